//! Facts of a run in Python: its counts and its energy ledger.

use crate::error::digits;
use crate::python::argument;
use crate::python::array::vector;
use crate::python::record::plain_class;
use crate::quantity::finite_vector;
use crate::simulate::{Energy, Stats};
use pyo3::prelude::*;

/// What a run did, counted, and its absolute tolerance.
#[pyclass(name = "Stats", module = "vibroimpact", frozen)]
pub(crate) struct PyStats(pub Stats);

plain_class! { PyStats |own| {
    /// Evaluations of the right-hand side; none in exact flights.
    n_rhs: own.n_rhs,
    /// Steps of an integrator; none in exact flights.
    n_steps: own.n_steps,
    /// Evaluations of a gap with its derivatives.
    n_gap_evaluations: own.n_gap_evaluations,
    /// Flights.
    n_flights: own.n_flights,
    /// Impacts.
    n_impacts: own.n_impacts,
    /// Absolute tolerance that the run had [length]: the smallest of its gaps, and of its coordinates where steps were taken; under ramps the smallest
    /// of all parts. Zero where nothing has one, nan of a file that does not know.
    atol: own.atol,
    /// Contacts with stops that give way which began.
    n_contacts: own.n_contacts,
}

    #[new]
    #[pyo3(signature = (n_rhs, n_steps, n_gap_evaluations, n_flights, n_impacts, atol=f64::NAN, n_contacts=None))]
    fn new(
        n_rhs: &Bound<'_, PyAny>,
        n_steps: &Bound<'_, PyAny>,
        n_gap_evaluations: &Bound<'_, PyAny>,
        n_flights: &Bound<'_, PyAny>,
        n_impacts: &Bound<'_, PyAny>,
        atol: f64,
        n_contacts: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        Ok(Self(Stats {
            n_rhs: argument::saved("n_rhs", n_rhs)?,
            n_steps: argument::saved("n_steps", n_steps)?,
            n_gap_evaluations: argument::saved("n_gap_evaluations", n_gap_evaluations)?,
            n_flights: argument::saved("n_flights", n_flights)?,
            n_impacts: argument::saved("n_impacts", n_impacts)?,
            n_contacts: n_contacts.map_or(Ok(0), |own| argument::saved("n_contacts", own))?,
            atol,
        }))
    }

    fn __repr__(&self) -> String {
        let s = self.0;
        let contacts = match s.n_contacts {
            0 => String::new(),
            count => format!(", n_contacts={count}"),
        };
        format!(
            "Stats(n_rhs={}, n_steps={}, n_gap_evaluations={}, n_flights={}, n_impacts={}, atol={:e}{contacts})",
            s.n_rhs, s.n_steps, s.n_gap_evaluations, s.n_flights, s.n_impacts, s.atol
        )
    }
}

/// Energies along a motion, one entry for each of the times t.
/// They are those of a trajectory, or of one period of an orbit; arrays of shape (m,).
///
/// ``balance`` is what does not add up: kinetic + potential - forcing_work + damping_loss + impact_loss + contact_loss, less its
/// value at the start; zero but for the tolerance of the integration.
#[pyclass(name = "Energy", module = "vibroimpact", frozen)]
pub(crate) struct PyEnergy(pub Energy);

plain_class! { PyEnergy |own| {
    /// The times [s], shape (m,).
    t: &own.time,
    /// Kinetic energy [J], shape (m,).
    kinetic: &own.kinetic,
    /// Potential energy [J], shape (m,), zero at q = 0.
    potential: &own.potential,
    /// Work of the forcing since the start [J], shape (m,).
    forcing_work: &own.forcing_work,
    /// Loss in dampers since the start [J], shape (m,).
    damping_loss: &own.damping_loss,
    /// Loss at impacts since the start [J], shape (m,), chatter included; for a reaction that is not that of inertia also what lasting
    /// contact takes.
    impact_loss: &own.impact_loss,
    /// What does not add up [J], zero at the start, shape (m,).
    balance: &own.balance,
    /// Loss in contacts with stops that give way since the start [J], shape (m,): in their dashpots, and what a stop that is left still
    /// has stored.
    contact_loss: &own.contact_loss,
}

    #[new]
    #[pyo3(signature = (t, kinetic, potential, forcing_work, damping_loss, impact_loss, balance, contact_loss=None))]
    fn new(
        t: &Bound<'_, PyAny>,
        kinetic: &Bound<'_, PyAny>,
        potential: &Bound<'_, PyAny>,
        forcing_work: &Bound<'_, PyAny>,
        damping_loss: &Bound<'_, PyAny>,
        impact_loss: &Bound<'_, PyAny>,
        balance: &Bound<'_, PyAny>,
        contact_loss: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let time = vector("t", t)?;
        let values = |name, value| -> PyResult<Vec<f64>> {
            let values = vector(name, value)?;
            finite_vector(name, &values, time.len())?;
            Ok(values.as_slice().to_vec())
        };
        Ok(Self(Energy {
            kinetic: values("kinetic", kinetic)?,
            potential: values("potential", potential)?,
            forcing_work: values("forcing_work", forcing_work)?,
            damping_loss: values("damping_loss", damping_loss)?,
            impact_loss: values("impact_loss", impact_loss)?,
            balance: values("balance", balance)?,
            contact_loss: match contact_loss {
                Some(own) => values("contact_loss", own)?,
                None => vec![0.0; time.len()],
            },
            time: time.as_slice().to_vec(),
        }))
    }

    fn __repr__(&self) -> String {
        let worst = self.0.balance.iter().fold(0.0f64, |a, x| a.max(x.abs()));
        format!(
            "Energy({} times, balance within {})",
            self.0.balance.len(),
            digits(worst)
        )
    }
}
