//! Pendulums on a moving base: the double pendulum of eq. (3) and the chain of N links. Angles are absolute, from the
//! downward vertical; the linear systems are theory section 2.

use crate::error::{Error, Result};
use crate::model::linear::{Coefficient, LinearSystem};
use crate::quantity::{finite, finite_vector, positive};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};

/// The coefficients of a pendulum's equations of motion on a base with acceleration `-b` (theory 2):
/// `sum_j I_ij (cos(q_i - q_j) q_j'' + sin(q_i - q_j) v_j^2) = h_i (b cos q_i - g sin q_i) - (C v)_i`.
#[derive(Debug, Clone)]
pub(crate) struct Links {
    /// The inertia I, shape `(N, N)`, [kg m^2]; dimensionless for the double pendulum, as all of these.
    pub inertia: DMatrix<f64>,
    /// The static moments h, shape `(N,)`, [kg m].
    pub static_moment: DVector<f64>,
    /// The gravity g [m/s^2].
    pub gravity: f64,
    /// The damping matrix C, shape `(N, N)`, [N m s/rad].
    pub damping: DMatrix<f64>,
}

/// Double pendulum of the source paper's eq. (3), nonlinear and dimensionless.
/// Time is in units of `1/(w1 sqrt(1 + m))`, base amplitudes in units of `l1`.
#[derive(Debug, Clone, PartialEq)]
pub struct DoublePendulum {
    mass_ratio: f64,
    length_ratio: f64,
    damping: DMatrix<f64>,
}

impl DoublePendulum {
    /// A double pendulum with `mass_ratio = m2/m1`, `length_ratio = l1/l2` and joint dampers `(p1, p2)`.
    ///
    /// # Errors
    /// A ratio that is not positive, a damper that is not finite.
    pub fn new(mass_ratio: f64, length_ratio: f64, dampers: (f64, f64)) -> Result<Self> {
        let (p1, p2) = (
            finite("damping[0]", dampers.0)?,
            finite("damping[1]", dampers.1)?,
        );
        Self::with_damping_matrix(mass_ratio, length_ratio, dmatrix![p1 + p2, -p2; -p2, p2])
    }

    /// A double pendulum with any damping matrix C in the symmetric form of its equations.
    ///
    /// # Errors
    /// A ratio that is not positive, a matrix that is not 2 by 2 or not finite.
    pub fn with_damping_matrix(
        mass_ratio: f64,
        length_ratio: f64,
        damping: DMatrix<f64>,
    ) -> Result<Self> {
        crate::quantity::finite_square("damping", &damping, 2)?;
        Ok(Self {
            mass_ratio: positive("mass_ratio", mass_ratio)?,
            length_ratio: positive("length_ratio", length_ratio)?,
            damping,
        })
    }

    /// `m2/m1`.
    pub fn mass_ratio(&self) -> f64 {
        self.mass_ratio
    }

    /// `l1/l2`.
    pub fn length_ratio(&self) -> f64 {
        self.length_ratio
    }

    /// The damping matrix, shape `(2, 2)`.
    pub fn damping(&self) -> &DMatrix<f64> {
        &self.damping
    }

    /// The mass matrix of small angles, shape `(2, 2)`.
    pub(crate) fn mass(&self) -> DMatrix<f64> {
        pendulum_mass(self.mass_ratio, self.length_ratio)
    }

    /// The entries of its mass matrix, without the turn of the links in the coupling.
    pub(crate) fn inertia(&self) -> [f64; 3] {
        pendulum_inertia(self.mass_ratio, self.length_ratio)
    }

    /// The coefficients of its equations of motion.
    pub(crate) fn links(&self) -> Links {
        let inertia = self.mass();
        Links {
            // A bob's share of the base's push is its coupling to the first link, whose length is one.
            static_moment: inertia.column(0).into_owned(),
            inertia,
            gravity: 1.0 / (1.0 + self.mass_ratio),
            damping: self.damping.clone(),
        }
    }

    /// The lengths `(1, 1/mu)`.
    pub(crate) fn link_lengths(&self) -> DVector<f64> {
        dvector![1.0, 1.0 / self.length_ratio]
    }

    pub(crate) fn with_damping_scaled(&self, factor: f64) -> Result<Self> {
        Self::with_damping_matrix(
            self.mass_ratio,
            self.length_ratio,
            &self.damping * finite("damping_scale", factor)?,
        )
    }

    /// The linear system about the hanging equilibrium, influence vector filled in.
    ///
    /// # Errors
    /// Ratios so far apart that the mass matrix is singular in double precision.
    pub fn linearise(&self) -> Result<LinearSystem> {
        LinearSystem::new(
            pendulum_mass(self.mass_ratio, self.length_ratio),
            self.damping.clone(),
            pendulum_stiffness(self.mass_ratio, self.length_ratio),
        )?
        .with_influence(dvector![1.0, 0.0])
    }
}

/// `(1, alpha, alpha/mu)`: the entries of the mass matrix, but for the cosine of the angle between the links in the second.
fn pendulum_inertia(mass_ratio: f64, length_ratio: f64) -> [f64; 3] {
    let alpha = mass_ratio / (1.0 + mass_ratio) / length_ratio;
    [1.0, alpha, alpha / length_ratio]
}

/// `[[1, alpha], [alpha, alpha/mu]]`.
pub(crate) fn pendulum_mass(mass_ratio: f64, length_ratio: f64) -> DMatrix<f64> {
    let [outer, coupling, inner] = pendulum_inertia(mass_ratio, length_ratio);
    dmatrix![outer, coupling; coupling, inner]
}

/// `diag(1, alpha)/(1 + m)`.
pub(crate) fn pendulum_stiffness(mass_ratio: f64, length_ratio: f64) -> DMatrix<f64> {
    let alpha = mass_ratio / (1.0 + mass_ratio) / length_ratio;
    DMatrix::from_diagonal(&dvector![
        1.0 / (1.0 + mass_ratio),
        alpha / (1.0 + mass_ratio)
    ])
}

/// Chain of N pendulum links in physical units, nonlinear. Its base may move horizontally.
#[derive(Debug, Clone, PartialEq)]
pub struct PendulumChain {
    masses: DVector<f64>,
    lengths: DVector<f64>,
    damping: DMatrix<f64>,
    gravity: f64,
}

impl PendulumChain {
    /// A chain with point masses, link lengths, joint dampers `(N,)` and gravity.
    ///
    /// # Errors
    /// Arrays of different lengths, masses or lengths that are not positive, numbers that are not finite.
    pub fn new(
        masses: DVector<f64>,
        lengths: DVector<f64>,
        dampers: &DVector<f64>,
        gravity: f64,
    ) -> Result<Self> {
        finite_vector("damping", dampers, masses.len())?;
        let n = masses.len();
        let outer = |i: usize| if i + 1 < n { dampers[i + 1] } else { 0.0 };
        let damping = DMatrix::from_fn(n, n, |i, j| {
            if i == j {
                dampers[i] + outer(i)
            } else if i.abs_diff(j) == 1 {
                -dampers[i.max(j)]
            } else {
                0.0
            }
        });
        Self::with_damping_matrix(masses, lengths, damping, gravity)
    }

    /// A chain with any damping matrix.
    ///
    /// # Errors
    /// As `new`.
    pub fn with_damping_matrix(
        masses: DVector<f64>,
        lengths: DVector<f64>,
        damping: DMatrix<f64>,
        gravity: f64,
    ) -> Result<Self> {
        let n = masses.len();
        if n == 0 {
            return Err(Error::bad_shape("masses", "(0,)", "at least one link"));
        }
        finite_vector("lengths", &lengths, n)?;
        for i in 0..n {
            positive(&format!("masses[{i}]"), masses[i])?;
            positive(&format!("lengths[{i}]"), lengths[i])?;
        }
        crate::quantity::finite_square("damping", &damping, n)?;
        Ok(Self {
            masses,
            lengths,
            damping,
            gravity: finite("gravity", gravity)?,
        })
    }

    /// Number of links.
    pub fn n_dof(&self) -> usize {
        self.masses.len()
    }

    /// Point masses, shape `(N,)`.
    pub fn masses(&self) -> &DVector<f64> {
        &self.masses
    }

    /// Link lengths, shape `(N,)`.
    pub fn lengths(&self) -> &DVector<f64> {
        &self.lengths
    }

    /// The damping matrix, shape `(N, N)`.
    pub fn damping(&self) -> &DMatrix<f64> {
        &self.damping
    }

    /// Gravity.
    pub fn gravity(&self) -> f64 {
        self.gravity
    }

    pub(crate) fn with_damping_scaled(&self, factor: f64) -> Result<Self> {
        Self::with_damping_matrix(
            self.masses.clone(),
            self.lengths.clone(),
            &self.damping * finite("damping_scale", factor)?,
            self.gravity,
        )
    }

    /// The coefficients of its equations of motion.
    pub(crate) fn links(&self) -> Links {
        let (n, l, s) = (self.n_dof(), &self.lengths, self.hanging_mass());
        Links {
            inertia: DMatrix::from_fn(n, n, |i, j| l[i] * l[j] * s[i.max(j)]),
            static_moment: l.component_mul(&s),
            gravity: self.gravity,
            damping: self.damping.clone(),
        }
    }

    /// `S_k`, the mass that hangs at joint k and below.
    pub(crate) fn hanging_mass(&self) -> DVector<f64> {
        let n = self.n_dof();
        DVector::from_fn(n, |k, _| self.masses.rows(k, n - k).sum())
    }

    /// The linear system about the hanging equilibrium, influence vector filled in.
    ///
    /// # Errors
    /// Masses so far apart that the mass matrix is singular in double precision.
    pub fn linearise(&self) -> Result<LinearSystem> {
        let links = self.links();
        let stiffness = DMatrix::from_diagonal(&(&links.static_moment * links.gravity));
        // M r = (l_i S_i) has the solution r = e_1 / l_1: a base displacement turns the first link alone.
        let mut influence = DVector::zeros(self.n_dof());
        influence[0] = 1.0 / self.lengths[0];
        LinearSystem::new(links.inertia, Coefficient::Dense(links.damping), stiffness)?
            .with_influence(influence)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chain_of_two_is_the_double_pendulum_in_other_units() {
        let (m1, m2, l1, l2, g) = (2.0, 1.0, 0.7, 0.3, 9.81);
        let (c1, c2) = (0.4, 0.25);
        let chain = PendulumChain::new(dvector![m1, m2], dvector![l1, l2], &dvector![c1, c2], g)
            .expect("valid");
        let m: f64 = m2 / m1;
        let rate = (g / l1 * (1.0 + m)).sqrt();
        let unit = (m1 + m2) * l1 * l1; // of moments of inertia: the first entry of the mass matrix
        let (p1, p2) = (c1 / (rate * unit), c2 / (rate * unit));
        let pair = DoublePendulum::new(m, l1 / l2, (p1, p2))
            .expect("valid")
            .linearise()
            .expect("valid");
        let chain = chain.linearise().expect("valid");
        let close = |a: DMatrix<f64>, b: DMatrix<f64>| assert!((a - b).amax() < 1e-15);
        close(chain.mass().to_dense() / unit, pair.mass().to_dense());
        close(
            chain.damping().to_dense() / (unit * rate),
            pair.damping().to_dense(),
        );
        close(
            chain.stiffness().to_dense() / (unit * rate * rate),
            pair.stiffness().to_dense(),
        );
    }

    #[test]
    fn base_motion_loads_every_link_with_the_mass_below_it() {
        let chain = PendulumChain::new(
            dvector![1.0, 2.0, 3.0],
            dvector![0.5, 0.6, 0.7],
            &dvector![0.0, 0.0, 0.0],
            9.81,
        )
        .expect("valid")
        .linearise()
        .expect("valid");
        let force = chain.mass().times(chain.influence().expect("filled in"));
        assert!((force - dvector![0.5 * 6.0, 0.6 * 5.0, 0.7 * 3.0]).amax() < 1e-15);
    }
}
