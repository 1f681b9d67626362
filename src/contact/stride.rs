//! Steps of the search for the next impact, as many at once as are proved to hold none: eight looks ahead in the widest registers,
//! where a flow has them, one otherwise (theory 8).

use crate::contact::followed::Followed;
use crate::contact::next::{ContactSearch, Gone, Grazed};
use crate::flow::LinearFlow;
use crate::flow::looks::{LOOKS, LookDerivatives, LookModels, Stride, WhichLooks, eight};
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
                self.looks.resize_with(self.state.len(), Default::default);
                self.models.resize_with(self.active.len(), Default::default);
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

    /// The time in a step at which a stop is reached, found by the cubic at its beginning: by that of the nearer of the two looks about it,
    /// with a fourth power that leads through the gap at the other.
    pub(super) fn between_looks(&self, stop: usize, at: f64, step: f64) -> f64 {
        let beyond = self.beyond.and_then(|(look, after)| {
            let place = self.active.iter().position(|&other| other == stop)?;
            Some((self.models[place].at(look), after))
        });
        let Some((beyond, after)) = beyond else {
            return at;
        };
        let here = &self.gaps[stop].model;
        let (near, far, from, to) = if 2.0 * at < after {
            (here, &beyond, 0.0, after)
        } else {
            (&beyond, here, after, -after)
        };
        let fourth = (far.c[0] - near.value(to)) / (to * to * (to * to));
        let mut r = at - from;
        for _ in 0..2 {
            r -= (near.value(r) + fourth * (r * r * (r * r))) / near.slope(r);
        }
        let there = from + r;
        if (0.0..=step).contains(&there) {
            there
        } else {
            at
        }
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
            let (stop, models) = (self.active[k], &self.models[k]);
            let gap = &mut self.gaps[stop];
            // A gap that turns in a clear step is clear there: of the first step that is not known.
            let has_turned = gap.follow(first, models.at(0));
            let (at_first, at_last) = (gap.model, models.at(last));
            if last > 0 {
                gap.widen(models.extent);
                gap.bracket
                    .note(time + (last + 1) as f64 * step, at_last.c[0]);
            }
            if has_turned {
                self.note_turn(stop, first, &at_first, grazes);
            }
            self.gaps[stop].model = at_last;
        }
        self.n_gap_evaluations += self.active.len() * (last + 1);
        self.beyond = (last + 1 < LOOKS).then_some((last + 1, step));
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
    looks: &'a mut [LookDerivatives],
    models: &'a mut [LookModels],
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
        let mut clear = WhichLooks::MAX;
        for (&stop, models) in self.active.iter().zip(self.models.iter_mut()) {
            let gap = &self.gaps[stop];
            *models = gap.row.models(self.looks);
            clear &= models.above(gap.clear, gap.bracket.floor, self.step);
        }
        let first_unclear = clear.trailing_ones() as usize;
        let last = first_unclear.min(self.last);
        let is_seen = eight(|k| f64::from(u8::from(k <= last)));
        for models in self.models.iter_mut() {
            models.note_extent(&is_seen);
        }
        Looked {
            last,
            are_clear: first_unclear == LOOKS,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::first_root::FirstRoot;
    use crate::flow::block::BlockFlow;
    use crate::flow::drive::Undriven;
    use crate::flow::{FlowRows, Quantity};
    use crate::modal::Block;
    use crate::observer::Observer;
    use crate::quantity::larger;
    use pulp::Scalar;
    use std::ops::ControlFlow;

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
    fn looked(clearances: &[f64]) -> [(Looked, Vec<LookModels>); 2] {
        let flow = BlockFlow::new(&BLOCKS, Undriven);
        let row = [[1.0, 0.0], [0.4, 0.1], [0.7, -0.2]];
        let gap = |&c: &f64| Followed::new(flow.gap_row(&Quantity::gap(c, &row)));
        let gaps: Vec<Followed> = clearances.iter().map(gap).collect();
        let mut search = ContactSearch::new(&flow, Vec::new());
        search.levels.prepare(&flow, LEVEL, 3);
        let strides = search.levels.strides(&flow, LEVEL).expect("free");
        let active: Vec<usize> = (0..gaps.len()).collect();
        let state = [[0.1, 1.5], [0.1, -0.2], [0.3, 0.4]];
        let mut looks = [LookDerivatives::default(); 3];
        let mut models = vec![LookModels::default(); gaps.len()];
        let mut ahead = |in_registers: bool| {
            let work = LooksAhead {
                flow: &flow,
                strides,
                step: search.levels.step(LEVEL),
                last: LOOKS - 1,
                state: &state,
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
        for (a, b) in in_registers.iter().zip(&one_by_one) {
            let bits = |m: &LookModels| {
                let numbers = m.c.iter().chain([&m.quartic, &m.size]).flatten();
                let bits = numbers.chain(&m.extent).map(|x| x.to_bits());
                bits.collect::<Vec<_>>()
            };
            assert_eq!(bits(a), bits(b));
        }
    }

    #[test]
    fn a_contact_between_two_looks_is_found_to_the_fifth_power_of_their_distance() {
        // `sin t` before a stop at a clearance.
        let flow = BlockFlow::new(&[Block::Oscillator { w2: 1.0, eta: 0.0 }], Undriven);
        let state = [[0.0, 1.0]];
        let mut found = 0;
        for clearance in (1..90).map(|k| 0.01 * f64::from(k)) {
            let gap = flow.gap_row(&Quantity::gap(clearance, &[[1.0, 0.0]]));
            let mut search = ContactSearch::new(&flow, vec![gap]);
            search.level = LEVEL;
            search.evaluate(&state);
            let go_on = &mut || ControlFlow::Continue(());
            let observer = &mut Observer::new(go_on);
            let event = search.next(&state, &[0], 3.0, &mut Vec::new(), observer);
            let FirstRoot::Crossing { at, .. } = event.expect("not broken off").root else {
                panic!("{clearance}: no contact");
            };
            if let Some((_, distance)) = search.beyond {
                let left = f64::powi(0.5 * distance, 4) * distance / 120.0;
                let time = f64::asin(clearance);
                let error = (at - time).abs() * f64::cos(time);
                assert!(error <= 1.1 * left, "{clearance}: {error:e} {left:e}");
                found += 1;
            }
        }
        assert!(found > 60, "{found}");
    }

    #[test]
    fn the_search_goes_to_the_look_before_the_first_step_that_is_not_clear() {
        let [(far, models), _] = looked(&[9.0]);
        assert!(far.are_clear && far.last == LOOKS - 1);
        let gaps = models[0].c[0];
        // A stop that the fourth look just reaches, and another beyond.
        let nearer = 9.0 - gaps[3] - 1e-6;
        let [(near, models), _] = looked(&[9.0, nearer]);
        let first_passed = gaps.iter().position(|gap| gap - gaps[3] - 1e-6 < 0.0);
        assert!(!near.are_clear);
        assert!(near.last < first_passed.expect("one"), "{}", near.last);
        let seen = |numbers: &[f64]| {
            numbers[..=near.last]
                .iter()
                .fold(0.0, |x, y| larger(x, y.abs()))
        };
        for models in models {
            assert_eq!(models.extent, [seen(&models.size), seen(&models.c[0])]);
        }
    }
}
