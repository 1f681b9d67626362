#![cfg(test)]
//! The order conditions of explicit tableaux, one for each rooted tree (Hairer, Norsett and Wanner, Solving Ordinary Differential
//! Equations I, section II.2).

use crate::flow::steps::dop853::Dop853Tableau;
use crate::flow::steps::dormand_prince::DormandPrinceTableau;
use crate::flow::steps::example::BogackiShampineTableau;
use crate::flow::steps::explicit_rk::{ButcherTableau, EmbeddedError};

/// An order condition: the weights that a rooted tree asks of a method add up to `1/density`.
struct Tree {
    order: usize,
    /// Shape (stages,).
    weights: Vec<f64>,
    density: f64,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `sum_j a_ij x_j`
fn through<T: ButcherTableau>(x: &[f64]) -> Vec<f64> {
    let rows = T::ROWS.iter().map(|row| dot(row, x));
    std::iter::once(0.0).chain(rows).collect()
}

/// The forests of some vertices in all, made of the trees from a first one on: products of their weights and densities.
fn forests<T: ButcherTableau>(
    trees: &[Tree],
    first: usize,
    vertices: usize,
) -> Vec<(Vec<f64>, f64)> {
    if vertices == 0 {
        return vec![(vec![1.0; T::ROWS.len() + 1], 1.0)];
    }
    let mut found = Vec::new();
    for (i, tree) in trees.iter().enumerate().skip(first) {
        if tree.order <= vertices {
            let branch = through::<T>(&tree.weights);
            for (others, density) in forests::<T>(trees, i, vertices - tree.order) {
                let weights = branch.iter().zip(others).map(|(a, b)| a * b).collect();
                found.push((weights, tree.density * density));
            }
        }
    }
    found
}

/// All rooted trees up to an order: a root that carries a forest of smaller ones.
fn trees<T: ButcherTableau>(largest: usize) -> Vec<Tree> {
    let mut trees = Vec::new();
    for order in 1..=largest {
        let forests = forests::<T>(&trees, 0, order - 1).into_iter();
        let rooted = forests.map(|(weights, density)| Tree {
            order,
            weights,
            density: order as f64 * density,
        });
        let rooted: Vec<_> = rooted.collect();
        trees.extend(rooted);
    }
    trees
}

/// Weights of the dense output at the part x of a step.
fn dense<T: ButcherTableau>(x: f64) -> Vec<f64> {
    let (y, b) = (1.0 - x, T::ROWS[T::END - 1]);
    let weight = |i: usize| {
        let (first, last) = (f64::from(i == 0), f64::from(i == T::END));
        let b = b.get(i).copied().unwrap_or(0.0);
        let mut c = vec![b, first - b, 2.0 * b - first - last];
        c.extend(T::DENSE.iter().map(|weights| weights[i]));
        let nested = |sum: f64, (k, c): (usize, &f64)| c + if k % 2 == 0 { y } else { x } * sum;
        x * c.iter().enumerate().rev().fold(0.0, nested)
    };
    (0..=T::ROWS.len()).map(weight).collect()
}

/// Whether a tableau has a solution, an error that vanishes and a dense output of these orders, and of none higher.
fn has_orders<T: ButcherTableau>(name: &str, solution: usize, errors: &[usize], of_dense: usize) {
    for (k, (row, node)) in T::ROWS.iter().zip(T::NODES).enumerate() {
        assert_eq!(row.len(), k + 1, "{name}");
        assert!(
            (row.iter().sum::<f64>() - node).abs() < 1e-14,
            "{name} {node}"
        );
    }
    let trees = trees::<T>(solution + 1);
    // The largest defect of some weights, meant for the part x of a step, in the conditions of one order.
    let defect = |weights: &[f64], order: usize, x: f64| {
        let power = (0..order).fold(1.0, |power, _| power * x);
        let of_order = trees.iter().filter(|tree| tree.order == order);
        of_order
            .map(|tree| (dot(weights, &tree.weights) - power / tree.density).abs())
            .fold(0.0, f64::max)
    };
    let is_of = |weights: &[f64], order: usize, x: f64| {
        for known in 1..=order {
            let defect = defect(weights, known, x);
            assert!(defect < 1e-14, "{name} {known} {x}: {defect}");
        }
        assert!(defect(weights, order + 1, x) > 1e-6, "{name} {x}");
    };
    is_of(T::ROWS[T::END - 1], solution, 1.0);
    let estimates = match T::ERROR {
        EmbeddedError::One(weights) => vec![weights],
        EmbeddedError::FifthAndThird(fifth, third) => vec![fifth, third],
    };
    for (weights, order) in estimates.into_iter().zip(errors) {
        is_of(weights, *order, 0.0);
    }
    for step in 1..10 {
        let x = f64::from(step) / 10.0;
        is_of(&dense::<T>(x), of_dense, x);
    }
}

#[test]
fn tableaux_have_the_orders_of_their_textbooks() {
    has_orders::<DormandPrinceTableau>("rk45", 5, &[4], 4);
    has_orders::<Dop853Tableau>("dop853", 8, &[5, 3], 7);
    has_orders::<BogackiShampineTableau>("example", 3, &[2], 3);
    assert_eq!(trees::<Dop853Tableau>(9).len(), 486);
}

#[test]
fn rows_of_dop853_are_quadratures_of_their_stage_order() {
    // sum_j a_ij c_j^k = c_i^(k+1)/(k+1) from stage 6 on.
    let nodes: Vec<f64> = std::iter::once(0.0)
        .chain(Dop853Tableau::NODES.iter().copied())
        .collect();
    for i in 5..nodes.len() {
        for k in 1..=if i < Dop853Tableau::END { 4 } else { 5 } {
            let powers: Vec<f64> = nodes.iter().map(|c| c.powi(k)).collect();
            let exact = nodes[i].powi(k + 1) / f64::from(k + 1);
            assert!(
                (through::<Dop853Tableau>(&powers)[i] - exact).abs() < 1e-14,
                "{i} {k}"
            );
        }
    }
}
