//! Scenes of which an orbit once did not close, the least that shows it.

use crate::orbits::closing::misfit;
use crate::orbits::plant::{Face, Plant, chain};
use nalgebra::{Complex, DMatrix, DVector, dmatrix, dvector};
use vibroimpact::{FreeParameter, OrbitOptions, Pattern, Reaction, Verdict, periodic_orbits};

/// What an orbit closes to, relative to its size.
const CLOSED: f64 = 1e-11;

fn inertial(mass: &DMatrix<f64>, normal: DVector<f64>, clearance: f64, restitution: f64) -> Face {
    let inverse = mass.clone().try_inverse().expect("positive definite");
    Face {
        reaction: inverse * &normal,
        normal,
        clearance,
        restitution,
        law: Reaction::Inertia,
    }
}

fn check(plant: &Plant, pattern: &Pattern, options: &OrbitOptions, least: usize) {
    let orbits = periodic_orbits(&plant.scene(), pattern, options).expect("solved");
    assert!(
        orbits.len() >= least,
        "{} {options:?} {:?}: {}",
        plant.kind,
        plant.faces,
        orbits.reason()
    );
    for orbit in orbits.iter() {
        let found = misfit(plant, orbit);
        assert!(found.worst() < CLOSED, "{}: {found:?}", plant.kind);
    }
}

#[test]
fn a_chain_with_weight_and_one_dashpot_to_the_ground_bounces_and_closes() {
    for (damper, e) in [(0.1, 0.5), (0.7, 0.9), (0.7, 0.0)] {
        let mass = dmatrix![1.0, 0.0; 0.0, 1.5];
        let mut damping = chain(&[0.2]);
        damping[(0, 0)] += damper;
        let plant = Plant {
            kind: "weight",
            faces: vec![inertial(&mass, dvector![0.0, 1.0], 0.1, e)],
            load: mass.diagonal() * 0.8,
            mass,
            damping,
            stiffness: chain(&[20.0]),
            force: dvector![Complex::new(60.0, 0.0), Complex::new(0.0, 0.0)],
            w: 1.7,
        };
        check(&plant, &Pattern::single(0), &OrbitOptions::default(), 2);
        // The impulse is the weight times the period whatever the phase: given one, the speeds do not fit.
        let phase = Some(0.4);
        let given = OrbitOptions {
            phase,
            ..Default::default()
        };
        check(&plant, &Pattern::single(0), &given, 0);
    }
}

#[test]
fn a_free_pair_near_half_its_frequency_closes() {
    for off in [1e-6, 1e-8, 1e-9, 1e-10] {
        let mass = dmatrix![1.0, 0.0; 0.0, 2.0];
        let plant = Plant {
            kind: "free pair",
            faces: vec![inertial(&mass, dvector![0.0, 1.0], 0.4, 0.05)],
            load: dvector![0.0, 0.0],
            mass,
            damping: DMatrix::zeros(2, 2),
            stiffness: chain(&[1000.0]),
            force: dvector![Complex::new(4.0, 0.0), Complex::new(-5.0, 0.0)],
            w: 0.5 * 1500f64.sqrt() * (1.0 + off),
        };
        for n_periods in 1..=3 {
            let options = OrbitOptions {
                n_periods,
                ..Default::default()
            };
            check(&plant, &Pattern::single(0), &options, 0);
        }
    }
}

#[test]
fn stops_with_one_normal_and_two_reactions_are_hit_together() {
    let mass = dmatrix![1.0, 0.2; 0.2, 1.5];
    let first = inertial(&mass, dvector![1.0, 0.0], 0.3, 0.6);
    let second = Face {
        reaction: dvector![1.0, 0.4],
        law: Reaction::Direction(dvector![1.0, 0.4]),
        ..first.clone()
    };
    let stiffness = dmatrix![3.0, -1.0; -1.0, 2.0];
    let plant = Plant {
        kind: "twins",
        faces: vec![first, second],
        load: dvector![0.0, 0.0],
        mass,
        damping: &stiffness * 0.05,
        stiffness,
        force: dvector![Complex::new(4.0, 0.0), Complex::new(0.3, 0.0)],
        w: 1.3,
    };
    let together = Pattern::together(&[0, 1]).expect("two stops");
    for (phase, free) in [
        (Some(0.7), None),
        (None, Some(FreeParameter::Clearance)),
        (None, None),
    ] {
        let options = OrbitOptions {
            phase,
            free,
            ..Default::default()
        };
        check(&plant, &together, &options, 1);
    }
    // Twins alike are one stop: half the impulse each.
    let faces = vec![plant.faces[0].clone(), plant.faces[0].clone()];
    let twins = Plant { faces, ..plant };
    let both = periodic_orbits(&twins.scene(), &together, &OrbitOptions::default());
    let alone = periodic_orbits(
        &twins.scene(),
        &Pattern::single(0),
        &OrbitOptions::default(),
    );
    let (both, alone) = (both.expect("solved"), alone.expect("solved"));
    assert_eq!((both.verdict(), both.len()), (Verdict::Found, 2));
    for orbit in both.iter() {
        let same = alone
            .iter()
            .find(|o| (o.phase() - orbit.phase()).abs() < 1e-9);
        let (same, halves) = (same.expect("found"), orbit.impacts());
        assert!((orbit.v0() - same.v0()).amax() < 1e-11);
        let whole = same.impacts()[0].impulse;
        assert!(
            halves
                .iter()
                .all(|half| (2.0 * half.impulse - whole).abs() < 1e-10 * whole.abs())
        );
    }
}

#[test]
fn a_body_that_no_stop_sees_is_a_family_or_there_is_no_orbit() {
    let mass = DMatrix::<f64>::identity(2, 2);
    let face = inertial(&mass, dvector![0.0, 1.0], 0.2, 0.6);
    let plant = |force: f64, load: f64| Plant {
        kind: "apart",
        faces: vec![face.clone()],
        load: dvector![load, 0.0],
        mass: mass.clone(),
        damping: dmatrix![0.0, 0.0; 0.0, 0.1],
        stiffness: dmatrix![0.0, 0.0; 0.0, 1.0],
        force: dvector![Complex::new(force, 0.0), Complex::new(1.5, 0.0)],
        w: 2.3,
    };
    let twice = Pattern::new(vec![vec![0], vec![0]]).expect("two instants");
    let options = OrbitOptions {
        n_periods: 3,
        ..Default::default()
    };
    // The same without the body.
    let alone = Plant {
        faces: vec![inertial(&dmatrix![1.0], dvector![1.0], 0.2, 0.6)],
        load: dvector![0.0],
        mass: dmatrix![1.0],
        damping: dmatrix![0.1],
        stiffness: dmatrix![1.0],
        force: dvector![Complex::new(1.5, 0.0)],
        ..plant(0.0, 0.0)
    };
    let alone = periodic_orbits(&alone.scene(), &twice, &options).expect("solved");
    assert!(!alone.is_empty(), "{}", alone.reason());
    for force in [0.0, 0.7] {
        let plant = plant(force, 0.0);
        check(&plant, &twice, &options, alone.len());
        let found = periodic_orbits(&plant.scene(), &twice, &options).expect("solved");
        assert_eq!(
            (found.verdict(), found.len()),
            (Verdict::Family, alone.len())
        );
        let basis = &found.family().expect("a family").basis;
        assert_eq!(basis.shape(), (4, 1));
        // The body may be anywhere.
        assert!(
            basis[(0, 0)].abs() > 0.0 && basis.rows(1, 3).amax() == 0.0,
            "{basis}"
        );
    }
    let loaded = periodic_orbits(&plant(0.0, 0.3).scene(), &twice, &options).expect("solved");
    assert_eq!(loaded.verdict(), Verdict::None);
    assert!(
        loaded.reason().contains("nothing to rest on"),
        "{}",
        loaded.reason()
    );
}
