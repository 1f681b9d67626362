//! Audit of any given recovery matrix (theory 9): can rigid frictionless stops with these normals do it?

use crate::error::{Error, Result};
use crate::law::Newton;
use crate::linalg::{eigen, rank};
use crate::quantity::{finite_square, finite_vector};
use crate::tolerance::{AUDIT_TOL, SYMMETRY_TOL};
use nalgebra::{Cholesky, DMatrix, DVector};

/// What [`audit_recovery`] found.
#[derive(Debug, Clone, PartialEq)]
pub struct RecoveryAudit {
    /// Whether rigid, frictionless stops can act so: no reason against it was found.
    pub is_realisable: bool,
    /// The restitution coefficient along each normal [-], shape `(k,)`; nan where the matrix has none.
    pub restitution: DVector<f64>,
    /// The largest factor by which the matrix can multiply the kinetic energy [-].
    pub energy_gain: f64,
    /// Every rule that is broken, in words.
    pub reasons: Vec<String>,
}

/// Audits a recovery matrix: can rigid, frictionless stops with these normals do it? The matrix has the shape (2n, 2n), the mass
/// (n, n), the normals of the stops hit (n, k).
///
/// Four rules (theory 9): impulses act along the normals alone; each normal velocity is reversed by a restitution in
/// [0, 1]; the kinetic energy cannot grow; impulses push. With `R_v` the velocity part, the energy gain is the largest
/// eigenvalue of `M^-1 R_v^T M R_v`. The last two are asked of all velocities, which is sufficient, not necessary: an impact has
/// only those that close its stops.
///
/// # Errors
/// Wrong shapes, numbers that are not finite, a mass that is not symmetric positive definite, a normal that is zero.
pub fn audit_recovery(
    matrix: &DMatrix<f64>,
    mass: &DMatrix<f64>,
    normals: &DMatrix<f64>,
) -> Result<RecoveryAudit> {
    let n = mass.nrows();
    if n == 0 {
        let expected = "at least one degree of freedom";
        return Err(Error::bad_shape("mass", "(0, 0)", expected));
    }
    finite_square("mass", mass, n)?;
    finite_square("matrix", matrix, 2 * n)?;
    if normals.nrows() != n {
        let found = format!("({},)", normals.nrows());
        return Err(Error::bad_shape("normals", found, format!("({n},) each")));
    }
    for (i, normal) in normals.column_iter().enumerate() {
        let name = format!("normals[{i}]");
        finite_vector(&name, &normal.into_owned(), n)?;
        if normal.amax() == 0.0 {
            return Err(Error::bad_value(
                name,
                "zero",
                "a normal needs an entry that is not zero",
            ));
        }
    }
    let factor = Cholesky::new(mass.clone())
        .filter(|_| (mass - mass.transpose()).amax() <= SYMMETRY_TOL * mass.amax())
        .ok_or_else(|| {
            Error::bad_value(
                "mass",
                "not positive definite",
                "it must be symmetric positive definite",
            )
        })?;
    let velocity = matrix.view((n, n), (n, n)).into_owned();
    let mut reasons = Vec::new();

    let mut rest = matrix.clone();
    rest.view_mut((n, n), (n, n)).fill(0.0);
    for i in 0..n {
        rest[(i, i)] -= 1.0;
    }
    if rest.amax() > AUDIT_TOL {
        reasons.push("it moves positions, or couples them with velocities; an impact changes velocities alone".to_owned());
    }
    if outside_span(&(mass * (&velocity - DMatrix::identity(n, n))), normals)? {
        reasons.push(
            "it needs impulses that are not along the normals, M (R_v - I) leaves their span"
                .to_owned(),
        );
    }
    let restitution = restitutions(&velocity, normals, &mut reasons);
    let energy_gain = largest_gain(&velocity, &factor)?;
    if energy_gain > 1.0 + AUDIT_TOL {
        reasons.push(format!(
            "it can multiply the kinetic energy by {energy_gain:.6}"
        ));
    }
    if normals.ncols() > 0 && restitution.iter().all(|e| e.is_finite()) {
        let delassus = normals.tr_mul(&factor.solve(normals));
        let rebound = DMatrix::from_diagonal(&restitution.map(|e| Newton::known(e).factor()));
        if let Some(inverse) = delassus.try_inverse() {
            let impulses = inverse * rebound;
            if impulses.min() < -AUDIT_TOL * impulses.amax() {
                reasons.push("some approach velocities need a pulling impulse".to_owned());
            }
        }
    }
    Ok(RecoveryAudit {
        is_realisable: reasons.is_empty(),
        restitution,
        energy_gain,
        reasons,
    })
}

/// Whether a column of `image` leaves the span of `normals`.
fn outside_span(image: &DMatrix<f64>, normals: &DMatrix<f64>) -> Result<bool> {
    for column in image.column_iter() {
        let column = column.into_owned();
        if column.norm() <= AUDIT_TOL * image.norm() {
            continue;
        }
        if normals.ncols() == 0 {
            return Ok(true);
        }
        let set = rank::solve(normals, &column, AUDIT_TOL * normals.amax())?;
        if (normals * set.particular - &column).norm() > AUDIT_TOL * image.norm() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// `e_i` with `n_i^T R_v = -e_i n_i^T`, nan where there is none.
fn restitutions(
    velocity: &DMatrix<f64>,
    normals: &DMatrix<f64>,
    reasons: &mut Vec<String>,
) -> DVector<f64> {
    DVector::from_iterator(
        normals.ncols(),
        normals.column_iter().enumerate().map(|(i, normal)| {
            let image = velocity.tr_mul(&normal);
            let e = -image.dot(&normal) / normal.norm_squared();
            if (image + normal * e).amax() > AUDIT_TOL * normal.amax() {
                reasons.push(format!(
                    "the velocity along normal {i} after impact does not follow from the one before"
                ));
                f64::NAN
            } else {
                if !(-AUDIT_TOL..=1.0 + AUDIT_TOL).contains(&e) {
                    reasons.push(format!(
                        "the restitution along normal {i} is {e:.6}, outside [0, 1]"
                    ));
                }
                e
            }
        }),
    )
}

/// The largest eigenvalue of `M^-1 R_v^T M R_v`, as that of `G^T G`, `G = L^T R_v L^-T`.
fn largest_gain(velocity: &DMatrix<f64>, mass: &Cholesky<f64, nalgebra::Dyn>) -> Result<f64> {
    let l = mass.l();
    let inverse_t = l
        .transpose()
        .try_inverse()
        .expect("a Cholesky factor is regular");
    let g = l.transpose() * velocity * inverse_t;
    Ok(eigen::symmetric(g.transpose() * g)?.0.max())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::impact::recovery_matrix;
    use crate::model::{Forcing, Reaction, Scene, Stop, paper_system};

    fn paper_audit(mass_ratio: f64, stops: &[usize], reaction: &Reaction) -> RecoveryAudit {
        let system = paper_system(mass_ratio, 3.24, 0.05).expect("valid");
        let stop = |i: usize| {
            Stop::new(i, 0.3, 0.9)
                .and_then(|s| s.with_reaction(reaction.clone()))
                .expect("valid")
        };
        let mass = system.mass().to_dense();
        let scene = Scene::new(system, Forcing::Unforced, [stop(0), stop(1)]).expect("valid");
        let matrix = recovery_matrix(&scene, stops).expect("valid");
        let normals = DMatrix::<f64>::identity(2, 2).select_columns(stops);
        audit_recovery(&matrix, &mass, &normals).expect("valid")
    }

    #[test]
    fn the_papers_single_impacts_can_multiply_the_energy() {
        // theory 1: 5.27 for m = 1, 12.58 for m = 3, whatever mu
        for (mass_ratio, gain) in [(1.0, 5.27), (3.0, 12.58)] {
            for stop in [0, 1] {
                let audit = paper_audit(mass_ratio, &[stop], &Reaction::Coordinate);
                assert!(!audit.is_realisable);
                assert!(
                    (audit.energy_gain - gain).abs() < 5e-3,
                    "{}",
                    audit.energy_gain
                );
                assert!((audit.restitution[0] - 0.9).abs() < 1e-14);
            }
            let both = paper_audit(mass_ratio, &[0, 1], &Reaction::Coordinate);
            assert!((both.energy_gain - 0.81).abs() < 1e-14);
        }
    }

    #[test]
    fn newtons_law_passes() {
        for stops in [&[0][..], &[1], &[]] {
            let audit = paper_audit(1.0, stops, &Reaction::Inertia);
            assert!(audit.is_realisable, "{:?}", audit.reasons);
            assert!(audit.energy_gain <= 1.0 + 1e-14);
        }
    }
}
