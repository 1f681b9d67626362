//! The list of attractors from the outcomes of seeds: motions on one attractor (`same_attractor.rs`) form a group. Where the states of two
//! sets do not tell whether they are one, their motions are carried on.
//!
//! States are rows (q, v) in units of the scene. Source: docs/theory.md, sections 15 and 17.

use crate::attractor::at_phase::strobed;
use crate::attractor::finding::{AttractorSearch, SeedOutcome};
use crate::attractor::kind::AttractorKind;
use crate::attractor::list::Attractors;
use crate::attractor::record::Attractor;
use crate::attractor::same_attractor::are_one;
use crate::error::Result;
use crate::model::PhysicalState;
use crate::recurrence::{Sets, comes_back, compared, repeats_after};
use crate::simulate::Keep;
use crate::tolerance::{MOST_SET_DOUBLINGS, ORBIT_CHECK_STATES, SET_DOUBLINGS_APART, SET_STATES};
use nalgebra::DMatrix;

/// Motions that have settled on one attractor.
struct Group {
    /// The indices of their seeds.
    members: Vec<usize>,
    one: Attractor,
    /// Its states, one in each period, shape `(p, 2n)`: its points, and more once the motion was carried on.
    states: DMatrix<f64>,
}

/// The attractors among the outcomes of seeds, the one that most seeds led to first.
pub(super) fn gathered(search: &AttractorSearch<'_>, found: &[SeedOutcome]) -> Result<Attractors> {
    let measure = search.measure();
    let mut groups: Vec<Group> = Vec::new();
    for (i, own) in found.iter().enumerate() {
        if let SeedOutcome::Attractor(own) = own {
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
    let mut groups = merged(search, groups)?;
    for (i, own) in found.iter().enumerate() {
        // Its own exponents leave it undecided; those of another motion on the same set decide.
        if let SeedOutcome::Unclear(states) = own {
            let is_on = |group: &&mut Group| {
                let of_group = (&group.states, group.one.is_cycle());
                are_one(of_group, (states, false), &measure)
            };
            if let Some(group) = groups.iter_mut().find(is_on) {
                group.members.push(i);
            }
        }
    }
    groups.sort_by_key(|group| std::cmp::Reverse(group.members.len()));
    Ok(listed(groups, found))
}

/// The index of the group that an attractor belongs to.
fn place(search: &AttractorSearch<'_>, groups: &[Group], own: &Attractor) -> Result<Option<usize>> {
    for (k, group) in groups.iter().enumerate() {
        if search.are_one((&group.one, &group.states), (own, &own.points))? {
            return Ok(Some(k));
        }
    }
    Ok(None)
}

/// The attractor that represents a group: a periodic one if there is one, since of motions on one set all repeat themselves once one has
/// come to rest on a stop; else one of the kind that most members are of.
fn standing(group: &Group, found: &[SeedOutcome]) -> Attractor {
    let members = || {
        group.members.iter().filter_map(|&i| match &found[i] {
            SeedOutcome::Attractor(own) => Some(own),
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

/// Merges groups whose sets are one by the states of motions that are carried on; the largest group first. A motion that leaves its set
/// while it is carried on was on a transient: it joins the group of the attractor that it settles on then.
fn merged(search: &AttractorSearch<'_>, mut groups: Vec<Group>) -> Result<Vec<Group>> {
    groups.sort_by_key(|group| std::cmp::Reverse(group.members.len()));
    let (mut kept, sets): (Vec<Group>, Vec<Group>) =
        groups.into_iter().partition(|group| group.one.is_cycle());
    let mut left = Vec::new();
    'sets: for mut own in sets {
        if !carry_on(search, &mut own.states, SET_STATES << SET_DOUBLINGS_APART)? {
            settle_again(search, &mut kept, own)?;
            continue;
        }
        let mut k = 0;
        while k < kept.len() {
            let other = &mut kept[k];
            if other.one.is_cycle() {
                k += 1;
                continue;
            }
            match carried_on_and_compared(search, other, &mut own)? {
                Relation::One => {
                    other.members.append(&mut own.members);
                    if own.one.kind == AttractorKind::Periodic {
                        other.one = own.one;
                    }
                    continue 'sets;
                }
                Relation::Apart => k += 1,
                Relation::OtherLeft => left.push(kept.remove(k)),
                Relation::Left => {
                    settle_again(search, &mut kept, own)?;
                    continue 'sets;
                }
            }
        }
        kept.push(own);
    }
    for other in left {
        settle_again(search, &mut kept, other)?;
    }
    Ok(kept)
}

/// How a set is related to another.
enum Relation {
    One,
    Apart,
    /// Its motion has left it, or the other's its own.
    Left,
    OtherLeft,
}

/// Carries two motions on, to twice as many states each time, until their states tell whether their sets are one.
fn carried_on_and_compared(
    search: &AttractorSearch<'_>,
    other: &mut Group,
    own: &mut Group,
) -> Result<Relation> {
    let measure = search.measure();
    let mut relation = Relation::Apart;
    for doubled in 0..=MOST_SET_DOUBLINGS {
        let count = SET_STATES << doubled;
        if !carry_on(search, &mut own.states, count)? {
            return Ok(Relation::Left);
        }
        if !carry_on(search, &mut other.states, count)? {
            return Ok(Relation::OtherLeft);
        }
        relation = match compared(&own.states, &other.states, &measure) {
            Sets::One => return Ok(Relation::One),
            Sets::Apart => Relation::Apart,
            // Sets that no number of states tells apart count as one.
            Sets::Unclear => Relation::One,
        };
        // Each motion has gone through all of its set, as far as its own states tell.
        let are_whole = || {
            [&own, &other]
                .iter()
                .all(|one| comes_back(&one.states, &measure))
        };
        if matches!(relation, Relation::Apart) && doubled >= SET_DOUBLINGS_APART && are_whole() {
            break;
        }
    }
    Ok(relation)
}

/// Carries a motion on until it has so many states; whether it is still on a set, having neither ended nor come to an orbit.
fn carry_on(search: &AttractorSearch<'_>, states: &mut DMatrix<f64>, count: usize) -> Result<bool> {
    let had = states.nrows();
    if had >= count {
        return Ok(true);
    }
    let time = |periods: usize| search.start + search.period * periods as f64;
    let more = count - had;
    let options = search.options.run(Keep::Final);
    let times = (time(0), time(1), more);
    let Some(found) = strobed(search.scene, &last_of(states), times, &options)? else {
        return Ok(false);
    };
    let mut longer = std::mem::replace(states, DMatrix::zeros(0, 0)).resize_vertically(count, 0.0);
    longer.rows_mut(had, more).copy_from(&found);
    *states = search.around.within_turns(longer);
    let end = states
        .rows_range(count.saturating_sub(ORBIT_CHECK_STATES)..)
        .into_owned();
    Ok(repeats_after(&end, &search.measure(), ORBIT_CHECK_STATES / 3) == 0)
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

/// Puts the members of a group whose motion has left its set into the group of the attractor that it settles on.
fn settle_again(search: &AttractorSearch<'_>, groups: &mut Vec<Group>, left: Group) -> Result<()> {
    if let SeedOutcome::Attractor(own) = search.settle(&last_of(&left.states))? {
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
fn listed(groups: Vec<Group>, found: &[SeedOutcome]) -> Attractors {
    let mut of_seed = vec![None; found.len()];
    for (place, group) in groups.iter().enumerate() {
        for &i in &group.members {
            of_seed[i] = Some(place);
        }
    }
    let count = |is_one: fn(&SeedOutcome) -> bool| found.iter().filter(|own| is_one(own)).count();
    let n_inside = count(|own| matches!(own, SeedOutcome::Inside));
    let (n_lost, n_drifting) = (
        count(|own| matches!(own, SeedOutcome::Lost)),
        count(|own| matches!(own, SeedOutcome::Drifting)),
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attractor::options::AttractorOptions;
    use crate::attractor::state_box::StateBox;
    use crate::model::{Harmonic, LinearSystem, Scene, Stop};
    use crate::orbit::Pattern;
    use nalgebra::{dmatrix, dvector};
    use std::f64::consts::TAU;

    /// A group of some seeds whose motion is taken to be chaotic, by its states.
    fn of_states(members: &[usize], states: DMatrix<f64>) -> Group {
        let one = Attractor {
            kind: AttractorKind::Chaotic,
            orbit: None,
            n_periods: 0,
            points: states.rows(0, SET_STATES).into_owned(),
            exponents: Vec::new(),
            pattern: Pattern::none(),
            reason: String::new(),
            fraction: 0.0,
        };
        let members = members.to_vec();
        Group {
            members,
            one,
            states,
        }
    }

    #[test]
    fn a_motion_that_leaves_its_set_beside_another_joins_where_it_settles() {
        let system =
            LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("a system");
        let force = Harmonic::new(dvector![1.0.into()], 2.4, 0.0).expect("a force");
        let stop = Stop::new(0, 100.0, 0.8).expect("a stop");
        let scene = Scene::new(system, force, [stop]).expect("a scene");
        let around =
            StateBox::new(dvector![-20.0, -20.0], dvector![20.0, 20.0]).expect("a state box");
        let options = AttractorOptions::default();
        let search = AttractorSearch {
            scene: &scene,
            around: &around,
            options: &options,
            period: scene.period().expect("a period"),
            start: 0.0,
            known: Vec::new(),
        };
        // The first decays to the orbit of the scene; the second, far from it, is known for as long as any is carried on.
        let decays = DMatrix::from_fn(SET_STATES << SET_DOUBLINGS_APART, 2, |k, j| {
            (-1e-3 * k as f64).exp() * [1.0, -1.0][j]
        });
        let circle = DMatrix::from_fn(SET_STATES << MOST_SET_DOUBLINGS, 2, |k, j| {
            let angle = TAU * 0.618_033_988_749_895 * k as f64;
            10.0 * [angle.cos(), angle.sin()][j]
        });
        let groups = vec![of_states(&[0, 1], decays), of_states(&[2], circle)];
        let found = merged(&search, groups).expect("it runs");
        let told = found
            .iter()
            .map(|group| (group.one.kind, group.members.as_slice()));
        assert_eq!(
            told.collect::<Vec<_>>(),
            [
                (AttractorKind::Chaotic, &[2][..]),
                (AttractorKind::Periodic, &[0, 1][..])
            ]
        );
    }
}
