"""What is absent costs nothing: the counts that are zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import vibroimpact as vi
from report.cost import scenes
from report.cost.scenes import START, pair, pendulum, stops

SPAN = (0.0, 100.0)


@dataclass(frozen=True)
class Absence:
    """A scene that lacks something, and the counts that must then be zero."""

    name: str
    run: Callable[[], vi.Trajectory]
    zero: tuple[str, ...]


def simulated(scene: vi.Scene, method: str = "auto", keep: str = "final") -> Callable[[], vi.Trajectory]:
    """A run of a scene over the span."""
    n = scene.n_dof
    return lambda: vi.simulate(scene, np.zeros(n), np.full(n, START[1][0]), SPAN, method=method, keep=keep)


def absences() -> tuple[Absence, ...]:
    """Scenes that lack something."""
    integrator, search = ("n_rhs", "n_steps"), ("n_gap_evaluations", "n_impacts")
    return (
        Absence("linear, one stop", simulated(pair(stops=stops(1))), integrator),
        Absence("linear, forced, one stop", simulated(pair(forcing=scenes.harmonic(), stops=stops(1))), integrator),
        Absence("linear, non-proportional damping, four stops", simulated(pair(scenes.OTHER, stops=stops(4))), integrator),
        Absence("linear, no stop", simulated(pair()), integrator + search),
        Absence("linear, forced, no stop", simulated(pair(forcing=scenes.harmonic())), integrator + search),
        Absence('linear, no stop, `method="rk45"`', simulated(pair(), "rk45"), search),
        Absence("double pendulum, no wall, Taylor series", simulated(pendulum()), search),
        Absence('double pendulum, no wall, `method="rk45"`', simulated(pendulum(), "rk45"), search),
    )


COUNTS = ("n_rhs", "n_steps", "n_gap_evaluations", "n_flights", "n_impacts")


def counted(absence: Absence) -> dict[str, int]:
    """Every count of a run."""
    stats = absence.run().stats
    return {name: int(getattr(stats, name)) for name in COUNTS}


def is_zero(absence: Absence, counts: dict[str, int]) -> bool:
    """Whether what is absent was not used, not once."""
    return all(counts[name] == 0 for name in absence.zero)
