//! Step-size control (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, sections II.4 and IV.2): the
//! PI controller, the first step, the test for stiffness.

use crate::tolerance::{
    EULER_STEP_PART, FIRST_STEP_OF_REST, LEAST_SCALED_ERROR, LEAST_STEP_ERROR, NO_RATE,
    SMALL_FIRST_STEP, SMALL_STATE, SOUND_STEPS, STEP_SAFETY, STIFF_STEPS,
};

/// How the length of the steps of a method follows from their errors.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepControl {
    /// Order of the error in the step.
    pub order: u32,
    /// Weight of the error before.
    pub beta: f64,
    /// A step changes at most by these factors.
    pub least: f64,
    pub most: f64,
    /// A step that could grow by less than this factor stays as it is: what it was made with can be used again.
    pub kept_below: f64,
}

/// The verdict on one trial step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepVerdict {
    pub is_accepted: bool,
    /// The step to take next, or to try again.
    pub next: f64,
}

/// A PI controller and a test for stiffness.
#[derive(Debug, Clone)]
pub(crate) struct Controller {
    /// Logarithm of the error of the step before.
    last_error: f64,
    was_rejected: bool,
    stiff: u32,
    sound: u32,
    /// Whether the motion was found stiff.
    pub is_stiff: bool,
}

impl Default for Controller {
    fn default() -> Self {
        Self {
            last_error: LEAST_STEP_ERROR.ln(),
            was_rejected: false,
            stiff: 0,
            sound: 0,
            is_stiff: false,
        }
    }
}

impl Controller {
    /// Judges a step of length h by its error in units of the tolerance; an error that is no number is a rejection.
    #[allow(
        clippy::inline_always,
        reason = "the control of a method is known when its steps are compiled"
    )]
    #[inline(always)]
    pub fn judge(&mut self, control: StepControl, h: f64, error: f64) -> StepVerdict {
        let StepControl {
            order,
            beta,
            least,
            most,
            kept_below,
            ..
        } = control;
        let exponent = 1.0 / f64::from(order) - 0.75 * beta;
        if error <= 1.0 {
            let size = error.max(LEAST_SCALED_ERROR).ln();
            let most = if self.was_rejected { 1.0 } else { most };
            let factor = STEP_SAFETY * (beta * self.last_error - exponent * size).exp();
            let factor = factor.clamp(least, most);
            let is_kept = factor > 1.0 && factor < kept_below;
            let factor = if is_kept { 1.0 } else { factor };
            self.last_error = size.max(LEAST_STEP_ERROR.ln());
            self.was_rejected = false;
            return StepVerdict {
                is_accepted: true,
                next: h * factor,
            };
        }
        self.was_rejected = true;
        let factor = if error.is_finite() {
            (STEP_SAFETY / error.powf(exponent)).clamp(least, STEP_SAFETY)
        } else {
            least
        };
        StepVerdict {
            is_accepted: false,
            next: h * factor,
        }
    }

    /// Counts a step, which stability limits or does not.
    #[inline]
    pub fn note_stiffness(&mut self, is_limited: bool) {
        if is_limited {
            self.sound = 0;
            self.stiff += 1;
            self.is_stiff |= self.stiff == STIFF_STEPS;
        } else {
            self.sound += 1;
            if self.sound == SOUND_STEPS {
                self.stiff = 0;
            }
        }
    }
}

/// A first step from the sizes of the state and its rate, in units of the tolerance, and from those of the second
/// derivative after the trial step that [`trial_step`] gives; `order` is that of the error.
pub(crate) fn first_step(order: u32, trial: f64, rate: f64, second: f64) -> f64 {
    let largest = rate.max(second);
    let h = if largest <= NO_RATE {
        (trial * FIRST_STEP_OF_REST).max(SMALL_FIRST_STEP)
    } else {
        (EULER_STEP_PART / largest).powf(1.0 / f64::from(order))
    };
    h.min(100.0 * trial)
}

/// A small step in which an Euler step moves the state by a hundredth of its size.
pub(crate) fn trial_step(state: f64, rate: f64) -> f64 {
    if state < SMALL_STATE || rate < SMALL_STATE {
        SMALL_FIRST_STEP
    } else {
        EULER_STEP_PART * state / rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONTROL: StepControl = StepControl {
        order: 5,
        beta: 0.04,
        least: 0.2,
        most: 10.0,
        kept_below: 1.2,
    };

    #[test]
    fn steps_shrink_when_rejected_and_grow_when_accurate() {
        let mut control = Controller::default();
        let bad = control.judge(CONTROL, 1.0, 32.0);
        assert!(!bad.is_accepted && bad.next < 0.55 && bad.next > 0.4);
        let nan = control.judge(CONTROL, 1.0, f64::NAN);
        assert!(!nan.is_accepted && nan.next == 0.2);
        // Right after a rejection a step does not grow.
        assert!(control.judge(CONTROL, 1.0, 1e-3).next <= 1.0);
        assert!(control.judge(CONTROL, 1.0, 1e-3).next > 1.0);
        assert!(control.judge(CONTROL, 1.0, 0.0).next <= 10.0);
    }

    #[test]
    fn a_step_that_would_grow_little_is_kept() {
        let mut control = Controller::default();

        let grown = |error: f64| Controller::default().judge(CONTROL, 1.0, error).next;
        assert_eq!(grown(0.05), 1.0);
        assert!(grown(0.01) > 1.2 && grown(0.9) < 1.0);
        assert!(control.judge(CONTROL, 2.0, 0.05).next == 2.0);
    }

    #[test]
    fn stiffness_is_said_after_fifteen_limited_steps() {
        let mut control = Controller::default();
        for step in 0..20 {
            control.note_stiffness(true);
            assert_eq!(control.is_stiff, step >= 14);
        }
        let mut sound = Controller::default();
        for step in 0..1000 {
            sound.note_stiffness(step % 8 == 0);
        }
        assert!(!sound.is_stiff);
    }
}
