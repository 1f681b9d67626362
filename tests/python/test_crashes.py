"""What a user gives may be strange or too large: an exception comes out, the interpreter lives on."""

import ctypes
import subprocess
import sys
from unittest import mock

import numpy as np
import pytest

import vibroimpact as vi

MANY = 100_000  # a matrix of as many rows and columns takes 80 GB


class Callable:
    """An acceleration that is an object with attributes of its own, whatever they are."""

    def __init__(self, **attributes):
        self.__dict__.update(attributes)

    def __call__(self, t, q, v):
        return -q


class Endless:
    """Every attribute that is asked for is there, and another such object; no class of the standard library."""

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return Endless()

    def __call__(self, t, q, v):
        return -q


class TestFunctions:
    @pytest.mark.parametrize(
        "function",
        [
            mock.Mock(side_effect=lambda t, q, v: -q),
            mock.MagicMock(side_effect=lambda t, q, v: -q),
            Endless(),
            Callable(address=1, ctypes=Callable(address=1, ctypes=None)),
        ],
        ids=["Mock", "MagicMock", "endless", "nested"],
    )
    def test_an_object_with_any_attribute_is_a_function_of_python(self, function):
        run = vi.simulate(vi.Scene(vi.NonlinearSystem(1, function)), 1.0, 0.0, (0, 1))
        assert run.final[0][0] == pytest.approx(np.cos(1), rel=1e-8)

    def test_an_attribute_that_raises_is_none(self):
        class Grumpy(Callable):
            @property
            def address(self):
                raise RuntimeError("not now")

        run = vi.simulate(vi.Scene(vi.NonlinearSystem(1, Grumpy())), 1.0, 0.0, (0, 1))
        assert run.final[0][0] == pytest.approx(np.cos(1), rel=1e-8)

    def test_a_mass_of_another_shape_is_named(self):
        for n, mass in ((1, [1.0, 2.0]), (1, np.ones((2, 2))), (2, 1.0), (2, np.ones(4)), (2, np.eye(3)), (1, [])):
            with pytest.raises(ValueError, match=rf"mass has shape .* but \({n}, {n}\) is needed"):
                vi.NonlinearSystem(n, lambda t, q, v: -q, mass=mass)
            scene = vi.Scene(vi.NonlinearSystem(n, lambda t, q, v: -q, mass=lambda q, m=mass: m), None, vi.Stop(0, 0.1, 0.5))
            with pytest.raises(ValueError, match=rf"mass.* has shape .* but \({n}, {n}\) is needed"):
                vi.simulate(scene, np.zeros(n), np.ones(n), (0, 1))

    def test_a_mass_of_one_entry_may_be_a_number(self):
        for mass in (2.0, [2.0], [[2.0]], np.array(2.0)):
            assert vi.NonlinearSystem(1, lambda t, q, v: -q, mass=mass).mass.tolist() == [[2.0]]


def nested(kind):
    """A scene whose own functions simulate it."""

    def again(*_):
        vi.simulate(scene, 0.0, 1.0, (0, 1))
        return 1.0

    if kind == "acceleration":
        scene = vi.Scene(vi.NonlinearSystem(1, again))
    elif kind == "mass":
        scene = vi.Scene(vi.NonlinearSystem(1, lambda t, q, v: -q, mass=again), None, vi.Stop(0, 0.1, 0.5))
    elif kind == "gap":
        scene = vi.Scene(vi.LinearSystem(1, 0, 1), None, vi.NonlinearStop(again, lambda q: [-1.0], 0.5))
    return scene


class TestRecursion:
    @pytest.mark.parametrize("kind", ["acceleration", "mass", "gap"])
    def test_functions_that_simulate_their_own_scene_end_in_a_recursion_error(self, kind):
        scene = nested(kind)
        with pytest.raises(RecursionError, match="deep"):
            vi.simulate(scene, 0.0, 1.0, (0, 1))
        with pytest.raises(RecursionError, match="deep"):
            vi.simulate_many(scene, [0.0] * 3, [1.0] * 3, (0, 1))

    def test_a_callback_of_ctypes_too(self):
        double = ctypes.POINTER(ctypes.c_double)
        seen = []

        @ctypes.CFUNCTYPE(None, ctypes.c_double, double, double, double, double)
        def again(t, q, v, a, parameters):
            a[0] = -q[0]
            if not seen:
                try:
                    vi.simulate(scene, 0.0, 1.0, (0, 1))
                except RecursionError as error:
                    seen.append(error)

        scene = vi.Scene(vi.NonlinearSystem(1, again))
        run = vi.simulate(scene, 0.0, 1.0, (0, 1))
        assert seen
        assert run.final[0][0] == pytest.approx(np.sin(1), rel=1e-8)

    def test_another_simulation_within_a_function_is_no_recursion(self):
        pendulum = vi.Scene(vi.LinearSystem(1, 0, 1))

        def acceleration(t, q, v):
            return -vi.simulate(pendulum, q, 0.0, (0, 1)).final[0] / np.cos(1)

        run = vi.simulate(vi.Scene(vi.NonlinearSystem(1, acceleration)), 1.0, 0.0, (0, 1))
        assert run.final[0][0] == pytest.approx(np.cos(1), rel=1e-8)


def uncoupled(n=MANY, **options):
    frequencies = np.linspace(1.0, 2.0, n)
    return vi.LinearSystem(np.ones(n), 0.02 * frequencies, frequencies**2, **options)


LARGE = """
import resource
import numpy as np
import vibroimpact as vi

resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
n = {n}
w = np.linspace(1.0, 2.0, n)
system = vi.LinearSystem(np.ones(n), 0.02 * w, w**2)
scene = vi.Scene(system, None, [vi.Stop(0, -0.1, 0.0)])
zero = np.zeros(n)
first = zero.copy()
first[0] = 1.0
driven = vi.periodic_orbits(vi.Scene(system, vi.Harmonic(first, 2.8), vi.Stop(0, 0.05, 0.8)), [0])[0]
pushed = vi.Scene(vi.LinearSystem(np.ones(n), 0.02 * w, w**2, load=np.ones(n)), None, vi.Stop(0, 0.1, 0.0))
try:
    {call}
except MemoryError as error:
    assert str(error), "no message"
    print("MemoryError", end="")
"""

TOO_LARGE = {
    "shapes": "vi.modes(system).shapes",
    "recovery_matrix": "vi.recovery_matrix(scene, 0)",
    "lasting contact": "vi.simulate(pushed, zero, zero, (0, 10))",
    "t_eval": "vi.simulate(scene, zero - 1, zero, (0, 1), t_eval=np.linspace(0, 1, n))",
    "position": "vi.simulate(scene, zero - 1, zero, (0, 1)).position(np.linspace(0, 1, n))",
    "coordinates": "vi.NonlinearSystem(10**15, lambda t, q, v: -q)",
    "multipliers": "driven.floquet_multipliers",
    "shooting": "vi.find_orbit(driven.scene, driven)",
    "cells": "vi.existence_map(vi.paper_scene(3), [1], ('frequency', w), ('clearance', w), 2)",
}


class TestMemory:
    def test_a_hundred_thousand_uncoupled_modes_take_no_matrix(self):
        modes = vi.modes(uncoupled())
        assert np.allclose(modes.natural_frequencies, np.linspace(1.0, 2.0, MANY), rtol=1e-14)
        assert np.allclose(modes.damping_ratios, 0.01, rtol=1e-12)
        assert modes.eigenvalues.shape == (2 * MANY,)
        assert modes.is_proportional
        assert len(repr(modes)) < 1000

    def test_shapes_are_there_when_asked_for(self):
        modes = vi.modes(vi.LinearSystem([4.0, 1.0], [0.0, 0.0], [64.0, 9.0]))
        assert modes.shapes.tolist() == [[0.0, 0.5], [1.0, 0.0]]

    def test_a_mass_that_fits_no_matrix_is_no_reason_to_make_one(self):
        with pytest.raises(ValueError, match="matrix has shape"):
            vi.audit_recovery(np.eye(4), np.ones(MANY), [0])

    @pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are set as Linux has them")
    @pytest.mark.parametrize("call", TOO_LARGE)
    def test_what_does_not_fit_is_a_memory_error(self, call):
        child = [sys.executable, "-c", LARGE.format(call=TOO_LARGE[call], n=MANY)]
        answer = subprocess.run(child, capture_output=True, text=True, timeout=60, check=False)
        assert answer.stdout == "MemoryError", answer.stderr


class TestRoom:
    def test_the_plan_says_where_no_position_is_admissible(self):
        def plan(upper, lower):
            stops = [vi.Stop(0, upper, 0.5), vi.Stop(0, lower, 0.5, side="lower")]
            return vi.Scene(vi.LinearSystem(1, 0, 1), None, stops).plan()

        assert "no position is admissible: stops 0 and 1 overlap by 0.5" in plan(-1.0, 0.5)
        for upper, lower in ((-1.0, 1.0), (0.0, 0.0), (0.2, 0.3), (-1.0, 1.5)):
            assert "admissible" not in plan(upper, lower)

    def test_no_start_lies_in_no_room(self):
        stops = [vi.Stop(0, -1.0, 0.5), vi.Stop(0, 0.5, 0.5, side="lower")]
        scene = vi.Scene(vi.LinearSystem(1, 0, 1), None, stops)
        for q in (-1.0, -0.75, -0.5, 0.0):
            with pytest.raises(ValueError, match="inside"):
                vi.simulate(scene, q, 0.0, (0, 1))
