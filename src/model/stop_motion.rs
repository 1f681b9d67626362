//! How a stop moves by itself (theory 12): what is added to its clearance, its position or its gap.

use crate::error::{Error, Result};
use crate::model::forcing::{Forcing, Harmonic};
use crate::model::fourier::Fourier;
use crate::model::load::Load;
use crate::model::signal::Signal;
use crate::tolerance::SMOOTH_MOTION;

/// A motion of a stop: harmonic, periodic, or after a signal whose derivative is continuous.
///
/// # Examples
/// A table that shakes under a ball, and a blow that lifts it:
/// ```
/// use nalgebra::{dmatrix, dvector};
/// use vibroimpact::{Harmonic, Signal, Stop, StopMotion};
/// let shaken = StopMotion::harmonic(Harmonic::new(dvector![0.01.into()], 20.0, 0.0)?)?;
/// let table = Stop::new(0, 0.0, 0.8)?.with_motion(Some(shaken));
/// // t^2 (1 - t)^2 between 0 and 1
/// let lift = Signal::pieces(&[0.0, 1.0], &dmatrix![1.0; -2.0; 1.0; 0.0; 0.0])?;
/// let lifted = table.with_motion(Some(StopMotion::signal(lift)?));
/// # let _ = lifted;
/// # Ok::<(), vibroimpact::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct StopMotion(pub(super) Forcing);

impl StopMotion {
    /// A harmonic motion `Re(a e^{i (w t + phase)})`.
    ///
    /// # Errors
    /// An amplitude of more than one number.
    pub fn harmonic(motion: Harmonic) -> Result<Self> {
        let count = motion.amplitude().len();
        one_number(count, || format!("({count},)"))?;
        Ok(Self(motion.into()))
    }

    /// A periodic motion of several harmonics about a mean.
    ///
    /// # Errors
    /// Amplitudes of more than one number each.
    pub fn periodic(motion: Fourier) -> Result<Self> {
        let (count, n) = (motion.n_harmonics(), motion.n_dof());
        one_number(n, || format!("({count}, {n})"))?;
        Ok(Self(motion.into()))
    }

    /// A motion that follows a signal. Where the signal does not begin, or end, at rest at zero, runs must stay within it.
    ///
    /// # Errors
    /// A signal that jumps, or whose slope does, between its pieces: a stop that is struck by its own motion has no law.
    pub fn signal(motion: Signal) -> Result<Self> {
        if let Some(t) = motion.first_kink(SMOOTH_MOTION) {
            let rule = "value and slope must be continuous: take a spline, not straight lines between samples";
            return Err(Error::bad_value(
                "motion",
                format!("not smooth at t = {t}"),
                rule,
            ));
        }
        Load::new(0, motion).map(|load| Self(load.into()))
    }

    /// The motion as a harmonic, a periodic force, or a load, of one coordinate.
    pub fn as_forcing(&self) -> &Forcing {
        &self.0
    }

    /// Whether it is not zero at all times.
    pub(crate) fn moves(&self) -> bool {
        self.0.own_signal().is_some_and(|signal| !signal.is_zero())
            || self.0.own_periodic().is_some_and(|f| {
                let mean = f.mean().is_some_and(|mean| mean[0] != 0.0);
                mean || f.amplitudes().iter().any(|a| a[0].norm() > 0.0)
            })
    }

    /// A motion again of its [`as_forcing`](Self::as_forcing), changed.
    pub(super) fn of_forcing(forcing: Forcing) -> Self {
        Self(forcing)
    }

    /// The same motion the other way.
    pub(crate) fn opposite(&self) -> Self {
        Self(self.0.scaled(-1.0).expect("finite as it was"))
    }

    /// Whether a run over a span of time leaves a signal that is not at rest at zero there; the span of the signal then.
    pub(crate) fn is_left_by(&self, (start, end): (f64, f64)) -> Option<(f64, f64)> {
        let signal = self.0.own_signal()?;
        let (from, to) = signal.span();
        let [begins, ends] = signal.rests_at_ends(SMOOTH_MOTION);
        let is_left = (start < from && !begins) || (end > to && !ends);
        is_left.then_some((from, to))
    }
}

fn one_number(found: usize, shape: impl Fn() -> String) -> Result<()> {
    if found == 1 {
        return Ok(());
    }
    let expected = "one number: a stop moves along its normal";
    Err(Error::bad_shape("motion.amplitude", shape(), expected))
}
