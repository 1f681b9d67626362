//! What a trajectory and one period of an orbit have in common: motions that are kept, chapter by chapter, and what is measured of them, at
//! some times or, without these, where they are sampled.

use crate::error::Result;
use crate::impact::Impact;
use crate::model::{Constraint, Normal, PhysicalState, Scene};
use crate::observer::{Observer, unless_broken_off};
use crate::path::chapter::PathChapter;
use crate::path::contacts::{ContactRecord, contacts_along};
use crate::path::drawing::{Samples, joined};
use crate::path::energy::{Energy, energy_along};
use crate::path::equations::PathEquations;
use crate::path::outputs::{Component, Located, check_stop};
use crate::path::parts::PathPoint;
use crate::path::segments::{ImpactSide, RegimeRow, Segment, Stretch};
use nalgebra::DVector;
use std::cell::OnceCell;

/// A motion that is kept: its scene, where it is at a time, and the forcing along it.
pub(crate) trait KeptMotion {
    fn scene(&self) -> &Scene;
    /// The scene at a time, which ramps change.
    fn scene_at(&self, _t: f64) -> &Scene {
        self.scene()
    }
    /// Start and end.
    fn span(&self) -> (f64, f64);
    fn impacts(&self) -> &[Impact];
    /// Its chapters, which follow each other.
    fn chapters(&self) -> Result<Vec<PathChapter<'_>>>;
    /// The parts of a chapter, each once, with the stops in contact.
    fn stretches_of<'a>(&'a self, chapter: &PathChapter<'a>) -> Vec<Stretch<'a>> {
        chapter.path.stretches()
    }
    /// The chapter that a time is in, and the place on its path.
    fn place(&self, t: f64, side: ImpactSide) -> Result<(usize, Located)>;
    /// The states at the times that were asked for when it was made, if any were; they may be kept where the motion is not.
    fn kept_samples(&self) -> Option<&Samples> {
        None
    }
    /// Its chapters as far as its contacts are read from them.
    fn contact_chapters(&self) -> Result<Vec<PathChapter<'_>>> {
        self.chapters()
    }
    /// Its contacts, of one that was saved with them and without its motion.
    fn kept_contacts(&self) -> Option<&[ContactRecord]> {
        None
    }
    /// All that a stop gives, in a window or all along.
    fn impulse_in(&self, stop: usize, window: Option<(f64, f64)>) -> Result<f64>;
    /// The phase of the forcing [rad] as a function of time.
    fn forcing_phase(&self) -> Box<dyn Fn(f64) -> f64 + '_>;
    /// Whether that phase grows at a constant rate.
    fn has_steady_phase(&self) -> bool {
        true
    }
    /// Whether the motion is closed: its end is its start.
    fn is_closed(&self) -> bool {
        false
    }

    /// Its parts, each once, with the stops in contact.
    fn stretches(&self) -> Result<Vec<Stretch<'_>>> {
        let chapters = self.chapters()?;
        Ok(chapters
            .iter()
            .flat_map(|own| self.stretches_of(own))
            .collect())
    }

    /// The states at some times.
    fn states(&self, times: &[f64], side: ImpactSide) -> Result<Vec<PhysicalState>> {
        let state = |&t: &f64| {
            unless_broken_off()?;
            Ok(self.place(t, side)?.1.state)
        };
        times.iter().map(state).collect()
    }

    /// How fast some stops are approached, each at a time, on a side of it.
    fn approach_speeds(&self, places: &[(f64, usize)], side: ImpactSide) -> Result<Vec<f64>> {
        let equations = EquationsByChapter::of(self.chapters()?);
        let speed = |&(t, stop): &(f64, usize)| {
            let (chapter, Located { point, state }) = self.place(t, side)?;
            let own = equations.at(chapter);
            let at = own.moment(point.arc, point.local);
            let (q, v) = (state.0.as_slice(), state.1.as_slice());
            Ok(-own.contacts()[stop].along(|| at, (q, v, v), 0.0)?.speed)
        };
        places.iter().map(speed).collect()
    }

    /// The accelerations at some times.
    fn accelerations(&self, times: &[f64], side: ImpactSide) -> Result<Vec<DVector<f64>>> {
        let equations = EquationsByChapter::of(self.chapters()?);
        let acceleration = |chapter: usize, Located { point, state }| {
            equations.at(chapter).acceleration(point, &state)
        };
        each(self, Some(times), side, acceleration)
    }
}

/// A trajectory, or a periodic orbit: what is measured of its motion.
///
/// Times are those inside the span of a trajectory, and any of an orbit. Where none are given they are those of
/// [`samples`](Self::samples). What is left of impacts that accumulate (a segment `Chatter`) is given as motion with the stop held: its
/// velocity is off the true one, which jumps without end there, by no more than the speed of the first impact left out, along the stop's
/// reaction.
///
/// # Examples
/// ```
/// use vibroimpact::{ImpactSide, Kind, Motion, OrbitOptions, PaperOptions, Pattern, paper_scene, periodic_orbits};
/// let scene = paper_scene(Kind::Three, &PaperOptions::default())?;
/// let orbits = periodic_orbits(&scene, &Pattern::single(1), &OrbitOptions { n_periods: 2, ..Default::default() })?;
/// // The lower pendulum is on its stop at the impact.
/// let lower = orbits[0].along(1, Some(&[0.0]), 0, ImpactSide::After)?;
/// assert!((lower[0] - 0.15).abs() < 1e-12);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
#[expect(private_bounds, reason = "what the crate alone implements and asks")]
pub trait Motion: KeptMotion {
    /// Position and velocity at a time; at an impact the velocity is the one after it, or before it.
    ///
    /// # Errors
    /// A time outside the span of a trajectory, or not finite; a trajectory that does not keep its motion.
    fn state(&self, t: f64, side: ImpactSide) -> Result<PhysicalState> {
        Ok(self.place(t, side)?.1.state)
    }

    /// The motion at the `t_eval` of a run, or, without it, at points for drawing: both sides of each impact, at most 200 a flight, fewer
    /// where these would be more than a million. Of an orbit these are the points of one period, from right after the first impact on.
    ///
    /// # Errors
    /// A trajectory that has neither `t_eval` nor its motion.
    fn samples(&self) -> Result<Samples> {
        if let Some(known) = self.kept_samples() {
            return Ok(known.clone());
        }
        let chapters = self.chapters()?;
        let points = sampled_points(self, &chapters)?;
        let each = chapters.iter().zip(&points);
        let each = each.map(|(own, points)| own.path.samples(points));
        Ok(joined(each.collect::<Result<_>>()?, self.scene().n_dof()))
    }

    /// The times of [`samples`](Self::samples).
    ///
    /// # Errors
    /// As [`samples`](Self::samples).
    fn sample_times(&self) -> Result<Vec<f64>> {
        if let Some((times, ..)) = self.kept_samples() {
            return Ok(times.clone());
        }
        let points = sampled_points(self, &self.chapters()?)?;
        Ok(points.iter().flatten().map(|point| point.time).collect())
    }

    /// `n.q`, `n.v` or `n.a` along a direction n (derivative 0, 1 or 2), at some times or those of the samples. Points for drawing stand on
    /// both sides of each impact, each on its own.
    ///
    /// # Errors
    /// A direction that does not fit the scene, another derivative, a time as for [`state`](Self::state); a trajectory that does not keep
    /// its motion, but for position and velocity at its `t_eval`; what the functions of a nonlinear scene report.
    fn along(
        &self,
        direction: impl Into<Normal>,
        times: Option<&[f64]>,
        derivative: usize,
        side: ImpactSide,
    ) -> Result<Vec<f64>> {
        let component = Component::new(&direction.into(), derivative, self.scene().n_dof())?;
        if let (None, ImpactSide::After, Some((_, q, v))) = (times, side, self.kept_samples()) {
            let row = |k: usize| (q.row(k).transpose(), v.row(k).transpose());
            let known = (0..q.nrows()).map(|k| component.of_state(&row(k)));
            if let Some(known) = known.collect() {
                return Ok(known);
            }
        }
        let equations = EquationsByChapter::of(self.chapters()?);
        each(
            self,
            times,
            side,
            |chapter, Located { point, state }| match component.of_state(&state) {
                Some(known) => Ok(known),
                None => Ok(component.of(&equations.at(chapter).acceleration(point, &state)?)),
            },
        )
    }

    /// The acceleration at a time, shape `(n,)`: that of the equations of motion, free or with stops held. On a segment `Chatter` it is that
    /// of the motion with the stop held, the mean over the impacts.
    ///
    /// # Errors
    /// As [`state`](Self::state); what the functions of a nonlinear scene report.
    fn acceleration(&self, t: f64, side: ImpactSide) -> Result<DVector<f64>> {
        Ok(self.accelerations(&[t], side)?.swap_remove(0))
    }

    /// The gap of a stop, at some times or those of the samples.
    ///
    /// # Errors
    /// A stop that the scene does not have, a time as for [`state`](Self::state); a trajectory that does not keep its motion, but for its
    /// `t_eval`; what the gap function of a nonlinear stop reports.
    fn gap(&self, stop: usize, times: Option<&[f64]>) -> Result<Vec<f64>> {
        check_stop(self.scene(), stop)?;
        if let (None, Some((times, q, _))) = (times, self.kept_samples()) {
            let gap = |(k, &t): (usize, &f64)| {
                unless_broken_off()?;
                Ok(self.scene_at(t).gaps_at(&q.row(k).transpose(), t)?[stop])
            };
            return times.iter().enumerate().map(gap).collect();
        }
        let chapters = self.chapters()?;
        each(self, times, ImpactSide::After, |chapter, place| {
            let scene = chapters[chapter].scene;
            Ok(scene.gaps_at(&place.state.0, place.point.time)?[stop])
        })
    }

    /// The force L of a stop in lasting contact, at least 0, at some times or those of the samples; zero elsewhere. `v' = a_free -
    /// b L`: a force for the reaction of inertia, an acceleration where the reaction has no unit. Impacts that accumulate (a
    /// segment `Chatter`) are no lasting contact.
    ///
    /// # Errors
    /// A stop that the scene does not have, as [`state`](Self::state); what the functions of a nonlinear scene report.
    fn contact_force(&self, stop: usize, times: Option<&[f64]>) -> Result<Vec<f64>> {
        check_stop(self.scene(), stop)?;
        let equations = EquationsByChapter::of(self.chapters()?);
        let after = ImpactSide::After;
        each(self, times, after, |chapter, Located { point, state }| {
            let equations = equations.at(chapter);
            equations.contact_force(stop, point, &state)
        })
    }

    /// All that a stop gives, from right after a time to right after another, or all along, in one period of an orbit: impacts, impacts
    /// that accumulate, the force of lasting contact over its time, `v(t2) - v(t1) = integral of a_free - sum b p`. What happens at the start
    /// of a run counts where the window begins there. Impacts that accumulate (a segment `Chatter`) count as they come in the mean.
    ///
    /// # Errors
    /// A stop that the scene does not have, a window that runs backwards, is not finite or leaves the span of a trajectory; a trajectory that
    /// does not keep its motion; what the functions of a nonlinear scene report.
    fn impulse(&self, stop: usize, window: Option<(f64, f64)>) -> Result<f64> {
        check_stop(self.scene(), stop)?;
        self.impulse_in(stop, window)
    }

    /// The parts of the motion, of an orbit those of one period; several stops in lasting contact have a row each. What stops give on them
    /// is integrated when first asked for.
    ///
    /// # Errors
    /// A trajectory that does not keep its motion; what the functions of a nonlinear scene report.
    fn segments(&self) -> Result<Vec<Segment>> {
        let mut rows = Vec::new();
        for chapter in self.chapters()? {
            let impulses = chapter.impulses_of_segments()?;
            let parts = self.stretches_of(&chapter).into_iter();
            rows.extend(parts.flat_map(|part| part.rows(&impulses[part.segment])));
        }
        Ok(rows)
    }

    /// The contacts by their starts, one row each: an impact, or a stretch along which a stop is pressed or held, with the impact or the
    /// impacts that accumulate with which that begins.
    ///
    /// # Errors
    /// A trajectory of which the end alone is kept; what the functions of a nonlinear scene report.
    fn contacts(&self) -> Result<Vec<ContactRecord>> {
        if let Some(known) = self.kept_contacts() {
            return Ok(known.to_vec());
        }
        let phase = self.forcing_phase();
        let motion = (self.span(), self.is_closed());
        contacts_along(&self.contact_chapters()?, motion, &*phase)
    }

    /// The regimes, one after the other: the state of each element of the scene along each.
    ///
    /// # Errors
    /// A trajectory that does not keep its motion.
    fn regimes(&self) -> Result<Vec<RegimeRow>> {
        let scene = self.scene();
        let mut rows: Vec<RegimeRow> = Vec::new();
        for stretch in self.stretches()? {
            let laws = scene.stops().iter().map(Constraint::contact);
            let next = RegimeRow::of(&stretch, laws);
            match rows.last_mut().filter(|last| last.states == next.states) {
                Some(last) => last.end = next.end,
                None => rows.push(next),
            }
        }
        Ok(rows)
    }

    /// The energy ledger at the times of [`samples`](Self::samples). At the end of a period of an orbit, what the forcing brought is what was
    /// lost.
    ///
    /// # Errors
    /// A trajectory that does not keep its motion; a system given by functions without its mass matrix or its potential.
    fn energy(&self) -> Result<Energy> {
        let (mut all, mut observer) = (Energy::default(), Observer::default());
        let chapters = self.chapters()?;
        let points = sampled_points(self, &chapters)?;
        let mut stored_before = None;
        for (k, (PathChapter { path, scene, .. }, mut points)) in
            chapters.iter().zip(points).enumerate()
        {
            if k + 1 < chapters.len() {
                // What has been brought and lost by its end is there at the start of the next.
                points.push(path.end());
            }
            let (own, [stored, left]) = energy_along(path, scene, &points, &mut observer)?;
            all.go_on(own, stored - stored_before.unwrap_or(stored));
            stored_before = Some(left);
        }
        Ok(all)
    }
}

/// The equations of motion in each chapter, made when first asked for.
struct EquationsByChapter<'a> {
    chapters: Vec<(PathChapter<'a>, OnceCell<PathEquations<'a>>)>,
}

impl<'a> EquationsByChapter<'a> {
    fn of(chapters: Vec<PathChapter<'a>>) -> Self {
        let chapters = chapters.into_iter().map(|own| (own, OnceCell::new()));
        Self {
            chapters: chapters.collect(),
        }
    }

    fn at(&self, chapter: usize) -> &PathEquations<'a> {
        let (own, equations) = &self.chapters[chapter];
        equations.get_or_init(|| PathEquations::new(own.path, own.scene))
    }
}

/// What a motion gives at some times, or at those of its samples, while the caller's work goes on: of the chapter there and the place on its
/// path.
fn each<M: KeptMotion + ?Sized, T>(
    motion: &M,
    times: Option<&[f64]>,
    side: ImpactSide,
    of: impl Fn(usize, Located) -> Result<T>,
) -> Result<Vec<T>> {
    let chapters = motion.chapters()?;
    let value = |chapter: usize, place: Located| {
        unless_broken_off()?;
        of(chapter, place)
    };
    let asked = motion.kept_samples().map(|(times, ..)| times.as_slice());
    if let Some(times) = times.or(asked) {
        let value = |&t: &f64| motion.place(t, side).and_then(|(k, own)| value(k, own));
        return times.iter().map(value).collect();
    }
    let points = sampled_points(motion, &chapters)?;
    let own = |k: usize| points[k].iter().map(move |&point| (k, point));
    let value = |(k, point)| value(k, chapters[k].path.locate(point));
    (0..chapters.len()).flat_map(own).map(value).collect()
}

/// The points of each chapter at which a motion is sampled.
fn sampled_points<M: KeptMotion + ?Sized>(
    motion: &M,
    chapters: &[PathChapter<'_>],
) -> Result<Vec<Vec<PathPoint>>> {
    let Some((times, ..)) = motion.kept_samples() else {
        return chapters.iter().map(|own| own.path.points()).collect();
    };
    let mut points = vec![Vec::new(); chapters.len()];
    for &t in times {
        let (chapter, place) = motion.place(t, ImpactSide::After)?;
        points[chapter].push(place.point);
    }
    Ok(points)
}
