//! Wrong numbers put into a right answer: the checks of what a run lists and counts must see each.

use crate::runs::case::Case;
use crate::runs::generator::scene;
use crate::runs::invariants::check;
use crate::runs::library::library;
use crate::runs::reference::{FEW, reference};
use vibroimpact::{Method, Motion, SavedTrajectory, SegmentKind, Trajectory};

/// The classes of what is found once an answer has been changed.
fn found(case: &Case, run: &Trajectory, change: &dyn Fn(&mut SavedTrajectory)) -> Vec<String> {
    let scene = case.scene().expect("a scene");
    let mut saved = run.save();
    change(&mut saved);
    let wrong = Trajectory::restore(&scene, saved).expect("fits");
    let found = check(case, &scene, &wrong, &reference(case, FEW));
    found.into_iter().map(|d| d.class).collect()
}

fn run_of(case: &Case) -> Option<Trajectory> {
    library(case, &case.scene().ok()?).ok()
}

/// The first scene of a seed, from a number on, whose run is of some kind.
fn first(from: u64, is: &dyn Fn(&Case, &Trajectory) -> bool) -> (Case, Trajectory) {
    let runs = (from..).map(|k| scene(7, k));
    let mut runs = runs.filter_map(|case| run_of(&case).map(|run| (case, run)));
    runs.find(|(case, run)| is(case, run))
        .expect("there is one")
}

#[test]
fn wrong_phases_and_counts_are_seen() {
    let (case, run) = first(0, &|case, run| {
        case.force.is_some() && run.impacts().len() > 3
    });
    assert!(found(&case, &run, &|_| {}).is_empty());
    let sees = |class: &str, change: &dyn Fn(&mut SavedTrajectory)| {
        let found = found(&case, &run, change);
        assert!(found.iter().any(|f| f == class), "{class}: {found:?}");
    };
    for by in [1e-12, -1e-12, 3.0] {
        sees("phase of an impact", &|s| s.impacts[2].5 += by);
    }
    sees("count of impacts", &|s| s.stats[4] += 1);
    sees("count of flights", &|s| s.stats[3] += 1);
    sees("count of flights", &|s| s.stats[3] -= 2);
    sees("count of steps", &|s| s.stats[1] += 1 + s.stats[0]);
    sees("count of gap evaluations", &|s| s.stats[2] = 1);
}

#[test]
fn wrong_grazes_are_seen() {
    let (case, run) = first(2000, &|case, run| {
        let is_far = |g: &vibroimpact::Graze| {
            case.stops[g.stop].clearance.abs() > 0.1 && g.depth.abs() < f64::EPSILON / 4.0
        };
        let is_free = (run.segments().expect("kept").iter()).all(|s| s.kind == SegmentKind::Flight);
        let grazes = run.grazes();
        case.has_real_modes() && is_free && grazes.iter().all(is_far) && grazes.len() > 3
    });
    let sees = |class: &str, change: &dyn Fn(&mut SavedTrajectory)| {
        let found = found(&case, &run, change);
        assert!(found.iter().any(|f| f == class), "{class}: {found:?}");
    };
    assert!(found(&case, &run, &|_| {}).is_empty());
    sees("graze against the motion", &|s| s.grazes[1].0 += 1e-2);
    sees("graze away from its stop", &|s| s.grazes[1].2 += 1e-13);
    sees("graze missed", &|s| s.grazes.truncate(1));
}

#[test]
fn impacts_are_no_grazes() {
    let (case, run) = first(0, &|case, run| {
        let mut impacts = run.impacts().iter();
        let is_fast = impacts.next().is_some_and(|i| i.departure > 0.3);
        let is_alone = impacts
            .next()
            .is_none_or(|i| i.time > run.impacts()[0].time + 1e-6);
        let is_exact = case.method == Method::Exact && case.span.0.abs() < 1e3;
        case.has_real_modes() && is_exact && is_fast && is_alone
    });
    let impact = run.impacts()[0];
    for (time, class) in [
        (impact.time, "graze at an impact"),
        (impact.time.next_up(), "graze that moves"),
    ] {
        let found = found(&case, &run, &|s| s.grazes.push((time, impact.stop, 0.0)));
        assert!(found.iter().any(|f| f == class), "{class}: {found:?}");
    }
}

#[test]
fn wrong_ends_of_accumulating_impacts_are_seen() {
    let is_long = |s: &vibroimpact::Segment| {
        s.kind == SegmentKind::Chatter && s.end - s.start > 1e-7 && s.start.abs() < 100.0
    };
    let (case, run) = first(0, &|_, run| {
        run.segments().is_ok_and(|all| all.iter().any(is_long))
    });
    assert!(found(&case, &run, &|_| {}).is_empty());
    // All later pieces begin as much later.
    let stretch = |s: &mut SavedTrajectory, by: f64| {
        let motion = &mut s.motion.as_mut().expect("kept")[0];
        let chatter = motion.2.iter().position(|part| part.0 == "chatter");
        let at = motion.2[chatter.expect("there is one")].2;
        let more = by * motion.0[at][2];
        motion.0[at][2] += more;
        for piece in &mut motion.0[at + 1..] {
            piece[0] += more;
        }
    };
    let late = found(&case, &run, &|s| stretch(s, 1e-4));
    assert!(
        late.iter().any(|f| f == "span of accumulating impacts"),
        "{late:?}"
    );
}
