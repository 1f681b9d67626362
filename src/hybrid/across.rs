//! First-order deviations from a motion across its events (theory 7, 9): across an impact, whose time depends on them, and across the rest
//! of impacts that accumulate. States are `(q, v)`, deviations columns of such.
//!
//! Where a stop is held after an impact with e = 0, f+ is the rate of the held motion. At a release the rates before and after agree, its
//! contact force being zero, and nothing happens to deviations. The rest of impacts that accumulate has the Jacobian of its map, between
//! fixed times: `dx* - f_held dt*` (`chatter_map.rs`).

use crate::error::Result;
use crate::hybrid::chatter_map::finish;
use crate::hybrid::maps::HybridMaps;
use crate::hybrid::scaled_units::ScaledUnits;
use crate::hybrid::timed::Timed;
use crate::impact::{GapRate, saltation};
use crate::law::{Regime, Relaxation, Transition};
use nalgebra::{DMatrix, DVector, RowDVector};

/// The rest of impacts that accumulate on a stop, on a state before the first of them and on deviations from it, from the regime that lasts
/// between them to the one after them; in a motion of some units.
pub(crate) fn across_rest<M: HybridMaps + ?Sized>(
    motion: &M,
    (stop, [lasting, after]): (usize, [&Regime; 2]),
    units: &ScaledUnits,
    time: f64,
    (state, deviations): (&mut DVector<f64>, &mut DMatrix<f64>),
) -> Result<()> {
    let at = motion.gap(stop, time, state)?;
    let rate = motion.rate(lasting, time, state)?;
    let speed = at.speed(rate.rows(0, at.gradient.len()));
    let delays = at.deviations(deviations) / -speed;
    let mut y = Timed {
        time,
        state: state.clone(),
        deviations: &*deviations + rate * delays.transpose(),
        delays,
    };
    finish(motion, (stop, lasting), units, &mut y)?;
    let rate = motion.rate(after, y.time, &y.state)?;
    *deviations = y.deviations - rate * y.delays.transpose();
    *state = y.state;
    Ok(())
}

/// One impact: the stop that is reached, the stops that receive an impulse with it, none of one that gives way, the regimes before and after.
struct ImpactAt<'a> {
    gap_of: usize,
    struck: &'a [usize],
    regimes: (&'a Regime, &'a Regime),
    time: f64,
}

/// A transition at a time, between two regimes, on a state and on deviations from it; `order` are the stops that are reached, in the order of
/// their impacts.
pub(crate) fn across<M: HybridMaps + ?Sized>(
    motion: &M,
    (transition, order): (&Transition, &[usize]),
    at: ((&Regime, &Regime), f64),
    state: &mut DVector<f64>,
    deviations: &mut DMatrix<f64>,
) -> Result<()> {
    if let Transition::Change(guard, _) = *transition {
        // A force may jump with its gap (theory 22); where the force itself is zero nothing does.
        let (regimes, time) = at;
        let own = ImpactAt {
            gap_of: guard.element,
            struck: &[],
            regimes,
            time,
        };
        return if guard.is_gap() {
            across_impact(motion, &own, state, deviations)
        } else {
            Ok(())
        };
    }
    across_impacts(motion, (transition.struck(), order), at, state, deviations)
}

/// The impacts of the stops that receive an impulse at a time, one after the other, on a state and on deviations from it. Between the regimes
/// before the first and after the last all is free. If fewer stops are reached than receive an impulse each impact is on all of them.
pub(crate) fn across_impacts<M: HybridMaps + ?Sized>(
    motion: &M,
    (struck, order): (&[usize], &[usize]),
    ((mut before, last), time): ((&Regime, &Regime), f64),
    state: &mut DVector<f64>,
    deviations: &mut DMatrix<f64>,
) -> Result<()> {
    let is_joint = struck.len() > order.len();
    for (i, stop) in order.iter().enumerate() {
        let is_last = i + 1 == order.len();
        let after = if is_last { last } else { Regime::free() };
        let own = ImpactAt {
            gap_of: *stop,
            struck: if is_joint {
                struck
            } else {
                std::slice::from_ref(stop)
            },
            regimes: (before, after),
            time,
        };
        across_impact(motion, &own, state, deviations)?;
        before = after;
    }
    Ok(())
}

/// The deviations of the place at which an element is left to relax, from those of the state before that instant: where an impact ends its
/// force the two have different speeds, and the `delays` of the impact count.
pub(crate) fn place_left<M: HybridMaps + ?Sized>(
    motion: &M,
    (element, relaxation): (usize, Relaxation),
    (time, state): (f64, &DVector<f64>),
    (deviations, delays): (&DMatrix<f64>, Option<&RowDVector<f64>>),
) -> Result<RowDVector<f64>> {
    let at = motion.gap(element, time, state)?;
    let n = at.gradient.len();
    let mut place = -at.gradient.tr_mul(&deviations.rows(0, n));
    if let Some(delays) = delays {
        place -= delays * (at.speed(state.rows(n, n)) + relaxation.speed(-at.gap));
    }
    Ok(place)
}

/// The delays of an instant at which the gap of a stop closes in a regime, by the deviations of the state before it.
pub(crate) fn closing_delays<M: HybridMaps + ?Sized>(
    motion: &M,
    (stop, before): (usize, &Regime),
    (time, state): (f64, &DVector<f64>),
    deviations: &DMatrix<f64>,
) -> Result<RowDVector<f64>> {
    let at = motion.gap(stop, time, state)?;
    let n = at.gradient.len();
    let speed = at.speed(motion.rate(before, time, state)?.rows(0, n));
    Ok(at.gradient.tr_mul(&deviations.rows(0, n)) / -speed)
}

/// The instant at which an element that relaxes is met, on deviations from a state, with those of its place (theory 22): its guard is `r - p`.
pub(crate) fn across_meeting<M: HybridMaps + ?Sized>(
    motion: &M,
    (element, relaxation): (usize, Relaxation),
    ((before, after), time): ((&Regime, &Regime), f64),
    state: &DVector<f64>,
    (deviations, place): (&mut DMatrix<f64>, &RowDVector<f64>),
) -> Result<()> {
    let at = motion.gap(element, time, state)?;
    let [from, to] = [
        motion.rate(before, time, state)?,
        motion.rate(after, time, state)?,
    ];
    let n = at.gradient.len();
    let closing = relaxation.speed(-at.gap) + at.speed(from.rows(0, n));
    let own = at.gradient.tr_mul(&deviations.rows(0, n)) + place;
    *deviations += (to - from) * own / closing;
    Ok(())
}

/// The impact of one stop, while all are free, on a state and on deviations from it.
pub(crate) fn across_free_impact<M: HybridMaps + ?Sized>(
    motion: &M,
    (stop, time): (usize, f64),
    state: &mut DVector<f64>,
    deviations: &mut DMatrix<f64>,
) -> Result<()> {
    let own = ImpactAt {
        gap_of: stop,
        struck: &[stop],
        regimes: (Regime::free(), Regime::free()),
        time,
    };
    across_impact(motion, &own, state, deviations)
}

/// The impact on a state and on deviations from it.
fn across_impact<M: HybridMaps + ?Sized>(
    motion: &M,
    instant: &ImpactAt<'_>,
    state: &mut DVector<f64>,
    deviations: &mut DMatrix<f64>,
) -> Result<()> {
    let at = motion.gap(instant.gap_of, instant.time, state)?;
    let before = motion.rate(instant.regimes.0, instant.time, state)?;
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
        let mut slip = motion.rate(instant.regimes.1, instant.time, state)? - columns.column(count);
        if let Some(recoil) = &recoil {
            slip -= recoil;
        }
        *deviations = columns.remove_column(count);
        Ok(slip)
    };
    saltation(closing, reset, deviations)
}
