//! The orders of the roots that guards have where a flight begins.

use crate::hybrid::pen::Pen;
use crate::law::{Guard, GuardKind};
use std::ops::{Index, IndexMut};

/// The order of the root of each guard where a flight begins, zero for one that is not zero there.
#[derive(Debug, Clone, Default)]
pub(crate) struct RootOrders {
    /// By elements: of the gap, or the approach, or of one that is held that of its contact force, as far as known.
    by_element: Vec<usize>,
    /// Those of other guards, as far as they are not zero.
    others: Vec<(Guard, usize)>,
}

impl RootOrders {
    /// None at zero, of a scene of so many elements.
    pub fn none(n_elements: usize) -> Self {
        Self {
            by_element: vec![0; n_elements],
            others: Vec::new(),
        }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.by_element.fill(0);
        self.others.clear();
    }

    /// Puts them down, or takes them up.
    pub fn carry(&mut self, pen: &mut Pen) {
        pen.counts(&mut self.by_element);
        let code = |kind: GuardKind| GuardKind::ALL.iter().position(|own| *own == kind);
        let own = self.others.iter();
        let own = own.map(|(guard, order)| [guard.element, code(guard.kind).unwrap_or(0), *order]);
        let mut others: Vec<[usize; 3]> = own.collect();
        pen.list(&mut others, |pen, own| {
            for number in own {
                pen.count(number);
            }
        });
        self.others.clear();
        for [element, code, order] in others {
            match GuardKind::ALL.get(code) {
                Some(&kind) => self.others.push((Guard { element, kind }, order)),
                None => pen.lose(),
            }
        }
    }

    /// Whether they are those of a scene of so many elements.
    pub fn are_of(&self, n_elements: usize) -> bool {
        let mut others = self.others.iter();
        self.by_element.len() == n_elements && others.all(|own| own.0.element < n_elements)
    }

    /// By elements, where all are free.
    pub fn gaps(&self) -> &[usize] {
        &self.by_element
    }

    /// That of a guard.
    pub fn of(&self, guard: Guard) -> usize {
        match guard.kind {
            GuardKind::Gap | GuardKind::Approach | GuardKind::Force => {
                self.by_element[guard.element]
            }
            _ => {
                let known = self.others.iter().find(|own| own.0 == guard);
                known.map_or(0, |own| own.1)
            }
        }
    }

    /// Takes that of a guard.
    pub fn note(&mut self, guard: Guard, order: usize) {
        if matches!(guard.kind, GuardKind::Gap | GuardKind::Approach) {
            self.by_element[guard.element] = order;
        } else if order > 0 {
            self.others.push((guard, order));
        }
    }
}

impl Index<usize> for RootOrders {
    type Output = usize;

    fn index(&self, element: usize) -> &usize {
        &self.by_element[element]
    }
}

impl IndexMut<usize> for RootOrders {
    fn index_mut(&mut self, element: usize) -> &mut usize {
        &mut self.by_element[element]
    }
}
