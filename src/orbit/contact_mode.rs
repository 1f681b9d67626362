//! What happens at the instants of an orbit, and what is in contact between them (theory 9).

use crate::hybrid::SegmentKind;

/// What happens at an instant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Event {
    /// Nothing: a period without instants begins here.
    Nothing,
    /// These stops are struck together; a stop held that receives an impulse with them is one of them.
    Strike(Vec<usize>),
    /// The impacts on this stop accumulate, from here to their limit.
    Chatter(usize),
    /// This stop is let go, its contact force at zero.
    Release(usize),
}

/// An instant and the stops held from it to the next one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ContactStage {
    pub event: Event,
    pub held: Vec<usize>,
}

impl ContactStage {
    /// The stops held but one.
    pub fn held_but(&self, stop: usize) -> Vec<usize> {
        self.held
            .iter()
            .copied()
            .filter(|own| *own != stop)
            .collect()
    }

    /// The same with the mirror image of each stop.
    pub fn mirrored(&self, images: &[usize]) -> Self {
        let image = |stop: &usize| images[*stop];
        let event = match &self.event {
            Event::Nothing => Event::Nothing,
            Event::Strike(stops) => Event::Strike(stops.iter().map(image).collect()),
            Event::Chatter(stop) => Event::Chatter(image(stop)),
            Event::Release(stop) => Event::Release(image(stop)),
        };
        let mut held: Vec<usize> = self.held.iter().map(image).collect();
        held.sort_unstable();
        Self { event, held }
    }
}

/// What one flight of an orbit is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ContactMode {
    /// Free, in lasting contact, or the rest of impacts that accumulate.
    pub kind: SegmentKind,
    /// The stops in contact, in ascending order.
    pub stops: Vec<usize>,
    /// Whether it begins with the next instant of the pattern.
    pub is_struck: bool,
    /// The stop let go at its start.
    pub released: Option<usize>,
}

impl ContactMode {
    /// Free motion after an instant of the pattern.
    pub const FREE: Self = Self {
        kind: SegmentKind::Flight,
        stops: Vec::new(),
        is_struck: true,
        released: None,
    };

    /// The stops held along it; none where impacts accumulate.
    pub fn held(&self) -> &[usize] {
        if self.kind == SegmentKind::Stick {
            &self.stops
        } else {
            &[]
        }
    }
}

/// The number of the flight that begins with each instant.
pub(crate) fn struck<'a>(
    modes_of_contact: impl Iterator<Item = &'a ContactMode> + 'a,
) -> impl Iterator<Item = usize> + 'a {
    modes_of_contact
        .enumerate()
        .filter(|(_, mode)| mode.is_struck)
        .map(|(k, _)| k)
}
