//! A gap \[m\] without a bound on its curvature, evaluated at some places of a step beside its ends: whether it agrees with the quintic
//! through the ends, and where the stop is passed.

use crate::event::polynomial::Quintic;
use crate::tolerance::{NEAR_MISS_FACTOR, UNLIKE_QUINTIC};

/// Parts of a step at which a gap is evaluated beside its ends. [work]
pub(crate) const STEP_PROBES: [f64; 3] = [0.25, 0.5, 0.75];

/// A gap at the places `STEP_PROBES`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Probed(pub [f64; STEP_PROBES.len()]);

impl Probed {
    /// Whether the gap differs from its quintic, by more than the margin, so much that a search on it may find what is not there.
    pub fn is_unlike(&self, quintic: &Quintic, margin: f64) -> bool {
        let ends = [0.0, 1.0].map(|x| quintic.value(x));
        let all = || self.0.iter().chain(&ends).copied();
        let (most, least) = (
            all().fold(f64::NEG_INFINITY, f64::max),
            all().fold(f64::INFINITY, f64::min),
        );
        let misses = self.0.iter().zip(STEP_PROBES);
        let misses = misses.map(|(gap, x)| (gap - quintic.value(x)).abs());
        let miss = misses.fold(0.0, f64::max);
        let lowest = least.min(-quintic.lowest().1);
        miss > margin.max(UNLIKE_QUINTIC * (most - least)) && lowest <= NEAR_MISS_FACTOR * miss
    }

    /// The first place at which the gap is passed by more than the margin, and the last before it that is looked at.
    pub fn passed(&self, margin: f64) -> Option<(f64, f64)> {
        let k = self.0.iter().position(|gap| *gap < -margin)?;
        let before = if k > 0 { STEP_PROBES[k - 1] } else { 0.0 };
        Some((before, STEP_PROBES[k]))
    }

    /// The deepest place of those looked at, and how deep it is.
    pub fn deepest(&self) -> (f64, f64) {
        let all = STEP_PROBES.into_iter().zip(self.0);
        let least = all.min_by(|a, b| a.1.total_cmp(&b.1));
        least.map_or((0.0, f64::NEG_INFINITY), |(x, gap)| (x, -gap))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::polynomial::EndValues;

    fn of(gap: fn(f64) -> [f64; 3]) -> (Quintic, Probed) {
        let quintic = Quintic::new(&EndValues::new(gap(0.0), gap(1.0), 1.0, 0));
        (quintic, Probed(STEP_PROBES.map(|x| gap(x)[0])))
    }

    #[test]
    fn a_gap_that_turns_between_the_ends_is_not_that_of_its_quintic_and_one_that_bends_little_is() {
        // 1.2 + sin of one and of four turns.
        let (quintic, probed) = of(|x| {
            let w = 8.0;
            let (s, c) = (w * x).sin_cos();
            [1.2 + s, w * c, -w * w * s]
        });
        assert!(probed.is_unlike(&quintic, 1e-9));
        let (quintic, probed) = of(|x| {
            let (s, c) = (0.8 * x).sin_cos();
            [1.2 - s, -0.8 * c, 0.64 * s]
        });
        assert!(!probed.is_unlike(&quintic, 1e-9));
        // Far from zero it does not matter.
        let (quintic, probed) = of(|x| {
            let (s, c) = (3.0 * x).sin_cos();
            [1e3 + s, 3.0 * c, -9.0 * s]
        });
        assert!(!probed.is_unlike(&quintic, 1e-9));
    }

    #[test]
    fn a_place_that_is_passed_is_seen() {
        let probed = Probed([1.0, -0.5, -1.0]);
        assert_eq!(probed.passed(1e-3), Some((0.25, 0.5)));
        assert_eq!(probed.deepest(), (0.75, 1.0));
        assert_eq!(Probed([1.0, -1e-4, 0.2]).passed(1e-3), None);
    }
}
