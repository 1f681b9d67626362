//! `find_orbit` from outside: against the closed form, against simulation, and where the problem is singular.

use crate::scenes::{harmonic, lower, oscillator, periods, run, scene, upper};
use nalgebra::{DVector, dmatrix, dvector};
use std::f64::consts::TAU;
use vibroimpact::{
    BaseMotion, Change, Error, Forcing, Guess, ImpactSide, Keep, Kind, Motion, OrbitOptions,
    PaperOptions, Parameter, Pattern, PendulumChain, PeriodicOrbit, Scene, SegmentKind,
    SimulateOptions, Solver, Stop, StopNumber, find_orbit, find_orbit_in_order, nalgebra,
    paper_scene, periodic_orbits, simulate,
};

/// How far a simulation from a point of the orbit between two impacts is from it a period later, relative to its size.
fn opening(orbit: &PeriodicOrbit) -> f64 {
    let start = orbit.impacts().get(1).map_or(orbit.period(), |i| i.time) / 2.0;
    let (q0, v0) = orbit.state(start, ImpactSide::After).expect("a time");
    let keep = SimulateOptions {
        solver: Solver {
            rtol: 1e-12,
            atol: Some(1e-15),
            ..Solver::default()
        },
        keep: Keep::Final,
        ..Default::default()
    };
    let span = (start, start + orbit.period());
    let run = simulate(orbit.scene(), &q0, &v0, span, &keep).expect("valid");
    let (q, v) = run.last();
    let size = orbit.q0().amax().max(orbit.v0().amax());
    ((q - &q0).amax() / size).max((v - &v0).amax() / size)
}

#[test]
fn a_neighbour_leads_to_the_closed_form() {
    let guess = paper_scene(Kind::Three, &PaperOptions::default()).expect("valid");
    let guesses = periodic_orbits(&guess, &Pattern::single(1), &periods(2)).expect("found");
    let damped = PaperOptions {
        damping: Some(0.055),
        ..Default::default()
    };
    let scene = paper_scene(Kind::Three, &damped).expect("valid");
    let wanted = periodic_orbits(&scene, &Pattern::single(1), &periods(2)).expect("found");
    assert_eq!(guesses.len(), 2);
    for (guess, wanted) in guesses.iter().zip(wanted.iter()) {
        let orbit = find_orbit(&scene, guess, None).expect("converges");
        assert!((orbit.phase() - wanted.phase()).abs() < 1e-11);
        assert!((orbit.q0() - wanted.q0()).amax() < 1e-12);
        assert!((orbit.v0() - wanted.v0()).amax() < 1e-12);
        assert_eq!(orbit.is_admissible(), wanted.is_admissible());
        let (a, b) = (&orbit.impacts()[0], &wanted.impacts()[0]);
        assert!((a.impulse - b.impulse).abs() < 1e-12 && (a.approach - b.approach).abs() < 1e-12);
    }
}

#[test]
fn two_instants_and_two_stops_together_agree_with_their_own_solvers() {
    let stops = vec![upper(0, 0.5, 0.8), lower(0, 0.55, 0.7)];
    let scene = oscillator(0.1, harmonic(&[1.0], 1.4, 0.0), stops);
    let pattern = Pattern::new(vec![vec![0], vec![1]]).expect("valid");
    let guesses = periodic_orbits(&scene, &pattern, &periods(1)).expect("searched");
    let near = scene
        .replace(Parameter::ForcingScale.change(1.01))
        .expect("valid");
    let wanted = periodic_orbits(&near, &pattern, &periods(1)).expect("searched");
    assert!(!guesses.is_empty());
    for guess in guesses.iter() {
        let orbit = find_orbit(&near, guess, None).expect("converges");
        let is_same = |w: &PeriodicOrbit| {
            (w.q0() - orbit.q0()).amax() < 1e-10 && (w.v0() - orbit.v0()).amax() < 1e-10
        };
        assert!(wanted.iter().any(is_same));
    }

    let options = PaperOptions {
        damping: Some(0.05),
        clearance: Some(0.8),
        ..Default::default()
    };
    let kind_1 = paper_scene(Kind::One, &options).expect("valid");
    let free = OrbitOptions {
        n_periods: 3,
        free: Some(vibroimpact::FreeParameter::Clearance),
        ..Default::default()
    };
    let together = Pattern::together(&[0, 1]).expect("valid");
    let known = periodic_orbits(&kind_1, &together, &free).expect("found");
    let known = known
        .iter()
        .find(|o| o.is_admissible() == Some(true))
        .expect("theory 3");
    let orbit = find_orbit(known.scene(), known, None).expect("it is closed already");
    assert!((orbit.v0() - known.v0()).amax() < 1e-12);
    // No phase lets both pendulums hit together at other clearances: the mismatch stays and is reported.
    let other = known
        .scene()
        .replace(Change::EachStop(StopNumber::Clearance, vec![0.8, 0.85]))
        .expect("valid");
    let Err(Error::NoConvergence { residual, .. }) = find_orbit(&other, known, None) else {
        panic!("nothing closes here");
    };
    assert!(residual > 1e-4 && residual < 1.0);
}

#[test]
fn a_trajectory_leads_to_the_orbit_it_settles_on() {
    let scene = paper_scene(Kind::Three, &PaperOptions::default()).expect("valid");
    let wanted = periodic_orbits(&scene, &Pattern::single(1), &periods(2)).expect("found");
    let stable = &wanted[0];
    assert_eq!(stable.stability().expect("computed").is_stable, Some(true));
    // Off the orbit by a thousandth, and far from settled.
    let (q0, v0) = (stable.q0() * 0.999, stable.v0() * 1.002);
    let span = (0.0, 4.2 * stable.period());
    let run = simulate(stable.scene(), &q0, &v0, span, &SimulateOptions::default()).expect("runs");
    for n_periods in [None, Some(2)] {
        let orbit = find_orbit(stable.scene(), &run, n_periods).expect("converges");
        assert_eq!(orbit.n_periods(), 2);
        assert!((orbit.phase() - stable.phase()).abs() < 1e-11);
        assert!((orbit.v0() - stable.v0()).amax() < 1e-12);
    }
    let twice =
        find_orbit(stable.scene(), &run, Some(4)).expect("the same orbit, gone through twice");
    assert_eq!(twice.pattern().instants().len(), 2);
    assert!((twice.v0() - stable.v0()).amax() < 1e-11);
}

#[test]
fn many_instants_close_and_are_retraced() {
    // Soft forcing below the natural frequency: several impacts a period.
    let (mut found, mut n_held) = (Vec::new(), 0);
    for step in 0..60 {
        let frequency = 0.2 + 0.01 * f64::from(step);
        let scene = oscillator(0.1, harmonic(&[1.0], frequency, 0.0), [upper(0, 0.1, 0.6)]);
        let period = TAU / frequency;
        let settle = SimulateOptions {
            t_eval: None,
            ..Default::default()
        };
        let run = run(&scene, &[0.0], &[0.0], 60.0 * period, &settle);
        if run.status() != vibroimpact::Status::Finished {
            continue;
        }
        let Ok(orbit) = find_orbit(&scene, &run, None) else {
            continue;
        };
        let count = orbit.pattern().instants().len();
        if count < 3 || orbit.is_admissible() != Some(true) {
            continue;
        }
        let multipliers = orbit.stability().expect("computed");
        assert!(
            opening(&orbit) < 1e-9,
            "frequency {frequency}: {}",
            opening(&orbit)
        );
        for impact in orbit.impacts() {
            let (q, _) = orbit.state(impact.time, ImpactSide::After).expect("a time");
            assert!((q[0] - 0.1).abs() < 1e-13);
            assert!((impact.departure - 0.6 * impact.approach).abs() < 1e-13);
        }
        let det: nalgebra::Complex<f64> = multipliers.orders[0].multipliers.iter().product();
        if orbit
            .segments()
            .expect("linear")
            .iter()
            .any(|s| s.kind == SegmentKind::Stick)
        {
            // Held: one degree of freedom keeps nothing.
            assert!(det.norm() < 1e-12 && multipliers.is_stable == Some(true));
            n_held += 1;
            continue;
        }
        // det of the monodromy: e^2 for each impact, and the damping (theory 7).
        let law =
            0.6f64.powi(2 * i32::try_from(count).expect("small")) * (-0.1 * orbit.period()).exp();
        assert!((det.re / law - 1.0).abs() < 1e-6 && det.im.abs() < 1e-9 * law.max(1e-300) + 1e-15);
        found.push(count);
    }
    assert!(found.len() >= 3 && n_held >= 3, "{found:?} {n_held}");
}

#[test]
fn an_impact_without_speed_is_a_regular_point() {
    // The steady response touches a stop at its own amplitude: an orbit whose impact has no speed.
    let (damping, frequency) = (0.2, 1.3);
    let amplitude = 1.0 / (1.0f64 - frequency * frequency).hypot(damping * frequency);
    let near = oscillator(
        damping,
        harmonic(&[1.0], frequency, 0.0),
        [upper(0, 0.999 * amplitude, 0.7)],
    );
    let guesses = periodic_orbits(&near, &Pattern::single(0), &periods(1)).expect("found");
    let slow = guesses
        .iter()
        .min_by(|a, b| a.impacts()[0].approach.total_cmp(&b.impacts()[0].approach))
        .expect("two orbits");
    let grazing = oscillator(
        damping,
        harmonic(&[1.0], frequency, 0.0),
        [upper(0, amplitude, 0.7)],
    );
    let orbit = find_orbit(&grazing, slow, None).expect("converges");
    assert!(
        orbit.impacts()[0].approach.abs() < 1e-11,
        "{}",
        orbit.impacts()[0].approach
    );
    assert!((orbit.q0()[0] - amplitude).abs() < 1e-12);
    assert!(orbit.v0()[0].abs() < 1e-11);
}

#[test]
fn without_forcing_the_period_is_found() {
    // q'' + q = 0 below a stop at c, elastic: from the stop with speed s, amplitude a = hypot(c, s), back after
    // 2 pi - 2 arccos(c/a).
    let scene = oscillator(0.0, Forcing::Unforced, [upper(0, 0.5, 1.0)]);
    let run = run(&scene, &[0.0], &[1.0], 30.0, &SimulateOptions::default());
    let orbit = find_orbit(&scene, &run, None).expect("a family; the nearest member");
    let amplitude = 0.5f64.hypot(orbit.v0()[0]);
    assert!((orbit.period() - (TAU - 2.0 * (0.5 / amplitude).acos())).abs() < 1e-12);
    assert!((amplitude - 1.0).abs() < 1e-12 && orbit.is_admissible() == Some(true));
    assert!((orbit.impacts()[0].approach + orbit.v0()[0]).abs() < 1e-12);
    let Err(Error::BadValue { argument, .. }) = find_orbit(&scene, &run, Some(1)) else {
        panic!("no forcing to count periods of");
    };
    assert_eq!(argument, "n_periods");
    // Self-excited: negative damping feeds what the impact takes. Unit frequency, -2 eta = 0.1, c = 0: half-turns of the
    // spiral, e^{eta pi/wd} e = 1 at no e but one; with c > 0 the amplitude settles by itself.
    let excited = oscillator(-0.1, Forcing::Unforced, [upper(0, 0.5, 0.8)]);
    let run = crate::scenes::run(&excited, &[0.0], &[0.6], 400.0, &SimulateOptions::default());
    let orbit = find_orbit(&excited, &run, None).expect("converges");
    assert!(opening(&orbit) < 1e-10);
    let multipliers = &orbit.stability().expect("computed").orders[0].multipliers;
    assert!(
        multipliers.iter().any(|m| (m - 1.0).norm() < 1e-9),
        "time may be shifted: {multipliers}"
    );
}

#[test]
fn motions_without_impacts_are_the_steady_response() {
    let scene = oscillator(0.2, harmonic(&[1.0], 0.7, 0.0), [upper(0, 10.0, 0.5)]);
    let run = run(&scene, &[0.0], &[0.0], 50.0, &SimulateOptions::default());
    let orbit = find_orbit(&scene, &run, None).expect("linear");
    let y = nalgebra::Complex::new(1.0 - 0.49, 0.2 * 0.7).inv();
    let q = |t: f64| (y * nalgebra::Complex::from_polar(1.0, 0.7 * t + orbit.phase())).re;
    for k in 0..10 {
        let t = f64::from(k);
        assert!((orbit.state(t, ImpactSide::After).expect("a time").0[0] - q(t)).abs() < 1e-13);
    }
    assert!((orbit.phase() - (0.7 * 50.0f64).rem_euclid(TAU)).abs() < 1e-12);
}

#[test]
fn what_cannot_be_a_guess_is_refused() {
    let scene = oscillator(0.1, harmonic(&[1.0], 0.8, 0.0), [upper(0, 0.2, 0.6)]);
    let still = DVector::zeros(1);
    let short = simulate(
        &scene,
        &still,
        &still,
        (0.0, 3.0),
        &SimulateOptions::default(),
    )
    .expect("valid");
    let text = find_orbit(&scene, &short, None)
        .expect_err("too short")
        .to_string();
    assert!(
        text.contains("guess") && text.contains("simulate longer"),
        "{text}"
    );
    let keep = SimulateOptions {
        keep: Keep::Impacts,
        ..Default::default()
    };
    let forgotten = simulate(&scene, &still, &still, (0.0, 100.0), &keep).expect("valid");
    let text = find_orbit(&scene, &forgotten, None)
        .expect_err("no motion")
        .to_string();
    assert!(text.contains("keep"), "{text}");
    let pendulum = paper_scene(Kind::Three, &PaperOptions::default()).expect("valid");
    let orbits = periodic_orbits(&pendulum, &Pattern::single(1), &periods(2)).expect("found");
    for (scene, n, word) in [
        (&scene, None, "guess"),
        (&pendulum, Some(3), "n_periods"),
        (&pendulum, Some(0), "n_periods"),
    ] {
        let text = find_orbit(scene, &orbits[0], n)
            .map(|o| o.phase())
            .expect_err("refused")
            .to_string();
        assert!(text.contains(word), "{text}");
    }
}

#[test]
fn the_stops_of_a_pattern_alone_are_looked_at() {
    let two = vec![upper(0, 0.5, 0.8), lower(0, 0.55, 0.7)];
    let plain = oscillator(0.1, harmonic(&[1.0], 1.4, 0.0), two.clone());
    let pattern = Pattern::new(vec![vec![0], vec![1]]).expect("valid");
    let known = periodic_orbits(&plain, &pattern, &periods(1)).expect("searched");
    let known = known
        .iter()
        .find(|orbit| orbit.is_admissible() == Some(true));
    let known = known.expect("one");
    // A third stop in the middle of the motion, which every flight passes.
    let three = [two, vec![upper(0, 0.1, 0.5)]].concat();
    let scene = oscillator(0.1, harmonic(&[1.0], 1.4, 0.0), three);
    let t = known.period() - 0.05;
    let (q, v) = known.state(t, ImpactSide::After).expect("a time");
    let (q, v) = (q * 1.001, v * 0.999);
    let phase = Parameter::Phase.change(known.phase() + 1.4 * t);
    let turned = scene.replace(phase).expect("valid");
    let settled = run(
        &plain,
        &[0.0],
        &[0.0],
        60.0 * known.period(),
        &SimulateOptions::default(),
    );
    let state = Guess::State {
        q: &q,
        v: &v,
        period: None,
    };
    for guess in [state, Guess::Orbit(known), Guess::Trajectory(&settled)] {
        let own = if matches!(guess, Guess::State { .. }) {
            &turned
        } else {
            &scene
        };
        let found = find_orbit_in_order(own, guess, None, &pattern).expect("found");
        assert_eq!(found.pattern(), &pattern);
        assert_eq!(found.is_admissible(), Some(false));
        assert!((found.v0() - known.v0()).amax() < 1e-11, "{guess:?}");
        assert!((found.phase() - known.phase()).sin().abs() < 1e-11);
    }
    // Nothing at all, and a stop that is not reached.
    let none = find_orbit_in_order(&scene, state, None, &Pattern::none()).expect("steady");
    assert!(none.impacts().is_empty() && opening_of_steady(&none) < 1e-12);
    let far = oscillator(0.1, harmonic(&[1.0], 1.4, 0.0), vec![upper(0, 50.0, 0.8)]);
    let text = find_orbit_in_order(&far, state, None, &Pattern::single(0));
    let text = text.expect_err("out of reach").to_string();
    assert!(
        text.contains("pattern[0]") && text.contains("not hit within a period"),
        "{text}"
    );
    let text = find_orbit_in_order(&scene, state, None, &Pattern::single(3));
    assert!(
        text.expect_err("no such stop")
            .to_string()
            .contains("pattern[0]")
    );
    let free = oscillator(0.0, Forcing::Unforced, [upper(0, 0.5, 1.0)]);
    let text = find_orbit_in_order(&free, &settled, None, &Pattern::single(0));
    assert!(text.expect_err("no period").to_string().contains("period"));
}

/// How far a motion that hits nothing is from coming back.
fn opening_of_steady(orbit: &PeriodicOrbit) -> f64 {
    let (first, last) = (
        orbit.state(0.0, ImpactSide::After).expect("a time"),
        orbit
            .state(orbit.period(), ImpactSide::After)
            .expect("a time"),
    );
    (first.0 - last.0).amax().max((first.1 - last.1).amax())
}

/// The paper's third case at a part of its amplitude, linear or of large angles.
fn third(part: f64, linear: bool) -> Scene {
    let options = PaperOptions {
        linear,
        ..Default::default()
    };
    let scene = paper_scene(Kind::Three, &options).expect("valid");
    let clearances = scene.gaps(&DVector::zeros(2)).expect("plane stops") * part;
    let clearances = clearances.iter().copied().collect();
    scene
        .replace(Parameter::ForcingScale.change(part))
        .and_then(|scene| scene.replace(Change::EachStop(StopNumber::Clearance, clearances)))
        .expect("valid")
}

#[test]
fn large_angles_have_an_orbit_near_the_linear_one_that_nears_it_with_the_square_of_the_amplitude() {
    let apart = |part: f64| {
        let linear =
            periodic_orbits(&third(part, true), &Pattern::single(1), &periods(2)).expect("found");
        let orbit = find_orbit(&third(part, false), &linear[0], None).expect("converges");
        assert!(
            orbit.is_admissible() == Some(true) && opening(&orbit) < 1e-9,
            "{part}"
        );
        (orbit.phase() - linear[0].phase()).abs()
    };
    let (small, smaller) = (apart(0.1), apart(0.05));
    assert!((small / smaller - 4.0).abs() < 0.05, "{small} {smaller}");
    assert!(apart(1.0) > 0.01);
}

#[test]
fn multipliers_of_large_angles_are_those_of_the_simulated_return_map() {
    let linear =
        periodic_orbits(&third(1.0, true), &Pattern::single(1), &periods(2)).expect("found");
    let orbit = find_orbit(&third(1.0, false), &linear[0], None).expect("converges");
    let start = 0.4 * orbit.period();
    let keep = SimulateOptions {
        solver: Solver {
            rtol: 1e-13,
            atol: Some(1e-15),
            ..Solver::default()
        },
        keep: Keep::Final,
        ..Default::default()
    };
    let returned = |x: &DVector<f64>| {
        let (q, v) = (x.rows(0, 2).into_owned(), x.rows(2, 2).into_owned());
        let run = simulate(
            orbit.scene(),
            &q,
            &v,
            (start, start + orbit.period()),
            &keep,
        )
        .expect("runs");
        let (q, v) = run.last();
        DVector::from_iterator(4, q.iter().chain(v.iter()).copied())
    };
    let (q, v) = orbit.state(start, ImpactSide::After).expect("a time");
    let x = DVector::from_iterator(4, q.iter().chain(v.iter()).copied());
    let columns: Vec<_> = (0..4)
        .map(|i| {
            let step = DVector::from_fn(4, |j, _| if i == j { 1e-6 } else { 0.0 });
            (returned(&(&x + &step)) - returned(&(&x - &step))) / 2e-6
        })
        .collect();
    let differences = nalgebra::DMatrix::from_columns(&columns).complex_eigenvalues();
    let multipliers = &orbit.stability().expect("computed").orders[0].multipliers;
    for multiplier in multipliers.iter() {
        let nearest = differences
            .iter()
            .map(|d| (d - multiplier).norm())
            .fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-6, "{multiplier}: {nearest:e}");
    }
}

#[test]
fn a_pendulum_against_a_wall_is_followed_from_its_trajectory() {
    let pendulum = vibroimpact::DoublePendulum::new(1.0, 2.0, (0.1, 0.05)).expect("valid");
    let base = vibroimpact::BaseMotion::new(0.25, 1.0, 0.0).expect("valid");
    let wall = vibroimpact::Wall::new(1, 0.3, 0.7, vibroimpact::WallSide::Right).expect("valid");
    let scene = scene(pendulum, base, [wall]);
    let still = DVector::zeros(2);
    let span = (0.0, 300.0 * TAU);
    let run = simulate(&scene, &still, &still, span, &SimulateOptions::default()).expect("runs");
    assert_eq!(
        run.status(),
        vibroimpact::Status::Finished,
        "{}",
        run.message()
    );
    let orbit = find_orbit(&scene, &run, None).expect("it has settled");
    assert!(orbit.is_admissible() == Some(true) && opening(&orbit) < 1e-8);
    assert_eq!(orbit.stability().expect("computed").is_stable, Some(true));
    for impact in orbit.impacts() {
        let (q, _) = orbit.state(impact.time, ImpactSide::After).expect("a time");
        assert!((q[0].sin() + 0.5 * q[1].sin() - 0.3).abs() < 1e-12);
        assert!((impact.departure - 0.7 * impact.approach).abs() < 1e-11);
    }
}

/// A run that comes to its motion by turns is still nearer to where it was two periods ago.
#[test]
fn a_motion_of_one_period_is_not_found_as_one_of_two() {
    let c = 0.211_042_339_534_924_2;
    let chain = PendulumChain::with_damping_matrix(
        dvector![0.901_866_812_046_203_2, 1.851_773_216_037_278_2],
        dvector![0.791_940_611_106_269_9, 0.642_959_370_396_258_6],
        dmatrix![c, -c; -c, c],
        1.0,
    );
    let base = BaseMotion::new(0.270_871_295_967_684_83, 1.675_498_104_737_948_5, 0.0);
    let stop = Stop::new(0, 0.024_188_287_433_522_29, 0.0).expect("valid");
    let scene = Scene::new(chain.expect("valid"), base.expect("valid"), [stop]).expect("valid");
    let mut found = 0;
    for (k, periods) in [40.0, 60.0, 80.0, 100.0].into_iter().enumerate() {
        let (q, v) = (dvector![0.0, 0.0], dvector![0.1, -0.1 * k as f64]);
        let until = periods * scene.period().expect("forced");
        let run = simulate(&scene, &q, &v, (0.0, until), &SimulateOptions::default());
        let run = run.expect("a run");
        let Ok(orbit) = find_orbit(&scene, &run, None) else {
            continue;
        };
        let one = orbit.period() / orbit.n_periods() as f64;
        let (now, later) = (
            orbit.state(0.3, ImpactSide::After).expect("a time"),
            orbit.state(0.3 + one, ImpactSide::After).expect("a time"),
        );
        let off = (now.0 - later.0).amax().max((now.1 - later.1).amax());
        assert!(orbit.n_periods() == 1 || off > 1e-6, "{periods}: {off:e}");
        found += 1;
        // What is asked for is given.
        if orbit.n_periods() == 1 {
            let twice = find_orbit(&scene, &run, Some(2)).expect("two rounds");
            assert_eq!(
                (twice.n_periods(), twice.impacts().len()),
                (2, 2 * orbit.impacts().len())
            );
        }
    }
    assert!(found > 2, "{found}");
}
