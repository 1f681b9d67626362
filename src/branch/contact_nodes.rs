//! Loops with a contact more or less of a stop that gives way, where that is touched: at a duration of zero they are the same motion (theory
//! 22, "Touches"). Times in \[s\].

use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::BranchProblem;
use crate::branch::shooting_nodes::period;
use crate::continuation::ScaledDirection;
use crate::error::Result;
use crate::hybrid::carried;
use crate::itinerary::{begun_with_impact, relaxed, states_of_touch, without_contact};
use crate::law::{ContactLaw, ElementState, Stage, Transition};
use crate::orbit::{ShootingState, with_maps};
use crate::tolerance::PLACE_FORGOTTEN;

/// A contact of a loop with a stop that gives way.
#[derive(Debug, Clone, Copy)]
pub(super) struct BriefContact {
    pub stop: usize,
    /// The instant with which it begins, and how many later the stop is left.
    pub instant: usize,
    pub length: usize,
}

impl BriefContact {
    /// How long it lasts \[s\].
    pub fn duration(self, state: &ShootingState) -> f64 {
        let (times, count) = (&state.times, state.states.len());
        let end = self.instant + self.length;
        times[end % count] + (end / count) as f64 * period(state) - times[self.instant]
    }
}

/// A loop without a contact, and its problem.
pub(super) struct LoopWithout<'a> {
    pub problem: BranchProblem<'a>,
    pub place: ParametricLoop,
    /// When the contact was, from the first instant of the loop.
    pub time: f64,
}

impl<'a> BranchProblem<'a> {
    /// The contacts of its loops with stops that give way; of loops that close with their mirror image those that end in the half that is
    /// followed.
    pub fn brief_contacts(&self) -> impl Iterator<Item = BriefContact> + '_ {
        let stages = &self.signature.stages;
        let is_whole = self.signature.images.is_none();
        (0..stages.len()).filter_map(move |instant| {
            let stop = stages.stage(instant).transition.press()?;
            let length = stages.contact_length(instant)?;
            (is_whole || instant + length < stages.len()).then_some(BriefContact {
                stop,
                instant,
                length,
            })
        })
    }

    /// Whether a stop is rigid in the scene of a loop.
    pub fn is_rigid_at(&self, place: &ParametricLoop, stop: usize) -> Result<bool> {
        Ok(self.scene(place.value)?.stops()[stop].contact().is_rigid())
    }

    /// The direction in which the duration of a contact grows, per unit of scaled time, while all else stays.
    pub fn longer(&self, place: &ParametricLoop, contact: BriefContact) -> BranchDirection {
        let mut along = BranchDirection::of_value(self.n_unknowns(place)).scaled(0.0);
        let (before, count) = (place.before_times().len(), place.state.states.len());
        let last = contact.instant + contact.length;
        for (instant, way) in [(contact.instant, -1.0), (last, 1.0)] {
            // Without forcing the first instant is at time zero, and the period is unknown.
            let unknown = if self.is_free {
                instant.checked_sub(1)
            } else {
                Some(instant % count)
            };
            if let Some(unknown) = unknown {
                along.loop_part[before + unknown] += way;
            }
        }
        along
    }

    /// A loop with a contact of some duration where a stop is touched, at a time from its first instant; not closed. None where there is no
    /// room for it.
    pub fn with_contact(
        &self,
        place: &ParametricLoop,
        (stop, time): (usize, f64),
        duration: f64,
    ) -> Result<Option<(Self, ParametricLoop, BriefContact)>> {
        let state = &place.state;
        let mut instants = self.instants(state);
        let whole = period(state);
        let mut time = state.times[0] + time.rem_euclid(whole);
        let flight = instants.iter().rposition(|own| own.start <= time);
        let Some(flight) = flight else {
            return Ok(None);
        };
        let base = instants[flight].clone();
        let end = instants
            .get(flight + 1)
            .map_or(state.times[0] + whole, |own| own.time);
        let scene = self.scene(place.value)?;
        let law = scene.stops()[stop].contact().by_state();
        let states = states_of_touch(law);
        let relaxes = states.last() == Some(&ElementState::Relaxing);
        let images = self.signature.images.as_ref();
        let image = images.map(|images| images[stop]).filter(|_| relaxes);
        if image.is_some() && !self.is_back_in_time(law, (whole, duration)) {
            return Ok(None);
        }
        // Where the force ends it, a body has no speed any more.
        let lead = if relaxes { duration } else { 0.5 * duration };
        let step = duration / (states.len() - 1) as f64;
        let is_alone = self.is_empty();
        if is_alone && time - lead < base.start {
            time += whole;
        }
        let has_room = time - lead > base.start && time + duration - lead < end;
        if !(is_alone || has_room) {
            return Ok(None);
        }
        let mut free = base.stage.regime.without(stop);
        // What the stop does in one half its image does in the next.
        if let Some(image) = image {
            free = free.with(image, ElementState::Relaxing);
        }
        let contact = with_maps(&scene, &self.signature, |motion| {
            let mut from = ElementState::Free;
            let mut own = Vec::with_capacity(states.len());
            for (i, &to) in states.iter().enumerate() {
                let mut instant = base.clone();
                instant.time = time - lead + i as f64 * step;
                instant.start = instant.time;
                instant.state = carried(
                    motion,
                    &base.stage.regime,
                    (base.start, instant.time),
                    &base.state,
                )?;
                let Some(transition) = Transition::change(law, stop, [from, to]) else {
                    return Ok(None);
                };
                instant.stage = Stage {
                    transition,
                    regime: free.with(stop, to),
                };
                own.push(instant);
                from = to;
            }
            Ok(Some(own))
        })?;
        let Some(contact) = contact else {
            return Ok(None);
        };
        let (instant, length) = (if is_alone { 0 } else { flight + 1 }, contact.len() - 1);
        if is_alone {
            instants.clear();
        }
        instants.splice(instant..instant, contact);
        // A mirror image has its own contact in the other half.
        let again = if images.is_some() { 2.0 * whole } else { whole };
        relaxed(&mut instants, (stop, law), again);
        let own = (whole, self.signature.n_periods);
        let (mut problem, place) = self.with_instants(place.value, instants, own)?;
        problem.signature.images.clone_from(&self.signature.images);
        let contact = BriefContact {
            stop,
            instant,
            length,
        };
        Ok(Some((problem, place, contact)))
    }

    /// Whether a stop that relaxes is back before its next contact in loops that close with their mirror image, where it has no other in a period.
    fn is_back_in_time(&self, law: &dyn ContactLaw, (half, duration): (f64, f64)) -> bool {
        let relaxation = law.relaxation(ElementState::Relaxing);
        let is_back = relaxation.is_some_and(|own| {
            own.beyond == 0.0 && own.rate * (2.0 * half - duration) >= PLACE_FORGOTTEN
        });
        is_back && self.is_empty()
    }

    /// A loop without one of its contacts; none where nothing is left with which a period could begin.
    pub fn without_contact(
        &self,
        place: &ParametricLoop,
        contact: BriefContact,
    ) -> Result<Option<LoopWithout<'a>>> {
        let whole = period(&place.state);
        let instants = self.instants(&place.state);
        let middle = instants[contact.instant].time + 0.5 * contact.duration(&place.state);
        let scene = self.scene(place.value)?;
        let law = scene.stops()[contact.stop].contact().by_state();
        let own = (contact.instant, contact.length);
        let mut rest = without_contact(&instants, own, (contact.stop, law), whole);
        if let Some(images) = &self.signature.images
            && rest[0].stage.transition.is_nothing()
        {
            // What is left of its image is gone with it.
            let regime = &mut rest[0].stage.regime;
            *regime = regime.without(images[contact.stop]);
        }
        let is_whole = self.signature.images.is_none();
        let begun = if is_whole {
            begun_with_impact(rest, whole)
        } else {
            let begins = |own: &Transition| own.is_nothing() || !own.begun().is_empty();
            begins(&rest[0].stage.transition).then_some(rest)
        };
        let Some(begun) = begun else {
            return Ok(None);
        };
        if self.is_free && begun[0].stage.transition.is_nothing() {
            return Ok(None);
        }
        let time = (middle - begun[0].time).rem_euclid(whole);
        let length = (whole, self.signature.n_periods);
        let (mut problem, place) = self.with_instants(place.value, begun, length)?;
        problem.signature.images.clone_from(&self.signature.images);
        Ok(Some(LoopWithout {
            problem,
            place,
            time,
        }))
    }
}
