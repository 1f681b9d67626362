//! Newton's law of one impact (theory 1): a rigid, frictionless stop reverses the normal speed by its restitution e, whatever the direction
//! b of its reaction. Speeds along the normal are `s = n.v - c'`, relative to the stop's own speed c' and positive towards it; an impulse p
//! changes the velocity by `-b p`, the normal speed by `-(n.b) p`. `NormalImpacts::strike` (`hybrid/system.rs`) applies it with n.v and c'
//! of the instant, at a stop at rest as at one that moves: `v+ = v- - b (1 + e) (n.v- - c')/(n.b)`, so that `n.v+ - c' = -e (n.v- - c')`.
//! Orbits apply it in `HybridMaps::impact` (`hybrid/closed_form/maps.rs`, `hybrid/integrated/maps.rs`); several stops together:
//! `impact/several_stops.rs`.

use crate::error::Result;
use crate::law::contact_law::{Action, ContactLaw, Outcome};
use crate::law::guard::GuardKind;
use crate::law::regime::ElementState;
use crate::quantity::{Restitution, positive};
use crate::tolerance::RATIO_TOL;

/// Newton's law of a rigid stop: the normal speed after an impact is minus the restitution times that before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Newton {
    /// The restitution e \[-\].
    pub(crate) restitution: f64,
}

impl Newton {
    /// The law of a restitution e \[-\].
    ///
    /// # Errors
    /// A restitution outside [0, 1].
    pub fn new(restitution: f64) -> Result<Self> {
        Ok(Self::known(Restitution::new(restitution)?.value()))
    }

    /// That of one that is known to be in [0, 1].
    pub(crate) const fn known(restitution: f64) -> Self {
        Self { restitution }
    }

    /// The restitution e \[-\].
    pub const fn restitution(&self) -> f64 {
        self.restitution
    }

    /// The restitution of a free body: that of the law, whatever its mass \[kg\] and speed \[m/s\].
    ///
    /// # Errors
    /// A mass or a speed that is not positive.
    pub fn equivalent_restitution(&self, mass: f64, speed: Option<f64>) -> Result<f64> {
        positive("mass", mass)?;
        speed.map(|speed| positive("speed", speed)).transpose()?;
        Ok(self.restitution)
    }

    /// `1 + e`: the change of normal speed to an approach speed of one.
    pub(crate) const fn factor(self) -> f64 {
        1.0 + self.restitution
    }

    /// The change of normal speed to an approach speed, `(1 + e) s`.
    pub(crate) const fn change(self, approach: f64) -> f64 {
        self.factor() * approach
    }

    /// The speed away from the stop after an approach, `e s`.
    pub(crate) const fn departure(self, approach: f64) -> f64 {
        self.restitution * approach
    }

    /// The part of a change of normal speed that is the departure, `e/(1 + e)` of it.
    pub(crate) const fn departure_by(self, change: f64) -> f64 {
        self.restitution / self.factor() * change
    }

    /// The approach speed to which a change of normal speed belongs, `1/(1 + e)` of it.
    pub(crate) const fn approach_by(self, change: f64) -> f64 {
        change / self.factor()
    }

    /// What a speed s+ after an impact and its change `s- - s+` leave of the law, `s+ + e s- = (1 + e) s+ + e (s- - s+)`.
    pub(crate) const fn residual(self, after: f64, change: f64) -> f64 {
        self.factor() * after + self.restitution * change
    }

    /// The impulse to an approach speed of one, `(1 + e)/(n.b)`.
    pub(crate) const fn rebound(self, give: f64) -> f64 {
        self.factor() / give
    }

    /// Whether all speed is taken: the stop may hold from then on.
    pub(crate) fn is_inelastic(self) -> bool {
        self.restitution == 0.0
    }

    /// Whether impacts accumulate under a force that draws back to the stop: their speeds are a geometric series, `0 < e < 1`.
    pub(crate) fn is_contracting(self) -> bool {
        self.restitution > 0.0 && self.restitution < 1.0
    }

    /// Whether two successive approach speeds are in the ratio e, as where impacts accumulate.
    pub(crate) fn is_repeated(self, before: f64, next: f64) -> bool {
        (next / before / self.restitution - 1.0).abs() < RATIO_TOL
    }
}

impl ContactLaw for Newton {
    fn action(&self, state: ElementState) -> Action {
        if state.is_held() {
            Action::Constraint
        } else {
            Action::Nothing
        }
    }

    fn guards(&self, state: ElementState) -> &'static [GuardKind] {
        if state.is_held() {
            &[GuardKind::Force]
        } else {
            &[GuardKind::Gap]
        }
    }

    fn outcome(&self, state: ElementState, _guard: GuardKind) -> Outcome {
        if state.is_held() {
            Outcome::Release
        } else {
            Outcome::Impact
        }
    }

    fn restitution(&self) -> Option<f64> {
        Some(self.restitution)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impact_leaves_nothing_of_the_law() {
        for e in [0.0, 0.3, 0.5, 1.0] {
            let (law, approach) = (Newton::known(e), 0.7);
            let change = law.change(approach);
            assert!((change - approach - law.departure(approach)).abs() < 1e-15);
            assert!(law.residual(-law.departure(approach), change).abs() < 1e-15);
            assert!((law.approach_by(change) - approach).abs() < 1e-15);
            assert!((law.departure_by(change) - law.departure(approach)).abs() < 1e-15);
            assert!((law.rebound(4.0) * approach * 4.0 - change).abs() < 1e-15);
            assert_eq!(law.is_contracting(), e == 0.3 || e == 0.5);
            assert_eq!(law.is_inelastic(), e == 0.0);
            assert!(e == 0.0 || law.is_repeated(approach, law.departure(approach)));
        }
    }
}
