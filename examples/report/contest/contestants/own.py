"""The library's own methods, each where the scene allows it.

Equations of motion that a user writes are a C function: it has no series, its Jacobian is made of differences, and all kinds of
steps are tried.
"""

from __future__ import annotations

import numpy as np

import vibroimpact as vi

from ..problems import Problem
from . import Outcome, Run, Tolerances

DISTRIBUTION = "vibroimpact"


def methods(problem: Problem) -> list[str]:
    """Closed form for linear scenes, Taylor series for pendulums, Runge-Kutta for all; all steps for a user's equations."""
    system = problem.scene.system
    if isinstance(system, vi.NonlinearSystem):
        return ["rk45", "dop853", "radau", "auto"]
    return ["exact", "rk45"] if isinstance(system, vi.LinearSystem) else ["taylor", "rk45"]


def prepare(problem: Problem, method: str, tolerances: Tolerances) -> Run:
    """One call of `simulate` that keeps the impacts."""
    scene, q0, v0, span = problem.scene, np.array(problem.q0), np.array(problem.v0), (0.0, problem.end)
    rtol, atol = tolerances.relative, tolerances.absolute

    def run() -> Outcome:
        motion = vi.simulate(scene, q0, v0, span, method=method, rtol=rtol, atol=atol, keep="impacts")
        if motion.status != "finished":
            raise RuntimeError(f"{motion.status}, {motion.message}")
        return Outcome(np.concatenate(motion.final), motion.impacts["time"])

    return run
