"""The pair's equations of motion written by a user: in Python, with NumPy, in C, compiled by numba."""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import vibroimpact as vi
from report.cost.scenes import acceleration_matrix

SOURCE = """
void pair(double t, const double *q, const double *v, double *a, const double *p)
{
    a[0] = p[0] * q[0] + p[1] * q[1];
    a[1] = p[2] * q[0] + p[3] * q[1];
}
"""


def coefficients() -> list[float]:
    """The four entries of `-M^-1 K`."""
    return [float(c) for c in acceleration_matrix().ravel()]


def in_python() -> vi.NonlinearSystem:
    """Plain Python numbers."""
    a, b, c, d = coefficients()

    def acceleration(t: float, q: Any, v: Any) -> tuple[float, float]:
        x, y = q.tolist()
        return a * x + b * y, c * x + d * y

    return vi.NonlinearSystem(2, acceleration)


def with_numpy() -> vi.NonlinearSystem:
    """One product of NumPy."""
    matrix = acceleration_matrix()
    return vi.NonlinearSystem(2, lambda t, q, v: matrix @ q)


def compiler() -> str | None:
    """A C compiler, None where there is none."""
    return shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")


@functools.cache
def library() -> ctypes.CDLL:
    """The C function, compiled."""
    with tempfile.TemporaryDirectory() as directory:
        source, target = Path(directory, "pair.c"), Path(directory, "pair.so")
        source.write_text(SOURCE)
        subprocess.run([str(compiler()), "-O2", "-shared", "-fPIC", "-o", str(target), str(source)], check=True)
        return ctypes.CDLL(str(target))


def in_c() -> vi.NonlinearSystem:
    """A C function by its address, taken from `ctypes`."""
    pointer = ctypes.POINTER(ctypes.c_double)
    function = library().pair
    function.argtypes, function.restype = [ctypes.c_double, *[pointer] * 4], None
    return vi.NonlinearSystem(2, function, parameters=coefficients())


def with_numba() -> vi.NonlinearSystem:
    """A numba `cfunc`."""
    numba = __import__("numba")
    types = numba.types
    numbers = types.CPointer(types.double)

    @numba.cfunc(types.void(types.double, numbers, numbers, numbers, numbers))  # type: ignore[untyped-decorator]
    def function(t: Any, q: Any, v: Any, a: Any, p: Any) -> None:
        a[0] = p[0] * q[0] + p[1] * q[1]
        a[1] = p[2] * q[0] + p[3] * q[1]

    return vi.NonlinearSystem(2, function, parameters=coefficients())


def available() -> dict[str, Callable[[], vi.NonlinearSystem]]:
    """The systems that can be made here, by how they are written."""
    systems: dict[str, Callable[[], vi.NonlinearSystem]] = {"Python": in_python, "Python with NumPy": with_numpy}
    if compiler():
        systems["C, by its address"] = in_c
    if importlib.util.find_spec("numba"):
        systems["numba cfunc"] = with_numba
    return systems
