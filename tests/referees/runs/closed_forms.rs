//! The referee itself, against closed forms.

use crate::runs::case::{Case, ForceCase, Push, StopCase};
use crate::runs::double_double::Dd;
use crate::runs::motion::Model;
use crate::runs::record::Record;
use crate::runs::simulator::follow;
use nalgebra::DMatrix;
use vibroimpact::Method;

fn oscillator(
    stiffness: f64,
    load: f64,
    force: Option<ForceCase>,
    restitution: f64,
    q0: f64,
    end: f64,
) -> Case {
    let one = |x: f64| DMatrix::from_element(1, 1, x);
    Case {
        label: String::new(),
        mass: one(1.0),
        damping: one(0.0),
        stiffness: one(stiffness),
        load: vec![load],
        force,
        more: Vec::new(),
        stops: vec![StopCase {
            normal: vec![1.0],
            clearance: 0.0,
            restitution,
            lower: true,
            push: Push::Inertia,
        }],
        q0: vec![q0],
        v0: vec![0.0],
        span: (0.0, end),
        method: Method::Exact,
        rtol: 1e-9,
        atol: 1e-12,
    }
}

fn run(case: &Case, samples: &[f64]) -> Record {
    let model = Model::new(case, &[1.0; 7]);
    let samples: Vec<Dd> = samples.iter().map(|&t| Dd::from(t)).collect();
    let start = model.start(case, &[1.0; 7]);
    follow(
        &model,
        start,
        Dd::from(case.span.1) - Dd::from(case.span.0),
        &samples,
        None,
        100_000,
    )
}

fn shaking(amplitude: f64, phase: f64) -> ForceCase {
    ForceCase {
        re: vec![amplitude],
        im: vec![0.0],
        frequency: 1.0,
        phase,
    }
}

#[test]
fn a_ball_comes_to_rest() {
    for e in [0.5, 0.9] {
        let record = run(&oscillator(0.0, -1.0, None, e, 1.0, 60.0), &[50.0]);
        let fall = 2f64.sqrt();
        assert!(record.hits.len() > 20, "{e} {}", record.hits.len());
        for (n, hit) in (0..30).zip(&record.hits) {
            let speed = fall * e.powi(n);
            let time = fall * (1.0 + 2.0 * e * (1.0 - e.powi(n)) / (1.0 - e));
            assert!((hit.time.to_f64() - time).abs() < 1e-14 * time);
            assert!((hit.approach - speed).abs() < 1e-14 * speed);
        }
        let end = fall * (1.0 + 2.0 * e / (1.0 - e));
        assert!((record.sticks[0].start - end).abs() < 1e-14 * end && record.sticks[0].end == 60.0);
        assert!(record.samples[0].iter().all(|x| x.abs() < 1e-25));
    }
}

#[test]
fn a_forced_oscillator_has_its_closed_form() {
    // q'' + 4 q = cos(t + 1), far from its stop: q = cos(t + 1)/3 + free motion.
    let mut case = oscillator(4.0, 0.0, Some(shaking(1.0, 1.0)), 0.5, 2.0, 30.0);
    case.stops[0].clearance = 5.0;
    for start in [0.0, 1e9, -1e6] {
        case.span = (start, start + 30.0);
        let times: Vec<f64> = (0..30).map(f64::from).collect();
        let record = run(&case, &times);
        let steady = |s: f64| {
            let (c, s) = (Dd::from(start) + Dd::from(s) + Dd::ONE).cos_sin();
            (c.to_f64() / 3.0, -s.to_f64() / 3.0)
        };
        let (a, b) = (2.0 - steady(0.0).0, -steady(0.0).1 / 2.0);
        for (t, x) in times.iter().zip(&record.samples) {
            let q = steady(*t).0 + a * (2.0 * t).cos() + b * (2.0 * t).sin();
            assert!((x[0] - q).abs() < 1e-14, "{start} {t}");
        }
    }
}

#[test]
fn a_plastic_ball_is_let_go_and_lands() {
    // Held while a cos(t + pi) <= 1, let go at t = pi - arccos(1/a).
    let shake = 1.2f64;
    let record = run(
        &oscillator(
            0.0,
            -1.0,
            Some(shaking(shake, std::f64::consts::PI)),
            0.0,
            0.0,
            12.0,
        ),
        &[],
    );
    let release = std::f64::consts::PI - (1.0 / shake).acos();
    assert!(record.sticks[0].start == 0.0 && (record.sticks[0].end - release).abs() < 1e-14);
    let height = |t: f64| {
        let s = t - release;
        -0.5 * s * s + shake * (t.cos() - release.cos()) + shake * release.sin() * s
    };
    let landing = record.hits[0].time.to_f64();
    assert!(landing > release && height(landing).abs() < 1e-14 && record.hits[0].departure == 0.0);
}

#[test]
fn a_sine_that_pulls_lets_go_at_once_and_one_that_presses_holds() {
    for (amplitude, held) in [(1.0, 0.0), (-1.0, std::f64::consts::PI)] {
        let record = run(
            &oscillator(
                0.0,
                0.0,
                Some(shaking(amplitude, -std::f64::consts::FRAC_PI_2)),
                0.5,
                0.0,
                6.0,
            ),
            &[5.0],
        );
        let stick = record.sticks.first().map_or(0.0, |s| s.end);
        assert!((stick - held).abs() < 1e-14, "{amplitude}: {stick}");
        let s = 5.0 - held;
        assert!((record.samples[0][0] - (s - s.sin())).abs() < 1e-13);
    }
}
