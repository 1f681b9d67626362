//! Contacts along one step: the first one on the quintics of the gaps, or by the bounds on their curvature (`certify.rs`).

use super::scene::Integrated;
use crate::error::Result;
use crate::event::certified::SearchFailure;
use crate::event::first_root::{FirstEvent, FirstRoot};
use crate::event::polynomial::{EndValues, Judgement, Quintic};
use crate::event::probed::{Probed, STEP_PROBES};

use crate::flow::steps::{DenseOutput, State, Stepper};
use crate::hybrid::segment::Graze;
use crate::hybrid::system::Gaps;
use crate::model::{Dynamics, GapValue, Surface};
use crate::tolerance::{FAR_QUINTIC_TURN, QUINTIC_TURN, SAME_TOUCH, TERM_ROUNDINGS};

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// The earliest contact along the step last taken, as a part of the step, or before it a place that cannot be told from one, for
    /// which the step may be shortened if it may; touches before that are noted.
    #[allow(
        clippy::inline_always,
        reason = "the innermost loop of flights with and without stops held"
    )]
    #[inline(always)]
    pub(super) fn contact_along<E: Dynamics, const IS_HELD: bool>(
        &mut self,
        dynamics: &E,
        orders: Option<&[usize]>,
        (h, may_shorten): (f64, bool),
    ) -> Result<FirstEvent> {
        let mut first = FirstEvent::NONE;
        let noted = self.grazes.len();
        self.sought.clear();
        self.doubt = None;
        for stop in 0..self.contacts.len() {
            if IS_HELD && (self.is_unwatched[stop] || self.stays_outside(stop, h)) {
                continue;
            }
            let (start, end) = (self.gaps[stop], self.ahead[stop]);
            let known = |g: GapValue| [g.gap, g.speed, g.acceleration];
            let order = orders.map_or(0, |orders| orders[stop]);
            let mut ends = [known(start), known(end)];
            ends[1][0] -= self.departed(stop, order);
            let ends = EndValues::new(ends[0], ends[1], h, order);
            // The error of the interpolation is of the size of the step's tolerance, a tenth of the margin.
            let margin = self.margin_of(start).max(self.margin_of(end));
            let is_clear = if P::HAS_QUINTIC {
                ends.are_clear(order, 2.0 * margin)
            } else {
                order == 0 && ends.are_far(2.0 * margin)
            };
            if is_clear && !self.says_little(stop, h) {
                continue;
            }
            let root = self.judge(dynamics, (stop, order), &ends, (margin, may_shorten), h)?;
            first.note(stop, root);
        }
        if !self.sought.is_empty() {
            first = self.certify(dynamics, first, h)?;
        }
        if first.root != FirstRoot::None {
            let time = self.clock.after(first.root.at() * h).time();
            let mut at = 0;
            self.grazes.retain(|graze| {
                at += 1;
                at <= noted || graze.time < time
            });
        }
        Ok(first)
    }

    /// Whether the ends of a step say little of a gap between them: of a nonlinear one, and of a wall before links that turn far where no
    /// error holds the step down.
    #[inline]
    pub(super) fn says_little(&self, stop: usize, h: f64) -> bool {
        let most = if P::HAS_QUINTIC {
            QUINTIC_TURN
        } else {
            FAR_QUINTIC_TURN
        };
        self.bends(stop, h, most)
    }

    /// Whether a gap may bend otherwise than its quintic along the step last taken, of which the angles of links to a wall turn by more than
    /// some.
    #[inline]
    fn bends(&self, stop: usize, h: f64, turn: f64) -> bool {
        match &self.contacts[stop].surface {
            Surface::Plane { .. } => false,
            Surface::Nonlinear(_) => true,
            Surface::Wall { lengths, .. } => self.turns(lengths.len(), h, turn),
        }
    }

    /// Whether the angle of one of the first links turns by more than some along the step last taken; a function of its own, since most
    /// stops are planes.
    #[inline(never)]
    fn turns(&self, n_links: usize, h: f64, turn: f64) -> bool {
        let ends = [self.x.slice(), self.stepper.end().slice()].into_iter();
        let mut speeds = ends.flat_map(|x| x.iter().skip(self.n()).take(n_links));
        speeds.any(|v| (h * v).abs() > turn)
    }

    /// What a gap that is not clear at once does along the step last taken; one that is to be searched by its curvature nothing, yet.
    #[inline(never)]
    fn judge<E: Dynamics>(
        &mut self,
        dynamics: &E,
        (stop, order): (usize, usize),
        ends: &EndValues,
        doubtful: (f64, bool),
        h: f64,
    ) -> Result<FirstRoot> {
        let surface = &self.contacts[stop].surface;
        let is_nonlinear = surface.is_nonlinear();
        let is_bounded = surface.curvature().is_some();
        if is_bounded && self.bends(stop, h, QUINTIC_TURN) {
            self.sought.push((stop, order));
            return Ok(FirstRoot::None);
        }
        let quintic = Quintic::new(ends);
        let size = self.gaps[stop].size.max(self.ahead[stop].size);
        let judgement = Judgement {
            rounding: TERM_ROUNDINGS * size,
            error: self.interpolation_error(dynamics, stop, &quintic, h)?,
        };
        self.touches.clear();
        let along = quintic.first_contact(order, judgement, &mut self.touches);
        self.note_touches(stop, h);
        let along = if self.is_late((stop, order), along, &quintic, size) {
            FirstRoot::None
        } else {
            along
        };
        if is_nonlinear {
            return self.probed(dynamics, (stop, order), (along, &quintic), doubtful, h);
        }
        Ok(along)
    }

    /// Whether a stop that a flight left so slowly that a quintic does not tell stays within the tolerance.
    fn is_late(
        &self,
        (stop, order): (usize, usize),
        along: FirstRoot,
        quintic: &Quintic,
        size: f64,
    ) -> bool {
        let is_near = |x: f64| quintic.value(x).abs() <= self.tolerance(stop, size);
        let is_undecided = matches!(along, FirstRoot::Undecided { .. });
        order > 0 && is_undecided && [0.0, 0.5, 1.0].into_iter().all(is_near)
    }

    /// What the quintic of a nonlinear gap of which no curvature is known says of the step last taken, put right by the gap itself at
    /// some places: a step along which the two differ is too long, and a place where the stop is passed has a contact before it.
    fn probed<E: Dynamics>(
        &mut self,
        dynamics: &E,
        (stop, order): (usize, usize),
        (along, quintic): (FirstRoot, &Quintic),
        (margin, may_shorten): (f64, bool),
        h: f64,
    ) -> Result<FirstRoot> {
        let path = self.step_path(dynamics, h)?;
        let (begun, departed) = (self.moment(), self.departed(stop, order));
        let watched = self.watched_now(stop);
        let mut probed = Probed([0.0; STEP_PROBES.len()]);
        for (gap, x) in probed.0.iter_mut().zip(STEP_PROBES) {
            let q = path.about(x).position();
            let value = self.contacts[stop].gap(&q, begun.after(x * h))?;
            *gap = watched.at(value, x * h) - departed;
        }
        self.n_gap_evaluations += STEP_PROBES.len();
        if may_shorten && probed.is_unlike(quintic, margin) {
            self.doubt = Some((stop, SearchFailure::Jumps));
            return Ok(FirstRoot::Undecided { at: 0.0 });
        }
        Ok(match probed.passed(margin) {
            Some((open, passed)) if along.at() > passed => FirstRoot::Crossing {
                at: 0.5 * (open + passed),
                passed,
            },
            _ => along,
        })
    }

    /// Notes the touches along the step last taken; one that was noted where the step before ended is the same.
    pub(super) fn note_touches(&mut self, stop: usize, h: f64) {
        if !self.watched_guard(stop).is_clearance() {
            return;
        }
        for &(x, gap) in &self.touches {
            let time = self.clock.after(x * h).time();
            let is_same = |g: &Graze| g.stop == stop && (time - g.time).abs() <= SAME_TOUCH * h;
            if !self.grazes.iter().any(is_same) {
                let depth = -gap;
                self.grazes.push(Graze { time, stop, depth });
            }
        }
    }

    /// The difference of the quintic to the dense output half-way.
    fn interpolation_error<E: Dynamics>(
        &mut self,
        dynamics: &E,
        stop: usize,
        quintic: &Quintic,
        h: f64,
    ) -> Result<f64> {
        let n = self.n();
        let mut x = S::zeros(2 * n);
        let dense = self.dense(dynamics, h)?;
        dense.state(0.5 * h, x.slice_mut());
        self.n_gap_evaluations += 1;
        let half_way = self.moment().after(0.5 * h);
        let there = self.contacts[stop].gap(&x.slice()[..n], half_way)?;
        let there = self.watched_now(stop).at(there, 0.5 * h);
        Ok((there - quintic.value(0.5)).abs())
    }

    /// The gap at the start of a flight that left a stop: rounding, or as deep as the margin where the run began inside the stop. The flight
    /// ends where the gap falls back to that: one that began below zero and stays low never comes above zero to fall through it.
    pub(super) fn departed(&self, stop: usize, order: usize) -> f64 {
        if order > 0 { self.gaps[stop].gap } else { 0.0 }
    }
}
