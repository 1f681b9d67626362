//! A periodic orbit as a result: the motion at any time, its impacts, whether it is admissible and stable.

use crate::error::Result;
use crate::flow::ModalScene;
use crate::impact::Impact;
use crate::model::{Change, Forcing, PhysicalState, Scene};
use crate::observer::{Observer, unobserved};
use crate::orbit::extremes::{Along, Extremes};
use crate::orbit::orbit_data::{OrbitArc, OrbitData};
use crate::orbit::orbit_motion::OrbitMotion;
use crate::orbit::paper_coefficients::{Coefficients, coefficients};
use crate::orbit::pattern::Pattern;
use crate::orbit::problem::outgrown;
use crate::orbit::stability::multipliers::Stability;
use crate::orbit::verdict::admissibility::{Admissibility, Breach, Ruling, Touch, Violation};
use crate::path::{Energy, Impulses, Located, Path, PathPoint, Segment, Stretch, energy_along};
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
    motion: OrbitMotion,
    pattern: Pattern,
    n_periods: usize,
    period: f64,
    phase: f64,
    flights: Vec<OrbitArc>,
    impacts: Vec<Impact>,
    path: OnceLock<Path>,
    /// What stops give on each segment of the path.
    given: OnceLock<Vec<Vec<f64>>>,
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
            given: OnceLock::new(),
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
    pub(super) fn lost(&self) -> Option<f64> {
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

    /// The parts of one period, counted from the first impact, as those of a trajectory: flights from impact to impact, the
    /// rest of impacts that accumulate, lasting contact (each stop in contact has a row). What stops give on them is integrated when
    /// first asked for.
    ///
    /// # Errors
    /// What the functions of a nonlinear scene report.
    pub fn segments(&self) -> Result<Vec<Segment>> {
        let impulses = self.impulses_of_segments()?;
        let rows = self
            .stretches()
            .flat_map(|part| part.rows(&impulses[part.segment]));
        Ok(rows.collect())
    }

    /// The parts of one period, each once, with the stops in contact.
    pub(crate) fn stretches(&self) -> impl Iterator<Item = Stretch<'_>> {
        let flights = self.flights.iter().zip(&self.path().parts.segments);
        flights.enumerate().map(|(segment, (flight, own))| Stretch {
            segment,
            kind: own.kind,
            regime: &own.regime,
            start: flight.start,
            end: flight.end,
        })
    }

    /// What the stops in contact on each segment of the path give.
    fn impulses_of_segments(&self) -> Result<&Vec<Vec<f64>>> {
        if let Some(known) = self.given.get() {
            return Ok(known);
        }
        let impulses = Impulses::new(self.path(), &self.scene, &self.impacts)?.of_segments()?;
        Ok(self.given.get_or_init(|| impulses))
    }

    /// Position right after the first impact, shape `(n,)`.
    pub fn q0(&self) -> DVector<f64> {
        self.motion.physical(&self.flights[0].after).0
    }

    /// Velocity right after the first impact, shape `(n,)`.
    pub fn v0(&self) -> DVector<f64> {
        self.motion.physical(&self.flights[0].after).1
    }

    /// Position and velocity at any time; at an impact the velocity is the one after it, or before it.
    pub fn state(&self, t: f64, before_impact: bool) -> PhysicalState {
        match self.place(t, before_impact) {
            FlightPosition::End(k) => self.motion.physical(&self.flights[k].before_next),
            FlightPosition::Start(k) => self.motion.physical(&self.flights[k].after),
            FlightPosition::Within(k, local) => {
                let PathPoint { arc, local, .. } = self.path().point_along(k, local);
                self.path().state_in(arc, local)
            }
        }
    }

    /// The same, and where on the path of one period it is.
    pub(super) fn locate(&self, t: f64, before_impact: bool) -> Located {
        let path = self.path();
        let point = match self.place(t, before_impact) {
            FlightPosition::End(k) => path.end_of(path.parts.arcs_of(k).end - 1, t),
            FlightPosition::Start(k) => path.point_along(k, 0.0),
            FlightPosition::Within(k, local) => path.point_along(k, local),
        };
        let state = self.state(t, before_impact);
        Located { point, state }
    }

    /// A time as whole periods and what is left of one; a time within rounding of an impact is the impact.
    pub(super) fn periods_and_rest(&self, t: f64) -> (f64, f64) {
        let turns = (t / self.period).floor();
        match self.place(t, false) {
            FlightPosition::Start(0) => ((t / self.period).round(), 0.0),
            FlightPosition::Start(k) => (turns, self.flights[k].start),
            FlightPosition::End(_) | FlightPosition::Within(..) => {
                (turns, t.rem_euclid(self.period))
            }
        }
    }

    /// Where on the flights a time is.
    fn place(&self, t: f64, before_impact: bool) -> FlightPosition {
        let mut local = t.rem_euclid(self.period);
        if local >= self.period {
            local = 0.0;
        }
        // A time within rounding of an impact is the impact: times are often made by adding spans up.
        let at_impact =
            |start: f64| (local - start).abs() <= 4.0 * f64::EPSILON * t.abs().max(self.period);
        if !self.pattern.instants().is_empty() {
            let ends = self.flights.iter().map(|f| f.start + f.span).enumerate();
            for (k, end) in ends {
                let next = (k + 1) % self.flights.len();
                if at_impact(end) || (next == 0 && at_impact(0.0)) {
                    return if before_impact {
                        FlightPosition::End(k)
                    } else {
                        FlightPosition::Start(next)
                    };
                }
            }
        }
        let k = self
            .flights
            .iter()
            .rposition(|f| f.start <= local)
            .unwrap_or(0);
        FlightPosition::Within(k, local - self.flights[k].start)
    }

    /// One period as a path.
    pub(crate) fn path(&self) -> &Path {
        self.path
            .get_or_init(|| self.motion.path(self.phase, &self.flights))
    }

    /// The energy ledger of one period, from right after the first impact to right after it a period later; what the forcing brought
    /// is then what was lost.
    ///
    /// # Errors
    /// A system given by functions without its mass matrix or its potential.
    pub fn energy(&self) -> Result<Energy> {
        let points = self.path().points()?;
        energy_along(self.path(), &self.scene, &points, &mut Observer::default())
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

/// Where on the flights of an orbit a time is.
enum FlightPosition {
    /// At the end of one, before the impacts there.
    End(usize),
    /// At the start of one.
    Start(usize),
    /// A time after its start.
    Within(usize, f64),
}

/// A ruling as an answer.
fn decided(ruling: Ruling) -> Option<bool> {
    match ruling {
        Ruling::Admissible => Some(true),
        Ruling::Undecided => None,
        Ruling::Broken(_) => Some(false),
    }
}
