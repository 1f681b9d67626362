//! Proximity of a motion to the attractors: once in each period of the forcing, at a phase far from the impacts of all orbits, its state is
//! compared with the points of every attractor; it is labelled once it has followed one for long enough.
//!
//! Distances are the largest difference of a coordinate in parts of the width of the state box \[-\]; a hit is a period in which the motion
//! is within the radius of a point. Source: docs/theory.md, section 18.

use crate::attractor::{Attractor, StateBox, are_one, points_at, quiet_phase};
use crate::basin::label::Label;
use crate::error::Result;
use crate::model::{PhysicalState, Scene};
use crate::recurrence::Measure;
use crate::simulate::SimulateOptions;
use crate::tolerance::{
    ATTRACTOR_RADIUS, IN_SET, LEFT_BOX, ORBIT_ROUNDS_TO_LABEL, OTHER_ATTRACTOR_PART,
    OWN_POINT_PART, PERIODS_LOST, SET_PERIODS_TO_LABEL,
};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// An attractor as motions are compared with it; coordinates and the radius are in parts of the box.
#[derive(Debug, Clone)]
struct Target {
    /// The points, of an orbit in the order in which it goes through them.
    points: Vec<Vec<f64>>,
    /// The first coordinates, ascending, each with the index of its point.
    firsts: Vec<(f64, usize)>,
    is_set: bool,
    radius: f64,
    hits: usize,
}

/// All attractors at one phase of the forcing.
#[derive(Debug, Clone)]
pub(crate) struct Targets {
    all: Vec<Target>,
    around: StateBox,
    /// The phase at which motions are compared with the points \[rad\].
    pub phase: f64,
}

/// The median distance of points to their nearest neighbours.
fn spacing(points: &[Vec<f64>], around: &StateBox) -> f64 {
    let nearest = |i: usize| {
        let others = points.iter().enumerate().filter(|(j, _)| *j != i);
        others
            .map(|(_, other)| around.apart(&points[i], other))
            .fold(f64::INFINITY, f64::min)
    };
    let mut all: Vec<f64> = (0..points.len()).map(nearest).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(0.0)
}

/// The least distance between a point of one list and a point of the other; of a list and itself, between two of its points.
fn least_of(a: &[Vec<f64>], b: &[Vec<f64>], around: &StateBox) -> f64 {
    let pairs = a.iter().flat_map(|x| b.iter().map(move |y| (x, y)));
    let others = pairs.filter(|(x, y)| !std::ptr::eq(*x, *y));
    let each = others.map(|(x, y)| around.apart(x, y));
    each.fold(f64::INFINITY, f64::min)
}

impl Targets {
    /// The targets of attractors whose points are at a phase \[rad\]. `hits` is the number of periods after which a motion is labelled;
    /// `None`: the default of each attractor.
    pub fn new(
        scene: &Scene,
        attractors: &[Attractor],
        around: &StateBox,
        phase: f64,
        hits: Option<usize>,
        options: &SimulateOptions,
    ) -> Result<Self> {
        scene.check_springs_are_linear("basins")?;
        let quiet = quiet_phase(attractors, phase);
        let scaled = |points: &DMatrix<f64>, k: usize| -> Vec<f64> {
            let mut place = Vec::new();
            around.place(points.row(k).iter(), &mut place);
            place
        };
        let measure = Measure::new(around.turns(), TAU / scene.period().unwrap_or_default());
        // If the list has an attractor twice, the first of the two is labelled.
        let mut earlier: Vec<(DMatrix<f64>, bool)> = Vec::with_capacity(attractors.len());
        let mut all: Vec<Target> = Vec::with_capacity(attractors.len());
        for one in attractors {
            let points = points_at(scene, one, (phase, quiet), options)?;
            let is_set = !one.is_cycle();
            let is_one = |(other, is_other_set): &(DMatrix<f64>, bool)| {
                are_one((&points, !is_set), (other, !is_other_set), &measure)
            };
            let own: Vec<Vec<f64>> = if earlier.iter().any(is_one) {
                Vec::new()
            } else {
                (0..points.nrows()).map(|k| scaled(&points, k)).collect()
            };
            let usual = if is_set {
                SET_PERIODS_TO_LABEL
            } else {
                ORBIT_ROUNDS_TO_LABEL * own.len()
            };
            let mut firsts: Vec<(f64, usize)> = own.iter().map(|x| x[0]).zip(0..).collect();
            firsts.sort_by(|a, b| a.0.total_cmp(&b.0));
            all.push(Target {
                radius: if is_set {
                    IN_SET * spacing(&own, around)
                } else {
                    ATTRACTOR_RADIUS.min(OWN_POINT_PART * least_of(&own, &own, around))
                },
                firsts,
                points: own,
                is_set,
                hits: hits.unwrap_or(usual).max(1),
            });
            earlier.push((points, is_set));
        }
        let nearest = |i: usize| {
            let others = all.iter().enumerate().filter(|(j, _)| *j != i);
            let each = others.map(|(_, other)| least_of(&all[i].points, &other.points, around));
            each.fold(f64::INFINITY, f64::min)
        };
        let least: Vec<f64> = (0..all.len()).map(nearest).collect();
        for (target, least) in all.iter_mut().zip(least) {
            target.radius = target.radius.min(OTHER_ATTRACTOR_PART * least);
        }
        Ok(Self {
            all,
            around: around.clone(),
            phase: quiet,
        })
    }
}

impl Target {
    /// The index of the point that a state is near: the one after that of the period before, if it is near that; else any.
    fn place(&self, around: &StateBox, x: &[f64], before: Option<usize>) -> Option<usize> {
        let is_near = |k: &usize| around.apart(&self.points[*k], x) <= self.radius;
        let after = before.map(|k| (k + 1) % self.points.len());
        after
            .filter(is_near)
            .or_else(|| self.near_in_first(around, x[0]).find(is_near))
    }

    /// The points whose first coordinate is within the radius.
    fn near_in_first(&self, around: &StateBox, first: f64) -> impl Iterator<Item = usize> {
        let before = |limit: f64| self.firsts.partition_point(|own| own.0 < limit);
        let (low, high) = (first - self.radius, first + self.radius);
        // An angle may be near a turn away.
        let range = if around.begins_with_an_angle() {
            0..self.firsts.len()
        } else {
            before(low)..before(high.next_up())
        };
        self.firsts[range].iter().map(|own| own.1)
    }

    /// Whether the second point follows the first; on a set any does.
    fn follows(&self, before: Option<usize>, now: usize) -> bool {
        self.is_set || before.is_some_and(|k| (k + 1) % self.points.len() == now)
    }
}

/// How long one motion has been following each attractor, updated once in each period.
#[derive(Debug, Clone)]
pub(crate) struct ProximityCounter {
    /// Of each attractor the index of the point that the motion is near, and for how many periods in a row it has followed it.
    matches: Vec<(Option<usize>, usize)>,
    /// Periods in a row that the motion has been far from the box.
    away: usize,
    /// The state in parts of the box.
    x: Vec<f64>,
}

impl ProximityCounter {
    /// Of a motion that has not been compared yet.
    pub fn new(targets: &Targets) -> Self {
        Self {
            matches: vec![(None, 0); targets.all.len()],
            away: 0,
            x: Vec::new(),
        }
    }

    /// Takes the state after another period; the label, once it is known.
    pub fn update(&mut self, targets: &Targets, (q, v): &PhysicalState) -> Option<Label> {
        let state = || q.iter().chain(v.iter());
        targets.around.place(state(), &mut self.x);
        // No state is farther from the box than from its lowest corner, which costs less.
        let may_be_away = self
            .x
            .iter()
            .any(|part| part.is_nan() || part.abs() > LEFT_BOX);
        let is_away = may_be_away && targets.around.beyond(state()) > LEFT_BOX;
        self.away = if is_away { self.away + 1 } else { 0 };
        if self.away >= PERIODS_LOST {
            return Some(Label::Lost);
        }
        for (k, (target, (place, hits))) in targets.all.iter().zip(&mut self.matches).enumerate() {
            let now = target.place(&targets.around, &self.x, *place);
            *hits = match now {
                Some(now) if *hits > 0 && target.follows(*place, now) => *hits + 1,
                Some(_) => 1,
                None => 0,
            };
            *place = now;
            if *hits >= target.hits {
                return Some(Label::Attractor(k));
            }
        }
        None
    }
}
