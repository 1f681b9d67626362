"""What a scene must not spend on what it lacks: sines, memory, instructions in machinery it does not need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from report.cost.instructions import CALLS, PerUnit

# Calls per unit, and instructions per unit, that count as none: a start-up that did not cancel.
NO_CALLS, NO_INSTRUCTIONS = 0.005, 0.5
# Relative difference of two numbers of calls that count as equal: impacts do not all take the same number of looks.
ALIKE = 0.01
# Where stops are held and let go.
CHATTER = "chatter: impacts that accumulate, lasting contact, release"
STEPPED_CHATTER = 'chatter: the same, `method="rk45"`'


@dataclass(frozen=True)
class Claim:
    """What a case must not spend: nothing at all on something, or no more than another case.

    `seen`: for nothing at all, a case that has what this one lacks, in which the counter must see it.
    """

    case: str
    kind: str
    beside: str | None = None
    seen: str | None = None

    def cases(self) -> set[str]:
        """The cases that it speaks of."""
        return {name for name in (self.case, self.beside, self.seen) if name}

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

    def elsewhere(self, counts: Mapping[str, PerUnit]) -> float | None:
        """What a unit spends where it is to be seen."""
        return None if self.seen is None else counts[self.seen].spent[self.kind]

    def holds(self, counts: Mapping[str, PerUnit]) -> bool:
        """Whether it does not spend more, and more would be seen."""
        none = NO_CALLS if self.kind in CALLS else NO_INSTRUCTIONS
        elsewhere = self.elsewhere(counts)
        is_seen = elsewhere is None or elsewhere > none
        return is_seen and self.made(counts) <= self.allowed(counts) * (1.0 + ALIKE) + none


def transcendental() -> list[Claim]:
    """Sines of what is not there; those of exact flights are the library's own, in its loops, and no calls."""
    sines = "sine, cosine"
    return [
        *(Claim(name, sines, seen="rk45: forcing") for name in ("rk45: no stop", "rk45: damping", "rk45: a stop")),
        *(Claim(f"taylor: {name}", sines, "taylor: no wall") for name in ("joint dampers", "a wall that is never reached")),
    ]


def memory() -> list[Claim]:
    """Memory where nothing is kept."""
    exact = ("one stop", "forcing", "non-proportional damping", "a fourth stop")
    stepped = ("rk45: no stop", "rk45: forcing", "rk45: a stop", "taylor: no wall", "taylor: base motion", "taylor: a wall")
    called = ("callable: the library's own `LinearSystem`", "callable: C, by its address")
    names = (*(f"exact: {name}" for name in exact), *stepped, *called)
    return [Claim(name, "allocation", seen='exact: keep="motion"') for name in names]


def machinery() -> list[Claim]:
    """Machinery of what is not there; that of forcing in steps has no functions of its own to be seen in."""
    stepped = {"search for contacts": "{}", "impacts": "{}", "release of held stops": STEPPED_CHATTER}
    lacks = {
        "exact: one stop": {
            "integrator": "rk45: no stop",
            "load or forcing": "exact: constant load",
            "release of held stops": CHATTER,
        },
        "exact: forcing": {"integrator": "rk45: no stop"},
        "rk45: no stop": {kind: seen.format("rk45: a stop") for kind, seen in stepped.items()},
        "rk45: a stop": {"release of held stops": STEPPED_CHATTER},
        "taylor: no wall": {kind: seen.format("taylor: a wall") for kind, seen in stepped.items()},
        "taylor: a wall": {"release of held stops": STEPPED_CHATTER},
    }
    return [Claim(case, kind, seen=seen) for case, kinds in lacks.items() for kind, seen in kinds.items()]


def checked(counts: Mapping[str, PerUnit]) -> list[tuple[Claim, float, float, float | None, bool]]:
    """Each claim whose cases were counted: what is allowed, what is spent, what is where it is seen, and whether it holds."""
    known = (claim for claim in (*transcendental(), *memory(), *machinery()) if claim.cases() <= counts.keys())
    return [(c, c.allowed(counts), c.made(counts), c.elsewhere(counts), c.holds(counts)) for c in known]
