//! The equations `G(Z, p) = 0` of a closed loop Z at a value p of the parameter, linearised: `G_Z` exactly, the column `G_p` by central
//! differences (theory 19). Rows and unknowns are scaled, in units of the motion.

use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::{BranchProblem, check_same, stretched};
use crate::continuation::bordered;
use crate::error::{Error, Result};
use crate::hybrid::ScaledUnits;
use crate::linalg::determinant::{Determinant, signed_volume};
use crate::linalg::rank;
use crate::model::Scene;
use crate::orbit::{
    Linearised, LinearisedPulses, OrbitOf, PeriodicOrbit, Shooting, ShootingState, with_shooting,
};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// The linearised equations at a loop: `rows xi + column pi = right`, xi the correction of its scaled unknowns, pi that of the parameter in
/// parts of its range.
#[derive(Clone)]
pub(super) struct Equations {
    /// The Jacobian by the unknowns of the loop, shape `(n_equations, n_unknowns)`, \[-\].
    pub rows: DMatrix<f64>,
    pub by_value: ParameterDerivative,
    /// Minus the residual, shape `(n_equations,)`, \[-\].
    pub right: DVector<f64>,
    /// How far the loop is from closing, in parts of the motion's size \[-\].
    pub mismatch: f64,
    scene: Arc<Scene>,
    /// `None` for a loop whose unknowns are its impulses.
    linear: Option<Linearised>,
}

/// The point that a step begins from: its loop, the equations there, and the tangent of the branch.
pub(super) type BasePoint<'a> = (&'a ParametricLoop, &'a Equations, &'a BranchDirection);

/// Derivatives by pi, the parameter in parts of its range.
#[derive(Clone, Default)]
pub(super) struct ParameterDerivative {
    /// Of the residual, shape `(n_equations,)`, \[-\].
    pub column: DVector<f64>,
    /// Of the states and of the starts of the flights; empty for a loop whose unknowns are its impulses.
    pub flights: ShootingState,
}

impl Equations {
    /// The test function of branch points: it changes its sign where another branch is crossed, along the tangent of this one.
    pub fn crossing(&self, tangent: &BranchDirection) -> f64 {
        signed_volume(bordered(self, tangent))
    }

    /// The Jacobian `[G_Z G_p]`, the column of the parameter last.
    pub fn all_columns(&self) -> DMatrix<f64> {
        let last = self.rows.ncols();
        let mut matrix = self.rows.clone().insert_column(last, 0.0);
        matrix.set_column(last, &self.by_value.column);
        matrix
    }
}

impl BranchProblem<'_> {
    /// The equations at a loop.
    pub fn equations(&self, place: &ParametricLoop) -> Result<Equations> {
        let equations = self.equations_nearby(place, &ParameterDerivative::default())?;
        self.renewed(place, equations)
    }

    /// The equations with the derivatives by the parameter of a loop nearby, which saves their differences: corrections converge a little
    /// slower, to the same solution.
    pub fn equations_nearby(
        &self,
        place: &ParametricLoop,
        by_value: &ParameterDerivative,
    ) -> Result<Equations> {
        let scene = self.scene(place.value)?;
        let by_value = by_value.clone();
        // The mismatch is relative to the motion's size where that has outgrown the units.
        let grown = self.size(&place.state).max(1.0);
        if self.has_pulses {
            let LinearisedPulses {
                rows,
                right,
                mismatch,
            } = self.pulse_equations(&scene, place);
            return Ok(Equations {
                rows,
                by_value,
                right,
                mismatch: mismatch / grown,
                scene,
                linear: None,
            });
        }
        let (state, units) = (&place.state, &self.units_in(&scene));
        let linear = with_shooting(&scene, &self.signature, |shooting, _| {
            shooting.linearised(state, units)
        })?;
        let (rows, right) = self.with_energy(place, &linear)?;
        Ok(Equations {
            rows,
            by_value,
            right,
            mismatch: linear.mismatch / grown,
            scene,
            linear: Some(linear),
        })
    }

    /// The equations with the derivatives by the parameter taken at the loop itself.
    pub fn renewed(&self, place: &ParametricLoop, equations: Equations) -> Result<Equations> {
        let by_value = match &equations.linear {
            Some(linear) => self.by_value(place, &equations.scene, linear)?,
            None => self.pulses_by_value(place, &equations.scene)?,
        };
        Ok(Equations {
            by_value,
            ..equations
        })
    }

    /// The equations of a loop taken for those of one next to it.
    pub fn equations_at(&self, place: &ParametricLoop, equations: Equations) -> Result<Equations> {
        Ok(Equations {
            scene: self.scene(place.value)?,
            ..equations
        })
    }

    /// Gives the shooting problem at a loop to a function, and returns what that makes of it.
    fn shooting_at<T>(
        &self,
        place: &ParametricLoop,
        work: impl FnOnce(&Shooting<'_>, OrbitOf<'_>, &ScaledUnits) -> Result<T>,
    ) -> Result<T> {
        let scene = self.scene(place.value)?;
        let units = &self.units_in(&scene);
        with_shooting(&scene, &self.signature, |shooting, orbit| {
            work(shooting, orbit, units)
        })
    }

    /// The speed at which the stop of an instant is approached, of the first stop if several are hit.
    pub fn approach(&self, place: &ParametricLoop, instant: usize) -> Result<f64> {
        Ok(self.approaches(place)?[instant])
    }

    /// The speeds of approach at all instants; NaN where nothing is hit.
    pub fn approaches(&self, place: &ParametricLoop) -> Result<Vec<f64>> {
        if self.has_pulses {
            let (pulses, train) = place.train();
            return Ok(pulses.approaches(&train));
        }
        let state = &place.state;
        let count = state.states.len();
        self.shooting_at(place, |shooting, _, units| {
            let ends = shooting.flight_ends(state, units)?;
            let speed = |instant: usize| {
                let Some(stop) = self.signature.stages.impact(instant) else {
                    return Ok(f64::NAN);
                };
                let flight = (instant + count - 1) % count;
                let before = &ends[flight].before;
                let n = before.len() / 2;
                let at = shooting.motion.gap(stop, state.times[flight + 1], before)?;
                Ok(-at.speed(before.rows(n, n)))
            };
            (0..count).map(speed).collect()
        })
    }

    /// The gap of a stop at an instant, in units of the motion \[-\].
    pub fn gap_at(&self, place: &ParametricLoop, (stop, instant): (usize, usize)) -> Result<f64> {
        let (t, x) = (place.state.times[instant], &place.state.states[instant]);
        self.shooting_at(place, |shooting, _, units| {
            let at = shooting.motion.gap(stop, t, x)?;
            Ok(at.gap / (at.gradient.amax() * units.position))
        })
    }

    /// The acceleration with which the gap opens after an instant if the stop that is hit there lets the motion go.
    pub fn opening(&self, place: &ParametricLoop, instant: usize) -> Result<f64> {
        let (t, state) = (place.state.times[instant], &place.state.states[instant]);
        let stages = &self.signature.stages;
        let Some(stop) = stages.impact(instant) else {
            return Ok(f64::NAN);
        };
        let others = stages[instant].regime.without(stop);
        self.shooting_at(place, |shooting, _, _| {
            let rate = shooting.motion.rate(&others, t, state)?;
            shooting.motion.gap_acceleration(stop, t, state, &rate)
        })
    }

    /// The eigenvector of a multiplier, as deviations of all states and times.
    pub fn deviation(&self, place: &ParametricLoop, multiplier: f64) -> Result<ShootingState> {
        if self.has_pulses {
            return self.pulse_deviation(place, multiplier);
        }
        let linear = self.linearised(place)?;
        let own = rank::weakest(&linear.returning(multiplier), 1)?;
        Ok(linear.deviations(&own.column(0).into_owned()))
    }

    /// The linearised equations of the loop, without the parameter.
    fn linearised(&self, place: &ParametricLoop) -> Result<Linearised> {
        self.shooting_at(place, |shooting, _, units| {
            shooting.linearised(&place.state, units)
        })
    }

    /// How far a loop is from closing \[-\].
    pub fn mismatch(&self, place: &ParametricLoop) -> Result<f64> {
        self.shooting_at(place, |shooting, _, units| {
            shooting.mismatch(&place.state, units)
        })
    }

    /// The same problem with the units of another loop for positions and velocities.
    pub fn in_units_of(&self, place: &ParametricLoop) -> Result<Self> {
        let units = self.shooting_at(place, |shooting, _, _| shooting.units(&place.state))?;
        let time = self.units.time;
        Ok(Self {
            units: ScaledUnits { time, ..units },
            ..self.clone()
        })
    }

    /// The test function of a multiplier: it changes its sign where one passes through a number, and nowhere else.
    pub fn multiplier_test(
        &self,
        at: (&ParametricLoop, Option<&Equations>),
        multiplier: f64,
    ) -> Result<f64> {
        let own = self.multiplier_determinant(at, multiplier)?;
        Ok(own.in_parts_of(own.lengths))
    }

    /// A smooth determinant that is zero where a number is a multiplier; it takes the equations at the loop where they are known.
    pub fn multiplier_determinant(
        &self,
        (place, equations): (&ParametricLoop, Option<&Equations>),
        multiplier: f64,
    ) -> Result<Determinant> {
        let known = equations.and_then(|own| own.linear.as_ref());
        Ok(Determinant::of(if self.has_pulses {
            self.pulse_variational(place, multiplier)
        } else if let Some(linear) = known {
            linear.returning(multiplier)
        } else {
            self.linearised(place)?.returning(multiplier)
        }))
    }

    /// The orbit of a closed loop.
    ///
    /// # Errors
    /// For a loop of half a period, a scene that is no longer odd; what the motion reports.
    pub fn orbit(&self, place: &ParametricLoop) -> Result<PeriodicOrbit> {
        if self.signature.images.is_some() {
            let scene = self.scene(place.value)?;
            if self.images_in(&scene, place)? != self.signature.images {
                let rule = "the scene must stay odd, which the orbits' symmetry q(t + T/2) = -q(t) asks for";
                return Err(Error::bad_value("parameter", place.value, rule));
            }
            let (problem, place) = self.whole(place)?;
            return problem.orbit(&place);
        }
        if self.has_pulses {
            return self.orbit_of_pulses(place);
        }
        let state = &place.state;
        self.shooting_at(place, |shooting, orbit, units| {
            orbit(state, &shooting.flight_ends(state, units)?)
        })
    }

    /// The orbit of a closed loop, checked by another route: it has to close when it is flown once more, a half motion for the whole
    /// period, a loop of impulses by its flights.
    ///
    /// # Errors
    /// As [`orbit`](Self::orbit); a motion that does not close.
    pub fn closed_orbit(&self, place: &ParametricLoop) -> Result<PeriodicOrbit> {
        let orbit = self.orbit(place)?;
        match orbit.closure_defect([self.units.position, self.units.velocity])? {
            None => Ok(orbit),
            Some(residual) => Err(Error::NoConvergence {
                stage: "the motion, followed once more by another route,",
                iterations: 0,
                residual,
            }),
        }
    }

    /// Derivatives of the residual and of the states by the parameter in parts of its range: central differences, instants held at their
    /// phases; one-sided where the parameter may go no further.
    fn by_value(
        &self,
        place: &ParametricLoop,
        scene: &Scene,
        here: &Linearised,
    ) -> Result<ParameterDerivative> {
        let none = DVector::zeros(here.rows.ncols());
        if self.energetics.is_some() {
            return Ok(ParameterDerivative {
                column: DVector::zeros(here.rows.nrows()).push(-1.0),
                flights: here.deviations(&none),
            });
        }
        let lacking = |value: f64| -> Result<Linearised> {
            let there = self.scene(value)?;
            check_same(scene, &there, value)?;
            let state = &stretched(&place.state, scene, &there);
            let units = &self.units_in(&there);
            with_shooting(&there, &self.signature, |shooting, _| {
                shooting.lacking(state, units, here)
            })
        };
        // Corrections without unknowns.
        let open = |linear: &Linearised| {
            let none = DVector::zeros(linear.rows.ncols());
            (linear.right.clone(), linear.corrections(&none))
        };
        let at = |value: f64| lacking(value).map(|linear| open(&linear));
        let [(high, one), (low, other)] = self.beside(place.value, &at, || Ok(open(here)))?;
        let factor = self.span() / (high - low);
        let rate = |a: &[f64], b: &[f64]| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| (a - b) * factor).collect()
        };
        let ((right, one), (left, other)) = (one, other);
        let states = one.states.iter().zip(&other.states);
        Ok(ParameterDerivative {
            column: (right - left) * -factor,
            flights: ShootingState {
                times: rate(&one.times, &other.times),
                starts: rate(&one.starts, &other.starts),
                states: states.map(|(a, b)| (a - b) * factor).collect(),
            },
        })
    }

    /// A function at both ends of a difference about a value, with the ends; at the value itself in place of an end that the scene refuses.
    pub fn beside<T>(
        &self,
        value: f64,
        at: &dyn Fn(f64) -> Result<T>,
        here: impl FnOnce() -> Result<T>,
    ) -> Result<[(f64, T); 2]> {
        let step = self.difference(value);
        let (above, below) = (value + step, value - step);
        let is_refused = |found: &Result<T>| matches!(found, Err(Error::BadValue { .. }));
        Ok(match (at(above), at(below)) {
            (Ok(upper), lower) if is_refused(&lower) => [(above, upper), (value, here()?)],
            (upper, Ok(lower)) if is_refused(&upper) => [(value, here()?), (below, lower)],
            (upper, lower) => [(above, upper?), (below, lower?)],
        })
    }

    /// A loop moved with the parameter, its own unknowns held, to first order.
    pub fn moved_by_value(
        &self,
        place: &ParametricLoop,
        (equations, by_value): (&Equations, &ParameterDerivative),
        part: f64,
    ) -> Result<ParametricLoop> {
        let by = BranchDirection {
            loop_part: DVector::zeros(equations.rows.ncols()),
            value_part: part,
        };
        // A loop that was moved by another number belongs to another scene than the equations.
        let scene = &self.scene(place.value)?;
        let moved = |linear: &Linearised| linear.deviations(&own_part(linear, &by));
        self.moved_by((place, scene), (equations, by_value), (&by, &moved))
    }

    /// A loop corrected along a direction, to first order: its flights are joined.
    pub fn moved(
        &self,
        place: &ParametricLoop,
        equations: &Equations,
        by: &BranchDirection,
    ) -> Result<ParametricLoop> {
        let moved = |linear: &Linearised| linear.corrections(&own_part(linear, by));
        let own = (equations, &equations.by_value);
        self.moved_by((place, &equations.scene), own, (by, &moved))
    }

    /// A loop moved along a deviation, to first order: flights that are not joined stay so.
    pub fn deviated(
        &self,
        place: &ParametricLoop,
        equations: &Equations,
        by: &BranchDirection,
    ) -> Result<ParametricLoop> {
        let moved = |linear: &Linearised| linear.deviations(&own_part(linear, by));
        let own = (equations, &equations.by_value);
        self.moved_by((place, &equations.scene), own, (by, &moved))
    }

    fn moved_by(
        &self,
        (place, scene): (&ParametricLoop, &Scene),
        (equations, by_value): (&Equations, &ParameterDerivative),
        (by, moved): (&BranchDirection, &dyn Fn(&Linearised) -> ShootingState),
    ) -> Result<ParametricLoop> {
        let Some(linear) = &equations.linear else {
            return self.moved_pulses(place, scene, by);
        };
        let value = self.snapped(place.value + by.value_part * self.span());
        let there = self.scene(value)?;
        check_same(scene, &there, value)?;
        let closed = place.state.moved(&moved(linear), 1.0);
        let moved = closed.moved(&by_value.flights, by.value_part);
        self.place(&there, value, stretched(&moved, scene, &there))
    }
}

/// The part of a direction in the unknowns of the shooting problem, without that of the energy.
fn own_part(linear: &Linearised, by: &BranchDirection) -> DVector<f64> {
    by.loop_part.rows(0, linear.rows.ncols()).into_owned()
}
