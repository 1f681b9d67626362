//! The equations of a linear system as somebody's own, which are integrated.

use nalgebra::{DMatrix, DVector};
use vibroimpact::{EquationsOfMotion, Result};

pub struct Own {
    pub mass: DMatrix<f64>,
    pub damping: DMatrix<f64>,
    pub stiffness: DMatrix<f64>,
    pub load: DVector<f64>,
}

impl EquationsOfMotion for Own {
    fn n_dof(&self) -> usize {
        self.load.len()
    }

    fn acceleration(&self, _t: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        let [q, v] = [q, v].map(DVector::from_row_slice);
        let force = &self.load - &self.stiffness * q - &self.damping * v;
        let found = self.mass.clone().lu().solve(&force).expect("regular");
        a.copy_from_slice(found.as_slice());
        Ok(())
    }

    fn has_mass(&self) -> bool {
        true
    }

    fn mass(&self, _q: &[f64]) -> Result<DMatrix<f64>> {
        Ok(self.mass.clone())
    }
}
