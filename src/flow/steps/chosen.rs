//! A method chosen when a run begins, and the one that fits: explicit steps that give over to the implicit method, for good, from the
//! step on at which stability holds them down (theory 8).

use crate::error::Result;
use crate::flow::steps::control::{Controller, StepControl};
use crate::flow::steps::dense_output::Dense;
use crate::flow::steps::dop853::Dop853;
use crate::flow::steps::dormand_prince::DormandPrince;
use crate::flow::steps::radau::Radau;
use crate::flow::steps::state::State;
use crate::flow::steps::stepper::{StepEnds, StepStart, Stepper, Tolerance};
use crate::model::Dynamics;
use crate::tolerance::LOOSE_RELATIVE_TOLERANCE;

/// Degree of the dense output of any method: that of DOP853. [exact]
const HIGHEST_DENSE_DEGREE: usize = 7;

/// Which method is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum StepChoice {
    /// The one that fits.
    #[default]
    Fitting,
    Dop853,
    Radau,
}

/// The method that steps now.
#[allow(
    clippy::large_enum_variant,
    reason = "there is one in a run, and every step would follow a pointer"
)]
enum Running<S> {
    DormandPrince(DormandPrince<S>),
    Dop853(Dop853<S>),
    Radau(Radau<S>),
}

/// Runs a block of code with the method that steps now.
macro_rules! with_present {
    ($present:expr, $method:ident => $body:expr) => {
        match $present {
            Running::DormandPrince($method) => $body,
            Running::Dop853($method) => $body,
            Running::Radau($method) => $body,
        }
    };
}

/// Steps of the method that is asked for.
pub(crate) struct ChosenSteps<S> {
    present: Running<S>,
    /// What an implicit method is made for, where it may have to take over.
    then: Option<(usize, Tolerance)>,
    /// Whether it does at the next beginning.
    is_due: bool,
    /// Evaluations of the right-hand side by the method before.
    rhs_before: usize,
}

impl<S: State> StepEnds<S> for ChosenSteps<S> {
    fn start_rate(&self) -> &S {
        with_present!(&self.present, method => method.start_rate())
    }

    fn end(&self) -> &S {
        with_present!(&self.present, method => method.end())
    }

    fn end_mut(&mut self) -> &mut S {
        with_present!(&mut self.present, method => method.end_mut())
    }

    fn end_rate(&self) -> &S {
        with_present!(&self.present, method => method.end_rate())
    }

    fn n_rhs(&self) -> usize {
        self.rhs_before + with_present!(&self.present, method => method.n_rhs())
    }

    fn fitting(&self) -> Option<&'static str> {
        let is_fitting = self.then.is_some() || self.rhs_before > 0;
        is_fitting.then_some(match self.present {
            Running::DormandPrince(_) => "rk45",
            Running::Dop853(_) => "dop853",
            Running::Radau(_) => "radau",
        })
    }
}

impl<S: State> Stepper<S> for ChosenSteps<S> {
    const HAS_QUINTIC: bool = false;

    type Choice = StepChoice;
    type Dense = Dense<S, HIGHEST_DENSE_DEGREE>;

    fn new(n_dof: usize, tolerance: Tolerance, choice: StepChoice) -> Self {
        let explicit = || {
            if tolerance.relative < LOOSE_RELATIVE_TOLERANCE {
                Running::Dop853(Dop853::new(n_dof, tolerance, ()))
            } else {
                Running::DormandPrince(DormandPrince::new(n_dof, tolerance, ()))
            }
        };
        Self {
            present: match choice {
                StepChoice::Fitting => explicit(),
                StepChoice::Dop853 => Running::Dop853(Dop853::new(n_dof, tolerance, ())),
                StepChoice::Radau => Running::Radau(Radau::new(n_dof, tolerance, ())),
            },
            then: (choice == StepChoice::Fitting).then_some((n_dof, tolerance)),
            is_due: false,
            rhs_before: 0,
        }
    }

    fn begin<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>) -> Result<()> {
        if self.is_due
            && let Some((n_dof, tolerance)) = self.then.take()
        {
            self.rhs_before = self.n_rhs();
            self.present = Running::Radau(Radau::new(n_dof, tolerance, ()));
        }
        with_present!(&mut self.present, method => method.begin(dynamics, start))
    }

    fn step<D: Dynamics>(&mut self, dynamics: &D, start: StepStart<'_, S>, h: f64) -> Result<bool> {
        with_present!(&mut self.present, method => method.step(dynamics, start, h))
    }

    fn error<D: Dynamics>(
        &mut self,
        dynamics: &D,
        start: StepStart<'_, S>,
        h: f64,
        tolerance: Tolerance,
    ) -> Result<f64> {
        with_present!(&mut self.present, method => method.error(dynamics, start, h, tolerance))
    }

    fn dense<D: Dynamics>(
        &mut self,
        dynamics: &D,
        start: StepStart<'_, S>,
        h: f64,
    ) -> Result<Dense<S, HIGHEST_DENSE_DEGREE>> {
        with_present!(&mut self.present, method => Ok(method.dense(dynamics, start, h)?.raised()))
    }

    fn go_on(&mut self) -> bool {
        let goes_on = with_present!(&mut self.present, method => method.go_on());
        goes_on && !(self.is_due && self.then.is_some())
    }

    fn control(&self) -> StepControl {
        with_present!(&self.present, method => method.control())
    }

    fn accept(&mut self, h: f64, controller: &mut Controller) {
        with_present!(&mut self.present, method => method.accept(h, controller));
        self.is_due = controller.is_stiff;
    }
}
