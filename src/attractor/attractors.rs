//! The search for attractors from many starts: each start is followed by itself until its motion has settled, then the outcomes are
//! gathered into a list. Starts are states (q, v) in units of the scene, at a phase of the forcing \[rad\]. Source: docs/theory.md,
//! section 17.

use crate::attractor::finding::{AttractorSearch, SeedOutcome, TURNS};
use crate::attractor::gathering::gathered;
use crate::attractor::list::Attractors;
use crate::attractor::options::AttractorOptions;
use crate::attractor::state_box::StateBox;
use crate::error::{Error, Result};
use crate::model::Scene;
use crate::observer::{ProgressRange, report};
use crate::quantity::{at_least_one, finite};
use crate::section::wait;
use crate::sweep::tiles::fill;
use nalgebra::DMatrix;

/// Starts that are followed independently of each other at one time, on several threads; those after them know the orbits that these have
/// led to, so that a motion near a known orbit needs no search. The result does not depend on it. [work]
const SEEDS_SIDE_BY_SIDE: usize = 16;

/// Finds what the motions of a scene settle on, from many starts. The states are rows, shape (k, 2n): each start is followed
/// until it repeats itself and an orbit is found where it does, or its exponents say what it is.
///
/// The observer of the calling thread ([`with_observer`](crate::with_observer)) is told from time to time and at the end; breaking off stops
/// every thread.
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
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{AttractorKind, AttractorOptions, Harmonic, LinearSystem, Scene, StateBox, Stop, find_attractors};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![9.0.into()], 2.4, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
/// let around = StateBox::new(dvector![-3.0, -5.0], dvector![1.0, 5.0])?;
/// let seeds = dmatrix![0.0, 0.0; -1.0, 2.0; 0.5, -3.0];
/// let found = find_attractors(&scene, &around, &seeds, &AttractorOptions::default())?;
/// assert!(found.all.iter().all(|one| one.kind == AttractorKind::Periodic && one.orbit.is_some()));
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn find_attractors(
    scene: &Scene,
    around: &StateBox,
    seeds: &DMatrix<f64>,
    options: &AttractorOptions,
) -> Result<Attractors> {
    let found = settle_seeds(scene, around, seeds, options)?;
    gathered_seeds(scene, around, &found, options)
}

/// The list of attractors that the outcomes of seeds make, asking from time to time whether to go on.
pub(crate) fn gathered_seeds(
    scene: &Scene,
    around: &StateBox,
    found: &[SeedOutcome],
    options: &AttractorOptions,
) -> Result<Attractors> {
    let _range = ProgressRange::over(0.0, 1.0);
    report(1.0)?;
    gathered(&search(scene, around, options)?, found)
}

/// The search in a scene, with no orbit known yet.
fn search<'s>(
    scene: &'s Scene,
    around: &'s StateBox,
    options: &'s AttractorOptions,
) -> Result<AttractorSearch<'s>> {
    scene.check_springs_are_linear("find_attractors")?;
    let Some(period) = scene.period() else {
        let rule = "attractors are looked at once in each period of the forcing: it must have one";
        return Err(Error::bad_value("scene", "without a forcing period", rule));
    };
    Ok(AttractorSearch {
        scene,
        around,
        options,
        period,
        start: wait(period, scene.phase(), options.phase),
        known: Vec::new(),
    })
}

/// The outcome of each seed, states as rows, shape (k, 2n).
pub(crate) fn settle_seeds(
    scene: &Scene,
    around: &StateBox,
    seeds: &DMatrix<f64>,
    options: &AttractorOptions,
) -> Result<Vec<SeedOutcome>> {
    let n = scene.n_dof();
    around.check(n)?;
    if seeds.ncols() != 2 * n {
        let found = format!("({}, {})", seeds.nrows(), seeds.ncols());
        return Err(Error::bad_shape("seeds", found, format!("(k, {})", 2 * n)));
    }
    if let Some(i) = (0..seeds.nrows()).find(|&i| seeds.row(i).iter().any(|x| !x.is_finite())) {
        let value = seeds.row(i).iter().copied().find(|x| !x.is_finite());
        let rule = "it must be finite";
        return Err(Error::bad_value(
            format!("seeds[{i}]"),
            value.unwrap_or(f64::NAN),
            rule,
        ));
    }
    finite("phase", options.phase)?;
    options.solver.check()?;
    at_least_one("longest_period", options.longest_period)?;
    let mut search = search(scene, around, options)?;
    let total = seeds.nrows();
    let mut found = vec![SeedOutcome::Undecided; total];
    for (k, part) in found.chunks_mut(SEEDS_SIDE_BY_SIDE).enumerate() {
        let first = k * SEEDS_SIDE_BY_SIDE;
        let work = |(): &mut (), i: usize| {
            let row = seeds.row(first + i);
            let half = |from: usize| row.columns(from, n).transpose();
            let settled = search.settle(&(half(0), half(n)));
            settled.map_err(|error| error.at(format_args!("seeds[{}]", first + i)))
        };
        let _range = ProgressRange::over(-(first as f64), (total - first) as f64);
        fill(part, 1, options.sweep, || Ok(()), work)?;
        for own in part {
            if let SeedOutcome::Attractor(own) = own
                && (own.orbit.is_some() || own.reason == TURNS)
                && !search.knows(own)?
            {
                search.known.push((**own).clone());
            }
        }
    }
    Ok(found)
}
