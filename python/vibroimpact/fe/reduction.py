"""Reduction of finite-element models to a few modes and the static answers that the others would give (theory 13)."""

from __future__ import annotations

from dataclasses import dataclass, fields
from operator import index
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vibroimpact._core import LinearSystem, _numbers
from vibroimpact.fe import matrices

__all__ = ["Reduction", "reduce"]

_Array = NDArray[np.float64]

#: Residual vectors of which less than this part is left beside the modes are dropped.
_DROPPED = 1e-10
#: Entries beside the diagonal of the damping below this, relative to its largest, are rounding: the modes uncouple.
_UNCOUPLED = 1e-12


@dataclass(frozen=True, eq=False)
class Reduction:
    """A finite-element model in a basis of modes and residual vectors; made by ``reduce``.

    Attributes
    ----------
    system : LinearSystem
        The reduced system of m coordinates: unit masses, squared frequencies for its stiffness, ascending.
    basis : ndarray, shape (N, m)
        Modes and residual vectors of the full model as columns, with ``basis.T @ M @ basis`` the identity. The largest entry
        of each is positive. It is read-only.
    static_error : float
        Largest relative error of the static compliance ``n.K^-1 n`` over the directions given, of a free structure that of
        its elastic part; zero without directions.
    """

    system: LinearSystem
    basis: _Array
    static_error: float

    def __post_init__(self) -> None:
        """Refuse a basis that is none of the system; make it read-only."""
        basis = np.array(self.basis, dtype=float, order="F")
        if basis.ndim != 2 or basis.shape[1] != self.system.n_dof:
            message = f"basis has shape {basis.shape}, but (N, {self.system.n_dof}) is needed"
            raise ValueError(message)
        basis.flags.writeable = False
        object.__setattr__(self, "basis", basis)

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the arguments, which are looked at again."""
        return Reduction, tuple(getattr(self, field.name) for field in fields(self))

    def direction(self, n: Any) -> _Array:
        """Return a direction of the full model in the reduced one: the normal of a stop, the amplitude of a force.

        Parameters
        ----------
        n : int or array_like, shape (N,)
            Index of an unknown of the full model, or a direction.

        Returns
        -------
        ndarray, shape (m,)
            ``basis.T @ n``.

        Raises
        ------
        ValueError
            A direction of another length, one that vanishes or is not finite.
        """
        return self.basis.T @ matrices.direction("n", n, len(self.basis))

    def physical(self, q: ArrayLike) -> _Array:
        """Return positions, velocities or accelerations of the full model.

        Parameters
        ----------
        q : array_like, shape (..., m)
            Those of the reduced one.

        Returns
        -------
        ndarray, shape (..., N)
            ``q @ basis.T``.

        Raises
        ------
        ValueError
            An array whose last axis is not m long.
        """
        reduced = _numbers("q", q)
        m = self.basis.shape[1]
        if reduced.ndim == 0 or reduced.shape[-1] != m:
            message = f"q has shape {reduced.shape}, but (..., {m}), the coordinates of the reduced system, is needed"
            raise ValueError(message)
        return reduced @ self.basis.T

    def participating_mass(self, n: Any) -> float:
        """Return the mass ``1/(n.M^-1 n)`` that takes part in an impact along a direction.

        It falls as modes are added: see the Notes of ``reduce``.

        Parameters
        ----------
        n : int or array_like, shape (N,)
            Index of an unknown of the full model, or a direction.

        Returns
        -------
        float
            In the unit of mass for a direction of length 1; infinite if no column of the basis moves along it.

        Raises
        ------
        ValueError
            As for ``direction``.
        """
        mobility = float(np.sum(self.direction(n) ** 2))
        return 1.0 / mobility if mobility > 0.0 else np.inf

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of the reduction and of its system, for ``numpy.savez``."""
        system = {name: getattr(self.system, name) for name in ("mass", "damping", "stiffness", "load", "influence")}
        arrays = {"basis": self.basis, "static_error": np.float64(self.static_error), **system}
        return {name: np.asarray(array) for name, array in arrays.items() if array is not None}

    def __repr__(self) -> str:
        """Say what was reduced to what, and how well it answers static loads."""
        n, m = self.basis.shape
        frequencies = np.sqrt(self.system.stiffness)
        n_rigid = int(np.count_nonzero(frequencies == 0.0))
        rigid = f"{n_rigid} of them rigid-body modes, " if n_rigid else ""
        return (
            f"Reduction({n} unknowns to {m}: {rigid}natural frequencies {frequencies[n_rigid:].min(initial=np.inf):.6g} to "
            f"{frequencies.max():.6g} rad/s, static error {self.static_error:.1e})"
        )


def reduce(
    mass: ArrayLike | Any,
    damping: ArrayLike | Any | None,
    stiffness: ArrayLike | Any,
    *,
    n_modes: int | None = None,
    up_to: float | None = None,
    rigid_modes: int | None = None,
    directions: Any = (),
    load: ArrayLike | None = None,
    influence: ArrayLike | None = None,
    residual: bool = True,
) -> Reduction:
    """Reduce a finite-element model to its lowest modes and, for directions that matter, its exact static compliance.

    Needs SciPy, the extra ``fe``.

    Parameters
    ----------
    mass : sparse array or array_like, shape (N, N) or (N,)
        Mass matrix M, symmetric positive definite; ``(N,)`` is a diagonal. Coordinates without mass, whose rows are zero, are
        condensed first, by ``-K_ss^-1 K_sm``; they carry no stop or force.
    damping : None, float, array_like of shape (m,), or matrix of shape (N, N)
        None: no damping. A number not below zero: the damping ratio of every mode [-]. An array: that of each mode,
        rigid-body modes included; residual vectors take the last one unless it has one for each of them too. A matrix, sparse
        or not: the damping matrix C.
    stiffness : sparse array or array_like, shape (N, N) or (N,)
        Stiffness matrix K, symmetric, positive definite or, for a structure that nothing holds, semidefinite.
    n_modes : int, optional
        How many of the lowest modes to keep, rigid-body modes included: from their number to that of the coordinates with mass.
    up_to : float, optional
        Keep the modes of natural frequencies up to this [rad/s], in place of ``n_modes``.
    rigid_modes : int, optional
        How many rigid-body modes there are, 6 of a body that nothing holds; default what the squared frequencies say, see the
        Notes. For matrices written with fewer digits, of which that many of the lowest modes get a frequency of zero.
    directions : sequence of int or array_like of shape (N,), or sparse array of shape (N, k), optional
        Directions of stops, forces and sensors: each the index of an unknown or an array, or all of them the columns of a
        sparse array.
    load : array_like, shape (N,), optional
        Constant force.
    influence : array_like, shape (N,), optional
        Influence vector r: a base displacement u adds the force ``-M r u''``.
    residual : bool, default True
        Add a residual vector for each direction: what the modes left out give to its static answer.

    Returns
    -------
    Reduction
        The reduced system, its basis, and directions of the full model in it.

    Raises
    ------
    ValueError
        Matrices that are not square, not of one size, not symmetric (one triangle is not) or not finite; a mass that is singular
        or not positive definite beside rows of zeros, unknowns with neither mass nor stiffness, directions or loads at unknowns
        without mass; a stiffness with negative eigenvalues; both or neither of ``n_modes`` and ``up_to``, fewer modes than
        rigid-body modes, more than unknowns; other ``rigid_modes`` than there may be; directions, loads or damping ratios of
        another length; numbers that are negative or not finite.
    ConvergenceError
        Modes that were not found, or not all of them, as a count by the signs of pivots says; modes whose squared frequencies
        are farther apart than doubles hold.
    ImportError
        SciPy is not installed.

    Notes
    -----
    *Clamped unknowns*, whose diagonal of K some programs set to 1e36, may be left in: modes and static answers are those of the
    clamped structure, of which there are fewer. A direction along which nothing moves beside that is refused.

    *Modes* come from a shift-invert Lanczos method, with a count by the inertia of ``K - s M`` that none is missing [1]_. A
    structure is free if modes have a squared frequency within the rounding of the entries of K, or within what is left where
    these have lost digits, up to a rounding of 1e-12, if all others lie a thousand times beyond; these modes get a frequency of
    zero. ``rigid_modes`` says how many they are where that is not so, 0 of a structure that is held as softly as that.

    *Residual flexibility* [1]_: with ``X = K^-1 N`` for the directions N, the residual vectors are what is left of X beside
    the modes. The static compliance ``n.K^-1 n``, also between two directions, is then that of the full model, with any
    number of modes. Loads of a free structure are answered less its rigid-body motion.

    *What it does to impacts.* Newton's law sees ``n.M^-1 n``, a sum over all columns of the basis that grows with the number
    of modes, for a bar or a beam without bound. The mass that takes part in the instant of an impact, ``participating_mass``,
    falls as modes are added, and one restitution coefficient then means another loss of energy: a restitution coefficient
    belongs to a number of modes, and is to be chosen or measured with it (theory, section 13).

    References
    ----------
    .. [1] M. Geradin, D. J. Rixen, Mechanical Vibrations, 3rd ed., Wiley 2015, ch. 6 and 7.

    Examples
    --------
    A bar of 1000 elements, clamped at one end, with a stop at the other: five modes and the static compliance of its tip.

    >>> import numpy as np
    >>> import scipy.sparse as sp
    >>> import vibroimpact as vi
    >>> n = 1000
    >>> line = np.ones(n)
    >>> stiffness = n * sp.diags_array([-line[1:], np.append(2 * line[1:], 1.0), -line[1:]], offsets=[-1, 0, 1])
    >>> mass = np.append(line[1:], 0.5) / n
    >>> bar = vi.reduce(mass, 0.01, stiffness, n_modes=5, directions=[n - 1])
    >>> bar.system.n_dof
    6
    >>> (2 / np.pi * np.sqrt(bar.system.stiffness[:3])).round(4)
    array([1., 3., 5.])
    >>> tip = bar.direction(n - 1)
    >>> round(float(tip @ (tip / bar.system.stiffness)), 10)  # the bar's length over its stiffness
    1.0
    >>> scene = vi.Scene(bar.system, vi.Harmonic(tip, 1.5), vi.Stop(tip, 0.1, 0.8))
    """
    matrices.sparse_library("vibroimpact.reduce")
    from vibroimpact.fe import rigid_body, sparse_modes
    from vibroimpact.fe.condensation import Condensation

    m = matrices.symmetric("mass", mass)
    n = m.shape[0]
    k = matrices.symmetric("stiffness", stiffness, n)
    loads = matrices.directions("directions", directions, n)
    f0, r = _vector("load", load, n), _vector("influence", influence, n)
    given = _given_damping(damping, n)
    condensed = Condensation(m, k)
    n = condensed.n
    loads = condensed.forces("directions", loads)
    if f0 is not None:
        condensed.forces("load", f0)
    count, highest = _choice(n_modes, up_to, n)
    n_rigid = _rigid(rigid_modes, n)
    sparse_modes.check_mass(condensed.mass)
    # In units of their largest entries, so that no unit of the user's takes anything out of the doubles.
    of_mass, of_stiffness = (_power_of_four(float(abs(matrix).max())) for matrix in (m, condensed.stiffness))
    mass, stiffness = condensed.mass / of_mass, condensed.stiffness / of_stiffness
    rigid = rigid_body.rigid_body_modes(stiffness, mass, n if count is None else count, n_rigid)
    if count is None:
        count = max(sparse_modes.count_below(stiffness, mass, highest / of_stiffness * of_mass), rigid.shape[1])
    elif count < rigid.shape[1]:
        message = f"n_modes is {n_modes}, but rigid-body modes are kept, and the structure has {rigid.shape[1]} or more of them"
        raise ValueError(message)
    flexibility = sparse_modes.Flexibility(stiffness, mass, rigid)
    squares, elastic = sparse_modes.elastic_modes(stiffness, mass, flexibility, rigid, count - rigid.shape[1])
    sparse_modes.check_range(stiffness, mass, squares, elastic)
    answers = flexibility.solve(loads)
    if loads.size and squares.size:
        for i in sparse_modes.clamped(flexibility.elastic_part(loads), answers, mass, float(squares[0]))[:1]:
            told = sparse_modes.stiffest(stiffness, mass)
            message = (
                f"directions[{i}] is one along which nothing moves, beside the rounding of other motions: {told}; leave it out"
            )
            raise ValueError(message)
    if residual:
        left = sparse_modes.orthonormalise(answers, mass, np.hstack([rigid, elastic]), _DROPPED)
        more, left = sparse_modes.ritz(stiffness, left)
        squares, elastic = np.append(squares, more), np.hstack([elastic, left])
    basis = _with_signs(np.hstack([rigid, elastic]))
    if basis.shape[1] == 0:
        message = f"up_to is {up_to}, but no natural frequency is as low: it must be larger"
        raise ValueError(message)
    squares = np.append(np.zeros(rigid.shape[1]), squares)
    exact = np.einsum("ij,ij->j", flexibility.elastic_part(loads), answers)
    error = _static_error(squares, basis.T @ loads, exact)
    squares, basis = squares * of_stiffness / of_mass, condensed.whole(basis / np.sqrt(of_mass))
    c = sparse_modes.quadratic(given, basis) if matrices.is_sparse(given) else given
    system = LinearSystem(
        np.ones(len(squares)),
        _modal_damping(c, np.sqrt(squares), count),
        squares,
        None if f0 is None else basis.T @ f0,
        None if r is None else basis.T @ (m @ r),
    )
    return Reduction(system, basis, error)


def _power_of_four(value: float) -> float:
    """Return the power of four below a number, 1 for zero: numbers divided by it, and by its root, keep all their digits."""
    return 4.0 ** (np.frexp(value)[1] // 2 - 1) if value > 0.0 else 1.0


def _vector(argument: str, value: ArrayLike | None, n: int) -> _Array | None:
    """Return a vector of the full model, which may vanish."""
    if value is None:
        return None
    vector = np.atleast_1d(matrices.finite(argument, value))
    if vector.shape != (n,):
        message = f"{argument} has shape {vector.shape}, but ({n},), the unknowns of the full model, is needed"
        raise ValueError(message)
    return vector


def _choice(n_modes: int | None, up_to: float | None, n: int) -> tuple[int | None, float]:
    """Return a number of modes, or None and a squared frequency; refuse both or neither, and what is none of these."""
    if (n_modes is None) == (up_to is None):
        message = (
            f"n_modes is {n_modes} and up_to is {up_to}, but one of the two is needed: how many modes, or up to which frequency"
        )
        raise ValueError(message)
    if n_modes is None:
        highest = matrices.number("up_to", up_to)
        square = highest * highest
        if not (highest > 0.0 and 0.0 < square < np.inf):
            message = f"up_to is {up_to}, but it must be a frequency above zero [rad/s] whose square is one of the doubles"
            raise ValueError(message)
        return None, square
    return _count("n_modes", n_modes, 1, n), 0.0


def _rigid(rigid_modes: int | None, n: int) -> int | None:
    """Return a number of rigid-body modes, None where it is to be found."""
    return None if rigid_modes is None else _count("rigid_modes", rigid_modes, 0, n)


def _count(name: str, value: Any, least: int, n: int) -> int:
    """Return a number of modes, of n at the most."""
    try:
        count = index(value)
    except TypeError:
        message = f"{name} is {value!r}, but a whole number is needed"
        raise TypeError(message) from None
    if not least <= count <= n:
        message = f"{name} is {count}, but it must lie in {least} to {n}, the number of unknowns with mass"
        raise ValueError(message)
    return count


def _given_damping(damping: Any, n: int) -> Any:
    """Return None, damping ratios of shape () or (m,), or a sparse matrix."""
    if damping is None:
        return None
    if matrices.is_sparse(damping) or np.ndim(damping) == 2:
        return matrices.square("damping", damping, n)
    ratios = matrices.finite("damping", damping)
    if ratios.ndim > 1:
        message = f"damping has shape {ratios.shape}, but a number, (m,) for damping ratios or ({n}, {n}) is needed"
        raise ValueError(message)
    for i in np.flatnonzero(ratios < 0.0)[:1]:
        name = f"damping[{i}]" if ratios.ndim else "damping"
        message = f"{name} is {ratios.flat[i]}, but a damping ratio must not be below zero: modes that grow have a matrix C"
        raise ValueError(message)
    return ratios


def _modal_damping(given: _Array | None, frequencies: _Array, n_modes: int) -> _Array:
    """Return the damping of the reduced system from damping ratios, or from its matrix: the diagonal where it is one."""
    if given is None:
        return np.zeros(len(frequencies))
    if given.ndim == 2:
        diagonal = np.diag(given)
        uncouples = np.abs(given - np.diag(diagonal)).max() <= _UNCOUPLED * np.abs(diagonal).max()
        return diagonal if uncouples else given
    m = len(frequencies)
    if given.ndim == 1 and len(given) not in (n_modes, m):
        which = f"({n_modes},), a ratio for each mode" + (f", or ({m},), for residual vectors too" if m > n_modes else "")
        message = f"damping has shape {given.shape}, but a number, {which}, or a matrix is needed"
        raise ValueError(message)
    if given.ndim == 1 and 0 < len(given) < m:
        given = np.append(given, np.full(m - len(given), given[-1]))
    return 2.0 * given * frequencies


def _with_signs(basis: _Array) -> _Array:
    """Turn each column so that its largest entry is positive, of two as large the first."""
    sizes = np.abs(basis)
    first = np.argmax(sizes > (1.0 - 1e-6) * sizes.max(axis=0, initial=0.0), axis=0)
    return basis * np.where(np.take_along_axis(basis, first[np.newaxis], axis=0)[0] < 0.0, -1.0, 1.0)


def _static_error(squares: _Array, reduced: _Array, exact: _Array) -> float:
    """Return the largest relative error of the static compliances of the elastic part."""
    is_elastic = squares > 0.0
    compliance = np.sum(reduced[is_elastic] ** 2 / squares[is_elastic, np.newaxis], axis=0)
    errors = np.abs(compliance - exact)[exact > 0.0] / exact[exact > 0.0]
    return float(np.max(errors, initial=0.0))
