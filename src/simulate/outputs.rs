//! What is measured of a trajectory: components of its motion, gaps, contact forces. Where no times are given they are those of
//! [`Trajectory::samples`].

use crate::error::Result;
use crate::model::Normal;
use crate::path::{
    Component, ImpactSide, Impulses, Window, accelerations, check_stop, contact_forces, gaps,
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
        self.each_kept(&self.places(times, side)?, |kept, points| {
            component.along(kept, kept.0.located(points))
        })
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
        self.each_kept(&self.places(Some(times), side)?, |kept, points| {
            accelerations(kept, kept.0.located(points))
        })
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
            let gap = |(&t, row): (&f64, _)| {
                let scene = self.scene_of(self.chapter_at(t, ImpactSide::After));
                let position = nalgebra::Matrix::transpose(&row);
                Ok(gaps(scene, stop, std::iter::once(Ok((t, position))))?[0])
            };
            return samples.map(gap).collect();
        }
        self.each_kept(
            &self.places(times, ImpactSide::After)?,
            |(path, scene), points| {
                let located = path.located(points);
                gaps(scene, stop, located.map(|place| Ok(place?.position())))
            },
        )
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
        self.each_kept(&self.places(times, ImpactSide::After)?, |kept, points| {
            contact_forces(kept, stop, kept.0.located(points))
        })
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
        self.kept(0)?;
        let window = window.map_or(Ok(Window::ALL), |window| Window::of(self.span, window))?;
        let mut sum = 0.0;
        for chapter in 0..self.chapters.len() {
            let (path, scene) = self.kept(chapter)?;
            if window.meets(path.span) {
                let impulses = Impulses::new(path, scene, self.impacts_of(chapter))?;
                sum += impulses.of_stop(stop, window)?;
            }
        }
        Ok(sum)
    }
}
