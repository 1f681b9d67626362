//! A linear scene in closed form: moved from contact to contact in modes (theory 8).

mod arcs;
mod flight_sampler;
mod held;
mod impacts;
mod maps;
mod system;

pub(crate) use impacts::ModalImpacts;
pub(crate) use maps::{ClosedFormMaps, constrained_motions, joined};
pub(crate) use system::ClosedForm;
