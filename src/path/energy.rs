//! The energy ledger of a motion that is kept (theory 9): what is stored, what the forcing brought, what dampers and impacts took.
//! The powers are integrated along the motion that was kept, by Gauss's rule on each arc.

use crate::error::Result;
use crate::law::Regime;
use crate::model::{Energetics, Moment, PhysicalState, Scene};
use crate::observer::Observer;
use crate::path::equations::PathEquations;
use crate::path::fading::Fading;
use crate::path::parts::PathPoint;
use crate::path::path::Path;
use crate::path::quadrature::{QuadratureNode, each_node};
use nalgebra::DVector;

/// Energies along a motion, one entry for each of the times t.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Energy {
    /// The times, shape `(m,)`, \[s\]: those of a trajectory's samples; one period of an orbit, both sides of each impact.
    pub time: Vec<f64>,
    /// Kinetic energy, shape `(m,)`, \[J\].
    pub kinetic: Vec<f64>,
    /// Potential energy, shape `(m,)`, \[J\], zero at q = 0, with what stops that give way have stored.
    pub potential: Vec<f64>,
    /// Work of the forcing, and of stops that move, or whose numbers a ramp changes in levels, since the start, shape `(m,)`, \[J\].
    pub forcing_work: Vec<f64>,
    /// Loss in dampers since the start, shape `(m,)`, \[J\]. Of a system given by functions: what its forces took beyond the potential, those
    /// of dampers and any others; negative where they brought energy, as a drive written into the acceleration does.
    pub damping_loss: Vec<f64>,
    /// Loss at impacts since the start, shape `(m,)`, \[J\], chatter included; for a reaction that is not that of inertia also what lasting
    /// contact takes.
    pub impact_loss: Vec<f64>,
    /// Loss in contacts with stops that give way since the start, shape `(m,)`, \[J\]: in their dashpots, and what a stop that is left still
    /// has stored.
    pub contact_loss: Vec<f64>,
    /// The error of the balance, shape `(m,)`, \[J\]: `kinetic + potential - forcing_work + damping_loss + impact_loss + contact_loss` less its value at the
    /// start. Of a system given by functions it checks the motion and the quadrature alone: a mass or potential that is not that of the
    /// acceleration shows as `damping_loss`.
    pub balance: Vec<f64>,
}

impl Energy {
    /// Goes on with what follows, from the works up to the last row, which gives way to it; what stops have stored more there than before has
    /// been brought by what changed their numbers.
    pub(crate) fn go_on(&mut self, mut next: Self, brought: f64) {
        if brought != 0.0 {
            next.forcing_work
                .iter_mut()
                .for_each(|work| *work += brought);
        }
        let add = |all: &mut Vec<f64>, next: Vec<f64>, is_sum: bool| {
            // Minus zero leaves every number as it is.
            let before = all.pop().filter(|_| is_sum).unwrap_or(-0.0);
            all.extend(next.into_iter().map(|x| before + x));
        };
        add(&mut self.time, next.time, false);
        add(&mut self.kinetic, next.kinetic, false);
        add(&mut self.potential, next.potential, false);
        add(&mut self.forcing_work, next.forcing_work, true);
        add(&mut self.damping_loss, next.damping_loss, true);
        add(&mut self.impact_loss, next.impact_loss, true);
        add(&mut self.contact_loss, next.contact_loss, true);
        add(&mut self.balance, next.balance, true);
    }
}

/// Works up to some point of the motion.
#[derive(Debug, Clone, Copy, Default)]
struct Works {
    forcing: f64,
    damping: f64,
    impact: f64,
    /// By stops that give way, with what they have stored.
    contact: f64,
}

/// Powers of the contact forces.
#[derive(Debug, Clone, Copy, Default)]
struct ContactPowers {
    /// Taken by stops that are held: nothing where reactions are those of inertia and the stops rest.
    held: f64,
    /// Taken by those that give way.
    compliant: f64,
    /// Given by the motions of stops, `-sum L c'`.
    by_stops: f64,
}

/// The energy ledger at some points of a path of a scene, with what stops have stored at the first and at the last one.
///
/// # Errors
/// A system given by functions without its mass matrix or its potential; `Error::Interrupted` from the observer.
pub(crate) fn energy_along(
    path: &Path,
    scene: &Scene,
    points: &[PathPoint],
    observer: &mut Observer,
) -> Result<(Energy, [f64; 2])> {
    Ledger::new(path, scene)?.fill(points, observer)
}

struct Ledger<'a> {
    path: &'a Path,
    equations: PathEquations<'a>,
    energetics: Energetics,
    fading: Fading<'a>,
    /// Work of one evaluation, in the units of an observer.
    work: usize,
}

impl<'a> Ledger<'a> {
    fn new(path: &'a Path, scene: &'a Scene) -> Result<Self> {
        Ok(Self {
            path,
            energetics: Energetics::new(scene)?,
            equations: PathEquations::new(path, scene),
            fading: Fading::new(&path.evaluator),
            work: 8 * scene.n_dof(),
        })
    }

    fn fill(&self, points: &[PathPoint], observer: &mut Observer) -> Result<(Energy, [f64; 2])> {
        let mut energy = Energy::default();
        let (mut works, mut arc, mut local) = (Works::default(), 0, 0.0);
        let (mut start, mut stored_first, mut stored_last) = (None, None, 0.0);
        for point in points {
            while arc < point.arc {
                let span = self.path.arc(arc).span;
                self.integrate(arc, (local, span), &mut works, observer)?;
                let before = self.path.state_in(arc, span);
                let after = self.path.state_in(arc + 1, 0.0);
                let at = self.equations.moment(arc + 1, 0.0);
                let by_stops = self.work_at_jump(at, &before, &after)?;
                works.forcing += by_stops;
                works.impact += self.jump_loss(&before, &after)? + by_stops;
                (arc, local) = (arc + 1, 0.0);
            }
            self.integrate(arc, (local, point.local), &mut works, observer)?;
            local = point.local;
            let (q, v) = self.path.state_in(arc, local);
            let (kinetic, potential) = (
                self.energetics.kinetic(&q, &v)?,
                self.energetics.potential(&q)?,
            );
            let stored = self.equations.stored(*point, &q)?;
            let at_start = *stored_first.get_or_insert(stored);
            stored_last = stored;
            let lost = works.impact + works.contact;
            let sum = kinetic + potential - works.forcing + works.damping + lost;
            energy.time.push(point.time);
            energy.kinetic.push(kinetic);
            energy.potential.push(potential + stored);
            energy.forcing_work.push(works.forcing);
            energy.damping_loss.push(works.damping);
            energy.impact_loss.push(works.impact);
            energy.contact_loss.push(works.contact + at_start - stored);
            energy.balance.push(sum - *start.get_or_insert(sum));
        }
        Ok((energy, [stored_first.unwrap_or_default(), stored_last]))
    }

    /// Kinetic energy lost between the end of a arc and the start of the next.
    fn jump_loss(&self, before: &PhysicalState, after: &PhysicalState) -> Result<f64> {
        let jump = &before.1 - &after.1;
        let mean = (&before.1 + &after.1) * 0.5;
        self.energetics.inertial_work(&after.0, &mean, &jump)
    }

    /// Adds the works along a part of a arc.
    fn integrate(
        &self,
        arc: usize,
        (from, to): (f64, f64),
        works: &mut Works,
        observer: &mut Observer,
    ) -> Result<()> {
        let regime = self.path.regime_of(arc);
        each_node(self.fading.of(regime), (from, to), |node| {
            observer.work(self.work)?;
            let QuadratureNode {
                at: s,
                weight: w,
                stretch,
            } = node;
            let (q, v) = self.path.state_in(arc, s);
            let at = self.equations.moment(arc, s);
            works.forcing += w * self.energetics.forcing_power(at, &q, &v);
            let free = || self.equations.free_acceleration(at, &q, &v);
            works.damping += w * (self.energetics).damping_power(at, (&q, &v), stretch, free)?;
            if !regime.is_free() {
                let powers = self.contact_powers(at, &q, &v, regime)?;
                works.forcing += w * powers.by_stops;
                works.impact += w * powers.held;
                works.contact += w * powers.compliant;
            }
            Ok(())
        })
    }

    /// The work of stops that move at an instant, `-sum p c'`: of impulses on those in contact that change the velocity so.
    fn work_at_jump(
        &self,
        at: Moment,
        before: &PhysicalState,
        after: &PhysicalState,
    ) -> Result<f64> {
        let equations = &self.equations;
        if !equations.has_stop_motion() || before.1 == after.1 {
            return Ok(0.0);
        }
        let closed = equations.closed_stops(at, &after.0)?;
        let impulses = equations.impulses(&closed, &after.0, &(&before.1 - &after.1))?;
        let works = closed.iter().zip(impulses.iter());
        Ok(works
            .map(|(&stop, p)| -p * equations.stop_speed(stop, at))
            .sum())
    }

    /// The powers of the contact forces.
    fn contact_powers(
        &self,
        at: Moment,
        q: &DVector<f64>,
        v: &DVector<f64>,
        regime: &Regime,
    ) -> Result<ContactPowers> {
        let equations = &self.equations;
        let (actual, forces) = equations.regime_acceleration(regime, at, q, v)?;
        let pushed = equations.free_acceleration(at, q, v)? - actual;
        let all = self.energetics.inertial_work(q, v, &pushed)?;
        let mut powers = ContactPowers::default();
        for (stop, force) in forces {
            let by_stop = -force * equations.stop_speed(stop, at);
            powers.by_stops += by_stop;
            if regime.is_pressed(stop) {
                powers.compliant += equations.taken(&self.energetics, (stop, force), at, (q, v))?;
            }
        }
        powers.held = all + powers.by_stops - powers.compliant;
        Ok(powers)
    }
}
