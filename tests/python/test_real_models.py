"""Models as element codes write them: clamped by penalties, with digits lost, with lumped masses alone (theory 13)."""

import os

import mpmath
import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from structure_models import beam, truss

import vibroimpact as vi

law = settings(max_examples=min(int(os.environ.get("VIBROIMPACT_CASES", "40")), 1000), deadline=None)


def exact_frequencies(mass, stiffness):
    """Natural frequencies in 120 digits, ascending."""
    with mpmath.workdps(120):
        inverse = mpmath.cholesky(mpmath.matrix(mass.tolist())) ** -1
        squares = mpmath.eigsy(inverse * mpmath.matrix(stiffness.tolist()) * inverse.T, eigvals_only=True)
        return np.array([float(mpmath.sqrt(abs(one))) for one in sorted(squares)])


def random_structure(rng, n):
    """Full matrices, positive definite and well conditioned but for the units of their coordinates."""
    a, b = rng.standard_normal((2, n, n))
    units = 10.0 ** rng.uniform(-2, 2, n)
    mass, stiffness = (units[:, np.newaxis] * (c @ c.T + n * np.eye(n)) * units for c in (a, b))
    return (mass + mass.T) / 2, (stiffness + stiffness.T) / 2


@given(st.integers(0, 2**32), st.integers(4, 7), st.lists(st.floats(0, 36), min_size=1, max_size=3), st.booleans())
@law
def test_penalties_leave_the_digits_of_all_other_frequencies(seed, n, exponents, is_coupled):
    rng = np.random.default_rng(seed)
    mass, stiffness = random_structure(rng, n)
    places = rng.permutation(n)[: len(exponents)]
    # In parts of the structure: one penalty on the other, 10^114 in all, is beyond the digits of the reference.
    largest = stiffness.max()
    for i, exponent in zip(places, exponents, strict=True):
        if not is_coupled:
            stiffness[i, :] = stiffness[:, i] = 0.0
            stiffness[i, i] = 1.0
        stiffness[i, i] += 10.0**exponent * largest
    exact = exact_frequencies(mass, stiffness)
    modes = vi.modes(vi.LinearSystem(mass, np.zeros((n, n)), stiffness))
    assert np.allclose(modes.natural_frequencies, exact, rtol=1e-12)
    shapes = modes.shapes.real
    assert np.allclose(shapes.T @ mass @ shapes, np.eye(n), atol=1e-11)
    wanted = n - len(exponents)
    reduction = vi.reduce(mass, None, stiffness, n_modes=wanted)
    assert np.allclose(np.sqrt(reduction.system.stiffness), exact[:wanted], rtol=1e-11)


@pytest.mark.parametrize("n_elements", [4, 30, 150])
@pytest.mark.parametrize("penalty", [1e20, 1e36])
def test_a_penalty_clamps(n_elements, penalty):
    """A cantilever whose first two unknowns are held by a penalty is the one without them."""
    tip = 2 * n_elements
    mass, stiffness = beam(n_elements, clamped=False)
    whole = stiffness.tolil()
    whole[0, 0] += penalty
    whole[1, 1] += penalty
    held = vi.reduce(mass, 0.01, whole, n_modes=4, directions=[tip])
    clamped = vi.reduce(mass[2:, 2:], 0.01, stiffness[2:, 2:], n_modes=4, directions=[tip - 2])
    assert np.allclose(np.sqrt(held.system.stiffness / clamped.system.stiffness), 1.0, rtol=1e-9)
    assert np.allclose(held.direction(tip), clamped.direction(tip - 2), rtol=1e-8)
    assert np.abs(held.basis[:2]).max() < 1e-12 * np.abs(held.basis).max()
    with pytest.raises(ValueError, match=r"directions\[1\] is one along which nothing moves.*unknown 1 is .* times as stiff"):
        vi.reduce(mass, 0.01, whole, n_modes=4, directions=[tip, 0])
    with pytest.raises(vi.ConvergenceError, match="doubles"):
        vi.reduce(mass, 0.01, whole, n_modes=mass.shape[0])


def test_a_penalty_holds_a_part_of_what_is_free():
    """A plane truss that penalties hold across moves along, and has the frequencies of the one whose unknowns are left out."""
    points = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (0.5, 0.8), (1.5, 0.8)]
    pairs = [(0, 1), (1, 2), (0, 3), (1, 3), (1, 4), (2, 4), (3, 4)]
    mass, stiffness = truss(points, pairs)
    across = [1, 5]
    held = stiffness.tolil()
    for i in across:
        held[i, i] += 1e30
    along = np.setdiff1d(np.arange(10), across)
    exact = vi.reduce(mass[along], None, stiffness[along][:, along], n_modes=6)
    found = vi.reduce(mass, None, held, n_modes=6)
    assert found.system.stiffness[0] == exact.system.stiffness[0] == 0.0
    assert np.allclose(np.sqrt(found.system.stiffness), np.sqrt(exact.system.stiffness), rtol=1e-11)


def noisy(rng, stiffness, noise):
    """Entries with a relative rounding."""
    matrix = np.triu(stiffness.toarray() * (1.0 + noise * rng.standard_normal(stiffness.shape)))
    return matrix + np.triu(matrix, 1).T


@given(st.integers(0, 2**32), st.integers(1, 3), st.sampled_from([0.0, 1e-15, 1e-14, 1e-13, 3e-13]))
@law
def test_free_structures_with_rounding_in_their_entries(seed, d, noise):
    rng = np.random.default_rng(seed)
    p = int(rng.integers(d + 2, 24))
    points = rng.uniform(size=(p, d))
    pairs = [(i, j) for j in range(p) for i in range(j)]
    mass, stiffness = truss(points, pairs, rng.uniform(0.5, 2.0, len(pairs)))
    n_rigid = d * (d + 1) // 2
    n_modes = min(n_rigid + 4, p * d)
    exact = scipy.linalg.eigh(stiffness.toarray(), eigvals_only=True)
    if exact[n_rigid] < 1e-5 * exact[-1]:  # points nearly in line: a slow mode
        return
    for rigid_modes in (None, n_rigid):
        found = vi.reduce(mass, None, noisy(rng, stiffness, noise), n_modes=n_modes, rigid_modes=rigid_modes)
        assert np.count_nonzero(found.system.stiffness) == n_modes - n_rigid
        assert np.allclose(found.system.stiffness[n_rigid:], exact[n_rigid:n_modes], rtol=1e-7)


@pytest.mark.parametrize("digits", [5, 7, 10])
def test_rigid_body_modes_by_count(digits):
    """A free beam whose matrix is written with few digits has the frequencies of the one with all."""
    mass, stiffness = beam(8, clamped=False)
    exact = np.sqrt(vi.reduce(mass, None, stiffness, n_modes=5).system.stiffness[2:])
    entries = stiffness.toarray()
    few = np.array([float(f"{entry:.{digits - 1}e}") for entry in (entries * np.pi).ravel()]).reshape(entries.shape) / np.pi
    few = (few + few.T) / 2
    found = np.sqrt(vi.reduce(mass, None, few, n_modes=5, rigid_modes=2).system.stiffness)
    assert np.array_equal(found[:2], [0.0, 0.0])
    assert np.allclose(found[2:], exact, rtol=10.0 ** (3 - digits))
    with pytest.raises(ValueError, match="rigid_modes is 3, but the squared frequency of the last of them is only"):
        vi.reduce(mass, None, few, n_modes=5, rigid_modes=3)
    with pytest.raises(ValueError, match="rigid_modes is 1, but 2 or more modes have no stiffness"):
        vi.reduce(mass, None, stiffness, n_modes=5, rigid_modes=1)


@pytest.mark.parametrize("n_elements", [300, 600])
def test_slow_modes_of_fine_meshes_are_no_rigid_body_modes(n_elements):
    mass, stiffness = beam(n_elements)
    assert vi.reduce(mass, None, stiffness, n_modes=3).system.stiffness.all()


@given(st.integers(0, 2**32), st.integers(3, 8))
@law
def test_coordinates_without_mass_are_condensed(seed, n):
    """The frequencies are those of masses that tend to zero: of 1e-60 here, in 120 digits."""
    rng = np.random.default_rng(seed)
    _, stiffness = random_structure(rng, n)
    massless = rng.permutation(n)[: int(rng.integers(1, n - 1))]
    mass = np.exp(rng.standard_normal(n))
    mass[massless] = 1e-60
    kept = n - len(massless)
    exact = exact_frequencies(np.diag(mass), stiffness)[:kept]
    mass[massless] = 0.0
    found = vi.reduce(mass, 0.01, sp.csc_array(stiffness), n_modes=kept)
    assert np.allclose(np.sqrt(found.system.stiffness), exact, rtol=1e-9)
    assert np.allclose(found.basis.T @ np.diag(mass) @ found.basis, np.eye(kept), atol=1e-11)
    # No force stands at a coordinate without mass.
    force = (stiffness @ found.basis)[massless]
    assert np.allclose(force, 0.0, atol=1e-10 * np.abs(np.abs(stiffness) @ np.abs(found.basis)).max())


def test_a_free_structure_with_massless_coordinates_moves_as_one():
    _, stiffness = beam(6, clamped=False)
    lumped = np.zeros(14)
    lumped[0::2] = 1.0 / 6.0
    lumped[[0, 12]] /= 2.0
    found = vi.reduce(lumped, None, stiffness, n_modes=4, directions=[12])
    assert np.array_equal(found.system.stiffness[:2], [0.0, 0.0])
    x = np.linspace(0.0, 1.0, 7)
    for shape in found.basis[:, :2].T:  # slopes follow deflections of a line
        line = np.polyfit(x, shape[0::2], 1)
        assert np.allclose(shape[0::2], np.polyval(line, x), atol=1e-8)
        assert np.allclose(shape[1::2], line[0], atol=1e-7)


def test_what_nothing_holds_and_nothing_weighs_is_told():
    mass, stiffness = np.array([1.0, 1.0, 0.0, 0.0]), np.diag([1.0, 2.0, 0.0, 0.0])
    stiffness[2:, 2:] = [[1.0, -1.0], [-1.0, 1.0]]
    with pytest.raises(ValueError, match="unknowns without mass, as 2, 3, are not all held by the stiffness"):
        vi.reduce(mass, None, stiffness, n_modes=1)
    stiffness[2:, 2:] = 0.0
    with pytest.raises(ValueError, match="unknown 2, 3 has neither mass nor stiffness: leave its rows"):
        vi.reduce(mass, None, stiffness, n_modes=1)


def test_an_asymmetry_is_seen_beside_a_penalty():
    stiffness = np.array([[2.0, -1.0, 0.0], [-0.5, 2.0, 0.0], [0.0, 0.0, 1e36]])
    with pytest.raises(ValueError, match=r"stiffness\[\d, \d\] is .*it must be symmetric"):
        vi.reduce(np.ones(3), None, stiffness, n_modes=1)
    with pytest.raises(
        ValueError, match=r"stiffness\[2, 2\] is 1e\+?36.*more than 1/EPSILON times as stiff.*leave a clamped unknown out"
    ):
        vi.modes(vi.LinearSystem(np.ones(3), np.zeros(3), stiffness))
    # Squared frequencies are the roots of K itself, 2 -+ sqrt(0.5).
    stiffness[2, 2] = 1e12
    found = vi.modes(vi.LinearSystem(np.ones(3), np.zeros(3), stiffness)).natural_frequencies[:2]
    assert np.allclose(found**2, [2.0 - 0.5**0.5, 2.0 + 0.5**0.5], rtol=1e-6)


def flown(mass, damping, stiffness, start, t):
    """Positions after a time of free motion, in sixty digits."""
    n = len(mass)
    with mpmath.workdps(60):
        inverse = mpmath.matrix(mass.tolist()) ** -1
        by_position, by_velocity = (-inverse * mpmath.matrix(one.tolist()) for one in (stiffness, damping))
        state = mpmath.zeros(2 * n)
        state[:n, n:], state[n:, :n], state[n:, n:] = mpmath.eye(n), by_position, by_velocity
        roots, vectors = mpmath.eig(state)
        parts = mpmath.lu_solve(vectors, mpmath.matrix(start.tolist()))
        grown = mpmath.matrix([mpmath.exp(root * t) * part for root, part in zip(roots, parts, strict=True)])
        return np.array([float(mpmath.re(x)) for x in (vectors * grown)[:n]])


@given(st.integers(0, 2**32), st.integers(0, 36), st.sampled_from(["proportional", "coupled", "not symmetric"]))
@law
def test_motions_beside_a_penalty(seed, exponent, kind):
    """Right, or refused where modes are coupled and doubles do not hold them."""
    rng = np.random.default_rng(seed)
    n = 3
    a, b, c = rng.standard_normal((3, n, n))
    mass, stiffness, damping = (x @ x.T + n * np.eye(n) for x in (a, b, 0.1 * c))
    if kind == "proportional":
        damping = 0.05 * mass
    if kind == "not symmetric":
        stiffness[0, 1] *= 0.5
    stiffness[2, 2] += 10.0**exponent
    start = np.append(rng.standard_normal(n), rng.standard_normal(n))
    start[[2, 5]] = 0.0
    system = vi.LinearSystem(mass, damping, stiffness)
    ratios = np.diag(stiffness) / np.diag(mass)
    scene = vi.Scene(system, None, [])
    if kind != "proportional" and ratios.max() / ratios.min() > 2.0**52:
        with pytest.raises(ValueError, match=r"stiffness\[2, 2\] is .*leave a clamped unknown out"):
            vi.simulate(scene, start[:n], start[n:], (0.0, 2.0))
        return
    found = vi.simulate(scene, start[:n], start[n:], (0.0, 2.0)).final[0]
    exact = flown(mass, damping, stiffness, start, 2.0)
    tolerance = 1e-12 if kind == "proportional" else 1e-15 * (ratios.max() / ratios.min()) ** 0.5 + 1e-12
    assert np.abs(found - exact).max() <= 10.0 * tolerance * np.abs(exact).max()


def test_stops_beside_a_penalty_are_refused():
    """An impact would set a clamped unknown going, at a rate whose phase doubles do not hold."""
    mass, stiffness = (one.toarray() for one in beam(4, clamped=False))
    stiffness[0, 0] = stiffness[1, 1] = 1e36
    system = vi.LinearSystem(mass, np.zeros((10, 10)), stiffness)
    for stops in (vi.Stop(8, 0.1, 0.5), [vi.Stop(8, 0.1, 0.5), vi.Stop(8, 0.1, 0.5, side="lower")]):
        with pytest.raises(ValueError, match=r"stiffness\[\d, \d\] is 1e\+?36.*leave a clamped unknown out"):
            vi.simulate(vi.Scene(system, None, stops), np.zeros(10), np.ones(10), (0.0, 1.0))
    # Modes that do not know each other may be as far apart as they are.
    system = vi.LinearSystem([1.0, 1.0], [0.0, 0.0], [1.0, 1e36])
    run = vi.simulate(vi.Scene(system, None, vi.Stop(0, 0.5, 0.5)), [0.0, 0.0], [1.0, 0.0], (0.0, 1.0))
    assert run.impacts["time"][0] == pytest.approx(np.pi / 6, rel=1e-14)
