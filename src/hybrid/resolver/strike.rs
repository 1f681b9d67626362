//! Impacts at one instant: which stops are struck, and whether each by itself or by the law of several together (theory 9). The velocity
//! after an impact on one stop is `NormalImpacts::strike` in `hybrid/system.rs`.

use super::{Resolved, Resolver, Unresolved, least_speed};
use crate::error::Result;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::system::{HybridSystem, NormalImpact};
use crate::impact::{Impact, resolve_impacts};
use crate::model::impulses_of;
use crate::quantity::positive_part;
use crate::tolerance::{GAP_ROUNDING, IMPACT_RATE_MATCH, IMPULSE_ROUNDING};
use nalgebra::{DMatrix, DVector};

/// Number of earlier impacts whose speeds set the rounding of the next ones, in a check that debug builds alone make. [work]
const RECENT_IMPACTS: usize = 100;

impl Resolver {
    /// The impacts of those stops in contact that are approached: each by itself where they are decoupled, else by the law
    /// of several stops at one instant.
    pub(super) fn resolve_contacts<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        recorder: &mut R,
    ) -> Resolved {
        let count = self.n_impacts;
        let excess = self.impacts.len().saturating_sub(RECENT_IMPACTS);
        self.impacts.drain(..excess);
        let first = self.impacts.len();
        self.prior_sizes.fill(0.0);
        self.note_prior_sizes(system)?;
        if self.touching.len() > 1 && self.is_coupled(system) {
            let restitutions = self.restitutions(system);
            if let Err(unresolved) = self.strike_together(system, &restitutions, Some(recorder))? {
                return Ok(Err(unresolved));
            }
        } else {
            for k in 0..self.touching.len() {
                let stop = self.touching[k];
                if self.closes(system, stop) {
                    let impact = system.strike(stop)?;
                    self.note(system, stop, impact, recorder);
                    if impact.departure == 0.0 {
                        self.zero_speed.push(stop);
                    }
                } else if self.held.contains(&stop) {
                    // What is left of its speed is rounding, of a gap that is none.
                    self.zero_speed.push(stop);
                }
            }
        }
        if self.n_impacts == count {
            self.prior_sizes.fill(0.0);
        }
        system.evaluate_gaps()?;
        debug_assert!(
            agree(system, &self.touching, &self.impacts, first),
            "{:?}",
            &self.impacts[first..]
        );
        self.settle(system)
    }

    /// Takes note of the sizes of accelerations before and between impacts, where others than the stop that was reached are in
    /// contact.
    pub(super) fn note_prior_sizes<Y: HybridSystem + ?Sized>(&mut self, system: &Y) -> Result<()> {
        if self.touching.len() > 1 {
            let sizes = system.acceleration_sizes(&self.touching)?;
            for (&stop, size) in self.touching.iter().zip(sizes) {
                self.prior_sizes[stop] = size.max(self.prior_sizes[stop]);
            }
        }
        Ok(())
    }

    /// Whether a stop that is approached is coupled to another in contact.
    fn is_coupled<Y: HybridSystem + ?Sized>(&self, system: &Y) -> bool {
        let pairs = |&stop: &usize| self.touching.iter().map(move |&other| (stop, other));
        self.touching
            .iter()
            .filter(|&&stop| self.closes(system, stop))
            .flat_map(pairs)
            .any(|(stop, other)| stop != other && system.is_coupled(stop, other))
    }

    /// The restitution coefficients of the stops in contact.
    fn restitutions<Y: HybridSystem + ?Sized>(&self, system: &Y) -> DVector<f64> {
        let each = (self.touching.iter()).map(|&stop| system.law(stop).restitution);
        DVector::from_iterator(self.touching.len(), each)
    }

    /// The impacts of all stops in contact at one instant (Newton and Moreau), with their restitution coefficients.
    pub(super) fn strike_together<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        restitutions: &DVector<f64>,
        mut recorder: Option<&mut R>,
    ) -> Resolved {
        let stops = self.touching.clone();
        let each = |of: &dyn Fn(usize) -> f64| {
            DVector::from_iterator(stops.len(), stops.iter().map(|&stop| of(stop)))
        };
        let (held, still) = (&self.held, &self.zero_speed);
        let speeds = each(&|stop| {
            if held.contains(&stop) || still.contains(&stop) {
                0.0
            } else {
                system.gap(stop).speed
            }
        });
        let slack = each(&|stop| least_speed(system, stop, system.gap(stop)));
        let delassus = system.delassus(&stops)?;
        let Ok(resolved) = resolve_impacts(&delassus, restitutions, &speeds, &slack) else {
            let reason = format!("no impulses that push resolve the contacts {stops:?}: a jam");
            return Ok(Err(Unresolved { reason }));
        };
        self.n_inelastic += usize::from(resolved.is_inelastic);
        self.zero_speed.clear();
        let kick = |k: usize| delassus[(k, k)] * resolved.impulses[k];
        let least = IMPULSE_ROUNDING * (0..stops.len()).map(kick).fold(0.0, f64::max);
        for (k, &stop) in stops.iter().enumerate() {
            let impulse = resolved.impulses[k];
            let departure = resolved.opening_speeds[k];
            if kick(k) > least {
                system.push(stop, impulse)?;
                self.note_prior_sizes(system)?;
                let impact = NormalImpact {
                    approach: positive_part(-speeds[k]),
                    departure,
                    impulse,
                };
                if let Some(recorder) = recorder.as_deref_mut() {
                    self.note(system, stop, impact, recorder);
                }
            }
            if departure == 0.0 {
                self.zero_speed.push(stop);
            }
        }
        if !self.zero_speed.is_empty() {
            take(system, &stops, &resolved.opening_speeds, &delassus)?;
        }
        Ok(Ok(()))
    }

    /// Takes note of an impact.
    fn note<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &Y,
        stop: usize,
        impact: NormalImpact,
        recorder: &mut R,
    ) {
        self.last_impact = Some((stop, impact.approach));
        self.approaches[stop] = impact.approach;
        self.impulses.push((stop, impact.impulse));
        self.n_impacts += 1;
        if recorder.wanted().events {
            let impact = as_recorded(system, stop, impact);
            if cfg!(debug_assertions) {
                self.impacts.push(impact);
            }
            recorder.impact(impact);
        }
    }
}

/// Whether the motion leaves stops that were struck at one instant as the rows of their impacts say: those from the first one on.
fn agree<Y: HybridSystem + ?Sized>(
    system: &Y,
    touching: &[usize],
    impacts: &[Impact],
    first: usize,
) -> bool {
    let (before, impacts) = impacts.split_at(first);
    // A speed below the rounding at one stop in contact is rounding at the others, too, and so is one below the rounding of earlier, faster
    // impacts.
    let least = |&stop: &usize| least_speed(system, stop, system.gap(stop));
    let least = touching.iter().map(least).fold(f64::MIN_POSITIVE, f64::max);
    let earlier = before
        .iter()
        .rev()
        .take(RECENT_IMPACTS)
        .map(|impact| impact.approach);
    let least = least.max(GAP_ROUNDING * earlier.fold(0.0, f64::max));
    // The forcing's part of a speed is known to the rounding of the time.
    let stops: Vec<usize> = impacts.iter().map(|impact| impact.stop).collect();
    let pulls = system.acceleration_sizes(&stops).unwrap_or_default();
    let pull = pulls.into_iter().fold(0.0, f64::max);
    let least = least.max(f64::EPSILON * system.clock().time().abs() * pull);
    impacts.iter().all(|impact| {
        let (stop, state) = (impact.stop, system.gap(impact.stop));
        let kick = |other: &Impact| {
            let give = system.delassus(&[stop, other.stop]);
            give.map_or(0.0, |give| give[(0, 1)].abs() * other.impulse)
        };
        let size = system.speed_size(stop) + impacts.iter().map(kick).sum::<f64>();
        // The law of several stops is known to some roundings; below the normal numbers there are few digits.
        let allowed = IMPACT_RATE_MATCH * size + 10.0 * least;
        (state.speed - impact.departure).abs() <= allowed
    })
}

/// An impact as it is recorded.
#[inline(never)]
fn as_recorded<Y: HybridSystem + ?Sized>(system: &Y, stop: usize, impact: NormalImpact) -> Impact {
    Impact {
        time: system.clock().time(),
        stop,
        approach: impact.approach,
        departure: impact.departure,
        impulse: impact.impulse,
        phase: system.phase(),
    }
}

/// Gives the motion the opening speeds that the law says, to the last digit: those that are none decide what is held, and rounding of
/// impulses is no speed.
pub(super) fn take<Y: HybridSystem + ?Sized>(
    system: &mut Y,
    stops: &[usize],
    opening: &DVector<f64>,
    delassus: &DMatrix<f64>,
) -> Result<()> {
    system.evaluate_gaps()?;
    let left = |k: usize| opening[k] - system.gap(stops[k]).speed;
    let left = DVector::from_fn(stops.len(), |k, _| left(k));
    let impulses = impulses_of(delassus, &left)?;
    for (&stop, &impulse) in stops.iter().zip(impulses.iter()) {
        system.push(stop, impulse)?;
    }
    Ok(())
}
