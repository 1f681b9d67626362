"""The part of the page on builds that cannot have what a scene lacks."""

from __future__ import annotations

from collections.abc import Iterator

from report.cost.bare.compare import EQUAL, UNITS, Found, Pair
from report.cost.bare.copies import is_possible
from report.cost.bare.kinds import BARE, Bare
from report.page import table

METHOD = f"""\
Copies of the crate's sources are made in which parts are taken out, so that the compiler has no code for them: types and arms of
`match` are gone, fields are not read, and where a scene would need the part there is a panic. The copies and the whole crate run
the same scenes of `benches/scene_cost.rs`, which need none of it, from Rust. Both must make the same number of units and end, to
the last bit, in the same state; callgrind counts runs of about {UNITS:,} and {2 * UNITS:,} units. What is absent costs nothing
where the whole crate takes no more than {100 * EQUAL:g} % above the copy; where it takes less, the compiler has arranged the
same code better. Questions whose answer decides whether a motion is right (does this impact end in lasting contact?) are no part
that a scene could lack: they are asked in the copies too, and it is what follows on the rare answer that is taken out."""

APART = """\
With less left, the compiler would put functions into their callers that it keeps apart in the whole crate, and the comparison
would be one of such decisions: the copies are told to keep them apart."""


def lacks(bare: Bare) -> str:
    """What a build lacks."""
    parts = "; ".join(f"{part} ({len(changes)} changes)" for part, changes in bare.without.items())
    return f"- **{bare.title}**: without {parts}."


def verdict(pair: Pair) -> str:
    """The verdict on a pair."""
    if not pair.is_same:
        return "NOT THE SAME MOTION"
    return "holds" if pair.holds() else "DOES NOT HOLD"


def line(pair: Pair) -> list[str]:
    """One line of the table."""
    same = "same, to the bit" if pair.is_same else "DIFFERENT"
    numbers = [f"{pair.whole:,.1f}", f"{pair.left:,.1f}", f"{pair.whole - pair.left:+,.1f}", f"{100.0 * pair.more():+.2f} %"]
    return [pair.case, pair.bare.title, f"{pair.units:,}", same, *numbers, verdict(pair)]


def why_none(found: Found, is_quick: bool) -> str:
    """Why nothing was compared."""
    if is_quick:
        return "a quick report builds nothing; that every change still applies to the sources was looked at"
    if not is_possible():
        return "that takes a clone of the repository and cargo"
    return "a change does not apply any more" if found.faults else "that takes callgrind, and builds that succeed"


def short(found: Found) -> list[str]:
    """Lines for the top of the page."""
    hold = [pair.holds() for pair in found.pairs]
    if not hold:
        return []
    lines = [
        f"- Scenes that take at most {100 * EQUAL:g} % more in the whole crate than where it cannot have what they lack: "
        f"{sum(hold)} of {len(hold)}; the most is {100.0 * max(pair.more() for pair in found.pairs):+.2f} %."
    ]
    return lines


def broken(found: Found) -> list[str]:
    """What does not hold."""
    return [
        *(f"A CHANGE DOES NOT APPLY ANY MORE: {fault}" for fault in found.faults),
        *(f"the copy `{key}` could not be built" for key in found.failed),
        *(
            f"{pair.case}: {100.0 * pair.more():+.2f} % against {pair.bare.title}, {verdict(pair)}"
            for pair in found.pairs
            if not pair.holds()
        ),
    ]


def parts(found: Found, is_quick: bool) -> Iterator[str]:
    """The section."""
    yield "### In a build that cannot have it"
    yield METHOD
    yield "\n".join(map(lacks, BARE))
    yield APART
    if not found.pairs:
        yield f"Nothing was compared: {why_none(found, is_quick)}."
    else:
        header = ["one unit of", "in", "units", "motion", "whole crate", "without", "more", "more", "verdict"]
        yield table(header, map(line, found.pairs))
    if found.faults or found.failed:
        yield "\n".join(f"- **{each}**" for each in broken(Found((), found.faults, found.failed)))
