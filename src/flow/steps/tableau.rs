//! Coefficients of explicit Runge-Kutta pairs. Dormand and Prince, A family of embedded Runge-Kutta formulae, J. Comp.
//! Appl. Math. 6 (1980) 19; the dense output is Shampine's, as in Hairer, Norsett and Wanner, Solving Ordinary
//! Differential Equations I, section II.6.

/// Stages of the Dormand-Prince pair, the last of which is the first of the next step. [exact]
pub(crate) const DOPRI5_STAGES: usize = 7;

/// Nodes of stages 2 to 7. [exact]
pub(crate) const DOPRI5_NODES: [f64; DOPRI5_STAGES - 1] = [0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];

/// Rows of stages 2 to 7; the last row is the solution. [exact]
pub(crate) const DOPRI5_ROWS: [[f64; DOPRI5_STAGES - 1]; DOPRI5_STAGES - 1] = [
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// The solution of order 5 less that of order 4. [exact]
pub(crate) const DOPRI5_ERROR: [f64; DOPRI5_STAGES] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// The last coefficient of the dense output, of order 4. [exact]
pub(crate) const DOPRI5_DENSE: [f64; DOPRI5_STAGES] = [
    -12_715_105_075.0 / 11_282_082_432.0,
    0.0,
    87_487_479_700.0 / 32_700_410_799.0,
    -10_690_763_975.0 / 1_880_347_072.0,
    701_980_252_875.0 / 199_316_789_632.0,
    -1_453_857_185.0 / 822_651_844.0,
    69_997_945.0 / 29_380_423.0,
];

#[cfg(test)]
mod tests {
    use super::*;

    fn row(i: usize) -> Vec<f64> {
        let mut row = vec![0.0; DOPRI5_STAGES];
        if i > 0 {
            row[..DOPRI5_STAGES - 1].copy_from_slice(&DOPRI5_ROWS[i - 1]);
        }
        row
    }

    fn node(i: usize) -> f64 {
        if i == 0 { 0.0 } else { DOPRI5_NODES[i - 1] }
    }

    /// `sum_j a_ij x_j`
    fn through(x: &[f64]) -> Vec<f64> {
        (0..DOPRI5_STAGES)
            .map(|i| row(i).iter().zip(x).map(|(a, x)| a * x).sum())
            .collect()
    }

    /// The elementary weights of every rooted tree up to order 5, with their densities.
    fn trees() -> Vec<(usize, Vec<f64>, f64)> {
        let one = vec![1.0; DOPRI5_STAGES];
        let c: Vec<f64> = (0..DOPRI5_STAGES).map(node).collect();
        let times =
            |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
        let power = |k: i32| -> Vec<f64> { c.iter().map(|c| c.powi(k)).collect() };
        let (c2, c3, c4) = (power(2), power(3), power(4));
        let ac = through(&c);
        let (ac2, aac) = (through(&c2), through(&ac));
        vec![
            (1, one, 1.0),
            (2, c.clone(), 2.0),
            (3, c2.clone(), 3.0),
            (3, ac.clone(), 6.0),
            (4, c3.clone(), 4.0),
            (4, times(&c, &ac), 8.0),
            (4, ac2.clone(), 12.0),
            (4, aac.clone(), 24.0),
            (5, c4, 5.0),
            (5, times(&c2, &ac), 10.0),
            (5, times(&ac, &ac), 20.0),
            (5, times(&c, &ac2), 15.0),
            (5, times(&c, &aac), 30.0),
            (5, through(&c3), 20.0),
            (5, through(&times(&c, &ac)), 40.0),
            (5, through(&ac2), 60.0),
            (5, through(&aac), 120.0),
        ]
    }

    #[test]
    fn rows_add_up_to_their_nodes() {
        for i in 0..DOPRI5_STAGES {
            assert!((row(i).iter().sum::<f64>() - node(i)).abs() < 1e-14);
        }
    }

    #[test]
    fn the_pair_meets_its_order_conditions() {
        let weights = row(DOPRI5_STAGES - 1);
        for (order, tree, density) in trees() {
            let dot = |b: &[f64]| -> f64 { b.iter().zip(&tree).map(|(b, t)| b * t).sum() };
            assert!(
                (dot(&weights) - 1.0 / density).abs() < 1e-15,
                "{order} {density}"
            );
            // The error estimate vanishes up to order 4 and not beyond.
            if order < 5 {
                assert!(dot(&DOPRI5_ERROR).abs() < 1e-15, "{order} {density}");
            }
        }
        let fifth: f64 = trees()
            .iter()
            .filter(|(order, ..)| *order == 5)
            .map(|(_, tree, _)| {
                DOPRI5_ERROR
                    .iter()
                    .zip(tree)
                    .map(|(e, t)| e * t)
                    .sum::<f64>()
                    .abs()
            })
            .fold(0.0, f64::max);
        assert!(fifth > 1e-4);
    }

    #[test]
    fn the_dense_output_is_of_order_four_at_every_point() {
        // y0 + x (dy + (1 - x)(h k1 - dy + x (2 dy - h k1 - h k7 + (1 - x) h D))), dy = h sum b k: the weights at x.
        let b = row(DOPRI5_STAGES - 1);
        for step in 1..10 {
            let x = f64::from(step) / 10.0;
            let weights: Vec<f64> = (0..DOPRI5_STAGES)
                .map(|i| {
                    let (first, last) = (f64::from(u8::from(i == 0)), f64::from(u8::from(i == 6)));
                    x * (b[i]
                        + (1.0 - x)
                            * (first - b[i]
                                + x * (2.0 * b[i] - first - last + (1.0 - x) * DOPRI5_DENSE[i])))
                })
                .collect();
            for (order, tree, density) in trees() {
                if order <= 4 {
                    let got: f64 = weights.iter().zip(&tree).map(|(w, t)| w * t).sum();
                    let exact = x.powi(i32::try_from(order).expect("small")) / density;
                    assert!((got - exact).abs() < 1e-14, "{order} {density} {x}");
                }
            }
        }
    }
}
