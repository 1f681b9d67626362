//! Attractors as what motions are held against, once in each period, at a phase that is far from their impacts.

use crate::attractor::{Attractor, StateBox, points_at, quiet_phase};
use crate::basin::label::Label;
use crate::error::Result;
use crate::model::{PhysicalState, Scene};
use crate::recurrence::{Measure, Sets, are_one_cycle, compared};
use crate::simulate::SimulateOptions;
use crate::tolerance::{FAR, IN_SET};
use nalgebra::DMatrix;
use std::f64::consts::TAU;

/// Rounds for which a motion must follow an orbit, and periods for which it must stay on a set, by default.
const ROUNDS: usize = 3;
const PERIODS: usize = 20;
/// A motion is on an attractor within this part of the box, if no other is nearer than five times that.
const NEAR: f64 = 1e-2;
const OF_OTHERS: f64 = 0.2;
/// And if no other point of an orbit is as near as this part of the distance to it, or more.
const OF_OWN: f64 = 0.4;
/// A motion far away for so many periods has left.
const PERIODS_AWAY: usize = 10;

/// An attractor's points, in parts of the box.
#[derive(Debug, Clone)]
struct Target {
    /// In their order.
    points: Vec<Vec<f64>>,
    /// The first coordinates, ascending, and whose each is.
    firsts: Vec<(f64, usize)>,
    is_set: bool,
    radius: f64,
    hits: usize,
}

/// All attractors at one phase.
#[derive(Debug, Clone)]
pub(crate) struct Targets {
    all: Vec<Target>,
    around: StateBox,
    /// The phase at which motions are looked at.
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

/// The least distance of points of two lists, each from others than itself.
fn least_of(a: &[Vec<f64>], b: &[Vec<f64>], around: &StateBox) -> f64 {
    let pairs = a.iter().flat_map(|x| b.iter().map(move |y| (x, y)));
    let others = pairs.filter(|(x, y)| !std::ptr::eq(*x, *y));
    let each = others.map(|(x, y)| around.apart(x, y));
    each.fold(f64::INFINITY, f64::min)
}

impl Targets {
    /// Attractors whose points are at a phase; so many hits decide, if they are given.
    pub fn new(
        scene: &Scene,
        attractors: &[Attractor],
        around: &StateBox,
        phase: f64,
        hits: Option<usize>,
        options: &SimulateOptions,
    ) -> Result<Self> {
        let quiet = quiet_phase(attractors, phase);
        let scaled = |points: &DMatrix<f64>, k: usize| -> Vec<f64> {
            let mut place = Vec::new();
            around.place(points.row(k).iter(), &mut place);
            place
        };
        let measure = Measure::new(around.turns(), TAU / scene.period().unwrap_or_default());
        // Of a list that has an attractor twice, the first of the two is meant.
        let mut seen: Vec<(DMatrix<f64>, bool)> = Vec::with_capacity(attractors.len());
        let mut all: Vec<Target> = Vec::with_capacity(attractors.len());
        for one in attractors {
            let points = points_at(scene, one, (phase, quiet), options)?;
            let is_set = !one.is_cycle();
            let is_one = |(other, other_is_set): &(DMatrix<f64>, bool)| match (is_set, other_is_set)
            {
                (false, false) => are_one_cycle(&points, other, &measure),
                (true, true) => compared(&points, other, &measure) == Sets::One,
                _ => false,
            };
            let own: Vec<Vec<f64>> = if seen.iter().any(is_one) {
                Vec::new()
            } else {
                (0..points.nrows()).map(|k| scaled(&points, k)).collect()
            };
            let usual = if is_set { PERIODS } else { ROUNDS * own.len() };
            let mut firsts: Vec<(f64, usize)> = own.iter().map(|x| x[0]).zip(0..).collect();
            firsts.sort_by(|a, b| a.0.total_cmp(&b.0));
            all.push(Target {
                radius: if is_set {
                    IN_SET * spacing(&own, around)
                } else {
                    NEAR.min(OF_OWN * least_of(&own, &own, around))
                },
                firsts,
                points: own,
                is_set,
                hits: hits.unwrap_or(usual).max(1),
            });
            seen.push((points, is_set));
        }
        let nearest = |i: usize| {
            let others = all.iter().enumerate().filter(|(j, _)| *j != i);
            let each = others.map(|(_, other)| least_of(&all[i].points, &other.points, around));
            each.fold(f64::INFINITY, f64::min)
        };
        let least: Vec<f64> = (0..all.len()).map(nearest).collect();
        for (target, least) in all.iter_mut().zip(least) {
            target.radius = target.radius.min(OF_OTHERS * least);
        }
        Ok(Self {
            all,
            around: around.clone(),
            phase: quiet,
        })
    }
}

impl Target {
    /// Whether a point is where the motion must be after it was at another, and where that is; from nowhere, anywhere.
    fn place(&self, around: &StateBox, x: &[f64], before: Option<usize>) -> Option<usize> {
        let is_near = |k: &usize| around.apart(&self.points[*k], x) <= self.radius;
        let after = before.map(|k| (k + 1) % self.points.len());
        after
            .filter(is_near)
            .or_else(|| self.beside(around, x[0]).find(is_near))
    }

    /// The points whose first coordinate is near enough.
    fn beside(&self, around: &StateBox, first: f64) -> impl Iterator<Item = usize> {
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

    /// Whether the second place follows the first.
    fn follows(&self, before: Option<usize>, now: usize) -> bool {
        self.is_set || before.is_some_and(|k| (k + 1) % self.points.len() == now)
    }
}

/// What is seen of one motion, looked at once in each period.
#[derive(Debug, Clone)]
pub(crate) struct Course {
    /// Of each attractor the place where the motion is, and for how many periods it has followed it.
    followed: Vec<(Option<usize>, usize)>,
    away: usize,
    x: Vec<f64>,
}

impl Course {
    /// Nothing yet.
    pub fn new(targets: &Targets) -> Self {
        Self {
            followed: vec![(None, 0); targets.all.len()],
            away: 0,
            x: Vec::new(),
        }
    }

    /// The state after another period; what is known then.
    pub fn look(&mut self, targets: &Targets, (q, v): &PhysicalState) -> Option<Label> {
        let state = || q.iter().chain(v.iter());
        targets.around.place(state(), &mut self.x);
        // No state is farther beyond the box than from its lowest corner.
        let may_be_away = self.x.iter().any(|part| part.is_nan() || part.abs() > FAR);
        let is_away = may_be_away && targets.around.beyond(state()) > FAR;
        self.away = if is_away { self.away + 1 } else { 0 };
        if self.away >= PERIODS_AWAY {
            return Some(Label::Lost);
        }
        for (k, (target, (place, hits))) in targets.all.iter().zip(&mut self.followed).enumerate() {
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
