"""The front: at each level of error, the fastest of the library's methods and the fastest of everybody else's.

An answer reaches a level if its number of impacts is right and the worse of its two errors is not above it. A peer has its
fastest point there. The library has the loosest tolerance of each method that gets there: where a tolerance changes nothing, as
with exact flights, the fastest of many like runs would be picked by chance.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from .measure import Point

LEVELS = tuple(10.0**-k for k in range(3, 13))
OWN = "own"


@dataclass(frozen=True)
class Lead:
    """Who leads at one level of one problem: the fastest of the library's points and of the peers'."""

    problem: str
    level: float
    own: Point | None
    peer: Point | None

    @property
    def ratio(self) -> float | None:
        """How many times as long the fastest peer takes, None where either is missing."""
        return self.peer.seconds / self.own.seconds if self.own and self.peer else None

    @property
    def leader(self) -> str:
        """Name of the fastest."""
        if self.own is None or self.peer is None:
            return next((label(point) for point in (self.own, self.peer) if point), "nobody")
        return label(self.own if self.own.seconds <= self.peer.seconds else self.peer)

    @property
    def is_reached(self) -> bool:
        """Whether anybody reaches the level."""
        return self.own is not None or self.peer is not None

    @property
    def is_lost(self) -> bool:
        """Whether a peer is faster, or alone there."""
        return self.peer is not None and (self.own is None or self.peer.seconds < self.own.seconds)


def label(point: Point) -> str:
    """How a point is named in lists."""
    return f"{point.method} (this library)" if point.package == OWN else point.name


def fastest(points: Iterable[Point], level: float) -> Point | None:
    """The fastest point that reaches a level."""
    return min((p for p in points if p.seconds is not None and p.error <= level), key=lambda p: p.seconds, default=None)


def front(points: Sequence[Point]) -> list[Lead]:
    """Leads of every problem at every level."""
    leads = []
    for problem in dict.fromkeys(point.problem for point in points):
        here = [point for point in points if point.problem == problem]
        own, peers = [p for p in here if p.package == OWN], [p for p in here if p.package != OWN]
        for level in LEVELS:
            mine = [found for each in methods(own) if (found := loosest(each, level))]
            leads.append(Lead(problem, level, fastest(mine, level), fastest(peers, level)))
    return leads


def methods(points: Iterable[Point]) -> list[list[Point]]:
    """Points of each method, from the loosest tolerance on."""
    found: dict[str, list[Point]] = {}
    for point in points:
        found.setdefault(point.name, []).append(point)
    return [sorted(each, key=lambda p: -p.rtol) for each in found.values()]


def between(points: Sequence[Point], level: float) -> Iterator[float]:
    """Times at which one method would reach a level between two of its tolerances, by the line between them, both logarithmic."""
    for coarse, fine in pairwise(points):
        if 0.0 < fine.error <= level < coarse.error < math.inf:
            part = math.log(coarse.error / level) / math.log(coarse.error / fine.error)
            yield coarse.seconds * (fine.seconds / coarse.seconds) ** part


def loosest(points: Sequence[Point], level: float) -> Point | None:
    """The loosest tolerance of one method that reaches a level; its points stand in that order."""
    return next((p for p in points if p.seconds is not None and p.error <= level), None)


def is_ahead_at_worst(lead: Lead, points: Sequence[Point]) -> bool:
    """Whether the library leads if a peer has any tolerance between two of its own, too."""
    if lead.own is None or lead.is_lost:
        return False
    peers = [point for point in points if point.problem == lead.problem and point.package != OWN]
    return all(lead.own.seconds <= t for each in methods(peers) for t in between(each, lead.level))
