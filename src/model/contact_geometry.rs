//! The stops of a linear scene as matrices: n coordinates, k stops.

use crate::law::{Law, LinearForce, Newton, Regime};
use crate::model::linear::LinearSystem;
use crate::model::reaction::Reaction;
use crate::model::scene::Scene;
use crate::model::stop::{Side, Stop};
use crate::tolerance::{ONE_PLACE, UNCOUPLED};
use nalgebra::{DMatrix, DVector};

/// The stops of a linear scene as columns: `gap = c - N^T q`, an impact moves the velocity along B.
#[derive(Debug, Clone)]
pub(crate) struct ContactGeometry {
    /// Normals towards the stops, shape `(n, k)`, [-].
    pub normals: DMatrix<f64>,
    /// Reaction directions, shape `(n, k)`, [-], or [1/kg] for the reaction of inertia.
    pub reactions: DMatrix<f64>,
    /// Gaps at q = 0, shape `(k,)`, [m].
    pub clearances: DVector<f64>,
    /// The law of each stop, of `k`.
    pub laws: Vec<Law>,
}

/// For each stop the first one at its place: a plane whose normal and clearance are those of the other but for a factor. Those are
/// reached together, whatever rounding leaves of their gaps.
pub(crate) fn places(planes: &[Option<(DVector<f64>, f64)>]) -> Vec<usize> {
    let are_one = |one: &(DVector<f64>, f64), other: &(DVector<f64>, f64)| {
        let factor = one.0.dot(&other.0) / other.0.norm_squared();
        let off = (&one.0 - &other.0 * factor).amax();
        let (here, there) = (one.1, factor * other.1);
        factor > 0.0
            && off <= ONE_PLACE * one.0.amax()
            && (here - there).abs() <= ONE_PLACE * here.abs().max(there.abs())
    };
    let same = |i: usize| {
        let one = planes[i].as_ref()?;
        let is_same =
            |other: &Option<(DVector<f64>, f64)>| other.as_ref().is_some_and(|o| are_one(one, o));
        planes[..i].iter().position(is_same)
    };
    (0..planes.len()).map(|i| same(i).unwrap_or(i)).collect()
}

impl ContactGeometry {
    /// The geometry of every stop of a linear scene.
    pub fn new(system: &LinearSystem, scene: &Scene) -> Self {
        let n = system.n_dof();
        let stops: Vec<&Stop> = scene.plane_stops().collect();
        let k = stops.len();
        let mut normals = DMatrix::zeros(n, k);
        let mut reactions = DMatrix::zeros(n, k);
        for (i, stop) in stops.iter().enumerate() {
            let normal = stop.outward(n);
            let reaction = match stop.reaction() {
                Reaction::Inertia => system.solve_mass(&normal),
                Reaction::Coordinate => normal.clone(),
                Reaction::Direction(b) if stop.side() == Side::Lower => -b,
                Reaction::Direction(b) => b.clone(),
            };
            normals.set_column(i, &normal);
            reactions.set_column(i, &reaction);
        }
        Self {
            normals,
            reactions,
            clearances: DVector::from_iterator(k, stops.iter().map(|s| s.clearance())),
            laws: stops.iter().map(|stop| stop.contact().clone()).collect(),
        }
    }

    /// The law of the impacts of a stop.
    #[inline]
    pub fn law(&self, stop: usize) -> Newton {
        self.laws[stop].newton()
    }

    /// The forces that elements have by their laws in a regime.
    pub fn forces(&self, regime: &Regime) -> impl Iterator<Item = (usize, LinearForce)> {
        let own = regime.others().iter();
        own.filter_map(|&(element, state)| {
            let force = self.laws[element].by_state().force(state);
            force.map(|force| (element, force))
        })
    }

    /// What the elements that are pressed in a regime add to the stiffness and the damping over the mass, shape `(n, n)` each.
    pub fn pressed(&self, regime: &Regime) -> [DMatrix<f64>; 2] {
        let n = self.normals.nrows();
        let mut added = [DMatrix::zeros(n, n), DMatrix::zeros(n, n)];
        for (element, force) in self.forces(regime) {
            let across = self.reactions.column(element) * self.normals.column(element).transpose();
            added[0] += &across * force.stiffness;
            added[1] += across * force.damping;
        }
        added
    }

    /// Whether an impact on one of two stops changes the normal velocity at the other.
    pub fn is_coupled(&self, i: usize, j: usize) -> bool {
        let sees = |n: usize, b: usize| {
            let (n, b) = (self.normals.column(n), self.reactions.column(b));
            n.dot(&b).abs() > UNCOUPLED * n.norm() * b.norm()
        };
        sees(i, j) || sees(j, i)
    }

    /// See [`places`].
    pub fn places(&self) -> Vec<usize> {
        let planes = self.normals.column_iter().zip(self.clearances.iter());
        let planes = planes.map(|(normal, &clearance)| Some((normal.into_owned(), clearance)));
        places(&planes.collect::<Vec<_>>())
    }

    /// The change of the speed along a normal by an impulse of one on a stop, `n_i . b_j`.
    pub fn give(&self, i: usize, j: usize) -> f64 {
        self.normals.column(i).dot(&self.reactions.column(j))
    }

    /// The Delassus matrix `N^T B` of some stops, shape `(k, k)`.
    pub fn delassus(&self, stops: &[usize]) -> DMatrix<f64> {
        let give = |i: usize, j: usize| self.give(stops[i], stops[j]);
        DMatrix::from_fn(stops.len(), stops.len(), give)
    }

    /// Normals and reactions of some stops as columns.
    pub fn columns(&self, stops: &[usize]) -> (DMatrix<f64>, DMatrix<f64>) {
        let select = |of: &DMatrix<f64>| of.select_columns(stops);
        (select(&self.normals), select(&self.reactions))
    }

    /// Normals and reactions of some stops.
    pub fn directions(&self, stops: &[usize]) -> (Vec<DVector<f64>>, Vec<DVector<f64>>) {
        let columns = |of: &DMatrix<f64>| {
            let columns = stops.iter().map(|&i| of.column(i).into_owned());
            columns.collect()
        };
        (columns(&self.normals), columns(&self.reactions))
    }

    /// Number of stops.
    pub fn len(&self) -> usize {
        self.clearances.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dvector;

    #[test]
    fn planes_are_at_one_place_whatever_the_length_of_their_normals() {
        let plane = |x: f64, y: f64, clearance: f64| Some((dvector![x, y], clearance));
        let planes = [
            plane(-1.0, 1.0, 0.3),
            plane(-0.8, 0.8, 0.8 * 0.3),
            // The other side, another place, another direction, no plane.
            plane(1.0, -1.0, -0.3),
            plane(-1.0, 1.0, 0.3 + 1e-14),
            plane(-1.0, 1.0 + 1e-14, 0.3),
            None,
            plane(-3.0, 3.0, 0.9),
            None,
        ];
        assert_eq!(places(&planes), [0, 0, 2, 3, 4, 5, 0, 7]);
        let at_zero = [plane(0.3, 0.0, 0.0), plane(7.0, 0.0, 0.0)];
        assert_eq!(places(&at_zero), [0, 0]);
    }
}
