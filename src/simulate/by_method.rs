//! Runs of a scene by its method: what each method moves a scene by, and what reads the arcs that it keeps.

use crate::error::Result;
use crate::flow::steps::chosen::{ChosenSteps, StepChoice};
use crate::flow::steps::{DenseOutput, DormandPrince, State, Stepper};
use crate::flow::{TimedScene, with_flow};
use crate::hybrid::{AnyLoop, ClosedForm, InSteps, IntegratedFlow, Pendulum, Taylor, series_order};
use crate::model::{Dynamics, Links, Scene, SceneMotion, with_motion};
use crate::path::Evaluator;
use crate::simulate::method::Method;
use crate::simulate::options::SimulateOptions;
use crate::simulate::run::Run;
use std::sync::Arc;

/// Runs along the Taylor series of a pendulum.
pub(crate) type SeriesRun<'a, S, D> = Run<'a, IntegratedFlow<'a, S, D, Taylor>>;

/// What is done with runs of a scene, whatever they are made of.
pub(crate) trait RunVisitor: Sized {
    type Output;

    /// What takes linear scenes alone, to be named in errors.
    const BY_EXACT_FLIGHTS: &'static str;

    /// Takes what makes runs, and what reads the arcs that they keep but for motions with stops held, which a run leaves behind.
    fn visit<'a, M: AnyLoop>(
        self,
        make: impl Fn() -> Run<'a, M> + Sync,
        evaluator: Evaluator,
    ) -> Result<Self::Output>;

    /// The same of runs along Taylor series, which may go side by side.
    fn visit_series<'a, S: State, D: Dynamics + 'a>(
        self,
        make: impl Fn() -> SeriesRun<'a, S, D> + Sync,
        evaluator: Evaluator,
    ) -> Result<Self::Output> {
        self.visit(make, evaluator)
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
    match options.method.chosen_for(scene) {
        Method::Exact => {
            let timed = TimedScene::of(scene, V::BY_EXACT_FLIGHTS)?;
            let evaluator = Evaluator::Exact {
                modal: Arc::clone(&timed.modal),
                flow: Arc::clone(&timed.flow),
                held: Vec::new(),
                phase: 0.0,
            };
            let (phase, n_dof) = (scene.phase(), scene.n_dof());
            with_flow!(&*timed.flow, flow => {
                let flow = || ClosedForm::new(flow, &timed, phase, options.tolerances());
                visitor.visit(|| Run::new(flow(), options, n_dof), evaluator)
            })
        }
        Method::Taylor => match &Pendulum::new(scene)? {
            Pendulum::Double(motion, links) => {
                along_series::<[f64; 4], _, _>((motion, links), scene, options, visitor)
            }
            Pendulum::Chain(motion, links) => {
                along_series::<Vec<f64>, _, _>((motion, links), scene, options, visitor)
            }
        },
        steps => {
            let motion = SceneMotion::new(scene);
            if let Some(choice) = steps.choice() {
                return in_steps::<Chosen, _, _>(&motion, scene, options, choice, visitor);
            }
            with_motion!(&motion, motion => {
                in_steps::<PairByMotion, _, _>(motion, scene, options, (), visitor)
            })
        }
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
        let free = Taylor::new(links.clone(), scene, options.rtol);
        let flow = IntegratedFlow::<S, D, _>::new(motion, scene, options.tolerances(), free);
        Run::new(flow, options, scene.n_dof())
    };
    let order = series_order(options.rtol);
    visitor.visit_series(make, Evaluator::Series { order })
}

/// Steps for states of any kind.
trait AnySteps {
    type Choice: Copy + Sync;
    type Of<S: State>: Stepper<S, Choice = Self::Choice>;
}

/// The pair of orders 5 and 4, whose steps are so little work that they have code of their own for every kind of motion.
struct PairByMotion;

impl AnySteps for PairByMotion {
    type Choice = ();
    type Of<S: State> = DormandPrince<S>;
}

/// The others, for any motion.
struct Chosen;

impl AnySteps for Chosen {
    type Choice = StepChoice;
    type Of<S: State> = ChosenSteps<S>;
}

/// Visits runs in steps, with a state of the type that fits a motion.
fn in_steps<P: AnySteps, D: Dynamics + Sync, V: RunVisitor>(
    motion: &D,
    scene: &Scene,
    options: &SimulateOptions,
    choice: P::Choice,
    visitor: V,
) -> Result<V::Output> {
    match motion.n_dof() {
        1 if const { D::IN_ARRAYS[0] } => {
            stepped::<[f64; 2], P, D, V>(motion, scene, options, choice, visitor)
        }
        2 if const { D::IN_ARRAYS[1] } => {
            stepped::<[f64; 4], P, D, V>(motion, scene, options, choice, visitor)
        }
        _ => stepped::<Vec<f64>, P, D, V>(motion, scene, options, choice, visitor),
    }
}

/// Visits runs in steps.
fn stepped<S: State, P: AnySteps, D: Dynamics + Sync, V: RunVisitor>(
    motion: &D,
    scene: &Scene,
    options: &SimulateOptions,
    choice: P::Choice,
    visitor: V,
) -> Result<V::Output> {
    let make = || {
        let free = InSteps::<P::Choice, P::Of<S>>::new(choice);
        let flow = IntegratedFlow::<S, D, _>::new(motion, scene, options.tolerances(), free);
        Run::new(flow, options, scene.n_dof())
    };
    let degree = <P::Of<S> as Stepper<S>>::Dense::DEGREE;
    visitor.visit(make, Evaluator::Steps { degree })
}
