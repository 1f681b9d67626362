//! Admissibility of an orbit (theory 6): the stops hit are approached and pushed, and no stop is passed at any other
//! time, by a search that proves what it passes over. A gap within [`ORBIT_MARGIN`] of the motion's size is a touch; an approach speed
//! within that margin times the rate of the motion makes the impact a graze.

use crate::error::Result;
use crate::event::levels::PropagatorLevels;
use crate::event::walk::{Sought, StopDepth, check_flight};
use crate::flow::{
    FlowRows, GapRow, LinearFlow, ModalScene, RegimeMotion, SceneFlow, along, with_flow,
};
use crate::impact::Impact;
use crate::modal::Pair;
use crate::model::Moment;
use crate::observer::Observer;
use crate::orbit::orbit_data::OrbitArc;
use crate::orbit::verdict::admissibility::{Admissibility, Breach, Rule};
use crate::orbit::verdict::closing::FlightPropagator;
use crate::orbit::verdict::lasting::{SearchSpan, is_low_bounce, search_regimes, search_stretch};
use crate::orbit::verdict::thrown::{HeldAtImpact, judge_thrown};
use crate::tolerance::ORBIT_MARGIN;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Judges the orbits of one scene; made once for all of them.
pub(crate) struct Judge<'a> {
    scene: &'a ModalScene,
    flow: Arc<SceneFlow>,
    /// The gap of every stop on the flow.
    gaps: Vec<GapRow>,
}

impl<'a> Judge<'a> {
    /// A judge for a scene.
    pub fn new(scene: &'a ModalScene) -> Self {
        let flow = scene.flow();
        let gaps = (0..scene.n_stops()).map(|stop| scene.gap(stop));
        let gaps = with_flow!(&*flow, f => gaps.map(|gap| f.gap_row(&gap)).collect());
        Self { scene, flow, gaps }
    }

    /// Whether each of some motions of one flight and one instant, given with their phases, closes.
    pub fn are_closed<'m>(
        &self,
        motions: impl Iterator<Item = (f64, &'m [OrbitArc])>,
    ) -> Vec<bool> {
        with_flow!(&*self.flow, f => {
            let mut carrier = FlightPropagator::new(self.scene, f);
            motions
                .map(|(phase, flights)| carrier.lost(phase, flights).is_none())
                .collect()
        })
    }

    /// Judges the impacts, and searches every flight for every stop.
    ///
    /// # Errors
    /// `Error::Interrupted` from the observer.
    pub fn admissibility(
        &mut self,
        phase: f64,
        flights: &[OrbitArc],
        impacts: &[Impact],
        observer: &mut Observer,
    ) -> Result<Admissibility> {
        self.admissibility_to_depth(StopDepth::FULL, phase, flights, impacts, observer)
    }

    /// Judges an orbit with lasting contact, given the motions while stops are held: the contact forces too, and the flights
    /// between impacts that accumulate as what they are.
    ///
    /// # Errors
    /// `Error::Interrupted` from the observer.
    pub fn with_lasting_contact(
        &mut self,
        regimes: &[Arc<RegimeMotion>],
        phase: f64,
        flights: &[OrbitArc],
        impacts: &[Impact],
        observer: &mut Observer,
    ) -> Result<Admissibility> {
        let scene = self.scene;
        let (margins, rate, mut found) = self.at_instants(phase, flights, impacts);
        self.judge_thrown(flights, impacts, |stop| margins[stop] * rate, &mut found)?;
        let gap = |stop: usize, t: f64, state: &[Pair]| self.gap(phase, stop, t, state);
        let free = flights.iter().filter(|flight| flight.is_flight());
        with_flow!(&*self.flow, f => {
            for flight in free {
                let on_flow = |t: f64, state| {
                    let mut entered = Vec::new();
                    let at = Moment::of_angle(scene.frequency * t + phase);
                    f.state_from_modal(state, at, &mut entered);
                    entered
                };
                let times = [flight.start, flight.end];
                let entered = on_flow(times[0], &flight.after);
                for (stop, row) in self.gaps.iter().enumerate() {
                    let [margin, span] = [margins[stop], flight.span];
                    let bend = |t: f64, state| {
                        let mut derivatives = Vec::new();
                        f.derivatives(&on_flow(t, state), &mut derivatives);
                        2.0 * row.model(&derivatives).c[2]
                    };
                    let [gap_after, opening] = gap(stop, times[0], &flight.after);
                    let [gap_before, closing] = gap(stop, times[1], &flight.before_next);
                    let is_low = |bends: [f64; 2]| {
                        let (start, end) = ([gap_after, opening, bends[0]], [gap_before, closing, bends[1]]);
                        is_low_bounce(start, end, span, margin)
                    };
                    // Few flights are so slow that their bends are asked for.
                    let bends = || [bend(times[0], &flight.after), bend(times[1], &flight.before_next)];
                    if is_low([0.0; 2]) && is_low(bends()) {
                        continue;
                    }
                    let stretch = SearchSpan {
                        span,
                        margin,
                        is_released: flight.departure() == Some(stop),
                    };
                    let mut state = entered.clone();
                    let (skipped, check) = search_stretch(f, row, &mut state, stretch, observer)?;
                    found.note(stop, flight.start + skipped, &check);
                }
            }
        });
        search_regimes(
            regimes,
            (scene, phase),
            &margins,
            flights,
            &mut found,
            observer,
        )?;
        Ok(found)
    }

    /// The same, searching a violation only to a depth.
    pub fn admissibility_to_depth(
        &mut self,
        effort: StopDepth,
        phase: f64,
        flights: &[OrbitArc],
        impacts: &[Impact],
        observer: &mut Observer,
    ) -> Result<Admissibility> {
        let scene = self.scene;
        let (margins, _, mut found) = self.at_instants(phase, flights, impacts);
        with_flow!(&*self.flow, f => {
            let start = |flight: &OrbitArc, state: &mut Vec<Pair>| {
                let at = Moment::of_angle(scene.frequency * flight.start + phase);
                f.state_from_modal(&flight.after, at, state);
            };
            search(f, (&self.gaps, &margins, effort), flights, start, &mut found, observer)?;
        });
        Ok(found)
    }

    /// What the rules say of the instants, with the margins of the stops and the rate of the motion.
    fn at_instants(
        &self,
        phase: f64,
        flights: &[OrbitArc],
        impacts: &[Impact],
    ) -> (Vec<f64>, f64, Admissibility) {
        let rate = rate(self.scene, flights);
        // Behind impacts that take all speed the states after say nothing of the motion's size.
        let ends = flights.iter().flat_map(|f| [&f.after, &f.before_next]);
        let margins = margins(self.scene, rate, ends.map(|state| state.as_slice()));
        let mut found = Admissibility::default();
        judge_impacts(impacts, |stop| margins[stop] * rate, &mut found);
        self.judge_ends(phase, flights, impacts, (&margins, rate), &mut found);
        (margins, rate, found)
    }

    /// The gap of a stop and its rate.
    fn gap(&self, phase: f64, stop: usize, t: f64, state: &[Pair]) -> [f64; 2] {
        let scene = self.scene;
        let at = Moment::new(t, scene.frequency * t + phase, scene.frequency);
        let [moved, receding, _] = scene.stop_motion(stop, at);
        let position = along(&scene.position_rows[stop], state);
        let speed = receding - along(&scene.velocity_rows[stop], state);
        [scene.geometry.clearances[stop] + moved - position, speed]
    }

    /// Judges the stops that are held where others are hit.
    fn judge_thrown(
        &self,
        flights: &[OrbitArc],
        impacts: &[Impact],
        slow: impl Fn(usize) -> f64,
        found: &mut Admissibility,
    ) -> Result<()> {
        let geometry = &self.scene.geometry;
        let following = flights.iter().cycle().skip(1);
        for (flight, next) in flights.iter().zip(following) {
            let own = HeldAtImpact {
                before: flight.regime(),
                after: next.regime(),
                time: next.start,
                impacts,
            };
            let coupling = |one: usize, other: usize| Ok(geometry.give(one, other));
            judge_thrown(own, coupling, &slow, found)?;
        }
        Ok(())
    }

    /// Judges the stops at the ends of flights that are not hit there.
    fn judge_ends(
        &self,
        phase: f64,
        flights: &[OrbitArc],
        impacts: &[Impact],
        (margins, rate): (&[f64], f64),
        found: &mut Admissibility,
    ) {
        let following = flights.iter().cycle().skip(1);
        for (flight, next) in flights.iter().zip(following) {
            for (stop, &margin) in margins.iter().enumerate() {
                if is_met(impacts, stop, next.start, [flight, next]) {
                    continue;
                }
                let time = flight.end;
                let gap = self.gap(phase, stop, time, &flight.before_next);
                judge_reached((stop, next.start), gap, (margin, margin * rate), found);
            }
        }
    }
}

/// Whether a stop is hit where a flight ends, or in lasting contact before or after.
pub(in crate::orbit) fn is_met(
    impacts: &[Impact],
    stop: usize,
    time: f64,
    arcs: [&OrbitArc; 2],
) -> bool {
    let mut hits = impacts.iter().filter(|impact| impact.time == time);
    hits.any(|impact| impact.stop == stop) || arcs.iter().any(|arc| arc.touches(stop))
}

/// A stop that is reached faster than `slow` where others are hit would be hit too.
pub(in crate::orbit) fn judge_reached(
    (stop, time): (usize, f64),
    [gap, speed]: [f64; 2],
    (margin, slow): (f64, f64),
    found: &mut Admissibility,
) {
    if gap.abs() <= margin && speed < -slow {
        found.keep_worst(Breach {
            stop,
            time,
            depth: 0.0,
            rule: Rule::Reached { approach: -speed },
        });
    }
}

/// Impacts are approached and push; `slow` is the speed below which one grazes. Where nothing that happens at an instant has more, nothing
/// happens there.
pub(in crate::orbit) fn judge_impacts(
    impacts: &[Impact],
    slow: impl Fn(usize) -> f64,
    found: &mut Admissibility,
) {
    for instant in impacts.chunk_by(|a, b| a.time == b.time) {
        let is_slow = |own: &Impact| own.approach.abs() <= slow(own.stop);
        let is_touch = instant.iter().all(is_slow);
        for own in instant {
            let &Impact {
                stop,
                time,
                approach,
                impulse,
                ..
            } = own;
            let rule = if is_touch {
                Some(Rule::Touches { approach })
            } else if impulse < 0.0 {
                Some(Rule::Pulls { impulse })
            } else if approach < -slow(stop) {
                Some(Rule::Leaves { approach })
            } else {
                None
            };
            if let Some(rule) = rule {
                found.keep_worst(Breach {
                    stop,
                    time,
                    depth: 0.0,
                    rule,
                });
            }
            found.has_grazing_impact |= is_slow(own);
        }
    }
}

/// Searches every flight for every stop along a flow, on which `start` puts the state of a flight.
fn search<F: LinearFlow>(
    flow: &F,
    (gaps, margins, effort): (&[GapRow], &[f64], StopDepth),
    flights: &[OrbitArc],
    start: impl Fn(&OrbitArc, &mut Vec<Pair>),
    found: &mut Admissibility,
    observer: &mut Observer,
) -> Result<()> {
    let mut state: Vec<Pair> = Vec::new();
    let mut levels = PropagatorLevels::new(flow);
    for (stop, (gap, &margin)) in gaps.iter().zip(margins).enumerate() {
        for flight in flights {
            if found
                .breach
                .is_some_and(|breach| breach.depth > effort.enough)
            {
                return Ok(());
            }
            start(flight, &mut state);
            let sought = Sought {
                span: flight.span,
                margin,
                stop_depth: effort,
            };
            let check = check_flight(flow, &mut levels, gap, &mut state, sought, observer)?;
            observer.work(state.len())?;
            found.note(stop, flight.start, &check);
        }
    }
    Ok(())
}

/// The rate of the motion: the forcing frequency, or that of the orbit where there is no forcing.
fn rate(scene: &ModalScene, flights: &[OrbitArc]) -> f64 {
    if scene.frequency > 0.0 {
        scene.frequency
    } else {
        TAU / flights.iter().map(|f| f.span).sum::<f64>()
    }
}

/// The margin of each stop, from some states of the motion.
fn margins<'s>(
    scene: &ModalScene,
    rate: f64,
    states: impl Iterator<Item = &'s [Pair]> + Clone,
) -> Vec<f64> {
    let stops = 0..scene.n_stops();
    stops
        .map(|stop| ORBIT_MARGIN * motion_size(scene, stop, rate, states.clone()))
        .collect()
}

/// The size of the motion along one normal, as far as some of its states show it.
fn motion_size<'s>(
    scene: &ModalScene,
    stop: usize,
    rate: f64,
    states: impl Iterator<Item = &'s [Pair]>,
) -> f64 {
    let row = &scene.position_rows[stop];
    states
        .map(|state| {
            let position: f64 = row
                .iter()
                .zip(state)
                .map(|(r, z)| (r[0] * z[0]).abs() + (r[1] * z[1]).abs())
                .sum();
            position + along(&scene.velocity_rows[stop], state).abs() / rate
        })
        .fold(scene.geometry.clearances[stop].abs(), f64::max)
}
