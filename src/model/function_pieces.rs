//! A function laid out in pieces, each a polynomial that is it to some part of its largest value (theory 11): a piece is halved until it is
//! the function at places of its own, and at those at which the whole of the function was looked at beforehand.

use crate::error::{Error, Result};
use crate::model::chebyshev::{
    GOLDEN, NODES, PLACES, Piece, coefficients, line, powers, steepest, sum,
};
use crate::observer::{Observer, ObserverFn};
use crate::tolerance::{FUNCTION_TOL, MOST_PIECES};

/// Pieces up to this part of the way between two breaks, where halves of it have led to a corner, may be straight lines: high powers would
/// have no digits.
const CORNER: f64 = 1.0 / 67_108_864.0;
/// How much farther a line may be off a corner than at the places that are looked at: a tip between an end and the next place.
const TIP: f64 = 2.0;
/// What the last place of the time may make of a function, in parts of its largest value: more is a jump.
const MOST_BY_TIME: f64 = 1e-6;
/// Last places of the time by which a place beside a break is away from it.
const BESIDE: f64 = 2.0;
/// Last places of the time by which the time of a value is unknown. Where the function is smooth, a place is half of one off, being a sum
/// that is rounded, and the function takes another half or so where it first multiplies the time; a polynomial through nine such values is
/// off by 2.3 times that between them, and the value it is held against by once: 3.3. At a corner halving ends at a piece with one or two
/// times inside, two or three last places long: all its times are looked at, and its values are not farther apart than the steepest slope
/// makes of its length, 3. So what is steep and continuous is followed, whatever the function rounds; a jump is more than
/// [`MOST_BY_TIME`]. That is by how much it is off where it was looked at: at a corner between these places a polynomial of degree 8 is off
/// by up to 6.8 times as much.
const LAST_PLACES: f64 = 4.0;
/// A function is rough where the miss of half a piece is more than this part of that of the whole: halving a piece of a smooth one takes 1/512
/// of it, at a corner a half. What is left is its rounding, if no more than the last places of the span's times make of it, there or where
/// it is steep (where slopes of its terms cancel, their roundings do not), or, of one that is known to something anyhow, this part of its
/// largest value.
const ROUGH: f64 = 0.7;
const ROUGHEST: f64 = 1e-9;
/// Places at which the whole of a function is looked at, no two neighbours farther apart than twice the usual: two or more lie in what lasts
/// a thousandth of the span.
const LOOKS: usize = 4096;
/// Pieces looked at between two questions whether to go on.
const PIECES_PER_QUESTION: usize = 256;

/// What a function is asked for its values at.
type Function<'a> = &'a mut dyn FnMut(&[f64]) -> Result<Vec<f64>>;

/// A piece of a function: its coefficients in powers of the part of it that has passed.
pub(crate) struct PolynomialPiece {
    pub start: f64,
    pub end: f64,
    pub powers: [f64; NODES],
}

/// How a function is laid out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout<'a> {
    /// Start and end.
    pub span: (f64, f64),
    /// In order, where the function or a derivative of it jumps: it is asked beside them. Some may be ends of the span.
    pub breaks: &'a [f64],
    /// The size of its terms, of which its largest value may be a small part.
    pub size: f64,
    /// What it is known to, if not to its own rounding.
    pub known_to: f64,
    /// Whether nothing is known of how long its features last, so that the whole of it is looked at beforehand.
    pub is_unknown: bool,
}

impl Layout<'_> {
    /// That of a function of which all is known but its values.
    pub fn of_span(span: (f64, f64)) -> Self {
        Self {
            span,
            breaks: &[],
            size: 0.0,
            known_to: 0.0,
            is_unknown: false,
        }
    }

    /// The ways between breaks.
    fn ways(&self) -> Vec<Part> {
        let (start, end) = self.span;
        let inner = self.breaks.iter().copied();
        let inner = inner.filter(|b| *b > start && *b < end);
        let ends: Vec<f64> = std::iter::once(start).chain(inner).chain([end]).collect();
        let part = |ends: &[f64]| Part {
            start: ends[0],
            end: ends[1],
            way: ends[1] - ends[0],
            missed: f64::INFINITY,
        };
        ends.windows(2).map(part).collect()
    }

    /// How far from an end of a piece it is asked: not at all, but beside a break.
    fn beside(&self, part: &Part) -> [f64; 2] {
        let last_places = BESIDE * f64::EPSILON * part.start.abs().max(part.end.abs());
        let is_break = |t: f64| self.breaks.binary_search_by(|b| b.total_cmp(&t)).is_ok();
        [part.start, part.end].map(|t| if is_break(t) { last_places } else { 0.0 })
    }

    /// Places all over the span, in order.
    fn looks(&self) -> Vec<f64> {
        let (start, end) = self.span;
        let place = |i: usize| i as f64 + (GOLDEN * (i + 1) as f64).fract();
        (0..LOOKS)
            .map(|i| start + (end - start) * (place(i) / LOOKS as f64))
            .collect()
    }
}

/// A part of the span that is to be one piece.
#[derive(Debug, Clone, Copy)]
struct Part {
    start: f64,
    end: f64,
    /// The length of the way between breaks on which it lies.
    way: f64,
    /// By how much a piece twice as long was off.
    missed: f64,
}

impl Part {
    fn middle(&self) -> f64 {
        0.5 * self.start + 0.5 * self.end
    }

    fn halves(&self, missed: f64) -> [Self; 2] {
        let middle = self.middle();
        let (mut first, mut second) = (Self { missed, ..*self }, Self { missed, ..*self });
        (first.end, second.start) = (middle, middle);
        [first, second]
    }

    /// Whether no time lies inside.
    fn is_too_short(&self) -> bool {
        let middle = self.middle();
        let is_inside = self.start < middle && middle < self.end;
        !is_inside || self.end - self.start <= f64::EPSILON * f64::EPSILON * self.way
    }
}

/// A function that is being laid out.
struct Pieces<'a, 'o> {
    layout: Layout<'a>,
    function: Function<'a>,
    observer: Observer<'o>,
    /// Times and values of the looks at the whole.
    looks: [Vec<f64>; 2],
    /// The largest slope between those.
    steepest: f64,
    largest: f64,
}

/// The pieces of a function, in order; asks from time to time whether to go on.
///
/// # Errors
/// What the function reports, values that are not finite, a function that `MOST_PIECES` pieces do not follow; `Error::Interrupted`.
pub(crate) fn polynomial_pieces(
    function: Function<'_>,
    layout: Layout<'_>,
    go_on: ObserverFn<'_>,
) -> Result<Vec<PolynomialPiece>> {
    let mut all = Pieces {
        layout,
        function,
        observer: Observer::new(go_on),
        looks: [Vec::new(), Vec::new()],
        steepest: 0.0,
        largest: layout.size,
    };
    if layout.is_unknown {
        let times = layout.looks();
        let values = all.values(&times)?;
        all.steepest = steepest(&times, &values);
        all.looks = [times, values];
    }
    all.lay_out()
}

impl Pieces<'_, '_> {
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

    /// The function at all places of some parts, asked for at once for many of them.
    fn look(&mut self, parts: &[Part]) -> Result<Vec<Piece>> {
        let mut pieces = Vec::with_capacity(parts.len());
        for some in parts.chunks(PIECES_PER_QUESTION) {
            self.observer.ask()?;
            let beside = some.iter().map(|part| self.layout.beside(part));
            let of = |(part, beside): (&Part, [f64; 2])| Piece::at((part.start, part.end), beside);
            let mut own: Vec<Piece> = some.iter().zip(beside).map(of).collect();
            let places: Vec<f64> = own.iter().flat_map(|piece| piece.places).collect();
            let values = self.values(&places)?;
            for (piece, values) in own.iter_mut().zip(values.chunks(PLACES)) {
                piece.values.copy_from_slice(values);
            }
            pieces.append(&mut own);
        }
        Ok(pieces)
    }

    /// How far a polynomial is off the looks at the whole that lie in a part.
    fn missed_looks(&self, part: &Part, c: &[f64; NODES]) -> f64 {
        let [times, values] = &self.looks;
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

    /// The polynomial of a part, with what it misses the function by beyond what it may; NaN counts as that.
    fn fit(&self, part: &Part, piece: &Piece) -> (f64, Option<[f64; NODES]>) {
        let slope = piece.steepest();
        let by_time = |(start, end): (f64, f64), slope: f64| {
            let last_places = LAST_PLACES * f64::EPSILON * start.abs().max(end.abs());
            (last_places * slope).min(MOST_BY_TIME * self.largest)
        };
        let least = FUNCTION_TOL * self.largest;
        let last_places = by_time((part.start, part.end), slope);
        let allowed = self.layout.known_to.max(least) + last_places;
        let rounding = if self.layout.known_to > 0.0 {
            ROUGHEST * self.largest
        } else {
            by_time(self.layout.span, slope.max(self.steepest))
        };
        let is_short = part.end - part.start <= CORNER * part.way;
        // The tip of a corner may lie between two places, and high powers see less of it; below the last places of the time there is none.
        let has_tip = is_short && last_places < least;
        let beside = if has_tip { TIP } else { 1.0 };
        let lines = is_short.then(|| line(&piece.values));
        let curves = (!has_tip).then(|| coefficients(&piece.values[..NODES]));
        let mut smallest = f64::INFINITY;
        for c in lines.into_iter().chain(curves) {
            let miss = beside * piece.miss(&c).max(self.missed_looks(part, &c));
            let is_rough = miss > ROUGH * part.missed && miss <= rounding;
            if is_rough || miss <= allowed {
                return (miss, Some(c));
            }
            smallest = smallest.min(miss);
        }
        (smallest, None)
    }

    fn lay_out(&mut self) -> Result<Vec<PolynomialPiece>> {
        let mut open = self.layout.ways();
        let mut done = Vec::new();
        while !open.is_empty() {
            let looked = self.look(&open)?;
            let mut next = Vec::new();
            let mut worst = (0.0f64, open[0]);
            for (part, piece) in open.iter().zip(&looked) {
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
            let is_short = |halves: &&[Part]| halves.iter().any(Part::is_too_short);
            if let Some(halves) = next.chunks(2).find(is_short) {
                let Part { missed, start, .. } = halves[0];
                return Err(self.refused(
                    missed,
                    start,
                    "the time has no places for shorter pieces",
                ));
            }
            if next.len() + done.len() > MOST_PIECES {
                let reason = format!("more than {MOST_PIECES} pieces would be needed");
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
