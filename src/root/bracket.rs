//! A bracket, and bisection.

/// Two numbers between which something changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bracket {
    /// The lower one: what is here is before the change.
    pub before: f64,
    /// The upper one.
    pub after: f64,
}

impl Bracket {
    pub fn new([before, after]: [f64; 2]) -> Self {
        Self { before, after }
    }

    #[inline]
    pub fn middle(self) -> f64 {
        0.5 * (self.before + self.after)
    }

    pub fn length(self) -> f64 {
        self.after - self.before
    }

    /// Whether a number lies inside, not at an end; of neighbouring numbers not even the middle does.
    #[inline]
    pub fn has(self, x: f64) -> bool {
        x > self.before && x < self.after
    }

    /// Takes a number inside as an end.
    #[inline]
    pub fn narrow(&mut self, x: f64, is_before: bool) {
        *(if is_before {
            &mut self.before
        } else {
            &mut self.after
        }) = x;
    }
}

/// The bracket of a change by halves: one no longer than `shortest`, or neighbouring numbers.
pub(crate) fn bisected<E>(
    mut between: Bracket,
    shortest: f64,
    mut is_before: impl FnMut(f64) -> Result<bool, E>,
) -> Result<Bracket, E> {
    while between.length() > shortest && between.has(between.middle()) {
        let middle = between.middle();
        between.narrow(middle, is_before(middle)?);
    }
    Ok(between)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn below(place: f64) -> impl FnMut(f64) -> Result<bool, Infallible> {
        move |x| Ok(x < place)
    }

    #[test]
    fn halves_end_at_neighbours() {
        for place in [1.0 / 3.0, 1e-300, 1.0, -0.7, f64::from_bits(1)] {
            let Ok(found) = bisected(Bracket::new([-1.0, 1.0]), 0.0, below(place));
            assert_eq!(found.before.next_up(), found.after, "{place}");
            assert_eq!(found.after, place);
        }
    }

    #[test]
    fn halves_end_at_a_length() {
        let Ok(found) = bisected(Bracket::new([0.0, 8.0]), 0.5, below(3.3));
        assert_eq!((found.before, found.after), (3.0, 3.5));
        // A bracket of no length, or of no numbers, is none.
        for ends in [[1.0, 1.0], [f64::NAN, 1.0]] {
            let mut count = 0;
            let Ok(_) = bisected(Bracket::new(ends), 0.0, |_| {
                count += 1;
                Ok::<_, Infallible>(true)
            });
            assert_eq!(count, 0);
        }
    }
}
