//! An orbit as a motion that is kept: one period of it, which repeats itself.

use crate::error::Result;
use crate::hybrid::clock::Clock;
use crate::impact::{Impact, wrapped};
use crate::model::{PhysicalState, Scene};
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::path::{
    ImpactSide, KeptMotion, Located, Motion, PathChapter, PathPoint, Stretch, Window, check_order,
};
use crate::quantity::finite;

impl KeptMotion for PeriodicOrbit {
    fn scene(&self) -> &Scene {
        self.scene()
    }

    fn span(&self) -> (f64, f64) {
        (0.0, self.period)
    }

    fn impacts(&self) -> &[Impact] {
        self.impacts()
    }

    fn chapters(&self) -> Result<Vec<PathChapter<'_>>> {
        Ok(vec![self.chapter()])
    }

    fn stretches_of<'a>(&'a self, chapter: &PathChapter<'a>) -> Vec<Stretch<'a>> {
        let flights = self.flights.iter().zip(&chapter.path.parts.segments);
        let stretches = flights.enumerate().map(|(segment, (flight, own))| Stretch {
            segment,
            kind: own.kind,
            regime: &own.regime,
            start: flight.start,
            end: flight.end,
        });
        stretches.collect()
    }

    fn place(&self, t: f64, side: ImpactSide) -> Result<(usize, Located)> {
        let (path, t) = (self.path(), finite("t", t)?);
        let point = match self.flight_position(t, side) {
            FlightPosition::End(k) => path.end_of(path.parts.arcs_of(k).end - 1, t),
            FlightPosition::Start(k) => path.point_along(k, 0.0),
            FlightPosition::Within(k, local) => path.point_along(k, local),
        };
        let state = self.state_at(t, side);
        Ok((0, Located { point, state }))
    }

    fn impulse_in(&self, stop: usize, window: Option<(f64, f64)>) -> Result<f64> {
        let impulses = self.chapter().impulses()?;
        let in_period = impulses.of_stop(stop, Window::ALL)?;
        let Some((start, end)) = window else {
            return Ok(in_period);
        };
        check_order((start, end))?;
        let [first, last] = [start, end].map(|t| self.periods_and_rest(t));
        let given = |rest: f64| impulses.of_stop(stop, Window::until(self.path(), rest));
        Ok((last.0 - first.0) * in_period + given(last.1)? - given(first.1)?)
    }

    fn forcing_phase(&self) -> Box<dyn Fn(f64) -> f64 + '_> {
        let clock = Clock::new(0.0, self.scene().frequency().unwrap_or(0.0));
        Box::new(move |t| wrapped(clock.at(t).angle() + self.phase()))
    }

    fn is_closed(&self) -> bool {
        true
    }
}

impl Motion for PeriodicOrbit {}

impl PeriodicOrbit {
    fn chapter(&self) -> PathChapter<'_> {
        PathChapter {
            path: self.path(),
            scene: self.scene(),
            impacts: self.impacts(),
            contact_impulses: &self.contact_impulses,
            accumulations: &[],
        }
    }

    /// Position and velocity at any time; at an impact the velocity is the one on a side of it.
    pub(crate) fn state_at(&self, t: f64, side: ImpactSide) -> PhysicalState {
        match self.flight_position(t, side) {
            FlightPosition::End(k) => self.motion.physical(&self.flights[k].before_next),
            FlightPosition::Start(k) => self.motion.physical(&self.flights[k].after),
            FlightPosition::Within(k, local) => {
                let PathPoint { arc, local, .. } = self.path().point_along(k, local);
                self.path().state_in(arc, local)
            }
        }
    }

    /// A time as whole periods and what is left of one; a time within rounding of an impact is the impact.
    fn periods_and_rest(&self, t: f64) -> (f64, f64) {
        let turns = (t / self.period).floor();
        match self.flight_position(t, ImpactSide::After) {
            FlightPosition::Start(0) => ((t / self.period).round(), 0.0),
            FlightPosition::Start(k) => (turns, self.flights[k].start),
            FlightPosition::End(_) | FlightPosition::Within(..) => {
                (turns, t.rem_euclid(self.period))
            }
        }
    }

    /// Where on the flights a time is.
    fn flight_position(&self, t: f64, side: ImpactSide) -> FlightPosition {
        let mut local = t.rem_euclid(self.period);
        if local >= self.period {
            local = 0.0;
        }
        // A time within rounding of an impact is the impact: times are often made by adding spans up.
        let at_impact =
            |start: f64| (local - start).abs() <= 4.0 * f64::EPSILON * t.abs().max(self.period);
        if !self.pattern.instants().is_empty() {
            let ends = self.flights.iter().map(|f| f.start + f.span).enumerate();
            for (k, end) in ends {
                let next = (k + 1) % self.flights.len();
                if at_impact(end) || (next == 0 && at_impact(0.0)) {
                    return if side == ImpactSide::Before {
                        FlightPosition::End(k)
                    } else {
                        FlightPosition::Start(next)
                    };
                }
            }
        }
        let k = self
            .flights
            .iter()
            .rposition(|f| f.start <= local)
            .unwrap_or(0);
        FlightPosition::Within(k, local - self.flights[k].start)
    }
}

/// Where on the flights of an orbit a time is.
enum FlightPosition {
    /// At the end of one, before the impacts there.
    End(usize),
    /// At the start of one.
    Start(usize),
    /// A time after its start.
    Within(usize, f64),
}
