//! A double pendulum that swings into a wall: from the linear orbit to the one with large angles.
//!
//! Two links hang from a base that moves to and fro; a vertical wall, which moves with the base, stops the lower bob. You
//! will see the orbit of the linearised pendulum, in closed form, beside the one that `find_orbit` reaches from it, and that the
//! difference is of second order in the size of the motion; a run from rest that settles on it; the balance of work and losses
//! over one period; and the multipliers beside the simulated return map. `wall_pendulum.py` draws it and makes it move.

use std::f64::consts::TAU;
use vibroimpact::nalgebra::{DMatrix, DVector, dvector};
use vibroimpact::{
    BaseMotion, Energy, ImpactSide, Motion, OrbitOptions, Pattern, PendulumChain, PeriodicOrbit,
    Result, Scene, SimulateOptions, Solver, Wall, WallSide, find_orbit, linearise, periodic_orbits,
    simulate,
};

const PERIOD: f64 = 1.25; // of the base [s]
const AMPLITUDE: f64 = 0.03; // of the base [m]
const POSITION: f64 = 0.12; // of the wall, to the right of the base [m]
const RESTITUTION: f64 = 0.7;

/// Pendulum and wall; `size` scales the motion of the base and the way to the wall alike.
fn pendulum(size: f64) -> Result<Scene> {
    let (masses, lengths) = (dvector![1.0, 0.5], dvector![0.5, 0.3]);
    let chain = PendulumChain::new(masses, lengths, &dvector![0.02, 0.02], 9.81)?;
    let base = BaseMotion::new(size * AMPLITUDE, TAU / PERIOD, 0.0)?;
    let wall = Wall::new(1, size * POSITION, RESTITUTION, WallSide::Right)?;
    Scene::new(chain, base, [wall])
}

/// The orbit of the linearised pendulum that hits the wall once in each period, and the real one near it.
fn linear_and_real(size: f64) -> Result<(PeriodicOrbit, PeriodicOrbit)> {
    let scene = pendulum(size)?;
    let orbits = periodic_orbits(
        &linearise(&scene)?,
        &Pattern::single(0),
        &OrbitOptions::default(),
    )?;
    let real = find_orbit(&scene, &orbits[0], None)?;
    Ok((orbits[0].clone(), real))
}

/// By how much the linear orbit's speed at the wall is wrong, relatively.
fn difference(size: f64) -> Result<f64> {
    let (linear, real) = linear_and_real(size)?;
    Ok((linear.impacts()[0].approach / real.impacts()[0].approach - 1.0).abs())
}

/// The real orbit, which the linear one approaches by the square of the size.
fn check_orbits() -> Result<PeriodicOrbit> {
    let (linear, real) = linear_and_real(1.0)?;
    for (name, orbit) in [("linear", &linear), ("real", &real)] {
        println!(
            "{name:<7} speed at the wall {:.9}, phase {:.9}, largest multiplier {:.6}",
            orbit.impacts()[0].approach,
            orbit.phase(),
            orbit.stability()?.orders[0].spectral_radius()
        );
    }
    assert!(real.is_admissible() == Some(true) && real.stability()?.is_stable == Some(true));
    let (small, smaller) = (difference(0.1)?, difference(0.01)?);
    println!(
        "the linear speed is wrong by {:.1e}, in a motion a tenth as large by {small:.1e}, a hundredth {smaller:.1e}",
        difference(1.0)?
    );
    assert!((95.0..105.0).contains(&(small / smaller)));
    Ok(real)
}

/// The last entry of a ledger's column less the first.
fn gain(column: &[f64]) -> f64 {
    column[column.len() - 1] - column[0]
}

/// From rest the pendulum settles on the orbit; over a period of that the work of the base is what dampers and wall take.
fn check_runs(real: &PeriodicOrbit) -> Result<()> {
    let rest = dvector![0.0, 0.0];
    let options = SimulateOptions::default();
    let run = simulate(
        &pendulum(1.0)?,
        &rest,
        &rest,
        (0.0, 40.0 * PERIOD),
        &options,
    )?;
    let (last, speed) = (
        run.impacts()[run.impacts().len() - 1].approach,
        real.impacts()[0].approach,
    );
    println!("from rest: the last impact at {last:.9}, the orbit's {speed:.9}");
    assert!((last - speed).abs() < 1e-6);
    let options = SimulateOptions {
        solver: Solver {
            rtol: 1e-11,
            ..Solver::default()
        },
        t_eval: Some(vec![0.5 * PERIOD, 1.5 * PERIOD]),
        ..Default::default()
    };
    let span = (0.0, 2.0 * PERIOD);
    let Energy {
        forcing_work,
        damping_loss,
        impact_loss,
        ..
    } = simulate(real.scene(), &real.q0(), &real.v0(), span, &options)?.energy()?;
    let (work, dampers, wall) = (gain(&forcing_work), gain(&damping_loss), gain(&impact_loss));
    println!(
        "in a period the base does {work:.6} J, dampers take {dampers:.6} J, the wall {wall:.6} J"
    );
    assert!((work - dampers - wall).abs() < 1e-8 * work);
    Ok(())
}

/// The state one period later, from the middle of the orbit's flight.
fn after_a_period(real: &PeriodicOrbit, x: &DVector<f64>) -> Result<DVector<f64>> {
    let options = SimulateOptions {
        solver: Solver {
            rtol: 1e-12,
            atol: Some(1e-14),
            ..Solver::default()
        },
        ..Default::default()
    };
    let (q, v) = (x.rows(0, 2).into_owned(), x.rows(2, 2).into_owned());
    let run = simulate(real.scene(), &q, &v, (0.5 * PERIOD, 1.5 * PERIOD), &options)?;
    let (q, v) = run.last();
    Ok(dvector![q[0], q[1], v[0], v[1]])
}

/// Sum and product of the multipliers are trace and determinant of the simulated return map, by central differences.
fn check_multipliers(real: &PeriodicOrbit) -> Result<()> {
    let (q, v) = real.state(0.5 * PERIOD, ImpactSide::After)?;
    let start = dvector![q[0], q[1], v[0], v[1]];
    let step = 1e-5;
    let mut map = DMatrix::zeros(4, 4);
    for j in 0..4 {
        let mut shift = DVector::zeros(4);
        shift[j] = step;
        let change =
            after_a_period(real, &(&start + &shift))? - after_a_period(real, &(&start - &shift))?;
        map.set_column(j, &(change / (2.0 * step)));
    }
    let multipliers = &real.stability()?.orders[0].multipliers;
    let (sum, product) = (multipliers.sum().re, multipliers.product().re);
    println!(
        "multipliers: sum {sum:.9}, simulated {:.9}; product {product:.9}, simulated {:.9}",
        map.trace(),
        map.determinant()
    );
    assert!((sum - map.trace()).abs() < 1e-6);
    assert!((product - map.determinant()).abs() < 1e-6);
    Ok(())
}

fn main() -> Result<()> {
    let real = check_orbits()?;
    check_runs(&real)?;
    check_multipliers(&real)
}
