//! A slow twin of linear scenes that shares no line with the library: everything that moves is one vector `z = (q, v, 1, cos, sin, ..., s)` with
//! `z' = A z`, gaps and contact forces are rows of it, flights are Taylor sums of short steps, impacts that accumulate are gone through until
//! their speed is 1e-7.

mod events;

use nalgebra::{DMatrix, DVector};
use std::rc::Rc;

/// Steps are no longer than this over the norm of A.
const REACH: f64 = 0.5;
/// Terms of a Taylor sum, whose steps reach half of the radius at which the exponential's grow.
const TERMS: usize = 16;
/// Speed below which the rest of impacts that accumulate is taken at once: what that neglects is its square.
const AT_REST: f64 = 1e-7;
/// An impact no faster, a gap whose least value is no larger, a force as small: no motion beside is surely like it.
const NEAR: f64 = 1e-4;
/// Events of a run.
const MOST_EVENTS: usize = 4000;

/// What turns with time: `re cos(w t + phase) - im sin(w t + phase)` as a force.
#[derive(Debug, Clone)]
pub struct Tone {
    pub w: f64,
    pub phase: f64,
    pub re: DVector<f64>,
    pub im: DVector<f64>,
}

/// `gap = clearance - n.q`, and what its own motion adds: `amplitude cos(w t + phase)` of a tone.
#[derive(Debug, Clone)]
pub struct TwinStop {
    pub normal: DVector<f64>,
    pub reaction: DVector<f64>,
    pub clearance: f64,
    pub restitution: f64,
    pub motion: Option<(usize, f64)>,
}

/// A force along a direction, straight lines between samples that reach over the run.
#[derive(Debug, Clone)]
pub struct Samples {
    pub direction: DVector<f64>,
    pub times: Vec<f64>,
    pub values: Vec<f64>,
}

#[derive(Debug, Clone)]
pub struct Twin {
    pub mass: DMatrix<f64>,
    pub damping: DMatrix<f64>,
    pub stiffness: DMatrix<f64>,
    pub load: DVector<f64>,
    pub tones: Vec<Tone>,
    pub samples: Option<Samples>,
    pub stops: Vec<TwinStop>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Happening {
    Impact(usize),
    /// The impacts on a stop that accumulate, all of them.
    Chatter(usize),
    /// An impact behind which the stop is held.
    Landing(usize),
    Release(usize),
}

/// A run: its states at the times that were asked for, and what happened.
#[derive(Debug, Clone, Default)]
pub struct Course {
    pub states: Vec<DVector<f64>>,
    pub happenings: Vec<Happening>,
    pub times: Vec<f64>,
}

/// A moving vector, what is held and which gaps are zero with so many of their derivatives.
struct Here {
    /// What moves it, and for which stops held and which slope of the samples that was made.
    mode: Option<(Vec<usize>, f64, Rc<Mode>)>,
    t: f64,
    z: DVector<f64>,
    held: Vec<usize>,
    open: Vec<(usize, usize)>,
}

/// The matrices while some stops are held on a piece of the samples.
struct Mode {
    a: DMatrix<f64>,
    /// Contact forces, a row for each stop held.
    forces: DMatrix<f64>,
    step: f64,
}

impl Twin {
    fn n(&self) -> usize {
        self.load.len()
    }

    fn len(&self) -> usize {
        2 * self.n() + 2 + 2 * self.tones.len()
    }

    /// The gap of a stop.
    fn gap(&self, i: usize) -> DVector<f64> {
        let (n, stop) = (self.n(), &self.stops[i]);
        let mut row = DVector::zeros(self.len());
        row.rows_mut(0, n).copy_from(&-&stop.normal);
        row[2 * n] = stop.clearance;
        if let Some((tone, amplitude)) = stop.motion {
            row[2 * n + 1 + 2 * tone] = amplitude;
        }
        row
    }

    /// The matrix of free motion, the samples rising by a slope.
    fn free(&self, slope: f64) -> DMatrix<f64> {
        let (n, len) = (self.n(), self.len());
        let inverse = self.mass.clone().try_inverse().expect("regular");
        let mut a = DMatrix::zeros(len, len);
        a.view_mut((0, n), (n, n)).fill_with_identity();
        a.view_mut((n, 0), (n, n))
            .copy_from(&(-&inverse * &self.stiffness));
        a.view_mut((n, n), (n, n))
            .copy_from(&(-&inverse * &self.damping));
        a.view_mut((n, 2 * n), (n, 1))
            .copy_from(&(&inverse * &self.load));
        for (j, tone) in self.tones.iter().enumerate() {
            let c = 2 * n + 1 + 2 * j;
            a.view_mut((n, c), (n, 1)).copy_from(&(&inverse * &tone.re));
            a.view_mut((n, c + 1), (n, 1))
                .copy_from(&(-&inverse * &tone.im));
            (a[(c, c + 1)], a[(c + 1, c)]) = (-tone.w, tone.w);
        }
        if let Some(samples) = &self.samples {
            a.view_mut((n, len - 1), (n, 1))
                .copy_from(&(inverse * &samples.direction));
            a[(len - 1, 2 * n)] = slope;
        }
        a
    }

    /// Normals and reactions of some stops.
    fn directions(&self, held: &[usize]) -> [DMatrix<f64>; 2] {
        let columns = |of: fn(&TwinStop) -> &DVector<f64>| {
            DMatrix::from_fn(self.n(), held.len(), |i, j| of(&self.stops[held[j]])[i])
        };
        [columns(|stop| &stop.normal), columns(|stop| &stop.reaction)]
    }

    fn mode(&self, here: &mut Here) -> Option<Rc<Mode>> {
        let slope = self.samples.as_ref().map_or(0.0, |own| own.piece(here.t).1);
        match &here.mode {
            Some((held, own, mode)) if *held == here.held && *own == slope => Some(Rc::clone(mode)),
            _ => {
                let mode = Rc::new(self.made(&here.held, slope)?);
                here.mode = Some((here.held.clone(), slope, Rc::clone(&mode)));
                Some(mode)
            }
        }
    }

    fn made(&self, held: &[usize], slope: f64) -> Option<Mode> {
        let n = self.n();
        let mut a = self.free(slope);
        let mut forces = DMatrix::zeros(held.len(), self.len());
        if !held.is_empty() {
            let square = &a * &a;
            let mut pulls = DMatrix::zeros(held.len(), self.len());
            for (k, &stop) in held.iter().enumerate() {
                pulls.set_row(k, &(self.gap(stop).transpose() * &square));
            }
            let [normals, reactions] = self.directions(held);
            forces = -normals.tr_mul(&reactions).try_inverse()? * pulls;
            let change = reactions * &forces;
            let mut rows = a.rows_mut(n, n);
            rows -= change;
        }
        let norm = a
            .row_iter()
            .map(|row| row.iter().map(|x| x.abs()).sum::<f64>());
        let step = REACH / norm.fold(1.0, f64::max);
        Some(Mode { a, forces, step })
    }

    /// What turns, and the samples, from the time itself.
    fn clocked(&self, t: f64, z: &mut DVector<f64>) {
        let n = self.n();
        for (j, tone) in self.tones.iter().enumerate() {
            let angle = tone.w * t + tone.phase;
            (z[2 * n + 1 + 2 * j], z[2 * n + 2 + 2 * j]) = (angle.cos(), angle.sin());
        }
        if let Some(samples) = &self.samples {
            z[2 * n + 1 + 2 * self.tones.len()] = samples.piece(t).0;
        }
    }

    /// The run from a state; `None` where one beside is not surely like it.
    pub fn run(
        &self,
        q: &DVector<f64>,
        v: &DVector<f64>,
        span: (f64, f64),
        times: &[f64],
    ) -> Option<Course> {
        let n = self.n();
        let mut z = DVector::zeros(self.len());
        z.rows_mut(0, n).copy_from(q);
        z.rows_mut(n, n).copy_from(v);
        z[2 * n] = 1.0;
        self.clocked(span.0, &mut z);
        let (held, open) = (Vec::new(), Vec::new());
        let mut here = Here {
            mode: None,
            t: span.0,
            z,
            held,
            open,
        };
        if (0..self.stops.len()).any(|i| self.gap(i).dot(&here.z) < NEAR) {
            return None;
        }
        let mut found = Course::default();
        let mut marks: Vec<f64> = times.to_vec();
        if let Some(samples) = &self.samples {
            marks.extend(
                samples
                    .times
                    .iter()
                    .filter(|t| span.0 < **t && **t < span.1),
            );
        }
        marks.sort_by(f64::total_cmp);
        for mark in marks {
            while here.t < mark {
                self.step(&mut here, mark, &mut found)?;
                if found.happenings.len() > MOST_EVENTS {
                    return None;
                }
            }
            if times.contains(&mark) {
                found.states.push(here.z.rows(0, 2 * n).into_owned());
            }
        }
        Some(found)
    }

    /// One step, to the next event or a mark at the farthest.
    fn step(&self, here: &mut Here, mark: f64, found: &mut Course) -> Option<()> {
        let mode = self.mode(here)?;
        let span = mode.step.min(mark - here.t);
        let mut terms = vec![here.z.clone()];
        for k in 1..=TERMS {
            let next = &mode.a * &terms[k - 1] / k as f64;
            terms.push(next);
        }
        let along = |row: &DVector<f64>| -> Vec<f64> { terms.iter().map(|z| row.dot(z)).collect() };
        let mut first: Option<(f64, Happening)> = None;
        let mut note = |at: f64, what: Happening| {
            if at < first.map_or(f64::INFINITY, |own| own.0) {
                first = Some((at, what));
            }
        };
        for i in (0..self.stops.len()).filter(|i| !here.held.contains(i)) {
            let zero = here
                .open
                .iter()
                .find(|own| own.0 == i)
                .map_or(0, |own| own.1);
            let series = along(&self.gap(i)).split_off(zero);
            note(first_root(&series, span, zero == 0)?, Happening::Impact(i));
        }
        for (k, &i) in here.held.iter().enumerate() {
            let series = along(&mode.forces.row(k).transpose());
            note(first_root(&series, span, true)?, Happening::Release(i));
        }
        let past = first.map_or(span, |own| own.0);
        here.z = terms
            .iter()
            .rev()
            .fold(DVector::zeros(self.len()), |sum, z| sum * past + z);
        here.t = if first.is_none() && span == mark - here.t {
            mark
        } else {
            here.t + past
        };
        here.open.clear();
        self.clocked(here.t, &mut here.z);
        let Some((_, what)) = first else {
            return Some(());
        };
        found.times.push(here.t);
        match what {
            Happening::Impact(i) => self.strike(here, i, found),
            _ => self.release(here, what, found),
        }
    }
}

impl Samples {
    /// Value and slope at a time, where two pieces meet those of the later.
    fn piece(&self, t: f64) -> (f64, f64) {
        let k = self
            .times
            .partition_point(|own| *own <= t)
            .clamp(1, self.times.len() - 1);
        let slope = (self.values[k] - self.values[k - 1]) / (self.times[k] - self.times[k - 1]);
        (self.values[k - 1] + slope * (t - self.times[k - 1]), slope)
    }
}

fn value(series: &[f64], x: f64) -> f64 {
    series.iter().rev().fold(0.0, |sum, term| sum * x + term)
}

/// The first zero of a power series that is positive at first, within a span, infinite where there is none; `None` where it comes
/// near zero without a crossing.
fn first_root(series: &[f64], span: f64, has_begun: bool) -> Option<f64> {
    let fine = (1..40).rev().map(|k| span * 0.5f64.powi(k));
    let mut grid: Vec<f64> = std::iter::once(0.0)
        .chain(fine.filter(|_| !has_begun))
        .chain((1..=8).map(|k| span * f64::from(k) / 8.0))
        .collect();
    grid.sort_by(f64::total_cmp);
    let at: Vec<f64> = grid.iter().map(|x| value(series, *x)).collect();
    let bisected = |mut low: f64, mut high: f64| {
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if value(series, middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    };
    for k in 1..grid.len() {
        if at[k] <= 0.0 {
            return Some(bisected(grid[k - 1], grid[k]));
        }
        let is_dip = k + 1 < grid.len() && at[k] < at[k - 1] && at[k] < at[k + 1];
        if is_dip {
            let (mut low, mut high) = (grid[k - 1], grid[k + 1]);
            for _ in 0..100 {
                let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if value(series, a) < value(series, b) {
                    high = b;
                } else {
                    low = a;
                }
            }
            let least = value(series, low);
            if least <= -NEAR {
                return Some(bisected(grid[k - 1], low));
            }
            if least < NEAR {
                return None;
            }
        }
    }
    Some(f64::INFINITY)
}
