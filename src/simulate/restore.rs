//! Trajectories to plain numbers, and back without running them.

use crate::error::{Error, Result};
use crate::flow::TimedScene;
use crate::hybrid::clock::Clock;
use crate::hybrid::{Graze, SegmentKind, regime_motions};
use crate::impact::{Impact, wrapped};
use crate::law::Regime;
use crate::model::Scene;
use crate::path::{ContactRecord, Evaluator, Motion, Path, PathArc, PathParts, PathSegment};
use crate::simulate::kept::{KeptChapter, Ramped};
use crate::simulate::motion_state::Left;
use crate::simulate::options::{Stats, Status};
use crate::simulate::saved::{SavedMotion, SavedTrajectory};
use crate::simulate::saved_rules::{check, check_arcs, check_chapters, check_finite};
use crate::simulate::schedule::Schedule;
use crate::simulate::trajectory::Trajectory;
use crate::tolerance::TIME_TOL;
use nalgebra::DVector;
use std::sync::{Arc, OnceLock};

/// The least order of a series in a saved motion: numbers below it are degrees of the polynomials of steps. [exact]
const LEAST_SERIES_ORDER: usize = 8;

impl Trajectory {
    /// The trajectory as plain numbers.
    pub fn save(&self) -> SavedTrajectory {
        let s = self.stats;
        SavedTrajectory {
            span: self.span,
            status: self.status.name().to_owned(),
            message: self.message.clone(),
            stats: {
                let contacts = Some(s.n_contacts).filter(|count| *count > 0);
                let others = [
                    s.n_rhs,
                    s.n_steps,
                    s.n_gap_evaluations,
                    s.n_flights,
                    s.n_impacts,
                ];
                others.into_iter().chain(contacts).collect()
            },
            atol: s.atol,
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
            motion: self
                .chapters
                .iter()
                .map(|own| own.path.as_ref().map(numbers))
                .collect(),
            ramps: match &self.ramped {
                Some(ramped) => (ramped.ramps.clone(), ramped.until),
                None => (Vec::new(), self.span.1),
            },
            chapters: {
                let own = self.chapters.iter();
                own.map(|own| (own.span.0, own.span.1, own.impacts.start))
                    .collect()
            },
            left: Some(self.left.save()),
            contacts: self.saved_contacts(),
            samples: self.samples.clone(),
        }
    }

    /// The trajectory of a scene that was saved.
    ///
    /// # Errors
    /// A status that does not exist, numbers that do not fit the scene or each other.
    pub fn restore(scene: &Scene, saved: SavedTrajectory) -> Result<Self> {
        check(scene, &saved)?;
        let (ramps, until) = saved.ramps;
        let schedule = (!ramps.is_empty())
            .then(|| {
                let span = (saved.span.0, until);
                Schedule::new(scene, &ramps, span)
            })
            .transpose()?;
        check_chapters(
            saved.span,
            &saved.chapters,
            saved.impacts.len(),
            schedule.as_ref(),
        )?;
        let mut motions = saved.motion.map(Vec::into_iter);
        let mut chapters = Vec::with_capacity(saved.chapters.len());
        let ends = saved.chapters.iter().skip(1).map(|next| next.2);
        let ends = ends.chain([saved.impacts.len()]);
        for (k, (&(start, end, first), last)) in saved.chapters.iter().zip(ends).enumerate() {
            let own = schedule
                .as_ref()
                .map_or(scene, |all| &all.chapters[k].scene);
            let motion = motions
                .as_mut()
                .map(|motions| motions.next().unwrap_or_default());
            chapters.push(KeptChapter {
                path: motion
                    .map(|motion| path(own, (start, end), motion))
                    .transpose()?,
                contacts: None,
                contact_impulses: OnceLock::new(),
                span: (start, end),
                impacts: first..last,
            });
        }
        let left = Left::of_saved(scene, saved.left, chapters.last())?;
        let &[
            n_rhs,
            n_steps,
            n_gap_evaluations,
            n_flights,
            n_impacts,
            ref contacts @ ..,
        ] = saved.stats.as_slice()
        else {
            let found = format!("({},)", saved.stats.len());
            return Err(Error::bad_shape("stats", found, "(5,) or (6,)"));
        };
        let n_contacts = contacts.first().copied().unwrap_or(0);
        Ok(Self {
            scene: scene.clone(),
            chapters,
            ramped: schedule.map(|schedule| {
                Arc::new(Ramped {
                    ramps,
                    until,
                    schedule,
                })
            }),
            span: saved.span,
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
                n_contacts,
                atol: saved.atol,
            },
            left,
            contacts: saved
                .contacts
                .map(|all| read_contacts(scene, saved.span, &all))
                .transpose()?,
        })
    }

    /// Its contacts as plain numbers, where the motion from which they follow is not kept.
    fn saved_contacts(&self) -> Option<Vec<f64>> {
        let is_apart = |own: &KeptChapter| own.contacts.is_some();
        let are_known = self.contacts.is_some() || self.chapters.iter().any(is_apart);
        let rows = are_known.then(|| self.contacts().ok()).flatten()?;
        Some(rows.iter().flat_map(ContactRecord::written).collect())
    }
}

/// The contacts that were saved.
fn read_contacts(
    scene: &Scene,
    (start, end): (f64, f64),
    numbers: &[f64],
) -> Result<Vec<ContactRecord>> {
    let (rows, rest) = numbers.as_chunks::<10>();
    let n_stops = scene.stops().len() as f64;
    let is_stop = |stop: f64| stop.fract() == 0.0 && (0.0..n_stops).contains(&stop);
    let slack = TIME_TOL * start.abs().max(end.abs());
    let is_within = |t: f64| t.is_nan() || (start - slack..=end + slack).contains(&t);
    let is_one = |row: &[f64; 10]| is_stop(row[0]) && row[1..3].iter().all(|t| is_within(*t));
    if rest.is_empty() && rows.iter().all(is_one) {
        return Ok(rows.iter().copied().map(ContactRecord::read).collect());
    }
    let rule = "they must be those of stops of the scene, within the span of the run";
    Err(Error::bad_value(
        "the contacts of the saved trajectory",
        "others",
        rule,
    ))
}

/// A motion that is kept as plain numbers.
fn numbers(path: &Path) -> SavedMotion {
    let parts = &path.parts;
    let named = |s: &PathSegment| (s.kind.name().to_owned(), s.regime.written(), s.first);
    let reading = |f: &PathArc| {
        let [time, rest] = f.clock.reading();
        [time, rest, f.span]
    };
    (
        parts.arcs.iter().map(reading).collect(),
        parts.numbers.clone(),
        parts.segments.iter().map(named).collect(),
        match path.evaluator {
            Evaluator::Exact { .. } => 0,
            Evaluator::Steps { degree } => degree,
            Evaluator::Series { order } => order,
        },
    )
}

/// The motion of a scene that was saved.
fn path(scene: &Scene, span: (f64, f64), motion: SavedMotion) -> Result<Path> {
    let (n_dof, order) = (scene.n_dof(), motion.3);
    let mut evaluator = if order >= LEAST_SERIES_ORDER {
        Evaluator::Series { order }
    } else if order > 0 {
        Evaluator::Steps { degree: order }
    } else {
        let timed = TimedScene::of(scene, "a trajectory")?;
        Evaluator::Exact {
            modal: Arc::clone(&timed.modal),
            flow: Arc::clone(&timed.flow),
            regimes: Vec::new(),
            phase: 0.0,
        }
    };
    let clock = Clock::new(0.0, scene.frequency().unwrap_or(0.0));
    let parts = kept(clock, span, motion, |regime| evaluator.width(regime, n_dof))?;
    if let Evaluator::Exact { modal, regimes, .. } = &mut evaluator {
        let each = parts.segments.iter().map(|segment| &segment.regime);
        *regimes = regime_motions(modal, each)?;
    }
    Ok(Path {
        evaluator,
        parts,
        span,
        n_dof,
    })
}

/// The motion that was saved, on a clock of its scene; `width` is how many numbers a piece in a regime has.
fn kept(
    clock: Clock,
    span: (f64, f64),
    (arcs, numbers, segments, _): SavedMotion,
    width: impl Fn(&Regime) -> usize,
) -> Result<PathParts> {
    let mut offset = 0;
    let ends = segments.iter().skip(1).map(|next| next.2);
    let ends: Vec<usize> = ends.chain([arcs.len()]).collect();
    let mut segment = |((name, stops, first), end): (&(String, Vec<usize>, usize), &usize)| {
        let kind = SegmentKind::from_name(name)?;
        let kept = PathSegment {
            kind,
            regime: Regime::read(stops).unwrap_or_default(),
            first: *first,
            offset,
        };
        let numbers = width(&kept.regime).checked_mul(end.saturating_sub(*first));
        offset = numbers.map_or(usize::MAX, |numbers| offset.saturating_add(numbers));
        Ok(kept)
    };
    let segments = segments.iter().zip(&ends).map(&mut segment);
    let segments = segments.collect::<Result<Vec<_>>>()?;
    if offset != numbers.len() || (segments.is_empty() && !arcs.is_empty()) {
        let found = format!("{} numbers", numbers.len());
        return Err(Error::bad_shape(
            "saved motion",
            found,
            format!("{offset} numbers"),
        ));
    }
    check_finite("the motion", numbers.iter())?;
    let kept = PathParts {
        arcs: arcs
            .iter()
            .map(|&[time, rest, span]| PathArc {
                clock: clock.set([time, rest]),
                span,
            })
            .collect(),
        segments,
        numbers,
        has_gaps: false,
    };
    check_arcs(&kept, span)?;
    Ok(kept)
}
