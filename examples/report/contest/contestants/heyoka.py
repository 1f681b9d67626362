"""heyoka: Taylor series, compiled; a terminal event for each stop, the impact in its callback, which goes on.

It takes one tolerance.
"""

from __future__ import annotations

import heyoka as hy
import numpy as np

from ..equations import equations
from ..problems import Problem
from . import Outcome, Run, Tolerances

DISTRIBUTION = "heyoka"


def methods(_: Problem) -> list[str]:
    """One."""
    return ["Taylor"]


class Impact:
    """The impact on one stop."""

    def __init__(self, formula, n: int, times: list[float]) -> None:
        """Take the formula of the velocities afterwards and the list of times that all stops share."""
        self.formula, self.n, self.times = formula, n, times

    def __call__(self, integrator, _) -> bool:
        """Turn the velocities and go on."""
        state = integrator.state
        state[self.n :] = self.formula(*state.tolist())
        self.times.append(integrator.time)
        return True


def system(problem: Problem):
    """Names of the state, equations of motion and gaps as heyoka's expressions."""
    formulas = equations(problem.scene)
    n, functions = formulas.n_dof, {"sin": hy.sin, "cos": hy.cos}
    names = hy.make_vars(*[f"q{i}" for i in range(n)], *[f"v{i}" for i in range(n)])
    accelerations = formulas.acceleration.function(functions)(hy.time, *names)
    rates = [(name, rate if isinstance(rate, hy.expression) else hy.expression(float(rate))) for name, rate in
             zip(names, [*names[n:], *accelerations], strict=True)]  # fmt: skip
    return formulas, rates, [each.function(functions)(*names[:n])[0] for each in formulas.gaps]


def prepare(problem: Problem, _: str, tolerances: Tolerances) -> Run:
    """One integrator, compiled here and set back to the start by each run."""
    formulas, rates, gaps = system(problem)
    times: list[float] = []
    integrator = hy.taylor_adaptive(
        rates,
        problem.start,
        tol=tolerances.relative,
        t_events=[
            hy.t_event(gap, callback=Impact(each.function(), formulas.n_dof, times), direction=hy.event_direction.negative)
            for gap, each in zip(gaps, formulas.impacts, strict=True)
        ],
    )
    shared = integrator.t_events[0].callback.times  # callbacks are copied with the events
    for event in integrator.t_events:
        event.callback.times = shared

    def run() -> Outcome:
        shared.clear()
        integrator.time = 0.0
        integrator.state[:] = problem.start
        integrator.reset_cooldowns()
        outcome = integrator.propagate_until(problem.end)[0]
        if outcome != hy.taylor_outcome.time_limit:
            raise RuntimeError(str(outcome))
        return Outcome(integrator.state.copy(), np.array(shared))

    return run
