//! A linear scene in modal form with the phase of its forcing put into its amplitude, for runs by the clock; it keeps the motions
//! in other regimes that its runs have needed.

use crate::error::Result;
use crate::flow::characteristic_length::CharacteristicLengths;
use crate::flow::derivative::LinearEquations;
use crate::flow::modal_scene::ModalScene;
use crate::flow::regime_motion::RegimeMotion;
use crate::flow::scene_flow::SceneFlow;
use crate::law::{Newton, Regime};
use crate::model::{Laws, Scene};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Motions in other regimes that are kept with a scene. [work]
const MOST_KEPT_MOTIONS: usize = 32;

/// A linear scene as it runs by the clock, and its flow: the forcing's phase is in its amplitude. A slow force that begins from zero has
/// all its digits there, and few in the sum of phase and angle.
#[derive(Debug)]
pub(crate) struct TimedScene {
    pub modal: Arc<ModalScene>,
    pub flow: Arc<SceneFlow>,
    /// Motions in regimes that are not free, as runs have needed them.
    regimes: Mutex<Vec<Arc<RegimeMotion>>>,
    equations: OnceLock<LinearEquations>,
    lengths: OnceLock<CharacteristicLengths>,
    /// The times at which a signal passes from one polynomial to the next, ascending, shape `(n_breaks,)`, \[s\].
    pub breaks: Vec<f64>,
    laws: Option<Arc<Laws>>,
}

impl TimedScene {
    /// Made of a scene once; `purpose` says in an error what needs it linear.
    pub fn of(scene: &Scene, purpose: &str) -> Result<Arc<Self>> {
        scene.derived().or_made(|| {
            let modal = ModalScene::turned(scene, purpose, scene.phase())?;
            Ok(Self {
                flow: modal.flow(),
                breaks: modal.excitation.breaks(),
                modal: Arc::new(modal),
                regimes: Mutex::default(),
                equations: OnceLock::new(),
                lengths: OnceLock::new(),
                laws: scene.laws().cloned(),
            })
        })
    }

    /// The law of a stop at a time, where it drifts.
    #[inline]
    pub fn drifting_law(&self, stop: usize, t: f64) -> Option<Newton> {
        self.laws.as_ref()?.law(stop, t)
    }

    /// The equations of its motion where nothing is held.
    pub fn equations(&self) -> &LinearEquations {
        self.equations
            .get_or_init(|| LinearEquations::new(&self.modal.system, None))
    }

    /// Its characteristic lengths.
    pub fn lengths(&self) -> &CharacteristicLengths {
        (self.lengths).get_or_init(|| CharacteristicLengths::new(&self.modal))
    }

    /// The motion in a regime, made when it is first needed.
    pub fn in_regime(&self, regime: &Regime) -> Result<Arc<RegimeMotion>> {
        let kept = || self.regimes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kept().iter().find(|motion| motion.regime == *regime) {
            return Ok(Arc::clone(known));
        }
        let made = Arc::new(RegimeMotion::new(&self.modal, regime)?);
        let mut kept = kept();
        if kept.len() < MOST_KEPT_MOTIONS {
            kept.push(Arc::clone(&made));
        }
        Ok(made)
    }
}
