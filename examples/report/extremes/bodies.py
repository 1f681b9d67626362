"""Two coordinates coupled by inertia alone: straight flights and Newton's impacts, in fifty digits and by every method.

Two links of unit mass and length without gravity, in minute swings, have the mass matrix [[2, 1], [1, 1]].
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpmath import matrix, mpf

import vibroimpact as vi
from report.extremes.condition import Parts
from report.extremes.motion import ATOL, SMALL, tolerance

MASS = ((2.0, 1.0), (1.0, 1.0))


def flown(
    inverse: matrix, q: Sequence[mpf], v: Sequence[mpf], clearances: Sequence[mpf], restitutions: Sequence[mpf], end: mpf
) -> Parts:
    """Positions and velocities at the end: each coordinate has an upper stop, hit one at a time, along M^-1 n."""
    q, v, time = list(q), list(v), mpf(0)
    while True:
        waits = [(c - x) / y if y > 0 else mpf("inf") for c, x, y in zip(clearances, q, v, strict=True)]
        first = min(range(len(q)), key=waits.__getitem__)
        wait = min(waits[first], end - time)
        q = [x + y * wait for x, y in zip(q, v, strict=True)]
        time += wait
        if time == end:
            return [q, v]
        q[first] = clearances[first]
        impulse = (1 + restitutions[first]) * v[first] / inverse[first, first]
        v = [y - inverse[i, first] * impulse for i, y in enumerate(v)]


def simulated(
    stops: Sequence[vi.Stop], q: Sequence[float], v: Sequence[float], end: float, method: str, **links: object
) -> vi.Trajectory:
    """The two links, or their linear system without gravity; stops as for positions of unit size."""
    unit, rtol = (SMALL if method == "taylor" else 1.0), tolerance(method)
    scaled = [vi.Stop(s.normal, unit * s.clearance, s.restitution, side=s.side) for s in stops]
    chain = vi.PendulumChain([1, 1], [1, 1], **({"gravity": 0.0} | links))
    scene = vi.Scene(chain if method == "taylor" else chain.linearise(), None, scaled)
    start = unit * np.array(q), unit * np.array(v)
    return vi.simulate(scene, *start, (0, end), method=method, rtol=rtol, atol=ATOL * rtol * unit)


def final(run: vi.Trajectory, method: str) -> list[np.ndarray]:
    """Positions and velocities at the end, in units of the motion."""
    return [x / (SMALL if method == "taylor" else 1.0) for x in run.final]
