//! A number of a scene that drifts during a run (theory 14): from its value at the start to another, steadily or in levels.

use crate::error::{Error, Result};
use crate::model::parameter::Parameter;
use crate::model::twice::{Twice, mean_exponential};
use crate::quantity::{finite, positive};

/// The most levels of a ramp, each of which is a scene. [work]
const MOST_RAMP_LEVELS: usize = 100_000;

/// How a ramp goes from its first value to its last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RampLaw {
    /// Equal changes in equal times.
    #[default]
    Linear,
    /// Equal factors in equal times; values of one sign.
    Log,
}

/// How fast a ramp changes its number, as a function of time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RampProfile {
    /// Steadily, in this much time \[s\].
    Over(f64),
    /// Steadily, at this rate: the change of the value, or of its logarithm, in a unit of time. Its sign does not matter.
    Rate(f64),
    /// By equal steps over a number of levels, the first and the last value among them.
    Steps {
        /// How many.
        levels: usize,
        /// Forcing periods at each.
        dwell: f64,
    },
}

/// Number of a scene that drifts along a run: from its value at the start of the run to another, where it stays.
///
/// # Examples
/// ```
/// use nalgebra::dvector;
/// use vibroimpact::{Harmonic, LinearSystem, Parameter, Ramp, RampProfile, Scene, SimulateOptions, Stop, simulate};
/// let system = LinearSystem::new(dvector![1.0], dvector![0.1], dvector![1.0])?;
/// let force = Harmonic::new(dvector![0.5.into()], 0.5, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
/// let up = Ramp::new(Parameter::Frequency, 2.0, RampProfile::Rate(0.01))?;
/// let options = SimulateOptions { ramps: vec![up], ..Default::default() };
/// let rest = dvector![0.0];
/// let run = simulate(&scene, &rest, &rest, (0.0, 200.0), &options)?;
/// assert!((run.parameter(100.0, None)? - 1.5).abs() < 1e-12);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ramp {
    parameter: Parameter,
    to: f64,
    profile: RampProfile,
    law: RampLaw,
}

impl Ramp {
    /// A ramp of a number to a value, by the law `Linear`.
    ///
    /// # Errors
    /// A value that the number may not take, a time, rate or dwell that is not positive and finite, fewer than two levels, or more than 100 000.
    pub fn new(parameter: Parameter, to: f64, profile: RampProfile) -> Result<Self> {
        parameter.check(to)?;
        match profile {
            RampProfile::Over(time) => drop(positive("over", time)?),
            RampProfile::Rate(rate) => {
                if finite("rate", rate)? == 0.0 {
                    let rule = "it must not be zero: the value would never be reached";
                    return Err(Error::bad_value("rate", rate, rule));
                }
            }
            RampProfile::Steps { levels, dwell } => {
                positive("dwell", dwell)?;
                if !(2..=MOST_RAMP_LEVELS).contains(&levels) {
                    let rule = format!(
                        "it must be from 2 to {MOST_RAMP_LEVELS}: the first and the last value are among them"
                    );
                    return Err(Error::bad_value("levels", levels, rule));
                }
            }
        }
        Ok(Self {
            parameter,
            to,
            profile,
            law: RampLaw::Linear,
        })
    }

    /// The same by another law.
    #[must_use]
    pub fn with_law(self, law: RampLaw) -> Self {
        Self { law, ..self }
    }

    /// The number that drifts.
    pub fn parameter(&self) -> Parameter {
        self.parameter
    }

    /// Its last value.
    pub fn to(&self) -> f64 {
        self.to
    }

    /// How fast the number changes.
    pub fn profile(&self) -> RampProfile {
        self.profile
    }

    /// The law between the first value and the last.
    pub fn law(&self) -> RampLaw {
        self.law
    }

    /// The range from a first value to the last one of the ramp.
    ///
    /// # Errors
    /// Values of which the law `Log` has no logarithm.
    pub(crate) fn range(&self, from: f64) -> Result<RampRange> {
        let to = self.to;
        let has_logarithm = from * to > 0.0;
        if self.law == RampLaw::Log && !has_logarithm {
            let rule = format!(
                "with law=\"log\" it must have the sign of the value at the start, {from}, and neither may be zero"
            );
            let argument = format!("to of the ramp of \"{}\"", self.parameter);
            return Err(Error::bad_value(argument, to, rule));
        }
        Ok(RampRange {
            from,
            to,
            law: self.law,
        })
    }
}

/// The first and the last value of a ramp, with the law between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RampRange {
    pub from: f64,
    pub to: f64,
    law: RampLaw,
}

impl RampRange {
    /// The value of level `k`, the first being 0, of `levels` in all.
    pub fn level(self, k: usize, levels: usize) -> f64 {
        if k == 0 {
            return self.from;
        }
        if k + 1 >= levels {
            return self.to;
        }
        let part = k as f64 / (levels - 1) as f64;
        match self.law {
            RampLaw::Linear => self.from + part * self.change(),
            RampLaw::Log => self.from * (part * self.change()).exp(),
        }
    }

    /// The change from end to end, of the value or of its logarithm.
    fn change(self) -> f64 {
        match self.law {
            RampLaw::Linear => self.to - self.from,
            RampLaw::Log => (self.to / self.from).ln(),
        }
    }

    /// The ramp that begins at `start` and takes the given time.
    pub fn over(self, start: f64, time: f64) -> SteadyRamp {
        SteadyRamp {
            range: self,
            start,
            rate: self.change() / time,
        }
    }

    /// The ramp that begins at `start` and changes at a rate, towards the last value whatever the sign of the rate.
    pub fn at_rate(self, start: f64, rate: f64) -> SteadyRamp {
        SteadyRamp {
            range: self,
            start,
            rate: rate.copysign(self.change()),
        }
    }
}

/// A number that changes steadily: `from + rate s`, or `from e^(rate s)`, at a time s after the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SteadyRamp {
    range: RampRange,
    pub start: f64,
    rate: f64,
}

impl SteadyRamp {
    /// When it has reached its last value; the start where it is there already.
    pub fn end(self) -> f64 {
        if self.range.from == self.range.to {
            return self.start;
        }
        self.start + self.range.change() / self.rate
    }

    /// Its last value.
    pub fn last(self) -> f64 {
        self.range.to
    }

    /// Value, slope and second derivative at a time, as it goes on beyond its end.
    pub fn at(self, t: f64) -> [f64; 3] {
        let (from, rate, s) = (self.range.from, self.rate, t - self.start);
        match self.range.law {
            RampLaw::Linear => [from + rate * s, rate, 0.0],
            RampLaw::Log => {
                let value = from * (rate * s).exp();
                [value, rate * value, rate * rate * value]
            }
        }
    }

    /// By how much it has changed at a time since its start, as it goes on beyond its end.
    pub fn changed(self, t: f64) -> f64 {
        let (from, x) = (self.range.from, self.rate * (t - self.start));
        match self.range.law {
            RampLaw::Linear => x,
            RampLaw::Log => from * x.exp_m1(),
        }
    }

    /// Its value at a time, before its start and after its end that of there.
    pub fn value(self, t: f64) -> f64 {
        if t <= self.start {
            self.range.from
        } else if t >= self.end() {
            self.range.to
        } else {
            self.at(t)[0]
        }
    }

    /// Its integral from the start to a time, in twice the precision.
    pub fn integral(self, t: f64) -> Twice {
        let s = Twice::of(t).plus(Twice::of(-self.start));
        let from = Twice::of(self.range.from);
        let x = s.times(Twice::of(self.rate));
        match self.range.law {
            // from s + rate s^2/2
            RampLaw::Linear => s.times(from.plus(x.times(Twice::of(0.5)))),
            // from s (e^x - 1)/x
            RampLaw::Log => s.times(from).times(mean_exponential(x)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(to: f64, profile: RampProfile, law: RampLaw) -> Ramp {
        Ramp::new(Parameter::Frequency, to, profile)
            .expect("valid")
            .with_law(law)
    }

    #[test]
    fn levels_are_equally_far_apart_and_end_at_the_ends() {
        let profile = RampProfile::Over(1.0);
        let values = |law| {
            let range = ramp(8.0, profile, law).range(1.0).expect("a range");
            (0..4).map(|k| range.level(k, 4)).collect::<Vec<_>>()
        };
        let linear = values(RampLaw::Linear);
        assert_eq!((linear[0], linear[3]), (1.0, 8.0));
        assert!((linear[1] - 10.0 / 3.0).abs() < 1e-15);
        let log = values(RampLaw::Log);
        assert!((log[1] - 2.0).abs() < 1e-15 && (log[2] - 4.0).abs() < 2e-15);
    }

    #[test]
    fn a_number_moves_by_its_law_and_stays() {
        for law in [RampLaw::Linear, RampLaw::Log] {
            let range = ramp(0.5, RampProfile::Over(4.0), law)
                .range(2.0)
                .expect("a range");
            let moving = range.over(10.0, 4.0);
            assert_eq!(moving.end(), 14.0);
            assert_eq!((moving.value(9.0), moving.value(15.0)), (2.0, 0.5));
            let same = range.at_rate(10.0, moving.rate.abs());
            assert_eq!(same, moving);
            let h = 1e-4;
            let [before, now, after] = [12.0 - h, 12.0, 12.0 + h].map(|t| moving.at(t));
            assert!(((after[0] - before[0]) / (2.0 * h) - now[1]).abs() < 1e-8);
            assert!(((after[1] - before[1]) / (2.0 * h) - now[2]).abs() < 1e-8);
            let area = moving.integral(12.0 + h).0 - moving.integral(12.0 - h).0;
            assert!((area / (2.0 * h) - now[0]).abs() < 1e-8);
        }
    }

    /// `3 s + 0.007 s^2/2` and `5 (e^(r s) - 1)/r` at s = 1234.5, of the doubles themselves, to 34 digits.
    #[test]
    fn angles_keep_their_digits_after_thousands_of_turns() {
        let moving = |from, to, law, rate| RampRange { from, to, law }.at_rate(0.0, rate);
        for (moving, (high, low)) in [
            (
                moving(3.0, 1e3, RampLaw::Linear, 0.007),
                (9_037.465_875, 2.420_027_069_363_617e-13),
            ),
            (
                moving(5.0, 1e3, RampLaw::Log, 0.001),
                (12_183.298_805_852_317, -8.419_517_782_323_304e-13),
            ),
            (
                moving(5.0, 1e-3, RampLaw::Log, 0.01),
                (499.997_824_271_877_7, -1.359_987_509_019_447_5e-14),
            ),
        ] {
            let found = moving.integral(1234.5);
            let miss: f64 = (found.0 - high) + (found.1 - low);
            assert!(miss.abs() < 1e-30 * high, "{moving:?}: {miss:e}");
        }
    }

    #[test]
    fn what_is_no_ramp_is_refused_by_name() {
        let message = |to, profile| {
            let ramp = Ramp::new(Parameter::Frequency, to, profile);
            ramp.expect_err("refused").to_string()
        };
        let over = RampProfile::Over(1.0);
        assert!(message(-1.0, over).starts_with("frequency is -1"));
        assert!(message(1.0, RampProfile::Over(0.0)).starts_with("over is 0"));
        assert!(message(1.0, RampProfile::Rate(0.0)).starts_with("rate is 0"));
        let steps = |levels, dwell| message(1.0, RampProfile::Steps { levels, dwell });
        assert!(steps(1, 1.0).starts_with("levels is 1"));
        assert!(steps(3, f64::NAN).starts_with("dwell is NaN"));
        let log = ramp(1.0, over, RampLaw::Log).range(-1.0);
        let message = log.expect_err("refused").to_string();
        assert!(message.contains("it must have the sign"), "{message}");
    }
}
