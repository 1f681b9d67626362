//! The stops of a scene as contacts of a motion: gap, its time derivatives, normal, reaction, at any position (theory 1, 2).

use crate::model::dynamics::factored_mass;
use crate::model::stop::WallSide;
use crate::model::{Constraint, Reaction, Scene, Side, System};
use nalgebra::DVector;

/// A surface that the motion may not cross.
#[derive(Debug, Clone)]
pub(crate) enum Surface {
    /// `clearance - n.q`
    Plane {
        normal: DVector<f64>,
        clearance: f64,
    },
    /// `sign (position - sum l_i sin q_i)` over the links up to a pendulum's bob.
    Wall {
        lengths: Vec<f64>,
        position: f64,
        sign: f64,
    },
}

/// A gap with its first two time derivatives, and the size of the terms it was summed from.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct GapValue {
    pub gap: f64,
    pub speed: f64,
    pub acceleration: f64,
    pub size: f64,
}

impl Surface {
    /// The gap along a motion, `h'' = -n.a + kappa`.
    #[inline]
    pub fn along(&self, q: &[f64], v: &[f64], a: &[f64]) -> GapValue {
        match self {
            Self::Plane { normal, clearance } => {
                let mut value = GapValue {
                    gap: *clearance,
                    size: clearance.abs(),
                    ..GapValue::default()
                };
                for (((n, q), v), a) in normal.as_slice().iter().zip(q).zip(v).zip(a) {
                    value.gap -= n * q;
                    value.speed -= n * v;
                    value.acceleration -= n * a;
                    value.size += (n * q).abs();
                }
                value
            }
            Self::Wall {
                lengths,
                position,
                sign,
            } => {
                let mut value = GapValue {
                    gap: sign * position,
                    size: position.abs(),
                    ..GapValue::default()
                };
                for (((l, q), v), a) in lengths.iter().zip(q).zip(v).zip(a) {
                    let (sin, cos) = q.sin_cos();
                    value.gap -= sign * l * sin;
                    value.speed -= sign * l * cos * v;
                    value.acceleration -= sign * l * (cos * a - sin * v * v);
                    value.size += (l * sin).abs();
                }
                value
            }
        }
    }

    /// The normal `n = -grad h` towards the stop.
    pub fn normal(&self, q: &[f64]) -> DVector<f64> {
        match self {
            Self::Plane { normal, .. } => normal.clone(),
            Self::Wall { lengths, sign, .. } => DVector::from_fn(q.len(), |i, _| {
                lengths.get(i).map_or(0.0, |l| sign * l * q[i].cos())
            }),
        }
    }

    /// A bound on the sum of the normal's entries over all positions: the gap moves by no more than this times the largest
    /// change of a coordinate.
    pub fn steepness(&self) -> f64 {
        match self {
            Self::Plane { normal, .. } => normal.lp_norm(1),
            Self::Wall { lengths, .. } => lengths.iter().sum(),
        }
    }
}

/// One stop as a contact.
#[derive(Debug, Clone)]
pub(crate) struct Contact {
    pub surface: Surface,
    pub restitution: f64,
    reaction: Reaction,
}

impl Contact {
    /// The direction in which an impact at q changes the velocity; `None` where the mass matrix is singular.
    pub fn reaction(&self, system: &System, q: &[f64]) -> Option<DVector<f64>> {
        let normal = self.surface.normal(q);
        match &self.reaction {
            Reaction::Inertia => {
                let mass = factored_mass(system, &DVector::from_column_slice(q))?;
                Some(mass.solve(&normal))
            }
            Reaction::Coordinate => Some(normal),
            Reaction::Direction(b) => Some(b.clone()),
        }
    }
}

/// The contacts of a scene.
pub(crate) fn contacts(scene: &Scene) -> Vec<Contact> {
    let n = scene.n_dof();
    let contact = |stop: &Constraint| match stop {
        Constraint::Stop(stop) => Contact {
            surface: Surface::Plane {
                normal: stop.outward(n),
                clearance: stop.clearance(),
            },
            restitution: stop.restitution().value(),
            reaction: match stop.reaction() {
                Reaction::Direction(b) if stop.side() == Side::Lower => Reaction::Direction(-b),
                other => other.clone(),
            },
        },
        Constraint::Wall(wall) => Contact {
            surface: Surface::Wall {
                lengths: scene
                    .system()
                    .link_lengths()
                    .map(|l| l.iter().take(wall.bob() + 1).copied().collect())
                    .unwrap_or_default(),
                position: wall.position(),
                sign: match wall.side() {
                    WallSide::Right => 1.0,
                    WallSide::Left => -1.0,
                },
            },
            restitution: wall.restitution().value(),
            reaction: Reaction::Inertia,
        },
    };
    scene.stops().iter().map(contact).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_a_wall_gap_are_those_of_its_value() {
        let wall = Surface::Wall {
            lengths: vec![1.0, 0.4],
            position: 0.7,
            sign: -1.0,
        };
        let at = |t: f64| {
            let q = [
                0.3 + 0.5 * t + 0.2 * t * t,
                -0.4 + 1.1 * t - 0.3 * t * t,
                0.9,
            ];
            let v = [0.5 + 0.4 * t, 1.1 - 0.6 * t, 0.0];
            wall.along(&q, &v, &[0.4, -0.6, 0.0])
        };
        let (h, mid) = (1e-5, at(0.2));
        let (before, after) = (at(0.2 - h), at(0.2 + h));
        assert!(((after.gap - before.gap) / (2.0 * h) - mid.speed).abs() < 1e-9);
        assert!(((after.speed - before.speed) / (2.0 * h) - mid.acceleration).abs() < 1e-9);
        let n = wall.normal(&[0.3, -0.4, 0.9]);
        assert_eq!(n[2], 0.0);
        assert!((n[0] + 0.3f64.cos()).abs() < 1e-15 && (n[1] + 0.4 * 0.4f64.cos()).abs() < 1e-15);
    }
}
