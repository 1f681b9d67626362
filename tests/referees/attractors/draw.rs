//! Scenes at random: one or two masses before one or two stops, from soft to hard, from hardly driven to chaos.

use crate::random::Random;
use nalgebra::{Complex, DMatrix, DVector, dmatrix, dvector};
use vibroimpact::{Harmonic, LinearSystem, Scene, Side, StateBox, Stop, nalgebra};

/// A scene, the box in which its motions begin, and some states of it.
pub struct Case {
    pub scene: Scene,
    pub around: StateBox,
    pub seeds: DMatrix<f64>,
    pub cells: DMatrix<f64>,
}

/// One at random.
pub fn case(random: &mut Random, (seeds, cells): (usize, usize)) -> Case {
    let n = if random.chance(65) { 1 } else { 2 };
    let damping = random.log(0.02, 0.4);
    let frequency = random.between(0.6, 3.2);
    let force = random.log(0.3, 10.0);
    let system = if n == 1 {
        LinearSystem::new(dvector![1.0], dmatrix![damping], dmatrix![1.0])
    } else {
        let (mass, tie) = (random.between(0.5, 2.0), random.between(0.3, 2.0));
        let stiffness = dmatrix![1.0 + tie, -tie; -tie, 1.0 + tie];
        let damping = damping * &stiffness;
        LinearSystem::new(dvector![1.0, mass], damping, stiffness)
    };
    let mut amplitude = DVector::zeros(n);
    amplitude[random.below(n)] = Complex::new(force, 0.0);
    let driven = Harmonic::new(amplitude, frequency, 0.0).expect("valid");
    let restitution = |random: &mut Random| {
        if random.chance(10) {
            0.0
        } else {
            random.between(0.0, 0.95)
        }
    };
    let near = random.between(0.05, 1.5);
    let mut stops = vec![stop(random.below(n), near, restitution(random))];
    if random.chance(40) {
        let far = random.between(0.05, 1.5);
        stops.push(stop(random.below(n), far, restitution(random)).on_side(Side::Lower));
    }
    let scene = Scene::new(system.expect("valid"), driven, stops).expect("valid");
    // About as far as the motion goes without a stop.
    let wide = near + force / (1.0 - frequency * frequency).abs().max(0.5);
    let sides = |sign: f64| {
        DVector::from_fn(2 * n, |i, _| {
            sign * wide * if i < n { 1.0 } else { frequency }
        })
    };
    let around = StateBox::new(sides(-1.0), sides(1.0)).expect("a box");
    let high = sides(1.0);
    let mut states =
        |count: usize| DMatrix::from_fn(count, 2 * n, |_, i| random.between(-high[i], high[i]));
    Case {
        seeds: states(seeds),
        cells: states(cells),
        scene,
        around,
    }
}

fn stop(mass: usize, clearance: f64, restitution: f64) -> Stop {
    Stop::new(mass, clearance, restitution).expect("valid")
}
