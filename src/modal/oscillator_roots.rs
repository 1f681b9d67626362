//! An oscillator `y'' + 2 eta y' + w2 y` under-, over- or critically damped, rigid or unstable: its roots and what depends on
//! their kind alone (theory 4).

use crate::linalg::exponential::{one_minus_sinc, phi1_divided, phi2};

/// The roots of an oscillator in the form that its damping asks for.
pub(super) enum OscillatorRoots {
    Under { damped_frequency: f64 },
    Over { l1: f64, l2: f64, half_gap: f64 },
}

/// The roots of `y'' + 2 eta y' + w2 y`, without cancellation.
pub(super) fn oscillator_roots(w2: f64, eta: f64) -> OscillatorRoots {
    let w = w2.max(0.0).sqrt();
    if w2 >= 0.0 && w >= eta.abs() {
        return OscillatorRoots::Under {
            damped_frequency: ((w - eta) * (w + eta)).sqrt(),
        };
    }
    let half_gap = if w2 >= 0.0 {
        ((eta.abs() - w) * (eta.abs() + w)).sqrt()
    } else {
        eta.hypot((-w2).sqrt())
    };
    // The root of larger modulus first, the other from their product: no cancellation, l1 > l2.
    let (l1, l2) = if eta >= 0.0 {
        let l2 = -(eta + half_gap);
        (w2 / l2, l2)
    } else {
        let l1 = half_gap - eta;
        (l1, w2 / l1)
    };
    OscillatorRoots::Over { l1, l2, half_gap }
}

/// `int_0^t S` of an overdamped or unstable oscillator: its response from rest to a unit load.
pub(super) fn over_load_response(l1: f64, l2: f64, t: f64) -> f64 {
    t * t * phi1_divided((l1 * t).into(), (l2 * t).into()).re
}

/// `1 - e^{-x}(cos y + x sinc y)`, `x = eta t`, `y = wd t`: a sum of terms that are not negative for `eta >= 0`.
pub(super) fn under_one_minus_cp(eta: f64, damped_frequency: f64, t: f64) -> f64 {
    let (x, y) = (eta * t, damped_frequency * t);
    let half = (0.5 * y).sin();
    let start = if x > 700.0 {
        1.0
    } else {
        (-x).exp() * x * x * phi2(x)
    };
    start + (-x).exp() * (x * one_minus_sinc(y) + 2.0 * half * half)
}
