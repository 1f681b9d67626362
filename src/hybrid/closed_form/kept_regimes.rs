//! The motions in regimes that are not free, each made once, with the propagators that flights in it have made.

use crate::error::Result;
use crate::flow::RegimeMotion;
use crate::law::Regime;
use std::any::Any;
use std::sync::Arc;

/// The propagators of the flow of a regime, whichever flow it has; none before the first flight.
pub(super) type KeptLevels = Option<Box<dyn Any>>;

/// The motions in regimes, in the order in which they were met.
#[derive(Default)]
pub(super) struct KeptRegimes(Vec<(Arc<RegimeMotion>, KeptLevels)>);

impl KeptRegimes {
    /// The motion in a regime, made if it is a new one.
    pub fn motion(
        &mut self,
        regime: &Regime,
        made: impl FnOnce() -> Result<Arc<RegimeMotion>>,
    ) -> Result<Arc<RegimeMotion>> {
        if let Some((known, _)) = self.0.iter().find(|own| own.0.regime == *regime) {
            return Ok(Arc::clone(known));
        }
        let motion = made()?;
        self.0.push((Arc::clone(&motion), None));
        Ok(motion)
    }

    /// The propagators of a motion.
    pub fn levels(&mut self, motion: &RegimeMotion) -> &mut KeptLevels {
        let own = self
            .0
            .iter_mut()
            .find(|own| std::ptr::eq(Arc::as_ptr(&own.0), motion));
        &mut own.expect("it was made here").1
    }

    /// The motions.
    pub fn motions(&self) -> Vec<Arc<RegimeMotion>> {
        self.0.iter().map(|own| Arc::clone(&own.0)).collect()
    }
}
