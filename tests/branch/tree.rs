//! Trees of branches: each branch once, each with its parent, whatever is met on the way.

use crate::scenes::USUAL;
use std::ops::ControlFlow;
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    BranchTree, ContinuationParameter, Error, Harmonic, LinearSystem, OrbitOptions, Parameter,
    Pattern, PeriodicOrbit, Scene, SpecialKind, Stop, TreeOptions, branch_tree, periodic_orbits,
    with_observer,
};

const FORCE: ContinuationParameter<'_> = ContinuationParameter::Number(Parameter::ForcingScale);

fn grown(orbit: &PeriodicOrbit, range: (f64, f64), options: &TreeOptions) -> BranchTree {
    branch_tree((orbit, None), FORCE, range, options).expect("a tree")
}

#[test]
fn each_branch_stands_once_below_the_special_point_where_it_goes_off() {
    let orbit = &USUAL.orbits(1)[0];
    let tree = grown(orbit, (0.3, 1.2), &TreeOptions::default());
    assert_eq!(
        (tree.branches.len(), tree.parents[0]),
        (tree.parents.len(), None)
    );
    for (k, parent) in tree.parents.iter().enumerate().skip(1) {
        let (of, place) = parent.expect("a parent");
        assert!(of < k);
        let special = &tree.branches[of].special[place];
        // It begins beside that point.
        let branch = &tree.branches[k];
        let start = branch
            .arclength
            .iter()
            .position(|own| *own == 0.0)
            .expect("a start");
        assert!((branch.parameter[start] - special.parameter).abs() < 0.05);
    }
    // Over one value no two branches have one orbit: impacts at the same phases with the same speeds.
    for value in [0.45, 0.7, 0.95, 1.1] {
        let each = tree
            .branches
            .iter()
            .map(|own| own.at(FORCE, value).expect("orbits"));
        let all: Vec<PeriodicOrbit> = each.flatten().collect();
        let mark = |own: &PeriodicOrbit| {
            let impacts = own.impacts().iter();
            let mut marks: Vec<(i64, i64)> = impacts
                .map(|own| ((own.phase * 1e7) as i64, (own.approach * 1e7) as i64))
                .collect();
            marks.sort_unstable();
            (own.n_periods(), marks)
        };
        for (k, own) in all.iter().enumerate() {
            assert!(
                all[..k].iter().all(|other| mark(other) != mark(own)),
                "{value}"
            );
        }
    }
}

#[test]
fn depth_boundaries_and_number_are_bounded() {
    let orbit = &USUAL.orbits(1)[0];
    let alone = TreeOptions {
        depth: 0,
        ..TreeOptions::default()
    };
    assert_eq!(grown(orbit, (0.3, 1.2), &alone).branches.len(), 1);
    let smooth = TreeOptions {
        through: false,
        ..TreeOptions::default()
    };
    let tree = grown(orbit, (0.3, 1.2), &smooth);
    for (of, place) in tree.parents.iter().flatten() {
        assert!(!tree.branches[*of].special[*place].kind.is_boundary());
    }
    let two = TreeOptions {
        max_branches: 2,
        ..TreeOptions::default()
    };
    assert_eq!(grown(orbit, (0.3, 1.2), &two).branches.len(), 2);
    let none = TreeOptions {
        max_branches: 0,
        ..TreeOptions::default()
    };
    let refused = branch_tree((orbit, None), FORCE, (0.3, 1.2), &none);
    assert!(matches!(refused, Err(Error::BadValue { .. })));
    let stop = |_| ControlFlow::Break(());
    let grow = || branch_tree((orbit, None), FORCE, (0.3, 1.2), &smooth);
    let broken_off = with_observer(stop, grow);
    assert_eq!(broken_off.err(), Some(Error::Interrupted));
}

#[test]
fn of_two_mirror_images_one_is_followed() {
    // Two stops that are alike: at a pitchfork two motions are born, each the image of the other.
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], 0.6, 0.0).expect("valid");
    let stops = [1.0, -1.0].map(|side| Stop::new(dvector![side], 0.5, 0.7).expect("valid"));
    let scene = Scene::new(system, force, stops).expect("valid");
    let pattern = Pattern::new(vec![vec![0], vec![1]]).expect("valid");
    let orbits = periodic_orbits(&scene, &pattern, &OrbitOptions::default()).expect("a search");
    let is_own = |own: &&PeriodicOrbit| own.is_admissible() == Some(true);
    let orbit = orbits.iter().find(is_own).expect("an orbit");
    let frequency = ContinuationParameter::Number(Parameter::Frequency);
    let smooth = TreeOptions {
        through: false,
        depth: 1,
        ..TreeOptions::default()
    };
    let tree = branch_tree((orbit, None), frequency, (0.3, 1.5), &smooth).expect("a tree");
    let forks = tree.branches[0].special.iter();
    let forks = forks
        .filter(|own| own.kind == SpecialKind::Pitchfork)
        .count();
    let born = tree.parents.iter().flatten();
    let born = born
        .filter(|(of, place)| tree.branches[*of].special[*place].kind == SpecialKind::Pitchfork);
    assert!(forks > 0 && born.count() <= forks);
}
