//! Orbits of scenes that are integrated in steps: the flights as the shooting needs them, the motion at any time, what the
//! rules of contact say along it (theory 5, 6).

use crate::contact::polynomial::{Along, EndValues, Judgement, Quintic};
use crate::error::{Error, Result};
use crate::flow::integrate::{KeptStep, Variational, integrate, joined, parted};
use crate::flow::steps::{Dense, DenseOutput, DormandPrince, Tolerance};
use crate::impact::Impact;
use crate::model::{
    Contact, DIFFERENCE, Dynamics, Moment, Scene, SceneMotion, System, are_coupled, contacts,
    reaction_weights,
};
use crate::orbit::course::{Course, struck};
use crate::orbit::flights::Flight;
use crate::orbit::motions::chatter::project;
use crate::orbit::motions::pieces::Motion;
use crate::orbit::pattern::Pattern;
use crate::orbit::verdict::admissibility::{Admissibility, Breach, Rule, Touch};
use crate::orbit::verdict::judge::judge_impacts;
use crate::orbit::verdict::lasting::{is_low_bounce, judge_force};
use crate::simulate::{HeldMotion, SegmentKind};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Tolerances of the flights of an orbit: an orbit closes to 1e-11.
const TOLERANCE: Tolerance = Tolerance {
    relative: 2e-13,
    absolute: 1e-15,
};
/// Margin within which a gap counts as touching, relative to the motion's size: what the flights are known to.
const MARGIN: f64 = 1e-10;

/// The method of the flights of an orbit.
type Method = DormandPrince<Vec<f64>>;
/// A step of it.
pub(crate) type OrbitStep = KeptStep<Dense<Vec<f64>, 4>>;

/// Runs a block of code with the motion of a scene while stops are held, if there are any.
macro_rules! with_held {
    ($stepped:expr, $held:expr, $dynamics:ident => $body:expr) => {
        if $held.is_empty() {
            let $dynamics = &$stepped.motion;
            $body
        } else {
            let $dynamics = &$stepped.held_motion($held);
            $body
        }
    };
}

/// A scene whose flights are integrated, from a forcing phase.
#[derive(Debug, Clone)]
pub(crate) struct SteppedMotion {
    motion: SceneMotion,
    system: System,
    contacts: Arc<Vec<Contact>>,
    pub frequency: f64,
    pub phase: f64,
}

impl SteppedMotion {
    pub fn new(scene: &Scene, phase: f64) -> Self {
        Self {
            motion: SceneMotion::new(scene),
            system: scene.system().clone(),
            contacts: Arc::new(contacts(scene)),
            frequency: scene.forcing().frequency().unwrap_or(0.0),
            phase,
        }
    }

    fn moment(&self, t: f64) -> Moment {
        Moment {
            time: t,
            angle: self.frequency * t + self.phase,
            frequency: self.frequency,
        }
    }

    /// The motion while some stops are held.
    fn held_motion(&self, stops: &[usize]) -> HeldMotion<'_, SceneMotion> {
        HeldMotion {
            dynamics: &self.motion,
            system: &self.system,
            contacts: Arc::clone(&self.contacts),
            stops: stops.to_vec(),
        }
    }

    /// The steps of a flight between two states; the rest of impacts that accumulate is a line.
    pub fn steps(
        &self,
        course: &Course,
        (start, span): (f64, f64),
        state: &DVector<f64>,
        end: &DVector<f64>,
    ) -> Result<Vec<OrbitStep>> {
        let mut x: Vec<f64> = state.iter().copied().collect();
        if course.kind == SegmentKind::Chatter {
            let dense = Dense::line(&x, &end.iter().copied().collect(), span);
            return Ok(vec![KeptStep {
                start: 0.0,
                h: span,
                dense,
            }]);
        }
        let mut steps = Vec::new();
        let at = self.moment(start);
        with_held!(self, course.held(), motion => {
            integrate::<Method, _>(motion, at, span, TOLERANCE, &mut x, Some(&mut steps))
        })?;
        Ok(steps)
    }

    fn rate_of(&self, held: &[usize], at: Moment, x: &[f64]) -> Result<Vec<f64>> {
        let (q, v) = x.split_at(x.len() / 2);
        let mut a = vec![0.0; q.len()];
        with_held!(self, held, motion => motion.acceleration(at, q, v, &mut a))?;
        Ok(a)
    }

    /// The contact forces of the stops held.
    fn forces(&self, held: &[usize], at: Moment, x: &[f64]) -> Result<Vec<f64>> {
        let (q, v) = x.split_at(x.len() / 2);
        let mut a = vec![0.0; q.len()];
        self.held_motion(held).forces(at, q, v, &mut a)
    }

    /// The reaction of a stop at a position.
    fn reaction_at(&self, stop: usize, q: &[f64]) -> Result<DVector<f64>> {
        let reaction = self.contacts[stop].reaction(&self.system, q)?;
        reaction.ok_or(Error::NoConvergence {
            stage: "the mass matrix at an impact, which is singular,",
            iterations: 0,
            residual: f64::NAN,
        })
    }

    /// The impact of some stops at a fixed time, and their impulses.
    fn struck(&self, stops: &[usize], state: &mut [f64]) -> Result<Vec<f64>> {
        let (q, v) = state.split_at_mut(state.len() / 2);
        let mut normals = Vec::with_capacity(stops.len());
        let mut reactions = Vec::with_capacity(stops.len());
        for &stop in stops {
            let contact = &self.contacts[stop];
            normals.push(contact.surface.normal(q)?);
            reactions.push(self.reaction_at(stop, q)?);
        }
        let approach = DVector::from_fn(stops.len(), |i, _| {
            let speed: f64 = normals[i].iter().zip(v.iter()).map(|(n, v)| n * v).sum();
            (1.0 + self.contacts[stops[i]].restitution) * speed
        });
        let impulses = reaction_weights(&normals, &reactions, &approach)?;
        for (reaction, impulse) in reactions.iter().zip(impulses.iter()) {
            for (v, b) in v.iter_mut().zip(reaction.iter()) {
                *v -= b * impulse;
            }
        }
        Ok(impulses.iter().copied().collect())
    }

    /// Judges the impacts, every gap along every flight, and the contact forces of what is held.
    pub fn admissibility(
        &self,
        flights: &[(f64, Vec<OrbitStep>)],
        courses: &[Course],
        pattern: &[Vec<usize>],
        impacts: &[Impact],
        rate: f64,
    ) -> Result<Admissibility> {
        let mut found = Admissibility::default();
        let sizes: Vec<f64> = (0..self.contacts.len())
            .map(|stop| self.size(stop, flights))
            .collect::<Result<_>>()?;
        judge_impacts(impacts, |stop| MARGIN * sizes[stop] * rate, &mut found);
        let mut instants = pattern.iter();
        for ((start, steps), course) in flights.iter().zip(courses) {
            let next = if course.is_struck {
                instants.next()
            } else {
                None
            };
            let begins: &[usize] = next.map_or(&[], |instant| instant);
            if course.kind == SegmentKind::Chatter {
                continue;
            }
            self.search_forces(course.held(), *start, steps, &mut found)?;
            for (stop, &size) in sizes.iter().enumerate() {
                let order = match course.released {
                    Some(released) if released == stop => 3,
                    _ => usize::from(begins.contains(&stop)),
                };
                let (held, margin) = (course.held(), MARGIN * size);
                if !held.contains(&stop) && !self.is_low_bounce(steps, stop, margin)? {
                    self.search((*start, steps), (stop, order), held, margin, &mut found)?;
                }
            }
        }
        Ok(found)
    }

    /// Whether a flight stays within the margin of a stop between two contacts with it.
    fn is_low_bounce(&self, steps: &[OrbitStep], stop: usize, margin: f64) -> Result<bool> {
        let (Some(first), Some(last)) = (steps.first(), steps.last()) else {
            return Ok(false);
        };
        let gap = |x: &[f64]| -> Result<[f64; 2]> {
            let (q, v) = x.split_at(x.len() / 2);
            let value = self.contacts[stop].surface.along(q, v, v, 0.0)?;
            Ok([value.gap, value.speed])
        };
        let (start, end) = (gap(&first.dense.at(0.0))?, gap(&last.dense.at(last.h))?);
        let span: f64 = steps.iter().map(|step| step.h).sum();
        Ok(is_low_bounce(start, end, span, margin))
    }

    /// Searches the contact forces of the stops held for the worst pull, on the quartic through five values of each step.
    fn search_forces(
        &self,
        held: &[usize],
        start: f64,
        steps: &[OrbitStep],
        found: &mut Admissibility,
    ) -> Result<()> {
        if held.is_empty() {
            return Ok(());
        }
        let mut along = Vec::with_capacity(steps.len());
        for step in steps {
            let mut nodes = Vec::with_capacity(5);
            for part in [0.0, 0.25, 0.5, 0.75, 1.0] {
                let at = self.moment(start).after(step.start + part * step.h);
                nodes.push(self.forces(held, at, &step.dense.at(part * step.h))?);
            }
            along.push((start + step.start, step.h, nodes));
        }
        for (k, &stop) in held.iter().enumerate() {
            let of_stop: Vec<_> = along
                .iter()
                .map(|(t, h, nodes)| (*t, *h, std::array::from_fn(|i| nodes[i][k])))
                .collect();
            judge_force(stop, &of_stop, MARGIN, found);
        }
        Ok(())
    }

    /// Whether an impact on one of two stops changes the normal velocity at the other, at an instant that hits both.
    pub fn is_coupled(&self, a: usize, b: usize, flights: &[Flight], pattern: &Pattern) -> bool {
        let starts = struck(flights.iter().map(|flight| &flight.course));
        let hits = pattern.instants().iter().zip(starts);
        let mut both = hits.filter(|(instant, _)| instant.contains(&a) && instant.contains(&b));
        both.any(|(_, k)| {
            let flight = &flights[k];
            let q: Vec<f64> = flight.after.iter().map(|z| z[0]).collect();
            are_coupled(&self.contacts[a], &self.contacts[b], &self.system, &q)
        })
    }

    /// The size of the motion along one gap.
    fn size(&self, stop: usize, flights: &[(f64, Vec<OrbitStep>)]) -> Result<f64> {
        let mut size = 0.0f64;
        for step in flights.iter().flat_map(|(_, steps)| steps) {
            let x = step.dense.at(0.0);
            let (q, v) = x.split_at(x.len() / 2);
            let value = self.contacts[stop].surface.along(q, v, v, 0.0)?;
            size = size.max(value.size);
        }
        Ok(size)
    }

    fn search(
        &self,
        (start, steps): (f64, &[OrbitStep]),
        (stop, first_order): (usize, usize),
        held: &[usize],
        margin: f64,
        found: &mut Admissibility,
    ) -> Result<()> {
        let surface = &self.contacts[stop].surface;
        let ends = |t: f64, x: &[f64], h: f64| -> Result<[f64; 3]> {
            let a = self.rate_of(held, self.moment(t), x)?;
            let (q, v) = x.split_at(x.len() / 2);
            let value = surface.along(q, v, &a, h)?;
            Ok([value.gap, value.speed, value.acceleration])
        };
        // What the flights are known to is the rounding of an orbit.
        let judged = Judgement {
            rounding: margin,
            error: 0.0,
        };
        for (i, step) in steps.iter().enumerate() {
            let t = start + step.start;
            let order = if i == 0 { first_order } else { 0 };
            let known = EndValues::new(
                ends(t, &step.dense.at(0.0), step.h)?,
                ends(t + step.h, &step.dense.at(step.h), step.h)?,
                step.h,
                order,
            );
            if known.are_clear(order, margin) {
                continue;
            }
            let quintic = Quintic::new(&known);
            let mut touches = Vec::new();
            let along = quintic.first_contact(order, judged, &mut touches);
            let (x, depth) = quintic.lowest();
            if along != Along::Clear && depth > margin {
                found.keep_worst(Breach {
                    stop,
                    time: t + x * step.h,
                    depth,
                    rule: Rule::Passed,
                });
            }
            found.touches.extend(touches.iter().map(|&(x, gap)| Touch {
                stop,
                time: t + x * step.h,
                gap,
            }));
        }
        Ok(())
    }
}

impl Motion for SteppedMotion {
    fn fly(
        &self,
        held: &[usize],
        (start, end): (f64, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<()> {
        let (at, span) = (self.moment(start), end - start);
        if !held.is_empty() {
            differentiated(state, deviations, |x| project(self, held, x))?;
        }
        let mut x = joined(state.as_slice(), deviations.as_slice());
        with_held!(self, held, motion => {
            let dynamics = Variational { dynamics: motion, count: deviations.ncols() };
            integrate::<Method, _>(&dynamics, at, span, TOLERANCE, &mut x, None)
        })?;
        parted(&x, state.as_mut_slice(), deviations.as_mut_slice());
        Ok(())
    }

    fn rate(&self, held: &[usize], t: f64, state: &DVector<f64>) -> Result<DVector<f64>> {
        let a = self.rate_of(held, self.moment(t), state.as_slice())?;
        let v = state.rows(a.len(), a.len());
        Ok(DVector::from_iterator(
            state.len(),
            v.iter().copied().chain(a),
        ))
    }

    fn collide(
        &self,
        stops: &[usize],
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<Vec<f64>> {
        if stops.is_empty() {
            return Ok(Vec::new());
        }
        differentiated(state, deviations, |x| self.struck(stops, x.as_mut_slice()))
    }

    fn gap(&self, stop: usize, state: &DVector<f64>) -> Result<(f64, DVector<f64>)> {
        let q = &state.as_slice()[..state.len() / 2];
        let surface = &self.contacts[stop].surface;
        Ok((surface.gap(q)?, -surface.normal(q)?))
    }

    fn acceleration(&self, stop: usize, state: &DVector<f64>, rate: &DVector<f64>) -> Result<f64> {
        let n = state.len() / 2;
        let ((q, v), a) = (state.as_slice().split_at(n), &rate.as_slice()[n..]);
        let surface = &self.contacts[stop].surface;
        Ok(surface.along(q, v, a, 1.0)?.acceleration)
    }

    fn reaction(&self, stop: usize, state: &DVector<f64>) -> Result<DVector<f64>> {
        self.reaction_at(stop, &state.as_slice()[..state.len() / 2])
    }

    fn restitution(&self, stop: usize) -> f64 {
        self.contacts[stop].restitution
    }
}

/// Applies a map to a state, and its Jacobian, by central differences, to deviations.
fn differentiated<T>(
    state: &mut DVector<f64>,
    deviations: &mut DMatrix<f64>,
    map: impl Fn(&mut DVector<f64>) -> Result<T>,
) -> Result<T> {
    let reach = state.amax();
    for mut column in deviations.column_iter_mut() {
        let size = column.amax();
        if size == 0.0 {
            continue;
        }
        let step = DIFFERENCE * if reach > 0.0 { reach } else { 1.0 } / size;
        let (mut ahead, mut behind) = (&*state + &column * step, &*state - &column * step);
        map(&mut ahead)?;
        map(&mut behind)?;
        column.copy_from(&((ahead - behind) / (2.0 * step)));
    }
    map(state)
}
