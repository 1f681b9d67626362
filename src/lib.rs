//! crate
pub mod error;
pub mod quantity;
mod linalg;
pub mod model;
pub mod modal;
pub use error::{Error,Result};
pub use model::*;
pub use modal::{modes,Modes};
pub mod impact;
mod contact;
mod flow;
pub use impact::*;
pub mod orbit;
pub use orbit::*;
pub mod simulate;
pub use simulate::*;
pub mod sweep;
pub use sweep::*;
#[cfg(feature = "python")]
mod python;
