//! Where the affine set of contact states and phases that the linear conditions leave meets the unit circle of
//! `u = (cos phase, sin phase)` (theory 5).

use crate::error::Result;
use crate::linalg::rank::SolutionSet;
use crate::modal::Pair;

use crate::tolerance::{AT_FOLD, CONDITIONS_RANK, ON_UNIT_CIRCLE, SOLVABLE};
use nalgebra::{DMatrix, DVector};

/// Where the solution set meets the circle.
pub(crate) struct PhaseSolutions {
    /// Solutions X, each with |u| = 1, of shape (unknowns,): impulses [N s], resonant modal states, cosines and sines [-].
    pub points: Vec<DVector<f64>>,
    /// `1 -` the distance of the set from the origin of the u plane; `None` where there is no solution at all.
    pub margin: Option<f64>,
    /// Directions, as null vectors X, in which each point may be moved freely, shape (unknowns, dimension), [units of X].
    pub basis: DMatrix<f64>,
    /// Whether every phase is reached.
    pub is_any_phase: bool,
}

fn norm(u: Pair) -> f64 {
    u[0].hypot(u[1])
}

/// Where a line in the plane of u meets the unit circle.
pub(crate) struct Chord {
    /// `1 -` the distance of the line from the origin.
    pub margin: f64,
    ends: [f64; 2],
    count: usize,
}

impl Chord {
    /// The multiples c of the direction at which the line is on the circle: none, one (a fold) or two.
    pub fn ends(&self) -> &[f64] {
        &self.ends[..self.count]
    }
}

/// The chord of the line `u0 + c direction`.
pub(crate) fn chord(u0: Pair, direction: Pair) -> Chord {
    let length = norm(direction);
    let e = [direction[0] / length, direction[1] / length];
    let along = u0[0] * e[0] + u0[1] * e[1];
    let distance = (u0[0] * e[1] - u0[1] * e[0]).abs();
    let half = ((1.0 - distance) * (1.0 + distance)).max(0.0).sqrt();
    let count = match () {
        () if distance > 1.0 + AT_FOLD || distance.is_nan() => 0,
        () if half == 0.0 => 1,
        () => 2,
    };
    Chord {
        margin: 1.0 - distance,
        ends: [(-half - along) / length, (half - along) / length],
        count,
    }
}

/// The points of `set` with |u| = 1, u the part of X that `phase_part` reads.
pub(crate) fn meet_circle(
    set: &SolutionSet,
    phase_part: impl Fn(&DVector<f64>) -> Pair,
) -> Result<PhaseSolutions> {
    let dimension = set.particular.len();
    let mut phases = PhaseSolutions {
        points: Vec::new(),
        margin: None,
        basis: DMatrix::zeros(dimension, 0),
        is_any_phase: false,
    };
    if set.residual > SOLVABLE {
        return Ok(phases);
    }
    let x0 = &set.particular;
    let u0 = phase_part(x0);
    let m = set.null_space.ncols();
    let directions = DMatrix::from_fn(2, m, |i, j| {
        phase_part(&set.null_space.column(j).into_owned())[i]
    });
    // Turn the null space so that its first columns move u and the others do not.
    let (moving, fixed) = split(&set.null_space, &directions)?;
    phases.basis = fixed;
    match moving.len() {
        0 => {
            phases.margin = Some(1.0 - norm(u0));
            if (1.0 - norm(u0)).abs() <= ON_UNIT_CIRCLE {
                phases.points.push(x0.clone());
            }
        }
        1 => {
            let chord = chord(u0, phase_part(&moving[0]));
            phases.margin = Some(chord.margin);
            phases.points = chord.ends().iter().map(|&c| x0 + &moving[0] * c).collect();
        }
        _ => {
            // The whole plane: every phase; phase 0 stands for them.
            let plane = DMatrix::from_fn(2, 2, |i, j| phase_part(&moving[j])[i]);
            if let Some(inverse) = plane.try_inverse() {
                let c = inverse * DVector::from_vec(vec![1.0 - u0[0], -u0[1]]);
                phases
                    .points
                    .push(x0 + &moving[0] * c[0] + &moving[1] * c[1]);
                phases.is_any_phase = true;
                phases.margin = Some(1.0);
            }
        }
    }
    Ok(phases)
}

/// Null vectors that move u, and an orthogonal set of those that do not.
fn split(
    null_space: &DMatrix<f64>,
    directions: &DMatrix<f64>,
) -> Result<(Vec<DVector<f64>>, DMatrix<f64>)> {
    let m = null_space.ncols();
    if m == 0 {
        return Ok((Vec::new(), null_space.clone()));
    }
    let is_negligible = directions.amax() <= CONDITIONS_RANK * null_space.amax();
    if is_negligible {
        return Ok((Vec::new(), null_space.clone()));
    }
    let kernel = crate::linalg::rank::solve(
        directions,
        &DVector::zeros(2),
        CONDITIONS_RANK * directions.amax(),
    )?
    .null_space;
    let fixed = null_space * &kernel;
    // The orthogonal complement of the kernel.
    let complement = crate::linalg::rank::solve(
        &kernel.transpose(),
        &DVector::zeros(kernel.ncols()),
        CONDITIONS_RANK,
    )?;
    let moving = if kernel.ncols() == 0 {
        DMatrix::identity(m, m)
    } else {
        complement.null_space
    };
    Ok((
        (0..moving.ncols())
            .map(|j| null_space * moving.column(j))
            .collect(),
        fixed,
    ))
}
