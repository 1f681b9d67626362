//! A periodic orbit as a result: the motion at any time, its impacts, whether it is admissible and stable.

use crate::error::Result;
use crate::flow::ModalScene;
use crate::impact::Impact;
use crate::model::{Change, Forcing, Scene};
use crate::observer::{Observer, unobserved};
use crate::orbit::extremes::{Along, Extremes};
use crate::orbit::orbit_data::{OrbitArc, OrbitData};
use crate::orbit::orbit_motion::OrbitMotion;
use crate::orbit::paper_coefficients::{Coefficients, coefficients};
use crate::orbit::pattern::Pattern;
use crate::orbit::problem::outgrown;
use crate::orbit::stability::multipliers::Stability;
use crate::orbit::verdict::admissibility::{Admissibility, Breach, Ruling, Touch, Violation};
use crate::path::Path;
use crate::quantity::room_for;
use nalgebra::DVector;
use std::sync::{Arc, OnceLock};

/// A periodic motion that hits stops in a given pattern; t = 0 is right after its first impact.
///
/// Where stops are held and let go that is the first impact that follows a release.
#[derive(Debug, Clone)]
pub struct PeriodicOrbit {
    scene: Scene,
    /// The scene as it was before it was turned to the phase, where that rounds the phases of several motions.
    unturned: Option<Box<Scene>>,
    pub(super) motion: OrbitMotion,
    pub(super) pattern: Pattern,
    n_periods: usize,
    pub(super) period: f64,
    phase: f64,
    pub(super) flights: Vec<OrbitArc>,
    impacts: Vec<Impact>,
    path: OnceLock<Path>,
    /// What the stops in contact on each segment of the path give [N s], shape `(n_contacts,)` each.
    pub(super) contact_impulses: OnceLock<Vec<Vec<f64>>>,
    admissibility: OnceLock<Admissibility>,
    violation: OnceLock<Option<Violation>>,
    stability: OnceLock<Stability>,
    extremes: OnceLock<Extremes>,
}

impl PeriodicOrbit {
    /// An orbit from its parts; `scene` has the orbit's clearances and is given its phase here.
    pub(crate) fn new(scene: &Scene, modal: Arc<ModalScene>, parts: OrbitData) -> Result<Self> {
        let motion = OrbitMotion::modal_along(modal, &parts.flights)?;
        Self::moved_by(motion, scene, parts)
    }

    /// An orbit from what moves it and its parts.
    pub(crate) fn moved_by(motion: OrbitMotion, scene: &Scene, parts: OrbitData) -> Result<Self> {
        let OrbitData {
            pattern,
            n_periods,
            phase,
            flights,
            impulses,
            ..
        } = parts;
        if !flights.iter().all(OrbitArc::is_finite) {
            return Err(outgrown());
        }
        let impacts = motion.impacts(phase, &flights, &impulses)?;
        let rounds = scene.has_stop_motion() || matches!(scene.forcing(), Forcing::Several(_));
        Ok(Self {
            unturned: rounds.then(|| Box::new(scene.clone())),
            scene: match scene.frequency() {
                Some(_) => scene.replace(Change::FundamentalPhase(phase))?,
                None => scene.clone(),
            },
            period: flights.iter().map(|f| f.span).sum(),
            motion,
            pattern,
            n_periods,
            phase,
            flights,
            impacts,
            path: OnceLock::new(),
            contact_impulses: OnceLock::new(),
            admissibility: OnceLock::new(),
            violation: OnceLock::new(),
            stability: OnceLock::new(),
            extremes: OnceLock::new(),
        })
    }

    /// The scene with the orbit's phase and clearances: simulated from `(q0, v0)` at t = 0 it retraces the orbit.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene from which [`restore`](Self::restore) makes the orbit again to the last bit: [`scene`](Self::scene) in any phase.
    pub fn saved_scene(&self) -> &Scene {
        self.unturned.as_deref().unwrap_or(&self.scene)
    }

    /// The period \[s\].
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Forcing periods in one period.
    pub fn n_periods(&self) -> usize {
        self.n_periods
    }

    /// The forcing phase at t = 0 \[rad\], in [0, 2 pi).
    pub fn phase(&self) -> f64 {
        self.phase
    }

    /// The pattern.
    pub fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// The impacts of one period, in order of time.
    pub fn impacts(&self) -> &[Impact] {
        &self.impacts
    }

    /// By how much the motion misses its own beginning, relative to its size, where that is more than rounding explains.
    pub(super) fn lost(&self) -> Result<Option<f64>> {
        self.motion.lost(self.phase, &self.flights)
    }

    /// By how much the motion misses its own ends by another route than the one that made it, in parts of its size or of some units of
    /// positions and velocities, where that is more than rounding explains.
    pub(crate) fn closure_defect(&self, least: [f64; 2]) -> Result<Option<f64>> {
        self.motion.closure_defect(self.phase, &self.flights, least)
    }

    /// Its flights.
    pub(crate) fn flights(&self) -> &[OrbitArc] {
        &self.flights
    }

    /// Position right after the first impact, shape `(n,)`.
    pub fn q0(&self) -> DVector<f64> {
        self.motion.physical(&self.flights[0].after).0
    }

    /// Velocity right after the first impact, shape `(n,)`.
    pub fn v0(&self) -> DVector<f64> {
        self.motion.physical(&self.flights[0].after).1
    }

    /// One period as a path.
    pub(crate) fn path(&self) -> &Path {
        self.path
            .get_or_init(|| self.motion.path(self.phase, &self.flights))
    }

    /// The coefficients of eq. (14); `None` where the modes are complex, there is no steady response, or the first impact leads
    /// to lasting contact.
    pub fn coefficients(&self) -> Option<Coefficients> {
        if !self.flights[0].is_flight() {
            return None;
        }
        coefficients(
            self.motion.modal_scene()?,
            self.phase,
            &self.flights[0].after,
        )
    }

    /// What the rules of contact say, searched when first asked for.
    fn admissibility(&self) -> &Admissibility {
        unobserved(|| self.judged(&mut Observer::default()))
            .expect("a search that nobody interrupts comes to its end")
    }

    pub(super) fn judged(&self, observer: &mut Observer) -> Result<&Admissibility> {
        if let Some(known) = self.admissibility.get() {
            return Ok(known);
        }
        let found =
            self.motion
                .admissibility(self.phase, &self.flights, &self.impacts, observer)?;
        Ok(self.admissibility.get_or_init(|| found))
    }

    /// Whether the orbit keeps the rules of contact at every time; searched when first asked for. `None` where the search found
    /// no breach and could not prove that there is none: [`violation`](Self::violation) says where.
    pub fn is_admissible(&self) -> Option<bool> {
        decided(self.admissibility().ruling())
    }

    /// [`is_admissible`](Self::is_admissible), broken off where the observer of the thread says so.
    ///
    /// # Errors
    /// `Error::Interrupted`.
    pub fn try_is_admissible(&self) -> Result<Option<bool>> {
        Ok(decided(self.judged(&mut Observer::default())?.ruling()))
    }

    /// The worst breach of the rules of contact; where there is none, and none is excluded, where the search could not decide.
    pub fn violation(&self) -> Option<&Violation> {
        self.violation
            .get_or_init(|| self.admissibility().describe())
            .as_ref()
    }

    /// The rule of contact that is broken worst.
    pub(crate) fn breach(&self) -> Option<Breach> {
        self.admissibility().breach
    }

    /// Touches within the margin, without impact.
    pub fn touches(&self) -> &[Touch] {
        &self.admissibility().touches
    }

    /// The least gap of every stop over a period, shape `(stops,)`: zero for one that is hit, unless it is passed too.
    ///
    /// Sought between the points at which the motion is drawn, 8 in a radian of the fastest oscillation or 4 in a step of an integrator.
    ///
    /// # Errors
    /// What the functions of a nonlinear stop report.
    pub fn min_gap(&self) -> Result<Vec<f64>> {
        let gaps = &self.extremes()?.gaps;
        Ok(gaps.iter().map(|gap| gap.value).collect())
    }

    /// The largest distance of every coordinate from zero over a period, `max |q_i|`, shape `(n,)`; sought as
    /// [`min_gap`](Self::min_gap).
    ///
    /// # Errors
    /// As [`min_gap`](Self::min_gap).
    pub fn max_displacement(&self) -> Result<Vec<f64>> {
        let all = &self.extremes()?.displacements;
        Ok(all.iter().map(|own| own.value).collect())
    }

    /// The gap of a stop where it turns from closing to opening next to a place on a flight; none where it does not turn there, or there is no
    /// such flight.
    pub(crate) fn least_gap_near(&self, stop: usize, place: (usize, f64)) -> Result<Option<f64>> {
        if place.0 >= self.flights.len() {
            return Ok(None);
        }
        self.walked().least_gap_near(stop, place)
    }

    /// The flight that a time is on, and how far along it, in parts of its span.
    pub(crate) fn place_on_flight(&self, time: f64) -> (usize, f64) {
        let time = time.rem_euclid(self.period);
        let flight = self.flights.partition_point(|own| own.start <= time).max(1) - 1;
        let own = &self.flights[flight];
        (flight, ((time - own.start) / own.span).min(1.0))
    }

    fn walked(&self) -> Along<'_> {
        Along {
            scene: &self.scene,
            path: self.path(),
            flights: &self.flights,
        }
    }

    pub(crate) fn extremes(&self) -> Result<&Extremes> {
        if let Some(known) = self.extremes.get() {
            return Ok(known);
        }
        let found = Extremes::new(&self.walked())?;
        Ok(self.extremes.get_or_init(|| found))
    }

    /// Multipliers and what they decide, computed when first asked for.
    ///
    /// # Errors
    /// `Error::NoConvergence` if an eigenvalue iteration fails.
    pub fn stability(&self) -> Result<&Stability> {
        self.decided(&mut Observer::default())
    }

    pub(super) fn decided(&self, observer: &mut Observer) -> Result<&Stability> {
        if let Some(known) = self.stability.get() {
            return Ok(known);
        }
        let n = self.scene.n_dof();
        room_for("the monodromy matrix", 2 * n, 6 * n)?;
        let admissibility = self.judged(observer)?;
        let found = self
            .motion
            .stability(self.phase, &self.flights, admissibility, observer)?;
        Ok(self.stability.get_or_init(|| found))
    }
}

/// A ruling as an answer.
fn decided(ruling: Ruling) -> Option<bool> {
    match ruling {
        Ruling::Admissible => Some(true),
        Ruling::Undecided => None,
        Ruling::Broken(_) => Some(false),
    }
}
