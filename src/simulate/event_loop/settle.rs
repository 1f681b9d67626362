//! What stops in contact do next: those at rest are held where they are pressed and let go where they are drawn away, the
//! others open (theory 9, at acceleration level).

use super::{EventLoop, Resolved, TIME_ROUNDING, Unresolved};
use crate::contact::walk::ROUNDING;
use crate::error::Result;
use crate::impact::{ContactForce, Release, contact_forces};
use crate::simulate::mover::Mover;
use nalgebra::{DMatrix, DVector};

/// Acceleration of a gap, relative to the largest in contact, that the rounding of the time of a release may leave of none.
const RELEASED: f64 = 1e-9;

/// Singular values of a Delassus matrix below this part of its largest entry are zero: normals depend on each other.
const DEPENDENT: f64 = 1e-12;

impl EventLoop {
    /// What each stop in contact does next: it opens with a root of some order, or it is held.
    pub(super) fn settle<M: Mover + ?Sized>(&mut self, mover: &mut M) -> Resolved {
        self.starts.fill(0);
        for (stop, size) in self.sizes.iter_mut().enumerate() {
            *size = size.max(mover.gap(stop).size);
        }
        let before = std::mem::take(&mut self.held);
        let mut resting = Vec::new();
        for &stop in self.touching.iter().chain(&before) {
            if self.is_still(mover, stop) {
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

    /// A stop held whose force fell through zero: it opens with gap, speed and acceleration zero. The others in contact at rest are
    /// judged anew: a stop that faces it may take over, and if one of them opens with it, its gap has an acceleration, and it may
    /// be held after all.
    #[cold]
    pub(super) fn let_go<M: Mover + ?Sized>(&mut self, mover: &mut M, stop: usize) -> Resolved {
        let all = std::mem::take(&mut self.held);
        let rests = |other: &usize| {
            all.contains(other) || (self.is_closed(mover, *other) && self.is_still(mover, *other))
        };
        let others = (0..mover.n_stops()).filter(|other| *other != stop);
        let others: Vec<usize> = others.filter(rests).collect();
        self.still.clear();
        self.starts.fill(0);
        if let Err(unresolved) = self.hold_or_open(mover, &others)? {
            return Ok(Err(unresolved));
        }
        let acceleration = self.drawn(mover, stop, &self.held)?;
        let rounding = if self.held == others {
            f64::INFINITY
        } else {
            let pulls = all.iter().map(|&stop| mover.gap(stop).acceleration.abs());
            (RELEASED * pulls.fold(0.0, f64::max)).max(self.unknown_pull(mover, stop))
        };
        // Where holding it alone made the force pull, damping having pushed before, free motion draws it away as well.
        let is_drawn = self.held.is_empty() && acceleration > 0.0 && mover.jerk(stop)? < 0.0;
        if acceleration < -rounding {
            self.held.clear();
            self.starts.fill(0);
            if let Err(unresolved) = self.hold_or_open(mover, &all)? {
                return Ok(Err(unresolved));
            }
        } else {
            let is_drawn = is_drawn || acceleration > rounding;
            self.starts[stop] = if is_drawn { 2 } else { 3 };
        }
        let held = self.held.clone();
        mover.hold(&held)?;
        Ok(Ok(()))
    }

    /// Whether a stop in contact has no normal speed: an inelastic impact leaves one of rounding size, which is none.
    fn is_still<M: Mover + ?Sized>(&self, mover: &M, stop: usize) -> bool {
        let speed = mover.gap(stop).speed;
        self.still.contains(&stop) || speed.abs() <= ROUNDING * mover.speed_size(stop)
    }

    /// Of the stops at rest in contact, those that push are held, the others open (theory 9, at acceleration level).
    fn hold_or_open<M: Mover + ?Sized>(&mut self, mover: &M, resting: &[usize]) -> Resolved {
        if resting.is_empty() {
            return Ok(Ok(()));
        }
        let Some(forces) = self.holding_forces(mover, resting, &mover.delassus(resting)?) else {
            let reason = format!("no forces that push keep the contacts {resting:?} closed: a jam");
            return Ok(Err(Unresolved { reason }));
        };
        // The third derivative is that of free motion: beside forces, which change too, it says nothing.
        let is_free = forces.iter().all(|f| f.release != Release::Stays);
        let delassus = mover.delassus(resting)?;
        let stays = |i: &usize| forces[*i].release == Release::Stays;
        let stays: Vec<usize> = (0..resting.len()).filter(stays).collect();
        for (i, (&stop, force)) in resting.iter().zip(&forces).enumerate() {
            match force.release {
                Release::Leaves => self.starts[stop] = 2,
                Release::Undecided if is_free && mover.jerk(stop)? > 0.0 => {
                    self.starts[stop] = 3;
                }
                // It carries nothing, and the others leave its gap no motion: it faces one of them.
                Release::Undecided if is_bound(&delassus, &stays, i) => self.starts[stop] = 3,
                Release::Stays | Release::Undecided => self.held.push(stop),
            }
        }
        Ok(Ok(()))
    }

    /// The acceleration of a gap while other stops are held: that of free motion with the contact forces of theirs.
    pub(super) fn drawn<M: Mover + ?Sized>(
        &self,
        mover: &M,
        stop: usize,
        held: &[usize],
    ) -> Result<f64> {
        let free = mover.gap(stop).acceleration;
        let k = held.len();
        if k == 0 {
            return Ok(free);
        }
        let mut with_it = held.to_vec();
        with_it.push(stop);
        let delassus = mover.delassus(&with_it)?;
        let among = delassus.view((0, 0), (k, k)).into_owned();
        // Contacts without forces are a jam, which is found where it is asked which of them stay.
        let forces = self.holding_forces(mover, held, &among).unwrap_or_default();
        let forces = forces.iter().enumerate();
        let added: f64 = forces
            .map(|(j, force)| delassus[(k, j)] * force.force)
            .sum();
        Ok(free + added)
    }

    /// The contact forces that hold stops at rest, by their Delassus matrix; `None` in a jam.
    fn holding_forces<M: Mover + ?Sized>(
        &self,
        mover: &M,
        stops: &[usize],
        delassus: &DMatrix<f64>,
    ) -> Option<Vec<ContactForce>> {
        let each = |of: &dyn Fn(usize) -> f64| {
            DVector::from_iterator(stops.len(), stops.iter().map(|&stop| of(stop)))
        };
        let pulls = each(&|stop| mover.gap(stop).acceleration);
        let slack = each(&|stop| self.unknown_pull(mover, stop).max(ROUNDING * pulls.amax()));
        contact_forces(delassus, &pulls, &slack).ok()
    }

    /// What rounding, that of the time since the last event too, leaves unknown of the acceleration of a gap.
    fn unknown_pull<M: Mover + ?Sized>(&self, mover: &M, stop: usize) -> f64 {
        let flight = self.departure.map_or(0.0, |then| then.until(mover.clock()));
        ROUNDING * mover.acceleration_size(stop)
            + TIME_ROUNDING * flight * mover.gap(stop).jerk.abs()
    }
}

/// Whether the gap of a contact cannot change while some others are held: its normal depends on theirs.
fn is_bound(delassus: &DMatrix<f64>, held: &[usize], contact: usize) -> bool {
    if held.is_empty() {
        return false;
    }
    let among = delassus.select_rows(held).select_columns(held);
    let (row, column) = (delassus.row(contact), delassus.column(contact));
    let moves = |inverse: DMatrix<f64>| {
        let across = row.select_columns(held) * inverse * column.select_rows(held);
        delassus[(contact, contact)] - across.sum()
    };
    let inverse = among.clone().pseudo_inverse(DEPENDENT * among.amax());
    inverse.is_ok_and(|inverse| moves(inverse) <= DEPENDENT * delassus[(contact, contact)])
}
