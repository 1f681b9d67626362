//! What moves, a chain of pendulums or a linear system, with its numbers by name; and the scene that the library is given of it.

use crate::branches::plant::Plant;
use crate::pendulums::chain::{Chain, Face, Kind};
use nalgebra::{DMatrix, DVector};
use vibroimpact::nalgebra::Complex;
use vibroimpact::{
    BaseMotion, Constraint, EquationsOfMotion, Forcing, Harmonic, LinearSystem, NonlinearSystem,
    Parameter, PendulumChain, Result, Scene, Side, Stop, Wall, WallSide,
};

/// A number that a branch is followed over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Number {
    Frequency,
    /// A factor on the forcing.
    Forcing,
    /// A factor on the damping.
    Damping,
    /// The restitution of one stop.
    Restitution(usize),
    /// The place of a wall, the clearance of a plane.
    Room(usize),
}

impl Number {
    /// The number as the library has it, but for the place of a wall.
    pub fn parameter(self) -> Parameter {
        match self {
            Self::Frequency => Parameter::Frequency,
            Self::Forcing => Parameter::ForcingScale,
            Self::Damping => Parameter::DampingScale,
            Self::Restitution(stop) => Parameter::RESTITUTION.of(stop),
            Self::Room(stop) => Parameter::CLEARANCE.of(stop),
        }
    }
}

/// What moves.
#[derive(Debug, Clone)]
pub enum Body {
    Chain(Chain),
    Plant(Plant),
}

impl Body {
    pub fn n(&self) -> usize {
        match self {
            Self::Chain(chain) => chain.n(),
            Self::Plant(plant) => plant.force.len(),
        }
    }

    pub fn faces(&self) -> &[Face] {
        match self {
            Self::Chain(chain) => &chain.faces,
            Self::Plant(plant) => &plant.faces,
        }
    }

    fn face_mut(&mut self, face: usize) -> &mut Face {
        match self {
            Self::Chain(chain) => &mut chain.faces[face],
            Self::Plant(plant) => &mut plant.faces[face],
        }
    }

    pub fn acceleration(&self, t: f64, x: &[f64], held: Option<usize>) -> (DVector<f64>, f64) {
        let (q, v) = x.split_at(self.n());
        match self {
            Self::Chain(chain) => chain.acceleration(t, q, v, held),
            Self::Plant(plant) => plant.acceleration(t, q, v, held),
        }
    }

    pub fn gap(&self, face: usize, x: &[f64]) -> f64 {
        let q = &x[..self.n()];
        match self {
            Self::Chain(chain) => chain.gap(face, q),
            Self::Plant(plant) => plant.gap(face, q),
        }
    }

    /// The rate of a gap.
    pub fn speed(&self, face: usize, x: &[f64]) -> f64 {
        let (q, v) = x.split_at(self.n());
        match self {
            Self::Chain(chain) => chain.speed(face, q, v),
            Self::Plant(plant) => plant.speed(face, v),
        }
    }

    /// The second derivative of a gap in free motion.
    pub fn opening(&self, face: usize, t: f64, x: &[f64]) -> f64 {
        let (q, v) = x.split_at(self.n());
        match self {
            Self::Chain(chain) => chain.opening(face, t, q, v),
            Self::Plant(plant) => -plant.normal(face).dot(&plant.acceleration(t, q, v, None).0),
        }
    }

    /// The state after an impact, and its impulse.
    pub fn struck(&self, face: usize, x: &[f64]) -> (Vec<f64>, f64) {
        let (q, v) = x.split_at(self.n());
        let (after, impulse) = match self {
            Self::Chain(chain) => chain.struck(face, q, v),
            Self::Plant(plant) => plant.struck(face, v),
        };
        (q.iter().copied().chain(after).collect(), impulse)
    }

    /// The frequency and the phase of what shakes it.
    fn wave(&self) -> Option<[f64; 2]> {
        match self {
            Self::Chain(chain) => chain.base.map(|[_, w, phase]| [w, phase]),
            Self::Plant(plant) => plant.wave,
        }
    }

    /// Kinetic energy and the sum of kinetic and potential energy, which is zero at the origin.
    pub fn energies(&self, x: &[f64]) -> [f64; 2] {
        let (q, v) = x.split_at(self.n());
        match self {
            Self::Chain(chain) => {
                let (mut across, mut up, mut above) = (0.0, 0.0, 0.0);
                let (mut kinetic, mut potential) = (0.0, 0.0);
                for (i, (mass, length)) in chain.masses.iter().zip(&chain.lengths).enumerate() {
                    let (sin, cos) = q[i].sin_cos();
                    across += length * cos * v[i];
                    up += length * sin * v[i];
                    above += length * 2.0 * (0.5 * q[i]).sin().powi(2);
                    kinetic += 0.5 * mass * (across * across + up * up);
                    potential += mass * chain.gravity * above;
                }
                [kinetic, kinetic + potential]
            }
            Self::Plant(plant) => {
                let [q, v] = [q, v].map(DVector::from_column_slice);
                let kinetic = 0.5 * v.dot(&(&plant.mass * &v));
                [kinetic, kinetic + 0.5 * q.dot(&(&plant.stiffness * &q))]
            }
        }
    }

    /// How fast it moves in a state: the sum of all rates.
    pub fn rate(&self, x: &[f64]) -> f64 {
        let forced = self.wave().map_or(0.0, |[w, _]| w);
        let least = |all: &[f64]| all.iter().copied().fold(f64::INFINITY, f64::min);
        forced
            + match self {
                Self::Chain(chain) => {
                    let lightest = chain.masses.iter().sum::<f64>() / least(&chain.masses);
                    let swing = (lightest * chain.gravity / least(&chain.lengths)).sqrt();
                    swing + x[chain.n()..].iter().map(|v| v.abs()).sum::<f64>()
                }
                Self::Plant(plant) => {
                    let norm = |matrix: &DMatrix<f64>| (&plant.inverse * matrix).norm();
                    let hard: f64 = plant.pads.iter().map(|pad| pad.stiffness).sum();
                    let hard = hard * plant.inverse.norm();
                    (norm(&plant.stiffness) + hard).sqrt() + norm(&plant.damping)
                }
            }
    }

    /// The same with another phase of what shakes it.
    pub fn at_phase(&self, phase: f64) -> Self {
        let mut other = self.clone();
        match &mut other {
            Self::Chain(chain) => {
                chain.base.iter_mut().for_each(|base| base[2] = phase);
            }
            Self::Plant(plant) => {
                plant.wave.iter_mut().for_each(|wave| wave[1] = phase);
            }
        }
        other
    }

    /// The value of a number: of factors one.
    pub fn value(&self, number: Number) -> f64 {
        match number {
            Number::Frequency => self.wave().expect("shaken")[0],
            Number::Forcing | Number::Damping => 1.0,
            Number::Restitution(face) => self.faces()[face].restitution,
            Number::Room(face) => match &self.faces()[face].kind {
                Kind::Wall { at, .. } => *at,
                Kind::Plane { clearance, .. } => *clearance,
            },
        }
    }

    /// The same with another value of a number.
    pub fn with(&self, number: Number, value: f64) -> Self {
        let mut other = self.clone();
        match (number, &mut other) {
            (Number::Frequency, Self::Chain(chain)) => {
                chain.base.iter_mut().for_each(|base| base[1] = value);
            }
            (Number::Frequency, Self::Plant(plant)) => {
                plant.wave.iter_mut().for_each(|wave| wave[0] = value);
            }
            (Number::Forcing, Self::Chain(chain)) => {
                chain.base.iter_mut().for_each(|base| base[0] *= value);
            }
            (Number::Forcing, Self::Plant(plant)) => plant.force *= value,
            (Number::Damping, Self::Chain(chain)) => chain.damping *= value,
            (Number::Damping, Self::Plant(plant)) => plant.damping *= value,
            (Number::Restitution(face), own) => own.face_mut(face).restitution = value,
            (Number::Room(face), own) => match &mut own.face_mut(face).kind {
                Kind::Wall { at, .. } => *at = value,
                Kind::Plane { clearance, .. } => *clearance = value,
            },
        }
        other
    }

    /// The scene as the library has it.
    pub fn scene(&self) -> Result<Scene> {
        let stops = self.faces().iter().map(constraint);
        let stops = stops.collect::<Result<Vec<Constraint>>>()?;
        match self {
            Self::Chain(chain) => {
                let forcing = match chain.base {
                    Some([a, w, phase]) => BaseMotion::new(a, w, phase)?.into(),
                    None => Forcing::Unforced,
                };
                let [masses, lengths] =
                    [&chain.masses, &chain.lengths].map(|x| DVector::from_column_slice(x));
                let damping = chain.damping.clone();
                let system =
                    PendulumChain::with_damping_matrix(masses, lengths, damping, chain.gravity)?;
                Scene::new(system, forcing, stops)
            }
            Self::Plant(plant) => {
                let forcing = match plant.wave {
                    Some([w, phase]) => {
                        Harmonic::new(plant.force.map(Complex::from), w, phase)?.into()
                    }
                    None => Forcing::Unforced,
                };
                let [mass, damping, stiffness] =
                    [&plant.mass, &plant.damping, &plant.stiffness].map(Clone::clone);
                if plant.pads.is_empty() {
                    return Scene::new(
                        LinearSystem::new(mass, damping, stiffness)?,
                        forcing,
                        stops,
                    );
                }
                let inner = Inner(Plant {
                    force: DVector::zeros(self.n()),
                    ..plant.clone()
                });
                Scene::new(NonlinearSystem::new(inner)?, forcing, stops)
            }
        }
    }
}

/// The equations of a plant without its force, for the library.
struct Inner(Plant);

impl EquationsOfMotion for Inner {
    fn n_dof(&self) -> usize {
        self.0.force.len()
    }

    fn acceleration(&self, t: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<()> {
        a.copy_from_slice(self.0.acceleration(t, q, v, None).0.as_slice());
        Ok(())
    }

    fn has_mass(&self) -> bool {
        true
    }

    fn mass(&self, _: &[f64]) -> Result<DMatrix<f64>> {
        Ok(self.0.mass.clone())
    }
}

/// A face as the library has it: planes on one coordinate by that and their side.
fn constraint(face: &Face) -> Result<Constraint> {
    match &face.kind {
        Kind::Wall { bob, at, side } => {
            let side = if *side > 0.0 {
                WallSide::Right
            } else {
                WallSide::Left
            };
            Ok(Wall::new(*bob, *at, face.restitution, side)?.into())
        }
        Kind::Plane { normal, clearance } => {
            let along: Vec<usize> = (0..normal.len()).filter(|&i| normal[i] != 0.0).collect();
            match along[..] {
                [one] if normal[one].abs() == 1.0 => {
                    let stop = Stop::new(one, *clearance, face.restitution)?;
                    let side = if normal[one] > 0.0 {
                        Side::Upper
                    } else {
                        Side::Lower
                    };
                    Ok(stop.on_side(side).into())
                }
                _ => {
                    let normal = DVector::from_column_slice(normal);
                    Ok(Stop::new(normal, *clearance, face.restitution)?.into())
                }
            }
        }
    }
}
