"""What a scene must not ask of the C library: sines for what is absent, memory where nothing is kept."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from report.cost.instructions import PerUnit

# Calls per unit that count as none: a start-up that did not cancel.
NONE = 0.005
# Relative difference of two numbers of calls that count as equal: impacts do not all take the same number of looks.
ALIKE = 0.01


@dataclass(frozen=True)
class Claim:
    """Calls of one kind that a case must not make: none at all, or none beyond those of another case."""

    case: str
    kind: str
    beside: str | None

    def words(self) -> str:
        """What is claimed."""
        return "none" if self.beside is None else f"as many as {self.beside.partition(': ')[2]}"

    def allowed(self, counts: Mapping[str, PerUnit]) -> float:
        """The calls that may be made."""
        return 0.0 if self.beside is None else counts[self.beside].calls[self.kind]

    def holds(self, counts: Mapping[str, PerUnit]) -> bool:
        """Whether it does not make them."""
        allowed = self.allowed(counts)
        return counts[self.case].calls[self.kind] <= allowed * (1.0 + ALIKE) + NONE


def claims() -> list[Claim]:
    """Every claim."""
    sines, memory = "sine, cosine", "allocation"
    one = "exact: one stop"
    no_forcing = [
        "constant load",
        "proportional damping",
        "restitution below 1",
        "a second stop",
        "a fourth stop",
        'keep="motion"',
    ]
    free = ["exact: one stop", "exact: forcing", "exact: non-proportional damping", "exact: a fourth stop"]
    stepped = ["rk45: no stop", "rk45: forcing", "rk45: a stop", "taylor: no wall", "taylor: base motion", "taylor: a wall"]
    called = ["callable: the library's own `LinearSystem`", "callable: C, by its address"]
    return [
        *(Claim(f"exact: {name}", sines, one) for name in no_forcing),
        *(Claim(name, sines, None) for name in ("rk45: no stop", "rk45: damping", "rk45: a stop")),
        *(Claim(f"taylor: {name}", sines, "taylor: no wall") for name in ("joint dampers", "a wall that is never reached")),
        *(Claim(name, memory, None) for name in (*free, *stepped, *called)),
    ]


def checked(counts: Mapping[str, PerUnit]) -> list[tuple[Claim, float, bool]]:
    """Each claim whose cases were counted, with the calls that were made, and whether it holds."""
    known = (claim for claim in claims() if claim.case in counts and (claim.beside is None or claim.beside in counts))
    return [(claim, counts[claim.case].calls[claim.kind], claim.holds(counts)) for claim in known]
