//! The time over which growth is counted, in batches of equal length: means over them, and from how these scatter their errors.

use crate::tolerance::{FINEST_BATCHES, RETURNS_PER_BATCH};

/// Numbers of batches that are made of the finest ones: the divisors of `FINEST_BATCHES`, but for one. [exact]
const BATCH_COUNTS: [usize; 5] = [20, 10, 5, 4, 2];

/// Growth at the ends of batches of a span of time.
pub(crate) struct Batches {
    start: f64,
    end: f64,
    /// At the ends of those passed so far, after the start.
    growth: Vec<Vec<f64>>,
    has_begun: bool,
}

/// Means with their errors.
pub(crate) struct Means {
    /// Growth per unit time of each of k exponents in each of b batches, shape (b, k), [1/s].
    pub history: Vec<Vec<f64>>,
    /// Standard errors of the means, shape (k,), [1/s]: NaN of one batch.
    pub errors: Vec<f64>,
}

impl Batches {
    /// Those of a span.
    pub fn new((start, end): (f64, f64)) -> Self {
        Self {
            start,
            end,
            growth: Vec::with_capacity(FINEST_BATCHES),
            has_begun: false,
        }
    }

    /// The next end of a batch, at first the start of all; none beyond the last.
    pub fn next_mark(&self) -> f64 {
        if !self.has_begun {
            return self.start;
        }
        match self.growth.len() + 1 {
            k if k < FINEST_BATCHES => {
                self.start + (self.end - self.start) * k as f64 / FINEST_BATCHES as f64
            }
            FINEST_BATCHES => self.end,
            _ => f64::INFINITY,
        }
    }

    /// When counting begins.
    pub fn start(&self) -> f64 {
        self.start
    }

    /// Whether counting has begun.
    pub fn has_begun(&self) -> bool {
        self.has_begun
    }

    /// Begins.
    pub fn begin(&mut self) {
        self.has_begun = true;
    }

    /// A batch ends, with the growth since the start.
    pub fn pass(&mut self, growth: &[f64]) {
        self.growth.push(growth.to_vec());
    }

    /// The means of batches each with enough returns, of which there were so many in all.
    pub fn means(&self, returns: usize) -> Means {
        let all = self.growth.len();
        let is_enough =
            |&count: &usize| all == FINEST_BATCHES && returns >= count * RETURNS_PER_BATCH;
        let count = BATCH_COUNTS.into_iter().find(is_enough).unwrap_or(1);
        let each = all / count;
        let length = (self.end - self.start) * each as f64 / FINEST_BATCHES as f64;
        let at = |batch: usize| batch.checked_sub(1).map(|before| &self.growth[before]);
        let mean = |batch: usize| -> Vec<f64> {
            let (from, to) = (at(batch * each), at((batch + 1) * each));
            let to = to.into_iter().flatten();
            let grown = to.enumerate().map(|(i, to)| match from {
                Some(from) if to.is_finite() => to - from[i],
                _ => *to,
            });
            grown.map(|grown| grown / length).collect()
        };
        let history: Vec<Vec<f64>> = if all == 0 {
            Vec::new()
        } else {
            (0..count).map(mean).collect()
        };
        let k = history.first().map_or(0, Vec::len);
        let errors = (0..k)
            .map(|i| error(history.iter().map(|row| row[i])))
            .collect();
        Means { history, errors }
    }
}

/// The standard error of the mean of values: none where they are infinite, by rule.
fn error(values: impl ExactSizeIterator<Item = f64> + Clone) -> f64 {
    let count = values.len() as f64;
    if values.clone().any(f64::is_infinite) {
        return 0.0;
    }
    let mean = values.clone().sum::<f64>() / count;
    let squares: f64 = values.map(|x| (x - mean).powi(2)).sum();
    (squares / (count * (count - 1.0))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_have_enough_returns() {
        let mut batches = Batches::new((1.0, 5.0));
        assert_eq!(batches.next_mark(), 1.0);
        batches.begin();
        for k in 1..=20 {
            assert!((batches.next_mark() - (1.0 + 0.2 * f64::from(k))).abs() < 1e-15);
            batches.pass(&[
                0.3 * f64::from(k) + 0.01 * f64::from(k % 2),
                f64::NEG_INFINITY,
            ]);
        }
        assert_eq!(batches.next_mark(), f64::INFINITY);
        for (returns, count) in [(2000, 20), (999, 10), (250, 5), (249, 4), (100, 2), (99, 1)] {
            let means = batches.means(returns);
            assert_eq!(means.history.len(), count);
            let mean = means.history.iter().map(|row| row[0]).sum::<f64>() / count as f64;
            assert!((mean - 1.5).abs() < 1e-14, "{mean}");
            assert_eq!(means.errors[0].is_nan(), count == 1);
            assert!(means.history.iter().all(|row| row[1] == f64::NEG_INFINITY));
            assert_eq!(means.errors[1], 0.0);
        }
        // Values that go up and down by 0.05 about their mean.
        let error = batches.means(2000).errors[0];
        assert!((error - 0.05 / 19f64.sqrt()).abs() < 1e-14, "{error}");
    }
}
