"""Points of Poincare sections, of one motion or over the values of a number of its scene."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from vibroimpact.results.record import Record, array, items

#: The stops hit in one period, a tuple at one instant.
Pattern = list[int | tuple[int, ...]]


class PoincarePoints(Record):
    """A motion looked at once in a while: p points of n coordinates.

    Attributes
    ----------
    t : ndarray, shape (p,)
        Times [s].
    stop : ndarray of int, shape (p,)
        The stop that was hit, -1 at a phase.
    speed_before : ndarray, shape (p,)
        The speed at which it was approached [m/s]: zero at the end of impacts that accumulate, nan at a phase.
    phase : ndarray, shape (p,)
        Phases of the forcing [rad], in [0, 2 pi); nan where it has no period.
    q, v : ndarray, shape (p, n)
        Positions [m] and velocities [m/s], after impacts.
    """

    t: NDArray[np.float64] = array("point", unit="s")
    stop: NDArray[np.int64] = array("point")
    speed_before: NDArray[np.float64] = array("point", unit="m/s")
    phase: NDArray[np.float64] = array("point", unit="rad")
    q: NDArray[np.float64] = array("point dof", unit="m")
    v: NDArray[np.float64] = array("point dof", unit="m/s")

    def __repr__(self) -> str:
        """Say how many points there are."""
        where = f"of {self.q.shape[1]} coordinates"
        return f"PoincarePoints({len(self.t)} points {where}, {np.count_nonzero(self.stop >= 0)} of them after impacts)"


class BifurcationDiagram(Record):
    """What a motion of n coordinates settles on at m values of a number of its scene: p points.

    Attributes
    ----------
    name : str or None
        The number, None of a diagram made by a callable.
    parameter, direction : ndarray, shape (m,)
        Its values [its own unit] in the order in which they were gone through, and whether upwards, +1, or downwards, -1.
    n_periods : ndarray of int, shape (m,)
        After how many periods of the forcing the motion repeats itself, up to 32 and half of those looked at; 0: never.
    n_impacts : ndarray of int, shape (m,)
        Impacts in the periods looked at; those that accumulate until a stop is at rest count as one.
    pattern : tuple of list, length m
        The stops hit in one period of the motion, a tuple at one instant, as of an orbit; empty where it has none.
    status : ndarray of str, shape (m,)
        How the run ended, "finished" but where something went wrong.
    index : ndarray of int, shape (p,)
        The place of the value that each point belongs to: ``parameter[index]`` is the abscissa.
    stop, speed_before, phase : ndarray, shape (p,)
        As of ``PoincarePoints``, [m/s] and [rad].
    q, v : ndarray, shape (p, n)
        Positions [m] and velocities [m/s], after impacts.
    """

    name: str | None
    parameter: NDArray[np.float64] = array("value", coordinate="parameter")
    direction: NDArray[np.int64] = array("value")
    n_periods: NDArray[np.int64] = array("value")
    n_impacts: NDArray[np.int64] = array("value")
    pattern: tuple[Pattern, ...] = items("value", as_text=True)
    status: NDArray[np.str_] = array("value")
    index: NDArray[np.int64] = array("point")
    stop: NDArray[np.int64] = array("point")
    speed_before: NDArray[np.float64] = array("point", unit="m/s")
    phase: NDArray[np.float64] = array("point", unit="rad")
    q: NDArray[np.float64] = array("point dof", unit="m")
    v: NDArray[np.float64] = array("point dof", unit="m/s")

    def __repr__(self) -> str:
        """Say what the diagram is over and which periods were found."""
        periods, counts = np.unique(self.n_periods, return_counts=True)
        found = ", ".join(f"{count} of period {period or '?'}" for period, count in zip(periods, counts, strict=True))
        return f"BifurcationDiagram({self.name or 'callable'}, {len(self.parameter)} values: {found}; {len(self.index)} points)"
