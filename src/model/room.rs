//! Stops between which there is no room: no position keeps the rules of both.

use crate::model::constraint::Constraint;
use crate::model::scene::Scene;
use crate::model::stop::WallSide;
use crate::tolerance::ROOM_ROUNDING;
use nalgebra::DVector;

/// A rule `n.x <= c` on the coordinates, or on the horizontal place of a bob.
enum Bound {
    Position(DVector<f64>, f64),
    Bob(usize, WallSide, f64),
}

fn bound(stop: &Constraint, n_dof: usize) -> Option<Bound> {
    match stop {
        Constraint::Stop(stop) => Some(Bound::Position(stop.outward(n_dof), stop.clearance())),
        Constraint::Wall(wall) => Some(Bound::Bob(wall.bob(), wall.side(), wall.position())),
        Constraint::Nonlinear(_) => None,
    }
}

/// The room between two rules that are opposite to each other, in units of the first gap, and the size of its terms.
fn between(one: &Bound, other: &Bound) -> Option<(f64, f64)> {
    match (one, other) {
        (Bound::Position(n, c), Bound::Position(m, d)) => {
            // The length of n in that of m.
            let factor = n.norm() / m.norm();
            let is_opposite = (n + m * factor).amax() <= ROOM_ROUNDING * n.amax();
            is_opposite.then_some((c + factor * d, c.abs() + (factor * d).abs()))
        }
        (Bound::Bob(i, WallSide::Right, right), Bound::Bob(j, WallSide::Left, left))
        | (Bound::Bob(i, WallSide::Left, left), Bound::Bob(j, WallSide::Right, right))
            if i == j =>
        {
            Some((right - left, right.abs() + left.abs()))
        }
        _ => None,
    }
}

/// Pairs of stops opposite to each other that overlap, each with how much, in units of the gap of the first. Zero room is
/// room.
pub(crate) fn overlaps(scene: &Scene) -> Vec<(usize, usize, f64)> {
    let bounds: Vec<_> = scene
        .stops()
        .iter()
        .map(|stop| bound(stop, scene.n_dof()))
        .collect();
    let mut found = Vec::new();
    for (j, other) in bounds.iter().enumerate() {
        for (i, one) in bounds[..j].iter().enumerate() {
            let room = one
                .as_ref()
                .zip(other.as_ref())
                .and_then(|(one, other)| between(one, other));
            if let Some((room, size)) = room
                && room < -ROOM_ROUNDING * size
            {
                found.push((i, j, -room));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{DoublePendulum, Forcing, LinearSystem, Side, Stop, Wall};
    use nalgebra::dvector;

    fn overlap(stops: [Constraint; 2]) -> Vec<(usize, usize, f64)> {
        let ones = || dvector![1.0, 1.0];
        let system = LinearSystem::new(ones(), ones(), ones()).expect("valid");
        overlaps(&Scene::new(system, Forcing::Unforced, stops).expect("valid"))
    }

    #[test]
    fn opposite_stops_overlap_where_their_clearances_sum_to_less_than_nothing() {
        let pair = |upper: f64, lower: f64, length: f64| {
            let one = Stop::new(dvector![3.0, -4.0], upper, 0.5).expect("valid");
            let normal = dvector![3.0, -4.0] * length;
            let other = Stop::new(normal, lower * length, 0.5).expect("valid");
            overlap([one.into(), other.on_side(Side::Lower).into()])
        };
        for length in [1.0, 0.1, 1e6] {
            assert!(pair(-1.0, 1.0, length).is_empty() && pair(0.1, 0.2, length).is_empty());
            let [(0, 1, depth)] = pair(-1.0, 0.5, length)[..] else {
                panic!("no overlap of 1/2 at length {length}")
            };
            assert!((depth - 0.5).abs() < 1e-14);
        }
        // Normals that are not opposite leave a corner.
        let corner = [0, 1].map(|i| Stop::new(i, -1.0, 0.5).expect("valid").into());
        assert!(overlap(corner).is_empty());
    }

    #[test]
    fn walls_overlap_on_one_bob_alone() {
        let scene = |bob: usize, left: f64| {
            let right = Wall::new(0, 0.1, 0.5, WallSide::Right).expect("valid");
            let left = Wall::new(bob, left, 0.5, WallSide::Left).expect("valid");
            let pendulum = DoublePendulum::new(1.0, 1.0, (0.0, 0.0)).expect("valid");
            overlaps(&Scene::new(pendulum, Forcing::Unforced, [right, left]).expect("valid"))
        };
        assert!(scene(0, 0.1).is_empty() && scene(1, 0.3).is_empty());
        assert_eq!(scene(0, 0.3).len(), 1);
    }
}
