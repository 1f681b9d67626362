//! Long computations ask from time to time whether to go on, so that Ctrl-C and a caller's own observer stop them: often enough
//! for a person who waits, seldom enough to cost nothing.

use crate::error::{Error, Result};
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::rc::Rc;
use std::time::Duration;

/// Asked by a long computation whether to go on.
pub(crate) type ObserverFn<'a> = &'a mut dyn FnMut() -> ControlFlow<()>;

/// Work between two questions, in units of some nanoseconds: below a millisecond. [work]
const WORK_PER_QUESTION: usize = 1 << 14;

/// `Error::Interrupted` where the answer is to break off.
pub(crate) fn stop_if(answer: ControlFlow<()>) -> Result<()> {
    match answer {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(Error::Interrupted),
    }
}

/// Counts the work done and asks when it has become enough.
pub(crate) struct Observer<'a> {
    go_on: ObserverFn<'a>,
    left: usize,
}

impl<'a> Observer<'a> {
    /// An observer that asks `go_on`.
    pub fn new(go_on: ObserverFn<'a>) -> Self {
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
        self.ask()
    }

    /// The steps of a loop, each so much work as in [`Observer::work`].
    #[inline]
    pub fn steps(&mut self, work: usize) -> Steps<'_, 'a> {
        let work = work.max(1);
        Steps {
            left: self.left / work,
            work,
            observer: self,
        }
    }

    /// Asks now: for pieces of work that are long in themselves.
    ///
    /// # Errors
    /// `Error::Interrupted` if the answer is to break off.
    #[cold]
    pub fn ask(&mut self) -> Result<()> {
        self.left = WORK_PER_QUESTION;
        stop_if((self.go_on)())
    }
}

/// Counts the steps of a loop down to the next question: a number in a register. The observer knows of them when it ends.
pub(crate) struct Steps<'w, 'a> {
    observer: &'w mut Observer<'a>,
    work: usize,
    left: usize,
}

impl Steps<'_, '_> {
    /// A step begins.
    ///
    /// # Errors
    /// As [`Observer::work`].
    #[inline]
    pub fn begin(&mut self) -> Result<()> {
        if let Some(left) = self.left.checked_sub(1) {
            self.left = left;
            return Ok(());
        }
        self.observer.ask()?;
        self.left = WORK_PER_QUESTION / self.work;
        Ok(())
    }
}

impl Drop for Steps<'_, '_> {
    #[inline]
    fn drop(&mut self) {
        self.observer.left = self.left * self.work;
    }
}

/// Asked by what has no observer of its own.
type Asker = Rc<dyn Fn() -> ControlFlow<()>>;

thread_local! {
    /// Whom work on this thread asks that has no observer of its own.
    static ASKER: RefCell<Option<Asker>> = const { RefCell::new(None) };
}

/// Puts back whom the thread asked before.
#[cfg(any(feature = "parallel", test))]
struct Before(Option<Asker>);

#[cfg(any(feature = "parallel", test))]
impl Drop for Before {
    fn drop(&mut self) {
        ASKER.set(self.0.take());
    }
}

/// Does work whose pieces that have no observer of their own ask this one, on this thread: for threads of a sweep and for
/// callers in Python, where every other observer is handed down.
#[cfg(any(feature = "parallel", test))]
pub(crate) fn with_asker<T>(
    asker: impl Fn() -> ControlFlow<()> + 'static,
    work: impl FnOnce() -> T,
) -> T {
    let _before = Before(ASKER.replace(Some(Rc::new(asker))));
    work()
}

fn asker() -> Option<Asker> {
    ASKER.with_borrow(Clone::clone)
}

/// Whether the work that this piece belongs to is to be broken off; its result is not wanted then.
pub(crate) fn is_broken_off() -> bool {
    go_on_unless_broken_off().is_break()
}

/// The same as an observer has it, for work that is handed none.
pub(crate) fn go_on_unless_broken_off() -> ControlFlow<()> {
    asker().map_or(ControlFlow::Continue(()), |ask| ask())
}

/// `Error::Interrupted` where it is.
pub(crate) fn unless_broken_off() -> Result<()> {
    stop_if(go_on_unless_broken_off())
}

/// Does a piece of work in which nothing can be asked. Where somebody is there to be asked it is done on a thread of its own: it
/// is left to itself when it is not wanted any more.
///
/// # Errors
/// `Error::Interrupted` if the answer is to break off.
pub(crate) fn apart<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T> {
    let Some(ask) = asker() else {
        return Ok(work());
    };
    let caller = std::thread::current();
    let task = move || {
        let _waking = Waking(caller);
        work()
    };
    let refused = |e| Error::bad_value("threads", 1, format!("the system refuses it: {e}"));
    let worker = std::thread::Builder::new().spawn(task).map_err(refused)?;
    while !worker.is_finished() {
        stop_if(ask())?;
        std::thread::park_timeout(ANSWER);
    }
    worker
        .join()
        .map_err(|panic| std::panic::resume_unwind(panic))
}

/// Time between two questions while somebody else works.
const ANSWER: Duration = Duration::from_millis(50);

/// Wakes a thread that waits, when it is dropped.
struct Waking(std::thread::Thread);

impl Drop for Waking {
    fn drop(&mut self) {
        self.0.unpark();
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
        let mut observer = Observer::new(&mut go_on);
        let work = WORK_PER_QUESTION / 8;
        // Loops of three steps, and a loop of as many as there may be: a question at every ninth step.
        for _ in 0..4 {
            let mut steps = observer.steps(work);
            for _ in 0..3 {
                assert_eq!(steps.begin(), Ok(()));
            }
        }
        assert_eq!(asked.get(), 1);
        let mut steps = observer.steps(work);
        let begun = std::iter::repeat_with(|| steps.begin()).take_while(|done| *done == Ok(()));
        assert_eq!((begun.count(), asked.get()), (14, 3));
        // A step that is more work than lies between two questions asks each time.
        asked.set(0);
        let mut go_on = || {
            asked.set(asked.get() + 1);
            ControlFlow::Continue(())
        };
        let mut observer = Observer::new(&mut go_on);
        let mut steps = observer.steps(2 * WORK_PER_QUESTION);
        (0..5).for_each(|_| assert_eq!(steps.begin(), Ok(())));
        assert_eq!(asked.get(), 5);
    }

    #[test]
    fn work_of_its_own_thread_is_left_when_it_is_not_wanted() {
        assert!(!is_broken_off());
        assert_eq!(apart(|| 7), Ok(7));
        let go_on = || ControlFlow::Continue(());
        assert_eq!(with_asker(go_on, || apart(|| 7)), Ok(7));
        let start = std::time::Instant::now();
        let long = || apart(|| std::thread::sleep(Duration::from_secs(5)));
        assert_eq!(
            with_asker(|| ControlFlow::Break(()), long),
            Err(Error::Interrupted)
        );
        assert!(start.elapsed() < Duration::from_secs(1));
        assert!(!is_broken_off());
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
        let mut observer = Observer::new(&mut go_on);
        for _ in 0..3 * WORK_PER_QUESTION - 1 {
            assert_eq!(observer.work(1), Ok(()));
        }
        assert_eq!(observer.work(1), Err(Error::Interrupted));
        assert_eq!(asked, 3);
    }
}
