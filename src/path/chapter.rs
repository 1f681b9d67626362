//! A part of a motion that one scene has.

use crate::error::Result;
use crate::impact::Impact;
use crate::model::Scene;
use crate::path::impulses::Impulses;
use crate::path::parts::AccumulationStart;
use crate::path::path::Path;
use std::sync::OnceLock;

/// A path of a scene, with the impacts along it.
#[derive(Clone, Copy)]
pub(crate) struct PathChapter<'a> {
    pub path: &'a Path,
    pub scene: &'a Scene,
    pub impacts: &'a [Impact],
    /// What the stops in contact on each segment of the path give [N s], shape `(n_contacts,)` each, integrated when first asked for.
    pub contact_impulses: &'a OnceLock<Vec<Vec<f64>>>,
    /// Where impacts began to accumulate, of a path that has gaps.
    pub accumulations: &'a [AccumulationStart],
}

impl<'a> PathChapter<'a> {
    /// The impulses of the stops along it.
    pub fn impulses(&self) -> Result<Impulses<'a>> {
        Impulses::new(self.path, self.scene, self.impacts)
    }

    /// Those of the stops in contact on each segment.
    pub fn impulses_of_segments(&self) -> Result<&'a Vec<Vec<f64>>> {
        if let Some(known) = self.contact_impulses.get() {
            return Ok(known);
        }
        let impulses = self.impulses()?.of_segments()?;
        Ok(self.contact_impulses.get_or_init(|| impulses))
    }
}
