//! The periodic conditions of two instants of impact, a flight time dt apart in the period T (theory 5), as linear
//! equations in the impulses, the states of resonant modes and the phase `u = (cos, sin)` at the first instant, whose
//! coefficients are analytic functions of dt: restitution, repetition of the resonant modes, and the contacts.

use crate::flow::ModalScene;
use crate::modal::{Form, ModalState, Pair, times};
use crate::orbit::one_instant::periodic_conditions::PeriodicConditions;
use crate::orbit::two_instants::enlarged_flow::EnlargedFlow;
use crate::orbit::two_instants::green::{Green, TimeInterval, turned};
use crate::orbit::two_instants::polish::Root;
use crate::orbit::two_instants::taylor_model::UnscaledModel;
use crate::orbit::two_instants::units::Units;
use crate::tolerance::REPEATED_IMPULSE;
use nalgebra::{Complex, DMatrix, DVector};

/// Rows: restitution of each stop, repetition of the resonant modes, contact of each stop. Columns: impulses, states of
/// the resonant modes, cos and sin, right-hand side.
pub(crate) struct TwoInstantConditions<'a> {
    pub(in crate::orbit) instant: &'a PeriodicConditions<'a>,
    /// Stops of the first instant; those of the second follow in `instant.stops`.
    pub(in crate::orbit) first: usize,
    /// The equations with dt = 0 wherever dt enters, shape (rows, columns) as above, [physical units].
    pub(in crate::orbit) constant: DMatrix<f64>,
    pub(in crate::orbit) units: Units,
    /// The response of the eliminated modes to an impulse of each stop.
    green: Vec<Green>,
    /// The restitution and the contact rows of the stops of either instant, in the eliminated modes.
    eliminated_rows: [Vec<(f64, Vec<Pair>)>; 2],
    pub(in crate::orbit) resonant: Option<EnlargedFlow<'a>>,
}

impl<'a> TwoInstantConditions<'a> {
    /// The conditions for the stops of `instant`, of which the first few are hit at the first instant.
    pub fn new(instant: &'a PeriodicConditions<'a>, first: usize) -> Self {
        let scene = instant.scene;
        let (k, inner) = (instant.stops.len(), instant.n_inner());
        let (repeat, rhs) = instant.repeat_rows();
        let (contact, offset) = instant.contact_rows();
        let mut constant = DMatrix::zeros(inner + k, inner + 3);
        constant
            .view_mut((0, 0), (inner, inner + 2))
            .copy_from(&repeat);
        constant
            .view_mut((inner, 0), (k, inner + 2))
            .copy_from(&contact);
        constant
            .view_mut((0, inner + 2), (inner, 1))
            .copy_from(&rhs);
        constant
            .view_mut((inner, inner + 2), (k, 1))
            .copy_from(&(instant.clearances() - offset));
        let mut units = instant.units(&constant.columns(0, inner + 2).into_owned(), k);
        units.columns = units.columns.push(1.0);
        let (eliminated, blocks) = eliminated(instant);
        let softest = blocks
            .iter()
            .flat_map(|b| b.roots().map(Complex::norm))
            .filter(|&r| r > 0.0);
        let softest = softest.fold(scene.frequency, f64::min);
        let green = instant
            .stops
            .iter()
            .map(|&stop| {
                let start = eliminated.iter().filter_map(|&j| {
                    Some(times(instant.resolvents[j].as_ref()?, scene.jumps[stop][j]))
                });
                Green::new(blocks.iter().copied().zip(start).collect(), softest)
            })
            .collect();
        let pick = |row: &[Pair]| eliminated.iter().map(|&j| row[j]).collect::<Vec<_>>();
        let eliminated_rows = [&instant.stops[..first], &instant.stops[first..]].map(|stops| {
            let velocity = stops.iter().map(|&a| {
                (
                    -scene.geometry.law(a).factor(),
                    pick(&scene.velocity_rows[a]),
                )
            });
            velocity
                .chain(stops.iter().map(|&a| (-1.0, pick(&scene.position_rows[a]))))
                .collect()
        });
        let resonant =
            (!instant.resonant.is_empty()).then(|| EnlargedFlow::new(scene, &instant.resonant));
        Self {
            instant,
            first,
            constant,
            units,
            green,
            eliminated_rows,
            resonant,
        }
    }

    pub(in crate::orbit) fn scene(&self) -> &'a ModalScene {
        self.instant.scene
    }

    /// Number of unknowns besides the phase.
    pub fn n_inner(&self) -> usize {
        self.instant.n_inner()
    }

    /// Unit of the phase's columns: `u = unit u'`.
    pub fn phase_unit(&self) -> f64 {
        self.units.columns[self.n_inner()]
    }

    /// Whether modes keep their unknowns.
    pub fn has_resonant_modes(&self) -> bool {
        self.resonant.is_some()
    }

    /// The equations over a cell of dt, by rows, unscaled.
    pub fn entries(&self, cell: &TimeInterval) -> Vec<UnscaledModel> {
        let (k, inner, width) = (
            self.instant.stops.len(),
            self.n_inner(),
            self.constant.ncols(),
        );
        let mut entries: Vec<UnscaledModel> = self
            .constant
            .transpose()
            .iter()
            .map(|&x| UnscaledModel::constant(x))
            .collect();
        let t = self.instant.period;
        let rest = TimeInterval {
            origin: t - cell.origin,
            low: t - cell.high,
            high: t - cell.low,
            ..*cell
        };
        let mut out = vec![UnscaledModel::default(); 2 * k];
        for (b, green) in self.green.iter().enumerate() {
            let is_first = b < self.first;
            // An impulse of one instant as the stops of the other one see it.
            let (rows, targets, tau) = if is_first {
                (&self.eliminated_rows[1], self.first..k, cell)
            } else {
                (&self.eliminated_rows[0], 0..self.first, &rest)
            };
            let n = targets.len();
            out.fill(UnscaledModel::default());
            green.add(tau, !is_first, rows, &mut out);
            for (i, a) in targets.enumerate() {
                entries[a * width + b] = out[i];
                entries[(inner + a) * width + b] = out[n + i];
            }
        }
        for a in self.first..k {
            for row in [a, inner + a] {
                let steady = [self.constant[(row, inner)], self.constant[(row, inner + 1)]];
                let turned = turned(cell, self.scene().frequency, steady);
                entries[row * width + inner..row * width + inner + 2].copy_from_slice(&turned);
            }
        }
        if let Some(resonant) = &self.resonant {
            self.put_resonant(resonant, cell, &rest, &mut entries);
        }
        entries
    }

    fn put_resonant(
        &self,
        resonant: &EnlargedFlow<'_>,
        cell: &TimeInterval,
        rest: &TimeInterval,
        entries: &mut [UnscaledModel],
    ) {
        let scene = self.scene();
        let (k, inner, width) = (
            self.instant.stops.len(),
            self.n_inner(),
            self.constant.ncols(),
        );
        let (there, back) = (resonant.flow(cell.origin), resonant.flow(rest.origin));
        let pick = |row: &[Pair]| {
            self.instant
                .resonant
                .iter()
                .flat_map(|&j| row[j])
                .collect::<Vec<f64>>()
        };
        for a in self.first..k {
            let stop = self.instant.stops[a];
            let velocity = (
                a,
                scene.geometry.law(stop).factor(),
                &scene.velocity_rows[stop],
            );
            for (row, factor, seen) in [velocity, (inner + a, 1.0, &scene.position_rows[stop])] {
                let seen = pick(seen);
                let along = resonant.row(&seen, &there, cell);
                let line = &mut entries[row * width..(row + 1) * width];
                for entry in &mut line[k..inner] {
                    *entry = UnscaledModel::default();
                }
                for (i, x) in along[..inner - k].iter().enumerate() {
                    line[k + i].add(factor, x);
                }
                line[inner + 2].add(-factor, &along[inner - k]);
                line[inner].add(factor, &along[inner - k + 1]);
                line[inner + 1].add(factor, &along[inner - k + 2]);
                // z at the second instant is the one before its own impulses.
                for (entry, &stop) in line.iter_mut().zip(self.instant.stops).skip(self.first) {
                    let jump = pick(&scene.jumps[stop]);
                    let own: f64 = seen.iter().zip(&jump).map(|(r, j)| r * j).sum();
                    entry.add(-factor, &UnscaledModel::constant(own));
                }
            }
        }
        for b in self.first..k {
            let jump = pick(&scene.jumps[self.instant.stops[b]]);
            for (i, entry) in resonant.column(&jump, &back, rest).into_iter().enumerate() {
                entries[(k + i) * width + b] = entry;
            }
        }
    }

    /// The largest misfit of the contacts that the search did not solve for, scaled: stops hit together have more contacts
    /// than there are unknowns. With the phase given only stops hit at both instants have one.
    pub fn contact_misfit(&self, root: &Root, is_phase_given: bool) -> f64 {
        let (inner, width) = (self.n_inner(), self.constant.ncols());
        let stops = self.instant.stops;
        if stops.len() == 2 {
            return 0.0;
        }
        let entries = self.entries(&point(root.dt, 1.0));
        let position = |a: usize| {
            let row = inner + a;
            let terms = (0..inner + 2)
                .map(|c| entries[row * width + c].c[0] * self.units.columns[c] * root.x[c]);
            self.units.rows[row] * (terms.sum::<f64>() - entries[row * width + inner + 2].c[0])
        };
        if !is_phase_given {
            return (0..stops.len())
                .map(|a| position(a).abs())
                .fold(0.0, f64::max);
        }
        let again = |a: usize| (self.first..stops.len()).find(|&b| stops[b] == stops[a]);
        let moved = |a: usize| again(a).map_or(0.0, |b| (position(b) - position(a)).abs());
        (0..self.first).map(moved).fold(0.0, f64::max)
    }

    /// Whether each stop is given the same impulse at both instants.
    pub fn impulses_repeat(&self, x: &DVector<f64>) -> bool {
        let stops = self.instant.stops;
        let largest = x.rows(0, stops.len()).amax();
        (0..self.first).all(|a| {
            let again = (self.first..stops.len()).find(|&b| stops[b] == stops[a]);
            again.is_some_and(|b| (x[a] - x[b]).abs() <= REPEATED_IMPULSE * largest)
        })
    }

    /// Impulses and phase of scaled unknowns.
    pub fn read(&self, x: &DVector<f64>) -> (Vec<f64>, Pair) {
        let value = |i: usize| x[i] * self.units.columns[i];
        let inner = self.n_inner();
        (
            (0..self.instant.stops.len()).map(value).collect(),
            [value(inner), value(inner + 1)],
        )
    }

    /// Scaled unknowns with the given phase from the solution of `phase_rows`, whose right-hand side has the phase's unit.
    pub fn with_phase(&self, x: &DVector<f64>, u: Pair) -> DVector<f64> {
        let unit = self.phase_unit();
        DVector::from_iterator(x.len() + 2, x.iter().copied().chain(u).map(|x| x / unit))
    }

    /// The states after the two instants, for scaled unknowns.
    pub fn states(&self, dt: f64, x: &DVector<f64>) -> [ModalState; 2] {
        let (instant, scene) = (self.instant, self.scene());
        let (impulses, u) = self.read(x);
        let (s, c) = (scene.frequency * dt).sin_cos();
        let later = [c * u[0] - s * u[1], s * u[0] + c * u[1]];
        let (eliminated, _) = eliminated(instant);
        let mut states = [(); 2].map(|()| instant.equilibrium.clone());
        for (side, (state, u)) in states.iter_mut().zip([u, later]).enumerate() {
            for &j in &eliminated {
                let [by_cos, by_sin] = instant.steady[0][j];
                state[j] = [0, 1].map(|k| state[j][k] + by_cos[k] * u[0] + by_sin[k] * u[1]);
            }
            for (b, green) in self.green.iter().enumerate() {
                let tau = match (side, b < self.first) {
                    (0, true) | (1, false) => 0.0,
                    (_, true) => dt,
                    (_, false) => instant.period - dt,
                };
                for (&j, z) in eliminated.iter().zip(green.states(tau)) {
                    state[j] = [
                        state[j][0] - impulses[b] * z[0],
                        state[j][1] - impulses[b] * z[1],
                    ];
                }
            }
        }
        if let Some(resonant) = &self.resonant {
            let (k, inner) = (instant.stops.len(), self.n_inner());
            let z = (k..inner).map(|i| x[i] * self.units.columns[i]);
            let y = DVector::from_iterator(inner - k + 3, z.chain([1.0, u[0], u[1]]));
            let moved = resonant.flow(dt) * &y;
            for (i, &j) in instant.resonant.iter().enumerate() {
                states[0][j] = [y[2 * i], y[2 * i + 1]];
                states[1][j] = [moved[2 * i], moved[2 * i + 1]];
                for (&stop, p) in instant.stops.iter().zip(&impulses).skip(self.first) {
                    let jump = scene.jumps[stop][j];
                    states[1][j] = [states[1][j][0] - jump[0] * p, states[1][j][1] - jump[1] * p];
                }
            }
        }
        states
    }
}

/// A cell of one point: values and derivatives only.
pub(crate) fn point(dt: f64, scale: f64) -> TimeInterval {
    TimeInterval {
        origin: dt,
        scale,
        low: dt,
        high: dt,
    }
}

/// The eliminated modes of an instant.
fn eliminated(instant: &PeriodicConditions<'_>) -> (Vec<usize>, Vec<crate::modal::Block>) {
    match &instant.scene.form.form {
        Form::Blocks(blocks) => (0..blocks.len())
            .filter(|&j| instant.resolvents[j].is_some())
            .map(|j| (j, blocks[j]))
            .unzip(),
        Form::Dense(_) => (Vec::new(), Vec::new()),
    }
}
