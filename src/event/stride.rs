//! Steps of the search for the next impact, as many at once as are proved to hold none: eight samples ahead in the widest registers,
//! where a flow has them, one otherwise (theory 8).

use crate::event::next::{ContactSearch, Grazed, StepAdvance};
use crate::event::tracked_gap::TrackedGap;
use crate::flow::LinearFlow;
use crate::flow::samples::{
    SAMPLES_AT_ONCE, SampleDerivatives, SampleMask, SampleModels, Stride, eight,
};
use crate::modal::Pair;
use pulp::{Arch, Simd, WithSimd};

impl<F: LinearFlow> ContactSearch<'_, F> {
    /// Advances from a time by the step that is proved to hold no contact, and by the steps after it that are clear of contacts, up to the
    /// end of a span; the propagator of the level must be prepared.
    #[inline]
    pub(super) fn go_on(&mut self, time: f64, span: f64, grazes: &mut Vec<Grazed>) -> StepAdvance {
        let is_late = |&stop: &usize| self.gaps[stop].late != 0.0;
        let strides = self.levels.strides(self.flow, self.level);
        match strides {
            Some(strides) if !self.active.iter().any(is_late) => {
                self.samples.resize_with(self.state.len(), Default::default);
                self.models.resize_with(self.active.len(), Default::default);
                let step = self.levels.step(self.level);
                let is_end = |&sample: &usize| time + (sample + 1) as f64 * step >= span;
                let ahead = SamplesAhead {
                    flow: self.flow,
                    strides,
                    step,
                    last: (0..SAMPLES_AT_ONCE - 1)
                        .find(is_end)
                        .unwrap_or(SAMPLES_AT_ONCE - 1),
                    state: &self.state,
                    gaps: &self.gaps,
                    active: &self.active,
                    samples: &mut self.samples,
                    models: &mut self.models,
                };
                let reached = Arch::new().dispatch(ahead);
                self.go_to_sample(reached, time, grazes)
            }
            _ => self.go_one_step(time, grazes),
        }
    }

    /// The time in a step at which a stop is reached, improved from what the cubic at the start of the step gives: by the cubic of the nearer
    /// one of the two samples around it, plus a fourth power that fits the gap at the other sample.
    pub(super) fn between_samples(&self, stop: usize, at: f64, step: f64) -> f64 {
        let beyond = self.beyond.and_then(|(sample, after)| {
            let place = self.active.iter().position(|&other| other == stop)?;
            Some((self.models[place].at(sample), after))
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

    /// Advances by one step.
    fn go_one_step(&mut self, time: f64, grazes: &mut Vec<Grazed>) -> StepAdvance {
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
        StepAdvance {
            count: 1,
            are_clear: true,
        }
    }

    /// Advances to the last sample that was reached.
    fn go_to_sample(
        &mut self,
        reached: SamplesReached,
        time: f64,
        grazes: &mut Vec<Grazed>,
    ) -> StepAdvance {
        let SamplesReached { last, are_clear } = reached;
        let step = self.levels.step(self.level);
        let first = time + step;
        for (z, sample) in self.state.iter_mut().zip(&self.samples) {
            *z = sample.pair(last);
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
        self.beyond = (last + 1 < SAMPLES_AT_ONCE).then_some((last + 1, step));
        StepAdvance {
            count: last + 1,
            are_clear,
        }
    }
}

/// The work of taking the samples ahead, in registers of some kind.
struct SamplesAhead<'a, F> {
    flow: &'a F,
    strides: &'a [Stride],
    step: f64,
    /// The first sample at or beyond the end of the span; the eighth where none is.
    last: usize,
    state: &'a [Pair],
    gaps: &'a [TrackedGap],
    active: &'a [usize],
    samples: &'a mut [SampleDerivatives],
    models: &'a mut [SampleModels],
}

/// How far the samples ahead allow to advance.
struct SamplesReached {
    /// The last sample before which every step after the first is clear of contacts.
    last: usize,
    /// Whether the steps after all eight samples are clear.
    are_clear: bool,
}

impl<F: LinearFlow> WithSimd for SamplesAhead<'_, F> {
    type Output = SamplesReached;

    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> SamplesReached {
        self.flow.sample(self.strides, self.state, self.samples);
        let mut clear = SampleMask::MAX;
        for (&stop, models) in self.active.iter().zip(self.models.iter_mut()) {
            let gap = &self.gaps[stop];
            *models = gap.row.models(self.samples);
            clear &= models.above(gap.clear, gap.bracket.floor, self.step);
        }
        let first_unclear = clear.trailing_ones() as usize;
        let last = first_unclear.min(self.last);
        let is_counted = eight(|k| f64::from(u8::from(k <= last)));
        for models in self.models.iter_mut() {
            models.note_extent(&is_counted);
        }
        SamplesReached {
            last,
            are_clear: first_unclear == SAMPLES_AT_ONCE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::first_root::FirstRoot;
    use crate::flow::block::BlockFlow;
    use crate::flow::drive::Undriven;
    use crate::flow::{FlowRows, Quantity};
    use crate::modal::Block;
    use crate::observer::Observer;
    use crate::quantity::larger;
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
    fn reached(clearances: &[f64]) -> [(SamplesReached, Vec<SampleModels>); 2] {
        let flow = BlockFlow::new(&BLOCKS, Undriven);
        let row = [[1.0, 0.0], [0.4, 0.1], [0.7, -0.2]];
        let gap = |&c: &f64| TrackedGap::new(flow.gap_row(&Quantity::gap(c, &row)));
        let gaps: Vec<TrackedGap> = clearances.iter().map(gap).collect();
        let mut search = ContactSearch::new(&flow, Vec::new());
        search.levels.prepare(&flow, LEVEL, 3);
        let strides = search.levels.strides(&flow, LEVEL).expect("free");
        let active: Vec<usize> = (0..gaps.len()).collect();
        let state = [[0.1, 1.5], [0.1, -0.2], [0.3, 0.4]];
        let mut samples = [SampleDerivatives::default(); 3];
        let mut models = vec![SampleModels::default(); gaps.len()];
        let mut ahead = |in_registers: bool| {
            let work = SamplesAhead {
                flow: &flow,
                strides,
                step: search.levels.step(LEVEL),
                last: SAMPLES_AT_ONCE - 1,
                state: &state,
                gaps: &gaps,
                active: &active,
                samples: &mut samples,
                models: &mut models,
            };
            let reached = if in_registers {
                Arch::new().dispatch(work)
            } else {
                work.with_simd(Scalar)
            };
            (reached, models.clone())
        };
        [ahead(true), ahead(false)]
    }

    #[test]
    fn registers_change_no_bit() {
        let [(a, in_registers), (b, one_by_one)] = reached(&[1.5, 0.8, 9.0]);
        assert_eq!((a.last, a.are_clear), (b.last, b.are_clear));
        for (a, b) in in_registers.iter().zip(&one_by_one) {
            let bits = |m: &SampleModels| {
                let numbers = m.c.iter().chain([&m.quartic, &m.size]).flatten();
                let bits = numbers.chain(&m.extent).map(|x| x.to_bits());
                bits.collect::<Vec<_>>()
            };
            assert_eq!(bits(a), bits(b));
        }
    }

    #[test]
    fn a_contact_between_two_samples_is_found_to_the_fifth_power_of_their_distance() {
        // `sin t` before a stop at a clearance.
        let flow = BlockFlow::new(&[Block::Oscillator { w2: 1.0, eta: 0.0 }], Undriven);
        let state = [[0.0, 1.0]];
        let mut found = 0;
        for clearance in (1..90).map(|k| 0.01 * f64::from(k)) {
            let gap = flow.gap_row(&Quantity::gap(clearance, &[[1.0, 0.0]]));
            let mut search = ContactSearch::new(&flow, vec![gap]);
            search.level = LEVEL;
            search.evaluate(&state);
            let observer = &mut Observer::default();
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
    fn the_search_goes_to_the_sample_before_the_first_step_that_is_not_clear() {
        let [(far, models), _] = reached(&[9.0]);
        assert!(far.are_clear && far.last == SAMPLES_AT_ONCE - 1);
        let gaps = models[0].c[0];
        // A stop that the fourth sample just reaches, and another beyond.
        let nearer = 9.0 - gaps[3] - 1e-6;
        let [(near, models), _] = reached(&[9.0, nearer]);
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
