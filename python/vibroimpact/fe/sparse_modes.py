"""Lowest modes and static answers of large structures: ``K phi = w^2 M phi`` and ``K x = f`` with sparse matrices (theory 13).

Factors are those of SuperLU, in doubles. What is answered with them is refined: residuals and quadratic forms are taken in
the extended precision of the machine, where it has one, since what a slow mode of a fine mesh is made of cancels in doubles.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
from numpy.typing import NDArray

from vibroimpact.errors import ConvergenceError

_Array = NDArray[np.float64]

_EPS = float(np.finfo(float).eps)
#: Structures of fewer unknowns, or of which more than a third of the modes are wanted, are taken as dense.
_DENSE = 200
#: Modes beyond those wanted, for a gap in which to count.
_BEYOND = 2
#: Passes of Gram and Schmidt over a column, at the most.
_PASSES = 5
#: Steps of refinement of a static answer; each gains the digits that the factor has.
_REFINEMENTS = 30
#: What is left of a load below this part of it, without what accelerates a free structure, is rounding.
_CANCELLED = 1e-12
#: Squared frequencies beyond this over a rounding of the lowest are looked at by their residuals: rounding, relative to the
#: largest compliance, is a thousandth of their own.
_WIDE = 1e-3
#: Residual of such a mode, relative to its squared frequency.
_RESIDUAL = 1e-6
#: Pivots of a mass below this, relative to its diagonal and for each unknown, are zero.
_SINGULAR = _EPS


def symmetric_factor(matrix: Any) -> Any:
    """Factor a symmetric matrix with pivots on its diagonal, or return None where one of them is exactly zero."""
    options = {"SymmetricMode": True}
    csc = scipy.sparse.csc_array(matrix)
    try:
        factor = scipy.sparse.linalg.splu(csc, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    except RuntimeError:  # exactly singular
        return None
    return factor if np.array_equal(factor.perm_r, factor.perm_c) else None


def negative_pivots(factor: Any) -> int:
    """Return the number of negative eigenvalues of the matrix that was factored (Sylvester's law of inertia)."""
    return int(np.count_nonzero(factor.U.diagonal() <= 0.0))


def check_mass(mass: Any) -> None:
    """Refuse a mass that is singular or not positive definite."""
    rule = "it must be positive definite: coordinates without mass, whose rows are zero, are condensed first"
    diagonal = mass.diagonal()
    for i in np.flatnonzero(diagonal <= 0.0)[:1]:
        message = f"mass[{i}, {i}] is {diagonal[i]}, but {rule}"
        raise ValueError(message)
    if positive_factor(mass) is None:
        message = f"mass is singular or has negative eigenvalues, but {rule}"
        raise ValueError(message)


def positive_factor(matrix: Any) -> Any:
    """Factor a symmetric matrix, or return None where it is not positive definite beyond rounding."""
    diagonal = matrix.diagonal()
    factor = symmetric_factor(matrix) if (diagonal > 0.0).all() else None
    if factor is None:
        return None
    ratio = np.asarray(factor.U.diagonal()[factor.perm_c]) / diagonal
    return factor if ratio.min() > _SINGULAR * len(diagonal) else None


def orthonormalise(columns: _Array, mass: Any, against: _Array, drop: float = 0.0) -> _Array:
    """Make columns M-orthonormal to others and in themselves; drop those of which no more than a part is left.

    Gram and Schmidt, again until a column keeps half its length, as a rule once; one that never does is rounding, and dropped.
    """
    first = n_basis = against.shape[1]
    basis = np.zeros((len(columns), first + columns.shape[1]), order="F")
    basis[:, :first] = against
    for column in columns.T:
        vector, left = column, 1.0
        length = np.sqrt(vector @ (mass @ vector))
        for _ in range(_PASSES):
            if not length > 0.0:
                break
            vector = vector / length
            vector = vector - basis[:, :n_basis] @ (basis[:, :n_basis].T @ (mass @ vector))
            length = np.sqrt(vector @ (mass @ vector))
            left *= length
            if left <= drop:
                break
            if length > 0.5:
                basis[:, n_basis] = vector / length
                n_basis += 1
                break
    return basis[:, first:n_basis]


def _extended_form(matrix: Any, columns: _Array) -> NDArray[np.longdouble]:
    extended = np.longdouble
    image = matrix.tocsr().astype(extended) @ columns.astype(extended)
    return np.asarray(columns.T.astype(extended) @ image)


def quadratic(matrix: Any, columns: _Array) -> _Array:
    """``V^T A V`` summed in the extended precision of the machine."""
    return _extended_form(matrix, columns).astype(float)


def ritz(stiffness: Any, columns: _Array) -> tuple[_Array, _Array]:
    """Squared frequencies, ascending, and shapes of the structure within the span of M-orthonormal columns."""
    form = _extended_form(stiffness, columns)
    form = (form + form.T) * 0.5
    _, turn = scipy.linalg.eigh(form.astype(float))
    # Eigenvalues are known to the rounding of the largest, their quotients to that of their own terms.
    values = np.einsum("ij,ij->j", turn, form @ turn.astype(np.longdouble)).astype(float)
    return values, columns @ turn


def indefinite(negative: int) -> str:
    """Return what is said of a stiffness with negative eigenvalues."""
    return (
        f"stiffness has {negative} negative eigenvalue(s), but it must be positive definite, or semidefinite if it is free; "
        "matrices written with few digits are not; beyond a buckling load there are no frequencies (LinearSystem takes such a K)"
    )


class Flexibility:
    """Static answers ``X = K^-1 F``; of a free structure those without rigid-body motion to loads that leave it where it is.

    With the rigid-body modes R they are the X of ``[[K, M R], [(M R)^T, 0]] (X, .) = (F, 0)``: it takes ``M R R^T F`` off the
    loads, and ``R^T M X = 0``. To such loads a structure answers the same wherever it is held, if no more than just held: as
    many coordinates are, what is left of K is positive definite, and the rigid-body motion is taken off the answer.
    """

    def __init__(self, stiffness: Any, mass: Any, rigid: _Array) -> None:
        self._rigid = rigid
        self._inertia = mass @ rigid
        self._loose = np.sort(pivots(rigid, mass)[rigid.shape[1] :])
        self._factor = symmetric_factor(stiffness[self._loose][:, self._loose])
        if self._factor is None:
            message = "the stiffness could not be factored: a pivot is zero, though no motion has no stiffness"
            raise ConvergenceError(message)
        if negative_pivots(self._factor):
            raise ValueError(indefinite(negative_pivots(self._factor)))
        self._extended = scipy.sparse.csr_array(stiffness).astype(np.longdouble)

    def elastic_part(self, loads: _Array) -> _Array:
        """Take off loads what moves the structure as a rigid body; what is left of rounding is zero."""
        if self._rigid.shape[1] == 0:
            return loads
        part = loads - self._inertia @ (self._rigid.T @ loads)
        is_rounding = np.linalg.norm(part, axis=0) <= _CANCELLED * np.linalg.norm(loads, axis=0)
        return np.where(is_rounding, 0.0, part)

    def apply(self, loads: _Array) -> _Array:
        """Return the static answers to loads, shape (n,) or (n, k), with the digits of the factor."""
        part = self.elastic_part(loads)
        answers = np.zeros(loads.shape, order="F")
        answers[self._loose] = self._factor.solve(np.asfortranarray(part[self._loose]))
        return np.asarray(answers - self._rigid @ (self._inertia.T @ answers))

    def solve(self, loads: _Array) -> _Array:
        """Return the static answers to loads, shape (n, k), refined until they no longer change."""
        part = self.elastic_part(loads)
        answers = self.apply(part)
        sizes = np.abs(answers).max(axis=0, initial=0.0)
        sizes[sizes == 0.0] = 1.0
        before = np.inf
        for _ in range(_REFINEMENTS):
            residual = np.asarray(part - self._extended @ answers.astype(np.longdouble), dtype=float)
            change = self.apply(residual)
            relative = np.max(np.abs(change).max(axis=0, initial=0.0) / sizes, initial=0.0)
            if not relative < 0.5 * before:
                break
            answers = answers + change
            before = relative
        return answers


def pivots(rigid: _Array, mass: Any) -> NDArray[np.int64]:
    """Order coordinates so that the rigid-body modes are most independent at the first of them, in units of the mass."""
    if rigid.shape[1] == 0:
        return np.arange(len(rigid))
    weighted = rigid * np.sqrt(mass.diagonal())[:, np.newaxis]
    return np.asarray(scipy.linalg.qr(weighted.T, mode="r", pivoting=True)[1])


def count_below(stiffness: Any, mass: Any, value: float) -> int:
    """Return the number of squared frequencies below a value, by the signs of pivots (a Sturm sequence)."""
    for nudge in (0.0, 1e-12, 1e-10, 1e-8):
        factor = symmetric_factor(stiffness - value * (1.0 + nudge) * mass)
        if factor is not None:
            return negative_pivots(factor)
    message = "the modes below a frequency could not be counted: the factor of K - w^2 M has a pivot of zero"
    raise ConvergenceError(message)


def elastic_modes(stiffness: Any, mass: Any, flexibility: Flexibility, rigid: _Array, n_modes: int) -> tuple[_Array, _Array]:
    """Squared frequencies (n_modes,) and M-orthonormal shapes (n, n_modes) of the lowest elastic modes, ascending."""
    n = mass.shape[0]
    left = n - rigid.shape[1]
    if n_modes == 0:
        return np.zeros(0), np.zeros((n, 0))
    beyond = _BEYOND
    for attempt in range(3):
        wanted = min(n_modes + beyond, left)
        is_dense = n <= _DENSE or 3 * wanted > n
        if is_dense:
            found = _dense_modes(mass, flexibility, wanted, n_modes)
        else:
            found = _lanczos_modes(stiffness, mass, flexibility, wanted, attempt)
        squares, shapes = _inverse_iteration(mass, flexibility, rigid, found)
        if wanted == left or _none_missing(stiffness, mass, rigid.shape[1], squares[n_modes - 1 :], n_modes):
            return squares[:n_modes], shapes[:, :n_modes]
        beyond = 4 * beyond
    message = (
        f"the lowest {n_modes} modes could not all be found: a count by pivots disagrees; ask for a few modes more or less, "
        "so that no group of equal frequencies is cut"
    )
    raise ConvergenceError(message)


def _inverse_iteration(mass: Any, flexibility: Flexibility, rigid: _Array, shapes: _Array) -> tuple[_Array, _Array]:
    """Take a step with refined answers, which rounding of factors does not reach, and the modes in its span.

    With ``K z = M phi`` the forms ``z.K z = z.M phi`` and ``z.M z`` have all digits, since nothing cancels in them. The small
    eigenproblem is that of the compliances ``1/w^2``: its errors are relative to the largest compliance, as those of a static
    answer.
    """
    loads = mass @ shapes
    answers = flexibility.solve(loads)
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = 1.0 / np.sqrt(np.einsum("ij,ij->j", answers, loads))
    answers, loads = answers * scale, loads * scale
    energy = loads.T @ answers
    try:
        _, turn = scipy.linalg.eigh(answers.T @ (mass @ answers), (energy + energy.T) * 0.5)
    except (np.linalg.LinAlgError, ValueError):
        message = "the modes that were found depend on each other: doubles do not hold so wide a range of frequencies"
        raise ConvergenceError(message) from None
    turn = turn[:, ::-1]
    answers, loads = answers @ turn, loads @ turn
    squares = np.einsum("ij,ij->j", answers, loads) / np.einsum("ij,ij->j", answers, mass @ answers)
    return squares, orthonormalise(answers, mass, rigid)


def _none_missing(stiffness: Any, mass: Any, n_rigid: int, last: _Array, n_modes: int) -> bool:
    """Whether as many modes lie below the widest gap behind the last wanted one as were found there."""
    if len(last) == 1:
        last = np.append(last, last[0] / _EPS)
    gaps = last[1:] / last[:-1]
    widest = int(np.argmax(gaps))
    value = float(np.sqrt(last[widest] * last[widest + 1]))
    return count_below(stiffness, mass, value) == n_rigid + n_modes + widest


def check_range(stiffness: Any, mass: Any, squares: _Array, shapes: _Array) -> None:
    """Refuse modes so far above the lowest that rounding may have made them, but those of ``K phi = w^2 M phi`` too."""
    far = squares > _WIDE / _EPS * squares.min(initial=np.inf)
    if not far.any():
        return
    residual = stiffness @ shapes[:, far] - mass @ shapes[:, far] * squares[far]
    sizes = np.sqrt(np.einsum("ij,ij->j", residual, symmetric_factor(mass).solve(np.asfortranarray(residual)))) / squares[far]
    if np.all(sizes <= _RESIDUAL) and np.all(np.diff(squares) >= -_RESIDUAL * squares[1:]):
        return
    message = (
        f"the modes reach over more than doubles hold: the squared frequencies lie a factor of "
        f"{squares.max() / squares.min():.1g} apart; {stiffest(stiffness, mass)}: ask for fewer modes"
    )
    raise ConvergenceError(message)


def stiffest(stiffness: Any, mass: Any) -> str:
    """Say which unknown is the stiffest beside its mass, as one clamped by a penalty is."""
    ratios = stiffness.diagonal() / mass.diagonal()
    i = int(np.argmax(ratios))
    return f"unknown {i} is {ratios[i] / np.median(ratios):.1g} times as stiff, beside its mass, as half of the others"


def clamped(loads: _Array, answers: _Array, mass: Any, lowest: float) -> NDArray[np.int64]:
    """Return the directions along which nothing moves, as at an unknown clamped by a penalty.

    Their static compliance, in units of what the mass alone gives, is below the rounding of that of the lowest mode.
    """
    compliance = np.einsum("ij,ij->j", loads, answers)
    mobility = np.einsum("ij,ij->j", loads, symmetric_factor(mass).solve(np.asfortranarray(loads)))
    return np.flatnonzero((compliance > 0.0) & (compliance * lowest < _EPS * mobility))


def _dense_modes(mass: Any, flexibility: Flexibility, n_modes: int, least: int) -> _Array:
    """Return the lowest elastic modes, so many at least, as the largest compliances ``1/w^2``.

    These are eigenvalues of ``L^T K^-1 L`` with ``M = L L^T``.

    Rounding is relative to the largest of them, so that the lowest modes are right whatever the stiffest unknown is, as one
    clamped by a penalty; a rigid-body motion has none.
    """
    factor = scipy.linalg.cholesky(mass.toarray(), lower=True)
    compliance = factor.T @ flexibility.apply(factor)
    last = len(factor) - 1
    values, turned = scipy.linalg.eigh((compliance + compliance.T) * 0.5, subset_by_index=[last + 1 - n_modes, last])
    # Those beyond the last one wanted may be too far to be anything but rounding.
    is_there = values > _EPS * len(factor) * values[-1]
    is_there[-least:] = True
    turned = turned[:, is_there]
    return np.asarray(scipy.linalg.solve_triangular(factor, turned[:, ::-1], lower=True, trans="T"))


def _lanczos_modes(stiffness: Any, mass: Any, flexibility: Flexibility, n_modes: int, attempt: int) -> _Array:
    """Return modes by the Lanczos method with the inverse of K, of a free structure that without rigid-body motion."""
    n = mass.shape[0]
    operator = scipy.sparse.linalg.LinearOperator((n, n), matvec=flexibility.apply, dtype=float)
    start = flexibility.apply(mass @ np.random.default_rng(attempt).standard_normal(n))
    try:
        _, shapes = scipy.sparse.linalg.eigsh(stiffness, n_modes, mass, sigma=0.0, OPinv=operator, v0=start)
    except scipy.sparse.linalg.ArpackError as error:
        message = f"the Lanczos method for {n_modes} modes did not converge: {error}"
        raise ConvergenceError(message) from None
    return np.asarray(shapes)
