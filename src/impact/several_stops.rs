//! Several stops hit at one instant: Newton's law of each as a complementarity problem, after Moreau, in which only stops
//! that close or are in lasting contact take part (theory 9). Opening speeds are `gamma = -N^T v = h'`, negative towards
//! the stop; impulses push away from it.

use crate::error::{Error, Result};
use crate::law::Newton;
use crate::linalg::complementarity;
use crate::quantity::{Restitution, finite_square, finite_vector};
use crate::tolerance::{
    IMPACT_LAW_SLACKS, IMPACT_ROUNDING, MOST_IMPACT_ROUNDS, THROWN_ROUNDS, THROWN_SLACKS,
};
use nalgebra::{DMatrix, DVector};

/// What several stops do at one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct ResolvedImpacts {
    /// The impulse of each stop, all rounds together, at least 0, shape `(k,)`, \[N s\]: `v+ = v- - B p`.
    pub impulses: DVector<f64>,
    /// Opening speeds after the impacts, at least 0, shape `(k,)`, \[m/s\]; exactly 0 where zero within the slack and the rounding
    /// of the impulses. Without an impact those before.
    pub opening_speeds: DVector<f64>,
    /// Complementarity problems solved; 0 where no stop was closing.
    pub rounds: usize,
    /// Whether the stops were still closing one another after 100 rounds, and one more without restitution ended that.
    pub is_inelastic: bool,
}

/// Resolves the impacts of k touching stops at one instant, from the opening speeds `gamma- = -N^T v-` before.
///
/// With the Delassus matrix `G = N^T B` (k, k) and restitutions `E = diag(e)`, the stops that are closing
/// (`gamma- < 0`) or in lasting contact (`gamma- = 0`) obey
///
/// ```text
/// 0 <= p  perp  gamma+ + E gamma- >= 0,    gamma+ = gamma- + G p,
/// ```
///
/// stops that are opening take no part. Where the result closes one of those, the law is applied again to what is then
/// closing or in lasting contact; after 100 such rounds, or where stops that face each other cannot all be left as fast as
/// the law asks, once more to all stops, with e = 0, which ends it. An
/// opening speed within `slack` (k,), at least 0, of zero is zero: what the caller knows about the rounding of
/// `n_i . v`, say `1e-14 sum |n_i| |v_i|`.
///
/// For `b = M^-1 n` the kinetic energy cannot grow, whatever the restitutions: it changes by
/// `-1/2 p^T (I - E) N^T v-` in each round, where `p >= 0` and `N^T v- >= 0`. Other reactions have no such law. Dependent
/// normals (the same stop twice, three stops on two coordinates) make G singular: where all reactions are `M^-1 n`, or all are
/// `n`, the velocity after is the same for all solutions, and the impulses are those of least norm; with others there may be
/// several solutions, of which one is taken, or none.
///
/// # Errors
/// Wrong shapes, numbers that are not finite, a diagonal entry of G (`n . b`) not above zero, restitutions outside [0, 1], a
/// negative slack; reactions with which no impulses that push can keep the stops from closing, or numbers that overflow.
///
/// # References
/// J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics (1988), for the law; C. Glocker, F. Pfeiffer,
/// Multiple impacts with friction in rigid multibody systems, Nonlinear Dynamics 7 (1995) 471, for impacts as a complementarity
/// problem (theirs has Poisson's law, restitution of impulses); theory section 9.
///
/// # Examples
/// Newton's cradle of three equal balls in contact, the first moving: the law's answer is -1/3, 2/3, 2/3.
/// ```
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::resolve_impacts;
/// let (g, e) = (dmatrix![2.0, -1.0; -1.0, 2.0], dvector![1.0, 1.0]);
/// let impacts = resolve_impacts(&g, &e, &dvector![-1.0, 0.0], &dvector![1e-14, 1e-14])?;
/// assert!((impacts.impulses - dvector![4.0 / 3.0, 2.0 / 3.0]).amax() < 1e-15);
/// assert!((impacts.opening_speeds - dvector![1.0, 0.0]).amax() < 1e-15);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn resolve_impacts(
    delassus: &DMatrix<f64>,
    restitutions: &DVector<f64>,
    opening_speeds: &DVector<f64>,
    slack: &DVector<f64>,
) -> Result<ResolvedImpacts> {
    let k = opening_speeds.len();
    check_contacts(delassus, ("opening_speeds", opening_speeds), slack)?;
    finite_vector("restitutions", restitutions, k)?;
    for &e in restitutions.iter() {
        Restitution::new(e)?;
    }
    let mut state = ImpactState::new(opening_speeds, slack);
    let mut rounds = 0;
    while state.is_closing() && rounds < MOST_IMPACT_ROUNDS {
        let entering: Vec<usize> = (0..k).filter(|&i| !state.is_opening(i)).collect();
        // Stops that face each other without room cannot both be left at the speeds that they ask for.
        let Some(has_pushed) = state.apply(delassus, restitutions, &entering)? else {
            break;
        };
        rounds += 1;
        if !has_pushed {
            state.rest();
        }
    }
    let is_inelastic = state.is_closing();
    if is_inelastic {
        state.stop_all(delassus)?.ok_or_else(unsolvable_impacts)?;
        rounds += 1;
    }
    if is_inelastic || rounds > THROWN_ROUNDS {
        state.end_throws(delassus, opening_speeds)?;
    }
    Ok(ResolvedImpacts {
        impulses: state.impulses,
        opening_speeds: state.reported,
        rounds,
        is_inelastic,
    })
}

/// Checks G, the vector that the complementarity is about, and its slack.
pub(crate) fn check_contacts(
    delassus: &DMatrix<f64>,
    (name, values): (&str, &DVector<f64>),
    slack: &DVector<f64>,
) -> Result<()> {
    let k = values.len();
    finite_square("delassus", delassus, k)?;
    for i in 0..k {
        if delassus[(i, i)] <= 0.0 {
            let rule = "n . b of each stop must be greater than zero: its reaction pushes";
            let name = format!("delassus[{i}, {i}]");
            return Err(Error::bad_value(name, delassus[(i, i)], rule));
        }
    }
    finite_vector(name, values, k)?;
    finite_vector("slack", slack, k)?;
    match slack.iter().position(|&s| s < 0.0) {
        Some(i) => {
            let rule = "it must not be negative";
            Err(Error::bad_value(format!("slack[{i}]"), slack[i], rule))
        }
        None => Ok(()),
    }
}

/// Impulses so far, and the opening speeds that they lead to.
struct ImpactState {
    impulses: DVector<f64>,
    /// `gamma- + G p`, as dependent normals need it: speeds that are consistent to rounding.
    speeds: DVector<f64>,
    slack: DVector<f64>,
    /// The same speeds, where the last round's law gives them to all digits.
    reported: DVector<f64>,
}

impl ImpactState {
    fn new(speeds: &DVector<f64>, slack: &DVector<f64>) -> Self {
        Self {
            impulses: DVector::zeros(speeds.len()),
            speeds: speeds.clone(),
            slack: slack.clone(),
            reported: speeds.clone(),
        }
    }

    fn is_zero(&self, i: usize) -> bool {
        self.speeds[i].abs() <= self.slack[i]
    }

    fn is_opening(&self, i: usize) -> bool {
        self.speeds[i] > self.slack[i]
    }

    fn is_closing(&self) -> bool {
        (0..self.speeds.len()).any(|i| self.speeds[i] < -self.slack[i])
    }

    /// Where no impulse is left, what a stop closes with is none: the law knows it to some slacks alone.
    fn rest(&mut self) {
        for i in 0..self.speeds.len() {
            if self.speeds[i].abs() <= IMPACT_LAW_SLACKS * self.slack[i] {
                (self.speeds[i], self.reported[i]) = (0.0, 0.0);
            }
        }
    }

    /// What restitution has thrown to and fro ends without it; what is left within the rounding of all the throws is nothing.
    fn end_throws(&mut self, g: &DMatrix<f64>, before: &DVector<f64>) -> Result<()> {
        let slack = THROWN_SLACKS * &self.slack;
        self.speeds = before + g * &self.impulses;
        self.slack = rounding(g, &self.impulses);
        self.stop_all(g)?;
        self.slack = slack;
        self.rest();
        Ok(())
    }

    /// One round without restitution, for all stops.
    fn stop_all(&mut self, g: &DMatrix<f64>) -> Result<Option<bool>> {
        let all: Vec<usize> = (0..g.nrows()).collect();
        self.apply(g, &DVector::zeros(g.nrows()), &all)
    }

    /// One round: the law for the stops that enter. Whether any was pushed; `None` where the law has no solution.
    fn apply(
        &mut self,
        g: &DMatrix<f64>,
        e: &DVector<f64>,
        entering: &[usize],
    ) -> Result<Option<bool>> {
        // What rounding left of the zero speed of a lasting contact is not to be reversed.
        let before = |i: usize| if self.is_zero(i) { 0.0 } else { self.speeds[i] };
        let matrix = g.select_rows(entering).select_columns(entering);
        let law = |i: usize| Newton::known(e[i]);
        let rebound: Vec<f64> = entering.iter().map(|&i| law(i).change(before(i))).collect();
        let slack: Vec<f64> = entering
            .iter()
            .map(|&i| IMPACT_LAW_SLACKS * self.slack[i])
            .collect();
        let Some(solution) = complementarity::solve(&matrix, &rebound, &slack) else {
            return Ok(None);
        };
        let mut push = DVector::zeros(g.nrows());
        for (p, &i) in solution.x.iter().zip(entering) {
            push[i] = *p;
        }
        let after = &self.speeds + g * &push;
        let mut reported = after.clone();
        for (&w, &i) in solution.w.iter().zip(entering) {
            if w == 0.0 {
                reported[i] = -law(i).departure(before(i));
            }
        }
        self.impulses += &push;
        self.slack += rounding(g, &push);
        self.speeds = after;
        for i in 0..g.nrows() {
            if self.is_zero(i) {
                reported[i] = 0.0;
            }
        }
        self.reported = reported;
        let all = self.speeds.iter().chain(&self.slack).chain(&self.impulses);
        if all.into_iter().all(|value| value.is_finite()) {
            Ok(Some(push.iter().any(|&p| p > 0.0)))
        } else {
            Err(unsolvable_impacts())
        }
    }
}

/// What rounding may make of `G p`: eps times `|n_i| |b_j| p_j`, lengths in the norm where G is their product.
fn rounding(g: &DMatrix<f64>, p: &DVector<f64>) -> DVector<f64> {
    let lengths = g.diagonal().map(f64::sqrt);
    let size = lengths.dot(p) * IMPACT_ROUNDING;
    lengths * size
}

fn unsolvable_impacts() -> Error {
    Error::bad_value(
        "delassus",
        "a matrix for which these impacts have no solution",
        "impulses that push must be able to keep every stop from closing, in numbers that do not overflow",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::impact::recovery_matrix;
    use crate::linalg::seeded::config;
    use crate::model::{ContactGeometry, Forcing, LinearSystem, Reaction, Scene, Stop};
    use nalgebra::{dmatrix, dvector};
    use proptest::prelude::*;

    fn numbers(count: usize) -> impl Strategy<Value = DVector<f64>> {
        proptest::collection::vec(-1.0..1.0_f64, count).prop_map(DVector::from_vec)
    }

    fn restitutions(count: usize) -> impl Strategy<Value = DVector<f64>> {
        let one = prop_oneof![3 => 0.0..=1.0_f64, 1 => Just(0.0), 1 => Just(1.0)];
        proptest::collection::vec(one, count).prop_map(DVector::from_vec)
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn it_agrees_with_the_recovery_matrix_where_that_holds(
            root in numbers(9), normals in numbers(9), e in restitutions(3), v in numbers(3),
            k in 1..4_usize, is_coordinate in any::<bool>(),
        ) {
            let root = DMatrix::from_column_slice(3, 3, root.as_slice());
            let mass = &root * root.transpose() + DMatrix::identity(3, 3) * 0.1;
            let reaction = if is_coordinate { Reaction::Coordinate } else { Reaction::Inertia };
            let stop = |i: usize| {
                let normal = DVector::from_column_slice(&normals.as_slice()[3 * i..][..3]);
                Stop::new(normal, 0.0, e[i])?.with_reaction(reaction.clone())
            };
            let stops = (0..k).map(stop).collect::<Result<Vec<_>>>();
            prop_assume!(stops.is_ok());
            let system = LinearSystem::new(mass, DMatrix::zeros(3, 3), DMatrix::zeros(3, 3)).expect("definite");
            let scene = Scene::new(system.clone(), Forcing::Unforced, stops.expect("assumed")).expect("valid");
            let contacts = ContactGeometry::new(&system, &scene);
            let g = contacts.normals.tr_mul(&contacts.reactions);
            prop_assume!(g.clone().try_inverse().is_some_and(|inverse| inverse.amax() < 1e4));
            // Turned towards the first stop, and towards the others or not.
            let v = if contacts.normals.column(0).dot(&v) < 0.0 { -v } else { v };
            let before = -contacts.normals.tr_mul(&v);
            let rebound = DMatrix::from_diagonal(&DVector::from_fn(k, |i, _| 1.0 + e[i]));
            let by_matrix = g.clone().lu().solve(&(rebound * -&before)).expect("regular");
            prop_assume!(before.max() < 0.0 && by_matrix.min() >= 0.0);
            let e = e.rows(0, k).into_owned();
            let found = resolve_impacts(&g, &e, &before, &DVector::zeros(k)).expect("solvable");
            let stops: Vec<usize> = (0..k).collect();
            let recovery = recovery_matrix(&scene, &stops).expect("independent");
            let after = &v - &contacts.reactions * &found.impulses;
            let expected = recovery.view((3, 3), (3, 3)) * &v;
            prop_assert_eq!((found.rounds, found.is_inelastic), (1, false));
            prop_assert!((after - expected).amax() < 1e-10);
            prop_assert!((&found.opening_speeds + before.component_mul(&e)).amax() == 0.0);
        }

        #[test]
        fn decoupled_stops_are_single_impacts_bit_for_bit(
            nb in proptest::collection::vec(1e-6..1e6_f64, 6), e in restitutions(6), before in numbers(6),
        ) {
            let g = DMatrix::from_diagonal(&DVector::from_vec(nb.clone()));
            let found = resolve_impacts(&g, &e, &before, &DVector::zeros(6)).expect("solvable");
            for i in 0..6 {
                let (impulse, after) = if before[i] < 0.0 {
                    ((1.0 + e[i]) * -before[i] / nb[i], e[i] * -before[i])
                } else {
                    (0.0, before[i])
                };
                prop_assert_eq!((found.impulses[i], found.opening_speeds[i]), (impulse, after));
            }
        }

        #[test]
        fn hostile_numbers_are_errors_or_keep_the_law(
            k in 0..5_usize,
            entries in proptest::collection::vec(
                prop_oneof![8 => 0.0..1.0_f64, 4 => -1.0..1.0_f64, 1 => any::<f64>(), 1 => Just(0.0)], 40,
            ),
        ) {
            let vector = |start: usize| DVector::from_column_slice(&entries[start..start + k]);
            let mut g = DMatrix::from_column_slice(k, k, &entries[..k * k]);
            g.fill_diagonal(entries[39] + 1.0);
            if let Ok(found) = resolve_impacts(&g, &vector(20), &-vector(25), &(vector(30) * 1e-14)) {
                prop_assert!(found.impulses.iter().all(|&p| p >= 0.0 && p.is_finite()));
                prop_assert!(found.opening_speeds.iter().all(|s| s.is_finite()));
                prop_assert!(found.rounds <= MOST_IMPACT_ROUNDS + 1);
            }
        }
    }

    #[test]
    fn the_same_stop_twice_is_one_stop_and_the_livelier_wins() {
        let g = DMatrix::from_element(2, 2, 0.5);
        let resolve = |e| {
            resolve_impacts(&g, &e, &dvector![-2.0, -2.0], &DVector::zeros(2)).expect("solvable")
        };
        // One stop alone: p = 1.5 * 2 / 0.5 = 6, shared.
        let same = resolve(dvector![0.5, 0.5]);
        assert!((same.impulses - dvector![3.0, 3.0]).amax() < 1e-14);
        assert_eq!(same.opening_speeds, dvector![1.0, 1.0]);
        let unequal = resolve(dvector![0.25, 0.5]);
        assert_eq!(unequal.impulses, dvector![0.0, 6.0]);
        assert_eq!(unequal.opening_speeds, dvector![1.0, 1.0]);
    }

    #[test]
    fn a_body_without_room_that_restitution_throws_to_and_fro_comes_to_rest() {
        // Normals whose sum is nothing: no stop can open unless another closes.
        let normals = dmatrix![0.0, 0.0, 0.0; 0.0, -1.0, 1.0; -1.0, 1.0, 0.0];
        let inverse = DMatrix::from_diagonal(&dvector![1.0 / 0.875, 1.0 / 0.870, 1.0 / 1.453]);
        let g = normals.tr_mul(&(inverse * &normals));
        let before = -normals.tr_mul(&dvector![-0.81, -0.2858, -0.0157]);
        for livelier in [0.9, 0.99] {
            let e = dvector![0.826, livelier, 0.0124];
            let slack = before.map(|speed: f64| 1e-14 * speed.abs());
            let found = resolve_impacts(&g, &e, &before, &slack).expect("solvable");
            assert!(found.is_inelastic);
            assert_eq!(found.opening_speeds, DVector::zeros(3));
        }
    }

    #[test]
    fn what_is_thrown_between_two_stops_without_room_comes_to_rest_at_both() {
        // A body of mass 1/50 between stops that push it by an impulse and by its speed.
        let g = dmatrix![50.0, -1.0; -50.0, 1.0];
        let (e, slack) = (dvector![0.5, 0.5], dvector![2e-15, 2e-15]);
        for speed in [0.2, -0.2, 0.3, 0.7, -1.1] {
            let before = dvector![speed, -speed];
            let found = resolve_impacts(&g, &e, &before, &slack).expect("solvable");
            assert_eq!(found.opening_speeds, dvector![0.0, 0.0], "{speed}");
        }
    }

    #[test]
    fn the_impulses_of_what_is_thrown_to_and_fro_bring_it_to_rest() {
        // A body of mass 1 on two equal stops below, one above, and no room; slow is what is slower than 1e-12.
        let normals = dmatrix![-0.45, -0.45, 1.0];
        let g = normals.tr_mul(&normals);
        let (e, slack) = (dvector![0.5, 0.5, 0.5], dvector![1e-12, 1e-12, 1e-12]);
        for speed in [0.07, -0.07, 0.3] {
            let before = -normals.tr_mul(&dvector![speed]);
            let found = resolve_impacts(&g, &e, &before, &slack).expect("solvable");
            assert_eq!(found.opening_speeds, DVector::zeros(3));
            let left = (before + &g * found.impulses).amax();
            assert!(left < 1e-14, "{left} of {speed}");
        }
    }

    #[test]
    fn opening_stops_take_no_part() {
        // Closing 1 and opening 2 with a coupling that pushes 2 open further: the impulse is that of stop 1 alone.
        let g = dmatrix![1.0, 0.5; 0.5, 1.0];
        let (e, none) = (dvector![1.0, 1.0], DVector::zeros(2));
        let found = resolve_impacts(&g, &e, &dvector![-1.0, 0.5], &none).expect("solvable");
        assert_eq!(found.impulses, dvector![2.0, 0.0]);
        assert_eq!(found.opening_speeds, dvector![1.0, 1.5]);
        let apart = resolve_impacts(&g, &e, &dvector![0.0, 0.5], &none).expect("nothing to do");
        assert_eq!((apart.rounds, apart.impulses), (0, DVector::zeros(2)));
    }

    #[test]
    fn bad_input_names_the_argument() {
        let one = |x: f64| DVector::from_element(1, x);
        let message = |g: f64, e: f64, speed: f64, slack: f64| {
            resolve_impacts(
                &DMatrix::from_element(1, 1, g),
                &one(e),
                &one(speed),
                &one(slack),
            )
            .map_or_else(|error| error.to_string(), |found| format!("{found:?}"))
        };
        assert!(message(f64::NAN, 0.5, -1.0, 0.0).starts_with("delassus[0, 0] is NaN"));
        assert!(message(0.0, 0.5, -1.0, 0.0).starts_with("delassus[0, 0] is 0"));
        assert!(message(-1.0, 0.5, -1.0, 0.0).starts_with("delassus[0, 0] is -1"));
        assert!(message(1.0, 1.5, -1.0, 0.0).starts_with("restitution is 1.5"));
        assert!(message(1.0, 0.5, f64::INFINITY, 0.0).starts_with("opening_speeds[0] is inf"));
        assert!(message(1.0, 0.5, -1.0, -1.0).starts_with("slack[0] is -1"));
        assert!(message(1e-300, 1.0, -1e300, 0.0).starts_with("delassus is a matrix for which"));
        assert!(message(1e-200, 1.0, -1e200, 0.0).starts_with("delassus is a matrix for which"));
        let short = resolve_impacts(&DMatrix::identity(2, 2), &one(0.5), &one(-1.0), &one(0.0));
        assert!(short.is_err());
        // Reactions that pull on one another's stops: no impulses keep both from closing.
        let pulling = dmatrix![1.0, -2.0; -2.0, 1.0];
        let two = DVector::from_element(2, -1.0);
        assert!(resolve_impacts(&pulling, &-&two, &two, &DVector::zeros(2)).is_err());
    }
}
