"""How cost grows: series of scenes that differ in one size."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

from report.cost.case import Case, Run
from report.cost.sized import (
    basin,
    chain,
    diagram,
    exponents,
    far_stops,
    first_held,
    many,
    modes_in_a_band,
    modes_of_a_bar,
    polygon,
    whole_run,
)


@dataclass(frozen=True)
class Series:
    """Cost of a unit against a size, and the law it should obey: `cost = const * size**power` at most."""

    key: str
    title: str
    # The title in the figure.
    label: str
    size: str
    unit: str
    power: float
    # Power of the peak memory.
    memory: float
    reason: str
    sizes: tuple[int, ...]
    # The largest size of which instructions are counted, and the largest of a quick report.
    most_counted: int
    quick: int
    # A run of a size, and the units in a timed and in a counted run.
    run: Callable[[int], Run]
    timed: Callable[[int], int]
    counted: Callable[[int], int]

    def case(self, size: int) -> Case:
        """The case of one size."""
        return Case(str(size), lambda: self.run(size), self.timed(size), self.counted(size))


def per_size(units: float, at_least: int = 2) -> Callable[[int], int]:
    """Fewer units the larger the size."""
    return lambda size: max(at_least, round(units / size))


def always(units: int) -> Callable[[int], int]:
    """The same number of units at each size."""
    return lambda size: units


def modes_series() -> tuple[Series, ...]:
    """Cost against the number of modes."""
    held = Series(
        "held",
        "Modes of a bar that is held by a stop for the first time",
        "of a bar, first lasting contact",
        "modes",
        "contact",
        3.0,
        2.0,
        "the stuck system has modes of its own, one dense eigenproblem; they are kept for all later contacts",
        (5, 10, 20, 50, 100, 200),
        50,
        50,
        first_held,
        per_size(200, 1),
        per_size(100, 1),
    )
    band = Series(
        "modes",
        "Modes in a band of frequencies",
        "in a band of frequencies",
        "modes",
        "impact",
        1.0,
        1.0,
        "each look at a gap is one sum over the modes, and the number of looks is that of one mode",
        (2, 10, 30, 100, 300, 1000, 3000, 10_000),
        10_000,
        1000,
        modes_in_a_band,
        per_size(30_000, 5),
        per_size(3_000, 5),
    )
    bar = Series(
        "bar",
        "Modes of a bar, each faster than those before",
        "of a bar",
        "modes",
        "impact",
        2.0,
        1.0,
        "the fastest mode bounds the steps proved to hold no impact: up to so many more looks, each one sum over the modes",
        (2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000),
        200,
        100,
        modes_of_a_bar,
        per_size(20_000, 20),
        per_size(2_000, 10),
    )
    return band, bar, held


def stop_series() -> tuple[Series, ...]:
    """Cost against the number of stops."""
    sizes = (1, 2, 5, 10, 20, 50, 100)
    looked = "each look is at every gap"
    walls = Series(
        "polygon",
        "Stops round a mass in the plane, every one hit",
        "every one hit, exact flights",
        "stops",
        "impact",
        1.0,
        1.0,
        looked,
        (3, 5, 10, 20, 50, 100),
        100,
        20,
        polygon,
        per_size(20_000),
        per_size(3_000, 100),
    )
    far = [
        Series(
            f"stops {method}",
            f'Stops never reached beside one that is, `method="{method}"`',
            f"out of reach, {method}",
            "stops",
            "impact",
            1.0,
            1.0,
            looked,
            sizes,
            100,
            20,
            functools.partial(far_stops, method),
            per_size(units),
            per_size(0.15 * units, 20),
        )
        for method, units in (("exact", 20_000), ("rk45", 4_000))
    ]
    return *far, walls


def length_series() -> tuple[Series, ...]:
    """Cost against the length of the run."""
    kept = {
        "final": (0.0, (100, 1000, 10_000, 100_000, 1_000_000, 10_000_000), "nothing is kept but the last state"),
        "impacts": (1.0, (100, 1000, 10_000, 100_000, 1_000_000), "one row is kept per impact"),
        "motion": (1.0, (100, 1000, 10_000, 100_000, 1_000_000), "one row and one flight are kept per impact"),
    }
    return tuple(
        Series(
            f"length {keep}",
            f'Length of the run, `keep="{keep}"`',
            f'keep="{keep}"',
            "impacts",
            "impact",
            0.0,
            memory,
            f"{reason}; an impact costs the same whenever it falls",
            sizes,
            10_000,
            100_000,
            functools.partial(whole_run, keep),
            always(1),
            always(1),
        )
        for keep, (memory, sizes, reason) in kept.items()
    )


def ensemble_series() -> tuple[Series, ...]:
    """Cost against the number of trajectories."""
    return tuple(
        Series(
            f"ensemble {workers}",
            f"Trajectories of 50 impacts at once, {workers} worker{'s' * (workers > 1)}",
            f"{workers} worker{'s' * (workers > 1)}",
            "trajectories",
            "trajectory",
            0.0,
            1.0,
            "the machinery is made once, and trajectories do not know of each other",
            (1, 10, 100, 1000, 3000, 10_000),
            100,
            1000,
            functools.partial(many, workers),
            per_size(100, 1),
            always(1),
        )
        for workers in (1, 2)
    )


def chain_series() -> tuple[Series, ...]:
    """Cost against the number of links."""
    return tuple(
        Series(
            f"chain {method}",
            f'Links of a pendulum chain, `method="{method}"`',
            method,
            "links",
            "step",
            3.0,
            2.0,
            reason,
            (2, 4, 8, 16, 32, 64),
            32,
            16,
            functools.partial(chain, method),
            per_size(units, 40),
            per_size(0.1 * units, 20),
        )
        for method, units, reason in (
            (
                "taylor",
                8_000,
                "the mass matrix is factored once a step, O(n^3); each order takes sums over pairs of links, O(n^2)",
            ),
            ("rk45", 20_000, "each evaluation of the right-hand side factors the mass matrix, O(n^3)"),
        )
    )


def family_series() -> tuple[Series, ...]:
    """Cost against the number of values of a diagram, of cells of a basin, of masses whose exponents are taken."""
    alone = [
        Series(
            key,
            title,
            label,
            "values or cells",
            unit,
            0.0,
            1.0,
            reason,
            sizes,
            100,
            100,
            run,
            per_size(most, 1),
            always(1),
        )
        for key, title, label, unit, reason, sizes, run, most in (
            (
                "family diagram",
                "Values of a bifurcation diagram",
                "values of a diagram",
                "value",
                "each value goes on where the one before has ended, and has as many points",
                (10, 30, 100, 300, 1000, 3000),
                diagram,
                300,
            ),
            (
                "family basin",
                "Cells of a basin",
                "cells of a basin",
                "cell",
                "no cell knows of another",
                (10, 100, 1000, 10_000, 100_000),
                basin,
                3000,
            ),
        )
    ]
    deviations = Series(
        "exponents",
        "Lyapunov exponents of a chain of masses",
        "all exponents, a chain",
        "masses",
        "impact",
        3.0,
        2.0,
        "twice as many deviations as masses are made orthogonal to each other, O(n^3)",
        (1, 2, 4, 8, 16, 32, 64),
        32,
        16,
        exponents,
        per_size(4000, 60),
        per_size(300, 20),
    )
    return *alone, deviations


@functools.cache
def series() -> tuple[Series, ...]:
    """Every series."""
    return (*modes_series(), *stop_series(), *length_series(), *ensemble_series(), *chain_series(), *family_series())
