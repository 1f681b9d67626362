"""Reduction of finite-element models against closed forms, high precision and the laws of modes (theory 13)."""

import copy
import itertools
import os
import pickle
import subprocess
import sys
import textwrap

import mpmath
import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from structure_models import CANTILEVER, FREE_BEAM, bar, bar_frequencies, beam, cantilever_compliance, truss

import vibroimpact as vi
from vibroimpact.fe import sparse_modes

CASES = int(os.environ.get("VIBROIMPACT_CASES", "50"))
law = settings(max_examples=min(CASES, 1000), deadline=5000)


def frequencies(reduction):
    return np.sqrt(reduction.system.stiffness)


def elastic_compliance(reduction, directions):
    """What the reduced system answers to static loads, less its rigid-body motion, between every two directions."""
    seen = np.array([reduction.direction(n) for n in directions]).T
    is_elastic = reduction.system.stiffness > 0.0
    return seen[is_elastic].T @ (seen[is_elastic] / reduction.system.stiffness[is_elastic, np.newaxis])


def compliance_of_a_free_structure(mass, stiffness, rigid, loads):
    """Solve the bordered system in 50 digits: N^T X with [[K, M R], [(M R)^T, 0]] (X, .) = (N, 0)."""
    n, r = rigid.shape
    with mpmath.workdps(50):
        inertia = mpmath.matrix(mass.tolist()) * mpmath.matrix(rigid.tolist())
        bordered = mpmath.zeros(n + r)
        for i, j in itertools.product(range(n), range(n)):
            bordered[i, j] = stiffness[i, j]
        for i, j in itertools.product(range(n), range(r)):
            bordered[i, n + j] = bordered[n + j, i] = inertia[i, j]
        answers = []
        for load in loads.T:
            x = mpmath.lu_solve(bordered, mpmath.matrix([*load.tolist(), *[0.0] * r]))
            answers.append([mpmath.fdot(x[:n], other.tolist()) for other in loads.T])
        return np.array(answers, dtype=float)


class TestClosedForms:
    @pytest.mark.parametrize("n_elements", [3, 20, 120, 400])
    def test_a_cantilever(self, n_elements):
        """Elements with cubic shapes are too stiff, by less than (b / n)^4 / 720 in a frequency that they resolve."""
        mass, stiffness = beam(n_elements)
        found = frequencies(vi.reduce(mass, None, stiffness, n_modes=4)) / CANTILEVER**2 - 1.0
        assert np.all(found > -1e-9)
        assert np.all(found < 1.1 * (CANTILEVER / n_elements) ** 4 / 720.0 + 1e-9)

    @pytest.mark.parametrize("n_elements", [5, 150])
    def test_a_free_beam(self, n_elements):
        mass, stiffness = beam(n_elements, clamped=False)
        found = frequencies(vi.reduce(mass, None, stiffness, n_modes=6))
        assert np.array_equal(found[:2], [0.0, 0.0])
        error = found[2:] / FREE_BEAM**2 - 1.0
        assert np.all(error > -1e-9)
        assert np.all(error < 1.1 * (FREE_BEAM / n_elements) ** 4 / 720.0 + 1e-9)

    @pytest.mark.parametrize("n_elements", [1, 2, 7, 60, 3000])
    def test_a_free_bar(self, n_elements):
        """The bar of masses and springs has its frequencies in closed form, all of them."""
        mass, stiffness = bar(n_elements)
        n_modes = min(12, n_elements + 1)
        reduction = vi.reduce(mass, None, stiffness, n_modes=n_modes)
        exact = bar_frequencies(n_elements)[:n_modes]
        assert frequencies(reduction)[0] == 0.0
        assert np.allclose(frequencies(reduction)[1:], exact[1:], rtol=1e-11, atol=0.0)
        assert np.allclose(reduction.basis[:, 0], 1.0, rtol=1e-9)

    def test_the_compliance_of_a_cantilever_with_five_modes(self):
        n_elements = 20
        mass, stiffness = beam(n_elements)
        unknowns, places = [2 * n_elements - 2, 8], [1.0, 5 / n_elements]
        reduction = vi.reduce(mass, None, stiffness, n_modes=5, directions=unknowns)
        exact = [[cantilever_compliance(x, y) for y in places] for x in places]
        assert np.allclose(elastic_compliance(reduction, unknowns), exact, rtol=1e-10, atol=0.0)
        assert reduction.static_error < 1e-12
        assert reduction.system.n_dof == 7

    def test_without_residual_vectors_the_error_is_that_of_the_modes_left_out(self):
        """A continuous clamped beam has the share 12/b_j^4 of the compliance of its tip in mode j."""
        n_elements = 60
        mass, stiffness = beam(n_elements)
        tip = 2 * n_elements - 2
        for n_modes in (1, 2, 3):
            reduction = vi.reduce(mass, None, stiffness, n_modes=n_modes, directions=[tip], residual=False)
            left = 1.0 - np.sum(12.0 / CANTILEVER[:n_modes] ** 4)
            assert reduction.system.n_dof == n_modes
            assert reduction.static_error == pytest.approx(left, rel=1e-4)

    def test_the_compliance_of_a_free_beam_in_fifty_digits(self):
        n_elements = 6
        mass, stiffness = beam(n_elements, clamped=False)
        n = mass.shape[0]
        x = np.arange(n_elements + 1) / n_elements
        rigid = np.zeros((n, 2))
        rigid[0::2, 0], rigid[0::2, 1], rigid[1::2, 1] = 1.0, x - 0.5, 1.0
        rigid[:, 1] *= np.sqrt(12.0)
        assert np.allclose(rigid.T @ (mass @ rigid), np.eye(2), atol=1e-14)
        loads = np.zeros((n, 3))
        loads[n - 2, 0] = loads[5, 1] = 1.0
        loads[:, 2] = np.linspace(-1.0, 2.0, n)
        reduction = vi.reduce(mass, None, stiffness, n_modes=4, directions=list(loads.T))
        exact = compliance_of_a_free_structure(mass.toarray(), stiffness.toarray(), rigid, loads)
        assert np.allclose(elastic_compliance(reduction, loads.T), exact, rtol=1e-11, atol=1e-13 * np.abs(exact).max())
        assert reduction.static_error < 1e-12

    def test_a_load_that_only_moves_a_free_structure(self):
        mass, stiffness = bar(10)
        reduction = vi.reduce(mass, None, stiffness, n_modes=3, directions=[mass])
        assert reduction.system.n_dof == 3
        assert reduction.static_error == 0.0


class TestLawsOfModes:
    @pytest.mark.parametrize(
        ("structure", "n_modes"), [(beam(30), 6), (beam(150), 6), (beam(150, clamped=False), 6), (bar(400), 9)]
    )
    def test_the_basis_uncouples_mass_and_stiffness(self, structure, n_modes):
        mass = structure[0] if structure[0].ndim == 2 else sp.diags_array(structure[0])
        reduction = vi.reduce(*(structure[0], None, structure[1]), n_modes=n_modes, directions=[0, 7])
        basis, squares = reduction.basis, reduction.system.stiffness
        assert basis.shape == (mass.shape[0], n_modes + 2)
        assert np.allclose(basis.T @ (mass @ basis), np.eye(n_modes + 2), atol=1e-12)
        assert np.allclose(basis.T @ (structure[1] @ basis), np.diag(squares), atol=1e-9 * squares[-1])
        assert np.all(np.diff(squares) >= -1e-12 * squares[-1])
        assert np.all(basis.max(axis=0) >= (1.0 - 1e-5) * np.abs(basis).max(axis=0))

    def test_dense_and_sparse_ways_agree(self, monkeypatch):
        mass, stiffness = beam(40)
        dense = vi.reduce(mass, None, stiffness, n_modes=8, directions=[3])
        monkeypatch.setattr(sparse_modes, "_DENSE", 0)
        sparse = vi.reduce(mass, None, stiffness, n_modes=8, directions=[3])
        assert np.allclose(frequencies(sparse), frequencies(dense), rtol=1e-10)
        assert np.allclose(sparse.basis, dense.basis, atol=1e-7 * np.abs(dense.basis).max())

    @pytest.mark.parametrize("n_modes", [9, 10])
    def test_double_frequencies_are_all_found(self, n_modes):
        """A beam that bends in two planes; the last pair may be cut."""
        mass, stiffness = (sp.block_diag([part, part], format="csc") for part in beam(150))
        found = frequencies(vi.reduce(mass, None, stiffness, n_modes=n_modes))
        single = frequencies(vi.reduce(*beam(150)[:1], None, beam(150)[1], n_modes=5))
        assert np.allclose(found, np.repeat(single, 2)[:n_modes], rtol=1e-9)

    def test_modes_up_to_a_frequency(self):
        mass, stiffness = bar(500)
        exact = bar_frequencies(500)
        for count in (1, 2, 8):
            between = 0.5 * (exact[count - 1] + exact[count])
            reduction = vi.reduce(mass, None, stiffness, up_to=between)
            assert reduction.system.n_dof == count
        mass, stiffness = bar(20)
        assert vi.reduce(mass, None, stiffness, up_to=1e9).system.n_dof == 21

    def test_all_modes_are_the_model_itself(self):
        mass, stiffness = beam(4)
        reduction = vi.reduce(mass, None, stiffness, n_modes=8, directions=[6])
        whole = vi.modes(vi.LinearSystem(mass, None, stiffness)).natural_frequencies
        assert reduction.system.n_dof == 8
        assert np.allclose(frequencies(reduction), whole, rtol=1e-9)
        mobility = np.linalg.inv(mass.toarray())[6, 6]
        assert reduction.participating_mass(6) == pytest.approx(1.0 / mobility, rel=1e-10)

    def test_a_lost_mode_is_noticed(self, monkeypatch):
        mass, stiffness = beam(150)
        honest = sparse_modes._lanczos_modes
        lost = []

        def without_the_second(*arguments):
            lost.append(arguments[-1])
            return np.delete(honest(*arguments), 1, axis=1) if len(lost) <= failures else honest(*arguments)

        monkeypatch.setattr(sparse_modes, "_lanczos_modes", without_the_second)
        failures = 1
        found = frequencies(vi.reduce(mass, None, stiffness, n_modes=4))
        assert lost == [0, 1]
        assert np.allclose(found, CANTILEVER**2, rtol=1e-6)
        failures = 100
        with pytest.raises(vi.ConvergenceError, match="could not all be found"):
            vi.reduce(mass, None, stiffness, n_modes=4)

    def test_the_same_every_time(self):
        mass, stiffness = beam(150, clamped=False)
        first, second = (vi.reduce(mass, None, stiffness, n_modes=7, directions=[4]) for _ in range(2))
        assert np.array_equal(first.basis, second.basis)
        assert first.system == second.system


class TestRigidBodies:
    @given(st.integers(0, 2**32 - 1))
    @law
    def test_as_many_as_the_rank_leaves(self, seed):
        """Trusses in the plane or in space, in one or several bodies, with bars of very different stiffness, some held."""
        rng = np.random.default_rng(seed)
        d, bodies = int(rng.integers(2, 4)), int(rng.integers(1, 4))
        blocks, expected, held = [], 0, int(rng.integers(0, bodies + 1))
        for body in range(bodies):
            p = int(rng.integers(d + 2, d + 6))
            points = rng.uniform(-1.0, 1.0, (p, d)) * 10.0 ** rng.uniform(-2, 2) + rng.uniform(-10, 10, d)
            pairs = np.array(list(itertools.combinations(range(p), 2)))
            _, stiffness = truss(points, pairs, 10.0 ** rng.uniform(-2, 2, len(pairs)))
            if body < held:
                stiffness = stiffness + sp.diags_array(np.eye(1, p * d)[0] + np.ones(p * d) * 0.01)
            else:
                expected += d * (d + 1) // 2
            blocks.append(stiffness * 10.0 ** rng.uniform(-3, 3))
        stiffness = sp.block_diag(blocks, format="csc")
        units = 10.0 ** rng.uniform(-3, 3, stiffness.shape[0])
        stiffness = sp.diags_array(units) @ stiffness @ sp.diags_array(units)
        mass = units**2 * 10.0 ** rng.uniform(-1, 1, len(units))
        reduction = vi.reduce(mass, None, stiffness, n_modes=len(units), directions=[0])
        assert np.count_nonzero(reduction.system.stiffness == 0.0) == expected
        assert np.allclose(reduction.basis.T @ (mass[:, np.newaxis] * reduction.basis), np.eye(len(units)), atol=1e-10)

    def test_a_bar_that_turns_about_a_pin(self):
        mass, stiffness = truss([[0.0, 0.0], [0.6, 0.8]], [[0, 1]])
        mass, stiffness = mass[2:], stiffness[2:, 2:]
        reduction = vi.reduce(mass, None, stiffness, n_modes=2)
        assert np.array_equal(reduction.system.stiffness == 0.0, [True, False])
        assert np.allclose(np.abs(reduction.basis[:, 0]), [0.8, 0.6], rtol=1e-14)

    def test_nothing_has_stiffness(self):
        reduction = vi.reduce([1.0, 4.0, 1.0], 0.1, np.zeros((3, 3)), n_modes=3, directions=[1])
        assert np.array_equal(reduction.system.stiffness, np.zeros(3))
        assert reduction.participating_mass(1) == pytest.approx(4.0)
        assert reduction.static_error == 0.0

    @pytest.mark.parametrize(("of_mass", "of_stiffness"), [(1e-100, 1e100), (1e100, 1e-100), (1e150, 1e150), (1e-150, 1e-150)])
    def test_any_unit(self, of_mass, of_stiffness):
        for structure in (beam(20, clamped=False), beam(120)):
            plain = vi.reduce(structure[0], None, structure[1], n_modes=5, directions=[7])
            scaled = vi.reduce(of_mass * structure[0], None, of_stiffness * structure[1], n_modes=5, directions=[7])
            units = np.sqrt(of_stiffness) / np.sqrt(of_mass)
            assert np.allclose(frequencies(scaled), units * frequencies(plain), rtol=1e-10, atol=0.0)
            assert scaled.static_error < 1e-10

    def test_a_soft_suspension_is_no_rigid_body_mode(self):
        mass, stiffness = bar(30)
        stiffness = stiffness.tolil()
        stiffness[0, 0] += 1e-8
        reduction = vi.reduce(mass, None, stiffness, n_modes=3)
        assert frequencies(reduction)[0] == pytest.approx(1e-4, rel=1e-4)

    @pytest.mark.skipif(np.finfo(np.longdouble).eps == np.finfo(float).eps, reason="the machine has no extended precision")
    def test_a_mesh_as_fine_as_doubles_hold(self):
        """Of 10 000 elements the first squared frequency of a clamped beam is near the rounding of K."""
        mass, stiffness = beam(10_000)
        assert np.allclose(frequencies(vi.reduce(mass, None, stiffness, n_modes=4)), CANTILEVER**2, rtol=1e-4)
        mass, stiffness = beam(10_000, clamped=False)
        found = frequencies(vi.reduce(mass, None, stiffness, n_modes=6))
        assert np.array_equal(found[:2], [0.0, 0.0])
        assert np.allclose(found[2:], FREE_BEAM**2, rtol=1e-5)


class TestReducedSystem:
    MASS, STIFFNESS = beam(12)

    def reduced(self, damping=None, **options):
        return vi.reduce(self.MASS, damping, self.STIFFNESS, **{"n_modes": 4, "directions": [22, 5], **options})

    def test_damping_ratios(self):
        assert np.array_equal(self.reduced().system.damping, np.zeros(6))
        w = frequencies(self.reduced())
        assert np.allclose(self.reduced(0.02).system.damping, 2 * 0.02 * w, rtol=1e-14)
        for ratios, expected in (
            ([0.01, 0.02, 0.03, 0.04], [0.01, 0.02, 0.03, 0.04, 0.04, 0.04]),
            ([0.01, 0.02, 0.03, 0.04, 0.05, 0.06],) * 2,
        ):
            assert np.allclose(self.reduced(ratios).system.damping, 2 * np.array(expected) * w, rtol=1e-14)

    def test_rayleigh_damping_uncouples(self):
        c = vi.rayleigh_damping(self.MASS, self.STIFFNESS, alpha=0.3, beta=1e-3)
        system = self.reduced(c).system
        assert system.damping.shape == (6,)
        assert np.allclose(system.damping, 0.3 + 1e-3 * system.stiffness, rtol=1e-10)

    def test_any_damping_is_projected(self):
        c = sp.csr_array(np.random.default_rng(1).standard_normal(self.MASS.shape))
        reduction = self.reduced(c)
        assert np.allclose(reduction.system.damping, reduction.basis.T @ c @ reduction.basis, rtol=1e-12, atol=1e-12)
        assert reduction.system == self.reduced(c.toarray()).system

    def test_loads_and_influence(self):
        load, influence = np.linspace(1.0, 2.0, 24), np.tile([1.0, 0.0], 12)
        reduction = self.reduced(load=load, influence=influence)
        assert np.allclose(reduction.system.load, reduction.basis.T @ load, rtol=1e-14)
        assert np.allclose(reduction.system.influence, reduction.basis.T @ (self.MASS @ influence), rtol=1e-12)
        plain = self.reduced().system
        assert plain.influence is None
        assert not plain.load.any()

    def test_the_base_moves_all_of_the_mass(self):
        """All modes together have the mass of the moving structure: sum of the squared participation factors."""
        influence = np.tile([1.0, 0.0], 12)
        whole = self.reduced(n_modes=24, influence=influence).system
        assert whole.influence @ whole.influence == pytest.approx(influence @ (self.MASS @ influence), rel=1e-12)

    def test_directions_and_positions_are_dual(self):
        reduction = self.reduced()
        rng = np.random.default_rng(2)
        n, q = rng.standard_normal(24), rng.standard_normal((5, 3, 6))
        assert reduction.physical(q).shape == (5, 3, 24)
        assert np.allclose(reduction.physical(q) @ n, q @ reduction.direction(n), rtol=1e-12)
        assert np.array_equal(reduction.direction(7), reduction.basis[7])
        assert np.array_equal(reduction.direction(sp.csc_array(n[:, np.newaxis])), reduction.direction(n))

    def test_the_ways_to_give_directions(self):
        unit = np.eye(24)[22]
        plain = self.reduced(directions=[22])
        for same in ([unit], (np.int32(22),), [sp.coo_array(unit[:, np.newaxis])], sp.csr_array(unit[:, np.newaxis])):
            other = self.reduced(directions=same)
            assert np.array_equal(other.basis, plain.basis)
            assert other.static_error == plain.static_error
        assert self.reduced(directions=[22, unit, 2 * unit]).system.n_dof == 5
        assert self.reduced(directions=()).static_error == 0.0

    def test_less_mass_takes_part_with_more_modes(self):
        masses = [self.reduced(n_modes=m, directions=[22], residual=False).participating_mass(22) for m in range(1, 25)]
        assert np.all(np.diff(masses) < 0.0)
        assert masses[-1] == pytest.approx(1.0 / np.linalg.inv(self.MASS.toarray())[22, 22], rel=1e-10)
        assert self.reduced(n_modes=4, directions=[22]).participating_mass(22) < masses[3]

    @pytest.mark.parametrize(("structure", "end", "of_mode", "share"), [(beam(400), 798, 4, 9 / 16), (bar(2000), 0, 2, 1 / 4)])
    def test_the_mass_that_many_modes_leave(self, structure, end, of_mode, share):
        """Of continuous beams and bars 1/(4 k) and 1/(2 k), with a residual vector 9/16 and a quarter of it (theory 13)."""
        k = 40
        options = {"n_modes": k, "directions": [end]}
        without = vi.reduce(structure[0], None, structure[1], residual=False, **options).participating_mass(end)
        assert without * of_mode * k == pytest.approx(1.0, rel=0.03)
        within = vi.reduce(structure[0], None, structure[1], **options).participating_mass(end)
        assert within / without == pytest.approx(share, rel=0.03)

    def test_an_impact_of_the_reduced_model(self):
        """A stop on a direction takes the energy (1 - e^2) v^2 m / 2, m the mass that takes part."""
        reduction = self.reduced()
        tip = reduction.direction(22)
        scene = vi.Scene(reduction.system, None, vi.Stop(tip, 0.0, 0.5))
        v = tip / (tip @ tip)
        run = vi.simulate(scene, np.zeros(6), v, (0.0, 1e-9))
        lost = (1.0 - 0.25) * reduction.participating_mass(22) / 2.0
        assert run.energy.impact_loss[-1] == pytest.approx(lost, rel=1e-9)

    def test_matrices_of_every_kind(self):
        plain = self.reduced()
        for convert in (
            sp.coo_array,
            sp.lil_array,
            sp.csr_matrix,
            sp.dia_array,
            lambda a: a.toarray(),
            lambda a: a.toarray().tolist(),
        ):
            mass, stiffness = convert(self.MASS), convert(self.STIFFNESS)
            other = vi.reduce(mass, None, stiffness, n_modes=4, directions=[22, 5])
            assert np.array_equal(other.basis, plain.basis)
        one = vi.reduce(2.0, 0.1, 8.0, n_modes=1)
        assert (one.system.stiffness, one.system.damping) == (pytest.approx(4.0), pytest.approx(0.4))

    def test_a_result_keeps_copies_and_cannot_be_changed(self):
        reduction = self.reduced(0.01, influence=np.ones(24))
        for clone in (pickle.loads(pickle.dumps(reduction)), copy.deepcopy(reduction)):
            assert np.array_equal(clone.basis, reduction.basis)
            assert clone.system == reduction.system
            assert clone.static_error == reduction.static_error
        with pytest.raises(ValueError, match="read-only"):
            reduction.basis[0, 0] = 1.0
        with pytest.raises(AttributeError):
            reduction.system = None
        arrays = reduction.to_arrays()
        assert set(arrays) == {"basis", "static_error", "mass", "damping", "stiffness", "load", "influence"}
        assert all(isinstance(array, np.ndarray) for array in arrays.values())
        assert "influence" not in self.reduced().to_arrays()
        assert repr(reduction).startswith("Reduction(24 unknowns to 6: natural frequencies 3.51")
        free = vi.reduce(*bar(5)[:1], None, bar(5)[1], n_modes=1)
        assert "1 of them rigid-body modes" in repr(free)
        with pytest.raises(ValueError, match=r"basis has shape \(3, 2\), but \(N, 6\)"):
            vi.Reduction(reduction.system, np.zeros((3, 2)), 0.0)


MASS, STIFFNESS = beam(3)
HELD = {"mass": MASS, "damping": None, "stiffness": STIFFNESS, "n_modes": 2}
NAN = STIFFNESS.copy()
NAN.data[3] = np.nan
LOPSIDED = STIFFNESS.tolil()
LOPSIDED[0, 2] += 1.0
WITHOUT_MASS = MASS.tolil()
WITHOUT_MASS[4, :] = WITHOUT_MASS[:, 4] = 0.0
DEPENDENT = np.ones((6, 6)) + np.diag([0.0, 0, 1, 1, 1, 1])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass": MASS[:4]}, r"mass has shape \(4, 6\), but \(n, n\) is needed"),
        ({"stiffness": STIFFNESS[:4, :4]}, r"stiffness has shape \(4, 4\), but \(6, 6\) is needed"),
        ({"mass": np.zeros((2, 2, 2))}, r"mass has shape \(2, 2, 2\)"),
        ({"mass": sp.csc_array((0, 0))}, r"mass has shape \(0, 0\)"),
        ({"mass": "heavy"}, "mass is 'heavy'"),
        ({"mass": MASS * 1j}, "mass is a sparse array of dtype complex128, but real numbers"),
        ({"stiffness": NAN}, r"stiffness\[\d, \d\] is nan, but it must be finite"),
        ({"stiffness": NAN.toarray()}, r"stiffness\[\d, \d\] is nan, but it must be finite"),
        ({"mass": [1.0, 2.0, 3.0, 4.0, 5.0, np.inf]}, r"mass\[5\] is inf"),
        ({"stiffness": LOPSIDED}, r"stiffness\[(0, 2|2, 0)\] is .*, but stiffness\[(2, 0|0, 2)\] is .*: it must be symmetric"),
        (
            {"mass": WITHOUT_MASS - sp.diags_array([0.0, 0, 0, 1, 0, 0])},
            r"mass\[3, 3\] is -0.\d+, but it must be positive definite: coordinates without mass.* condensed",
        ),
        ({"mass": WITHOUT_MASS, "n_modes": 6}, "n_modes is 6, but it must lie in 1 to 5, the number of unknowns with mass"),
        ({"mass": WITHOUT_MASS, "directions": [2, 4]}, r"directions\[1\] has a part at unknown 4, which has no mass"),
        ({"mass": WITHOUT_MASS, "load": np.ones(6)}, "load has a part at unknown 4, which has no mass"),
        (
            {"mass": np.append(np.ones(5), 0.0), "stiffness": np.append(np.ones(5), 0.0)},
            "unknown 5 has neither mass nor stiffness",
        ),
        ({"mass": np.zeros(6)}, "mass has 6 rows of zeros beside 0 others"),
        ({"mass": sp.triu(MASS)}, r"mass is an upper triangle, but both sides are needed: A \+ A.T - scipy.sparse.diags_array"),
        ({"stiffness": np.tril(STIFFNESS.toarray())}, "stiffness is a lower triangle, but both sides are needed"),
        ({"rigid_modes": -1}, "rigid_modes is -1, but it must lie in 0 to 6"),
        ({"rigid_modes": 1}, "rigid_modes is 1, but the squared frequency of the last of them is only"),
        ({"mass": DEPENDENT}, "mass is singular or has negative eigenvalues.*condensed"),
        ({"mass": DEPENDENT - np.diag([0.0, 0, 3, 0, 0, 0])}, r"mass\[2, 2\] is -1.0"),
        ({"mass": np.eye(6) + 2 * np.eye(6)[::-1]}, "mass is singular or has negative eigenvalues"),
        ({"stiffness": -STIFFNESS}, "stiffness has 6 negative"),
        ({"stiffness": STIFFNESS - 13.0 * MASS}, "stiffness has 1 negative"),
        ({"n_modes": None}, "n_modes is None and up_to is None, but one of the two is needed"),
        ({"up_to": 10.0}, "n_modes is 2 and up_to is 10.0, but one"),
        ({"n_modes": 7}, "n_modes is 7, but it must lie in 1 to 6"),
        ({"n_modes": 0}, "n_modes is 0, but"),
        ({"n_modes": -1}, "n_modes is -1, but"),
        ({"n_modes": None, "up_to": -3.0}, "up_to is -3.0, but"),
        ({"n_modes": None, "up_to": np.nan}, "up_to is nan, but"),
        ({"n_modes": None, "up_to": 1e200}, r"up_to is 1e\+200, but"),
        ({"n_modes": None, "up_to": [1.0, 2.0]}, r"up_to has shape \(2,\), but one number"),
        ({"n_modes": None, "up_to": 1.0}, "up_to is 1.0, but no natural frequency is as low"),
        ({"directions": [6]}, r"directions\[0\] is 6, but an index must lie in 0 to 5"),
        ({"directions": [0, -1]}, r"directions\[1\] is -1, but"),
        ({"directions": [np.ones(5)]}, r"directions\[0\] has shape \(5,\), but \(6,\)"),
        ({"directions": [np.zeros(6)]}, r"directions\[0\] is zero everywhere"),
        ({"directions": [0, np.full(6, np.nan)]}, r"directions\[1\]\[0\] is nan"),
        ({"directions": 3}, "directions is 3, but a sequence"),
        ({"directions": sp.csc_array(np.ones((5, 1)))}, r"directions has shape \(5, 1\), but \(6, k\)"),
        ({"directions": sp.csc_array(np.eye(6)[:, :2] * [1.0, 0.0])}, r"directions\[1\] is zero everywhere"),
        ({"damping": [0.1]}, r"damping has shape \(1,\), but a number, \(2,\), a ratio for each mode, or a matrix"),
        ({"damping": [0.1] * 5, "directions": [0]}, r"damping has shape \(5,\).*\(2,\).*\(3,\), for residual vectors too"),
        ({"damping": -0.1}, "damping is -0.1, but a damping ratio must not be below zero"),
        ({"damping": [0.1, -0.1]}, r"damping\[1\] is -0.1, but"),
        ({"damping": np.nan}, "damping is nan, but it must be finite"),
        ({"damping": np.eye(4)}, r"damping has shape \(4, 4\), but \(6, 6\) is needed"),
        ({"damping": NAN}, r"damping\[\d, \d\] is nan"),
        ({"load": np.ones(5)}, r"load has shape \(5,\), but \(6,\)"),
        ({"influence": [0, 1, 2, 3, 4, np.inf]}, r"influence\[5\] is inf"),
    ],
)
def test_bad_input_is_refused_by_name_value_and_rule(changes, message):
    with pytest.raises(ValueError, match=message):
        vi.reduce(**{**HELD, **changes})


def test_a_number_of_modes_that_is_no_whole_number():
    with pytest.raises(TypeError, match=r"n_modes is 2.5, but a whole number is needed"):
        vi.reduce(**{**HELD, "n_modes": 2.5})


def test_rigid_body_modes_are_not_left_out():
    with pytest.raises(ValueError, match="n_modes is 1, but rigid-body modes are kept, and the structure has 2 or more"):
        vi.reduce(beam(3, clamped=False)[0], None, beam(3, clamped=False)[1], n_modes=1)
    with pytest.raises(ValueError, match="n_modes is 4, but rigid-body modes are kept"):
        vi.reduce(np.ones(3000), None, sp.csc_array((3000, 3000)), n_modes=4)


@pytest.mark.parametrize(
    ("name", "argument", "message"),
    [
        ("direction", 24, "n is 24, but an index must lie in 0 to 23"),
        ("direction", np.ones(6), r"n has shape \(6,\), but \(24,\)"),
        ("participating_mass", np.zeros(24), "n is zero everywhere"),
        ("physical", np.ones(5), r"q has shape \(5,\), but \(..., 6\)"),
        ("physical", 1.0, r"q has shape \(\), but"),
        ("physical", "q", "q is 'q'"),
    ],
)
def test_bad_arguments_of_a_reduction(name, argument, message):
    with pytest.raises(ValueError, match=message):
        getattr(TestReducedSystem().reduced(), name)(argument)


def run(code, **environment):
    command = [sys.executable, "-W", "error", "-c", textwrap.dedent(code)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False, env={**os.environ, **environment})
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_without_scipy_the_extra_is_named():
    run(
        """
        import sys
        sys.modules["scipy"] = sys.modules["scipy.sparse"] = None
        import vibroimpact as vi
        try:
            vi.reduce([1.0], None, [1.0], n_modes=1)
        except ImportError as error:
            assert 'vibroimpact.reduce needs SciPy: pip install "vibroimpact[fe]"' in str(error), error
        else:
            raise AssertionError("no error")
        assert vi.rayleigh_damping([1.0], [2.0], alpha=1.0, beta=2.0)[0] == 5.0
        """
    )


@pytest.mark.skipif(sys.platform == "win32", reason="peak memory is had from the resource module")
def test_twenty_thousand_unknowns_take_less_than_a_gigabyte():
    peak = run(
        f"""
        import resource, sys
        sys.path.insert(0, {os.path.dirname(__file__)!r})
        from structure_models import beam
        import vibroimpact as vi
        mass, stiffness = beam(10_000)
        reduction = vi.reduce(mass, 0.01, stiffness, n_modes=40, directions=[19_998])
        assert reduction.basis.shape == (20_000, 41)
        print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
        """
    )
    unit = 1 if sys.platform == "darwin" else 1024
    assert int(peak) * unit < 1e9
