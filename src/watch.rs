//! Long computations ask from time to time whether to go on: often enough for a person who waits, seldom enough to cost
//! nothing.

use crate::error::{Error, Result};
use std::ops::ControlFlow;

/// Asked by a long computation whether to go on.
pub(crate) type GoOn<'a> = &'a mut dyn FnMut() -> ControlFlow<()>;

/// Work between two questions, in units of some nanoseconds: below a millisecond.
const WORK_PER_QUESTION: usize = 1 << 14;

/// `Error::Interrupted` where the answer is to break off.
pub(crate) fn stop_if(answer: ControlFlow<()>) -> Result<()> {
    match answer {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted),
    }
}

/// Counts the work done and asks when it has become enough.
pub(crate) struct Watch<'a> {
    go_on: GoOn<'a>,
    left: usize,
}

impl<'a> Watch<'a> {
    /// A watch that asks `go_on`.
    pub fn new(go_on: GoOn<'a>) -> Self {
        Self {
            go_on,
            left: WORK_PER_QUESTION,
        }
    }

    /// Some work was done: so many operations on a block of two unknowns.
    ///
    /// # Errors
    /// `Error::Interrupted` if the time has come to ask, and the answer is to break off.
    #[inline]
    pub fn work(&mut self, amount: usize) -> Result<()> {
        if amount < self.left {
            self.left -= amount;
            return Ok(());
        }
        self.look()
    }

    /// Asks now: for pieces of work that are long in themselves.
    ///
    /// # Errors
    /// `Error::Interrupted` if the answer is to break off.
    #[cold]
    pub fn look(&mut self) -> Result<()> {
        self.left = WORK_PER_QUESTION;
        stop_if((self.go_on)())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_watch_asks_once_for_so_much_work_and_passes_the_answer_on() {
        let mut asked = 0;
        let mut go_on = || {
            asked += 1;
            if asked < 3 {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        };
        let mut watch = Watch::new(&mut go_on);
        for _ in 0..3 * WORK_PER_QUESTION - 1 {
            assert_eq!(watch.work(1), Ok(()));
        }
        assert_eq!(watch.work(1), Err(Error::Interrupted));
        assert_eq!(asked, 3);
    }
}
