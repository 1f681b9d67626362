//! The source paper's system and its three numerical cases (Symmetry 2019, 11(7), 886), with the damping, wall angle and
//! signs that make them admissible (theory 3); zeta and theta0 are not printed there.

use crate::error::{Error, Result};
use crate::model::base_motion::BaseMotion;
use crate::model::linear::LinearSystem;
use crate::model::pendulum::{DoublePendulum, pendulum_mass, pendulum_stiffness};
use crate::model::reaction::Reaction;
use crate::model::scene::Scene;
use crate::model::stop::Stop;
use crate::quantity::{finite, positive};
use nalgebra::dvector;

/// The paper's kinds of periodic solution (Table 1) that come with numbers in its section 5.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Both pendulums hit the wall together.
    One,
    /// The upper pendulum hits.
    Two,
    /// The lower pendulum hits.
    Three,
}

/// The paper's parameters of one numerical case.
struct Case {
    mass_ratio: f64,
    length_ratio: f64,
    forcing: f64,
    damping: f64,
    clearance: f64,
}

/// Forcing frequency of all three cases of the paper [-], in units of its time. [exact]
const PAPER_FREQUENCY: f64 = 1.5;
/// Restitution coefficient `1 - gamma` of all three cases of the paper [-]. [exact]
const PAPER_RESTITUTION: f64 = 0.9;

impl Kind {
    /// Table 1: the stops hit in one period, and how many forcing periods that takes in the paper's cases.
    pub fn pattern(self) -> Vec<Vec<usize>> {
        match self {
            Self::One => vec![vec![0, 1]],
            Self::Two => vec![vec![0]],
            Self::Three => vec![vec![1]],
        }
    }

    /// Forcing periods in one period of the paper's orbit.
    pub fn n_periods(self) -> usize {
        match self {
            Self::One => 3,
            Self::Two | Self::Three => 2,
        }
    }

    fn case(self) -> Case {
        match self {
            // theta0 is where both contact positions meet: the answer of `free = clearance`, tested in tests/orbit/orbits.rs.
            Self::One => Case {
                mass_ratio: 3.0,
                length_ratio: 3.24,
                forcing: 0.162,
                damping: 0.05,
                clearance: 0.806_286_029_398_939_5,
            },
            Self::Two => Case {
                mass_ratio: 1.0,
                length_ratio: 3.24,
                forcing: 0.22,
                damping: 0.01,
                clearance: 0.5,
            },
            Self::Three => Case {
                mass_ratio: 1.0,
                length_ratio: 3.2,
                forcing: 0.1,
                damping: 0.05,
                clearance: 0.15,
            },
        }
    }
}

/// What the paper does not print, or what a user changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperOptions {
    /// zeta in `C = 2 zeta K`; `None`: a value with an admissible orbit.
    pub damping: Option<f64>,
    /// theta0; `None`: a value with an admissible orbit.
    pub clearance: Option<f64>,
    /// The small-angle system (7), or the full eq. (3) with the same damping.
    pub linear: bool,
}

impl Default for PaperOptions {
    fn default() -> Self {
        Self {
            damping: None,
            clearance: None,
            linear: true,
        }
    }
}

/// The source paper's system (7) in symmetric form, with damping C = 2 damping K. Modal damping ratios are `damping w_j`.
///
/// # Errors
/// A ratio that is not positive, a damping that is not finite.
pub fn paper_system(mass_ratio: f64, length_ratio: f64, damping: f64) -> Result<LinearSystem> {
    positive("mass_ratio", mass_ratio)?;
    positive("length_ratio", length_ratio)?;
    let stiffness = pendulum_stiffness(mass_ratio, length_ratio);
    LinearSystem::new(
        pendulum_mass(mass_ratio, length_ratio),
        &stiffness * (2.0 * finite("damping", damping)?),
        stiffness,
    )?
    .with_influence(dvector![1.0, 0.0])
}

/// The source paper's numerical case of the given kind: base motion, and a stop for each pendulum. Its impacts change the
/// coordinate of the stop alone.
///
/// # Errors
/// A damping or clearance that is not finite.
pub fn paper_scene(kind: Kind, options: &PaperOptions) -> Result<Scene> {
    let case = kind.case();
    let damping = options.damping.unwrap_or(case.damping);
    let clearance = options.clearance.unwrap_or(case.clearance);
    let stop =
        |i: usize| Stop::new(i, clearance, PAPER_RESTITUTION)?.with_reaction(Reaction::Coordinate);
    let base = BaseMotion::new(
        case.forcing / (PAPER_FREQUENCY * PAPER_FREQUENCY),
        PAPER_FREQUENCY,
        0.0,
    )?;
    let stops = [stop(0)?, stop(1)?];
    if options.linear {
        Scene::new(
            paper_system(case.mass_ratio, case.length_ratio, damping)?,
            base,
            stops,
        )
    } else {
        let c = pendulum_stiffness(case.mass_ratio, case.length_ratio)
            * (2.0 * finite("damping", damping)?);
        Scene::new(
            DoublePendulum::with_damping_matrix(case.mass_ratio, case.length_ratio, c)?,
            base,
            stops,
        )
    }
}

impl TryFrom<i64> for Kind {
    type Error = Error;

    fn try_from(kind: i64) -> Result<Self> {
        match kind {
            1 => Ok(Self::One),
            2 => Ok(Self::Two),
            3 => Ok(Self::Three),
            _ => Err(Error::bad_value(
                "kind",
                kind,
                "the paper's cases are 1, 2 and 3",
            )),
        }
    }
}
