//! Bifurcation diagrams: what a motion settles on, over the values of a number of its scene (theory 15).

use crate::error::{Error, Result};
use crate::hybrid::joined;
use crate::model::Scene;
use crate::observer::ProgressRange;
use crate::orbit::{Pattern, depends_on_own_time};
use crate::quantity::{at_least_one, finite, finite_vector};
use crate::section::{PoincarePoints, Section, Settled, points_of, settled, settled_by_impacts};
use crate::simulate::{Keep, RunEnd, SimulateOptions, Solver, Status, put_onto, simulate_after};
use crate::sweep::counted::until;
use crate::sweep::ensemble::Scenes;
use crate::sweep::existence::Axis;
use crate::sweep::tiles::{SweepOptions, fill};
use crate::tolerance::DIAGRAM_LONGEST_PERIOD;
use nalgebra::DVector;

/// In which order the values are gone through.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Direction {
    /// From the smallest up.
    #[default]
    Up,
    /// From the largest down.
    Down,
    /// Up, then down.
    Both,
}

/// Options of [`bifurcation_diagram`].
#[derive(Debug, Clone, PartialEq)]
pub struct DiagramOptions {
    /// In which order the values are gone through.
    pub direction: Direction,
    /// Position and velocity at the first value, and without `carry` at each, shape `(n,)` each, \[units of q and v\]; `None`: at rest at
    /// zero. A position beyond a stop is moved onto it.
    pub start: Option<(DVector<f64>, DVector<f64>)>,
    /// Periods of the forcing that are left out at each value, default 200; of a scene without one impacts are counted.
    pub transient: usize,
    /// Periods that are looked at, default 50, at least 1.
    pub periods: usize,
    /// When the motion is looked at, default at phase 0.
    pub section: Section,
    /// Whether the motion goes on from value to value, default true.
    pub carry: bool,
    /// As for [`simulate`](crate::simulate()).
    pub solver: Solver,
    /// Threads: for both directions side by side, without `carry` for all values.
    pub sweep: SweepOptions,
}

impl Default for DiagramOptions {
    fn default() -> Self {
        Self {
            direction: Direction::Up,
            start: None,
            transient: 200,
            periods: 50,
            section: Section::Phase(0.0),
            carry: true,
            solver: Solver::default(),
            sweep: SweepOptions::default(),
        }
    }
}

/// What a motion of n coordinates settles on at m values of a number of its scene: p points.
#[derive(Debug, Clone, PartialEq)]
pub struct BifurcationDiagram {
    /// The values in the order in which they were gone through, shape `(m,)`, \[unit of the parameter\]: up, then down.
    pub parameter: Vec<f64>,
    /// Whether each was gone through upwards, shape `(m,)`.
    pub is_up: Vec<bool>,
    /// After how many periods of the forcing, or points where it has none, the motion repeats itself, up to 32 and half of those that are
    /// sampled; zero where it does not. Shape `(m,)`.
    pub n_periods: Vec<usize>,
    /// Impacts in the periods that are looked at; those that accumulate until a stop is at rest count as one. Shape `(m,)`.
    pub n_impacts: Vec<usize>,
    /// The stops hit in one period of the motion, from the smallest on; empty where it has none. Shape `(m,)`.
    pub pattern: Vec<Pattern>,
    /// How the run ended, shape `(m,)`.
    pub status: Vec<Status>,
    /// The place of the value that each point belongs to, shape `(p,)`.
    pub index: Vec<usize>,
    /// The points.
    pub points: PoincarePoints,
}

/// What one value gives, and where the motion has come to at its end.
#[derive(Clone)]
struct AtValue {
    settled: Settled,
    points: PoincarePoints,
    status: Status,
    last: RunEnd,
}

/// Follows a motion over the values of a number of its scene, its transients left out. At each value `transient` periods of the
/// forcing are left out and `periods` looked at, at a phase or after impacts.
///
/// The observer of the calling thread ([`with_observer`](crate::with_observer)) is told from time to time and at the end; breaking off stops
/// every thread.
///
/// # Errors
/// Values that are none, or that the number may not take; no periods to look at; a phase of a scene without a forcing period; as
/// [`simulate`](crate::simulate()).
///
/// # References
/// Theory section 15; S. W. Shaw and P. J. Holmes, J. Sound Vib. 90 (1983) 129.
///
/// # Examples
/// ```
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{Axis, DiagramOptions, Harmonic, LinearSystem, Parameter, Scene, Stop, bifurcation_diagram};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![5.0.into()], 2.4, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
/// let axis = Axis::new(Parameter::ForcingScale, [1.0, 1.3, 2.0]);
/// let diagram = bifurcation_diagram(&scene, &axis, &DiagramOptions::default())?;
/// // Chaos, and beyond the doubling at 7.73/5 one impact in each period.
/// assert_eq!(diagram.n_periods[2], 1);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn bifurcation_diagram(
    scene: &Scene,
    axis: &Axis,
    options: &DiagramOptions,
) -> Result<BifurcationDiagram> {
    let made = |(i, &value): (usize, &f64)| {
        let checked = axis.parameter.check(value);
        let made = checked.and_then(|()| scene.replace(axis.parameter.change(value)));
        made.map_err(|error| error.at(format_args!("axis[{i}]")))
    };
    let scenes: Vec<Scene> = (axis.values.iter().enumerate())
        .map(made)
        .collect::<Result<_>>()?;
    bifurcation_diagram_of(&axis.values, &scenes, options)
}

/// The same of scenes, one for each value.
///
/// # Errors
/// As [`bifurcation_diagram`]; scenes that are not as many as values.
pub fn bifurcation_diagram_of(
    values: &[f64],
    scenes: &[Scene],
    options: &DiagramOptions,
) -> Result<BifurcationDiagram> {
    check(values, scenes, options)?;
    let mut up: Vec<usize> = (0..values.len()).collect();
    up.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let down: Vec<usize> = up.iter().rev().copied().collect();
    let ways: Vec<(bool, Vec<usize>)> = match options.direction {
        Direction::Up => vec![(true, up)],
        Direction::Down => vec![(false, down)],
        Direction::Both => vec![(true, up), (false, down)],
    };
    // Runs that go on from value to value are one piece of work.
    let pieces: Vec<&[usize]> = if options.carry {
        ways.iter().map(|(_, way)| way.as_slice()).collect()
    } else {
        ways.iter().flat_map(|(_, way)| way.chunks(1)).collect()
    };
    let mut parts: Vec<Vec<AtValue>> = vec![Vec::new(); pieces.len()];
    let _range = ProgressRange::over(0.0, pieces.len() as f64);
    let work =
        |(): &mut (), piece: usize| along(pieces[piece].iter().map(|&k| &scenes[k]), options);
    fill(&mut parts, 1, options.sweep, || Ok(()), work)?;
    let all: Vec<AtValue> = parts.into_iter().flatten().collect();
    let each = ways
        .iter()
        .flat_map(|(is_up, way)| way.iter().map(move |&k| (*is_up, values[k])));
    let (is_up, parameter) = each.unzip();
    Ok(gathered(all, is_up, parameter, scenes[0].n_dof()))
}

/// Equations that depend on time by themselves repeat with the forcing at every value, as points at a phase of it mean.
fn check_own_times(scenes: &[Scene], options: &DiagramOptions) -> Result<()> {
    if !matches!(options.section, Section::Phase(_)) {
        return Ok(());
    }
    for (i, scene) in scenes.iter().enumerate() {
        let rest = || (DVector::zeros(scene.n_dof()), DVector::zeros(scene.n_dof()));
        let start = joined(&options.start.clone().unwrap_or_else(rest));
        // Where the start is an equilibrium at all times, what is beside it may not be.
        let beside = start.add_scalar(1.0);
        match depends_on_own_time(scene, &[start, beside]) {
            Err(error) if error.is_about("scene") => {
                return Err(error.at(format_args!("at the value {i} of the axis")));
            }
            _ => {}
        }
    }
    Ok(())
}

fn check(values: &[f64], scenes: &[Scene], options: &DiagramOptions) -> Result<()> {
    if values.is_empty() {
        return Err(Error::bad_value(
            "axis",
            "without values",
            "at least one is needed",
        ));
    }
    if scenes.len() != values.len() {
        let (found, wanted) = (
            format!("({},)", scenes.len()),
            format!("({},)", values.len()),
        );
        return Err(Error::bad_shape("scenes", found, wanted));
    }
    for (i, &value) in values.iter().enumerate() {
        finite(&format!("axis[{i}]"), value)?;
    }
    options.solver.check()?;
    at_least_one("periods", options.periods)?;
    let n = Scenes::Each(scenes).n_dof()?;
    for scene in scenes {
        if scene.period().is_none() && !matches!(options.section, Section::Impacts(_)) {
            let rule = "without a period of the forcing a diagram is that of impacts: section must be \"impact\"";
            return Err(Error::bad_value("scene", "without a forcing period", rule));
        }
        options.section.check(scene)?;
    }
    if let Some((q0, v0)) = &options.start {
        finite_vector("q0", q0, n)?;
        finite_vector("v0", v0, n)?;
    }
    check_own_times(scenes, options)
}

/// One value after the other, each from where the one before has ended.
fn along<'s>(
    scenes: impl Iterator<Item = &'s Scene>,
    options: &DiagramOptions,
) -> Result<Vec<AtValue>> {
    let start = options.start.clone();
    let mut from = start.map(|state| RunEnd {
        state,
        ..RunEnd::default()
    });
    let mut all = Vec::new();
    for scene in scenes {
        let rest = || RunEnd {
            state: (DVector::zeros(scene.n_dof()), DVector::zeros(scene.n_dof())),
            ..RunEnd::default()
        };
        let found = at_value(scene, from.unwrap_or_else(rest), options)?;
        from = Some(found.last.clone());
        all.push(found);
    }
    Ok(all)
}

fn run_options(options: &DiagramOptions) -> SimulateOptions {
    SimulateOptions::by(options.solver, Keep::Final)
}

/// What a motion settles on from where another one has ended.
fn at_value(scene: &Scene, from: RunEnd, options: &DiagramOptions) -> Result<AtValue> {
    let run = run_options(options);
    let from = RunEnd {
        state: put_onto(scene, from.state, 0.0, &run)?,
        ..from
    };
    let Some(period) = scene.period() else {
        return by_impacts(scene, &from, options);
    };
    let span = (0.0, options.transient as f64 * period);
    let transient = simulate_after(scene, &from, span, &run)?;
    let seen = SimulateOptions {
        keep: Keep::Motion,
        ..run
    };
    // One that broke off before is looked at from there.
    let start = transient.t_end();
    let span = (start, start + options.periods as f64 * period);
    let seen = simulate_after(scene, &transient.run_end(), span, &seen)?;
    let mut points = points_of(&seen, &options.section)?;
    if let Section::Phase(_) = options.section {
        // Of a phase that is that of the start, the end is the start of the next value.
        points.truncate(options.periods);
    }
    Ok(AtValue {
        settled: settled(&seen, &vec![0.0; scene.n_dof()], DIAGRAM_LONGEST_PERIOD)?,
        points,
        status: if transient.status() == Status::Finished {
            seen.status()
        } else {
            transient.status()
        },
        last: seen.run_end(),
    })
}

/// The same where the forcing has no period: impacts are counted.
fn by_impacts(scene: &Scene, from: &RunEnd, options: &DiagramOptions) -> Result<AtValue> {
    let (run, section) = (run_options(options), &options.section);
    let transient = until(scene, (from, 0.0), (options.transient, section), &run)?;
    let start = (&transient.run_end(), transient.t_end());
    let seen = until(scene, start, (options.periods, section), &run)?;
    let mut points = points_of(&seen, section)?;
    points.truncate(options.periods);
    let status = match seen.status() {
        Status::MaxImpacts => Status::Finished,
        status => status,
    };
    Ok(AtValue {
        settled: settled_by_impacts(&seen, &points, DIAGRAM_LONGEST_PERIOD)?,
        points,
        status,
        last: seen.run_end(),
    })
}

/// One diagram of what all values gave.
fn gathered(
    all: Vec<AtValue>,
    is_up: Vec<bool>,
    parameter: Vec<f64>,
    n: usize,
) -> BifurcationDiagram {
    let count = all.iter().map(|at| at.points.t.len()).sum();
    let mut diagram = BifurcationDiagram {
        parameter,
        is_up,
        n_periods: all.iter().map(|at| at.settled.n_periods).collect(),
        n_impacts: all.iter().map(|at| at.settled.n_impacts).collect(),
        pattern: all.iter().map(|at| at.settled.pattern.clone()).collect(),
        status: all.iter().map(|at| at.status).collect(),
        index: Vec::with_capacity(count),
        points: PoincarePoints::with_room(count, n),
    };
    for (k, AtValue { points, .. }) in all.into_iter().enumerate() {
        diagram.index.extend(std::iter::repeat_n(k, points.t.len()));
        diagram.points.append(points);
    }
    diagram
}
