//! The impact oscillator: what a driven mass before a stop settles on, over the force that drives it.
//!
//! `x'' + 0.1 x' + x = F cos 2.4 t` with a stop at x = 1 and restitution 0.8. You will see where its bifurcation diagram changes beside the
//! closed forms of the graze and of the doubling, the Lyapunov exponents of its chaos at F = 5 with their errors, and how large the basins
//! of the two orbits are that attract at F = 9. `impact_oscillator.py` draws them.
use vibroimpact::nalgebra::{DMatrix, dmatrix, dvector};
use vibroimpact::{
    Attraction, AttractorOptions, Axis, BasinOptions, DiagramOptions, Direction, Harmonic, Label,
    LinearSystem, LyapunovOptions, Parameter, Result, Scene, Section, StateBox, Stop, basin_cells,
    bifurcation_diagram, find_attractors, lyapunov_exponents,
};

/// The force at which the stop is grazed, and that above which one impact in each period is stable: theory of one impact in closed form.
const GRAZE: f64 = 4.766_046_580;
const DOUBLING: f64 = 7.733_257_821_64;
/// The largest exponent at F = 5, and its error.
const LONG: [f64; 2] = [0.1179, 0.0005];
/// Cells of the basins along each side.
const SIDE: usize = 40;

fn oscillator(force: f64) -> Result<Scene> {
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
    let force = Harmonic::new(dvector![force.into()], 2.4, 0.0)?;
    Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])
}

fn main() -> Result<()> {
    let step = 0.05;
    let forces: Vec<f64> = (0..=120).map(|k| 4.0 + step * f64::from(k)).collect();
    let axis = Axis::new(Parameter::ForcingScale, forces);
    let options = DiagramOptions {
        direction: Direction::Both,
        section: Section::Impacts(vec![0]),
        ..DiagramOptions::default()
    };
    let diagram = bifurcation_diagram(&oscillator(1.0)?, &axis, &options)?;
    let values = || (0..diagram.parameter.len()).map(|k| (k, diagram.parameter[k]));
    let hit = values().filter(|&(k, _)| diagram.is_up[k] && diagram.n_impacts[k] > 0);
    let hit = hit.map(|(_, force)| force).fold(f64::INFINITY, f64::min);
    let is_once = |k: usize| diagram.n_periods[k] == 1 && diagram.n_impacts[k] > 0;
    let once = values().filter(|&(k, _)| !diagram.is_up[k] && is_once(k));
    let once = once.map(|(_, force)| force).fold(f64::INFINITY, f64::min);
    println!("the stop is hit from F = {hit:.3}, closed form {GRAZE:.3}");
    println!("once in each period from F = {once:.3}, closed form {DOUBLING:.3}");
    assert!((hit - GRAZE).abs() <= step && (once - DOUBLING).abs() <= 2.0 * step);

    let options = LyapunovOptions {
        skip: 1000.0,
        ..LyapunovOptions::default()
    };
    let rest = dvector![0.0];
    let chaos = lyapunov_exponents(&oscillator(5.0)?, &rest, &rest, (0.0, 12_000.0), &options)?;
    let [largest, error] = [chaos.exponents[0], chaos.errors[0]];
    println!(
        "at F = 5: {largest:.4} +- {error:.4}, {:.4}",
        chaos.exponents[1]
    );
    assert_eq!(chaos.verdict, Attraction::Chaotic);
    assert!((largest - LONG[0]).abs() < 4.0 * error.hypot(LONG[1]));
    assert!((chaos.sum - chaos.expected_sum).abs() < 1e-9);

    let scene = oscillator(9.0)?;
    let around = StateBox::new(dvector![-4.0, -6.0], dvector![1.0, 6.0])?;
    let states = DMatrix::from_fn(SIDE * SIDE, 2, |k, j| {
        let place = if j == 0 { k % SIDE } else { k / SIDE };
        let part = (place as f64 + 0.5) / SIDE as f64;
        if j == 0 {
            -4.0 + 5.0 * part
        } else {
            -6.0 + 12.0 * part
        }
    });
    let seeds = states.select_rows(&(0..states.nrows()).step_by(17).collect::<Vec<_>>());
    let found = find_attractors(&scene, &around, &seeds, &AttractorOptions::default())?;
    let phases = vec![0.0; states.nrows()];
    let options = BasinOptions::default();
    let cells = basin_cells(&scene, &found.all, &around, (&states, &phases), &options)?;
    assert_eq!(found.all.len(), 2);
    for (k, one) in found.all.iter().enumerate() {
        let label = Label::Attractor(k);
        let count = cells.labels.iter().filter(|own| **own == label).count();
        let part = count as f64 / states.nrows() as f64;
        println!(
            "at F = 9: {} of {} periods attracts {part:.3}",
            one.kind.name(),
            one.n_periods
        );
        assert!(part > 0.05);
    }
    Ok(())
}
