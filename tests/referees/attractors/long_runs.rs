//! Long runs, and what they say of two motions: no periods, no exponents, no judgement of the library, but states of its runs held against
//! each other at three phases of the forcing.

use nalgebra::{DMatrix, DVector};
use vibroimpact::{Motion, Scene, SimulateOptions, Status, nalgebra, simulate};

/// Phases at which states are taken, in parts of a period: next to an impact two motions that are one may look apart, but not at all three.
const PHASES: [f64; 3] = [0.0, 0.37, 0.71];

/// The states of a motion at three phases, one after the other in time, velocities over the frequency; one matrix for each phase.
pub struct Seen(pub [DMatrix<f64>; 3]);

/// The states of a motion for so many periods after some that are left out; none where the run ends before.
pub fn seen(scene: &Scene, state: &DVector<f64>, left_out: usize, periods: usize) -> Option<Seen> {
    let (n, period) = (scene.n_dof(), scene.period()?);
    let time =
        |k: usize| period * ((left_out + k / PHASES.len()) as f64 + PHASES[k % PHASES.len()]);
    let count = PHASES.len() * periods;
    let options = SimulateOptions {
        t_eval: Some((0..count).map(time).collect()),
        ..SimulateOptions::default()
    };
    let (q, v) = (state.rows(0, n).into_owned(), state.rows(n, n).into_owned());
    let end = period * (left_out + periods) as f64;
    let run = simulate(scene, &q, &v, (0.0, end), &options).expect("a run");
    if run.status() != Status::Finished {
        return None;
    }
    let (_, q, v) = run.samples().expect("samples");
    let unit = period / std::f64::consts::TAU;
    Some(Seen([0, 1, 2].map(|phase| {
        DMatrix::from_fn(periods, 2 * n, |k, j| {
            let row = PHASES.len() * k + phase;
            if j < n {
                q[(row, j)]
            } else {
                unit * v[(row, j - n)]
            }
        })
    })))
}

/// The largest coordinate.
pub fn size(seen: &Seen) -> f64 {
    seen.0.iter().map(DMatrix::amax).fold(0.0, f64::max)
}

fn apart(a: &DMatrix<f64>, i: usize, b: &DMatrix<f64>, j: usize) -> f64 {
    let each = (0..a.ncols()).map(|k| (a[(i, k)] - b[(j, k)]).abs());
    each.fold(0.0, f64::max)
}

/// Of some rows of `a` how far the nearest of `b` is, ascending; of those of a `b` that is `a` of the other parity.
fn nearest(a: &DMatrix<f64>, b: &DMatrix<f64>, is_own: bool) -> Vec<f64> {
    let every = (a.nrows() / 400).max(1) | 1;
    let least = |i: usize| {
        let others = (0..b.nrows()).filter(|j| (i + j) % 2 == 1 || !is_own);
        others
            .map(|j| apart(a, i, b, j))
            .fold(f64::INFINITY, f64::min)
    };
    let mut all: Vec<f64> = (0..a.nrows()).step_by(every).map(least).collect();
    all.sort_by(f64::total_cmp);
    all
}

fn quantile(ascending: &[f64], part: f64) -> f64 {
    ascending[((ascending.len() - 1) as f64 * part) as usize]
}

/// Whether the later states of a motion are all states of another, to a part of its size, at two of the three phases.
pub fn is_on_cycle(own: &Seen, cycle: &Seen, part: f64) -> bool {
    let within = part * size(cycle);
    let agrees = |k: &usize| {
        let (a, b) = (&own.0[*k], &cycle.0[*k]);
        (0..a.nrows()).all(|i| (0..b.nrows()).any(|j| apart(a, i, b, j) <= within))
    };
    (0..3).filter(agrees).count() >= 2
}

/// After how many periods, up to a largest number, a motion is back where it was, to a part of its size, at two of the three phases.
pub fn comes_back(own: &Seen, most: usize, part: f64) -> Option<usize> {
    let within = part * size(own);
    (1..=most).find(|late| {
        let agrees = |k: &usize| {
            let a = &own.0[*k];
            (*late..a.nrows()).all(|i| apart(a, i, a, i - late) <= within)
        };
        (0..3).filter(agrees).count() >= 2
    })
}

/// Whether two long motions fill the same set: half the states of each lie as near to the other's as nine in ten of its own odd ones to the even ones.
pub fn fill_one_set(a: &Seen, b: &Seen) -> bool {
    let is_in = |a: &DMatrix<f64>, b: &DMatrix<f64>| {
        quantile(&nearest(a, b, false), 0.5) <= quantile(&nearest(b, b, true), 0.9)
    };
    let agrees = |k: &usize| is_in(&a.0[*k], &b.0[*k]) && is_in(&b.0[*k], &a.0[*k]);
    (0..3).filter(agrees).count() >= 2
}

/// Whether some states lie on a set that a long motion fills: nine in ten of them as near as its own states are to each other, but for the
/// one in a hundred that is farthest.
pub fn is_on_set(own: &Seen, set: &Seen) -> bool {
    let agrees = |k: &usize| {
        let far = quantile(&nearest(&set.0[*k], &set.0[*k], true), 0.99);
        quantile(&nearest(&own.0[*k], &set.0[*k], false), 0.9) <= 3.0 * far
    };
    (0..3).filter(agrees).count() >= 2
}
