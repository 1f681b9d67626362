//! Derivatives of the states of a run by numbers of its scene (theory 21, "Runs"). Deviations are transported along arcs and across events;
//! the partial derivatives of each arc and each event by a number are differences of that one alone, so that no digits are lost where
//! deviations grow. Unknowns: deviations of (q, v) and the delay of each event, per unit of the number.

use crate::derivative::adaptive_differences::{AdaptiveDifferences, ScaledBlock};
use crate::derivative::itinerary::{RunItinerary, timed, with_doubts};
use crate::derivative::numbers::Numbers;
use crate::derivative::stencil::{DifferenceOrder, Stencil};
use crate::error::{Error, Result};
use crate::flow::differences::WarningLog;
use crate::hybrid::{HybridMaps, NO_CONDITION, Timed, arrival, enter};
use crate::law::Transition;
use crate::model::{Parameter, Scene};
use crate::orbit::with_maps;
use crate::simulate::Trajectory;
use crate::tolerance::{
    HIT_TOGETHER_GAP, RUN_DERIVATIVE_STEPS, RUN_VALUE_NOISE, SHORT_CONTACT, TOUCHING_IMPACT_SPEED,
};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// How the states of a run change with numbers of its scene, times and the first state being the same.
#[derive(Debug, Clone, PartialEq)]
pub struct RunDerivatives {
    /// For each number the derivatives of `(q, v)` at m times, shape `(m, 2n)`, [m, m/s] per unit of the number; not a number from where
    /// there are none.
    pub by: Vec<DMatrix<f64>>,
    /// Why there are none from some time on.
    pub reason: Option<String>,
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
/// let found = derivatives_of_run(&run, &[Parameter::CLEARANCE, Parameter::RESTITUTION], &[2.0])?;
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
    check(run, times)?;
    let mut itinerary = match RunItinerary::of(run)? {
        Ok(itinerary) => itinerary,
        Err(reason) => {
            found.reason = Some(reason);
            return Ok(found);
        }
    };
    itinerary.ask(times);
    let fastest = scene.excitation().rotations.fastest();
    let (first, end) = run.span();
    let turned = fastest * first.abs().max(end.abs());
    let mut numbers = Numbers::new(scene, parameters, itinerary.units.position)?.turning(turned);
    if itinerary.accumulates() {
        numbers = numbers.accumulating();
    }
    // For each number the partial derivatives of all arcs and events.
    let mut by_number = Vec::with_capacity(parameters.len());
    for (i, parameter) in parameters.iter().enumerate() {
        let rates = itinerary.rates(&|offset| numbers.scene(i, offset), numbers.size(i))?;
        if rates.is_none() {
            let reason = format!("by {parameter}: the motion does not change smoothly with it");
            found.reason.get_or_insert(reason);
        }
        by_number.push(rates);
    }
    let reason = with_doubts(scene, &itinerary.signature, |motion, watch| {
        itinerary.carry((motion, watch), run, &by_number, &mut found)
    })?;
    found.reason = reason.or(found.reason);
    Ok(found)
}

fn check(run: &Trajectory, times: &[f64]) -> Result<()> {
    run.scene().check_springs_are_linear("derivatives=")?;
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
    Ok(())
}

impl RunItinerary {
    /// The blocks of the list that `values` returns, with their units.
    fn blocks(&self) -> Vec<ScaledBlock> {
        let n = self.arcs[0].after.len() / 2;
        let state = [(n, self.units.position), (n, self.units.velocity)];
        let mut all = Vec::new();
        for (k, asked) in self.asked.iter().enumerate() {
            for _ in 0..=asked.len() {
                all.extend(state);
            }
            if self.next(k).is_some() {
                all.push((1, 1.0));
                all.extend(state);
                all.push((1, self.units.time));
            }
        }
        all
    }

    /// The values of each arc in a scene, from the state with which it begins in the run: its states at the times that are asked for and at
    /// its end; then for the event there, at its time in the run, the residual of its condition, the state after it and the delay of that.
    fn values(&self, scene: &Scene) -> Result<Vec<f64>> {
        let mut all = Vec::new();
        with_maps(scene, &self.signature, |motion| {
            for (k, arc) in self.arcs.iter().enumerate() {
                let mut none = DMatrix::zeros(arc.after.len(), 0);
                self.along(motion, k, &mut none, |x, _| all.extend(x.iter()))?;
                if let Some(next) = self.next(k) {
                    let (mut y, event) = (timed(arc, 0), (arc.regime(), &next.stage));
                    all.push(arrival(motion, event, &self.units, &y)?.map_or(0.0, |own| own.0));
                    enter(motion, &next.stage, &self.units, &mut y)?;
                    all.extend(y.state.iter());
                    all.push(y.time - arc.end);
                }
            }
            Ok(())
        })?;
        Ok(all)
    }

    /// Moves a state along an arc with deviations of its start, and shows both at the times that are asked for and at its end.
    fn along(
        &self,
        motion: &dyn HybridMaps,
        k: usize,
        deviations: &mut DMatrix<f64>,
        mut show: impl FnMut(&DVector<f64>, &DMatrix<f64>),
    ) -> Result<()> {
        let arc = &self.arcs[k];
        let (mut from, mut state) = (arc.start, arc.after.clone());
        for to in self.asked[k].iter().map(|asked| asked.1).chain([arc.end]) {
            motion.flow(arc.regime(), (from, to), &mut state, deviations)?;
            show(&state, deviations);
            from = to;
        }
        Ok(())
    }

    /// Partial derivatives of the values by a number, of which `make` makes scenes and whose scale is `size`; each block by the step that
    /// suits it, `None` where no step suits one.
    fn rates(&self, make: &dyn Fn(f64) -> Result<Scene>, size: f64) -> Result<Option<Vec<f64>>> {
        let mut differences = AdaptiveDifferences::new(self.blocks(), RUN_VALUE_NOISE);
        for step in RUN_DERIVATIVE_STEPS {
            let stencil = Stencil::new(make, step * size, DifferenceOrder::Fourth)?;
            let found = stencil.differences(|node| self.values(&node.scene))?;
            let Some(found) = found else {
                return Ok(None);
            };
            differences.take(&stencil, &found);
            if differences.is_complete() {
                break;
            }
        }
        Ok(differences.derivative())
    }

    /// Transports deviations along all arcs, and returns the reason why they end early, if they do.
    fn carry(
        &self,
        (motion, watch): (&dyn HybridMaps, &WarningLog),
        run: &Trajectory,
        by_number: &[Option<Vec<f64>>],
        found: &mut RunDerivatives,
    ) -> Result<Option<String>> {
        let (two_n, count) = (self.arcs[0].after.len(), by_number.len());
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
        for (k, arc) in self.arcs.iter().enumerate() {
            let mut grazes = run.grazes().iter();
            let touch = grazes.find(|own| arc.start <= own.time && own.time <= arc.end);
            let asked = &self.asked[k];
            let mut carried = Vec::with_capacity(asked.len() + 1);
            self.along(motion, k, &mut x, |_, x| carried.push(x.clone()))?;
            for (there, asked) in carried
                .iter_mut()
                .zip((asked.iter().map(Some)).chain([None]))
            {
                *there += next(two_n);
                // Behind a touch there is none, nor behind a doubt.
                let is_known = |own: &&(usize, f64)| {
                    touch.is_none_or(|touch| own.1 < touch.time)
                        && watch.noted().is_none_or(|[first, _]| own.1 < first.time())
                };
                if let Some((place, _)) = asked.filter(is_known) {
                    for (j, by) in found.by.iter_mut().enumerate() {
                        by.set_row(*place, &there.column(j).transpose());
                    }
                }
            }
            if let Some([first, _]) = watch.noted() {
                return Ok(Some(first.reason()));
            }
            if let Some(own) = touch {
                return Ok(Some(format!(
                    "the run grazes stop {} at t = {}: one-sided only",
                    own.stop, own.time
                )));
            }
            x = carried.pop().expect("the end");
            let Some(behind) = self.next(k) else {
                continue;
            };
            if let Some(reason) = self.refused(motion, k)? {
                return Ok(Some(reason));
            }
            let rate = motion.rate(arc.regime(), arc.end, &arc.before_next)?;
            let mut y = timed(arc, count);
            y.deviations.copy_from(&x);
            let mut flow = timed(arc, 1);
            flow.deviations.copy_from(&rate);
            flow.delays[0] = 1.0;
            let event = (arc.regime(), &behind.stage);
            let lacks = |y: &Timed| arrival(motion, event, &self.units, y);
            let (Some((_, own)), Some((_, along))) = (lacks(&y)?, lacks(&flow)?) else {
                let what = NO_CONDITION;
                return Ok(Some(format!("{what} at t = {} by themselves", arc.end)));
            };
            let own = own.transpose() + next(1);
            y.delays = -own.transpose() / along[0];
            y.deviations += rate * y.delays.transpose();
            enter(motion, &behind.stage, &self.units, &mut y)?;
            y.deviations += next(two_n);
            y.delays += next(1).transpose();
            let rate = motion.rate(behind.regime(), y.time, &y.state)?;
            x = y.deviations - rate * y.delays.transpose();
        }
        Ok(None)
    }

    /// The reason why there are no derivatives after the event at the end of an arc, if there are none.
    fn refused(&self, motion: &dyn HybridMaps, k: usize) -> Result<Option<String>> {
        let (arc, next) = (&self.arcs[k], &self.arcs[k + 1]);
        let (at, n) = (arc.end, arc.before_next.len() / 2);
        if let Transition::Change(guard, _) = next.stage.transition
            && guard.is_gap()
        {
            let gap = motion.gap(guard.element, at, &arc.before_next)?;
            let speed = gap.speed(arc.before_next.rows(n, n));
            let slow = TOUCHING_IMPACT_SPEED * gap.gradient.amax() * self.units.velocity;
            if speed.abs() <= slow {
                return Ok(Some(format!(
                    "the run grazes stop {} at t = {at}: one-sided only",
                    guard.element
                )));
            }
        }
        if let Some(&first) = next.hits().first() {
            // Some of several stops that are met at once may receive no impulse.
            for stop in (0..self.n_stops).filter(|&stop| arc.regime().leaves_free(stop)) {
                let gap = motion.gap(stop, at, &arc.before_next)?;
                let size = gap.gradient.amax();
                let speed = gap.speed(arc.before_next.rows(n, n));
                let is_met =
                    gap.gap <= HIT_TOGETHER_GAP * size * self.units.position && speed < 0.0;
                if is_met && stop != first {
                    return Ok(Some(format!(
                        "the run hits stops {first} and {stop} together at t = {at}: it would hit one of them first"
                    )));
                }
                let is_slow = speed.abs() <= TOUCHING_IMPACT_SPEED * size * self.units.velocity;
                if stop == first && is_slow && !self.is_accumulating(k) {
                    return Ok(Some(format!(
                        "the run grazes stop {stop} at t = {at}: one-sided only"
                    )));
                }
            }
        }
        let is_short = next.end - next.start <= SHORT_CONTACT * TAU * self.units.time;
        let held = next.regime().constrained().first();
        let short = held.filter(|_| is_short && k + 2 < self.arcs.len());
        Ok(short.map(|stop| {
            format!("the contact with stop {stop} at t = {at} ends as it begins: one-sided only")
        }))
    }
}
