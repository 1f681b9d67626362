//! The monodromy matrix of any motion (theory 7): flow Jacobians and saltation matrices, `R_x + (f+ - R_x f-) g_x/(g_x f-)`,
//! from the flights and impacts as the shooting has them.

use crate::error::Result;
use crate::orbit::shooting::Motion;
use nalgebra::{DMatrix, DVector};

/// The product over one period from just after the first instant, in (q, v); `flights` are their start, end and first state,
/// `order` the stops of each instant one after the other.
pub(crate) fn monodromy<M: Motion>(
    motion: &M,
    order: &[Vec<usize>],
    flights: &[(f64, f64, DVector<f64>)],
) -> Result<DMatrix<f64>> {
    let len = flights.first().map_or(0, |(.., state)| state.len());
    let mut deviations = DMatrix::identity(len, len);
    for (k, (start, end, state)) in flights.iter().enumerate() {
        let mut x = state.clone();
        motion.fly((*start, *end), &mut x, &mut deviations)?;
        let next: &[usize] = match order.len() {
            0 => &[],
            count => &order[(k + 1) % count],
        };
        for &stop in next {
            salt(motion, stop, *end, &mut x, &mut deviations)?;
        }
    }
    Ok(deviations)
}

/// The impact of one stop on a state and on deviations from it.
fn salt<M: Motion>(
    motion: &M,
    stop: usize,
    t: f64,
    state: &mut DVector<f64>,
    deviations: &mut DMatrix<f64>,
) -> Result<()> {
    let (_, gradient) = motion.gap(stop, state)?;
    let before = motion.rate(t, state)?;
    let along = |x: &DVector<f64>| gradient.dot(&x.rows(0, gradient.len()));
    let delays: Vec<f64> = deviations
        .column_iter()
        .map(|c| along(&c.into_owned()) / along(&before))
        .collect();
    let count = deviations.ncols();
    let mut columns = deviations.clone().insert_column(count, 0.0);
    columns.set_column(count, &before);
    motion.collide(&[stop], state, &mut columns)?;
    let slip = motion.rate(t, state)? - columns.column(count);
    for (j, delay) in delays.iter().enumerate() {
        deviations.set_column(j, &(columns.column(j) + &slip * *delay));
    }
    Ok(())
}
