//! Grid points of a basin whose motions are integrated in lanes of one batch, period by period: a lane whose point has its label takes
//! the next point.
//!
//! The state of a point is (q, v) in units of the scene, at the phase of the attractors' points; counts are in periods of the forcing.

use crate::basin::label::Label;
use crate::basin::targets::{ProximityCounter, Targets};
use crate::error::Failure;
use crate::flow::steps::State;
use crate::model::{Dynamics, PhysicalState};
use crate::simulate::{Batch, Done, Status};
use std::cell::RefCell;
use std::collections::VecDeque;

/// A grid point: the last state of its motion at the phase, its proximity to the attractors, the periods counted, and whether it still
/// needs a label.
struct BasinPoint {
    state: PhysicalState,
    proximity: ProximityCounter,
    count: usize,
    is_open: bool,
}

/// Grid points that are labelled together; all begin at one phase of the forcing.
pub(super) struct Tile<'t> {
    points: Vec<BasinPoint>,
    slots: &'t mut [(Label, usize)],
    waiting: VecDeque<usize>,
    targets: &'t Targets,
    /// Periods after which a point is left undecided.
    most: usize,
}

impl<'t> Tile<'t> {
    /// Points at their states; the label of each and the periods that it took go into the slots.
    pub fn new(
        slots: &'t mut [(Label, usize)],
        states: impl Iterator<Item = PhysicalState>,
        targets: &'t Targets,
        most: usize,
    ) -> Self {
        let point = |state| BasinPoint {
            state,
            proximity: ProximityCounter::new(targets),
            count: 0,
            is_open: true,
        };
        Self {
            points: states.map(point).collect(),
            slots,
            waiting: VecDeque::new(),
            targets,
            most,
        }
    }

    /// Labels all points: `first` runs them to the phase of the attractors' points, `later` from there period by period.
    ///
    /// # Errors
    /// As a run by itself, with the index of the point.
    pub fn label<S: State, D: Dynamics, const K: usize>(
        self,
        [first, later]: &mut [Batch<'_, S, D, K>; 2],
    ) -> Result<(), Failure> {
        let tile = RefCell::new(self);
        Self::follow(&tile, first, false)?;
        Self::follow(&tile, later, true)
    }

    /// Runs all open points, once or until none is open.
    fn follow<S: State, D: Dynamics, const K: usize>(
        tile: &RefCell<Self>,
        batch: &mut Batch<'_, S, D, K>,
        goes_on: bool,
    ) -> Result<(), Failure> {
        let put = &mut |i: usize, done: Option<Done>| {
            let mut tile = tile.borrow_mut();
            tile.record(i, done);
            if goes_on && tile.points[i].is_open {
                tile.waiting.push_front(i);
            }
            Ok(())
        };
        loop {
            {
                let mut tile = tile.borrow_mut();
                tile.waiting = (0..tile.points.len())
                    .filter(|&i| tile.points[i].is_open)
                    .collect();
            }
            let next = std::iter::from_fn(|| tile.borrow_mut().waiting.pop_front());
            let start = |i: usize| tile.borrow().points[i].state.clone();
            match batch.run(next, start, put) {
                // It has grown beyond the doubles; the others go on.
                Err((i, error)) if error.is_about("t_span") => {
                    tile.borrow_mut().close(i, Label::Lost);
                }
                done => return done,
            }
        }
    }

    /// Takes the end of a point's run, `None` where its state lies inside a stop.
    fn record(&mut self, i: usize, done: Option<Done>) {
        let Some(done) = done else {
            return self.close(i, Label::Inside);
        };
        if done.ending.status != Status::Finished {
            return self.close(i, Label::Undecided);
        }
        let point = &mut self.points[i];
        (point.state, point.count) = (done.last, point.count + 1);
        match point.proximity.update(self.targets, &point.state) {
            Some(label) => self.close(i, label),
            None if point.count >= self.most => self.close(i, Label::Undecided),
            None => {}
        }
    }

    fn close(&mut self, i: usize, label: Label) {
        self.slots[i] = (label, self.points[i].count);
        self.points[i].is_open = false;
    }
}
