//! A gap whose curvature is bounded along one step of an integrator: its value, its slope and a bound on how it bends.
//!
//! The motion on the step is the polynomial `q(x)` of `step_path.rs`, which is the true one to the tolerance of the step. With
//! `|q'| <= V` and `|q''| <= A` over a width w from x on, with a curvature K, `|hess h| <= K`, and with `|n.q''| <= N` of the gradient
//! n at x, which differs from that farther on by no more than `K V w`, the gap `g(x) = h(q(x))` has
//!
//! `|g''| = |grad h.q'' + q'.(hess h) q'| <= N + K V (w A + V) =: B`,
//!
//! plus a bound on that of the own motion of the stop, if it moves. N is a bound on one polynomial: coordinates that the gap does not
//! depend on do not enter it, and it is the same whatever the units of the others, such as lengths beside angles. In V and A they are of one unit, as they are
//! in the norm that K bounds. A plane has K = 0; the walls of a pendulum have the length of their longest link. Of a nonlinear stop K is
//! what its maker says; that every value of the gap agrees with it is looked at.

use crate::error::Result;
use crate::event::step_path::{Expansion, StepPath, derivative_bounds};
use crate::flow::steps::Tolerance;
use crate::model::{Contact, Moment, WatchedGap};
use crate::tolerance::{GAP_KNOWN_ROUNDINGS, GAP_ROUNDING, TERM_ROUNDINGS};

/// The error of a gap for an error of the state as large as its tolerance \[m\].
#[inline]
pub(crate) fn gap_tolerance(tolerance: Tolerance, (steepness, size): (f64, f64)) -> f64 {
    tolerance.absolute * steepness + tolerance.relative.max(GAP_ROUNDING) * size
}

/// A gap with a bound on its curvature along a step.
pub(crate) struct BoundedGap<'a> {
    pub contact: &'a Contact,
    /// What is searched of it, at the start of the step.
    pub watched: WatchedGap,
    /// K
    pub curvature: f64,
    /// The order of the root at the start, zero of an open gap.
    pub order: usize,
    /// The gap at the start where that is a root: what counts as zero.
    pub departed: f64,
    /// Where the step begins, and its length.
    pub begun: Moment,
    pub h: f64,
    pub tolerance: Tolerance,
    /// The smallest error that the gap is known to, whatever the rounding of its terms.
    pub known: f64,
}

/// A gap at a place of the step.
#[derive(Debug, Clone)]
pub(crate) struct GapPoint {
    pub x: f64,
    pub gap: f64,
    /// By parts of the step.
    pub slope: f64,
    /// The rounding of its terms; that plus the error of the path there; that plus the tolerance.
    pub rounding: f64,
    pub doubt: f64,
    pub tolerance: f64,
    motion: Expansion,
    /// That along the normal there, in powers.
    approach: Vec<f64>,
}

impl BoundedGap<'_> {
    /// The gap at a place of a motion.
    pub fn at(&self, path: &StepPath, x: f64) -> Result<GapPoint> {
        let motion = path.about(x);
        let q = motion.position();
        let surface = &self.contact.surface;
        let (gap, normal) = (surface.gap(&q)?, surface.normal(&q)?);
        let own = self.contact.motion.as_ref();
        let ([moved, speed, _], moved_size) = own.map_or(([0.0; 3], 0.0), |own| {
            own.along_with_size(self.begun.after(x * self.h))
        });
        let weighted = |sizes: &[f64]| -> f64 {
            let terms = normal.iter().zip(sizes);
            terms.map(|(n, size)| (n * size).abs()).sum()
        };
        let approach = motion.along(normal.as_slice());
        let (sign, [place, place_speed, _]) = (self.watched.sign(), self.watched.place(x * self.h));
        let slope = self.h * speed - approach.get(1).copied().unwrap_or(0.0);
        // The part of the gap that the motion of the stop does not make, as `Surface::along` has it.
        let size = gap.abs() + weighted(&q) + moved_size + place;
        let terms = gap.abs() + weighted(&motion.sizes) + moved_size + place;
        let rounding = self.known.max(TERM_ROUNDINGS * terms);
        let tolerance = gap_tolerance(self.tolerance, (normal.lp_norm(1), size));
        let doubt = rounding + path.error_at(x, normal.as_slice());
        Ok(GapPoint {
            x,
            gap: sign * (gap + moved) + place - self.departed,
            slope: sign * slope + self.h * place_speed,
            rounding,
            doubt,
            tolerance: tolerance.max(GAP_KNOWN_ROUNDINGS * rounding) + doubt,
            motion,
            approach,
        })
    }

    /// A bound on the size of the second derivative by parts of the step, over a width from a place on.
    pub fn bend(&self, place: &GapPoint, width: f64) -> f64 {
        let [_, straight] = derivative_bounds(&place.approach, width);
        let [speed, bend] = place.motion.bounds(width);
        let curved = self.curvature * speed * (width * bend + speed);
        let own = self.contact.motion.as_ref().map_or(0.0, |own| {
            own.bend_bound(self.begun.after(place.x * self.h), width * self.h)
        });
        // A place goes back ever more slowly.
        let [_, _, back] = self.watched.place(place.x * self.h);
        straight + curved + self.h * self.h * (own + back)
    }
}
