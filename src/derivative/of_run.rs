//! How the states of a run change with numbers of its scene (theory 21): deviations fly, are late at instants and go through impacts, and what
//! each flight and each impact itself changes by is a difference of that one alone, so that nothing is lost where deviations grow.

use crate::derivative::loop_rates::step;
use crate::derivative::numbers::Numbers;
use crate::derivative::of_orbit::{BORDER, CLOSER, MOST_CLOSER};
use crate::derivative::refusal::SHORT_CONTACT;
use crate::derivative::stencil::{Node, Stencil};
use crate::error::{Error, Result};
use crate::hybrid::chatter_map::{NO_REST, Timed};
use crate::hybrid::{IntegratedMaps, SegmentKind, joined, project_onto};
use crate::model::{Parameter, Scene};
use crate::orbit::{
    ContactStage, Event, OF_INTEGRATED, ScaledUnits, Shooting, Signature, folded, instants_of,
    with_shooting,
};
use crate::simulate::{ImpactSide, Trajectory};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// An impact of so small a part of the motion's speed is a touch that the rounding of the gap made one.
const SLOW: f64 = 1e-7;

/// A stop whose gap is no larger, in parts of the motion, at the impact on another is met with it.
const MET: f64 = 1e-9;

const BEGUN: &str = "the run begins in contact: one-sided only";

/// How the states of a run change with numbers of its scene, times and the first state being the same.
#[derive(Debug, Clone, PartialEq)]
pub struct RunDerivatives {
    /// For each number the derivatives of `(q, v)`, shape `(m, 2n)`; not a number from where there are none.
    pub by: Vec<DMatrix<f64>>,
    /// Why there are none from some time on.
    pub reason: Option<String>,
}

/// A part of a run between instants, and what happens at its end.
struct Leg {
    start: f64,
    end: f64,
    state: DVector<f64>,
    /// The state before its end.
    before: DVector<f64>,
    /// Times at which what acts passes from one polynomial to another, which a flight stops at.
    breaks: Vec<f64>,
    /// Times that are asked for, by their places.
    asked: Vec<(usize, f64)>,
}

/// A run leg by leg. What happens at the end of leg k is event k + 1 of the signature.
struct Course {
    legs: Vec<Leg>,
    signature: Signature,
    units: ScaledUnits,
    n_stops: usize,
}

/// The derivatives of the states of a run at some times by numbers of its scene. At an instant they are those behind it.
///
/// # Errors
/// A number that the scene does not have, or that its stops do not share; a run that did not keep its motion, or whose numbers drift by ramps; times
/// outside it; what the functions of a nonlinear scene report.
///
/// # References
/// Theory section 21, "Runs".
///
/// # Examples
/// ```
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{Forcing, LinearSystem, Parameter, Scene, SimulateOptions, Stop, derivatives_of_run, simulate};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.0], dmatrix![0.0])?;
/// let scene = Scene::new(system, Forcing::Unforced, [Stop::new(0, 1.0, 0.5)?])?;
/// let run = simulate(&scene, &dvector![0.0], &dvector![2.0], (0.0, 3.0), &SimulateOptions::default())?;
/// // From the stop at d it goes back with half the speed: q = d - (t - d/2), v = -1 = -2 e.
/// let found = derivatives_of_run(&run, &[Parameter::Clearance, Parameter::Restitution], &[2.0])?;
/// assert!((found.by[0][(0, 0)] - 1.5).abs() < 1e-9 && (found.by[1][(0, 1)] + 2.0).abs() < 1e-9);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn derivatives_of_run(
    run: &Trajectory,
    parameters: &[Parameter],
    times: &[f64],
) -> Result<RunDerivatives> {
    let scene = run.scene();
    let n = scene.n_dof();
    let nothing = DMatrix::from_element(times.len(), 2 * n, f64::NAN);
    let mut found = RunDerivatives {
        by: vec![nothing; parameters.len()],
        reason: None,
    };
    let course = match Course::of(run, times)? {
        Ok(course) => course,
        Err(reason) => {
            found.reason = Some(reason);
            return Ok(found);
        }
    };
    let numbers = Numbers::new(scene, parameters, course.units.position)?;
    // Of each number how the values of all legs change with it.
    let mut by_number = Vec::with_capacity(parameters.len());
    let step = step(scene, &course.signature);
    for (i, parameter) in parameters.iter().enumerate() {
        let make = |offset: f64| numbers.scene(i, offset);
        let at = |node: &Node| course.values(&node.scene);
        let mut rates = None;
        let mut part = 1.0;
        for _ in 0..=MOST_CLOSER {
            let stencil = Stencil::new(&make, part * step.0 * numbers.size(i), step.1)?;
            match stencil.derivative(at) {
                Err(Error::NoConvergence { stage, .. }) if stage == NO_REST => part *= CLOSER,
                found => {
                    rates = found?;
                    break;
                }
            }
        }
        if rates.is_none() {
            found.reason = Some(format!("by {parameter}: {BORDER}"));
        }
        by_number.push(rates);
    }
    let carried = with_equations(scene, course.equations(), |shooting| {
        course.carry(shooting, run, &by_number, &mut found)
    });
    match carried {
        Err(Error::NoConvergence { stage, .. }) if stage == NO_REST => {
            found.reason = Some("impacts that accumulate come to no rest".to_owned());
        }
        carried => carried?,
    }
    Ok(found)
}

impl Course {
    /// The legs of a run; why it has no derivatives, if it has none at all.
    fn of(run: &Trajectory, times: &[f64]) -> Result<std::result::Result<Self, String>> {
        let (first, end) = run.span();
        if !run.ramps().is_empty() {
            let rule = "numbers that drift by a ramp have no derivatives here";
            return Err(Error::bad_value("ramp", "one", rule));
        }
        for &t in times {
            if !(first..=end).contains(&t) {
                let rule = format!("it must lie in the span of the run, ({first}, {end})");
                return Err(Error::bad_value("t_eval", t, rule));
            }
        }
        let begin = joined(&run.state(first, ImpactSide::Before)?);
        let is_held = (run.stretches()?.first()).is_some_and(|own| own.kind != SegmentKind::Flight);
        let instants = match instants_of(run) {
            // The last impacts before an accumulation are part of it.
            Ok(instants) => folded(instants, run.scene()),
            Err(Error::BadValue { value, .. }) => {
                return Ok(Err(format!("of {value} there are none")));
            }
            Err(error) => return Err(error),
        };
        let is_struck = instants.first().is_some_and(|own| own.time <= first);
        if is_held || is_struck {
            return Ok(Err(BEGUN.to_owned()));
        }
        let states = instants.iter().map(|own| &own.state).chain([&begin]);
        let units = ScaledUnits::of(states, run.scene().period().unwrap_or(end - first));
        let mut stages = vec![ContactStage {
            event: Event::Nothing,
            held: Vec::new(),
        }];
        let mut legs = Vec::with_capacity(instants.len() + 1);
        let mut from = (first, begin);
        for own in instants {
            legs.push(Leg::new(from, own.time));
            stages.push(ContactStage {
                event: own.event,
                held: own.held,
            });
            from = (own.start, own.state);
        }
        legs.push(Leg::new(from, end));
        let breaks = run.scene().excitation().breaks();
        for leg in &mut legs {
            let within = breaks.iter().filter(|&&t| leg.start < t && t < leg.end);
            leg.breaks = within.copied().collect();
        }
        for (place, &t) in times.iter().enumerate() {
            let own = legs.iter().rposition(|leg| leg.start <= t).unwrap_or(0);
            legs[own].asked.push((place, t));
        }
        let signature = Signature {
            stages,
            n_periods: 1,
            depends_on_time: false,
            images: None,
        };
        let mut all = Self {
            legs,
            signature,
            units,
            n_stops: run.scene().stops().len(),
        };
        let ends = with_equations(run.scene(), all.equations(), |shooting| {
            if all.is_touching(shooting)? {
                return Ok(None);
            }
            let each = all.legs.iter().enumerate();
            let each = each.map(|(k, leg)| leg.flown(shooting, k, leg.end));
            each.collect::<Result<Vec<_>>>().map(Some)
        })?;
        let Some(ends) = ends else {
            return Ok(Err(BEGUN.to_owned()));
        };
        for (leg, end) in all.legs.iter_mut().zip(ends) {
            leg.before = end;
        }
        Ok(Ok(all))
    }

    /// Whether the run begins on a stop that it does not leave.
    fn is_touching(&self, shooting: &Shooting<'_>) -> Result<bool> {
        let Leg { start, state, .. } = &self.legs[0];
        let n = state.len() / 2;
        for stop in 0..self.n_stops {
            let at = shooting.motion.gap(stop, *start, state)?;
            let size = at.gradient.amax();
            let (near, slow) = (
                MET * size * self.units.position,
                SLOW * size * self.units.velocity,
            );
            if at.gap <= near && at.speed(state.rows(n, n)) <= slow {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// What happens, and the size of what is integrated.
    fn equations(&self) -> (&Signature, f64) {
        let ScaledUnits {
            position, velocity, ..
        } = self.units;
        (&self.signature, position.min(velocity))
    }

    /// The event at the end of a leg, but at that of the last one.
    fn event(&self, k: usize) -> Option<usize> {
        Some(k + 1).filter(|next| *next < self.legs.len())
    }

    /// What each leg comes to in a scene, from the state with which it begins: its states at the times that are asked for and at its end, what the
    /// event there lacks at the time that it has, and what becomes there of the state before it.
    fn values(&self, scene: &Scene) -> Result<Vec<f64>> {
        let mut all = Vec::new();
        with_equations(scene, self.equations(), |shooting| {
            for (k, leg) in self.legs.iter().enumerate() {
                let times = leg.asked.iter().map(|asked| asked.1).chain([leg.end]);
                for t in times {
                    all.extend(leg.flown(shooting, k, t)?.iter());
                }
                if let Some(event) = self.event(k) {
                    let mut y = leg.timed(0);
                    all.push(lacks(shooting, event, &self.units, &y)?.0);
                    shooting.pass(event, &self.units, &mut y)?;
                    // What is held loses along its reaction what it is not to have.
                    let held = self.held(event);
                    project_onto(shooting.motion, held, y.time, &mut y.state)?;
                    all.extend(y.state.iter());
                    all.push(y.time);
                }
            }
            Ok(())
        })?;
        Ok(all)
    }

    /// Carries deviations through all legs, until there are none any more.
    fn carry(
        &self,
        shooting: &Shooting<'_>,
        run: &Trajectory,
        by_number: &[Option<Vec<f64>>],
        found: &mut RunDerivatives,
    ) -> Result<()> {
        let (two_n, count) = (self.legs[0].state.len(), by_number.len());
        let mut read = 0;
        // The next values of all numbers, one column each.
        let mut next = |rows: usize| {
            let value = |values: &Vec<f64>, i: usize| values[read + i];
            let part = DMatrix::from_fn(rows, count, |i, j| {
                let own = by_number[j].as_ref();
                own.map_or(f64::NAN, |values| value(values, i))
            });
            read += rows;
            part
        };
        let mut x = DMatrix::zeros(two_n, count);
        for (k, leg) in self.legs.iter().enumerate() {
            let touch = run
                .grazes()
                .iter()
                .find(|own| leg.start <= own.time && own.time <= leg.end);
            for &(place, t) in &leg.asked {
                let there = leg.carried(shooting, k, t, &x)? + next(two_n);
                // Behind a touch there is none, nor within impacts that accumulate.
                if touch.is_some_and(|own| own.time <= t) || t > leg.end {
                    continue;
                }
                for (j, by) in found.by.iter_mut().enumerate() {
                    by.set_row(place, &there.column(j).transpose());
                }
            }
            if let Some(own) = touch {
                found.reason = Some(format!(
                    "the run grazes stop {} at t = {}: one-sided only",
                    own.stop, own.time
                ));
                return Ok(());
            }
            x = leg.carried(shooting, k, leg.end, &x)? + next(two_n);
            let Some(event) = self.event(k) else {
                return Ok(());
            };
            if let Some(reason) = self.refused(shooting, event, leg)? {
                found.reason = Some(reason);
                return Ok(());
            }
            let rate = shooting.motion.rate(self.held(k), leg.end, &leg.before)?;
            let mut y = leg.timed(count);
            y.deviations.copy_from(&x);
            let own = lacks(shooting, event, &self.units, &y)?.1.transpose() + next(1);
            let mut flow = leg.timed(1);
            flow.deviations.copy_from(&rate);
            flow.delays[0] = 1.0;
            let along = lacks(shooting, event, &self.units, &flow)?.1[0];
            y.delays = -own.transpose() / along;
            y.deviations += rate * y.delays.transpose();
            shooting.pass(event, &self.units, &mut y)?;
            y.deviations += next(two_n);
            y.delays += next(1).transpose();
            let rate = shooting.motion.rate(self.held(event), y.time, &y.state)?;
            x = y.deviations - rate * y.delays.transpose();
        }
        Ok(())
    }

    fn held(&self, stage: usize) -> &[usize] {
        &self.signature.stages[stage].held
    }

    /// Why there are no derivatives behind an event.
    fn refused(&self, shooting: &Shooting<'_>, event: usize, leg: &Leg) -> Result<Option<String>> {
        let (at, n) = (leg.end, leg.before.len() / 2);
        if let Event::Strike(stops) = &self.signature.stages[event].event {
            // Of stops that are met at once some may receive no impulse.
            let before = self.held(event - 1);
            for stop in (0..self.n_stops).filter(|stop| !before.contains(stop)) {
                let gap = shooting.motion.gap(stop, at, &leg.before)?;
                let size = gap.gradient.amax();
                let speed = gap.speed(leg.before.rows(n, n));
                let is_met = gap.gap <= MET * size * self.units.position && speed < 0.0;
                if is_met && stop != stops[0] {
                    return Ok(Some(format!(
                        "the run hits stops {} and {stop} together at t = {at}: it would hit one of them first",
                        stops[0]
                    )));
                }
                if stop == stops[0] && speed.abs() <= SLOW * size * self.units.velocity {
                    return Ok(Some(format!(
                        "the run grazes stop {stop} at t = {at}: one-sided only"
                    )));
                }
            }
        }
        let next = &self.legs[event];
        let is_short = next.end - next.start <= SHORT_CONTACT * TAU * self.units.time;
        let held = self.held(event).first();
        let short = held.filter(|_| is_short && event + 1 < self.legs.len());
        Ok(short.map(|stop| {
            format!("the contact with stop {stop} at t = {at} ends as it begins: one-sided only")
        }))
    }
}

impl Leg {
    fn new((start, state): (f64, DVector<f64>), end: f64) -> Self {
        Self {
            start,
            end,
            before: state.clone(),
            state,
            breaks: Vec::new(),
            asked: Vec::new(),
        }
    }

    /// Its state at a time.
    fn flown(&self, shooting: &Shooting<'_>, k: usize, t: f64) -> Result<DVector<f64>> {
        let none = DMatrix::zeros(self.state.len(), 0);
        Ok(self.flow(shooting, k, t, none)?.0)
    }

    /// Deviations at its start as they are at a time.
    fn carried(
        &self,
        shooting: &Shooting<'_>,
        k: usize,
        t: f64,
        deviations: &DMatrix<f64>,
    ) -> Result<DMatrix<f64>> {
        Ok(self.flow(shooting, k, t, deviations.clone())?.1)
    }

    /// Its state at a time, and deviations from it.
    fn flow(
        &self,
        shooting: &Shooting<'_>,
        k: usize,
        t: f64,
        mut deviations: DMatrix<f64>,
    ) -> Result<(DVector<f64>, DMatrix<f64>)> {
        let (mut state, held) = (self.state.clone(), &shooting.stages[k].held);
        let mut from = self.start;
        let breaks = self.breaks.iter().copied().filter(|own| *own < t);
        for to in breaks.chain([t]) {
            let span = (from, to);
            (shooting.motion).flow(held, span, &mut state, &mut deviations)?;
            from = to;
        }
        Ok((state, deviations))
    }

    /// The state before its end, with so many deviations that are zero.
    fn timed(&self, count: usize) -> Timed {
        Timed {
            time: self.end,
            state: self.before.clone(),
            deviations: DMatrix::zeros(self.before.len(), count),
            delays: DVector::zeros(count),
        }
    }
}

/// Does some work with the equations of a run of some size, whatever moves it: what follows signals is integrated.
fn with_equations<T>(
    scene: &Scene,
    (signature, size): (&Signature, f64),
    work: impl FnOnce(&Shooting<'_>) -> Result<T>,
) -> Result<T> {
    if scene.excitation().signals.is_empty() {
        return with_shooting(scene, signature, |shooting, _| work(shooting));
    }
    let motion = IntegratedMaps::new(scene, scene.phase());
    work(&Shooting {
        motion: &motion.in_parts_of(size),
        stages: &signature.stages,
        clocked: signature.clocked(scene),
        images: None,
        weak_directions: OF_INTEGRATED,
    })
}

/// What an event lacks in a state before it, and what deviations make of that: the gap of the stop that is struck, the condition of another.
fn lacks(
    shooting: &Shooting<'_>,
    event: usize,
    units: &ScaledUnits,
    y: &Timed,
) -> Result<(f64, DVector<f64>)> {
    if let Some(condition) = shooting.condition(event, units, y)? {
        return Ok(condition);
    }
    let Some(stop) = shooting.newly_struck(event).next() else {
        // Nothing is newly hit: a stop that was held receives an impulse, at the time of another's.
        return Ok((0.0, DVector::zeros(y.delays.len())));
    };
    let at = shooting.motion.gap(stop, y.time, &y.state)?;
    Ok((at.gap, at.timed_deviations(&y.deviations, &y.delays)))
}
