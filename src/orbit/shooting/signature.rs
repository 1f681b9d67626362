//! What happens along a periodic motion and in which order, which stays while its numbers change; and the equations of a motion that has
//! it, in a scene of any kind (theory 19).

use crate::error::Result;
use crate::flow::ModalScene;
use crate::hybrid::{ClosedFormMaps, HybridMaps, IntegratedMaps, ScaledUnits, regime_motions};
use crate::impact::wrapped;
use crate::law::Stage;
use crate::modal::ModalState;
use crate::model::Scene;
use crate::orbit::flights::{Flight, OrbitData};
use crate::orbit::orbit_motion::{OrbitMotion, paired};
use crate::orbit::pattern::Pattern;
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::orbit::shooting::closure::{
    Clocked, FlightEnd, Shooting, ShootingState, WEAK_EXACT, WEAK_INTEGRATED,
};
use crate::orbit::shooting::own_time::with_phase;
use crate::orbit::shooting::shooting_flight::{
    ShootingFlight, in_order, shooting_flights, struck_in_order,
};
use crate::quantity::room_for;
use nalgebra::DVector;
use std::f64::consts::TAU;
use std::sync::Arc;

/// What happens at the instants of a periodic motion, what is held between them, and for how many periods of the forcing it goes on.
#[derive(Debug, Clone)]
pub(crate) struct Signature {
    pub stages: Vec<Stage>,
    /// 1 without forcing.
    pub n_periods: usize,
    /// Whether the equations of the scene depend on time by themselves.
    pub depends_on_time: bool,
    /// The units of the states that it was read from: of motions that are integrated, absolute tolerances are parts of them.
    pub units: ScaledUnits,
    /// The image of each stop, where the motion is its own mirror image half a period later; the stages are then those of one half.
    pub images: Option<Vec<usize>>,
}

impl Signature {
    /// The times that are unknown in a scene.
    pub fn clocked(&self, scene: &Scene) -> Clocked {
        match scene.frequency() {
            Some(w) => {
                let half = if self.images.is_some() { 0.5 } else { 1.0 };
                let period = TAU / w * self.n_periods as f64 * half;
                Clocked::Forced { period }
            }
            None => Clocked::Free,
        }
    }
}

/// A function that makes an orbit of a closed loop and the ends of its flights.
pub(crate) type OrbitOf<'a> = &'a dyn Fn(&ShootingState, &[FlightEnd]) -> Result<PeriodicOrbit>;

/// Does some work with the equations of a signature in a scene, whatever moves it; the phase of the scene is that of the forcing at time
/// zero.
pub(crate) fn with_shooting<T>(
    scene: &Scene,
    signature: &Signature,
    work: impl FnOnce(&Shooting<'_>, OrbitOf<'_>) -> Result<T>,
) -> Result<T> {
    let clocked = signature.clocked(scene);
    let stages = &signature.stages;
    let images = signature.images.as_deref();
    if scene.linear_system("find_orbit").is_err() {
        let motion = &IntegratedMaps::new(scene, scene.phase()).in_units(signature.units);
        let orbit = |found: &ShootingState, flight_ends: &[FlightEnd]| {
            let parts = parts(scene, signature, found, flight_ends, motion, paired)?;
            let scene = with_phase(scene, parts.phase, signature.depends_on_time)?;
            let from_first = IntegratedMaps::new(&scene, parts.phase);
            let moved = OrbitMotion::stepped(from_first, &parts.flights)?;
            PeriodicOrbit::moved_by(moved, &scene, parts)
        };
        let shooting = Shooting {
            motion,
            stages,
            clocked,
            images,
            weak_directions: WEAK_INTEGRATED,
        };
        return work(&shooting, &orbit);
    }
    // Deviations, and the matrices between coordinates and modes.
    let n = scene.n_dof();
    room_for("shooting", 2 * n, 12 * n)?;
    let modal = ModalScene::of(scene, "find_orbit")?;
    let regimes = regime_motions(&modal, stages.iter().map(|stage| &stage.regime))?;
    let motion = &ClosedFormMaps::new(&modal, scene.phase(), regimes);
    let orbit = |found: &ShootingState, flight_ends: &[FlightEnd]| {
        let pairs = |state: &DVector<f64>| motion.modal(state);
        let parts = parts(scene, signature, found, flight_ends, motion, pairs)?;
        PeriodicOrbit::new(scene, Arc::clone(&modal), parts)
    };
    let shooting = Shooting {
        motion,
        stages,
        clocked,
        images,
        weak_directions: WEAK_EXACT,
    };
    work(&shooting, &orbit)
}

/// The parts of the orbit, counted from its first impact; impacts that accumulate are taken apart.
fn parts<M: HybridMaps>(
    scene: &Scene,
    signature: &Signature,
    found: &ShootingState,
    flight_ends: &[FlightEnd],
    motion: &M,
    pairs: impl Fn(&DVector<f64>) -> ModalState,
) -> Result<OrbitData> {
    let flights = in_order(shooting_flights(
        &signature.stages,
        found,
        flight_ends,
        motion,
    )?);
    let (instants, impulses) = struck_in_order(&signature.stages, flight_ends);
    let flight = |own: ShootingFlight| Flight {
        start: 0.0,
        span: own.end - own.start,
        after: pairs(&own.after),
        before_next: pairs(&own.before_next),
        mode: own.mode,
    };
    let mut flights: Vec<Flight> = flights.into_iter().map(flight).collect();
    // The starts are the sums of the spans, as those of an orbit that was saved.
    let mut elapsed = 0.0;
    for flight in &mut flights {
        flight.start = elapsed;
        elapsed += flight.span;
    }
    let frequency = scene.frequency().unwrap_or(0.0);
    Ok(OrbitData {
        pattern: Pattern::new(instants)?,
        n_periods: signature.n_periods,
        phase: wrapped(frequency * found.times[0] + scene.phase()),
        flights,
        impulses,
        clearances: Vec::new(),
    })
}
