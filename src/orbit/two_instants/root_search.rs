//! The roots of conditions that are linear in all unknowns but a time: Newton's method with all unknowns at once, from where the time was
//! isolated.

use crate::error::Result;
use crate::observer::Observer;
use crate::orbit::two_instants::isolate::{Enclosure, IntervalEnd, IntervalModel, SearchInterval};
use crate::orbit::two_instants::polish::{
    Root, TwoInstantEquations, circle_starts, least_squares_start, polish,
};
use crate::root::{Bracket, bisected};
use crate::tolerance::{SAME_FLIGHT_TIME, SAME_ROOT_UNKNOWNS};
use nalgebra::DVector;

/// The part of a bracket, from which Newton's method went astray, to which bisection narrows it. [work]
const BRACKET_RESOLUTION: f64 = 1.0 / (1u64 << 30) as f64;

/// Conditions that are linear in all unknowns but a time.
pub(crate) trait TimedConditions {
    /// What takes Taylor models of the analytic function whose zeros are the times.
    fn sampler(&self) -> impl FnMut(&SearchInterval) -> IntervalModel + '_;

    /// The conditions at a time, and their rates in units of it.
    fn equations(&self, time: f64) -> TwoInstantEquations;

    /// The unit of the phase, where that is unknown: the last two unknowns times it are on the unit circle.
    fn circle(&self) -> Option<f64>;

    /// The unit of time in which the rates of the conditions are.
    fn time_unit(&self) -> f64;

    /// The period, in parts of which two times are told apart.
    fn period(&self) -> f64;

    /// A root with what is not among the unknowns.
    fn completed(&self, root: Root) -> Root {
        root
    }
}

/// The roots that Newton's method reaches from a time.
pub(crate) fn near<C: TimedConditions>(
    conditions: &C,
    time: f64,
    observer: &mut Observer,
) -> Result<Vec<Root>> {
    let here = conditions.equations(time);
    let circle = conditions.circle();
    let starts: Vec<DVector<f64>> = match circle {
        Some(unit) => circle_starts(&here, unit)?,
        None => vec![least_squares_start(&here)?],
    };
    let mut roots = Vec::new();
    for x in starts {
        observer.ask()?;
        let equations = |time: f64| conditions.equations(time);
        if let Some(root) = polish(&equations, circle, conditions.time_unit(), time, x) {
            keep(&mut roots, conditions.completed(root), conditions.period());
        }
    }
    Ok(roots)
}

/// A root of some kind in a bracket of one sign change, narrowed by bisection where Newton's method goes astray.
pub(crate) fn within<C: TimedConditions>(
    conditions: &C,
    bracket: &Enclosure,
    is_wanted: impl Fn(&Root) -> bool,
    observer: &mut Observer,
) -> Result<Option<Root>> {
    let roots = near(conditions, bracket.guess, observer)?;
    if let Some(root) = roots.into_iter().find(&is_wanted) {
        return Ok(Some(root));
    }
    let middle = halved(conditions, bracket, observer)?;
    let roots = near(conditions, middle, observer)?;
    Ok(roots.into_iter().find(is_wanted))
}

/// Adds a root that is not known yet.
pub(crate) fn keep(roots: &mut Vec<Root>, root: Root, period: f64) {
    let is_known = roots.iter().any(|known| {
        (known.dt - root.dt).abs() <= SAME_FLIGHT_TIME * period
            && (&known.x - &root.x).amax() <= SAME_ROOT_UNKNOWNS * root.x.amax()
    });
    if !is_known {
        roots.push(root);
    }
}

/// The middle of a bracket of one sign change that bisection has narrowed.
fn halved<C: TimedConditions>(
    conditions: &C,
    bracket: &Enclosure,
    observer: &mut Observer,
) -> Result<f64> {
    let mut sample = conditions.sampler();
    let mut value = |t: f64| {
        let place = SearchInterval {
            low: t,
            high: t,
            end: IntervalEnd::Neither,
        };
        sample(&place).series.at_origin()
    };
    let Enclosure { low, high, .. } = *bracket;
    // The end of the range may be a zero that was divided out: the sign is that of the other one.
    let (below, above) = (value(low), value(high));
    let is_from_low = below.abs() > above.abs();
    let sign = if is_from_low { below } else { above };
    let between = Bracket::new([low, high]);
    let narrowed = bisected(
        between,
        BRACKET_RESOLUTION * between.length(),
        |t| -> Result<bool> {
            observer.ask()?;
            Ok((value(t) * sign > 0.0) == is_from_low)
        },
    )?;
    Ok(narrowed.middle())
}
