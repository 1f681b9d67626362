//! Whether what crosses the unit circle on a step of a branch is what its special points say: how many multipliers, and which way
//! (theory 19).

use crate::branch::family::Family;
use crate::branch::multipliers::own_multipliers;
use crate::branch::special::{Special, SpecialKind};
use crate::branch::step::Point;
use crate::error::Result;
use crate::tolerance::{MARGINAL, MEETING};
use nalgebra::Complex;

/// A multiplier that is at a number is nearer to it than this, however fast it changes.
const AT: f64 = 0.5;

/// Whether a multiplier is at a number, if an orbit has multipliers. Where a release comes to an instant at which the force is zero, too, the
/// equations are singular for every multiplier; many modes of which nothing is held have none such.
pub(super) fn has_multiplier(family: &Family<'_>, special: &Special, number: f64) -> Result<bool> {
    if family.has_pulses {
        return Ok(true);
    }
    let own = own_multipliers(&special.orbit)?;
    Ok(own.is_none_or(|own| own.iter().any(|mu| (mu - number).norm() < AT)))
}

/// How many multipliers cross the unit circle outwards, and inwards.
type Crossed = [usize; 2];

/// Whether the multipliers that leave the unit circle on a step, and those that come into it, are those of its special points, which are in
/// their order. One orbit without multipliers explains whatever is beside it.
pub(super) fn are_explained(
    family: &Family<'_>,
    (from, to): (&Point, &Point),
    special: &[Special],
) -> Result<bool> {
    let (Some(before), Some(after)) = (from.indicators.outside, to.indicators.outside) else {
        return Ok(true);
    };
    let mut ways = vec![(before, [0, 0])];
    for own in special {
        let at = AtCircle::of(family, own)?;
        ways = ways.into_iter().flat_map(|way| at.passed(way)).collect();
        ways.sort_unstable();
        ways.dedup();
    }
    ways.retain(|(outside, _)| *outside == after);
    if family.has_pulses || ways.is_empty() {
        return Ok(!ways.is_empty());
    }
    // What leaves the circle while as many others come into it leaves no trace in the numbers.
    let (one, other) = (own_multipliers(&from.orbit)?, own_multipliers(&to.orbit)?);
    let (Some(one), Some(other)) = (one, other) else {
        return Ok(true);
    };
    let crossed = crossed(&one, &other);
    Ok(ways.iter().any(|(_, own)| *own == crossed))
}

/// The multipliers of a special point: so many cross the circle there, and of the others so many are outside, in a range where one of them is
/// next to the circle too; none where they are not known.
struct AtCircle {
    critical: usize,
    outside: Option<(usize, usize)>,
}

impl AtCircle {
    fn of(family: &Family<'_>, special: &Special) -> Result<Self> {
        let critical = match special.kind {
            SpecialKind::Torus => 2,
            SpecialKind::Fold => usize::from(has_multiplier(family, special, 1.0)?),
            _ => 1,
        };
        if family.has_pulses {
            let outside = family.n_well_outside(special)?;
            let outside = outside.map(|outside| (outside, outside));
            return Ok(Self { critical, outside });
        }
        let outside = own_multipliers(&special.orbit)?.map(|mut own| {
            for _ in 0..critical {
                without_nearest(&mut own, special);
            }
            let beyond = |margin: f64| own.iter().filter(|mu| mu.norm() > 1.0 + margin).count();
            (beyond(MEETING), beyond(-MEETING))
        });
        Ok(Self { critical, outside })
    }

    /// What may be outside behind it of what is before, and what has crossed so far.
    fn passed(&self, (before, [out, back]): (usize, Crossed)) -> Vec<(usize, Crossed)> {
        let own = self.critical;
        let may_be = |others: usize| {
            self.outside
                .is_none_or(|(low, high)| (low..=high).contains(&others))
        };
        let mut ways = Vec::new();
        if may_be(before) {
            ways.push((before + own, [out + own, back]));
        }
        if own > 0 && before >= own && may_be(before - own) {
            ways.push((before - own, [out, back + own]));
        }
        ways
    }
}

/// Leaves out the multiplier that is nearest to where one crosses the circle at a special point: of a torus to the circle beside the real axis.
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

/// How many of some multipliers have crossed the circle when they have become others, each the one that it is next to: the nearest two first,
/// far ones by their ratio.
fn crossed(before: &[Complex<f64>], after: &[Complex<f64>]) -> Crossed {
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
        let at = AtCircle {
            critical: 1,
            outside: Some((2, 2)),
        };
        assert_eq!(at.passed((3, [0, 0])), [(2, [0, 1])]);
        assert_eq!(at.passed((2, [0, 0])), [(3, [1, 0])]);
        assert!(at.passed((1, [0, 0])).is_empty());
        // Of one that is not known both are possible.
        let unknown = AtCircle {
            outside: None,
            ..at
        };
        assert_eq!(unknown.passed((1, [0, 0])).len(), 2);
    }
}
