//! A scene while some of its numbers drift steadily (theory 14): forcings that are periodic without drift become signals, piecewise
//! polynomials that agree with them to rounding.
//!
//! A force `Re(F e^{i k theta})` stays one with `theta' = w(t)`; a displacement stays one, so that the acceleration of a base
//! `s Re(U e^{i k theta})` is `Re((s'' + 2 i k w s' + s (i k w' - (k w)^2)) U e^{i k theta})`, and the slope of a moving stop has its own w.

use crate::error::{Error, Result};
use crate::model::base_acceleration::BaseAcceleration;
use crate::model::constraint::Constraint;
use crate::model::forcing::{Forcing, whole_multiple};
use crate::model::fourier::Fourier;
use crate::model::function_pieces::Layout;
use crate::model::load::Load;
use crate::model::moment::Moment;
use crate::model::ramp::SteadyRamp;
use crate::model::scene::Scene;
use crate::model::signal::Signal;
use crate::model::stop_motion::StopMotion;
use crate::model::twice::Twice;
use crate::tolerance::{DRIFT_OVERHANG, DRIFT_OVERHANG_ROUNDINGS};
use nalgebra::{Complex, DVector};
use std::f64::consts::PI;

/// The numbers of a scene that drift over a span of time.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Drift {
    /// The frequency.
    pub frequency: Option<SteadyRamp>,
    /// The phase of the first periodic part, and the ratio of its frequency to the lowest; all parts are shifted in time with it.
    pub phase: Option<(SteadyRamp, f64)>,
    /// The factor on the forcing.
    pub scale: Option<SteadyRamp>,
    /// The clearance of each stop, `None` of one that keeps it; empty where all do.
    pub clearances: Vec<Option<SteadyRamp>>,
}

/// An angle that changes at a rate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Swept {
    pub angle: f64,
    pub rate: f64,
    pub rate_slope: f64,
}

impl Drift {
    /// Whether nothing drifts that makes signals necessary.
    fn is_still(&self) -> bool {
        self.frequency.is_none()
            && self.phase.is_none()
            && self.scale.is_none()
            && self.clearances.iter().all(Option::is_none)
    }

    /// Whether periodic parts become signals.
    pub fn turns_into_signals(&self) -> bool {
        self.sweeps() || self.scale.is_some()
    }

    /// Whether the angles of periodic parts drift.
    fn sweeps(&self) -> bool {
        self.frequency.is_some() || self.phase.is_some()
    }

    /// The angle at a time of what turned, before the frequency began to drift, at a frequency with a phase; `lowest` is the lowest of
    /// all frequencies then, the one that the drift is about.
    pub fn angle(&self, (frequency, phase): (f64, f64), lowest: f64, t: f64) -> Swept {
        let times = Self::times(frequency, lowest);
        let mut swept = match self.frequency {
            None => Swept {
                angle: Moment::new(t, 0.0, 0.0).angle_of(frequency) + phase,
                rate: frequency,
                rate_slope: 0.0,
            },
            Some(moving) => {
                let turned = moving.integral(t).times(Twice(times, 0.0)).reduced();
                let begun = Moment::new(moving.start, 0.0, 0.0).angle_of(frequency);
                let [rate, rate_slope, _] = moving.at(t);
                Swept {
                    angle: begun + phase + turned,
                    rate: times * rate,
                    rate_slope: times * rate_slope,
                }
            }
        };
        if let Some((moving, first)) = self.phase {
            let ([_, slope, bend], share) = (moving.at(t), times / first);
            swept.angle += share * moving.changed(t);
            swept.rate += share * slope;
            swept.rate_slope += share * bend;
        }
        swept
    }

    /// How many times a frequency is the lowest, a whole number to the bit where it is one.
    pub fn times(frequency: f64, lowest: f64) -> f64 {
        whole_multiple(frequency, lowest).map_or(frequency / lowest, f64::from)
    }

    /// The factor on the forcing at a time, with its derivatives.
    fn scale_at(&self, t: f64) -> [f64; 3] {
        self.scale.map_or([1.0, 0.0, 0.0], |moving| moving.at(t))
    }
}

/// Signals over a span of time under a drift.
struct Sweep<'a> {
    drift: &'a Drift,
    lowest: f64,
    span: (f64, f64),
}

impl Sweep<'_> {
    fn angle(&self, periodic: &Fourier, t: f64) -> Swept {
        let (frequency, phase) = (periodic.frequency(), periodic.phase());
        // Whole turns would take digits.
        let phase = if phase.abs() > PI {
            Complex::cis(phase).arg()
        } else {
            phase
        };
        self.drift.angle((frequency, phase), self.lowest, t)
    }

    /// A value of time, its terms of a size at either end of the span, of which they have their largest: of an angle that is known to its
    /// last place a force is known in parts of its amplitude, however small it is itself.
    fn signal(&self, value: impl Fn(f64) -> f64, size: impl Fn(f64) -> f64) -> Result<Signal> {
        let (start, end) = self.span;
        let mut values = |times: &[f64]| Ok(times.iter().map(|&t| value(t)).collect());
        let layout = Layout {
            size: size(start).max(size(end)),
            ..Layout::of_span(self.span)
        };
        Signal::laid_out(&mut values, layout).map_err(|error| {
            if error == Error::Interrupted {
                return error;
            }
            let (value, rule) = (
                format!("steady from {start} to {end}"),
                "what drifts turns more often there than a million polynomials follow, or faster than the time has digits",
            );
            Error::bad_value("ramp", value, rule)
        })
    }

    /// A force along a direction that grows with the factor on all forcing, and its size without that.
    fn load(
        &self,
        direction: DVector<f64>,
        value: impl Fn(f64) -> f64,
        size: f64,
    ) -> Result<Forcing> {
        let scale = |t: f64| self.drift.scale_at(t)[0];
        let signal = self.signal(|t| scale(t) * value(t), |t| size * scale(t).abs())?;
        Ok(Load::new(direction, signal)?.into())
    }

    /// A periodic force with harmonics about a mean.
    fn force(&self, force: &Fourier) -> Result<Vec<Forcing>> {
        let amplitudes = force.amplitudes();
        let mut all = Vec::new();
        if let Some(mean) = force.mean() {
            all.push(self.load(mean.clone(), |_| 1.0, 1.0)?);
        }
        // Along as few directions as may be: those of the coordinates, or those of the parts of each harmonic.
        let acts_on = |&i: &usize| amplitudes.iter().any(|a| a[i] != Complex::default());
        let coordinates: Vec<usize> = (0..force.n_dof()).filter(acts_on).collect();
        let turned = |t: f64, k: usize| {
            let Swept { angle, .. } = self.angle(force, t);
            Complex::cis(angle * (k + 1) as f64)
        };
        if coordinates.len() <= amplitudes.len() {
            for i in coordinates {
                let direction =
                    DVector::from_fn(force.n_dof(), |j, _| if i == j { 1.0 } else { 0.0 });
                let harmonics = |t: f64| {
                    amplitudes
                        .iter()
                        .enumerate()
                        .map(move |(k, a)| (a[i], k, t))
                };
                let value = |t: f64| harmonics(t).map(|(a, k, t)| (a * turned(t, k)).re).sum();
                let size = amplitudes.iter().map(|a| a[i].norm()).sum();
                all.push(self.load(direction, value, size)?);
            }
            return Ok(all);
        }
        for (k, a) in amplitudes.iter().enumerate() {
            for (direction, is_sine) in [(a.map(|a| a.re), false), (a.map(|a| -a.im), true)] {
                if direction.amax() > 0.0 {
                    let part_of = |u: Complex<f64>| if is_sine { u.im } else { u.re };
                    all.push(self.load(direction, |t| part_of(turned(t, k)), 1.0)?);
                }
            }
        }
        Ok(all)
    }

    /// One forcing as it drifts.
    fn forcing(&self, part: &Forcing) -> Result<Vec<Forcing>> {
        match part {
            Forcing::BaseMotion(base) => {
                let harmonics = |t: f64| {
                    let (swept, [s, s1, s2]) = (self.angle(base, t), self.drift.scale_at(t));
                    base.amplitudes().iter().enumerate().map(move |(k, u)| {
                        let k = (k + 1) as f64;
                        let (w, slope) = (k * swept.rate, k * swept.rate_slope);
                        let factor = Complex::new(s2 - s * w * w, 2.0 * w * s1 + s * slope);
                        factor * u[0] * Complex::cis(k * swept.angle)
                    })
                };
                let acceleration = |t: f64| harmonics(t).map(|z| z.re).sum();
                let size = |t: f64| harmonics(t).map(Complex::norm).sum();
                let signal = self.signal(acceleration, size)?;
                Ok(vec![BaseAcceleration::new(signal).into()])
            }
            _ if let Some(force) = part.own_periodic() => self.force(force),
            signal if self.drift.scale.is_none() => Ok(vec![signal.clone()]),
            _ => {
                let rule = "a forcing that follows a signal cannot be scaled steadily: give the signal as it is to be";
                Err(Error::bad_value("ramp", "of \"forcing_scale\"", rule))
            }
        }
    }

    /// A stop as it drifts.
    fn stop(&self, index: usize, stop: &Constraint) -> Result<Constraint> {
        let clearance = self.drift.clearances.get(index).copied().flatten();
        let motion = stop.motion().map(StopMotion::as_forcing);
        let turns = motion.is_some_and(|motion| motion.own_angle().is_some());
        if clearance.is_none() && !(turns && self.drift.sweeps()) {
            return Ok(stop.clone());
        }
        let value = |t: f64| {
            let widened = clearance.map_or(0.0, |moving| moving.changed(t));
            widened + motion.map_or(0.0, |motion| self.displacement(motion, t))
        };
        let size = |t: f64| {
            let widened = clearance.map_or(0.0, |moving| moving.changed(t).abs());
            widened + motion.map_or(0.0, |motion| self.largest_displacement(motion, t))
        };
        let signal = self.signal(value, size)?;
        Ok(stop
            .clone()
            .with_motion(Some(StopMotion::of_forcing(Load::new(0, signal)?.into()))))
    }

    /// The sizes of the terms of [`displacement`](Self::displacement).
    fn largest_displacement(&self, motion: &Forcing, t: f64) -> f64 {
        let Some(f) = motion.own_periodic() else {
            return self.displacement(motion, t).abs();
        };
        let mean = f.mean().map_or(0.0, |mean| mean[0].abs());
        mean + f.amplitudes().iter().map(|a| a[0].norm()).sum::<f64>()
    }

    /// The displacement of a stop by its own motion.
    fn displacement(&self, motion: &Forcing, t: f64) -> f64 {
        let Some(f) = motion.own_periodic() else {
            return motion.own_signal().map_or(0.0, |signal| signal.value(t));
        };
        let Swept { angle, .. } = self.angle(f, t);
        let amplitudes = f.amplitudes().iter().enumerate();
        let harmonics = amplitudes.map(|(k, a)| (a[0] * Complex::cis((k + 1) as f64 * angle)).re);
        f.mean().map_or(0.0, |mean| mean[0]) + harmonics.sum::<f64>()
    }
}

/// A scene over a span of time while some of its numbers drift. It holds beyond the end by a part of a period. Long spans are many
/// pieces: asks from time to time whether to go on.
///
/// # Errors
/// A forcing that cannot be scaled, a span of more periods than pieces follow; `Error::Interrupted`.
pub(crate) fn drifting(scene: &Scene, drift: &Drift, span: (f64, f64)) -> Result<Scene> {
    if drift.is_still() {
        return Ok(scene.clone());
    }
    let all = scene.all_forcing();
    let lowest = all.lowest().map_or(0.0, |(w, _)| w);
    let fastest = drift
        .frequency
        .map_or(lowest, |m| m.at(span.0)[0].max(m.at(span.1)[0]));
    let longest = if fastest > 0.0 {
        (span.1 - span.0).min(1.0 / fastest)
    } else {
        span.1 - span.0
    };
    let beyond = (DRIFT_OVERHANG * longest)
        .max(DRIFT_OVERHANG_ROUNDINGS * f64::EPSILON * span.0.abs().max(span.1.abs()));
    let sweep = Sweep {
        drift,
        lowest,
        span: (span.0, span.1 + beyond),
    };
    let parts = scene.forcing().parts();
    let forcing = if drift.turns_into_signals() {
        let parts = parts.map(|part| sweep.forcing(part));
        let parts = parts.collect::<Result<Vec<_>>>()?;
        Forcing::Several(parts.into_iter().flatten().collect())
    } else {
        scene.forcing().clone()
    };
    let stops = scene.stops().iter().enumerate();
    let stops = stops.map(|(i, stop)| sweep.stop(i, stop));
    Scene::new(
        scene.system().clone(),
        forcing,
        stops.collect::<Result<Vec<_>>>()?,
    )
}
