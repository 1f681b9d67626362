//! What nalgebra lacks: guarded eigenproblems, elementary and phi functions, a rank-revealing solve, complementarity, the plane.

mod active_set;
pub(crate) mod compensated;
pub(crate) mod complementarity;
pub(crate) mod determinant;
pub(crate) mod eigen;
pub(crate) mod elementary;
pub(crate) mod exponential;
pub(crate) mod francis;
pub(crate) mod graded;
mod lemke;
pub(crate) mod matrix_exponential;
pub(crate) mod plane;
pub(crate) mod rank;
#[cfg(test)]
pub(crate) mod seeded;
pub(crate) mod singular;
pub(crate) mod small;
