#![doc = include_str!("../README.md")]
//!
//! # How the crate is laid out
//!
//! Each folder uses those before it in this list, never those after: `tolerance`: every threshold; `error`, `quantity`, `linalg`,
//! `observer`: whether a long computation goes on; `law`: the laws of contact; [`model`]: what is analysed; [`modal`]: the modal transformation; [`impact`]: the laws of one instant; `flow`: smooth
//! motion, in closed form, along series, in steps; `event`: where the next root of a guard is; `hybrid`: how a scene with stops
//! moves from event to event, in closed form or integrated; `path`: motions that are kept; `recurrence`: which states, cycles and sets are one; [`simulate`](mod@simulate): trajectories; `itinerary`: what happens along a motion, as one list of
//! instants and arcs; [`orbit`]: periodic orbits; `continuation`: curves of zeros; [`section`]: a
//! motion looked at once in a while; [`exponents`]: how fast deviations grow; [`sweep`]: maps, ensembles, diagrams; [`attractor`]: what motions settle on; [`basin`]: from where; [`branch`]: orbits over a number of
//! their scene; [`derivative`]: how they change with its numbers. nalgebra is part of the public interface and re-exported. Formulas, with conditions and sources, are in
//! `docs/theory.md`: "theory 5" in a comment is its section 5; the words in `docs/glossary.md`; which files a new system, stop, excitation or
//! integrator touches in `docs/extending.md`.

pub mod attractor;
pub mod basin;
pub mod branch;
mod continuation;

pub mod derivative;
pub mod error;
mod event;
pub mod exponents;
mod flow;
mod hybrid;
pub mod impact;
mod itinerary;
mod law;
mod linalg;
pub mod modal;
pub mod model;
mod observer;
pub mod orbit;
mod path;
#[cfg(feature = "python")]
mod python;
pub mod quantity;
mod recurrence;
mod root;
pub mod section;
pub mod simulate;
pub mod sweep;
mod tolerance;

pub use attractor::*;
pub use basin::*;
pub use branch::*;
pub use derivative::*;
pub use error::{Error, Result};
pub use exponents::*;
pub use impact::*;
pub use law::{ContactRelease, Hertz, IntoLaw, Law, Newton, Spring};
pub use modal::{Modes, Spectrum, modes, modes_in, spectrum, spectrum_in};
pub use model::*;
pub use nalgebra;
pub use observer::with_observer;
pub use orbit::*;
pub use section::*;
pub use simulate::*;
pub use sweep::*;
