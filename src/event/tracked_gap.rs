//! A gap \[m\] tracked along a flight by the search for the next impact: its model at the present time, the bracket of its zero, the order
//! of its root at the start.

use crate::event::gap_bracket::GapBracket;
use crate::flow::GapRow;
use crate::flow::gap_model::GapModel;
use crate::tolerance::GAP_ROUNDING;

/// A gap tracked along a flight.
#[derive(Debug, Clone)]
pub(super) struct TrackedGap {
    pub row: GapRow,
    /// The part of the size of its terms above which it is clear of rounding.
    pub clear: f64,
    /// The model at the time of the last evaluation.
    pub model: GapModel,
    /// The order of its root at the start of the flight, and at the present time: the same until the first step, zero afterwards.
    pub order: usize,
    pub order_here: usize,
    /// Where the stop is left so slowly that the cubic does not show it: the gap up to which it is still being left, in proportion to the
    /// motion shortly after. Zero beyond, and where the stop is not left so.
    pub late: f64,
    /// The times between which it falls through zero.
    pub bracket: GapBracket,
    /// The largest size of its terms on the flight so far, and the largest gap.
    pub extent: [f64; 2],
}

impl TrackedGap {
    pub fn new(row: GapRow) -> Self {
        Self {
            clear: GAP_ROUNDING.max(row.relative_rounding()),
            row,
            model: GapModel::default(),
            order: 0,
            order_here: 0,
            late: 0.0,
            bracket: GapBracket::start(0.0, 0),
            extent: [0.0; 2],
        }
    }

    /// Begins a flight at the time of the last evaluation, with a root of some order there.
    pub fn depart(&mut self, order: usize) {
        let gap = self.model.c[0];
        (self.order, self.order_here, self.late) = (order, order, 0.0);
        self.bracket = GapBracket::start(gap, order);
        self.extent = [0.0, gap.abs()];
    }

    /// Sets the model at a later time of the flight, and returns whether the gap has passed a minimum since.
    #[inline]
    pub fn follow(&mut self, time: f64, model: GapModel) -> bool {
        // What leaves its stop was not on the way to it.
        let was_falling = self.order_here == 0 && self.late == 0.0 && self.model.c[1] < 0.0;
        self.order_here = 0;
        self.model = model;
        let [gap, speed, ..] = self.model.c;
        if gap > self.late {
            self.late = 0.0;
        }
        self.bracket.note(time, gap);
        self.widen([self.model.size, gap.abs()]);
        was_falling && speed >= 0.0
    }

    /// Widens the extent by a size of its terms and a gap.
    #[inline]
    pub fn widen(&mut self, [size, gap]: [f64; 2]) {
        let [widest, farthest] = &mut self.extent;
        if size > *widest {
            *widest = size;
        }
        if gap > *farthest {
            *farthest = gap;
        }
    }

    /// Its rounding at the time of the last evaluation.
    #[inline]
    pub fn rounding(&self) -> f64 {
        self.row.rounding(&self.model)
    }
}
