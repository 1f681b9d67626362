//! Runs of one pendulum abreast: each goes its own way, in steps of its own, but their Taylor series are made together.

use crate::error::{Failure, Result};
use crate::flow::runge_kutta::State;
use crate::flow::{PendulumSeries, SeriesOf};
use crate::model::Dynamics;
use crate::simulate::clock::Clock;
use crate::simulate::event_loop::Ending;
use crate::simulate::mover::Mover;
use crate::simulate::record::Record;
use crate::simulate::run::{Done, Run};
use crate::simulate::stepping::{StepMover, Taylor};
use crate::watch::{GoOn, Watch};
use nalgebra::DVector;
use std::ops::ControlFlow;

/// Runs at a time: what fills the widest registers of most processors.
const ABREAST: usize = 4;

/// One of the runs.
struct Runner<'a, S, D> {
    run: Run<'a, StepMover<'a, S, D, Taylor>>,
    record: Record,
    /// The number of the run; none where there is none left to do.
    item: Option<usize>,
    /// Where the flight under way is to end.
    goal: Option<Clock>,
}

/// Runs abreast, with their buffers.
pub(crate) struct Abreast<'a, S, D> {
    runners: [Runner<'a, S, D>; ABREAST],
    series: SeriesOf<ABREAST>,
    t_span: (f64, f64),
}

impl<'a, S: State, D: Dynamics> Abreast<'a, S, D> {
    /// Runs over a span, made one by one.
    pub fn new(
        make: impl Fn() -> Run<'a, StepMover<'a, S, D, Taylor>>,
        t_span: (f64, f64),
    ) -> Self {
        let runners = std::array::from_fn(|_| Runner::new(make()));
        let series = SeriesOf::new(runners[0].run.n_dof);
        Self {
            runners,
            series,
            t_span,
        }
    }

    /// Runs each item from its start, and puts down what it leaves behind.
    ///
    /// # Errors
    /// As a run by itself, with the number of the item.
    pub fn run(
        &mut self,
        mut items: impl Iterator<Item = usize>,
        start: impl Fn(usize) -> (DVector<f64>, DVector<f64>),
        go_on: GoOn<'_>,
        put: &mut dyn FnMut(usize, Done),
    ) -> std::result::Result<(), Failure> {
        for runner in &mut self.runners {
            runner.item = None;
        }
        let work = self.runners[0].run.mover.work();
        let mut watch = Watch::new(go_on);
        loop {
            for runner in &mut self.runners {
                while runner.item.is_none()
                    && let Some(item) = items.next()
                {
                    runner.item = Some(item);
                    let ended = runner.begin(&start(item), self.t_span.0);
                    runner.put_down(ended, put)?;
                }
            }
            if self.runners.iter().all(|runner| runner.item.is_none()) {
                return Ok(());
            }
            self.expand()?;
            for runner in &mut self.runners {
                if let Some(item) = runner.item {
                    watch.work(work).map_err(|error| (item, error))?;
                    let ended = runner.step(self.t_span.1, &mut watch);
                    runner.put_down(ended, put)?;
                }
            }
        }
    }

    /// Makes the series of all runs in free flight.
    fn expand(&mut self) -> std::result::Result<(), Failure> {
        let mut all = [const { None }; ABREAST];
        for (series, runner) in all.iter_mut().zip(&mut self.runners) {
            if let Some(item) = runner.item
                && runner.run.mover.is_free()
            {
                let begun = runner.run.mover.begin_series();
                *series = Some(begun.map_err(|error| (item, error))?);
            }
        }
        PendulumSeries::expand_abreast(&mut self.series, all);
        Ok(())
    }
}

impl<'a, S: State, D: Dynamics> Runner<'a, S, D> {
    fn new(run: Run<'a, StepMover<'a, S, D, Taylor>>) -> Self {
        Self {
            record: Record::new(run.options, run.n_dof),
            run,
            item: None,
            goal: None,
        }
    }

    /// Makes ready for a run; its end, if it cannot begin.
    fn begin(
        &mut self,
        (q0, v0): &(DVector<f64>, DVector<f64>),
        t0: f64,
    ) -> Result<Option<Ending>> {
        let Run {
            mover,
            events,
            options,
            n_dof,
        } = &mut self.run;
        self.record = Record::new(options, *n_dof);
        self.goal = None;
        mover.start(q0, v0, t0);
        events.start(mover, t0, &mut self.record)
    }

    /// A step of a free flight, or all of one with stops held; the end of the run, if it is that.
    fn step(&mut self, t_end: f64, watch: &mut Watch<'_>) -> Result<Option<Ending>> {
        let Run {
            mover,
            events,
            options,
            ..
        } = &mut self.run;
        let record = &mut self.record;
        let arrival = if let Some(goal) = self.goal {
            mover.step_on(None, (goal, t_end), record)?
        } else {
            let end = mover.clock().at(t_end);
            // The watch has been asked for each step.
            match events.depart(mover, end, options, &mut |_| ControlFlow::Continue(()))? {
                ControlFlow::Break(ending) => return Ok(Some(ending)),
                ControlFlow::Continue(span) if mover.is_free() => {
                    let goal = mover.clock().after(span);
                    self.goal = Some(goal);
                    mover.step_on(Some(&events.starts), (goal, t_end), record)?
                }
                ControlFlow::Continue(span) => {
                    let mut check = || watch.look().is_ok();
                    Some(mover.fly(&events.starts, span, t_end, record, &mut check)?)
                }
            }
        };
        let Some(arrival) = arrival else {
            return Ok(None);
        };
        self.goal = None;
        events.arrive(mover, arrival, t_end, record)
    }

    /// Puts down what the run leaves behind, if it has ended.
    fn put_down(
        &mut self,
        ended: Result<Option<Ending>>,
        put: &mut dyn FnMut(usize, Done),
    ) -> std::result::Result<(), Failure> {
        let item = self.item.unwrap_or_default();
        let Some(ending) = ended.map_err(|error| (item, error))? else {
            return Ok(());
        };
        let record = Record::new(self.run.options, self.run.n_dof);
        let record = std::mem::replace(&mut self.record, record);
        let done = self
            .run
            .finish(ending, record)
            .map_err(|error| (item, error))?;
        self.item = None;
        put(item, done);
        Ok(())
    }
}
