//! What is analysed: systems, forcing, stops, and the scene they make. Plain data, checked once.

mod acceleration_terms;
mod change;
mod constraint;
mod contact;
mod contact_geometry;
mod derived;
mod difference;
mod dynamics;
mod energy;
mod excitation;
mod forcing;
mod fourier;
mod input;
mod linear;
mod linear_motion;
mod linearise;
mod moment;
mod nonlinear;
mod nonlinear_stop;
mod paper;
mod pendulum;
mod rayleigh;
mod reaction;
mod room;
mod scene;
mod scene_motion;
mod state;
mod stop;
mod system;

pub(crate) use acceleration_terms::{acceleration_size, force_terms};
pub use change::{Change, Parameter};
pub use constraint::Constraint;
pub(crate) use contact::{
    Contact, GapValue, Surface, along_reactions, are_coupled, contacts, impulses_of,
    reaction_weights,
};
pub(crate) use contact_geometry::{ContactGeometry, places};
pub(crate) use dynamics::{ChainMotion, DIFFERENCE, DoublePendulumMotion, Dynamics, singular_mass};
pub(crate) use energy::Energetics;
pub(crate) use excitation::{Excitation, HarmonicPart, powers};
pub use forcing::{BaseMotion, Forcing, Harmonic};
pub use fourier::Fourier;
pub(crate) use input::Driven;
pub use linear::{Coefficient, LinearSystem};
pub(crate) use linear_motion::Linear;
pub use linearise::linearise;
pub(crate) use moment::Moment;
#[cfg(feature = "python")]
pub(crate) use nonlinear::no_mass;
pub use nonlinear::{EquationsOfMotion, NonlinearSystem};
pub use nonlinear_stop::{GapFunction, NonlinearStop};
pub use paper::{Kind, PaperOptions, paper_scene, paper_system};
pub(crate) use pendulum::Links;
pub use pendulum::{DoublePendulum, PendulumChain};
pub use rayleigh::{rayleigh_coefficients, rayleigh_damping};
pub use reaction::Reaction;
pub(crate) use room::overlaps;
pub use scene::Scene;
pub(crate) use scene_motion::{SceneMotion, with_motion};
pub(crate) use state::PhysicalState;
pub use stop::{Normal, Side, Stop, Wall, WallSide};
pub use system::System;
