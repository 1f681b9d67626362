//! A linear scene with parameters at other values: its modal form is changed in place instead of being built anew for each point of a map.
//! Only complex modes are computed again, for another damping.

use crate::error::Result;
use crate::flow::{FlowCache, ModalScene};
use crate::modal::{Block, Form, Pair};
use crate::model::{Constraint, Parameter, Scene, StopNumber};
use nalgebra::Complex;
use std::sync::Arc;

/// The machinery of a scene, and of the same scene with other values of its parameters.
pub(crate) struct ParametricScene<'a> {
    scene: &'a Scene,
    has_real_modes: bool,
    /// As given, but for the damping of modes that are not real.
    base: ModalScene,
    /// The factor on the damping that `base` has.
    base_damping: f64,
    moved: ModalScene,
    /// The stops that `moved` has.
    stops: Vec<Constraint>,
    /// Whether all forces grow with the square of the frequency; `None` where some do.
    grows_with_frequency: Option<bool>,

    /// The mean of a periodic force in modal pairs, empty where there is none.
    mean: Vec<Pair>,
}

impl<'a> ParametricScene<'a> {
    /// The machinery of a scene; `purpose` says in an error what needs it linear.
    pub fn new(scene: &'a Scene, purpose: &str) -> Result<Self> {
        let base = ModalScene::new(scene, purpose)?;
        let grows_with_frequency = scene.forcing().is_inertial();
        let has_real_modes = base.form.shapes().is_some();
        Ok(Self {
            scene,
            has_real_modes,
            moved: base.clone(),
            mean: mean(&base),
            base,
            base_damping: 1.0,
            stops: scene.stops().to_vec(),
            grows_with_frequency,
        })
    }

    /// The machinery with these parameters at these values, which [`Parameter::check`] has passed, all others as given.
    pub fn at(&mut self, values: &[(Parameter, f64)]) -> Result<&ModalScene> {
        let damping = values
            .iter()
            .find(|(p, _)| *p == Parameter::DampingScale)
            .map(|&(_, factor)| factor);
        if let Some(factor) = damping {
            if self.has_real_modes {
                self.damp(factor);
            } else if factor.to_bits() != self.base_damping.to_bits() {
                self.rebuild(factor)?;
            }
        }
        let (mut scale, mut frequency) = (1.0, self.base.frequency);
        for &(parameter, value) in values {
            match parameter {
                Parameter::Frequency => frequency = value,
                Parameter::ForcingScale => scale = value,
                Parameter::EveryStop(number) => {
                    for stop in 0..self.stops.len() {
                        self.set_stop(stop, number, value)?;
                    }
                }
                Parameter::OneStop(number, stop) => self.set_stop(stop, number, value)?,
                // The phase of the forcing is an outcome; the damping was dealt with.
                Parameter::Phase | Parameter::DampingScale => {}
            }
        }
        if self.grows_with_frequency == Some(true) {
            scale *= (frequency / self.base.frequency).powi(2);
        }
        self.moved.flow_cache = FlowCache::default();
        self.moved.frequency = frequency;
        self.moved.rotations.fundamental = frequency;
        for motion in self.moved.excitation.stops.iter_mut().flatten() {
            motion.rotations.fundamental = frequency;
        }
        let (moved, base) = (&mut self.moved, &self.base);
        for (moved, given) in moved.force.iter_mut().zip(&base.force) {
            *moved = given.map(|f| f * scale);
        }
        let higher = moved.higher.iter_mut().flatten();
        for (moved, given) in higher.zip(base.higher.iter().flatten()) {
            *moved = given.map(|f| f * scale);
        }
        if self.grows_with_frequency.is_none() && frequency != base.frequency {
            let sped = self
                .scene
                .replace(Parameter::Frequency.change(frequency))?
                .excitation();
            let forces = std::iter::once(&mut moved.force).chain(&mut moved.higher);
            for (moved, part) in forces.zip(&sped.harmonics) {
                let force = part.force.map(|f| f * Complex::from(scale));
                if !force.is_empty() {
                    *moved = base.form.force(&base.system, &force);
                }
            }
        }
        // The mean of a periodic force is scaled with it, a load of the system is not.
        for ((moved, given), mean) in moved.load.iter_mut().zip(&base.load).zip(&self.mean) {
            *moved = [0, 1].map(|c| given[c] + (scale - 1.0) * mean[c]);
        }
        Ok(&self.moved)
    }

    /// Gives a stop another value of a number.
    fn set_stop(&mut self, stop: usize, number: StopNumber, value: f64) -> Result<()> {
        number.set(&mut self.stops[stop], value)?;
        let (geometry, own) = (Arc::make_mut(&mut self.moved.geometry), &self.stops[stop]);
        geometry.clearances[stop] = own.clearance();
        geometry.laws[stop] = own.contact().clone();
        Ok(())
    }

    /// Real modes keep their shapes and decay faster or slower.
    fn damp(&mut self, factor: f64) {
        if let (Form::Blocks(moved), Form::Blocks(given)) = (
            &mut Arc::make_mut(&mut self.moved.form).form,
            &self.base.form.form,
        ) {
            for (moved, given) in moved.iter_mut().zip(given) {
                if let Block::Oscillator { w2, eta } = *given {
                    *moved = Block::Oscillator {
                        w2,
                        eta: eta * factor,
                    };
                }
            }
        }
    }

    /// Other modes are made again.
    fn rebuild(&mut self, factor: f64) -> Result<()> {
        self.base = ModalScene::new(
            &self.scene.replace(Parameter::DampingScale.change(factor))?,
            "a sweep",
        )?;
        self.base_damping = factor;
        self.mean = mean(&self.base);
        self.moved = self.base.clone();
        Ok(())
    }
}

/// The mean of a periodic force in modal pairs, empty where there is none.
fn mean(scene: &ModalScene) -> Vec<Pair> {
    let mean = &scene.excitation.mean;
    if mean.is_empty() {
        return Vec::new();
    }
    scene.form.load(&scene.system, mean)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{BaseMotion, Harmonic, LinearSystem, Stop};
    use nalgebra::{dmatrix, dvector};

    fn close(a: &ModalScene, b: &ModalScene) {
        let (Form::Blocks(x), Form::Blocks(y)) = (&a.form.form, &b.form.form) else {
            panic!("blocks")
        };
        for (x, y) in x.iter().zip(y) {
            for (x, y) in x.roots().iter().zip(y.roots()) {
                assert!((x - y).norm() < 1e-14, "{x} {y}");
            }
        }
        for (x, y) in a.force.iter().flatten().zip(b.force.iter().flatten()) {
            assert!((x - y).norm() < 1e-14, "{x} {y}");
        }
        assert!((a.frequency - b.frequency).abs() < f64::EPSILON);
        assert_eq!(a.geometry.clearances, b.geometry.clearances);
        assert_eq!(a.geometry.laws, b.geometry.laws);
        assert!((a.position_rows[0][0][0] - b.position_rows[0][0][0]).abs() < 1e-14);
    }

    #[test]
    fn moved_machinery_is_that_of_the_replaced_scene() {
        let parameters = [
            Parameter::Frequency,
            Parameter::ForcingScale,
            Parameter::DampingScale,
            Parameter::CLEARANCE,
            Parameter::CLEARANCE.of(1),
            Parameter::RESTITUTION,
            Parameter::RESTITUTION.of(0),
        ];
        let mass = dmatrix![2.0, 0.3; 0.3, 1.0];
        let stiffness = dmatrix![3.0, -1.0; -1.0, 2.0];
        for damping in [&stiffness * 0.1, dmatrix![0.3, 0.0; 0.0, 0.1]] {
            let system = LinearSystem::new(mass.clone(), damping, stiffness.clone())
                .and_then(|s| s.with_influence(dvector![1.0, 0.5]))
                .expect("valid");
            let stops = || [0usize, 1].map(|i| Stop::new(i, 0.4, 0.7).expect("valid"));
            let force = Harmonic::new(dvector![0.3.into(), 0.1.into()], 1.3, 0.2).expect("valid");
            let base = BaseMotion::new(0.3, 1.3, 0.2).expect("valid");
            for scene in [
                Scene::new(system.clone(), force, stops()),
                Scene::new(system.clone(), base, stops()),
            ] {
                let scene = scene.expect("valid");
                for x in parameters {
                    for y in parameters.into_iter().filter(|&y| y != x) {
                        let mut moving = ParametricScene::new(&scene, "the test").expect("linear");
                        // 0 first: complex modes become real ones and must come back.
                        for value in [0.0, 0.8, 0.3] {
                            let value = if x == Parameter::Frequency {
                                value + 0.1
                            } else {
                                value
                            };
                            let replaced = scene
                                .replace(x.change(value))
                                .and_then(|s| s.replace(y.change(0.6)));
                            let expected = ModalScene::new(&replaced.expect("valid"), "the test")
                                .expect("linear");
                            close(
                                moving.at(&[(x, value), (y, 0.6)]).expect("linear"),
                                &expected,
                            );
                        }
                    }
                }
            }
        }
    }
}
