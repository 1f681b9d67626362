//! How long steps are (theory 19).

/// A step is refused if the second correction is longer than this part of the first, or if the branch turns by more than this angle.
const MOST_CONTRACTION: f64 = 0.5;
const MOST_ANGLE: f64 = 0.35;
/// The contraction and the angle that steps are to have, and the changes of a step from one to the next.
const USUAL_CONTRACTION: f64 = 0.1;
const USUAL_ANGLE: f64 = 0.15;
const GROWTH: std::ops::RangeInclusive<f64> = 0.25..=2.0;
/// What comes back has this part of its direction there.
pub(super) const SAME_WAY: f64 = 0.9;

/// The factor on the next step after one with some contraction, along which the direction has kept a part of itself; why it is not to be
/// trusted.
pub(super) fn step_factor(contraction: f64, along: f64) -> std::result::Result<f64, &'static str> {
    if contraction > MOST_CONTRACTION {
        return Err("Newton's method hardly converges");
    }
    let angle = along.abs().min(1.0).acos();
    if angle > MOST_ANGLE {
        return Err("the branch turns sharply");
    }
    let factor = (USUAL_CONTRACTION / contraction)
        .sqrt()
        .min(USUAL_ANGLE / angle);
    Ok(factor.clamp(*GROWTH.start(), *GROWTH.end()))
}
