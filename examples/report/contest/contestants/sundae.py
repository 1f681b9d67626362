"""scikit-sundae: CVODE of SUNDIALS; terminal events, the impact by hand, a new start a little in front of the stop after each.

It is given the Jacobian.
"""

from __future__ import annotations

import numpy as np
from sksundae.cvode import CVODE

from ..equations import equations
from ..problems import Problem
from . import Outcome, Run, Tolerances
from .scipy import after_impact, jacobian

DISTRIBUTION = "scikit-sundae"
STEPS = 10**7  # allowed in one flight


def methods(_: Problem) -> list[str]:
    """Both families of CVODE."""
    return ["Adams", "BDF"]


def prepare(problem: Problem, method: str, tolerances: Tolerances) -> Run:
    """Events and restarts."""
    formulas = equations(problem.scene)
    n, acceleration = formulas.n_dof, formulas.acceleration.function()
    gaps = [each.function() for each in formulas.gaps]
    stops = [after_impact(problem, k, impact.function()) for k, impact in enumerate(formulas.impacts)]

    def rate(t, x, dx):
        x = x.tolist()
        dx[:n] = x[n:]
        dx[n:] = acceleration(t, *x)

    def distances(t, x, out):
        q = x[:n].tolist()
        for k, gap in enumerate(gaps):
            out[k] = gap(t, *q)[0]

    slopes = jacobian(formulas)

    def derivative(t, x, _, out):
        out[:] = slopes(t, x)

    distances.terminal, distances.direction = [True] * len(gaps), [-1] * len(gaps)
    options = {"rtol": tolerances.relative, "atol": tolerances.absolute, "max_num_steps": STEPS, "jacfn": derivative}
    solver = CVODE(rate, method=method, eventsfn=distances, num_events=len(gaps), **options)

    def run() -> Outcome:
        t, x, times = 0.0, problem.start, []
        while t < problem.end:
            flight = solver.solve([t, problem.end], x)
            if not flight.success:
                raise RuntimeError(flight.message)
            t, x = float(flight.t[-1]), flight.y[-1].copy()
            if t >= problem.end:
                break
            for stop, hit in zip(stops, np.atleast_2d(flight.i_events)[-1], strict=True):
                if hit:
                    stop(t, x)
                    times.append(t)
        return Outcome(x, np.array(times))

    return run
