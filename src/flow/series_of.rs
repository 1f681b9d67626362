//! The Taylor series of K motions of one pendulum, made at one time in the widest registers: how far each reaches, and the
//! states along them (theory 8).

use crate::flow::registers::{Arithmetic, in_registers_of};
use crate::flow::series_forcing::{
    LinkPair, NoForcing, PendulumForcing, SeriesForcing, Shaken, ShakenSeries, each,
};
use crate::flow::steps::Tolerance;
use crate::flow::taylor::{Blocks, Lane, MotionCoefficients, expand};
use pulp::{Simd, WithSimd};

/// The work of making the series of K motions from their inputs.
struct SeriesExpansion<'a, E, const K: usize> {
    lanes: &'a mut [Lane<K>],
    coefficients: &'a MotionCoefficients,
    inverse: &'a Blocks<LinkPair<K>>,
    excitation: &'a E,
    angles: &'a [f64; K],
}

impl<E: SeriesForcing<K>, const K: usize> WithSimd for SeriesExpansion<'_, E, K> {
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

impl<E: SeriesForcing<K>, const K: usize> SeriesExpansion<'_, E, K> {
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
    pub inverse: Blocks<LinkPair<K>>,
    /// The angles of the forcing at the start.
    pub angles: [f64; K],
    /// What shakes them, where that is more than one harmonic.
    pub shaken: ShakenSeries<K>,
    /// Order of the velocities; the positions have one more.
    pub order: usize,
    /// Room for a mass matrix by rows and a column, shape `(n (n + 1),)`, \[kg m^2\] for n links.
    pub scratch: Vec<f64>,
}

impl<const K: usize> SeriesOf<K> {
    /// Series of n links, all zero.
    pub fn new(n: usize, order: usize) -> Self {
        Self {
            lanes: vec![Lane::EMPTY; n.div_ceil(2)],
            inverse: Blocks::zeros(n),
            angles: [0.0; K],
            shaken: ShakenSeries::default(),
            order,
            scratch: vec![0.0; n * (n + 1)],
        }
    }

    /// Fills the series, each from its coefficients of order zero, the inverse of its mass matrix and its angle.
    pub fn expand(&mut self, coefficients: &MotionCoefficients, shake: &PendulumForcing) {
        let Self {
            lanes,
            inverse,
            angles,
            shaken,
            ..
        } = self;
        let about = (&mut lanes[..], coefficients, &*inverse, &*angles);
        match shake {
            PendulumForcing::None => expand_shaken(about, &NoForcing),
            PendulumForcing::Base(base) => expand_shaken(about, base),
            PendulumForcing::Forces(forces) => expand_shaken(about, forces),
            PendulumForcing::Any(forcing) => {
                let series = &*shaken;
                expand_shaken(about, &Shaken { forcing, series });
            }
        }
    }

    /// One of the motions.
    pub fn motion(&self, m: usize) -> BatchMotion<'_, K> {
        BatchMotion { of: self, m }
    }

    /// The state of each motion a time of its own after its start: `put` takes the link, the motion, its position and velocity.
    pub fn states(&self, times: &[f64; K], mut put: impl FnMut(usize, usize, [f64; 2])) {
        for (r, lane) in self.lanes.iter().enumerate() {
            let (rows, rates) = (&lane.q[..=self.order + 1], &lane.v[..=self.order]);
            let [q, v] = in_registers_of::<K, _>(BatchSums { rows, rates, times });
            for i in 0..2 {
                for m in 0..K {
                    put(2 * r + i, m, [q[i][m], v[i][m]]);
                }
            }
        }
    }
}

/// The inputs of K series: their lanes with the coefficients of order zero, the constant coefficients, the inverses of the mass matrices, the
/// angles of the forcing.
type SeriesInputs<'a, const K: usize> = (
    &'a mut [Lane<K>],
    &'a MotionCoefficients,
    &'a Blocks<LinkPair<K>>,
    &'a [f64; K],
);

fn expand_shaken<E: SeriesForcing<K>, const K: usize>(
    (lanes, coefficients, inverse, angles): SeriesInputs<'_, K>,
    excitation: &E,
) {
    in_registers_of::<K, _>(SeriesExpansion {
        lanes,
        coefficients,
        inverse,
        excitation,
        angles,
    });
}

impl SeriesOf<1> {
    /// The state of the one motion a time after its start.
    pub fn state(&self, time: f64, x: &mut [f64]) {
        let n = x.len() / 2;
        self.states(&[time], |link, _, state| {
            if link < n {
                [x[link], x[n + link]] = state;
            }
        });
    }
}

/// One motion of several whose series are made together.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BatchMotion<'a, const K: usize> {
    of: &'a SeriesOf<K>,
    m: usize,
}

impl<'a, const K: usize> BatchMotion<'a, K> {
    /// Order of the velocities; the positions have one more.
    pub fn order(self) -> usize {
        self.of.order
    }

    /// The coefficients of a link's angle.
    #[inline]
    pub fn angle(self, link: usize) -> impl Iterator<Item = f64> + 'a {
        self.coefficients(link, |lane| &lane.q)
    }

    /// The coefficients of the sine of a link's angle.
    #[inline]
    pub fn sine(self, link: usize) -> impl Iterator<Item = f64> + 'a {
        self.coefficients(link, |lane| &lane.sin)
    }

    #[inline]
    fn coefficients(
        self,
        link: usize,
        of: impl Fn(&'a Lane<K>) -> &'a [LinkPair<K>],
    ) -> impl Iterator<Item = f64> + 'a {
        let rows = &of(&self.of.lanes[link / 2])[..self.of.order + 2];
        rows.iter().map(move |row| row[link % 2][self.m])
    }

    /// The largest of some numbers of the links; one that is not a number counts as such.
    pub fn largest(self, of: impl Fn(&Lane<K>) -> &LinkPair<K>) -> f64 {
        let all = self.of.lanes.iter().flat_map(|lane| of(lane).iter());
        all.map(|link| link[self.m]).fold(0.0, |most, x| {
            if x.abs() > most || x.is_nan() {
                x.abs()
            } else {
                most
            }
        })
    }

    /// The longest step whose last two terms are below the tolerance; `before` is the length of a step nearby, if one is
    /// known. Not a number where the series overflows, infinite where it has no such terms.
    pub fn longest_step(self, tolerance: Tolerance, before: Option<f64>) -> f64 {
        let p = self.order();
        let [q, v, a] = [
            self.largest(|lane| &lane.q[0]),
            self.largest(|lane| &lane.v[0]),
            self.largest(|lane| &lane.v[1]),
        ];
        let [early, late] = [p - 1, p].map(|k| self.largest(|lane| &lane.v[k]));
        if !(early + late).is_finite() {
            return f64::NAN;
        }
        let radius = || {
            let by_term = |k: usize, term: f64| {
                (v / term)
                    .powf(1.0 / k as f64)
                    .max((a / term).powf(1.0 / (k - 1) as f64))
            };
            by_term(p - 1, early).min(by_term(p, late))
        };
        let unit = before.unwrap_or_else(radius).min(f64::MAX);
        let size = |x: f64, rate: f64| tolerance.absolute + tolerance.relative * x.max(unit * rate);
        let (of_q, of_v) = (size(q, v), size(v, a));
        let step = |k: usize, term: f64| {
            let allowed = of_v.min(of_q * (k + 1) as f64 / unit);
            (allowed / term).ln() / k as f64
        };
        step(p - 1, early).min(step(p, late)).exp()
    }
}

/// Two polynomials of two links in each of K motions, at a time of each; the first has no fewer rows than the second.
struct BatchSums<'a, const K: usize> {
    rows: &'a [LinkPair<K>],
    rates: &'a [LinkPair<K>],
    times: &'a [f64; K],
}

impl<const K: usize> WithSimd for BatchSums<'_, K> {
    type Output = [LinkPair<K>; 2];

    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [LinkPair<K>; 2] {
        let raise = |sum: &mut LinkPair<K>, row: &LinkPair<K>| {
            *sum = each(|i, m| S::add_product(sum[i][m], self.times[m], row[i][m]));
        };
        let (rows, higher) = self.rows.split_at(self.rates.len());
        let (mut at, mut rate) = ([[0.0; K]; 2], [[0.0; K]; 2]);
        for row in higher.iter().rev() {
            raise(&mut at, row);
        }
        for (row, change) in rows.iter().zip(self.rates).rev() {
            raise(&mut at, row);
            raise(&mut rate, change);
        }
        [at, rate]
    }
}
