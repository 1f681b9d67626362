//! Nonlinear systems given by their equations of motion `q'' = a(t, q, v)`: any type that implements one trait.

use crate::error::{Error, Result};
use crate::model::difference::derivative;
use crate::model::linear::{Coefficient, LinearSystem};
use crate::quantity::{at_least_one, finite_square, room_for};
use crate::tolerance::{
    EQUILIBRIUM_TIMES, EQUILIBRIUM_TOL, ERROR_FACTOR, ONE_SIDED_STEP, ROUGH_JACOBIAN,
    SHORT_ONE_SIDED_STEP, WRONG_JACOBIAN,
};
use nalgebra::{Cholesky, DMatrix, DVector};
use std::any::Any;
use std::fmt;
use std::sync::Arc;

/// Numbers that a step of an integrator takes for each coordinate, roughly: its stages and dense output. [work]
const NUMBERS_OF_A_STEP: usize = 32;

/// Equations of motion `q'' = a(t, q, v)`, and what may be known beside them. The functions must be pure: the same
/// arguments give the same values.
///
/// An implementation reports a failure of its own by [`Error::function`]; values that are not finite are reported for it.
pub trait EquationsOfMotion: Any + Send + Sync {
    /// Number of degrees of freedom, at least 1.
    fn n_dof(&self) -> usize;

    /// Writes the acceleration at time t, position q and velocity v.
    ///
    /// # Errors
    /// Whatever the implementation cannot evaluate.
    fn acceleration(&self, t: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()>;

    /// Whether [`mass`](Self::mass) is there.
    fn has_mass(&self) -> bool {
        false
    }

    /// The mass matrix at q, shape `(n, n)`, symmetric positive definite: needed for the inertial reaction of stops, for
    /// harmonic forces and to linearise.
    ///
    /// # Errors
    /// Whatever the implementation cannot evaluate.
    fn mass(&self, q: &[f64]) -> Result<DMatrix<f64>> {
        let _ = q;
        Err(no_mass("this"))
    }

    /// The mass matrix where it is the same at every q: harmonic forces are divided by it once, not at every evaluation.
    fn constant_mass(&self) -> Option<DMatrix<f64>> {
        None
    }

    /// The derivative of the acceleration by `(q, v)`, shape `(n, 2n)`; `None`: it is had by differences.
    ///
    /// # Errors
    /// Whatever the implementation cannot evaluate.
    fn jacobian(&self, t: f64, q: &[f64], v: &[f64]) -> Result<Option<DMatrix<f64>>> {
        let _ = (t, q, v);
        Ok(None)
    }

    /// The potential energy at q; `None`: it is not known.
    ///
    /// # Errors
    /// Whatever the implementation cannot evaluate.
    fn potential(&self, q: &[f64]) -> Result<Option<f64>> {
        let _ = q;
        Ok(None)
    }

    /// Whether another object is known to be the same equations; one object is always equal to itself.
    fn equals(&self, other: &dyn EquationsOfMotion) -> bool {
        let _ = other;
        false
    }
}

/// Nonlinear system given by its equations of motion `q'' = a(t, q, v)`.
///
/// # Examples
/// A Duffing oscillator between two stops:
/// ```
/// use nalgebra::{DMatrix, dmatrix, dvector};
/// use vibroimpact::{EquationsOfMotion, Forcing, NonlinearSystem, Result, Scene, Side, SimulateOptions, Stop, simulate};
/// struct Duffing;
/// impl EquationsOfMotion for Duffing {
///     fn n_dof(&self) -> usize {
///         1
///     }
///     fn acceleration(&self, _t: f64, q: &[f64], _v: &[f64], a: &mut [f64]) -> Result<()> {
///         a[0] = -q[0] - q[0].powi(3);
///         Ok(())
///     }
///     fn has_mass(&self) -> bool {
///         true
///     }
///     fn mass(&self, _q: &[f64]) -> Result<DMatrix<f64>> {
///         Ok(dmatrix![1.0])
///     }
/// }
/// let stops = [Stop::new(0, 0.5, 1.0)?, Stop::new(0, 0.5, 1.0)?.on_side(Side::Lower)];
/// let scene = Scene::new(NonlinearSystem::new(Duffing)?, Forcing::Unforced, stops)?;
/// let run = simulate(&scene, &dvector![0.0], &dvector![1.0], (0.0, 20.0), &SimulateOptions::default())?;
/// // v^2 = 1 - q^2 - q^4/2 at the stops
/// assert!(run.impacts().iter().all(|i| (i.approach - (1.0 - 0.25 - 0.03125f64).sqrt()).abs() < 1e-7));
/// # Ok::<(), vibroimpact::Error>(())
/// ```
#[derive(Clone)]
pub struct NonlinearSystem {
    equations: Arc<dyn EquationsOfMotion>,
    /// What is added to the time that the equations are given.
    time_offset: f64,
}

impl fmt::Debug for NonlinearSystem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "NonlinearSystem(n_dof={})", self.n_dof())
    }
}

impl PartialEq for NonlinearSystem {
    /// One object is equal to itself; others as far as they know.
    fn eq(&self, other: &Self) -> bool {
        let (ours, theirs) = (&self.equations, &other.equations);
        self.time_offset == other.time_offset
            && (Arc::ptr_eq(ours, theirs) || ours.equals(&**theirs))
    }
}

impl NonlinearSystem {
    /// A system that moves by the given equations.
    ///
    /// # Errors
    /// No degree of freedom at all, or more than the memory holds.
    pub fn new(equations: impl EquationsOfMotion) -> Result<Self> {
        let n = equations.n_dof();
        at_least_one("n_dof", n)?;
        room_for("a step of the motion", n, NUMBERS_OF_A_STEP)?;
        Ok(Self {
            equations: Arc::new(equations),
            time_offset: 0.0,
        })
    }

    /// The same equations at a time that is later by `offset`: what they are at t, this system's are at `t - offset`. An orbit's
    /// scene, whose time begins at the first impact, has it where the equations depend on time by themselves.
    ///
    /// # Errors
    /// An offset that is not finite.
    pub fn with_time_offset(mut self, offset: f64) -> Result<Self> {
        self.time_offset = crate::quantity::finite("time_offset", offset)?;
        Ok(self)
    }

    /// What is added to the time that the equations are given.
    pub fn time_offset(&self) -> f64 {
        self.time_offset
    }

    /// The equations as they were given.
    pub fn equations(&self) -> &dyn EquationsOfMotion {
        &*self.equations
    }

    /// Number of degrees of freedom.
    pub fn n_dof(&self) -> usize {
        self.equations.n_dof()
    }

    /// Whether the mass matrix is known.
    pub fn has_mass(&self) -> bool {
        self.equations.has_mass()
    }

    /// Writes the acceleration.
    ///
    /// # Errors
    /// What the equations report; a value that is not finite.
    pub fn acceleration(&self, t: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        let t = t + self.time_offset;
        self.equations.acceleration(t, q, v, a)?;
        match a.iter().position(|x| !x.is_finite()) {
            None => Ok(()),
            Some(i) => Err(Error::bad_value(
                format!("acceleration[{i}] at t = {t}"),
                a[i],
                format!("it must be finite, as q = {q:?} and v = {v:?} are"),
            )),
        }
    }

    /// The mass matrix at q, shape `(n, n)`.
    ///
    /// # Errors
    /// What the equations report; a matrix of another shape, not finite or not symmetric.
    pub fn mass(&self, q: &[f64]) -> Result<DMatrix<f64>> {
        let mass = self.equations.mass(q)?;
        finite_square("mass", &mass, self.n_dof())?;
        let mass = Coefficient::Dense(mass);
        if !mass.is_symmetric() {
            let value = format!("not symmetric at q = {q:?}");
            return Err(Error::bad_value("mass", value, "it must be"));
        }
        Ok(mass.to_dense())
    }

    /// The mass matrix where it is the same at every q.
    pub(crate) fn constant_mass(&self) -> Option<DMatrix<f64>> {
        self.equations.constant_mass()
    }

    /// Checks that the mass matrix at q is symmetric and positive definite.
    ///
    /// # Errors
    /// As [`mass`](Self::mass); a matrix that is not positive definite.
    pub fn check_mass(&self, q: &[f64]) -> Result<()> {
        if Cholesky::new(self.mass(q)?).is_some() {
            return Ok(());
        }
        let value = format!("not positive definite at q = {q:?}");
        Err(Error::bad_value("mass", value, "it must be"))
    }

    /// The potential energy at q, `None` where it is not known.
    ///
    /// # Errors
    /// What the equations report; a value that is not finite.
    pub fn potential(&self, q: &[f64]) -> Result<Option<f64>> {
        self.equations
            .potential(q)?
            .map(|u| crate::quantity::finite("potential", u))
            .transpose()
    }

    /// The derivative of the acceleration by `(q, v)`, shape `(n, 2n)`: as given, or by differences (Ridders' method).
    ///
    /// # Errors
    /// What the equations report; a derivative of another shape or not finite; differences that settle on no value.
    pub fn jacobian(&self, t: f64, q: &[f64], v: &[f64]) -> Result<DMatrix<f64>> {
        if let Some(jacobian) = self.given_jacobian(t, q, v)? {
            return Ok(jacobian);
        }
        let columns: Vec<DVector<f64>> = (0..2 * self.n_dof())
            .map(|j| Ok(self.difference(t, q, v, j)?.0))
            .collect::<Result<_>>()?;
        Ok(DMatrix::from_columns(&columns))
    }

    /// The derivative of the acceleration by `(q, v)` as the equations give it, `None` where they do not.
    ///
    /// # Errors
    /// What the equations report; a derivative of another shape or not finite.
    pub(crate) fn given_jacobian(
        &self,
        t: f64,
        q: &[f64],
        v: &[f64],
    ) -> Result<Option<DMatrix<f64>>> {
        let n = self.n_dof();
        let Some(jacobian) = self.equations.jacobian(t + self.time_offset, q, v)? else {
            return Ok(None);
        };
        if jacobian.shape() != (n, 2 * n) {
            let found = format!("({}, {})", jacobian.nrows(), jacobian.ncols());
            let expected = format!("({n}, {}), by q and then by v,", 2 * n);
            return Err(Error::bad_shape("jacobian", found, expected));
        }
        match jacobian.iter().find(|x| !x.is_finite()) {
            None => Ok(Some(jacobian)),
            Some(x) => Err(Error::bad_value("jacobian", x, "it must be finite")),
        }
    }

    /// The acceleration where entry j of `(q, v)` is larger by h.
    fn beside(&self, t: f64, (q, v): (&[f64], &[f64]), j: usize, h: f64) -> Result<DVector<f64>> {
        let n = self.n_dof();
        let mut y: Vec<f64> = q.iter().chain(v).copied().collect();
        y[j] += h;
        let mut a = DVector::zeros(n);
        let t = t + self.time_offset;
        self.equations
            .acceleration(t, &y[..n], &y[n..], a.as_mut_slice())?;
        Ok(a)
    }

    /// The derivative of the acceleration by entry j of `(q, v)`, by differences, and by how much it may be off.
    fn difference(
        &self,
        t: f64,
        q: &[f64],
        v: &[f64],
        j: usize,
    ) -> Result<(DVector<f64>, DVector<f64>)> {
        derivative(|h| self.beside(t, (q, v), j, h))
    }

    /// The least and the largest of derivatives by entry j to either side: at a kink, such as the place at which a spring is touched, each of
    /// them is right, and all between.
    fn sides(&self, t: f64, x: (&[f64], &[f64]), j: usize) -> Result<[DVector<f64>; 2]> {
        let here = self.beside(t, x, j, 0.0)?;
        let mut bounds = [f64::INFINITY, f64::NEG_INFINITY].map(|x| here.map(|_| x));
        for h in [
            ONE_SIDED_STEP,
            -ONE_SIDED_STEP,
            SHORT_ONE_SIDED_STEP,
            -SHORT_ONE_SIDED_STEP,
        ] {
            let slope = (self.beside(t, x, j, h)? - &here) / h;
            let rounding = here.map(|a| ERROR_FACTOR * f64::EPSILON * a.abs() / h.abs());
            bounds[0] = bounds[0].inf(&(&slope - &rounding));
            bounds[1] = bounds[1].sup(&(&slope + &rounding));
        }
        Ok(bounds)
    }

    /// Compares the derivative that the equations give, if they do, with a difference at one place. Where differences settle on
    /// no value nothing is said, nor at a kink of a derivative that is between those to either side.
    ///
    /// # Errors
    /// What the equations report; an entry that is off by more than 1e-3 of its size and the rounding of a difference.
    pub fn check_jacobian(&self, t: f64, q: &[f64], v: &[f64]) -> Result<()> {
        let Some(given) = self.given_jacobian(t, q, v)? else {
            return Ok(());
        };
        for (j, column) in given.column_iter().enumerate() {
            let (found, errors) = match self.difference(t, q, v, j) {
                Err(Error::NoConvergence { .. }) => continue,
                found => found?,
            };
            let rounding = ROUGH_JACOBIAN * column.amax().max(found.amax());
            for (i, (&given, &found)) in column.iter().zip(found.iter()).enumerate() {
                let allowed = WRONG_JACOBIAN * given.abs().max(found.abs())
                    + rounding
                    + ERROR_FACTOR * errors[i];
                if (given - found).abs() > allowed {
                    let [least, most] = self.sides(t, (q, v), j)?;
                    if (least[i] - allowed..=most[i] + allowed).contains(&given) {
                        continue;
                    }
                    let rule = format!(
                        "a difference gives {found} at t = {t}, q = {q:?}, v = {v:?}: it must be the derivative of acceleration[{i}] \
                         by entry {j} of (q, v)"
                    );
                    return Err(Error::bad_value(format!("jacobian[{i}, {j}]"), given, rule));
                }
            }
        }
        Ok(())
    }

    /// The linear system about the equilibrium q = 0, `K = -M da/dq`, `C = -M da/dv`.
    ///
    /// # Errors
    /// No mass matrix; q = 0 is not at rest (within 1e-12 of the coordinates' units, at the times 0, 1 and sqrt 2); what
    /// [`jacobian`](Self::jacobian) reports.
    pub fn linearise(&self) -> Result<LinearSystem> {
        if !self.has_mass() {
            return Err(no_mass("linearise"));
        }
        let n = self.n_dof();
        let zero = vec![0.0; n];
        self.check_jacobian(0.0, &zero, &zero)?;
        let jacobian = self.jacobian(0.0, &zero, &zero)?;
        let small = EQUILIBRIUM_TOL * jacobian.columns(0, n).amax();
        for t in EQUILIBRIUM_TIMES {
            let mut a = vec![0.0; n];
            self.acceleration(t, &zero, &zero, &mut a)?;
            if a.iter().any(|a| a.abs() > small) {
                return Err(Error::bad_value(
                    format!("the acceleration at q = 0, v = 0, t = {t}"),
                    format!("{a:?}"),
                    "q = 0 must be an equilibrium at all times to be linearised about; count q from there, and give a \
                     harmonic force as forcing",
                ));
            }
        }
        let mass = self.mass(&zero)?;
        let stiffness = -(&mass * jacobian.columns(0, n));
        let damping = -(&mass * jacobian.columns(n, n));
        LinearSystem::new(mass, damping, stiffness)
    }
}

/// The mass matrix is needed and not there.
pub(crate) fn no_mass(what: &str) -> Error {
    Error::bad_value(
        "mass",
        "not given",
        format!("{what} needs the mass matrix of a nonlinear system"),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    /// `M q'' = -K q - C v - k q^3` on each coordinate, started at rest at `q = offset`.
    struct Hardening {
        offset: f64,
    }

    fn matrices() -> [DMatrix<f64>; 3] {
        [
            dmatrix![2.0, 0.5; 0.5, 1.0],
            dmatrix![0.3, -0.1; -0.1, 0.2],
            dmatrix![5.0, -2.0; -2.0, 3.0],
        ]
    }

    impl EquationsOfMotion for Hardening {
        fn n_dof(&self) -> usize {
            2
        }
        fn acceleration(&self, _t: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
            let [m, c, k] = matrices();
            let (q, v) = (
                DVector::from_column_slice(q).add_scalar(-self.offset),
                DVector::from_column_slice(v),
            );
            let f = -(k * &q) - c * v - q.map(|x| 7.0 * x.powi(3));
            let solved = m.lu().solve(&f).ok_or_else(|| no_mass("the test"))?;
            a.copy_from_slice(solved.as_slice());
            Ok(())
        }
        fn has_mass(&self) -> bool {
            true
        }
        fn mass(&self, _q: &[f64]) -> Result<DMatrix<f64>> {
            Ok(matrices()[0].clone())
        }
    }

    #[test]
    fn the_linear_part_is_found_by_differences() {
        let system = NonlinearSystem::new(Hardening { offset: 0.0 }).expect("two coordinates");
        let linear = system.linearise().expect("an equilibrium");
        let [m, c, k] = matrices();
        assert!((linear.mass().to_dense() - m).amax() < 1e-15);
        assert!((linear.damping().to_dense() - c).amax() < 1e-12);
        assert!((linear.stiffness().to_dense() - k).amax() < 1e-12);
    }

    #[test]
    fn a_point_that_is_not_at_rest_is_not_linearised_about() {
        let system = NonlinearSystem::new(Hardening { offset: 1e-6 }).expect("two coordinates");
        let message = system.linearise().unwrap_err().to_string();
        assert!(message.contains("must be an equilibrium"), "{message}");
    }

    #[test]
    fn equations_are_compared_by_identity() {
        let one = NonlinearSystem::new(Hardening { offset: 0.0 }).expect("valid");
        let other = NonlinearSystem::new(Hardening { offset: 0.0 }).expect("valid");
        assert_eq!(one, one.clone());
        assert_ne!(one, other);
        assert_eq!(format!("{one:?}"), "NonlinearSystem(n_dof=2)");
    }

    #[test]
    fn a_value_that_is_not_finite_is_named_with_its_time() {
        struct Broken;
        impl EquationsOfMotion for Broken {
            fn n_dof(&self) -> usize {
                1
            }
            fn acceleration(&self, _: f64, _: &[f64], _: &[f64], a: &mut [f64]) -> Result<()> {
                a[0] = f64::NAN;
                Ok(())
            }
        }
        let system = NonlinearSystem::new(Broken).expect("one coordinate");
        let q = dvector![0.5];
        let message = system
            .acceleration(0.25, q.as_slice(), q.as_slice(), &mut [0.0])
            .unwrap_err()
            .to_string();
        assert!(
            message.starts_with("acceleration[0] at t = 0.25 is NaN"),
            "{message}"
        );
        assert!(system.linearise().is_err() && system.mass(&[0.0]).is_err());
    }
}
