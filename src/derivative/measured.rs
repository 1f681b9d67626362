//! The numbers measured of a loop, one after the other: the attributes of its orbit that change smoothly with it. Times in [s], states in [m,
//! m/s], phases in [rad].

use crate::error::Result;
use crate::hybrid::ScaledUnits;
use crate::itinerary::MotionArc;
use crate::model::Scene;
use crate::orbit::{Extremes, PlaceOnFlight, Shooting, ShootingState};
use nalgebra::{DMatrix, DVector};
use std::fmt;
use std::ops::Range;

/// The quantity whose extreme is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ExtremeQuantity {
    Gap(usize),
    Coordinate(usize),
}

impl fmt::Display for ExtremeQuantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gap(stop) => write!(f, "the least gap of stop {stop} is reached"),
            Self::Coordinate(i) => write!(f, "coordinate {i} is farthest from zero"),
        }
    }
}

/// A place at which the loop is measured: by the envelope, an extreme changes as the value where it is.
pub(super) type Mark = (ExtremeQuantity, PlaceOnFlight);

/// The places of the extremes, in the order in which their orbit comes to them.
pub(super) fn marks(extremes: &Extremes) -> Vec<Mark> {
    let gaps = extremes.gaps.iter().enumerate();
    let gaps = gaps.flat_map(|(stop, gap)| {
        gap.places
            .iter()
            .map(move |p| (ExtremeQuantity::Gap(stop), *p))
    });
    let all = extremes.displacements.iter().enumerate();
    let all = all.flat_map(|(i, own)| {
        own.places
            .iter()
            .map(move |p| (ExtremeQuantity::Coordinate(i), *p))
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

/// The place of each attribute in the list of measured numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeasurementLayout {
    pub n: usize,
    /// Number of impacts.
    pub k: usize,
}

impl MeasurementLayout {
    /// The numbers of an orbit that are no lists: its phase and its period. [exact]
    const PHASE_AND_PERIOD: usize = 2;

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
        2 * self.n + 1..2 * self.n + Self::PHASE_AND_PERIOD
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

/// The attributes of a loop in a scene, as [`MeasurementLayout`] has them.
pub(super) fn measured(
    (shooting, units): (&Shooting<'_>, &ScaledUnits),
    scene: &Scene,
    state: &ShootingState,
    marks: &[Mark],
) -> Result<Vec<f64>> {
    let ends = shooting.flight_ends(state, units)?;
    let flights = state.arcs(shooting.stages, &ends, shooting.motion)?;
    let zero = flights[0].start;
    let last = &flights[flights.len() - 1];
    let mut all: Vec<f64> = flights[0].after.iter().copied().collect();
    all.push(scene.frequency().unwrap_or(0.0) * zero);
    all.push(state.times[state.times.len() - 1] - state.times[0]);
    let before = [last].into_iter().chain(&flights);
    let (mut times, mut speeds) = (Vec::new(), Vec::new());
    for (flight, before) in flights.iter().zip(before) {
        for &stop in flight.hits() {
            let x = &before.before_next;
            let at = shooting.motion.gap(stop, before.end, x)?;
            times.push(flight.start - zero);
            speeds.push(-at.speed(x.rows(x.len() / 2, x.len() / 2)));
        }
    }
    all.extend(times);
    all.extend(speeds);
    at_marks(shooting, &flights, marks, &mut all)?;
    Ok(all)
}

/// The values at the marks, each flight followed once.
fn at_marks(
    shooting: &Shooting<'_>,
    flights: &[MotionArc<DVector<f64>>],
    marks: &[Mark],
    all: &mut Vec<f64>,
) -> Result<()> {
    let mut here: Option<(usize, f64, DVector<f64>)> = None;
    for (quantity, place) in marks {
        let Some(flight) = flights.get(place.flight) else {
            all.push(f64::NAN);
            continue;
        };
        let time = flight.start + place.part * (flight.end - flight.start);
        let (from, mut state) = match here.take() {
            Some((flight, from, state)) if flight == place.flight => (from, state),
            _ => (flight.start, flight.after.clone()),
        };
        if time > from {
            let none = &mut DMatrix::zeros(state.len(), 0);
            shooting
                .motion
                .flow(flight.regime(), (from, time), &mut state, none)?;
        }
        all.push(match *quantity {
            ExtremeQuantity::Gap(stop) => shooting.motion.gap(stop, time, &state)?.gap,
            ExtremeQuantity::Coordinate(i) => place.sign * state[i],
        });
        here = Some((place.flight, time, state));
    }
    Ok(())
}
