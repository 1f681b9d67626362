//! Contacts along one step with stops whose gaps have a bound on their curvature: the motion on the step, and the search that is
//! certain along it (`contact/certified.rs`).

use super::scene::Integrated;
use crate::contact::certified::{Certified, first_contact};
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

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// The motion on the step last taken: that of the quintics through both its ends where they are as near to it as the dense output;
    /// else the dense output, which is off by the tolerance. Of quintics, and of a dense output of lower degree, the error is what
    /// they differ by half-way.
    pub(super) fn step_path<E: Dynamics>(&mut self, dynamics: &E, h: f64) -> Result<StepPath> {
        let n = self.n();
        let dense = self.dense(dynamics, h)?;
        let (start, end) = (self.x.slice(), self.stepper.end().slice());
        let rates = [self.stepper.start_rate(), self.stepper.end_rate()].map(State::slice);
        let quintic = |i: usize| {
            let known = |x: &[f64], rate: &[f64]| [x[i], x[n + i], rate[n + i]];
            Quintic::new(&EndValues::new(
                known(start, rates[0]),
                known(end, rates[1]),
                h,
                0,
            ))
        };
        let mut middle = S::zeros(2 * n);
        dense.state(0.5 * h, middle.slice_mut());
        let differ = || {
            let misses = (0..n).map(|i| quintic(i).value(0.5) - middle.slice()[i]);
            misses.map(|miss| miss * miss).sum::<f64>().sqrt()
        };
        if P::HAS_QUINTIC {
            let powers = (0..n).map(|i| quintic(i).powers().to_vec()).collect();
            return Ok(StepPath::new(powers, differ()));
        }
        let powers: Vec<_> = (0..n).map(|i| dense.powers(i)).collect();
        let allowed = |(q, end): (&f64, &f64)| {
            self.tolerance.absolute + self.tolerance.relative * q.abs().max(end.abs())
        };
        let squares = start[..n].iter().zip(end).map(allowed).map(|x| x * x);
        let mut error = squares.sum::<f64>().sqrt();
        let is_low = |c: &Vec<f64>| c.iter().skip(CUBIC).all(|c| *c == 0.0);
        if powers.iter().all(is_low) {
            error = error.max(differ());
        }
        Ok(StepPath::new(powers, error))
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
            places,
        } = first_contact(&gaps, &path, until, &mut self.sought_touches)?;
        self.n_gap_evaluations += places;
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
}
