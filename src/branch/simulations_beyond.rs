//! Simulations beyond a boundary that begin next to the last orbit of a branch, ever nearer to the boundary: whether what they come to
//! comes nearer to that orbit with them.

use crate::branch::beyond_outcome::BeyondOutcome;
use crate::branch::continuation_parameter::ContinuationParameter;
use crate::branch::special::Special;
use crate::error::{Error, Result, digits};
use crate::hybrid::{halves, joined};
use crate::model::{Parameter, PhysicalState, Scene};
use crate::orbit::PeriodicOrbit;
use crate::path::{ImpactSide, Motion};
use crate::simulate::{Keep, SimulateOptions, Status, Trajectory, simulate};
use crate::tolerance::{
    BOUNDARY_ERRORS, EACH_NEARING, JUMP_KEEPS, KICK_LEFT, KICK_SIZE, KICKED_SIZE_FLOOR,
    KICKED_SIZE_PART, LEAVING_FACTOR, NEARER_START_FACTOR, NEARING_STARTS, WHOLE_NEARING,
};
use nalgebra::DVector;
use std::f64::consts::TAU;

/// Starts at the most. [work]
const MOST_NEARING_STARTS: usize = 5;
/// Periods over which a motion that has settled is compared with the last orbit. [work]
const SETTLED_PERIODS: usize = 40;
/// Times in each of these. [work]
const TIMES_A_PERIOD: usize = 64;
/// Times of a period at which its size is taken. [work]
const SIZE_TIMES: usize = 65;
/// Times of a period at which an orbit without forcing is taken, for the distance of states from it. [work]
const CHORD_ENDS: usize = 2001;

/// Gives so many numbers in (-1, 1).
pub(super) type KickFn<'a> = &'a mut dyn FnMut(usize) -> Result<Vec<f64>>;

/// Why a computation gives nothing.
pub(super) enum NoAnswer {
    /// A reason, which an answer says: a scene that there is not, a solver that does not converge, a run that ends early.
    Reason(String),
    /// An error that ends the computation.
    Failed(Error),
}

impl From<Error> for NoAnswer {
    fn from(error: Error) -> Self {
        match error {
            Error::Interrupted | Error::Function(_) | Error::OutOfMemory { .. } => {
                Self::Failed(error)
            }
            error => Self::Reason(error.to_string()),
        }
    }
}

/// What a computation gives, or the reason why it gives nothing.
pub(super) fn or_reason<T>(
    found: std::result::Result<T, impl Into<NoAnswer>>,
) -> Result<std::result::Result<T, String>> {
    match found.map_err(Into::into) {
        Ok(found) => Ok(Ok(found)),
        Err(NoAnswer::Reason(reason)) => Ok(Err(reason)),
        Err(NoAnswer::Failed(error)) => Err(error),
    }
}

/// A motion that begins next to the last orbit.
pub(super) struct KickedMotion {
    pub scene: Scene,
    pub state: PhysicalState,
    /// The time of its start on the orbit \[s\].
    time: f64,
    /// The sizes of coordinates and velocities, shape `(2n,)`, \[units of q and v\].
    pub sizes: DVector<f64>,
}

/// Simulations from the last orbit before a special point, in scenes beyond it.
pub(super) struct NearingMotions<'a, 'o> {
    pub special: &'a Special,
    pub parameter: ContinuationParameter<'a>,
    /// Periods of the forcing that they are given to settle.
    pub periods: usize,
    pub kick: KickFn<'o>,
}

impl NearingMotions<'_, '_> {
    /// What becomes of them, and how that was seen; the first begins so far ahead of the boundary.
    pub fn outcome(&mut self, ahead: f64) -> Result<(BeyondOutcome, String)> {
        let (mut offs, mut apart): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut off = ahead;
        let mut reason = "the boundary is not known well enough".to_owned();
        while apart.len() < MOST_NEARING_STARTS && off.abs() > BOUNDARY_ERRORS * self.special.error
        {
            match or_reason(self.distance(self.special.parameter + off))? {
                Ok(distance) => apart.push(distance),
                Err(why) => {
                    reason = why;
                    break;
                }
            }
            offs.push(off);
            off *= NEARER_START_FACTOR;
            let Some(last) = apart.len().checked_sub(NEARING_STARTS).map(|k| &apart[k..]) else {
                continue;
            };
            let all = |of: &[f64]| {
                let each: Vec<String> = of.iter().map(|x| digits(*x)).collect();
                each.join(", ")
            };
            reason = format!(
                "simulations of {} periods from the last orbit, kicked by {KICK_SIZE:e} of its size, come to {} of its size from it at {} beyond",
                self.periods,
                all(&apart),
                all(&offs)
            );
            let nears = |from: f64, to: f64, part: f64| to <= (part * from).max(KICK_LEFT);
            let is_nearing = last
                .windows(2)
                .all(|pair| nears(pair[0], pair[1], EACH_NEARING));
            if is_nearing && nears(last[0], last[last.len() - 1], WHOLE_NEARING) {
                return Ok((BeyondOutcome::Continues, reason));
            }
            let least = last.iter().copied().fold(f64::INFINITY, f64::min);
            let most = last.iter().copied().fold(0.0, f64::max);
            if least >= (JUMP_KEEPS * most).max(KICK_LEFT) {
                return Ok((BeyondOutcome::Jumps, reason));
            }
        }
        Ok((BeyondOutcome::Undecided, reason))
    }

    /// A kicked state of the last orbit in the scene of a value, from where the motion is farthest from all stops: a kick on a stop may lead
    /// into it.
    pub fn kicked(&mut self, value: f64) -> Result<KickedMotion> {
        let orbit = &self.special.orbit;
        let scene = self.parameter.scene(orbit, self.special.parameter, value)?;
        let times = spread(orbit.period(), SIZE_TIMES);
        let states: Vec<DVector<f64>> = times.iter().map(|&t| whole_state(orbit, t)).collect();
        let sizes = sizes(&states);
        let gaps = (0..orbit.scene().stops().len()).map(|stop| orbit.gap(stop, Some(&times)));
        let gaps = gaps.collect::<Result<Vec<_>>>()?;
        let least = |k: usize| gaps.iter().map(|own| own[k]).fold(f64::INFINITY, f64::min);
        let farthest = |best: usize, k: usize| if least(k) > least(best) { k } else { best };
        let far = (0..times.len()).fold(0, farthest);
        let kick = DVector::from_vec((self.kick)(sizes.len())?);
        let start = &states[far] + (KICK_SIZE * &sizes).component_mul(&kick);
        let turned = TAU * orbit.n_periods() as f64 * times[far] / orbit.period();
        let scene = match scene.period() {
            Some(_) => {
                scene.with_value(Parameter::Phase, (orbit.phase() + turned).rem_euclid(TAU))?
            }
            None => scene,
        };
        Ok(KickedMotion {
            scene,
            state: halves(&start),
            time: times[far],
            sizes,
        })
    }

    /// How far from the last orbit a motion comes to be that begins next to it, in parts of its size \[-\].
    fn distance(&mut self, value: f64) -> std::result::Result<f64, NoAnswer> {
        let begun = self.kicked(value)?;
        let (scene, mut state, orbit) = (&begun.scene, begun.state, &self.special.orbit);
        let once = orbit.period() / orbit.n_periods() as f64;
        let period = scene.period().unwrap_or(once);
        let size = orbit.max_displacement()?.into_iter().fold(0.0, f64::max);
        let mut apart = [0.0; 2];
        for (rounds, apart) in [1, 2].into_iter().zip(&mut apart) {
            // Whole periods later the forcing has the phase that it had.
            let settling = self.periods as f64 * period;
            let end = ended(scene, &state, settling, Keep::Final)?;
            state = (end.last().0.clone(), end.last().1.clone());
            let compared = SETTLED_PERIODS as f64 * period;
            let run = ended(scene, &state, compared, Keep::Motion)?;
            let gone = (rounds * self.periods) as f64;
            let mut states = Vec::new();
            for k in 0..SETTLED_PERIODS * TIMES_A_PERIOD {
                let count = k as f64 / TIMES_A_PERIOD as f64;
                let state = run.state(count * period, ImpactSide::After)?;
                if scene.period().is_none() {
                    states.push(joined(&state));
                } else {
                    let then = (begun.time + (gone + count) * once).rem_euclid(orbit.period());
                    let off = (state.0 - orbit.state_at(then, ImpactSide::After).0).amax() / size;
                    *apart = off.max(*apart);
                }
            }
            if !states.is_empty() {
                *apart = farthest(states, orbit);
            }
        }
        if apart[1] > LEAVING_FACTOR * apart[0].max(KICK_LEFT) {
            return Err(NoAnswer::Reason(format!(
                "at {} the motion still leaves the last orbit after {} periods",
                digits(value),
                self.periods
            )));
        }
        Ok(apart[0].max(apart[1]))
    }
}

/// A run that came to its end.
fn ended(
    scene: &Scene,
    (q, v): &PhysicalState,
    end: f64,
    keep: Keep,
) -> std::result::Result<Trajectory, NoAnswer> {
    let options = SimulateOptions {
        keep,
        ..SimulateOptions::default()
    };
    let run = simulate(scene, q, v, (0.0, end), &options)?;
    match run.status() {
        Status::Finished => Ok(run),
        _ => Err(NoAnswer::Reason(run.message().to_owned())),
    }
}

/// So many times from zero to the end of a period.
fn spread(period: f64, count: usize) -> Vec<f64> {
    let step = period / (count - 1) as f64;
    let times = (0..count - 1).map(|k| k as f64 * step);
    times.chain([period]).collect()
}

fn whole_state(orbit: &PeriodicOrbit, time: f64) -> DVector<f64> {
    joined(&orbit.state_at(time, ImpactSide::After))
}

/// The sizes of coordinates and velocities over some states.
fn sizes(states: &[DVector<f64>]) -> DVector<f64> {
    let width = states[0].len();
    let largest = |i: usize| states.iter().map(|x| x[i].abs()).fold(0.0, f64::max);
    let sizes = DVector::from_fn(width, |i, _| largest(i));
    let least = KICKED_SIZE_FLOOR + KICKED_SIZE_PART * sizes.max();
    sizes.map(|size| size.max(least))
}

/// The largest distance of states from an orbit at any time, coordinates and velocities in parts of their largest \[-\].
fn farthest(states: Vec<DVector<f64>>, orbit: &PeriodicOrbit) -> f64 {
    let times = spread(orbit.period(), CHORD_ENDS);
    let mut path: Vec<DVector<f64>> = times.iter().map(|&t| whole_state(orbit, t)).collect();
    let n = path[0].len() / 2;
    let largest = |first: usize| {
        path.iter()
            .map(|x| x.rows(first, n).amax())
            .fold(0.0, f64::max)
    };
    let units = [largest(0), largest(n)];
    let scaled = |mut x: DVector<f64>| {
        x.iter_mut()
            .enumerate()
            .for_each(|(i, x)| *x /= units[i / n]);
        x
    };
    path = path.into_iter().map(scaled).collect();
    let from_chord = |x: &DVector<f64>, pair: &[DVector<f64>]| {
        let (way, from_start) = (&pair[1] - &pair[0], x - &pair[0]);
        let length = way.norm_squared().max(f64::MIN_POSITIVE);
        let part = (from_start.dot(&way) / length).clamp(0.0, 1.0);
        (from_start - part * way).norm()
    };
    states.into_iter().fold(0.0, |most, x| {
        let x = scaled(x);
        // From the nearest of the chords between neighbouring states.
        let each = path.windows(2).map(|pair| from_chord(&x, pair));
        most.max(each.fold(f64::INFINITY, f64::min))
    })
}
