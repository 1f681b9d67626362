//! What happens along a periodic motion and in which order, which stays while its numbers change; and the equations of a motion that has
//! it, in a scene of any kind (theory 19).

use crate::error::Result;
use crate::flow::ModalScene;
use crate::hybrid::{
    ClosedFormMaps, HybridMaps, IntegratedMaps, SegmentKind, constrained_motions, project_onto,
};
use crate::impact::wrapped;
use crate::modal::ModalState;
use crate::model::Scene;
use crate::orbit::contact_mode::{ContactMode, ContactStage, Event};
use crate::orbit::flights::{Flight, OrbitData};
use crate::orbit::orbit_motion::{OrbitMotion, paired};
use crate::orbit::pattern::Pattern;
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::orbit::shooting::closure::{Clocked, FlightEnd, Shooting, ShootingState};
use crate::orbit::shooting::own_time::with_phase;
use crate::quantity::room_for;
use nalgebra::DVector;
use std::f64::consts::TAU;
use std::sync::Arc;

/// What happens at the instants of a periodic motion, what is held between them, and for how many periods of the forcing it goes on.
#[derive(Debug, Clone)]
pub(crate) struct Signature {
    pub stages: Vec<ContactStage>,
    /// 1 without forcing.
    pub n_periods: usize,
    /// Whether the equations of the scene depend on time by themselves.
    pub depends_on_time: bool,
    /// Of a motion that is its own mirror image half a period later, of which the stages are one half: the image of each stop.
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

/// What makes an orbit of a closed loop, with the ends of its flights.
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
        let motion = &IntegratedMaps::new(scene, scene.phase());
        let orbit = |found: &ShootingState, flight_ends: &[FlightEnd]| {
            let parts = parts(scene, signature, found, flight_ends, motion, paired)?;
            let scene = with_phase(scene, parts.phase, signature.depends_on_time)?;
            let from_first = Arc::new(IntegratedMaps::new(&scene, parts.phase));
            let moved = OrbitMotion::stepped(from_first, &parts.flights)?;
            PeriodicOrbit::moved_by(moved, &scene, parts)
        };
        let shooting = Shooting {
            motion,
            stages,
            clocked,
            images,
        };
        return work(&shooting, &orbit);
    }
    // Deviations, and the matrices between coordinates and modes.
    let n = scene.n_dof();
    room_for("shooting", 2 * n, 12 * n)?;
    let modal = Arc::new(ModalScene::new(scene, "find_orbit")?);
    let held = constrained_motions(&modal, stages.iter().map(|stage| stage.held.as_slice()))?;
    let motion = &ClosedFormMaps::new(&modal, scene.phase(), held);
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
    for (k, stage) in signature.stages.iter().enumerate() {
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
        n_periods: signature.n_periods,
        phase: wrapped(frequency * zero + scene.phase()),
        flights,
        impulses,
        clearances: Vec::new(),
    })
}
