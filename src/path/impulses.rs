//! Impulses of the stops along a path [N s]: impacts, impacts that accumulate, the forces of lasting contact (theory 9, "Momentum").
//!
//! Every change of the velocity is one of free motion or one along the reactions,
//!
//! ```text
//! v(t2) - v(t1) = integral of a_free dt - sum b_i p_i,
//! ```
//!
//! with p an impulse at an instant and `L dt` while a stop is held, `D L = N^T a_free - kappa`. What is left of impacts that
//! accumulate, speeds `s, e s, e^2 s, ...` before them, gives
//!
//! ```text
//! (1 + e) (s + e s + ...)/(n.b) = (1 + e)/(1 - e) s/(n.b) = s/(n.b) + L span,    span = 2 e s/((1 - e) |h''|),  L = |h''|/(n.b):
//! ```
//!
//! as much as to take the speed away at once and hold the stop over the time that they take. That is the motion which a path has
//! on a segment of chatter, so that its impulse is the jump at its start, along the reaction, and the force along it.

use crate::error::{Error, Result};
use crate::impact::Impact;
use crate::model::Scene;
use crate::observer::unless_broken_off;
use crate::path::equations::PathEquations;
use crate::path::fading::Fading;
use crate::path::fast_forces::FastPart;
use crate::path::path::Path;
use crate::path::quadrature::{QuadratureNode, each_node};

/// Times from right after one to right after another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Window {
    after: f64,
    until: f64,
}

impl Window {
    /// All of a path, what happens at its ends included.
    pub const ALL: Self = Self {
        after: f64::NEG_INFINITY,
        until: f64::INFINITY,
    };

    /// From right after one time to right after another; at the ends of a path what happens there counts.
    ///
    /// # Errors
    /// Times that run backwards or leave the path.
    pub fn of((first, last): (f64, f64), span: (f64, f64)) -> Result<Self> {
        check_order(span)?;
        let slack = 4.0 * f64::EPSILON * first.abs().max(last.abs());
        if span.0 < first - slack || span.1 > last + slack {
            let rule = format!("it must lie in the span [{first}, {last}] of the trajectory");
            return Err(Error::bad_value("span", format!("{span:?}"), rule));
        }
        Ok(Self {
            after: if span.0 <= first {
                f64::NEG_INFINITY
            } else {
                span.0
            },
            until: if span.1 >= last {
                f64::INFINITY
            } else {
                span.1
            },
        })
    }

    /// From right after the start of a path to right after a time.
    pub fn until(path: &Path, until: f64) -> Self {
        let after = path.span.0;
        Self { after, until }
    }

    /// Whether some of a span is in it.
    pub fn meets(self, (first, last): (f64, f64)) -> bool {
        self.after <= last && first <= self.until
    }

    fn has(self, time: f64) -> bool {
        self.after < time && time <= self.until
    }
}

/// Refuses times that are not finite or run backwards.
pub(crate) fn check_order(span: (f64, f64)) -> Result<()> {
    if span.0.is_finite() && span.1.is_finite() && span.0 <= span.1 {
        return Ok(());
    }
    let rule = "it must be finite with start <= end";
    Err(Error::bad_value("span", format!("{span:?}"), rule))
}

/// What a stop in contact on a segment gives at an instant at which impacts accumulate: a speed is taken away there that no
/// impact of the list is about.
#[derive(Debug, Clone, Copy)]
struct Jump {
    time: f64,
    owner: Owner,
    impulse: f64,
}

/// A stop in contact on a segment.
#[derive(Debug, Clone, Copy)]
struct Owner {
    segment: usize,
    /// Its place among the stops of the segment.
    place: usize,
    stop: usize,
}

/// The impulses of the stops of a scene along a path of it.
pub(crate) struct Impulses<'a> {
    path: &'a Path,
    equations: PathEquations<'a>,
    fading: Fading<'a>,
    impacts: &'a [Impact],
    jumps: Vec<Jump>,
}

impl<'a> Impulses<'a> {
    /// Along a path of a scene with the impacts that are listed of it.
    ///
    /// # Errors
    /// What the functions of a nonlinear scene report.
    pub fn new(path: &'a Path, scene: &'a Scene, impacts: &'a [Impact]) -> Result<Self> {
        let equations = PathEquations::new(path, scene);
        Ok(Self {
            path,
            jumps: jumps(path, &equations)?,
            equations,
            fading: Fading::new(&path.evaluator),
            impacts,
        })
    }

    /// All that a stop gives in a window.
    ///
    /// # Errors
    /// What the functions of a nonlinear scene report; `Error::Interrupted` where the caller's work is broken off.
    pub fn of_stop(&self, stop: usize, window: Window) -> Result<f64> {
        let is_its = |impact: &&Impact| impact.stop == stop && window.has(impact.time);
        let hits = self.impacts.iter().filter(is_its).map(|i| i.impulse);
        let is_its = |jump: &&Jump| jump.owner.stop == stop && window.has(jump.time);
        let jumps = self.jumps.iter().filter(is_its).map(|j| j.impulse);
        let mut sum: f64 = hits.chain(jumps).sum();
        for (k, segment) in self.path.parts.segments.iter().enumerate() {
            if let Some(place) = segment.regime.pushing().position(|own| own == stop) {
                sum += self.forces_on(k, window)?[place];
            }
        }
        Ok(sum)
    }

    /// The impulses of the stops in contact on each segment, but for the impacts that are listed.
    ///
    /// # Errors
    /// As [`of_stop`](Self::of_stop).
    pub fn of_segments(&self) -> Result<Vec<Vec<f64>>> {
        let segments = 0..self.path.parts.segments.len();
        let each = segments.map(|k| self.forces_on(k, Window::ALL));
        let mut sums = each.collect::<Result<Vec<_>>>()?;
        for Jump { owner, impulse, .. } in &self.jumps {
            sums[owner.segment][owner.place] += impulse;
        }
        Ok(sums)
    }

    /// The integrals of the forces of the stops in contact on a segment, in a window.
    fn forces_on(&self, segment: usize, window: Window) -> Result<Vec<f64>> {
        let mut sums = vec![0.0; self.path.parts.segments[segment].regime.pushing().count()];
        if !sums.is_empty() {
            for arc in self.path.parts.arcs_of(segment) {
                self.integrate(arc, window, &mut sums)?;
            }
        }
        Ok(sums)
    }

    /// Adds the integrals of the forces along what of an arc lies in a window.
    fn integrate(&self, arc: usize, window: Window, sums: &mut [f64]) -> Result<()> {
        let kept = self.path.arc(arc);
        let (start, end) = (kept.clock.time(), kept.clock.after(kept.span).time());
        let from = if window.after > start {
            kept.local(window.after)
        } else {
            0.0
        };
        let to = if window.until < end {
            kept.local(window.until)
        } else {
            kept.span
        };
        let regime = self.path.regime_of(arc);
        let fast = FastPart::new(&self.path.evaluator, regime, to - from);
        let rates = fast
            .as_ref()
            .map_or_else(|| self.fading.of(regime), |fast| &fast.rates);
        each_node(rates, (from, to), |node| {
            let QuadratureNode { at, weight, .. } = node;
            unless_broken_off()?;
            let (q, v) = self.path.state_in(arc, at);
            let moment = self.equations.moment(arc, at);
            let (a, mut forces) = self.equations.regime_acceleration(regime, moment, &q, &v)?;
            if let Some(fast) = &fast {
                subtract(forces.iter_mut().map(|own| &mut own.1), fast.of(&v, &a));
            }
            for (sum, (_, force)) in sums.iter_mut().zip(forces) {
                *sum += weight * force;
            }
            Ok(())
        })?;
        if let Some(fast) = &fast {
            let [start, end] = [from, to].map(|at| self.path.state_in(arc, at));
            let mut change = fast.of(&end.0, &end.1);
            subtract(change.iter_mut(), fast.of(&start.0, &start.1));
            for (sum, change) in sums.iter_mut().zip(change) {
                *sum += change;
            }
        }
        Ok(())
    }
}

fn subtract<'a>(from: impl Iterator<Item = &'a mut f64>, values: Vec<f64>) {
    for (from, value) in from.zip(values) {
        *from -= value;
    }
}

/// The instants of a path at which impacts accumulate, stop by stop. Those that take no time share their instant, with what pushes
/// the stops held beside them.
fn jumps(path: &Path, equations: &PathEquations<'_>) -> Result<Vec<Jump>> {
    let parts = &path.parts;
    let is_rest = |k: usize| parts.segments[k].accumulation().is_some();
    let takes_time = |k: usize| {
        parts.arcs[parts.arcs_of(k)]
            .iter()
            .any(|arc| arc.span > 0.0)
    };
    let (mut all, mut next) = (Vec::new(), 0);
    while let Some(first) = (next..parts.segments.len()).find(|&k| is_rest(k)) {
        let later = first..parts.segments.len();
        let spent = later.take_while(|&k| is_rest(k) && !takes_time(k));
        next = first + spent.count();
        let (before, after) = (parts.arcs_of(first).start, parts.segments.get(next));
        if let (Some(before), Some(after)) = (before.checked_sub(1), after)
            && let Some(behind) = parts.arcs.get(after.first)
        {
            let owners = owners(path, first, next);
            let (_, v) = path.state_in(before, path.arc(before).span);
            let (q, w) = path.state_in(after.first, 0.0);
            let stops: Vec<usize> = owners.iter().map(|owner| owner.stop).collect();
            let impulses = equations.impulses(&stops, &q, &(v - w))?;
            let time = behind.clock.time();
            all.extend(
                owners
                    .into_iter()
                    .zip(impulses.iter())
                    .map(|(owner, &impulse)| Jump {
                        time,
                        owner,
                        impulse,
                    }),
            );
        }
        next += usize::from(next < parts.segments.len() && is_rest(next));
    }
    Ok(all)
}

/// The stops that push at an instant at which impacts accumulate: those of the chatters from one segment to before another, then those
/// in contact after it, then those held before it, each once.
fn owners(path: &Path, first: usize, next: usize) -> Vec<Owner> {
    let segments = &path.parts.segments;
    let mut owners: Vec<Owner> = Vec::new();
    for segment in (first..=next).chain(first.checked_sub(1)) {
        for (place, &stop) in segments[segment].regime.constrained().iter().enumerate() {
            if owners.iter().all(|owner| owner.stop != stop) {
                owners.push(Owner {
                    segment,
                    place,
                    stop,
                });
            }
        }
    }
    owners
}
