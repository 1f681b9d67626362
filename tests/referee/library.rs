//! The library's run of a scene, in a thread that is left behind if it never ends, and what it saw in the referee's form.

use crate::case::Case;
use crate::compare::Difference;
use crate::double_double::{Dd, dot};
use crate::motion::Model;
use crate::record::{Hit, Record, Stretch};
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};
use vibroimpact::{ImpactSide, Scene, SegmentKind, Trajectory, simulate_checked};

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
        let mut observer = |_| {
            if began.elapsed() > PATIENCE {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let run = catch_unwind(AssertUnwindSafe(|| {
            simulate_checked(&scene, &q0, &v0, case.span, &case.options(), &mut observer)
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
    let curvature = |time: f64, stop: usize| {
        let Ok((q, v)) = run.state(time, ImpactSide::Before) else {
            return f64::NAN;
        };
        let mut x: Vec<Dd> = q.iter().chain(v.iter()).map(|&x| Dd::from(x)).collect();
        x.extend(model.forcing_at(case, time));
        -dot(&model.stops[stop].normal, &model.free.times(&x)).to_f64()
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
        let segments = run.segments().expect("motion is kept");
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
