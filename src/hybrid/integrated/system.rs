//! The traits of `hybrid/system.rs` for a scene that is integrated: gaps and their margins, accelerations, the impact of one stop,
//! stops held.

use super::normal::{Directions, dot};
use super::scene::{Integrated, parted};
use crate::error::Result;
use crate::model::PhysicalState;

use crate::flow::GuardDerivatives;
use crate::flow::steps::{State, Stepper};
use crate::hybrid::clock::Clock;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::segment::SegmentKind;
use crate::hybrid::system::{
    Accelerations, Contacts, GapSizes, GapState, Gaps, GivenGap, Holding, NormalMotion, Present,
};
use crate::impact::wrapped;
use crate::law::{Guard, Law, Newton, Regime};
use crate::model::{
    Contact, Dynamics, GapValue, Laws, Surface, System, acceleration_size, are_coupled,
    force_terms, places,
};
use crate::quantity::difference;
use crate::tolerance::{RELEASED, STEADY_BY_STEPS, TERM_ROUNDINGS};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use std::sync::Arc;

/// Steps that a short flight with its impact is as much work as. [work]
const STEPS_OF_SHORT_FLIGHT: usize = 16;

impl<S: State, D: Dynamics, P: Stepper<S>> Gaps for Integrated<'_, S, D, P> {
    fn evaluate_gaps(&mut self) -> Result<()> {
        self.is_begun = false;
        if self.regime.others().is_empty() {
            return self.begin(self.dynamics);
        }
        // What is held is judged by the motion without it, under the forces of all others.
        let motion = self.motion_in(&self.regime.holding_instead(&[]));
        self.begin(&motion)
    }

    fn guard_derivatives(&mut self, guard: Guard) -> Result<Option<GuardDerivatives>> {
        self.present_guard(guard)
    }

    fn gap(&self, stop: usize) -> GapState {
        let mut value = self.gaps[stop];
        self.watched_now(stop).turn_back(&mut value);
        GapState {
            gap: value.gap,
            speed: value.speed,
            acceleration: value.acceleration,
            jerk: None,
            size: value.size,
        }
    }

    fn given_gap(&self, stop: usize, q: &DVector<f64>, v: &DVector<f64>) -> Result<GivenGap> {
        let (contact, q, v) = (&self.contacts[stop], q.as_slice(), v.as_slice());
        let value = contact.along(|| self.moment(), (q, v, v), 0.0)?;
        let motion = contact.own_motion(|| self.moment());
        let speed_size = contact.surface.speed_size(q, v)? + motion[1].abs();
        Ok(GivenGap {
            gap: (value.gap, value.size),
            speed: (value.speed, speed_size),
        }
        .at_time(self.clock.time(), motion))
    }

    fn rounding(&self, stop: usize) -> f64 {
        TERM_ROUNDINGS * self.gaps[stop].size
    }

    fn margin(&self, stop: usize, size: f64) -> f64 {
        let gap = self.gaps[stop];
        self.margin_of(GapValue { size, ..gap })
    }

    fn flight_sizes(&self, stop: usize) -> GapSizes {
        let terms = self.extents.get(stop).copied().unwrap_or(0.0);
        let reach = terms;
        GapSizes { terms, reach }
    }

    fn speed_size(&self, stop: usize) -> f64 {
        let (q, v) = self.x.slice().split_at(self.n());
        // The look before has had this normal: an error would have ended the run there.
        let size = self.contacts[stop].surface.speed_size(q, v);
        size.unwrap_or(0.0) + self.stop_speed(stop).abs()
    }
}

impl<S: State, D: Dynamics, P: Stepper<S>> Contacts for Integrated<'_, S, D, P> {
    fn n_stops(&self) -> usize {
        self.contacts.len()
    }

    fn element_law(&self, element: usize) -> &Law {
        &self.contacts[element].law
    }

    fn law(&self, stop: usize) -> Newton {
        let drifting = |laws: &Arc<Laws>| laws.law(stop, self.clock.time());
        let drifting = self.scene.laws().and_then(drifting);
        drifting.unwrap_or(self.contacts[stop].law())
    }

    fn normals(&self, stops: &[usize]) -> Result<DMatrix<f64>> {
        let q = self.x.slice().split_at(self.n()).0;
        let normal = |&stop: &usize| self.contacts[stop].surface.normal(q);
        let normals: Vec<_> = stops.iter().map(normal).collect::<Result<_>>()?;
        Ok(DMatrix::from_columns(&normals))
    }

    fn delassus(&self, stops: &[usize]) -> Result<DMatrix<f64>> {
        let all = stops.iter().map(|&stop| self.directions(stop));
        let all: Vec<_> = all.collect::<Result<_>>()?;
        let product = |i: usize, j: usize| dot(all[i].both().0, all[j].both().1);
        Ok(DMatrix::from_fn(stops.len(), stops.len(), product))
    }

    fn is_coupled(&self, one: usize, other: usize) -> bool {
        let (q, _) = self.x.slice().split_at(self.n());
        let (a, b) = (&self.contacts[one], &self.contacts[other]);
        are_coupled(a, b, self.scene.system(), q)
    }

    fn is_at_place_of(&self, one: usize, other: usize) -> bool {
        let plane = |contact: &Contact| match &contact.surface {
            Surface::Plane { normal, clearance } => Some((normal.clone(), *clearance)),
            _ => None,
        };
        let made = || places(&self.contacts.iter().map(plane).collect::<Vec<_>>());
        one == other || {
            let places = self.places.get_or_init(made);
            let is_one = places[one] == places[other];
            is_one && self.contacts[one].motion == self.contacts[other].motion
        }
    }

    fn is_bound(&self, stop: usize) -> bool {
        !self.regime.is_free() && self.is_bound[stop] && self.regime.leaves_free(stop)
    }
}

impl<S: State, D: Dynamics, P: Stepper<S>> Accelerations for Integrated<'_, S, D, P> {
    fn free_accelerations(&self, stops: &[usize]) -> DVector<f64> {
        DVector::from_fn(stops.len(), |i, _| self.gap(stops[i]).acceleration)
    }

    fn acceleration_sizes(&self, stops: &[usize]) -> Result<Vec<f64>> {
        let (q, v) = self.physical();
        let normals = stops
            .iter()
            .map(|&stop| self.contacts[stop].surface.normal(q.as_slice()));
        if let System::Linear(system) = self.scene.system() {
            let sizes = self.excitation.sizes(self.moment(), self.n());
            let terms = force_terms(system, &sizes, (&q, &v));
            let pushed = |stop: usize| -> Result<f64> {
                let pressed = self
                    .regime
                    .pressed()
                    .map(|other| self.push_size(other, stop));
                pressed.sum()
            };
            return normals
                .zip(stops)
                .map(|(normal, &stop)| {
                    Ok(acceleration_size(system, &normal?, &terms) + pushed(stop)?)
                })
                .collect();
        }
        // Of the terms of an acceleration given by a function nobody knows: they are as large as those of other coordinates.
        let (_, a) = self.stepper.start_rate().slice().split_at(self.n());
        let largest = a.iter().fold(0.0f64, |most, a| most.max(a.abs()));
        normals
            .map(|normal| Ok(largest * normal?.lp_norm(1)))
            .collect()
    }

    fn gap_derivatives(
        &mut self,
        stops: &[usize],
        regime: &Regime,
        orders: Range<usize>,
    ) -> Result<Vec<Vec<[f64; 2]>>> {
        let mut of_order = |order: usize| -> Result<Vec<[f64; 2]>> {
            let stops = stops.iter();
            if order == 2 {
                stops.map(|&stop| self.drawn(stop, regime)).collect()
            } else {
                stops.map(|&stop| self.jerk(stop, regime)).collect()
            }
        };
        (orders.start..orders.end.min(4))
            .map(&mut of_order)
            .collect()
    }

    fn free_jerk(&mut self, stop: usize) -> Result<f64> {
        let regime = self.regime.holding_instead(&[]);
        self.jerk(stop, &regime).map(|[jerk, _]| jerk)
    }

    fn left_at_release(&self) -> f64 {
        RELEASED
    }

    fn steady(&self) -> f64 {
        STEADY_BY_STEPS
    }
}

impl<S: State, D: Dynamics, P: Stepper<S>> NormalMotion for Integrated<'_, S, D, P> {
    type Directions = Directions<S>;

    fn directions(&self, stop: usize) -> Result<Directions<S>> {
        self.directions_at(stop, &self.x.slice()[..self.n()])
    }

    fn stop_speed(&self, stop: usize) -> f64 {
        self.contacts[stop].own_motion(|| self.moment())[1]
    }

    fn speed_along(&self, directions: &Directions<S>) -> f64 {
        dot(directions.both().0, &self.x.slice()[self.n()..])
    }

    fn impulse_of(&self, directions: &Directions<S>, _law: Newton, change: f64) -> f64 {
        change / directions.give
    }

    fn push_along(&mut self, directions: &Directions<S>, impulse: f64) {
        let reaction = directions.both().1;
        let v = &mut self.x.slice_mut()[reaction.len()..];
        for (v, b) in v.iter_mut().zip(reaction) {
            *v = difference(*v, b * impulse);
        }
        self.is_begun = false;
    }
}

impl<S: State, D: Dynamics, P: Stepper<S>> Holding for Integrated<'_, S, D, P> {
    fn put_on(&mut self, stops: &[usize]) -> Result<()> {
        self.move_onto(stops)?;
        self.evaluate_gaps()
    }

    fn enter(&mut self, regime: &Regime) -> Result<()> {
        let is_new = self.regime != *regime;
        self.regime.clone_from(regime);
        let stops = regime.constrained();
        self.take_force_guards();
        self.settle()?;
        self.enter_places();
        if is_new {
            let held: Vec<&Surface> = stops.iter().map(|&i| &self.contacts[i].surface).collect();
            let is_moving = stops.iter().any(|&i| self.contacts[i].motion.is_some());
            let is_bound = (0..self.contacts.len()).map(|stop| {
                let contact = &self.contacts[stop];
                let can_move = is_moving || contact.motion.is_some();
                Ok(stops.contains(&stop) || (!can_move && contact.surface.is_bound_by(&held)?))
            });
            self.is_bound = is_bound.collect::<Result<_>>()?;
            let is_unwatched = self.is_bound.iter().enumerate();
            // A place goes back to a body that cannot move, too.
            let relaxes = |own: usize| self.places_back.of(own).is_some();
            let is_unwatched =
                is_unwatched.map(|(own, bound)| *bound && !relaxes(own) || !self.watches_gap(own));
            self.is_unwatched = is_unwatched.collect();
        }
        self.evaluate_gaps()
    }

    fn set_places(&mut self, places: &[(usize, f64)]) {
        let law = |element: usize| self.contacts.get(element).map(|own| &own.law);
        self.places_back.put(law, places.iter().copied());
    }

    fn complete_chatter(
        &mut self,
        stops: &[usize],
        span: f64,
        recorder: &mut dyn Recorder,
    ) -> Result<()> {
        self.complete(stops, span, recorder)
    }

    fn record_chatter(&mut self, stop: usize, recorder: &mut dyn Recorder) -> Result<()> {
        recorder.begin_segment(SegmentKind::Chatter, &Regime::holding([stop]));
        self.record_no_step(None, recorder);
        Ok(())
    }
}

impl<S: State, D: Dynamics, P: Stepper<S>> Present for Integrated<'_, S, D, P> {
    fn clock(&self) -> Clock {
        self.clock
    }

    fn set_time(&mut self, t: f64) {
        self.clock = self.clock.at(t);
        self.is_begun = false;
    }

    fn phase(&self) -> f64 {
        wrapped(self.clock.angle() + self.phase)
    }

    fn breaks(&self) -> &[f64] {
        &self.breaks
    }

    fn physical(&self) -> PhysicalState {
        parted(self.x.slice())
    }

    fn work_of_flight(&self) -> usize {
        STEPS_OF_SHORT_FLIGHT * self.n().pow(2)
    }
}
