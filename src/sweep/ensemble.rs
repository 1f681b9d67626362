//! Many trajectories, of one scene or of as many: their ends, impacts and samples, on any number of threads.

use crate::error::{Error, Result};
use crate::flow::registers;
use crate::flow::steps::State;
use crate::impact::Impact;
use crate::model::{Dynamics, PhysicalState, Scene};
use crate::observer::ProgressRange;
use crate::path::{ContactRecord, Evaluator, Motion, Samples};
use crate::quantity::room_for;
use crate::simulate::method::check_jacobian;
use crate::simulate::{
    AnyRun, Batch, Done, Keep, RunMaker, RunVisitor, SeriesRun, SimulateOptions, Status,
    Trajectory, simulate, visit_runs, whole_run,
};
use crate::sweep::tiles::{SweepOptions, fill, fill_tiles};
use nalgebra::{DMatrix, DVector};

/// Trajectories that a thread takes at a time. [work]
const ENSEMBLE_TILE: usize = 8;
/// Trajectories that a thread takes at a time where they run in lanes of a batch: more, since lanes stay empty at the end of a tile. [work]
const ENSEMBLE_BATCH_TILE: usize = 32;

/// The scenes of many runs.
#[derive(Debug, Clone, Copy)]
pub enum Scenes<'a> {
    /// One for all.
    One(&'a Scene),
    /// One each, of one number of degrees of freedom.
    Each(&'a [Scene]),
}

impl<'a> From<&'a Scene> for Scenes<'a> {
    fn from(scene: &'a Scene) -> Self {
        Self::One(scene)
    }
}

impl<'a> From<&'a [Scene]> for Scenes<'a> {
    fn from(scenes: &'a [Scene]) -> Self {
        Self::Each(scenes)
    }
}

impl Scenes<'_> {
    /// How many there are; `None` of one for all.
    fn len(self) -> Option<usize> {
        match self {
            Self::One(_) => None,
            Self::Each(scenes) => Some(scenes.len()),
        }
    }

    /// The number of degrees of freedom, that of every scene; zero without scenes.
    pub(super) fn n_dof(self) -> Result<usize> {
        let scenes = match self {
            Self::One(scene) => return Ok(scene.n_dof()),
            Self::Each(scenes) => scenes,
        };
        let n = scenes.first().map_or(0, Scene::n_dof);
        match scenes.iter().position(|scene| scene.n_dof() != n) {
            None => Ok(n),
            Some(i) => {
                let value = format!("of {} degrees of freedom", scenes[i].n_dof());
                let rule = format!("all must have as many as scene[0], {n}");
                Err(Error::bad_value(format!("scene[{i}]"), value, rule))
            }
        }
    }
}

/// Many trajectories, one row each: their ends, or their motions at given times, and their impacts.
#[derive(Debug, Clone, PartialEq)]
pub struct Ensemble {
    /// Final positions, shape `(k, n)`, \[units of q\].
    pub q: DMatrix<f64>,
    /// Final velocities, shape `(k, n)`, \[units of v\].
    pub v: DMatrix<f64>,
    /// Impacts of each trajectory, shape `(k,)`.
    pub n_impacts: Vec<usize>,
    /// How each ended, shape `(k,)`.
    pub status: Vec<Status>,
    /// The impacts of each trajectory with `Keep::Impacts`, empty lists without; shape `(k,)`.
    pub impacts: Vec<Vec<Impact>>,
    /// The contacts of each trajectory with `Keep::Impacts`, shape `(k,)`; empty without.
    pub contacts: Vec<Vec<ContactRecord>>,
    /// Times, positions and velocities of each trajectory at `t_eval`, as far as it went; `None` without.
    pub samples: Option<Vec<Samples>>,
}

/// The end of one trajectory.
#[derive(Clone)]
struct TrajectoryEnd {
    q: DVector<f64>,
    v: DVector<f64>,
    n_impacts: usize,
    status: Status,
    impacts: Vec<Impact>,
    /// None of a run that does not keep them.
    contacts: Option<Box<[ContactRecord]>>,
    samples: Option<Samples>,
}

/// Simulates one scene from many states, or many scenes; the same bits as one by one. Rows of `q0` and `v0` have the shape (k,
/// n), or (1, n) for all. Pendulums with large motions that share a scene run in batches of four or eight, as wide as the registers
/// are, their Taylor series made together. A start inside a stop is left as it is, with the status [`Status::InsideStop`].
///
/// The observer of the calling thread ([`with_observer`](crate::with_observer)) is told from time to time and at the end; breaking off stops
/// every thread.
///
/// # Errors
/// As [`crate::simulate()`], naming the row; rows and scenes that are not as many; [`Keep::Motion`].
///
/// # Examples
/// ```
/// use nalgebra::dmatrix;
/// use vibroimpact::{Keep, Kind, PaperOptions, SimulateOptions, SweepOptions, paper_scene, simulate_many};
/// let scene = paper_scene(Kind::Three, &PaperOptions::default())?;
/// let (q0, v0) = (dmatrix![0.0, 0.0; 0.1, -0.1], dmatrix![0.0, 0.1; 0.0, 0.0]);
/// let options = SimulateOptions { keep: Keep::Final, ..Default::default() };
/// let ends = simulate_many(&scene, (&q0, &v0), (0.0, 50.0), &options, SweepOptions::default())?;
/// assert_eq!(ends.q.shape(), (2, 2));
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn simulate_many<'a>(
    scenes: impl Into<Scenes<'a>>,
    (q0, v0): (&DMatrix<f64>, &DMatrix<f64>),
    t_span: (f64, f64),
    options: &SimulateOptions,
    sweep: SweepOptions,
) -> Result<Ensemble> {
    simulate_rows(scenes.into(), (q0, v0), t_span, options, sweep)
}

/// The same of scenes of one type: what makes the runs is compiled once, here, not by whoever calls.
fn simulate_rows(
    scenes: Scenes<'_>,
    (q0, v0): (&DMatrix<f64>, &DMatrix<f64>),
    t_span: (f64, f64),
    options: &SimulateOptions,
    sweep: SweepOptions,
) -> Result<Ensemble> {
    let n = scenes.n_dof()?;
    let counts = [scenes.len(), Some(q0.nrows()), Some(v0.nrows())];
    let is_one = |count: &usize| *count == 1;
    let k = counts.iter().flatten().find(|count| !is_one(count));
    let k = k.copied().unwrap_or(1);
    if scenes.len().is_some_and(|count| count != k) {
        let found = format!("({},)", scenes.len().unwrap_or_default());
        return Err(Error::bad_shape(
            "scene",
            found,
            format!("one scene, or ({k},)"),
        ));
    }
    for (name, rows) in [("q0", q0), ("v0", v0)] {
        if rows.ncols() != n || (rows.nrows() != k && rows.nrows() != 1) {
            let found = format!("({}, {})", rows.nrows(), rows.ncols());
            return Err(Error::bad_shape(name, found, format!("({k}, {n})")));
        }
        if let Some(i) = (0..rows.nrows()).find(|&i| rows.row(i).iter().any(|x| !x.is_finite())) {
            return Err(Error::bad_value(
                format!("{name}[{i}]"),
                format!("{:?}", row(rows, i).as_slice()),
                "it must be finite",
            ));
        }
    }
    options.check(t_span)?;
    if options.keep == Keep::Motion {
        let rule = "an ensemble keeps impacts, or final states alone: \"impacts\" or \"final\"";
        return Err(Error::bad_value("keep", "\"motion\"", rule));
    }
    let n_samples = options.t_eval.as_ref().map_or(0, Vec::len);
    room_for("the motions at t_eval", k * n_samples, 2 * n)?;
    let nothing = TrajectoryEnd {
        q: DVector::zeros(n),
        v: DVector::zeros(n),
        n_impacts: 0,
        status: Status::Finished,
        impacts: Vec::new(),
        contacts: None,
        samples: None,
    };
    let mut ends = vec![nothing; k];
    let start = (q0, v0);
    let _range = ProgressRange::over(0.0, k as f64);
    match scenes {
        Scenes::One(scene) if options.ramps.is_empty() => {
            scene.check_span(t_span)?;
            if k > 0 {
                let (q0, v0) = (row(q0, 0), row(v0, 0));
                check_jacobian(options.solver.method, scene, t_span.0, (&q0, &v0))?;
            }
            let runs = ManyRuns {
                scene,
                ends: &mut ends,
                start,
                t_span,
                sweep,
            };
            visit_runs(scene, options, runs)?;
        }
        _ => {
            let work = |(): &mut (), i: usize| {
                let scene = match scenes {
                    Scenes::One(scene) => scene,
                    Scenes::Each(scenes) => &scenes[i],
                };
                let (q0, v0) = (row(q0, i), row(v0, i));
                let run = simulate(scene, &q0, &v0, t_span, options);
                match run {
                    Err(error) if error.is_about("q0") => Ok(TrajectoryEnd::inside((q0, v0))),
                    run => run
                        .and_then(TrajectoryEnd::of_trajectory)
                        .map_err(|e| of_row(i, e)),
                }
            };
            fill(&mut ends, ENSEMBLE_TILE, sweep, || Ok(()), work)?;
        }
    }
    Ok(Ensemble {
        q: DMatrix::from_fn(k, n, |i, j| ends[i].q[j]),
        v: DMatrix::from_fn(k, n, |i, j| ends[i].v[j]),
        n_impacts: ends.iter().map(|e| e.n_impacts).collect(),
        status: ends.iter().map(|e| e.status).collect(),
        samples: options.t_eval.as_ref().map(|_| {
            let samples = ends.iter_mut().map(|e| e.samples.take());
            let none = || (Vec::new(), DMatrix::zeros(0, n), DMatrix::zeros(0, n));
            samples.map(|own| own.unwrap_or_else(none)).collect()
        }),
        contacts: if options.keep == Keep::Impacts {
            let each = ends.iter_mut().map(|e| e.contacts.take());
            each.map(|own| own.map_or_else(Vec::new, <[_]>::into_vec))
                .collect()
        } else {
            Vec::new()
        },
        impacts: ends.into_iter().map(|e| e.impacts).collect(),
    })
}

/// Many runs, of which the ends are kept.
struct ManyRuns<'s> {
    scene: &'s Scene,
    ends: &'s mut [TrajectoryEnd],
    start: (&'s DMatrix<f64>, &'s DMatrix<f64>),
    t_span: (f64, f64),
    sweep: SweepOptions,
}

impl RunVisitor for ManyRuns<'_> {
    type Output = ();

    const BY_EXACT_FLIGHTS: &'static str = "simulate_many with method=\"exact\"";

    /// Fills the ends, each thread with a run of its own.
    fn visit(self, make: &RunMaker<'_, '_>, evaluator: Evaluator) -> Result<()> {
        let ((q0, v0), of) = (self.start, (self.scene, &evaluator, self.t_span.0));
        let work = |run: &mut Box<AnyRun<'_>>, i: usize| {
            let (q0, v0) = (row(q0, i), row(v0, i));
            match run.run(&q0, &v0, self.t_span) {
                Err(error) if error.is_about("q0") => Ok(TrajectoryEnd::inside((q0, v0))),
                done => done
                    .and_then(|done| TrajectoryEnd::of(done, of))
                    .map_err(|error| of_row(i, error)),
            }
        };
        let one = || Ok(make());
        fill(self.ends, ENSEMBLE_TILE, self.sweep, one, work)
    }

    fn visit_series<'a, S: State, D: Dynamics + 'a>(
        self,
        make: impl Fn() -> SeriesRun<'a, S, D> + Sync,
        evaluator: Evaluator,
    ) -> Result<()> {
        // A batch keeps no arcs from which samples could be taken, or what comes before contacts.
        let run = make();
        if run.options.t_eval.is_some() || (run.options.keep == Keep::Impacts && run.has_sides) {
            return self.visit(&|| Box::new(make()), evaluator);
        }
        if registers::width() < 8 {
            self.fill_batches::<4, _, _>(make, &evaluator)
        } else {
            self.fill_batches::<8, _, _>(make, &evaluator)
        }
    }
}

impl ManyRuns<'_> {
    /// Fills the ends by batches of K runs.
    fn fill_batches<'a, const K: usize, S: State, D: Dynamics + 'a>(
        self,
        make: impl Fn() -> SeriesRun<'a, S, D> + Sync,
        evaluator: &Evaluator,
    ) -> Result<()> {
        let ((q0, v0), of) = (self.start, (self.scene, evaluator, self.t_span.0));
        let work = |runs: &mut Batch<'a, S, D, K>, first: usize, slots: &mut [TrajectoryEnd]| {
            let start = |i: usize| (row(q0, first + i), row(v0, first + i));
            let n = slots.len();
            let mut put = |i: usize, done: Option<Done>| {
                slots[i] = match done {
                    Some(done) => TrajectoryEnd::of(done, of)?,
                    None => TrajectoryEnd::inside(start(i)),
                };
                Ok(())
            };
            let done = runs.run(0..n, start, &mut put);
            done.map_err(|(i, error)| (first + i, of_row(first + i, error)))
        };
        let together = || Ok(Batch::new(&make, self.t_span));
        fill_tiles(self.ends, ENSEMBLE_BATCH_TILE, self.sweep, together, work)
    }
}

/// A row, or the one that is for all.
fn row(rows: &DMatrix<f64>, i: usize) -> DVector<f64> {
    rows.row(if rows.nrows() == 1 { 0 } else { i }).transpose()
}

/// An error of a run, with the row that it began from.
fn of_row(i: usize, error: Error) -> Error {
    error.at(format_args!("row {i}"))
}

/// What a run that keeps its impacts has recorded, with its contacts.
fn recorded_with_contacts(
    done: Done,
    (scene, evaluator, start): (&Scene, &Evaluator, f64),
) -> Result<(Vec<Impact>, Vec<ContactRecord>, Option<Samples>)> {
    let evaluator = evaluator.clone().with_regimes(&done.regimes);
    let run = whole_run(scene, start, (evaluator, done));
    let contacts = run.contacts()?;
    Ok((run.impacts, contacts, run.samples))
}

impl TrajectoryEnd {
    /// That of a run of a scene from a time on, whose arcs an evaluator reads.
    fn of(done: Done, (scene, evaluator, start): (&Scene, &Evaluator, f64)) -> Result<Self> {
        let (status, n_impacts) = (done.ending.status, done.stats.n_impacts);
        let (q, v) = done.last.clone();
        let (impacts, contacts, samples) = if done.record.keep == Keep::Impacts {
            let (impacts, contacts, samples) =
                recorded_with_contacts(done, (scene, evaluator, start))?;
            (impacts, Some(contacts.into_boxed_slice()), samples)
        } else {
            let own = done.record.finish();
            (own.impacts, None, own.samples)
        };
        Ok(Self {
            q,
            v,
            n_impacts,
            status,
            impacts,
            contacts,
            samples,
        })
    }

    fn of_trajectory(run: Trajectory) -> Result<Self> {
        let keeps = run.chapters.iter().any(|own| own.contacts.is_some());
        let contacts = keeps.then(|| run.contacts()).transpose()?;
        let contacts = contacts.map(Vec::into_boxed_slice);
        let (q, v) = run.last;
        Ok(Self {
            q,
            v,
            n_impacts: run.stats.n_impacts,
            status: run.status,
            impacts: run.impacts,
            contacts,
            samples: run.samples,
        })
    }

    /// A start inside a stop, as it is.
    fn inside((q, v): PhysicalState) -> Self {
        Self {
            q,
            v,
            n_impacts: 0,
            status: Status::InsideStop,
            impacts: Vec::new(),
            contacts: None,
            samples: None,
        }
    }
}
