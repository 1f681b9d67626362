//! The Taylor series of K motions of one pendulum, made at one time in the widest registers.

use crate::flow::registers::in_widest;
use crate::flow::shaking::{Calm, Excitation, Pair, Shaking};
use crate::flow::taylor::{Blocks, Coefficients, Lane, expand};
use pulp::{Simd, WithSimd};

/// Where the series of K motions come from, and the work of making them.
struct Expansion<'a, E, const K: usize> {
    lanes: &'a mut [Lane<K>],
    coefficients: &'a Coefficients,
    inverse: &'a Blocks<Pair<K>>,
    excitation: &'a E,
    angles: &'a [f64; K],
}

impl<E: Shaking, const K: usize> WithSimd for Expansion<'_, E, K> {
    type Output = ();

    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if self.coefficients.damping.0.is_empty() {
            self.expand_by_number::<S, false>();
        } else {
            self.expand_by_number::<S, true>();
        }
    }
}

impl<E: Shaking, const K: usize> Expansion<'_, E, K> {
    /// [`expand`] with the number of lanes known at compile time where it is small.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn expand_by_number<S: Simd, const IS_DAMPED: bool>(self) {
        let (c, inverse, e, at) = (
            self.coefficients,
            self.inverse,
            self.excitation,
            self.angles,
        );
        match self.lanes {
            lanes @ [_] => expand::<S, E, K, IS_DAMPED>(&mut lanes[..1], c, inverse, e, at),
            lanes @ [_, _] => expand::<S, E, K, IS_DAMPED>(&mut lanes[..2], c, inverse, e, at),
            lanes @ [_, _, _] => expand::<S, E, K, IS_DAMPED>(&mut lanes[..3], c, inverse, e, at),
            lanes => expand::<S, E, K, IS_DAMPED>(lanes, c, inverse, e, at),
        }
    }
}

/// The series of K motions of one pendulum at a time.
#[derive(Debug, Clone)]
pub(crate) struct SeriesOf<const K: usize> {
    pub lanes: Vec<Lane<K>>,
    /// The inverses of the mass matrices at the start.
    pub inverse: Blocks<Pair<K>>,
    /// The angles of the forcing at the start.
    pub angles: [f64; K],
}

impl<const K: usize> SeriesOf<K> {
    /// Series of n links, all zero.
    pub fn new(n: usize) -> Self {
        Self {
            lanes: vec![Lane::EMPTY; n.div_ceil(2)],
            inverse: Blocks::zeros(n),
            angles: [0.0; K],
        }
    }

    /// Fills the series, each from its coefficients of order zero, the inverse of its mass matrix and its angle.
    pub fn expand(&mut self, coefficients: &Coefficients, excitation: &Excitation) {
        match excitation {
            Excitation::None => self.expand_shaken(coefficients, &Calm),
            Excitation::Base(base) => self.expand_shaken(coefficients, base),
            Excitation::Forces(forces) => self.expand_shaken(coefficients, forces),
        }
    }

    /// Takes the start of one motion as the m-th here.
    pub fn take_start(&mut self, m: usize, one: &SeriesOf<1>) {
        for (lane, from) in self.lanes.iter_mut().zip(&one.lanes) {
            for i in 0..2 {
                lane.q[0][i][m] = from.q[0][i][0];
                lane.v[0][i][m] = from.v[0][i][0];
                lane.sin[0][i][m] = from.sin[0][i][0];
                lane.cos[0][i][m] = from.cos[0][i][0];
            }
        }
        for (entry, from) in self.inverse.0.iter_mut().zip(&one.inverse.0) {
            for i in 0..2 {
                entry[i][m] = from[i][0];
            }
        }
        self.angles[m] = one.angles[0];
    }

    /// Hands the series of the m-th motion over: what is asked of them once they are made.
    pub fn hand_over(&self, m: usize, order: usize, one: &mut SeriesOf<1>) {
        for (from, lane) in self.lanes.iter().zip(&mut one.lanes) {
            for k in 1..order + 2 {
                for i in 0..2 {
                    lane.q[k][i] = [from.q[k][i][m]];
                    lane.v[k][i] = [from.v[k][i][m]];
                    lane.sin[k][i] = [from.sin[k][i][m]];
                }
            }
        }
    }

    fn expand_shaken<E: Shaking>(&mut self, coefficients: &Coefficients, excitation: &E) {
        in_widest(Expansion {
            lanes: &mut self.lanes,
            coefficients,
            inverse: &self.inverse,
            excitation,
            angles: &self.angles,
        });
    }
}
