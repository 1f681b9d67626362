//! Whether an orbit closes (theory 5). The conditions are solved backwards, from the inverse of `I - e^{AT}` or a bordered
//! system; here each flight is gone through once more, forwards and along the flow that simulations use, and every contact is
//! looked at.

use crate::flow::{LinearFlow, ModalScene, along};
use crate::modal::{Block, Form, ModalState, Pair};
use crate::model::Moment;
use crate::orbit::orbit_data::OrbitArc;
use crate::tolerance::{CLOSING_ROUNDING, ELASTIC_SPEED_PART, FLIGHTS_CLOSED};

/// Points of a flight at which the size of its motion is evaluated, where its ends say too little. [work]
const FLIGHT_SIZE_POINTS: usize = 64;

/// Sizes of position and velocity, and the elastic speed.
#[derive(Debug, Clone, Copy, Default)]
struct Size {
    position: f64,
    velocity: f64,
    elastic: f64,
}

impl Size {
    /// The size of a state in modal pairs: by the energy norm where the modes are real, of the coordinates elsewhere.
    fn of(scene: &ModalScene, state: &ModalState) -> Self {
        if let (Some(_), Form::Blocks(blocks)) = (scene.form.shapes(), &scene.form.form) {
            let [mut position, mut velocity, mut elastic] = [0.0; 3];
            for (z, block) in state.iter().zip(blocks) {
                position += z[0] * z[0];
                velocity += z[1] * z[1];
                if let Block::Oscillator { w2, .. } = block {
                    elastic += w2.abs() * z[0] * z[0];
                }
            }
            return Self {
                position: position.sqrt(),
                velocity: velocity.sqrt(),
                elastic: elastic.sqrt(),
            };
        }
        let (q, v) = scene.form.to_physical(state);
        let strained = scene.system.solve_mass(&scene.system.stiffness().times(&q));
        let fastest = scene.form.fastest_rate();
        Self {
            position: q.norm(),
            velocity: v.norm(),
            elastic: if fastest > 0.0 {
                strained.norm() / fastest
            } else {
                0.0
            },
        }
    }

    fn max(self, other: Self) -> Self {
        Self {
            position: self.position.max(other.position),
            velocity: self.velocity.max(other.velocity),
            elastic: self.elastic.max(other.elastic),
        }
    }

    /// A misfit relative to the size of the motion.
    fn relative_to(self, motion: Self) -> f64 {
        let part = |x: f64, size: f64| if x > 0.0 { x / size } else { x };
        let velocity = motion.velocity + ELASTIC_SPEED_PART * motion.elastic;
        let (x, y) = (
            part(self.position, motion.position),
            part(self.velocity, velocity),
        );
        // The one that is not a number, if one is.
        if y > x || y.is_nan() { y } else { x }
    }
}

/// Moves states along a flow over flights, the propagator of the last span kept.
pub(crate) struct FlightPropagator<'a, F: LinearFlow> {
    flow: &'a F,
    scene: &'a ModalScene,
    span: f64,
    propagator: F::Propagator,
    state: Vec<Pair>,
    end: ModalState,
}

impl<'a, F: LinearFlow> FlightPropagator<'a, F> {
    /// A carrier along the flow of a scene.
    pub fn new(scene: &'a ModalScene, flow: &'a F) -> Self {
        Self {
            flow,
            scene,
            span: f64::NAN,
            propagator: F::Propagator::default(),
            state: Vec::new(),
            end: ModalState::default(),
        }
    }

    /// Moves the state at the start of a flight on by a time, into `self.end`.
    fn propagate(&mut self, phase: f64, flight: &OrbitArc, span: f64) {
        if span != self.span {
            self.flow.prepare(span, &mut self.propagator);
            self.span = span;
        }
        let at = Moment::of_angle(self.scene.frequency * flight.start + phase);
        self.flow
            .state_from_modal(&flight.after, at, &mut self.state);
        self.flow.advance(&self.propagator, &mut self.state);
        self.flow.modal_from_state(&self.state, &mut self.end);
    }

    /// The end of a free flight.
    pub fn end(&mut self, phase: f64, flight: &OrbitArc) -> &ModalState {
        self.propagate(phase, flight, flight.span);
        &self.end
    }

    /// By how much the flights miss their ends, and the contacts their stops, relative to the size of the motion; of free
    /// flights.
    fn misfit(&mut self, phase: f64, flights: &[OrbitArc]) -> f64 {
        let (mut missed, mut motion) = (Size::default(), Size::default());
        for flight in flights {
            self.propagate(phase, flight, flight.span);
            for (end, expected) in self.end.iter_mut().zip(&flight.before_next) {
                *end = [end[0] - expected[0], end[1] - expected[1]];
            }
            // A misfit that is no number is one.
            let here = Size::of(self.scene, &self.end);
            if !(here.position.is_finite() && here.velocity.is_finite()) {
                return f64::INFINITY;
            }
            missed = missed.max(here);
            for state in [&flight.after, &flight.before_next] {
                motion = motion.max(Size::of(self.scene, state));
            }
        }
        missed.position = missed.position.max(self.gap(phase, flights));
        let misfit = missed.relative_to(motion);
        if misfit <= FLIGHTS_CLOSED {
            return misfit;
        }
        // At the contacts the motion may be little beside what it is elsewhere.
        for flight in flights {
            for i in 1..FLIGHT_SIZE_POINTS {
                self.propagate(
                    phase,
                    flight,
                    flight.span * i as f64 / FLIGHT_SIZE_POINTS as f64,
                );
                motion = motion.max(Size::of(self.scene, &self.end));
            }
        }
        missed.relative_to(motion)
    }

    /// The same where it is more than rounding explains.
    pub fn lost(&mut self, phase: f64, flights: &[OrbitArc]) -> Option<f64> {
        let misfit = self.misfit(phase, flights);
        (!is_closed(self.scene, flights, misfit)).then_some(misfit)
    }

    /// The largest gap at a contact, as a position.
    fn gap(&self, phase: f64, flights: &[OrbitArc]) -> f64 {
        let (scene, mut gap) = (self.scene, 0.0f64);
        for flight in flights {
            for &stop in flight.hits() {
                let row = &scene.position_rows[stop];
                let seen = along(row, &flight.after);
                let length = row.iter().flatten().map(|r| r * r).sum::<f64>().sqrt();
                let at = Moment::of_angle(scene.frequency * flight.start + phase);
                let clearance = scene.geometry.clearances[stop] + scene.stop_motion(stop, at)[0];
                gap = gap.max((clearance - seen).abs() / length);
            }
        }
        gap
    }
}

/// Whether a misfit is one of rounding, for flights of the given spans.
fn is_closed(scene: &ModalScene, flights: &[OrbitArc], misfit: f64) -> bool {
    if misfit <= FLIGHTS_CLOSED {
        return true;
    }
    let span: f64 = flights.iter().map(|f| f.span).sum();
    misfit <= CLOSING_ROUNDING * (scene.form.fastest_growth() * span).exp()
}
