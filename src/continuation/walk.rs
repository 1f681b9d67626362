//! One half of a curve of zeros, step by step from its first point to its end (theory 19): where steps are refused they are halved, and
//! the curve ends where it comes back to its first point.

use crate::continuation::end::{BranchEnd, EndReason};
use crate::continuation::failure::StepFailure;
use crate::continuation::zero_problem::ScaledDirection;
use crate::error::Result;
use crate::tolerance::CLOSED_BRANCH_DIRECTION;

/// One half of a branch or a curve, without its first point, and why it ended.
pub(crate) struct HalfBranch<P, S> {
    pub points: Vec<P>,
    pub special: Vec<S>,
    pub end: BranchEnd,
}

/// The outcome of a step.
pub(crate) enum StepOutcome<P, S> {
    /// A point, the special points before it, and the factor on the next step.
    Accepted(Box<P>, Vec<S>, f64),
    /// An end: the last point, where there is one, and the special points before it.
    End(Option<Box<P>>, Vec<S>, BranchEnd),
    /// Why there is no point: a shorter step may succeed.
    Refused(StepFailure),
    /// The problem was changed, and the step is to be made again.
    Changed,
}

impl<P, S> StepOutcome<P, S> {
    /// An end at the point before the step.
    pub fn end(end: BranchEnd) -> Self {
        Self::End(None, Vec::new(), end)
    }
}

/// A curve that is followed: what is done at each of its steps.
pub(crate) trait Walk {
    type Point;
    type Iterate;
    type Direction: ScaledDirection;
    type Special;

    /// Makes a step of some arclength \[-\] from the last of the points, from the first one if there are none, and judges it.
    fn step(
        &mut self,
        first: &mut Self::Point,
        points: &mut [Self::Point],
        length: f64,
    ) -> Result<StepOutcome<Self::Point, Self::Special>>;

    /// The tangent at a point.
    fn tangent<'p>(&self, own: &'p Self::Point) -> &'p Self::Direction;

    /// The iterate of the first point in the round of another one, and the chord from there to that.
    fn home_from(&self, first: &Self::Point, own: &Self::Point)
    -> (Self::Iterate, Self::Direction);

    /// An accepted point as one of the curve.
    fn kept(&mut self, own: Self::Point) -> Result<Self::Point>;

    /// Whether the curve ends at an accepted point; with the special point there.
    fn ended(&self, own: &Self::Point) -> Result<Option<(Option<Self::Special>, BranchEnd)>>;

    /// The first point again, behind the last one of a closed curve, and the special points between; `passed` are those of the step that
    /// led past it.
    fn closed(
        &self,
        from: &Self::Point,
        first: (&Self::Point, Self::Iterate),
        passed: Vec<Self::Special>,
    ) -> Result<(Self::Point, Vec<Self::Special>)>;

    /// The end at a point from which the shortest step is refused, with the special point there.
    fn refused(
        &self,
        from: (&Self::Point, &[Self::Point]),
        failure: StepFailure,
        length: f64,
    ) -> Result<(Option<Self::Special>, BranchEnd)>;
}

/// Follows a curve from a point, which is not among the points returned, along its tangent; with the smallest, the first and the largest
/// step \[-\].
pub(crate) fn walk<W: Walk>(
    walker: &mut W,
    mut first: W::Point,
    [smallest, usual, largest]: [f64; 3],
    most_points: usize,
) -> Result<HalfBranch<W::Point, W::Special>> {
    let mut points: Vec<W::Point> = Vec::new();
    let mut special = Vec::new();
    let (mut step, mut farthest) = (usual, 0.0f64);
    let end = loop {
        if points.len() >= most_points {
            let detail = format!("{most_points} points were asked for");
            break BranchEnd::new(EndReason::Points, detail);
        }
        let failure = match walker.step(&mut first, &mut points, step)? {
            StepOutcome::Accepted(own, found, factor) => {
                let (begun, home) = walker.home_from(&first, &own);
                let (away, tangent) = (home.length(), walker.tangent(&first));
                let has_closed = farthest > 2.0 * step
                    && away < step
                    && tangent.dot(walker.tangent(&own)) > CLOSED_BRANCH_DIRECTION;
                farthest = farthest.max(away);
                let mut passed = Vec::new();
                if has_closed && tangent.dot(&home) > 0.0 {
                    passed = found;
                } else {
                    special.extend(found);
                    points.push(walker.kept(*own)?);
                }
                if has_closed {
                    let from = points.last().unwrap_or(&first);
                    let (last, found) = walker.closed(from, (&first, begun), passed)?;
                    special.extend(found);
                    points.push(last);
                    let detail = "it came back to where it began".to_owned();
                    break BranchEnd::new(EndReason::Closed, detail);
                }
                let ended = points.last().map_or(Ok(None), |own| walker.ended(own))?;
                if let Some((found, end)) = ended {
                    special.extend(found);
                    break end;
                }
                step = (step * factor).clamp(smallest, largest);
                continue;
            }
            StepOutcome::End(last, found, end) => {
                special.extend(found);
                points.extend(last.map(|last| *last));
                break end;
            }
            StepOutcome::Changed => continue,
            StepOutcome::Refused(failure) => failure,
        };
        if step <= smallest {
            let from = points.last().unwrap_or(&first);
            let (found, end) = walker.refused((from, &points), failure, step)?;
            special.extend(found);
            break end;
        }
        step = (0.5 * step).max(smallest);
    };
    Ok(HalfBranch {
        points,
        special,
        end,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::continuation::corrector::{Corrected, CorrectedOf, corrected};
    use crate::continuation::locator::{ChangeBracket, evaluated, locate_change, locate_zero};
    use crate::continuation::predictor::{stepped, stepped_to};
    use crate::continuation::step_control::step_factor;
    use crate::continuation::zero_problem::{Linearisation, ZeroProblem};
    use nalgebra::{DMatrix, DVector, dmatrix, dvector};

    /// `x^2 + p^2 = 1`, of which p is the number.
    struct Circle;

    #[derive(Clone)]
    struct Chord(DVector<f64>);

    impl ScaledDirection for Chord {
        fn of(components: &DVector<f64>) -> Self {
            Self(components.clone())
        }

        fn dot(&self, other: &Self) -> f64 {
            self.0.dot(&other.0)
        }

        fn row(&self) -> DVector<f64> {
            self.0.clone()
        }

        fn scaled(&self, factor: f64) -> Self {
            Self(&self.0 * factor)
        }

        fn plus(&self, other: &Self) -> Self {
            Self(&self.0 + &other.0)
        }

        fn unit(&self) -> Self {
            Self(self.0.normalize())
        }
    }

    #[derive(Clone)]
    struct Linear(DMatrix<f64>, DVector<f64>);

    impl Linearisation for Linear {
        fn matrix(&self) -> DMatrix<f64> {
            self.0.clone()
        }

        fn right(&self) -> &DVector<f64> {
            &self.1
        }

        fn mismatch(&self) -> f64 {
            self.1.amax()
        }
    }

    impl ZeroProblem for Circle {
        type Iterate = DVector<f64>;
        type Equations = Linear;
        type Direction = Chord;

        const N_NUMBERS: usize = 1;
        const MOST_CORRECTIONS: usize = 8;
        const KEPT_CORRECTION: Option<f64> = None;

        fn value(&self, at: &DVector<f64>) -> f64 {
            at[1]
        }

        fn coinciding(&self, _: &DVector<f64>) -> Option<usize> {
            None
        }

        fn linearise(&self, at: &DVector<f64>, _: Option<&Linear>) -> Result<Linear> {
            let rates = dmatrix![2.0 * at[0], 2.0 * at[1]];
            Ok(Linear(rates, dvector![1.0 - at.norm_squared()]))
        }

        fn retract(&self, at: &DVector<f64>, _: &Linear, by: &Chord) -> Result<DVector<f64>> {
            Ok(at + &by.0)
        }

        fn settle(
            &self,
            at: DVector<f64>,
            _: Linear,
            by: Option<&Chord>,
        ) -> Result<(DVector<f64>, Linear)> {
            let there = by.map_or(at.clone(), |by| at + &by.0);
            let equations = self.linearise(&there, None)?;
            Ok((there, equations))
        }

        fn pin(&self, mut at: DVector<f64>, _: usize, value: f64) -> Result<DVector<f64>> {
            at[1] = value;
            Ok(at)
        }
    }

    type CirclePoint = CorrectedOf<Circle>;

    impl Walk for Circle {
        type Point = CirclePoint;
        type Iterate = DVector<f64>;
        type Direction = Chord;
        type Special = ();

        fn step(
            &mut self,
            first: &mut CirclePoint,
            points: &mut [CirclePoint],
            length: f64,
        ) -> Result<StepOutcome<CirclePoint, ()>> {
            let from = points.last().unwrap_or(first);
            Ok(match stepped(self, from.base(), length)? {
                Ok(found) => {
                    let cosine = found.tangent.dot(&from.tangent);
                    match step_factor(found.contraction, cosine) {
                        Ok(factor) => StepOutcome::Accepted(Box::new(found), Vec::new(), factor),
                        Err(why) => StepOutcome::Refused(StepFailure::distrusted(why.to_owned())),
                    }
                }
                Err(failure) => StepOutcome::Refused(failure),
            })
        }

        fn tangent<'p>(&self, own: &'p CirclePoint) -> &'p Chord {
            &own.tangent
        }

        fn home_from(&self, first: &CirclePoint, own: &CirclePoint) -> (DVector<f64>, Chord) {
            let begun = first.iterate.clone();
            let home = Chord(&own.iterate - &begun);
            (begun, home)
        }

        fn kept(&mut self, own: CirclePoint) -> Result<CirclePoint> {
            Ok(own)
        }

        fn ended(&self, _: &CirclePoint) -> Result<Option<(Option<()>, BranchEnd)>> {
            Ok(None)
        }

        fn closed(
            &self,
            _: &CirclePoint,
            (first, _): (&CirclePoint, DVector<f64>),
            passed: Vec<()>,
        ) -> Result<(CirclePoint, Vec<()>)> {
            Ok((first.clone(), passed))
        }

        fn refused(
            &self,
            _: (&CirclePoint, &[CirclePoint]),
            failure: StepFailure,
            _: f64,
        ) -> Result<(Option<()>, BranchEnd)> {
            Ok((None, failure.end()))
        }
    }

    /// The point (1, 0), the tangent upwards.
    fn begun() -> CirclePoint {
        let found = corrected(&Circle, dvector![1.1, 0.0], &Chord(dvector![0.0, 1.0]));
        let Ok(Ok(found)) = found else {
            panic!("no point")
        };
        found
    }

    #[test]
    fn a_predicted_point_is_corrected_to_the_curve() {
        let Corrected {
            iterate, tangent, ..
        } = begun();
        assert!((iterate - dvector![1.0, 0.0]).amax() < 1e-15);
        assert!((tangent.0 - dvector![0.0, 1.0]).amax() < 1e-15);
        let there = stepped_to(&Circle, begun().base(), 0.3, (0, 0.3)).expect("no error");
        let Ok(there) = there else { panic!("no point") };
        assert_eq!(there.iterate[1], 0.3);
        assert!((there.iterate[0] - 0.91f64.sqrt()).abs() < 1e-15);
        // No point of the circle has this value.
        let none = stepped_to(&Circle, begun().base(), 0.3, (0, 1.5)).expect("no error");
        assert!(matches!(none, Err(StepFailure::Stalled { .. })));
    }

    #[test]
    fn a_closed_curve_is_followed_once_round() {
        let half = walk(&mut Circle, begun(), [1e-6, 0.05, 0.1], 1000).expect("no error");
        assert_eq!(half.end.reason, EndReason::Closed);
        let off = |own: &CirclePoint| (own.iterate.norm() - 1.0).abs();
        assert!(half.points.iter().all(|own| off(own) < 1e-14));
        let all: Vec<CirclePoint> = [begun()].into_iter().chain(half.points).collect();
        let chords = all
            .windows(2)
            .map(|two| (&two[1].iterate - &two[0].iterate).norm());
        let length: f64 = chords.sum();
        // Chords of 0.1 are shorter than their arcs by a part of 0.1^2/24.
        let missing = 1.0 - length / std::f64::consts::TAU;
        assert!((0.0..5e-4).contains(&missing), "{missing:e}");
        let few = walk(&mut Circle, begun(), [1e-6, 0.05, 0.1], 3).expect("no error");
        assert_eq!((few.end.reason, few.points.len()), (EndReason::Points, 3));
    }

    #[test]
    fn zeros_and_changes_on_a_step_are_located() {
        // Along the tangent at (1, 0) the arclength of a step is p.
        let from = begun();
        let exact = (1.0f64 - 0.81).sqrt();
        let ends = [0.5, 0.1, 0.75f64.sqrt() - 0.9];
        let mut point = |along: f64| {
            evaluated(&Circle, from.base(), along, |there| {
                Ok(Some((there.iterate[1], there.iterate[0] - 0.9)))
            })
        };
        let zero = locate_zero(ends, 1.0, &mut point)
            .expect("no error")
            .expect("a zero");
        assert!((zero.along - exact).abs() <= zero.error.max(1e-15) && zero.error < 1e-11);
        let mut middle = |own: &ChangeBracket<f64>| Ok(0.5 * (own.ends[0] + own.ends[1]));
        let mut at = |along: f64| Ok(Some((along, along < exact)));
        let found = locate_change(0.5, 1e-11, &mut middle, &mut at).expect("no error");
        let [low, high] = found.ends;
        assert!(low < exact && exact <= high && high - low <= 1e-11 && found.is_reached);
        assert_eq!(found.points, [Some(low), Some(high)]);
    }
}
