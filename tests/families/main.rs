//! Families of motions: sections and diagrams, exponents, attractors, basins.

mod attractors;
mod basins;
mod diagram;
mod lyapunov;
mod scenes;
