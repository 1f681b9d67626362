//! The motion of a linear scene in a regime that is not free. While stops are held (theory 9), it is that of a smaller linear system,
//! `q = q_c + Z y` with `N^T Z = 0` \[m\]; those that are pressed add to its stiffness and damping, their motions to what drives it. All
//! guards are rows on its state: contact forces \[N\] like the gaps of the other stops. The place of a stop that relaxes is a block of its own.

use crate::error::Result;
use crate::flow::derivative::{LinearEquations, solve_columns};
use crate::flow::derivatives_at::{QuantityDerivatives, derivatives_at};
use crate::flow::gap_row::{GapRow, Quantity};
use crate::flow::imposed_motion::ImposedMotion;
use crate::flow::linear::{FlowRows, propagate};
use crate::flow::modal_scene::ModalScene;
use crate::flow::reduced_system::{Reduced, cleared, in_modes, uncoupled, without_rounding};
use crate::flow::regime_drive::RegimeDrive;
use crate::flow::scene_flow::{SceneFlow, with_flow};
use crate::law::{ElementState, Guard, GuardKind, Regime, Relaxation};
use crate::linalg::rank;
use crate::modal::{Form, ModalForm, ModalState, Pair};
use crate::model::{Moment, PhysicalState};
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
    /// The stops that relax, by their blocks behind those of the form.
    relaxing: Vec<(usize, Relaxation)>,
    pub flow: SceneFlow,
    /// The contact force of each stop held, in their order.
    pub forces: Vec<Quantity>,
    /// The guards but for contact forces; of stops that do not give way those that can change.
    others: Vec<(Guard, Quantity)>,
    /// All guards as rows on the state of the flow, made when first needed.
    rows: OnceLock<Vec<GapRow>>,
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

        let (stiffness, damping, own) = over_mass(scene, regime);
        let drawn = &stiffness * &anchor;
        // A spring between coordinates that stand where it is at rest pulls at neither.
        let sizes = own.abs() + stiffness.abs() * anchor.abs();
        let load = without_rounding(&(own - drawn), &sizes);
        let mut drive = RegimeDrive::new(scene);
        let carried = ImposedMotion::new(scene, stops, |c| {
            let moved = held(&normals, c)?.particular;
            Ok(moved)
        })?;
        carried.act((&stiffness, &damping), &mut drive);
        for (element, force) in g.forces(regime) {
            let reaction = g.reactions.column(element).into_owned();
            drive.push(scene.excitation.motion_of(element), force, &reaction);
        }
        // (N^T B)^+, which takes the gaps' free accelerations to the contact forces.
        let delassus = normals.tr_mul(&reactions);
        let tolerance = DEPENDENT * reactions.amax() * normals.amax();
        let inverse = uncoupled(rank::pseudo_inverse(&delassus, tolerance)?);
        // Where normals depend on each other, stops share their forces: they react along what these make of their reactions.
        let shared = &reactions * &inverse;
        let reduced = Reduced::new(system, &free, &shared)?;
        let form = reduced.form(&stiffness, &damping, &free)?;
        let relaxing = relaxing_in(scene, regime);
        let kinematics = Kinematics {
            anchor: &anchor,
            free: &free,
            form: &form,
            carried: &carried,
        };
        let mut guards = Guards::new(scene, regime, &kinematics);
        guards.take_rates(&mut drive);
        let mut others = guards.with_relaxing(&relaxing);
        let (forces, directions) = (&drive.turning, &drive.following);
        let takes = inverse * normals.transpose();
        let row = |q: DVector<f64>, v: DVector<f64>| in_modes(&form, &q, &v);
        // What of a matrix the motion left over sees along a row.
        let seen = |m: &DMatrix<f64>, g: &DVector<f64>| {
            let sizes = free.abs().tr_mul(&m.abs().tr_mul(&g.abs()));
            without_rounding(&free.tr_mul(&m.tr_mul(g)), &sizes)
        };
        let forces: Vec<Quantity> = (0..stops.len())
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
                let row = row(seen(&stiffness, &g), seen(&damping, &g));
                Quantity {
                    constant: cleared(g.dot(&load), size),
                    size,
                    row: beside_relaxing(row, &relaxing),
                    forcing: forces.iter().map(pull).collect(),
                    signals: directions.iter().map(follow).collect(),
                }
            })
            .collect();
        let borne = stops.iter().zip(&forces);
        others.extend(borne.filter_map(|(&element, force)| {
            let seat = g.laws[element].by_state().seat()?;
            let kind = GuardKind::Excess;
            Some((Guard { element, kind }, force.left_of(seat)))
        }));
        let flow = drive.flow(&form, &reduced, &load, &relaxing);
        Ok(Self {
            regime: regime.clone(),
            others,
            along: &free * &reduced.takes,
            shared,
            equations: OnceLock::new(),
            anchor,
            carried,
            free,
            form,
            relaxing,
            flow,
            forces,
            rows: OnceLock::new(),
        })
    }

    /// The guards of the regime as rows on the state of the flow, in the order of [`guards`](Self::guards).
    pub fn rows(&self) -> &[GapRow] {
        self.rows.get_or_init(|| {
            let row = |(_, quantity)| with_flow!(&self.flow, flow => flow.gap_row(quantity));
            self.guards().map(row).collect()
        })
    }

    /// A quantity of it in a state at a moment.
    pub fn derivatives(
        &self,
        quantity: &Quantity,
        (state, at): (&ModalState, Moment),
    ) -> QuantityDerivatives {
        with_flow!(&self.flow, flow => derivatives_at(flow, quantity, (state, at)))
    }

    /// A state with the places of the stops that relax.
    pub fn with_places(&self, mut state: ModalState, place: impl Fn(usize) -> f64) -> ModalState {
        let places = self.relaxing.iter();
        state.extend(places.map(|&(element, own)| [place(element) + own.beyond, 0.0]));
        state
    }

    /// The guards of the regime as quantities of the motion: the contact forces of what is held, and all others that can fall.
    pub fn guards(&self) -> impl Iterator<Item = (Guard, &Quantity)> {
        let held = self.regime.constrained().iter();
        let forces = held.zip(&self.forces);
        let forces = forces.map(|(&element, force)| (Guard::force(element), force));
        forces.chain(self.others.iter().map(|(guard, own)| (*guard, own)))
    }

    /// The equations of the motion, made when first needed.
    pub fn equations(&self, scene: &ModalScene) -> &LinearEquations {
        let make = || {
            let (system, g) = (&scene.system, &scene.geometry);
            let mut equations = LinearEquations::new(system, Some(&self.along));
            for (element, force) in scene.geometry.forces(&self.regime) {
                let direction = system
                    .mass()
                    .times(&g.reactions.column(element).into_owned());
                let clearance = scene.mean_clearances(&[element])[0];
                let normal = g.normals.column(element).into_owned();
                equations.push(&direction, &normal, (force, clearance));
            }
            equations
        };
        self.equations.get_or_init(make)
    }

    /// The part that stops which move impose of the derivative of the position of some order, from the second on: those held, and those
    /// that are pressed.
    pub fn carried_derivative(
        &self,
        scene: &ModalScene,
        at: Moment,
        order: usize,
    ) -> Option<DVector<f64>> {
        if scene.excitation.stops.is_empty() {
            return None;
        }
        let own = |stop: usize, order: usize| {
            let motion = scene.excitation.motion_of(stop);
            motion.map_or(0.0, |motion| motion.derivative(at, order).0)
        };
        let stops = self.regime.constrained();
        let held = DVector::from_iterator(stops.len(), stops.iter().map(|&stop| own(stop, order)));
        let mut all = DVector::zeros(self.anchor.len());
        if held.amax() > 0.0 {
            all += &self.shared * held;
        }
        for (stop, force) in scene.geometry.forces(&self.regime) {
            let push =
                force.stiffness * own(stop, order - 2) + force.damping * own(stop, order - 1);
            if push != 0.0 {
                all += &self.along * scene.geometry.reactions.column(stop) * push;
            }
        }
        (all.amax() > 0.0).then_some(all)
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
        // Where the stops are that relax moves nothing.
        let mut state = self.with_places(self.reduce(q, v, at), |_| 0.0);
        with_flow!(&self.flow, f => propagate(f, at, span, &mut state));
        state.truncate(self.form.n_dof());
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

    /// Whether the gap of a rigid element cannot change.
    pub fn fixes_gap(&self, element: usize) -> bool {
        self.others
            .iter()
            .all(|(guard, _)| guard.element != element)
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

/// Where `q = anchor + free y` lies and what moves it beside y.
struct Kinematics<'a> {
    anchor: &'a DVector<f64>,
    free: &'a DMatrix<f64>,
    form: &'a ModalForm,
    carried: &'a ImposedMotion,
}

impl Kinematics<'_> {
    /// The gap of a stop, its opening speed as far as it depends on the state, and whether it can change.
    fn gap(&self, scene: &ModalScene, stop: usize) -> (Quantity, Vec<Pair>, bool) {
        let g = &scene.geometry;
        let normal = g.normals.column(stop).into_owned();
        let seen = self.free.tr_mul(&normal);
        let clearance = g.clearances[stop] - normal.dot(self.anchor);
        let gap = Quantity::gap(clearance, &self.form.position_row(&seen));
        let gap = self.carried.gap(scene, stop, &normal, gap);
        let can_change = seen.norm() > DEPENDENT * normal.norm() || gap.changes_by_itself();
        (gap, self.form.velocity_row(&seen), can_change)
    }
}

/// The guards of a regime but for contact forces.
struct Guards(Vec<WatchedGuard>);

/// A guard, and what it takes of the rate of a gap.
struct WatchedGuard {
    guard: Guard,
    quantity: Quantity,
    /// The gap of the element, where its rate is in the guard, and the factor on that.
    rate: Option<(Quantity, f64)>,
}

impl Guards {
    fn new(scene: &ModalScene, regime: &Regime, kinematics: &Kinematics<'_>) -> Self {
        let g = &scene.geometry;
        let of_element = |element: usize| {
            let law = g.laws[element].by_state();
            let (gap, speed, can_change) = kinematics.gap(scene, element);
            let guards = law.guards(regime.state(element)).iter();
            let guard = guards.filter_map(move |&kind| {
                let force = |sign: f64| {
                    let own = law.force(ElementState::Pressed)?;
                    let quantity = gap.pressed(&speed, own, sign);
                    Some((quantity, Some((gap.clone(), -sign * own.damping))))
                };
                let (quantity, rate) = match kind {
                    GuardKind::Gap | GuardKind::Distance => (gap.clone(), None),
                    GuardKind::Approach => (gap.opposite(), None),
                    GuardKind::Push => force(1.0)?,
                    GuardKind::Pull => force(-1.0)?,
                    GuardKind::Force | GuardKind::Excess | GuardKind::Place => return None,
                };
                // An impact may put a force of a stop that gives way where it stays.
                (can_change || law.restitution().is_none()).then_some(WatchedGuard {
                    guard: Guard { element, kind },
                    quantity,
                    rate,
                })
            });
            guard.collect::<Vec<_>>()
        };
        Self((0..g.len()).flat_map(of_element).collect())
    }

    /// Takes the rates of the motions of stops into what needs them; those of signals become signals of their own.
    fn take_rates(&mut self, drive: &mut RegimeDrive) {
        for own in &mut self.0 {
            if let Some((gap, factor)) = &own.rate {
                drive.add_rate(gap, *factor, &mut own.quantity);
            }
        }
    }

    /// The guards beside the places of the stops that relax.
    fn with_relaxing(self, relaxing: &[(usize, Relaxation)]) -> Vec<(Guard, Quantity)> {
        let beside = |own: WatchedGuard| {
            let (guard, mut quantity) = (own.guard, own.quantity);
            let n = quantity.row.len();
            quantity.row = beside_relaxing(quantity.row, relaxing);
            if guard.kind == GuardKind::Distance {
                let place = relaxing.iter().position(|own| own.0 == guard.element);
                let place = place.expect("it relaxes");
                // A quantity is its constant less its row; the block is what is left of the way to where its place would go.
                quantity.row[n + place] = [-1.0, 0.0];
                quantity.constant -= relaxing[place].1.beyond;
                quantity.size += relaxing[place].1.beyond;
            }
            (guard, quantity)
        };
        self.0.into_iter().map(beside).collect()
    }
}

/// The stops that relax in a regime, with how they do.
fn relaxing_in(scene: &ModalScene, regime: &Regime) -> Vec<(usize, Relaxation)> {
    let own = regime.others().iter();
    let own = own.filter_map(|&(element, state)| {
        let law = scene.geometry.laws[element].by_state();
        Some((element, law.relaxation(state)?))
    });
    own.collect()
}

/// A row on the pairs of a form as one beside those of stops that relax.
fn beside_relaxing(mut row: Vec<Pair>, relaxing: &[(usize, Relaxation)]) -> Vec<Pair> {
    row.resize(row.len() + relaxing.len(), [0.0; 2]);
    row
}

/// Stiffness and damping of a regime over the mass, shape `(n, n)`, and the constant accelerations of all but contact forces, shape `(n,)`.
fn over_mass(scene: &ModalScene, regime: &Regime) -> (DMatrix<f64>, DMatrix<f64>, DVector<f64>) {
    let (system, g) = (&scene.system, &scene.geometry);
    let over = |m: DMatrix<f64>| solve_columns(system, &m);
    let [stiffness, damping] = g.pressed(regime);
    let stiffness = over(system.stiffness().to_dense()) + stiffness;
    let damping = over(system.damping().to_dense()) + damping;
    let mut own = system.solve_mass(&scene.excitation.constant(system.n_dof()));
    for (element, force) in g.forces(regime) {
        let clearance = scene.mean_clearances(&[element])[0];
        own -= g.reactions.column(element) * force.at(clearance, 0.0);
    }
    (stiffness, damping, own)
}
