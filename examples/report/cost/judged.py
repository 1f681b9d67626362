"""A series with its fits and verdicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from report.cost.growth import Series
from report.cost.laws import SLACK_OF_COUNTS, SLACK_OF_TIMES, Fit, fitted, law, verdict
from report.cost.measure import Point
from report.cost.memory import LEAST
from report.cost.tables import number, whole
from report.page import table

# Sizes to which a law is fitted: peaks of memory have next to no noise.
FEWEST, FEWEST_OF_MEMORY = 3, 2
TOO_FEW = "too few sizes"


@dataclass(frozen=True)
class Judged:
    """A series, its points, and the laws fitted to them; None where too few sizes are known."""

    series: Series
    points: Sequence[Point]
    times: Fit | None
    counts: Fit | None
    memory: Fit | None

    def verdict(self) -> str:
        """The verdict on the cost of a unit: by instructions where they are counted."""
        if self.counts:
            return verdict(self.counts, self.series.power, SLACK_OF_COUNTS)
        return verdict(self.times, self.series.power, SLACK_OF_TIMES) if self.times else TOO_FEW

    def verdict_on_memory(self) -> str:
        """The verdict on the peak memory."""
        if self.memory:
            return verdict(self.memory, self.series.memory, SLACK_OF_TIMES)
        known = [point.memory for point in self.points if point.memory is not None]
        if not known:
            return "not measured"
        return "holds" if max(known) < LEAST else TOO_FEW


def fit_of(costs: dict[int, float], fewest: int) -> Fit | None:
    """The law of enough sizes."""
    return fitted(costs) if len(costs) >= fewest else None


def judge(series: Series, points: Sequence[Point]) -> Judged:
    """Fit what is known."""
    times = {point.size: point.nanoseconds for point in points}
    counts = {point.size: point.counted.instructions for point in points if point.counted}
    memory = {point.size: point.memory for point in points if point.memory is not None and point.memory >= LEAST}
    return Judged(series, points, fit_of(times, FEWEST), fit_of(counts, FEWEST), fit_of(memory, FEWEST_OF_MEMORY))


def power(fit: Fit | None) -> str:
    """A fitted exponent."""
    return "" if fit is None else f"{fit.power:.2f}"


def summary(judged: Sequence[Judged]) -> str:
    """One line for each series."""
    header = ["cost of a unit", "stated", "by instructions", "by time", "verdict", "memory", "fitted", "verdict"]

    def line(one: Judged) -> list[str]:
        s = one.series
        laws = [law(s.power, s.size), power(one.counts), power(one.times), one.verdict()]
        return [f"{s.title}: one {s.unit}", *laws, law(s.memory, s.size), power(one.memory), one.verdict_on_memory()]

    return table(header, map(line, judged))


def memory(value: float | None) -> str:
    """Peak memory of a run."""
    if value is None:
        return "not measured"
    return number(value) if value >= LEAST else f"below {LEAST:g}"


def values(judged: Judged) -> str:
    """The values of one series."""
    series = judged.series
    header = [series.size, f"one {series.unit} [us]", "instructions", "memory of the run [MiB]"]

    def line(point: Point) -> list[str]:
        count = point.counted.instructions if point.counted else None
        return [f"{point.size:,}", number(point.nanoseconds / 1000.0), whole(count, ""), memory(point.memory)]

    return table(header, map(line, judged.points))
