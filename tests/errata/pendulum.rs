//! Equations (1) to (3): the pendulum in physical and in dimensionless units, judged by its energies.

use crate::{STEP, fails, holds};
use nalgebra::Complex;
use vibroimpact::{DoublePendulum, PendulumChain};

/// Complex, for derivatives by a complex step.
type Number = Complex<f64>;

/// Masses, lengths, joint dampers, gravity, amplitude and frequency of the base, in SI units.
struct Pendulum {
    m: [f64; 2],
    l: [f64; 2],
    c: [f64; 2],
    g: f64,
    amplitude: f64,
    frequency: f64,
}

/// Time, angles, angular velocities, angular accelerations.
#[derive(Clone, Copy)]
struct Instant {
    t: f64,
    q: [f64; 2],
    v: [f64; 2],
    a: [f64; 2],
}

const PENDULUM: Pendulum = Pendulum {
    m: [1.3, 0.7],
    l: [0.8, 0.5],
    c: [0.4, 0.6],
    g: 9.81,
    amplitude: 0.2,
    frequency: 3.0,
};
/// Any instant will do: the residuals are compared off the motion.
const INSTANT: Instant = Instant {
    t: 0.3,
    q: [0.4, -0.7],
    v: [1.1, 0.6],
    a: [-0.5, 0.9],
};

/// Kinetic energy, written from the velocities of the bobs.
fn kinetic(p: &Pendulum, t: Number, q: [Number; 2], v: [Number; 2]) -> Number {
    let mut along = -(t * p.frequency).sin() * (p.amplitude * p.frequency);
    let (mut up, mut energy) = (Number::ZERO, Number::ZERO);
    for i in 0..2 {
        along += v[i] * q[i].cos() * p.l[i];
        up += v[i] * q[i].sin() * p.l[i];
        energy += (along * along + up * up) * (0.5 * p.m[i]);
    }
    energy
}

/// Potential energy, written from the heights of the bobs.
fn potential(p: &Pendulum, q: [Number; 2]) -> Number {
    let upper = -q[0].cos() * p.l[0];
    let lower = upper - q[1].cos() * p.l[1];
    (upper * p.m[0] + lower * p.m[1]) * p.g
}

/// Lagrange's equation `i`, `d/dt dL/dv - dL/dq + dD/dv`, from the energies and Rayleigh's function `D` alone.
fn lagrange(p: &Pendulum, s: &Instant, i: usize) -> f64 {
    let step = |x: f64, rate: f64| Complex::new(x, STEP * rate);
    let momentum = |t, q, v: [Number; 2]| {
        let (mut up, mut down) = (v, v);
        up[i] += 1.0;
        down[i] -= 1.0;
        (kinetic(p, t, q, up) - kinetic(p, t, q, down)) * 0.5 // exact: quadratic in v
    };
    let along = [0, 1].map(|j| step(s.q[j], s.v[j]));
    let rate = momentum(step(s.t, 1.0), along, [0, 1].map(|j| step(s.v[j], s.a[j]))).im / STEP;
    let one = |j: usize| if j == i { 1.0 } else { 0.0 };
    let moved = [0, 1].map(|j| step(s.q[j], one(j)));
    let lagrangian = kinetic(p, s.t.into(), moved, s.v.map(Complex::from)) - potential(p, moved);
    let [v1, v2] = [0, 1].map(|j| step(s.v[j], one(j)));
    let dissipation = (v1 * v1 * p.c[0] + (v2 - v1) * (v2 - v1) * p.c[1]) * 0.5;
    rate - lagrangian.im / STEP + dissipation.im / STEP
}

/// Left minus right side of the lower row of (1), with the length that multiplies `m2 g sin(theta2)`.
fn lower_row(p: &Pendulum, s: &Instant, length: f64) -> f64 {
    let (m, [l1, l2], d) = (p.m[1], p.l, s.q[0] - s.q[1]);
    let push = p.amplitude * p.frequency.powi(2) * (p.frequency * s.t).cos();
    m * l2 * l2 * s.a[1]
        + m * l1 * l2 * (s.a[0] * d.cos() - s.v[0] * s.v[0] * d.sin())
        + m * p.g * length * s.q[1].sin()
        - m * l2 * push * s.q[1].cos()
        - p.c[1] * (s.v[0] - s.v[1])
}

fn lower_row_printed(p: &Pendulum, s: &Instant) -> f64 {
    lower_row(p, s, p.l[0])
}

fn lower_row_corrected(p: &Pendulum, s: &Instant) -> f64 {
    lower_row(p, s, p.l[1])
}

/// Equation (1), lower row: the weight of the lower bob acts on `l2`, not on `l1`. Judge: Lagrange's equation.
#[test]
fn equation_1_weight_of_the_lower_bob() {
    let truth = lagrange(&PENDULUM, &INSTANT, 1);
    fails((lower_row_printed(&PENDULUM, &INSTANT) - truth).abs());
    holds((lower_row_corrected(&PENDULUM, &INSTANT) - truth).abs());
}

/// The library's chain of two links in physical units: mass, damping, stiffness and base force of small angles. Judge:
/// Lagrange's equations at the hanging equilibrium.
#[test]
fn equation_1_in_the_library() {
    let p = &PENDULUM;
    let vector = |x: [f64; 2]| nalgebra::DVector::from_row_slice(&x);
    let linear = PendulumChain::new(vector(p.m), vector(p.l), &vector(p.c), p.g)
        .and_then(|chain| chain.linearise())
        .expect("valid");
    let hanging = Instant {
        t: 0.5 * std::f64::consts::PI / p.frequency, // the base passes the middle: no force from it
        q: [0.0; 2],
        v: [0.0; 2],
        a: [0.0; 2],
    };
    let rest = [0, 1].map(|i| lagrange(p, &hanging, i));
    let small = 1e-7; // its square is rounding
    for j in 0..2 {
        let one = [0, 1].map(|k| if k == j { small } else { 0.0 });
        for (i, rest) in rest.into_iter().enumerate() {
            let slope = |moved: Instant| (lagrange(p, &moved, i) - rest) / small;
            let column = [
                (slope(Instant { a: one, ..hanging }), linear.mass()),
                (slope(Instant { v: one, ..hanging }), linear.damping()),
                (slope(Instant { q: one, ..hanging }), linear.stiffness()),
            ];
            for (truth, ours) in column {
                assert!((truth - ours.to_dense()[(i, j)]).abs() < 1e-7);
            }
        }
    }
    let force = linear
        .mass()
        .times(linear.influence().expect("a pendulum has one"));
    let start = Instant { t: 0.0, ..hanging };
    for i in 0..2 {
        let push = p.amplitude * p.frequency.powi(2) * force[i];
        holds((lagrange(p, &start, i) + push).abs());
    }
}

/// `w1^2`, `p1`, `p2`, `p3` of (2).
#[derive(Clone, Copy)]
struct Scales {
    w1_squared: f64,
    p1: f64,
    p2: f64,
    p3: f64,
}

fn scales_printed(p: &Pendulum) -> Scales {
    let root = (1.0 + p.m[1] / p.m[0]).sqrt();
    let w1 = (p.g / p.l[0]).sqrt(); // the one meant, so that each error stands alone
    let d = w1 * root * (p.m[0] + p.m[1]) * p.l[0] * p.l[0];
    Scales {
        w1_squared: p.g / p.c[0],
        p1: p.c[1] / d,
        p2: p.c[1] / d,
        p3: p.c[0] * root * p.m[1] * p.l[1] * p.l[1] / w1,
    }
}

fn scales_corrected(p: &Pendulum) -> Scales {
    let w1_squared = p.g / p.l[0];
    let unit = (w1_squared * (1.0 + p.m[1] / p.m[0])).sqrt();
    let d = unit * (p.m[0] + p.m[1]) * p.l[0] * p.l[0];
    Scales {
        w1_squared,
        p1: p.c[0] / d,
        p2: p.c[1] / d,
        p3: p.c[1] / (unit * p.m[1] * p.l[1] * p.l[1]),
    }
}

/// The two rows of (3) at an instant given in physical units, put back into physical units.
fn dimensionless_rows(p: &Pendulum, s: &Instant, scales: Scales) -> [f64; 2] {
    let m = p.m[1] / p.m[0];
    let (mu, unit) = (p.l[0] / p.l[1], (scales.w1_squared * (1.0 + m)).sqrt());
    let alpha = m / (1.0 + m) / mu;
    let push = p.amplitude / p.l[0] * (p.frequency / unit).powi(2) * (p.frequency * s.t).cos();
    let (q, d) = (s.q, s.q[0] - s.q[1]);
    let (v, a) = (s.v.map(|v| v / unit), s.a.map(|a| a / (unit * unit)));
    let upper = a[0]
        + alpha * (a[1] * d.cos() + v[1] * v[1] * d.sin())
        + q[0].sin() / (1.0 + m)
        + scales.p1 * v[0]
        + scales.p2 * (v[0] - v[1])
        - push * q[0].cos();
    let lower = a[1]
        + mu * (a[0] * d.cos() - v[0] * v[0] * d.sin())
        + mu * q[1].sin() / (1.0 + m)
        + scales.p3 * (v[1] - v[0])
        - mu * push * q[1].cos();
    let [l1, l2] = p.l.map(|l| (l * unit).powi(2));
    [upper * (p.m[0] + p.m[1]) * l1, lower * p.m[1] * l2]
}

/// Equation (2): `w1^2 = g/l1`, `p1` has `c1`, `p3 = c2/(w1 sqrt(1+m) m2 l2^2)`; (3) is right with them. Each printed
/// entry is put alone among the corrected ones. Judge: Lagrange's equations.
#[test]
fn equation_2_scales() {
    let truth = [0, 1].map(|i| lagrange(&PENDULUM, &INSTANT, i));
    let error = |scales: Scales| {
        let rows = dimensionless_rows(&PENDULUM, &INSTANT, scales);
        (rows[0] - truth[0]).abs().max((rows[1] - truth[1]).abs())
    };
    let (bad, good) = (scales_printed(&PENDULUM), scales_corrected(&PENDULUM));
    fails(error(Scales {
        w1_squared: bad.w1_squared,
        ..good
    }));
    fails(error(Scales { p1: bad.p1, ..good }));
    fails(error(Scales { p3: bad.p3, ..good }));
    holds(error(good));
    holds(error(Scales { p2: bad.p2, ..good })); // p2 is printed right
    // The library's dimensionless pendulum takes p1 and p2; with its second row brought to (3), p3 comes out.
    let (m, mu) = (PENDULUM.m[1] / PENDULUM.m[0], PENDULUM.l[0] / PENDULUM.l[1]);
    let linear = DoublePendulum::new(m, mu, (good.p1, good.p2))
        .and_then(|pendulum| pendulum.linearise())
        .expect("valid");
    let (damping, alpha) = (linear.damping().to_dense(), m / (1.0 + m) / mu);
    holds((damping[(0, 0)] - good.p1 - good.p2).abs());
    holds((damping[(1, 1)] * mu / alpha - good.p3).abs());
}
