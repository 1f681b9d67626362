//! The formulation of branches by shooting: the unknowns are the first state and the times of the instants, from which the flights follow
//! one after the other; the last has to end where the first begins (theory 19). Derivatives of the flights are exact, those by the
//! parameter central differences.

use crate::branch::equations::{BasePoint, Equations, ParameterDerivative};
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::{BranchProblem, check_same, stretched};
use crate::error::{Error, Result};
use crate::hybrid::ScaledUnits;
use crate::linalg::rank;
use crate::model::Scene;
use crate::orbit::{Linearised, OrbitOf, PeriodicOrbit, Shooting, ShootingState, with_shooting};
use nalgebra::DVector;
use std::sync::Arc;

impl BranchProblem<'_> {
    /// Gives the shooting problem at a loop to a function, and returns what that makes of it.
    pub fn shooting_at<T>(
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

    /// The equations of a loop: the conditions of its instants, and that its last flight ends where the first begins.
    pub fn shooting_equations(
        &self,
        place: &ParametricLoop,
        scene: Arc<Scene>,
    ) -> Result<Equations> {
        let (state, units) = (&place.state, &self.units_in(&scene));
        let flights = with_shooting(&scene, &self.signature, |shooting, _| {
            shooting.linearised(state, units)
        })?;
        let own = (
            flights.rows.clone(),
            flights.right.clone(),
            flights.mismatch,
        );
        Ok(Equations::closing(scene, own, Some(flights)))
    }

    /// Derivatives of the residual and of the states by the parameter in parts of its range: central differences, instants held at their
    /// phases; one-sided where the parameter may go no further.
    pub fn shooting_by_value(
        &self,
        place: &ParametricLoop,
        equations: &Equations,
    ) -> Result<ParameterDerivative> {
        let (scene, here) = (&equations.scene, equations.flights());
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

    /// A loop moved with the parameter, its own unknowns held, to first order.
    pub fn moved_by_value(
        &self,
        place: &ParametricLoop,
        (equations, by_value): (&Equations, &ParameterDerivative),
        part: f64,
    ) -> Result<ParametricLoop> {
        // A loop that was moved by another number belongs to another scene than the equations.
        let scene = &self.scene(place.value)?;
        let flights = equations.flights();
        let moved = flights.deviations(&DVector::zeros(flights.rows.ncols()));
        self.moved_flights((place, scene), &moved, (by_value, part))
    }

    /// A loop corrected along a direction, to first order: its flights are joined.
    pub fn joined_flights(&self, (place, equations, by): BasePoint<'_>) -> Result<ParametricLoop> {
        let flights = equations.flights();
        let moved = flights.corrections(&own_part(flights, by));
        let by_value = (&equations.by_value, by.value_part);
        self.moved_flights((place, &equations.scene), &moved, by_value)
    }

    /// A loop moved along a deviation, to first order: flights that are not joined stay so.
    pub fn deviated(&self, (place, equations, by): BasePoint<'_>) -> Result<ParametricLoop> {
        let flights = equations.flights();
        let moved = flights.deviations(&own_part(flights, by));
        let by_value = (&equations.by_value, by.value_part);
        self.moved_flights((place, &equations.scene), &moved, by_value)
    }

    /// A loop with its flights moved, and by a part of the derivatives by the parameter.
    fn moved_flights(
        &self,
        (place, scene): (&ParametricLoop, &Scene),
        by: &ShootingState,
        (by_value, part): (&ParameterDerivative, f64),
    ) -> Result<ParametricLoop> {
        let value = self.snapped(place.value + part * self.span());
        let there = self.scene(value)?;
        check_same(scene, &there, value)?;
        let closed = place.state.moved(by, 1.0);
        let moved = closed.moved(&by_value.flights, part);
        self.place(&there, value, stretched(&moved, scene, &there))
    }

    /// The speeds of approach at all instants, at the ends of their flights.
    pub fn approaches_of_flights(&self, place: &ParametricLoop) -> Result<Vec<f64>> {
        let state = &place.state;
        let count = state.states.len();
        self.shooting_at(place, |shooting, _, units| {
            let ends = shooting.flight_ends(state, units)?;
            let speed = |instant: usize| {
                let Some(stop) = self.signature.stages.reached(instant) else {
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
        let Some(stop) = stages.reached(instant) else {
            return Ok(f64::NAN);
        };
        let others = stages[instant].regime.without(stop);
        self.shooting_at(place, |shooting, _, _| {
            let rate = shooting.motion.rate(&others, t, state)?;
            shooting.motion.gap_acceleration(stop, t, state, &rate)
        })
    }

    /// The eigenvector of a multiplier, as deviations of all states and times.
    pub fn flight_deviation(
        &self,
        place: &ParametricLoop,
        multiplier: f64,
    ) -> Result<ShootingState> {
        let linear = self.linearised(place)?;
        let own = rank::weakest(&linear.returning(multiplier), 1)?;
        Ok(linear.deviations(&own.column(0).into_owned()))
    }

    /// The linearised equations of the loop, without the parameter.
    pub fn linearised(&self, place: &ParametricLoop) -> Result<Linearised> {
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

    /// The orbit of a closed loop by its flights.
    ///
    /// # Errors
    /// For a loop of half a period, a scene that is no longer odd; what the motion reports.
    pub fn orbit_of_flights(&self, place: &ParametricLoop) -> Result<PeriodicOrbit> {
        if self.signature.images.is_some() {
            let scene = self.scene(place.value)?;
            if self.images_in(&scene, place)? != self.signature.images {
                let rule = "the scene must stay odd, which the orbits' symmetry q(t + T/2) = -q(t) asks for";
                return Err(Error::bad_value("parameter", place.value, rule));
            }
            let (problem, place) = self.whole(place)?;
            return problem.orbit_of_flights(&place);
        }
        let state = &place.state;
        self.shooting_at(place, |shooting, orbit, units| {
            orbit(state, &shooting.flight_ends(state, units)?)
        })
    }
}

/// The part of a direction in the unknowns of the shooting problem, without that of the energy.
fn own_part(linear: &Linearised, by: &BranchDirection) -> DVector<f64> {
    by.loop_part.rows(0, linear.rows.ncols()).into_owned()
}
