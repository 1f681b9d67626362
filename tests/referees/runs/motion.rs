//! The smooth motion of a linear scene while given stops are held: the state `x = (q, v, 1, cos, sin, ...)` obeys `x' = A x` with a
//! constant matrix, and is moved by Taylor series with nodes so dense that the fastest rate times their distance is below 0.3.

use crate::runs::case::{Case, Push};
use crate::runs::double_double::{Dd, Matrix, dot};
use nalgebra::{DMatrix, DVector};

/// Order of the Taylor series: `0.6^24 / 24!` is below 1e-28.
pub const ORDER: usize = 24;

/// A stop in the referee's numbers.
pub struct Plane {
    pub normal: Vec<Dd>,
    pub reaction: Vec<Dd>,
    pub clearance: Dd,
    pub restitution: f64,
}

/// The scene in the referee's numbers, and what does not depend on the stops held.
pub struct Model {
    pub n: usize,
    /// Free acceleration `a = rows . x`.
    pub free: Matrix,
    /// Those of the forces, whose cosines and sines end a state.
    pub frequencies: Vec<Dd>,
    pub stops: Vec<Plane>,
    /// `N^T B`
    pub delassus: Matrix,
    /// Distance of nodes.
    pub step: f64,
    pub rate: f64,
}

/// Factors on mass, damping, stiffness, load, force, initial position and velocity: near one, to see what the answer is sensitive to.
pub type Factors = [f64; 7];

impl Model {
    pub fn new(case: &Case, factors: &Factors) -> Self {
        let n = case.n();
        let scaled = |x: f64, k: usize| Dd::from(x) * Dd::from(factors[k]);
        let rows = |a: &DMatrix<f64>, k: usize| Matrix {
            rows: (0..n)
                .map(|i| (0..n).map(|j| scaled(a[(i, j)], k)).collect())
                .collect(),
        };
        let mass = rows(&case.mass, 0);
        let (damping, stiffness) = (rows(&case.damping, 1), rows(&case.stiffness, 2));
        let solve = |b: Vec<Dd>| mass.solve(&b).expect("a positive definite mass");
        let mut free = Matrix::zeros(n, 2 * n + 1 + 2 * case.forces().count());
        let mut put = |column: usize, b: Vec<Dd>, sign: f64| {
            for (i, x) in solve(b).into_iter().enumerate() {
                free.rows[i][column] = x * sign;
            }
        };
        for j in 0..n {
            put(j, stiffness.rows.iter().map(|r| r[j]).collect(), -1.0);
            put(n + j, damping.rows.iter().map(|r| r[j]).collect(), -1.0);
        }
        put(
            2 * n,
            case.load.iter().map(|&x| scaled(x, 3)).collect(),
            1.0,
        );
        for (k, f) in case.forces().enumerate() {
            let place = 2 * n + 1 + 2 * k;
            put(place, f.re.iter().map(|&x| scaled(x, 4)).collect(), 1.0);
            let im = f.im.iter().map(|&x| scaled(x, 4)).collect();
            put(place + 1, im, -1.0);
        }
        let stops: Vec<Plane> = case
            .stops
            .iter()
            .map(|stop| {
                let normal: Vec<Dd> = stop.outward().into_iter().map(Dd::from).collect();
                let reaction = match &stop.push {
                    Push::Inertia => solve(normal.clone()),
                    Push::Coordinate => normal.clone(),
                    Push::Direction(b) => b
                        .iter()
                        .map(|&x| Dd::from(if stop.lower { -x } else { x }))
                        .collect(),
                };
                Plane {
                    normal,
                    reaction,
                    clearance: Dd::from(stop.clearance),
                    restitution: stop.restitution,
                }
            })
            .collect();
        let delassus = Matrix {
            rows: stops
                .iter()
                .map(|i| stops.iter().map(|j| dot(&i.normal, &j.reaction)).collect())
                .collect(),
        };
        let w = case.forces().map(|f| f.frequency).fold(0.0, f64::max);
        let span = case.span.1 - case.span.0;
        let rate = fastest_rate(&free, n, span).max(w).max(4.0 * 0.3 / span);
        Self {
            n,
            free,
            frequencies: case.forces().map(|f| Dd::from(f.frequency)).collect(),
            stops,
            delassus,
            step: (0.3 / rate).log2().floor().exp2(),
            rate,
        }
    }

    pub fn start(&self, case: &Case, factors: &Factors) -> Vec<Dd> {
        let mut x: Vec<Dd> = case.q0.iter().map(|&q| Dd::from(q) * factors[5]).collect();
        x.extend(case.v0.iter().map(|&v| Dd::from(v) * factors[6]));
        x.extend(self.forcing_at(case, case.span.0));
        x
    }

    /// The end of a state: one, and cosine and sine of each force.
    pub fn forcing_at(&self, case: &Case, time: f64) -> Vec<Dd> {
        let turned = case.forces().zip(&self.frequencies).flat_map(|(f, &w)| {
            let (cos, sin) = (w * Dd::from(time) + Dd::from(f.phase)).cos_sin();
            [cos, sin]
        });
        std::iter::once(Dd::ONE).chain(turned).collect()
    }

    /// The numbers of a state.
    pub fn size(&self) -> usize {
        2 * self.n + 1 + 2 * self.frequencies.len()
    }

    /// The rates of the end of a state.
    pub fn turning(&self, x: &[Dd]) -> Vec<Dd> {
        turning(&self.frequencies, &x[2 * self.n..])
    }

    /// The opening speed of a stop.
    pub fn opening(&self, stop: usize, x: &[Dd]) -> Dd {
        -dot(&self.stops[stop].normal, &x[self.n..2 * self.n])
    }

    pub fn gap(&self, stop: usize, x: &[Dd]) -> Dd {
        let plane = &self.stops[stop];
        plane.clearance - dot(&plane.normal, &x[..self.n])
    }
}

/// The rates of one, and of the cosine and sine of each frequency.
fn turning(frequencies: &[Dd], end: &[Dd]) -> Vec<Dd> {
    let turned = frequencies.iter().enumerate().flat_map(|(k, &w)| {
        let (cos, sin) = (end[1 + 2 * k], end[2 + 2 * k]);
        [-(w * sin), w * cos]
    });
    std::iter::once(Dd::ZERO).chain(turned).collect()
}

/// Gelfand's `|A^16|^(1/16)` with velocities scaled to positions: the modulus of the fastest eigenvalue, or somewhat more.
fn fastest_rate(free: &Matrix, n: usize, span: f64) -> f64 {
    let entry = |i: usize, j: usize| free.rows[i][j].to_f64();
    let k = DMatrix::from_fn(n, n, entry);
    let c = DMatrix::from_fn(n, n, |i, j| entry(i, n + j));
    let r = k.norm().sqrt().max(c.norm()).max(1.0 / span);
    let mut a = DMatrix::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, false) if j - n == i => r,
        (true, _) => 0.0,
        (false, true) => k[(i - n, j)] / r,
        (false, false) => c[(i - n, j - n)],
    });
    let mut log = 0.0;
    for power in 1..=4 {
        let size = a.norm();
        if size == 0.0 {
            return 0.0;
        }
        log += size.ln() / f64::from(1 << (power - 1));
        a /= size;
        a = &a * &a;
    }
    (log + a.norm().max(1e-300).ln() / 16.0).exp()
}

impl Model {
    /// What errors of the speeds of some stops, one each, may add up to in the impulse of one of them that are struck together: where
    /// the stops are dependent, what it does alone.
    pub fn impulse_of_speeds(&self, mut together: Vec<usize>, stop: usize) -> f64 {
        together.sort_unstable();
        together.dedup();
        let among = self.delassus.part(&together);
        let unit = |j: usize| -> Vec<Dd> {
            let one = |i: usize| Dd::from(f64::from(u8::from(i == j)));
            (0..together.len()).map(one).collect()
        };
        let own = together.iter().position(|&other| other == stop);
        let column = |j: usize| Some(among.solve(&unit(j))?[own?].abs().to_f64());
        let inverse: Option<Vec<f64>> = (0..together.len()).map(column).collect();
        let alone = 1.0 / self.delassus.rows[stop][stop].to_f64();
        inverse.map_or(alone, |row| row.iter().sum())
    }

    /// Whether impulses on some stops that change none of their speeds can change the motion: which of them carries a load is
    /// then nobody's, and matters.
    pub fn reactions_differ(&self, stops: &[usize]) -> bool {
        // Of a part of them as of all.
        (0..1u32 << stops.len()).any(|bits| {
            let part = stops.iter().enumerate();
            let part = part.filter(|(k, _)| bits >> k & 1 == 1).map(|(_, &i)| i);
            self.all_differ(&part.collect::<Vec<_>>())
        })
    }

    fn all_differ(&self, stops: &[usize]) -> bool {
        if stops.len() < 2 {
            return false;
        }
        let unit = |vector: &[Dd]| {
            let vector = DVector::from_iterator(self.n, vector.iter().map(|x| x.to_f64()));
            let size = vector.norm();
            vector / size
        };
        let columns = |of: &dyn Fn(usize) -> DVector<f64>| {
            DMatrix::from_columns(&stops.iter().map(|&i| of(i)).collect::<Vec<_>>())
        };
        let normals = columns(&|i| unit(&self.stops[i].normal));
        let reactions = columns(&|i| unit(&self.stops[i].reaction));
        normals.tr_mul(&reactions).rank(1e-9) < reactions.rank(1e-9)
    }
}

/// The motion while an independent set of stops is held.
pub struct Motion {
    pub held: Vec<usize>,
    n: usize,
    frequencies: Vec<Dd>,
    /// Accelerations `rows . x`.
    acceleration: Matrix,
    transition: Matrix,
    /// `gaps[stop][k] . x`: coefficients of the gap in powers of time over the step, less the clearance in the first.
    gaps: Vec<Vec<Vec<Dd>>>,
    coarse: Vec<Vec<Vec<f64>>>,
    /// The same of the contact force of each stop held.
    forces: Vec<Vec<Vec<Dd>>>,
}

impl Motion {
    /// `None` where the stops are not independent.
    pub fn new(model: &Model, held: &[usize]) -> Option<Self> {
        let (n, m) = (model.n, model.size());
        let mut acceleration = model.free.clone();
        let mut forces = vec![vec![Dd::ZERO; m]; held.len()];
        let inner = model.delassus.part(held);
        for column in 0..m {
            let free: Vec<Dd> = model.free.rows.iter().map(|r| r[column]).collect();
            let right: Vec<Dd> = held
                .iter()
                .map(|&i| dot(&model.stops[i].normal, &free))
                .collect();
            let force = inner.solve(&right)?;
            for (k, &i) in held.iter().enumerate() {
                forces[k][column] = force[k];
                for (row, &b) in acceleration.rows.iter_mut().zip(&model.stops[i].reaction) {
                    row[column] -= b * force[k];
                }
            }
        }
        let mut motion = Self {
            held: held.to_vec(),
            n,
            frequencies: model.frequencies.clone(),
            acceleration,
            transition: Matrix::zeros(m, m),
            gaps: Vec::new(),
            coarse: Vec::new(),
            forces: Vec::new(),
        };
        for i in 0..m {
            let mut unit = vec![Dd::ZERO; m];
            unit[i] = Dd::ONE;
            for term in motion.series(unit, model.step) {
                for (sum, x) in motion.transition.rows[i].iter_mut().zip(&term) {
                    *sum += *x;
                }
            }
        }
        for stop in &model.stops {
            let mut row = vec![Dd::ZERO; m];
            for (x, &normal) in row.iter_mut().zip(&stop.normal) {
                *x = -normal;
            }
            row[2 * n] = stop.clearance;
            motion.gaps.push(motion.series(row, model.step));
        }
        let single = |rows: &Vec<Vec<Dd>>| {
            rows.iter()
                .map(|r| r.iter().map(|x| x.to_f64()).collect())
                .collect()
        };
        motion.coarse = motion.gaps.iter().map(single).collect();
        motion.forces = forces
            .into_iter()
            .map(|row| motion.series(row, model.step))
            .collect();
        Some(motion)
    }

    /// `row A`
    fn derivative(&self, row: &[Dd]) -> Vec<Dd> {
        let n = self.n;
        let mut result = vec![Dd::ZERO; row.len()];
        for (i, &r) in row[n..2 * n].iter().enumerate() {
            if r != Dd::ZERO {
                for (sum, &a) in result.iter_mut().zip(&self.acceleration.rows[i]) {
                    *sum += r * a;
                }
            }
        }
        for i in 0..n {
            result[n + i] += row[i];
        }
        for (k, &w) in self.frequencies.iter().enumerate() {
            let (cos, sin) = (2 * n + 1 + 2 * k, 2 * n + 2 + 2 * k);
            result[cos] += row[sin] * w;
            result[sin] -= row[cos] * w;
        }
        result
    }

    /// `row A^k step^k / k!`
    fn series(&self, row: Vec<Dd>, step: f64) -> Vec<Vec<Dd>> {
        let mut terms = vec![row];
        for k in 1..=ORDER {
            let factor = Dd::from(step) / Dd::from(k as f64);
            let next = self.derivative(&terms[k - 1]);
            terms.push(next.into_iter().map(|x| x * factor).collect());
        }
        terms
    }

    /// The state one node on.
    pub fn step(&self, x: &[Dd]) -> Vec<Dd> {
        self.transition.times(x)
    }

    /// The state a time later, at most one node.
    pub fn advance(&self, x: &[Dd], time: Dd) -> Vec<Dd> {
        let n = self.n;
        let mut y = x.to_vec();
        for k in (1..=ORDER).rev() {
            let factor = time / Dd::from(k as f64);
            let a = self.acceleration.times(&y);
            let mut next = x.to_vec();
            for i in 0..n {
                next[i] += factor * y[n + i];
                next[n + i] += factor * a[i];
            }
            let rates = turning(&self.frequencies, &y[2 * n..]);
            for (x, rate) in next[2 * n..].iter_mut().zip(rates) {
                *x += factor * rate;
            }
            y = next;
        }
        y
    }

    pub fn acceleration(&self, x: &[Dd]) -> Vec<Dd> {
        self.acceleration.times(x)
    }

    /// Whether a gap is so large at a node that it stays open up to the next.
    pub fn stays_open(&self, stop: usize, x: &[f64]) -> bool {
        let value = |row: &Vec<f64>| row.iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
        let rows = &self.coarse[stop];
        let gap = value(&rows[0]);
        let rest: f64 = rows[1..].iter().map(|row| value(row).abs()).sum();
        gap > 1.001 * rest && gap > 0.0
    }

    pub fn gap_series(&self, stop: usize, x: &[Dd]) -> Vec<Dd> {
        self.gaps[stop].iter().map(|row| dot(row, x)).collect()
    }

    /// Of the `k`-th stop held.
    pub fn force_series(&self, k: usize, x: &[Dd]) -> Vec<Dd> {
        self.forces[k].iter().map(|row| dot(row, x)).collect()
    }
}
