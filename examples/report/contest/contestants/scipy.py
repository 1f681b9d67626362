"""SciPy's `solve_ivp`: a terminal event for each stop, the impact by hand, a new start after each.

It starts again a little in front of the stop, at a gap far below every tolerance. `Radau` and `LSODA` are given the Jacobian, for
`Radau` a constant one of a linear scene.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

import vibroimpact as vi

from ..equations import Equations, equations
from ..opening import opening
from ..problems import Problem
from . import Outcome, Run, Tolerances

DISTRIBUTION = "scipy"
IMPLICIT = ("Radau", "LSODA")


def methods(_: Problem) -> list[str]:
    """Two explicit pairs, one implicit method, one that switches."""
    return ["RK45", "DOP853", "Radau", "LSODA"]


def after_impact(problem: Problem, k: int, impact):
    """What an impact does to a state, in place."""
    n, (leading, change) = problem.scene.n_dof, opening(problem, k)
    moved = change.function()

    def act(t: float, x: np.ndarray) -> None:
        values = x.tolist()
        x[n:] = impact(t, *values)
        x[leading] += moved(t, *values[:n])[0]

    return act


def jacobian(formulas: Equations):
    """Derivative of the rates by the state."""
    n, entries = formulas.n_dof, formulas.jacobian().function()
    slopes = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), np.zeros((n, 2 * n))])

    def at(t, x):
        found = slopes.copy()
        found[n:].flat = entries(t, *x.tolist())
        return found

    return at


def prepare(problem: Problem, method: str, tolerances: Tolerances) -> Run:
    """Events and restarts; the right-hand side is straight lines of Python floats, faster than small NumPy arrays."""
    formulas = equations(problem.scene)
    n, acceleration = formulas.n_dof, formulas.acceleration.function()
    stops = [after_impact(problem, k, impact.function()) for k, impact in enumerate(formulas.impacts)]

    def rate(t, x):
        x = x.tolist()
        return [*x[n:], *acceleration(t, *x)]

    def event(gap):
        def distance(t, x):
            return gap(t, *x[:n].tolist())[0]

        distance.terminal, distance.direction = True, -1
        return distance

    events = [event(each.function()) for each in formulas.gaps]
    options = {"method": method, "rtol": tolerances.relative, "atol": tolerances.absolute, "events": events}
    if method in IMPLICIT:
        slopes = jacobian(formulas)
        is_constant = method == "Radau" and isinstance(problem.scene.system, vi.LinearSystem)
        options["jac"] = slopes(0.0, problem.start) if is_constant else slopes

    def run() -> Outcome:
        t, x, times = 0.0, problem.start, []
        while t < problem.end:
            flight = solve_ivp(rate, (t, problem.end), x, **options)
            if flight.status < 0:
                raise RuntimeError(flight.message)
            t, x = flight.t[-1], flight.y[:, -1].copy()
            for stop, hits in zip(stops, flight.t_events, strict=True):
                if len(hits):
                    stop(t, x)
                    times.append(t)
        return Outcome(x, np.array(times))

    return run
