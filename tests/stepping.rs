//! Laws of motions taken in Runge-Kutta steps (theory 8), most of them against exact flights of the same scene. Random cases:
//! `VIBROIMPACT_CASES` (default 200) and `VIBROIMPACT_SEED`.

#[path = "common/random.rs"]
mod random;

use nalgebra::{DMatrix, DVector, dvector};
use random::{Random, number};
use vibroimpact::{
    Forcing, Harmonic, Impact, ImpactSide, Keep, Kind, LinearSystem, Method, PaperOptions, Scene,
    Side, SimulateOptions, Status, Stop, Trajectory, paper_scene, simulate,
};

fn rk45(rtol: f64) -> SimulateOptions {
    SimulateOptions {
        method: Method::Rk45,
        rtol,
        atol: 1e-3 * rtol,
        ..Default::default()
    }
}

fn exact(rtol: f64) -> SimulateOptions {
    SimulateOptions {
        method: Method::Exact,
        ..rk45(rtol)
    }
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

fn oscillator(damping: f64, stiffness: f64, forcing: Forcing, stop: Option<Stop>) -> Scene {
    let system = LinearSystem::new(dvector![1.0], dvector![damping], dvector![stiffness]);
    Scene::new(system.expect("valid"), forcing, stop).expect("valid")
}

/// Two coupled masses without damping or forcing, one elastic stop on either side.
fn elastic_pair() -> Case {
    let rows = |a: [f64; 4]| DMatrix::from_row_slice(2, 2, &a);
    let system = LinearSystem::new(
        rows([2.0, 0.5, 0.5, 1.0]),
        dvector![0.0, 0.0],
        rows([5.0, -1.0, -1.0, 3.0]),
    );
    let stops = [
        Stop::new(0, 0.2, 1.0).expect("valid"),
        Stop::new(dvector![0.5, 1.0], 0.15, 1.0)
            .expect("valid")
            .on_side(Side::Lower),
    ];
    Case {
        scene: Scene::new(system.expect("valid"), Forcing::Unforced, stops).expect("valid"),
        q0: dvector![0.1, 0.0],
        v0: dvector![0.5, -0.3],
    }
}

// --- shallow contacts ------------------------------------------------------------------------------------------------

/// The resonant oscillator of the torture set, `c/2m = 0.05`, at rest at t = 0, with a wall.
fn resonant(wall: f64) -> Case {
    let w = (1.0f64 - 0.05 * 0.05).sqrt();
    let force = Harmonic::new(dvector![1.0.into()], w, 0.0).expect("valid");
    let stop = Stop::new(0, wall, 0.8).expect("valid");
    Case {
        scene: oscillator(0.1, 1.0, force.into(), Some(stop)),
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

/// Twice the wall's distance: the size of the terms of the gap in contact. `10 (atol + rtol size)` of theory 8.
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
fn no_contact_deeper_than_the_margin_is_missed() {
    // A contact is missed if the first impact of a run comes after the end of the first excursion, of the motion without a
    // wall, that is deeper than the margin. 26 depths below each of 8 peaks, at every tolerance.
    let peaks = peaks();
    for exponent in 3..=12 {
        let rtol = 10f64.powi(-exponent);
        let (mut due, mut noticed) = (0, 0);
        for &(time, height) in &peaks[..8] {
            for step in 0..26 {
                let depth = 10f64.powf(-6.0 + 0.2 * f64::from(step));
                let wall = height - depth;
                let options = SimulateOptions {
                    max_impacts: Some(1),
                    ..rk45(rtol)
                };
                let over = excursions(&peaks, wall);
                let run = resonant(wall).run((0.0, time + 4.0), &options);
                let label = format!("rtol {rtol:e}, peak at {time}, depth {depth:e}");
                if let Some((_, until)) = over
                    .iter()
                    .find(|x| x.0 > margin(rtol, wall) && x.1 < time + 4.0)
                {
                    due += 1;
                    let hit = run.impacts().first().map(|impact| impact.time);
                    assert!(hit.is_some_and(|t| t < *until), "missed: {label}, {hit:?}");
                }
                noticed += usize::from(!run.impacts().is_empty() || !run.grazes().is_empty());
            }
        }
        println!("rtol {rtol:e}: {due} deeper than the margin, {noticed} of 208 noticed");
        if exponent >= 9 {
            assert_eq!(due, 208);
        }
    }
}

#[test]
fn the_margin_is_small() {
    // At rtol 1e-8 every contact deeper than 1e-6 of the height is an impact.
    let peaks = peaks();
    for &(time, height) in &peaks[..8] {
        for factor in [1.0, 1.3, 2.0, 5.0] {
            let wall = height * (1.0 - 1e-6 * factor);
            let options = SimulateOptions {
                max_impacts: Some(1),
                ..rk45(1e-8)
            };
            let run = resonant(wall).run((0.0, time + 3.0), &options);
            assert_eq!(run.impacts().len(), 1, "{time} {factor}");
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
fn the_end_is_of_order_five_with_impacts_in_between() {
    // The error of the last state against the mean step, over five decades of tolerance.
    for linear in [true, false] {
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
                let run = case.run(span, &rk45(rtol));
                assert_eq!(run.impacts().len(), truth.impacts().len());
                let h = span.1 / run.stats().n_steps as f64;
                (h.ln(), apart(&end(&run), &end(&truth)).ln())
            })
            .collect();
        let order = slope(&points);
        println!("linear {linear}: order {order}, {points:?}");
        assert!(order >= 4.7, "linear {linear}: {order}");
    }
}
