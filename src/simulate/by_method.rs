//! Runs of a scene by its method: what each method moves a scene by, and what reads the arcs that it keeps.

use crate::error::Result;
use crate::flow::steps::chosen::{ChosenSteps, StepChoice};
use crate::flow::steps::{DenseOutput, DormandPrince, State, Stepper};
use crate::flow::{TimedScene, with_flow};
use crate::hybrid::{ClosedForm, InSteps, IntegratedFlow, Pendulum, Taylor, series_order};
use crate::model::{ByInput, ByParts, Dynamics, Links, Scene, SceneMotion};
use crate::path::Evaluator;
use crate::simulate::method::Method;
use crate::simulate::options::SimulateOptions;
use crate::simulate::run::{AnyRun, Run};
use std::sync::Arc;

/// Runs along the Taylor series of a pendulum.
pub(crate) type SeriesRun<'a, S, D> = Run<'a, IntegratedFlow<'a, S, D, Taylor>>;

/// What makes runs, one for each thread.
pub(crate) type RunMaker<'m, 'a> = dyn Fn() -> Box<AnyRun<'a>> + Sync + 'm;

/// A computation on runs of a scene.
pub(crate) trait RunVisitor: Sized {
    type Output;

    /// The name in errors of what takes linear scenes alone.
    const BY_EXACT_FLIGHTS: &'static str;

    /// Takes what makes runs, and what reads the arcs that they keep but for motions with stops held, which a run leaves behind.
    fn visit(self, make: &RunMaker<'_, '_>, evaluator: Evaluator) -> Result<Self::Output>;

    /// Takes runs along Taylor series, which may be computed in a batch.
    fn visit_series<'a, S: State, D: Dynamics + 'a>(
        self,
        make: impl Fn() -> SeriesRun<'a, S, D> + Sync,
        evaluator: Evaluator,
    ) -> Result<Self::Output> {
        self.visit(&|| Box::new(make()), evaluator)
    }
}

/// Visits runs of a scene by the method of the options.
///
/// # Errors
/// A method that the scene does not have; those of the visitor.
pub(crate) fn visit_runs<V: RunVisitor>(
    scene: &Scene,
    options: &SimulateOptions,
    visitor: V,
) -> Result<V::Output> {
    let method = options.solver.method.chosen_for(scene);
    if method == Method::Taylor {
        return match &Pendulum::new(scene)? {
            Pendulum::Double(motion, links) => {
                along_series::<[f64; 4], _, _>((motion, links), scene, options, visitor)
            }
            Pendulum::Chain(motion, links) => {
                along_series::<Vec<f64>, _, _>((motion, links), scene, options, visitor)
            }
        };
    }
    let (mut visitor, mut output) = (Some(visitor), None);
    let mut visit = |make: &RunMaker<'_, '_>, evaluator: Evaluator| {
        output = visitor.take().map(|visitor| visitor.visit(make, evaluator));
    };
    if method == Method::Exact {
        in_closed_form(scene, options, V::BY_EXACT_FLIGHTS, &mut visit)?;
    } else {
        in_steps_of((scene, options), method.choice(), &mut visit);
    }
    output.expect("runs of any method are visited once")
}

/// Takes what makes runs, and what reads the arcs that they keep.
type Visit<'v> = dyn FnMut(&RunMaker<'_, '_>, Evaluator) + 'v;

/// Visits runs in closed form.
fn in_closed_form(
    scene: &Scene,
    options: &SimulateOptions,
    purpose: &str,
    visit: &mut Visit<'_>,
) -> Result<()> {
    let timed = TimedScene::of(scene, purpose)?;
    let evaluator = Evaluator::Exact {
        modal: Arc::clone(&timed.modal),
        flow: Arc::clone(&timed.flow),
        regimes: Vec::new(),
        // The amplitudes of a timed scene have the phase already.
        phase: 0.0,
    };
    // For the phases of impacts in the records alone.
    let phase = scene.phase();
    with_flow!(&*timed.flow, flow => {
        let flow = || ClosedForm::new(flow, &timed, phase, options.solver.tolerances());
        visit(&|| Box::new(Run::new(flow(), options, scene)), evaluator);
    });
    Ok(())
}

/// Visits runs in the steps of a method, those of the pair where none of the others is chosen.
fn in_steps_of(
    given: (&Scene, &SimulateOptions),
    choice: Option<StepChoice>,
    visit: &mut Visit<'_>,
) {
    let m = &SceneMotion::new(given.0);
    let Some(choice) = choice else {
        return in_pairs(m, given, visit);
    };
    match m.n_dof() {
        1 => in_steps::<[f64; 2], Chosen, _>(m, given, choice, visit),
        2 => in_steps::<[f64; 4], Chosen, _>(m, given, choice, visit),
        _ => in_steps::<Vec<f64>, Chosen, _>(m, given, choice, visit),
    }
}

/// Visits runs along Taylor series.
fn along_series<S: State, D: Dynamics + Sync, V: RunVisitor>(
    (motion, links): (&D, &Links),
    scene: &Scene,
    options: &SimulateOptions,
    visitor: V,
) -> Result<V::Output> {
    let make = || {
        let free = Taylor::new(links.clone(), scene, options.solver.rtol);
        let flow = IntegratedFlow::<S, D, _>::new(motion, scene, options.solver.tolerances(), free);
        Run::new(flow, options, scene)
    };
    let order = series_order(options.solver.rtol);
    visitor.visit_series(make, Evaluator::Series { order })
}

/// Steps for states of any kind.
trait AnySteps {
    type Choice: Copy + Sync;
    type Of<S: State>: Stepper<S, Choice = Self::Choice>;
}

/// The pair of orders 5 and 4.
struct DormandPrinceSteps;

impl AnySteps for DormandPrinceSteps {
    type Choice = ();
    type Of<S: State> = DormandPrince<S>;
}

/// The others, for any motion.
struct Chosen;

impl AnySteps for Chosen {
    type Choice = StepChoice;
    type Of<S: State> = ChosenSteps<S>;
}

/// Runs a block of code with a linear motion, whatever it has.
macro_rules! by_parts {
    ($motion:expr, $by:ident => $body:expr) => {
        match $motion.by_parts() {
            ByParts::Free($by) => $body,
            ByParts::Driven($by) => $body,
            ByParts::Damped($by) => $body,
            ByParts::DampedDriven($by) => $body,
        }
    };
}

/// Visits runs in steps of the pair, with a state of the type that fits a motion: those of one or two coordinates, and diagonal ones,
/// take so little work that they have code of their own.
fn in_pairs(motion: &SceneMotion, given: (&Scene, &SimulateOptions), visit: &mut Visit<'_>) {
    match motion {
        SceneMotion::Full(m) if m.n_dof() == 1 => by_parts!(m, m => {
            in_steps::<[f64; 2], DormandPrinceSteps, _>(&m, given, (), visit);
        }),
        SceneMotion::Full(m) if m.n_dof() == 2 => by_parts!(m, m => {
            in_steps::<[f64; 4], DormandPrinceSteps, _>(&m, given, (), visit);
        }),
        SceneMotion::Diagonal(m) => {
            in_steps::<Vec<f64>, DormandPrinceSteps, _>(m, given, (), visit);
        }
        SceneMotion::DoublePendulum(m) => match m.by_input() {
            ByInput::Free(m) => in_steps::<[f64; 4], DormandPrinceSteps, _>(&m, given, (), visit),
            ByInput::Driven(m) => in_steps::<[f64; 4], DormandPrinceSteps, _>(&m, given, (), visit),
        },
        SceneMotion::Nonlinear(m) if m.n_dof() == 1 => {
            in_steps::<[f64; 2], DormandPrinceSteps, _>(m, given, (), visit);
        }
        SceneMotion::Nonlinear(m) if m.n_dof() == 2 => {
            in_steps::<[f64; 4], DormandPrinceSteps, _>(m, given, (), visit);
        }
        _ => in_steps::<Vec<f64>, DormandPrinceSteps, _>(motion, given, (), visit),
    }
}

/// Visits runs in steps.
fn in_steps<S: State, P: AnySteps, D: Dynamics + Sync>(
    motion: &D,
    (scene, options): (&Scene, &SimulateOptions),
    choice: P::Choice,
    visit: &mut Visit<'_>,
) {
    let make = || {
        let free = InSteps::<P::Choice, P::Of<S>>::new(choice);
        let flow = IntegratedFlow::<S, D, _>::new(motion, scene, options.solver.tolerances(), free);
        Box::new(Run::new(flow, options, scene)) as Box<AnyRun<'_>>
    };
    let degree = <P::Of<S> as Stepper<S>>::Dense::DEGREE;
    visit(&make, Evaluator::Steps { degree });
}
