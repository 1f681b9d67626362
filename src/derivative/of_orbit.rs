//! Derivatives of an orbit by numbers of its scene (theory 21): the loop, its rates, and central differences of what is measured of the loops
//! beside it, with the reasons where there are none.

use crate::derivative::adaptive_differences::{AdaptiveDifferences, ScaledBlock};
use crate::derivative::loop_rates::Loop;
use crate::derivative::measured::{ExtremeQuantity, Mark, MeasurementLayout, marks, measured};
use crate::derivative::multipliers::Multipliers;
use crate::derivative::numbers::Numbers;
use crate::derivative::rates::OrbitDerivatives;
use crate::derivative::refusal::{refusal, singular};
use crate::derivative::stencil::{DifferenceOrder, DifferenceQuotient, Stencil, StencilNode};
use crate::error::{Error, Result};
use crate::hybrid::chatter_map::NO_REST;
use crate::model::{Parameter, Scene, System};
use crate::orbit::PeriodicOrbit;
use crate::quantity::finite;
use crate::tolerance::{
    DEVIATION_NOISE_UNIT, FIRST_CHATTER_STEP, LOOP_VALUE_NOISE, SAME_EXTREME_RATE, STEP_REFINEMENT,
};
use nalgebra::{Complex, DMatrix};

/// Why an orbit next to one with other accumulating impacts has no derivative.
const CHATTER_BORDER: &str =
    "beside the motion impacts that accumulate are others, or come to no rest: one-sided only";
/// Why there is none where no step is short enough.
const NOT_SMOOTH: &str = "the motion does not change smoothly with it";
/// Steps that are tried for one number. [work]
const MOST_STEP_LENGTHS: usize = 4;

/// The derivatives of an orbit by numbers of its scene: those of the orbits of the same pattern in scenes nearby.
///
/// # Errors
/// A number that the scene does not have, or that its stops do not share; the phase, which shifts time alone; what the functions of a
/// nonlinear scene report.
///
/// # References
/// Theory section 21.
///
/// # Examples
/// ```
/// use vibroimpact::{OrbitOptions, Parameter, Pattern, derivatives, periodic_orbits};
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{Harmonic, LinearSystem, Scene, Stop};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![8.5.into()], 2.4, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
/// let orbits = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default())?;
/// let orbit = &orbits[0];
/// let found = derivatives(orbit, &[Parameter::ForcingScale, Parameter::CLEARANCE])?;
/// // Twice the force and twice the clearance are twice the motion.
/// let speed = found.speeds_before[(0, 0)] + found.speeds_before[(0, 1)];
/// assert!((speed / orbit.impacts()[0].approach - 1.0).abs() < 1e-9);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn derivatives(orbit: &PeriodicOrbit, parameters: &[Parameter]) -> Result<OrbitDerivatives> {
    let scene = orbit.scene();
    let farthest = orbit.max_displacement()?.into_iter().fold(0.0, f64::max);
    let mut numbers = Numbers::new(scene, parameters, farthest)?;
    let mut flights = orbit.flights().iter();
    if flights.any(|flight| flight.accumulation().is_some()) {
        numbers = numbers.accumulating();
    }
    let make = |i: usize, offset: f64| numbers.scene(i, offset);
    by_numbers(orbit, scene, (&make, &numbers.sizes), true)
}

/// The same over scenes of any kind, one for each list of d numbers; the orbit is that of the scene of `start`, but for its phase.
///
/// # Errors
/// A scene of `start` in which the orbit does not close; numbers about it that are refused both above and below; what `make` says.
pub fn derivatives_of(
    orbit: &PeriodicOrbit,
    make: &dyn Fn(&[f64]) -> Result<Scene>,
    start: &[f64],
) -> Result<OrbitDerivatives> {
    by_list(orbit, make, start, true)
}

/// The same without multipliers, which take half of the time and are not numbers here: what most optimisers need.
///
/// # Errors
/// As [`derivatives_of`].
pub fn derivatives_but_multipliers(
    orbit: &PeriodicOrbit,
    make: &dyn Fn(&[f64]) -> Result<Scene>,
    start: &[f64],
) -> Result<OrbitDerivatives> {
    by_list(orbit, make, start, false)
}

fn by_list(
    orbit: &PeriodicOrbit,
    make: &dyn Fn(&[f64]) -> Result<Scene>,
    start: &[f64],
    has_multipliers: bool,
) -> Result<OrbitDerivatives> {
    for &value in start {
        finite("start", value)?;
    }
    let scene = make(start)?;
    let beside = |i: usize, offset: f64| {
        let mut p = start.to_vec();
        p[i] += offset;
        make(&p)
    };
    let sizes: Vec<f64> = start.iter().map(|value| value.abs()).collect();
    by_numbers(orbit, &scene, (&beside, &sizes), has_multipliers)
}

/// The derivatives by one number.
struct Column {
    measured: Vec<f64>,
    min_gap: Vec<f64>,
    max_displacement: Vec<f64>,
    multipliers: Vec<Complex<f64>>,
}

/// The loops beside an orbit, compared with its own.
enum Beside {
    /// They have as many impacts.
    Alike(Stencil, DifferenceQuotient),
    Other,
    /// The equations of the loop are singular.
    Singular,
}

/// An orbit that is to be differentiated.
struct DifferentiationProblem<'a> {
    own: &'a Loop,
    layout: MeasurementLayout,
    stops: usize,
    marks: &'a [Mark],
    floquet: &'a Multipliers,
}

impl DifferentiationProblem<'_> {
    /// The derivatives by a number of a size, of which `make` makes scenes; `None`, with the reason, where there are none.
    fn column(
        &self,
        make: &dyn Fn(f64) -> Result<Scene>,
        size: f64,
        reasons: &mut Vec<String>,
    ) -> Result<Option<Column>> {
        let mut part = match self.own.step.1 {
            DifferenceOrder::Second => 1.0,
            DifferenceOrder::Fourth => FIRST_CHATTER_STEP,
        };
        let mut differences = AdaptiveDifferences::new(self.blocks(), LOOP_VALUE_NOISE);
        let mut is_alike = false;
        for _ in 0..MOST_STEP_LENGTHS {
            match self.by_steps(make, (size, part), reasons) {
                Ok(Beside::Alike(stencil, found)) => {
                    is_alike = true;
                    differences.take(&stencil, &found);
                    if differences.is_complete() {
                        break;
                    }
                }
                Ok(Beside::Singular) => return Ok(None),
                Ok(Beside::Other) => {}
                Err(error) if has_no_rest(&error) => {}
                Err(error) => return Err(error),
            }
            part *= STEP_REFINEMENT;
        }
        let Some(mut measured) = differences.derivative() else {
            reasons.push(if is_alike { NOT_SMOOTH } else { CHATTER_BORDER }.to_owned());
            return Ok(None);
        };
        let deviations = measured.split_off(self.count());
        let mut extreme = |quantity: ExtremeQuantity| {
            self.extreme(quantity, &measured).unwrap_or_else(|| {
                reasons.push(format!("{quantity} at several times: one-sided only"));
                f64::NAN
            })
        };
        Ok(Some(Column {
            min_gap: (0..self.stops)
                .map(|j| extreme(ExtremeQuantity::Gap(j)))
                .collect(),
            max_displacement: (0..self.layout.n)
                .map(|i| extreme(ExtremeQuantity::Coordinate(i)))
                .collect(),
            multipliers: self.floquet.derivatives(self.own, &deviations),
            measured,
        }))
    }

    /// How many numbers are measured, but for the multipliers.
    fn count(&self) -> usize {
        self.layout.marks() + self.marks.len()
    }

    /// The blocks of the measured numbers, with their units.
    fn blocks(&self) -> Vec<ScaledBlock> {
        let (layout, units) = (self.layout, &self.own.units);
        let mut all = vec![
            (layout.q0().len(), units.position),
            (layout.v0().len(), units.velocity),
            (layout.phase().len(), 1.0),
            (layout.period().len(), units.time),
            (layout.times().len(), units.time),
        ];
        // The speeds of impacts that accumulate become small, and the last change by less than a short step tells.
        all.extend(layout.speeds().map(|_| (1, units.velocity)));
        all.extend(self.marks.iter().map(|_| (1, units.position)));
        all.push((self.floquet.n_measured(self.own), DEVIATION_NOISE_UNIT));
        all
    }

    /// Differences of the measured numbers, by steps that are `part` of the usual ones.
    fn by_steps(
        &self,
        make: &dyn Fn(f64) -> Result<Scene>,
        (size, part): (f64, f64),
        reasons: &mut Vec<String>,
    ) -> Result<Beside> {
        let rates = self.own.rates(make, size, part)?;
        if let Some(reason) = singular(self.own, &rates.of_equations) {
            reasons.push(reason.to_owned());
            return Ok(Beside::Singular);
        }
        let (count, more) = (self.count(), self.floquet.n_measured(self.own));
        let there = |node: &StencilNode| {
            let state = self.own.moved(&rates.state, node);
            self.own.in_scene(&node.scene, |shooting, units| {
                let equations = (shooting, units);
                let mut all = measured(equations, &node.scene, &state, self.marks)?;
                if all.len() == count && more > 0 {
                    all.extend(Multipliers::measured(equations, &state)?);
                }
                Ok(all)
            })
        };
        let found = rates.stencil.differences(there)?;
        let found = found.filter(|found| found.derivative.len() == count + more);
        Ok(found.map_or(Beside::Other, |found| Beside::Alike(rates.stencil, found)))
    }

    /// The derivative of an extreme: that of the value where it is, zero where it is that of a contact; `None` where it is reached at
    /// several times, whose values change apart from each other.
    fn extreme(&self, quantity: ExtremeQuantity, measured: &[f64]) -> Option<f64> {
        let at_marks = &measured[self.layout.marks()..];
        let all = self.marks.iter().zip(at_marks);
        let mut values = all.filter(|((own, _), _)| *own == quantity);
        let first = values.next().map_or(0.0, |(_, value)| *value);
        let positions = &measured[..self.layout.n];
        let sizes = positions.iter().chain(at_marks).map(|x| x.abs());
        let tolerance = SAME_EXTREME_RATE * sizes.fold(0.0, f64::max);
        let is_one = values.all(|(_, value)| (value - first).abs() <= tolerance);
        is_one.then_some(first)
    }
}

/// Whether an error says that impacts do not accumulate.
fn has_no_rest(error: &Error) -> bool {
    matches!(error, Error::NoConvergence { stage, .. } if *stage == NO_REST)
}

/// A row for each number of an attribute, a column for each derivative.
fn assembled<T: nalgebra::Scalar + Copy>(
    columns: &[Option<Column>],
    (count, nan): (usize, T),
    of: impl Fn(&Column) -> &[T],
) -> DMatrix<T> {
    DMatrix::from_fn(count, columns.len(), |j, i| {
        let numbers = columns[i].as_ref().map(&of);
        numbers.and_then(|x| x.get(j)).copied().unwrap_or(nan)
    })
}

/// Why deviations along an orbit of equations of one's own have no derivatives, if its multipliers have found a reason.
fn roughness(orbit: &PeriodicOrbit) -> Result<Option<String>> {
    if !matches!(orbit.scene().system(), System::Nonlinear(_)) {
        return Ok(None);
    }
    let known = orbit.stability()?;
    Ok((known.orders.is_empty()).then(|| known.reason.clone()))
}

/// The derivatives by numbers of some sizes, of which `make` makes a scene where one of them is off by so much.
fn by_numbers(
    orbit: &PeriodicOrbit,
    scene: &Scene,
    (make, sizes): (&dyn Fn(usize, f64) -> Result<Scene>, &[f64]),
    has_multipliers: bool,
) -> Result<OrbitDerivatives> {
    let extremes = orbit.extremes()?;
    let (n, k) = (orbit.scene().n_dof(), orbit.impacts().len());
    let (layout, stops) = (MeasurementLayout { n, k }, extremes.gaps.len());
    let (mut reasons, own) = match Loop::new(scene, orbit) {
        Err(error) if has_no_rest(&error) => (vec![CHATTER_BORDER.to_owned()], None),
        own => {
            let own = own?;
            let reason = match refusal(&own, extremes)? {
                None => roughness(orbit)?,
                reason => reason,
            };
            (Vec::from_iter(reason), Some(own))
        }
    };
    let regular = own.filter(|_| reasons.is_empty());
    let columns: Vec<Option<Column>> = if let Some(own) = &regular {
        let floquet = &if has_multipliers {
            Multipliers::new(own, orbit)?
        } else {
            Multipliers::default()
        };
        reasons.extend(floquet.reason().map(str::to_owned));
        let marks = &marks(extremes);
        let problem = DifferentiationProblem {
            own,
            layout,
            stops,
            marks,
            floquet,
        };
        let each = sizes.iter().enumerate();
        let column = |(i, &size): (usize, &f64)| {
            problem.column(&|offset| make(i, offset), size, &mut reasons)
        };
        each.map(column).collect::<Result<_>>()?
    } else {
        sizes.iter().map(|_| None).collect()
    };
    let mut said: Vec<String> = Vec::new();
    for reason in reasons {
        if !said.contains(&reason) {
            said.push(reason);
        }
    }
    let of = |range: std::ops::Range<usize>| {
        let nan = (range.len(), f64::NAN);
        assembled(&columns, nan, |column| {
            column.measured.get(range.clone()).unwrap_or(&[])
        })
    };
    let nan = Complex::new(f64::NAN, f64::NAN);
    Ok(OrbitDerivatives {
        q0: of(layout.q0()),
        v0: of(layout.v0()),
        phase: of(layout.phase()).row(0).transpose(),
        period: of(layout.period()).row(0).transpose(),
        times: of(layout.times()),
        speeds_before: of(layout.speeds()),
        multipliers: assembled(&columns, (2 * n, nan), |column| &column.multipliers),
        min_gap: assembled(&columns, (stops, f64::NAN), |column| &column.min_gap),
        max_displacement: assembled(&columns, (n, f64::NAN), |column| &column.max_displacement),
        reason: said.join("; "),
    })
}
