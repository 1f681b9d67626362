//! Impacts on one stop that accumulate, taken at once in the limit of low flights (theory 9). Formulas only: a run decides in
//! `hybrid/resolver/chatter.rs` when it completes them, an orbit in `hybrid/chatter_map.rs`.
//!
//! `h' < 0` is the speed before an impact, `h'' = a < 0` the acceleration of the free motion. The flights are so short that a does not
//! change over all of them together: each impact leaves `-e h'`, and the next comes after `2 e h'/a` with the speed `e h'`. Speeds
//! and times are geometric series with the ratio e.

use crate::law::Newton;
use nalgebra::DVector;

/// All impacts that follow one on a stop, itself included: `0 < e < 1`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CompleteChatter {
    /// The law of the stop.
    pub law: Newton,
    /// The opening speed h' before the first impact, negative.
    pub speed: f64,
    /// The acceleration h'' of the gap in free motion, negative.
    pub acceleration: f64,
}

impl CompleteChatter {
    /// The time from the first impact to where they come to rest, `2 e h'/((1 - e) a)`.
    pub fn span(&self) -> f64 {
        let e = self.law.restitution;
        2.0 * e * self.speed / ((1.0 - e) * self.acceleration)
    }

    /// The time from the first impact to the second, `2 e h'/a`.
    pub fn first_flight(&self) -> f64 {
        2.0 * self.law.restitution * self.speed / self.acceleration
    }

    /// What is left of the gap when all are taken at once, `2 e h'^2/((1 - e) |a|)`: an estimate of what that neglects.
    pub fn residual(&self) -> f64 {
        let e = self.law.restitution;
        2.0 * e / (1.0 - e) * self.speed * self.speed / -self.acceleration
    }

    /// The height of the first flight times the acceleration that draws it back, `(e h')^2/2`.
    pub fn height_by_acceleration(&self) -> f64 {
        0.5 * self.law.departure(self.speed).powi(2)
    }

    /// The change of another speed by all impulses, of each of which it receives a share, `(1 + e)/(1 - e) share h'`.
    pub fn kick(&self, share: f64) -> f64 {
        let e = self.law.restitution;
        self.law.factor() / (1.0 - e) * share * self.speed
    }

    /// The change of a state up to where they come to rest, from its rate before the first impact and its change by that impact. Orbits
    /// change so; runs hold the stop instead.
    pub fn change(&self, rate: DVector<f64>, struck: DVector<f64>) -> DVector<f64> {
        rate * self.span() + struck / (1.0 - self.law.restitution)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dvector;

    const E: f64 = 0.7;

    fn falling() -> CompleteChatter {
        CompleteChatter {
            law: Newton::known(E),
            speed: -3.0,
            acceleration: -2.0,
        }
    }

    /// Impact after impact of a ball: the speed before each, and when it comes.
    fn impacts() -> impl Iterator<Item = (f64, f64)> {
        let all = falling();
        (0..200).scan((0.0, all.speed), move |(time, speed), _| {
            let here = (*time, *speed);
            *time += 2.0 * E * *speed / all.acceleration;
            *speed *= E;
            Some(here)
        })
    }

    #[test]
    fn the_span_is_the_sum_of_the_flights() {
        let (last, _) = impacts().last().expect("some");
        assert!((falling().span() - last).abs() < 1e-14 * last);
        let (second, _) = impacts().nth(1).expect("some");
        assert_eq!(falling().first_flight(), second);
    }

    #[test]
    fn a_first_flight_rises_to_its_height() {
        let (all, rise) = (falling(), 0.5 * falling().first_flight());
        let height = -E * all.speed * rise + 0.5 * all.acceleration * rise * rise;
        assert!((all.height_by_acceleration() - height * -all.acceleration).abs() < 1e-14);
    }

    #[test]
    fn the_kick_is_the_sum_of_the_impulses() {
        let share = 0.25;
        let sum: f64 = impacts().map(|(_, speed)| (1.0 + E) * share * speed).sum();
        assert!((falling().kick(share) - sum).abs() < 1e-14);
    }

    #[test]
    fn a_ball_ends_on_its_stop_at_rest() {
        let all = falling();
        let before = dvector![0.0, all.speed];
        let rate = dvector![all.speed, all.acceleration];
        let struck = dvector![0.0, -E * all.speed];
        let end = &before + all.change(rate, struck - &before);
        // Off the stop by what is left of the gap.
        assert!(end[1].abs() < 1e-14);
        assert!((end[0].abs() - all.residual()).abs() < 1e-14);
    }
}
