//! What stops in contact do next: those at rest are held where they are pressed and let go where they are drawn away, the
//! others open (theory 9, at acceleration level). Where a force falls through zero is found in `hybrid` (`closed_form/regime_flight.rs`,
//! `integrated/release.rs`); the law of the forces is `impact/contact_force.rs`.

use super::resting::{Resting, carriers, depend, is_bound, reduced};
use super::strike::take;
use super::{Resolved, Resolver, Unresolved, least_speed};
use crate::event::next::LATE;

use crate::error::Result;
use crate::hybrid::system::{GapState, HybridSystem};
use crate::impact::{ContactForce, Release, contact_forces};
use crate::law::{ElementState, Guard};

use crate::tolerance::{DEPENDENT, FACING, GAP_ROUNDING, RELEASED, RELEASES_AT_ONCE};
use nalgebra::{DMatrix, DVector};
use std::collections::VecDeque;

impl Resolver {
    /// Decides whether each stop in contact opens, with a root of some order, or is held.
    pub(super) fn settle<Y: HybridSystem + ?Sized>(&mut self, system: &mut Y) -> Resolved {
        self.root_orders.clear();
        for (stop, size) in self.sizes.iter_mut().enumerate() {
            *size = size.max(system.gap(stop).size);
        }
        std::mem::swap(&mut self.were_held, &mut self.held);
        self.held.clear();
        let mut resting = Vec::new();
        for &stop in &self.touching {
            if self.is_still(system, stop) {
                resting.push(stop);
            } else {
                self.root_orders[stop] = 1;
            }
        }
        let seats = self.seats_at_rest(system);
        resting.extend(&seats);
        if resting.is_empty() && self.were_held.is_empty() {
            return Ok(Ok(()));
        }
        if let Err(unresolved) = self.hold_or_open(system, &resting, false)? {
            return Ok(Err(unresolved));
        }
        self.enter(system)?;
        self.stop_what_rests(system, &resting)?;
        for seat in seats {
            if !self.held.contains(&seat) {
                self.note_zero(Guard::force(seat), ElementState::Free, false);
            }
        }
        Ok(Ok(()))
    }

    /// Takes away the speeds at which stops at rest are approached as they open: rounding, but gaps that open late would close first.
    fn stop_what_rests<Y: HybridSystem + ?Sized>(
        &self,
        system: &mut Y,
        resting: &[usize],
    ) -> Result<()> {
        let approached = |&stop: &usize| !self.held.contains(&stop) && system.gap(stop).speed < 0.0;
        if resting.iter().any(approached) {
            let nothing = DVector::zeros(resting.len());
            take(system, resting, &nothing, &system.delassus(resting)?)?;
            system.evaluate_gaps()?;
        }
        Ok(())
    }

    /// A stop held whose force fell through zero. With it, all that rest in contact are judged anew: a stop that faces it may take
    /// over, and if others open with it, it may be held after all.
    #[cold]
    pub(super) fn release<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
        stop: usize,
    ) -> Resolved {
        let now = system.clock().time();
        self.impulses.clear();
        self.note_zero(Guard::force(stop), ElementState::Free, true);
        self.releases.note(now, stop);
        // Stops without speed at the start of the flight may have one now.
        if !self.departed_at(now) {
            self.zero_speed.clear();
        }
        let mut resting = Vec::new();
        for other in 0..system.n_stops() {
            let is_rigid = system.element_law(other).is_rigid();
            let rests = is_rigid && self.is_closed(system, other) && self.is_still(system, other);
            if rests || self.held.contains(&other) || self.faces_held(system, other) {
                resting.push(other);
            }
        }
        self.held.clear();
        self.zero_speed.clear();
        self.root_orders.clear();
        if !self.is_spared(system, &resting, stop)? {
            self.held.clear();
            self.root_orders.clear();
            if let Err(unresolved) = self.hold_or_open(system, &resting, true)? {
                return Ok(Err(unresolved));
            }
        }
        self.enter(system)?;
        Ok(Ok(()))
    }

    /// Whether a gap is closed because stops that are held leave it no other place: their own gaps are known to more digits.
    pub(super) fn faces_held<Y: HybridSystem + ?Sized>(&self, system: &Y, stop: usize) -> bool {
        let is_near = || {
            let least = (FACING * system.rounding(stop)).max(system.tolerance(stop, 0.0));
            self.root_orders[stop] == LATE || system.gap(stop).gap <= least
        };
        system.element_law(stop).is_rigid() && system.is_bound(stop) && is_near()
    }

    /// Whether others that a stop depends on carry without it what it carried with them; they are held then.
    fn is_spared<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
        resting: &[usize],
        stop: usize,
    ) -> Result<bool> {
        let Some(own) = resting.iter().position(|&other| other == stop) else {
            return Ok(false);
        };
        let others: Vec<usize> = (0..resting.len()).filter(|&i| i != own).collect();
        if others.is_empty() {
            return Ok(false);
        }
        let normals = system.normals(resting)?;
        if !is_bound(&normals, &others, own)? {
            return Ok(false);
        }
        let others: Vec<usize> = others.into_iter().map(|i| resting[i]).collect();
        if self.hold_or_open(system, &others, true)?.is_err() {
            return Ok(false);
        }
        let bound: Vec<usize> = (0..resting.len())
            .filter(|&i| self.held.contains(&resting[i]))
            .collect();
        let stays = is_bound(&normals, &bound, own)?;
        let least = -RELEASED * system.acceleration_sizes(&[stop])?[0];
        self.root_orders[stop] = LATE;
        Ok(stays && self.drawn(system, (stop, system.gap(stop)), &self.held)? >= least)
    }

    /// Whether a stop in contact has no normal speed: an inelastic impact leaves one of rounding size, which is none.
    pub(super) fn is_still<Y: HybridSystem + ?Sized>(&self, system: &Y, stop: usize) -> bool {
        let state = system.gap(stop);
        self.zero_speed.contains(&stop) || state.speed.abs() <= least_speed(system, stop, state)
    }

    /// The sizes of the terms of the accelerations of stops at rest, or those before the impacts of this instant, if larger; and the
    /// latter.
    fn pull_sizes<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &Y,
        stops: &[usize],
    ) -> Result<(Vec<f64>, Vec<f64>)> {
        let prior_sizes: Vec<f64> = stops.iter().map(|&stop| self.prior_sizes[stop]).collect();
        self.prior_sizes.fill(0.0);
        let sizes = system.acceleration_sizes(stops)?;
        let sizes = sizes
            .iter()
            .zip(&prior_sizes)
            .map(|(size, prior)| size.max(*prior));
        Ok((sizes.collect(), prior_sizes))
    }

    /// Of the stops at rest in contact, those that push are held, the others open (theory 9, at acceleration level); where one is let
    /// go, what is as little as its force is nothing.
    fn hold_or_open<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
        stops: &[usize],
        is_release: bool,
    ) -> Resolved {
        if stops.is_empty() {
            return Ok(Ok(()));
        }
        let (mut sizes, prior_sizes) = self.pull_sizes(system, stops)?;
        let by_impacts = self.unknown_by_impacts(system, stops, &[], 2)?;
        for (size, unknown) in sizes.iter_mut().zip(by_impacts) {
            *size = size.max(unknown / GAP_ROUNDING);
        }
        let resting = Resting {
            stops,
            normals: system.normals(stops)?,
            delassus: system.delassus(stops)?,
            sizes,
            prior_sizes,
            steady: system.steady(),
        };
        let Resting {
            delassus, sizes, ..
        } = &resting;
        let Some(forces) = self.holding_forces(system, stops, sizes, delassus) else {
            let reason = format!("no forces that push keep the contacts {stops:?} closed: a jam");
            return Ok(Err(Unresolved { reason }));
        };
        let largest = sizes.iter().copied().fold(0.0, f64::max);
        let nothing = largest
            * if is_release {
                system.left_at_release()
            } else {
                DEPENDENT
            };
        let now = system.clock().time();
        // Where one is let go again and again, the law of the forces as they are ends it.
        let times = |stop: usize| self.releases.times(now, stop);
        let is_law = is_release && stops.iter().any(|&stop| times(stop) > RELEASES_AT_ONCE);
        let unclear = |stop: usize| match times(stop) {
            _ if is_law => 0.0,
            0 => nothing,
            _ => RELEASED * largest,
        };
        let (mut shares, mut undecided) = (Vec::new(), Vec::new());
        for (i, (&stop, force)) in stops.iter().zip(&forces).enumerate() {
            let left = (resting.delassus[(i, i)] * force.force).max(force.acceleration);
            match force.release {
                // The time of a release is known to rounding, and what is so little then to nobody.
                _ if is_release && left <= unclear(stop) => undecided.push(i),
                // Where the law of the forces is no end of it either, how they change decides.
                Release::Stays if is_release && times(stop) > 2 * RELEASES_AT_ONCE => {
                    undecided.push(i);
                }
                Release::Stays => shares.push((i, force.force)),
                Release::Leaves => self.root_orders[stop] = 2,
                Release::Undecided => undecided.push(i),
            }
        }
        let carrying = carriers(&resting.delassus, shares, resting.normals.nrows(), nothing)?;
        undecided.extend(carrying.idle);
        let held = self.decide(system, &resting, (carrying.held, undecided), is_release)?;
        self.held = held.into_iter().map(|i| stops[i]).collect();
        self.held.sort_unstable();
        Ok(Ok(()))
    }

    /// Of contacts that neither push nor open, those that begin to push are held, the others open: the same law for the third
    /// derivatives of the gaps and the rates of the forces, beside the contacts that are held; where those are nothing too, for the
    /// next ones. Contacts are places among those at rest; those that are held now.
    fn decide<Y: HybridSystem + ?Sized>(
        &mut self,
        system: &mut Y,
        resting: &Resting<'_>,
        (mut held, undecided): (Vec<usize>, Vec<usize>),
        is_release: bool,
    ) -> Result<Vec<usize>> {
        let now = system.clock().time();
        // One that is back each time that it opens is opened by rounding.
        let is_back = |&i: &usize| self.reclosings.times(now, resting.stops[i]) > RELEASES_AT_ONCE;
        let (back, mut undecided): (Vec<_>, Vec<_>) = undecided.into_iter().partition(is_back);
        let mut one_leaves = resting
            .stops
            .iter()
            .any(|&stop| self.root_orders[stop] == 2);
        // Those held share by other rules what the normals they have in common leave open: none may rest under these.
        let shares = !undecided.is_empty() && depend(&resting.normals, &held)?;
        let first = if shares || !is_release { 2 } else { LATE };
        let mut known = VecDeque::<Vec<[f64; 2]>>::new();
        for order in first.. {
            // One that faces those held, or stands at their place, has a gap that stays as it is.
            let mut free = Vec::new();
            for i in undecided {
                if is_bound(&resting.normals, &held, i)? {
                    self.root_orders[resting.stops[i]] = LATE;
                } else {
                    free.push(i);
                }
            }
            undecided = free;
            if undecided.is_empty() {
                break;
            }
            // Those that the first order leaves undecided are asked for all that follow at once, until fewer are left.
            if known.front().is_none_or(|all| all.len() != undecided.len()) {
                let end = if order == first {
                    order + 1
                } else {
                    usize::MAX
                };
                let (stops, held) = (resting.stops_of(&undecided), resting.stops_of(&held));
                known = system
                    .gap_derivatives(&stops, &self.regime.holding_instead(&held), order..end)?
                    .into();
            }
            let Some(mut derivatives) = known.pop_front() else {
                break;
            };
            let (stops, beside) = (resting.stops_of(&undecided), resting.stops_of(&held));
            let by_impacts = self.unknown_by_impacts(system, &stops, &beside, order)?;
            for (derivative, unknown) in derivatives.iter_mut().zip(by_impacts) {
                derivative[1] = derivative[1].max(unknown);
            }
            if order == 2 {
                let unknown = self.unknown_beside(system, resting, &held, &undecided)?;
                for (derivative, unknown) in derivatives.iter_mut().zip(unknown) {
                    derivative[1] = derivative[1].max(unknown);
                }
            }
            let law = resting.law_of(&held, &undecided, &derivatives)?;
            one_leaves |= !law.opening.is_empty();
            for &i in &law.opening {
                self.root_orders[resting.stops[i]] = order.min(LATE);
            }
            // One whose force falls each time that it is held is pressed by rounding, but by an acceleration.
            let is_spent = |i: &usize| {
                let times = self.releases.times(now, resting.stops[*i]);
                is_release && order > 2 && times > RELEASES_AT_ONCE
            };
            let (spent, pressed): (Vec<_>, Vec<_>) =
                law.pressed.iter().copied().partition(is_spent);
            for &i in &spent {
                self.root_orders[resting.stops[i]] = LATE;
            }
            for &i in &pressed {
                self.root_orders[resting.stops[i]] = (order - 2).min(LATE);
            }
            held.extend(pressed);
            undecided = law.undecided;
        }
        for i in undecided.into_iter().chain(back.iter().copied()) {
            // Where another leaves, it is that one whose force fell; at a second time it is this one.
            let times = self.releases.times(now, resting.stops[i]);
            // One that is let go each time that it is held, and back each time, is so by rounding: it stays, with a force that begins late.
            let is_neither = times > RELEASES_AT_ONCE && back.contains(&i);
            if is_neither {
                self.root_orders[resting.stops[i]] = LATE;
            }
            let leaves = is_release && !is_neither && times > usize::from(one_leaves);
            if leaves || is_bound(&resting.normals, &held, i)? {
                self.root_orders[resting.stops[i]] = LATE;
            } else {
                held.push(i);
            }
        }
        Ok(held)
    }

    /// The acceleration of a gap, as it is in free motion, while other stops are held: with the contact forces of theirs.
    pub(super) fn drawn<Y: HybridSystem + ?Sized>(
        &self,
        system: &Y,
        (stop, state): (usize, GapState),
        held: &[usize],
    ) -> Result<f64> {
        let k = held.len();
        if k == 0 {
            return Ok(state.acceleration);
        }
        let free = system.free_accelerations(&[stop])[0];
        let mut with_it = held.to_vec();
        with_it.push(stop);
        let delassus = system.delassus(&with_it)?;
        let among = delassus.view((0, 0), (k, k)).into_owned();
        // Contacts without forces are a jam, which is found where it is asked which of them stay.
        let sizes = system.acceleration_sizes(held)?;
        let forces = self
            .holding_forces(system, held, &sizes, &among)
            .unwrap_or_default();
        let forces = forces.iter().enumerate();
        let added: f64 = forces
            .map(|(j, force)| delassus[(k, j)] * force.force)
            .sum();
        Ok(free + added)
    }

    /// What an impulse of one on a stop changes its normal speed by while those held are: its Delassus number beside them.
    pub(super) fn give_beside_held<Y: HybridSystem + ?Sized>(
        &self,
        system: &Y,
        stop: usize,
    ) -> Result<f64> {
        let mut stops = self.held.clone();
        stops.push(stop);
        let delassus = system.delassus(&stops)?;
        let held: Vec<usize> = (0..self.held.len()).collect();
        Ok(reduced(&delassus, &held, &[self.held.len()])[(0, 0)])
    }

    /// The contact forces that hold stops at rest, by the sizes of the terms of their accelerations and their Delassus matrix;
    /// `None` in a jam.
    fn holding_forces<Y: HybridSystem + ?Sized>(
        &self,
        system: &Y,
        stops: &[usize],
        sizes: &[f64],
        delassus: &DMatrix<f64>,
    ) -> Option<Vec<ContactForce>> {
        let pulls = system.free_accelerations(stops);
        let unknown = |i: usize| {
            let jerk = system.gap(stops[i]).jerk.unwrap_or(0.0);
            self.acceleration_unknown(system, (stops[i], jerk), sizes[i])
        };
        let slack = DVector::from_fn(stops.len(), |i, _| {
            unknown(i).max(GAP_ROUNDING * pulls.amax())
        });
        contact_forces(delassus, &pulls, &slack).ok()
    }
}
