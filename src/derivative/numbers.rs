//! Numbers of a scene by which something is derived: their values, their sizes, the scenes beside.

use crate::error::Result;
use crate::model::{Parameter, Scene, StopNumber, Unit};
use crate::tolerance::LEAST_RESTITUTION_LOSS;

/// Numbers of a scene.
pub(super) struct Numbers<'a> {
    scene: &'a Scene,
    parameters: &'a [Parameter],
    values: Vec<f64>,
    /// By how much each may be changed without the motion becoming another one, shape (d,), [units of the numbers].
    pub sizes: Vec<f64>,
}

impl<'a> Numbers<'a> {
    /// Numbers of a scene whose motion goes so far.
    ///
    /// # Errors
    /// A number that the scene does not have, or that its stops do not share; the phase, which shifts time alone.
    pub fn new(scene: &'a Scene, parameters: &'a [Parameter], farthest: f64) -> Result<Self> {
        let values = parameters.iter();
        let values = values.map(|&parameter| scene.start_of(parameter, "parameters"));
        let values: Vec<f64> = values.collect::<Result<_>>()?;
        // Clearances are felt as parts of the motion, factors and restitutions of one.
        let size = |(&parameter, &value): (&Parameter, &f64)| match parameter.unit() {
            Unit::Length => farthest.max(value.abs()),
            Unit::One => 1.0,
            Unit::Own if value == 0.0 => 1.0,
            Unit::Frequency | Unit::Own => value,
        };
        let sizes = parameters.iter().zip(&values).map(size).collect();
        Ok(Self {
            scene,
            parameters,
            values,
            sizes,
        })
    }

    /// Scales for a motion with accumulating impacts, which go on for as long as `1/(1 - e)`.
    pub fn accumulating(mut self) -> Self {
        let numbers = self.parameters.iter().zip(&self.values);
        for ((parameter, value), size) in numbers.zip(&mut self.sizes) {
            if parameter.stop_number() == Some(StopNumber::Restitution) {
                *size = (1.0 - value).max(LEAST_RESTITUTION_LOSS);
            }
        }
        self
    }

    /// Scales for a motion whose forcing turns by an angle [rad] from time zero on: a change of the frequency is felt in proportion to it.
    pub fn turning(mut self, angle: f64) -> Self {
        for (parameter, size) in self.parameters.iter().zip(&mut self.sizes) {
            if *parameter == Parameter::Frequency {
                *size /= angle.max(1.0);
            }
        }
        self
    }

    /// The scene beside in which number i is larger.
    pub fn scene(&self, i: usize, offset: f64) -> Result<Scene> {
        self.scene
            .with_value(self.parameters[i], self.values[i] + offset)
    }

    /// The size of a number.
    pub fn size(&self, i: usize) -> f64 {
        self.sizes[i]
    }
}
