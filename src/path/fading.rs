//! The rates that set how densely a kept motion is drawn: parts that have died out do not count.

use crate::flow::ModalScene;
use crate::law::Regime;
use crate::modal::{Block, Form, rate_bound};
use crate::path::evaluator::Evaluator;
use crate::tolerance::DIED_OUT_EXPONENT;

/// The rates of free motion and of those in other regimes.
pub(crate) struct Fading<'a> {
    free: Rates,
    regimes: Vec<(&'a Regime, Rates)>,
}

impl<'a> Fading<'a> {
    /// The rates of exact flights; those of integrated ones are zero, a step being no longer than what it resolves.
    pub fn new(evaluator: &'a Evaluator) -> Self {
        let Evaluator::Exact { modal, regimes, .. } = evaluator else {
            return Self {
                free: Rates::default(),
                regimes: Vec::new(),
            };
        };
        let each = regimes.iter();
        Self {
            free: Rates::new(&modal.form.form, modal),
            regimes: each
                .map(|motion| (&motion.regime, Rates::new(motion.form(), modal)))
                .collect(),
        }
    }

    /// The rates in a regime.
    pub fn of(&self, regime: &Regime) -> &Rates {
        let known = self.regimes.iter().find(|(own, _)| *own == regime);
        known.map_or(&self.free, |(_, rates)| rates)
    }
}

/// The fastest rate of a motion from each of some times on, until the next.
#[derive(Debug, Default)]
pub(crate) struct Rates(Vec<(f64, f64)>);

impl Rates {
    fn new(form: &Form, scene: &ModalScene) -> Self {
        Self::without(form, scene, |_| false)
    }

    /// The rates of a motion, some of its blocks left out.
    pub fn without(form: &Form, scene: &ModalScene, is_left_out: impl Fn(&Block) -> bool) -> Self {
        let lasting = (f64::INFINITY, scene.rotations.fastest());
        match form {
            Form::Dense(matrix) => Self::of(vec![lasting, (f64::INFINITY, rate_bound(matrix))]),
            Form::Blocks(blocks) => {
                let counted = blocks.iter().filter(|block| !is_left_out(block));
                let roots = counted.flat_map(|block| block.roots());
                let each = roots.map(|root| {
                    let fades = root.re < 0.0;
                    let until = if fades {
                        DIED_OUT_EXPONENT / -root.re
                    } else {
                        f64::INFINITY
                    };
                    (until, root.norm())
                });
                Self::of(each.chain([lasting]).collect())
            }
        }
    }

    /// From parts, each with the time until which it lasts and its rate. A rate of less than half the one before begins a new
    /// stretch.
    fn of(mut parts: Vec<(f64, f64)>) -> Self {
        parts.sort_by(|a, b| b.0.total_cmp(&a.0));
        // From the longest-lasting part on, each that is faster rules until it has died out.
        let mut ruling: Vec<(f64, f64)> = Vec::new();
        for (until, rate) in parts {
            match ruling.last_mut() {
                Some((_, last)) if rate <= *last => {}
                Some((_, last)) if rate <= 2.0 * *last => *last = rate,
                _ => ruling.push((until, rate)),
            }
        }
        ruling.reverse();
        Self(ruling)
    }

    /// The fastest rate a time after the start, and until when it rules.
    pub fn at(&self, s: f64) -> (f64, f64) {
        let k = self.0.partition_point(|(until, _)| *until <= s);
        let (until, rate) = self.0.get(k).copied().unwrap_or((f64::INFINITY, 0.0));
        (rate, until)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fastest_part_rules_until_it_has_died_out() {
        let parts = vec![
            (f64::INFINITY, 1.0),
            (1e-6, 1e8),
            (3.0, 100.0),
            (2.0, 150.0),
            (5.0, 0.5),
        ];
        let rates = Rates::of(parts);
        for (s, expected) in [
            (0.0, (1e8, 1e-6)),
            (1e-6, (150.0, 3.0)),
            (2.5, (150.0, 3.0)),
            (3.0, (1.0, f64::INFINITY)),
            (1e9, (1.0, f64::INFINITY)),
        ] {
            assert_eq!(rates.at(s), expected, "{s}");
        }
        assert_eq!(Rates::default().at(0.0), (0.0, f64::INFINITY));
    }
}
