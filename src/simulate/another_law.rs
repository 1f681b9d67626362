#![cfg(test)]
//! A run with a law of contact that is none of the library's.

use crate::law::Cushion;
use crate::model::{Forcing, LinearSystem, Scene, Stop};
use crate::simulate::{ImpactSide, Method, Motion, SimulateOptions, Solver, simulate};
use nalgebra::{dmatrix, dvector};

/// A free body gives back of its speed what the law says of a spring with a dashpot, in the time that it says.
#[test]
fn a_free_body_is_given_back_what_another_law_says() {
    let (k, ratio) = (50.0, 0.3);
    let free = LinearSystem::new(dmatrix![2.0], dmatrix![0.0], dmatrix![0.0]).expect("valid");
    let rate = f64::sqrt(k / 2.0);
    let damped = rate * f64::sqrt(1.0 - ratio * ratio);
    let law = Cushion::law(k, 4.0 * ratio * rate);
    let stop = Stop::new(0, 0.5, law).expect("valid");
    let scene = Scene::new(free, Forcing::Unforced, [stop]).expect("valid");
    let given_back = f64::exp(-std::f64::consts::PI * ratio / f64::sqrt(1.0 - ratio * ratio));
    let back = 0.5 / 0.8 + std::f64::consts::PI / damped;
    for method in ["exact", "rk45", "dop853"] {
        let options = SimulateOptions {
            solver: Solver {
                method: Method::from_name(method).expect("a method"),
                rtol: 1e-11,
                ..Solver::default()
            },
            ..SimulateOptions::default()
        };
        let run = simulate(&scene, &dvector![0.0], &dvector![0.8], (0.0, 3.0), &options)
            .expect("regular");
        let (q, v) = run.state(3.0, ImpactSide::After).expect("within");
        assert!((v[0] + 0.8 * given_back).abs() < 1e-8, "{method}: {v}");
        assert!(
            (q[0] - 0.5 - (3.0 - back) * v[0]).abs() < 1e-8,
            "{method}: {q}"
        );
        assert_eq!(run.impacts().len(), 0);
        // What the spring has, and what the dashpot took.
        let energy = run.energy().expect("kept");
        let most = |values: &[f64]| values.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        assert!(most(&energy.balance) < 1e-8, "{method}");
        let taken = 0.64 * (1.0 - given_back * given_back);
        let lost = energy.contact_loss.last().expect("a last row");
        assert!((lost - taken).abs() < 1e-8, "{method}: {lost}");
        // At the touch the dashpot alone pushes, apart from the stop nothing does.
        let force = run.contact_force(0, Some(&[0.6, 0.625, 2.5]));
        let force = force.expect("kept");
        assert!(
            (force[1] - 4.0 * ratio * rate * 0.8).abs() < 1e-6,
            "{method}: {force:?}"
        );
        assert_eq!([force[0], force[2]], [0.0, 0.0], "{method}");
    }
}
