//! The records of what the rules of contact say of an orbit (theory 6): the worst breach, what is left open, touches. The rules themselves
//! are in `judge.rs`, `integrated.rs`, `lasting.rs`.

use crate::error::digits;
use crate::event::walk::FlightCheck;
use crate::law::GuardKind;

/// Where and by how much an orbit breaks the rules of contact. With a depth that is not a number, where the search could not
/// decide whether it does.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// The stop.
    pub stop: usize,
    /// The time of the deepest point, or of the impact \[s\], counted from the first impact.
    pub time: f64,
    /// How far the stop is passed, in units of the gap; zero where an impulse or a contact force pulls, nan where it is not known.
    pub depth: f64,
    /// The rule that is broken, in words.
    pub reason: String,
}

/// A touch within the margin, without an impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// The stop.
    pub stop: usize,
    /// The time of the lowest point \[s\].
    pub time: f64,
    /// The gap there.
    pub gap: f64,
}

/// The rule of contact that is broken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rule {
    /// The impulse of an impact would have to pull.
    Pulls { impulse: f64 },
    /// The stop is left at an impact, not approached.
    Leaves { approach: f64 },
    /// The stop is neither approached nor left but for rounding: a touch, which is no impact.
    Touches { approach: f64 },
    /// The stop is reached together with others that are hit there, and not hit.
    Reached { approach: f64 },
    /// The stop is passed.
    Passed,
    /// The stop is held by a force that would have to pull.
    Holds { force: f64 },
    /// A stop that gives way would be in another state: what a guard of its state tells is below zero.
    Changes { guard: GuardKind, value: f64 },
}

/// A violation as numbers, put into words only when somebody asks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Breach {
    pub stop: usize,
    pub time: f64,
    pub depth: f64,
    pub rule: Rule,
}

impl Breach {
    /// The violation in words.
    pub fn describe(&self) -> Violation {
        let Self {
            stop,
            time,
            depth,
            rule,
        } = *self;
        let reason = match rule {
            Rule::Pulls { impulse } => {
                format!(
                    "stop {stop} needs a pulling impulse at its impact at t = {time:.6} ({})",
                    digits(impulse)
                )
            }
            Rule::Leaves { approach } => {
                format!(
                    "stop {stop} is left, not approached at its impact at t = {time:.6} ({})",
                    digits(approach)
                )
            }
            Rule::Touches { approach } => {
                format!(
                    "stop {stop} is touched without speed at t = {time:.6} ({}): that is no impact",
                    digits(approach)
                )
            }
            Rule::Reached { approach } => {
                format!(
                    "stop {stop} is reached together with those hit at t = {time:.6}, and would be hit too ({})",
                    digits(approach)
                )
            }
            Rule::Holds { force } => {
                format!(
                    "stop {stop} is held by a pulling force at t = {time:.6} ({})",
                    digits(force)
                )
            }
            Rule::Changes { guard, value } => {
                let what = match guard {
                    GuardKind::Approach => "is left",
                    GuardKind::Pull => "pushes again",
                    GuardKind::Gap | GuardKind::Distance => "is met",
                    _ => "would pull",
                };
                format!("stop {stop} {what} at t = {time:.6} ({})", digits(value))
            }
            Rule::Passed => format!(
                "stop {stop} is passed by {} at t = {time:.6}",
                digits(depth)
            ),
        };
        Violation {
            stop,
            time,
            depth,
            reason,
        }
    }
}

/// A gap, or a contact force, of which the search proved nothing from some time on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Undecided {
    pub stop: usize,
    pub time: f64,
}

impl Undecided {
    /// What is not known, in words; the depth is not a number.
    pub fn describe(&self) -> Violation {
        let Self { stop, time } = *self;
        let reason = format!(
            "the search could not decide whether stop {stop} is passed: from t = {time:.6} on its bounds prove nothing"
        );
        Violation {
            stop,
            time,
            depth: f64::NAN,
            reason,
        }
    }
}

/// What the rules of contact say of an orbit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Ruling {
    Admissible,
    /// Nothing was found, and not everything was proved.
    Undecided,
    /// With the depth of the worst breach.
    Broken(f64),
}

/// What the search of a whole period found.
#[derive(Debug, Clone, Default)]
pub(crate) struct Admissibility {
    /// The worst breach of the rules of contact.
    pub breach: Option<Breach>,
    /// The first place where the search proved nothing more.
    pub undecided: Option<Undecided>,
    pub touches: Vec<Touch>,
    /// An impact whose approach speed is within the margin of zero.
    pub has_grazing_impact: bool,
}

impl Admissibility {
    /// Admissible only where everything was proved.
    pub fn ruling(&self) -> Ruling {
        match (self.breach, self.undecided) {
            (Some(breach), _) => Ruling::Broken(breach.depth),
            (None, Some(_)) => Ruling::Undecided,
            (None, None) => Ruling::Admissible,
        }
    }

    /// The worst breach, or what is not known, in words.
    pub fn describe(&self) -> Option<Violation> {
        let open = self.undecided.map(|open| open.describe());
        let Some(breach) = &self.breach else {
            return open;
        };
        let mut found = breach.describe();
        if let Some(open) = open {
            found.reason.push_str("; it may be worse: ");
            found.reason.push_str(&open.reason);
        }
        Some(found)
    }

    /// Takes note of where a search on a flight proved nothing more.
    pub(in crate::orbit) fn leave_open(&mut self, stop: usize, start: f64, check: &FlightCheck) {
        if let Some(time) = check.undecided {
            self.leave_undecided(stop, start + time);
        }
    }

    /// Takes note of the first time from which on a search proved nothing more.
    pub(in crate::orbit) fn leave_undecided(&mut self, stop: usize, time: f64) {
        self.undecided.get_or_insert(Undecided { stop, time });
    }

    pub(in crate::orbit) fn keep_worst(&mut self, breach: Breach) {
        if self.breach.is_none_or(|worst| breach.depth > worst.depth) {
            self.breach = Some(breach);
        }
    }

    /// Takes note of what the search of one gap found on a flight.
    pub(in crate::orbit) fn note(&mut self, stop: usize, start: f64, check: &FlightCheck) {
        self.note_as(stop, start, check, |_| Rule::Passed);
    }

    /// The same of what is like a gap; `rule` is the one that a value below zero breaks.
    pub(in crate::orbit) fn note_as(
        &mut self,
        stop: usize,
        start: f64,
        check: &FlightCheck,
        rule: impl Fn(f64) -> Rule,
    ) {
        self.leave_open(stop, start, check);
        if let Some(lowest) = check.violation {
            self.keep_worst(Breach {
                stop,
                time: start + lowest.time,
                depth: -lowest.gap,
                rule: rule(lowest.gap),
            });
        }
        if let Some(lowest) = check.graze {
            self.touches.push(Touch {
                stop,
                time: start + lowest.time,
                gap: lowest.gap,
            });
        }
    }
}
