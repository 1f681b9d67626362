//! The secant method, which needs no bracket.

use std::ops::{Div, Mul, Neg, Sub};

/// The place tried last and the value there, of real or complex numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Secant<T> {
    pub at: T,
    pub value: T,
}

impl<T> Secant<T>
where
    T: Copy + Sub<Output = T> + Mul<Output = T> + Div<Output = T> + Neg<Output = T>,
{
    /// The step to the zero of the secant through the place before and another, which takes its part. Not finite where the values are
    /// the same.
    pub fn step(&mut self, at: T, value: T) -> T {
        let step = -value * (at - self.at) / (value - self.value);
        *self = Self { at, value };
        step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_needs_one_step() {
        let mut secant = Secant::<f64> {
            at: 1.0,
            value: 4.0,
        };
        assert_eq!(secant.step(2.0, 3.0), 3.0);
        assert_eq!((secant.at, secant.value), (2.0, 3.0));
        assert!(!secant.step(4.0, 3.0).is_finite());
    }
}
