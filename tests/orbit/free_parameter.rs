//! Stops hit together, one parameter free: orbits that come in narrow pairs.

use crate::scenes::{linear, lower, upper};
use nalgebra::{Complex, dmatrix, dvector};
use vibroimpact::{
    FreeParameter, Harmonic, OrbitOptions, Parameter, Pattern, Scene, periodic_orbits,
};

fn scene(frequency: f64) -> Scene {
    let stiffness = dmatrix![3.0, -1.0; -1.0, 2.0];
    let system = linear(dmatrix![1.0, 0.2; 0.2, 1.5], &stiffness * 0.04, stiffness);
    let force = dvector![Complex::new(1.0, 0.0), Complex::new(0.3, 0.4)];
    let forcing = Harmonic::new(force, frequency, 0.0).expect("valid");
    let stops = [upper(0, 0.3, 0.6), lower(1, 0.2, 0.5)];
    Scene::new(system, forcing, stops).expect("valid")
}

/// `|L^-1 d|` at a frequency, for the scene's own force: the factor on the force at which the stops are hit together.
fn factor(frequency: f64, together: &Pattern) -> f64 {
    let orbits = periodic_orbits(&scene(frequency), together, &OrbitOptions::default());
    1.0 - orbits.expect("solved").margin().expect("regular")
}

#[test]
fn narrow_pairs_of_solutions_are_found() {
    let together = Pattern::together(&[0, 1]).expect("two stops");
    let (low, high) = (0.4, 4.7);
    let at = |i: u32| low + (high - low) * f64::from(i) / 3000.0;
    let values: Vec<f64> = (0..=3000).map(|i| factor(at(i), &together)).collect();
    let mut tried = 0;
    for i in 1..3000u32 {
        let k = i as usize;
        if !(values[k] < values[k - 1] && values[k] <= values[k + 1]) {
            continue;
        }
        // A least factor: a force a little above it has two frequencies about here.
        let (mut a, mut b) = (at(i - 1), at(i + 1));
        for _ in 0..80 {
            let (x, y) = (a + 0.382 * (b - a), a + 0.618 * (b - a));
            if factor(x, &together) < factor(y, &together) {
                b = y;
            } else {
                a = x;
            }
        }
        let middle = 0.5 * (a + b);
        for above in [1e-5, 1e-6, 1e-8] {
            let scale = factor(middle, &together) * (1.0 + above);
            let scaled = scene(1.0)
                .replace(Parameter::ForcingScale.change(scale))
                .expect("valid");
            let options = OrbitOptions {
                free: Some(FreeParameter::Parameter(Parameter::Frequency)),
                between: Some((low, high)),
                ..Default::default()
            };
            let found = periodic_orbits(&scaled, &together, &options).expect("solved");
            let frequencies: Vec<f64> = found
                .iter()
                .filter_map(|orbit| orbit.scene().forcing().frequency())
                .filter(|w| (w - middle).abs() < 0.005)
                .collect();
            assert_eq!(frequencies.len(), 2, "about {middle}: {}", found.reason());
            for &w in &frequencies {
                assert!((factor(w, &together) - scale).abs() < 1e-9 * scale);
            }
            assert!((frequencies[0] - middle) * (frequencies[1] - middle) < 0.0);
            assert!(!found.reason().contains("undecided"), "{}", found.reason());
        }
        tried += 1;
    }
    assert!(tried > 0, "no least factor in the range");
}
