//! A cache kept with a scene or a linear system: what other layers make of it (`flow/timed_scene.rs`, `modal/form.rs`), made once.

use std::any::Any;
use std::fmt;
use std::sync::{Arc, OnceLock};

/// A place for one thing that follows from its owner and from nothing else. Copies of the owner share it; owners that differ have places
/// of their own, and places are no difference between owners.
#[derive(Clone, Default)]
pub(crate) struct Derived(Arc<OnceLock<Arc<dyn Any + Send + Sync>>>);

impl Derived {
    /// The value that was made before, or one that is made now. A value of another type than the first one is made each time.
    ///
    /// # Errors
    /// Errors of making the value; nothing is kept then.
    pub fn or_made<T: Any + Send + Sync, E>(
        &self,
        make: impl FnOnce() -> Result<T, E>,
    ) -> Result<Arc<T>, E> {
        if let Some(known) = self.0.get().cloned().and_then(|any| any.downcast().ok()) {
            return Ok(known);
        }
        let made = Arc::new(make()?);
        // If two threads made it at the same time, one value is kept.
        let _ = self.0.set(Arc::clone(&made) as Arc<dyn Any + Send + Sync>);
        Ok(made)
    }
}

impl fmt::Debug for Derived {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let state = if self.0.get().is_some() {
            "made"
        } else {
            "not made"
        };
        f.write_str(state)
    }
}

impl PartialEq for Derived {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    #[test]
    fn what_is_made_once_is_shared_by_copies_and_an_error_is_not_kept() {
        let place = Derived::default();
        assert_eq!(place.or_made(|| Err::<u32, _>("none")).unwrap_err(), "none");
        let made = place.or_made(|| Ok::<u32, Infallible>(3)).expect("made");
        let copy = place.clone();
        let again = copy
            .or_made(|| Ok::<u32, Infallible>(4))
            .expect("made before");
        assert!(Arc::ptr_eq(&made, &again) && *again == 3);
        let other = copy
            .or_made(|| Ok::<u64, Infallible>(5))
            .expect("of another type");
        assert_eq!(*other, 5);
    }
}
