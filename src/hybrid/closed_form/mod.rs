//! A linear scene in closed form: moved from contact to contact in modes (theory 8).

mod arcs;
mod compliant;
mod compliant_elements;
mod departure;
mod flight_sampler;
mod impacts;
mod kept_regimes;
mod maps;
mod memory;
mod regime_flight;
mod system;

pub(crate) use impacts::ModalImpacts;
pub(crate) use maps::{ClosedFormMaps, regime_motions};
pub(crate) use system::ClosedForm;
