//! What is known of contacts where a flight begins, from which a run goes on as if it had not ended.

use super::Resolver;
use crate::hybrid::pen::Pen;
use crate::hybrid::system::HybridSystem;
use crate::law::Regime;

impl Resolver {
    /// Puts down what is known where a flight begins, or takes it up.
    pub fn carry(&mut self, pen: &mut Pen) {
        self.root_orders.carry(pen);
        for numbers in [
            &mut self.sizes,
            &mut self.reaches,
            &mut self.prior_sizes,
            &mut self.approaches,
        ] {
            pen.numbers(numbers);
        }
        for stops in [&mut self.held, &mut self.were_held, &mut self.zero_speed] {
            pen.counts(stops);
        }
        let mut regime = self.regime.written();
        pen.counts(&mut regime);
        match Regime::read(&regime) {
            Some(own) => self.regime = own,
            None => pen.lose(),
        }
        let mut last: Vec<(usize, f64)> = self.last_impact.into_iter().collect();
        pen.list(&mut last, |pen, (stop, speed)| {
            pen.count(stop);
            pen.number(speed);
        });
        self.last_impact = last.first().copied();
        self.releases.carry(pen);
        self.reclosings.carry(pen);
    }

    /// Takes up what was known of a system where a flight begins; whether that is of such a system.
    pub fn take_up<Y: HybridSystem + ?Sized>(&mut self, system: &Y, pen: &mut Pen) -> bool {
        self.forget(system);
        self.carry(pen);
        let n_stops = system.n_stops();
        let numbers = [
            &self.sizes,
            &self.reaches,
            &self.prior_sizes,
            &self.approaches,
        ];
        let stops = [&self.held, &self.were_held, &self.zero_speed];
        let mut stops = stops.into_iter().flatten().copied();
        let mut last = self.last_impact.iter();
        let others: Vec<usize> = self.regime.elements().collect();
        self.root_orders.are_of(n_stops)
            && numbers.iter().all(|numbers| numbers.len() == n_stops)
            && stops.all(|stop| stop < n_stops)
            && others
                .iter()
                .all(|element| self.compliant.contains(element))
            && last.all(|own| own.0 < n_stops)
    }

    /// Takes note of what is known before impacts that accumulate are completed, if only as far as the run goes.
    pub(super) fn note_cut(&mut self, is_cut: bool) {
        self.before_cut = is_cut.then(|| Box::new(self.clone()));
    }
}
