//! Lasting contact that is nobody's: which of dependent stops is held, and whether one without force is.

use crate::runs::case::Case;
use crate::runs::double_double::{Dd, dot};
use crate::runs::motion::Motion;
use crate::runs::record::Stretch;
use crate::runs::reference::Reference;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeSet;
use vibroimpact::Motion as _;
use vibroimpact::{ImpactSide, Trajectory};

pub struct Labels<'a> {
    pub case: &'a Case,
    pub run: &'a Trajectory,
    pub reference: &'a Reference,
    pub theirs: &'a [Stretch],
}

impl Labels<'_> {
    /// Whether a lasting contact of one run may be missing in the other: the library's where its stop stays closed, the
    /// referee's where besides others hold the stop, or nothing pulls at it.
    pub fn is_nobodys(&self, stop: usize, span: (f64, f64), is_mine: bool) -> bool {
        let held = self.held_beside(stop, span);
        let is_held = !is_mine || self.depends(stop, &held) || self.is_idle(stop, &held, span);
        is_held && self.stays_closed(stop, span)
    }

    /// The library's states within a stretch, but for its end, which one of the runs may see a little earlier.
    fn states(&self, (from, to): (f64, f64)) -> impl Iterator<Item = (f64, Vec<f64>)> {
        (0..=20).map_while(move |k| {
            let t = self.case.span.0 + from + (to - from) * f64::from(k) / 20.5;
            let t = t.min(self.run.span().1);
            let (q, v) = self.run.state(t, ImpactSide::After).ok()?;
            Some((t, q.iter().chain(v.iter()).copied().collect()))
        })
    }

    fn stays_closed(&self, stop: usize, span: (f64, f64)) -> bool {
        let counting = self.reference.counting(self.case);
        let size = counting.size(stop);
        let rounding = 1e2 * (counting.gap_rounding(stop) / size).max(1e-14);
        let allowed = rounding.max(self.case.by_method(0.0, self.case.rtol)) * size;
        let gap = |x: &[f64]| self.case.stops[stop].gap(&x[..self.case.n()]);
        self.states(span).all(|(_, x)| gap(&x).abs() <= allowed)
    }

    /// The stops held at some time of a stretch, but for one.
    fn held_beside(&self, stop: usize, (from, to): (f64, f64)) -> Vec<usize> {
        let soon = (1e-6 / self.reference.model.rate).min(0.25 * (to - from));
        let is_stop = |i: usize| i != stop && i < self.case.stops.len();
        let is_during = |s: &&Stretch| s.start < to - soon && s.end > from + soon;
        let sticks = self.reference.main.sticks.iter().chain(self.theirs);
        let held = sticks.filter(is_during).map(|s| s.stop);
        let held: BTreeSet<usize> = held.filter(|&i| is_stop(i)).collect();
        held.into_iter().collect()
    }

    /// Whether a stop is held by others that are.
    fn depends(&self, stop: usize, held: &[usize]) -> bool {
        let unit = |&i: &usize| DVector::from_vec(self.case.stops[i].outward()).normalize();
        let mut normals: Vec<DVector<f64>> = held.iter().map(unit).collect();
        if normals.is_empty() {
            return false;
        }
        let rank = DMatrix::from_columns(&normals).rank(1e-9);
        normals.push(unit(&stop));
        DMatrix::from_columns(&normals).rank(1e-9) == rank
    }

    /// Whether nothing pulls at a stop while others are held, those of them that are independent.
    fn is_idle(&self, stop: usize, held: &[usize], span: (f64, f64)) -> bool {
        let model = &self.reference.model;
        let mut independent = Vec::new();
        for &other in held {
            if !self.depends(other, &independent) {
                independent.push(other);
            }
        }
        let Some(motion) = Motion::new(model, &independent) else {
            return false;
        };
        let normal = &model.stops[stop].normal;
        let sum = |x: &[Dd]| -> f64 { x.iter().map(|x| x.to_f64().abs()).sum() };
        let slow = 1e-9 * model.rate * self.reference.v_unit;
        let known = self.case.by_method(1e-12, self.case.rtol);
        self.states(span).all(|(t, x)| {
            let mut x: Vec<Dd> = x.into_iter().map(Dd::from).collect();
            x.extend(model.forcing_at(self.case, t));
            let least = sum(normal) * (slow + known * sum(&model.free.times(&x)));
            dot(normal, &motion.acceleration(&x)).to_f64().abs() <= least
        })
    }
}
