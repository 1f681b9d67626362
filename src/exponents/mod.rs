//! Lyapunov exponents: how fast small deviations from a motion grow (theory 16).

mod batches;
mod follower;
mod frame;
mod integrated_tangents;
mod lyapunov;
mod modal_tangents;
mod motion;
mod places;
mod tangents;
mod verdict;

pub use lyapunov::{LyapunovExponents, LyapunovOptions, lyapunov_exponents};
pub use verdict::Attraction;
