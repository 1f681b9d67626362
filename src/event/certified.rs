//! The first contact along one step of an integrator, certain for gaps whose curvature is bounded (`curvature.rs`).
//!
//! With `|g''| <= B` over a width from x on, `g(x + s) >= g + g' s - B s^2/2`: up to where that falls to the floor, minus the
//! tolerance, the step provably holds no contact deeper than it. And where `g + g' s + B s^2/2` comes as far below zero before
//! `g' + B s` is none, the gap provably falls through zero once. The pieces between shrink, as Newton's steps do, towards a place
//! where the stop is crossed. Of several stops the one whose next piece ends first is searched next: no gap is evaluated beyond the first
//! contact with another stop, where it may not be defined. Places are parts of the step, from 0 to 1.

use crate::error::Result;
use crate::event::curvature::{BoundedGap, GapPoint};
use crate::event::first_root::{FirstEvent, FirstRoot};
use crate::event::step_path::StepPath;
use crate::event::touch::Bottom;
use crate::root::{Bracket, FalsePosition, NewtonPoint, newton};
use crate::tolerance::{NEAR_MINIMUM_TOLERANCES, PASSED_TOLERANCE_PART, SHORTEST_PIECE};
use std::fmt;

/// Evaluations of a gap in one search, of which a touch needs some hundreds. [work]
const MOST_SEARCH_POINTS: usize = 1 << 14;
/// Evaluations that narrow one bracket, by Newton's or secant steps or by halving it. [work]
const MOST_CERTIFIED_POLISHES: usize = 100;

/// Why a search could not be certified.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SearchFailure {
    /// It came to no end.
    Endless,
    /// It would take too many places.
    Long,
    /// The gap differs from what its gradient and its curvature allow.
    Bends,
    /// The gap is zero nowhere where it is crossed, or like no interpolant of it.
    Jumps,
    /// No step along an exact flight is short enough to tell.
    Shallow,
}

impl fmt::Display for SearchFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Endless => {
                "the search with this bound on its curvature came to no end; is `curvature` that large?"
            }
            Self::Long => {
                "the search with this bound on its curvature takes too many looks at the gap; is `curvature` that large?"
            }
            Self::Bends => {
                "the gap changes by more than its gradient and `curvature` allow: one of them is not that of the gap"
            }
            Self::Jumps => {
                "the gap jumps, or its gradient is not that of the gap"
            }
            Self::Shallow => {
                "what would begin or end one is zero to rounding there, and no step is short enough to tell on which side"
            }
        })
    }
}

/// The number of evaluations of the gap of one stop, and the number that the smallest valid bound on its curvature would have needed.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SearchCost {
    pub places: usize,
    /// A piece is as long as the root of its room over the bound, so that each evaluation counts as this part of one: the root of how much
    /// the gap bends over how much the bound allows.
    pub needed: f64,
}

impl SearchCost {
    /// The sum of both.
    pub fn with(self, other: Self) -> Self {
        Self {
            places: self.places + other.places,
            needed: self.needed + other.needed,
        }
    }

    /// The ratio of the evaluations to those needed.
    pub fn excess(self) -> f64 {
        self.places as f64 / self.needed
    }
}

/// What a search found.
#[derive(Debug, Clone)]
pub(crate) struct Certified {
    /// The first contact, its stop being the index of the gap in the list; undecided where no piece could be proved.
    pub first: FirstEvent,
    /// Why it could not be certified, if so; none where a minimum is too near to zero.
    pub doubt: Option<SearchFailure>,
    /// The cost along each of the gaps.
    pub costs: Vec<SearchCost>,
}

/// A touch along a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepTouch {
    /// The place of the gap in its list.
    pub gap: usize,
    pub x: f64,
    pub depth: f64,
}

/// The first contact of some gaps along a motion, before a part `until` of its step; touches before it are noted.
///
/// # Errors
/// What the functions of the stops report.
pub(crate) fn first_contact(
    gaps: &[BoundedGap<'_>],
    path: &StepPath,
    mut until: f64,
    touches: &mut Vec<StepTouch>,
) -> Result<Certified> {
    let searches = gaps.iter().map(|gap| GapSearch::new(gap, path));
    let mut searches = searches.collect::<Result<Vec<_>>>()?;
    let mut found = Certified {
        first: FirstEvent::NONE,
        doubt: None,
        costs: Vec::new(),
    };
    loop {
        let open = searches.iter_mut().enumerate();
        let open = open.filter(|(_, search)| search.here.x < until);
        let least = open.min_by(|(_, a), (_, b)| a.reach().total_cmp(&b.reach()));
        let Some((gap, search)) = least else {
            found.costs = searches.iter().map(|search| search.cost).collect();
            return Ok(found);
        };
        let (root, doubt) = match search.go_on(until)? {
            PieceOutcome::Clear => continue,
            PieceOutcome::Touch { x, depth } => {
                touches.push(StepTouch { gap, x, depth });
                continue;
            }
            PieceOutcome::Root(root) => (root, None),
            PieceOutcome::Lost(doubt) => {
                let at = search.here.x;
                (FirstRoot::Undecided { at }, Some(doubt))
            }
        };
        search.here.x = f64::INFINITY;
        if root.at() < found.first.root.at() {
            (found.first, found.doubt) = (FirstEvent { stop: gap, root }, doubt);
            until = until.min(root.at());
        }
    }
}

/// The next move of a search.
#[derive(Clone, Copy)]
enum Plan {
    /// A piece up to a place that is proved, with a bound on how the gap bends there.
    Piece {
        to: f64,
        bend: f64,
    },
    /// A place before which the gap falls through zero, for certain.
    Crossing {
        passed: f64,
    },
    /// It begins a little below zero, and falls.
    Falls,
    Lost(SearchFailure),
}

/// What the search found on a piece.
enum PieceOutcome {
    Clear,
    Touch { x: f64, depth: f64 },
    Root(FirstRoot),
    Lost(SearchFailure),
}

/// The search on one gap.
struct GapSearch<'a> {
    of: &'a BoundedGap<'a>,
    path: &'a StepPath,
    /// The place up to which it is proved.
    here: GapPoint,
    plan: Plan,
    /// The width of the next piece to be tried.
    width: f64,
    /// Whether the gap has opened, and the last place at which it was.
    is_open: bool,
    open: f64,
    /// How deep the start is, if it is below zero: nothing is proved above it.
    depth: f64,
    cost: SearchCost,
}

impl<'a> GapSearch<'a> {
    fn new(of: &'a BoundedGap<'a>, path: &'a StepPath) -> Result<Self> {
        let mut here = of.at(path, 0.0)?;
        if of.order > 0 {
            here.gap = 0.0;
        }
        let is_open = of.order == 0 && here.gap >= -here.rounding;
        let falls = !is_open && of.order == 0 && here.slope < 0.0;
        let mut search = Self {
            of,
            path,
            plan: Plan::Falls,
            width: 1.0,
            is_open,
            open: 0.0,
            depth: (-here.gap).max(0.0),
            here,
            // The start is looked at, and another place at the least.
            cost: SearchCost {
                places: 1,
                needed: 2.0,
            },
        };
        if !falls {
            search.plan = search.planned(1.0);
        }
        Ok(search)
    }

    /// The farthest place of the next evaluation.
    fn reach(&self) -> f64 {
        match self.plan {
            Plan::Piece { to, .. } => to,
            Plan::Crossing { passed } => passed,
            Plan::Falls | Plan::Lost(_) => self.here.x,
        }
    }

    /// The next move, no farther than to a part of the step.
    fn planned(&self, until: f64) -> Plan {
        let GapPoint {
            x,
            gap,
            slope,
            tolerance,
            ..
        } = self.here;
        let left = until - x;
        let room = (gap + tolerance + self.depth).max(0.0);
        let mut width = self.width.min(left);
        loop {
            let bend = self.of.bend(&self.here, width);
            if let Some(passed) = crossed(gap + 2.0 * tolerance, slope, bend)
                && passed <= width
                && self.is_open
            {
                let passed = x + passed;
                return Plan::Crossing { passed };
            }
            let s = proved(room, slope, bend);
            if s >= width {
                // Exactly there, where all is left.
                let to = if width >= left { until } else { x + width };
                return Plan::Piece { to, bend };
            }
            if s.is_nan() || x + s == x || s < SHORTEST_PIECE * left {
                return Plan::Lost(SearchFailure::Endless);
            }
            if self.cost.places > MOST_SEARCH_POINTS {
                return Plan::Lost(SearchFailure::Long);
            }
            if s >= 0.5 * width {
                return Plan::Piece { to: x + s, bend };
            }
            width = 2.0 * s;
        }
    }

    /// Makes the next move, no farther than to a part of the step.
    fn go_on(&mut self, until: f64) -> Result<PieceOutcome> {
        let (to, bend) = match self.plan {
            Plan::Piece { to, bend } => (to.min(until), bend),
            Plan::Crossing { passed } if passed <= until => {
                return Ok(PieceOutcome::Root(self.crossing(self.here.x, passed)?));
            }
            Plan::Crossing { .. } => {
                self.plan = self.planned(until);
                return Ok(PieceOutcome::Clear);
            }
            Plan::Falls => {
                let root = FirstRoot::Crossing {
                    at: 0.0,
                    passed: until,
                };
                return Ok(PieceOutcome::Root(root));
            }
            Plan::Lost(doubt) => return Ok(PieceOutcome::Lost(doubt)),
        };
        self.cost.places += 1;
        let next = self.of.at(self.path, to)?;
        let s = to - self.here.x;
        let miss = (next.gap - self.here.gap - self.here.slope * s).abs();
        let (most, known) = (0.5 * bend * s * s, self.here.tolerance + next.tolerance);
        if miss > most + known {
            return Ok(PieceOutcome::Lost(SearchFailure::Bends));
        }
        // Near zero the tolerance makes pieces short, whatever the bound.
        self.cost.needed += if most > known {
            ((miss - known).max(0.0) / most).sqrt()
        } else {
            1.0
        };
        let ahead = self.judge(&next)?;
        if next.gap > if self.is_open { 0.0 } else { next.tolerance } {
            (self.is_open, self.open, self.depth) = (true, next.x, 0.0);
        }
        (self.here, self.width) = (next, 2.0 * s);
        if !matches!(ahead, PieceOutcome::Root(_)) && self.here.x < until {
            self.plan = self.planned(until);
        }
        Ok(ahead)
    }

    /// What is on the piece up to a place: a crossing where the gap ends below the tolerance, a minimum near zero, or nothing.
    fn judge(&self, next: &GapPoint) -> Result<PieceOutcome> {
        let here = &self.here;
        // A gap that has not opened yet is zero but for the tolerance.
        let deep = if self.is_open {
            next.doubt
        } else {
            PASSED_TOLERANCE_PART * next.tolerance + self.depth
        };
        if next.gap < -deep && next.slope <= 0.0 {
            return Ok(PieceOutcome::Root(self.crossing(self.open, next.x)?));
        }
        let turns = here.slope < 0.0 && next.slope > 0.0;
        let least = here.gap.min(next.gap);
        if !(turns && self.is_open && least <= NEAR_MINIMUM_TOLERANCES * next.tolerance) {
            return Ok(PieceOutcome::Clear);
        }
        let GapPoint {
            x,
            gap,
            rounding,
            doubt,
            ..
        } = self.lowest(here.x, next.x)?;
        let doubt = (doubt > 1.5 * rounding).then_some(doubt);
        Ok(match Bottom::in_step(gap, rounding, doubt) {
            Bottom::Undecided => PieceOutcome::Root(FirstRoot::Undecided { at: x }),
            Bottom::Passed => PieceOutcome::Root(self.crossing(self.open, x)?),
            Bottom::Touch => PieceOutcome::Touch { x, depth: -gap },
            Bottom::Open => PieceOutcome::Clear,
        })
    }

    /// The root between a place at which the gap is open, or has its root of some order, and one at which it is passed.
    fn crossing(&self, open: f64, passed: f64) -> Result<FirstRoot> {
        let between = Bracket::new([open, passed]);
        let guess = between.middle();
        let step = newton(
            between,
            guess,
            MOST_CERTIFIED_POLISHES,
            |x| -> Result<NewtonPoint> {
                let there = self.of.at(self.path, x)?;
                Ok(NewtonPoint {
                    value: there.gap,
                    slope: there.slope,
                    resolution: 2.0 * f64::EPSILON * x,
                })
            },
        )?;
        let at = step.from;
        Ok(FirstRoot::Crossing { at, passed })
    }

    /// The lowest place between one at which the gap falls and one at which it rises.
    fn lowest(&self, falls: f64, rises: f64) -> Result<GapPoint> {
        let mut search = FalsePosition::new([falls, rises], [self.here.slope, f64::NAN]);
        let mut place = self.of.at(self.path, search.trial())?;
        for _ in 0..MOST_CERTIFIED_POLISHES {
            search.narrow(place.x, place.slope);
            let next = search.trial();
            let is_found = place.slope.abs() * search.between.length() <= 0.1 * place.rounding;
            if is_found || !search.between.has(next) {
                break;
            }
            place = self.of.at(self.path, next)?;
        }
        Ok(place)
    }
}

/// How far a gap stays above its floor that is no nearer than `room`, with a slope and a bound on how it bends.
fn proved(room: f64, slope: f64, bend: f64) -> f64 {
    let root = (slope * slope + 2.0 * bend * room).sqrt();
    // Of the two forms of the root the one without cancellation; infinite for a gap that neither falls nor can bend.
    if slope > 0.0 {
        (slope + root) / bend
    } else if root > slope {
        2.0 * room / (root - slope)
    } else {
        f64::INFINITY
    }
}

/// How far on a gap has fallen by `height`, for certain, and falls all the way; none where that is not known.
fn crossed(height: f64, slope: f64, bend: f64) -> Option<f64> {
    let square = slope * slope - 2.0 * bend * height;
    (slope < 0.0 && square > 0.0 && height > 0.0).then(|| 2.0 * height / (square.sqrt() - slope))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Result;
    use crate::flow::steps::Tolerance;
    use crate::model::{
        Contact, Forcing, GapFunction, LinearSystem, Moment, NonlinearStop, Scene, WatchedGap,
        contacts,
    };
    use nalgebra::DVector;

    type Function = fn(&[f64]) -> f64;
    type Gradient = fn(&[f64]) -> [f64; 2];

    struct Given(Function, Gradient);

    impl GapFunction for Given {
        fn gap(&self, q: &[f64]) -> Result<f64> {
            Ok(self.0(q))
        }
        fn gradient(&self, q: &[f64], gradient: &mut [f64]) -> Result<()> {
            gradient.copy_from_slice(&self.1(q));
            Ok(())
        }
    }

    const TOLERANCE: Tolerance = Tolerance {
        relative: 1e-9,
        absolute: 1e-12,
    };

    fn contact(gap: Function, gradient: Gradient, curvature: f64) -> Contact {
        let stop = NonlinearStop::new(Given(gap, gradient), 1.0).expect("valid");
        let stop = stop.with_curvature(curvature).expect("valid");
        let (one, zero) = (DVector::from_element(2, 1.0), DVector::zeros(2));
        let system = LinearSystem::undamped(one, zero).expect("valid");
        let scene = Scene::new(system, Forcing::Unforced, [stop]).expect("valid");
        contacts(&scene).remove(0)
    }

    fn bounded(contact: &Contact, order: usize) -> BoundedGap<'_> {
        BoundedGap {
            watched: WatchedGap::Gap,
            contact,
            curvature: contact.surface.curvature().expect("given"),
            order,
            departed: 0.0,
            begun: Moment::of_angle(0.0),
            h: 1.0,
            tolerance: TOLERANCE,
            known: 0.0,
        }
    }

    fn searched(
        of: &[(&Contact, usize)],
        path: [Vec<f64>; 2],
        error: f64,
    ) -> (Certified, Vec<StepTouch>) {
        let gaps = of.iter().map(|&(contact, order)| bounded(contact, order));
        let gaps: Vec<BoundedGap<'_>> = gaps.collect();
        let path = StepPath::new(path.to_vec(), vec![error; 2]);
        let mut touches = Vec::new();
        let found = first_contact(&gaps, &path, 1.0, &mut touches).expect("finite");
        (found, touches)
    }

    fn root(found: &Certified) -> (f64, f64) {
        match found.first.root {
            FirstRoot::Crossing { at, passed } => (at, passed),
            other => panic!("{other:?} {:?}", found.doubt),
        }
    }

    /// `q_0 + sin(q_1)/2`: the end of a rod.
    fn rod() -> Contact {
        contact(
            |q| q[0] + 0.5 * q[1].sin(),
            |q| [1.0, 0.5 * q[1].cos()],
            0.5,
        )
    }

    #[test]
    fn the_end_of_a_rod_that_spins_many_times_in_a_step_is_met_where_it_first_comes_down() {
        let rod = rod();
        for spin in [3.0, 30.0, 300.0] {
            // From a height of 2 at a speed of 4 downwards.
            let height = |x: f64| 2.0 - 4.0 * x + 0.5 * (1.0 + spin * x).sin();
            let places = (0..200_000).map(|k| f64::from(k) * 5e-6);
            let first = places.into_iter().find(|x| height(*x) < 0.0).expect("met");
            let path = [vec![2.0, -4.0], vec![1.0, spin]];
            let (found, touches) = searched(&[(&rod, 0)], path, 0.0);
            let (at, passed) = root(&found);
            assert!((at - first).abs() < 5.1e-6, "{spin} {at} {first}");
            assert!(height(passed) < 0.0 && passed > at);
            assert!(height(at).abs() < 1e-12 && touches.is_empty());
        }
    }

    #[test]
    fn a_search_is_as_long_in_any_unit_of_length() {
        let small = contact(
            |q| q[0] + 0.5e-9 * q[1].sin(),
            |q| [1.0, 0.5e-9 * q[1].cos()],
            0.5e-9,
        );
        // The rod begins to spin on the way: its angle has an acceleration, which is none of its height.
        let search = |rod: &Contact, unit: f64, error: f64| {
            let path = [vec![2.0 * unit, -4.0 * unit], vec![1.0, 3.0, 15.0]];
            let (found, _) = searched(&[(rod, 0)], path, error);
            (root(&found).0, found.costs[0])
        };
        let (at, known) = search(&rod(), 1.0, 0.0);
        let (there, found) = search(&small, 1e-9, 0.0);
        assert!((at - there).abs() < 1e-9);
        assert!(found.places <= 2 * known.places, "{found:?} {known:?}");
        assert!(found.excess() < 4.0);
    }

    #[test]
    fn an_angle_that_is_not_known_leaves_as_much_unknown_of_a_gap_as_it_moves_it() {
        // A height, and an angle that is known to 1e-6 and moves it by 1e-9 a radian: it is not zero below that.
        let tilted = contact(|q| q[0] + 1e-9 * q[1], |_| [1.0, 1e-9], 0.0);
        let path = [vec![1e-9 + 1e-12, -4e-9, 4e-9], vec![0.0]];
        let path = StepPath::new(path.to_vec(), vec![0.0, 1e-6]);
        let given = [BoundedGap {
            tolerance: Tolerance {
                relative: 1e-9,
                absolute: 0.0,
            },
            ..bounded(&tilted, 0)
        }];
        let found = first_contact(&given, &path, 1.0, &mut Vec::new()).expect("finite");
        assert_eq!((found.first.root, found.doubt), (FirstRoot::None, None));
    }

    #[test]
    fn a_bound_that_is_too_large_shows_in_what_the_search_takes() {
        let plane = contact(|q| q[1] + q[0] * q[0], |q| [2.0 * q[0], 1.0], 2.0);
        let loose = contact(|q| q[1] + q[0] * q[0], |q| [2.0 * q[0], 1.0], 2e6);
        let path = || [vec![-1.0, 2.0], vec![0.1]];
        let [close, far] = [&plane, &loose].map(|gap| {
            let (found, _) = searched(&[(gap, 0)], path(), 0.0);
            assert_eq!((found.first.root, found.doubt), (FirstRoot::None, None));
            found.costs[0]
        });
        assert!(close.excess() < 4.0, "{close:?}");
        // A thousand times as many, and as many needed.
        assert!(far.places > 200 * close.places, "{far:?} {close:?}");
        let ratio = far.needed / close.needed;
        assert!((0.25..4.0).contains(&ratio), "{far:?} {close:?}");
    }

    #[test]
    fn nothing_is_asked_of_a_gap_behind_the_first_contact() {
        // A wall at 0.3, and behind it a stop whose gap is none.
        let wall = contact(|q| 0.3 - q[0], |_| [-1.0, 0.0], 0.0);
        let beyond = contact(
            |q| {
                assert!(q[0] < 0.31, "asked at {}", q[0]);
                1.0 + q[1]
            },
            |_| [0.0, 1.0],
            10.0,
        );
        let line = || [vec![0.0, 1.0], vec![0.0]];
        let (found, _) = searched(&[(&beyond, 0), (&wall, 0)], line(), 0.0);
        assert_eq!(found.first.stop, 1);
        assert!((root(&found).0 - 0.3).abs() < 1e-14);
    }

    #[test]
    fn the_earliest_of_several_is_found_in_any_order() {
        let at = |k: usize| -> Contact {
            let all: [Function; 3] = [|q| 0.2 - q[0], |q| 0.5 - q[0], |q| 0.2001 - q[0]];
            contact(all[k], |_| [-1.0, 0.0], 3.0)
        };
        let all = [at(0), at(1), at(2)];
        for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
            let gaps: Vec<_> = order.iter().map(|&k| (&all[k], 0)).collect();
            let (found, _) = searched(&gaps, [vec![0.0, 1.0], vec![0.0]], 0.0);
            assert_eq!(order[found.first.stop], 0);
            assert!((root(&found).0 - 0.2).abs() < 1e-14);
        }
    }

    #[test]
    fn a_spike_narrower_than_the_step_is_found_and_one_passed_above_is_not() {
        // A wall along the first coordinate with a spike of height 1 and width 1/100 at zero.
        let spike = contact(
            |q| q[1] - (-1e4 * q[0] * q[0]).exp(),
            |q| [2e4 * q[0] * (-1e4 * q[0] * q[0]).exp(), 1.0],
            2e4,
        );
        let path = |height: f64| [vec![-1.0, 4.0], vec![height]];
        let (found, _) = searched(&[(&spike, 0)], path(0.5), 0.0);
        let exact = 0.25 * (1.0 - 1e-2 * 2f64.ln().sqrt());
        assert!((root(&found).0 - exact).abs() < 1e-12);
        let (found, _) = searched(&[(&spike, 0)], path(1.0 + 1e-6), 0.0);
        assert_eq!((found.first.root, found.doubt), (FirstRoot::None, None));
    }

    #[test]
    fn dips_below_rounding_are_contacts_and_those_within_it_touches() {
        let plane = contact(|q| q[1], |_| [0.0, 1.0], 0.0);
        // (x - 1/2)^2 - depth, whose size is about one.
        let path = |depth: f64| [vec![0.0], vec![0.25 - depth, -1.0, 1.0]];
        for depth in [1e-3, 1e-8, 1e-10, 1e-12] {
            let (found, _) = searched(&[(&plane, 0)], path(depth), 0.0);
            let lost = 1e-15 / depth.sqrt();
            assert!(
                (root(&found).0 - 0.5 + depth.sqrt()).abs() < lost,
                "{depth}"
            );
        }
        let (found, touches) = searched(&[(&plane, 0)], path(0.0), 0.0);
        assert_eq!((found.first.root, touches.len()), (FirstRoot::None, 1));
        for height in [1e-12, 1e-8, 1e-3] {
            let (found, touches) = searched(&[(&plane, 0)], path(-height), 0.0);
            assert_eq!((found.first.root, touches.len()), (FirstRoot::None, 0));
        }
        // What the motion is not known to is not told from a touch.
        let (found, _) = searched(&[(&plane, 0)], path(1e-10), 1e-9);
        let FirstRoot::Undecided { at } = found.first.root else {
            panic!("{found:?}")
        };
        assert!((at - 0.5).abs() < 1e-6 && found.doubt.is_none());
    }

    #[test]
    fn a_low_flight_behind_an_impact_ends_where_it_comes_down() {
        let plane = contact(|q| q[1], |_| [0.0, 1.0], 0.0);
        for speed in [0.5, 1e-3, 1e-6, 1e-8] {
            let path = [vec![0.0], vec![0.0, speed, -1.0]];
            let (found, _) = searched(&[(&plane, 1)], path, 0.0);
            let (at, _) = root(&found);
            assert!((at / speed - 1.0).abs() < 1e-6, "{speed} {at}");
        }
        // Let go with an acceleration, or a jerk: it does not come back.
        for rise in [vec![0.0, 0.0, 1.0], vec![0.0, 0.0, 0.0, 1.0]] {
            let order = rise.len() - 1;
            let (found, _) = searched(&[(&plane, order)], [vec![0.0], rise], 0.0);
            assert_eq!((found.first.root, found.doubt), (FirstRoot::None, None));
        }
    }

    #[test]
    fn a_start_below_zero_that_rises_and_falls_comes_to_an_end() {
        let plane = contact(|q| q[1], |_| [0.0, 1.0], 0.0);
        let path = |deep: f64| [vec![0.0], vec![-deep, 1e-3, -1.0]];
        for deep in [1e-13, 1e-10, 1e-3] {
            let (found, _) = searched(&[(&plane, 0)], path(deep), 0.0);
            let (at, _) = root(&found);
            assert!(at <= 1e-3, "{deep} {at} {:?}", found.doubt);
        }
    }

    #[test]
    fn bounds_that_are_none_and_searches_without_an_end_are_told() {
        let line = || [vec![-1.0, 2.0], vec![0.1]];
        // A gradient that is another's; a jump; a curvature beyond all reason.
        let wrong = contact(|q| q[1] + q[0] * q[0], |_| [3.0, 1.0], 2.0);
        let jump = contact(
            |q| if q[0] < 0.2 { 1.0 } else { -1.0 },
            |_| [0.0, 0.0],
            10.0,
        );
        for (gap, doubt) in [
            (&wrong, SearchFailure::Bends),
            (&jump, SearchFailure::Bends),
            (
                &contact(|q| q[1] + q[0] * q[0], |q| [2.0 * q[0], 1.0], 1e20),
                SearchFailure::Long,
            ),
        ] {
            let (found, _) = searched(&[(gap, 0)], line(), 0.0);
            assert!(matches!(found.first.root, FirstRoot::Undecided { .. }));
            assert_eq!(found.doubt, Some(doubt));
        }
    }
}
