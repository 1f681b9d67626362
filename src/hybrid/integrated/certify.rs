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

impl<S: State, D: Dynamics, P: Stepper<S>> Integrated<'_, S, D, P> {
    /// The motion on the step last taken: that of the quintics through both its ends where they are as near to it as the dense output,
    /// whose difference to them half-way is then its error; else the dense output, which is off by the tolerance.
    pub(super) fn step_path<E: Dynamics>(&mut self, dynamics: &E, h: f64) -> Result<StepPath> {
        let n = self.n();
        let dense = self.dense(dynamics, h)?;
        if !P::HAS_QUINTIC {
            let allowed = |(q, end): (&f64, &f64)| {
                self.tolerance.absolute + self.tolerance.relative * q.abs().max(end.abs())
            };
            let ends = self.x.slice()[..n].iter().zip(self.stepper.end().slice());
            let squares = ends.map(allowed).map(|error| error * error);
            let error = squares.sum::<f64>().sqrt();
            return Ok(StepPath::new(
                (0..n).map(|i| dense.powers(i)).collect(),
                error,
            ));
        }
        let mut middle = S::zeros(2 * n);
        dense.state(0.5 * h, middle.slice_mut());
        let (start, end) = (self.x.slice(), self.stepper.end().slice());
        let (rate, end_rate) = (
            self.stepper.start_rate().slice(),
            self.stepper.end_rate().slice(),
        );
        let mut square = 0.0;
        let quintic = |i: usize| {
            let known = |x: &[f64], rate: &[f64]| [x[i], x[n + i], rate[n + i]];
            let ends = EndValues::new(known(start, rate), known(end, end_rate), h, 0);
            let quintic = Quintic::new(&ends);
            square += (quintic.value(0.5) - middle.slice()[i]).powi(2);
            quintic.powers().to_vec()
        };
        let powers = (0..n).map(quintic).collect();
        Ok(StepPath::new(powers, square.sqrt()))
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
