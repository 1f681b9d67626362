"""SciPy's `solve_ivp`: a terminal event for each stop, the impact by hand, a new start after each."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from ..equations import equations
from ..problems import Problem
from . import Outcome, Run, Tolerances

DISTRIBUTION = "scipy"


def methods(_: Problem) -> list[str]:
    """Two explicit pairs, one implicit method, one that switches."""
    return ["RK45", "DOP853", "Radau", "LSODA"]


def prepare(problem: Problem, method: str, tolerances: Tolerances) -> Run:
    """Events and restarts; the right-hand side is straight lines of Python floats, faster than small NumPy arrays."""
    formulas = equations(problem.scene)
    n, acceleration = formulas.n_dof, formulas.acceleration.function()
    impacts = [each.function() for each in formulas.impacts]

    def rate(t, x):
        x = x.tolist()
        return [*x[n:], *acceleration(t, *x)]

    def event(gap):
        def distance(_, x):
            return gap(*x[:n].tolist())[0]

        distance.terminal, distance.direction = True, -1
        return distance

    events = [event(each.function()) for each in formulas.gaps]
    options = {"method": method, "rtol": tolerances.relative, "atol": tolerances.absolute, "events": events}

    def run() -> Outcome:
        t, x, times = 0.0, problem.start, []
        while t < problem.end:
            flight = solve_ivp(rate, (t, problem.end), x, **options)
            if flight.status < 0:
                raise RuntimeError(flight.message)
            t, x = flight.t[-1], flight.y[:, -1].copy()
            for impact, hits in zip(impacts, flight.t_events, strict=True):
                if len(hits):
                    x[n:] = impact(*x.tolist())
                    times.append(t)
        return Outcome(x, np.array(times))

    return run
