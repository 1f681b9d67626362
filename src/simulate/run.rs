//! `simulate`: from a scene and a state to a trajectory.

use crate::error::Result;
use crate::flow::{LinearFlow, ModalScene, with_flow};
use crate::modal::Pair;
use crate::model::Scene;
use crate::quantity::finite_vector;
use crate::simulate::event_loop::{Ending, EventLoop};
use crate::simulate::exact::ExactMover;
use crate::simulate::mover::Mover;
use crate::simulate::record::Record;
use crate::simulate::trajectory::Kept;
use crate::simulate::{SimulateOptions, Stats, Trajectory};
use nalgebra::DVector;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Simulates a scene from `(q0, v0)` over a span of time.
///
/// A linear scene flies in closed form from impact to impact; each next impact is provably the first one, but for touches
/// inside the margin `10 (atol |n|_1 + rtol * size)`, which are listed as grazes.
///
/// # Errors
/// Arrays of the wrong length or not finite, a span that runs backwards, a start inside a stop, a nonlinear scene.
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
    simulate_checked(scene, q0, v0, t_span, options, &mut |_| {
        ControlFlow::Continue(())
    })
}

/// [`simulate()`], asking `observer` from time to time, with the time reached, whether to go on.
///
/// # Errors
/// As [`simulate()`]; `Error::Interrupted` when the observer breaks off.
pub fn simulate_checked(
    scene: &Scene,
    q0: &DVector<f64>,
    v0: &DVector<f64>,
    t_span: (f64, f64),
    options: &SimulateOptions,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Trajectory> {
    let modal = Arc::new(ModalScene::new(scene, "simulate")?);
    finite_vector("q0", q0, scene.n_dof())?;
    finite_vector("v0", v0, scene.n_dof())?;
    options.check(t_span)?;
    let flow = Arc::new(modal.flow());
    let phase = scene.forcing().phase();
    let done = with_flow!(&*flow, f => {
        Run::new(f, &modal, phase, options).run(&modal.form.to_modal(q0, v0), t_span, observer)
    })?;
    let Ending {
        time,
        status,
        message,
    } = done.ending;
    let (impacts, grazes, samples) = done.record.finish();
    Ok(Trajectory {
        scene: scene.clone(),
        last: done.last,
        modal,
        flow,
        phase,
        span: (t_span.0, time),
        kept: done.kept,
        impacts,
        grazes,
        samples,
        status,
        message,
        stats: done.stats,
    })
}

/// What a run leaves behind.
pub(crate) struct Done {
    pub ending: Ending,
    pub last: (DVector<f64>, DVector<f64>),
    pub stats: Stats,
    record: Record,
    kept: Option<Kept>,
}

/// One run after another of the same linear scene, with their buffers.
pub(crate) struct Run<'a, F: LinearFlow> {
    mover: ExactMover<'a, F>,
    events: EventLoop,
    options: &'a SimulateOptions,
    n_dof: usize,
}

impl<'a, F: LinearFlow> Run<'a, F> {
    pub fn new(
        flow: &'a F,
        scene: &'a ModalScene,
        phase: f64,
        options: &'a SimulateOptions,
    ) -> Self {
        Self {
            mover: ExactMover::new(flow, scene, phase, options),
            events: EventLoop::default(),
            options,
            n_dof: scene.form.n_dof(),
        }
    }

    /// A run from a state in modal pairs.
    pub fn run(
        &mut self,
        state: &[Pair],
        t_span: (f64, f64),
        observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<Done> {
        let mut record = Record::new(self.options, self.n_dof);
        self.mover.start(state, t_span.0);
        let ending =
            self.events
                .run(&mut self.mover, t_span, self.options, &mut record, observer)?;
        let mut stats = self.events.stats;
        stats.n_gap_evaluations = self.mover.n_gap_evaluations();
        Ok(Done {
            ending,
            last: self.mover.physical(),
            stats,
            record,
            kept: self.mover.take_kept(),
        })
    }
}
