//! Contacts that nothing presses at first, or no longer: gaps that open by a high derivative, forces that begin from zero, forces
//! that are nothing but rounding. What follows is known in closed form.

use crate::scenes::{BOTH, linear, loaded, lower, scene, unit_mass, upper, with};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use std::f64::consts::{FRAC_PI_2, PI};
use vibroimpact::{
    Forcing, Harmonic, ImpactSide, Method, Motion, Reaction, Scene, SegmentKind, Side, Status,
    Stop, Trajectory, nalgebra, simulate,
};

fn run(
    scene: &Scene,
    (q0, v0): (DVector<f64>, DVector<f64>),
    span: (f64, f64),
    method: Method,
) -> Trajectory {
    let run = simulate(scene, &q0, &v0, span, &with(method, 1e-10)).expect("runs");
    assert_eq!(run.status(), Status::Finished, "{}", run.message());
    run
}

fn still(n: usize) -> (DVector<f64>, DVector<f64>) {
    (DVector::zeros(n), DVector::zeros(n))
}

/// Two unit masses side by side under the force `sin t` each, the second on a spring: apart they are at `t - sin t` and
/// `(sin t - t cos t)/2`, so that between them `t^5/120` opens.
fn side_by_side(side: Side) -> Scene {
    let system = linear(dvector![1.0, 1.0], dvector![0.0, 0.0], dvector![0.0, 1.0]);
    let push = nalgebra::Complex::new(0.0, -1.0);
    let forcing = Harmonic::new(dvector![push, push], 1.0, 0.0).expect("valid");
    let between = upper(dvector![1.0, -1.0], 0.0, 0.5).on_side(side);
    scene(system, forcing, [between])
}

#[test]
fn a_body_is_let_go_where_another_that_nothing_couples_to_it_is_struck() {
    // x'' + x = -0.9 sin 2t falls onto its stop where 0.6 sin 2t lets go of what rests on the other: at odd multiples of pi/2.
    let system = linear(dvector![1.0, 1.0], dvector![0.0, 0.0], dvector![1.0, 4.0]);
    let push = dvector![nalgebra::Complex::from(-0.9), nalgebra::Complex::from(0.6)];
    let forcing = Harmonic::new(push, 2.0, -FRAC_PI_2).expect("valid");
    let stops = [
        lower(dvector![1.0, 0.0], 0.0, 0.5),
        upper(dvector![0.0, 1.0], 0.0, 0.001),
    ];
    let scene = scene(system, forcing, stops);
    let run = run(&scene, still(2), (0.0, 30.0), Method::Exact);
    let instants: Vec<f64> = (1..10).map(|k| PI * f64::from(k) + FRAC_PI_2).collect();
    let struck: Vec<f64> = (run.impacts().iter())
        .filter(|impact| impact.stop == 0)
        .map(|impact| impact.time)
        .collect();
    let segments = run.segments().expect("kept");
    let released = segments
        .iter()
        .filter(|s| s.kind == SegmentKind::Stick && s.stop == Some(1) && s.start > 0.0);
    let released: Vec<f64> = released.map(|s| s.end).collect();
    for times in [struck, released] {
        let instants = &instants[..times.len()];
        assert!(times.len() > 7, "{times:?}");
        let off = |(a, b): (&f64, &f64)| (a - b).abs();
        let most = times.iter().zip(instants).map(off).fold(0.0, f64::max);
        assert!(most < 1e-12, "{times:?}");
    }
}

#[test]
fn a_gap_opens_by_its_fifth_derivative() {
    for method in BOTH {
        let run = run(&side_by_side(Side::Lower), still(2), (0.0, 2.0), method);
        assert!(run.impacts().is_empty(), "{method:?}");
        for t in [0.01, 0.1, 0.7, 2.0] {
            let (q, _) = run.state(t, ImpactSide::After).expect("kept");
            let wanted = dvector![t - f64::sin(t), 0.5 * (f64::sin(t) - t * f64::cos(t))];
            assert!((&q - &wanted).amax() < 1e-10, "{method:?} {t} {q}");
        }
    }
}

#[test]
fn a_gap_opens_by_its_fourth_derivative_from_where_nothing_moves() {
    // x'' + x/16 = 3/8 (cos 400 t - 1)
    let (w, fast, a) = (0.25, 400.0, 0.375);
    let system = linear(dvector![0.8], dvector![0.0], dvector![0.05]);
    let system = system.with_load(dvector![-0.3]).expect("valid");
    let push = dvector![nalgebra::Complex::from(0.3)];
    let forcing = Harmonic::new(push, fast, 0.0).expect("valid");
    let scene = scene(system, forcing, [upper(0, 0.0, 0.5)]);
    let run = run(&scene, still(1), (0.0, 0.4), Method::Exact);
    assert!(run.impacts().is_empty());
    for t in [1e-3, 0.01, 0.1, 0.4] {
        let (q, _) = run.state(t, ImpactSide::After).expect("kept");
        let (slow, turning) = ((w * t).cos(), (fast * t).cos());
        let wanted = a / (w * w) * (slow - 1.0) + a / (w * w - fast * fast) * (turning - slow);
        assert!((q[0] - wanted).abs() < 1e-14, "{t} {} {wanted}", q[0]);
    }
}

#[test]
fn a_contact_is_pressed_from_the_fifth_derivative_on() {
    // Together they are two masses on one spring: 2 q'' + q = 2 sin t.
    for method in BOTH {
        let run = run(&side_by_side(Side::Upper), still(2), (0.0, 2.0), method);
        assert!(run.impacts().is_empty(), "{method:?}");
        let w = 0.5f64.sqrt();
        for t in [0.01, 0.1, 0.7, 2.0] {
            let (q, _) = run.state(t, ImpactSide::After).expect("kept");
            let wanted = 2.0 * (f64::sin(w * t) / w - f64::sin(t));
            let off = (q[0] - wanted).abs().max((q[1] - wanted).abs());
            assert!(off < 1e-10, "{method:?} {t} {q}");
        }
    }
}

#[test]
fn a_contact_is_let_go_where_every_force_is_zero() {
    // The second of two masses on one spring swings as -cos t while the first is held; at pi/2 nothing is left but its speed.
    let stiffness = dmatrix![1.0, -1.0; -1.0, 1.0];
    let system = linear(dvector![1.0, 1.0], dvector![0.0, 0.0], stiffness);
    let held = lower(dvector![1.0, 0.0], 0.0, 0.5);
    let scene = scene(system, Forcing::Unforced, [held]);
    for method in BOTH {
        for start in [0.0, -1e6, 1e4] {
            let free = 1.4;
            let end = start + 0.5 * std::f64::consts::PI + free;
            let given = (dvector![0.0, -1.0], dvector![0.0, 0.0]);
            let run = run(&scene, given, (start, end), method);
            let apart = (2f64.sqrt() * free).sin() / 2f64.sqrt();
            let wanted = dvector![0.5 * (free - apart), 0.5 * (free + apart)];
            let off = (run.last().0 - wanted).amax();
            assert!(off < 1e-8, "{method:?} {start} {off:e}");
        }
    }
}

#[test]
fn a_body_crosses_a_narrow_room() {
    // The force -cos t holds a unit mass at the lower stop until pi/2; it is at the upper one when `s - sin s` is the room.
    let push = nalgebra::Complex::new(-1.0, 0.0);
    let forcing = Harmonic::new(dvector![push], 1.0, 0.0).expect("valid");
    let system = unit_mass(0.0, 0.0);
    for method in BOTH {
        for room in [1e-9, 1e-6] {
            let stops = [lower(0, 0.0, 0.0), upper(0, room, 0.0)];
            let scene = scene(system.clone(), forcing.clone(), stops);
            let run = run(&scene, still(1), (0.0, 3.0), method);
            let crossing = (6.0 * room).cbrt();
            let impacts = run.impacts();
            assert_eq!(impacts.len(), 1, "{method:?} {room:e} {impacts:?}");
            let late = impacts[0].time - 0.5 * std::f64::consts::PI - crossing;
            // Steps know a position to their tolerance.
            let allowed = 1e-5 * crossing + 1e-12 / crossing.powi(2);
            assert!(late.abs() < allowed, "{method:?} {room:e} {late:e}");
        }
    }
}

#[test]
fn an_impact_leaves_the_contacts_it_does_not_reach() {
    // One coordinate is pressed to a stop, the other goes to and fro between two.
    let system = linear(dvector![1.0, 1.0], dvector![0.0, 0.0], dvector![0.0, 0.0]);
    let system = loaded(system, &[-1.0, 0.0]);
    let stops = [
        lower(dvector![1.0, 0.0], 0.0, 1.0),
        lower(dvector![0.0, 1.0], 0.0, 1.0),
        upper(dvector![0.0, 1.0], 1.0, 1.0),
    ];
    let scene = scene(system, Forcing::Unforced, stops);
    for method in BOTH {
        let given = (dvector![0.0, 0.5], dvector![0.0, 1.0]);
        let run = run(&scene, given, (0.0, 20.0), method);
        assert_eq!(run.impacts().len(), 20, "{method:?}");
        assert!(run.impacts().iter().all(|i| i.stop != 0), "{method:?}");
        let segments = run.segments().expect("kept");
        let is_held = |s: &&vibroimpact::Segment| s.kind == SegmentKind::Stick && s.stop == Some(0);
        let held = segments.iter().filter(is_held);
        let time: f64 = held.map(|s| s.end - s.start).sum();
        assert!((time - 20.0).abs() < 1e-12, "{method:?} {time}");
    }
}

#[test]
fn a_force_of_rounding_shortens_no_step() {
    // After an impact without restitution two bodies in one stream move as one: nothing presses them together.
    let (mass, rate) = (dmatrix![1.7, -0.3; -0.3, 1.8], 0.017);
    let scene = |mass: &nalgebra::DMatrix<f64>| {
        let system = linear(mass.clone(), mass * rate, dvector![0.0, 0.0]);
        let between = lower(dvector![1.0, -1.0], 0.0, 0.0);
        scene(system, Forcing::Unforced, [between])
    };
    for v in [0.13, 0.133_788_3, 0.2, 0.21] {
        let given = (dvector![0.0, 0.0], dvector![v, 0.25]);
        let run = run(&scene(&mass), given, (0.0, 400.0), Method::Rk45);
        let (q, _) = run.last();
        assert!((q[0] - q[1]).abs() < 1e-10, "{v} {q}");
        assert!(run.stats().n_steps < 1000, "{v} {:?}", run.stats());
    }
}

#[test]
fn what_slides_between_two_walls_comes_to_rest_there() {
    // Dampers in proportion to the masses: along the walls v' = -v/25, and no force but rounding holds the bodies on them.
    let mass = dmatrix![1.98, 0.84; 0.84, 1.74];
    let system = linear(mass.clone(), 0.04 * &mass, dvector![0.0, 0.0]);
    let walls =
        [Side::Lower, Side::Upper].map(|side| upper(dvector![0.8, 0.5], 0.0, 0.8).on_side(side));
    let scene = scene(system, Forcing::Unforced, walls);
    let (normal, thrown) = (dvector![0.8, 0.5], dvector![0.9, -0.7]);
    let give = mass.try_inverse().expect("regular") * &normal;
    let along = &thrown - &give * (normal.dot(&thrown) / normal.dot(&give));
    for method in BOTH {
        let run = run(
            &scene,
            (dvector![0.0, 0.0], thrown.clone()),
            (0.0, 200.0),
            method,
        );
        for t in [50.0, 91.4, 200.0] {
            let (q, _) = run.state(t, ImpactSide::After).expect("kept");
            let wanted = 25.0 * (1.0 - f64::exp(-0.04 * t)) * &along;
            assert!((&q - &wanted).amax() < 1e-7, "{method:?} {t} {q}");
        }
    }
}

#[test]
fn a_force_that_hardly_changes_holds() {
    // sin(w t) with a period of ages presses a mass on a spring to its stop, or draws it away.
    let w = 1e-9;
    for method in BOTH {
        for (sign, side) in [(1.0, Side::Lower), (-1.0, Side::Lower), (1.0, Side::Upper)] {
            let push = nalgebra::Complex::new(0.0, -2.0 * sign);
            let forcing = Harmonic::new(dvector![push], w, 0.0).expect("valid");
            let system = linear(dvector![1.0], dvector![0.1], dvector![3.0]);
            let stops = [upper(0, 0.0, 0.9).on_side(side)];
            let scene = scene(system, forcing, stops);
            let run = run(&scene, still(1), (0.0, 200.0), method);
            let is_drawn = (sign > 0.0) == (side == Side::Lower);
            let (q, _) = run.last();
            // Quasi-static: the spring takes the force, less the damper's share.
            let far = 2.0 * w * (200.0 - 0.1 / 3.0) / 3.0;
            let wanted = if is_drawn { sign * far } else { 0.0 };
            assert!((q[0] - wanted).abs() < 1e-3 * far, "{method:?} {sign} {q}");
        }
    }
}

#[test]
fn a_fast_force_that_moves_nothing_lets_go_in_its_first_period() {
    // A unit mass pressed by 1.1 against a stop at its place, and by 2.2 cos(w t): let go where cos w t = -1/2. A step over nearly
    // sixteen periods sees a slow force; the second stop leaves no room in which anything could move.
    let w = 1e3;
    let push = Harmonic::new(dvector![nalgebra::Complex::new(2.2, 0.0)], w, 0.0).expect("valid");
    let stops = vec![
        upper(dvector![0.7], 0.35, 0.5),
        lower(dvector![0.7], -0.35, 0.5),
    ];
    let scene = scene(loaded(unit_mass(0.0, 0.0), &[1.1]), push, stops);
    for method in BOTH {
        let run = run(
            &scene,
            (dvector![0.5], dvector![0.0]),
            (0.0, 16.2 * 2.0 * PI / w),
            method,
        );
        let segments = run.segments().expect("kept");
        let held: Vec<_> = segments.iter().filter(|s| s.end > s.start).collect();
        assert_eq!(held.len(), 33, "{method:?}");
        for (k, segment) in held.iter().enumerate() {
            assert_eq!(segment.stop, Some(k % 2), "{method:?}");
            let turns = (k / 2) as f64 + if k % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
            let end = (2.0 * PI * turns / w).min(run.span().1);
            assert!((segment.end - end).abs() < 1e-8, "{method:?} {segment:?}");
        }
    }
}

#[test]
fn fast_forcing_that_begins_from_zero_presses_until_it_turns() {
    // What it moves in each mode is thousands of times what it moves in all of them.
    let frequency = 3000.0;
    let push = [-0.03, -0.08].map(|f| nalgebra::Complex::new(f, 0.0));
    let forcing = Harmonic::new(push.to_vec().into(), frequency, -FRAC_PI_2).expect("valid");
    for k in 0..20 {
        let system = linear(
            dvector![1.0, 1.0],
            dmatrix![0.185 + 0.003 * f64::from(k), 0.007; 0.007, 0.138],
            dmatrix![0.55, -0.24; -0.24, 0.55],
        );
        let stops = [
            upper(dvector![-0.3, -0.06], 0.0, 0.9),
            lower(dvector![0.0, 1.0], 0.0, 0.5),
        ];
        let scene = scene(system, forcing.clone(), stops);
        for method in BOTH {
            let run = run(&scene, still(2), (0.0, 0.01), method);
            let segments = run.segments().expect("kept");
            let free = segments.iter().find(|s| s.kind == SegmentKind::Flight);
            let released = free.expect("a flight").start * frequency;
            assert!((released - PI).abs() < 1e-6, "{method:?} {k} {released}");
        }
    }
}

#[test]
fn a_release_leaves_alone_what_is_pressed_little() {
    // The first body is pressed by sin(1e-9 - 1e-10 t), up to t = 10; the second by 1e-10 cos(sqrt(2) t), the spring to the third.
    let stiffness = dmatrix![1.0, 0.0, 0.0; 0.0, 2.0, -1.0; 0.0, -1.0, 2.0];
    let system = linear(dvector![1.0, 1.0, 1.0], DVector::zeros(3), stiffness);
    let push = dvector![1.0, 0.0, 0.0].map(nalgebra::Complex::from);
    let forcing = Harmonic::new(push, 1e-10, -FRAC_PI_2 - 1e-9).expect("valid");
    let stops =
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|n| lower(DVector::from_row_slice(&n), 0.0, 0.5));
    let scene = scene(system, forcing, stops);
    let start = (dvector![0.0, 0.0, -1e-10], DVector::zeros(3));
    for method in BOTH {
        let run = run(&scene, start.clone(), (0.0, 15.0), method);
        let segments = run.segments().expect("kept");
        assert!(
            run.impacts().iter().all(|impact| impact.stop == 1),
            "{method:?}"
        );
        let held = |stop| segments.iter().filter(move |s| s.stop == Some(stop));
        let ends = [
            held(0).next_back().expect("held").end,
            held(1).next().expect("held").end,
        ];
        assert!((ends[0] - 10.0).abs() < 1e-4, "{method:?} {ends:?}");
        assert!(
            (ends[1] - PI / 8f64.sqrt()).abs() < 1e-4,
            "{method:?} {ends:?}"
        );
    }
}

#[test]
fn a_force_along_one_normal_leaves_what_else_is_touched_at_rest() {
    // What the one stop carries, to the last digit, is no force on the other.
    for k in 0..20 {
        let coupling = 0.03 * f64::from(k) + 0.014;
        let mass = dmatrix![1.9, coupling; coupling, 0.99];
        let (damping, stiffness) = (&mass * 0.03, dmatrix![0.11, 0.01; 0.01, 0.04]);
        let system = linear(mass, damping, stiffness);
        let push = dvector![-0.2, 0.2].map(nalgebra::Complex::from);
        let forcing = Harmonic::new(push, 1.0, 0.0).expect("valid");
        let stops = [
            upper(dvector![1.0, 0.0], 0.0, 0.0),
            lower(dvector![1.0, -1.0], 0.0, 0.5),
        ];
        for reaction in [Reaction::Inertia, Reaction::Coordinate] {
            let mut stops = stops.clone();
            stops[0] = stops[0]
                .clone()
                .with_reaction(reaction.clone())
                .expect("valid");
            let scene = scene(system.clone(), forcing.clone(), stops);
            for method in BOTH {
                let run = run(&scene, still(2), (0.0, 1.5), method);
                assert!(
                    run.impacts().is_empty() && run.stats().n_flights < 5,
                    "{k} {method:?} {:?}",
                    run.stats()
                );
                assert!(run.last().0.amax() < 1e-15, "{k} {method:?}");
            }
        }
    }
}

/// Positions of masses under `sin(w t)` times a force, from rest at zero: mode by mode, springs and masses of size one.
fn pushed(stiffness: &DMatrix<f64>, force: &DVector<f64>, w: f64, t: f64) -> DVector<f64> {
    let modes = stiffness.clone().symmetric_eigen();
    let parts = modes.eigenvalues.map_with_location(|j, _, w2: f64| {
        let own = w2.max(0.0).sqrt();
        let reply = if own > 1e-6 {
            w / own * f64::sin(own * t)
        } else {
            w * t
        };
        modes.eigenvectors.column(j).dot(force) * (f64::sin(w * t) - reply) / (own * own - w * w)
    });
    &modes.eigenvectors * parts
}

#[test]
fn what_happens_far_away_reaches_a_stop_that_is_held() {
    // A chain at rest against a stop at its one end, pushed or pulled at the other: there the force is zero with more and more
    // of its derivatives.
    let w = 0.7;
    for n in 2..=6 {
        let spring = |i: usize, j: usize| match i.abs_diff(j) {
            0 if i == 0 || i == n - 1 => 1.0,
            0 => 2.0,
            1 => -1.0,
            _ => 0.0,
        };
        let stiffness = DMatrix::from_fn(n, n, spring);
        let masses = DVector::from_element(n, 1.0);
        let system = linear(masses, DVector::zeros(n), stiffness.clone());
        let near = DVector::from_fn(n, |i, _| f64::from(u8::from(i == 0)));
        for sign in [1.0, -1.0] {
            let far = DVector::from_fn(n, |i, _| if i == n - 1 { sign } else { 0.0 });
            let amplitude = far.map(|f| nalgebra::Complex::new(0.0, -f));
            let forcing = Harmonic::new(amplitude, w, 0.0).expect("valid");
            let scene = scene(system.clone(), forcing, [upper(near.clone(), 0.0, 0.5)]);
            // Pulled, the chain leaves at once; pushed, when the neighbour comes back.
            let held = stiffness.view((1, 1), (n - 1, n - 1)).into_owned();
            let neighbour = |t: f64| pushed(&held, &far.rows(1, n - 1).into_owned(), w, t)[0];
            let (mut before, mut after) = (3.0, 12.0);
            while after - before > 1e-13 * after {
                let middle = 0.5 * (before + after);
                if neighbour(middle) > 0.0 {
                    before = middle;
                } else {
                    after = middle;
                }
            }
            for method in BOTH {
                let run = run(&scene, still(n), (0.0, 12.0), method);
                let (stay, leave) = if sign > 0.0 {
                    (0.999 * before, after)
                } else {
                    (0.0, 0.0)
                };
                assert!(run.impacts().is_empty(), "{n} {sign} {method:?}");
                let at = |t: f64| run.state(t, ImpactSide::After).expect("kept").0;
                assert!(at(stay)[0].abs() < 1e-15, "{n} {sign} {method:?}");
                if sign < 0.0 {
                    let wanted = pushed(&stiffness, &far, w, 12.0);
                    let off = (at(12.0) - &wanted).amax();
                    assert!(off < 1e-8, "{n} {method:?} {off:e}");
                } else {
                    let last = run
                        .segments()
                        .expect("kept")
                        .into_iter()
                        .find(|s| s.kind == SegmentKind::Flight);
                    let released = last.expect("let go").start;
                    assert!(
                        (released - leave).abs() < 1e-8,
                        "{n} {method:?} {released} {leave}"
                    );
                }
            }
        }
    }
}

#[test]
fn what_dashpots_hand_on_presses_from_the_fifth_derivative_on() {
    // Over dashpots alone the force `sin t` on the third mass reaches the first as `t^5/120` would.
    let dashpots = dmatrix![1.0, -1.0, 0.0; -1.0, 2.0, -1.0; 0.0, -1.0, 1.0];
    let twisted = &dashpots + dmatrix![0.0, 0.3, 0.0; -0.3, 0.0, 0.7; 0.0, -0.7, 0.0];
    for damping in [dashpots, twisted] {
        let masses = dvector![1.3, 0.7, 1.1];
        let system = linear(masses, damping, DVector::zeros(3));
        for (sign, stays) in [(1.0, true), (-1.0, false)] {
            let amplitude = dvector![0.0, 0.0, sign].map(|f| nalgebra::Complex::new(0.0, -f));
            let forcing = Harmonic::new(amplitude, 1.0, 0.0).expect("valid");
            let stops = [upper(dvector![1.0, 0.0, 0.0], 0.0, 1.0)];
            let scene = scene(system.clone(), forcing, stops);
            for method in BOTH {
                let run = run(&scene, still(3), (0.0, 2.0), method);
                assert!(run.impacts().is_empty(), "{sign} {method:?}");
                let moved = run.last().0[0];
                assert_eq!(moved.abs() < 1e-15, stays, "{sign} {method:?} {moved:e}");
            }
        }
    }
}

#[test]
fn what_only_a_damper_slows_stays_where_a_stop_has_stopped_it() {
    for method in BOTH {
        for k in 1..60 {
            let k = f64::from(k);
            let (mass, damper, normal) = (0.3 + 0.11 * k, 0.2 + 0.037 * k, 0.1 + 0.013 * k);
            let system = linear(dvector![mass], dvector![damper], dvector![0.0]);
            let floor = lower(dvector![normal], 0.0, 0.0);
            let scene = scene(system, Forcing::Unforced, [floor]);
            let start = (dvector![0.0], dvector![-0.089 * k.sqrt()]);
            let run = run(&scene, start, (-1e6, 60.0 - 1e6), method);
            assert_eq!(run.impacts().len(), 1);
            let segments = run.segments().expect("kept");
            let last = segments.last().expect("some");
            assert_eq!((last.kind, last.start), (SegmentKind::Stick, -1e6));
            assert_eq!(run.last().1[0], 0.0);
        }
    }
}

#[test]
fn two_gaps_open_one_after_the_other_from_rest() {
    // The second body is pushed by a sine from zero; a dashpot between the two draws the first one after it, an order later.
    let system = linear(
        dvector![1.0, 1.0],
        dmatrix![15.6, 1.1; 1.1, 13.6],
        dmatrix![1.8, 0.0; 0.0, 1.8],
    );
    let force = dvector![0.0.into(), 2.4.into()];
    let forcing = Forcing::from(Harmonic::new(force, 0.8, -FRAC_PI_2).expect("valid"));
    let stops = [
        upper(dvector![1.0, -1.0], 0.0, 0.9),
        upper(dvector![1.0, 0.0], 0.0, 0.5),
    ];
    let free = scene(system.clone(), forcing.clone(), Vec::<Stop>::new());
    let scene = scene(system, forcing, stops);
    for method in BOTH {
        let [free, bounded] = [&free, &scene].map(|scene| run(scene, still(2), (0.0, 2.0), method));
        assert!(bounded.impacts().is_empty());
        let off = (free.last().0 - bounded.last().0).amax();
        assert!(off < 1e-9, "{method:?}: {off:e}");
    }
}

#[test]
fn a_stop_between_bodies_that_rest_does_not_open_by_rounding() {
    // The first body is struck without restitution and pressed for good; nothing moves the second, whose speed is what the modes leave
    // of that impact.
    let system = linear(
        dvector![1.0, 1.0],
        dvector![0.0, 0.0],
        dmatrix![1.83, 0.21; 0.21, 0.94],
    );
    let system = loaded(system, &[-1.0, 0.0]);
    let force = dvector![nalgebra::Complex::from(0.5), nalgebra::Complex::from(0.0)];
    let forcing = Harmonic::new(force, 1.25, 0.0).expect("valid");
    let stops = [
        lower(dvector![1.0, 0.0], 0.0, 0.0),
        upper(dvector![1.0, -1.0], 0.0, 0.5),
    ];
    let scene = scene(system, forcing, stops);
    for k in 0..50 {
        let v0 = dvector![-0.5 - 0.013 * f64::from(k), 0.0];
        let span = (-1e6, -1e6 + 20.0);
        let run = run(&scene, (DVector::zeros(2), v0), span, Method::Exact);
        assert_eq!(run.impacts().len(), 1, "{k}");
        let (q, v) = run.last();
        for (x, v) in q.iter().zip(v) {
            assert!(x.abs() < 1e-13 && v.abs() < 1e-13, "{k}: {x:e} {v:e}");
        }
    }
}
