"""Laws of motion that a user writes down: accelerations as formulas, which the library is given as compiled C functions.

A law shows itself as a compiled function of numba does, by its address and its ctypes function; all others read its formula.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from .equations import Number, Vector
from .formulas import cos, traced
from .plugin import function, loaded

HEAD = "accelerations(double t, const double *q, const double *v, double *a, const double *parameters)"
NUMBERS = ctypes.POINTER(ctypes.c_double)


@dataclass(frozen=True, eq=False)
class Law:
    """Accelerations of (t, q, v), made by `formula` for one kind of number."""

    n_dof: int
    formula: Callable[[Number], Callable[[Any, Vector, Vector], list[Any]]]

    @cached_property
    def ctypes(self) -> Any:
        """The accelerations as a C function."""
        n, move = self.n_dof, self.formula(float)
        names = [f"{x}{i}" for x in "qv" for i in range(n)]
        places = {f"{x}{i}": f"{x}[{i}]" for x in "qv" for i in range(n)}
        lines = traced(lambda t, *x: move(t, x[:n], x[n:]), ["t", *names])
        compiled = loaded([function(HEAD, lines, places, "a")]).library.accelerations
        compiled.argtypes, compiled.restype = [ctypes.c_double, *[NUMBERS] * 4], None
        return compiled

    @property
    def address(self) -> int:
        """Where the C function is."""
        return ctypes.cast(self.ctypes, ctypes.c_void_p).value


def duffing(damping: float, cubic: float, force: float, frequency: float) -> Law:
    """Duffing's oscillator, driven: `q'' + damping q' + q + cubic q^3 = force cos(frequency t)`."""

    def formula(number: Number) -> Callable[[Any, Vector, Vector], list[Any]]:
        c, b, f, w = (number(each) for each in (damping, cubic, force, frequency))
        return lambda t, q, v: [cos(t * w) * f - v[0] * c - q[0] * (q[0] * q[0] * b + 1)]

    return Law(1, formula)


def cubic_pair(mass: float, damping: float, cubic: float) -> Law:
    """A light mass on a spring of stiffness one; behind it a mass of one on a cubic spring with a damper."""

    def formula(number: Number) -> Callable[[Any, Vector, Vector], list[Any]]:
        m, c, b = number(mass), number(damping), number(cubic)

        def move(_: Any, q: Vector, v: Vector) -> list[Any]:
            elongation = q[1] - q[0]
            force = elongation * elongation * elongation * b + (v[1] - v[0]) * c
            return [(force - q[0]) / m, force * -1]

        return move

    return Law(2, formula)
