//! A stop that gives way by a spring, a dashpot and a preload: the force `f = k p + c p' + F0` on the approach p = -h. With a dashpot it has to be
//! said where a contact ends, as laws differ in that and published results with them: where the gap opens, or where the force is zero.

use crate::error::{Error, Result};
use crate::law::contact_law::{Action, ContactLaw, LinearForce, Outcome, Relaxation};
use crate::law::contact_release::ContactRelease;
use crate::law::free_contact::{FreeContact, damping_ratio, restitution_of};
use crate::law::guard::GuardKind;
use crate::law::regime::ElementState;
use crate::quantity::{not_negative, positive};

/// Law of a stop that gives way: a force k p + c p' pushes against the approach p = -gap while that is positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    force: LinearForce,
    release: Option<ContactRelease>,
}

impl Spring {
    /// The law of a stiffness k \[N/m\] and a damping c \[N s/m\]. Without damping it is the same whatever the release.
    ///
    /// # Errors
    /// A stiffness that is not positive, a damping that is negative or not finite, damping without a release.
    pub fn new(stiffness: f64, damping: f64, release: Option<ContactRelease>) -> Result<Self> {
        let stiffness = positive("stiffness", stiffness)?;
        let damping = not_negative("damping", damping)?;
        if damping > 0.0 && release.is_none() {
            return Err(no_release(stiffness, damping));
        }
        let preload = 0.0;
        Ok(Self {
            force: LinearForce {
                stiffness,
                damping,
                preload,
            },
            release,
        })
    }

    /// The same with a preload F0 \[N\]: the force at which it begins to give way.
    ///
    /// # Errors
    /// A number that is negative or not finite.
    pub fn with_preload(mut self, preload: f64) -> Result<Self> {
        self.force.preload = not_negative("preload", preload)?;
        Ok(self)
    }

    /// The law that gives a free body of some mass \[kg\] back so much of its speed.
    ///
    /// # Errors
    /// A restitution outside [0, 1], or 0 where the force ends a contact: no dashpot takes all speed then; a stiffness or a mass that
    /// is not positive.
    pub fn from_restitution(
        restitution: f64,
        stiffness: f64,
        mass: f64,
        release: ContactRelease,
    ) -> Result<Self> {
        let (stiffness, mass) = (positive("stiffness", stiffness)?, positive("mass", mass)?);
        let at_gap = release == ContactRelease::Gap;
        let is_known = restitution <= 1.0 && (restitution > 0.0 || at_gap && restitution == 0.0);
        if !is_known {
            let rule = if at_gap {
                "it must be in [0, 1]"
            } else {
                "it must be in (0, 1]: no dashpot takes all speed where a contact ends with its force"
            };
            return Err(Error::bad_value("restitution", restitution, rule));
        }
        let damping = 2.0 * damping_ratio(restitution, release) * (stiffness * mass).sqrt();
        Self::new(stiffness, damping, Some(release))
    }

    /// The restitution of a free body of some mass \[kg\] that meets the stop at some speed \[m/s\] with nothing else acting; without a preload
    /// it is the same at all speeds.
    ///
    /// # Errors
    /// A mass or a speed that is not positive; no speed where there is a preload.
    pub fn equivalent_restitution(&self, mass: f64, speed: Option<f64>) -> Result<f64> {
        let mass = positive("mass", mass)?;
        let speed = speed.map(|speed| positive("speed", speed)).transpose()?;
        let release = self.ends();
        if self.force.preload == 0.0 {
            return Ok(restitution_of(self.ratio(mass), release));
        }
        let rule = "with a preload the restitution depends on it";
        let speed = speed.ok_or_else(|| Error::bad_value("speed", "None", rule))?;
        let contact = FreeContact::new(self.force, mass, speed);
        Ok(contact.end(release).departure / speed)
    }

    /// Where a contact ends; without damping that is one place.
    fn ends(&self) -> ContactRelease {
        let said = self.release.filter(|_| self.force.damping > 0.0);
        said.unwrap_or(ContactRelease::Gap)
    }

    /// The damping ratio of a mass on the stop alone, `c/(2 sqrt(k m))`.
    fn ratio(&self, mass: f64) -> f64 {
        0.5 * self.force.damping / (self.force.stiffness * mass).sqrt()
    }

    /// The stiffness k \[N/m\].
    pub fn stiffness(&self) -> f64 {
        self.force.stiffness
    }

    /// The damping c \[N s/m\].
    pub fn damping(&self) -> f64 {
        self.force.damping
    }

    /// The preload F0 \[N\].
    pub fn preload(&self) -> f64 {
        self.force.preload
    }

    /// Where a contact ends, if that was said.
    pub fn release(&self) -> Option<ContactRelease> {
        self.release
    }
}

impl ContactLaw for Spring {
    fn action(&self, state: ElementState) -> Action {
        match state {
            ElementState::Pressed => Action::Force(self.force),
            // It is seated: its preload bears what there is.
            ElementState::Held => Action::Constraint,
            _ => Action::Nothing,
        }
    }

    fn guards(&self, state: ElementState) -> &'static [GuardKind] {
        let has_seat = self.force.preload > 0.0;
        match (state, self.ends()) {
            (ElementState::Pressed, ContactRelease::Gap) => &[GuardKind::Approach],
            // Under a preload a slow body is back at the seat before the force is zero.
            (ElementState::Pressed, _) if has_seat => &[GuardKind::Approach, GuardKind::Push],
            (ElementState::Pressed, _) => &[GuardKind::Push],
            (ElementState::Held, _) => &[GuardKind::Force, GuardKind::Excess],
            (ElementState::Idle, _) => &[GuardKind::Approach, GuardKind::Pull],
            (ElementState::Relaxing, _) => &[GuardKind::Distance],
            _ => &[GuardKind::Gap],
        }
    }

    fn outcome(&self, state: ElementState, guard: GuardKind) -> Outcome {
        if guard == GuardKind::Force {
            return Outcome::Release;
        }
        Outcome::Enters(match (state, guard) {
            (ElementState::Pressed, GuardKind::Push) => match self.ends() {
                ContactRelease::Force => ElementState::Relaxing,
                _ => ElementState::Idle,
            },
            (ElementState::Pressed | ElementState::Idle, GuardKind::Approach)
            | (ElementState::Relaxing, GuardKind::Place) => ElementState::Free,
            _ => ElementState::Pressed,
        })
    }

    fn relaxation(&self, state: ElementState) -> Option<Relaxation> {
        let LinearForce {
            stiffness,
            damping,
            preload,
        } = self.force;
        (state == ElementState::Relaxing).then(|| Relaxation {
            rate: stiffness / damping,
            beyond: preload / stiffness,
        })
    }

    fn stored(&self, state: ElementState, gap: f64) -> f64 {
        match state {
            ElementState::Pressed => (0.5 * self.force.stiffness * gap - self.force.preload) * gap,
            _ => 0.0,
        }
    }
}

/// The error of a dashpot without a release, with what each gives a free body of 1 kg back.
fn no_release(stiffness: f64, damping: f64) -> Error {
    let ratio = 0.5 * damping / stiffness.sqrt();
    let each = ContactRelease::ALL.map(|(release, name)| {
        let restitution = restitution_of(ratio, release);
        format!("{restitution:.3} by \"{name}\"")
    });
    let rule = format!(
        "with damping it must say where a contact ends: a free body of 1 kg is given back {} of its speed",
        each.join(", ")
    );
    Error::bad_value("release", "None", rule)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spring(k: f64, c: f64, release: ContactRelease) -> Spring {
        Spring::new(k, c, Some(release)).expect("valid")
    }

    #[test]
    fn a_free_body_is_given_back_what_the_references_say() {
        let of_ratio = |ratio: f64, release| {
            let law = spring(4.0, 4.0 * ratio * 3f64.sqrt(), release);
            law.equivalent_restitution(3.0, None).expect("valid")
        };
        for (ratio, release, wanted) in [
            (0.2, ContactRelease::Gap, 0.526_620_599_330_303),
            (0.2, ContactRelease::Force, 0.571_740_027_584_777),
            (1.5, ContactRelease::Force, 0.075_588_309_364_956_1),
            (1.0, ContactRelease::Force, (-2f64).exp()),
            (1.0, ContactRelease::Gap, 0.0),
            (0.0, ContactRelease::Clipped, 1.0),
        ] {
            let found = of_ratio(ratio, release);
            assert!(
                (found - wanted).abs() < 1e-14,
                "{ratio} {release:?} {found}"
            );
        }
        // Either side of the critical damping ratio.
        for off in [-1e-9, 1e-9] {
            let found = of_ratio(1.0 + off, ContactRelease::Clipped);
            assert!((found - (-2f64).exp()).abs() < 1e-8, "{found}");
        }
        let loaded = spring(4.0, 0.6, ContactRelease::Gap)
            .with_preload(0.3)
            .expect("valid");
        let found = loaded
            .equivalent_restitution(2.0, Some(1.5))
            .expect("valid");
        assert!((found - 0.739_371_429_784_197).abs() < 1e-13, "{found}");
    }

    #[test]
    fn a_slow_body_on_a_preload_keeps_its_speed() {
        for release in [
            ContactRelease::Gap,
            ContactRelease::Force,
            ContactRelease::Clipped,
        ] {
            let law = spring(4.0, 0.6, release).with_preload(1.0).expect("valid");
            let lost = |speed: f64| {
                let kept = law.equivalent_restitution(1.0, Some(speed)).expect("valid");
                (1.0 - kept) / speed
            };
            // The part lost goes like (2/3) c v/F0.
            assert!((lost(1e-4) / 0.4 - 1.0).abs() < 1e-3, "{}", lost(1e-4));
            assert!(lost(1e-12).abs() < 1.0);
        }
        // The contact ends at the seat, and the force there is not zero (theory 22).
        let law = spring(4.0, 0.6, ContactRelease::Force)
            .with_preload(1.0)
            .expect("valid");
        let kept = law.equivalent_restitution(1.0, Some(0.5)).expect("valid");
        assert!((kept - 0.851).abs() < 5e-4, "{kept}");
    }

    #[test]
    fn a_restitution_gives_its_dashpot() {
        for release in [
            ContactRelease::Gap,
            ContactRelease::Force,
            ContactRelease::Clipped,
        ] {
            for wanted in [1.0, 0.9, 0.5, 0.03, 1e-6] {
                let law = Spring::from_restitution(wanted, 70.0, 0.3, release).expect("valid");
                let found = law.equivalent_restitution(0.3, None).expect("valid");
                assert!(
                    (found / wanted - 1.0).abs() < 1e-12,
                    "{release:?} {wanted} {found}"
                );
            }
        }
        let all = Spring::from_restitution(0.0, 70.0, 0.3, ContactRelease::Gap).expect("valid");
        assert_eq!(all.equivalent_restitution(0.3, None), Ok(0.0));
        for wrong in [-0.1, 1.1, f64::NAN] {
            for release in [ContactRelease::Gap, ContactRelease::Force] {
                assert!(Spring::from_restitution(wrong, 70.0, 0.3, release).is_err());
            }
        }
        assert!(Spring::from_restitution(0.0, 70.0, 0.3, ContactRelease::Clipped).is_err());
    }

    #[test]
    fn wrong_numbers_are_refused_by_their_names() {
        for (k, c, name) in [
            (-1.0, 0.0, "stiffness"),
            (f64::NAN, 0.0, "stiffness"),
            (0.0, 1.0, "stiffness"),
            (1.0, -1.0, "damping"),
            (1.0, f64::INFINITY, "damping"),
        ] {
            let error = Spring::new(k, c, Some(ContactRelease::Gap)).expect_err("wrong");
            assert!(error.is_about(name), "{error}");
        }
        let error = Spring::new(1.0, 0.4, None).expect_err("no release");
        assert!(
            error.is_about("release") && error.to_string().contains("0.527 by \"gap\""),
            "{error}"
        );
        let loaded = Spring::new(1.0, 0.0, None).expect("valid");
        assert!(
            loaded
                .with_preload(-1.0)
                .expect_err("wrong")
                .is_about("preload")
        );
        let loaded = loaded.with_preload(1.0).expect("valid");
        assert!(
            loaded
                .equivalent_restitution(1.0, None)
                .expect_err("no speed")
                .is_about("speed")
        );
        assert!(
            loaded
                .equivalent_restitution(0.0, Some(1.0))
                .expect_err("wrong")
                .is_about("mass")
        );
    }
}
