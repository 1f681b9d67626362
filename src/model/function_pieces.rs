//! Piecewise polynomial approximation of a function, to a part of its largest value (theory 11): an interval is halved until the polynomial
//! through its nodes is the function at check points between them, and at the samples of the whole span that were taken first.

use crate::error::{Error, Result};
use crate::model::chebyshev::{
    CHEBYSHEV_NODES, GOLDEN_FRACTION, SAMPLE_POINTS, SampledPiece, coefficients, line, powers,
    steepest, sum,
};
use crate::observer::Observer;
use crate::tolerance::{
    BREAK_SIDE_ROUNDINGS, CORNER_ERROR_FACTOR, CORNER_PIECE_LENGTH, FUNCTION_JUMP,
    FUNCTION_SAMPLES, FUNCTION_TOL, MOST_FUNCTION_PIECES, ROUGH_FUNCTION, ROUGH_HALVING,
    SAMPLE_TIME_ROUNDINGS,
};

/// Pieces that are sampled between two questions whether to go on. [work]
const PIECES_AT_ONCE: usize = 256;

/// A function of many times at once.
type Function<'a> = &'a mut dyn FnMut(&[f64]) -> Result<Vec<f64>>;

/// A piece of a function: its coefficients in powers of the part of it that has passed.
pub(crate) struct PolynomialPiece {
    pub start: f64,
    pub end: f64,
    pub powers: [f64; CHEBYSHEV_NODES],
}

/// The span of a function, and what is known of the function on it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout<'a> {
    /// Start and end.
    pub span: (f64, f64),
    /// The times, ascending, shape `(n_breaks,)`, [s], at which the function or a derivative of it jumps: it is evaluated on either side of
    /// them. Some may be ends of the span.
    pub breaks: &'a [f64],
    /// The size of its terms, of which its largest value may be a small part.
    pub size: f64,
    /// The error of the values of the function, zero where it is their rounding.
    pub known_to: f64,
    /// Whether nothing is known of how long its features last, so that the whole of it is looked at beforehand.
    pub is_unknown: bool,
}

impl Layout<'_> {
    /// The layout of a function without breaks that is known to its rounding.
    pub fn of_span(span: (f64, f64)) -> Self {
        Self {
            span,
            breaks: &[],
            size: 0.0,
            known_to: 0.0,
            is_unknown: false,
        }
    }

    /// The intervals between breaks.
    fn smooth_intervals(&self) -> Vec<FitInterval> {
        let (start, end) = self.span;
        let inner = self.breaks.iter().copied();
        let inner = inner.filter(|b| *b > start && *b < end);
        let ends: Vec<f64> = std::iter::once(start).chain(inner).chain([end]).collect();
        let part = |ends: &[f64]| FitInterval {
            start: ends[0],
            end: ends[1],
            smooth_length: ends[1] - ends[0],
            parent_error: f64::INFINITY,
        };
        ends.windows(2).map(part).collect()
    }

    /// How far inside the two ends of an interval the function is evaluated: at an end itself, unless it is a break.
    fn beside(&self, part: &FitInterval) -> [f64; 2] {
        let last_places =
            BREAK_SIDE_ROUNDINGS * f64::EPSILON * part.start.abs().max(part.end.abs());
        let is_break = |t: f64| self.breaks.binary_search_by(|b| b.total_cmp(&t)).is_ok();
        [part.start, part.end].map(|t| if is_break(t) { last_places } else { 0.0 })
    }

    /// Sample times all over the span, in order.
    fn sample_times(&self) -> Vec<f64> {
        let (start, end) = self.span;
        let place = |i: usize| i as f64 + (GOLDEN_FRACTION * (i + 1) as f64).fract();
        (0..FUNCTION_SAMPLES)
            .map(|i| start + (end - start) * (place(i) / FUNCTION_SAMPLES as f64))
            .collect()
    }
}

/// An interval that is to be one piece.
#[derive(Debug, Clone, Copy)]
struct FitInterval {
    start: f64,
    end: f64,
    /// The length of the interval between breaks in which it lies.
    smooth_length: f64,
    /// The error of the polynomial on the interval of which this is a half.
    parent_error: f64,
}

impl FitInterval {
    fn middle(&self) -> f64 {
        0.5 * self.start + 0.5 * self.end
    }

    fn halves(&self, parent_error: f64) -> [Self; 2] {
        let middle = self.middle();
        let half = Self {
            parent_error,
            ..*self
        };
        let (mut first, mut second) = (half, half);
        (first.end, second.start) = (middle, middle);
        [first, second]
    }

    /// Whether no time lies inside.
    fn is_too_short(&self) -> bool {
        let middle = self.middle();
        let is_inside = self.start < middle && middle < self.end;
        !is_inside || self.end - self.start <= f64::EPSILON * f64::EPSILON * self.smooth_length
    }
}

/// The approximation of a function by pieces, under way.
struct PiecewiseFit<'a> {
    layout: Layout<'a>,
    function: Function<'a>,
    observer: Observer,
    /// Times and values of samples over the whole span, empty where its features are known to last long.
    samples: [Vec<f64>; 2],
    /// The largest slope between those samples.
    steepest: f64,
    largest: f64,
}

/// The pieces of a function, in order; asks from time to time whether to go on.
///
/// # Errors
/// What the function reports, values that are not finite, a function that `MOST_FUNCTION_PIECES` pieces do not follow; `Error::Interrupted`.
pub(crate) fn polynomial_pieces(
    function: Function<'_>,
    layout: Layout<'_>,
) -> Result<Vec<PolynomialPiece>> {
    let mut all = PiecewiseFit {
        layout,
        function,
        observer: Observer::default(),
        samples: [Vec::new(), Vec::new()],
        steepest: 0.0,
        largest: layout.size,
    };
    if layout.is_unknown {
        let times = layout.sample_times();
        let values = all.values(&times)?;
        all.steepest = steepest(&times, &values);
        all.samples = [times, values];
    }
    all.lay_out()
}

impl PiecewiseFit<'_> {
    /// The values of the function at some places.
    fn values(&mut self, places: &[f64]) -> Result<Vec<f64>> {
        let values = (self.function)(places)?;
        if values.len() != places.len() {
            let shape = |n: usize| format!("({n},)");
            let (found, expected) = (shape(values.len()), shape(places.len()));
            return Err(Error::bad_shape("the function's value", found, expected));
        }
        if let Some(i) = values.iter().position(|x| !x.is_finite()) {
            let argument = format!("the function at t = {}", places[i]);
            return Err(Error::bad_value(argument, values[i], "it must be finite"));
        }
        let largest = values.iter().map(|x| x.abs());
        self.largest = largest.fold(self.largest, f64::max);
        Ok(values)
    }

    /// The function at the nodes and check points of some intervals, evaluated at once for many of them.
    fn sample(&mut self, parts: &[FitInterval]) -> Result<Vec<SampledPiece>> {
        let mut pieces = Vec::with_capacity(parts.len());
        for some in parts.chunks(PIECES_AT_ONCE) {
            self.observer.ask()?;
            let beside = some.iter().map(|part| self.layout.beside(part));
            let of = |(part, beside): (&FitInterval, [f64; 2])| {
                SampledPiece::at((part.start, part.end), beside)
            };
            let mut own: Vec<SampledPiece> = some.iter().zip(beside).map(of).collect();
            let places: Vec<f64> = own.iter().flat_map(|piece| piece.places).collect();
            let values = self.values(&places)?;
            for (piece, values) in own.iter_mut().zip(values.chunks(SAMPLE_POINTS)) {
                piece.values.copy_from_slice(values);
            }
            pieces.append(&mut own);
        }
        Ok(pieces)
    }

    /// The largest error of a polynomial at those samples of the whole span that lie in an interval.
    fn error_at_samples(&self, part: &FitInterval, c: &[f64; CHEBYSHEV_NODES]) -> f64 {
        let [times, values] = &self.samples;
        let first = times.partition_point(|t| *t <= part.start);
        let inside = times[first..].iter().zip(&values[first..]);
        let inside = inside.take_while(|(t, _)| **t < part.end);
        let at = |t: f64| {
            sum(
                c,
                ((t - part.start) - (part.end - t)) / (part.end - part.start),
            )
        };
        inside
            .map(|(t, value)| (at(*t) - value).abs())
            .fold(0.0, f64::max)
    }

    /// The polynomial of an interval, with its error; none where the error is larger than it may be, or NaN.
    fn fit(
        &self,
        part: &FitInterval,
        piece: &SampledPiece,
    ) -> (f64, Option<[f64; CHEBYSHEV_NODES]>) {
        let slope = piece.steepest();
        let by_time = |(start, end): (f64, f64), slope: f64| {
            let last_places = SAMPLE_TIME_ROUNDINGS * f64::EPSILON * start.abs().max(end.abs());
            (last_places * slope).min(FUNCTION_JUMP * self.largest)
        };
        let least = FUNCTION_TOL * self.largest;
        let last_places = by_time((part.start, part.end), slope);
        let allowed = self.layout.known_to.max(least) + last_places;
        let rounding = if self.layout.known_to > 0.0 {
            ROUGH_FUNCTION * self.largest
        } else {
            by_time(self.layout.span, slope.max(self.steepest))
        };
        let is_short = part.end - part.start <= CORNER_PIECE_LENGTH * part.smooth_length;
        // A corner may lie between two sampled points, where high powers show less of it; below the last places of the time there is none.
        let has_tip = is_short && last_places < least;
        let beside = if has_tip { CORNER_ERROR_FACTOR } else { 1.0 };
        let lines = is_short.then(|| line(&piece.values));
        let curves = (!has_tip).then(|| coefficients(&piece.values[..CHEBYSHEV_NODES]));
        let mut smallest = f64::INFINITY;
        for c in lines.into_iter().chain(curves) {
            let miss = beside * piece.miss(&c).max(self.error_at_samples(part, &c));
            let is_rough = miss > ROUGH_HALVING * part.parent_error && miss <= rounding;
            if is_rough || miss <= allowed {
                return (miss, Some(c));
            }
            smallest = smallest.min(miss);
        }
        (smallest, None)
    }

    fn lay_out(&mut self) -> Result<Vec<PolynomialPiece>> {
        let mut open = self.layout.smooth_intervals();
        let mut done = Vec::new();
        while !open.is_empty() {
            let sampled = self.sample(&open)?;
            let mut next = Vec::new();
            let mut worst = (0.0f64, open[0]);
            for (part, piece) in open.iter().zip(&sampled) {
                let (miss, fitted) = self.fit(part, piece);
                if let Some(c) = fitted {
                    done.push(PolynomialPiece {
                        start: part.start,
                        end: part.end,
                        powers: powers(&c),
                    });
                    continue;
                }
                if miss >= worst.0 {
                    worst = (miss, *part);
                }
                next.extend(part.halves(miss));
            }
            let is_short = |halves: &&[FitInterval]| halves.iter().any(FitInterval::is_too_short);
            if let Some(halves) = next.chunks(2).find(is_short) {
                let FitInterval {
                    parent_error,
                    start,
                    ..
                } = halves[0];
                return Err(self.refused(
                    parent_error,
                    start,
                    "the time has no places for shorter pieces",
                ));
            }
            if next.len() + done.len() > MOST_FUNCTION_PIECES {
                let reason = format!("more than {MOST_FUNCTION_PIECES} pieces would be needed");
                return Err(self.refused(worst.0, worst.1.start, &reason));
            }
            open = next;
        }
        done.sort_by(|x, y| x.start.total_cmp(&y.start));
        Ok(done)
    }

    fn refused(&self, miss: f64, t: f64, reason: &str) -> Error {
        let value = format!("off by {miss:e} near t = {t} ({reason})");
        let rule = format!(
            "pieces must follow it to {FUNCTION_TOL:e} of its largest value, {:e}: name the places at which it or a derivative jumps as \
             `breaks`, or shorten the span",
            self.largest
        );
        Error::bad_value("the function", value, rule)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::signal::Signal;

    fn each(f: impl Fn(f64) -> f64) -> impl FnMut(&[f64]) -> Result<Vec<f64>> {
        move |t: &[f64]| Ok(t.iter().map(|&t| f(t)).collect())
    }

    #[test]
    fn smooth_functions_are_followed_to_rounding() {
        let functions: [(&str, fn(f64) -> f64); 4] = [
            ("a chirp", |t| ((1.0 + t) * t).sin()),
            ("a polynomial", |t| 1.0 + t * (2.0 - t * t * t)),
            ("a pulse", |t| (-4.0 * (t - 5.0).powi(2)).exp()),
            ("nothing", |_| 0.0),
        ];
        for (name, f) in functions {
            let signal = Signal::from_function(each(f), (-3.0, 10.0)).expect("smooth");
            let samples = (1..9_999).map(|i| -3.0 + 13.0 * f64::from(i) / 10_000.0);
            let largest = samples.clone().fold(0.0f64, |m, t| m.max(f(t).abs()));
            let slope = |t: f64| ((f(t + 1e-6) - f(t - 1e-6)) / 2e-6).abs();
            let steepest = samples.clone().map(slope).fold(0.0, f64::max);
            for t in samples {
                let off = (signal.value(t) - f(t)).abs();
                let by_time = f64::EPSILON * t.abs() * steepest;
                let allowed = 2e-14 * largest + 4.0 * by_time;
                assert!(off <= allowed, "{name} at {t}: {off:e}");
            }
        }
    }

    #[test]
    fn a_fast_function_far_from_zero_is_followed_as_far_as_its_time_is_known() {
        let signal = Signal::from_function(each(|t| (1e3 * t).sin()), (1000.0, 1001.0));
        let signal = signal.expect("as far as the time is known");
        for i in 0..1000 {
            let t = 1000.0 + f64::from(i) * 1e-3;
            assert!((signal.value(t) - (1e3 * t).sin()).abs() < 1e-9);
        }
    }

    #[test]
    fn a_corner_is_followed_by_lines_and_a_jump_is_refused() {
        let corner = |t: f64| (t - 0.3).abs();
        let signal = Signal::from_function(each(corner), (0.0, 1.0)).expect("continuous");
        for i in 0..10_000 {
            let t = 0.2999 + 2e-8 * f64::from(i);
            assert!((signal.value(t) - corner(t)).abs() < 1e-14, "{t}");
        }
        let jump = Signal::from_function(each(|t| (t - 0.3).signum()), (0.0, 1.0));
        let message = jump.expect_err("a jump").to_string();
        assert!(message.starts_with("the function is off by "), "{message}");
        for (f, span) in [
            (f64::NAN, (0.0, 1.0)),
            (1.0, (1.0, 1.0)),
            (1.0, (0.0, f64::INFINITY)),
        ] {
            assert!(Signal::from_function(each(move |_| f), span).is_err());
        }
    }
}
