//! The conditions of one contact in a period (theory 22): a stop that gives way is met, pressed for a time tau, and the system is free of it for
//! the rest of the period. They are linear in the state at the beginning and in the phase; their coefficients are analytic functions of tau.

use crate::error::Result;
use crate::flow::ModalScene;
use crate::law::LinearForce;
use crate::observer::Observer;
use crate::orbit::two_instants::conditions::point;
use crate::orbit::two_instants::enlarged_flow::EnlargedFlow;
use crate::orbit::two_instants::green::TimeInterval;
use crate::orbit::two_instants::isolate::{IntervalEnd, IntervalModel, SearchInterval, isolate};
use crate::orbit::two_instants::polish::Root;
use crate::orbit::two_instants::taylor_model::{TAYLOR_TERMS, TaylorModel, UnscaledModel};
use crate::tolerance::FLIGHT_TIME_ROUNDING;
use nalgebra::{DMatrix, DVector};

/// Steps of Newton's method from the zero of a polynomial of degree seven to that of the function. [work]
const FINAL_STEPS: usize = 2;

/// Where a contact ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ContactEnd {
    /// Where the gap opens.
    Gap,
    /// Where the force is zero.
    Force,
}

/// What the period is made of.
pub(super) struct ContactCycle<'a> {
    /// The scene while the stop is pressed, and free of it.
    pub pressed: &'a ModalScene,
    pub free: &'a ModalScene,
    pub stop: usize,
    pub force: LinearForce,
    pub end: ContactEnd,
    /// The rate at which the stop goes back to its place, of one that relaxes.
    pub relaxes: Option<f64>,
    /// How long it is from the beginning until the motion, or its mirror image, repeats.
    pub span: f64,
    /// The mirror image is what repeats: half a period later all is opposite.
    pub is_mirrored: bool,
}

/// The conditions: rows of the repetition, of the beginning of the contact and of its end; columns of the state at the beginning in the modes of
/// the pressed system, of the phase's cosine and sine, and of the right-hand side.
pub(super) struct Conditions<'a> {
    cycle: &'a ContactCycle<'a>,
    /// The motions, on states with a one and the phasor behind: `(z, 1, cos, sin)`.
    pressed: EnlargedFlow<'a>,
    free: EnlargedFlow<'a>,
    /// Takes states of the pressed system's modes to those of the free one's, shape `(2n + 3, 2n + 3)`.
    change: DMatrix<f64>,
    /// The approach to the stop as a row on such states, of the pressed system and of the free one.
    approach: [Vec<f64>; 2],
    /// The force of the stop as a row on states of the pressed system.
    force: Vec<f64>,
    /// What the force of the stop does to the modes of the free system.
    push: Vec<f64>,
}

impl<'a> Conditions<'a> {
    /// The conditions of a cycle; `modes` are the numbers of all modes.
    pub fn new(cycle: &'a ContactCycle<'a>, modes: &'a [usize]) -> Self {
        let ContactCycle {
            pressed,
            free,
            stop,
            force,
            ..
        } = *cycle;
        let m = 2 * modes.len();
        let mut change = DMatrix::identity(m + 3, m + 3);
        let between = free.form.transformation().1 * pressed.form.transformation().0;
        change.view_mut((0, 0), (m, m)).copy_from(&between);
        let way = LinearForce {
            stiffness: 1.0,
            ..LinearForce::NOTHING
        };
        let approach = |scene: &ModalScene| stop_row(scene, stop, way);
        Self {
            cycle,
            pressed: EnlargedFlow::new(pressed, modes),
            free: EnlargedFlow::new(free, modes),
            change,
            approach: [approach(pressed), approach(free)],
            force: stop_row(pressed, stop, force),
            push: free.jumps[stop].as_flattened().iter().map(|x| -x).collect(),
        }
    }

    /// Number of coordinates of a state.
    pub fn n_states(&self) -> usize {
        self.push.len()
    }

    /// Whether nothing is constant in them but zero: no clearance, load or preload.
    pub fn is_homogeneous(&self) -> bool {
        let m = self.n_states();
        let ContactCycle { pressed, free, .. } = self.cycle;
        let mut loads = pressed.load.iter().chain(&free.load).flatten();
        let rows = [&self.approach[0], &self.force];
        loads.all(|x| *x == 0.0) && rows.iter().all(|row| row[m] == 0.0)
    }

    /// The unit of the phase's columns.
    pub fn phase_unit(&self) -> f64 {
        1.0 / self.pressed.units[self.n_states() + 1]
    }

    /// The scaled conditions over a cell of durations, by rows. At an end of the range at which some are no longer independent the zero known
    /// there is divided out.
    pub fn models(&self, cell: &TimeInterval, end: IntervalEnd) -> Vec<TaylorModel> {
        let (m, span) = (self.n_states(), self.cycle.span);
        let width = m + 3;
        let rest = TimeInterval {
            origin: span - cell.origin,
            low: span - cell.high,
            high: span - cell.low,
            ..*cell
        };
        let (during, after) = (self.pressed.flow(cell.origin), self.free.flow(rest.origin));
        // A longer contact adds what its force does at the end of it: d/dtau of the motion has rank one.
        let given = self.free.column(&self.push, &after, &rest);
        let force = self.pressed.row(&self.force, &during, cell);
        let reached = &after * &self.change * &during;
        let sizes = after.abs() * self.change.abs() * during.abs();
        let begun = |row: usize, column: usize| match (column < m, self.cycle.is_mirrored) {
            (false, _) => 0.0,
            (true, false) => self.change[(row, column)],
            (true, true) => -self.change[(row, column)],
        };
        let moved = |row: usize, column: usize| {
            let mut entry =
                UnscaledModel::product(&given[row], &force[column]).integral(cell.scale);
            let begun = begun(row, column);
            entry.c[0] += reached[(row, column)] - begun;
            entry.size += sizes[(row, column)] + begun.abs();
            entry
        };
        let closing: Vec<Vec<UnscaledModel>> = (0..m)
            .map(|row| (0..width).map(|c| moved(row, c)).collect())
            .collect();
        let contact = self.contact_rows(cell, (&during, &closing), &force, end);
        let rows = closing.iter().zip(self.free.units.iter().copied());
        let rows = rows.chain(contact.iter().map(|(row, unit)| (row, *unit)));
        rows.flat_map(|(row, unit)| self.scaled(row, unit))
            .collect()
    }

    /// One row with columns in the order of the unknowns, right-hand side last.
    fn scaled<'r>(
        &'r self,
        row: &'r [UnscaledModel],
        unit: f64,
    ) -> impl Iterator<Item = TaylorModel> + 'r {
        let m = self.n_states();
        let columns = (0..m).chain([m + 1, m + 2]);
        let unknowns = columns.map(move |c| row[c].series(unit / self.pressed.units[c]));
        unknowns.chain([row[m].series(-unit)])
    }

    /// The rows of the beginning and of the end of the contact, each with its unit.
    fn contact_rows(
        &self,
        cell: &TimeInterval,
        (during, closing): (&DMatrix<f64>, &[Vec<UnscaledModel>]),
        force: &[UnscaledModel],
        end: IntervalEnd,
    ) -> [(Vec<UnscaledModel>, f64); 2] {
        let approach = self.pressed.row(&self.approach[0], during, cell);
        let constant = |row: &[f64]| {
            row.iter()
                .map(|&x| UnscaledModel::constant(x))
                .collect::<Vec<_>>()
        };
        let difference =
            |one: &[UnscaledModel], factor: f64, other: &[UnscaledModel]| -> Vec<UnscaledModel> {
                let pairs = one.iter().zip(other);
                pairs
                    .map(|(a, b)| UnscaledModel::combined([1.0, -factor], [a, b]))
                    .collect()
            };
        let begun = constant(&self.approach[0]);
        let at_gap = self.cycle.end == ContactEnd::Gap;
        let mut ended = if at_gap {
            approach.clone()
        } else {
            force.to_vec()
        };
        if at_gap && end == IntervalEnd::Low {
            ended = over_x(&difference(&ended, 1.0, &begun));
        }
        // What the approach misses at the end of the period, by the rows that say that the motion repeats.
        let missed = || -> Vec<UnscaledModel> {
            (0..begun.len())
                .map(|c| {
                    let mut sum = UnscaledModel::default();
                    for (row, factor) in closing.iter().zip(&self.approach[1]) {
                        sum.add(*factor, &row[c]);
                    }
                    sum
                })
                .collect()
        };
        if at_gap && end == IntervalEnd::High && !self.cycle.is_mirrored {
            ended = over_x(&difference(
                &difference(&ended, 1.0, &begun),
                1.0,
                &missed(),
            ));
        }
        let begun = match self.cycle.relaxes {
            None => begun,
            Some(rate) => {
                let factor = self.remembered(rate, cell);
                let kept = approach.iter();
                let kept: Vec<_> = kept
                    .map(|own| UnscaledModel::product(own, &factor))
                    .collect();
                let left = difference(&begun, 1.0, &kept);
                if end == IntervalEnd::High && !self.cycle.is_mirrored {
                    // Behind a flight of a time t the stop is met again where p(T) = r: what is left is f t/c, and then of second order.
                    let share = cell.scale / self.cycle.force.damping;
                    let slow: Vec<_> = force.iter().map(UnscaledModel::times_x).collect();
                    let left = difference(&left, -1.0, &missed());
                    over_x(&over_x(&difference(&left, -share, &slow)))
                } else {
                    left
                }
            }
        };
        let unit = |row: &[f64]| {
            let units = self.pressed.units.iter().take(self.n_states());
            let lengths = row.iter().zip(units).map(|(r, unit)| r / unit);
            1.0 / lengths.fold(0.0, f64::hypot)
        };
        let ended_unit = unit(if at_gap {
            &self.approach[0]
        } else {
            &self.force
        });
        [(begun, unit(&self.approach[0])), (ended, ended_unit)]
    }

    /// The part of its way in which a stop that goes back at a rate is still out when the next contact begins.
    fn remembered(&self, rate: f64, cell: &TimeInterval) -> UnscaledModel {
        let period = self.cycle.span * if self.cycle.is_mirrored { 2.0 } else { 1.0 };
        let (mut own, mut factor) = (UnscaledModel::default(), 1.0);
        let [here, most] = [cell.origin, cell.high].map(|tau| (rate * (tau - period)).exp());
        for k in 0..TAYLOR_TERMS + 3 {
            if k < TAYLOR_TERMS + 2 {
                own.c[k] = here * factor;
            }
            if k >= TAYLOR_TERMS {
                own.rest[k - TAYLOR_TERMS] = most * factor;
            }
            factor *= rate * cell.scale / (k + 1) as f64;
        }
        own.size = here;
        own
    }

    /// How long it is from the beginning until the motion, or its mirror image, repeats.
    pub fn span(&self) -> f64 {
        self.cycle.span
    }

    /// The unknowns of a root that was found with the phase given.
    pub fn at_phase(&self, root: &Root, phase: [f64; 2]) -> Root {
        let m = self.n_states();
        let given = phase.map(|part| part / self.phase_unit());
        let all = root.x.iter().take(m).copied().chain(given);
        Root {
            dt: root.dt,
            x: DVector::from_iterator(m + 2, all),
        }
    }

    /// How deep the stop is pressed at the end of a contact.
    pub fn approach(&self, tau: f64, x: &DVector<f64>) -> f64 {
        let ended = self.pressed.flow(tau) * self.begun(x);
        row_value(&self.approach[0], &ended)
    }

    /// The state at the beginning, in the modes of the pressed system, with a one and the phasor behind.
    fn begun(&self, x: &DVector<f64>) -> DVector<f64> {
        let m = self.n_states();
        let place = |c: usize| if c < m { c } else { c - 1 };
        DVector::from_fn(m + 3, |c, _| match c {
            one if one == m => 1.0,
            c => x[place(c)] / self.pressed.units[c],
        })
    }

    /// The states, in the modes of the free system, at the beginning and at the end of a contact and at the end of the period, from scaled
    /// unknowns; and the cosine and sine of the phase.
    pub fn states(&self, tau: f64, x: &DVector<f64>) -> ([DVector<f64>; 3], [f64; 2]) {
        let m = self.n_states();
        let begun = self.begun(x);
        let phase = [begun[m + 1], begun[m + 2]];
        let ended = &self.change * self.pressed.flow(tau) * &begun;
        let last = self.free.flow(self.cycle.span - tau) * &ended;
        let all = [&self.change * begun, ended, last];
        (all.map(|state| state.rows(0, m).into_owned()), phase)
    }

    /// When the gap of the stop first is zero on the flight behind a contact of some duration, from the beginning of the period; if it is inside
    /// then, and comes out before it is met again. With the state there, in the modes of the free system.
    ///
    /// # Errors
    /// `Error::Interrupted` from the observer.
    pub fn opening(
        &self,
        (tau, x): (f64, &DVector<f64>),
        observer: &mut Observer,
    ) -> Result<Option<(f64, DVector<f64>)>> {
        let ended = &self.change * self.pressed.flow(tau) * self.begun(x);
        let approach = |place: &SearchInterval| {
            let cell = place.time_interval();
            let row = self
                .free
                .row(&self.approach[1], &self.free.flow(cell.origin), &cell);
            let terms: Vec<_> = row
                .iter()
                .zip(&ended)
                .map(|(own, y)| own.series(*y))
                .collect();
            let series = TaylorModel::sum(terms.iter().map(|own| (1.0, own)));
            let floor = FLIGHT_TIME_ROUNDING * series.size();
            IntervalModel { series, floor }
        };
        if row_value(&self.approach[1], &ended) <= 0.0 {
            return Ok(None);
        }
        let span = self.cycle.span - tau;
        let found = isolate((0.0, span), (false, false), observer, approach)?;
        Ok(found.simple.first().map(|bracket| {
            let mut t = bracket.guess;
            for _ in 0..FINAL_STEPS {
                let row = self
                    .free
                    .row(&self.approach[1], &self.free.flow(t), &point(t, 1.0));
                let terms = row.iter().zip(&ended);
                let sums = |[gap, speed]: [f64; 2], (own, y): (&UnscaledModel, &f64)| {
                    [gap + own.c[0] * y, speed + own.c[1] * y]
                };
                let [gap, speed] = terms.fold([0.0; 2], sums);
                t -= gap / speed;
            }
            let state = self.free.flow(t) * &ended;
            (tau + t, state.rows(0, self.n_states()).into_owned())
        }))
    }
}

/// What a row sees of a state.
fn row_value(row: &[f64], state: &DVector<f64>) -> f64 {
    row.iter().zip(state).map(|(row, y)| row * y).sum()
}

/// A row over x, its value at the origin zero.
fn over_x(row: &[UnscaledModel]) -> Vec<UnscaledModel> {
    row.iter().map(UnscaledModel::shifted).collect()
}

/// A force that a stop has by a law, as a row on `(z, 1, cos, sin)`.
fn stop_row(scene: &ModalScene, stop: usize, force: LinearForce) -> Vec<f64> {
    let (place, speed) = (&scene.position_rows[stop], &scene.velocity_rows[stop]);
    let on_state = place.iter().flatten().zip(speed.iter().flatten());
    let mut row: Vec<f64> = on_state
        .map(|(q, v)| force.stiffness * q + force.damping * v)
        .collect();
    let clearance = scene.mean_clearances(&[stop])[0];
    row.push(force.at(clearance, 0.0));
    let motion = scene.excitation.motion_of(stop);
    let amplitude = motion
        .and_then(|own| own.amplitudes.first().copied())
        .unwrap_or_default();
    let turned = force.turned(amplitude, scene.frequency);
    row.extend([-turned.re, turned.im]);
    row
}
