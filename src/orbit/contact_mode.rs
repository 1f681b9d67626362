//! The contact mode of one flight of an orbit: its regime, and how it begins (theory 9).

use crate::hybrid::SegmentKind;
use crate::law::Regime;

/// A contact mode as plain numbers: the kind of motion, the stops in contact, whether it begins with an instant of the pattern, the stop let
/// go at its start.
pub type SavedMode = (SegmentKind, Vec<usize>, bool, Option<usize>);

/// What one flight of an orbit is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ContactMode {
    /// Free, in lasting contact, or the rest of impacts that accumulate.
    pub kind: SegmentKind,
    /// The regime of the motion along it; of impacts that accumulate the one that they lead to.
    pub regime: Regime,
    /// Whether it begins with the next instant of the pattern.
    pub is_struck: bool,
    /// The stop let go at its start.
    pub released: Option<usize>,
}

impl ContactMode {
    /// A flight in a regime.
    pub fn in_regime(regime: Regime) -> Self {
        Self {
            kind: SegmentKind::of(&regime),
            regime,
            is_struck: false,
            released: None,
        }
    }

    /// Free motion after an instant of the pattern.
    pub fn struck() -> Self {
        Self {
            is_struck: true,
            ..Self::in_regime(Regime::default())
        }
    }

    /// The rest of impacts that accumulate on a stop.
    pub fn rest_on(stop: usize) -> Self {
        Self {
            kind: SegmentKind::Chatter,
            ..Self::in_regime(Regime::holding([stop]))
        }
    }

    /// As plain numbers.
    pub fn saved(&self) -> SavedMode {
        let stops = self.stops().to_vec();
        (self.kind, stops, self.is_struck, self.released)
    }

    /// The mode that was saved.
    pub fn restored((kind, stops, is_struck, released): &SavedMode) -> Self {
        Self {
            kind: *kind,
            regime: Regime::holding(stops.as_slice()),
            is_struck: *is_struck,
            released: *released,
        }
    }

    /// Whether it is the rest of impacts that accumulate.
    pub fn is_chatter(&self) -> bool {
        self.kind == SegmentKind::Chatter
    }

    /// Whether it is free motion.
    pub fn is_flight(&self) -> bool {
        self.kind == SegmentKind::Flight
    }

    /// The stops in contact, in ascending order.
    pub fn stops(&self) -> &[usize] {
        self.regime.constrained()
    }

    /// The regime that lasts along it: the free one where impacts accumulate.
    pub fn lasting(&self) -> &Regime {
        if self.is_chatter() {
            Regime::free()
        } else {
            &self.regime
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
