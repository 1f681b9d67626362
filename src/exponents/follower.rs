//! Follows a motion segment after segment with deviations from it: flights, impacts, impacts that accumulate, landings (theory 16). At a
//! release nothing happens to them.

use crate::error::Result;
use crate::exponents::batches::Batches;
use crate::exponents::frame::{Frame, beyond};
use crate::exponents::places::Places;
use crate::exponents::tangents::Tangents;
use crate::hybrid::{
    Graze, HybridMaps, Landing, ScaledUnits, across_free_impact, across_impacts, across_rest,
    closing_delays,
};
use crate::impact::Impact;
use crate::law::{ElementState, Law, Regime};
use crate::observer::unless_broken_off;
use crate::path::Path;
use crate::tolerance::{IMPACT_RATE_MATCH, IMPULSE_ROUNDING, MOST_TANGENT_SPREAD, UNCOUPLED};
use nalgebra::{DMatrix, DVector, RowDVector};

/// Ratio of growths below which pieces of a flight are put together again. [work]
const LEAST_TANGENT_SPREAD: f64 = 1e3;
/// Pieces of a flight beyond which it is cut no further. [work]
const MOST_TANGENT_PIECES: usize = 1 << 20;
/// Pieces between two questions whether to go on. [work]
const PIECES_PER_POLL: usize = 256;

/// Events of a motion that are counted together with the growth of deviations.
#[derive(Debug, Clone, Default, PartialEq)]
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
    /// For how long each element was pressed, shape (stops,), [s].
    pub pressed: Vec<f64>,
    /// For how long some relaxed \[s\].
    pub relaxing: f64,
}

/// Deviations that are carried along a motion.
pub(crate) struct Follower<'a, T> {
    pub tangents: T,
    /// The directions of the motion, and below them those of the places of elements that relax.
    pub frame: Frame,
    pub batches: Batches,
    pub counted: Counted,
    places: Places<'a>,
    /// Impacts since the last segment.
    struck: Vec<Impact>,
    /// The regime of it; none before the first.
    regime: Option<Regime>,
    /// The fastest approach so far.
    fastest: f64,
    /// In how many pieces flights are followed now.
    pieces: usize,
    /// Pieces since the last question.
    asked: usize,
}

impl<'a, T: Tangents> Follower<'a, T> {
    /// A follower of a motion with deviations in k directions, in a scene with stops of some laws.
    pub fn new(tangents: T, frame: Frame, batches: Batches, laws: Vec<&'a Law>) -> Self {
        Self {
            tangents,
            counted: Counted {
                pressed: vec![0.0; laws.len()],
                ..Counted::default()
            },
            places: Places::below(frame.columns.nrows(), laws),
            frame,
            batches,
            struck: Vec::new(),
            regime: None,
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
            let rest = rest.filter(|&stop| segment.regime.constrained() == [stop]);
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
                let lasting = segment.kind.lasting(&segment.regime);
                self.pass_instant(start, &lasting)?;
                self.complete((stop, [&lasting, &segment.regime]), start)?;
            }
        }
        self.struck.extend(impacts);
        let since = self.batches.start();
        self.counted.grazes += grazes.iter().filter(|graze| graze.time >= since).count();
        Ok(())
    }

    /// Ends the motion at a time.
    pub fn finish(&mut self, end: f64) -> Result<()> {
        let last = self.regime.as_ref().unwrap_or(Regime::free());
        let free = last.holding_instead(&[]);
        self.pass_instant(end, &free)?;
        self.pass_marks(end, &free)
    }

    /// Goes along a flight in a regime, from one end of a batch to the next.
    fn fly(&mut self, regime: &Regime, (mut start, end): (f64, f64)) -> Result<()> {
        loop {
            self.pass_marks(start, regime)?;
            let to = end.min(self.batches.next_mark());
            if self.batches.has_begun() {
                self.count_contacts(regime, to - start);
            }
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
                if !regime.constrained().is_empty() {
                    self.land(t, regime, regime.n_new_constraints(Regime::free()))?;
                }
            }
        }
        Ok(())
    }

    /// Counts for how long elements that give way are in contact.
    fn count_contacts(&mut self, regime: &Regime, span: f64) {
        for element in regime.pressed() {
            self.counted.pressed[element] += span;
        }
        if regime.in_state(ElementState::Relaxing).next().is_some() {
            self.counted.relaxing += span;
        }
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
                let span = (at(piece), to);
                let columns = &mut self.frame.columns;
                (self.places).beside(columns, |own| self.tangents.fly(regime, span, own))?;
                self.places.relax(columns, to - at(piece));
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

    /// Passes the impacts, changes of elements that give way and landings between two segments, to the regime of the second one. Elements
    /// that give way are in their states from the beginning.
    fn pass_instant(&mut self, t: f64, regime: &Regime) -> Result<()> {
        let begun = || regime.holding_instead(&[]);
        let before = self.regime.take().unwrap_or_else(begun);
        if self.struck.is_empty() {
            self.change((&before, regime), t)?;
            self.fit_places((regime, t), None)?;
        } else {
            let struck = std::mem::take(&mut self.struck);
            let delays = self.delays_of((&before, regime), &struck, t)?;
            self.fit_places((regime, t), delays.as_ref())?;
            self.strike(&struck, t, (&before, regime))?;
            self.struck = struck;
            self.struck.clear();
        }
        let landed = regime.n_new_constraints(&before);
        if landed > 0 {
            self.land(t, regime, landed)?;
        }
        self.regime = Some(regime.clone());
        Ok(())
    }

    /// The rows of places that are those of a regime, from the state at an instant on that has its `delays`.
    fn fit_places(&mut self, at: (&Regime, f64), delays: Option<&RowDVector<f64>>) -> Result<()> {
        let own = (&mut self.tangents, &mut self.frame);
        self.places.fit(at, own, delays)
    }

    /// Passes an instant at which elements that give way change their states. What each does to deviations does not depend on their order.
    fn change(&mut self, (before, after): (&Regime, &Regime), t: f64) -> Result<()> {
        let changes = self.places.changes((before, after));
        if changes.is_empty() || self.frame.is_empty() {
            return Ok(());
        }
        let mut from = before.clone();
        for (k, change) in changes.iter().enumerate() {
            let to = if k + 1 == changes.len() {
                after.clone()
            } else {
                from.with(change.element, change.to)
            };
            let own = (&mut self.tangents, &mut self.frame.columns);
            let at = ((&from, &to), t);
            let is_smooth = self.places.pass(*change, at, own, &mut self.fastest)?;
            self.counted.grazes += usize::from(!is_smooth && self.batches.has_begun());
            from = to;
        }
        self.frame.orthonormalise();
        Ok(())
    }

    /// The delays of an impact that ends the forces of elements, which relax from then on. Where other guards of elements that give way are
    /// zero besides, or several stops are hit, their order matters.
    fn delays_of(
        &mut self,
        regimes: (&Regime, &Regime),
        struck: &[Impact],
        t: f64,
    ) -> Result<Option<RowDVector<f64>>> {
        let changes = self.places.changes(regimes);
        if changes.is_empty() {
            return Ok(None);
        }
        let (before, _) = regimes;
        let is_alone = struck.len() == 1 && before.leaves_free(struck[0].stop);
        let is_apart = is_alone && changes.iter().all(|change| !change.jumps());
        self.counted.clashes += usize::from(!is_apart && self.batches.has_begun());
        let own = (struck[0].stop, before);
        let delays =
            self.physically(|maps, state, columns| closing_delays(maps, own, (t, state), columns))?;
        Ok(Some(delays))
    }

    /// The impacts of an instant, in their order, from a regime to another one.
    fn strike(
        &mut self,
        struck: &[Impact],
        t: f64,
        (before, regime): (&Regime, &Regime),
    ) -> Result<()> {
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
            [impact] if regime.is_free() && before.is_free() => Some(impact.stop),
            _ => None,
        };
        match alone {
            Some(stop) => self.tangents.strike(stop, t, &mut self.frame.columns)?,
            None => self.strike_several(struck, t, (before, regime))?,
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
    fn strike_several(
        &mut self,
        struck: &[Impact],
        t: f64,
        (before, regime): (&Regime, &Regime),
    ) -> Result<()> {
        let stops: Vec<usize> = struck.iter().map(|impact| impact.stop).collect();
        let is_clash = self.physically(|maps, state, own| {
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

    /// The rest of impacts that accumulate, from a time on, to a regime that holds their stop. Which directions that takes away is told before:
    /// in what it leaves of those that accumulated impacts have shrunk there is its error.
    fn complete(&mut self, (stop, regimes): (usize, [&Regime; 2]), t: f64) -> Result<()> {
        let [lasting, regime] = regimes;
        self.counted.landings += usize::from(self.batches.has_begun());
        self.regime = Some(regime.clone());
        if self.frame.is_empty() {
            return Ok(());
        }
        let places = self.places.taken(&mut self.frame.columns);
        let columns = &mut self.frame.columns;
        let (mut at_once, lost) = self.tangents.physically(columns, |maps, state, own| {
            let (mut at_once, landing) = (own.clone(), Landing::new(maps, regime, t, state)?);
            landing.take(&mut at_once);
            let units = ScaledUnits::of_state(state, &maps.rate(lasting, t, state)?);
            across_rest(maps, (stop, regimes), &units, t, (state, own))?;
            Ok((at_once, landing.n_lost_directions()))
        })?;
        for columns in [&mut self.frame.columns, &mut at_once] {
            self.places.put(columns, &places);
        }
        let gone = beyond(&at_once, at_once.nrows().saturating_sub(lost));
        self.leave(t, regime)?;
        self.frame.collapse_without(&gone);
        Ok(())
    }

    /// A regime holds stops from now on: what would leave them is gone, along their reactions.
    fn land(&mut self, t: f64, regime: &Regime, landed: usize) -> Result<()> {
        self.counted.landings += if self.batches.has_begun() { landed } else { 0 };
        if !self.frame.is_empty() {
            let lost = self.leave(t, regime)?;
            self.frame
                .collapse(self.frame.columns.nrows().saturating_sub(lost));
        }
        Ok(())
    }

    /// Takes away what would leave the stops that a regime holds; the number of directions that are gone.
    fn leave(&mut self, t: f64, regime: &Regime) -> Result<usize> {
        self.physically(|maps, state, own| {
            let landing = Landing::new(maps, regime, t, state)?;
            landing.take(own);
            Ok(landing.n_lost_directions())
        })
    }

    /// Does something to the state and to deviations from it as position and velocity.
    fn physically<R>(
        &mut self,
        work: impl FnOnce(&T::Maps, &mut DVector<f64>, &mut DMatrix<f64>) -> Result<R>,
    ) -> Result<R> {
        let own = (&mut self.tangents, &mut self.frame.columns);
        self.places.physically(own, work)
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
