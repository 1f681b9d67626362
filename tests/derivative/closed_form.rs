//! One degree of freedom with one impact: `(d + a u)^2 + (b u/w)^2 = F^2/z^2` (theory 19, "closed forms") gives every derivative of the
//! speed u exactly.

use crate::scenes::{harmonic, periods, scene, unit_mass, upper};
use std::f64::consts::TAU;
use vibroimpact::{
    Parameter, Pattern, PeriodicOrbit, derivatives, derivatives_but_multipliers, derivatives_of,
    periodic_orbits,
};

/// `x'' + 2 eta x' + x = F cos w t` before a stop at d with restitution e.
#[derive(Debug, Clone, Copy)]
struct Oscillator {
    eta: f64,
    force: f64,
    frequency: f64,
    clearance: f64,
    restitution: f64,
}

const ALL: [Oscillator; 3] = [
    Oscillator {
        eta: 0.05,
        force: 8.5,
        frequency: 2.4,
        clearance: 1.0,
        restitution: 0.8,
    },
    Oscillator {
        eta: 0.2,
        force: 1.0,
        frequency: 2.8,
        clearance: -0.5,
        restitution: 0.3,
    },
    Oscillator {
        eta: 0.01,
        force: 3.0,
        frequency: 1.3,
        clearance: 0.02,
        restitution: 0.6,
    },
];

impl Oscillator {
    fn orbits(self, n_periods: usize) -> Vec<PeriodicOrbit> {
        let force = harmonic(&[self.force], self.frequency, 0.0);
        let stop = upper(0, self.clearance, self.restitution);
        let scene = scene(unit_mass(2.0 * self.eta, 1.0), force, [stop]);
        let found = periodic_orbits(&scene, &Pattern::single(0), &periods(n_periods));
        found.expect("a search").into_iter().collect()
    }

    /// a, b, their derivatives by e, and z.
    fn closed(self, n_periods: usize) -> ([f64; 2], [f64; 2], f64) {
        let Self {
            eta,
            frequency: w,
            restitution: e,
            ..
        } = self;
        let t = TAU * n_periods as f64 / w;
        let own = (1.0 - eta * eta).sqrt();
        let (decay, angle) = ((-eta * t).exp(), own * t);
        let s = decay * angle.sin() / own;
        let cos = decay * angle.cos();
        let end = (-2.0 * eta * t).exp();
        let all = 1.0 - 2.0 * cos + end;
        let by_e = [s / all, (cos - eta * s - end) / all];
        let [a, b] = by_e.map(|x| (1.0 + e) * x);
        ([a, 1.0 + b], by_e, (1.0 - w * w).hypot(2.0 * eta * w))
    }

    /// du/dF, du/dd and du/de at a speed u: of `f = (d + a u)^2 + (b u/w)^2 - (F/z)^2`.
    fn speed_by(self, n_periods: usize, u: f64) -> [f64; 3] {
        let ([a, b], [a_e, b_e], z) = self.closed(n_periods);
        let Self {
            force,
            frequency: w,
            clearance: d,
            ..
        } = self;
        let across = d + a * u;
        let by_u = 2.0 * across * a + 2.0 * b * b * u / (w * w);
        let by_e = 2.0 * across * a_e * u + 2.0 * b * b_e * (u / w).powi(2);
        [2.0 * force / (z * z), -2.0 * across, -by_e].map(|own| own / by_u)
    }
}

#[test]
fn speeds_have_the_derivatives_of_the_closed_form() {
    let mut count = 0;
    for own in ALL {
        for n_periods in [1, 2, 3] {
            for orbit in own.orbits(n_periods) {
                let numbers = [
                    Parameter::ForcingScale,
                    Parameter::CLEARANCE,
                    Parameter::RESTITUTION,
                ];
                let found = derivatives(&orbit, &numbers).expect("derivatives");
                let speed = orbit.impacts()[0].approach;
                let exact = own.speed_by(n_periods, speed);
                let exact = [exact[0] * own.force, exact[1], exact[2]];
                for (i, exact) in exact.iter().enumerate() {
                    let own_rate = found.speeds_before[(0, i)];
                    assert!(
                        (own_rate - exact).abs() < 1e-9 * exact.abs().max(1e-2 * speed),
                        "{own:?} {n_periods} {i}: {own_rate} {exact}"
                    );
                    // At the impact the place is the stop's.
                    let moved = if i == 1 { 1.0 } else { 0.0 };
                    assert!((found.q0[(0, i)] - moved).abs() < 1e-9 * exact.abs().max(1.0));
                    assert!(found.period[i].abs() < 1e-9);
                    if orbit.is_admissible() == Some(true) {
                        assert_eq!(found.min_gap[(0, i)], 0.0);
                    }
                }
                count += 1;
            }
        }
    }
    assert!(count > 8, "{count}");
}

/// All multiples of the scene's lengths are the same motion: F and d times a factor.
#[test]
fn numbers_of_one_dimension_scale_together() {
    for orbit in ALL[0].orbits(1) {
        let numbers = [Parameter::ForcingScale, Parameter::CLEARANCE];
        let found = derivatives(&orbit, &numbers).expect("derivatives");
        let d = ALL[0].clearance;
        let together = |by: [f64; 2]| by[0] + d * by[1];
        let displaced = orbit.max_displacement().expect("positions")[0];
        let own = &found.max_displacement;
        assert!((together([own[(0, 0)], own[(0, 1)]]) / displaced - 1.0).abs() < 1e-9);
        assert!(together([found.phase[0], found.phase[1]]).abs() < 1e-9);
        for i in 0..2 {
            let mu = &found.multipliers;
            let own = mu[(i, 0)] + mu[(i, 1)] * d;
            assert!(own.norm() < 1e-8, "{own}");
        }
    }
}

#[test]
fn without_multipliers_the_rest_is_the_same() {
    let orbit = &ALL[0].orbits(1)[0];
    let scene = orbit.scene();
    let make = |p: &[f64]| scene.replace(Parameter::CLEARANCE.change(p[0]));
    let start = [ALL[0].clearance];
    let all = derivatives_of(orbit, &make, &start).expect("derivatives");
    let rest = derivatives_but_multipliers(orbit, &make, &start).expect("derivatives");
    assert_eq!(
        (&all.v0, &all.times, &all.phase),
        (&rest.v0, &rest.times, &rest.phase)
    );
    assert_eq!(all.max_displacement, rest.max_displacement);
    assert!(all.multipliers.iter().all(|mu| mu.re.is_finite()));
    assert!(rest.multipliers.iter().all(|mu| mu.re.is_nan()) && rest.reason.is_empty());
}
