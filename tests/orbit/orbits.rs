//! Periodic orbits from outside: the paper's three kinds with the public numbers of theory section 3, closed forms,
//! degenerate cases.

use crate::random::Random;
use crate::scenes::{harmonic, loaded, oscillator, periods, scene, unit_mass, upper};
use nalgebra::{Complex, DMatrix, DVector, dvector};
use std::f64::consts::{PI, TAU};
use vibroimpact::{
    BaseMotion, Change, FreeParameter, Harmonic, ImpactSide, Kind, LinearSystem, Motion,
    OrbitOptions, PaperOptions, Parameter, Pattern, Reaction, Scene, Side, SimulateOptions, Stop,
    Verdict, first_kind_coefficients, modes, paper_scene, paper_system, periodic_orbits, simulate,
};

fn kind(kind: Kind, damping: f64) -> Scene {
    paper_scene(
        kind,
        &PaperOptions {
            damping: Some(damping),
            ..Default::default()
        },
    )
    .expect("valid")
}

fn first_kind(damping: f64) -> vibroimpact::Orbits {
    let options = OrbitOptions {
        free: Some(FreeParameter::Clearance),
        ..periods(3)
    };
    periodic_orbits(
        &kind(Kind::One, damping),
        &Pattern::together(&[0, 1]).expect("valid"),
        &options,
    )
    .expect("solved")
}

#[test]
fn first_kind_has_the_published_phase_angle_and_multipliers() {
    let orbits = first_kind(0.05);
    let orbit = &orbits[0];
    assert!(
        orbit.is_admissible() == Some(true),
        "{:?}",
        orbit.violation()
    );
    assert!(
        (orbit.phase().to_degrees() - 73.0915).abs() < 5e-5,
        "{}",
        orbit.phase().to_degrees()
    );
    assert!(
        (orbit.q0() - dvector![0.806_286, 0.806_286]).amax() < 5e-7,
        "{}",
        orbit.q0()
    );
    assert!(
        (orbit.v0() - dvector![-0.105_278, -0.198_472]).amax() < 5e-7,
        "{}",
        orbit.v0()
    );
    let stability = orbit.stability().expect("converges");
    let radii: Vec<f64> = stability
        .orders
        .iter()
        .map(vibroimpact::OrderMultipliers::spectral_radius)
        .collect();
    assert!(
        (radii[0] - 0.79341).abs() < 5e-6 && (radii[1] - 0.79333).abs() < 5e-6,
        "{radii:?}"
    );
    assert_eq!(stability.is_stable, Some(true));
}

#[test]
fn first_kind_loses_one_order_then_both_as_the_damping_grows() {
    for (damping, expected) in [(0.07, [1.775, 0.753]), (0.1, [3.42, 2.14])] {
        let orbits = first_kind(damping);
        let stability = orbits[0].stability().expect("converges");
        for (order, radius) in stability.orders.iter().zip(expected) {
            assert!(
                (order.spectral_radius() / radius - 1.0).abs() < 2e-3,
                "{damping}: {}",
                order.spectral_radius()
            );
        }
        assert_eq!(stability.is_stable, Some(false));
    }
}

#[test]
fn the_default_scene_of_the_first_kind_has_its_orbit() {
    let scene = paper_scene(Kind::One, &PaperOptions::default()).expect("valid");
    let orbits = periodic_orbits(
        &scene,
        &Pattern::together(&[0, 1]).expect("valid"),
        &periods(3),
    )
    .expect("solved");
    println!("{:.17}", first_kind(0.05)[0].q0()[0]);
    assert_eq!(
        orbits.verdict(),
        Verdict::Found,
        "{} {:?}",
        orbits.reason(),
        orbits.margin()
    );
    assert!(orbits[0].is_admissible() == Some(true));
}

/// Admissible range of phases with the phase given, on a grid of one degree.
fn admissible_phases(which: Kind, damping: f64, stop: usize) -> Vec<(f64, f64, Option<bool>)> {
    (0..360)
        .filter_map(|degree| {
            let options = OrbitOptions {
                phase: Some(f64::from(degree).to_radians()),
                ..periods(2)
            };
            let orbits = periodic_orbits(&kind(which, damping), &Pattern::single(stop), &options)
                .expect("solved");
            let theta0 = orbits[0].q0()[stop];
            // The other stop is at the same angle in the paper: judge the orbit with both there.
            let scene = orbits[0]
                .scene()
                .replace(Parameter::CLEARANCE.change(theta0))
                .expect("valid");
            let again = periodic_orbits(&scene, &Pattern::single(stop), &options).expect("solved");
            (again[0].is_admissible() == Some(true)).then(|| {
                (
                    f64::from(degree),
                    theta0,
                    again[0].stability().expect("converges").is_stable,
                )
            })
        })
        .collect()
}

#[test]
fn second_kind_is_admissible_for_light_damping_only() {
    let found = admissible_phases(Kind::Two, 0.01, 0);
    let (first, last) = (found[0], found[found.len() - 1]);
    assert_eq!((first.0, last.0), (12.0, 24.0));
    assert!(
        (first.1.min(last.1) - 0.354).abs() < 1e-3 && (first.1.max(last.1) - 0.712).abs() < 1e-3
    );
    assert!(found.iter().all(|f| f.2 == Some(true)));
    assert!(admissible_phases(Kind::Two, 0.015, 0).is_empty());
}

#[test]
fn third_kind_is_admissible_on_a_wide_range() {
    let found = admissible_phases(Kind::Three, 0.05, 1);
    let (first, last) = (found[0], found[found.len() - 1]);
    assert_eq!((first.0, last.0), (94.0, 189.0));
    let angles: Vec<f64> = found.iter().map(|f| f.1).collect();
    let (low, high) = (
        angles.iter().copied().fold(1.0, f64::min),
        angles.iter().copied().fold(0.0, f64::max),
    );
    assert!(
        (low - 0.111).abs() < 1e-3 && (high - 0.178).abs() < 1e-3,
        "{low} {high}"
    );
    let stable = found.iter().filter(|f| f.2 == Some(true)).count();
    assert!(
        (0.3..0.7).contains(&(stable as f64 / found.len() as f64)),
        "{stable} of {}",
        found.len()
    );
}

#[test]
fn coefficients_are_the_corrected_closed_form() {
    for (degrees, zeta) in [(0.0, 0.05), (73.0f64, 0.05), (200.0, 0.01), (311.0, 0.2)] {
        let options = OrbitOptions {
            phase: Some(degrees.to_radians()),
            ..periods(3)
        };
        let scene = kind(Kind::One, zeta);
        let orbits = periodic_orbits(
            &scene,
            &Pattern::together(&[0, 1]).expect("valid"),
            &options,
        )
        .expect("solved");
        let c = orbits[0].coefficients().expect("real modes");
        let system = paper_system(3.0, 3.24, zeta).expect("valid");
        let modes = modes(&system).expect("converges");
        for j in 0..2 {
            let w = modes.natural_frequencies[j];
            let eta = modes.damping_ratios[j] * w;
            let (a, b) =
                first_kind_coefficients(eta, (w * w - eta * eta).sqrt(), c.sine[j], 1.5, 0.9, 3);
            assert!(
                (c.a[j] - a).abs() < 1e-13 && (c.b[j] - b).abs() < 1e-13,
                "{} {a} {} {b}",
                c.a[j],
                c.b[j]
            );
        }
    }
}

#[test]
fn an_orbit_closes_and_its_coefficients_draw_it() {
    let orbits = periodic_orbits(&kind(Kind::Three, 0.05), &Pattern::single(1), &periods(2))
        .expect("solved");
    let orbit = &orbits[0];
    let modes = modes(&paper_system(1.0, 3.2, 0.05).expect("valid")).expect("converges");
    let c = orbit.coefficients().expect("real modes");
    for i in 0..20 {
        let t = orbit.period() * f64::from(i) / 20.0;
        let (q, _) = orbit.state(t, ImpactSide::After).expect("a time");
        let y = DVector::from_fn(2, |j, _| {
            let w = modes.natural_frequencies[j];
            let eta = modes.damping_ratios[j] * w;
            let wd = (w * w - eta * eta).sqrt();
            (-eta * t).exp() * (c.a[j] * (wd * t).cos() + c.b[j] * (wd * t).sin())
                + c.sine[j] * (1.5 * t).sin()
                + c.cosine[j] * (1.5 * t).cos()
        });
        assert!((modes.shapes.map(|z| z.re) * y - &q).amax() < 1e-13);
        let (shifted, _) = orbit
            .state(t - 3.0 * orbit.period(), ImpactSide::After)
            .expect("a time");
        assert!((shifted - q).amax() < 1e-12);
    }
    let ((q, before), v) = (
        orbit.state(0.0, ImpactSide::Before).expect("a time"),
        orbit.v0(),
    );
    assert!((q[1] - 0.15).abs() < 1e-13 && (v[1] + 0.9 * before[1]).abs() < 1e-13);
    assert!((orbit.impacts()[0].approach - before[1]).abs() < 1e-13);
}

#[test]
fn without_impacts_the_steady_response_is_the_orbit() {
    // F/(k - w^2 + i c w) for one degree of freedom, no stop reached.
    let orbits = periodic_orbits(
        &scene(
            unit_mass(0.3, 4.0),
            harmonic(&[0.8], 1.5, 0.0),
            [upper(0, 5.0, 0.7)],
        ),
        &Pattern::none(),
        &periods(1),
    )
    .expect("solved");
    assert_eq!((orbits.len(), orbits.verdict()), (1, Verdict::Found));
    assert!(
        orbits[0].is_admissible() == Some(true)
            && orbits[0].stability().expect("converges").is_stable == Some(true)
    );
    let response = nalgebra::Complex::new(4.0 - 2.25, 0.3 * 1.5).inv() * 0.8;
    assert!((orbits[0].q0()[0] - response.re).abs() < 1e-15);
    assert!((orbits[0].v0()[0] + 1.5 * response.im).abs() < 1e-15);
}

#[test]
fn a_ball_on_a_shaken_table_has_its_closed_form() {
    // The gap to the table is -q: gravity pushes q up to the stop at 0. Base a cos(w t + phase) seen from the table:
    // force on q is -a w^2 cos(w t + phase). theory 5: v+ = e g T/(1+e); the sine law, with the table's own phase.
    let (g, a, w, e) = (9.81, 0.02, 60.0, 0.7);
    for n in [1, 2] {
        let orbits = periodic_orbits(
            &scene(
                loaded(unit_mass(0.0, 0.0), &[g]),
                harmonic(&[a * w * w], w, 0.0),
                [upper(0, 0.0, e)],
            ),
            &Pattern::single(0),
            &periods(n),
        )
        .expect("solved");
        assert_eq!(orbits.verdict(), Verdict::Found);
        assert_eq!(orbits.len(), 2, "{}", orbits.reason());
        let period = TAU * n as f64 / w;
        let speed = e * g * period / (1.0 + e);
        for orbit in orbits.iter() {
            // force a w^2 cos(w t + phase): -v T + g T^2/2 - a w T sin(phase) = 0 over whole periods
            let sine = (g * period / 2.0 - speed) / (a * w);
            assert!(
                (orbit.v0()[0] + speed).abs() < 1e-11,
                "{} {speed}",
                orbit.v0()[0]
            );
            assert!(
                (orbit.phase().sin() - sine).abs() < 1e-11,
                "{} {sine}",
                orbit.phase().sin()
            );
        }
    }
}

#[test]
fn the_fold_of_the_single_impact_orbit_is_where_it_should_be() {
    // Shaw and Holmes (1983): alpha of the orbit grows with the forcing, so the fold lies at one amplitude exactly.
    let at = |force: f64| {
        periodic_orbits(
            &oscillator(0.1, harmonic(&[force], 2.8, 0.0), [upper(0, 1.0, 0.8)]),
            &Pattern::single(0),
            &periods(2),
        )
        .expect("solved")
    };
    let limit = 1.0 / (1.0 - at(1.0).margin().expect("a phase search")); // |d|/|alpha| at force 1, d = 1
    let fold = 1.0 / limit;
    assert_eq!(at(fold * (1.0 - 1e-12)).len(), 0);
    assert_eq!(at(fold * (1.0 + 1e-12)).len(), 2);
    assert_eq!(at(fold * 2.0).len(), 2);
}

#[test]
fn undamped_elastic_impacts_leave_a_family_at_two_phases_only() {
    let scene = |reaction: &Reaction| {
        let system = paper_system(3.0, 3.24, 0.0).expect("valid");
        let stop = |i: usize| {
            Stop::new(i, 0.3, 1.0)
                .and_then(|s| s.with_reaction(reaction.clone()))
                .expect("valid")
        };
        scene(
            system,
            BaseMotion::new(0.072, 1.5, 0.0).expect("valid"),
            [stop(0), stop(1)],
        )
    };
    for reaction in [Reaction::Coordinate, Reaction::Inertia] {
        for (stops, dimension) in [(vec![0, 1], 2), (vec![0], 1), (vec![1], 1)] {
            for (phase, family) in [(0.0, true), (PI, true), (1.0, false)] {
                let pattern = Pattern::together(&stops).expect("valid");
                let options = OrbitOptions {
                    phase: Some(phase),
                    ..periods(3)
                };
                let orbits =
                    periodic_orbits(&scene(&reaction), &pattern, &options).expect("solved");
                if family {
                    assert_eq!(
                        orbits.verdict(),
                        Verdict::Family,
                        "{stops:?} {phase} {}",
                        orbits.reason()
                    );
                    assert_eq!(orbits.family().expect("given").basis.ncols(), dimension);
                } else {
                    assert_eq!(orbits.verdict(), Verdict::None, "{stops:?} {phase}");
                }
            }
        }
    }
}

#[test]
fn resonance_without_damping_has_no_steady_response_but_an_impact_orbit() {
    let scene = scene(
        unit_mass(0.0, 4.0),
        harmonic(&[0.3], 2.0, 0.0),
        [upper(0, 0.5, 0.7)],
    );
    assert_eq!(
        periodic_orbits(&scene, &Pattern::none(), &periods(1))
            .expect("solved")
            .verdict(),
        Verdict::None
    );
    let orbits = periodic_orbits(&scene, &Pattern::single(0), &periods(1)).expect("solved");
    // Energy gained in a period at resonance is lost at the impact; the orbit must close under exact flights.
    for orbit in orbits.iter() {
        let (q, v) = orbit
            .state(orbit.period(), ImpactSide::Before)
            .expect("a time");
        assert!((q[0] - 0.5).abs() < 1e-12);
        assert!((orbit.v0()[0] + 0.7 * v[0]).abs() < 1e-12);
        // over one period of resonance the free motion repeats and the forcing adds (f T/(2 w)) (sin, w cos ...)
        let gained = 0.3 * PI / 2.0;
        let (dq, dv) = (q[0] - orbit.q0()[0], v[0] - orbit.v0()[0]);
        assert!(dq.abs() < 1e-12 && (dv.abs() - gained * orbit.phase().cos().abs()).abs() < 1e-12);
    }
    assert!(!orbits.is_empty());
}

#[test]
fn wrong_questions_are_refused_by_name() {
    let scene = kind(Kind::Three, 0.05);
    let message = |pattern: &Pattern, options: &OrbitOptions| {
        periodic_orbits(&scene, pattern, options)
            .expect_err("refused")
            .to_string()
    };
    assert!(message(&Pattern::single(2), &periods(1)).starts_with("pattern[0]"));
    assert!(message(&Pattern::single(1), &periods(0)).starts_with("n_periods"));
    let free = OrbitOptions {
        free: Some(FreeParameter::Clearance),
        ..periods(1)
    };
    assert!(message(&Pattern::single(1), &free).starts_with("free"));
    assert!(Pattern::new(vec![vec![]]).is_err() && Pattern::together(&[1, 1]).is_err());
}

#[test]
fn a_contact_left_at_zero_speed_is_no_graze_of_its_own() {
    // Without restitution the gap begins at zero with zero slope and opens by its curvature; the multipliers are the limit
    // of those for small restitution.
    let largest = |frequency: f64, restitution: f64| {
        let scene = kind(Kind::Three, 0.05)
            .replace(Parameter::Frequency.change(frequency))
            .and_then(|scene| scene.replace(Parameter::RESTITUTION.change(restitution)))
            .expect("valid");
        let orbits = periodic_orbits(&scene, &Pattern::single(1), &periods(2)).expect("solved");
        assert!(orbits[0].is_admissible() == Some(true) && orbits[0].touches().is_empty());
        orbits[0].stability().expect("computed").orders[0].spectral_radius()
    };
    for i in 0..=40 {
        let frequency = 1.7 + 0.01 * f64::from(i);
        let difference = largest(frequency, 0.0) - largest(frequency, 1e-9);
        assert!(
            difference.abs() < 1e-6,
            "frequency {frequency}: {difference}"
        );
    }
}

/// Masses in a row on springs, nothing but their weight holding them, with a damper between the first and the ground.
fn free_row(random: &mut Random, has_weight: bool) -> (Scene, f64) {
    let n = 1 + random.below(4);
    let mut stiffness = DMatrix::zeros(n, n);
    for i in 1..n {
        let k = random.between(0.5, 3.0);
        for (a, b) in [(i, i - 1), (i - 1, i)] {
            stiffness[(a, a)] += k;
            stiffness[(a, b)] -= k;
        }
    }
    let mut damping = &stiffness * random.between(0.0, 0.05);
    damping[(0, 0)] += random.between(0.05, 0.5);
    let masses = DVector::from_fn(n, |_, _| random.between(0.5, 2.0));
    let weight = if has_weight { 1.0 } else { 0.0 };
    let total = weight * masses.sum();
    let system = LinearSystem::new(masses.clone(), damping, stiffness).expect("valid");
    let system = system.with_load(&masses * -weight).expect("valid");
    let force = (random.vector(n) * random.log(3.0, 60.0)).map(Complex::from);
    let force = Harmonic::new(force, random.between(0.5, 4.0), 0.0).expect("valid");
    let stop = Stop::new(
        random.below(n),
        random.between(-0.2, 0.3),
        random.between(0.0, 1.0),
    );
    let stop = stop.expect("valid").on_side(Side::Lower);
    (Scene::new(system, force, [stop]).expect("valid"), total)
}

#[test]
fn structures_that_nothing_holds_bounce_by_their_weight_alone() {
    let mut seen = [0; 2];
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let has_weight = seed % 2 == 0;
        let (scene, weight) = free_row(&mut random, has_weight);
        let n_periods = 1 + random.below(2);
        let found =
            periodic_orbits(&scene, &Pattern::single(0), &periods(n_periods)).expect("a search");
        for orbit in found.iter() {
            let label = format!("{seed}, {n_periods} periods");
            seen[usize::from(has_weight)] += 1;
            // No field raises, none is not a number but the depth of what is not known.
            let stability = orbit
                .stability()
                .unwrap_or_else(|error| panic!("{label}: {error}"));
            for order in &stability.orders {
                assert!(
                    order.multipliers.iter().all(|mu| mu.re.is_finite()),
                    "{label}"
                );
            }
            assert!(
                orbit.energy().is_ok() && orbit.segments().is_ok(),
                "{label}"
            );
            let impact = orbit.impacts()[0];
            assert!(impact.approach.is_finite() && impact.impulse.is_finite());
            // The mean of what the stop gives is the weight, and none where there is none.
            let off = (impact.impulse / orbit.period() - weight).abs();
            assert!(off < 1e-8 * weight.max(1.0), "{label}: {off:e}");
            if !has_weight {
                assert_eq!(orbit.is_admissible(), Some(false), "{label}");
                let why = orbit.violation().map(|own| own.reason.clone());
                assert!(why.is_some_and(|own| !own.is_empty()), "{label}");
            }
            // It comes back to its beginning in a flight of its own.
            let bare = orbit
                .scene()
                .replace(Change::Stops(Vec::new()))
                .expect("valid");
            let (q, v) = (orbit.q0(), orbit.v0());
            let run = simulate(
                &bare,
                &q,
                &v,
                (0.0, orbit.period()),
                &SimulateOptions::default(),
            );
            let (end, _) = run
                .expect("a run")
                .state(orbit.period(), ImpactSide::Before)
                .expect("its end");
            let size = orbit
                .max_displacement()
                .expect("sought")
                .iter()
                .fold(0.0f64, |m, x| m.max(*x));
            assert!((end - &q).amax() < 1e-9 * size, "{label}");
        }
    }
    assert!(seen.iter().all(|count| *count > 10), "{seen:?}");
}
