//! What happens to the twin at its events.

use super::{AT_REST, Course, Happening, Here, NEAR, Twin};
use nalgebra::DVector;

impl Twin {
    pub(super) fn release(
        &self,
        here: &mut Here,
        what: Happening,
        found: &mut Course,
    ) -> Option<()> {
        let Happening::Release(i) = what else {
            return None;
        };
        here.held.retain(|own| *own != i);
        here.open.push((i, 3));
        found.happenings.push(what);
        self.is_pressed(here).then_some(())
    }

    /// Whether what is held is pressed on all of its stops.
    fn is_pressed(&self, here: &mut Here) -> bool {
        let mode = self.mode(here);
        mode.is_some_and(|mode| (&mode.forces * &here.z).iter().all(|force| *force > NEAR))
    }

    /// The opening speed of a stop, and its acceleration in free motion.
    fn opening(&self, i: usize, here: &Here) -> [f64; 2] {
        let a = self.free(self.samples.as_ref().map_or(0.0, |own| own.piece(here.t).1));
        let rate = &a * &here.z;
        [self.gap(i).dot(&rate), self.gap(i).dot(&(&a * rate))]
    }

    /// The stops that receive an impulse, the one set of them for which the law holds, and the change of velocity that they make.
    fn law(&self, here: &Here, i: usize, speed: f64) -> Option<(Vec<usize>, DVector<f64>)> {
        let stop = &self.stops[i];
        let mut all = here.held.clone();
        all.push(i);
        let mut law = None;
        for set in 1..1u32 << all.len() {
            let chosen: Vec<usize> = (0..all.len()).filter(|k| set >> k & 1 == 1).collect();
            let stops: Vec<usize> = chosen.iter().map(|&k| all[k]).collect();
            let [normals, reactions] = self.directions(&stops);
            let wanted = DVector::from_fn(stops.len(), |k, _| {
                if stops[k] == i {
                    -(1.0 + stop.restitution) * speed
                } else {
                    0.0
                }
            });
            let inverse = normals.tr_mul(&reactions).try_inverse();
            let Some(impulses) = inverse.map(|inverse| inverse * wanted) else {
                continue;
            };
            let change = &reactions * &impulses;
            let left = |j: usize| {
                let before = if j == i {
                    (1.0 + stop.restitution) * speed
                } else {
                    0.0
                };
                before + self.stops[j].normal.dot(&change)
            };
            let is_law = impulses.iter().all(|p| *p > 0.0)
                && all
                    .iter()
                    .all(|j| stops.contains(j) || left(*j) > NEAR * -speed);
            if is_law {
                if law.is_some() {
                    return None;
                }
                law = Some((stops, change));
            }
        }
        law
    }

    /// An impact on stop i, in which those held take part.
    pub(super) fn strike(&self, here: &mut Here, i: usize, found: &mut Course) -> Option<()> {
        let near =
            |j: &usize| *j != i && !here.held.contains(j) && self.gap(*j).dot(&here.z) < NEAR;
        if (0..self.stops.len()).any(|j| near(&j)) {
            return None;
        }
        let n = self.n();
        let stop = &self.stops[i];
        let speed = self.opening(i, here)[0];
        let last = found.happenings.last();
        if -speed < NEAR && last != Some(&Happening::Impact(i)) {
            return None;
        }
        let (stops, change) = self.law(here, i, speed)?;
        if !stops.contains(&i) {
            return None;
        }
        let mut v = here.z.rows_mut(n, n);
        v -= change;
        let let_go = here.held.iter().filter(|j| !stops.contains(j));
        here.open.extend(let_go.map(|j| (*j, 1)));
        here.held.retain(|j| stops.contains(j));
        let [opening, pull] = self.opening(i, here);
        let is_at_rest = stop.restitution == 0.0 || (opening < AT_REST && pull < 0.0);
        if !is_at_rest {
            here.open.push((i, 1));
            found.happenings.push(Happening::Impact(i));
            return Some(());
        }
        if pull.abs() < NEAR {
            return None;
        }
        if here.held.is_empty() && pull > 0.0 {
            here.open.push((i, 2));
            found.happenings.push(Happening::Impact(i));
            return Some(());
        }
        if stop.restitution > 0.0 {
            // Of those that led here any number is all of them.
            while found.happenings.last() == Some(&Happening::Impact(i)) {
                found.happenings.pop();
            }
            found.happenings.push(Happening::Chatter(i));
        } else {
            found.happenings.push(Happening::Landing(i));
        }
        if stop.restitution > 0.0 && !here.held.is_empty() {
            return None;
        }
        here.held.push(i);
        let [normals, reactions] = self.directions(&here.held);
        let inverse = normals.tr_mul(&reactions).try_inverse()?;
        let a = self.free(0.0);
        for half in 0..2 {
            let off = DVector::from_fn(here.held.len(), |k, _| {
                let gap = self.gap(here.held[k]);
                if half == 0 {
                    gap.dot(&here.z)
                } else {
                    gap.dot(&(&a * &here.z))
                }
            });
            let moved = &reactions * (&inverse * off);
            let mut part = here.z.rows_mut(half * n, n);
            part += moved;
        }
        self.is_pressed(here).then_some(())
    }
}
