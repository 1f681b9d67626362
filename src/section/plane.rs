//! Where a motion passes through a plane of its states upwards. On each arc the quantity is followed by polynomials to its rounding, and these
//! have all their changes of sign found: between two arcs, at an impact too, a change is one of the instant.

use crate::error::Result;
use crate::model::PhysicalState;
use crate::model::chebyshev::CHEBYSHEV_NODES;
use crate::model::function_pieces::{Layout, polynomial_pieces};
use crate::path::{KeptMotion, Path, PathChapter};
use crate::root::polynomial::{roots_of, value as value_of};
use crate::tolerance::{ROOM_ROUNDING, TIME_ROUNDING};
use nalgebra::DVector;

/// The times at which `row.(q, v)` rises through a value, with the states there.
pub(super) fn crossings(
    motion: &dyn KeptMotion,
    row: &DVector<f64>,
    value: f64,
) -> Result<Vec<(f64, PhysicalState)>> {
    let mut found: Vec<(f64, PhysicalState)> = Vec::new();
    let (row, value) = &(row / row.amax(), value / row.amax());
    if !value.is_finite() {
        return Ok(found);
    }
    let mut is_above = None;
    for PathChapter { path, .. } in motion.chapters()? {
        for arc in 0..path.parts.arcs.len() {
            let clock = path.arc(arc).clock;
            for local in rises(path, arc, (row, *value), &mut is_above)? {
                found.push((clock.after(local).time(), path.state_in(arc, local)));
            }
        }
    }
    let (start, end) = motion.span();
    for (t, _) in &mut found {
        *t = t.clamp(start, end);
    }
    // The end of a closed motion is its start, which counts once.
    let rounding = TIME_ROUNDING * (start.abs().max(end.abs()));
    let is_twice = |found: &[(f64, PhysicalState)]| {
        let [first, .., last] = found else {
            return false;
        };
        first.0 - start <= rounding && end - last.0 <= rounding
    };
    if motion.is_closed() && is_twice(&found) {
        found.pop();
    }
    Ok(found)
}

/// The times after the start of an arc at which the quantity rises through its value; whether it was above it before, and is behind.
fn rises(
    path: &Path,
    arc: usize,
    (row, value): (&DVector<f64>, f64),
    is_above: &mut Option<bool>,
) -> Result<Vec<f64>> {
    let n = path.n_dof;
    let at = |local: f64| {
        let (q, v) = path.state_in(arc, local);
        let terms = q.iter().chain(v.iter()).zip(row).map(|(x, r)| x * r);
        let size = terms.clone().map(f64::abs).sum::<f64>() + value.abs();
        (terms.sum::<f64>() - value, size)
    };
    debug_assert_eq!(row.len(), 2 * n);
    let span = path.arc(arc).span;
    let looks = if span > 0.0 { 2 * CHEBYSHEV_NODES } else { 1 };
    let looks: Vec<(f64, f64)> = (0..looks)
        .map(|k| at(span * k as f64 / (2 * CHEBYSHEV_NODES - 1) as f64))
        .collect();
    let size = looks.iter().fold(0.0, |most: f64, look| most.max(look.1));
    let rounding = ROOM_ROUNDING * size;
    if looks.iter().all(|look| look.0.abs() <= rounding) {
        // It stays in the plane.
        return Ok(Vec::new());
    }
    if is_above.is_none() && looks[0].0.abs() <= rounding {
        // A start in the plane is one below it.
        *is_above = Some(false);
    }
    let mut rises = Vec::new();
    let mut pass = |local: f64, above: bool| {
        if above && *is_above == Some(false) {
            rises.push(local);
        }
        *is_above = Some(above);
    };
    if looks.len() == 1 {
        pass(0.0, looks[0].0 > 0.0);
        return Ok(rises);
    }
    // In parts of its largest terms, of which sums have room.
    let mut function = |times: &[f64]| Ok(times.iter().map(|&t| at(t).0 / size).collect());
    let layout = Layout {
        known_to: ROOM_ROUNDING,
        ..Layout::of_span((0.0, span))
    };
    for piece in polynomial_pieces(&mut function, layout)? {
        let roots = roots_of::<CHEBYSHEV_NODES>(&piece.powers);
        let ends = std::iter::once(&0.0).chain(roots.slice());
        let nexts = roots.slice().iter().chain([&1.0]);
        for (x, next) in ends.zip(nexts) {
            // Where a piece ends or begins in the plane, rounding alone would tell on which side: between roots it does not.
            let between = value_of(&piece.powers, 0.5 * (x + next));
            if between.abs() > ROOM_ROUNDING {
                pass(piece.start + x * (piece.end - piece.start), between > 0.0);
            }
        }
    }
    Ok(rises)
}
