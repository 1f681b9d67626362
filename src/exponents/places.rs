//! What elements that give way do to deviations (theory 22): saltation where one is met or left, and the deviations of the places of those
//! that relax, one row each below those of the motion.

use crate::error::Result;
use crate::exponents::frame::Frame;
use crate::exponents::tangents::Tangents;
use crate::hybrid::{HybridMaps, across, across_meeting, place_left};
use crate::law::{ElementState, Guard, GuardKind, Law, Regime, Relaxation, Transition};
use crate::tolerance::IMPULSE_ROUNDING;
use nalgebra::{DMatrix, DVector, RowDVector};

/// Which rows of deviations are of which places.
#[derive(Debug, Clone)]
pub(crate) struct Places<'a> {
    /// The number of rows above them, those of the motion.
    above: usize,
    /// The element of each.
    elements: Vec<usize>,
    /// The law of each element of the scene.
    laws: Vec<&'a Law>,
}

/// A change of the state of an element that gives way.
#[derive(Debug, Clone, Copy)]
pub(super) struct ElementChange {
    pub element: usize,
    pub to: ElementState,
    /// The guard at whose zero it comes; none of one that comes by an impact, or by a touch.
    guard: Option<Guard>,
}

impl ElementChange {
    /// Whether a force may jump with it.
    pub fn jumps(&self) -> bool {
        self.guard.is_some_and(Guard::is_gap)
    }
}

impl<'a> Places<'a> {
    /// None, below so many rows, in a scene with stops of some laws.
    pub fn below(above: usize, laws: Vec<&'a Law>) -> Self {
        Self {
            above,
            elements: Vec::new(),
            laws,
        }
    }

    /// Takes the rows of places off.
    pub fn taken(&self, columns: &mut DMatrix<f64>) -> DMatrix<f64> {
        let count = self.elements.len();
        let own = columns.rows(self.above, count).into_owned();
        if count > 0 {
            *columns = std::mem::take(columns).remove_rows(self.above, count);
        }
        own
    }

    /// Puts them back.
    pub fn put(&self, columns: &mut DMatrix<f64>, own: &DMatrix<f64>) {
        if own.nrows() > 0 {
            *columns = std::mem::take(columns).resize_vertically(self.above + own.nrows(), 0.0);
            columns.rows_mut(self.above, own.nrows()).copy_from(own);
        }
    }

    /// Does something to deviations of the motion alone.
    pub fn beside<R>(
        &self,
        columns: &mut DMatrix<f64>,
        work: impl FnOnce(&mut DMatrix<f64>) -> Result<R>,
    ) -> Result<R> {
        let places = self.taken(columns);
        let done = work(columns)?;
        self.put(columns, &places);
        Ok(done)
    }

    /// Lets the deviations of places go back for a time.
    pub fn relax(&self, columns: &mut DMatrix<f64>, span: f64) {
        for (row, &element) in self.elements.iter().enumerate() {
            if let Some(relaxation) = self.relaxation(element) {
                let mut own = columns.row_mut(self.above + row);
                own *= relaxation.left(span);
            }
        }
    }

    /// How the place of an element goes back.
    fn relaxation(&self, element: usize) -> Option<Relaxation> {
        let law = self.laws[element].by_state();
        law.relaxation(ElementState::Relaxing)
    }

    /// The changes between two regimes but for those to a seat or from it; where one that relaxes is back nothing happens to a motion.
    pub fn changes(&self, (before, after): (&Regime, &Regime)) -> Vec<ElementChange> {
        if before.others().is_empty() && after.others().is_empty() {
            return Vec::new();
        }
        let change = |element: usize| {
            let (from, to) = (before.state(element), after.state(element));
            if from == to || from.is_back(to) || from.is_held() || to.is_held() {
                return None;
            }
            let law = self.laws[element].by_state();
            let guard = match Transition::change(law, element, [from, to]) {
                Some(Transition::Change(guard, _)) => Some(guard),
                _ => None,
            };
            Some(ElementChange { element, to, guard })
        };
        let compliant = (0..self.laws.len()).filter(|&i| !self.laws[i].is_rigid());
        compliant.filter_map(change).collect()
    }

    /// Takes deviations across a change; whether they have a derivative there, and are not only passed by a touch. `fastest` is the fastest
    /// approach so far.
    pub fn pass<T: Tangents>(
        &self,
        change: ElementChange,
        at: ((&Regime, &Regime), f64),
        (tangents, columns): (&mut T, &mut DMatrix<f64>),
        fastest: &mut f64,
    ) -> Result<bool> {
        let Some(guard) = change.guard else {
            return Ok(false);
        };
        if !guard.is_gap() {
            return Ok(true);
        }
        let element = change.element;
        let row = self.elements.iter().position(|own| *own == element);
        let row = row.filter(|_| guard.kind == GuardKind::Distance);
        let met = row.zip(self.relaxation(element));
        let places = self.taken(columns);
        let slow = IMPULSE_ROUNDING * *fastest;
        let speed = tangents.physically(columns, |maps, state, own| {
            let gap = maps.gap(element, at.1, state)?;
            let n = gap.gradient.len();
            let back = met.map_or(0.0, |(_, relaxation)| relaxation.speed(-gap.gap));
            let speed = (gap.speed(state.rows(n, n)) + back).abs();
            if speed <= slow {
                return Ok(speed);
            }
            if let Some((row, relaxation)) = met {
                let place = places.row(row).into_owned();
                across_meeting(maps, (element, relaxation), at, state, (own, &place))?;
            } else {
                let transition = Transition::Change(guard, change.to);
                across(maps, (&transition, &[]), at, state, own)?;
            }
            Ok(speed)
        })?;
        self.put(columns, &places);
        *fastest = fastest.max(speed);
        Ok(speed > slow)
    }

    /// Gives rows to the places of the elements that relax in a regime, from the state before an instant that has its `delays` on, and takes
    /// those of others away.
    pub fn fit<T: Tangents>(
        &mut self,
        (regime, t): (&Regime, f64),
        (tangents, frame): (&mut T, &mut Frame),
        delays: Option<&RowDVector<f64>>,
    ) -> Result<()> {
        let elements: Vec<usize> = regime.in_state(ElementState::Relaxing).collect();
        if elements == self.elements {
            return Ok(());
        }
        let known = self.taken(&mut frame.columns);
        let before = std::mem::replace(&mut self.elements, elements);
        let mut own = DMatrix::zeros(self.elements.len(), known.ncols());
        for (row, &element) in self.elements.iter().enumerate() {
            let known_row = before.iter().position(|own| *own == element);
            let place = match (known_row, self.relaxation(element)) {
                (None, Some(relaxation)) => {
                    tangents.physically(&mut frame.columns, |maps, state, own| {
                        place_left(maps, (element, relaxation), (t, state), (own, delays))
                    })?
                }
                (known_row, _) => known.row(known_row.unwrap_or(row)).into_owned(),
            };
            own.set_row(row, &place);
        }
        self.put(&mut frame.columns, &own);
        if before.iter().all(|own| self.elements.contains(own)) {
            frame.orthonormalise();
        } else {
            frame.collapse(frame.columns.nrows());
        }
        Ok(())
    }

    /// Does something to a state and to deviations from it as position and velocity.
    pub fn physically<T: Tangents, R>(
        &self,
        (tangents, columns): (&mut T, &mut DMatrix<f64>),
        work: impl FnOnce(&T::Maps, &mut DVector<f64>, &mut DMatrix<f64>) -> Result<R>,
    ) -> Result<R> {
        self.beside(columns, |own| tangents.physically(own, work))
    }
}
