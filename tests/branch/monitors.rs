//! Functions of orbits along a branch: their zeros lie where the closed form says, and a jump is none.

use crate::scenes::{Oscillator, USUAL, followed};
use vibroimpact::{
    Branch, ContinuationOptions, ContinuationParameter, Error, Parameter, PeriodicOrbit, Virtual,
};

const FORCE: ContinuationParameter<'_> = ContinuationParameter::Number(Parameter::ForcingScale);

/// A branch over the force, through its fold where it has one in the range.
fn branch(own: Oscillator, range: (f64, f64)) -> Branch {
    let options = ContinuationOptions {
        beyond: Virtual::Keep,
        ..ContinuationOptions::default()
    };
    let orbit = own.orbits(1).swap_remove(0);
    followed(&orbit, Parameter::ForcingScale, range, &options)
}

fn speed(orbit: &PeriodicOrbit) -> f64 {
    orbit.impacts()[0].approach
}

#[test]
fn a_speed_is_reached_at_the_force_of_the_closed_form() {
    let branch = branch(USUAL, (0.3, 3.0));
    for wanted in [1.0, 2.0, 3.5, 6.0] {
        let measure = &mut |own: &PeriodicOrbit| Ok(speed(own) - wanted);
        let found = branch.monitored(FORCE, "speed", measure).expect("zeros");
        let known = USUAL.force_of(1, wanted) / USUAL.force;
        let [zero] = found.zeros.as_slice() else {
            panic!("{wanted}: {} zeros", found.zeros.len());
        };
        assert!(
            (zero.parameter - known).abs() < 1e-11,
            "{wanted}: {}",
            zero.parameter - known
        );
        assert!(zero.error < 1e-9 && (speed(&zero.orbit) - wanted).abs() < 1e-9);
        let values = branch.orbits.iter().map(|own| speed(own) - wanted);
        assert_eq!(found.values, values.collect::<Vec<f64>>());
        let beside = branch
            .arclength
            .partition_point(|own| *own < zero.arclength);
        let between = [branch.parameter[beside - 1], branch.parameter[beside]];
        assert!(between[0] < zero.parameter && zero.parameter < between[1]);
    }
}

#[test]
fn a_value_beside_a_fold_has_an_orbit_on_each_side_of_it() {
    // Preloaded: the branch turns at the least force, below which there is no orbit.
    let own = Oscillator {
        clearance: -0.5,
        ..USUAL
    };
    let branch = branch(own, (0.01, 3.0));
    let fold = own.force_of(1, own.fold_speed(1)) / own.force;
    let value = fold + 0.05;
    let there = branch.at(FORCE, value).expect("orbits");
    assert_eq!(there.len(), 2);
    for orbit in &there {
        assert!(
            own.at(Parameter::ForcingScale, value)
                .miss(1, speed(orbit))
                .abs()
                < 1e-9
        );
    }
    assert!((speed(&there[0]) - speed(&there[1])).abs() > 0.1);
}

#[test]
fn a_jump_is_no_zero_and_what_is_no_number_is_refused() {
    let branch = branch(USUAL, (0.3, 3.0));
    let jump = &mut |own: &PeriodicOrbit| Ok(if speed(own) < 2.0 { -1.0 } else { 1.0 });
    let found = branch.monitored(FORCE, "jump", jump).expect("values");
    assert!(found.zeros.is_empty() && found.values.contains(&-1.0));
    let none = branch.monitored(FORCE, "none", &mut |_| Ok(f64::NAN));
    let error = none.expect_err("no number").to_string();
    assert!(
        error.starts_with("monitor['none'] at point 0 is NaN"),
        "{error}"
    );
    let failed = branch.monitored(FORCE, "failed", &mut |_| Err(Error::Interrupted));
    assert_eq!(failed.err(), Some(Error::Interrupted));
}
