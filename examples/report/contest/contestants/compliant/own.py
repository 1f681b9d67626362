"""The library's own methods: closed form from change to change, and steps."""

from __future__ import annotations

import numpy as np

import vibroimpact as vi

from ...problems import Compliant
from .. import Outcome, Run, Tolerances


def methods(_: Compliant) -> list[str]:
    """Closed form and Runge-Kutta."""
    return ["exact", "rk45"]


def prepare(problem: Compliant, method: str, tolerances: Tolerances) -> Run:
    """One call of `simulate`, and the beginnings of contacts from its regimes: the table of contacts says far more of each."""
    scene, q0, v0, span = problem.scene, np.array(problem.q0), np.array(problem.v0), (0.0, problem.end)
    rtol, atol = tolerances.relative, tolerances.absolute

    def run() -> Outcome:
        motion = vi.simulate(scene, q0, v0, span, method=method, rtol=rtol, atol=atol)
        if motion.status != "finished":
            raise RuntimeError(f"{motion.status}, {motion.message}")
        is_pressed = motion.regimes["state"] == "pressed"
        begun = (is_pressed[1:] & ~is_pressed[:-1]).sum(axis=1)
        return Outcome(np.concatenate(motion.final), np.repeat(motion.regimes["start"][1:], begun))

    return run
