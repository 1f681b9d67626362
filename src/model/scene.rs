//! A scene: a system, its forcing and its stops, checked against each other once.

use crate::error::{Error, Result};
use crate::law::{ElementState, Newton};
use crate::model::constraint::Constraint;
use crate::model::derived::Derived;
use crate::model::excitation::Excitation;
use crate::model::forcing::{Forcing, Timing};
use crate::model::linear::LinearSystem;
use crate::model::moment::Moment;
use crate::model::nonlinear::no_mass;
use crate::model::ramp::SteadyRamp;
use crate::model::reaction::Reaction;
use crate::model::stop::Stop;
use crate::model::stop_motion::StopMotion;
use crate::model::system::System;
use crate::model::turns::nearest_turn;
use crate::tolerance::PLACE_FORGOTTEN;
use nalgebra::DVector;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::sync::Arc;

impl Laws {
    /// The law of a stop at a time, where it drifts.
    #[inline]
    pub fn law(&self, stop: usize, t: f64) -> Option<Newton> {
        Some(Newton::known(self.restitutions[stop]?.value(t)))
    }
}

/// System, forcing and stops: what is analysed or simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    pub(super) system: System,
    pub(super) forcing: Forcing,
    pub(super) stops: Vec<Constraint>,
    /// What runs by exact flights need of it.
    derived: Derived,
    /// What follows from its system and its stops alone, their motions apart.
    pub(super) contacts: Derived,
    /// What periodic motions need of it, the phase of its forcing left out.
    modal: Derived,
    /// What drifts along a run otherwise than by signals.
    laws: Option<Arc<Laws>>,
}

/// Numbers of a scene that are functions of time.
#[derive(Debug, PartialEq)]
pub(crate) struct Laws {
    /// The restitution of each stop, `None` of one that keeps its own.
    pub restitutions: Vec<Option<SteadyRamp>>,
    /// The factor on the damping.
    pub damping: Option<SteadyRamp>,
}

impl Scene {
    /// A scene.
    ///
    /// # Errors
    /// A forcing or stop that does not fit the system: wrong length, a coordinate it does not have, base motion without
    /// an influence vector, a wall without a pendulum, a reaction with `n.b <= 0`; a nonlinear system with base motion, or
    /// without the mass matrix that a harmonic force or an inertial reaction needs.
    pub fn new(
        system: impl Into<System>,
        forcing: impl Into<Forcing>,
        stops: impl IntoIterator<Item = impl Into<Constraint>>,
    ) -> Result<Self> {
        let scene = Self {
            system: system.into(),
            forcing: forcing.into(),
            stops: stops.into_iter().map(Into::into).collect(),
            derived: Derived::default(),
            contacts: Derived::default(),
            modal: Derived::default(),
            laws: None,
        };
        scene.check_forcing()?;
        for (i, stop) in scene.stops.iter().enumerate() {
            scene.check_stop(i, stop)?;
        }
        Ok(scene)
    }

    fn check_forcing(&self) -> Result<()> {
        let n = self.n_dof();
        self.forcing
            .parts()
            .try_for_each(|part| self.check_part(part, n))
    }

    /// One forcing of several.
    fn check_part(&self, part: &Forcing, n: usize) -> Result<()> {
        match (part, &self.system) {
            (Forcing::Harmonic(f), _) if f.amplitude().len() != n => Err(Error::bad_shape(
                "forcing.amplitude",
                format!("({},)", f.amplitude().len()),
                format!("({n},)"),
            )),
            (Forcing::Fourier(f), _) if f.n_dof() != n => Err(Error::bad_shape(
                "forcing.amplitudes",
                format!("({}, {})", f.n_harmonics(), f.n_dof()),
                format!("({}, {n})", f.n_harmonics()),
            )),
            (Forcing::BaseMotion(_) | Forcing::BaseAcceleration(_), System::Linear(s))
                if s.influence().is_none() =>
            {
                Err(Error::bad_value(
                    "forcing",
                    part.kind(),
                    "the linear system has no influence vector; give it one with `influence`",
                ))
            }
            (Forcing::BaseMotion(_) | Forcing::BaseAcceleration(_), System::Nonlinear(_)) => {
                Err(Error::bad_value(
                    "forcing",
                    part.kind(),
                    "it moves a pendulum or a linear system; write it into the acceleration of a nonlinear system",
                ))
            }
            (
                Forcing::Harmonic(_) | Forcing::Fourier(_) | Forcing::Load(_),
                System::Nonlinear(s),
            ) if !s.has_mass() => Err(no_mass(part.kind())),
            (Forcing::Load(load), _) => load.direction_vector(n).map(drop),
            _ => Ok(()),
        }
    }

    /// An inertial reaction needs the mass matrix.
    fn check_reaction(&self, label: &str, reaction: &Reaction) -> Result<()> {
        match (reaction, &self.system) {
            (Reaction::Inertia, System::Nonlinear(s)) if !s.has_mass() => Err(Error::bad_value(
                format!("{label}.reaction"),
                "\"inertia\"",
                "it needs the mass matrix of the nonlinear system: give it `mass`, or the stop another reaction",
            )),
            _ => Ok(()),
        }
    }

    fn check_stop(&self, index: usize, constraint: &Constraint) -> Result<()> {
        let (n, label) = (self.n_dof(), format!("stops[{index}]"));
        match constraint {
            Constraint::Stop(stop) => {
                self.check_reaction(&label, stop.reaction())?;
                let normal = stop.normal_vector(n, &label)?;
                if let Reaction::Direction(b) = stop.reaction() {
                    crate::quantity::finite_vector(&format!("{label}.reaction"), b, n)?;
                    let push = normal.dot(b);
                    if push <= f64::EPSILON * normal.norm() * b.norm() {
                        return Err(Error::bad_value(
                            format!("{label}.reaction"),
                            format!("a vector with n.b = {push}"),
                            "it must have n.b > 0, or the impact cannot turn the normal velocity",
                        ));
                    }
                }
                Ok(())
            }
            Constraint::Nonlinear(stop) => {
                if let Reaction::Direction(b) = stop.reaction() {
                    crate::quantity::finite_vector(&format!("{label}.reaction"), b, n)?;
                }
                self.check_reaction(&label, stop.reaction())
            }
            Constraint::Wall(wall) => match self.system.link_lengths() {
                None => Err(Error::bad_value(
                    label,
                    "a wall",
                    "walls stop the bobs of a pendulum; stop another system with `Stop` or `NonlinearStop`",
                )),
                Some(lengths) if wall.bob() >= lengths.len() => Err(Error::bad_value(
                    format!("{label}.bob"),
                    wall.bob(),
                    format!("the pendulum has bobs 0 to {}", lengths.len() - 1),
                )),
                Some(_) => Ok(()),
            },
        }
    }

    /// The system.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// The forcing.
    pub fn forcing(&self) -> &Forcing {
        &self.forcing
    }

    /// Names of its contact elements, in the order of the states of a regime: "stop\[0\]" and so on.
    pub fn elements(&self) -> Vec<String> {
        let stops = 0..self.stops.len();
        stops.map(|stop| format!("stop[{stop}]")).collect()
    }

    /// The stops.
    pub fn stops(&self) -> &[Constraint] {
        &self.stops
    }

    /// Number of degrees of freedom.
    pub fn n_dof(&self) -> usize {
        self.system.n_dof()
    }

    /// The period of the forcing and of the stops that move, `None` where nothing does, and where there is none in common.
    pub fn period(&self) -> Option<f64> {
        self.frequency().map(|w| TAU / w)
    }

    /// What acts on the system from outside, and how its stops move.
    pub(crate) fn excitation(&self) -> Excitation {
        if self.has_stop_motion() {
            let all = self.all_forcing();
            Excitation::with_stops(&self.system, &self.forcing, &self.stops, &all)
        } else {
            Excitation::new(&self.system, &self.forcing)
        }
    }

    /// Whether a stop moves by itself.
    pub(crate) fn has_stop_motion(&self) -> bool {
        self.stops.iter().any(|stop| stop.motion().is_some())
    }

    /// The scene while some of its numbers drift.
    pub(crate) fn with_laws(
        self,
        restitutions: Vec<Option<SteadyRamp>>,
        damping: Option<SteadyRamp>,
    ) -> Self {
        let has_any = damping.is_some() || restitutions.iter().any(Option::is_some);
        let laws = || Laws {
            restitutions,
            damping,
        };
        Self {
            laws: has_any.then(|| Arc::new(laws())),
            ..self
        }
    }

    /// What drifts otherwise than by signals.
    pub(crate) fn laws(&self) -> Option<&Arc<Laws>> {
        self.laws.as_ref()
    }

    /// The factor on its damping, where that drifts.
    pub(crate) fn drifting_damping(&self) -> Option<SteadyRamp> {
        self.laws.as_ref()?.damping
    }

    /// A copy whose motion is to be changed: without what was made of the scene once, but for its contacts.
    pub(super) fn to_be_changed(&self) -> Self {
        Self {
            derived: Derived::default(),
            modal: Derived::default(),
            ..self.clone()
        }
    }

    /// The scene with other frequencies and phases of the periodic parts of its forcing and of its stops' motions.
    pub(crate) fn with_angles(&self, of: impl Fn((f64, f64)) -> (f64, f64)) -> Result<Self> {
        let mut copy = self.to_be_changed();
        copy.with_all_forcing(|all| all.with_angles(&of))?;
        Ok(copy)
    }

    /// Frequency and phase of the first periodic part, whose phase `Parameter::Phase` is.
    pub(crate) fn first_angle(&self) -> Option<(f64, f64)> {
        self.all_forcing().angles().next()
    }

    /// The lowest frequency of all periodic parts.
    pub(crate) fn lowest_frequency(&self) -> Option<f64> {
        self.all_forcing().lowest().map(|(w, _)| w)
    }

    /// All that changes with time: the forcing, then the motions of stops in their order.
    pub(super) fn all_forcing(&self) -> Cow<'_, Forcing> {
        if !self.has_stop_motion() {
            return Cow::Borrowed(&self.forcing);
        }
        let stops = self.stops.iter().filter_map(Constraint::motion);
        let stops = stops.map(|motion| motion.as_forcing().clone());
        let all = std::iter::once(self.forcing.clone()).chain(stops);
        Cow::Owned(Forcing::Several(all.collect()))
    }

    /// Changes the forcing and the motions of stops together.
    pub(super) fn with_all_forcing(
        &mut self,
        change: impl FnOnce(&Forcing) -> Result<Forcing>,
    ) -> Result<()> {
        let changed = change(&self.all_forcing())?;
        if !self.has_stop_motion() {
            self.forcing = changed;
            return Ok(());
        }
        let Forcing::Several(all) = changed else {
            unreachable!("several are changed one by one");
        };
        let mut all = all.into_iter();
        self.forcing = all.next().unwrap_or_default();
        for stop in &mut self.stops {
            if stop.motion().is_some() {
                let motion = all.next().map(StopMotion::of_forcing);
                *stop = stop.clone().with_motion(motion);
            }
        }
        Ok(())
    }

    /// How the scene depends on time, but for equations of motion that do by themselves.
    pub(crate) fn timing(&self) -> Timing {
        self.all_forcing().timing()
    }

    /// Refuses stops that give way; `purpose` says what takes none yet.
    ///
    /// # Errors
    /// A stop that gives way.
    pub(crate) fn check_stops_are_rigid(&self, purpose: &str) -> Result<()> {
        let takers = match self.linear_system(purpose) {
            Ok(_) => "simulate and find_orbit do",
            Err(_) => "simulate does",
        };
        let rule = || format!("{purpose} does not take stops that give way yet; {takers}");
        self.refuse_springs(|stop| !stop.contact().is_rigid(), rule)
    }

    /// Refuses stops that give way in a scene that is not linear; `purpose` says what takes none there.
    ///
    /// # Errors
    /// A stop that gives way.
    pub(crate) fn check_springs_are_linear(&self, purpose: &str) -> Result<()> {
        if self.linear_system(purpose).is_ok() {
            return Ok(());
        }
        self.check_stops_are_rigid(&format!("{purpose} of a scene that is not linear"))
    }

    /// Periods of the forcing after which nothing is left of where the stops that relax were, the last digit included; none without such.
    pub(crate) fn periods_to_forget(&self) -> usize {
        let laws = self.stops.iter().map(Constraint::contact);
        let relaxing = laws.filter(|law| law.relaxes());
        let rates = relaxing.filter_map(|law| law.by_state().relaxation(ElementState::Relaxing));
        let longest = rates
            .map(|own| PLACE_FORGOTTEN / own.rate)
            .fold(0.0, f64::max);
        self.period()
            .map_or(0, |period| (longest / period).ceil() as usize)
    }

    /// Refuses a scene with a stop of some kind that gives way.
    fn refuse_springs(
        &self,
        is_refused: impl Fn(&Constraint) -> bool,
        rule: impl FnOnce() -> String,
    ) -> Result<()> {
        match self.stops.iter().position(is_refused) {
            Some(stop) => {
                let law = self.stops[stop].contact().name();
                Err(Error::bad_value(format!("stops[{stop}]"), law, rule()))
            }
            None => Ok(()),
        }
    }

    /// Refuses stops that move by themselves; `purpose` says what takes none.
    ///
    /// # Errors
    /// A stop that moves.
    pub(crate) fn check_stops_rest(&self, purpose: &str) -> Result<()> {
        if !self.has_stop_motion() {
            return Ok(());
        }
        let rule = format!(
            "{purpose} takes stops that rest relative to the base; use find_orbit with a guess"
        );
        Err(Error::bad_value("scene", "with a stop that moves", rule))
    }

    /// Whether a run over a span of time stays within the motions of the stops.
    ///
    /// # Errors
    /// A signal that the run leaves where it is not at rest.
    pub(crate) fn check_span(&self, span: (f64, f64)) -> Result<()> {
        for (i, stop) in self.stops.iter().enumerate() {
            if let Some((start, end)) = stop.motion().and_then(|motion| motion.is_left_by(span)) {
                let rule = format!(
                    "the motion of stops[{i}] is known on [{start}, {end}] alone, and is not at rest there: the stop would jump"
                );
                return Err(Error::bad_value("t_span", format!("{span:?}"), rule));
            }
        }
        Ok(())
    }

    /// Whether what acts on it is known to have a period, or to be constant.
    ///
    /// # Errors
    /// Forcings without a common period, and signals; `purpose` says what needs one.
    pub(crate) fn check_period(&self, purpose: &str) -> Result<()> {
        let Timing::Aperiodic { reason } = self.timing() else {
            return Ok(());
        };
        let rule = format!("{purpose} needs a period: {reason}");
        Err(Error::bad_value("scene", "without a period", rule))
    }

    /// The fundamental frequency of what acts on the system, `None` without forcing, and where there is none.
    pub(crate) fn frequency(&self) -> Option<f64> {
        self.all_forcing().frequency()
    }

    /// The phase of the fundamental frequency, zero without forcing, NaN where there is none.
    pub(crate) fn phase(&self) -> f64 {
        self.all_forcing().phase()
    }

    /// The same without its whole turns, which cost digits where it is added to an angle.
    pub(crate) fn turned_phase(&self) -> f64 {
        let phase = self.phase();
        let (turn, rest) = nearest_turn([phase, 0.0], 1.0);
        (phase - turn) - rest
    }

    /// The gap of every stop at the position q, at time zero where stops move, shape `(n_stops,)`.
    ///
    /// # Errors
    /// What the gap function of a nonlinear stop reports.
    ///
    /// # Panics
    /// If q has not n entries.
    pub fn gaps(&self, q: &DVector<f64>) -> Result<DVector<f64>> {
        self.gaps_at(q, 0.0)
    }

    /// The gap of every stop at the position q and a time, shape `(n_stops,)`.
    ///
    /// # Errors
    /// What the gap function of a nonlinear stop reports.
    ///
    /// # Panics
    /// If q has not n entries.
    pub fn gaps_at(&self, q: &DVector<f64>, t: f64) -> Result<DVector<f64>> {
        let mut gaps = self.gaps_at_rest(q)?;
        if self.has_stop_motion() {
            let frequency = self.frequency().unwrap_or(0.0);
            let turns = Moment::new(t, 0.0, frequency).angle_of(frequency);
            let at = Moment::new(t, turns + self.turned_phase(), frequency);
            let motions = self.excitation().stops;
            for (gap, motion) in gaps.iter_mut().zip(&motions) {
                *gap += motion.as_ref().map_or(0.0, |motion| motion.value_at(at));
            }
        }
        Ok(gaps)
    }

    /// The same where no stop moves by itself.
    fn gaps_at_rest(&self, q: &DVector<f64>) -> Result<DVector<f64>> {
        let n = self.n_dof();
        let gap = |constraint: &Constraint| match constraint {
            Constraint::Stop(stop) => Ok(stop.clearance() - stop.outward(n).dot(q)),
            Constraint::Nonlinear(stop) => stop.gap(q.as_slice()),
            Constraint::Wall(wall) => Ok(wall.gap(
                &self
                    .system
                    .link_lengths()
                    .expect("a scene with a wall has a pendulum"),
                q,
            )),
        };
        let gaps: Vec<f64> = self.stops.iter().map(gap).collect::<Result<_>>()?;
        Ok(DVector::from_vec(gaps))
    }

    /// The linear system, or the reason why the caller needs one.
    ///
    /// # Errors
    /// `Error::BadValue` for a nonlinear system or stop or a wall; `purpose` says what needs a linear scene.
    pub fn linear_system(&self, purpose: &str) -> Result<&Arc<LinearSystem>> {
        let rule = || format!("{purpose} needs a linear scene; take scene.linearise()");
        if self.stops.iter().any(|s| matches!(s, Constraint::Wall(_))) {
            return Err(Error::bad_value("scene", "a scene with a wall", rule()));
        }
        let is_nonlinear = |s: &Constraint| matches!(s, Constraint::Nonlinear(_));
        if self.stops.iter().any(is_nonlinear) {
            return Err(Error::bad_value(
                "scene",
                "a scene with a nonlinear stop",
                rule(),
            ));
        }
        if let Some(stop) = self.stops.iter().position(|s| !s.contact().is_linear()) {
            let rule = format!(
                "{purpose} needs forces of contact that are linear, as those of Spring are; simulate integrates others"
            );
            let law = self.stops[stop].contact().name();
            return Err(Error::bad_value(format!("stops[{stop}]"), law, rule));
        }
        match &self.system {
            System::Linear(system) => Ok(system),
            _ => Err(Error::bad_value("scene", "a nonlinear scene", rule())),
        }
    }

    /// The plane stops of a linear scene.
    pub(crate) fn plane_stops(&self) -> impl Iterator<Item = &Stop> {
        self.stops.iter().filter_map(|constraint| match constraint {
            Constraint::Stop(stop) => Some(stop),
            Constraint::Wall(_) | Constraint::Nonlinear(_) => None,
        })
    }

    /// The place of what is made once of its system and its stops, their motions apart.
    pub(crate) fn contacts(&self) -> &Derived {
        &self.contacts
    }

    /// The place of its modal form, phase left out.
    pub(crate) fn modal(&self) -> &Derived {
        &self.modal
    }

    /// The place of what is made of the scene once.
    pub(crate) fn derived(&self) -> &Derived {
        &self.derived
    }
}
