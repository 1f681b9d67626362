//! Trajectories to plain numbers, and back without running them.

use crate::error::{Error, Result};
use crate::flow::{ConstrainedMotion, TimedScene};
use crate::hybrid::clock::Clock;
use crate::hybrid::{Graze, SegmentKind};
use crate::impact::{Impact, wrapped};
use crate::model::Scene;
use crate::simulate::kept::{Kept, KeptSegment, Machinery, Piece};
use crate::simulate::options::{Stats, Status};
use crate::simulate::saved::{SavedMotion, SavedTrajectory};
use crate::simulate::saved_rules::{check, check_finite, check_pieces};
use crate::simulate::trajectory::Trajectory;
use nalgebra::DVector;
use std::sync::Arc;

/// Polynomials of steps are of a lower degree than any series.
const LEAST_SERIES: usize = 8;

impl Trajectory {
    /// The trajectory as plain numbers.
    pub fn save(&self) -> SavedTrajectory {
        let s = self.stats;
        let reading = |f: &Piece| {
            let [time, rest] = f.clock.reading();
            [time, rest, f.span]
        };
        SavedTrajectory {
            span: self.span,
            status: self.status.name().to_owned(),
            message: self.message.clone(),
            stats: [
                s.n_rhs,
                s.n_steps,
                s.n_gap_evaluations,
                s.n_flights,
                s.n_impacts,
            ],
            impacts: self
                .impacts
                .iter()
                .map(|i| (i.time, i.stop, i.approach, i.departure, i.impulse, i.phase))
                .collect(),
            grazes: self
                .grazes
                .iter()
                .map(|g| (g.time, g.stop, g.depth))
                .collect(),
            last: (
                self.last.0.as_slice().to_vec(),
                self.last.1.as_slice().to_vec(),
            ),
            motion: self.kept.as_ref().map(|kept| {
                let named = |s: &KeptSegment| (s.kind.name().to_owned(), s.stops.clone(), s.first);
                (
                    kept.pieces.iter().map(reading).collect(),
                    kept.numbers.clone(),
                    kept.segments.iter().map(named).collect(),
                    match self.machinery {
                        Machinery::Exact { .. } => 0,
                        Machinery::Steps { degree } => degree,
                        Machinery::Series { order } => order,
                    },
                )
            }),
            samples: self.samples.clone(),
        }
    }

    /// The trajectory of a scene that was saved.
    ///
    /// # Errors
    /// A status that does not exist, numbers that do not fit the scene or each other.
    pub fn restore(scene: &Scene, saved: SavedTrajectory) -> Result<Self> {
        check(scene, &saved)?;
        let n = scene.n_dof();
        // Without a motion nothing asks what would move it.
        let order = saved.motion.as_ref().map_or(1, |motion| motion.3);
        let frequency = scene.forcing().frequency().unwrap_or(0.0);
        let mut machinery = if order >= LEAST_SERIES {
            Machinery::Series { order }
        } else if order > 0 {
            Machinery::Steps { degree: order }
        } else {
            let timed = TimedScene::of(scene, "a trajectory")?;
            Machinery::Exact {
                modal: Arc::clone(&timed.modal),
                flow: Arc::clone(&timed.flow),
                held: Vec::new(),
            }
        };
        let clock = Clock::new(0.0, frequency);
        let width = |kind| machinery.width(kind, n);
        let kept = saved
            .motion
            .map(|motion| kept(clock, saved.span, motion, width))
            .transpose()?;
        if let (Machinery::Exact { modal, held, .. }, Some(kept)) = (&mut machinery, &kept) {
            for segment in &kept.segments {
                let stops = &segment.stops;
                if !stops.is_empty()
                    && held
                        .iter()
                        .all(|h: &Arc<ConstrainedMotion>| h.stops != *stops)
                {
                    held.push(Arc::new(ConstrainedMotion::new(modal, stops)?));
                }
            }
        }
        let [n_rhs, n_steps, n_gap_evaluations, n_flights, n_impacts] = saved.stats;
        Ok(Self {
            scene: scene.clone(),
            machinery,
            span: saved.span,
            kept,
            impacts: saved
                .impacts
                .into_iter()
                .map(|(time, stop, approach, departure, impulse, phase)| Impact {
                    time,
                    stop,
                    approach,
                    departure,
                    impulse,
                    phase: wrapped(phase),
                })
                .collect(),
            grazes: saved
                .grazes
                .into_iter()
                .map(|(time, stop, depth)| Graze { time, stop, depth })
                .collect(),
            samples: saved.samples,
            last: (
                DVector::from_vec(saved.last.0),
                DVector::from_vec(saved.last.1),
            ),
            status: Status::from_name(&saved.status)?,
            message: saved.message,
            stats: Stats {
                n_rhs,
                n_steps,
                n_gap_evaluations,
                n_flights,
                n_impacts,
            },
        })
    }
}

/// The motion that was saved, on a clock of its scene; `width` is how many numbers a piece of a kind of segment has.
fn kept(
    clock: Clock,
    span: (f64, f64),
    (pieces, numbers, segments, _): SavedMotion,
    width: impl Fn(SegmentKind) -> usize,
) -> Result<Kept> {
    let mut offset = 0;
    let ends = segments.iter().skip(1).map(|next| next.2);
    let ends: Vec<usize> = ends.chain([pieces.len()]).collect();
    let mut segment = |((name, stops, first), end): (&(String, Vec<usize>, usize), &usize)| {
        let kind = SegmentKind::from_name(name)?;
        let kept = KeptSegment {
            kind,
            stops: stops.clone(),
            first: *first,
            offset,
        };
        let numbers = width(kind).checked_mul(end.saturating_sub(*first));
        offset = numbers.map_or(usize::MAX, |numbers| offset.saturating_add(numbers));
        Ok(kept)
    };
    let segments = segments.iter().zip(&ends).map(&mut segment);
    let segments = segments.collect::<Result<Vec<_>>>()?;
    if offset != numbers.len() || (segments.is_empty() && !pieces.is_empty()) {
        let found = format!("{} numbers", numbers.len());
        return Err(Error::bad_shape(
            "saved motion",
            found,
            format!("{offset} numbers"),
        ));
    }
    check_finite("the motion", numbers.iter())?;
    let kept = Kept {
        pieces: pieces
            .iter()
            .map(|&[time, rest, span]| Piece {
                clock: clock.set([time, rest]),
                span,
            })
            .collect(),
        segments,
        numbers,
    };
    check_pieces(&kept, span)?;
    Ok(kept)
}
