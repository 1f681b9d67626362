//! Contacts along one step with stops whose gaps have a bound on their curvature: the motion on the step, and the search that is
//! certain along it (`event/certified.rs`).

use super::scene::Integrated;
use crate::error::Result;
use crate::event::certified::{Certified, SearchCost, first_contact};
use crate::event::curvature::BoundedGap;
use crate::event::first_root::{FirstEvent, FirstRoot};
use crate::event::polynomial::{EndValues, Quintic};
use crate::event::step_path::StepPath;
use crate::flow::steps::{DenseOutput, State, Stepper};
use crate::model::Dynamics;
use crate::tolerance::{LOOSE_CURVATURE, NOTICED_SEARCH_POINTS};
use std::sync::Arc;

/// Number of coefficients of a cubic, the collocation polynomial of implicit steps. [exact]
const CUBIC_SIZE: usize = 4;
/// Evaluations along one gap with a loose bound that a run may take, extrapolated from the part of it that is done. [work]
const MOST_RUN_SEARCH_POINTS: f64 = (1u64 << 22) as f64;

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// The motion on the step last taken: that of the quintics through both its ends where they are as near to it as the dense output, or
    /// that is of lower degree, as it has neither the speeds nor the accelerations of the ends; else the dense output, which is off by the
    /// tolerance. Of quintics the error is what they differ by from the dense output half-way.
    pub(super) fn step_path<E: Dynamics>(&mut self, dynamics: &E, h: f64) -> Result<StepPath> {
        let n = self.n();
        let dense = self.dense(dynamics, h)?;
        let (start, end) = (self.x.slice(), self.stepper.end().slice());
        let allowed = |i: usize| {
            self.tolerance.absolute + self.tolerance.relative * start[i].abs().max(end[i].abs())
        };
        if !P::HAS_QUINTIC {
            let powers: Vec<_> = (0..n).map(|i| dense.powers(i)).collect();
            let is_low = |c: &Vec<f64>| c.iter().skip(CUBIC_SIZE).all(|c| *c == 0.0);
            if !powers.iter().all(is_low) {
                return Ok(StepPath::new(powers, (0..n).map(allowed).collect()));
            }
        }
        let rates = [self.stepper.start_rate(), self.stepper.end_rate()].map(State::slice);
        let mut middle = S::zeros(2 * n);
        dense.state(0.5 * h, middle.slice_mut());
        let (mut all, mut errors) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for i in 0..n {
            let known = |x: &[f64], rate: &[f64]| [x[i], x[n + i], rate[n + i]];
            let ends = (known(start, rates[0]), known(end, rates[1]));
            let quintic = Quintic::new(&EndValues::new(ends.0, ends.1, h, 0));
            let differs = (quintic.value(0.5) - middle.slice()[i]).abs();
            errors.push(if P::HAS_QUINTIC {
                differs
            } else {
                differs.max(allowed(i))
            });
            all.push(quintic.powers().to_vec());
        }
        Ok(StepPath::new(all, errors))
    }

    /// The first contact along the step last taken, if that of the stops sought by the bound on their curvature comes before one that is
    /// known.
    #[cold]
    pub(super) fn certify<E: Dynamics>(
        &mut self,
        dynamics: &E,
        known: FirstEvent,
        h: f64,
    ) -> Result<FirstEvent> {
        let path = self.step_path(dynamics, h)?;
        let contacts = Arc::clone(&self.contacts);
        let gap = |&(stop, order): &(usize, usize)| {
            let contact = &contacts[stop];
            contact.surface.curvature().map(|curvature| BoundedGap {
                contact,
                watched: self.watched_now(stop),
                curvature,
                order,
                departed: self.departed(stop, order),
                begun: self.moment(),
                h,
                tolerance: self.tolerance,
                known: 0.0,
            })
        };
        let gaps: Vec<_> = self.sought.iter().filter_map(gap).collect();
        let until = known.root.at().min(1.0);
        self.sought_touches.clear();
        let Certified {
            first,
            doubt,
            costs,
        } = first_contact(&gaps, &path, until, &mut self.sought_touches)?;
        for (cost, (stop, _)) in costs.into_iter().zip(&self.sought) {
            self.n_gap_evaluations += cost.places;
            self.search_costs[*stop] = self.search_costs[*stop].with(cost);
        }
        for touch in std::mem::take(&mut self.sought_touches) {
            self.touches.clear();
            self.touches.push((touch.x, -touch.depth));
            self.note_touches(self.sought[touch.gap].0, h);
        }
        if first.root == FirstRoot::None {
            return Ok(known);
        }
        let stop = self.sought[first.stop].0;
        self.doubt = doubt.map(|doubt| (stop, doubt));
        Ok(FirstEvent { stop, ..first })
    }

    /// Whether the searches along the gap of a stop, with a bound far above what it bends by, would go on too long until the end of the
    /// run, at the rate of what is behind and of a time beyond that has been searched.
    #[cold]
    pub(super) fn is_hopeless(&self, stop: usize, searched: f64, end: f64) -> bool {
        let cost = self.search_costs[stop];
        let began = self.began.time();
        let gone = (self.clock.time() + searched - began) / (end - began);
        cost.excess() > LOOSE_CURVATURE && cost.places as f64 > MOST_RUN_SEARCH_POINTS * gone
    }

    /// What is said of stops whose bounds made their searches long.
    pub(super) fn long_searches(&self) -> String {
        let is_long = |(stop, cost): &(usize, &SearchCost)| {
            let is_nonlinear = self.contacts[*stop].surface.is_nonlinear();
            is_nonlinear && cost.places > NOTICED_SEARCH_POINTS && cost.excess() > LOOSE_CURVATURE
        };
        let searched = self.search_costs.iter().enumerate();
        let Some((stop, cost)) = searched.filter(is_long).max_by_key(|(_, e)| e.places) else {
            return String::new();
        };
        format!(
            "; with its `curvature` the search for contacts with stop {stop} derivatives_at at {} places, {:.0} times as many as it bends for \
             along the motion: give a closer bound, or units in which the coordinates of its gap are of one size",
            cost.places,
            cost.excess()
        )
    }
}
