"""The README's block on the report: its first figure and three numbers, read from the report's table of points."""

from __future__ import annotations

import csv
from pathlib import Path
from statistics import median

from .front import OWN, front, is_ahead_at_worst
from .measure import BASE, Point, base_of

LEVEL = 1e-9
NUMBERS = (
    "n_impacts",
    "state_error",
    "time_error",
    "preparation",
    "first_call",
    "seconds",
    "ratio",
    "rtol",
    "share",
    "median_error",
    "spread",
)


def read(path: Path) -> list[Point]:
    """Points of a table written before."""
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return [Point(**{key: number(value) if key in NUMBERS else value for key, value in row.items()}) for row in rows]


def number(text: str) -> float | None:
    """A number, None for an empty cell."""
    return float(text) if text else None


def block(points: list[Point]) -> str:
    """The figure and the three numbers."""
    leads = front(points)
    reached = [lead for lead in leads if lead.is_reached]
    ahead = sum(not lead.is_lost for lead in reached)
    ratios = [lead.ratio for lead in leads if lead.ratio is not None]
    surely = sum(is_ahead_at_worst(lead, points) for lead in reached)
    problems = dict.fromkeys(point.problem for point in points)
    bases = {name: base_of([p for p in points if p.problem == name]) for name in problems}
    right = {name: base for name, base in bases.items() if base and base.verdict == "right"}
    times = [right[x.problem].seconds / x.own.seconds for x in leads if x.level == LEVEL and x.own and x.problem in right]
    ball = [p for p in points if p.problem == "ball" and not p.verdict.startswith("not tried")]
    here, elsewhere = (share_right([p for p in ball if (p.package == OWN) is mine]) for mine in (True, False))
    lines = [
        "![Error of the final state against run time, every problem](docs/report/figures/error_vs_runtime.png)",
        "",
        f"- At {ahead} of {len(reached)} pairs of problem and error level (1e-3 to 1e-12) nobody is faster ({surely} if peers",
        "  may have any tolerance between those tried); where peers get there at all, the fastest takes",
        f"  {plain(median(ratios))} times as long (median; at worst {plain(min(ratios))}).",
        f"- To an error of {LEVEL:g}: {plain(median(times))} times as fast (median) as `{BASE[1]}` of `scipy.integrate` at",
        f"  rtol {BASE[2]:g}, in the {len(right)} of {len(problems)} problems that it gets right in time.",
        f"- A bouncing ball to rest: right in {here} runs here, elsewhere in {elsewhere}.",
        "",
        "[Every problem, rule and number](docs/report/error_vs_runtime.md), made by `python examples/error_vs_runtime.py`.",
    ]
    return "\n".join(["", *lines, ""])


def share_right(points: list[Point]) -> str:
    """How many of some answers were right."""
    return f"{sum(point.verdict == 'right' for point in points)} of {len(points)}"


def plain(number: float) -> str:
    """A number of two digits."""
    return f"{float(f'{number:.2g}'):g}"
