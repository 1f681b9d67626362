//! The Radau IIA method of order 5.

mod cubic;
mod method;
mod newton;
mod system;
mod tableau;

pub(crate) use method::Radau;
