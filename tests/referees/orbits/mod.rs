//! A referee of periodic orbits that shares no line with the library: plain matrices, an exponential and a solver of its own.

mod causes;
mod closing;
mod plant;
mod returns;
mod scan;

use crate::random::{Cases, Random};
use closing::misfit;
use nalgebra::DVector;
use plant::{KINDS, Plant, random_plant};
use returns::Returns;
use scan::{Times, phases};
use std::f64::consts::TAU;
use vibroimpact::{
    FreeParameter, ImpactSide, Motion, OrbitOptions, Orbits, Parameter, Pattern, PeriodicOrbit,
    periodic_orbits,
};

/// What an orbit closes to, relative to its size.
const CLOSED: f64 = 1e-9;
/// What a sampled gap may be below zero where the orbit is admissible, relative to the motion.
const TOUCH: f64 = 1e-10;

fn cases(default: usize) -> Cases {
    Cases::new(0x0B17, default)
}

/// The scenes asked for: the number of each, a plant and numbers for the questions.
fn scenes(default: usize) -> impl Iterator<Item = (usize, Random, Plant)> {
    cases(default).each().map(|(case, mut random)| {
        let plant = random_plant(&mut random, KINDS[case % KINDS.len()]);
        (case, random, plant)
    })
}

/// Whether one scene alone is looked at, which need not have all that is counted.
fn is_one() -> bool {
    cases(0).is_one()
}

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
        for free in [
            FreeParameter::Clearance,
            FreeParameter::Parameter(Parameter::ForcingScale),
        ] {
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

/// The factor on the forcing that a search for it has found.
fn scale(orbits: &Orbits) -> f64 {
    let text = orbits.reason().split("forcing_scale = ").nth(1);
    let number = text.and_then(|text| text.split([';', ' ']).next()?.parse().ok());
    number.unwrap_or(1.0)
}

/// Every orbit of the scenes, with the plant that it moves by.
fn each_orbit(
    default: usize,
    mut see: impl FnMut(&str, &Plant, &Orbits, &PeriodicOrbit),
) -> [usize; 2] {
    let (mut total, mut lost) = (0, 0);
    for (case, mut random, plant) in scenes(default) {
        for (pattern, options) in questions(&mut random, &plant) {
            let Some(orbits) = asked(&plant, &pattern, &options) else {
                continue;
            };
            lost += usize::from(orbits.reason().contains("told from rounding"));
            let factor = scale(&orbits);
            let plant = Plant {
                force: plant.force.map(|f| f * factor),
                ..plant.clone()
            };
            for (i, orbit) in orbits.iter().enumerate() {
                total += 1;
                let label = format!(
                    "case {case} ({}, n = {}), {:?}, {} periods, free {:?}, phase {:?}, orbit {i}",
                    plant.kind,
                    plant.n(),
                    pattern.instants(),
                    options.n_periods,
                    options.free,
                    options.phase,
                );
                see(&label, &plant, &orbits, orbit);
            }
        }
    }
    [total, lost]
}

fn none_failed(subject: &str, failures: &[String], total: usize) {
    if !is_one() {
        crate::soak::note(subject, cases(0).seed, total, failures.len());
    }
    println!("{total} looked at, {} failed", failures.len());
    let shown: Vec<&str> = failures.iter().take(60).map(String::as_str).collect();
    assert!(
        failures.is_empty(),
        "{} of {total}:\n{}",
        failures.len(),
        shown.join("\n")
    );
}

#[test]
fn every_orbit_closes() {
    let mut failures = Vec::new();
    let [total, lost] = each_orbit(64, |label, plant, orbits, orbit| {
        let found = misfit(plant, orbit);
        if found.worst() > CLOSED {
            failures.push(format!("{label}: {found:?}; {}", orbits.reason()));
        }
    });
    none_failed("orbits that close", &failures, total);
    assert!(is_one() || total > 0);
    // What rounding has left nothing of is rare.
    assert!(lost <= 1 + total / 500, "{lost} lists left orbits out");
}

/// Gaps along an orbit: the least of every stop, away from its own contacts, and the size of the motion.
fn sampled_gaps(plant: &Plant, orbit: &PeriodicOrbit) -> (Vec<(f64, f64)>, f64) {
    let n = plant.n();
    let mut least = vec![(f64::INFINITY, 0.0); plant.faces.len()];
    let mut starts: Vec<f64> = closing::instants(orbit).iter().map(|(t, _)| *t).collect();
    if starts.is_empty() {
        starts.push(0.0);
    }
    let mut size = 0.0f64;
    for (k, &start) in starts.iter().enumerate() {
        let end = starts.get(k + 1).copied().unwrap_or(orbit.period());
        let (q, v) = orbit.state(start, ImpactSide::After).expect("a time");
        let mut x = plant.lifted(&q, &v, plant.w * start + orbit.phase());
        plant.carry(&mut x, end - start, |t, x| {
            let q = x.rows(0, n).into_owned();
            size = size.max(q.amax());
            let gaps = orbit.scene().gaps(&q).expect("linear");
            for (least, &gap) in least.iter_mut().zip(gaps.iter()) {
                if gap < least.0 {
                    *least = (gap, start + t);
                }
            }
        });
    }
    (least, size)
}

/// Speeds that are nothing but rounding, in parts of the motion's.
const ROUNDING: f64 = 1e-14;

/// Whether stops are only touched at some instant: all that is reached there has less speed.
fn touches(orbit: &PeriodicOrbit, slow: f64) -> bool {
    let mut instants = orbit.impacts().chunk_by(|a, b| a.time == b.time);
    instants.any(|instant| instant.iter().all(|own| own.approach.abs() < slow))
}

#[test]
fn an_orbit_is_admissible_where_samples_show_no_breach() {
    let (mut failures, mut judged, mut open) = (Vec::new(), [0; 2], 0usize);
    let [total, _] = each_orbit(48, |label, plant, _, orbit| {
        let (least, size) = sampled_gaps(plant, orbit);
        let lengths = plant.faces.iter().map(|face| face.normal.norm());
        let lowest = least
            .iter()
            .zip(lengths)
            .map(|((gap, t), length)| (gap / length, *t));
        let (gap, t) = lowest.fold((f64::INFINITY, 0.0), |m, x| if x.0 < m.0 { x } else { m });
        let fast = orbit.v0().amax() + plant.w * size;
        match orbit.is_admissible() {
            None => open += 1,
            Some(true) => {
                judged[1] += 1;
                if gap < -TOUCH * size {
                    failures.push(format!(
                        "{label}: admissible, but passes by {gap:e} of {size:e} at {t}"
                    ));
                }
                if orbit
                    .impacts()
                    .iter()
                    .any(|i| i.approach < -1e-9 * fast || i.impulse < 0.0)
                    || touches(orbit, ROUNDING * fast)
                {
                    failures.push(format!("{label}: admissible, but {:?}", orbit.impacts()));
                }
            }
            Some(false) => {
                judged[0] += 1;
                let found = orbit.violation().expect("not admissible");
                let length = plant.faces[found.stop].normal.norm();
                if found.depth > 0.0 {
                    let (q, _) = orbit.state(found.time, ImpactSide::After).expect("a time");
                    let there = orbit.scene().gaps(&q).expect("linear")[found.stop];
                    if (there + found.depth).abs() > 1e-9 * size * length {
                        failures.push(format!("{label}: {found:?}, but the gap is {there}"));
                    }
                    // A search that could not go on says that there may be worse.
                    let is_worst = !found.reason.contains("could not decide");
                    let deepest = least.iter().fold(0.0f64, |m, (gap, _)| m.max(-gap));
                    if is_worst && deepest > found.depth + 1e-9 * size {
                        failures.push(format!(
                            "{label}: {found:?}, but a stop is passed by {deepest}"
                        ));
                    }
                } else if !orbit
                    .impacts()
                    .iter()
                    .any(|i| i.approach < 0.0 || i.impulse < 0.0)
                    && !touches(orbit, 1e-9 * fast)
                {
                    failures.push(format!("{label}: {found:?}, but impacts approach and push"));
                }
            }
        }
    });
    none_failed("admissibility by samples", &failures, total);
    assert!(
        is_one() || judged[0] > 0 && judged[1] > 0 && open <= total / 20,
        "{judged:?} {open}"
    );
}

/// The scaled state after the first impact, and the sizes of position and velocity.
fn start(orbit: &PeriodicOrbit, w: f64) -> (DVector<f64>, [f64; 2]) {
    let (q, v) = (orbit.q0(), orbit.v0());
    let fast = v.amax()
        + orbit
            .state(0.0, ImpactSide::Before)
            .expect("a time")
            .1
            .amax();
    let at = q.amax() + fast / w;
    // A motion that hardly moves about its contact has the speed of nothing.
    let fast = fast.max(1e-3 * w * at);
    let both = q.iter().chain(v.iter()).copied();
    (DVector::from_iterator(2 * q.len(), both), [at, fast])
}

/// The return map of an orbit, its start, and the sizes of position and velocity; `None` where an impact is so slow that the map
/// bends within any difference.
fn returns<'a>(
    plant: &'a Plant,
    orbit: &PeriodicOrbit,
) -> Option<(Returns<'a>, DVector<f64>, [f64; 2])> {
    let (x, sizes) = start(orbit, plant.w);
    let slow = 0.03 * sizes[1].max(plant.w * sizes[0]);
    let is_slow = orbit.impacts().iter().any(|i| i.approach.abs() < slow);
    let returns = Returns::new(plant, orbit).filter(|_| !is_slow)?;
    Some((returns, x, sizes))
}

#[test]
fn multipliers_are_those_of_the_return_map() {
    let (mut failures, mut compared) = (Vec::new(), 0usize);
    let [total, _] = each_orbit(48, |label, plant, _, orbit| {
        let Some((returns, x, sizes)) = returns(plant, orbit) else {
            return;
        };
        let stability = orbit.stability().expect("converges");
        let Some(order) = stability.orders.first() else {
            return;
        };
        let (Some(coarse), Some(fine)) = (
            returns.jacobian(&x, sizes, 4e-6),
            returns.jacobian(&x, sizes, 1e-6),
        ) else {
            return;
        };
        let unit = |i: usize| sizes[i / plant.n()];
        let scaled =
            |m: &nalgebra::DMatrix<f64>| m.map_with_location(|i, j, x| x * unit(j) / unit(i));
        let (coarse, fine, ours) = (scaled(&coarse), scaled(&fine), scaled(&order.monodromy));
        let size = 1.0 + ours.amax();
        if (&coarse - &fine).amax() > 1e-6 * size {
            return;
        }
        compared += 1;
        let miss = (&fine - &ours).amax();
        if miss.is_nan() || miss > 2e-5 * size {
            failures.push(format!("{label}: monodromy off by {miss:e} of {size:e}"));
        }
        // Their product: e^2 for each impact, times that of the flow.
        let trace = (plant.mass.clone().try_inverse().expect("regular") * &plant.damping).trace();
        let shrunk = (-orbit.period() * trace).exp();
        let restitutions = orbit
            .impacts()
            .iter()
            .map(|i| plant.faces[i.stop].restitution.powi(2));
        let exact = restitutions.product::<f64>() * shrunk;
        let product: f64 = order.multipliers.iter().map(|z| z.norm()).product();
        // A determinant is known to the product of all singular values, each known to a part of the largest, but the least, of which
        // that part is all.
        let stretches = ours.clone().svd(false, false).singular_values;
        let least = 1e-12 * stretches[0];
        let others = stretches.rows(0, stretches.len() - 1);
        let rounding = least * others.iter().map(|s| s.max(least)).product::<f64>();
        let off = (product - exact).abs();
        if off.is_nan() || off > 1e-6 * exact + rounding {
            failures.push(format!(
                "{label}: the multipliers' product is {product}, not {exact}"
            ));
        }
    });
    none_failed("multipliers by differences", &failures, compared);
    assert!(5 * compared > total || is_one(), "{compared} of {total}");
}

#[test]
fn stability_is_what_perturbed_starts_show() {
    let (mut failures, mut seen) = (Vec::new(), [0usize; 2]);
    let [count, _] = each_orbit(24, |label, plant, _, orbit| {
        let Some((returns, x, sizes)) = returns(plant, orbit) else {
            return;
        };
        let stability = orbit.stability().expect("converges");
        let radius = stability
            .orders
            .first()
            .map_or(1.0, vibroimpact::OrderMultipliers::spectral_radius);
        if (0.95..=1.1).contains(&radius) || radius > 1e4 {
            return;
        }
        let n = plant.n();
        let apart = |y: &DVector<f64>| {
            let d = y - &x;
            (d.rows(0, n).amax() / sizes[0]).max(d.rows(n, n).amax() / sizes[1])
        };
        // A generic direction.
        let mut y = DVector::from_fn(2 * n, |i, _| {
            x[i] + 1e-7 * sizes[i / n] * (1.0 + 0.37 * i as f64).sin()
        });
        let mut is_near = true;
        for _ in 0..300 {
            match returns.map(&y) {
                Some(next) if apart(&next) < 1e-3 => y = next,
                _ => {
                    is_near = false;
                    break;
                }
            }
        }
        let found = Some(is_near && apart(&y) < 1e-7);
        let wanted = stability.is_stable;
        seen[usize::from(wanted == Some(true))] += 1;
        if found != wanted {
            failures.push(format!(
                "{label}: radius {radius}, {wanted:?}, but a start comes to {:e}",
                apart(&y)
            ));
        }
    });
    none_failed("stability by perturbed starts", &failures, count);
    assert!(is_one() || seen[0] > 0 && seen[1] > 0, "{seen:?}");
}

#[test]
fn lists_of_one_impact_are_complete() {
    let (mut failures, mut compared) = (Vec::new(), 0usize);
    for (case, mut random, plant) in scenes(64) {
        let n_periods = 1 + random.below(3);
        for stop in 0..plant.faces.len() {
            let Some(expected) = phases(&plant, stop, n_periods) else {
                continue;
            };
            let options = OrbitOptions {
                n_periods,
                ..Default::default()
            };
            let orbits = asked(&plant, &Pattern::single(stop), &options).expect("one stop");
            let found: Vec<f64> = orbits.iter().map(PeriodicOrbit::phase).collect();
            compared += 1;
            let near = |a: f64, b: f64| (0.5 * (a - b)).sin().abs() < 1e-5;
            let is_same = found.len() == expected.len()
                && expected.iter().all(|e| found.iter().any(|f| near(*f, *e)));
            if !is_same {
                failures.push(format!(
                    "case {case} ({}, n = {}), stop {stop}: {found:?}, not {expected:?}: {}",
                    plant.kind,
                    plant.n(),
                    orbits.reason()
                ));
            }
        }
    }
    none_failed("lists of one impact", &failures, compared);
    assert!(is_one() || compared > 0);
}

#[test]
fn lists_of_two_impacts_are_complete() {
    let (mut failures, mut compared, mut total) = (Vec::new(), 0usize, 0usize);
    for (case, mut random, plant) in scenes(24) {
        let n_periods = 1 + random.below(3);
        if plant.faces.is_empty() {
            continue;
        }
        let other = random.below(plant.faces.len());
        let times = Times::new(&plant, [0, other], n_periods);
        let Some(expected) = times.scan() else {
            continue;
        };
        let options = OrbitOptions {
            n_periods,
            ..Default::default()
        };
        let pattern = Pattern::new(vec![vec![0], vec![other]]).expect("two instants");
        let Some(orbits) = asked(&plant, &pattern, &options) else {
            continue;
        };
        compared += 1;
        let t = times.period;
        let found: Vec<f64> = orbits.iter().map(|o| o.impacts()[1].time).collect();
        total += found.len();
        let is_alike = other == 0;
        let label = format!(
            "case {case} ({}, n = {}), [0], [{other}], {n_periods}",
            plant.kind,
            plant.n()
        );
        // Where like instants are whole forcing periods apart their contacts coincide, and the residual is nought by nought.
        let is_whole = |dt: f64| {
            let turns = plant.w * dt / TAU;
            is_alike && (turns - turns.round()).abs() < 1e-4
        };
        for dt in expected {
            // Trivial zeros, and lines of solutions: where instants meet or are half the period apart.
            let is_special = dt < 1e-3 * t || t - dt < 1e-3 * t || (dt - 0.5 * t).abs() < 1e-4 * t;
            let is_there =
                |f: &f64| (f - dt).abs() < 1e-6 * t || (is_alike && (t - f - dt).abs() < 1e-6 * t);
            if !is_special && !is_whole(dt) && !found.iter().any(is_there) {
                failures.push(format!(
                    "{label}: dt = {dt} of {t} is missing: {found:?} {}",
                    orbits.reason()
                ));
            }
        }
        // What closes, and meets its stops by the law, is an orbit, whatever the scan shows there.
        for orbit in orbits.iter() {
            let found = misfit(&plant, orbit);
            if found.worst() > CLOSED {
                failures.push(format!(
                    "{label}: {:?} is invented, {found:?}",
                    orbit.impacts()
                ));
            }
        }
    }
    println!("{total} orbits");
    none_failed("lists of two impacts", &failures, compared);
    assert!(is_one() || compared > 0);
}
