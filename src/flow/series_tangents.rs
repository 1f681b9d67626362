//! The Taylor series of the variational equations of a pendulum: of first-order deviations from its motion (theory 8).
//!
//! With `s = sin q`, `c = cos q` the deviations are `ds = c dq` and `dc = -s dq`, products of series. The equations of motion
//! `c_i P_i - s_i Q_i = -(C v)_i + f_i` give `c dP - s dQ = -C dv + R dq`, in which `R = s P + c Q` is of the motion alone, `dP = I ds''`
//! and `dQ = I dc''`: in coefficient k the unknown acceleration appears with the mass matrix at the start, as in the series of the motion.

use crate::flow::registers::{Arithmetic, in_registers_of};
use crate::flow::series_of::SeriesOf;
use crate::flow::taylor::{Lane, MotionCoefficients, RECIPROCALS, ROWS};
use pulp::{Simd, WithSimd};

/// Number of deviations whose series are made together. [work]
pub(crate) const TANGENT_LANES: usize = 4;
/// A number for each of these deviations.
pub(crate) type TangentLanes = [f64; TANGENT_LANES];

const NONE: TangentLanes = [0.0; TANGENT_LANES];

/// The series of deviations along one link: coefficient k is that of `t^k`.
#[derive(Debug, Clone)]
struct LinkTangents {
    q: [TangentLanes; ROWS],
    v: [TangentLanes; ROWS],
    /// Of P and Q of the equations of motion.
    across: [TangentLanes; ROWS],
    along: [TangentLanes; ROWS],
    /// The second derivatives of sine and cosine at the order in work: without the acceleration, then its part alone.
    bent: [TangentLanes; 2],
    /// What drives the acceleration of the order in work.
    rest: TangentLanes,
}

impl LinkTangents {
    const EMPTY: Self = Self {
        q: [NONE; ROWS],
        v: [NONE; ROWS],
        across: [NONE; ROWS],
        along: [NONE; ROWS],
        bent: [NONE; 2],
        rest: NONE,
    };
}

/// The coefficients along one link of the base motion, from which deviations are counted.
#[derive(Debug, Clone)]
struct BaseSeries {
    sin: [f64; ROWS],
    cos: [f64; ROWS],
    /// R, the derivative of the equation of motion by the angle of the link.
    turn: [f64; ROWS],
}

/// The series of groups of deviations from one motion.
#[derive(Debug, Clone)]
pub(crate) struct SeriesTangents {
    /// One after the other, the links of each.
    groups: Vec<LinkTangents>,
    about: Vec<BaseSeries>,
    matrices: Matrices,
}

/// Matrices over the links, row after row.
#[derive(Debug, Clone)]
struct Matrices {
    inertia: Vec<f64>,
    /// Empty without damping.
    damping: Vec<f64>,
    inverse: Vec<f64>,
}

impl SeriesTangents {
    /// Room for so many groups of deviations of n links.
    pub fn new(n: usize, groups: usize, coefficients: &MotionCoefficients) -> Self {
        let lanes = n.div_ceil(2);
        let entries = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let damping = &coefficients.damping;
        let inertia = entries().map(|(i, j)| coefficients.inertia.beside(i, j, lanes)[i % 2]);
        let none = BaseSeries {
            sin: [0.0; ROWS],
            cos: [0.0; ROWS],
            turn: [0.0; ROWS],
        };
        Self {
            groups: vec![LinkTangents::EMPTY; n * groups],
            about: vec![none; n],
            matrices: Matrices {
                inertia: inertia.collect(),
                damping: if damping.0.is_empty() {
                    Vec::new()
                } else {
                    let own = entries().map(|(i, j)| damping.beside(i, j, lanes)[i % 2]);
                    own.collect()
                },
                inverse: vec![0.0; n * n],
            },
        }
    }

    /// Makes the series of deviations from a base motion; `start` gives the position and velocity of each of a group at a link.
    pub fn expand(
        &mut self,
        motion: &SeriesOf<1>,
        start: impl Fn(usize, usize) -> [TangentLanes; 2],
    ) {
        let n = self.about.len();
        for (at, link) in self.groups.iter_mut().enumerate() {
            [link.q[0], link.v[0]] = start(at / n, at % n);
            link.q[1] = link.v[0];
        }
        let lanes = motion.lanes.len();
        for (at, entry) in self.matrices.inverse.iter_mut().enumerate() {
            let (i, j) = (at / n, at % n);
            *entry = motion.inverse.beside(i, j, lanes)[i % 2][0];
        }
        in_registers_of::<TANGENT_LANES, _>(TangentExpansion { of: self, motion });
    }

    /// The deviations of a group a time after the start, up to an order of the velocities: `put` takes the link, the position and velocity of
    /// each.
    pub fn at(
        &self,
        group: usize,
        (time, order): (f64, usize),
        put: impl FnMut(usize, [TangentLanes; 2]),
    ) {
        in_registers_of::<TANGENT_LANES, _>(TangentSums {
            links: self.group(group),
            time,
            order,
            put,
        });
    }

    fn group(&self, group: usize) -> &[LinkTangents] {
        let n = self.about.len();
        &self.groups[group * n..(group + 1) * n]
    }

    /// The largest part that the last two terms of the velocities are of a deviation after a time, whose velocities count for what they
    /// are over that time.
    pub fn last_terms(&self, time: f64, order: usize) -> f64 {
        let power = (1..order).fold(1.0, |power, _| power * time);
        let of_group = |links: &[LinkTangents]| {
            let largest = |of: &dyn Fn(&LinkTangents) -> TangentLanes| {
                links.iter().fold(NONE, |most, link| {
                    let own = of(link);
                    std::array::from_fn(|m| f64::max(most[m], own[m].abs()))
                })
            };
            let (q, v) = (largest(&|link| link.q[0]), largest(&|link| link.v[0]));
            let last = largest(&|link| link.v[order]);
            let early = largest(&|link| link.v[order - 1]);
            let part = |m: usize| {
                let size = q[m].max(time * v[m]);
                let term = time * power * early[m].max(time * last[m]);
                if size > 0.0 { term / size } else { 0.0 }
            };
            (0..TANGENT_LANES).map(part).fold(0.0, f64::max)
        };
        let groups = self.groups.chunks(self.about.len());
        groups.map(of_group).fold(0.0, f64::max)
    }
}

/// The work of making the series of deviations from a base motion.
struct TangentExpansion<'a> {
    of: &'a mut SeriesTangents,
    motion: &'a SeriesOf<1>,
}

impl WithSimd for TangentExpansion<'_> {
    type Output = ();

    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { of, motion } = self;
        for (i, about) in of.about.iter_mut().enumerate() {
            about.take::<S>(&motion.lanes[i / 2], i % 2, motion.order);
        }
        let (order, matrices) = (motion.order, &of.matrices);
        for links in of.groups.chunks_mut(of.about.len()) {
            match (links, &of.about[..]) {
                ([a], [b]) => expand::<S>(
                    std::array::from_mut(a),
                    std::array::from_ref(b),
                    matrices,
                    order,
                ),
                (links @ [_, _], about @ [_, _]) => {
                    expand::<S>(&mut links[..2], &about[..2], matrices, order);
                }
                (links @ [_, _, _], about @ [_, _, _]) => {
                    expand::<S>(&mut links[..3], &about[..3], matrices, order);
                }
                (links, about) => expand::<S>(links, about, matrices, order),
            }
        }
    }
}

/// Positions and velocities of a group at a time.
struct TangentSums<'a, P> {
    links: &'a [LinkTangents],
    time: f64,
    order: usize,
    put: P,
}

impl<P: FnMut(usize, [TangentLanes; 2])> WithSimd for TangentSums<'_, P> {
    type Output = ();

    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _: S) {
        for (i, link) in self.links.iter().enumerate() {
            let (mut at, mut rate) = (link.q[self.order + 1], NONE);
            let rows = link.q[..=self.order].iter().zip(&link.v[..=self.order]);
            for (q, v) in rows.rev() {
                at = plus::<S>(*q, self.time, &at);
                rate = plus::<S>(*v, self.time, &rate);
            }
            (self.put)(i, [at, rate]);
        }
    }
}

impl BaseSeries {
    /// Takes the coefficients along one link of a lane.
    #[allow(clippy::inline_always, reason = "a part of the series")]
    #[inline(always)]
    fn take<A: Arithmetic>(&mut self, lane: &Lane<1>, i: usize, order: usize) {
        for k in 0..ROWS {
            (self.sin[k], self.cos[k]) = (lane.sin[k][i][0], lane.cos[k][i][0]);
        }
        // Orders below zero come first.
        let (mut across, mut along) = ([0.0; TANGENT_LANES + ROWS], [0.0; TANGENT_LANES + ROWS]);
        for k in 0..order {
            across[TANGENT_LANES + k] = lane.across[k][i][0];
            along[TANGENT_LANES + k] = lane.along[k][i][0];
        }
        // Several orders at once.
        for first in (0..order).step_by(TANGENT_LANES) {
            let (mut of_sin, mut of_cos) = (NONE, NONE);
            for j in 0..first + TANGENT_LANES {
                let back = first + TANGENT_LANES - j;
                let rows = (across[back..].first_chunk(), along[back..].first_chunk());
                if let (Some(across), Some(along)) = rows {
                    of_sin = plus::<A>(of_sin, self.sin[j], across);
                    of_cos = plus::<A>(of_cos, self.cos[j], along);
                }
            }
            for m in 0..TANGENT_LANES {
                self.turn[first + m] = of_sin[m] + of_cos[m];
            }
        }
    }
}

/// A number for each of the deviations of a group, from its place in the group.
#[allow(clippy::inline_always, reason = "a part of the innermost loop")]
#[inline(always)]
fn each(of: impl Fn(usize) -> f64) -> TangentLanes {
    let mut all = NONE;
    for (m, x) in all.iter_mut().enumerate() {
        *x = of(m);
    }
    all
}

/// `sum + a x`
#[allow(clippy::inline_always, reason = "a part of the innermost loop")]
#[inline(always)]
fn plus<A: Arithmetic>(sum: TangentLanes, a: f64, x: &TangentLanes) -> TangentLanes {
    each(|m| A::add_product(a, x[m], sum[m]))
}

/// A row of a matrix times what the links have.
#[allow(clippy::inline_always, reason = "a part of the innermost loop")]
#[inline(always)]
fn product<A: Arithmetic>(
    row: &[f64],
    links: &[LinkTangents],
    of: impl Fn(&LinkTangents) -> &TangentLanes,
) -> TangentLanes {
    let mut sum = NONE;
    for j in 0..row.len() {
        sum = plus::<A>(sum, row[j], of(&links[j]));
    }
    sum
}

/// Fills the series of one group.
#[allow(
    clippy::inline_always,
    reason = "the loops over links are written out where their number is known"
)]
#[inline(always)]
fn expand<A: Arithmetic>(
    links: &mut [LinkTangents],
    about: &[BaseSeries],
    matrices: &Matrices,
    order: usize,
) {
    let n = about.len();
    let row = |i: usize| i * n..(i + 1) * n;
    for k in 0..order {
        for (link, about) in links.iter_mut().zip(about) {
            link.raise::<A>(about, k);
        }
        for i in 0..n {
            let across = product::<A>(&matrices.inertia[row(i)], links, |link| &link.bent[0]);
            let along = product::<A>(&matrices.inertia[row(i)], links, |link| &link.bent[1]);
            let mut rest = plus::<A>(links[i].rest, -about[i].cos[0], &across);
            rest = plus::<A>(rest, about[i].sin[0], &along);
            if !matrices.damping.is_empty() {
                rest = plus::<A>(
                    rest,
                    -1.0,
                    &product::<A>(&matrices.damping[row(i)], links, |link| &link.v[k]),
                );
            }
            let link = &mut links[i];
            (link.across[k], link.along[k], link.rest) = (across, along, rest);
        }
        for i in 0..n {
            let acceleration = product::<A>(&matrices.inverse[row(i)], links, |link| &link.rest);
            let link = &mut links[i];
            link.bent = [
                each(|m| about[i].cos[0] * acceleration[m]),
                each(|m| -about[i].sin[0] * acceleration[m]),
            ];
            link.v[k + 1] = each(|m| acceleration[m] * RECIPROCALS[k + 1]);
            link.q[k + 2] = each(|m| link.v[k + 1][m] * RECIPROCALS[k + 2]);
        }
        for i in 0..n {
            let across = product::<A>(&matrices.inertia[row(i)], links, |link| &link.bent[0]);
            let along = product::<A>(&matrices.inertia[row(i)], links, |link| &link.bent[1]);
            let link = &mut links[i];
            link.across[k] = plus::<A>(link.across[k], 1.0, &across);
            link.along[k] = plus::<A>(link.along[k], 1.0, &along);
        }
    }
}

impl LinkTangents {
    /// The parts that do not need the accelerations of order k: the second derivatives of the sine and cosine, and of what is left of the
    /// equations of motion all but those with the deviations of P, Q and the velocity of order k.
    #[allow(clippy::inline_always, reason = "the innermost loop of the series")]
    #[inline(always)]
    fn raise<A: Arithmetic>(&mut self, about: &BaseSeries, k: usize) {
        let (c, s, r) = (&about.cos[..k + 3], &about.sin[..k + 3], &about.turn[..=k]);
        let (own, next) = (&self.q[..=k], &self.q[2..k + 2]);
        let (across, along) = (&self.across[..k], &self.along[..k]);
        // TangentSums of their own, none of which waits for another.
        let [mut sin, mut cos, mut of_turn, mut of_across, mut of_along] = [NONE; 5];
        for j in 0..k {
            let back = k - j;
            sin = plus::<A>(sin, c[back], &next[j]);
            cos = plus::<A>(cos, s[back], &next[j]);
            of_turn = plus::<A>(of_turn, r[back], &own[j]);
            of_across = plus::<A>(of_across, c[back], &across[j]);
            of_along = plus::<A>(of_along, s[back], &along[j]);
        }
        for j in 0..2 {
            sin = plus::<A>(sin, c[k + 2 - j], &self.q[j]);
            cos = plus::<A>(cos, s[k + 2 - j], &self.q[j]);
        }
        of_turn = plus::<A>(of_turn, r[0], &own[k]);
        self.rest = each(|m| of_turn[m] + (of_along[m] - of_across[m]));
        let both = ((k + 1) * (k + 2)) as f64;
        self.bent = [each(|m| both * sin[m]), each(|m| -both * cos[m])];
    }
}
