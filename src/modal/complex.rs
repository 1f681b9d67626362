//! Complex modes (theory 4): the state matrix of any linear system as real 2 by 2 blocks, one for each complex pair or
//! for two real roots, unless its eigenvectors are too close to dependent.

use crate::error::{Error, Result};
use crate::linalg::elementary::power_of_two;
use crate::linalg::{eigen, graded};
use crate::modal::block::Block;
use crate::model::LinearSystem;
use crate::tolerance::{
    DEFECTIVE_CONDITION, REAL_ROOT_TOL, SPLIT_ZERO_ROOT, STANDS_STILL, TOO_GRADED, ZERO_ROOT,
};
use nalgebra::{Complex, DMatrix, DVector};

/// `x = V z` with z in uncoupled blocks, `z = W x`; x = (q, v).
#[derive(Debug, Clone)]
pub(crate) struct ComplexModes {
    pub blocks: Vec<Block>,
    /// V, shape `(2 n_dof, 2 n_dof)`, [-] for positions and \[1/s\] for velocities, in units of the modal coordinates.
    pub to_physical: DMatrix<f64>,
    /// W, the inverse of V, shape `(2 n_dof, 2 n_dof)`, [-] for positions and \[s\] for velocities.
    pub to_modal: DMatrix<f64>,
    /// The largest condition number of a column of V.
    pub condition: f64,
}

/// The state matrix `[[0, I], [-M^-1 K, -M^-1 C]]`, shape `(2n, 2n)`.
pub(crate) fn state_matrix(system: &LinearSystem) -> DMatrix<f64> {
    let n = system.n_dof();
    let (damping, stiffness) = (system.damping().to_dense(), system.stiffness().to_dense());
    let mut a = DMatrix::zeros(2 * n, 2 * n);
    for j in 0..n {
        a[(j, n + j)] = 1.0;
        a.view_mut((n, j), (n, 1))
            .copy_from(&-system.solve_mass(&stiffness.column(j).into_owned()));
        a.view_mut((n, n + j), (n, 1))
            .copy_from(&-system.solve_mass(&damping.column(j).into_owned()));
    }
    a
}

/// Refuses an unknown so much stiffer than others, beside its mass, that doubles do not hold what it does beside them. Modes that the
/// damping does not couple are right without it, but impacts set all of them going.
///
/// # Errors
/// The stiffest unknown.
pub(crate) fn check_range(system: &LinearSystem) -> Result<()> {
    let stiffness = system.stiffness().to_dense();
    let squares = graded::squares(&system.mass().to_dense(), &stiffness);
    if !graded::are_apart(&squares, TOO_GRADED) {
        return Ok(());
    }
    let stiffest = (0..squares.len()).max_by(|&i, &j| squares[i].total_cmp(&squares[j]));
    let i = stiffest.unwrap_or_default();
    let rule = "beside its mass it is more than 1/EPSILON times as stiff as another unknown: doubles do not hold that where stops are hit, \
                damping couples the modes, or the stiffness is not symmetric; leave a clamped unknown out of the matrices";
    let argument = format!("stiffness[{i}, {i}]");
    Err(Error::bad_value(argument, stiffness[(i, i)], rule))
}

/// The state matrix with velocities in units of the system's own rate, so that a condition number says something; the rate, a power of
/// two, by which nothing is rounded.
///
/// # Errors
/// As [`check_range`].
pub(crate) fn scaled_state_matrix(system: &LinearSystem) -> Result<(DMatrix<f64>, f64)> {
    let n = system.n_dof();
    check_range(system)?;
    let mut a = state_matrix(system);
    let stiffness = a.view((n, 0), (n, n)).norm().sqrt();
    let damping = a.view((n, n), (n, n)).norm();
    let rate = stiffness.max(damping);
    let rate = power_of_two(rate);
    a.view_mut((0, n), (n, n)).scale_mut(rate);
    a.view_mut((n, 0), (n, n)).unscale_mut(rate);
    Ok((a, rate))
}

impl ComplexModes {
    /// The blocks of a system, `None` where the state matrix is defective or nearly so.
    pub fn new(system: &LinearSystem) -> Result<Option<Self>> {
        let n = system.n_dof();
        let (scaled, rate) = scaled_state_matrix(system)?;
        let unit = DVector::from_fn(2 * n, |i, _| if i < n { 1.0 } else { rate });
        let (roots, mut vectors) = eigen::eigenvectors(&scaled)?;
        // A position moves by its velocity alone, which is known to fewer digits the slower the mode is.
        for (j, &root) in roots.iter().enumerate() {
            let velocity = vectors.view((0, j), (n, 1)) * (root / rate);
            vectors.view_mut((n, j), (n, 1)).copy_from(&velocity);
        }
        let largest = roots.iter().fold(0.0f64, |m, z| m.max(z.norm()));
        let is_split = |z: &Complex<f64>| {
            let part = z.norm() / largest;
            part > ZERO_ROOT && part < SPLIT_ZERO_ROOT
        };
        if roots.iter().any(is_split) {
            return Ok(None);
        }
        let Some((blocks, columns)) = real_blocks(&roots, &vectors) else {
            return Ok(None);
        };
        let Some(inverse) = columns.clone().try_inverse() else {
            return Ok(None);
        };
        // Column by column, so that slow modes among fast ones do not count as dependent.
        let condition = |j: usize| columns.column(j).norm() * inverse.row(j).norm();
        let conditions: Vec<f64> = (0..2 * n).map(condition).collect();
        if !conditions.iter().all(|&c| c <= DEFECTIVE_CONDITION) {
            return Ok(None);
        }
        let condition = conditions.into_iter().fold(1.0, f64::max);
        let to_physical = DMatrix::from_fn(2 * n, 2 * n, |i, j| columns[(i, j)] * unit[i]);
        let mut to_modal = DMatrix::from_fn(2 * n, 2 * n, |i, j| inverse[(i, j)] / unit[j]);
        // Where a coordinate that no spring holds stands is nothing to what moves: rounding would set it going.
        let is_free = |j: usize| scaled.view((n, j), (n, 1)).iter().all(|&k| k == 0.0);
        let moving = blocks.iter().flat_map(|block| block.roots());
        for (i, _) in moving.enumerate().filter(|(_, root)| root.norm() > 0.0) {
            for j in (0..n).filter(|&j| is_free(j)) {
                to_modal[(i, j)] = 0.0;
            }
        }
        Ok(Some(Self {
            blocks,
            to_physical,
            to_modal,
            condition,
        }))
    }
}

/// Real columns and blocks from complex roots and vectors, `None` where they do not pair.
fn real_blocks(
    roots: &DVector<Complex<f64>>,
    vectors: &DMatrix<Complex<f64>>,
) -> Option<(Vec<Block>, DMatrix<f64>)> {
    let largest = roots.iter().fold(0.0f64, |m, z| m.max(z.norm()));
    let is_real = |z: &Complex<f64>| z.im.abs() <= REAL_ROOT_TOL * largest;
    let mut order: Vec<usize> = (0..roots.len()).collect();
    order.sort_by(|&i, &j| roots[i].norm().total_cmp(&roots[j].norm()));
    let pairs: Vec<usize> = order
        .iter()
        .copied()
        .filter(|&i| !is_real(&roots[i]) && roots[i].im > 0.0)
        .collect();
    let reals: Vec<usize> = order
        .iter()
        .copied()
        .filter(|&i| is_real(&roots[i]))
        .collect();
    if 2 * pairs.len() + reals.len() != roots.len() {
        return None;
    }
    let mut blocks = Vec::with_capacity(roots.len() / 2);
    let mut columns = Vec::with_capacity(roots.len());
    for &i in &pairs {
        blocks.push(Block::Spiral {
            sigma: roots[i].re,
            omega: roots[i].im,
        });
        columns.push(vectors.column(i).map(|z| z.re));
        columns.push(vectors.column(i).map(|z| -z.im));
    }
    for two in reals.chunks(2) {
        let &[i, j] = two else { return None };
        let stands = |k: usize| roots[k].norm() <= STANDS_STILL * largest;
        let root = |k: usize| if stands(k) { 0.0 } else { roots[k].re };
        blocks.push(Block::Decays {
            roots: [root(i), root(j)],
        });
        for k in [i, j] {
            let vector = vectors.column(k);
            let pivot = vector[vector.icamax()];
            let mut column = vector.map(|z| (z * pivot.conj()).re / pivot.norm());
            if stands(k) {
                column.rows_mut(roots.len() / 2, roots.len() / 2).fill(0.0);
            }
            columns.push(column);
        }
    }
    let mut columns = DMatrix::from_columns(&columns);
    clear(&mut columns);
    Some((blocks, columns))
}

/// Clears the entries of modes that are rounding, of positions and of velocities: a force would seem to see a motion that it does not.
fn clear(columns: &mut DMatrix<f64>) {
    let n = columns.nrows() / 2;
    for mut column in columns.column_iter_mut() {
        for first in [0, n] {
            let mut part = column.rows_mut(first, n);
            let least = f64::EPSILON * part.amax();
            part.apply(|x| *x = if x.abs() > least { *x } else { 0.0 });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    #[test]
    fn blocks_rebuild_the_state_matrix() {
        let identity = DMatrix::<f64>::identity(2, 2);
        for (c, k) in [
            (
                dmatrix![0.3, -0.1; -0.1, 0.1],
                dmatrix![3.0, -1.0; -1.0, 2.0],
            ),
            (dmatrix![0.0, 1.0; -1.0, 0.0], dmatrix![1.0, 0.0; 0.0, 2.0]),
            (
                dmatrix![9.0, -1.0; -1.0, 0.1],
                dmatrix![3.0, -1.0; -0.5, 2.0],
            ),
        ] {
            let system = LinearSystem::new(identity.clone(), c, k).expect("valid");
            let modes = ComplexModes::new(&system)
                .expect("converges")
                .expect("not defective");
            let mut lambda = DMatrix::zeros(4, 4);
            for (j, block) in modes.blocks.iter().enumerate() {
                let m = block.matrix();
                for r in 0..2 {
                    for s in 0..2 {
                        lambda[(2 * j + r, 2 * j + s)] = m[r][s];
                    }
                }
            }
            let rebuilt = &modes.to_physical * lambda * &modes.to_modal;
            assert!((rebuilt - state_matrix(&system)).amax() < 1e-13);
        }
    }

    #[test]
    fn slow_modes_beside_a_light_body_keep_their_digits() {
        // A Coriolis force on a body of a hundredth of the mass: modes of rates 0.1 and 7, entries of the state matrix up to 60.
        let system = LinearSystem::new(
            DMatrix::from_diagonal(&DVector::from_vec(vec![0.017, 4.8, 1.7])),
            dmatrix![0.0, 0.71, -1.06; -0.71, 0.04, -0.57; 1.06, 0.57, 0.0],
            DMatrix::from_diagonal(&DVector::from_vec(vec![0.1, 0.16, 2.4])),
        );
        let modes = ComplexModes::new(&system.expect("valid")).expect("converges");
        let modes = modes.expect("not defective");
        positions_move_by_velocities(&modes);
    }

    #[test]
    fn positions_of_a_free_body_that_rounding_holds_move_by_their_velocities() {
        for held in [3e-16, -3e-16, 3e-15, 3e-14, 3e-12] {
            let stiffness = dmatrix![0.01, -0.01; -0.005, 0.005 + held];
            let system = LinearSystem::new(dvector![1.0, 1.0], DMatrix::zeros(2, 2), stiffness);
            let modes = ComplexModes::new(&system.expect("valid")).expect("converges");
            if let Some(modes) = modes {
                positions_move_by_velocities(&modes);
            }
        }
    }

    fn positions_move_by_velocities(modes: &ComplexModes) {
        let n = modes.blocks.len();
        for i in 0..n {
            let mut rate = DVector::zeros(2 * n);
            for (j, block) in modes.blocks.iter().enumerate() {
                let rows = modes.to_modal.rows(2 * j, 2);
                let m = block.matrix();
                for (r, &[first, second]) in m.iter().enumerate() {
                    let row = rows.row(0) * first + rows.row(1) * second;
                    rate += row.transpose() * modes.to_physical[(i, 2 * j + r)];
                }
            }
            rate[n + i] -= 1.0;
            assert!(rate.amax() < 1e-14, "{rate}");
        }
    }

    #[test]
    fn a_slow_root_beside_a_free_one_keeps_its_digits() {
        // A free body that gyroscopes turn: a root at zero, a slow one whose vector is near to the same, and fast ones.
        let system = LinearSystem::new(
            dvector![2.0, 0.5, 0.125],
            dmatrix![0.03125, 0.0, -1.25; 0.0, 0.007_812_5, 0.125; 1.25, -0.125, 0.003_906_25],
            dmatrix![2.5, -2.5, 0.0; -2.5, 3.5, -1.0; 0.0, -1.0, 1.0],
        );
        let modes = ComplexModes::new(&system.expect("valid")).expect("converges");
        let modes = modes.expect("not defective");
        let roots = modes.blocks.iter().flat_map(|block| block.roots());
        let slow = roots.fold(
            0.0,
            |slow: f64, z| if z.im == 0.0 { slow.min(z.re) } else { slow },
        );
        // det(M s^2 + C s + K)/s = 0 in fifty digits.
        let off = slow - -0.009_515_463_863_097_64;
        assert!(off.abs() < 1e-17, "{off:e}");
    }

    #[test]
    fn what_no_spring_holds_rests_anywhere() {
        let turning = dmatrix![0.02, 0.16, -1.8; -0.16, 0.02, 1.1; 1.8, -1.1, 0.02];
        let system = LinearSystem::new(DMatrix::identity(3, 3), turning, DMatrix::zeros(3, 3));
        let modes = ComplexModes::new(&system.expect("valid")).expect("converges");
        let modes = modes.expect("not defective");
        let mut rest = DVector::zeros(6);
        rest.rows_mut(0, 3).copy_from_slice(&[1.0 / 3.0, -0.4, 0.7]);
        let pairs = &modes.to_modal * &rest;
        for (j, block) in modes.blocks.iter().enumerate() {
            for (k, root) in block.roots().iter().enumerate() {
                assert!(root.norm() == 0.0 || pairs[2 * j + k] == 0.0, "{pairs}");
            }
        }
        let off = (&modes.to_physical * pairs - rest).amax();
        assert!(off < 1e-14, "{off}");
    }

    #[test]
    fn defective_state_matrices_are_recognised() {
        // A circulatory coupling that makes two equal oscillators one Jordan block.
        let identity = DMatrix::<f64>::identity(2, 2);
        let system =
            LinearSystem::new(identity, DMatrix::zeros(2, 2), dmatrix![1.0, 1.0; 0.0, 1.0])
                .expect("valid");
        assert!(ComplexModes::new(&system).expect("converges").is_none());
    }
}
