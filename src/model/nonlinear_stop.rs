//! Stops with any gap `h(q) >= 0`, given by the gap and its gradient: any type that implements one trait.

use crate::error::{Error, Result};
use crate::law::{IntoLaw, Law};
use crate::model::reaction::Reaction;
use crate::model::stop::Stop;
use crate::model::stop_motion::StopMotion;
use crate::quantity::{Restitution, finite_vector};
use nalgebra::DVector;
use std::any::Any;
use std::fmt;
use std::sync::Arc;

/// A gap and its gradient. The functions must be pure: the same q gives the same values.
///
/// An implementation reports a failure of its own by [`Error::function`]; values that are not finite are reported for it.
pub trait GapFunction: Any + Send + Sync {
    /// The gap h at q, twice continuously differentiable; negative inside the stop.
    ///
    /// # Errors
    /// Whatever the implementation cannot evaluate.
    fn gap(&self, q: &[f64]) -> Result<f64>;

    /// Writes the gradient of the gap at q.
    ///
    /// # Errors
    /// Whatever the implementation cannot evaluate.
    fn gradient(&self, q: &[f64], gradient: &mut [f64]) -> Result<()>;

    /// Whether another object is known to be the same function; one object is always equal to itself.
    fn equals(&self, other: &dyn GapFunction) -> bool {
        let _ = other;
        false
    }
}

/// Stop with any gap `h(q) >= 0`, given with its gradient; the normal towards it is `-grad h`.
///
/// Without a bound on its curvature the gradient is believed: with one that is not that of the gap a run may creep.
///
/// # Examples
/// A point in the plane that may not leave a circle:
/// ```
/// use vibroimpact::{GapFunction, NonlinearStop, Result};
/// struct Circle;
/// impl GapFunction for Circle {
///     fn gap(&self, q: &[f64]) -> Result<f64> {
///         Ok(1.0 - q[0].hypot(q[1]))
///     }
///     fn gradient(&self, q: &[f64], gradient: &mut [f64]) -> Result<()> {
///         let r = q[0].hypot(q[1]);
///         (gradient[0], gradient[1]) = (-q[0] / r, -q[1] / r);
///         Ok(())
///     }
/// }
/// let stop = NonlinearStop::new(Circle, 0.9)?;
/// assert_eq!(stop.gap(&[0.3, 0.4])?, 0.5);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
#[derive(Clone)]
pub struct NonlinearStop {
    function: Arc<dyn GapFunction>,
    pub(super) law: Law,
    curvature: Option<f64>,
    reaction: Reaction,
    motion: Option<StopMotion>,
}

impl fmt::Debug for NonlinearStop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NonlinearStop")
            .field("contact", &self.law)
            .field("curvature", &self.curvature)
            .field("reaction", &self.reaction)
            .field("motion", &self.motion)
            .finish_non_exhaustive()
    }
}

impl PartialEq for NonlinearStop {
    /// Functions are compared as objects, or as far as they know.
    fn eq(&self, other: &Self) -> bool {
        let is_same =
            Arc::ptr_eq(&self.function, &other.function) || self.function.equals(&*other.function);
        is_same
            && self.law == other.law
            && self.curvature == other.curvature
            && self.reaction == other.reaction
            && self.motion == other.motion
    }
}

impl NonlinearStop {
    /// A stop with the inertial reaction and no bound on the curvature of its gap; `contact` is the law of contact, or the restitution of a
    /// rigid stop.
    ///
    /// # Errors
    /// A restitution outside [0, 1].
    pub fn new(function: impl GapFunction, contact: impl IntoLaw) -> Result<Self> {
        Ok(Self {
            function: Arc::new(function),
            law: contact.into_law()?,
            curvature: None,
            reaction: Reaction::Inertia,
            motion: None,
        })
    }

    /// The same stop with a bound on the spectral norm of the gap's second derivative, over all positions met and a little inside the
    /// stop. With it the search for contacts is certain, whatever the length of a step; a run in which it cannot be ends with
    /// [`Status::Uncertain`](crate::Status::Uncertain). In the norm lengths and angles count alike: where the gap depends on both, a unit
    /// of length in which lengths are about one keeps the bound close, and the search short.
    ///
    /// # Errors
    /// A bound that is negative or not finite.
    pub fn with_curvature(mut self, curvature: f64) -> Result<Self> {
        if !curvature.is_finite() || curvature < 0.0 {
            let rule = "it bounds a norm: it must be finite and not negative";
            return Err(Error::bad_value("curvature", curvature, rule));
        }
        self.curvature = Some(curvature);
        Ok(self)
    }

    /// The same stop with the given reaction.
    ///
    /// # Errors
    /// A reaction direction that is not finite.
    pub fn with_reaction(mut self, reaction: Reaction) -> Result<Self> {
        if let Reaction::Direction(b) = &reaction {
            finite_vector("reaction", b, b.len())?;
        }
        self.reaction = reaction;
        Ok(self)
    }

    /// The same stop with a motion of its own, which is added to its gap; without where it is `None`.
    #[must_use]
    pub fn with_motion(mut self, motion: Option<StopMotion>) -> Self {
        self.motion = motion;
        self
    }

    /// The motion of its own.
    pub fn motion(&self) -> Option<&StopMotion> {
        self.motion.as_ref()
    }

    /// The functions as they were given.
    pub fn function(&self) -> &dyn GapFunction {
        &*self.function
    }

    /// The restitution coefficient; `None` of a stop that gives way.
    pub fn restitution(&self) -> Option<Restitution> {
        self.law.restitution()
    }

    /// The law of contact.
    pub fn contact(&self) -> &Law {
        &self.law
    }

    /// The bound on the gap's second derivative, if there is one.
    pub fn curvature(&self) -> Option<f64> {
        self.curvature
    }

    /// The reaction.
    pub fn reaction(&self) -> &Reaction {
        &self.reaction
    }

    /// The gap at q, but for a motion of its own.
    ///
    /// # Errors
    /// What the function reports; a value that is not finite.
    pub fn gap(&self, q: &[f64]) -> Result<f64> {
        let gap = self.function.gap(q)?;
        if gap.is_finite() {
            return Ok(gap);
        }
        Err(not_finite("gap", gap, q))
    }

    /// The gradient of the gap at q, shape `(n,)`.
    ///
    /// # Errors
    /// What the function reports; values that are not finite.
    pub fn gradient(&self, q: &[f64]) -> Result<DVector<f64>> {
        let mut gradient = DVector::zeros(q.len());
        self.function.gradient(q, gradient.as_mut_slice())?;
        match gradient.iter().find(|x| !x.is_finite()) {
            None => Ok(gradient),
            Some(x) => Err(not_finite("gradient", *x, q)),
        }
    }

    /// The stop that this one is near q = 0.
    pub(crate) fn linearise(&self, n: usize) -> Result<Stop> {
        let zero = vec![0.0; n];
        Stop::new(-self.gradient(&zero)?, self.gap(&zero)?, self.law.clone())?
            .with_reaction(self.reaction.clone())
            .map(|stop| stop.with_motion(self.motion.clone()))
    }
}

fn not_finite(name: &str, value: f64, q: &[f64]) -> Error {
    Error::bad_value(format!("{name} at q = {q:?}"), value, "it must be finite")
}
