"""Times and instructions of the cases, as rows of a table."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median, quantiles

from report.cost.case import Case, Group
from report.cost.crate import Measured
from report.cost.growth import Series
from report.cost.instructions import PerUnit
from report.timing import interleaved, seconds


@dataclass(frozen=True)
class Row:
    """The cost of a unit of a case, from Rust too where it is known, and what it adds to the first case of its group.

    `doubt`: half of what lies between the quartiles of what it adds in each round.
    """

    name: str
    nanoseconds: float
    added: float
    doubt: float
    call: float
    counted: PerUnit | None
    rust: Measured | None


@dataclass(frozen=True)
class Point:
    """The cost of a unit at one size."""

    size: int
    nanoseconds: float
    counted: PerUnit | None
    memory: float | None


def per_unit_times(cases: Mapping[str, Case], rounds: int, least: float) -> dict[str, list[float]]:
    """Nanoseconds of a unit of each case, one for each round; the cases take turns."""
    runs = {name: case.prepare() for name, case in cases.items()}
    units = {name: run(cases[name].timed) for name, run in runs.items()}
    actions = {name: functools.partial(run, cases[name].timed) for name, run in runs.items()}
    times = interleaved(actions, rounds, least)
    return {name: [1e9 * t / units[name] for t in each] for name, each in times.items()}


def shortest_call(case: Case, rounds: int) -> float:
    """Microseconds of a call with about one unit."""
    run = case.prepare()
    run(1)
    return 1e6 * median(seconds(functools.partial(run, 1), 20) for _ in range(rounds))


def rows(group: Group, rounds: int, counts: Mapping[str, PerUnit], rust: Mapping[str, Measured]) -> list[Row]:
    """The rows of a group."""
    cases = dict(zip(group.names(), group.cases, strict=True))
    times = per_unit_times(cases, rounds, 2e-3)
    base = times[group.names()[0]]

    def row(name: str, case: Case) -> Row:
        more = [t - b for t, b in zip(times[name], base, strict=True)]
        low, _, high = quantiles(more, n=4, method="inclusive")
        call = shortest_call(case, rounds)
        return Row(case.name, median(times[name]), median(more), 0.5 * (high - low), call, counts.get(name), rust.get(name))

    return [row(name, case) for name, case in cases.items()]


def points(
    series: Series, sizes: Sequence[int], rounds: int, counts: Mapping[str, PerUnit], memory: Mapping[str, float]
) -> list[Point]:
    """The points of a series; the sizes take turns."""
    names = {f"{series.key} {size}": size for size in sizes}
    times = per_unit_times({name: series.case(size) for name, size in names.items()}, rounds, 2e-3)
    return [Point(size, median(times[name]), counts.get(name), memory.get(name)) for name, size in names.items()]
