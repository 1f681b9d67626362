//! A method that gives over to the implicit one, for good, from the step on at which stability holds its steps down (theory 8).

use crate::error::Result;
use crate::flow::steps::control::{Controller, StepControl};
use crate::flow::steps::dense_output::Dense;
use crate::flow::steps::radau::Radau;
use crate::flow::steps::state::State;
use crate::flow::steps::stepper::{StepEnds, StepStart, Stepper, Tolerance};
use crate::model::Dynamics;

/// An explicit method E with a dense output of degree P, and the implicit one.
pub(crate) struct Switching<S, E, const P: usize> {
    explicit: E,
    implicit: Radau<S>,
    /// Whether the next step that begins anew is implicit, and whether steps are.
    is_due: bool,
    is_implicit: bool,
}

/// Runs a block of code with the method that steps now.
macro_rules! with_present {
    ($switching:expr, $method:ident => $body:expr) => {
        if $switching.is_implicit {
            let $method = &$switching.implicit;
            $body
        } else {
            let $method = &$switching.explicit;
            $body
        }
    };
    (mut $switching:expr, $method:ident => $body:expr) => {
        if $switching.is_implicit {
            let $method = &mut $switching.implicit;
            $body
        } else {
            let $method = &mut $switching.explicit;
            $body
        }
    };
}

impl<S: State, E: Stepper<S>, const P: usize> StepEnds<S> for Switching<S, E, P> {
    fn start_rate(&self) -> &S {
        with_present!(self, method => method.start_rate())
    }

    fn end(&self) -> &S {
        with_present!(self, method => method.end())
    }

    fn end_mut(&mut self) -> &mut S {
        with_present!(mut self, method => method.end_mut())
    }

    fn end_rate(&self) -> &S {
        with_present!(self, method => method.end_rate())
    }

    fn n_rhs(&self) -> usize {
        self.explicit.n_rhs() + self.implicit.n_rhs()
    }
}

impl<S, E, const P: usize> Stepper<S> for Switching<S, E, P>
where
    S: State,
    E: Stepper<S, Dense = Dense<S, P>>,
{
    const NAMES: &'static [&'static str] = &[E::NAMES[0], <Radau<S> as Stepper<S>>::NAMES[0]];

    const HAS_QUINTIC: bool = false;

    type Dense = Dense<S, P>;

    fn new(n_dof: usize, tolerance: Tolerance) -> Self {
        Self {
            explicit: E::new(n_dof, tolerance),
            implicit: Radau::new(n_dof, tolerance),
            is_due: false,
            is_implicit: false,
        }
    }

    fn begin<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>) -> Result<()> {
        self.is_implicit |= self.is_due;
        with_present!(mut self, method => method.begin(dynamics, start))
    }

    fn step<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>, h: f64) -> Result<bool> {
        with_present!(mut self, method => method.step(dynamics, start, h))
    }

    fn error<D: Dynamics>(
        &mut self,
        dynamics: &D,
        start: StepStart<'_, S>,
        h: f64,
        tolerance: Tolerance,
    ) -> Result<f64> {
        with_present!(mut self, method => method.error(dynamics, start, h, tolerance))
    }

    fn dense<D: Dynamics>(
        &mut self,
        dynamics: &D,
        start: StepStart<'_, S>,
        h: f64,
    ) -> Result<Dense<S, P>> {
        if self.is_implicit {
            Ok(self.implicit.dense(dynamics, start, h)?.raised())
        } else {
            self.explicit.dense(dynamics, start, h)
        }
    }

    fn go_on(&mut self) -> bool {
        let goes_on = with_present!(mut self, method => method.go_on());
        goes_on && self.is_implicit == self.is_due
    }

    fn control(&self) -> StepControl {
        with_present!(self, method => method.control())
    }

    fn accept(&mut self, h: f64, controller: &mut Controller) {
        with_present!(mut self, method => method.accept(h, controller));
        self.is_due |= controller.is_stiff;
    }
}
