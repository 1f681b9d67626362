//! Extrapolated midpoint steps, much shorter than the motion, and zeros on them.

use crate::branches::body::Body;
use crate::extrapolated::extrapolated;

/// Step, relative to the fastest turn.
const STEP: f64 = 0.4;

/// The state after a step, with a stop held or none.
pub fn step(body: &Body, held: Option<usize>, (t, x): (f64, &[f64]), dt: f64) -> Vec<f64> {
    if dt == 0.0 {
        return x.to_vec();
    }
    let n = body.n();
    let slope = |t: f64, x: &[f64]| -> Vec<f64> {
        let (a, _) = body.acceleration(t, x, held);
        x[n..].iter().copied().chain(a.iter().copied()).collect()
    };
    extrapolated(slope, (t, x), dt)
}

/// Looks of a step at what bends on it, the first a little behind its start.
const LOOKS: usize = 4;
const BEHIND: f64 = 1e-6;

/// When a spring on one side is first reached or left in a step.
fn first_kink(body: &Body, held: Option<usize>, (t, x): (f64, &[f64]), dt: f64) -> Option<f64> {
    let Body::Plant(plant) = body else {
        return None;
    };
    let n = body.n();
    let kinks = plant.pads.iter().filter_map(|pad| {
        let state = |s: f64| step(body, held, (t, x), s);
        let pressed = |s: f64| pad.pressed(&state(s)[..n]);
        let rate = |s: f64| pad.along(&state(s)[n..]);
        // What is far off at both ends, and goes there and back no faster, is not met between.
        let [near, fast] = [0.0, dt]
            .map(|s| [pressed(s), rate(s)])
            .iter()
            .fold([f64::INFINITY, 0.0f64], |[near, fast], [p, r]| {
                [near.min(p.abs()), fast.max(r.abs())]
            });
        if near > 2.0 * fast * dt.abs() && (pressed(0.0) > 0.0) == (pressed(dt) > 0.0) {
            return None;
        }
        let mut from = BEHIND * dt;
        let (is_pressed, mut was_rising) = (pressed(from) > 0.0, rate(from) > 0.0);
        for k in 1..=LOOKS {
            let to = dt * k as f64 / LOOKS as f64;
            if (pressed(to) > 0.0) != is_pressed {
                return Some(zero(pressed, from, to));
            }
            let is_rising = rate(to) > 0.0;
            // Towards the other side and back between two looks.
            if was_rising != is_rising && was_rising != is_pressed {
                let turn = zero(rate, from, to);
                if (pressed(turn) > 0.0) != is_pressed {
                    return Some(zero(pressed, from, turn));
                }
            }
            (from, was_rising) = (to, is_rising);
        }
        None
    });
    kinks.min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// The times of a motion from one to another and its states there, a step from each other; the start is the first.
pub fn motion(
    body: &Body,
    held: Option<usize>,
    (t, x): (f64, &[f64]),
    end: f64,
) -> Vec<(f64, Vec<f64>)> {
    let mut all = vec![(t, x.to_vec())];
    let span = end - t;
    if span == 0.0 {
        return all;
    }
    let mut done = 0.0;
    while done < 1.0 {
        let (now, x) = all.last().expect("the start");
        // As many steps as the rest takes at this rate.
        let left = (1.0 - done) * span;
        let count = (left.abs() * body.rate(x) / STEP).ceil().max(1.0);
        let next = if count == 1.0 {
            1.0
        } else {
            done + (1.0 - done) / count
        };
        let dt = t + next * span - now;
        if let Some(early) = first_kink(body, held, (*now, x), dt) {
            // A step ends where the forces bend.
            let ahead = (now + early, step(body, held, (*now, x), early));
            done = (ahead.0 - t) / span;
            all.push(ahead);
            continue;
        }
        let ahead = (t + next * span, step(body, held, (*now, x), dt));
        all.push(ahead);
        done = next;
    }
    all
}

/// The state at the end of a motion from one time to another.
pub fn moved(body: &Body, held: Option<usize>, start: (f64, &[f64]), end: f64) -> Vec<f64> {
    let all = motion(body, held, start, end);
    all.into_iter().next_back().expect("the start").1
}

/// A zero between two arguments at which a function has other signs, by regula falsi (Illinois).
pub fn zero(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..100 {
        let c = b - fb * (b - a) / (fb - fa);
        if fb == 0.0 || fa == fb || (b - a).abs() <= 1e-15 * b.abs() {
            return b;
        }
        let fc = f(c);
        if (fc < 0.0) == (fb < 0.0) {
            fa *= 0.5;
        } else {
            (a, fa) = (b, fb);
        }
        (b, fb) = (c, fc);
    }
    b
}
