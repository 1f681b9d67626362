//! Laws of contact (theory 1, 9): the states of a contact element, the guards that end them, and what happens there. What several elements
//! do at one instant is in `impact`.

mod contact_law;
mod element_law;
#[cfg(test)]
mod example;
mod guard;
mod newton;
mod regime;
mod transition;

pub(crate) use contact_law::{Action, LinearForce, Outcome};
pub(crate) use element_law::Law;
#[cfg(test)]
pub(crate) use example::Cushion;
pub(crate) use guard::{Guard, GuardKind};
pub(crate) use newton::Newton;
pub(crate) use regime::{ElementState, Regime};
pub(crate) use transition::{Stage, Transition};
