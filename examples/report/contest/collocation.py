"""The second way to stiff nonlinear flights: collocation at Radau's points (Hairer and Wanner 1996), in mpmath's digits.

The equations of a step are solved by Newton's method: residuals in many digits, corrections in doubles, which gain some ten each.
After an impact the steps grow from a part of the quickest time of the motion, so that what dies out fast is followed too.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from mpmath import mp

from .equations import equations
from .many_digits import Flight, Functions
from .problems import Problem

STAGES = 16  # order 31
STEP = 0.05  # longest step, in units of the problem's time
FIRST = 0.1  # first step of a flight, in units of the quickest time
GROWTH = 1.2  # of the steps
CLOSE = 1e-36  # of the velocities' scale, corrections that are not needed
MOST = 30  # corrections


@cache
def points() -> tuple[list[Any], list[list[Any]]]:
    """Points of a step of length one, and the integrals from its start to each of them of what is known at all."""
    s = STAGES
    with mp.workdps(100):
        rodrigues = [mp.mpf(0)] * (2 * s)  # x^(s-1) (x-1)^s, then its derivative of order s-1: the highest power first
        for k in range(s + 1):
            rodrigues[k] = mp.binomial(s, k) * (-1) ** k
        derived = [a * mp.ff(2 * s - 1 - k, s - 1) for k, a in enumerate(rodrigues[: s + 1])]
        nodes = sorted(mp.re(each) for each in mp.polyroots(derived, maxsteps=500, extraprec=500))
        powers = mp.matrix([[c**j for j in range(s)] for c in nodes])
        integrals = mp.matrix([[c ** (j + 1) / (j + 1) for j in range(s)] for c in nodes])
        weights = integrals * mp.inverse(powers)
        return nodes, [[weights[i, j] for j in range(s)] for i in range(s)]


class Steps:
    """Steps of one problem."""

    def __init__(self, problem: Problem) -> None:
        """Take its formulas, their derivatives in doubles."""
        self.functions = Functions.of(problem)
        self.jacobian = equations(problem.scene).jacobian().function()
        self.weights = np.array([[float(each) for each in row] for row in points()[1]])

    def slopes(self, t: float, x: list[Any]) -> np.ndarray:
        """Derivative of the rates by the state, in doubles."""
        n = self.functions.n
        entries = self.jacobian(t, *map(float, x))
        return np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), np.reshape(entries, (n, 2 * n))])

    def step(self, t: Any, x: list[Any], length: Any) -> list[Any]:
        """The state after one step."""
        n, (nodes, weights) = self.functions.n, points()
        times, stages = [t + c * length for c in nodes], [list(x) for _ in nodes]
        for _ in range(MOST):
            rates = [[*z[n:], *self.functions.acceleration(u, *z)] for u, z in zip(times, stages, strict=True)]
            residuals = [
                [a - b - length * mp.fdot(row, column) for a, b, column in zip(z, x, zip(*rates, strict=True), strict=True)]
                for z, row in zip(stages, weights, strict=True)
            ]
            size = max(abs(each) for row in residuals for each in row)
            if size < CLOSE:
                return stages[-1]
            change = self.correction(times, stages, float(length), [[float(e / size) for e in row] for row in residuals])
            stages = [[a - size * b for a, b in zip(z, row, strict=True)] for z, row in zip(stages, change, strict=True)]
        raise ArithmeticError(f"no step of {mp.nstr(length, 3)} from {mp.nstr(t, 10)}")

    def correction(self, times: list[Any], stages: list[list[Any]], length: float, right: list[list[float]]) -> list[list[Any]]:
        """Solution of the linearised equations, in doubles."""
        slopes = [self.slopes(float(u), z) for u, z in zip(times, stages, strict=True)]
        size = len(slopes[0])
        matrix = np.block([[-length * w * slope for w, slope in zip(row, slopes, strict=True)] for row in self.weights])
        found = np.linalg.solve(np.eye(len(matrix)) + matrix, np.ravel(right))
        return [[mp.mpf(each) for each in row] for row in found.reshape(-1, size).tolist()]

    def end(self, flight: Flight) -> list[Any]:
        """The state at a flight's end."""
        t, x = flight.start, flight.state
        length = FIRST / mp.mpf(float(np.abs(self.slopes(float(t), x)).sum(axis=1).max()))
        while t < flight.end:
            part = min(length, mp.mpf(STEP), flight.end - t)
            t, x = (flight.end if part == flight.end - t else t + part), self.step(t, x, part)
            length *= GROWTH
        return x


def by_collocation(problem: Problem, flights: list[Flight]) -> Any:
    """Largest difference of any flight's end from that of collocation."""
    steps = Steps(problem)
    return max(abs(a - b) for flight in flights for a, b in zip(steps.end(flight), flight.before, strict=True))
