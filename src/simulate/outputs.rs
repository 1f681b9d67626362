//! What is measured of a trajectory: components of its motion, gaps, contact forces. Where no times are given they are those of
//! [`Trajectory::samples`].

use crate::error::Result;
use crate::model::Normal;
use crate::path::{
    Component, ImpactSide, Impulses, Located, Path, Window, accelerations, check_stop,
    contact_forces, gaps,
};
use crate::simulate::trajectory::Trajectory;
use nalgebra::DVector;

impl Trajectory {
    /// `n.q`, `n.v` or `n.a` along a direction n (derivative 0, 1 or 2), at some times or those of the samples. Points for
    /// drawing stand on both sides of each impact, each on its own.
    ///
    /// # Errors
    /// A direction that does not fit the scene, another derivative, a time outside the span; a trajectory that does not keep
    /// its motion, but for position and velocity at its `t_eval`.
    pub fn along(
        &self,
        direction: impl Into<Normal>,
        times: Option<&[f64]>,
        derivative: usize,
        side: ImpactSide,
    ) -> Result<Vec<f64>> {
        let component = Component::new(&direction.into(), derivative, self.scene.n_dof())?;
        if let (None, ImpactSide::After, Some((_, q, v))) = (times, side, &self.samples) {
            let row = |k: usize| (q.row(k).transpose(), v.row(k).transpose());
            let known = (0..q.nrows()).map(|k| component.of_state(&row(k)));
            if let Some(known) = known.collect() {
                return Ok(known);
            }
        }
        let places = self.places(times, side)?;
        component.along((self.path()?, &self.scene), places)
    }

    /// The acceleration at a time inside the span, shape `(n,)`: that of the equations of motion, free or with stops held. On a
    /// segment `Chatter` it is that of the motion with the stop held, the mean over the impacts.
    ///
    /// # Errors
    /// A time outside the span, or a trajectory that does not keep its motion; what the functions of a nonlinear scene report.
    pub fn acceleration(&self, t: f64, side: ImpactSide) -> Result<DVector<f64>> {
        Ok(self.accelerations(&[t], side)?.swap_remove(0))
    }

    /// The same at some times.
    pub(crate) fn accelerations(
        &self,
        times: &[f64],
        side: ImpactSide,
    ) -> Result<Vec<DVector<f64>>> {
        let places = self.places(Some(times), side)?;
        accelerations((self.path()?, &self.scene), places)
    }

    /// The gap of a stop, at some times or those of the samples.
    ///
    /// # Errors
    /// A stop that the scene does not have, a time outside the span; a trajectory that does not keep its motion, but for its
    /// `t_eval`; what the gap function of a nonlinear stop reports.
    pub fn gap(&self, stop: usize, times: Option<&[f64]>) -> Result<Vec<f64>> {
        check_stop(&self.scene, stop)?;
        if let (None, Some((times, q, _))) = (times, &self.samples) {
            let samples = times.iter().zip(q.row_iter());
            let samples = samples.map(|(&t, row)| Ok((t, row.transpose())));
            return gaps(&self.scene, stop, samples);
        }
        let places = self.places(times, ImpactSide::After)?;
        gaps(&self.scene, stop, places.map(|place| Ok(place?.position())))
    }

    /// The force L of a stop in lasting contact, at least 0, at some times or those of the samples; zero elsewhere. `v' = a_free -
    /// b L`: a force for the reaction of inertia, an acceleration where the reaction has no unit. Impacts that accumulate (a
    /// segment `Chatter`) are no lasting contact.
    ///
    /// # Errors
    /// A stop that the scene does not have, a time outside the span, a trajectory that does not keep its motion; what the
    /// functions of a nonlinear scene report.
    pub fn contact_force(&self, stop: usize, times: Option<&[f64]>) -> Result<Vec<f64>> {
        check_stop(&self.scene, stop)?;
        let places = self.places(times, ImpactSide::After)?;
        contact_forces((self.path()?, &self.scene), stop, places)
    }

    /// All that a stop gives, from right after a time to right after another, or all along: impacts, impacts that accumulate, the force
    /// of lasting contact over its time, `v(t2) - v(t1) = integral of a_free - sum b p`. What happens at the start of the run
    /// counts where the window begins there. Impacts that accumulate (a segment `Chatter`) count as they come in the mean.
    ///
    /// # Errors
    /// A stop that the scene does not have, a window that runs backwards or leaves the span, a trajectory that does not keep its
    /// motion; what the functions of a nonlinear scene report.
    pub fn impulse(&self, stop: usize, window: Option<(f64, f64)>) -> Result<f64> {
        check_stop(&self.scene, stop)?;
        let path = self.path()?;
        let window = window.map_or(Ok(Window::ALL), |window| Window::of(path, window))?;
        Impulses::new(path, &self.scene, &self.impacts)?.of_stop(stop, window)
    }

    /// The motion at some times, on a side of the impacts there, or at the points of the samples.
    fn places(
        &self,
        times: Option<&[f64]>,
        side: ImpactSide,
    ) -> Result<impl Iterator<Item = Result<Located>>> {
        let path = self.path()?;
        let sampled = self.samples.as_ref().map(|(times, ..)| times.as_slice());
        let points = match times.or(sampled) {
            Some(times) => times.iter().map(|&t| path.point(t, side)).collect(),
            None => path.points(),
        }?;
        let locate = |point| Ok(Path::locate(path, point));
        Ok(points.into_iter().map(locate))
    }
}
