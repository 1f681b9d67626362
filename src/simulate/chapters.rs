//! A trajectory by its chapters: which one a time is in, and what is had of the motion of each.

use crate::error::{Error, Result};
use crate::impact::Impact;
use crate::model::{Parameter, Ramp, Scene};
use crate::path::{ImpactSide, KeptMotion, PathChapter, check_time};
use crate::simulate::kept::KeptChapter;
use crate::simulate::trajectory::Trajectory;

impl Trajectory {
    /// The scene of a chapter.
    pub(super) fn scene_of(&self, chapter: usize) -> &Scene {
        match &self.ramped {
            Some(ramped) => &ramped.schedule.chapters[chapter].scene,
            None => &self.scene,
        }
    }

    /// A chapter of the motion.
    ///
    /// # Errors
    /// A trajectory that does not keep its motion.
    pub(super) fn kept(&self, chapter: usize) -> Result<PathChapter<'_>> {
        let Some((own, path)) = self
            .chapters
            .get(chapter)
            .and_then(|own| Some((own, own.path.as_ref()?)))
        else {
            let rule = "the motion is kept with keep=\"motion\" alone: what there is of this run is its last state, the states at t_eval, and its \
                        impacts and contacts with keep=\"impacts\"";
            return Err(Error::bad_value("keep", "\"impacts\" or \"final\"", rule));
        };
        Ok(PathChapter {
            path,
            scene: self.scene_of(chapter),
            impacts: self.impacts_of(chapter),
            contact_impulses: &own.contact_impulses,
            accumulations: &[],
        })
    }

    /// Its chapters as far as contacts are read from them.
    ///
    /// # Errors
    /// A trajectory of which the end alone is kept.
    pub(super) fn chapters_in_contact(&self) -> Result<Vec<PathChapter<'_>>> {
        let mut all = Vec::with_capacity(self.chapters.len());
        for (k, own) in self.chapters.iter().enumerate() {
            all.push(match &own.contacts {
                Some((path, accumulations)) => PathChapter {
                    path,
                    scene: self.scene_of(k),
                    impacts: self.impacts_of(k),
                    contact_impulses: &own.contact_impulses,
                    accumulations,
                },
                None => self.kept(k)?,
            });
        }
        Ok(all)
    }

    /// The chapter that a time is in; where two meet, that of a side.
    pub(super) fn chapter_at(&self, t: f64, side: ImpactSide) -> usize {
        let begun =
            |own: &KeptChapter| own.span.0 < t || (own.span.0 == t && side == ImpactSide::After);
        self.chapters.partition_point(begun).max(1) - 1
    }

    /// The impacts of a chapter.
    pub(super) fn impacts_of(&self, chapter: usize) -> &[Impact] {
        self.impacts
            .get(self.chapters[chapter].impacts.clone())
            .unwrap_or_default()
    }

    /// The ramps of the run.
    pub fn ramps(&self) -> &[Ramp] {
        self.ramped.as_ref().map_or(&[], |ramped| &ramped.ramps)
    }

    /// The value at a time of a number that a ramp moves; the number may be left out where there is one ramp.
    ///
    /// # Errors
    /// A time outside the span, a number without a ramp, none given where there are several or no ramps.
    ///
    /// # References
    /// Theory section 14.
    pub fn parameter(&self, t: f64, name: Option<Parameter>) -> Result<f64> {
        check_time(t, self.span)?;
        let histories = self
            .ramped
            .as_ref()
            .map_or(&[][..], |ramped| &ramped.schedule.histories);
        let found = match (name, histories) {
            (None, [(_, only)]) => Some(only),
            (None, _) => None,
            (Some(name), _) => {
                let own = histories.iter().find(|(own, _)| *own == name);
                own.map(|(_, course)| course)
            }
        };
        let Some(course) = found else {
            let names: Vec<String> = histories
                .iter()
                .map(|(own, _)| format!("\"{own}\""))
                .collect();
            let rule = if names.is_empty() {
                "the run has no ramp: its numbers are those of its scene".to_owned()
            } else {
                format!("it must be one of those with a ramp, {}", names.join(", "))
            };
            let given = name.map_or("None".to_owned(), |name| format!("\"{name}\""));
            return Err(Error::bad_value("name", given, rule));
        };
        Ok(course.at(t))
    }

    /// The forcing phase at a time, from 0 to 2 pi: the angle of the fundamental frequency, which goes on through ramps; zero without
    /// forcing, NaN where there is no period.
    ///
    /// # Errors
    /// A time outside the span.
    pub fn phase(&self, t: f64) -> Result<f64> {
        check_time(t, self.span)?;
        Ok(self.forcing_phase()(t))
    }
}
