#![cfg(test)]
//! What every [`HybridSystem`] must keep: one linear scene in closed form and integrated says the same of its gaps, contacts, forces and
//! impacts, and comes to the same events.

use crate::flow::characteristic_length::Tolerances;
use crate::flow::steps::example::BogackiShampine;
use crate::flow::steps::{Dop853, DormandPrince, Radau, Stepper};
use crate::flow::{TimedScene, with_flow};
use crate::hybrid::clock::Clock;
use crate::hybrid::recorder::{ArcMotion, ArcSpan, Recorder, Wanted};
use crate::hybrid::system::{Contacts, Gaps, Holding, NormalImpacts, Present};
use crate::hybrid::{
    Arrival, ClosedForm, ClosedFormMaps, GapAt, Graze, HybridFlow, HybridMaps, HybridSystem,
    InSteps, IntegratedFlow, IntegratedMaps, RootOrders, SegmentKind, project_onto,
};
use crate::law::{Cushion, ElementState, Guard, GuardKind, Regime};
use crate::model::{
    Change, Forcing, Harmonic, LinearSystem, Load, Scene, SceneMotion, Side, Signal, Stop,
};
use crate::observer::Observer;
use nalgebra::{DMatrix, DVector, dmatrix, dvector};

/// The forcing phase of the test [rad]. [exact]
const PHASE: f64 = 0.4;
const CONTRACT_TOLERANCES: Tolerances = Tolerances {
    relative: 1e-9,
    absolute: None,
};
const TIGHT_CONTRACT_TOLERANCES: Tolerances = Tolerances {
    relative: 1e-12,
    absolute: Some(1e-14),
};

/// Two coupled masses under a force, a stop on either side of the first and one across both.
fn scene() -> Scene {
    let system = LinearSystem::new(
        dmatrix![1.0, 0.3; 0.3, 0.8],
        dmatrix![0.2, -0.1; -0.1, 0.3],
        dmatrix![2.0, -1.0; -1.0, 1.5],
    );
    let force = dvector![1.5.into(), 0.5.into()];
    let forcing = Harmonic::new(force, 1.3, PHASE).expect("valid");
    let stops = vec![
        Stop::new(0, 0.5, 0.6).expect("valid"),
        Stop::new(0, 0.4, 0.8).expect("valid").on_side(Side::Lower),
        Stop::new(dvector![0.6, -0.8], 0.7, 0.7).expect("valid"),
    ];
    Scene::new(system.expect("valid"), forcing, stops).expect("valid")
}

/// What was recorded: the kinds of segments, the ends of arcs and the state in their middle.
#[derive(Default)]
struct Notes {
    kinds: Vec<(SegmentKind, Regime)>,
    ends: Vec<f64>,
    middles: Vec<f64>,
}

impl Recorder for Notes {
    fn wanted(&self) -> Wanted {
        Wanted {
            events: true,
            arcs: true,
            contacts: false,
        }
    }

    fn begin_segment(&mut self, kind: SegmentKind, regime: &Regime) {
        self.kinds.push((kind, regime.clone()));
    }

    fn wants_arc(&self, _span: &ArcSpan) -> bool {
        true
    }

    fn arc(&mut self, span: &ArcSpan, motion: &mut dyn ArcMotion) {
        let mut numbers = Vec::new();
        motion.write(&mut numbers);
        assert!(!numbers.is_empty());
        self.ends.push(span.start.after(span.span).time());
        let (q, v) = motion.state(0.5 * span.span);
        self.middles = q.iter().chain(v.iter()).copied().collect();
    }

    fn graze(&mut self, _graze: Graze) {}
}

/// A number, and how much less well it may be known than others: third derivatives are differences where steps are taken.
type Fact = (f64, f64);

/// How much less well third derivatives are known in the test. [exact]
const JERK_ROUGHNESS: f64 = 1e3;

/// The numbers of a system where it is.
fn facts<Y: HybridSystem + ?Sized>(system: &mut Y) -> Vec<Fact> {
    system.evaluate_gaps().expect("regular");
    let (q, v) = system.physical();
    let stops: Vec<usize> = (0..system.n_stops()).collect();
    let mut facts: Vec<f64> = q.iter().chain(v.iter()).copied().collect();
    let mut rough = Vec::new();
    for &stop in &stops {
        let gap = system.gap(stop);
        let given = system.given_gap(stop, &q, &v).expect("regular");
        assert!((given.gap.0 - gap.gap).abs() < 1e-13 && (given.speed.0 - gap.speed).abs() < 1e-13);
        assert!(system.rounding(stop) < 1e-13 && system.tolerance(stop, 1.0) > 0.0);
        assert!(system.margin(stop, 1.0) >= system.tolerance(stop, 1.0));
        facts.extend([gap.gap, gap.speed, gap.acceleration]);
        facts.extend([
            system.law(stop).restitution,
            f64::from(u8::from(system.is_bound(stop))),
        ]);
        rough.push(system.free_jerk(stop).expect("regular"));
        for &other in &stops {
            facts.push(f64::from(u8::from(system.is_coupled(stop, other))));
            facts.push(f64::from(u8::from(system.is_at_place_of(stop, other))));
        }
    }
    facts.extend(system.normals(&stops).expect("regular").iter());
    facts.extend(system.delassus(&stops).expect("regular").iter());
    facts.extend(system.free_accelerations(&stops).iter());
    // Those that are in contact at rest can be held.
    let rests = |stop: &usize| {
        let gap = system.gap(*stop);
        gap.gap.abs() < 1e-12 && gap.speed.abs() < 1e-12
    };
    let resting: Vec<usize> = stops.iter().copied().filter(rests).collect();
    for regime in [Regime::default(), Regime::holding(resting)] {
        let derivatives = system.gap_derivatives(&stops, &regime, 2..4);
        let derivatives = derivatives.expect("regular");
        facts.extend(derivatives[0].iter().map(|[value, _]| *value));
        rough.extend(derivatives[1].iter().map(|[value, _]| *value));
    }
    facts.extend([system.clock().time(), system.phase()]);
    let facts = facts.into_iter().map(|x| (x, 1.0));
    facts
        .chain(rough.into_iter().map(|x| (x, JERK_ROUGHNESS)))
        .collect()
}

/// What happens to a scene that is struck, held, and let go again: the numbers all along.
fn facts_of_a_run<M: HybridFlow + ?Sized>(flow: &mut M) -> Vec<Fact> {
    let mut notes = Notes::default();
    let (q, v) = (dvector![0.1, -0.3], dvector![0.7, 0.4]);
    flow.start(&q, &v, 0.3);
    let mut all = facts(flow.system());
    // To the first contact.
    let mut observer = Observer::default();
    let arrival = flow.advance_to_event(&RootOrders::none(3), 5.0, 5.3, &mut notes, &mut observer);
    let Arrival::Event { guard } = arrival.expect("regular") else {
        panic!("no contact")
    };
    assert!(guard.is_gap());
    let stop = guard.element;
    all.push((stop as f64, 1.0));
    let system = flow.system();
    assert!(system.gap(stop).gap.abs() < 1e-10 && system.gap(stop).speed < 0.0);
    let impact = system.strike(stop).expect("regular");
    let departure = system.law(stop).departure(impact.approach);
    assert!((impact.departure - departure).abs() < 1e-15);
    all.extend([(impact.approach, 1.0), (impact.impulse, 1.0)]);
    all.extend(facts(system));
    assert!((system.gap(stop).speed - impact.departure).abs() < 1e-12);
    // A push is the law of one impulse.
    let before = system.physical().1;
    system.push(stop, 0.25).expect("regular");
    let pushed = (before - system.physical().1).norm();
    system.push(stop, -0.25).expect("regular");
    all.push((pushed, 1.0));
    // Held, it is on the stop at rest, and stays.
    let held = Regime::holding([stop]);
    system.enter(&held).expect("regular");
    all.extend(facts(system));
    let gap = system.gap(stop);
    assert!(gap.gap.abs() < 1e-14 && gap.speed.abs() < 1e-14);
    let mut observer = Observer::default();
    let orders = RootOrders::none(3);
    let arrival = flow.advance_to_event(&orders, 5.0, 9.0, &mut notes, &mut observer);
    match arrival.expect("regular") {
        Arrival::Event { guard } => {
            let kind = if guard.is_gap() { 20.0 } else { 10.0 };
            all.push((kind + guard.element as f64, 1.0));
        }
        other => panic!("{other:?}"),
    }
    let system = flow.system();
    all.push((system.clock().time(), 1.0));
    system.enter(Regime::free()).expect("regular");
    all.extend(facts(system));
    let kinds: Vec<_> = notes.kinds.iter().map(|(kind, _)| *kind).collect();
    assert_eq!(kinds, [SegmentKind::Flight, SegmentKind::Stick]);
    assert_eq!(notes.kinds[1].1, held);
    assert!((notes.ends[notes.ends.len() - 1] - system.clock().time()).abs() < 1e-12);
    all
}

fn integrated<P: Stepper<[f64; 4], Choice = ()>>(scene: &Scene) -> Vec<Fact> {
    let motion = SceneMotion::new(scene);
    let mut flow = IntegratedFlow::new(
        &motion,
        scene,
        TIGHT_CONTRACT_TOLERANCES,
        InSteps::<(), P>::new(()),
    );
    facts_of_a_run(&mut flow)
}

#[test]
fn both_systems_keep_the_contract() {
    let scene = scene();
    let timed = TimedScene::of(&scene, "the test").expect("linear");
    let exact = with_flow!(&*timed.flow, f => {
        facts_of_a_run(&mut ClosedForm::new(f, &timed, PHASE, CONTRACT_TOLERANCES))
    });
    for (name, found, allowed) in [
        ("rk45", integrated::<DormandPrince<[f64; 4]>>(&scene), 1e-7),
        ("dop853", integrated::<Dop853<[f64; 4]>>(&scene), 1e-7),
        (
            "example",
            integrated::<BogackiShampine<[f64; 4]>>(&scene),
            1e-6,
        ),
        ("radau", integrated::<Radau<[f64; 4]>>(&scene), 1e-6),
    ] {
        assert_eq!(found.len(), exact.len(), "{name}");
        for (k, ((a, rough), (b, _))) in found.iter().zip(&exact).enumerate() {
            let allowed = allowed * rough * (1.0 + b.abs());
            assert!((a - b).abs() < allowed, "{name} {k}: {a} {b}");
        }
    }
}

/// The numbers of the maps of a state, and of deviations from it.
fn maps_of<M: HybridMaps>(maps: &M) -> Vec<f64> {
    let state = dvector![0.1, -0.3, 0.7, 0.4];
    let mut all = Vec::new();
    for held in [&[][..], &[0], &[2]].map(Regime::holding) {
        let mut x = state.clone();
        project_onto(maps, &held, 0.7, &mut x).expect("regular");
        all.extend(x.iter());
        all.extend(maps.rate(&held, 0.7, &x).expect("regular").iter());
        let mut deviations = DMatrix::identity(4, 4);
        maps.flow(&held, (0.7, 1.9), &mut x, &mut deviations)
            .expect("regular");
        all.extend(x.iter());
        // Deviations are those of motions that keep their contacts.
        if held.is_free() {
            all.extend(deviations.iter());
        }
    }
    for stops in [&[0][..], &[2], &[0, 2]] {
        let (mut x, mut deviations) = (state.clone(), DMatrix::identity(4, 4));
        all.extend(
            maps.impact(stops, 0.7, &mut x, &mut deviations)
                .expect("regular"),
        );
        all.extend(x.iter().chain(deviations.iter()));
    }
    for stop in 0..3 {
        let GapAt { gap, gradient, .. } = maps.gap(stop, 0.7, &state).expect("regular");
        let rate: DVector<f64> = maps.rate(Regime::free(), 0.7, &state).expect("regular");
        let acceleration = maps.gap_acceleration(stop, 0.7, &state, &rate);
        all.extend([
            gap,
            maps.law(stop).restitution,
            acceleration.expect("regular"),
        ]);
        all.extend(gradient.iter());
        all.extend(maps.reaction(stop, &state).expect("regular").iter());
    }
    all
}

/// The same scene under a load that follows samples too, with corners on every flight of the maps.
fn with_sampled_load() -> Scene {
    let t: Vec<f64> = (0..20).map(|k| 0.17 * f64::from(k)).collect();
    let values: Vec<f64> = t.iter().map(|t| 3.0 * (7.0 * t).sin()).collect();
    let load = Load::new(1, Signal::samples(&t, &values).expect("valid")).expect("valid");
    let calm = scene();
    let both = Forcing::Several(vec![calm.forcing().clone(), load.into()]);
    calm.replace(Change::Forcing(both)).expect("valid")
}

#[test]
fn both_systems_have_the_same_maps() {
    for scene in [scene(), with_sampled_load()] {
        let modal = crate::flow::ModalScene::new(&scene, "the test").expect("linear");
        let regimes = [0, 2].map(|stop| Regime::holding([stop]));
        let held = crate::hybrid::regime_motions(&modal, regimes.iter());
        // Of a forcing without a period all phases are in its tones.
        let phase = scene.frequency().map_or(0.0, |_| PHASE);
        let closed = maps_of(&ClosedFormMaps::new(&modal, phase, held.expect("regular")));
        let stepped = maps_of(&IntegratedMaps::new(&scene, phase));
        assert_eq!(closed.len(), stepped.len());
        for (k, (a, b)) in closed.iter().zip(&stepped).enumerate() {
            assert!((a - b).abs() < 1e-9 * (1.0 + b.abs()), "{k}: {a} {b}");
        }
    }
    assert!(Clock::new(0.0, 1.3).angle() == 0.0);
}

/// The scene of the contract with a first stop that gives way.
fn soft_scene() -> Scene {
    let hard = scene();
    let soft = Stop::new(0, 0.5, Cushion::law(40.0, 1.5)).expect("valid");
    let stops = hard.stops().iter().skip(1).cloned();
    let all = std::iter::once(soft.into()).chain(stops);
    hard.replace(Change::Stops(all.collect())).expect("valid")
}

/// A contact with a stop that gives way, from free motion to free motion: the numbers all along.
fn facts_of_a_contact<M: HybridFlow + ?Sized>(flow: &mut M) -> Vec<Fact> {
    let mut notes = Notes::default();
    flow.start(&dvector![0.1, -0.3], &dvector![0.9, 0.4], 0.3);
    let mut all = facts(flow.system());
    let pressed = Regime::default().with(0, ElementState::Pressed);
    let changes = [
        (GuardKind::Gap, &pressed),
        (GuardKind::Approach, Regime::free()),
    ];
    let mut orders = RootOrders::none(3);
    for (kind, regime) in changes {
        let mut observer = Observer::default();
        let arrival = flow.advance_to_event(&orders, 5.0, 9.0, &mut notes, &mut observer);
        let guard = Guard { element: 0, kind };
        assert_eq!(arrival.expect("regular"), Arrival::Event { guard });
        let system = flow.system();
        all.push((system.clock().time(), 1.0));
        system.enter(regime).expect("regular");
        all.extend(facts(system));
        orders[0] = 1;
    }
    let kinds: Vec<_> = notes
        .kinds
        .iter()
        .map(|(_, regime)| regime.clone())
        .collect();
    assert_eq!(kinds, [Regime::default(), pressed]);
    all
}

#[test]
fn another_law_keeps_the_contract() {
    let scene = soft_scene();
    let timed = TimedScene::of(&scene, "the test").expect("linear");
    let exact = with_flow!(&*timed.flow, f => {
        facts_of_a_contact(&mut ClosedForm::new(f, &timed, PHASE, CONTRACT_TOLERANCES))
    });
    let motion = SceneMotion::new(&scene);
    let mut stepped = IntegratedFlow::new(
        &motion,
        &scene,
        TIGHT_CONTRACT_TOLERANCES,
        InSteps::<(), Dop853<[f64; 4]>>::new(()),
    );
    let found = facts_of_a_contact(&mut stepped);
    assert_eq!(found.len(), exact.len());
    for (k, ((a, rough), (b, _))) in found.iter().zip(&exact).enumerate() {
        assert!(
            (a - b).abs() < 1e-7 * rough * (1.0 + b.abs()),
            "{k}: {a} {b}"
        );
    }
}

#[test]
fn another_law_has_the_same_maps() {
    let scene = soft_scene();
    let modal = crate::flow::ModalScene::new(&scene, "the test").expect("linear");
    let pressed = Regime::default().with(0, ElementState::Pressed);
    let beside = pressed.with(2, ElementState::Held);
    let regimes = [pressed, beside];
    let motions = crate::hybrid::regime_motions(&modal, regimes.iter()).expect("regular");
    let closed = ClosedFormMaps::new(&modal, PHASE, motions);
    let stepped = IntegratedMaps::new(&scene, PHASE);
    for regime in &regimes {
        let mut start = dvector![0.6, -0.3, 0.7, 0.4];
        project_onto(&closed, regime, 0.7, &mut start).expect("regular");
        let rates = [
            closed.rate(regime, 0.7, &start).expect("regular"),
            stepped.rate(regime, 0.7, &start).expect("regular"),
        ];
        assert!((&rates[0] - &rates[1]).amax() < 1e-12, "{rates:?}");
        let along = |maps: &dyn HybridMaps| {
            let (mut x, mut deviations) = (start.clone(), DMatrix::identity(4, 4));
            let span = (0.7, 1.9);
            maps.flow(regime, span, &mut x, &mut deviations)
                .expect("regular");
            (x, deviations)
        };
        let ((x, a), (y, b)) = (along(&closed), along(&stepped));
        assert!((x - y).amax() < 1e-9);
        // Deviations are those of motions that keep their contacts.
        assert!(!regime.constrained().is_empty() || (a - b).amax() < 1e-8);
    }
}
