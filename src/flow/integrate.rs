//! A motion over a span without contacts, to a tolerance, with the deviations from it (variational equations) and its dense
//! output where they are wanted.

use crate::error::{Error, Result};
use crate::flow::steps::control::Controller;
use crate::flow::steps::{StepStart, Stepper, Tolerance};
use crate::model::{DIFFERENCE, Dynamics, Moment};

/// A first step, in parts of the span; the controller finds the right one soon.
const FIRST_PART: f64 = 1e-3;
/// Steps before a span counts as too long to integrate.
const MOST_STEPS: usize = 10_000_000;

/// Integrates from a state `(q, v)` by a method, whose steps are added to those `kept`, if any are.
pub(crate) fn integrate<P: Stepper<Vec<f64>, Choice: Default>, D: Dynamics>(
    dynamics: &D,
    at: Moment,
    span: f64,
    tolerance: Tolerance,
    state: &mut Vec<f64>,
    mut kept: Option<&mut Vec<KeptStep<P::Dense>>>,
) -> Result<()> {
    let mut stepper = P::new(dynamics.n_dof(), tolerance, P::Choice::default());
    let mut controller = Controller::default();
    let (mut done, mut h) = (0.0, FIRST_PART * span);
    stepper.begin(dynamics, StepStart { at, x: state })?;
    for _ in 0..MOST_STEPS {
        if done >= span {
            return Ok(());
        }
        let is_last = h >= 0.999 * (span - done);
        let step = if is_last { span - done } else { h };
        let start = StepStart {
            at: at.after(done),
            x: state,
        };
        let error = if stepper.step(dynamics, start, step)? {
            stepper.error(dynamics, start, step, tolerance)?
        } else {
            f64::INFINITY
        };
        let verdict = controller.judge(stepper.control(), step, error);
        h = verdict.next;
        if !verdict.is_accepted {
            if done + h == done {
                break;
            }
            continue;
        }
        if let Some(kept) = &mut kept {
            kept.push(KeptStep {
                start: done,
                h: step,
                dense: stepper.dense(dynamics, start, step)?,
            });
        }
        state.clone_from(stepper.end());
        done = if is_last { span } else { done + step };
        if !stepper.go_on() {
            let at = at.after(done);
            stepper.begin(dynamics, StepStart { at, x: state })?;
        }
    }
    Err(Error::NoConvergence {
        stage: "the integration of a flight",
        iterations: MOST_STEPS,
        residual: span - done,
    })
}

/// One step of a flight that was kept.
#[derive(Debug, Clone)]
pub(crate) struct KeptStep<Q> {
    /// Its start, counted from that of the flight.
    pub start: f64,
    pub h: f64,
    pub dense: Q,
}

/// A motion and deviations from it as one motion: coordinates `(q, dq_1, dq_2, ...)`. The derivative of the acceleration is
/// the system's own where it is known, and else central differences along each deviation.
pub(crate) struct Variational<'a, D> {
    pub dynamics: &'a D,
    /// Number of deviations.
    pub count: usize,
}

impl<D: Dynamics> Dynamics for Variational<'_, D> {
    /// The moment, at which the derivative is asked for, and what drives the motion then.
    type Drive = (Moment, D::Drive);

    fn n_dof(&self) -> usize {
        self.dynamics.n_dof() * (1 + self.count)
    }

    fn drive(&self, at: Moment) -> (Moment, D::Drive) {
        (at, self.dynamics.drive(at))
    }

    fn driven(
        &self,
        (at, drive): (Moment, D::Drive),
        q: &[f64],
        v: &[f64],
        a: &mut [f64],
    ) -> Result<()> {
        let n = self.dynamics.n_dof();
        let (base_q, base_v) = (&q[..n], &v[..n]);
        self.dynamics.driven(drive, base_q, base_v, &mut a[..n])?;
        if self.count > 0
            && let Some(jacobian) = self.dynamics.jacobian(at, base_q, base_v)?
        {
            for k in 1..=self.count {
                let deviation = q[k * n..(k + 1) * n].iter().chain(&v[k * n..(k + 1) * n]);
                for (i, out) in a[k * n..(k + 1) * n].iter_mut().enumerate() {
                    let row = jacobian.row(i);
                    *out = row.iter().zip(deviation.clone()).map(|(j, d)| j * d).sum();
                }
            }
            return Ok(());
        }
        let largest = |x: &[f64]| x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let size = 1.0 + largest(base_q).max(largest(base_v));
        let (mut moved_q, mut moved_v) = (vec![0.0; n], vec![0.0; n]);
        let (mut ahead, mut behind) = (vec![0.0; n], vec![0.0; n]);
        for k in 1..=self.count {
            let (dq, dv) = (&q[k * n..(k + 1) * n], &v[k * n..(k + 1) * n]);
            let deviation = largest(dq).max(largest(dv));
            let out = &mut a[k * n..(k + 1) * n];
            if deviation == 0.0 {
                out.fill(0.0);
                continue;
            }
            let step = DIFFERENCE * size / deviation;
            for (sign, result) in [(step, &mut ahead), (-step, &mut behind)] {
                for i in 0..n {
                    moved_q[i] = base_q[i] + sign * dq[i];
                    moved_v[i] = base_v[i] + sign * dv[i];
                }
                self.dynamics.driven(drive, &moved_q, &moved_v, result)?;
            }
            for i in 0..n {
                out[i] = (ahead[i] - behind[i]) / (2.0 * step);
            }
        }
        Ok(())
    }
}

/// `(q, v)` with deviations `(dq, dv)`, columns of `2n` entries, as one state `(q, dq..., v, dv...)`.
pub(crate) fn joined(state: &[f64], deviations: &[f64]) -> Vec<f64> {
    let n = state.len() / 2;
    let half = |which: usize| {
        let of = move |x: &[f64]| x[which * n..(which + 1) * n].to_vec();
        std::iter::once(of(state)).chain(deviations.chunks(2 * n).map(of))
    };
    half(0).chain(half(1)).flatten().collect()
}

/// The inverse of [`joined`].
pub(crate) fn parted(joint: &[f64], state: &mut [f64], deviations: &mut [f64]) {
    let n = state.len() / 2;
    let (q, v) = joint.split_at(joint.len() / 2);
    for (which, half) in [q, v].into_iter().enumerate() {
        state[which * n..(which + 1) * n].copy_from_slice(&half[..n]);
        for (column, part) in deviations.chunks_mut(2 * n).zip(half[n..].chunks(n)) {
            column[which * n..(which + 1) * n].copy_from_slice(part);
        }
    }
}
