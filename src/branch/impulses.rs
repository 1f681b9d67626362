//! The formulation of branches of linear scenes of many modes. The unknowns are the impulses and times of the impacts, two for each impact
//! whatever the number of modes (theory 19, "Many modes"); impulses as changes of speed in the unit of velocities, times in that of the
//! clock. Multipliers are counted, by the turns of their determinant along the unit circle.

use crate::branch::equations::{Equations, ParameterDerivative};
use crate::branch::parametric_loop::{BranchDirection, ImpulseUnknowns, ParametricLoop};
use crate::branch::problem::{BranchProblem, Formulation, check_same, stretched};
use crate::branch::shooting_nodes::period;
use crate::error::{Error, Result};
use crate::flow::ModalScene;
use crate::hybrid::ScaledUnits;
use crate::linalg::rank;
use crate::model::Scene;
use crate::orbit::{
    Clocked, Kernel, LinearisedPulses, PeriodicOrbit, PulseTrain, Pulses, ShootingState,
};
use crate::tolerance::{MANY_MODES, MARGINAL, SINGULAR_ALONG_FOLD};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Corrections of a loop that is closed already, by which its gaps become zero to rounding. `[work]`
const MOST_POLISHINGS: usize = 3;

impl BranchProblem<'_> {
    /// The problem and its loop with the impulses as unknowns, where the scene has many modes and these determine the motion; else both as
    /// they are.
    pub fn by_impulses(self, place: ParametricLoop) -> Result<(Self, ParametricLoop)> {
        let scene = self.scene(place.value)?;
        let is_linear = scene.linear_system("continuation").is_ok();
        if !is_linear
            || scene.n_dof() < MANY_MODES
            || self.is_free
            || self.signature.images.is_some()
        {
            return Ok((self, place));
        }
        let reduced = Self {
            formulation: Formulation::Impulses,
            ..self.clone()
        };
        // At both ends of the range: where modes do not decay enough, all unknowns are needed.
        let (low, high) = self.range;
        for value in [low, high] {
            let there = match self.scene(value) {
                // The scene refuses this value.
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
            impulses => (reduced, ParametricLoop { impulses, ..place }),
        })
    }

    /// The equations of impulses in a scene, if these determine the motion.
    fn pulses(&self, scene: &Scene, others: Option<&Pulses>) -> Result<Option<Arc<Pulses>>> {
        let Clocked::Forced { period } = self.signature.clocked(scene) else {
            return Ok(None);
        };
        let modal = ModalScene::of(scene, "continuation")?;
        let itinerary = &self.signature.stages;
        Ok(Pulses::new(scene, &modal, (itinerary, period), others).map(Arc::new))
    }

    /// The equations of impulses in a scene; an error where these do not determine the motion.
    fn needed_pulses(&self, scene: &Scene, value: f64, others: &Pulses) -> Result<Arc<Pulses>> {
        self.pulses(scene, Some(others))?.ok_or_else(|| {
            let rule = "of many modes each must lose more than a millionth in a period";
            Error::bad_value("parameter", value, rule)
        })
    }

    /// The impulses of a loop; none where they do not determine the motion.
    pub fn impulses_of(
        &self,
        scene: &Scene,
        state: &ShootingState,
    ) -> Result<Option<ImpulseUnknowns>> {
        let equations = self.pulses(scene, None)?;
        Ok(equations.map(|equations| ImpulseUnknowns {
            changes: equations.train(&state.times, &state.states).changes,
            equations,
        }))
    }

    fn linearised_impulses(&self, scene: &Scene, place: &ParametricLoop) -> LinearisedPulses {
        let (pulses, train) = place.train();
        pulses.linearised(&train, &self.units_in(scene))
    }

    /// The equations of a loop: the gap of the stop and the law of restitution of each impact.
    pub fn impulse_equations(&self, place: &ParametricLoop, scene: Arc<Scene>) -> Equations {
        let own = self.linearised_impulses(&scene, place);
        Equations::closing(scene, (own.rows, own.right, own.mismatch), None)
    }

    /// Derivatives by the parameter, phases and impulses held.
    pub fn impulses_by_value(
        &self,
        place: &ParametricLoop,
        scene: &Scene,
    ) -> Result<ParameterDerivative> {
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
        let here = || Ok(self.linearised_impulses(scene, place).right);
        let [(high, upper), (low, lower)] = self.beside(place.value, &lacking, here)?;
        Ok(ParameterDerivative {
            column: (lower - upper) * (self.span() / (high - low)),
            ..ParameterDerivative::default()
        })
    }

    /// The matrix that is singular where a number is a multiplier.
    pub fn impulse_variational(&self, place: &ParametricLoop, multiplier: f64) -> DMatrix<f64> {
        let (pulses, train) = place.train();
        let kernel = Kernel::new(pulses, &train, &pulses.before(&train));
        kernel.equations(pulses, &self.pulse_units(place), multiplier)
    }

    /// The eigenvector of a multiplier, as deviations of all states and times.
    pub fn impulse_deviation(
        &self,
        place: &ParametricLoop,
        multiplier: f64,
    ) -> Result<ShootingState> {
        let rows = self.impulse_variational(place, multiplier);
        let own = rank::weakest(&rows, 1)?.column(0).into_owned();
        let (pulses, train) = place.train();
        let by = self.train_of(&own, place.clock);
        Ok(ShootingState {
            states: pulses.deviations(&train, multiplier, &by),
            starts: by.times.clone(),
            times: by.times.iter().copied().chain([by.times[0]]).collect(),
        })
    }

    /// How many multipliers lie outside the unit circle; `None` where that is not decided.
    pub fn n_outside_of_impulses(&self, place: &ParametricLoop) -> Option<usize> {
        let (pulses, train) = place.train();
        pulses.n_outside(&train, &self.pulse_units(place), MARGINAL)
    }

    /// What a function makes of the impulses of an orbit at a value; none where other unknowns are needed.
    pub fn impulses_at<T>(
        &self,
        orbit: &PeriodicOrbit,
        value: f64,
        of: impl FnOnce(&Pulses, &PulseTrain, &ScaledUnits) -> Option<T>,
    ) -> Result<Option<T>> {
        let (there, place) = BranchProblem::around(orbit, self.make, value, self.range)?;
        let (there, place) = there.by_impulses(place)?;
        if place.impulses.is_none() {
            return Ok(None);
        }
        let (pulses, train) = place.train();
        Ok(of(pulses, &train, &there.pulse_units(&place)))
    }

    /// Scaled unknowns of a loop as impulses and times.
    fn train_of(&self, scaled: &DVector<f64>, clock: f64) -> PulseTrain {
        let (changes, times) = scaled.as_slice().split_at(scaled.len() / 2);
        PulseTrain {
            times: times.iter().map(|time| time * clock).collect(),
            changes: changes
                .iter()
                .map(|own| own * self.units.velocity)
                .collect(),
        }
    }

    fn pulse_units(&self, place: &ParametricLoop) -> ScaledUnits {
        ScaledUnits {
            time: place.clock,
            ..self.units
        }
    }

    /// A loop moved along a direction: impulses, times and the parameter, and the states that follow from them.
    pub fn moved_impulses(
        &self,
        place: &ParametricLoop,
        scene: &Scene,
        by: &BranchDirection,
    ) -> Result<ParametricLoop> {
        let value = place.value + by.value_part * self.span();
        let there = self.scene(value)?;
        check_same(scene, &there, value)?;
        let state = stretched(&place.state, scene, &there);
        let equations = self.needed_pulses(&there, value, place.train().0)?;
        let clock = self.units_in(&there).time;
        let stretched = PulseTrain {
            times: state.times.clone(),
            changes: place.before_times().to_vec(),
        };
        let moved = stretched.moved(&self.train_of(&by.loop_part, clock));
        let (starts, states) = if moved.times.is_empty() {
            let begin = state.times[0];
            (vec![begin], vec![equations.steady_at(begin)])
        } else {
            (moved.times.clone(), equations.after(&moved))
        };
        let last = starts[0] + period(&state);
        Ok(ParametricLoop {
            value,
            state: ShootingState {
                times: starts.iter().copied().chain([last]).collect(),
                starts,
                states: states.iter().map(|z| equations.physical(z)).collect(),
            },
            clock,
            impulses: Some(ImpulseUnknowns {
                equations,
                changes: moved.changes,
            }),
        })
    }

    /// The orbit of a loop.
    pub fn orbit_of_impulses(&self, place: &ParametricLoop) -> Result<PeriodicOrbit> {
        let scene = self.scene(place.value)?;
        let (pulses, mut train) = place.train();
        let units = &self.units_in(&scene);
        let mut own = pulses.linearised(&train, units);
        // Gaps are to be zero to rounding; along a fold the loop would move too far for that.
        for _ in 0..MOST_POLISHINGS.min(pulses.len()) {
            let tolerance = SINGULAR_ALONG_FOLD * own.rows.amax();
            let by = rank::solve(&own.rows, &own.right, tolerance)?.particular;
            let moved = train.moved(&self.train_of(&by, place.clock));
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
