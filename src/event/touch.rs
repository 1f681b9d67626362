//! What the lowest value of a gap \[m\] says (theory 8, "Touches"): below minus its rounding the stop is passed, and there is an impact,
//! however slow; within the rounding it is touched; above it nothing happens. The user's tolerances do not enter.
//!
//! Of runs the rounding is [`TERM_ROUNDINGS`] of the terms of the gap. Exact flights (`GapRow::rounding` in `flow/gap_row.rs`) take the
//! clearance and the position along the normal as its two terms, and where that is more [`SUM_ROUNDINGS`](crate::tolerance::SUM_ROUNDINGS)
//! of the sum of the modes. Of orbits it is [`ORBIT_MARGIN`] of the size of the motion, where they are integrated [`INTEGRATED_MARGIN`]
//! (`orbit/verdict`); an instant of an orbit with no approach faster than that margin times the rate of the motion is a touch
//! (`judge_impacts` in `orbit/verdict/judge.rs`).
//!
//! In steps the gap is interpolated. A lowest value nearer to zero than that is known to is undecided, and the step is taken again so that
//! it ends there: then the value is that of the motion. After [`MOST_STEP_HALVINGS`](crate::tolerance::MOST_STEP_HALVINGS) of these it
//! counts as no contact, unless the search gave up with a reason: then the run ends as uncertain (`hybrid/integrated/steps.rs`).
//!
//! [`TERM_ROUNDINGS`]: crate::tolerance::TERM_ROUNDINGS
//! [`ORBIT_MARGIN`]: crate::tolerance::ORBIT_MARGIN
//! [`INTEGRATED_MARGIN`]: crate::tolerance::INTEGRATED_MARGIN

/// What a gap does where it is lowest.
pub(super) enum Bottom {
    Open,
    Touch,
    Passed,
    Undecided,
}

impl Bottom {
    /// By the lowest value of a gap, known to its rounding.
    pub fn of(gap: f64, rounding: f64) -> Self {
        if gap < -rounding {
            Self::Passed
        } else if gap <= rounding {
            Self::Touch
        } else {
            Self::Open
        }
    }

    /// The same of a gap along a step; `doubt` is the distance from zero within which its value says nothing, where it is known clearly
    /// worse than to its rounding.
    pub fn in_step(gap: f64, rounding: f64, doubt: Option<f64>) -> Self {
        if doubt.is_some_and(|doubt| gap.abs() <= doubt) {
            Self::Undecided
        } else {
            Self::of(gap, rounding)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Bottom::{self, Open, Passed, Touch, Undecided};

    #[test]
    fn within_rounding_is_a_touch_and_within_doubt_nothing_is_known() {
        let gaps = [-2.0, -1.0, 0.0, 1.0, 2.0];
        assert!(matches!(
            gaps.map(|gap| Bottom::of(gap, 1.0)),
            [Passed, Touch, Touch, Touch, Open]
        ));
        assert!(matches!(
            gaps.map(|gap| Bottom::in_step(gap, 0.5, Some(1.0))),
            [Passed, Undecided, Undecided, Undecided, Open]
        ));
        assert!(matches!(Bottom::of(f64::NAN, 1.0), Open));
    }
}
