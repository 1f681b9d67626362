//! The arcs of a motion, one after the other; of a loop of shooting with the impacts that accumulate one by one.

use crate::error::Result;
use crate::hybrid::chatter_map::{Bounce, Chatter};
use crate::hybrid::{HybridMaps, SegmentKind, project_onto};
use crate::itinerary::instant::Instant;
use crate::law::{Regime, Stage, Transition};
use nalgebra::DVector;

/// One arc, with its states after the instant at its start and before the one at its end: `(q, v)`, or modal pairs.
#[derive(Debug, Clone)]
pub(crate) struct MotionArc<S> {
    /// What happens at its start, and the regime along it; of the rest of impacts that accumulate the one in which they go on.
    pub stage: Stage,
    /// Its start, its end and its duration \[s\], each to its own digits.
    pub start: f64,
    pub end: f64,
    pub span: f64,
    /// The state at its start, after the instant there.
    pub after: S,
    /// The state at its end, before the instant there.
    pub before_next: S,
}

impl<S> MotionArc<S> {
    /// An arc over a span from a start.
    pub fn over(stage: Stage, [start, span]: [f64; 2], [after, before_next]: [S; 2]) -> Self {
        Self {
            stage,
            start,
            end: start + span,
            span,
            after,
            before_next,
        }
    }

    /// An arc from a start to an end.
    pub fn between(stage: Stage, (start, end): (f64, f64), states: [S; 2]) -> Self {
        let arc = Self::over(stage, [start, end - start], states);
        Self { end, ..arc }
    }

    /// The same, its states in another form.
    pub fn map<T>(self, form: impl Fn(&S) -> T) -> MotionArc<T> {
        MotionArc {
            after: form(&self.after),
            before_next: form(&self.before_next),
            stage: self.stage,
            start: self.start,
            end: self.end,
            span: self.span,
        }
    }

    /// The regime of the motion along it.
    pub fn regime(&self) -> &Regime {
        &self.stage.regime
    }

    /// The stops that are hit at its start.
    pub fn hits(&self) -> &[usize] {
        self.stage.transition.struck()
    }

    /// The element that is left at its start without an impact.
    pub fn departure(&self) -> Option<usize> {
        self.stage.transition.departure()
    }

    /// The element whose impacts accumulate along it: what is left of them is one arc.
    pub fn accumulation(&self) -> Option<usize> {
        let accumulation = self.stage.transition.accumulation();
        accumulation.filter(|&stop| !self.regime().holds(stop))
    }

    /// Whether it is free motion.
    pub fn is_flight(&self) -> bool {
        self.regime().is_free() && self.accumulation().is_none()
    }

    /// Whether the gap of an element is kept at zero along it, or accumulates impacts.
    pub fn keeps_closed(&self, element: usize) -> bool {
        self.accumulation() == Some(element) || self.regime().holds(element)
    }

    /// Whether an element is in contact along it, or accumulates impacts.
    pub fn touches(&self, element: usize) -> bool {
        self.accumulation() == Some(element) || !self.regime().leaves_free(element)
    }

    /// The kind of motion, and the regime in which it is drawn: of impacts that accumulate the one that they lead to.
    pub fn drawn(&self) -> (SegmentKind, Regime) {
        match self.accumulation() {
            Some(stop) => (SegmentKind::Chatter, Regime::holding([stop])),
            None => (SegmentKind::of(self.regime()), self.regime().clone()),
        }
    }
}

/// The stops that are hit at each of the instants at which some are.
pub(crate) fn hits<S>(arcs: &[MotionArc<S>]) -> impl Iterator<Item = &[usize]> {
    let all = arcs.iter().map(MotionArc::hits);
    all.filter(|hits| !hits.is_empty())
}

/// The elements with which contacts begin at each of the instants at which some do.
pub(crate) fn contacts_begun<S>(arcs: &[MotionArc<S>]) -> impl Iterator<Item = Vec<usize>> {
    let all = arcs.iter().map(|arc| arc.stage.transition.begun());
    all.filter(|begun| !begun.is_empty())
}

/// Those of them whose gaps close there, of the arcs of a period.
pub(crate) fn closing<S>(arcs: &[MotionArc<S>]) -> Vec<Vec<usize>> {
    let before = arcs.iter().cycle().skip(arcs.len() - 1);
    let hit = arcs
        .iter()
        .zip(before)
        .filter(|own| !own.0.hits().is_empty());
    let each = hit.map(|(own, before)| own.stage.transition.closing(before.regime()).collect());
    each.collect()
}

/// The end of an arc: the state and what happens to it there.
#[derive(Debug, Clone)]
pub(crate) struct ArcEnd {
    /// The state (q, v) before the instant, shape (2n,), [m, m/s].
    pub before: DVector<f64>,
    /// The impulses of the stops struck together there, shape (stops struck,), [N s].
    pub impulses: Vec<f64>,
    /// The impacts that accumulate from there.
    pub chatter: Option<Chatter>,
}

/// The arcs between impacts that accumulate on a stop.
pub(crate) fn bounces(
    stop: usize,
    chatter: &Chatter,
) -> impl Iterator<Item = MotionArc<DVector<f64>>> + '_ {
    let later = chatter.bounces.iter().skip(1);
    let ends = later.map(|next| (next.time, &next.before));
    let ends = ends.chain([(chatter.last_time, &chatter.last)]);
    let arc = move |(bounce, (end, before)): (&Bounce, (f64, &DVector<f64>))| {
        let states = [bounce.after.clone(), before.clone()];
        MotionArc::between(Stage::impact(&[stop]), (bounce.time, end), states)
    };
    chatter.bounces.iter().zip(ends).map(arc)
}

/// The arcs of a period, given its instants, its end and the ends of its arcs. They change smoothly with them; the completion of accumulating
/// impacts may end a little before it begins.
pub(crate) fn arcs_of<M: HybridMaps + ?Sized>(
    instants: &[Instant],
    end: f64,
    ends: &[ArcEnd],
    motion: &M,
) -> Result<Vec<MotionArc<DVector<f64>>>> {
    let mut arcs = Vec::with_capacity(instants.len());
    let count = instants.len();
    for (k, instant) in instants.iter().enumerate() {
        let Instant { start, state, .. } = instant;
        let mut stage = instant.stage.clone();
        if let Transition::Chatter(stop) = stage.transition {
            let chatter = ends[(k + count - 1) % count].chatter.as_ref();
            let chatter = chatter.expect("completed at every instant where impacts accumulate");
            arcs.extend(bounces(stop, chatter));
            // The rest is over in no time: it begins without normal speed.
            let mut rest = chatter.last.clone();
            project_onto(
                motion,
                &Regime::holding([stop]),
                chatter.last_time,
                &mut rest,
            )?;
            let left = Stage::free(Transition::Chatter(stop));
            let span = (chatter.last_time, *start);
            arcs.push(MotionArc::between(left, span, [rest, state.clone()]));
            stage.transition = Transition::Nothing;
        }
        let mut after = state.clone();
        project_onto(motion, &stage.regime, *start, &mut after)?;
        let end = instants.get(k + 1).map_or(end, |next| next.time);
        let (span, states) = ((*start, end.max(*start)), [after, ends[k].before.clone()]);
        arcs.push(MotionArc::between(stage, span, states));
    }
    Ok(arcs)
}
