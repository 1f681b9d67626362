//! What a hybrid system is to those that follow its motion: gaps with their derivatives, contacts, accelerations, impacts, the stops
//! that are held. Each subject is a trait of its own.

use crate::error::Result;
use crate::flow::GuardDerivatives;
use crate::hybrid::clock::Clock;
use crate::hybrid::recorder::Recorder;
use crate::law::{Guard, Law, Newton, Regime};
use crate::model::PhysicalState;
use crate::quantity::positive_part;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// A gap and its time derivatives where nothing is held, at one instant.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GapState {
    pub gap: f64,
    /// Opening speed.
    pub speed: f64,
    pub acceleration: f64,
    /// The third derivative where it costs nothing.
    pub jerk: Option<f64>,
    /// Size of the terms of the gap.
    pub size: f64,
}

/// A gap and its speed, each with the size of its terms.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GivenGap {
    pub gap: (f64, f64),
    pub speed: (f64, f64),
}

impl GivenGap {
    /// The same where the time has been rounded, of a stop of some value, speed and acceleration: it has moved on by that.
    pub fn at_time(mut self, t: f64, [_, speed, acceleration]: [f64; 3]) -> Self {
        self.gap.1 += (t * speed).abs();
        self.speed.1 += (t * acceleration).abs();
        self
    }
}

/// The largest sizes seen of a gap on a flight.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct GapSizes {
    /// Of its terms, whose rounding is that of the gap.
    pub terms: f64,
    /// Of the clearance and the way to it, which the tolerances are about: parts of a motion may be larger, and cancel.
    pub reach: f64,
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

/// The gaps of the present state.
pub(crate) trait Gaps {
    /// Evaluates every gap where the motion is now.
    fn evaluate_gaps(&mut self) -> Result<()>;
    /// A guard of the present regime where the motion is now; `None` of one that cannot change.
    fn guard_derivatives(&mut self, guard: Guard) -> Result<Option<GuardDerivatives>>;
    /// The gap of a stop as it was evaluated last.
    fn gap(&self, stop: usize) -> GapState;
    /// A gap and its speed at a position and velocity as they were given, before the rounding of the system's own state.
    fn given_gap(&self, stop: usize, q: &DVector<f64>, v: &DVector<f64>) -> Result<GivenGap>;
    /// What rounding leaves unknown of a gap as it was evaluated last: within it a touch is no impact, and another stop is reached
    /// at the same instant.
    fn rounding(&self, stop: usize) -> f64;
    /// Distance from zero within which a start is in contact, for a gap whose terms have the given size (theory 8).
    fn margin(&self, stop: usize, size: f64) -> f64;
    /// What the user's tolerances allow as an error of a gap whose terms have the given size (theory 9); an integrator's
    /// margin is ten times it.
    fn tolerance(&self, stop: usize, size: f64) -> f64 {
        0.1 * self.margin(stop, size)
    }
    /// The largest sizes of a gap seen on the last flight.
    fn flight_sizes(&self, stop: usize) -> GapSizes;
    /// Size of the terms of a normal velocity.
    fn speed_size(&self, stop: usize) -> f64;
}

/// How the stops act on the motion where it is now.
pub(crate) trait Contacts {
    /// Number of stops.
    fn n_stops(&self) -> usize;
    /// The law of contact of an element.
    fn element_law(&self, element: usize) -> &Law;
    /// The law of impact of a stop, now.
    fn law(&self, stop: usize) -> Newton;
    /// The normals of some stops, as columns.
    fn normals(&self, stops: &[usize]) -> Result<DMatrix<f64>>;
    /// `N^T B` of some stops.
    fn delassus(&self, stops: &[usize]) -> Result<DMatrix<f64>>;
    /// Whether an impact on one of two stops changes the normal velocity at the other.
    fn is_coupled(&self, one: usize, other: usize) -> bool;
    /// Whether two stops are at one place: they are reached together.
    fn is_at_place_of(&self, one: usize, other: usize) -> bool;
    /// Whether those held keep the gap of another stop as it is.
    fn is_bound(&self, stop: usize) -> bool;
}

/// The accelerations of gaps, and derivatives beyond.
pub(crate) trait Accelerations {
    /// The accelerations of some gaps where nothing is held, to as many digits as forces have that cancel exactly.
    fn free_accelerations(&self, stops: &[usize]) -> DVector<f64>;
    /// Size of the terms of the accelerations of some gaps.
    fn acceleration_sizes(&self, stops: &[usize]) -> Result<Vec<f64>>;
    /// What the system's own numbers leave unknown of the acceleration of a gap, beside the rounding of its terms.
    fn acceleration_lost(&self, _stop: usize) -> f64 {
        0.0
    }
    /// Time derivatives of some orders, from the second on, of the gaps of some stops in a regime, and what rounding leaves
    /// unknown of each; those of the orders that the system can tell, and that say more.
    fn gap_derivatives(
        &mut self,
        stops: &[usize],
        regime: &Regime,
        orders: Range<usize>,
    ) -> Result<Vec<Vec<[f64; 2]>>>;
    /// The third derivative of a gap where nothing is held.
    fn free_jerk(&mut self, stop: usize) -> Result<f64>;
    /// Acceleration of a gap, relative to the largest terms of those in contact, that the time of the release of another may leave of
    /// none.
    fn left_at_release(&self) -> f64;
    /// Third derivatives of gaps below this part of what others do to them are zero.
    fn steady(&self) -> f64;
}

/// Normal speeds and impulses of one stop where the motion is.
pub(crate) trait NormalMotion: Contacts {
    /// The normal of a stop and the direction of its reaction.
    type Directions;
    fn directions(&self, stop: usize) -> Result<Self::Directions>;
    /// The speed at which a stop recedes by its own motion.
    fn stop_speed(&self, stop: usize) -> f64;
    /// The speed along a normal, `n.v`.
    fn speed_along(&self, directions: &Self::Directions) -> f64;
    /// The impulse that changes the normal speed by so much, `change/(n.b)`.
    fn impulse_of(&self, directions: &Self::Directions, law: Newton, change: f64) -> f64;
    /// The impulse to an approach speed, `(1 + e) s/(n.b)`.
    fn rebound(&self, directions: &Self::Directions, law: Newton, approach: f64) -> f64 {
        self.impulse_of(directions, law, law.change(approach))
    }
    /// Changes the velocity by `-b` times an impulse.
    fn push_along(&mut self, directions: &Self::Directions, impulse: f64);
}

/// The impact of one stop.
pub(crate) trait NormalImpacts: Contacts {
    /// The impact of one stop by its law.
    fn strike(&mut self, stop: usize) -> Result<NormalImpact>;
    /// Pushes the motion away from a stop: the velocity changes by `-b` times the impulse.
    fn push(&mut self, stop: usize, impulse: f64) -> Result<()>;
}

impl<T: NormalMotion> NormalImpacts for T {
    fn strike(&mut self, stop: usize) -> Result<NormalImpact> {
        let (law, directions) = (self.law(stop), self.directions(stop)?);
        let receding = self.stop_speed(stop);
        let approach = positive_part(self.speed_along(&directions) - receding);
        let departure = law.departure(approach);
        let impulse = self.rebound(&directions, law, approach);
        self.push_along(&directions, impulse);
        // A small departure is what is left of two large speeds: its rounding is taken off.
        let left = self.speed_along(&directions) - receding + departure;
        let rest = self.impulse_of(&directions, law, left);
        self.push_along(&directions, rest);
        Ok(NormalImpact {
            approach,
            departure,
            impulse,
        })
    }

    fn push(&mut self, stop: usize, impulse: f64) -> Result<()> {
        let directions = self.directions(stop)?;
        self.push_along(&directions, impulse);
        Ok(())
    }
}

/// What puts the motion on stops at one instant, and holds it there.
pub(crate) trait Holding {
    /// Moves the motion onto some stops, along their reactions; its velocity stays.
    fn put_on(&mut self, stops: &[usize]) -> Result<()>;
    /// Moves the motion onto a stop by as little as rounding left it below, along its reaction. Steps stay where their tolerance puts
    /// them.
    fn raise(&mut self, _stop: usize) -> Result<()> {
        Ok(())
    }
    /// Puts elements that are about to relax at their places.
    fn set_places(&mut self, _places: &[(usize, f64)]) {}
    /// Enters a regime; gaps that it keeps closed, and their speeds, are made exact zeros.
    fn enter(&mut self, regime: &Regime) -> Result<()>;
    /// Completes the impacts on the first of some stops, which is about to be struck, that accumulate (theory 9) while the others are
    /// held: goes on over a span, that of the infinite sequence or what is left of it, and to where the gaps and their speeds are zero.
    fn complete_chatter(
        &mut self,
        stops: &[usize],
        span: f64,
        recorder: &mut dyn Recorder,
    ) -> Result<()>;
    /// Records the end of impacts that lose speed, in no time, as a segment of chatter.
    fn record_chatter(&mut self, stop: usize, recorder: &mut dyn Recorder) -> Result<()>;
}

/// Where the motion is.
pub(crate) trait Present {
    /// The present time.
    fn clock(&self) -> Clock;
    /// Sets the clock to a time that it is at but for rounding: that of a break, from which on something else acts.
    fn set_time(&mut self, t: f64);
    /// The forcing phase now.
    fn phase(&self) -> f64;
    /// The times at which what acts passes from one law to another, in order: a flight ends there, and another begins.
    fn breaks(&self) -> &[f64];
    /// Position and velocity now.
    fn physical(&self) -> PhysicalState;
    /// Operations that a flight of few steps is, in the units of an observer.
    fn work_of_flight(&self) -> usize;
}

/// A system with its stops where its motion is now.
pub(crate) trait HybridSystem:
    Gaps + Accelerations + NormalImpacts + Holding + Present
{
}

impl<T: Gaps + Accelerations + NormalImpacts + Holding + Present + ?Sized> HybridSystem for T {}
