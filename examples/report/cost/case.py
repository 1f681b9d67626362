"""A case: something whose cost is proportional to a number of units."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

# Runs about so many units and says how many there were.
Run = Callable[[int], int]


@dataclass(frozen=True)
class Case:
    """One line of a table: a name in words, what makes its run ready, how many units a timed and a counted run have."""

    name: str
    prepare: Callable[[], Run]
    timed: int = 20_000
    counted: int = 1_000


@dataclass(frozen=True)
class Group:
    """Cases beside the first of them, which has none of the features."""

    key: str
    title: str
    unit: str
    cases: tuple[Case, ...]

    def names(self) -> list[str]:
        """A name for each case that no other group has."""
        return [f"{self.key}: {case.name}" for case in self.cases]
