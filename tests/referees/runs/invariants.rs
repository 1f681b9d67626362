//! What must hold of the library's answer whatever the motion is.

use crate::runs::case::{Case, Push};
use crate::runs::chatters::chatters_end_where_impacts_accumulate;
use crate::runs::compare::Difference;
use crate::runs::counts::counts_are_those_of_what_is_kept;
use crate::runs::grazes::{grazes_are_listed, grazes_touch};
use crate::runs::jumps::{begins_chatter, impulses_move_the_motion};
use crate::runs::ledger::columns_are_energies;
use crate::runs::phases::phases_follow_the_forcing;
use crate::runs::places::{held_stops_are_closed, impacts_are_at_stops, segments_fill_the_span};
use crate::runs::record::AMBIGUOUS;
use crate::runs::reference::{Reference, slowest_rate, squared_frequencies};
use nalgebra::{DMatrix, DVector};
use vibroimpact::{
    Impact, ImpactSide, Keep, Method, Motion, Scene, SegmentKind, SimulateOptions, Stats,
    Trajectory, simulate,
};

/// Relative rounding allowed: complex modes lose up to three digits before others take their place, steps of an integrator add
/// their tolerance.
pub fn rounding(case: &Case) -> f64 {
    1e3 * f64::EPSILON + case.by_method(0.0, 10.0 * case.rtol)
}

pub fn check(
    case: &Case,
    scene: &Scene,
    run: &Trajectory,
    reference: &Reference,
) -> Vec<Difference> {
    [
        gaps_stay_open(case, run, reference),
        impacts_are_at_stops(case, run, reference),
        held_stops_are_closed(case, run, reference),
        impacts_keep_the_law(case, run, reference),
        impulses_move_the_motion(case, run, reference),
        forces_press(case, run, reference),
        energy_adds_up(case, run, reference),
        segments_fill_the_span(run),
        phases_follow_the_forcing(case, run),
        counts_are_those_of_what_is_kept(case, run),
        chatters_end_where_impacts_accumulate(case, run, reference),
        grazes_touch(case, run, reference),
        grazes_are_listed(case, run, reference),
        same_bits_twice(case, scene, run, reference),
    ]
    .into_iter()
    .flatten()
    .collect()
}

#[allow(
    clippy::unnecessary_wraps,
    reason = "every check ends with it or with none"
)]
pub fn difference(class: &str, detail: String) -> Option<Difference> {
    Some(Difference {
        class: class.to_string(),
        detail,
    })
}

/// Number of times asked for in the second run.
const ASKED: usize = 50;

/// Number of points at which gaps are looked at.
const POINTS: usize = 10_000;

/// The time of the first impact of a motion that reactions have fed: soon impacts are nearer to each other than times in doubles.
fn fed(case: &Case, run: &Trajectory, reference: &Reference) -> f64 {
    let speed = reference.fed(case).min(1e9 * reference.v_unit);
    let fed = run.impacts().iter().find(|i| i.approach > speed);
    fed.map_or(f64::INFINITY, |impact| impact.time)
}

fn gaps_stay_open(case: &Case, run: &Trajectory, reference: &Reference) -> Option<Difference> {
    let (start, mut end) = run.span();
    end = end.min(fed(case, run, reference));
    if reference.horizon.1 == Some(AMBIGUOUS) {
        // Who carries what is nobody's to say then, nor when the first of them is let go.
        end = start + reference.horizon.0;
    }
    // Complex modes mix positions and velocities.
    let slow = (!case.has_real_modes())
        .then(|| slowest_rate(case))
        .flatten();
    let mut fastest = 0.0;
    for k in 0..POINTS {
        let t = start + (end - start) * k as f64 / POINTS as f64;
        let (q, v) = run.state(t, ImpactSide::After).expect("inside the span");
        fastest = v.amax().max(fastest);
        let way = slow.map_or(0.0, |rate| fastest / rate);
        for (i, stop) in case.stops.iter().enumerate() {
            let terms = stop
                .outward()
                .iter()
                .zip(q.iter())
                .map(|(n, q)| n * q)
                .collect::<Vec<_>>();
            let gap = stop.clearance - terms.iter().sum::<f64>();
            let size = stop.clearance.abs() + terms.iter().map(|x| x.abs()).sum::<f64>();
            let reach: f64 = stop.normal.iter().map(|x| x.abs()).sum();
            let moved = reference
                .q_unit
                .max(reference.v_unit / reference.model.rate)
                .max(q.amax())
                .max(way);
            let allowed = rounding(case) * size.max(reach * moved) + start_depth(case, i);
            if gap < -allowed {
                let margin = 10.0
                    * (case.atol * reach
                        + case.rtol.min(1e-9) * size.max(reach * reference.main.q_size));
                let class = if gap < -margin {
                    "behind a stop"
                } else {
                    "behind a stop, within the margin"
                };
                return difference(class, format!("stop {i} at {:e}: gap {gap:e}", t - start));
            }
        }
    }
    None
}

/// How far a start that counts as in contact may be behind the stop, or bring another one behind its own.
fn start_depth(case: &Case, stop: usize) -> f64 {
    let depth = (-case.first_gap(stop)).max(0.0) * 2.0;
    let is_moved = (0..case.stops.len()).any(|i| case.starts_within_tolerance(i));
    if is_moved {
        depth.max(2.0 * case.start_tolerance(stop))
    } else {
        depth
    }
}

pub fn inverse_mass(case: &Case) -> DMatrix<f64> {
    case.mass.clone().try_inverse().expect("positive definite")
}

pub fn reaction(case: &Case, inverse: &DMatrix<f64>, stop: usize) -> DVector<f64> {
    let stop = &case.stops[stop];
    let normal = DVector::from_vec(stop.outward());
    match &stop.push {
        Push::Inertia => inverse * normal,
        Push::Coordinate => normal,
        Push::Direction(b) => DVector::from_row_slice(b) * if stop.lower { -1.0 } else { 1.0 },
    }
}

fn impacts_keep_the_law(
    case: &Case,
    run: &Trajectory,
    reference: &Reference,
) -> Option<Difference> {
    let impacts = run.impacts();
    let held = run.segments().expect("kept");
    let tick = 2.0 * f64::EPSILON * case.span.0.abs().max(case.span.1.abs());
    let near = 4.0 * tick + 1e-9 / reference.model.rate;
    for (k, impact) in impacts.iter().enumerate() {
        if impact.approach < 0.0
            || impact.departure < 0.0
            || impact.impulse < 0.0
            || !impact.time.is_finite()
        {
            return difference("row of an impact", format!("{impact:?}"));
        }
        if k > 0 && impact.time < impacts[k - 1].time {
            return difference(
                "impacts out of order",
                format!("{impact:?} after {:?}", impacts[k - 1]),
            );
        }
        // Impacts of other stops too near to tell the times apart: the sides are those of all together.
        let is_alone = impacts
            .iter()
            .enumerate()
            .skip(k.saturating_sub(8))
            .take(17)
            .all(|(j, other)| j == k || (other.time - impact.time).abs() > near);
        if !is_alone {
            continue;
        }
        if begins_chatter(&held, impact.time, near) {
            continue;
        }
        let (Ok(before), Ok(after)) = (
            run.state(impact.time, ImpactSide::Before),
            run.state(impact.time, ImpactSide::After),
        ) else {
            return difference("state refused", format!("{impact:?}"));
        };
        let normal = DVector::from_vec(case.stops[impact.stop].outward());
        // A time in doubles is off by a tick, and the motion there by as much as it moves.
        // The referee follows a motion that grows for some time only.
        let v_unit = reference.v_unit.max(before.1.amax());
        let acceleration = reference.model.rate * v_unit;
        // Nor can a speed be known beside places so far away.
        let place = reference.model.rate * before.0.amax();
        let far = place * 1e-2;
        let size = v_unit.max(far) * normal.lp_norm(1);
        // A flight may be moved by one matrix exponential, which is off by rounding times the radians that it turns (N. Higham, SIAM
        // J. Matrix Anal. Appl. 26 (2005) 1179): a speed by that of the place.
        let since = if k > 0 {
            impacts[k - 1].time
        } else {
            case.span.0
        };
        let carried = f64::EPSILON * reference.model.rate * (impact.time - since) * place;
        // Steps keep the speeds of stops held to their tolerance, and impacts begin from none.
        let relative = case.by_method(1e-12, 1e-12 + 10.0 * case.rtol);
        let unsteady = 4.0 * tick * acceleration + carried;
        let allowed = relative * size + unsteady * normal.lp_norm(1);
        let (into, out) = (normal.dot(&before.1), -normal.dot(&after.1));
        if (into - impact.approach).abs() > allowed || (out - impact.departure).abs() > allowed {
            let bend = acceleration * normal.lp_norm(1);
            let height = impact.departure.powi(2) / (2.0 * bend);
            let margin = 30.0
                * (case.atol + case.rtol.min(1e-9) * reference.main.q_size)
                * normal.lp_norm(1);
            let is_shallow = (into - impact.approach).abs() <= allowed
                && height < margin
                && out.abs() <= allowed;
            return difference(
                if is_shallow {
                    "row against motion, low flight"
                } else {
                    "row against motion"
                },
                format!("{impact:?}, motion {into:e} before, {out:e} after"),
            );
        }
        let touching = held.iter().any(|s| {
            s.kind == SegmentKind::Stick
                && s.start <= impact.time + tick
                && s.end >= impact.time - tick
                && s.stop != Some(impact.stop)
        });
        if touching {
            continue;
        }
        let e = case.stops[impact.stop].restitution;
        if (impact.departure - e * impact.approach).abs() > 1e-13 * size {
            return difference("law of restitution", format!("{impact:?}, e = {e}"));
        }
    }
    None
}

fn forces_press(case: &Case, run: &Trajectory, reference: &Reference) -> Option<Difference> {
    let inverse = inverse_mass(case);
    let segments = run.segments().expect("kept");
    let sticks: Vec<_> = segments
        .iter()
        .filter(|s| s.kind == SegmentKind::Stick && s.end > s.start)
        .collect();
    let end = fed(case, run, reference);
    for stick in sticks.iter().filter(|s| s.end < end) {
        // A release that comes late pulls just before.
        let parts = (1..20).map(|k| f64::from(k) / 20.0);
        for part in parts.chain([1e-3, 1e-5, 1e-7].map(|left| 1.0 - left)) {
            let t = stick.start + (stick.end - stick.start) * part;
            let mut held: Vec<usize> = sticks
                .iter()
                .filter(|s| s.start < t && t < s.end)
                .filter_map(|s| s.stop)
                .collect();
            held.sort_unstable();
            held.dedup();
            let (q, v) = run.state(t, ImpactSide::After).expect("inside the span");
            let mut force = DVector::from_row_slice(&case.load);
            let mut size = force.amax();
            let turned = reference.model.forcing_at(case, t);
            for (f, turned) in case.forces().zip(turned[1..].chunks(2)) {
                let (c, s) = (turned[0].to_f64(), turned[1].to_f64());
                for i in 0..case.n() {
                    force[i] += f.re[i] * c - f.im[i] * s;
                    size = size.max(f.re[i].abs()).max(f.im[i].abs());
                }
            }
            let (damping, spring) = (&case.damping * &v, &case.stiffness * &q);
            size = size.max(damping.amax()).max(spring.amax());
            // What is left of a motion that has died away is known to its tolerance, or to the rounding of what it was.
            let (damper, stiff) = (case.damping.amax(), case.stiffness.amax());
            let was = damper * reference.v_unit + stiff * reference.q_unit;
            size = size.max(case.by_method(1e-5 * was, damper.max(stiff) * case.atol / case.rtol));
            // And of one at rest to the rounding of where it rests.
            let held_at = reference.model.rate * reference.model.rate * q.amax();
            size = size.max(1e-6 * held_at * case.mass.diagonal().min());
            let free = &inverse * (force - damping - spring);
            let normals = DMatrix::from_fn(case.n(), held.len(), |i, j| {
                case.stops[held[j]].outward()[i]
            });
            let reactions: Vec<DVector<f64>> =
                held.iter().map(|&i| reaction(case, &inverse, i)).collect();
            if held.is_empty() {
                continue;
            }
            let b = DMatrix::from_columns(&reactions);
            let delassus = normals.transpose() * &b;
            let values = delassus.clone().svd(false, false).singular_values;
            if values.min() < 1e-9 * values.max() {
                continue;
            }
            let Some(forces) = delassus.lu().solve(&(normals.transpose() * free)) else {
                continue;
            };
            let largest = inverse.amax() * size / b.amax();
            let allowed = case.by_method(1e-9, 1e-5) * largest.max(1e-300);
            if forces.min() < -allowed {
                return difference(
                    "a contact force pulls",
                    format!(
                        "at {:e}: stops {held:?}, forces {:?}",
                        t - case.span.0,
                        forces.as_slice()
                    ),
                );
            }
            let speeds = normals.transpose() * &v;
            let limit = case.by_method(1e-10, 1e-6);
            if speeds.amax() > limit * (reference.v_unit + v.amax()) {
                return difference(
                    "held and moving",
                    format!(
                        "at {:e}: stops {held:?}, speeds {:?}",
                        t - case.span.0,
                        speeds.as_slice()
                    ),
                );
            }
        }
    }
    None
}

fn is_symmetric(a: &DMatrix<f64>) -> bool {
    (a - a.transpose()).amax() <= 1e-14 * a.amax()
}

/// How far the largest force moves a body that nothing but dashpots holds, over the span.
fn carried(case: &Case) -> f64 {
    let span = case.span.1 - case.span.0;
    let slowing = (0..case.n()).map(|i| case.damping[(i, i)] / case.mass[(i, i)]);
    let least = slowing.fold(f64::INFINITY, f64::min).max(1.0 / span);
    inverse_mass(case).amax() * case.largest_force() * span / least
}

fn energy_adds_up(case: &Case, run: &Trajectory, reference: &Reference) -> Option<Difference> {
    let is_inertial = case.stops.iter().all(|s| s.push == Push::Inertia);
    if !is_symmetric(&case.stiffness) {
        return None;
    }
    let energy = match run.energy() {
        Ok(energy) => energy,
        Err(error) => return difference("energy refused", error.to_string()),
    };
    let all = [
        &energy.kinetic,
        &energy.potential,
        &energy.forcing_work,
        &energy.damping_loss,
        &energy.impact_loss,
    ];
    let size = all
        .iter()
        .flat_map(|x| x.iter())
        .fold(0.0, |m: f64, x| m.max(x.abs()));
    // Positions no larger than this are known to no part of themselves, and no energy better than theirs.
    let unit = case.by_method(1e-12, case.atol / case.rtol);
    let least = 0.5 * case.mass.amax() * unit.powi(2) + case.largest_force() * unit;
    let size = size.max(least);
    let segments = run.segments().expect("motion is kept");
    let completions = segments.iter().filter(|s| s.kind == SegmentKind::Chatter);
    // Accumulating impacts that are completed end on the stop, off by the residual gap of theory 9.
    let completed = 40.0 * case.rtol * completions.count() as f64;
    let worst = energy.balance.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let allowed = case.by_method(1e-8, 1e-5 + 10.0 * case.rtol * run.stats().n_steps as f64);
    // What the forces do over the rounding of a position, which may be the small difference of large parts: of what a load and a slow
    // forcing each do to a body that nothing holds.
    let is_free = squared_frequencies(case).len() < case.n();
    let carried = if is_free { carried(case) } else { 0.0 };
    let place = f64::EPSILON * reference.q_unit.max(carried);
    let work = place * case.largest_force();
    let stiff = case.stiffness.amax();
    let rounding = 1e2 * work + 1e2 * place.powi(2) * stiff;
    // Each flight takes its places anew from such parts, and those of flights of one kind are off by one sign.
    let flights = 1.0 + run.impacts().len() as f64;
    // A body that nothing holds has no energy by its place, but what the springs and the speeds see of that where a flight is moved by
    // one matrix exponential is off by rounding times the radians that it turns, as in `impacts_keep_the_law`.
    let radians = reference.model.rate * (run.span().1 - run.span().0);
    let gone = if is_free { place * radians } else { 0.0 };
    let limit =
        (allowed + completed) * size + rounding + flights * work + 1e2 * gone.powi(2) * stiff;
    if let Some(difference) = columns_are_energies(case, run, (&energy, limit)) {
        return Some(difference);
    }
    if worst > limit || worst.is_nan() {
        return difference("energy balance", format!("{worst:e} of {size:e}"));
    }
    // Each class by itself, where it is known.
    let last = |x: &[f64]| x.last().copied().unwrap_or(0.0);
    let has_dampers = (&case.damping + case.damping.transpose()).amax() > 0.0;
    if !has_dampers && last(&energy.damping_loss).abs() > limit {
        let detail = format!("{:e} of {size:e}", last(&energy.damping_loss));
        return difference("loss of no dampers", detail);
    }
    if case.force.is_none() && last(&energy.forcing_work).abs() > limit {
        let detail = format!("{:e} of {size:e}", last(&energy.forcing_work));
        return difference("work of no forcing", detail);
    }
    if !is_inertial {
        return None;
    }
    let tick = 4.0 * f64::EPSILON * case.span.0.abs().max(case.span.1.abs());
    let near = tick + 1e-9 / reference.model.rate;
    let impacts = run.impacts();
    let are_alone = impacts.windows(2).all(|p| p[1].time - p[0].time > near);
    // Stops that are held do no work, nor is there any at impacts that accumulate but in their rows.
    if are_alone && segments.iter().all(|s| s.kind != SegmentKind::Chatter) {
        let end = run.sample_times().unwrap_or_default().last().copied();
        let rows = impacts
            .iter()
            .filter(|i| end.is_some_and(|end| i.time <= end));
        let rows: f64 = rows
            .map(|i| 0.5 * i.impulse * (i.approach - i.departure))
            .sum();
        let off = last(&energy.impact_loss) - rows;
        if off.abs() > limit {
            return difference("impact loss against rows", format!("{off:e} of {size:e}"));
        }
    }
    let losses = energy.impact_loss.windows(2).map(|w| w[1] - w[0]);
    let (at, loss) = losses
        .enumerate()
        .fold((0, 0.0), |worst, l| if l.1 < worst.1 { l } else { worst });
    if loss < -(1e-3 * allowed.max(1e-6) + completed) * size - rounding {
        let times = run.sample_times().unwrap_or_default();
        let when = times.get(at).copied().unwrap_or(f64::NAN);
        let detail = format!("{loss:e} of {size:e} after {:e}", when - case.span.0);
        return difference("impacts gain energy", detail);
    }
    None
}

fn same_bits_twice(
    case: &Case,
    scene: &Scene,
    run: &Trajectory,
    reference: &Reference,
) -> Option<Difference> {
    let (q0, v0) = case.start();
    // Times asked for, and what is kept, change nothing else.
    let (start, end) = run.span();
    let asked: Vec<f64> = (0..ASKED)
        .map(|k| start + (end - start) * k as f64 / ASKED as f64)
        .collect();
    let options = SimulateOptions {
        t_eval: Some(asked.clone()),
        keep: Keep::Impacts,
        ..case.options()
    };
    let again = match simulate(scene, &q0, &v0, case.span, &options) {
        Ok(again) => again,
        Err(error) => return difference("error the second time", error.to_string()),
    };
    let (times, q, v) = again.samples().expect("asked for");
    if times != asked {
        return difference("samples at other times", format!("{times:?}"));
    }
    let tick = 2.0 * f64::EPSILON * start.abs().max(end.abs());
    for (k, &t) in asked.iter().enumerate() {
        let (q_kept, v_kept) = run.state(t, ImpactSide::After).expect("inside the span");
        let off = (q.row(k).transpose() - &q_kept).amax() / reference.q_unit.max(q_kept.amax());
        let fast = (v.row(k).transpose() - &v_kept).amax() / reference.v_unit.max(v_kept.amax());
        if off.max(fast) > 1e-12 + tick * reference.model.rate {
            let is_struck = run.impacts().iter().any(|i| i.time == t);
            if !is_struck {
                return difference(
                    "samples off the motion",
                    format!("{off:e} {fast:e} at {t:e}"),
                );
            }
        }
    }
    // A phase that is no number stays one.
    let bits = |i: &Impact| {
        let numbers = [i.time, i.approach, i.departure, i.impulse, i.phase];
        (i.stop, numbers.map(f64::to_bits))
    };
    let are_same = (again.impacts().iter().map(bits)).eq(run.impacts().iter().map(bits));
    if are_same && again.last() == run.last() {
        // The method of order 8 takes more rates where its steps are kept.
        let counts = |stats: Stats| Stats {
            n_rhs: if case.method == Method::Dop853 {
                0
            } else {
                stats.n_rhs
            },
            ..stats
        };
        if again.grazes() == run.grazes() && counts(again.stats()) == counts(run.stats()) {
            return None;
        }
        let detail = format!("{:?}, {:?}", again.stats(), again.grazes());
        return difference("other counts the second time", detail);
    }
    let is_nan = again
        .last()
        .0
        .iter()
        .chain(again.last().1.iter())
        .any(|x| x.is_nan());
    difference(
        if is_nan {
            "not a number"
        } else {
            "other bits the second time"
        },
        String::new(),
    )
}
