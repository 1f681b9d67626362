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
#: A mode is a rigid-body mode if its squared frequency is within so many times what random rounding of the entries of K makes
#: of it. Of structures that nothing holds it is within 2, of held ones beyond 1e4 but for meshes so fine that doubles hardly
#: hold them.
_ROUNDINGS = 8.0
#: Shifts that are tried, each a hundred times the one before, until rounding leaves ``K + s M`` positive definite.
_SHIFT_STEP = 100.0
#: The last of them relative to the rounding of the fastest coordinate: what is negative beyond it is negative.
_LAST_SHIFT = 1e4
#: Vectors that are iterated to find the rigid-body modes, at first.
_BLOCK = 8
#: Steps of their iteration at the most; a few do but where no shift is small beside the first squared frequency.
_ITERATIONS = 100
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
#: Pivots of a mass below this, relative to its diagonal and for each unknown, are zero.
_SINGULAR = _EPS


def _symmetric_factor(matrix: Any) -> Any:
    """Factor a symmetric matrix with pivots on its diagonal, or return None where one of them is exactly zero."""
    options = {"SymmetricMode": True}
    csc = scipy.sparse.csc_array(matrix)
    try:
        factor = scipy.sparse.linalg.splu(csc, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    except RuntimeError:  # exactly singular
        return None
    return factor if np.array_equal(factor.perm_r, factor.perm_c) else None


def _negative_pivots(factor: Any) -> int:
    """Return the number of negative eigenvalues of the matrix that was factored (Sylvester's law of inertia)."""
    return int(np.count_nonzero(factor.U.diagonal() <= 0.0))


def check_mass(mass: Any) -> None:
    """Refuse a mass that is singular or not positive definite."""
    condense = "coordinates without mass are condensed first, by -K_ss^-1 K_sm, and carry no stop or force"
    diagonal = mass.diagonal()
    for i in np.flatnonzero(diagonal <= 0.0)[:1]:
        message = f"mass[{i}, {i}] is {diagonal[i]}, but the mass must be positive definite: {condense}"
        raise ValueError(message)
    factor = _symmetric_factor(mass)
    if factor is not None:
        pivots = np.empty(len(diagonal))
        pivots[:] = factor.U.diagonal()[factor.perm_c]
        ratio = pivots / diagonal
        if ratio.min() > _SINGULAR * len(diagonal):
            return
    message = f"mass is singular or has negative eigenvalues, but it must be positive definite: {condense}"
    raise ValueError(message)


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


def _rounding(stiffness: Any, shapes: _Array) -> _Array:
    """Return what random rounding of the entries of K makes of the squared frequency of each shape (the root of squares)."""
    squares = shapes**2
    return np.asarray(_EPS * np.sqrt(np.einsum("ij,ij->j", squares, stiffness.power(2) @ squares)))


def _shifted_factor(stiffness: Any, mass: Any) -> Any:
    """Factor ``K + s M`` with the least shift tried with which rounding leaves it positive definite."""
    ratios = np.abs(stiffness.diagonal()) / mass.diagonal()
    if not ratios.any():
        shift, last = 1.0, 1.0
    else:
        shift, last = _ROUNDINGS * _EPS * ratios[ratios > 0.0].min(), _LAST_SHIFT * _EPS * ratios.max()
    negative = 0
    while shift <= last:
        factor = _symmetric_factor(stiffness + shift * mass)
        if factor is not None:
            negative = _negative_pivots(factor)
            if negative == 0:
                return factor
        shift *= _SHIFT_STEP
    raise ValueError(_indefinite(negative))


def _indefinite(negative: int) -> str:
    return (
        f"stiffness has {negative} negative eigenvalue(s), but it must be positive definite, or semidefinite if it is free; "
        "matrices written with few digits are not; beyond a buckling load there are no frequencies (LinearSystem takes such a K)"
    )


def rigid_body_modes(stiffness: Any, mass: Any, most: int) -> _Array:
    """M-orthonormal rigid-body modes, shape (n, r): motions without strain, with frequency zero to the rounding of K.

    Subspace iteration with ``K + s M``, s a small shift: what has no stiffness is ahead of all else by the ratio of the first
    elastic squared frequency to s, and a block misses no mode of a multiple frequency. If there are more than ``most``, some
    of them.
    """
    n = mass.shape[0]
    factor = _shifted_factor(stiffness, mass)
    size = min(n, _BLOCK)
    while True:
        values, shapes = _subspace_iteration(stiffness, mass, factor, size)
        rounding = _ROUNDINGS * _rounding(stiffness, shapes)
        if np.any(values < -rounding):
            raise ValueError(_indefinite(int(np.count_nonzero(values < -rounding))))
        is_rigid = values <= rounding
        if size == n or size > most or not is_rigid.all():
            return _in_order(shapes[:, is_rigid], mass)
        size = min(n, 4 * size)


def _subspace_iteration(stiffness: Any, mass: Any, factor: Any, size: int) -> tuple[_Array, _Array]:
    """Iterate a block until all its squared frequencies but the last have settled to a tenth, or are rounding."""
    none = np.zeros((mass.shape[0], 0))
    random = np.random.default_rng(0)
    shapes = random.standard_normal((mass.shape[0], size))
    n_settled = max(1, size - 1)
    before = np.full(n_settled, np.inf)
    for _ in range(_ITERATIONS):
        shapes = orthonormalise(factor.solve(mass @ shapes), mass, none)
        # Beside what has no stiffness, columns may be left without a digit of anything else.
        fresh = random.standard_normal((mass.shape[0], size - shapes.shape[1]))
        shapes = np.hstack([shapes, orthonormalise(fresh, mass, shapes)])
        if shapes.shape[1] < size:
            message = "rigid-body modes could not be looked for: in doubles the mass does not tell the coordinates apart"
            raise ConvergenceError(message)
        values, shapes = ritz(stiffness, shapes)
        now = values[:n_settled]
        if np.all(np.abs(now - before) <= 0.1 * np.abs(now) + _ROUNDINGS * _rounding(stiffness, shapes[:, :n_settled])):
            break
        before = now
    return values, shapes


def _in_order(rigid: _Array, mass: Any) -> _Array:
    """Turn rigid-body modes, of which any rotation is as good, to where each has no part at the coordinates of those before."""
    n_rigid = rigid.shape[1]
    if n_rigid == 0:
        return rigid
    turn, _ = scipy.linalg.qr(rigid[_pivots(rigid, mass)[:n_rigid]].T)
    return np.asarray(rigid @ turn)


class Flexibility:
    """Static answers ``X = K^-1 F``; of a free structure those without rigid-body motion to loads that leave it where it is.

    With the rigid-body modes R they are the X of ``[[K, M R], [(M R)^T, 0]] (X, .) = (F, 0)``: it takes ``M R R^T F`` off the
    loads, and ``R^T M X = 0``. To such loads a structure answers the same wherever it is held, if no more than just held: as
    many coordinates are, what is left of K is positive definite, and the rigid-body motion is taken off the answer.
    """

    def __init__(self, stiffness: Any, mass: Any, rigid: _Array) -> None:
        self._rigid = rigid
        self._inertia = mass @ rigid
        self._loose = np.sort(_pivots(rigid, mass)[rigid.shape[1] :])
        self._factor = _symmetric_factor(stiffness[self._loose][:, self._loose])
        if self._factor is None:
            message = "the stiffness could not be factored: a pivot is zero, though no motion has no stiffness"
            raise ConvergenceError(message)
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


def _pivots(rigid: _Array, mass: Any) -> NDArray[np.int64]:
    """Order coordinates so that the rigid-body modes are most independent at the first of them, in units of the mass."""
    if rigid.shape[1] == 0:
        return np.arange(len(rigid))
    weighted = rigid * np.sqrt(mass.diagonal())[:, np.newaxis]
    return np.asarray(scipy.linalg.qr(weighted.T, mode="r", pivoting=True)[1])


def count_below(stiffness: Any, mass: Any, value: float) -> int:
    """Return the number of squared frequencies below a value, by the signs of pivots (a Sturm sequence)."""
    for nudge in (0.0, 1e-12, 1e-10, 1e-8):
        factor = _symmetric_factor(stiffness - value * (1.0 + nudge) * mass)
        if factor is not None:
            return _negative_pivots(factor)
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
            found = _dense_modes(stiffness, mass, rigid, wanted)
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
    gaps = last[1:] / last[:-1]
    widest = int(np.argmax(gaps))
    value = float(np.sqrt(last[widest] * last[widest + 1]))
    return count_below(stiffness, mass, value) == n_rigid + n_modes + widest


def _dense_modes(stiffness: Any, mass: Any, rigid: _Array, n_modes: int) -> _Array:
    """Return the lowest elastic modes by a dense eigenproblem, in which rigid-body modes are moved above the highest."""
    k, m = stiffness.toarray(), mass.toarray()
    if rigid.shape[1]:
        highest = scipy.linalg.eigh(k, m, eigvals_only=True)[-1]
        inertia = m @ rigid
        k = k + 2.0 * highest * inertia @ inertia.T
    return np.asarray(scipy.linalg.eigh(k, m, subset_by_index=[0, n_modes - 1])[1])


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
