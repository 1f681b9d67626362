//! Labels of grid points of a basin: the attractor that the motion from each point leads to. A label is a function of the point and of the
//! attractors alone, whatever other points are labelled with it.
//!
//! A point is a state (q, v) in units of the scene, with a phase of the forcing \[rad\]; iterations are periods of the forcing.

use crate::attractor::{Attractor, StateBox};
use crate::basin::batch::Tile;
use crate::basin::label::Label;
use crate::basin::targets::{ProximityCounter, Targets};
use crate::error::{Error, Failure, Result};
use crate::flow::registers;
use crate::flow::steps::State;
use crate::model::{Dynamics, PhysicalState, Scene};
use crate::observer::ProgressRange;
use crate::path::Evaluator;
use crate::quantity::finite;
use crate::section::wait;
use crate::simulate::{
    AnyRun, Batch, Keep, RunMaker, RunMonitor, RunVisitor, SeriesRun, SimulateOptions, Solver,
    visit_runs,
};
use crate::sweep::SweepOptions;
use crate::sweep::tiles::{fill, fill_tiles};
use nalgebra::DMatrix;
use std::any::Any;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Periods of the forcing up to which contacts are sought in one go. [work]
const PERIODS_AT_ONCE: f64 = 24.0;
/// Grid points that a thread takes at a time. [work]
const BASIN_TILE: usize = 32;
/// Grid points that a thread takes at a time where they run in lanes of a batch: more, since lanes stay empty at the end of a tile. [work]
const BASIN_BATCH_TILE: usize = 128;

/// Options of [`basin_cells`].
#[derive(Debug, Clone, PartialEq)]
pub struct BasinOptions {
    /// The phase of the forcing at which the attractors have their points, default 0 \[rad\].
    pub phase: f64,
    /// Periods after which a state is left undecided, default 2000.
    pub max_periods: usize,
    /// Periods for which a motion must follow an attractor; `None`: three of an orbit's own, 20 of a set.
    pub hits: Option<usize>,
    /// As for [`simulate`](crate::simulate()).
    pub solver: Solver,
    /// Threads.
    pub sweep: SweepOptions,
}

impl Default for BasinOptions {
    fn default() -> Self {
        Self {
            phase: 0.0,
            max_periods: 2000,
            hits: None,
            solver: Solver::default(),
            sweep: SweepOptions::default(),
        }
    }
}

/// Labels of states.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BasinCells {
    /// Where each state leads to, shape `(k,)`.
    pub labels: Vec<Label>,
    /// Periods of the forcing after which each was decided, shape `(k,)`.
    pub iterations: Vec<usize>,
}

/// Where the motions of a scene lead to, from states, one a row, shape `(k, 2n)`, each at a phase of the forcing of its own \[rad\], shape
/// `(k,)`: to which of some attractors, whose points are at the phase of the options. A motion is on one if it follows it, within a part of
/// the box and of the distance to the others, for some periods.
///
/// The observer of the calling thread ([`with_observer`](crate::with_observer)) is told from time to time and at the end; breaking off stops
/// every thread.
///
/// # Errors
/// A scene without a forcing period; states, phases or attractors that do not fit or are not finite; as [`simulate`](crate::simulate()).
///
/// # References
/// Theory section 18.
pub fn basin_cells(
    scene: &Scene,
    attractors: &[Attractor],
    around: &StateBox,
    (states, phases): (&DMatrix<f64>, &[f64]),
    options: &BasinOptions,
) -> Result<BasinCells> {
    let width = 2 * scene.n_dof();
    let shape = |argument: &str, found: (usize, usize), wanted: String| {
        Err(Error::bad_shape(argument, format!("{found:?}"), wanted))
    };
    if states.ncols() != width {
        return shape("states", states.shape(), format!("(k, {width})"));
    }
    if phases.len() != states.nrows() {
        return shape(
            "phases",
            (phases.len(), 1),
            format!("({}, 1)", states.nrows()),
        );
    }
    for (i, &phase) in phases.iter().enumerate() {
        finite(&format!("phases[{i}]"), phase)?;
        if states.row(i).iter().any(|x| !x.is_finite()) {
            let rule = "every state must be finite";
            return Err(Error::bad_value(format!("states[{i}]"), f64::NAN, rule));
        }
    }
    around.check(scene.n_dof())?;
    for (k, one) in attractors.iter().enumerate() {
        if one.points.ncols() != width {
            return shape(
                &format!("attractors[{k}].points"),
                one.points.shape(),
                format!("(p, {width})"),
            );
        }
    }
    let Some(period) = scene.period() else {
        let rule = "motions are looked at once in each period of the forcing: it must have one";
        return Err(Error::bad_value("scene", "without a forcing period", rule));
    };
    let run = SimulateOptions::by(options.solver, Keep::Final);
    options.solver.check()?;
    let phase = finite("phase", options.phase)?;
    let targets = Targets::new(scene, attractors, around, phase, options.hits, &run)?;
    let mut found = vec![(Label::Undecided, 0); states.nrows()];
    let cells = Cells {
        scene,
        targets: Arc::new(targets),
        starts: (states, phases),
        period,
        options,
        found: &mut found,
    };
    let _range = ProgressRange::over(0.0, states.nrows() as f64);
    visit_runs(scene, &run, cells)?;
    let (labels, iterations) = found.into_iter().unzip();
    Ok(BasinCells { labels, iterations })
}

/// All grid points, labelled by runs of the scene.
struct Cells<'s> {
    scene: &'s Scene,
    targets: Arc<Targets>,
    starts: (&'s DMatrix<f64>, &'s [f64]),
    period: f64,
    options: &'s BasinOptions,
    found: &'s mut [(Label, usize)],
}

impl RunVisitor for Cells<'_> {
    type Output = ();

    const BY_EXACT_FLIGHTS: &'static str = "basins with method=\"exact\"";

    fn visit(self, make: &RunMaker<'_, '_>, _: Evaluator) -> Result<()> {
        let Self {
            scene,
            targets,
            starts: (states, phases),
            period,
            options,
            found,
        } = self;
        let n = scene.n_dof();
        let own_phase = scene.phase();
        let work = |run: &mut Box<AnyRun<'_>>, i: usize| {
            let row = states.row(i);
            let part = |first: usize| row.columns(first, n).transpose();
            let start: f64 = wait(period, own_phase, phases[i]);
            let first = start + wait(period, phases[i], targets.phase);
            let labeller = MotionLabeller {
                proximity: ProximityCounter::new(&targets),
                targets: Arc::clone(&targets),
                first,
                period,
                count: 0,
                most: options.max_periods,
                label: Label::Undecided,
            };
            let end = match options.max_periods {
                0 => start,
                most => first + period * most as f64,
            };
            let done = run.monitored(
                (&part(0), &part(n)),
                (start, end),
                (Box::new(labeller), PERIODS_AT_ONCE * period),
            );
            match done {
                Err(error) if error.is_about("q0") => Ok((Label::Inside, 0)),
                // It has grown beyond the doubles.
                Err(error) if error.is_about("t_span") => Ok((Label::Lost, 0)),
                Err(error) => Err(error.at(format_args!("states[{i}]"))),
                Ok(done) => {
                    let labeller = done.record.monitor.monitor.map(RunMonitor::into_any);
                    let labeller = labeller.and_then(|own| own.downcast::<MotionLabeller>().ok());
                    Ok(labeller.map_or((Label::Undecided, 0), |own| (own.label, own.count)))
                }
            }
        };
        fill(found, BASIN_TILE, options.sweep, || Ok(make()), work)
    }

    fn visit_series<'a, S: State, D: Dynamics + 'a>(
        self,
        make: impl Fn() -> SeriesRun<'a, S, D> + Sync,
        evaluator: Evaluator,
    ) -> Result<()> {
        let phases = self.starts.1;
        match phases.first() {
            Some(&phase) if self.options.max_periods > 0 && phases.iter().all(|x| *x == phase) => {
                if registers::width() < 8 {
                    self.fill_batches::<4, _, _>(make, phase)
                } else {
                    self.fill_batches::<8, _, _>(make, phase)
                }
            }
            _ => self.visit(&|| Box::new(make()), evaluator),
        }
    }
}

impl Cells<'_> {
    /// Labels points by batches of K lanes: from their common phase of the forcing to that of the attractors' points, and from there period
    /// by period.
    fn fill_batches<'a, const K: usize, S: State, D: Dynamics + 'a>(
        self,
        make: impl Fn() -> SeriesRun<'a, S, D> + Sync,
        phase: f64,
    ) -> Result<()> {
        let Self {
            scene,
            targets,
            starts: (states, _),
            period,
            options,
            found,
        } = self;
        let n = scene.n_dof();
        let start = wait(period, scene.phase(), phase);
        let first = start + wait(period, phase, targets.phase);
        let spans = [(start, first), (first, first + period)];
        let together = || Ok(spans.map(|span| Batch::<S, D, K>::new(&make, span)));
        let work =
            |batches: &mut [Batch<'a, S, D, K>; 2], from: usize, slots: &mut [(Label, usize)]| {
                let part = |i: usize, first: usize| states.row(i).columns(first, n).transpose();
                let own = (from..from + slots.len()).map(|i| (part(i, 0), part(i, n)));
                let tile = Tile::new(slots, own, &targets, options.max_periods);
                let failed = |(i, error): Failure| {
                    let at = from + i;
                    (at, error.at(format_args!("states[{at}]")))
                };
                tile.label(batches).map_err(failed)
            };
        fill_tiles(found, BASIN_BATCH_TILE, options.sweep, together, work)
    }
}

/// Follows one motion, period by period, until it has a label.
struct MotionLabeller {
    targets: Arc<Targets>,
    proximity: ProximityCounter,
    first: f64,
    period: f64,
    count: usize,
    most: usize,
    label: Label,
}

impl RunMonitor for MotionLabeller {
    fn next(&self) -> f64 {
        self.first + self.period * self.count as f64
    }

    fn every(&self) -> f64 {
        self.period
    }

    fn inspect(&mut self, state: &PhysicalState) -> ControlFlow<()> {
        self.count += 1;
        if let Some(label) = self.proximity.update(&self.targets, state) {
            self.label = label;
            return ControlFlow::Break(());
        }
        if self.count < self.most {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    }

    fn into_any(self: Box<Self>) -> Box<dyn Any> {
        self
    }
}
