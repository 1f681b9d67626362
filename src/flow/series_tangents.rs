//! What deviations of its start make of the Taylor series of a pendulum's motion: the series of the linearised equations (theory 8).
//!
//! With `s = sin q`, `c = cos q` the deviations are `ds = c dq` and `dc = -s dq`, products of series. The equations of motion
//! `c_i P_i - s_i Q_i = -(C v)_i + f_i` give `c dP - s dQ = -C dv - dc P + ds Q`, in which `dP = I ds''` and `dQ = I dc''`: in
//! coefficient k the unknown acceleration appears with the mass matrix at the start, as in the series of the motion.

use crate::flow::registers::{Arithmetic, in_registers_of};
use crate::flow::series_forcing::LinkPair;
use crate::flow::series_of::SeriesOf;
use crate::flow::taylor::{Lane, MotionCoefficients, RECIPROCALS, ROWS};
use pulp::{Simd, WithSimd};

/// Deviations whose series are made together.
pub(crate) const ABREAST: usize = 4;
/// The numbers of those.
pub(crate) type Abreast = [f64; ABREAST];

/// The series of deviations along one link: coefficient k is that of `t^k`.
#[derive(Debug, Clone)]
struct LinkTangents {
    q: [Abreast; ROWS],
    v: [Abreast; ROWS],
    sin: [Abreast; ROWS],
    cos: [Abreast; ROWS],
    across: [Abreast; ROWS],
    along: [Abreast; ROWS],
    /// What drives the acceleration of the order in work.
    rest: Abreast,
}

impl LinkTangents {
    const EMPTY: Self = Self {
        q: [[0.0; ABREAST]; ROWS],
        v: [[0.0; ABREAST]; ROWS],
        sin: [[0.0; ABREAST]; ROWS],
        cos: [[0.0; ABREAST]; ROWS],
        across: [[0.0; ABREAST]; ROWS],
        along: [[0.0; ABREAST]; ROWS],
        rest: [0.0; ABREAST],
    };
}

/// The series of deviations from one motion.
#[derive(Debug, Clone)]
pub(crate) struct SeriesTangents {
    links: Vec<LinkTangents>,
}

impl SeriesTangents {
    /// Room for deviations of n links.
    pub fn new(n: usize) -> Self {
        Self {
            links: vec![LinkTangents::EMPTY; n],
        }
    }

    /// Makes the series of deviations about a motion; `start` gives the position and velocity of each at a link.
    pub fn expand(
        &mut self,
        about: &SeriesOf<1>,
        coefficients: &MotionCoefficients,
        start: impl Fn(usize) -> [Abreast; 2],
    ) {
        for (i, link) in self.links.iter_mut().enumerate() {
            [link.q[0], link.v[0]] = start(i);
        }
        in_registers_of::<ABREAST, _>(Expansion {
            links: &mut self.links,
            about,
            coefficients,
        });
    }

    /// The deviations a time after the start: the position and velocity of each at a link.
    pub fn at(&self, link: usize, time: f64, order: usize) -> [Abreast; 2] {
        let sum = |rows: &[Abreast]| {
            rows.iter().rev().fold([0.0; ABREAST], |sum, row| {
                std::array::from_fn(|m| sum[m] * time + row[m])
            })
        };
        let own = &self.links[link];
        [sum(&own.q[..=order + 1]), sum(&own.v[..=order])]
    }

    /// The largest part that the last two terms of the velocities are of a deviation after a time, whose velocities count for what they
    /// are over that time.
    pub fn last_terms(&self, time: f64, order: usize) -> f64 {
        let largest = |of: &dyn Fn(&LinkTangents) -> Abreast| {
            self.links.iter().fold([0.0f64; ABREAST], |most, link| {
                let own = of(link);
                std::array::from_fn(|m| most[m].max(own[m].abs()))
            })
        };
        let (q, v) = (largest(&|link| link.q[0]), largest(&|link| link.v[0]));
        let last = largest(&|link| link.v[order]);
        let early = largest(&|link| link.v[order - 1]);
        let power = (1..order).fold(1.0, |power, _| power * time);
        let part = |m: usize| {
            let size = q[m].max(time * v[m]);
            let term = time * power * early[m].max(time * last[m]);
            if size > 0.0 { term / size } else { 0.0 }
        };
        (0..ABREAST).map(part).fold(0.0, f64::max)
    }
}

/// Deviations, the motion that they are about, and what does not change.
struct Expansion<'a> {
    links: &'a mut [LinkTangents],
    about: &'a SeriesOf<1>,
    coefficients: &'a MotionCoefficients,
}

/// The coefficients along one link of the motion that deviations are about.
struct About {
    sin: [f64; ROWS],
    cos: [f64; ROWS],
    across: [f64; ROWS],
    along: [f64; ROWS],
}

impl About {
    fn new(lane: &Lane<1>, i: usize) -> Self {
        let rows = |of: &[LinkPair<1>; ROWS]| of.map(|row| row[i][0]);
        Self {
            sin: rows(&lane.sin),
            cos: rows(&lane.cos),
            across: rows(&lane.across),
            along: rows(&lane.along),
        }
    }
}

impl WithSimd for Expansion<'_> {
    type Output = ();

    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) {
        let lanes = &self.about.lanes;
        let about = (0..self.links.len()).map(|i| About::new(&lanes[i / 2], i % 2));
        let about: Vec<About> = about.collect();
        for (link, about) in self.links.iter_mut().zip(&about) {
            link.begin::<S>(about);
        }
        for k in 0..self.coefficients.order {
            for (link, about) in self.links.iter_mut().zip(&about) {
                link.raise::<S>(about, k);
            }
            self.accelerate::<S>(k);
        }
    }
}

/// `sum + a x`
#[allow(clippy::inline_always, reason = "a part of the innermost loop")]
#[inline(always)]
fn plus<A: Arithmetic>(sum: Abreast, a: f64, x: &Abreast) -> Abreast {
    std::array::from_fn(|m| A::add_product(a, x[m], sum[m]))
}

impl LinkTangents {
    /// The first two orders of the sine and cosine.
    #[allow(clippy::inline_always, reason = "a part of the series")]
    #[inline(always)]
    fn begin<A: Arithmetic>(&mut self, about: &About) {
        let (none, [sin, cos]) = ([0.0; ABREAST], [about.sin, about.cos]);
        self.q[1] = self.v[0];
        self.sin[0] = plus::<A>(none, cos[0], &self.q[0]);
        self.cos[0] = plus::<A>(none, -sin[0], &self.q[0]);
        self.sin[1] = plus::<A>(plus::<A>(none, cos[1], &self.q[0]), cos[0], &self.q[1]);
        self.cos[1] = plus::<A>(plus::<A>(none, -sin[1], &self.q[0]), -sin[0], &self.q[1]);
    }

    /// The parts that do not need the accelerations of order k: of the sine and cosine two orders on, and of what is left of the
    /// equations of motion all but those with the deviations of P, Q and the velocity of order k.
    #[allow(clippy::inline_always, reason = "the innermost loop of the series")]
    #[inline(always)]
    fn raise<A: Arithmetic>(&mut self, about: &About, k: usize) {
        let (c, s) = (&about.cos[..k + 3], &about.sin[..k + 3]);
        let (p, q) = (&about.across[..=k], &about.along[..=k]);
        let (own, sines, cosines) = (&self.q[..k + 2], &self.sin[..=k], &self.cos[..=k]);
        let (across, along) = (&self.across[..k], &self.along[..k]);
        // Sums of their own, none of which waits for another.
        let [
            mut sin,
            mut cos,
            mut of_cos,
            mut of_sin,
            mut of_across,
            mut of_along,
        ] = [[0.0; ABREAST]; 6];
        for j in 0..k {
            let back = k - j;
            sin = plus::<A>(sin, c[back + 2], &own[j]);
            cos = plus::<A>(cos, s[back + 2], &own[j]);
            of_cos = plus::<A>(of_cos, p[back], &cosines[j]);
            of_sin = plus::<A>(of_sin, q[back], &sines[j]);
            of_across = plus::<A>(of_across, c[back], &across[j]);
            of_along = plus::<A>(of_along, s[back], &along[j]);
        }
        for j in k..k + 2 {
            sin = plus::<A>(sin, c[k + 2 - j], &own[j]);
            cos = plus::<A>(cos, s[k + 2 - j], &own[j]);
        }
        of_cos = plus::<A>(of_cos, p[0], &cosines[k]);
        of_sin = plus::<A>(of_sin, q[0], &sines[k]);
        self.rest = std::array::from_fn(|m| (of_sin[m] - of_cos[m]) + (of_along[m] - of_across[m]));
        (self.sin[k + 2], self.cos[k + 2]) = (sin, cos.map(|x| -x));
    }
}

impl Expansion<'_> {
    /// The accelerations of order k, and what follows from them.
    #[allow(clippy::inline_always, reason = "the innermost loop of the series")]
    #[inline(always)]
    fn accelerate<A: Arithmetic>(&mut self, k: usize) {
        let Self {
            links,
            about,
            coefficients,
        } = self;
        let (n, lanes) = (links.len(), about.lanes.len());
        let inertia = |i: usize, j: usize| coefficients.inertia.beside(i, j, lanes)[i % 2];
        let both = ((k + 1) * (k + 2)) as f64;
        let summed =
            |links: &[LinkTangents], i: usize, of: fn(&LinkTangents) -> &[Abreast; ROWS]| {
                let each = links.iter().enumerate();
                each.fold([0.0; ABREAST], |sum, (j, link)| {
                    plus::<A>(sum, both * inertia(i, j), &of(link)[k + 2])
                })
            };
        for i in 0..n {
            let (lane, own) = (&about.lanes[i / 2], i % 2);
            let (sin, cos) = (lane.sin[0][own][0], lane.cos[0][own][0]);
            let mut rest = plus::<A>(links[i].rest, -cos, &summed(links, i, |link| &link.sin));
            rest = plus::<A>(rest, sin, &summed(links, i, |link| &link.cos));
            if !coefficients.damping.0.is_empty() {
                for (j, link) in links.iter().enumerate() {
                    let entry = coefficients.damping.beside(i, j, lanes)[own];
                    rest = plus::<A>(rest, -entry, &link.v[k]);
                }
            }
            links[i].rest = rest;
        }
        for i in 0..n {
            let (lane, own) = (&about.lanes[i / 2], i % 2);
            let each = links.iter().enumerate();
            let acceleration = each.fold([0.0; ABREAST], |sum, (j, link)| {
                plus::<A>(sum, about.inverse.beside(i, j, lanes)[own][0], &link.rest)
            });
            let (sin, cos, link) = (lane.sin[0][own][0], lane.cos[0][own][0], &mut links[i]);
            link.v[k + 1] = acceleration.map(|a| a * RECIPROCALS[k + 1]);
            link.q[k + 2] = link.v[k + 1].map(|v| v * RECIPROCALS[k + 2]);
            link.sin[k + 2] = plus::<A>(link.sin[k + 2], cos, &link.q[k + 2]);
            link.cos[k + 2] = plus::<A>(link.cos[k + 2], -sin, &link.q[k + 2]);
        }
        for i in 0..n {
            links[i].across[k] = summed(links, i, |link| &link.sin);
            links[i].along[k] = summed(links, i, |link| &link.cos);
        }
    }
}
