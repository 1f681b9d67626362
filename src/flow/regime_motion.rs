//! Lasting contact of a linear scene (theory 9): while stops are held, the motion is that of a smaller linear system, `q = q_c + Z y` with
//! `N^T Z = 0` \[m\], and the contact forces \[N\] are rows on its state like the gaps of the other stops.

use crate::error::{Error, Result};
use crate::flow::derivative::{LinearEquations, solve_columns};
use crate::flow::gap_row::Quantity;
use crate::flow::imposed_motion::ImposedMotion;
use crate::flow::linear::propagate;
use crate::flow::modal_scene::ModalScene;
use crate::flow::reduced_system::{
    Reduced, cleared, form_drive, form_load, in_modes, uncoupled, without_rounding,
};
use crate::flow::scene_flow::{SceneFlow, modal_flow, with_flow};
use crate::law::{Action, Guard, GuardKind, LinearForce, Regime};
use crate::linalg::rank;
use crate::modal::{Form, ModalForm, ModalState};
use crate::model::{LinearSystem, Moment, PhysicalState};
use crate::quantity::room_for;
use crate::tolerance::{CANCELLED, DEPENDENT};
use nalgebra::{Complex, DMatrix, DVector};
use std::sync::OnceLock;

const ZERO: Complex<f64> = Complex::new(0.0, 0.0);

/// The motion of a linear scene in a regime that is not free.
#[derive(Debug, Clone)]
pub(crate) struct RegimeMotion {
    pub regime: Regime,
    /// `q_c`, at which every held gap is zero, but for what stops that move add to it.
    anchor: DVector<f64>,
    /// The motion that stops held and moving impose; empty where all held are at rest.
    carried: ImposedMotion,
    /// Z, shape `(n, n - k)`, orthonormal columns.
    free: DMatrix<f64>,
    /// `B (N^T B)^+`, shape `(n, k)`: how the stops held move what they hold.
    shared: DMatrix<f64>,
    /// The projection of an acceleration onto those that the stops held allow, shape `(n, n)`.
    along: DMatrix<f64>,
    equations: OnceLock<LinearEquations>,
    form: ModalForm,
    pub flow: SceneFlow,
    /// The contact force of each stop held, in their order.
    pub forces: Vec<Quantity>,
    /// The guards that are gaps or approaches, but those that cannot change.
    gaps: Vec<(Guard, Quantity)>,
}

impl RegimeMotion {
    /// The motion in a regime.
    pub fn new(scene: &ModalScene, regime: &Regime) -> Result<Self> {
        let stops = regime.constrained();
        let (system, g) = (&scene.system, &scene.geometry);
        let n = system.n_dof();
        room_for("the motion while stops are held", 16 * n, n)?;
        let (normals, reactions) = g.columns(stops);
        let clearances = scene.mean_clearances(stops);
        let held = |matrix: &DMatrix<f64>, right: &DVector<f64>| {
            rank::solve(&matrix.transpose(), right, DEPENDENT * matrix.amax())
        };
        // Of a direction of length one, what is less than its rounding is nothing: along it a structure would look damped, or stiff.
        let clear = |x: f64| if x.abs() > f64::EPSILON { x } else { 0.0 };
        let (anchor, free) = if stops.is_empty() {
            (DVector::zeros(n), DMatrix::identity(n, n))
        } else {
            let constraint = held(&normals, &clearances)?;
            (constraint.particular, constraint.null_space.map(clear))
        };

        let (stiffness, damping, own) = over_mass(scene, regime)?;
        let drawn = &stiffness * &anchor;
        // A spring between coordinates that stand where it is at rest pulls at neither.
        let sizes = own.abs() + stiffness.abs() * anchor.abs();
        let load = without_rounding(&(own - drawn), &sizes);
        let (mut forces, mut directions) = free_accelerations(scene);
        let mut given = scene.drive();
        let carried = ImposedMotion::new(scene, stops, |c| {
            let moved = held(&normals, c)?.particular;
            Ok(moved)
        })?;
        carried.act(
            (&stiffness, &damping),
            &mut forces,
            &mut directions,
            &mut given,
        );
        // (N^T B)^+, which takes the gaps' free accelerations to the contact forces.
        let delassus = normals.tr_mul(&reactions);
        let tolerance = DEPENDENT * reactions.amax() * normals.amax();
        let inverse = uncoupled(rank::pseudo_inverse(&delassus, tolerance)?);
        // Where normals depend on each other, stops share their forces: they react along what these make of their reactions.
        let shared = &reactions * &inverse;
        let reduced = Reduced::new(system, &free, &shared)?;
        let form = reduced.form(&stiffness, &damping, &free)?;
        let drive = form_drive(&form, &reduced, given, (&forces, &directions));
        let flow = modal_flow(&form, form_load(&form, &reduced.apply(&load)), drive);

        let takes = inverse * normals.transpose();
        let row = |q: DVector<f64>, v: DVector<f64>| in_modes(&form, &q, &v);
        // What of a matrix the motion left over sees along a row.
        let seen = |m: &DMatrix<f64>, g: &DVector<f64>| {
            let sizes = free.abs().tr_mul(&m.abs().tr_mul(&g.abs()));
            without_rounding(&free.tr_mul(&m.tr_mul(g)), &sizes)
        };
        let forces = (0..stops.len())
            .map(|i| {
                let g = takes.row(i).transpose();
                let pull = |force: &DVector<Complex<f64>>| {
                    let pulled: Complex<f64> =
                        force.iter().zip(g.iter()).map(|(f, g)| f * *g).sum();
                    let pulls = force.iter().zip(g.iter()).map(|(f, g)| f.norm() * g.abs());
                    let amplitude = cleared(pulled.norm(), pulls.sum());
                    if amplitude > 0.0 { -pulled } else { ZERO }
                };
                let follow = |direction: &DVector<f64>| {
                    -cleared(g.dot(direction), g.abs().dot(&direction.abs()))
                };
                let size = g.abs().dot(&sizes);
                Quantity {
                    constant: cleared(g.dot(&load), size),
                    size,
                    row: row(seen(&stiffness, &g), seen(&damping, &g)),
                    forcing: forces.iter().map(pull).collect(),
                    signals: directions.iter().map(follow).collect(),
                }
            })
            .collect();
        Ok(Self {
            regime: regime.clone(),
            gaps: gap_guards(scene, regime, (&anchor, &free), &form, &carried),
            along: &free * &reduced.takes,
            shared,
            equations: OnceLock::new(),
            anchor,
            carried,
            free,
            form,
            flow,
            forces,
        })
    }

    /// The guards of the regime as quantities of the motion: the contact forces of what is held, and the gaps that can change.
    pub fn guards(&self) -> impl Iterator<Item = (Guard, &Quantity)> {
        let held = self.regime.constrained().iter();
        let forces = held.zip(&self.forces);
        let forces = forces.map(|(&element, force)| (Guard::force(element), force));
        forces.chain(self.gaps.iter().map(|(guard, gap)| (*guard, gap)))
    }

    /// The equations of the motion, made when first needed.
    pub fn equations(&self, system: &LinearSystem) -> &LinearEquations {
        let make = || LinearEquations::new(system, Some(&self.along));
        self.equations.get_or_init(make)
    }

    /// The part that stops held and moving impose of the derivative of the position of some order, from the second on.
    pub fn carried_derivative(
        &self,
        scene: &ModalScene,
        at: Moment,
        order: usize,
    ) -> Option<DVector<f64>> {
        if scene.excitation.stops.is_empty() {
            return None;
        }
        let stops = self.regime.constrained();
        let own = stops.iter().map(|&stop| {
            let motion = scene.excitation.motion_of(stop);
            motion.map_or(0.0, |motion| motion.derivative(at, order).0)
        });
        let own = DVector::from_iterator(stops.len(), own);
        (own.amax() > 0.0).then(|| &self.shared * own)
    }

    /// How the motion uncouples.
    pub fn form(&self) -> &Form {
        &self.form.form
    }

    /// Position and velocity a time after others, from a moment.
    pub fn propagate(
        &self,
        at: Moment,
        span: f64,
        q: &DVector<f64>,
        v: &DVector<f64>,
    ) -> PhysicalState {
        let mut state = self.reduce(q, v, at);
        with_flow!(&self.flow, f => propagate(f, at, span, &mut state));
        self.lift(&state, at.after(span))
    }

    /// Propagates deviations of (q, v) over a span, after projecting them onto the smaller system.
    pub fn propagate_deviations(&self, span: f64, deviations: &mut DMatrix<f64>) {
        let (n, count) = (self.free.nrows(), deviations.ncols());
        let m = self.free.ncols();
        let mut seen = DMatrix::zeros(2 * m, count);
        for half in 0..2 {
            let part = self.free.tr_mul(&deviations.rows(half * n, n));
            seen.rows_mut(half * m, m).copy_from(&part);
        }
        if m > 0 {
            let (to_physical, to_modal) = self.form.transformation();
            let mut modal = to_modal * seen;
            self.form.propagate(span, &mut modal);
            seen = to_physical * modal;
        }
        for half in 0..2 {
            let part = &self.free * seen.rows(half * m, m);
            deviations.rows_mut(half * n, n).copy_from(&part);
        }
    }

    /// Whether the gap of an element cannot change.
    pub fn fixes_gap(&self, element: usize) -> bool {
        self.gaps.iter().all(|(guard, _)| guard.element != element)
    }

    /// The rounding of a force for a state in complex modes, which are combinations of all coordinates.
    pub fn lost(&self, force: &Quantity, state: &ModalState) -> f64 {
        if !self.form.is_complex() {
            return 0.0;
        }
        let largest = state
            .iter()
            .flatten()
            .fold(0.0, |most: f64, x| most.max(x.abs()));
        let terms: f64 = force.row.iter().flatten().map(|x| x.abs()).sum();
        CANCELLED * largest * terms
    }

    /// The state of the smaller system that is nearest a position and velocity.
    pub fn reduce(&self, q: &DVector<f64>, v: &DVector<f64>, at: Moment) -> ModalState {
        let mut y = q - &self.anchor;
        let mut dy = v.clone();
        if let Some((moved, speed)) = self.carried.at(at) {
            y -= moved;
            dy -= speed;
        }
        self.reduce_change(&y, &dy)
    }

    /// That of a displacement and its rate, from anywhere.
    pub fn reduce_change(&self, dq: &DVector<f64>, dv: &DVector<f64>) -> ModalState {
        let free = &self.free;
        let (dq, dv) = (free.tr_mul(dq), free.tr_mul(dv));
        self.form.to_modal(dq.as_slice(), dv.as_slice())
    }

    /// Position and velocity of a state of the smaller system.
    pub fn lift(&self, state: &ModalState, at: Moment) -> PhysicalState {
        let (y, dy) = self.form.to_physical(state);
        let (mut q, mut v) = (&self.anchor + &self.free * y, &self.free * dy);
        if let Some((moved, speed)) = self.carried.at(at) {
            q += moved;
            v += speed;
        }
        (q, v)
    }
}

/// The guards of a regime that are gaps or approaches, along `q = anchor + free y`.
fn gap_guards(
    scene: &ModalScene,
    regime: &Regime,
    (anchor, free): (&DVector<f64>, &DMatrix<f64>),
    form: &ModalForm,
    carried: &ImposedMotion,
) -> Vec<(Guard, Quantity)> {
    let g = &scene.geometry;
    let of_element = |i: usize| {
        let normal = g.normals.column(i).into_owned();
        let seen = free.tr_mul(&normal);
        let clearance = g.clearances[i] - normal.dot(anchor);
        let gap = carried.gap(
            scene,
            i,
            &normal,
            Quantity::gap(clearance, &form.position_row(&seen)),
        );
        let can_change = seen.norm() > DEPENDENT * normal.norm() || gap.changes_by_itself();
        let guards = g.laws[i].by_state().guards(regime.state(i)).iter();
        let guard = guards.filter_map(|&kind| {
            let quantity = match kind {
                GuardKind::Gap => gap.clone(),
                GuardKind::Approach => gap.opposite(),
                GuardKind::Force => return None,
            };
            can_change.then_some((Guard { element: i, kind }, quantity))
        });
        guard.collect::<Vec<_>>()
    };
    (0..g.len()).flat_map(of_element).collect()
}

/// Stiffness and damping of a regime over the mass, shape `(n, n)`, and the constant accelerations of all but contact forces, shape `(n,)`.
fn over_mass(
    scene: &ModalScene,
    regime: &Regime,
) -> Result<(DMatrix<f64>, DMatrix<f64>, DVector<f64>)> {
    let (system, g) = (&scene.system, &scene.geometry);
    let over = |m: DMatrix<f64>| solve_columns(system, &m);
    let mut stiffness = over(system.stiffness().to_dense());
    let mut damping = over(system.damping().to_dense());
    let mut own = system.solve_mass(&scene.excitation.constant(system.n_dof()));
    for (element, force) in forces_of(scene, regime)? {
        let (normal, reaction) = (g.normals.column(element), g.reactions.column(element));
        let across = reaction * normal.transpose();
        stiffness += &across * force.stiffness;
        damping += across * force.damping;
        own += reaction * (force.stiffness * g.clearances[element] - force.preload);
    }
    Ok((stiffness, damping, own))
}

/// The forces that elements add in a regime.
fn forces_of(scene: &ModalScene, regime: &Regime) -> Result<Vec<(usize, LinearForce)>> {
    let mut all = Vec::new();
    for &(element, state) in regime.others() {
        if let Action::Force(force) = scene.geometry.laws[element].by_state().action(state) {
            if scene.excitation.motion_of(element).is_some() {
                let rule = "the motion of a stop that gives way drives nothing yet";
                return Err(Error::bad_value("stops", format!("stop {element}"), rule));
            }
            all.push((element, force));
        }
    }
    Ok(all)
}

/// The harmonic accelerations of the whole system without contact forces, and those that follow signals.
fn free_accelerations(scene: &ModalScene) -> (Vec<DVector<Complex<f64>>>, Vec<DVector<f64>>) {
    let (system, n) = (&scene.system, scene.system.n_dof());
    let turning = scene.excitation.harmonics.iter().map(|part| {
        if part.force.is_empty() {
            DVector::from_element(n, ZERO)
        } else {
            system.solve_mass_complex(&part.force)
        }
    });
    let following = scene.excitation.signals.iter().map(|part| {
        if part.force.is_empty() {
            DVector::zeros(n)
        } else {
            system.solve_mass(&part.force)
        }
    });
    (turning.collect(), following.collect())
}
