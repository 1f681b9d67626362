//! The variational equations: a motion and deviations from it as one motion. The derivative of the acceleration is the system's own where it
//! is known, and taken by finite differences along each deviation otherwise (`differences.rs`). Neither shows where the
//! acceleration jumps, so each step is tested for a jump (theory 7).

use crate::error::Result;
use crate::flow::differences::{DerivativeWarning, Differences, WarningLog};
use crate::flow::integrate::Accepted;
use crate::flow::steps::Stepper;
use crate::model::{Dynamics, Moment};
use crate::tolerance::{ACCELERATION_JUMP, JUMP_HALVINGS, ONE_SIDED};
use std::cell::{Cell, RefCell};

/// A motion and deviations from it as one motion: coordinates `(q, dq_1, dq_2, ...)`.
pub(crate) struct Variational<'a, D> {
    dynamics: &'a D,
    /// Number of deviations.
    count: usize,
    differences: RefCell<Differences>,
    /// The log of warnings about the deviations, where one is kept.
    log: Option<&'a WarningLog>,
    /// The largest acceleration so far.
    largest: Cell<f64>,
}

/// A state of the motion with its moment.
#[derive(Clone)]
struct TrajectoryPoint {
    at: Moment,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl TrajectoryPoint {
    /// Half way between two.
    fn between(a: &Self, b: &Self) -> Self {
        let mean = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
        Self {
            at: a.at.after(0.5 * (b.at.time - a.at.time)),
            q: mean(&a.q, &b.q),
            v: mean(&a.v, &b.v),
        }
    }
}

/// The largest difference of two accelerations.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let each = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    each.fold(0.0, f64::max)
}

impl<'a, D: Dynamics> Variational<'a, D> {
    /// A motion with deviations, whose differences are taken where it says no derivatives, and where doubts about them are noted.
    pub fn new(dynamics: &'a D, differences: Differences, log: Option<&'a WarningLog>) -> Self {
        Self {
            dynamics,
            count: differences.count(),
            differences: RefCell::new(differences),
            log,
            largest: Cell::new(0.0),
        }
    }

    /// Tests a step for a jump of the acceleration.
    ///
    /// # Errors
    /// What the acceleration reports.
    pub fn look_across<P: Stepper<Vec<f64>>>(&self, step: &Accepted<'_, P>) -> Result<()> {
        let Some(log) = self.log else {
            return Ok(());
        };
        let n = self.dynamics.n_dof();
        let half = n * (1 + self.count);
        let place = |at: Moment, x: &[f64]| TrajectoryPoint {
            at,
            q: x[..n].to_vec(),
            v: x[half..half + n].to_vec(),
        };
        let acceleration = |rate: &[f64]| rate[half..half + n].to_vec();
        let ends = [
            place(step.start.at, step.start.x),
            place(step.start.at.after(step.h), step.stepper.end()),
        ];
        let values = [
            acceleration(step.stepper.start_rate()),
            acceleration(step.stepper.end_rate()),
        ];
        if let Some(time) = self.jump(ends, values)? {
            log.note(DerivativeWarning::Jump { time });
        }
        Ok(())
    }

    /// When the acceleration jumps between two places, if it does: nearly all of its change then lies in one half of the step, and so
    /// on in each half. A change with time alone is no jump for deviations.
    fn jump(
        &self,
        mut ends: [TrajectoryPoint; 2],
        mut values: [Vec<f64>; 2],
    ) -> Result<Option<f64>> {
        let size = |a: &[f64]| a.iter().fold(self.largest.get(), |m, x| m.max(x.abs()));
        self.largest
            .set(values.iter().map(|a| size(a)).fold(0.0, f64::max));
        for _ in 0..JUMP_HALVINGS {
            let middle = TrajectoryPoint::between(&ends[0], &ends[1]);
            let mut value = vec![0.0; middle.q.len()];
            let at = middle.at;
            self.dynamics
                .acceleration(at, &middle.q, &middle.v, &mut value)?;
            let [first, second] = [apart(&values[0], &value), apart(&value, &values[1])];
            let more = first.max(second);
            if more < ONE_SIDED * (first + second) || more <= ACCELERATION_JUMP * self.largest.get()
            {
                return Ok(None);
            }
            let side = usize::from(first > second);
            (ends[side], values[side]) = (middle, value);
        }
        let mut value = vec![0.0; ends[0].q.len()];
        let [before, after] = &ends;
        (self.dynamics).acceleration(after.at, &before.q, &before.v, &mut value)?;
        let is_by_time = after.at.time > before.at.time
            && apart(&value, &values[1]) < (1.0 - ONE_SIDED) * apart(&values[0], &values[1]);
        Ok((!is_by_time).then_some(after.at.time))
    }
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
        let (base, others) = a.split_at_mut(n);
        self.dynamics.driven(drive, base_q, base_v, base)?;
        if self.count == 0 {
            return Ok(());
        }
        if let Some(jacobian) = self.dynamics.jacobian(at, base_q, base_v)? {
            for (k, own) in (1..).zip(others.chunks_mut(n)) {
                let deviation = q[k * n..(k + 1) * n].iter().chain(&v[k * n..(k + 1) * n]);
                for (i, out) in own.iter_mut().enumerate() {
                    let row = jacobian.row(i);
                    *out = row.iter().zip(deviation.clone()).map(|(j, d)| j * d).sum();
                }
            }
            return Ok(());
        }
        let rate = |q: &[f64], v: &[f64], a: &mut [f64]| self.dynamics.driven(drive, q, v, a);
        let mut differences = self.differences.borrow_mut();
        differences.begin((base_q, base_v), base);
        for (k, own) in (1..).zip(others.chunks_mut(n)) {
            let deviation = [&q[k * n..(k + 1) * n], &v[k * n..(k + 1) * n]];
            differences.along(k - 1, deviation, &rate, own)?;
        }
        if std::mem::take(&mut differences.is_doubtful)
            && let Some(log) = self.log
        {
            log.note(DerivativeWarning::Differences { time: at.time });
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
