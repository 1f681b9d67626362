//! Several stops at one instant, held to laws and closed forms: energy, momentum, billiards, Gauss's principle.

use crate::random::{Cases, Random};
use nalgebra::{Cholesky, DMatrix, DVector, dmatrix, dvector};
use vibroimpact::{
    Forcing, Harmonic, ImpactSide, LinearSystem, Method, Motion, Release, ResolvedImpacts, Scene,
    SimulateOptions, Stop, StopMotion, contact_forces, resolve_impacts, simulate,
};

/// A mass, and normals of stops as columns, each with `b = M^-1 n`.
struct Body {
    mass: DMatrix<f64>,
    normals: DMatrix<f64>,
    reactions: DMatrix<f64>,
}

impl Body {
    fn new(mass: DMatrix<f64>, normals: DMatrix<f64>) -> Self {
        let factor = Cholesky::new(mass.clone()).expect("a mass is positive definite");
        let reactions = factor.solve(&normals);
        Self {
            mass,
            normals,
            reactions,
        }
    }

    /// Beads above one another on a vertical line, heights upwards: stop 0 is the floor, stop i lies between the beads
    /// i - 1 and i, `h_i = z_i - z_(i-1)`.
    fn column(masses: &[f64]) -> Self {
        let n = masses.len();
        let normals = DMatrix::from_fn(n, n, |bead, stop| match bead {
            _ if bead == stop => -1.0,
            _ if bead + 1 == stop => 1.0,
            _ => 0.0,
        });
        Self::new(
            DMatrix::from_diagonal(&DVector::from_column_slice(masses)),
            normals,
        )
    }

    fn random(random: &mut Random) -> Self {
        let most = [6, 6, 6, 20][random.below(4)];
        let (n, k) = (1 + random.below(4), 1 + random.below(most));
        let root = random.matrix(n);
        let mass = &root * root.transpose() + DMatrix::identity(n, n) * 0.05;
        // Normals on a grid are dependent or well apart: the same one again, opposite ones, three in a plane.
        let grid = [2.0, 16.0][random.below(2)];
        let normals = DMatrix::from_fn(n, k, |_, _| (grid * random.between(-1.0, 1.0)).round());
        let kept: Vec<usize> = (0..k)
            .filter(|&i| normals.column(i).norm() > 1e-3)
            .collect();
        Self::new(mass, normals.select_columns(&kept))
    }

    fn delassus(&self) -> DMatrix<f64> {
        self.normals.tr_mul(&self.reactions)
    }

    fn energy(&self, v: &DVector<f64>) -> f64 {
        0.5 * v.dot(&(&self.mass * v))
    }

    fn slack(&self, v: &DVector<f64>) -> DVector<f64> {
        self.normals.abs().tr_mul(&v.abs()) * 1e-14
    }

    fn hit(&self, v: &DVector<f64>, e: &DVector<f64>) -> (DVector<f64>, ResolvedImpacts) {
        let before = -self.normals.tr_mul(v);
        let found = resolve_impacts(&self.delassus(), e, &before, &self.slack(v))
            .unwrap_or_else(|error| panic!("{error}: N {} v {v} e {e}", self.normals));
        (v - &self.reactions * &found.impulses, found)
    }
}

#[test]
fn newtons_law_never_gains_energy_and_leaves_no_stop_closing() {
    let (cases, mut several_rounds) = (Cases::new(0x5EED, 5_000), 0);
    for (_, mut random) in cases.each() {
        let body = Body::random(&mut random);
        let k = body.normals.ncols();
        let v = random.vector(body.mass.nrows());
        let e = DVector::from_fn(k, |_, _| [0.0, 1.0, random.unit()][random.below(3)]);
        let (after, found) = body.hit(&v, &e);
        assert!(found.impulses.iter().all(|&p| p >= 0.0));
        let (start, end) = (body.energy(&v), body.energy(&after));
        assert!(end <= start * (1.0 + 1e-11), "{start} {end} {found:?}");
        let speeds = -body.normals.tr_mul(&after);
        let size = body
            .normals
            .abs()
            .tr_mul(&(body.reactions.abs() * &found.impulses + v.abs()));
        for i in 0..k {
            assert!(speeds[i] >= -1e-12 * size[i], "{speeds} {found:?}");
            assert!((speeds[i] - found.opening_speeds[i]).abs() <= 1e-12 * size[i]);
        }
        if found.rounds == 1 {
            // dT = -1/2 p^T (I - E) N^T v-
            let approach = body.normals.tr_mul(&v);
            let loss: f64 = (0..k)
                .map(|i| 0.5 * found.impulses[i] * (1.0 - e[i]) * approach[i])
                .sum();
            assert!((start - end - loss).abs() <= 1e-11 * start);
        }
        several_rounds += usize::from(found.rounds > 1);
    }
    assert!(cases.is_one() || several_rounds > 0);
}

#[test]
fn a_column_of_beads_rebounds_as_one_body() {
    // Only the floor closes, the contacts between beads are sustained. All active: the opening speeds after are (v, 0, ...),
    // every bead rises with v, and each contact gives what lies above it twice its momentum, p_i = 2 v sum_(k>=i) m_k > 0,
    // so it is the solution; G is positive definite, so there is no other.
    for masses in [
        vec![1.0; 10],
        vec![1.0, 2.0, 0.5, 4.0, 1.0, 8.0, 0.25, 1.0, 3.0, 2.0],
    ] {
        let body = Body::column(&masses);
        let (after, found) = body.hit(&DVector::from_element(10, -3.0), &DVector::repeat(10, 1.0));
        assert!((after.add_scalar(-3.0)).amax() < 1e-13);
        for i in 0..10 {
            let above: f64 = masses[i..].iter().sum();
            assert!((found.impulses[i] - 6.0 * above).abs() < 1e-13 * found.impulses[0]);
        }
        assert_eq!((found.rounds, found.is_inelastic), (1, false));
        assert_eq!(found.opening_speeds[0], 3.0);
        assert!(
            found
                .opening_speeds
                .rows(1, 9)
                .iter()
                .all(|&speed| speed == 0.0)
        );
    }
}

#[test]
fn an_opened_column_passes_the_blow_on_one_by_one() {
    // Equal beads, elastic, each contact above opening: pairs exchange their velocities from the bottom up, as if apart.
    let body = Body::column(&[1.0; 4]);
    let (after, found) = body.hit(&dvector![-1.0, -0.9, -0.8, -0.7], &DVector::repeat(4, 1.0));
    // The set of velocities (1, 0.9, 0.8, 0.7) after all have met the floor, sorted upwards.
    assert!((after - dvector![0.7, 0.8, 0.9, 1.0]).amax() < 1e-14);
    assert!(found.rounds > 4 && !found.is_inelastic);
}

/// A light bead between the floor and a falling body `ratio` times as heavy, hardly off the floor: (light, heavy).
fn galperin(ratio: f64) -> (Body, DVector<f64>, ResolvedImpacts) {
    let body = Body::column(&[1.0, ratio]);
    let (after, found) = body.hit(&dvector![0.1, -1.0], &DVector::repeat(2, 1.0));
    (body, after, found)
}

#[test]
fn elastic_bounces_count_the_digits_of_pi() {
    // G. Galperin, Regular and Chaotic Dynamics 8 (2003) 375: unfolded, the motion is a straight line through a fan of
    // mirrors at angles k arctan(1/sqrt(ratio)) below pi; 3, 31, 314, ... bounces.
    for (ratio, bounces) in [(1.0, 3), (100.0, 31)] {
        let (body, after, found) = galperin(ratio);
        assert_eq!((found.rounds, found.is_inelastic), (bounces, false));
        let energy = body.energy(&dvector![0.1, -1.0]);
        assert!((body.energy(&after) - energy).abs() < 1e-12 * energy);
    }
}

#[test]
fn after_a_hundred_rounds_restitution_is_given_up() {
    let (body, after, found) = galperin(1e4);
    assert_eq!((found.rounds, found.is_inelastic), (101, true));
    assert!(body.energy(&after) <= body.energy(&dvector![0.1, -1.0]));
    assert!(found.opening_speeds.iter().all(|&speed| speed >= 0.0));
    let size = (body.reactions.abs() * &found.impulses).max();
    assert!(after[0] >= -1e-14 * size && after[1] - after[0] >= -1e-14 * size);
}

#[test]
fn three_stops_on_two_coordinates_move_as_two_do() {
    // A unit mass meets the walls of a corner and the diagonal across it: any two give v+ = -e v-, and so do three.
    let normals = dmatrix![1.0, 0.0, 1.0; 0.0, 1.0, 1.0];
    let body = Body::new(DMatrix::identity(2, 2), normals);
    let v = dvector![1.0, 2.0];
    let (after, found) = body.hit(&v, &DVector::repeat(3, 0.5));
    assert!((&after + &v * 0.5).amax() < 1e-15);
    // Of all p with p1 + p3 = 1.5, p2 + p3 = 3 the shortest: p3 = 1.5, p1 = 0, p2 = 1.5.
    assert!((found.impulses - dvector![0.0, 1.5, 1.5]).amax() < 1e-14);
}

#[test]
fn a_column_at_rest_carries_its_weight() {
    let masses = [1.0, 2.0, 0.5, 4.0];
    let body = Body::column(&masses);
    let free = body.normals.tr_mul(&DVector::repeat(4, 9.81));
    let slack = DVector::repeat(4, 1e-12);
    let forces = contact_forces(&body.delassus(), &free, &slack).expect("solvable");
    for (i, contact) in forces.iter().enumerate() {
        let weight = 9.81 * masses[i..].iter().sum::<f64>();
        assert!((contact.force - weight).abs() < 1e-13 * weight);
        assert_eq!(
            (contact.acceleration, contact.release),
            (0.0, Release::Stays)
        );
    }
}

#[test]
fn contacts_leave_stay_or_are_undecided() {
    // Two unit beads on a floor; gravity 1, the upper one lifted by a force f: it leaves for f > 1, is undecided for f = 1.
    let body = Body::column(&[1.0, 1.0]);
    for (lift, upper) in [
        (0.5, Release::Stays),
        (1.0, Release::Undecided),
        (1.0 + 1e-15, Release::Undecided),
        (1.0 - 1e-15, Release::Undecided),
        (1.5, Release::Leaves),
    ] {
        let free = -body.normals.tr_mul(&dvector![-1.0, lift - 1.0]);
        let forces = contact_forces(&body.delassus(), &free, &DVector::repeat(2, 1e-14));
        let forces = forces.expect("solvable");
        assert_eq!(
            (forces[0].release, forces[1].release),
            (Release::Stays, upper)
        );
        assert!((forces[0].force - (1.0 + (1.0 - lift).max(0.0))).abs() < 1e-14);
        assert!((forces[1].acceleration - (lift - 1.0).max(0.0)).abs() < 1e-14);
    }
    // A jam: two walls that close in on one coordinate.
    let jam = dmatrix![1.0, -1.0; -1.0, 1.0];
    let closing = dvector![-1.0, -1.0];
    assert!(contact_forces(&jam, &closing, &DVector::zeros(2)).is_err());
}

#[test]
fn stuck_motion_is_the_nearest_the_stops_allow() {
    // Gauss's principle: of all accelerations with N^T a <= 0, the true one is nearest to the free one in the mass norm, so
    // the direction to every other makes no obtuse angle: (a' - a)^T M (a - a_free) >= 0.
    for (_, mut random) in Cases::new(0xACCE1, 5_000).each() {
        let body = Body::random(&mut random);
        let (n, k) = (body.mass.nrows(), body.normals.ncols());
        let free = random.vector(n);
        let slack = body.slack(&free);
        let gaps = -body.normals.tr_mul(&free);
        let forces = contact_forces(&body.delassus(), &gaps, &slack).expect("a = 0 is allowed");
        let force = DVector::from_fn(k, |i, _| forces[i].force);
        let a = &free - &body.reactions * &force;
        let push = &body.mass * (&a - &free);
        let size = body
            .normals
            .abs()
            .tr_mul(&(body.reactions.abs() * &force + free.abs()));
        for i in 0..k {
            let h = -body.normals.column(i).dot(&a);
            assert!(h >= -1e-12 * size[i] && (h - forces[i].acceleration).abs() <= 1e-12 * size[i]);
            assert!(forces[i].force == 0.0 || forces[i].acceleration == 0.0);
        }
        for _ in 0..5 {
            let other = random.vector(n);
            if (0..k).all(|i| body.normals.column(i).dot(&other) <= 0.0) {
                let terms = push.abs().dot(&(&other - &a).abs());
                assert!((other - &a).dot(&push) >= -1e-11 * terms);
            }
        }
    }
}

/// Stops that move through their places of rest at some speeds at t = 0, each a number of a body; the speeds after both are hit at once
/// are those of the law for the speeds relative to the stops.
#[test]
fn stops_that_move_are_hit_at_once_by_their_relative_speeds() {
    let mut random = Random::new(61);
    let (mut together, mut one_by_one) = (0, 0);
    for case in 0..200 {
        let root = random.matrix(2);
        let mass = &root * root.transpose() + DMatrix::identity(2, 2) * 0.3;
        let normals = dmatrix![1.0, random.between(-0.9, 0.9); random.between(-0.9, 0.9), 1.0];
        let body = Body::new(mass.clone(), normals.clone());
        let e = dvector![random.between(0.1, 1.0), random.between(0.1, 1.0)];
        let q = dvector![random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
        let v = dvector![random.between(-2.0, 2.0), random.between(-2.0, 2.0)];
        let moved = dvector![random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
        // `c cos(w t - pi/2)` has the speed `c w` at t = 0.
        let (w, quarter) = (1.3, -std::f64::consts::FRAC_PI_2);
        let stop = |i: usize| {
            let normal = normals.column(i).into_owned();
            let motion = Harmonic::new(dvector![(moved[i] / w).into()], w, quarter).expect("valid");
            let stop = Stop::new(normal.clone(), normal.dot(&q), e[i]).expect("valid");
            stop.with_motion(Some(StopMotion::harmonic(motion).expect("valid")))
        };
        let system =
            LinearSystem::new(mass, DMatrix::zeros(2, 2), DMatrix::identity(2, 2)).expect("valid");
        let scene = Scene::new(system, Forcing::Unforced, [stop(0), stop(1)]).expect("valid");
        let opening = &moved - normals.tr_mul(&v);
        let slack = DVector::from_element(2, 1e-13);
        let expected = match (opening[0] < 0.0, opening[1] < 0.0) {
            (false, false) => continue,
            // One that is not approached is in contact all the same: it may be pushed into.
            _ => resolve_impacts(&body.delassus(), &e, &opening, &slack).expect("resolved"),
        };
        let after = &v - &body.reactions * &expected.impulses;
        for method in [Method::Exact, Method::Dop853, Method::Radau] {
            let options = SimulateOptions {
                solver: method.into(),
                ..SimulateOptions::default()
            };
            let run = simulate(&scene, &q, &v, (0.0, 1e-6), &options).expect("a run");
            let (_, found) = run.state(0.0, ImpactSide::After).expect("kept");
            let off = (&found - &after).amax();
            assert!(
                off < 1e-9 * v.amax().max(1.0),
                "{case} {method:?}: {found} {after}"
            );
        }
        let pushed = expected.impulses.iter().filter(|&&p| p > 0.0).count();
        *(if pushed == 2 {
            &mut together
        } else {
            &mut one_by_one
        }) += 1;
    }
    assert!(together > 40 && one_by_one > 20, "{together} {one_by_one}");
}
