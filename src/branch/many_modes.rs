//! Branches of linear scenes of many modes, followed by the impulses and the times of their impacts, two unknowns for each whatever the number of
//! modes (theory 19, "Many modes").

use crate::branch::equations::ByValue;
use crate::branch::family::{Family, check_same, stretched};
use crate::branch::instants::period;
use crate::branch::place::{Direction, Place};
use crate::error::{Error, Result};
use crate::flow::ModalScene;
use crate::linalg::rank;
use crate::model::Scene;
use crate::orbit::{Kernel, LinearisedPulses, PeriodicOrbit, PulseTrain, Pulses, ShootingState};
use nalgebra::{Complex, DMatrix, DVector};
use std::sync::Arc;

/// From so many modes on: below, the unknowns of a loop are not many either.
const MANY: usize = 24;

impl Family<'_> {
    /// The same followed by its impulses, where the scene has many modes and they say all.
    pub fn by_pulses(self, place: Place) -> Result<(Self, Place)> {
        let scene = self.scene(place.value)?;
        let is_linear = scene.linear_system("continuation").is_ok();
        if !is_linear || scene.n_dof() < MANY || self.is_free || self.signature.images.is_some() {
            return Ok((self, place));
        }
        let reduced = Self {
            has_pulses: true,
            ..self.clone()
        };
        Ok(match reduced.pulses(&scene, &place.state)? {
            Some(_) => {
                let place = reduced.place(&scene, place.value, place.state)?;
                (reduced, place)
            }
            None => (self, place),
        })
    }

    /// The equations of its impulses in a scene, if these say all.
    fn pulses(&self, scene: &Scene, state: &ShootingState) -> Result<Option<Pulses>> {
        let modal = Arc::new(ModalScene::new(scene, "continuation")?);
        let stages = &self.signature.stages;
        Ok(Pulses::new(scene, &modal, stages, period(state)))
    }

    /// The same where they are to.
    fn pulses_at(&self, scene: &Scene, place: &Place) -> Result<Pulses> {
        self.pulses(scene, &place.state)?.ok_or_else(|| {
            let rule = "with many modes each of them must decay";
            Error::bad_value("parameter", place.value, rule)
        })
    }

    /// The impulses of a loop, if it is followed by them.
    pub fn impulses_of(&self, scene: &Scene, state: &ShootingState) -> Result<Vec<f64>> {
        if !self.has_pulses {
            return Ok(Vec::new());
        }
        let pulses = self.pulses(scene, state)?;
        Ok(pulses.map_or(Vec::new(), |pulses| {
            pulses.train(&state.times, &state.states).changes
        }))
    }

    /// The equations of a train, and how far it is from being one.
    pub fn pulse_equations(&self, scene: &Scene, place: &Place) -> Result<LinearisedPulses> {
        let pulses = self.pulses_at(scene, place)?;
        Ok(pulses.linearised(&train(place), &self.units_in(scene)))
    }

    /// What changes with the parameter, phases and impulses being the same.
    pub fn pulses_by_value(&self, place: &Place, scene: &Scene) -> Result<ByValue> {
        let lacking = |value: f64| -> Result<DVector<f64>> {
            let there = self.scene(value)?;
            check_same(scene, &there, value)?;
            let state = stretched(&place.state, scene, &there);
            let moved = Place {
                value,
                state,
                ..place.clone()
            };
            Ok(self.pulse_equations(&there, &moved)?.right)
        };
        let here = || self.pulse_equations(scene, place).map(|own| own.right);
        let [(high, upper), (low, lower)] = self.beside(place.value, &lacking, here)?;
        Ok(ByValue {
            column: (lower - upper) * (self.span() / (high - low)),
            ..ByValue::default()
        })
    }

    /// The rows of a deviation that comes back multiplied.
    pub fn pulse_variational(&self, place: &Place, multiplier: f64) -> Result<DMatrix<f64>> {
        let scene = self.scene(place.value)?;
        let (pulses, train) = (self.pulses_at(&scene, place)?, train(place));
        let before = pulses.before(&train);
        let units = &self.units_in(&scene);
        Ok(Kernel::new(&pulses, &train, &before).equations(&pulses, units, multiplier))
    }

    /// The deviation that comes back multiplied by a number that is a multiplier, of all states and times.
    pub fn pulse_deviation(&self, place: &Place, multiplier: f64) -> Result<ShootingState> {
        let rows = self.pulse_variational(place, multiplier)?;
        let own = rank::weakest(&rows, 1)?.column(0).into_owned();
        let scene = self.scene(place.value)?;
        let (pulses, train) = (self.pulses_at(&scene, place)?, train(place));
        let (count, clock) = (pulses.len(), self.units_in(&scene).time);
        let by = PulseTrain {
            times: (0..count).map(|i| own[count + i] * clock).collect(),
            changes: (0..count).map(|i| own[i] * self.units.velocity).collect(),
        };
        Ok(ShootingState {
            states: pulses.deviations(&train, multiplier, &by),
            starts: by.times.clone(),
            times: by.times.iter().copied().chain([by.times[0]]).collect(),
        })
    }

    /// The speeds at which stops are approached.
    pub fn approaches_of_pulses(&self, place: &Place) -> Result<Vec<f64>> {
        let scene = self.scene(place.value)?;
        Ok(self.pulses_at(&scene, place)?.approaches(&train(place)))
    }

    /// How many multipliers lie outside the unit circle; none where that is not told.
    pub fn n_outside_of_pulses(&self, place: &Place) -> Result<Option<usize>> {
        let scene = self.scene(place.value)?;
        let pulses = self.pulses_at(&scene, place)?;
        Ok(pulses.n_outside(&train(place), &self.units_in(&scene)))
    }

    /// The multiplier of a loop on the upper half of the unit circle, where one is.
    pub fn pulse_multiplier(&self, place: &Place) -> Result<Option<Complex<f64>>> {
        let scene = self.scene(place.value)?;
        let pulses = self.pulses_at(&scene, place)?;
        Ok(pulses.on_circle(&train(place), &self.units_in(&scene)))
    }

    /// A place moved by a direction: impulses, times and the parameter, states being what follows from them.
    pub fn moved_pulses(&self, place: &Place, scene: &Scene, by: &Direction) -> Result<Place> {
        let value = place.value + by.value_part * self.span();
        let there = self.scene(value)?;
        check_same(scene, &there, value)?;
        let state = stretched(&place.state, scene, &there);
        let pulses = self.pulses_at(&there, place)?;
        let (count, clock) = (pulses.len(), self.units_in(&there).time);
        let own = |i: usize| place.impulses[i] + by.loop_part[i] * self.units.velocity;
        let late = |i: usize| state.times[i] + by.loop_part[count + i] * clock;
        let moved = PulseTrain {
            times: (0..count).map(late).collect(),
            changes: (0..count).map(own).collect(),
        };
        Ok(self.place_of(&pulses, moved, value, (period(&state), clock)))
    }

    fn place_of(
        &self,
        pulses: &Pulses,
        train: PulseTrain,
        value: f64,
        (period, clock): (f64, f64),
    ) -> Place {
        let states = pulses.after(&train);
        let last = train.times[0] + period;
        Place {
            value,
            state: ShootingState {
                starts: train.times.clone(),
                times: train.times.iter().copied().chain([last]).collect(),
                states: states.iter().map(|z| pulses.physical(z)).collect(),
            },
            clock,
            impulses: train.changes,
        }
    }

    /// The way from a loop to another, in the scaled unknowns.
    pub fn between_pulses(&self, from: &Place, to: &Place) -> Direction {
        let count = from.impulses.len();
        let part = |i: usize| {
            if i < count {
                (to.impulses[i] - from.impulses[i]) / self.units.velocity
            } else {
                let k = i - count;
                to.state.times[k] / to.clock - from.state.times[k] / from.clock
            }
        };
        Direction {
            loop_part: DVector::from_fn(2 * count, |i, _| part(i)),
            value_part: (to.value - from.value) / self.span(),
        }
    }

    /// The orbit of a loop.
    pub fn orbit_of_pulses(&self, place: &Place) -> Result<PeriodicOrbit> {
        let scene = self.scene(place.value)?;
        let pulses = self.pulses_at(&scene, place)?;
        pulses.orbit(&scene, &train(place), self.signature.n_periods)
    }
}

/// The impulses and times of a loop.
fn train(place: &Place) -> PulseTrain {
    PulseTrain {
        times: place.state.times[..place.impulses.len()].to_vec(),
        changes: place.impulses.clone(),
    }
}
