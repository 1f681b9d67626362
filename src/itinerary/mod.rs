//! What happens along a motion and in which order (theory 5, 19): instants, each with the regime behind it, and the arcs between them, as one
//! list, whatever it is read from: a trajectory, an orbit, a loop of shooting. A new law of contact adds its transitions here; who asks an
//! itinerary does not learn of them.

mod arc;
mod brief;
mod compliant_states;
mod instant;
mod list;
mod read;
mod short;
mod transport;

pub(crate) use arc::{ArcEnd, MotionArc, arcs_of, bounces, closing, contacts_begun, hits};
pub(crate) use brief::{relaxed, states_of_touch, without_contact};
pub(crate) use instant::{Instant, begun_with_impact, turned, without_first, without_impact};
pub(crate) use list::{Itinerary, check_landings, check_laws, unsupported};
pub(crate) use read::{ReadInstant, folded, instants_of, instants_of_arcs, uneventful_end};
pub(crate) use short::Coincidence;
pub(crate) use transport::monodromy;
