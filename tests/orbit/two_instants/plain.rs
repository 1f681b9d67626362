//! Scenes in plain matrices, their flight times by a scan written independently of the library: the 2N cyclic solve of
//! theory 5 with matrix exponentials, `|u| = 1` by sign changes and by minima of the modulus.

use crate::random::Random;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;
use vibroimpact::{Harmonic, LinearSystem, OrbitOptions, Pattern, Scene, Stop};

/// One stop as the scan uses it: gap `clearance - normal.q`.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    pub normal: DVector<f64>,
    pub clearance: f64,
    pub restitution: f64,
}

/// A scene in plain matrices, and the flight times at which the periodic conditions hold.
#[derive(Debug, Clone)]
pub struct Plain {
    pub mass: DMatrix<f64>,
    pub damping: DMatrix<f64>,
    pub stiffness: DMatrix<f64>,
    pub load: DVector<f64>,
    pub force: DVector<f64>,
    pub w: f64,
    pub n_periods: usize,
    /// The stops of the two instants.
    pub faces: [Face; 2],
}

/// The contact conditions at one flight time: `L u = d`.
pub struct Contact {
    pub l: DMatrix<f64>,
    pub d: DVector<f64>,
}

impl Contact {
    /// `|u|^2 - 1` times `det^2`, relative: between -1 and 1.
    pub fn residual(&self) -> f64 {
        let (l, d) = (&self.l, &self.d);
        let det = l[(0, 0)] * l[(1, 1)] - l[(0, 1)] * l[(1, 0)];
        let a = [
            l[(1, 1)] * d[0] - l[(0, 1)] * d[1],
            l[(0, 0)] * d[1] - l[(1, 0)] * d[0],
        ];
        let size = a[0] * a[0] + a[1] * a[1];
        (size - det * det) / (size + det * det)
    }
}

impl Plain {
    pub fn n(&self) -> usize {
        self.load.len()
    }

    pub fn period(&self) -> f64 {
        TAU * self.n_periods as f64 / self.w
    }

    pub fn state_matrix(&self) -> DMatrix<f64> {
        let n = self.n();
        let inverse = self.mass.clone().try_inverse().expect("positive definite");
        let mut a = DMatrix::zeros(2 * n, 2 * n);
        a.view_mut((0, n), (n, n))
            .copy_from(&DMatrix::identity(n, n));
        a.view_mut((n, 0), (n, n))
            .copy_from(&(-&inverse * &self.stiffness));
        a.view_mut((n, n), (n, n))
            .copy_from(&(-&inverse * &self.damping));
        a
    }

    /// The state matrix enlarged by the load and the forcing: of the state (q, v, 1, cos, sin).
    pub fn enlarged(&self) -> DMatrix<f64> {
        let n = self.n();
        let inverse = self.mass.clone().try_inverse().expect("positive definite");
        let mut big = DMatrix::zeros(2 * n + 3, 2 * n + 3);
        big.view_mut((0, 0), (2 * n, 2 * n))
            .copy_from(&self.state_matrix());
        big.view_mut((n, 2 * n), (n, 1))
            .copy_from(&(&inverse * &self.load));
        big.view_mut((n, 2 * n + 1), (n, 1))
            .copy_from(&(&inverse * &self.force));
        big[(2 * n + 1, 2 * n + 2)] = -self.w;
        big[(2 * n + 2, 2 * n + 1)] = self.w;
        big
    }

    /// The enlarged state a period after x, over an impact of the second stop near `dt` and one of the first near T.
    pub fn return_map(&self, x: &DVector<f64>, dt: f64) -> DVector<f64> {
        let (n, big) = (self.n(), self.enlarged());
        let (mut x, mut time) = (x.clone(), 0.0);
        for (face, guess) in [(&self.faces[1], dt), (&self.faces[0], self.period())] {
            x = (&big * (guess - time)).exp() * x;
            time = guess;
            for _ in 0..6 {
                let speed = face.normal.dot(&x.rows(n, n));
                let step = (face.clearance - face.normal.dot(&x.rows(0, n))) / speed;
                x = (&big * step).exp() * x;
                time += step;
            }
            let after = self.recovery(face) * x.rows(0, 2 * n);
            x.rows_mut(0, 2 * n).copy_from(&after);
        }
        (&big * (self.period() - time)).exp() * x
    }

    /// The steady response at t to the phases 0 (cosine) and pi/2 in the columns: `s(t) u`, u = (cos phase, sin phase).
    pub fn steady(&self, t: f64) -> DMatrix<f64> {
        let (n, w) = (self.n(), self.w);
        // (K - w^2 M + i w C) X = F as a real system for (Re X, Im X).
        let dynamic = &self.stiffness - &self.mass * (w * w);
        let cross = &self.damping * w;
        let mut big = DMatrix::zeros(2 * n, 2 * n);
        big.view_mut((0, 0), (n, n)).copy_from(&dynamic);
        big.view_mut((n, n), (n, n)).copy_from(&dynamic);
        big.view_mut((0, n), (n, n)).copy_from(&-&cross);
        big.view_mut((n, 0), (n, n)).copy_from(&cross);
        let mut rhs = DVector::zeros(2 * n);
        rhs.rows_mut(0, n).copy_from(&self.force);
        let x = big.lu().solve(&rhs).expect("damped");
        let (re, im) = (x.rows(0, n), x.rows(n, n));
        let (s, c) = (w * t).sin_cos();
        // q = Re(X e^{i(wt + phase)}), v = Re(i w X e^{i(wt + phase)})
        let mut out = DMatrix::zeros(2 * n, 2);
        for i in 0..n {
            let (a, b) = (re[i] * c - im[i] * s, re[i] * s + im[i] * c); // X e^{iwt} = a + i b
            out[(i, 0)] = a;
            out[(i, 1)] = -b;
            out[(n + i, 0)] = -w * b;
            out[(n + i, 1)] = -w * a;
        }
        out
    }

    pub fn recovery(&self, face: &Face) -> DMatrix<f64> {
        let n = self.n();
        let b = self.mass.clone().try_inverse().expect("positive definite") * &face.normal;
        let p = DMatrix::identity(n, n)
            - &b * face.normal.transpose() * ((1.0 + face.restitution) / face.normal.dot(&b));
        let mut r = DMatrix::identity(2 * n, 2 * n);
        r.view_mut((n, n), (n, n)).copy_from(&p);
        r
    }

    /// The cyclic solve for a flight time whose propagators are given.
    pub fn contact(&self, dt: f64, there: &DMatrix<f64>, back: &DMatrix<f64>) -> Contact {
        let n = self.n();
        let [r0, r1] = [0, 1].map(|i| self.recovery(&self.faces[i]));
        let identity = DMatrix::identity(2 * n, 2 * n);
        let (s0, s1) = (self.steady(0.0), self.steady(dt));
        let home = &r0 * back;
        let matrix = &identity - &home * &r1 * there;
        let rhs = &home * (&r1 - &identity) * &s1 + (&r0 - &identity) * &s0;
        let z = matrix.lu().solve(&rhs).expect("regular");
        let q0 = (&z + &s0).rows(0, n).into_owned();
        let q1 = (there * &z + &s1).rows(0, n).into_owned();
        let rest = self
            .stiffness
            .clone()
            .lu()
            .solve(&self.load)
            .expect("stiff");
        let mut l = DMatrix::zeros(2, 2);
        l.set_row(0, &(self.faces[0].normal.transpose() * q0));
        l.set_row(1, &(self.faces[1].normal.transpose() * q1));
        let d = DVector::from_fn(2, |i, _| {
            self.faces[i].clearance - self.faces[i].normal.dot(&rest)
        });
        Contact { l, d }
    }

    pub fn at(&self, dt: f64) -> Contact {
        let a = self.state_matrix();
        self.contact(dt, &(&a * dt).exp(), &(&a * (self.period() - dt)).exp())
    }

    /// The flight times found by a scan of `count` equal steps: sign changes, and minima of the modulus that reach zero.
    pub fn scan(&self, count: usize) -> Vec<f64> {
        let a = self.state_matrix();
        let t = self.period();
        let step = t / count as f64;
        let one = (&a * step).exp();
        let mut powers = vec![DMatrix::identity(2 * self.n(), 2 * self.n())];
        for k in 1..count {
            // Made afresh now and then, so that rounding does not add up.
            let next = if k % 500 == 0 {
                (&a * (step * k as f64)).exp()
            } else {
                &powers[k - 1] * &one
            };
            powers.push(next);
        }
        let value: Vec<f64> = (1..count)
            .map(|k| {
                self.contact(step * k as f64, &powers[k], &powers[count - k])
                    .residual()
            })
            .collect();
        let mut found = Vec::new();
        for k in 0..value.len() - 1 {
            let (mut x0, mut x1) = (step * (k + 1) as f64, step * (k + 2) as f64);
            if value[k] * value[k + 1] < 0.0 {
                for _ in 0..50 {
                    let x = 0.5 * (x0 + x1);
                    if self.at(x).residual() * value[k] > 0.0 {
                        x0 = x;
                    } else {
                        x1 = x;
                    }
                }
                found.push(0.5 * (x0 + x1));
            } else if k > 0
                && value[k - 1] * value[k] > 0.0
                && value[k].abs() < value[k - 1].abs()
                && value[k].abs() <= value[k + 1].abs()
                && value[k].abs() < 1e-3
            {
                // Golden section for the least modulus.
                let (mut low, mut high) = (step * k as f64, step * (k + 2) as f64);
                let modulus = |x: f64| self.at(x).residual() * value[k].signum();
                for _ in 0..60 {
                    let (a, b) = (low + 0.382 * (high - low), low + 0.618 * (high - low));
                    let (fa, fb) = (modulus(a), modulus(b));
                    if fa < 0.0 || fb < 0.0 {
                        // A pair of roots between two samples.
                        let middle = if fa < 0.0 { a } else { b };
                        for (mut x0, mut x1) in [(low, middle), (high, middle)] {
                            for _ in 0..50 {
                                let x = 0.5 * (x0 + x1);
                                if modulus(x) > 0.0 { x0 = x } else { x1 = x }
                            }
                            found.push(x1);
                        }
                        break;
                    }
                    if fa < fb { high = b } else { low = a }
                }
            }
        }
        found
    }

    pub fn scene(&self) -> (Scene, Pattern) {
        let system = LinearSystem::new(
            self.mass.clone(),
            self.damping.clone(),
            self.stiffness.clone(),
        )
        .and_then(|s| s.with_load(self.load.clone()))
        .expect("valid");
        let stop =
            |f: &Face| Stop::new(f.normal.clone(), f.clearance, f.restitution).expect("valid");
        let is_one = self.faces[0] == self.faces[1];
        let faces = if is_one {
            &self.faces[..1]
        } else {
            &self.faces[..]
        };
        let forcing = Harmonic::new(self.force.map(Into::into), self.w, 0.0).expect("valid");
        let scene = Scene::new(system, forcing, faces.iter().map(stop)).expect("valid");
        (
            scene,
            Pattern::new(vec![vec![0], vec![faces.len() - 1]]).expect("valid"),
        )
    }

    pub fn options(&self) -> OrbitOptions {
        OrbitOptions {
            n_periods: self.n_periods,
            ..Default::default()
        }
    }
}

#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Sides {
    One,
    Two,
    Symmetric,
}

pub fn random_plain(random: &mut Random, sides: Sides) -> Plain {
    let n = 1 + random.below(3);
    let identity = DMatrix::identity(n, n);
    let (a, b) = (random.matrix(n), random.matrix(n));
    let mass = &identity + &a * a.transpose() * 0.3;
    let stiffness =
        &identity * random.between(0.2, 2.0) + &b * b.transpose() * random.between(0.5, 4.0);
    let damping = if random.unit() < 0.5 {
        &mass * random.between(0.0, 0.05) + &stiffness * random.between(0.005, 0.1)
    } else {
        let c = random.matrix(n);
        &c * c.transpose() * 0.2 + &identity * 0.02
    };
    let normal = if random.unit() < 0.5 {
        DVector::from_fn(n, |i, _| f64::from(u8::from(i == 0)))
    } else {
        DVector::from_fn(n, |_, _| random.between(-1.0, 1.0))
    };
    let w = random.between(0.5, 3.0);
    let restitution = [0.0, 0.3, 0.7, 0.9, 1.0][random.below(5)];
    let clearance = random.between(-0.1, 0.5);
    let first = Face {
        normal,
        clearance,
        restitution,
    };
    let second = match sides {
        Sides::One => first.clone(),
        Sides::Symmetric => Face {
            normal: -&first.normal,
            ..first.clone()
        },
        Sides::Two => Face {
            normal: -&first.normal,
            clearance: random.between(0.11, 0.6),
            ..first.clone()
        },
    };
    let load = if sides == Sides::Symmetric {
        DVector::zeros(n)
    } else {
        DVector::from_fn(n, |_, _| random.between(-0.1, 0.1))
    };
    Plain {
        force: DVector::from_fn(n, |_, _| random.between(-1.0, 1.0)),
        n_periods: 1 + random.below(3),
        mass,
        damping,
        stiffness,
        load,
        w,
        faces: [first, second],
    }
}
