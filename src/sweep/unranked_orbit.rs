//! The orbits at one point of an existence map before they are ranked. Of a violation of the rules of contact only as much is worked out
//! as the ranking needs.

use crate::error::Result;
use crate::event::walk::StopDepth;
use crate::flow::ModalScene;
use crate::impact::Impact;
use crate::observer::Observer;
use crate::orbit::{Admissibility, Judge, Ruling, Solution, largest_multiplier, list_impacts};
use crate::tolerance::{DISTINCT, ROUGH_MULTIPLIER};

/// One orbit at a point of a map, with what the map needs of it.
pub(super) struct UnrankedOrbit {
    pub solution: Solution,
    impacts: Vec<Impact>,
    admissibility: Admissibility,
}

impl UnrankedOrbit {
    pub fn new(scene: &ModalScene, solution: Solution) -> Self {
        let flights = std::slice::from_ref(&solution.flight);
        let impacts = list_impacts(scene, solution.phase, flights, solution.impulses.as_slice());
        Self {
            solution,
            impacts,
            admissibility: Admissibility::default(),
        }
    }

    pub fn judge(
        &mut self,
        judge: &mut Judge<'_>,
        effort: StopDepth,
        observer: &mut Observer,
    ) -> Result<()> {
        let flights = std::slice::from_ref(&self.solution.flight);
        let phase = self.solution.phase;
        self.admissibility =
            judge.admissibility_to_depth(effort, phase, flights, &self.impacts, observer)?;
        Ok(())
    }

    /// What the rules of contact say.
    pub fn ruling(&self) -> Ruling {
        self.admissibility.ruling()
    }

    /// Depth of the violation, if there is one.
    fn depth(&self) -> Option<f64> {
        self.admissibility.breach.map(|breach| breach.depth)
    }

    pub fn largest_multiplier(
        &self,
        scene: &ModalScene,
        observer: &mut Observer,
    ) -> Result<Option<f64>> {
        let flights = std::slice::from_ref(&self.solution.flight);
        largest_multiplier(
            scene,
            self.solution.phase,
            flights,
            &self.admissibility,
            observer,
        )
    }
}

/// Removes candidates that do not close, and judges the others as far as their ranking needs: a violation that is deeper than an earlier
/// one is not followed to its end, and exact depths are computed only where two are near each other.
pub(super) fn judge_all(
    scene: &ModalScene,
    candidates: &mut Vec<UnrankedOrbit>,
    observer: &mut Observer,
) -> Result<()> {
    let mut judge = Judge::new(scene);
    let motions = candidates.iter().map(|c| {
        let flights = std::slice::from_ref(&c.solution.flight);
        (c.solution.phase, flights)
    });
    let mut closed = judge.are_closed(motions).into_iter();
    candidates.retain(|_| closed.next() == Some(true));
    let mut least = f64::INFINITY;
    for candidate in candidates.iter_mut() {
        candidate.judge(
            &mut judge,
            StopDepth {
                enough: least * (1.0 + DISTINCT),
                depth_error: ROUGH_MULTIPLIER,
            },
            observer,
        )?;
        least = match candidate.ruling() {
            // After an admissible one, any violation is enough.
            Ruling::Admissible => -1.0,
            Ruling::Undecided => least,
            Ruling::Broken(depth) => depth.min(least),
        };
    }
    let mut depths: Vec<f64> = candidates.iter().filter_map(UnrankedOrbit::depth).collect();
    depths.sort_by(f64::total_cmp);
    if depths
        .windows(2)
        .any(|pair| pair[1] > 0.0 && pair[1] - pair[0] <= DISTINCT * pair[1])
    {
        for candidate in candidates {
            candidate.judge(&mut judge, StopDepth::FULL, observer)?;
        }
    }
    Ok(())
}
