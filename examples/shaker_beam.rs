//! A beam between two stops on a shaker, from its modes: swept up and down, it jumps at different frequencies.
//!
//! The first three modes of a clamped steel strip, 0.5 m by 3 mm, with 2 % damping, as a finite-element program or a modal test gives
//! them: frequencies, shapes at the tip, and what a motion of the clamp does to each. The shaker moves by 1.2 mm and is swept from 5 to
//! 50 Hz and back; a stop on each side holds the tip within 8 mm. You will see where the large motion falls on the way up and where
//! the small one ends on the way down. `shaker_beam.py` meshes the strip, and draws it.

use std::f64::consts::TAU;
use vibroimpact::nalgebra::{DVector, dvector};
use vibroimpact::{
    BaseMotion, Keep, LinearSystem, Parameter, Ramp, RampProfile, Result, Scene, Side,
    SimulateOptions, Stop, Trajectory, simulate,
};

/// Roots of `cos b cosh b = -1`: the modes of a clamped strip.
const ROOTS: [f64; 3] = [
    1.875_104_068_711_961_1,
    4.694_091_132_974_175,
    7.854_757_438_237_613,
];
/// `sqrt(E/rho) h/sqrt(12)`, of steel 3 mm thick \[m^2/s\]; length \[m\]; mass \[kg\].
const STIFFNESS: f64 = 4.479_2;
const LENGTH: f64 = 0.5;
const MASS: f64 = 0.2355;
const DAMPING: f64 = 0.02;
/// Displacement of the shaker, and of the tip to its stops \[m\].
const SHAKER: f64 = 1.2e-3;
const ROOM: f64 = 8e-3;
/// The sweep \[rad/s\], \[rad/s^2\].
const LOW: f64 = TAU * 5.0;
const HIGH: f64 = TAU * 50.0;
const RATE: f64 = TAU * 0.25;

/// The modes with unit modal masses: frequencies, shapes at the tip, and shares of a motion of the clamp.
fn modes() -> (DVector<f64>, DVector<f64>, DVector<f64>) {
    let frequency = |b: f64| b * b * STIFFNESS / (LENGTH * LENGTH);
    // Shapes of mean square one are 2 at the tip in size, and have the mean 2 sigma/b.
    let sigma = |b: f64| (b.sinh() - b.sin()) / (b.cosh() + b.cos());
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    let per_mode = |f: &dyn Fn(usize, f64) -> f64| {
        DVector::from_iterator(3, ROOTS.iter().enumerate().map(|(k, &b)| f(k, b)))
    };
    (
        per_mode(&|_, b| frequency(b)),
        per_mode(&|k, _| sign(k) * 2.0 / MASS.sqrt()),
        per_mode(&|_, b| 2.0 * sigma(b) / b * MASS.sqrt()),
    )
}

/// Sweeps the shaker from rest, from one frequency to another.
fn swept(scene: &Scene, first: f64, last: f64) -> Result<Trajectory> {
    let start = scene.replace(Parameter::Frequency.change(first))?;
    let rest = DVector::zeros(scene.n_dof());
    let options = SimulateOptions {
        ramps: vec![Ramp::new(
            Parameter::Frequency,
            last,
            RampProfile::Rate(RATE),
        )?],
        keep: Keep::Impacts,
        ..SimulateOptions::default()
    };
    simulate(&start, &rest, &rest, (0.0, (HIGH - LOW) / RATE), &options)
}

fn main() -> Result<()> {
    let (frequencies, tip, shares) = modes();
    let ratios = dvector![DAMPING, DAMPING, DAMPING];
    let beam = LinearSystem::from_modes(&frequencies, &ratios)?.with_influence(shares)?;
    let stop = Stop::new(tip, ROOM, 0.6)?;
    let stops = [stop.clone(), stop.on_side(Side::Lower)];
    let scene = Scene::new(beam, BaseMotion::new(SHAKER, LOW, 0.0)?, stops)?;
    let (up, down) = (swept(&scene, LOW, HIGH)?, swept(&scene, HIGH, LOW)?);
    let (last, first) = (up.impacts().last(), down.impacts().first());
    let (last, first) = (last.expect("it hits"), first.expect("it hits"));
    let hertz = |run: &Trajectory, t: f64| run.parameter(t, None).map(|w| w / TAU);
    let (falls, climbs) = (hertz(&up, last.time)?, hertz(&down, first.time)?);
    println!(
        "{} impacts on the way up, {} down; the beam alone resonates at {:.2} Hz",
        up.impacts().len(),
        down.impacts().len(),
        frequencies[0] / TAU
    );
    println!("the large motion falls at {falls:.2} Hz on the way up");
    println!("the small one ends at {climbs:.2} Hz on the way down");
    assert!(falls > climbs + 1.0 && climbs > frequencies[0] / TAU);
    // The angle of the shaker is that of its sweep.
    let angle = LOW * last.time + 0.5 * RATE * last.time.powi(2);
    assert!((up.phase(last.time)?.cos() - angle.cos()).abs() < 1e-11);
    Ok(())
}
