//! The smaller system that stops held leave of a linear one (theory 9), and its modal form: accelerations of the whole system as those of the
//! smaller one, entries of rounding cleared.

use crate::error::{Error, Result};
use crate::flow::many_drive::{ManyDrive, SignalInput};
use crate::linalg::rank;
use crate::modal::{ModalForm, Pair, Response, pairs};
use crate::model::LinearSystem;
use crate::tolerance::{CANCELLED, DEPENDENT, ORTHOGONAL_TOL};
use nalgebra::allocator::Allocator;
use nalgebra::{Complex, DMatrix, DVector, DefaultAllocator, Dim, Dyn, OMatrix};

/// The row of a quantity `q.y + v.y'` on modal pairs; entries of rounding are zero.
pub(super) fn in_modes(form: &ModalForm, q: &DVector<f64>, v: &DVector<f64>) -> Vec<Pair> {
    let both = DVector::from_iterator(q.len() + v.len(), q.iter().chain(v.iter()).copied());
    let to_physical = form.transformation().0;
    let sizes = to_physical.abs().tr_mul(&both.abs());
    pairs(&without_rounding(&to_physical.tr_mul(&both), &sizes))
}

/// The rate of change of each pair under an acceleration; entries of rounding are zero, so that under a force along one mode the others
/// stay at rest.
pub(super) fn form_load(form: &ModalForm, acceleration: &DVector<f64>) -> Vec<Pair> {
    let n = acceleration.len();
    let to_modal = form.transformation().1.columns(n, n).into_owned();
    let sizes = to_modal.abs() * acceleration.abs();
    pairs(&without_rounding(&(to_modal * acceleration), &sizes))
}

/// The drive of the smaller system by accelerations of the whole one: harmonic ones, and those that follow signals.
pub(super) fn form_drive(
    form: &ModalForm,
    reduced: &Reduced,
    given: ManyDrive,
    (turning, following): (&[DVector<Complex<f64>>], &[DVector<f64>]),
) -> ManyDrive {
    let forces = turning.iter();
    let signals = given.signals.into_iter().zip(following);
    let signals = signals.map(|(own, direction)| SignalInput {
        directions: form_load(form, &reduced.apply(direction)),
        ..own
    });
    ManyDrive {
        forces: forces
            .map(|a| form_force(form, &reduced.apply_complex(a)))
            .collect(),
        signals: signals.collect(),
        rotations: given.rotations,
    }
}

pub(super) fn form_force(form: &ModalForm, acceleration: &DVector<Complex<f64>>) -> Vec<Response> {
    let (re, im) = (
        form_load(form, &acceleration.map(|z| z.re)),
        form_load(form, &acceleration.map(|z| z.im)),
    );
    re.iter()
        .zip(&im)
        .map(|(a, b)| [0, 1].map(|c| Complex::new(a[c], b[c])))
        .collect()
}

/// A matrix whose off-diagonal entries of rounding are set to zero: else the force of one stop would depend on that of another.
pub(super) fn uncoupled(mut matrix: DMatrix<f64>) -> DMatrix<f64> {
    let own = matrix.diagonal().map(|x| x.abs().sqrt());
    for i in 0..own.len() {
        for j in (0..own.len()).filter(|&j| j != i) {
            matrix[(i, j)] = cleared(matrix[(i, j)], own[i] * own[j]);
        }
    }
    matrix
}

/// Sums of terms of the given sizes; what is left of terms that cancel is nothing: a force of rounding would drive what rests, and a
/// stiffness of rounding hold what is free.
pub(super) fn without_rounding<C: Dim>(
    sums: &OMatrix<f64, Dyn, C>,
    sizes: &OMatrix<f64, Dyn, C>,
) -> OMatrix<f64, Dyn, C>
where
    DefaultAllocator: Allocator<Dyn, C>,
{
    sums.zip_map(sizes, cleared)
}

/// A sum of terms of a size; nothing, where that is what is left of terms that cancel.
pub(super) fn cleared(sum: f64, size: f64) -> f64 {
    if sum.abs() > CANCELLED * size {
        sum
    } else {
        0.0
    }
}

/// The map from accelerations of the whole system to those of the smaller one: `(Y^T Z)^-1 Y^T`, `B^T Y = 0`.
pub(super) struct Reduced {
    /// `(Y^T Z)^-1 Y^T`, shape `(m, n)`, \[-\].
    pub takes: DMatrix<f64>,
    /// `Z^T M Z` where the reactions are those of inertia: the smaller system is symmetric then.
    mass: Option<DMatrix<f64>>,
}

impl Reduced {
    pub fn new(
        system: &LinearSystem,
        free: &DMatrix<f64>,
        reactions: &DMatrix<f64>,
    ) -> Result<Self> {
        let m = free.ncols();
        if reactions.ncols() == 0 {
            let mass = system.mass().to_dense();
            return Ok(Self {
                takes: DMatrix::identity(m, m),
                mass: Some(mass),
            });
        }
        if m == 0 {
            return Ok(Self {
                takes: DMatrix::zeros(0, free.nrows()),
                mass: None,
            });
        }
        let inertia: Vec<_> = free
            .column_iter()
            .map(|z| system.mass().times(&z.into_owned()))
            .collect();
        let inertia = DMatrix::from_columns(&inertia);
        let work = reactions.tr_mul(&inertia).amax();
        let is_inertial = work <= ORTHOGONAL_TOL * reactions.amax() * inertia.amax();
        let across = if is_inertial {
            inertia
        } else {
            let k = reactions.ncols();
            let tolerance = DEPENDENT * reactions.amax();
            rank::solve(&reactions.transpose(), &DVector::zeros(k), tolerance)?.null_space
        };
        let product = across.tr_mul(free);
        if !product.is_square() {
            return Err(Error::bad_value(
                "stops",
                "stops held whose reactions depend on each other",
                "where their normals do not, no forces keep them closed",
            ));
        }
        let takes = product
            .clone()
            .lu()
            .solve(&across.transpose())
            .unwrap_or_else(|| DMatrix::zeros(m, free.nrows()));
        Ok(Self {
            takes,
            mass: is_inertial.then_some(product),
        })
    }

    pub fn apply(&self, acceleration: &DVector<f64>) -> DVector<f64> {
        let sizes = self.takes.abs() * acceleration.abs();
        without_rounding(&(&self.takes * acceleration), &sizes)
    }

    pub fn apply_complex(&self, acceleration: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
        let (re, im) = (
            self.apply(&acceleration.map(|z| z.re)),
            self.apply(&acceleration.map(|z| z.im)),
        );
        re.zip_map(&im, Complex::new)
    }

    /// The modal form of the smaller system; `stiffness` and `damping` are over the mass.
    pub fn form(
        &self,
        stiffness: &DMatrix<f64>,
        damping: &DMatrix<f64>,
        free: &DMatrix<f64>,
    ) -> Result<ModalForm> {
        if free.ncols() == 0 {
            return Ok(ModalForm::empty());
        }
        let taken = |m: &DMatrix<f64>| {
            let sizes = self.takes.abs() * m.abs() * free.abs();
            without_rounding(&(&self.takes * m * free), &sizes)
        };
        let (k, c) = (taken(stiffness), taken(damping));
        let symmetric = |m: DMatrix<f64>| (&m + m.transpose()) * 0.5;
        let system = match &self.mass {
            Some(mass) => {
                let mass = symmetric(mass.clone());
                LinearSystem::new(mass.clone(), &mass * c, &mass * k)?
            }
            None => LinearSystem::new(DMatrix::identity(k.nrows(), k.nrows()), c, k)?,
        };
        ModalForm::new(&system)
    }
}
