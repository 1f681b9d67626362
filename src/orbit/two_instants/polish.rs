//! Roots of the two-instant conditions with all unknowns at once: Newton's method on the bordered system for
//! (unknowns, dt), regular also where the conditions at fixed dt are singular (symmetric orbits), and its starts.

use crate::error::Result;
use crate::linalg::rank;
use crate::linalg::singular::Singular;
use crate::orbit::two_instants::taylor_model::TaylorModel;
use crate::tolerance::{CONVERGED, LEAST_SQUARES_RANK, LEAVES_TWO_STARTS, SINGULAR_STEP_RANK};
use nalgebra::{DMatrix, DVector};

/// Newton steps. [work]
const MOST_POLISH_STEPS: usize = 40;

/// `matrix (x, -1) = 0` at one dt, and its derivative in dt times the unit of time.
pub(crate) struct TwoInstantEquations {
    /// Scaled coefficients of the unknowns [-] and right-hand side [m/s], shape (equations, unknowns + 1).
    pub matrix: DMatrix<f64>,
    /// Derivative of `matrix` by dt times the unit of time, shape (equations, unknowns + 1), [as `matrix`].
    pub rate: DMatrix<f64>,
}

/// A flight time and its unknowns.
#[derive(Debug, Clone)]
pub(crate) struct Root {
    pub dt: f64,
    /// The scaled unknowns, shape (unknowns,), [m/s] in the sense of `Units`.
    pub x: DVector<f64>,
}

impl TwoInstantEquations {
    /// Those of Taylor models about a time, by rows of so many.
    pub fn of_models(models: &[TaylorModel], columns: usize) -> Self {
        let each = |of: fn(&TaylorModel) -> f64| {
            let values = models.iter().map(of);
            DMatrix::from_row_iterator(models.len() / columns, columns, values)
        };
        Self {
            matrix: each(TaylorModel::at_origin),
            rate: each(TaylorModel::slope_at_origin),
        }
    }

    fn n(&self) -> usize {
        self.matrix.ncols() - 1
    }

    /// `matrix (x, -1)`.
    fn misfit(&self, x: &DVector<f64>) -> DVector<f64> {
        self.matrix.columns(0, self.n()) * x - self.matrix.column(self.n())
    }

    fn slope(&self, x: &DVector<f64>) -> DVector<f64> {
        self.rate.columns(0, self.n()) * x - self.rate.column(self.n())
    }
}

/// Solutions of all equations but the one that is nearest to dependent, with `|phase| = 1`, the phase the last two
/// unknowns times `unit`: at most two. Where the equations are regular, only the better one.
pub(crate) fn circle_starts(
    equations: &TwoInstantEquations,
    unit: f64,
) -> Result<Vec<DVector<f64>>> {
    let n = equations.n();
    let singular = Singular::new(&equations.matrix.columns(0, n).into_owned())?;
    let rhs = equations.matrix.column(n).into_owned();
    let sigma = DVector::from_fn(n, |k, _| singular.value(k));
    let last = sigma.imin();
    let mut base = DVector::zeros(n);
    for k in (0..n).filter(|&k| k != last && sigma[k] > 0.0) {
        base += singular.right(k) * singular.part(k, &rhs);
    }
    let direction = singular.right(last);
    let part = |x: &DVector<f64>| [unit * x[n - 2], unit * x[n - 1]];
    let (p, d) = (part(&base), part(&direction));
    // |p + s d|^2 = 1
    let (a, b, c) = (
        d[0] * d[0] + d[1] * d[1],
        p[0] * d[0] + p[1] * d[1],
        p[0] * p[0] + p[1] * p[1] - 1.0,
    );
    let wanted = singular.part(last, &rhs);
    let half = (b * b - a * c).max(0.0).sqrt();
    // The larger root first, the other from the product.
    let q = if b >= 0.0 { -b - half } else { half - b };
    let roots = [q / a, c / q].map(|s| if s.is_finite() { s } else { -b / a });
    if roots.iter().any(|s| !s.is_finite()) {
        return Ok(if wanted.is_finite() {
            vec![base + direction * wanted]
        } else {
            vec![base]
        });
    }
    let mut starts: Vec<f64> = roots.to_vec();
    starts.sort_by(|s, t| (s - wanted).abs().total_cmp(&(t - wanted).abs()));
    if sigma[last] > LEAVES_TWO_STARTS * sigma.max() {
        starts.truncate(1);
    }
    Ok(starts.into_iter().map(|s| &base + &direction * s).collect())
}

/// The unknowns that fit more equations than there are of them best.
pub(crate) fn least_squares_start(equations: &TwoInstantEquations) -> Result<DVector<f64>> {
    let n = equations.n();
    let a = equations.matrix.columns(0, n).into_owned();
    let tolerance = LEAST_SQUARES_RANK * a.amax();
    Ok(rank::solve(&a, &equations.matrix.column(n).into_owned(), tolerance)?.particular)
}

/// Newton's method for the unknowns and dt; with `circle` the phase, the last two unknowns times that unit, is on the
/// unit circle. `None` where it does not converge.
pub(crate) fn polish(
    equations: &impl Fn(f64) -> TwoInstantEquations,
    circle: Option<f64>,
    time_unit: f64,
    mut dt: f64,
    mut x: DVector<f64>,
) -> Option<Root> {
    let n = x.len();
    let mut best: Option<(f64, Root)> = None;
    for _ in 0..MOST_POLISH_STEPS {
        let here = equations(dt);
        let mut jacobian = DMatrix::zeros(n + 1, n + 1);
        let mut misfit = DVector::zeros(n + 1);
        let rows = here.matrix.nrows();
        jacobian
            .view_mut((0, 0), (rows, n))
            .copy_from(&here.matrix.columns(0, n));
        jacobian
            .view_mut((0, n), (rows, 1))
            .copy_from(&here.slope(&x));
        misfit.rows_mut(0, rows).copy_from(&here.misfit(&x));
        let mut size =
            misfit.norm() / (x.norm() + here.matrix.column(n).norm()).max(f64::MIN_POSITIVE);
        if let Some(unit) = circle {
            let u = [unit * x[n - 2], unit * x[n - 1]];
            misfit[n] = 0.5 * (u[0] * u[0] + u[1] * u[1] - 1.0);
            jacobian[(n, n - 2)] = unit * u[0];
            jacobian[(n, n - 1)] = unit * u[1];
            // The same weight as the others: the phase's columns are of order one.
            size = size.max(misfit[n].abs());
            let scale = x.norm().max(f64::MIN_POSITIVE);
            misfit[n] *= scale;
            jacobian.row_mut(n).scale_mut(scale);
        }
        if best.as_ref().is_none_or(|(b, _)| size < *b) {
            best = Some((size, Root { dt, x: x.clone() }));
        } else if size < CONVERGED {
            break;
        }
        let step = jacobian
            .clone()
            .lu()
            .solve(&misfit)
            .filter(|s| s.iter().all(|v| v.is_finite()));
        // At a fold the bordered system is singular too: the shortest step that solves what can be solved.
        let shortest = || {
            Some(
                rank::solve(&jacobian, &misfit, SINGULAR_STEP_RANK * jacobian.amax())
                    .ok()?
                    .particular,
            )
        };
        let Some(step) = step.or_else(shortest) else {
            break;
        };
        x -= step.rows(0, n);
        dt -= step[n] * time_unit;
        if !dt.is_finite() || x.iter().any(|v| !v.is_finite()) {
            break;
        }
    }
    best.filter(|(size, _)| *size < CONVERGED)
        .map(|(_, root)| root)
}
