"""Searches of nonlinear gaps take as long in one unit of length or of time as in another, as far as their bounds allow.

Where a bound does not, a run says so and comes to an end.
"""

from __future__ import annotations

import numpy as np
import pytest

import vibroimpact as vi

TURNED = (0.0, np.pi)


def end_above_a_floor(unit, offset):
    """The height of one end of a rod, whose second derivative is no larger than half its length."""
    length = 0.3 * unit

    def gap(q):
        return unit + q[1] + length * np.sin(q[2] + offset)

    def gradient(q):
        return np.array([0.0, 1.0, length * np.cos(q[2] + offset)])

    return vi.NonlinearStop(gap, gradient, 0.0, curvature=length)


def end_in_a_circle(unit, offset, factor):
    """One end of a rod inside a circle, ``(R^2 - |p|^2)/R``: its second derivatives are 2/R by lengths, and lengths by angles."""
    length = 0.3 * unit

    def gap(q):
        x, y = q[0] + length * np.cos(q[2] + offset), q[1] + length * np.sin(q[2] + offset)
        return unit - (x * x + y * y) / unit

    def gradient(q):
        c, s = length * np.cos(q[2] + offset), length * np.sin(q[2] + offset)
        return -2 / unit * np.array([q[0] + c, q[1] + s, q[1] * c - q[0] * s])

    # In the circle |p| is its radius at the most.
    bound = 2 / unit * (1 + length**2 + 1.3 * length * unit)
    return vi.NonlinearStop(gap, gradient, 0.9, curvature=factor * bound)


def rod(unit, time=1.0):
    third = (0.3 * unit) ** 2 / 3
    return vi.LinearSystem(np.diag([1.0, 1.0, third]), None, np.zeros((3, 3)), load=[0.0, -5 * unit / time**2, 0.0])


def fallen(unit, time, method):
    """A rod that falls, is held by its end, tips over and comes to lie."""
    scene = vi.Scene(rod(unit, time), stops=[end_above_a_floor(unit, turn) for turn in TURNED])
    start = [0.0, -0.65 * unit, 1.2], [0.1 * unit / time, 0.0, -0.3 / time]
    return vi.simulate(scene, *start, (0.0, time), method=method)


def thrown(unit, factor=1.0, method="dop853"):
    scene = vi.Scene(rod(unit), stops=[end_in_a_circle(unit, turn, factor) for turn in TURNED])
    return vi.simulate(scene, [0.0, -0.2 * unit, 1.5], [0.7 * unit, 0.0, 3.0], (0.0, 1.0), method=method)


def point(unit, time, method):
    """A point in an ellipse: nothing but lengths."""
    a, b = 1.3 * unit, unit

    def gap(q):
        return unit * (1 - (q[0] / a) ** 2 - (q[1] / b) ** 2)

    def gradient(q):
        return -2 * unit * np.array([q[0] / a**2, q[1] / b**2])

    stop = vi.NonlinearStop(gap, gradient, 0.9, curvature=2 * unit / b**2)
    body = vi.LinearSystem(np.eye(2), None, np.zeros((2, 2)), load=[0.0, -5 * unit / time**2])
    return vi.simulate(vi.Scene(body, stops=stop), [0.0, -0.2 * unit], [0.7 * unit / time, 0.0], (0.0, 3 * time), method=method)


def pressed(stop, method):
    """Two masses in slow time: one chatters onto a stop, is pressed on it, let go, and comes back."""
    length, slow = 1e-3, 1e3
    force = length / slow**2
    system = vi.LinearSystem(
        np.diag([0.8, 1.26]),
        np.array([[0.07, -0.02], [-0.02, 0.06]]) / slow,
        np.array([[1.2, -0.3], [-0.3, 1.1]]) / slow**2,
        load=np.array([1.21, 2.41]) * force,
    )
    harmonic = vi.Harmonic(np.array([1.54, 2.12]) * force, 1.72 / slow, -0.99)
    scene = vi.Scene(system, harmonic, [stop(1.0, 0.0), stop(-1.0, 1.3 * length)])
    start = np.array([-0.1, -0.08]) * length, np.array([0.16, 0.37]) * length / slow
    return vi.simulate(scene, *start, (7.3 * slow, 15.3 * slow), method=method)


def in_units(run, unit, time):
    lengths = np.array([unit, unit, 1.0])[: run.final[0].size]
    return np.concatenate([run.final[0] / lengths, run.final[1] * time / lengths, run.impacts["time"] / time])


@pytest.mark.parametrize("method", ["rk45", "dop853", "radau"])
@pytest.mark.parametrize("scene", [fallen, point])
def test_a_search_is_as_long_in_any_unit_of_length_and_of_time(scene, method):
    known = scene(1.0, 1.0, method)
    assert known.status == "finished"
    for unit, time in [(1e-3, 1.0), (1e-6, 1.0), (1e-9, 1.0), (1.0, 1e-6), (1.0, 1e6), (1e-6, 1e-6)]:
        run = scene(unit, time, method)
        assert run.status == "finished"
        assert run.stats.n_gap_evaluations <= 2 * known.stats.n_gap_evaluations, (unit, time)
        assert "times as many" not in run.message
        np.testing.assert_allclose(in_units(run, unit, time), in_units(known, 1.0, 1.0), atol=1e-6)


def test_a_bound_that_is_loose_in_its_unit_is_told():
    known, run = thrown(1.0), thrown(3e-3)
    assert "times as many" not in known.message
    assert run.status == "finished"
    assert "the search for contacts with stop" in run.message
    assert "times as many as it bends for along the motion" in run.message
    np.testing.assert_allclose(in_units(run, 3e-3, 1.0), in_units(known, 1.0, 1.0), atol=1e-6)


@pytest.mark.parametrize(("unit", "factor"), [(1e-6, 3.0), (1e-9, 1.0)])
def test_a_search_that_would_not_come_to_an_end_in_a_useful_time_ends_the_run(unit, factor):
    run = thrown(unit, factor)
    assert run.status == "uncertain"
    assert run.t_end < 1.0
    assert "takes too many looks at the gap" in run.message
    assert "times as many as it bends for along the motion" in run.message
    assert run.stats.n_gap_evaluations < 200_000


@pytest.mark.parametrize("method", ["rk45", "dop853", "radau"])
@pytest.mark.parametrize("curvature", [None, 0.0, 10.0])
def test_a_plane_that_is_given_by_its_gap_is_the_plane(method, curvature):
    def plane(sign, clearance):
        return vi.Stop([sign, 0.0], clearance, 0.5)

    def gap(sign, clearance):
        return vi.NonlinearStop(lambda q: clearance - sign * q[0], lambda q: np.array([-sign, 0.0]), 0.5, curvature=curvature)

    known, run = pressed(plane, method), pressed(gap, method)
    assert run.status == known.status == "finished"
    held = [np.count_nonzero(of.segments["kind"] == "stick") for of in (known, run)]
    assert held[0] == held[1] > 0
    times = np.linspace(7.3e3, known.t_end, 50)
    np.testing.assert_allclose(run.position(times), known.position(times), atol=1e-9 * 1e-3)
