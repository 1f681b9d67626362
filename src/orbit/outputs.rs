//! What is measured of an orbit, at any times: components of its motion, gaps, contact forces.

use crate::error::Result;
use crate::model::Normal;
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::path::{
    Component, ImpactSide, Impulses, Located, Window, accelerations, check_order, check_stop,
    contact_forces, gaps,
};
use crate::quantity::finite;
use nalgebra::DVector;

impl PeriodicOrbit {
    /// `n.q`, `n.v` or `n.a` along a direction n (derivative 0, 1 or 2), at any times.
    ///
    /// # Errors
    /// A direction that does not fit the scene, another derivative, a time that is not finite; what the functions of a nonlinear
    /// scene report.
    pub fn along(
        &self,
        direction: impl Into<Normal>,
        times: &[f64],
        derivative: usize,
        side: ImpactSide,
    ) -> Result<Vec<f64>> {
        let component = Component::new(&direction.into(), derivative, self.scene().n_dof())?;
        component.along((self.path(), self.scene()), self.places(times, side))
    }

    /// The acceleration at any time, shape `(n,)`: that of the equations of motion, free or with stops held. On a segment
    /// `Chatter` it is that of the motion with the stop held, the mean over the impacts.
    ///
    /// # Errors
    /// A time that is not finite; what the functions of a nonlinear scene report.
    pub fn acceleration(&self, t: f64, side: ImpactSide) -> Result<DVector<f64>> {
        Ok(self.accelerations(&[t], side)?.swap_remove(0))
    }

    /// The same at some times.
    pub(crate) fn accelerations(
        &self,
        times: &[f64],
        side: ImpactSide,
    ) -> Result<Vec<DVector<f64>>> {
        accelerations((self.path(), self.scene()), self.places(times, side))
    }

    /// The gap of a stop at any times.
    ///
    /// # Errors
    /// A stop that the scene does not have, a time that is not finite; what the gap function of a nonlinear stop reports.
    pub fn gap(&self, stop: usize, times: &[f64]) -> Result<Vec<f64>> {
        check_stop(self.scene(), stop)?;
        let places = self.places(times, ImpactSide::After);
        gaps(
            self.scene(),
            stop,
            places.map(|place| Ok(place?.position())),
        )
    }

    /// The force L of a stop in lasting contact, at least 0, at any times; zero elsewhere, as of a trajectory.
    ///
    /// # Errors
    /// A stop that the scene does not have, a time that is not finite; what the functions of a nonlinear scene report.
    pub fn contact_force(&self, stop: usize, times: &[f64]) -> Result<Vec<f64>> {
        check_stop(self.scene(), stop)?;
        let places = self.places(times, ImpactSide::After);
        contact_forces((self.path(), self.scene()), stop, places)
    }

    /// All that a stop gives in one period, or from right after a time to right after another: impacts, impacts that accumulate, the
    /// force of lasting contact over its time.
    ///
    /// # Errors
    /// A stop that the scene does not have, times that run backwards or are not finite; what the functions of a nonlinear scene
    /// report.
    pub fn impulse(&self, stop: usize, window: Option<(f64, f64)>) -> Result<f64> {
        check_stop(self.scene(), stop)?;
        let impulses = Impulses::new(self.path(), self.scene(), self.impacts())?;
        let in_period = impulses.of_stop(stop, Window::ALL)?;
        let Some((start, end)) = window else {
            return Ok(in_period);
        };
        check_order((start, end))?;
        let [first, last] = [start, end].map(|t| self.periods_and_rest(t));
        let given = |rest: f64| impulses.of_stop(stop, Window::until(self.path(), rest));
        Ok((last.0 - first.0) * in_period + given(last.1)? - given(first.1)?)
    }

    /// The motion at some times, on a side of the impacts there.
    fn places(&self, times: &[f64], side: ImpactSide) -> impl Iterator<Item = Result<Located>> {
        let locate = move |&t: &f64| Ok(self.locate(finite("t", t)?, side == ImpactSide::Before));
        times.iter().map(locate)
    }
}
