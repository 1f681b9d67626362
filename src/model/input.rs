//! An excitation as integrators evaluate it at a moment. A motion on which nothing acts compiles to code without any of it.

use crate::model::excitation::{Excitation, HarmonicPart, SignalPart};
use crate::model::moment::Moment;
use crate::model::rotations::Rotations;
use nalgebra::{Complex, DVector};

/// What acts on the coordinates from outside.
pub(crate) trait Input {
    /// The part that changes with time.
    type Push: Copy;

    /// That at a moment.
    fn push(&self, at: Moment) -> Self::Push;
    /// Adds all of it to `f`; an acceleration of the base adds `lever(i)` times itself to coordinate i.
    fn add(&self, push: Self::Push, lever: impl Fn(usize) -> f64, f: &mut [f64]);
}

/// Nothing.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NoInput;

/// A motion on which nothing acts, or one on which something does.
pub(crate) enum ByInput<F, D> {
    Free(F),
    Driven(D),
}

/// Any of it.
#[derive(Debug, Clone)]
pub(crate) struct Driven {
    /// Empty where there is none.
    load: DVector<f64>,
    /// `A w^2` of a base displaced by `A cos(angle)`: its acceleration towards the system is `A w^2 cos(angle)`.
    base: f64,
    /// f of `Re(f e^{i angle})`, empty where there is none.
    force: DVector<Complex<f64>>,
    /// What acts beside those.
    other: Option<Box<Other>>,
}

/// What acts beside a load and one harmonic: the harmonics from the second on, tones, signals, a base that is not moved by a cosine.
#[derive(Debug, Clone)]
struct Other {
    /// Whether some of it moves the base.
    is_shaken: bool,
    harmonics: Vec<HarmonicPart>,
    rotations: Rotations,
    signals: Vec<SignalPart>,
}

/// What changes with time: the acceleration of the base, and the cosine and sine of the angle where a force turns.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Swing {
    base: f64,
    cos: f64,
    sin: f64,
    at: Moment,
}

impl Driven {
    /// What acts on the coordinates of a system; `None` where nothing does.
    pub fn new(excitation: &Excitation) -> Option<Self> {
        if !excitation.acts() {
            return None;
        }
        let Excitation {
            load,
            harmonics,
            rotations,
            signals,
            ..
        } = excitation;
        let is_usual = |part: &&HarmonicPart| rotations.n_harmonics > 0 && part.base.im == 0.0;
        let first = harmonics.first().filter(is_usual);
        let rest = &harmonics[usize::from(first.is_some())..];
        let other = || {
            let mut harmonics = harmonics.clone();
            if first.is_some() {
                harmonics[0] = HarmonicPart {
                    base: Complex::default(),
                    force: DVector::zeros(0),
                };
            }
            let shaken = signals.iter().any(|part| part.base != 0.0);
            Box::new(Other {
                is_shaken: shaken || harmonics.iter().any(|part| part.base.norm() > 0.0),
                harmonics,
                rotations: rotations.clone(),
                signals: signals.clone(),
            })
        };
        Some(Self {
            load: load.clone(),
            base: first.map_or(0.0, |part| part.base.re),
            force: first.map_or_else(|| DVector::zeros(0), |part| part.force.clone()),
            other: (!rest.is_empty() || !signals.is_empty()).then(other),
        })
    }
}

impl Other {
    /// Its part of the acceleration of the base, in a function of its own: most have none.
    #[cold]
    fn base(&self, first: Complex<f64>, at: Moment) -> f64 {
        let phasors = self.rotations.phasors_of(first, at);
        let harmonics = self.harmonics.iter().zip(phasors);
        let turning: f64 = harmonics.map(|(part, u)| (part.base * u).re).sum();
        let shaken = self.signals.iter().filter(|part| part.base != 0.0);
        turning + shaken.map(|part| part.base * part.value(at)).sum::<f64>()
    }

    /// Adds its forces.
    #[cold]
    fn add(&self, first: Complex<f64>, at: Moment, f: &mut [f64]) {
        let phasors = self.rotations.phasors_of(first, at);
        for (part, u) in self.harmonics.iter().zip(phasors) {
            for (f, a) in f.iter_mut().zip(part.force.as_slice()) {
                *f += a.re * u.re - a.im * u.im;
            }
        }
        for part in self.signals.iter().filter(|part| !part.force.is_empty()) {
            let value = part.value(at);
            for (f, d) in f.iter_mut().zip(part.force.as_slice()) {
                *f += d * value;
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
        let mut base = if self.base == 0.0 {
            0.0
        } else {
            self.base * at.angle.cos()
        };
        let turns = |other: &Other| other.rotations.n_harmonics > 0;
        let (sin, cos) = if self.force.is_empty() && !self.other.as_deref().is_some_and(turns) {
            (0.0, 1.0)
        } else {
            at.angle.sin_cos()
        };
        if let Some(other) = self.other.as_deref().filter(|other| other.is_shaken) {
            base += other.base(Complex::new(cos, sin), at);
        }
        Swing { base, cos, sin, at }
    }

    #[inline]
    fn add(&self, push: Swing, lever: impl Fn(usize) -> f64, f: &mut [f64]) {
        let Swing { base, cos, sin, at } = push;
        for (f, load) in f.iter_mut().zip(self.load.as_slice()) {
            *f += load;
        }
        if base != 0.0 {
            for (i, f) in f.iter_mut().enumerate() {
                *f += base * lever(i);
            }
        }
        for (f, a) in f.iter_mut().zip(self.force.as_slice()) {
            *f += a.re * cos - a.im * sin;
        }
        if let Some(other) = &self.other {
            other.add(Complex::new(cos, sin), at, f);
        }
    }
}
