//! Impacts at one instant: each stop by itself, or the law of several together (theory 9).

use super::{EventLoop, Resolved, Unresolved};
use crate::contact::walk::ROUNDING;
use crate::impact::{Impact, resolve_impacts};
use crate::quantity::positive_part;
use crate::simulate::Keep;
use crate::simulate::mover::{Blow, Mover};
use crate::simulate::record::Record;
use nalgebra::DVector;

impl EventLoop {
    /// The impacts of those stops in contact that are approached: each by itself where they are decoupled, else by the law
    /// of several stops at one instant.
    pub(super) fn strike_all<M: Mover + ?Sized>(
        &mut self,
        mover: &mut M,
        record: &mut Record,
    ) -> Resolved {
        self.still.clear();
        if self.touching.len() > 1 && self.is_coupled(mover) {
            if let Err(unresolved) = self.strike_together(mover, record)? {
                return Ok(Err(unresolved));
            }
        } else {
            for k in 0..self.touching.len() {
                let stop = self.touching[k];
                if self.closes(mover, stop) {
                    let blow = mover.strike(stop)?;
                    self.note(mover, stop, blow, record);
                    if blow.departure == 0.0 {
                        self.still.push(stop);
                    }
                }
            }
        }
        mover.look()?;
        self.settle(mover)
    }

    /// Whether a stop that is approached is coupled to another in contact.
    fn is_coupled<M: Mover + ?Sized>(&self, mover: &M) -> bool {
        let pairs = |&stop: &usize| self.touching.iter().map(move |&other| (stop, other));
        self.touching
            .iter()
            .filter(|&&stop| self.closes(mover, stop))
            .flat_map(pairs)
            .any(|(stop, other)| stop != other && mover.is_coupled(stop, other))
    }

    /// The impacts of all stops in contact at one instant (Newton and Moreau).
    fn strike_together<M: Mover + ?Sized>(
        &mut self,
        mover: &mut M,
        record: &mut Record,
    ) -> Resolved {
        let stops = self.touching.clone();
        let each = |of: &dyn Fn(usize) -> f64| {
            DVector::from_iterator(stops.len(), stops.iter().map(|&stop| of(stop)))
        };
        let restitutions = each(&|stop| mover.restitution(stop));
        let held = &self.held;
        let speeds = each(&|stop| {
            if held.contains(&stop) {
                0.0
            } else {
                mover.gap(stop).speed
            }
        });
        let slack = each(&|stop| ROUNDING * mover.speed_size(stop));
        let delassus = mover.delassus(&stops)?;
        let Ok(resolved) = resolve_impacts(&delassus, &restitutions, &speeds, &slack) else {
            let reason = format!("no impulses that push resolve the contacts {stops:?}: a jam");
            return Ok(Err(Unresolved { reason }));
        };
        self.n_inelastic += usize::from(resolved.is_inelastic);
        for (k, &stop) in stops.iter().enumerate() {
            let impulse = resolved.impulses[k];
            let departure = resolved.opening_speeds[k];
            if impulse > 0.0 {
                mover.push(stop, impulse)?;
                let blow = Blow {
                    approach: positive_part(-speeds[k]),
                    departure,
                    impulse,
                };
                self.note(mover, stop, blow, record);
            }
            if departure == 0.0 {
                self.still.push(stop);
            }
        }
        Ok(Ok(()))
    }

    /// Takes note of an impact.
    fn note<M: Mover + ?Sized>(&mut self, mover: &M, stop: usize, blow: Blow, record: &mut Record) {
        self.last_blow = Some((stop, blow.approach));
        self.stats.n_impacts += 1;
        if record.keep != Keep::Final {
            keep_impact(mover, stop, blow, record);
        }
    }
}

/// Keeps an impact.
#[inline(never)]
fn keep_impact<M: Mover + ?Sized>(mover: &M, stop: usize, blow: Blow, record: &mut Record) {
    record.impacts.push(Impact {
        time: mover.clock().time(),
        stop,
        approach: blow.approach,
        departure: blow.departure,
        impulse: blow.impulse,
        phase: mover.phase(),
    });
}
