//! One stop hit, no mode resonant: two conditions in the three unknowns `(p, cos, sin)`, so the solutions are a line in
//! space, direction the cross product of the two rows, and the orbits are where it meets the circle (theory 5). Gives
//! what the singular value decomposition gives, where the rank is beyond doubt.

use crate::flow::along;
use crate::modal::Pair;
use crate::orbit::one_instant::periodic_conditions::PeriodicConditions;
use crate::orbit::one_instant::phases::{PhaseSolutions, chord};
use crate::tolerance::{CLEAR_DIRECTION, CLEAR_RANK};
use nalgebra::{DMatrix, DVector};

type Row = [f64; 3];

/// The two conditions for one stop hit, in the unknowns `(p, cos, sin)`: `rows[0] x = 0`, the normal velocity is
/// reversed; `rows[1] x = target`, the contact is where the stop is.
struct OneStop {
    rows: [Row; 2],
    target: f64,
    /// The units of p and of (cos, sin).
    units: Pair,
}

fn cross(a: Row, b: Row) -> Row {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn square(a: Row) -> f64 {
    a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
}

impl PeriodicConditions<'_> {
    /// The conditions for one stop hit that rests, one harmonic and no mode resonant, in units of order one; `None` in any other case.
    fn one_stop_conditions(&self) -> Option<OneStop> {
        let &[stop] = self.stops else { return None };
        let moves = self.scene.excitation.motion_of(stop).is_some();
        if !self.resonant.is_empty() || self.steady.len() > 1 || moves {
            return None;
        }
        let (scene, g) = (self.scene, &self.scene.geometry);
        let (velocity, position) = (&scene.velocity_rows[stop], &scene.position_rows[stop]);
        let (law, delassus) = (g.law(stop), g.give(stop, stop));
        let or_one = |x: f64| if x > 0.0 && x.is_finite() { x } else { 1.0 };
        let (w, push) = (or_one(scene.frequency), 1.0 / or_one(delassus.abs()));
        let speed = self.driven(0, velocity).map(|x| law.factor() * x);
        let place = self.driven(0, position).map(|x| w * x);
        let response = 1.0 / or_one(speed.iter().chain(&place).fold(0.0, |m, x| x.abs().max(m)));
        let repeat = law.residual(self.pushed(velocity, stop), delassus) * push;
        let contact = w * self.pushed(position, stop) * push;
        Some(OneStop {
            rows: [
                [repeat, speed[0] * response, speed[1] * response],
                [contact, place[0] * response, place[1] * response],
            ],
            target: w * (g.clearances[stop] - along(position, &self.equilibrium)),
            units: [push, response],
        })
    }
}

impl OneStop {
    /// The impulse at a given (cos, sin), in their units: by that of the two conditions in which rounding leaves more of it.
    fn impulse(&self, u: Pair) -> f64 {
        let by = |row: Row, target: f64| {
            // Of cos and sin both the smaller too has the rounding of the larger.
            let rounded = target.abs() + row[1].hypot(row[2]) * u[0].hypot(u[1]);
            let left = target - row[1] * u[0] - row[2] * u[1];
            (left / row[0], rounded / row[0].abs())
        };
        let [repeat, contact] = [by(self.rows[0], 0.0), by(self.rows[1], self.target)];
        if contact.1 < repeat.1 {
            contact.0
        } else {
            repeat.0
        }
    }
}

/// The solutions for a given clearance; `None` where more than one stop is hit, the force has several harmonics, modes are resonant,
/// or the rank is in doubt.
pub(crate) fn clearance_given(conditions: &PeriodicConditions<'_>) -> Option<PhaseSolutions> {
    let conditions = conditions.one_stop_conditions()?;
    let [repeat, contact] = conditions.rows;
    let normal = cross(repeat, contact);
    let volume = square(normal);
    // volume = (s1 s2)^2 and the squares of the rows add up to s1^2 + s2^2.
    let is_clear = volume > CLEAR_RANK * CLEAR_RANK * (square(repeat) + square(contact));
    let length = normal[1].hypot(normal[2]);
    if !(is_clear && length > CLEAR_DIRECTION * volume.sqrt()) {
        return None;
    }
    let [push, response] = conditions.units;
    let to_units = |x: Row, factor: f64| {
        [
            x[0] * push * factor,
            x[1] * response * factor,
            x[2] * response * factor,
        ]
    };
    let particular = to_units(cross(normal, repeat), conditions.target / volume);
    let direction = to_units(normal, 1.0 / volume.sqrt());
    let u = |x: Row| -> Pair { [x[1], x[2]] };
    let chord = chord(u(particular), u(direction));
    let point = |c: &f64| {
        let [cos, sin] = [1, 2].map(|i| particular[i] + c * direction[i]);
        let impulse = push * conditions.impulse([cos / response, sin / response]);
        DVector::from_vec(vec![impulse, cos, sin])
    };
    Some(PhaseSolutions {
        points: chord.ends().iter().map(point).collect(),
        margin: Some(chord.margin),
        basis: DMatrix::zeros(3, 0),
        is_any_phase: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::ModalScene;
    use crate::model::{Kind, PaperOptions, Parameter, paper_scene};
    use crate::orbit::one_instant::phases::meet_circle;

    #[test]
    fn the_line_in_space_is_the_solution_set_of_the_decomposition() {
        for (kind, stop) in [(Kind::Two, 0), (Kind::Three, 1)] {
            for i in 0..40 {
                let w = 0.3 + 0.07 * f64::from(i);
                let scene = paper_scene(kind, &PaperOptions::default())
                    .and_then(|s| s.replace(Parameter::Frequency.change(w)))
                    .and_then(|s| s.replace(Parameter::RESTITUTION.change(0.02 * f64::from(i))))
                    .expect("valid");
                let modal = ModalScene::new(&scene, "the test").expect("linear");
                let stops = [stop];
                let conditions =
                    PeriodicConditions::new(&modal, &stops, std::f64::consts::TAU * 2.0 / w);
                let fast = clearance_given(&conditions).expect("a clear rank");
                let set = conditions.at_clearance(None).expect("converges");
                let slow = meet_circle(&set, |x| conditions.phase_part(x)).expect("converges");
                let (a, b) = (fast.margin.expect("a line"), slow.margin.expect("a line"));
                assert!((a - b).abs() <= 1e-12 * (1.0 + b.abs()), "{w}: {a} {b}");
                assert_eq!(fast.points.len(), slow.points.len());
                for x in &fast.points {
                    let nearest = slow
                        .points
                        .iter()
                        .map(|y| (x - y).amax())
                        .fold(f64::INFINITY, f64::min);
                    assert!(nearest <= 1e-12 * x.amax(), "{w}: {nearest:e}");
                }
            }
        }
    }
}
