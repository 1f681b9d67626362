//! A loop at a value of the parameter, as a point of the curve that a branch is.

use crate::orbit::{PulseTrain, Pulses, ShootingState};
use nalgebra::DVector;
use std::f64::consts::TAU;
use std::sync::Arc;

/// A loop, closed or nearly so, at a value of the parameter.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub value: f64,
    pub state: ShootingState,
    /// The unit of its times: with a forcing they are its angles.
    pub clock: f64,
    /// Of a loop that is followed by its impulses.
    pub impulses: Option<Impulses>,
}

/// The impulses of a loop, and the equations of such loops in its scene.
#[derive(Clone)]
pub(super) struct Impulses {
    pub equations: Arc<Pulses>,
    /// By how much each changes the speed along its stop.
    pub changes: Vec<f64>,
}

impl std::fmt::Debug for Impulses {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.changes.fmt(f)
    }
}

impl Place {
    /// How many unknowns come before the times: the first state, or the impulses.
    pub fn n_before_times(&self) -> usize {
        let impulses = self.impulses.as_ref();
        impulses.map_or(self.state.states[0].len(), |own| own.changes.len())
    }

    /// The equations of a loop that is followed by its impulses, and its train.
    pub fn train(&self) -> (&Pulses, PulseTrain) {
        let own = self.impulses.as_ref();
        let Impulses { equations, changes } = own.expect("the family is followed by impulses");
        let train = PulseTrain {
            times: self.state.times[..changes.len()].to_vec(),
            changes: changes.clone(),
        };
        (equations, train)
    }

    /// The same loop so many turns later.
    pub fn turned(&self, turns: f64) -> Self {
        let mut turned = self.clone();
        let late = turns * TAU * self.clock;
        let ShootingState { times, starts, .. } = &mut turned.state;
        times.iter_mut().chain(starts).for_each(|t| *t += late);
        turned
    }

    /// The flight that takes the least time, of two at least.
    pub fn shortest_flight(&self) -> Option<usize> {
        let times = &self.state.times;
        let count = self.state.states.len();
        let length = |k: usize| times[k + 1] - times[k];
        let shortest = (0..count).min_by(|&a, &b| length(a).total_cmp(&length(b)));
        shortest.filter(|_| count > 1)
    }
}

/// A direction in the scaled unknowns of a branch: those of the loop, and the parameter in parts of its range.
#[derive(Debug, Clone)]
pub(super) struct Direction {
    pub loop_part: DVector<f64>,
    pub value_part: f64,
}

impl Direction {
    /// The product in which a direction has its length: the mean over the unknowns of the loop, so that loops of many instants step alike.
    pub fn dot(&self, other: &Self) -> f64 {
        let count = self.loop_part.len().max(1) as f64;
        self.loop_part.dot(&other.loop_part) / count + self.value_part * other.value_part
    }

    /// Its length.
    pub fn length(&self) -> f64 {
        self.dot(self).sqrt()
    }

    /// The same of length one, or the other way round.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            loop_part: &self.loop_part * factor,
            value_part: self.value_part * factor,
        }
    }

    /// The sum of two.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            loop_part: &self.loop_part + &other.loop_part,
            value_part: self.value_part + other.value_part,
        }
    }

    /// The direction of the parameter alone.
    pub fn of_value(unknowns: usize) -> Self {
        Self {
            loop_part: DVector::zeros(unknowns),
            value_part: 1.0,
        }
    }

    /// The row that is this product with a direction.
    pub fn row(&self) -> DVector<f64> {
        let count = self.loop_part.len().max(1) as f64;
        (&self.loop_part / count).push(self.value_part)
    }

    /// All its numbers, the parameter last.
    pub fn numbers(&self) -> DVector<f64> {
        self.loop_part.clone().push(self.value_part)
    }

    /// The direction of a list of all numbers, the parameter last.
    pub fn of(numbers: &DVector<f64>) -> Self {
        let last = numbers.len() - 1;
        Self {
            loop_part: numbers.rows(0, last).into_owned(),
            value_part: numbers[last],
        }
    }
}
