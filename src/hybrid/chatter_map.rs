//! Impacts that accumulate, as a map of their own with its Jacobian (theory 9).
//!
//! A state before an impact and its time, `Y = (x, t)`, lie on `h = 0`. One round of the sequence is the impact `x+ = x + W h'`, `W = (0,
//! (1 + e) b/(n.b))`, and the flight to the next zero of the gap. A deviation `(dx, dt)` of Y goes through the impact as `R_x dx` and
//! through the flight as follows: at a fixed time after the impact it is `dx - f dt`, at the fixed end `y = J (dx - f dt)` with the
//! Jacobian J of the flow; the next contact is late by `dt' = -(g.y)/(g.f')`, `g = grad h`, and there `dx' = y + f' dt'`. Rounds are gone
//! through one by one until what the rest leaves out is at most [`CHATTER_DEPTH`] of the unit of positions, or no next contact is found
//! within [`NEAR_CHATTER_DEPTH`] times that; so a chatter of a thousand impacts costs a thousand small products and no unknown. Which
//! impacts of an orbit accumulate is read from a run (`itinerary/read.rs`).
//!
//! The rest is the map
//!
//! `Y* = Y + ((2e/a) (f, 1) + (W, 0)) h'/(1 - e)`, `a = h''`,
//!
//! and then gap and normal speed are set to zero along b (`landing.rs`). What it leaves out is of second order in h'. In the limit `h' ->
//! 0` its Jacobian is `I + ((2e/a) (f, 1) + (W, 0)) grad(h')/(1 - e)`: the derivatives of f, W and a come with the factor h' and vanish.
//! Newton's method on the limit would close by the factor h' (1e-6) a step and give multipliers as good as that; the map as executed, its
//! dependence on a included, is differentiated instead (central differences of one evaluation, no flight), so that Newton keeps its order
//! and the multipliers are those of the process as it runs.
//!
//! After it the motion is held: `h = h' = 0` for every deviation, so that at a fixed time, where the deviation is `dx* - f_held dt*`, two
//! of 2n directions are gone. Each completed chatter so gives two zero multipliers, and so does each impact with e = 0 after which a stop
//! is held.
//!
//! The end t* is known to rounding over the speed of the last impact, 1e-9, but the state at a fixed time is known to rounding: a later
//! contact brings a larger impulse, by just what the contact force would have given.

use crate::error::{Error, Result};
use crate::hybrid::landing::land;
use crate::hybrid::maps::{GapAt, HybridMaps};
use crate::hybrid::scaled_units::ScaledUnits;
use crate::hybrid::timed::Timed;
use crate::impact::CompleteChatter;
use crate::law::Regime;
use crate::tolerance::{CENTRAL_DIFFERENCE_STEP, CHATTER_DEPTH, NEAR_CHATTER_DEPTH};
use nalgebra::{DMatrix, DVector};

/// The stage that fails where impacts that should accumulate do not.
pub(crate) const NO_REST: &str = "the completion of impacts that accumulate";

/// Impacts after which a sequence has no end in sight: e = 0.9999 has 150 000. [work]
const MOST_BOUNCES: usize = 1_000_000;
/// Newton steps to the next contact of a round. [work]
const MOST_FLIGHT_STEPS: usize = 50;

/// One impact of a sequence that accumulates.
#[derive(Debug, Clone)]
pub(crate) struct Bounce {
    pub time: f64,
    /// The state `(q, v)` before the impact, shape `(2 n_dof,)`, \[m\] and \[m/s\].
    pub before: DVector<f64>,
    /// The state `(q, v)` after the impact, shape `(2 n_dof,)`, \[m\] and \[m/s\].
    pub after: DVector<f64>,
    pub impulse: f64,
}

/// A sequence as it was gone through.
#[derive(Debug, Clone)]
pub(crate) struct Chatter {
    pub bounces: Vec<Bounce>,
    /// Where the rest begins, and the state before the impact there.
    pub last_time: f64,
    /// The state `(q, v)` before the impact there, shape `(2 n_dof,)`, \[m\] and \[m/s\].
    pub last: DVector<f64>,
}

fn failed(iterations: usize, residual: f64) -> Error {
    Error::NoConvergence {
        stage: NO_REST,
        iterations,
        residual,
    }
}

/// The impacts on a stop from a state before one of them, with its gap there and the rate of the state in free motion.
fn sequence<M: HybridMaps + ?Sized>(
    motion: &M,
    stop: usize,
    (t, state): (f64, &DVector<f64>),
    (gap, rate): (&GapAt, &DVector<f64>),
) -> Result<CompleteChatter> {
    let n = state.len() / 2;
    Ok(CompleteChatter {
        law: motion.law(stop),
        speed: gap.speed(state.rows(n, n)),
        acceleration: motion.gap_acceleration(stop, t, state, rate)?,
    })
}

/// The impacts of some stops on a state, on deviations of it and of its time.
pub(crate) fn strike<M: HybridMaps + ?Sized>(
    motion: &M,
    stops: &[usize],
    y: &mut Timed,
) -> Result<Vec<f64>> {
    let recoil = motion.recoil(stops, y.time, &y.state)?;
    let impulses = motion.impact(stops, y.time, &mut y.state, &mut y.deviations)?;
    if let Some(recoil) = recoil {
        y.deviations += recoil * y.delays.transpose();
    }
    Ok(impulses)
}

/// Goes through the sequence that begins with an impact on a stop; `y` becomes the state in lasting contact after it.
pub(crate) fn complete<M: HybridMaps + ?Sized>(
    motion: &M,
    stop: usize,
    units: &ScaledUnits,
    y: &mut Timed,
) -> Result<Chatter> {
    // Not yet closed, the motion may arrive at some other gap: the sequence runs on that level.
    let mut there = motion.gap(stop, y.time, &y.state)?;
    let level = there.gap;
    let level_deviations = there.timed_deviations(&y.deviations, &y.delays);
    let mut bounces = Vec::new();
    let mut arrival = motion.rate(Regime::free(), y.time, &y.state)?;
    loop {
        let rest = sequence(motion, stop, (y.time, &y.state), (&there, &arrival))?;
        if !(rest.speed < 0.0 && rest.acceleration < 0.0) || bounces.len() >= MOST_BOUNCES {
            return Err(failed(bounces.len(), rest.speed));
        }
        if rest.residual() <= CHATTER_DEPTH * units.position {
            break;
        }
        let last = (rest.residual() <= NEAR_CHATTER_DEPTH * CHATTER_DEPTH * units.position)
            .then(|| y.clone());
        let before = y.state.clone();
        let impulses = strike(motion, &[stop], y)?;
        let after = y.state.clone();
        bounces.push(Bounce {
            time: y.time,
            before,
            after: after.clone(),
            impulse: impulses[0],
        });
        let rate = motion.rate(Regime::free(), y.time, &after)?;
        let guess = rest.first_flight();
        let next = next_contact(motion, stop, (y.time, &after), level, guess);
        let span = match (next, last) {
            // The height of this flight is rounding: the rest begins before it.
            (Err(Error::NoConvergence { .. }), Some(last)) => {
                *y = last;
                bounces.pop();
                break;
            }
            (next, _) => next?,
        };
        let mut carried = &y.deviations - &rate * y.delays.transpose();
        let end = y.time + span;
        motion.flow(Regime::free(), (y.time, end), &mut y.state, &mut carried)?;
        arrival = motion.rate(Regime::free(), end, &y.state)?;
        there = motion.gap(stop, end, &y.state)?;
        let speed = there.speed(arrival.rows(0, there.gradient.len()));
        y.delays = (&level_deviations - there.deviations(&carried)) / speed;
        y.deviations = carried + &arrival * y.delays.transpose();
        y.time = end;
    }
    let chatter = Chatter {
        bounces,
        last_time: y.time,
        last: y.state.clone(),
    };
    finish(motion, (stop, Regime::free()), units, y)?;
    Ok(chatter)
}

/// The time from an impact to the next contact, from a guess: the gap is concave, so that Newton's method arrives from
/// behind.
fn next_contact<M: HybridMaps + ?Sized>(
    motion: &M,
    stop: usize,
    (start, after): (f64, &DVector<f64>),
    level: f64,
    guess: f64,
) -> Result<f64> {
    let mut none = DMatrix::zeros(after.len(), 0);
    let mut span = guess;
    let mut least = f64::INFINITY;
    for step in 0..MOST_FLIGHT_STEPS {
        let mut state = after.clone();
        motion.flow(Regime::free(), (start, start + span), &mut state, &mut none)?;
        let there = motion.gap(stop, start + span, &state)?;
        let (gap, n) = (there.gap, there.gradient.len());
        let speed = there.speed(state.rows(n, n));
        let correction = -(gap - level) / speed;
        if !(speed < 0.0 && correction.is_finite() && span + correction > 0.0) {
            return Err(failed(step, gap));
        }
        // Rounding of the gap ends it: the corrections stop to shrink.
        if correction.abs() >= 0.5 * least || correction.abs() <= f64::EPSILON * span {
            return Ok(span);
        }
        least = correction.abs();
        span += correction;
    }
    Err(failed(MOST_FLIGHT_STEPS, least))
}

/// The rest of the sequence at once, with its Jacobian, between whose impacts some regime lasts; in a motion of some units.
pub(crate) fn finish<M: HybridMaps + ?Sized>(
    motion: &M,
    (stop, regime): (usize, &Regime),
    units: &ScaledUnits,
    y: &mut Timed,
) -> Result<()> {
    let own = (stop, regime);
    let (span, change) = rest(motion, own, y.time, &y.state)?;
    for (mut column, delay) in y.deviations.column_iter_mut().zip(y.delays.iter_mut()) {
        let largest = units.size_of(column.iter(), *delay);
        if largest == 0.0 {
            continue;
        }
        let step = CENTRAL_DIFFERENCE_STEP / largest;
        let moved = |sign: f64| {
            let x = &y.state + &column * (sign * step);
            rest(motion, own, y.time + sign * step * *delay, &x)
        };
        // Of the change alone, which is small: differences of times and places would lose its digits, far from zero all of them.
        let ((t1, x1), (t0, x0)) = (moved(1.0)?, moved(-1.0)?);
        column += (x1 - x0) / (2.0 * step);
        *delay += (t1 - t0) / (2.0 * step);
    }
    y.time += span;
    y.state += change;
    land(motion, &Regime::holding([stop]), y)
}

/// How long the rest takes and by what it changes a state, `((2e/a) (f, 1) + (W, 0)) h'/(1 - e)`.
fn rest<M: HybridMaps + ?Sized>(
    motion: &M,
    (stop, regime): (usize, &Regime),
    t: f64,
    state: &DVector<f64>,
) -> Result<(f64, DVector<f64>)> {
    let rate = motion.rate(regime, t, state)?;
    let gap = motion.gap(stop, t, state)?;
    let rest = sequence(motion, stop, (t, state), (&gap, &rate))?;
    let mut struck = state.clone();
    motion.impact(&[stop], t, &mut struck, &mut DMatrix::zeros(state.len(), 0))?;
    Ok((rest.span(), rest.change(rate, struck - state)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::ModalScene;
    use crate::hybrid::closed_form::ClosedFormMaps;
    use crate::model::{Harmonic, LinearSystem, Scene, Stop};
    use nalgebra::{Complex, dmatrix, dvector};

    /// Two coupled coordinates under forcing, the first pressed onto its stop at one.
    fn pressed(e: f64) -> Scene {
        let system = LinearSystem::new(
            dmatrix![1.0, 0.3; 0.3, 0.8],
            dmatrix![0.2, -0.1; -0.1, 0.3],
            dmatrix![2.0, -1.0; -1.0, 1.5],
        );
        let force = dvector![Complex::new(9.0, 0.0), Complex::new(1.0, 0.5)];
        let forcing = Harmonic::new(force, 1.3, 0.4).expect("valid");
        let stop = Stop::new(0, 1.0, e).expect("valid");
        Scene::new(system.expect("valid"), forcing, vec![stop]).expect("valid")
    }

    /// What the rest does to deviations against its limit for a small speed,
    /// `I + ((2e/a) (f, 1) + (W, 0)) grad(h')/(1 - e)` and the projection: they differ by the first order of the speed.
    #[test]
    fn the_rest_is_differentiated() {
        for e in [0.3, 0.8] {
            let scene = pressed(e);
            let modal = ModalScene::new(&scene, "the test").expect("linear");
            let motion = ClosedFormMaps::new(&modal, 0.4, Vec::new());
            let misses = [1e-3, 1e-5].map(|speed| {
                let state = dvector![1.0, 0.3, speed, -0.7];
                let t = 0.2;
                let rate = motion.rate(Regime::free(), t, &state).expect("regular");
                let pull = -rate[2];
                assert!(pull < -1.0);
                let b = motion.reaction(0, &state).expect("regular");
                let mut y = Timed {
                    time: t,
                    state: state.clone(),
                    deviations: DMatrix::from_fn(4, 5, |i, j| f64::from(u8::from(i == j))),
                    delays: DVector::from_fn(5, |j, _| f64::from(u8::from(j == 4))),
                };
                let units = ScaledUnits::of_state(&state, &rate);
                finish(&motion, (0, Regime::free()), &units, &mut y).expect("regular");
                let mut miss = 0.0f64;
                for j in 0..5 {
                    // h' = -v_0, W = (0, (1 + e) b/b_0)
                    let change = if j == 2 { -1.0 / (1.0 - e) } else { 0.0 };
                    let delay = f64::from(u8::from(j == 4)) + 2.0 * e / pull * change;
                    let mut dx = DVector::from_fn(4, |i, _| f64::from(u8::from(i == j)));
                    dx += &rate * (2.0 * e / pull * change);
                    for i in 0..2 {
                        dx[2 + i] += (1.0 + e) * b[i] / b[0] * change;
                    }
                    let (off, speed) = (dx[0], dx[2]);
                    for i in 0..2 {
                        dx[i] -= b[i] / b[0] * off;
                        dx[2 + i] -= b[i] / b[0] * speed;
                    }
                    miss = miss.max((y.deviations.column(j) - dx).amax());
                    miss = miss.max((y.delays[j] - delay).abs());
                }
                miss
            });
            assert!(misses[0] < 0.05, "{misses:?}");
            assert!(misses[1] < 0.015 * misses[0], "{misses:?}");
        }
    }
}
