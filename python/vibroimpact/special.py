"""Special points of branches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact._core import Orbit
from vibroimpact._results import ArrayResult

__all__ = ["Special"]

#: What happens at a special point.
KINDS = ("fold", "period_doubling", "graze", "lost_impact", "corner", "chatter_border")


@dataclass(frozen=True, eq=False)
class Special(ArrayResult):
    """A special point of a branch.

    Attributes
    ----------
    kind : {"fold", "period_doubling", "graze", "lost_impact", "corner", "chatter_border"}
        The branch turns back; a multiplier passes through -1; at a boundary, where the branch ends: a stop is touched, an impact
        has lost its speed, two stops are hit at one instant, lasting contact has no duration left.
    parameter, error : float
        The number of the branch there, and how far it is known.
    arclength : float
        How far along the branch it is.
    orbit : Orbit
        The orbit there; of a boundary the last one before it.
    stop : int or None
        The stop that a boundary is about.
    time : float or None
        The time of its touch or impact [s], counted from the first impact.
    is_virtual : bool
        Whether the orbit breaks a rule of contact.
    """

    kind: str
    parameter: float
    error: float
    arclength: float
    orbit: Orbit
    stop: int | None
    time: float | None

    def __post_init__(self) -> None:
        """Refuse what is none."""
        self._check_types({"kind": str, "parameter": float, "error": float, "arclength": float, "orbit": Orbit})
        self._check_types({"stop": (int, type(None)), "time": (float, type(None))})
        if self.kind not in KINDS:
            message = f"kind is {self.kind!r}, but it must be one of {KINDS}"
            raise ValueError(message)

    @property
    def is_virtual(self) -> bool:
        """Whether the orbit breaks a rule of contact."""
        return self.orbit.is_admissible is False

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return its numbers as arrays, for ``numpy.savez``."""
        return {name: np.array(getattr(self, name)) for name in ("kind", "parameter", "error", "arclength")}

    def __repr__(self) -> str:
        """Say what happens, and where."""
        stop = "" if self.stop is None else f", stop {self.stop}"
        return f"Special({self.kind} at {self.parameter:.10g}{stop}, error {self.error:.1g})"
