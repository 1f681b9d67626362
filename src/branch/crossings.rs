//! Whether the multipliers that cross the unit circle on a step of a branch are those that its special points say, in number and in direction
//! (theory 19).

use crate::branch::predictor::AcceptedPoint;
use crate::branch::problem::BranchProblem;
use crate::branch::special::{Special, SpecialKind};
use crate::error::Result;
use crate::tolerance::{MARGINAL, MEETING, MULTIPLIER_AT_NUMBER};
use nalgebra::Complex;

/// Whether a multiplier of a special point is at a number, if its orbit has multipliers. At a release where the force only touches zero the
/// equations are singular for every multiplier, and the test function is zero without one; loops of impulses have no releases.
pub(super) fn has_multiplier(
    problem: &BranchProblem<'_>,
    special: &Special,
    number: f64,
) -> Result<bool> {
    let own = problem.multipliers(&special.orbit)?;
    Ok(own.is_none_or(|own| {
        own.iter()
            .any(|mu| (mu - number).norm() < MULTIPLIER_AT_NUMBER)
    }))
}

/// How many multipliers cross the unit circle outwards, and inwards.
type CrossingCount = [usize; 2];

/// Whether the multipliers that leave and enter the unit circle on a step are those of its special points, which are in their order. Next
/// to an orbit without multipliers nothing can be said against them.
pub(super) fn are_explained(
    problem: &BranchProblem<'_>,
    (from, to): (&AcceptedPoint, &AcceptedPoint),
    special: &[Special],
) -> Result<bool> {
    let (Some(before), Some(after)) = (from.test_values.outside, to.test_values.outside) else {
        return Ok(true);
    };
    let mut counts = vec![(before, [0, 0])];
    for own in special {
        let at = CircleCrossing::of(problem, own)?;
        counts = counts
            .into_iter()
            .flat_map(|count| at.passed(count))
            .collect();
        counts.sort_unstable();
        counts.dedup();
    }
    counts.retain(|(outside, _)| *outside == after);
    if counts.is_empty() {
        return Ok(false);
    }
    // Multipliers that leave the circle while as many others enter it do not show in the counts.
    let [one, other] = [from, to].map(|own| problem.multipliers(&own.orbit));
    let (one, other) = (one?, other?);
    let (Some(one), Some(other)) = (one, other) else {
        return Ok(true);
    };
    let crossed = crossed(&one, &other);
    Ok(counts.iter().any(|(_, own)| *own == crossed))
}

/// The multipliers at a special point: how many cross the circle there, and how many of the others are outside, as a range if some of these
/// are next to the circle too; `None` where they are not known.
struct CircleCrossing {
    critical: usize,
    outside: Option<(usize, usize)>,
}

impl CircleCrossing {
    fn of(problem: &BranchProblem<'_>, special: &Special) -> Result<Self> {
        let critical = match special.kind {
            SpecialKind::Torus => 2,
            SpecialKind::Fold => usize::from(has_multiplier(problem, special, 1.0)?),
            _ => 1,
        };
        let outside = if let Some(mut own) = problem.multipliers(&special.orbit)? {
            for _ in 0..critical {
                without_nearest(&mut own, special);
            }
            let beyond = |margin: f64| own.iter().filter(|mu| mu.norm() > 1.0 + margin).count();
            Some((beyond(MEETING), beyond(-MEETING)))
        } else {
            let count = problem.n_well_outside(&special.orbit, special.parameter)?;
            count.map(|count| (count, count))
        };
        Ok(Self { critical, outside })
    }

    /// The numbers of multipliers that may be outside after the special point, with those that have crossed so far, by those before it.
    fn passed(&self, (before, [out, back]): (usize, CrossingCount)) -> Vec<(usize, CrossingCount)> {
        let own = self.critical;
        let may_be = |others: usize| {
            self.outside
                .is_none_or(|(low, high)| (low..=high).contains(&others))
        };
        let mut counts = Vec::new();
        if may_be(before) {
            counts.push((before + own, [out + own, back]));
        }
        if own > 0 && before >= own && may_be(before - own) {
            counts.push((before - own, [out, back + own]));
        }
        counts
    }
}

/// Leaves out the multiplier nearest to where one crosses the circle at a special point; at a torus, the complex one nearest to the circle.
fn without_nearest(own: &mut Vec<Complex<f64>>, special: &Special) {
    let off = |mu: &Complex<f64>| match special.kind {
        SpecialKind::Torus if mu.im == 0.0 => f64::INFINITY,
        SpecialKind::Torus => mu.norm().ln().abs(),
        SpecialKind::PeriodDoubling => (mu + 1.0).norm(),
        _ => (mu - 1.0).norm(),
    };
    let nearest = (0..own.len()).min_by(|&i, &j| off(&own[i]).total_cmp(&off(&own[j])));
    nearest.map(|i| own.swap_remove(i));
}

/// How many multipliers cross the circle from one orbit to another. Each is matched with the nearest one of the other orbit, the closest
/// pairs first; far from the circle distances are relative.
fn crossed(before: &[Complex<f64>], after: &[Complex<f64>]) -> CrossingCount {
    let apart =
        |a: &Complex<f64>, b: &Complex<f64>| (a - b).norm() / (1.0 + a.norm().max(b.norm()));
    let mut pairs: Vec<(f64, usize, usize)> = Vec::with_capacity(before.len() * after.len());
    for (i, a) in before.iter().enumerate() {
        pairs.extend(after.iter().enumerate().map(|(j, b)| (apart(a, b), i, j)));
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut used, mut taken) = (vec![false; before.len()], vec![false; after.len()]);
    let mut crossed = [0, 0];
    for (_, i, j) in pairs {
        if used[i] || taken[j] {
            continue;
        }
        (used[i], taken[j]) = (true, true);
        let is_outside = |mu: &Complex<f64>| mu.norm() > 1.0 + MARGINAL;
        match (is_outside(&before[i]), is_outside(&after[j])) {
            (false, true) => crossed[0] += 1,
            (true, false) => crossed[1] += 1,
            _ => {}
        }
    }
    crossed
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(numbers: &[(f64, f64)]) -> Vec<Complex<f64>> {
        numbers
            .iter()
            .map(|&(re, im)| Complex::new(re, im))
            .collect()
    }

    #[test]
    fn multipliers_are_followed_one_by_one() {
        let pair = |re: f64, im: f64| [(re, im), (re, -im)];
        let one = all(&[pair(0.6, 0.85), pair(-0.6, 0.75)].concat());
        let other = all(&[pair(-0.6, 0.85), pair(0.6, 0.75)].concat());
        // As many outside before and after: one pair came in, another left.
        assert_eq!(crossed(&one, &other), [2, 2]);
        assert_eq!(crossed(&one, &one), [0, 0]);
        // Through -1, and one that is far away and grows.
        let (one, other) = (
            all(&[(-0.9, 0.0), (40.0, 0.0)]),
            all(&[(-1.1, 0.0), (90.0, 0.0)]),
        );
        assert_eq!(crossed(&one, &other), [1, 0]);
    }

    #[test]
    fn numbers_are_explained_by_their_direction() {
        // A doubling beside which two others are outside takes one away from three, or brings one to two; it makes no two of one.
        let at = CircleCrossing {
            critical: 1,
            outside: Some((2, 2)),
        };
        assert_eq!(at.passed((3, [0, 0])), [(2, [0, 1])]);
        assert_eq!(at.passed((2, [0, 0])), [(3, [1, 0])]);
        assert!(at.passed((1, [0, 0])).is_empty());
        // Of one that is not known both are possible.
        let unknown = CircleCrossing {
            outside: None,
            ..at
        };
        assert_eq!(unknown.passed((1, [0, 0])).len(), 2);
    }
}
