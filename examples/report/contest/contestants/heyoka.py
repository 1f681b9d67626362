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

    def __init__(self, formula) -> None:
        """Take the formula of the velocities afterwards; `state`, `velocities`, `times` are set with the integrator."""
        self.formula = formula

    def __call__(self, integrator, _) -> bool:
        """Turn the velocities and go on."""
        time = integrator.time
        self.velocities[:] = self.formula(time, *self.state.tolist())
        self.times.append(time)
        return True


def system(problem: Problem):
    """Names of the state, equations of motion and gaps as heyoka's expressions."""
    formulas = equations(problem.scene)
    n, functions = formulas.n_dof, {"sin": hy.sin, "cos": hy.cos}
    names = hy.make_vars(*[f"q{i}" for i in range(n)], *[f"v{i}" for i in range(n)])
    accelerations = formulas.acceleration.function(functions)(hy.time, *names)
    rates = [(name, rate if isinstance(rate, hy.expression) else hy.expression(float(rate))) for name, rate in
             zip(names, [*names[n:], *accelerations], strict=True)]  # fmt: skip
    return formulas, rates, [each.function(functions)(hy.time, *names[:n])[0] for each in formulas.gaps]


def prepare(problem: Problem, _: str, tolerances: Tolerances) -> Run:
    """One integrator, compiled here and set back to the start by each run."""
    formulas, rates, gaps = system(problem)
    times: list[float] = []
    integrator = hy.taylor_adaptive(
        rates,
        problem.start,
        tol=tolerances.relative,
        t_events=[
            hy.t_event(gap, callback=Impact(each.function()), direction=hy.event_direction.negative)
            for gap, each in zip(gaps, formulas.impacts, strict=True)
        ],
    )
    state = integrator.state  # a view, which the callbacks, copied with the events, keep: made anew, it costs as much as they do
    for event in integrator.t_events:
        event.callback.state, event.callback.velocities, event.callback.times = state, state[formulas.n_dof :], times

    def run() -> Outcome:
        times.clear()
        integrator.time = 0.0
        state[:] = problem.start
        integrator.reset_cooldowns()
        outcome = integrator.propagate_until(problem.end)[0]
        if outcome != hy.taylor_outcome.time_limit:
            raise RuntimeError(str(outcome))
        return Outcome(state.copy(), np.array(times))

    return run
