//! Long computations ask from time to time whether to go on, so that Ctrl-C and a caller's own observer stop them: often enough
//! for a person who waits, seldom enough to cost nothing. Whom they ask belongs to the thread: [`with_observer`].

use crate::error::{Error, Result};
use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;
use std::rc::Rc;
use std::time::Duration;

/// Work between two questions, in units of some nanoseconds: below a millisecond. [work]
const WORK_PER_QUESTION: usize = 1 << 14;

/// Whom the work on a thread asks, and how far that work is.
struct Asked {
    observer: Box<dyn Fn(f64) -> ControlFlow<()>>,
    /// Computations in one another that know how far they are; the outermost tells.
    depth: Cell<usize>,
    /// Where that one begins and ends.
    range: Cell<(f64, f64)>,
    fraction: Cell<f64>,
    /// Whether the answer was to break off, as it is from then on.
    is_broken_off: Cell<bool>,
}

thread_local! {
    static ASKED: RefCell<Option<Rc<Asked>>> = const { RefCell::new(None) };
}

/// Puts back whom the thread asked before.
struct Before(Option<Rc<Asked>>);

impl Drop for Before {
    fn drop(&mut self) {
        ASKED.set(self.0.take());
    }
}

/// Does work whose long computations tell an observer, on this thread, how far they are, from 0 to 1, and break off where it says so.
/// Work on threads of its own is told by the calling thread. Of several computations in one another the outermost is told of; those that
/// do not know how far they are tell what is known, 0 at first.
///
/// # Examples
/// ```
/// use std::ops::ControlFlow;
/// use vibroimpact::nalgebra::dvector;
/// use vibroimpact::{Error, Forcing, LinearSystem, Scene, SimulateOptions, Stop, simulate, with_observer};
/// let system = LinearSystem::new(dvector![1.0], dvector![0.0], dvector![1.0])?;
/// let scene = Scene::new(system, Forcing::Unforced, [Stop::new(0, 1.0, 1.0)?])?;
/// let (q, v) = (dvector![0.0], dvector![2.0]);
/// let run = || simulate(&scene, &q, &v, (0.0, 1e9), &SimulateOptions::default());
/// let half = |done: f64| if done < 1e-6 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) };
/// assert_eq!(with_observer(half, run).err(), Some(Error::Interrupted));
/// # Ok::<(), Error>(())
/// ```
pub fn with_observer<T>(
    observer: impl Fn(f64) -> ControlFlow<()> + 'static,
    work: impl FnOnce() -> T,
) -> T {
    let asked = Asked {
        observer: Box::new(observer),
        depth: Cell::new(0),
        range: Cell::new((0.0, 1.0)),
        fraction: Cell::new(0.0),
        is_broken_off: Cell::new(false),
    };
    let _before = Before(ASKED.replace(Some(Rc::new(asked))));
    work()
}

/// Does work that asks nobody and comes to its end.
pub(crate) fn unobserved<T>(work: impl FnOnce() -> T) -> T {
    let _before = Before(ASKED.take());
    work()
}

fn asked() -> Option<Rc<Asked>> {
    ASKED.with_borrow(Clone::clone)
}

/// A computation that knows how far it is, while it lives.
pub(crate) struct ProgressRange(Option<Rc<Asked>>);

impl ProgressRange {
    /// A computation that goes from a value to another, of time, of a number or of items that are done.
    pub fn over(begin: f64, end: f64) -> Self {
        let asked = asked();
        if let Some(asked) = &asked {
            if asked.depth.get() == 0 {
                asked.range.set((begin, end));
            }
            asked.depth.set(asked.depth.get() + 1);
        }
        Self(asked)
    }
}

impl Drop for ProgressRange {
    fn drop(&mut self) {
        if let Some(asked) = &self.0 {
            asked.depth.set(asked.depth.get() - 1);
        }
    }
}

/// `Error::Interrupted` where the answer is to break off, of a computation that has reached a value of those it goes over.
pub(crate) fn report(value: f64) -> Result<()> {
    if let Some(asked) = asked()
        && asked.depth.get() <= 1
    {
        let (begin, end) = asked.range.get();
        let part = (value - begin) / (end - begin);
        asked.fraction.set(if part.is_nan() {
            1.0
        } else {
            part.clamp(0.0, 1.0)
        });
    }
    unless_broken_off()
}

/// Whether the work that this piece belongs to is to be broken off; its result is not wanted then.
pub(crate) fn is_broken_off() -> bool {
    asked().is_some_and(|asked| {
        let broken = &asked.is_broken_off;
        broken.set(broken.get() || (asked.observer)(asked.fraction.get()).is_break());
        broken.get()
    })
}

/// `Error::Interrupted` where it is.
pub(crate) fn unless_broken_off() -> Result<()> {
    if is_broken_off() {
        Err(Error::Interrupted)
    } else {
        Ok(())
    }
}

/// Counts the work done and asks when it has become enough.
pub(crate) struct Observer {
    left: usize,
    /// The last value that was reached of those that the computation goes over, if it knows.
    pub at: Option<f64>,
}

impl Default for Observer {
    fn default() -> Self {
        Self {
            left: WORK_PER_QUESTION,
            at: None,
        }
    }
}

impl Observer {
    /// Of a computation that has reached a value of those it goes over.
    pub fn at(value: f64) -> Self {
        Self {
            at: Some(value),
            ..Self::default()
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
    pub fn steps(&mut self, work: usize) -> Steps<'_> {
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
        self.at.map_or_else(unless_broken_off, report)
    }
}

/// Counts the steps of a loop down to the next question: a number in a register. The observer knows of them when it ends.
pub(crate) struct Steps<'w> {
    observer: &'w mut Observer,
    work: usize,
    left: usize,
}

impl Steps<'_> {
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

impl Drop for Steps<'_> {
    #[inline]
    fn drop(&mut self) {
        self.observer.left = self.left * self.work;
    }
}

/// Does a piece of work in which nothing can be asked. Where somebody is there to be asked it is done on a thread of its own: it
/// is left to itself when it is not wanted any more.
///
/// # Errors
/// `Error::Interrupted` if the answer is to break off.
pub(crate) fn apart<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T> {
    if asked().is_none() {
        return Ok(work());
    }
    let caller = std::thread::current();
    let task = move || {
        let _waking = Waking(caller);
        work()
    };
    let refused = |e| Error::bad_value("threads", 1, format!("the system refuses it: {e}"));
    let worker = std::thread::Builder::new().spawn(task).map_err(refused)?;
    while !worker.is_finished() {
        unless_broken_off()?;
        std::thread::park_timeout(OBSERVER_INTERVAL);
    }
    worker
        .join()
        .map_err(|panic| std::panic::resume_unwind(panic))
}

/// Time between two questions while others work: short beside the 0.2 s in which an interruption is to be answered. [work]
pub(crate) const OBSERVER_INTERVAL: Duration = Duration::from_millis(50);

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

    /// An observer that counts its questions and breaks off at one of them.
    fn counting(most: usize) -> (Rc<Cell<usize>>, impl Fn(f64) -> ControlFlow<()> + 'static) {
        let count = Rc::new(Cell::new(0));
        let own = Rc::clone(&count);
        let observer = move |_| {
            own.set(own.get() + 1);
            if own.get() < most {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        };
        (count, observer)
    }

    #[test]
    fn steps_of_loops_count_as_their_work_does() {
        let (count, three) = counting(3);
        with_observer(three, || {
            let mut observer = Observer::default();
            let work = WORK_PER_QUESTION / 8;
            // Loops of three steps, and a loop of as many as there may be: a question at every ninth step.
            for _ in 0..4 {
                let mut steps = observer.steps(work);
                for _ in 0..3 {
                    assert_eq!(steps.begin(), Ok(()));
                }
            }
            assert_eq!(count.get(), 1);
            let mut steps = observer.steps(work);
            let begun = std::iter::repeat_with(|| steps.begin()).take_while(|done| *done == Ok(()));
            assert_eq!((begun.count(), count.get()), (14, 3));
        });
        // A step that is more work than lies between two questions asks each time.
        let (count, many) = counting(usize::MAX);
        with_observer(many, || {
            let mut observer = Observer::default();
            let mut steps = observer.steps(2 * WORK_PER_QUESTION);
            (0..5).for_each(|_| assert_eq!(steps.begin(), Ok(())));
        });
        assert_eq!(count.get(), 5);
    }

    #[test]
    fn the_outermost_computation_tells_how_far_it_is() {
        let told = Rc::new(RefCell::new(Vec::new()));
        let own = Rc::clone(&told);
        let observer = move |part| {
            own.borrow_mut().push(part);
            ControlFlow::Continue(())
        };
        let done = with_observer(observer, || {
            unless_broken_off()?;
            let _outer = ProgressRange::over(10.0, 30.0);
            report(15.0)?;
            let inner = ProgressRange::over(0.0, 1.0);
            report(0.9)?;
            drop(inner);
            report(20.0)?;
            unless_broken_off()
        });
        assert_eq!(done, Ok(()));
        assert_eq!(*told.borrow(), [0.0, 0.25, 0.25, 0.5, 0.5]);
        // Without an observer nobody is asked.
        let _alone = ProgressRange::over(0.0, 1.0);
        assert_eq!(report(0.5), Ok(()));
    }

    #[test]
    fn work_of_its_own_thread_is_left_when_it_is_not_wanted() {
        assert!(!is_broken_off());
        assert_eq!(apart(|| 7), Ok(7));
        let go_on = |_| ControlFlow::Continue(());
        assert_eq!(with_observer(go_on, || apart(|| 7)), Ok(7));
        let start = std::time::Instant::now();
        let long = || apart(|| std::thread::sleep(Duration::from_secs(5)));
        assert_eq!(
            with_observer(|_| ControlFlow::Break(()), long),
            Err(Error::Interrupted)
        );
        assert!(start.elapsed() < Duration::from_secs(1));
        assert!(!is_broken_off());
    }

    #[test]
    fn an_observer_is_asked_once_for_so_much_work_and_its_answer_passed_on() {
        let (count, three) = counting(3);
        with_observer(three, || {
            let mut observer = Observer::default();
            for _ in 0..3 * WORK_PER_QUESTION - 1 {
                assert_eq!(observer.work(1), Ok(()));
            }
            assert_eq!(observer.work(1), Err(Error::Interrupted));
        });
        assert_eq!(count.get(), 3);
    }
}
