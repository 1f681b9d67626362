//! The map of a period by the referee: from a time amid the longest flight to the same time a period later, event by event, and
//! its derivative by differences.

use crate::branches::look::Look;
use crate::branches::script::{Event, Instant};
use crate::branches::stepper::{moved, step};
use crate::roots::eigenvalues;
use nalgebra::{Complex, DMatrix, DVector};

/// The largest step of differences, in the units of the motion.
const STEP: f64 = 4e-4;
/// An event moves by no more than this part of the period.
const NEAR: f64 = 0.1;
/// So often a step is halved, at the most.
const HALVINGS: i32 = 14;
/// Extrapolated differences that agree to this part of the largest with those of steps twice as long are the derivative.
const AGREED: f64 = 1e-7;

/// The map about an orbit.
pub struct Map<'a, 'b> {
    look: &'a Look<'b>,
    /// Where it begins.
    section: f64,
    /// What happens until a period later, in this order, at times counted on.
    ahead: Vec<Instant>,
}

impl<'a, 'b> Map<'a, 'b> {
    /// About an orbit that flies somewhere.
    pub fn new(look: &'a Look<'b>) -> Option<Self> {
        let flights = look.script.flights();
        let free = flights.iter().filter(|flight| flight.held.is_none());
        let longest = free.max_by(|a, b| (a.end - a.start).total_cmp(&(b.end - b.start)))?;
        let section = 0.5 * (longest.start + longest.end);
        let mut ahead = look.script.instants.clone();
        for own in &mut ahead {
            if own.time < section {
                own.time += look.script.period;
            }
        }
        ahead.sort_by(|a, b| a.time.total_cmp(&b.time));
        Some(Self {
            look,
            section,
            ahead,
        })
    }

    /// The state a period later; none where an event is not found.
    fn after(&self, x: &[f64]) -> Option<Vec<f64>> {
        let body = &self.look.body;
        let (mut time, mut x, mut held) = (self.section, x.to_vec(), None);
        for own in &self.ahead {
            x = moved(body, held, (time, &x), own.time);
            time = own.time;
            let dt = self.instant(own, held, (time, &x))?;
            x = step(body, held, (time, &x), dt);
            time += dt;
            if let Event::Hit { face, .. } = own.event {
                x = body.struck(face, &x).0;
            }
            held = own.held;
        }
        Some(moved(
            body,
            None,
            (time, &x),
            self.section + self.look.script.period,
        ))
    }

    /// How much later than in a state an event is, by secants.
    fn instant(&self, own: &Instant, held: Option<usize>, (t, x): (f64, &[f64])) -> Option<f64> {
        let body = &self.look.body;
        let zero = |dt: f64| {
            let y = step(body, held, (t, x), dt);
            match own.event {
                Event::Hit { face, .. } => body.gap(face, &y),
                Event::Release(_) => body.acceleration(t + dt, &y, held).1,
            }
        };
        let slope = match own.event {
            Event::Hit { face, .. } => body.speed(face, x),
            Event::Release(_) => {
                let h = 1e-5 * self.look.script.period;
                (zero(h) - zero(-h)) / (2.0 * h)
            }
        };
        let is_near = |dt: f64| dt.abs() < NEAR * self.look.script.period;
        let (mut before, mut now) = (0.0, -zero(0.0) / slope);
        let mut old = zero(0.0);
        for _ in 0..20 {
            if !is_near(now) {
                return None;
            }
            let value = zero(now);
            if value == old || now == before {
                break;
            }
            let next = now - value * (now - before) / (value - old);
            let is_there = (next - now).abs() <= 1e-15 * self.look.script.period;
            (before, old, now) = (now, value, next);
            if is_there {
                break;
            }
        }
        // The same event: at a speed of the same sign.
        let is_same = match own.event {
            Event::Hit { face, impact } => {
                let y = step(body, held, (t, x), now);
                body.speed(face, &y) * self.look.orbit.impacts()[impact].approach < 0.0
            }
            Event::Release(_) => true,
        };
        (is_near(now) && is_same).then_some(now)
    }

    /// Its derivative, in units of the motion; none where differences do not tell it.
    pub fn derivative(&self) -> Option<DMatrix<f64>> {
        let x = self.look.state(self.section, false);
        let (mut far, mut last): (Option<DMatrix<f64>>, Option<DMatrix<f64>>) = (None, None);
        for k in 0..=HALVINGS {
            let near = self.differences(&x, STEP * 2f64.powi(-k));
            let pair = near.as_ref().zip(far.as_ref());
            let found = pair.map(|(near, far)| (near * 4.0 - far) / 3.0);
            if let (Some(found), Some(last)) = (&found, &last)
                && (found - last).amax() <= AGREED * found.amax()
            {
                return Some(found.clone());
            }
            (far, last) = (near, found);
        }
        None
    }

    /// Its differences over a step, in units of the motion.
    fn differences(&self, x: &[f64], h: f64) -> Option<DMatrix<f64>> {
        let n = self.look.body.n();
        let unit = |i: usize| self.look.units[usize::from(i >= n)];
        let end = |i: usize, step: f64| {
            let mut y = x.to_vec();
            y[i] += step * unit(i);
            self.after(&y).map(DVector::from_vec)
        };
        let columns = (0..2 * n).map(|i| Some((end(i, h)? - end(i, -h)?) / (2.0 * h)));
        let found = DMatrix::from_columns(&columns.collect::<Option<Vec<_>>>()?);
        Some(DMatrix::from_fn(2 * n, 2 * n, |i, j| {
            found[(i, j)] / unit(i)
        }))
    }

    /// The multipliers, and how large the derivative is.
    pub fn multipliers(&self) -> Option<(Vec<Complex<f64>>, f64)> {
        let derivative = self.derivative()?;
        let found = eigenvalues(&derivative).iter().copied().collect();
        Some((found, derivative.norm()))
    }
}

/// The sums of powers of multipliers, which tell them without an order and are as well known where some of them meet.
pub fn power_sums(all: &[Complex<f64>]) -> Vec<f64> {
    let powers = 1..=i32::try_from(all.len()).expect("few");
    powers
        .map(|k| all.iter().map(|mu| mu.powi(k).re).sum())
        .collect()
}

/// By how much two sets of multipliers differ, in parts of the largest, at least one.
pub fn difference(one: &[Complex<f64>], other: &[Complex<f64>]) -> f64 {
    let largest = one.iter().map(|mu| mu.norm()).fold(1.0, f64::max);
    let scaled = |all: &[Complex<f64>]| {
        let scaled: Vec<_> = all.iter().map(|mu| mu / largest).collect();
        power_sums(&scaled)
    };
    let pairs = scaled(one).into_iter().zip(scaled(other));
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}
