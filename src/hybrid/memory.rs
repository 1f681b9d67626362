//! What exact flights go on from, beside what is known of contacts (`resolver.rs`): the motion where a flight begins.

use crate::hybrid::pen::Pen;
use crate::modal::Pair;

/// A flow where one of its flights begins.
#[derive(Debug, Clone, Default)]
pub(crate) struct FlowMemory {
    /// The clock, as it is written.
    pub clock: [f64; 4],
    /// The level of the steps of the search.
    pub level: usize,
    /// The state of the flow.
    pub state: Vec<Pair>,
    /// What the rounding of positions leaves unknown of each gap; shape `(n_stops,)`, \[m\]; empty where the
    /// state was not taken from a position.
    pub placed: Vec<f64>,
    /// What the tolerances allow as an absolute error of each gap, shape `(n_stops,)`, \[m\].
    pub allowed: Vec<f64>,
    /// The largest sizes seen of each gap on the flight before.
    pub extents: Vec<Pair>,
    /// The elements that relax, with the place of each and the time after which it is back.
    pub places: Vec<(usize, Pair)>,
}

impl FlowMemory {
    /// Puts it down, or takes it up.
    pub fn carry(&mut self, pen: &mut Pen) {
        self.clock.iter_mut().for_each(|number| pen.number(number));
        pen.count(&mut self.level);
        pen.list(&mut self.state, carry_pair);
        pen.numbers(&mut self.placed);
        pen.numbers(&mut self.allowed);
        pen.list(&mut self.extents, carry_pair);
        pen.list(&mut self.places, |pen, (element, place)| {
            pen.count(element);
            carry_pair(pen, place);
        });
    }
}

fn carry_pair(pen: &mut Pen, pair: &mut Pair) {
    for number in pair {
        pen.number(number);
    }
}
