//! Trees of branches: each branch once, each with its parent, whatever is met on the way.

use crate::scenes::USUAL;
use std::ops::ControlFlow;
use vibroimpact::nalgebra::{dmatrix, dvector};
use vibroimpact::{
    BranchTree, ContinuationParameter, Error, Harmonic, LinearSystem, OrbitOptions, Parameter,
    Pattern, PeriodicOrbit, Scene, Side, Special, SpecialKind, Stop, TreeOptions, branch_tree,
    periodic_orbits, with_observer,
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
    // Two stops that are alike: at each pitchfork two motions are born, one the image of the other.
    let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0]).expect("valid");
    let force = Harmonic::new(dvector![1.0.into()], 1.2, 0.0).expect("valid");
    let stops = [Side::Upper, Side::Lower];
    let stops = stops.map(|side| Stop::new(0, 0.5, 0.7).expect("valid").on_side(side));
    let scene = Scene::new(system, force, stops).expect("valid");
    let pattern = Pattern::new(vec![vec![0], vec![1]]).expect("valid");
    let orbits = periodic_orbits(&scene, &pattern, &OrbitOptions::default()).expect("a search");
    let is_own = |own: &&PeriodicOrbit| own.is_admissible() == Some(true);
    let orbit = orbits.iter().find(is_own).expect("an orbit");
    let frequency = ContinuationParameter::Number(Parameter::Frequency);
    let smooth = TreeOptions {
        through: false,
        ..TreeOptions::default()
    };
    let tree = branch_tree((orbit, None), frequency, (0.9, 1.8), &smooth).expect("a tree");
    let is_fork = |own: &&Special| own.kind == SpecialKind::Pitchfork;
    let forks = tree.branches[0].special.iter().filter(is_fork).count();
    assert_eq!((forks, tree.branches.len()), (2, 3));
    // Where the second one is born, no branch has an orbit of another one, or its image.
    let each = tree.branches.iter().enumerate();
    let each = each.map(|(k, own)| (k, own.at(frequency, 1.45).expect("orbits")));
    let all: Vec<(usize, PeriodicOrbit)> = each
        .flat_map(|(k, own)| own.into_iter().map(move |orbit| (k, orbit)))
        .collect();
    let fastest = |own: &PeriodicOrbit| {
        let speeds = own.impacts().iter().map(|impact| impact.approach);
        speeds.fold(0.0, f64::max)
    };
    assert!(all.len() >= 2);
    for (k, own) in &all {
        let image = own.mirrored().expect("an odd scene");
        assert!((fastest(&image) - fastest(own)).abs() < 1e-9);
        let others = all.iter().filter(|(other, _)| other != k);
        for (_, other) in others {
            assert!((fastest(other) - fastest(own)).abs() > 1e-4);
        }
    }
}
