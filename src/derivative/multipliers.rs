//! How multipliers change: they are where `J_mu = J_0 + mu (J_1 - J_0)` is singular, the equations of a deviation that comes back mu times
//! as large (theory 19), so `dmu = -w (dJ_0 + mu (dJ_1 - dJ_0)) v / (w (J_1 - J_0) v)` with its null vectors w and v.

use crate::derivative::loop_rates::Loop;
use crate::error::{Result, digits};
use crate::hybrid::ScaledUnits;
use crate::orbit::{PeriodicOrbit, Shooting, ShootingState};
use crate::tolerance::{DEFECTIVE_MULTIPLIER, ISOLATED_MULTIPLIER};
use nalgebra::{Complex, DMatrix, DVector};

/// Inverse iterations towards a null vector, each of which takes away all but rounding. [work]
const INVERSE_ITERATIONS: usize = 3;

type ComplexMatrix = DMatrix<Complex<f64>>;

/// The matrices of `J_mu = J_0 + mu (J_1 - J_0)`: of deviations of which nothing comes back after a period, and what deviations that come back
struct Deviations {
    at_zero: DMatrix<f64>,
    closing: DMatrix<f64>,
}

impl Deviations {
    fn new(shooting: &Shooting<'_>, units: &ScaledUnits, state: &ShootingState) -> Result<Self> {
        let linear = shooting.linearised(state, units)?;
        Ok(Self {
            at_zero: linear.returning(0.0),
            closing: linear.closing,
        })
    }

    /// `J_mu`.
    fn at(&self, mu: Complex<f64>) -> ComplexMatrix {
        self.at_zero.map(Complex::from) + self.closing.map(Complex::from) * mu
    }
}

/// How the derivative of a multiplier is found.
enum Sensitivity {
    /// It stays what it is.
    Fixed,
    /// Null vectors and `w (J_1 - J_0) v`.
    Simple {
        mu: Complex<f64>,
        left: DVector<Complex<f64>>,
        right: DVector<Complex<f64>>,
        over: Complex<f64>,
    },
    /// It is one of several that are equal, or nearly so.
    Multiple,
}

/// The multipliers of an orbit, ready to be differentiated, why some have no derivative; by default none.
#[derive(Default)]
pub(super) struct Multipliers {
    each: Vec<Sensitivity>,
    reason: Option<String>,
}

impl Multipliers {
    /// Those of an orbit, given its loop; the shift in time of a motion without forcing, and those that lasting contact takes, stay.
    pub fn new(own: &Loop, orbit: &PeriodicOrbit) -> Result<Self> {
        let stability = orbit.stability()?;
        let Some(order) = stability.orders.first() else {
            return Ok(Self {
                each: Vec::new(),
                reason: Some(stability.reason.clone()),
            });
        };
        let all: Vec<Complex<f64>> = order.multipliers.iter().copied().collect();
        let deviations = own.in_scene(&own.scene, |shooting, units| {
            Deviations::new(shooting, units, &own.state)
        })?;
        let n_lost = own.signature.stages.n_lost_directions();
        let shift = own.scene.frequency().is_none().then(|| {
            let off = |i: &usize| (all[*i] - 1.0).norm();
            (0..all.len()).min_by(|i, j| off(i).total_cmp(&off(j)))
        });
        // The largest come first.
        let first_zero = all.len().saturating_sub(n_lost);
        let each = all.iter().enumerate().map(|(i, &mu)| {
            if i >= first_zero || shift == Some(Some(i)) {
                return Sensitivity::Fixed;
            }
            sensitivity(&deviations, mu, &all)
        });
        let each: Vec<Sensitivity> = each.collect();
        let multiple = |own: &Sensitivity| matches!(own, Sensitivity::Multiple);
        let reason = each.iter().position(multiple).map(|i| {
            let (mu, size) = (all[i], digits(all[i].norm()));
            let mu = if mu.im == 0.0 {
                digits(mu.re)
            } else {
                format!("of modulus {size}")
            };
            format!("the multiplier {mu} is one of several that meet")
        });
        Ok(Self { each, reason })
    }

    /// Why some have no derivative.
    pub fn reason(&self) -> Option<&str> {
        self.reason.as_deref()
    }

    /// How many numbers their derivatives are made of.
    pub fn n_measured(&self, own: &Loop) -> usize {
        let is_simple = |own: &Sensitivity| matches!(own, Sensitivity::Simple { .. });
        if self.each.iter().any(is_simple) {
            2 * own.shape.0 * own.shape.1
        } else {
            0
        }
    }

    /// These numbers at a loop beside.
    pub fn measured(
        (shooting, units): (&Shooting<'_>, &ScaledUnits),
        state: &ShootingState,
    ) -> Result<Vec<f64>> {
        let Deviations { at_zero, closing } = Deviations::new(shooting, units, state)?;
        Ok(at_zero.iter().chain(closing.iter()).copied().collect())
    }

    /// Their derivatives, of those of what was measured; not a number where a multiplier is one of several.
    pub fn derivatives(&self, own: &Loop, measured: &[f64]) -> Vec<Complex<f64>> {
        let (rows, columns) = own.shape;
        let (at_zero, closing) = measured.split_at(measured.len() / 2);
        let matrix = |x: &[f64]| DMatrix::from_iterator(rows, columns, x.iter().copied());
        let change = (!measured.is_empty()).then(|| Deviations {
            at_zero: matrix(at_zero),
            closing: matrix(closing),
        });
        let each = self.each.iter().map(|own| match (own, &change) {
            (Sensitivity::Fixed, _) => Complex::from(0.0),
            (
                Sensitivity::Simple {
                    mu,
                    left,
                    right,
                    over,
                },
                Some(change),
            ) => -left.dotc(&(change.at(*mu) * right)) / over,
            _ => Complex::new(f64::NAN, f64::NAN),
        });
        each.collect()
    }
}

/// How the derivative of a multiplier is found; `others` are all multipliers, this one too.
fn sensitivity(deviations: &Deviations, mu: Complex<f64>, others: &[Complex<f64>]) -> Sensitivity {
    let near =
        |other: &&Complex<f64>| (*other - mu).norm() <= DEFECTIVE_MULTIPLIER * others[0].norm();
    if others.iter().filter(near).count() > 1 {
        return Sensitivity::Multiple;
    }
    let matrix = deviations.at(mu);
    let (Some(left), Some(right)) = (null_vector(matrix.adjoint()), null_vector(matrix)) else {
        return Sensitivity::Multiple;
    };
    let per_mu = deviations.closing.map(Complex::from) * &right;
    let over = left.dotc(&per_mu);
    let beside = |other: &&Complex<f64>| (*other - mu).norm() <= ISOLATED_MULTIPLIER * mu.norm();
    let is_alone = others.iter().filter(beside).count() == 1;
    if !is_alone && over.norm() <= DEFECTIVE_MULTIPLIER * per_mu.norm() {
        return Sensitivity::Multiple;
    }
    Sensitivity::Simple {
        mu,
        left,
        right,
        over,
    }
}

/// The vector of length one that a singular matrix maps to zero, by inverse iteration.
fn null_vector(mut matrix: ComplexMatrix) -> Option<DVector<Complex<f64>>> {
    let n = matrix.nrows();
    // A pivot that is zero to the bit has no inverse.
    let off = Complex::from(f64::EPSILON * matrix.norm());
    for i in 0..n {
        matrix[(i, i)] += off;
    }
    let lu = matrix.lu();
    let mut vector = DVector::from_fn(n, |i, _| Complex::new(1.0, 0.1 * i as f64));
    for _ in 0..INVERSE_ITERATIONS {
        vector = lu.solve(&vector)?.normalize();
    }
    Some(vector)
}
