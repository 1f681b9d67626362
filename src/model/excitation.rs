//! What acts on a scene from outside (theory 2): a constant load and harmonics of one fundamental frequency,
//! `f(t) = f0 + Re sum_k F_k e^{i k (w t + phase)}`, and a base whose acceleration has the same harmonics.
//!
//! Forcings say what a user means; this is what all equations read.

use crate::model::forcing::Forcing;
use crate::model::linear::LinearSystem;
use crate::model::moment::Moment;
use crate::model::system::System;
use nalgebra::{Complex, DVector};

/// What acts on the coordinates from outside.
#[derive(Debug, Clone)]
pub(crate) struct Excitation {
    /// `f0`, empty where there is none: the system's own load, and the mean of a periodic force.
    pub load: DVector<f64>,
    /// The mean of a periodic force, empty where there is none.
    pub mean: DVector<f64>,
    /// What acts at `w`, at `2 w` and so on.
    pub harmonics: Vec<HarmonicPart>,
    /// The fundamental frequency w, zero without harmonics.
    pub frequency: f64,
}

/// What acts at one multiple of the fundamental frequency.
#[derive(Debug, Clone)]
pub(crate) struct HarmonicPart {
    /// `A w^2` of a base displaced by `A cos(angle)`: its acceleration towards the system is `A w^2 cos(angle)`.
    pub base: f64,
    /// F of `Re(F e^{i angle})` on the coordinates, empty where there is none.
    pub force: DVector<Complex<f64>>,
}

impl HarmonicPart {
    /// A force on the coordinates.
    fn of(force: DVector<Complex<f64>>) -> Self {
        let base = 0.0;
        Self { base, force }
    }

    /// Whether it is a force that is not zero.
    pub fn is_force(&self) -> bool {
        self.force.iter().any(|f| f.norm() > 0.0)
    }
}

/// `u`, `u^2`, `u^3` and so on: the phasors of the harmonics from that of the first.
#[inline]
pub(crate) fn powers(u: Complex<f64>) -> impl Iterator<Item = Complex<f64>> {
    std::iter::successors(Some(u), move |power| Some(power * u))
}

impl Excitation {
    /// What a forcing, and a load of its own, are to a system: the base of a linear system moves it by forces.
    pub fn new(system: &System, forcing: &Forcing) -> Self {
        let none = DVector::zeros(0);
        let harmonics = match (forcing, system) {
            (Forcing::Unforced, _) => Vec::new(),
            (Forcing::Harmonic(force), _) => vec![HarmonicPart::of(force.amplitude().clone())],
            (Forcing::Fourier(force), _) => {
                let amplitudes = force.amplitudes().iter().cloned();
                amplitudes.map(HarmonicPart::of).collect()
            }
            (Forcing::BaseMotion(base), System::Linear(system)) => {
                let pull = system.influence().map(|r| system.mass().times(r));
                let pull = pull.expect("a scene with base motion has an influence vector");
                let (a, w) = (base.amplitude(), base.frequency());
                vec![HarmonicPart::of(pull.map(|x| Complex::from(x * a * w * w)))]
            }
            (Forcing::BaseMotion(base), _) => vec![HarmonicPart {
                base: base.amplitude() * base.frequency().powi(2),
                force: DVector::zeros(0),
            }],
        };
        let own = match system {
            System::Linear(system) if system.load().amax() > 0.0 => system.load().clone(),
            _ => none.clone(),
        };
        let mean = match forcing {
            Forcing::Fourier(force) => force.mean().filter(|mean| mean.amax() > 0.0),
            _ => None,
        };
        Self {
            load: match (mean, own.is_empty()) {
                (None, _) => own,
                (Some(mean), true) => mean.clone(),
                (Some(mean), false) => own + mean,
            },
            mean: mean.cloned().unwrap_or(none),
            harmonics,
            frequency: forcing.frequency().unwrap_or(0.0),
        }
    }

    /// The same with constant and harmonic forces that are made of these.
    pub fn map(
        &self,
        constant: impl Fn(&DVector<f64>) -> DVector<f64>,
        harmonic: impl Fn(&DVector<Complex<f64>>) -> DVector<Complex<f64>>,
    ) -> Self {
        let constant = |given: &DVector<f64>| {
            if given.is_empty() {
                DVector::zeros(0)
            } else {
                constant(given)
            }
        };
        let harmonics = self.harmonics.iter().map(|part| HarmonicPart {
            base: part.base,
            force: harmonic(&part.force),
        });
        Self {
            load: constant(&self.load),
            mean: constant(&self.mean),
            harmonics: harmonics.collect(),
            frequency: self.frequency,
        }
    }

    /// `M^-1` times all that acts on a linear system.
    pub fn over_mass(&self, system: &LinearSystem) -> Self {
        let force = |force: &DVector<Complex<f64>>| system.solve_mass_complex(force);
        self.map(|load| system.solve_mass(load), force)
    }

    /// The forces of a linear system with a phase put into their amplitudes.
    pub fn turned(mut self, phase: f64) -> Self {
        for (part, turn) in self.harmonics.iter_mut().zip(powers(Complex::cis(phase))) {
            part.force.apply(|f| *f *= turn);
        }
        self
    }

    /// The constant load on n coordinates.
    pub fn constant(&self, n: usize) -> DVector<f64> {
        if self.load.is_empty() {
            DVector::zeros(n)
        } else {
            self.load.clone()
        }
    }

    /// The forces on the n coordinates of a linear system, but its own load, where the phasor of the first harmonic is u.
    pub fn force(&self, u: Complex<f64>, n: usize) -> DVector<f64> {
        let mut harmonics = self.harmonics.iter().zip(powers(u));
        let real = |(part, u): (&HarmonicPart, Complex<f64>)| part.force.map(|f| (f * u).re);
        let mut sum = harmonics.next().map_or_else(|| DVector::zeros(n), real);
        for higher in harmonics {
            sum += real(higher);
        }
        if !self.mean.is_empty() {
            sum += &self.mean;
        }
        sum
    }

    /// The sizes of the terms of [`force`](Self::force).
    pub fn sizes(&self, n: usize) -> DVector<f64> {
        let zero = DVector::zeros(n);
        let sum = |sum: DVector<f64>, part: &HarmonicPart| sum + part.force.map(Complex::norm);
        let sizes = self.harmonics.iter().fold(zero, sum);
        if self.mean.is_empty() {
            sizes
        } else {
            sizes + self.mean.abs()
        }
    }

    /// The power of all but the load of the system: an acceleration of the base acts on coordinate i by `lever(i)` times itself.
    pub fn power(&self, at: Moment, lever: impl Fn(usize) -> f64, v: &DVector<f64>) -> f64 {
        let by_base = || (0..v.len()).map(|i| lever(i) * v[i]).sum::<f64>();
        let mut power = 0.0;
        for (HarmonicPart { base, force }, u) in
            self.harmonics.iter().zip(powers(Complex::cis(at.angle)))
        {
            let by_force = |(f, v): (&Complex<f64>, &f64)| (f.re * u.re - f.im * u.im) * v;
            let base_power = if *base == 0.0 {
                0.0
            } else {
                base * u.re * by_base()
            };
            power += base_power + force.iter().zip(v.iter()).map(by_force).sum::<f64>();
        }
        if self.mean.is_empty() {
            power
        } else {
            power + self.mean.dot(v)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{BaseMotion, DoublePendulum, Harmonic, LinearSystem};
    use nalgebra::dvector;

    fn linear() -> LinearSystem {
        let (mass, stiffness) = (dvector![2.0, 3.0], dvector![5.0, 7.0]);
        LinearSystem::new(mass, dvector![0.0, 0.0], stiffness)
            .and_then(|system| system.with_influence(dvector![1.0, -0.5]))
            .and_then(|system| system.with_load(dvector![0.0, 4.0]))
            .expect("valid")
    }

    #[test]
    fn a_base_pushes_a_linear_system_by_its_mass() {
        let base = BaseMotion::new(0.5, 3.0, 0.2).expect("valid");
        let of = Excitation::new(&linear().into(), &base.into());
        assert_eq!((of.frequency, of.load.as_slice()), (3.0, &[0.0, 4.0][..]));
        let force = &of.harmonics[0].force;
        assert_eq!(force.map(|f| f.re), dvector![2.0 * 4.5, -1.5 * 4.5]);
    }

    #[test]
    fn a_base_shakes_a_pendulum_and_nothing_is_nothing() {
        let pendulum = System::from(DoublePendulum::new(1.0, 1.0, (0.0, 0.0)).expect("valid"));
        let base = BaseMotion::new(0.5, 3.0, 0.2).expect("valid");
        let of = Excitation::new(&pendulum, &base.into());
        let part = &of.harmonics[0];
        assert_eq!((part.base, part.force.len(), of.load.len()), (4.5, 0, 0));
        let nothing = Excitation::new(&pendulum, &Forcing::Unforced);
        assert!(nothing.harmonics.is_empty() && nothing.load.is_empty());
        assert_eq!(nothing.frequency, 0.0);
    }

    #[test]
    fn power_is_force_times_velocity() {
        let force = dvector![Complex::new(1.0, 2.0), Complex::new(-3.0, 0.5)];
        let forcing = Harmonic::new(force.clone(), 1.7, 0.3).expect("valid");
        let of = Excitation::new(&linear().into(), &forcing.into());
        let (angle, v) = (0.8, dvector![0.3, -1.1]);
        let at = Moment {
            time: 0.0,
            angle,
            frequency: 1.7,
        };
        let now = force.map(|f| (f * Complex::cis(angle)).re);
        let power = of.power(at, |_| 0.0, &v);
        assert!((power - now.dot(&v)).abs() < 1e-15, "{power}");
    }
}
