//! Linear systems `M q'' + C q' + K q = f0 + forcing`: dense or diagonal coefficients, M positive definite, C and K any
//! real matrices (non-symmetric, singular, zero).

use crate::error::{Error, Result};
use crate::model::derived::Derived;
use crate::quantity::{finite_square, finite_vector};
use crate::tolerance::SYMMETRY_TOL;
use nalgebra::{Cholesky, Complex, DMatrix, DVector, DVectorViewMut, Dyn};

/// A coefficient matrix: dense, or the diagonal of one.
#[derive(Debug, Clone, PartialEq)]
pub enum Coefficient {
    /// The diagonal of a diagonal matrix, shape `(n,)`.
    Diagonal(DVector<f64>),
    /// A dense matrix, shape `(n, n)`.
    Dense(DMatrix<f64>),
}

impl From<DMatrix<f64>> for Coefficient {
    fn from(matrix: DMatrix<f64>) -> Self {
        Self::Dense(matrix)
    }
}

impl From<DVector<f64>> for Coefficient {
    fn from(diagonal: DVector<f64>) -> Self {
        Self::Diagonal(diagonal)
    }
}

impl Coefficient {
    /// Number of rows.
    pub fn order(&self) -> usize {
        match self {
            Self::Diagonal(d) => d.len(),
            Self::Dense(m) => m.nrows(),
        }
    }

    /// The matrix times a vector.
    pub fn times(&self, x: &DVector<f64>) -> DVector<f64> {
        match self {
            Self::Diagonal(d) => d.component_mul(x),
            Self::Dense(m) => m * x,
        }
    }

    /// The matrix in dense form, shape `(n, n)`.
    pub fn to_dense(&self) -> DMatrix<f64> {
        match self {
            Self::Diagonal(d) => DMatrix::from_diagonal(d),
            Self::Dense(m) => m.clone(),
        }
    }

    /// The diagonal if every other entry is zero.
    pub fn diagonal(&self) -> Option<DVector<f64>> {
        match self {
            Self::Diagonal(d) => Some(d.clone()),
            Self::Dense(m) if m.nrows() <= 1 => Some(m.diagonal()),
            Self::Dense(_) => None,
        }
    }

    /// Whether the matrix equals its transpose, to rounding.
    pub fn is_symmetric(&self) -> bool {
        match self {
            Self::Diagonal(_) => true,
            Self::Dense(m) => {
                let row = |i: usize| m.row(i).amax().max(m.column(i).amax());
                let rows: Vec<f64> = (0..m.nrows()).map(row).collect();
                (0..m.nrows()).all(|i| {
                    let own = |j: usize| SYMMETRY_TOL * rows[i].min(rows[j]);
                    (0..i).all(|j| (m[(i, j)] - m[(j, i)]).abs() <= own(j))
                })
            }
        }
    }

    /// The matrix times a number.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::Diagonal(d) => Self::Diagonal(d * factor),
            Self::Dense(m) => Self::Dense(m * factor),
        }
    }

    pub(super) fn check(&self, argument: &str, n: usize) -> Result<()> {
        match self {
            Self::Diagonal(d) => finite_vector(argument, d, n),
            Self::Dense(m) => finite_square(argument, m, n),
        }
    }
}

/// The factor of the mass with which `M x = b` is solved.
#[derive(Debug, Clone)]
enum MassFactor {
    Diagonal(DVector<f64>),
    Cholesky(Cholesky<f64, Dyn>),
}

/// Linear system `M q'' + C q' + K q = f0 + forcing` with n degrees of freedom.
///
/// The mass is symmetric positive definite; damping and stiffness are any real matrices.
///
/// # Examples
/// ```
/// use nalgebra::dvector;
/// use vibroimpact::LinearSystem;
///
/// // Two modes of a structure: unit modal masses, 2 zeta w, w^2.
/// let system = LinearSystem::new(dvector![1.0, 1.0], dvector![0.02, 0.06], dvector![1.0, 9.0])?;
/// assert_eq!(system.n_dof(), 2);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct LinearSystem {
    mass: Coefficient,
    damping: Coefficient,
    stiffness: Coefficient,
    load: DVector<f64>,
    influence: Option<DVector<f64>>,
    factor: MassFactor,
    /// What follows from mass, damping and stiffness: the modal form.
    derived: Derived,
}

impl PartialEq for LinearSystem {
    fn eq(&self, other: &Self) -> bool {
        self.mass == other.mass
            && self.damping == other.damping
            && self.stiffness == other.stiffness
            && self.load == other.load
            && self.influence == other.influence
    }
}

impl LinearSystem {
    /// A linear system without load or influence vector.
    ///
    /// # Errors
    /// `Error::BadShape` or `Error::BadValue` for matrices that do not fit together, numbers that are not finite, or a
    /// mass that is not symmetric positive definite.
    pub fn new(
        mass: impl Into<Coefficient>,
        damping: impl Into<Coefficient>,
        stiffness: impl Into<Coefficient>,
    ) -> Result<Self> {
        let (mass, damping, stiffness) = (mass.into(), damping.into(), stiffness.into());
        let n = mass.order();
        if n == 0 {
            return Err(Error::bad_shape(
                "mass",
                "(0,)",
                "at least one degree of freedom",
            ));
        }
        mass.check("mass", n)?;
        damping.check("damping", n)?;
        stiffness.check("stiffness", n)?;
        let factor = factorise(&mass)?;
        Ok(Self {
            mass,
            damping,
            stiffness,
            load: DVector::zeros(n),
            influence: None,
            factor,
            derived: Derived::default(),
        })
    }

    /// A linear system without damping.
    ///
    /// # Errors
    /// As [`LinearSystem::new`].
    pub fn undamped(
        mass: impl Into<Coefficient>,
        stiffness: impl Into<Coefficient>,
    ) -> Result<Self> {
        let mass = mass.into();
        let n = mass.order();
        let damping: Coefficient = match &mass {
            Coefficient::Diagonal(_) => DVector::zeros(n).into(),
            Coefficient::Dense(_) => DMatrix::zeros(n, n).into(),
        };
        Self::new(mass, damping, stiffness)
    }

    /// A linear system in the coordinates of its modes: unit modal masses, damping `2 zeta w`, stiffness `w^2`. Frequencies w \[rad/s\]
    /// and damping ratios zeta \[-\] have shape `(m,)`; a frequency of zero is a rigid-body mode. Of mode shapes of shape `(n, m)` that are
    /// normalised to unit modal mass, row i is the direction of coordinate i: the normal of a stop there.
    ///
    /// # Errors
    /// `Error::BadShape` for no frequency, or ratios of another length; `Error::BadValue` for numbers that are negative or not finite, or
    /// whose `w^2` is not.
    ///
    /// # Examples
    /// ```
    /// use nalgebra::dvector;
    /// use vibroimpact::LinearSystem;
    ///
    /// let system = LinearSystem::from_modes(&dvector![1.0, 3.0], &dvector![0.01, 0.02])?;
    /// assert_eq!(system, LinearSystem::new(dvector![1.0, 1.0], dvector![0.02, 0.12], dvector![1.0, 9.0])?);
    /// # Ok::<(), vibroimpact::Error>(())
    /// ```
    pub fn from_modes(frequencies: &DVector<f64>, damping_ratios: &DVector<f64>) -> Result<Self> {
        let m = frequencies.len();
        if m == 0 {
            let needed = "(m,) with at least one mode";
            return Err(Error::bad_shape("frequencies", "(0,)", needed));
        }
        not_negative("frequencies", frequencies, m)?;
        not_negative("damping_ratios", damping_ratios, m)?;
        let stiffness = frequencies.component_mul(frequencies);
        let damping = frequencies.component_mul(damping_ratios) * 2.0;
        for i in 0..m {
            if !stiffness[i].is_finite() || !damping[i].is_finite() {
                let argument = format!("frequencies[{i}]");
                let rule = "its square, and its product with the damping ratio, must be finite";
                return Err(Error::bad_value(argument, frequencies[i], rule));
            }
        }
        Self::new(DVector::from_element(m, 1.0), damping, stiffness)
    }

    /// The same system with a constant force, shape `(n,)`.
    ///
    /// # Errors
    /// A load of the wrong length or not finite.
    pub fn with_load(mut self, load: DVector<f64>) -> Result<Self> {
        finite_vector("load", &load, self.n_dof())?;
        self.load = load;
        Ok(self)
    }

    /// The same system with an influence vector r, shape `(n,)`: a base displacement u adds the force `-M r u''`.
    ///
    /// # Errors
    /// A vector of the wrong length or not finite.
    pub fn with_influence(mut self, influence: DVector<f64>) -> Result<Self> {
        finite_vector("influence", &influence, self.n_dof())?;
        self.influence = Some(influence);
        Ok(self)
    }

    /// The same system with its damping multiplied by a number.
    ///
    /// # Errors
    /// A factor that is not finite, or with which the damping is not.
    pub fn with_damping_scaled(mut self, factor: f64) -> Result<Self> {
        crate::quantity::finite("damping_scale", factor)?;
        self.damping = self.damping.scaled(factor);
        self.derived = Derived::default();
        if self.damping.check("damping", self.n_dof()).is_ok() {
            return Ok(self);
        }
        let rule = "the damping times it must be finite";
        Err(Error::bad_value("damping_scale", factor, rule))
    }

    /// Number of degrees of freedom.
    pub fn n_dof(&self) -> usize {
        self.load.len()
    }

    /// The mass matrix M.
    pub fn mass(&self) -> &Coefficient {
        &self.mass
    }

    /// The damping matrix C.
    pub fn damping(&self) -> &Coefficient {
        &self.damping
    }

    /// The stiffness matrix K.
    pub fn stiffness(&self) -> &Coefficient {
        &self.stiffness
    }

    /// The constant force f0, shape `(n,)`.
    pub fn load(&self) -> &DVector<f64> {
        &self.load
    }

    /// The influence vector r, shape `(n,)`.
    pub fn influence(&self) -> Option<&DVector<f64>> {
        self.influence.as_ref()
    }

    /// The place of what is made of mass, damping and stiffness once.
    pub(crate) fn derived(&self) -> &Derived {
        &self.derived
    }

    /// `M^-1 b`.
    pub fn solve_mass(&self, b: &DVector<f64>) -> DVector<f64> {
        let mut x = b.clone();
        self.solve_mass_mut(x.as_mut_slice());
        x
    }

    /// `M^-1 b` in the place of b.
    pub(crate) fn solve_mass_mut(&self, b: &mut [f64]) {
        match &self.factor {
            MassFactor::Diagonal(d) => b.iter_mut().zip(d.iter()).for_each(|(b, d)| *b /= d),
            MassFactor::Cholesky(c) => {
                let n = b.len();
                c.solve_mut(&mut DVectorViewMut::from_slice(b, n));
            }
        }
    }

    /// `M^-1 b` for a complex vector.
    pub fn solve_mass_complex(&self, b: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
        let (re, im) = (
            self.solve_mass(&b.map(|z| z.re)),
            self.solve_mass(&b.map(|z| z.im)),
        );
        re.zip_map(&im, Complex::new)
    }

    /// The diagonals of M, C, K if all three are diagonal: the coordinates are the modes then.
    pub(crate) fn diagonals(&self) -> Option<(DVector<f64>, DVector<f64>, DVector<f64>)> {
        Some((
            self.mass.diagonal()?,
            self.damping.diagonal()?,
            self.stiffness.diagonal()?,
        ))
    }

    /// The Cholesky factor of a dense mass matrix.
    pub(crate) fn mass_cholesky(&self) -> Cholesky<f64, Dyn> {
        match &self.factor {
            MassFactor::Cholesky(c) => c.clone(),
            MassFactor::Diagonal(d) => Cholesky::new(DMatrix::from_diagonal(d))
                .expect("the mass was checked to be positive definite"),
        }
    }

    /// The acceleration `M^-1 (f0 + force - C v - K q)`.
    pub fn acceleration(
        &self,
        q: &DVector<f64>,
        v: &DVector<f64>,
        force: &DVector<f64>,
    ) -> DVector<f64> {
        self.solve_mass(&(&self.load + force - self.damping.times(v) - self.stiffness.times(q)))
    }
}

/// Numbers of a mode, none of them negative.
fn not_negative(argument: &str, values: &DVector<f64>, m: usize) -> Result<()> {
    finite_vector(argument, values, m)?;
    match values.iter().position(|&x| x < 0.0) {
        None => Ok(()),
        Some(i) => {
            let argument = format!("{argument}[{i}]");
            let rule = "it must not be below zero: a mode that grows is given to LinearSystem by its stiffness and damping";
            Err(Error::bad_value(argument, values[i], rule))
        }
    }
}

fn factorise(mass: &Coefficient) -> Result<MassFactor> {
    const RULE: &str = "the mass must be symmetric positive definite";
    match mass {
        Coefficient::Diagonal(d) => match d.iter().position(|&m| m <= 0.0) {
            Some(i) => Err(Error::bad_value(format!("mass[{i}]"), d[i], RULE)),
            None => Ok(MassFactor::Diagonal(d.clone())),
        },
        Coefficient::Dense(m) => {
            if !mass.is_symmetric() {
                return Err(Error::bad_value("mass", "not symmetric", RULE));
            }
            // nalgebra's factorisation reads one triangle and accepts a pivot of rounding size.
            let factor = Cholesky::new((m + m.transpose()) * 0.5)
                .filter(|c| {
                    let pivots = c.l_dirty().diagonal();
                    let smallest = (0..m.nrows())
                        .map(|i| pivots[i] * pivots[i] / m[(i, i)])
                        .fold(1.0, f64::min);
                    smallest > f64::EPSILON * m.nrows() as f64
                })
                .ok_or_else(|| Error::bad_value("mass", "not positive definite", RULE))?;
            Ok(MassFactor::Cholesky(factor))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    #[test]
    fn bad_masses_are_refused_by_name() {
        let zero = || DMatrix::<f64>::zeros(2, 2);
        for mass in [
            dmatrix![1.0, 2.0; 2.0, 1.0],
            dmatrix![1.0, 0.1; 0.2, 1.0],
            dmatrix![1.0, 1.0; 1.0, 1.0],
            zero(),
        ] {
            let message = LinearSystem::new(mass, zero(), zero())
                .unwrap_err()
                .to_string();
            assert!(message.starts_with("mass"), "{message}");
        }
        assert!(
            LinearSystem::new(dvector![1.0, 0.0], dvector![0.0, 0.0], dvector![0.0, 0.0]).is_err()
        );
        assert!(LinearSystem::new(dvector![1.0, 1.0], dvector![0.0], dvector![0.0, 0.0]).is_err());
        assert!(LinearSystem::new(dvector![1.0], dvector![f64::NAN], dvector![0.0]).is_err());
    }

    #[test]
    fn modes_make_a_diagonal_system() {
        let (w, zeta) = (dvector![0.0, 2.0, 5.0], dvector![0.5, 0.01, 0.02]);
        let system = LinearSystem::from_modes(&w, &zeta).expect("valid");
        assert_eq!(system.mass(), &dvector![1.0, 1.0, 1.0].into());
        assert_eq!(system.damping(), &dvector![0.0, 0.04, 0.2].into());
        assert_eq!(system.stiffness(), &dvector![0.0, 4.0, 25.0].into());
    }

    #[test]
    fn bad_modes_are_refused_by_name() {
        let message = |w: DVector<f64>, zeta: DVector<f64>| {
            let refused = LinearSystem::from_modes(&w, &zeta).unwrap_err();
            refused.to_string()
        };
        let none = DVector::zeros(0);
        assert!(message(none.clone(), none).starts_with("frequencies has shape (0,)"));
        assert!(
            message(dvector![1.0, -2.0], dvector![0.0, 0.0]).starts_with("frequencies[1] is -2")
        );
        assert!(message(dvector![f64::NAN], dvector![0.0]).starts_with("frequencies[0] is NaN"));
        assert!(message(dvector![1e200], dvector![0.0]).starts_with("frequencies[0] is 1e200"));
        assert!(message(dvector![1.0], dvector![-0.1]).starts_with("damping_ratios[0] is -0.1"));
        assert!(message(dvector![1.0, 2.0], dvector![0.1]).starts_with("damping_ratios has shape"));
    }

    #[test]
    fn a_system_without_damping_has_zeros_of_the_form_of_its_mass() {
        let dense = dmatrix![2.0, 0.0; 0.0, 1.0];
        let system = LinearSystem::undamped(dense.clone(), dense.clone()).expect("valid");
        let zeros = DMatrix::<f64>::zeros(2, 2);
        let same = LinearSystem::new(dense.clone(), zeros, dense.clone());
        assert_eq!(system, same.expect("valid"));
        let system = LinearSystem::undamped(dvector![2.0, 1.0], dense).expect("valid");
        assert_eq!(system.damping(), &dvector![0.0, 0.0].into());
    }

    #[test]
    fn diagonal_and_dense_forms_agree() {
        let (m, c, k) = (dvector![2.0, 3.0], dvector![0.1, 0.2], dvector![5.0, 7.0]);
        let diagonal = LinearSystem::new(m.clone(), c.clone(), k.clone()).expect("valid");
        let dense = |d: &DVector<f64>| DMatrix::from_diagonal(d);
        let full = LinearSystem::new(dense(&m), dense(&c), dense(&k)).expect("valid");
        let (q, v, f) = (dvector![0.3, -0.1], dvector![1.0, 2.0], dvector![0.5, 0.25]);
        assert!((diagonal.acceleration(&q, &v, &f) - full.acceleration(&q, &v, &f)).amax() < 1e-15);
    }
}
