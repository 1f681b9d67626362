//! A guess for an orbit of a given signature: from a state on, each event is waited for in its order, in the regime that the events before have
//! led to, and all other guards are passed by.

use crate::error::{Error, Result};
use crate::event::first_root::FirstRoot;
use crate::event::next::ContactSearch;
use crate::flow::{FlowRows, GapRow, LinearFlow, ModalScene, RegimeMotion, with_flow};
use crate::hybrid::{ClosedFormMaps, HybridMaps, halves, regime_motions};
use crate::itinerary::Instant;
use crate::law::{ElementState, Guard, GuardKind, Law, Outcome, Regime, Stage, Transition};
use crate::modal::{ModalState, Pair};
use crate::model::{Moment, Scene};
use crate::observer::Observer;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// The events of a signature that are waited for, as [`PeriodicOrbit::signature`](crate::PeriodicOrbit::signature) names them.
const AWAITED: [&str; 4] = ["strike", "press", "leave", "relax"];

/// The instants of a signature from a state on, each the first of its kind after the one before; none later than a period after the first.
pub(super) fn instants_of_signature(
    scene: &Scene,
    start: &DVector<f64>,
    signature: &[(String, usize)],
    period: f64,
) -> Result<Vec<Instant>> {
    let modal = ModalScene::of(scene, "find_orbit with signature=")?;
    let stages = stages(&modal, signature)?;
    let regimes = stages.iter();
    let regimes = regimes.flat_map(|(before, stage)| [before, &stage.regime]);
    let regimes = regime_motions(&modal, regimes)?;
    let flights = Flights {
        modal: &modal,
        maps: ClosedFormMaps::new(&modal, scene.phase(), regimes.clone()),
        regimes,
        phase: scene.phase(),
    };
    let (mut time, mut state) = (0.0, start.clone());
    let mut found: Vec<Instant> = Vec::new();
    for (k, (before, stage)) in stages.into_iter().enumerate() {
        let last = found.first().map_or(f64::INFINITY, |first| first.time) + period;
        let left = stage.transition.met_again().and_then(|element| {
            let mut earlier = found.iter().rev();
            earlier.find(|own| own.stage.transition.elements() == [element])
        });
        let after = found.last().map(|own| &own.stage.transition);
        let span = (last - time).min(2.0 * period);
        let reached = flights.next(
            (&before, &stage.transition, after),
            (time, &state),
            left,
            span,
        )?;
        let Some(reached) = reached else {
            let (event, element) = &signature[k];
            let rule = "from the guess it does not come within a period: the events of a signature come in its order";
            return Err(Error::bad_value(
                format!("signature[{k}]"),
                format!("({event:?}, {element})"),
                rule,
            ));
        };
        let none = &mut DMatrix::zeros(state.len(), 0);
        flights
            .maps
            .flow(&before, (time, reached), &mut state, none)?;
        time = reached;
        flights
            .maps
            .impact(stage.transition.struck(), time, &mut state, none)?;
        found.push(Instant {
            time,
            start: time,
            stage,
            state: state.clone(),
        });
    }
    Ok(found)
}

/// The events of a signature as stages, each with the regime before it. What an element has come to in the end is its state at the beginning,
/// but that one which relaxes is taken to be back.
fn stages(modal: &ModalScene, signature: &[(String, usize)]) -> Result<Vec<(Regime, Stage)>> {
    let count = modal.n_stops();
    let mut begun = Regime::default();
    for (k, (event, element)) in signature.iter().enumerate() {
        let refused = |rule: String| {
            Err(Error::bad_value(
                format!("signature[{k}]"),
                format!("({event:?}, {element})"),
                rule,
            ))
        };
        if *element >= count {
            return refused(format!("the scene has {count} stops"));
        }
        if !AWAITED.contains(&event.as_str()) {
            return refused(format!(
                "of a signature the events {AWAITED:?} are waited for; give an orbit or a run as guess for others"
            ));
        }
        let is_first = signature[..k].iter().all(|own| own.1 != *element);
        if is_first && matches!(event.as_str(), "leave" | "relax") {
            begun = begun.with(*element, ElementState::Pressed);
        }
    }
    // Once round to see how it ends, and once from there.
    let mut rounds = [Vec::new(), Vec::new()];
    for round in &mut rounds {
        let mut before = begun.clone();
        for (k, (event, element)) in signature.iter().enumerate() {
            let law = &modal.geometry.laws[*element];
            let state = before.state(*element);
            let Some(transition) = transition(law, *element, event, state) else {
                let rule = format!(
                    "stop {element} is \"{}\" then, and its law, {}, has no such change",
                    state.name(law.is_rigid()),
                    law.name()
                );
                return Err(Error::bad_value(
                    format!("signature[{k}]"),
                    format!("({event:?}, {element})"),
                    rule,
                ));
            };
            let regime = match transition {
                Transition::Change(_, to) => before.with(*element, to),
                _ => before.clone(),
            };
            round.push((
                before,
                Stage {
                    transition,
                    regime: regime.clone(),
                },
            ));
            before = regime;
        }
        let back: Vec<usize> = before.in_state(ElementState::Relaxing).collect();
        begun = back
            .iter()
            .fold(before, |regime, element| regime.without(*element));
    }
    let [_, whole] = rounds;
    Ok(whole)
}

/// The transition that an event is for an element of a law in a state, if it has such a one.
fn transition(law: &Law, element: usize, event: &str, from: ElementState) -> Option<Transition> {
    if event == "strike" {
        return law.is_rigid().then(|| Transition::Strike(vec![element]));
    }
    if law.is_rigid() {
        return None;
    }
    let own = law.by_state();
    let to = match event {
        "press" => ElementState::Pressed,
        "leave" => ElementState::Free,
        _ => match own.outcome(ElementState::Pressed, GuardKind::Push) {
            Outcome::Enters(to) if own.guards(ElementState::Pressed).contains(&GuardKind::Push) => {
                to
            }
            _ => return None,
        },
    };
    if from == to || event == "relax" && from != ElementState::Pressed {
        return None;
    }
    Transition::change(own, element, [from, to])
}

/// The flights of a scene in some regimes.
struct Flights<'a> {
    modal: &'a ModalScene,
    maps: ClosedFormMaps<'a>,
    regimes: Vec<Arc<RegimeMotion>>,
    phase: f64,
}

impl Flights<'_> {
    /// When the guard of a transition falls through zero, from a state behind another transition.
    fn next(
        &self,
        (before, transition, after): (&Regime, &Transition, Option<&Transition>),
        (time, state): (f64, &DVector<f64>),
        left: Option<&Instant>,
        span: f64,
    ) -> Result<Option<f64>> {
        let guard = match *transition {
            Transition::Change(guard, _) => guard,
            _ => Guard::gap(transition.struck()[0]),
        };
        let order = match after {
            Some(Transition::Change(own, to)) if own.element == guard.element => {
                let zero = own.kind.leaves_at_zero(*to, true);
                zero.filter(|zero| zero.0 == guard.kind)
                    .map_or(0, |zero| zero.1)
            }
            Some(Transition::Strike(stops)) => usize::from(stops.contains(&guard.element)),
            _ => 0,
        };
        let at = Moment::of_angle(self.modal.frequency * time + self.phase);
        if before.is_free() {
            let own = self.modal.form.pairs_of(state);
            let gap = self.modal.gap(guard.element);
            let found = with_flow!(&*self.modal.flow(), f => first_root(f, f.gap_row(&gap), (&own, at), order, span));
            return Ok(found?.map(|after| time + after));
        }
        let motion = self.regimes.iter().find(|own| own.regime == *before);
        let motion = motion.expect("it was made of all regimes");
        let (q, v) = halves(state);
        let place = |element: usize| {
            let known = left.filter(|_| element == guard.element);
            known.map_or(0.0, |left| self.place(element, left, time))
        };
        let own = motion.with_places(motion.reduce(&q, &v, at), place);
        let quantity = motion.guards().find(|(known, _)| *known == guard);
        let Some((_, quantity)) = quantity else {
            return Ok(None);
        };
        let found = with_flow!(&motion.flow, f => first_root(f, f.gap_row(quantity), (&own, at), order, span));
        Ok(found?.map(|after| time + after))
    }

    /// The place of an element that relaxes since an instant.
    fn place(&self, element: usize, left: &Instant, time: f64) -> f64 {
        let law = self.modal.geometry.laws[element].by_state();
        let gap = self.maps.gap(element, left.time, &left.state);
        let relaxation = law.relaxation(ElementState::Relaxing);
        let known = gap.ok().zip(relaxation);
        known.map_or(0.0, |(at, own)| own.after(-at.gap, time - left.time))
    }
}

/// The first root of a quantity along a flow from a state.
fn first_root<F: LinearFlow>(
    flow: &F,
    row: GapRow,
    (state, at): (&ModalState, Moment),
    order: usize,
    span: f64,
) -> Result<Option<f64>> {
    let mut entered: Vec<Pair> = Vec::new();
    flow.state_from_modal(state, at, &mut entered);
    let mut search = ContactSearch::new(flow, vec![row]);
    search.evaluate(&entered);
    let observer = &mut Observer::default();
    let event = search.next(&entered, &[order], span, &mut Vec::new(), observer)?;
    Ok(match event.root {
        FirstRoot::Crossing { at, .. } => {
            Some(search.arrive(0, at, &entered, &mut Vec::new()).1).filter(|time| *time <= span)
        }
        FirstRoot::None | FirstRoot::Undecided { .. } => None,
    })
}
