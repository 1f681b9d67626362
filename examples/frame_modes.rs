//! A cantilever with a mass at its tip between two stops, by forty modes of a finite-element model.
//!
//! A steel strip of twenty Euler-Bernoulli elements carries twice its own mass at the tip, which a harmonic force shakes and a
//! stop on each side holds within 2 mm. The modes are all that goes into the scene: unit modal masses, 2 % damping, squared
//! frequencies, and the mode shapes at the tip. You will see the tip's stiffness beside `3 E I / L^3` and the first frequency
//! beside the root of the beam's frequency equation; then where, over the forcing frequency and the clearance, the tip has
//! a motion that hits each stop once in each period, and a simulation from rest that settles on one. `frame_modes.py`
//! draws both.

use std::f64::consts::TAU;
use vibroimpact::nalgebra::{Complex, DMatrix, DVector, Matrix4};
use vibroimpact::{
    Axis, Harmonic, LinearSystem, OrbitOptions, Pattern, Result, Scene, Side, SimulateOptions,
    Stop, SweepOptions, existence_map, modes, periodic_orbits, simulate,
};

/// \[m\]
const LENGTH: f64 = 0.5;
/// E I \[N m^2\]: steel, 20 mm by 3 mm.
const BENDING: f64 = 210e9 * 0.02 * 0.003 * 0.003 * 0.003 / 12.0;
/// \[kg/m\]
const LINE_MASS: f64 = 7850.0 * 0.02 * 0.003;
/// In masses of the beam.
const TIP_MASS: f64 = 2.0;
const N_ELEMENTS: usize = 20;
/// Of every mode.
const DAMPING: f64 = 0.02;
/// At the tip \[N\].
const FORCE: f64 = 0.3;
/// On each side of the tip \[m\].
const CLEARANCE: f64 = 2e-3;
const RESTITUTION: f64 = 0.6;
/// Of the simulation \[Hz\].
const FREQUENCY: f64 = 4.5;

/// Mass and stiffness of the clamped beam with its tip mass; coordinates: deflection and slope at each node.
#[rustfmt::skip]
fn beam() -> (DMatrix<f64>, DMatrix<f64>) {
    let h = LENGTH / N_ELEMENTS as f64;
    let mass = Matrix4::new(
        156.0,     22.0 * h,     54.0,     -13.0 * h,
        22.0 * h,  4.0 * h * h,  13.0 * h, -3.0 * h * h,
        54.0,      13.0 * h,     156.0,    -22.0 * h,
        -13.0 * h, -3.0 * h * h, -22.0 * h, 4.0 * h * h,
    ) * (LINE_MASS * h / 420.0);
    let stiffness = Matrix4::new(
        12.0,    6.0 * h,     -12.0,    6.0 * h,
        6.0 * h, 4.0 * h * h, -6.0 * h, 2.0 * h * h,
        -12.0,   -6.0 * h,    12.0,     -6.0 * h,
        6.0 * h, 2.0 * h * h, -6.0 * h, 4.0 * h * h,
    ) * (BENDING / h.powi(3));
    let size = 2 * (N_ELEMENTS + 1);
    let (mut m, mut k) = (DMatrix::zeros(size, size), DMatrix::zeros(size, size));
    for first in (0..size - 2).step_by(2) {
        let mut nodes = m.fixed_view_mut::<4, 4>(first, first);
        nodes += mass;
        let mut nodes = k.fixed_view_mut::<4, 4>(first, first);
        nodes += stiffness;
    }
    m[(size - 2, size - 2)] += TIP_MASS * LINE_MASS * LENGTH;
    (m.remove_rows(0, 2).remove_columns(0, 2), k.remove_rows(0, 2).remove_columns(0, 2))
}

/// Zero at `b = L (rho A w^2 / E I)^(1/4)` of a clamped beam with a tip mass.
fn frequency_equation(b: f64) -> f64 {
    let bending = b.cos() * b.sinh() - b.sin() * b.cosh();
    1.0 + b.cos() * b.cosh() + TIP_MASS * b * bending
}

/// The root between two values at which the sign differs.
fn root(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if function(low) * function(middle) <= 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

/// The model beside the continuous beam: cubic elements are too stiff by less than `(b / n)^4 / 720` in a frequency, and carry
/// a static force at the tip exactly; the rounding of the lowest mode is that of the highest squared frequency.
fn check_modes(frequencies: &DVector<f64>, tip: &DVector<f64>) {
    let rounding = f64::EPSILON * (frequencies.max() / frequencies[0]).powi(2);
    let b = root(frequency_equation, 0.5, 2.0);
    let exact = b * b * (BENDING / (LINE_MASS * LENGTH.powi(4))).sqrt();
    println!(
        "first frequency {:.7} Hz, closed form {:.7} Hz",
        frequencies[0] / TAU,
        exact / TAU
    );
    let excess = frequencies[0] / exact - 1.0;
    assert!(-rounding < excess && excess < (b / N_ELEMENTS as f64).powi(4) / 720.0 + rounding);
    let stiffness = 1.0
        / tip
            .zip_map(frequencies, |shape, w| (shape / w).powi(2))
            .sum();
    let exact = 3.0 * BENDING / LENGTH.powi(3);
    println!("stiffness of the tip {stiffness:.6} N/m, closed form {exact:.6} N/m");
    assert!((stiffness - exact).abs() < rounding * exact);
}

/// The scene in modal coordinates: `q` are the modes' amplitudes, `tip.q` is the tip's deflection.
fn tip_between_stops(frequencies: &DVector<f64>, tip: &DVector<f64>) -> Result<Scene> {
    let ones = DVector::from_element(frequencies.len(), 1.0);
    let system = LinearSystem::new(
        ones,
        frequencies * (2.0 * DAMPING),
        frequencies.component_mul(frequencies),
    )?;
    let force = Harmonic::new(
        tip.map(|shape| Complex::from(FORCE * shape)),
        TAU * FREQUENCY,
        0.0,
    )?;
    let upper = Stop::new(tip.clone(), CLEARANCE, RESTITUTION)?;
    let lower = upper.clone().on_side(Side::Lower);
    Scene::new(system, force, [upper, lower])
}

/// A simulation from rest, whose last impacts have the speed of the stable orbit.
fn check_run(scene: &Scene, both: &Pattern) -> Result<()> {
    let orbits = periodic_orbits(scene, both, &OrbitOptions::default())?;
    assert!(
        orbits[0].is_admissible() == Some(true) && orbits[0].stability()?.is_stable == Some(true)
    );
    let rest = DVector::zeros(scene.n_dof());
    let run = simulate(
        scene,
        &rest,
        &rest,
        (0.0, 60.0 / FREQUENCY),
        &SimulateOptions::default(),
    )?;
    let last = run.impacts()[run.impacts().len() - 1];
    let speed = orbits[0].impacts()[0].approach;
    println!(
        "{} impacts, the last at {:.8} m/s; the orbit's at {speed:.8} m/s",
        run.impacts().len(),
        last.approach
    );
    assert!((last.approach - speed).abs() < 1e-6 * speed);
    Ok(())
}

/// The map, a letter a cell: S stable, A admissible, o inadmissible.
fn print_map(scene: &Scene, both: &Pattern) -> Result<()> {
    let frequencies = Axis::new(
        "frequency".parse()?,
        (0..25).map(|i| TAU * (2.0 + 0.25 * f64::from(i))),
    );
    let clearances = Axis::new(
        "clearance".parse()?,
        (1..=12).rev().map(|j| 5e-4 * f64::from(j)),
    );
    let map = existence_map(
        scene,
        both,
        (&frequencies, &clearances),
        1,
        SweepOptions::default(),
    )?;
    println!("clearance [mm]; to the right: forcing frequency, 2 to 8 Hz");
    for (j, clearance) in map.y.iter().enumerate() {
        let row = (0..map.x.len())
            .map(|i| map.point(i, j))
            .map(|cell| match cell {
                cell if cell.is_stable => 'S',
                cell if cell.is_admissible => 'A',
                cell if cell.n_orbits > 0 => 'o',
                _ => '.',
            });
        println!("{:>4.1}  {}", 1e3 * clearance, row.collect::<String>());
    }
    Ok(())
}

fn main() -> Result<()> {
    let (mass, stiffness) = beam();
    let still = DMatrix::zeros(mass.nrows(), mass.ncols());
    let modes = modes(&LinearSystem::new(mass, still, stiffness)?)?;
    let frequencies = &modes.natural_frequencies;
    let deflection = modes.shapes.nrows() - 2;
    let tip = modes
        .shapes
        .row(deflection)
        .map(|shape| shape.re)
        .transpose();
    check_modes(frequencies, &tip);
    let scene = tip_between_stops(frequencies, &tip)?;
    let both = Pattern::new(vec![vec![0], vec![1]])?;
    check_run(&scene, &both)?;
    print_map(&scene, &both)
}
