//! Forces of several stops in lasting contact, and which of them let go (theory 9, "Several stuck stops").

use crate::error::{Error, Result};
use crate::impact::several_stops::check_contacts;
use crate::linalg::complementarity;
use nalgebra::{DMatrix, DVector};

/// What a stop in lasting contact does next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Release {
    /// It pushes and its gap stays closed.
    Stays,
    /// It does not push and its gap opens.
    Leaves,
    /// Force and acceleration are both zero within the slack: higher derivatives decide.
    Undecided,
}

/// One stop in lasting contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// The force L, at least 0: `v' = a_free - sum b_i L_i`.
    pub force: f64,
    /// The second derivative of the gap, at least 0; exactly 0 where the stop pushes.
    pub acceleration: f64,
    /// Whether the contact lasts.
    pub release: Release,
}

/// The forces of k stops in lasting contact (`h = h' = 0`), from the accelerations that their gaps would have without them.
///
/// With the free accelerations `c = -N^T a_free + kappa` (k,) of the gaps and the Delassus matrix `G = N^T B` (k, k):
///
/// ```text
/// 0 <= L  perp  h'' = c + G L >= 0.
/// ```
///
/// A stop with `L > 0` stays, one with `h'' > 0` leaves. Where `n.b L` and `h''` are both within `slack` (k,), at least 0, of
/// zero, it is undecided. Dependent normals share the force such that its norm is least; where all reactions are `M^-1 n`, or
/// all are `n`, they leave h'' as it is.
///
/// # Errors
/// Wrong shapes, numbers that are not finite, a diagonal entry of G (`n . b`) not above zero, a negative slack; no forces that
/// push keep the gaps closed (curved walls with less and less room between them: a jam), or numbers that overflow.
///
/// # References
/// F. Pfeiffer, C. Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 5; theory section 9.
///
/// # Examples
/// A unit mass in a corner, pressed to the first wall and pulled from the second:
/// ```
/// use vibroimpact::nalgebra::{DMatrix, dvector};
/// use vibroimpact::{Release, contact_forces};
/// let g = DMatrix::identity(2, 2);
/// let forces = contact_forces(&g, &dvector![-3.0, 2.0], &dvector![1e-14, 1e-14])?;
/// assert_eq!((forces[0].force, forces[0].release), (3.0, Release::Stays));
/// assert_eq!((forces[1].acceleration, forces[1].release), (2.0, Release::Leaves));
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn contact_forces(
    delassus: &DMatrix<f64>,
    free_accelerations: &DVector<f64>,
    slack: &DVector<f64>,
) -> Result<Vec<ContactForce>> {
    check_contacts(delassus, ("free_accelerations", free_accelerations), slack)?;
    let solution =
        complementarity::solve(delassus, free_accelerations.as_slice(), slack.as_slice())
            .filter(|s| s.x.iter().chain(&s.w).all(|value| value.is_finite()))
            .ok_or_else(|| {
                Error::bad_value(
                    "free_accelerations",
                    "such that these contacts have no forces",
                    "forces that push must be able to keep every gap from closing, in numbers that do not overflow",
                )
            })?;
    Ok((0..slack.len())
        .map(|i| {
            let (force, acceleration) = (solution.x[i], solution.w[i]);
            let release = if delassus[(i, i)] * force > slack[i] {
                Release::Stays
            } else if acceleration > slack[i] {
                Release::Leaves
            } else {
                Release::Undecided
            };
            ContactForce {
                force,
                acceleration,
                release,
            }
        })
        .collect())
}
