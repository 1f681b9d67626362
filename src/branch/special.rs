//! Special points of a branch: bifurcations, and the boundaries at which it ends.

use crate::branch::predictor::AcceptedPoint;
use crate::branch::problem::BranchProblem;
use crate::branch::touch_outcome::TouchMultipliers;
use crate::impact::Impact;
use crate::itinerary::Coincidence;
use crate::law::{ElementState, GuardKind, Law};
use crate::orbit::{Breach, PeriodicOrbit, Rule};
use crate::tolerance::{
    BREACH_AT_IMPACT, LOST_IMPACT_SPEED, REACHED_AT_IMPACT, ROUNDED_IMPACT_SPEED,
};
use nalgebra::DVector;

/// What happens at a special point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpecialKind {
    /// The branch turns back: two orbits meet.
    Fold,
    /// A multiplier passes through -1: an orbit of twice the period is born.
    PeriodDoubling,
    /// Two conjugate multipliers pass through the unit circle beside 1 and -1: motions with a frequency more are born.
    Torus,
    /// A motion loses or gets a symmetry: it was its own mirror image, two that are each other's are born.
    Pitchfork,
    /// Another branch of the same pattern is crossed.
    BranchPoint,
    /// A stop that is not hit is touched.
    Graze,
    /// A stop that gives way is touched: the branch goes on with a contact more, or one less, and its multipliers do so smoothly.
    Touch,
    /// The same where the multipliers jump.
    BorderCollision,
    /// An impact has lost its speed.
    LostImpact,
    /// Two stops are hit at one instant.
    Corner,
    /// Lasting contact has no duration left.
    ChatterBorder,
    /// After an impact that takes all speed the stop is left instead of held, or held instead of left.
    LandingBorder,
    /// The contact force comes to zero while a stop is held.
    Rise,
    /// A flight between a release and the next landing on the same stop has no duration left: a rise from the other side.
    ReleaseBorder,
    /// All impacts of the period lose their speed at once, and contact goes on.
    VanishingImpacts,
}

impl SpecialKind {
    /// All of them.
    pub const ALL: [Self; 15] = [
        Self::Fold,
        Self::PeriodDoubling,
        Self::Torus,
        Self::Pitchfork,
        Self::BranchPoint,
        Self::Touch,
        Self::BorderCollision,
        Self::Graze,
        Self::LostImpact,
        Self::Corner,
        Self::ChatterBorder,
        Self::LandingBorder,
        Self::Rise,
        Self::ReleaseBorder,
        Self::VanishingImpacts,
    ];

    /// Whether the branch ends there: a rule of contact is broken beyond, or the motion has other instants.
    pub fn is_boundary(self) -> bool {
        !matches!(
            self,
            Self::Fold
                | Self::PeriodDoubling
                | Self::Torus
                | Self::Pitchfork
                | Self::BranchPoint
                | Self::Touch
                | Self::BorderCollision
        )
    }

    /// What the touch of a stop is, by its law: whether the orbits of a branch change smoothly there, their multipliers jump, or grow without bound.
    pub(super) fn of_touch(law: &Law) -> Self {
        let force = law.pressed_force();
        if law.is_rigid() || force.preload > 0.0 {
            return Self::Graze;
        }
        let guards = law.by_state().guards(ElementState::Pressed);
        if force.damping > 0.0 && guards.contains(&GuardKind::Push) {
            Self::BorderCollision
        } else {
            Self::Touch
        }
    }

    /// Whether orbits on one side of it are not those on the other, followed by the number alone: the branch turns back, or contacts come and go.
    pub(crate) fn divides(self) -> bool {
        matches!(self, Self::Fold | Self::Touch | Self::BorderCollision)
    }

    /// The kind of a name.
    #[cfg(feature = "python")]
    pub(crate) fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|own| own.name() == name)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fold => "fold",
            Self::PeriodDoubling => "period_doubling",
            Self::Torus => "torus",
            Self::Pitchfork => "pitchfork",
            Self::BranchPoint => "branch_point",
            Self::Graze => "graze",
            Self::Touch => "touch",
            Self::BorderCollision => "border_collision",
            Self::LostImpact => "lost_impact",
            Self::Corner => "corner",
            Self::ChatterBorder => "chatter_border",
            Self::LandingBorder => "landing_border",
            Self::Rise => "rise",
            Self::ReleaseBorder => "release_border",
            Self::VanishingImpacts => "vanishing_impacts",
        }
    }
}

/// A special point of a branch.
#[derive(Debug, Clone)]
pub struct Special {
    /// What happens there.
    pub kind: SpecialKind,
    /// The number of the branch there.
    pub parameter: f64,
    /// The error of that: the last change of the search, or the width of its bracket.
    pub error: f64,
    /// How far along the branch it is, in scaled unknowns \[-\].
    pub arclength: f64,
    /// The orbit there; of a boundary the last one before it.
    pub orbit: PeriodicOrbit,
    /// The stop that it is about.
    pub stop: Option<usize>,
    /// The time of the touch or the impact \[s\], counted from the first impact.
    pub time: Option<f64>,
    /// Of a touch of a stop that gives way the multipliers on both sides.
    pub touch: Option<TouchMultipliers>,
    /// Of a torus its rotation number: by what part of a turn a small deviation turns in a period, in (0, 1/2).
    pub rotation: Option<f64>,
    /// The tangent of the branch there, shape `(n_unknowns + 1,)`, \[-\]: the first state and the instants in scaled unknowns, then the
    /// number in parts of the range; of half the motion where that is kept its own mirror image. At the end of a doubled branch it is the
    /// difference of its two rounds, and the number stays.
    pub direction: DVector<f64>,
}

impl Special {
    /// A special point of a kind at a point of the branch.
    pub(super) fn at(kind: SpecialKind, point: &AcceptedPoint, error: f64) -> Self {
        Self {
            kind,
            parameter: point.place.value,
            error,
            arclength: point.arclength,
            orbit: point.orbit.clone(),
            stop: None,
            time: None,
            touch: None,
            rotation: None,
            direction: point.tangent.numbers(),
        }
    }
}

/// The boundary next to a point as a special point with an error, by the rule that an orbit breaks on one side of it; with the unit of
/// velocities.
pub(super) fn of_boundary(
    broken: &PeriodicOrbit,
    at: &AcceptedPoint,
    error: f64,
    speed: f64,
) -> Option<Special> {
    let own = breach_kind(broken, &at.orbit, speed)?;
    let kind = match own.kind {
        SpecialKind::Graze => SpecialKind::of_touch(broken.scene().stops()[own.stop].contact()),
        kind => kind,
    };
    Some(Special {
        stop: Some(own.stop),
        time: Some(own.time),
        ..Special::at(kind, at, error)
    })
}

/// The kind of a boundary, by the rule of contact that is broken beyond it.
pub(super) struct BreachKind {
    pub kind: SpecialKind,
    /// The stop that it is about, and when.
    pub stop: usize,
    pub time: f64,
    /// Whether the breach goes by the third power of the number that changes its sign there.
    pub is_by_cube: bool,
}

/// The boundary between an orbit that breaks a rule of contact and one that does not; with the unit of velocities.
pub(super) fn breach_kind(
    broken: &PeriodicOrbit,
    kept: &PeriodicOrbit,
    speed: f64,
) -> Option<BreachKind> {
    let Breach {
        mut stop,
        mut time,
        rule,
        ..
    } = broken.breach()?;
    let mut is_by_cube = false;
    let kind = match rule {
        Rule::Pulls { .. } | Rule::Leaves { .. } | Rule::Touches { .. } => SpecialKind::LostImpact,
        Rule::Reached { .. } => SpecialKind::Corner,
        // At the landing itself the contact would pull at once.
        Rule::Holds { .. }
            if beside(kept, time).is_some_and(|(own, off)| {
                own.stop == stop && own.departure == 0.0 && off <= REACHED_AT_IMPACT
            }) =>
        {
            SpecialKind::LandingBorder
        }
        Rule::Holds { .. } => SpecialKind::Rise,
        Rule::Changes { .. } => return None,
        Rule::Passed => {
            let next_to = beside(kept, time);
            if let Some(impact) = at_rest(kept, broken, speed) {
                // A stop is passed where an impact has no speed any more, or in other rounds of the motion without it.
                (stop, time) = (impact.stop, impact.time);
                SpecialKind::LostImpact
            } else if next_to.is_some_and(|(own, _)| own.stop == stop && own.departure == 0.0) {
                is_by_cube = true;
                SpecialKind::LandingBorder
            } else if next_to.is_some_and(|(own, off)| own.stop != stop && off <= REACHED_AT_IMPACT)
            {
                SpecialKind::Corner
            } else {
                SpecialKind::Graze
            }
        }
    };
    Some(BreachKind {
        kind,
        stop,
        time,
        is_by_cube,
    })
}

/// The slowest impact of an orbit, if it has no speed left and is slower on another orbit.
fn at_rest<'a>(orbit: &'a PeriodicOrbit, other: &PeriodicOrbit, unit: f64) -> Option<&'a Impact> {
    let impacts = orbit.impacts().iter().zip(other.impacts());
    let slowest = impacts.min_by(|a, b| a.0.approach.total_cmp(&b.0.approach));
    let is_lost = |(own, there): &(&Impact, &Impact)| {
        let speed = own.approach;
        speed <= ROUNDED_IMPACT_SPEED * unit
            || speed <= LOST_IMPACT_SPEED * unit && there.approach <= 0.5 * speed
    };
    slowest.filter(is_lost).map(|(own, _)| own)
}

/// The impact of an orbit nearest to a time, if it is near, and the difference of the times, in parts of the period \[-\].
fn beside(orbit: &PeriodicOrbit, time: f64) -> Option<(&Impact, f64)> {
    let period = orbit.period();
    let off = |impact: &Impact| {
        let late = (time - impact.time).rem_euclid(period);
        late.min(period - late) / period
    };
    let each = orbit.impacts().iter().map(|impact| (impact, off(impact)));
    let nearest = each.min_by(|a, b| a.1.total_cmp(&b.1));
    nearest.filter(|(_, off)| *off <= BREACH_AT_IMPACT)
}

/// The boundary at which an instant coincides with the next one, at the end of a branch.
pub(super) fn of_meeting(
    problem: &BranchProblem<'_>,
    last: &AcceptedPoint,
    (instant, error): (usize, f64),
) -> Special {
    let stages = &problem.signature.stages;
    let kind = match stages.coincidence(instant) {
        // A motion that an impact throws off a held stop comes back the sooner the slower the impact is: speed and flight vanish together.
        Coincidence::LowBounce => {
            let times = &last.place.state.times;
            return Special {
                stop: stages.impact(instant),
                time: Some(times[instant] - times[0]),
                ..Special::at(SpecialKind::LostImpact, last, error)
            };
        }
        Coincidence::Departure => SpecialKind::ReleaseBorder,
        Coincidence::Landing => SpecialKind::LandingBorder,
        Coincidence::Contact => SpecialKind::ChatterBorder,
        Coincidence::Corner => SpecialKind::Corner,
    };
    Special {
        stop: stages.stage(instant + 1).transition.element(),
        ..Special::at(kind, last, error)
    }
}
