//! Control of the length of steps by the convergence of Newton's method and by the turn of the tangent (theory 19).

use crate::tolerance::{
    STEP_ANGLE_LIMIT, STEP_CONTRACTION_LIMIT, STEP_GROWTH, USUAL_STEP_ANGLE, USUAL_STEP_CONTRACTION,
};

/// The factor on the next step, by the contraction of Newton's method and the cosine between the tangents at both ends; or why the step is
/// refused.
pub(crate) fn step_factor(contraction: f64, along: f64) -> std::result::Result<f64, &'static str> {
    if contraction > STEP_CONTRACTION_LIMIT {
        return Err("Newton's method hardly converges");
    }
    let angle = along.abs().min(1.0).acos();
    if angle > STEP_ANGLE_LIMIT {
        return Err("the branch turns sharply");
    }
    let factor = (USUAL_STEP_CONTRACTION / contraction)
        .sqrt()
        .min(USUAL_STEP_ANGLE / angle);
    Ok(factor.clamp(*STEP_GROWTH.start(), *STEP_GROWTH.end()))
}
