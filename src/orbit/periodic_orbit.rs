//! Periodic orbits as results: the motion at any time, its impacts, whether it is admissible and stable; and the list of
//! all orbits of a pattern with the verdict on the periodic problem.

use crate::error::{Error, Result};
use crate::flow::carry;
use crate::flow::{ModalScene, SceneFlow, along, with_flow};
use crate::impact::{Impact, wrapped};
use crate::modal::Pair;
use crate::model::{Change, Scene};
use crate::orbit::Pattern;
use crate::orbit::admissible::{Admissibility, Judge, Touch, Violation};
use crate::orbit::closed_form::{Coefficients, coefficients};
use crate::orbit::stability::{Stability, stability};
use nalgebra::{DMatrix, DVector};
use std::sync::{Arc, OnceLock};

/// One flight of an orbit, in modal pairs.
#[derive(Debug, Clone)]
pub(crate) struct Flight {
    /// Its start, counted from the first impact.
    pub start: f64,
    pub span: f64,
    /// The state at its start, after the impacts there.
    pub after: Vec<Pair>,
    /// The state at its end, before the impacts there.
    pub before_next: Vec<Pair>,
}

/// A periodic motion that hits stops in a given pattern; t = 0 is right after its first impact.
#[derive(Debug, Clone)]
pub struct PeriodicOrbit {
    scene: Scene,
    modal: Arc<ModalScene>,
    flow: Arc<SceneFlow>,
    pattern: Pattern,
    n_periods: usize,
    period: f64,
    phase: f64,
    flights: Vec<Flight>,
    impacts: Vec<Impact>,
    admissibility: Admissibility,
    violation: Option<Violation>,
    stability: OnceLock<Result<Stability>>,
}

/// What makes an orbit: the parts that a solver found.
pub(crate) struct Parts {
    pub pattern: Pattern,
    pub n_periods: usize,
    pub phase: f64,
    pub flights: Vec<Flight>,
    /// The impulses, instant by instant, in the order of the pattern.
    pub impulses: Vec<f64>,
}

impl PeriodicOrbit {
    /// An orbit from its parts; `scene` has the orbit's clearances and is given its phase here.
    pub(crate) fn new(
        scene: &Scene,
        modal: Arc<ModalScene>,
        flow: Arc<SceneFlow>,
        parts: Parts,
    ) -> Result<Self> {
        let Parts {
            pattern,
            n_periods,
            phase,
            flights,
            impulses,
        } = parts;
        let states = flights
            .iter()
            .flat_map(|f| f.after.iter().chain(&f.before_next));
        if !states.flatten().all(|x| x.is_finite()) {
            let rule = "its motion grows beyond the largest number within a period";
            return Err(Error::bad_value("scene", "unstable", rule));
        }
        let impacts = list_impacts(&modal, &pattern, phase, &flights, &impulses);
        let admissibility = Judge::new(&modal).admissibility(phase, &flights, &impacts);
        Ok(Self {
            scene: scene.replace(Change::Phase(phase))?,
            period: flights.iter().map(|f| f.span).sum(),
            modal,
            flow,
            pattern,
            n_periods,
            phase,
            flights,
            impacts,
            violation: admissibility.breach.map(|breach| breach.describe()),
            admissibility,
            stability: OnceLock::new(),
        })
    }

    /// The scene with the orbit's phase and clearances: simulated from `(q0, v0)` at t = 0 it retraces the orbit.
    pub fn scene(&self) -> &Scene {
        &self.scene
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

    /// Position right after the first impact, shape `(n,)`.
    pub fn q0(&self) -> DVector<f64> {
        self.modal.form.to_physical(&self.flights[0].after).0
    }

    /// Velocity right after the first impact, shape `(n,)`.
    pub fn v0(&self) -> DVector<f64> {
        self.modal.form.to_physical(&self.flights[0].after).1
    }

    /// Position and velocity at any time; at an impact the velocity is the one after it, or before it.
    pub fn state(&self, t: f64, before_impact: bool) -> (DVector<f64>, DVector<f64>) {
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
                    let state = if before_impact {
                        &self.flights[k].before_next
                    } else {
                        &self.flights[next].after
                    };
                    return self.modal.form.to_physical(state);
                }
            }
        }
        let flight = self
            .flights
            .iter()
            .rfind(|f| f.start <= local)
            .unwrap_or(&self.flights[0]);
        let mut state = flight.after.clone();
        with_flow!(&*self.flow, f => carry(f, self.modal.frequency * flight.start + self.phase, local - flight.start, &mut state));
        self.modal.form.to_physical(&state)
    }

    /// The coefficients of eq. (14); `None` where the modes are complex or there is no steady response.
    pub fn coefficients(&self) -> Option<Coefficients> {
        coefficients(&self.modal, self.phase, &self.flights[0].after)
    }

    /// Whether the orbit keeps the rules of contact at every time.
    pub fn is_admissible(&self) -> bool {
        self.violation.is_none()
    }

    /// The worst breach of the rules of contact.
    pub fn violation(&self) -> Option<&Violation> {
        self.violation.as_ref()
    }

    /// Touches within the margin, without impact.
    pub fn touches(&self) -> &[Touch] {
        &self.admissibility.touches
    }

    /// Multipliers and what they decide, computed when first asked for.
    ///
    /// # Errors
    /// `Error::NoConvergence` if an eigenvalue iteration fails.
    pub fn stability(&self) -> Result<&Stability> {
        self.stability
            .get_or_init(|| {
                stability(
                    &self.modal,
                    self.pattern.instants(),
                    self.phase,
                    &self.flights,
                    &self.admissibility,
                )
            })
            .as_ref()
            .map_err(Clone::clone)
    }
}

/// An orbit as plain numbers, from which it can be made again: spans of its flights, modal states (after, then before the
/// next instant, flight by flight), impulses.
#[derive(Debug, Clone, PartialEq)]
pub struct Saved {
    /// Forcing periods in one period.
    pub n_periods: usize,
    /// Forcing phase at the first impact.
    pub phase: f64,
    /// Spans of the flights.
    pub spans: Vec<f64>,
    /// Modal states, flattened.
    pub states: Vec<f64>,
    /// Impulses in the order of the pattern.
    pub impulses: Vec<f64>,
}

impl PeriodicOrbit {
    /// The orbit as plain numbers.
    pub fn save(&self) -> Saved {
        let states = self
            .flights
            .iter()
            .flat_map(|f| f.after.iter().chain(&f.before_next))
            .flatten();
        Saved {
            n_periods: self.n_periods,
            phase: self.phase,
            spans: self.flights.iter().map(|f| f.span).collect(),
            states: states.copied().collect(),
            impulses: self.impacts.iter().map(|i| i.impulse).collect(),
        }
    }

    /// The orbit that was saved; `scene` is the orbit's own.
    ///
    /// # Errors
    /// Numbers that do not fit the scene.
    pub fn restore(scene: &Scene, pattern: Pattern, saved: Saved) -> Result<Self> {
        let modal = Arc::new(ModalScene::new(scene, "an orbit")?);
        let n = modal.form.n_dof();
        if saved.states.len() != 4 * n * saved.spans.len() || saved.spans.is_empty() {
            let expected = format!("({},)", 4 * n * saved.spans.len());
            return Err(Error::bad_shape(
                "states",
                format!("({},)", saved.states.len()),
                expected,
            ));
        }
        let pairs: Vec<Pair> = saved.states.chunks(2).map(|z| [z[0], z[1]]).collect();
        let mut start = 0.0;
        let mut flights = Vec::new();
        for (span, states) in saved.spans.iter().zip(pairs.chunks(2 * n)) {
            let (after, before_next) = (states[..n].to_vec(), states[n..].to_vec());
            flights.push(Flight {
                start,
                span: *span,
                after,
                before_next,
            });
            start += span;
        }
        let flow = Arc::new(modal.flow());
        let Saved {
            n_periods,
            phase,
            impulses,
            ..
        } = saved;
        Self::new(
            scene,
            modal,
            flow,
            Parts {
                pattern,
                n_periods,
                phase,
                flights,
                impulses,
            },
        )
    }
}

/// The impacts of a period, instant by instant.
pub(crate) fn list_impacts(
    scene: &ModalScene,
    pattern: &Pattern,
    phase: f64,
    flights: &[Flight],
    impulses: &[f64],
) -> Vec<Impact> {
    let mut impacts = Vec::with_capacity(impulses.len());
    let mut impulses = impulses.iter();
    for (k, instant) in pattern.instants().iter().enumerate() {
        let previous = &flights[(k + flights.len() - 1) % flights.len()].before_next;
        for (&stop, &impulse) in instant.iter().zip(impulses.by_ref()) {
            impacts.push(Impact {
                time: flights[k].start,
                stop,
                approach: along(&scene.velocity_rows[stop], previous),
                departure: -along(&scene.velocity_rows[stop], &flights[k].after),
                impulse,
                phase: wrapped(scene.frequency * flights[k].start + phase),
            });
        }
    }
    impacts
}

/// The verdict on a periodic problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// There are isolated orbits.
    Found,
    /// There is none.
    None,
    /// There is a family of orbits with one parameter or more.
    Family,
}

/// The directions of a family of orbits.
#[derive(Debug, Clone)]
pub struct Family {
    /// Directions of the contact state (q, v) in which the orbit may be changed, shape `(2n, dimension)`.
    pub basis: DMatrix<f64>,
}

/// Options of [`crate::periodic_orbits`].
#[derive(Debug, Clone, PartialEq)]
pub struct OrbitOptions {
    /// Forcing periods in one period of the orbit, 1 or more.
    pub n_periods: usize,
    /// A given forcing phase at the first impact \[rad\]: the clearances come out. `None`: clearances given, phase found.
    pub phase: Option<f64>,
    /// One more unknown, as stops hit together need.
    pub free: Option<crate::orbit::Free>,
    /// The range of the free parameter.
    pub between: Option<(f64, f64)>,
}

impl Default for OrbitOptions {
    fn default() -> Self {
        Self {
            n_periods: 1,
            phase: None,
            free: None,
            between: None,
        }
    }
}

/// Every orbit of a pattern: stable and admissible ones first, then admissible ones, then by depth of violation.
#[derive(Debug, Clone)]
pub struct Orbits {
    pub(crate) all: Vec<PeriodicOrbit>,
    pub(crate) verdict: Verdict,
    pub(crate) reason: String,
    pub(crate) margin: Option<f64>,
    pub(crate) family: Option<Family>,
}

impl Orbits {
    /// Whether orbits were found, or a family, or none.
    pub fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// Why, in words.
    pub fn reason(&self) -> &str {
        &self.reason
    }

    /// `1 - |d|/|alpha|`: how far the parameters are from the fold at which the orbits meet and vanish; negative: none.
    pub fn margin(&self) -> Option<f64> {
        self.margin
    }

    /// The family, where the verdict is one.
    pub fn family(&self) -> Option<&Family> {
        self.family.as_ref()
    }
}

impl IntoIterator for Orbits {
    type Item = PeriodicOrbit;
    type IntoIter = std::vec::IntoIter<PeriodicOrbit>;

    fn into_iter(self) -> Self::IntoIter {
        self.all.into_iter()
    }
}

impl std::ops::Deref for Orbits {
    type Target = [PeriodicOrbit];

    fn deref(&self) -> &[PeriodicOrbit] {
        &self.all
    }
}
