//! What the library is asked: an orbit of a body, and the branch that it is on.

use crate::body::{Body, Number};
use crate::chain::Kind;
use crate::draw::start;
use crate::random::Random;
use std::ops::ControlFlow;
use vibroimpact::{
    Branch, ContinuationOptions, PeriodicOrbit, SimulateOptions, continuation, continuation_of,
    find_orbit, simulate,
};

/// So many periods of the forcing a motion is given to settle.
const PERIODS: f64 = 60.0;

/// The orbit that a body comes to, if it is found.
pub fn settled(random: &mut Random, body: &Body) -> Option<PeriodicOrbit> {
    let scene = body.scene().expect("valid");
    let [q, v] = start(random, body);
    let options = SimulateOptions {
        max_impacts: Some(5_000),
        ..Default::default()
    };
    let span = (0.0, PERIODS * scene.period().expect("shaken"));
    let run = simulate(&scene, &q, &v, span, &options).ok()?;
    find_orbit(&scene, &run, None).ok()
}

/// The branch of an orbit over a number: of the place of a wall by scenes of one's own.
pub fn followed(
    orbit: &PeriodicOrbit,
    body: &Body,
    (number, range): (Number, (f64, f64)),
    options: &ContinuationOptions,
) -> vibroimpact::Result<Branch> {
    let go_on = &mut |_| ControlFlow::Continue(());
    let is_wall = matches!(number, Number::Room(face) if matches!(body.faces()[face].kind, Kind::Wall { .. }));
    if is_wall {
        let make = |value: f64| body.with(number, value).scene();
        return continuation_of(orbit, &make, body.value(number), range, options, go_on);
    }
    continuation(orbit, number.parameter(), range, options, go_on)
}
