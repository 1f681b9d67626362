"""What becomes of a motion beyond a boundary."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core
from vibroimpact._numbers import shown
from vibroimpact._results import ArrayResult
from vibroimpact.attractors import Attractor, find_attractors
from vibroimpact.branch import continuation
from vibroimpact.special import Candidate, Special

__all__ = ["Beyond", "look_beyond"]

#: The kinds of special points that are boundaries.
BOUNDARIES = ("graze", "lost_impact", "corner", "chatter_border", "landing_border", "rise", "release_border")

#: How a motion may go on.
OUTCOMES = ("continues", "nonsmooth_fold", "jumps")

#: A kick in parts of the motion's size, and the box of starts in which it is looked for, in its sizes.
_KICK = 1e-6
_BOX = 10.0


@dataclass(frozen=True, eq=False)
class Beyond(ArrayResult):
    """What becomes of a motion beyond a boundary.

    Attributes
    ----------
    outcome : {"continues", "nonsmooth_fold", "jumps"}
        A stable orbit on another branch goes on beyond the boundary; the branch meets one that is not stable and both end; or
        neither.
    candidates : tuple of Candidate
        The branches that meet it there, as ``Special.branches`` has them.
    attractor : Attractor or None
        Unless it continues what a simulation comes to, which begins next to the orbit, beyond the boundary.
    reason : str
        How that was found, with the distance from the boundary and the length of the simulation.
    """

    outcome: str
    candidates: tuple[Candidate, ...]
    attractor: Attractor | None
    reason: str

    def __post_init__(self) -> None:
        """Refuse what is none."""
        object.__setattr__(self, "candidates", tuple(self.candidates))
        self._check_types({"outcome": str, "attractor": (Attractor, type(None)), "reason": str})
        if self.outcome not in OUTCOMES:
            message = f"outcome is {self.outcome!r}, but it must be one of {OUTCOMES}"
            raise ValueError(message)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return its numbers as arrays, for ``numpy.savez``."""
        return {"candidates": np.array([[own.parameter, own.side] for own in self.candidates])}

    def __repr__(self) -> str:
        """Say what happens."""
        to = "" if self.attractor is None else f", to {self.attractor!r}"
        return f"Beyond({self.outcome}{to}: {self.reason})"


def look_beyond(special: Special, delta: float | None, periods: int, rng: int | np.random.Generator) -> Beyond:
    """Say what becomes of a motion beyond a boundary; documented at ``Special.beyond``."""
    if special.kind not in BOUNDARIES:
        message = f"special is {shown(special)}, but beyond is asked of a boundary: {', '.join(BOUNDARIES)}"
        raise ValueError(message)
    if special.parameter_name == "energy":
        message = f"special is {shown(special)}, of motions that keep their energy: they settle on nothing beyond it"
        raise ValueError(message)
    low, high = special.between
    delta = 1e-3 * (high - low) if delta is None else float(_core._numbers("delta", delta))
    if not (np.isfinite(delta) and delta > 0.0):
        message = f"delta is {delta}, but it must be above 0"
        raise ValueError(message)
    if not isinstance(periods, int) or isinstance(periods, bool) or periods < 1:
        message = f"periods is {periods!r}, but it must be at least 1"
        raise ValueError(message)
    candidates = tuple(special.branches())
    far = 1 if special.direction[-1] >= 0.0 else -1
    value = special.parameter + far * delta
    if any(own.side == far and _goes_on(special, own, value) for own in candidates):
        return Beyond("continues", candidates, None, f"a stable orbit goes on at {value:.10g}")
    met = any(own.side == -far and own.is_admissible and own.is_stable is False for own in candidates)
    attractor, reason = _settled(special, value, periods, rng)
    return Beyond("nonsmooth_fold" if met else "jumps", candidates, attractor, reason)


def _goes_on(special: Special, candidate: Candidate, value: float) -> bool:
    """Whether a candidate is followed to a value at which it is stable and keeps the rules of contact."""
    if candidate.is_admissible is False:
        return False
    between = (min(special.parameter, value), max(special.parameter, value))
    if not between[0] <= candidate.parameter <= between[1]:
        return bool(candidate.is_stable)
    make = getattr(special, "_make", None)
    branch = continuation(candidate, special.parameter_name or make, between)  # type: ignore[arg-type]
    return any(orbit.is_stable and orbit.is_admissible for orbit in branch.at(value))


def _settled(special: Special, value: float, periods: int, rng: int | np.random.Generator) -> tuple[Attractor | None, str]:
    """Return what a simulation from the orbit of a special point comes to at a value, and how that was found."""
    orbit, make = special.orbit, getattr(special, "_make", None)
    said = f"{periods} periods from the last orbit, kicked by {_KICK:g} of its size, at {value:.10g}"
    try:
        scene = _core._scene_at(orbit.scene, special.parameter_name, make, special.parameter, value)
    except ValueError as error:
        return None, f"there is no scene at {value:.10g}: {error}"
    t = np.linspace(0.0, orbit.period, 65)
    q, v = orbit.position(t), orbit.velocity(t)
    sizes = np.concatenate([np.abs(q).max(axis=0), np.abs(v).max(axis=0)])
    sizes = np.maximum(sizes, 1e-12 + 1e-3 * sizes.max())
    # From where the motion is farthest from all stops: a kick on a stop may lead into it.
    gaps = np.array([orbit.gap(stop, t) for stop in range(len(orbit.scene.stops))]).min(axis=0)
    far = int(gaps.argmax())
    kick = _KICK * sizes * np.random.default_rng(rng).uniform(-1.0, 1.0, sizes.size)
    start = np.concatenate([q[far], v[far]]) + kick
    phase = float(orbit.phase + 2.0 * np.pi * orbit.n_periods * t[far] / orbit.period)
    box = np.stack([-_BOX * sizes, _BOX * sizes], axis=1)
    try:
        found = find_attractors(scene, box, seeds=start[None], phase=phase, transient=periods, max_periods=max(2000, 2 * periods))
    except ValueError as error:
        return None, f"not simulated: {error}"
    if not found:
        return None, f"undecided after {said}"
    return found[0], said
