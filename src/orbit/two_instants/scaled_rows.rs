//! The two-instant conditions in the forms that the search needs (theory 5), in units in which they are of order one:
//! with the clearances or the phase given, and with the zeros that are known beforehand divided out: where the instants
//! meet (dt = 0, T), and where like or mirrored instants are half the period apart.

use crate::modal::Pair;
use crate::orbit::two_instants::conditions::{TwoInstantConditions, point};
use crate::orbit::two_instants::green::{TimeInterval, turned};
use crate::orbit::two_instants::isolate::IntervalEnd;
use crate::orbit::two_instants::taylor_model::{TaylorModel, UnscaledModel};
use crate::tolerance::SPLIT_ROWS;

impl TwoInstantConditions<'_> {
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

    /// The restitution row, and its factor, of the impact before the short flight where the instants meet on one surface,
    /// if that impact leaves no speed (`e = 0`): the contacts then differ by that row times the flight time, to first order.
    fn dead_stop(
        &self,
        places: (usize, usize),
        end: IntervalEnd,
        factor: f64,
    ) -> Option<(usize, f64)> {
        let (place, factor) = if end == IntervalEnd::Low {
            (places.0, factor)
        } else {
            (places.1, 1.0)
        };
        let law = self.scene().geometry.law(self.instant.stops[place]);
        (law.restitution < f64::MIN_POSITIVE).then_some((place, factor))
    }

    /// The scaled equations for impulses, states and phase with the clearances given: all rows but the contacts, and the
    /// leading contacts. At an `end` at which these meet, on one surface, the second is what is left of their difference
    /// with its known zero divided out.
    pub fn circle_rows(
        &self,
        entries: &[UnscaledModel],
        cell: &TimeInterval,
        end: IntervalEnd,
    ) -> Vec<TaylorModel> {
        let (inner, width) = (self.n_inner(), self.constant.ncols());
        let [first, second] = self.leading_contacts();
        let meeting = if end == IntervalEnd::Neither {
            None
        } else {
            self.same_surface()
        };
        let dead = meeting.and_then(|factor| self.dead_stop((0, self.first), end, factor));
        let mut rows = Vec::with_capacity((inner + 2) * width);
        for row in (0..=inner).chain([second]) {
            for c in 0..width {
                let entry = &entries[row * width + c];
                let unit = self.units.rows[row] * self.units.columns[c];
                rows.push(match meeting.filter(|_| row == second) {
                    Some(factor) => {
                        let before = &entries[first * width + c];
                        let difference = UnscaledModel::combined([1.0, -factor], [entry, before]);
                        let dead = dead.map(|(place, factor)| (entries[place * width + c], factor));
                        met(difference, dead, cell, unit)
                    }
                    None => entry.series(unit),
                });
            }
        }
        rows
    }

    /// The equations over a cell with the phase counted from the middle of the flight, in sums and differences over the two
    /// instants, of their rows and of their impulses: rows R+, R-, C+, C-, columns p+, p-, cos, sin, right-hand side.
    fn half_entries(&self, cell: &TimeInterval) -> [[UnscaledModel; 5]; 4] {
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
        let mut half = [[UnscaledModel::default(); 5]; 4];
        for (i, [first, second]) in rows.into_iter().enumerate() {
            for (j, sign) in [1.0, -1.0].into_iter().enumerate() {
                let line: [UnscaledModel; 5] = std::array::from_fn(|c| {
                    UnscaledModel::combined(
                        [1.0, sign],
                        [&entries[second * width + c], &entries[first * width + c]],
                    )
                });
                let [p, q, rest @ ..] = &line;
                let [sum, difference] =
                    [1.0, -1.0].map(|s| UnscaledModel::combined([1.0, s], [p, q]));
                half[2 * i + j] = [sum, difference, rest[0], rest[1], rest[2]];
            }
        }
        half
    }

    /// Whether half the period apart the instants are alike, the same stop or mirror images: the conditions then split
    /// into sums and differences over the instants, and every flight time has a line of solutions there. That line holds
    /// the shorter orbit gone through twice, or the symmetric orbits.
    pub fn splits_at_half(&self) -> bool {
        if self.instant.stops.len() != 2 || self.resonant.is_some() {
            return false;
        }
        let half = self.half_entries(&point(
            0.5 * self.instant.period,
            1.0 / self.scene().frequency,
        ));
        [1, 3].iter().all(|&row| {
            [0, 2, 3, 4]
                .iter()
                .all(|&c| half[row][c].c[0].abs() <= SPLIT_ROWS * half[row][c].size)
        })
    }

    /// The scaled equations over a cell about `dt = T/2` where they split, the double zero there divided out: the rows of
    /// differences over x, the unknown difference of the impulses over x.
    pub fn half_rows(&self, cell: &TimeInterval) -> Vec<TaylorModel> {
        let inner = self.n_inner();
        let half = self.half_entries(cell);
        let x = TaylorModel::x();
        let mut rows = Vec::with_capacity(20);
        for (i, line) in half.iter().enumerate() {
            let unit = self.units.rows[[0, 0, inner, inner][i]];
            for (c, entry) in line.iter().enumerate() {
                let factor = unit * self.units.columns[[0, 0, inner, inner, inner + 2][c]];
                rows.push(match (i % 2, c) {
                    (0, 1) => {
                        TaylorModel::sum_of_products([(1.0, &x, &entry.series(factor))].into_iter())
                    }
                    (0, _) | (_, 1) => entry.series(factor),
                    _ => entry.over_x(1, factor),
                });
            }
        }
        rows
    }

    /// The scaled equations for impulses and states with the phase given: all rows but the contacts, and "stop number
    /// `places.1` of the list is at its second instant where `places.0` was at its first"; at an `end` as `circle_rows`.
    pub fn phase_rows(
        &self,
        entries: &[UnscaledModel],
        u: Pair,
        places: (usize, usize),
        (cell, end): (&TimeInterval, IntervalEnd),
    ) -> Vec<TaylorModel> {
        let (inner, width) = (self.n_inner(), self.constant.ncols());
        // The entry of a row and an unknown, or of what is known.
        let entry = |row: usize, c: usize| {
            let line = &entries[row * width..(row + 1) * width];
            if c < inner {
                return line[c];
            }
            let mut known = line[inner + 2];
            known.add(-u[0], &line[inner]);
            known.add(-u[1], &line[inner + 1]);
            known
        };
        let dead = self.dead_stop(places, end, 1.0);
        let mut rows = Vec::with_capacity((inner + 1) * (inner + 1));
        for row in 0..=inner {
            for c in 0..=inner {
                // What is known has the unit of the phase's columns, the next in the list.
                let unit = self.units.rows[row] * self.units.columns[c];
                if row < inner {
                    rows.push(entry(row, c).series(unit));
                    continue;
                }
                let contacts = [entry(inner + places.1, c), entry(inner + places.0, c)];
                let difference = UnscaledModel::combined([1.0, -1.0], [&contacts[0], &contacts[1]]);
                rows.push(if end == IntervalEnd::Neither {
                    difference.series(unit)
                } else {
                    met(
                        difference,
                        dead.map(|(place, factor)| (entry(place, c), factor)),
                        cell,
                        unit,
                    )
                });
            }
        }
        rows
    }
}

/// A difference of contacts about a flight time at which they meet, over x; or, where the impact before leaves no speed,
/// less the way made at that speed and over `x^2`. In the given unit.
fn met(
    mut difference: UnscaledModel,
    dead: Option<(UnscaledModel, f64)>,
    cell: &TimeInterval,
    unit: f64,
) -> TaylorModel {
    let Some((speed, factor)) = dead else {
        return difference.over_x(1, unit);
    };
    difference.add(-factor * cell.scale, &speed.times_x());
    difference.over_x(2, unit)
}
