//! A referee for `simulate`: a slow simulator of linear scenes that shares nothing with the library, a generator of scenes,
//! and a comparison of the two. The number of scenes comes from `VIBROIMPACT_REFEREE`, their seed from
//! `VIBROIMPACT_REFEREE_SEED`.

mod case;
mod closed_forms;
mod double_double;
mod law;
mod motion;
mod polynomial;
mod record;
mod simulator;
