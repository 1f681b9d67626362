//! The motion along a flight that is integrated, piece by piece: steps, or Taylor series where the scene has them.

use super::series_flow::SeriesPiece;
use crate::flow::integrate::KeptStep;
use crate::flow::steps::{DenseOutput, DormandPrince, Stepper};
use crate::hybrid::recorder::Written;
use nalgebra::DVector;

/// The method of the flights of an orbit.
pub(super) type OrbitMethod = DormandPrince<Vec<f64>>;
/// A step of it.
pub(crate) type OrbitStep = KeptStep<OrbitDense>;
/// The motion on it.
pub(crate) type OrbitDense = <OrbitMethod as Stepper<Vec<f64>>>::Dense;

/// The pieces of a flight.
#[derive(Debug, Clone)]
pub(crate) enum FlightPieces {
    Steps(Vec<OrbitStep>),
    Series(Vec<SeriesPiece>),
}

impl FlightPieces {
    /// The straight line between two states as one step.
    pub fn line(h: f64, start: &DVector<f64>, end: &DVector<f64>) -> Self {
        let [x, y] = [start, end].map(|state| state.iter().copied().collect());
        let dense = OrbitDense::line(&x, &y, h);
        let start = 0.0;
        Self::Steps(vec![OrbitStep { start, h, dense }])
    }

    /// How many there are.
    fn len(&self) -> usize {
        match self {
            Self::Steps(steps) => steps.len(),
            Self::Series(pieces) => pieces.len(),
        }
    }

    /// The start of a piece, counted from that of the flight, and its length.
    fn span(&self, piece: usize) -> [f64; 2] {
        match self {
            Self::Steps(steps) => [steps[piece].start, steps[piece].h],
            Self::Series(pieces) => [pieces[piece].start, pieces[piece].h],
        }
    }

    /// The state a time after the start of a piece.
    fn state(&self, piece: usize, local: f64) -> Vec<f64> {
        match self {
            Self::Steps(steps) => steps[piece].dense.at(local),
            Self::Series(pieces) => pieces[piece].state(local),
        }
    }

    /// The times at which pieces begin, counted from the start of the flight, with the states there.
    pub fn starts(&self) -> impl Iterator<Item = (f64, Vec<f64>)> {
        (0..self.len()).map(|piece| (self.span(piece)[0], self.state(piece, 0.0)))
    }

    /// The end of the flight, counted from its start, with the state there; none of a flight of no length.
    pub fn end(&self) -> Option<(f64, Vec<f64>)> {
        let last = self.len().checked_sub(1)?;
        let [start, h] = self.span(last);
        Some((start + h, self.state(last, h)))
    }

    /// The arcs that the pieces are: where each begins, counted from the start of the flight, how long it is, and its numbers.
    pub fn arcs(&self) -> impl Iterator<Item = ([f64; 2], Box<dyn Written + '_>)> {
        (0..self.len()).map(|piece| {
            let numbers: Box<dyn Written> = match self {
                Self::Steps(steps) => Box::new(steps[piece].dense.clone()),
                Self::Series(pieces) => Box::new(pieces[piece].arc()),
            };
            (self.span(piece), numbers)
        })
    }
}
