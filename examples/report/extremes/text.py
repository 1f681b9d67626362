"""The page: rules, summary, what is lost, and a table for each row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mpmath import mpf

from report.extremes.finding import EPSILON, FACTOR, Finding, short
from report.extremes.lost import Series
from report.extremes.motion import ATOL, MARGIN, RTOL
from report.extremes.registry import DIGITS
from report.extremes.rows import GROUPS, NEARLY_TOGETHER, PRELOADED, STIFF
from report.page import table

Rows = Mapping[str, list[Finding]]
AGREED = mpf(10) ** -30  # of references by two methods
ILL = 1e6  # condition number from which a row is called ill conditioned
HEADER = ("quantity", "method", "computed", "reference", "error", "condition", "allowed", "rule", "verdict")
# What is known of lines that fail, by their row.
WHY = {
    NEARLY_TOGETHER: """a gap below 1e-13 of its terms is closed, for rounding may leave as much after many flights. When the
  second of two coupled stops is reached, the first is open by less than that: it counts as still in contact, and both are struck
  together. The speeds are those of theory; the places are off by the width that counts as closed.""",
    STIFF: """in exact flights the place at which a body meets a stop is rounded, and a spring of frequency w makes a speed of
  that rounding times w: so much of each speed behind a contact with a dashpot is lost, and of all that comes later. Without a
  dashpot it is the square of that.""",
    PRELOADED: """exact flights are counted from the place at which the spring would be at rest, F0/k before the seat: where that
  is far, its rounding times the frequency is what the speed behind a contact is off.""",
    "T under 1e-3 of a free period": """the impulse is what a period of the steady motion leaves. Where damping is strong it
  comes from a sum whose terms are hundreds of times as large, that cancel because the motion repeats; so many roundings are
  lost.""",
}


def rules() -> str:
    """How the verdicts are made."""
    return f"""Every row is a situation that must hold; each line of its table is one quantity by one method, beside a reference
by a closed form or by {DIGITS}-digit arithmetic that takes the doubles given to the library as exact. The numbers are made by
`python examples/extreme_cases.py`.

## Rules

- *Error*: the largest difference over the largest entry of the same kind (positions, velocities, times, speeds, each a kind of
  its own); over 1 where the reference is zero. A line shows the kind that comes closest to what it is allowed, its worst entry.
- *Condition*: the largest sum over all inputs of |x df/dx|, over the same size: how many times a relative change of the inputs
  (masses, stiffnesses, forces, clearances, start, times) comes back in the answer. It is computed by differences of the
  {DIGITS}-digit reference, never by the library; that of answers which theory gives as they stand (rest, one speed kept for
  ever) is theory's, 1 or 2.
- *rounding*, for what is computed in closed form (exact flights, orbits, modes):
  error <= {FACTOR} x max(condition, 1) x {EPSILON:.1e}.
- *steps*, for what is integrated to a tolerance (`rk45`, `dop853`, `radau`, `taylor`), and for rest after infinitely many
  impacts by any method, which is completed to a tolerance: error <= {FACTOR} x max(condition, 1) x rtol. rtol is {RTOL:g} where
  a line does not say otherwise, and {MARGIN:g} for exact flights, where it is the width of contacts and touches; atol is
  {ATOL:g} rtol times the size of the motion. *steps, at each impact* allows one rtol for every impact of a long run: in steps
  errors add up, by no more than that; only exact flights are held to *rounding* there, which is to be without drift.
- *fact*: a count, an order, a status or a verdict equals the one that theory gives.
- *refusal*: bad input raises `ValueError`, and its message has the argument and the words of the rule.

Motions of one coordinate are tried by every method where no constant load acts: for `taylor` the coordinate is the angle
of a link in swings of about 1e-9 rad, where the sine is the angle to 1e-19 of it. A line that breaks its rule *fails*."""


def worst(findings: Sequence[Finding]) -> str:
    """The largest error over what it is allowed."""
    ratios = [f.error / f.allowed for f in findings if f.error is not None]
    return short(max(ratios)) if ratios else ""


def conditioned(findings: Sequence[Finding]) -> str:
    """The largest condition number."""
    numbers = [f.condition for f in findings if f.condition is not None]
    return short(max(numbers)) if numbers else ""


def verdict(findings: Sequence[Finding]) -> str:
    """Holds where every line does."""
    failed = sum(not f.holds for f in findings)
    return f"**fails** in {failed} of {len(findings)}" if failed else "holds"


def summary(rows: Rows) -> str:
    """All rows on one table, and how many hold."""
    count = sum(map(len, rows.values()))
    failed = sum(not f.holds for findings in rows.values() for f in findings)
    broken = sum(any(not f.holds for f in findings) for findings in rows.values())
    ill = [row for row, findings in rows.items() if any((f.condition or 0) > ILL for f in findings)]
    lines = [(row, len(found), worst(found), conditioned(found), verdict(found)) for row, found in rows.items()]
    return "\n\n".join(
        [
            "## Summary",
            f"{len(rows)} rows, {count} lines: {count - failed} hold and {failed} fail, in {broken} rows. Condition numbers "
            f"beyond {ILL:.0e} occur in {len(ill)} rows: {', '.join(ill)}.",
            table(("row", "lines", "largest error / allowed", "largest condition", "verdict"), lines),
        ]
    )


def failures(rows: Rows) -> str:
    """Every line that breaks its rule, and what is known of why."""
    lines = [(row, *line(f)) for row, findings in rows.items() for f in findings if not f.holds]
    if not lines:
        return "## What fails\n\nNothing."
    known = [f"- *{row}*: {WHY.get(row, 'not known.')}" for row in dict.fromkeys(row for row, *_ in lines)]
    return "\n\n".join(["## What fails", table(("row", *HEADER), lines), "\n".join(known)])


def line(f: Finding) -> tuple[str, ...]:
    """One line of a table."""
    numbers = ["" if x is None else short(x) for x in (f.error, f.condition, f.allowed)]
    return (f.quantity, f.method, f.computed, f.reference, *numbers, f.rule, "holds" if f.holds else "**fails**")


def checked(checks: Sequence[tuple[str, mpf]]) -> str:
    """The references by a second method."""
    far = [name for name, apart in checks if apart > AGREED]
    assert not far, f"references that disagree: {far}"
    lines = [(name, short(apart)) for name, apart in checks]
    words = (
        "Each kind of reference was computed twice, by methods that share no formula (double pendulums: by the same one with "
        f"more, shorter steps); they agree to better than {short(AGREED)}."
    )
    return f"## The references by a second method\n\n{words}\n\n" + table(("compared", "difference"), lines)


def soaked(soaks: Sequence[Mapping[str, str]]) -> list[str]:
    """What was compared with referees on random scenes; nothing where no soak was run."""
    if not soaks:
        return []
    words = """Random scenes, answers that are exactly zero among them, beside referees that share no line with the library: a
slow simulator in twice the precision, pendulums by extrapolated midpoint steps, orbits by brute force. A seed says which;
where two answers hang on rounding, a scene is compared up to there, and a difference that is gone in three other systems of
units (of length, time and mass) is one of rounding too: from seed 142 on these are counted apart. Each line is a soak by hand
(`VIBROIMPACT_SOAKS=docs/report/soaks.csv` before `cargo test --release`, with `VIBROIMPACT_CASES` and `VIBROIMPACT_SEED`), and
says how many disagreed then: each of those was mended, in the library or in the referee, and is among the tests since. The
tests run some hundreds of random scenes each time."""
    header = ("compared", "seed", "count", "disagree")
    return [f"## Random scenes beside a referee\n\n{words}\n\n" + table(header, [[s[key] for key in header] for s in soaks])]


def page_parts(
    rows: Rows, series: Sequence[Series], checks: Sequence[tuple[str, mpf]], soaks: Sequence[Mapping[str, str]]
) -> list[str]:
    """All parts of the page."""
    parts = [
        rules(),
        summary(rows),
        failures(rows),
        "## What is lost where the problem is ill conditioned",
        *(s.text for s in series),
    ]
    for group, names in GROUPS.items():
        parts.append(f"## {group}")
        parts += [f"### {row}\n\n{table(HEADER, map(line, rows[row]))}" for row in names]
    return [*parts, checked(checks), *soaked(soaks)]


def records(rows: Rows) -> list[dict[str, object]]:
    """All lines for the CSV."""
    return [{"row": row} | vars(f) for row, findings in rows.items() for f in findings]
