//! What the search of flight times has proved (theory 5), in words.

use crate::error::digits;
use crate::orbit::two_instants::isolate::Enclosure;
use crate::tolerance::UNDECIDED_PART;

/// The outcome of a search: its solutions, and what is known of all other times.
pub(crate) struct Certificate {
    /// What was searched for.
    pub time: &'static str,
    pub solutions: usize,
    /// Roots that leave contacts of further stops unmet.
    pub apart: usize,
    /// Whether a shorter orbit was left out.
    pub repeats: bool,
    /// Stretches that bounds did not decide.
    pub open: Vec<Enclosure>,
    /// Brackets without a root.
    pub lost: usize,
    pub cells: usize,
    /// Length of the range searched.
    pub length: f64,
    /// Whether that is half the period, the other half being its mirror image.
    pub is_half: bool,
}

impl Certificate {
    /// The outcome in words.
    pub fn describe(&self) -> String {
        let range = if self.is_half { "(0, T/2]" } else { "(0, T)" };
        let solutions = match self.solutions {
            0 => "no solution".to_owned(),
            1 => "one solution".to_owned(),
            n => format!("{n} solutions"),
        };
        let width: f64 = self.open.iter().map(|b| b.high - b.low).sum();
        if width > UNDECIDED_PART * self.length {
            let share = 100.0 * width / self.length;
            return format!(
                "{solutions}; {share:.0} % of the {}s in {range} are undecided: the conditions hold there to rounding",
                self.time
            );
        }
        let cells = self.cells;
        let mut parts = vec![
            solutions,
            format!(
                "every other {} in {range} is excluded by bounds on {cells} cells",
                self.time
            ),
        ];
        if !self.open.is_empty() {
            let places: Vec<String> = self
                .open
                .iter()
                .map(|b| format!("{:.9}", b.guess))
                .collect();
            parts.push(format!(
                "but for a width of {} about dt = {}, a double zero, decided by Newton's method",
                digits(width),
                places.join(", ")
            ));
        }
        if self.repeats {
            parts.push("orbits of half the period, gone through twice, are not counted".to_owned());
        }
        if self.apart > 0 {
            parts.push(format!(
                "{} more meet one contact of each instant, but not those of all stops",
                self.apart
            ));
        }
        if self.lost > 0 {
            parts.push(format!(
                "{} more are bracketed, but could not be refined",
                self.lost
            ));
        }
        parts.join("; ")
    }
}
