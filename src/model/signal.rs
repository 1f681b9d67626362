//! Functions of time in pieces, each a polynomial (theory 11): measured samples, splines, functions by Chebyshev pieces.

use crate::error::{Error, Result};
use crate::model::chebyshev::{CHEBYSHEV_DEGREE, CHEBYSHEV_NODES};
use crate::model::function_pieces::{Layout, PolynomialPiece, polynomial_pieces};
use crate::quantity::finite;
use nalgebra::DMatrix;
use std::sync::Arc;

/// The highest degree of a piece; what needs a higher one is given as several pieces. [work]
const HIGHEST_SIGNAL_DEGREE: usize = 16;

/// A function of time in pieces, each a polynomial; zero before the first and after the last.
///
/// # Examples
/// ```
/// use vibroimpact::Signal;
/// let signal = Signal::samples(&[0.0, 1.0, 3.0], &[0.0, 2.0, 0.0])?;
/// assert_eq!((signal.value(0.5), signal.value(2.0), signal.value(4.0)), (1.0, 1.0, 0.0));
/// # Ok::<(), vibroimpact::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    pieces: Arc<PiecewisePolynomial>,
    /// What is added to the time.
    shift: f64,
    factor: f64,
}

/// The pieces as they were given.
#[derive(Debug, PartialEq)]
struct PiecewisePolynomial {
    /// Where they begin, and where the last one ends.
    breaks: Vec<f64>,
    degree: usize,
    /// The derivatives of orders 0 to the degree where each begins.
    derivatives: Vec<f64>,
    /// The lengths of the shortest and of the longest.
    lengths: [f64; 2],
}

impl Signal {
    /// Straight lines between samples.
    ///
    /// # Errors
    /// Fewer than two samples, as many times as values, numbers that are not finite, times that do not increase.
    pub fn samples(times: &[f64], values: &[f64]) -> Result<Self> {
        if values.len() != times.len() {
            let found = format!("({},)", values.len());
            return Err(Error::bad_shape(
                "values",
                found,
                format!("({},)", times.len()),
            ));
        }
        check_increasing("t", times)?;
        for (i, x) in values.iter().enumerate() {
            finite(&format!("values[{i}]"), *x)?;
        }
        let line = |i: usize| {
            let slope = (values[i + 1] - values[i]) / (times[i + 1] - times[i]);
            finite(&format!("the slope after t[{i}]"), slope).map(|slope| [values[i], slope])
        };
        let lines: Vec<[f64; 2]> = (0..times.len() - 1).map(line).collect::<Result<_>>()?;
        Ok(Self::new(times.to_vec(), 1, lines.concat()))
    }

    /// Polynomials between breakpoints, `sum_k coefficients[(k, i)] (t - breaks[i])^(degree - k)` on the i-th piece, as `PPoly` of
    /// `SciPy` has them: shape `(degree + 1, pieces)`.
    ///
    /// # Errors
    /// Breakpoints that do not increase or are not one more than the pieces, numbers that are not finite, a degree above 16.
    pub fn pieces(breaks: &[f64], coefficients: &DMatrix<f64>) -> Result<Self> {
        check_increasing("breaks", breaks)?;
        let (rows, count) = coefficients.shape();
        if rows == 0 || count + 1 != breaks.len() {
            let expected = format!(
                "(degree + 1, {}): a column for each piece",
                breaks.len() - 1
            );
            return Err(Error::bad_shape(
                "coefficients",
                format!("({rows}, {count})"),
                expected,
            ));
        }
        let degree = rows - 1;
        if degree > HIGHEST_SIGNAL_DEGREE {
            let rule = format!(
                "pieces of a degree up to {HIGHEST_SIGNAL_DEGREE} are taken; use more of them"
            );
            return Err(Error::bad_value("the degree", degree, rule));
        }
        let mut derivatives = Vec::with_capacity(rows * count);
        for i in 0..count {
            let mut factorial = 1.0;
            for m in 0..rows {
                factorial *= m.max(1) as f64;
                let name = || format!("coefficients[{}, {i}]", degree - m);
                let derivative = coefficients[(degree - m, i)] * factorial;
                derivatives.push(finite(&name(), derivative)?);
            }
        }
        Ok(Self::new(breaks.to_vec(), degree, derivatives))
    }

    /// A function on a span by Chebyshev pieces of degree 8, to 1e-14 of its largest value there and what the last place of the time
    /// makes of it. It is asked for its values at many times at once.
    ///
    /// It is looked at all over the span first, and each piece at places of its own: nothing that lasts a thousandth of the span is lost.
    /// What is shorter may be, unless [`from_function_with_breaks`](Self::from_function_with_breaks) says where it is. Kinks are found by
    /// halving, to the last place of the time; jumps are refused.
    ///
    /// # Errors
    /// A span that is empty or not finite, values that are not finite, a function that pieces do not follow to 1e-14, with the place: the
    /// time has none shorter there, or a million are not enough; what the function reports.
    pub fn from_function(
        function: impl FnMut(&[f64]) -> Result<Vec<f64>>,
        span: (f64, f64),
    ) -> Result<Self> {
        Self::from_function_with_breaks(function, span, &[])
    }

    /// [`from_function`](Self::from_function) where it is known at which times the function or a derivative of it jumps: it is taken from
    /// both sides there, and from inside at an end of the span that is among them. The smooth parts between are looked at one by one,
    /// however short.
    ///
    /// # Errors
    /// As [`from_function`](Self::from_function); breaks outside the span or not finite.
    pub fn from_function_with_breaks(
        mut function: impl FnMut(&[f64]) -> Result<Vec<f64>>,
        span: (f64, f64),
        breaks: &[f64],
    ) -> Result<Self> {
        let (start, end) = span;
        if !(start.is_finite() && end.is_finite() && start < end) {
            let rule = "it must be (start, end), finite, with start < end";
            return Err(Error::bad_value("span", format!("({start}, {end})"), rule));
        }
        for (i, &t) in breaks.iter().enumerate() {
            if !(start..=end).contains(&t) {
                let rule = format!("it must lie in the span ({start}, {end})");
                return Err(Error::bad_value(format!("breaks[{i}]"), t, rule));
            }
        }
        // Zero has two signs.
        let mut breaks: Vec<f64> = breaks.iter().map(|t| t + 0.0).collect();
        breaks.sort_by(f64::total_cmp);
        breaks.dedup();
        let layout = Layout {
            breaks: &breaks,
            is_unknown: true,
            ..Layout::of_span((start + 0.0, end + 0.0))
        };
        Self::laid_out(&mut function, layout)
    }

    /// A function laid out in pieces; asks whether to go on.
    ///
    /// # Errors
    /// As [`polynomial_pieces`].
    pub(crate) fn laid_out(
        function: &mut dyn FnMut(&[f64]) -> Result<Vec<f64>>,
        layout: Layout<'_>,
    ) -> Result<Self> {
        let all = polynomial_pieces(function, layout)?;
        let mut breaks: Vec<f64> = all.iter().map(|piece| piece.start).collect();
        breaks.push(layout.span.1);
        let mut derivatives = Vec::with_capacity(CHEBYSHEV_NODES * all.len());
        for PolynomialPiece { start, end, powers } in &all {
            let mut factor = 1.0;
            for (m, power) in powers.iter().enumerate() {
                derivatives.push(factor * power);
                factor *= (m + 1) as f64 / (end - start);
            }
        }
        Ok(Self::new(breaks, CHEBYSHEV_DEGREE, derivatives))
    }

    fn new(breaks: Vec<f64>, degree: usize, derivatives: Vec<f64>) -> Self {
        let lengths = breaks.windows(2).map(|b| b[1] - b[0]);
        let shortest_and_longest = lengths.fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], x| {
            [a.min(x), b.max(x)]
        });
        Self {
            pieces: Arc::new(PiecewisePolynomial {
                breaks,
                degree,
                derivatives,
                lengths: shortest_and_longest,
            }),
            shift: 0.0,
            factor: 1.0,
        }
    }

    /// Its breakpoints, degree, derivatives where the pieces begin, what is added to the time, and the factor: all there is to know.
    #[cfg(feature = "python")]
    pub(crate) fn parts(&self) -> (&[f64], usize, &[f64], f64, f64) {
        let PiecewisePolynomial {
            breaks,
            degree,
            derivatives,
            ..
        } = &*self.pieces;
        (breaks, *degree, derivatives, self.shift, self.factor)
    }

    /// A signal from its [`parts`](Self::parts).
    ///
    /// # Errors
    /// Parts that do not fit together, numbers that are not finite.
    #[cfg(feature = "python")]
    pub(crate) fn from_parts(
        breaks: Vec<f64>,
        degree: usize,
        derivatives: Vec<f64>,
        (shift, factor): (f64, f64),
    ) -> Result<Self> {
        check_increasing("breaks", &breaks)?;
        let needed = degree.saturating_add(1).saturating_mul(breaks.len() - 1);
        if degree > HIGHEST_SIGNAL_DEGREE || derivatives.len() != needed {
            let found = format!("({},)", derivatives.len());
            let expected = format!("({needed},)");
            return Err(Error::bad_shape("derivatives", found, expected));
        }
        if let Some(i) = derivatives.iter().position(|x| !x.is_finite()) {
            let name = format!("derivatives[{i}]");
            return Err(Error::bad_value(name, derivatives[i], "it must be finite"));
        }
        Ok(Self {
            shift: finite("shift", shift)?,
            factor: finite("factor", factor)?,
            ..Self::new(breaks, degree, derivatives)
        })
    }

    /// Where the first piece begins and the last one ends.
    pub fn span(&self) -> (f64, f64) {
        let breaks = &self.pieces.breaks;
        (
            breaks[0] - self.shift,
            breaks[breaks.len() - 1] - self.shift,
        )
    }

    /// Where the pieces begin, and where the last one ends.
    pub fn breaks(&self) -> impl Iterator<Item = f64> + Clone {
        self.pieces.breaks.iter().map(|t| t - self.shift)
    }

    /// The degree of the polynomials.
    pub fn degree(&self) -> usize {
        self.pieces.degree
    }

    /// The coefficients of each piece in powers of the time since it began, the highest first: shape `(degree + 1, pieces)`.
    pub fn coefficients(&self) -> DMatrix<f64> {
        let PiecewisePolynomial {
            degree,
            derivatives,
            ..
        } = &*self.pieces;
        let factorials = (1..=*degree).scan(1.0, |product, m| {
            *product *= m as f64;
            Some(*product)
        });
        let factorials: Vec<f64> = std::iter::once(1.0).chain(factorials).collect();
        DMatrix::from_fn(degree + 1, derivatives.len() / (degree + 1), |k, i| {
            let m = degree - k;
            self.factor * derivatives[i * (degree + 1) + m] / factorials[m]
        })
    }

    /// The value at a time; where two pieces meet, that of the later; NaN where the time is.
    pub fn value(&self, t: f64) -> f64 {
        if t.is_nan() {
            return t;
        }
        let mut value = 0.0;
        self.derivatives(t, t, |m, derivative| {
            if m == 0 {
                value = derivative;
            }
        });
        value
    }

    /// Value and slope before and after the k-th breakpoint, zero outside.
    fn sides(&self, k: usize) -> [[f64; 2]; 2] {
        let PiecewisePolynomial { breaks, .. } = &*self.pieces;
        let mut sides = [[0.0; 2]; 2];
        let mut put = |side: usize, piece: usize, local: f64| {
            self.pieces.after_start(piece, local, |m, x| {
                if m < 2 {
                    sides[side][m] = x;
                }
            });
        };
        if k > 0 {
            put(0, k - 1, breaks[k] - breaks[k - 1]);
        }
        if k + 1 < breaks.len() {
            put(1, k, 0.0);
        }
        sides
    }

    /// The sizes of the terms of value and slope, the largest of all pieces.
    pub(crate) fn largest(&self) -> [f64; 2] {
        let PiecewisePolynomial {
            breaks,
            degree,
            derivatives,
            ..
        } = &*self.pieces;
        let mut largest = [0.0f64; 2];
        for (piece, ends) in derivatives.chunks(degree + 1).zip(breaks.windows(2)) {
            let sizes: Vec<f64> = piece.iter().map(|x| x.abs()).collect();
            for (m, largest) in largest.iter_mut().enumerate() {
                let size = taylor(sizes.get(m..).unwrap_or(&[]), ends[1] - ends[0]);
                *largest = largest.max(size);
            }
        }
        largest
    }

    /// The first breakpoint but the ends at which the value, or the slope, jumps by more than a part of the largest.
    pub(crate) fn first_kink(&self, part: f64) -> Option<f64> {
        let [value, slope] = self.largest();
        let jumps = |k: &usize| {
            let [before, after] = self.sides(*k);
            (after[0] - before[0]).abs() > part * value
                || (after[1] - before[1]).abs() > part * slope
        };
        let inner = 1..self.pieces.breaks.len() - 1;
        inner
            .into_iter()
            .find(jumps)
            .map(|k| self.pieces.breaks[k] - self.shift)
    }

    /// Whether it begins and ends at rest at zero, to a part of its largest value and slope.
    pub(crate) fn rests_at_ends(&self, part: f64) -> [bool; 2] {
        let [value, slope] = self.largest();
        let rests = |side: [f64; 2]| side[0].abs() <= part * value && side[1].abs() <= part * slope;
        let last = self.pieces.breaks.len() - 1;
        [rests(self.sides(0)[1]), rests(self.sides(last)[0])]
    }

    /// The derivative, piece by piece.
    pub(crate) fn derivative(&self) -> Self {
        let PiecewisePolynomial {
            breaks,
            degree,
            derivatives,
            ..
        } = &*self.pieces;
        let mut lowered = Vec::new();
        for piece in derivatives.chunks(degree + 1) {
            lowered.extend_from_slice(if *degree == 0 { &[0.0] } else { &piece[1..] });
        }
        Self {
            shift: self.shift,
            factor: self.factor,
            ..Self::new(breaks.clone(), degree.saturating_sub(1), lowered)
        }
    }

    /// Hands out the derivatives at a time, of orders 0 to the degree, on the piece that holds for a step that began at another;
    /// nothing outside the pieces, where all are zero.
    pub(crate) fn derivatives(&self, since: f64, t: f64, mut put: impl FnMut(usize, f64)) {
        if let Some((piece, local)) = self.piece_at(since, t) {
            (self.pieces).after_start(piece, local, |m, x| put(m, self.factor * x));
        }
    }

    /// The piece that holds for a step that began at a time, and how long after its start another time is; none outside.
    fn piece_at(&self, since: f64, t: f64) -> Option<(usize, f64)> {
        let breaks = &self.pieces.breaks;
        let begun = breaks.partition_point(|b| *b <= since + self.shift);
        (begun > 0 && begun < breaks.len())
            .then(|| (begun - 1, (t + self.shift) - breaks[begun - 1]))
    }

    /// The value at a time, and the size of the terms that it is a sum of, on the piece that holds for a step that began at another.
    pub(crate) fn value_with_size(&self, since: f64, t: f64) -> (f64, f64) {
        let Some((piece, local)) = self.piece_at(since, t) else {
            return (0.0, 0.0);
        };
        let given = self.pieces.given(piece);
        let (mut value, mut size) = (0.0, 0.0);
        for (m, derivative) in given.iter().enumerate().rev() {
            let step = local / (m + 1) as f64;
            value = derivative + step * value;
            size = derivative.abs() + step.abs() * size;
        }
        (self.factor * value, self.factor.abs() * size)
    }

    /// The lengths of the shortest and of the longest piece.
    pub(crate) fn piece_lengths(&self) -> [f64; 2] {
        self.pieces.lengths
    }

    /// What is left, from a time on, of the piece that holds for a step that began at another; zero outside.
    pub(crate) fn rest_of_piece(&self, since: f64, t: f64) -> f64 {
        let breaks = &self.pieces.breaks;
        let left = |(piece, local): (usize, f64)| breaks[piece + 1] - breaks[piece] - local;
        self.piece_at(since, t).map_or(0.0, left).max(0.0)
    }

    /// The same signal so much earlier.
    pub(crate) fn earlier(&self, span: f64) -> Self {
        Self {
            shift: self.shift + span,
            ..self.clone()
        }
    }

    /// The same signal times a number.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Self {
            factor: self.factor * factor,
            ..self.clone()
        }
    }

    /// Whether it is zero at all times.
    pub(crate) fn is_zero(&self) -> bool {
        let mut derivatives = self.pieces.derivatives.iter();
        self.factor == 0.0 || derivatives.all(|x| *x == 0.0)
    }

    /// Whether all of it is finite.
    pub(crate) fn is_finite(&self) -> bool {
        let mut derivatives = self.pieces.derivatives.iter();
        derivatives.all(|x| (self.factor * x).is_finite())
    }
}

impl PiecewisePolynomial {
    /// The derivatives where a piece begins.
    fn given(&self, piece: usize) -> &[f64] {
        let n = self.degree + 1;
        &self.derivatives[piece * n..(piece + 1) * n]
    }

    /// Hands out the derivatives of a piece so long after its start.
    fn after_start(&self, piece: usize, local: f64, mut put: impl FnMut(usize, f64)) {
        let given = self.given(piece);
        for m in 0..=self.degree {
            put(m, taylor(&given[m..], local));
        }
    }
}

/// `sum_k derivatives[k] s^k/k!`
pub(crate) fn taylor(derivatives: &[f64], s: f64) -> f64 {
    let terms = derivatives.iter().enumerate().rev();
    terms.fold(0.0, |sum, (k, derivative)| {
        derivative + s / (k + 1) as f64 * sum
    })
}

/// Breakpoints that increase, two of them at least.
fn check_increasing(argument: &str, times: &[f64]) -> Result<()> {
    if times.len() < 2 {
        let found = format!("({},)", times.len());
        return Err(Error::bad_shape(argument, found, "(m,), m >= 2"));
    }
    for (i, t) in times.iter().enumerate() {
        finite(&format!("{argument}[{i}]"), *t)?;
    }
    match times.windows(2).position(|pair| pair[0] >= pair[1]) {
        None => Ok(()),
        Some(i) => {
            let rule = format!("it must be later than {argument}[{i}], {}", times[i]);
            Err(Error::bad_value(
                format!("{argument}[{}]", i + 1),
                times[i + 1],
                rule,
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn pieces_are_their_polynomials_and_zero_outside() {
        // 1 + 2 (t - 1) + 3 (t - 1)^2, then -4 + (t - 2)^2
        let signal = Signal::pieces(&[1.0, 2.0, 4.0], &dmatrix![3.0, 1.0; 2.0, 0.0; 1.0, -4.0]);
        let signal = signal.expect("valid");
        assert_eq!(signal.span(), (1.0, 4.0));
        for (t, value) in [
            (0.9, 0.0),
            (1.0, 1.0),
            (1.5, 2.75),
            (2.0, -4.0),
            (3.0, -3.0),
            (4.0, 0.0),
        ] {
            assert_eq!(signal.value(t), value, "{t}");
        }
        let mut found = Vec::new();
        signal.derivatives(1.0, 2.0, |_, x| found.push(x));
        assert_eq!(found, [6.0, 8.0, 6.0]);
        // Earlier by one half, and twice as large.
        let moved = signal.earlier(0.5).scaled(2.0);
        assert_eq!((moved.value(1.0), moved.span()), (5.5, (0.5, 3.5)));
        assert_eq!(
            moved.coefficients(),
            dmatrix![6.0, 2.0; 4.0, 0.0; 2.0, -8.0]
        );
        let (value, size) = signal.value_with_size(2.0, 3.0);
        assert_eq!((value, size), (-3.0, 5.0));
    }

    #[test]
    fn jumps_of_value_and_slope_are_seen() {
        let kink = |breaks: &[f64], c: &DMatrix<f64>| {
            Signal::pieces(breaks, c).expect("valid").first_kink(1e-9)
        };
        // t^2 (1 - t)^2 joins zero smoothly at both ends.
        let bump = dmatrix![1.0; -2.0; 1.0; 0.0; 0.0];
        let signal = Signal::pieces(&[0.0, 1.0], &bump).expect("valid");
        assert_eq!(
            (signal.first_kink(1e-9), signal.rests_at_ends(1e-9)),
            (None, [true; 2])
        );
        assert_eq!(
            kink(&[0.0, 1.0, 2.0], &dmatrix![1.0, -1.0; 0.0, 1.0]),
            Some(1.0)
        );
        assert_eq!(
            kink(&[0.0, 1.0, 2.0], &dmatrix![1.0, 2.0; 0.0, 1.0]),
            Some(1.0)
        );
        assert_eq!(kink(&[0.0, 1.0, 2.0], &dmatrix![1.0, 2.0]), Some(1.0));
        let parabolas = dmatrix![1.0, -1.0; 0.0, 2.0; 0.0, 1.0];
        assert_eq!(kink(&[0.0, 1.0, 2.0], &parabolas), None);
        let signal = Signal::pieces(&[0.0, 1.0, 2.0], &parabolas).expect("valid");
        assert_eq!(signal.rests_at_ends(1e-9), [true, false]);
        assert_eq!(
            signal.derivative().coefficients(),
            dmatrix![2.0, -2.0; 0.0, 2.0]
        );
    }

    #[test]
    fn what_is_no_signal_is_refused_by_name() {
        let message = |signal: Result<Signal>| signal.expect_err("refused").to_string();
        let samples = |t: &[f64], x: &[f64]| message(Signal::samples(t, x));
        assert!(samples(&[0.0], &[1.0]).starts_with("t has shape (1,)"));
        assert!(samples(&[0.0, 1.0], &[1.0]).starts_with("values has shape (1,)"));
        assert!(samples(&[0.0, 0.0], &[1.0, 2.0]).starts_with("t[1] is 0, but it must be later"));
        assert!(samples(&[0.0, f64::NAN], &[1.0, 2.0]).starts_with("t[1] is NaN"));
        assert!(samples(&[0.0, 1.0], &[1.0, f64::INFINITY]).starts_with("values[1] is inf"));
        let pieces = |b: &[f64], c: &DMatrix<f64>| message(Signal::pieces(b, c));
        assert!(pieces(&[0.0, 1.0, 2.0], &dmatrix![1.0]).contains("(degree + 1, 2)"));
        assert!(pieces(&[0.0, 1.0], &DMatrix::zeros(18, 1)).starts_with("the degree is 17"));
        assert!(
            pieces(&[0.0, 1.0], &dmatrix![1.0; f64::NAN]).starts_with("coefficients[1, 0] is NaN")
        );
    }
}
