//! Scenes and orbits that the tests begin with.

use crate::random::Random;
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    Branch, ContinuationOptions, Fourier, Harmonic, LinearSystem, OrbitOptions, Parameter, Pattern,
    PeriodicOrbit, Scene, SimulateOptions, Stop, continuation, find_orbit, periodic_orbits,
    simulate,
};

/// `x'' + 2 eta x' + x = F cos w t` before a stop at d.
#[derive(Debug, Clone, Copy)]
pub struct Oscillator {
    pub eta: f64,
    pub force: f64,
    pub frequency: f64,
    pub clearance: f64,
    pub restitution: f64,
}

/// The oscillator of Shaw and Holmes that most tests take.
pub const USUAL: Oscillator = Oscillator {
    eta: 0.05,
    force: 8.5,
    frequency: 2.4,
    clearance: 1.0,
    restitution: 0.8,
};

impl Oscillator {
    pub fn scene(self) -> Scene {
        let system = LinearSystem::new(dvector![1.0], dmatrix![2.0 * self.eta], dmatrix![1.0]);
        let force = Harmonic::new(dvector![self.force.into()], self.frequency, 0.0);
        let stop = Stop::new(0, self.clearance, self.restitution).expect("valid");
        Scene::new(system.expect("valid"), force.expect("valid"), [stop]).expect("valid")
    }

    /// Its orbits of one impact in n periods.
    pub fn orbits(self, n_periods: usize) -> Vec<PeriodicOrbit> {
        let options = OrbitOptions {
            n_periods,
            ..OrbitOptions::default()
        };
        let found = periodic_orbits(&self.scene(), &Pattern::single(0), &options);
        found.expect("a search").into_iter().collect()
    }

    /// The oscillator with a number moved.
    pub fn at(self, parameter: Parameter, value: f64) -> Self {
        match parameter {
            Parameter::ForcingScale => Self {
                force: self.force * value,
                ..self
            },
            Parameter::DampingScale => Self {
                eta: self.eta * value,
                ..self
            },
            Parameter::Frequency => Self {
                frequency: value,
                ..self
            },
            Parameter::RESTITUTION => Self {
                restitution: value,
                ..self
            },
            _ => Self {
                clearance: value,
                ..self
            },
        }
    }

    /// The numbers of the closed form of one impact in n periods (theory 19, "closed forms").
    pub fn closed(self, n_periods: usize) -> Closed {
        let Self {
            eta,
            frequency: w,
            restitution: e,
            ..
        } = self;
        let t = std::f64::consts::TAU * n_periods as f64 / w;
        let own = (1.0 - eta * eta).sqrt();
        let (decay, angle) = ((-eta * t).exp(), own * t);
        let s = decay * angle.sin() / own;
        let cos = decay * angle.cos();
        let end = (-2.0 * eta * t).exp();
        let all = 1.0 - 2.0 * cos + end;
        let a = (1.0 + e) * s / all;
        let b = 1.0 + (1.0 + e) * (cos - eta * s - end) / all;
        let z = (1.0 - w * w).hypot(2.0 * eta * w);
        Closed {
            s,
            cos,
            end,
            a,
            b,
            z,
        }
    }

    /// By how much the speed of an impact misses the closed form, in parts of the amplitude without a stop.
    pub fn miss(self, n_periods: usize, speed: f64) -> f64 {
        self.force_of(n_periods, speed) / self.force - 1.0
    }

    /// The force of which an impact has a speed.
    pub fn force_of(self, n_periods: usize, speed: f64) -> f64 {
        let Closed { a, b, z, .. } = self.closed(n_periods);
        z * (self.clearance + a * speed).hypot(b * speed / self.frequency)
    }

    /// The speed at the fold over the force, below zero where there is none.
    pub fn fold_speed(self, n_periods: usize) -> f64 {
        let Closed { a, b, .. } = self.closed(n_periods);
        -a * self.clearance / (a * a + (b / self.frequency).powi(2))
    }

    /// The speed at which a multiplier is -1, below zero where there is none.
    pub fn doubling_speed(self, n_periods: usize) -> f64 {
        let Closed {
            s, cos, end, a, b, ..
        } = self.closed(n_periods);
        let (e, w2) = (self.restitution, self.frequency.powi(2));
        let q = (1.0 - w2) * a + 2.0 * self.eta * b;
        let rest = 1.0 + e * e * end - 2.0 * e * cos + (1.0 + e) * s * q;
        (1.0 + e) * s * w2 * self.clearance / rest
    }
}

/// What the closed form is made of.
#[derive(Debug, Clone, Copy)]
pub struct Closed {
    pub s: f64,
    pub cos: f64,
    pub end: f64,
    pub a: f64,
    pub b: f64,
    pub z: f64,
}

/// A branch that is followed to its ends.
pub fn followed(
    orbit: &PeriodicOrbit,
    parameter: Parameter,
    between: (f64, f64),
    options: &ContinuationOptions,
) -> Branch {
    continuation(orbit, parameter, between, options).expect("a branch")
}

/// A mass held at zero by `F cos th - F_2 cos 2 th`, F = 1, which comes to zero at th = 0 where `F_2` is F.
pub fn pressed(second: f64, restitution: f64) -> vibroimpact::Result<Scene> {
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
    let force = vec![dvector![1.0.into()], dvector![(-second).into()]];
    let force = Fourier::new(force, 0.3, 0.0)?;
    Scene::new(system, force, [Stop::new(0, 0.0, restitution)?])
}

/// A random oscillator, with an orbit of one impact a little beside the force at which it doubles; none where it does not.
pub fn beside_a_doubling(random: &mut Random) -> Option<(Oscillator, PeriodicOrbit)> {
    let own = Oscillator {
        eta: random.between(0.01, 0.2),
        force: 1.0,
        frequency: random.between(1.5, 4.0),
        clearance: random.between(0.2, 1.5),
        restitution: random.between(0.3, 0.95),
    };
    let speed = own.doubling_speed(1);
    if !(speed > 0.05 && speed.is_finite()) {
        return None;
    }
    let start = Oscillator {
        force: 1.001 * own.force_of(1, speed),
        ..own
    };
    let near = |orbit: &PeriodicOrbit| (orbit.impacts()[0].approach / speed - 1.0).abs() < 0.1;
    let orbit = start.orbits(1).into_iter().find(near)?;
    Some((start, orbit))
}

/// The orbit that one mass comes to from rest somewhere, after so many periods of the forcing.
pub fn settled(scene: &Scene, from: f64, periods: u32) -> Option<PeriodicOrbit> {
    let (q, v) = (dvector![from], dvector![0.0]);
    let span = (0.0, f64::from(periods) * scene.period().expect("one"));
    let run = simulate(scene, &q, &v, span, &SimulateOptions::default()).expect("a run");
    find_orbit(scene, &run, None).ok()
}
