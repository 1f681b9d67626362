"""What an optimiser asks of a periodic orbit, followed from one set of numbers to the next: a value and its gradient."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _core
from vibroimpact._core import Orbit, Scene
from vibroimpact._validation import shown
from vibroimpact.errors import ConvergenceError
from vibroimpact.results.derivatives import Derivatives

__all__ = ["objective"]

#: What of an orbit each derivative is of.
VALUES: dict[str, Callable[[Orbit], Any]] = {
    "q0": lambda orbit: orbit.q0,
    "v0": lambda orbit: orbit.v0,
    "phase": lambda orbit: orbit.phase,
    "period": lambda orbit: orbit.period,
    "speeds_before": lambda orbit: orbit.impacts["speed_before"],
    "times": lambda orbit: orbit.impacts["time"],
    "min_gap": lambda orbit: orbit.min_gap,
    "max_displacement": lambda orbit: orbit.max_displacement,
}
Value = Callable[[Orbit, Derivatives], tuple[float, ArrayLike]]
Make = Callable[[NDArray[np.float64]], Scene]


class Objective:
    """A value of an orbit, and its gradient, as a function of numbers of the scene; made by ``objective``.

    Attributes
    ----------
    orbit : Orbit
        The orbit at the last p that it was found for.
    p : ndarray, shape (d,)
        That p.
    """

    def __init__(self, make: Make, orbit: Orbit, value: Value, start: NDArray[np.float64]) -> None:
        self._make, self._value = make, value
        self.orbit, self.p = orbit, start

    def __call__(self, p: ArrayLike) -> tuple[float, NDArray[np.float64]]:
        """Return the value and its gradient at p, shape (d,)."""
        p = _core._numbers("p", p)
        if p.shape != self.p.shape or not np.isfinite(p).all():
            message = f"p is {p}, but {len(self.p)} finite numbers are needed"
            raise ValueError(message)
        try:
            orbit = _core._continued_orbit(self.orbit, self._make, self.p, p)
        except ConvergenceError as error:
            raise ConvergenceError(f"p = {p.tolist()}, followed from {self.p.tolist()}: {error}") from error
        if isinstance(self._value, _Entry):  # which is none of the multipliers
            found = _core._derivatives_but_multipliers(orbit, self._make, p)
        else:
            found = orbit.derivatives(self._make, start=p)
        value, gradient = self._value(orbit, found)
        gradient = _core._numbers("the gradient of value", gradient)
        if gradient.shape != p.shape:
            message = f"the gradient of value has shape {gradient.shape}, but {p.shape} is needed"
            raise ValueError(message)
        self.orbit, self.p = orbit, p
        return float(value), gradient


def objective(make: Make, orbit: Orbit, value: str | Value, *, start: ArrayLike) -> Objective:
    """Make a function of numbers of a scene that gives a value of its orbit, and the gradient, for an optimiser.

    Parameters
    ----------
    make : callable
        ``make(p)``, p of shape (d,), the scene; that of ``start`` is the orbit's but for the phase.
    orbit : Orbit
        The orbit at ``start``.
    value : str or callable
        An entry of what ``Derivatives`` has, "speeds_before[0]", "max_displacement[1]", "period", ... (not of the multipliers,
        which are complex); or ``f(orbit, derivatives) -> (float, (d,))``.
    start : array_like, shape (d,)
        Where the orbit is followed from.

    Returns
    -------
    callable
        ``g(p) -> (value, gradient)``, for ``scipy.optimize.minimize(g, p0, jac=True)``. It has the last ``orbit`` and ``p``.

    Raises
    ------
    ValueError
        A value that there is not; an orbit that does not close in the scene of ``start``; and when it is called, a p of
        another length, what ``make`` raises.
    ConvergenceError
        When it is called with a p to which the orbit cannot be followed.

    Notes
    -----
    From the last p the orbit is followed by ``find_orbit``, in smaller steps where that fails or leads far off, at last by
    ``continuation`` along the way between. The orbit may break a rule of contact, and the gradient may be nan (see
    ``Derivatives.reason``): what keeps it from that, bounds on ``speeds_before``, ``min_gap`` and the multipliers, is to be a
    constraint.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> def make(p):
    ...     return vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([8.5], 2.4), vi.Stop(0, p[0], p[1]))
    >>> orbit = vi.periodic_orbits(make([1.0, 0.8]), [0])[0]
    >>> g = vi.objective(make, orbit, "speeds_before[0]", start=[1.0, 0.8])
    >>> speed, gradient = g([1.1, 0.7])
    >>> round(speed, 6), gradient.round(4).tolist()
    (2.919598, [-4.1711, -1.3103])
    """
    if not callable(make):
        message = f"make is {shown(make)}, but a callable p (d,) -> Scene is needed"
        raise TypeError(message)
    if not isinstance(orbit, Orbit):
        message = f"orbit is {shown(orbit)}, but an Orbit is needed"
        raise TypeError(message)
    p = _core._numbers("start", start)
    if p.ndim != 1:
        message = f"start has shape {p.shape}, but (d,) is needed"
        raise ValueError(message)
    if not (isinstance(value, str) or callable(value)):
        message = f"value is {shown(value)}, but the name of an entry or a callable f(orbit, derivatives) is needed"
        raise TypeError(message)
    entry = _Entry(value, orbit) if isinstance(value, str) else value
    _core._derivatives_but_multipliers(orbit, make, p)  # refuses an orbit that is not that of start
    return Objective(make, orbit, entry, p)


class _Entry:
    """An entry of what an orbit has, and its derivatives."""

    def __init__(self, name: str, orbit: Orbit) -> None:
        parts = re.fullmatch(r"(\w+?)(?:\[(\d+)\])?", name)
        if parts is None or parts[1] not in VALUES:
            message = f"value is {name!r}, but it must be an entry of {', '.join(VALUES)}, or a callable f(orbit, derivatives)"
            raise ValueError(message)
        self._own, index = parts[1], parts[2]
        shape = np.shape(VALUES[self._own](orbit))
        if (index is None) != (shape == ()) or (index is not None and int(index) >= shape[0]):
            entries = "one number" if shape == () else f"of {shape[0]} entries, {self._own}[0] and so on"
            message = f"value is {name!r}, but {self._own} of this orbit is {entries}"
            raise ValueError(message)
        self._place = () if index is None else int(index)

    def __call__(self, orbit: Orbit, derivatives: Derivatives) -> tuple[float, NDArray[np.float64]]:
        """Return the entry and its derivatives."""
        return float(np.asarray(VALUES[self._own](orbit))[self._place]), getattr(derivatives, self._own)[self._place]
