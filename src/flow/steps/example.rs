#![cfg(test)]
//! The worked example of `docs/extending.md`: an integrator from scratch, the pair of Bogacki and Shampine of orders 3 and 2 (Appl. Math.
//! Lett. 2 (1989) 321) with the cubic through both ends as its dense output.

use crate::error::Result;
use crate::flow::steps::control::StepControl;
use crate::flow::steps::dense_output::Dense;
use crate::flow::steps::state::{State, rate, stage_state, weighted_sum};
use crate::flow::steps::stepper::{StepEnds, StepStart, Stepper, Tolerance};
use crate::model::Dynamics;

/// Rows of stages 2 to 4, the last of them the solution. [exact]
const BOGACKI_SHAMPINE_ROWS: [[f64; 3]; 3] = [
    [0.5, 0.0, 0.0],
    [0.0, 0.75, 0.0],
    [2.0 / 9.0, 1.0 / 3.0, 4.0 / 9.0],
];
/// Nodes of stages 2 to 4. [exact]
const BOGACKI_SHAMPINE_NODES: [f64; 3] = [0.5, 0.75, 1.0];
/// The solution of order 3 less that of order 2. [exact]
const BOGACKI_SHAMPINE_ERROR: [f64; 4] = [-5.0 / 72.0, 1.0 / 12.0, 1.0 / 9.0, -1.0 / 8.0];

/// The pair, with the step last taken.
pub(crate) struct BogackiShampine<S> {
    /// Rates at the stages; the first at the start, the last at the end.
    stages: [S; 4],
    end: S,
    error: S,
    n_rhs: usize,
}

impl<S: State> StepEnds<S> for BogackiShampine<S> {
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
        &self.stages[3]
    }

    fn n_rhs(&self) -> usize {
        self.n_rhs
    }
}

impl<S: State> Stepper<S> for BogackiShampine<S> {
    const HAS_QUINTIC: bool = true;

    type Choice = ();
    type Dense = Dense<S, 3>;

    fn new(n_dof: usize, _tolerance: Tolerance, _choice: ()) -> Self {
        let zeros = S::zeros(2 * n_dof);
        Self {
            stages: std::array::from_fn(|_| zeros.clone()),
            end: zeros.clone(),
            error: zeros,
            n_rhs: 0,
        }
    }

    fn begin<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>) -> Result<()> {
        self.n_rhs += 1;
        let drive = dynamics.drive(start.at);
        rate(dynamics, drive, start.x, &mut self.stages[0])
    }

    fn step<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>, h: f64) -> Result<bool> {
        for (k, (row, node)) in BOGACKI_SHAMPINE_ROWS
            .iter()
            .zip(BOGACKI_SHAMPINE_NODES)
            .enumerate()
        {
            let (known, next) = self.stages.split_at_mut(k + 1);
            // Rates that are not known yet have no weight.
            stage_state::<S, 3>(known, row, (start.x, h), &mut self.end);
            let drive = dynamics.drive(start.at.after(node * h));
            rate(dynamics, drive, &self.end, &mut next[0])?;
        }
        self.n_rhs += 3;
        Ok(true)
    }

    fn error<D: Dynamics>(
        &mut self,
        _dynamics: &D,
        start: StepStart<'_, S>,
        h: f64,
        tolerance: Tolerance,
    ) -> Result<f64> {
        weighted_sum::<S, 4>(&self.stages, &BOGACKI_SHAMPINE_ERROR, &mut self.error);
        let ends = (start.x, &self.end);
        Ok(h.abs() * tolerance.norm(&self.error, ends))
    }

    fn dense<D: Dynamics>(
        &mut self,
        _dynamics: &D,
        start: StepStart<'_, S>,
        h: f64,
    ) -> Result<Dense<S, 3>> {
        let mut c: [S; 3] = std::array::from_fn(|_| S::zeros(start.x.slice().len()));
        for (i, x) in start.x.slice().iter().enumerate() {
            let difference = self.end.slice()[i] - x;
            let first = h * self.stages[0].slice()[i] - difference;
            c[0].slice_mut()[i] = difference;
            c[1].slice_mut()[i] = first;
            c[2].slice_mut()[i] = difference - h * self.stages[3].slice()[i] - first;
        }
        let start = start.x.clone();
        Ok(Dense { start, c, h })
    }

    fn go_on(&mut self) -> bool {
        self.stages.swap(0, 3);
        true
    }

    fn control(&self) -> StepControl {
        StepControl {
            order: 3,
            beta: 0.04,
            least: 0.2,
            most: 10.0,
            kept_below: 1.0,
        }
    }
}
