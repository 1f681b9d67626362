//! Branches of linear scenes of many modes, followed by the impulses and the times of their impacts, two unknowns for each whatever the number of
//! modes (theory 19, "Many modes").

use crate::branch::equations::ByValue;
use crate::branch::family::{Family, check_same, stretched};
use crate::branch::instants::period;
use crate::branch::place::{Direction, Impulses, Place};
use crate::branch::special::Special;
use crate::error::{Error, Result};
use crate::flow::ModalScene;
use crate::hybrid::ScaledUnits;
use crate::linalg::rank;
use crate::model::Scene;
use crate::orbit::{
    Clocked, Kernel, LinearisedPulses, PeriodicOrbit, PulseTrain, Pulses, ShootingState,
};
use crate::tolerance::{MARGINAL, MEETING};
use nalgebra::{Complex, DMatrix, DVector};
use std::sync::Arc;

/// From so many modes on: below, the unknowns of a loop are not many either.
const MANY: usize = 24;
/// Corrections of a loop that is closed, and singular values along which it is not corrected, in parts of the largest entry.
const POLISHED: usize = 3;
const ALONG_FOLD: f64 = 1e-6;

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
        // All the way: where modes do not decay enough all unknowns serve.
        let (low, high) = self.range;
        for value in [low, high] {
            let there = match self.scene(value) {
                // The number may not take this value.
                Err(Error::BadValue { .. }) => continue,
                there => there?,
            };
            if check_same(&scene, &there, value).is_err() {
                continue;
            }
            if reduced.pulses(&there, None)?.is_none() {
                return Ok((self, place));
            }
        }
        Ok(match reduced.impulses_of(&scene, &place.state)? {
            None => (self, place),
            impulses => (reduced, Place { impulses, ..place }),
        })
    }

    /// The equations of loops by their impulses in a scene, if these say all.
    fn pulses(&self, scene: &Scene, others: Option<&Pulses>) -> Result<Option<Arc<Pulses>>> {
        let Clocked::Forced { period } = self.signature.clocked(scene) else {
            return Ok(None);
        };
        let modal = ModalScene::of(scene, "continuation")?;
        let stages = self.signature.stages.as_slice();
        Ok(Pulses::new(scene, &modal, (stages, period), others).map(Arc::new))
    }

    /// The same where they are to.
    fn needed_pulses(&self, scene: &Scene, value: f64, others: &Pulses) -> Result<Arc<Pulses>> {
        self.pulses(scene, Some(others))?.ok_or_else(|| {
            let rule = "of many modes each must lose more than a millionth in a period";
            Error::bad_value("parameter", value, rule)
        })
    }

    /// The impulses of a loop, if it is to be followed by them.
    pub fn impulses_of(&self, scene: &Scene, state: &ShootingState) -> Result<Option<Impulses>> {
        if !self.has_pulses {
            return Ok(None);
        }
        let equations = self.pulses(scene, None)?;
        Ok(equations.map(|equations| Impulses {
            changes: equations.train(&state.times, &state.states).changes,
            equations,
        }))
    }

    /// The equations of a train, and how far it is from being one.
    pub fn pulse_equations(&self, scene: &Scene, place: &Place) -> LinearisedPulses {
        let (pulses, train) = place.train();
        pulses.linearised(&train, &self.units_in(scene))
    }

    /// What changes with the parameter, phases and impulses being the same.
    pub fn pulses_by_value(&self, place: &Place, scene: &Scene) -> Result<ByValue> {
        let lacking = |value: f64| -> Result<DVector<f64>> {
            let there = self.scene(value)?;
            check_same(scene, &there, value)?;
            let state = stretched(&place.state, scene, &there);
            let (others, train) = place.train();
            let equations = self.needed_pulses(&there, value, others)?;
            let train = PulseTrain {
                times: state.times[..equations.len()].to_vec(),
                ..train
            };
            Ok(equations.lacking(&train, &self.units_in(&there)))
        };
        let here = || Ok(self.pulse_equations(scene, place).right);
        let [(high, upper), (low, lower)] = self.beside(place.value, &lacking, here)?;
        Ok(ByValue {
            column: (lower - upper) * (self.span() / (high - low)),
            ..ByValue::default()
        })
    }

    /// The rows of a deviation that comes back multiplied.
    pub fn pulse_variational(&self, place: &Place, multiplier: f64) -> DMatrix<f64> {
        let (pulses, train) = place.train();
        let kernel = Kernel::new(pulses, &train, &pulses.before(&train));
        kernel.equations(pulses, &self.pulse_units(place), multiplier)
    }

    /// The deviation that comes back multiplied by a number that is a multiplier, of all states and times.
    pub fn pulse_deviation(&self, place: &Place, multiplier: f64) -> Result<ShootingState> {
        let rows = self.pulse_variational(place, multiplier);
        let own = rank::weakest(&rows, 1)?.column(0).into_owned();
        let (pulses, train) = place.train();
        let count = pulses.len();
        let by = PulseTrain {
            times: (0..count).map(|i| own[count + i] * place.clock).collect(),
            changes: (0..count).map(|i| own[i] * self.units.velocity).collect(),
        };
        Ok(ShootingState {
            states: pulses.deviations(&train, multiplier, &by),
            starts: by.times.clone(),
            times: by.times.iter().copied().chain([by.times[0]]).collect(),
        })
    }

    /// How many multipliers lie outside the unit circle; none where that is not told.
    pub fn n_outside_of_pulses(&self, place: &Place) -> Option<usize> {
        let (pulses, train) = place.train();
        pulses.n_outside(&train, &self.pulse_units(place), MARGINAL)
    }

    /// How many multipliers lie outside it at a special point but those that cross it there; none where that is not told.
    pub fn n_well_outside(&self, special: &Special) -> Result<Option<usize>> {
        let (value, range) = (special.parameter, self.range);
        let (there, place) = Family::around(&special.orbit, self.make, value, range)?;
        let (there, place) = there.by_pulses(place)?;
        if !there.has_pulses {
            return Ok(None);
        }
        let (pulses, train) = place.train();
        Ok(pulses.n_outside(&train, &there.pulse_units(&place), MEETING))
    }

    /// The multiplier of a loop on the upper half of the unit circle, where one is.
    pub fn pulse_multiplier(&self, place: &Place) -> Option<Complex<f64>> {
        let (pulses, train) = place.train();
        pulses.on_circle(&train, &self.pulse_units(place))
    }

    fn pulse_units(&self, place: &Place) -> ScaledUnits {
        ScaledUnits {
            time: place.clock,
            ..self.units
        }
    }

    /// A place moved by a direction: impulses, times and the parameter, states being what follows from them.
    pub fn moved_pulses(&self, place: &Place, scene: &Scene, by: &Direction) -> Result<Place> {
        let value = place.value + by.value_part * self.span();
        let there = self.scene(value)?;
        check_same(scene, &there, value)?;
        let state = stretched(&place.state, scene, &there);
        let equations = self.needed_pulses(&there, value, place.train().0)?;
        let (count, clock) = (equations.len(), self.units_in(&there).time);
        let before = place.train().1.changes;
        let changes = before.iter().zip(by.loop_part.iter());
        let times = state.times.iter().zip(by.loop_part.iter().skip(count));
        let moved = PulseTrain {
            times: times.map(|(t, late)| t + late * clock).collect(),
            changes: changes
                .map(|(own, more)| own + more * self.units.velocity)
                .collect(),
        };
        let (starts, states) = if moved.times.is_empty() {
            let begin = state.times[0];
            (vec![begin], vec![equations.steady_at(begin)])
        } else {
            (moved.times.clone(), equations.after(&moved))
        };
        let last = starts[0] + period(&state);
        Ok(Place {
            value,
            state: ShootingState {
                times: starts.iter().copied().chain([last]).collect(),
                starts,
                states: states.iter().map(|z| equations.physical(z)).collect(),
            },
            clock,
            impulses: Some(Impulses {
                equations,
                changes: moved.changes,
            }),
        })
    }

    /// The way from a loop to another, in the scaled unknowns.
    pub fn between_pulses(&self, from: &Place, to: &Place) -> Direction {
        let ([one, other], count) = (
            [from, to].map(|place| place.train().1),
            from.train().0.len(),
        );
        let part = |i: usize| {
            if i < count {
                (other.changes[i] - one.changes[i]) / self.units.velocity
            } else {
                other.times[i - count] / to.clock - one.times[i - count] / from.clock
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
        let (pulses, mut train) = place.train();
        let units = &self.units_in(&scene);
        let mut own = pulses.linearised(&train, units);
        // Gaps are to be zero to rounding, where the orbit may not change by much: not along a fold.
        for _ in 0..POLISHED.min(pulses.len()) {
            let tolerance = ALONG_FOLD * own.rows.amax();
            let by = rank::solve(&own.rows, &own.right, tolerance)?.particular;
            let count = pulses.len();
            let moved = PulseTrain {
                times: (0..count)
                    .map(|i| train.times[i] + by[count + i] * place.clock)
                    .collect(),
                changes: (0..count)
                    .map(|i| train.changes[i] + by[i] * units.velocity)
                    .collect(),
            };
            let there = pulses.linearised(&moved, units);
            if there.mismatch >= own.mismatch {
                break;
            }
            (train, own) = (moved, there);
        }
        let begin = train.times.first().copied().unwrap_or(place.state.times[0]);
        pulses.orbit(&scene, (&train, begin), self.signature.n_periods)
    }
}
