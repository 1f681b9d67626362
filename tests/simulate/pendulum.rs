//! Pendulums with large angles, integrated in steps: laws of mechanics with and without impacts on walls and stops.

use crate::random::Random;
use nalgebra::{DMatrix, DVector, dvector};
use vibroimpact::{
    BaseMotion, DoublePendulum, Forcing, ImpactSide, Motion, PendulumChain, Scene, SimulateOptions,
    Solver, Status, Stop, Trajectory, Wall, WallSide, linearise, simulate,
};

const NO_STOPS: [Stop; 0] = [];

/// A chain in physical units, written down once more from the Lagrangian.
struct Chain {
    masses: Vec<f64>,
    lengths: Vec<f64>,
    gravity: f64,
}

impl Chain {
    fn below(&self, k: usize) -> f64 {
        self.masses[k..].iter().sum()
    }

    fn mass(&self, q: &DVector<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(q.len(), q.len(), |i, j| {
            self.lengths[i] * self.lengths[j] * self.below(i.max(j)) * (q[i] - q[j]).cos()
        })
    }

    /// Kinetic and potential energy of the bobs, from their Cartesian positions and velocities.
    fn energy(&self, q: &DVector<f64>, v: &DVector<f64>) -> f64 {
        let (mut velocity, mut height, mut energy) = ([0.0, 0.0], 0.0, 0.0);
        for i in 0..q.len() {
            velocity[0] += self.lengths[i] * q[i].cos() * v[i];
            velocity[1] += self.lengths[i] * q[i].sin() * v[i];
            height -= self.lengths[i] * q[i].cos();
            let speed = velocity[0] * velocity[0] + velocity[1] * velocity[1];
            energy += self.masses[i] * (0.5 * speed + self.gravity * height);
        }
        energy
    }

    fn reach(&self, bob: usize, q: &DVector<f64>) -> f64 {
        (0..=bob).map(|i| self.lengths[i] * q[i].sin()).sum()
    }

    fn system(&self) -> PendulumChain {
        PendulumChain::new(
            DVector::from_vec(self.masses.clone()),
            DVector::from_vec(self.lengths.clone()),
            &DVector::zeros(self.masses.len()),
            self.gravity,
        )
        .expect("valid")
    }
}

fn five() -> Chain {
    Chain {
        masses: vec![1.0, 0.5, 2.0, 0.7, 0.3],
        lengths: vec![0.5, 0.3, 0.4, 0.2, 0.6],
        gravity: 9.81,
    }
}

/// The double pendulum of mass ratio m and length ratio mu as a chain: `M_11 = 1`, gravity `1/(1 + m)`.
fn pair(m: f64, mu: f64) -> Chain {
    Chain {
        masses: vec![1.0 / (1.0 + m), m / (1.0 + m)],
        lengths: vec![1.0, 1.0 / mu],
        gravity: 1.0 / (1.0 + m),
    }
}

fn tight() -> SimulateOptions {
    SimulateOptions {
        solver: Solver {
            rtol: 1e-12,
            atol: Some(1e-13),
            ..Solver::default()
        },
        ..Default::default()
    }
}

fn run(scene: &Scene, q: &DVector<f64>, v: &DVector<f64>, end: f64) -> Trajectory {
    let run = simulate(scene, q, v, (0.0, end), &tight()).expect("runs");
    assert_eq!(run.status(), Status::Finished, "{}", run.message());
    run
}

#[test]
fn energy_is_kept_without_damping_and_forcing() {
    let chain = pair(3.0, 1.5);
    let scene = Scene::new(
        DoublePendulum::new(3.0, 1.5, (0.0, 0.0)).expect("valid"),
        Forcing::Unforced,
        NO_STOPS,
    );
    let (q, v) = (dvector![2.0, -1.0], dvector![0.1, 0.4]);
    let (q1, v1) = {
        let end = run(&scene.expect("valid"), &q, &v, 50.0);
        (end.last().0.clone(), end.last().1.clone())
    };
    let change = chain.energy(&q1, &v1) - chain.energy(&q, &v);
    assert!(change.abs() < 1e-10, "{change:e}");

    let chain = five();
    let scene = Scene::new(chain.system(), Forcing::Unforced, NO_STOPS).expect("valid");
    let (q, v) = (
        dvector![1.5, 1.0, -0.5, 2.0, 0.3],
        dvector![0.0, 1.0, 0.0, -2.0, 0.0],
    );
    let end = run(&scene, &q, &v, 5.0);
    let energy = chain.energy(&q, &v);
    let change = chain.energy(end.last().0, end.last().1) - energy;
    assert!(change.abs() < 1e-9 * energy.abs(), "{change:e} of {energy}");
}

#[test]
fn the_chain_of_two_moves_as_the_double_pendulum_in_other_units() {
    let (m1, m2, l1, l2, g) = (2.0, 1.0, 0.7, 0.3, 9.81);
    let (c1, c2) = (0.4, 0.25);
    let m: f64 = m2 / m1;
    let rate = (g / l1 * (1.0 + m)).sqrt();
    let unit = rate * (m1 + m2) * l1 * l1;
    let (amplitude, frequency, phase) = (0.06, 0.9 * rate, 0.4);
    let wall = |unit: f64| Wall::new(1, 0.3 / unit, 0.7, WallSide::Right).expect("valid");
    let chain = Scene::new(
        PendulumChain::new(dvector![m1, m2], dvector![l1, l2], &dvector![c1, c2], g)
            .expect("valid"),
        BaseMotion::new(amplitude, frequency, phase).expect("valid"),
        [wall(1.0)],
    )
    .expect("valid");
    let double = Scene::new(
        DoublePendulum::new(m, l1 / l2, (c1 / unit, c2 / unit)).expect("valid"),
        BaseMotion::new(amplitude / l1, frequency / rate, phase).expect("valid"),
        [wall(l1)],
    )
    .expect("valid");
    let (q, v) = (dvector![-1.2, -0.4], dvector![0.5, -0.3]);
    let end = 20.0;
    let one = run(&chain, &q, &(&v * rate), end / rate);
    let other = run(&double, &q, &v, end);
    assert!(one.impacts().len() > 1);
    assert_eq!(one.impacts().len(), other.impacts().len());
    for (a, b) in one.impacts().iter().zip(other.impacts()) {
        assert!((a.time * rate - b.time).abs() < 1e-9);
        assert!((a.approach / (rate * l1) - b.approach).abs() < 1e-9);
    }
    assert!((one.last().0 - other.last().0).amax() < 1e-9);
    assert!((one.last().1 / rate - other.last().1).amax() < 1e-9);
}

/// Energy right before and right after each impact of a run, with the normal of its wall.
fn losses(
    chain: &Chain,
    run: &Trajectory,
    normal: impl Fn(&DVector<f64>) -> DVector<f64>,
) -> Vec<[f64; 3]> {
    run.impacts()
        .iter()
        .map(|impact| {
            let (q, before) = run.state(impact.time, ImpactSide::Before).expect("kept");
            let (_, after) = run.state(impact.time, ImpactSide::After).expect("kept");
            let n = normal(&q);
            let solved = chain.mass(&q).lu().solve(&n).expect("regular");
            let effective = 1.0 / n.dot(&solved);
            [
                chain.energy(&q, &before) - chain.energy(&q, &after),
                0.5 * effective * impact.approach.powi(2),
                n.dot(&before) - impact.approach,
            ]
        })
        .collect()
}

#[test]
fn wall_impacts_lose_what_their_restitution_says_and_no_bob_passes() {
    let mut random = Random::new(0x5eed);
    for restitution in [1.0, 0.6, 0.95] {
        for (chain, bob, position, side, end) in [
            (pair(1.0, 1.0), 1, 0.3, WallSide::Right, 20.0),
            (pair(0.4, 2.0), 0, -0.2, WallSide::Left, 20.0),
            (five(), 4, 0.25, WallSide::Right, 2.0),
            (five(), 2, -0.1, WallSide::Left, 2.0),
        ] {
            let n = chain.masses.len();
            let sign = if side == WallSide::Right { 1.0 } else { -1.0 };
            let wall = Wall::new(bob, position, restitution, side).expect("valid");
            let scene = Scene::new(chain.system(), Forcing::Unforced, [wall]).expect("valid");
            // On the free side of the wall, at large angles.
            let q = DVector::from_fn(n, |_, _| -sign * random.between(0.2, 1.3));
            let v = random.vector(n);
            let run = run(&scene, &q, &v, end);
            assert!(!run.impacts().is_empty());
            let normal = |q: &DVector<f64>| {
                DVector::from_fn(n, |i, _| {
                    if i <= bob {
                        sign * chain.lengths[i] * q[i].cos()
                    } else {
                        0.0
                    }
                })
            };
            let scale = chain.energy(&q, &v).abs();
            for [lost, energy, speed] in losses(&chain, &run, normal) {
                let law = energy * (1.0 - restitution * restitution);
                assert!((lost - law).abs() < 1e-11 * scale, "{lost} {law}");
                assert!(speed.abs() < 1e-10, "{speed:e}");
            }
            let total: f64 = losses(&chain, &run, normal).iter().map(|l| l[0]).sum();
            let (q1, v1) = run.last();
            let drift = chain.energy(q1, v1) + total - chain.energy(&q, &v);
            assert!(drift.abs() < 1e-9 * scale, "{drift:e} of {scale}");
            for k in 0..=2000 {
                let (q, _) = run
                    .state(end * f64::from(k) / 2000.0, ImpactSide::After)
                    .expect("kept");
                let gap = sign * (position - chain.reach(bob, &q));
                assert!(gap > -1e-9, "{gap:e}");
            }
        }
    }
}

#[test]
fn a_joint_angle_stop_turns_the_angle_alone() {
    let chain = pair(1.0, 1.2);
    let e = 0.8;
    let stop = Stop::new(0, 0.4, e).expect("valid");
    let scene = Scene::new(
        DoublePendulum::new(1.0, 1.2, (0.0, 0.0)).expect("valid"),
        Forcing::Unforced,
        [stop],
    )
    .expect("valid");
    let (q, v) = (dvector![-1.0, -0.8], dvector![0.0, 0.0]);
    let run = run(&scene, &q, &v, 30.0);
    assert!(run.impacts().len() > 2);
    for [lost, energy, _] in losses(&chain, &run, |_| dvector![1.0, 0.0]) {
        assert!((lost - energy * (1.0 - e * e)).abs() < 1e-11);
    }
    for impact in run.impacts() {
        let (q, _) = run.state(impact.time, ImpactSide::After).expect("kept");
        assert!((q[0] - 0.4).abs() < 1e-11);
        assert!((impact.departure - e * impact.approach).abs() < 1e-14);
    }
}

#[test]
fn small_motions_are_those_of_the_linear_scene() {
    // The difference is of third order in the size of the motion, impacts included.
    let size = 1e-4;
    let scene = Scene::new(
        DoublePendulum::new(1.0, 1.0, (0.05, 0.02)).expect("valid"),
        BaseMotion::new(0.3 * size, 1.7, 0.2).expect("valid"),
        [Wall::new(1, 0.5 * size, 0.9, WallSide::Right).expect("valid")],
    )
    .expect("valid");
    let (q, v) = (dvector![-size, 0.5 * size], dvector![0.3 * size, size]);
    let linear = linearise(&scene).expect("an equilibrium");
    let options = SimulateOptions {
        solver: Solver {
            rtol: 1e-12,
            atol: Some(1e-12 * size),
            ..Solver::default()
        },
        ..Default::default()
    };
    let large = simulate(&scene, &q, &v, (0.0, 15.0), &options).expect("runs");
    let small = simulate(&linear, &q, &v, (0.0, 15.0), &options).expect("runs");
    assert!(small.impacts().len() > 2 && small.stats().n_steps == 0);
    assert_eq!(large.impacts().len(), small.impacts().len());
    for (a, b) in large.impacts().iter().zip(small.impacts()) {
        assert!((a.time - b.time).abs() < 1e-6, "{} {}", a.time, b.time);
    }
    let difference = (large.last().0 - small.last().0).amax();
    assert!(difference < 1e-6 * size, "{difference:e}");
}

#[test]
fn a_mirrored_scene_moves_as_the_mirror_image() {
    let scene = |sign: f64, side: WallSide| {
        let phase = if sign > 0.0 {
            0.3
        } else {
            0.3 + std::f64::consts::PI
        };
        Scene::new(
            five().system(),
            BaseMotion::new(0.05, 7.0, phase).expect("valid"),
            [Wall::new(3, sign * 0.3, 0.8, side).expect("valid")],
        )
        .expect("valid")
    };
    let (q, v) = (
        dvector![-0.5, -0.3, -0.2, 0.1, 0.4],
        dvector![0.0, 1.0, 0.5, 0.0, 0.0],
    );
    let one = run(&scene(1.0, WallSide::Right), &q, &v, 2.0);
    let other = run(&scene(-1.0, WallSide::Left), &-&q, &-&v, 2.0);
    assert!(!one.impacts().is_empty());
    assert_eq!(one.impacts().len(), other.impacts().len());
    assert!((one.last().0 + other.last().0).amax() < 1e-8);
}
