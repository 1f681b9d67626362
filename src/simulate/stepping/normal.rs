//! The present state of a motion in steps against its stops: normals and reactions, pushes along them.

use super::free::FreeFlight;
use super::{MOST_POLISHES, StepMover};
use crate::error::{Error, Result};
use crate::flow::steps::State;
use crate::model::{Dynamics, GapValue, along_reactions};
use crate::quantity::difference;
use nalgebra::DVector;

impl<S: State, D: Dynamics, F: FreeFlight<S, D>> StepMover<'_, S, D, F> {
    /// Moves the present state onto some stops, along their reactions, and takes their normal speeds away.
    pub(super) fn settle(&mut self, stops: &[usize]) -> Result<()> {
        self.put_on(stops)?;
        let approach = |&stop: &usize| Ok(self.along(self.directions(stop)?.both().0));
        let approaches: Vec<f64> = stops.iter().map(approach).collect::<Result<_>>()?;
        let moves = self.along_reactions(stops, &DVector::from_vec(approaches))?;
        self.push_along(moves.as_slice(), 1.0);
        Ok(())
    }

    /// Moves the present position onto some stops, along their reactions.
    pub(super) fn put_on(&mut self, stops: &[usize]) -> Result<()> {
        let n = self.n();
        self.is_begun = false;
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
        Ok(())
    }

    /// The present speed along a normal.
    pub(super) fn along(&self, normal: &[f64]) -> f64 {
        dot(normal, &self.x.slice()[normal.len()..])
    }

    /// Changes the present velocity by so much against a direction.
    pub(super) fn push_along(&mut self, direction: &[f64], impulse: f64) {
        let v = &mut self.x.slice_mut()[direction.len()..];
        for (v, b) in v.iter_mut().zip(direction) {
            *v = difference(*v, b * impulse);
        }
        self.is_begun = false;
    }

    /// The combination of the stops' reactions whose parts along their normals are given.
    pub(super) fn along_reactions(
        &self,
        stops: &[usize],
        parts: &DVector<f64>,
    ) -> Result<DVector<f64>> {
        let (mut normals, mut reactions) = (Vec::new(), Vec::new());
        for &stop in stops {
            let directions = self.directions(stop)?;
            let (normal, reaction) = directions.both();
            normals.push(DVector::from_column_slice(normal));
            reactions.push(DVector::from_column_slice(reaction));
        }
        along_reactions(&normals, &reactions, parts)
    }

    /// The normal of a stop and its reaction direction.
    pub(super) fn directions(&self, stop: usize) -> Result<Directions<S>> {
        let (q, _) = self.x.slice().split_at(self.n());
        let contact = &self.contacts[stop];
        let mut both = S::zeros(2 * q.len());
        let (normal, reaction) = both.slice_mut().split_at_mut(q.len());
        contact.surface.put_normal(q, normal)?;
        reaction.copy_from_slice(normal);
        let is_regular = contact.turn_to_reaction(self.scene.system(), q, reaction)?;
        if is_regular && dot(normal, reaction) > 0.0 {
            return Ok(Directions(both));
        }
        Err(Error::bad_value(
            format!("stops[{stop}]"),
            "a stop without a normal",
            "at an impact its gap must change with the coordinates and its reaction must push",
        ))
    }
}

/// The normal of a stop and its reaction direction, in the room that a state takes.
pub(super) struct Directions<S>(S);

impl<S: State> Directions<S> {
    /// Normal and reaction.
    pub fn both(&self) -> (&[f64], &[f64]) {
        let x = self.0.slice();
        x.split_at(x.len() / 2)
    }
}

/// `a.b`
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
