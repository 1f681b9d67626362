//! The parts of a motion that its contacts are read from, of a run that does not keep all of it: those along which a stop is pressed or held,
//! with the arc behind each; in scenes with stops that give way the arc before each, too.

use crate::hybrid::SegmentKind;
use crate::hybrid::recorder::ArcSpan;
use crate::law::Regime;
use crate::path::{AccumulationStart, PathParts};

/// An arc put aside.
struct ArcAside {
    kind: SegmentKind,
    regime: Regime,
    span: ArcSpan,
}

/// What is kept of a run for its contacts.
pub(crate) struct ContactParts {
    parts: PathParts,
    /// Where impacts began to accumulate.
    accumulations: Vec<AccumulationStart>,
    /// The present segment, and whether it is the last one of the parts.
    present: (SegmentKind, Regime),
    is_open: bool,
    /// Whether the next arc is the one behind a contact.
    wants_next: bool,
    /// Whether arcs before contacts are kept: in scenes with stops that give way.
    has_sides: bool,
    before: Option<ArcAside>,
    /// The numbers of that arc, shape `(n_numbers,)`, \[mixed\].
    numbers: Vec<f64>,
}

impl ContactParts {
    /// Nothing yet.
    pub fn new(has_sides: bool) -> Self {
        let parts = PathParts {
            has_gaps: true,
            ..PathParts::default()
        };
        Self {
            parts,
            accumulations: Vec::new(),
            present: (SegmentKind::Flight, Regime::default()),
            is_open: false,
            wants_next: false,
            has_sides,
            before: None,
            numbers: Vec::new(),
        }
    }

    /// Begins a segment; whether it goes on a last one of the same kind and regime.
    pub fn begin(&mut self, kind: SegmentKind, regime: &Regime, goes_on: bool) {
        let is_same = self.present.0 == kind && self.present.1 == *regime;
        if !(goes_on && is_same) {
            self.is_open = false;
            self.present = (kind, regime.clone());
        }
    }

    /// Whether it wants arcs along which no stop is met.
    pub fn wants_free(&self) -> bool {
        self.wants_next || self.has_sides
    }

    /// Whether it wants an arc of the present segment.
    pub fn wants_arc(&self) -> bool {
        self.wants_free() || self.is_met()
    }

    /// Whether a stop is met along the present segment.
    fn is_met(&self) -> bool {
        self.present.1.pushing().next().is_some()
    }

    /// Takes an arc of the present segment.
    pub fn push(&mut self, span: &ArcSpan, write: impl FnOnce(&mut Vec<f64>)) {
        let is_met = self.is_met();
        if is_met || self.wants_next {
            self.keep_before();
            if !self.is_open {
                self.parts.begin(self.present.0, &self.present.1);
            }
            self.parts.push_later(span, write);
            (self.is_open, self.wants_next) = (is_met, is_met);
        } else if self.has_sides {
            let (kind, regime) = self.present.clone();
            let span = *span;
            self.before = Some(ArcAside { kind, regime, span });
            self.numbers.clear();
            write(&mut self.numbers);
        }
    }

    /// An impact, both of whose sides are kept where they count.
    pub fn note_impact(&mut self) {
        if self.has_sides {
            self.keep_before();
            (self.is_open, self.wants_next) = (false, true);
        }
    }

    /// Impacts begin to accumulate.
    pub fn note_accumulation(&mut self, own: AccumulationStart) {
        self.accumulations.push(own);
    }

    /// Keeps the arc that was put aside, the last one.
    fn keep_before(&mut self) {
        if let Some(ArcAside { kind, regime, span }) = self.before.take() {
            self.parts.begin(kind, &regime);
            let numbers = &self.numbers;
            self.parts
                .push_later(&span, |all| all.extend_from_slice(numbers));
        }
    }

    /// What has been kept.
    pub fn finish(self) -> (PathParts, Vec<AccumulationStart>) {
        (self.parts, self.accumulations)
    }
}
