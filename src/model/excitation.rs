//! What acts on a scene from outside (theory 2, 10, 11): a constant load, harmonics of a fundamental frequency, tones of other
//! frequencies and signals, `f(t) = f0 + Re sum_k F_k e^{i k (w t + phase)} + Re sum_j T_j e^{i w_j t} + sum_j d_j s_j(t)`, and a base
//! whose acceleration has the same parts.
//!
//! Forcings are what a user gives; all equations of motion read the excitation that is made of them.
//!
//! The phase of the fundamental frequency (`Forcing::phase`) is in no amplitude here. Other forcings that are whole multiples of that
//! frequency have the difference of their phase to it in their amplitudes, tones all of their phase (`place_of`). A motion gets it as the
//! angle `w t + phase` of a `Moment`, whose phasor and its powers turn the harmonics: in steps, along series, in the maps of orbits. Runs in
//! closed form have it in the amplitudes (`turned`, by `flow/timed_scene.rs`), and their moments are without it.

use crate::model::constraint::Constraint;
use crate::model::forcing::{Forcing, whole_multiple};
use crate::model::fourier::Fourier;
use crate::model::gap_motion::GapMotion;
use crate::model::linear::LinearSystem;
use crate::model::moment::Moment;
use crate::model::rotations::{Rotations, powers};
use crate::model::signal::Signal;
use crate::model::system::System;
use nalgebra::{Complex, DVector};

/// What acts on the coordinates from outside.
#[derive(Debug, Clone)]
pub(crate) struct Excitation {
    /// The constant force `f0`: the system's own load, and the mean of a periodic force; shape `(n,)`, empty where there is none, [N].
    pub load: DVector<f64>,
    /// The mean of a periodic force, shape `(n,)`, empty where there is none, [N].
    pub mean: DVector<f64>,
    /// The harmonic part of the excitation at each frequency of the rotations.
    pub harmonics: Vec<HarmonicPart>,
    pub rotations: Rotations,
    /// The parts that follow signals.
    pub signals: Vec<SignalPart>,
    /// How each stop moves, `None` of one that rests; empty where all do.
    pub stops: Vec<Option<GapMotion>>,
}

/// The part of the excitation at one frequency.
#[derive(Debug, Clone)]
pub(crate) struct HarmonicPart {
    /// `A w^2` of a base displaced by `Re(A e^{i angle})`: its acceleration towards the system is `Re(A w^2 e^{i angle})`.
    pub base: Complex<f64>,
    /// The amplitude F of a force `Re(F e^{i angle})` on the coordinates, shape `(n,)`, empty where there is none, [N].
    pub force: DVector<Complex<f64>>,
}

/// The part of the excitation that follows one signal.
#[derive(Debug, Clone)]
pub(crate) struct SignalPart {
    /// The acceleration of the base towards the system, in units of the signal.
    pub base: f64,
    /// The force on the coordinates at a signal of 1, shape `(n,)`, empty where there is none, [N].
    pub force: DVector<f64>,
    pub signal: Signal,
}

impl HarmonicPart {
    /// Nothing.
    fn none() -> Self {
        Self::of(DVector::zeros(0))
    }

    /// A force on the coordinates.
    fn of(force: DVector<Complex<f64>>) -> Self {
        let base = Complex::default();
        Self { base, force }
    }

    /// Adds another of a phase.
    fn add(&mut self, other: Self, phase: f64) {
        let other = if phase == 0.0 {
            other
        } else {
            other.turned(Complex::cis(phase))
        };
        self.base += other.base;
        if self.force.is_empty() {
            self.force = other.force;
        } else if !other.force.is_empty() {
            self.force += other.force;
        }
    }

    fn turned(self, turn: Complex<f64>) -> Self {
        Self {
            base: self.base * turn,
            force: self.force.map(|f| f * turn),
        }
    }

    /// Whether it is a force that is not zero.
    pub fn is_force(&self) -> bool {
        self.force.iter().any(|f| f.norm() > 0.0)
    }
}

/// The force `M r` with which a base moves a linear system.
fn pull(system: &LinearSystem) -> DVector<f64> {
    let pull = system.influence().map(|r| system.mass().times(r));
    pull.expect("a scene with base motion has an influence vector")
}

impl Excitation {
    /// The excitation of a system by a forcing and its own load; the motion of a linear system's base becomes a force.
    pub fn new(system: &System, forcing: &Forcing) -> Self {
        Self::within(system, forcing, forcing)
    }

    /// The excitation by a forcing whose fundamental frequency is that of `moving`: the forcing and the motions of stops together.
    fn within(system: &System, forcing: &Forcing, moving: &Forcing) -> Self {
        let mut all = Self {
            load: match system {
                System::Linear(system) if system.load().amax() > 0.0 => system.load().clone(),
                _ => DVector::zeros(0),
            },
            mean: DVector::zeros(0),
            harmonics: Vec::new(),
            rotations: Rotations::default(),
            signals: Vec::new(),
            stops: Vec::new(),
        };
        if let Some(fundamental) = moving.frequency() {
            all.rotations.fundamental = fundamental;
        }
        for part in forcing.parts() {
            all.add(system, part, moving.phase());
        }
        if !all.mean.is_empty() {
            all.load = if all.load.is_empty() {
                all.mean.clone()
            } else {
                all.load + &all.mean
            };
        }
        all
    }

    /// Adds one forcing; `phase` is that of the fundamental frequency.
    fn add(&mut self, system: &System, part: &Forcing, phase: f64) {
        if let Some(signal) = part.own_signal() {
            self.signals
                .push(SignalPart::new(system, part, signal.clone()));
        }
        let Some(periodic) = part.own_periodic() else {
            return;
        };
        if let Some(mean) = periodic.mean().filter(|mean| mean.amax() > 0.0) {
            self.mean = if self.mean.is_empty() {
                mean.clone()
            } else {
                &self.mean + mean
            };
        }
        let angle = (periodic.frequency(), periodic.phase());
        for (k, (w, amplitude)) in (1u32..).zip(periodic.harmonics()) {
            let harmonic = match (part, system) {
                (Forcing::BaseMotion(_), System::Linear(system)) => {
                    HarmonicPart::of(pull(system).map(|x| amplitude[0] * x * w * w))
                }
                (Forcing::BaseMotion(_), _) => HarmonicPart {
                    base: amplitude[0] * w.powi(2),
                    force: DVector::zeros(0),
                },
                _ => HarmonicPart::of(amplitude.clone()),
            };
            let (place, phase) = self.place_of(k, angle, phase);
            self.harmonics[place].add(harmonic, phase);
        }
    }

    /// The place among the rotations of the k-th harmonic of a frequency, and what its phase adds to the angle there; `phase` is that
    /// of the fundamental frequency.
    fn place_of(&mut self, k: u32, (frequency, own_phase): (f64, f64), phase: f64) -> (usize, f64) {
        let Rotations {
            fundamental,
            n_harmonics,
            tones,
        } = &mut self.rotations;
        let periodic = *fundamental > 0.0;
        let times = periodic.then(|| whole_multiple(frequency, *fundamental));
        if let Some(times) = times.flatten() {
            let order = (times * k) as usize;
            if self.harmonics.len() < order {
                self.harmonics.resize(order, HarmonicPart::none());
                *n_harmonics = order;
            }
            let turned = f64::from(k) * (own_phase - f64::from(times) * phase);
            return (order - 1, turned);
        }
        self.harmonics.push(HarmonicPart::none());
        tones.push(f64::from(k) * frequency);
        (self.harmonics.len() - 1, f64::from(k) * own_phase)
    }

    /// The excitation of a scene with stops of which some move; `moving` is the forcing and the motions of stops together.
    pub fn with_stops(
        system: &System,
        forcing: &Forcing,
        stops: &[Constraint],
        moving: &Forcing,
    ) -> Self {
        let mut all = Self::within(system, forcing, moving);
        let phase = moving.phase();
        let each = stops.iter().map(|stop| {
            let motion = stop.motion().filter(|motion| motion.moves())?.as_forcing();
            let widens = stop.widens_by();
            let mut amplitudes = Vec::new();
            if let Some(periodic) = motion.own_periodic() {
                let angle = (periodic.frequency(), periodic.phase());
                for (k, a) in (1u32..).zip(periodic.amplitudes()) {
                    let (place, turned) = all.place_of(k, angle, phase);
                    if amplitudes.len() <= place {
                        amplitudes.resize(place + 1, Complex::default());
                    }
                    let turn = if turned == 0.0 {
                        Complex::from(1.0)
                    } else {
                        Complex::cis(turned)
                    };
                    amplitudes[place] += a[0] * turn * widens;
                }
            }
            let signal = motion.own_signal().map(|signal| {
                all.signals.push(SignalPart {
                    base: 0.0,
                    force: DVector::zeros(0),
                    signal: signal.scaled(widens),
                });
                let last = all.signals.len() - 1;
                (last, all.signals[last].signal.clone())
            });
            let mean = motion.own_periodic().and_then(Fourier::mean);
            let mean = mean.map_or(0.0, |mean| mean[0]);
            Some(GapMotion {
                mean: widens * mean,
                rotations: Rotations::default(),
                amplitudes,
                signal,
            })
        });
        let mut each: Vec<Option<GapMotion>> = each.collect();
        if each.iter().all(Option::is_none) {
            return all;
        }
        for motion in each.iter_mut().flatten() {
            motion.rotations = all.rotations.clone();
        }
        all.stops = each;
        all
    }

    /// Whether anything acts on the coordinates: stops that move have rotations and signals of their own, without force.
    pub fn acts(&self) -> bool {
        let moves_base = |part: &HarmonicPart| part.base != Complex::default();
        !self.load.is_empty()
            || (self.harmonics.iter()).any(|part| part.is_force() || moves_base(part))
            || (self.signals.iter()).any(|part| part.base != 0.0 || !part.force.is_empty())
    }

    /// How a stop moves, if it does.
    pub fn motion_of(&self, stop: usize) -> Option<&GapMotion> {
        self.stops.get(stop).and_then(Option::as_ref)
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
            force: if part.force.is_empty() {
                DVector::zeros(0)
            } else {
                harmonic(&part.force)
            },
        });
        let signals = self.signals.iter().map(|part| SignalPart {
            force: constant(&part.force),
            ..part.clone()
        });
        Self {
            load: constant(&self.load),
            mean: constant(&self.mean),
            harmonics: harmonics.collect(),
            rotations: self.rotations.clone(),
            signals: signals.collect(),
            stops: self.stops.clone(),
        }
    }

    /// `M^-1` times all that acts on a linear system.
    pub fn over_mass(&self, system: &LinearSystem) -> Self {
        let force = |force: &DVector<Complex<f64>>| system.solve_mass_complex(force);
        self.map(|load| system.solve_mass(load), force)
    }

    /// The forces of a linear system with the phase of the fundamental frequency put into their amplitudes.
    pub fn turned(mut self, phase: f64) -> Self {
        let harmonics = self.harmonics.iter_mut().take(self.rotations.n_harmonics);
        for (part, turn) in harmonics.zip(powers(Complex::cis(phase))) {
            part.force.apply(|f| *f *= turn);
        }
        for motion in self.stops.iter_mut().flatten() {
            let harmonics = motion
                .amplitudes
                .iter_mut()
                .take(self.rotations.n_harmonics);
            for (a, turn) in harmonics.zip(powers(Complex::cis(phase))) {
                *a *= turn;
            }
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

    /// The harmonics with their phasors at a moment.
    fn phasors(&self, at: Moment) -> impl Iterator<Item = (&HarmonicPart, Complex<f64>)> {
        self.harmonics.iter().zip(self.rotations.phasors(at))
    }

    /// The forces on the n coordinates of a linear system at a moment, but its own load.
    pub fn force(&self, at: Moment, n: usize) -> DVector<f64> {
        let mut sum = DVector::zeros(n);
        let mut is_first = true;
        let forces = self.phasors(at).filter(|(part, _)| !part.force.is_empty());
        for (part, u) in forces {
            let real = part.force.map(|f| (f * u).re);
            sum = if is_first { real } else { sum + real };
            is_first = false;
        }
        for part in self.signals.iter().filter(|part| !part.force.is_empty()) {
            sum.axpy(part.value(at), &part.force, 1.0);
        }
        if !self.mean.is_empty() {
            sum += &self.mean;
        }
        sum
    }

    /// The sizes of the terms of [`force`](Self::force).
    pub fn sizes(&self, at: Moment, n: usize) -> DVector<f64> {
        let zero = DVector::zeros(n);
        let sum = |sum: DVector<f64>, part: &HarmonicPart| {
            if part.force.is_empty() {
                sum
            } else {
                sum + part.force.map(Complex::norm)
            }
        };
        let mut sizes = self.harmonics.iter().fold(zero, sum);
        for part in self.signals.iter().filter(|part| !part.force.is_empty()) {
            sizes += part.force.abs() * part.signal.value_with_size(at.since, at.time).1;
        }
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
        for (HarmonicPart { base, force }, u) in self.phasors(at) {
            let by_force = |(f, v): (&Complex<f64>, &f64)| (f.re * u.re - f.im * u.im) * v;
            let base_power = if *base == Complex::default() {
                0.0
            } else if base.im == 0.0 {
                base.re * u.re * by_base()
            } else {
                (base * u).re * by_base()
            };
            power += base_power + force.iter().zip(v.iter()).map(by_force).sum::<f64>();
        }
        for part in &self.signals {
            let base_power = if part.base == 0.0 {
                0.0
            } else {
                part.base * by_base()
            };
            let by_force = part.force.iter().zip(v.iter()).map(|(f, v)| f * v);
            power += part.value(at) * (base_power + by_force.sum::<f64>());
        }
        if self.mean.is_empty() {
            power
        } else {
            power + self.mean.dot(v)
        }
    }

    /// The times at which a signal passes from one polynomial to another, or begins or ends, in order.
    pub fn breaks(&self) -> Vec<f64> {
        let each = self.signals.iter().flat_map(|part| part.signal.breaks());
        let mut all: Vec<f64> = each.collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }
}

impl SignalPart {
    /// The part of the excitation of a system by a forcing that follows a signal.
    fn new(system: &System, forcing: &Forcing, signal: Signal) -> Self {
        let nothing = DVector::zeros(0);
        let (base, force) = match (forcing, system) {
            (Forcing::Load(load), _) => {
                let direction = load.direction_vector(system.n_dof());
                (0.0, direction.expect("a scene has checked its loads"))
            }
            (_, System::Linear(system)) => (0.0, -pull(system)),
            _ => (-1.0, nothing),
        };
        Self {
            base,
            force,
            signal,
        }
    }

    /// The signal at a moment.
    pub fn value(&self, at: Moment) -> f64 {
        self.signal.value_with_size(at.since, at.time).0
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
        assert_eq!(of.rotations, Rotations::harmonics(3.0, 1));
        assert_eq!(of.load, dvector![0.0, 4.0]);
        let force = &of.harmonics[0].force;
        assert_eq!(force.map(|f| f.re), dvector![2.0 * 4.5, -1.5 * 4.5]);
    }

    #[test]
    fn a_base_shakes_a_pendulum_and_nothing_is_nothing() {
        let pendulum = System::from(DoublePendulum::new(1.0, 1.0, (0.0, 0.0)).expect("valid"));
        let base = BaseMotion::new(0.5, 3.0, 0.2).expect("valid");
        let of = Excitation::new(&pendulum, &base.into());
        let part = &of.harmonics[0];
        assert_eq!((part.base.re, part.force.len(), of.load.len()), (4.5, 0, 0));
        let nothing = Excitation::new(&pendulum, &Forcing::Unforced);
        assert!(nothing.harmonics.is_empty() && nothing.load.is_empty());
        assert!(nothing.rotations.is_empty());
    }

    #[test]
    fn power_is_force_times_velocity() {
        let force = dvector![Complex::new(1.0, 2.0), Complex::new(-3.0, 0.5)];
        let forcing = Harmonic::new(force.clone(), 1.7, 0.3).expect("valid");
        let of = Excitation::new(&linear().into(), &forcing.into());
        let (angle, v) = (0.8, dvector![0.3, -1.1]);
        let at = Moment::of_angle(angle);
        let now = force.map(|f| (f * Complex::cis(angle)).re);
        let power = of.power(at, |_| 0.0, &v);
        assert!((power - now.dot(&v)).abs() < 1e-15, "{power}");
    }
}
