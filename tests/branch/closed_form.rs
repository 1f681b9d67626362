//! Branches of one degree of freedom lie on their closed form, all along.

use crate::scenes::{Oscillator, USUAL, followed};
use vibroimpact::{Branch, ContinuationOptions, Parameter, Virtual};

/// All points lie on the closed form.
fn check(own: Oscillator, n_periods: usize, parameter: Parameter, branch: &Branch) {
    for (orbit, &value) in branch.orbits.iter().zip(&branch.parameter) {
        let speed = orbit.impacts()[0].approach;
        let miss = own.at(parameter, value).miss(n_periods, speed);
        assert!(miss.abs() < 1e-9, "{parameter} {value}: {miss:e}");
    }
}

#[test]
fn every_point_lies_on_the_closed_form() {
    let keep = ContinuationOptions {
        beyond: Virtual::Keep,
        ..ContinuationOptions::default()
    };
    let ranges = [
        (Parameter::ForcingScale, (0.2, 3.0)),
        (Parameter::Frequency, (1.5, 3.5)),
        (Parameter::CLEARANCE, (-1.0, 2.5)),
        (Parameter::RESTITUTION, (0.0, 1.0)),
        (Parameter::DampingScale, (0.0, 4.0)),
    ];
    for n_periods in [1, 2] {
        let orbit = &USUAL.orbits(n_periods)[0];
        for (parameter, range) in ranges {
            let branch = followed(orbit, parameter, range, &keep);
            check(USUAL, n_periods, parameter, &branch);
        }
    }
}

#[test]
fn a_branch_goes_round_its_fold() {
    // Preloaded: orbits are born in pairs at F = 0.39322555956.
    let own = Oscillator {
        force: 1.0,
        frequency: 2.8,
        clearance: -0.5,
        ..USUAL
    };
    let orbit = &own.orbits(1)[0];
    let branch = followed(
        orbit,
        Parameter::ForcingScale,
        (0.2, 5.0),
        &ContinuationOptions::default(),
    );
    check(own, 1, Parameter::ForcingScale, &branch);
    let least = branch
        .parameter
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    assert!((least - 0.393_225_563_977_3).abs() < 1e-3, "{least}");
    // From a slow impact to a fast one, over the fold between them.
    let speeds: Vec<f64> = (branch.orbits.iter().map(|own| own.impacts()[0].approach)).collect();
    let is_rising = speeds.windows(2).all(|pair| pair[0] < pair[1]);
    assert!(is_rising || speeds.windows(2).all(|pair| pair[0] > pair[1]));
    let lowest = branch.parameter.iter().position(|p| *p == least);
    assert!(lowest.is_some_and(|k| k > 0 && k + 1 < branch.orbits.len()));
}
