//! What is measured of a loop: the attributes of its orbit that change smoothly with it, one after the other.

use crate::error::Result;
use crate::hybrid::ScaledUnits;
use crate::model::Scene;
use crate::orbit::{Extremes, Leg, PlaceOnFlight, Shooting, ShootingState, legs, struck_in_order};
use nalgebra::{DMatrix, DVector};
use std::fmt;
use std::ops::Range;

/// What an extreme is of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Quantity {
    Gap(usize),
    Coordinate(usize),
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gap(stop) => write!(f, "the least gap of stop {stop} is reached"),
            Self::Coordinate(i) => write!(f, "coordinate {i} is farthest from zero"),
        }
    }
}

/// A place at which the loop is measured: by the envelope, an extreme changes as the value where it is.
pub(super) type Mark = (Quantity, PlaceOnFlight);

/// The places of the extremes, in the order in which their orbit comes to them.
pub(super) fn marks(extremes: &Extremes) -> Vec<Mark> {
    let gaps = extremes.gaps.iter().enumerate();
    let gaps =
        gaps.flat_map(|(stop, gap)| gap.places.iter().map(move |p| (Quantity::Gap(stop), *p)));
    let all = extremes.displacements.iter().enumerate();
    let all = all.flat_map(|(i, own)| {
        own.places
            .iter()
            .map(move |p| (Quantity::Coordinate(i), *p))
    });
    let mut marks: Vec<Mark> = gaps.chain(all).collect();
    let order = |(_, place): &Mark| (place.flight, place.part);
    marks.sort_by(|a, b| {
        order(a)
            .partial_cmp(&order(b))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    marks
}

/// Where each attribute stands in what is measured.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    pub n: usize,
    /// Number of impacts.
    pub k: usize,
}

impl Layout {
    /// The phase and the period.
    const NUMBERS: usize = 2;

    pub fn q0(self) -> Range<usize> {
        0..self.n
    }

    pub fn v0(self) -> Range<usize> {
        self.n..2 * self.n
    }

    pub fn phase(self) -> Range<usize> {
        2 * self.n..2 * self.n + 1
    }

    pub fn period(self) -> Range<usize> {
        2 * self.n + 1..2 * self.n + Self::NUMBERS
    }

    pub fn times(self) -> Range<usize> {
        let first = self.period().end;
        first..first + self.k
    }

    pub fn speeds(self) -> Range<usize> {
        let first = self.times().end;
        first..first + self.k
    }

    /// The first of the marks.
    pub fn marks(self) -> usize {
        self.speeds().end
    }
}

/// The attributes of a loop in a scene, as [`Layout`] has them.
pub(super) fn measured(
    (shooting, units): (&Shooting<'_>, &ScaledUnits),
    scene: &Scene,
    state: &ShootingState,
    marks: &[Mark],
) -> Result<Vec<f64>> {
    let ends = shooting.flight_ends(state, units)?;
    let legs = legs(shooting.stages, state, &ends, shooting.motion)?;
    let (instants, _) = struck_in_order(shooting.stages, &ends);
    let zero = legs[0].start;
    let last = &legs[legs.len() - 1];
    let mut all: Vec<f64> = legs[0].after.iter().copied().collect();
    all.push(scene.frequency().unwrap_or(0.0) * zero);
    all.push(state.times[state.times.len() - 1] - state.times[0]);
    let before = [last].into_iter().chain(&legs);
    let struck = legs
        .iter()
        .zip(before)
        .filter(|(leg, _)| leg.mode.is_struck);
    let (mut times, mut speeds) = (Vec::new(), Vec::new());
    for ((leg, before), stops) in struck.zip(&instants) {
        for &stop in stops {
            let x = &before.before_next;
            let at = shooting.motion.gap(stop, before.end, x)?;
            times.push(leg.start - zero);
            speeds.push(-at.speed(x.rows(x.len() / 2, x.len() / 2)));
        }
    }
    all.extend(times);
    all.extend(speeds);
    at_marks(shooting, &legs, marks, &mut all)?;
    Ok(all)
}

/// The values at the marks, each flight followed once.
fn at_marks(
    shooting: &Shooting<'_>,
    legs: &[Leg],
    marks: &[Mark],
    all: &mut Vec<f64>,
) -> Result<()> {
    let mut here: Option<(usize, f64, DVector<f64>)> = None;
    for (quantity, place) in marks {
        let Some(leg) = legs.get(place.flight) else {
            all.push(f64::NAN);
            continue;
        };
        let time = leg.start + place.part * (leg.end - leg.start);
        let (from, mut state) = match here.take() {
            Some((flight, from, state)) if flight == place.flight => (from, state),
            _ => (leg.start, leg.after.clone()),
        };
        if time > from {
            let none = &mut DMatrix::zeros(state.len(), 0);
            shooting
                .motion
                .flow(leg.mode.held(), (from, time), &mut state, none)?;
        }
        all.push(match *quantity {
            Quantity::Gap(stop) => shooting.motion.gap(stop, time, &state)?.gap,
            Quantity::Coordinate(i) => place.sign * state[i],
        });
        here = Some((place.flight, time, state));
    }
    Ok(())
}
