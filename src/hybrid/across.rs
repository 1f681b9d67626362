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
use nalgebra::{DMatrix, DVector};

/// The rest of impacts on a stop, from a time and a state before the first of them, in a motion of some units.
pub(crate) fn across_rest<M: HybridMaps>(
    motion: &M,
    stop: usize,
    units: &ScaledUnits,
    (time, state): (f64, &DVector<f64>),
    deviations: DMatrix<f64>,
) -> Result<Timed> {
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
    finish(motion, stop, units, &mut y)?;
    Ok(y)
}

impl Timed {
    /// The deviations at a fixed time, while some stops are held.
    pub fn held<M: HybridMaps>(self, motion: &M, held: &[usize]) -> Result<DMatrix<f64>> {
        let rate = motion.rate(held, self.time, &self.state)?;
        Ok(self.deviations - rate * self.delays.transpose())
    }
}

/// One impact: the stop that is reached, the stops that receive an impulse with it, those held before and after.
pub(crate) struct ImpactAt<'a> {
    pub gap_of: usize,
    pub struck: &'a [usize],
    pub held: (&'a [usize], &'a [usize]),
    pub time: f64,
}

impl<'a> ImpactAt<'a> {
    /// One stop, that of a list of one, while none is held.
    pub fn alone(stop: &'a [usize; 1], time: f64) -> Self {
        Self {
            gap_of: stop[0],
            struck: stop,
            held: (&[], &[]),
            time,
        }
    }
}

/// The impact on a state and on deviations from it.
pub(crate) fn across_impact<M: HybridMaps>(
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
