"""Matrices and directions of large structures: anything array-like or sparse comes in, checked by name, value and rule."""

from __future__ import annotations

from operator import index
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact import _core

#: Asymmetry up to which a matrix counts as symmetric, relative to the largest entries of the two rows, of the smaller of them:
#: that of a penalty elsewhere says nothing.
_SYMMETRY = 1e-12


def sparse_library(purpose: str) -> ModuleType:
    """Return ``scipy.sparse``, imported when it is first needed."""
    try:
        import scipy.sparse
        import scipy.sparse.linalg
    except ImportError:
        message = f'{purpose} needs SciPy: pip install "vibroimpact[fe]"'
        raise ImportError(message) from None
    library: ModuleType = scipy.sparse
    return library


def is_sparse(value: Any) -> bool:
    """Whether a value is a sparse array of SciPy, told by its methods: without SciPy there is none."""
    return hasattr(value, "tocsc") and hasattr(value, "nnz")


def _refuse(argument: str, found: object, rule: str) -> None:
    message = f"{argument} is {found}, but {rule}"
    raise ValueError(message)


def finite(argument: str, value: ArrayLike) -> NDArray[np.float64]:
    """Return the entries of anything array-like; they are finite real numbers."""
    entries = _core._numbers(argument, value)
    for place in np.argwhere(~np.isfinite(entries))[:1]:
        name = f"{argument}{[int(i) for i in place]}" if entries.ndim else argument
        _refuse(name, float(entries[tuple(place)]), "it must be finite")
    return entries


def number(argument: str, value: Any) -> float:
    """Return a finite real number."""
    found = finite(argument, value)
    if found.ndim:
        message = f"{argument} has shape {found.shape}, but one number is needed"
        raise ValueError(message)
    return float(found)


def _finite_sparse(argument: str, value: Any) -> Any:
    """Return a sparse array by its coordinates; its entries are finite real numbers."""
    found = value.tocoo()
    if found.dtype.kind == "c" and found.data.imag.any():
        _refuse(argument, f"a sparse array of dtype {found.dtype}", "real numbers are needed")
    entries = _core._numbers(argument, found.data)
    for i in np.flatnonzero(~np.isfinite(entries))[:1]:
        _refuse(f"{argument}{[int(axis[i]) for axis in found.coords]}", float(entries[i]), "it must be finite")
    return sparse_library(argument).coo_array((entries, found.coords), shape=found.shape)


def square(argument: str, value: ArrayLike | Any, n: int | None = None) -> Any:
    """Return a matrix as a sparse one in columns, of order n if given; ``(n,)`` is a diagonal, a number one of order 1."""
    sparse = sparse_library(argument)
    matrix: Any = _finite_sparse(argument, value) if is_sparse(value) else np.atleast_1d(finite(argument, value))
    shape = matrix.shape
    wanted = "n" if n is None else n
    if len(shape) > 2 or len(set(shape)) != 1 or 0 in shape or n not in (None, shape[0]):
        message = f"{argument} has shape {shape}, but ({wanted}, {wanted}) is needed, or ({wanted},) for a diagonal"
        raise ValueError(message)
    if len(shape) == 1:
        matrix = sparse.diags_array(matrix.toarray() if is_sparse(matrix) else matrix)
    return sparse.csc_array(matrix)


def symmetric(argument: str, value: ArrayLike | Any, n: int | None = None) -> Any:
    """Return a symmetric matrix as a sparse one in columns, of order n if that is given."""
    matrix = square(argument, value, n)
    difference = abs(matrix - matrix.T).tocoo()
    rows = np.maximum(*(abs(matrix).max(axis=axis).toarray().ravel() for axis in (0, 1)))
    excess = difference.data - _SYMMETRY * np.minimum(*(rows[axis] for axis in difference.coords))
    if np.max(excess, initial=0.0) > 0.0:
        _refuse_triangle(argument, matrix)
        worst = int(np.argmax(excess))
        i, j = (int(axis[worst]) for axis in difference.coords)
        rule = f"{argument}[{j}, {i}] is {matrix[j, i]}: it must be symmetric; (A + A.T) / 2 is, if the difference is rounding"
        _refuse(f"{argument}[{i}, {j}]", float(matrix[i, j]), rule)
    return ((matrix + matrix.T) * 0.5).tocsc()


def _refuse_triangle(argument: str, matrix: Any) -> None:
    """Refuse a matrix of which one side of the diagonal is empty: no half of a difference makes it the one that is meant."""
    library = sparse_library(argument)
    for side, beside in (("upper", library.tril(matrix, -1)), ("lower", library.triu(matrix, 1))):
        if not beside.count_nonzero():
            whole = "A + A.T - scipy.sparse.diags_array(A.diagonal())"
            _refuse(
                argument, f"an {side} triangle" if side == "upper" else f"a {side} triangle", f"both sides are needed: {whole}"
            )


def direction(argument: str, value: Any, n: int) -> NDArray[np.float64]:
    """Return a direction of a model of n unknowns, shape (n,): an index stands for a unit vector."""
    if is_sparse(value):
        vector = _finite_sparse(argument, value).toarray()
        vector = vector.ravel() if vector.shape == (n, 1) else vector
    else:
        try:
            i = index(value)
        except TypeError:
            vector = finite(argument, value)
        else:
            if not 0 <= i < n:
                _refuse(argument, i, f"an index must lie in 0 to {n - 1}, the unknowns of the full model")
            vector = np.zeros(n)
            vector[i] = 1.0
    if vector.shape != (n,):
        message = f"{argument} has shape {vector.shape}, but ({n},), the unknowns of the full model, or an index is needed"
        raise ValueError(message)
    if not vector.any():
        _refuse(argument, "zero everywhere", "a direction must not vanish")
    return np.asarray(vector)


def directions(argument: str, value: Any, n: int) -> NDArray[np.float64]:
    """Return directions as columns, shape (n, k), from a sequence of them or from the columns of a sparse array."""
    if is_sparse(value):
        if len(value.shape) != 2 or value.shape[0] != n:
            message = f"{argument} has shape {value.shape}, but ({n}, k), a direction of the full model in each column, is needed"
            raise ValueError(message)
        each: list[Any] = list(_finite_sparse(argument, value).toarray().T)
    else:
        try:
            each = list(value)
        except TypeError:
            _refuse(argument, repr(value), "a sequence of directions, each an index or an array, is needed")
    columns = [direction(f"{argument}[{i}]", one, n) for i, one in enumerate(each)]
    return np.array(columns).T if columns else np.zeros((n, 0))
