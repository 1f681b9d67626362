//! The chapters of a run under ramps (theory 14): spans of time in each of which one scene holds. State and forcing angles are continuous
//! from chapter to chapter.

use crate::error::{Error, Result};
use crate::hybrid::clock::Clock;
use crate::model::{
    Drift, Parameter, Ramp, RampProfile, RampRange, Scene, SteadyRamp, StopNumber, drifting,
};
use crate::root::{Bracket, bisected};
use crate::tolerance::DWELL_ROUNDING;
use std::convert::Infallible;
use std::f64::consts::TAU;

/// The most chapters of a run. [work]
const MOST_CHAPTERS: usize = 1 << 20;

/// A span of time in which one scene holds.
#[derive(Debug, Clone)]
pub(crate) struct Chapter {
    pub scene: Scene,
    pub span: (f64, f64),
    /// The scene whose angles count, and what drifts of it.
    steady: Scene,
    drift: Drift,
}

/// A time, and the value that a number has from then on.
type Since = (f64, f64);

/// The value of a number as a function of time along a run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ParameterHistory {
    /// In levels, each from a time on.
    Levels(Vec<Since>),
    Steady(SteadyRamp),
}

impl ParameterHistory {
    /// The value at a time.
    pub fn at(&self, t: f64) -> f64 {
        match self {
            Self::Steady(moving) => moving.value(t),
            Self::Levels(levels) => {
                let later = levels.partition_point(|(since, _)| *since <= t);
                levels[later.max(1) - 1].1
            }
        }
    }
}

/// The chapters of a run, and each number that a ramp changes as a function of time.
#[derive(Debug, Clone)]
pub(crate) struct Schedule {
    pub chapters: Vec<Chapter>,
    pub histories: Vec<(Parameter, ParameterHistory)>,
}

impl Chapter {
    /// Whether what turned has become signals, or nothing.
    pub fn has_lost_its_angle(&self) -> bool {
        self.scene.frequency().is_none()
    }

    /// The angle of the fundamental frequency at a time, NaN where there is no period.
    pub fn angle(&self, t: f64) -> f64 {
        match self.steady.frequency() {
            Some(lowest) => {
                let own = (lowest, self.steady.phase());
                self.drift.angle(own, lowest, t).angle
            }
            None => self.steady.phase(),
        }
    }
}

/// A ramp in levels, as far as it has come.
struct SteppedRamp {
    parameter: Parameter,
    range: RampRange,
    count: usize,
    dwell: f64,
    /// The level that holds, and what is left of its dwell, in turns.
    level: usize,
    left: f64,
    history: Vec<Since>,
}

impl SteppedRamp {
    fn is_done(&self) -> bool {
        self.level + 1 >= self.count
    }
}

/// Makes the chapters of a run one after another: the numbers at the start of the next chapter.
struct ScheduleBuilder {
    /// The scene with its angles, and what has been reached of everything else but factors.
    steady: Scene,
    levels: Vec<SteppedRamp>,
    steady_ramps: Vec<(Parameter, SteadyRamp)>,
    /// Factors on forcing and damping where they do not drift.
    factors: [f64; 2],
    now: f64,
}

impl Schedule {
    /// The chapters of a run over a span; one, the scene as it is, where nothing changes.
    ///
    /// # Errors
    /// Two ramps of one number, values that it may not take, a dwell without a period, a phase in levels; a scene that cannot drift so;
    /// `Error::Interrupted` where the answer to whether to go on is to break off.
    pub fn new(scene: &Scene, ramps: &[Ramp], span: (f64, f64)) -> Result<Self> {
        let mut builder = ScheduleBuilder {
            steady: scene.clone(),
            levels: Vec::new(),
            steady_ramps: Vec::new(),
            factors: [1.0; 2],
            now: span.0,
        };
        for (i, ramp) in ramps.iter().enumerate() {
            let parameter = ramp.parameter();
            let mut before = ramps[..i].iter();
            if before.any(|other| other.parameter().overlaps(parameter)) {
                let rule = "each number may have one ramp";
                return Err(Error::bad_value(
                    "ramp",
                    format!("twice of \"{parameter}\""),
                    rule,
                ));
            }
        }
        for ramp in ramps {
            builder.add(scene, *ramp)?;
        }
        let mut chapters = Vec::new();
        loop {
            let end = builder.next_change().min(span.1);
            chapters.push(builder.chapter(end)?);
            if end >= span.1 {
                break;
            }
            if chapters.len() == MOST_CHAPTERS {
                let rule = format!("a run has at most {MOST_CHAPTERS} levels");
                return Err(Error::bad_value("levels", chapters.len(), rule));
            }
            builder.go_on(end)?;
        }
        Ok(Self {
            chapters,
            histories: builder.histories(),
        })
    }
}

impl ScheduleBuilder {
    /// Begins a ramp.
    fn add(&mut self, scene: &Scene, ramp: Ramp) -> Result<()> {
        let parameter = ramp.parameter();
        drop(scene.replace(parameter.change(ramp.to()))?);
        let from = scene.value_of(parameter, &format!("the ramp of \"{parameter}\""))?;
        if from.is_nan() {
            let rule = "the scene has no value of it";
            return Err(Error::bad_value(
                "ramp",
                format!("of \"{parameter}\""),
                rule,
            ));
        }
        let is_drift = !matches!(ramp.profile(), RampProfile::Steps { .. });
        if is_drift
            && parameter
                .stop_number()
                .is_some_and(StopNumber::is_of_compliance)
        {
            let rule = "while a stop is pressed its numbers drift in levels alone: give levels= and dwell=";
            return Err(Error::bad_value(
                "ramp",
                format!("of \"{parameter}\""),
                rule,
            ));
        }
        let range = ramp.range(from)?;
        let moving = match ramp.profile() {
            RampProfile::Over(time) => range.over(self.now, time),
            RampProfile::Rate(rate) => range.at_rate(self.now, rate),
            RampProfile::Steps { levels, dwell } => {
                if parameter == Parameter::Phase {
                    let rule = "a phase that jumps is another run: give over= or rate=";
                    return Err(Error::bad_value("levels", levels, rule));
                }
                scene.check_period("dwell, a number of forcing periods,")?;
                if scene.frequency().is_none() {
                    let rule = "it counts forcing periods, and the scene has no forcing: give over= or rate=";
                    return Err(Error::bad_value("dwell", dwell, rule));
                }
                self.levels.push(SteppedRamp {
                    parameter,
                    range,
                    count: if from == ramp.to() { 1 } else { levels },
                    dwell,
                    level: 0,
                    left: dwell,
                    history: vec![(self.now, from)],
                });
                return Ok(());
            }
        };
        self.steady_ramps.push((parameter, moving));
        Ok(())
    }

    /// The ramp of a number that drifts now.
    fn drifting(&self, parameter: Parameter) -> Option<SteadyRamp> {
        let own = self
            .steady_ramps
            .iter()
            .find(|(other, _)| *other == parameter);
        own.map(|(_, moving)| *moving)
            .filter(|moving| self.now < moving.end())
    }

    /// The drifts of a number of the stops.
    fn drifting_stops(&self, number: StopNumber) -> Vec<Option<SteadyRamp>> {
        let all = self.drifting(Parameter::EveryStop(number));
        let of = |i: usize| self.drifting(Parameter::OneStop(number, i)).or(all);
        (0..self.steady.stops().len()).map(of).collect()
    }

    fn drift(&self) -> Drift {
        Drift {
            frequency: self.drifting(Parameter::Frequency),
            phase: self.drifting(Parameter::Phase).zip(self.first_times()),
            scale: self.drifting(Parameter::ForcingScale),
            clearances: self.drifting_stops(StopNumber::Clearance),
        }
    }

    /// How many times the lowest frequency that is of which the phase is named.
    fn first_times(&self) -> Option<f64> {
        let (first, lowest) = (
            self.steady.first_angle()?.0,
            self.steady.lowest_frequency()?,
        );
        Some(Drift::times(first, lowest))
    }

    /// When a number changes otherwise than now, infinite where none does.
    fn next_change(&self) -> f64 {
        let ends = self.steady_ramps.iter().map(|(_, moving)| moving.end());
        let ends = ends
            .filter(|end| *end > self.now)
            .fold(f64::INFINITY, f64::min);
        let left = self
            .levels
            .iter()
            .filter(|steps| !steps.is_done())
            .map(|steps| steps.left);
        let Some(turns) = left.reduce(f64::min) else {
            return ends;
        };
        ends.min(self.after_turns(turns, ends))
    }

    /// The time at which the forcing has made a number of turns from now on; no later than `latest`.
    fn after_turns(&self, turns: f64, latest: f64) -> f64 {
        let angle = turns * TAU;
        if self.drifting(Parameter::Frequency).is_none() {
            return self.now + angle / self.steady.frequency().unwrap_or(f64::NAN);
        }
        if self.turned(latest) <= angle {
            return latest;
        }
        // The frequency stays positive: the angle grows.
        let between = Bracket::new([self.now, latest]);
        let Ok(found) = bisected(between, 0.0, |time| {
            Ok::<_, Infallible>(self.turned(time) < angle)
        });
        found.after
    }

    /// By which angle the forcing turns from now to a time.
    fn turned(&self, then: f64) -> f64 {
        match self.drifting(Parameter::Frequency) {
            Some(moving) => moving.integral(then).0 - moving.integral(self.now).0,
            None => self.steady.frequency().unwrap_or(0.0) * (then - self.now),
        }
    }

    /// The chapter from now to a time.
    fn chapter(&self, end: f64) -> Result<Chapter> {
        let (drift, span) = (self.drift(), (self.now, end));
        let mut scene = self.steady.clone();
        let [force, damping] = self.factors;
        if force != 1.0 {
            scene = scene.replace(Parameter::ForcingScale.change(force))?;
        }
        if damping != 1.0 {
            scene = scene.replace(Parameter::DampingScale.change(damping))?;
        }
        let scene = drifting(&scene, &drift, span)?;
        let restitutions = self.drifting_stops(StopNumber::Restitution);
        let damping = self.drifting(Parameter::DampingScale);
        Ok(Chapter {
            scene: scene.with_laws(restitutions, damping),
            span,
            steady: self.steady.clone(),
            drift,
        })
    }

    /// Goes on to a time at which a number begins to change otherwise.
    fn go_on(&mut self, then: f64) -> Result<()> {
        let turns = self.turned(then) / TAU;
        let ended = self.steady_ramps.iter().copied();
        let ended: Vec<_> = ended
            .filter(|(_, m)| self.now < m.end() && m.end() <= then)
            .collect();
        // Angles go on from where they are.
        let drift = self.drift();
        let ends = |parameter| ended.iter().any(|(other, _)| *other == parameter);
        let gone = Drift {
            frequency: drift.frequency.filter(|_| ends(Parameter::Frequency)),
            phase: drift.phase.filter(|_| ends(Parameter::Phase)),
            ..Drift::default()
        };
        if gone.turns_into_signals() {
            self.turn(&gone, gone.frequency.map(SteadyRamp::last), then)?;
        }
        for (parameter, moving) in ended {
            self.set(parameter, moving.last())?;
        }
        let mut changed = Vec::new();
        for steps in self.levels.iter_mut().filter(|steps| !steps.is_done()) {
            steps.left -= turns;
            if steps.left <= DWELL_ROUNDING * steps.dwell {
                (steps.level, steps.left) = (steps.level + 1, steps.dwell);
                let value = steps.range.level(steps.level, steps.count);
                steps.history.push((then, value));
                changed.push((steps.parameter, value));
            }
        }
        for (parameter, value) in changed {
            if parameter == Parameter::Frequency {
                self.turn(&Drift::default(), Some(value), then)?;
            } else {
                self.set(parameter, value)?;
            }
        }
        self.now = then;
        Ok(())
    }

    /// Puts what has drifted of the angles into the phases, at a time, and the frequency at another value.
    fn turn(&mut self, gone: &Drift, frequency: Option<f64>, then: f64) -> Result<()> {
        let lowest = self.steady.lowest_frequency().unwrap_or(f64::NAN);
        self.steady = self.steady.with_angles(|(w, phase)| {
            let swept = gone.angle((w, phase), lowest, then);
            let sped = frequency.map_or(w, |to| Drift::times(w, lowest) * to);
            (sped, swept.angle - Clock::new(then, sped).angle())
        })?;
        Ok(())
    }

    /// Gives a number that is no angle a value.
    fn set(&mut self, parameter: Parameter, value: f64) -> Result<()> {
        match parameter {
            Parameter::Frequency | Parameter::Phase => {}
            Parameter::ForcingScale => self.factors[0] = value,
            Parameter::DampingScale => self.factors[1] = value,
            other => self.steady = self.steady.replace(other.change(value))?,
        }
        Ok(())
    }

    /// Each number that a ramp changes as a function of time.
    fn histories(self) -> Vec<(Parameter, ParameterHistory)> {
        let steps = self.levels.into_iter();
        let steps = steps.map(|steps| (steps.parameter, ParameterHistory::Levels(steps.history)));
        let steady = self.steady_ramps.into_iter();
        let steady =
            steady.map(|(parameter, moving)| (parameter, ParameterHistory::Steady(moving)));
        steps.chain(steady).collect()
    }
}
