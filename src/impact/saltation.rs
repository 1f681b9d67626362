//! The saltation matrix (theory 7): what the first deviations from a motion become at an impact, whose time depends on them.

use crate::error::Result;
use nalgebra::{DMatrix, DVector, DVectorView};

/// Takes deviations, columns, across an impact: `S = R_x + (f+ - R_x f-) dh/(dh.f-)`.
///
/// `dh` is the derivative of the gap by the state, or any multiple of it, `before` the rate f- of the state before the impact. `reset`
/// applies `R_x`, the derivative of the impact at a fixed time, to deviations, and returns `f+ - R_x f-`.
pub(crate) fn saltation(
    dh: DVectorView<'_, f64>,
    before: DVectorView<'_, f64>,
    reset: impl FnOnce(&mut DMatrix<f64>) -> Result<DVector<f64>>,
    deviations: &mut DMatrix<f64>,
) -> Result<()> {
    let delays = deviations.tr_mul(&dh) / dh.dot(&before);
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
        saltation(dh.as_view(), before.as_view(), reset, &mut deviations).expect("linear");
        // A ball higher by d falls for d/2 longer, and so is faster by d/2 before and by e d/2 after, which it leaves later.
        let expected = dmatrix![-e, 0.0; (-1.0 - e) / v, -e];
        assert!((&deviations - expected).amax() < 1e-15, "{deviations}");
        assert!((deviations.determinant() - e * e).abs() < 1e-15);
    }
}
