"""The motion of any linear system by the exponential of its state matrix, enlarged by load and forcing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpmath import matrix, mp, mpf

from report.extremes.condition import Parts, Truth, truth

Rows = Sequence[Sequence[mpf]]


def enlarged(mass: Rows, damping: Rows, stiffness: Rows, load: Sequence[mpf], force: Sequence[mpf], frequency: mpf) -> matrix:
    """Rate matrix of (q, v, 1, cos, sin)."""
    n = len(mass)
    inverse, rate = mp.matrix(mass) ** -1, mp.zeros(2 * n + 3)
    rate[:n, n : 2 * n] = mp.eye(n)
    rate[n : 2 * n, :n] = -inverse * mp.matrix(stiffness)
    rate[n : 2 * n, n : 2 * n] = -inverse * mp.matrix(damping)
    rate[n : 2 * n, 2 * n] = inverse * mp.matrix(load)
    rate[n : 2 * n, 2 * n + 1] = inverse * mp.matrix(force)
    rate[2 * n + 1, 2 * n + 2], rate[2 * n + 2, 2 * n + 1] = -frequency, frequency
    return rate


def flow(rate: matrix, time: mpf) -> matrix:
    """e^(A T), with digits to spare for the squarings."""
    spare = 20 + int(mp.log10(1 + mp.mnorm(rate, 1) * time))
    with mp.workdps(mp.dps + spare):
        result = mp.expm(rate * time, method="taylor")
    return +result


def square(entries: Sequence[mpf], n: int) -> Rows:
    """Rows of n."""
    return [list(entries[i * n : (i + 1) * n]) for i in range(n)]


def system(n: int, inputs: Sequence[mpf]) -> Parts:
    """Positions and velocities after some time: mass, damping, stiffness, load, force, frequency, phase, q, v, time."""
    cuts = np.cumsum([n * n, n * n, n * n, n, n, 1, 1, n, n]).tolist()
    mass, damping, stiffness, load, force, (w,), (phase,), q, v, (time,) = (
        inputs[a:b] for a, b in zip([0, *cuts], [*cuts, None], strict=True)
    )
    rate = enlarged(square(mass, n), square(damping, n), square(stiffness, n), load, force, w)
    end = flow(rate, time) * mp.matrix([*q, *v, 1, mp.cos(phase), mp.sin(phase)])
    return [list(end[:n]), list(end[n : 2 * n])]


def system_truth(*arrays: object) -> Truth:
    """The same with condition numbers, of arrays in this order."""
    flat = [float(x) for array in arrays for x in np.ravel(np.asarray(array, dtype=float))]
    n = np.size(arrays[-2])
    return truth(lambda *inputs: system(n, inputs), *flat)
