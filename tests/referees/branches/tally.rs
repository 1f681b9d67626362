//! What was compared and what was left out, by kind.

use std::collections::BTreeMap;

/// Of each kind how often it was compared, and the worst that was seen.
#[derive(Debug, Default)]
pub struct Tally {
    seen: BTreeMap<&'static str, (usize, f64)>,
    left_out: BTreeMap<&'static str, usize>,
    notes: Vec<String>,
}

impl Tally {
    pub fn saw(&mut self, what: &'static str, off: f64) {
        let own = self.seen.entry(what).or_default();
        *own = (own.0 + 1, own.1.max(off));
    }

    pub fn count(&mut self, what: &'static str, number: usize) {
        self.seen.entry(what).or_default().0 += number;
    }

    pub fn left_out(&mut self, why: &'static str) {
        *self.left_out.entry(why).or_default() += 1;
    }

    pub fn note(&mut self, what: String) {
        self.notes.push(what);
    }

    /// How often something was compared.
    pub fn number(&self, what: &str) -> usize {
        self.seen.get(what).map_or(0, |own| own.0)
    }

    pub fn print(&self, of: &str) {
        for (what, (count, worst)) in &self.seen {
            println!("{of}: {count} {what}, off by {worst:.1e} at the most");
        }
        for (why, count) in &self.left_out {
            println!("{of}: {count} left out: {why}");
        }
        for note in &self.notes {
            println!("{of}: {note}");
        }
    }
}
