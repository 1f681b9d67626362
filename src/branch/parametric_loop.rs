//! A point of the curve that a branch is: a motion by its states and times (a loop, closed or nearly so) and a value of the parameter
//! (theory 19). Directions in these unknowns are scaled: by units of the motion, phases of the forcing, and the range of the parameter.

use crate::continuation::ScaledDirection;
use crate::orbit::{PulseTrain, Pulses, ShootingState};
use nalgebra::DVector;
use std::f64::consts::TAU;
use std::sync::Arc;

/// A loop, closed or nearly so, and the value of the parameter that it belongs to.
#[derive(Debug, Clone)]
pub(super) struct ParametricLoop {
    /// The parameter, in its own unit.
    pub value: f64,
    pub state: ShootingState,
    /// The unit of times \[s\]: with a forcing 1 / (its frequency), so that scaled times are phases \[rad\].
    pub clock: f64,
    /// The unknowns of a linear scene of many modes, instead of the first state.
    pub impulses: Option<ImpulseUnknowns>,
}

/// The impulses of a loop as unknowns, and the equations of such loops in its scene (theory 19, "Many modes").
#[derive(Clone)]
pub(super) struct ImpulseUnknowns {
    pub equations: Arc<Pulses>,
    /// By how much each impulse changes the speed along its stop, shape `(n_impacts,)`, \[m/s\].
    pub changes: Vec<f64>,
}

impl std::fmt::Debug for ImpulseUnknowns {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.changes.fmt(f)
    }
}

impl ParametricLoop {
    /// The unknowns that come before the times: the first state, or the impulses.
    pub fn before_times(&self) -> &[f64] {
        match &self.impulses {
            Some(own) => &own.changes,
            None => self.state.states[0].as_slice(),
        }
    }

    /// How many of these are positions; the others are velocities.
    pub fn n_positions(&self) -> usize {
        match &self.impulses {
            Some(_) => 0,
            None => self.state.states[0].len() / 2,
        }
    }

    /// The equations of a loop that is followed by its impulses, and its train.
    pub fn train(&self) -> (&Pulses, PulseTrain) {
        let own = self.impulses.as_ref();
        let ImpulseUnknowns { equations, changes } =
            own.expect("the family is followed by impulses");
        let train = PulseTrain {
            times: self.state.times[..changes.len()].to_vec(),
            changes: changes.clone(),
        };
        (equations, train)
    }

    /// The same loop later by a number of turns of the forcing.
    pub fn turned(&self, turns: f64) -> Self {
        let mut turned = self.clone();
        let late = turns * TAU * self.clock;
        let ShootingState { times, starts, .. } = &mut turned.state;
        times.iter_mut().chain(starts).for_each(|t| *t += late);
        turned
    }

    /// The instant with which the next one coincides, so that its flight takes no time.
    pub fn coinciding_instant(&self) -> Option<usize> {
        let ends = self.state.times.windows(2);
        let mut flights = self.state.starts.iter().zip(ends);
        flights.position(|(start, ends)| !(ends[0] <= *start && *start < ends[1]))
    }

    /// The flight that takes the least time; none if there is only one.
    pub fn shortest_flight(&self) -> Option<usize> {
        let times = &self.state.times;
        let count = self.state.states.len();
        let length = |k: usize| times[k + 1] - times[k];
        let shortest = (0..count).min_by(|&a, &b| length(a).total_cmp(&length(b)));
        shortest.filter(|_| count > 1)
    }
}

/// A direction in the scaled unknowns of a branch \[-\]: those of the loop (first state and times, or impulses and times), and the parameter.
#[derive(Debug, Clone)]
pub(super) struct BranchDirection {
    /// In the unknowns of the loop: positions, velocities and times, or impulses and times; shape `(n_unknowns,)`, \[-\], in units of the
    /// motion's positions, velocities and the clock.
    pub loop_part: DVector<f64>,
    /// In the parameter, in parts of its range \[-\].
    pub value_part: f64,
}

impl BranchDirection {
    /// The direction of the parameter alone.
    pub fn of_value(unknowns: usize) -> Self {
        Self {
            loop_part: DVector::zeros(unknowns),
            value_part: 1.0,
        }
    }

    /// All its numbers, the parameter last.
    pub fn numbers(&self) -> DVector<f64> {
        self.loop_part.clone().push(self.value_part)
    }
}

impl ScaledDirection for BranchDirection {
    fn of(numbers: &DVector<f64>) -> Self {
        let last = numbers.len() - 1;
        Self {
            loop_part: numbers.rows(0, last).into_owned(),
            value_part: numbers[last],
        }
    }

    /// The mean over the unknowns of the loop, so that steps of loops with many instants are as long, plus the product of the parts in
    /// the parameter.
    fn dot(&self, other: &Self) -> f64 {
        let count = self.loop_part.len().max(1) as f64;
        self.loop_part.dot(&other.loop_part) / count + self.value_part * other.value_part
    }

    fn row(&self) -> DVector<f64> {
        let count = self.loop_part.len().max(1) as f64;
        (&self.loop_part / count).push(self.value_part)
    }

    fn scaled(&self, factor: f64) -> Self {
        Self {
            loop_part: &self.loop_part * factor,
            value_part: self.value_part * factor,
        }
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            loop_part: &self.loop_part + &other.loop_part,
            value_part: self.value_part + other.value_part,
        }
    }

    fn unit(&self) -> Self {
        self.scaled(1.0 / self.length())
    }
}
