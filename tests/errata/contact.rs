//! Conditions (9), (20), section 3, section 5 and Note 1: what an orbit must do at the wall.

use crate::first_kind::{determinants, has_one_solution_printed, terms};
use crate::library::interleaved;
use crate::system::{Case, KIND_1, KIND_2, KIND_3};
use crate::{FAILS, fails, holds};

fn leaves_printed(velocity_after: f64) -> bool {
    velocity_after >= 0.0
}

fn leaves(velocity_after: f64) -> bool {
    velocity_after <= 0.0
}

/// Conditions (9), (20): after the impact the velocities are `<= 0`. The phase half a turn on gives the mirror image,
/// which the printed condition accepts. Judge: the gap a moment later.
#[test]
fn equations_9_20_sign_of_the_velocities() {
    let good = KIND_1.with_equal_contacts();
    for (case, stays_below) in [(good, true), (good.turned(), false)] {
        let (z, start) = case.orbit(&case.recovery(1));
        let soon = (case.state_matrix() * 0.05).exp() * z + case.steady_state(0.05);
        for i in [0, 2] {
            let gap = start[i] - soon[i];
            fails(if stays_below { gap } else { -gap });
            assert_eq!(leaves(start[i + 1]), stays_below);
            assert_eq!(leaves_printed(start[i + 1]), !stays_below);
        }
        let ours = &case.orbits(1)[0];
        holds((interleaved(&ours.q0(), &ours.v0()) - start).amax());
        assert_eq!(ours.is_admissible(), Some(stays_below));
    }
}

/// Section 3 and (29): `theta10 = theta20 = theta0` does not follow from periodicity. Kinds 2 and 3 touch with one
/// pendulum only; in kind 1 both contact positions come out of (29) and agree at one phase. Judge: the dense solution.
#[test]
fn section_3_contact_positions() {
    let mismatch = |case: &Case, kind| {
        let x = case.orbit(&case.recovery(kind)).1;
        (x[0] - x[2]).abs()
    };
    fails(mismatch(&KIND_2, 2));
    fails(mismatch(&KIND_3, 3));
    fails(mismatch(&KIND_1, 1));
    holds(mismatch(&KIND_1.with_equal_contacts(), 1));
    for (case, kind) in [(KIND_1, 1), (KIND_2, 2), (KIND_3, 3)] {
        let ours = case.orbits(kind)[0].q0();
        holds(((ours[0] - ours[1]).abs() - mismatch(&case, kind)).abs());
    }
}

/// Section 5 takes kinds 2 and 3 "from (37)", which is R1's and needs `k2 p2 = m2 n2`; (38) is meant. Judge: (38)'s
/// solution leaves the velocity of the pendulum that is not hit continuous, which R1 does not.
#[test]
fn section_5_kinds_2_and_3() {
    for (case, kind, free) in [(KIND_2, 2, 3), (KIND_3, 3, 1)] {
        fails(determinants(&terms(&case))[1].abs());
        let jump = |recovery| {
            let (z, start) = case.orbit(&recovery);
            let end = (case.state_matrix() * case.period()).exp() * z + case.steady_state(0.0);
            (end[free] - start[free]).abs()
        };
        fails(jump(case.recovery(1)));
        holds(jump(case.recovery(kind)));
        let (orbits, start) = (case.orbits(kind), case.orbit(&case.recovery(kind)).1);
        holds((interleaved(&orbits[0].q0(), &orbits[0].v0()) - start).amax());
    }
}

/// Note 1 and Theorem 1: an orbit may satisfy (20), with its sign put right, and (32), with equal contact positions,
/// and cross the wall between its impacts. Judge: the gap along the orbit.
#[test]
fn note_1_orbit_through_the_wall() {
    let kept = KIND_1.with_equal_contacts();
    let crossing = Case {
        n: 5,
        stiffness_damping: 0.2,
        ..KIND_1
    }
    .with_equal_contacts();
    for case in [kept, crossing] {
        let start = case.orbit(&case.recovery(1)).1;
        assert!(has_one_solution_printed(&terms(&case)) && start[0] > FAILS);
        assert!(leaves(start[1]) && leaves(start[3]));
        holds((start[0] - start[2]).abs());
    }
    assert!(kept.lowest_gap() > 0.0);
    fails(-crossing.lowest_gap());
    assert!(kept.orbits(1)[0].is_admissible() == Some(true));
    let orbits = crossing.orbits(1);
    let violation = orbits[0].violation().expect("it crosses");
    assert!(violation.depth >= -crossing.lowest_gap());
}
