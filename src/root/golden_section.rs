//! The lowest value of a function between two places: golden sections.

/// Golden sections of an interval: it is narrowed to 4e-9 of its length. [work]
const GOLDEN_SECTIONS: usize = 40;

/// The place of the lowest value of a function between two places, where it has a single one.
///
/// # Errors
/// What the function reports.
pub(crate) fn golden_section<E>(
    [mut a, mut b]: [f64; 2],
    mut at: impl FnMut(f64) -> Result<f64, E>,
) -> Result<f64, E> {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    for _ in 0..GOLDEN_SECTIONS {
        let (c, d) = (b - golden * (b - a), a + golden * (b - a));
        if at(c)? < at(d)? {
            b = d;
        } else {
            a = c;
        }
    }
    Ok(0.5 * (a + b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    #[test]
    fn the_lowest_value_is_found_inside_and_at_an_end() {
        for (lowest, wanted) in [(0.3, 0.3), (-2.0, -1.0), (5.0, 2.0)] {
            let Ok(found) =
                golden_section([-1.0, 2.0], |x| Ok::<_, Infallible>((x - lowest).powi(2)));
            assert!((found - wanted).abs() < 3e-8, "{lowest} {found}");
        }
    }
}
