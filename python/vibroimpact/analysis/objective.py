"""What an optimiser asks of a periodic orbit, followed from one set of numbers to the next: a value and its gradient."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _core
from vibroimpact._core import Orbit, Scene
from vibroimpact._validation import shown
from vibroimpact.errors import ConvergenceError
from vibroimpact.results.derivatives import Derivatives

__all__ = ["objective"]

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

    def __init__(self, make: Make, orbit: Orbit, value: str | Value, start: NDArray[np.float64]) -> None:
        self._make, self._value = make, value
        self.orbit, self.p = orbit, start

    def __call__(self, p: ArrayLike) -> tuple[float, NDArray[np.float64]]:
        """Return the value and its gradient at p, shape (d,)."""
        p = _core._numbers("p", p)
        if p.shape != self.p.shape or not np.isfinite(p).all():
            message = f"p is {p}, but {len(self.p)} finite numbers are needed"
            raise ValueError(message)
        try:
            value, gradient, orbit = _core._objective_at(self.orbit, self._make, self._value, self.p, p)
        except ConvergenceError as error:
            raise ConvergenceError(f"p = {p.tolist()}, followed from {self.p.tolist()}: {error}") from error
        self.orbit, self.p = orbit, p
        return value, gradient


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
    if isinstance(value, str):
        _core._check_entry(value, orbit)
    _core._derivatives_but_multipliers(orbit, make, p)  # refuses an orbit that is not that of start
    return Objective(make, orbit, value, p)
