//! Lyapunov exponents of a motion.

use crate::error::{Error, Result, digits};
use crate::exponents::batches::Batches;
use crate::exponents::follower::{Counted, Follower};
use crate::exponents::frame::Frame;
use crate::exponents::integrated_tangents::IntegratedTangents;
use crate::exponents::modal_tangents::ModalTangents;
use crate::exponents::motion::verdict_of_motion;
use crate::exponents::tangents::Tangents;
use crate::exponents::verdict::{Attraction, ForcingKind, verdict};
use crate::flow::TimedScene;
use crate::law::Law;
use crate::model::{Constraint, ContactGeometry, Forcing, Scene, System};
use crate::observer::ProgressRange;
use crate::path::Evaluator;
use crate::quantity::{finite_vector, room_for};
use crate::simulate::{
    AnyRun, Ending, Keep, RunMaker, RunPiece, RunVisitor, SimulateOptions, Solver, Status,
    visit_runs,
};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Pieces in which a motion without a period is integrated. [work]
const LYAPUNOV_PIECES: f64 = 1000.0;

/// Options of [`lyapunov_exponents`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LyapunovOptions {
    /// Time at the start that does not count, default 0 \[s\].
    pub skip: f64,
    /// How many exponents are wanted, the largest; default all 2n.
    pub n_exponents: Option<usize>,
    /// As for [`simulate`](crate::simulate()); deviations from a motion that is integrated have the same tolerances.
    pub solver: Solver,
}

/// How fast small deviations from a motion grow, in k directions.
#[derive(Debug, Clone, PartialEq)]
pub struct LyapunovExponents {
    /// Growth per unit time, the largest first, shape `(k,)`, [1/s]; minus infinity where contact takes a direction away; NaN where the run
    /// ends before any time counts, and where deviations have no derivative that is known.
    pub exponents: Vec<f64>,
    /// Standard errors from the means of batches, shape `(k,)`, [1/s]; NaN where time is too short for two of them, zero of minus infinity.
    pub errors: Vec<f64>,
    /// The sum of all 2n; NaN where fewer are asked for.
    pub sum: f64,
    /// The sum as damping and restitution make it, of linear scenes while nothing sticks; else NaN.
    pub expected_sum: f64,
    /// Growth per unit time in each of b batches of equal length, shape `(b, k)`, [1/s]; at most 20 batches, each with at least 50 returns
    /// (periods of the forcing; without one impacts, or turns of its slowest tone, whichever are more), and one where there are fewer than
    /// 100.
    pub history: DMatrix<f64>,
    /// Impacts in the time that counts.
    pub n_impacts: usize,
    /// How often a stop came to be held in it.
    pub n_landings: usize,
    /// Touches in it, and impacts too slow to have a derivative, which deviations pass by.
    pub n_grazes: usize,
    /// Instants in it at which several stops were hit and their order matters: deviations have no derivative there.
    pub n_clashes: usize,
    /// What the motion settles on, as far as the exponents tell.
    pub verdict: Attraction,
    /// How the run ended.
    pub status: Status,
    /// Why the exponents are none, or the verdict is what it is; empty where the exponents say all.
    pub message: String,
}

/// Returns how fast small deviations from a motion grow.
///
/// # Errors
/// As [`simulate`](crate::simulate()); a `skip` that is negative or not shorter than the span; a number of exponents that is none of
/// 1 to 2n.
///
/// # References
/// Theory section 16; G. Benettin, L. Galgani, A. Giorgilli and J.-M. Strelcyn, Meccanica 15 (1980) 9; P. Mueller, Chaos, Solitons and
/// Fractals 5 (1995) 1671.
///
/// # Examples
/// ```
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{Attraction, Harmonic, LinearSystem, LyapunovOptions, Scene, Stop, lyapunov_exponents};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![5.0.into()], 2.4, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
/// let options = LyapunovOptions { skip: 500.0, ..LyapunovOptions::default() };
/// let found = lyapunov_exponents(&scene, &dvector![0.0], &dvector![0.0], (0.0, 5000.0), &options)?;
/// assert_eq!(found.verdict, Attraction::Chaotic);
/// assert!((found.sum - found.expected_sum).abs() < 1e-6);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn lyapunov_exponents(
    scene: &Scene,
    q0: &DVector<f64>,
    v0: &DVector<f64>,
    t_span: (f64, f64),
    options: &LyapunovOptions,
) -> Result<LyapunovExponents> {
    let n = scene.n_dof();
    finite_vector("q0", q0, n)?;
    finite_vector("v0", v0, n)?;
    let run = SimulateOptions::by(options.solver, Keep::Motion);
    run.check(t_span)?;
    scene.check_span(t_span)?;
    let length = t_span.1 - t_span.0;
    if !(options.skip >= 0.0 && options.skip < length) {
        let rule = format!("it must be at least 0 and shorter than the span of {length}");
        return Err(Error::bad_value("skip", options.skip, rule));
    }
    let k = options.n_exponents.unwrap_or(2 * n);
    if k == 0 || k > 2 * n {
        let rule = format!("it must be at least 1 and at most {}", 2 * n);
        return Err(Error::bad_value("n_exponents", k, rule));
    }
    room_for("deviations from the motion", 4 * n, 2 * n)?;
    let _range = ProgressRange::over(t_span.0, t_span.1);
    let exponents = Exponents {
        scene,
        start: (q0, v0),
        t_span,
        options: &run,
        frame: Frame::new(2 * n, k),
        batches: Batches::new((t_span.0 + options.skip, t_span.1)),
    };
    let (followed, ended) = visit_runs(scene, &run, exponents)?;
    let mut found = gathered(scene, &followed, &ended);
    if found.verdict == Attraction::Torus
        && let (ForcingKind::Periodic, Some(period)) = (drive(scene), scene.period())
    {
        let motion = ((q0, v0), (t_span.0, ended.time));
        (found.verdict, found.message) = verdict_of_motion(scene, period, motion, &run)?;
        if found.verdict == Attraction::Torus && has_no_torus(scene) {
            let reason = "an exponent is zero within its error, but one mass on a spring under one period has no torus";
            (found.verdict, found.message) = (Attraction::Undecided, reason.into());
        }
    }
    Ok(found)
}

/// The frame, the batches and the counts after a motion was followed.
struct GrowthRecord {
    frame: Frame,
    batches: Batches,
    counted: Counted,
    /// Why it is not to be trusted, if it is not.
    doubt: Option<String>,
}

/// A run with deviations from it.
struct Exponents<'s> {
    scene: &'s Scene,
    start: (&'s DVector<f64>, &'s DVector<f64>),
    t_span: (f64, f64),
    options: &'s SimulateOptions,
    frame: Frame,
    batches: Batches,
}

impl RunVisitor for Exponents<'_> {
    type Output = (GrowthRecord, Ending);

    const BY_EXACT_FLIGHTS: &'static str = "lyapunov_exponents with method=\"exact\"";

    fn visit(self, make: &RunMaker<'_, '_>, evaluator: Evaluator) -> Result<Self::Output> {
        if matches!(evaluator, Evaluator::Exact { .. }) {
            let timed = TimedScene::of(self.scene, Self::BY_EXACT_FLIGHTS)?;
            let tangents = ModalTangents::new(&timed);
            return self.along(make(), evaluator, tangents, None);
        }
        let purpose = "lyapunov_exponents without exact flights";
        self.scene.check_stops_are_rigid(purpose)?;
        let tangents =
            IntegratedTangents::new(self.scene, self.options.solver.tolerances(), self.start);
        let whole = (self.t_span.1 - self.t_span.0) / LYAPUNOV_PIECES;
        let every = self
            .scene
            .period()
            .map_or(whole, |period| period.min(whole));
        self.along(make(), evaluator, tangents, Some(every))
    }
}

impl Exponents<'_> {
    /// Follows a run, in pieces of some time where it has steps.
    fn along<T: Tangents>(
        self,
        mut run: Box<AnyRun<'_>>,
        evaluator: Evaluator,
        tangents: T,
        every: Option<f64>,
    ) -> Result<(GrowthRecord, Ending)> {
        let laws = self.scene.stops().iter().map(Constraint::contact);
        let mut follower = Follower::new(tangents, self.frame, self.batches, laws.collect());
        follower.tangents.begin(self.start);
        let n_dof = run.n_dof;
        let take = &mut |mut piece: RunPiece| {
            let path = piece.path(evaluator.clone(), n_dof);
            follower.tangents.take_regimes(&path.evaluator);
            follower.follow(&path, &piece.impacts, &piece.grazes)
        };
        let (q0, v0) = self.start;
        let ending = run.in_pieces((q0, v0), self.t_span, every, take)?;
        follower.finish(ending.time)?;
        let doubt = (follower.tangents).doubt_since(follower.batches.start());
        let followed = GrowthRecord {
            doubt,
            frame: follower.frame,
            batches: follower.batches,
            counted: follower.counted,
        };
        Ok((followed, ending))
    }
}

/// The kind of forcing of a scene.
fn drive(scene: &Scene) -> ForcingKind {
    let excitation = scene.excitation();
    if !excitation.signals.is_empty() {
        ForcingKind::Signals
    } else if scene.period().is_some() {
        ForcingKind::Periodic
    } else if matches!(scene.forcing(), Forcing::Unforced) {
        ForcingKind::None
    } else {
        ForcingKind::Tones
    }
}

/// Whether a scene has no torus, being one mass on a spring that nothing feeds but a forcing of one period: areas of its plane of states
/// shrink, and a closed curve that were carried onto itself would enclose one that does not.
fn has_no_torus(scene: &Scene) -> bool {
    let System::Linear(system) = scene.system() else {
        return false;
    };
    let is_damped = || system.damping().to_dense()[(0, 0)] >= 0.0;
    // A stop that relaxes has a state besides.
    let mut laws = scene.stops().iter().map(Constraint::contact);
    let is_plane = scene.n_dof() == 1 && !laws.any(Law::relaxes);
    is_plane && scene.period().is_some() && is_damped()
}

/// The exponents of a motion that was followed to its end.
fn gathered(scene: &Scene, followed: &GrowthRecord, ended: &Ending) -> LyapunovExponents {
    let GrowthRecord {
        frame,
        batches,
        counted,
        doubt,
    } = followed;
    let status = ended.status;
    let time = ended.time - batches.start();
    // Growth of no time is none, not that of another time.
    let time = if time > 0.0 { time } else { f64::NAN };
    let turns = |turn: f64| (time / turn) as usize;
    let slowest = || scene.lowest_frequency().map_or(0, |w| turns(TAU / w));
    let returns = match scene.period() {
        Some(period) => turns(period),
        None => counted.impacts.max(slowest()),
    };
    let means = batches.means(returns);
    let each = frame.growth();
    let known = if doubt.is_some() { f64::NAN } else { 1.0 };
    let each: Vec<f64> = (each.into_iter())
        .map(|growth| known * growth / time)
        .collect();
    let mut order: Vec<usize> = (0..each.len()).collect();
    order.sort_by(|&a, &b| each[b].total_cmp(&each[a]));
    let sorted = |of: &[f64]| -> Vec<f64> { order.iter().map(|&i| of[i]).collect() };
    let exponents = sorted(&each);
    let errors = if means.errors.is_empty() || doubt.is_some() {
        vec![f64::NAN; each.len()]
    } else {
        sorted(&means.errors)
    };
    let is_whole = exponents.len() == 2 * scene.n_dof();
    let sum = if is_whole {
        exponents.iter().sum()
    } else {
        f64::NAN
    };
    let found = if status == Status::Finished && counted.clashes == 0 && doubt.is_none() {
        verdict(&exponents, &errors, drive(scene), 1.0 / time)
    } else {
        Attraction::Undecided
    };
    let message = if let Some(doubt) = doubt {
        doubt.clone()
    } else if time.is_nan() {
        format!(
            "the run ends at {}, before the time from {} on that counts: {}",
            digits(ended.time),
            digits(batches.start()),
            ended.message
        )
    } else if status != Status::Finished {
        format!("the run ends early: {}", ended.message)
    } else if counted.clashes > 0 {
        "several stops are hit at one instant, and their order matters: deviations have no derivative there".into()
    } else {
        String::new()
    };
    LyapunovExponents {
        sum,
        expected_sum: expected_sum(scene, counted, time),
        history: DMatrix::from_fn(means.history.len(), each.len(), |b, i| {
            known * means.history[b][order[i]]
        }),
        exponents,
        errors,
        n_impacts: counted.impacts,
        n_landings: counted.landings,
        n_grazes: counted.grazes,
        n_clashes: counted.clashes,
        verdict: found,
        status,
        message,
    }
}

/// `-tr(M^-1 C) + sum ln e^2 / time - sum c n.b t_pressed / time` of a linear scene on which nothing came to be held or relaxed.
fn expected_sum(scene: &Scene, counted: &Counted, time: f64) -> f64 {
    let Ok(system) = scene.linear_system("the sum of exponents") else {
        return f64::NAN;
    };
    if counted.landings > 0 || counted.relaxing > 0.0 {
        return f64::NAN;
    }
    let damping = system.damping().to_dense();
    let trace: f64 = (0..system.n_dof())
        .map(|j| system.solve_mass(&damping.column(j).into_owned())[j])
        .sum();
    let contacts = ContactGeometry::new(system, scene);
    let pressed = counted.pressed.iter().enumerate();
    let taken = pressed
        .filter(|own| *own.1 > 0.0)
        .map(|(i, time)| contacts.laws[i].pressed_force().damping * contacts.give(i, i) * time);
    (counted.log_restitution - taken.sum::<f64>()) / time - trace
}
