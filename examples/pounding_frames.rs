//! Two frames that pound under a record: how hard, by which law of the bumper between them.
//!
//! Two buildings of one storey, of 2.4 Hz and 1.1 Hz, stand 15 mm apart with a bumper between their roofs, a spring and a dashpot in parallel:
//! a stop on the difference of two coordinates. The ground follows a record made here as records look. You will see contacts and largest
//! forces by a dashpot that pulls, by one that is clipped, and impacts of rigid roofs, all of one restitution; contacts beside those by
//! the Radau method; the energies; and that ever stiffer bumpers come near to rigid roofs by the root of their stiffness.
//! `pounding_frames.py` draws a record of its own.

use std::f64::consts::{PI, TAU};
use vibroimpact::nalgebra::{DVector, dvector};
use vibroimpact::{
    BaseAcceleration, ContactRelease, ImpactSide, IntoLaw, LinearSystem, Method, Motion, Newton,
    Result, Scene, Signal, SimulateOptions, Solver, Spring, Stop, Trajectory, simulate,
};

/// The record: length \[s\], samples a second, peak \[m/s^2\].
const DURATION: f64 = 16.0;
const RATE: f64 = 100.0;
const PEAK: f64 = 3.0;
/// The soil's frequency \[rad/s\] and damping ratio.
const SOIL: f64 = TAU * 2.0;
const SOIL_DAMPING: f64 = 0.6;
/// Mass of each building \[kg\] and damping ratio.
const MASS: f64 = 1e5;
const RATIO: f64 = 0.04;
const ROOM: f64 = 0.015;
const BUMPER: f64 = 1e9;
const RESTITUTION: f64 = 0.6;

/// Times and accelerations like those of a strong earthquake.
fn record() -> Result<Signal> {
    let mut seed = 7u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let (count, step) = ((DURATION * RATE) as usize + 1, 1.0 / RATE);
    let times: Vec<f64> = (0..count).map(|k| k as f64 * step).collect();
    let (mut x, mut v) = (0.0, 0.0);
    let mut values: Vec<f64> = times
        .iter()
        .map(|t| {
            // Semi-implicit steps of the soil; what shakes is 2 z w x' + w^2 x, under an envelope.
            v += step * (noise() - 2.0 * SOIL_DAMPING * SOIL * v - SOIL * SOIL * x);
            x += step * v;
            let envelope = (t / 3.0).min(1.0).powi(2) * (-0.3 * (t - 8.0).max(0.0)).exp();
            envelope * (2.0 * SOIL_DAMPING * SOIL * v + SOIL * SOIL * x)
        })
        .collect();
    let largest = values.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    for value in &mut values {
        *value *= PEAK / largest;
    }
    Signal::samples(&times, &values)
}

/// Shakes both buildings from rest, with a law between their roofs.
fn run(law: impl IntoLaw, options: &SimulateOptions) -> Result<Trajectory> {
    let w = dvector![TAU * 2.4, TAU * 1.1];
    let mass = DVector::from_element(2, MASS);
    let system = LinearSystem::new(mass, &w * (2.0 * RATIO * MASS), w.map(|w| MASS * w * w))?
        .with_influence(DVector::from_element(2, 1.0))?;
    let stop = Stop::new(dvector![1.0, -1.0], ROOM, law)?;
    let scene = Scene::new(system, BaseAcceleration::new(record()?), [stop])?;
    let rest = DVector::zeros(2);
    simulate(&scene, &rest, &rest, (0.0, DURATION), options)
}

/// The bumper that gives the restitution back to two free roofs, whose reduced mass is half of one.
fn bumper(stiffness: f64, release: ContactRelease) -> Result<Spring> {
    Spring::from_restitution(RESTITUTION, stiffness, 0.5 * MASS, release)
}

/// Ever stiffer bumpers beside rigid roofs, until the second impact.
fn near_rigid(rigid: &Trajectory) -> Result<()> {
    let end = rigid.impacts()[1].time - 0.02;
    println!("\nstiffness [N/m]  largest difference from rigid roofs [mm]");
    let mut last = f64::NAN;
    for factor in [1.0, 1e2, 1e4] {
        let spring = bumper(factor * BUMPER, ContactRelease::Gap)?;
        let soft = run(spring, &SimulateOptions::default())?;
        let mut most: f64 = 0.0;
        for k in 0..400 {
            let t = end * f64::from(k) / 400.0;
            let q = soft.state(t, ImpactSide::After)?.0 - rigid.state(t, ImpactSide::After)?.0;
            most = most.max(1e3 * q.amax());
        }
        println!("{:<15.0e}  {most:.5}", factor * BUMPER);
        assert!(last.is_nan() || (6.0..14.0).contains(&(last / most)));
        last = most;
    }
    Ok(())
}

fn main() -> Result<()> {
    let exact = SimulateOptions::default();
    println!("law        damping ratio  contacts  largest force [MN]  taken [kJ]");
    for release in [ContactRelease::Gap, ContactRelease::Clipped] {
        let law = bumper(BUMPER, release)?;
        let motion = run(law, &exact)?;
        let contacts = motion.contacts()?;
        let largest = contacts
            .iter()
            .map(|own| own.peak_force)
            .fold(0.0, f64::max);
        let ratio = law.damping() / (2.0 * (0.5 * MASS * law.stiffness()).sqrt());
        let energy = motion.energy()?;
        let taken = energy.contact_loss.last().copied().unwrap_or(0.0);
        println!(
            "{:<9}  {ratio:<13.4}  {:<8}  {:<18.3}  {:.1}",
            format!("{release:?}"),
            contacts.len(),
            1e-6 * largest,
            1e-3 * taken
        );
        let most = energy.kinetic.iter().fold(0.0, |most: f64, x| most.max(*x));
        let open = energy
            .balance
            .iter()
            .fold(0.0, |most: f64, x| most.max(x.abs()));
        assert!(open < 1e-10 * most);
        let lost: f64 = contacts.iter().map(|own| own.loss).sum();
        assert!((lost - taken).abs() < 1e-9 * taken);
        if release == ContactRelease::Gap {
            let log = RESTITUTION.ln();
            assert!((ratio + log / PI.hypot(log)).abs() < 1e-12);
            let by_steps = SimulateOptions {
                solver: Solver {
                    rtol: 1e-10,
                    atol: Some(1e-13),
                    ..Method::Radau.into()
                },
                ..SimulateOptions::default()
            };
            let steps = run(law, &by_steps)?.contacts()?;
            let pairs = contacts.iter().zip(&steps).take(8);
            let off = pairs
                .map(|(a, b)| (a.start - b.start).abs())
                .fold(0.0, f64::max);
            println!("the first 8 contacts by the Radau method are off by {off:.0e} s");
            assert!(off < 1e-7);
        }
    }
    let rigid = run(Newton::new(RESTITUTION)?, &exact)?;
    println!("rigid: {} impacts", rigid.impacts().len());
    near_rigid(&rigid)
}
