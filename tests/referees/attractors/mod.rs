//! A referee of attractors and basins: random scenes, whose lists and labels are held against long runs. Each attractor is listed once,
//! closes after its own period and after none that is shorter, and has every cell that leads there.

mod draw;
mod long_runs;

use crate::random::Cases;
use draw::{Case, case};
use long_runs::{Seen, comes_back, fill_one_set, is_on_cycle, is_on_set, seen};
use vibroimpact::{
    Attractor, AttractorKind, AttractorOptions, Attractors, BasinOptions, Label, basin_cells,
    find_attractors,
};

/// Periods that a set is carried on for, and a cell is followed for.
const CARRIED: usize = 4000;
const FOLLOWED: usize = 1500;
/// Periods that states are held against.
const HELD: usize = 150;
/// A part of a motion's size that is surely one state, and one that is surely two.
const ONE: f64 = 1e-4;

/// What has been compared, and what is wrong.
#[derive(Default)]
struct Tally {
    attractors: usize,
    sets: usize,
    transients: usize,
    cells: usize,
    undecided: usize,
    undecided_seeds: usize,
    faults: Vec<String>,
}

/// The long motion on an attractor: of a cycle some rounds, of a set thousands of periods.
fn carried(case: &Case, one: &Attractor) -> Option<Seen> {
    let last = one.points.row(one.points.nrows() - 1).transpose();
    let is_set = one.points.nrows() != one.n_periods;
    let periods = if is_set {
        CARRIED
    } else {
        HELD.max(2 * one.n_periods)
    };
    seen(&case.scene, &last, 1, periods)
}

fn check_list(found: &Attractors, long: &[Option<Seen>], tally: &mut Tally) {
    let mut faults = Vec::new();
    for (k, one) in found.all.iter().enumerate() {
        tally.attractors += 1;
        let repeats = matches!(one.kind, AttractorKind::Periodic | AttractorKind::Rest);
        if repeats != (one.n_periods > 0) {
            faults.push(format!("{k}: {:?} of {} periods", one.kind, one.n_periods));
        }
        let is_set = one.points.nrows() != one.n_periods;
        let Some(own) = &long[k] else {
            faults.push(format!("{k}: {:?} ends", one.kind));
            continue;
        };
        if is_set {
            tally.sets += 1;
            let end = Seen([0, 1, 2].map(|p| own.0[p].rows(CARRIED - HELD, HELD).into_owned()));
            tally.transients += usize::from(comes_back(&end, HELD / 3, 1e-6).is_some());
        } else if comes_back(own, one.n_periods, ONE) != Some(one.n_periods) {
            let back = comes_back(own, HELD / 2, ONE);
            faults.push(format!(
                "{k}: {} periods, comes back after {back:?}",
                one.n_periods
            ));
        }
        for (j, other) in long[..k].iter().enumerate() {
            let Some(other) = other else { continue };
            let other_is_set = found.all[j].points.nrows() != found.all[j].n_periods;
            let is_one = match (is_set, other_is_set) {
                (false, false) => is_on_cycle(own, other, ONE) && is_on_cycle(other, own, ONE),
                (true, true) => fill_one_set(own, other),
                _ => false,
            };
            if is_one {
                let [a, b] = [&found.all[j], one].map(|one| (one.kind, one.n_periods));
                faults.push(format!("{j} and {k} are one: {a:?}, {b:?}"));
            }
        }
    }
    tally.faults.append(&mut faults);
}

fn check_cells(case: &Case, found: &Attractors, long: &[Option<Seen>], tally: &mut Tally) {
    let options = BasinOptions::default();
    let phases = vec![0.0; case.cells.nrows()];
    let states = (&case.cells, phases.as_slice());
    let cells = basin_cells(&case.scene, &found.all, &case.around, states, &options);
    let cells = cells.expect("cells");
    for (i, label) in cells.labels.iter().enumerate() {
        if matches!(label, Label::Inside | Label::Lost) {
            continue;
        }
        tally.cells += 1;
        let row = case.cells.row(i).transpose();
        let Some(end) = seen(&case.scene, &row, FOLLOWED, HELD) else {
            continue;
        };
        let is_on = |k: usize| match &long[k] {
            Some(long) if found.all[k].points.nrows() == found.all[k].n_periods => {
                is_on_cycle(&end, long, 1e-3)
            }
            Some(long) => is_on_set(&end, long),
            None => true,
        };
        match label {
            Label::Attractor(k) if !is_on(*k) => {
                let other = (0..long.len()).find(|&j| is_on(j));
                tally
                    .faults
                    .push(format!("cell {i}: label {k}, ends on {other:?}"));
            }
            Label::Undecided => {
                tally.undecided += 1;
                // What is there long before the end is to be labelled.
                let on = (0..long.len()).find(|&k| is_on(k));
                if let Some(k) = on {
                    tally
                        .faults
                        .push(format!("cell {i}: undecided, but on {k}"));
                }
            }
            _ => {}
        }
    }
}

#[test]
fn each_attractor_is_listed_once_and_has_its_cells() {
    let cases = Cases::new(1, 8);
    let mut all = Tally::default();
    for (number, mut random) in cases.each() {
        let case = case(&mut random, (16, 25));
        let options = AttractorOptions {
            max_periods: 1000,
            ..AttractorOptions::default()
        };
        let found = find_attractors(&case.scene, &case.around, &case.seeds, &options);
        let found = found.expect("attractors");
        all.undecided_seeds += found.n_undecided;
        let long: Vec<_> = found.all.iter().map(|one| carried(&case, one)).collect();
        let before = all.faults.len();
        check_list(&found, &long, &mut all);
        check_cells(&case, &found, &long, &mut all);
        for fault in &mut all.faults[before..] {
            *fault = format!("case {number}: {fault}");
            println!("{fault}");
        }
        if cases.is_one() {
            println!("{:#?}\n{:?}", case.scene, found);
        }
    }
    println!(
        "{} attractors, {} sets, {} of them transients; {} cells, {} undecided; {} seeds undecided",
        all.attractors, all.sets, all.transients, all.cells, all.undecided, all.undecided_seeds
    );
    crate::soak::note(
        "attractors",
        cases.seed,
        all.attractors + all.cells,
        all.faults.len(),
    );
    assert!(
        all.faults.is_empty(),
        "seed {}: {:#?}",
        cases.seed,
        all.faults
    );
    // The referee says little where nothing is chaotic, or little decided.
    assert!(cases.have(all.sets, 13));
    assert!(cases.is_one() || 20 * all.undecided <= all.cells);
}
