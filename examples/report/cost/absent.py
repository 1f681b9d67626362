"""What is absent costs nothing: the counts that are zero, and those that laws of contact leave as they are."""

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


@dataclass(frozen=True)
class Likeness:
    """A scene beside one of rigid stops that differs from it by a law of contact alone, which never acts."""

    name: str
    rigid: Callable[[], vi.Trajectory]
    other: Callable[[], vi.Trajectory]


def simulated(scene: vi.Scene, method: str = "auto", keep: str = "final") -> Callable[[], vi.Trajectory]:
    """A run of a scene over the span."""
    n = scene.n_dof
    return lambda: vi.simulate(scene, np.zeros(n), np.full(n, START[1][0]), SPAN, method=method, keep=keep)


def absences() -> tuple[Absence, ...]:
    """Scenes that lack something."""
    laws = ("n_contacts",)
    integrator, search = ("n_rhs", "n_steps", *laws), ("n_gap_evaluations", "n_impacts")
    return (
        Absence("linear, one stop", simulated(pair(stops=stops(1))), integrator),
        Absence("linear, forced, one stop", simulated(pair(forcing=scenes.harmonic(), stops=stops(1))), integrator),
        Absence("linear, non-proportional damping, four stops", simulated(pair(scenes.OTHER, stops=stops(4))), integrator),
        Absence("linear, no stop", simulated(pair()), integrator + search),
        Absence("linear, forced, no stop", simulated(pair(forcing=scenes.harmonic())), integrator + search),
        Absence('linear, no stop, `method="rk45"`', simulated(pair(), "rk45"), (*search, *laws)),
        Absence('linear, four stops, `method="rk45"`', simulated(pair(stops=stops(4)), "rk45"), laws),
        Absence("double pendulum, no wall, Taylor series", simulated(pendulum()), search),
        Absence('double pendulum, no wall, `method="rk45"`', simulated(pendulum(), "rk45"), search),
    )


def likenesses() -> tuple[Likeness, ...]:
    """Scenes whose stops have a law of contact: Newton's by its name, a spring out of reach in place of a rigid stop there."""
    near, far = stops(2)
    named = vi.Stop(0, near.clearance, contact=vi.Newton(1.0))
    changed = {"`Newton(1)` for a coefficient": [named, far], "a spring out of reach": [near, scenes.spring_out_of_reach()]}
    return tuple(
        Likeness(f'{name}, `method="{method}"`', simulated(pair(stops=[near, far]), method), simulated(pair(stops=other), method))
        for method in ("exact", "rk45")
        for name, other in changed.items()
    )


COUNTS = ("n_rhs", "n_steps", "n_gap_evaluations", "n_flights", "n_impacts", "n_contacts")


def counts_of(run: vi.Trajectory) -> dict[str, int]:
    """Every count of a run; of contacts there is none where no stop gives way."""
    return {name: int(getattr(run.stats, name)) for name in COUNTS}


def counted(absence: Absence) -> dict[str, int]:
    """Every count of a scene that lacks something."""
    return counts_of(absence.run())


def compared(likeness: Likeness) -> tuple[dict[str, int], dict[str, int], bool]:
    """Counts of both runs, and whether these and every bit of the final state are the same."""
    rigid, other = likeness.rigid(), likeness.other()
    counts = counts_of(rigid), counts_of(other)
    return *counts, counts[0] == counts[1] and np.array_equal(rigid.final, other.final)


def is_zero(absence: Absence, counts: dict[str, int]) -> bool:
    """Whether what is absent was not used, not once."""
    return all(counts[name] == 0 for name in absence.zero)
