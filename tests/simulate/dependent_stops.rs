//! Stops whose normals depend on each other: two that face each other without room, the same stop twice, more stops in a corner
//! than it has directions. What they let a body do is known in closed form, whoever of them carries the load.

use crate::scenes::{BOTH, harmonic, linear, loaded, lower, scene, unit_mass, upper, with};
use nalgebra::{DVector, dmatrix, dvector};
use vibroimpact::{
    Forcing, Harmonic, ImpactSide, Method, Motion, Reaction, Scene, Status, Stop, Trajectory,
    nalgebra,
};

fn run(scene: &Scene, q0: &[f64], v0: &[f64], end: f64, method: Method) -> Trajectory {
    let run = crate::scenes::run(scene, q0, v0, end, &with(method, 1e-9));
    assert_eq!(run.status(), Status::Finished, "{}", run.message());
    run
}

/// A mass on a spring, pushed by a constant and a harmonic force.
fn pushed(load: f64, force: f64, stops: Vec<Stop>) -> Scene {
    let forcing = harmonic(&[force], 2.3, 0.4);
    scene(loaded(unit_mass(0.0, 5.0), &[load]), forcing, stops)
}

#[test]
fn a_body_without_room_stays_whichever_stop_the_force_presses_it_to() {
    for method in BOTH {
        let stops = vec![
            lower(0, 0.0, 0.3),
            upper(dvector![-0.9], 0.0, 0.9),
            upper(0, 0.0, 1.0),
        ];
        let scene = pushed(0.2, 0.6, stops);
        let run = run(&scene, &[0.0], &[0.0], 60.0, method);
        let (q, v) = run.last();
        assert!(
            q[0].abs() < 1e-15 && v[0].abs() < 1e-15,
            "{method:?} {q} {v}"
        );
        assert!(run.impacts().is_empty(), "{method:?} {:?}", run.impacts());
    }
}

#[test]
fn a_body_that_comes_where_it_has_no_room_comes_to_rest() {
    for method in BOTH {
        for (e, f) in [(0.5, 0.5), (0.9, 0.2), (1.0, 0.0)] {
            let scene = pushed(0.0, 0.6, vec![lower(0, 0.0, e), upper(0, 0.0, f)]);
            let run = run(&scene, &[0.0], &[0.7], 20.0, method);
            let (q, v) = run.last();
            assert!(
                q[0].abs() < 1e-12 && v[0].abs() < 1e-12,
                "{method:?} {e} {f}: {q} {v}"
            );
        }
    }
}

#[test]
fn a_stop_given_twice_holds_and_lets_go_as_one() {
    for method in BOTH {
        let once = pushed(-1.0, 2.0, vec![lower(0, 0.0, 0.4)]);
        let twice = pushed(-1.0, 2.0, vec![lower(0, 0.0, 0.4); 2]);
        let end = |scene: &Scene| run(scene, &[0.0], &[0.0], 40.0, method);
        let (one, two) = (end(&once), end(&twice));
        let apart = (one.last().0[0] - two.last().0[0]).abs();
        assert!(apart < 1e-7, "{method:?} {apart:e}");
        assert!(one.impacts().len() > 3, "{method:?}");
    }
}

/// A plane body in a corner between three stops, pressed by a force that turns; it stays as long as the force points into the
/// cone of the reactions.
#[test]
fn a_corner_with_more_stops_than_directions_holds_as_the_cone_of_its_reactions() {
    let system = linear(dvector![1.0, 1.0], dvector![0.0, 0.0], dvector![0.0, 0.0]);
    let i = nalgebra::Complex::new(0.0, 1.0);
    // The force (sin t, -cos t) turns from straight down to the right; the left-most reaction is (0.6, 0.8), the right-most (-0.6, 0.8).
    let forcing = Harmonic::new(dvector![-i, (-1.0).into()], 1.0, 0.0).expect("valid");
    let stops = [
        lower(dvector![0.6, 0.8], 0.0, 0.5),
        lower(dvector![0.0, 1.0], 0.0, 0.5),
        lower(dvector![-0.6, 0.8], 0.0, 0.5),
    ];
    let scene = scene(system, forcing, stops);
    let leaves = 0.6f64.atan2(0.8);
    for method in BOTH {
        let rest = run(&scene, &[0.0; 2], &[0.0; 2], leaves - 1e-6, method);
        assert!(rest.last().0.amax() < 1e-14, "{method:?} {}", rest.last().0);
        // Behind that it slides along the right-most stop, driven by sin(t - leaves).
        let later = leaves + 0.5;
        let run = run(&scene, &[0.0; 2], &[0.0; 2], later, method);
        let far = 0.5 - 0.5f64.sin();
        let along = dvector![0.8, 0.6] * far;
        let off = (run.last().0 - &along).amax();
        assert!(off < 1e-8, "{method:?} {off:e} {}", run.last().0);
    }
}

/// A third stop is hit while two hold a body in a corner: it cannot go through them.
#[test]
fn a_stop_that_is_held_takes_part_in_the_impacts_of_others() {
    let (m, k) = (dmatrix![1.5, 0.5; 0.5, 1.2], dmatrix![3.0, -1.0; -1.0, 3.0]);
    let system = loaded(linear(m, dvector![0.0, 0.0], k), &[-2.0, 0.0]);
    let stops = [
        lower(dvector![1.0, 0.0], 0.0, 0.9),
        upper(dvector![0.3, 1.0], 0.4, 0.8),
        lower(dvector![0.2, 1.0], 0.3, 0.7)
            .with_reaction(Reaction::Direction(dvector![0.1, 1.0]))
            .expect("valid"),
    ];
    let scene = scene(system, harmonic(&[0.0, 2.5], 1.7, 0.3), stops);
    for method in BOTH {
        let run = run(&scene, &[0.0; 2], &[0.0; 2], 60.0, method);
        assert!(run.impacts().iter().any(|i| i.stop == 2), "{method:?}");
        for k in 0..=6000 {
            let (q, _) = run
                .state(f64::from(k) * 0.01, ImpactSide::After)
                .expect("kept");
            let gaps = scene.gaps(&q).expect("linear");
            assert!(gaps.min() > -1e-8, "{method:?} {k} {gaps}");
        }
    }
}

#[test]
fn a_body_without_room_in_a_corner_stays_whatever_the_force() {
    // Three stops whose normals span the plane positively: any force is carried by two of them, and which ones turns with it.
    for method in BOTH {
        for normals in [
            [[1.0, 0.0], [-0.5, 0.8], [-0.5, -0.9]],
            [[0.5, -0.51], [1.0, 0.0], [-1.0, 1.0]],
        ] {
            let system = linear(
                dmatrix![2.3, 0.07; 0.07, 1.5],
                dmatrix![0.0, 0.0; 0.0, 0.0],
                dmatrix![2.7, 0.05; 0.05, 2.3],
            );
            // Along one line as well as all around.
            for across in [0.0, 1.0] {
                let push = dvector![
                    nalgebra::Complex::new(0.9, 0.0),
                    nalgebra::Complex::new(-0.55, across)
                ];
                let forcing = Harmonic::new(push, 0.7, 0.3).expect("valid");
                let stops = normals.map(|normal| upper(DVector::from_row_slice(&normal), 0.0, 0.5));
                let scene = scene(system.clone(), forcing, stops);
                let run = run(&scene, &[0.0; 2], &[0.0; 2], 40.0, method);
                assert!(run.last().0.amax() < 1e-10, "{method:?} {}", run.last().0);
            }
        }
    }
}

#[test]
fn a_body_slides_along_two_stops_by_its_load_alone() {
    // Its dashpot acts along a coordinate that the stops keep: nothing damps the one motion that they leave.
    let system = loaded(
        linear(
            dvector![300.0, 2.0, 0.06],
            dvector![0.0, 2.0, 0.0],
            dvector![0.0, 0.0, 0.0],
        ),
        &[-0.8, -0.5, 0.6],
    );
    let along = |stop: Stop| stop.with_reaction(Reaction::Coordinate).expect("valid");
    let stops = [
        along(upper(dvector![0.9, 0.9, 0.3], 0.2, 0.03)),
        along(lower(dvector![0.0, 1.0, 0.0], 0.4, 0.0)),
    ];
    let scene = scene(system, Forcing::Unforced, stops);
    for method in BOTH {
        let start = [0.0, -0.4, 0.56 / 0.3];
        let run = run(&scene, &start, &[0.0; 3], 10.0, method);
        assert!(run.impacts().is_empty(), "{method:?}");
        // q'' = M^-1 load - b x, with 0.9 q0'' + 0.3 q2'' = 0.
        let free = [-0.8 / 300.0, 0.6 / 0.06];
        let x = (0.9 * free[0] + 0.3 * free[1]) / 0.9;
        let wanted = 0.5 * (free[0] - 0.9 * x) * 100.0;
        let (q, _) = run.last();
        assert!(
            (q[0] / wanted - 1.0).abs() < 1e-9,
            "{method:?} {q} {wanted}"
        );
    }
}
