//! What a problem has whose zeros form a curve: its equations, linearised; how an iterate is moved along a direction; the inner product of
//! directions; and when an iterate means nothing.

use crate::error::Result;
use nalgebra::{DMatrix, DVector};

/// A direction in all scaled unknowns of a problem \[-\], its numbers of the scene last.
pub(crate) trait ScaledDirection: Clone {
    /// The direction of a list of its components.
    fn of(components: &DVector<f64>) -> Self;

    /// The inner product that arclength goes by.
    fn dot(&self, other: &Self) -> f64;

    /// The row whose product with the components of another direction is their inner product.
    fn row(&self) -> DVector<f64>;

    /// The direction times a factor.
    fn scaled(&self, factor: f64) -> Self;

    /// The sum of two.
    fn plus(&self, other: &Self) -> Self;

    /// The same with the length one.
    fn unit(&self) -> Self;

    /// Its length.
    fn length(&self) -> f64 {
        self.dot(self).sqrt()
    }
}

/// The linearised equations at an iterate: `matrix y = right`, y the correction of all scaled unknowns.
pub(crate) trait Linearisation: Clone {
    /// The Jacobian, shape `(n_equations, n_unknowns)`, \[-\].
    fn matrix(&self) -> DMatrix<f64>;

    /// Minus the residual, shape `(n_equations,)`, \[-\].
    fn right(&self) -> &DVector<f64>;

    /// How far the iterate is from solving the equations, in parts of the solution's size \[-\].
    fn mismatch(&self) -> f64;
}

/// Equations with one unknown more than there are of them. The last unknowns are numbers of the scene.
pub(crate) trait ZeroProblem {
    /// Values of all unknowns.
    type Iterate: Clone;
    type Equations: Linearisation;
    type Direction: ScaledDirection;

    /// How many of the unknowns are numbers of the scene. `[exact]`
    const N_NUMBERS: usize;
    /// Corrections of one point, at the most. `[work]`
    const MOST_CORRECTIONS: usize;
    /// An iterate that solves the equations is kept, should no better one be found, where all corrections were made and the last one was no
    /// longer than this \[-\]; none is kept without.
    const KEPT_CORRECTION: Option<f64>;

    /// The value of the first number at an iterate.
    fn value(&self, iterate: &Self::Iterate) -> f64;

    /// The instant with which the next one coincides, so that an iterate means nothing.
    fn coinciding(&self, iterate: &Self::Iterate) -> Option<usize>;

    /// The equations at an iterate; next to another one, derivatives that are expensive may be taken from there.
    fn linearise(
        &self,
        iterate: &Self::Iterate,
        near: Option<&Self::Equations>,
    ) -> Result<Self::Equations>;

    /// An iterate moved along a direction, to first order.
    fn retract(
        &self,
        iterate: &Self::Iterate,
        equations: &Self::Equations,
        by: &Self::Direction,
    ) -> Result<Self::Iterate>;

    /// The point after a last correction that is too short to change the equations, with all derivatives taken at it.
    fn settle(
        &self,
        iterate: Self::Iterate,
        equations: Self::Equations,
        by: Option<&Self::Direction>,
    ) -> Result<(Self::Iterate, Self::Equations)>;

    /// An iterate at a value of one of its numbers, from which it differs by little.
    fn pin(&self, iterate: Self::Iterate, number: usize, value: f64) -> Result<Self::Iterate>;
}
