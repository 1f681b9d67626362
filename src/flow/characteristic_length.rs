//! The characteristic lengths \[m\] of a motion, estimated from its scene and its start before it is computed: a run without an absolute
//! tolerance takes a part of them (theory 9). In another unit of length they are other numbers and the run is the same.
//!
//! The length of a gap is the largest of its clearance, the motion of its stop, the terms of `n.q` at the start and in the steady
//! response, and those of `n.v` at the start times the time of a turn. The response is taken without its resonances, which stops
//! and spans cut off: too short a length swallows no impact.

use crate::flow::modal_scene::ModalScene;
use crate::modal::{Block, Form, ModalForm, Pair, Response};
use crate::model::{Change, GapMotion, Scene};
use crate::tolerance::{ABSOLUTE_PART, SPLIT_ZERO_ROOT};
use nalgebra::{Complex, DVector};
use std::f64::consts::TAU;

/// The characteristic lengths of a linear scene, before its motion begins.
#[derive(Debug)]
pub(crate) struct CharacteristicLengths {
    /// The characteristic length of each gap, shape `(n_stops,)`, \[m\].
    pub gaps: Vec<f64>,
    pub rate: TurnRate,
}

impl CharacteristicLengths {
    /// Those of a scene.
    pub fn new(scene: &ModalScene) -> Self {
        let response = steady_sizes(scene);
        let gap = |stop: usize| {
            let clearance = scene.geometry.clearances[stop].abs();
            let moved = scene.excitation.motion_of(stop);
            let moved = moved.map_or(0.0, GapMotion::reach);
            let response = sum_of_sizes(&scene.position_rows[stop], &response);
            clearance.max(moved).max(response)
        };
        Self {
            gaps: (0..scene.n_stops()).map(gap).collect(),
            rate: TurnRate::new(scene.form.fastest_rate(), scene.rotations.fastest()),
        }
    }
}

/// The characteristic lengths of a scene that is integrated, before its motion begins.
#[derive(Debug)]
pub(crate) struct StepLengths {
    /// That of each coordinate, zeros of a scene that is not linear.
    coordinates: Vec<f64>,
    rate: TurnRate,
}

impl StepLengths {
    /// Those of a scene.
    pub fn new(scene: &Scene) -> Self {
        let fastest_forcing = scene.excitation().rotations.fastest();
        let unknown = || Self {
            coordinates: vec![0.0; scene.n_dof()],
            rate: TurnRate::new(0.0, fastest_forcing),
        };
        let Ok(bare) = scene.replace(Change::Stops(Vec::new())) else {
            return unknown();
        };
        let Ok(modal) = ModalScene::new(&bare, "the steady response") else {
            return unknown();
        };
        let (response, n) = (steady_sizes(&modal), scene.n_dof());
        let length = |j: usize| {
            let axis = DVector::from_fn(n, |i, _| if i == j { 1.0 } else { 0.0 });
            sum_of_sizes(&modal.form.position_row(&axis), &response)
        };
        Self {
            coordinates: (0..n).map(length).collect(),
            rate: TurnRate::new(modal.form.fastest_rate(), fastest_forcing),
        }
    }

    /// The shortest of the lengths of all coordinates for a start, and of the speeds that go with them, which have the same tolerance; none
    /// where all are zero. The acceleration at the start is used where no rate is known.
    pub fn shortest(
        &self,
        (q, v): (&[f64], &[f64]),
        acceleration: impl FnOnce() -> Vec<f64>,
    ) -> Option<f64> {
        let accelerations = if self.rate.is_known() {
            Vec::new()
        } else {
            acceleration()
        };
        let of = |(j, own): (usize, &f64)| {
            let speed = v[j].abs();
            let distance = self
                .rate
                .distance(speed, || accelerations.get(j).map_or(0.0, |a| a.abs()));
            let length = own.max(q[j].abs()).max(distance);
            [Some(length), self.rate.speed(length)]
                .into_iter()
                .flatten()
                .chain([speed])
        };
        let all = self.coordinates.iter().enumerate().flat_map(of);
        all.filter(|size| *size > 0.0).reduce(f64::min)
    }
}

/// The highest rate at which a motion oscillates \[1/s\]: its fastest rate, or the fastest frequency of the excitation; zero where it does
/// not oscillate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TurnRate(f64);

impl TurnRate {
    /// That of a motion with a fastest rate, zero where none is known, under what turns with angular frequencies.
    pub fn new(fastest_rate: f64, fastest_forcing: f64) -> Self {
        Self(fastest_rate.max(fastest_forcing / TAU))
    }

    /// Whether it is known.
    pub fn is_known(self) -> bool {
        self.0 > 0.0 && self.0.is_finite()
    }

    /// The distance that a speed leads to in the time of an oscillation; without one, until an acceleration has stopped it, or in a unit of
    /// time.
    pub fn distance(self, speed: f64, acceleration: impl FnOnce() -> f64) -> f64 {
        if self.is_known() {
            return speed / self.0;
        }
        let fall = speed * (speed / acceleration());
        if fall.is_finite() { fall } else { speed }
    }

    /// The speed that goes with a length; none where nothing turns.
    fn speed(self, length: f64) -> Option<f64> {
        self.is_known().then_some(length * self.0)
    }
}

/// The tolerances of a run, as they are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tolerances {
    pub relative: f64,
    /// None: a part of the characteristic lengths.
    pub absolute: Option<f64>,
}

/// The part of a length that an absolute tolerance is, where it is not given; of no length the part of one.
pub(crate) fn part_of(length: f64) -> f64 {
    let is_length = length > 0.0 && length.is_finite();
    ABSOLUTE_PART * if is_length { length } else { 1.0 }
}

/// The sizes of the modal pairs of the steady motion, without resonances: those of each force and of each load added up.
fn steady_sizes(scene: &ModalScene) -> Vec<Pair> {
    let steady =
        |load: &[Pair]| -> Vec<Response> { load.iter().map(|l| l.map(Complex::from)).collect() };
    let signals = scene.signals.iter().map(|part| {
        let [largest, _] = part.signal.largest();
        let direction = |d: &Pair| d.map(|d| Complex::from(largest * d));
        (0.0, part.directions.iter().map(direction).collect())
    });
    let harmonics = scene.harmonics().map(|(w, force)| (w, force.to_vec()));
    let all = harmonics.chain(signals).chain([(0.0, steady(&scene.load))]);
    let mut sizes = vec![[0.0; 2]; scene.form.n_dof()];
    for (w, force) in all {
        for (size, more) in sizes.iter_mut().zip(off_resonance(&scene.form, w, &force)) {
            *size = [size[0] + more[0], size[1] + more[1]];
        }
    }
    sizes
}

/// The sizes of the steady response to forces that turn with some angular frequency, zero of those that stand, as if each root were as
/// far from it as a root of its modulus at right angles: `|adj(i w - A) f| / (w^2 + |l_1 l_2|)`. What nothing holds does not answer to a
/// force that stands.
fn off_resonance(form: &ModalForm, w: f64, force: &[Response]) -> Vec<Pair> {
    let fastest = form.fastest_rate();
    match &form.form {
        Form::Blocks(blocks) => {
            let answer = |(block, f): (&Block, &Response)| {
                let [l, m] = block.roots().map(Complex::norm);
                let is_supported = l.min(m) > SPLIT_ZERO_ROOT * fastest;
                if w == 0.0 && !is_supported {
                    return [0.0; 2];
                }
                let [[a, b], [c, d]] = block.matrix();
                let (p, q) = (Complex::new(-a, w), Complex::new(-d, w));
                let from = [f[0] * q + f[1] * b, f[0] * c + f[1] * p];
                from.map(|x| x.norm() / (w * w + l * m))
            };
            blocks.iter().zip(force).map(answer).collect()
        }
        // Physical pairs: of an acceleration a position as if all were as stiff as the fastest.
        Form::Dense(_) => {
            let stiffness = w * w + fastest * fastest;
            let answer = |f: &Response| [f[1].norm() / stiffness, 0.0];
            force.iter().map(answer).collect()
        }
    }
}

/// The sum of the sizes of the terms of a row.
fn sum_of_sizes(row: &[Pair], sizes: &[Pair]) -> f64 {
    let terms = row.iter().zip(sizes);
    let terms = terms.map(|(r, z)| (r[0] * z[0]).abs() + (r[1] * z[1]).abs());
    terms.sum()
}
