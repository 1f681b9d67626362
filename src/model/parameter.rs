//! The numbers of a scene by name: the value, the domain and the unit of each, for all that replaces, sweeps, ramps, follows or derives by
//! them. A number that stops have is one of [`StopNumber`], here alone.

use crate::error::{Error, Result};
use crate::law::LawNumber;
use crate::model::constraint::Constraint;
use crate::quantity::{Restitution, finite, not_negative, positive};

/// A number that stops have, each of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum StopNumber {
    /// The gap at q = 0 \[m\].
    Clearance,
    /// The restitution coefficient \[-\] of a rigid stop.
    Restitution,
    /// The stiffness \[N/m\] of a stop that gives way.
    ContactStiffness,
    /// Its damping \[N s/m\].
    ContactDamping,
    /// Its preload \[N\].
    Preload,
    /// Its exponent \[-\].
    ContactExponent,
}

/// A number of a scene that sweeps and searches may vary, by the name it has in `Scene::replace`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    /// The forcing frequency.
    Frequency,
    /// The phase of the first periodic part of the forcing; the others go with it in time.
    Phase,
    /// A factor on the forcing amplitude.
    ForcingScale,
    /// A factor on the damping matrix.
    DampingScale,
    /// A number of every stop.
    EveryStop(StopNumber),
    /// A number of one stop.
    OneStop(StopNumber, usize),
}

/// What a number is measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unit {
    /// Of the motion.
    Length,
    /// Of the time in which the forcing turns.
    Frequency,
    /// A number that is of the order of one.
    One,
    /// A number of another kind: its own size is all that is known of it.
    Own,
}

impl StopNumber {
    const ALL: [Self; 6] = [
        Self::Clearance,
        Self::Restitution,
        Self::ContactStiffness,
        Self::ContactDamping,
        Self::Preload,
        Self::ContactExponent,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clearance => "clearance",
            Self::Restitution => "restitution",
            Self::ContactStiffness => "contact_stiffness",
            Self::ContactDamping => "contact_damping",
            Self::Preload => "preload",
            Self::ContactExponent => "contact_exponent",
        }
    }

    /// Whether it is one of stops that give way alone.
    pub(crate) fn is_of_compliance(self) -> bool {
        !matches!(self, Self::Clearance | Self::Restitution)
    }

    /// The number of the law of a stop that it is, if it is one.
    fn of_law(self) -> Option<LawNumber> {
        Some(match self {
            Self::Clearance => return None,
            Self::Restitution => LawNumber::Restitution,
            Self::ContactStiffness => LawNumber::Stiffness,
            Self::ContactDamping => LawNumber::Damping,
            Self::Preload => LawNumber::Preload,
            Self::ContactExponent => LawNumber::Exponent,
        })
    }

    fn unit(self) -> Unit {
        match self {
            Self::Clearance => Unit::Length,
            Self::Restitution | Self::ContactExponent => Unit::One,
            Self::ContactStiffness | Self::ContactDamping | Self::Preload => Unit::Own,
        }
    }

    fn check(self, value: f64) -> Result<()> {
        match self {
            Self::Clearance => finite(self.name(), value).map(drop),
            Self::Restitution => Restitution::new(value).map(drop),
            Self::ContactStiffness | Self::ContactExponent => {
                positive(self.name(), value).map(drop)
            }
            Self::ContactDamping | Self::Preload => not_negative(self.name(), value).map(drop),
        }
    }

    /// The value that a stop has, NaN of a number that it has not.
    pub(super) fn of(self, stop: &Constraint) -> f64 {
        match self.of_law() {
            None => stop.clearance(),
            Some(number) => stop.contact().number(number).unwrap_or(f64::NAN),
        }
    }

    /// Whether a stop is meant where the number is one of every stop: those whose law has it.
    pub(super) fn is_of(self, stop: &Constraint) -> bool {
        let number = self.of_law();
        number.is_none_or(|number| stop.contact().number(number).is_some())
    }

    /// Gives a stop another value.
    ///
    /// # Errors
    /// A value beyond the domain, a stop that has no such number.
    pub(crate) fn set(self, stop: &mut Constraint, value: f64) -> Result<()> {
        match (self.of_law(), stop) {
            (None, Constraint::Stop(stop)) => stop.set_clearance(value),
            (None, stop) => {
                let instead = match stop {
                    Constraint::Wall(_) => "a wall has a position",
                    _ => "a nonlinear stop has a gap function",
                };
                let rule = format!("{instead} instead; replace the stops");
                Err(Error::bad_value(self.name(), value, rule))
            }
            (Some(number), stop) => {
                if !self.is_of(stop) {
                    let law = stop.contact().name();
                    let rule = format!("a stop with the law {law} has none; replace the stops");
                    return Err(Error::bad_value(self.name(), value, rule));
                }
                self.check(value)?;
                let law = stop.contact().with(number, value)?;
                *stop.law_mut() = law;
                Ok(())
            }
        }
    }
}

impl Parameter {
    /// The clearance of every stop.
    pub const CLEARANCE: Self = Self::EveryStop(StopNumber::Clearance);
    /// The restitution of every stop.
    pub const RESTITUTION: Self = Self::EveryStop(StopNumber::Restitution);

    /// Those that are not of stops, by name.
    const OF_SCENES: [(Self, &str); 4] = [
        (Self::Frequency, "frequency"),
        (Self::Phase, "phase"),
        (Self::ForcingScale, "forcing_scale"),
        (Self::DampingScale, "damping_scale"),
    ];

    /// The number of one stop alone, where it is one of every stop.
    #[must_use]
    pub fn of(self, stop: usize) -> Self {
        match self.stop_number() {
            Some(number) => Self::OneStop(number, stop),
            None => self,
        }
    }

    /// The number of stops that it is, of all or of one.
    pub(crate) fn stop_number(self) -> Option<StopNumber> {
        match self {
            Self::EveryStop(number) | Self::OneStop(number, _) => Some(number),
            _ => None,
        }
    }

    /// Whether two are about one number of some stop, or of the scene.
    pub(crate) fn overlaps(self, other: Self) -> bool {
        match (self, other) {
            (Self::OneStop(..), Self::OneStop(..)) => self == other,
            _ => self.of(0) == other.of(0),
        }
    }

    /// Whether it counts from the scene: one is the scene as it is.
    pub(crate) fn is_factor(self) -> bool {
        matches!(self, Self::ForcingScale | Self::DampingScale)
    }

    pub(crate) fn unit(self) -> Unit {
        match (self, self.stop_number()) {
            (Self::Frequency, _) => Unit::Frequency,
            (_, Some(number)) => number.unit(),
            _ => Unit::One,
        }
    }

    /// Whether a value is one that the parameter may take, in any scene.
    ///
    /// # Errors
    /// `Error::BadValue`, as [`crate::Scene::replace`] would give it.
    pub(crate) fn check(self, value: f64) -> Result<()> {
        match (self, self.stop_number()) {
            (_, Some(number)) => number.check(value),
            (Self::Frequency, _) => positive("frequency", value).map(drop),
            _ => finite(&self.to_string(), value).map(drop),
        }
    }
}

impl std::fmt::Display for Parameter {
    /// The name that [`Parameter`] is parsed from.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::EveryStop(number) => f.write_str(number.name()),
            Self::OneStop(number, i) => write!(f, "{}[{i}]", number.name()),
            _ => {
                let mut all = Self::OF_SCENES.iter();
                f.write_str(
                    all.find(|(own, _)| own == self)
                        .map_or("", |(_, name)| name),
                )
            }
        }
    }
}

impl std::str::FromStr for Parameter {
    type Err = Error;

    /// `"frequency"`, `"clearance"`, `"clearance[1]"` and so on.
    fn from_str(name: &str) -> Result<Self> {
        let (head, index) = match name.strip_suffix(']').and_then(|s| s.split_once('[')) {
            Some((head, index)) => (head, Some(index.trim().parse().ok())),
            None => (name, None),
        };
        let of_stops = StopNumber::ALL.into_iter().find(|own| own.name() == head);
        let of_scene = Self::OF_SCENES.iter().find(|(_, own)| *own == head);
        match (of_stops, of_scene, index) {
            (Some(number), _, None) => Ok(Self::EveryStop(number)),
            (Some(number), _, Some(Some(i))) => Ok(Self::OneStop(number, i)),
            (None, Some((own, _)), None) => Ok(*own),
            _ => {
                let scene = Self::OF_SCENES.map(|(_, name)| name).join(", ");
                let stops = StopNumber::ALL.map(StopNumber::name);
                let (all, each) = (stops.join(", "), stops.map(|name| format!("{name}[i]")));
                let rule = format!(
                    "it must be one of {scene}, {all}, or {} for one stop",
                    each.join(", ")
                );
                Err(Error::bad_value("the parameter", format!("{name:?}"), rule))
            }
        }
    }
}
