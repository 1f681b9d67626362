//! Scenes whose stop is passed by little: it is put where the highest point of the motion without it is, less an overshoot.

use crate::runs::case::Case;
use crate::runs::double_double::Dd;
use crate::runs::motion::Model;
use crate::runs::simulator::follow;

/// Times looked at in one round, each round between the neighbours of the best of the one before.
const POINTS: usize = 400;
const ROUNDS: usize = 6;

/// Keeps the first stop alone, and lets the motion pass it by a part of its height; false where that is highest at an end.
pub fn make_shallow(case: &mut Case, overshoot: f64) -> bool {
    let Some(mut stop) = case.stops.first().cloned() else {
        return false;
    };
    case.stops.clear();
    let model = Model::new(case, &[1.0; 7]);
    let normal = stop.outward();
    let duration = Dd::from(case.span.1) - Dd::from(case.span.0);
    let height = |q: &[f64]| normal.iter().zip(q).map(|(n, q)| n * q).sum::<f64>();
    let (mut low, mut high) = (0.0, duration.to_f64());
    let mut best = f64::NAN;
    for _ in 0..ROUNDS {
        let step = (high - low) / POINTS as f64;
        let times: Vec<Dd> = (0..POINTS)
            .map(|k| Dd::from(low + step * k as f64))
            .collect();
        let start = model.start(case, &[1.0; 7]);
        let record = follow(&model, start, duration, &times, None, usize::MAX);
        let heights: Vec<f64> = record.samples.iter().map(|x| height(x)).collect();
        let highest = (0..heights.len()).max_by(|&i, &j| heights[i].total_cmp(&heights[j]));
        let Some(k) = highest.filter(|&k| k > 0 && k + 1 < POINTS) else {
            return false;
        };
        best = heights[k];
        (low, high) = (times[k - 1].to_f64(), times[k + 1].to_f64());
    }
    stop.clearance = best - overshoot * best.abs();
    let is_open = stop.gap(&case.q0) > 0.0;
    case.stops.push(stop);
    is_open
}
