//! Every stable admissible orbit that `periodic_orbits` finds is retraced by `simulate` for a thousand periods. Random scenes
//! of one to three degrees of freedom.

use crate::random::{Cases, Random};
use crate::scenes::{harmonic, linear, scene, upper};
use nalgebra::{DMatrix, dvector};
use std::f64::consts::TAU;
use vibroimpact::{
    FreeParameter, Harmonic, ImpactSide, Keep, LinearSystem, Method, Motion, OrbitOptions, Pattern,
    PeriodicOrbit, Reaction, Side, SimulateOptions, Status, Stop, Verdict, periodic_orbits,
    simulate,
};

const PERIODS: usize = 1000;
/// Drift of a time or a velocity that is too much, in scenes whose periods and speeds are of order one.
const DRIFT: f64 = 1e-9;
/// Multipliers below this modulus are clearly inside the unit circle.
const CLEARLY_STABLE: f64 = 0.97;

fn is_clearly_stable(orbit: &PeriodicOrbit) -> bool {
    let stability = orbit.stability().expect("converges");
    stability.is_stable == Some(true)
        && stability
            .orders
            .iter()
            .all(|order| order.spectral_radius() < CLEARLY_STABLE)
}

/// The largest difference between a thousand simulated periods and the orbit: impact times, speeds, the state at the end.
fn drift(orbit: &PeriodicOrbit, label: &str) -> f64 {
    let options = SimulateOptions {
        solver: Method::Exact.into(),
        keep: Keep::Impacts,
        ..Default::default()
    };
    let (period, expected) = (orbit.period(), orbit.impacts());
    // In the middle of a flight, so that no impact falls on the end.
    let first_flight = expected
        .iter()
        .map(|impact| impact.time)
        .find(|&time| time > 0.0)
        .unwrap_or(period);
    let end = PERIODS as f64 * period + 0.5 * first_flight;
    let run = simulate(
        orbit.scene(),
        &orbit.q0(),
        &orbit.v0(),
        (0.0, end),
        &options,
    )
    .expect("an orbit's scene and start are valid");
    assert_eq!(run.status(), Status::Finished, "{label}: {}", run.message());
    assert_eq!(run.impacts().len(), PERIODS * expected.len(), "{label}");
    // The first impact of the run is that of the second instant; those of the first instant come round last.
    let at_start = expected.iter().filter(|impact| impact.time == 0.0).count();
    let mut worst = 0.0f64;
    for (cycle, impacts) in run.impacts().chunks(expected.len()).enumerate() {
        let mut cycle_expected: Vec<_> = expected[at_start..].to_vec();
        cycle_expected.extend(
            expected[..at_start]
                .iter()
                .map(|impact| vibroimpact::Impact {
                    time: period,
                    ..*impact
                }),
        );
        for wanted in cycle_expected {
            // Stops hit together come in either order: that of rounding.
            let found = impacts
                .iter()
                .filter(|impact| impact.stop == wanted.stop)
                .map(|impact| {
                    let late = impact.time - cycle as f64 * period - wanted.time;
                    late.abs()
                        .max((impact.approach - wanted.approach).abs())
                        .max((impact.departure - wanted.departure).abs())
                })
                .fold(f64::INFINITY, f64::min);
            worst = worst.max(found);
        }
    }
    let (q, v) = orbit
        .state(0.5 * first_flight, ImpactSide::After)
        .expect("a time");
    worst
        .max((run.last().0 - q).amax())
        .max((run.last().1 - v).amax())
}

/// Mass, damping and stiffness of order one, the damping proportional or not.
fn random_system(random: &mut Random, n: usize) -> LinearSystem {
    let identity = DMatrix::identity(n, n);
    let (a, b, c) = (random.matrix(n), random.matrix(n), random.matrix(n));
    let mass = &identity + &a * a.transpose() * 0.3;
    let stiffness =
        &identity * random.between(0.2, 2.0) + &b * b.transpose() * random.between(0.5, 4.0);
    let damping = if random.unit() < 0.5 {
        &mass * random.between(0.0, 0.1) + &stiffness * random.between(0.01, 0.2)
    } else {
        &c * c.transpose() * 0.2 + &identity * 0.05
    };
    let load = random.vector(n) * 0.1;
    LinearSystem::new(mass, damping, stiffness)
        .and_then(|system| system.with_load(load))
        .expect("positive definite")
}

fn random_forcing(random: &mut Random, n: usize) -> Harmonic {
    let amplitude = random.vector(n).map(Into::into);
    Harmonic::new(amplitude, random.between(0.5, 3.0), 0.0).expect("finite")
}

fn random_restitution(random: &mut Random) -> f64 {
    random.between(0.3, 0.95)
}

/// What a pattern asks of a scene.
#[derive(Debug, Clone, Copy)]
enum Kind {
    /// `[0]`: the clearance given.
    Once,
    /// `[0, 1]` at one instant: the paper's first kind, in any system of two coordinates or more.
    Together,
    /// `[0], [0]`.
    Twice,
    /// `[0], [1]`, the stops on opposite sides.
    BothSides,
}

impl Kind {
    fn pattern(self) -> Pattern {
        Pattern::new(match self {
            Self::Once => vec![vec![0]],
            Self::Together => vec![vec![0, 1]],
            Self::Twice => vec![vec![0], vec![0]],
            Self::BothSides => vec![vec![0], vec![1]],
        })
        .expect("valid")
    }

    /// The stops; those hit together are on two coordinates, each reset alone, so that the order does not matter.
    fn stops(self, random: &mut Random, n: usize) -> Vec<Stop> {
        let normal = random.vector(n);
        let e = random_restitution(random);
        match self {
            Self::Once | Self::Twice => vec![upper(normal, random.between(-0.1, 0.6), e)],
            Self::BothSides => {
                let lower = upper(normal.clone(), random.between(0.1, 0.6), e).on_side(Side::Lower);
                vec![upper(normal, random.between(0.1, 0.6), e), lower]
            }
            Self::Together => [0, 1]
                .map(|coordinate| {
                    Stop::new(
                        coordinate,
                        random.between(0.1, 0.6),
                        random_restitution(random),
                    )
                    .and_then(|s| s.with_reaction(Reaction::Coordinate))
                    .expect("valid")
                })
                .to_vec(),
        }
    }

    fn options(self, n_periods: usize) -> OrbitOptions {
        OrbitOptions {
            n_periods,
            free: matches!(self, Self::Together).then_some(FreeParameter::Clearance),
            ..Default::default()
        }
    }
}

/// Retraces the clearly stable, admissible orbits of one kind.
fn retrace(kind: Kind) {
    let cases = cases();
    let (mut retraced, mut worst) = (0, 0.0f64);
    for (case, mut random) in cases.each() {
        let least = if matches!(kind, Kind::Together) { 2 } else { 1 };
        let n = least + random.below(4 - least);
        let system = random_system(&mut random, n);
        let forcing = random_forcing(&mut random, n);
        let scene = scene(system, forcing, kind.stops(&mut random, n));
        let n_periods = 1 + random.below(3);
        let orbits =
            periodic_orbits(&scene, &kind.pattern(), &kind.options(n_periods)).expect("solved");
        for orbit in orbits
            .iter()
            .filter(|orbit| orbit.is_admissible() == Some(true) && is_clearly_stable(orbit))
        {
            let label = format!("{kind:?}, scene {case}, n = {n}, n_periods = {n_periods}");
            let drift = drift(orbit, &label);
            assert!(drift < DRIFT, "{label}: drift {drift:e}");
            worst = worst.max(drift);
            retraced += 1;
        }
    }
    println!("{kind:?}: {retraced} orbits, largest drift {worst:e}");
    assert!(cases.is_one() || retraced > 0);
}

fn cases() -> Cases {
    Cases::new(0x5EED, 400)
}

#[test]
fn orbits_of_one_stop_hit_once() {
    retrace(Kind::Once);
}

#[test]
fn orbits_of_two_stops_hit_together() {
    retrace(Kind::Together);
}

#[test]
fn orbits_of_one_stop_hit_twice() {
    retrace(Kind::Twice);
}

#[test]
fn orbits_between_two_stops() {
    retrace(Kind::BothSides);
}

/// A self-excited oscillator (negative damping) whose impacts take away what the damping feeds: `I - R e^(AT)` is singular
/// and each clearance has its own member of one family, all with the same multipliers.
#[test]
fn members_of_a_family() {
    let cases = cases();
    let (mut retraced, mut worst) = (0, 0.0f64);
    for (case, mut random) in cases.each() {
        let (eta, w) = (-random.between(0.01, 0.3), random.between(1.0, 3.0));
        let n_periods = 1 + random.below(2);
        let t = TAU * n_periods as f64 / w;
        // det(I - R e^(AT)) = 1 - Cp + e (Cm - e^(-2 eta T)) = 0
        let (damped, decay) = ((1.0 - eta * eta).sqrt(), (-eta * t).exp());
        let (s, c) = (damped * t).sin_cos();
        let (s, c) = (decay * s / damped, decay * c);
        let restitution = (c + eta * s - 1.0) / (c - eta * s - decay * decay);
        if !(0.05..0.95).contains(&restitution) {
            continue;
        }
        let system = linear(dvector![1.0], dvector![2.0 * eta], dvector![1.0]);
        // The only phases with orbits: the steady velocity is zero at the impact.
        let phase = (2.0 * eta * w).atan2(1.0 - w * w);
        let scene = |clearance: f64| {
            scene(
                system.clone(),
                harmonic(&[1.0], w, phase),
                [upper(0, clearance, restitution)],
            )
        };
        let label = format!("case {case}, eta = {eta}, w = {w}, n_periods = {n_periods}");
        let given = OrbitOptions {
            phase: Some(phase),
            ..Kind::Once.options(n_periods)
        };
        let family = periodic_orbits(&scene(1.0), &Kind::Once.pattern(), &given).expect("solved");
        assert_eq!(family.verdict(), Verdict::Family, "{label}");
        let basis = family.family().expect("a family").basis.clone();
        assert_eq!(basis.ncols(), 1, "{label}");
        for clearance in [0.5, 1.0, 2.0] {
            let members = periodic_orbits(
                &scene(clearance),
                &Kind::Once.pattern(),
                &Kind::Once.options(n_periods),
            )
            .expect("solved");
            for orbit in members
                .iter()
                .filter(|orbit| orbit.is_admissible() == Some(true) && is_clearly_stable(orbit))
            {
                let off_phase = (orbit.phase() - phase).sin().abs();
                assert!(off_phase < 1e-9, "{label}: phase off by {off_phase:e}");
                if (orbit.phase() - phase).cos() > 0.0 {
                    let away = [0, 1].map(|i| {
                        let state = |o: &PeriodicOrbit| if i == 0 { o.q0()[0] } else { o.v0()[0] };
                        state(orbit) - state(&family[0])
                    });
                    let off = (away[0] * basis[(1, 0)] - away[1] * basis[(0, 0)]).abs();
                    assert!(
                        off < 1e-9 * basis.norm(),
                        "{label}: off the family by {off:e}"
                    );
                }
                let drift = drift(orbit, &label);
                assert!(drift < DRIFT, "{label}: drift {drift:e}");
                worst = worst.max(drift);
                retraced += 1;
            }
        }
    }
    println!("members of families: {retraced}, largest drift {worst:e}");
    assert!(cases.is_one() || retraced > 0);
}
