//! Double-double arithmetic: an unevaluated sum of two doubles, some 32 digits. Products by Dekker's splitting, since a fused
//! multiply-add is a function call on processors of unknown age. T. J. Dekker, Numer. Math. 18 (1971) 224.

use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Dd {
    hi: f64,
    lo: f64,
}

fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let t = s - a;
    (s, (a - (s - t)) + (b - t))
}

fn quick_two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    (s, b - (s - a))
}

fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a; // 2^27 + 1
    let hi = c - (c - a);
    (hi, a - hi)
}

fn two_product(a: f64, b: f64) -> (f64, f64) {
    let p = a * b;
    if cfg!(target_feature = "fma") {
        return (p, a.mul_add(b, -p));
    }
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    (p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

impl Dd {
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };
    pub const ONE: Self = Self { hi: 1.0, lo: 0.0 };
    const TAU: Self = Self {
        hi: std::f64::consts::TAU,
        lo: 2.449_293_598_294_706_4e-16,
    };

    pub fn to_f64(self) -> f64 {
        self.hi
    }

    pub fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    /// Cosine and sine, the angle reduced by whole turns first.
    pub fn cos_sin(self) -> (Self, Self) {
        let turns = (self / Self::TAU).hi.round();
        let x = self - Self::TAU * turns;
        let (mut term, mut sums) = (Self::ONE, [Self::ZERO; 2]);
        for k in 0..48 {
            let signed = if k % 4 < 2 { term } else { -term };
            sums[k % 2] += signed;
            term = term * x / Self::from(k as f64 + 1.0);
        }
        (sums[0], sums[1])
    }
}

impl From<f64> for Dd {
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

impl Neg for Dd {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            hi: -self.hi,
            lo: -self.lo,
        }
    }
}

impl Add for Dd {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let (s, e) = two_sum(self.hi, b.hi);
        let (t, f) = two_sum(self.lo, b.lo);
        let (s, e) = quick_two_sum(s, e + t);
        let (hi, lo) = quick_two_sum(s, e + f);
        Self { hi, lo }
    }
}

impl Sub for Dd {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Mul for Dd {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let (p, e) = two_product(self.hi, b.hi);
        let (hi, lo) = quick_two_sum(p, e + (self.hi * b.lo + self.lo * b.hi));
        Self { hi, lo }
    }
}

impl Mul<f64> for Dd {
    type Output = Self;
    fn mul(self, b: f64) -> Self {
        self * Self::from(b)
    }
}

impl Div for Dd {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let first = self.hi / b.hi;
        let rest = self - b * first;
        let second = rest.hi / b.hi;
        let rest = rest - b * second;
        let (hi, lo) = quick_two_sum(first, second);
        Self { hi, lo } + Self::from(rest.hi / b.hi)
    }
}

impl AddAssign for Dd {
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}

impl SubAssign for Dd {
    fn sub_assign(&mut self, b: Self) {
        *self = *self - b;
    }
}

impl PartialOrd for Dd {
    fn partial_cmp(&self, b: &Self) -> Option<Ordering> {
        match self.hi.partial_cmp(&b.hi) {
            Some(Ordering::Equal) => self.lo.partial_cmp(&b.lo),
            other => other,
        }
    }
}

pub fn dot(a: &[Dd], b: &[Dd]) -> Dd {
    let mut sum = Dd::ZERO;
    for (&a, &b) in a.iter().zip(b) {
        sum += a * b;
    }
    sum
}

/// A dense matrix of rows.
#[derive(Debug, Clone)]
pub struct Matrix {
    pub rows: Vec<Vec<Dd>>,
}

impl Matrix {
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self {
            rows: vec![vec![Dd::ZERO; columns]; rows],
        }
    }

    /// Some rows of some columns, the same of both.
    pub fn part(&self, places: &[usize]) -> Self {
        let row = |&i: &usize| places.iter().map(|&j| self.rows[i][j]).collect();
        Self {
            rows: places.iter().map(row).collect(),
        }
    }

    pub fn times(&self, x: &[Dd]) -> Vec<Dd> {
        self.rows.iter().map(|row| dot(row, x)).collect()
    }

    /// The number of independent rows, by elimination with complete pivoting to `1e-20` of the largest entry.
    pub fn rank(&self) -> usize {
        let mut rows = self.rows.clone();
        let size = |x: &Dd| x.abs().to_f64();
        let largest = rows.iter().flatten().map(size).fold(0.0, f64::max);
        let mut rank = 0;
        loop {
            let places = (rank..rows.len()).flat_map(|i| (0..rows[i].len()).map(move |j| (i, j)));
            let pivot =
                places.max_by(|&(i, j), &(k, l)| size(&rows[i][j]).total_cmp(&size(&rows[k][l])));
            let Some((i, j)) = pivot.filter(|&(i, j)| size(&rows[i][j]) > 1e-20 * largest) else {
                return rank;
            };
            rows.swap(rank, i);
            let above = rows[rank].clone();
            rank += 1;
            for row in &mut rows[rank..] {
                let factor = row[j] / above[j];
                for (x, pivot) in row.iter_mut().zip(&above) {
                    *x -= factor * *pivot;
                }
                row[j] = Dd::ZERO;
            }
        }
    }

    /// The solution of `self y = b` by elimination with complete pivoting, `None` where a pivot is below `1e-20` of the largest
    /// entry.
    pub fn solve(&self, b: &[Dd]) -> Option<Vec<Dd>> {
        let n = b.len();
        let mut a = self.rows.clone();
        let mut b = b.to_vec();
        let mut order: Vec<usize> = (0..n).collect();
        let largest = a
            .iter()
            .flatten()
            .map(|x| x.abs().to_f64())
            .fold(0.0, f64::max);
        for k in 0..n {
            let mut pivot = (k, k);
            for i in k..n {
                for j in k..n {
                    if a[i][j].abs() > a[pivot.0][pivot.1].abs() {
                        pivot = (i, j);
                    }
                }
            }
            if a[pivot.0][pivot.1].abs().to_f64() <= 1e-20 * largest {
                return None;
            }
            a.swap(k, pivot.0);
            b.swap(k, pivot.0);
            for row in &mut a {
                row.swap(k, pivot.1);
            }
            order.swap(k, pivot.1);
            for i in k + 1..n {
                let factor = a[i][k] / a[k][k];
                let (above, below) = a.split_at_mut(i);
                for (x, pivot) in below[0][k..].iter_mut().zip(&above[k][k..]) {
                    *x -= factor * *pivot;
                }
                let change = factor * b[k];
                b[i] -= change;
            }
        }
        let mut y = vec![Dd::ZERO; n];
        for k in (0..n).rev() {
            let mut sum = b[k];
            for j in k + 1..n {
                sum -= a[k][j] * y[order[j]];
            }
            y[order[k]] = sum / a[k][k];
        }
        Some(y)
    }
}

#[test]
fn rows_that_depend_on_others_add_no_rank() {
    let matrix = |rows: &[[f64; 3]]| Matrix {
        rows: rows.iter().map(|r| r.map(Dd::from).to_vec()).collect(),
    };
    assert_eq!(matrix(&[[0.0; 3]; 2]).rank(), 0);
    assert_eq!(matrix(&[[1.0, 2.0, 3.0], [0.1, 0.2, 0.3]]).rank(), 2); // 0.3 is not three times 0.1 in doubles
    assert_eq!(
        matrix(&[[1.0, 2.0, 3.0], [0.5, 1.0, 1.5], [0.0, 1.0, 0.0]]).rank(),
        2
    );
}

#[test]
fn arithmetic_has_thirty_digits() {
    let third = Dd::ONE / Dd::from(3.0);
    assert!((third * 3.0 - Dd::ONE).abs().to_f64() < 1e-31);
    // sin(1e9 + 1) and cos, by addition formulas from angles of one.
    let ((c, s), (c1, s1)) = (Dd::from(1e9).cos_sin(), Dd::from(1.0).cos_sin());
    let (sum_c, sum_s) = Dd::from(1e9 + 1.0).cos_sin();
    assert!((sum_c - (c * c1 - s * s1)).abs().to_f64() < 1e-22);
    assert!((sum_s - (s * c1 + c * s1)).abs().to_f64() < 1e-22);
    assert!((s.to_f64() - 1e9f64.sin()).abs() < 1e-15);
}
