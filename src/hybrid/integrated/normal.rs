//! Normals and reactions of the stops at the present state of an integrated scene, pushes along them, projection onto stops.

use super::scene::Integrated;
use crate::error::{Error, Result};
use crate::flow::steps::{State, Stepper};
use crate::hybrid::system::{Gaps, NormalMotion, Present};
use crate::impact::{StopsAt, project, put_onto_stops};
use crate::law::Regime;
use crate::model::Dynamics;
use nalgebra::DVector;

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// Moves the present state onto some stops, along their reactions, and takes their normal speeds away.
    pub(super) fn settle(&mut self) -> Result<()> {
        self.settle_in(&self.regime.clone())
    }

    /// The same for another regime.
    pub(super) fn settle_in(&mut self, regime: &Regime) -> Result<()> {
        let stops = regime.constrained();
        if stops.is_empty() {
            return Ok(());
        }
        let (mut q, mut v) = self.physical();
        project(&mut q, &mut v, |q| self.stops_at(stops, q))?;
        self.put(&q, &v);
        Ok(())
    }

    /// Moves the present position onto some stops, along their reactions.
    pub(super) fn move_onto(&mut self, stops: &[usize]) -> Result<()> {
        let (mut q, v) = self.physical();
        put_onto_stops(&mut q, |q| self.stops_at(stops, q))?;
        self.put(&q, &v);
        Ok(())
    }

    /// Makes a position and velocity the present ones.
    fn put(&mut self, q: &DVector<f64>, v: &DVector<f64>) {
        let both = q.iter().chain(v.iter());
        for (x, y) in self.x.slice_mut().iter_mut().zip(both) {
            *x = *y;
        }
        self.is_begun = false;
    }

    /// Size of the terms of what the force of a stop that is pressed does to the acceleration of a gap.
    pub(super) fn push_size(&self, pressed: usize, stop: usize) -> Result<f64> {
        let (law, value) = (self.contacts[pressed].law.by_state(), self.gap(pressed));
        let force = law.force_at(-value.gap, -value.speed);
        let directions = self.directions(pressed)?;
        let normal = self.contacts[stop]
            .surface
            .normal(&self.x.slice()[..self.n()])?;
        let give = dot(normal.as_slice(), directions.both().1);
        Ok(give.abs() * force.size_at(value.size, self.speed_size(pressed)))
    }

    /// Some stops at a position.
    fn stops_at(&self, stops: &[usize], q: &DVector<f64>) -> Result<StopsAt> {
        let (mut gaps, mut speeds) = (Vec::new(), Vec::new());
        let (mut normals, mut reactions) = (Vec::new(), Vec::new());
        for &stop in stops {
            let directions = self.directions_at(stop, q.as_slice())?;
            let (normal, reaction) = directions.both();
            gaps.push(self.contacts[stop].gap(q.as_slice(), self.moment())?);
            speeds.push(self.stop_speed(stop));
            normals.push(DVector::from_column_slice(normal));
            reactions.push(DVector::from_column_slice(reaction));
        }
        Ok(StopsAt {
            gaps: DVector::from_vec(gaps),
            speeds: DVector::from_vec(speeds),
            normals,
            reactions,
        })
    }

    /// The normal of a stop and its reaction direction at a position.
    pub(super) fn directions_at(&self, stop: usize, q: &[f64]) -> Result<Directions<S>> {
        let contact = &self.contacts[stop];
        let mut both = S::zeros(2 * q.len());
        let (normal, reaction) = both.slice_mut().split_at_mut(q.len());
        contact.surface.put_normal(q, normal)?;
        reaction.copy_from_slice(normal);
        let is_regular = contact.turn_to_reaction(self.scene.system(), q, reaction)?;
        let give = dot(normal, reaction);
        if is_regular && give > 0.0 {
            return Ok(Directions { both, give });
        }
        Err(Error::bad_value(
            format!("stops[{stop}]"),
            "a stop without a normal",
            "at an impact its gap must change with the coordinates and its reaction must push",
        ))
    }
}

/// The normal of a stop and its reaction direction, in the room that a state takes.
pub(crate) struct Directions<S> {
    both: S,
    /// `n.b`, above zero.
    pub give: f64,
}

impl<S: State> Directions<S> {
    /// Normal and reaction.
    pub fn both(&self) -> (&[f64], &[f64]) {
        let x = self.both.slice();
        x.split_at(x.len() / 2)
    }
}

/// `a.b`
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
