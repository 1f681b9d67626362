//! The two-instant conditions in the forms that the search needs (theory 5), in units in which they are of order one:
//! with the clearances or the phase given, and with the zeros that are known beforehand divided out: where the instants
//! meet (dt = 0, T), and where like or mirrored instants are half the period apart.

use crate::modal::Pair;
use crate::orbit::conditions::{Conditions, point};
use crate::orbit::green::{Cell, turned};
use crate::orbit::series::{Entry, Series};

/// Entries that vanish by symmetry are below this, relative to their terms.
const SPLIT: f64 = 1e-13;

impl Conditions<'_> {
    /// The factor by which the contact row of the first stop of the second instant repeats that of the first instant
    /// when the instants meet: both stops are one surface.
    pub fn same_surface(&self) -> Option<f64> {
        let g = &self.scene().geometry;
        let (a, b) = (self.instant.stops[0], self.instant.stops[self.first]);
        let (n, m) = (g.normals.column(a), g.normals.column(b));
        let factor = n.dot(&m) / n.norm_squared();
        let is_parallel = (m - n * factor).amax() <= 4.0 * f64::EPSILON * m.amax();
        let offset = g.clearances[b] - factor * g.clearances[a];
        (is_parallel && offset.abs() <= 4.0 * f64::EPSILON * g.clearances[b].abs())
            .then_some(factor)
    }

    /// The two contact rows that a search solves: the first stop of either instant.
    fn leading_contacts(&self) -> [usize; 2] {
        [self.n_inner(), self.n_inner() + self.first]
    }

    /// The scaled equations for impulses, states and phase with the clearances given: all rows but the contacts, and the
    /// leading contacts. With `factor` the second of these is the difference to `factor` times the first, over x.
    pub fn circle_rows(&self, entries: &[Entry], factor: Option<f64>) -> Vec<Series> {
        let (inner, width) = (self.n_inner(), self.constant.ncols());
        let [first, second] = self.leading_contacts();
        let mut rows = Vec::with_capacity((inner + 2) * width);
        for row in (0..=inner).chain([second]) {
            for c in 0..width {
                let entry = &entries[row * width + c];
                let unit = self.units.rows[row] * self.units.columns[c];
                rows.push(match factor.filter(|_| row == second) {
                    Some(factor) => {
                        let mut difference = *entry;
                        difference.add(-factor, &entries[first * width + c]);
                        difference.over_x(unit)
                    }
                    None => entry.series(unit),
                });
            }
        }
        rows
    }

    /// The equations over a cell with the phase counted from the middle of the flight, in sums and differences over the two
    /// instants, of their rows and of their impulses: rows R+, R-, C+, C-, columns p+, p-, cos, sin, right-hand side.
    fn half_entries(&self, cell: &Cell) -> [[Entry; 5]; 4] {
        let (inner, width) = (self.n_inner(), self.constant.ncols());
        let mut entries = self.entries(cell);
        let rows = [[0, 1], [inner, inner + 1]];
        for (row, side) in rows.iter().flat_map(|pair| pair.iter().zip([-0.5, 0.5])) {
            let steady = [
                self.constant[(*row, inner)],
                self.constant[(*row, inner + 1)],
            ];
            let turned = turned(cell, side * self.scene().frequency, steady);
            entries[row * width + inner..row * width + inner + 2].copy_from_slice(&turned);
        }
        let mut half = [[Entry::default(); 5]; 4];
        for (i, [first, second]) in rows.into_iter().enumerate() {
            for (j, sign) in [1.0, -1.0].into_iter().enumerate() {
                let line: [Entry; 5] = std::array::from_fn(|c| {
                    Entry::combined(
                        [1.0, sign],
                        [&entries[second * width + c], &entries[first * width + c]],
                    )
                });
                let [p, q, rest @ ..] = &line;
                let [sum, difference] = [1.0, -1.0].map(|s| Entry::combined([1.0, s], [p, q]));
                half[2 * i + j] = [sum, difference, rest[0], rest[1], rest[2]];
            }
        }
        half
    }

    /// Whether half the period apart the instants are alike, the same stop or mirror images: the conditions then split
    /// into sums and differences over the instants, and every flight time has a line of solutions there. That line holds
    /// the shorter orbit gone through twice, or the symmetric orbits.
    pub fn splits_at_half(&self) -> bool {
        if self.instant.stops.len() != 2 || self.retained.is_some() {
            return false;
        }
        let half = self.half_entries(&point(
            0.5 * self.instant.period,
            1.0 / self.scene().frequency,
        ));
        [1, 3].iter().all(|&row| {
            [0, 2, 3, 4]
                .iter()
                .all(|&c| half[row][c].c[0].abs() <= SPLIT * half[row][c].size)
        })
    }

    /// The scaled equations over a cell about `dt = T/2` where they split, the double zero there divided out: the rows of
    /// differences over x, the unknown difference of the impulses over x.
    pub fn half_rows(&self, cell: &Cell) -> Vec<Series> {
        let inner = self.n_inner();
        let half = self.half_entries(cell);
        let x = Series::x();
        let mut rows = Vec::with_capacity(20);
        for (i, line) in half.iter().enumerate() {
            let unit = self.units.rows[[0, 0, inner, inner][i]];
            for (c, entry) in line.iter().enumerate() {
                let factor = unit * self.units.columns[[0, 0, inner, inner, inner + 2][c]];
                rows.push(match (i % 2, c) {
                    (0, 1) => {
                        Series::sum_of_products([(1.0, &x, &entry.series(factor))].into_iter())
                    }
                    (0, _) | (_, 1) => entry.series(factor),
                    _ => entry.over_x(factor),
                });
            }
        }
        rows
    }

    /// The scaled equations for impulses and states with the phase given: all rows but the contacts, and "stop number
    /// `contacts.1` of the list is at its second instant where `contacts.0` was at its first"; over x if `deflated`.
    pub fn phase_rows(
        &self,
        entries: &[Entry],
        u: Pair,
        contacts: (usize, usize),
        deflated: bool,
    ) -> Vec<Series> {
        let (inner, width) = (self.n_inner(), self.constant.ncols());
        let mut rows = Vec::with_capacity((inner + 1) * (inner + 1));
        let known = |line: &[Entry]| {
            let mut known = line[inner + 2];
            known.add(-u[0], &line[inner]);
            known.add(-u[1], &line[inner + 1]);
            known
        };
        for row in 0..inner {
            let line = &entries[row * width..(row + 1) * width];
            let unit = self.units.rows[row];
            rows.extend((0..inner).map(|c| line[c].series(unit * self.units.columns[c])));
            rows.push(known(line).series(unit * self.phase_unit()));
        }
        let line = |a: usize| &entries[(inner + a) * width..(inner + a + 1) * width];
        let (before, after) = (line(contacts.0), line(contacts.1));
        for c in 0..=inner {
            let (mut difference, from) = if c < inner {
                (after[c], before[c])
            } else {
                (known(after), known(before))
            };
            difference.add(-1.0, &from);
            let unit = self.units.rows[inner]
                * if c < inner {
                    self.units.columns[c]
                } else {
                    self.phase_unit()
                };
            rows.push(if deflated {
                difference.over_x(unit)
            } else {
                difference.series(unit)
            });
        }
        rows
    }
}
