//! What moves an orbit: modal flights of a linear scene, or steps of an integrator. Both give the motion along a flight, the
//! impacts, the verdict of the rules of contact and the multipliers.

use crate::error::Result;
use crate::flow::steps::DenseOutput;
use crate::flow::{ModalScene, RegimeMotion, with_flow};
use crate::hybrid::ScaledUnits;
use crate::hybrid::clock::Clock;
use crate::hybrid::recorder::ArcSpan;
use crate::hybrid::{
    ClosedFormMaps, FlightPieces, HybridMaps, IntegratedMaps, OrbitDense, regime_motions,
};
use crate::impact::Impact;
use crate::itinerary::{closing, hits, monodromy};
use crate::law::Stage;
use crate::modal::ModalState;
use crate::model::PhysicalState;
use crate::observer::Observer;
use crate::orbit::impacts::{impacts_by, list_impacts};
use crate::orbit::orbit_data::OrbitArc;
use crate::orbit::stability::multipliers::{Stability, over_orders, stability};
use crate::orbit::verdict::admissibility::Admissibility;
use crate::orbit::verdict::another_route::closure_defect;
use crate::orbit::verdict::closing::FlightPropagator;
use crate::orbit::verdict::integrated::IntegratedJudge;
use crate::orbit::verdict::judge::Judge;
use crate::path::{Evaluator, Path, PathParts};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use std::sync::Arc;

/// What moves an orbit. The states of its flights are modal pairs of the first, pairs `(q_i, v_i)` of the second.
#[derive(Debug, Clone)]
pub(crate) enum OrbitMotion {
    Modal {
        modal: Arc<ModalScene>,
        /// The motions while stops are held.
        regimes: Vec<Arc<RegimeMotion>>,
    },
    Stepped {
        motion: Arc<IntegratedMaps>,
        /// The start and the pieces of each flight.
        pieces: Arc<Vec<(f64, FlightPieces)>>,
    },
}

/// `(q, v)` as pairs.
pub(crate) fn paired(state: &DVector<f64>) -> ModalState {
    let (q, v) = state.as_slice().split_at(state.len() / 2);
    q.iter().zip(v).map(|(&q, &v)| [q, v]).collect()
}

/// An arc of an orbit, from a time on.
fn arc_span(frequency: f64, start: f64, span: f64) -> ArcSpan {
    let start = Clock::new(start, frequency);
    let last = None;
    ArcSpan { start, span, last }
}

/// The inverse of [`paired`].
fn unpaired(state: &ModalState) -> DVector<f64> {
    let part = |k: usize| state.iter().map(move |z| z[k]);
    DVector::from_iterator(2 * state.len(), part(0).chain(part(1)))
}

impl OrbitMotion {
    /// The modal flights of a linear scene, along which stops may be held.
    pub fn modal_along(modal: Arc<ModalScene>, flights: &[OrbitArc]) -> Result<Self> {
        let drawn: Vec<_> = flights.iter().map(|flight| flight.drawn().1).collect();
        let regimes = regime_motions(&modal, drawn.iter())?;
        Ok(Self::Modal { modal, regimes })
    }

    /// The pieces of the flights of any scene.
    pub fn stepped(motion: IntegratedMaps, flights: &[OrbitArc]) -> Result<Self> {
        let states: Vec<_> = flights.iter().map(|own| unpaired(&own.after)).collect();
        let period = flights.iter().map(|own| own.span).sum();
        let units = ScaledUnits::of(states.iter(), period);
        let motion = Arc::new(motion.in_units(units));
        let pieces = |flight: &OrbitArc| {
            let (state, end) = (unpaired(&flight.after), unpaired(&flight.before_next));
            let span = (flight.start, flight.span);
            // The rest of impacts that accumulate is a line.
            let pieces = if flight.accumulation().is_some() {
                FlightPieces::line(flight.span, &state, &end)
            } else {
                motion.pieces(flight.regime(), span, &state)?
            };
            Ok((flight.start, pieces))
        };
        let pieces = Arc::new(flights.iter().map(pieces).collect::<Result<Vec<_>>>()?);
        Ok(Self::Stepped { motion, pieces })
    }

    /// Number of modal pairs, for a linear scene.
    pub fn modal_scene(&self) -> Option<&ModalScene> {
        match self {
            Self::Modal { modal, .. } => Some(modal),
            Self::Stepped { .. } => None,
        }
    }

    /// Position and velocity of a state.
    pub fn physical(&self, state: &ModalState) -> PhysicalState {
        match self {
            Self::Modal { modal, .. } => modal.form.to_physical(state),
            Self::Stepped { .. } => {
                let part =
                    |k: usize| DVector::from_iterator(state.len(), state.iter().map(|z| z[k]));
                (part(0), part(1))
            }
        }
    }

    /// One period as a path, its end closed by the start of the next.
    pub fn path(&self, phase: f64, flights: &[OrbitArc]) -> Path {
        let period = flights.iter().map(|flight| flight.span).sum();
        let first = &flights[0].after;
        let states = [first.clone(), first.clone()];
        let closing = OrbitArc::over(Stage::impact(&[]), [period, 0.0], states);
        let flights = flights.iter().chain([&closing]);
        let mut parts = PathParts::default();
        match self {
            Self::Modal { modal, .. } => {
                for flight in flights {
                    let (kind, regime) = flight.drawn();
                    let arc = arc_span(modal.frequency, flight.start, flight.span);
                    parts.begin(kind, &regime);
                    parts.push(&arc, flight.after.as_slice());
                }
            }
            Self::Stepped { motion, pieces } => {
                let closed = (period, motion.instant(&unpaired(first)));
                for (flight, (start, own)) in flights.zip(pieces.iter().chain([&closed])) {
                    let (kind, regime) = flight.drawn();
                    parts.begin(kind, &regime);
                    for ([local, h], numbers) in own.arcs() {
                        let arc = arc_span(motion.frequency, start + local, h);
                        parts.push(&arc, &*numbers);
                    }
                }
            }
        }
        Path {
            evaluator: self.evaluator(phase),
            parts,
            span: (0.0, period),
            n_dof: first.len(),
        }
    }

    fn evaluator(&self, phase: f64) -> Evaluator {
        match self {
            Self::Modal { modal, regimes } => Evaluator::Exact {
                modal: Arc::clone(modal),
                flow: modal.flow(),
                regimes: regimes.clone(),
                phase,
            },
            Self::Stepped { motion, .. } => match motion.series_order() {
                Some(order) => Evaluator::Series { order },
                None => Evaluator::Steps {
                    degree: OrbitDense::DEGREE,
                },
            },
        }
    }

    /// By how much flights of a linear scene miss their ends and contacts, relative to the size of the motion, where that is more than
    /// rounding explains.
    pub fn lost(&self, phase: f64, flights: &[OrbitArc]) -> Result<Option<f64>> {
        let Self::Modal { modal, .. } = self else {
            return Ok(None);
        };
        if !flights.iter().all(OrbitArc::is_flight) {
            return self.closure_defect(phase, flights, [0.0; 2]);
        }
        let lost =
            with_flow!(&*modal.flow(), f => FlightPropagator::new(modal, f).lost(phase, flights));
        Ok(lost)
    }

    /// By how much the motion misses its own ends by another route than the one that made it: free flights of a linear scene along the flow
    /// that simulations use, flights with stops held in two parts, integrated ones in the steps in which the orbit is kept.
    pub fn closure_defect(
        &self,
        phase: f64,
        flights: &[OrbitArc],
        least: [f64; 2],
    ) -> Result<Option<f64>> {
        let (modal, regimes) = match self {
            Self::Stepped { motion, pieces } => {
                let end = |k: usize| {
                    let end = pieces[k].1.end().map(|(_, x)| DVector::from_vec(x));
                    Ok(end.unwrap_or_else(|| unpaired(&flights[k].after)))
                };
                return closure_defect(&**motion, flights, unpaired, least, end);
            }
            Self::Modal { modal, regimes } => (modal, regimes),
        };
        let maps = ClosedFormMaps::new(modal, phase, regimes.clone());
        let state = |pairs: &ModalState| modal.form.state_of(pairs);
        with_flow!(&*modal.flow(), f => {
            let mut carrier = FlightPropagator::new(modal, f);
            closure_defect(&maps, flights, state, least, |k| {
                let flight = &flights[k];
                if flight.is_flight() {
                    return Ok(state(carrier.end(phase, flight)));
                }
                let mut x = state(&flight.after);
                let middle = flight.start + 0.5 * flight.span;
                for span in [(flight.start, middle), (middle, flight.end)] {
                    let none = &mut DMatrix::zeros(x.len(), 0);
                    maps.flow(flight.regime(), span, &mut x, none)?;
                }
                Ok(x)
            })
        })
    }

    /// The impacts of a period, instant by instant.
    pub fn impacts(
        &self,
        phase: f64,
        flights: &[OrbitArc],
        impulses: &[f64],
    ) -> Result<Vec<Impact>> {
        let motion = match self {
            Self::Modal { modal, .. } => {
                return Ok(list_impacts(modal, phase, flights, impulses));
            }
            Self::Stepped { motion, .. } => motion,
        };
        let law = |stop: usize, t: f64, before: &ModalState| -> Result<(f64, f64)> {
            let x = unpaired(before);
            let at = motion.gap(stop, t, &x)?;
            let n = at.gradient.len();
            let approach = -at.speed(x.rows(n, n));
            Ok((approach, motion.law(stop).departure(approach)))
        };
        impacts_by(law, (motion.frequency, phase), flights, impulses)
    }

    /// What the rules of contact say.
    pub fn admissibility(
        &self,
        phase: f64,
        flights: &[OrbitArc],
        impacts: &[Impact],
        observer: &mut Observer,
    ) -> Result<Admissibility> {
        let impacts = &struck_free(flights, impacts);
        match self {
            Self::Modal { modal, regimes } if has_lasting_contact(flights) => {
                Judge::new(modal).with_lasting_contact(regimes, phase, flights, impacts, observer)
            }
            Self::Modal { modal, .. } => {
                Judge::new(modal).admissibility(phase, flights, impacts, observer)
            }
            Self::Stepped { motion, pieces } => {
                let period: f64 = flights.iter().map(|f| f.span).sum();
                let judge = IntegratedJudge { maps: motion };
                judge.admissibility(pieces, flights, impacts, TAU / period)
            }
        }
    }

    /// Multipliers and what they decide.
    pub fn stability(
        &self,
        phase: f64,
        flights: &[OrbitArc],
        found: &Admissibility,
        observer: &mut Observer,
    ) -> Result<Stability> {
        match self {
            Self::Modal { modal, regimes } if has_lasting_contact(flights) => {
                let motion = ClosedFormMaps::new(modal, phase, regimes.clone());
                let is_coupled = |a, b| modal.geometry.is_coupled(a, b);
                let states = |pairs: &ModalState| modal.form.state_of(pairs);
                over_flights(&motion, flights, states, found, is_coupled, observer)
            }
            Self::Modal { modal, .. } => stability(modal, phase, flights, found, observer),
            Self::Stepped { motion, .. } => {
                let judge = IntegratedJudge { maps: motion };
                let is_coupled = |a: usize, b: usize| judge.is_coupled(a, b, flights);
                let (watched, watch) = motion.watched();
                let stability =
                    over_flights(&watched, flights, unpaired, found, is_coupled, observer)?;
                Ok(match watch.noted() {
                    None => stability,
                    Some([_, doubt]) => Stability::undefined(doubt.reason()),
                })
            }
        }
    }
}

/// Whether an orbit has lasting contact, or impacts that accumulate.
fn has_lasting_contact(flights: &[OrbitArc]) -> bool {
    !flights.iter().all(OrbitArc::is_flight)
}

/// The impacts but those that a stop in lasting contact receives with another's: it is neither approached nor left.
fn struck_free(flights: &[OrbitArc], impacts: &[Impact]) -> Vec<Impact> {
    let whole = hits(flights).zip(closing(flights));
    let is_new = whole.flat_map(|(all, new)| all.iter().map(move |stop| new.contains(stop)));
    let judged = impacts.iter().zip(is_new).filter(|(_, is_new)| *is_new);
    judged.map(|(impact, _)| *impact).collect()
}

/// Multipliers from arcs as the shooting has them.
fn over_flights<M: HybridMaps>(
    motion: &M,
    flights: &[OrbitArc],
    state: impl Fn(&ModalState) -> DVector<f64>,
    found: &Admissibility,
    is_coupled: impl Fn(usize, usize) -> bool,
    observer: &mut Observer,
) -> Result<Stability> {
    let arcs: Vec<_> = flights.iter().map(|own| own.clone().map(&state)).collect();
    over_orders(&closing(flights), (found, is_coupled), |order| {
        observer.ask()?;
        monodromy(motion, order, &arcs)
    })
}
