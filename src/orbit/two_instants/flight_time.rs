//! The search for the flight time dt between two instants of impact (theory 5). Cramer's rule makes `|u| = 1` (clearances
//! given) or "the stop is where it was" (phase given) one analytic equation in dt without poles, of which every zero in
//! (0, T) is isolated by bounds; each is then polished with all unknowns at once.

use crate::error::Result;
use crate::modal::Pair;
use crate::observer::Observer;
use crate::orbit::two_instants::certificate::Certificate;
use crate::orbit::two_instants::conditions::{TwoInstantConditions, point};
use crate::orbit::two_instants::green::TimeInterval;
use crate::orbit::two_instants::isolate::{
    Enclosure, IntervalEnd, IntervalModel, Isolated, SearchInterval, isolate,
};
use crate::orbit::two_instants::minors::Minors;
use crate::orbit::two_instants::polish::{Root, TwoInstantEquations};
use crate::orbit::two_instants::root_search::{TimedConditions, keep, near, within};
use crate::orbit::two_instants::taylor_model::TaylorModel;
use crate::tolerance::{
    FLIGHT_TIME_ROUNDING, NEAR_FLIGHT_TIME, SAME_FLIGHT_TIME, TOGETHER, TRIVIAL_FLIGHT,
};

/// A search of flight times: what is asked, and what the trivial solutions are.
pub(crate) struct FlightTimeSearch<'a> {
    pub conditions: &'a TwoInstantConditions<'a>,
    pub period: f64,
    /// The instants are alike, so that an orbit may be a shorter one repeated.
    pub is_alike: bool,
    pub n_periods: usize,
    pub phase: Option<Pair>,
    /// With the phase given: the places in the list of stops of one hit at both instants.
    pub pair: (usize, usize),
}

impl FlightTimeSearch<'_> {
    /// Number of unknowns.
    fn n_unknowns(&self) -> usize {
        self.conditions.n_inner() + if self.phase.is_some() { 0 } else { 2 }
    }

    /// The range of flight times: half of it where `dt` and `T - dt` are one orbit, started at either impact.
    fn range(&self) -> (f64, f64) {
        let is_half = self.is_alike && self.phase.is_none();
        let share = if is_half { 0.5 } else { 1.0 };
        (0.0, share * self.period)
    }

    /// Whether a flight time is half the period, where like or mirrored instants have their line of solutions.
    fn is_half(&self, dt: f64) -> bool {
        (dt - 0.5 * self.period).abs() <= 4.0 * f64::EPSILON * self.period
    }

    /// The scaled equations over a cell, the meeting of the instants, or the line of solutions half the period apart,
    /// divided out where `end` says so.
    fn rows(&self, cell: &TimeInterval, end: IntervalEnd) -> Vec<TaylorModel> {
        if end != IntervalEnd::Neither && self.phase.is_none() && self.is_half(cell.origin) {
            return self.conditions.half_rows(cell);
        }
        let entries = self.conditions.entries(cell);
        match self.phase {
            Some(u) => self
                .conditions
                .phase_rows(&entries, u, self.pair, (cell, end)),
            None => self.conditions.circle_rows(&entries, cell, end),
        }
    }

    /// The analytic function whose zeros are the flight times: `|numerators|^2 - denominator^2` of `|u| = 1`, or the
    /// determinant of the conditions with the phase given.
    fn sample(&self, minors: &mut Minors, place: &SearchInterval) -> IntervalModel {
        let cell = place.time_interval();
        minors.compute(&self.rows(&cell, place.end));
        let n = self.n_unknowns();
        if self.phase.is_some() {
            let series = *minors.det((1 << (n + 1)) - 1);
            return IntervalModel {
                series,
                floor: FLIGHT_TIME_ROUNDING * series.size(),
            };
        }
        let [det, over_sin, over_cos] = self.wanted_circle().map(|set| minors.det(set));
        let unit = TaylorModel::constant(self.conditions.phase_unit().powi(2));
        let squares = TaylorModel::sum_of_products(
            [(1.0, over_sin, over_sin), (1.0, over_cos, over_cos)].into_iter(),
        );
        let one = TaylorModel::constant(1.0);
        let square = TaylorModel::sum_of_products([(1.0, det, det)].into_iter());
        let series = TaylorModel::sum_of_products(
            [(1.0, &unit, &squares), (-1.0, &one, &square)].into_iter(),
        );
        let error = |s: &TaylorModel| {
            (2.0 * s.bound() + FLIGHT_TIME_ROUNDING * s.size()) * FLIGHT_TIME_ROUNDING * s.size()
        };
        IntervalModel {
            series,
            floor: unit.bound() * (error(over_sin) + error(over_cos)) + error(det),
        }
    }

    /// The columns of the determinant, and of the numerators of the phase.
    fn wanted_circle(&self) -> [usize; 3] {
        let n = self.n_unknowns();
        let all = (1 << (n + 1)) - 1;
        [
            all & !(1 << n),
            all & !(1 << (n - 1)),
            all & !(1 << (n - 2)),
        ]
    }

    fn minors(&self) -> Minors {
        let n = self.n_unknowns();
        match self.phase {
            Some(_) => Minors::new(n + 1, n + 1, &[(1 << (n + 1)) - 1]),
            None => Minors::new(n + 1, n, &self.wanted_circle()),
        }
    }

    /// Whether the instants are on one surface, so that they can meet in contact.
    fn meets(&self) -> bool {
        self.phase.is_some() || self.conditions.same_surface().is_some()
    }

    /// The walk over the range; `splits` as in `TwoInstantConditions::splits_at_half`.
    fn walk(&self, splits: bool, observer: &mut Observer) -> Result<Isolated> {
        let mut minors = self.minors();
        let (low, high) = self.range();
        let meets = self.meets();
        // The repetition of resonant modes hides the meeting at T.
        let at_end = meets && !self.conditions.has_resonant_modes();
        let half = 0.5 * self.period;
        let mut walk = |range, deflated| {
            isolate(range, deflated, observer, |place| {
                self.sample(&mut minors, place)
            })
        };
        if !splits {
            return walk((low, high), (meets, at_end && high > half));
        }
        let first = walk((low, half), (meets, true))?;
        Ok(if high > half {
            first.joined(walk((half, high), (true, at_end))?)
        } else {
            first
        })
    }

    /// All roots, and in words what is proved of the rest.
    ///
    /// # Errors
    /// `Error::Interrupted` from the observer; `Error::NoConvergence` of a decomposition.
    pub fn run(&self, observer: &mut Observer) -> Result<(Vec<Root>, String)> {
        let splits = self.phase.is_none() && self.conditions.splits_at_half();
        let found = self.walk(splits, observer)?;
        let mut roots: Vec<Root> = Vec::new();
        let mut lost = 0;
        for bracket in &found.simple {
            match self.solve_simple(bracket, splits, observer)? {
                Some(root) => keep(&mut roots, root, self.period),
                None => lost += 1,
            }
        }
        let open: Vec<Enclosure> = found
            .undecided
            .iter()
            .filter(|b| !self.is_trivial(b))
            .copied()
            .collect();
        for bracket in &open {
            for root in near(self, bracket.guess, observer)? {
                if self.is_near(root.dt, bracket) && !self.is_meeting(root.dt, TRIVIAL_FLIGHT) {
                    keep(&mut roots, root, self.period);
                }
            }
        }
        if splits && !self.is_alike {
            let half = 0.5 * self.period;
            let line = Enclosure {
                low: half,
                high: half,
                guess: half,
            };
            for root in near(self, line.guess, observer)? {
                if self.is_near(root.dt, &line) {
                    keep(&mut roots, root, self.period);
                }
            }
        }
        // Nearer to an end than this nothing is searched: the instants cannot be told apart.
        roots.retain(|root| root.dt.min(self.period - root.dt) >= SAME_FLIGHT_TIME * self.period);
        let solved = roots.len();
        roots.retain(|root| !self.is_shorter(root));
        let repeats = solved > roots.len() || (splits && self.is_alike);
        let together = roots.len();
        roots.retain(|root| {
            self.conditions.contact_misfit(root, self.phase.is_some()) <= TOGETHER * root.x.norm()
        });
        let (low, high) = self.range();
        let certificate = Certificate {
            time: "flight time",
            solutions: roots.len(),
            apart: together - roots.len(),
            repeats,
            open,
            lost,
            cells: found.cells,
            length: high - low,
            is_half: high < 0.75 * self.period,
        };
        let reason = certificate.describe();
        Ok((roots, reason))
    }

    /// Where instants of one surface meet there is no orbit to find.
    fn is_trivial(&self, bracket: &Enclosure) -> bool {
        self.meets()
            && (bracket.high < TRIVIAL_FLIGHT * self.period
                || bracket.low > (1.0 - TRIVIAL_FLIGHT) * self.period)
    }

    /// Whether a root is an orbit of half the period, gone through twice.
    fn is_shorter(&self, root: &Root) -> bool {
        self.is_alike
            && self.n_periods.is_multiple_of(2)
            && (root.dt - 0.5 * self.period).abs() <= TRIVIAL_FLIGHT * self.period
            && self.conditions.impulses_repeat(&root.x)
    }

    /// Whether two instants of one surface are no farther apart than `margin` periods.
    fn is_meeting(&self, dt: f64, margin: f64) -> bool {
        self.meets() && dt.min(self.period - dt) < margin * self.period
    }

    /// Whether a flight time belongs to an undecided bracket.
    fn is_near(&self, dt: f64, bracket: &Enclosure) -> bool {
        let slack = 8.0 * (bracket.high - bracket.low) + NEAR_FLIGHT_TIME * self.period;
        dt > 0.0 && dt < self.period && dt >= bracket.low - slack && dt <= bracket.high + slack
    }

    /// The one root of a bracket that is proved to hold one.
    fn solve_simple(
        &self,
        bracket: &Enclosure,
        splits: bool,
        observer: &mut Observer,
    ) -> Result<Option<Root>> {
        let is_other = |dt: f64| {
            self.is_meeting(dt, SAME_FLIGHT_TIME)
                || (splits && (dt - 0.5 * self.period).abs() < SAME_FLIGHT_TIME * self.period)
        };
        let is_inside =
            |root: &Root| (bracket.low..=bracket.high).contains(&root.dt) && !is_other(root.dt);
        within(self, bracket, is_inside, observer)
    }
}

impl TimedConditions for FlightTimeSearch<'_> {
    fn sampler(&self) -> impl FnMut(&SearchInterval) -> IntervalModel + '_ {
        let mut minors = self.minors();
        move |place| self.sample(&mut minors, place)
    }

    fn equations(&self, dt: f64) -> TwoInstantEquations {
        let n = self.n_unknowns();
        let rows = self.rows(&point(dt, self.time_unit()), IntervalEnd::Neither);
        TwoInstantEquations::of_models(&rows, n + 1)
    }

    fn circle(&self) -> Option<f64> {
        self.phase.is_none().then(|| self.conditions.phase_unit())
    }

    fn time_unit(&self) -> f64 {
        self.period / (std::f64::consts::TAU * self.n_periods as f64)
    }

    fn period(&self) -> f64 {
        self.period
    }

    fn completed(&self, root: Root) -> Root {
        match self.phase {
            Some(u) => Root {
                x: self.conditions.with_phase(&root.x, u),
                ..root
            },
            None => root,
        }
    }
}
