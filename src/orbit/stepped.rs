//! Orbits of scenes that are integrated in steps: the flights as the shooting needs them, the motion at any time, what the
//! rules of contact say along it (theory 5, 6).

use crate::contact::polynomial::{Along, Ends, Judgement, Quintic};
use crate::error::{Error, Result};
use crate::flow::integrate::{KeptStep, Variational, integrate, joined, parted};
use crate::flow::runge_kutta::Tolerance;
use crate::impact::Impact;
use crate::linalg::rank;
use crate::model::{
    Contact, Dynamics, Moment, Scene, SceneMotion, System, are_coupled, contacts, with_motion,
};
use crate::orbit::Pattern;
use crate::orbit::admissible::{Admissibility, Breach, Rule, Touch, judge_impacts};
use crate::orbit::periodic_orbit::Flight;
use crate::orbit::shooting::Motion;
use nalgebra::{DMatrix, DVector};

/// Tolerances of the flights of an orbit: an orbit closes to 1e-11.
const TOLERANCE: Tolerance = Tolerance {
    relative: 2e-13,
    absolute: 1e-15,
};
/// Margin within which a gap counts as touching, relative to the motion's size: what the flights are known to.
const MARGIN: f64 = 1e-10;
/// Size of a difference of an impact map, relative to the state.
const DIFFERENCE: f64 = 6e-6;

/// A scene whose flights are integrated, from a forcing phase.
#[derive(Debug, Clone)]
pub(crate) struct SteppedMotion {
    motion: SceneMotion,
    system: System,
    contacts: Vec<Contact>,
    pub frequency: f64,
    pub phase: f64,
}

impl SteppedMotion {
    pub fn new(scene: &Scene, phase: f64) -> Self {
        Self {
            motion: SceneMotion::new(scene),
            system: scene.system().clone(),
            contacts: contacts(scene),
            frequency: scene.forcing().frequency().unwrap_or(0.0),
            phase,
        }
    }

    /// The restitution coefficient of a stop.
    pub fn restitution(&self, stop: usize) -> f64 {
        self.contacts[stop].restitution
    }

    fn moment(&self, t: f64) -> Moment {
        Moment {
            time: t,
            angle: self.frequency * t + self.phase,
        }
    }

    /// The steps of a flight from a state.
    pub fn steps(&self, start: f64, span: f64, state: &DVector<f64>) -> Result<Vec<KeptStep>> {
        let mut steps = Vec::new();
        let mut x: Vec<f64> = state.iter().copied().collect();
        let at = self.moment(start);
        with_motion!(&self.motion, motion => {
            integrate(motion, at, self.frequency, span, TOLERANCE, &mut x, &mut |from, stepper, x, h| {
                steps.push(KeptStep { start: from, h, dense: stepper.dense(x, h) });
            })
        })?;
        Ok(steps)
    }

    fn acceleration(&self, at: Moment, x: &[f64]) -> Result<Vec<f64>> {
        let (q, v) = x.split_at(x.len() / 2);
        let mut a = vec![0.0; q.len()];
        with_motion!(&self.motion, motion => motion.acceleration(at, q, v, &mut a))?;
        Ok(a)
    }

    /// The impact of some stops at a fixed time, and their impulses.
    fn struck(&self, stops: &[usize], state: &mut [f64]) -> Result<Vec<f64>> {
        let (q, v) = state.split_at_mut(state.len() / 2);
        let mut normals = Vec::with_capacity(stops.len());
        let mut reactions = Vec::with_capacity(stops.len());
        for &stop in stops {
            let contact = &self.contacts[stop];
            normals.push(contact.surface.normal(q)?);
            let reaction = contact.reaction(&self.system, q)?;
            reactions.push(reaction.ok_or(Error::NoConvergence {
                stage: "the mass matrix at an impact, which is singular,",
                iterations: 0,
                residual: f64::NAN,
            })?);
        }
        let k = stops.len();
        let delassus = DMatrix::from_fn(k, k, |i, j| normals[i].dot(&reactions[j]));
        let approach = DVector::from_fn(k, |i, _| {
            let speed: f64 = normals[i].iter().zip(v.iter()).map(|(n, v)| n * v).sum();
            (1.0 + self.contacts[stops[i]].restitution) * speed
        });
        let tolerance = 1e-12 * delassus.amax();
        let impulses = rank::solve(&delassus, &approach, tolerance)?.particular;
        for (reaction, impulse) in reactions.iter().zip(impulses.iter()) {
            for (v, b) in v.iter_mut().zip(reaction.iter()) {
                *v -= b * impulse;
            }
        }
        Ok(impulses.iter().copied().collect())
    }

    /// Judges the impacts, and every gap along every flight.
    pub fn admissibility(
        &self,
        flights: &[(f64, Vec<KeptStep>)],
        pattern: &[Vec<usize>],
        impacts: &[Impact],
        rate: f64,
    ) -> Result<Admissibility> {
        let mut found = Admissibility::default();
        let sizes: Vec<f64> = (0..self.contacts.len())
            .map(|stop| self.size(stop, flights))
            .collect::<Result<_>>()?;
        judge_impacts(impacts, |stop| MARGIN * sizes[stop] * rate, &mut found);
        for (k, (start, steps)) in flights.iter().enumerate() {
            let begins: &[usize] = pattern.get(k).map_or(&[], |instant| instant);
            for (stop, &size) in sizes.iter().enumerate() {
                let is_hit = begins.contains(&stop);
                self.search(*start, steps, stop, is_hit, MARGIN * size, &mut found)?;
            }
        }
        Ok(found)
    }

    /// Whether an impact on one of two stops changes the normal velocity at the other, at an instant that hits both.
    pub fn is_coupled(&self, a: usize, b: usize, flights: &[Flight], pattern: &Pattern) -> bool {
        let hits = |(k, _): &(usize, &Flight)| {
            let instant = &pattern.instants()[*k];
            instant.contains(&a) && instant.contains(&b)
        };
        flights.iter().enumerate().filter(hits).any(|(_, flight)| {
            let q: Vec<f64> = flight.after.iter().map(|z| z[0]).collect();
            are_coupled(&self.contacts[a], &self.contacts[b], &self.system, &q)
        })
    }

    /// The size of the motion along one gap.
    fn size(&self, stop: usize, flights: &[(f64, Vec<KeptStep>)]) -> Result<f64> {
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
        start: f64,
        steps: &[KeptStep],
        stop: usize,
        is_hit: bool,
        margin: f64,
        found: &mut Admissibility,
    ) -> Result<()> {
        let surface = &self.contacts[stop].surface;
        let ends = |t: f64, x: &[f64], h: f64| -> Result<[f64; 3]> {
            let a = self.acceleration(self.moment(t), x)?;
            let (q, v) = x.split_at(x.len() / 2);
            let value = surface.along(q, v, &a, h)?;
            Ok([value.gap, value.speed, value.acceleration])
        };
        let judged = Judgement { margin, error: 0.0 };
        for (i, step) in steps.iter().enumerate() {
            let t = start + step.start;
            let order = usize::from(is_hit && i == 0);
            let known = Ends::new(
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
            let along = match order {
                0 => quintic.when_open(judged, &mut touches),
                _ => quintic.after_contact(order),
            };
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
        (start, end): (f64, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<()> {
        let (at, span) = (self.moment(start), end - start);
        let nothing = &mut |_: f64, _: &_, _: &_, _: f64| ();
        let mut x = joined(state.as_slice(), deviations.as_slice());
        with_motion!(&self.motion, motion => {
            let dynamics = Variational { dynamics: motion, count: deviations.ncols() };
            integrate(&dynamics, at, self.frequency, span, TOLERANCE, &mut x, nothing)
        })?;
        parted(&x, state.as_mut_slice(), deviations.as_mut_slice());
        Ok(())
    }

    fn rate(&self, t: f64, state: &DVector<f64>) -> Result<DVector<f64>> {
        let a = self.acceleration(self.moment(t), state.as_slice())?;
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
        let before = state.clone();
        for mut column in deviations.column_iter_mut() {
            let size = column.amax();
            if size == 0.0 {
                continue;
            }
            let step = DIFFERENCE * (1.0 + before.amax()) / size;
            let (mut ahead, mut behind) = (&before + &column * step, &before - &column * step);
            self.struck(stops, ahead.as_mut_slice())?;
            self.struck(stops, behind.as_mut_slice())?;
            column.copy_from(&((ahead - behind) / (2.0 * step)));
        }
        self.struck(stops, state.as_mut_slice())
    }

    fn gap(&self, stop: usize, state: &DVector<f64>) -> Result<(f64, DVector<f64>)> {
        let q = &state.as_slice()[..state.len() / 2];
        let surface = &self.contacts[stop].surface;
        Ok((surface.gap(q)?, -surface.normal(q)?))
    }
}
