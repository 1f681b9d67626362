//! What the event loop asks of the machinery that moves a scene: to fly to the next contact, to look at the gaps, to
//! strike a stop.

use crate::error::Result;
use crate::flow::ConstrainedMotion;
use crate::simulate::clock::Clock;
use crate::simulate::kept::Kept;
use crate::simulate::options::Stats;
use crate::simulate::record::Record;
use crate::watch::Watch;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use std::sync::Arc;

/// Roundings of a gap that are left of it, at the most, where steps have reached its stop.
const MOST_LEFT: f64 = 100.0;

/// A gap and its time derivatives under free motion, at one instant.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GapState {
    pub gap: f64,
    /// Opening speed.
    pub speed: f64,
    pub acceleration: f64,
    /// The third derivative where it costs nothing, zero elsewhere.
    pub jerk: f64,
    /// Size of the terms of the gap.
    pub size: f64,
}

/// A gap and its speed, each with the size of its terms.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed {
    pub gap: (f64, f64),
    pub speed: (f64, f64),
}

/// How a flight ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Arrival {
    /// At the end of the span.
    End,
    /// At a stop.
    Contact { stop: usize },
    /// Where the contact force of a stop that is held falls through zero.
    Release { stop: usize },
    /// Where no step was short enough to tell contact from none.
    Stalled { stop: usize },
    /// Where the steps of an integrator became too short for the time.
    Underflow,
}

/// The impact of one stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NormalImpact {
    /// Normal speed towards the stop before, not negative.
    pub approach: f64,
    /// Normal speed away from it after: restitution times approach, the law itself, which a sum over the struck state has
    /// only to rounding.
    pub departure: f64,
    pub impulse: f64,
}

/// Moves a scene; holds the present state and time.
pub(crate) trait Mover {
    /// Puts the motion at a state and a time, as new.
    fn start(&mut self, q: &DVector<f64>, v: &DVector<f64>, t: f64);
    /// The counts of a run, to which the mover's own since the start are added.
    fn counted(&self, stats: Stats) -> Stats;
    /// What is to be said of the run since the start, to follow the message.
    fn remarks(&self) -> String;
    /// The motion kept since the start.
    fn take_kept(&mut self) -> Option<Kept>;
    /// The motions while stops were held that the kept motion refers to.
    fn held_motions(&self) -> Vec<Arc<ConstrainedMotion>>;
    /// Number of stops.
    fn n_stops(&self) -> usize;
    /// The present time.
    fn clock(&self) -> Clock;
    /// Looks at every gap where the motion is now.
    fn look(&mut self) -> Result<()>;
    /// The gap of a stop at the last look.
    fn gap(&self, stop: usize) -> GapState;
    /// Distance from zero within which a start is in contact, for a gap whose terms have the given size (theory 8).
    fn margin(&self, stop: usize, size: f64) -> f64;
    /// What the user's tolerances allow as an error of a gap whose terms have the given size (theory 9); an integrator's
    /// margin is ten times it.
    fn tolerance(&self, stop: usize, size: f64) -> f64 {
        0.1 * self.margin(stop, size)
    }
    /// What rounding leaves unknown of the gap of a stop at the last look: within it a touch is no impact, and another stop is
    /// reached at the same instant.
    fn rounding(&self, stop: usize) -> f64;
    /// How many roundings may be left of a gap that was reached, and of others at that instant.
    fn left_of(&self, stop: usize) -> f64 {
        (self.gap(stop).gap / self.rounding(stop)).clamp(1.0, MOST_LEFT)
    }
    /// The largest size of the terms of a gap seen on the last flight.
    fn extent(&self, stop: usize) -> f64;
    /// The same of its clearance and the way to it, which the tolerances are about: parts of a motion may be larger, and cancel.
    fn reach(&self, stop: usize) -> f64 {
        self.extent(stop)
    }
    /// Size of the terms of a normal velocity.
    fn speed_size(&self, stop: usize) -> f64;
    /// Time derivatives of some orders, from the second on, of the gaps of some stops while others are held, and what rounding leaves
    /// unknown of each; those of the orders that the mover can tell, and that say more.
    fn gap_derivatives(
        &mut self,
        stops: &[usize],
        held: &[usize],
        orders: Range<usize>,
    ) -> Result<Vec<Vec<[f64; 2]>>>;
    /// The third derivative of a gap in free motion.
    fn free_jerk(&mut self, stop: usize) -> Result<f64> {
        Ok(self.gap(stop).jerk)
    }
    /// A gap and its speed at a position and velocity, before the rounding of the mover's own state.
    fn placed(&self, stop: usize, q: &DVector<f64>, v: &DVector<f64>) -> Result<Placed>;
    /// Whether those held keep the gap of another stop as it is.
    fn is_bound(&self, stop: usize) -> bool;
    /// The accelerations of some gaps in free motion, to as many digits as forces have that cancel exactly.
    fn pulls(&self, stops: &[usize]) -> DVector<f64> {
        DVector::from_fn(stops.len(), |i, _| self.gap(stops[i]).acceleration)
    }
    /// Size of the terms of the accelerations of some gaps.
    fn acceleration_sizes(&self, stops: &[usize]) -> Result<Vec<f64>>;
    /// What the mover's own numbers leave unknown of the acceleration of a gap, beside the rounding of its terms.
    fn acceleration_lost(&self, _stop: usize) -> f64 {
        0.0
    }
    /// Acceleration of a gap, relative to the largest terms of those in contact, that the time of the release of another may leave of
    /// none.
    fn left_at_release(&self) -> f64 {
        1e-9
    }
    /// Third derivatives of gaps below this part of what others do to them are zero: steps know them by differences.
    fn steady(&self) -> f64 {
        1e-6
    }
    /// Operations that a flight of few steps is, in the units of a watch.
    fn work_of_flight(&self) -> usize;
    /// Whether an impact on one of two stops changes the normal velocity at the other.
    fn is_coupled(&self, one: usize, other: usize) -> bool;
    /// Whether two stops are at one place: they are reached together.
    fn is_at(&self, one: usize, other: usize) -> bool;
    /// Flies to the next contact or release or over the whole span, `last` the time at which the run ends there. The gaps must have
    /// been looked at; `starts[i]` is the order of the root of gap i at the start, zero for an open gap. On a contact the
    /// gaps have been looked at there.
    fn fly(
        &mut self,
        starts: &[usize],
        span: f64,
        last: f64,
        record: &mut Record,
        watch: &mut Watch<'_>,
    ) -> Result<Arrival>;
    /// Keeps a flight of no length: the state before an impact at the start of the run, or that after the last event of a run
    /// that ends with it, at `last`.
    fn stay(&mut self, last: Option<f64>, record: &mut Record) -> Result<()>;
    /// The impact of one stop.
    fn strike(&mut self, stop: usize) -> Result<NormalImpact>;
    /// The normals of some stops where the motion is now, as columns.
    fn normals(&self, stops: &[usize]) -> Result<DMatrix<f64>>;
    /// `N^T B` of some stops where the motion is now.
    fn delassus(&self, stops: &[usize]) -> Result<DMatrix<f64>>;
    /// Pushes the motion away from a stop: the velocity changes by `-b` times the impulse.
    fn push(&mut self, stop: usize, impulse: f64) -> Result<()>;
    /// The restitution coefficient of a stop.
    fn restitution(&self, stop: usize) -> f64;
    /// Completes the impacts on a stop that is about to be struck and that accumulate (theory 9): goes to the end of the
    /// infinite sequence, where the gap and its speed are zero, or as far on the way there as time is left. The gaps must have been
    /// looked at.
    fn accumulate(&mut self, stop: usize, left: f64, record: &mut Record) -> Result<()>;
    /// Keeps the end of impacts that lose speed, in no time, as a segment of chatter.
    fn note_chatter(&mut self, stop: usize, record: &mut Record) -> Result<()>;
    /// Moves the motion onto some stops, along their reactions; its velocity stays.
    fn touch(&mut self, stops: &[usize]) -> Result<()>;
    /// Moves the motion onto a stop by as little as rounding left it below, along its reaction. Steps stay where their tolerance puts
    /// them.
    fn raise(&mut self, _stop: usize) -> Result<()> {
        Ok(())
    }
    /// Holds these stops from now on, none to let all go; their gaps and speeds are made exact zeros.
    fn hold(&mut self, stops: &[usize]) -> Result<()>;
    /// The forcing phase now.
    fn phase(&self) -> f64;
    /// Position and velocity now.
    fn physical(&self) -> (DVector<f64>, DVector<f64>);
}

/// A mover as the loop of flights takes it: by its type where an impact is worth little more than the calls that the loop
/// makes, as any mover where steps outweigh them; one loop serves all of those.
pub(crate) trait Looped: Mover {
    /// What the loop is made for.
    type Taken<'s>: Mover + ?Sized
    where
        Self: 's;

    /// The mover as that.
    fn taken(&mut self) -> &mut Self::Taken<'_>;
}
