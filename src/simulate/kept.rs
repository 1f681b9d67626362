//! A motion as it is kept: pieces that follow each other in time, grouped in segments, and for each piece the numbers from
//! which it can be had at any of its times.

use crate::error::{Error, Result};
use crate::flow::steps::Dense;
use crate::flow::steps::dense_output::{DenseOutput, state_of};
use crate::flow::{ConstrainedMotion, ModalScene, SceneFlow, carry, with_flow};
use crate::modal::Pair;
use crate::simulate::clock::Clock;
use nalgebra::DVector;
use std::sync::Arc;

/// What a part of a trajectory is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SegmentKind {
    /// Free motion.
    Flight,
    /// The end of an infinite sequence of impacts that accumulate at a finite time.
    Chatter,
    /// Lasting contact.
    Stick,
}

impl SegmentKind {
    const ALL: [Self; 3] = [Self::Flight, Self::Chatter, Self::Stick];

    /// The name used in Python.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flight => "flight",
            Self::Chatter => "chatter",
            Self::Stick => "stick",
        }
    }

    /// The kind of a name.
    pub(crate) fn from_name(name: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.name() == name)
            .ok_or_else(|| Error::bad_value("segment", name, "there is no such kind"))
    }
}

/// One piece: its clock and span.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    pub clock: Clock,
    pub span: f64,
}

impl Piece {
    /// How far along it a time is, as the doubles that a user sees: at its start, the start.
    pub fn local(&self, t: f64) -> f64 {
        if t == self.clock.time() {
            return 0.0;
        }
        self.clock.until(self.clock.at(t)).clamp(0.0, self.span)
    }
}

/// A segment: its kind, the stops in contact and its first piece.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct KeptSegment {
    pub kind: SegmentKind,
    pub stops: Vec<usize>,
    pub first: usize,
    /// Where the numbers of its pieces begin.
    pub offset: usize,
}

/// The motion that `keep` asks for.
#[derive(Debug, Clone, Default)]
pub(crate) struct Kept {
    pub pieces: Vec<Piece>,
    pub segments: Vec<KeptSegment>,
    /// The numbers of each piece, one after the other, as many for each of a segment.
    pub numbers: Vec<f64>,
}

impl Kept {
    /// Begins a segment.
    pub fn begin(&mut self, kind: SegmentKind, stops: &[usize]) {
        self.segments.push(KeptSegment {
            kind,
            stops: stops.to_vec(),
            first: self.pieces.len(),
            offset: self.numbers.len(),
        });
    }

    /// The segment that a piece belongs to.
    pub fn segment_of(&self, piece: usize) -> &KeptSegment {
        let later = self.segments.partition_point(|s| s.first <= piece);
        &self.segments[later - 1]
    }

    /// The numbers of a piece of a segment, so many for each.
    pub fn numbers_of(&self, segment: &KeptSegment, piece: usize, width: usize) -> &[f64] {
        let start = segment.offset + (piece - segment.first) * width;
        &self.numbers[start..start + width]
    }

    /// The pieces of a segment.
    pub fn pieces_of(&self, segment: usize) -> std::ops::Range<usize> {
        let end = self
            .segments
            .get(segment + 1)
            .map_or(self.pieces.len(), |next| next.first);
        self.segments[segment].first..end
    }
}

/// What makes a motion of the numbers of its pieces.
#[derive(Debug, Clone)]
pub(crate) enum Machinery {
    /// Exact flights: the numbers are the modal pairs at the start of the piece.
    Exact {
        modal: Arc<ModalScene>,
        flow: Arc<SceneFlow>,
        /// The motions while stops were held.
        held: Vec<Arc<ConstrainedMotion>>,
    },
    /// Runge-Kutta steps: the numbers are the step's length and its dense output.
    Steps,
    /// Taylor series of the velocities to an order: the numbers are the unit of time and the coefficients of the positions
    /// in it, one after the other for each. Chatter and lasting contact are Runge-Kutta steps.
    Series { order: usize },
}

impl Machinery {
    /// How many numbers a piece of a segment has for n degrees of freedom.
    pub fn width(&self, kind: SegmentKind, n: usize) -> usize {
        match self {
            Self::Exact { .. } => 2 * n,
            Self::Series { order } if kind == SegmentKind::Flight => series_width(*order, n),
            Self::Steps | Self::Series { .. } => Dense::<Vec<f64>, 4>::width(n),
        }
    }

    /// Position and velocity a time after the start of a piece of a segment.
    pub fn state(
        &self,
        segment: &KeptSegment,
        piece: Piece,
        numbers: &[f64],
        local: f64,
    ) -> (DVector<f64>, DVector<f64>) {
        match self {
            Self::Exact { modal, flow, held } => {
                let mut state: Vec<Pair> = numbers.chunks(2).map(|z| [z[0], z[1]]).collect();
                let angle = piece.clock.angle();
                let is_holding = |s: &&Arc<ConstrainedMotion>| s.stops == segment.stops;
                if let Some(constrained) = held.iter().find(is_holding) {
                    let (q, v) = modal.form.to_physical(&state);
                    return constrained.carry(angle, local, &q, &v);
                }
                with_flow!(&**flow, f => carry(f, angle, local, &mut state));
                modal.form.to_physical(&state)
            }
            Self::Series { order } if segment.kind == SegmentKind::Flight => {
                read_series(numbers, *order, local)
            }
            Self::Steps | Self::Series { .. } => {
                let n = numbers.len() / 10;
                let x = state_of(numbers, n, local);
                (
                    DVector::from_column_slice(&x[..n]),
                    DVector::from_column_slice(&x[n..]),
                )
            }
        }
    }
}

/// How many numbers a Taylor series of n positions has, its unit of time with them.
fn series_width(order: usize, n: usize) -> usize {
    1 + n * (order + 2)
}

/// Writes Taylor series of n positions, each given by its coefficients, in a unit of time.
pub(crate) fn write_series<C: Iterator<Item = f64>>(
    unit: f64,
    coefficients: impl Fn(usize) -> C,
    n: usize,
    numbers: &mut Vec<f64>,
) {
    numbers.push(unit);
    for i in 0..n {
        let mut power = 1.0;
        for c in coefficients(i) {
            numbers.push(c * power);
            power *= unit;
        }
    }
}

/// Position and velocity a time after the start of Taylor series.
fn read_series(numbers: &[f64], order: usize, local: f64) -> (DVector<f64>, DVector<f64>) {
    let (unit, rows) = (numbers[0], numbers[1..].chunks(order + 2));
    let x = local / unit;
    let (mut q, mut v) = (DVector::zeros(rows.len()), DVector::zeros(rows.len()));
    for (i, row) in rows.enumerate() {
        for c in row.iter().rev() {
            v[i] = v[i] * x + q[i];
            q[i] = q[i] * x + c;
        }
    }
    (q, v / unit)
}
