//! The stops of a linear scene in matrices.

use crate::model::{LinearSystem, Reaction, Scene, Side, Stop};
use nalgebra::{DMatrix, DVector};

/// The stops of a linear scene as columns: `gap = c - N^T q`, an impact moves the velocity along B.
#[derive(Debug, Clone)]
pub(crate) struct ContactGeometry {
    /// Normals towards the stops, shape `(n, k)`.
    pub normals: DMatrix<f64>,
    /// Reaction directions, shape `(n, k)`.
    pub reactions: DMatrix<f64>,
    /// Gaps at q = 0, shape `(k,)`.
    pub clearances: DVector<f64>,
    /// Restitution coefficients, shape `(k,)`.
    pub restitutions: DVector<f64>,
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
            restitutions: DVector::from_iterator(k, stops.iter().map(|s| s.restitution().value())),
        }
    }

    /// Whether an impact on one of two stops changes the normal velocity at the other.
    pub fn is_coupled(&self, i: usize, j: usize) -> bool {
        let sees = |n: usize, b: usize| {
            let (n, b) = (self.normals.column(n), self.reactions.column(b));
            n.dot(&b).abs() > 1e-12 * n.norm() * b.norm()
        };
        sees(i, j) || sees(j, i)
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
