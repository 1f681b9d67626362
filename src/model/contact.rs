//! The stops of a scene as contacts of a motion: gap, its time derivatives, normal, reaction, at any position (theory 1, 2).

use crate::error::Result;
use crate::law::{Law, Newton};
use crate::linalg::rank;
use crate::model::constraint::Constraint;
use crate::model::dynamics::solve_mass_at;
use crate::model::gap_motion::GapMotion;
use crate::model::moment::Moment;
use crate::model::nonlinear_stop::NonlinearStop;
use crate::model::reaction::Reaction;
use crate::model::scene::Scene;
use crate::model::stop::{Side, WallSide};
use crate::model::system::System;
use crate::tolerance::{
    DEPENDENT, GAP_CURVATURE_CONVERGING, GAP_DIFFERENCE_STEP, GAP_SPEED_ROUNDINGS,
    LARGE_SPEED_CHANGE, SAFE_PIVOT, SAME_GAP_CURVATURE, SHORTENING_FACTOR, SLOWEST_SPEED_CHANGE,
    UNCOUPLED,
};
use nalgebra::{DMatrix, DVector};

/// Times that a difference along the motion is made shorter. [work]
const MOST_SHORTENINGS: usize = 16;

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
    /// Any gap.
    Nonlinear(NonlinearStop),
}

/// A gap with its first two time derivatives, and the size of the terms it was summed from.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct GapValue {
    pub gap: f64,
    pub speed: f64,
    pub acceleration: f64,
    pub size: f64,
    /// A bound on the sum of the normal's entries, here or over all positions: the gap moves by no more than this times the
    /// largest change of a coordinate.
    pub steepness: f64,
}

impl Surface {
    /// Whether its gap cannot change while those of some others do not: a plane whose normal depends on theirs, a wall before the
    /// same bob. A curved gap never counts as bound.
    pub fn is_bound_by(&self, others: &[&Self]) -> Result<bool> {
        match self {
            Self::Plane { normal, .. } => {
                let normals: Vec<_> = (others.iter())
                    .filter_map(|other| match other {
                        Self::Plane { normal, .. } => Some(normal.clone()),
                        _ => None,
                    })
                    .collect();
                if normals.is_empty() {
                    return Ok(false);
                }
                rank::depends_on(normal, &DMatrix::from_columns(&normals))
            }
            Self::Wall { lengths, .. } => Ok((others.iter())
                .any(|other| matches!(other, Self::Wall { lengths: l, .. } if l == lengths))),
            Self::Nonlinear(_) => Ok(false),
        }
    }

    /// The gap along a motion, `h'' = -n.a + kappa`; `step` is a time over which the motion changes little.
    ///
    /// # Errors
    /// What the functions of a nonlinear stop report.
    #[inline]
    pub fn along(&self, q: &[f64], v: &[f64], a: &[f64], step: f64) -> Result<GapValue> {
        Ok(match self {
            Self::Plane { normal, clearance } => {
                let mut value = GapValue {
                    gap: *clearance,
                    size: clearance.abs(),
                    steepness: normal.lp_norm(1),
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
                    steepness: lengths.iter().sum(),
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
            Self::Nonlinear(stop) => nonlinear_along(stop, q, v, a, step)?,
        })
    }

    /// The size of the terms of the normal speed.
    ///
    /// # Errors
    /// What the functions of a nonlinear stop report.
    pub fn speed_size(&self, q: &[f64], v: &[f64]) -> Result<f64> {
        let size = |(n, v): (&f64, &f64)| (n * v).abs();
        Ok(match self {
            Self::Plane { normal, .. } => normal.iter().zip(v).map(size).sum(),
            Self::Wall { lengths, .. } => {
                let terms = lengths.iter().zip(q).zip(v);
                terms.map(|((l, q), v)| (l * q.cos() * v).abs()).sum()
            }
            Self::Nonlinear(stop) => stop.gradient(q)?.iter().zip(v).map(size).sum(),
        })
    }

    /// A bound on the spectral norm of the gap's second derivative; `None` where none is known.
    pub fn curvature(&self) -> Option<f64> {
        match self {
            Self::Plane { .. } => Some(0.0),
            // Its second derivative is diagonal, with the entries l_i sin q_i.
            Self::Wall { lengths, .. } => Some(lengths.iter().fold(0.0, |most, l| l.max(most))),
            Self::Nonlinear(stop) => stop.curvature(),
        }
    }

    /// Whether its gap is any function of the position.
    #[inline]
    pub fn is_nonlinear(&self) -> bool {
        matches!(self, Self::Nonlinear(_))
    }

    /// The gap at a position.
    ///
    /// # Errors
    /// What the functions of a nonlinear stop report.
    pub fn gap(&self, q: &[f64]) -> Result<f64> {
        match self {
            Self::Nonlinear(stop) => stop.gap(q),
            _ => Ok(self.along(q, q, q, 0.0)?.gap),
        }
    }

    /// The normal `n = -grad h` towards the stop.
    ///
    /// # Errors
    /// What the functions of a nonlinear stop report.
    pub fn normal(&self, q: &[f64]) -> Result<DVector<f64>> {
        let mut normal = DVector::zeros(q.len());
        self.put_normal(q, normal.as_mut_slice())?;
        Ok(normal)
    }

    /// Writes the normal into a buffer.
    pub fn put_normal(&self, q: &[f64], room: &mut [f64]) -> Result<()> {
        match self {
            Self::Plane { normal, .. } => room.copy_from_slice(normal.as_slice()),
            Self::Wall { lengths, sign, .. } => {
                for (i, (n, q)) in room.iter_mut().zip(q).enumerate() {
                    *n = lengths.get(i).map_or(0.0, |l| sign * l * q.cos());
                }
            }
            Self::Nonlinear(stop) => {
                for (n, g) in room.iter_mut().zip(stop.gradient(q)?.iter()) {
                    *n = -g;
                }
            }
        }
        Ok(())
    }
}

/// A nonlinear gap: `h'' = grad h.a + v.(grad h(q + s v) - grad h(q - s v))/2s`.
fn nonlinear_along(
    stop: &NonlinearStop,
    q: &[f64],
    v: &[f64],
    a: &[f64],
    step: f64,
) -> Result<GapValue> {
    let gradient = stop.gradient(q)?;
    let dot = |g: &DVector<f64>, x: &[f64]| g.iter().zip(x).map(|(g, x)| g * x).sum::<f64>();
    let gap = stop.gap(q)?;
    let speed = dot(&gradient, v);
    let bending = if step > 0.0 && v.iter().any(|v| *v != 0.0) {
        bending(stop, (q, v, speed), GAP_DIFFERENCE_STEP * step)?
    } else {
        0.0
    };
    Ok(GapValue {
        gap,
        speed,
        acceleration: dot(&gradient, a) + bending,
        size: gap.abs()
            + gradient
                .iter()
                .zip(q)
                .map(|(g, q)| (g * q).abs())
                .sum::<f64>(),
        steepness: gradient.lp_norm(1),
    })
}

/// `v.(hess h) v`, by the difference of the speed of a gap along the motion over a time s, or a shorter one if it changes by much.
fn bending(stop: &NonlinearStop, (q, v, speed): (&[f64], &[f64], f64), mut s: f64) -> Result<f64> {
    let over = |s: f64| -> Result<[f64; 3]> {
        let speed_at = |s: f64| -> Result<[f64; 2]> {
            let moved: Vec<f64> = q.iter().zip(v).map(|(q, v)| q + s * v).collect();
            let gradient = stop.gradient(&moved)?;
            let terms = gradient.iter().zip(v).map(|(g, v)| g * v);
            Ok(terms.fold([0.0; 2], |[sum, size], x| [sum + x, size + x.abs()]))
        };
        let ([ahead, size], [behind, other]) = (speed_at(s)?, speed_at(-s)?);
        let (odd, even) = (ahead - behind, ahead + behind - 2.0 * speed);
        Ok([odd / (2.0 * s), odd.abs().max(even.abs()), size.max(other)])
    };
    let [mut bending, change, size] = over(s)?;
    if change <= LARGE_SPEED_CHANGE * size {
        return Ok(bending);
    }
    let mut best = (f64::INFINITY, bending);
    for _ in 0..MOST_SHORTENINGS {
        s /= SHORTENING_FACTOR;
        let [shorter, _, size] = over(s)?;
        let off = (shorter - bending).abs();
        let part = off / shorter.abs();
        if part <= SAME_GAP_CURVATURE || off <= GAP_SPEED_ROUNDINGS * size / s {
            return Ok(bending);
        }
        if part > best.0 {
            break;
        }
        if part <= GAP_CURVATURE_CONVERGING {
            best = (part, bending);
        }
        bending = shorter;
    }
    Ok(best.1)
}

/// A time over which a motion changes little, as far as its state tells: what it takes to go as far as it is, or what its acceleration
/// takes to change its speed. In another unit of time it is another number.
pub(crate) fn slow_time(q: &[f64], v: &[f64], a: &[f64]) -> f64 {
    let size = |x: &[f64]| x.iter().fold(0.0f64, |size, x| size.max(x.abs()));
    let speed = size(v);
    let (gone, turned) = (size(q) / speed, speed / size(a));
    let is_time = |t: &f64| *t > 0.0 && t.is_finite();
    if is_time(&gone) {
        gone.max(turned.min(SLOWEST_SPEED_CHANGE * gone))
    } else {
        Some(turned).filter(is_time).unwrap_or(1.0)
    }
}

/// One stop as a contact.
#[derive(Debug, Clone)]
pub(crate) struct Contact {
    pub surface: Surface,
    pub law: Law,
    reaction: Reaction,
    /// The change of the gap by the stop's own motion, if it has one.
    pub motion: Option<GapMotion>,
}

impl GapValue {
    /// Turns a gap into the approach, and back: `p = -h`.
    pub fn reverse(&mut self) {
        self.gap = -self.gap;
        self.speed = -self.speed;
        self.acceleration = -self.acceleration;
    }

    /// Adds what the own motion of its stop adds at a moment.
    #[cold]
    pub fn widen(&mut self, motion: &GapMotion, at: Moment) {
        let ([value, speed, acceleration], size) = motion.along_with_size(at);
        self.gap += value;
        self.speed += speed;
        self.acceleration += acceleration;
        self.size += size;
    }
}

impl Contact {
    /// The law of its impacts.
    pub fn law(&self) -> Newton {
        self.law.newton()
    }

    /// The gap along a motion at a moment, as [`Surface::along`] for a surface that rests.
    ///
    /// # Errors
    /// What the functions of a nonlinear stop report.
    pub fn along(
        &self,
        at: impl FnOnce() -> Moment,
        (q, v, a): (&[f64], &[f64], &[f64]),
        step: f64,
    ) -> Result<GapValue> {
        let mut value = self.surface.along(q, v, a, step)?;
        if let Some(motion) = &self.motion {
            value.widen(motion, at());
        }
        Ok(value)
    }

    /// The gap at a position and a moment.
    ///
    /// # Errors
    /// What the functions of a nonlinear stop report.
    pub fn gap(&self, q: &[f64], at: Moment) -> Result<f64> {
        Ok(self.surface.gap(q)? + self.own_motion(|| at)[0])
    }

    /// What the stop's own motion adds to its gap, with speed and acceleration.
    pub fn own_motion(&self, at: impl FnOnce() -> Moment) -> [f64; 3] {
        let motion = self.motion.as_ref();
        motion.map_or([0.0; 3], |motion| motion.along(at()))
    }

    /// The direction in which an impact at q changes the velocity; `None` where the mass matrix is singular.
    ///
    /// # Errors
    /// What the functions of a nonlinear stop or system report.
    pub fn reaction(&self, system: &System, q: &[f64]) -> Result<Option<DVector<f64>>> {
        let mut direction = self.surface.normal(q)?;
        let is_regular = self.turn_to_reaction(system, q, direction.as_mut_slice())?;
        Ok(is_regular.then_some(direction))
    }

    /// Replaces the normal at q by the reaction direction; false where the mass matrix is singular.
    pub fn turn_to_reaction(&self, system: &System, q: &[f64], normal: &mut [f64]) -> Result<bool> {
        match &self.reaction {
            Reaction::Inertia => return solve_mass_at(system, q, normal),
            Reaction::Coordinate => {}
            Reaction::Direction(b) => normal.copy_from_slice(b.as_slice()),
        }
        Ok(true)
    }
}

/// Whether an impact on one of two contacts changes the normal velocity at the other, at the position q. Where a function
/// of theirs fails they count as coupled.
pub(crate) fn are_coupled(a: &Contact, b: &Contact, system: &System, q: &[f64]) -> bool {
    let sees = |a: &Contact, b: &Contact| match (a.surface.normal(q), b.reaction(system, q)) {
        (Ok(n), Ok(Some(b))) => n.dot(&b).abs() > UNCOUPLED * n.norm() * b.norm(),
        _ => true,
    };
    sees(a, b) || sees(b, a)
}

/// The weights w of reactions whose sum has given parts along the normals, `(N^T B) w = parts`; where there are many, those of least norm.
pub(crate) fn reaction_weights(
    normals: &[DVector<f64>],
    reactions: &[DVector<f64>],
    parts: &DVector<f64>,
) -> Result<DVector<f64>> {
    let delassus = DMatrix::from_fn(normals.len(), reactions.len(), |i, j| {
        normals[i].dot(&reactions[j])
    });
    impulses_of(&delassus, parts)
}

/// The impulses that change the normal speeds of contacts by given parts, from their Delassus matrix; where there are many, those
/// of least norm.
pub(crate) fn impulses_of(delassus: &DMatrix<f64>, parts: &DVector<f64>) -> Result<DVector<f64>> {
    if parts.is_empty() {
        return Ok(parts.clone());
    }
    let lone = parts[0] / delassus[0];
    if parts.len() == 1 && lone.is_finite() {
        return Ok(DVector::from_element(1, lone));
    }
    let largest = delassus.amax();
    let eliminated = delassus.clone().full_piv_lu();
    if eliminated
        .u()
        .diagonal()
        .iter()
        .all(|pivot| pivot.abs() > SAFE_PIVOT * largest)
        && let Some(weights) = eliminated.solve(parts)
        && weights.iter().all(|w| w.is_finite())
    {
        return Ok(weights);
    }
    Ok(rank::solve(delassus, parts, DEPENDENT * largest)?.particular)
}

/// Normals and reactions of some contacts at a position; without a reaction where the mass matrix is singular.
///
/// # Errors
/// What the functions of a nonlinear stop or system report.
pub(crate) fn directions<'c>(
    contacts: impl Iterator<Item = &'c Contact>,
    system: &System,
    q: &DVector<f64>,
) -> Result<[Vec<DVector<f64>>; 2]> {
    let mut both = [Vec::new(), Vec::new()];
    for contact in contacts {
        let reaction = contact.reaction(system, q.as_slice())?;
        both[1].push(reaction.unwrap_or_else(|| DVector::zeros(q.len())));
        both[0].push(contact.surface.normal(q.as_slice())?);
    }
    Ok(both)
}

/// The combination of reactions whose parts along the normals are given; of many that of the least weights.
pub(crate) fn along_reactions(
    normals: &[DVector<f64>],
    reactions: &[DVector<f64>],
    parts: &DVector<f64>,
) -> Result<DVector<f64>> {
    let weights = reaction_weights(normals, reactions, parts)?;
    let weighted = reactions.iter().zip(weights.iter()).map(|(b, w)| b * *w);
    let none = reactions.first().map_or(0, DVector::len);
    Ok(weighted.fold(DVector::zeros(none), |sum, b| sum + b))
}

/// The contacts of a scene.
pub(crate) fn contacts(scene: &Scene) -> Vec<Contact> {
    let n = scene.n_dof();
    let mut motions = scene.excitation().stops.into_iter();
    let contact = |stop: &Constraint| match stop {
        Constraint::Stop(stop) => {
            let normal = stop.outward(n);
            Contact {
                reaction: match (stop.reaction(), scene.system()) {
                    (Reaction::Direction(b), _) if stop.side() == Side::Lower => {
                        Reaction::Direction(-b)
                    }
                    // Where neither the normal nor the mass changes, it is known beforehand.
                    (Reaction::Inertia, System::Linear(system)) => {
                        Reaction::Direction(system.solve_mass(&normal))
                    }
                    (other, _) => other.clone(),
                },
                surface: Surface::Plane {
                    normal,
                    clearance: stop.clearance(),
                },
                law: stop.contact().clone(),
                motion: None,
            }
        }
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
            law: wall.contact().clone(),
            reaction: Reaction::Inertia,
            motion: None,
        },
        Constraint::Nonlinear(stop) => Contact {
            surface: Surface::Nonlinear(stop.clone()),
            law: stop.contact().clone(),
            reaction: stop.reaction().clone(),
            motion: None,
        },
    };
    let with_motion = |stop: &Constraint| Contact {
        motion: motions.next().flatten(),
        ..contact(stop)
    };
    scene.stops().iter().map(with_motion).collect()
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
            wall.along(&q, &v, &[0.4, -0.6, 0.0], 0.0).expect("a wall")
        };
        let (h, mid) = (1e-5, at(0.2));
        let (before, after) = (at(0.2 - h), at(0.2 + h));
        assert!(((after.gap - before.gap) / (2.0 * h) - mid.speed).abs() < 1e-9);
        assert!(((after.speed - before.speed) / (2.0 * h) - mid.acceleration).abs() < 1e-9);
        let n = wall.normal(&[0.3, -0.4, 0.9]).expect("a wall");
        assert_eq!(n[2], 0.0);
        assert!((n[0] + 0.3f64.cos()).abs() < 1e-15 && (n[1] + 0.4 * 0.4f64.cos()).abs() < 1e-15);
    }

    /// `1 - |q|` in the plane.
    struct Circle;

    impl crate::model::GapFunction for Circle {
        fn gap(&self, q: &[f64]) -> Result<f64> {
            Ok(1.0 - q[0].hypot(q[1]))
        }
        fn gradient(&self, q: &[f64], gradient: &mut [f64]) -> Result<()> {
            let r = q[0].hypot(q[1]);
            (gradient[0], gradient[1]) = (-q[0] / r, -q[1] / r);
            Ok(())
        }
    }

    #[test]
    fn derivatives_of_a_nonlinear_gap_are_those_of_its_value() {
        let circle = Surface::Nonlinear(NonlinearStop::new(Circle, 1.0).expect("valid"));
        // On a circle about the centre the gap is constant, whatever the radius and the rate.
        for (r, w) in [(0.5, 2.0), (1e-3, 1e3), (1e3, 1e-2)] {
            let (q, v, a) = ([r, 0.0], [0.0, r * w], [-r * w * w, 0.0]);
            let value = circle.along(&q, &v, &a, 0.1 / w).expect("off the centre");
            assert_eq!((value.gap, value.speed), (1.0 - r, 0.0));
            assert!(value.acceleration.abs() < 1e-9 * r * w * w, "{value:?}");
        }
        // Through the centre at a distance p: h'' = -v^2/r at the nearest point.
        let value = circle
            .along(&[0.3, 0.0], &[0.0, 2.0], &[0.0, 0.0], 0.1)
            .expect("off the centre");
        assert!((value.acceleration + 4.0 / 0.3).abs() < 1e-9);
        assert!((circle.normal(&[0.3, 0.4]).expect("off the centre")[1] - 0.8).abs() < 1e-15);
    }

    /// The height of the end of a rod, `q_0 + sin(q_1)/2`.
    struct End;

    impl crate::model::GapFunction for End {
        fn gap(&self, q: &[f64]) -> Result<f64> {
            Ok(q[0] + 0.5 * q[1].sin())
        }
        fn gradient(&self, q: &[f64], gradient: &mut [f64]) -> Result<()> {
            (gradient[0], gradient[1]) = (1.0, 0.5 * q[1].cos());
            Ok(())
        }
    }

    #[test]
    fn a_gap_bends_alike_over_any_step_and_in_any_unit_of_time() {
        let end = Surface::Nonlinear(NonlinearStop::new(End, 1.0).expect("valid"));
        for turn in [0.3, 1.5, 0.5 * std::f64::consts::PI, 1e-9, 20.0] {
            for spin in [1e-9, 1.0, 1e9] {
                let (q, a) = ([0.2, turn], [-10.0 * spin * spin, 0.0]);
                let exact = -0.5 * turn.sin() * spin * spin;
                let close = |v: [f64; 2], step: f64| {
                    let value = end.along(&q, &v, &a, step).expect("finite");
                    let off = value.acceleration - a[0] - exact;
                    assert!(
                        off.abs() < 1e-8 * spin * spin,
                        "{turn} {spin} {step} {off:e}"
                    );
                };
                let held = [-0.5 * turn.cos() * spin, spin];
                close(held, slow_time(&q, &held, &a));
                for step in [0.1, 10.0, 1e4, 1e7] {
                    close(held, step / spin);
                    close([0.7 * spin, spin], step / spin);
                }
            }
        }
    }
}
