"""Times taken side by side: contestants in turn, call by call, so that a slow moment of the machine falls on all of them."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from statistics import median

Action = Callable[[], object]


def seconds(action: Action, repeats: int = 1) -> float:
    """Mean time of one of several calls in a row."""
    start = time.perf_counter()
    for _ in range(repeats):
        action()
    return (time.perf_counter() - start) / repeats


def repeats_for(action: Action, least: float) -> int:
    """Number of calls in a row that take at least so many seconds; the first call does not count."""
    action()
    repeats = 1
    while (took := seconds(action, repeats) * repeats) < least:
        repeats = max(2 * repeats, int(1.1 * repeats * least / max(took, 1e-9)))
    return repeats


def interleaved(actions: Mapping[str, Action], rounds: int, least: float = 2e-3) -> dict[str, list[float]]:
    """Times of each action, one per round: each round calls all of them, one after another."""
    repeats = {name: repeats_for(action, least) for name, action in actions.items()}
    times: dict[str, list[float]] = {name: [] for name in actions}
    for _ in range(rounds):
        for name, action in actions.items():
            times[name].append(seconds(action, repeats[name]))
    return times


def medians(times: Mapping[str, list[float]]) -> dict[str, float]:
    """Median time of each."""
    return {name: median(each) for name, each in times.items()}


def ratios(times: Mapping[str, list[float]], to: str) -> dict[str, float]:
    """How many times as long as another each took: the median over the rounds."""
    base = times[to]
    return {name: median(t / b for t, b in zip(each, base, strict=True)) for name, each in times.items()}
