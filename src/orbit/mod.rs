//! Periodic impact orbits: a pattern of impacts, the periodic solve, admissibility, stability (theory 5, 6, 7).

mod extremes;
mod free_parameter;
mod impacts;
mod kept_motion;
mod mirrored;
mod one_instant;
mod options;
mod orbit_data;
mod orbit_motion;
mod orbits;
mod paper_coefficients;
mod pattern;
mod periodic_orbit;
mod problem;
mod pulse_count;
mod pulse_kernel;
mod pulses;
mod saved;
mod search;
mod shooting;
mod signature_events;
mod solutions;
mod stability;
mod two_instants;
mod value_roots;
mod verdict;

pub use options::{FreeParameter, OrbitOptions};
pub use orbits::{Family, Orbits, Verdict};
pub use paper_coefficients::{Coefficients, first_kind_coefficients};
pub use pattern::Pattern;
pub use periodic_orbit::PeriodicOrbit;
pub use saved::{SavedMode, SavedOrbit};
pub use search::periodic_orbits;
pub use shooting::find::{find_orbit, find_orbit_in_order};
pub use shooting::guess::Guess;

pub use stability::multipliers::{OrderMultipliers, Stability};
pub use verdict::admissibility::{Touch, Violation};

pub(crate) use extremes::{Extremes, PlaceOnFlight};
pub(crate) use impacts::list_impacts;
pub(crate) use one_instant::periodic_conditions::PeriodicConditions;
pub(crate) use one_instant::solve::{Solution, clearance_given};
pub(crate) use orbits::ranking;
pub(crate) use problem::{check, period};
pub(crate) use pulse_kernel::{Kernel, LinearisedPulses};
pub(crate) use pulses::{PulseTrain, Pulses};
pub(crate) use shooting::closure::{Clocked, Shooting, ShootingState};
pub(crate) use shooting::find::begun;
pub(crate) use shooting::mirror::images;
pub(crate) use shooting::newton::Linearised;
pub(crate) use shooting::own_time::{depends_on_own_time, with_phase};
pub(crate) use shooting::signature::{OrbitOf, Signature, with_maps, with_shooting};
pub(crate) use stability::multipliers::{decides, largest_multiplier};
pub(crate) use verdict::admissibility::{Admissibility, Breach, Rule, Ruling};
pub(crate) use verdict::judge::Judge;
