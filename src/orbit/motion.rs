//! What moves an orbit: modal flights of a linear scene, or steps of an integrator. Both give the motion along a flight, the
//! impacts, the verdict of the rules of contact and the multipliers.

use crate::error::Result;
use crate::flow::integrate::KeptStep;
use crate::flow::{ModalScene, SceneFlow, carry, with_flow};
use crate::impact::Impact;
use crate::modal::Pair;
use crate::orbit::Pattern;
use crate::orbit::admissible::{Admissibility, Judge};
use crate::orbit::monodromy::monodromy;
use crate::orbit::periodic_orbit::{Flight, impacts_by, list_impacts};
use crate::orbit::shooting::Motion;
use crate::orbit::stability::{self, Stability};
use crate::orbit::stepped::SteppedMotion;
use crate::watch::Watch;
use nalgebra::DVector;
use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

/// What moves an orbit. The states of its flights are modal pairs of the first, pairs `(q_i, v_i)` of the second.
#[derive(Debug, Clone)]
pub(crate) enum OrbitMotion {
    Modal {
        modal: Arc<ModalScene>,
        flow: OnceLock<SceneFlow>,
    },
    Stepped {
        motion: Arc<SteppedMotion>,
        /// The start and the steps of each flight.
        steps: Arc<Vec<(f64, Vec<KeptStep>)>>,
    },
}

/// `(q, v)` as pairs.
pub(crate) fn paired(state: &DVector<f64>) -> Vec<Pair> {
    let (q, v) = state.as_slice().split_at(state.len() / 2);
    q.iter().zip(v).map(|(&q, &v)| [q, v]).collect()
}

/// The inverse of [`paired`].
fn unpaired(state: &[Pair]) -> DVector<f64> {
    let part = |k: usize| state.iter().map(move |z| z[k]);
    DVector::from_iterator(2 * state.len(), part(0).chain(part(1)))
}

impl OrbitMotion {
    /// The modal flights of a linear scene.
    pub fn modal(modal: Arc<ModalScene>) -> Self {
        Self::Modal {
            modal,
            flow: OnceLock::new(),
        }
    }

    /// The steps of the flights of any scene.
    pub fn stepped(motion: Arc<SteppedMotion>, flights: &[Flight]) -> Result<Self> {
        let steps = |flight: &Flight| {
            let state = unpaired(&flight.after);
            Ok((
                flight.start,
                motion.steps(flight.start, flight.span, &state)?,
            ))
        };
        let steps = Arc::new(flights.iter().map(steps).collect::<Result<Vec<_>>>()?);
        Ok(Self::Stepped { motion, steps })
    }

    /// Number of modal pairs, for a linear scene.
    pub fn modal_scene(&self) -> Option<&ModalScene> {
        match self {
            Self::Modal { modal, .. } => Some(modal),
            Self::Stepped { .. } => None,
        }
    }

    /// Position and velocity of a state.
    pub fn physical(&self, state: &[Pair]) -> (DVector<f64>, DVector<f64>) {
        match self {
            Self::Modal { modal, .. } => modal.form.to_physical(state),
            Self::Stepped { .. } => {
                let part =
                    |k: usize| DVector::from_iterator(state.len(), state.iter().map(|z| z[k]));
                (part(0), part(1))
            }
        }
    }

    /// Position and velocity a time after the start of flight k.
    pub fn along(
        &self,
        phase: f64,
        k: usize,
        flight: &Flight,
        local: f64,
    ) -> (DVector<f64>, DVector<f64>) {
        match self {
            Self::Modal { modal, flow } => {
                let mut state = flight.after.clone();
                let flow = flow.get_or_init(|| modal.flow());
                let angle = modal.frequency * flight.start + phase;
                with_flow!(flow, f => carry(f, angle, local, &mut state));
                modal.form.to_physical(&state)
            }
            Self::Stepped { steps, .. } => {
                let all = &steps[k].1;
                let index = all.partition_point(|s| s.start <= local).max(1) - 1;
                let x = all.get(index).map_or_else(
                    || unpaired(&flight.after).as_slice().to_vec(),
                    |step| step.dense.at((local - step.start).min(step.h)),
                );
                let (q, v) = x.split_at(x.len() / 2);
                (DVector::from_column_slice(q), DVector::from_column_slice(v))
            }
        }
    }

    /// The impacts of a period, instant by instant.
    pub fn impacts(
        &self,
        pattern: &Pattern,
        phase: f64,
        flights: &[Flight],
        impulses: &[f64],
    ) -> Result<Vec<Impact>> {
        let motion = match self {
            Self::Modal { modal, .. } => {
                return Ok(list_impacts(modal, pattern, phase, flights, impulses));
            }
            Self::Stepped { motion, .. } => motion,
        };
        let law = |stop: usize, before: &[Pair]| -> Result<(f64, f64)> {
            let x = unpaired(before);
            let (_, gradient) = motion.gap(stop, &x)?;
            let approach = -gradient.dot(&x.rows(gradient.len(), gradient.len()));
            Ok((approach, motion.restitution(stop)))
        };
        impacts_by(law, pattern, (motion.frequency, phase), flights, impulses)
    }

    /// What the rules of contact say.
    pub fn admissibility(
        &self,
        pattern: &Pattern,
        phase: f64,
        flights: &[Flight],
        impacts: &[Impact],
        watch: &mut Watch<'_>,
    ) -> Result<Admissibility> {
        match self {
            Self::Modal { modal, .. } => {
                Judge::new(modal).admissibility(phase, flights, impacts, watch)
            }
            Self::Stepped { motion, steps } => {
                let period: f64 = flights.iter().map(|f| f.span).sum();
                motion.admissibility(steps, pattern.instants(), impacts, TAU / period)
            }
        }
    }

    /// Multipliers and what they decide.
    pub fn stability(
        &self,
        pattern: &Pattern,
        phase: f64,
        flights: &[Flight],
        found: &Admissibility,
        watch: &mut Watch<'_>,
    ) -> Result<Stability> {
        match self {
            Self::Modal { modal, .. } => {
                stability::stability(modal, pattern.instants(), phase, flights, found, watch)
            }
            Self::Stepped { motion, .. } => {
                let is_coupled = |a: usize, b: usize| motion.is_coupled(a, b, flights, pattern);
                if let Some(refused) = stability::refused(pattern.instants(), found, is_coupled) {
                    return Ok(refused);
                }
                let flown: Vec<_> = flights
                    .iter()
                    .map(|f| (f.start, f.start + f.span, unpaired(&f.after)))
                    .collect();
                stability::over_orders(pattern.instants(), |order| {
                    watch.look()?;
                    monodromy(&**motion, order, &flown)
                })
            }
        }
    }
}
