//! Changes of a scene, and its numbers by name ([`Parameter`]): all that a map, a search or a sweep can vary.

use crate::error::{Error, Result};
use crate::model::constraint::Constraint;
use crate::model::forcing::Forcing;
use crate::model::linear::LinearSystem;
use crate::model::system::System;
use crate::quantity::{Restitution, finite, positive};

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
    /// The forcing frequency.
    Frequency(f64),
    /// The forcing phase \[rad\]: that of the first of several forcings; all are as much earlier.
    Phase(f64),
    /// The phase of the fundamental frequency \[rad\], which is that of the first forcing which has it.
    FundamentalPhase(f64),
    /// The clearances: one number for every stop, or one each.
    Clearance(Vec<f64>),
    /// The clearance of one stop.
    ClearanceOf(usize, f64),
    /// The restitution coefficients: one number for every stop, or one each.
    Restitution(Vec<f64>),
    /// The restitution coefficient of one stop.
    RestitutionOf(usize, f64),
    /// A factor on the forcing amplitude.
    ForcingScale(f64),
    /// A factor on the damping matrix.
    DampingScale(f64),
}

/// A number of a scene that sweeps and searches may vary, by the name it has in `Scene::replace`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// The forcing frequency.
    Frequency,
    /// The forcing phase.
    Phase,
    /// The clearance of every stop.
    Clearance,
    /// The clearance of one stop.
    ClearanceOf(usize),
    /// The restitution of every stop.
    Restitution,
    /// The restitution of one stop.
    RestitutionOf(usize),
    /// A factor on the forcing amplitude.
    ForcingScale,
    /// A factor on the damping matrix.
    DampingScale,
}

impl Parameter {
    /// The change that gives the parameter a value.
    pub fn change(self, value: f64) -> Change {
        match self {
            Self::Frequency => Change::Frequency(value),
            Self::Phase => Change::Phase(value),
            Self::Clearance => Change::Clearance(vec![value]),
            Self::ClearanceOf(i) => Change::ClearanceOf(i, value),
            Self::Restitution => Change::Restitution(vec![value]),
            Self::RestitutionOf(i) => Change::RestitutionOf(i, value),
            Self::ForcingScale => Change::ForcingScale(value),
            Self::DampingScale => Change::DampingScale(value),
        }
    }
}

impl Parameter {
    /// Whether it counts from the scene: one is the scene as it is.
    pub(crate) fn is_factor(self) -> bool {
        matches!(self, Self::ForcingScale | Self::DampingScale)
    }

    /// Whether a value is one that the parameter may take, in any scene.
    ///
    /// # Errors
    /// `Error::BadValue`, as [`crate::Scene::replace`] would give it.
    pub(crate) fn check(self, value: f64) -> Result<()> {
        match self {
            Self::Frequency => positive("frequency", value).map(drop),
            Self::Restitution | Self::RestitutionOf(_) => Restitution::new(value).map(drop),
            Self::Phase => finite("phase", value).map(drop),
            Self::Clearance | Self::ClearanceOf(_) => finite("clearance", value).map(drop),
            Self::ForcingScale => finite("forcing_scale", value).map(drop),
            Self::DampingScale => finite("damping_scale", value).map(drop),
        }
    }
}

impl std::fmt::Display for Parameter {
    /// The name that [`Parameter`] is parsed from.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Frequency => f.write_str("frequency"),
            Self::Phase => f.write_str("phase"),
            Self::Clearance => f.write_str("clearance"),
            Self::ClearanceOf(i) => write!(f, "clearance[{i}]"),
            Self::Restitution => f.write_str("restitution"),
            Self::RestitutionOf(i) => write!(f, "restitution[{i}]"),
            Self::ForcingScale => f.write_str("forcing_scale"),
            Self::DampingScale => f.write_str("damping_scale"),
        }
    }
}

impl std::str::FromStr for Parameter {
    type Err = Error;

    /// `"frequency"`, `"clearance"`, `"clearance[1]"` and so on.
    fn from_str(name: &str) -> Result<Self> {
        let unknown = || {
            Error::bad_value(
                "the parameter",
                format!("{name:?}"),
                "it must be one of frequency, phase, forcing_scale, damping_scale, clearance, restitution, or \
                 clearance[i], restitution[i] for one stop",
            )
        };
        if let Some((head, index)) = name.strip_suffix(']').and_then(|s| s.split_once('[')) {
            let index: usize = index.trim().parse().map_err(|_| unknown())?;
            return match head {
                "clearance" => Ok(Self::ClearanceOf(index)),
                "restitution" => Ok(Self::RestitutionOf(index)),
                _ => Err(unknown()),
            };
        }
        match name {
            "frequency" => Ok(Self::Frequency),
            "phase" => Ok(Self::Phase),
            "clearance" => Ok(Self::Clearance),
            "restitution" => Ok(Self::Restitution),
            "forcing_scale" => Ok(Self::ForcingScale),
            "damping_scale" => Ok(Self::DampingScale),
            _ => Err(unknown()),
        }
    }
}

/// Sets the clearance of a stop that has one.
pub(super) fn set_clearance(constraint: &mut Constraint, value: f64) -> Result<()> {
    match constraint {
        Constraint::Stop(stop) => stop.set_clearance(value),
        Constraint::Wall(_) => Err(Error::bad_value(
            "clearance",
            value,
            "a wall has a position instead; replace the stops",
        )),
        Constraint::Nonlinear(_) => Err(Error::bad_value(
            "clearance",
            value,
            "a nonlinear stop has a gap function instead; replace the stops",
        )),
    }
}

/// Sets the restitution of a stop of any kind.
pub(super) fn set_restitution(constraint: &mut Constraint, value: f64) -> Result<()> {
    match constraint {
        Constraint::Stop(stop) => stop.set_restitution(value),
        Constraint::Wall(wall) => wall.set_restitution(value),
        Constraint::Nonlinear(stop) => stop.set_restitution(value),
    }
}

/// A system with its damping matrix scaled.
pub(super) fn scale_damping(system: &System, factor: f64) -> Result<System> {
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
