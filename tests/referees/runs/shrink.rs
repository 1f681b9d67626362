//! A scene that disagrees is made smaller, change by change, while it still disagrees in the same way.

use crate::runs::case::{Case, ForceCase, Push};
use crate::runs::compare::{Verdict, judge};
use crate::runs::generator;
use nalgebra::DMatrix;
use vibroimpact::Method;

fn disagrees(case: &Case, original: &Case, class: &str) -> bool {
    let is_feasible = case
        .stops
        .iter()
        .all(|stop| stop.gap(&case.q0) >= -1e-13 && stop.normal.iter().any(|x| *x != 0.0));
    let is_long = case.span.1 - case.span.0 > 1e-3 * (original.span.1 - original.span.0);
    is_feasible
        && is_long
        && matches!(judge(case), Verdict::Disagree(all) if all.iter().any(|d| d.class == class))
}

/// A number with so many digits.
fn digits(x: f64, n: usize) -> f64 {
    format!("{x:.n$e}").parse().unwrap_or(x)
}

/// Every change to something simpler.
fn simpler(case: &Case) -> Vec<Case> {
    let mut all = Vec::new();
    let mut offer = |change: &dyn Fn(&mut Case)| {
        let mut other = case.clone();
        change(&mut other);
        all.push(other);
    };
    let n = case.n();
    for i in 0..case.stops.len() {
        offer(&|c| {
            c.stops.remove(i);
        });
    }
    for k in 0..n {
        if n > 1 {
            offer(&|c| without(c, k));
        }
    }
    let length = case.span.1 - case.span.0;
    offer(&|c| c.span = (0.0, length));
    for part in [0.1, 0.5, 0.8] {
        offer(&|c| {
            c.span.1 = digits(
                c.span.0 + part * length,
                2 + (c.span.0.abs().log10().max(0.0)) as usize,
            );
        });
    }
    offer(&|c| c.method = Method::Exact);
    offer(&|c| c.more.clear());
    offer(&|c| drop(c.more.pop()));
    offer(&|c| c.force = c.more.pop());
    offer(&|c| c.load = vec![0.0; n]);
    offer(&|c| c.damping = DMatrix::zeros(n, n));
    offer(&|c| c.mass = DMatrix::identity(n, n));
    offer(&|c| c.stiffness = DMatrix::zeros(n, n));
    offer(&|c| c.stiffness = DMatrix::from_diagonal(&c.stiffness.diagonal()));
    offer(&|c| c.q0 = vec![0.0; n]);
    offer(&|c| c.v0 = vec![0.0; n]);
    offer(&|c| (c.rtol, c.atol) = (1e-9, 1e-12));
    for i in 0..case.stops.len() {
        offer(&|c| c.stops[i].push = Push::Inertia);
        offer(&|c| c.stops[i].restitution = 0.5);
        offer(&|c| c.stops[i].clearance = 0.0);
        for k in 0..n {
            offer(&|c| {
                c.stops[i].normal = vec![0.0; n];
                c.stops[i].normal[k] = 1.0;
            });
        }
    }
    for i in 0..case.forces().count() {
        let offer = &mut |change: &dyn Fn(&mut ForceCase)| {
            offer(&|c| change(c.forces_mut().nth(i).expect("that many")));
        };
        offer(&|f| f.im = vec![0.0; n]);
        offer(&|f| f.phase = 0.0);
        offer(&|f| f.frequency = 1.0);
        for k in 0..n {
            offer(&|f| f.re[k] = 0.0);
        }
    }
    for d in [0, 1, 3] {
        offer(&|c| round(c, d));
    }
    all.retain(|other| format!("{other:?}") != format!("{case:?}"));
    all
}

/// The scene without one coordinate.
fn without(c: &mut Case, k: usize) {
    for matrix in [&mut c.mass, &mut c.damping, &mut c.stiffness] {
        *matrix = matrix.clone().remove_row(k).remove_column(k);
    }
    let mut vectors = vec![&mut c.load, &mut c.q0, &mut c.v0];
    for f in c.force.iter_mut().chain(&mut c.more) {
        vectors.extend([&mut f.re, &mut f.im]);
    }
    for stop in &mut c.stops {
        vectors.push(&mut stop.normal);
        if let Push::Direction(b) = &mut stop.push {
            vectors.push(b);
        }
    }
    for vector in vectors {
        vector.remove(k);
    }
}

/// All numbers but times with fewer digits.
fn round(c: &mut Case, d: usize) {
    for matrix in [&mut c.mass, &mut c.damping, &mut c.stiffness] {
        matrix.apply(|x| *x = digits(*x, d));
    }
    let mut vectors = vec![&mut c.load, &mut c.q0, &mut c.v0];
    for f in c.force.iter_mut().chain(&mut c.more) {
        f.frequency = digits(f.frequency, d);
        vectors.extend([&mut f.re, &mut f.im]);
    }
    for stop in &mut c.stops {
        stop.clearance = digits(stop.clearance, d);
        stop.restitution = digits(stop.restitution, d);
        vectors.push(&mut stop.normal);
        if let Push::Direction(b) = &mut stop.push {
            vectors.push(b);
        }
    }
    for x in vectors.into_iter().flatten() {
        *x = digits(*x, d);
    }
}

fn shrunk(mut case: Case, class: &str) -> Case {
    let original = case.clone();
    let mut left = 250;
    'again: while left > 0 {
        for other in simpler(&case) {
            left -= 1;
            if left == 0 {
                break;
            }
            if disagrees(&other, &original, class) {
                case = other;
                continue 'again;
            }
        }
        break;
    }
    case
}

/// The smallest of the first few scenes of a class, shrunk.
pub fn smallest(class: &str, numbers: &[u64], seed: u64) -> (u64, Case) {
    let few = numbers.iter().take(3);
    let cases = few.map(|&number| (number, shrunk(generator::scene(seed, number), class)));
    cases
        .min_by_key(|(_, case)| case.dump().len())
        .expect("not empty")
}
