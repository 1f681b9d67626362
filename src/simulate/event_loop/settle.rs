//! What stops in contact do next: those at rest are held where they are pressed and let go where they are drawn away, the
//! others open (theory 9, at acceleration level).

use super::{EventLoop, Resolved, Unresolved};
use crate::contact::walk::ROUNDING;
use crate::error::Result;
use crate::impact::{ContactForce, Release, contact_forces};
use crate::simulate::mover::Mover;
use nalgebra::{DMatrix, DVector};

impl EventLoop {
    /// What each stop in contact does next: it opens with a root of some order, or it is held.
    pub(super) fn settle<M: Mover + ?Sized>(&mut self, mover: &mut M) -> Resolved {
        self.starts.fill(0);
        for (stop, size) in self.sizes.iter_mut().enumerate() {
            let state = mover.gap(stop);
            *size = size.max(state.size).max(0.5 * state.apex());
        }
        let before = std::mem::take(&mut self.held);
        let mut resting = Vec::new();
        for &stop in self.touching.iter().chain(&before) {
            if self.is_still(mover, stop, &before)? {
                resting.push(stop);
            } else {
                self.starts[stop] = 1;
            }
        }
        resting.sort_unstable();
        resting.dedup();
        if resting.is_empty() && before.is_empty() {
            return Ok(Ok(()));
        }
        if let Err(unresolved) = self.hold_or_open(mover, &resting)? {
            return Ok(Err(unresolved));
        }
        let held = self.held.clone();
        mover.hold(&held)?;
        Ok(Ok(()))
    }

    /// Whether a stop in contact has no normal speed: an inelastic impact leaves one of rounding size, which is none; so
    /// does a flight that would rise by no more than rounding.
    fn is_still<M: Mover + ?Sized>(&self, mover: &M, stop: usize, held: &[usize]) -> Result<bool> {
        let mut state = mover.gap(stop);
        let low = ROUNDING * self.sizes[stop];
        if self.still.contains(&stop) || state.speed.abs() <= ROUNDING * mover.speed_size(stop) {
            return Ok(true);
        }
        state.acceleration = drawn(mover, stop, held)?;
        Ok(state.acceleration < 0.0 && state.speed > 0.0 && 0.5 * state.apex() < low)
    }

    /// Of the stops at rest in contact, those that push are held, the others open (theory 9, at acceleration level).
    fn hold_or_open<M: Mover + ?Sized>(&mut self, mover: &M, resting: &[usize]) -> Resolved {
        if resting.is_empty() {
            return Ok(Ok(()));
        }
        let Some(forces) = holding_forces(mover, resting, &mover.delassus(resting)?) else {
            let reason = format!("no forces that push keep the contacts {resting:?} closed: a jam");
            return Ok(Err(Unresolved { reason }));
        };
        for (&stop, force) in resting.iter().zip(&forces) {
            match force.release {
                Release::Leaves => self.starts[stop] = 2,
                Release::Undecided if mover.gap(stop).jerk > 0.0 => self.starts[stop] = 3,
                Release::Stays | Release::Undecided => self.held.push(stop),
            }
        }
        Ok(Ok(()))
    }
}

/// The acceleration of a gap while other stops are held: that of free motion with the contact forces of theirs.
fn drawn<M: Mover + ?Sized>(mover: &M, stop: usize, held: &[usize]) -> Result<f64> {
    let free = mover.gap(stop).acceleration;
    let all: Vec<usize> = held.iter().copied().filter(|&h| h != stop).collect();
    let k = all.len();
    if k == 0 {
        return Ok(free);
    }
    let mut with_it = all.clone();
    with_it.push(stop);
    let delassus = mover.delassus(&with_it)?;
    let among = delassus.view((0, 0), (k, k)).into_owned();
    // Contacts without forces are a jam, which is found where it is asked which of them stay.
    let forces = holding_forces(mover, &all, &among).unwrap_or_default();
    let forces = forces.iter().enumerate();
    let added: f64 = forces
        .map(|(j, force)| delassus[(k, j)] * force.force)
        .sum();
    Ok(free + added)
}

/// The contact forces that hold stops at rest, by their Delassus matrix; `None` in a jam.
fn holding_forces<M: Mover + ?Sized>(
    mover: &M,
    stops: &[usize],
    delassus: &DMatrix<f64>,
) -> Option<Vec<ContactForce>> {
    let pulls = stops.iter().map(|&stop| mover.gap(stop).acceleration);
    let pulls = DVector::from_iterator(stops.len(), pulls);
    let slack = DVector::from_element(stops.len(), ROUNDING * pulls.amax());
    contact_forces(delassus, &pulls, &slack).ok()
}
