//! What happens along a periodic motion and in which order, which stays while its numbers change; and the equations of a motion that has
//! it, in a scene of any kind (theory 19).

use crate::error::Result;
use crate::flow::ModalScene;
use crate::hybrid::{ClosedFormMaps, HybridMaps, IntegratedMaps, ScaledUnits, regime_motions};
use crate::impact::wrapped;
use crate::itinerary::{ArcEnd, Itinerary, MotionArc, contacts_begun};
use crate::law::{Regime, Stage};
use crate::modal::ModalState;
use crate::model::Scene;
use crate::orbit::orbit_data::{OrbitArc, OrbitData};
use crate::orbit::orbit_motion::{OrbitMotion, paired};
use crate::orbit::pattern::Pattern;
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::orbit::shooting::closure::{
    Clocked, Shooting, ShootingState, WEAK_EXACT, WEAK_INTEGRATED,
};
use crate::orbit::shooting::own_time::with_phase;
use crate::quantity::room_for;
use nalgebra::DVector;
use std::f64::consts::TAU;
use std::sync::Arc;

/// What happens at the instants of a periodic motion, what is held between them, and for how many periods of the forcing it goes on.
#[derive(Debug, Clone)]
pub(crate) struct Signature {
    pub stages: Itinerary,
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
    /// The same with the motion in one regime more.
    pub fn beside(mut self, regime: &Regime) -> Self {
        self.stages.push(Stage::uneventful(regime.clone()));
        self
    }

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
pub(crate) type OrbitOf<'a> = &'a dyn Fn(&ShootingState, &[ArcEnd]) -> Result<PeriodicOrbit>;

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
        scene.check_stops_are_rigid("find_orbit of a scene that is not linear")?;
        let motion = &IntegratedMaps::new(scene, scene.phase()).in_units(signature.units);
        let orbit = |found: &ShootingState, flight_ends: &[ArcEnd]| {
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
    let orbit = |found: &ShootingState, flight_ends: &[ArcEnd]| {
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

/// Does some work with the maps of a scene in the regimes of a signature.
pub(crate) fn with_maps<T>(
    scene: &Scene,
    signature: &Signature,
    work: impl FnOnce(&dyn HybridMaps) -> Result<T>,
) -> Result<T> {
    with_shooting(scene, signature, |shooting, _| work(shooting.motion))
}

/// The parts of the orbit, counted from its first impact; impacts that accumulate are taken apart.
fn parts<M: HybridMaps>(
    scene: &Scene,
    signature: &Signature,
    found: &ShootingState,
    arc_ends: &[ArcEnd],
    motion: &M,
    pairs: impl Fn(&DVector<f64>) -> ModalState,
) -> Result<OrbitData> {
    let arcs = in_order(found.arcs(&signature.stages, arc_ends, motion)?);
    // The starts are the sums of the spans, as those of an orbit that was saved.
    let mut elapsed = 0.0;
    let mut flights = Vec::with_capacity(arcs.len());
    for arc in arcs {
        let span = arc.end - arc.start;
        let states = [&arc.after, &arc.before_next].map(&pairs);
        flights.push(OrbitArc::over(arc.stage, [elapsed, span], states));
        elapsed += span;
    }
    let frequency = scene.frequency().unwrap_or(0.0);
    Ok(OrbitData {
        pattern: Pattern::new(contacts_begun(&flights).collect())?,
        n_periods: signature.n_periods,
        phase: wrapped(frequency * found.times[0] + scene.phase()),
        flights,
        impulses: impulses_in_order(arc_ends),
        clearances: Vec::new(),
    })
}

/// The arcs of an orbit: a loop knows the end of impacts that are next to nothing no better than their speed, and it comes no earlier than
/// what is left of them begins.
fn in_order(mut arcs: Vec<MotionArc<DVector<f64>>>) -> Vec<MotionArc<DVector<f64>>> {
    for k in 1..arcs.len() {
        let begun = arcs[k - 1].start;
        if arcs[k - 1].accumulation().is_some() && arcs[k].start < begun {
            (arcs[k - 1].end, arcs[k].start) = (begun, begun);
            arcs[k].end = arcs[k].end.max(begun);
        }
    }
    arcs
}

/// The impulses of a period in the order of its impacts, given the ends of its arcs, the last of which comes first.
fn impulses_in_order(arc_ends: &[ArcEnd]) -> Vec<f64> {
    let mut impulses = Vec::new();
    let last = arc_ends.iter().rev().take(1);
    for end in last.chain(&arc_ends[..arc_ends.len() - 1]) {
        impulses.extend_from_slice(&end.impulses);
        let bounces = end.chatter.iter().flat_map(|chatter| &chatter.bounces);
        impulses.extend(bounces.map(|bounce| bounce.impulse));
    }
    impulses
}
