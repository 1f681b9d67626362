"""The front: at each level of error, the fastest of the library's methods and the fastest of everybody else's.

An answer reaches a level if its number of impacts is right and the worse of its two errors is not above it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

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
        leads += [Lead(problem, level, fastest(own, level), fastest(peers, level)) for level in LEVELS]
    return leads
