//! The motions of which a section can be taken: a trajectory, or one period of an orbit.

use crate::error::Result;
use crate::hybrid::clock::Clock;
use crate::impact::{Impact, wrapped};
use crate::model::{PhysicalState, Scene};
use crate::orbit::PeriodicOrbit;
use crate::path::{ImpactSide, Path, Stretch};
use crate::simulate::Trajectory;

/// A motion of which a section is taken.
#[derive(Debug, Clone, Copy)]
pub enum Motion<'a> {
    /// A trajectory that keeps its motion.
    Trajectory(&'a Trajectory),
    /// One period of an orbit.
    Orbit(&'a PeriodicOrbit),
}

impl<'a> From<&'a Trajectory> for Motion<'a> {
    fn from(trajectory: &'a Trajectory) -> Self {
        Self::Trajectory(trajectory)
    }
}

impl<'a> From<&'a PeriodicOrbit> for Motion<'a> {
    fn from(orbit: &'a PeriodicOrbit) -> Self {
        Self::Orbit(orbit)
    }
}

/// What a section asks of a motion.
pub(crate) trait Sectioned {
    fn scene(&self) -> &Scene;
    /// Start and end.
    fn span(&self) -> (f64, f64);
    fn impacts(&self) -> &[Impact];
    /// Its parts, with the stops in contact.
    fn stretches(&self) -> Result<Vec<Stretch<'_>>>;
    /// The motion in paths that follow each other.
    fn paths(&self) -> Result<Vec<&Path>>;
    /// Position and velocity at a time.
    fn state(&self, t: f64, side: ImpactSide) -> Result<PhysicalState>;
    /// The phase of the forcing [rad] as a function of time.
    fn phase(&self) -> Box<dyn Fn(f64) -> f64 + '_>;
    /// Whether that phase grows at a constant rate.
    fn has_steady_phase(&self) -> bool;
    /// Whether the motion is closed: its end is its start.
    fn is_closed(&self) -> bool;
}

impl Sectioned for Motion<'_> {
    fn scene(&self) -> &Scene {
        match self {
            Self::Trajectory(trajectory) => trajectory.scene(),
            Self::Orbit(orbit) => orbit.scene(),
        }
    }

    fn span(&self) -> (f64, f64) {
        match self {
            Self::Trajectory(trajectory) => trajectory.span(),
            Self::Orbit(orbit) => (0.0, orbit.period()),
        }
    }

    fn impacts(&self) -> &[Impact] {
        match self {
            Self::Trajectory(trajectory) => trajectory.impacts(),
            Self::Orbit(orbit) => orbit.impacts(),
        }
    }

    fn stretches(&self) -> Result<Vec<Stretch<'_>>> {
        match self {
            Self::Trajectory(trajectory) => trajectory.stretches(),
            Self::Orbit(orbit) => Ok(orbit.stretches().collect()),
        }
    }

    fn paths(&self) -> Result<Vec<&Path>> {
        match self {
            Self::Trajectory(trajectory) => trajectory.paths(),
            Self::Orbit(orbit) => Ok(vec![orbit.path()]),
        }
    }

    fn state(&self, t: f64, side: ImpactSide) -> Result<PhysicalState> {
        match self {
            Self::Trajectory(trajectory) => trajectory.state(t, side),
            Self::Orbit(orbit) => Ok(orbit.state(t, side == ImpactSide::Before)),
        }
    }

    fn phase(&self) -> Box<dyn Fn(f64) -> f64 + '_> {
        match self {
            Self::Trajectory(trajectory) => Box::new(trajectory.forcing_phase()),
            Self::Orbit(orbit) => {
                let (clock, phase) = (
                    Clock::new(0.0, orbit.scene().frequency().unwrap_or(0.0)),
                    orbit.phase(),
                );
                Box::new(move |t| wrapped(clock.at(t).angle() + phase))
            }
        }
    }

    fn has_steady_phase(&self) -> bool {
        match self {
            Self::Trajectory(trajectory) => trajectory.ramps().is_empty(),
            Self::Orbit(_) => true,
        }
    }

    fn is_closed(&self) -> bool {
        matches!(self, Self::Orbit(_))
    }
}
