"""heyoka in batch mode: as many trajectories at once as the processor has lanes."""

from __future__ import annotations

from collections.abc import Callable

import heyoka as hy
import numpy as np

from ...problems import Ensemble
from .. import Tolerances
from ..heyoka import system
from . import Ends


def methods(_: Ensemble) -> list[str]:
    """One."""
    return ["Taylor batch"]


class Impact:
    """The impact on one stop in one lane, counted."""

    def __init__(self, formula, n: int) -> None:
        """Take the formula of the velocities afterwards; `time`, `state`, `counts` are set when there is an integrator."""
        self.formula, self.n = formula, n

    def __call__(self, _, __, lane: int) -> bool:
        """Turn the velocities and go on."""
        self.state[self.n :, lane] = self.formula(self.time[lane], *self.state[:, lane].tolist())
        self.counts[lane] += 1
        return True


def prepare(problem: Ensemble, _: str, tolerances: Tolerances) -> Callable[[], Ends]:
    """One integrator for all batches."""
    formulas, rates, gaps = system(problem)
    n, lanes = formulas.n_dof, hy.recommended_simd_size()
    falling = hy.event_direction.negative
    events = [
        hy.t_event_batch(gap, callback=Impact(each.function(), n), direction=falling)
        for gap, each in zip(gaps, formulas.impacts, strict=True)
    ]
    integrator = hy.taylor_adaptive_batch(
        rates, np.ascontiguousarray(problem.starts[:lanes].T), tol=tolerances.relative, t_events=events
    )
    time, state, counts = integrator.time, integrator.state, np.zeros(lanes, int)  # times and state are views
    for event in integrator.t_events:  # callbacks are copied with the events
        event.callback.time, event.callback.state, event.callback.counts = time, state, counts
    k = len(problem.starts)
    batches = [np.arange(i, i + lanes) % k for i in range(0, k, lanes)]

    def run() -> Ends:
        states, n_impacts = np.empty((k, 2 * n)), np.empty(k, int)
        for rows in batches:
            counts[:] = 0
            integrator.set_time(0.0)
            state[:] = problem.starts[rows].T
            integrator.reset_cooldowns()
            integrator.propagate_until(problem.end)
            states[rows], n_impacts[rows] = state.T, counts
        return Ends(np.arange(k), states, n_impacts)

    return run
