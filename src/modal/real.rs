//! Real modes (theory 4): M-orthonormal shapes that uncouple a system with symmetric stiffness and proportional damping.

use crate::error::Result;
use crate::linalg::plane::Pair;
use crate::linalg::{compensated, eigen, graded};
use crate::model::LinearSystem;
use crate::tolerance::{EQUAL_FREQUENCIES, PROPORTIONAL_TOL};
use nalgebra::{DMatrix, DVector};

/// M-orthonormal mode shapes, ascending in frequency; for a diagonal system each mode is one coordinate.
#[derive(Debug, Clone)]
pub(crate) enum Shapes {
    /// Mode j is coordinate `order[j]`, times `1/sqrt(mass)`.
    Diagonal {
        order: Vec<usize>,
        root_mass: DVector<f64>,
    },
    /// Columns are modes; with them `Phi^-1`.
    Dense {
        shapes: DMatrix<f64>,
        inverse: DMatrix<f64>,
    },
}

impl Shapes {
    /// `Phi^T n`: what a covector (a normal, a force) is in the modes.
    pub fn project(&self, n: &DVector<f64>) -> DVector<f64> {
        match self {
            Self::Diagonal { order, root_mass } => {
                DVector::from_fn(order.len(), |j, _| n[order[j]] / root_mass[order[j]])
            }
            Self::Dense { shapes, .. } => shapes.tr_mul(n),
        }
    }

    /// `Phi^T M x = Phi^-1 x` of a displacement and of a velocity: what they are in the modes.
    pub fn to_modal(&self, q: &[f64], v: &[f64]) -> Vec<Pair> {
        match self {
            Self::Diagonal { order, root_mass } => {
                let pair = |&i: &usize| [q[i], v[i]].map(|x| x * root_mass[i]);
                order.iter().map(pair).collect()
            }
            Self::Dense { inverse, .. } => {
                let mut pairs = vec![[0.0; 2]; q.len()];
                let columns = inverse.as_slice().chunks_exact(q.len());
                for (column, (q, v)) in columns.zip(q.iter().zip(v)) {
                    for (z, x) in pairs.iter_mut().zip(column) {
                        *z = [z[0] + x * q, z[1] + x * v];
                    }
                }
                pairs
            }
        }
    }

    /// `Phi y` into q and v, where y are the first and the second of each pair.
    pub fn fill_physical(&self, pairs: &[Pair], q: &mut [f64], v: &mut [f64]) {
        match self {
            Self::Diagonal { order, root_mass } => {
                for (z, &i) in pairs.iter().zip(order) {
                    [q[i], v[i]] = z.map(|z| z / root_mass[i]);
                }
            }
            Self::Dense { shapes, .. } => {
                q.fill(0.0);
                v.fill(0.0);
                for (z, shape) in pairs.iter().zip(shapes.as_slice().chunks_exact(q.len())) {
                    for ((q, v), x) in q.iter_mut().zip(&mut *v).zip(shape) {
                        *q += x * z[0];
                        *v += x * z[1];
                    }
                }
            }
        }
    }

    /// Phi in dense form, shape `(n, n)`.
    pub fn to_dense(&self) -> DMatrix<f64> {
        match self {
            Self::Diagonal { order, root_mass } => {
                let n = order.len();
                let mut phi = DMatrix::zeros(n, n);
                for (j, &i) in order.iter().enumerate() {
                    phi[(i, j)] = 1.0 / root_mass[i];
                }
                phi
            }
            Self::Dense { shapes, .. } => shapes.clone(),
        }
    }

    /// `Phi^-1 = Phi^T M` in dense form, shape `(n, n)`.
    pub fn inverse(&self) -> DMatrix<f64> {
        match self {
            Self::Diagonal { order, root_mass } => {
                let n = order.len();
                let mut inverse = DMatrix::zeros(n, n);
                for (j, &i) in order.iter().enumerate() {
                    inverse[(j, i)] = root_mass[i];
                }
                inverse
            }
            Self::Dense { inverse, .. } => inverse.clone(),
        }
    }
}

/// Undamped modes of a system with symmetric stiffness, and what the damping is in them.
#[derive(Debug, Clone)]
pub(crate) struct RealModes {
    /// Squared natural frequencies, ascending, negative for an unstable equilibrium, shape `(n_dof,)`, \[rad^2/s^2\].
    pub w2: DVector<f64>,
    /// Half the diagonal of `Phi^T C Phi`, shape `(n_dof,)`, \[1/s\].
    pub eta: DVector<f64>,
    /// The shapes.
    pub shapes: Shapes,
    /// Whether `Phi^T C Phi` is diagonal: the modes are uncoupled then.
    pub is_proportional: bool,
}

impl RealModes {
    /// The undamped modes, `None` where the stiffness is not symmetric.
    pub fn new(system: &LinearSystem) -> Result<Option<Self>> {
        if let Some((m, c, k)) = system.diagonals() {
            return Ok(Some(Self::of_diagonal(&m, &c, &k)));
        }
        if !system.stiffness().is_symmetric() {
            return Ok(None);
        }
        let stiffness = system.stiffness().to_dense();
        let damping = system.damping().to_dense();
        let (w2, rounding, mut shapes) = undamped(system, &stiffness)?;
        rotate_clusters(&w2, &rounding, &damping, &mut shapes)?;
        for mut column in shapes.column_iter_mut() {
            if column[column.icamax()] < 0.0 {
                column.neg_mut();
            }
        }
        let mut modal = shapes.transpose() * &damping * &shapes;
        // What slow modes take of large entries cancels.
        modal.set_diagonal(&beyond_rounding(&damping, &shapes));
        let w2 = beyond_rounding(&stiffness, &shapes);
        // In numbers `Phi^T M` cancels where the entries of M differ by many orders.
        let inverse = shapes.clone().try_inverse();
        let inverse = inverse.unwrap_or_else(|| shapes.tr_mul(&system.mass().to_dense()));
        Ok(Some(Self {
            w2,
            eta: modal.diagonal() * 0.5,
            is_proportional: is_diagonal(&modal, &damping, &shapes),
            shapes: Shapes::Dense { shapes, inverse },
        }))
    }

    fn of_diagonal(m: &DVector<f64>, c: &DVector<f64>, k: &DVector<f64>) -> Self {
        let mut order: Vec<usize> = (0..m.len()).collect();
        order.sort_by(|&i, &j| (k[i] / m[i]).total_cmp(&(k[j] / m[j])));
        let pick = |f: &dyn Fn(usize) -> f64| {
            DVector::from_iterator(order.len(), order.iter().map(|&i| f(i)))
        };
        Self {
            w2: pick(&|i| k[i] / m[i]),
            eta: pick(&|i| 0.5 * c[i] / m[i]),
            shapes: Shapes::Diagonal {
                root_mass: m.map(f64::sqrt),
                order,
            },
            is_proportional: true,
        }
    }
}

/// Squared frequencies, ascending, what rounding may make of them, and M-orthonormal shapes.
fn undamped(
    system: &LinearSystem,
    stiffness: &DMatrix<f64>,
) -> Result<(DVector<f64>, DVector<f64>, DMatrix<f64>)> {
    let mass = system.mass().to_dense();
    if let Some(order) = graded::order(&mass, stiffness) {
        let (w2, shapes) = graded::symmetric_generalised(&mass, stiffness, &order)?;
        let rounding = compensated::quadratic_rounding(stiffness, &shapes);
        return Ok((w2, rounding, shapes));
    }
    let (w2, shapes) = eigen::symmetric_generalised(&system.mass_cholesky(), stiffness)?;
    let n = w2.len();
    let rounding = DVector::from_element(n, 4.0 * f64::EPSILON * n as f64 * w2.amax());
    Ok((w2, rounding, shapes))
}

/// Whether the damping in the modes is diagonal but for rounding: each other entry is measured by those of its own two modes, and by
/// the sizes of the terms it is a sum of, not by what a stiff mode elsewhere has.
fn is_diagonal(modal: &DMatrix<f64>, damping: &DMatrix<f64>, shapes: &DMatrix<f64>) -> bool {
    let n = modal.nrows();
    let beside = (0..n).flat_map(|j| (0..j).map(move |i| (i, j)));
    let mut left = beside.filter(|&(i, j)| {
        let own = modal[(i, i)].abs().max(modal[(j, j)].abs());
        modal[(i, j)].abs().max(modal[(j, i)].abs()) > PROPORTIONAL_TOL * own
    });
    let Some(first) = left.next() else {
        return true;
    };
    let sizes = shapes.abs();
    let sizes = sizes.tr_mul(&(damping.abs() * &sizes));
    let is_rounding = |(i, j)| {
        let entry = f64::max(modal[(i, j)].abs(), modal[(j, i)].abs());
        entry <= PROPORTIONAL_TOL * f64::max(sizes[(i, j)], sizes[(j, i)])
    };
    is_rounding(first) && left.all(is_rounding)
}

/// The values of a form at the modes, zero where the rounding of its entries may have made them: what no spring or dashpot
/// holds moves as a rigid body, not with a frequency of 1e-16 of the others.
fn beyond_rounding(matrix: &DMatrix<f64>, shapes: &DMatrix<f64>) -> DVector<f64> {
    let values = compensated::quadratic(matrix, shapes);
    let rounding = compensated::quadratic_rounding(matrix, shapes);
    values.zip_map(
        &rounding,
        |value, rounding| {
            if value.abs() <= rounding { 0.0 } else { value }
        },
    )
}

/// Inside each cluster of equal frequencies, turns the shapes so that they diagonalise the damping too.
fn rotate_clusters(
    w2: &DVector<f64>,
    rounding: &DVector<f64>,
    damping: &DMatrix<f64>,
    shapes: &mut DMatrix<f64>,
) -> Result<()> {
    let n = w2.len();
    let mut start = 0;
    while start < n {
        let mut end = start + 1;
        while end < n
            && w2[end] - w2[start] <= EQUAL_FREQUENCIES * w2[start].abs() + rounding[start]
        {
            end += 1;
        }
        if end > start + 1 {
            let cluster = shapes.columns(start, end - start).into_owned();
            let block = cluster.transpose() * damping * &cluster;
            let (_, rotation) = eigen::symmetric((&block + block.transpose()) * 0.5)?;
            shapes
                .columns_mut(start, end - start)
                .copy_from(&(cluster * rotation));
        }
        start = end;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    #[test]
    fn repeated_frequencies_are_turned_to_the_damping() {
        let identity = DMatrix::<f64>::identity(2, 2);
        let system = LinearSystem::new(
            identity.clone(),
            dmatrix![0.2, 0.1; 0.1, 0.2],
            identity * 4.0,
        )
        .expect("valid");
        let modes = RealModes::new(&system)
            .expect("converges")
            .expect("symmetric");
        assert!(modes.is_proportional);
        assert!(
            (&modes.eta - dvector![0.05, 0.15]).amax() < 1e-15,
            "{}",
            modes.eta
        );
    }

    #[test]
    fn joint_dampers_are_proportional_only_in_the_ratio_of_the_masses() {
        for (p2, proportional) in [(0.3, true), (0.2, false)] {
            let system = crate::model::DoublePendulum::new(3.0, 3.24, (0.1, p2))
                .and_then(|p| p.linearise())
                .expect("valid");
            let modes = RealModes::new(&system)
                .expect("converges")
                .expect("symmetric");
            assert_eq!(modes.is_proportional, proportional);
        }
    }

    #[test]
    fn diagonal_systems_are_sorted_and_scaled() {
        let system = LinearSystem::new(dvector![4.0, 1.0], dvector![0.4, 0.2], dvector![64.0, 9.0])
            .expect("valid");
        let modes = RealModes::new(&system)
            .expect("diagonal")
            .expect("symmetric");
        assert_eq!(modes.w2, dvector![9.0, 16.0]);
        assert_eq!(modes.shapes.to_dense(), dmatrix![0.0, 0.5; 1.0, 0.0]);
        let pairs = modes.shapes.to_modal(&[0.3, 0.7], &[-0.1, 0.9]);
        let (mut q, mut v) = ([f64::NAN; 2], [f64::NAN; 2]);
        modes.shapes.fill_physical(&pairs, &mut q, &mut v);
        assert!((dvector![q[0], q[1], v[0], v[1]] - dvector![0.3, 0.7, -0.1, 0.9]).amax() < 1e-15);
    }
}
