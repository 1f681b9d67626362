//! Work in pieces: independent items computed by index, so that the result has the same bits on any number of threads;
//! the observer of the calling thread hears of the progress from time to time and may stop it all.

use crate::error::{Failure, Result};
use crate::observer::{report, unless_broken_off};
use crate::quantity::at_least_one;

/// Options of sweeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SweepOptions {
    /// Threads; `None`: one for each core with the feature `parallel`, 1 without it.
    pub threads: Option<usize>,
}

impl SweepOptions {
    /// The number of threads for so many tiles, 1 or more.
    fn count(self, tiles: usize) -> Result<usize> {
        at_least_one("threads", self.threads.unwrap_or(1))?;
        let available = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let wanted = self.threads.unwrap_or_else(available);
        Ok(if cfg!(feature = "parallel") {
            wanted.min(tiles.max(1))
        } else {
            1
        })
    }
}

/// Fills `out[i]` with `item(&mut workspace, i)`, as [`fill_tiles`].
///
/// # Errors
/// As [`fill_tiles`].
pub(crate) fn fill<T: Send, W>(
    out: &mut [T],
    tile: usize,
    options: SweepOptions,
    workspace: impl Fn() -> Result<W> + Sync,
    item: impl Fn(&mut W, usize) -> Result<T> + Sync,
) -> Result<()> {
    let items = |workspace: &mut W, first: usize, slots: &mut [T]| {
        for (i, slot) in (first..).zip(slots) {
            let value = unless_broken_off().and_then(|()| item(workspace, i));
            *slot = value.map_err(|error| (i, error))?;
        }
        Ok(())
    };
    fill_tiles(out, tile, options, workspace, items)
}

/// Fills `out` tile by tile by `items(&mut workspace, first, slots)`, `first` being the index of the first slot; a
/// workspace for each thread. The observer is called on the calling thread, about every 50 ms and at the end. A thread takes
/// `tile` items at a time: many enough to make the handing out cheap, few enough to share evenly.
///
/// # Errors
/// `Error::Interrupted` if the observer breaks off; else the error of the item of lowest index among those that failed
/// before the sweep stopped.
pub(crate) fn fill_tiles<T: Send, W>(
    out: &mut [T],
    tile: usize,
    options: SweepOptions,
    workspace: impl Fn() -> Result<W> + Sync,
    items: impl Fn(&mut W, usize, &mut [T]) -> std::result::Result<(), Failure> + Sync,
) -> Result<()> {
    let total = out.len();
    let threads = options.count(total.div_ceil(tile))?;
    if threads > 1 {
        #[cfg(feature = "parallel")]
        on_threads::fill(out, tile, threads, workspace, items)?;
    } else {
        alone(out, tile, workspace, items)?;
    }
    report(total as f64)
}

/// On the calling thread.
fn alone<T, W>(
    out: &mut [T],
    tile: usize,
    workspace: impl Fn() -> Result<W>,
    items: impl Fn(&mut W, usize, &mut [T]) -> std::result::Result<(), Failure>,
) -> Result<()> {
    let mut workspace = workspace()?;
    for (k, slots) in out.chunks_mut(tile).enumerate() {
        report((k * tile) as f64)?;
        items(&mut workspace, k * tile, slots).map_err(|(_, error)| error)?;
    }
    Ok(())
}

#[cfg(feature = "parallel")]
mod on_threads {
    use crate::error::{Error, Failure, Result};
    use crate::observer::{OBSERVER_INTERVAL, report, with_observer};
    use std::ops::ControlFlow;
    use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
    use std::sync::{Arc, Mutex};
    use std::time::Instant;

    /// What the threads of one sweep share.
    struct Shared<'a, T> {
        /// The tiles not yet taken, with the index of their first item.
        tiles: Mutex<std::iter::Enumerate<std::slice::ChunksMut<'a, T>>>,
        done: AtomicUsize,
        working: AtomicUsize,
        is_stopped: Arc<AtomicBool>,
        /// The failure of lowest index.
        failure: Mutex<Option<(usize, Error)>>,
    }

    fn answer(is_stopped: &AtomicBool) -> ControlFlow<()> {
        if is_stopped.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    impl<T> Shared<'_, T> {
        fn fail(&self, index: usize, error: Error) {
            self.is_stopped.store(true, Ordering::Relaxed);
            if error == Error::Interrupted {
                return; // an item that was told to stop: why, is known elsewhere
            }
            let mut failure = self
                .failure
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner);
            if failure.as_ref().is_none_or(|(first, _)| index < *first) {
                *failure = Some((index, error));
            }
        }

        /// Takes tiles until there are none, or the sweep is stopped.
        fn work<W>(
            &self,
            size: usize,
            workspace: impl Fn() -> Result<W>,
            items: impl Fn(&mut W, usize, &mut [T]) -> std::result::Result<(), Failure>,
        ) {
            let mut workspace = match workspace() {
                Ok(workspace) => workspace,
                Err(error) => return self.fail(0, error),
            };
            loop {
                let next = self
                    .tiles
                    .lock()
                    .unwrap_or_else(std::sync::PoisonError::into_inner)
                    .next();
                let Some((tile, slots)) = next else { return };
                if let Err((index, error)) = items(&mut workspace, tile * size, slots) {
                    return self.fail(index, error);
                }
                self.done.fetch_add(slots.len(), Ordering::Relaxed);
            }
        }
    }

    /// Wakes the calling thread when a worker ends, also when it ends by a panic.
    struct Leaving<'a>(&'a AtomicUsize, &'a std::thread::Thread);

    impl Drop for Leaving<'_> {
        fn drop(&mut self) {
            self.0.fetch_sub(1, Ordering::Release);
            self.1.unpark();
        }
    }

    /// On a pool of so many threads, while the calling thread observes.
    pub(super) fn fill<T: Send, W>(
        out: &mut [T],
        tile: usize,
        threads: usize,
        workspace: impl Fn() -> Result<W> + Sync,
        items: impl Fn(&mut W, usize, &mut [T]) -> std::result::Result<(), Failure> + Sync,
    ) -> Result<()> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|e| {
                Error::bad_value("threads", threads, format!("the system refuses them: {e}"))
            })?;
        let shared = Shared {
            tiles: Mutex::new(out.chunks_mut(tile).enumerate()),
            done: AtomicUsize::new(0),
            working: AtomicUsize::new(threads),
            is_stopped: Arc::new(AtomicBool::new(false)),
            failure: Mutex::new(None),
        };
        let caller = std::thread::current();
        let mut verdict = Ok(());
        pool.in_place_scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|_| {
                    let _leaving = Leaving(&shared.working, &caller);
                    let is_stopped = Arc::clone(&shared.is_stopped);
                    let answer = move |_| answer(&is_stopped);
                    with_observer(answer, || shared.work(tile, &workspace, &items));
                });
            }
            let mut last = Instant::now();
            while shared.working.load(Ordering::Acquire) > 0 {
                std::thread::park_timeout(OBSERVER_INTERVAL.saturating_sub(last.elapsed()));
                if last.elapsed() < OBSERVER_INTERVAL {
                    continue;
                }
                last = Instant::now();
                if verdict.is_ok() {
                    verdict = report(shared.done.load(Ordering::Relaxed) as f64);
                    shared
                        .is_stopped
                        .fetch_or(verdict.is_err(), Ordering::Relaxed);
                }
            }
        });
        verdict?;
        match shared
            .failure
            .into_inner()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
        {
            Some((_, error)) => Err(error),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::observer::{ProgressRange, with_observer};
    use std::cell::RefCell;
    use std::ops::ControlFlow;
    use std::rc::Rc;
    use std::time::Duration;

    fn squares(
        threads: usize,
        observer: impl Fn(f64) -> ControlFlow<()> + 'static,
    ) -> Result<Vec<usize>> {
        let mut out = vec![0; 3000];
        let slow = |(): &mut (), i: usize| {
            std::thread::sleep(Duration::from_micros(50));
            Ok(i * i)
        };
        let threads = Some(threads);
        let fill = || {
            let _range = ProgressRange::over(0.0, 3000.0);
            fill(&mut out, 256, SweepOptions { threads }, || Ok(()), slow)
        };
        with_observer(observer, fill).map(|()| out)
    }

    #[test]
    fn every_item_is_at_its_index_and_the_observer_sees_the_end() {
        for threads in [1, 2, 3] {
            let seen = Rc::new(RefCell::new(Vec::new()));
            let own = Rc::clone(&seen);
            let out = squares(threads, move |part| {
                own.borrow_mut().push(part);
                ControlFlow::Continue(())
            });
            assert!(
                out.expect("no failure")
                    .iter()
                    .enumerate()
                    .all(|(i, &x)| x == i * i)
            );
            let seen = seen.borrow();
            assert!(
                seen.len() > 1 && seen.is_sorted() && seen.last() == Some(&1.0),
                "{seen:?}"
            );
        }
    }

    #[test]
    fn an_observer_that_breaks_stops_the_sweep() {
        for threads in [1, 2] {
            let calls = Rc::new(RefCell::new(0));
            let own = Rc::clone(&calls);
            let out = squares(threads, move |_| {
                *own.borrow_mut() += 1;
                ControlFlow::Break(())
            });
            assert_eq!((out, *calls.borrow()), (Err(Error::Interrupted), 1));
        }
    }

    #[test]
    fn a_failure_is_reported_and_no_threads_are_refused() {
        for threads in [1, 2] {
            let fails = |(): &mut (), i: usize| {
                if i == 2000 {
                    Err(Error::bad_value("item", i, "no"))
                } else {
                    Ok(i)
                }
            };
            let threads = Some(threads);
            let mut out = vec![0; 3000];
            let result = fill(&mut out, 256, SweepOptions { threads }, || Ok(()), fails);
            assert_eq!(result, Err(Error::bad_value("item", 2000, "no")));
        }
        assert!(squares(0, |_| ControlFlow::Continue(())).is_err());
    }
}
