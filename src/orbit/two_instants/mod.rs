//! Patterns of two instants: the search for the flight time between them (theory 5).

pub(in crate::orbit) mod certificate;
pub(in crate::orbit) mod conditions;
pub(in crate::orbit) mod enlarged_flow;
pub(in crate::orbit) mod flight_time;
pub(in crate::orbit) mod green;
pub(in crate::orbit) mod isolate;
pub(in crate::orbit) mod minors;
pub(in crate::orbit) mod polish;
pub(in crate::orbit) mod root_search;
pub(in crate::orbit) mod scaled_rows;
pub(in crate::orbit) mod solve;
pub(in crate::orbit) mod taylor_model;
pub(in crate::orbit) mod units;
pub(in crate::orbit) mod unseen;
