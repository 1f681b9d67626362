//! Impacts that accumulate: their end, in the referee's run.

use crate::runs::double_double::{Dd, dot};
use crate::runs::record::Stretch;
use crate::runs::simulator::{Contact, Run};

impl Run<'_> {
    /// The rest of impacts that accumulate, as a geometric series, once its flights are short enough.
    pub fn complete(&mut self, stop: usize) {
        let e = self.model.stops[stop].restitution;
        let held = self.held.clone();
        let motion = self.motion(&held).expect("settled");
        let accelerations = motion.acceleration(&self.x);
        let curvature = |i: usize| -dot(&self.model.stops[i].normal, &accelerations).to_f64();
        let (speed, a) = (self.model.opening(stop, &self.x), curvature(stop));
        if e >= 1.0 || e == 0.0 || a >= 0.0 {
            return;
        }
        let flight = 2.0 * speed.to_f64() / -a;
        let duration = flight / (1.0 - e);
        let mut is_short = flight * self.model.rate < 1e-9;
        if let Some(roughness) = self.roughness {
            let previous = self
                .record
                .hits
                .iter()
                .rev()
                .skip(1)
                .find(|hit| hit.stop == stop);
            let is_regular =
                previous.is_some_and(|hit| (speed.to_f64() / hit.departure / e - 1.0).abs() < 0.05);
            let residual = 8.0 * speed.to_f64().powi(2) / (e * (1.0 - e)) / -a;
            is_short |= is_regular
                && residual
                    < roughness.completion * self.size(stop).max(self.record.q_size)
                        + roughness.least;
        }
        let others_stay = (0..self.contacts.len()).all(|i| {
            if i == stop || self.contacts[i] == Contact::Held {
                return true;
            }
            let (gap, opening, bend) = (
                self.model.gap(i, &self.x).to_f64(),
                self.model.opening(i, &self.x).to_f64(),
                curvature(i),
            );
            match self.contacts[i] {
                Contact::Leaving(_) => bend >= 0.0 || 2.0 * opening / -bend > 2.0 * duration,
                _ => gap > 2.0 * duration * (opening.abs() + duration * bend.abs()),
            }
        });
        let mut all = held;
        all.push(stop);
        all.sort_unstable();
        if !is_short || !others_stay || duration > 0.5 * self.model.step {
            return;
        }
        let Some(motion) = self.motion(&all) else {
            return;
        };
        // The normal speeds vanish; the held motion takes the time of the series.
        let inner = self.model.delassus.part(&all);
        let closing: Vec<Dd> = all
            .iter()
            .map(|&i| -self.model.opening(i, &self.x))
            .collect();
        let Some(p) = inner.solve(&closing) else {
            return;
        };
        self.push(&all, &p);
        let passed = speed * 2.0 / Dd::from(-a) / (Dd::ONE - Dd::from(e));
        self.sample(&motion, passed);
        self.x = motion.advance(&self.x, passed);
        let start = self.time.to_f64();
        self.time += passed;
        self.record.chatters.push(Stretch {
            stop,
            start,
            end: self.time.to_f64(),
        });
        let mut stays = self.held_stops();
        stays.push(stop);
        self.settle(&stays);
    }
}
