//! False position: the secant through the ends of a bracket, in its Illinois form.

use crate::root::bracket::Bracket;

/// The bracket of a zero with the values at its ends. Where the same end is replaced twice running, the value at the other is halved: it
/// would stay where it is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FalsePosition {
    pub between: Bracket,
    values: [f64; 2],
    /// The side replaced last.
    last: Option<usize>,
}

impl FalsePosition {
    /// Of ends with values of different signs; of one that is not known, NaN, the first trial is half-way.
    pub fn new(ends: [f64; 2], values: [f64; 2]) -> Self {
        Self {
            between: Bracket::new(ends),
            values,
            last: None,
        }
    }

    /// The next place to try: where the secant is zero, if that is inside, else half-way.
    pub fn trial(&self) -> f64 {
        let Bracket { before, after } = self.between;
        let [first, second] = self.values;
        let wanted = (before * second - after * first) / (second - first);
        if self.between.has(wanted) {
            wanted
        } else {
            self.between.middle()
        }
    }

    /// Takes the value at a place inside as that of an end.
    pub fn narrow(&mut self, at: f64, value: f64) {
        let side = usize::from((value > 0.0) != (self.values[0] > 0.0));
        self.between.narrow(at, side == 0);
        self.values[side] = value;
        if self.last == Some(side) {
            self.values[1 - side] *= 0.5;
        }
        self.last = Some(side);
    }

    /// The zero to the last places of the ends, after no more than `most` values; none where the function has no value on the way.
    pub fn zero<E>(
        mut self,
        most: usize,
        mut at: impl FnMut(f64) -> Result<Option<f64>, E>,
    ) -> Result<Option<f64>, E> {
        let mut place = f64::NAN;
        for _ in 0..most {
            place = self.trial();
            let Some(value) = at(place)? else {
                return Ok(None);
            };
            self.narrow(place, value);
            let Bracket { before, after } = self.between;
            let last_places = 4.0 * f64::EPSILON * before.abs().max(after.abs());
            // A short way from an end is no sign that the zero is near: a value that is nearly zero there leads to one.
            if value == 0.0 || after - before <= last_places || !self.between.has(self.trial()) {
                break;
            }
        }
        Ok(Some(place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn zero(ends: [f64; 2], f: impl Fn(f64) -> f64) -> (f64, usize) {
        let mut count = 0;
        let search = FalsePosition::new(ends, ends.map(&f));
        let Ok(found) = search.zero(200, |x| {
            count += 1;
            Ok::<_, Infallible>(Some(f(x)))
        });
        (found.unwrap_or(f64::NAN), count)
    }

    #[test]
    fn zeros_of_known_functions() {
        for sign in [1.0, -1.0] {
            let (root, count) = zero([0.0, 2.0], |x| sign * (x * x - 2.0));
            assert!((root - 2f64.sqrt()).abs() <= 4.0 * f64::EPSILON && count < 15);
            // The end at 5 would stay where it is.
            let (root, count) = zero([-1.0, 5.0], |x| sign * (x.exp() - 1.5));
            assert!((root - 1.5f64.ln()).abs() <= 4.0 * f64::EPSILON && count < 25);
            assert_eq!(zero([-1.0, 1.0], |x| sign * x).0, 0.0);
            // One that is nearly zero at an end, from which a secant hardly moves.
            let (root, _) = zero([0.0, 1.0], |x| sign * (1e-20 + x * x * (0.4 - x)));
            assert!((root - 0.4).abs() <= 4.0 * f64::EPSILON, "{root}");
        }
    }

    #[test]
    fn a_function_without_a_value_has_no_zero() {
        let search = FalsePosition::new([0.0, 1.0], [-1.0, 1.0]);
        let found = search.zero(9, |_| Ok::<_, Infallible>(None));
        assert_eq!(found, Ok(None));
        let open = FalsePosition::new([0.0, 1.0], [-1.0, f64::NAN]);
        assert_eq!(open.trial(), 0.5);
    }
}
