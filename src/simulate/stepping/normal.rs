//! The present state of a motion in steps against its stops: normals and reactions, pushes along them.

use super::FreeFlight;
use super::{MOST_POLISHES, StepMover};
use crate::error::{Error, Result};
use crate::flow::runge_kutta::State;
use crate::model::{Dynamics, GapValue, along_reactions};
use nalgebra::DVector;

impl<S: State, D: Dynamics, F: FreeFlight<S, D>> StepMover<'_, S, D, F> {
    /// Moves the present state onto some stops, along their reactions, and takes their normal speeds away.
    pub(super) fn settle(&mut self, stops: &[usize]) -> Result<()> {
        let n = self.n();
        for _ in 0..MOST_POLISHES {
            let values = stops.iter().map(|&stop| {
                let (q, v) = self.x.slice().split_at(n);
                self.contacts[stop].surface.along(q, v, v, 0.0)
            });
            let values: Vec<GapValue> = values.collect::<Result<_>>()?;
            let gaps = DVector::from_iterator(stops.len(), values.iter().map(|value| value.gap));
            let moves = self.along_reactions(stops, &gaps)?;
            for (q, d) in self.x.slice_mut()[..n].iter_mut().zip(moves.iter()) {
                *q += d;
            }
            if values
                .iter()
                .all(|value| value.gap.abs() <= f64::EPSILON * value.size)
            {
                break;
            }
        }
        let approach = |&stop: &usize| {
            let (normal, _) = self.directions(stop)?;
            Ok(self.along(&normal))
        };
        let approaches: Vec<f64> = stops.iter().map(approach).collect::<Result<_>>()?;
        let moves = self.along_reactions(stops, &DVector::from_vec(approaches))?;
        self.push_along(&moves, 1.0);
        Ok(())
    }

    /// The present speed along a normal.
    pub(super) fn along(&self, normal: &DVector<f64>) -> f64 {
        let v = &self.x.slice()[normal.len()..];
        normal.iter().zip(v).map(|(n, v)| n * v).sum()
    }

    /// Changes the present velocity by so much against a direction.
    pub(super) fn push_along(&mut self, direction: &DVector<f64>, impulse: f64) {
        let v = &mut self.x.slice_mut()[direction.len()..];
        for (v, b) in v.iter_mut().zip(direction.iter()) {
            *v -= b * impulse;
        }
        self.is_begun = false;
    }

    /// The combination of the stops' reactions whose parts along their normals are given.
    pub(super) fn along_reactions(
        &self,
        stops: &[usize],
        parts: &DVector<f64>,
    ) -> Result<DVector<f64>> {
        let each = stops.iter().map(|&stop| self.directions(stop));
        let each: Vec<_> = each.collect::<Result<_>>()?;
        let (normals, reactions): (Vec<_>, Vec<_>) = each.into_iter().unzip();
        along_reactions(&normals, &reactions, parts)
    }

    /// The normal of a stop and its reaction direction.
    pub(super) fn directions(&self, stop: usize) -> Result<(DVector<f64>, DVector<f64>)> {
        let (q, _) = self.x.slice().split_at(self.n());
        let contact = &self.contacts[stop];
        let normal = contact.surface.normal(q)?;
        let reaction = contact.reaction(self.scene.system(), q)?;
        match reaction.filter(|b| normal.dot(b) > 0.0) {
            Some(reaction) => Ok((normal, reaction)),
            None => Err(Error::bad_value(
                format!("stops[{stop}]"),
                "a stop without a normal",
                "at an impact its gap must change with the coordinates and its reaction must push",
            )),
        }
    }
}
