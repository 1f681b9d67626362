"""SciPy, once with a terminal event at each beginning and end of a contact and a new start there, once without.

Without them one call follows the whole motion, by forces that begin where gaps close; its events end nothing, they give the times
at which contacts begin. `Radau` and `LSODA` are given the Jacobian.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from ...equations import Equations, equations
from ...opening import OPEN, opening
from ...problems import Compliant
from .. import Outcome, Run, Tolerances
from ..scipy import IMPLICIT, jacobian

KINDS = ("RK45", "DOP853", "Radau", "LSODA")
WITHOUT = " without restarts"


def methods(_: Compliant) -> list[str]:
    """Two explicit pairs, one implicit method, one that switches, each in both ways."""
    return [kind + way for way in ("", WITHOUT) for kind in KINDS]


class Regime:
    """The motion while some stops are pressed, as SciPy takes it."""

    def __init__(self, problem: Compliant, pressed: tuple[int, ...]) -> None:
        """Write its formulas out as functions of Python floats."""
        formulas: Equations = equations(problem.scene, pressed=pressed)
        n, acceleration = formulas.n_dof, formulas.acceleration.function()

        def rate(t: float, x: np.ndarray) -> list[float]:
            values = x.tolist()
            return [*values[n:], *acceleration(t, *values)]

        self.rate, self.jacobian = rate, jacobian(formulas)
        self.events = [event(each.function(), n) for each in formulas.gaps]


def event(guard: Callable[..., Any], n: int) -> Callable[[float, np.ndarray], float]:
    """A guard that ends a flight where it falls through zero."""

    def value(t: float, x: np.ndarray) -> float:
        return guard(t, *x[:n].tolist())[0]

    value.terminal, value.direction = True, -1
    return value


def with_restarts(problem: Compliant, options: dict[str, Any]) -> Run:
    """From change to change, each flight from a little behind the last one."""
    regime = cache(lambda pressed: Regime(problem, pressed))
    stops = range(len(problem.scene.stops))
    moves = [[(i, change.function()) for i, change in (opening(problem, k, side * OPEN) for side in (1, -1))] for k in stops]
    n = problem.scene.n_dof

    def run() -> Outcome:
        t, x, times, pressed = 0.0, problem.start, [], ()
        while t < problem.end:
            now = regime(pressed)
            more = {"jac": now.jacobian} if options["method"] in IMPLICIT else {}
            flight = solve_ivp(now.rate, (t, problem.end), x, events=now.events, **options, **more)
            if flight.status < 0:
                raise RuntimeError(flight.message)
            t, x = flight.t[-1], flight.y[:, -1].copy()
            for stop in (k for k, found in enumerate(flight.t_events) if len(found)):
                pressed = tuple(sorted({*pressed} ^ {stop}))
                leading, change = moves[stop][stop in pressed]
                x[leading] += change(t, *x[:n].tolist())[0]
                if stop in pressed:
                    times.append(t)
        return Outcome(x, np.array(times))

    return run


def without_restarts(problem: Compliant, options: dict[str, Any]) -> Run:
    """One call, whose forces are those of the stops that are pressed at each state."""
    regime = cache(lambda pressed: Regime(problem, pressed))
    gaps = Regime(problem, ()).events

    def now(t: float, x: np.ndarray) -> Regime:
        return regime(tuple(k for k, gap in enumerate(gaps) if gap(t, x) < 0.0))

    more = {"jac": lambda t, x: now(t, x).jacobian(t, x)} if options["method"] in IMPLICIT else {}
    watched = [seen(gap) for gap in gaps]

    def run() -> Outcome:
        motion = solve_ivp(
            lambda t, x: now(t, x).rate(t, x), (0.0, problem.end), problem.start, events=watched, **options, **more
        )
        if motion.status < 0:
            raise RuntimeError(motion.message)
        return Outcome(motion.y[:, -1], sorted_times(motion.t_events))

    return run


def seen(gap: Callable[[float, np.ndarray], float]) -> Callable[[float, np.ndarray], float]:
    """An event that ends nothing."""

    def value(t: float, x: np.ndarray) -> float:
        return gap(t, x)

    value.direction = -1
    return value


def sorted_times(events: Sequence[np.ndarray]) -> np.ndarray:
    """The times of several events, in order."""
    return np.sort(np.concatenate([np.asarray(each, dtype=float) for each in events]))


def prepare(problem: Compliant, method: str, tolerances: Tolerances) -> Run:
    """The run, in one of the two ways."""
    options = {"method": method.removesuffix(WITHOUT), "rtol": tolerances.relative, "atol": tolerances.absolute}
    run = (without_restarts if method.endswith(WITHOUT) else with_restarts)(problem, options)
    run()  # writes the formulas of each regime out
    return run
