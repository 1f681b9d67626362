//! A gap as the search for the next impact follows it along a flight.

use crate::contact::bracket::Bracket;
use crate::flow::GapRow;
use crate::flow::gap_model::GapModel;
use crate::tolerance::GAP_ROUNDING;

/// A gap as the search follows it along a flight.
#[derive(Debug, Clone)]
pub(super) struct Followed {
    pub row: GapRow,
    /// The part of the size of its terms above which it is clear of rounding.
    pub clear: f64,
    /// The model where the search last looked.
    pub model: GapModel,
    /// The order of its root at the start of the flight; the same as long as the search has gone no step.
    pub order: usize,
    pub order_here: usize,
    /// Of a stop left more slowly than a cubic tells, the gap up to which it is on its way out, beside what the motion soon is; zero
    /// beyond, and of others.
    pub late: f64,
    /// Where the walk last saw it open, and from where on no longer: the zero at which the stop is reached lies between.
    pub bracket: Bracket,
    /// The largest size of its terms seen on the flight, and the largest gap.
    pub extent: [f64; 2],
}

impl Followed {
    pub fn new(row: GapRow) -> Self {
        Self {
            clear: GAP_ROUNDING.max(row.relative_rounding()),
            row,
            model: GapModel::default(),
            order: 0,
            order_here: 0,
            late: 0.0,
            bracket: Bracket::start(0.0, 0),
            extent: [0.0; 2],
        }
    }

    /// Begins a flight where the search last looked, with a root of some order there.
    pub fn depart(&mut self, order: usize) {
        let gap = self.model.c[0];
        (self.order, self.order_here, self.late) = (order, order, 0.0);
        self.bracket = Bracket::start(gap, order);
        self.extent = [0.0, gap.abs()];
    }

    /// Looks at it a step further along the flight: whether it has turned since.
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

    /// Takes note of how large its terms and itself are.
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

    /// What rounding leaves unknown of it where the search last looked.
    #[inline]
    pub fn rounding(&self) -> f64 {
        self.row.rounding(&self.model)
    }
}
