//! Stability of an orbit (theory 7): the monodromy matrix as the product of flow Jacobians and saltation matrices, its
//! eigenvalues (Floquet multipliers), both orders where stops are hit together, and the reason where there are none.

use crate::error::Result;
use crate::flow::ModalScene;
use crate::hybrid::ModalImpacts;
use crate::itinerary::closing;
use crate::linalg::eigen;
use crate::model::Moment;
use crate::observer::Observer;
use crate::orbit::orbit_data::OrbitArc;
use crate::orbit::verdict::admissibility::{Admissibility, Touch};
use crate::tolerance::{MARGINAL, MEETING};
use nalgebra::{Complex, DMatrix, DVector};
use std::cell::OnceCell;

/// Stops hit together whose orders are all followed; their number grows as the factorial. [work]
const MOST_TOGETHER: usize = 5;

/// The multipliers of one order in which stops hit together are taken.
#[derive(Debug, Clone)]
pub struct OrderMultipliers {
    /// The stops in the order of their impacts over one period.
    pub order: Vec<usize>,
    /// Floquet multipliers, shape `(2n,)`, [-], largest modulus first; one more for each stop that relaxes at t = 0 and is met before it is back.
    pub multipliers: DVector<Complex<f64>>,
    /// The monodromy matrix in (q, v), and the places of such stops behind, shape `(2n, 2n)` or larger, [m, m/s].
    pub monodromy: DMatrix<f64>,
}

/// Whether small deviations die out.
#[derive(Debug, Clone)]
pub struct Stability {
    /// All multipliers inside the unit circle, in every order; `None` where that decides nothing.
    pub is_stable: Option<bool>,
    /// What was decided, and on what ground.
    pub reason: String,
    /// Every order of simultaneous impacts, the worst first; empty where the return map has no derivative.
    pub orders: Vec<OrderMultipliers>,
}

impl Stability {
    /// That of an orbit that has no multipliers, and why.
    pub(crate) fn undefined(reason: String) -> Self {
        Self {
            is_stable: None,
            reason,
            orders: Vec::new(),
        }
    }
}

impl OrderMultipliers {
    /// The largest modulus.
    pub fn spectral_radius(&self) -> f64 {
        self.multipliers
            .iter()
            .map(|z| z.norm())
            .fold(0.0, f64::max)
    }
}

impl OrderMultipliers {
    /// The modulus that decides: two multipliers that meet at 1, as those of motions that keep their energy do, are known to the root of
    /// what one is known to, and count as 1.
    fn decisive(&self) -> f64 {
        let is_one = |mu: &Complex<f64>| (mu - 1.0).norm() < MEETING;
        let is_double = self.multipliers.iter().filter(|mu| is_one(mu)).count() > 1;
        let sizes = self.multipliers.iter().map(|mu| {
            if is_double && is_one(mu) {
                1.0
            } else {
                mu.norm()
            }
        });
        sizes.fold(0.0, f64::max)
    }
}

/// Every order of the given stops.
fn permutations(stops: &[usize]) -> Vec<Vec<usize>> {
    if stops.len() <= 1 {
        return vec![stops.to_vec()];
    }
    let mut all = Vec::new();
    for (i, &first) in stops.iter().enumerate() {
        let rest: Vec<usize> = stops[..i].iter().chain(&stops[i + 1..]).copied().collect();
        all.extend(permutations(&rest).into_iter().map(|mut tail| {
            tail.insert(0, first);
            tail
        }));
    }
    all
}

/// Every way to order the impacts of a period, instant by instant.
fn orders(pattern: &[Vec<usize>]) -> Vec<Vec<Vec<usize>>> {
    pattern.iter().fold(vec![Vec::new()], |so_far, instant| {
        let ways = permutations(instant);
        so_far
            .iter()
            .flat_map(|head| {
                ways.iter().map(move |way| {
                    let mut order = head.clone();
                    order.push(way.clone());
                    order
                })
            })
            .collect()
    })
}

/// Why there are no multipliers.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Refusal {
    GrazingImpact,
    Touched(Touch),
    Coupled(usize, usize),
    TooManyTogether,
    Outgrown,
}

impl Refusal {
    fn describe(self) -> String {
        match self {
            Self::GrazingImpact => {
                "an impact has no approach speed: the return map is not differentiable at a grazing impact".to_owned()
            }
            Self::Touched(Touch { stop, time, .. }) => format!(
                "stop {stop} is touched without impact at t = {time:.6}: the return map is not differentiable there"
            ),
            Self::Coupled(a, b) => format!(
                "stops {a} and {b} are hit together and are coupled by inertia: which is hit first changes the \
                 outcome, so the return map is discontinuous there"
            ),
            Self::Outgrown => {
                "deviations outgrow the largest number within a period: the return map has no derivative in doubles".to_owned()
            }
            Self::TooManyTogether => {
                format!("more than {MOST_TOGETHER} stops are hit together: their orders are too many to follow")
            }
        }
    }
}

/// Why there are no multipliers, if there are none.
fn refusal(
    pattern: &[Vec<usize>],
    found: &Admissibility,
    is_coupled: impl Fn(usize, usize) -> bool,
) -> Option<Refusal> {
    if found.has_grazing_impact {
        return Some(Refusal::GrazingImpact);
    }
    if let Some(&touch) = found.touches.first() {
        return Some(Refusal::Touched(touch));
    }
    for instant in pattern {
        for (i, &a) in instant.iter().enumerate() {
            for &b in &instant[i + 1..] {
                if is_coupled(a, b) {
                    return Some(Refusal::Coupled(a, b));
                }
            }
        }
        if instant.len() > MOST_TOGETHER {
            return Some(Refusal::TooManyTogether);
        }
    }
    None
}

/// The multipliers of an orbit.
pub(crate) fn stability(
    scene: &ModalScene,
    phase: f64,
    flights: &[OrbitArc],
    found: &Admissibility,
    observer: &mut Observer,
) -> Result<Stability> {
    let pattern = &closing(flights);
    let is_coupled = |a, b| scene.geometry.is_coupled(a, b);
    let transformation = OnceCell::new();
    over_orders(pattern, (found, is_coupled), |order| {
        observer.work((2 * scene.form.n_dof()).pow(3))?;
        let (forward, backward) = transformation.get_or_init(|| scene.form.transformation());
        Ok(forward * monodromy(scene, order, phase, flights)? * backward)
    })
}

fn without_multipliers(refusal: Refusal) -> Stability {
    Stability::undefined(refusal.describe())
}

/// The multipliers of every order of the impacts, from its monodromy matrix in (q, v), and what they decide; the reason why there are none,
/// given what the rules of contact say and whether two stops are coupled.
pub(crate) fn over_orders(
    pattern: &[Vec<usize>],
    (found, is_coupled): (&Admissibility, impl Fn(usize, usize) -> bool),
    mut monodromy: impl FnMut(&[Vec<usize>]) -> Result<DMatrix<f64>>,
) -> Result<Stability> {
    if let Some(refusal) = refusal(pattern, found, is_coupled) {
        return Ok(without_multipliers(refusal));
    }
    let mut results = Vec::new();
    for order in orders(pattern) {
        let monodromy = monodromy(&order)?;
        if !monodromy.iter().all(|x| x.is_finite()) {
            return Ok(without_multipliers(Refusal::Outgrown));
        }
        let mut multipliers: Vec<Complex<f64>> = eigen::eigenvalues(&monodromy)?;
        multipliers.sort_by(|a, b| b.norm().total_cmp(&a.norm()));
        results.push(OrderMultipliers {
            order: order.concat(),
            multipliers: DVector::from_vec(multipliers),
            monodromy,
        });
    }
    results.sort_by(|a, b| b.spectral_radius().total_cmp(&a.spectral_radius()));
    Ok(verdict(results))
}

/// Whether a largest modulus means stability; `None` on the unit circle.
pub(crate) fn decides(largest: f64) -> Option<bool> {
    if largest < 1.0 - MARGINAL {
        Some(true)
    } else if largest > 1.0 + MARGINAL {
        Some(false)
    } else {
        None
    }
}

/// The largest modulus of the multipliers, over all orders of the impacts; `None` where there are none.
pub(crate) fn largest_multiplier(
    scene: &ModalScene,
    phase: f64,
    flights: &[OrbitArc],
    found: &Admissibility,
    observer: &mut Observer,
) -> Result<Option<f64>> {
    let pattern = &closing(flights);
    let is_coupled = |a, b| scene.geometry.is_coupled(a, b);
    if refusal(pattern, found, is_coupled).is_some() {
        return Ok(None);
    }
    let mut largest = 0.0f64;
    for order in orders(pattern) {
        let monodromy = monodromy(scene, &order, phase, flights)?;
        if !monodromy.iter().all(|x| x.is_finite()) {
            return Ok(None);
        }
        let multipliers = eigen::eigenvalues(&monodromy)?;
        largest = multipliers.iter().map(|z| z.norm()).fold(largest, f64::max);
        observer.work(multipliers.len().pow(3))?;
    }
    Ok(Some(largest))
}

fn verdict(orders: Vec<OrderMultipliers>) -> Stability {
    let largest = orders
        .iter()
        .map(OrderMultipliers::decisive)
        .fold(0.0, f64::max);
    let is_stable = decides(largest);
    let mut reason = match is_stable {
        Some(true) => {
            format!("the largest multiplier has modulus {largest:.6}, inside the unit circle")
        }
        Some(false) => {
            format!("the largest multiplier has modulus {largest:.6}, outside the unit circle")
        }
        None => "the largest multiplier lies on the unit circle: the first order decides nothing"
            .to_owned(),
    };
    if orders.len() > 1 {
        reason.push_str(
            "; stops are hit together, so each order has its own multipliers, and those of the pieces do not prove \
             stability of the piecewise-linear whole",
        );
    }
    Stability {
        is_stable,
        reason,
        orders,
    }
}

/// The product of flow Jacobians and saltation matrices over one period, from just after the first instant, in modal
/// pairs; the impacts of each instant in the given order.
fn monodromy(
    scene: &ModalScene,
    order: &[Vec<usize>],
    phase: f64,
    flights: &[OrbitArc],
) -> Result<DMatrix<f64>> {
    let n = scene.form.n_dof();
    let mut deviations = DMatrix::identity(2 * n, 2 * n);
    let mut impacts = ModalImpacts::new(scene);
    for (k, flight) in flights.iter().enumerate() {
        scene.form.propagate(flight.span, &mut deviations);
        if order.is_empty() {
            continue;
        }
        let end = flight.start + flight.span;
        let at = Moment::new(end, scene.frequency * end + phase, scene.frequency);
        let mut state = flight.before_next.clone();
        impacts.begin(&state, at);
        for &stop in &order[(k + 1) % order.len()] {
            impacts.strike(stop, &mut state, &mut deviations)?;
        }
    }
    Ok(deviations)
}
