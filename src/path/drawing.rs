//! The points at which a motion is drawn, and the motion at such points.

use crate::error::Result;
use crate::modal::{Form, rate_bound};
use crate::observer::unless_broken_off;
use crate::path::evaluator::Evaluator;
use crate::path::parts::{PathArc, PathPoint};
use crate::path::path::Path;
use crate::quantity::room_for;
use nalgebra::DMatrix;

/// The most points drawn in one flight. [work]
const MOST_DRAWN_POINTS: usize = 200;
/// The most points drawn in all, beside both sides of each impact: as many as any figure shows. [work]
const DRAWN_POINTS_IN_ALL: usize = 1_000_000;
/// The most positions drawn in all, points times coordinates. [work]
const DRAWN_NUMBERS_IN_ALL: usize = 100_000_000;
/// Points drawn in one step of an integrator. [work]
const DRAWN_POINTS_PER_STEP: usize = 4;
/// Points drawn in one radian of the fastest motion [1/rad]. [work]
const DRAWN_POINTS_PER_RADIAN: f64 = 8.0;

/// Times, positions and velocities, shapes `(m,)`, `(m, n)`, `(m, n)`.
pub type Samples = (Vec<f64>, DMatrix<f64>, DMatrix<f64>);

impl Path {
    /// Points for drawing: both sides of each impact, at most 200 a flight, fewer where these would be more than a million.
    ///
    /// # Errors
    /// `Error::Interrupted` where the caller's work is broken off.
    pub fn points(&self) -> Result<Vec<PathPoint>> {
        let parts = &self.parts;
        let rate = self.fastest_rate();
        let count = parts.segments.len();
        let in_all = DRAWN_POINTS_IN_ALL.min(DRAWN_NUMBERS_IN_ALL / self.n_dof);
        let drawn = (in_all / count.max(1)).clamp(2, MOST_DRAWN_POINTS);
        let mut points: Vec<PathPoint> = Vec::new();
        for segment in 0..count {
            unless_broken_off()?;
            let arcs = parts.arcs_of(segment);
            let Some(&first) = parts.arcs[arcs.clone()].first() else {
                continue;
            };
            let span: f64 = parts.arcs[arcs.clone()].iter().map(|p| p.span).sum();
            let wanted = (span * rate * DRAWN_POINTS_PER_RADIAN).ceil() + 1.0;
            let by_steps = (DRAWN_POINTS_PER_STEP * arcs.len()) as f64 + 1.0;
            let wanted = if self.is_stepped() { by_steps } else { wanted };
            // A flight of no length is a side of an impact: one point.
            let most = if span > 0.0 { drawn } else { 1 };
            let count = (wanted.max(2.0) as usize).min(most);
            let (mut arc, mut before) = (arcs.start, 0.0);
            for k in 0..count - 1 {
                let s = span * k as f64 / (count - 1) as f64;
                while arc + 1 < arcs.end && s > before + parts.arcs[arc].span {
                    before += parts.arcs[arc].span;
                    arc += 1;
                }
                points.push(PathPoint {
                    time: first.clock.after(s).time(),
                    arc,
                    local: (s - before).clamp(0.0, parts.arcs[arc].span),
                });
            }
            // The end is the start of the next segment to the bit, which a sum of steps is not.
            let (last, PathArc { clock, span }) = (arcs.end - 1, parts.arcs[arcs.end - 1]);
            points.push(PathPoint {
                time: clock.after(span).time(),
                arc: last,
                local: span,
            });
        }
        // The ends are those asked for, whatever rounding makes of a time counted in periods.
        let ends = points.first().zip(points.last());
        if let Some((first, last)) = ends.map(|(a, b)| (a.time, b.time)) {
            for point in &mut points {
                if point.time == first {
                    point.time = self.span.0;
                } else if point.time == last {
                    point.time = self.span.1;
                }
            }
        }
        Ok(points)
    }

    /// The motion at some points.
    ///
    /// # Errors
    /// More points than there is room for; `Error::Interrupted` where the caller's work is broken off.
    pub fn samples(&self, points: &[PathPoint]) -> Result<Samples> {
        let (m, n) = (points.len(), self.n_dof);
        room_for("the motion at its points", m, 2 * n)?;
        let (mut q, mut v) = (DMatrix::zeros(m, n), DMatrix::zeros(m, n));
        for (i, point) in points.iter().enumerate() {
            unless_broken_off()?;
            let (position, velocity) = self.state_in(point.arc, point.local);
            q.set_row(i, &position.transpose());
            v.set_row(i, &velocity.transpose());
        }
        Ok((points.iter().map(|p| p.time).collect(), q, v))
    }

    fn is_stepped(&self) -> bool {
        !matches!(self.evaluator, Evaluator::Exact { .. })
    }

    /// The fastest of the forcing and the free oscillations of a linear scene.
    fn fastest_rate(&self) -> f64 {
        let Evaluator::Exact { modal, .. } = &self.evaluator else {
            return 0.0;
        };
        let free = match &modal.form.form {
            Form::Blocks(blocks) => blocks
                .iter()
                .flat_map(|b| b.roots())
                .map(|l| l.im.abs())
                .fold(0.0, f64::max),
            Form::Dense(matrix) => rate_bound(matrix),
        };
        let rate = free.max(modal.rotations.fastest());
        if rate > 0.0 {
            rate
        } else {
            MOST_DRAWN_POINTS as f64 / (self.span.1 - self.span.0).max(f64::MIN_POSITIVE)
        }
    }
}

/// The samples of chapters one after another.
pub(crate) fn joined(mut each: Vec<Samples>, n: usize) -> Samples {
    if each.len() == 1 {
        return each.swap_remove(0);
    }
    let count = each.iter().map(|(times, ..)| times.len()).sum();
    let (mut q, mut v) = (DMatrix::zeros(count, n), DMatrix::zeros(count, n));
    let (mut all, mut row) = (Vec::with_capacity(count), 0);
    for (times, positions, velocities) in each {
        q.rows_mut(row, times.len()).copy_from(&positions);
        v.rows_mut(row, times.len()).copy_from(&velocities);
        row += times.len();
        all.extend(times);
    }
    (all, q, v)
}
