//! The saltation matrix (theory 7): first-order deviations from a motion across an impact, whose time depends on them.

use crate::error::Result;
use nalgebra::{DMatrix, DVector, DVectorView};

/// The derivative of a gap by the state, and its total rate before an impact, `h_x.f- + h_t`; both may be multiples by one number.
pub(crate) struct GapRate<'a> {
    pub by_state: DVectorView<'a, f64>,
    pub total: f64,
}

/// Takes deviations, columns, across an impact: `S = R_x + (f+ - R_x f- - R_t) h_x/(h_x.f- + h_t)`, where `h_t` and `R_t`, the derivatives
/// by time of the gap and of the impact, are there if the stop moves.
///
/// `reset` applies `R_x`, the derivative of the impact at a fixed time, to deviations, and returns `f+ - R_x f- - R_t`.
pub(crate) fn saltation(
    gap: GapRate<'_>,
    reset: impl FnOnce(&mut DMatrix<f64>) -> Result<DVector<f64>>,
    deviations: &mut DMatrix<f64>,
) -> Result<()> {
    let delays = deviations.tr_mul(&gap.by_state) / gap.total;
    let slip = reset(deviations)?;
    deviations.ger(1.0, &slip, &delays, 1.0);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    /// A ball under unit gravity on a floor at zero: `x' = (v, -1)`, impact `v+ = -e v-`.
    #[test]
    fn a_deviation_of_a_ball_is_that_of_its_neighbour() {
        let (e, v) = (0.6, -2.0);
        let mut deviations = DMatrix::identity(2, 2);
        let (dh, before) = (dvector![1.0, 0.0], dvector![v, -1.0]);
        let reset = |columns: &mut DMatrix<f64>| {
            columns.row_mut(1).scale_mut(-e);
            Ok(dvector![-e * v, -1.0] - dvector![v, e])
        };
        let gap = GapRate {
            by_state: dh.as_view(),
            total: dh.dot(&before),
        };
        saltation(gap, reset, &mut deviations).expect("linear");
        // A ball higher by d falls for d/2 longer, and so is faster by d/2 before and by e d/2 after, which it leaves later.
        let expected = dmatrix![-e, 0.0; (-1.0 - e) / v, -e];
        assert!((&deviations - expected).amax() < 1e-15, "{deviations}");
        assert!((deviations.determinant() - e * e).abs() < 1e-15);
    }
}
