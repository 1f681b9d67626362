//! One uncoupled block `z' = A z + Re(f e^{i(w t + phase)}) + g` of two real unknowns: a real mode `(y, y')` under,
//! over or critically damped, rigid or unstable; a complex pair; or two real roots. Every quantity the orbits and the
//! flights need of it, without cancellation (theory 4 and 5).

use crate::linalg::exponential::{phi1, phi1_divided};
use crate::linalg::plane::Pair;
use crate::modal::oscillator_roots::{
    OscillatorRoots, oscillator_roots, over_load_response, under_one_minus_cp,
};
use crate::modal::propagation::{Matrix, Propagation};
use crate::tolerance::SPIRAL_TURN;
use nalgebra::Complex;

/// The complex response of a pair to `e^{i phase}`.
pub(crate) type Response = [Complex<f64>; 2];

/// A block of two first-order equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Block {
    /// `y'' + 2 eta y' + w2 y`, unknowns `(y, y')`.
    Oscillator { w2: f64, eta: f64 },
    /// A complex root `sigma + i omega`, unknowns the real and imaginary part.
    Spiral { sigma: f64, omega: f64 },
    /// Two real roots, the smaller modulus first, unknowns each on its own.
    Decays { roots: Pair },
}

impl Block {
    /// The matrix A.
    pub fn matrix(self) -> Matrix {
        match self {
            Self::Oscillator { w2, eta } => [[0.0, 1.0], [-w2, -2.0 * eta]],
            Self::Spiral { sigma, omega } => [[sigma, -omega], [omega, sigma]],
            Self::Decays { roots } => [[roots[0], 0.0], [0.0, roots[1]]],
        }
    }

    /// The two eigenvalues, the one of smaller modulus first where they are real.
    pub fn roots(self) -> Response {
        match self {
            Self::Oscillator { w2, eta } => match oscillator_roots(w2, eta) {
                OscillatorRoots::Under {
                    damped_frequency: wd,
                } => [Complex::new(-eta, wd), Complex::new(-eta, -wd)],
                OscillatorRoots::Over { l1, l2, .. } if l1.abs() <= l2.abs() => {
                    [l1.into(), l2.into()]
                }
                OscillatorRoots::Over { l1, l2, .. } => [l2.into(), l1.into()],
            },
            Self::Spiral { sigma, omega } => {
                [Complex::new(sigma, omega), Complex::new(sigma, -omega)]
            }
            Self::Decays { roots: [a, b] } => [a.into(), b.into()],
        }
    }

    /// `e^{A t}`.
    pub fn propagator(self, t: f64) -> Matrix {
        self.propagation().over(t)
    }

    /// What `e^{A t}` needs at any t, computed once.
    pub fn propagation(self) -> Propagation {
        match self {
            Self::Oscillator { w2, eta } => match oscillator_roots(w2, eta) {
                OscillatorRoots::Under { damped_frequency } => Propagation::Under {
                    w2,
                    eta,
                    damped_frequency,
                },
                OscillatorRoots::Over { l1, l2, half_gap } => Propagation::Over {
                    w2,
                    l1,
                    l2,
                    half_gap,
                },
            },
            Self::Spiral { sigma, omega } => Propagation::Spiral { sigma, omega },
            Self::Decays { roots } => Propagation::Decays { roots },
        }
    }

    /// `I - e^{A t}`, each entry to full relative accuracy for damped blocks.
    pub fn one_minus_propagator(self, t: f64) -> Matrix {
        match self {
            Self::Oscillator { w2, eta } => {
                let s = self.propagator(t)[0][1];
                let upper = match oscillator_roots(w2, eta) {
                    OscillatorRoots::Under {
                        damped_frequency: wd,
                    } => under_one_minus_cp(eta, wd, t),
                    OscillatorRoots::Over { l1, l2, .. } => w2 * over_load_response(l1, l2, t),
                };
                [[upper, -s], [w2 * s, upper + 2.0 * eta * s]]
            }
            Self::Spiral { sigma, omega } => {
                let growth = (sigma * t).exp();
                let half = (0.5 * omega * t).sin();
                let diagonal = 2.0 * growth * half * half - (sigma * t).exp_m1();
                let sin = growth * (omega * t).sin();
                [[diagonal, sin], [-sin, diagonal]]
            }
            Self::Decays { roots } => [
                [-(roots[0] * t).exp_m1(), 0.0],
                [0.0, -(roots[1] * t).exp_m1()],
            ],
        }
    }

    /// `det(I - e^{A t})` to full relative accuracy, and the size it is to be judged by.
    pub fn det_one_minus(self, t: f64) -> (f64, f64) {
        let pair = |sigma: f64, omega: f64| {
            let (growth, half) = ((sigma * t).exp(), (0.5 * omega * t).sin());
            let real = (sigma * t).exp_m1();
            (
                real * real + 4.0 * growth * half * half,
                (growth * growth).max(1.0),
            )
        };
        let real = |l1: f64, l2: f64| {
            (
                (l1 * t).exp_m1() * (l2 * t).exp_m1(),
                ((l1 + l2) * t).exp().max(1.0),
            )
        };
        match self {
            Self::Oscillator { w2, eta } => match oscillator_roots(w2, eta) {
                OscillatorRoots::Under { damped_frequency } => pair(-eta, damped_frequency),
                OscillatorRoots::Over { l1, l2, .. } => real(l1, l2),
            },
            Self::Spiral { sigma, omega } => pair(sigma, omega),
            Self::Decays { roots } => real(roots[0], roots[1]),
        }
    }

    /// The steady response to `f e^{i w t}`: `(i w - A)^-1 f`. Infinite at an undamped resonance.
    pub fn steady(self, w: f64, f: Response) -> Response {
        let [[a, b], [c, d]] = self.matrix();
        let (p, q) = (Complex::new(-a, w), Complex::new(-d, w));
        let det = match self {
            // (w_j - w)(w_j + w) keeps the digits that w_j^2 - w^2 loses.
            Self::Oscillator { w2, eta } if w2 >= 0.0 => {
                let natural = w2.sqrt();
                Complex::new((natural - w) * (natural + w), 2.0 * eta * w)
            }
            _ => p * q - b * c,
        };
        [(q * f[0] + f[1] * b) / det, (f[0] * c + p * f[1]) / det]
    }

    /// Response from rest over `t` to `Re(f e^{i(w r + phase)})`, as the complex pair G of `Re(G e^{i phase})`; sound at
    /// and near resonance and for frequencies and times of any size.
    pub fn forced(self, t: f64, w: f64, f: Response) -> Response {
        let roots = self.roots();
        let turn = Complex::new(0.0, w * t).exp();
        if self.is_off_resonance(t, w) {
            let y = self.steady(w, f);
            let p = self.propagator(t);
            return [
                turn * y[0] - (y[0] * p[0][0] + y[1] * p[0][1]),
                turn * y[1] - (y[0] * p[1][0] + y[1] * p[1][1]),
            ];
        }
        let from_input = |l: Complex<f64>| (l - Complex::new(0.0, w)) * t;
        // int_0^t e^{l (t - r)} e^{i w r} dr
        let exposed = |l| turn * t * phi1(from_input(l));
        match self {
            Self::Oscillator { .. } => {
                debug_assert!(
                    f[0].norm() == 0.0,
                    "a force acts on the velocity of a real mode"
                );
                let [z1, z2] = roots.map(from_input);
                let y = turn * (t * t) * phi1_divided(z1, z2);
                [f[1] * y, f[1] * (roots[0] * y + exposed(roots[1]))]
            }
            Self::Spiral { omega, .. } => {
                // int_0^t e^{sigma (t - r)} (cos, sin)(omega (t - r)) e^{i w r} dr
                let [ahead, behind] = roots.map(exposed);
                let cos = (ahead + behind) * 0.5;
                let sin = if (omega * t).abs() > SPIRAL_TURN {
                    (ahead - behind) * Complex::new(0.0, -0.5)
                } else {
                    let [z1, z2] = roots.map(from_input);
                    turn * (omega * t * t) * phi1_divided(z1, z2)
                };
                [f[0] * cos - f[1] * sin, f[0] * sin + f[1] * cos]
            }
            Self::Decays { .. } => [f[0] * exposed(roots[0]), f[1] * exposed(roots[1])],
        }
    }

    /// The same over a time `t` of whole periods, after which the input is as before: `(I - e^{A t})` of the steady response,
    /// where that is not near resonance. Of an input much faster than the block little is left, with its own digits.
    pub fn forced_over_periods(self, t: f64, w: f64, f: Response) -> Response {
        if !self.is_off_resonance(t, w) {
            return self.forced(t, w, f);
        }
        let (y, left) = (self.steady(w, f), self.one_minus_propagator(t));
        left.map(|row| y[0] * row[0] + y[1] * row[1])
    }

    /// Whether the input turns away from the free motion over `t`: no root is within `1/t` of `i w`.
    fn is_off_resonance(self, t: f64, w: f64) -> bool {
        let squares = self
            .roots()
            .map(|l| ((l - Complex::new(0.0, w)) * t).norm_sqr());
        squares.into_iter().fold(f64::INFINITY, f64::min) >= 1.0
    }

    /// Response from rest over `t` to the constant input `g`.
    #[inline]
    pub fn loaded(self, t: f64, g: Pair) -> Pair {
        let propagation = self.propagation();
        propagation.loaded(t, &propagation.over(t), g)
    }

    /// The equilibrium under the constant input `g`: `-A^-1 g`. Infinite for a rigid-body mode under a load.
    pub fn equilibrium(self, g: Pair) -> Pair {
        match self {
            _ if g == [0.0, 0.0] => g,
            Self::Oscillator { w2, .. } => [g[1] / w2, 0.0],
            Self::Spiral { sigma, omega } => {
                let x = -Complex::new(g[0], g[1]) / Complex::new(sigma, omega);
                [x.re, x.im]
            }
            Self::Decays { roots } => {
                [0, 1].map(|k| if g[k] == 0.0 { 0.0 } else { -g[k] / roots[k] })
            }
        }
    }

    /// The norm `sqrt(z1^2 + weight z0^2)` in which the free block grows no faster than `e^{growth t}`; `softest` is the
    /// frequency that stands in for the one a rigid-body mode does not have.
    pub fn norm(self, softest: f64) -> BlockNorm {
        match self {
            Self::Oscillator { w2, eta } => {
                // Of a block that leaves its place this is the rate of its leaving.
                let kappa = w2.abs().max(softest * softest).sqrt();
                let coupling = 0.5 * (kappa * kappa - w2) / kappa;
                BlockNorm {
                    weight: kappa * kappa,
                    growth: (eta.hypot(coupling) - eta).max(0.0),
                }
            }
            Self::Spiral { sigma, .. } => BlockNorm {
                weight: 1.0,
                growth: sigma.max(0.0),
            },
            Self::Decays { roots } => BlockNorm {
                weight: 1.0,
                growth: roots[0].max(roots[1]).max(0.0),
            },
        }
    }

    /// The parts along the eigenvectors E of a block that decays without turning, none of which grows; none of a block whose roots
    /// are so near each other that the parts cancel.
    pub fn parts(self) -> Option<BlockParts> {
        let roots = self.roots();
        if roots.iter().any(|l| l.im != 0.0 || l.re > 0.0) {
            return None;
        }
        let [slow, fast] = roots.map(|l| l.re);
        match self {
            Self::Oscillator { .. } if fast <= 2.0 * slow && fast < 0.0 => {
                let apart = slow - fast;
                Some(BlockParts {
                    rows: [[-fast / apart, 1.0 / apart], [slow / apart, -1.0 / apart]],
                    images: [[slow, slow * slow], [fast, fast * fast]],
                })
            }
            Self::Decays { roots: [a, b] } => Some(BlockParts {
                rows: [[1.0, 0.0], [0.0, 1.0]],
                images: [[a, 0.0], [0.0, b]],
            }),
            _ => None,
        }
    }
}

/// The parts of a block along its eigenvectors, see [`Block::parts`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockParts {
    /// Row by row what takes the parts from the unknowns.
    rows: Matrix,
    /// The unknowns that are one part alone, each times its root: the columns of `A E`.
    images: [Pair; 2],
}

impl BlockParts {
    /// Rows whose sizes on a third derivative bound, for good, what the block adds to the fourth derivative of a quantity that is
    /// a row of its unknowns.
    pub fn fourth_derivatives(&self, row: Pair) -> [Pair; 2] {
        [0, 1].map(|part| {
            let image = self.images[part];
            let share = row[0] * image[0] + row[1] * image[1];
            self.rows[part].map(|x| share * x)
        })
    }
}

/// See [`Block::norm`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct BlockNorm {
    pub weight: f64,
    pub growth: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, dmatrix};

    const BLOCKS: [Block; 12] = [
        Block::Oscillator { w2: 4.0, eta: 0.1 },
        Block::Oscillator { w2: 4.0, eta: 0.0 },
        Block::Oscillator { w2: 4.0, eta: 2.0 },
        Block::Oscillator {
            w2: 4.0,
            eta: 2.0 + 2e-12,
        },
        Block::Oscillator {
            w2: 4.0,
            eta: 2.0 - 2e-12,
        },
        Block::Oscillator { w2: 4.0, eta: 30.0 },
        Block::Oscillator { w2: 0.0, eta: 0.0 },
        Block::Oscillator { w2: 0.0, eta: 0.3 },
        Block::Oscillator { w2: -1.0, eta: 0.2 },
        Block::Oscillator { w2: 4.0, eta: -0.1 },
        Block::Spiral {
            sigma: -0.2,
            omega: 1.5,
        },
        Block::Decays {
            roots: [-0.5, -3.0],
        },
    ];

    /// `exp` of the block enlarged by `(1, cos, sin)`: response over t from `z`, an independent route.
    fn enlarged(block: Block, t: f64, w: f64, f: Response, g: Pair) -> DMatrix<f64> {
        let [[a, b], [c, d]] = block.matrix();
        let big = dmatrix![
            a, b, g[0], f[0].re, -f[0].im;
            c, d, g[1], f[1].re, -f[1].im;
            0.0, 0.0, 0.0, 0.0, 0.0;
            0.0, 0.0, 0.0, 0.0, -w;
            0.0, 0.0, 0.0, w, 0.0
        ];
        (big * t).exp()
    }

    #[test]
    fn propagator_and_responses_agree_with_the_enlarged_exponential() {
        for block in BLOCKS {
            for w in [1e-6, 0.3, 2.0, 2.0 + 1e-12, 1.5, 7.0] {
                for t in [1e-3, 0.4, 3.0] {
                    let on_velocity = matches!(block, Block::Oscillator { .. });
                    let first = if on_velocity {
                        Complex::new(0.0, 0.0)
                    } else {
                        Complex::new(0.3, 0.4)
                    };
                    let f = [first, Complex::new(0.7, -0.2)];
                    let g = if on_velocity { [0.0, 0.5] } else { [0.2, 0.5] };
                    let (exact, p) = (enlarged(block, t, w, f, g), block.propagator(t));
                    let (forced, loaded) = (block.forced(t, w, f), block.loaded(t, g));
                    for i in 0..2 {
                        let got = [p[i][0], p[i][1], loaded[i], forced[i].re, -forced[i].im];
                        for j in 0..5 {
                            let error = (got[j] - exact[(i, j)]).abs();
                            assert!(
                                error < 4e-14 * (1.0 + exact.amax()),
                                "{block:?} w {w} t {t} ({i}, {j}): {error:e}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_block_that_hardly_turns_is_forced_as_an_oscillator_is() {
        // The second unknown of a spiral pushed at its first, over omega: the place of an oscillator.
        let f = Complex::new(0.7, -0.2);
        for sigma in [0.0, -0.3, 0.2] {
            for omega in [2e-8, 1e-4, 0.03, 0.7, 4.0] {
                let spiral = Block::Spiral { sigma, omega };
                let oscillator = Block::Oscillator {
                    w2: sigma * sigma + omega * omega,
                    eta: -sigma,
                };
                for w in [1e-3, 0.122, 2.0] {
                    for t in [1e-3, 0.1, 0.35, 2.0] {
                        let place = spiral.forced(t, w, [f, 0.0.into()])[1] / omega;
                        let speed = spiral.forced(t, w, [0.0.into(), f])[0] / omega;
                        let other = oscillator.forced(t, w, [0.0.into(), f])[0];
                        for (place, sign) in [(place, 1.0), (speed, -1.0)] {
                            let off = (place * sign - other).norm();
                            assert!(
                                off < 1e-14 * other.norm(),
                                "{spiral:?} w {w} t {t}: {off:e} of {other:e}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn one_minus_propagator_keeps_its_digits_over_short_times() {
        for block in BLOCKS {
            let t = 1e-6;
            let [[a, b], [c, d]] = block.matrix();
            // I - e^{At} = -(A t + A^2 t^2/2 + A^3 t^3/6 + ...)
            let m = dmatrix![a, b; c, d] * t;
            let series = -(&m + &m * &m / 2.0 + &m * &m * &m / 6.0 + &m * &m * &m * &m / 24.0);
            let got = block.one_minus_propagator(t);
            for i in 0..2 {
                for j in 0..2 {
                    let scale = series[(i, j)].abs().max(1e-28);
                    assert!(
                        (got[i][j] - series[(i, j)]).abs() < 1e-14 * scale,
                        "{block:?} ({i}, {j})"
                    );
                }
            }
            let det = series[(0, 0)] * series[(1, 1)] - series[(0, 1)] * series[(1, 0)];
            assert!(
                (block.det_one_minus(t).0 - det).abs() <= 1e-9 * det.abs(),
                "{block:?}"
            );
        }
    }

    #[test]
    fn stiff_overdamped_blocks_neither_overflow_nor_lose_the_slow_root() {
        let block = Block::Oscillator { w2: 1.0, eta: 1e3 };
        let p = block.propagator(1e4);
        let slow = -1.0 / (1e3 + (1e6f64 - 1.0).sqrt());
        assert!(
            (p[0][0] / ((slow * 1e4).exp() * (1.0 - slow / (2.0 * (1e6f64 - 1.0).sqrt()))) - 1.0)
                .abs()
                < 1e-12
        );
        assert!(
            block
                .forced(1e4, 1.0, [0.0.into(), 1.0.into()])
                .iter()
                .all(|z| z.is_finite())
        );
    }

    #[test]
    fn a_block_that_leaves_its_place_grows_by_its_own_rate_beside_a_soft_one() {
        for eta in [0.0, 0.3, 7.0] {
            let block = Block::Oscillator { w2: -0.49, eta };
            let growth = eta.hypot(0.7) - eta;
            for softest in [1e-9, 1e-3, 0.7] {
                let found = block.norm(softest).growth;
                assert!((found - growth).abs() < 1e-15, "{eta} {softest}: {found}");
            }
        }
    }

    #[test]
    fn the_norm_bounds_the_growth() {
        for block in BLOCKS {
            let norm = block.norm(0.5);
            let size = |z: Pair| (z[1] * z[1] + norm.weight * z[0] * z[0]).sqrt();
            for step in 0..64 {
                let angle = f64::from(step) * 0.1;
                let z = [angle.cos(), angle.sin()];
                for t in [0.01, 0.3, 1.0, 4.0] {
                    let p = block.propagator(t);
                    let moved = [
                        p[0][0] * z[0] + p[0][1] * z[1],
                        p[1][0] * z[0] + p[1][1] * z[1],
                    ];
                    assert!(
                        size(moved) <= size(z) * (norm.growth * t).exp() * (1.0 + 1e-13),
                        "{block:?} {t}"
                    );
                }
            }
        }
    }
}
