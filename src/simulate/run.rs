//! `simulate`: from a scene and a state to a trajectory.

use crate::error::{Error, Result, shortened};
use crate::flow::steps::{State, Stepper};
use crate::flow::{ConstrainedMotion, LinearFlow, TimedScene, with_flow};
use crate::hybrid::{
    AnyLoop, ClosedForm, HybridFlow, InSteps, IntegratedFlow, Pendulum, Present, Taylor,
    series_order,
};
use crate::linalg::singular::overflow;
use crate::model::{Dynamics, Links, PhysicalState, Scene, SceneMotion};
use crate::path::{Evaluator, Path};
use crate::quantity::{finite_vector, room_for};
use crate::simulate::event_loop::{Ending, EventLoop};
use crate::simulate::method::{Method, check_jacobian, with_steps};
use crate::simulate::options::{SimulateOptions, Stats, Status};
use crate::simulate::record::Record;
use crate::simulate::trajectory::Trajectory;
use nalgebra::DVector;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Simulates a scene from `(q0, v0)` over a span of time.
///
/// A linear scene flies in closed form from impact to impact; each next impact is provably the first one. A pendulum with large
/// motions follows its Taylor series (`Method::Taylor`), whose order is chosen by the tolerance and along which every gap is a
/// polynomial, with the same proof. Other scenes are integrated by the method of order 8 of Dormand and Prince (`Method::Dop853`),
/// or by their pair of orders 5 and 4 (`Method::Rk45`) for loose tolerances, and by the implicit Radau IIA method of order 5
/// (`Method::Radau`) from where the motion is found stiff; every contact on the interpolant of a step is found, and reached by a
/// step of its own, as is a minimum of a gap that the interpolant cannot tell from a contact. Impacts that accumulate are
/// completed, stops that stay in contact are held and let go by their force; what cannot be resolved, such as a jam, ends the run
/// with a status of its own.
///
/// A stop that the computed motion passes by more than the rounding of the gap is hit, however slowly; a minimum within that is
/// a graze, listed and no impact, and so is a gap that stays within it. Tolerances have a say at the start alone: a gap within
/// the margin `10 (atol |n|_1 + rtol * size)` below zero is closed, and the start is moved onto its stop. Exact flights have
/// errors of rounding alone: tolerances looser than the default do not widen their margin.
///
/// # Errors
/// Arrays of the wrong length or not finite, a span that runs backwards, a start deeper inside a stop than that margin,
/// `Method::Exact` for a nonlinear scene or `Method::Taylor` for one without series, a motion that grows beyond the doubles.
///
/// # References
/// Theory sections 8 and 9; J. R. Dormand and P. J. Prince, J. Comp. Appl. Math. 6 (1980) 19; E. Hairer, S. P. Norsett and G. Wanner,
/// Solving Ordinary Differential Equations I, section II.10, and II, section IV.8, for the methods of order 8 and 5; A. Jorba and M. Zou,
/// Experimental Mathematics 14 (2005) 99, for steps and orders of Taylor series.
///
/// # Examples
/// ```
/// use vibroimpact::{Kind, OrbitOptions, PaperOptions, Pattern, SimulateOptions, paper_scene, periodic_orbits, simulate};
/// let scene = paper_scene(Kind::Three, &PaperOptions::default())?;
/// let orbits = periodic_orbits(&scene, &Pattern::single(1), &OrbitOptions { n_periods: 2, ..Default::default() })?;
/// let orbit = &orbits[0];
/// let span = (0.0, 100.0 * orbit.period());
/// let trajectory = simulate(orbit.scene(), &orbit.q0(), &orbit.v0(), span, &SimulateOptions::default())?;
/// assert!((trajectory.last().0 - orbit.q0()).amax() < 1e-10);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn simulate(
    scene: &Scene,
    q0: &DVector<f64>,
    v0: &DVector<f64>,
    t_span: (f64, f64),
    options: &SimulateOptions,
) -> Result<Trajectory> {
    simulate_observed(scene, q0, v0, t_span, options, &mut |_| {
        ControlFlow::Continue(())
    })
}

/// [`simulate()`], asking `observer` from time to time, with the time reached, whether to go on. The eigenproblem of order 2n at
/// the first lasting contact of exact flights is one piece of work, in which it is not asked: a second or more for n = 200.
///
/// # Errors
/// As [`simulate()`]; `Error::Interrupted` when the observer breaks off.
pub fn simulate_observed(
    scene: &Scene,
    q0: &DVector<f64>,
    v0: &DVector<f64>,
    t_span: (f64, f64),
    options: &SimulateOptions,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Trajectory> {
    finite_vector("q0", q0, scene.n_dof())?;
    finite_vector("v0", v0, scene.n_dof())?;
    options.check(t_span)?;
    let n_samples = options.t_eval.as_ref().map_or(0, Vec::len);
    room_for("the motion at t_eval", 2 * n_samples, scene.n_dof())?;
    let beyond = || {
        let rule = "the motion grows beyond the largest number in it";
        Error::bad_value("t_span", format!("{t_span:?}"), rule)
    };
    let flown = run_by_method(scene, (q0, v0), t_span, options, observer);
    let (evaluator, done) = flown.map_err(|e| if e == overflow() { beyond() } else { e })?;
    if !(done.last.0.iter().chain(&done.last.1)).all(|x| x.is_finite()) {
        return Err(beyond());
    }
    let Ending {
        time,
        status,
        message,
    } = done.ending;
    let (impacts, grazes, samples, kept) = done.record.finish();
    Ok(Trajectory {
        scene: scene.clone(),
        last: done.last,
        path: kept.map(|parts| Path {
            evaluator,
            parts,
            span: (t_span.0, time),
            n_dof: scene.n_dof(),
        }),
        span: (t_span.0, time),
        impacts,
        grazes,
        samples,
        status,
        message,
        stats: done.stats,
    })
}

/// Simulates by the method that fits.
fn run_by_method(
    scene: &Scene,
    (q0, v0): (&DVector<f64>, &DVector<f64>),
    t_span: (f64, f64),
    options: &SimulateOptions,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<(Evaluator, Done)> {
    let method = options.method.chosen_for(scene);
    Ok(match method {
        Method::Exact => {
            let timed = TimedScene::of(scene, "simulate with method=\"exact\"")?;
            let TimedScene { modal, flow, .. } = &*timed;
            let phase = scene.phase();
            let done = with_flow!(&**flow, f => {
                Run::exact(f, &timed, phase, options).run(q0, v0, t_span, observer)
            })?;
            let exact = Evaluator::Exact {
                modal: Arc::clone(modal),
                flow: Arc::clone(flow),
                held: done.held.clone(),
                phase: 0.0,
            };
            (exact, done)
        }
        Method::Taylor => {
            let pendulum = Pendulum::new(scene)?;
            let done = with_series!(&pendulum, scene, options, make => {
                make().run(q0, v0, t_span, observer)
            })?;
            let order = series_order(options.rtol);
            (Evaluator::Series { order }, done)
        }
        steps => {
            check_jacobian(steps, scene, t_span.0, (q0, v0))?;
            let motion = SceneMotion::new(scene);
            with_steps!(steps, &motion, scene, options, make => {
                let mut run = make();
                let degree = run.flow.degree();
                (Evaluator::Steps { degree }, run.run(q0, v0, t_span, observer)?)
            })
        }
    })
}

/// Runs a block of code with what makes runs along the Taylor series of a pendulum.
macro_rules! with_series {
    ($pendulum:expr, $scene:expr, $options:expr, $make:ident => $body:expr) => {
        match $pendulum {
            $crate::hybrid::Pendulum::Double(motion, links) => {
                let $make = || {
                    $crate::simulate::Run::along_series::<[f64; 4], _>(
                        motion, links, $scene, $options,
                    )
                };
                $body
            }
            $crate::hybrid::Pendulum::Chain(motion, links) => {
                let $make = || {
                    $crate::simulate::Run::along_series::<Vec<f64>, _>(
                        motion, links, $scene, $options,
                    )
                };
                $body
            }
        }
    };
}
pub(crate) use with_series;

/// What a run leaves behind.
pub(crate) struct Done {
    pub ending: Ending,
    pub last: PhysicalState,
    pub stats: Stats,
    record: Record,
    /// The motions while stops were held.
    held: Vec<Arc<ConstrainedMotion>>,
}

/// One run after another of the same scene, with their buffers.
pub(crate) struct Run<'a, M> {
    pub flow: M,
    pub events: EventLoop,
    pub options: &'a SimulateOptions,
    pub n_dof: usize,
}

impl<'a> Run<'a, ()> {
    /// Runs along the flow of a linear scene.
    pub fn exact<F: LinearFlow>(
        flow: &'a F,
        timed: &'a TimedScene,
        phase: f64,
        options: &'a SimulateOptions,
    ) -> Run<'a, ClosedForm<'a, F>> {
        let flow = ClosedForm::new(flow, timed, phase, options.tolerance());
        Run::of(flow, options, timed.modal.form.n_dof())
    }

    /// Runs in steps.
    pub fn stepped<S: State, D: Dynamics, P: Stepper<S>>(
        dynamics: &'a D,
        scene: &'a Scene,
        options: &'a SimulateOptions,
        choice: P::Choice,
    ) -> Run<'a, IntegratedFlow<'a, S, D, InSteps<P::Choice, P>>> {
        let flow = IntegratedFlow::new(dynamics, scene, options.tolerance(), InSteps::new(choice));
        Run::of(flow, options, scene.n_dof())
    }

    /// Runs along Taylor series.
    pub fn along_series<S: State, D: Dynamics>(
        dynamics: &'a D,
        links: &Links,
        scene: &'a Scene,
        options: &'a SimulateOptions,
    ) -> Run<'a, IntegratedFlow<'a, S, D, Taylor>> {
        let free = Taylor::new(links.clone(), scene, options.rtol);
        let flow = IntegratedFlow::new(dynamics, scene, options.tolerance(), free);
        Run::of(flow, options, scene.n_dof())
    }
}

impl<'a, M: AnyLoop> Run<'a, M> {
    fn of(flow: M, options: &'a SimulateOptions, n_dof: usize) -> Self {
        Self {
            flow,
            events: EventLoop::default(),
            options,
            n_dof,
        }
    }

    /// A run over a span.
    pub fn run(
        &mut self,
        q0: &DVector<f64>,
        v0: &DVector<f64>,
        t_span: (f64, f64),
        observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Done> {
        let Self {
            flow,
            events,
            options,
            n_dof,
        } = self;
        let mut record = Record::new(options, *n_dof);
        let flow = flow.taken();
        flow.start(q0, v0, t_span.0);
        let ending = match events.start(flow, (q0, v0, t_span.0), &mut record)? {
            Some(ending) => ending,
            None => events.go_on(flow, t_span.1, options, &mut record, observer)?,
        };
        self.finish(ending, record)
    }

    /// What a run that has ended leaves behind.
    pub fn finish(&mut self, mut ending: Ending, mut record: Record) -> Result<Done> {
        let Self { flow, events, .. } = self;
        if ending.status != Status::Finished {
            // The last event has a side after it, and the last instant its sample.
            flow.record_instant(Some(ending.time), &mut record)?;
        }
        ending.message = shortened(ending.message + &flow.remarks());
        Ok(Done {
            ending,
            last: flow.system().physical(),
            stats: events.stats.with(flow.counts()),
            record,
            held: flow.constrained_motions(),
        })
    }
}
