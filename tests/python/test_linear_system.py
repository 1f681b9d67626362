"""Linear systems from modes, without damping, and of sparse matrices; Rayleigh damping."""

import math
import subprocess
import sys

import numpy as np
import pytest
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from structure_models import bar

import vibroimpact as vi

MASS = np.array([[2.0, 0.5], [0.5, 1.0]])
STIFFNESS = np.array([[5.0, -1.0], [-1.0, 3.0]])


class TestFromModes:
    def test_a_system_of_modes(self):
        system = vi.LinearSystem.from_modes([0.0, 2.0, 5.0], [0.5, 0.01, 0.02], load=[1, 2, 3], influence=[1, 0, 1])
        expected = vi.LinearSystem(np.ones(3), [0.0, 0.04, 0.2], [0.0, 4.0, 25.0], [1, 2, 3], [1, 0, 1])
        assert system == expected
        assert isinstance(system, vi.LinearSystem)

    def test_a_ratio_of_every_mode(self):
        assert vi.LinearSystem.from_modes([1.0, 3.0], 0.1) == vi.LinearSystem.from_modes([1.0, 3.0], [0.1, 0.1])
        assert vi.LinearSystem.from_modes(2, np.float32(0.25)) == vi.LinearSystem(1, 1, 4)

    @given(st.lists(st.floats(1e-3, 1e3), min_size=1, max_size=6), st.floats(0.0, 0.99))
    @settings(max_examples=50, deadline=None)
    def test_modes_of_it_are_those_given(self, frequencies, ratio):
        modes = vi.modes(vi.LinearSystem.from_modes(frequencies, ratio))
        assert np.allclose(modes.natural_frequencies, np.sort(frequencies), rtol=1e-15)
        assert np.allclose(modes.damping_ratios, ratio, rtol=1e-14)

    def test_rows_of_mode_shapes_are_directions(self):
        """The scene in modal coordinates and the one in physical coordinates have the same motion and the same impacts."""
        physical = vi.LinearSystem(MASS, None, STIFFNESS)
        modes = vi.modes(physical)
        shapes = modes.shapes
        modal = vi.LinearSystem.from_modes(modes.natural_frequencies, 0.0)
        q, v = np.array([0.1, -0.2]), np.array([0.5, 0.3])
        one = vi.simulate(vi.Scene(physical, None, vi.Stop(1, 0.05, 0.7)), q, v, (0, 20))
        y, dy = shapes.T @ MASS @ q, shapes.T @ MASS @ v
        other = vi.simulate(vi.Scene(modal, None, vi.Stop(shapes[1], 0.05, 0.7)), y, dy, (0, 20))
        assert len(one.impacts) > 3
        assert np.allclose(one.impacts["time"], other.impacts["time"], rtol=1e-9)
        assert np.allclose(one.final[0], shapes @ other.final[0], atol=1e-9)

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            (([], 0.1), r"frequencies has shape \(0,\)"),
            (([[1.0]], 0.1), r"frequencies has shape \(1, 1\)"),
            (([1.0, -2.0], 0.1), r"frequencies\[1\] is -2"),
            (([np.nan], 0.1), r"frequencies\[0\] is NaN"),
            (([1e200], 0.1), r"frequencies\[0\] is 1e200, but its square"),
            (([1.0, 2.0], [0.1]), r"damping_ratios has shape \(1,\), but \(2,\)"),
            (([1.0, 2.0], [[0.1, 0.1]]), r"damping_ratios has shape \(1, 2\)"),
            (([1.0], -0.1), r"damping_ratios\[0\] is -0.1, but it must not be below zero"),
            (([1.0], math.inf), r"damping_ratios\[0\] is inf"),
            (([1.0], "none"), "damping_ratios is 'none'"),
        ],
    )
    def test_bad_input(self, arguments, message):
        with pytest.raises(ValueError, match=message):
            vi.LinearSystem.from_modes(*arguments)

    def test_bad_forces(self):
        with pytest.raises(ValueError, match=r"load has shape \(1,\)"):
            vi.LinearSystem.from_modes([1.0, 2.0], 0.1, load=[1.0])
        with pytest.raises(ValueError, match=r"influence has shape \(3,\)"):
            vi.LinearSystem.from_modes([1.0, 2.0], 0.1, influence=[1.0, 2.0, 3.0])


class TestWithoutDamping:
    @pytest.mark.parametrize("none", [None, 0, 0.0, -0.0, np.float64(0.0), np.int32(0)])
    def test_none_and_zero(self, none):
        assert vi.LinearSystem(MASS, none, STIFFNESS) == vi.LinearSystem(MASS, np.zeros((2, 2)), STIFFNESS)
        assert vi.LinearSystem([1, 2], none, [3, 4]) == vi.LinearSystem([1, 2], [0, 0], [3, 4])
        assert vi.LinearSystem(1, none, 4) == vi.LinearSystem(1, [0.0], 4)

    def test_another_number_is_none_for_one_coordinate_alone(self):
        with pytest.raises(ValueError, match=r"damping has shape \(1,\)"):
            vi.LinearSystem([1, 2], 0.1, [3, 4])


class TestSparseMatrices:
    @pytest.mark.parametrize("convert", [sp.csc_array, sp.coo_array, sp.dia_array, sp.lil_array, sp.csr_matrix])
    def test_they_are_written_out(self, convert):
        damping = 0.1 * STIFFNESS
        plain = vi.LinearSystem(MASS, damping, STIFFNESS)
        assert vi.LinearSystem(convert(MASS), convert(damping), convert(STIFFNESS)) == plain
        assert vi.LinearSystem(convert(MASS), None, STIFFNESS) == vi.LinearSystem(MASS, None, STIFFNESS)

    def test_larger_ones_are_refused_with_the_remedy(self):
        mass, stiffness = bar(2000)
        with pytest.raises(ValueError, match=r"stiffness is sparse with 2001 rows.*up to 2000: vibroimpact.reduce"):
            vi.LinearSystem(mass, None, stiffness)

    def test_what_is_wrong_with_them_is_said(self):
        with pytest.raises(ValueError, match=r"stiffness has shape \(2, 3\)"):
            vi.LinearSystem(MASS, None, sp.csc_array((2, 3)))
        with pytest.raises(ValueError, match=r"damping\[0, 1\] is NaN"):
            vi.LinearSystem(MASS, sp.csc_array([[0.0, np.nan], [0.0, 0.0]]), STIFFNESS)

    def test_scipy_is_not_needed_to_tell_them(self):
        code = """
import sys
sys.modules["scipy"] = None
import numpy as np, vibroimpact as vi
class Sparse:
    nnz, shape = 2, (2, 2)
    def toarray(self):
        return np.diag([2.0, 3.0])
assert vi.LinearSystem([1.0, 1.0], None, Sparse()).stiffness.tolist() == [[2.0, 0.0], [0.0, 3.0]]
"""
        subprocess.run([sys.executable, "-W", "error", "-c", code], timeout=60, check=True)


class TestRayleighDamping:
    def test_the_sum_of_both_matrices(self):
        expected = 0.5 * MASS + 0.25 * STIFFNESS
        assert np.array_equal(vi.rayleigh_damping(MASS, STIFFNESS, alpha=0.5, beta=0.25), expected)
        for mass, stiffness in ((sp.csr_array(MASS), sp.coo_array(STIFFNESS)), (sp.csr_array(MASS), STIFFNESS)):
            damping = vi.rayleigh_damping(mass, stiffness, alpha=0.5, beta=0.25)
            assert sp.issparse(damping)
            assert np.array_equal(damping.toarray(), expected)
        assert np.array_equal(vi.rayleigh_damping(MASS, STIFFNESS, beta=2), 2 * STIFFNESS)
        assert np.array_equal(vi.rayleigh_damping(MASS, STIFFNESS, alpha=2), 2 * MASS)

    def test_diagonals(self):
        assert np.array_equal(vi.rayleigh_damping([1, 2], [3, 4], alpha=1, beta=2), [7, 10])
        assert np.array_equal(vi.rayleigh_damping([1, 2], STIFFNESS, alpha=1, beta=1), np.diag([1, 2]) + STIFFNESS)
        assert np.array_equal(vi.rayleigh_damping(2, 3, alpha=1, beta=1), [5])

    @given(st.floats(0.1, 10.0), st.floats(1.1, 50.0), st.floats(0.001, 0.5), st.floats(0.0, 1.0))
    @settings(max_examples=50, deadline=None)
    def test_the_ratios_at_both_frequencies(self, low, factor, ratio, part):
        high = low * factor
        ratios = {low: ratio, high: ratio * factor ** (2.0 * part - 1.0)}
        mass, stiffness = np.ones(2), np.array([low, high]) ** 2
        found = vi.modes(vi.LinearSystem(mass, vi.rayleigh_damping(mass, stiffness, ratios=ratios), stiffness))
        assert np.allclose(found.damping_ratios, list(ratios.values()), rtol=1e-9)

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({}, "alpha is None, beta is None and ratios is None, but either"),
            ({"alpha": 1.0, "ratios": {1: 0.1, 2: 0.1}}, "alpha is 1.0, .* but either"),
            ({"alpha": -1.0}, "alpha is -1.0, but it must not be below zero"),
            ({"beta": np.nan}, "beta is nan, but it must be finite"),
            ({"beta": [1.0, 2.0]}, r"beta has shape \(2,\), but one number"),
            ({"ratios": {1.0: 0.1}}, "ratios is {1.0: 0.1}, but damping ratios at two frequencies"),
            ({"ratios": {1.0: 0.1, 2.0: 0.1, 3.0: 0.1}}, "ratios is .*two frequencies"),
            ({"ratios": [0.1, 0.2]}, "ratios is .*two frequencies"),
            ({"ratios": {"low": 0.1, "high": 0.2}}, "ratios is .*two frequencies"),
            ({"ratios": {0.0: 0.1, 2.0: 0.1}}, "a frequency of ratios is 0"),
            ({"ratios": {1.0: -0.1, 2.0: 0.1}}, r"ratios\[1\] is -0.1"),
            ({"ratios": {1.0: 0.01, 2.0: 0.1}}, "ratios is {1: 0.01, 2: 0.1}, but .* would be negative"),
        ],
    )
    def test_bad_coefficients(self, arguments, message):
        with pytest.raises(ValueError, match=message):
            vi.rayleigh_damping(MASS, STIFFNESS, **arguments)

    @pytest.mark.parametrize(
        ("mass", "stiffness", "message"),
        [
            (np.ones((2, 3)), STIFFNESS, r"mass has shape \(2, 3\)"),
            (MASS, np.eye(3), r"stiffness has shape \(3, 3\)"),
            (sp.csc_array(MASS), np.eye(3), r"stiffness has shape \(3, 3\), but \(2, 2\)"),
            (MASS, [[1.0, np.inf], [0.0, 1.0]], r"stiffness\[0, 1\] is inf"),
            ("mass", STIFFNESS, "mass is 'mass'"),
        ],
    )
    def test_bad_matrices(self, mass, stiffness, message):
        with pytest.raises(ValueError, match=message):
            vi.rayleigh_damping(mass, stiffness, alpha=1.0)
