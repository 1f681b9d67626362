"""What a scene must not spend on what it lacks: sines, exponentials, memory, instructions in machinery it does not need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from report.cost.instructions import CALLS, PerUnit

# Calls per unit, and instructions per unit, that count as none: a start-up that did not cancel.
NO_CALLS, NO_INSTRUCTIONS = 0.005, 0.5
# Relative difference of two numbers of calls that count as equal: impacts do not all take the same number of looks.
ALIKE = 0.01


@dataclass(frozen=True)
class Claim:
    """What a case must not spend: nothing at all on something, or no more than another case."""

    case: str
    kind: str
    beside: str | None = None

    def words(self) -> str:
        """What is allowed."""
        return "none" if self.beside is None else f"as many as {self.beside.partition(': ')[2]}"

    def what(self) -> str:
        """What is counted."""
        return f"calls of {self.kind}" if self.kind in CALLS else f"instructions in {self.kind}"

    def made(self, counts: Mapping[str, PerUnit]) -> float:
        """What a unit spends."""
        return counts[self.case].spent[self.kind]

    def allowed(self, counts: Mapping[str, PerUnit]) -> float:
        """What a unit may spend."""
        return 0.0 if self.beside is None else counts[self.beside].spent[self.kind]

    def holds(self, counts: Mapping[str, PerUnit]) -> bool:
        """Whether it does not spend more."""
        none = NO_CALLS if self.kind in CALLS else NO_INSTRUCTIONS
        return self.made(counts) <= self.allowed(counts) * (1.0 + ALIKE) + none


def transcendental() -> list[Claim]:
    """Sines and exponentials of what is not there."""
    sines, one = "sine, cosine", "exact: one stop"
    free = ("constant load", "proportional damping", "restitution below 1", "a second stop", "a fourth stop", 'keep="motion"')
    return [
        *(Claim(f"exact: {name}", sines, one) for name in free),
        Claim(one, "exponential"),
        *(Claim(name, sines) for name in ("rk45: no stop", "rk45: damping", "rk45: a stop")),
        *(Claim(f"taylor: {name}", sines, "taylor: no wall") for name in ("joint dampers", "a wall that is never reached")),
    ]


def memory() -> list[Claim]:
    """Memory where nothing is kept."""
    exact = ("one stop", "forcing", "non-proportional damping", "a fourth stop")
    stepped = ("rk45: no stop", "rk45: forcing", "rk45: a stop", "taylor: no wall", "taylor: base motion", "taylor: a wall")
    called = ("callable: the library's own `LinearSystem`", "callable: C, by its address")
    return [Claim(name, "allocation") for name in (*(f"exact: {name}" for name in exact), *stepped, *called)]


def machinery() -> list[Claim]:
    """Machinery of what is not there."""
    contact = ("search for contacts", "impacts", "release of held stops")
    lacks = {
        "exact: one stop": ("integrator", "load or forcing", "release of held stops"),
        "exact: forcing": ("integrator",),
        "rk45: no stop": (*contact, "load or forcing"),
        "rk45: a stop": ("release of held stops",),
        "taylor: no wall": (*contact, "load or forcing"),
        "taylor: a wall": ("release of held stops",),
    }
    return [Claim(case, kind) for case, kinds in lacks.items() for kind in kinds]


def checked(counts: Mapping[str, PerUnit]) -> list[tuple[Claim, float, float, bool]]:
    """Each claim whose cases were counted, with what is allowed, what is spent, and whether it holds."""
    claims = (*transcendental(), *memory(), *machinery())
    known = (claim for claim in claims if {claim.case, claim.beside or claim.case} <= counts.keys())
    return [(claim, claim.allowed(counts), claim.made(counts), claim.holds(counts)) for claim in known]
