//! Follows a motion segment after segment with deviations from it: flights, impacts, impacts that accumulate, landings (theory 16). At a
//! release nothing happens to them.

use crate::error::Result;
use crate::exponents::batches::Batches;
use crate::exponents::frame::Frame;
use crate::exponents::tangents::Tangents;
use crate::hybrid::{
    Graze, HybridMaps, Landing, ScaledUnits, across_free_impact, across_impacts, across_rest,
};
use crate::impact::Impact;
use crate::law::Regime;
use crate::observer::unless_broken_off;
use crate::path::Path;
use crate::tolerance::{IMPACT_RATE_MATCH, IMPULSE_ROUNDING, MOST_TANGENT_SPREAD, UNCOUPLED};
use nalgebra::{DMatrix, DVector};

/// Ratio of growths below which pieces of a flight are put together again. [work]
const LEAST_TANGENT_SPREAD: f64 = 1e3;
/// Pieces of a flight beyond which it is cut no further. [work]
const MOST_TANGENT_PIECES: usize = 1 << 20;
/// Pieces between two questions whether to go on. [work]
const PIECES_PER_POLL: usize = 256;

/// Events of a motion that are counted together with the growth of deviations.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Counted {
    pub impacts: usize,
    /// Stops that came to be held.
    pub landings: usize,
    /// Touches, and impacts too slow to have a derivative.
    pub grazes: usize,
    /// Instants at which the order of impacts matters.
    pub clashes: usize,
    /// The sum of `ln e^2` of the impacts.
    pub log_restitution: f64,
}

/// Deviations that are carried along a motion.
pub(crate) struct Follower<T> {
    pub tangents: T,
    pub frame: Frame,
    pub batches: Batches,
    pub counted: Counted,
    /// Impacts since the last segment.
    struck: Vec<Impact>,
    /// The regime of it.
    regime: Regime,
    /// The fastest approach so far.
    fastest: f64,
    /// In how many pieces flights are followed now.
    pieces: usize,
    /// Pieces since the last question.
    asked: usize,
}

impl<T: Tangents> Follower<T> {
    /// A follower of a motion with deviations in k directions.
    pub fn new(tangents: T, frame: Frame, batches: Batches) -> Self {
        Self {
            tangents,
            frame,
            batches,
            counted: Counted::default(),
            struck: Vec::new(),
            regime: Regime::default(),
            fastest: 0.0,
            pieces: 1,
            asked: 0,
        }
    }

    /// Follows the next part of the motion.
    pub fn follow(&mut self, path: &Path, impacts: &[Impact], grazes: &[Graze]) -> Result<()> {
        let mut impacts = impacts.iter().peekable();
        for (k, segment) in path.parts.segments.iter().enumerate() {
            let arcs = &path.parts.arcs[path.parts.arcs_of(k)];
            let (Some(first), Some(last)) = (arcs.first(), arcs.last()) else {
                continue;
            };
            let (start, end) = (first.clock.time(), last.clock.after(last.span).time());
            while let Some(impact) = impacts.next_if(|impact| impact.time <= start) {
                self.struck.push(*impact);
            }
            // Beside stops that are held so little is left of a chatter that it is a landing.
            let rest = segment.accumulation();
            let rest = rest.filter(|&stop| segment.regime.without(stop).is_free());
            let Some(stop) = rest else {
                self.pass_instant(start, &segment.regime)?;
                let range = path.parts.arcs_of(k);
                for arcs in T::spans(range) {
                    let (first, last) = (path.arc(arcs.start), path.arc(arcs.end - 1));
                    self.tangents.read(path, arcs.start);
                    let end = last.clock.after(last.span).time();
                    self.fly(&segment.regime, (first.clock.time(), end))?;
                    self.tangents.arrive(path, arcs.end - 1);
                }
                continue;
            };
            if end > start {
                self.pass_instant(start, Regime::free())?;
                self.complete((stop, &segment.regime), start)?;
            }
        }
        self.struck.extend(impacts);
        let since = self.batches.start();
        self.counted.grazes += grazes.iter().filter(|graze| graze.time >= since).count();
        Ok(())
    }

    /// Ends the motion at a time.
    pub fn finish(&mut self, end: f64) -> Result<()> {
        self.pass_instant(end, Regime::free())?;
        self.pass_marks(end, Regime::free())
    }

    /// Goes along a flight in a regime, from one end of a batch to the next.
    fn fly(&mut self, regime: &Regime, (mut start, end): (f64, f64)) -> Result<()> {
        loop {
            self.pass_marks(start, regime)?;
            let to = end.min(self.batches.next_mark());
            if !(self.frame.is_empty() && self.batches.has_begun()) {
                self.fly_between(regime, (start, to))?;
            }
            start = to;
            if to >= end {
                return Ok(());
            }
        }
    }

    /// Ends the batches that end by a time, in a regime.
    fn pass_marks(&mut self, t: f64, regime: &Regime) -> Result<()> {
        while self.batches.next_mark() <= t {
            if self.batches.has_begun() {
                let growth = self.frame.growth();
                self.batches.pass(&growth);
            } else {
                self.batches.begin();
                self.frame.begin_anew();
                // Deviations that would leave the stops that are held are taken away from the beginning.
                if !regime.is_free() {
                    self.land(t, regime, regime.n_new_constraints(Regime::free()))?;
                }
            }
        }
        Ok(())
    }

    /// Goes on in pieces so short that every direction keeps its digits.
    fn fly_between(&mut self, regime: &Regime, (start, end): (f64, f64)) -> Result<()> {
        let before = (self.frame.clone(), self.tangents.state().clone());
        loop {
            let length = (end - start) / self.pieces as f64;
            let at = |piece: usize| start + length * piece as f64;
            let mut spread = 1.0f64;
            for piece in 0..self.pieces {
                self.ask()?;
                let to = if piece + 1 == self.pieces {
                    end
                } else {
                    at(piece + 1)
                };
                self.tangents
                    .fly(regime, (at(piece), to), &mut self.frame.columns)?;
                spread = spread.max(self.frame.orthonormalise());
                if spread > MOST_TANGENT_SPREAD {
                    break;
                }
            }
            if spread <= MOST_TANGENT_SPREAD
                || start + 0.5 * length <= start
                || self.pieces > MOST_TANGENT_PIECES
            {
                if spread < LEAST_TANGENT_SPREAD {
                    self.pieces = self.pieces.div_ceil(2);
                }
                return Ok(());
            }
            self.pieces *= 2;
            self.frame.clone_from(&before.0);
            self.tangents.state().clone_from(&before.1);
        }
    }

    /// Whether to go on.
    fn ask(&mut self) -> Result<()> {
        self.asked += 1;
        if self.asked.is_multiple_of(PIECES_PER_POLL) {
            unless_broken_off()?;
        }
        Ok(())
    }

    /// Passes the impacts and landings between two segments, to the regime of the second one.
    fn pass_instant(&mut self, t: f64, regime: &Regime) -> Result<()> {
        if !self.struck.is_empty() {
            let struck = std::mem::take(&mut self.struck);
            self.strike(&struck, t, regime)?;
            self.struck = struck;
            self.struck.clear();
        }
        let landed = regime.n_new_constraints(&self.regime);
        if landed > 0 {
            self.land(t, regime, landed)?;
        }
        self.regime.clone_from(regime);
        Ok(())
    }

    /// The impacts of an instant, in their order.
    fn strike(&mut self, struck: &[Impact], t: f64, regime: &Regime) -> Result<()> {
        let maps = self.tangents.maps();
        let is_dead = struck
            .iter()
            .any(|impact| maps.law(impact.stop).is_inelastic());
        let squares = struck
            .iter()
            .map(|impact| 2.0 * maps.law(impact.stop).restitution.ln());
        let log_restitution: f64 = squares.sum();
        if self.batches.has_begun() {
            self.counted.impacts += struck.len();
            self.counted.log_restitution += log_restitution;
        }
        let fastest = struck.iter().map(|impact| impact.approach);
        self.fastest = fastest.fold(self.fastest, f64::max);
        if self.frame.is_empty() {
            return Ok(());
        }
        let is_slow = |impact: &Impact| impact.approach <= IMPULSE_ROUNDING * self.fastest;
        if struck.iter().any(is_slow) {
            self.counted.grazes += usize::from(self.batches.has_begun());
            return Ok(());
        }
        let alone = match struck {
            [impact] if regime.is_free() && self.regime.is_free() => Some(impact.stop),
            _ => None,
        };
        match alone {
            Some(stop) => self.tangents.strike(stop, t, &mut self.frame.columns)?,
            None => self.strike_several(struck, t, regime)?,
        }
        if is_dead {
            self.frame.collapse(self.frame.columns.nrows() - 1);
        } else if alone.is_some() {
            self.frame.orthonormalise_of(log_restitution);
        } else {
            self.frame.orthonormalise();
        }
        Ok(())
    }

    /// Impacts of several stops, or beside stops held.
    fn strike_several(&mut self, struck: &[Impact], t: f64, regime: &Regime) -> Result<()> {
        let before = &self.regime;
        let stops: Vec<usize> = struck.iter().map(|impact| impact.stop).collect();
        let is_clash = self
            .tangents
            .physically(&mut self.frame.columns, |maps, state, own| {
                let hit: Vec<usize> = (stops.iter().copied())
                    .filter(|&stop| before.leaves_free(stop))
                    .collect();
                let order = ImpactOrder::of(maps, &hit, t, state)?;
                let is_joint = order == ImpactOrder::Coupled || hit.len() < stops.len();
                let rounds: Vec<usize> = if is_joint {
                    hit.first().or(stops.first()).copied().into_iter().collect()
                } else {
                    hit
                };
                let at = ((before, regime), t);
                across_impacts(maps, (&stops, &rounds), at, state, own)?;
                Ok(order != ImpactOrder::Free)
            })?;
        self.counted.clashes += usize::from(is_clash && self.batches.has_begun());
        Ok(())
    }

    /// The rest of impacts that accumulate, from a time on, to a regime that holds their stop.
    fn complete(&mut self, (stop, regime): (usize, &Regime), t: f64) -> Result<()> {
        if self.frame.is_empty() {
            self.counted.landings += usize::from(self.batches.has_begun());
        } else {
            let columns = &mut self.frame.columns;
            self.tangents.physically(columns, |maps, state, own| {
                let units = ScaledUnits::of_state(state, &maps.rate(Regime::free(), t, state)?);
                across_rest(maps, (stop, regime), &units, t, (state, own))
            })?;
            self.land(t, regime, 1)?;
        }
        self.regime.clone_from(regime);
        Ok(())
    }

    /// A regime holds stops from now on: what would leave them is gone, along their reactions.
    fn land(&mut self, t: f64, regime: &Regime, landed: usize) -> Result<()> {
        self.counted.landings += if self.batches.has_begun() { landed } else { 0 };
        if self.frame.is_empty() {
            return Ok(());
        }
        let columns = &mut self.frame.columns;
        let gone = self.tangents.physically(columns, |maps, state, own| {
            let landing = Landing::new(maps, regime, t, state)?;
            landing.take(own);
            Ok(landing.n_lost_directions())
        })?;
        self.frame
            .collapse(self.frame.columns.nrows().saturating_sub(gone));
        Ok(())
    }
}

/// Whether the order of impacts on several stops at one instant matters to deviations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ImpactOrder {
    /// It does not matter.
    Free,
    /// An impact on one changes the speed at another: the outcome jumps.
    Coupled,
    /// Each is by itself, but what becomes of deviations depends on it.
    Matters,
}

impl ImpactOrder {
    fn of<M: HybridMaps>(maps: &M, stops: &[usize], t: f64, state: &DVector<f64>) -> Result<Self> {
        let is_coupled = |one: usize, other: usize| -> Result<bool> {
            let (b, at) = (maps.reaction(one, state)?, maps.gap(other, t, state)?);
            let n = at.gradient;
            Ok(b.dot(&n).abs() > UNCOUPLED * b.norm() * n.norm())
        };
        let mut found = Self::Free;
        for (i, &one) in stops.iter().enumerate() {
            for &other in &stops[i + 1..] {
                if is_coupled(one, other)? || is_coupled(other, one)? {
                    return Ok(Self::Coupled);
                }
                let both = |pair: [usize; 2]| -> Result<DMatrix<f64>> {
                    let (mut x, mut own) =
                        (state.clone(), DMatrix::identity(state.len(), state.len()));
                    for stop in pair {
                        across_free_impact(maps, (stop, t), &mut x, &mut own)?;
                    }
                    Ok(own)
                };
                let (first, second) = (both([one, other])?, both([other, one])?);
                if (&first - second).amax() > IMPACT_RATE_MATCH * first.amax() {
                    found = Self::Matters;
                }
            }
        }
        Ok(found)
    }
}
