//! What becomes of a motion beyond a boundary at which its branch ends (theory 19, "Grazing"): by the orbits that meet the branch there, else
//! by simulations that begin ever nearer to the boundary.

use crate::attractor::{Attractor, AttractorOptions, StateBox, find_attractors};
use crate::branch::beyond_outcome::{Beyond, BeyondOptions, BeyondOutcome};
use crate::branch::candidate::Candidate;
use crate::branch::continuation_parameter::ContinuationParameter;
use crate::branch::options::ContinuationOptions;
use crate::branch::simulations_beyond::{KickFn, KickedMotion, NearingMotions, or_reason};
use crate::branch::special::Special;
use crate::branch::switching::branches;
use crate::error::{Error, Result, digits};
use crate::orbit::PeriodicOrbit;
use crate::tolerance::{KICK_SIZE, KICKED_BOX, SIMULATED_DISTANCE};
use nalgebra::DMatrix;

/// Periods after which a motion that has not settled is told by its exponents, at least. [work]
const LEAST_MOST_PERIODS: usize = 2000;

/// What becomes of a motion beyond a boundary of its branch, which goes over a range.
///
/// A candidate beyond that is stable and keeps the rules of contact "continues". Else simulations begin at the last orbit, kicked: `kick`
/// gives so many numbers in (-1, 1), by which the state is displaced in parts of 1e-6 of its size. Where what they come to is the nearer to
/// the last orbit the nearer they begin to the boundary, the motion continues; where it stays as far, it jumps.
///
/// # Errors
/// A special point that is no boundary; motions that keep their energy; a distance or a count that is not above zero;
/// `Error::Interrupted` when the observer of the thread breaks off. Where nothing is found, or it cannot be known, the answer says so.
///
/// # References
/// Theory section 19.
pub fn beyond(
    special: &Special,
    parameter: ContinuationParameter<'_>,
    (low, high): (f64, f64),
    options: BeyondOptions,
    kick: KickFn<'_>,
) -> Result<Beyond> {
    if !special.kind.is_boundary() {
        let rule = "beyond is asked of a boundary of motion, at which a branch ends";
        return Err(Error::bad_value("special", special.kind.name(), rule));
    }
    if matches!(parameter, ContinuationParameter::Energy) {
        let value = format!("{}, of motions that keep their energy", special.kind.name());
        return Err(Error::bad_value(
            "special",
            value,
            "they settle on nothing beyond it",
        ));
    }
    let delta = options.delta.unwrap_or(SIMULATED_DISTANCE * (high - low));
    if !(delta.is_finite() && delta > 0.0) {
        return Err(Error::bad_value("delta", delta, "it must be above 0"));
    }
    if options.periods == 0 {
        return Err(Error::bad_value("periods", 0, "it must be at least 1"));
    }
    let last = special.direction.len() - 1;
    let is_far_above = special.direction[last] >= 0.0;
    let ahead = if is_far_above { delta } else { -delta };
    let value = special.parameter + ahead;
    // What does not close, or has no scene, is none.
    let candidates = or_reason(branches(special, parameter, (low, high)))?.unwrap_or_default();
    for own in candidates.iter().filter(|own| own.is_above == is_far_above) {
        if let Some(at) = goes_on(special, parameter, own, value)? {
            return Ok(Beyond {
                outcome: BeyondOutcome::Continues,
                candidates,
                attractor: None,
                reason: format!("a stable orbit goes on at {}", digits(at)),
            });
        }
    }
    let mut motions = NearingMotions {
        special,
        parameter,
        periods: options.periods,
        kick,
    };
    let (outcome, seen) = motions.outcome(ahead)?;
    let mut found = Beyond {
        outcome,
        candidates,
        attractor: None,
        reason: seen,
    };
    if outcome == BeyondOutcome::Continues {
        return Ok(found);
    }
    let (attractor, reason) = settled(&mut motions, value)?;
    found.attractor = attractor;
    if outcome == BeyondOutcome::Undecided {
        found.reason = format!("{}; {reason}", found.reason);
        return Ok(found);
    }
    found.reason = reason;
    for own in found
        .candidates
        .iter()
        .filter(|own| own.is_above != is_far_above)
    {
        let orbit = &own.orbit;
        if orbit.is_admissible() == Some(true) && orbit.stability()?.is_stable == Some(false) {
            found.outcome = BeyondOutcome::NonsmoothFold;
        }
    }
    Ok(found)
}

/// Where a candidate is stable and keeps the rules of contact: at a value, or nearer to the boundary.
fn goes_on(
    special: &Special,
    parameter: ContinuationParameter<'_>,
    candidate: &Candidate,
    value: f64,
) -> Result<Option<f64>> {
    let orbit = &candidate.orbit;
    if orbit.is_admissible() == Some(false) {
        return Ok(None);
    }
    let is_seen = |orbit: &PeriodicOrbit| -> Result<bool> {
        let is_stable = orbit.stability()?.is_stable;
        Ok(is_stable == Some(true) && orbit.is_admissible() == Some(true))
    };
    let (low, high) = (special.parameter.min(value), special.parameter.max(value));
    if (low..=high).contains(&candidate.parameter) {
        let begin = (orbit, Some(candidate.parameter));
        let options = ContinuationOptions::default();
        let branch = parameter.continuation(begin, (low, high), &options);
        let there = branch.and_then(|branch| branch.at(parameter, value));
        // Where it ends before the value, there is none.
        for own in or_reason(there)?.unwrap_or_default() {
            if is_seen(&own)? {
                return Ok(Some(value));
            }
        }
    }
    Ok(is_seen(orbit)?.then_some(candidate.parameter))
}

/// What a simulation from the last orbit comes to at a value, and how that was found.
fn settled(
    motions: &mut NearingMotions<'_, '_>,
    value: f64,
) -> Result<(Option<Attractor>, String)> {
    let periods = motions.periods;
    let KickedMotion {
        scene,
        state: (q, v),
        sizes,
        ..
    } = match or_reason(motions.kicked(value))? {
        Ok(begun) => begun,
        Err(reason) => {
            return Ok((
                None,
                format!("there is no scene at {}: {reason}", digits(value)),
            ));
        }
    };
    let around = StateBox::new(-KICKED_BOX * &sizes, KICKED_BOX * &sizes);
    let seeds = DMatrix::from_iterator(1, sizes.len(), q.iter().chain(v.iter()).copied());
    let options = AttractorOptions {
        phase: scene.phase(),
        transient: periods,
        max_periods: LEAST_MOST_PERIODS.max(2 * periods),
        ..AttractorOptions::default()
    };
    let found = around.and_then(|around| find_attractors(&scene, &around, &seeds, &options));
    let said = format!(
        "{periods} periods from the last orbit, kicked by {KICK_SIZE:e} of its size, at {}",
        digits(value)
    );
    Ok(match or_reason(found)? {
        Err(reason) => (None, format!("not simulated: {reason}")),
        Ok(found) => match found.all.into_iter().next() {
            None => (None, format!("undecided after {said}")),
            attractor => (attractor, said),
        },
    })
}
