//! The energy ledger: every entry against a closed form somewhere, and the balance everywhere (theory 9).

use nalgebra::{DVector, dmatrix, dvector};
use vibroimpact::{
    BaseMotion, DoublePendulum, Energy, Forcing, Harmonic, LinearSystem, Method, PendulumChain,
    Reaction, Scene, Side, SimulateOptions, Stop, Trajectory, Wall, WallSide, simulate,
};

const RTOL: f64 = 1e-9;

fn run(scene: &Scene, q: DVector<f64>, v: DVector<f64>, end: f64, method: Method) -> Trajectory {
    let options = SimulateOptions {
        method,
        rtol: RTOL,
        ..Default::default()
    };
    simulate(scene, &q, &v, (0.0, end), &options).expect("runs")
}

/// The balance is zero within ten tolerances of the largest entry.
fn assert_balanced(energy: &Energy, what: &str) {
    let largest = [
        &energy.kinetic,
        &energy.potential,
        &energy.forcing_work,
        &energy.damping_loss,
        &energy.impact_loss,
    ]
    .iter()
    .flat_map(|terms| terms.iter())
    .fold(0.0f64, |a, x| a.max(x.abs()));
    let worst = energy.balance.iter().fold(0.0f64, |a, x| a.max(x.abs()));
    assert!(
        worst <= 10.0 * RTOL * largest,
        "{what}: {:e}",
        worst / largest
    );
}

#[test]
fn a_ball_loses_its_closed_form_energy_at_each_impact_and_all_of_it_in_the_end() {
    let system = LinearSystem::new(dvector![2.0], dvector![0.0], dvector![0.0])
        .expect("valid")
        .with_load(dvector![-6.0])
        .expect("valid");
    let floor = Stop::new(0, 0.0, 0.8).expect("valid").on_side(Side::Lower);
    let scene = Scene::new(system, Forcing::Unforced, [floor]).expect("valid");
    for method in [Method::Exact, Method::Rk45] {
        let run = run(&scene, dvector![1.0], dvector![0.0], 12.0, method);
        let energy = run.energy().expect("kept");
        assert_balanced(&energy, "ball");
        // Mass 2, weight 6, height 1: six units of energy, e^2 of them left after each impact.
        let (times, _, _) = run.samples().expect("kept");
        for (k, impact) in run.impacts().iter().enumerate() {
            let after = times
                .iter()
                .rposition(|&t| t == impact.time)
                .expect("drawn on both sides");
            let left = 6.0 * 0.64f64.powi(i32::try_from(k + 1).expect("few"));
            assert!(
                (energy.impact_loss[after] - (6.0 - left)).abs() < 1e-8,
                "{method:?} {k}"
            );
        }
        assert!((energy.impact_loss.last().expect("there") - 6.0).abs() < 1e-8);
        assert_eq!(energy.forcing_work.last(), Some(&0.0));
    }
}

#[test]
fn a_damped_forced_oscillator_loses_what_its_dampers_take() {
    // The steady response: work and loss per period are pi c w A^2, equal.
    let system = LinearSystem::new(dmatrix![1.0], dmatrix![0.2], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], 0.7, 0.0).expect("valid");
    let scene = Scene::new(system, force, Vec::<Stop>::new()).expect("valid");
    let y = nalgebra::Complex::new(1.0 - 0.49, 0.14).inv();
    let period = std::f64::consts::TAU / 0.7;
    for method in [Method::Exact, Method::Rk45] {
        let run = run(
            &scene,
            dvector![y.re],
            dvector![-0.7 * y.im],
            period,
            method,
        );
        let energy = run.energy().expect("kept");
        assert_balanced(&energy, "steady");
        let loss = std::f64::consts::PI * 0.2 * 0.7 * y.norm_sqr();
        assert!((energy.damping_loss.last().expect("there") / loss - 1.0).abs() < 1e-8);
        assert!((energy.forcing_work.last().expect("there") / loss - 1.0).abs() < 1e-8);
    }
}

#[test]
fn every_kind_of_scene_balances() {
    for reaction in [Reaction::Inertia, Reaction::Coordinate] {
        let system = LinearSystem::new(
            dmatrix![2.0, 0.5; 0.5, 1.0],
            dmatrix![0.1, 0.05; -0.05, 0.2],
            dmatrix![3.0, -1.0; -0.8, 2.0],
        )
        .expect("valid")
        .with_load(dvector![0.3, 0.1])
        .expect("valid");
        let stop = Stop::new(0, 0.1, 0.5)
            .expect("valid")
            .with_reaction(reaction.clone())
            .expect("valid");
        let force = Harmonic::new(dvector![1.0.into(), 0.5.into()], 0.3, 0.4).expect("valid");
        let scene = Scene::new(system, force, [stop]).expect("valid");
        for method in [Method::Exact, Method::Rk45] {
            let run = run(&scene, dvector![0.0, 0.0], dvector![0.0, 0.0], 50.0, method);
            assert!(
                run.segments()
                    .expect("kept")
                    .iter()
                    .any(|s| s.stop.is_some())
            );
            assert_balanced(
                &run.energy().expect("kept"),
                &format!("{reaction:?} {method:?}"),
            );
        }
    }
    let pendulum = DoublePendulum::new(1.0, 2.0, (0.05, 0.02)).expect("valid");
    let base = BaseMotion::new(0.3, 1.2, 0.0).expect("valid");
    let wall = Wall::new(1, 0.4, 0.7, WallSide::Right).expect("valid");
    let scene = Scene::new(pendulum, base, [wall]).expect("valid");
    let run_1 = run(
        &scene,
        dvector![0.0, 0.0],
        dvector![0.3, 0.0],
        40.0,
        Method::Auto,
    );
    assert!(run_1.impacts().len() > 3);
    assert_balanced(&run_1.energy().expect("kept"), "pendulum");

    let chain = PendulumChain::new(
        dvector![1.0, 0.5, 2.0],
        dvector![0.5, 0.4, 0.3],
        &dvector![0.1, 0.05, 0.02],
        9.81,
    )
    .expect("valid");
    let base = BaseMotion::new(0.05, 4.0, 0.5).expect("valid");
    let wall = Wall::new(2, -0.5, 0.6, WallSide::Left).expect("valid");
    let scene = Scene::new(chain, base, [wall]).expect("valid");
    let still = DVector::zeros(3);
    let run_2 = run(
        &scene,
        still.clone(),
        still.add_scalar(1.5),
        10.0,
        Method::Auto,
    );
    assert_balanced(&run_2.energy().expect("kept"), "chain");
}

#[test]
fn the_ledger_at_asked_times_is_the_one_along_the_way() {
    let system = LinearSystem::new(dmatrix![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], 0.8, 0.0).expect("valid");
    let scene = Scene::new(system, force, [Stop::new(0, 0.3, 0.7).expect("valid")]).expect("valid");
    let options = SimulateOptions {
        t_eval: Some((0..=50).map(f64::from).collect()),
        ..Default::default()
    };
    let run = simulate(
        &scene,
        &dvector![0.0],
        &dvector![0.0],
        (0.0, 50.0),
        &options,
    )
    .expect("runs");
    let energy = run.energy().expect("kept");
    assert_eq!(energy.balance.len(), 51);
    assert_balanced(&energy, "asked times");
    assert!(energy.impact_loss.windows(2).all(|w| w[1] >= w[0]));
}
