//! `find_orbit`: from a guess to a periodic motion of any pattern (theory 5).

use crate::error::{Error, Result};
use crate::hybrid::ScaledUnits;
use crate::itinerary::{Itinerary, check_landings, check_laws};
use crate::model::{Scene, System};

use crate::orbit::pattern::Pattern;
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::orbit::shooting::closure::{Clocked, ShootingState};
use crate::orbit::shooting::guess::Guess;
use crate::orbit::shooting::guess_in_order::{ToCome, start_in_order};
use crate::orbit::shooting::own_time::{depends_on_own_time, with_phase};
use crate::orbit::shooting::signature::{Signature, with_shooting};
use crate::quantity::at_least_one;
use crate::recurrence::{Measure, advance};
use crate::simulate::{ImpactSide, Motion, Trajectory};
use crate::tolerance::SAME_ROUND;
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// States of a trajectory, one in each period of the forcing, by which a drift is recognised. [work]
const DRIFT_STATES: usize = 100;

/// A periodic motion near a guess: another orbit (of other parameters, say), a trajectory that comes near it, or a state.
///
/// Any scene, any number of instants; flights in closed form, or integrated to 2e-13; Newton's method on the flight times
/// and the states after the impacts, regular also where an impact has no speed. The pattern is the guess's. `n_periods` is the
/// number of forcing periods; without it, that of the orbit, or the least one after which the trajectory comes back. Without
/// forcing the period is found too. Where the orbits form a family, the member nearest the guess is returned. The result may be
/// inadmissible, and says so.
///
/// Equations that depend on time by themselves (of a [`NonlinearSystem`](crate::NonlinearSystem)) have to repeat with the forcing;
/// the orbit's scene has them later, as much as its phase is. A Jacobian that they give is used in every derivative of free
/// flights, and is compared with a difference first.
///
/// A motion may chatter, stay on stops and be let go ([`PeriodicOrbit::segments`]): impacts that accumulate are gone through until
/// what is left of them is 1e-12 of the motion, whatever the tolerances of the guess, and completed there; t = 0 is then right
/// after the first impact that follows a release. Contact forces have to push. Each chatter that ends in lasting contact has
/// two zero multipliers, and so has each impact with e = 0 that does. An orbit of a stop that is held for good has no impacts.
///
/// Stops of a linear scene may give way: t = 0 is then where a contact begins, and [`PeriodicOrbit::signature`] has what happens in a period.
///
/// # Errors
/// `Error::NoConvergence`, with the mismatch reached, when no motion of the pattern closes near the guess to 1e-11 of its
/// size; a guess of another number of degrees of freedom, or with stops that the scene does not have; a trajectory that
/// did not keep its motion or does not return; equations that depend on time and do not repeat with the forcing; a Jacobian
/// that is off by more than 1e-3 of its size. Of lasting contact two things are refused: stops let go at one time, and a
/// contact with e > 0 that comes to rest while another stop is held or hit. Of stops that give way: scenes that are not linear, a body that
/// comes to a seat or leaves it, a change of state at the instant of another event.
///
/// # References
/// Theory section 5, "several instants", as multiple shooting; A. B. Nordmark and P. T. Piiroinen, Nonlinear Dyn. 58 (2009) 85, for
/// the completion of chatter.
///
/// # Examples
/// ```
/// use vibroimpact::{Kind, OrbitOptions, PaperOptions, Pattern, find_orbit, paper_scene, periodic_orbits};
/// let options = OrbitOptions { n_periods: 2, ..Default::default() };
/// let known = paper_scene(Kind::Three, &PaperOptions::default())?;
/// let orbits = periodic_orbits(&known, &Pattern::single(1), &options)?;
/// let other = paper_scene(Kind::Three, &PaperOptions { damping: Some(0.06), ..Default::default() })?;
/// let orbit = find_orbit(&other, &orbits[0], None)?;
/// assert!(orbit.is_admissible() == Some(true) && orbit.phase() != orbits[0].phase());
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn find_orbit<'a>(
    scene: &Scene,
    guess: impl Into<Guess<'a>>,
    n_periods: Option<usize>,
) -> Result<PeriodicOrbit> {
    let guess = guess.into();
    let found = found_near(scene, guess, n_periods);
    match (found, guess) {
        (Err(error), Guess::Trajectory(run)) if error != Error::Interrupted => {
            Err(drift(run).ok().flatten().unwrap_or(error))
        }
        (found, _) => found,
    }
}

/// The error for a trajectory that drifts.
fn drift(run: &Trajectory) -> Result<Option<Error>> {
    let Some(period) = run.scene().period().filter(|_| run.ramps().is_empty()) else {
        return Ok(None);
    };
    let (start, end) = run.span();
    let count = (((end - start) / period) as usize + 1).min(DRIFT_STATES);
    let n = run.scene().n_dof();
    let mut states = DMatrix::zeros(count, 2 * n);
    for k in 0..count {
        let t = end - (count - 1 - k) as f64 * period;
        let (q, v) = run.state(t.max(start), ImpactSide::After)?;
        states.view_mut((k, 0), (1, n)).tr_copy_from(&q);
        states.view_mut((k, n), (1, n)).tr_copy_from(&v);
    }
    let measure = Measure::new(&vec![0.0; n], TAU / period);
    let found = advance(&states, &measure, count / 3);
    Ok(found.map(|found| {
        let rule = format!("{}; an orbit comes back to where it was", found.told());
        Error::bad_value("guess", "a motion that does not come back", rule)
    }))
}

/// The orbit near a guess.
fn found_near(scene: &Scene, guess: Guess<'_>, n_periods: Option<usize>) -> Result<PeriodicOrbit> {
    let is_counted = n_periods.is_some() || matches!(guess, Guess::Orbit(_));
    let (scene, signature, first) = begun_in_order(scene, guess, n_periods, None)?;
    if is_counted || signature.n_periods == 1 {
        return solved((scene, signature, first));
    }
    let several = with_shooting(&scene, &signature, |shooting, orbit| {
        let (found, flight_ends) = shooting.solve(first)?;
        Ok((orbit(&found, &flight_ends)?, found))
    });
    let (orbit, found) = several?;
    match one_round(&scene, &signature, &found)? {
        Some((signature, round)) => solved((scene, signature, round)),
        None => Ok(orbit),
    }
}

/// [`find_orbit`] for a pattern: from the state of the guess (of a trajectory its last one, of an orbit that in the middle of its last flight) the
/// stops of the pattern are hit in its order, each as soon as the flight meets it, and all others are passed through; those of one instant together
/// where the first of them is met. So orbits are found that are not admissible, or whose pattern the motion from the guess has not.
///
/// # Errors
/// As [`find_orbit`]; a stop of the pattern that is not hit within a period; a trajectory without forcing, as it has no period.
///
/// # Examples
/// ```
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{Guess, Harmonic, LinearSystem, Pattern, Scene, Stop, find_orbit_in_order};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![8.5.into()], 2.4, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?, Stop::new(0, 1.1, 0.8)?])?;
/// let guess = Guess::State { q: &dvector![0.0], v: &dvector![2.0], period: None };
/// // Behind the first stop, which it passes through.
/// let orbit = find_orbit_in_order(&scene, guess, None, &Pattern::single(1))?;
/// assert_eq!(orbit.is_admissible(), Some(false));
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn find_orbit_in_order<'a>(
    scene: &Scene,
    guess: impl Into<Guess<'a>>,
    n_periods: Option<usize>,
    pattern: &Pattern,
) -> Result<PeriodicOrbit> {
    let to_come = ToCome::Impacts(pattern);
    let begun = begun_in_order(scene, guess.into(), n_periods, Some(&to_come))?;
    solved(begun)
}

/// [`find_orbit`] for a signature, as [`PeriodicOrbit::signature`] has it, of a linear scene: from the state of the guess, as in
/// [`find_orbit_in_order`], its events are waited for in their order, each in the regime that those before have led to, and all other guards
/// are passed by. Those events are "press", "leave" and "relax" of stops that give way and "strike" of rigid ones; a stop that relaxes in the end is
/// taken to be back at the beginning.
///
/// # Errors
/// As [`find_orbit`]; a scene that is not linear, a stop that does not exist, an event of another name, one that the law of its stop does not
/// have then, or that does not come within a period.
///
/// # Examples
/// ```
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{ContactRelease, Guess, Harmonic, LinearSystem, Scene, Spring, Stop, find_orbit_of_signature};
/// let system = LinearSystem::new(dmatrix![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let law = Spring::new(20.0, 0.5, Some(ContactRelease::Gap))?;
/// let force = Harmonic::new(dvector![1.0.into()], 0.8, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 0.5, law)?])?;
/// let guess = Guess::State { q: &dvector![0.0], v: &dvector![1.8], period: None };
/// let orbit = find_orbit_of_signature(&scene, guess, None, &[("press", 0), ("leave", 0)])?;
/// assert_eq!(orbit.is_admissible(), Some(true));
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn find_orbit_of_signature<'a>(
    scene: &Scene,
    guess: impl Into<Guess<'a>>,
    n_periods: Option<usize>,
    signature: &[(&str, usize)],
) -> Result<PeriodicOrbit> {
    if signature.is_empty() {
        let rule = "a signature has an event at least; find_orbit finds motions without any";
        return Err(Error::bad_value("signature", "empty", rule));
    }
    let events = signature
        .iter()
        .map(|(event, element)| ((*event).to_owned(), *element));
    let events: Vec<(String, usize)> = events.collect();
    let to_come = ToCome::Events(&events);
    let begun = begun_in_order(scene, guess.into(), n_periods, Some(&to_come))?;
    solved(begun)
}

/// The orbit near the loop that a guess is.
fn solved((scene, signature, guess): (Scene, Signature, ShootingState)) -> Result<PeriodicOrbit> {
    with_shooting(&scene, &signature, |shooting, orbit| {
        let (found, flight_ends) = shooting.solve(guess)?;
        orbit(&found, &flight_ends)
    })
}

/// The scene with the phase of an orbit, what happens along the motion, and the loop that the orbit is.
pub(crate) fn begun(
    scene: &Scene,
    guess: Guess<'_>,
    n_periods: Option<usize>,
) -> Result<(Scene, Signature, ShootingState)> {
    scene.check_springs_are_linear(
        "what goes on from an orbit (continuation, derivatives, mirror images)",
    )?;
    begun_in_order(scene, guess, n_periods, None)
}

/// The same of a pattern that is given.
fn begun_in_order(
    scene: &Scene,
    guess: Guess<'_>,
    n_periods: Option<usize>,
    to_come: Option<&ToCome<'_>>,
) -> Result<(Scene, Signature, ShootingState)> {
    scene.check_period("find_orbit")?;
    check_periods(scene, n_periods)?;
    let start = match to_come {
        None => guess.read(scene, n_periods)?,
        Some(to_come) => {
            if let ToCome::Impacts(_) = to_come {
                scene.check_stops_are_rigid("find_orbit with pattern= (signature= does)")?;
            }
            start_in_order(guess, scene, n_periods, to_come)?
        }
    };
    let (stages, mut first) = ShootingState::of_instants(start.instants, 1.0);
    check(scene, &stages, &first)?;
    let depends = depends_on_own_time(scene, &first.states)?;
    let scene = with_phase(scene, start.phase, depends)?;
    if let System::Nonlinear(system) = scene.system() {
        let (q, v) = first.states[0].as_slice().split_at(scene.n_dof());
        system.check_jacobian(0.0, q, v)?;
    }
    let signature = Signature {
        stages,
        n_periods: start.n_periods,
        depends_on_time: depends,
        units: ScaledUnits::of(first.states.iter(), start.period),
        images: None,
    };
    // Its times are stretched to the period that the motion has to have.
    let period = match signature.clocked(&scene) {
        Clocked::Forced { period } => period,
        Clocked::Free => start.period,
    };
    let times = first.times.iter_mut().chain(&mut first.starts);
    times.for_each(|time| *time *= period);
    Ok((scene, signature, first))
}

/// The motion that a loop goes through several times, if it does.
fn one_round(
    scene: &Scene,
    signature: &Signature,
    found: &ShootingState,
) -> Result<Option<(Signature, ShootingState)>> {
    let (stages, n_periods) = (&signature.stages, signature.n_periods);
    for periods in 1..n_periods {
        let rounds = n_periods / periods;
        let own = stages.round(rounds);
        let Some(own) = own.filter(|_| n_periods.is_multiple_of(periods)) else {
            continue;
        };
        let round = Signature {
            stages: stages.iter().take(own).cloned().collect(),
            n_periods: periods,
            ..signature.clone()
        };
        let whole = found.times[stages.len()] - found.times[0];
        let end = found.times[0] + whole / rounds as f64;
        let state = ShootingState {
            times: found.times[..own].iter().copied().chain([end]).collect(),
            starts: found.starts[..own].to_vec(),
            states: found.states[..own].to_vec(),
        };
        let mismatch = with_shooting(scene, &round, |shooting, _| {
            shooting.mismatch(&state, &shooting.units(&state)?)
        })?;
        if mismatch <= SAME_ROUND {
            return Ok(Some((round, state)));
        }
    }
    Ok(None)
}

fn check_periods(scene: &Scene, n_periods: Option<usize>) -> Result<()> {
    at_least_one("n_periods", n_periods.unwrap_or(1))?;
    if let (None, Some(n)) = (scene.frequency(), n_periods) {
        let rule = "the scene has no forcing whose periods could be counted; leave it out";
        return Err(Error::bad_value("n_periods", n, rule));
    }
    Ok(())
}

fn check(scene: &Scene, stages: &Itinerary, first: &ShootingState) -> Result<()> {
    let (found, wanted) = (first.states[0].len() / 2, scene.n_dof());
    if found != wanted {
        let found = format!("of {found} degrees of freedom");
        let rule = format!("the scene has {wanted}");
        return Err(Error::bad_value("guess", found, rule));
    }
    Pattern::new(stages.elements())?.check(scene.stops().len())?;
    check_laws(scene, stages)?;
    check_landings(scene, stages)
}
