//! Families of motions: sections and diagrams, exponents, attractors, basins.

mod aperiodic;
mod attractors;
mod basins;
mod diagram;
mod literature;
mod lyapunov;
mod scenes;
mod turning;
