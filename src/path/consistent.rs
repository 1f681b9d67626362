//! Whether a motion that was kept is one of its scene: it is continuous, its velocity jumps along the reactions of closed stops alone,
//! no gap is below zero, and its impacts are where it has them. What comes from a file may have been changed.

use crate::error::{Error, Result};
use crate::impact::Impact;
use crate::model::{Moment, PhysicalState, Scene, along_reactions, directions};
use crate::path::equations::PathEquations;
use crate::path::evaluator::Evaluator;
use crate::path::fading::Rates;
use crate::path::outputs::Located;
use crate::path::parts::PathPoint;
use crate::path::path::Path;
use crate::path::quadrature::each_node;
use crate::path::segments::ImpactSide;
use crate::tolerance::{ARC_SIZE_SAMPLES, KEPT_AGREES};
use nalgebra::DVector;

/// The name of a kind of motion that may pass stops: an orbit that is not admissible does.
pub(crate) const ORBIT: &str = "orbit";

/// Whether a change is larger than what sizes of terms allow, or no number.
fn is_beyond(change: &DVector<f64>, sizes: &DVector<f64>) -> bool {
    let mut terms = change.iter().zip(sizes);
    let agrees = |(x, size): (&f64, &f64)| x.abs() <= KEPT_AGREES * size;
    !terms.all(agrees)
}

/// Refuses a part of a motion.
fn refused(what: &str, t: f64, found: impl std::fmt::Display) -> Error {
    let rule = "it must go on as the scene says";
    let argument = format!("the motion of the saved {what} at t = {t}");
    Error::bad_value(argument, found, rule)
}

/// A motion with the scale of each of its positions and velocities.
struct Kept<'a> {
    what: &'a str,
    path: &'a Path,
    equations: PathEquations<'a>,
    /// The states at the start and at the end of each arc.
    ends: Vec<[PhysicalState; 2]>,
    sizes: PhysicalState,
}

/// Refuses a motion that its scene cannot have, or with impacts that it has not; one that is called an orbit may pass stops, as orbits
/// that are not admissible do.
///
/// # Errors
/// A state that is not finite, a jump, a gap below zero, an impact without its jump; what functions of the scene report.
pub(crate) fn check_motion(
    what: &str,
    path: &Path,
    scene: &Scene,
    impacts: &[Impact],
) -> Result<()> {
    let may_pass = what == ORBIT;
    let arcs = &path.parts.arcs;
    let ends: Vec<[PhysicalState; 2]> = (0..arcs.len())
        .map(|arc| [0.0, arcs[arc].span].map(|local| path.state_in(arc, local)))
        .collect();
    let mut sizes = (DVector::zeros(path.n_dof), DVector::zeros(path.n_dof));
    for (arc, own) in ends.iter().enumerate() {
        // Flights may begin and end at stops where positions are zero, or where velocities are, there and half-way.
        let between = ARC_SIZE_SAMPLES.map(|part| path.state_in(arc, part * arcs[arc].span));
        for (q, v) in own.iter().chain(&between) {
            if !q.iter().chain(v).all(|x| x.is_finite()) {
                return Err(refused(what, arcs[arc].clock.time(), "no number"));
            }
            let most = |size: &mut f64, x: f64| *size = size.max(x.abs());
            sizes.0.zip_apply(q, most);
            sizes.1.zip_apply(v, most);
        }
    }
    let kept = Kept {
        what,
        path,
        equations: PathEquations::new(path, scene),
        ends,
        sizes,
    };
    for arc in 0..arcs.len() {
        if !may_pass {
            kept.check_gaps(arc)?;
        }
        if arc > 0 {
            kept.check_jump(arc)?;
        }
        if !matches!(path.evaluator, Evaluator::Exact { .. }) {
            kept.check_momentum(arc)?;
        }
    }
    for (k, impact) in impacts.iter().enumerate() {
        let at_once = |other: Option<&Impact>| other.is_some_and(|o| o.time == impact.time);
        let before = k.checked_sub(1).and_then(|k| impacts.get(k));
        let is_alone = !at_once(before) && !at_once(impacts.get(k + 1));
        kept.check_impact(impact, is_alone)?;
    }
    Ok(())
}

impl Kept<'_> {
    fn time(&self, arc: usize) -> f64 {
        self.path.arc(arc).clock.time()
    }

    /// No stop is passed at the ends of an arc, but one that has given way.
    fn check_gaps(&self, arc: usize) -> Result<()> {
        let span = self.path.arc(arc).span;
        for (local, (q, _)) in [0.0, span].into_iter().zip(&self.ends[arc]) {
            let gaps = self.gaps(self.equations.moment(arc, local), q)?;
            let regime = self.path.regime_of(arc);
            for (stop, (gap, size)) in gaps.into_iter().enumerate() {
                let is_open = gap >= -KEPT_AGREES * size;
                let may_pass = regime.others().iter().any(|own| own.0 == stop);
                if !(is_open || may_pass) {
                    let found = format!("{gap:e} beyond a stop");
                    return Err(refused(self.what, self.time(arc) + local, found));
                }
            }
        }
        Ok(())
    }

    /// An arc begins where the one before ends, but for a jump of the velocity that closed stops may give.
    fn check_jump(&self, arc: usize) -> Result<()> {
        let ((q, v), (next_q, next_v)) = (&self.ends[arc - 1][1], &self.ends[arc][0]);
        let moved = is_beyond(&(next_q - q), &self.sizes.0);
        if moved {
            return Err(refused(self.what, self.time(arc), "a jump"));
        }
        let mut jump = v - next_v;
        if is_beyond(&jump, &self.sizes.1) {
            jump -= self.along_closed(self.equations.moment(arc, 0.0), next_q, &jump)?;
            if is_beyond(&jump, &self.sizes.1) {
                let found = "a change of velocity that no stop gives";
                return Err(refused(self.what, self.time(arc), found));
            }
        }
        Ok(())
    }

    /// The velocity of an arc that is known by polynomials changes by what the scene's accelerations give.
    fn check_momentum(&self, arc: usize) -> Result<()> {
        let ([(_, start), (_, end)], span) = (&self.ends[arc], self.path.arc(arc).span);
        if self.path.is_rest(arc) || span == 0.0 {
            return Ok(());
        }
        let mut left = end - start;
        each_node(&Rates::default(), (0.0, span), |node| {
            let (time, local) = (self.time(arc) + node.at, node.at);
            let state = self.path.state_in(arc, local);
            let a = self
                .equations
                .acceleration(PathPoint { time, arc, local }, &state)?;
            left -= a * node.weight;
            Ok(())
        })?;
        if is_beyond(&left, &self.sizes.1) {
            let found = "a change of velocity that its accelerations do not give";
            return Err(refused(self.what, self.time(arc), found));
        }
        Ok(())
    }

    /// The stop of an impact is closed then, and the velocity before and after is that of the impact.
    fn check_impact(&self, impact: &Impact, is_alone: bool) -> Result<()> {
        let sides = [ImpactSide::Before, ImpactSide::After];
        let [before, after] = sides.map(|side| self.path.point(impact.time, side));
        let [before, Located { point, state }] = [before?, after?].map(|own| self.path.locate(own));
        let ((q, before), (_, after), arc) = (before.state, state, point.arc);
        let at = self.equations.moment(arc, 0.0);
        let (gap, size) = self.gaps(at, &q)?[impact.stop];
        let is_closed = gap.abs() <= KEPT_AGREES * size;
        if !is_closed {
            let found = format!("{gap:e} away from stop {} of an impact", impact.stop);
            return Err(refused(self.what, impact.time, found));
        }
        // Held stops give a part of it, and at the ends of a motion one side of it is not there.
        let is_inside = self.path.span.0 < impact.time && impact.time < self.path.span.1;
        let is_flight = |arc: usize| self.path.regime_of(arc).is_free();
        if !(is_alone && is_inside && arc > 0 && is_flight(arc - 1) && is_flight(arc)) {
            return Ok(());
        }
        let (speeds, size) = self
            .equations
            .approach(impact.stop, at, &q, [&before, &after])?;
        let told = [impact.approach, -impact.departure];
        let impulse = self
            .equations
            .impulses(&[impact.stop], &q, &(&before - &after));
        let impulse = impulse?.get(0).copied().unwrap_or(f64::NAN);
        let largest = impulse.abs().max(impact.impulse.abs());
        let agrees = (0..2).all(|k| (speeds[k] - told[k]).abs() <= KEPT_AGREES * size)
            && (impulse - impact.impulse).abs() <= KEPT_AGREES.sqrt() * largest;
        if agrees {
            return Ok(());
        }
        let found = format!(
            "of speeds {speeds:?} and the impulse {impulse} at stop {}, which are not those of the impact",
            impact.stop
        );
        Err(refused(self.what, impact.time, found))
    }
}

impl Kept<'_> {
    /// The gap of every stop, with the size of its terms, at the least what positions as large as any of the motion give: where the position
    /// is zero, a gap is known no better.
    fn gaps(&self, at: Moment, q: &DVector<f64>) -> Result<Vec<(f64, f64)>> {
        let x = q.as_slice();
        let each = self.equations.contacts().iter().map(|contact| {
            let value = contact.along(|| at, (x, x, x), 0.0)?;
            let normal = contact.surface.normal(x)?;
            Ok((value.gap, value.size.max(normal.abs().dot(&self.sizes.0))))
        });
        each.collect()
    }

    /// The part of a change of velocity that closed stops can cause.
    fn along_closed(
        &self,
        at: Moment,
        q: &DVector<f64>,
        taken: &DVector<f64>,
    ) -> Result<DVector<f64>> {
        let gaps = self.equations.contacts().iter().zip(self.gaps(at, q)?);
        let is_closed = |gap: f64, size: f64| gap.abs() <= KEPT_AGREES * size;
        let closed =
            gaps.filter(|(contact, (gap, size))| contact.law.is_rigid() && is_closed(*gap, *size));
        let closed = closed.map(|(contact, _)| contact);
        let [normals, reactions] = directions(closed, self.equations.system(), q)?;
        if normals.is_empty() {
            return Ok(DVector::zeros(q.len()));
        }
        let parts = DVector::from_iterator(normals.len(), normals.iter().map(|n| n.dot(taken)));
        along_reactions(&normals, &reactions, &parts)
    }
}

impl PathEquations<'_> {
    /// The speeds at which velocities approach a stop, and the size of their terms.
    fn approach(
        &self,
        stop: usize,
        at: Moment,
        q: &DVector<f64>,
        velocities: [&DVector<f64>; 2],
    ) -> Result<([f64; 2], f64)> {
        let normal = self.contacts()[stop].surface.normal(q.as_slice())?;
        let own = self.stop_speed(stop, at);
        let size = velocities.map(|v| normal.abs().dot(&v.abs()) + own.abs());
        Ok((
            velocities.map(|v| normal.dot(v) - own),
            size[0].max(size[1]),
        ))
    }
}
