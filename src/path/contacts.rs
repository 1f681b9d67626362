//! Contacts along a motion that is kept (theory 22), each with what its stop gave and took: impacts, and the stretches along which a
//! stop is pressed or held.

use crate::error::Result;
use crate::impact::Impact;
use crate::law::Regime;
use crate::model::{Constraint, Energetics, Moment, Scene};
use crate::observer::unless_broken_off;
use crate::path::chapter::PathChapter;
use crate::path::equations::PathEquations;
use crate::path::fading::Fading;
use crate::path::parts::AccumulationStart;
use crate::path::quadrature::each_node;
use crate::path::segments::ImpactSide;
use crate::root::golden_section;
use nalgebra::DVector;
use std::ops::Range;

/// One contact of a motion with a stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactRecord {
    /// The stop.
    pub stop: usize,
    /// When it begins \[s\]; where the motion begins, of one that it begins in.
    pub start: f64,
    /// When it ends \[s\]: where it begins, of an impact; NaN if the motion ends in it.
    pub end: f64,
    /// The phase of the forcing where it begins \[rad\].
    pub phase: f64,
    /// Normal speed towards the stop where it begins \[m/s\]; NaN if the motion begins in it.
    pub speed_before: f64,
    /// Normal speed away from the stop where it ends \[m/s\]; NaN if the motion ends in it.
    pub speed_after: f64,
    /// What the stop gave \[N s\].
    pub impulse: f64,
    /// The largest force \[N\]; infinite of an impact.
    pub peak_force: f64,
    /// How far the stop gave way \[m\]; zero of a rigid one.
    pub peak_approach: f64,
    /// The energy that the stop took and did not give back \[J\]; NaN of a system given by functions without its mass where the reaction is not
    /// that of inertia.
    pub loss: f64,
}

impl ContactRecord {
    /// As plain numbers, in the order of its fields.
    pub(crate) fn written(&self) -> [f64; 10] {
        [
            self.stop as f64,
            self.start,
            self.end,
            self.phase,
            self.speed_before,
            self.speed_after,
            self.impulse,
            self.peak_force,
            self.peak_approach,
            self.loss,
        ]
    }

    /// One that was written.
    pub(crate) fn read(
        [
            stop,
            start,
            end,
            phase,
            speed_before,
            speed_after,
            impulse,
            peak_force,
            peak_approach,
            loss,
        ]: [f64; 10],
    ) -> Self {
        Self {
            stop: stop as usize,
            start,
            end,
            phase,
            speed_before,
            speed_after,
            impulse,
            peak_force,
            peak_approach,
            loss,
        }
    }

    /// An impact.
    fn of_impact(impact: &Impact) -> Self {
        let &Impact {
            time,
            stop,
            approach,
            departure,
            impulse,
            phase,
        } = impact;
        Self {
            stop,
            start: time,
            end: time,
            phase,
            speed_before: approach,
            speed_after: departure,
            impulse,
            peak_force: f64::INFINITY,
            peak_approach: 0.0,
            loss: 0.5 * impulse * (approach - departure),
        }
    }

    /// The same with what follows it at once.
    fn then(self, next: &Self) -> Self {
        Self {
            end: next.end,
            speed_after: next.speed_after,
            impulse: self.impulse + next.impulse,
            peak_force: self.peak_force.max(next.peak_force),
            peak_approach: self.peak_approach.max(next.peak_approach),
            loss: self.loss + next.loss,
            ..self
        }
    }
}

/// A contact that takes time.
#[derive(Clone, Copy)]
struct LastingContact {
    record: ContactRecord,
    /// What the stop has stored at both ends \[J\].
    stored: [f64; 2],
}

impl LastingContact {
    /// The same with what follows it at once.
    fn then(self, next: &Self) -> Self {
        Self {
            record: self.record.then(&next.record),
            stored: [self.stored[0], next.stored[1]],
        }
    }

    /// Whether an impact on its stop is a part of it: one while it lasts, or after which the stop holds.
    fn has(&self, impact: &ContactRecord) -> bool {
        let own = &self.record;
        let is_apart = impact.start == own.end && impact.speed_before > 0.0;
        own.start <= impact.start && impact.start <= own.end && !is_apart
    }

    /// Takes an impact that is a part of it.
    fn take(&mut self, impact: &ContactRecord) {
        let own = &mut self.record;
        if impact.start == own.start {
            own.speed_before = impact.speed_before;
        }
        own.impulse += impact.impulse;
        own.peak_force = own.peak_force.max(impact.peak_force);
        own.loss += impact.loss;
    }

    /// The same in a motion over a span, of which it may be the beginning or the end. What a stop has stored before the motion and after it is
    /// not lost; what it has when it is left it does not give back.
    fn within(mut self, (start, end): (f64, f64)) -> Self {
        let own = &mut self.record;
        if own.start == start {
            own.loss += self.stored[0];
            own.speed_before = f64::NAN;
        }
        if own.end == end {
            own.loss -= self.stored[1];
            own.speed_after = f64::NAN;
        }
        self
    }
}

/// The contacts along some chapters of a motion, by their starts, those of one time in the order of their impacts; `phase` is that of the
/// forcing at a time. Of a motion that is closed, one period of an orbit, one that goes on over its end is one contact.
///
/// # Errors
/// What the functions of a nonlinear scene report; `Error::Interrupted` where the caller's work is broken off.
pub(crate) fn contacts_along(
    chapters: &[PathChapter<'_>],
    (span, is_closed): ((f64, f64), bool),
    phase: &dyn Fn(f64) -> f64,
) -> Result<Vec<ContactRecord>> {
    let mut impacts: Vec<ContactRecord> = Vec::new();
    for chapter in chapters {
        impacts.extend(impact_records(chapter)?);
    }
    if chapters.iter().all(|own| own.path.parts.arcs.is_empty()) {
        return Ok(impacts);
    }
    let n_stops = chapters.first().map_or(0, |own| own.scene.stops().len());
    let mut all: Vec<(usize, ContactRecord)> = Vec::new();
    for stop in 0..n_stops {
        let own = impacts.iter().copied().enumerate();
        let mut rest = own.filter(|own| own.1.stop == stop).peekable();
        let mut own_contacts = lasting_contacts(chapters, (stop, is_closed))?;
        let lasts = |own: &LastingContact| (own.record.start, own.record.end) == span;
        let is_open = !is_closed || own_contacts.iter().any(lasts);
        if !is_open {
            join_over_end(&mut own_contacts, span);
        }
        for mut lasting in own_contacts {
            if is_open {
                lasting = lasting.within(span);
            }
            let start = lasting.record.start;
            while let Some(before) = rest.next_if(|next| next.1.start < start) {
                all.push(before);
            }
            let mut place = impacts.len();
            while let Some((k, part)) = rest.next_if(|next| lasting.has(&next.1)) {
                lasting.take(&part);
                place = place.min(k);
            }
            let mut record = ContactRecord {
                phase: phase(start),
                ..lasting.record
            };
            if record.speed_after.is_nan() {
                record.end = f64::NAN;
            }
            all.push((place, record));
        }
        all.extend(rest);
    }
    all.sort_by(|a, b| a.1.start.total_cmp(&b.1.start).then(a.0.cmp(&b.0)));
    Ok(all.into_iter().map(|own| own.1).collect())
}

/// The contacts of a stop that take time, along some chapters.
fn lasting_contacts(
    chapters: &[PathChapter<'_>],
    (stop, is_closed): (usize, bool),
) -> Result<Vec<LastingContact>> {
    let mut all: Vec<LastingContact> = Vec::new();
    for chapter in chapters {
        for own in ContactsAlong::new(chapter, stop, is_closed).all()? {
            match all
                .last_mut()
                .filter(|last| last.record.end == own.record.start)
            {
                Some(last) => *last = last.then(&own),
                None => all.push(own),
            }
        }
    }
    Ok(all)
}

/// Makes one of a contact that lasts to the end of a period and one that lasts from its beginning.
fn join_over_end(contacts: &mut Vec<LastingContact>, (start, end): (f64, f64)) {
    let is_first = |own: &LastingContact| own.record.start == start;
    let is_last = |own: &LastingContact| own.record.end == end;
    if contacts.len() > 1 && contacts.first().is_some_and(is_first) {
        let first = contacts[0];
        if let Some(last) = contacts.last_mut().filter(|own| is_last(own)) {
            *last = last.then(&first);
            last.record.end += end - start;
            contacts.remove(0);
        }
    }
}

/// The impacts of a chapter.
fn impact_records(chapter: &PathChapter<'_>) -> Result<Vec<ContactRecord>> {
    let (equations, path) = (
        PathEquations::new(chapter.path, chapter.scene),
        chapter.path,
    );
    let energetics = energetics_of(&equations, chapter.scene);
    let mut records = Vec::with_capacity(chapter.impacts.len());
    // Of impacts that are kept alone, without what is on their sides, the rest is known.
    let gives_way = |stop: &Constraint| !stop.contact().is_rigid();
    let has_sides = !path.parts.has_gaps || chapter.scene.stops().iter().any(gives_way);
    for impact in chapter.impacts {
        let mut record = ContactRecord::of_impact(impact);
        if !equations.is_of_inertia(impact.stop) && !has_sides {
            record.loss = f64::NAN;
        } else if !equations.is_of_inertia(impact.stop) {
            let at = |side| {
                path.point(impact.time, side)
                    .map(|point| path.locate(point))
            };
            let (before, after) = (at(ImpactSide::Before)?, at(ImpactSide::After)?);
            let (q, v) = &before.state;
            // All impacts of an instant share the mean of the velocities before and after it.
            let mean = (v + &after.state.1) * 0.5;
            let at = equations.moment(after.point.arc, after.point.local);
            let given = (impact.stop, impact.impulse);
            record.loss = taken(&equations, energetics.as_ref(), given, at, (q, &mean))?;
        }
        records.push(record);
    }
    Ok(records)
}

/// What stops take whose reactions are not those of inertia; none of a system given by functions without its mass.
fn energetics_of(equations: &PathEquations<'_>, scene: &Scene) -> Option<Energetics> {
    let mut stops = 0..scene.stops().len();
    let has_others = stops.any(|stop| !equations.is_of_inertia(stop));
    has_others.then(|| Energetics::new(scene).ok()).flatten()
}

/// What a stop takes as [`PathEquations::taken`] says; NaN where the mass is not known.
fn taken(
    equations: &PathEquations<'_>,
    energetics: Option<&Energetics>,
    given: (usize, f64),
    at: Moment,
    motion: (&DVector<f64>, &DVector<f64>),
) -> Result<f64> {
    energetics.map_or(Ok(f64::NAN), |own| equations.taken(own, given, at, motion))
}

/// The contacts of a stop along a chapter that take time.
struct ContactsAlong<'a> {
    chapter: &'a PathChapter<'a>,
    equations: PathEquations<'a>,
    fading: Fading<'a>,
    energetics: Option<Energetics>,
    stop: usize,
    /// Whether the last arc but the one that closes a period comes before the first.
    is_closed: bool,
}

/// What a stop does at a place on an arc.
#[derive(Clone, Copy)]
struct Push {
    force: f64,
    approach: f64,
    speed: f64,
    /// What it takes \[W\].
    power: f64,
}

impl<'a> ContactsAlong<'a> {
    fn new(chapter: &'a PathChapter<'a>, stop: usize, is_closed: bool) -> Self {
        let equations = PathEquations::new(chapter.path, chapter.scene);
        Self {
            chapter,
            energetics: energetics_of(&equations, chapter.scene),
            equations,
            fading: Fading::new(&chapter.path.evaluator),
            stop,
            is_closed,
        }
    }

    /// Whether the stop is in contact in a regime.
    fn is_met(&self, regime: &Regime) -> bool {
        regime.state(self.stop).is_met()
    }

    /// All of them, one for each part of the motion.
    fn all(&self) -> Result<Vec<LastingContact>> {
        let path = self.chapter.path;
        let mut all = Vec::new();
        for stretch in path.stretches() {
            if !self.is_met(stretch.regime) {
                continue;
            }
            let arcs = path.parts.arcs_of(stretch.segment);
            let mut whole: Option<LastingContact> = None;
            for arc in arcs.clone() {
                let next = self.along(arc, stretch.regime)?;
                whole = Some(whole.map_or(next, |own| own.then(&next)));
            }
            let Some(mut whole) = whole else {
                continue;
            };
            let own = &mut whole.record;
            (own.start, own.end) = (stretch.start, stretch.end);
            self.complete_ends(own, arcs)?;
            if stretch.regime.holds(self.stop) {
                self.complete_held(own, stretch.accumulation());
            }
            all.push(whole);
        }
        Ok(all)
    }

    /// The stop along an arc.
    fn along(&self, arc: usize, regime: &Regime) -> Result<LastingContact> {
        let kept = self.chapter.path.arc(arc);
        let push = |local: f64| self.push(arc, regime, local);
        let ends = [push(0.0)?, push(kept.span)?];
        let mut nodes = vec![(0.0, ends[0])];
        let (mut impulse, mut work) = (0.0, 0.0);
        each_node(self.fading.of(regime), (0.0, kept.span), |node| {
            unless_broken_off()?;
            let own = push(node.at)?;
            impulse += node.weight * own.force;
            work += node.weight * own.power;
            nodes.push((node.at, own));
            Ok(())
        })?;
        nodes.push((kept.span, ends[1]));
        let force = |own: &Push| own.force;
        let approach = |own: &Push| own.approach;
        let stored = ends.map(|own| self.stored(regime, own.approach));
        let record = ContactRecord {
            stop: self.stop,
            start: kept.clock.time(),
            end: kept.clock.after(kept.span).time(),
            phase: 0.0,
            speed_before: ends[0].speed,
            speed_after: -ends[1].speed,
            impulse,
            peak_force: largest(&nodes, force, push)?,
            peak_approach: largest(&nodes, approach, push)?.max(0.0),
            loss: work,
        };
        Ok(LastingContact { record, stored })
    }

    /// The speeds before and after some arcs, where the impacts of other stops may change them.
    fn complete_ends(&self, own: &mut ContactRecord, arcs: Range<usize>) -> Result<()> {
        let path = self.chapter.path;
        let last = path.parts.arcs.len().checked_sub(2);
        let before = arcs
            .start
            .checked_sub(1)
            .filter(|_| path.parts.follows(arcs.start));
        if let Some(before) = before.or(last.filter(|_| self.is_closed)) {
            let (regime, span) = (path.regime_of(before), path.arc(before).span);
            own.speed_before = self.push(before, regime, span)?.speed;
        }
        if path.parts.follows(arcs.end) {
            own.speed_after = -self.push(arcs.end, path.regime_of(arcs.end), 0.0)?.speed;
        }
        Ok(())
    }

    /// Of a stop that is held: impacts that accumulate push without bounds, and nothing gives way. Without an impact it is neither met nor left
    /// with a speed.
    fn complete_held(&self, own: &mut ContactRecord, accumulation: Option<usize>) {
        own.peak_approach = 0.0;
        let impacts = self.chapter.impacts;
        let is_hit = |time: f64| {
            let first = impacts.partition_point(|impact| impact.time < time);
            impacts.get(first).is_some_and(|impact| impact.time == time)
        };
        if accumulation == Some(self.stop) {
            // Low bounces on a seat push no harder than its preload.
            if self.equations.contacts()[self.stop].law.is_rigid() {
                own.peak_force = f64::INFINITY;
            }
            let began = |all: &&AccumulationStart| all.0 == own.start && all.1 == self.stop;
            if let Some(known) = self.chapter.accumulations.iter().find(began) {
                own.speed_before = known.2;
            }
        } else if !is_hit(own.start) {
            own.speed_before = 0.0;
        }
        if !is_hit(own.end) {
            own.speed_after = 0.0;
        }
    }

    /// What the stop does at a place on an arc.
    fn push(&self, arc: usize, regime: &Regime, local: f64) -> Result<Push> {
        let (q, v) = self.chapter.path.state_in(arc, local);
        let at = self.equations.moment(arc, local);
        let contact = &self.equations.contacts()[self.stop];
        let (x, y) = (q.as_slice(), v.as_slice());
        let gap = contact.along(|| at, (x, y, y), 0.0)?;
        let law = contact.law.by_state();
        let force = if let Some(own) = law.force_in(regime.state(self.stop), gap.gap, gap.speed) {
            own
        } else {
            let (_, forces) = self.equations.regime_acceleration(regime, at, &q, &v)?;
            let own = forces.iter().find(|own| own.0 == self.stop);
            law.allowed(own.map_or(0.0, |own| own.1))
        };
        let power = if self.equations.is_of_inertia(self.stop) {
            -force * gap.speed
        } else {
            let (given, energetics) = ((self.stop, force), self.energetics.as_ref());
            taken(&self.equations, energetics, given, at, (&q, &v))?
        };
        Ok(Push {
            force,
            approach: -gap.gap,
            speed: -gap.speed,
            power,
        })
    }

    /// The energy that the stop stores in a regime at an approach.
    fn stored(&self, regime: &Regime, approach: f64) -> f64 {
        self.equations
            .stored_in(self.stop, regime.state(self.stop), -approach)
    }
}

/// The largest value along an arc, of one that has a single top between neighbours of some nodes: each top that may be the largest is sought
/// by the golden section.
fn largest(
    nodes: &[(f64, Push)],
    of: impl Fn(&Push) -> f64,
    at: impl Fn(f64) -> Result<Push>,
) -> Result<f64> {
    let value = |k: usize| of(&nodes[k].1);
    let last = nodes.len() - 1;
    let mut most = (0..=last).map(value).fold(f64::NEG_INFINITY, f64::max);
    for k in 0..=last {
        let beside = [k.saturating_sub(1), (k + 1).min(last)];
        let rises = beside.map(|other| value(k) - value(other));
        let is_top = rises.iter().all(|rise| *rise >= 0.0);
        if is_top && value(k) + rises[0].max(rises[1]) > most {
            let between = beside.map(|other| nodes[other].0);
            let place = golden_section(between, |x| at(x).map(|own| -of(&own)))?;
            most = most.max(of(&at(place)?));
        }
    }
    Ok(most)
}
