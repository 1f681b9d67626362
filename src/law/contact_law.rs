//! A law of contact, by the states of its element: what the element adds to the equations of motion in each, the guards that end it, and what
//! follows where one of them falls through zero. `hybrid` and `flow` know elements by this alone.

use crate::law::guard::GuardKind;
use crate::law::regime::ElementState;
use crate::quantity::positive_part;
use crate::tolerance::PLACE_FORGOTTEN;
use nalgebra::Complex;

/// What an element adds to the equations of motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Action {
    Nothing,
    /// A force that keeps its gap at zero.
    Constraint,
    /// A force against its approach, linear in it and its rate.
    Force(LinearForce),
    /// One that is not: [`ContactLaw::force_at`].
    Curve,
}

/// A force at an approach p and its rate p', with its derivatives.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct ForceAt {
    pub value: f64,
    pub by_approach: f64,
    pub by_rate: f64,
}

impl ForceAt {
    /// The size of its terms, from those of the approach and of its rate.
    pub fn size_at(self, approach: f64, rate: f64) -> f64 {
        self.value.abs() + self.change_at(approach, rate)
    }

    /// What it changes by at the most, as the approach and its rate do.
    pub fn change_at(self, approach: f64, rate: f64) -> f64 {
        self.by_approach.abs() * approach + self.by_rate.abs() * rate
    }
}

/// A force `f = k p + c p' + F0` on the approach `p = -h`: the generalised force is `-n f`, or it acts along the reaction of the stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LinearForce {
    /// k \[N/m\].
    pub stiffness: f64,
    /// c \[N s/m\].
    pub damping: f64,
    /// F0 \[N\].
    pub preload: f64,
}

impl LinearForce {
    /// None at all.
    pub const NOTHING: Self = Self {
        stiffness: 0.0,
        damping: 0.0,
        preload: 0.0,
    };

    /// The force at a gap and its opening speed.
    pub fn at(self, gap: f64, speed: f64) -> f64 {
        self.preload - self.stiffness * gap - self.damping * speed
    }

    /// What a motion of the stop of an amplitude at a frequency adds to it, as a push along the reaction.
    pub fn turned(self, amplitude: Complex<f64>, frequency: f64) -> Complex<f64> {
        amplitude * Complex::new(self.stiffness, self.damping * frequency)
    }

    /// The size of its terms, from those of the gap and of its speed.
    pub fn size_at(self, gap: f64, speed: f64) -> f64 {
        self.preload + self.stiffness * gap + self.damping * speed
    }
}

/// How the place r of an element goes back to where it was when nothing of the body is left on it: `r' = -rate (r + beyond)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Relaxation {
    /// \[1/s\]
    pub rate: f64,
    /// How far beyond its seat it would go, had it none.
    pub beyond: f64,
}

impl Relaxation {
    /// Where a place is after a time.
    pub fn after(self, place: f64, time: f64) -> f64 {
        let gone = -(-self.rate * time).exp_m1();
        positive_part(place - gone * (place + self.beyond))
    }

    /// A place after a time, with its speed and acceleration then.
    pub fn along(self, place: f64, time: f64) -> [f64; 3] {
        let there = self.after(place, time);
        let speed = self.speed(there);
        [there, speed, -self.rate * speed]
    }

    /// The speed at which a place goes back.
    pub fn speed(self, place: f64) -> f64 {
        -self.rate * (place + self.beyond)
    }

    /// What is left after a time of a small deviation of a place.
    pub fn left(self, time: f64) -> f64 {
        (-self.rate * time).exp()
    }

    /// The time after which a place is back, to the last digit.
    pub fn duration(self, place: f64) -> f64 {
        if self.beyond > 0.0 {
            (place / self.beyond).ln_1p() / self.rate
        } else {
            PLACE_FORGOTTEN / self.rate
        }
    }
}

/// What follows where a guard falls through zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// An impact, after which the element is free or held.
    Impact,
    /// It is let go, unless it is held after all.
    Release,
    /// It goes on in another state.
    Enters(ElementState),
}

/// A law of contact.
pub(crate) trait ContactLaw: std::fmt::Debug + Send + Sync {
    /// What the element adds in a state.
    fn action(&self, state: ElementState) -> Action;
    /// The guards that end a state.
    fn guards(&self, state: ElementState) -> &'static [GuardKind];
    /// What follows where a guard of a state falls through zero.
    fn outcome(&self, state: ElementState, guard: GuardKind) -> Outcome;
    /// The force of an element that is pressed.
    fn force_at(&self, approach: f64, rate: f64) -> ForceAt {
        let own = self.force(ElementState::Pressed);
        own.map_or(ForceAt::default(), |own| ForceAt {
            value: own.at(-approach, -rate),
            by_approach: own.stiffness,
            by_rate: own.damping,
        })
    }
    /// What has the sign of that force, without the zero that it has where the approach is zero and the contact ends anyway.
    fn grip(&self, approach: f64, rate: f64) -> ForceAt {
        self.force_at(approach, rate)
    }
    /// The force that the element has in a state, at a gap and its opening speed, if it has one of its own.
    fn force_in(&self, state: ElementState, gap: f64, speed: f64) -> Option<f64> {
        match self.action(state) {
            Action::Force(force) => Some(force.at(gap, speed)),
            Action::Curve => Some(self.force_at(-gap, -speed).value),
            Action::Nothing | Action::Constraint => None,
        }
    }
    /// The force that the element has in a state, if it has one of its own that is linear.
    fn force(&self, state: ElementState) -> Option<LinearForce> {
        match self.action(state) {
            Action::Force(force) => Some(force),
            Action::Nothing | Action::Constraint | Action::Curve => None,
        }
    }
    /// How its place goes back in a state, if it does.
    fn relaxation(&self, _state: ElementState) -> Option<Relaxation> {
        None
    }
    /// The energy that it stores in a state, at a gap \[J\].
    fn stored(&self, _state: ElementState, _gap: f64) -> f64 {
        0.0
    }
    /// The largest force by which an element that gives way keeps its gap at zero, its preload; none of one without.
    fn seat(&self) -> Option<f64> {
        let own = self.force(ElementState::Pressed)?;
        (own.preload > 0.0).then_some(own.preload)
    }
    /// A contact force without what rounding makes of it: a rigid element pushes, to the instant when its force is zero and it is let go.
    fn allowed(&self, force: f64) -> f64 {
        if self.restitution().is_some() {
            force.max(0.0)
        } else {
            force
        }
    }
    /// The restitution of its impacts, if it is rigid: its gap is never negative.
    fn restitution(&self) -> Option<f64> {
        None
    }
}
