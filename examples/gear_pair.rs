//! A gear pair with elastic teeth: where it loses contact, and the two motions that it then has.
//!
//! The coordinate is the dynamic transmission error over half the backlash: teeth touch at 1 and at -1, where a spring and a dashpot give
//! way. A torque presses them together with 0.1, an error of the wheels with amplitude 0.05 shakes them. You will see from which frequency
//! the teeth separate on the way up, beside the closed form, down to which they do on the way down, and both motions at one frequency, over
//! a period of which the teeth carry the torque. `gear_pair.py` draws them.

use vibroimpact::nalgebra::{DVector, dvector};
use vibroimpact::{
    BaseMotion, ContactRelease, ImpactSide, Keep, LinearSystem, Motion, Result, Scene, Side,
    SimulateOptions, Spring, Stop, find_orbit, simulate,
};

/// Static deflection of the mesh and amplitude of the error, over half the backlash.
const TORQUE: f64 = 0.1;
const ERROR: f64 = 0.05;
const STIFFNESS: f64 = 1.0;
const DASHPOT: f64 = 0.1;
const DRAG: f64 = 0.01;
/// A frequency with both motions.
const BOTH: f64 = 0.72;
const STEP: f64 = 0.01;

fn gears(frequency: f64) -> Result<Scene> {
    let relative = LinearSystem::new(dvector![1.0], dvector![DRAG], dvector![0.0])?
        .with_load(dvector![TORQUE])?
        .with_influence(dvector![1.0])?;
    let tooth = Spring::new(STIFFNESS, DASHPOT, Some(ContactRelease::Gap))?;
    let flank = Stop::new(0, 1.0, tooth)?;
    let flanks = [flank.clone(), flank.on_side(Side::Lower)];
    Scene::new(relative, BaseMotion::new(ERROR, frequency, 0.0)?, flanks)
}

/// The frequency from which the amplitude of teeth that stay together is larger than the static deflection: a quadratic in its square.
fn separation() -> f64 {
    let share = (ERROR * STIFFNESS / TORQUE).powi(2);
    let (a, b) = (1.0 - share, 2.0 * STIFFNESS - (DASHPOT + DRAG).powi(2));
    ((b - (b * b - 4.0 * a * STIFFNESS * STIFFNESS).sqrt()) / (2.0 * a)).sqrt()
}

/// What is seen at a frequency.
struct Response {
    frequency: f64,
    separates: bool,
    /// The state at its end.
    state: (DVector<f64>, DVector<f64>),
}

/// Follows the motion from frequency to frequency.
fn swept(frequencies: impl Iterator<Item = f64>) -> Result<Vec<Response>> {
    let mut state = (dvector![1.0 + TORQUE / STIFFNESS], dvector![0.0]);
    let mut found = Vec::new();
    for frequency in frequencies {
        let scene = gears(frequency)?;
        let period = std::f64::consts::TAU / frequency;
        let settling = SimulateOptions {
            keep: Keep::Final,
            ..SimulateOptions::default()
        };
        let before = simulate(&scene, &state.0, &state.1, (0.0, 200.0 * period), &settling)?;
        let (q, v) = before.last();
        let run = simulate(
            &scene,
            q,
            v,
            (0.0, 10.0 * period),
            &SimulateOptions::default(),
        )?;
        let (q, v) = run.last();
        state = (q.clone(), v.clone());
        found.push(Response {
            frequency,
            separates: run.regimes()?.len() > 1,
            state: state.clone(),
        });
    }
    Ok(found)
}

fn main() -> Result<()> {
    let all = || (0..=90).map(|k| 0.4 + STEP * f64::from(k));
    let (up, down) = (swept(all())?, swept(all().rev())?);
    let below = |each: &&Response| each.frequency < 1.0;
    let together = up.iter().filter(below).filter(|each| !each.separates);
    let last = together.map(|each| each.frequency).fold(0.0, f64::max);
    let apart = down.iter().filter(below).filter(|each| each.separates);
    let back = apart.map(|each| each.frequency).fold(1.0, f64::min);
    println!(
        "on the way up they stay together to w = {last:.2}, closed form {:.4}; down they separate to w = {back:.2}",
        separation()
    );
    assert!((last - separation()).abs() <= STEP && back < separation() - 0.05);

    println!("\namplitude  largest multiplier  force over torque, mean");
    for responses in [&up, &down] {
        let near = responses
            .iter()
            .find(|each| (each.frequency - BOTH).abs() < 0.5 * STEP)
            .expect("among them");
        let scene = gears(near.frequency)?;
        let span = (0.0, 50.0 * std::f64::consts::TAU / near.frequency);
        let run = simulate(
            &scene,
            &near.state.0,
            &near.state.1,
            span,
            &SimulateOptions::default(),
        )?;
        let orbit = find_orbit(&scene, &run, None)?;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..=2000 {
            let t = orbit.period() * f64::from(k) / 2000.0;
            let x = orbit.state(t, ImpactSide::After)?.0[0];
            (low, high) = (low.min(x), high.max(x));
        }
        let stability = orbit.stability()?;
        let largest = stability.orders[0].spectral_radius();
        let carried = orbit.impulse(0, None)? - orbit.impulse(1, None)?;
        let mean = carried / (TORQUE * orbit.period());
        println!(
            "{:.6}   {largest:.4}              {mean:.12}",
            0.5 * (high - low)
        );
        assert_eq!(orbit.is_admissible(), Some(true));
        assert_eq!(stability.is_stable, Some(true));
        assert!((mean - 1.0).abs() < 1e-9);
    }
    Ok(())
}
