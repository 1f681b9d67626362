//! What the rules of contact say of the orbits of a branch, against samples of their gaps.

use crate::scenes::followed;
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    ContinuationOptions, Harmonic, LinearSystem, Parameter, Scene, SimulateOptions, Stop, Virtual,
    find_orbit, simulate,
};

#[test]
fn a_stop_that_is_passed_behind_a_release_is_seen() {
    // Two masses before a stop that takes all speed: along the branch the flight behind the release comes back to the stop, and passes it.
    let stiffness = dmatrix![
        3.920_111_074_504_845_3, -1.851_416_477_874_136_9;
        -1.851_416_477_874_136_9, 3.866_230_239_550_701
    ];
    let damping = dmatrix![0.151_939_312_383_485_46, 0.0; 0.0, 0.151_939_312_383_485_46];
    let system = LinearSystem::new(dvector![1.0, 1.0], damping, stiffness).expect("valid");
    let force = dvector![2.475_749_823_533_228_7.into(), 2.851_617_267_853_695.into()];
    let force = Harmonic::new(force, 0.763_525_880_667_199_8, 0.0).expect("valid");
    let clearance = 0.630_989_717_028_171_5;
    let stop = Stop::new(0, clearance, 0.0).expect("valid");
    let scene = Scene::new(system, force, [stop]).expect("valid");
    let (q, v) = (dvector![-0.6, -0.6], dvector![0.0, 0.0]);
    let until = 60.0 * scene.period().expect("forced");
    let run = simulate(&scene, &q, &v, (0.0, until), &SimulateOptions::default());
    let orbit = find_orbit(&scene, &run.expect("a run"), None).expect("an orbit");
    let keep = ContinuationOptions {
        beyond: Virtual::Keep,
        ..Default::default()
    };
    let branch = followed(&orbit, Parameter::ForcingScale, (0.5, 1.6), &keep);
    let mut passed = 0;
    for (orbit, value) in branch.orbits.iter().zip(&branch.parameter) {
        let each = (0..4000).map(|k| orbit.period() * f64::from(k) / 4000.0);
        let gaps = each.map(|t| clearance - orbit.state(t, false).0[0]);
        let least = gaps.fold(f64::INFINITY, f64::min);
        if least < -1e-9 {
            assert_eq!(orbit.is_admissible(), Some(false), "{value}: {least}");
            passed += 1;
        }
    }
    assert!(passed > 5, "{passed}");
}
