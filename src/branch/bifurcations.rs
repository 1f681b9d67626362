//! Smooth bifurcations on a step of a branch (theory 19).

use crate::branch::corrector::Settled;
use crate::branch::crossings::has_multiplier;
use crate::branch::family::Family;
use crate::branch::interpolated::zero_through;
use crate::branch::multipliers::{own_multipliers, pair_at_circle};
use crate::branch::special::{Special, SpecialKind};
use crate::branch::step::{Point, Target, step_to};
use crate::branch::zero::{Tried, Zero, zero_between};
use crate::error::Result;
use crate::orbit::PeriodicOrbit;
use nalgebra::Complex;
use std::f64::consts::TAU;

/// What is known no better than this part of the range is sought by interpolation.
const KNOWN: f64 = 1e-10;

/// The bifurcations on a step of some length, by the indicators whose signs are not the same at its ends, in their order.
pub(super) fn bifurcations(
    family: &Family<'_>,
    from: &Point,
    to: &Point,
    length: f64,
) -> Result<Vec<Special>> {
    let (a, b) = (&from.indicators, &to.indicators);
    let fold = |settled: &Settled| Ok(settled.tangent.value_part);
    let doubling = |settled: &Settled| family.multiplier_test((&settled.place, None), -1.0);
    let crossing = |settled: &Settled| Ok(settled.equations.crossing(&settled.tangent));
    let is_half = family.signature.images.is_some();
    let doubled = if is_half {
        SpecialKind::Pitchfork
    } else {
        SpecialKind::PeriodDoubling
    };
    let tests: [(SpecialKind, [f64; 2], Test<'_>); 3] = [
        (SpecialKind::Fold, [a.fold, b.fold], &fold),
        (doubled, [a.doubling, b.doubling], &doubling),
        (
            SpecialKind::BranchPoint,
            [a.crossing, b.crossing],
            &crossing,
        ),
    ];
    let mut all = Vec::new();
    for (kind, [at_start, at_end], of) in tests {
        if at_start * at_end < 0.0 {
            let ends = [length, at_start, at_end];
            let found = located(family, (from, to, kind), ends, of)?;
            if kind != SpecialKind::PeriodDoubling || has_multiplier(family, &found, -1.0)? {
                all.push(found);
            }
        }
    }
    if let (true, Some(one), Some(other)) = (all.is_empty(), a.outside, b.outside)
        && one.abs_diff(other) == 2
    {
        all.extend(torus(family, (from, to), (length, one))?);
    }
    all.sort_by(|a, b| a.arclength.total_cmp(&b.arclength));
    Ok(all)
}

/// A number at a point of a step.
type Test<'a> = &'a dyn Fn(&Settled) -> Result<f64>;

/// Where a number is zero on a step.
fn located(
    family: &Family<'_>,
    (from, to, kind): (&Point, &Point, SpecialKind),
    between: [f64; 3],
    of: Test<'_>,
) -> Result<Special> {
    let mut point = |along: f64| {
        let Ok(settled) = step_to(family, from.foot(), Target::Length(along))? else {
            return Ok(None);
        };
        Ok(Some(Tried {
            parameter: settled.place.value,
            value: of(&settled)?,
            point: settled,
        }))
    };
    let found = zero_between(between, family.span(), &mut point)?;
    // Next to a crossing no point is reached, or what is reached is not known well.
    let is_beside_crossing = kind == SpecialKind::BranchPoint
        || kind != SpecialKind::Torus
            && found
                .as_ref()
                .is_none_or(|own| own.error > KNOWN * family.span());
    let through = if is_beside_crossing {
        let near = found.as_ref().map_or(0.5 * between[0], |own| own.along);
        zero_through(family, from, near, of)?
    } else {
        None
    };
    let found = if kind == SpecialKind::BranchPoint {
        through.or(found)
    } else {
        let both = through.into_iter().chain(found);
        both.min_by(|a, b| a.error.total_cmp(&b.error))
    };
    let Some(Zero {
        point: settled,
        along,
        error,
    }) = found
    else {
        // It is known to lie on the step.
        let width = (to.place.value - from.place.value).abs();
        return Ok(Special::at(kind, to, width));
    };
    let point = Point {
        orbit: family.orbit(&settled.place)?,
        place: settled.place,
        equations: settled.equations,
        tangent: settled.tangent,
        arclength: from.arclength + along,
        indicators: from.indicators,
    };
    let error = error.max(f64::EPSILON * family.span());
    Ok(Special::at(kind, &point, error))
}

/// Where two conjugate multipliers pass through the unit circle, and so many are outside before; none where they are real there.
fn torus(
    family: &Family<'_>,
    (from, to): (&Point, &Point),
    (length, before): (f64, usize),
) -> Result<Option<Special>> {
    if family.has_pulses {
        // Of many modes they are counted alone: halves.
        let off = |settled: &Settled| {
            let outside = family.n_outside_of_pulses(&settled.place);
            Ok(if outside == Some(before) { -1.0 } else { 1.0 })
        };
        let between = [length, -1.0, 1.0];
        let found = located(family, (from, to, SpecialKind::Torus), between, &off)?;
        let (value, range) = (found.parameter, family.range);
        let (there, place) = Family::around(&found.orbit, family.make, value, range)?;
        let (there, place) = there.by_pulses(place)?;
        return Ok(on_circle(found, there.pulse_multiplier(&place)));
    }
    let size = |orbit: &PeriodicOrbit| -> Result<(f64, usize)> {
        let own = own_multipliers(orbit)?.unwrap_or_default();
        let size = pair_at_circle(&own).map_or(1.0, |mu| mu.norm().ln().abs());
        // Without a margin: the pair is on the circle at the point itself.
        Ok((size, own.iter().filter(|mu| mu.norm() > 1.0).count()))
    };
    let off = |settled: &Settled| -> Result<f64> {
        let (size, outside) = size(&family.orbit(&settled.place)?)?;
        Ok(if outside == before { -size } else { size })
    };
    let between = [length, -size(&from.orbit)?.0, size(&to.orbit)?.0];
    let found = located(family, (from, to, SpecialKind::Torus), between, &off)?;
    let own = own_multipliers(&found.orbit)?.unwrap_or_default();
    Ok(on_circle(found, pair_at_circle(&own)))
}

/// A torus, if a multiplier is on the circle there.
fn on_circle(found: Special, multiplier: Option<Complex<f64>>) -> Option<Special> {
    let pair = multiplier.filter(|mu| mu.norm().ln().abs() < ON_CIRCLE);
    pair.map(|mu| Special {
        rotation: Some(mu.arg() / TAU),
        ..found
    })
}

/// A pair is on the circle if the logarithm of its modulus is below this.
const ON_CIRCLE: f64 = 1e-6;
