//! Contacts along one step with stops whose gaps have a bound on their curvature: the motion on the step, and the search that is
//! certain along it (`contact/certified.rs`).

use super::scene::Integrated;
use crate::contact::certified::{Certified, Effort, first_contact};
use crate::contact::curvature::BoundedGap;
use crate::contact::first_root::{FirstEvent, FirstRoot};
use crate::contact::polynomial::{EndValues, Quintic};
use crate::contact::step_path::StepPath;
use crate::error::Result;
use crate::flow::steps::{DenseOutput, State, Stepper};
use crate::model::Dynamics;
use std::sync::Arc;

/// Coefficients of a cubic, that of the collocation of implicit steps.
const CUBIC: usize = 4;
/// Times as many places as a gap bends for that are worth a word, where they are no fewer than some.
const LOOSE: f64 = 32.0;
const NOTICED_PLACES: usize = 1 << 12;
/// Places along one gap, looked at with so loose a bound, that a run takes at the most, as far as what is behind tells.
const MOST_PLACES: f64 = (1u64 << 22) as f64;

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
            let is_low = |c: &Vec<f64>| c.iter().skip(CUBIC).all(|c| *c == 0.0);
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
            efforts,
        } = first_contact(&gaps, &path, until, &mut self.sought_touches)?;
        for (effort, (stop, _)) in efforts.into_iter().zip(&self.sought) {
            self.n_gap_evaluations += effort.places;
            self.efforts[*stop] = self.efforts[*stop].with(effort);
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
        let effort = self.efforts[stop];
        let began = self.began.time();
        let gone = (self.clock.time() + searched - began) / (end - began);
        effort.excess() > LOOSE && effort.places as f64 > MOST_PLACES * gone
    }

    /// What is said of stops whose bounds made their searches long.
    pub(super) fn long_searches(&self) -> String {
        let is_long = |(stop, effort): &(usize, &Effort)| {
            let is_nonlinear = self.contacts[*stop].surface.is_nonlinear();
            is_nonlinear && effort.places > NOTICED_PLACES && effort.excess() > LOOSE
        };
        let searched = self.efforts.iter().enumerate();
        let Some((stop, effort)) = searched.filter(is_long).max_by_key(|(_, e)| e.places) else {
            return String::new();
        };
        format!(
            "; with its `curvature` the search for contacts with stop {stop} looked at {} places, {:.0} times as many as it bends for \
             along the motion: give a closer bound, or units in which the coordinates of its gap are of one size",
            effort.places,
            effort.excess()
        )
    }
}
