"""Curves in two numbers on which special points of branches lie."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact._core import Orbit
from vibroimpact._validation import few, shown
from vibroimpact.results.branch import check_ends
from vibroimpact.results.labelled import Parts
from vibroimpact.results.record import ItemsRecord, Record, array, items
from vibroimpact.results.special import KINDS

#: What happens on a curve at once with what it is a curve of.
TWO_AT_ONCE = (
    *("cusp", "strong_1_1", "strong_1_2", "strong_1_3", "strong_1_4", "fold_flip"),
    *("resonant_graze", "graze_fold", "double_graze", "degenerate_graze", "graze_corner"),
    *KINDS[KINDS.index("graze") :],
)


class CurvePoint(Record):
    """A point of a curve at which two things happen at once.

    Attributes
    ----------
    kind : str
        "cusp": two curves of folds meet and end. "fold_flip": on a curve of folds a multiplier -1, on one of doublings a
        multiplier 1. "strong_1_1", "strong_1_2": two multipliers are 1, or -1; a curve of tori ends there. "strong_1_3",
        "strong_1_4": on a curve of tori they turn by a third of a turn, or by a quarter. "resonant_graze": on a curve of folds,
        doublings or tori an impact loses its speed; on one of grazes a curve of doublings ends. "graze_fold": on one of grazes
        a curve of folds ends. "double_graze": on one of grazes another touch. "degenerate_graze": there is no acceleration at
        a touch. "graze_corner": of two stops hit at one instant one is touched only, or another touch comes to a corner or a
        corner to a touch. Else the kind of ``Special`` of a boundary of motion, beyond which the orbits of the curve are
        virtual.
    parameter, error : (float, float)
        Both numbers, and how far each is known.
    arclength : float
        How far along the curve it is [-].
    orbit : Orbit
        The orbit there.
    """

    kind: str
    parameter: tuple[float, float]
    error: tuple[float, float]
    arclength: float
    orbit: Orbit

    def _prepare(self) -> None:
        for name in ("parameter", "error"):
            self._set(name, few(name, getattr(self, name), ("x", "y")))

    def _check_more(self) -> None:
        if self.kind not in TWO_AT_ONCE:
            message = f"kind is {self.kind!r}, but it must be one of {TWO_AT_ONCE}"
            raise ValueError(message)

    def _labelled(self) -> Parts:
        variables, coordinates, attributes = super()._labelled()
        return variables, coordinates, attributes | dict(zip("xy", self.parameter, strict=True))

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return its numbers as arrays, for ``numpy.savez``."""
        return {name: np.array(getattr(self, name)) for name in ("kind", "parameter", "error", "arclength")}

    def __repr__(self) -> str:
        """Say what happens, and where."""
        x, y = self.parameter
        return f"CurvePoint({self.kind} at ({x:.10g}, {y:.10g}))"


class BifurcationCurve(ItemsRecord[Orbit]):
    """Periodic orbits at special points over two numbers of their scene: a sequence of m orbits, beside each other.

    Attributes
    ----------
    kind : str
        What lies on it: a kind of ``Special``, or "together" of an orbit that hits stops at one instant.
    parameter_names : tuple of str or None
        Both numbers, None of a curve made by a callable.
    orbits : tuple of Orbit
        The orbits; of a graze those that touch.
    x, y : ndarray, shape (m,)
        The numbers at each [its own unit].
    arclength : ndarray, shape (m,)
        How far along the curve [-] each is from the point that was given, in scaled unknowns.
    is_virtual : ndarray of bool, shape (m,)
        Whether each breaks a rule of contact.
    special : tuple of CurvePoint
        Where two things happen at once.
    ends : tuple of (str, str), length 2
        Why it ends before its first point and after its last, as ``Branch.ends``.
    """

    kind: str
    parameter_names: tuple[str, str] | None
    orbits: tuple[Orbit, ...] = items("orbit", least=1)
    x: NDArray[np.float64] = array("orbit", coordinate="x")
    y: NDArray[np.float64] = array("orbit", coordinate="y")
    arclength: NDArray[np.float64] = array("orbit")
    is_virtual: NDArray[np.bool_] = array("orbit")
    special: tuple[CurvePoint, ...]
    ends: tuple[tuple[str, str], tuple[str, str]]

    def _prepare(self) -> None:
        if self.parameter_names is not None:
            self._set("parameter_names", two_names(self.parameter_names))
        self._set("ends", tuple((str(reason), str(detail)) for reason, detail in self.ends))

    def _sizes(self) -> dict[str, int]:
        return {"orbit": len(self.orbits)}

    def _check_more(self) -> None:
        if self.kind not in (*KINDS, "together"):
            message = f'kind is {self.kind!r}, but it must be a kind of Special or "together"'
            raise ValueError(message)
        check_ends(self.ends)

    def _items(self) -> tuple[Orbit, ...]:
        return self.orbits

    def _labelled(self) -> Parts:
        variables, coordinates, attributes = super()._labelled()
        names = zip(("name_x", "name_y"), self.parameter_names or (), strict=False)
        return variables, coordinates, attributes | dict(names)

    def __repr__(self) -> str:
        """Say where the curve goes and what ends it."""
        names = "callable" if self.parameter_names is None else ", ".join(self.parameter_names)
        ranges = f"{self.x.min():.6g} to {self.x.max():.6g}, {self.y.min():.6g} to {self.y.max():.6g}"
        lines = [f"BifurcationCurve({self.kind} over {names}: {ranges}, {len(self)} orbits)"]
        lines += [f"  {own}" for own in self.special]
        lines += [f"  {reason}: {detail}" for reason, detail in self.ends]
        return "\n".join(lines)


def two_names(parameters: Any) -> tuple[str, str]:
    """Return two names."""
    given = tuple(parameters) if isinstance(parameters, (tuple, list)) else ()
    if len(given) != 2 or not all(isinstance(own, str) for own in given):
        message = f"parameters is {shown(parameters)}, but two numbers of Scene.replace or a callable (x, y) -> Scene are needed"
        raise TypeError(message)
    if given[0] == given[1]:
        message = f"parameters is {shown(parameters)}, but they must be two"
        raise ValueError(message)
    return given[0], given[1]
