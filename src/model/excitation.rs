//! What acts on a scene from outside (theory 2): a constant load and harmonics of one fundamental frequency,
//! `f(t) = f0 + Re sum_k F_k e^{i k (w t + phase)}`, and a base whose acceleration has the same harmonics.
//!
//! Forcings say what a user means; this is what all equations read. Today there is one harmonic: who asks for
//! [`Excitation::single`] has no sum over several yet.

use crate::model::forcing::Forcing;
use crate::model::linear::LinearSystem;
use crate::model::moment::Moment;
use crate::model::system::System;
use nalgebra::{Complex, DVector};

/// What acts on the coordinates from outside.
#[derive(Debug, Clone)]
pub(crate) struct Excitation {
    /// `f0`, empty where there is none.
    pub load: DVector<f64>,
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

impl Excitation {
    /// What a forcing, and a load of its own, are to a system: the base of a linear system moves it by forces.
    pub fn new(system: &System, forcing: &Forcing) -> Self {
        let none = DVector::zeros(0);
        let harmonic = match (forcing, system) {
            (Forcing::Unforced, _) => None,
            (Forcing::Harmonic(force), _) => Some((0.0, force.amplitude().clone())),
            (Forcing::BaseMotion(base), System::Linear(system)) => {
                let pull = system.influence().map(|r| system.mass().times(r));
                let pull = pull.expect("a scene with base motion has an influence vector");
                let (a, w) = (base.amplitude(), base.frequency());
                Some((0.0, pull.map(|x| Complex::from(x * a * w * w))))
            }
            (Forcing::BaseMotion(base), _) => Some((
                base.amplitude() * base.frequency().powi(2),
                DVector::zeros(0),
            )),
        };
        Self {
            load: match system {
                System::Linear(system) if system.load().amax() > 0.0 => system.load().clone(),
                _ => none,
            },
            harmonics: harmonic
                .map(|(base, force)| HarmonicPart { base, force })
                .into_iter()
                .collect(),
            frequency: forcing.frequency().unwrap_or(0.0),
        }
    }

    /// The same with a load and forces that are made of these.
    pub fn map(
        &self,
        load: impl Fn(&DVector<f64>) -> DVector<f64>,
        force: impl Fn(&DVector<Complex<f64>>) -> DVector<Complex<f64>>,
    ) -> Self {
        let given = !self.load.is_empty();
        let harmonics = self.harmonics.iter().map(|part| HarmonicPart {
            base: part.base,
            force: force(&part.force),
        });
        Self {
            load: if given {
                load(&self.load)
            } else {
                DVector::zeros(0)
            },
            harmonics: harmonics.collect(),
            frequency: self.frequency,
        }
    }

    /// `M^-1` times all that acts on a linear system.
    pub fn over_mass(&self, system: &LinearSystem) -> Self {
        let force = |force: &DVector<Complex<f64>>| system.solve_mass_complex(force);
        self.map(|load| system.solve_mass(load), force)
    }

    /// The one harmonic, where there is any.
    pub fn single(&self) -> Option<&HarmonicPart> {
        debug_assert!(self.harmonics.len() < 2, "no sum over several yet");
        self.harmonics.first()
    }

    /// The complex amplitude of the one harmonic's force on n coordinates.
    pub fn amplitude(&self, n: usize) -> DVector<Complex<f64>> {
        self.single()
            .map_or_else(|| DVector::zeros(n), |part| part.force.clone())
    }

    /// The power of what changes with time: an acceleration of the base acts on coordinate i by `lever(i)` times itself.
    pub fn power(&self, at: Moment, lever: impl Fn(usize) -> f64, v: &DVector<f64>) -> f64 {
        let (sin, cos) = at.angle.sin_cos();
        let Some(HarmonicPart { base, force }) = self.single() else {
            return 0.0;
        };
        let by_force = |(f, v): (&Complex<f64>, &f64)| (f.re * cos - f.im * sin) * v;
        let by_base = || (0..v.len()).map(|i| lever(i) * v[i]).sum::<f64>();
        let base_power = if *base == 0.0 {
            0.0
        } else {
            base * cos * by_base()
        };
        base_power + force.iter().zip(v.iter()).map(by_force).sum::<f64>()
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
        let force = &of.single().expect("one").force;
        assert_eq!(force.map(|f| f.re), dvector![2.0 * 4.5, -1.5 * 4.5]);
    }

    #[test]
    fn a_base_shakes_a_pendulum_and_nothing_is_nothing() {
        let pendulum = System::from(DoublePendulum::new(1.0, 1.0, (0.0, 0.0)).expect("valid"));
        let base = BaseMotion::new(0.5, 3.0, 0.2).expect("valid");
        let of = Excitation::new(&pendulum, &base.into());
        let part = of.single().expect("one");
        assert_eq!((part.base, part.force.len(), of.load.len()), (4.5, 0, 0));
        let nothing = Excitation::new(&pendulum, &Forcing::Unforced);
        assert!(nothing.single().is_none() && nothing.load.is_empty());
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
