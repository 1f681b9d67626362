//! An oscillator between two stops: symmetric motions, and the pair of unsymmetric ones that they give way to.
//!
//! A unit mass on a unit spring, undamped, driven by a harmonic force, hits a stop on each side once in each forcing period.
//! You will see the symmetric motion beside its closed form; the unsymmetric pair, each the mirror image of the other; and
//! the number of admissible motions over the frequency, three where the symmetric one is unstable and the pair has
//! branched off. `two_sided.py` derives both ends of that range and draws it.

use std::f64::consts::PI;
use vibroimpact::nalgebra::dvector;
use vibroimpact::{
    Harmonic, ImpactSide, LinearSystem, Motion, OrbitOptions, Pattern, PeriodicOrbit, Result,
    Scene, Side, Stop, periodic_orbits,
};

const FORCE: f64 = 1.0;
const CLEARANCE: f64 = 0.5;
const RESTITUTION: f64 = 0.7;
const FREQUENCY: f64 = 1.4;

/// The oscillator between its stops.
fn oscillator(frequency: f64) -> Result<Scene> {
    let system = LinearSystem::new(dvector![1.0], dvector![0.0], dvector![1.0])?;
    let upper = Stop::new(0, CLEARANCE, RESTITUTION)?;
    let lower = upper.clone().on_side(Side::Lower);
    let force = Harmonic::new(dvector![FORCE.into()], frequency, 0.0)?;
    Scene::new(system, force, [upper, lower])
}

/// The admissible motions that hit the upper and the lower stop once in each period.
fn admissible_orbits(frequency: f64) -> Result<Vec<PeriodicOrbit>> {
    let both = Pattern::new(vec![vec![0], vec![1]])?;
    let orbits = periodic_orbits(&oscillator(frequency)?, &both, &OrbitOptions::default())?;
    Ok(orbits
        .iter()
        .filter(|o| o.is_admissible() == Some(true))
        .cloned()
        .collect())
}

/// Speed after each impact of the symmetric motion; the frequency is not 1.
///
/// With `X = F / (1 - w^2)`, `k = tan(pi / (2 w)) (1 + e) / (2 e)` and `n = (1 - e) / (2 e w)`, the free motion over half a
/// period joins the impacts where `(d - k v)^2 + (n v)^2 = X^2`; v is the larger root.
fn symmetric_speed(w: f64) -> f64 {
    let response = FORCE / (1.0 - w * w);
    let k = (0.5 * PI / w).tan() * (1.0 + RESTITUTION) / (2.0 * RESTITUTION);
    let n = (1.0 - RESTITUTION) / (2.0 * RESTITUTION * w);
    let square = k * k + n * n;
    let rest = square * (CLEARANCE.powi(2) - response.powi(2));
    (CLEARANCE * k + ((CLEARANCE * k).powi(2) - rest).sqrt()) / square
}

/// Whether both stops are hit at the same speed.
fn is_symmetric(orbit: &PeriodicOrbit) -> bool {
    let impacts = orbit.impacts();
    (impacts[0].approach - impacts[1].approach).abs() < 1e-6
}

/// The symmetric motion beside its closed form, and each of the pair beside the mirror image of the other.
fn check_orbits() -> Result<()> {
    let (symmetric, pair): (Vec<_>, Vec<_>) = admissible_orbits(FREQUENCY)?
        .into_iter()
        .partition(is_symmetric);
    assert_eq!((symmetric.len(), pair.len()), (1, 2));
    let (found, speed) = (-symmetric[0].v0()[0], symmetric_speed(FREQUENCY));
    println!(
        "frequency {FREQUENCY}: symmetric motion, speed after impact {found:.12}, closed form {speed:.12}"
    );
    assert!((found - speed).abs() < 1e-12);
    assert_eq!(symmetric[0].stability()?.is_stable, Some(false));
    assert_eq!(pair[0].stability()?.is_stable, Some(true));
    let delay = pair[0].impacts()[1].time;
    let times = (0..100).map(|i| 0.01 * f64::from(i) * pair[0].period());
    let (now, late): (Vec<f64>, Vec<f64>) = times.map(|t| (t, t + delay)).unzip();
    let ours = pair[0].along(0, Some(&late), 0, ImpactSide::After)?;
    let theirs = pair[1].along(0, Some(&now), 0, ImpactSide::After)?;
    let mismatch = ours.iter().zip(&theirs);
    let mismatch = mismatch.fold(0.0, |largest: f64, (a, b)| largest.max((a + b).abs()));
    println!("the pair mirrors itself to {mismatch:.1e}");
    assert!(mismatch < 1e-9);
    Ok(())
}

/// The speeds at the upper stop over the frequency.
fn sweep() -> Result<()> {
    println!("frequency   speeds after the upper stop");
    for i in 0..=10 {
        let frequency = 1.2 + 0.05 * f64::from(i);
        print!("{frequency:<10.2}");
        for orbit in admissible_orbits(frequency)? {
            let stable = orbit.stability()?.is_stable == Some(true);
            print!(
                "  {:.6} {}",
                orbit.impacts()[0].departure,
                if stable { "stable  " } else { "unstable" }
            );
        }
        println!();
    }
    for (frequency, number) in [(1.2, 1), (1.4, 3), (1.6, 1)] {
        assert_eq!(admissible_orbits(frequency)?.len(), number);
    }
    Ok(())
}

fn main() -> Result<()> {
    check_orbits()?;
    sweep()
}
