//! crate
pub mod error;
mod linalg;
pub mod modal;
pub mod model;
pub mod quantity;
pub use error::{Error, Result};
pub use modal::{Modes, modes};
pub use model::*;
mod contact;
mod flow;
pub mod impact;
pub use impact::*;
pub mod orbit;
pub use orbit::*;
pub mod simulate;
pub use simulate::*;
pub mod sweep;
pub use sweep::*;
#[cfg(feature = "python")]
mod python;
