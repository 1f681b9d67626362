//! The Dormand-Prince pair of orders 5 and 4 on `q'' = a(t, q, v)`, with its quartic dense output (theory 8).

use crate::error::Result;
use crate::flow::steps::control::{Controller, StepControl};
use crate::flow::steps::dense_output::Dense;
use crate::flow::steps::state::{State, rate, stage_state, stiffness, weighted_sum};
use crate::flow::steps::stepper::{StepEnds, StepStart, Stepper, Tolerance};
use crate::flow::steps::tableau::{
    DOPRI5_DENSE, DOPRI5_ERROR, DOPRI5_NODES, DOPRI5_ROWS, DOPRI5_STAGES,
};
use crate::model::Dynamics;

/// Stiffness `h |lambda|` beyond which stability holds the step down: the stability limit of the method on the negative real axis. [exact]
const DOPRI5_STABLE: f64 = 3.25;

/// The pair, with the step last taken.
#[derive(Debug, Clone)]
pub(crate) struct DormandPrince<S> {
    /// Rates at the stages; the first at the start, the last at the end.
    stages: [S; DOPRI5_STAGES],
    trial: S,
    error: S,
    end: S,
    n_rhs: usize,
}

impl<S: State> DormandPrince<S> {
    /// The rate at stage K from those before it.
    #[inline]
    fn stage<D: Dynamics, const K: usize>(
        &mut self,
        dynamics: &D,
        drive: D::Drive,
        x: &S,
        h: f64,
    ) -> Result<()> {
        let row = &DOPRI5_ROWS[K - 1];
        let (known, next) = self.stages.split_at_mut(K);
        let target = if K == DOPRI5_STAGES - 1 {
            &mut self.end
        } else {
            &mut self.trial
        };
        stage_state::<S, K>(known, row, (x, h), target);
        rate(dynamics, drive, target, &mut next[0])
    }

    /// The error of the step last taken from x, in a function of its own: sums over references that are arguments are vectorised.
    #[inline(never)]
    fn scaled_error(&mut self, x: &S, h: f64, tolerance: Tolerance) -> f64 {
        weighted_sum::<S, DOPRI5_STAGES>(&self.stages, &DOPRI5_ERROR, &mut self.error);
        h.abs() * tolerance.norm(&self.error, (x, &self.end))
    }

    /// The stiffness that the end and the last stage before it tell.
    #[inline]
    fn stiffness(&self, h: f64) -> f64 {
        let rates = [
            &self.stages[DOPRI5_STAGES - 1],
            &self.stages[DOPRI5_STAGES - 2],
        ];
        stiffness(h, rates, [&self.end, &self.trial])
    }
}

impl<S: State> StepEnds<S> for DormandPrince<S> {
    fn start_rate(&self) -> &S {
        &self.stages[0]
    }

    fn end(&self) -> &S {
        &self.end
    }

    fn end_mut(&mut self) -> &mut S {
        &mut self.end
    }

    fn end_rate(&self) -> &S {
        &self.stages[DOPRI5_STAGES - 1]
    }

    fn n_rhs(&self) -> usize {
        self.n_rhs
    }
}

impl<S: State> Stepper<S> for DormandPrince<S> {
    const HAS_QUINTIC: bool = true;

    type Choice = ();
    type Dense = Dense<S, 4>;

    fn new(n_dof: usize, _tolerance: Tolerance, _choice: ()) -> Self {
        let zeros = S::zeros(2 * n_dof);
        Self {
            stages: std::array::from_fn(|_| zeros.clone()),
            trial: zeros.clone(),
            error: zeros.clone(),
            end: zeros,
            n_rhs: 0,
        }
    }

    fn begin<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>) -> Result<()> {
        self.n_rhs += 1;
        let drive = dynamics.drive(start.at);
        rate(dynamics, drive, start.x, &mut self.stages[0])
    }

    /// Afterwards the end is the state of order 5 there.
    #[inline]
    fn step<D: Dynamics>(
        &mut self,
        dynamics: &D,
        StepStart { at, x }: StepStart<'_, S>,
        h: f64,
    ) -> Result<bool> {
        let drive_at = |node: f64| dynamics.drive(at.after(node * h));
        self.stage::<D, 1>(dynamics, drive_at(DOPRI5_NODES[0]), x, h)?;
        self.stage::<D, 2>(dynamics, drive_at(DOPRI5_NODES[1]), x, h)?;
        self.stage::<D, 3>(dynamics, drive_at(DOPRI5_NODES[2]), x, h)?;
        self.stage::<D, 4>(dynamics, drive_at(DOPRI5_NODES[3]), x, h)?;
        // The last two stages are at one time.
        let last = drive_at(DOPRI5_NODES[4]);
        self.stage::<D, 5>(dynamics, last, x, h)?;
        self.stage::<D, 6>(dynamics, last, x, h)?;
        self.n_rhs += DOPRI5_STAGES - 1;
        Ok(true)
    }

    #[inline]
    fn error<D: Dynamics>(
        &mut self,
        _dynamics: &D,
        start: StepStart<'_, S>,
        h: f64,
        tolerance: Tolerance,
    ) -> Result<f64> {
        Ok(self.scaled_error(start.x, h, tolerance))
    }

    #[inline]
    fn dense<D: Dynamics>(
        &mut self,
        _dynamics: &D,
        StepStart { x, .. }: StepStart<'_, S>,
        h: f64,
    ) -> Result<Dense<S, 4>> {
        let mut c: [S; 4] = std::array::from_fn(|_| S::zeros(x.slice().len()));
        for i in 0..x.slice().len() {
            let difference = self.end.slice()[i] - x.slice()[i];
            let first = h * self.stages[0].slice()[i] - difference;
            let last = difference - h * self.stages[DOPRI5_STAGES - 1].slice()[i] - first;
            let mut bump = 0.0;
            for (k, d) in self.stages.iter().zip(&DOPRI5_DENSE) {
                bump += d * k.slice()[i];
            }
            c[0].slice_mut()[i] = difference;
            c[1].slice_mut()[i] = first;
            c[2].slice_mut()[i] = last;
            c[3].slice_mut()[i] = h * bump;
        }
        let start = x.clone();
        Ok(Dense { start, c, h })
    }

    #[inline]
    fn go_on(&mut self) -> bool {
        self.stages.swap(0, DOPRI5_STAGES - 1);
        true
    }

    fn control(&self) -> StepControl {
        StepControl {
            order: 5,
            beta: 0.04,
            least: 0.2,
            most: 10.0,
            kept_below: 1.0,
        }
    }

    #[inline]
    fn accept(&mut self, h: f64, controller: &mut Controller) {
        controller.note_stiffness(self.stiffness(h) > DOPRI5_STABLE);
    }
}
