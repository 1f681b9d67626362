//! An orbit as a closed loop, and how the loop changes with a number of its scene: `G_Z dZ = -G_p`, phases held (theory 21).

use crate::branch::{check_same, stretched};
use crate::derivative::stencil::{DifferenceOrder, Stencil, StencilNode};
use crate::error::{Error, Result, digits};
use crate::hybrid::ScaledUnits;
use crate::linalg::singular::Singular;
use crate::model::Scene;
use crate::orbit::{
    Guess, Linearised, PeriodicOrbit, Shooting, ShootingState, Signature, begun, with_phase,
    with_shooting,
};
use crate::root::{Bracket, bisected};
use crate::tolerance::{
    DERIVATIVE_STEP_CHATTER, DERIVATIVE_STEP_EXACT, DERIVATIVE_STEP_INTEGRATED, LEAST_STEP_EFFECT,
    ORBIT_OF_ANOTHER_SCENE, SAME_STEP_SCALE,
};
use nalgebra::{DMatrix, DVector};

/// Bound on the logarithm of the factor that is sought for the depth to which accumulating impacts are gone through. [work]
const MOST_DEPTH_LOGARITHM: f64 = 10.0;
/// The part of the range of that logarithm to which one is found. [work]
const DEPTH_RESOLUTION: f64 = 1.0 / 4096.0;
/// Rounds in which rows and columns are balanced. [work]
const BALANCING_ROUNDS: usize = 2;
/// Scales of a number that are tried. [work]
const MOST_STEP_SCALES: usize = 3;

/// A closed loop in its scene, with its equations.
pub(super) struct Loop {
    pub scene: Scene,
    pub signature: Signature,
    pub state: ShootingState,
    pub units: ScaledUnits,
    /// Number of equations, and of unknowns.
    pub shape: (usize, usize),
    linear: Linearised,
    /// The singular values of the balanced equations.
    singular: Singular,
    balance: Balance,
    pub step: (f64, DifferenceOrder),
}

/// How a loop changes with a number, and the scenes beside it in which what depends on it is to be compared.
pub(super) struct LoopRates {
    pub state: ShootingState,
    pub stencil: Stencil,
    /// The rates of the scaled residuals of the loop with the number, the loop held, shape (equations,), [-] per unit of the number.
    pub of_equations: DVector<f64>,
}

/// Lengths of rows and columns, in parts of which those of a matrix are of one size: an impact of little speed is as good as another.
struct Balance {
    rows: DVector<f64>,
    columns: DVector<f64>,
}

impl Balance {
    /// Balances a matrix.
    fn of(matrix: &mut DMatrix<f64>) -> Self {
        let (m, n) = matrix.shape();
        let mut lengths = Self {
            rows: DVector::from_element(m, 1.0),
            columns: DVector::from_element(n, 1.0),
        };
        let or_one = |x: f64| if x > 0.0 { x } else { 1.0 };
        for _ in 0..BALANCING_ROUNDS {
            for (mut row, length) in matrix.row_iter_mut().zip(lengths.rows.iter_mut()) {
                let own = or_one(row.norm());
                row /= own;
                *length *= own;
            }
            for (mut column, length) in matrix.column_iter_mut().zip(lengths.columns.iter_mut()) {
                let own = or_one(column.norm());
                column /= own;
                *length *= own;
            }
        }
        lengths
    }
}

/// The factor on the unit of length, a part of which ends the list of accumulating impacts, for which a loop has `count` flights: in the
/// middle of all such factors, so that loops beside it have as many.
fn depth(
    shooting: &Shooting<'_>,
    state: &ShootingState,
    units: &ScaledUnits,
    count: usize,
) -> Result<f64> {
    let flights = |factor: f64| -> Result<usize> {
        let position = units.position * factor;
        let units = ScaledUnits { position, ..*units };
        let ends = shooting.flight_ends(state, &units)?;
        Ok(state.arcs(shooting.stages, &ends, shooting.motion)?.len())
    };
    // The largest logarithm of a factor for which there are `count` flights or more.
    let largest = |count: usize| -> Result<f64> {
        let all = Bracket::new([-MOST_DEPTH_LOGARITHM, MOST_DEPTH_LOGARITHM]);
        let is_before = |logarithm: f64| -> Result<bool> { Ok(flights(logarithm.exp())? >= count) };
        Ok(bisected(all, DEPTH_RESOLUTION * all.length(), is_before)?.middle())
    };
    Ok((0.5 * (largest(count)? + largest(count + 1)?)).exp())
}

/// The step for the motions of a scene, and the order of their differences.
fn step(scene: &Scene, signature: &Signature) -> (f64, DifferenceOrder) {
    if signature.stages.accumulates() {
        (DERIVATIVE_STEP_CHATTER, DifferenceOrder::Fourth)
    } else if scene.linear_system("derivatives").is_ok() {
        (DERIVATIVE_STEP_EXACT, DifferenceOrder::Second)
    } else {
        (DERIVATIVE_STEP_INTEGRATED, DifferenceOrder::Second)
    }
}

impl Loop {
    /// The loop of an orbit in a scene that is its own but for the phase.
    pub fn new(scene: &Scene, orbit: &PeriodicOrbit) -> Result<Self> {
        let (scene, signature, state) = begun(scene, Guess::Orbit(orbit), None)?;
        let (units, linear) = with_shooting(&scene, &signature, |shooting, _| {
            let mut units = shooting.units(&state)?;
            if signature.stages.accumulates() {
                units.position *= depth(shooting, &state, &units, orbit.flights().len())?;
            }
            Ok((units, shooting.linearised(&state, &units)?))
        })?;
        if linear.mismatch > ORBIT_OF_ANOTHER_SCENE {
            let rule = format!(
                "it must be the scene of the orbit, which does not close in it (by {})",
                digits(linear.mismatch)
            );
            return Err(Error::bad_value("start", "of another scene", rule));
        }
        let mut rows = linear.rows.clone();
        let balance = Balance::of(&mut rows);
        Ok(Self {
            step: step(&scene, &signature),
            scene,
            signature,
            state,
            units,
            shape: rows.shape(),
            balance,
            singular: Singular::new(&rows)?,
            linear,
        })
    }

    /// The singular values of the equations, the smallest first, each with its number.
    pub fn singular_values(&self) -> Vec<(f64, usize)> {
        let count = self.shape.1;
        let mut all: Vec<_> = (0..count).map(|k| (self.singular.value(k), k)).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    }

    /// The part of the equations along the left vector of a singular value.
    pub fn left_part(&self, k: usize, equations: &DVector<f64>) -> f64 {
        self.part(k, equations) * self.singular.value(k)
    }

    /// The part of a solution along the right vector of a singular value.
    fn part(&self, k: usize, equations: &DVector<f64>) -> f64 {
        let balanced = equations.component_div(&self.balance.rows);
        self.singular.part(k, &balanced)
    }

    /// Does some work with the equations in a scene.
    pub fn in_scene<T>(
        &self,
        scene: &Scene,
        work: impl FnOnce(&Shooting<'_>, &ScaledUnits) -> Result<T>,
    ) -> Result<T> {
        let stretch = match (self.scene.frequency(), scene.frequency()) {
            (Some(own), Some(there)) => own / there,
            _ => 1.0,
        };
        let units = ScaledUnits {
            time: self.units.time * stretch,
            ..self.units
        };
        with_shooting(scene, &self.signature, |shooting, _| work(shooting, &units))
    }

    /// The scene that is made of an offset, from the phase of the loop on.
    fn made(&self, make: &dyn Fn(f64) -> Result<Scene>, offset: f64) -> Result<Scene> {
        let scene = make(offset)?;
        check_same(&self.scene, &scene, offset)?;
        with_phase(&scene, self.scene.phase(), self.signature.depends_on_time)
    }

    /// How the loop changes with a number: `make` makes a scene of an offset from its value, which is of a size; by steps that are a part of
    /// the usual ones.
    pub fn rates(
        &self,
        make: &dyn Fn(f64) -> Result<Scene>,
        size: f64,
        part: f64,
    ) -> Result<LoopRates> {
        let (step, order) = self.step;
        let step = part * step;
        let make = |offset: f64| self.made(make, offset);
        let unit = if size == 0.0 { 1.0 } else { size };
        let mut scale = unit;
        let mut stencil = Stencil::new(&make, step * scale, order)?;
        let mut lacking = self.lacking(&stencil)?;
        for _ in 1..MOST_STEP_SCALES {
            let felt = lacking.rows(0, self.shape.0).amax() * scale;
            let is_unfelt = felt < LEAST_STEP_EFFECT && scale < 1.0;
            if !(is_unfelt || felt > SAME_STEP_SCALE) {
                break;
            }
            scale = (scale / felt).min(unit.max(1.0));
            stencil = Stencil::new(&make, step * scale, order)?;
            lacking = self.lacking(&stencil)?;
        }
        let of_equations = lacking.rows(0, self.shape.0).into_owned();
        let none = DVector::zeros(self.shape.1);
        let along = |k: usize| self.singular.right(k) * self.part(k, &of_equations);
        let balanced = (0..none.len()).fold(none.clone(), |xi, k| xi + along(k));
        let xi = balanced.component_div(&self.balance.columns);
        // Where a small change of the number is a large one of the motion a smaller step is as good.
        if xi.amax() * scale > SAME_STEP_SCALE {
            let closer = (step / xi.amax()).max(f64::EPSILON * size / step);
            stencil = Stencil::new(&make, closer, order)?;
        }
        let none = self.linear.corrections(&none);
        let mut state = self.linear.corrections(&xi);
        let mut rest = lacking.iter().skip(self.shape.0);
        let parts = state.states.iter_mut().zip(&none.states);
        let states = parts.flat_map(|(x, none)| x.iter_mut().zip(none.iter()));
        let times = state.times.iter_mut().zip(&none.times);
        let starts = state.starts.iter_mut().zip(&none.starts);
        for ((own, none), rate) in states.chain(times).chain(starts).zip(&mut rest) {
            *own += rate - none;
        }
        Ok(LoopRates {
            state,
            stencil,
            of_equations,
        })
    }

    /// Derivatives of the residuals of the loop, and of the states, times and starts of its flights, by the number of a stencil, with the
    /// phases of all instants held.
    fn lacking(&self, stencil: &Stencil) -> Result<DVector<f64>> {
        let there = |node: &StencilNode| {
            let state = stretched(&self.state, &self.scene, &node.scene);
            let lacking = self.in_scene(&node.scene, |shooting, units| {
                shooting.lacking(&state, units, &self.linear)
            })?;
            let open = lacking.corrections(&DVector::zeros(0));
            let states = open.states.iter().flat_map(|x| x.iter().copied());
            let right = lacking.right.iter().copied();
            let all = right.chain(states).chain(open.times).chain(open.starts);
            Ok(all.collect())
        };
        let found = stencil.derivative(there)?;
        Ok(DVector::from_vec(found.expect("as many equations at each")))
    }

    /// The loop that it becomes at a node, to first order.
    pub fn moved(&self, rates: &ShootingState, node: &StencilNode) -> ShootingState {
        let moved = self.state.moved(rates, node.offset);
        stretched(&moved, &self.scene, &node.scene)
    }
}
