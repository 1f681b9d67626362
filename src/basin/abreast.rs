//! Cells whose motions run side by side, a period at a time: a place whose cell is decided gets the next.

use crate::basin::label::Label;
use crate::basin::targets::{Course, Targets};
use crate::error::Failure;
use crate::flow::steps::State;
use crate::model::{Dynamics, PhysicalState};
use crate::observer::ObserverFn;
use crate::simulate::{Batch, Done, Status};
use std::cell::RefCell;
use std::collections::VecDeque;

/// A cell: its state when it was last looked at, what has been seen, and whether it is to go on.
struct Cell {
    state: PhysicalState,
    course: Course,
    count: usize,
    is_open: bool,
}

/// Cells that are labelled together; all begin at one phase of the forcing.
pub(super) struct Tile<'t> {
    cells: Vec<Cell>,
    slots: &'t mut [(Label, usize)],
    waiting: VecDeque<usize>,
    targets: &'t Targets,
    /// Looks after which a cell is left undecided.
    most: usize,
}

impl<'t> Tile<'t> {
    /// Cells at their states; a label and the periods that it took go into the slots.
    pub fn new(
        slots: &'t mut [(Label, usize)],
        states: impl Iterator<Item = PhysicalState>,
        targets: &'t Targets,
        most: usize,
    ) -> Self {
        let cell = |state| Cell {
            state,
            course: Course::new(targets),
            count: 0,
            is_open: true,
        };
        Self {
            cells: states.map(cell).collect(),
            slots,
            waiting: VecDeque::new(),
            targets,
            most,
        }
    }

    /// Labels them by runs up to the first look, and others from each look to the next.
    ///
    /// # Errors
    /// As a run by itself, with the place of the cell.
    pub fn label<S: State, D: Dynamics, const K: usize>(
        self,
        [first, later]: &mut [Batch<'_, S, D, K>; 2],
        go_on: ObserverFn<'_>,
    ) -> Result<(), Failure> {
        let tile = RefCell::new(self);
        Self::follow(&tile, first, false, go_on)?;
        Self::follow(&tile, later, true, go_on)
    }

    /// Runs all open cells, once or until none is open.
    fn follow<S: State, D: Dynamics, const K: usize>(
        tile: &RefCell<Self>,
        batch: &mut Batch<'_, S, D, K>,
        goes_on: bool,
        go_on: ObserverFn<'_>,
    ) -> Result<(), Failure> {
        let put = &mut |i: usize, done: Option<Done>| {
            let mut tile = tile.borrow_mut();
            tile.look(i, done);
            if goes_on && tile.cells[i].is_open {
                tile.waiting.push_front(i);
            }
        };
        loop {
            {
                let mut tile = tile.borrow_mut();
                tile.waiting = (0..tile.cells.len())
                    .filter(|&i| tile.cells[i].is_open)
                    .collect();
            }
            let next = std::iter::from_fn(|| tile.borrow_mut().waiting.pop_front());
            let start = |i: usize| tile.borrow().cells[i].state.clone();
            match batch.run(next, start, go_on, put) {
                // It has grown beyond the doubles; the others go on.
                Err((i, error)) if error.is_about("t_span") => {
                    tile.borrow_mut().close(i, Label::Lost);
                }
                done => return done,
            }
        }
    }

    /// Looks at what a run has brought; nothing of a state inside a stop.
    fn look(&mut self, i: usize, done: Option<Done>) {
        let Some(done) = done else {
            return self.close(i, Label::Inside);
        };
        if done.ending.status != Status::Finished {
            return self.close(i, Label::Undecided);
        }
        let cell = &mut self.cells[i];
        (cell.state, cell.count) = (done.last, cell.count + 1);
        match cell.course.look(self.targets, &cell.state) {
            Some(label) => self.close(i, label),
            None if cell.count >= self.most => self.close(i, Label::Undecided),
            None => {}
        }
    }

    fn close(&mut self, i: usize, label: Label) {
        self.slots[i] = (label, self.cells[i].count);
        self.cells[i].is_open = false;
    }
}
