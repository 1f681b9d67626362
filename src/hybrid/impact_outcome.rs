//! The effect of an impact on one stop on others that are held at that instant (theory 9): it presses the motion onto them, and they take
//! impulses with it, or it throws the motion off them. The impact law of all of them together decides, as in a simulation.

use crate::error::Result;
use crate::hybrid::maps::{GapAt, HybridMaps};
use crate::impact::resolve_impacts;
use crate::law::{Regime, Transition};
use nalgebra::{DMatrix, DVector};

/// What an impact on one stop is in a regime.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ImpactOutcome {
    /// The impact, on the stop that is hit and on those held that take an impulse with it.
    pub transition: Transition,
    /// The stops that the motion is thrown off.
    pub thrown: Vec<usize>,
}

/// The effect of an impact on a stop on others that are held in the regime before it. The law has no scale: the result is the same for every speed.
///
/// # Errors
/// What the maps report; reactions with which no impulses keep the stops from closing.
pub(crate) fn impact_outcome<M: HybridMaps + ?Sized>(
    maps: &M,
    (hit, before): (usize, &Regime),
    t: f64,
    state: &DVector<f64>,
) -> Result<ImpactOutcome> {
    let others = before
        .constrained()
        .iter()
        .copied()
        .filter(|stop| *stop != hit);
    let stops: Vec<usize> = std::iter::once(hit).chain(others).collect();
    let count = stops.len();
    let (mut struck, mut thrown) = (vec![hit], Vec::new());
    if count == 1 {
        let transition = Transition::Strike(struck);
        return Ok(ImpactOutcome { transition, thrown });
    }
    let (mut gaps, mut reactions) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for &stop in &stops {
        let GapAt { gradient, .. } = maps.gap(stop, t, state)?;
        gaps.push(gradient);
        reactions.push(maps.reaction(stop, state)?);
    }
    let delassus = DMatrix::from_fn(count, count, |i, j| -gaps[i].dot(&reactions[j]));
    let restitutions = DVector::from_fn(count, |i, _| maps.law(stops[i]).restitution);
    let mut speeds = DVector::zeros(count);
    speeds[0] = -1.0;
    let law = resolve_impacts(&delassus, &restitutions, &speeds, &DVector::zeros(count))?;
    for (i, &stop) in stops.iter().enumerate().skip(1) {
        if law.opening_speeds[i] > 0.0 {
            thrown.push(stop);
        } else if law.impulses[i] > 0.0 {
            struck.push(stop);
        }
    }
    let transition = Transition::Strike(struck);
    Ok(ImpactOutcome { transition, thrown })
}

/// The transition by which a motion comes to rest on a stop in a regime: one impact where that takes all speed, impacts that accumulate
/// elsewhere. None where the impact throws the motion off another stop.
///
/// # Errors
/// As [`impact_outcome`].
pub(crate) fn landing_on<M: HybridMaps + ?Sized>(
    maps: &M,
    (stop, before): (usize, &Regime),
    t: f64,
    state: &DVector<f64>,
) -> Result<Option<Transition>> {
    if !maps.law(stop).is_inelastic() {
        return Ok(Some(Transition::Chatter(stop)));
    }
    let ImpactOutcome { transition, thrown } = impact_outcome(maps, (stop, before), t, state)?;
    Ok(thrown.is_empty().then_some(transition))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::ModalScene;
    use crate::hybrid::closed_form::ClosedFormMaps;
    use crate::model::{Forcing, LinearSystem, Scene, Stop};
    use nalgebra::{dmatrix, dvector};

    /// What an impact on the second stop does to the first one, which is held, of two masses coupled by their inertia.
    fn found(coupling: f64, second: f64) -> ImpactOutcome {
        let mass = dmatrix![1.0, coupling; coupling, 1.0];
        let system = LinearSystem::new(mass, DMatrix::zeros(2, 2), dmatrix![2.0, 0.0; 0.0, 3.0]);
        let stops = [
            Stop::new(dvector![1.0, 0.0], 0.0, 0.3),
            Stop::new(dvector![0.0, second], 0.0, 0.5),
        ];
        let stops = stops.map(|stop| stop.expect("valid"));
        let scene = Scene::new(system.expect("definite"), Forcing::Unforced, stops);
        let modal = ModalScene::of(&scene.expect("valid"), "test").expect("linear");
        let maps = ClosedFormMaps::new(&modal, 0.0, Vec::new());
        impact_outcome(&maps, (1, &Regime::holding([0])), 0.0, &DVector::zeros(4))
            .expect("solvable")
    }

    #[test]
    fn a_stop_that_is_held_is_pressed_thrown_off_or_left_alone() {
        // M^-1 = [1, -c; -c, 1]/(1 - c^2): an impulse p on the second normal changes the speed along the first by c p/(1 - c^2).
        let c = 0.4;
        let thrown = found(-c, 1.0);
        assert_eq!(thrown.transition.struck(), [1]);
        assert_eq!(thrown.thrown, [0]);
        let pressed = found(-c, -1.0);
        assert_eq!(pressed.transition.struck(), [1, 0]);
        assert!(pressed.thrown.is_empty());
        let alone = found(0.0, 1.0);
        assert_eq!(alone.transition.struck(), [1]);
        assert!(alone.thrown.is_empty());
    }
}
