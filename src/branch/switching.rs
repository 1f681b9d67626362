//! Other branches that meet a branch at a special point: an orbit of each nearby (theory 19).

use crate::branch::behind::behind;
use crate::branch::candidate::Candidate;
use crate::branch::corrector::directions;
use crate::branch::energy::energy_at;
use crate::branch::family::Family;
use crate::branch::instants::{period, turned};
use crate::branch::landed::with_change;
use crate::branch::lessened::with_less;
use crate::branch::place::{Direction, Place};
use crate::branch::risen::with_flight;
use crate::branch::simulated::beyond;
use crate::branch::special::{Special, SpecialKind};
use crate::branch::step::{Target, step_to};
use crate::branch::touched::Touched;
use crate::error::{Error, Result};
use crate::linalg::rank;
use crate::model::{Parameter, Scene};
use crate::orbit::{Event, Signature, with_shooting};
use nalgebra::{DMatrix, dvector};

/// How far beside a branch an orbit of another is looked for at first, in its scaled unknowns, and how often half as far.
const ASIDE: f64 = 0.01;
const MOST_HALVINGS: usize = 12;
/// The speed of an impact that is born, in the unit of velocities, and the step by which its growth is measured.
const SLOW: f64 = 1e-3;
const TRIED: f64 = 1e-5;
/// The most periods from one impact that is born to the next.
const MOST_ROUNDS: usize = 6;
/// A stay or a flight of so small a part of the period is one that comes to nothing at a border.
const LITTLE: f64 = 1e-3;
/// How far from a boundary, in parts of the range, the orbit beyond is.
const BEYOND: f64 = 1e-4;
/// By what factor nearer it is looked for where it breaks a rule of contact there, and how often.
const NEARER: f64 = 0.1;
const MOST_NEARER: i32 = 3;

/// The branches that meet a branch over a number of its scene at a special point, an orbit of each near it: at a period doubling the one of twice
/// the period; at a boundary those with an impact more, in one to six rounds, or less, or with two in the other order, or with a flight or a stay
/// on a stop more or less where a contact comes or goes. None at a fold.
///
/// `between` is the range of the branch. Of branches that are born at a graze most are not admissible, and say so; those that are come
/// first. What is not found near the point is left out.
///
/// # Errors
/// As [`continuation`](crate::continuation).
///
/// # References
/// Theory section 19, "Switching"; A. B. Nordmark, J. Sound Vib. 145 (1991) 279.
///
/// # Examples
/// ```
/// use std::ops::ControlFlow;
/// use vibroimpact::{ContinuationOptions, OrbitOptions, Parameter, Pattern, SpecialKind, branches, continuation, periodic_orbits};
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{Harmonic, LinearSystem, Scene, Stop};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![7.0.into()], 2.4, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
/// let orbits = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default())?;
/// let (parameter, range) = (Parameter::ForcingScale, (0.5, 2.0));
/// let branch = continuation(&orbits[0], parameter, range, &ContinuationOptions::default(), &mut |_| ControlFlow::Continue(()))?;
/// let doubling = branch.special.iter().find(|own| own.kind == SpecialKind::PeriodDoubling).expect("one");
/// let born = branches(doubling, parameter, range)?;
/// assert_eq!(born[0].orbit.n_periods(), 2);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn branches(
    special: &Special,
    parameter: Parameter,
    between: (f64, f64),
) -> Result<Vec<Candidate>> {
    branches_of(special, &special.scenes_over(parameter), between)
}

/// The same over scenes of any kind, one for each value.
///
/// # Errors
/// As [`branches`]; what `make` says.
pub fn branches_of(
    special: &Special,
    make: &dyn Fn(f64) -> Result<Scene>,
    between: (f64, f64),
) -> Result<Vec<Candidate>> {
    let mut begun = Family::around(&special.orbit, make, special.parameter, between)?;
    if special.kind != SpecialKind::Pitchfork {
        begun = begun.0.by_pulses(begun.1)?;
    }
    meeting(special, &begun)
}

/// The same over the energy of the motion ([`continuation_over_energy`](crate::continuation_over_energy)).
///
/// # Errors
/// As [`branches`].
pub fn branches_over_energy(special: &Special, between: (f64, f64)) -> Result<Vec<Candidate>> {
    let (energetics, _) = energy_at(&special.orbit)?;
    let make = |_: f64| Ok(special.orbit.scene().clone());
    let (family, place) = Family::around(&special.orbit, &make, special.parameter, between)?;
    let family = Family {
        energetics: Some(&energetics),
        ..family
    };
    meeting(special, &(family, place))
}

/// The branches that meet a branch at a loop of its scenes.
fn meeting(special: &Special, (family, place): &(Family<'_>, Place)) -> Result<Vec<Candidate>> {
    let mut found = match (special.kind, special.stop.zip(special.time)) {
        // At the tip of a doubled branch the number does not change, in which no branch of one round turns.
        (SpecialKind::PeriodDoubling, _) if special.direction.iter().next_back() == Some(&0.0) => {
            vec![Candidate::at(family, place, special.parameter)?]
        }
        (SpecialKind::PeriodDoubling, _) => found_there(doubled(family, place))?,
        (SpecialKind::Pitchfork, _) => match family.half(place)? {
            Some((half, place)) => found_there(doubled(&half, &place))?,
            None => Vec::new(),
        },
        (SpecialKind::BranchPoint, _) => crossed(family, place, special)?,
        (SpecialKind::Graze, Some(touch)) => born(family, place, touch, None)?,
        (SpecialKind::LostImpact, Some(touch)) => lost(family, place, touch)?,
        (SpecialKind::Rise, Some(rise)) => {
            let rebuilt = |there: &Place| with_flight(family, there, rise);
            found_there(behind(family, place, special, &rebuilt))?
        }
        (SpecialKind::LandingBorder, Some(landing)) => {
            let rebuilt = |there: &Place| with_change(family, there, landing);
            found_there(behind(family, place, special, &rebuilt))?
        }
        (SpecialKind::LandingBorder | SpecialKind::ReleaseBorder, None) => {
            // Where the border is known sharply its orbit has nothing that comes to nothing.
            let state = &place.state;
            let nothing = LITTLE * period(state);
            let is_little = |k: &usize| state.times[k + 1] - state.starts[*k] < nothing;
            let short = place.shortest_flight().filter(is_little);
            let less = short.map_or(Ok(None), |k| with_less(family, place, k))?;
            // On the near side too what it breaks is next to nothing.
            let ahead = special.direction[special.direction.len() - 1].signum();
            let other = match less {
                Some((rest, at)) => beside(&rest, &at, ahead),
                None => beside(family, place, ahead),
            };
            found_there(other)?
        }
        (SpecialKind::Corner, _) => found_there(swapped(family, place))?,
        _ => Vec::new(),
    };
    // Where none of these keeps the rules of contact beyond a boundary, the motion there says what it is.
    let ahead = special.direction[special.direction.len() - 1];
    let goes_on =
        |own: &Candidate| own.is_above == (ahead > 0.0) && own.orbit.is_admissible() != Some(false);
    if special.kind.is_boundary() && !found.iter().any(goes_on) {
        let side = if ahead > 0.0 { 1.0 } else { -1.0 };
        found.extend(found_there(beyond(family, place, side))?);
    }
    found.sort_by_key(|own| own.orbit.is_admissible() == Some(false));
    Ok(found)
}

/// What was found, nothing where the way there leads out of what the number may be.
fn found_there(found: Result<Option<Candidate>>) -> Result<Vec<Candidate>> {
    match found {
        Err(Error::BadValue { .. }) => Ok(Vec::new()),
        found => Ok(found?.into_iter().collect()),
    }
}

/// The orbit of twice the period, along the deviation that comes back reversed; of half a motion the one that is not its mirror image.
fn doubled(family: &Family<'_>, place: &Place) -> Result<Option<Candidate>> {
    let by = &family.deviation(place, -1.0)?;
    let (twice, at) = family.repeated(place, by, &[0.0, 0.0])?;
    let moved = |aside: f64| Ok(family.repeated(place, by, &[aside, -aside])?.1);
    found_aside(&twice, &at, &moved)
}

/// The branch that is crossed, which leaves the plane of both at right angles to the first one.
fn crossed(family: &Family<'_>, place: &Place, special: &Special) -> Result<Vec<Candidate>> {
    let own = Direction::of(&special.direction);
    let is_half = own.loop_part.len() < family.n_unknowns(place);
    let half = if is_half { family.half(place)? } else { None };
    let (family, place) = half
        .as_ref()
        .map_or((family, place), |half| (&half.0, &half.1));
    let equations = family.equations(place)?;
    let plane = rank::weakest(&equations.all_columns(), 2)?;
    let weight = own.row();
    let parts = plane.tr_mul(&weight);
    // Across in the product of directions.
    let across = Direction::of(&(&plane * dvector![-parts[1], parts[0]]));
    let across = across.scaled(1.0 / across.length());
    let mut found = Vec::new();
    for side in [1.0, -1.0] {
        let moved = |aside: f64| family.moved(place, &equations, &across.scaled(side * aside));
        found.extend(found_there(found_aside(family, place, &moved))?);
    }
    Ok(found)
}

/// The orbit of another branch that is so far from an orbit, less if there is none, in a direction.
fn found_aside(
    family: &Family<'_>,
    at: &Place,
    moved: &dyn Fn(f64) -> Result<Place>,
) -> Result<Option<Candidate>> {
    let mut aside = ASIDE;
    for _ in 0..MOST_HALVINGS {
        let to = moved(aside)?;
        let way = family.between(at, &to);
        let length = way.length();
        if let Ok(settled) = family.corrected(to.clone(), &way.scaled(1.0 / length))? {
            let off = family.between(&to, &settled.place);
            if off.length() < length {
                let one = family.one_round(&settled.place)?;
                let (family, place) = one
                    .as_ref()
                    .map_or((family, &settled.place), |(family, place)| (family, place));
                return Candidate::at(family, place, at.value).map(Some);
            }
        }
        aside *= 0.5;
    }
    Ok(None)
}

/// The orbits with one impact more, on a stop that is touched, in some rounds of a loop; not that of so many periods and instants, which is the
/// branch itself.
fn born(
    family: &Family<'_>,
    place: &Place,
    touch: (usize, f64),
    but: Option<(usize, usize)>,
) -> Result<Vec<Candidate>> {
    let mut found = Vec::new();
    let mut with_impact = |touched: &Touched<'_>| -> Result<()> {
        let Signature {
            stages, n_periods, ..
        } = &touched.family.signature;
        let halves = if touched.family.signature.images.is_some() {
            2
        } else {
            1
        };
        // What an impact throws off comes back at an instant more.
        let count = stages.len() + touched.thrown.len();
        if but != Some((*n_periods, halves * count)) {
            found.extend(found_there(with_speed(touched))?);
        }
        Ok(())
    };
    // A motion that is its own mirror image touches two stops, or one twice: it may go on hitting both.
    if let Some((half, at)) = family.half(place)? {
        with_impact(&half.with_touch(&at, half.in_half(&at, touch))?)?;
    }
    for rounds in 1..=MOST_ROUNDS {
        let (several, at) = family.repeated(place, &place.state, &vec![0.0; rounds])?;
        with_impact(&several.with_touch(&at, touch)?)?;
    }
    Ok(found)
}

/// The orbit with an impact more in one round of a loop, on a stop that is touched.
pub(super) fn born_at(
    family: &Family<'_>,
    place: &Place,
    touch: (usize, f64),
) -> Result<Vec<Candidate>> {
    found_there(with_speed(&family.with_touch(place, touch)?))
}

/// The orbit near a loop on which an impact that has no speed there has some. What it throws off a stop that is held comes back to it.
fn with_speed(touched: &Touched<'_>) -> Result<Option<Candidate>> {
    let Touched {
        family,
        place,
        instant,
        thrown,
    } = touched;
    let Some(there) = sped_up(family, place, *instant)? else {
        return Ok(None);
    };
    match thrown[..] {
        [] => Candidate::at(family, &there, place.value).map(Some),
        [stop] if family.signature.images.is_none() => {
            let Some((other, at)) = family.left_at(&there, *instant, stop)? else {
                return Ok(None);
            };
            let by_value = Direction::of_value(other.n_unknowns(&at));
            match other.corrected(at, &by_value)? {
                Ok(settled) => Candidate::at(&other, &settled.place, place.value).map(Some),
                Err(_) => Ok(None),
            }
        }
        _ => Ok(None),
    }
}

/// The loop along its family at which an impact that has no speed has some.
fn sped_up(family: &Family<'_>, place: &Place, instant: usize) -> Result<Option<Place>> {
    let equations = family.equations(place)?;
    let all = directions(&equations)?;
    let [tangent] = all.as_slice() else {
        return Ok(None);
    };
    let tried = family.moved(place, &equations, &tangent.scaled(TRIED))?;
    let growth = family.approach(&tried, instant)? - family.approach(place, instant)?;
    let mut length = (SLOW * family.units.velocity / growth * TRIED).clamp(-ASIDE, ASIDE);
    for _ in 0..MOST_HALVINGS {
        let from = (place, &equations, tangent);
        if let Ok(settled) = step_to(family, from, Target::Length(length))?
            && family.approach(&settled.place, instant)? > 0.0
        {
            return Ok(Some(settled.place));
        }
        length *= 0.5;
    }
    Ok(None)
}

/// The orbit without an impact that has lost its speed, and the others that it meets there.
fn lost(family: &Family<'_>, place: &Place, (stop, time): (usize, f64)) -> Result<Vec<Candidate>> {
    let Signature {
        stages, n_periods, ..
    } = &family.signature;
    let own = (*n_periods, stages.len());
    // A motion that is its own mirror image loses two impacts at once.
    let half = family.half(place)?;
    let (family, place, (stop, time)) = match &half {
        Some((half, at)) => (half, at, half.in_half(at, (stop, time))),
        None => (family, place, (stop, time)),
    };
    let Some(instant) = family.instant_of(place, (stop, time)) else {
        return Ok(Vec::new());
    };
    let touch = (stop, place.state.times[instant]);
    let Some((rest, at)) = family.without(place, instant)? else {
        return Ok(Vec::new());
    };
    let by_value = Direction::of_value(rest.n_unknowns(&at));
    let Ok(settled) = rest.corrected(at, &by_value)? else {
        return Ok(Vec::new());
    };
    let (rest, at) = if rest.signature.images.is_some() {
        rest.whole(&settled.place)?
    } else {
        (rest, settled.place)
    };
    let (rest, at) = rest.one_round(&at)?.unwrap_or((rest, at));
    let mut found: Vec<Candidate> = beside(&rest, &at, 1.0)?.into_iter().collect();
    found.extend(born(&rest, &at, touch, Some(own))?);
    Ok(found)
}

/// The orbit next to a boundary on the side on which it keeps the rules of contact, if on one; a side is looked at first.
fn beside(family: &Family<'_>, place: &Place, first: f64) -> Result<Option<Candidate>> {
    let by_value = Direction::of_value(family.n_unknowns(place));
    let Ok(settled) = family.corrected(place.clone(), &by_value)? else {
        return Ok(None);
    };
    let mut found = None;
    // Past a further boundary it breaks a rule that it keeps nearer to this one.
    let near = (0..MOST_NEARER).flat_map(|k| [first, -first].map(|side| side * NEARER.powi(k)));
    for side in near {
        let value = place.value + side * BEYOND * family.span();
        let from = (&settled.place, &settled.equations, &settled.tangent);
        let Ok(there) = step_to(family, from, Target::Value(value))? else {
            continue;
        };
        let own = Candidate::at(family, &there.place, place.value)?;
        if own.orbit.is_admissible() != Some(false) {
            return Ok(Some(own));
        }
        found.get_or_insert(own);
    }
    Ok(found)
}

/// The orbit beyond a corner that hits its two stops in the other order; where the order matters there mostly is none.
fn swapped(family: &Family<'_>, place: &Place) -> Result<Option<Candidate>> {
    let Some(first) = place.shortest_flight() else {
        return Ok(None);
    };
    let count = place.state.states.len();
    let length = |place: &Place| place.state.times[first + 1] - place.state.times[first];
    let equations = family.equations(place)?;
    let all = directions(&equations)?;
    let [tangent] = all.as_slice() else {
        return Ok(None);
    };
    // On past the corner, where the first of the two would come behind the second.
    let later = family.moved(place, &equations, &tangent.scaled(TRIED))?;
    let grows = length(&later) > length(place);
    let ahead = if grows { -BEYOND } else { BEYOND };
    let past = family.moved(place, &equations, &tangent.scaled(ahead))?;
    let whole = period(&past.state);
    let mut instants = turned(family.instants(&past.state), first, whole);
    // What an impact does to stops that are held is not the same in the other order: there the motion itself is asked.
    if instants
        .iter()
        .take(2)
        .any(|own| !own.stage.held.is_empty())
        || instants
            .last()
            .is_some_and(|own| !own.stage.held.is_empty())
    {
        return Ok(None);
    }
    instants.swap(0, 1);
    let flown = instants.last().cloned().filter(|_| count > 2);
    let before = flown.unwrap_or_else(|| instants[0].clone()).later(-whole);
    let scene = family.scene(past.value)?;
    with_shooting(&scene, &family.signature, |shooting, _| {
        let mut from = before;
        for own in &mut instants[..2] {
            let Event::Strike(stops) = own.stage.event.clone() else {
                return Ok(());
            };
            let none = &mut DMatrix::zeros(from.state.len(), 0);
            let state = &mut from.state;
            let span = (from.start, own.time);
            shooting.motion.flow(&from.stage.held, span, state, none)?;
            shooting.motion.impact(&stops, own.time, state, none)?;
            own.state.copy_from(state);
            (own.start, from) = (own.time, own.clone());
        }
        Ok(())
    })?;
    let n_periods = family.signature.n_periods;
    let (other, at) = family.with_instants(past.value, instants, (whole, n_periods))?;
    let by_value = Direction::of_value(other.n_unknowns(&at));
    let Ok(settled) = other.corrected(at.clone(), &by_value)? else {
        return Ok(None);
    };
    let off = other.between(&at, &settled.place);
    if off.length() > ASIDE {
        return Ok(None);
    }
    Candidate::at(&other, &settled.place, place.value).map(Some)
}
