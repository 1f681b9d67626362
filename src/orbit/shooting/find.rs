//! `find_orbit`: from a guess to a periodic motion of any pattern (theory 5).

use crate::error::{Error, Result};
use crate::flow::ModalScene;
use crate::hybrid::{
    ClosedFormMaps, HybridMaps, IntegratedMaps, SegmentKind, constrained_motions, project_onto,
};
use crate::impact::wrapped;
use crate::modal::ModalState;
use crate::model::{Scene, System, contacts};
use crate::orbit::contact_mode::{ContactMode, Event};
use crate::orbit::flights::{Flight, OrbitData};
use crate::orbit::orbit_motion::{OrbitMotion, paired};
use crate::orbit::pattern::Pattern;
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::orbit::shooting::closure::{Clocked, FlightEnd, Shooting, ShootingState};
use crate::orbit::shooting::guess::{Guess, Start};
use crate::orbit::shooting::own_time::{depends_on_own_time, with_phase};
use crate::quantity::room_for;
use nalgebra::DVector;
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Arc;

/// A periodic motion near a guess: another orbit (of other parameters, say), or a trajectory that comes near it.
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
/// # Errors
/// `Error::NoConvergence`, with the mismatch reached, when no motion of the pattern closes near the guess to 1e-11 of its
/// size; a guess of another number of degrees of freedom, or with stops that the scene does not have; a trajectory that
/// did not keep its motion or does not return; equations that depend on time and do not repeat with the forcing; a Jacobian
/// that is off by more than 1e-3 of its size. Of lasting contact two things are refused: stops let go at one time, and a
/// contact with e > 0 that comes to rest while another stop is held or hit.
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
    find_orbit_observed(scene, guess, n_periods, &mut || ControlFlow::Continue(()))
}

/// [`find_orbit`], asking `observer` before each step of Newton's method whether to go on.
///
/// # Errors
/// As [`find_orbit`]; `Error::Interrupted` when the observer breaks off.
pub fn find_orbit_observed<'a>(
    scene: &Scene,
    guess: impl Into<Guess<'a>>,
    n_periods: Option<usize>,
    observer: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<PeriodicOrbit> {
    scene.check_period("find_orbit")?;
    let frequency = scene.frequency();
    let start = guess.into().read(frequency, n_periods)?;
    check(scene, &start)?;
    let depends = depends_on_own_time(scene, &start.states)?;
    let scene = with_phase(scene, start.phase, depends)?;
    if let System::Nonlinear(system) = scene.system() {
        let (q, v) = start.states[0].as_slice().split_at(scene.n_dof());
        system.check_jacobian(0.0, q, v)?;
    }
    if scene.linear_system("find_orbit").is_err() {
        return stepped(&scene, &start, depends, observer);
    }
    // Deviations, and the matrices between coordinates and modes.
    let n = scene.n_dof();
    room_for("shooting", 2 * n, 12 * n)?;
    let modal = Arc::new(ModalScene::new(&scene, "find_orbit")?);
    let held = constrained_motions(
        &modal,
        start.stages.iter().map(|stage| stage.held.as_slice()),
    )?;
    let motion = ClosedFormMaps::new(&modal, scene.phase(), held);
    let (found, flight_ends) = shoot(&motion, &scene, &start, observer)?;
    let pairs = |state: &DVector<f64>| motion.modal(state);
    let parts = parts(&scene, &start, &found, &flight_ends, &motion, pairs)?;
    PeriodicOrbit::new(&scene, Arc::clone(&modal), parts)
}

/// The orbit of a scene that is integrated in steps.
fn stepped(
    scene: &Scene,
    start: &Start,
    depends: bool,
    observer: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<PeriodicOrbit> {
    let motion = IntegratedMaps::new(scene, scene.phase());
    let (found, flight_ends) = shoot(&motion, scene, start, observer)?;
    let parts = parts(scene, start, &found, &flight_ends, &motion, paired)?;
    let scene = with_phase(scene, parts.phase, depends)?;
    let from_first = Arc::new(IntegratedMaps::new(&scene, parts.phase));
    let moved = OrbitMotion::stepped(from_first, &parts.flights)?;
    PeriodicOrbit::moved_by(moved, &scene, parts)
}

/// Closes the guess.
fn shoot<M: HybridMaps>(
    motion: &M,
    scene: &Scene,
    start: &Start,
    observer: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<(ShootingState, Vec<FlightEnd>)> {
    let clocked = match scene.frequency() {
        Some(w) => Clocked::Forced {
            period: TAU / w * start.n_periods as f64,
        },
        None => Clocked::Free,
    };
    let shooting = Shooting {
        motion,
        stages: &start.stages,
        clocked,
    };
    shooting.solve(first_loop(start, clocked), observer)
}

/// The parts of the orbit, counted from its first impact; impacts that accumulate are taken apart.
fn parts<M: HybridMaps>(
    scene: &Scene,
    start: &Start,
    found: &ShootingState,
    flight_ends: &[FlightEnd],
    motion: &M,
    pairs: impl Fn(&DVector<f64>) -> ModalState,
) -> Result<OrbitData> {
    let zero = found.times[0];
    let count = flight_ends.len();
    let (mut instants, mut impulses, mut flights) = (Vec::new(), Vec::new(), Vec::new());
    let flight = |mode: ContactMode, (from, to): (f64, f64), after: &_, before_next: &_| Flight {
        start: 0.0,
        span: to - from,
        after: pairs(after),
        before_next: pairs(before_next),
        mode,
    };
    for (k, stage) in start.stages.iter().enumerate() {
        let opening = &flight_ends[(k + count - 1) % count];
        let mut mode = ContactMode {
            kind: SegmentKind::Flight,
            stops: stage.held.clone(),
            is_struck: false,
            released: None,
        };
        if !stage.held.is_empty() {
            mode.kind = SegmentKind::Stick;
        }
        match &stage.event {
            Event::Nothing => mode.is_struck = stage.held.is_empty(),
            Event::Release(stop) => mode.released = Some(*stop),
            Event::Strike(stops) => {
                instants.push(stops.clone());
                impulses.extend_from_slice(&opening.impulses);
                mode.is_struck = true;
            }
            Event::Chatter(stop) => {
                let chatter = opening.chatter.as_ref();
                let chatter = chatter.expect("completed at every instant where impacts accumulate");
                for (i, bounce) in chatter.bounces.iter().enumerate() {
                    let next = chatter.bounces.get(i + 1);
                    let (to, before_next) = next
                        .map_or((chatter.last_time, &chatter.last), |next| {
                            (next.time, &next.before)
                        });
                    let span = (bounce.time, to);
                    instants.push(vec![*stop]);
                    impulses.push(bounce.impulse);
                    flights.push(flight(ContactMode::FREE, span, &bounce.after, before_next));
                }
                // The rest is over in no time: it begins without normal speed.
                let mut rest = chatter.last.clone();
                project_onto(motion, &[*stop], chatter.last_time, &mut rest)?;
                let remainder = ContactMode {
                    kind: SegmentKind::Chatter,
                    stops: vec![*stop],
                    is_struck: false,
                    released: None,
                };
                let span = (chatter.last_time, found.starts[k]);
                flights.push(flight(remainder, span, &rest, &found.states[k]));
            }
        }
        let mut after = found.states[k].clone();
        project_onto(motion, &stage.held, found.starts[k], &mut after)?;
        let span = (found.starts[k], found.times[k + 1]);
        flights.push(flight(mode, span, &after, &flight_ends[k].before));
    }
    // The starts are the sums of the spans, as those of an orbit that was saved.
    let mut elapsed = 0.0;
    for flight in &mut flights {
        flight.start = elapsed;
        elapsed += flight.span;
    }
    let frequency = scene.frequency().unwrap_or(0.0);
    Ok(OrbitData {
        pattern: Pattern::new(instants)?,
        n_periods: start.n_periods,
        phase: wrapped(frequency * zero + scene.phase()),
        flights,
        impulses,
        clearances: Vec::new(),
    })
}

fn check(scene: &Scene, start: &Start) -> Result<()> {
    let (found, wanted) = (start.states[0].len() / 2, scene.n_dof());
    if found != wanted {
        let found = format!("of {found} degrees of freedom");
        let rule = format!("the scene has {wanted}");
        return Err(Error::bad_value("guess", found, rule));
    }
    let mut struck = Vec::new();
    for stage in &start.stages {
        match &stage.event {
            Event::Strike(stops) => struck.push(stops.clone()),
            Event::Chatter(stop) | Event::Release(stop) => struck.push(vec![*stop]),
            Event::Nothing => {}
        }
    }
    Pattern::new(struck)?.check(scene.stops().len())?;
    let contacts = contacts(scene);
    for (k, stage) in start.stages.iter().enumerate() {
        let Event::Strike(stops) = &stage.event else {
            continue;
        };
        let before = &start.stages[(k + start.stages.len() - 1) % start.stages.len()].held;
        let mut caught = stops.iter().filter(|stop| stage.held.contains(stop));
        if let Some(&stop) =
            caught.find(|&&stop| !before.contains(&stop) && contacts[stop].restitution > 0.0)
        {
            let rule = "its impacts must accumulate while no other stop is held or hit; of other contacts that come to rest \
                        with e > 0 there is no Jacobian";
            let value = format!("a motion that comes to rest on stop {stop} by an impact");
            return Err(Error::bad_value("guess", value, rule));
        }
    }
    Ok(())
}

/// The guess, its times stretched to the period that the motion has to have.
fn first_loop(start: &Start, clocked: Clocked) -> ShootingState {
    let period = match clocked {
        Clocked::Forced { period } => period,
        Clocked::Free => start.period,
    };
    let ends = start.parts.iter().copied().chain([1.0]);
    ShootingState {
        times: ends.map(|part| part * period).collect(),
        starts: start.starts.iter().map(|part| part * period).collect(),
        states: start.states.clone(),
    }
}
