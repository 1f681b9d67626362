//! Grazing: what is born where a driven mass just touches its stop.
//!
//! `x'' + 0.1 x' + x = F cos t` with a stop at x = 1 and restitution 0.8, driven at its own frequency. You will see the motion with
//! one impact in each period followed down over the force, round the fold at F = 0.09997 to F = 0.1, where its impact has lost its
//! speed; and what is born there, on which side, and whether it keeps the rules of contact. `grazing.py` draws it, and
//! says what becomes of the motion beyond.
use vibroimpact::nalgebra::dvector;
use vibroimpact::{
    ContinuationOptions, CurveOf, Harmonic, LinearSystem, OrbitOptions, Parameter, Pattern, Result,
    Scene, SpecialKind, Stop, bifurcation_curve, branches, continuation, periodic_orbits,
};

/// The oscillator, its force of one: a factor on the force is the force.
fn oscillator() -> Result<Scene> {
    let system = LinearSystem::new(dvector![1.0], dvector![0.1], dvector![1.0])?;
    let force = Harmonic::new(dvector![1.0.into()], 1.0, 0.0)?;
    Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])
}

fn main() -> Result<()> {
    let orbits = periodic_orbits(
        &oscillator()?,
        &Pattern::single(0),
        &OrbitOptions::default(),
    )?;
    let (force, range) = (Parameter::ForcingScale, (0.05, 1.2));
    let options = ContinuationOptions::default();
    let branch = continuation(&orbits[0], force, range, &options)?;
    for special in &branch.special {
        println!(
            "{:<12} at F = {:.12}",
            special.kind.name(),
            special.parameter
        );
    }
    let of = |kind: SpecialKind| branch.special.iter().find(|own| own.kind == kind);
    let fold = of(SpecialKind::Fold).expect("the branch turns");
    let lost = of(SpecialKind::LostImpact).expect("its impact loses its speed");
    // Closed forms (theory 19).
    assert!((fold.parameter - 0.099_970_753_63).abs() < 1e-10);
    assert!((lost.parameter - 0.1).abs() < 1e-9);

    println!("\nborn there:");
    for born in branches(lost, force, range)? {
        let side = if born.is_above { "above" } else { "below" };
        let kept = born.orbit.is_admissible() == Some(true);
        println!(
            "  {} impacts in {} periods, {side}, at {:.9}: {}",
            born.orbit.impacts().len(),
            born.orbit.n_periods(),
            born.parameter,
            if kept { "admissible" } else { "not admissible" }
        );
    }

    // The fold over frequency and force.
    let plane = [Parameter::Frequency, Parameter::ForcingScale];
    let scene = fold.orbit.scene();
    let scale = |factor: f64| factor / fold.parameter;
    let between = [(0.7, 1.3), (scale(0.01), scale(1.0))];
    let curve = bifurcation_curve(CurveOf::Special(fold), plane, between, &options)?;
    let least = curve.y.iter().copied().fold(f64::INFINITY, f64::min) * fold.parameter;
    println!(
        "\nthe fold over the frequency: {} points, down to F = {least:.6}; the scene of the branch has {} stop",
        curve.x.len(),
        scene.stops().len()
    );
    Ok(())
}
