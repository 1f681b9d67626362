//! What is asked of a simulation beside the scene and the start, and what it counts.

use crate::error::{Error, Result};
use crate::hybrid::Counts;
use crate::model::{Ramp, Scene};
use crate::simulate::solver::Solver;

/// What a trajectory keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Keep {
    /// Every flight: the motion can be asked for at any time.
    #[default]
    Motion,
    /// The impacts and the contacts, and the motion at `t_eval`.
    Impacts,
    /// The final state, and the motion at `t_eval`: constant memory.
    Final,
}

/// Options of [`crate::simulate()`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SimulateOptions {
    /// The method and its tolerances.
    pub solver: Solver,
    /// Times at which the motion is wanted, shape `(m,)`, \[s\], ascending and inside the span.
    pub t_eval: Option<Vec<f64>>,
    /// What is kept.
    pub keep: Keep,
    /// The run ends after this many impacts.
    pub max_impacts: Option<usize>,
    /// Numbers of the scene that drift along the run, each by a ramp of its own.
    pub ramps: Vec<Ramp>,
}

impl SimulateOptions {
    /// The options of a run by a solver that keeps something.
    pub(crate) fn by(solver: Solver, keep: Keep) -> Self {
        Self {
            solver,
            keep,
            ..Self::default()
        }
    }

    /// The options of one chapter of a run of a scene that is to go until a time: the sample times that fall into it.
    ///
    /// # Errors
    /// A method that cannot follow the ramps.
    pub(crate) fn of_chapter(&self, scene: &Scene, span: (f64, f64), until: f64) -> Result<Self> {
        let of_chapter = |all: &Vec<f64>| {
            let before = |limit: f64| all.partition_point(|t| *t < limit);
            let end = if span.1 >= until {
                all.len()
            } else {
                before(span.1)
            };
            all[before(span.0)..end].to_vec()
        };
        Ok(Self {
            solver: Solver {
                method: self.solver.method.under(&self.ramps, scene)?,
                ..self.solver
            },
            t_eval: self.t_eval.as_ref().map(of_chapter),
            keep: self.keep,
            max_impacts: self.max_impacts,
            ramps: Vec::new(),
        })
    }

    pub(crate) fn check(&self, (start, end): (f64, f64)) -> Result<()> {
        if !(start.is_finite() && end.is_finite() && start <= end) {
            return Err(Error::bad_value(
                "t_span",
                format!("({start}, {end})"),
                "it must be finite with start <= end",
            ));
        }
        self.solver.check()?;
        let Some(times) = &self.t_eval else {
            return Ok(());
        };
        if let Some(&t) = times.iter().find(|t| !(start..=end).contains(*t)) {
            return Err(Error::bad_value(
                "t_eval",
                t,
                format!("it must lie in the span [{start}, {end}]"),
            ));
        }
        if let Some(&[earlier, later]) = times
            .windows(2)
            .find(|w| w[1] < w[0])
            .and_then(|w| w.first_chunk())
        {
            return Err(Error::bad_value(
                "t_eval",
                format!("{later} after {earlier}"),
                "times must ascend",
            ));
        }
        Ok(())
    }
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// At the end of the span.
    Finished,
    /// After `max_impacts`.
    MaxImpacts,
    /// Where the steps of an integrator became too short for the time.
    StepUnderflow,
    /// Where a ramp put a stop onto the motion.
    InsideStop,
    /// At a contact that no rule resolves: no step is short enough to tell it from none, or stops go on to strike each other.
    UnresolvedContact,
    /// Where a search for contacts could not be certified.
    Uncertain,
}

impl Status {
    /// The status of a name.
    pub(crate) fn from_name(name: &str) -> Result<Self> {
        [
            Self::Finished,
            Self::MaxImpacts,
            Self::StepUnderflow,
            Self::InsideStop,
            Self::UnresolvedContact,
            Self::Uncertain,
        ]
        .into_iter()
        .find(|s| s.name() == name)
        .ok_or_else(|| Error::bad_value("status", name, "there is no such status"))
    }

    /// The name used in Python.
    pub fn name(self) -> &'static str {
        match self {
            Self::Finished => "finished",
            Self::MaxImpacts => "max_impacts",
            Self::StepUnderflow => "step_underflow",
            Self::InsideStop => "inside_stop",
            Self::UnresolvedContact => "unresolved_contact",
            Self::Uncertain => "uncertain",
        }
    }
}

/// What a run did, counted, and its absolute tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stats {
    /// Evaluations of the right-hand side; none in exact flights.
    pub n_rhs: usize,
    /// Steps of an integrator; none in exact flights.
    pub n_steps: usize,
    /// Evaluations of a gap with its derivatives.
    pub n_gap_evaluations: usize,
    /// Flights.
    pub n_flights: usize,
    /// Impacts.
    pub n_impacts: usize,
    /// Contacts with stops that give way which began.
    pub n_contacts: usize,
    /// The absolute tolerance that the run had, the smallest of its gaps, and of its coordinates where steps were taken; the smallest of all
    /// parts of a run under ramps. Zero where there is nothing that has one, NaN of a file that does not know.
    pub atol: f64,
}

impl Stats {
    /// The sum of two.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            n_rhs: self.n_rhs + other.n_rhs,
            n_steps: self.n_steps + other.n_steps,
            n_gap_evaluations: self.n_gap_evaluations + other.n_gap_evaluations,
            n_flights: self.n_flights + other.n_flights,
            n_impacts: self.n_impacts + other.n_impacts,
            n_contacts: self.n_contacts + other.n_contacts,
            atol: if self.atol > 0.0 {
                self.atol.min(other.atol)
            } else {
                other.atol
            },
        }
    }

    /// Adds the counts of a flow.
    pub(crate) fn with(self, counts: Counts) -> Self {
        Self {
            n_rhs: counts.rhs,
            n_steps: counts.steps,
            n_gap_evaluations: counts.gap_evaluations,
            atol: counts.atol,
            ..self
        }
    }
}
