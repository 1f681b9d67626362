//! Where a signal passes from one polynomial to the next (theory 11): the state goes on, the acceleration may jump. What is held is
//! judged anew, and so is what is in contact.

use super::{Resolved, Resolver};
use crate::error::Result;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::system::HybridSystem;

impl Resolver {
    /// Goes on at the time from which something else acts.
    pub fn pass_break<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        at: f64,
        recorder: &mut R,
    ) -> Resolved {
        system.set_time(at);
        self.zeros.clear();
        self.impulses.clear();
        let resolved = self.judge_at_break(system, recorder)?;
        self.settle_compliant(system, resolved, recorder)
    }

    /// Judges what is in contact there; where that is what was held and stays so, the segment goes on.
    fn judge_at_break<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        recorder: &mut R,
    ) -> Resolved {
        self.find_touching(system)?;
        let held = self.held.clone();
        let is_held_alone = self.touching.iter().all(|stop| held.contains(stop));
        let is_struck = self.is_struck(system);
        let resolved = self.judge_touching(system, recorder)?;
        if is_held_alone && !is_struck && self.held == held {
            recorder.continue_segment();
        }
        Ok(resolved)
    }

    /// Whether a stop in contact is approached.
    fn is_struck<Y: HybridSystem + ?Sized>(&self, system: &Y) -> bool {
        self.touching.iter().any(|&stop| self.closes(system, stop))
    }

    /// Judges the stops in contact anew: those that are approached are struck, the others held or let go.
    pub(super) fn judge_touching<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        recorder: &mut R,
    ) -> Resolved {
        if self.touching.is_empty() && self.held.is_empty() && self.zero_speed.is_empty() {
            self.root_orders.clear();
            return Ok(Ok(()));
        }
        if self.is_struck(system) {
            return self.resolve_contacts(system, recorder);
        }
        self.settle(system)
    }

    /// The stops in contact: those held, those that these keep closed, and those that are closed to rounding.
    pub(super) fn find_touching<Y: HybridSystem + ?Sized>(&mut self, system: &mut Y) -> Result<()> {
        system.evaluate_gaps()?;
        self.touching.clear();
        self.zero_speed.clear();
        for stop in 0..system.n_stops() {
            if !system.element_law(stop).is_rigid() {
                continue;
            }
            // What is held has no speed, though its stop may have moved on by the rounding of the time.
            let stays = self.held.contains(&stop) || self.faces_held(system, stop);
            if stays {
                self.zero_speed.push(stop);
            }
            if stays || self.is_closed(system, stop) {
                self.touching.push(stop);
            }
        }
        Ok(())
    }
}
