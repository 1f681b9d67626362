//! Which motions have settled on one attractor, and the list of all.

use crate::attractor::finding::{Found, Search};
use crate::attractor::kind::AttractorKind;
use crate::attractor::list::Attractors;
use crate::attractor::one::Attractor;
use crate::attractor::unsettled::KEPT;
use crate::error::Result;
use crate::model::PhysicalState;
use crate::observer::ObserverFn;
use crate::recurrence::{Sets, comes_back, compared, repeats_after};
use crate::simulate::{Keep, SimulateOptions, Status, simulate_observed};
use nalgebra::DMatrix;

/// How often motions are carried on to twice as many states, where these do not tell whether their sets are one, and how often at least
/// where they seem to be two and each has come back to where it was: a motion may visit some parts of its set rarely.
const DOUBLED: usize = 5;
const DOUBLED_APART: usize = 2;
/// States at the end of a motion that is carried on by which it is told whether it has come to an orbit.
const LAST: usize = 1504;

/// Motions that have settled on one attractor.
struct Group {
    /// Their numbers.
    members: Vec<usize>,
    one: Attractor,
    /// Its points, and more where it was carried on.
    states: DMatrix<f64>,
}

/// The attractors among what starts have settled on, the one that most starts led to first.
pub(super) fn gathered(
    search: &Search<'_>,
    found: &[Found],
    go_on: ObserverFn<'_>,
) -> Result<Attractors> {
    let measure = search.measure();
    let mut groups: Vec<Group> = Vec::new();
    for (i, own) in found.iter().enumerate() {
        if let Found::Attractor(own) = own {
            match place(search, &groups, own)? {
                Some(k) => groups[k].members.push(i),
                None => groups.push(Group {
                    members: vec![i],
                    one: (**own).clone(),
                    states: own.points.clone(),
                }),
            }
        }
    }
    for group in &mut groups {
        group.one = standing(group, found);
    }
    let mut groups = merged(search, groups, go_on)?;
    for (i, own) in found.iter().enumerate() {
        // Its exponents alone do not say what it is; another's on the same set do.
        if let Found::Unclear(states) = own {
            let is_on = |group: &&mut Group| {
                !group.one.is_cycle() && compared(&group.states, states, &measure) == Sets::One
            };
            if let Some(group) = groups.iter_mut().find(is_on) {
                group.members.push(i);
            }
        }
    }
    groups.sort_by_key(|group| std::cmp::Reverse(group.members.len()));
    Ok(listed(groups, found))
}

/// The group that an attractor belongs to.
fn place(search: &Search<'_>, groups: &[Group], own: &Attractor) -> Result<Option<usize>> {
    for (k, group) in groups.iter().enumerate() {
        let is_one = match (group.one.is_cycle(), own.is_cycle()) {
            (true, true) => search.are_one_cycle(&group.one, own)?,
            (false, false) => compared(&group.states, &own.points, &search.measure()) == Sets::One,
            _ => false,
        };
        if is_one {
            return Ok(Some(k));
        }
    }
    Ok(None)
}

/// The one that stands for a group: of a set on which some start has come to rest on a stop, that one, since all repeat themselves
/// however long they have not; else one of the kind that most are of.
fn standing(group: &Group, found: &[Found]) -> Attractor {
    let members = || {
        group.members.iter().filter_map(|&i| match &found[i] {
            Found::Attractor(own) => Some(own),
            _ => None,
        })
    };
    let count = |kind: AttractorKind| members().filter(|own| own.kind == kind).count();
    let first = |kind: AttractorKind| members().find(|own| own.kind == kind);
    let of_most = if count(AttractorKind::Torus) > count(AttractorKind::Chaotic) {
        AttractorKind::Torus
    } else {
        AttractorKind::Chaotic
    };
    let own = first(AttractorKind::Periodic).or_else(|| first(of_most));
    own.map_or_else(|| group.one.clone(), |own| (**own).clone())
}

/// Groups of sets that are one, as far as their motions, carried on, tell; the largest first. A motion that leaves its set on the way
/// was on none: it counts where it settles then.
fn merged(
    search: &Search<'_>,
    mut groups: Vec<Group>,
    go_on: ObserverFn<'_>,
) -> Result<Vec<Group>> {
    groups.sort_by_key(|group| std::cmp::Reverse(group.members.len()));
    let (mut kept, sets): (Vec<Group>, Vec<Group>) =
        groups.into_iter().partition(|group| group.one.is_cycle());
    'sets: for mut own in sets {
        if !carry_on(search, &mut own.states, KEPT << DOUBLED_APART, go_on)? {
            settle_again(search, &mut kept, own, go_on)?;
            continue;
        }
        for other in kept.iter_mut().filter(|other| !other.one.is_cycle()) {
            match carried_on_and_compared(search, other, &mut own, go_on)? {
                Relation::One => {
                    other.members.append(&mut own.members);
                    if own.one.kind == AttractorKind::Periodic {
                        other.one = own.one;
                    }
                    continue 'sets;
                }
                Relation::Apart => {}
                Relation::Left => {
                    settle_again(search, &mut kept, own, go_on)?;
                    continue 'sets;
                }
            }
        }
        kept.push(own);
    }
    Ok(kept)
}

/// How a set is related to another.
enum Relation {
    One,
    Apart,
    /// Its motion has left it.
    Left,
}

fn carried_on_and_compared(
    search: &Search<'_>,
    other: &mut Group,
    own: &mut Group,
    go_on: ObserverFn<'_>,
) -> Result<Relation> {
    let measure = search.measure();
    let mut relation = Relation::Apart;
    for doubled in 0..=DOUBLED {
        let count = KEPT << doubled;
        if !carry_on(search, &mut own.states, count, go_on)? {
            return Ok(Relation::Left);
        }
        if !carry_on(search, &mut other.states, count, go_on)? {
            return Ok(Relation::Apart);
        }
        relation = match compared(&own.states, &other.states, &measure) {
            Sets::One => return Ok(Relation::One),
            Sets::Apart => Relation::Apart,
            // What is not two in the end is one.
            Sets::Unclear => Relation::One,
        };
        let are_whole = || {
            [&own, &other]
                .iter()
                .all(|one| comes_back(&one.states, &measure))
        };
        if matches!(relation, Relation::Apart) && doubled >= DOUBLED_APART && are_whole() {
            break;
        }
    }
    Ok(relation)
}

/// Carries a motion on until so many of its states are had; whether it has not come to its end or to an orbit on the way.
fn carry_on(
    search: &Search<'_>,
    states: &mut DMatrix<f64>,
    count: usize,
    go_on: ObserverFn<'_>,
) -> Result<bool> {
    let had = states.nrows();
    if had >= count {
        return Ok(true);
    }
    let time = |periods: usize| search.start + search.period * periods as f64;
    let more = count - had;
    let sampled = SimulateOptions {
        t_eval: Some((1..=more).map(time).collect()),
        ..search.options.run(Keep::Final)
    };
    let (q, v) = last_of(states);
    let span = (time(0), time(more));
    let run = simulate_observed(search.scene, &q, &v, span, &sampled, &mut |_| go_on())?;
    if run.status() != Status::Finished {
        return Ok(false);
    }
    let (_, q, v) = run.samples()?;
    let n = q.ncols();
    let mut longer = std::mem::replace(states, DMatrix::zeros(0, 0)).resize_vertically(count, 0.0);
    longer.view_mut((had, 0), (more, n)).copy_from(&q);
    longer.view_mut((had, n), (more, n)).copy_from(&v);
    *states = search.around.within_turns(longer);
    let end = states.rows_range(count.saturating_sub(LAST)..).into_owned();
    Ok(repeats_after(&end, &search.measure(), LAST / 3) == 0)
}

/// The last of some states.
fn last_of(states: &DMatrix<f64>) -> PhysicalState {
    let (last, n) = (states.nrows() - 1, states.ncols() / 2);
    let part = |first: usize| {
        states
            .view((last, first), (1, n))
            .transpose()
            .column(0)
            .into_owned()
    };
    (part(0), part(n))
}

/// Puts those whose motion has left its set to where it settles.
fn settle_again(
    search: &Search<'_>,
    groups: &mut Vec<Group>,
    left: Group,
    go_on: ObserverFn<'_>,
) -> Result<()> {
    if let Found::Attractor(own) = search.settle(&last_of(&left.states), go_on)? {
        match place(search, groups, &own)? {
            Some(k) => groups[k].members.extend(left.members),
            None => groups.push(Group {
                states: own.points.clone(),
                one: *own,
                ..left
            }),
        }
    }
    Ok(())
}

/// The list of all.
fn listed(groups: Vec<Group>, found: &[Found]) -> Attractors {
    let mut of_seed = vec![None; found.len()];
    for (place, group) in groups.iter().enumerate() {
        for &i in &group.members {
            of_seed[i] = Some(place);
        }
    }
    let count = |is_one: fn(&Found) -> bool| found.iter().filter(|own| is_one(own)).count();
    let n_inside = count(|own| matches!(own, Found::Inside));
    let (n_lost, n_drifting) = (
        count(|own| matches!(own, Found::Lost)),
        count(|own| matches!(own, Found::Drifting)),
    );
    let decided = of_seed.iter().flatten().count();
    let outside = (found.len() - n_inside) as f64;
    let one = |group: Group| Attractor {
        fraction: group.members.len() as f64 / outside,
        ..group.one
    };
    Attractors {
        all: groups.into_iter().map(one).collect(),
        of_seed,
        n_undecided: found.len() - decided - n_lost - n_drifting - n_inside,
        n_lost,
        n_drifting,
        n_inside,
    }
}
