"""Condition of a problem: the largest factor by which a relative change of the start grows up to the end.

Changes are measured in the motion's own scale, positions by the largest position, velocities by the largest velocity. The
derivatives are central differences of the library's finest runs.
"""

from __future__ import annotations

import numpy as np

import vibroimpact as vi

from .problems import Ensemble, Problem

STEP = 1e-6  # of the scale: shallow contacts of 3e-6 are not lost


def final_state(problem: Problem, start: np.ndarray) -> np.ndarray:
    """State at the end of the library's finest run from a start."""
    n = problem.scene.n_dof
    run = vi.simulate(problem.scene, start[:n], start[n:], (0.0, problem.end), rtol=1e-14, atol=1e-16, keep="final")
    return np.concatenate(run.final)


def condition(problem: Problem, scale: np.ndarray) -> float:
    """Largest entry of the scaled derivative of the final state by the start; of many starts, the median of the sample."""
    if isinstance(problem, Ensemble):
        return float(np.median([condition(problem.member(i), scale) for i in problem.sample]))
    columns = []
    for i, size in enumerate(scale):
        change = np.zeros_like(scale)
        change[i] = STEP * size
        difference = final_state(problem, problem.start + change) - final_state(problem, problem.start - change)
        columns.append(np.abs(difference / scale).max() / (2.0 * STEP))
    return float(max(columns))
