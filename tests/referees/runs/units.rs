//! A scene in other units. Lengths change by a power of two, so that places which are equal, or zero, stay so; times and masses by
//! factors that change every rounding. A mistake answers in all units; what rounding alone decides does not.

use crate::runs::case::{Case, ForceCase, StopCase};
use crate::runs::compare::{self, Verdict};

/// What lengths, times and masses are multiplied by.
const UNITS: [[f64; 3]; 3] = [[4.0, 1.1, 0.7], [0.5, 0.37, 1.9], [1.0, 2.3, 3.1]];

impl Case {
    /// The same scene and start, its numbers those of other units.
    pub fn in_units(&self, [length, time, mass]: [f64; 3]) -> Self {
        let stiffness = mass / (time * time);
        let force = stiffness * length;
        let times = |values: &[f64], by: f64| values.iter().map(|x| x * by).collect();
        let in_units = |f: &ForceCase| ForceCase {
            re: times(&f.re, force),
            im: times(&f.im, force),
            frequency: f.frequency / time,
            phase: f.phase,
        };
        Self {
            label: self.label.clone(),
            mass: &self.mass * mass,
            damping: &self.damping * (mass / time),
            stiffness: &self.stiffness * stiffness,
            load: times(&self.load, force),
            force: self.force.as_ref().map(in_units),
            more: self.more.iter().map(in_units).collect(),
            stops: (self.stops.iter())
                .map(|stop| StopCase {
                    clearance: stop.clearance * length,
                    ..stop.clone()
                })
                .collect(),
            q0: times(&self.q0, length),
            v0: times(&self.v0, length / time),
            span: (self.span.0 * time, self.span.1 * time),
            method: self.method,
            rtol: self.rtol,
            atol: self.atol * length,
        }
    }
}

/// Whether the library and the referee agree on a scene in all other units.
pub fn agree_in_others(case: &Case) -> bool {
    let agree = |units| matches!(compare::judge(&case.in_units(units)), Verdict::Agree(..));
    UNITS.into_iter().all(agree)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::generator;

    #[test]
    fn the_motion_is_the_same() {
        let units = UNITS[0];
        for number in [3, 5, 8] {
            let case = generator::scene(1, number);
            let other = case.in_units(units);
            let run = |case: &Case| {
                let (q0, v0) = (case.q0.clone().into(), case.v0.clone().into());
                let options = vibroimpact::SimulateOptions::default();
                let end = case.span.0 + 0.01 * (case.span.1 - case.span.0);
                let scene = case.scene().expect("valid");
                let run = vibroimpact::simulate(&scene, &q0, &v0, (case.span.0, end), &options);
                let run = run.expect("valid");
                let (q, v) = run.last();
                (q.clone(), v.clone())
            };
            let ((q, v), (other_q, other_v)) = (run(&case), run(&other));
            let is_same = |a: nalgebra::DVector<f64>, b: nalgebra::DVector<f64>| {
                (a - &b).amax() <= 1e-9 * b.amax()
            };
            assert!(is_same(q * units[0], other_q), "{number}");
            assert!(is_same(v * (units[0] / units[1]), other_v), "{number}");
        }
    }
}
