//! `find_orbit`: from a guess to a periodic motion of any pattern (theory 5).

use crate::error::{Error, Result};
use crate::flow::{ModalScene, SceneFlow, carry, with_flow};
use crate::impact::{impulse_matrix, wrapped};
use crate::model::{Change, Scene};
use crate::orbit::PeriodicOrbit;
use crate::orbit::guess::{Guess, Start};
use crate::orbit::motion::{OrbitMotion, paired};
use crate::orbit::periodic_orbit::{Flight, Parts};
use crate::orbit::shooting::{Clocked, Landing, Loop, Motion, Shooting};
use crate::orbit::stability::propagate;
use crate::orbit::stepped::SteppedMotion;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Arc;

/// A periodic motion near a guess: another orbit (of other parameters, say), or a trajectory that comes near it.
///
/// Any scene, any number of instants; flights in closed form, or integrated to 2e-13; Newton's method on the flight times
/// and the states after the impacts, regular also where an impact has no speed. The pattern is the guess's. `n_periods` is the number of forcing periods; without it,
/// that of the orbit, or the least one after which the trajectory comes back. Without forcing the period is found too.
/// Where the orbits form a family, the member nearest the guess is returned. The result may be inadmissible, and says so.
///
/// # Errors
/// `Error::NoConvergence`, with the mismatch reached, when no motion of the pattern closes near the guess to 1e-11 of its
/// size; a guess of another number of degrees of freedom, or with stops that the scene does not have; a trajectory that
/// did not keep its motion or does not return.
///
/// # References
/// Theory section 5, "several instants", as multiple shooting.
///
/// # Examples
/// ```
/// use vibroimpact::{Kind, OrbitOptions, PaperOptions, Pattern, find_orbit, paper_scene, periodic_orbits};
/// let options = OrbitOptions { n_periods: 2, ..Default::default() };
/// let known = paper_scene(Kind::Three, &PaperOptions::default())?;
/// let orbits = periodic_orbits(&known, &Pattern::single(1), &options)?;
/// let other = paper_scene(Kind::Three, &PaperOptions { damping: Some(0.06), ..Default::default() })?;
/// let orbit = find_orbit(&other, &orbits[0], None)?;
/// assert!(orbit.is_admissible() && orbit.phase() != orbits[0].phase());
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn find_orbit<'a>(
    scene: &Scene,
    guess: impl Into<Guess<'a>>,
    n_periods: Option<usize>,
) -> Result<PeriodicOrbit> {
    find_orbit_checked(scene, guess, n_periods, &mut || ControlFlow::Continue(()))
}

/// [`find_orbit`], asking `observer` before each step of Newton's method whether to go on.
///
/// # Errors
/// As [`find_orbit`]; `Error::Interrupted` when the observer breaks off.
pub fn find_orbit_checked<'a>(
    scene: &Scene,
    guess: impl Into<Guess<'a>>,
    n_periods: Option<usize>,
    observer: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<PeriodicOrbit> {
    let frequency = scene.forcing().frequency();
    let start = guess.into().read(frequency, n_periods)?;
    check(scene, &start)?;
    let scene = match frequency {
        Some(_) => scene.replace(Change::Phase(start.phase))?,
        None => scene.clone(),
    };
    if scene.linear_system("find_orbit").is_err() {
        return stepped(&scene, &start, observer);
    }
    let modal = Arc::new(ModalScene::new(&scene, "find_orbit")?);
    let motion = LinearMotion::new(&modal, scene.forcing().phase());
    let (found, landings) = shoot(&motion, &scene, &start, observer)?;
    let parts = parts(&scene, &start, &found, &landings, |state| {
        motion.modal(state)
    });
    PeriodicOrbit::new(&scene, Arc::clone(&modal), parts)
}

/// The orbit of a scene that is integrated in steps.
fn stepped(
    scene: &Scene,
    start: &Start,
    observer: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<PeriodicOrbit> {
    let motion = SteppedMotion::new(scene, scene.forcing().phase());
    let (found, landings) = shoot(&motion, scene, start, observer)?;
    let parts = parts(scene, start, &found, &landings, paired);
    let from_first = Arc::new(SteppedMotion::new(scene, parts.phase));
    let moved = OrbitMotion::stepped(from_first, &parts.flights)?;
    PeriodicOrbit::moved_by(moved, scene, parts)
}

/// Closes the guess.
fn shoot<M: Motion>(
    motion: &M,
    scene: &Scene,
    start: &Start,
    observer: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<(Loop, Vec<Landing>)> {
    let clocked = match scene.forcing().frequency() {
        Some(w) => Clocked::Forced {
            period: TAU / w * start.n_periods as f64,
        },
        None => Clocked::Free,
    };
    let shooting = Shooting {
        motion,
        pattern: &start.pattern,
        clocked,
    };
    shooting.solve(first_loop(start, clocked), observer)
}

/// The parts of the orbit, counted from its first impact.
fn parts(
    scene: &Scene,
    start: &Start,
    found: &Loop,
    landings: &[Landing],
    pairs: impl Fn(&DVector<f64>) -> Vec<[f64; 2]>,
) -> Parts {
    let last_first = landings.iter().cycle().skip(landings.len() - 1);
    let impulses = last_first.take(landings.len());
    let flights = landings.iter().enumerate().map(|(k, landing)| Flight {
        start: found.times[k] - found.times[0],
        span: found.times[k + 1] - found.times[k],
        after: pairs(&found.states[k]),
        before_next: pairs(&landing.before),
    });
    let forcing = scene.forcing();
    let frequency = forcing.frequency().unwrap_or(0.0);
    Parts {
        pattern: start.pattern.clone(),
        n_periods: start.n_periods,
        phase: wrapped(frequency * found.times[0] + forcing.phase()),
        flights: flights.collect(),
        impulses: impulses
            .flat_map(|landing| landing.impulses.iter().copied())
            .collect(),
    }
}

fn check(scene: &Scene, start: &Start) -> Result<()> {
    let (found, wanted) = (start.states[0].len() / 2, scene.n_dof());
    if found != wanted {
        let found = format!("of {found} degrees of freedom");
        let rule = format!("the scene has {wanted}");
        return Err(Error::bad_value("guess", found, rule));
    }
    start.pattern.check(scene.stops().len())
}

/// The guess, its times stretched to the period that the motion has to have.
fn first_loop(start: &Start, clocked: Clocked) -> Loop {
    let period = match clocked {
        Clocked::Forced { period } => period,
        Clocked::Free => start.period,
    };
    let ends = start.parts.iter().copied().chain([1.0]);
    Loop {
        times: ends.map(|part| part * period).collect(),
        states: start.states.clone(),
    }
}

/// A linear scene for the shooting: closed-form flights.
struct LinearMotion<'a> {
    scene: &'a ModalScene,
    flow: SceneFlow,
    phase: f64,
    to_physical: DMatrix<f64>,
    to_modal: DMatrix<f64>,
}

impl<'a> LinearMotion<'a> {
    fn new(scene: &'a ModalScene, phase: f64) -> Self {
        let (to_physical, to_modal) = scene.form.transformation();
        Self {
            scene,
            flow: scene.flow(),
            phase,
            to_physical,
            to_modal,
        }
    }

    fn modal(&self, state: &DVector<f64>) -> Vec<[f64; 2]> {
        let n = state.len() / 2;
        let (q, v) = (state.rows(0, n).into_owned(), state.rows(n, n).into_owned());
        self.scene.form.to_modal(&q, &v)
    }

    fn physical(&self, modal: &[[f64; 2]]) -> DVector<f64> {
        let (q, v) = self.scene.form.to_physical(modal);
        DVector::from_iterator(2 * q.len(), q.iter().chain(v.iter()).copied())
    }

    fn angle(&self, t: f64) -> f64 {
        self.scene.frequency * t + self.phase
    }
}

impl Motion for LinearMotion<'_> {
    fn fly(
        &self,
        (start, end): (f64, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<()> {
        let mut modal = self.modal(state);
        with_flow!(&self.flow, f => carry(f, self.angle(start), end - start, &mut modal));
        *state = self.physical(&modal);
        if deviations.ncols() > 0 {
            let mut carried = &self.to_modal * &*deviations;
            propagate(self.scene, end - start, &mut carried);
            *deviations = &self.to_physical * carried;
        }
        Ok(())
    }

    fn rate(&self, t: f64, state: &DVector<f64>) -> Result<DVector<f64>> {
        let modal = self.modal(state);
        let mut rate = vec![[0.0; 2]; modal.len()];
        let u = Complex::from_polar(1.0, self.angle(t));
        self.scene.rate(&modal, u, &mut rate);
        Ok(self.physical(&rate))
    }

    fn collide(
        &self,
        stops: &[usize],
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<Vec<f64>> {
        if stops.is_empty() {
            return Ok(Vec::new());
        }
        let (n, g) = (state.len() / 2, &self.scene.geometry);
        let (normals, reactions) = (
            g.normals.select_columns(stops),
            g.reactions.select_columns(stops),
        );
        let impulse_matrix = impulse_matrix(g, stops)?;
        let impulses = &impulse_matrix * normals.tr_mul(&state.rows(n, n));
        let mut v = state.rows_mut(n, n);
        v -= &reactions * &impulses;
        let mut dv = deviations.rows_mut(n, n);
        let change = reactions * (impulse_matrix * normals.tr_mul(&dv));
        dv -= change;
        Ok(impulses.iter().copied().collect())
    }

    fn gap(&self, stop: usize, state: &DVector<f64>) -> Result<(f64, DVector<f64>)> {
        let normal = self.scene.geometry.normals.column(stop).into_owned();
        let gap = self.scene.geometry.clearances[stop] - normal.dot(&state.rows(0, normal.len()));
        Ok((gap, -normal))
    }
}
