"""The tables of the page."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from report.cost.absent import COUNTS, Absence, Likeness, is_zero
from report.cost.case import Group
from report.cost.instructions import CALLS, KINDS
from report.cost.measure import Row
from report.page import table

MISSING = "not counted"
# From so many times more on, a percentage says less than a factor.
MANY = 3.0
# Whose calls are shown beside those of the first case of each group.
SHORT_CALLS = (
    "exact: forcing",
    "exact: non-proportional damping",
    "exact: a fourth stop",
    'exact: keep="motion"',
    "callable: Python",
    "callable: C, by its address",
)


def number(value: float | None, missing: str = MISSING) -> str:
    """Three or four digits, without an exponent where it can be read without."""
    if value is None:
        return missing
    size = abs(value)
    return f"{value:,.0f}" if size >= 1000 else f"{value:.3g}"


def signed(value: float) -> str:
    """The same with its sign."""
    return f"{'+' if value >= 0 else '-'}{number(abs(value))}"


def whole(value: float | None, missing: str = MISSING) -> str:
    """A number of instructions."""
    return missing if value is None else f"{round(value):,}"


def instructions(row: Row) -> float | None:
    """Instructions of a unit."""
    return row.counted.instructions if row.counted else None


def more(row: Row, base: Row) -> float | None:
    """Instructions that a case adds."""
    if not (row.counted and base.counted):
        return None
    return row.counted.instructions - base.counted.instructions


def percent(part: float | None, base: float | None) -> str:
    """What is more, in percent of a base; where it is many times the base, how many times the base there are."""
    if part is None or base is None:
        return MISSING
    ratio = part / base
    return f"{1.0 + ratio:,.1f} times" if ratio >= MANY else f"{round(100.0 * ratio, 1) + 0.0:+.1f} %"


def features(group: Group, rows: Sequence[Row]) -> str:
    """What each feature adds to a unit."""
    base = rows[0]
    header = [f"one {group.unit}", "time [ns]", "more [ns]", "more", "instructions", "more", "more"]

    def line(row: Row) -> list[str]:
        if row is base:
            return [row.name, number(row.nanoseconds), "", "", whole(instructions(row)), "", ""]
        added, count = more(row, base), instructions(base)
        added_time = f"{signed(row.added)} ± {number(row.doubt)}"
        times = [number(row.nanoseconds), added_time, percent(row.added, base.nanoseconds)]
        return [row.name, *times, whole(instructions(row)), whole(added), percent(added, count)]

    return table(header, map(line, rows))


def plain(group: Group, rows: Sequence[Row]) -> str:
    """What a unit of each case takes, where none of them is a part of the others."""
    header = [f"one {group.unit}", "time [ns]", "instructions"]
    return table(header, [[row.name, number(row.nanoseconds), whole(instructions(row))] for row in rows])


def against_rust(groups: Iterable[tuple[Group, Sequence[Row]]]) -> str:
    """The same scenes from Python and from Rust."""
    clock = "clock, for Ctrl-C"
    instructed = ["Python [instructions]", "Rust [instructions]", "more", "more", f"of it {clock}"]
    header = ["the same scene", "Python [ns]", "Rust [ns]", *instructed]

    def line(group: Group, row: Row) -> list[str]:
        assert row.rust is not None
        own, other = instructions(row), row.rust.instructions
        apart = None if own is None or other is None else own - other
        numbers = [number(row.nanoseconds), number(row.rust.nanoseconds), whole(own), whole(other), whole(apart)]
        looked = whole(row.counted.spent[clock] if row.counted else None)
        return [f"{group.key}: {row.name}", *numbers, percent(apart, other), looked]

    return table(header, [line(group, row) for group, rows in groups for row in rows if row.rust])


def calls(groups: Iterable[tuple[Group, Sequence[Row]]]) -> str:
    """What a unit asks of the C library, and what it spends in the machinery of the library."""
    header = ["in one unit", *(f"calls: {kind}" if kind in CALLS else f"instructions: {kind}" for kind in KINDS)]
    return table(
        header,
        [
            [f"{group.key}: {row.name}", *(f"{row.counted.spent[kind]:.{2 if kind in CALLS else 0}f}" for kind in KINDS)]
            for group, rows in groups
            for row in rows
            if row.counted
        ],
    )


def fixed(groups: Iterable[tuple[Group, Sequence[Row]]]) -> str:
    """What a call takes whatever its length."""
    counts = ["beside its units, from Python [instructions]", "from Rust [instructions]"]
    header = ["a call of", "with one unit, from Python [us]", "from Rust [us]", *counts]

    def of_rust(row: Row) -> tuple[str, str]:
        if row.rust is None:
            return "", ""
        return number(row.rust.call), whole(row.rust.fixed)

    def line(group: Group, row: Row) -> list[str]:
        (call, count), fixed = of_rust(row), row.counted.fixed if row.counted else None
        return [f"{group.key}: {row.name}", number(row.call), call, whole(fixed), count]

    return table(
        header,
        [
            line(group, row)
            for group, rows in groups
            for row in rows
            if row is rows[0] or f"{group.key}: {row.name}" in SHORT_CALLS
        ],
    )


def alike(found: Sequence[tuple[Likeness, tuple[dict[str, int], dict[str, int], bool]]]) -> str:
    """The counts of scenes that differ by a law of contact that never acts."""

    def cell(name: str, rigid: dict[str, int], other: dict[str, int]) -> str:
        return f"{rigid[name]}" if rigid[name] == other[name] else f"{rigid[name]}, {other[name]}"

    rows = [
        [likeness.name, *(cell(name, rigid, other) for name in COUNTS), "the same" if is_same else "NOT THE SAME"]
        for likeness, (rigid, other, is_same) in found
    ]
    return table(["scene", *COUNTS, "counts and final state"], rows)


def absent(found: Sequence[tuple[Absence, dict[str, int]]]) -> str:
    """The counts of scenes that lack something."""
    header = ["scene", *COUNTS, "must be zero", "verdict"]
    return table(
        header,
        [
            [
                absence.name,
                *(counts[name] for name in COUNTS),
                ", ".join(absence.zero),
                "zero" if is_zero(absence, counts) else "NOT ZERO",
            ]
            for absence, counts in found
        ],
    )
