"""What each part of a scene costs, that what is absent costs nothing, and how cost grows.

Each feature of a scene (forcing, damping, stops, chatter, a motion that is kept, a user's function) is timed beside the same
scene without it, and its instructions are counted where callgrind is installed. Scenes that lack something must not use its
machinery. Cost and memory are followed over modes, stops, impacts, trajectories and links, and held against a stated law.

Writes `scene_cost.md`, three CSV files and two figures. Run: python examples/scene_cost.py [--quick] [--output DIRECTORY]
"""

# sphinx_gallery_thumbnail_path = "report/scene_cost_features.png"
from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from report.cost import absent, crate, figures, memory, tables
from report.cost.bare import compare, copies
from report.cost.case import Group
from report.cost.catalogue import groups
from report.cost.growth import Series, series
from report.cost.instructions import PerUnit, counted, tool
from report.cost.judged import Judged, judge
from report.cost.measure import Row, points, rows
from report.cost.words import page
from report.page import Job, job, write_csv, write_page


@dataclass(frozen=True)
class Effort:
    """How much is measured: rounds of times, the largest sizes; and what is measured in processes apart."""

    rounds: int
    rounds_of_growth: int
    counts: Mapping[str, PerUnit]
    rust: Mapping[str, crate.Measured]
    memory: Mapping[str, float]
    builds: compare.Found
    is_quick: bool


def sizes(one: Series, is_quick: bool) -> list[int]:
    """The sizes of a series that are measured."""
    return [size for size in one.sizes if not is_quick or size <= one.quick]


def peaks(is_quick: bool) -> dict[str, float]:
    """What every size of every series adds to the peak memory."""
    return memory.added({f"{one.key} {size}": f"{one.key} {one.sizes[0]}" for one in series() for size in sizes(one, is_quick)})


def effort(task: Job) -> Effort:
    """A quick report takes few rounds, counts nothing and builds nothing."""
    if task.quick:
        return Effort(5, 5, {}, {}, peaks(True), compare.Found(faults=compare.stale()), True)
    features = [name for group in groups() for name in group.names()]
    grown = [f"{one.key} {size}" for one in series() for size in one.sizes if size <= one.most_counted]
    bench = copies.built("whole", ()) if copies.is_possible() else None
    return Effort(21, 5, counted(features + grown), crate.measured(bench), peaks(False), compare.compared(bench), False)


def feature_rows(measured: Sequence[tuple[Group, Sequence[Row]]]) -> list[dict[str, object]]:
    """One line of the CSV for each case."""

    def line(group: Group, row: Row) -> dict[str, object]:
        count, rust = row.counted, row.rust
        return {
            "group": group.key,
            "case": row.name,
            "unit": group.unit,
            "ns": row.nanoseconds,
            "added_ns": row.added,
            "instructions": count.instructions if count else "",
            "added_instructions": tables.more(row, rows_of[group.key][0]) if count else "",
            "call_us": row.call,
            "call_instructions": count.fixed if count else "",
            "rust_ns": rust.nanoseconds if rust else "",
            "rust_instructions": rust.instructions if rust else "",
            "rust_call_us": rust.call if rust else "",
            "rust_call_instructions": rust.fixed if rust else "",
            "sines": count.spent["sine, cosine"] if count else "",
            "allocations": count.spent["allocation"] if count else "",
        }

    rows_of = {group.key: found for group, found in measured}
    return [line(group, row) for group, found in measured for row in found]


def growth_rows(judged: Sequence[Judged]) -> list[dict[str, object]]:
    """One line of the CSV for each size of each series."""
    return [
        {
            "series": one.series.key,
            "size_of": one.series.size,
            "size": point.size,
            "unit": one.series.unit,
            "us": point.nanoseconds / 1000.0,
            "instructions": point.counted.instructions if point.counted else "",
            "memory_mib": "" if point.memory is None else point.memory,
            "stated_power": one.series.power,
            "power_by_time": one.times.power if one.times else "",
            "power_by_instructions": one.counts.power if one.counts else "",
            "verdict": one.verdict(),
        }
        for one in judged
        for point in one.points
    ]


def bare_rows(found: compare.Found) -> list[dict[str, object]]:
    """One line of the CSV for each scene of each bare build."""
    return [
        {
            "case": pair.case,
            "build": pair.bare.key,
            "units": pair.units,
            "is_same_motion": pair.is_same,
            "whole_instructions": pair.whole,
            "bare_instructions": pair.left,
            "more": pair.more(),
            "holds": pair.holds(),
        }
        for pair in found.pairs
    ]


def write(task: Job, much: Effort) -> Path:
    """Measure, draw and write."""
    measured = [(group, rows(group, much.rounds, much.counts, much.rust)) for group in groups()]
    judged = [
        judge(one, points(one, sizes(one, much.is_quick), much.rounds_of_growth, much.counts, much.memory)) for one in series()
    ]
    counts = [(each, absent.counted(each)) for each in absent.absences()]
    alike = [(each, absent.compared(each)) for each in absent.likenesses()]
    figures.features({group.key: (group, found) for group, found in measured}, task.output)
    figures.growth(judged, task.output)
    write_csv(task.output / "scene_cost.csv", feature_rows(measured))
    write_csv(task.output / "scene_cost_growth.csv", growth_rows(judged))
    if much.builds.pairs:
        write_csv(task.output / "scene_cost_bare.csv", bare_rows(much.builds))
    target = task.output / "scene_cost.md"
    counter = tool() if much.counts else None
    parts = page(measured, judged, counts, alike, much.counts, much.builds, counter, task.quick)
    write_page(target, "What a scene costs", parts, ("numba",))
    return target


def main() -> None:
    """Measure what is asked for and write it."""
    task = job(str(__doc__).splitlines()[0])
    much = effort(task)
    print(f"report in {write(task, much)}")
    wrong = [*much.builds.faults, *much.builds.failed]
    if wrong:
        sys.exit("the bare builds must follow the sources again:\n" + "\n".join(wrong))


if __name__ == "__main__":
    main()
