//! The Dormand-Prince pair of orders 5 and 4 on `q'' = a(t, q, v)`, with its quartic dense output (theory 8). Dormand and Prince, A
//! family of embedded Runge-Kutta formulae, J. Comp. Appl. Math. 6 (1980) 19; the dense output is Shampine's, as in Hairer, Norsett and
//! Wanner, Solving Ordinary Differential Equations I, section II.6.

use crate::flow::steps::control::StepControl;
use crate::flow::steps::explicit_rk::{ButcherTableau, EmbeddedError, ExplicitRk};

/// The tableau of the pair.
#[derive(Debug)]
pub(crate) struct DormandPrinceTableau;

/// The pair, with the step last taken: afterwards the end is the state of order 5 there.
pub(crate) type DormandPrince<S> = ExplicitRk<DormandPrinceTableau, S, 7, 4>;

impl ButcherTableau for DormandPrinceTableau {
    const NODES: &'static [f64] = &[0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
    const ROWS: &'static [&'static [f64]] = &[
        &[0.2],
        &[3.0 / 40.0, 9.0 / 40.0],
        &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
        &[
            19372.0 / 6561.0,
            -25360.0 / 2187.0,
            64448.0 / 6561.0,
            -212.0 / 729.0,
        ],
        &[
            9017.0 / 3168.0,
            -355.0 / 33.0,
            46732.0 / 5247.0,
            49.0 / 176.0,
            -5103.0 / 18656.0,
        ],
        &[
            35.0 / 384.0,
            0.0,
            500.0 / 1113.0,
            125.0 / 192.0,
            -2187.0 / 6784.0,
            11.0 / 84.0,
        ],
    ];
    /// The last stage of the solution. [exact]
    const END: usize = 6;
    // The solution of order 5 less that of order 4.
    const ERROR: EmbeddedError = EmbeddedError::One(&[
        71.0 / 57600.0,
        0.0,
        -71.0 / 16695.0,
        71.0 / 1920.0,
        -17253.0 / 339_200.0,
        22.0 / 525.0,
        -1.0 / 40.0,
    ]);
    const DENSE: &'static [&'static [f64]] = &[&[
        -12_715_105_075.0 / 11_282_082_432.0,
        0.0,
        87_487_479_700.0 / 32_700_410_799.0,
        -10_690_763_975.0 / 1_880_347_072.0,
        701_980_252_875.0 / 199_316_789_632.0,
        -1_453_857_185.0 / 822_651_844.0,
        69_997_945.0 / 29_380_423.0,
    ]];
    const HAS_QUINTIC: bool = true;
    const CONTROL: StepControl = StepControl {
        order: 5,
        beta: 0.04,
        least: 0.2,
        most: 10.0,
        kept_below: 1.0,
    };
    /// The stability limit on the negative real axis. [exact]
    const STABLE: f64 = 3.25;
}
