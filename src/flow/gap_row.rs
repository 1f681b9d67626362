//! A plane gap `clearance - row.z` \[m\] along a linear flow, z being the pairs of the flow's state: its cubic model from the derivatives
//! of the state, and the weights that bound its remainder (theory 8).

use crate::flow::gap_model::GapModel;
use crate::flow::samples::{SAMPLES_AT_ONCE, SampleDerivatives, SampleModels, eight};
use crate::law::LinearForce;
use crate::modal::Pair;
use crate::model::GapMotion;
use crate::quantity::larger;
use crate::tolerance::{GAP_ROUNDING, SUM_ROUNDINGS, TERM_ROUNDINGS};
use nalgebra::Complex;

/// A quantity of the whole motion, `constant - row.z - Re sum_k forcing_k u_k - sum_j signals_j s_j(t)`, by the phasors and the signals of
/// an excitation: a gap, or a contact force.
#[derive(Debug, Clone, Default)]
pub(crate) struct Quantity {
    pub constant: f64,
    /// Size of the terms that the constant was summed from.
    pub size: f64,
    pub row: Vec<Pair>,
    /// Empty where no harmonic enters it directly.
    pub forcing: Vec<Complex<f64>>,
    /// The factor of each signal, shape `(n_signals,)` or less, \[-\] in units of the quantity per unit of the signal; empty where no
    /// signal enters it directly.
    pub signals: Vec<f64>,
}

impl Quantity {
    /// A gap of a stop at rest: the forcing does not enter it directly.
    pub fn gap(clearance: f64, row: &[Pair]) -> Self {
        Self {
            constant: clearance,
            size: clearance.abs(),
            row: row.to_vec(),
            ..Self::default()
        }
    }

    /// The same with the motion of the stop itself added.
    pub fn widened_by(mut self, motion: &GapMotion) -> Self {
        self.constant += motion.mean;
        self.size += motion.mean.abs();
        self.forcing = motion.amplitudes.iter().map(|a| -a).collect();
        if let Some((place, _)) = motion.signal {
            self.signals = vec![0.0; place + 1];
            self.signals[place] = -1.0;
        }
        self
    }

    /// Its opposite.
    pub fn opposite(&self) -> Self {
        Self {
            constant: -self.constant,
            size: self.size,
            row: self.row.iter().map(|&[q, v]| [-q, -v]).collect(),
            forcing: self.forcing.iter().map(|a| -a).collect(),
            signals: self.signals.iter().map(|factor| -factor).collect(),
        }
    }

    /// What it leaves of a constant.
    pub fn left_of(&self, most: f64) -> Self {
        let opposite = self.opposite();
        Self {
            constant: most + opposite.constant,
            size: most + opposite.size,
            ..opposite
        }
    }

    /// Of a gap, with its opening speed as a row: the force `F0 - k h - c h'`, times a sign, of which the rate of what moves the gap by itself
    /// is left out.
    pub fn pressed(&self, speed: &[Pair], force: LinearForce, sign: f64) -> Self {
        let [k, c] = [sign * force.stiffness, sign * force.damping];
        let rows = self.row.iter().zip(speed);
        Self {
            constant: sign * force.preload - k * self.constant,
            size: force.preload + k.abs() * self.size,
            row: rows
                .map(|(p, v)| [0, 1].map(|i| -k * p[i] - c * v[i]))
                .collect(),
            forcing: self.forcing.iter().map(|a| -a * k).collect(),
            signals: self.signals.iter().map(|a| -a * k).collect(),
        }
    }

    /// The amplitude of each harmonic of the forcing in it, followed by zeros.
    pub fn harmonics(&self) -> impl Iterator<Item = Complex<f64>> {
        let zeros = std::iter::repeat(Complex::new(0.0, 0.0));
        self.forcing.iter().copied().chain(zeros)
    }

    /// The factor of each signal in it, followed by zeros.
    pub fn signals(&self) -> impl Iterator<Item = f64> {
        self.signals.iter().copied().chain(std::iter::repeat(0.0))
    }

    /// Whether a harmonic or a signal enters it directly.
    pub fn changes_by_itself(&self) -> bool {
        let turns = self.forcing.iter().any(|f| f.norm() > 0.0);
        turns || self.signals.iter().any(|s| *s != 0.0)
    }

    /// A bound on what the harmonics add.
    pub fn amplitude(&self) -> f64 {
        self.forcing.iter().map(|f| f.norm()).sum()
    }
}

/// One pair of a state and its first three time derivatives, with the bound on what is left.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Derivatives {
    pub z: Pair,
    pub d1: Pair,
    pub d2: Pair,
    pub d3: Pair,
    /// A bound on the third derivative in the norm of the pair's block.
    pub norm: f64,
}

impl Derivatives {
    /// The pair after a short step, by its Taylor series.
    #[inline]
    pub fn after(&self, step: f64) -> Pair {
        [0, 1].map(|c| {
            let third = self.d2[c] + step * (1.0 / 3.0) * self.d3[c];
            self.z[c] + step * (self.d1[c] + 0.5 * step * third)
        })
    }
}

/// The part of one pair of the state in a gap.
#[derive(Debug, Clone, Copy)]
struct GapTerm {
    row: Pair,
    /// Bound on what one unit of the third derivative's norm adds to the gap's fourth derivative.
    weight: f64,
    /// Bound on what one unit of the pair's norm adds to the gap; infinite where the norm may grow.
    reach: f64,
}

/// The gap of one stop in pairs of the state, with the weights of its remainder.
#[derive(Debug, Clone)]
pub(crate) struct GapRow {
    cells: Vec<GapTerm>,
    clearance: f64,
    /// Size of the terms that the clearance was summed from.
    size: f64,
    /// The gap where every pair rests, and the size of its terms.
    rest: (f64, f64),
    /// Bound on the forcing's own part of the fourth derivative, constant and growing with time.
    forced: f64,
    forced_growth: f64,
    /// The pairs that decay without turning, without weights: their places, and rows whose sizes on the third derivative bound what
    /// they add to the gap's fourth from then on.
    decaying: Vec<(usize, [Pair; 2])>,
    /// Sizes of the terms that what turns with the forcing is a sum of, by its cosine and its sine: the last pair, where it is one.
    turning: Option<Pair>,
    /// The same of several harmonics, the last pairs: their sizes are in that of the clearance.
    harmonics: Vec<Pair>,
    /// Rounding relative to the sum of the sizes of all parts of the motion in it.
    relative: f64,
    /// Whether nothing happens where it stays at zero.
    may_settle: bool,
}

impl GapRow {
    /// A gap from one `(row, weight, reach)` for each pair: the weight in the bound on the fourth derivative, that in the
    /// bound on the gap over all times to come. `clearance` and `size` are the gap and the size of its terms where every
    /// pair is zero, `rest` the same where every norm is zero; `forced` are the bounds on the forcing's own part of the fourth
    /// derivative, constant and growing with time.
    pub fn new(
        cells: impl Iterator<Item = (Pair, f64, f64)>,
        (clearance, size): (f64, f64),
        rest: (f64, f64),
        (forced, forced_growth): (f64, f64),
    ) -> Self {
        let cells = cells.map(|(row, weight, reach)| GapTerm { row, weight, reach });
        Self {
            cells: cells.collect(),
            clearance,
            size,
            rest,
            forced,
            forced_growth,
            decaying: Vec::new(),
            turning: None,
            harmonics: Vec::new(),
            relative: SUM_ROUNDINGS,
            may_settle: false,
        }
    }

    /// With nothing that happens where it stays at zero, as with the approach into a stop at which a body comes to rest.
    pub fn that_may_settle(mut self) -> Self {
        self.may_settle = true;
        self
    }

    /// Whether nothing comes of it at any later time: it stays above zero, or at zero where that is nothing.
    pub fn is_beyond_reach(&self, norms: &[f64]) -> bool {
        let (least, size) = self.least(norms);
        // Of a motion that nothing bounds the size is infinite.
        let is_settled = || self.most(norms) <= GAP_ROUNDING * self.rest.1;
        least > GAP_ROUNDING * size || self.may_settle && is_settled()
    }

    /// With pairs that decay without turning, by their places, and the rows that bound what they add to the fourth derivative.
    pub fn with_decaying(mut self, decaying: Vec<(usize, [Pair; 2])>) -> Self {
        self.decaying = decaying;
        self
    }

    /// With rows that are known only to this part of the sizes of their terms.
    pub fn known_to(mut self, relative: f64) -> Self {
        self.relative = relative;
        self
    }

    /// With last pairs `(cos, sin)` of the forcing's angles, whose parts of the gap are sums of terms of these sizes, though the rows on
    /// them may be smaller. Several are known to their amplitudes only.
    pub fn with_turning(mut self, terms: Vec<Pair>) -> Self {
        let whole = terms.iter().map(|[a, b]| a + b).sum::<f64>();
        self.rest.1 += whole;
        if let [one] = terms[..] {
            self.turning = Some(one);
        } else {
            self.size += whole;
            self.harmonics = terms;
        }
        self
    }

    /// The same with the terms that turn with the forcing counted by their amplitudes, whatever their values are: a force that begins slowly
    /// from zero is for a while a small difference of large terms, and known to the rounding of these.
    pub fn with_whole_turning(mut self) -> Self {
        let [by_cos, by_sin] = self.turning.unwrap_or_default();
        self.size += by_cos + by_sin;
        self
    }

    /// What rounding leaves unknown of what turns with the forcing, in its second derivative.
    pub fn acceleration_lost(&self, derivatives: &[Derivatives]) -> f64 {
        let terms = self.turning.as_slice().iter().chain(&self.harmonics);
        let count = terms.clone().count();
        let last = &derivatives[derivatives.len().saturating_sub(count)..];
        let lost = |(terms, d): (&Pair, &Derivatives)| {
            SUM_ROUNDINGS * (terms[0] * d.d2[0].abs() + terms[1] * d.d2[1].abs())
        };
        terms.zip(last).map(lost).sum()
    }

    /// How near zero the gap can come at any later time, from the norms of the state's pairs; and a bound on the size of
    /// its terms.
    pub fn least(&self, norms: &[f64]) -> (f64, f64) {
        let moved = self.moved(norms);
        (self.rest.0 - moved, self.rest.1 + moved)
    }

    /// How far from zero the gap can come at any later time.
    pub fn most(&self, norms: &[f64]) -> f64 {
        self.rest.0.abs() + self.moved(norms)
    }

    /// How far from its rest the gap can come at any later time; no number where nothing bounds what rests now.
    fn moved(&self, norms: &[f64]) -> f64 {
        debug_assert_eq!(norms.len(), self.cells.len(), "a norm for every pair");
        self.cells.iter().zip(norms).map(|(c, x)| c.reach * x).sum()
    }

    /// What rounding leaves unknown of a gap: that of its two terms, the clearance and the position along the normal, and where
    /// the parts of the motion cancel that of their sum.
    #[inline]
    pub fn rounding(&self, model: &GapModel) -> f64 {
        let terms = self.clearance.abs() + (self.clearance - model.c[0]).abs();
        larger(TERM_ROUNDINGS * terms, self.relative * model.size)
    }

    /// A bound on [`rounding`](Self::rounding) in parts of the size of all terms of the gap, of which the clearance and the position are
    /// sums.
    pub fn relative_rounding(&self) -> f64 {
        TERM_ROUNDINGS.max(self.relative)
    }

    /// What rounding leaves unknown of a gap at the end of a short step: at a start from rest at zero the terms grow from zero.
    pub fn rounding_after(&self, derivatives: &[Derivatives], step: f64) -> f64 {
        self.relative * self.size_of(derivatives, |d| d.after(step))
    }

    /// Size of the terms of the gap's speed.
    pub fn speed_size(&self, derivatives: &[Derivatives]) -> f64 {
        self.size_of(derivatives, |d| d.d1)
    }

    /// Size of the terms of the gap's acceleration, now or in a time in which a motion of the given rate changes.
    pub fn acceleration_size(&self, derivatives: &[Derivatives], rate: f64) -> f64 {
        let now = self.size_of(derivatives, |d| d.d2);
        now.max(self.jerk_size(derivatives) / rate)
    }

    /// Size of the terms of the gap's third derivative.
    pub fn jerk_size(&self, derivatives: &[Derivatives]) -> f64 {
        self.size_of(derivatives, |d| d.d3)
    }

    fn size_of(&self, derivatives: &[Derivatives], order: impl Fn(&Derivatives) -> Pair) -> f64 {
        let terms = |(GapTerm { row: r, .. }, d): (&GapTerm, &Derivatives)| {
            let x = order(d);
            (r[0] * x[0]).abs() + (r[1] * x[1]).abs()
        };
        self.cells.iter().zip(derivatives).map(terms).sum()
    }

    /// The gap's models at eight samples.
    #[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
    #[inline(always)]
    pub fn models(&self, samples: &[SampleDerivatives]) -> SampleModels {
        let [mut gap, mut quartic, mut size] =
            [self.clearance, self.forced, self.size].map(|x| [x; SAMPLES_AT_ONCE]);
        let [mut slope, mut bend, mut third] = [[0.0; SAMPLES_AT_ONCE]; 3];
        for (GapTerm { row, weight, .. }, d) in self.cells.iter().zip(samples) {
            gap = eight(|k| gap[k] - (row[0] * d.z[0][k] + row[1] * d.z[1][k]));
            slope = eight(|k| slope[k] - (row[0] * d.d1[0][k] + row[1] * d.d1[1][k]));
            bend = eight(|k| bend[k] - (row[0] * d.d2[0][k] + row[1] * d.d2[1][k]));
            third = eight(|k| third[k] - (row[0] * d.d3[0][k] + row[1] * d.d3[1][k]));
            quartic = eight(|k| quartic[k] + weight * d.norm[k]);
            let terms = |k: usize| (row[0] * d.z[0][k]).abs() + (row[1] * d.z[1][k]).abs();
            size = eight(|k| size[k] + terms(k));
        }
        for (place, [slow, fast]) in &self.decaying {
            let [x, y] = &samples[*place].d3;
            let share = |row: &Pair, k: usize| (row[0] * x[k] + row[1] * y[k]).abs();
            quartic = eight(|k| quartic[k] + share(slow, k) + share(fast, k));
        }
        if let (Some(terms), Some(d)) = (self.turning, samples.last()) {
            let [cos, sin] = &d.z;
            size = eight(|k| size[k] + turning_size(terms, [cos[k], sin[k]]));
        }
        SampleModels {
            c: [
                gap,
                slope,
                eight(|k| 0.5 * bend[k]),
                eight(|k| third[k] * (1.0 / 6.0)),
            ],
            quartic: eight(|k| quartic[k] * (1.0 / 24.0)),
            quintic: self.forced_growth * (1.0 / 120.0),
            size,
            extent: [0.0; 2],
        }
    }

    /// The gap's model.
    #[inline]
    pub fn model(&self, derivatives: &[Derivatives]) -> GapModel {
        let mut c = [self.clearance, 0.0, 0.0, 0.0];
        let (mut quartic, mut size) = (self.forced, self.size);
        for (GapTerm { row: r, weight, .. }, d) in self.cells.iter().zip(derivatives) {
            let terms = [r[0] * d.z[0], r[1] * d.z[1]];
            c[0] -= terms[0] + terms[1];
            c[1] -= r[0] * d.d1[0] + r[1] * d.d1[1];
            c[2] -= r[0] * d.d2[0] + r[1] * d.d2[1];
            c[3] -= r[0] * d.d3[0] + r[1] * d.d3[1];
            quartic += weight * d.norm;
            size += terms[0].abs() + terms[1].abs();
        }
        for (place, [slow, fast]) in &self.decaying {
            let [x, y] = derivatives[*place].d3;
            quartic += (slow[0] * x + slow[1] * y).abs() + (fast[0] * x + fast[1] * y).abs();
        }
        if let (Some(terms), Some(d)) = (self.turning, derivatives.last()) {
            size += turning_size(terms, d.z);
        }
        GapModel {
            c: [c[0], c[1], 0.5 * c[2], c[3] * (1.0 / 6.0)],
            quartic: quartic * (1.0 / 24.0),
            quintic: self.forced_growth * (1.0 / 120.0),
            size,
        }
    }
}

/// The size of what turns with the forcing, from those of its terms. Angles are counted from a whole turn: the sine has its digits near
/// that, and half a turn away it has few.
#[allow(clippy::inline_always, reason = "compiled for each kind of registers")]
#[inline(always)]
fn turning_size([by_cos, by_sin]: Pair, [cos, sin]: Pair) -> f64 {
    by_cos + by_sin * (sin.abs() + 0.5 * (cos.abs() - cos))
}
