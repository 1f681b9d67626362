//! Moving stops impose a part of the motion of what is held on them (theory 12): with stops held it is `q = q_c + G c(t) + Z y`, where c
//! are the motions of the stops about their means \[m\], known functions of time, and y is the remaining motion, which they drive. The
//! means are in `q_c`.

use crate::error::Result;
use crate::flow::gap_row::Quantity;
use crate::flow::modal_scene::ModalScene;
use crate::flow::regime_drive::RegimeDrive;
use crate::model::{GapMotion, Moment, PhysicalState, Rotations, Signal};
use crate::tolerance::CANCELLED;
use nalgebra::{Complex, DMatrix, DVector};

/// The part `G c(t)` of the position that stops which are held and move impose.
#[derive(Debug, Clone, Default)]
pub(crate) struct ImposedMotion {
    rotations: Rotations,
    /// The amplitude of `G c` for each rotation; empty where no stop held moves harmonically.
    turning: Vec<DVector<Complex<f64>>>,
    /// For each signal that a stop held follows: its number, the signal, and the direction of `G c`.
    following: Vec<(usize, Signal, DVector<f64>)>,
}

impl ImposedMotion {
    /// The imposed motion of some stops held; `lift` applies G, from gaps of these stops to a position.
    pub fn new(
        scene: &ModalScene,
        stops: &[usize],
        lift: impl Fn(&DVector<f64>) -> Result<DVector<f64>>,
    ) -> Result<Self> {
        let motions: Vec<Option<&GapMotion>> = stops
            .iter()
            .map(|&stop| scene.excitation.motion_of(stop))
            .collect();
        if motions.iter().all(Option::is_none) {
            return Ok(Self::default());
        }
        let each = |of: &dyn Fn(&GapMotion) -> f64| {
            let parts = motions.iter().map(|motion| motion.map_or(0.0, of));
            DVector::from_iterator(stops.len(), parts)
        };
        let mut turning = Vec::new();
        for r in 0..scene.rotations.len() {
            let amplitude =
                |motion: &GapMotion| motion.amplitudes.get(r).copied().unwrap_or_default();
            let (re, im) = (
                lift(&each(&|motion| amplitude(motion).re))?,
                lift(&each(&|motion| amplitude(motion).im))?,
            );
            turning.push(re.zip_map(&im, Complex::new));
        }
        let mut following = Vec::new();
        for (place, part) in scene.excitation.signals.iter().enumerate() {
            let follows = |motion: &GapMotion| {
                let is_it = motion.signal.as_ref().is_some_and(|(own, _)| *own == place);
                f64::from(u8::from(is_it))
            };
            let direction = each(&follows);
            if direction.amax() > 0.0 {
                following.push((place, part.signal.clone(), lift(&direction)?));
            }
        }
        Ok(Self {
            rotations: scene.rotations.clone(),
            turning,
            following,
        })
    }

    /// Position and velocity at a moment; `None` where no stop held moves.
    pub fn at(&self, at: Moment) -> Option<PhysicalState> {
        let n = (self.turning.first().map(DVector::len))
            .or_else(|| self.following.first().map(|(_, _, d)| d.len()))?;
        let (mut q, mut v) = (DVector::zeros(n), DVector::zeros(n));
        let phasors = self.rotations.phasors(at).zip(self.rotations.frequencies());
        for (amplitude, (u, w)) in self.turning.iter().zip(phasors) {
            q.zip_apply(amplitude, |q, a| *q += (a * u).re);
            v.zip_apply(amplitude, |v, a| *v -= w * (a * u).im);
        }
        for (_, signal, direction) in &self.following {
            signal.derivatives(at.since, at.time, |m, x| match m {
                0 => q.axpy(x, direction, 1.0),
                1 => v.axpy(x, direction, 1.0),
                _ => {}
            });
        }
        Some((q, v))
    }

    /// Adds what this does to the accelerations of the whole system, `-M^-1 K q_c - M^-1 C q_c' - q_c''`, to those by rotations and by
    /// signals; derivatives of signals become signals of their own.
    pub fn act(
        &self,
        (stiffness, damping): (&DMatrix<f64>, &DMatrix<f64>),
        drive: &mut RegimeDrive,
    ) {
        let over = |m: &DMatrix<f64>, x: &DVector<Complex<f64>>| {
            let (re, im) = (m * x.map(|z| z.re), m * x.map(|z| z.im));
            re.zip_map(&im, Complex::new)
        };
        let frequencies = self.rotations.frequencies();
        for ((a, q), w) in drive.turning.iter_mut().zip(&self.turning).zip(frequencies) {
            let drawn = over(stiffness, q) + over(damping, q) * Complex::new(0.0, w);
            *a += q * Complex::from(w * w) - drawn;
        }
        for (place, signal, direction) in &self.following {
            drive.following[*place] -= stiffness * direction;
            let (speed, acceleration) = (signal.derivative(), signal.derivative().derivative());
            drive.add(speed, -(damping * direction));
            drive.add(acceleration, -direction);
        }
    }

    /// The gap of another stop, with the imposed motion and that stop's own motion included.
    pub fn gap(
        &self,
        scene: &ModalScene,
        stop: usize,
        normal: &DVector<f64>,
        gap: Quantity,
    ) -> Quantity {
        let own = scene.excitation.motion_of(stop);
        let mut gap = own.map_or(gap.clone(), |motion| gap.widened_by(motion));
        let cleared = |sum: f64, size: f64| {
            if sum.abs() > CANCELLED * size {
                sum
            } else {
                0.0
            }
        };
        for (r, q) in self.turning.iter().enumerate() {
            if gap.forcing.len() <= r {
                gap.forcing.resize(r + 1, Complex::default());
            }
            let own = gap.forcing[r];
            let along: Complex<f64> = normal.iter().zip(q.iter()).map(|(n, q)| q * *n).sum();
            let size = own.norm() + along.norm();
            gap.forcing[r] = Complex::new(
                cleared(own.re + along.re, size),
                cleared(own.im + along.im, size),
            );
        }
        for (place, _, direction) in &self.following {
            if gap.signals.len() <= *place {
                gap.signals.resize(place + 1, 0.0);
            }
            let (own, along) = (gap.signals[*place], normal.dot(direction));
            gap.signals[*place] = cleared(own + along, own.abs() + along.abs());
        }
        gap
    }
}
