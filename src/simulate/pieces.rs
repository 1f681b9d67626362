//! A run that is handed on in pieces while it goes on, so that a motion of any length takes the room of one.

use crate::error::Result;
use crate::hybrid::Graze;
use crate::impact::Impact;
use crate::path::{Evaluator, Path, PathParts};
use crate::simulate::event_loop::Ending;
use crate::simulate::options::{SimulateOptions, Status};
use crate::simulate::record::Record;
use crate::simulate::run::AnyRun;
use nalgebra::DVector;
use std::sync::Arc;

/// Impacts in a piece of a run. [work]
const IMPACTS_PER_PIECE: usize = 1024;

/// A piece of a run.
pub(crate) struct RunPiece {
    pub impacts: Vec<Impact>,
    pub grazes: Vec<Graze>,
    parts: PathParts,
    regimes: Vec<Arc<crate::flow::RegimeMotion>>,
    span: (f64, f64),
}

impl RunPiece {
    /// Its motion, that n coordinates make.
    pub fn path(&mut self, evaluator: Evaluator, n_dof: usize) -> Path {
        Path {
            evaluator: evaluator.with_regimes(&self.regimes),
            parts: std::mem::take(&mut self.parts),
            span: self.span,
            n_dof,
        }
    }
}

impl AnyRun<'_> {
    /// A run over a span that hands on its motion after a number of impacts, and, where `every` is given, after each such time, at which
    /// flights then end.
    pub fn in_pieces(
        &mut self,
        (q0, v0): (&DVector<f64>, &DVector<f64>),
        (start, end): (f64, f64),
        every: Option<f64>,
        take: &mut dyn FnMut(RunPiece) -> Result<()>,
    ) -> Result<Ending> {
        let mut record = self.new_record();
        let mut ending = self.begin((q0, v0, start), &mut record)?;
        let Self {
            events,
            options,
            n_dof,
            has_sides,
            flow,
        } = self;
        let mut from = start;
        let mut goal = 1;
        loop {
            let is_over = ending.is_some();
            let to = every.map_or(end, |every| end.min(start + every * f64::from(goal)));
            let ended = if let Some(ended) = ending.take() {
                ended
            } else {
                let some = SimulateOptions {
                    max_impacts: Some(events.n_met() + IMPACTS_PER_PIECE),
                    ..(*options).clone()
                };
                flow.go_on(events, to, &some, &mut record)?
            };
            let is_last = is_over
                || match ended.status {
                    Status::MaxImpacts => false,
                    Status::Finished => to >= end,
                    _ => true,
                };
            if is_last && ended.status != Status::Finished {
                flow.record_last(ended.time, &mut record)?;
            }
            let whole = std::mem::replace(&mut record, Record::new(options, (*n_dof, *has_sides)));
            let whole = whole.finish();
            take(RunPiece {
                impacts: whole.impacts,
                grazes: whole.grazes,
                parts: whole.kept.unwrap_or_default(),
                regimes: flow.told().2,
                span: (from, ended.time),
            })?;
            if is_last {
                return Ok(ended);
            }
            from = ended.time;
            if ended.status == Status::Finished {
                goal += 1;
                ending = flow.go_past(events, from, &mut record)?;
            }
        }
    }
}
