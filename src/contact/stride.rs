//! Steps of the search for the next impact, as many at once as are proved to hold none: eight looks ahead in the widest registers,
//! where a flow has them, one otherwise (theory 8).

use crate::contact::followed::Followed;
use crate::contact::next::{ContactSearch, Gone, Grazed};
use crate::flow::LinearFlow;
use crate::flow::looks::{LOOKS, LookDerivatives, LookModels, Stride};
use crate::modal::Pair;
use pulp::{Arch, Simd, WithSimd};

impl<F: LinearFlow> ContactSearch<'_, F> {
    /// Goes on by the step that is proved to hold no contact, from a time, and by those after it up to the end of a span that are clear;
    /// the level must be prepared.
    #[inline]
    pub(super) fn go_on(&mut self, time: f64, span: f64, grazes: &mut Vec<Grazed>) -> Gone {
        let is_late = |&stop: &usize| self.gaps[stop].late != 0.0;
        let strides = self.levels.strides(self.flow, self.level);
        match strides {
            Some(strides) if !self.active.iter().any(is_late) => {
                let step = self.levels.step(self.level);
                let is_end = |&look: &usize| time + (look + 1) as f64 * step >= span;
                let ahead = LooksAhead {
                    flow: self.flow,
                    strides,
                    step,
                    last: (0..LOOKS - 1).find(is_end).unwrap_or(LOOKS - 1),
                    state: &self.state,
                    gaps: &self.gaps,
                    active: &self.active,
                    looks: &mut self.looks,
                    models: &mut self.models,
                };
                let looked = Arch::new().dispatch(ahead);
                self.go_to_look(looked, time, grazes)
            }
            _ => self.go_one_step(time, grazes),
        }
    }

    /// The time in a step at which a stop is reached, by the cubic at its end where that is nearer than the one at its beginning.
    pub(super) fn seen_from_beyond(&self, stop: usize, at: f64) -> Option<f64> {
        let (look, level) = self.beyond?;
        let step = self.levels.step(level);
        if level != self.level || 2.0 * at < step {
            return None;
        }
        let place = self.active.iter().position(|&other| other == stop)?;
        let model = self.models.get(place)?.0.at(look);
        let mut back = at - step;
        for _ in 0..2 {
            back -= model.value(back) / model.slope(back);
        }
        let there = step + back;
        (0.0..=step).contains(&there).then_some(there)
    }

    /// Goes on by one step.
    fn go_one_step(&mut self, time: f64, grazes: &mut Vec<Grazed>) -> Gone {
        self.levels.advance(self.flow, self.level, &mut self.state);
        self.flow.derivatives(&self.state, &mut self.derivatives);
        let time = time + self.levels.step(self.level);
        for k in 0..self.active.len() {
            let gap = &mut self.gaps[self.active[k]];
            let model = gap.row.model(&self.derivatives);
            if gap.follow(time, model) {
                self.note_turn(self.active[k], time, &model, grazes);
            }
        }
        self.n_gap_evaluations += self.active.len();
        self.beyond = None;
        Gone {
            count: 1,
            are_clear: true,
        }
    }

    /// Goes on to the last look that was reached.
    fn go_to_look(&mut self, looked: Looked, time: f64, grazes: &mut Vec<Grazed>) -> Gone {
        let Looked { last, are_clear } = looked;
        let step = self.levels.step(self.level);
        let first = time + step;
        for (z, look) in self.state.iter_mut().zip(&self.looks) {
            *z = look.pair(last);
        }
        for k in 0..self.active.len() {
            let (stop, (models, extent)) = (self.active[k], &self.models[k]);
            let gap = &mut self.gaps[stop];
            // A gap that turns in a clear step is clear there: of the first step that is not known.
            let has_turned = gap.follow(first, models.at(0));
            let (at_first, at_last) = (gap.model, models.at(last));
            if last > 0 {
                gap.widen(extent[0], extent[1]);
                gap.bracket
                    .note(time + (last + 1) as f64 * step, at_last.c[0]);
            }
            if has_turned {
                self.note_turn(stop, first, &at_first, grazes);
            }
            self.gaps[stop].model = at_last;
        }
        self.n_gap_evaluations += self.active.len() * (last + 1);
        self.beyond = (last + 1 < LOOKS).then_some((last + 1, self.level));
        Gone {
            count: last + 1,
            are_clear,
        }
    }
}

/// The looks ahead.
struct LooksAhead<'a, F> {
    flow: &'a F,
    strides: &'a [Stride],
    step: f64,
    /// The last look before the end of the span or at it, the eighth at the latest.
    last: usize,
    state: &'a [Pair],
    gaps: &'a [Followed],
    active: &'a [usize],
    looks: &'a mut Vec<LookDerivatives>,
    models: &'a mut Vec<(LookModels, [f64; 2])>,
}

/// What the looks ahead have told.
struct Looked {
    /// The last look before which every step but the first is clear.
    last: usize,
    /// Whether the steps after all eight are.
    are_clear: bool,
}

impl<F: LinearFlow> WithSimd for LooksAhead<'_, F> {
    type Output = Looked;

    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Looked {
        self.flow.look(self.strides, self.state, self.looks);
        self.models.clear();
        let mut clear = [true; LOOKS];
        for &stop in self.active {
            let gap = &self.gaps[stop];
            let models = gap.row.models(self.looks);
            let above = models.are_above(gap.clear, gap.bracket.floor, self.step);
            for (is_clear, is_above) in clear.iter_mut().zip(above) {
                *is_clear &= is_above;
            }
            self.models.push((models, [0.0; 2]));
        }
        let first_unclear = clear.iter().position(|is_clear| !is_clear);
        let last = first_unclear.map_or(self.last, |look| look.min(self.last));
        for (models, extent) in self.models.iter_mut() {
            *extent = models.extent(last);
        }
        Looked {
            last,
            are_clear: first_unclear.is_none(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::block::BlockFlow;
    use crate::flow::drive::Undriven;
    use crate::flow::{FlowRows, Quantity};
    use crate::modal::Block;
    use pulp::Scalar;

    const BLOCKS: [Block; 3] = [
        Block::Oscillator { w2: 2.0, eta: 0.1 },
        Block::Oscillator { w2: 9.0, eta: 5.0 },
        Block::Spiral {
            sigma: 0.0,
            omega: 1.3,
        },
    ];

    /// A sixteenth of the longest step.
    const LEVEL: usize = 64;

    /// Looks ahead from a state at gaps of some clearances, in registers and without.
    fn looked(clearances: &[f64]) -> [(Looked, Vec<(LookModels, [f64; 2])>); 2] {
        let flow = BlockFlow::new(&BLOCKS, Undriven);
        let row = [[1.0, 0.0], [0.4, 0.1], [0.7, -0.2]];
        let gap = |&c: &f64| Followed::new(flow.gap_row(&Quantity::gap(c, &row)));
        let gaps: Vec<Followed> = clearances.iter().map(gap).collect();
        let mut search = ContactSearch::new(&flow, Vec::new());
        search.levels.prepare(&flow, LEVEL, 3);
        let strides = search.levels.strides(&flow, LEVEL).expect("free");
        let active: Vec<usize> = (0..gaps.len()).collect();
        let (mut looks, mut models) = (Vec::new(), Vec::new());
        let mut ahead = |in_registers: bool| {
            let work = LooksAhead {
                flow: &flow,
                strides,
                step: search.levels.step(LEVEL),
                last: LOOKS - 1,
                state: &[[0.1, 1.5], [0.1, -0.2], [0.3, 0.4]],
                gaps: &gaps,
                active: &active,
                looks: &mut looks,
                models: &mut models,
            };
            let looked = if in_registers {
                Arch::new().dispatch(work)
            } else {
                work.with_simd(Scalar)
            };
            (looked, models.clone())
        };
        [ahead(true), ahead(false)]
    }

    #[test]
    fn registers_change_no_bit() {
        let [(a, in_registers), (b, one_by_one)] = looked(&[1.5, 0.8, 9.0]);
        assert_eq!((a.last, a.are_clear), (b.last, b.are_clear));
        for ((a, of_a), (b, of_b)) in in_registers.iter().zip(&one_by_one) {
            let bits = |m: &LookModels| {
                let numbers = m.c.iter().chain([&m.quartic, &m.size]).flatten();
                numbers.map(|x| x.to_bits()).collect::<Vec<_>>()
            };
            assert_eq!((bits(a), of_a), (bits(b), of_b));
        }
    }

    #[test]
    fn the_search_goes_to_the_look_before_the_first_step_that_is_not_clear() {
        let [(far, models), _] = looked(&[9.0]);
        assert!(far.are_clear && far.last == LOOKS - 1);
        let gaps = models[0].0.c[0];
        // A stop that the fourth look just reaches, and another beyond.
        let nearer = 9.0 - gaps[3] - 1e-6;
        let [(near, _), _] = looked(&[9.0, nearer]);
        let first_passed = gaps.iter().position(|gap| gap - gaps[3] - 1e-6 < 0.0);
        assert!(!near.are_clear);
        assert!(near.last < first_passed.expect("one"), "{}", near.last);
        let (least, extent) = (near.last, models[0].1);
        assert!(extent[1] >= gaps[least].abs());
    }
}
