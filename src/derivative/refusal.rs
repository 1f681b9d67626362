//! Where an orbit has no derivatives: it is at a boundary of its motions, beyond which they are others, or at a fold.

use crate::derivative::loop_rates::Loop;
use crate::error::Result;
use crate::orbit::Extremes;
use crate::tolerance::{COINCIDENT_INSTANTS, FAMILY_PART, SHORT_CONTACT, SINGULAR_LOOP, TOUCHED};
use nalgebra::DVector;

/// The stop that an orbit touches, without an impact or by one without speed.
fn touched(own: &Loop, extremes: &Extremes) -> Result<Option<usize>> {
    if extremes.touched.is_some() {
        return Ok(extremes.touched);
    }
    own.in_scene(&own.scene, |shooting, units| {
        let ends = shooting.flight_ends(&own.state, units)?;
        for (k, end) in ends.iter().enumerate() {
            let x = &end.before;
            let (n, time) = (x.len() / 2, own.state.times[k + 1]);
            for stop in shooting.closing(k + 1) {
                let at = shooting.motion.gap(stop, time, x)?;
                let slow = TOUCHED * units.velocity * at.gradient.amax();
                if at.speed(x.rows(n, n)).abs() <= slow {
                    return Ok(Some(stop));
                }
            }
        }
        Ok(None)
    })
}

/// Why an orbit has no derivatives, if it has none by any number.
pub(super) fn refusal(own: &Loop, extremes: &Extremes) -> Result<Option<String>> {
    let (state, stages) = (&own.state, &own.signature.stages);
    let (rows, unknowns) = own.shape;
    if rows < unknowns {
        let reason = "without forcing it hits nothing that gives it a phase: there is one for each";
        return Ok(Some(reason.to_owned()));
    }
    if rows > unknowns {
        let stops = stages.hit_together().map_or(String::new(), |stops| {
            format!(" {} and {}", stops[0], stops[1])
        });
        return Ok(Some(format!(
            "the orbit hits stops{stops} together: it would hit one of them first"
        )));
    }
    if let Some(stop) = touched(own, extremes)? {
        return Ok(Some(format!(
            "the orbit grazes stop {stop}: one-sided only"
        )));
    }
    let period = state.times[state.times.len() - 1] - state.times[0];
    for (k, stage) in stages.iter().enumerate() {
        let span = state.times[k + 1] - state.starts[k];
        if let (Some(stop), true) = (stage.regime.contact(), span <= SHORT_CONTACT * period) {
            return Ok(Some(format!(
                "the contact with stop {stop} ends as it begins: one-sided only"
            )));
        }
        if span <= COINCIDENT_INSTANTS * period {
            return Ok(Some(
                "two instants of the orbit meet: one-sided only".to_owned(),
            ));
        }
    }
    Ok(None)
}

/// Why an orbit has no derivative by a number with which its equations change so, where they are singular.
pub(super) fn singular(own: &Loop, of_equations: &DVector<f64>) -> Option<&'static str> {
    let values = own.singular_values();
    let (least, largest) = (values.first()?, values.last()?);
    if least.0 > SINGULAR_LOOP * largest.0 {
        return None;
    }
    let part = own.left_part(least.1, of_equations).abs();
    Some(if part > FAMILY_PART * of_equations.norm() {
        "the orbit is at a fold, where its derivatives are infinite"
    } else {
        "the orbit is one of a family, or branches meet there"
    })
}
