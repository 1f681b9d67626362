//! What the multipliers along a branch do between two points, against the special points that are said to lie between.

use nalgebra::Complex;
use vibroimpact::{Branch, PeriodicOrbit, Special, SpecialKind};

/// A real multiplier is on one side of a number for sure if it is so far from it.
const MARGIN: f64 = 1e-7;
/// The roundings of the largest multiplier, beside a graze far larger than all others, that these are known to.
const ROUNDED: f64 = 1e-14;
/// A loop closes to 1e-11: over a speed of this part of the fastest that is a hundredth.
const NEARLY_LOST: f64 = 1e-9;

/// Others are next to the circle at a special point if they are so near.
const BESIDE: f64 = 1e-5;
/// Steps shorter than this are not divided.
const UNDIVIDED: f64 = 1e-5;

fn is_bifurcation(kind: SpecialKind) -> bool {
    matches!(
        kind,
        SpecialKind::Fold
            | SpecialKind::Pitchfork
            | SpecialKind::BranchPoint
            | SpecialKind::PeriodDoubling
            | SpecialKind::Torus
    )
}

/// How many multipliers are outside the unit circle, real and above 1, real and below -1; none where one of them is next to it.
fn outside(all: &[Complex<f64>]) -> Option<[usize; 3]> {
    let largest = all.iter().map(|mu| mu.norm()).fold(0.0, f64::max);
    let margin = MARGIN.max(ROUNDED * largest);
    if all.iter().any(|mu| (mu.norm() - 1.0).abs() < margin) {
        return None;
    }
    let count = |is: &dyn Fn(&Complex<f64>) -> bool| all.iter().filter(|mu| is(mu)).count();
    Some([
        count(&|mu| mu.norm() > 1.0),
        count(&|mu| mu.im == 0.0 && mu.re > 1.0),
        count(&|mu| mu.im == 0.0 && mu.re < -1.0),
    ])
}

/// The multipliers of all points, none where an orbit has none.
fn multipliers(branch: &Branch) -> Vec<Option<[usize; 3]>> {
    let of = |orbit: &PeriodicOrbit| {
        let stability = orbit.stability().ok()?;
        let order = stability.orders.first()?;
        let all: Vec<_> = order.multipliers.iter().copied().collect();
        outside(&all)
    };
    branch.orbits.iter().map(of).collect()
}

/// What is said otherwise than the multipliers do, if anything; and how many pairs of points were looked at, and changes seen.
pub fn difference(branch: &Branch) -> (Option<String>, [usize; 2]) {
    let all = multipliers(branch);
    let mut seen = [0; 2];
    for k in 1..all.len() {
        let (Some(one), Some(other)) = (all[k - 1], all[k]) else {
            continue;
        };
        seen[0] += 1;
        seen[1] += one[0].abs_diff(other[0]);
        let within = branch.arclength[k - 1]..=branch.arclength[k];
        let between = branch.special.iter();
        let between: Vec<SpecialKind> = between
            .filter(|own| within.contains(&own.arclength) && !is_of_a_release(own))
            .map(|own| own.kind)
            .collect();
        let number = |kinds: &[SpecialKind]| {
            let own = between.iter().filter(|kind| kinds.contains(kind));
            own.count()
        };
        let ones = number(&[
            SpecialKind::Fold,
            SpecialKind::Pitchfork,
            SpecialKind::BranchPoint,
        ]);
        let minus = number(&[SpecialKind::PeriodDoubling]);
        // The multiplier of an impact without speed is infinite: it passes from one side of the real axis to the other.
        let lost = lost(&branch.orbits[k - 1], &branch.orbits[k]);
        let most = ones + minus + 2 * number(&[SpecialKind::Torus]);
        let is_even = |a: usize, b: usize| (a + b).is_multiple_of(2);
        let own: Vec<&Special> = branch
            .special
            .iter()
            .filter(|own| within.contains(&own.arclength) && !is_of_a_release(own))
            .filter(|own| is_bifurcation(own.kind))
            .collect();
        let is_long = branch.arclength[k] - branch.arclength[k - 1] > UNDIVIDED;
        let agrees = (!is_long || are_followed(one[0], &own, other[0]) != Some(false))
            && one[0].abs_diff(other[0]) <= most
            && is_even(one[1].abs_diff(other[1]), ones + lost)
            && is_even(one[2].abs_diff(other[2]), minus + lost);
        if !agrees {
            let at = [branch.parameter[k - 1], branch.parameter[k]];
            return (
                Some(format!("{one:?} to {other:?} from {at:?}, {between:?}")),
                seen,
            );
        }
    }
    (turns(branch), seen)
}

/// Whether the number turns where no multiplier is near 1: where the force of a stop that is held only touches zero.
fn is_of_a_release(special: &Special) -> bool {
    let is_alone = |orbit: &PeriodicOrbit| {
        let stability = orbit.stability().ok()?;
        let order = stability.orders.first()?;
        let mut all = order.multipliers.iter();
        Some(all.all(|mu| (mu - 1.0).norm() > 0.5))
    };
    special.kind == SpecialKind::Fold && is_alone(&special.orbit) == Some(true)
}

/// How many impacts have a speed on one orbit and would have to pull on the other.
fn lost(one: &PeriodicOrbit, other: &PeriodicOrbit) -> usize {
    let pairs = one.impacts().iter().zip(other.impacts());
    pairs.filter(|(a, b)| a.approach * b.approach < 0.0).count()
}

/// Whether an impact has lost its speed but for so little that the number is known to rounding over it.
fn is_nearly_lost(orbit: &PeriodicOrbit) -> bool {
    let speeds = orbit.impacts().iter().map(|own| own.approach.abs());
    let fastest = speeds.clone().fold(0.0, f64::max);
    speeds.fold(f64::INFINITY, f64::min) < NEARLY_LOST * fastest
}

/// Whether the multipliers outside the circle behind some special points in their order are as many as they are said to be, each crossing
/// outwards or inwards as the others at its own orbit leave it no choice; `None` where others are next to the circle there.
fn are_followed(before: usize, special: &[&Special], after: usize) -> Option<bool> {
    let mut outside = before;
    for own in special {
        let (number, crossing) = match own.kind {
            SpecialKind::PeriodDoubling => (Some(-1.0), 1),
            SpecialKind::Torus => (None, 2),
            _ => (Some(1.0), 1),
        };
        let stability = own.orbit.stability().ok()?;
        let order = stability.orders.first()?;
        let mut all: Vec<Complex<f64>> = order.multipliers.iter().copied().collect();
        let off = |mu: &Complex<f64>| {
            number.map_or((mu.norm() - 1.0).abs(), |number| (mu - number).norm())
        };
        all.sort_by(|a, b| off(a).total_cmp(&off(b)));
        let others = &all[crossing..];
        if others.iter().any(|mu| (mu.norm() - 1.0).abs() < BESIDE) {
            return None;
        }
        let own = others.iter().filter(|mu| mu.norm() > 1.0).count();
        outside = match outside.checked_sub(own) {
            Some(0) => own + crossing,
            Some(most) if most == crossing => own,
            _ => return Some(false),
        };
    }
    Some(outside == after)
}

/// Where the number turns back and there is no fold, or one where it does not.
fn turns(branch: &Branch) -> Option<String> {
    let (p, s) = (&branch.parameter, &branch.arclength);
    let span = p
        .iter()
        .fold(f64::MIN_POSITIVE, |m, a| m.max((a - p[0]).abs()));
    let way = |k: usize| p[k + 1] - p[k];
    let folds = branch
        .special
        .iter()
        .filter(|own| own.kind == SpecialKind::Fold);
    let folds: Vec<f64> = folds.map(|own| own.arclength).collect();
    (1..p.len().saturating_sub(1)).find_map(|k| {
        let near = folds
            .iter()
            .filter(|own| (s[k - 1]..=s[k + 1]).contains(own));
        let turned = way(k - 1) * way(k) < 0.0;
        let is_clear = way(k - 1).abs().min(way(k).abs()) > 1e-9 * span;
        let is_known = !branch.orbits[k - 1..=k + 1].iter().any(is_nearly_lost);
        (turned && is_clear && is_known && near.count() == 0)
            .then(|| format!("turns at {} without a fold", p[k]))
    })
}
