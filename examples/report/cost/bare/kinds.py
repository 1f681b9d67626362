"""The bare builds: what each lacks, and the scenes that are counted in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from report.cost.bare import flights, moving, steps
from report.cost.bare.change import Change


@dataclass(frozen=True)
class Bare:
    """A build without some parts, by what they are; the cases of the bench that need none of them."""

    key: str
    title: str
    without: Mapping[str, tuple[Change, ...]]
    cases: tuple[str, ...]
    apart: tuple[Change, ...] = ()

    def changes(self) -> tuple[Change, ...]:
        """Every change to the sources."""
        return (*(change for part in self.without.values() for change in part), *self.apart)


CONSTANT = "forcing and load"
KEPT = "anything kept but the state (motion, impacts, grazes, samples)"
WATCH = "the question whether to go on (Ctrl-C, progress)"
REST = "chatter and lasting contact"

BARE = (
    Bare(
        "flights",
        "exact flights alone",
        {
            f"{CONSTANT}, defective systems": flights.INPUTS,
            "damping, complex modes, real roots": flights.DAMPING,
            "simultaneous impacts of several stops": flights.SEVERAL,
            REST: flights.REST,
            KEPT: flights.KEPT,
            WATCH: flights.WATCH,
        },
        ("exact: one stop",),
        flights.APART,
    ),
    Bare(
        "steps",
        "steps alone",
        {
            CONSTANT: steps.INPUTS,
            "damping": steps.DAMPING,
            f"stops, contacts and their search; {KEPT}": steps.STOPS,
            WATCH: steps.WATCH,
        },
        ("rk45: no stop", "rk45: pendulum", "taylor: no wall"),
        steps.APART,
    ),
    Bare(
        "moving",
        "motion alone",
        {REST: moving.REST, KEPT: moving.KEPT, WATCH: moving.WATCH},
        (
            "exact: and forcing",
            "exact: and damping",
            "exact: complex, forcing",
            "exact: 4 stops",
            "rk45: 1 stop",
            "rk45: walled pendulum",
            "taylor: 1 wall",
            "taylor: base motion",
        ),
        moving.APART,
    ),
)
