//! The impacts of a motion as events, those that accumulate until a stop is at rest as one, at their end; and where contacts with stops that
//! give way begin.

use crate::error::Result;
use crate::impact::Impact;
use crate::model::Constraint;
use crate::path::{ImpactSide, KeptMotion, Stretch};

/// An impact, or a sequence of impacts that accumulate, taken as one at its end; or the beginning of a contact with a stop that gives way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ImpactEvent {
    pub time: f64,
    pub stop: usize,
    /// The speed at which the stop was approached: none at the end of impacts that accumulate.
    pub speed_before: f64,
}

/// The events of a motion, in order of time: those of its impacts, and where contacts with stops that give way begin.
pub(crate) fn events_of(motion: &dyn KeptMotion) -> Result<Vec<ImpactEvent>> {
    let mut all = events(motion.impacts(), &motion.stretches()?);
    let begun = contacts_begun(motion)?;
    if begun.is_empty() {
        return Ok(all);
    }
    let speeds = motion.approach_speeds(&begun, ImpactSide::Before)?;
    let own = begun.into_iter().zip(speeds);
    all.extend(own.map(|((time, stop), speed_before)| ImpactEvent {
        time,
        stop,
        speed_before,
    }));
    all.sort_by(|a, b| a.time.total_cmp(&b.time));
    Ok(all)
}

/// The times at which contacts with stops that give way begin along a motion, with the stops.
pub(crate) fn contacts_begun(motion: &dyn KeptMotion) -> Result<Vec<(f64, usize)>> {
    let laws = motion.scene().stops().iter().map(Constraint::contact);
    let laws = laws.enumerate().filter(|(_, law)| !law.is_rigid());
    let compliant: Vec<usize> = laws.map(|own| own.0).collect();
    if compliant.is_empty() {
        return Ok(Vec::new());
    }
    let stretches = motion.stretches()?;
    let is_met = |part: &Stretch<'_>, stop: usize| part.lasting().state(stop).is_met();
    let before = stretches.last().filter(|_| motion.is_closed());
    let before = before.into_iter().chain(&stretches);
    let after = &stretches[usize::from(!motion.is_closed()).min(stretches.len())..];
    let pairs = before.zip(after);
    let each = pairs.flat_map(|(before, part)| {
        let begins = move |stop: &&usize| !is_met(before, **stop) && is_met(part, **stop);
        compliant
            .iter()
            .filter(begins)
            .map(|stop| (part.start, *stop))
    });
    Ok(each.collect())
}

/// The events of impacts, in order of time, and of the parts of a motion, of which those with impacts that accumulate count. These begin
/// with the impacts before them on the same stop, each slower than the one before.
pub(crate) fn events(impacts: &[Impact], stretches: &[Stretch<'_>]) -> Vec<ImpactEvent> {
    let mut all: Vec<ImpactEvent> = Vec::with_capacity(impacts.len());
    let mut rest = impacts.iter().peekable();
    let event = |impact: &Impact| ImpactEvent {
        time: impact.time,
        stop: impact.stop,
        speed_before: impact.approach,
    };
    let resting = |part: &&Stretch<'_>| part.accumulation().is_some();
    for part in stretches.iter().filter(resting) {
        while let Some(impact) = rest.next_if(|impact| impact.time <= part.start) {
            all.push(event(impact));
        }
        if let Some(stop) = part.accumulation() {
            let mut last = 0.0;
            while let Some(before) = all.pop_if(|e| e.stop == stop && e.speed_before > last) {
                last = before.speed_before;
            }
            all.push(ImpactEvent {
                time: part.end,
                stop,
                speed_before: 0.0,
            });
        }
    }
    all.extend(rest.map(event));
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hybrid::SegmentKind;
    use crate::law::Regime;

    fn impact(time: f64, stop: usize, approach: f64) -> Impact {
        Impact {
            time,
            stop,
            approach,
            departure: 0.5 * approach,
            impulse: 1.5 * approach,
            phase: 0.0,
        }
    }

    #[test]
    fn impacts_that_accumulate_are_one_event() {
        let speeds = [
            (1.0, 1, 0.1),
            (2.0, 0, 0.3),
            (3.0, 0, 0.8),
            (3.5, 0, 0.4),
            (3.7, 0, 0.2),
            (6.0, 1, 0.7),
        ];
        let impacts = speeds.map(|(time, stop, speed)| impact(time, stop, speed));
        let regime = Regime::holding([0]);
        let chatter = Stretch {
            segment: 0,
            kind: SegmentKind::Chatter,
            regime: &regime,
            start: 3.7,
            end: 3.9,
        };
        let times = |events: Vec<ImpactEvent>| -> Vec<(f64, f64)> {
            events.iter().map(|e| (e.time, e.speed_before)).collect()
        };
        let found = times(events(&impacts, &[chatter]));
        assert_eq!(found, [(1.0, 0.1), (2.0, 0.3), (3.9, 0.0), (6.0, 0.7)]);
        assert_eq!(events(&impacts, &[]).len(), 6);
        // Two that follow each other are two.
        let again = Stretch {
            start: 5.0,
            end: 5.1,
            ..chatter
        };
        assert_eq!(events(&impacts, &[chatter, again]).len(), 5);
    }
}
