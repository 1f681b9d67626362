//! Laws of motions taken in Runge-Kutta steps (theory 8), most of them against exact flights of the same scene.

use crate::random::{Cases, Random};
use crate::scenes::{harmonic, linear, lower, oscillator, scene, unit_mass, upper};
use nalgebra::{DMatrix, DVector, dvector};
use vibroimpact::{
    Change, Constraint, Forcing, Harmonic, Impact, ImpactSide, Keep, Kind, Method, Motion,
    PaperOptions, Scene, Side, SimulateOptions, Solver, Status, Stop, StopNumber, Trajectory,
    paper_scene, simulate,
};

/// Every method of steps, the least order that is seen of it over decades of tolerance, and by how many tolerances its error may
/// exceed what a step is allowed: Radau's estimate is of a lower order than its end, and is allowed a power of the tolerance.
const METHODS: [(Method, f64, f64); 3] = [
    (Method::Rk45, 4.7, 1.0),
    (Method::Dop853, 7.5, 1.0),
    (Method::Radau, 4.7, 40.0),
];

fn steps(method: Method, rtol: f64) -> SimulateOptions {
    SimulateOptions {
        solver: Solver {
            method,
            rtol,
            atol: Some(1e-3 * rtol),
        },
        ..Default::default()
    }
}

fn rk45(rtol: f64) -> SimulateOptions {
    steps(Method::Rk45, rtol)
}

fn exact(rtol: f64) -> SimulateOptions {
    steps(Method::Exact, rtol)
}

/// A scene with a start.
struct Case {
    scene: Scene,
    q0: DVector<f64>,
    v0: DVector<f64>,
}

impl Case {
    fn run(&self, span: (f64, f64), options: &SimulateOptions) -> Trajectory {
        simulate(&self.scene, &self.q0, &self.v0, span, options).expect("runs")
    }
}

/// Position and velocity at the end of a run, one behind the other.
fn end(run: &Trajectory) -> Vec<f64> {
    let (q, v) = run.last();
    q.iter().chain(v.iter()).copied().collect()
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

fn pendulums(linear: bool) -> Case {
    let options = PaperOptions {
        linear,
        ..Default::default()
    };
    Case {
        scene: paper_scene(Kind::Three, &options).expect("valid"),
        q0: dvector![0.02, -0.1],
        v0: dvector![0.0, 0.3],
    }
}

/// Two coupled masses without damping or forcing, one elastic stop on either side.
fn elastic_pair() -> Case {
    let rows = |a: [f64; 4]| DMatrix::from_row_slice(2, 2, &a);
    let system = linear(
        rows([2.0, 0.5, 0.5, 1.0]),
        dvector![0.0, 0.0],
        rows([5.0, -1.0, -1.0, 3.0]),
    );
    let stops = [upper(0, 0.2, 1.0), lower(dvector![0.5, 1.0], 0.15, 1.0)];
    Case {
        scene: scene(system, Forcing::Unforced, stops),
        q0: dvector![0.1, 0.0],
        v0: dvector![0.5, -0.3],
    }
}

// --- shallow contacts ------------------------------------------------------------------------------------------------

/// The resonant oscillator of the torture set, `c/2m = 0.05`, at rest at t = 0, with a wall.
fn resonant(wall: f64) -> Case {
    let w = (1.0f64 - 0.05 * 0.05).sqrt();
    let stop = upper(0, wall, 0.8);
    Case {
        scene: oscillator(0.1, harmonic(&[1.0], w, 0.0), [stop]),
        q0: dvector![0.0],
        v0: dvector![0.0],
    }
}

/// Times and heights of its peaks without the wall, from exact flights: the zeros of the velocity, bisected.
fn peaks() -> Vec<(f64, f64)> {
    let run = resonant(100.0).run((0.0, 60.0), &exact(1e-9));
    let at = |t: f64| run.state(t, ImpactSide::After).expect("kept");
    let speed = |t: f64| at(t).1[0];
    let step = 0.01;
    let falls = (1..5999)
        .map(|i| f64::from(i) * step)
        .filter(|&t| speed(t) > 0.0 && speed(t + step) <= 0.0);
    falls
        .map(|t| {
            let (mut low, mut high) = (t, t + step);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if speed(middle) > 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            (low, at(low).0[0])
        })
        .collect()
}

/// Twice the wall's distance: the size of the terms of the gap in contact. Ten tolerances, `10 (atol + rtol size)`.
fn margin(rtol: f64, wall: f64) -> f64 {
    10.0 * rtol * (1e-3 + 2.0 * wall)
}

/// The excursions over a wall of the motion without it: depth, and the trough behind, up to which a contact counts.
fn excursions(peaks: &[(f64, f64)], wall: f64) -> Vec<(f64, f64)> {
    let over = peaks.windows(2).filter(|p| p[0].1 > wall);
    over.map(|p| (p[0].1 - wall, 0.5 * (p[0].0 + p[1].0)))
        .collect()
}

#[test]
fn no_contact_deeper_than_the_error_of_the_motion_is_missed() {
    // A contact is missed if the first impact of a run comes after the end of the first excursion, of the motion without a
    // wall, that is deeper than two tolerances, which are left to the error of the motion itself: 26 depths below each of 8 peaks, at
    // every tolerance.
    let peaks = peaks();
    let cases = METHODS.iter().flat_map(|of| (3..=12).map(move |k| (of, k)));
    for (&(method, _, off), exponent) in cases {
        let rtol = 10f64.powi(-exponent);
        let mut due = 0;
        for &(time, height) in &peaks[..8] {
            for step in 0..26 {
                let depth = 10f64.powf(-6.0 + 0.2 * f64::from(step));
                let wall = height - depth;
                let options = SimulateOptions {
                    max_impacts: Some(1),
                    ..steps(method, rtol)
                };
                let deep = 0.2 * off * margin(rtol, wall);
                let over = excursions(&peaks, wall);
                let run = resonant(wall).run((0.0, time + 4.0), &options);
                let label = format!("{method:?} {rtol:e}, peak at {time}, depth {depth:e}");
                if let Some((_, until)) = over.iter().find(|x| x.0 > deep && x.1 < time + 4.0) {
                    due += 1;
                    let hit = run.impacts().first().map(|impact| impact.time);
                    assert!(hit.is_some_and(|t| t < *until), "missed: {label}, {hit:?}");
                }
            }
        }
        if exponent >= 9 && off == 1.0 {
            assert_eq!(due, 208);
        }
    }
}

#[test]
fn the_margin_is_small() {
    // At rtol 1e-8 every contact deeper than 1e-6 of the height is an impact.
    let peaks = peaks();
    for (method, ..) in METHODS {
        for &(time, height) in &peaks[..8] {
            for factor in [1.0, 1.3, 2.0, 5.0] {
                let wall = height * (1.0 - 1e-6 * factor);
                let options = SimulateOptions {
                    max_impacts: Some(1),
                    ..steps(method, 1e-8)
                };
                let run = resonant(wall).run((0.0, time + 3.0), &options);
                assert_eq!(run.impacts().len(), 1, "{method:?} {time} {factor}");
            }
        }
    }
}

// --- order -----------------------------------------------------------------------------------------------------------

/// The slope of a line through points, by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2))
}

#[test]
fn the_end_is_of_the_order_of_its_method_with_impacts_in_between() {
    // The error of the last state against the mean step, over five decades of tolerance.
    for (linear, (method, least, _)) in [true, false]
        .into_iter()
        .flat_map(|linear| METHODS.map(|of| (linear, of)))
    {
        let case = pendulums(linear);
        let span = (0.0, 60.0);
        let truth = if linear {
            case.run(span, &exact(1e-13))
        } else {
            case.run(span, &rk45(2e-14))
        };
        assert!(truth.impacts().len() >= 5);
        let points: Vec<(f64, f64)> = (0..11)
            .map(|step| {
                let rtol = 10f64.powf(-5.0 - 0.5 * f64::from(step));
                let run = case.run(span, &steps(method, rtol));
                assert_eq!(run.impacts().len(), truth.impacts().len());
                let h = span.1 / run.stats().n_steps as f64;
                (h.ln(), apart(&end(&run), &end(&truth)).ln())
            })
            .collect();
        let order = slope(&points);
        assert!(order >= least, "linear {linear}, {method:?}: {order}");
    }
}

// --- agreement with exact flights --------------------------------------------------------------------------------------

/// A linear scene of one to three coordinates and stops at rest inside its stops, some forced, some stiff.
fn random_case(random: &mut Random) -> Case {
    let n = 1 + random.below(3);
    let positive = |random: &mut Random, least: f64| {
        let a = random.matrix(n);
        &a * a.transpose() + DMatrix::identity(n, n) * least
    };
    let mass = positive(random, 0.5);
    let (mut stiffness, mut damping) = (positive(random, 0.5) * 2.0, positive(random, 0.1) * 0.1);
    if random.unit() < 0.2 {
        // One stiff direction, well damped.
        let d = random.vector(n);
        stiffness += &d * d.transpose() * 1e4;
        damping += &d * d.transpose() * 30.0;
    }
    let forcing = if random.unit() < 0.6 {
        let force = random.vector(n).map(|f| (2.0 * f).into());
        Harmonic::new(force, random.between(0.5, 3.0), random.between(0.0, 6.0))
            .expect("valid")
            .into()
    } else {
        Forcing::Unforced
    };
    let count = 1 + random.below(3);
    let stops: Vec<Stop> = (0..count)
        .map(|_| {
            let side = if random.unit() < 0.5 {
                Side::Upper
            } else {
                Side::Lower
            };
            let (clearance, restitution) = (random.between(0.1, 0.5), random.between(0.5, 1.0));
            let stop = upper(random.vector(n), clearance, restitution);
            stop.on_side(side)
        })
        .collect();
    let system = linear(mass, damping, stiffness);
    Case {
        scene: scene(system, forcing, stops),
        q0: DVector::zeros(n),
        v0: random.vector(n) * 2.0,
    }
}

/// The stops of a scene that was drawn.
fn planes(scene: &Scene) -> impl Iterator<Item = &Stop> {
    scene.stops().iter().map(|stop| match stop {
        Constraint::Stop(plane) => plane,
        _ => unreachable!("only planes were drawn"),
    })
}

/// By how much the time and approach of each impact of a motion moves with the state at the start or between any two impacts
/// before it, or with the clearances, per unit; shorter than the impacts where a state 1e-8 away, or a gap within 1.5 times the margin
/// of steps, makes other ones.
fn condition(case: &Case, truth: &Trajectory, options: &SimulateOptions) -> Vec<f64> {
    const AWAY: f64 = 1e-8;
    let (impacts, n) = (truth.impacts(), case.q0.len());
    let mut worst = vec![0.0f64; impacts.len()];
    let mut note = |first: usize, other: &[Impact], away: f64| {
        let same = impacts[first..].iter().zip(other);
        let same = same.take_while(|(a, b)| a.stop == b.stop && (a.time - b.time).abs() < 1e-3);
        let shifts: Vec<f64> = same
            .map(|(a, b)| (a.time - b.time).abs().max((a.approach - b.approach).abs()) / away)
            .collect();
        worst.truncate(first + shifts.len());
        for (worst, shift) in worst.iter_mut().skip(first).zip(shifts) {
            *worst = worst.max(shift);
        }
    };
    // Of the size of the terms of a gap in contact, twice the clearance.
    let clearances: Vec<f64> = planes(&case.scene).map(Stop::clearance).collect();
    let widest = clearances.iter().copied().fold(0.0, f64::max);
    let width = 1.5 * margin(options.solver.rtol, widest);
    for moved in [-width, width] {
        let there = clearances.iter().map(|c| c + moved).collect();
        let scene = case
            .scene
            .replace(Change::EachStop(StopNumber::Clearance, there))
            .expect("valid");
        let run = simulate(&scene, &case.q0, &case.v0, truth.span(), options).expect("runs");
        note(0, run.impacts(), width);
    }
    for first in 0..impacts.len() {
        let before = if first == 0 {
            truth.span().0
        } else {
            0.5 * (impacts[first - 1].time + impacts[first].time)
        };
        let (q, v) = truth.state(before, ImpactSide::After).expect("kept");
        for k in 0..2 * n {
            let (mut q, mut v) = (q.clone(), v.clone());
            let entry = if k < n { &mut q[k] } else { &mut v[k - n] };
            *entry += AWAY;
            // Inside a stop: nothing is known from here on.
            let run = simulate(&case.scene, &q, &v, (before, truth.span().1), options);
            note(first, run.as_ref().map_or(&[], |run| run.impacts()), AWAY);
        }
    }
    worst
}

#[test]
fn steps_agree_with_exact_flights_impact_by_impact() {
    // The runs are compared, within ten tolerances times one and the condition, up to the first impact of which that leaves 1e-3 unknown: where a contact is near to grazing, as deep as the margin, or at almost the
    // same time as one of another stop, the condition says so or is not known. An accumulation is compared down to speeds of
    // 1e-5.
    let cases = Cases::new(17, 200);
    let (mut compared, mut all) = (0, 0);
    for (k, mut random) in cases.each() {
        let case = random_case(&mut random);
        let rtol = 10f64.powf(random.between(-10.0, -5.0));
        let (method, _, off) = METHODS[k % METHODS.len()];
        let span = (0.0, 12.0);
        let fine: Vec<f64> = (0..=6000).map(|i| f64::from(i) * 0.002).collect();
        let limited = |options: SimulateOptions| SimulateOptions {
            max_impacts: Some(12),
            ..options
        };
        let options = limited(SimulateOptions {
            t_eval: Some(fine),
            keep: Keep::Impacts,
            ..steps(method, rtol)
        });
        let run = case.run(span, &options);
        let truth = case.run(span, &limited(exact(rtol)));
        let condition = condition(&case, &truth, &limited(exact(rtol)));
        let scale = 1.0 + case.v0.amax();
        all += truth.impacts().len();
        for (j, amplification) in condition.iter().enumerate() {
            let allowed = 10.0 * off * rtol * scale * (1.0 + amplification);
            let a = &truth.impacts()[j];
            let close = truth.impacts().get(j + 1);
            let close = close.is_some_and(|b| b.stop != a.stop && b.time - a.time < allowed);
            if allowed > 1e-3 || a.approach < 1e-5 || close {
                break;
            }
            let label = format!(
                "case {k}, impact {j}, {method:?}, rtol {rtol:e}, condition {amplification:e}"
            );
            let Some(b) = run.impacts().get(j) else {
                panic!("{label}: missing at {} {}", a.time, run.message());
            };
            assert_eq!(a.stop, b.stop, "{label}");
            let error = (a.time - b.time).abs().max((a.approach - b.approach).abs());
            assert!(error <= allowed, "{label}: {error:e} > {allowed:e}");
            compared += 1;
        }
        let (times, q, _) = run.samples().expect("asked for");
        for (i, time) in times.iter().enumerate() {
            let q = q.row(i).transpose();
            let gaps = case.scene.gaps(&q).expect("planes");
            for (plane, gap) in planes(&case.scene).zip(&gaps) {
                let normal = plane.normal_vector(q.len(), "stop").expect("valid");
                let terms = normal.component_mul(&q).abs().sum() + plane.clearance();
                let margin = 10.0 * (1e-3 * rtol * normal.abs().sum() + rtol * terms);
                assert!(*gap >= -off * margin, "case {k}: {gap:e} at {time}");
            }
        }
    }
    assert!(
        cases.is_one() || 4 * compared >= 3 * all,
        "{compared} of {all}"
    );
}

// --- laws --------------------------------------------------------------------------------------------------------------

#[test]
fn elastic_motion_keeps_its_energy_and_can_be_reversed() {
    let case = elastic_pair();
    let rows = |a: [f64; 4]| DMatrix::from_row_slice(2, 2, &a);
    let (m, k) = (rows([2.0, 0.5, 0.5, 1.0]), rows([5.0, -1.0, -1.0, 3.0]));
    let energy = |q: &DVector<f64>, v: &DVector<f64>| 0.5 * (v.dot(&(&m * v)) + q.dot(&(&k * q)));
    let at_start = energy(&case.q0, &case.v0);
    let cases = METHODS
        .iter()
        .flat_map(|of| [1e-6, 1e-9, 1e-12].map(|rtol| (of, rtol)));
    for (&(method, _, off), rtol) in cases {
        let run = case.run((0.0, 30.0), &steps(method, rtol));
        assert!(run.impacts().len() > 10);
        let (q, v) = run.last();
        assert!(
            (energy(q, v) / at_start - 1.0).abs() < 100.0 * off * rtol,
            "{method:?} {rtol:e}"
        );
        let scene = case.scene.clone();
        let back = Case {
            scene,
            q0: q.clone(),
            v0: -v,
        };
        let back = back.run((0.0, 30.0), &steps(method, rtol));
        assert_eq!(back.impacts().len(), run.impacts().len());
        let (q, v) = back.last();
        let error = (q - &case.q0).amax().max((v + &case.v0).amax());
        assert!(
            error < 1000.0 * off * rtol,
            "{method:?} {rtol:e}: {error:e}"
        );
    }
}

#[test]
fn a_run_cut_in_two_is_one() {
    let cases = METHODS
        .iter()
        .flat_map(|of| [true, false].map(|linear| (of, linear)));
    for (&(method, _, off), linear) in cases {
        let case = pendulums(linear);
        let options = steps(method, 1e-9);
        let whole = case.run((0.0, 60.0), &options);
        for cut in [1.0, 17.3, 31.0, 59.9] {
            let first = case.run((0.0, cut), &options);
            let scene = case.scene.clone();
            let (q0, v0) = (first.last().0.clone(), first.last().1.clone());
            let rest = Case { scene, q0, v0 }.run((cut, 60.0), &options);
            let count = first.impacts().len() + rest.impacts().len();
            assert_eq!(count, whole.impacts().len(), "{method:?} {cut}");
            assert!(
                apart(&end(&rest), &end(&whole)) < 1e-8 * off,
                "{method:?} {cut}"
            );
        }
    }
}

#[test]
fn what_is_asked_for_does_not_change_the_motion() {
    let case = pendulums(false);
    let span = (0.0, 50.0);
    let times: Vec<f64> = (0..=333).map(|i| f64::from(i) * 50.0 / 333.0).collect();
    let cases = METHODS
        .iter()
        .flat_map(|of| [Keep::Motion, Keep::Impacts, Keep::Final].map(|keep| (of.0, keep)));
    for (method, keep) in cases {
        let whole = case.run(span, &steps(method, 1e-7));
        for t_eval in [None, Some(vec![]), Some(times.clone()), Some(vec![50.0])] {
            let options = SimulateOptions {
                keep,
                t_eval: t_eval.clone(),
                ..steps(method, 1e-7)
            };
            let run = case.run(span, &options);
            assert_eq!(end(&run), end(&whole));
            // A dense output may take evaluations of its own.
            let steps = |run: &Trajectory| (run.stats().n_steps, run.stats().n_flights);
            assert_eq!(steps(&run), steps(&whole));
            if keep != Keep::Final {
                assert_eq!(run.impacts(), whole.impacts());
            }
            let Some(asked) = t_eval else { continue };
            let (t, q, v) = run.samples().expect("asked for");
            assert_eq!(t, asked);
            for (i, t) in t.iter().enumerate() {
                let (q1, v1) = whole.state(*t, ImpactSide::After).expect("kept");
                assert!((q.row(i).transpose() - q1).amax() < 1e-15);
                assert!((v.row(i).transpose() - v1).amax() < 1e-15);
            }
            if let Some(i) = t.iter().position(|&t| t == 50.0) {
                // The quartic ends at the step's end but for its rounding.
                assert!((q.row(i).transpose() - run.last().0).amax() < 1e-15);
            }
        }
    }
}

#[test]
fn the_sides_of_an_impact_follow_its_law() {
    for (method, ..) in METHODS {
        sides_follow_the_law(method);
    }
}

fn sides_follow_the_law(method: Method) {
    let case = pendulums(true);
    let run = case.run((0.0, 50.0), &steps(method, 1e-9));
    for impact in run.impacts() {
        let (q, before) = run.state(impact.time, ImpactSide::Before).expect("kept");
        let (same, after) = run.state(impact.time, ImpactSide::After).expect("kept");
        assert!((q - same).amax() < 1e-14);
        assert!((before[impact.stop] - impact.approach).abs() < 1e-13);
        assert!((after[impact.stop] + 0.9 * impact.approach).abs() < 1e-13);
        let other = 1 - impact.stop;
        assert!((before[other] - after[other]).abs() < 1e-14);
    }
    let options = SimulateOptions {
        t_eval: Some(run.impacts().iter().map(|impact| impact.time).collect()),
        ..steps(method, 1e-9)
    };
    let (_, _, v) = case
        .run((0.0, 50.0), &options)
        .samples()
        .expect("asked for");
    for (i, impact) in run.impacts().iter().enumerate() {
        assert!((v[(i, impact.stop)] + 0.9 * impact.approach).abs() < 1e-13);
    }
}

#[test]
fn a_run_ends_after_its_impacts_or_at_once() {
    let case = pendulums(false);
    let whole = case.run((0.0, 100.0), &rk45(1e-8));
    for count in [0, 1, 5] {
        let options = SimulateOptions {
            max_impacts: Some(count),
            ..rk45(1e-8)
        };
        let run = case.run((0.0, 100.0), &options);
        assert_eq!(run.status(), Status::MaxImpacts);
        assert_eq!(run.impacts(), &whole.impacts()[..count]);
        let time = run.impacts().last().map_or(0.0, |impact| impact.time);
        assert_eq!(run.span().1, time);
    }
    let none = case.run((3.0, 3.0), &rk45(1e-8));
    assert_eq!((none.status(), none.stats().n_steps), (Status::Finished, 0));
    assert_eq!((none.last().0, none.last().1), (&case.q0, &case.v0));
}

#[test]
fn a_start_on_the_stop_strikes_or_leaves_it() {
    // q'' = -1 above a floor at 0: 2 v e until the next contact.
    let ball = |v: f64| Case {
        scene: crate::scenes::ball(0.5),
        q0: dvector![0.0],
        v0: dvector![v],
    };
    for (method, ..) in METHODS {
        let down = ball(-1.0).run((0.0, 1.2), &steps(method, 1e-9));
        let times: Vec<f64> = down.impacts().iter().map(|impact| impact.time).collect();
        assert!(times.len() == 2 && times[0] == 0.0 && (times[1] - 1.0).abs() < 1e-12);
        assert!((down.impacts()[1].approach - 0.5).abs() < 1e-12);
        for v in [1.0, 1e-3, 1e-6] {
            // Higher and lower than the margin alike, the flight ends after 2 v, once it is seen to go on below the margin.
            let options = SimulateOptions {
                max_impacts: Some(1),
                ..steps(method, 1e-9)
            };
            let up = ball(v).run((0.0, 2.0 * v + 1e-4), &options);
            assert_eq!(up.impacts().len(), 1, "{v:e}");
            assert!((up.impacts()[0].time / (2.0 * v) - 1.0).abs() < 1e-9);
            assert!((up.impacts()[0].approach / v - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn counts_are_those_of_the_pair() {
    let case = pendulums(true);
    for rtol in [1e-4, 1e-7, 1e-10] {
        let stats = case.run((0.0, 200.0), &rk45(rtol)).stats();
        // Six per step tried; one where the motion starts anew: at its start and after each impact.
        let starts = 1 + stats.n_impacts;
        assert!(stats.n_rhs >= 6 * (stats.n_steps + 1) + starts);
        assert_eq!((stats.n_rhs - starts) % 6, 0);
        assert_eq!(stats.n_flights, stats.n_impacts + 1);
    }
    let stats = case.run((0.0, 200.0), &exact(1e-9)).stats();
    assert_eq!((stats.n_rhs, stats.n_steps), (0, 0));
}

#[test]
fn a_motion_that_blows_up_ends() {
    // q'' = w^2 q grows beyond the doubles; the span is as long as it pleases.
    let cases = METHODS
        .iter()
        .flat_map(|of| [10.0f64, 1e4, 1e8].map(|w| (of.0, w)));
    for (method, w) in cases {
        let scene = scene(unit_mass(0.0, -w * w), Forcing::Unforced, [] as [Stop; 0]);
        let case = Case {
            scene,
            q0: dvector![1.0],
            v0: dvector![0.0],
        };
        let options = steps(method, 1e-6);
        match simulate(&case.scene, &case.q0, &case.v0, (0.0, 1e6), &options) {
            Ok(run) => {
                assert_eq!(run.status(), Status::StepUnderflow, "{w:e}");
                assert!(end(&run).iter().all(|x| x.is_finite()), "{w:e}");
                assert!(run.span().1 < 800.0 / w);
            }
            Err(error) => assert!(error.to_string().contains("grows beyond"), "{error}"),
        }
    }
}

#[test]
fn stiffness_is_said() {
    // q'' + 1e4 q' + q = 0: the step is held to 3.3e-4 by stability once the fast part is gone.
    let stiff = Case {
        scene: oscillator(1e4, Forcing::Unforced, [] as [Stop; 0]),
        q0: dvector![1.0],
        v0: dvector![0.0],
    };
    let run = stiff.run((0.0, 1.0), &rk45(1e-4));
    assert!(run.message().contains("stiff"), "{}", run.message());
    assert_eq!(run.status(), Status::Finished);
    for linear in [true, false] {
        let run = pendulums(linear).run((0.0, 100.0), &rk45(1e-6));
        assert!(!run.message().contains("stiff"), "{}", run.message());
    }
}

#[test]
fn a_long_run_keeps_nothing_but_its_end() {
    let case = pendulums(true);
    let options = SimulateOptions {
        keep: Keep::Final,
        max_impacts: Some(100_000),
        ..rk45(1e-5)
    };
    let run = case.run((0.0, 1e9), &options);
    assert_eq!(run.status(), Status::MaxImpacts);
    assert_eq!(run.stats().n_impacts, 100_000);
    assert!(run.impacts().is_empty() && run.grazes().is_empty());
    assert!(run.segments().is_err() && run.state(1.0, ImpactSide::After).is_err());
}
