//! Changed copies of a scene, and the values that its numbers have: the two sides of a [`Parameter`].

use crate::error::{Error, Result};
use crate::model::constraint::Constraint;
use crate::model::derived::Derived;
use crate::model::forcing::Forcing;
use crate::model::linear::LinearSystem;
use crate::model::parameter::{Parameter, StopNumber};
use crate::model::scene::Scene;
use crate::model::system::System;

/// One change of a scene, as made by [`crate::Scene::replace`].
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Change {
    /// Another system.
    System(System),
    /// Another forcing.
    Forcing(Forcing),
    /// Other stops.
    Stops(Vec<Constraint>),
    /// Another value of a number. The phase is that of the first of several forcings; all are as much earlier.
    Number(Parameter, f64),
    /// A number of stops: one value for every stop, or one each.
    EachStop(StopNumber, Vec<f64>),
    /// The phase of the fundamental frequency \[rad\], which is that of the first forcing which has it.
    FundamentalPhase(f64),
}

impl Parameter {
    /// The change that gives the parameter a value.
    pub fn change(self, value: f64) -> Change {
        Change::Number(self, value)
    }
}

impl Scene {
    /// A changed copy of the scene.
    ///
    /// # Errors
    /// A value that breaks its rule, or a result that does not fit together.
    pub fn replace(&self, change: Change) -> Result<Self> {
        let mut copy = self.to_be_changed();
        let is_of_motion_alone = matches!(
            change,
            Change::Number(
                Parameter::Frequency | Parameter::Phase | Parameter::ForcingScale,
                _
            ) | Change::FundamentalPhase(_)
        );
        if !is_of_motion_alone {
            copy.contacts = Derived::default();
        }
        match change {
            Change::System(system) => return Self::new(system, copy.forcing, copy.stops),
            Change::Forcing(forcing) => return Self::new(copy.system, forcing, copy.stops),
            Change::Stops(stops) => return Self::new(copy.system, copy.forcing, stops),
            Change::FundamentalPhase(phase) => {
                copy.with_all_forcing(|all| all.with_fundamental_phase(phase))?;
            }
            Change::EachStop(number, values) => copy.set_each(number, &values)?,
            Change::Number(parameter, value) => copy.set(parameter, value)?,
        }
        Ok(copy)
    }

    fn set(&mut self, parameter: Parameter, value: f64) -> Result<()> {
        match parameter {
            Parameter::Frequency => self.with_all_forcing(|all| all.with_frequency(value))?,
            Parameter::Phase => self.with_all_forcing(|all| all.with_phase(value))?,
            Parameter::ForcingScale => self.forcing = self.forcing.scaled(value)?,
            Parameter::DampingScale => self.system = scale_damping(&self.system, value)?,
            Parameter::EveryStop(number) => self.set_each(number, &[value])?,
            Parameter::OneStop(number, index) => {
                let count = self.stops.len();
                let stop = self.stops.get_mut(index).ok_or_else(|| {
                    let rule = format!("the scene has {count} stops");
                    Error::bad_value(format!("{}[{index}]", number.name()), "not there", rule)
                })?;
                number.set(stop, value)?;
            }
        }
        Ok(())
    }

    fn set_each(&mut self, number: StopNumber, values: &[f64]) -> Result<()> {
        let count = self.stops.len();
        if count == 0 {
            let rule = "the scene has no stops to change; give it some with `stops`";
            return Err(Error::bad_value(number.name(), format!("{values:?}"), rule));
        }
        if values.len() != 1 && values.len() != count {
            return Err(Error::bad_shape(
                number.name(),
                format!("({},)", values.len()),
                format!("one number, or ({count},): one for each stop"),
            ));
        }
        // One value for all is one for those that have the number, if any has.
        let is_for_some = values.len() == 1 && self.stops.iter().any(|stop| number.is_of(stop));
        let all = self.stops.iter_mut().zip(values.iter().cycle());
        let mut meant = all.filter(|(stop, _)| !is_for_some || number.is_of(stop));
        meant.try_for_each(|(stop, &value)| number.set(stop, value))
    }

    /// The value of a number: of factors one, not a number where the scene has none.
    ///
    /// # Errors
    /// A number that its stops do not share; `argument` is what asks for it.
    pub(crate) fn value_of(&self, parameter: Parameter, argument: &str) -> Result<f64> {
        Ok(match parameter {
            Parameter::Frequency => self.lowest_frequency().unwrap_or(f64::NAN),
            Parameter::Phase => self.first_angle().map_or(f64::NAN, |(_, phase)| phase),
            Parameter::ForcingScale | Parameter::DampingScale => 1.0,
            Parameter::EveryStop(number) => {
                let meant = self.stops.iter().filter(|stop| number.is_of(stop));
                let values: Vec<f64> = meant.map(|stop| number.of(stop)).collect();
                if values.windows(2).any(|pair| pair[0] != pair[1]) {
                    let rule =
                        format!("the stops differ, {values:?}: name one, \"{parameter}[0]\"");
                    return Err(Error::bad_value(argument, "for every stop", rule));
                }
                values.first().copied().unwrap_or(f64::NAN)
            }
            Parameter::OneStop(number, i) => {
                self.stops.get(i).map_or(f64::NAN, |stop| number.of(stop))
            }
        })
    }

    /// The value of a number that changes the motion.
    ///
    /// # Errors
    /// The phase, which shifts time alone; a number that the scene does not have, or that its stops do not share.
    pub(crate) fn start_of(&self, parameter: Parameter, argument: &str) -> Result<f64> {
        let refused = |rule: &str| Error::bad_value(argument, format!("\"{parameter}\""), rule);
        if parameter == Parameter::Phase {
            let rule = "it must be a number that changes the motion: the phase shifts time alone";
            return Err(refused(rule));
        }
        let value = self.value_of(parameter, argument)?;
        if value.is_finite() {
            Ok(value)
        } else {
            Err(refused(
                "it must be a number that the scene of the orbit has",
            ))
        }
    }

    /// The scene in which a number has a value, if it may have that.
    pub(crate) fn with_value(&self, parameter: Parameter, value: f64) -> Result<Self> {
        parameter.check(value)?;
        self.replace(parameter.change(value))
    }
}

/// A system with its damping matrix scaled.
fn scale_damping(system: &System, factor: f64) -> Result<System> {
    Ok(match system {
        System::Linear(s) => LinearSystem::clone(s).with_damping_scaled(factor)?.into(),
        System::DoublePendulum(s) => s.with_damping_scaled(factor)?.into(),
        System::PendulumChain(s) => s.with_damping_scaled(factor)?.into(),
        System::Nonlinear(_) => {
            return Err(Error::bad_value(
                "damping_scale",
                factor,
                "a nonlinear system has no damping matrix to scale; replace the system",
            ));
        }
    })
}
