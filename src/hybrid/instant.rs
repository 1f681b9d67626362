//! The instants of an itinerary as maps: what a transition does to a state and to deviations from it, and the condition at which it comes.

use crate::error::Result;
use crate::hybrid::chatter_map::{Chatter, complete, finish, strike};
use crate::hybrid::landing::land;
use crate::hybrid::maps::{GapAt, HybridMaps};
use crate::hybrid::scaled_units::ScaledUnits;
use crate::hybrid::timed::Timed;
use crate::law::{Guard, Regime, Stage, Transition};
use crate::tolerance::CENTRAL_DIFFERENCE_STEP;
use nalgebra::{DMatrix, DVector};

/// Maps a state before a transition to the one after it; returns the impulses, and the accumulating impacts there.
pub(crate) fn pass<M: HybridMaps + ?Sized>(
    motion: &M,
    transition: &Transition,
    units: &ScaledUnits,
    y: &mut Timed,
) -> Result<(Vec<f64>, Option<Chatter>)> {
    Ok(match transition {
        Transition::Strike(stops) => (strike(motion, stops, y)?, None),
        Transition::Chatter(stop) => (Vec::new(), Some(complete(motion, *stop, units, y)?)),
        Transition::Release(_) | Transition::Change(..) | Transition::Nothing => (Vec::new(), None),
    })
}

/// The state after the impacts of a transition at a time.
pub(crate) fn reset<M: HybridMaps + ?Sized>(
    motion: &M,
    transition: &Transition,
    t: f64,
    mut state: DVector<f64>,
) -> Result<DVector<f64>> {
    if transition.is_strike() {
        let none = &mut DMatrix::zeros(state.len(), 0);
        motion.impact(transition.struck(), t, &mut state, none)?;
    }
    Ok(state)
}

/// Maps a state before a transition, with its deviations, to the one with which the regime behind it begins; of impacts that accumulate only the
/// rest is left. Elements that are held from then on take away, along their reactions, the deviations that would leave them.
pub(crate) fn enter<M: HybridMaps + ?Sized>(
    motion: &M,
    stage: &Stage,
    units: &ScaledUnits,
    y: &mut Timed,
) -> Result<()> {
    match stage.transition.accumulation() {
        Some(stop) => finish(motion, (stop, Regime::free()), units, y)?,
        None => pass(motion, &stage.transition, units, y).map(drop)?,
    }
    land(motion, &stage.regime, y)
}

/// What there is to say of a transition that has no condition.
pub(crate) const NO_CONDITION: &str = "stops that are held receive an impulse";

/// The gap of a stop as a condition: scaled, with what deviations make of it.
fn gap_condition<M: HybridMaps + ?Sized>(
    motion: &M,
    stop: usize,
    units: &ScaledUnits,
    y: &Timed,
) -> Result<(f64, DVector<f64>)> {
    let at = motion.gap(stop, y.time, &y.state)?;
    let scale = 1.0 / (at.gradient.amax() * units.position);
    let row = at.timed_deviations(&y.deviations, &y.delays);
    Ok((at.gap * scale, row * scale))
}

/// The condition at which a transition comes, on a state before it: the gap of the first stop that is struck, or that of another transition.
/// `None` where elements that are held receive an impulse by themselves.
pub(crate) fn arrival<M: HybridMaps + ?Sized>(
    motion: &M,
    (before, stage): (&Regime, &Stage),
    units: &ScaledUnits,
    y: &Timed,
) -> Result<Option<(f64, DVector<f64>)>> {
    let closing = stage.transition.closing(before).next();
    match closing {
        Some(stop) => gap_condition(motion, stop, units, y).map(Some),
        None => condition(motion, stage, units, y),
    }
}

/// The condition of a transition on a state before it and on its time, scaled, with what deviations make of it; none of a stop that is
/// struck, which has its own on the state after, and of a stop that relaxes.
pub(crate) fn condition<M: HybridMaps + ?Sized>(
    motion: &M,
    stage: &Stage,
    units: &ScaledUnits,
    y: &Timed,
) -> Result<Option<(f64, DVector<f64>)>> {
    match stage.transition {
        Transition::Nothing | Transition::Strike(_) => Ok(None),
        // The place of the element is known from an instant before.
        Transition::Change(..) if stage.transition.met_again().is_some() => Ok(None),
        Transition::Chatter(stop) => gap_condition(motion, stop, units, y).map(Some),
        Transition::Release(stop) => {
            let GapAt { gradient, .. } = motion.gap(stop, y.time, &y.state)?;
            let scale = units.time / (gradient.amax() * units.velocity);
            let pull = |t: f64, x: &DVector<f64>| {
                let rate = motion.rate(&stage.regime, t, x)?;
                motion.gap_acceleration(stop, t, x, &rate)
            };
            by_differences(pull, scale, units, y).map(Some)
        }
        Transition::Change(guard, _) if guard.is_seat() => {
            gap_condition(motion, guard.element, units, y).map(Some)
        }
        Transition::Change(guard, _) => force_condition(motion, guard, units, y).map(Some),
    }
}

/// The force of an element that gives way as a condition: scaled, with what deviations make of it.
fn force_condition<M: HybridMaps + ?Sized>(
    motion: &M,
    guard: Guard,
    units: &ScaledUnits,
    y: &Timed,
) -> Result<(f64, DVector<f64>)> {
    let force = motion.contact_law(guard.element).pressed_force();
    let GapAt { gradient, .. } = motion.gap(guard.element, y.time, &y.state)?;
    let scale = 1.0 / (gradient.amax() * force.size_at(units.position, units.velocity));
    let value = |t: f64, x: &DVector<f64>| {
        let at = motion.gap(guard.element, t, x)?;
        let n = at.gradient.len();
        Ok(force.at(at.gap, at.speed(x.rows(n, n))))
    };
    by_differences(value, scale, units, y)
}

/// A value as a condition, scaled, with what deviations make of it by differences.
fn by_differences(
    value: impl Fn(f64, &DVector<f64>) -> Result<f64>,
    scale: f64,
    units: &ScaledUnits,
    y: &Timed,
) -> Result<(f64, DVector<f64>)> {
    let mut row = DVector::zeros(y.deviations.ncols());
    for (j, column) in y.deviations.column_iter().enumerate() {
        let size = units.size_of(column.iter(), y.delays[j]);
        if size > 0.0 {
            let step = CENTRAL_DIFFERENCE_STEP / size;
            let at = |s: f64| value(y.time + s * y.delays[j], &(&y.state + column * s));
            row[j] = (at(step)? - at(-step)?) / (2.0 * step) * scale;
        }
    }
    Ok((value(y.time, &y.state)? * scale, row))
}
