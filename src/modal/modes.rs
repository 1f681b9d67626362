//! The modes of a linear system as a user sees them: frequencies, shapes, damping ratios, eigenvalues.

use crate::error::Result;
use crate::linalg::{eigen, graded};
use crate::modal::block::{Block, Response};
use crate::modal::complex::{scaled_state_matrix, state_matrix};
use crate::modal::real::{RealModes, Shapes};
use crate::model::LinearSystem;
use crate::quantity::room_for;
use crate::tolerance::MODULUS_PARTS;
use nalgebra::{Complex, DMatrix, DVector};

/// Modes of a linear system, ascending in frequency, shapes mass-normalised with their largest entry positive.
#[derive(Debug, Clone)]
pub struct Modes {
    /// Natural frequencies of the undamped system \[rad/s\], shape `(n,)`; nan where the equilibrium is unstable. Where
    /// the stiffness is not symmetric: the moduli of the eigenvalues.
    pub natural_frequencies: DVector<f64>,
    /// Mode shapes in the columns, shape `(n, n)`, \[1/sqrt(kg)\], mass-normalised; complex where the stiffness is not symmetric.
    pub shapes: DMatrix<Complex<f64>>,
    /// Damping ratios [-], shape `(n,)`, in the order of the frequencies.
    pub damping_ratios: DVector<f64>,
    /// Eigenvalues of the damped system \[1/s\], shape `(2n,)`.
    pub eigenvalues: DVector<Complex<f64>>,
    /// Whether the damping is proportional: the real shapes uncouple the damped motion too.
    pub is_proportional: bool,
}

/// Frequencies, damping ratios and eigenvalues of a linear system: its modes, but for the shapes, which take n^2 numbers and are
/// made when asked for.
#[derive(Debug, Clone)]
pub struct Spectrum {
    /// Natural frequencies \[rad/s\], shape `(n,)`, as [`Modes::natural_frequencies`].
    pub natural_frequencies: DVector<f64>,
    /// Damping ratios [-], shape `(n,)`, as [`Modes::damping_ratios`].
    pub damping_ratios: DVector<f64>,
    /// Eigenvalues \[1/s\], shape `(2n,)`, as [`Modes::eigenvalues`].
    pub eigenvalues: DVector<Complex<f64>>,
    /// As [`Modes::is_proportional`].
    pub is_proportional: bool,
    shapes: Columns,
}

impl Modes {
    /// Those of a spectrum.
    pub(super) fn of(spectrum: Spectrum) -> Result<Self> {
        Ok(Self {
            shapes: spectrum.shapes()?,
            natural_frequencies: spectrum.natural_frequencies,
            damping_ratios: spectrum.damping_ratios,
            eigenvalues: spectrum.eigenvalues,
            is_proportional: spectrum.is_proportional,
        })
    }
}

/// The shapes of modes as they were found.
#[derive(Debug, Clone)]
enum Columns {
    Real(Shapes),
    Complex(DMatrix<Complex<f64>>),
}

impl Spectrum {
    /// The same of a motion along some directions, the columns of a matrix of shape `(n, m)`, \[-\].
    pub(super) fn lifted(mut self, directions: &DMatrix<f64>) -> Self {
        let shapes = match self.shapes {
            Columns::Real(shapes) => shapes.to_dense().map(Complex::from),
            Columns::Complex(shapes) => shapes,
        };
        self.shapes = Columns::Complex(directions.map(Complex::from) * shapes);
        self
    }

    /// The shapes, as [`Modes::shapes`].
    ///
    /// # Errors
    /// `Error::OutOfMemory` where the memory has no room for them.
    pub fn shapes(&self) -> Result<DMatrix<Complex<f64>>> {
        let n = self.natural_frequencies.len();
        room_for(&format!("the shapes of {n} modes"), 2 * n, n)?;
        match &self.shapes {
            Columns::Complex(shapes) => Ok(shapes.clone()),
            Columns::Real(_) => Ok(self.real_shapes()?.unwrap_or_default().map(Complex::from)),
        }
    }

    /// The shapes where they are real.
    ///
    /// # Errors
    /// As [`shapes`](Self::shapes).
    pub fn real_shapes(&self) -> Result<Option<DMatrix<f64>>> {
        let n = self.natural_frequencies.len();
        room_for(&format!("the shapes of {n} modes"), n, n)?;
        Ok(match &self.shapes {
            Columns::Real(shapes) => Some(shapes.to_dense()),
            Columns::Complex(shapes) if shapes.iter().all(|z| z.im == 0.0) => {
                Some(shapes.map(|z| z.re))
            }
            Columns::Complex(_) => None,
        })
    }
}

/// The modes of a linear system (eqs. (10), (11) for the paper's, in ascending order).
///
/// # Errors
/// `Error::NoConvergence` if an eigenvalue iteration fails, `Error::OutOfMemory` for more modes than their shapes have room for:
/// their [`spectrum`] has.
///
/// # Examples
/// ```
/// let system = vibroimpact::paper_system(3.0, 3.24, 0.05)?;
/// let modes = vibroimpact::modes(&system)?;
/// // eq. (10): w^2 = (1 + mu -+ sqrt((1 + mu)^2 - 4 mu (1 - xi)))/2, and zeta_j = zeta w_j
/// let root = (4.24f64 * 4.24 - 4.0 * 3.24 * 0.25).sqrt();
/// assert!((modes.natural_frequencies[0] - ((4.24 - root) / 2.0).sqrt()).abs() < 1e-14);
/// assert!((modes.damping_ratios[1] - 0.05 * modes.natural_frequencies[1]).abs() < 1e-15);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn modes(system: &LinearSystem) -> Result<Modes> {
    Modes::of(spectrum(system)?)
}

/// The modes of a linear system without their shapes: of a diagonal one in O(n) memory.
///
/// # Errors
/// `Error::NoConvergence` if an eigenvalue iteration fails.
pub fn spectrum(system: &LinearSystem) -> Result<Spectrum> {
    match RealModes::new(system)? {
        Some(real) if real.is_proportional => Ok(proportional(real)),
        real => general(system, real),
    }
}

fn proportional(real: RealModes) -> Spectrum {
    let blocks = real
        .w2
        .iter()
        .zip(real.eta.iter())
        .map(|(&w2, &eta)| Block::Oscillator { w2, eta });
    let roots: Vec<Response> = blocks.map(Block::roots).collect();
    Spectrum {
        natural_frequencies: real.w2.map(f64::sqrt),
        shapes: Columns::Real(real.shapes),
        damping_ratios: real.w2.zip_map(
            &real.eta,
            |w2, eta| if eta == 0.0 { 0.0 } else { eta / w2.sqrt() },
        ),
        eigenvalues: DVector::from_iterator(2 * roots.len(), roots.into_iter().flatten()),
        is_proportional: true,
    }
}

fn general(system: &LinearSystem, real: Option<RealModes>) -> Result<Spectrum> {
    let n = system.n_dof();
    let (scaled, _) = scaled_state_matrix(system)?;
    // In units of its own rate where rounding relative to the largest entry would take digits.
    let is_graded = graded::order(&system.mass().to_dense(), &system.stiffness().to_dense());
    let (roots, vectors) = eigen::eigenvectors(&if is_graded.is_some() {
        scaled
    } else {
        state_matrix(system)
    })?;
    let mut order: Vec<usize> = (0..2 * n).collect();
    // By modulus; of a pair, the positive imaginary part first.
    order.sort_by(|&i, &j| {
        let key = |k: usize| (roots[k].norm() * MODULUS_PARTS / roots.camax()).round();
        key(i)
            .total_cmp(&key(j))
            .then(roots[j].im.total_cmp(&roots[i].im))
    });
    let eigenvalues = DVector::from_fn(2 * n, |i, _| roots[order[i]]);
    let pairs: Vec<usize> = pair_up(&eigenvalues);
    let modulus = |i: usize| (eigenvalues[i].norm() * eigenvalues[pairs[i]].norm()).sqrt();
    let leaders: Vec<usize> = (0..2 * n).filter(|&i| i < pairs[i]).collect();
    let damping_ratios = DVector::from_iterator(
        n,
        leaders.iter().map(|&i| {
            let mean = -0.5 * (eigenvalues[i] + eigenvalues[pairs[i]]).re;
            if mean == 0.0 { 0.0 } else { mean / modulus(i) }
        }),
    );
    let (natural_frequencies, shapes) = match real {
        Some(real) => (real.w2.map(f64::sqrt), Columns::Real(real.shapes)),
        None => (
            DVector::from_iterator(n, leaders.iter().map(|&i| modulus(i))),
            Columns::Complex(mass_normalised(
                system,
                &DMatrix::from_fn(n, n, |i, j| vectors[(i, order[leaders[j]])]),
            )),
        ),
    };
    Ok(Spectrum {
        natural_frequencies,
        shapes,
        damping_ratios,
        eigenvalues,
        is_proportional: false,
    })
}

/// The partner of each root: its conjugate, or for a real root the next real one.
fn pair_up(roots: &DVector<Complex<f64>>) -> Vec<usize> {
    let mut partner = vec![usize::MAX; roots.len()];
    for i in 0..roots.len() {
        if partner[i] == usize::MAX {
            let distance = |j: usize| (roots[j] - roots[i].conj()).norm();
            let free = (i + 1..roots.len()).filter(|&j| partner[j] == usize::MAX);
            if let Some(j) = free.min_by(|&a, &b| distance(a).total_cmp(&distance(b))) {
                partner[i] = j;
                partner[j] = i;
            }
        }
    }
    partner
}

/// Columns scaled to `phi^* M phi = 1`, turned so that the largest entry of each is real and positive.
fn mass_normalised(system: &LinearSystem, shapes: &DMatrix<Complex<f64>>) -> DMatrix<Complex<f64>> {
    let mut shapes = shapes.clone();
    for mut column in shapes.column_iter_mut() {
        let largest = column[column.icamax()];
        let turned = column.map(|z| z * largest.conj() / largest.norm());
        let (re, im) = (turned.map(|z| z.re), turned.map(|z| z.im));
        let norm = (re.dot(&system.mass().times(&re)) + im.dot(&system.mass().times(&im))).sqrt();
        column.copy_from(&(turned / Complex::from(norm)));
    }
    shapes
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{dmatrix, dvector};

    #[test]
    fn overdamped_and_rigid_modes_are_described() {
        let system = LinearSystem::new(dvector![1.0, 1.0], dvector![0.5, 8.0], dvector![0.0, 4.0])
            .expect("valid");
        let modes = modes(&system).expect("diagonal");
        assert_eq!(modes.natural_frequencies, dvector![0.0, 2.0]);
        assert!(
            modes.damping_ratios[0].is_infinite() && (modes.damping_ratios[1] - 2.0).abs() < 1e-15
        );
        assert_eq!(modes.eigenvalues[0], Complex::new(0.0, 0.0));
        assert_eq!(modes.eigenvalues[1], Complex::new(-0.5, 0.0));
    }

    #[test]
    fn a_gyroscopic_system_has_conjugate_pairs() {
        let identity = DMatrix::<f64>::identity(2, 2);
        let system = LinearSystem::new(identity.clone(), dmatrix![0.0, 2.0; -2.0, 0.0], identity)
            .expect("valid");
        let modes = modes(&system).expect("converges");
        assert!(!modes.is_proportional);
        // w^4 - 6 w^2 + 1 = 0: w = sqrt(2) -+ 1
        let expected = [2f64.sqrt() - 1.0, 2f64.sqrt() + 1.0];
        for (j, w) in expected.into_iter().enumerate() {
            assert!((modes.eigenvalues[2 * j] - Complex::new(0.0, w)).norm() < 1e-13);
        }
        assert!(modes.damping_ratios.amax() < 1e-13);
    }
}
