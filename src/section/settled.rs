//! The regime on which a motion has settled: its period, and the stops that it hits in one.

use crate::error::Result;
use crate::orbit::Pattern;
use crate::path::KeptMotion;
use crate::recurrence::{Advance, Measure, advance, repeats_after};
use crate::section::events::{ImpactEvent, events_of};
use crate::section::points::{PoincarePoints, at_times, strobe_times};
use std::f64::consts::TAU;

/// The regime on which a motion has settled.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Settled {
    /// Periods of the forcing after which it repeats itself, zero where it does not.
    pub n_periods: usize,
    /// Its impacts, those that accumulate taken for one, and the beginnings of contacts with stops that give way.
    pub n_impacts: usize,
    /// The stops hit in one of its periods; empty where it has none.
    pub pattern: Pattern,
    /// By what it is on after some periods, where it repeats itself but for that.
    pub advance: Option<Advance>,
}

/// What a motion under a forcing with a period has settled on, up to a longest period; `turns` are those of positions that are angles,
/// zero of others. It is looked at where no impact is near: next to one, two motions that are
/// close look far apart.
pub(crate) fn settled(motion: &dyn KeptMotion, turns: &[f64], longest: usize) -> Result<Settled> {
    let events = events_of(motion)?;
    let phase_at = motion.forcing_phase();
    let phases = events.iter().map(|event| phase_at(event.time)).collect();
    let phase = farthest_from(phases).unwrap_or_else(|| phase_at(motion.span().0));
    let times = strobe_times(motion, phase)?;
    let points = at_times(motion, &times)?;
    let period = motion.scene().period().unwrap_or_default();
    let (states, measure) = (points.states(), Measure::new(turns, TAU / period));
    let n_periods = repeats_after(&states, &measure, longest);
    let end = times.last().copied().unwrap_or_default();
    let in_one =
        |event: &&ImpactEvent| event.time <= end && event.time > end - n_periods as f64 * period;
    Ok(Settled {
        n_periods,
        n_impacts: events.len(),
        pattern: pattern(events.iter().filter(in_one))?,
        advance: match n_periods {
            0 => advance(&states, &measure, longest),
            _ => None,
        },
    })
}

/// The regime of a motion from its states after impacts: its period is a number of these.
pub(crate) fn settled_by_impacts(
    motion: &dyn KeptMotion,
    points: &PoincarePoints,
    longest: usize,
) -> Result<Settled> {
    // Stops hit at one instant are one return.
    let is_new = |k: &usize| *k == 0 || points.t[*k] > points.t[k - 1];
    let rows: Vec<usize> = (0..points.t.len()).filter(is_new).collect();
    let times: Vec<f64> = rows.iter().map(|&k| points.t[k]).collect();
    let states = points.states().select_rows(&rows);
    let last = times.len().saturating_sub(1);
    let span = times.last().unwrap_or(&0.0) - times.first().unwrap_or(&0.0);
    let frequency = if span > 0.0 {
        TAU * last as f64 / span
    } else {
        1.0
    };
    let turns = vec![0.0; points.q.ncols()];
    let n_periods = repeats_after(&states, &Measure::new(&turns, frequency), longest);
    let mut events = events_of(motion)?;
    events.retain(|event| times.last().is_some_and(|end| event.time <= *end));
    let from = times
        .get(last.saturating_sub(n_periods))
        .copied()
        .unwrap_or_default();
    Ok(Settled {
        n_periods,
        n_impacts: events.len(),
        pattern: pattern(
            events
                .iter()
                .filter(|event| event.time > from && n_periods > 0),
        )?,
        advance: None,
    })
}

/// The angle in the middle of the widest gap between angles in [0, 2 pi).
pub(crate) fn farthest_from(mut angles: Vec<f64>) -> Option<f64> {
    angles.sort_by(f64::total_cmp);
    let (&first, &last) = (angles.first()?, angles.last()?);
    let across = (last, first + TAU - last);
    let gaps = angles.windows(2).map(|pair| (pair[0], pair[1] - pair[0]));
    let widest = gaps.fold(
        across,
        |widest, gap| if gap.1 > widest.1 { gap } else { widest },
    );
    Some((widest.0 + 0.5 * widest.1).rem_euclid(TAU))
}

/// The stops of events in order, those of one instant together, from the smallest on.
fn pattern<'e>(events: impl Iterator<Item = &'e ImpactEvent>) -> Result<Pattern> {
    let mut instants: Vec<(f64, Vec<usize>)> = Vec::new();
    for &ImpactEvent { time, stop, .. } in events {
        match instants.last_mut() {
            Some((last, stops)) if *last == time && !stops.contains(&stop) => stops.push(stop),
            _ => instants.push((time, vec![stop])),
        }
    }
    let mut stops: Vec<Vec<usize>> = instants.into_iter().map(|(_, stops)| stops).collect();
    for together in &mut stops {
        together.sort_unstable();
    }
    let turned = |k: usize| [&stops[k..], &stops[..k]].concat();
    let least = (0..stops.len()).map(turned).min().unwrap_or_default();
    Pattern::new(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_phase_is_in_the_middle_of_the_widest_gap() {
        assert_eq!(farthest_from(vec![]), None);
        let phase = |angles: &[f64]| farthest_from(angles.to_vec()).expect("some");
        assert!((phase(&[1.0]) - (1.0 + 0.5 * TAU)).abs() < 1e-15);
        assert!((phase(&[6.0, 0.5, 2.0]) - 4.0).abs() < 1e-15);
        assert!((phase(&[2.0, 2.5, 5.5]) - 4.0).abs() < 1e-15);
        assert!((phase(&[2.0, 3.0]) - (3.0 + 0.5 * (TAU - 1.0)).rem_euclid(TAU)).abs() < 1e-15);
    }

    #[test]
    fn a_pattern_begins_with_its_smallest_stop() {
        let event = |(time, stop): (f64, usize)| ImpactEvent {
            time,
            stop,
            speed_before: 1.0,
        };
        let of = |all: &[(f64, usize)]| {
            let all: Vec<ImpactEvent> = all.iter().copied().map(event).collect();
            pattern(all.iter()).expect("valid").instants().to_vec()
        };
        assert_eq!(of(&[(0.0, 1), (1.0, 0), (2.0, 1)]), [[0], [1], [1]]);
        assert_eq!(of(&[(0.0, 2), (1.0, 1), (1.0, 0)]), [vec![0, 1], vec![2]]);
        assert!(of(&[]).is_empty());
    }
}
