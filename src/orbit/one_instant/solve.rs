//! Orbits with one instant of impact, or none (theory 5): from a problem to its solutions.

use crate::error::Result;
use crate::flow::ModalScene;
use crate::impact::wrapped;
use crate::law::Stage;
use crate::model::Moment;
use crate::orbit::one_instant::contact_phases;
use crate::orbit::one_instant::one_stop;
use crate::orbit::one_instant::periodic_conditions::{PeriodicConditions, Rows};
use crate::orbit::one_instant::phases::{PhaseSolutions, meet_circle};
use crate::orbit::one_instant::refine::settle_speeds;
use crate::orbit::orbit_data::{OrbitArc, OrbitData};
use crate::orbit::problem::Problem;
use crate::orbit::solutions::Solutions;
use crate::tolerance::SOLVABLE;
use nalgebra::{DMatrix, DVector};

/// A periodic motion as the solver finds it: its phase, its one flight, its impulses.
pub(crate) struct Solution {
    /// The forcing phase at the instant \[rad\], in [0, 2 pi).
    pub phase: f64,
    pub flight: OrbitArc,
    /// In the order of the stops hit, shape (stops hit,), [N s].
    pub impulses: DVector<f64>,
}

impl Solution {
    /// The motion that X describes, over the period.
    pub fn new(conditions: &PeriodicConditions<'_>, x: &DVector<f64>, period: f64) -> Result<Self> {
        let u = conditions.phase_part(x);
        let impulses = conditions.impulse_part(x);
        let mut after = conditions.state_after(x, 1.0);
        settle_speeds(
            conditions.scene,
            (conditions.stops, &conditions.receding(u[1].atan2(u[0]))),
            impulses.as_slice(),
            &mut after,
        )?;
        let before_next = conditions.state_before(&after, &impulses);
        Ok(Self {
            phase: wrapped(u[1].atan2(u[0])),
            flight: OrbitArc::over(
                Stage::impact(conditions.stops),
                [0.0, period],
                [after, before_next],
            ),
            impulses,
        })
    }
}

/// The solutions for a given phase: one, none, or a family.
pub(crate) fn phase_given(
    conditions: &PeriodicConditions<'_>,
    phase: f64,
) -> Result<PhaseSolutions> {
    let set = conditions.at_phase([phase.cos(), phase.sin()])?;
    let is_solvable = set.residual <= SOLVABLE;
    Ok(PhaseSolutions {
        points: if is_solvable {
            vec![set.particular]
        } else {
            Vec::new()
        },
        margin: None,
        basis: set.null_space,
        is_any_phase: false,
    })
}

/// The solutions for given clearances.
pub(crate) fn clearance_given(conditions: &PeriodicConditions<'_>) -> Result<PhaseSolutions> {
    if let Some(phases) = one_stop::clearance_given(conditions) {
        return Ok(phases);
    }
    let rows = conditions.rows_at_clearance(None)?;
    let mut phases = if conditions.n_phases() > 2 {
        contact_phases::clearance_given(conditions)?
    } else {
        meet_contacts(conditions, &rows)?
    };
    if phases.basis.ncols() == 0 && !phases.is_any_phase {
        for x in &mut phases.points {
            conditions.refine(rows.clone(), x)?;
        }
    }
    Ok(phases)
}

/// The margin of [`clearance_given`] alone.
pub(crate) fn clearance_margin(conditions: &PeriodicConditions<'_>) -> Result<Option<f64>> {
    let phases = match one_stop::clearance_given(conditions) {
        Some(phases) => phases,
        None => meet_contacts(conditions, &conditions.rows_at_clearance(None)?)?,
    };
    Ok(phases.margin)
}

fn meet_contacts(conditions: &PeriodicConditions<'_>, rows: &Rows) -> Result<PhaseSolutions> {
    meet_circle(&conditions.solve_contacts(rows)?, |x| {
        conditions.phase_part(x)
    })
}

/// Motions without impacts.
pub(crate) fn without_impacts(problem: &Problem<'_>) -> Result<Solutions> {
    let given = problem.options.phase;
    let phase = given.unwrap_or_else(|| problem.scene.phase());
    let conditions = PeriodicConditions::new(&problem.modal, &[], problem.period);
    let phases = phase_given(&conditions, phase)?;
    let reason = match (phases.points.is_empty(), phases.basis.ncols()) {
        (true, _) => {
            "no motion repeats: an undamped mode is in resonance with the forcing, or a load has nothing to rest on"
        }
        (false, 0) => "the steady response",
        (false, _) => "a free motion that repeats can be added to the steady response",
    };
    solutions(problem, &conditions, &phases, reason.to_owned())
}

/// Orbits for a given phase at the impact; the clearances come out.
pub(crate) fn at_phase(problem: &Problem<'_>, phase: f64) -> Result<Solutions> {
    let conditions = PeriodicConditions::new(&problem.modal, problem.stops(), problem.period);
    let phases = phase_given(&conditions, phase)?;
    let none = "I - R e^(AT) is singular and the forcing is not in its range";
    let reason = describe(&phases, none);
    Ok(solutions(problem, &conditions, &phases, reason)?.at_contacts(&conditions))
}

/// Orbits for the clearances of the scene.
pub(crate) fn at_clearance(problem: &Problem<'_>) -> Result<Solutions> {
    let stops = problem.stops();
    let conditions = PeriodicConditions::new(&problem.modal, stops, problem.period);
    let phases = clearance_given(&conditions)?;
    let none = if stops.len() > 1 {
        "the stops hit together ask for two phases at once, or more; free one parameter (free=\"clearance\")"
    } else {
        "the forcing is too weak for a contact at this clearance: no phase reaches it"
    };
    let reason = describe(&phases, none);
    solutions(problem, &conditions, &phases, reason)
}

/// Orbits that hit their stops together at clearances times one unknown factor (theory 5: kind 1).
pub(crate) fn at_scaled_clearance(problem: &Problem<'_>) -> Result<Solutions> {
    let conditions = PeriodicConditions::new(&problem.modal, problem.stops(), problem.period);
    let given = conditions.clearances();
    let direction = if given.amax() > 0.0 {
        given
    } else {
        given.map(|_| 1.0)
    };
    let phases = meet_circle(&conditions.at_clearance(Some(&direction))?, |x| {
        conditions.phase_part(x)
    })?;
    let none = "no common factor on the clearances lets the stops be hit together";
    let reason = describe(&phases, none);
    // The orbits' own contact positions are the clearances.
    Ok(solutions(problem, &conditions, &phases, reason)?.at_contacts(&conditions))
}

impl Solutions {
    /// The same solutions with the stops hit standing where the contacts are.
    fn at_contacts(mut self, conditions: &PeriodicConditions<'_>) -> Self {
        for parts in &mut self.all {
            let contacts = conditions.contacts(&parts.flights[0].after);
            let at = Moment::of_angle(parts.phase);
            let own = |stop: usize| conditions.scene.stop_motion(stop, at)[0];
            let stops = conditions.stops.iter().zip(contacts);
            let clearances = stops.map(|(&stop, contact)| (stop, contact - own(stop)));
            parts.clearances = clearances.collect();
        }
        self
    }
}

fn describe(phases: &PhaseSolutions, none: &str) -> String {
    if phases.points.is_empty() {
        none.to_owned()
    } else if phases.is_any_phase {
        "every phase has an orbit".to_owned()
    } else if phases.basis.ncols() > 0 {
        format!(
            "a family with {} parameters: the contact state may be moved along its basis",
            phases.basis.ncols()
        )
    } else {
        match phases.points.len() {
            1 => "one solution".to_owned(),
            n => format!("{n} solutions"),
        }
    }
}

/// The solutions at the phases found.
fn solutions(
    problem: &Problem<'_>,
    conditions: &PeriodicConditions<'_>,
    phases: &PhaseSolutions,
    reason: String,
) -> Result<Solutions> {
    let parts = |x: &DVector<f64>| -> Result<OrbitData> {
        let Solution {
            phase,
            flight,
            impulses,
        } = Solution::new(conditions, x, problem.period)?;
        Ok(OrbitData {
            pattern: problem.pattern.clone(),
            n_periods: problem.options.n_periods,
            phase,
            flights: vec![flight],
            impulses: impulses.as_slice().to_vec(),
            clearances: Vec::new(),
        })
    };
    let all = phases.points.iter().map(parts).collect::<Result<_>>()?;
    let basis = family_basis(&problem.modal, conditions, phases);
    Ok(Solutions {
        all,
        reason,
        margin: phases.margin,
        family: (basis.ncols() > 0 || phases.is_any_phase).then_some(basis),
    })
}

/// Null vectors as changes of the contact state (q, v).
fn family_basis(
    modal: &ModalScene,
    conditions: &PeriodicConditions<'_>,
    phases: &PhaseSolutions,
) -> DMatrix<f64> {
    let n = modal.form.n_dof();
    let columns: Vec<DVector<f64>> = phases
        .basis
        .column_iter()
        .map(|x| {
            let (q, v) = modal
                .form
                .to_physical(&conditions.state_after(&x.into_owned(), 0.0));
            DVector::from_iterator(2 * n, q.iter().chain(v.iter()).copied())
        })
        .collect();
    if columns.is_empty() {
        DMatrix::zeros(2 * n, 0)
    } else {
        DMatrix::from_columns(&columns)
    }
}
