//! A referee of periodic orbits that shares no line with the library: plain matrices, an exponential and a solver of its own.

mod causes;
mod closing;
mod plant;
#[path = "../common/random.rs"]
mod random;

use closing::misfit;
use plant::{KINDS, Plant, random_plant};
use random::{Random, number};
use vibroimpact::{Free, OrbitOptions, Orbits, Parameter, Pattern, periodic_orbits};

/// What an orbit closes to, relative to its size.
const CLOSED: f64 = 1e-9;

/// What is asked of a scene.
fn questions(random: &mut Random, plant: &Plant) -> Vec<(Pattern, OrbitOptions)> {
    let options = OrbitOptions {
        n_periods: 1 + random.below(3),
        ..Default::default()
    };
    let mut all = vec![(Pattern::none(), options.clone())];
    let stops = plant.faces.len();
    for stop in 0..stops {
        all.push((Pattern::single(stop), options.clone()));
        let phase = Some(random.between(0.0, 6.2));
        let given = OrbitOptions {
            phase,
            ..options.clone()
        };
        all.push((Pattern::single(stop), given));
    }
    if stops >= 2 {
        let together = Pattern::together(&[0, 1]).expect("two stops");
        for free in [Free::Clearance, Free::Parameter(Parameter::ForcingScale)] {
            let free = Some(free);
            all.push((
                together.clone(),
                OrbitOptions {
                    free,
                    ..options.clone()
                },
            ));
        }
        let phase = Some(random.between(0.0, 6.2));
        all.push((
            together,
            OrbitOptions {
                phase,
                ..options.clone()
            },
        ));
    }
    if stops >= 1 && random.unit() < 0.5 {
        let other = random.below(stops);
        let twice = Pattern::new(vec![vec![0], vec![other]]).expect("two instants");
        all.push((twice, options));
    }
    all
}

/// The orbits of a pattern, none where its stops cannot be hit so.
fn asked(plant: &Plant, pattern: &Pattern, options: &OrbitOptions) -> Option<Orbits> {
    match periodic_orbits(&plant.scene(), pattern, options) {
        Ok(orbits) => Some(orbits),
        Err(error) => {
            let text = error.to_string();
            let is_rule =
                text.contains("dependent normals") || text.contains("undamped modes in step");
            assert!(is_rule, "{}: {text}\n{plant:?}", plant.kind);
            None
        }
    }
}

#[test]
fn every_orbit_closes() {
    let cases = number("VIBROIMPACT_CASES", 64);
    let seed = number("VIBROIMPACT_SEED", 0x0B17) as u64;
    let only = std::env::var("VIBROIMPACT_CASE")
        .ok()
        .and_then(|text| text.parse::<usize>().ok());
    let (mut total, mut lost, mut failures) = (0usize, 0usize, Vec::new());
    for case in 0..cases {
        if only.is_some_and(|only| only != case) {
            continue;
        }
        let mut random = Random((seed << 20) + 7919 * case as u64 + 1);
        for _ in 0..8 {
            random.unit();
        }
        let plant = random_plant(&mut random, KINDS[case % KINDS.len()]);
        for (pattern, options) in questions(&mut random, &plant) {
            let Some(orbits) = asked(&plant, &pattern, &options) else {
                continue;
            };
            lost += usize::from(orbits.reason().contains("told from rounding"));
            for orbit in orbits.iter() {
                total += 1;
                let plant = Plant {
                    force: plant.force.map(|f| f * scale(&orbits)),
                    ..plant.clone()
                };
                let found = misfit(&plant, orbit);
                if !(found.worst() <= CLOSED) {
                    failures.push(format!(
                        "case {case} ({}, n = {}), {:?}, free {:?}, phase {:?}: {found:?}; verdict {:?}: {}",
                        plant.kind,
                        plant.n(),
                        pattern.instants(),
                        options.free,
                        options.phase,
                        orbits.verdict(),
                        orbits.reason(),
                    ));
                }
            }
        }
    }
    println!(
        "{total} orbits, {} do not close; {lost} lists left some out",
        failures.len()
    );
    // What rounding has left nothing of is rare.
    assert!(lost <= 1 + cases / 100, "{lost} lists left orbits out");
    assert!(
        failures.is_empty(),
        "{} of {total}:\n{}",
        failures.len(),
        failures.join("\n")
    );
}

/// The factor on the forcing that a search for it has found.
fn scale(orbits: &Orbits) -> f64 {
    let text = orbits.reason().split("forcing_scale = ").nth(1);
    text.and_then(|text| {
        text.split(|c: char| c == ';' || c == ' ')
            .next()?
            .parse()
            .ok()
    })
    .unwrap_or(1.0)
}
