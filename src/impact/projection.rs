//! Moving a state onto stops along their reactions, and taking its normal speeds away (theory 9): what is left of an impact that comes
//! to rest is taken as impacts take it, not along the normals.

use crate::error::Result;
use crate::model::along_reactions;
use nalgebra::DVector;

/// Newton steps onto stops; plane ones need one. [work]
const MOST_PROJECTION_STEPS: usize = 60;

/// Some stops at a position.
pub(crate) struct StopsAt {
    /// The gaps, shape `(k,)`, \[m\].
    pub gaps: DVector<f64>,
    /// The speeds at which the stops recede by their own motion, shape `(k,)`, \[m/s\].
    pub speeds: DVector<f64>,
    /// The normals, k of shape `(n_dof,)`, \[-\].
    pub normals: Vec<DVector<f64>>,
    /// The reaction directions b of the stops, k of shape `(n_dof,)`, in which an impulse p changes the velocity by `-b p`, \[1/kg\].
    pub reactions: Vec<DVector<f64>>,
}

impl StopsAt {
    /// Whether every gap is no more than the rounding of its terms.
    fn are_closed(&self, q: &DVector<f64>) -> bool {
        let mut all = self.gaps.iter().zip(&self.normals);
        all.all(|(gap, normal)| {
            let terms = normal.iter().zip(q.iter()).map(|(n, q)| (n * q).abs());
            gap.abs() <= f64::EPSILON * terms.sum::<f64>()
        })
    }
}

/// Moves a position onto some stops, which `at` gives: Newton's steps along the reactions, until the gaps are rounding or
/// shrink no more. Returns the stops there.
///
/// # Errors
/// What `at` reports.
pub(crate) fn put_onto_stops(
    q: &mut DVector<f64>,
    mut at: impl FnMut(&DVector<f64>) -> Result<StopsAt>,
) -> Result<StopsAt> {
    let (mut here, mut least) = (at(q)?, f64::INFINITY);
    for _ in 0..MOST_PROJECTION_STEPS {
        let off = here.gaps.amax();
        let shrinks = off < least;
        if !shrinks || here.are_closed(q) {
            break;
        }
        least = off;
        *q += along_reactions(&here.normals, &here.reactions, &here.gaps)?;
        here = at(q)?;
    }
    Ok(here)
}

/// The same, and takes the normal speeds away, relative to those of the stops.
///
/// # Errors
/// What `at` reports.
pub(crate) fn project(
    q: &mut DVector<f64>,
    v: &mut DVector<f64>,
    at: impl FnMut(&DVector<f64>) -> Result<StopsAt>,
) -> Result<()> {
    let StopsAt {
        normals,
        reactions,
        speeds,
        ..
    } = put_onto_stops(q, at)?;
    let approached = normals.iter().zip(speeds.iter()).map(|(n, c)| n.dot(v) - c);
    let approached = DVector::from_iterator(normals.len(), approached);
    *v -= along_reactions(&normals, &reactions, &approached)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dvector;

    /// The circle of radius one from inside, its reaction across its normal: the way onto it bends.
    #[allow(clippy::unnecessary_wraps, reason = "as stops are asked for")]
    fn circle(q: &DVector<f64>) -> Result<StopsAt> {
        let normal = q / q.norm();
        let reaction = &normal + 0.5 * dvector![-normal[1], normal[0]];
        Ok(StopsAt {
            gaps: dvector![1.0 - q.norm()],
            speeds: dvector![0.0],
            normals: vec![normal],
            reactions: vec![reaction],
        })
    }

    #[test]
    fn a_state_is_brought_onto_a_bent_stop_and_stopped() {
        let (mut q, mut v) = (dvector![0.8, 0.1], dvector![0.3, -0.7]);
        let before = v.clone();
        project(&mut q, &mut v, circle).expect("regular");
        assert!((q.norm() - 1.0).abs() <= 2.0 * f64::EPSILON);
        let there = circle(&q).expect("regular");
        assert!(there.normals[0].dot(&v).abs() < 1e-15);
        // What was taken is along the reaction.
        let taken = before - v;
        let b = &there.reactions[0];
        assert!((taken[0] * b[1] - taken[1] * b[0]).abs() < 1e-15);
    }

    #[test]
    fn planes_take_one_step_and_what_is_there_stays() {
        let mut asked = 0;
        let mut plane = |q: &DVector<f64>| {
            asked += 1;
            Ok(StopsAt {
                gaps: dvector![2.0 - q[0] - q[1], 0.25 - q[1]],
                speeds: dvector![0.0, 0.0],
                normals: vec![dvector![1.0, 1.0], dvector![0.0, 1.0]],
                reactions: vec![dvector![1.0, 0.5], dvector![0.5, 1.0]],
            })
        };
        let mut q = dvector![0.0, 0.0];
        put_onto_stops(&mut q, &mut plane).expect("regular");
        assert_eq!(q, dvector![1.75, 0.25]);
        put_onto_stops(&mut q, &mut plane).expect("regular");
        assert_eq!((q, asked), (dvector![1.75, 0.25], 3));
    }
}
