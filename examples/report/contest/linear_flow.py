"""Linear flights in many digits: eigenvectors of the state matrix, with forcing and load as states of their own.

The states (q, v, cos, sin, 1) of a forced linear system follow `z' = A z`; `z(s) = sum c_k w_k exp(l_k s)`. The check takes
another way: the matrix exponential of `A s` by scaling and squaring of its series.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from mpmath import mp

from .many_digits import Functions
from .problems import Problem

SAMPLES = 200  # in a turn of the fastest oscillation


def state_matrix(problem: Problem) -> Any:
    """Matrix of `z' = A z`, read off the accelerations of unit states."""
    functions, n = Functions.of(problem), problem.scene.n_dof
    forcing = problem.scene.forcing
    zero, w = [mp.mpf(0)] * (2 * n), mp.mpf(forcing.frequency if forcing else 0)
    quarter = mp.pi / 2 / w if forcing else mp.mpf(0)
    phase = mp.mpf(forcing.phase) if forcing else mp.mpf(0)
    crest, rise = (-phase / w, -phase / w - quarter) if forcing else (mp.mpf(0), mp.mpf(0))  # cosine 1; cosine 0
    load = functions.acceleration(rise, *zero)
    wave = [a - b if forcing else mp.mpf(0) for a, b in zip(functions.acceleration(crest, *zero), load, strict=True)]
    a = mp.zeros(2 * n + 3)
    for i in range(n):
        a[i, n + i] = 1
        a[n + i, 2 * n], a[n + i, 2 * n + 2] = wave[i], load[i]
        for j in range(2 * n):
            unit = [mp.mpf(k == j) for k in range(2 * n)]
            a[n + i, j] = functions.acceleration(rise, *unit)[i] - load[i]
    a[2 * n, 2 * n + 1], a[2 * n + 1, 2 * n] = -w, w
    return a


def extended(problem: Problem, t: Any, x: list[Any]) -> Any:
    """The state with its forcing."""
    forcing = problem.scene.forcing
    angle = mp.mpf(forcing.frequency) * t + mp.mpf(forcing.phase) if forcing else mp.mpf(0)
    return mp.matrix([*x, mp.cos(angle), mp.sin(angle), 1])


class LinearPiece:
    """A flight to the end of the motion."""

    def __init__(self, values: list[Any], vectors: Any, weights: Any, n: int, length: Any) -> None:
        """Take eigenvalues, rows of the eigenvectors for positions and velocities, and the weights of the start in them."""
        self.values, self.n, self.length = values, n, length
        self.parts = [[vectors[i, k] * weights[k] for k in range(len(values))] for i in range(2 * n)]
        self.doubles = np.array([[complex(each) for each in row] for row in self.parts[:n]])
        self.rates = np.array([complex(each) for each in values])
        self.quickest = 1.0 / max(1.0, np.abs(self.rates).max())

    def grid(self) -> np.ndarray:
        """Points close to the start first, a twelfth apart, then so many in each turn of the fastest oscillation."""
        step = 2.0 * np.pi / SAMPLES / max(1e-2, np.abs(self.rates.imag).max())
        first, end = 1e-5 * min(step, self.quickest), float(self.length)
        near = np.geomspace(first, step, int(np.log(step / first) / np.log1p(1.0 / 12.0)))
        return np.concatenate([near[:-1], np.arange(step, end + step, step)])

    def positions(self, s: np.ndarray) -> np.ndarray:
        """Positions in doubles, (m, n)."""
        return np.real(np.exp(np.multiply.outer(s, self.rates)) @ self.doubles.T)

    def state(self, s: Any) -> list[Any]:
        """Positions and velocities in many digits."""
        growth = [mp.exp(each * s) for each in self.values]
        return [mp.re(sum(a * b for a, b in zip(row, growth, strict=True))) for row in self.parts]


class LinearFlow:
    """Makes the flights of a linear scene."""

    def __init__(self, problem: Problem) -> None:
        """Find the eigenvectors once."""
        self.problem, self.n = problem, problem.scene.n_dof
        self.values, self.vectors = mp.eig(state_matrix(problem))
        self.inverse = mp.inverse(self.vectors)

    def __call__(self, t: Any, x: list[Any]) -> Iterator[LinearPiece]:
        """One piece, to the end."""
        weights = self.inverse * extended(self.problem, t, x)
        yield LinearPiece(self.values, self.vectors, weights, self.n, mp.mpf(self.problem.end) - t)
