//! Which impacts count, and how well a computation in doubles can know them: the time of a contact to the rounding of its gap
//! over the approach speed, the speed to that times the acceleration, both carried along impacts that follow each other on one
//! stop. The ends of accumulating impacts, which the library completes once they are no larger than its tolerance, are left out.

use crate::runs::case::Case;
use crate::runs::record::{Hit, Stretch};
use vibroimpact::Method;

/// To what part of its terms a gap is known in doubles: some 16 units of rounding, as theory 8 has it.
pub const GAP_ROUNDING: f64 = 4e-15;
/// Flights lower than this part of the motion are completed whatever the tolerance.
const LOW: f64 = 1e-14;
/// The error of a completion is up to this many times the residual gap (A. Nordmark and P. Piiroinen, Nonlinear Dyn. 58
/// (2009) 85; measured 1 to 2.4 times it), and tolerances are understood to this factor.
const COMPLETED: f64 = 40.0;

pub struct Counting<'a> {
    pub case: &'a Case,
    pub q_unit: f64,
    pub v_unit: f64,
    pub rate: f64,
    /// How far the slowest motion goes, whose terms complex modes add: no place of such a motion is known better than to its rounding.
    pub way: f64,
    /// By how much more than usual impacts beside accumulating ones are left out.
    pub wide: f64,
}

impl Counting<'_> {
    /// The size of a normal.
    pub fn reach(&self, stop: usize) -> f64 {
        self.case.stops[stop].normal.iter().map(|x| x.abs()).sum()
    }

    /// The size of the terms of a gap.
    pub fn size(&self, stop: usize) -> f64 {
        self.case.stops[stop].clearance.abs() + self.reach(stop) * self.q_unit
    }

    /// Times of the span in doubles are known to this.
    pub fn tick(&self) -> f64 {
        4.0 * f64::EPSILON * self.case.span.0.abs().max(self.case.span.1.abs())
    }

    /// Times less apart than this are one.
    pub fn slack(&self) -> f64 {
        1e-9 / self.rate + 2.0 * self.tick()
    }

    /// To what a gap is known.
    pub fn gap_rounding(&self, stop: usize) -> f64 {
        let relative = self.case.by_method(GAP_ROUNDING, self.case.rtol);
        relative * self.size(stop)
    }

    /// The same where the gap is a sum over modes: complex ones lose a digit more.
    fn modal_rounding(&self, stop: usize) -> f64 {
        let lost = if self.case.has_real_modes() {
            1.0
        } else {
            10.0
        };
        lost * self.gap_rounding(stop)
    }

    /// Slower approaches are rounding.
    pub fn speed_floor(&self, stop: usize) -> f64 {
        let relative = self.case.by_method(1e-13, 10.0 * self.case.rtol);
        relative * self.reach(stop) * self.v_unit
    }

    /// To what the time of an impact is known; of one that hardly closes its gap, to the time the gap stays within rounding.
    pub fn time_rounding(&self, hit: &Hit) -> f64 {
        let depth = self.modal_rounding(hit.stop);
        let slow = (2.0 * depth * hit.curvature.abs()).sqrt();
        let floor = if slow.is_finite() { slow } else { 0.0 };
        // An impact that others of the same instant made has no approach of its own.
        let speed = hit.approach.max(hit.departure);
        depth / speed.max(floor).max(self.rate * depth)
    }

    /// How long a series of impacts takes whose first flight is as high as the gap is known to.
    pub fn lowest(&self, hit: &Hit) -> f64 {
        if hit.departure == 0.0 {
            return 0.0;
        }
        let e = (hit.departure / hit.approach).min(1.0);
        let flight = (8.0 * self.modal_rounding(hit.stop) / hit.curvature.abs()).sqrt();
        // Where hardly anything draws the stop back, its acceleration becomes another meanwhile.
        (flight / (1.0 - e)).min(0.1 / self.rate)
    }

    /// Whether the flights that end a series of accumulating impacts, as low as exact gaps are known to, take longer than times may
    /// differ: when it is over is nobody's then, nor what such a motion does later.
    pub fn ends_in_the_dark(&self, chatter: &Stretch, hits: &[Hit]) -> bool {
        let apart = |h: &Hit| (h.time.to_f64() - chatter.start).abs();
        let of_stop = hits.iter().filter(|h| h.stop == chatter.stop);
        let nearest = of_stop.min_by(|g, h| apart(g).total_cmp(&apart(h)));
        let lasts_long = |h: &Hit| self.lowest(h) > 1e-3 / self.rate;
        self.case.method == Method::Exact && nearest.is_some_and(lasts_long)
    }

    /// How long the rest of a geometric series of impacts takes that may be completed here.
    pub fn rest(&self, hit: &Hit) -> Option<f64> {
        self.rest_within(hit, COMPLETED)
    }

    /// Whether an impact belongs to the end of a series, as far as anybody knows: the other run may have completed it before.
    pub fn may_be_completed(&self, hit: &Hit, ends: &[Stretch]) -> bool {
        let time = hit.time.to_f64();
        let near = self.slack() + self.time_rounding(hit);
        let rest = self.rest_within(hit, 10.0 * COMPLETED).unwrap_or(0.0);
        (ends.iter())
            .any(|end| end.stop == hit.stop && (end.start - time).abs() < 3.0 * (rest + near))
    }

    fn rest_within(&self, hit: &Hit, factor: f64) -> Option<f64> {
        let e = hit.departure / hit.approach;
        let a = hit.curvature.abs();
        if e >= 1.0 || a == 0.0 || !a.is_finite() {
            return None;
        }
        let residual = 2.0 * e * hit.approach.powi(2) / ((1.0 - e) * a);
        let limit = factor * self.case.rtol.max(LOW) * self.size(hit.stop);
        let terms = self.size(hit.stop) + self.reach(hit.stop) * self.way;
        let is_low = 0.5 * hit.departure.powi(2) / a <= factor * LOW * terms;
        (residual <= limit || is_low).then_some(2.0 * hit.departure / ((1.0 - e) * a))
    }

    /// Impacts faster than rounding and outside the ends of accumulating ones, in order. Such an end is a chatter of either
    /// run, or the beginning of lasting contact right at an impact that may be completed; the impact it starts with is no row.
    pub fn counted(
        &self,
        hits: &[Hit],
        chatters: &[&[Stretch]],
        sticks: &[&[Stretch]],
    ) -> Vec<Hit> {
        let slack = self.slack();
        let mut until = vec![f64::NEG_INFINITY; self.case.stops.len()];
        let mut counted = Vec::new();
        for hit in hits {
            let time = hit.time.to_f64();
            let near = self.wide * (slack + self.time_rounding(hit));
            // The end is known to a part of the length: the acceleration may fall meanwhile.
            let is_inside = chatters.iter().copied().flatten().any(|c| {
                let (sooner, later) = (self.wide * 0.02 * (c.end - c.start), c.end - c.start);
                c.stop == hit.stop && time > c.start - sooner - near && time < c.end + later + near
            });
            let begins = chatters.iter().chain(sticks).copied().flatten().any(|c| {
                let sooner = 0.02 * (c.end - c.start).min(1e-3 / self.rate);
                c.stop == hit.stop && (time - c.start).abs() < near + sooner
            });
            // A departure that is none to rounding is the one that restitution asks for.
            let mut asked = hit.clone();
            if asked.departure == 0.0 {
                asked.departure = self.case.stops[hit.stop].restitution * hit.approach;
            }
            if let Some(rest) = self.rest(&asked)
                && begins
                && asked.departure > 0.0
            {
                until[hit.stop] = until[hit.stop].max(time + 1.1 * rest + near);
            }
            if hit.approach > self.speed_floor(hit.stop) && !is_inside && time > until[hit.stop] {
                counted.push(hit.clone());
            }
        }
        counted
    }
}

/// Puts first, of impacts at practically one time, the one of a stop.
pub fn put_first(hits: &mut [Hit], wanted: &Hit, slack: f64) {
    let is_near = |h: &&Hit| (h.time - wanted.time).to_f64().abs() <= slack;
    let near = hits.iter().take_while(is_near);
    if let Some(k) = near.map(|h| h.stop).position(|stop| stop == wanted.stop) {
        hits[..=k].rotate_right(1);
    }
}

/// What rounding of the gaps has done to times and speeds of impacts so far, stop by stop: an impact late by `w` is faster by
/// `|a| w`, its flight longer by twice the error of its departure over `|a|`.
pub struct Drift {
    time: Vec<f64>,
    speed: Vec<f64>,
}

impl Drift {
    pub fn new(stops: usize) -> Self {
        Self {
            time: vec![0.0; stops],
            speed: vec![0.0; stops],
        }
    }

    /// Errors of time and speed of the next impact; an impact on another stop ends what is carried on this one.
    pub fn next(
        &mut self,
        counting: &Counting<'_>,
        hit: &Hit,
        follows: Option<&Hit>,
    ) -> (f64, f64) {
        let own = counting.time_rounding(hit);
        let a = if hit.curvature.is_finite() {
            hit.curvature.abs()
        } else {
            counting.rate * counting.v_unit
        };
        let (mut time, mut speed) = (own, own * a);
        if let Some(last) = follows
            && last.stop == hit.stop
            && hit.curvature < 0.0
        {
            let e = last.departure / last.approach;
            time += self.time[hit.stop] + 2.0 * e * self.speed[hit.stop] / a;
            speed += e * self.speed[hit.stop];
        }
        (self.time[hit.stop], self.speed[hit.stop]) = (time, speed);
        (time, speed)
    }
}
