"""The page: what was measured, by which rules, and what came out."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence

from report.cost import frugal, judged, laws, periods, tables
from report.cost.absent import Absence, Likeness, is_zero
from report.cost.bare import words as bare
from report.cost.bare.compare import Found
from report.cost.bare.copies import is_possible
from report.cost.callables import available
from report.cost.case import Group
from report.cost.instructions import MARK, PerUnit
from report.cost.judged import Judged
from report.cost.measure import Row
from report.cost.memory import LEAST
from report.page import table

Measured = Sequence[tuple[Group, Sequence[Row]]]
Counts = Sequence[tuple[Absence, dict[str, int]]]
Likenesses = Sequence[tuple[Likeness, tuple[dict[str, int], dict[str, int], bool]]]
Claims = Sequence[tuple[frugal.Claim, float, float, float | None, bool]]
EQUAL = 0.01
# Groups whose cases are no additions to the first.
APART = ("reading",)

TIMES = """\
**Times** are medians over rounds in which all cases of a table take turns, so that a slow moment of the machine falls on all of
them; what a case adds is the median of the differences within a round, ± half of what lies between the quartiles of these. What
is within that is not told from chance: instructions say more. They are those of calls from Python, on one core, with so many
units that the call itself does not count."""

SAME_MOTION = """\
Forces, loads and damping that a feature adds are of relative size 1e-9: the motion, the impacts and the search for them stay
the same, and what differs is the machinery. Further stops are out of reach."""


def counting(counter: str | None, quick: bool) -> str:
    """How instructions were counted, or why not."""
    if counter is None:
        why = "a quick report counts none" if quick else "callgrind is not installed here"
        return f"**Instructions** were not counted: {why}."
    return (
        f"**Instructions** are counted by callgrind ({counter}) in one process that runs every case; the counts are written out "
        f"and reset whenever it calls `{MARK}`, which it does between runs. A run of about 2 N units less one of N units leaves "
        "the instructions of a unit: start-up and the call fall out. They do not depend on how busy the machine is; what looks "
        "at the clock (whether to look for Ctrl-C) and at addresses leaves differences of about 0.1 %."
    )


def verdicts(found: Sequence[Judged], counts: Counts, alike: Likenesses, claims: Claims, builds: Found) -> str:
    """How many verdicts hold, and which do not."""
    same = [is_same for _, (*_, is_same) in alike]
    zero = [is_zero(absence, numbers) for absence, numbers in counts]
    hold = [holds for *_, holds in claims]
    laws_hold = [verdict == "holds" for one in found for verdict in (one.verdict(), one.verdict_on_memory())]
    broken = [
        *(f"{absence.name}: counts that must be zero are not" for absence, numbers in counts if not is_zero(absence, numbers)),
        *(f"{likeness.name}: not as a scene of rigid stops" for likeness, (*_, is_same) in alike if not is_same),
        *(f"{c.case}: {made:.3g} {c.what()} in a unit, may be {c.words()}" for c, _, made, _, holds in claims if not holds),
        *bare.broken(builds),
        *(f"{one.series.title}: {one.verdict()}" for one in found if one.verdict() != "holds"),
        *(f"{one.series.title}, memory: {one.verdict_on_memory()}" for one in found if one.verdict_on_memory() != "holds"),
    ]
    lines = [
        f"- Scenes whose counts are zero where they must be: {sum(zero)} of {len(zero)}.",
        f"- Laws of contact that never act leave every count and every bit as they are: {sum(same)} of {len(same)} scenes.",
        *([f"- Claims that nothing is spent on what is absent: {sum(hold)} of {len(hold)} hold."] if hold else []),
        *bare.short(builds),
        f"- Laws of growth, of cost and of memory: {sum(laws_hold)} of {len(laws_hold)} hold.",
    ]
    if broken:
        lines += ["- What does not hold, or could not be judged:", *(f"  - {each}" for each in broken)]
    return "\n".join(lines)


def composition() -> str:
    """What a period of the ball that chatters is made of."""
    kept = periods.of_chatter()
    parts = ", ".join(f"{kept.kinds[kind]:.2f} of kind `{kind}`" for kind in sorted(kept.kinds))
    return f"A period of the second kind has {kept.impacts:.1f} impacts on average, and segments: {parts}."


def short(measured: Measured) -> str:
    """The numbers to remember."""
    rows = {f"{group.key}: {row.name}": row for group, found in measured for row in found}

    def cost(name: str, unit: str) -> str:
        counted = tables.instructions(rows[name])
        told = "" if counted is None else f", {counted:,.0f} instructions"
        return f"- {unit}: {tables.number(rows[name].nanoseconds)} ns{told}."

    def factor(row: Row, base: Row) -> str:
        more, counted = tables.more(row, base), tables.instructions(base)
        ratio = row.added / base.nanoseconds if more is None or counted is None else more / counted
        return f"{row.name} {1.0 + ratio:.3g} times"

    users = next(found for group, found in measured if group.key == "callable")
    by = "instructions" if tables.instructions(users[0]) is not None else "time"
    factors = ", ".join(factor(row, users[0]) for row in users[1:])
    return "\n".join(
        [
            cost("exact: one stop", "An impact of an exact flight, two masses, one stop"),
            cost("rk45: no stop", "A Runge-Kutta step of the same masses, no stop"),
            cost("taylor: no wall", "A step along the Taylor series of a double pendulum"),
            f"- A user's right-hand side, against the library's own, in {by}: {factors}.",
        ]
    )


def feature_parts(measured: Measured) -> Iterator[str]:
    """The tables of the features."""
    yield "## What a feature adds"
    yield SAME_MOTION
    yield "![Cost of an impact and of a step with each feature](scene_cost_features.png)"
    for group, rows in measured:
        yield f"### {group.title}"
        if group.key == "callable" and "C, by its address" not in available():
            yield "No C compiler was found: the C function is left out."
        yield tables.plain(group, rows) if group.key in APART else tables.features(group, rows)
        if group.key == "chatter":
            yield composition()
    yield "### A call from Python"
    yield (
        "The shortest call: arguments checked, modes found where there are any, buffers made, one unit run, the result handed "
        "over; and the instructions that such a call takes beside its units. From Rust the result is handed over as it is."
    )
    yield tables.fixed([(group, rows) for group, rows in measured if group.key in ("exact", "rk45", "taylor", "callable")])


def rust_parts(measured: Measured, quick: bool) -> Iterator[str]:
    """The same scenes from Rust."""
    yield "### From Python and from Rust"
    if not any(row.rust for _, rows in measured for row in rows):
        failed = "it failed" if is_possible() else "that takes a clone of the repository and cargo"
        yield f"`cargo bench --bench scene_cost` told nothing: {'a quick report builds nothing' if quick else failed}."
        return
    yield (
        "`cargo bench --bench scene_cost` runs the same scenes in a build of the crate that cannot have Python, threads or "
        "Ctrl-C. What a unit takes beyond that is what those cost, or the compiler's other arrangement of the same code; the "
        f"last column is what looking at the clock takes. Instruction counts within {100 * EQUAL:g} % are equal. The times are "
        "those of two processes, one after the other: where they are apart and the instructions are not, the machine was."
    )
    yield tables.against_rust(measured)
    pairs = [(tables.instructions(row), row.rust.instructions) for _, rows in measured for row in rows if row.rust]
    known = [abs(own / rust - 1.0) for own, rust in pairs if own and rust]
    if known:
        equal = sum(apart <= EQUAL for apart in known)
        yield f"Equal: {equal} of {len(known)}; the largest difference is {100 * max(known):.1f} %."


def claim_parts(claims: Claims) -> Iterator[str]:
    """Claims that nothing is spent on what is absent."""
    yield (
        "What `stats` does not count is read off callgrind: calls of the C library within a unit, and instructions within those "
        "functions of the library that serve what is absent (code that the compiler has put into other functions is not seen). "
        f"Fewer than {frugal.NO_CALLS:g} calls, or {frugal.NO_INSTRUCTIONS:g} instructions, per unit are none; numbers of calls "
        f"within {100 * frugal.ALIKE:g} % are as many. That the counter sees what must be none is shown by a case that has it."
    )
    header = ["case", "counted", "may be", "that is", "is", "in a case that has it", "that is", "verdict"]
    yield table(
        header,
        [
            [
                claim.case,
                claim.what(),
                claim.words(),
                f"{allowed:.2f}",
                f"{made:.2f}",
                claim.seen or "",
                "" if seen is None else f"{seen:.2f}",
                "holds" if holds else "DOES NOT HOLD",
            ]
            for claim, allowed, made, seen, holds in claims
        ],
    )


def absent_parts(
    measured: Measured, counts: Counts, alike: Likenesses, claims: Claims, builds: Found, quick: bool
) -> Iterator[str]:
    """What is absent costs nothing."""
    yield "## What is absent costs nothing"
    yield "`trajectory.stats` counts what ran. What a scene lacks must not have run once."
    yield tables.absent(counts)
    yield "A scene of rigid stops pays nothing for laws of contact that no stop of it has, nor for one that never acts:"
    yield tables.alike(alike)
    if claims:
        yield from claim_parts(claims)
        yield "Everything that was looked at:"
        yield tables.calls([(group, rows) for group, rows in measured if group.key in ("exact", "rk45", "taylor", "callable")])
    yield from bare.parts(builds, quick)
    yield from rust_parts(measured, quick)


def threads(found: Sequence[Judged]) -> Iterator[str]:
    """What a second worker gains."""
    last = {one.series.key: one.points[-1] for one in found}
    alone, both = last["ensemble 1"], last["ensemble 2"]
    yield (
        f"With two workers a trajectory of {alone.size:,} takes {alone.nanoseconds / both.nanoseconds:.2f} times less than with "
        f"one; {os.cpu_count()} cores were there, and nothing is known of what else ran on them."
    )


def growth_parts(found: Sequence[Judged]) -> Iterator[str]:
    """How cost grows."""
    yield "## How cost grows"
    yield f"The rule: {laws.RULE}"
    yield (
        "Memory is what the peak of a process rises by when it runs a size after the smallest of the series; less than "
        f"{LEAST:g} MiB is not told from chance, and no law is fitted to it."
    )
    yield "![Cost and memory against each size](scene_cost_growth.png)"
    yield judged.summary(found)
    for one in found:
        s = one.series
        yield f"### {s.title}"
        yield f"Stated: one {s.unit} costs {laws.law(s.power, s.size)} at most, for {s.reason}."
        yield judged.values(one)
    yield from threads(found)


def page(
    measured: Measured,
    found: Sequence[Judged],
    counts: Counts,
    alike: Likenesses,
    counted: Mapping[str, PerUnit],
    builds: Found,
    counter: str | None,
    quick: bool,
) -> list[str]:
    """Every part of the page."""
    claims = frugal.checked(counted)
    return [
        short(measured),
        TIMES,
        counting(counter, quick),
        verdicts(found, counts, alike, claims, builds),
        *feature_parts(measured),
        *absent_parts(measured, counts, alike, claims, builds, quick),
        *growth_parts(found),
    ]
