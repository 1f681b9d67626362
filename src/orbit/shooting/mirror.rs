//! Scenes that are odd: half a period later everything is opposite (theory 19, "Symmetry").

use crate::error::Result;
use crate::flow::ModalScene;
use crate::hybrid::{ClosedFormMaps, HybridMaps, ScaledUnits};
use crate::law::Regime;
use crate::model::Scene;
use crate::orbit::shooting::closure::ShootingState;
use crate::tolerance::OPPOSITE_SIDES;
use nalgebra::DVector;
use std::f64::consts::TAU;

/// Whether two vectors are opposite, to a part of their size.
fn are_opposite(a: &DVector<f64>, b: &DVector<f64>) -> bool {
    (a + b).amax() <= OPPOSITE_SIDES * a.amax().max(b.amax())
}

/// [`images`] of a linear scene by itself, its modal form given.
pub(crate) fn images_in(scene: &Scene, modal: &ModalScene) -> Result<Option<Vec<usize>>> {
    let n = scene.n_dof();
    let size = modal.geometry.clearances.amax();
    let period = scene.period().unwrap_or(TAU);
    let state = DVector::from_fn(2 * n, |i, _| if i < n { size } else { 0.0 });
    let units = ScaledUnits::of([&state].into_iter(), period);
    let motion = ClosedFormMaps::new(modal, scene.phase(), Vec::new());
    let loop_of_one = ShootingState {
        times: vec![0.0, period],
        starts: vec![0.0],
        states: vec![state],
    };
    images(&motion, scene, &units, &loop_of_one)
}

/// The mirror image of each stop, where for any motion `q(t)` of a scene `-q(t + T/2)` is one too, T the period of its forcing, as far as the
/// first state of a loop and two more show it; `None` for other scenes.
pub(crate) fn images(
    motion: &dyn HybridMaps,
    scene: &Scene,
    units: &ScaledUnits,
    state: &ShootingState,
) -> Result<Option<Vec<usize>>> {
    // Without forcing nothing depends on time.
    let half = scene.period().map_or(0.0, |period| 0.5 * period);
    let n = scene.n_dof();
    let usual = |k: usize| {
        DVector::from_fn(2 * n, |i, _| {
            let unit = if i < n {
                units.position
            } else {
                units.velocity
            };
            unit * ((1 + i + 2 * k) as f64).sin()
        })
    };
    let samples = [
        (state.starts[0], state.states[0].clone()),
        (0.3 * units.time, usual(0)),
        (1.1 * units.time, usual(1)),
    ];
    for (t, x) in &samples {
        let rate = motion.rate(Regime::free(), *t, x)?;
        if !are_opposite(&rate, &motion.rate(Regime::free(), t + half, &-x)?) {
            return Ok(None);
        }
    }
    let is_image = |stop: usize, other: usize| -> Result<bool> {
        for (t, x) in &samples {
            let (one, two) = (motion.gap(stop, *t, x)?, motion.gap(other, t + half, &-x)?);
            let size = one.gap.abs().max(one.gradient.amax() * x.amax());
            let same = (one.gap - two.gap).abs() <= OPPOSITE_SIDES * size
                && (one.slope - two.slope).abs() <= OPPOSITE_SIDES * one.slope.abs()
                && are_opposite(&one.gradient, &two.gradient);
            let reactions = (motion.reaction(stop, x)?, motion.reaction(other, &-x)?);
            if !same || !are_opposite(&reactions.0, &reactions.1) {
                return Ok(false);
            }
        }
        Ok(motion.contact_law(stop) == motion.contact_law(other))
    };
    let n_stops = scene.stops().len();
    let mut images = Vec::new();
    for stop in 0..n_stops {
        let mut image = None;
        for other in 0..n_stops {
            if image.is_none() && !images.contains(&other) && is_image(stop, other)? {
                image = Some(other);
            }
        }
        let Some(image) = image else {
            return Ok(None);
        };
        images.push(image);
    }
    Ok(Some(images))
}
