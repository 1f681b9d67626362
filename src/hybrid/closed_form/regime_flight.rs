//! Exact flights in regimes that are not free: the motion has modes of its own there, and all guards are searched as gaps are (theory 9).

use super::arcs::{RegimeArc, reported};
use super::kept_regimes::KeptLevels;
use super::system::{ClosedForm, is_before, is_within};
use crate::error::Result;
use crate::event::certified::SearchFailure;
use crate::event::first_root::{FirstEvent, FirstRoot};
use crate::event::levels::PropagatorLevels;
use crate::event::next::{ContactSearch, Grazed, LATE, SearchSummary};
use crate::flow::gap_model::GapModel;
use crate::flow::{GapRow, LinearFlow, Quantity, RegimeMotion, with_flow};
use crate::hybrid::flow::Arrival;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::root_orders::RootOrders;
use crate::hybrid::segment::SegmentKind;
use crate::hybrid::system::{Gaps, Present};
use crate::impact::{StopsAt, project};
use crate::law::{Guard, GuardKind, Regime};
use crate::modal::{ModalState, Pair};
use crate::model::{Moment, PhysicalState};
use crate::observer::Observer;
use crate::tolerance::{CANCELLED, FLAT_FORCE};
use nalgebra::DVector;
use std::ops::Range;
use std::sync::Arc;

impl<F: LinearFlow> ClosedForm<'_, F> {
    /// The present position and velocity, moved to where a regime keeps them.
    pub(super) fn settled(&self, regime: &Regime) -> Result<PhysicalState> {
        let (mut q, mut v) = self.physical();
        let stops = regime.constrained();
        if stops.is_empty() {
            return Ok((q, v));
        }
        project(&mut q, &mut v, |q| Ok(self.stops_at(stops, q)))?;
        Ok((q, v))
    }

    /// The motion while some stops are held, and where it begins: the present position and velocity, moved onto them. What impacts that
    /// accumulate give in all is what the forces of lasting contact give meanwhile.
    pub(super) fn held_on(
        &mut self,
        stops: &[usize],
    ) -> Result<(Arc<RegimeMotion>, PhysicalState)> {
        let regime = self.regime_holding(stops);
        Ok((self.motion_in(&regime)?, self.settled(&regime)?))
    }

    /// The present regime with other stops held.
    fn regime_holding(&self, stops: &[usize]) -> Regime {
        let beside = self.compliant.motion.as_ref();
        let beside = beside.map_or(Regime::free(), |motion| &motion.regime);
        beside.holding_instead(stops)
    }

    /// Some stops at a position.
    pub(super) fn stops_at(&self, stops: &[usize], q: &DVector<f64>) -> StopsAt {
        let g = &self.scene.geometry;
        let (normals, reactions) = g.directions(stops);
        let motion = |i: usize| self.scene.stop_motion(stops[i], self.moment());
        let gap = |i: usize| g.clearances[stops[i]] + motion(i)[0] - normals[i].dot(q);
        StopsAt {
            gaps: DVector::from_fn(stops.len(), |i, _| gap(i)),
            speeds: DVector::from_fn(stops.len(), |i, _| motion(i)[1]),
            normals,
            reactions,
        }
    }

    /// The motion in a regime that is not free.
    pub(super) fn motion_in(&mut self, regime: &Regime) -> Result<Arc<RegimeMotion>> {
        self.regimes.motion(regime, || self.timed.in_regime(regime))
    }

    /// Time derivatives of some orders of the gaps of some stops in a regime, and what rounding leaves unknown of each.
    pub(super) fn derivatives_beside(
        &mut self,
        stops: &[usize],
        regime: &Regime,
        orders: Range<usize>,
    ) -> Result<Vec<Vec<[f64; 2]>>> {
        let at = self.moment();
        let lost = self.scene.form.lost(&self.modal_state(&self.state));
        let derivatives = if regime.is_free() {
            let state = self.physical();
            let equations = self.timed.equations();
            equations.derivatives(self.scene, at, state, lost, (orders.clone(), &|_| None))
        } else {
            let motion = self.motion_in(regime)?;
            let state = self.settled(regime)?;
            let equations = motion.equations(self.scene);
            let carried = |order: usize| motion.carried_derivative(self.scene, at, order);
            equations.derivatives(self.scene, at, state, lost, (orders.clone(), &carried))
        };
        let own = |stop: usize, order: usize| {
            let motion = self.scene.excitation.motion_of(stop);
            motion.map_or((0.0, 0.0), |motion| motion.derivative(at, order))
        };
        let normal = |stop: usize| self.scene.geometry.normals.column(stop);
        let unknown = |stop: usize, of: &DVector<f64>| {
            let terms = normal(stop).into_iter().zip(of.iter());
            terms.map(|(n, unknown)| n.abs() * unknown).sum()
        };
        let gap = |stop: usize, order: usize, (value, of): &PhysicalState| {
            let (own, size) = own(stop, order);
            let lost: f64 = unknown(stop, of);
            let lost = lost + CANCELLED * size;
            [own - normal(stop).dot(value), lost]
        };
        let of_order = |(order, of)| stops.iter().map(|&stop| gap(stop, order, of)).collect();
        Ok(orders.zip(&derivatives).map(of_order).collect())
    }

    /// A flight in a regime that is not free: to the next event, or over the whole span.
    #[cold]
    pub(super) fn advance_in_regime(
        &mut self,
        motion: &RegimeMotion,
        orders: &RootOrders,
        (span, last): (f64, f64),
        recorder: &mut dyn Recorder,
        observer: &mut Observer,
    ) -> Result<Arrival> {
        self.depart_in_regime();
        let (q, v) = self.physical();
        let at = self.moment();
        let flight = RegimeFlight {
            motion,
            at,
            modal_state: motion.with_places(motion.reduce(&q, &v, at), |element| {
                self.compliant.places.place(element)
            }),
            orders,
        };
        let back = self
            .compliant
            .places
            .first_back()
            .filter(|own| own.1 <= span);
        let back = back.map(|(element, time)| (FlightEnd::Event(Guard::place(element)), time));
        let searched = back.map_or(span, |own| own.1);
        let kept = self.regimes.levels(motion);
        let (next, seen, touches) =
            with_flow!(&motion.flow, flow => flight.next(flow, searched, kept, observer))?;
        // A search may look beyond its span.
        let is_late = |own: &(FlightEnd, f64)| back.is_some_and(|back| back.1 < own.1);
        let next = next.filter(|own| !is_late(own)).or(back);
        self.search.saw(&seen);
        let next = next.filter(|(_, time)| is_within(self.clock.after(*time), last));
        let time = next.map_or(span, |(_, time)| time);
        self.grazed.clear();
        if recorder.wanted().events {
            let reached = next.and_then(|(end, _)| end.reached());
            let (from, is_end) = (self.clock, next.is_none());
            let is_kept = |graze: &Grazed| {
                is_before(graze, from, (reached, time)) || (is_end && graze.time <= time)
            };
            for graze in touches.into_iter().filter(is_kept) {
                recorder.graze(reported(graze, from));
            }
        }
        if recorder.wanted().motion_in(&motion.regime) {
            let mut arc = RegimeArc {
                motion,
                scene: self.scene,
                at,
                start: (&q, &v),
                modal_state: self.modal_state(&self.state),
            };
            let ends = (time, next.is_none().then_some(last));
            let kind = SegmentKind::of(&motion.regime);
            self.record_along(kind, ends, &mut arc, recorder);
        }
        let (q, v) = motion.propagate(at, time, &q, &v);
        self.put((&q, &v), time);
        // The sums that gave the position were those of this flight.
        for (stop, rounding) in seen.roundings {
            self.placed[stop] = self.placed[stop].max(rounding);
        }
        self.evaluate_gaps()?;
        Ok(match next {
            None => Arrival::End,
            Some((FlightEnd::Event(guard), _)) => Arrival::Event { guard },
            Some((FlightEnd::Doubt(stop), _)) => Arrival::Uncertain {
                stop,
                doubt: SearchFailure::Shallow,
            },
        })
    }
}

/// What ends a flight in a regime.
#[derive(Debug, Clone, Copy)]
enum FlightEnd {
    /// A guard falls through zero.
    Event(Guard),
    /// Whether one of this element does cannot be told.
    Doubt(usize),
}

impl FlightEnd {
    /// The element that the body reaches.
    fn reached(self) -> Option<usize> {
        match self {
            Self::Event(guard) if guard.is_gap() => Some(guard.element),
            _ => None,
        }
    }
}

/// A motion in a regime, from where it begins.
struct RegimeFlight<'a> {
    motion: &'a RegimeMotion,
    at: Moment,
    /// The motion left over, in its modal pairs.
    modal_state: ModalState,
    /// The orders of the roots of the gaps, and of the contact forces, as far as known.
    orders: &'a RootOrders,
}

impl RegimeFlight<'_> {
    /// What ends it within a span, and when; what was seen of the gaps, and the touches.
    fn next<H: LinearFlow + 'static>(
        &self,
        flow: &H,
        span: f64,
        kept: &mut KeptLevels,
        observer: &mut Observer,
    ) -> Result<(Option<(FlightEnd, f64)>, SearchSummary, Vec<Grazed>)> {
        let mut state = Vec::new();
        flow.state_from_modal(&self.modal_state, self.at, &mut state);
        let (guards, rows) = watched(flow, self.motion, (&self.modal_state, &state));
        let levels = kept.take().and_then(|kept| kept.downcast().ok());
        let levels = levels.map_or_else(|| PropagatorLevels::new(flow), |kept| *kept);
        let mut search = ContactSearch::with(flow, rows, levels);
        search.evaluate(&state);
        let order = |(place, guard): (usize, &Guard)| {
            let known = self.orders.of(*guard);
            if guard.is_gap() {
                return known;
            }
            known.max(order_of_zero(search.model(place), flow.fastest_rate()))
        };
        let orders: Vec<usize> = guards.iter().enumerate().map(order).collect();
        let mut grazed = Vec::new();
        let FirstEvent { stop: place, root } =
            search.next(&state, &orders, span, &mut grazed, observer)?;
        let found = match root {
            FirstRoot::None => None,
            FirstRoot::Undecided { at } => Some((FlightEnd::Doubt(guards[place].element), at)),
            FirstRoot::Crossing { at, .. } => {
                let (place, time) = search.arrive(place, at, &state, &mut Vec::new());
                Some((FlightEnd::Event(guards[place]), time))
            }
        };
        // Forces that touch zero hold their stops.
        let touches = grazed.into_iter().filter_map(|graze| {
            let guard = guards[graze.stop];
            let sharpened = || graze.sharpened(flow, search.gap(graze.stop), &state, span);
            let stop = guard.element;
            guard.is_clearance().then(|| Grazed {
                stop,
                ..sharpened()
            })
        });
        let touches = touches.collect();
        let gaps = guards.iter().enumerate().filter(|(_, own)| own.is_gap());
        let gaps = gaps.map(|(place, own)| (own.element, place));
        let extent = |(stop, place)| (stop, search.extent(place));
        let rounding = |(stop, place)| (stop, search.rounding(place));
        let seen = SearchSummary {
            extents: gaps.clone().map(extent).collect(),
            roundings: gaps.map(rounding).collect(),
            n_gap_evaluations: search.n_gap_evaluations,
        };
        *kept = Some(Box::new(search.into_levels()));
        Ok((found, seen, touches))
    }
}

/// The guards of a regime, as rows: the contact forces and the gaps that can change, but for forces that are zero for good.
fn watched<H: LinearFlow>(
    flow: &H,
    motion: &RegimeMotion,
    (modal_state, state): (&ModalState, &[Pair]),
) -> (Vec<Guard>, Vec<GapRow>) {
    let (mut derivatives, mut norms) = (Vec::new(), Vec::new());
    flow.derivatives(state, &mut derivatives);
    flow.norms(state, &mut norms);
    let row = |((guard, quantity), row): ((Guard, &Quantity), &GapRow)| {
        let row = row.clone();
        if guard.kind == GuardKind::Approach {
            return Some((guard, row.that_may_settle()));
        }
        if guard.is_gap() {
            return Some((guard, row));
        }
        let row = row.known_to(CANCELLED).with_whole_turning();
        let lost = motion.lost(quantity, modal_state);
        let size = row.model(&derivatives).size;
        let is_flat = row.most(&norms) <= (FLAT_FORCE * size).max(lost);
        (!is_flat).then_some((guard, row))
    };
    motion.guards().zip(motion.rows()).filter_map(row).unzip()
}

/// The number of leading derivatives of a contact force that are zero, as far as a cubic tells: beside its terms, or beside what it
/// will be soon.
fn order_of_zero(model: &GapModel, rate: f64) -> usize {
    let natural: [f64; 4] = std::array::from_fn(|k| {
        let unit: f64 = (0..k).fold(1.0, |unit, _| unit * rate);
        model.c[k].abs() / unit
    });
    let scale = FLAT_FORCE * natural.iter().fold(model.size, |size, c| size.max(*c));
    natural.iter().position(|c| *c > scale).unwrap_or(LATE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::TimedScene;
    use crate::flow::characteristic_length::Tolerances;
    use crate::hybrid::flow::HybridFlow;
    use crate::hybrid::recorder::{ArcMotion, ArcSpan, Wanted};
    use crate::hybrid::segment::Graze;
    use crate::hybrid::system::Holding;
    use crate::law::{Cushion, ElementState};
    use crate::model::{Forcing, LinearSystem, Scene, Stop};
    use nalgebra::{dmatrix, dvector};

    /// What keeps nothing.
    struct Nothing;

    impl Recorder for Nothing {
        fn wanted(&self) -> Wanted {
            Wanted {
                events: false,
                arcs: false,
                contacts: false,
            }
        }
        fn begin_segment(&mut self, _kind: SegmentKind, _regime: &Regime) {}
        fn wants_arc(&self, _span: &ArcSpan) -> bool {
            false
        }
        fn arc(&mut self, _span: &ArcSpan, _motion: &mut dyn ArcMotion) {}
        fn graze(&mut self, _graze: Graze) {}
    }

    #[test]
    fn a_search_that_proves_nothing_is_no_event() {
        let body = LinearSystem::new(dmatrix![1.0], dmatrix![0.1], dmatrix![1.0]);
        let stop = Stop::new(0, 0.5, Cushion::law(40.0, 1.5)).expect("valid");
        let scene = Scene::new(body.expect("valid"), Forcing::Unforced, [stop]).expect("valid");
        let timed = TimedScene::of(&scene, "the test").expect("linear");
        let tolerances = Tolerances {
            relative: 1e-9,
            absolute: None,
        };
        with_flow!(&*timed.flow, f => {
            let mut flow = ClosedForm::new(f, &timed, 0.0, tolerances);
            flow.start(&dvector![0.5], &dvector![1.0], 0.0);
            flow.evaluate_gaps().expect("regular");
            let pressed = Regime::default().with(0, ElementState::Pressed);
            flow.enter(&pressed).expect("regular");
            let advance = |flow: &mut ClosedForm<'_, _>| {
                let (mut orders, mut observer) = (RootOrders::none(1), Observer::default());
                orders[0] = 1;
                flow.advance_to_event(&orders, 9.0, 9.0, &mut Nothing, &mut observer)
            };
            flow.state[0][0] = f64::NAN;
            let doubt = SearchFailure::Shallow;
            assert_eq!(advance(&mut flow).expect("regular"), Arrival::Uncertain { stop: 0, doubt });
        });
    }
}
