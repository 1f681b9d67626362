//! An excitation as integrators evaluate it at a moment. A motion on which nothing acts compiles to code without any of it.

use crate::model::excitation::{Excitation, powers};
use crate::model::moment::Moment;
use nalgebra::{Complex, DVector};

/// What acts on the coordinates from outside.
pub(crate) trait Input {
    /// What of it changes with time.
    type Push: Copy;

    /// That at a moment.
    fn push(&self, at: Moment) -> Self::Push;
    /// Adds all of it to `f`; an acceleration of the base adds `lever(i)` times itself to coordinate i.
    fn add(&self, push: Self::Push, lever: impl Fn(usize) -> f64, f: &mut [f64]);
}

/// Nothing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NoInput;

/// Any of it.
#[derive(Debug, Clone)]
pub(crate) struct Driven {
    /// Empty where there is none.
    load: DVector<f64>,
    /// `A w^2` of a base displaced by `A cos(angle)`: its acceleration towards the system is `A w^2 cos(angle)`.
    base: f64,
    /// f of `Re(f e^{i angle})`, empty where there is none.
    force: DVector<Complex<f64>>,
    /// The same of the higher harmonics, at twice the angle and so on.
    higher: Vec<DVector<Complex<f64>>>,
}

/// What changes with time: the acceleration of the base, and the cosine and sine of the angle where there is a force.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Swing {
    base: f64,
    cos: f64,
    sin: f64,
}

impl Driven {
    /// What acts on the coordinates of a system; `None` where nothing does.
    pub fn new(excitation: &Excitation) -> Option<Self> {
        let (load, harmonics) = (&excitation.load, &excitation.harmonics);
        let first = harmonics.first();
        (!load.is_empty() || first.is_some()).then(|| Self {
            load: load.clone(),
            base: first.map_or(0.0, |part| part.base),
            force: first.map_or_else(|| DVector::zeros(0), |part| part.force.clone()),
            higher: harmonics
                .iter()
                .skip(1)
                .map(|part| part.force.clone())
                .collect(),
        })
    }

    /// Adds the higher harmonics where the phasor of the first is u, in a function of its own: most have none.
    #[cold]
    fn add_higher(&self, u: Complex<f64>, f: &mut [f64]) {
        for (force, u) in self.higher.iter().zip(powers(u).skip(1)) {
            for (f, a) in f.iter_mut().zip(force.as_slice()) {
                *f += a.re * u.re - a.im * u.im;
            }
        }
    }
}

impl Input for NoInput {
    type Push = ();

    #[inline]
    fn push(&self, _at: Moment) {}

    #[inline]
    fn add(&self, (): (), _lever: impl Fn(usize) -> f64, _f: &mut [f64]) {}
}

impl<I: Input> Input for Option<I> {
    type Push = Option<I::Push>;

    #[inline]
    fn push(&self, at: Moment) -> Option<I::Push> {
        self.as_ref().map(|input| input.push(at))
    }

    #[inline]
    fn add(&self, push: Option<I::Push>, lever: impl Fn(usize) -> f64, f: &mut [f64]) {
        if let (Some(input), Some(push)) = (self, push) {
            input.add(push, lever, f);
        }
    }
}

impl Input for Driven {
    type Push = Swing;

    #[inline]
    fn push(&self, at: Moment) -> Swing {
        let base = if self.base == 0.0 {
            0.0
        } else {
            self.base * at.angle.cos()
        };
        let (sin, cos) = if self.force.is_empty() {
            (0.0, 1.0)
        } else {
            at.angle.sin_cos()
        };
        Swing { base, cos, sin }
    }

    #[inline]
    fn add(&self, push: Swing, lever: impl Fn(usize) -> f64, f: &mut [f64]) {
        let Swing { base, cos, sin } = push;
        for (f, load) in f.iter_mut().zip(self.load.as_slice()) {
            *f += load;
        }
        if self.base != 0.0 {
            for (i, f) in f.iter_mut().enumerate() {
                *f += base * lever(i);
            }
        }
        for (f, a) in f.iter_mut().zip(self.force.as_slice()) {
            *f += a.re * cos - a.im * sin;
        }
        if !self.higher.is_empty() {
            self.add_higher(Complex::new(cos, sin), f);
        }
    }
}
