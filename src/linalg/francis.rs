//! Eigenvalues of a real square matrix by Francis' double-shift QR iteration on its Hessenberg form, with a cap on the
//! sweeps. Real arithmetic in place, for matrices so many or so small that a Schur form with its vectors is too dear.
//! After the procedures `orthes` and `hqr` of Wilkinson and Reinsch, Handbook for Automatic Computation II (1971).

use nalgebra::allocator::Allocator;
use nalgebra::{Complex, DefaultAllocator, Dim, OMatrix};

/// Sweeps allowed for one eigenvalue, the exceptional shifts of every tenth included. [work]
const MOST_ROOT_SWEEPS: usize = 60;

/// Turns a matrix into one with the same eigenvalues and zeros below the subdiagonal, by Householder reflections.
fn to_hessenberg<D: Dim>(a: &mut OMatrix<f64, D, D>)
where
    DefaultAllocator: Allocator<D, D>,
{
    let n = a.nrows();
    for k in 0..n.saturating_sub(2) {
        let scale = (k + 2..n).map(|i| a[(i, k)].abs()).fold(0.0, f64::max);
        if scale == 0.0 {
            continue;
        }
        // Reflection I - v v^T/h, v in rows k+1..n of column k, which it leaves at (alpha, 0, ..., 0).
        let norm = (k + 1..n)
            .map(|i| a[(i, k)] * a[(i, k)])
            .sum::<f64>()
            .sqrt();
        let alpha = if a[(k + 1, k)] > 0.0 { -norm } else { norm };
        let h = norm * norm - a[(k + 1, k)] * alpha;
        if h <= 0.0 {
            continue;
        }
        a[(k + 1, k)] -= alpha;
        for j in k + 1..n {
            let f = (k + 1..n).map(|i| a[(i, k)] * a[(i, j)]).sum::<f64>() / h;
            for i in k + 1..n {
                a[(i, j)] -= f * a[(i, k)];
            }
        }
        for i in 0..n {
            let f = (k + 1..n).map(|j| a[(i, j)] * a[(j, k)]).sum::<f64>() / h;
            for j in k + 1..n {
                a[(i, j)] -= f * a[(j, k)];
            }
        }
        a[(k + 1, k)] = alpha;
        for i in k + 2..n {
            a[(i, k)] = 0.0;
        }
    }
}

/// The two eigenvalues of `[[y, b], [c, x]]`, `w = b c`, all shifted by `shift`.
fn of_pair(x: f64, y: f64, w: f64, shift: f64) -> [Complex<f64>; 2] {
    let p = 0.5 * (y - x);
    let q = p * p + w;
    let z = q.abs().sqrt();
    let x = x + shift;
    if q < 0.0 {
        return [Complex::new(x + p, z), Complex::new(x + p, -z)];
    }
    let z = if p < 0.0 { p - z } else { p + z };
    let other = if z == 0.0 { x } else { x - w / z };
    [(x + z).into(), other.into()]
}

/// The eigenvalues, in no order; `None` if the iteration reaches its cap or the matrix is not finite. Uses up the matrix.
pub(crate) fn eigenvalues<D: Dim>(mut a: OMatrix<f64, D, D>) -> Option<Vec<Complex<f64>>>
where
    DefaultAllocator: Allocator<D, D>,
{
    to_hessenberg(&mut a);
    let n = a.nrows();
    let size: f64 = a.iter().map(|x| x.abs()).sum();
    if !size.is_finite() {
        return None;
    }
    let mut found = Vec::with_capacity(n);
    let mut shift = 0.0;
    let mut end = n; // rows end.. are done
    let mut sweeps = 0;
    while end > 0 {
        let last = end - 1;
        let start = block_start(&mut a, last, size);
        let x = a[(last, last)];
        if start == last {
            found.push((x + shift).into());
            (end, sweeps) = (end - 1, 0);
            continue;
        }
        let (y, w) = (
            a[(last - 1, last - 1)],
            a[(last, last - 1)] * a[(last - 1, last)],
        );
        if start + 1 == last {
            found.extend(of_pair(x, y, w, shift));
            (end, sweeps) = (end - 2, 0);
            continue;
        }
        if sweeps == MOST_ROOT_SWEEPS {
            return None;
        }
        sweeps += 1;
        let shifts = if sweeps.is_multiple_of(10) {
            shift += x;
            for i in 0..end {
                a[(i, i)] -= x;
            }
            let s = a[(last, last - 1)].abs() + a[(last - 1, last - 2)].abs();
            [0.75 * s, 0.75 * s, -0.4375 * s * s]
        } else {
            [x, y, w]
        };
        sweep(&mut a, start, last, shifts);
    }
    found
        .iter()
        .all(|z| z.re.is_finite() && z.im.is_finite())
        .then_some(found)
}

/// The first row of the block without a negligible subdiagonal entry that ends in row `last`.
fn block_start<D: Dim>(a: &mut OMatrix<f64, D, D>, last: usize, size: f64) -> usize
where
    DefaultAllocator: Allocator<D, D>,
{
    let mut l = last;
    while l > 0 {
        let near = a[(l - 1, l - 1)].abs() + a[(l, l)].abs();
        let near = if near == 0.0 { size } else { near };
        if a[(l, l - 1)].abs() <= f64::EPSILON * near {
            a[(l, l - 1)] = 0.0;
            break;
        }
        l -= 1;
    }
    l
}

/// One double QR sweep on the rows `start..=last` with the shifts that are the eigenvalues of the trailing pair.
fn sweep<D: Dim>(a: &mut OMatrix<f64, D, D>, start: usize, last: usize, [x, y, w]: [f64; 3])
where
    DefaultAllocator: Allocator<D, D>,
{
    // The bulge may start further down, where two consecutive subdiagonal entries are small.
    let mut m = last - 2;
    let mut first;
    loop {
        let z = a[(m, m)];
        let (r, s) = (x - z, y - z);
        first = [
            (r * s - w) / a[(m + 1, m)] + a[(m, m + 1)],
            a[(m + 1, m + 1)] - z - r - s,
            a[(m + 2, m + 1)],
        ];
        let sum = first[0].abs() + first[1].abs() + first[2].abs();
        first = first.map(|f| f / sum);
        if m == start {
            break;
        }
        let above = a[(m, m - 1)].abs() * (first[1].abs() + first[2].abs());
        let along = first[0].abs() * (a[(m - 1, m - 1)].abs() + z.abs() + a[(m + 1, m + 1)].abs());
        if above <= f64::EPSILON * along {
            break;
        }
        m -= 1;
    }
    for i in m + 2..=last {
        a[(i, i - 2)] = 0.0;
        if i > m + 2 {
            a[(i, i - 3)] = 0.0;
        }
    }
    for k in m..last {
        let is_wide = k + 1 < last;
        let mut scale = 1.0;
        let [mut p, mut q, mut r] = first;
        if k > m {
            [p, q, r] = [
                a[(k, k - 1)],
                a[(k + 1, k - 1)],
                if is_wide { a[(k + 2, k - 1)] } else { 0.0 },
            ];
            scale = p.abs() + q.abs() + r.abs();
            if scale == 0.0 {
                continue;
            }
            [p, q, r] = [p / scale, q / scale, r / scale];
        }
        let norm = (p * p + q * q + r * r).sqrt();
        let s = if p < 0.0 { -norm } else { norm };
        if s == 0.0 {
            continue;
        }
        if k > m {
            a[(k, k - 1)] = -s * scale;
        } else if start < m {
            a[(k, k - 1)] = -a[(k, k - 1)];
        }
        p += s;
        let (x, y, z) = (p / s, q / s, r / s);
        let (q, r) = (q / p, r / p);
        for j in k..=last {
            let mut f = a[(k, j)] + q * a[(k + 1, j)];
            if is_wide {
                f += r * a[(k + 2, j)];
                a[(k + 2, j)] -= f * z;
            }
            a[(k + 1, j)] -= f * y;
            a[(k, j)] -= f * x;
        }
        for i in start..=last.min(k + 3) {
            let mut f = x * a[(i, k)] + y * a[(i, k + 1)];
            if is_wide {
                f += z * a[(i, k + 2)];
                a[(i, k + 2)] -= f * r;
            }
            a[(i, k + 1)] -= f * q;
            a[(i, k)] -= f;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// Whether two lists of eigenvalues are the same but for their order.
    fn assert_same(mut found: Vec<Complex<f64>>, expected: &[Complex<f64>], tolerance: f64) {
        assert_eq!(found.len(), expected.len());
        for z in expected {
            let (i, nearest) = found
                .iter()
                .enumerate()
                .min_by(|a, b| (a.1 - z).norm().total_cmp(&(b.1 - z).norm()))
                .expect("as many as expected");
            assert!(
                (nearest - z).norm() <= tolerance,
                "{z} is missing; nearest is {nearest}"
            );
            found.swap_remove(i);
        }
    }

    #[test]
    fn a_matrix_made_from_its_eigenvalues_has_them() {
        for n in 1..=12 {
            // Blocks on the diagonal, turned by a reflection and a fixed dense similarity.
            let mut diagonal = DMatrix::<f64>::zeros(n, n);
            let mut expected = Vec::new();
            let mut i = 0;
            while i < n {
                let (re, im) = (0.7 - 0.3 * i as f64, 0.2 + 0.1 * i as f64);
                if i + 1 < n && i % 4 < 2 {
                    diagonal[(i, i)] = re;
                    diagonal[(i + 1, i + 1)] = re;
                    diagonal[(i, i + 1)] = im;
                    diagonal[(i + 1, i)] = -im;
                    expected.extend([Complex::new(re, im), Complex::new(re, -im)]);
                    i += 2;
                } else {
                    diagonal[(i, i)] = re;
                    expected.push(Complex::new(re, 0.0));
                    i += 1;
                }
            }
            let turn = DMatrix::from_fn(n, n, |i, j| {
                (1.0 + 1.7 * i as f64 + 0.9 * (j * j) as f64).cos()
            })
            .qr()
            .q();
            assert_same(
                eigenvalues(&turn * &diagonal * turn.transpose()).expect("converges"),
                &expected,
                1e-12,
            );
        }
    }

    #[test]
    fn cyclic_permutations_have_the_roots_of_unity() {
        for n in [1usize, 2, 3, 4, 6, 8, 10, 12, 16, 24] {
            let a = DMatrix::from_fn(n, n, |i, j| if (j + 1) % n == i { 1.0 } else { 0.0 });
            let roots: Vec<_> = (0..n)
                .map(|k| Complex::from_polar(1.0, std::f64::consts::TAU * k as f64 / n as f64))
                .collect();
            assert_same(eigenvalues(a).expect("exceptional shifts"), &roots, 1e-12);
        }
    }

    #[test]
    fn zeros_and_bad_numbers_end_too() {
        assert_same(
            eigenvalues(DMatrix::zeros(4, 4)).expect("nothing to do"),
            &[Complex::new(0.0, 0.0); 4],
            0.0,
        );
        assert!(eigenvalues(DMatrix::from_element(4, 4, f64::NAN)).is_none());
        // One cell of a Jordan form: eigenvalues are good to the fourth root of rounding.
        let jordan = DMatrix::from_fn(4, 4, |i, j| if j == i + 1 { 1.0 } else { 0.0 });
        assert_same(
            eigenvalues(jordan.transpose()).expect("converges"),
            &[Complex::new(0.0, 0.0); 4],
            1e-3,
        );
    }
}
