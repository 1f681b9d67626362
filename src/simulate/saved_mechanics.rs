//! Whether a trajectory that came from a file is one of its scene: a file may have been changed.

use crate::error::{Error, Result};
use crate::hybrid::clock::Clock;
use crate::impact::wrapped;
use crate::model::contacts;
use crate::path::check_motion;
use crate::simulate::method::Method;
use crate::simulate::options::{Keep, SimulateOptions};
use crate::simulate::simulation::simulate_from;
use crate::simulate::solver::Solver;
use crate::simulate::trajectory::Trajectory;
use crate::tolerance::KEPT_AGREES;
use nalgebra::DVector;
use std::f64::consts::TAU;

fn refused(part: &str, found: impl std::fmt::Display, rule: &str) -> Error {
    Error::bad_value(format!("{part} of the saved trajectory"), found, rule)
}

impl Trajectory {
    /// Refuses what its scene cannot have: a motion that is not continuous, passes stops, changes its velocity elsewhere or has not the
    /// impacts that are listed; a last state or samples that are not of it; impacts against the law of their stop.
    ///
    /// # Errors
    /// What disagrees, with its time; what functions of the scene report.
    pub fn check_kept(&self) -> Result<()> {
        for chapter in 0..self.chapters.len() {
            if let Some(path) = &self.chapters[chapter].path {
                let impacts = self.impacts_of(chapter);
                check_motion("trajectory", path, self.scene_of(chapter), impacts)?;
            }
        }
        if let Some(path) = self.chapters.last().and_then(|last| last.path.as_ref()) {
            let end = path.end();
            let (q, v) = path.state_in(end.arc, end.local);
            let agrees = agree(&q, &self.last.0) && agree(&v, &self.last.1);
            if !agrees {
                let found = format!("{:?}", self.last.0.as_slice());
                let rule = "it must be that in which the motion ends";
                return Err(refused("the last state", found, rule));
            }
        }
        self.check_flight()?;
        self.check_phases()?;
        self.check_law()
    }

    /// The flight from which another run goes on leads to the last state.
    fn check_flight(&self) -> Result<()> {
        let Some((tolerances, _)) = &self.left.flight else {
            return Ok(());
        };
        let solver = Solver {
            method: Method::Exact,
            rtol: tolerances.relative,
            atol: tolerances.absolute,
        };
        let (options, t) = (SimulateOptions::by(solver, Keep::Final), self.t_end());
        let again = simulate_from(&self.scene, &self.last_state(), (t, t), &options)?;
        if agree(&again.last.0, &self.last.0) && agree(&again.last.1, &self.last.1) {
            return Ok(());
        }
        let found = format!("{:?}", again.last.0.as_slice());
        let rule = "it must lead to the last state";
        Err(refused("the last flight", found, rule))
    }

    /// Phases of impacts follow from their times.
    fn check_phases(&self) -> Result<()> {
        let (Some(frequency), phase) = (self.scene.frequency(), self.scene.phase()) else {
            return Ok(());
        };
        if self.ramped.is_some() || phase.is_nan() {
            return Ok(());
        }
        for impact in &self.impacts {
            let off = wrapped(Clock::new(impact.time, frequency).angle() + phase - impact.phase);
            let agrees = off.min(TAU - off) <= KEPT_AGREES;
            if !agrees {
                let found = format!("of phase {} at t = {}", impact.phase, impact.time);
                let rule = "its phase must be that of its time";
                return Err(refused("an impact", found, rule));
            }
        }
        Ok(())
    }

    /// The law of one stop alone, which needs no motion: restitution, and the impulse where the mass does not change.
    fn check_law(&self) -> Result<()> {
        let all = contacts(&self.scene);
        let [contact] = all.as_slice() else {
            return Ok(());
        };
        if self.ramped.is_some() || self.scene.linear_system("a law").is_err() {
            return Ok(());
        }
        let q = DVector::zeros(self.scene.n_dof());
        let normal = contact.surface.normal(q.as_slice())?;
        let reaction = contact.reaction(self.scene.system(), q.as_slice())?;
        let mobility = reaction.map_or(f64::NAN, |b| normal.dot(&b));
        for impact in &self.impacts {
            let change = impact.approach + impact.departure;
            let left = impact.departure - contact.law().departure(impact.approach);
            let given = impact.impulse * mobility - change;
            let agrees = left.abs().max(given.abs()) <= KEPT_AGREES * change;
            if !agrees {
                let found = format!(
                    "at t = {}, with speeds {}, {} and the impulse {}",
                    impact.time, impact.approach, impact.departure, impact.impulse
                );
                let rule = "it must follow the law of its stop";
                return Err(refused("an impact", found, rule));
            }
        }
        Ok(())
    }
}

/// Whether two vectors are one, but for what a run's tolerances leave.
fn agree(one: &DVector<f64>, other: &DVector<f64>) -> bool {
    (one - other).amax() <= KEPT_AGREES * one.amax().max(other.amax())
}
