//! The search for the duration of the contact: Cramer's rule makes `|u| = 1` of the phase one analytic equation in it without poles, of which
//! every zero in the period is isolated by bounds; each is then polished with all unknowns at once.

use crate::error::Result;
use crate::observer::Observer;
use crate::orbit::one_contact::conditions::{Conditions, ContactCycle, ContactEnd};
use crate::orbit::one_contact::kernel::{determinant, kernel};
use crate::orbit::two_instants::certificate::Certificate;
use crate::orbit::two_instants::conditions::point;
use crate::orbit::two_instants::green::TimeInterval;
use crate::orbit::two_instants::isolate::{IntervalEnd, IntervalModel, SearchInterval, isolate};
use crate::orbit::two_instants::polish::{Root, TwoInstantEquations};
use crate::orbit::two_instants::root_search::{TimedConditions, keep, near, within};
use crate::orbit::two_instants::taylor_model::TaylorModel;
use crate::tolerance::{FLIGHT_TIME_ROUNDING, NEAR_FLIGHT_TIME, SAME_FLIGHT_TIME};

/// What is given beside the cycle: the clearance, and the phase is unknown; or the phase, with the conditions at clearances of zero and of one,
/// between which they are linear.
pub(super) enum Given<'a> {
    Clearance(&'a Conditions<'a>),
    Phase([f64; 2], [&'a Conditions<'a>; 2]),
}

/// The search for one cycle.
pub(super) struct DurationSearch<'a> {
    pub cycle: &'a ContactCycle<'a>,
    pub given: Given<'a>,
    /// The time in which the forcing turns by one.
    pub time_unit: f64,
}

impl DurationSearch<'_> {
    /// The analytic function whose zeros are the durations: `|numerators|^2 - denominator^2` of `|u| = 1`.
    fn sample(&self, place: &SearchInterval) -> IntervalModel {
        let n = self.n_unknowns();
        let models = self.models(&place.time_interval(), place.end);
        let square = |models: &[TaylorModel], n_columns: usize| {
            let series = determinant(models, n_columns);
            series.map_or_else(IntervalModel::unknown, |series| IntervalModel {
                series,
                floor: FLIGHT_TIME_ROUNDING * series.size(),
            })
        };
        let Some(unit) = self.circle() else {
            return square(&models, n + 1);
        };
        if self.is_homogeneous() {
            let rows = models.chunks_exact(n + 1);
            let left: Vec<_> = rows.flat_map(|row| &row[..n]).copied().collect();
            return square(&left, n);
        }
        let Some(kernel) = kernel(&models, n + 1) else {
            return IntervalModel::unknown();
        };
        let parts = [
            (unit, &kernel[n - 2]),
            (unit, &kernel[n - 1]),
            (1.0, &kernel[n]),
        ];
        let parts = parts.map(|(factor, own)| TaylorModel::sum([(factor, own)].into_iter()));
        let [cos, sin, one] = &parts;
        let error = |own: &TaylorModel| {
            let rounding = FLIGHT_TIME_ROUNDING * own.size();
            (2.0 * own.bound() + rounding) * rounding
        };
        IntervalModel {
            series: TaylorModel::sum_of_products(
                [(1.0, cos, cos), (1.0, sin, sin), (-1.0, one, one)].into_iter(),
            ),
            floor: parts.iter().map(error).sum(),
        }
    }

    /// Whether the conditions have no right-hand side: with each motion the opposite one is a solution, and of any size.
    fn is_homogeneous(&self) -> bool {
        matches!(self.given, Given::Clearance(conditions) if conditions.is_homogeneous())
    }

    /// Number of unknowns but the duration.
    fn n_unknowns(&self) -> usize {
        match self.given {
            Given::Clearance(conditions) => conditions.n_states() + 2,
            Given::Phase(_, [conditions, _]) => conditions.n_states() + 1,
        }
    }

    /// The scaled conditions over a cell, by rows: for the state and what is not given, right-hand side last.
    fn models(&self, cell: &TimeInterval, end: IntervalEnd) -> Vec<TaylorModel> {
        let (phase, [near, far]) = match &self.given {
            Given::Clearance(conditions) => return conditions.models(cell, end),
            Given::Phase(phase, conditions) => (phase, conditions),
        };
        let (m, unit) = (near.n_states(), near.phase_unit());
        let models = [near, far].map(|own| own.models(cell, end));
        let [near, far] = models.each_ref().map(|own| own.chunks_exact(m + 3));
        let row = |(near, far): (&[TaylorModel], &[TaylorModel])| {
            let beyond = [
                (self.time_unit, &near[m + 2]),
                (-self.time_unit, &far[m + 2]),
            ];
            let [cos, sin] = phase.map(|part| -part / unit);
            let known = [(1.0, &near[m + 2]), (cos, &near[m]), (sin, &near[m + 1])];
            let last = [
                TaylorModel::sum(beyond.into_iter()),
                TaylorModel::sum(known.into_iter()),
            ];
            near[..m].iter().copied().chain(last).collect::<Vec<_>>()
        };
        near.zip(far).flat_map(row).collect()
    }

    /// The clearance of a root, where the phase is given.
    pub fn clearance(&self, root: &Root) -> Option<f64> {
        match self.given {
            Given::Clearance(_) => None,
            Given::Phase(..) => Some(root.x[self.n_unknowns() - 1] * self.time_unit),
        }
    }

    /// The ends of the range at which conditions meet: where the contact, or the flight behind it, lasts for no time.
    fn deflated(&self) -> (bool, bool) {
        let at_gap = self.cycle.end == ContactEnd::Gap;
        let meets_again = at_gap || self.cycle.relaxes.is_some();
        (at_gap, meets_again && !self.cycle.is_mirrored)
    }

    /// All roots, and in words what is proved of the rest.
    ///
    /// # Errors
    /// `Error::Interrupted` from the observer; `Error::NoConvergence` of a decomposition.
    pub fn run(&self, observer: &mut Observer) -> Result<(Vec<Root>, Certificate)> {
        let span = self.cycle.span;
        let found = isolate((0.0, span), self.deflated(), observer, |place| {
            self.sample(place)
        })?;
        let mut roots: Vec<Root> = Vec::new();
        let mut lost = 0;
        for bracket in &found.simple {
            let is_inside = |root: &Root| (bracket.low..=bracket.high).contains(&root.dt);
            match within(self, bracket, is_inside, observer)? {
                Some(root) => keep(&mut roots, root, span),
                None => lost += 1,
            }
        }
        let open = found.undecided;
        for stretch in &open {
            let slack = 8.0 * (stretch.high - stretch.low) + NEAR_FLIGHT_TIME * span;
            let range = stretch.low - slack..=stretch.high + slack;
            for root in near(self, stretch.guess, observer)? {
                if range.contains(&root.dt) {
                    keep(&mut roots, root, span);
                }
            }
        }
        if self.is_homogeneous() {
            for Root { dt, x } in roots.clone() {
                keep(&mut roots, Root { dt, x: -x }, span);
            }
        }
        // Nearer to an end than this nothing is searched: a contact, or the flight behind it, of no time.
        roots.retain(|root| root.dt.min(span - root.dt) >= SAME_FLIGHT_TIME * span);
        let certificate = Certificate {
            time: "duration",
            solutions: roots.len(),
            apart: 0,
            repeats: false,
            open,
            lost,
            cells: found.cells,
            length: span,
            is_half: self.cycle.is_mirrored,
        };
        Ok((roots, certificate))
    }
}

impl TimedConditions for DurationSearch<'_> {
    fn sampler(&self) -> impl FnMut(&SearchInterval) -> IntervalModel + '_ {
        |place| self.sample(place)
    }

    fn equations(&self, tau: f64) -> TwoInstantEquations {
        let models = self.models(&point(tau, self.time_unit), IntervalEnd::Neither);
        TwoInstantEquations::of_models(&models, self.n_unknowns() + 1)
    }

    fn circle(&self) -> Option<f64> {
        match self.given {
            Given::Clearance(conditions) => Some(conditions.phase_unit()),
            Given::Phase(..) => None,
        }
    }

    fn time_unit(&self) -> f64 {
        self.time_unit
    }

    fn period(&self) -> f64 {
        self.cycle.span
    }
}
