//! A scene as plain numbers, from which the referee and the library each make their own; printed as Rust code where they
//! disagree.

use nalgebra::{Complex, DMatrix, DVector};
use vibroimpact::{
    Coefficient, Forcing, Harmonic, LinearSystem, Method, Reaction, Result, Scene, Side,
    SimulateOptions, Solver, Stop,
};

/// Without loss at impacts a damped motion under a load bounces ever faster: no run is followed further.
pub const MOST_IMPACTS: usize = 1500;

#[derive(Debug, Clone, PartialEq)]
pub enum Push {
    Inertia,
    Coordinate,
    Direction(Vec<f64>),
}

/// A stop; `normal` and a given direction as of the upper side, both turned when `lower`.
#[derive(Debug, Clone)]
pub struct StopCase {
    pub normal: Vec<f64>,
    pub clearance: f64,
    pub restitution: f64,
    pub lower: bool,
    pub push: Push,
}

#[derive(Debug, Clone)]
pub struct ForceCase {
    pub re: Vec<f64>,
    pub im: Vec<f64>,
    pub frequency: f64,
    pub phase: f64,
}

#[derive(Debug, Clone)]
pub struct Case {
    pub label: String,
    pub mass: DMatrix<f64>,
    pub damping: DMatrix<f64>,
    pub stiffness: DMatrix<f64>,
    pub load: Vec<f64>,
    pub force: Option<ForceCase>,
    /// More forces, of frequencies of their own, beside a first.
    pub more: Vec<ForceCase>,
    pub stops: Vec<StopCase>,
    pub q0: Vec<f64>,
    pub v0: Vec<f64>,
    pub span: (f64, f64),
    pub method: Method,
    pub rtol: f64,
    pub atol: f64,
}

fn is_diagonal(a: &DMatrix<f64>) -> bool {
    let off = |i: usize, j: usize| i == j || a[(i, j)] == 0.0;
    (0..a.nrows()).all(|i| (0..a.ncols()).all(|j| off(i, j)))
}

impl StopCase {
    /// The normal towards the stop.
    pub fn outward(&self) -> Vec<f64> {
        let sign = if self.lower { -1.0 } else { 1.0 };
        self.normal.iter().map(|x| sign * x).collect()
    }

    pub fn gap(&self, q: &[f64]) -> f64 {
        let n = self.outward();
        self.clearance - n.iter().zip(q).map(|(n, q)| n * q).sum::<f64>()
    }
}

impl ForceCase {
    fn amplitudes(&self) -> impl Iterator<Item = Complex<f64>> {
        let parts = self.re.iter().zip(&self.im);
        parts.map(|(&re, &im)| Complex::new(re, im))
    }

    fn forcing(&self) -> Result<Forcing> {
        let amplitude = DVector::from_iterator(self.re.len(), self.amplitudes());
        Ok(Harmonic::new(amplitude, self.frequency, self.phase)?.into())
    }

    fn dump(&self) -> String {
        let z: Vec<String> = self
            .amplitudes()
            .map(|z| format!("Complex::new({:?}, {:?})", z.re, z.im))
            .collect();
        format!(
            "Harmonic::new(dvector![{}], {:?}, {:?})?",
            z.join(", "),
            self.frequency,
            self.phase
        )
    }

    /// Its largest amplitude at a coordinate.
    pub fn size(&self) -> f64 {
        let largest = |x: &[f64]| x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        largest(&self.re) + largest(&self.im)
    }
}

impl Case {
    /// All forces.
    pub fn forces(&self) -> impl Iterator<Item = &ForceCase> + Clone {
        self.force.iter().chain(&self.more)
    }

    /// All forces, to be changed.
    pub fn forces_mut(&mut self) -> impl Iterator<Item = &mut ForceCase> {
        self.force.iter_mut().chain(&mut self.more)
    }

    pub fn n(&self) -> usize {
        self.q0.len()
    }

    /// A number that exact flights have, or that steps have.
    pub fn by_method<T>(&self, exact: T, steps: T) -> T {
        if self.method == Method::Exact {
            exact
        } else {
            steps
        }
    }

    /// The library's scene; a matrix that happens to be diagonal is given as one.
    pub fn scene(&self) -> Result<Scene> {
        let coefficient = |a: &DMatrix<f64>| {
            if is_diagonal(a) {
                Coefficient::Diagonal(a.diagonal())
            } else {
                Coefficient::Dense(a.clone())
            }
        };
        let system = LinearSystem::new(
            coefficient(&self.mass),
            coefficient(&self.damping),
            coefficient(&self.stiffness),
        )?
        .with_load(DVector::from_row_slice(&self.load))?;
        let forcings: Result<Vec<Forcing>> = self.forces().map(ForceCase::forcing).collect();
        let mut forcings = forcings?;
        let forcing = match (forcings.len(), forcings.pop()) {
            (_, None) => Forcing::Unforced,
            (1, Some(only)) => only,
            (_, Some(last)) => {
                forcings.push(last);
                forcings.into()
            }
        };
        let stops: Result<Vec<Stop>> = self
            .stops
            .iter()
            .map(|stop| {
                let normal = DVector::from_row_slice(&stop.normal);
                Stop::new(normal, stop.clearance, stop.restitution)?
                    .on_side(if stop.lower { Side::Lower } else { Side::Upper })
                    .with_reaction(match &stop.push {
                        Push::Inertia => Reaction::Inertia,
                        Push::Coordinate => Reaction::Coordinate,
                        Push::Direction(b) => Reaction::Direction(DVector::from_row_slice(b)),
                    })
            })
            .collect();
        Scene::new(system, forcing, stops?)
    }

    /// Whether the motion has real modes: nothing damps it, and its stiffness is symmetric.
    pub fn has_real_modes(&self) -> bool {
        let is_undamped = self.damping.iter().all(|&c| c == 0.0);
        is_undamped && self.stiffness == self.stiffness.transpose()
    }

    /// The largest force on a coordinate.
    pub fn largest_force(&self) -> f64 {
        let shaking = self.forces().map(|f| {
            let all = f.re.iter().chain(&f.im);
            all.fold(0.0, |most: f64, f| most.max(f.abs()))
        });
        let loads = self.load.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
        loads.max(shaking.sum())
    }

    /// The gap of a stop at the start.
    pub fn first_gap(&self, stop: usize) -> f64 {
        self.stops[stop].gap(&self.q0)
    }

    /// How far from a stop a start may be to count as in contact.
    pub fn start_tolerance(&self, stop: usize) -> f64 {
        let normal = &self.stops[stop].normal;
        let size = normal.iter().map(|n| n.abs()).sum::<f64>();
        let terms = normal.iter().zip(&self.q0).map(|(n, q)| (n * q).abs());
        10.0 * (self.atol * size + self.rtol * terms.sum::<f64>())
    }

    /// Whether a start is in contact by the tolerance alone.
    pub fn starts_within_tolerance(&self, stop: usize) -> bool {
        let normal = &self.stops[stop].normal;
        let terms = normal.iter().zip(&self.q0).map(|(n, q)| (n * q).abs());
        let size = self.stops[stop].clearance.abs() + terms.sum::<f64>();
        let gap = self.first_gap(stop).abs();
        gap > 4.0 * f64::EPSILON * size && gap <= self.start_tolerance(stop)
    }

    /// Whether a start is inside a stop by more than the tolerance.
    pub fn starts_inside(&self) -> bool {
        (0..self.stops.len()).any(|stop| self.first_gap(stop) < -self.start_tolerance(stop))
    }

    pub fn start(&self) -> (DVector<f64>, DVector<f64>) {
        (
            DVector::from_row_slice(&self.q0),
            DVector::from_row_slice(&self.v0),
        )
    }

    pub fn options(&self) -> SimulateOptions {
        SimulateOptions {
            solver: Solver {
                method: self.method,
                rtol: self.rtol,
                atol: Some(self.atol),
            },
            max_impacts: Some(MOST_IMPACTS),
            ..Default::default()
        }
    }

    /// The body of a test that repeats the run.
    pub fn dump(&self) -> String {
        let vector = |v: &[f64]| format!("dvector!{v:?}");
        let matrix = |a: &DMatrix<f64>| {
            if is_diagonal(a) {
                return vector(a.diagonal().as_slice());
            }
            let rows: Vec<String> = a
                .row_iter()
                .map(|r| {
                    r.iter()
                        .map(|x| format!("{x:?}"))
                        .collect::<Vec<_>>()
                        .join(", ")
                })
                .collect();
            format!("dmatrix![{}]", rows.join("; "))
        };
        let mut text = format!(
            "let system = LinearSystem::new({}, {}, {})?.with_load({})?;\n",
            matrix(&self.mass),
            matrix(&self.damping),
            matrix(&self.stiffness),
            vector(&self.load)
        );
        let forces: Vec<String> = self.forces().map(ForceCase::dump).collect();
        text += &match &forces[..] {
            [] => "let force = Forcing::Unforced;\n".to_string(),
            [one] => format!("let force = {one};\n"),
            several => format!("let force = vec![{}.into()];\n", several.join(".into(), ")),
        };
        text += "let stops = [\n";
        for s in &self.stops {
            text += &format!(
                "    Stop::new({}, {:?}, {:?})?",
                vector(&s.normal),
                s.clearance,
                s.restitution
            );
            if s.lower {
                text += ".on_side(Side::Lower)";
            }
            match &s.push {
                Push::Inertia => {}
                Push::Coordinate => text += ".with_reaction(Reaction::Coordinate)?",
                Push::Direction(b) => {
                    text += &format!(".with_reaction(Reaction::Direction({}))?", vector(b));
                }
            }
            text += ",\n";
        }
        text += &format!(
            "];\nlet scene = Scene::new(system, force, stops)?;\nlet options = SimulateOptions {{ method: Method::{:?}, rtol: {:e}, atol: Some({:e}), ..Default::default() }};\nlet run = simulate(&scene, &{}, &{}, {:?}, &options)?;\n",
            self.method,
            self.rtol,
            self.atol,
            vector(&self.q0),
            vector(&self.v0),
            self.span
        );
        text
    }
}
