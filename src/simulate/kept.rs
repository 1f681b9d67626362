//! A motion as it is kept: pieces that follow each other in time, grouped in segments, and for each piece the numbers from
//! which it can be had at any of its times.

use crate::flow::steps::dense_output::{written_state, written_width};
use crate::flow::{
    ConstrainedMotion, ModalScene, SceneFlow, carry, read_series, series_width, with_flow,
};
use crate::hybrid::SegmentKind;
use crate::hybrid::clock::Clock;
use crate::modal::Pair;
use nalgebra::DVector;
use std::sync::Arc;

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
    /// Steps: the numbers are the step's length and its dense output, polynomials of a degree.
    Steps { degree: usize },
    /// Taylor series of the velocities to an order: the numbers are the unit of time and the coefficients of the positions
    /// in it, one after the other for each. Chatter and lasting contact are Runge-Kutta steps.
    Series { order: usize },
}

/// Degree of the steps beside series.
const QUARTIC: usize = 4;

impl Machinery {
    /// How many numbers a piece of a segment has for n degrees of freedom.
    pub fn width(&self, kind: SegmentKind, n: usize) -> usize {
        match self {
            Self::Exact { .. } => 2 * n,
            Self::Series { order } if kind == SegmentKind::Flight => series_width(*order, n),
            Self::Steps { degree } => written_width(*degree, n),
            Self::Series { .. } => written_width(QUARTIC, n),
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
            Self::Steps { degree } => parted(&written_state(numbers, *degree, local)),
            Self::Series { .. } => parted(&written_state(numbers, QUARTIC, local)),
        }
    }
}

/// Position and velocity of a state.
fn parted(x: &[f64]) -> (DVector<f64>, DVector<f64>) {
    let (q, v) = x.split_at(x.len() / 2);
    (DVector::from_column_slice(q), DVector::from_column_slice(v))
}
