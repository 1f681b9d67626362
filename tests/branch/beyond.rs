//! What becomes of motions beyond boundaries, in scenes whose answer is known.

use crate::random::Random;
use crate::scenes::{USUAL, followed, settled};
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    Beyond, BeyondOptions, BeyondOutcome, Branch, ContinuationOptions, ContinuationParameter,
    Error, Harmonic, LinearSystem, Parameter, Scene, Special, SpecialKind, Stop, beyond,
};

fn seen(
    special: &Special,
    parameter: Parameter,
    between: (f64, f64),
    options: BeyondOptions,
) -> Result<Beyond, Error> {
    let random = &mut Random::of_case(5, 0);
    let kick = &mut |count: usize| Ok((0..count).map(|_| random.between(-1.0, 1.0)).collect());
    let number = ContinuationParameter::Number(parameter);
    beyond(special, number, between, options, kick)
}

fn one_of(branch: &Branch, kind: SpecialKind) -> &Special {
    let mut own = branch.special.iter().filter(|own| own.kind == kind);
    own.next().expect("a special point")
}

const RANGE: (f64, f64) = (0.1, 1.5);

fn usual() -> Branch {
    let orbit = &USUAL.orbits(1)[0];
    followed(
        orbit,
        Parameter::ForcingScale,
        RANGE,
        &ContinuationOptions::default(),
    )
}

#[test]
fn where_an_impact_is_lost_the_motion_that_hits_nothing_goes_on() {
    let branch = usual();
    let special = one_of(&branch, SpecialKind::LostImpact);
    let found = seen(
        special,
        Parameter::ForcingScale,
        RANGE,
        BeyondOptions::default(),
    );
    let found = found.expect("an answer");
    assert_eq!(found.outcome, BeyondOutcome::Continues);
    assert!(
        found
            .candidates
            .iter()
            .any(|own| own.orbit.impacts().is_empty())
    );
}

#[test]
fn what_is_no_boundary_and_no_distance_is_refused() {
    let branch = usual();
    let number = Parameter::ForcingScale;
    let smooth = one_of(&branch, SpecialKind::PeriodDoubling);
    let boundary = one_of(&branch, SpecialKind::LostImpact);
    let options = BeyondOptions::default();
    let none = BeyondOptions {
        periods: 0,
        ..options
    };
    for (special, options) in [
        (smooth, options),
        (boundary, none),
        (
            boundary,
            BeyondOptions {
                delta: Some(0.0),
                ..options
            },
        ),
        (
            boundary,
            BeyondOptions {
                delta: Some(f64::NAN),
                ..options
            },
        ),
    ] {
        let refused = seen(special, number, RANGE, options);
        assert!(
            matches!(refused, Err(Error::BadValue { .. })),
            "{refused:?}"
        );
    }
    let energy = ContinuationParameter::Energy;
    let kick = &mut |count: usize| Ok(vec![0.0; count]);
    let refused = beyond(boundary, energy, RANGE, options, kick);
    assert!(matches!(refused, Err(Error::BadValue { .. })));
}

#[test]
fn beyond_the_border_of_a_chatter_the_motion_goes_on() {
    // x'' + x = cos w t before a stop: the stick shrinks to nothing at a clearance that is known to 18 digits.
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], 0.3, 0.0).expect("valid");
    let stop = Stop::new(0, 0.0, 0.8).expect("valid");
    let scene = Scene::new(system, force, [stop]).expect("valid");
    let orbit = settled(&scene, -0.5, 40).expect("an orbit");
    let (number, range) = (Parameter::CLEARANCE, (-0.2, 0.3));
    let branch = followed(&orbit, number, range, &ContinuationOptions::default());
    let border = one_of(&branch, SpecialKind::ChatterBorder);
    assert!((border.parameter - 0.123_448_597_848_029_15).abs() < 1e-9);
    let found = seen(border, number, range, BeyondOptions::default()).expect("an answer");
    assert_eq!(found.outcome, BeyondOutcome::Continues, "{}", found.reason);
}
