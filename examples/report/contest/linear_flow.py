"""Linear flights in many digits: eigenvectors of the state matrix, with forcing and load as states of their own.

The states (q, v, cos, sin of each tone, 1) of a forced linear system follow `z' = A z`; `z(s) = sum c_k w_k exp(l_k s)`.
The check takes another way: the matrix exponential of `A s` by scaling and squaring of its series.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
from mpmath import mp

import vibroimpact as vi

from .equations import frequencies, tones
from .many_digits import Functions
from .problems import Problem

SAMPLES = 200  # in a turn of the fastest oscillation


def state_matrix(problem: Problem, pressed: tuple[int, ...] = ()) -> Any:
    """Matrix of `z' = A z`, its load and its columns read off the accelerations of the system without its forcing."""
    scene, n = problem.scene, problem.scene.n_dof
    free = Functions.of(replace(problem, scene=vi.Scene(scene.system, None, scene.stops)), pressed)
    driven, zero = tones(scene, mp.mpf), [mp.mpf(0)] * (2 * n)
    load = free.acceleration(mp.mpf(0), *zero)
    units = [free.acceleration(mp.mpf(0), *([mp.mpf(k == j) for k in range(2 * n)])) for j in range(2 * n)]
    last = 2 * n + 2 * len(driven)
    a = mp.zeros(last + 1)
    for i in range(n):
        a[i, n + i] = 1
        a[n + i, last] = load[i]
        for j, unit in enumerate(units):
            a[n + i, j] = unit[i] - load[i]
    for place, tone in zip(range(2 * n, last, 2), driven, strict=True):
        a[place, place + 1], a[place + 1, place] = -tone.frequency, tone.frequency
        for i in range(n):
            a[n + i, place] = tone.push[i]
    return a


def extended(problem: Problem, t: Any, x: list[Any]) -> Any:
    """The state with its forcing."""
    angles = [tone.frequency * t + tone.phase for tone in tones(problem.scene, mp.mpf)]
    turned = [wave(angle) for angle in angles for wave in (mp.cos, mp.sin)]
    return mp.matrix([*x, *turned, 1])


class LinearPiece:
    """A flight from a time to the end of the motion."""

    def __init__(self, problem: Problem, start: Any, values: list[Any], vectors: Any, weights: Any) -> None:
        """Take eigenvalues, rows of the eigenvectors for positions and velocities, and the weights of the start in them."""
        n = problem.scene.n_dof
        self.values, self.start, self.length = values, start, mp.mpf(problem.end) - start
        self.parts = [[vectors[i, k] * weights[k] for k in range(len(values))] for i in range(2 * n)]
        self.doubles = np.array([[complex(each) for each in row] for row in self.parts[:n]])
        self.rates = np.array([complex(each) for each in values])
        self.quickest = 1.0 / max(1.0, np.abs(self.rates).max())
        self.fastest = max(1e-2, np.abs(self.rates.imag).max(), *frequencies(problem.scene))

    def grid(self) -> np.ndarray:
        """Points close to the start first, a twelfth apart, then so many in each turn of the fastest oscillation."""
        step = 2.0 * np.pi / SAMPLES / self.fastest
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

    def __init__(self, problem: Problem, pressed: tuple[int, ...] = ()) -> None:
        """Find the eigenvectors once."""
        self.problem = problem
        self.values, self.vectors = mp.eig(state_matrix(problem, pressed))
        self.inverse = mp.inverse(self.vectors)

    def __call__(self, t: Any, x: list[Any]) -> Iterator[LinearPiece]:
        """One piece, to the end."""
        weights = self.inverse * extended(self.problem, t, x)
        yield LinearPiece(self.problem, t, self.values, self.vectors, weights)
