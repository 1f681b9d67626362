//! An orbit beside its script and the body that moves along it, with the units of both.

use crate::branches::body::Body;
use crate::branches::script::{Script, script};
use nalgebra::DVector;
use vibroimpact::{ImpactSide, Motion, PeriodicOrbit};

/// An orbit, and the body that it is said to be a motion of, at the orbit's phase.
pub struct Look<'a> {
    pub orbit: &'a PeriodicOrbit,
    pub body: Body,
    pub script: Script,
    /// The largest position and the largest velocity.
    pub units: [f64; 2],
}

/// So many states of a period tell how large it is.
const LOOKS: usize = 64;
/// What moves by less than this part of where it is in a period is known to rounding over it.
const STILL: f64 = 1e-6;

impl<'a> Look<'a> {
    /// Of an orbit in the scene of a body, or why there is none.
    pub fn new(orbit: &'a PeriodicOrbit, body: &Body) -> Result<Self, &'static str> {
        let alone = Self::alone(orbit, body);
        if alone.units[1] * orbit.period() < STILL * alone.units[0] {
            return Err("a motion that nearly stands still");
        }
        Ok(Self {
            script: script(orbit)?,
            ..alone
        })
    }

    /// The same without what happens along it.
    pub fn alone(orbit: &'a PeriodicOrbit, body: &Body) -> Self {
        let mut units = [0.0f64; 2];
        for k in 0..LOOKS {
            let (q, v) = orbit
                .state(orbit.period() * k as f64 / LOOKS as f64, ImpactSide::After)
                .expect("a time");
            units = [units[0].max(q.amax()), units[1].max(v.amax())];
        }
        for impact in orbit.impacts() {
            let (_, v) = orbit
                .state(impact.time, ImpactSide::Before)
                .expect("a time");
            units[1] = units[1].max(v.amax());
        }
        let script = Script {
            period: orbit.period(),
            instants: Vec::new(),
        };
        Self {
            orbit,
            body: body.at_phase(orbit.phase()),
            script,
            units,
        }
    }

    /// The state that the orbit has, before an impact or behind it.
    pub fn state(&self, time: f64, before: bool) -> Vec<f64> {
        let side = if before {
            ImpactSide::Before
        } else {
            ImpactSide::After
        };
        let (q, v) = self.orbit.state(time, side).expect("a time");
        q.iter().chain(v.iter()).copied().collect()
    }

    /// How far two states are from each other, in the units.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let n = self.body.n();
        let each = a.iter().zip(b).enumerate();
        each.map(|(i, (a, b))| (a - b).abs() / self.units[usize::from(i >= n)])
            .fold(0.0, f64::max)
    }

    /// The contact force that stops the motion in the distance that it goes.
    pub fn force(&self, face: usize) -> f64 {
        self.mass(face) * self.units[1] * self.units[1] / self.units[0]
    }

    /// The mass that a stop feels along its normal.
    pub fn mass(&self, face: usize) -> f64 {
        let mut x = self.state(0.0, false);
        let normal = self.normal(face);
        x[self.body.n()..].copy_from_slice(normal.as_slice());
        let (_, impulse) = self.body.struck(face, &x);
        impulse / (1.0 + self.body.faces()[face].restitution) / normal.norm_squared()
    }

    fn normal(&self, face: usize) -> DVector<f64> {
        match &self.body {
            Body::Chain(chain) => chain.normal(face, &self.state(0.0, false)[..chain.n()]),
            Body::Plant(plant) => plant.normal(face),
        }
    }

    /// How much a gap changes where the motion changes by its size.
    pub fn reach(&self, face: usize) -> f64 {
        self.units[0] * self.normal(face).lp_norm(1)
    }
}
