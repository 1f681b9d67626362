//! A trajectory as a motion that is kept, chapter by chapter.

use crate::error::Result;
use crate::hybrid::clock::Clock;
use crate::impact::{Impact, wrapped};
use crate::model::Scene;
use crate::path::{
    ContactRecord, ImpactSide, KeptMotion, Located, Motion, PathChapter, Samples, Window,
    check_time,
};
use crate::simulate::trajectory::Trajectory;

impl KeptMotion for Trajectory {
    fn scene(&self) -> &Scene {
        &self.scene
    }

    fn scene_at(&self, t: f64) -> &Scene {
        self.scene_of(self.chapter_at(t, ImpactSide::After))
    }

    fn span(&self) -> (f64, f64) {
        self.span
    }

    fn impacts(&self) -> &[Impact] {
        &self.impacts
    }

    fn chapters(&self) -> Result<Vec<PathChapter<'_>>> {
        self.kept(0)?;
        (0..self.chapters.len()).map(|k| self.kept(k)).collect()
    }

    fn contact_chapters(&self) -> Result<Vec<PathChapter<'_>>> {
        self.chapters_in_contact()
    }

    fn kept_contacts(&self) -> Option<&[ContactRecord]> {
        self.contacts.as_deref()
    }

    fn place(&self, t: f64, side: ImpactSide) -> Result<(usize, Located)> {
        self.kept(0)?;
        check_time(t, self.span)?;
        let chapter = self.chapter_at(t, side);
        let path = self.kept(chapter)?.path;
        Ok((chapter, path.locate(path.point(t, side)?)))
    }

    fn kept_samples(&self) -> Option<&Samples> {
        self.samples.as_ref()
    }

    fn impulse_in(&self, stop: usize, window: Option<(f64, f64)>) -> Result<f64> {
        let chapters = self.chapters()?;
        let window = window.map_or(Ok(Window::ALL), |window| Window::of(self.span, window))?;
        let mut sum = 0.0;
        for chapter in chapters.iter().filter(|own| window.meets(own.path.span)) {
            sum += chapter.impulses()?.of_stop(stop, window)?;
        }
        Ok(sum)
    }

    fn forcing_phase(&self) -> Box<dyn Fn(f64) -> f64 + '_> {
        let clock = Clock::new(0.0, self.scene.frequency().unwrap_or(0.0));
        let phase = self.scene.phase();
        Box::new(move |t| match &self.ramped {
            Some(ramped) => {
                let chapter = self.chapter_at(t, ImpactSide::After);
                wrapped(ramped.schedule.chapters[chapter].angle(t))
            }
            None => wrapped(clock.at(t).angle() + phase),
        })
    }

    fn has_steady_phase(&self) -> bool {
        self.ramps().is_empty()
    }
}

impl Motion for Trajectory {}
