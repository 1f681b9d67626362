"""The library's own methods, each where the scene allows it."""

from __future__ import annotations

import numpy as np

import vibroimpact as vi

from ..problems import Problem
from . import Outcome, Run, Tolerances

DISTRIBUTION = "vibroimpact"


def methods(problem: Problem) -> list[str]:
    """Closed form for linear scenes, Taylor series for pendulums, Runge-Kutta for all."""
    return ["exact", "rk45"] if isinstance(problem.scene.system, vi.LinearSystem) else ["taylor", "rk45"]


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
