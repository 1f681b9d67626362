//! Stops that relax and are met before they are back: the condition of such an instant knows where the stop was left, some instants before
//! (theory 22).

use crate::error::Result;
use crate::hybrid::{ScaledUnits, Timed};
use crate::law::{ElementState, Relaxation};
use crate::orbit::shooting::closure::{Shooting, ShootingState};
use nalgebra::{DMatrix, DVector};

/// An instant at which a stop is met that relaxes since another instant.
pub(super) struct Meeting {
    element: usize,
    relaxation: Relaxation,
    /// The instant at which it was left, and whether that is one of the period before.
    left: usize,
    is_before: bool,
}

impl Shooting<'_> {
    /// What instant k remembers.
    pub(super) fn meeting(&self, k: usize) -> Option<Meeting> {
        let element = self.stages.stage(k).transition.met_again()?;
        let law = self.motion.contact_law(element).by_state();
        let relaxation = law.relaxation(ElementState::Relaxing)?;
        let leaves =
            |own: &usize| self.stages.stage(*own).transition.left_to_relax() == Some(element);
        let count = self.stages.len();
        let left = (1..=count).map(|back| k + count - back).find(leaves)?;
        Some(Meeting {
            element,
            relaxation,
            left: left % count,
            is_before: left < count,
        })
    }

    /// How far the body is from the stop that it meets at an instant, scaled, and the derivatives by the unknowns: of the state there, and of
    /// the states and the starts of all flights.
    pub(super) fn distance(
        &self,
        own: &Meeting,
        (state, units): (&ShootingState, &ScaledUnits),
        y: &Timed,
        (states, starts): (&[DMatrix<f64>], &[DVector<f64>]),
    ) -> Result<(f64, DVector<f64>)> {
        let (from, count) = (own.left, state.states.len());
        let here = self.motion.gap(own.element, y.time, &y.state)?;
        let there = self
            .motion
            .gap(own.element, state.starts[from], &state.states[from])?;
        let (mut elapsed, mut unknowns) = (y.time - state.starts[from], y.deviations.ncols());
        if own.is_before {
            elapsed += state.times[count] - state.times[0];
        }
        let place = own.relaxation.after(-there.gap, elapsed);
        let scale = 1.0 / (here.gradient.amax() * units.position);
        let value = (here.gap + place) * scale;
        let Some((deviations, delays)) = states.get(from).zip(starts.get(from)) else {
            return Ok((value, DVector::zeros(unknowns)));
        };
        unknowns = unknowns.max(deviations.ncols());
        let fitted = |row: DVector<f64>| row.resize_vertically(unknowns, 0.0);
        let left = own.relaxation.left(elapsed);
        let mut later = fitted(y.delays.clone()) - fitted(delays.clone());
        if own.is_before {
            let columns = deviations.ncols() - 1;
            later +=
                fitted(self.shift(count, columns, units)) - fitted(self.shift(0, columns, units));
        }
        let row = fitted(here.timed_deviations(&y.deviations, &y.delays))
            - fitted(there.timed_deviations(deviations, delays)) * left
            + later * own.relaxation.speed(place);
        Ok((value, row * scale))
    }
}
