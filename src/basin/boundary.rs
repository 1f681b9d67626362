//! How intricate the boundary of basins is: entropy, dimension and uncertainty of a plane of labels, a state each, ny rows of nx.
//!
//! Sizes and distances count cells. States that lead to an attractor, and those that are lost, are of a basin; others are left out.
//!
//! Source: theory 18; A. Daza et al., Sci. Rep. 6 (2016) 31416 (entropy).

use crate::basin::label::Label;
use crate::error::{Error, Result};
use nalgebra::DMatrix;
use std::collections::BTreeMap;

/// Boxes of the largest size along the shorter side. [exact]
const LEAST_BOXES: usize = 4;
/// Largest distances along the shorter side. [exact]
const LEAST_DISTANCES: usize = 8;
/// Sizes with counts without which a power law has no error. [exact]
const LEAST_FITTED: usize = 3;

/// The entropy of basins \[-\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BasinEntropy {
    /// Its mean over all boxes with a state of a basin; NaN where there is none.
    pub all: f64,
    /// Its mean over the boxes with more than one basin; NaN where there is none. Beyond ln 2 the boundary is fractal.
    pub boundary: f64,
}

/// A power law fitted to counts over m sizes.
#[derive(Debug, Clone, PartialEq)]
pub struct PowerLaw {
    /// The exponent \[-\].
    pub value: f64,
    /// Its standard error by the regression \[-\]; both are NaN of fewer than three sizes with counts.
    pub error: f64,
    /// Sizes \[cells\], shape `(m,)`.
    pub sizes: Vec<usize>,
    /// What was counted at each \[-\], shape `(m,)`.
    pub counts: Vec<f64>,
}

/// Of a label that is a basin its number.
fn basin(label: Label) -> Option<i16> {
    matches!(label, Label::Attractor(_) | Label::Lost).then(|| label.number())
}

/// The basins of each whole box of so many cells a side, with how many cells each has.
fn boxes(plane: &DMatrix<Label>, side: usize) -> impl Iterator<Item = BTreeMap<i16, usize>> {
    let (ny, nx) = (plane.nrows() / side, plane.ncols() / side);
    let counted = move |(i, j): (usize, usize)| {
        let mut counts = BTreeMap::new();
        let cells = plane.view((i * side, j * side), (side, side));
        for own in cells.iter().filter_map(|label| basin(*label)) {
            *counts.entry(own).or_insert(0) += 1;
        }
        counts
    };
    (0..ny)
        .flat_map(move |i| (0..nx).map(move |j| (i, j)))
        .map(counted)
}

fn shorter_side(plane: &DMatrix<Label>) -> usize {
    plane.nrows().min(plane.ncols())
}

/// The entropy `-sum p ln p` of boxes of so many cells a side, p the parts of a box that are of each basin.
///
/// # Errors
/// No cells, or more than the shorter side has.
///
/// # Examples
/// ```
/// use vibroimpact::{Label, basin_entropy};
/// use vibroimpact::nalgebra::DMatrix;
/// // Two basins side by side: half of the boxes on the boundary is of each.
/// let plane = DMatrix::from_fn(20, 20, |_, j| Label::Attractor(usize::from(j >= 5)));
/// let found = basin_entropy(&plane, 10)?;
/// assert!((found.boundary - 2f64.ln()).abs() < 1e-15);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn basin_entropy(plane: &DMatrix<Label>, cells: usize) -> Result<BasinEntropy> {
    let most = shorter_side(plane);
    if !(1..=most).contains(&cells) {
        let rule = format!("it must be at least 1 and at most {most}, the shorter side");
        return Err(Error::bad_value("cells", cells, rule));
    }
    let (mut all, mut mixed) = (Vec::new(), Vec::new());
    for counts in boxes(plane, cells).filter(|counts| !counts.is_empty()) {
        let total: usize = counts.values().sum();
        let parts = counts.values().map(|count| *count as f64 / total as f64);
        let entropy = -parts.map(|p| p * p.ln()).sum::<f64>();
        all.push(entropy);
        if counts.len() > 1 {
            mixed.push(entropy);
        }
    }
    let mean = |each: &[f64]| each.iter().sum::<f64>() / each.len() as f64;
    Ok(BasinEntropy {
        all: mean(&all),
        boundary: mean(&mixed),
    })
}

/// Sizes from one cell up, each twice the one before, of which the shorter side has so many.
fn sizes(plane: &DMatrix<Label>, times: usize) -> Vec<usize> {
    let side = shorter_side(plane);
    let doubled = std::iter::successors(Some(1usize), |size| size.checked_mul(2));
    doubled.take_while(|size| size * times <= side).collect()
}

/// The dimension d of the boundary: `size^-d` boxes of a size hold more than one basin.
pub fn boundary_dimension(plane: &DMatrix<Label>) -> PowerLaw {
    let sizes: Vec<usize> = sizes(plane, LEAST_BOXES).into_iter().skip(1).collect();
    let mixed = |side: &usize| {
        boxes(plane, *side)
            .filter(|counts| counts.len() > 1)
            .count()
    };
    let counts = sizes.iter().map(|side| mixed(side) as f64).collect();
    fitted(sizes, counts, -1.0)
}

/// The exponent a of uncertainty: `distance^a` of the states have another basin at a distance to either side. The dimension of the boundary
/// is that of the plane, 2, less the exponent.
///
/// The states are those as far from the edges as the largest distance, for all of them the same.
pub fn uncertainty_exponent(plane: &DMatrix<Label>) -> PowerLaw {
    let sizes = sizes(plane, LEAST_DISTANCES);
    let rim = sizes.last().copied().unwrap_or(0);
    let part = |distance: &usize| {
        let (mut uncertain, mut known) = (0usize, 0usize);
        for own in [plane, &plane.transpose()] {
            for i in 0..own.nrows() {
                for j in rim..own.ncols() - rim {
                    let at = |j: usize| basin(own[(i, j)]);
                    let all = (at(j), at(j - distance), at(j + distance));
                    if let (Some(here), Some(before), Some(after)) = all {
                        known += 1;
                        uncertain += usize::from(here != before || here != after);
                    }
                }
            }
        }
        uncertain as f64 / known as f64
    };
    let counts = sizes.iter().map(part).collect();
    fitted(sizes, counts, 1.0)
}

/// A power fitted by least squares of the logarithms.
fn fitted(sizes: Vec<usize>, counts: Vec<f64>, sign: f64) -> PowerLaw {
    let pairs = sizes.iter().zip(&counts);
    let usable = pairs.filter(|(_, count)| count.is_finite() && **count > 0.0);
    let logs: Vec<(f64, f64)> = usable
        .map(|(size, count)| ((*size as f64).ln(), count.ln()))
        .collect();
    let m = logs.len();
    let mut found = PowerLaw {
        value: f64::NAN,
        error: f64::NAN,
        sizes,
        counts,
    };
    if m < LEAST_FITTED {
        return found;
    }
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / m as f64;
    let (x, y) = (mean(|log| log.0), mean(|log| log.1));
    let spread: f64 = logs.iter().map(|log| (log.0 - x).powi(2)).sum();
    let slope = logs
        .iter()
        .map(|log| (log.0 - x) * (log.1 - y))
        .sum::<f64>()
        / spread;
    let rest = logs
        .iter()
        .map(|log| (log.1 - y - slope * (log.0 - x)).powi(2));
    found.value = sign * slope;
    found.error = (rest.sum::<f64>() / (m - 2) as f64 / spread).sqrt();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plane with two basins, by where a state is.
    fn plane(size: usize, is_second: impl Fn(usize, usize) -> bool) -> DMatrix<Label> {
        DMatrix::from_fn(size, size, |i, j| {
            Label::Attractor(usize::from(is_second(i, j)))
        })
    }

    /// Whether a number has the digit one in base three: the gaps of the set of Cantor, from ones of a third.
    fn is_in_gap(mut k: usize) -> bool {
        while k > 0 {
            if k % 3 == 1 {
                return true;
            }
            k /= 3;
        }
        false
    }

    #[test]
    fn a_line_has_dimension_one_and_the_uncertainty_that_goes_with_it() {
        let line = plane(256, |i, j| 3 * i > 2 * j + 30);
        let (dimension, exponent) = (boundary_dimension(&line), uncertainty_exponent(&line));
        // Oblique to the cells, counts are whole numbers, few of them at large sizes.
        for found in [dimension, exponent] {
            let off = (found.value - 1.0).abs();
            assert!(off < 3.0 * found.error && found.error < 0.05, "{found:?}");
        }
    }

    #[test]
    fn a_straight_line_along_the_cells_is_known_to_the_last_digits() {
        let own = plane(128, |_, j| j >= 61);
        let entropy = basin_entropy(&own, 8).expect("in range");
        let mixed = -(0.625 * 0.625f64.ln() + 0.375 * 0.375f64.ln());
        assert!((entropy.boundary - mixed).abs() < 1e-12);
        assert!((entropy.all - mixed / 16.0).abs() < 1e-12);
        assert!((boundary_dimension(&own).value - 1.0).abs() < 1e-12);
        assert!((uncertainty_exponent(&own).value - 1.0).abs() < 1e-12);
    }

    #[test]
    fn basins_that_are_nowhere_apart_have_a_boundary_of_the_dimension_of_the_plane() {
        // Bits of a sequence without a pattern (a linear congruential generator).
        let mut state = 1u64;
        let bits: Vec<bool> = (0..256 * 256)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                state >> 63 == 1
            })
            .collect();
        let own = plane(256, |i, j| bits[256 * i + j]);
        assert!((boundary_dimension(&own).value - 2.0).abs() < 0.1);
        assert!(uncertainty_exponent(&own).value.abs() < 0.05);
        let entropy = basin_entropy(&own, 16).expect("in range").boundary;
        assert!((entropy / 2f64.ln() - 1.0).abs() < 0.01);
    }

    #[test]
    fn strips_over_the_set_of_cantor_have_its_dimension_and_one() {
        let size = 3usize.pow(6);
        let strips = plane(size, |_, j| is_in_gap(j));
        let wanted = 1.0 + 2f64.ln() / 3f64.ln();
        let found = boundary_dimension(&strips);
        assert!((found.value - wanted).abs() < 0.1, "{found:?}");
    }

    #[test]
    fn one_basin_has_no_entropy_and_no_boundary() {
        let whole = plane(64, |_, _| false);
        let entropy = basin_entropy(&whole, 8).expect("in range");
        assert!(entropy.all == 0.0 && entropy.boundary.is_nan());
        assert!(boundary_dimension(&whole).value.is_nan());
        assert!(basin_entropy(&whole, 65).is_err() && basin_entropy(&whole, 0).is_err());
    }

    #[test]
    fn states_that_are_of_no_basin_do_not_count() {
        let mut own = plane(64, |i, _| i < 32);
        let without = basin_entropy(&own, 7).expect("in range");
        own.fill_column(63, Label::Inside);
        let with = basin_entropy(&own, 7).expect("in range");
        assert_eq!(without, with);
        own.fill(Label::Undecided);
        assert!(basin_entropy(&own, 7).expect("in range").all.is_nan());
        assert!(
            uncertainty_exponent(&own)
                .counts
                .iter()
                .all(|part| part.is_nan())
        );
    }
}
