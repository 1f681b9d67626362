//! Two frames that pound against each other in an earthquake.
//!
//! Two buildings of two storeys stand 20 mm apart, a stiff one of 3 Hz and a soft one of 1.4 Hz; roofs and first floors may hit each other:
//! stops on the difference of two coordinates. The ground follows a record made here as records look: an oscillator, the soil, on noise
//! under an envelope, 20 s at 100 samples a second; exact flights follow it from sample to sample. You will see the impacts, the energies,
//! and the first impacts beside those by the Radau method. `ground_motion.py` draws a record of its own.

use std::f64::consts::TAU;
use vibroimpact::nalgebra::{DMatrix, DVector, dvector};
use vibroimpact::{
    BaseAcceleration, Keep, LinearSystem, Method, Motion, Result, Scene, Signal, SimulateOptions,
    Stop, rayleigh_damping, simulate,
};

/// The record: length \[s\], samples a second, peak \[m/s^2\].
const DURATION: f64 = 20.0;
const RATE: f64 = 100.0;
const PEAK: f64 = 3.5;
const ROOM: f64 = 0.02;
const RESTITUTION: f64 = 0.65;
/// The soil's frequency \[rad/s\] and damping ratio.
const SOIL: f64 = TAU * 2.4;
const SOIL_DAMPING: f64 = 0.6;
/// Mass of a floor \[kg\].
const FLOOR: f64 = 4e4;

/// Times and accelerations like those of a strong earthquake.
fn record() -> Result<Signal> {
    // A linear congruential generator is noise enough for the soil.
    let mut seed = 40u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let count = (DURATION * RATE) as usize + 1;
    let step = 1.0 / RATE;
    let (mut times, mut values) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let (mut x, mut v) = (0.0, 0.0);
    for k in 0..count {
        let t = k as f64 * step;
        // Semi-implicit steps of x'' + 2 z w x' + w^2 x = noise; what shakes is 2 z w x' + w^2 x.
        v += step * (noise() - 2.0 * SOIL_DAMPING * SOIL * v - SOIL * SOIL * x);
        x += step * v;
        let envelope = (t / 3.0).min(1.0).powi(2) * (-0.3 * (t - 8.0).max(0.0)).exp();
        times.push(t);
        values.push(envelope * (2.0 * SOIL_DAMPING * SOIL * v + SOIL * SOIL * x));
    }
    let largest = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    for value in &mut values {
        *value *= PEAK / largest;
    }
    Signal::samples(&times, &values)
}

/// Both buildings, floors of the stiff one first.
fn buildings() -> Result<Scene> {
    let (mut damping, mut stiffness) = (DMatrix::zeros(4, 4), DMatrix::zeros(4, 4));
    let root = 5f64.sqrt();
    let (lowest, highest) = (0.5 * (3.0 - root), 0.5 * (3.0 + root));
    for (k, hertz) in [(0, 3.0), (2, 1.4)] {
        let first = TAU * hertz;
        let second = first * (highest / lowest).sqrt();
        let storey = storey_matrix() * (FLOOR * first * first / lowest);
        let mass: DMatrix<f64> = DMatrix::identity(2, 2) * FLOOR;
        // Equal ratios at both frequencies.
        let ratio = 0.03;
        let (alpha, beta) = (
            2.0 * ratio * first * second / (first + second),
            2.0 * ratio / (first + second),
        );
        let own = rayleigh_damping(&mass.into(), &storey.clone().into(), alpha, beta)?;
        damping.view_mut((k, k), (2, 2)).copy_from(&own.to_dense());
        stiffness.view_mut((k, k), (2, 2)).copy_from(&storey);
    }
    let system = LinearSystem::new(DVector::from_element(4, FLOOR), damping, stiffness)?
        .with_influence(DVector::from_element(4, 1.0))?;
    let stops = [
        Stop::new(dvector![1.0, 0.0, -1.0, 0.0], ROOM, RESTITUTION)?,
        Stop::new(dvector![0.0, 1.0, 0.0, -1.0], ROOM, RESTITUTION)?,
    ];
    Scene::new(system, BaseAcceleration::new(record()?), stops)
}

/// Stiffness of two storeys over that of one.
fn storey_matrix() -> DMatrix<f64> {
    DMatrix::from_row_slice(2, 2, &[2.0, -1.0, -1.0, 1.0])
}

fn main() -> Result<()> {
    let scene = buildings()?;
    let (rest, span) = (DVector::zeros(4), (0.0, DURATION));
    let run = simulate(&scene, &rest, &rest, span, &SimulateOptions::default())?;
    let of_roofs = run.impacts().iter().filter(|i| i.stop == 1).count();
    println!(
        "{of_roofs} impacts of the roofs, {} of the first floors",
        run.impacts().len() - of_roofs
    );
    let by_steps = SimulateOptions {
        solver: Method::Radau.into(),
        keep: Keep::Impacts,
        ..SimulateOptions::default()
    };
    let steps = simulate(&scene, &rest, &rest, span, &by_steps)?;
    let pairs = run.impacts().iter().zip(steps.impacts()).take(10);
    let off = pairs
        .map(|(a, b)| (a.time - b.time).abs())
        .fold(0.0, f64::max);
    println!("the first ten impacts by the Radau method are off by {off:.0e} s");
    assert!(run.impacts().len() >= 10 && off < 1e-6);
    let energy = run.energy()?;
    let most = energy.kinetic.iter().fold(0.0, |most: f64, x| most.max(*x));
    let open = energy
        .balance
        .iter()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    let last = |column: &[f64]| column.last().copied().unwrap_or(0.0) / 1e3;
    println!(
        "impacts took {:.1} kJ, dampers {:.1} kJ; it adds up to {:.0e}",
        last(&energy.impact_loss),
        last(&energy.damping_loss),
        open / most
    );
    assert!(open < 1e-11 * most);
    let given = run.impulse(1, None)?;
    let listed: f64 = run
        .impacts()
        .iter()
        .filter(|i| i.stop == 1)
        .map(|i| i.impulse)
        .sum();
    assert!((given - listed).abs() < 1e-9 * given);
    Ok(())
}
