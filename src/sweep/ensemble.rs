//! Many trajectories of one scene: the final states, in constant memory for each, on any number of threads.

use crate::error::{Error, Result};
use crate::flow::registers;
use crate::flow::steps::State;
use crate::hybrid::AnyLoop;
use crate::model::{Dynamics, Scene};
use crate::observer::ObserverFn;
use crate::path::Evaluator;
use crate::simulate::method::check_jacobian;
use crate::simulate::{
    Batch, Done, Keep, Run, RunVisitor, SeriesRun, SimulateOptions, Status, visit_runs,
};
use crate::sweep::tiles::{Progress, SweepOptions, fill, fill_tiles};
use nalgebra::{DMatrix, DVector};
use std::ops::ControlFlow;

/// Trajectories that a thread takes at a time.
const TILE: usize = 8;
/// The same where several run abreast: the last of a tile run with empty places beside them.
const TILE_ABREAST: usize = 32;

/// The ends of many trajectories, one row each.
#[derive(Debug, Clone, PartialEq)]
pub struct Ensemble {
    /// Final positions, shape `(k, n)`.
    pub q: DMatrix<f64>,
    /// Final velocities, shape `(k, n)`.
    pub v: DMatrix<f64>,
    /// Impacts of each trajectory, shape `(k,)`.
    pub n_impacts: Vec<usize>,
    /// How each ended, shape `(k,)`.
    pub status: Vec<Status>,
}

/// The end of one trajectory.
#[derive(Clone)]
struct TrajectoryEnd {
    q: DVector<f64>,
    v: DVector<f64>,
    n_impacts: usize,
    status: Status,
}

/// Simulates a scene from many states, rows of `q0` and `v0`, shape `(k, n)` each; the same bits as one by one. Pendulums with
/// large motions run four or eight abreast, as wide as the registers are, their Taylor series made together.
///
/// `observer` is called on the calling thread about every 50 ms and at the end; breaking off stops every thread.
///
/// # Errors
/// As [`crate::simulate()`], naming the row; `keep` other than [`Keep::Final`], or `t_eval`.
///
/// # Examples
/// ```
/// use nalgebra::dmatrix;
/// use std::ops::ControlFlow;
/// use vibroimpact::{Keep, Kind, PaperOptions, SimulateOptions, SweepOptions, paper_scene, simulate_many};
/// let scene = paper_scene(Kind::Three, &PaperOptions::default())?;
/// let (q0, v0) = (dmatrix![0.0, 0.0; 0.1, -0.1], dmatrix![0.0, 0.1; 0.0, 0.0]);
/// let options = SimulateOptions { keep: Keep::Final, ..Default::default() };
/// let go_on = &mut |_| ControlFlow::Continue(());
/// let ends = simulate_many(&scene, (&q0, &v0), (0.0, 50.0), &options, SweepOptions::default(), go_on)?;
/// assert_eq!(ends.q.shape(), (2, 2));
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn simulate_many(
    scene: &Scene,
    (q0, v0): (&DMatrix<f64>, &DMatrix<f64>),
    t_span: (f64, f64),
    options: &SimulateOptions,
    sweep: SweepOptions,
    observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Ensemble> {
    let (k, n) = (q0.nrows(), scene.n_dof());
    for (name, rows) in [("q0", q0), ("v0", v0)] {
        if rows.shape() != (k, n) {
            let found = format!("({}, {})", rows.nrows(), rows.ncols());
            return Err(Error::bad_shape(name, found, format!("({k}, {n})")));
        }
        if let Some(i) = (0..k).find(|&i| rows.row(i).iter().any(|x| !x.is_finite())) {
            return Err(Error::bad_value(
                format!("{name}[{i}]"),
                rows.row(i),
                "it must be finite",
            ));
        }
    }
    options.check(t_span)?;
    scene.check_span(t_span)?;
    if options.keep != Keep::Final || options.t_eval.is_some() {
        return Err(Error::bad_value(
            "keep",
            format!("{:?}", options.keep),
            "an ensemble keeps final states alone",
        ));
    }
    let mut ends = vec![
        TrajectoryEnd {
            q: DVector::zeros(n),
            v: DVector::zeros(n),
            n_impacts: 0,
            status: Status::Finished
        };
        k
    ];
    if k > 0 {
        let of = |rows: &DMatrix<f64>| rows.row(0).transpose();
        check_jacobian(options.method, scene, t_span.0, (&of(q0), &of(v0)))?;
    }
    let runs = ManyRuns {
        ends: &mut ends,
        start: (q0, v0),
        t_span,
        sweep,
        observer,
    };
    visit_runs(scene, options, runs)?;
    Ok(Ensemble {
        q: DMatrix::from_fn(k, n, |i, j| ends[i].q[j]),
        v: DMatrix::from_fn(k, n, |i, j| ends[i].v[j]),
        n_impacts: ends.iter().map(|e| e.n_impacts).collect(),
        status: ends.iter().map(|e| e.status).collect(),
    })
}

/// Many runs, of which the ends are kept.
struct ManyRuns<'s> {
    ends: &'s mut [TrajectoryEnd],
    start: (&'s DMatrix<f64>, &'s DMatrix<f64>),
    t_span: (f64, f64),
    sweep: SweepOptions,
    observer: &'s mut dyn FnMut(Progress) -> ControlFlow<()>,
}

impl RunVisitor for ManyRuns<'_> {
    type Output = ();

    const BY_EXACT_FLIGHTS: &'static str = "simulate_many with method=\"exact\"";

    /// Fills the ends, each thread with a run of its own.
    fn visit<'a, M: AnyLoop>(
        self,
        make: impl Fn() -> Run<'a, M> + Sync,
        _: Evaluator,
    ) -> Result<()> {
        let (q0, v0) = self.start;
        let work = |run: &mut Run<'a, M>, i: usize, go_on: ObserverFn<'_>| {
            let (q0, v0) = (row(q0, i), row(v0, i));
            let done = run.run(&q0, &v0, self.t_span, &mut |_| go_on());
            done.map(TrajectoryEnd::of)
                .map_err(|error| of_row(i, error))
        };
        let one = || Ok(make());
        fill(self.ends, TILE, self.sweep, one, work, self.observer)
    }

    fn visit_series<'a, S: State, D: Dynamics + 'a>(
        self,
        make: impl Fn() -> SeriesRun<'a, S, D> + Sync,
        _: Evaluator,
    ) -> Result<()> {
        if registers::width() < 8 {
            self.fill_abreast::<4, _, _>(make)
        } else {
            self.fill_abreast::<8, _, _>(make)
        }
    }
}

impl ManyRuns<'_> {
    /// Fills the ends by K runs abreast.
    fn fill_abreast<'a, const K: usize, S: State, D: Dynamics + 'a>(
        self,
        make: impl Fn() -> SeriesRun<'a, S, D> + Sync,
    ) -> Result<()> {
        let (q0, v0) = self.start;
        let work = |runs: &mut Batch<'a, S, D, K>,
                    first: usize,
                    slots: &mut [TrajectoryEnd],
                    go_on: ObserverFn<'_>| {
            let start = |i: usize| (row(q0, first + i), row(v0, first + i));
            let n = slots.len();
            let mut put = |i: usize, done: Done| slots[i] = TrajectoryEnd::of(done);
            let done = runs.run(0..n, start, go_on, &mut put);
            done.map_err(|(i, error)| (first + i, of_row(first + i, error)))
        };
        let together = || Ok(Batch::new(&make, self.t_span));
        fill_tiles(
            self.ends,
            TILE_ABREAST,
            self.sweep,
            together,
            work,
            self.observer,
        )
    }
}

fn row(rows: &DMatrix<f64>, i: usize) -> DVector<f64> {
    rows.row(i).transpose()
}

/// An error of a run, with the row that it began from.
fn of_row(i: usize, error: Error) -> Error {
    match error {
        Error::BadValue {
            argument,
            value,
            rule,
        } => Error::bad_value(format!("row {i}: {argument}"), value, rule),
        other => other,
    }
}

impl TrajectoryEnd {
    fn of(done: Done) -> Self {
        let (q, v) = done.last;
        Self {
            q,
            v,
            n_impacts: done.stats.n_impacts,
            status: done.ending.status,
        }
    }
}
