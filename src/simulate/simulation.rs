//! `simulate`: from a scene and a state to a trajectory.

use crate::error::{Error, Result};
use crate::hybrid::ElementStates;
use crate::linalg::singular::overflow;
use crate::model::Scene;
use crate::observer::ProgressRange;
use crate::path::Evaluator;
use crate::quantity::{finite_vector, room_for};
use crate::simulate::by_method::{RunMaker, RunVisitor, visit_runs};
use crate::simulate::gathered::Gathered;
use crate::simulate::kept::Ramped;
use crate::simulate::method::{Method, check_jacobian};
use crate::simulate::motion_state::{Left, MotionState, RunEnd};
use crate::simulate::options::SimulateOptions;
use crate::simulate::run::Done;
use crate::simulate::schedule::Schedule;
use crate::simulate::trajectory::Trajectory;
use nalgebra::DVector;
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
/// the margin `10 (atol |n|_1 + rtol * size)` (of an `atol` that is not given 1e-11 of the gap's length) below zero is closed, and the start is moved onto its stop. Exact flights have
/// errors of rounding alone: tolerances looser than the default do not widen their margin.
///
/// The observer of the thread ([`with_observer`](crate::with_observer)) is told the part of the span that is done. The eigenproblem of order
/// 2n at the first lasting contact of exact flights is one piece of work, in which it is not asked: a second or more for n = 200.
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
    finite_vector("q0", q0, scene.n_dof())?;
    finite_vector("v0", v0, scene.n_dof())?;
    let start = RunStart {
        state: (q0, v0),
        elements: &ElementStates::default(),
        flight: None,
    };
    run_from(scene, start, t_span, options)
}

/// A run from where another one has ended, of any scene and from any time on.
pub(crate) fn simulate_after(
    scene: &Scene,
    from: &RunEnd,
    t_span: (f64, f64),
    options: &SimulateOptions,
) -> Result<Trajectory> {
    let start = RunStart {
        state: (&from.state.0, &from.state.1),
        elements: &from.elements,
        flight: None,
    };
    run_from(scene, start, t_span, options)
}

/// Goes on from the state in which a run has ended, over a span of time that begins there.
///
/// Exact flights of the same scene, by the same tolerances, go on to the bit as a run that was not interrupted: impacts, contacts, states at
/// `t_eval` and at the end. The motion in between has the same digits but for the rounding of its last ones on the flight that was under
/// way, which is kept from the start of the run on. Runs in steps begin anew from position and velocity, with a step length of their own; so
/// do runs of other scenes or by other tolerances, with each element in its state.
///
/// # Errors
/// As [`simulate`]; a state that does not fit the scene, a span that does not begin at its time.
///
/// # Examples
/// ```
/// use vibroimpact::{Kind, PaperOptions, SimulateOptions, paper_scene, simulate, simulate_from};
/// use nalgebra::dvector;
/// let scene = paper_scene(Kind::Three, &PaperOptions::default())?;
/// let (q0, v0, options) = (dvector![0.0, 0.0], dvector![0.0, 0.1], SimulateOptions::default());
/// let first = simulate(&scene, &q0, &v0, (0.0, 20.0), &options)?;
/// let rest = simulate_from(&scene, &first.last_state(), (20.0, 50.0), &options)?;
/// let whole = simulate(&scene, &q0, &v0, (0.0, 50.0), &options)?;
/// assert_eq!(rest.last(), whole.last());
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn simulate_from(
    scene: &Scene,
    state: &MotionState,
    t_span: (f64, f64),
    options: &SimulateOptions,
) -> Result<Trajectory> {
    state.check(scene)?;
    if t_span.0 != state.time() {
        let value = format!("{t_span:?}");
        let rule = format!("it must begin at the time of the state, {}", state.time());
        return Err(Error::bad_value("t_span", value, rule));
    }
    let tolerances = options.solver.tolerances();
    let is_exact = options.solver.method.chosen_for(scene) == Method::Exact;
    let start = RunStart {
        state: (state.q(), state.v()),
        elements: &state.left.elements,
        flight: state.flight_of(scene, tolerances).filter(|_| is_exact),
    };
    run_from(scene, start, t_span, options)
}

/// A run from what is known at its start.
fn run_from(
    scene: &Scene,
    start: RunStart<'_>,
    t_span: (f64, f64),
    options: &SimulateOptions,
) -> Result<Trajectory> {
    options.check(t_span)?;
    scene.check_span(t_span)?;
    let n_samples = options.t_eval.as_ref().map_or(0, Vec::len);
    room_for("the motion at t_eval", 2 * n_samples, scene.n_dof())?;
    let beyond = || {
        let rule = "the motion grows beyond the largest number in it";
        Error::bad_value("t_span", format!("{t_span:?}"), rule)
    };
    let _range = ProgressRange::over(t_span.0, t_span.1);
    check_jacobian(options.solver.method, scene, t_span.0, start.state)?;
    let fly = |scene: &Scene, options: &SimulateOptions, one: OneRun<'_>| {
        visit_runs(scene, options, one).map_err(|e| if e == overflow() { beyond() } else { e })
    };
    if options.ramps.is_empty() {
        let one = OneRun {
            start,
            t_span,
            n_impacts: 0,
        };
        let mut whole = Gathered::new(scene, None);
        whole.add(t_span.0, fly(scene, options, one)?);
        return whole.finish().ok_or_else(beyond);
    }
    let ramped = Arc::new(Ramped {
        ramps: options.ramps.clone(),
        until: t_span.1,
        schedule: Schedule::new(scene, &options.ramps, t_span)?,
    });
    let mut whole = Gathered::new(scene, Some(Arc::clone(&ramped)));
    let (q0, v0) = start.state;
    let mut state = (q0.clone(), v0.clone());
    let mut elements = start.elements.clone();
    for chapter in &ramped.schedule.chapters {
        let own = options.of_chapter(scene, chapter.span, t_span.1)?;
        let one = OneRun {
            start: RunStart {
                state: (&state.0, &state.1),
                elements: &elements,
                flight: None,
            },
            t_span: chapter.span,
            n_impacts: whole.n_impacts(),
        };
        match fly(&chapter.scene, &own, one) {
            Err(error) if chapter.span.0 > t_span.0 && error.is_about("q0") => {
                whole.end_inside(chapter.span.0, &error);
                break;
            }
            flown => whole.add(chapter.span.0, flown?),
        }
        if whole.has_ended() {
            break;
        }
        state.clone_from(whole.last());
        elements.clone_from(whole.elements());
    }
    whole.finish().ok_or_else(beyond)
}

/// What is known where a run begins.
struct RunStart<'s> {
    state: (&'s DVector<f64>, &'s DVector<f64>),
    elements: &'s ElementStates,
    /// The flight that is under way.
    flight: Option<&'s [f64]>,
}

/// One run, kept as the options say.
struct OneRun<'s> {
    start: RunStart<'s>,
    t_span: (f64, f64),
    /// Impacts before it.
    n_impacts: usize,
}

impl RunVisitor for OneRun<'_> {
    type Output = (Evaluator, Done, Left);

    const BY_EXACT_FLIGHTS: &'static str = "simulate with method=\"exact\"";

    fn visit(self, make: &RunMaker<'_, '_>, evaluator: Evaluator) -> Result<Self::Output> {
        let (q0, v0) = self.start.state;
        let mut run = make();
        run.events.n_before = self.n_impacts;
        let done = if let Some(flight) = self.start.flight {
            run.go_on_from((q0, v0, self.t_span.0), flight, self.t_span.1)?
        } else {
            run.events.give(self.start.elements);
            run.run(q0, v0, self.t_span)?
        };
        let left = run.left(done.ending.status);
        Ok((evaluator.with_regimes(&done.regimes), done, left))
    }
}
