//! The library's run of a scene, in a thread that is left behind if it never ends, and what it saw in the referee's form.

use crate::runs::case::Case;
use crate::runs::compare::Difference;
use crate::runs::double_double::{Dd, dot};
use crate::runs::motion::{Model, Motion};
use crate::runs::record::{Hit, Record, Stretch};
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};
use vibroimpact::Motion as _;
use vibroimpact::{ImpactSide, Scene, SegmentKind, Trajectory, simulate, with_observer};

/// After this time a run of the library counts as endless.
const PATIENCE: Duration = Duration::from_secs(5);

/// The library's run, in a thread that is left behind if it never ends.
pub fn library(case: &Case, scene: &Scene) -> Result<Trajectory, Difference> {
    let difference = |class: &str, detail: String| Difference {
        class: class.to_string(),
        detail,
    };
    let (sender, receiver) = channel();
    let (case, scene) = (case.clone(), scene.clone());
    std::thread::spawn(move || {
        let (q0, v0) = case.start();
        let began = Instant::now();
        let observer = move |_| {
            if began.elapsed() > PATIENCE {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let run = catch_unwind(AssertUnwindSafe(|| {
            let run = || simulate(&scene, &q0, &v0, case.span, &case.options());
            with_observer(observer, run)
        }));
        let _ = sender.send(run);
    });
    match receiver.recv_timeout(2 * PATIENCE) {
        Err(_) => Err(difference("endless, and asks nobody", String::new())),
        Ok(Err(panic)) => {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or(panic.downcast_ref::<&str>().map(ToString::to_string));
            Err(difference("panic", text.unwrap_or_default()))
        }
        Ok(Ok(Err(vibroimpact::Error::Interrupted))) => {
            Err(difference("endless", format!("more than {PATIENCE:?}")))
        }
        Ok(Ok(Err(error))) => Err(difference("error", error.to_string())),
        Ok(Ok(Ok(run))) => Ok(run),
    }
}

/// What the library saw, in the referee's form.
pub fn seen(case: &Case, run: &Trajectory, model: &Model) -> Record {
    let since = |t: f64| (Dd::from(t) - Dd::from(case.span.0)).to_f64();
    let segments = run.segments().expect("motion is kept");
    // The stops held just before a time: segments of one stretch follow each other.
    let held_before = |time: f64| {
        let later = segments.partition_point(|s| s.start < time);
        let last = segments[..later].last().map(|s| s.start);
        let of_last = segments[..later].iter().rev();
        let of_last = of_last.take_while(|s| Some(s.start) == last);
        let mut held: Vec<usize> = of_last
            .filter(|s| s.kind == SegmentKind::Stick)
            .filter_map(|s| s.stop)
            .collect();
        held.sort_unstable();
        held
    };
    let mut motions: HashMap<Vec<usize>, Option<Motion>> = HashMap::new();
    let mut curvature = |time: f64, stop: usize| {
        let held = held_before(time);
        let motion = motions
            .entry(held.clone())
            .or_insert_with(|| Motion::new(model, &held));
        let Ok((q, v)) = run.state(time, ImpactSide::Before) else {
            return f64::NAN;
        };
        let mut x: Vec<Dd> = q.iter().chain(v.iter()).map(|&x| Dd::from(x)).collect();
        x.extend(model.forcing_at(case, time));
        let acceleration = match motion {
            Some(motion) => motion.acceleration(&x),
            None => model.free.times(&x),
        };
        -dot(&model.stops[stop].normal, &acceleration).to_f64()
    };
    let hits = run
        .impacts()
        .iter()
        .map(|i| Hit {
            time: Dd::from(i.time) - Dd::from(case.span.0),
            stop: i.stop,
            approach: i.approach,
            departure: i.departure,
            impulse: i.impulse,
            curvature: curvature(i.time, i.stop),
            rounds: 1,
        })
        .collect();
    let of = |kind: SegmentKind| {
        segments
            .iter()
            .filter(|s| s.kind == kind)
            .map(|s| Stretch {
                stop: s.stop.unwrap_or(usize::MAX),
                start: since(s.start),
                end: since(s.end),
            })
            .collect()
    };
    Record {
        hits,
        chatters: of(SegmentKind::Chatter),
        sticks: of(SegmentKind::Stick),
        ..Record::default()
    }
}
