//! The maps of any scene: flights that are integrated, in any regime.

use super::flight_pieces::{FlightPieces, OrbitMethod};
use super::series_flow::SeriesFlow;
use crate::error::{Error, Result};
use crate::flow::RegimeDynamics;
use crate::flow::differences::{Differences, WarningLog};
use crate::flow::integrate::{KeptStep, integrate};
use crate::flow::own_time::OwnTime;
use crate::flow::steps::{Dop853, Stepper, Tolerance};
use crate::flow::variational::{Variational, joined, parted};
use crate::hybrid::maps::{Breaks, GapAt, HybridMaps, project_onto};
use crate::hybrid::scaled_units::ScaledUnits;
use crate::law::{Law, Newton, Regime};
use crate::linalg::elementary::power_of_two;
use crate::model::{
    Contact, Dynamics, Moment, Scene, SceneMotion, System, along_reactions, contacts,
    reaction_weights, slow_time,
};
use crate::tolerance::{
    CENTRAL_DIFFERENCE_STEP, DEVIATION_KNOWN, ORBIT_CLOSED_BY_STEPS, SMALLEST_DEVIATION,
};
use nalgebra::{DMatrix, DVector, DVectorView};
use std::sync::Arc;

/// Tolerances of the flights of an orbit: an orbit closes to 1e-11.
const TOLERANCE: Tolerance = Tolerance {
    relative: 2e-13,
    absolute: 1e-15,
};

/// A scene whose flights are integrated, from a forcing phase.
#[derive(Debug, Clone)]
pub(crate) struct IntegratedMaps {
    motion: SceneMotion,
    pub system: System,
    pub contacts: Arc<Vec<Contact>>,
    pub frequency: f64,
    pub phase: f64,
    tolerance: Tolerance,
    /// The units of the motions, as far as they are known.
    units: ScaledUnits,
    /// What moves it where no stop is held, if that has Taylor series.
    series: Option<SeriesFlow>,
    breaks: Breaks,
    /// Where doubts about deviations are noted, if somebody wants to know.
    warnings: Option<Arc<WarningLog>>,
}

impl IntegratedMaps {
    pub fn new(scene: &Scene, phase: f64) -> Self {
        Self {
            motion: SceneMotion::new(scene),
            system: scene.system().clone(),
            contacts: Arc::new(contacts(scene)),
            frequency: scene.frequency().unwrap_or(0.0),
            phase,
            tolerance: TOLERANCE,
            units: ScaledUnits::default(),
            series: SeriesFlow::new(scene, TOLERANCE),
            breaks: Breaks(scene.excitation().breaks()),
            warnings: None,
        }
    }

    /// The same, and where it notes doubts about deviations.
    pub fn watched(&self) -> (Self, Arc<WarningLog>) {
        let warnings = Arc::new(WarningLog::default());
        let maps = Self {
            warnings: Some(Arc::clone(&warnings)),
            ..self.clone()
        };
        (maps, warnings)
    }

    /// The same for motions of some units: the tolerance is as small beside them as the usual one beside one.
    pub fn in_units(self, units: ScaledUnits) -> Self {
        let absolute = TOLERANCE.absolute * units.position.min(units.velocity);
        Self {
            tolerance: Tolerance {
                absolute,
                ..TOLERANCE
            },
            units,
            ..self
        }
    }

    pub fn moment(&self, t: f64) -> Moment {
        Moment::new(t, self.frequency * t + self.phase, self.frequency)
    }

    /// The motion in a regime.
    fn in_regime(&self, regime: &Regime) -> RegimeDynamics<'_, SceneMotion> {
        RegimeDynamics {
            dynamics: &self.motion,
            system: &self.system,
            contacts: Arc::clone(&self.contacts),
            regime: regime.clone(),
        }
    }

    /// A flight from a state, from the time of its start.
    pub fn pieces(
        &self,
        regime: &Regime,
        (start, span): (f64, f64),
        state: &DVector<f64>,
    ) -> Result<FlightPieces> {
        let at = self.moment(start);
        if let Some(series) = self.series_of(regime) {
            return Ok(FlightPieces::Series(series.pieces(
                self.tolerance,
                (at, span),
                state,
            )?));
        }
        let mut x: Vec<f64> = state.iter().copied().collect();
        let mut steps = Vec::new();
        let (motion, tolerance) = (self.in_regime(regime), self.tolerance);
        integrate::<OrbitMethod, _>(&motion, (at, span), tolerance, &mut x, |step| {
            let dense = step.stepper.dense(&motion, step.start, step.h)?;
            steps.push(KeptStep {
                start: step.done,
                h: step.h,
                dense,
            });
            Ok(())
        })?;
        Ok(FlightPieces::Steps(steps))
    }

    /// A flight of no length at a state.
    pub fn instant(&self, state: &DVector<f64>) -> FlightPieces {
        match &self.series {
            Some(series) => FlightPieces::Series(vec![series.instant(state)]),
            None => FlightPieces::line(0.0, state, state),
        }
    }

    /// The series of the motion in a regime, if it has them.
    fn series_of(&self, regime: &Regime) -> Option<&SeriesFlow> {
        self.series.as_ref().filter(|_| regime.is_free())
    }

    /// The order of the velocities of the series of flights, if they have them.
    pub fn series_order(&self) -> Option<usize> {
        self.series.as_ref().map(SeriesFlow::order)
    }

    /// Goes on like `flow`, to a tolerance of a run.
    pub fn flow_to(
        &self,
        tolerance: Tolerance,
        regime: &Regime,
        span: (f64, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<()> {
        self.flow_by::<Dop853<Vec<f64>>>(tolerance, (regime, span), state, deviations)?;
        Ok(())
    }

    /// Carries a state and deviations from it over a span to a tolerance, along series or by a method; many deviations by the Jacobian,
    /// which is returned.
    fn flow_by<P: Stepper<Vec<f64>, Choice: Default>>(
        &self,
        tolerance: Tolerance,
        (regime, (start, end)): (&Regime, (f64, f64)),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<Option<DMatrix<f64>>> {
        let len = state.len();
        let moving = deviations.column_iter().filter(|own| own.amax() > 0.0);
        if moving.count() > len {
            // Of so many those of every coordinate and velocity say all.
            let mut jacobian = DMatrix::identity(len, len);
            self.flow_by::<P>(tolerance, (regime, (start, end)), state, &mut jacobian)?;
            *deviations = &jacobian * &*deviations;
            return Ok(Some(jacobian));
        }
        let mut parts = self.breaks.parts((start, end)).peekable();
        while let Some(part) = parts.next_if(|part| part.1 < end) {
            self.flow_by::<P>(tolerance, (regime, part), state, deviations)?;
        }
        let start = parts.next().map_or(start, |last| last.0);
        let (at, span) = (self.moment(start), end - start);
        if let Some(series) = self.series_of(regime) {
            series.flow(tolerance, (at, span), state, deviations)?;
            return Ok(None);
        }
        if !regime.is_free() {
            differentiated(state, deviations, |x| project_onto(self, regime, start, x))?;
        }
        let motion = self.in_regime(regime);
        self.vary::<P, _>(
            (&motion, regime),
            tolerance,
            (at, span),
            (state, deviations),
        )?;
        Ok(None)
    }

    /// The same along steps, of what moves it in a regime: in its own units, in which one tolerance does for all.
    fn vary<P: Stepper<Vec<f64>, Choice: Default>, D: Dynamics>(
        &self,
        (motion, regime): (&D, &Regime),
        tolerance: Tolerance,
        (start, span): (Moment, f64),
        (state, deviations): (&mut DVector<f64>, &mut DMatrix<f64>),
    ) -> Result<()> {
        let ScaledUnits {
            position, velocity, ..
        } = self.units;
        let unit = power_of_two(position / velocity);
        let absolute = tolerance.absolute / position.min(velocity);
        // Deviations are as small beside the motion as makes the absolute tolerance that of what they are known to.
        let known = tolerance.relative.max(DEVIATION_KNOWN);
        let part = (absolute / known).clamp(SMALLEST_DEVIATION, 1.0);
        let power =
            |own: DVectorView<'_, f64>| power_of_two(self.units.size_of(own.iter(), 0.0) / part);
        let powers: Vec<f64> = deviations.column_iter().map(power).collect();
        let scale = |deviations: &mut DMatrix<f64>, by: &dyn Fn(f64) -> f64| {
            for (mut column, power) in deviations.column_iter_mut().zip(&powers) {
                column *= by(*power);
            }
        };
        scale(deviations, &f64::recip);
        let mut x = joined(state.as_slice(), deviations.as_slice());
        let half = x.len() / 2;
        x[half..].iter_mut().for_each(|v| *v *= unit);
        let motion = OwnTime {
            dynamics: motion,
            start,
            unit,
        };
        // The accelerations of other systems are smooth, contact forces are had by differences themselves.
        let is_own = regime.is_free() && matches!(self.system, System::Nonlinear(_));
        let differences = Differences::new(deviations.ncols(), [position, velocity * unit]);
        let noted = WarningLog::default();
        let (warnings, differences) = if is_own {
            (self.warnings.as_ref().map(|_| &noted), differences)
        } else {
            (None, differences.of_one_length())
        };
        let dynamics = Variational::new(&motion, differences, warnings);
        let tolerance = Tolerance {
            absolute: absolute * position,
            ..tolerance
        };
        let part = (OwnTime::<D>::zero(), span / unit);
        integrate::<P, _>(&dynamics, part, tolerance, &mut x, |step| {
            dynamics.look_across(&step)
        })?;
        if let (Some(warnings), Some(doubts)) = (&self.warnings, noted.noted()) {
            for doubt in doubts {
                warnings.note(doubt.at(start.time + doubt.time() * unit));
            }
        }
        x[half..].iter_mut().for_each(|v| *v /= unit);
        parted(&x, state.as_mut_slice(), deviations.as_mut_slice());
        scale(deviations, &|power| power);
        Ok(())
    }

    pub fn rate_of(&self, regime: &Regime, at: Moment, x: &[f64]) -> Result<Vec<f64>> {
        let (q, v) = x.split_at(x.len() / 2);
        let mut a = vec![0.0; q.len()];
        self.in_regime(regime).acceleration(at, q, v, &mut a)?;
        Ok(a)
    }

    /// The contact forces of what the regime holds.
    pub fn forces(&self, regime: &Regime, at: Moment, x: &[f64]) -> Result<Vec<(usize, f64)>> {
        let (q, v) = x.split_at(x.len() / 2);
        let mut a = vec![0.0; q.len()];
        self.in_regime(regime).element_forces(at, q, v, &mut a)
    }

    /// The reaction of a stop at a position.
    fn reaction_at(&self, stop: usize, q: &[f64]) -> Result<DVector<f64>> {
        let reaction = self.contacts[stop].reaction(&self.system, q)?;
        reaction.ok_or(Error::NoConvergence {
            stage: "the mass matrix at an impact, which is singular,",
            iterations: 0,
            residual: f64::NAN,
        })
    }

    /// The normals and reactions of some stops at a position.
    fn directions_at(&self, stops: &[usize], q: &[f64]) -> Result<[Vec<DVector<f64>>; 2]> {
        let mut both = [Vec::new(), Vec::new()];
        for &stop in stops {
            both[0].push(self.contacts[stop].surface.normal(q)?);
            both[1].push(self.reaction_at(stop, q)?);
        }
        Ok(both)
    }

    /// The impact of some stops at a fixed time, and their impulses.
    fn struck(&self, stops: &[usize], t: f64, state: &mut [f64]) -> Result<Vec<f64>> {
        let (q, v) = state.split_at_mut(state.len() / 2);
        let [normals, reactions] = self.directions_at(stops, q)?;
        let changes = DVector::from_fn(stops.len(), |i, _| {
            let speed: f64 = normals[i].iter().zip(v.iter()).map(|(n, v)| n * v).sum();
            let receding = self.stop_motion(stops[i], t)[1];
            self.law(stops[i]).change(speed - receding)
        });
        let impulses = reaction_weights(&normals, &reactions, &changes)?;
        for (reaction, impulse) in reactions.iter().zip(impulses.iter()) {
            for (v, b) in v.iter_mut().zip(reaction.iter()) {
                *v -= b * impulse;
            }
        }
        Ok(impulses.iter().copied().collect())
    }
}

#[cfg(test)]
impl IntegratedMaps {
    /// The same without series.
    pub fn in_steps(self) -> Self {
        Self {
            series: None,
            ..self
        }
    }
}

impl HybridMaps for IntegratedMaps {
    fn flow(
        &self,
        regime: &Regime,
        span: (f64, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<()> {
        self.flow_by_jacobian(regime, span, state, deviations)?;
        Ok(())
    }

    fn flow_by_jacobian(
        &self,
        regime: &Regime,
        span: (f64, f64),
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<Option<DMatrix<f64>>> {
        if deviations.ncols() == 0 || self.series_of(regime).is_some() {
            return self.flow_by::<OrbitMethod>(self.tolerance, (regime, span), state, deviations);
        }
        // The motion is the one that it is without them: a loop closes by the same map that it is corrected by.
        let beside = &mut state.clone();
        let jacobian =
            self.flow_by::<OrbitMethod>(self.tolerance, (regime, span), beside, deviations)?;
        let none = &mut DMatrix::zeros(state.len(), 0);
        self.flow_by::<OrbitMethod>(self.tolerance, (regime, span), state, none)?;
        Ok(jacobian)
    }

    fn closes_to(&self) -> f64 {
        ORBIT_CLOSED_BY_STEPS
    }

    fn rate(&self, regime: &Regime, t: f64, state: &DVector<f64>) -> Result<DVector<f64>> {
        let a = self.rate_of(regime, self.moment(t), state.as_slice())?;
        let v = state.rows(a.len(), a.len());
        Ok(DVector::from_iterator(
            state.len(),
            v.iter().copied().chain(a),
        ))
    }

    fn impact(
        &self,
        stops: &[usize],
        t: f64,
        state: &mut DVector<f64>,
        deviations: &mut DMatrix<f64>,
    ) -> Result<Vec<f64>> {
        if stops.is_empty() {
            return Ok(Vec::new());
        }
        differentiated(state, deviations, |x| {
            self.struck(stops, t, x.as_mut_slice())
        })
    }

    fn kick(&self, stops: &[usize], state: &DVector<f64>, s: DVector<f64>) -> Result<DVector<f64>> {
        let q = &state.as_slice()[..state.len() / 2];
        let [normals, reactions] = self.directions_at(stops, q)?;
        let changes = DVector::from_fn(s.len(), |i, _| self.law(stops[i]).change(s[i]));
        along_reactions(&normals, &reactions, &changes)
    }

    fn stop_motion(&self, stop: usize, t: f64) -> [f64; 3] {
        self.contacts[stop].own_motion(|| self.moment(t))
    }

    fn gap(&self, stop: usize, t: f64, state: &DVector<f64>) -> Result<GapAt> {
        let (contact, q) = (&self.contacts[stop], &state.as_slice()[..state.len() / 2]);
        Ok(GapAt {
            gap: contact.gap(q, self.moment(t))?,
            gradient: -contact.surface.normal(q)?,
            slope: self.stop_motion(stop, t)[1],
        })
    }

    fn gap_acceleration(
        &self,
        stop: usize,
        t: f64,
        state: &DVector<f64>,
        rate: &DVector<f64>,
    ) -> Result<f64> {
        let n = state.len() / 2;
        let ((q, v), a) = (state.as_slice().split_at(n), &rate.as_slice()[n..]);
        let slow = slow_time(q, v, a);
        let value = self.contacts[stop].along(|| self.moment(t), (q, v, a), slow)?;
        Ok(value.acceleration)
    }

    fn reaction(&self, stop: usize, state: &DVector<f64>) -> Result<DVector<f64>> {
        self.reaction_at(stop, &state.as_slice()[..state.len() / 2])
    }

    fn law(&self, stop: usize) -> Newton {
        self.contacts[stop].law()
    }

    fn contact_law(&self, element: usize) -> &Law {
        &self.contacts[element].law
    }
}

/// Applies a map to a state, and its Jacobian, by central differences, to deviations.
fn differentiated<T>(
    state: &mut DVector<f64>,
    deviations: &mut DMatrix<f64>,
    map: impl Fn(&mut DVector<f64>) -> Result<T>,
) -> Result<T> {
    let reach = state.amax();
    for mut column in deviations.column_iter_mut() {
        let size = column.amax();
        if size == 0.0 {
            continue;
        }
        let step = CENTRAL_DIFFERENCE_STEP * if reach > 0.0 { reach } else { 1.0 } / size;
        let (mut ahead, mut behind) = (&*state + &column * step, &*state - &column * step);
        map(&mut ahead)?;
        map(&mut behind)?;
        column.copy_from(&((ahead - behind) / (2.0 * step)));
    }
    map(state)
}
