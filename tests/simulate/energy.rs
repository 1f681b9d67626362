//! The energy ledger: every entry against a closed form somewhere, and the balance everywhere (theory 9).

use crate::scenes::{BOTH, harmonic, linear, loaded, lower, oscillator, run, scene, upper, with};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use vibroimpact::{
    BaseMotion, Change, DoublePendulum, Energy, EquationsOfMotion, Forcing, Harmonic, Method,
    Motion, NonlinearSystem, PendulumChain, Reaction, Result, Scene, SegmentKind, SimulateOptions,
    Solver, Stop, Wall, WallSide, simulate,
};

const RTOL: f64 = 1e-9;

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
    let system = loaded(linear(dvector![2.0], dvector![0.0], dvector![0.0]), &[-6.0]);
    let scene = scene(system, Forcing::Unforced, [lower(0, 0.0, 0.8)]);
    for method in BOTH {
        let run = run(&scene, &[1.0], &[0.0], 12.0, &with(method, RTOL));
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
    let scene = oscillator(0.2, harmonic(&[1.0], 0.7, 0.0), Vec::<Stop>::new());
    let y = nalgebra::Complex::new(1.0 - 0.49, 0.14).inv();
    let period = std::f64::consts::TAU / 0.7;
    for method in BOTH {
        let run = run(&scene, &[y.re], &[-0.7 * y.im], period, &with(method, RTOL));
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
        let system = loaded(
            linear(
                dmatrix![2.0, 0.5; 0.5, 1.0],
                dmatrix![0.1, 0.05; -0.05, 0.2],
                dmatrix![3.0, -1.0; -0.8, 2.0],
            ),
            &[0.3, 0.1],
        );
        let stop = upper(0, 0.1, 0.5)
            .with_reaction(reaction.clone())
            .expect("valid");
        let scene = scene(system, harmonic(&[1.0, 0.5], 0.3, 0.4), [stop]);
        for method in BOTH {
            let run = run(&scene, &[0.0; 2], &[0.0; 2], 50.0, &with(method, RTOL));
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
    let usual = with(Method::Auto, RTOL);
    let pair = scene(pendulum, base, [wall]);
    let run_1 = run(&pair, &[0.0; 2], &[0.3, 0.0], 40.0, &usual);
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
    let three = scene(chain, base, [wall]);
    let run_2 = run(&three, &[0.0; 3], &[1.5; 3], 10.0, &usual);
    assert_balanced(&run_2.energy().expect("kept"), "chain");
}

#[test]
fn the_ledger_at_asked_times_is_the_one_along_the_way() {
    let scene = oscillator(0.1, harmonic(&[1.0], 0.8, 0.0), [upper(0, 0.3, 0.7)]);
    let options = SimulateOptions {
        t_eval: Some((0..=50).map(f64::from).collect()),
        ..Default::default()
    };
    let run = run(&scene, &[0.0], &[0.0], 50.0, &options);
    let energy = run.energy().expect("kept");
    assert_eq!(energy.balance.len(), 51);
    assert_balanced(&energy, "asked times");
    assert!(energy.impact_loss.windows(2).all(|w| w[1] >= w[0]));
}

/// Eq. (3) of the double pendulum, its mass matrix and potential as functions.
struct Functions {
    pendulum: DoublePendulum,
    knows: [bool; 2],
    drive: f64,
}

impl Functions {
    fn scene(pendulum: &DoublePendulum, knows: [bool; 2], drive: f64, force: bool) -> Scene {
        let functions = Self {
            pendulum: pendulum.clone(),
            knows,
            drive,
        };
        let system = NonlinearSystem::new(functions).expect("two angles");
        let amplitude = dvector![0.1.into(), 0.2.into()];
        let force = if force {
            Harmonic::new(amplitude, 1.3, 0.4).expect("valid").into()
        } else {
            Forcing::Unforced
        };
        let reaction = if knows[0] {
            Reaction::Inertia
        } else {
            Reaction::Coordinate
        };
        let stop = Stop::new(1, 0.2, 0.4).and_then(|s| s.with_reaction(reaction));
        scene(system, force, [stop.expect("valid")])
    }
}

impl EquationsOfMotion for Functions {
    fn n_dof(&self) -> usize {
        2
    }
    fn acceleration(&self, t: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        let linear = self.pendulum.linearise()?;
        let (m, k) = (linear.mass().to_dense(), linear.stiffness().to_dense());
        let turn = m[(0, 1)] * (q[0] - q[1]).sin();
        let whirl = dvector![-turn * v[1] * v[1], turn * v[0] * v[0]];
        let weight = dvector![-k[(0, 0)] * q[0].sin(), -k[(1, 1)] * q[1].sin()];
        let dampers = -(self.pendulum.damping() * DVector::from_column_slice(v));
        let drive = dvector![self.drive * (1.3 * t).cos(), 0.0];
        let force = whirl + weight + dampers + drive;
        let solved = self.mass(q)?.lu().solve(&force).expect("a mass matrix");
        a.copy_from_slice(solved.as_slice());
        Ok(())
    }
    fn has_mass(&self) -> bool {
        self.knows[0]
    }
    fn mass(&self, q: &[f64]) -> Result<DMatrix<f64>> {
        let mut m = self.pendulum.linearise()?.mass().to_dense();
        m[(0, 1)] *= (q[0] - q[1]).cos();
        m[(1, 0)] = m[(0, 1)];
        Ok(m)
    }
    fn potential(&self, q: &[f64]) -> Result<Option<f64>> {
        let k = self.pendulum.linearise()?.stiffness().to_dense();
        let height = |i: usize| k[(i, i)] * (1.0 - q[i].cos());
        Ok(self.knows[1].then(|| height(0) + height(1)))
    }
}

#[test]
fn functions_have_the_ledger_of_the_system_that_they_write_out() {
    let pendulum = DoublePendulum::new(1.0, 2.0, (0.05, 0.02)).expect("valid");
    let functions = Functions::scene(&pendulum, [true, true], 0.0, true);
    let known = functions
        .replace(Change::System(pendulum.clone().into()))
        .expect("fits");
    let ledger = |scene: &Scene| {
        let options = SimulateOptions {
            solver: Solver {
                rtol: RTOL,
                ..Solver::default()
            },
            t_eval: Some((0..=80).map(|i| 0.5 * f64::from(i)).collect()),
            ..Default::default()
        };
        let start = (dvector![0.3, -0.6], dvector![0.5, 0.2]);
        let run = simulate(scene, &start.0, &start.1, (0.0, 40.0), &options).expect("runs");
        assert!(run.impacts().len() > 5, "{}", run.message());
        run.energy().expect("kept")
    };
    let (one, other) = (ledger(&functions), ledger(&known));
    assert_balanced(&one, "functions");
    let pairs = [
        (&one.kinetic, &other.kinetic),
        (&one.potential, &other.potential),
        (&one.forcing_work, &other.forcing_work),
        (&one.damping_loss, &other.damping_loss),
        (&one.impact_loss, &other.impact_loss),
    ];
    for (name, (a, b)) in ["T", "V", "F", "C", "impacts"].iter().zip(pairs) {
        let largest = b.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() < 1e-6 * largest, "{name}: {a} {b}");
        }
    }
}

#[test]
fn a_drive_among_the_functions_brings_what_dampers_take_not() {
    // The same drive as a forcing and in the acceleration: what the one ledger has as work, the other has as negative loss.
    let pendulum = DoublePendulum::new(1.0, 2.0, (0.0, 0.0)).expect("valid");
    let scene = Functions::scene(&pendulum, [true, true], 0.1, false);
    let ledger = |scene: &Scene| {
        let run = run(scene, &[0.1; 2], &[0.0; 2], 20.0, &with(Method::Auto, RTOL));
        run.energy().expect("kept")
    };
    let energy = ledger(&scene);
    assert_balanced(&energy, "drive");
    let force = harmonic(&[0.1, 0.0], 1.3, 0.0);
    let forced = scene
        .replace(Change::System(pendulum.into()))
        .expect("fits");
    let forced = forced.replace(Change::Forcing(force)).expect("fits");
    let other = ledger(&forced);
    let (brought, work) = (energy.damping_loss.last(), other.forcing_work.last());
    let (brought, work) = (-brought.expect("there"), work.expect("there"));
    assert!(
        work.abs() > 1e-3 && (brought - work).abs() < 1e-7,
        "{brought} {work}"
    );
}

#[test]
fn functions_in_lasting_contact_balance() {
    /// An oscillator pressed to its stop and drawn off again by a slow drive.
    struct Pressed;
    impl EquationsOfMotion for Pressed {
        fn n_dof(&self) -> usize {
            1
        }
        fn acceleration(&self, t: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
            a[0] = 0.5 * (-q[0] - q[0].powi(3) - 0.2 * v[0] + (0.3 * t).cos());
            Ok(())
        }
        fn has_mass(&self) -> bool {
            true
        }
        fn mass(&self, _q: &[f64]) -> Result<DMatrix<f64>> {
            Ok(dmatrix![2.0])
        }
        fn potential(&self, q: &[f64]) -> Result<Option<f64>> {
            Ok(Some(0.5 * q[0].powi(2) + 0.25 * q[0].powi(4)))
        }
    }
    let system = NonlinearSystem::new(Pressed).expect("one coordinate");
    let scene = scene(system, Forcing::Unforced, [upper(0, 0.1, 0.5)]);
    let run = run(&scene, &[0.0], &[0.0], 60.0, &with(Method::Auto, RTOL));
    let kinds = run.segments().expect("kept");
    assert!(kinds.iter().any(|s| s.kind == SegmentKind::Stick));
    assert_balanced(&run.energy().expect("kept"), "pressed");
}

#[test]
fn a_ledger_of_functions_needs_mass_and_potential() {
    let pendulum = DoublePendulum::new(1.0, 2.0, (0.05, 0.02)).expect("valid");
    for (knows, lack) in [([false, true], "`mass`"), ([true, false], "`potential`")] {
        let scene = Functions::scene(&pendulum, knows, 0.0, false);
        let run = run(
            &scene,
            &[0.1, 0.0],
            &[0.0; 2],
            1.0,
            &with(Method::Auto, RTOL),
        );
        let message = run.energy().expect_err("not known").to_string();
        let start = format!("system is a NonlinearSystem without {lack}, but the energy ledger");
        assert!(message.starts_with(&start), "{message}");
    }
}
