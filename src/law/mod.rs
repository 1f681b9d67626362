//! Laws of contact (theory 1, 9): the states of a contact element, the guards that end them, and what happens there. What several elements
//! do at one instant is in `impact`.

mod contact_law;
mod contact_release;
mod element_law;
#[cfg(test)]
mod example;
mod free_contact;
mod guard;
mod hertz;
mod newton;
mod regime;
mod spring;
mod transition;

pub(crate) use contact_law::{Action, ContactLaw, LinearForce, Outcome, Relaxation};
pub use contact_release::ContactRelease;
pub(crate) use element_law::LawNumber;
pub use element_law::{IntoLaw, Law};
#[cfg(test)]
pub(crate) use example::Cushion;
pub(crate) use guard::{Guard, GuardKind};
pub use hertz::Hertz;
pub use newton::Newton;
pub(crate) use regime::{ElementState, Regime};
pub use spring::Spring;
pub(crate) use transition::{Stage, Transition};
