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

    /// The steps of a loop, each so much work as in [`Watch::work`].
    #[inline]
    pub fn steps(&mut self, work: usize) -> Steps<'_, 'a> {
        let work = work.max(1);
        Steps {
            left: self.left / work,
            work,
            watch: self,
        }
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

/// Counts the steps of a loop down to the next question: a number in a register. The watch knows of them when it ends.
pub(crate) struct Steps<'w, 'a> {
    watch: &'w mut Watch<'a>,
    work: usize,
    left: usize,
}

impl Steps<'_, '_> {
    /// A step begins.
    ///
    /// # Errors
    /// As [`Watch::work`].
    #[inline]
    pub fn begin(&mut self) -> Result<()> {
        if self.left == 0 {
            self.watch.look()?;
            self.left = WORK_PER_QUESTION / self.work;
            return Ok(());
        }
        self.left -= 1;
        Ok(())
    }
}

impl Drop for Steps<'_, '_> {
    #[inline]
    fn drop(&mut self) {
        self.watch.left = self.left * self.work;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_loops_count_as_their_work_does() {
        let asked = std::cell::Cell::new(0);
        let mut go_on = || {
            asked.set(asked.get() + 1);
            if asked.get() < 3 {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        };
        let mut watch = Watch::new(&mut go_on);
        let work = WORK_PER_QUESTION / 8;
        // Loops of three steps, and a loop of as many as there may be: a question at every ninth step.
        for _ in 0..4 {
            let mut steps = watch.steps(work);
            for _ in 0..3 {
                assert_eq!(steps.begin(), Ok(()));
            }
        }
        assert_eq!(asked.get(), 1);
        let mut steps = watch.steps(work);
        let begun = std::iter::repeat_with(|| steps.begin()).take_while(|done| *done == Ok(()));
        assert_eq!((begun.count(), asked.get()), (14, 3));
        // A step that is more work than lies between two questions asks each time.
        asked.set(0);
        let mut go_on = || {
            asked.set(asked.get() + 1);
            ControlFlow::Continue(())
        };
        let mut watch = Watch::new(&mut go_on);
        let mut steps = watch.steps(2 * WORK_PER_QUESTION);
        (0..5).for_each(|_| assert_eq!(steps.begin(), Ok(())));
        assert_eq!(asked.get(), 5);
    }

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
