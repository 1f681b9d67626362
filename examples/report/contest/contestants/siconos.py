"""Siconos: rigid impacts by its own Newton law, in both ways that its documentation offers; forces are compiled C functions.

*Event-driven*: LSODAR finds the contacts; complementarity problems give the impulses, and the forces where contact lasts.
LSODAR has one tolerance (Siconos sets the absolute one to the relative one); nearer to a stop and slower than that, contact
lasts. Siconos makes these forces from the accelerations evaluated last, so the driver evaluates them at each event: with the
velocities before the impact, and where damping is so strong that this matters, an exception ends the run. *Time-stepping*: the
scheme of Moreau and Jean (theta 1/2), of first order; the tolerance is its step, in spans; an impact is a step with an impulse
after one without, and its time the end of the step. For its impulses a spring that is stiff within a step is rigid. Stops that
move are followed by time-stepping alone: event-driven, Siconos has no impulses for them, and raises an exception. Where
reactions are along the coordinates, the equations are solved for the accelerations first, for Siconos makes reactions by the
mass matrix. Nonlinear scenes come without Jacobians, so each of their steps is iterated. A run makes its model anew, as nothing
takes one back to its start. Many starts are not tried, for each would be a model of its own.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import siconos.kernel as sk

import vibroimpact as vi

from ..equations import accelerations, dot, gap, mass_at, matrix_of, normal, shift_rate, tones, total
from ..formulas import traced
from ..plugin import Plugin, function, loaded
from ..problems import Problem
from . import Outcome, Run, Tolerances

DISTRIBUTION = "siconos"
STEPS = 10**7  # of LSODAR, allowed in one flight
THETA = 0.5  # of the scheme of Moreau and Jean: the trapezoidal rule between impacts
FINEST = 2.3e-12  # distance from a stop and speed of contact: just above what Siconos itself takes, whatever its tolerance
END = 1  # Siconos' number for an event of its discretisation of time
LOAD = "(double t, unsigned int n, double *f, unsigned int m, double *z)"
FORCE = "(double t, unsigned int n, double *q, double *v, double *f, unsigned int m, double *z)"
MASS = "(unsigned int n, double *q, double *mass, unsigned int m, double *z)"
GAP = "(unsigned int n, double *q, unsigned int k, double *y, unsigned int m, double *z)"
MOVING_GAP = "(unsigned int n, double *q, double t, unsigned int k, double *y, unsigned int m, double *z)"


def methods(problem: Problem) -> list[str]:
    """Both ways; time-stepping where stops move."""
    is_moving = any(stop.motion is not None for stop in problem.scene.stops)
    return ["time-stepping"] if is_moving else list(FOLLOWED)


def is_linear(problem: Problem) -> bool:
    """Whether mass, damping and stiffness are constant."""
    return isinstance(problem.scene.system, vi.LinearSystem)


def is_direct(problem: Problem) -> bool:
    """Whether reactions are along the coordinates, not along what the inverse mass makes of the normals."""
    return all(getattr(stop, "reaction", "inertia") == "coordinate" for stop in problem.scene.stops)


def matrices(problem: Problem) -> list[np.ndarray]:
    """Mass, stiffness, damping, constant force and crest of each tone, solved for accelerations if reactions ask for it."""
    scene, system = problem.scene, problem.scene.system
    mass, stiffness, damping = (np.array(matrix_of(each, float)) for each in (system.mass, system.stiffness, system.damping))
    crests = [mass @ tone.push for tone in tones(scene, float)]
    parts = [mass, stiffness, damping, np.array(system.load), *crests]
    return [np.linalg.solve(mass, part) for part in parts] if is_direct(problem) else parts


@lru_cache(maxsize=4)
def plugin(problem: Problem) -> Plugin:
    """What a problem's motion needs at each moment, compiled."""
    return loaded([*(forcing(problem) if is_linear(problem) else nonlinear(problem)), *distances(problem)])


def forcing(problem: Problem) -> list[str]:
    """The force of a linear scene in time."""
    driven, (_, _, _, load, *crests) = tones(problem.scene, float), matrices(problem)

    def outer(t):
        waves = [tone.wave(t) for tone in driven]
        parts = [[wave * each for each in crest.tolist()] for wave, crest in zip(waves, crests, strict=True)]
        return [total(terms) for terms in zip(load.tolist(), *parts, strict=True)]

    force = traced(outer, ["t"])
    return [function(f"load{LOAD}", force, {}, "f")]


def nonlinear(problem: Problem) -> list[str]:
    """Mass matrix and forces of a nonlinear scene."""
    scene, n = problem.scene, problem.scene.n_dof
    q, v, move = [f"q{i}" for i in range(n)], [f"v{i}" for i in range(n)], accelerations(scene, float)
    places = {f"{x}{i}": f"{x}[{i}]" for x in "qv" for i in range(n)}

    def mass(*x):
        return np.eye(n).tolist() if is_direct(problem) else mass_at(scene, x, float)

    def force(t, *x):  # against the motion, as Siconos has it
        rates = move(t, x[:n], x[n:])
        return [dot(row, rates) * -1.0 for row in mass(*x[:n])]

    return [
        function(f"mass{MASS}", traced(lambda *x: [each for row in mass(*x) for each in row], q), places, "mass"),
        function(f"force{FORCE}", traced(force, ["t", *q, *v]), places, "f"),
    ]


def distances(problem: Problem) -> list[str]:
    """Gap and normal of each stop that is no plane at rest, and the speed at which its own motion opens its gap."""
    scene, q = problem.scene, [f"q{i}" for i in range(problem.scene.n_dof)]
    places, functions = {name: f"q[{i}]" for i, name in enumerate(q)}, []
    for k, stop in enumerate(scene.stops):
        if is_fixed_plane(stop):
            continue
        to_gap, to_normal, to_speed = gap(stop, scene, float), normal(stop, scene, float), shift_rate(stop, float)
        formulas = {
            "gap": lambda t, *x, to=to_gap: [to(t, x)],
            "slope": lambda _, *x, to=to_normal: [each * -1.0 for each in to(x)],
            "speed": lambda t, *_, to=to_speed: [to(t)],
        }
        head = GAP if stop.motion is None else MOVING_GAP
        functions += [function(f"{name}{k}{head}", traced(each, ["t", *q]), places, "y") for name, each in formulas.items()]
    return functions


def is_fixed_plane(stop: Any) -> bool:
    """Whether a gap is linear, and constant in time."""
    return isinstance(stop, vi.Stop) and stop.motion is None


def body(problem: Problem):
    """The moving system at its start."""
    q0, v0 = list(problem.q0), list(problem.v0)
    if not is_linear(problem):
        moving = sk.LagrangianDS(q0, v0, np.eye(len(q0)))
        moving.setComputeMassFunction(plugin(problem).path, "mass")
        moving.setComputeFIntFunction(plugin(problem).path, "force")
        return moving
    mass, stiffness, damping, load, *_ = matrices(problem)
    moving = sk.LagrangianLinearTIDS(q0, v0, mass, stiffness, damping)
    if problem.scene.forcing is None:
        moving.setFExtPtr(load)
    else:
        moving.setComputeFExtFunction(plugin(problem).path, "load")
    return moving


def relation(problem: Problem, k: int):
    """Gap of a stop as Siconos takes it."""
    stop, scene = problem.scene.stops[k], problem.scene
    if is_fixed_plane(stop):
        return sk.LagrangianLinearTIR([[-each for each in normal(stop, scene, float)(problem.q0)]], [stop.clearance])
    path = plugin(problem).path
    if stop.motion is None:
        return sk.LagrangianScleronomousR(f"{path}:gap{k}", f"{path}:slope{k}")
    return sk.LagrangianRheonomousR(f"{path}:gap{k}", f"{path}:slope{k}", f"{path}:speed{k}")


def model(problem: Problem):
    """The whole, its moving system and its contacts."""
    whole, moving = sk.NonSmoothDynamicalSystem(0.0, problem.end), body(problem)
    whole.insertDynamicalSystem(moving)
    contacts = [
        sk.Interaction(sk.NewtonImpactNSL(stop.restitution), relation(problem, k)) for k, stop in enumerate(problem.scene.stops)
    ]
    for each in contacts:
        whole.link(each, moving)
    return whole, moving, contacts


def event_driven(problem: Problem, relative: float) -> Outcome:
    """From event to event; the discretisation of time is one step, to the end."""
    whole, moving, contacts = model(problem)
    integrator = sk.LsodarOSI()
    integrator.setTol(1, relative, relative)
    simulation = sk.EventDriven(whole, sk.TimeDiscretisation(0.0, problem.end))
    simulation.insertIntegrator(integrator)
    simulation.insertNonSmoothProblem(sk.LCP(), sk.SICONOS_OSNSP_ED_IMPACT)
    simulation.insertNonSmoothProblem(sk.LCP(), sk.SICONOS_OSNSP_ED_SMOOTH_ACC)
    simulation.setToleranceED(max(relative, FINEST))
    simulation.initialize()
    integrator.setMaxNstep(STEPS)  # after the start, which sets it back
    events, impulses, times = simulation.eventsManager(), [each.lambda_(1) for each in contacts], []
    is_over = False
    while not is_over:
        simulation.advanceToEvent()
        is_over = events.nextEvent().getType() == END
        integrator.computeRhs(simulation.nextTime())
        simulation.processEvents()
        times += [simulation.startingTime() for each in impulses if each[0] > 0.0]
    return Outcome(np.concatenate([moving.q(), moving.velocity()]), np.array(times))


def time_stepping(problem: Problem, relative: float) -> Outcome:
    """Step by step."""
    whole, moving, contacts = model(problem)
    steps = sk.TimeDiscretisation(0.0, relative * problem.end)
    simulation = sk.TimeStepping(whole, steps, sk.MoreauJeanOSI(THETA), sk.LCP())
    simulation.setNewtonOptions(sk.SICONOS_TS_LINEAR if is_linear(problem) else sk.SICONOS_TS_NONLINEAR)
    simulation.setNewtonTolerance(max(relative**2, FINEST))  # of one step: all together make the tolerance
    simulation.initialize()
    impulses, times = [each.lambda_(1) for each in contacts], []
    were = [False] * len(contacts)
    while simulation.hasNextEvent():
        simulation.computeOneStep()
        are = [each[0] > 0.0 for each in impulses]
        times += [simulation.nextTime() for is_now, was in zip(are, were, strict=True) if is_now and not was]
        were = are
        simulation.nextStep()
    return Outcome(np.concatenate([moving.q(), moving.velocity()]), np.array(times))


FOLLOWED = {"event-driven": event_driven, "time-stepping": time_stepping}


def prepare(problem: Problem, method: str, tolerances: Tolerances) -> Run:
    """A first model compiles what it needs; each run makes its own."""
    model(problem)
    return lambda: FOLLOWED[method](problem, tolerances.relative)
