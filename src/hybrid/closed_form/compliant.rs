//! What elements that give way do to a linear scene in motion: the accelerations of the gaps under their forces, their guards, the places of
//! those that relax.

use super::compliant_elements::GapPull;
use super::system::ClosedForm;
use crate::error::Result;
use crate::flow::{GuardDerivatives, LinearFlow, RegimeMotion, derivatives_at};
use crate::hybrid::system::{Gaps, Present};
use crate::law::{ElementState, Guard, GuardKind, LinearForce, Regime};
use crate::modal::ModalState;
use crate::quantity::larger;
use crate::tolerance::GAP_ROUNDING;

impl<F: LinearFlow> ClosedForm<'_, F> {
    /// Takes the elements of a regime that are neither free nor held.
    pub(super) fn enter_compliant(&mut self, regime: &Regime) -> Result<()> {
        if regime.others().is_empty() {
            self.compliant.forget();
            return Ok(());
        }
        self.compliant.motion = Some(self.motion_in(&regime.holding_instead(&[]))?);
        self.compliant.places.keep(regime);
        for element in self.compliant.places.begun(regime) {
            let (law, gap) = (&self.scene.geometry.laws[element], self.gap(element).gap);
            self.compliant.places.begin(law, element, gap);
        }
        Ok(())
    }

    /// The forces of the elements that are pressed.
    pub(super) fn pushes(&self) -> impl Iterator<Item = (usize, LinearForce)> + '_ {
        let motion = self.compliant.motion.iter();
        motion.flat_map(|motion| self.scene.geometry.forces(&motion.regime))
    }

    /// The state in the modes of a regime, with the places of the elements that relax.
    fn reduced(&self, motion: &RegimeMotion) -> ModalState {
        let ((q, v), at) = (self.physical(), self.moment());
        motion.with_places(motion.reduce(&q, &v, at), |element| {
            self.compliant.places.place(element)
        })
    }

    /// The acceleration of a gap, where it is not the free one.
    #[inline]
    pub(super) fn pull(&self, stop: usize) -> Option<&GapPull> {
        let motion = self.compliant.motion.as_ref()?;
        let known = &self.compliant.pulls[stop];
        known.get_or_init(|| self.pull_in(motion, stop)).as_ref()
    }

    /// The acceleration of a gap beside the elements that are pressed; `None` of one that cannot change.
    #[cold]
    fn pull_in(&self, motion: &RegimeMotion, stop: usize) -> Option<GapPull> {
        let mut own = motion.guards().filter(|own| own.0.element == stop);
        let (guard, quantity) = own.find(|own| own.0.is_seat())?;
        let sign = if guard.kind == GuardKind::Gap {
            1.0
        } else {
            -1.0
        };
        let derivatives = motion.derivatives(quantity, (&self.reduced(motion), self.moment()));
        let [_, _, [bend, _], [jerk, _]] = derivatives.derivatives;
        Some(GapPull {
            acceleration: sign * bend,
            jerk: sign * jerk,
            size: derivatives.bend_size,
            lost: derivatives.bend_lost,
        })
    }

    /// A guard of the present regime; `None` of one that cannot change.
    pub(super) fn present_guard(&self, guard: Guard) -> Option<GuardDerivatives> {
        let at = self.moment();
        let Some(motion) = &self.regime_motion else {
            let state = self.modal_state(&self.state);
            let gap = self.scene.gap(guard.element);
            return Some(derivatives_at(self.flow, &gap, (&state, at)).derivatives);
        };
        let (_, quantity) = motion.guards().find(|own| own.0 == guard)?;
        let mut derivatives = motion
            .derivatives(quantity, (&self.reduced(motion), at))
            .derivatives;
        // The state has the rounding of the modes in which it is kept, whatever it is in those of the regime.
        let (gap, speed) = (
            self.rounding(guard.element),
            GAP_ROUNDING * self.speed_size(guard.element),
        );
        let law = self.scene.geometry.laws[guard.element].by_state();
        let has_own_force = matches!(guard.kind, GuardKind::Push | GuardKind::Pull);
        let unknown = match law.force(ElementState::Pressed) {
            // Forces that hold are sums of the state, as their roundings say.
            _ if matches!(guard.kind, GuardKind::Force | GuardKind::Excess) => [0.0; 2],
            Some(force) if has_own_force => [
                force.size_at(gap, speed) - force.preload,
                force.stiffness * speed,
            ],
            _ => [gap, speed],
        };
        for (derivative, unknown) in derivatives.iter_mut().zip(unknown) {
            derivative[1] = larger(derivative[1], unknown);
        }
        Some(derivatives)
    }
}
