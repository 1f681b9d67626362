//! The midpoint rule, extrapolated to a step of none (Gragg, Bulirsch and Stoer): the slow integrator of the referees.

/// Steps of the midpoint rule, whose results are extrapolated.
const COLUMNS: [usize; 8] = [2, 4, 6, 8, 10, 12, 14, 16];

/// The state a time after another, of a motion with a slope.
pub fn extrapolated(
    slope: impl Fn(f64, &[f64]) -> Vec<f64>,
    (t, x): (f64, &[f64]),
    dt: f64,
) -> Vec<f64> {
    let shifted = |x: &[f64], k: &[f64], h: f64| -> Vec<f64> {
        x.iter().zip(k).map(|(x, k)| x + h * k).collect()
    };
    let first = slope(t, x);
    let mut last: Vec<Vec<f64>> = Vec::new();
    for (place, &count) in COLUMNS.iter().enumerate() {
        let h = dt / count as f64;
        let (mut before, mut now) = (x.to_vec(), shifted(x, &first, h));
        for k in 1..count {
            let next = shifted(&before, &slope(t + k as f64 * h, &now), 2.0 * h);
            (before, now) = (now, next);
        }
        let mut row = vec![now];
        for k in 1..=place {
            let ratio = (count as f64 / COLUMNS[place - k] as f64).powi(2) - 1.0;
            let change = shifted(&row[k - 1], &last[k - 1], -1.0);
            row.push(shifted(&row[k - 1], &change, 1.0 / ratio));
        }
        last = row;
    }
    last.pop().expect("a column")
}
