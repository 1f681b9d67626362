//! Periodic impact orbits: a pattern of impacts, the periodic solve, admissibility, stability (theory 5, 6, 7).

mod admissible;
mod certificate;
mod closed_form;
mod conditions;
mod find;
mod flight_time;
mod free;
mod green;
mod guess;
mod impulses;
mod isolate;
mod minors;
mod monodromy;
mod motion;
mod one_instant;
mod one_stop;
mod orbits;
mod pattern;
mod periodic_orbit;
mod polish;
mod retained;
mod scaled_rows;
mod search;
mod series;
mod shooting;
mod stability;
mod stepped;
mod two_instants;
mod units;

pub use admissible::{Touch, Violation};
pub use closed_form::{Coefficients, first_kind_coefficients};
pub use find::{find_orbit, find_orbit_checked};
pub use free::Free;
pub use guess::Guess;
pub use orbits::{Family, OrbitOptions, Orbits, Verdict};
pub use pattern::Pattern;
pub use periodic_orbit::{PeriodicOrbit, Saved};
pub use search::{periodic_orbits, periodic_orbits_checked};
pub use stability::{OrderMultipliers, Stability};

pub(crate) use admissible::{Admissibility, Judge};
pub(crate) use impulses::Instant;
pub(crate) use one_instant::{Solution, clearance_given};
pub(crate) use periodic_orbit::list_impacts;
pub(crate) use search::{check, period, ranking};
pub(crate) use stability::{decides, largest_multiplier};
