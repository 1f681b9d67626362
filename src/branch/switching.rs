//! Branch switching: the other branches that meet a branch at a special point, an orbit of each nearby (theory 19, "Switching").

use crate::branch::beyond_boundary::orbit_beyond_boundary;
use crate::branch::candidate::Candidate;
use crate::branch::continuation_parameter::ContinuationParameter;
use crate::branch::energy_level::energy_at;
use crate::branch::landing::with_landing_change;
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::predictor::{StepTarget, step_to};
use crate::branch::problem::{BranchProblem, Formulation};
use crate::branch::reduced_motion::reduced_motion;
use crate::branch::release_onset::with_flight;
use crate::branch::shooting_nodes::period;
use crate::branch::simulated::simulated_beyond;
use crate::branch::special::{Special, SpecialKind};
use crate::branch::through_touch::with_brief_contact;
use crate::branch::touch::TouchingLoop;
use crate::branch::zero_problem::directions;
use crate::continuation::{ScaledDirection, corrected};
use crate::error::{Error, Result};
use crate::hybrid::{carried, reset};
use crate::itinerary::turned;
use crate::linalg::rank;
use crate::orbit::{Signature, with_maps};
use crate::tolerance::{
    ASIDE_LENGTH, BEYOND_BOUNDARY_DISTANCE, BORN_IMPACT_SPEED, BORN_IMPACT_STEP,
    NEARER_BOUNDARY_FACTOR, PAST_CORNER_LENGTH, VANISHING_DURATION,
};
use nalgebra::dvector;

/// Halvings of the distance from a branch at which an orbit of another is looked for. `[work]`
const MOST_ASIDE_HALVINGS: usize = 12;
/// Rounds of a motion in one of which an impact may be born, at the most. `[work]`
const MOST_BORN_ROUNDS: usize = 6;
/// Distances from a boundary at which an orbit is looked for, each nearer than the one before. `[work]`
const MOST_NEARER_ORBITS: i32 = 3;

/// The branches that meet a branch at a special point, an orbit of each near it: at a period doubling the one of
/// twice the period; at a boundary those with an impact more, in one to six rounds, or less, or with two in the other order, or with a
/// flight or a stay on a stop more or less where a contact comes or goes. None at a fold.
///
/// `over` is what the branch goes over: a number of its scene, a function that makes the scene of each value, or the energy of the motion;
/// `between` is its range. Of branches that are born at a graze most are not admissible, and say so; those that are come
/// first. What is not found near the point is left out.
///
/// # Errors
/// As [`continuation`](fn@crate::continuation); what a function says that makes scenes of values.
///
/// # References
/// Theory section 19, "Switching"; A. B. Nordmark, J. Sound Vib. 145 (1991) 279.
///
/// # Examples
/// ```
/// use vibroimpact::{ContinuationOptions, OrbitOptions, Parameter, Pattern, SpecialKind, branches, continuation, periodic_orbits};
/// use vibroimpact::nalgebra::{dmatrix, dvector};
/// use vibroimpact::{Harmonic, LinearSystem, Scene, Stop};
/// let system = LinearSystem::new(dvector![1.0], dmatrix![0.1], dmatrix![1.0])?;
/// let force = Harmonic::new(dvector![7.0.into()], 2.4, 0.0)?;
/// let scene = Scene::new(system, force, [Stop::new(0, 1.0, 0.8)?])?;
/// let orbits = periodic_orbits(&scene, &Pattern::single(0), &OrbitOptions::default())?;
/// let (parameter, range) = (Parameter::ForcingScale, (0.5, 2.0));
/// let branch = continuation(&orbits[0], parameter, range, &ContinuationOptions::default())?;
/// let doubling = branch.special.iter().find(|own| own.kind == SpecialKind::PeriodDoubling).expect("one");
/// let born = branches(doubling, parameter, range)?;
/// assert_eq!(born[0].orbit.n_periods(), 2);
/// # Ok::<(), vibroimpact::Error>(())
/// ```
pub fn branches<'a>(
    special: &Special,
    over: impl Into<ContinuationParameter<'a>>,
    between: (f64, f64),
) -> Result<Vec<Candidate>> {
    let over = over.into();
    let make = |value: f64| over.scene(&special.orbit, special.parameter, value);
    let (problem, place) =
        BranchProblem::around(&special.orbit, &make, special.parameter, between)?;
    if let ContinuationParameter::Energy = over {
        let (energetics, _) = energy_at(&special.orbit)?;
        let problem = BranchProblem {
            formulation: Formulation::EnergyLevel(&energetics),
            ..problem
        };
        return meeting(special, &(problem, place));
    }
    if special.kind == SpecialKind::Pitchfork {
        return meeting(special, &(problem, place));
    }
    meeting(special, &problem.by_impulses(place)?)
}

/// The branches that meet a branch at a loop of its scenes.
fn meeting(
    special: &Special,
    (problem, place): &(BranchProblem<'_>, ParametricLoop),
) -> Result<Vec<Candidate>> {
    let mut found = match (special.kind, special.stop.zip(special.time)) {
        // The parameter does not change along the tangent at the end of a doubled branch; it does on the branch of half the period.
        (SpecialKind::PeriodDoubling, _) if special.direction.iter().next_back() == Some(&0.0) => {
            vec![Candidate::at(problem, place, special.parameter)?]
        }
        (SpecialKind::PeriodDoubling, _) => found_there(doubled(problem, place))?,
        (SpecialKind::Pitchfork, _) => match problem.half(place)? {
            Some((half, place)) => found_there(doubled(&half, &place))?,
            None => Vec::new(),
        },
        (SpecialKind::BranchPoint, _) => crossed(problem, place, special)?,
        (
            SpecialKind::Touch
            | SpecialKind::BorderCollision
            | SpecialKind::Graze
            | SpecialKind::LostImpact,
            Some(touch),
        ) if !problem.is_rigid_at(place, touch.0)? => {
            // The branch itself has one, or none, in each round.
            let own = if special.kind == SpecialKind::Graze {
                1
            } else {
                2
            };
            let mut found = contacts_born(problem, place, touch, own)?;
            if special.kind == SpecialKind::LostImpact {
                found.extend(found_there(beside(problem, place, 1.0))?);
            }
            found
        }
        (SpecialKind::Graze, Some(touch)) => born(problem, place, touch, None)?,
        (SpecialKind::LostImpact, Some(touch)) => lost(problem, place, touch)?,
        (SpecialKind::Rise, Some(rise)) => {
            let rebuilt = |there: &ParametricLoop| with_flight(problem, there, rise);
            found_there(orbit_beyond_boundary(problem, place, special, &rebuilt))?
        }
        (SpecialKind::LandingBorder, Some(landing)) => {
            let rebuilt = |there: &ParametricLoop| with_landing_change(problem, there, landing);
            found_there(orbit_beyond_boundary(problem, place, special, &rebuilt))?
        }
        (SpecialKind::LandingBorder | SpecialKind::ReleaseBorder, None) => {
            // Where the border is located, its orbit is the reduced motion already.
            let state = &place.state;
            let nothing = VANISHING_DURATION * period(state);
            let is_little = |k: &usize| state.times[k + 1] - state.starts[*k] < nothing;
            let short = place.shortest_flight().filter(is_little);
            let less = short.map_or(Ok(None), |k| reduced_motion(problem, place, k))?;
            // On this side of the border too the rule that it breaks is broken by next to nothing.
            let ahead = special.direction[special.direction.len() - 1].signum();
            let other = match less {
                Some((rest, at)) => beside(&rest, &at, ahead),
                None => beside(problem, place, ahead),
            };
            found_there(other)?
        }
        (SpecialKind::Corner, _) => found_there(swapped(problem, place))?,
        _ => Vec::new(),
    };
    // Where none of these keeps the rules of contact beyond a boundary, the motion there is simulated.
    let ahead = special.direction[special.direction.len() - 1];
    let goes_on =
        |own: &Candidate| own.is_above == (ahead > 0.0) && own.orbit.is_admissible() != Some(false);
    if special.kind.is_boundary() && !found.iter().any(goes_on) {
        let side = if ahead > 0.0 { 1.0 } else { -1.0 };
        found.extend(found_there(simulated_beyond(problem, place, side))?);
    }
    found.sort_by_key(|own| own.orbit.is_admissible() == Some(false));
    Ok(found)
}

/// The candidate that was found; none where the search leads to a value that the scene refuses.
fn found_there(found: Result<Option<Candidate>>) -> Result<Vec<Candidate>> {
    match found {
        Err(Error::BadValue { .. }) => Ok(Vec::new()),
        found => Ok(found?.into_iter().collect()),
    }
}

/// The orbit of twice the period, along the eigenvector of the multiplier -1; for half a period, the orbit that is not its own mirror image.
fn doubled(problem: &BranchProblem<'_>, place: &ParametricLoop) -> Result<Option<Candidate>> {
    let by = &problem.deviation(place, -1.0)?;
    let (twice, at) = problem.repeated(place, by, &[0.0, 0.0])?;
    let moved = |aside: f64| Ok(problem.repeated(place, by, &[aside, -aside])?.1);
    found_aside(&twice, &at, &moved)
}

/// Orbits of the branch that is crossed, on both sides: at right angles to the tangent, in the plane of both tangents.
fn crossed(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    special: &Special,
) -> Result<Vec<Candidate>> {
    let own = BranchDirection::of(&special.direction);
    let is_half = own.loop_part.len() < problem.n_unknowns(place);
    let half = if is_half { problem.half(place)? } else { None };
    let (problem, place) = half
        .as_ref()
        .map_or((problem, place), |half| (&half.0, &half.1));
    let equations = problem.equations(place)?;
    let plane = rank::weakest(&equations.all_columns(), 2)?;
    let weight = own.row();
    let parts = plane.tr_mul(&weight);
    // The direction in the plane that is orthogonal to the tangent.
    let across = BranchDirection::of(&(&plane * dvector![-parts[1], parts[0]]));
    let across = across.unit();
    let mut found = Vec::new();
    for side in [1.0, -1.0] {
        let moved = |aside: f64| problem.moved(place, &equations, &across.scaled(side * aside));
        found.extend(found_there(found_aside(problem, place, &moved))?);
    }
    Ok(found)
}

/// The orbit of another branch at some arclength from an orbit in a direction, at half of that and less if there is none.
fn found_aside(
    problem: &BranchProblem<'_>,
    at: &ParametricLoop,
    moved: &dyn Fn(f64) -> Result<ParametricLoop>,
) -> Result<Option<Candidate>> {
    let mut aside = ASIDE_LENGTH;
    for _ in 0..MOST_ASIDE_HALVINGS {
        let to = moved(aside)?;
        let chord = problem.between(at, &to);
        let length = chord.length();
        if let Ok(settled) = corrected(problem, to.clone(), &chord.unit())? {
            let off = problem.between(&to, &settled.iterate);
            if off.length() < length {
                let one = problem.one_round(&settled.iterate)?;
                let (problem, place) = one
                    .as_ref()
                    .map_or((problem, &settled.iterate), |(problem, place)| {
                        (problem, place)
                    });
                return Candidate::at(problem, place, at.value).map(Some);
            }
        }
        aside *= 0.5;
    }
    Ok(None)
}

/// The orbits with one impact more, on a stop that is touched, in one to six rounds of a loop; without that of the given numbers of periods
/// and instants, which is the branch itself.
fn born(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    touch: (usize, f64),
    but: Option<(usize, usize)>,
) -> Result<Vec<Candidate>> {
    let mut found = Vec::new();
    let mut with_impact = |touched: &TouchingLoop<'_>| -> Result<()> {
        let Signature {
            stages, n_periods, ..
        } = &touched.problem.signature;
        let halves = if touched.problem.signature.images.is_some() {
            2
        } else {
            1
        };
        // A stop that the impact throws the motion off is landed on at one instant more.
        let count = stages.len() + touched.thrown.len();
        if but != Some((*n_periods, halves * count)) {
            found.extend(found_there(with_speed(touched))?);
        }
        Ok(())
    };
    // A motion that is its own mirror image touches two stops, or one twice: it may hit both beyond the graze.
    if let Some((half, at)) = problem.half(place)? {
        with_impact(&half.with_touch(&at, half.in_half(&at, touch))?)?;
    }
    for rounds in 1..=MOST_BORN_ROUNDS {
        let (several, at) = problem.repeated(place, &place.state, &vec![0.0; rounds])?;
        with_impact(&several.with_touch(&at, touch)?)?;
    }
    Ok(found)
}

/// The orbits with a contact in one of some rounds of a loop that touches a stop which gives way, from a number of rounds to six.
fn contacts_born(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    touch: (usize, f64),
    first: usize,
) -> Result<Vec<Candidate>> {
    let mut found = Vec::new();
    for rounds in first..=MOST_BORN_ROUNDS {
        let (several, at) = problem.repeated(place, &place.state, &vec![0.0; rounds])?;
        let Some(own) = with_brief_contact(&several, (&at, touch), None)? else {
            continue;
        };
        found.push(Candidate {
            parameter: own.point.place.value,
            is_above: own.point.place.value > place.value,
            orbit: own.point.orbit,
        });
    }
    Ok(found)
}

/// The orbit with an impact more in one round of a loop, on a stop that is touched.
pub(super) fn born_at(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    touch: (usize, f64),
) -> Result<Vec<Candidate>> {
    found_there(with_speed(&problem.with_touch(place, touch)?))
}

/// The orbit near a loop on which the new impact has some speed. If that throws the motion off a held stop, the orbit lands on it again.
fn with_speed(touched: &TouchingLoop<'_>) -> Result<Option<Candidate>> {
    let TouchingLoop {
        problem,
        place,
        instant,
        thrown,
    } = touched;
    let Some(there) = sped_up(problem, place, *instant)? else {
        return Ok(None);
    };
    match thrown[..] {
        [] => Candidate::at(problem, &there, place.value).map(Some),
        [stop] if problem.signature.images.is_none() => {
            let Some((other, at)) = problem.left_at(&there, *instant, stop)? else {
                return Ok(None);
            };
            let by_value = BranchDirection::of_value(other.n_unknowns(&at));
            match corrected(&other, at, &by_value)? {
                Ok(settled) => Candidate::at(&other, &settled.iterate, place.value).map(Some),
                Err(_) => Ok(None),
            }
        }
        _ => Ok(None),
    }
}

/// The loop along its branch at which the new impact has some speed.
fn sped_up(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    instant: usize,
) -> Result<Option<ParametricLoop>> {
    let equations = problem.equations(place)?;
    let all = directions(&equations)?;
    let [tangent] = all.as_slice() else {
        return Ok(None);
    };
    let tried = problem.moved(place, &equations, &tangent.scaled(BORN_IMPACT_STEP))?;
    let growth = problem.approach(&tried, instant)? - problem.approach(place, instant)?;
    let mut length = (BORN_IMPACT_SPEED * problem.units.velocity / growth * BORN_IMPACT_STEP)
        .clamp(-ASIDE_LENGTH, ASIDE_LENGTH);
    for _ in 0..MOST_ASIDE_HALVINGS {
        let from = (place, &equations, tangent);
        if let Ok(settled) = step_to(problem, from, StepTarget::Length(length))?
            && problem.approach(&settled.iterate, instant)? > 0.0
        {
            return Ok(Some(settled.iterate));
        }
        length *= 0.5;
    }
    Ok(None)
}

/// The orbit without an impact that has lost its speed, and the others that begin with the graze there.
fn lost(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    (stop, time): (usize, f64),
) -> Result<Vec<Candidate>> {
    let Signature {
        stages, n_periods, ..
    } = &problem.signature;
    let own = (*n_periods, stages.len());
    // A motion that is its own mirror image loses two impacts at once.
    let half = problem.half(place)?;
    let (problem, place, (stop, time)) = match &half {
        Some((half, at)) => (half, at, half.in_half(at, (stop, time))),
        None => (problem, place, (stop, time)),
    };
    let Some(instant) = problem.instant_of(place, (stop, time)) else {
        return Ok(Vec::new());
    };
    let touch = (stop, place.state.times[instant]);
    let Some((rest, at)) = problem.without(place, instant)? else {
        return Ok(Vec::new());
    };
    let by_value = BranchDirection::of_value(rest.n_unknowns(&at));
    let Ok(settled) = corrected(&rest, at, &by_value)? else {
        return Ok(Vec::new());
    };
    let (rest, at) = if rest.signature.images.is_some() {
        rest.whole(&settled.iterate)?
    } else {
        (rest, settled.iterate)
    };
    let (rest, at) = rest.one_round(&at)?.unwrap_or((rest, at));
    let mut found: Vec<Candidate> = beside(&rest, &at, 1.0)?.into_iter().collect();
    found.extend(born(&rest, &at, touch, Some(own))?);
    Ok(found)
}

/// The orbit next to a boundary on the side on which it keeps the rules of contact, if on one; `first` is the sign of the side that is
/// tried first.
fn beside(
    problem: &BranchProblem<'_>,
    place: &ParametricLoop,
    first: f64,
) -> Result<Option<Candidate>> {
    let by_value = BranchDirection::of_value(problem.n_unknowns(place));
    let Ok(settled) = corrected(problem, place.clone(), &by_value)? else {
        return Ok(None);
    };
    let mut found = None;
    // Beyond a further boundary it breaks a rule that it keeps nearer to this one.
    let near = (0..MOST_NEARER_ORBITS)
        .flat_map(|k| [first, -first].map(|side| side * NEARER_BOUNDARY_FACTOR.powi(k)));
    for side in near {
        let value = place.value + side * BEYOND_BOUNDARY_DISTANCE * problem.span();
        let Ok(there) = step_to(problem, settled.base(), StepTarget::Value(value))? else {
            continue;
        };
        let own = Candidate::at(problem, &there.iterate, place.value)?;
        if own.orbit.is_admissible() != Some(false) {
            return Ok(Some(own));
        }
        found.get_or_insert(own);
    }
    Ok(found)
}

/// The orbit beyond a corner that hits its two stops in the other order; where the impacts do not commute there mostly is none.
fn swapped(problem: &BranchProblem<'_>, place: &ParametricLoop) -> Result<Option<Candidate>> {
    let Some(first) = place.shortest_flight() else {
        return Ok(None);
    };
    let count = place.state.states.len();
    let length = |place: &ParametricLoop| place.state.times[first + 1] - place.state.times[first];
    let equations = problem.equations(place)?;
    let all = directions(&equations)?;
    let [tangent] = all.as_slice() else {
        return Ok(None);
    };
    // Past the corner, where the first of the two impacts would come after the second.
    let later = problem.moved(place, &equations, &tangent.scaled(BORN_IMPACT_STEP))?;
    let grows = length(&later) > length(place);
    let ahead = if grows {
        -PAST_CORNER_LENGTH
    } else {
        PAST_CORNER_LENGTH
    };
    let past = problem.moved(place, &equations, &tangent.scaled(ahead))?;
    let whole = period(&past.state);
    let mut instants = turned(problem.instants(&past.state), first, whole);
    // The order of two impacts matters to stops that are held: there the motion is simulated instead.
    if instants
        .iter()
        .take(2)
        .any(|own| !own.stage.regime.is_free())
        || instants
            .last()
            .is_some_and(|own| !own.stage.regime.is_free())
    {
        return Ok(None);
    }
    instants.swap(0, 1);
    let flown = instants.last().cloned().filter(|_| count > 2);
    let before = flown.unwrap_or_else(|| instants[0].clone()).later(-whole);
    let scene = problem.scene(past.value)?;
    with_maps(&scene, &problem.signature, |motion| {
        let mut from = before;
        for (own, k) in instants[..2].iter_mut().zip([first + 1, first]) {
            if problem.signature.stages.impact(k).is_none() {
                return Ok(());
            }
            let span = (from.start, own.time);
            let before = carried(motion, &from.stage.regime, span, &from.state)?;
            own.state = reset(motion, &own.stage.transition, own.time, before)?;
            (own.start, from) = (own.time, own.clone());
        }
        Ok(())
    })?;
    let n_periods = problem.signature.n_periods;
    let (other, at) = problem.with_instants(past.value, instants, (whole, n_periods))?;
    let by_value = BranchDirection::of_value(other.n_unknowns(&at));
    let Ok(settled) = corrected(&other, at.clone(), &by_value)? else {
        return Ok(None);
    };
    let off = other.between(&at, &settled.iterate);
    if off.length() > ASIDE_LENGTH {
        return Ok(None);
    }
    Candidate::at(&other, &settled.iterate, place.value).map(Some)
}
