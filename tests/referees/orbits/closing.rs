//! Whether an orbit closes: its own states after the impacts, moved by the plain matrices over a period, through impacts of
//! the plain law.

use crate::orbits::plant::Plant;
use nalgebra::DVector;
use vibroimpact::{ImpactSide, Motion, PeriodicOrbit};

/// How far an orbit is from being one, each relative to its size.
#[derive(Debug, Clone, Copy, Default)]
pub struct Misfit {
    /// Of the states before and after the impacts.
    pub state: f64,
    /// Of the gaps at the contacts.
    pub gap: f64,
    /// Of the law of the impacts: the normal speeds turn, and the impulses change the velocities.
    pub impact: f64,
}

impl Misfit {
    pub fn worst(&self) -> f64 {
        self.state.max(self.gap).max(self.impact)
    }
}

/// The instants of an orbit: times and stops.
pub fn instants(orbit: &PeriodicOrbit) -> Vec<(f64, Vec<usize>)> {
    let mut all: Vec<(f64, Vec<usize>)> = Vec::new();
    for (k, stops) in orbit.pattern().instants().iter().enumerate() {
        let so_far: usize = orbit.pattern().instants()[..k].iter().map(Vec::len).sum();
        all.push((orbit.impacts()[so_far].time, stops.clone()));
    }
    all
}

/// The misfit of an orbit of a plant, whose clearances may be the orbit's own.
pub fn misfit(plant: &Plant, orbit: &PeriodicOrbit) -> Misfit {
    let n = plant.n();
    let w = orbit.scene().forcing().frequency().expect("forced");
    let mut found = instants(orbit);
    let is_smooth = found.is_empty();
    if is_smooth {
        found.push((0.0, Vec::new()));
    }
    let (mut at, mut fast) = (1e-300f64, 1e-300f64);
    let mut miss = [0.0f64; 2];
    let (mut gap, mut kick, mut pushed) = (0.0f64, 0.0f64, 0.0f64);
    let mut first_impact = 0;
    for (k, (start, stops)) in found.iter().enumerate() {
        let (q, v) = orbit.state(*start, ImpactSide::After).expect("a time");
        let (before_q, before) = orbit.state(*start, ImpactSide::Before).expect("a time");
        // A number that is none is larger than any, which no maximum tells.
        let numbers = [&q, &v, &before_q, &before].into_iter().flatten();
        let impulses = orbit.impacts().iter().map(|i| &i.impulse);
        if !numbers.chain(impulses).all(|x| x.is_finite()) {
            return Misfit {
                state: f64::INFINITY,
                ..Misfit::default()
            };
        }
        let gaps = orbit.scene().gaps(&q).expect("linear");
        miss[0] = miss[0].max((&q - &before_q).amax());
        if !stops.is_empty() {
            let mut after = before.clone();
            for (i, &stop) in stops.iter().enumerate() {
                let face = &plant.faces[stop];
                let length = face.normal.norm();
                gap = gap.max(gaps[stop].abs() / length);
                let turned = face.normal.dot(&v) + face.restitution * face.normal.dot(&before);
                kick = kick.max(turned.abs() / length);
                let push = orbit.impacts()[first_impact + i].impulse;
                after -= &face.reaction * push;
                pushed = pushed.max(push.abs() * face.reaction.norm());
            }
            kick = kick.max((after - &v).amax());
            first_impact += stops.len();
        }
        let end = found.get(k + 1).map_or(orbit.period(), |next| next.0);
        let mut x = plant.lifted(&q, &v, w * start + orbit.phase());
        plant.carry(&mut x, end - start, |_, x| {
            at = at.max(x.rows(0, n).amax());
            fast = fast.max(x.rows(n, n).amax());
        });
        let (q, v): (DVector<f64>, DVector<f64>) = if is_smooth {
            orbit.state(0.0, ImpactSide::After).expect("a time")
        } else {
            orbit.state(end, ImpactSide::Before).expect("a time")
        };
        miss[0] = miss[0].max((x.rows(0, n) - q).amax());
        miss[1] = miss[1].max((x.rows(n, n) - v).amax());
    }
    Misfit {
        state: (miss[0] / at).max(miss[1] / fast),
        gap: gap / at,
        impact: kick / fast.max(pushed),
    }
}
