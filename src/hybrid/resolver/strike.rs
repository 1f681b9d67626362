//! Impacts at one instant: each stop by itself, or the law of several together (theory 9); when impacts on several stops come to
//! rest.

use super::chatter::stay_open;
use super::{Resolved, Resolver, Unresolved, least_speed};

use crate::error::Result;
use crate::hybrid::recorder::Recorder;
use crate::hybrid::system::{GapState, HybridSystem, NormalImpact};
use crate::impact::{CompleteChatter, Impact, resolve_impacts};
use crate::model::impulses_of;
use crate::quantity::positive_part;
use crate::tolerance::{GAP_ROUNDING, IMPACT_RATE_MATCH, IMPULSE_ROUNDING, SPEED_ROUNDING};
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
    fn note_prior_sizes<Y: HybridSystem + ?Sized>(&mut self, system: &Y) -> Result<()> {
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

    /// Whether the stops that are approached are struck for the last time: the impacts before were in the ratio of restitution, or
    /// their flight rose by no more than rounding, which then feeds it, and flights from these would rise by no more than rounding;
    /// or by what rounding leaves of that, whatever came before.
    pub(super) fn are_spent<Y: HybridSystem + ?Sized>(&self, system: &Y) -> Result<bool> {
        // From most impacts flights rise by more than rounding, whatever came before.
        let may_rest = |&stop: &usize| {
            let GapState {
                speed,
                acceleration,
                ..
            } = system.gap(stop);
            let departure = system.law(stop).departure(speed);
            self.is_low((stop, departure), -acceleration, GAP_ROUNDING)
        };
        if self.held.is_empty() && !self.touching.iter().any(may_rest) {
            return Ok(false);
        }
        let mut any = false;
        for &stop in &self.touching {
            let state = system.gap(stop);
            if !self.closes_at(system, stop, state) {
                continue;
            }
            let (law, speed) = (system.law(stop), -state.speed);
            if !law.is_contracting() {
                return Ok(false);
            }
            let pull = -self.drawn(system, (stop, state), &self.held)?;
            let before = self.approaches[stop];
            let is_regular = law.is_repeated(before, speed);
            let is_low = |speed, part| self.is_low((stop, law.departure(speed)), pull, part);
            let flight = self.departure.map(|then| then.until(system.clock()));
            let is_fed = || {
                let fall = 2.0 * law.restitution * before / pull;
                is_low(before, GAP_ROUNDING) && flight.is_some_and(|flight| flight < 2.0 * fall)
            };
            let rounding = if is_regular || is_fed() {
                GAP_ROUNDING
            } else {
                SPEED_ROUNDING.powi(2)
            };
            if !is_low(speed, rounding) {
                return Ok(false);
            }
            any = true;
        }
        Ok(any)
    }

    /// Whether a flight that leaves a stop at a speed, drawn back to it, rises by no more than a part of the motion.
    fn is_low(&self, (stop, speed): (usize, f64), pull: f64, part: f64) -> bool {
        0.25 * speed * speed < part * self.sizes[stop] * pull
    }

    /// The end of impacts that lose speed, on several stops or beside stops that are held: what is left of the speeds is taken
    /// away. The rest of a sequence on one stop beside others that are held takes the time that it takes there; that of impacts on
    /// several stops, whose order nobody knows, none.
    #[cold]
    pub(super) fn come_to_rest<Y: HybridSystem + ?Sized, R: Recorder>(
        &mut self,
        system: &mut Y,
        t_end: f64,
        recorder: &mut R,
    ) -> Resolved {
        let struck: Vec<usize> = self
            .touching
            .iter()
            .copied()
            .filter(|&stop| self.closes(system, stop))
            .collect();
        let lasting = self.lasting_rest(system, &struck)?;
        if lasting.is_none() {
            for &stop in &struck {
                system.record_chatter(stop, recorder)?;
            }
        }
        self.prior_sizes.fill(0.0);
        self.note_prior_sizes(system)?;
        let inelastic = DVector::zeros(self.touching.len());
        if let Err(unresolved) = self.strike_together(system, &inelastic, None::<&mut R>)? {
            return Ok(Err(unresolved));
        }
        system.evaluate_gaps()?;
        // What the last impulses throw off others, and no higher than rounding before what rests draws it back, comes to rest with them.
        let rest = self.zero_speed.clone();
        for k in 0..self.touching.len() {
            let stop = self.touching[k];
            if rest.contains(&stop) {
                continue;
            }
            let state = system.gap(stop);
            let pull = -self.drawn(system, (stop, state), &rest)?;
            if self.is_low((stop, state.speed), pull, GAP_ROUNDING) {
                self.zero_speed.push(stop);
            }
        }
        if let Some(span) = lasting {
            let now = system.clock();
            let left = now.until(now.at(t_end)).max(0.0);
            let beside = self.touching.iter().filter(|&stop| !struck.contains(stop));
            let all: Vec<usize> = struck.iter().chain(beside).copied().collect();
            system.complete_chatter(&all, span.min(left), recorder)?;
        }
        self.settle(system)
    }

    /// The time that the rest of impacts takes on the one stop that is struck, where all others in contact are held and stay so, and
    /// what is open stays open: they are those of a single stop, drawn to it by what the others leave of its acceleration.
    fn lasting_rest<Y: HybridSystem + ?Sized>(
        &self,
        system: &Y,
        struck: &[usize],
    ) -> Result<Option<f64>> {
        let &[stop] = struck else {
            return Ok(None);
        };
        let are_held = |other: &usize| *other == stop || self.held.contains(other);
        if !self.touching.iter().all(are_held) {
            return Ok(None);
        }
        let state = system.gap(stop);
        let chatter = CompleteChatter {
            law: system.law(stop),
            speed: state.speed,
            acceleration: self.drawn(system, (stop, state), &self.held)?,
        };
        let open = (0..system.n_stops()).filter(|other| !self.touching.contains(other));
        let stays = chatter.acceleration < 0.0
            && self.push_with(system, stop)?
            && stay_open(system, (stop, chatter), open)?;
        Ok(stays.then(|| chatter.span()))
    }

    /// Whether an impact on a stop presses all that are held, which stay closed.
    fn push_with<Y: HybridSystem + ?Sized>(&self, system: &Y, stop: usize) -> Result<bool> {
        let all: Vec<usize> = self.held.iter().copied().chain([stop]).collect();
        let mut speeds = DVector::zeros(all.len());
        speeds[all.len() - 1] = 1.0;
        let impulses = impulses_of(&system.delassus(&all)?, &speeds)?;
        Ok(impulses.iter().all(|impulse| *impulse >= 0.0))
    }

    /// The restitution coefficients of the stops in contact.
    fn restitutions<Y: HybridSystem + ?Sized>(&self, system: &Y) -> DVector<f64> {
        let each = (self.touching.iter()).map(|&stop| system.law(stop).restitution);
        DVector::from_iterator(self.touching.len(), each)
    }

    /// The impacts of all stops in contact at one instant (Newton and Moreau), with their restitution coefficients.
    fn strike_together<Y: HybridSystem + ?Sized, R: Recorder>(
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
