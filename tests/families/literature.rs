//! Smooth cases with published numbers. `VIBROIMPACT_SIDE=200` gives the basins as many cells a side as they were published with.

use crate::scenes::{double_well, grid, well};
use vibroimpact::nalgebra::dvector;
use vibroimpact::{
    Attraction, AttractorOptions, BasinOptions, Label, LyapunovOptions, basin_cells,
    find_attractors, lyapunov_exponents,
};

#[test]
fn duffings_oscillator_is_chaotic() {
    // x'' + 0.2 x' - x + x^3 = 0.3 cos t: 0.159, -0.359 (ChaosTools, issue 301).
    let options = LyapunovOptions {
        skip: 500.0,
        ..LyapunovOptions::default()
    };
    let span = (0.0, 60_000.0);
    let found = lyapunov_exponents(
        &well(0.2, 0.3),
        &dvector![0.1],
        &dvector![0.1],
        span,
        &options,
    )
    .expect("exponents");
    assert_eq!(found.verdict, Attraction::Chaotic);
    assert!((found.exponents[0] - 0.159).abs() < 0.003, "{found:?}");
    assert!((found.exponents[1] + 0.359).abs() < 0.003, "{found:?}");
    assert!((found.exponents[0] + found.exponents[1] + 0.2).abs() < 1e-8);
}

#[test]
fn both_wells_have_about_half_of_the_plane() {
    // x'' + 0.15 x' - x + x^3 = 0.2 cos t over (-2.2, 2.2)^2: 0.512 and 0.488 of 200 x 200 cells (tests of Attractors.jl).
    let side = std::env::var("VIBROIMPACT_SIDE").map_or(50, |side| side.parse().expect("a number"));
    let (around, seeds) = grid([-2.2, 2.2], [-2.2, 2.2], 5);
    let (_, states) = grid([-2.2, 2.2], [-2.2, 2.2], side);
    let scene = double_well();
    let known =
        find_attractors(&scene, &around, &seeds, &AttractorOptions::default()).expect("found");
    assert_eq!(known.all.len(), 2);
    let phases = vec![0.0; side * side];
    let found = basin_cells(
        &scene,
        &known.all,
        &around,
        (&states, &phases),
        &BasinOptions::default(),
    );
    let found = found.expect("cells");
    let part = |k: usize| {
        let count = found
            .labels
            .iter()
            .filter(|label| **label == Label::Attractor(k))
            .count();
        count as f64 / (side * side) as f64
    };
    let mut parts = [part(0), part(1)];
    parts.sort_by(f64::total_cmp);
    assert!((parts[0] + parts[1] - 1.0).abs() < 1e-12);
    // The boundary is fractal: of fewer cells the parts are known less well.
    let within = 0.01f64.max(1.0 / side as f64);
    assert!(
        (parts[0] - 0.488).abs() < within && (parts[1] - 0.512).abs() < within,
        "{parts:?}"
    );
}
