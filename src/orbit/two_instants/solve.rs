//! Orbits with two instants of impact in a period (theory 5): from a problem, through the search for the
//! flight time between the instants, to the solutions and what was proved of the other flight times.

use crate::error::{Error, Result};
use crate::flow::{ModalScene, along};
use crate::impact::wrapped;
use crate::law::Stage;
use crate::linalg::rank;
use crate::modal::ModalState;
use crate::observer::Observer;
use crate::orbit::one_instant::periodic_conditions::PeriodicConditions;
use crate::orbit::one_instant::refine::settle_speeds;
use crate::orbit::orbit_data::{OrbitArc, OrbitData};
use crate::orbit::problem::Problem;
use crate::orbit::solutions::Solutions;
use crate::orbit::two_instants::conditions::TwoInstantConditions;
use crate::orbit::two_instants::flight_time::FlightTimeSearch;
use crate::orbit::two_instants::unseen::Unseen;
use crate::tolerance::DEPENDENT;
use nalgebra::DVector;

/// Unknowns whose determinants are still expanded: two impulses and four resonant modes. [work]
const MOST_UNKNOWNS: usize = 12;

/// Every solution whose pattern has two instants.
pub(crate) fn two_instants(problem: &Problem<'_>, observer: &mut Observer) -> Result<Solutions> {
    let &Problem {
        ref modal,
        pattern,
        options,
        period,
        ..
    } = problem;
    let [first, second] = pattern.instants() else {
        return Err(Error::bad_value(
            "pattern",
            format!("{pattern:?}"),
            "two instants are needed here",
        ));
    };
    let stops = [first.as_slice(), second.as_slice()].concat();
    let pair = common_stop(first, second);
    if let (Some(phase), None) = (options.phase, pair) {
        let rule = "with two different stops the flight time would be one unknown too many; leave the phase free, or \
                    give a pattern that hits one stop at both instants";
        return Err(Error::bad_value("phase", phase, rule));
    }
    for set in [first, second] {
        let normals = modal.geometry.normals.select_columns(set);
        let none = DVector::zeros(normals.nrows());
        let dependence = rank::solve(&normals, &none, DEPENDENT * normals.amax())?.null_space;
        if dependence.ncols() > 0 {
            let rule = "stops with dependent normals are one impact: name one of them at each of two instants";
            return Err(Error::bad_value("pattern", format!("{set:?}"), rule));
        }
    }
    let mut instant = PeriodicConditions::new(modal, &stops, period);
    let unseen = Unseen::set_aside(&mut instant);
    let instant = instant;
    if instant.n_inner() + 2 > MOST_UNKNOWNS {
        let rule = "the search in the flight time keeps at most four undamped modes in step with the period; damp them";
        return Err(Error::bad_value(
            "scene",
            format!("of {} unknowns", instant.n_inner() + 2),
            rule,
        ));
    }
    let conditions = TwoInstantConditions::new(&instant, first.len());
    let mut sets = [first.clone(), second.clone()];
    for set in &mut sets {
        set.sort_unstable();
    }
    let search = FlightTimeSearch {
        conditions: &conditions,
        period,
        is_alike: sets[0] == sets[1],
        n_periods: options.n_periods,
        phase: options.phase.map(|phase| [phase.cos(), phase.sin()]),
        pair: pair.unwrap_or((0, first.len())),
    };
    let (roots, mut reason) = search.run(observer)?;
    let mut all = Vec::with_capacity(roots.len());
    for root in &roots {
        let (impulses, u) = conditions.read(&root.x);
        let phase = options
            .phase
            .map_or_else(|| wrapped(u[1].atan2(u[0])), wrapped);
        let mut states = conditions.states(root.dt, &root.x);
        if !unseen.fill([phase.cos(), phase.sin()], root.dt, &mut states)? {
            continue;
        }
        let times = (root.dt, period);
        let flights = flights(modal, &stops, first.len(), &impulses, states, times)?;
        let clearances = match options.phase {
            Some(_) => contacts(modal, (&stops, first.len()), &flights),
            None => Vec::new(),
        };
        all.push(OrbitData {
            pattern: pattern.clone(),
            n_periods: options.n_periods,
            phase,
            flights,
            impulses,
            clearances,
        });
    }
    if all.len() < roots.len() {
        reason.push_str(
            "; none of them repeats as a whole: a mode that these stops do not see is in resonance with the forcing, or has \
             nothing to rest on under its load",
        );
    }
    let basis = unseen.basis()?;
    Ok(Solutions {
        all,
        reason,
        margin: None,
        family: (basis.ncols() > 0).then_some(basis),
    })
}

/// The clearances at which two flights meet the stops of their instants, of which the first few are hit first.
fn contacts(
    modal: &ModalScene,
    (stops, first): (&[usize], usize),
    flights: &[OrbitArc],
) -> Vec<(usize, f64)> {
    let contact = |(i, &stop): (usize, &usize)| {
        let state = &flights[usize::from(i >= first)].after;
        (stop, along(&modal.position_rows[stop], state))
    };
    stops.iter().enumerate().map(contact).collect()
}

/// Where a stop of both instants stands in their joint list.
fn common_stop(first: &[usize], second: &[usize]) -> Option<(usize, usize)> {
    let both = |(i, stop): (usize, &usize)| {
        Some((i, first.len() + second.iter().position(|s| s == stop)?))
    };
    first.iter().enumerate().find_map(both)
}

/// The two flights from the states after the instants.
fn flights(
    scene: &ModalScene,
    stops: &[usize],
    first: usize,
    impulses: &[f64],
    [mut after, mut later]: [ModalState; 2],
    (dt, period): (f64, f64),
) -> Result<Vec<OrbitArc>> {
    // The search for two instants takes no stops that move.
    let rest = vec![0.0; stops.len()];
    let (one, other) = (&rest[..first], &rest[first..]);
    settle_speeds(
        scene,
        (&stops[..first], one),
        &impulses[..first],
        &mut after,
    )?;
    settle_speeds(
        scene,
        (&stops[first..], other),
        &impulses[first..],
        &mut later,
    )?;
    let before = |after: &ModalState, which: std::ops::Range<usize>| {
        let mut state = after.clone();
        for b in which {
            for (z, jump) in state.iter_mut().zip(&scene.jumps[stops[b]]) {
                *z = [z[0] + jump[0] * impulses[b], z[1] + jump[1] * impulses[b]];
            }
        }
        state
    };
    let (before_first, before_later) =
        (before(&after, 0..first), before(&later, first..stops.len()));
    Ok(vec![
        OrbitArc::over(
            Stage::impact(&stops[..first]),
            [0.0, dt],
            [after, before_later],
        ),
        OrbitArc::over(
            Stage::impact(&stops[first..]),
            [dt, period - dt],
            [later, before_first],
        ),
    ])
}
