//! A referee of derivatives of runs: random scenes with every kind of segment, against differences of sixth order of an own simulator
//! (`twin.rs`) whose runs beside have the same course.

use crate::draw::{Case, drawn};
use crate::own::Own;
use crate::random::{Cases, Random};
use crate::soak;
use crate::twin::{Course, Happening, Twin};
use nalgebra::{Complex, DVector, dvector};
use vibroimpact::{
    Constraint, Forcing, Harmonic, LinearSystem, Load, Motion, NonlinearSystem, Parameter, Scene,
    Signal, SimulateOptions, Solver, Stop, StopMotion, StopNumber, System, derivatives_of_run,
    simulate,
};

const SEED: u64 = 57;
const COUNT: usize = 240;
/// Steps of differences, in parts of the scale of a number: the first by which the runs beside are alike, and their differences agree.
const STEPS: [f64; 3] = [1e-3, 1e-4, 1e-5];
/// Of two differences of fourth order, of all derivatives at a time.
const AGREED: f64 = 1e-6;
/// Of a derivative, and of a state, in parts of the larger of one and the largest at its time.
const ROOM: f64 = 1e-6;
const SAME: f64 = 1e-7;

impl Case {
    /// The scene of the library.
    fn scene(&self) -> Scene {
        let twin = &self.twin;
        let parts = [&twin.mass, &twin.damping, &twin.stiffness];
        let [mass, damping, stiffness] = parts.map(Clone::clone);
        let load = twin.load.clone();
        let system: System = if self.is_nonlinear {
            let own = Own {
                mass,
                damping,
                stiffness,
                load,
            };
            NonlinearSystem::new(own).expect("valid").into()
        } else {
            let system = LinearSystem::new(mass, damping, stiffness).expect("valid");
            system.with_load(load).expect("valid").into()
        };
        let carriers: Vec<usize> = twin
            .stops
            .iter()
            .filter_map(|own| own.motion.map(|own| own.0))
            .collect();
        let tones = twin
            .tones
            .iter()
            .enumerate()
            .filter(|(j, _)| !carriers.contains(j));
        let mut forcings: Vec<Forcing> = tones
            .map(|(_, own)| {
                let force = own.re.zip_map(&own.im, Complex::new);
                Harmonic::new(force, own.w, own.phase)
                    .expect("valid")
                    .into()
            })
            .collect();
        if let Some(own) = &twin.samples {
            let signal = Signal::samples(&own.times, &own.values).expect("valid");
            forcings.push(
                Load::new(own.direction.clone(), signal)
                    .expect("valid")
                    .into(),
            );
        }
        let forcing = if forcings.is_empty() {
            Forcing::Unforced
        } else {
            Forcing::Several(forcings)
        };
        let stops = twin.stops.iter().zip(&self.reactions).map(|(own, law)| {
            let motion = own.motion.map(|(tone, amplitude)| {
                let tone = &twin.tones[tone];
                let harmonic = Harmonic::new(dvector![amplitude.into()], tone.w, tone.phase);
                StopMotion::harmonic(harmonic.expect("valid")).expect("valid")
            });
            let stop =
                Stop::new(own.normal.clone(), own.clearance, own.restitution).expect("valid");
            stop.with_reaction(law.clone())
                .expect("valid")
                .with_motion(motion)
        });
        let stops: Vec<Constraint> = stops.map(Into::into).collect();
        Scene::new(system, forcing, stops).expect("valid")
    }

    /// The numbers by which it is differentiated.
    fn numbers(&self, random: &mut Random) -> Vec<Parameter> {
        let stop = random.below(self.twin.stops.len());
        let mut all = vec![Parameter::CLEARANCE.of(stop)];
        let has_force = self.twin.samples.is_some() || self.has_forcing();
        if self.twin.stops[stop].restitution > 0.0 {
            all.push(Parameter::RESTITUTION.of(stop));
        }
        if !self.twin.tones.is_empty() {
            all.push(Parameter::Frequency);
        }
        if has_force && random.chance(50) {
            all.push(Parameter::ForcingScale);
        }
        if !self.is_nonlinear && random.chance(50) {
            all.push(Parameter::DampingScale);
        }
        all
    }

    fn has_forcing(&self) -> bool {
        self.twin.tones.iter().any(|own| own.re.amax() > 0.0)
    }

    /// The twin in which a number is larger.
    fn beside(&self, number: Parameter, by: f64) -> Twin {
        let mut twin = self.twin.clone();
        match number {
            Parameter::OneStop(StopNumber::Clearance, i) => twin.stops[i].clearance += by,
            Parameter::OneStop(StopNumber::Restitution, i) => twin.stops[i].restitution += by,
            Parameter::DampingScale => twin.damping *= 1.0 + by,
            Parameter::ForcingScale => {
                for tone in &mut twin.tones {
                    tone.re *= 1.0 + by;
                    tone.im *= 1.0 + by;
                }
                if let Some(own) = &mut twin.samples {
                    own.values.iter_mut().for_each(|x| *x *= 1.0 + by);
                }
            }
            Parameter::Frequency => {
                let ratio = 1.0 + by / self.lowest();
                twin.tones.iter_mut().for_each(|tone| tone.w *= ratio);
            }
            other => panic!("{other}"),
        }
        twin
    }

    fn lowest(&self) -> f64 {
        self.twin
            .tones
            .iter()
            .map(|tone| tone.w)
            .fold(f64::INFINITY, f64::min)
    }

    /// By how much a number may change and the motion bend little.
    fn scale(&self, number: Parameter) -> f64 {
        match number {
            Parameter::Frequency => {
                let fastest = self
                    .twin
                    .tones
                    .iter()
                    .map(|tone| tone.w)
                    .fold(0.0, f64::max);
                self.lowest() / (fastest * self.span.0.abs().max(self.span.1.abs()))
            }
            Parameter::OneStop(StopNumber::Restitution, i) => 1.0 - self.twin.stops[i].restitution,
            _ => 1.0,
        }
    }

    fn run(&self, twin: &Twin) -> Option<Course> {
        twin.run(&self.q, &self.v, self.span, &self.times)
    }

    /// Derivatives of the twin's states by a number; `None` where there are none that are surely right.
    fn differences(&self, number: Parameter, own: &Course) -> Option<Vec<DVector<f64>>> {
        STEPS.iter().find_map(|part| {
            let step = part * self.scale(number);
            let central = |steps: f64| -> Option<Vec<DVector<f64>>> {
                let h = steps * step;
                let sides = [h, -h].map(|h| self.run(&self.beside(number, h)));
                let [Some(ahead), Some(behind)] = sides else {
                    return None;
                };
                let is_like = |other: &Course| other.happenings == own.happenings;
                let pairs = ahead.states.iter().zip(&behind.states);
                (is_like(&ahead) && is_like(&behind))
                    .then(|| pairs.map(|(a, b)| (a - b) / (2.0 * h)).collect())
            };
            let [one, two, four] = [central(1.0)?, central(2.0)?, central(4.0)?];
            let mut all = Vec::new();
            for ((one, two), four) in one.iter().zip(&two).zip(&four) {
                let (fine, coarse) = ((one * 4.0 - two) / 3.0, (two * 4.0 - four) / 3.0);
                let best = (&fine * 16.0 - &coarse) / 15.0;
                if (fine - coarse).amax() > AGREED * best.amax().max(1.0) {
                    return None;
                }
                all.push(best);
            }
            Some(all)
        })
    }
}

/// What was compared, and what each kind of segment had of it.
#[derive(Default, Debug)]
struct Tally {
    compared: usize,
    chatters: usize,
    landings: usize,
    releases: usize,
    samples: usize,
    moving: usize,
    several: usize,
    nonlinear: usize,
    refused: usize,
    elsewhere: usize,
    wrong: Vec<String>,
}

impl Tally {
    fn case(&mut self, number: usize, mut random: Random) {
        let case = drawn(&mut random);
        let Some(own) = case.run(&case.twin) else {
            return;
        };
        let near = |t: &f64| own.times.iter().any(|event| (event - t).abs() < 1e-3);
        if case.times.iter().any(near) || own.happenings.is_empty() {
            return;
        }
        let scene = case.scene();
        let options = SimulateOptions {
            solver: Solver {
                rtol: 1e-12,
                atol: Some(1e-14),
                ..Solver::default()
            },
            ..SimulateOptions::default()
        };
        let run = simulate(&scene, &case.q, &case.v, case.span, &options).expect("a run");
        let states = case.times.iter().map(|t| {
            let (q, v) = run.state(*t, vibroimpact::ImpactSide::After).expect("kept");
            DVector::from_iterator(2 * q.len(), q.iter().chain(v.iter()).copied())
        });
        if states
            .zip(&own.states)
            .any(|(x, y)| (x - y).amax() > SAME * y.amax().max(1.0))
        {
            self.elsewhere += 1;
            return;
        }
        let numbers = case.numbers(&mut random);
        let found = derivatives_of_run(&run, &numbers, &case.times).expect("an answer");
        if found.reason.is_some() {
            self.refused += 1;
        }
        for (parameter, by) in numbers.iter().zip(&found.by) {
            let Some(wanted) = case.differences(*parameter, &own) else {
                continue;
            };
            let mut was_compared = false;
            for (i, wanted) in wanted.iter().enumerate() {
                let row = by.row(i).transpose();
                if row.iter().any(|x| x.is_nan()) {
                    continue;
                }
                was_compared = true;
                let off = (&row - wanted).amax();
                if off > ROOM * wanted.amax().max(1.0) {
                    let t = case.times[i];
                    self.wrong.push(format!(
                        "{number} {parameter} at {t}: off by {off:e}, {} and {}; {:?}, apart from {:?}",
                        row.transpose(), wanted.transpose(), own.happenings, found.reason,
                    ));
                    break;
                }
            }
            if was_compared {
                self.compared += 1;
                let has =
                    |what: fn(&Happening) -> bool| usize::from(own.happenings.iter().any(what));
                self.chatters += has(|own| matches!(own, Happening::Chatter(_)));
                self.landings += has(|own| matches!(own, Happening::Landing(_)));
                self.releases += has(|own| matches!(own, Happening::Release(_)));
                self.samples += usize::from(case.twin.samples.is_some());
                self.moving += usize::from(case.twin.stops.iter().any(|own| own.motion.is_some()));
                self.several += usize::from(case.twin.stops.len() > 1);
                self.nonlinear += usize::from(case.is_nonlinear);
            }
        }
    }
}

#[test]
fn derivatives_of_random_runs_are_differences_of_a_twin() {
    let cases = Cases::new(SEED, COUNT);
    let mut tally = Tally::default();
    for (number, random) in cases.each() {
        tally.case(number, random);
    }
    soak::note(
        "derivatives of runs",
        cases.seed,
        tally.compared,
        tally.wrong.len(),
    );
    println!("{}", tally.wrong.join("\n"));
    let count = tally.wrong.len();
    tally.wrong.clear();
    println!("{tally:?}");
    assert!(count == 0, "{count} are wrong");
    for (seen, in_a_hundred) in [
        (tally.compared, 100),
        (tally.chatters, 15),
        (tally.landings, 10),
        (tally.releases, 5),
        (tally.samples, 20),
        (tally.moving, 10),
        (tally.several, 30),
        (tally.nonlinear, 5),
    ] {
        assert!(cases.have(seen, in_a_hundred), "{tally:?}");
    }
}
