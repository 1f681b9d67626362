//! The source paper's motions over frequency and clearance: where each is born and lost, and by what.
//!
//! For kinds 2 and 3, the upper or the lower pendulum hitting a wall, the paper's orbit is followed over the clearance; each special point of
//! that branch, a fold, a period doubling, a touch, an impact without speed, is then followed as a curve over frequency and clearance. Kind 1
//! asks two stops for one instant and is a curve itself. `paper_branches.py` maps the plane too, and draws both.
use vibroimpact::{
    BifurcationCurve, Constraint, ContinuationOptions, CurveOf, FreeParameter, Kind, OrbitOptions,
    PaperOptions, Parameter, Pattern, PeriodicOrbit, Result, SpecialKind, bifurcation_curve,
    bifurcation_curve_of, continuation, paper_scene, periodic_orbits,
};

/// Ranges of frequency and clearance.
const RANGES: [(f64, f64); 2] = [(1.3, 1.7), (0.05, 0.8)];

/// The paper's frequency.
const FREQUENCY: f64 = 1.5;

/// The paper's orbit of a kind.
fn orbit_of(kind: Kind) -> Result<PeriodicOrbit> {
    let options = OrbitOptions {
        n_periods: kind.n_periods(),
        free: (kind == Kind::One).then_some(FreeParameter::Clearance),
        ..Default::default()
    };
    let scene = paper_scene(kind, &PaperOptions::default())?;
    let found = periodic_orbits(&scene, &Pattern::new(kind.pattern())?, &options)?;
    Ok(found.into_iter().next().expect("the paper's orbit"))
}

/// One line of a curve, and one of each point where two things happen at once.
fn show(name: &str, curve: &BifurcationCurve) {
    let ends = |numbers: &[f64]| {
        let low = numbers.iter().copied().fold(f64::INFINITY, f64::min);
        let high = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        format!("{low:.4} to {high:.4}")
    };
    println!(
        "  {name:<16} frequency {}, clearance {}: {} orbits",
        ends(&curve.x),
        ends(&curve.y),
        curve.orbits.len()
    );
    for point in &curve.special {
        let [x, y] = point.parameters;
        println!("    {} at ({x:.6}, {y:.6})", point.kind);
    }
}

fn main() -> Result<()> {
    let options = ContinuationOptions::default();
    let plane = [Parameter::Frequency, Parameter::CLEARANCE];
    for (number, kind) in [(2, Kind::Two), (3, Kind::Three)] {
        println!("kind {number}");
        let orbit = orbit_of(kind)?;
        let branch = continuation(&orbit, plane[1], RANGES[1], &options)?;
        for special in &branch.special {
            // Tori, crossings and the ends of lasting contact have no curve; the paper's motions have none of them here.
            let curve = bifurcation_curve(CurveOf::Special(special), plane, RANGES, &options)?;
            show(special.kind.name(), &curve);
        }
        assert!(
            branch
                .special
                .iter()
                .any(|own| own.kind == SpecialKind::Graze || own.kind == SpecialKind::LostImpact)
        );
    }
    println!("kind 1");
    let orbit = orbit_of(Kind::One)?;
    let scene = paper_scene(Kind::One, &PaperOptions::default())?;
    let make = |frequency: f64, clearance: f64| {
        let there = scene.replace(plane[0].change(frequency))?;
        there.replace(plane[1].change(clearance))
    };
    // The angle of the wall at which both contacts meet is found with the orbit.
    let Constraint::Stop(wall) = &orbit.scene().stops()[0] else {
        unreachable!("the paper's walls are stops");
    };
    let start = [FREQUENCY, wall.clearance()];
    let ranges = [(1.2, 1.8), (0.3, 1.5)];
    let curve = bifurcation_curve_of(CurveOf::Orbit(&orbit), &make, start, ranges, &options)?;
    show("stops together", &curve);
    let kept = curve
        .orbits
        .iter()
        .filter(|own| own.is_admissible() == Some(true));
    println!("  {} of them keep the rules of contact", kept.count());
    Ok(())
}
