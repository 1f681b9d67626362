//! What happens at one instant, by trying every active set: impulses of stops that are hit together, and contact forces of
//! stops that stay in contact. J. J. Moreau, in Nonsmooth Mechanics and Applications (1988); exponential in the number of stops.

use crate::runs::double_double::{Dd, Matrix, dot};

/// Rounding of the double-double numbers that enter, relative to their size.
const ZERO: f64 = 1e-22;
/// Columns that give so many times their own to a target are dependent, but for the rounding of the doubles that they come from.
const DEPENDENT: f64 = 1e14;

fn size(values: &[Dd]) -> f64 {
    values.iter().map(|x| x.abs().to_f64()).fold(0.0, f64::max)
}

/// Every solution `x` of `0 <= x`, `w = G x - r >= 0`, `x.w = 0` with independent active columns, few active ones first.
pub fn complementary(g: &Matrix, r: &[Dd], scale: f64) -> Vec<Vec<Dd>> {
    let n = r.len();
    let mut sets: Vec<u32> = (0..1 << n).collect();
    sets.sort_by_key(|s| s.count_ones());
    let mut found = Vec::new();
    for set in sets {
        let active: Vec<usize> = (0..n).filter(|i| set >> i & 1 == 1).collect();
        let right: Vec<Dd> = active.iter().map(|&i| r[i]).collect();
        let Some(y) = g.part(&active).solve(&right) else {
            continue;
        };
        let most = DEPENDENT * size(&right);
        let is_lost = |(&i, y): (&usize, &Dd)| (g.rows[i][i] * *y).abs().to_f64() > most;
        if y.iter().any(|y| y.to_f64() < 0.0) || active.iter().zip(&y).any(is_lost) {
            continue;
        }
        let mut x = vec![Dd::ZERO; n];
        for (&i, &y) in active.iter().zip(&y) {
            x[i] = y;
        }
        let allowed = -ZERO * scale.max(size(r));
        if (0..n).all(|i| set >> i & 1 == 1 || (dot(&g.rows[i], &x) - r[i]).to_f64() >= allowed) {
            found.push(x);
        }
    }
    found
}

/// What impulses do at one instant.
pub struct Instant {
    /// Of each stop in contact, the sum over rounds.
    pub impulses: Vec<Dd>,
    /// Opening speeds afterwards.
    pub opening: Vec<Dd>,
    pub rounds: usize,
    /// Whether dependent stops share impulses, so that these are not unique.
    pub is_shared: bool,
    /// Why another answer is as good, if so.
    pub doubt: Option<&'static str>,
}

/// Impulses of the stops in contact, from their opening speeds, their Delassus matrix and their restitutions. `scale` is the
/// size of speeds whose rounding is no motion.
pub fn impulses(g: &Matrix, opening: &[Dd], restitution: &[f64], scale: f64) -> Instant {
    let n = opening.len();
    let mut instant = Instant {
        impulses: vec![Dd::ZERO; n],
        opening: opening.to_vec(),
        rounds: 0,
        is_shared: false,
        doubt: None,
    };
    let zero = ZERO * scale;
    loop {
        if instant.opening.iter().all(|s| s.to_f64() >= -zero) {
            break;
        }
        instant.rounds += 1;
        if instant.rounds > 101 {
            instant.doubt = Some("stops go on to strike each other");
            break;
        }
        let plastic = instant.rounds == 101;
        let enters: Vec<usize> = (0..n)
            .filter(|&i| instant.opening[i].to_f64() <= zero)
            .collect();
        let target: Vec<Dd> = enters
            .iter()
            .map(|&i| {
                let e = if plastic { 0.0 } else { restitution[i] };
                let closing = if instant.opening[i].to_f64() < -zero {
                    -instant.opening[i]
                } else {
                    Dd::ZERO
                };
                closing * (Dd::ONE + Dd::from(e))
            })
            .collect();
        let inner = g.part(&enters);
        let solutions = complementary(&inner, &target, scale);
        let Some(first) = solutions.first() else {
            instant.doubt = Some("no impulses solve the law");
            break;
        };
        let effect = inner.times(first);
        if solutions.iter().any(|x| {
            let other = inner.times(x);
            other
                .iter()
                .zip(&effect)
                .any(|(a, b)| (*a - *b).abs().to_f64() > 1e-18 * scale)
        }) {
            instant.doubt = Some("several sets of impulses solve the law");
        }
        instant.is_shared |= solutions.iter().any(|x| {
            let pairs = x.iter().zip(first);
            pairs
                .into_iter()
                .any(|(a, b)| (*a - *b).abs().to_f64() > 1e-18 * scale)
        });
        instant.is_shared |= (0..first.len()).any(|i| first[i] > Dd::ZERO && is_moot(&inner, i));
        let x = shared(first, &solutions);
        for (&i, &x) in enters.iter().zip(&x) {
            instant.impulses[i] += x;
            for (j, opening) in instant.opening.iter_mut().enumerate() {
                *opening += g.rows[j][i] * x;
            }
        }
        // What the law makes zero is zero.
        for (&i, &x) in enters.iter().zip(&x) {
            if x > Dd::ZERO && (plastic || restitution[i] == 0.0)
                || instant.opening[i].abs().to_f64() <= zero
            {
                instant.opening[i] = Dd::ZERO;
            }
        }
    }
    instant
}

/// Whether an impulse can be another with the same effect on all gaps: those of stops that press against each other besides.
fn is_moot(g: &Matrix, stop: usize) -> bool {
    let mut with_it = g.clone();
    let mut own = vec![Dd::ZERO; g.rows.len()];
    own[stop] = g.rows[stop][stop];
    with_it.rows.push(own);
    with_it.rank() > g.rank()
}

/// Where several independent sets of impulses have the same effect, their mean.
fn shared(first: &[Dd], solutions: &[Vec<Dd>]) -> Vec<Dd> {
    let share = Dd::ONE / Dd::from(solutions.len() as f64);
    (0..first.len())
        .map(|i| {
            let mut sum = Dd::ZERO;
            for x in solutions {
                sum += x[i] * share;
            }
            sum
        })
        .collect()
}

#[test]
fn two_stops_by_hand() {
    let matrix = |rows: [[f64; 2]; 2]| Matrix {
        rows: rows.iter().map(|r| r.map(Dd::from).to_vec()).collect(),
    };
    // Coupled stops, both closing: p = G^-1 (1 + e) (-gamma) = (4/3) (1/3) (...) by Cramer's rule.
    let g = matrix([[2.0, 1.0], [1.0, 2.0]]);
    let hit = impulses(&g, &[Dd::from(-1.0), Dd::from(-1.0)], &[0.5, 0.5], 1.0);
    assert!((hit.impulses[0].to_f64() - 0.5).abs() < 1e-15 && hit.rounds == 1);
    assert!((hit.opening[1].to_f64() - 0.5).abs() < 1e-15);
    // One strikes, the other rests: pushed apart by a positive coupling, pressed by a negative one.
    let apart = impulses(&g, &[Dd::from(-1.0), Dd::ZERO], &[0.5, 0.5], 1.0);
    assert!(apart.impulses[1] == Dd::ZERO && apart.opening[1].to_f64() == 0.75);
    let g = matrix([[2.0, -1.0], [-1.0, 2.0]]);
    let pressed = impulses(&g, &[Dd::from(-1.0), Dd::ZERO], &[0.5, 0.5], 1.0);
    assert!(
        (pressed.impulses[0].to_f64() - 1.0).abs() < 1e-15
            && (pressed.impulses[1].to_f64() - 0.5).abs() < 1e-15
    );
    assert!(pressed.opening[1] == Dd::ZERO);
    // The same stop twice.
    let g = matrix([[1.0, 1.0], [1.0, 1.0]]);
    let twice = impulses(&g, &[Dd::from(-1.0), Dd::from(-1.0)], &[0.5, 0.5], 1.0);
    assert!((twice.impulses[0].to_f64() - 0.75).abs() < 1e-15 && twice.doubt.is_none());
}
