//! The state in which a run ends, and from which another goes on.

use crate::error::{Error, Result};
use crate::flow::characteristic_length::Tolerances;
use crate::hybrid::ElementStates;
use crate::law::{ElementState, Regime};
use crate::model::{PhysicalState, Scene};
use crate::quantity::{finite, finite_vector};
use crate::simulate::kept::KeptChapter;
use crate::simulate::saved::SavedLeft;
use nalgebra::DVector;

/// All that a run goes on from.
///
/// Position and velocity do not say all: a stop that relaxes has a place of its own, and which of two states an element is in may be known
/// from what came before alone. `simulate_from` goes on from it.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionState {
    pub(crate) scene: Scene,
    pub(crate) time: f64,
    /// Position, shape `(n_dof,)`, \[units of q\].
    pub(crate) q: DVector<f64>,
    /// Velocity, shape `(n_dof,)`, \[units of v\].
    pub(crate) v: DVector<f64>,
    pub(crate) left: Left,
}

/// What a run leaves behind for the next one.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Left {
    pub elements: ElementStates,
    /// The motion where its last flight began, as plain numbers, shape `(n_numbers,)`, \[mixed\], with the tolerances by which it was made; none of a run in steps, and of one
    /// that ended where it could not go on.
    pub flight: Option<(Tolerances, Vec<f64>)>,
}

/// Where a run begins or has ended: position and velocity, and the states of elements that give way.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct RunEnd {
    pub state: PhysicalState,
    pub elements: ElementStates,
}

impl Left {
    /// What was saved, or, of a run that was saved without it, the regime in which its last chapter ends, where its motion is kept.
    ///
    /// # Errors
    /// As [`restore`](Self::restore).
    pub fn of_saved(
        scene: &Scene,
        saved: Option<SavedLeft>,
        chapter: Option<&KeptChapter>,
    ) -> Result<Self> {
        if let Some(saved) = saved {
            return Self::restore(scene, saved);
        }
        let path = chapter.and_then(|own| own.path.as_ref());
        let last = path.and_then(|path| path.parts.segments.last());
        let regime = last.map_or_else(Regime::default, |own| own.regime.clone());
        let places = Vec::new();
        Ok(Self {
            elements: ElementStates { regime, places },
            flight: None,
        })
    }

    /// As plain numbers.
    pub fn save(&self) -> SavedLeft {
        let flight = self.flight.as_ref();
        let numbers =
            |(own, numbers): &(Tolerances, Vec<f64>)| (own.relative, own.absolute, numbers.clone());
        let ElementStates { regime, places } = &self.elements;
        (regime.written(), places.clone(), flight.map(numbers))
    }

    /// What was saved of a scene's.
    ///
    /// # Errors
    /// Elements that the scene does not have, states that are none of their laws.
    pub fn restore(scene: &Scene, (regime, places, flight): SavedLeft) -> Result<Self> {
        let stops = scene.stops();
        let refused = |found: String| {
            let rule = "they must be those of the elements of the scene";
            Error::bad_value("the states of elements that were saved", found, rule)
        };
        let read = Regime::read(&regime).filter(|own| {
            let mut all = own.elements();
            let is_its = |i: usize| {
                stops
                    .get(i)
                    .is_some_and(|stop| stop.contact().has_state(own.state(i)))
            };
            all.all(is_its)
        });
        let own = read.ok_or_else(|| refused(format!("{regime:?}")))?;
        let relaxes = |&(i, place): &(usize, f64)| {
            own.state(i) == ElementState::Relaxing && place >= 0.0 && place.is_finite()
        };
        if !places.iter().all(relaxes) {
            return Err(refused(format!("{places:?}")));
        }
        let flight = flight
            .map(|(relative, absolute, numbers)| (Tolerances { relative, absolute }, numbers));
        Ok(Self {
            elements: ElementStates {
                regime: own,
                places,
            },
            flight,
        })
    }
}

impl MotionState {
    /// One that was saved.
    ///
    /// # Errors
    /// Numbers that do not fit the scene, or are not finite.
    pub fn restore(
        scene: &Scene,
        time: f64,
        (q, v): PhysicalState,
        left: SavedLeft,
    ) -> Result<Self> {
        finite_vector("q", &q, scene.n_dof())?;
        finite_vector("v", &v, scene.n_dof())?;
        let left = Left::restore(scene, left)?;
        Ok(Self {
            scene: scene.clone(),
            time: finite("time", time)?,
            q,
            v,
            left,
        })
    }

    /// What it is restored from, beside its scene, time, position and velocity.
    pub fn save(&self) -> SavedLeft {
        self.left.save()
    }

    /// The scene whose state it is.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Time \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Position, shape `(n_dof,)`, \[units of q\].
    pub fn q(&self) -> &DVector<f64> {
        &self.q
    }

    /// Velocity, shape `(n_dof,)`, \[units of v\].
    pub fn v(&self) -> &DVector<f64> {
        &self.v
    }

    /// States of first order, shape `(s,)`: none yet.
    pub fn z(&self) -> &[f64] {
        &[]
    }

    /// The mode: zero, the only one yet.
    pub fn mode(&self) -> usize {
        0
    }

    /// The state of each element, as [`RegimeRow::states`](crate::RegimeRow::states) has them.
    pub fn regime(&self) -> Vec<&'static str> {
        let stops = self.scene.stops().iter().enumerate();
        let state = |i: usize| self.left.elements.regime.state(i);
        stops
            .map(|(i, stop)| state(i).name(stop.contact().is_rigid()))
            .collect()
    }

    /// What each element remembers: of one that relaxes how far inside its place it is \[m\]; NaN of one that remembers nothing.
    pub fn remembered(&self) -> Vec<f64> {
        let mut all = vec![f64::NAN; self.scene.stops().len()];
        for &(element, place) in &self.left.elements.places {
            all[element] = place;
        }
        all
    }

    /// The numbers of the flight that is under way, for a run of a scene by some tolerances; none where that is another motion.
    pub(super) fn flight_of(&self, scene: &Scene, tolerances: Tolerances) -> Option<&[f64]> {
        let (own, numbers) = self.left.flight.as_ref()?;
        (*own == tolerances && *scene == self.scene).then_some(numbers)
    }

    /// Refuses a scene that cannot go on from it.
    ///
    /// # Errors
    /// A scene of another size, with other stops, or with laws of contact that do not have the states of its elements.
    pub(super) fn check(&self, scene: &Scene) -> Result<()> {
        let (n, of) = (scene.n_dof(), self.q.len());
        if n != of {
            let value = format!("of {of} degrees of freedom");
            return Err(Error::bad_value(
                "state",
                value,
                format!("the scene has {n}"),
            ));
        }
        let (count, own) = (scene.stops().len(), self.scene.stops().len());
        if count != own {
            let value = format!("of {own} elements");
            return Err(Error::bad_value(
                "state",
                value,
                format!("the scene has {count}"),
            ));
        }
        for (i, name) in self.regime().into_iter().enumerate() {
            let law = scene.stops()[i].contact();
            if !law.has_state(self.left.elements.regime.state(i)) {
                let rule = format!("the law of stops[{i}], {}, has no such state", law.name());
                return Err(Error::bad_value(
                    "state",
                    format!("\"{name}\" at stop {i}"),
                    rule,
                ));
            }
        }
        Ok(())
    }
}
