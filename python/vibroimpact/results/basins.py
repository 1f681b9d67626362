"""Basins: which states of a plane lead to which attractor."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core
from vibroimpact.results import html, labelled
from vibroimpact.results.attractors import Attractor, Attractors, check_all
from vibroimpact.results.boundary import Fit
from vibroimpact.results.record import Record, array

#: Labels of states that lead to no attractor, and of those that nobody has worked out.
UNDECIDED, LOST, INSIDE, OPEN = 0, -1, -2, -3

_LEFT = {"lost": LOST, "inside a stop": INSIDE, "not worked out yet": OPEN}


class Basins(Record):
    """Which states of a plane lead to which attractor: ny x nx cells.

    Attributes
    ----------
    labels : ndarray of int16, shape (ny, nx)
        k + 1 where a state leads to ``attractors[k]``; 0 undecided, -1 lost, -2 inside a stop, -3 not worked out yet.
    iterations : ndarray of int32, shape (ny, nx)
        Periods of the forcing until it was decided.
    x, y : ndarray, shape (nx,) and (ny,)
        The states: values of ``x_name`` and ``y_name`` [m, m/s or rad].
    x_name, y_name : str
        What they are, such as "q[0]", "v[0]", "phase", "speed".
    attractors : Attractors or tuple of Attractor
        The attractors.
    """

    labels: NDArray[np.int16] = array("y x")
    iterations: NDArray[np.int32] = array("y x")
    x: NDArray[np.float64] = array("x", coordinate="x")
    y: NDArray[np.float64] = array("y", coordinate="y")
    x_name: str
    y_name: str
    attractors: Attractors | tuple[Attractor, ...]

    def _prepare(self) -> None:
        if not isinstance(self.attractors, Attractors):
            self._set("attractors", tuple(self.attractors))
        check_all(self.attractors)

    @property
    def fractions(self) -> NDArray[np.float64]:
        """The part of the cells worked out, outside every stop, that leads to each attractor [-], shape (k,)."""
        outside = max(int(((self.labels != INSIDE) & (self.labels != OPEN)).sum()), 1)
        return np.array([(self.labels == k + 1).sum() / outside for k in range(len(self.attractors))])

    def entropy(self, cells: int = 10) -> tuple[float, float]:
        """Return the basin entropy, and that of the boundary, of boxes of so many cells a side (Daza et al. 2016).

        The first is the mean over all boxes of ``-sum p ln p``, p the parts of a box that lead to each attractor, or are lost;
        the second the mean over boxes with more than one. Beyond ``ln 2`` the boundary is fractal.
        """
        if isinstance(cells, bool) or not isinstance(cells, (int, np.integer)):
            message = f"cells is {cells!r}, but it must be at least 1 and at most {min(self.labels.shape)}, the shorter side"
            raise ValueError(message)
        return _core._basin_entropy(self.labels, int(cells))

    def boundary_dimension(self) -> Fit:
        """Return the dimension of the boundary: boxes of each size that hold more than one basin are counted."""
        return Fit(**_core._boundary_dimension(self.labels))

    def uncertainty_exponent(self) -> Fit:
        """Return the exponent by which states become certain: those with another label at a distance are counted, over distances.

        The dimension of the boundary is that of the plane, 2, less the exponent.
        """
        return Fit(**_core._uncertainty_exponent(self.labels))

    def _labelled(self) -> labelled.Parts:
        variables, coordinates, attributes = super()._labelled()
        return variables | {"fractions": ("attractor", self.fractions)}, coordinates, attributes

    def _repr_html_(self) -> str:
        """Return it as a notebook shows it."""

        def row(pair: tuple[Any, float]) -> Sequence[str]:
            return escape(repr(pair[0]).splitlines()[0]), f"{pair[1]:.1%}"

        pairs = zip(self.attractors, self.fractions, strict=True)
        plane = [
            (escape(name), f"{html.number(values.min())} to {html.number(values.max())}, {values.size} values")
            for name, values in ((self.x_name, self.x), (self.y_name, self.y))
        ]
        return html.page("Basins", html.table(plane), html.table(html.cut(pairs, row), ("attractor", "part of the cells")))

    def __repr__(self) -> str:
        """Say how large the basins are, and what to do about states that were not decided."""
        parts = [f"{fraction:.3g}" for fraction in self.fractions]
        left = [(name, int((self.labels == label).sum())) for name, label in _LEFT.items()]
        others = "".join(f", {count} {name}" for name, count in left if count)
        undecided = int((self.labels == UNDECIDED).sum())
        remedy = ""
        if undecided:
            remedy = f", {undecided} undecided: more max_periods, or find_attractors with these states as seeds"
        plane = f"{self.x_name} x {self.y_name}, {self.labels.shape[1]} x {self.labels.shape[0]}"
        return f"Basins({plane}: fractions [{', '.join(parts)}]{others}{remedy})"
