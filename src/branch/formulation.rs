//! What is asked of the formulation of a branch (theory 19): the unknowns of its loops, the equations that these close by, how a loop is
//! moved, and what its multipliers are. Each has its answers in one file: `shooting.rs`, `impulses.rs` and `energy_level.rs`, which adds an
//! equation and an unknown to shooting.

use crate::branch::energy_level::derivative_by_energy;
use crate::branch::equations::{Equations, ParameterDerivative};
use crate::branch::multipliers::{n_outside, off_circle, own_multipliers, pair_at_circle};
use crate::branch::parametric_loop::{BranchDirection, ParametricLoop};
use crate::branch::problem::{BranchProblem, Formulation};
use crate::error::Result;
use crate::orbit::{PeriodicOrbit, Pulses, ShootingState};
use crate::tolerance::MEETING;
use nalgebra::{Complex, DMatrix};

impl Formulation<'_> {
    /// That of a loop of another itinerary or scene: where impulses do not determine the motion, it is shooting.
    pub fn of_loop(self, place: &ParametricLoop) -> Self {
        match self {
            Self::Impulses if place.impulses.is_none() => Self::Shooting,
            own => own,
        }
    }

    /// Whether its motions keep their energy.
    pub fn keeps_energy(self) -> bool {
        matches!(self, Self::EnergyLevel(_))
    }

    /// Whether a loop may close with its mirror image.
    pub fn has_images(self) -> bool {
        !matches!(self, Self::Impulses)
    }

    /// Whether multipliers are counted, and not known one by one.
    pub fn counts_multipliers(self) -> bool {
        matches!(self, Self::Impulses)
    }

    /// How many unknowns come after the times of a loop.
    pub fn n_after_times(self) -> usize {
        usize::from(self.keeps_energy())
    }

    /// What an orbit is from which several directions lead on, and the rule that it breaks.
    pub fn several_directions(self, is_free: bool) -> (&'static str, &'static str) {
        match self {
            Self::EnergyLevel(_) => (
                "one of a family at this value",
                "at one energy there are several: another family is crossed, or the scene can be shifted",
            ),
            _ if is_free => (
                "one of a family at this value",
                "elastic impacts without damping leave one at each energy: continue in \"energy\" or add damping",
            ),
            _ => (
                "one at which branches cross",
                "it must be one beside it, or one of the special point's branches",
            ),
        }
    }
}

impl BranchProblem<'_> {
    /// The equations of a loop, without the column of the parameter.
    pub fn closing_equations(&self, place: &ParametricLoop) -> Result<Equations> {
        let scene = self.scene(place.value)?;
        match self.formulation {
            Formulation::Shooting => self.shooting_equations(place, scene),
            Formulation::Impulses => Ok(self.impulse_equations(place, scene)),
            Formulation::EnergyLevel(energetics) => {
                let flights = self.shooting_equations(place, scene)?;
                self.on_energy_level(place, flights, energetics)
            }
        }
    }

    /// The derivatives by the parameter at a loop.
    pub fn by_value(
        &self,
        place: &ParametricLoop,
        equations: &Equations,
    ) -> Result<ParameterDerivative> {
        match self.formulation {
            Formulation::Shooting => self.shooting_by_value(place, equations),
            Formulation::Impulses => self.impulses_by_value(place, &equations.scene),
            Formulation::EnergyLevel(_) => Ok(derivative_by_energy(equations)),
        }
    }

    /// A loop corrected along a direction, to first order: its flights are joined.
    pub fn moved(
        &self,
        place: &ParametricLoop,
        equations: &Equations,
        by: &BranchDirection,
    ) -> Result<ParametricLoop> {
        match self.formulation {
            Formulation::Impulses => self.moved_impulses(place, &equations.scene, by),
            _ => self.joined_flights((place, equations, by)),
        }
    }

    /// The orbit of a closed loop.
    ///
    /// # Errors
    /// For a loop of half a period, a scene that is no longer odd; what the motion reports.
    pub fn orbit(&self, place: &ParametricLoop) -> Result<PeriodicOrbit> {
        match self.formulation {
            Formulation::Impulses => self.orbit_of_impulses(place),
            _ => self.orbit_of_flights(place),
        }
    }

    /// The speeds of approach at all instants; NaN where nothing is hit.
    pub fn approaches(&self, place: &ParametricLoop) -> Result<Vec<f64>> {
        match self.formulation {
            Formulation::Impulses => {
                let (pulses, train) = place.train();
                Ok(pulses.approaches(&train))
            }
            _ => self.approaches_of_flights(place),
        }
    }

    /// The equations of a deviation that comes back multiplied by a number: singular where that is a multiplier. Those at the loop are
    /// taken where they are known.
    pub fn variational(
        &self,
        (place, equations): (&ParametricLoop, Option<&Equations>),
        multiplier: f64,
    ) -> Result<DMatrix<f64>> {
        match (self.formulation, equations) {
            (Formulation::Impulses, _) => Ok(self.impulse_variational(place, multiplier)),
            (_, Some(known)) => Ok(known.flights().returning(multiplier)),
            (_, None) => Ok(self.linearised(place)?.returning(multiplier)),
        }
    }

    /// The eigenvector of a multiplier, as deviations of all states and times.
    pub fn deviation(&self, place: &ParametricLoop, multiplier: f64) -> Result<ShootingState> {
        match self.formulation {
            Formulation::Impulses => self.impulse_deviation(place, multiplier),
            _ => self.flight_deviation(place, multiplier),
        }
    }

    /// The test function of doublings: it changes its sign where a multiplier passes through -1.
    pub fn doubling_test(&self, place: &ParametricLoop, equations: &Equations) -> Result<f64> {
        match self.formulation {
            // The multipliers of one coordinate that keeps its energy are both 1.
            Formulation::EnergyLevel(_) if equations.scene.n_dof() == 1 => Ok(1.0),
            _ => self.multiplier_test((place, Some(equations)), -1.0),
        }
    }

    /// How many multipliers of a loop and its orbit lie outside the unit circle; `None` where that is not decided, and where the energy is
    /// kept, as no torus is looked for there.
    pub fn n_outside(
        &self,
        place: &ParametricLoop,
        orbit: &PeriodicOrbit,
    ) -> Result<Option<usize>> {
        match self.formulation {
            Formulation::Shooting => n_outside(orbit, false),
            Formulation::Impulses => Ok(self.n_outside_of_impulses(place)),
            Formulation::EnergyLevel(_) => Ok(None),
        }
    }

    /// The multipliers of an orbit one by one; `None` where they are counted alone, or the return map has no derivative.
    pub fn multipliers(&self, orbit: &PeriodicOrbit) -> Result<Option<Vec<Complex<f64>>>> {
        if self.formulation.counts_multipliers() {
            return Ok(None);
        }
        own_multipliers(orbit)
    }

    /// How many multipliers of an orbit at a value lie outside the circle by more than those that cross it there, where they are counted
    /// alone; `None` where that is not decided.
    pub fn n_well_outside(&self, orbit: &PeriodicOrbit, value: f64) -> Result<Option<usize>> {
        match self.formulation {
            Formulation::Impulses => self.impulses_at(orbit, value, |pulses, train, units| {
                pulses.n_outside(train, units, MEETING)
            }),
            _ => Ok(None),
        }
    }

    /// How far the pair of multipliers nearest to the unit circle is from it, and how many are outside, of a loop and, where it is known,
    /// its orbit. Multipliers that are counted are all as far.
    pub fn off_circle(
        &self,
        place: &ParametricLoop,
        orbit: Option<&PeriodicOrbit>,
    ) -> Result<(f64, Option<usize>)> {
        match (self.formulation, orbit) {
            (Formulation::Impulses, _) => Ok((1.0, self.n_outside_of_impulses(place))),
            (_, Some(orbit)) => off_circle(orbit),
            (_, None) => off_circle(&self.orbit(place)?),
        }
    }

    /// The multiplier on the upper half plane of the pair at the unit circle, of an orbit at a value.
    pub fn pair_at_circle(
        &self,
        orbit: &PeriodicOrbit,
        value: f64,
    ) -> Result<Option<Complex<f64>>> {
        match self.formulation {
            Formulation::Impulses => self.impulses_at(orbit, value, Pulses::on_circle),
            _ => Ok(pair_at_circle(&own_multipliers(orbit)?.unwrap_or_default())),
        }
    }
}
