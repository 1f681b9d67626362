//! Impact recovery matrices (theory 1): `x+ = R x-`, `R = blockdiag(I, P)`, for the stops hit at one instant, with
//! `N^T P = -E N^T` whatever the reaction directions. As matrices, for audits and orbits: simulations strike stop by stop.

use crate::error::{Error, Result};
use crate::linalg::rank;
use crate::model::{ContactGeometry, Scene};
use crate::quantity::room_for;
use crate::tolerance::{AGREEING_RESTITUTION, DEPENDENT};
use nalgebra::{DMatrix, DVector};

/// `(N^T B)^-1 (I + E)` for the stops hit: what turns approach speeds into impulses, shape `(k, k)`.
///
/// Of dependent normals (the same stop given twice) the impulses of least norm are taken; restitutions that contradict
/// each other there are an error.
pub(crate) fn impulse_matrix(geometry: &ContactGeometry, stops: &[usize]) -> Result<DMatrix<f64>> {
    let k = stops.len();
    let delassus = geometry.delassus(stops);
    let rebound =
        DMatrix::from_diagonal(&DVector::from_fn(k, |i, _| geometry.law(stops[i]).factor()));
    if k == 1 {
        return Ok(rebound / delassus[(0, 0)]);
    }
    // Solve for the impulses of each approach velocity v = B c that the reactions can undo.
    let mut inverse = DMatrix::zeros(k, k);
    let mut dependent = false;
    for j in 0..k {
        let set = rank::solve(
            &delassus,
            &rebound.column(j).into_owned(),
            DEPENDENT * delassus.amax(),
        )?;
        dependent |= set.null_space.ncols() > 0;
        inverse.set_column(j, &set.particular);
    }
    if dependent {
        let normals = geometry.normals.select_columns(stops);
        let result = normals.transpose() - &delassus * &inverse * normals.transpose();
        let wanted = DMatrix::from_fn(k, normals.nrows(), |i, j| {
            -geometry.law(stops[i]).restitution * normals[(j, i)]
        });
        if (result - wanted).amax() > AGREEING_RESTITUTION * normals.amax() {
            return Err(Error::bad_value(
                "pattern",
                format!("{stops:?}"),
                "stops with dependent normals can be hit together only if their restitutions agree",
            ));
        }
    }
    Ok(inverse)
}

/// The velocity part `P = I - B (N^T B)^-1 (I + E) N^T` of the recovery matrix, shape `(n, n)`.
pub(crate) fn velocity_recovery(
    geometry: &ContactGeometry,
    stops: &[usize],
) -> Result<DMatrix<f64>> {
    let n = geometry.normals.nrows();
    let impulses = impulse_matrix(geometry, stops)?;
    let (normals, reactions) = geometry.columns(stops);
    Ok(DMatrix::identity(n, n) - reactions * impulses * normals.transpose())
}

/// The recovery matrix R of the stops hit together: x+ = R x-, x = (q, v). Its shape is (2n, 2n).
///
/// # Errors
/// A nonlinear scene, a stop that does not exist or stands twice, stops with dependent normals and unequal restitution.
///
/// # References
/// The source paper, eq. (23) and Note 2, where the reaction is the coordinate's own; theory section 1.
///
/// # Examples
/// ```
/// use vibroimpact::{Kind, PaperOptions, paper_scene, recovery_matrix};
/// let scene = paper_scene(Kind::One, &PaperOptions::default())?;
/// let r1 = recovery_matrix(&scene, &[0, 1])?;
/// assert!((r1[(2, 2)] + 0.9).abs() < 1e-15 && (r1[(3, 3)] + 0.9).abs() < 1e-15);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn recovery_matrix(scene: &Scene, stops: &[usize]) -> Result<DMatrix<f64>> {
    let system = scene.linear_system("recovery_matrix")?;
    scene.check_stops_are_rigid("recovery_matrix")?;
    check_stops("stops", stops, scene.stops().len())?;
    let geometry = ContactGeometry::new(system, scene);
    let n = system.n_dof();
    room_for("the recovery matrix", 2 * n, 2 * n)?;
    let mut matrix = DMatrix::identity(2 * n, 2 * n);
    if !stops.is_empty() {
        matrix
            .view_mut((n, n), (n, n))
            .copy_from(&velocity_recovery(&geometry, stops)?);
    }
    Ok(matrix)
}

/// Checks that every stop exists and none stands twice.
pub(crate) fn check_stops(argument: &str, stops: &[usize], count: usize) -> Result<()> {
    for (i, &stop) in stops.iter().enumerate() {
        if stop >= count {
            let rule = if count == 0 {
                "the scene has no stops".to_owned()
            } else {
                format!("the scene has stops 0 to {}", count - 1)
            };
            return Err(Error::bad_value(argument, format!("{stops:?}"), rule));
        }
        if stops[..i].contains(&stop) {
            let rule = format!("stop {stop} can be hit only once at one instant");
            return Err(Error::bad_value(argument, format!("{stops:?}"), rule));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Forcing, LinearSystem, Reaction, Stop};
    use nalgebra::{dmatrix, dvector};

    fn geometry(stops: Vec<Stop>) -> ContactGeometry {
        let system = LinearSystem::new(
            dmatrix![2.0, 0.5; 0.5, 1.0],
            DMatrix::zeros(2, 2),
            DMatrix::zeros(2, 2),
        )
        .expect("valid");
        let scene = Scene::new(system.clone(), Forcing::Unforced, stops).expect("valid");
        ContactGeometry::new(&system, &scene)
    }

    #[test]
    fn every_stop_hit_reverses_its_own_normal_velocity() {
        for reaction in [
            Reaction::Inertia,
            Reaction::Coordinate,
            Reaction::Direction(dvector![1.0, 1.0]),
        ] {
            let stop = |n, e| {
                Stop::new(n, 0.1, e)
                    .and_then(|s| s.with_reaction(reaction.clone()))
                    .expect("valid")
            };
            let g = geometry(vec![
                stop(dvector![1.0, 0.2], 0.8),
                stop(dvector![0.3, 1.0], 0.3),
            ]);
            let independent = (&g.normals.transpose() * &g.reactions).determinant().abs() > 1e-6;
            let sets: &[&[usize]] = if independent {
                &[&[0], &[1], &[0, 1]]
            } else {
                &[&[0], &[1]]
            };
            for &stops in sets {
                let p = velocity_recovery(&g, stops).expect("independent");
                for &i in stops {
                    let n = g.normals.column(i);
                    assert!((p.tr_mul(&n) + n * g.law(i).restitution).amax() < 1e-14);
                }
            }
        }
    }

    #[test]
    fn the_sum_formula_is_wrong_for_coupled_stops() {
        let stop = |i: usize| Stop::new(i, 0.1, 0.9).expect("valid");
        let g = geometry(vec![stop(0), stop(1)]);
        let one =
            |i: usize| DMatrix::identity(2, 2) - velocity_recovery(&g, &[i]).expect("one stop");
        let sum = DMatrix::identity(2, 2) - one(0) - one(1);
        assert!((sum.transpose() * g.normals.column(0) + g.normals.column(0) * 0.9).amax() > 0.1);
    }

    #[test]
    fn the_same_stop_twice_acts_once() {
        let stop = |e: f64| Stop::new(0, 0.1, e).expect("valid");
        let twice = geometry(vec![stop(0.9), stop(0.9)]);
        let p = velocity_recovery(&twice, &[0, 1]).expect("consistent");
        assert!((p - velocity_recovery(&twice, &[0]).expect("one")).amax() < 1e-14);
        assert!(velocity_recovery(&geometry(vec![stop(0.9), stop(0.5)]), &[0, 1]).is_err());
    }
}
