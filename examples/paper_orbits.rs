//! The source paper's three kinds of periodic impact motion: the table of `paper_orbits.py`, from Rust.
//!
//! A double pendulum on a shaken base hits a wall with both pendulums at once (kind 1), with the upper one (kind 2) or with
//! the lower one (kind 3). You will see each orbit's wall angle, forcing phase, velocities and largest multiplier.

use vibroimpact::{
    FreeParameter, Kind, OrbitOptions, PaperOptions, Pattern, PeriodicOrbit, Result, paper_scene,
    periodic_orbits,
};

fn paper_orbit(kind: Kind) -> Result<PeriodicOrbit> {
    let scene = paper_scene(kind, &PaperOptions::default())?;
    let free = (kind == Kind::One).then_some(FreeParameter::Clearance);
    let options = OrbitOptions {
        n_periods: kind.n_periods(),
        free,
        ..Default::default()
    };
    let orbits = periodic_orbits(&scene, &Pattern::new(kind.pattern())?, &options)?;
    Ok(orbits[0].clone())
}

fn main() -> Result<()> {
    println!("kind  theta0     phase[deg]  velocity after impact   stable      largest multiplier");
    for kind in [Kind::One, Kind::Two, Kind::Three] {
        let orbit = paper_orbit(kind)?;
        let stability = orbit.stability()?;
        let stop = orbit.impacts()[0].stop;
        println!(
            "{kind:<5} {:<10.6} {:>10.4}  {:+.6}, {:+.6}    {:<11} {:.5}",
            orbit.q0()[stop],
            orbit.phase().to_degrees(),
            orbit.v0()[0],
            orbit.v0()[1],
            format!("{:?}", stability.is_stable),
            stability.orders[0].spectral_radius(),
            kind = format!("{kind:?}"),
        );
        assert!(orbit.is_admissible() == Some(true) && stability.is_stable == Some(true));
        if kind == Kind::One {
            assert!((orbit.phase().to_degrees() - 73.0915).abs() < 5e-5);
            assert!((orbit.q0()[0] - 0.806_286).abs() < 5e-7);
        }
    }
    Ok(())
}
