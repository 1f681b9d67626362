//! Explicit Runge-Kutta methods on `q'' = a(t, q, v)`, each known by its tableau alone (Hairer, Norsett and Wanner, Solving Ordinary
//! Differential Equations I, sections II.4 to II.6).

use crate::error::Result;
use crate::flow::steps::control::{Controller, StepControl};
use crate::flow::steps::dense_output::Dense;
use crate::flow::steps::state::{State, rate, stage_state, stiffness, weighted_sum};
use crate::flow::steps::stepper::{StepEnds, StepStart, Stepper, Tolerance};
use crate::model::Dynamics;
use std::cmp::Ordering;
use std::marker::PhantomData;

/// The coefficients of a method whose solution is the row of its last stage, which is the first stage of the next step. Stages are
/// counted from zero, at the start of the step.
pub(crate) trait ButcherTableau: 'static {
    /// Nodes of the stages from 1 on.
    const NODES: &'static [f64];
    /// Rows of the stages from 1 on, each with a weight for every stage before.
    const ROWS: &'static [&'static [f64]];
    /// The stage at the end of the step, at the node 1; those after it are needed for the dense output alone. [exact]
    const END: usize;
    const ERROR: EmbeddedError;
    /// Coefficients of the dense output beyond the cubic through states and rates of both ends, in its nested form: weights of the stages.
    const DENSE: &'static [&'static [f64]];
    /// As in [`Stepper`].
    const HAS_QUINTIC: bool;
    const CONTROL: StepControl;
    /// Stiffness `h |lambda|` beyond which stability holds the step down: the stability limit on the negative real axis. It is told by
    /// the last two stages, which are at one time; infinite where they are not. [exact]
    const STABLE: f64;
}

/// Weights of the stages in an estimate of the error.
pub(crate) enum EmbeddedError {
    /// The solution less an embedded one.
    One(&'static [f64]),
    /// Estimates of orders 5 and 3 of a method of order 8.
    FifthAndThird(&'static [f64], &'static [f64]),
}

/// The method of a tableau of N stages whose dense output has degree P, with the step last taken.
#[derive(Debug)]
pub(crate) struct ExplicitRk<T, S, const N: usize, const P: usize> {
    /// Rates at the stages.
    pub(super) stages: [S; N],
    /// Whether the stages of the dense output are those of this step.
    is_extended: bool,
    /// The state at the last stage before the end.
    trial: S,
    end: S,
    scratch: S,
    n_rhs: usize,
    tableau: PhantomData<T>,
}

/// Evaluates the stages after one and up to another, out of those that any method has. Their numbers are known when they are
/// compiled: sums over the stages before are written out, zeros left out, and stages at one time share what drives the motion there.
macro_rules! stages {
    ($self:ident, ($after:expr, $last:expr), ($dynamics:ident, $start:ident, $h:ident), $($k:literal)*) => {
        let drive_at = |k: usize| $dynamics.drive($start.at.after(T::NODES[k - 1] * $h));
        let mut drive = drive_at($after + 1);
        $(if const { $after < $k && $k <= $last } {
            if $k > $after + 1 && T::NODES[$k - 1] != T::NODES[$k - 2] {
                drive = drive_at($k);
            }
            $self.stage::<D, $k>($dynamics, &drive, $start.x, $h)?;
        })*
    };
}

impl<T: ButcherTableau, S: State, const N: usize, const P: usize> ExplicitRk<T, S, N, P> {
    /// The rate at stage K from those before it.
    #[inline]
    fn stage<D: Dynamics, const K: usize>(
        &mut self,
        dynamics: &D,
        drive: &D::Drive,
        x: &S,
        h: f64,
    ) -> Result<()> {
        let (known, next) = self.stages.split_at_mut(K);
        let target = match K.cmp(&T::END) {
            Ordering::Less => &mut self.trial,
            Ordering::Equal => &mut self.end,
            Ordering::Greater => &mut self.scratch,
        };
        stage_state(known, T::ROWS[K - 1], (x, h), target);
        rate(dynamics, drive, target, &mut next[0])
    }

    /// The stages that only the dense output needs, once a step.
    fn extend<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>, h: f64) -> Result<()> {
        if const { T::END < T::ROWS.len() } && !self.is_extended {
            stages!(self, (T::END, T::ROWS.len()), (dynamics, start, h), 4 5 6 7 8 9 10 11 12 13 14 15);
            self.n_rhs += T::ROWS.len() - T::END;
            self.is_extended = true;
        }
        Ok(())
    }

    /// Coefficient K of the dense output, beyond the cubic, if there is one: by its number, as a stage.
    #[inline]
    fn set_coefficient<const K: usize>(&self, h: f64, c: &mut [S; P]) {
        if const { K < P } {
            weighted_sum(&self.stages, T::DENSE[K - 3], &mut c[K]);
            c[K].slice_mut().iter_mut().for_each(|c| *c *= h);
        }
    }

    /// The error of the step last taken from x, in a function of its own: sums over references that are arguments are vectorised. An end
    /// without a finite rate, which the estimates of some methods do not see, is an infinite error.
    #[inline(never)]
    fn scaled_error(&mut self, x: &S, h: f64, tolerance: Tolerance) -> f64 {
        let sees_end = matches!(T::ERROR, EmbeddedError::One(_));
        let mut at_end = self.end.slice().iter().chain(self.end_rate().slice());
        if !sees_end && !at_end.all(|x| x.is_finite()) {
            return f64::INFINITY;
        }
        let mut estimate = |weights: &[f64]| {
            weighted_sum(&self.stages, weights, &mut self.scratch);
            tolerance.norm(&self.scratch, (x, &self.end))
        };
        h.abs()
            * match T::ERROR {
                EmbeddedError::One(weights) => estimate(weights),
                EmbeddedError::FifthAndThird(fifth, third) => {
                    combined(estimate(fifth), estimate(third))
                }
            }
    }

    /// The stiffness that the end and the last stage before it tell.
    #[inline]
    pub(super) fn stiffness(&self, h: f64) -> f64 {
        let rates = [&self.stages[T::END], &self.stages[T::END - 1]];
        stiffness(h, rates, [&self.end, &self.trial])
    }
}

/// The estimates of orders 5 and 3 as one of order 8, `e5^2/sqrt(e5^2 + (e3/10)^2)`; infinite if one of them is no finite number.
pub(super) fn combined(fifth: f64, third: f64) -> f64 {
    let size = fifth.hypot(0.1 * third);
    if size == 0.0 {
        0.0
    } else if size.is_finite() {
        fifth * (fifth / size)
    } else {
        f64::INFINITY
    }
}

impl<T: ButcherTableau, S: State, const N: usize, const P: usize> StepEnds<S>
    for ExplicitRk<T, S, N, P>
{
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
        &self.stages[T::END]
    }

    fn n_rhs(&self) -> usize {
        self.n_rhs
    }
}

impl<T: ButcherTableau, S: State, const N: usize, const P: usize> Stepper<S>
    for ExplicitRk<T, S, N, P>
{
    const HAS_QUINTIC: bool = T::HAS_QUINTIC;

    type Choice = ();
    type Dense = Dense<S, P>;

    fn new(n_dof: usize, _tolerance: Tolerance, _choice: ()) -> Self {
        const { assert!(T::ROWS.len() + 1 == N && T::DENSE.len() + 3 == P && P <= 7) }
        let zeros = S::zeros(2 * n_dof);
        Self {
            stages: std::array::from_fn(|_| zeros.clone()),
            is_extended: false,
            trial: zeros.clone(),
            end: zeros.clone(),
            scratch: zeros,
            n_rhs: 0,
            tableau: PhantomData,
        }
    }

    fn begin<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>) -> Result<()> {
        self.n_rhs += 1;
        let drive = dynamics.drive(start.at);
        rate(dynamics, &drive, start.x, &mut self.stages[0])
    }

    #[inline]
    fn step<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>, h: f64) -> Result<bool> {
        self.is_extended = false;
        stages!(self, (0, T::END), (dynamics, start, h), 1 2 3 4 5 6 7 8 9 10 11 12);
        self.n_rhs += T::END;
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
        dynamics: &D,
        start: StepStart<'_, S>,
        h: f64,
    ) -> Result<Dense<S, P>> {
        self.extend(dynamics, start, h)?;
        let x = start.x;
        let mut c: [S; P] = std::array::from_fn(|_| S::zeros(x.slice().len()));
        for i in 0..x.slice().len() {
            let difference = self.end.slice()[i] - x.slice()[i];
            let first = h * self.stages[0].slice()[i] - difference;
            c[0].slice_mut()[i] = difference;
            c[1].slice_mut()[i] = first;
            c[2].slice_mut()[i] = difference - h * self.stages[T::END].slice()[i] - first;
        }
        self.set_coefficient::<3>(h, &mut c);
        self.set_coefficient::<4>(h, &mut c);
        self.set_coefficient::<5>(h, &mut c);
        self.set_coefficient::<6>(h, &mut c);
        let start = x.clone();
        Ok(Dense { start, c, h })
    }

    #[inline]
    fn go_on(&mut self) -> bool {
        self.stages.swap(0, T::END);
        true
    }

    fn control(&self) -> StepControl {
        T::CONTROL
    }

    #[inline]
    fn accept(&mut self, h: f64, controller: &mut Controller) {
        controller.note_stiffness(self.stiffness(h) > T::STABLE);
    }
}
