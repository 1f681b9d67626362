//! The list of all orbits of a pattern with the verdict on the periodic problem.

use crate::error::{Result, digits};
use crate::flow::ModalScene;
use crate::model::{Change, Scene, StopNumber};
use crate::observer::Observer;
use crate::orbit::orbit_data::OrbitData;
use crate::orbit::periodic_orbit::PeriodicOrbit;
use crate::orbit::problem::Problem;
use crate::orbit::solutions::Solutions;
use crate::orbit::verdict::admissibility::Ruling;
use crate::tolerance::MOST_DOF_SORTED_BY_STABILITY;
use nalgebra::DMatrix;
use std::sync::Arc;

/// The verdict on a periodic problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// There are isolated orbits.
    Found,
    /// There is none.
    None,
    /// There is a family of orbits with one parameter or more.
    Family,
}

/// The directions of a family of orbits.
#[derive(Debug, Clone)]
pub struct Family {
    /// Directions of the contact state (q, v) in which the orbit may be changed, shape `(2n, dimension)`, [m, m/s].
    pub basis: DMatrix<f64>,
}

/// Every orbit of a pattern: stable and admissible ones first, then admissible ones, then undecided ones, then by depth of
/// violation. In systems of more than 60 degrees of freedom stability has no say in the order: the multipliers, which cost
/// O(n^3), are computed only when asked for.
#[derive(Debug, Clone)]
pub struct Orbits {
    pub(crate) all: Vec<PeriodicOrbit>,
    pub(crate) verdict: Verdict,
    pub(crate) reason: String,
    pub(crate) margin: Option<f64>,
    pub(crate) family: Option<Family>,
}

impl Orbits {
    /// The orbits of a problem from its solutions: those that close, in their order.
    pub(super) fn new(
        problem: &Problem<'_>,
        solutions: Solutions,
        observer: &mut Observer,
    ) -> Result<Self> {
        let Solutions {
            all,
            mut reason,
            margin,
            family,
        } = solutions;
        let orbits = all.into_iter().map(|parts| orbit(problem, parts));
        let mut orbits = orbits.collect::<Result<Vec<_>>>()?;
        keep_closed(&mut orbits, &mut reason)?;
        let (verdict, family) = match (orbits.is_empty(), family) {
            (true, _) => (Verdict::None, None),
            (false, None) => (Verdict::Found, None),
            (false, Some(basis)) => (Verdict::Family, Some(Family { basis })),
        };
        Ok(Self {
            all: sorted(orbits, observer)?,
            verdict,
            reason,
            margin,
            family,
        })
    }

    /// The list without an orbit.
    pub(super) fn none(reason: &str) -> Self {
        Self {
            all: Vec::new(),
            verdict: Verdict::None,
            reason: reason.to_owned(),
            margin: None,
            family: None,
        }
    }

    /// Whether orbits were found, or a family, or none.
    pub fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// Why, in words.
    pub fn reason(&self) -> &str {
        &self.reason
    }

    /// `1 - |d|/|alpha|`: how far the parameters are from the fold at which the orbits meet and vanish; negative: none.
    pub fn margin(&self) -> Option<f64> {
        self.margin
    }

    /// The family, where the verdict is one.
    pub fn family(&self) -> Option<&Family> {
        self.family.as_ref()
    }
}

impl IntoIterator for Orbits {
    type Item = PeriodicOrbit;
    type IntoIter = std::vec::IntoIter<PeriodicOrbit>;

    fn into_iter(self) -> Self::IntoIter {
        self.all.into_iter()
    }
}

impl std::ops::Deref for Orbits {
    type Target = [PeriodicOrbit];

    fn deref(&self) -> &[PeriodicOrbit] {
        &self.all
    }
}

/// The orbit of a problem from its parts, in the scene that has its clearances.
fn orbit(problem: &Problem<'_>, parts: OrbitData) -> Result<PeriodicOrbit> {
    if parts.clearances.is_empty() {
        return PeriodicOrbit::new(problem.scene, problem.modal.clone(), parts);
    }
    let (scene, modal) = at_clearances(problem.scene, &problem.modal, &parts.clearances)?;
    PeriodicOrbit::new(&scene, modal, parts)
}

/// The scene with other clearances of some stops.
fn at_clearances(
    scene: &Scene,
    modal: &Arc<ModalScene>,
    changed: &[(usize, f64)],
) -> Result<(Scene, Arc<ModalScene>)> {
    let modal = Arc::new(modal.with_clearances(changed));
    let clearances = modal.geometry.clearances.as_slice().to_vec();
    Ok((
        scene.replace(Change::EachStop(StopNumber::Clearance, clearances))?,
        modal,
    ))
}

/// Takes the orbits out that do not close, and says so: there rounding has left no digits of them.
fn keep_closed(orbits: &mut Vec<PeriodicOrbit>, reason: &mut String) -> Result<()> {
    let misfits: Vec<Option<f64>> = orbits
        .iter()
        .map(PeriodicOrbit::lost)
        .collect::<Result<_>>()?;
    let mut of_each = misfits.iter();
    orbits.retain(|_| of_each.next().is_some_and(Option::is_none));
    let lost: Vec<f64> = misfits.into_iter().flatten().collect();
    if let Some(worst) = lost.iter().copied().reduce(f64::max) {
        reason.push_str(&format!(
            "; {} of these cannot be told from rounding: gone through once, the motion misses its beginning by {} of its size",
            lost.len(),
            digits(worst)
        ));
    }
    Ok(())
}

/// The order of orbits: stable and admissible first, then admissible, then undecided, then by depth of violation. Asks for
/// stability only where it decides.
pub(crate) fn ranking(
    n_dof: usize,
    rulings: &[Ruling],
    mut is_stable: impl FnMut(usize) -> Result<bool>,
) -> Result<Vec<usize>> {
    let is_admissible = |ruling: &&Ruling| **ruling == Ruling::Admissible;
    let asks =
        n_dof <= MOST_DOF_SORTED_BY_STABILITY && rulings.iter().filter(is_admissible).count() > 1;
    let mut keys = Vec::with_capacity(rulings.len());
    for (i, ruling) in rulings.iter().enumerate() {
        keys.push(match *ruling {
            Ruling::Admissible if asks && is_stable(i)? => (0, 0.0),
            Ruling::Admissible => (1, 0.0),
            Ruling::Undecided => (2, 0.0),
            Ruling::Broken(depth) => (3, depth),
        });
    }
    let mut order: Vec<usize> = (0..rulings.len()).collect();
    order.sort_by(|&i, &j| {
        keys[i]
            .0
            .cmp(&keys[j].0)
            .then(keys[i].1.total_cmp(&keys[j].1))
    });
    Ok(order)
}

/// The orbits in the order of [`ranking`]. A single one is not judged before somebody asks.
pub(super) fn sorted(
    mut orbits: Vec<PeriodicOrbit>,
    observer: &mut Observer,
) -> Result<Vec<PeriodicOrbit>> {
    if orbits.len() < 2 {
        return Ok(orbits);
    }
    let rulings = orbits
        .iter()
        .map(|o| Ok(o.judged(observer)?.ruling()))
        .collect::<Result<Vec<_>>>()?;
    let order = ranking(orbits[0].scene().n_dof(), &rulings, |i| {
        Ok(orbits[i].decided(observer)?.is_stable == Some(true))
    })?;
    let mut slots: Vec<Option<PeriodicOrbit>> = orbits.drain(..).map(Some).collect();
    Ok(order.into_iter().filter_map(|i| slots[i].take()).collect())
}
