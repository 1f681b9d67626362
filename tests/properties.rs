//! Laws that hold whatever is put in: no panic, no endless run, and every `Ok` keeps its promise. Numbers are drawn from
//! ordinary ones and from the ends of the doubles: NaN, infinities, subnormal and huge ones, zeros.
//!
//! 64 cases of each law, always the same ones; a soak run with others each time:
//! `PROPTEST_CASES=20000 cargo test --release --test properties`.

use nalgebra::{Complex, DMatrix, DVector};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::cell::Cell;
use std::ops::ControlFlow;
use vibroimpact::{
    Axis, BaseMotion, Change, Coefficient, DoublePendulum, Error, Forcing, FreeParameter, Harmonic,
    ImpactSide, Keep, LinearSystem, Motion, OrbitOptions, Parameter, Pattern, PendulumChain,
    PeriodicOrbit, Reaction, Scene, Side, SimulateOptions, Solver, Stop, StopNumber, SweepOptions,
    Trajectory, Wall, WallSide, audit_recovery, existence_map, modes, periodic_orbits,
    recovery_matrix, simulate, with_observer,
};

fn config() -> ProptestConfig {
    let from_environment = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    if std::env::var_os("PROPTEST_CASES").is_some() {
        from_environment
    } else {
        ProptestConfig {
            cases: 64,
            rng_seed: RngSeed::Fixed(0x5EED),
            ..from_environment
        }
    }
}

/// Any number at all, the ends of the doubles among them.
fn hostile() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -3.0..3.0,
        1 => proptest::sample::select(vec![
            f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, 5e-324, f64::MIN_POSITIVE,
            1e-300, 1e-18, 1e18, 1e150, 1e300, -1e300, f64::MAX,
        ]),
        1 => any::<f64>(),
    ]
}

/// A number of order one, or, now and then, a hostile one.
fn number(low: f64, high: f64) -> impl Strategy<Value = f64> {
    prop_oneof![40 => low..high, 1 => hostile()]
}

fn vector(n: usize, low: f64, high: f64) -> impl Strategy<Value = DVector<f64>> {
    proptest::collection::vec(number(low, high), n).prop_map(DVector::from_vec)
}

/// A length that is right most of the time.
fn length(n: usize) -> impl Strategy<Value = usize> {
    prop_oneof![30 => Just(n), 1 => 0..5usize]
}

fn matrix(rows: usize, columns: usize) -> impl Strategy<Value = DMatrix<f64>> {
    proptest::collection::vec(number(-1.0, 1.0), rows * columns)
        .prop_map(move |entries| DMatrix::from_vec(rows, columns, entries))
}

/// A coefficient that is symmetric positive, diagonal, or anything; scaled.
fn coefficient(n: usize) -> impl Strategy<Value = Coefficient> {
    let square = move || (length(n), length(n)).prop_flat_map(|(r, c)| matrix(r, c));
    let shape = prop_oneof![
        6 => square().prop_map(|a| {
            let product = &a * a.transpose();
            Coefficient::Dense(&product + DMatrix::identity(product.nrows(), product.ncols()))
        }),
        3 => length(n).prop_flat_map(|n| vector(n, 0.1, 4.0)).prop_map(Coefficient::Diagonal),
        1 => square().prop_map(Coefficient::Dense),
    ];
    let scale = prop_oneof![12 => Just(1.0), 2 => 1e-3..1e3, 1 => hostile()];
    (shape, scale).prop_map(|(shape, scale)| shape.scaled(scale))
}

fn system(n: usize) -> impl Strategy<Value = Result<LinearSystem, Error>> {
    let damping = (
        coefficient(n),
        prop_oneof![Just(0.0), Just(0.02), Just(0.3), Just(-0.05)],
    )
        .prop_map(|(c, scale)| c.scaled(scale));
    let load = proptest::option::weighted(0.3, length(n).prop_flat_map(|n| vector(n, -0.2, 0.2)));
    let influence =
        proptest::option::weighted(0.3, length(n).prop_flat_map(|n| vector(n, -1.0, 1.0)));
    (coefficient(n), damping, coefficient(n), load, influence).prop_map(
        |(mass, damping, stiffness, load, influence)| {
            let mut system = LinearSystem::new(mass, damping, stiffness)?;
            if let Some(load) = load {
                system = system.with_load(load)?;
            }
            if let Some(influence) = influence {
                system = system.with_influence(influence)?;
            }
            Ok(system)
        },
    )
}

fn forcing(n: usize) -> impl Strategy<Value = Result<Forcing, Error>> {
    let amplitude = (length(n), any::<bool>()).prop_flat_map(|(n, is_real)| {
        (vector(n, -1.0, 1.0), vector(n, -1.0, 1.0)).prop_map(move |(re, im)| {
            re.zip_map(&im, |re, im| {
                Complex::new(re, if is_real { 0.0 } else { im })
            })
        })
    });
    prop_oneof![
        1 => Just(Ok(Forcing::Unforced)),
        8 => (amplitude, number(0.3, 3.0), number(-4.0, 4.0))
            .prop_map(|(f, w, phase)| Harmonic::new(f, w, phase).map(Forcing::from)),
        1 => (number(-1.0, 1.0), number(0.3, 3.0), number(-4.0, 4.0))
            .prop_map(|(a, w, phase)| BaseMotion::new(a, w, phase).map(Forcing::from)),
    ]
}

fn stop(n: usize) -> impl Strategy<Value = Result<Stop, Error>> {
    let normal = prop_oneof![
        length(n).prop_map(vibroimpact::Normal::Coordinate),
        (0..n).prop_map(vibroimpact::Normal::Coordinate),
        length(n)
            .prop_flat_map(|n| vector(n, -1.0, 1.0))
            .prop_map(vibroimpact::Normal::Vector),
        length(n).prop_map(|n| vibroimpact::Normal::Vector(DVector::zeros(n))),
    ];
    let reaction = prop_oneof![
        6 => Just(Reaction::Inertia),
        2 => Just(Reaction::Coordinate),
        1 => length(n).prop_flat_map(|n| vector(n, -1.0, 1.0)).prop_map(Reaction::Direction),
    ];
    let side = prop_oneof![Just(Side::Upper), Just(Side::Lower)];
    (normal, number(0.05, 0.6), number(0.0, 1.0), side, reaction).prop_map(
        |(normal, clearance, restitution, side, reaction)| {
            Stop::new(normal, clearance, restitution)?
                .on_side(side)
                .with_reaction(reaction)
        },
    )
}

/// A scene of one to three degrees of freedom and none to three stops, one of them given twice now and then.
fn scene() -> impl Strategy<Value = Result<Scene, Error>> {
    (1..4usize).prop_flat_map(|n| {
        (
            system(n),
            forcing(n),
            proptest::collection::vec(stop(n), 0..3),
            any::<bool>(),
        )
            .prop_map(|(system, forcing, stops, is_repeated)| {
                let mut stops = stops.into_iter().collect::<Result<Vec<_>, _>>()?;
                if is_repeated && let [first, _] = stops.as_slice() {
                    stops.push(first.clone());
                }
                Scene::new(system?, forcing?, stops)
            })
    })
}

fn parameter() -> impl Strategy<Value = Parameter> {
    proptest::sample::select(vec![
        Parameter::Frequency,
        Parameter::Phase,
        Parameter::CLEARANCE,
        Parameter::CLEARANCE.of(0),
        Parameter::CLEARANCE.of(7),
        Parameter::RESTITUTION,
        Parameter::RESTITUTION.of(1),
        Parameter::ForcingScale,
        Parameter::DampingScale,
    ])
}

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        4 => (parameter(), number(0.1, 2.0)).prop_map(|(parameter, value)| parameter.change(value)),
        1 => proptest::collection::vec(number(0.0, 1.0), 0..4).prop_map(|values| Change::EachStop(StopNumber::Clearance, values)),
        1 => proptest::collection::vec(number(0.0, 1.0), 0..4).prop_map(|values| Change::EachStop(StopNumber::Restitution, values)),
        1 => (1..3usize).prop_flat_map(forcing)
            .prop_map(|f| Change::Forcing(f.unwrap_or_default())),
    ]
}

fn pattern() -> impl Strategy<Value = Result<Pattern, Error>> {
    proptest::collection::vec(proptest::collection::vec(0..4usize, 0..3), 0..4)
        .prop_map(Pattern::new)
}

fn is_finite(x: &DVector<f64>) -> bool {
    x.iter().all(|x| x.is_finite())
}

/// Kinetic energy.
fn kinetic(system: &LinearSystem, v: &DVector<f64>) -> f64 {
    0.5 * v.dot(&system.mass().times(v))
}

/// Whether an impact along `M^-1 n` gives every stop its reaction.
fn is_inertial(scene: &Scene) -> bool {
    scene.stops().iter().all(|stop| {
        matches!(stop, vibroimpact::Constraint::Stop(stop) if *stop.reaction() == Reaction::Inertia)
    })
}

/// Whether no number of the scene is so far from one that squares and products leave the doubles or their digits.
fn is_moderate(scene: &Scene) -> bool {
    let Ok(system) = scene.linear_system("the test") else {
        return false;
    };
    let within = |x: f64| x == 0.0 || (1e-6..1e6).contains(&x.abs());
    let matrices = [system.mass(), system.damping(), system.stiffness()].map(Coefficient::to_dense);
    let force = match scene.forcing() {
        Forcing::Unforced => Vec::new(),
        Forcing::Harmonic(f) => f.amplitude().iter().flat_map(|z| [z.re, z.im]).collect(),
        Forcing::BaseMotion(f) => (f.amplitudes().iter().flatten())
            .flat_map(|z| [z.re, z.im])
            .collect(),
        Forcing::Load(_) | Forcing::BaseAcceleration(_) | Forcing::Several(_) => return false,
        Forcing::Fourier(f) => {
            let amplitudes = f.amplitudes().iter().flatten().flat_map(|z| [z.re, z.im]);
            amplitudes
                .chain(f.mean().into_iter().flatten().copied())
                .collect()
        }
    };
    let stops = scene.stops().iter().flat_map(|stop| match stop {
        vibroimpact::Constraint::Stop(stop) => {
            let normal = stop.normal_vector(scene.n_dof(), "stop").expect("checked");
            let mut numbers: Vec<f64> = normal.iter().copied().collect();
            if let Reaction::Direction(b) = stop.reaction() {
                numbers.extend(b.iter());
            }
            numbers.push(stop.clearance());
            numbers
        }
        vibroimpact::Constraint::Wall(_) | vibroimpact::Constraint::Nonlinear(_) => Vec::new(),
    });
    let condition = {
        let values = matrices[0].clone().symmetric_eigenvalues();
        values.max() / values.min()
    };
    matrices.iter().flat_map(|m| m.iter().copied()).all(within)
        && system.load().iter().copied().all(within)
        && system
            .influence()
            .is_none_or(|r| r.iter().copied().all(within))
        && force.into_iter().all(within)
        && scene
            .forcing()
            .frequency()
            .is_none_or(|w| (0.01..100.0).contains(&w))
        && within(scene.forcing().phase())
        && stops.into_iter().all(within)
        && condition < 1e6
}

/// The moduli of the fastest and the growth rate of the fastest growing motion.
fn rates(scene: &Scene) -> Option<(f64, f64)> {
    let modes = modes(scene.linear_system("the test").ok()?).ok()?;
    let growth = modes.eigenvalues.iter().map(|l| l.re).fold(0.0, f64::max);
    Some((modes.eigenvalues.camax(), growth))
}

/// Whether the motion of a period has few enough oscillations to be followed: the work is in proportion to them.
fn is_followed(scene: &Scene, n_periods: usize) -> bool {
    let Some(period) = scene.period() else {
        return true;
    };
    rates(scene).is_some_and(|(fastest, _)| n_periods as f64 * period * fastest < 1e3)
}

fn check_trajectory(scene: &Scene, run: &Trajectory) {
    let (q, v) = run.last();
    assert!(is_finite(q) && is_finite(v), "{}", run.message());
    let system = scene.linear_system("the test").expect("it ran");
    for impact in run.impacts() {
        let before = run.state(impact.time, ImpactSide::Before).expect("kept");
        let after = run.state(impact.time, ImpactSide::After).expect("kept");
        let size = before.0.amax() + before.1.amax();
        assert!(
            (&before.0 - &after.0).amax() <= 1e-10 * size,
            "the position jumps"
        );
        assert!(impact.approach > 0.0 && impact.impulse >= 0.0);
        if is_inertial(scene) {
            let (gained, had) = (kinetic(system, &after.1), kinetic(system, &before.1));
            assert!(gained <= had * (1.0 + 1e-9), "{gained} after {had}");
        }
    }
    if let Ok((_, positions, velocities)) = run.samples() {
        assert!(
            positions
                .iter()
                .chain(velocities.iter())
                .all(|x| x.is_finite())
        );
        for q in positions.row_iter() {
            let q = q.transpose();
            for (i, &gap) in scene.gaps(&q).expect("plane stops").iter().enumerate() {
                let vibroimpact::Constraint::Stop(stop) = &scene.stops()[i] else {
                    continue;
                };
                let normal = stop.normal_vector(scene.n_dof(), "stop").expect("checked");
                // The margin: 10 (atol |n|_1 + rtol size), the size that of the terms over the whole run.
                let size = stop.clearance().abs()
                    + normal.abs().dot(&DVector::from_iterator(
                        scene.n_dof(),
                        positions.column_iter().map(|c| c.amax()),
                    ));
                let margin = 10.0 * (1e-12 * normal.lp_norm(1) + 1e-9 * size);
                assert!(gap >= -10.0 * margin, "stop {i} is passed by {:e}", -gap);
            }
        }
    }
}

/// The laws of an orbit: at each impact the position goes on and the normal velocity turns; the period leads back.
fn check_orbit(orbit: &PeriodicOrbit) {
    let scene = orbit.scene();
    let (q, v) = (orbit.q0(), orbit.v0());
    assert!(is_finite(&q) && is_finite(&v) && orbit.period() > 0.0);
    if rates(scene).is_none_or(|(_, growth)| growth * orbit.period() > 5.0) {
        return; // what grows so much in a period takes as many digits with it
    }
    for impact in orbit.impacts() {
        assert!(impact.time.is_finite() && (0.0..orbit.period()).contains(&impact.time));
        let (before, after) = (
            orbit
                .state(impact.time, ImpactSide::Before)
                .expect("a time"),
            orbit.state(impact.time, ImpactSide::After).expect("a time"),
        );
        let size = before.0.amax() + before.1.amax();
        assert!(
            (&before.0 - &after.0).amax() <= 1e-8 * size,
            "the position jumps"
        );
        let vibroimpact::Constraint::Stop(stop) = &scene.stops()[impact.stop] else {
            continue;
        };
        let normal = stop.normal_vector(scene.n_dof(), "stop").expect("checked");
        let turned = normal.dot(&after.1)
            + stop.restitution().expect("rigid").value() * normal.dot(&before.1);
        let speed = normal.norm() * (before.1.norm() + after.1.norm());
        assert!(
            turned.abs() <= 1e-8 * speed,
            "restitution is off by {turned:e} of {speed:e}"
        );
    }
    let Ok(stability) = orbit.stability() else {
        return;
    };
    let radius = stability
        .orders
        .iter()
        .map(vibroimpact::OrderMultipliers::spectral_radius)
        .fold(0.0, f64::max);
    if orbit.is_admissible() == Some(true) && !stability.orders.is_empty() && radius < 10.0 {
        let first_flight = orbit
            .impacts()
            .iter()
            .map(|i| i.time)
            .find(|&t| t > 0.0)
            .unwrap_or(orbit.period());
        let end = orbit.period() + 0.5 * first_flight;
        let options = SimulateOptions {
            keep: Keep::Impacts,
            ..Default::default()
        };
        let run = simulate(scene, &q, &v, (0.0, end), &options).expect("an orbit's own scene");
        if run.span().1 == end {
            let (there, velocity) = orbit
                .state(0.5 * first_flight, ImpactSide::After)
                .expect("a time");
            let size = there.amax() + velocity.amax() + q.amax() + v.amax();
            let miss = (run.last().0 - there).amax() + (run.last().1 - velocity).amax();
            assert!(
                miss <= 1e-6 * size,
                "a period later it misses by {miss:e} of {size:e}"
            );
        }
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn constructors_refuse_or_keep_what_they_are_given(
        scene in scene(),
        change in change(),
        masses in (0..4usize).prop_flat_map(|n| vector(n, 0.1, 2.0)),
        lengths in (0..4usize).prop_flat_map(|n| vector(n, 0.1, 2.0)),
        dampers in (0..4usize).prop_flat_map(|n| vector(n, 0.0, 1.0)),
        numbers in [hostile(), hostile(), hostile(), hostile()],
        bob in 0..4usize,
    ) {
        if let Ok(scene) = &scene {
            prop_assert_eq!(scene.gaps(&DVector::zeros(scene.n_dof())).expect("no user function").len(), scene.stops().len());
            prop_assert!(is_finite(&scene.gaps(&DVector::zeros(scene.n_dof())).expect("no user function")));
            let is_clearance = matches!(change, Change::EachStop(StopNumber::Clearance, _));
            if let Ok(changed) = scene.replace(change) {
                prop_assert_eq!(changed.n_dof(), scene.n_dof());
                prop_assert!(!(is_clearance && scene.stops().is_empty()), "there is nothing to change");
            }
        }
        let [a, b, c, d] = numbers;
        if let Ok(pendulum) = DoublePendulum::new(a, b, (c, d)) {
            let linear = pendulum.linearise();
            prop_assert!(linear.is_err() || linear.is_ok_and(|s| s.n_dof() == 2));
        }
        if let Ok(chain) = PendulumChain::new(masses, lengths, &dampers, d) {
            let n = chain.n_dof();
            prop_assert!(n > 0 && chain.lengths().len() == n);
            if let (Ok(wall), Ok(_)) = (Wall::new(bob, a, b, WallSide::Left), chain.linearise()) {
                let none: [Stop; 0] = [];
                let open = Scene::new(vibroimpact::System::from(chain.clone()), Forcing::Unforced, none);
                prop_assert!(open.is_ok());
                let walled = Scene::new(vibroimpact::System::from(chain), Forcing::Unforced, [wall]);
                prop_assert_eq!(walled.is_ok(), bob < n);
                if let Ok(walled) = walled {
                    let _ = vibroimpact::linearise(&walled);
                }
            }
        }
    }

    #[test]
    fn modes_are_normalised_by_the_mass(system in (1..4usize).prop_flat_map(system)) {
        let none: [Stop; 0] = [];
        if let Ok(system) = system
            && let Ok(modes) = modes(&system)
            && is_moderate(&Scene::new(system.clone(), Forcing::Unforced, none).expect("valid"))
        {
            let mass = system.mass().to_dense().map(Complex::from);
            let product = modes.shapes.adjoint() * mass * &modes.shapes;
            for i in 0..system.n_dof() {
                prop_assert!((product[(i, i)] - 1.0).norm() < 1e-9, "{}", product);
            }
            if system.stiffness().is_symmetric() {
                let identity = DMatrix::identity(system.n_dof(), system.n_dof());
                prop_assert!((product - identity).camax() < 1e-9);
            }
            prop_assert_eq!(modes.eigenvalues.len(), 2 * system.n_dof());
        }
    }

    #[test]
    fn an_inertial_recovery_turns_the_normal_velocity_and_takes_energy(
        scene in scene(),
        stops in proptest::collection::vec(0..4usize, 0..3),
    ) {
        if let Ok(scene) = scene
            && let Ok(matrix) = recovery_matrix(&scene, &stops)
            && is_moderate(&scene)
        {
            let n = scene.n_dof();
            let mass = scene.linear_system("the test").expect("linear").mass().to_dense();
            let mut normals = DMatrix::zeros(n, stops.len());
            let mut wanted = Vec::new();
            for (column, &i) in stops.iter().enumerate() {
                let vibroimpact::Constraint::Stop(stop) = &scene.stops()[i] else { continue };
                normals.set_column(column, &stop.normal_vector(n, "stop").expect("checked"));
                wanted.push(stop.restitution().expect("rigid").value());
            }
            let audit = audit_recovery(&matrix, &mass, &normals).expect("finite");
            if let ([e], true) = (wanted.as_slice(), is_inertial(&scene)) {
                prop_assert!(audit.is_realisable, "{:?}", audit.reasons);
                prop_assert!((audit.restitution[0] - e).abs() < 1e-8);
                prop_assert!(audit.energy_gain <= 1.0 + 1e-9);
            }
        }
    }

    #[test]
    fn audits_refuse_or_judge_any_matrix(
        matrix in (0..7usize, 0..7usize).prop_flat_map(|(r, c)| matrix(r, c)),
        mass in (0..4usize, 0..4usize).prop_flat_map(|(r, c)| matrix(r, c)),
        normals in (0..4usize, 0..3usize).prop_flat_map(|(r, c)| matrix(r, c)),
    ) {
        if let Ok(audit) = audit_recovery(&matrix, &mass, &normals) {
            prop_assert_eq!(audit.is_realisable, audit.reasons.is_empty());
            prop_assert_eq!(audit.restitution.len(), normals.ncols());
        }
    }

    #[test]
    fn trajectories_are_finite_stay_outside_the_stops_and_gain_no_energy_at_impacts(
        scene in scene(),
        q in (1..4usize).prop_flat_map(|n| vector(n, -0.05, 0.05)),
        v in (1..4usize).prop_flat_map(|n| vector(n, -1.0, 1.0)),
        start in number(-10.0, 10.0),
        span in number(0.0, 40.0),
        tolerances in (number(0.0, 1e-6), number(0.0, 1e-9)),
        t_eval in proptest::option::of(proptest::collection::vec(number(-10.0, 50.0), 0..4)),
    ) {
        if let Ok(scene) = scene {
            let n = scene.n_dof();
            let fitted = |x: &DVector<f64>| {
                if x.len() >= n { x.rows(0, n).into_owned() } else { x.clone() }
            };
            let (q, v) = (fitted(&q), fitted(&v));
            // Runs that would take more than so many steps are broken off.
            let few = || {
                let checks = Cell::new(0);
                move |_| {
                    checks.set(checks.get() + 1);
                    if checks.get() > 400 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
                }
            };
            let hostile_options = SimulateOptions { solver: Solver { rtol: tolerances.0, atol: Some(tolerances.1), ..Solver::default() }, t_eval, max_impacts: Some(200), ..Default::default() };
            let end = start + span;
            let run = || simulate(&scene, &q, &v, (start, end), &hostile_options);
            if let Ok(run) = with_observer(few(), run) {
                let (q, v) = run.last();
                prop_assert!(is_finite(q) && is_finite(v), "{}", run.message());
            }
            let options = SimulateOptions { max_impacts: Some(200), ..Default::default() };
            let is_slow = q.iter().chain(&v).all(|x| x.abs() < 1e3) && start.abs() < 1e3;
            if is_moderate(&scene)
                && is_slow
                && let Ok(run) = with_observer(few(), || simulate(&scene, &q, &v, (start, end), &options))
            {
                check_trajectory(&scene, &run);
            }
        }
    }

    #[test]
    fn orbits_close(
        scene in scene(),
        pattern in pattern(),
        n_periods in 0..4usize,
        phase in proptest::option::weighted(0.2, number(-4.0, 4.0)),
        free in proptest::option::weighted(0.2, prop_oneof![
            Just(FreeParameter::Clearance),
            parameter().prop_map(FreeParameter::Parameter),
        ]),
        between in proptest::option::weighted(0.1, (number(0.0, 1.0), number(1.0, 2.0))),
    ) {
        if let (Ok(scene), Ok(pattern)) = (scene, pattern) {
            let is_short = pattern.instants().len() < 2 || is_moderate(&scene);
            let options = OrbitOptions { n_periods, phase, free, between };
            // A free frequency or damping may be anything in its range.
            let is_fixed = !matches!(free, Some(FreeParameter::Parameter(Parameter::Frequency | Parameter::DampingScale)));
            if is_short && is_fixed && is_followed(&scene, n_periods) && let Ok(orbits) = periodic_orbits(&scene, &pattern, &options) && is_moderate(&scene) {
                for orbit in orbits.iter() {
                    check_orbit(orbit);
                }
            }
        }
    }

    #[test]
    fn maps_have_the_orbits_of_their_scenes(
        scene in scene(),
        stop in 0..3usize,
        n_periods in 0..3usize,
        parameters in (parameter(), parameter()),
        values in (
            proptest::collection::vec(number(0.1, 1.0), 0..4),
            proptest::collection::vec(number(0.1, 1.0), 0..4),
        ),
    ) {
        if let Ok(scene) = scene {
            let pattern = Pattern::single(stop);
            let (x, y) = (Axis::new(parameters.0, values.0), Axis::new(parameters.1, values.1));
            let there = |a: f64, b: f64| {
                scene
                    .replace(x.parameter.change(a))
                    .and_then(|scene| scene.replace(y.parameter.change(b)))
            };
            let is_short = y.values.iter().all(|&b| {
                x.values.iter().all(|&a| there(a, b).map_or(true, |s| is_followed(&s, n_periods)))
            });
            if !is_short {
                return Ok(());
            }
            let map = existence_map(&scene, &pattern, (&x, &y), n_periods, SweepOptions::default());
            if let Ok(map) = map && is_moderate(&scene) {
                for (j, &b) in map.y.iter().enumerate() {
                    for (i, &a) in map.x.iter().enumerate() {
                        let there = there(a, b).expect("the map took it");
                        let options = OrbitOptions { n_periods, ..Default::default() };
                        let orbits = periodic_orbits(&there, &pattern, &options).expect("the map took it");
                        prop_assert_eq!(map.point(i, j).n_orbits as usize, orbits.len());
                    }
                }
            }
        }
    }
}
