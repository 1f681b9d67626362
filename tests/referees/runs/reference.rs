//! The referee's run of a scene, some runs beside it with all numbers moved by a little, and up to where they tell the
//! same story: further on the answer hangs on rounding.

use crate::roots::eigenvalues;
use crate::runs::case::{Case, ForceCase, MOST_IMPACTS};
use crate::runs::double_double::Dd;
use crate::runs::hits::{Counting, GAP_ROUNDING};
use crate::runs::lasting::planes;
use crate::runs::motion::{Factors, Model};
use crate::runs::record::{Hit, Record};
use crate::runs::simulator::{Roughness, follow, scattered};
use nalgebra::DMatrix;
use vibroimpact::Method;

/// Times at which states are compared.
const SAMPLES: usize = 40;

/// How far the numbers are moved to see what the answer is sensitive to, and the error that is allowed besides.
pub struct Allowance {
    pub moved: f64,
    pub base: f64,
}

pub fn allowance(case: &Case) -> Allowance {
    if case.method == Method::Exact {
        Allowance {
            moved: 1e-13,
            // Modes of a matrix that is nearly defective lose four digits.
            base: 1e4 * f64::EPSILON,
        }
    } else {
        Allowance {
            moved: 1e1 * case.rtol,
            base: 1e2 * case.rtol,
        }
    }
}

/// Runs beside that of the referee where nothing seems to be wrong, and where something does.
pub const FEW: u64 = 2;
pub const MANY: u64 = 32;

/// Flights as low as the tolerance of steps that are still compared: impacts that accumulate have few.
const MOST_LOW: usize = 50;

/// The referee's run, and those beside it.
pub struct Reference {
    pub main: Record,
    pub aside: Vec<Record>,
    pub times: Vec<f64>,
    /// Up to where they tell the same story, and why not further.
    pub horizon: (f64, Option<&'static str>),
    pub model: Model,
    /// Sizes of positions and velocities, of steps at least those at which the absolute tolerance takes over.
    pub q_unit: f64,
    pub v_unit: f64,
    /// How far the slowest motion goes, where modes are complex.
    pub way: f64,
    /// How many times as much as usual is allowed, and impacts beside accumulating ones are left out.
    pub wide: f64,
}

pub fn reference(case: &Case, n_aside: u64) -> Reference {
    let duration = Dd::from(case.span.1) - Dd::from(case.span.0);
    let mut times: Vec<f64> = (0..SAMPLES)
        .map(|k| {
            let part = (k as f64 + 0.37 * (k as f64).sin().abs()) / SAMPLES as f64;
            case.span.0 + part * (case.span.1 - case.span.0)
        })
        .collect();
    times.dedup();
    let samples: Vec<Dd> = times
        .iter()
        .map(|&t| Dd::from(t) - Dd::from(case.span.0))
        .collect();
    let run = |case: &Case, factors: Factors, roughness: Option<Roughness>| {
        let model = Model::new(case, &factors);
        let start = model.start(case, &factors);
        (
            follow(&model, start, duration, &samples, roughness, MOST_IMPACTS),
            model,
        )
    };
    let touches = case
        .stops
        .iter()
        .any(|s| s.gap(&case.q0).abs() <= 1e-6 * (s.clearance.abs() + 1.0));
    // The first two are opposite, the others of no pattern.
    let sign = |k: u64, place: usize| {
        let bits = if k < 2 { k } else { scattered(k) >> place };
        if bits & 1 == 0 { 1.0 } else { -1.0 }
    };
    let moved = |k: u64| {
        let parts = [0.4, -1.0, -0.6, 1.0, 0.8, -0.7, 0.9];
        std::array::from_fn(|place| {
            let is_kept = touches && place == 5;
            let by = sign(k, place) * allowance(case).moved * parts[place];
            if is_kept { 1.0 } else { 1.0 + by }
        })
    };
    let (main, model) = run(case, [1.0; 7], None);
    let (q_terms, v_terms) = terms(case, model.rate);
    // Complex modes mix positions and velocities: beside places near each other the rounding of the way their speed takes them
    // counts.
    let is_real = case.has_real_modes();
    let way = if is_real {
        0.0
    } else {
        slowest_rate(case).map_or(0.0, |rate| main.v_size / rate)
    };
    // Complex modes may lose digits before a matrix moves by its exponential: one here, of the two that ten times the
    // difference of these runs allows.
    let lost = if is_real { 1.0 } else { 10.0 };
    let rough = |k: u64| {
        Some(Roughness {
            pattern: k / 2,
            terms: q_terms.max(way),
            completion: 40.0 * case.rtol.max(1e-14),
            least: 40.0 * case.atol,
            gap: sign(k, 7) * case.by_method(lost * GAP_ROUNDING, case.rtol),
        })
    };
    // An angle of the forcing is known to its rounding, and slow forces that begin from zero to no more.
    let turned = |k: u64| {
        let mut case = case.clone();
        for force in case.forces_mut().filter(|_| !touches) {
            force.phase += sign(k, 8) * 2.0 * f64::EPSILON;
        }
        case
    };
    let aside = (0..n_aside)
        .map(|k| run(&turned(k), moved(k), rough(k)).0)
        .collect();
    let floor = case.by_method(1e-12, case.atol / case.rtol);
    // What stops at once takes the rounding of its speed along.
    let stopped = main.v_size / model.rate;
    let terms = q_terms.max(1e-3 * way).max(stopped);
    let q_unit = main.q_size.max(floor).max(terms);
    // And beside a motion near rest that of its place.
    let rest = 1e-4 * model.rate * q_unit;
    let mut reference = Reference {
        wide: 1.0,
        way,
        q_unit,
        v_unit: main.v_size.max(floor).max(v_terms).max(rest),
        horizon: (main.end, None),
        main,
        aside,
        times,
        model,
    };
    reference.horizon = horizon(&reference, case);
    reference
}

/// The squares of the frequencies without damping, but for those of free bodies.
pub fn squared_frequencies(case: &Case) -> Vec<f64> {
    let Some(inverse) = case.mass.clone().try_inverse() else {
        return Vec::new();
    };
    let values = eigenvalues(&(inverse * &case.stiffness));
    let squares: Vec<f64> = values.iter().map(|z| z.norm()).collect();
    let most = squares.iter().fold(0.0, |m: f64, &x| m.max(x));
    squares.into_iter().filter(|&x| x > 1e-9 * most).collect()
}

/// The slowest rate of free motion, but for those of free bodies.
pub fn slowest_rate(case: &Case) -> Option<f64> {
    let (n, inverse) = (case.n(), case.mass.clone().try_inverse()?);
    let mut matrix = DMatrix::zeros(2 * n, 2 * n);
    matrix.view_mut((0, n), (n, n)).fill_with_identity();
    matrix
        .view_mut((n, 0), (n, n))
        .copy_from(&-(&inverse * &case.stiffness));
    matrix
        .view_mut((n, n), (n, n))
        .copy_from(&-(inverse * &case.damping));
    let rates: Vec<f64> = eigenvalues(&matrix).iter().map(|z| z.norm()).collect();
    let most = rates.iter().fold(0.0, |m: f64, &x| m.max(x));
    // Of a double root at zero rounding makes two of the size of its square root.
    let moving = rates.into_iter().filter(|&rate| rate > 1e-6 * most);
    moving.reduce(f64::min)
}

/// Sizes of positions and velocities that the forces alone make: over a radian of the fastest motion, and, of a motion that is
/// the sum of a steady and a free one, over the least stiffness, where they are not faster than all modes, or near a resonance by
/// what it makes of them, up to a hundredth of its frequency. A motion from rest is at first the small difference of such terms,
/// and known to their rounding.
fn terms(case: &Case, rate: f64) -> (f64, f64) {
    let largest = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let load = largest(&case.load);
    let shaking: f64 = case.forces().map(ForceCase::size).sum();
    let lightest = case.mass.diagonal().min();
    let short = (load + shaking) / lightest / (rate * rate);
    let squares = squared_frequencies(case);
    let most = squares.iter().fold(0.0, |m: f64, &x| m.max(x));
    let Some(least) = squares.iter().copied().reduce(f64::min) else {
        return (short, short * rate);
    };
    let slow = case.forces().filter(|f| f.frequency.powi(2) < 4.0 * most);
    let force = load + slow.map(ForceCase::size).sum::<f64>();
    let near = case.forces().map(|f| {
        let driving = f.frequency.powi(2);
        let distance = |&w2: &f64| (w2 - driving).abs().max(1e-2 * (w2 + driving));
        f.size() / squares.iter().map(distance).fold(f64::INFINITY, f64::min)
    });
    let q = (force / least).max(near.sum()) / lightest;
    (q.max(short), (q * most.sqrt()).max(short * rate))
}

impl Reference {
    pub fn counting<'a>(&self, case: &'a Case) -> Counting<'a> {
        Counting {
            case,
            q_unit: self.q_unit,
            v_unit: self.v_unit,
            rate: self.model.rate,
            way: self.way,
            wide: self.wide,
        }
    }

    /// A speed beyond all that the start and the forces give: reactions that are not those of inertia may feed a motion.
    pub fn fed(&self, case: &Case) -> f64 {
        let largest = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let given = terms(case, self.model.rate).1.max(largest(&case.v0));
        let given = given.max(self.model.rate * largest(&case.q0));
        if given > 0.0 {
            1e9 * given
        } else {
            f64::INFINITY
        }
    }

    /// How far the runs aside are off at a sample and its neighbours, relative to the motion.
    pub fn deviation(&self, k: usize) -> f64 {
        (k.saturating_sub(2)..=k + 1)
            .map(|j| self.deviation_at(j))
            .fold(0.0, f64::max)
    }

    fn deviation_at(&self, k: usize) -> f64 {
        let Some(x) = self.main.samples.get(k) else {
            return 0.0;
        };
        self.aside
            .iter()
            .filter_map(|r| r.samples.get(k))
            .map(|y| self.distance(x, y))
            .fold(0.0, f64::max)
    }

    /// Largest difference of two states, relative to the largest position and velocity.
    pub fn distance(&self, x: &[f64], y: &[f64]) -> f64 {
        let n = x.len() / 2;
        let (q, v) = (self.q_unit, self.v_unit);
        x.iter()
            .zip(y)
            .enumerate()
            .map(|(i, (a, b))| (a - b).abs() / if i < n { q } else { v })
            .fold(0.0, f64::max)
    }
}

/// The first dip that ends in an impact slower than rounding, which counts for nothing: what it changes may grow.
fn faint_dip(hits: &[Hit], counting: &Counting<'_>) -> Option<f64> {
    let is_faint = |hit: &&Hit| {
        let is_dip = hit.curvature.is_finite() && hit.curvature > 0.0;
        let is_slow = hit.approach > 0.0 && hit.approach <= counting.speed_floor(hit.stop);
        hit.rounds == 1 && is_dip && is_slow
    };
    hits.iter().find(is_faint).map(|hit| hit.time.to_f64())
}

/// The first item of the longer list that the shorter one has none beside.
fn unpaired<'a, T>(mine: &'a [T], theirs: &'a [T]) -> Option<&'a T> {
    let at = mine.len().min(theirs.len());
    mine.get(at).or(theirs.get(at))
}

fn horizon(reference: &Reference, case: &Case) -> (f64, Option<&'static str>) {
    let main = &reference.main;
    let mut end = (main.end, None);
    let mut cut = |time: f64, why: &'static str| {
        if time < end.0 {
            end = (time.max(0.0), Some(why));
        }
    };
    if (0..case.stops.len()).any(|i| case.starts_within_tolerance(i)) {
        cut(0.0, "a start within the tolerance of a stop");
    }
    for record in std::iter::once(main).chain(&reference.aside) {
        for &(time, why) in &record.doubts {
            cut(time, why);
        }
        if let Some((time, why)) = record.stopped {
            cut(time, why);
        }
    }
    let counting = reference.counting(case);
    if let Some(time) = faint_dip(&main.hits, &counting) {
        cut(time, "a graze");
    }
    let slack = 1e-9 / reference.model.rate;
    for aside in &reference.aside {
        let chatters = [&main.chatters[..], &aside.chatters[..]];
        let sticks = [&main.sticks[..], &aside.sticks[..]];
        let mine = counting.counted(&main.hits, &chatters, &sticks);
        let theirs = counting.counted(&aside.hits, &chatters, &sticks);
        for (a, b) in mine.iter().zip(&theirs) {
            let (s, t) = (a.time.to_f64(), b.time.to_f64());
            if a.stop != b.stop || (s - t).abs() > 1e-3 / reference.model.rate {
                cut(s.min(t), "another order of impacts");
                break;
            }
        }
        if let Some(next) = unpaired(&mine, &theirs) {
            cut(next.time.to_f64(), "another number of impacts");
        }
        let (mine, theirs) = (
            planes(case, &main.sticks, slack, &reference.model),
            planes(case, &aside.sticks, slack, &reference.model),
        );
        for (a, b) in mine.iter().zip(&theirs) {
            if a.stop != b.stop || (a.start - b.start).abs() > 1e-3 / reference.model.rate {
                cut(a.start.min(b.start), "another order of lasting contacts");
                break;
            }
            if (a.end - b.end).abs() > 1e-3 / reference.model.rate {
                cut(a.end.min(b.end), "another end of lasting contact");
                break;
            }
        }
        if let Some(next) = unpaired(&mine, &theirs) {
            cut(next.start, "another number of lasting contacts");
        }
    }
    // What nothing drives dies away, and what is left of it then is rounding.
    let is_driven = case.force.is_some() || case.load.iter().any(|&f| f != 0.0);
    let least = case.by_method(1e-13, 10.0 * case.rtol);
    for (k, x) in main.samples.iter().enumerate() {
        let left = reference.distance(x, &vec![0.0; x.len()]);
        if !is_driven && left > 0.0 && left < least {
            cut(
                reference.times[k.saturating_sub(1)] - case.span.0,
                "nothing is left of the motion",
            );
            break;
        }
    }
    // Of impacts that follow each other faster than a time in doubles tells, no times can be compared.
    // Those that belong to the end of accumulating ones are not compared.
    let counted = counting.counted(&main.hits, &[&main.chatters], &[&main.sticks]);
    let times: Vec<f64> = counted.iter().map(|h| h.time.to_f64()).collect();
    let is_fast = |pair: &&[f64]| pair[1] > pair[0] && pair[1] - pair[0] < 2.0 * counting.tick();
    if let Some(pair) = times.windows(2).find(is_fast) {
        cut(pair[0], "impacts at one time in doubles");
    }
    // Many flights of steps that rise no more than some tolerances are as wrong as they are high.
    let tolerance = case.by_method(0.0, 10.0 * case.rtol * reference.q_unit);
    let is_low = |pair: &&[Hit]| {
        let [a, b] = pair else { return false };
        let rise = 0.25 * a.departure * (b.time - a.time).to_f64();
        a.stop == b.stop && rise < tolerance * counting.reach(a.stop)
    };
    if let Some(pair) = main.hits.windows(2).filter(is_low).nth(MOST_LOW) {
        cut(pair[0].time.to_f64(), "flights as low as the tolerance");
    }
    // Reactions that are not those of inertia may feed a motion until nothing else counts beside it.
    let n = case.n();
    let fastest = |x: &[f64]| x[n..].iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let fed = reference.fed(case);
    if let Some(k) = main.samples.iter().position(|x| fastest(x) > fed) {
        cut(
            reference.times[k.saturating_sub(1)] - case.span.0,
            "a motion that grows and grows",
        );
    }
    for k in 0..main.samples.len() {
        if reference.deviation_at(k) > case.by_method(1e-6, 1e-4) {
            cut(reference.times[k] - case.span.0, "sensitive to rounding");
            break;
        }
    }
    end
}
