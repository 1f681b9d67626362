//! Derivatives of an acceleration along deviations from a motion, by central differences whose steps follow the scale on which it bends.
//!
//! The two one-sided differences `a(x + h d) - a(x)` and `a(x) - a(x - h d)` differ by `h^2 a''`, which shows where the acceleration bends.
//! There, and from time to time elsewhere, a difference with another step is taken: a step is accepted if one of a sixteenth of its length
//! gives the same. It is kept for the next points along the motion, where a longer one is tried from time to time. Positions and velocities
//! are measured in units of the largest of the motion.

use crate::error::Result;
use crate::tolerance::{
    BENT_DIFFERENCE, CENTRAL_DIFFERENCE_STEP, DIFFERENCE_LEVELS, DIFFERENCE_RATIO,
    DIFFERENCED_ROUNDING, DOUBTFUL, KINK_DISTANCE, KINK_LEVEL, SAME_DIFFERENCE,
};
use std::sync::{Mutex, PoisonError};

/// Evaluations between two comparisons where nothing bends. [work]
const COMPARISON_PAUSE: u32 = 16;
/// Evaluations without a comparison after no length of the step did better: the function is rough. [work]
const ROUGH_PAUSE: u32 = 256;

/// Why the derivatives along deviations from a motion cannot be trusted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum DerivativeWarning {
    /// The acceleration jumps.
    Jump { time: f64 },
    /// Differences of no two lengths agree.
    Differences { time: f64 },
}

/// The first and the last warning of a computation.
#[derive(Debug, Default)]
pub(crate) struct WarningLog(Mutex<Option<[DerivativeWarning; 2]>>);

impl WarningLog {
    /// Adds a warning.
    pub fn note(&self, warning: DerivativeWarning) {
        let mut noted = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let first = noted.map_or(warning, |[first, _]| first);
        *noted = Some([first, warning]);
    }

    /// The first warning and the last.
    pub fn noted(&self) -> Option<[DerivativeWarning; 2]> {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl DerivativeWarning {
    /// When it arose.
    pub fn time(self) -> f64 {
        let (Self::Jump { time } | Self::Differences { time }) = self;
        time
    }

    /// The same at another time.
    pub fn at(self, time: f64) -> Self {
        match self {
            Self::Jump { .. } => Self::Jump { time },
            Self::Differences { .. } => Self::Differences { time },
        }
    }

    /// The message that it gives.
    pub fn reason(self) -> String {
        match self {
            Self::Jump { time } => format!(
                "the acceleration jumps, or bends within less than a step, at t = {time:.6}: what deviations become there is not in its \
                 derivatives; smooth it over a time that steps resolve, or make the place a stop"
            ),
            Self::Differences { time } => format!(
                "differences of the acceleration of no two lengths agree at t = {time:.6}: it is rough there; give the system its `jacobian`"
            ),
        }
    }
}

/// The step of the difference along one deviation.
#[derive(Debug, Clone, Default)]
struct Length {
    /// Number of times that it has been shortened by `DIFFERENCE_RATIO`.
    level: i32,
    /// Evaluations left until steps are compared.
    left: u32,
    /// Whether no step did better at the last comparison: the function is rough, and nothing is compared for a while.
    is_rough: bool,
    /// The first point, position and velocity, since which no two steps have agreed.
    lost_at: Option<[Vec<f64>; 2]>,
}

/// A difference quotient along a deviation.
#[derive(Clone)]
struct Quotient {
    level: i32,
    value: Vec<f64>,
    /// The smaller of the two one-sided quotients: at a jump, that of the side on which the point lies.
    one_sided: Vec<f64>,
    /// Its rounding.
    rounding: f64,
    /// Whether the two one-sided quotients, of which it is the mean, differ.
    is_bent: bool,
}

impl Quotient {
    /// The largest relative difference of an entry to that of another quotient, beyond the rounding of both.
    fn off(&self, other: &Self) -> f64 {
        let rounding = self.rounding + other.rounding;
        let each = self.value.iter().zip(&other.value).map(|(a, b)| {
            let beyond = (a - b).abs() - rounding;
            if beyond > 0.0 {
                beyond / a.abs().max(b.abs())
            } else {
                0.0
            }
        });
        each.fold(0.0, f64::max)
    }
}

/// Difference quotients along deviations, with the steps found so far along a motion.
#[derive(Debug)]
pub(crate) struct Differences {
    lengths: Vec<Length>,
    /// The largest positions and velocities of the motion, as far as they are known, no less than which is taken for its states.
    sizes: [f64; 2],
    /// Position and velocity of the place, and the acceleration there.
    place: [Vec<f64>; 2],
    base: Vec<f64>,
    /// Those that are taken at the place.
    units: [f64; 2],
    /// Rounding of a difference of accelerations.
    rounding: f64,
    moved: [Vec<f64>; 2],
    /// The accelerations at the points a step ahead and a step back.
    sides: [Vec<f64>; 2],
    /// Whether those of no two lengths agreed, once.
    pub is_doubtful: bool,
}

/// The acceleration at a position and a velocity.
type Acceleration<'a> = &'a dyn Fn(&[f64], &[f64], &mut [f64]) -> Result<()>;

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0f64, |m, x| m.max(x.abs()))
}

impl Differences {
    /// Of so many deviations from a motion whose positions and velocities have some sizes.
    pub fn new(count: usize, sizes: [f64; 2]) -> Self {
        Self {
            lengths: vec![Length::default(); count],
            sizes,
            place: [Vec::new(), Vec::new()],
            base: Vec::new(),
            units: sizes,
            rounding: 0.0,
            moved: [Vec::new(), Vec::new()],
            sides: [Vec::new(), Vec::new()],
            is_doubtful: false,
        }
    }

    /// The same by steps of one length, which are compared with no others: of accelerations that are differences of large forces, and so
    /// rounded by more than they show.
    pub fn of_one_length(mut self) -> Self {
        for own in &mut self.lengths {
            (own.left, own.is_rough) = (u32::MAX, true);
        }
        self
    }

    /// How many deviations there are.
    pub fn count(&self) -> usize {
        self.lengths.len()
    }

    /// Sets the point at which differences are taken, with the acceleration there.
    pub fn begin(&mut self, (q, v): (&[f64], &[f64]), base: &[f64]) {
        for (own, given) in (self.place.iter_mut().chain([&mut self.base])).zip([q, v, base]) {
            own.clear();
            own.extend_from_slice(given);
        }
        for side in &mut self.sides {
            side.resize(base.len(), 0.0);
        }
        self.units = [self.sizes[0] + largest(q), self.sizes[1] + largest(v)];
        self.rounding = DIFFERENCED_ROUNDING * largest(base);
    }

    /// Writes the derivative of the acceleration along the k-th deviation.
    ///
    /// # Errors
    /// What the acceleration reports.
    pub fn along(
        &mut self,
        k: usize,
        deviation: [&[f64]; 2],
        acceleration: Acceleration<'_>,
        out: &mut [f64],
    ) -> Result<()> {
        let size = [0, 1].map(|half| largest(deviation[half]) / self.units[half]);
        let size = size[0].max(size[1]);
        if size == 0.0 {
            out.fill(0.0);
            return Ok(());
        }
        let longest = CENTRAL_DIFFERENCE_STEP / size;
        let step_of = |level: i32| longest * DIFFERENCE_RATIO.powi(-level);
        let Length {
            level,
            left,
            is_rough,
            ..
        } = self.lengths[k];
        self.go(step_of(level), deviation, acceleration)?;
        if left > 0 && (is_rough || !self.is_bent(step_of(level))) {
            self.lengths[k].left -= 1;
            let both = self.sides[0].iter().zip(&self.sides[1]);
            for (out, (ahead, behind)) in out.iter_mut().zip(both) {
                *out = (ahead - behind) / (2.0 * step_of(level));
            }
            return Ok(());
        }
        let found = self.quotient(level, step_of(level));
        let Compared {
            found,
            off,
            is_rough,
        } = compared(found, |level| {
            self.go(step_of(level), deviation, acceleration)?;
            Ok(self.quotient(level, step_of(level)))
        })?;
        if off > DOUBTFUL {
            self.lose(k);
        } else {
            self.lengths[k] = Length {
                level: found.level,
                left: if is_rough {
                    ROUGH_PAUSE
                } else {
                    COMPARISON_PAUSE
                },
                is_rough,
                lost_at: None,
            };
        }
        out.copy_from_slice(&found.value);
        Ok(())
    }

    /// No two lengths agree. At a kink or a jump of the motion, to which its steps come as near as their error asks, that is so for a moment;
    /// a rough function is so wherever the motion goes.
    fn lose(&mut self, k: usize) {
        let Self { place, units, .. } = self;
        let own = &mut self.lengths[k];
        let is_far = |from: &[Vec<f64>; 2]| {
            from.iter()
                .zip(place.iter())
                .zip(units.iter())
                .any(|((from, to), unit)| {
                    let mut moved = from.iter().zip(to).map(|(x, y)| (x - y).abs());
                    moved.any(|moved| moved > KINK_DISTANCE * CENTRAL_DIFFERENCE_STEP * *unit)
                })
        };
        if own.lost_at.as_ref().is_some_and(is_far) {
            self.is_doubtful = true;
            *own = Length {
                left: ROUGH_PAUSE,
                is_rough: true,
                ..Length::default()
            };
        } else {
            own.lost_at.get_or_insert_with(|| place.clone());
            (own.level, own.left, own.is_rough) = (KINK_LEVEL, 0, false);
        }
    }

    /// Evaluates the accelerations a step ahead and a step back.
    fn go(
        &mut self,
        step: f64,
        deviation: [&[f64]; 2],
        acceleration: Acceleration<'_>,
    ) -> Result<()> {
        for (side, step) in self.sides.iter_mut().zip([step, -step]) {
            let each = self.place.iter().zip(deviation);
            for (moved, (place, deviation)) in self.moved.iter_mut().zip(each) {
                moved.clear();
                moved.extend(place.iter().zip(deviation).map(|(x, d)| x + step * d));
            }
            acceleration(&self.moved[0], &self.moved[1], side)?;
        }
        Ok(())
    }

    /// The slopes to both sides, entry by entry.
    fn slopes(&self, step: f64) -> impl Iterator<Item = [f64; 2]> {
        let sides = self.sides[0].iter().zip(&self.sides[1]);
        let all = sides.zip(&self.base);
        all.map(move |((ahead, behind), base)| [(ahead - base) / step, (base - behind) / step])
    }

    /// Whether the two one-sided slopes differ.
    fn is_bent(&self, step: f64) -> bool {
        let rounding = self.rounding / step;
        self.slopes(step)
            .any(|[a, b]| (a - b).abs() > BENT_DIFFERENCE * (a.abs() + b.abs()) + rounding)
    }

    /// The quotient of the step last evaluated.
    fn quotient(&self, level: i32, step: f64) -> Quotient {
        let sides = self.sides[0].iter().zip(&self.sides[1]);
        let value = sides.map(|(ahead, behind)| (ahead - behind) / (2.0 * step));
        let size = |side: usize| self.slopes(step).fold(0.0f64, |m, s| m.max(s[side].abs()));
        let smaller = usize::from(size(0) >= size(1));
        Quotient {
            level,
            value: value.collect(),
            one_sided: self.slopes(step).map(|both| both[smaller]).collect(),
            rounding: self.rounding / step,
            is_bent: self.is_bent(step),
        }
    }
}

/// The result of comparing steps: a quotient, the relative difference to that of another step, and whether shorter steps only differ more.
struct Compared {
    found: Quotient,
    off: f64,
    is_rough: bool,
}

/// The longest quotient that a shorter one agrees with; where none do, that which comes nearest to doing so.
fn compared(
    found: Quotient,
    mut quotient: impl FnMut(i32) -> Result<Quotient>,
) -> Result<Compared> {
    let good = |found: Quotient| Compared {
        found,
        off: 0.0,
        is_rough: false,
    };
    if found.level > 0 && !found.is_bent {
        let longer = quotient(found.level - 1)?;
        let is_good = !longer.is_bent && longer.off(&found) <= SAME_DIFFERENCE;
        return Ok(good(if is_good { longer } else { found }));
    }
    let (first, mut longer) = (found.level, found);
    let mut best: Option<Compared> = None;
    for level in first + 1..=DIFFERENCE_LEVELS {
        let shorter = quotient(level)?;
        let off = longer.off(&shorter);
        if off <= SAME_DIFFERENCE {
            return Ok(good(longer));
        }
        match &mut best {
            // What bends is known the better the shorter the step, what is rough the worse.
            Some(best) if off >= 0.5 * best.off => best.is_rough |= best.found.level == first,
            _ => {
                let found = if level == first + 1 {
                    longer
                } else {
                    shorter.clone()
                };
                best = Some(Compared {
                    found,
                    off,
                    is_rough: false,
                });
            }
        }
        longer = shorter;
    }
    if let Some(best) = best.as_mut().filter(|best| best.off > DOUBTFUL) {
        best.found.value.clone_from(&best.found.one_sided);
    }
    Ok(best.unwrap_or_else(|| good(longer)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// The derivatives by v of `f(q, v)` along a motion of places, with whether they are doubted and how often f was asked for each.
    fn along(f: impl Fn(f64, f64) -> f64, places: &[[f64; 2]]) -> (Vec<f64>, bool, f64) {
        let asked = Cell::new(0);
        let acceleration = |q: &[f64], v: &[f64], a: &mut [f64]| {
            asked.set(asked.get() + 1);
            a[0] = f(q[0], v[0]);
            Ok(())
        };
        let mut differences = Differences::new(1, [1.0; 2]);
        let found = places.iter().map(|&[q, v]| {
            differences.begin((&[q], &[v]), &[f(q, v)]);
            let mut out = [0.0];
            let done = differences.along(0, [&[0.0], &[1.0]], &acceleration, &mut out);
            done.expect("no function fails");
            out[0]
        });
        let found = found.collect();
        (
            found,
            differences.is_doubtful,
            f64::from(asked.get()) / places.len() as f64,
        )
    }

    /// Through zero, ever slower towards it, and exactly there.
    fn through_zero() -> Vec<[f64; 2]> {
        let v = (-200..=200).map(|i: i32| {
            let x = f64::from(i) / 200.0;
            x.signum() * x * x * 10f64.powf(-9.0 * (1.0 - x.abs()))
        });
        v.map(|v| [0.7, v]).collect()
    }

    #[test]
    fn steps_follow_the_width_of_what_bends() {
        for width in [1.0, 1e-2, 1e-4, 1e-6, 1e-8] {
            let places = through_zero();
            let (found, is_doubtful, _) = along(|q, v| -q - 0.3 * (v / width).tanh(), &places);
            assert!(!is_doubtful, "{width}");
            for (found, [_, v]) in found.iter().zip(&places) {
                let right = -0.3 / width / (v / width).cosh().powi(2);
                // An acceleration of one, rounded, over the width.
                let allowed = 2e-5 * right.abs() + 1e-9 / width;
                assert!(
                    (found - right).abs() <= allowed,
                    "{width} at {v:e}: {found} {right}"
                );
            }
        }
    }

    #[test]
    fn smooth_functions_cost_no_more_and_are_not_doubted() {
        let functions: [(&str, fn(f64, f64) -> f64); 5] = [
            ("a line", |q, v| 3.0 - 1e5 * q - 0.3 * v),
            ("Duffing", |q, v| -q - 7.0 * q.powi(3) - 0.1 * v * v.abs()),
            ("a pendulum", |q, v| -q.sin() * (1.0 + v * v)),
            ("nothing", |_, _| 0.0),
            ("a stiff spring", |q, v| -1e8 * (q - 0.7) - 10.0 * v),
        ];
        let places: Vec<[f64; 2]> = (0..2000)
            .map(|i| f64::from(i) * 0.01)
            .map(|t| [t.sin() + 0.1, 1.5 * t.cos()])
            .collect();
        for (name, f) in functions {
            let (_, is_doubtful, asked) = along(f, &places);
            assert!(!is_doubtful, "{name}");
            assert!(asked <= 2.2, "{name}: {asked}");
        }
    }

    #[test]
    fn rough_functions_are_doubted_and_jumps_are_seen_from_one_side() {
        // Errors of another iteration's tolerance, as random as the last digits of a large angle's sine.
        let rough = |q: f64, v: f64| -q - 0.3 * v + 1e-7 * (1e12 * v).sin();
        let places: Vec<[f64; 2]> = (0..200).map(|i| [0.3, f64::from(i) * 0.01]).collect();
        let (_, is_doubtful, asked) = along(rough, &places);
        assert!(is_doubtful && asked < 3.0, "{asked}");
        // On a jump itself, and beside it.
        let jump = |_: f64, v: f64| if v > 0.5 { 2.0 - v } else { -3.0 * v };
        for v in [0.5, 0.5 + 1e-7, 0.5 - 1e-7, 0.6] {
            let (found, ..) = along(jump, &[[0.0, v]]);
            let right = if v > 0.5 { -1.0 } else { -3.0 };
            assert!((found[0] - right).abs() < 1e-4, "{v}: {}", found[0]);
        }
    }
}
