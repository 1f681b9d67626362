//! Orbits with one contact in a period (theory 22), or of two stops that are each other's mirror images with one contact in each half of it:
//! from a problem, through the search for the duration, to the solutions and what was proved of all other durations.

use crate::error::{Error, Result};
use crate::flow::ModalScene;
use crate::impact::wrapped;
use crate::law::{ElementState, GuardKind, Outcome, Regime, Stage, Transition};
use crate::modal::ModalState;
use crate::observer::Observer;
use crate::orbit::one_contact::conditions::{Conditions, ContactCycle, ContactEnd};
use crate::orbit::one_contact::search::{DurationSearch, Given};
use crate::orbit::orbit_data::{OrbitArc, OrbitData};
use crate::orbit::problem::Problem;
use crate::orbit::shooting::mirror::images_in;
use crate::orbit::solutions::Solutions;
use crate::orbit::two_instants::polish::Root;
use nalgebra::DVector;

/// Every solution with one contact with a stop that gives way; of two stops those that are their own mirror images.
pub(crate) fn one_contact(
    problem: &Problem<'_>,
    stops: &[usize],
    observer: &mut Observer,
) -> Result<Solutions> {
    let images = match stops {
        [_] => None,
        _ => Some(mirror(problem, stops)?),
    };
    let law = problem.modal.geometry.laws[stops[0]].by_state();
    let mut found = Solutions {
        all: Vec::new(),
        reason: String::new(),
        margin: None,
        family: None,
    };
    for &guard in law.guards(ElementState::Pressed) {
        if let Outcome::Enters(next) = law.outcome(ElementState::Pressed, guard) {
            let images = images.as_deref();
            let search = OneEnd {
                problem,
                stops,
                images,
                guard,
                next,
            };
            search.add_to(&mut found, observer)?;
        }
    }
    Ok(found)
}

/// The mirror image of each stop of a scene that is odd, in which two are each other's.
fn mirror(problem: &Problem<'_>, stops: &[usize]) -> Result<Vec<usize>> {
    let images = images_in(problem.scene, &problem.modal)?;
    let images = images.filter(|images| images[stops[0]] == stops[1]);
    match images {
        Some(images) if !problem.options.n_periods.is_multiple_of(2) => Ok(images),
        _ => {
            let found = format!("{:?}", problem.pattern.instants());
            let rule = "of two stops that give way the orbits that are their own mirror images are found: they have to be each other's images, in \
                        a scene that is odd, over an odd number of periods; use find_orbit with a guess";
            Err(Error::bad_value("pattern", found, rule))
        }
    }
}

/// The orbits whose contacts end by one guard.
struct OneEnd<'a> {
    problem: &'a Problem<'a>,
    stops: &'a [usize],
    images: Option<&'a [usize]>,
    guard: GuardKind,
    /// The state of the stop behind.
    next: ElementState,
}

impl OneEnd<'_> {
    /// Searches for them.
    fn add_to(&self, found: &mut Solutions, observer: &mut Observer) -> Result<()> {
        let modal = &self.problem.modal;
        let modes: Vec<usize> = (0..modal.form.n_dof()).collect();
        let given = self
            .problem
            .options
            .phase
            .map(|phase| [phase.cos(), phase.sin()]);
        // Between two clearances the conditions are linear.
        let scenes: Vec<[ModalScene; 2]> = match given {
            None => vec![self.scenes(modal)?],
            Some(_) => [0.0, 1.0]
                .iter()
                .map(|c| self.at_clearance(*c))
                .collect::<Result<_>>()?,
        };
        let cycles: Vec<ContactCycle<'_>> = scenes.iter().map(|own| self.cycle(own)).collect();
        let conditions = cycles.iter().map(|cycle| Conditions::new(cycle, &modes));
        let conditions: Vec<Conditions<'_>> = conditions.collect();
        let search = DurationSearch {
            cycle: &cycles[0],
            given: match (given, &conditions[..]) {
                (Some(phase), [near, far]) => Given::Phase(phase, [near, far]),
                _ => Given::Clearance(&conditions[0]),
            },
            time_unit: 1.0 / modal.frequency,
        };
        let (roots, certificate) = search.run(observer)?;
        let mut early = 0;
        for root in &roots {
            let orbit = match (search.clearance(root), given) {
                (Some(clearance), Some(phase)) => {
                    let scenes = self.at_clearance(clearance)?;
                    let cycle = self.cycle(&scenes);
                    let conditions = Conditions::new(&cycle, &modes);
                    let root = conditions.at_phase(root, phase);
                    let clearances = self.stops.iter().map(|&stop| (stop, clearance));
                    let orbit = self.orbit(&conditions, &root, observer)?;
                    orbit.map(|orbit| OrbitData {
                        clearances: clearances.collect(),
                        ..orbit
                    })
                }
                _ => self.orbit(&conditions[0], root, observer)?,
            };
            early += usize::from(orbit.is_none());
            found.all.extend(orbit);
        }
        if !found.reason.is_empty() {
            found
                .reason
                .push_str("; of contacts that end with their force: ");
        }
        found.reason.push_str(&certificate.describe());
        if early > 0 {
            let more =
                "meet the stop before it is back at its place under its preload, and are left out";
            found.reason.push_str(&format!("; {early} {more}"));
        }
        Ok(())
    }

    /// The scene while the stop is pressed, and free of it.
    fn scenes(&self, free: &ModalScene) -> Result<[ModalScene; 2]> {
        let regime = Regime::default().with(self.stops[0], ElementState::Pressed);
        Ok([free.with_pressed(&regime)?, free.clone()])
    }

    /// The same at another clearance.
    fn at_clearance(&self, clearance: f64) -> Result<[ModalScene; 2]> {
        let all = self.stops.iter().map(|&stop| (stop, clearance));
        self.scenes(&self.problem.modal.with_clearances(&all.collect::<Vec<_>>()))
    }

    fn cycle<'s>(&self, [pressed, free]: &'s [ModalScene; 2]) -> ContactCycle<'s> {
        let stop = self.stops[0];
        let law = free.geometry.laws[stop].by_state();
        let relaxation = law.relaxation(self.next).filter(|own| own.beyond == 0.0);
        let is_mirrored = self.images.is_some();
        ContactCycle {
            pressed,
            free,
            stop,
            force: law.force(ElementState::Pressed).expect("it is pressed"),
            end: match self.guard {
                GuardKind::Push => ContactEnd::Force,
                _ => ContactEnd::Gap,
            },
            relaxes: relaxation.map(|own| own.rate),
            span: self.problem.period * if is_mirrored { 0.5 } else { 1.0 },
            is_mirrored,
        }
    }

    /// The orbit of a root: the contact, and the flight behind it. None if the stop is met before it is back under a preload.
    fn orbit(
        &self,
        conditions: &Conditions<'_>,
        root: &Root,
        observer: &mut Observer,
    ) -> Result<Option<OrbitData>> {
        let (problem, stop, next) = (self.problem, self.stops[0], self.next);
        let law = problem.modal.geometry.laws[stop].by_state();
        let ([begun, ended, last], [cos, sin]) = conditions.states(root.dt, &root.x);
        let relaxation = law.relaxation(next);
        let is_early = relaxation.is_some_and(|own| {
            let place = conditions.approach(root.dt, &root.x);
            own.duration(place) > problem.period - root.dt
        });
        if is_early && relaxation.is_some_and(|own| own.beyond > 0.0) {
            return Ok(None);
        }
        let pairs = |state: &DVector<f64>| -> ModalState {
            let pairs = state.as_slice().chunks_exact(2);
            pairs.map(|pair| [pair[0], pair[1]]).collect()
        };
        let stage = |states: [ElementState; 2]| Stage {
            transition: Transition::change(law, stop, states).expect("a change of its law"),
            regime: match self.stops.get(1).filter(|_| relaxation.is_some()) {
                // The image of it relaxes meanwhile, or is back.
                Some(&image) => Regime::default().with(image, next).with(stop, states[1]),
                None => Regime::default().with(stop, states[1]),
            },
        };
        let (free, pressed) = (ElementState::Free, ElementState::Pressed);
        let before = if is_early { next } else { free };
        let opening = match next {
            ElementState::Idle => conditions.opening((root.dt, &root.x), observer)?,
            _ => None,
        };
        let mut instants = vec![
            (stage([before, pressed]), 0.0, pairs(&begun)),
            (stage([pressed, next]), root.dt, pairs(&ended)),
        ];
        if let Some((time, state)) = opening {
            instants.push((stage([next, free]), time, pairs(&state)));
        }
        let ends = instants
            .iter()
            .skip(1)
            .map(|(_, time, state)| (*time, state.clone()));
        let ends: Vec<_> = ends.chain([(conditions.span(), pairs(&last))]).collect();
        let arcs = instants.into_iter().zip(ends);
        let arcs = arcs.map(|((stage, start, after), (end, before))| {
            OrbitArc::over(stage, [start, end - start], [after, before])
        });
        let mut flights: Vec<OrbitArc> = arcs.collect();
        if let Some(images) = self.images {
            let image = |own: &OrbitArc| {
                let mut image = own
                    .clone()
                    .map(|state| state.iter().map(|z| z.map(|x| -x)).collect());
                image.stage = own.stage.mirrored(images);
                image.start += conditions.span();
                image.end += conditions.span();
                image
            };
            flights.extend(flights.iter().map(image).collect::<Vec<_>>());
        }
        Ok(Some(OrbitData {
            pattern: problem.pattern.clone(),
            n_periods: problem.options.n_periods,
            phase: wrapped(sin.atan2(cos)),
            flights,
            impulses: Vec::new(),
            clearances: Vec::new(),
        }))
    }
}
