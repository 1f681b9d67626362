//! Pendulums whose motion and gaps have Taylor series, and the order of these.

use crate::error::{Error, Result};
use crate::flow::taylor::MOST_ORDER;
use crate::model::{ChainMotion, Constraint, DoublePendulumMotion, Driven, Links, Scene, System};

/// The order of a series for a tolerance. A step of order p is as long as `tolerance^(1/p)` and its work `a + b p + c p^2`, of
/// which it is least for about this order on a double pendulum; it is flat there.
pub(crate) fn series_order(rtol: f64) -> usize {
    let digits = -rtol.max(f64::EPSILON).log10();
    let order = (8.5 + 1.1 * digits).ceil().max(8.0);
    (order as usize).min(MOST_ORDER)
}

/// Whether the motion of a scene and its gaps have Taylor series: a pendulum's do, but for stops given by functions and
/// stops that move by themselves.
pub(crate) fn has_series(scene: &Scene) -> bool {
    let is_given = |stop: &Constraint| !matches!(stop, Constraint::Nonlinear(_));
    let is_pendulum = matches!(
        scene.system(),
        System::DoublePendulum(_) | System::PendulumChain(_)
    );
    let is_constant = scene.drifting_damping().is_none();
    is_pendulum && is_constant && !scene.has_stop_motion() && scene.stops().iter().all(is_given)
}

/// The links of a pendulum.
pub(crate) fn links_of(system: &System) -> Option<Links> {
    match system {
        System::DoublePendulum(s) => Some(s.links()),
        System::PendulumChain(s) => Some(s.links()),
        _ => None,
    }
}

/// A pendulum that has Taylor series: its motion for everything else, the coefficients for these.
pub(crate) enum Pendulum {
    /// Two links.
    Double(DoublePendulumMotion<Option<Driven>>, Links),
    /// N links.
    Chain(ChainMotion, Links),
}

impl Pendulum {
    /// The pendulum of a scene.
    ///
    /// # Errors
    /// A scene that has no Taylor series.
    pub fn new(scene: &Scene) -> Result<Self> {
        let excitation = scene.excitation();
        match scene.system() {
            System::DoublePendulum(s) if has_series(scene) => Ok(Self::Double(
                DoublePendulumMotion::new(s, Driven::new(&excitation)),
                s.links(),
            )),
            System::PendulumChain(s) if has_series(scene) => {
                Ok(Self::Chain(ChainMotion::new(s, &excitation), s.links()))
            }
            _ => Err(Error::bad_value(
                "method",
                "\"taylor\"",
                "Taylor series are those of a DoublePendulum or a PendulumChain with stops and walls that rest; use \"auto\"",
            )),
        }
    }
}
