//! Motions that are their own mirror images, and where they cease to be stable as such: two stops, against closed forms (theory 19).

use crate::random::Random;
use crate::scenes::followed;
use std::f64::consts::PI;
use vibroimpact::nalgebra::{DMatrix, dmatrix, dvector};
use vibroimpact::{
    Branch, ContinuationOptions, EndReason, EquationsOfMotion, Harmonic, ImpactSide, LinearSystem,
    Motion, NonlinearSystem, OrbitOptions, Parameter, Pattern, PeriodicOrbit, Result, Scene, Side,
    SimulateOptions, Special, SpecialKind, Stop, Virtual, branches, find_orbit, periodic_orbits,
    simulate,
};

/// `x'' + 2 eta x' + x = F cos w t` between stops at d and -d.
#[derive(Debug, Clone, Copy)]
struct Between {
    eta: f64,
    frequency: f64,
    clearance: f64,
    restitution: f64,
}

impl Between {
    fn scene(self) -> Scene {
        let system = LinearSystem::new(dvector![1.0], dmatrix![2.0 * self.eta], dmatrix![1.0]);
        let force = Harmonic::new(dvector![1.0.into()], self.frequency, 0.0);
        let stop = |side| {
            let stop = Stop::new(0, self.clearance, self.restitution).expect("valid");
            stop.on_side(side)
        };
        let stops = [stop(Side::Upper), stop(Side::Lower)];
        Scene::new(system.expect("valid"), force.expect("valid"), stops).expect("valid")
    }

    /// Its motions of one impact on each stop in a period, that are their own mirror images.
    fn orbits(self) -> Vec<PeriodicOrbit> {
        let pattern = Pattern::new(vec![vec![0], vec![1]]).expect("valid");
        let found = periodic_orbits(&self.scene(), &pattern, &OrbitOptions::default());
        let own = found.expect("a search").into_iter();
        own.filter(|orbit| {
            let impacts = orbit.impacts();
            (impacts[0].approach / impacts[1].approach - 1.0).abs() < 1e-9
        })
        .collect()
    }

    /// `1 + tr H + det H` of half a period at an impact of some speed: zero where a multiplier of the half map is -1.
    fn breaking(self, speed: f64) -> f64 {
        let Self {
            eta,
            frequency: w,
            clearance: d,
            restitution: e,
        } = self;
        let h = PI / w;
        let own = (1.0 - eta * eta).sqrt();
        let (decay, angle) = ((-eta * h).exp(), own * h);
        let s = decay * angle.sin() / own;
        let [plus, minus] =
            [1.0, -1.0].map(|sign| decay * (angle.cos() + sign * eta * angle.sin() / own));
        let end = (-2.0 * eta * h).exp();
        let all = 1.0 + plus + minus + end;
        let a = (1.0 + e) * s / all;
        let b = 1.0 - (1.0 + e) * (minus + end) / all;
        let trace = e * (plus + minus)
            - (1.0 + e) * s * (2.0 * eta * b - (1.0 - w * w) * a - w * w * d / speed);
        1.0 + trace + e * e * end
    }
}

fn pitchforks(branch: &Branch) -> Vec<&Special> {
    let own = branch.special.iter();
    own.filter(|own| own.kind == SpecialKind::Pitchfork)
        .collect()
}

fn keep() -> ContinuationOptions {
    ContinuationOptions {
        beyond: Virtual::Keep,
        ..Default::default()
    }
}

#[test]
fn symmetry_breaks_where_the_half_map_says() {
    let own = Between {
        eta: 0.0,
        frequency: 1.2,
        clearance: 0.5,
        restitution: 0.7,
    };
    let orbit = &own.orbits()[0];
    let branch = followed(orbit, Parameter::Frequency, (0.9, 1.8), &keep());
    let found: Vec<f64> = pitchforks(&branch)
        .iter()
        .map(|own| own.parameter)
        .collect();
    for known in [1.034_484_452_715, 1.530_515_078_983] {
        assert!(
            found.iter().any(|own| (own - known).abs() < 1e-11),
            "{found:?}"
        );
    }
    // All of its orbits are their own mirror images, to rounding.
    for orbit in &branch.orbits {
        let (q, v) = orbit.state(0.1, ImpactSide::After).expect("a time");
        let (p, u) = orbit
            .state(0.1 + 0.5 * orbit.period(), ImpactSide::After)
            .expect("a time");
        assert!((q + p).amax() < 1e-12 && (v + u).amax() < 1e-12);
    }
}

/// A simulation does what an orbit says.
fn check_motion(orbit: &PeriodicOrbit) {
    let end = 1.3 * orbit.period();
    let options = SimulateOptions::default();
    let run = simulate(
        orbit.scene(),
        &orbit.q0(),
        &orbit.v0(),
        (0.0, end),
        &options,
    );
    let run = run.expect("a run");
    let (q, v) = run.last();
    let (p, u) = orbit.state(end, ImpactSide::After).expect("a time");
    assert!((q - p).amax() < 1e-8 && (v - u).amax() < 1e-8);
}

#[test]
fn motions_that_are_no_mirror_images_are_born_at_pitchforks() {
    let (mut seen, mut retraced) = (0, 0);
    for case in 0..60 {
        let random = &mut Random::of_case(81, case);
        let own = Between {
            eta: random.between(0.01, 0.2),
            frequency: random.between(0.7, 2.5),
            clearance: random.between(0.05, 0.8),
            restitution: random.between(0.3, 0.9),
        };
        for orbit in own.orbits() {
            let range = (0.5, 3.0);
            let branch = followed(&orbit, Parameter::Frequency, range, &keep());
            for pitchfork in pitchforks(&branch) {
                let there = Between {
                    frequency: pitchfork.parameter,
                    ..own
                };
                let speed = pitchfork.orbit.impacts()[0].approach;
                assert!(
                    there.breaking(speed).abs() < 1e-7,
                    "{}",
                    there.breaking(speed)
                );
                assert!(pitchfork.error < 1e-9);
                let born = branches(pitchfork, Parameter::Frequency, range).expect("branches");
                let [born] = born.as_slice() else {
                    panic!("{case}: {}", born.len());
                };
                let image = born.orbit.mirrored().expect("an image");
                let speeds = |orbit: &PeriodicOrbit| {
                    [0, 1].map(|k: usize| {
                        let own = orbit.impacts().iter().find(|impact| impact.stop == k);
                        own.expect("one").approach
                    })
                };
                let (one, other) = (speeds(&born.orbit), speeds(&image));
                assert!((one[0] / one[1] - 1.0).abs() > 1e-6);
                assert!(
                    (one[0] / other[1] - 1.0).abs() < 1e-12
                        && (one[1] / other[0] - 1.0).abs() < 1e-12
                );
                assert_eq!(image.is_admissible(), born.orbit.is_admissible());
                if image.is_admissible() == Some(true) {
                    check_motion(&image);
                    retraced += 1;
                }
                // One is stable where the symmetric one is not.
                let scene = image.scene();
                let other =
                    find_orbit(scene, &pitchfork.orbit, None).expect("the branch beside it");
                let radius = |orbit: &PeriodicOrbit| {
                    orbit.stability().expect("multipliers").orders[0].spectral_radius()
                };
                let rest_is_inside = radius(&pitchfork.orbit) < 1.0 + 1e-6;
                if rest_is_inside {
                    assert_eq!(radius(&born.orbit) < 1.0, radius(&other) > 1.0, "{case}");
                }
                seen += 1;
            }
        }
    }
    assert!(seen > 20 && retraced > 5, "{seen} {retraced}");
}

#[test]
fn where_a_scene_is_not_odd_nothing_is_kept_symmetric() {
    let own = Between {
        eta: 0.05,
        frequency: 1.2,
        clearance: 0.5,
        restitution: 0.7,
    };
    let orbit = &own.orbits()[0];
    let symmetric = ContinuationOptions {
        symmetric: Some(true),
        ..keep()
    };
    // One clearance alone.
    let range = (0.4, 0.6);
    let refused = vibroimpact::continuation(orbit, Parameter::CLEARANCE.of(1), range, &symmetric);
    assert!(refused.is_err_and(|error| error.to_string().contains("mirror image")));
    let branch = followed(orbit, Parameter::CLEARANCE.of(1), range, &keep());
    assert_eq!(branch.ends[0].reason, EndReason::Range);
    let speeds = |orbit: &PeriodicOrbit| [orbit.impacts()[0].approach, orbit.impacts()[1].approach];
    let last = speeds(&branch.orbits[0]);
    assert!((last[0] / last[1] - 1.0).abs() > 1e-3);
    assert!(branch.orbits[0].mirrored().is_err());
    // Both at once, without the symmetry: the same orbits, and crossings instead of pitchforks.
    let ignored = ContinuationOptions {
        symmetric: Some(false),
        ..keep()
    };
    let range = (0.9, 1.8);
    let [kept, free] =
        [symmetric, ignored].map(|options| followed(orbit, Parameter::Frequency, range, &options));
    let at = |branch: &Branch, kind| {
        let own = branch.special.iter().filter(|own| own.kind == kind);
        own.cloned().collect::<Vec<Special>>()
    };
    let (forks, crossings) = (
        at(&kept, SpecialKind::Pitchfork),
        at(&free, SpecialKind::BranchPoint),
    );
    assert!(!forks.is_empty() && forks.len() == crossings.len());
    for (fork, crossing) in forks.iter().zip(&crossings) {
        let off = (fork.parameter - crossing.parameter).abs();
        assert!(
            off < 1e-10 && crossing.error < 1e-10,
            "{off:e} {:e}",
            crossing.error
        );
    }
    let born = branches(&crossings[0], Parameter::Frequency, range).expect("branches");
    assert!(!born.is_empty());
    for own in &born {
        let [one, other] = speeds(&own.orbit);
        assert!((one / other - 1.0).abs() > 1e-6);
    }
}

#[test]
fn two_stops_touched_at_once_bear_motions_that_hit_both_and_one() {
    let own = Between {
        eta: 0.05,
        frequency: 1.4,
        clearance: 1.5,
        restitution: 0.7,
    };
    let found = periodic_orbits(&own.scene(), &Pattern::none(), &OrbitOptions::default());
    let rest = &found.expect("one")[0];
    let (parameter, range) = (Parameter::ForcingScale, (0.5, 3.0));
    let branch = followed(rest, parameter, range, &ContinuationOptions::default());
    let graze = branch
        .special
        .iter()
        .find(|own| own.kind == SpecialKind::Graze);
    let graze = graze.expect("a touch");
    // F = d |1 - w^2 + 2 i eta w|.
    let touch = 1.5 * (1.0f64 - 1.4 * 1.4).hypot(2.0 * 0.05 * 1.4);
    assert!((graze.parameter - touch).abs() < 1e-9);
    let born = branches(graze, parameter, range).expect("branches");
    let hits = |count: usize| {
        let own = born.iter().filter(|own| own.orbit.n_periods() == 1);
        own.filter(|own| own.orbit.impacts().len() == count)
            .collect::<Vec<_>>()
    };
    let [both] = hits(2)[..] else {
        panic!("{}", born.len());
    };
    let impacts = both.orbit.impacts();
    assert!(impacts[0].stop != impacts[1].stop);
    assert!((impacts[0].approach / impacts[1].approach - 1.0).abs() < 1e-9);
    let image = both.orbit.mirrored().expect("an image");
    assert!((image.impacts()[0].approach / impacts[0].approach - 1.0).abs() < 1e-9);
    let [one] = hits(1)[..] else {
        panic!("{}", born.len());
    };
    // Its mirror image hits the other stop.
    let image = one.orbit.mirrored().expect("an image");
    assert!(image.impacts()[0].stop != one.orbit.impacts()[0].stop);
}

#[test]
fn a_symmetric_motion_that_loses_both_impacts_leaves_the_one_without() {
    let own = Between {
        eta: 0.05,
        frequency: 0.9,
        clearance: 0.7,
        restitution: 0.85,
    };
    let scene = own
        .scene()
        .replace(Parameter::ForcingScale.change(1.2))
        .expect("valid");
    let pattern = Pattern::new(vec![vec![0], vec![1]]).expect("valid");
    let found = periodic_orbits(&scene, &pattern, &OrbitOptions::default());
    let orbit = found.expect("a search").into_iter();
    let orbit = orbit
        .into_iter()
        .find(|own| own.is_admissible() == Some(true));
    let (parameter, range) = (Parameter::ForcingScale, (0.05, 2.0));
    let branch = followed(
        &orbit.expect("one"),
        parameter,
        range,
        &ContinuationOptions::default(),
    );
    let lost = branch
        .special
        .iter()
        .find(|own| own.kind == SpecialKind::LostImpact);
    let born = branches(lost.expect("an end"), parameter, range).expect("branches");
    let rest = born.iter().find(|own| own.orbit.impacts().is_empty());
    let rest = rest.expect("the motion without impacts");
    assert!(rest.orbit.is_admissible() == Some(true) && !rest.is_above);
}

/// `x'' + 2 h x' + x + k max(0, x - d) = F cos w t`.
struct Sprung {
    h: f64,
    stiffness: f64,
    room: f64,
}

impl Sprung {
    /// By how much an orbit under a force of some amplitude and frequency misses its start in a period of classical Runge-Kutta steps.
    fn missed(&self, orbit: &PeriodicOrbit, (force, w): (f64, f64)) -> f64 {
        let (steps, period) = (40_000, orbit.period());
        let rate = |t: f64, [q, v]: [f64; 2]| {
            let press = self.stiffness * (q - self.room).max(0.0);
            let wave = force * (w * t + orbit.phase()).cos();
            [v, wave - 2.0 * self.h * v - q - press]
        };
        let start = [orbit.q0()[0], orbit.v0()[0]];
        let (mut x, dt) = (start, period / f64::from(steps));
        for k in 0..steps {
            let t = dt * f64::from(k);
            let ahead = |by: [f64; 2], part: f64| [x[0] + part * by[0], x[1] + part * by[1]];
            let a = rate(t, x);
            let b = rate(t + 0.5 * dt, ahead(a, 0.5 * dt));
            let c = rate(t + 0.5 * dt, ahead(b, 0.5 * dt));
            let d = rate(t + dt, ahead(c, dt));
            let mean = [0, 1].map(|i| (a[i] + 2.0 * (b[i] + c[i]) + d[i]) / 6.0);
            x = ahead(mean, dt);
        }
        (x[0] - start[0]).abs().max((x[1] - start[1]).abs())
    }
}

impl EquationsOfMotion for Sprung {
    fn n_dof(&self) -> usize {
        1
    }

    fn acceleration(&self, _: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        a[0] = -2.0 * self.h * v[0] - q[0] - self.stiffness * (q[0] - self.room).max(0.0);
        Ok(())
    }

    fn has_mass(&self) -> bool {
        true
    }

    fn mass(&self, _: &[f64]) -> Result<DMatrix<f64>> {
        Ok(dmatrix![1.0])
    }
}

#[test]
fn a_motion_that_reaches_a_spring_on_one_side_is_not_its_own_image_any_more() {
    let (h, w, room) = (0.05, 0.6, 1.0);
    // What the oscillator reaches alone.
    let reach = 1.0 / ((1.0f64 - w * w).powi(2) + (2.0 * h * w).powi(2)).sqrt();
    for stiffness in [0.5, 40.0] {
        let system = NonlinearSystem::new(Sprung { h, stiffness, room }).expect("valid");
        let force = Harmonic::new(dvector![(0.5 * room / reach).into()], w, 0.0).expect("valid");
        let scene = Scene::new(system, force, Vec::<Stop>::new()).expect("valid");
        let (q, v) = (dvector![0.0], dvector![0.0]);
        let run = simulate(&scene, &q, &v, (0.0, 2000.0), &SimulateOptions::default());
        let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
        // From below the force at the touch to beyond it.
        let branch = followed(&orbit, Parameter::ForcingScale, (0.9, 2.8), &keep());
        assert_eq!(
            branch.ends.clone().map(|end| end.reason),
            [EndReason::Range; 2],
            "{stiffness}"
        );
        assert!(pitchforks(&branch).is_empty(), "{stiffness}");
        for (k, (orbit, factor)) in branch.orbits.iter().zip(&branch.parameter).enumerate() {
            // The twin takes short steps, for its error at the spring: it looks at some of them.
            if k % 6 == 0 {
                let own = Sprung { h, stiffness, room };
                let off = own.missed(orbit, (0.5 * factor * room / reach, w));
                assert!(off < 1e-6, "{stiffness}, {factor}: {off:e}");
            }
            let [far, back] = [1.0, -1.0].map(|side| {
                let times = (0..400).map(|k| orbit.period() * f64::from(k) / 400.0);
                times
                    .map(|t| side * orbit.state(t, ImpactSide::After).expect("a time").0[0])
                    .fold(0.0, f64::max)
            });
            // A stiff spring folds the branch behind the touch: what reaches it tells what an orbit is, not the force.
            if far < room * (1.0 - 1e-3) {
                let alone = 0.5 * factor * room;
                assert!((far / alone - 1.0).abs() < 1e-3, "{stiffness}, {factor}");
                assert!((far / back - 1.0).abs() < 1e-3 && orbit.mirrored().is_ok());
            } else if far > room * (1.0 + 1e-3) {
                assert!((far / back - 1.0).abs() > 1e-6, "{stiffness}, {factor}");
                assert!(orbit.mirrored().is_err(), "{stiffness}, {factor}");
            }
        }
        let kept = ContinuationOptions {
            symmetric: Some(true),
            ..keep()
        };
        let kept = followed(&orbit, Parameter::ForcingScale, (0.9, 2.8), &kept);
        assert_eq!(
            kept.ends[1].reason,
            EndReason::Domain,
            "{stiffness} {:?}",
            kept.ends
        );
        let last = kept.parameter.last().expect("points");
        assert!((last - 2.0).abs() < 1e-3, "{stiffness}: {last}");
    }
}
