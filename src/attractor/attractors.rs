//! The attractors of a scene, found from many starts.

use crate::attractor::finding::{Found, Search};
use crate::attractor::kind::AttractorKind;
use crate::attractor::same::{Group, groups};
use crate::error::{Error, Result};
use crate::model::Scene;
use crate::observer::ObserverFn;
use crate::orbit::{Pattern, PeriodicOrbit};
use crate::quantity::{finite, finite_vector};
use crate::simulate::{Method, SimulateOptions};
use crate::sweep::tiles::fill;
use crate::sweep::{Progress, SweepOptions};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Starts that know nothing of each other; those after them know the orbits that they have led to. The result does not depend on it.
const SIDE_BY_SIDE: usize = 16;

/// An attractor of a scene of n degrees of freedom.
#[derive(Debug, Clone)]
pub struct Attractor {
    /// What it is.
    pub kind: AttractorKind,
    /// The orbit, where there is one; `None` of what does not repeat itself, and of what Newton's method does not close.
    pub orbit: Option<PeriodicOrbit>,
    /// Periods of the forcing in one of its own; zero where it has none up to the longest that was looked for.
    pub n_periods: usize,
    /// Its states (q, v) at the phase, one after the other, of what does not repeat itself a thousand; shape `(p, 2n)`.
    pub points: DMatrix<f64>,
    /// Its Lyapunov exponents; empty where it has no multipliers.
    pub exponents: Vec<f64>,
    /// The stops hit in one of its periods; empty where it has none.
    pub pattern: Pattern,
    /// Why it has no orbit; empty where it has.
    pub reason: String,
    /// The part of the starts outside every stop that led to it.
    pub fraction: f64,
}

/// A box of states (q, v).
#[derive(Debug, Clone, PartialEq)]
pub struct StateBox {
    pub(crate) low: DVector<f64>,
    pub(crate) high: DVector<f64>,
}

impl StateBox {
    /// From the lowest to the highest of each position, then of each velocity; shape `(2n,)` each.
    ///
    /// # Errors
    /// Arrays that do not fit, are not finite or upside down; a box without width in every position, or in every velocity.
    pub fn new(low: DVector<f64>, high: DVector<f64>) -> Result<Self> {
        finite_vector("box", &high, low.len())?;
        finite_vector("box", &low, low.len())?;
        if let Some(i) = (0..low.len()).find(|&i| low[i] > high[i]) {
            let value = format!("({}, {}) in row {i}", low[i], high[i]);
            return Err(Error::bad_value(
                "box",
                value,
                "the first must be the lower one",
            ));
        }
        let made = Self { low, high };
        if made.widths().iter().any(|width| *width == 0.0) {
            let rule =
                "some position and some velocity must have a range: distances are measured by them";
            return Err(Error::bad_value("box", "without width", rule));
        }
        Ok(made)
    }

    /// The lowest of each.
    pub(crate) fn low(&self) -> &DVector<f64> {
        &self.low
    }

    /// The widths by which distances are measured: where a coordinate has none, the largest of its kind.
    pub(crate) fn widths(&self) -> DVector<f64> {
        let n = self.low.len() / 2;
        let width = |i: usize| self.high[i] - self.low[i];
        let largest = |half: usize| (0..n).map(|i| width(half * n + i)).fold(0.0, f64::max);
        DVector::from_fn(2 * n, |i, _| {
            if width(i) > 0.0 {
                width(i)
            } else {
                largest(i / n)
            }
        })
    }
}

/// Options of [`find_attractors`].
#[derive(Debug, Clone, PartialEq)]
pub struct AttractorOptions {
    /// The phase of the forcing at which motions begin and points are taken, default 0 \[rad\].
    pub phase: f64,
    /// The longest period that is looked for, in periods of the forcing, default 32.
    pub longest_period: usize,
    /// Periods that are left out, default 200.
    pub transient: usize,
    /// Periods after which a motion that has not settled is told by its exponents, default 2000.
    pub max_periods: usize,
    /// As for [`simulate`](crate::simulate()).
    pub method: Method,
    /// As for [`simulate`](crate::simulate()).
    pub rtol: f64,
    /// As for [`simulate`](crate::simulate()).
    pub atol: f64,
    /// Threads.
    pub sweep: SweepOptions,
}

impl Default for AttractorOptions {
    fn default() -> Self {
        let usual = SimulateOptions::default();
        Self {
            phase: 0.0,
            longest_period: 32,
            transient: 200,
            max_periods: 2000,
            method: usual.method,
            rtol: usual.rtol,
            atol: usual.atol,
            sweep: SweepOptions::default(),
        }
    }
}

impl AttractorOptions {
    pub(crate) fn run(&self) -> SimulateOptions {
        SimulateOptions {
            method: self.method,
            rtol: self.rtol,
            atol: self.atol,
            ..SimulateOptions::default()
        }
    }
}

/// The attractors of a scene that were found, the one that most starts led to first.
#[derive(Debug, Clone)]
pub struct Attractors {
    /// The attractors.
    pub all: Vec<Attractor>,
    /// Of each start the place of its attractor; `None` of those that were not decided, were lost, or began inside a stop.
    pub of_seed: Vec<Option<usize>>,
    /// Starts that were not decided.
    pub n_undecided: usize,
    /// Starts that left the surroundings of the box.
    pub n_lost: usize,
    /// Starts inside a stop.
    pub n_inside: usize,
}

/// Finds what the motions of a scene settle on, from states, one a row, shape `(k, 2n)`: each start is followed until it repeats itself and
/// an orbit is found where it does, or its exponents say what it is.
///
/// `observer` is called on the calling thread about every 50 ms and at the end; breaking off stops every thread.
///
/// # Errors
/// A scene without a forcing period; states that do not fit or are not finite; a period of zero to look for; as
/// [`simulate`](crate::simulate()).
///
/// # References
/// Theory section 17.
///
/// # Examples
/// ```
/// use std::ops::ControlFlow;
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{AttractorKind, AttractorOptions, Harmonic, LinearSystem, Scene, StateBox, Stop, find_attractors};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![9.0.into()], 2.4, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
/// let around = StateBox::new(dvector![-3.0, -5.0], dvector![1.0, 5.0])?;
/// let seeds = dmatrix![0.0, 0.0; -1.0, 2.0; 0.5, -3.0];
/// let go_on = &mut |_| ControlFlow::Continue(());
/// let found = find_attractors(&scene, &around, &seeds, &AttractorOptions::default(), go_on)?;
/// assert_eq!(found.all.len(), 1);
/// assert_eq!(found.all[0].kind, AttractorKind::Periodic);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn find_attractors(
    scene: &Scene,
    around: &StateBox,
    seeds: &DMatrix<f64>,
    options: &AttractorOptions,
    observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Attractors> {
    let found = settle_seeds(scene, around, seeds, options, observer)?;
    Ok(gathered(found, around))
}

/// What each start settles on.
pub(crate) fn settle_seeds(
    scene: &Scene,
    around: &StateBox,
    seeds: &DMatrix<f64>,
    options: &AttractorOptions,
    observer: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Vec<Found>> {
    let n = scene.n_dof();
    if around.low.len() != 2 * n {
        let found = format!("({}, 2)", around.low.len());
        return Err(Error::bad_shape("box", found, format!("({}, 2)", 2 * n)));
    }
    if seeds.ncols() != 2 * n {
        let found = format!("({}, {})", seeds.nrows(), seeds.ncols());
        return Err(Error::bad_shape("seeds", found, format!("(k, {})", 2 * n)));
    }
    if let Some(i) = (0..seeds.nrows()).find(|&i| seeds.row(i).iter().any(|x| !x.is_finite())) {
        let rule = "it must be finite";
        return Err(Error::bad_value(format!("seeds[{i}]"), f64::NAN, rule));
    }
    finite("phase", options.phase)?;
    if options.longest_period == 0 {
        return Err(Error::bad_value(
            "longest_period",
            0,
            "it must be at least 1",
        ));
    }
    let Some(period) = scene.period() else {
        let rule = "attractors are looked at once in each period of the forcing: it must have one";
        return Err(Error::bad_value("scene", "without a forcing period", rule));
    };
    let mut search = Search {
        scene,
        around,
        options,
        period,
        start: period * ((options.phase - scene.phase()) / TAU).rem_euclid(1.0),
        known: Vec::new(),
    };
    let total = seeds.nrows();
    let mut found = vec![Found::Undecided; total];
    for (k, part) in found.chunks_mut(SIDE_BY_SIDE).enumerate() {
        let first = k * SIDE_BY_SIDE;
        let work = |(): &mut (), i: usize, go_on: ObserverFn<'_>| {
            let row = seeds.row(first + i);
            let half = |from: usize| row.columns(from, n).transpose();
            let settled = search.settle(&(half(0), half(n)), go_on);
            settled.map_err(|error| error.at(format_args!("seeds[{}]", first + i)))
        };
        let watch = &mut |Progress { done, .. }| {
            observer(Progress {
                done: first + done,
                total,
            })
        };
        fill(part, 1, options.sweep, || Ok(()), work, watch)?;
        for own in part {
            if let Found::Attractor(own) = own
                && own.orbit.is_some()
                && !search.knows(own)
            {
                search.known.push((**own).clone());
            }
        }
    }
    Ok(found)
}

/// The attractors among what starts have settled on, the one that most starts led to first.
fn gathered(found: Vec<Found>, around: &StateBox) -> Attractors {
    let of = |own: &Found| match own {
        Found::Attractor(own) => Some((own.kind, own.n_periods, own.points.clone())),
        _ => None,
    };
    let seen: Vec<_> = found.iter().map(of).collect();
    let groups = groups(&seen, &around.widths());
    let count = |is_one: fn(&Found) -> bool| found.iter().filter(|own| is_one(own)).count();
    let n_inside = count(|own| matches!(own, Found::Inside));
    let outside = (found.len() - n_inside) as f64;
    let first = |group: &Group| match &found[group.first] {
        Found::Attractor(own) => Some(Attractor {
            fraction: group.count as f64 / outside,
            ..(**own).clone()
        }),
        _ => None,
    };
    Attractors {
        all: groups.all.iter().filter_map(first).collect(),
        of_seed: groups.of_each,
        n_undecided: count(|own| matches!(own, Found::Undecided)),
        n_lost: count(|own| matches!(own, Found::Lost)),
        n_inside,
    }
}
