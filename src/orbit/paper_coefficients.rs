//! An orbit that was found, written in the paper's coefficients, eq. (14) with the corrections of theory 3 and 4:
//! `q = sum_j phi_j (e^{-eta_j t}(a_j cos wd_j t + b_j sin wd_j t) + A_j sin w t + B_j cos w t)`.

use crate::flow::ModalScene;
use crate::law::Newton;
use crate::modal::{Block, Form, Pair};
use nalgebra::{Complex, DVector};

/// The coefficients of eq. (14) in the mass-normalised modes, ascending; t = 0 just after the first impact.
///
/// Overdamped modes have cosh and sinh of `sqrt(eta^2 - w_j^2) t` in place of cos and sin, critical ones 1 and t.
#[derive(Debug, Clone, PartialEq)]
pub struct Coefficients {
    /// Cosine amplitudes of the free motion, shape `(n,)`, \[m\].
    pub a: DVector<f64>,
    /// Sine amplitudes of the free motion, shape `(n,)`, \[m\]; of a critical mode its slope [m/s].
    pub b: DVector<f64>,
    /// Sine amplitudes of the steady response, shape `(n,)`, \[m\].
    pub sine: DVector<f64>,
    /// Cosine amplitudes of the steady response, shape `(n,)`, \[m\].
    pub cosine: DVector<f64>,
}

/// The coefficients of a state right after the impact at t = 0; `None` where the modes are complex, the forcing has several harmonics, a
/// stop moves, or there is no steady response (undamped resonance, loaded rigid body).
pub(crate) fn coefficients(scene: &ModalScene, phase: f64, after: &[Pair]) -> Option<Coefficients> {
    let Form::Blocks(blocks) = &scene.form.form else {
        return None;
    };
    scene.form.shapes()?;
    if !scene.higher.is_empty() || !scene.excitation.stops.is_empty() {
        return None;
    }
    let n = blocks.len();
    let turn = Complex::from_polar(1.0, phase);
    let mut c = Coefficients {
        a: DVector::zeros(n),
        b: DVector::zeros(n),
        sine: DVector::zeros(n),
        cosine: DVector::zeros(n),
    };
    for (j, &block) in blocks.iter().enumerate() {
        let Block::Oscillator { w2, eta } = block else {
            return None;
        };
        let y = block.steady(scene.frequency, scene.force[j]);
        let rest = block.equilibrium(scene.load[j]);
        let (position, velocity) = (y[0] * turn, y[1] * turn);
        c.cosine[j] = position.re;
        c.sine[j] = -position.im;
        c.a[j] = after[j][0] - position.re - rest[0];
        let slope = after[j][1] - velocity.re + eta * c.a[j];
        let gap = w2 - eta * eta;
        let rate = if w2 > 0.0 {
            ((w2.sqrt() - eta) * (w2.sqrt() + eta)).abs().sqrt()
        } else {
            gap.abs().sqrt()
        };
        c.b[j] = if rate == 0.0 { slope } else { slope / rate };
        if !(c.a[j].is_finite() && c.b[j].is_finite()) {
            return None;
        }
    }
    Some(c)
}

/// The corrected (34), (35) for one mode of the first kind (every stop hit together, b = n, one restitution e): a and b
/// from the mode's steady sine amplitude A. Each mode bounces as if it were alone.
///
/// # References
/// The source paper, eqs. (30) to (35), with the signs of theory section 3.
///
/// # Examples
/// ```
/// use vibroimpact::first_kind_coefficients;
/// // e = 0: the mode stops at each impact, so b wd = eta a - A w.
/// let (w, eta, wd) = (1.5, 0.1, 2.0);
/// let (a, b) = first_kind_coefficients(eta, wd, 0.3, w, 0.0, 3);
/// assert!((b * wd - eta * a + 0.3 * w).abs() < 1e-15);
/// ```
pub fn first_kind_coefficients(
    eta: f64,
    damped_frequency: f64,
    sine: f64,
    frequency: f64,
    restitution: f64,
    n_periods: usize,
) -> (f64, f64) {
    let period = std::f64::consts::TAU * n_periods as f64 / frequency;
    let decay = (-eta * period).exp();
    let (s, c) = (damped_frequency * period).sin_cos();
    let (g, h) = (
        eta * c + damped_frequency * s,
        damped_frequency * c - eta * s,
    );
    let (k, m) = (1.0 - decay * c, decay * s);
    let (n, p) = (
        eta + restitution * decay * g,
        damped_frequency + restitution * decay * h,
    );
    let scale = -Newton::known(restitution).factor() * frequency * sine / (k * p - m * n);
    (scale * m, scale * k)
}
