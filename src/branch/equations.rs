//! The equations of a loop linearised at a place, with the column of the parameter by differences (theory 19).

use crate::branch::family::{Family, check_same, stretched};
use crate::branch::place::{Direction, Place};
use crate::error::{Error, Result};
use crate::hybrid::ScaledUnits;
use crate::linalg::determinant::{Determinant, signed_volume};
use crate::linalg::rank;
use crate::model::Scene;
use crate::orbit::{
    ContactStage, Event, Linearised, LinearisedPulses, OrbitOf, PeriodicOrbit, Shooting,
    ShootingState, with_shooting,
};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// The equations at a place: `rows xi + column pi = right`, pi the parameter in parts of its range.
#[derive(Clone)]
pub(super) struct Equations {
    pub rows: DMatrix<f64>,
    pub by_value: ByValue,
    pub right: DVector<f64>,
    /// How far the loop is from closing.
    pub mismatch: f64,
    scene: Arc<Scene>,
    /// None of a loop that is followed by its impulses.
    linear: Option<Linearised>,
}

/// Where a step begins: a place, the equations there, and the direction of the branch.
pub(super) type Foot<'a> = (&'a Place, &'a Equations, &'a Direction);

/// What changes with pi.
#[derive(Clone, Default)]
pub(super) struct ByValue {
    /// The equations.
    pub column: DVector<f64>,
    /// The states and the starts of the flights; nothing of a loop that is followed by its impulses.
    pub flights: ShootingState,
}

impl Equations {
    /// A number that changes its sign where another branch is crossed, along a direction of this one.
    pub fn crossing(&self, tangent: &Direction) -> f64 {
        signed_volume(self.bordered(tangent))
    }

    /// The matrix of the equations, the parameter last.
    pub fn all_columns(&self) -> DMatrix<f64> {
        let last = self.rows.ncols();
        let mut matrix = self.rows.clone().insert_column(last, 0.0);
        matrix.set_column(last, &self.by_value.column);
        matrix
    }

    /// The same beside one more row.
    pub fn bordered(&self, border: &Direction) -> DMatrix<f64> {
        let last = self.rows.nrows();
        let mut matrix = self.all_columns().insert_row(last, 0.0);
        matrix.set_row(last, &border.row().transpose());
        matrix
    }
}

impl Family<'_> {
    /// The equations at a place.
    pub fn equations(&self, place: &Place) -> Result<Equations> {
        let equations = self.equations_nearby(place, &ByValue::default())?;
        self.renewed(place, equations)
    }

    /// The same with what changes with the parameter as it is at a place nearby: corrections by them are a little longer on their way.
    pub fn equations_nearby(&self, place: &Place, by_value: &ByValue) -> Result<Equations> {
        let scene = self.scene(place.value)?;
        let by_value = by_value.clone();
        // In parts of the motion's own size, where it has outgrown the units.
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

    /// The same with what changes with the parameter there.
    pub fn renewed(&self, place: &Place, equations: Equations) -> Result<Equations> {
        let by_value = match &equations.linear {
            Some(linear) => self.by_value(place, &equations.scene, linear)?,
            None => self.pulses_by_value(place, &equations.scene)?,
        };
        Ok(Equations {
            by_value,
            ..equations
        })
    }

    /// Equations as those of a place next to theirs.
    pub fn equations_at(&self, place: &Place, equations: Equations) -> Result<Equations> {
        Ok(Equations {
            scene: self.scene(place.value)?,
            ..equations
        })
    }

    /// Does some work with the equations at a place.
    fn shooting_at<T>(
        &self,
        place: &Place,
        work: impl FnOnce(&Shooting<'_>, OrbitOf<'_>, &ScaledUnits) -> Result<T>,
    ) -> Result<T> {
        let scene = self.scene(place.value)?;
        let units = &self.units_in(&scene);
        with_shooting(&scene, &self.signature, |shooting, orbit| {
            work(shooting, orbit, units)
        })
    }

    /// The speed at which the stop of an instant is approached, the first of them if there are several.
    pub fn approach(&self, place: &Place, instant: usize) -> Result<f64> {
        Ok(self.approaches(place)?[instant])
    }

    /// The speeds at all instants; not a number where nothing is hit.
    pub fn approaches(&self, place: &Place) -> Result<Vec<f64>> {
        if self.has_pulses {
            let (pulses, train) = place.train();
            return Ok(pulses.approaches(&train));
        }
        let state = &place.state;
        let count = state.states.len();
        self.shooting_at(place, |shooting, _, units| {
            let ends = shooting.flight_ends(state, units)?;
            let stages = self.signature.stages.iter().enumerate();
            let speed = |(instant, stage): (usize, &ContactStage)| {
                let Event::Strike(stops) = &stage.event else {
                    return Ok(f64::NAN);
                };
                let flight = (instant + count - 1) % count;
                let before = &ends[flight].before;
                let n = before.len() / 2;
                let at = shooting
                    .motion
                    .gap(stops[0], state.times[flight + 1], before)?;
                Ok(-at.speed(before.rows(n, n)))
            };
            stages.map(speed).collect()
        })
    }

    /// The gap of a stop at an instant, in units of the motion.
    pub fn gap_at(&self, place: &Place, (stop, instant): (usize, usize)) -> Result<f64> {
        let (t, x) = (place.state.times[instant], &place.state.states[instant]);
        self.shooting_at(place, |shooting, _, units| {
            let at = shooting.motion.gap(stop, t, x)?;
            Ok(at.gap / (at.gradient.amax() * units.position))
        })
    }

    /// The acceleration with which the gap of the stop of an instant opens behind it, where it is let go.
    pub fn opening(&self, place: &Place, instant: usize) -> Result<f64> {
        let (t, state) = (place.state.times[instant], &place.state.states[instant]);
        let stage = &self.signature.stages[instant];
        let Event::Strike(stops) = &stage.event else {
            return Ok(f64::NAN);
        };
        let others = stage.held_but(stops[0]);
        self.shooting_at(place, |shooting, _, _| {
            let rate = shooting.motion.rate(&others, t, state)?;
            shooting.motion.gap_acceleration(stops[0], t, state, &rate)
        })
    }

    /// The deviation that comes back multiplied by a number that is a multiplier, of all states and times.
    pub fn deviation(&self, place: &Place, multiplier: f64) -> Result<ShootingState> {
        if self.has_pulses {
            return self.pulse_deviation(place, multiplier);
        }
        let linear = self.linearised(place)?;
        let own = rank::weakest(&linear.returning(multiplier), 1)?;
        Ok(linear.deviations(&own.column(0).into_owned()))
    }

    /// The equations of the loop alone.
    fn linearised(&self, place: &Place) -> Result<Linearised> {
        self.shooting_at(place, |shooting, _, units| {
            shooting.linearised(&place.state, units)
        })
    }

    /// How far a loop is from closing.
    pub fn mismatch(&self, place: &Place) -> Result<f64> {
        self.shooting_at(place, |shooting, _, units| {
            shooting.mismatch(&place.state, units)
        })
    }

    /// The same family with positions and velocities in the units of another loop.
    pub fn in_units_of(&self, place: &Place) -> Result<Self> {
        let units = self.shooting_at(place, |shooting, _, _| shooting.units(&place.state))?;
        let time = self.units.time;
        Ok(Self {
            units: ScaledUnits { time, ..units },
            ..self.clone()
        })
    }

    /// A number that changes its sign where a multiplier passes through another number, and nowhere else.
    pub fn multiplier_test(
        &self,
        at: (&Place, Option<&Equations>),
        multiplier: f64,
    ) -> Result<f64> {
        let own = self.multiplier_determinant(at, multiplier)?;
        Ok(own.in_parts_of(own.lengths))
    }

    /// A determinant that is zero where a number is a multiplier, and smooth; by the equations of a place where they are known.
    pub fn multiplier_determinant(
        &self,
        (place, equations): (&Place, Option<&Equations>),
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

    /// The orbit at a place where the loop is closed.
    ///
    /// # Errors
    /// A scene that is not odd any more, of half a motion; what the motion reports.
    pub fn orbit(&self, place: &Place) -> Result<PeriodicOrbit> {
        if self.signature.images.is_some() {
            let scene = self.scene(place.value)?;
            if self.images_in(&scene, place)? != self.signature.images {
                let rule = "the scene must stay odd, which the orbits' symmetry q(t + T/2) = -q(t) asks for";
                return Err(Error::bad_value("parameter", place.value, rule));
            }
            let (family, place) = self.whole(place)?;
            return family.orbit(&place);
        }
        if self.has_pulses {
            return self.orbit_of_pulses(place);
        }
        let state = &place.state;
        self.shooting_at(place, |shooting, orbit, units| {
            orbit(state, &shooting.flight_ends(state, units)?)
        })
    }

    /// The same where it closes by another route than the one that made it: half a motion for a whole period, impulses by flights.
    ///
    /// # Errors
    /// As [`orbit`](Self::orbit); a motion that does not.
    pub fn closed_orbit(&self, place: &Place) -> Result<PeriodicOrbit> {
        let orbit = self.orbit(place)?;
        match orbit.missed([self.units.position, self.units.velocity])? {
            None => Ok(orbit),
            Some(residual) => Err(Error::NoConvergence {
                stage: "the motion, followed once more by another route,",
                iterations: 0,
                residual,
            }),
        }
    }

    /// How what the loop lacks, and with it the states of its flights, changes with the parameter, in parts of the range: central
    /// differences, instants held at their phases; one-sided at the end of what the parameter may be.
    fn by_value(&self, place: &Place, scene: &Scene, here: &Linearised) -> Result<ByValue> {
        let none = DVector::zeros(here.rows.ncols());
        if self.energetics.is_some() {
            return Ok(ByValue {
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
        Ok(ByValue {
            column: (right - left) * -factor,
            flights: ShootingState {
                times: rate(&one.times, &other.times),
                starts: rate(&one.starts, &other.starts),
                states: states.map(|(a, b)| (a - b) * factor).collect(),
            },
        })
    }

    /// What is at the values beside one, above and below, with these; at itself where one of them is refused.
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

    /// A place moved by the parameter alone, to first order.
    pub fn moved_by_value(
        &self,
        place: &Place,
        (equations, by_value): (&Equations, &ByValue),
        part: f64,
    ) -> Result<Place> {
        let by = Direction {
            loop_part: DVector::zeros(equations.rows.ncols()),
            value_part: part,
        };
        // Of a place that was moved by another number the equations are not those of its scene.
        let scene = &self.scene(place.value)?;
        let moved = |linear: &Linearised| linear.deviations(&own_part(linear, &by));
        self.moved_by((place, scene), (equations, by_value), (&by, &moved))
    }

    /// A place moved by a direction, to first order.
    pub fn moved(&self, place: &Place, equations: &Equations, by: &Direction) -> Result<Place> {
        let moved = |linear: &Linearised| linear.corrections(&own_part(linear, by));
        let own = (equations, &equations.by_value);
        self.moved_by((place, &equations.scene), own, (by, &moved))
    }

    /// A place moved by a deviation, to first order: what is not closed stays so.
    pub fn deviated(&self, place: &Place, equations: &Equations, by: &Direction) -> Result<Place> {
        let moved = |linear: &Linearised| linear.deviations(&own_part(linear, by));
        let own = (equations, &equations.by_value);
        self.moved_by((place, &equations.scene), own, (by, &moved))
    }

    fn moved_by(
        &self,
        (place, scene): (&Place, &Scene),
        (equations, by_value): (&Equations, &ByValue),
        (by, moved): (&Direction, &dyn Fn(&Linearised) -> ShootingState),
    ) -> Result<Place> {
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

/// The part of a direction that its loop's own unknowns are.
fn own_part(linear: &Linearised, by: &Direction) -> DVector<f64> {
    by.loop_part.rows(0, linear.rows.ncols()).into_owned()
}
