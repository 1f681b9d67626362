//! What a saved trajectory must be: a file may have been changed, and numbers that no run leaves behind would be looked up
//! where there is nothing.

use crate::error::{Error, Result};
use crate::flow::taylor::MOST_ORDER;
use crate::hybrid::SegmentKind;
use crate::model::Scene;
use crate::path::{PathArc, PathParts};
use crate::simulate::saved::SavedTrajectory;
use crate::simulate::schedule::Schedule;
use crate::tolerance::TIME_TOL;

/// Refuses a part of what was saved.
fn refused(part: &str, found: impl ToString, rule: &str) -> Error {
    Error::bad_value(format!("{part} of the saved trajectory"), found, rule)
}

/// Refuses numbers that are not finite.
pub(super) fn check_finite<'a>(
    part: &str,
    mut values: impl Iterator<Item = &'a f64>,
) -> Result<()> {
    match values.find(|x| !x.is_finite()) {
        None => Ok(()),
        Some(x) => Err(refused(part, x, "it must be finite")),
    }
}

fn check_stop(part: &str, stop: usize, scene: &Scene) -> Result<()> {
    let count = scene.stops().len();
    if stop < count {
        return Ok(());
    }
    let rule = format!("the scene has {count} stops");
    Err(refused(part, format!("on stop {stop}"), &rule))
}

/// Times that lie in the span of a run, but for rounding, and ascend.
fn check_times(
    part: &str,
    (start, end): (f64, f64),
    times: impl Iterator<Item = f64>,
) -> Result<()> {
    let slack = TIME_TOL * start.abs().max(end.abs());
    let mut last = start;
    for t in times {
        // A time that is no number is none of these.
        let is_next = t >= last - slack && t <= end + slack;
        if !is_next {
            let rule = format!("times must ascend within the span [{start}, {end}]");
            return Err(refused(part, format!("at t = {t}"), &rule));
        }
        last = t;
    }
    Ok(())
}

/// Refuses numbers that no run of the scene leaves behind.
pub(super) fn check(scene: &Scene, saved: &SavedTrajectory) -> Result<()> {
    let (n, span) = (scene.n_dof(), saved.span);
    if !(span.0.is_finite() && span.1.is_finite() && span.0 <= span.1) {
        let rule = "it must be finite with start <= end";
        return Err(refused("span", format!("{span:?}"), rule));
    }
    let (q, v) = &saved.last;
    if q.len() != n || v.len() != n {
        let found = format!("({},), ({},)", q.len(), v.len());
        let expected = format!("({n},), ({n},)");
        return Err(Error::bad_shape(
            "the last state of the saved trajectory",
            found,
            expected,
        ));
    }
    check_finite("the last state", q.iter().chain(v))?;
    check_times("an impact", span, saved.impacts.iter().map(|i| i.0))?;
    for &(_, stop, before, after, impulse, phase) in &saved.impacts {
        check_stop("an impact", stop, scene)?;
        check_finite("an impact", [before, after, impulse].iter())?;
        // Where there is no period there is no phase.
        if !scene.phase().is_nan() {
            check_finite("an impact", [phase].iter())?;
        }
        if before < 0.0 || after < 0.0 {
            let found = format!("with speeds {before}, {after}");
            return Err(refused("an impact", found, "they must not be negative"));
        }
    }
    for &(time, stop, depth) in &saved.grazes {
        check_stop("a graze", stop, scene)?;
        check_times("a graze", span, std::iter::once(time))?;
        check_finite("a graze", [depth].iter())?;
    }
    if let Some((times, q, v)) = &saved.samples {
        let expected = (times.len(), n);
        if q.shape() != expected || v.shape() != expected {
            let found = format!("{:?}, {:?}", q.shape(), v.shape());
            let argument = "the samples of the saved trajectory";
            return Err(Error::bad_shape(
                argument,
                found,
                format!("{expected:?} twice"),
            ));
        }
        check_times("a sample", span, times.iter().copied())?;
        check_finite("a sample", q.iter().chain(v.iter()))?;
    }
    for (_, _, segments, order) in saved.motion.iter().flatten() {
        if *order > MOST_ORDER {
            let rule = format!("it must be at most {MOST_ORDER}");
            return Err(refused("the order", order, &rule));
        }
        for (name, stops, _) in segments {
            let kind = SegmentKind::from_name(name)?;
            let Some(regime) = kind.read(stops) else {
                let rule = format!("they are not those of a {name}");
                return Err(refused("a segment", format!("with stops {stops:?}"), &rule));
            };
            regime
                .elements()
                .try_for_each(|stop| check_stop("a segment", stop, scene))?;
        }
    }
    Ok(())
}

/// The chapters of a run divide its span and its impacts, as its ramps do.
pub(super) fn check_chapters(
    span: (f64, f64),
    chapters: &[(f64, f64, usize)],
    n_impacts: usize,
    schedule: Option<&Schedule>,
) -> Result<()> {
    let begins = |k: usize| match schedule {
        Some(schedule) => schedule.chapters.get(k).map(|own| own.span.0),
        None => (k == 0).then_some(span.0),
    };
    let follow = chapters
        .windows(2)
        .all(|pair| pair[0].1 == pair[1].0 && pair[0].2 <= pair[1].2);
    let is_begun = |(k, own): (usize, &(f64, f64, usize))| begins(k) == Some(own.0);
    let ends = chapters.last().map(|last| (last.1, last.2 <= n_impacts));
    let is_whole =
        follow && chapters.iter().enumerate().all(is_begun) && ends == Some((span.1, true));
    if is_whole && chapters[0].2 == 0 {
        return Ok(());
    }
    let rule = "they must divide its span and its impacts as its ramps do";
    Err(refused("the chapters", format!("{chapters:?}"), rule))
}

/// The pieces of a motion follow each other in time from the start of a run to its end, and its segments divide them.
pub(super) fn check_arcs(kept: &PathParts, (start, end): (f64, f64)) -> Result<()> {
    let (pieces, segments) = (&kept.arcs, &kept.segments);
    let starts_of_segments: Vec<usize> = segments.iter().map(|s| s.first).collect();
    if pieces.is_empty()
        || starts_of_segments.first() != Some(&0)
        || !starts_of_segments.is_sorted()
        || starts_of_segments
            .last()
            .is_some_and(|&last| last > pieces.len())
    {
        let found = format!("from pieces {starts_of_segments:?}");
        let rule = format!("they must divide {} pieces", pieces.len());
        return Err(refused("segments", found, &rule));
    }
    let slack = TIME_TOL * start.abs().max(end.abs());
    let mut last = start;
    let rounding = 4.0 * f64::EPSILON * start.abs().max(end.abs());
    for PathArc { clock, span } in pieces {
        let [begins, rest] = clock.reading();
        let is_rounding = rest.abs() <= rounding;
        if !is_rounding {
            let rule = "it must be what rounding takes from a time";
            return Err(refused("a rest of a time", rest, rule));
        }
        // A span or a time that is no number breaks these too.
        let follows = (begins - last).abs() <= slack && *span >= 0.0 && span.is_finite();
        if !follows {
            let found = format!("from t = {begins} for {span}");
            let rule = format!("it must go on from t = {last}");
            return Err(refused("a piece", found, &rule));
        }
        last = clock.after(*span).time();
    }
    if (last - end).abs() <= slack {
        return Ok(());
    }
    let rule = format!("they must reach t = {end}");
    Err(refused("pieces", format!("up to t = {last}"), &rule))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Kind, PaperOptions, paper_scene};
    use crate::simulate::{Keep, SimulateOptions, Trajectory, simulate};
    use nalgebra::dvector;

    fn run(keep: Keep, linear: bool) -> Trajectory {
        let options = PaperOptions {
            linear,
            clearance: Some(0.05),
            ..Default::default()
        };
        let scene = paper_scene(Kind::Three, &options).expect("valid");
        let (q0, v0) = (dvector![0.0, 0.0], dvector![0.0, 0.1]);
        let options = SimulateOptions {
            keep,
            ..Default::default()
        };
        simulate(&scene, &q0, &v0, (0.0, 60.0), &options).expect("a run")
    }

    #[test]
    fn what_a_run_leaves_comes_back_and_the_run_goes_on_from_there() {
        for (keep, linear) in [
            (Keep::Motion, true),
            (Keep::Motion, false),
            (Keep::Impacts, false),
            (Keep::Final, true),
            (Keep::Final, false),
        ] {
            let run = run(keep, linear);
            let again = Trajectory::restore(run.scene(), run.save()).expect("its own numbers");
            // By their texts: the loss of an impact that is kept alone is no number.
            assert_eq!(format!("{:?}", again.save()), format!("{:?}", run.save()));
            assert_eq!(again.t_end(), 60.0);
        }
    }

    #[test]
    fn numbers_that_no_run_leaves_are_refused() {
        let run = run(Keep::Motion, true);
        let spoilt = |spoil: &dyn Fn(&mut SavedTrajectory)| {
            let mut saved = run.save();
            spoil(&mut saved);
            Trajectory::restore(run.scene(), saved)
        };
        assert!(spoilt(&|_| {}).is_ok());
        let spoils: [&dyn Fn(&mut SavedTrajectory); 12] = [
            &|s| s.span.1 = f64::NAN,
            &|s| s.span.1 *= 0.5,
            &|s| s.last.0.clear(),
            &|s| s.impacts[0].1 = 7,
            &|s| s.impacts.reverse(),
            &|s| s.impacts[0].2 = -1.0,
            &|s| s.motion.as_mut().expect("kept")[0].0.clear(),
            &|s| s.motion.as_mut().expect("kept")[0].0.swap(0, 1),
            &|s| s.motion.as_mut().expect("kept")[0].1[0] = f64::INFINITY,
            &|s| s.motion.as_mut().expect("kept")[0].2[0].2 = 1,
            &|s| s.motion.as_mut().expect("kept")[0].2[0].1.push(0),
            &|s| s.motion.as_mut().expect("kept")[0].3 = usize::MAX,
        ];
        for (k, spoil) in spoils.iter().enumerate() {
            assert!(spoilt(*spoil).is_err(), "{k}");
        }
    }
}
