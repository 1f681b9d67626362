"""Where a contestant starts again after an impact: a little in front of the stop.

A located contact may lie behind the stop by its own tolerance. A solver that looks for a change of sign of the gap then starts
with a gap below zero: it misses a contact that follows within its first step, or takes the way out for another impact. So its
driver opens the gap to a distance far below every tolerance.
"""

from __future__ import annotations

from .equations import gap, normal
from .formulas import Traced, traced
from .problems import Problem

OPEN = 1e-14  # gap after an impact, in the units of the problems


def opening(problem: Problem, stop: int, wanted: float = OPEN) -> tuple[int, Traced]:
    """A coordinate, and its change, of (t, q), that sets the gap to a value (a curved one up to a product of small numbers)."""
    scene = problem.scene
    to_gap, to_normal = gap(scene.stops[stop], scene, float), normal(scene.stops[stop], scene, float)
    leading = next(i for i, each in enumerate(to_normal(problem.q0)) if each != 0.0)
    names = ["t", *(f"q{i}" for i in range(scene.n_dof))]
    return leading, traced(lambda t, *q: [(to_gap(t, q) - wanted) / to_normal(q)[leading]], names)
