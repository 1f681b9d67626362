//! What a run counts, against what it keeps.

use crate::runs::case::{Case, MOST_IMPACTS};
use crate::runs::compare::Difference;
use vibroimpact::{Method, Stats, Status, Trajectory};

/// Right-hand sides that a step of the Dormand-Prince pair takes, its first one left over from the step before.
const STAGES: usize = 6;

/// What is kept of a run, counted.
struct Kept {
    impacts: usize,
    /// Impacts before the last instant at which there was one.
    earlier: usize,
    instants: usize,
    /// Segments that are no end of accumulating impacts.
    flights: usize,
    /// Whether the first of them takes no time: then it may be the side before impacts at the start, which is no flight.
    is_first_short: bool,
    /// Pieces of any length, and those of some; of the latter those of flights.
    pieces: usize,
    steps: usize,
    flown: usize,
}

impl Kept {
    fn new(run: &Trajectory) -> Self {
        let mut times: Vec<f64> = run.impacts().iter().map(|i| i.time).collect();
        let last = times.last().copied();
        let earlier = times.iter().filter(|&&t| Some(t) != last).count();
        times.dedup();
        let [(pieces, _, segments, _)] = &run.save().motion.expect("motion is kept")[..] else {
            panic!("a run without ramps has one chapter")
        };
        let is_flight: Vec<bool> = segments.iter().map(|s| s.0 != "chatter").collect();
        let kind_of = |piece: usize| segments.partition_point(|s| s.2 <= piece) - 1;
        let is_step = |piece: &usize| pieces[*piece][2] > 0.0;
        let second = segments.get(1).map_or(pieces.len(), |s| s.2);
        Self {
            impacts: run.impacts().len(),
            earlier,
            instants: times.len(),
            flights: is_flight.iter().filter(|&&is| is).count(),
            is_first_short: !(0..second).any(|piece| is_step(&piece)),
            pieces: pieces.len(),
            steps: (0..pieces.len()).filter(is_step).count(),
            flown: (0..pieces.len())
                .filter(is_step)
                .filter(|&piece| is_flight[kind_of(piece)])
                .count(),
        }
    }
}

pub fn counts_are_those_of_what_is_kept(case: &Case, run: &Trajectory) -> Option<Difference> {
    let (stats, kept) = (run.stats(), Kept::new(run));
    let wrong = [
        wrong_impacts(stats, &kept, run.status()),
        wrong_flights(stats, &kept, run.status()),
        wrong_steps(stats, &kept, case.method),
        wrong_evaluations(stats, &kept, case),
    ];
    let wrong = wrong.into_iter().flatten().next()?;
    Some(Difference {
        class: format!("count of {wrong}"),
        detail: format!("{stats:?}, {}", run.message()),
    })
}

/// Each impact is a row. A run goes on while there are fewer than it may have: the last ones are those of one instant.
fn wrong_impacts(stats: Stats, kept: &Kept, status: Status) -> Option<&'static str> {
    let goes_with = match status {
        Status::Finished => kept.impacts < MOST_IMPACTS,
        Status::MaxImpacts => kept.impacts >= MOST_IMPACTS && kept.earlier < MOST_IMPACTS,
        _ => true,
    };
    (stats.n_impacts != kept.impacts || !goes_with).then_some("impacts")
}

/// Each flight, with or without stops held, is a segment.
fn wrong_flights(stats: Stats, kept: &Kept, status: Status) -> Option<&'static str> {
    // A run that ends before its span has the side after its last event, and where there was no end of events one more was begun.
    let (side, begun) = match status {
        Status::Finished => (0, 0),
        Status::MaxImpacts => (1, 0),
        _ => (1, 1),
    };
    let most = kept.flights.saturating_sub(side);
    let least = most.saturating_sub(usize::from(kept.is_first_short));
    (!(least..=most + begun).contains(&stats.n_flights)).then_some("flights")
}

/// Exact flights have no steps; each step of an integrator is a piece, and a piece of no length need not be a step.
fn wrong_steps(stats: Stats, kept: &Kept, method: Method) -> Option<&'static str> {
    let is_right = if method == Method::Exact {
        stats.n_steps == 0 && stats.n_rhs == 0
    } else {
        // An implicit step takes three rates for each iteration, the first of which may be the last.
        let stages = if method == Method::Radau { 3 } else { STAGES };
        (kept.steps..=kept.pieces).contains(&stats.n_steps) && stats.n_rhs > stages * stats.n_steps
    };
    (!is_right).then_some("steps")
}

/// Every gap is looked at where the run begins, at each contact, and at the end of each step of an integrator; none where there is no stop.
fn wrong_evaluations(stats: Stats, kept: &Kept, case: &Case) -> Option<&'static str> {
    let looks = 1 + case.by_method(kept.instants, kept.flown.max(kept.instants));
    let is_right = if case.stops.is_empty() {
        stats.n_gap_evaluations == 0
    } else {
        stats.n_gap_evaluations >= looks * case.stops.len()
    };
    (!is_right).then_some("gap evaluations")
}
