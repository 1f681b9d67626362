//! A stop of elastic bodies that touch in a point or along a line: the force `k p^m` on the approach p = -h, m = 3/2 of spheres, with a
//! dissipation by Hunt and Crossley, `k p^m (1 + d p')`, or by Tsuji, `k p^m + c p^((m-1)/2) p'`. A motion before it has no closed form.
//!
//! A free body is given back by the first what solves `x (1 + e) = ln((1 + x)/(1 - e x))`, x = d v0, at any m and k; by the other, in
//! `y = p^((m+1)/2)`, what a spring with the damping ratio `c/sqrt(2 (m + 1) k M)` gives (theory 22).

use crate::error::{Error, Result};
use crate::law::contact_law::{Action, ContactLaw, ForceAt, Outcome};
use crate::law::contact_release::ContactRelease;
use crate::law::free_contact::restitution_of;
use crate::law::guard::GuardKind;
use crate::law::regime::ElementState;
use crate::quantity::{not_negative, positive, positive_part};
use crate::root::{Bracket, bisected};
use std::convert::Infallible;

/// The exponent of spheres. [exact]
const SPHERES: f64 = 1.5;
/// Terms of the series of `y - ln(1 + y)` of a small y. [work]
const MOST_LOGARITHM_TERMS: i32 = 40;
/// A small one. [exact]
const SMALL: f64 = 0.25;

/// What takes energy in a contact of [`Hertz`].
#[derive(Debug, Clone, Copy, PartialEq)]
enum Dissipation {
    /// d \[s/m\]: the force `k p^m (1 + d p')`, none where that would pull.
    HuntCrossley(f64),
    /// c: the force `k p^m + c p^((m-1)/2) p'`, and where a contact ends.
    Tsuji(f64, Option<ContactRelease>),
}

/// Law of elastic bodies that touch: a force k p^m pushes against the approach p = -gap while that is positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hertz {
    stiffness: f64,
    exponent: f64,
    dissipation: Dissipation,
}

impl Hertz {
    /// The law of a stiffness k \[N/m^m\] and the exponent 3/2, that of spheres, without damping.
    ///
    /// # Errors
    /// A stiffness that is not positive.
    pub fn new(stiffness: f64) -> Result<Self> {
        Ok(Self {
            stiffness: positive("stiffness", stiffness)?,
            exponent: SPHERES,
            dissipation: Dissipation::HuntCrossley(0.0),
        })
    }

    /// The same with an exponent m \[-\], at least one.
    ///
    /// # Errors
    /// An exponent below one, or that is not finite.
    pub fn with_exponent(mut self, exponent: f64) -> Result<Self> {
        if !(exponent >= 1.0 && exponent.is_finite()) {
            let rule =
                "it must be at least 1: below that the force of a touch has an infinite slope";
            return Err(Error::bad_value("exponent", exponent, rule));
        }
        self.exponent = exponent;
        Ok(self)
    }

    /// The same with the damping d \[s/m\] of Hunt and Crossley, `k p^m (1 + d p')`, which never pulls.
    ///
    /// # Errors
    /// A damping that is negative or not finite.
    pub fn with_hunt_crossley(mut self, damping: f64) -> Result<Self> {
        self.dissipation = Dissipation::HuntCrossley(not_negative("damping", damping)?);
        Ok(self)
    }

    /// The same with the damping c of Tsuji, `k p^m + c p^((m-1)/2) p'`, and where a contact ends.
    ///
    /// # Errors
    /// A damping that is negative or not finite, damping without a release, a release by the force with a place of its own.
    pub fn with_tsuji(mut self, damping: f64, release: Option<ContactRelease>) -> Result<Self> {
        let damping = not_negative("damping", damping)?;
        if damping > 0.0 && release.is_none() {
            let rule = "with damping by Tsuji it must say where a contact ends: \"gap\", where the gap opens, or \"clipped\", where the force is zero";
            return Err(Error::bad_value("release", "None", rule));
        }
        if release == Some(ContactRelease::Force) {
            let rule = "a stop by Tsuji comes back to its place in no time that ends: \"gap\" and \"clipped\" know no place";
            return Err(Error::bad_value("release", "\"force\"", rule));
        }
        self.dissipation = Dissipation::Tsuji(damping, release);
        Ok(self)
    }

    /// The restitution of a free body of some mass \[kg\] that meets the stop at some speed \[m/s\] with nothing else acting; without damping and
    /// by Tsuji it is the same at all speeds.
    ///
    /// # Errors
    /// A mass or a speed that is not positive; no speed where there is damping by Hunt and Crossley.
    pub fn equivalent_restitution(&self, mass: f64, speed: Option<f64>) -> Result<f64> {
        let mass = positive("mass", mass)?;
        let speed = speed.map(|speed| positive("speed", speed)).transpose()?;
        match self.dissipation {
            Dissipation::HuntCrossley(0.0) => Ok(1.0),
            Dissipation::HuntCrossley(damping) => {
                let rule = "with damping by Hunt and Crossley the restitution depends on it";
                let speed = speed.ok_or_else(|| Error::bad_value("speed", "None", rule))?;
                Ok(given_back(damping * speed))
            }
            Dissipation::Tsuji(damping, _) => {
                let size = (2.0 * (self.exponent + 1.0) * self.stiffness * mass).sqrt();
                Ok(restitution_of(damping / size, self.ends()))
            }
        }
    }

    /// Where a contact ends; without damping that is one place.
    fn ends(&self) -> ContactRelease {
        match self.dissipation {
            Dissipation::HuntCrossley(damping) if damping > 0.0 => ContactRelease::Clipped,
            Dissipation::Tsuji(damping, Some(release)) if damping > 0.0 => release,
            _ => ContactRelease::Gap,
        }
    }

    /// The stiffness k \[N/m^m\].
    pub fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// The exponent m \[-\].
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// The damping, of Hunt and Crossley d \[s/m\], of Tsuji c.
    pub fn damping(&self) -> f64 {
        match self.dissipation {
            Dissipation::HuntCrossley(damping) | Dissipation::Tsuji(damping, _) => damping,
        }
    }

    /// Whether its damping is that of Tsuji.
    pub fn is_by_tsuji(&self) -> bool {
        matches!(self.dissipation, Dissipation::Tsuji(..))
    }

    /// Where a contact ends, if that was said.
    pub fn release(&self) -> Option<ContactRelease> {
        match self.dissipation {
            Dissipation::Tsuji(_, release) => release,
            Dissipation::HuntCrossley(_) => None,
        }
    }

    /// The same with another damping.
    ///
    /// # Errors
    /// As the damping has them.
    pub(crate) fn with_damping(self, damping: f64) -> Result<Self> {
        match self.dissipation {
            Dissipation::HuntCrossley(_) => self.with_hunt_crossley(damping),
            Dissipation::Tsuji(_, release) => self.with_tsuji(damping, release),
        }
    }

    /// The same with another stiffness.
    ///
    /// # Errors
    /// A stiffness that is not positive.
    pub(crate) fn with_stiffness(mut self, stiffness: f64) -> Result<Self> {
        self.stiffness = positive("stiffness", stiffness)?;
        Ok(self)
    }
}

impl ContactLaw for Hertz {
    fn action(&self, state: ElementState) -> Action {
        match state {
            ElementState::Pressed => Action::Curve,
            _ => Action::Nothing,
        }
    }

    fn guards(&self, state: ElementState) -> &'static [GuardKind] {
        match (state, self.ends()) {
            (ElementState::Pressed, ContactRelease::Gap) => &[GuardKind::Approach],
            (ElementState::Pressed, _) => &[GuardKind::Approach, GuardKind::Push],
            (ElementState::Idle, _) => &[GuardKind::Approach, GuardKind::Pull],
            _ => &[GuardKind::Gap],
        }
    }

    fn outcome(&self, state: ElementState, guard: GuardKind) -> Outcome {
        Outcome::Enters(match (state, guard) {
            (ElementState::Pressed, GuardKind::Push) => ElementState::Idle,
            (ElementState::Pressed | ElementState::Idle, GuardKind::Approach) => ElementState::Free,
            _ => ElementState::Pressed,
        })
    }

    fn force_at(&self, approach: f64, rate: f64) -> ForceAt {
        let (p, m) = (positive_part(approach), self.exponent);
        let elastic = self.stiffness * p.powf(m);
        let slope = m * self.stiffness * p.powf(m - 1.0);
        match self.dissipation {
            Dissipation::HuntCrossley(damping) => ForceAt {
                value: elastic * (1.0 + damping * rate),
                by_approach: slope * (1.0 + damping * rate),
                by_rate: elastic * damping,
            },
            Dissipation::Tsuji(damping, _) => {
                let half = 0.5 * (m - 1.0);
                let dashpot = damping * p.powf(half);
                let steeper = if half > 0.0 && p > 0.0 {
                    half * dashpot / p
                } else {
                    0.0
                };
                ForceAt {
                    value: elastic + dashpot * rate,
                    by_approach: slope + steeper * rate,
                    by_rate: dashpot,
                }
            }
        }
    }

    fn grip(&self, approach: f64, rate: f64) -> ForceAt {
        match self.dissipation {
            // The force over k p^m, which is zero where the gap opens.
            Dissipation::HuntCrossley(damping) => ForceAt {
                value: 1.0 + damping * rate,
                by_approach: 0.0,
                by_rate: damping,
            },
            // That over p^((m-1)/2).
            Dissipation::Tsuji(damping, _) => {
                let (p, m) = (positive_part(approach), 0.5 * (self.exponent + 1.0));
                ForceAt {
                    value: self.stiffness * p.powf(m) + damping * rate,
                    by_approach: m * self.stiffness * p.powf(m - 1.0),
                    by_rate: damping,
                }
            }
        }
    }

    fn stored(&self, state: ElementState, gap: f64) -> f64 {
        match state {
            ElementState::Pressed => {
                let order = self.exponent + 1.0;
                self.stiffness * positive_part(-gap).powf(order) / order
            }
            _ => 0.0,
        }
    }
}

/// What a free body is given back of its speed v0 by the damping d of Hunt and Crossley, x = d v0: with `phi(y) = y - ln(1 + y)`, which is the
/// same at x and at -e x.
fn given_back(x: f64) -> f64 {
    let wanted = phi(x);
    let Ok(found) = bisected(Bracket::new([0.0, x.min(1.0)]), 0.0, |u| {
        Ok::<_, Infallible>(phi(-u) < wanted)
    });
    found.after / x
}

/// `y - ln(1 + y)`
fn phi(y: f64) -> f64 {
    if y.abs() > SMALL {
        return y - y.ln_1p();
    }
    let terms = (2..MOST_LOGARITHM_TERMS).rev();
    terms.fold(0.0, |sum, k| sum * -y + 1.0 / f64::from(k)) * y * y
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hertz(k: f64) -> Hertz {
        Hertz::new(k).expect("valid")
    }

    #[test]
    fn a_free_body_is_given_back_what_the_references_say() {
        let back = |x: f64| {
            let law = hertz(7.0).with_hunt_crossley(2.0 * x).expect("valid");
            law.equivalent_restitution(3.0, Some(0.5)).expect("valid")
        };
        assert!((back(0.6) - 0.711_950_179_577_866).abs() < 1e-14);
        for x in [1e-12, 1e-6, 1e-2, 0.2, 0.3, 1.0, 30.0] {
            let e = back(x);
            let left = x * (1.0 + e) - ((1.0 + x) / (1.0 - e * x)).ln();
            assert!(
                left.abs() <= 4e-15 * (1.0 + x) / (1.0 - e * x),
                "{x} {e} {left}"
            );
        }
        // e = 1 - 2/3 x, and 1/x of a large x.
        assert!((back(1e-7) - (1.0 - 2e-7 / 3.0)).abs() < 1e-13);
        assert!((back(60.0) * 60.0 - 1.0).abs() < 1e-14);
        assert_eq!(hertz(1.0).equivalent_restitution(1.0, None), Ok(1.0));
    }

    #[test]
    fn by_tsuji_it_is_that_of_a_spring() {
        for (m, release, wanted) in [
            (1.5, ContactRelease::Gap, 0.526_620_599_330_303),
            (1.0, ContactRelease::Clipped, 0.571_740_027_584_777),
            (3.0, ContactRelease::Clipped, 0.571_740_027_584_777),
        ] {
            let damping = 0.2 * f64::sqrt(2.0 * (m + 1.0) * 7.0 * 3.0);
            let law = hertz(7.0)
                .with_exponent(m)
                .and_then(|own| own.with_tsuji(damping, Some(release)));
            let found = law.expect("valid").equivalent_restitution(3.0, None);
            assert!((found.expect("valid") - wanted).abs() < 1e-14);
        }
    }

    #[test]
    fn forces_have_their_slopes_and_no_pull() {
        let spheres = hertz(40.0);
        let all = [
            spheres,
            spheres.with_exponent(2.2).expect("valid"),
            spheres.with_hunt_crossley(0.7).expect("valid"),
            spheres
                .with_tsuji(3.0, Some(ContactRelease::Clipped))
                .expect("valid"),
        ];
        let step = 1e-6;
        for law in all {
            for (p, rate) in [(0.3, 0.8), (0.02, -0.4), (1.7, 0.0)] {
                for of in [ContactLaw::force_at, ContactLaw::grip] {
                    let own = of(&law, p, rate);
                    let by = |dp: f64, dr: f64| {
                        let (ahead, behind) =
                            (of(&law, p + dp, rate + dr), of(&law, p - dp, rate - dr));
                        (ahead.value - behind.value) / (2.0 * step)
                    };
                    let size = own.value.abs() + own.by_approach.abs();
                    assert!((by(step, 0.0) - own.by_approach).abs() < 1e-7 * (1.0 + size));
                    assert!((by(0.0, step) - own.by_rate).abs() < 1e-7 * (1.0 + size));
                }
                // Both have one sign.
                let signs = [law.force_at(p, rate).value, law.grip(p, rate).value];
                assert!(signs[0] * signs[1] > 0.0);
            }
            let outside = law.force_at(-0.1, -0.2);
            assert_eq!(outside.value, 0.0);
            let work = |p: f64| law.stored(ElementState::Pressed, -p);
            let elastic = (work(0.3 + step) - work(0.3 - step)) / (2.0 * step);
            assert!((elastic - law.force_at(0.3, 0.0).value).abs() < 1e-7);
        }
    }

    #[test]
    fn wrong_numbers_are_refused_by_their_names() {
        let refused = |made: Result<Hertz>, name: &str| {
            let error = made.expect_err("wrong");
            assert!(error.is_about(name), "{error}");
        };
        refused(Hertz::new(0.0), "stiffness");
        refused(hertz(1.0).with_exponent(0.9), "exponent");
        refused(hertz(1.0).with_exponent(f64::INFINITY), "exponent");
        refused(hertz(1.0).with_hunt_crossley(-1.0), "damping");
        refused(hertz(1.0).with_tsuji(1.0, None), "release");
        refused(
            hertz(1.0).with_tsuji(1.0, Some(ContactRelease::Force)),
            "release",
        );
        let damped = hertz(1.0).with_hunt_crossley(1.0).expect("valid");
        let error = damped
            .equivalent_restitution(1.0, None)
            .expect_err("no speed");
        assert!(error.is_about("speed"));
    }
}
