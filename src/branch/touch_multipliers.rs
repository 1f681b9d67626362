//! The multipliers of the orbits on both sides of a touch of a stop that gives way, as they come near to it (theory 22, "Touches").

use crate::branch::multipliers::{is_free, without_one};
use crate::branch::parametric_loop::ParametricLoop;
use crate::branch::problem::BranchProblem;
use crate::branch::special::SpecialKind;
use crate::error::Result;
use crate::hybrid::HybridMaps;
use crate::itinerary::{MotionArc, closing, monodromy};
use crate::law::{ElementState, Stage};
use crate::linalg::eigen;
use crate::orbit::PeriodicOrbit;
use nalgebra::{Complex, DMatrix, DVector};

/// The multipliers of a touching loop of a whole period, without contact and as those of contacts of no duration; `touches` are stops that give way and
/// the times at which they are touched, from the first instant. None where several stops are hit at one instant.
pub(super) fn at_touches(
    problem: &BranchProblem<'_>,
    (place, orbit): (&ParametricLoop, &PeriodicOrbit),
    touches: &[(usize, f64)],
) -> Result<Option<[Vec<Complex<f64>>; 2]>> {
    if problem.signature.stages.hit_together().is_some() {
        return Ok(None);
    }
    let state = &place.state;
    let found = problem.shooting_at(place, |shooting, _, units| {
        let ends = shooting.flight_ends(state, units)?;
        let arcs = state.arcs(&problem.signature.stages, &ends, shooting.motion)?;
        let first = state.times[0];
        let nodes = touches.iter().map(|&(stop, time)| (stop, first + time));
        transported(shooting.motion, arcs, nodes.collect())
    })?;
    let Some(sides) = found else {
        return Ok(None);
    };
    let multipliers = |matrix: &DMatrix<f64>| -> Result<Vec<Complex<f64>>> {
        let mut own = eigen::eigenvalues(matrix)?;
        if is_free(orbit) {
            without_one(&mut own);
        }
        Ok(own)
    };
    let [apart, met] = sides;
    Ok(Some([multipliers(&apart)?, multipliers(&met)?]))
}

/// The maps of deviations over a period from the first of some touches on: without contact, and with contacts of no duration.
fn transported(
    motion: &dyn HybridMaps,
    mut arcs: Vec<MotionArc<DVector<f64>>>,
    mut touches: Vec<(usize, f64)>,
) -> Result<Option<[DMatrix<f64>; 2]>> {
    touches.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (begin, finish) = (arcs[0].start, arcs[arcs.len() - 1].end);
    let mut nodes = Vec::new();
    for &(stop, time) in &touches {
        let time = begin + (time - begin).rem_euclid(finish - begin);
        let Some(k) = arcs
            .iter()
            .position(|own| own.start <= time && time < own.end)
        else {
            return Ok(None);
        };
        let own = arcs[k].clone();
        let mut there = own.after.clone();
        let none = &mut DMatrix::zeros(there.len(), 0);
        motion.flow(own.regime(), (own.start, time), &mut there, none)?;
        let stages = [own.stage.clone(), Stage::uneventful(own.regime().clone())];
        let [one, other] = stages;
        arcs[k] = MotionArc::between(one, (own.start, time), [own.after, there.clone()]);
        let states = [there, own.before_next];
        arcs.insert(k + 1, MotionArc::between(other, (time, own.end), states));
        nodes.push((k + 1, stop));
    }
    let size = arcs[0].after.len();
    let mut sides = [DMatrix::identity(size, size), DMatrix::identity(size, size)];
    let count = arcs.len();
    for (i, &(k, stop)) in nodes.iter().enumerate() {
        let until = nodes.get(i + 1).map_or(nodes[0].0 + count, |own| own.0);
        let piece: Vec<_> = (k..until).map(|j| arcs[j % count].clone()).collect();
        let mut order = closing(&piece);
        // The first of the piece begins without an impact.
        let one = usize::from(!order.is_empty());
        order.rotate_right(one);
        let over = monodromy(motion, &order, &piece)?;
        let entered = entry(motion, stop, &piece[0])?;
        sides = [&over * &sides[0], &over * entered * &sides[1]];
    }
    Ok(Some(sides))
}

/// What a contact of no duration does to deviations at the start of an arc: the force of its stop jumps with the speed of approach, of which
/// nothing is left where it ends with its force. Where it ends with its gap the jump at the end takes back that at the beginning.
fn entry(
    motion: &dyn HybridMaps,
    stop: usize,
    arc: &MotionArc<DVector<f64>>,
) -> Result<DMatrix<f64>> {
    let size = arc.after.len();
    let n = size / 2;
    let mut entered = DMatrix::identity(size, size);
    if SpecialKind::of_touch(motion.contact_law(stop)) != SpecialKind::BorderCollision {
        return Ok(entered);
    }
    let gradient = motion.gap(stop, arc.start, &arc.after)?.gradient;
    // The force of the stop is linear in the speed of approach.
    let (free, pressed) = (arc.regime(), arc.regime().with(stop, ElementState::Pressed));
    let mut state = arc.after.clone();
    let scale = 1.0 / gradient.norm_squared();
    state.rows_mut(n, n).axpy(-scale, &gradient, 1.0);
    let jump = |state: &DVector<f64>| -> Result<DVector<f64>> {
        Ok(motion.rate(&pressed, arc.start, state)? - motion.rate(free, arc.start, state)?)
    };
    // -b c, by a speed of approach that is larger by one.
    let change = jump(&state)? - jump(&arc.after)?;
    // The approach grows against the gradient of the gap.
    let column = change * gradient.transpose() * -1.0;
    let mut own = entered.view_mut((0, 0), (size, n));
    own += column;
    Ok(entered)
}

/// The touches of an orbit that come with one of them, of stops that give way: those, and their times from the first instant.
pub(super) fn touches_with(orbit: &PeriodicOrbit, known: (usize, f64)) -> Vec<(usize, f64)> {
    let stops = orbit.scene().stops();
    let all = orbit.touches().iter().map(|own| (own.stop, own.time));
    let mut all: Vec<_> = all
        .filter(|own| !stops[own.0].contact().is_rigid())
        .collect();
    if all.iter().all(|own| own.0 != known.0) {
        all.push(known);
    }
    all
}
