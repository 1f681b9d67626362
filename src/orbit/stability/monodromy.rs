//! The monodromy matrix of motions that shooting found (theory 7; that of free flights in modes is in `multipliers.rs`): flow Jacobians and saltation matrices, from the flights and impacts as the
//! shooting has them.
//!
//! Where a stop is held behind an impact with e = 0, f+ is the rate of the held motion. At a release the rates before and
//! after agree, its contact force being zero, and the saltation matrix is the identity. The rest of impacts that accumulate has
//! the Jacobian of its map, between fixed times: `dx* - f_held dt*` (`hybrid/chatter_map.rs`).

use crate::error::Result;
use crate::hybrid::chatter_map::{Timed, finish};
use crate::hybrid::{HybridMaps, SegmentKind};
use crate::impact::{GapRate, saltation};
use crate::orbit::contact_mode::ContactMode;
use nalgebra::{DMatrix, DVector};

/// One flight: its start, its end and its first state.
#[derive(Debug)]
pub(crate) struct Flown<'a> {
    pub start: f64,
    pub end: f64,
    pub state: DVector<f64>,
    pub mode: &'a ContactMode,
}

/// The product over one period from just after the first instant, in (q, v). `order` has the stops of each instant one after
/// the other, but those held before it; `pattern` has all of them.
pub(crate) fn monodromy<M: HybridMaps>(
    motion: &M,
    pattern: &[Vec<usize>],
    order: &[Vec<usize>],
    flights: &[Flown<'_>],
) -> Result<DMatrix<f64>> {
    let len = flights.first().map_or(0, |flight| flight.state.len());
    let mut deviations = DMatrix::identity(len, len);
    let (mut instant, mut before) = (0, DVector::zeros(len));
    let sizes = flights.iter().map(|flight| flight.state.amax());
    let size = sizes.fold(0.0, f64::max);
    for (k, flight) in flights.iter().enumerate() {
        let next = flights[(k + 1) % flights.len()].mode;
        let mode = flight.mode;
        if mode.kind == SegmentKind::Chatter {
            let from = (flight.start, &before);
            let stops = (mode.stops[0], next.held());
            deviations = finished(motion, stops, size, from, deviations)?;
            continue;
        }
        let held = mode.held();
        before.clone_from(&flight.state);
        motion.flow(
            held,
            (flight.start, flight.end),
            &mut before,
            &mut deviations,
        )?;
        if !next.is_struck || pattern.is_empty() {
            continue;
        }
        instant = (instant + 1) % pattern.len();
        let (all, ordered) = (&pattern[instant], &order[instant]);
        let is_joint = all.len() > ordered.len();
        let mut rates_from = held;
        for (i, &stop) in ordered.iter().enumerate() {
            let is_last = i + 1 == ordered.len();
            let after: &[usize] = if is_last { next.held() } else { &[] };
            let single = [stop];
            let struck: &[usize] = if is_joint { all } else { &single };
            let salted = ImpactAt {
                gap_of: stop,
                struck,
                held: (rates_from, after),
                time: flight.end,
            };
            salt(motion, &salted, &mut before, &mut deviations)?;
            rates_from = after;
        }
    }
    Ok(deviations)
}

/// The rest of impacts on a stop, between fixed times.
fn finished<M: HybridMaps>(
    motion: &M,
    (stop, held): (usize, &[usize]),
    size: f64,
    (time, state): (f64, &DVector<f64>),
    deviations: DMatrix<f64>,
) -> Result<DMatrix<f64>> {
    let at = motion.gap(stop, time, state)?;
    let rate = motion.rate(&[], time, state)?;
    let speed = at.speed(rate.rows(0, at.gradient.len()));
    let delays = at.deviations(&deviations) / -speed;
    let mut y = Timed {
        time,
        state: state.clone(),
        deviations: deviations + rate * delays.transpose(),
        delays,
    };
    finish(motion, stop, size, &mut y)?;
    let rate = motion.rate(held, y.time, &y.state)?;
    Ok(y.deviations - rate * y.delays.transpose())
}

/// One impact: the stop that is reached, the stops that receive an impulse with it, those held before and after.
struct ImpactAt<'a> {
    gap_of: usize,
    struck: &'a [usize],
    held: (&'a [usize], &'a [usize]),
    time: f64,
}

/// The impact on a state and on deviations from it.
fn salt<M: HybridMaps>(
    motion: &M,
    instant: &ImpactAt<'_>,
    state: &mut DVector<f64>,
    deviations: &mut DMatrix<f64>,
) -> Result<()> {
    let at = motion.gap(instant.gap_of, instant.time, state)?;
    let before = motion.rate(instant.held.0, instant.time, state)?;
    let recoil = motion.recoil(instant.struck, instant.time, state)?;
    let (mut dh, n) = (DVector::zeros(before.len()), at.gradient.len());
    dh.rows_mut(0, n).copy_from(&at.gradient);
    let closing = GapRate {
        by_state: dh.as_view(),
        total: at.speed(before.rows(0, n)),
    };
    let reset = |deviations: &mut DMatrix<f64>| {
        // The rate is carried through the impact beside the deviations.
        let count = deviations.ncols();
        let mut columns = std::mem::take(deviations).insert_column(count, 0.0);
        columns.set_column(count, &before);
        motion.impact(instant.struck, instant.time, state, &mut columns)?;
        let mut slip = motion.rate(instant.held.1, instant.time, state)? - columns.column(count);
        if let Some(recoil) = &recoil {
            slip -= recoil;
        }
        *deviations = columns.remove_column(count);
        Ok(slip)
    };
    saltation(closing, reset, deviations)
}
