//! Nonlinear gaps along the flights of an orbit: by a bound on their curvature, where they have one, what is passed is proved
//! (`event/certified.rs`); where they have none, the gap itself is asked for beside its quintics.

use crate::error::Result;
use crate::event::certified::{Certified, first_contact};
use crate::event::curvature::BoundedGap;
use crate::event::first_root::FirstRoot;
use crate::event::polynomial::{EndValues, Quintic};
use crate::event::step_path::StepPath;
use crate::flow::steps::Tolerance;
use crate::hybrid::OrbitStep;
use crate::law::Regime;
use crate::model::WatchedGap;
use crate::orbit::verdict::admissibility::{Admissibility, Breach, Rule, Touch};
use crate::orbit::verdict::integrated::IntegratedJudge;
use crate::root::golden_section;

/// Places at which the lowest of a gap beyond its crossing is sought, before golden sections. [work]
const LOWEST_GAP_POINTS: u32 = 64;
/// What flights are known to is a margin, so that their tolerance is nothing. [exact]
const NO_TOLERANCE: Tolerance = Tolerance {
    relative: 0.0,
    absolute: 0.0,
};

impl IntegratedJudge<'_> {
    /// The motion on a step in a regime, by the quintics through both its ends.
    fn path(&self, regime: &Regime, (t, step): (f64, &OrbitStep)) -> Result<StepPath> {
        let known = |at: f64| -> Result<(Vec<f64>, Vec<f64>)> {
            let x = step.dense.at(at);
            let a = self.maps.rate_of(regime, self.maps.moment(t + at), &x)?;
            Ok((x, a))
        };
        let ends = [known(0.0)?, known(step.h)?];
        let n = ends[0].1.len();
        let quintic = |i: usize| {
            let [start, end] = [0, 1].map(|k| [ends[k].0[i], ends[k].0[n + i], ends[k].1[i]]);
            let quintic = Quintic::new(&EndValues::new(start, end, step.h, 0));
            quintic.powers().to_vec()
        };
        Ok(StepPath::new((0..n).map(quintic).collect(), Vec::new()))
    }

    /// Searches the gap of a stop of some curvature along a flight whose first step begins with a root of some order.
    pub(super) fn search_bounded(
        &self,
        (start, steps): (f64, &[OrbitStep]),
        (stop, first_order, curvature): (usize, usize, f64),
        regime: &Regime,
        margin: f64,
        found: &mut Admissibility,
    ) -> Result<()> {
        let mut touches = Vec::new();
        for (i, step) in steps.iter().enumerate() {
            let t = start + step.start;
            let path = self.path(regime, (t, step))?;
            let mut gap = BoundedGap {
                contact: &self.maps.contacts[stop],
                watched: WatchedGap::Gap,
                curvature,
                order: if i == 0 { first_order } else { 0 },
                departed: 0.0,
                begun: self.maps.moment(t),
                h: step.h,
                tolerance: NO_TOLERANCE,
                known: margin,
            };
            if gap.order > 0 {
                gap.departed = gap.at(&path, 0.0)?.gap;
            }
            touches.clear();
            let gaps = [gap];
            let Certified { first, doubt, .. } = first_contact(&gaps, &path, 1.0, &mut touches)?;
            match first.root {
                FirstRoot::Crossing { at, .. } => {
                    let (x, depth) = deepest(&gaps[0], &path, at)?;
                    if depth > margin {
                        found.keep_worst(Breach {
                            stop,
                            time: t + x * step.h,
                            depth,
                            rule: Rule::Passed,
                        });
                    }
                }
                FirstRoot::Undecided { at } if doubt.is_some() => {
                    found.leave_undecided(stop, t + at * step.h);
                }
                FirstRoot::Undecided { .. } | FirstRoot::None => {}
            }
            found.touches.extend(touches.iter().map(|touch| Touch {
                stop,
                time: t + touch.x * step.h,
                gap: -touch.depth,
            }));
        }
        Ok(())
    }
}

/// The deepest place of a gap after a part of a step, and its depth there.
fn deepest(gap: &BoundedGap<'_>, path: &StepPath, from: f64) -> Result<(f64, f64)> {
    let look = |k: u32| from + (1.0 - from) * f64::from(k) / f64::from(LOWEST_GAP_POINTS);
    let mut least = (from, f64::INFINITY);
    let mut nearest = 0;
    for k in 0..=LOWEST_GAP_POINTS {
        let there = gap.at(path, look(k))?.gap;
        if there < least.1 {
            (least, nearest) = ((look(k), there), k);
        }
    }
    let beside = [
        look(nearest.saturating_sub(1)),
        look((nearest + 1).min(LOWEST_GAP_POINTS)),
    ];
    let x = golden_section(beside, |x| gap.at(path, x).map(|there| there.gap))?;
    let there = gap.at(path, x)?.gap;
    if there < least.1 {
        least = (x, there);
    }
    Ok((least.0, -least.1))
}
