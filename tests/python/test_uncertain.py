"""Searches for contacts that cannot be certified end a run with a status, and what came before is kept."""

from __future__ import annotations

import numpy as np
import pytest

import vibroimpact as vi

#: A point in the plane on which nothing acts, and a table under it.
POINT = vi.LinearSystem(np.ones(2), None, np.zeros(2))
TABLE = vi.Stop(1, 0.0, 1.0, side="lower")


def jump(q):
    return (4.0 if q[0] < 2.0 else 0.0) - q[0]


def onwards(q):
    return np.array([-1.0, 0.0])


def bend(q):
    return 4.0 + q[0] ** 2 - q[1]


def bend_gradient(q):
    return np.array([2 * q[0], -1.0])


def lie(q):
    return np.array([2 * q[0] + 3.0, -1.0])


UNCERTAIN = {
    "a jump, with a curvature": vi.NonlinearStop(jump, onwards, 1.0, curvature=1.0),
    "a jump": vi.NonlinearStop(jump, onwards, 1.0),
    "a gradient of another gap": vi.NonlinearStop(bend, lie, 1.0, curvature=2.0),
    "a curvature that is too small": vi.NonlinearStop(bend, bend_gradient, 1.0, curvature=1e-3),
    "a curvature beyond all reason": vi.NonlinearStop(bend, bend_gradient, 1.0, curvature=1e30),
}


@pytest.mark.parametrize("method", ["auto", "rk45", "dop853", "radau"])
@pytest.mark.parametrize("name", UNCERTAIN)
def test_a_search_without_a_certificate_ends_the_run_and_keeps_what_came_before(name, method):
    # The table is met at 0.5; the jump is at t = 2.
    scene = vi.Scene(POINT, None, [TABLE, UNCERTAIN[name]])
    run = vi.simulate(scene, [0.0, 0.5], [1.0, -1.0], (0, 10), method=method)
    assert run.status == "uncertain"
    assert "stop 1 could neither be found nor excluded" in run.message
    assert f"at t = {run.t_end:.15g}" in run.message or f"at t = {run.t_end!r}" in run.message
    assert run.t_end < 10
    assert np.all(run.impacts["stop"] == 0)
    np.testing.assert_allclose(run.position(run.t_end), run.final[0])
    if "jump" in name:
        assert 0.5 < run.t_end <= 2.0
        np.testing.assert_allclose(run.impacts["time"], [0.5], atol=1e-12)
        np.testing.assert_allclose(run.position(np.array([0.25, 0.5])), [[0.25, 0.25], [0.5, 0.0]], atol=1e-12)


def test_a_true_curvature_is_never_uncertain_and_no_impact_is_in_the_air():
    scene = vi.Scene(POINT, None, [TABLE, vi.NonlinearStop(bend, bend_gradient, 1.0, curvature=2.0)])
    for method in ("rk45", "dop853", "radau"):
        run = vi.simulate(scene, [0.0, 0.5], [1.0, -1.0], (0, 10), method=method)
        assert run.status == "finished"
        # Up at 45 degrees from (0.5, 0): 4 + x^2 = x - 1/2 nowhere.
        np.testing.assert_allclose(run.impacts["time"], [0.5], atol=1e-12)


def test_those_who_meet_an_uncertain_run_say_so():
    scene = vi.Scene(POINT, None, [TABLE, UNCERTAIN["a jump, with a curvature"]])
    starts = np.array([[0.0, 0.5], [-100.0, 0.5]])
    speeds = np.array([[1.0, -1.0], [1.0, 1.0]])
    many = vi.simulate_many(scene, starts, speeds, (0, 10))
    assert list(many.status) == ["uncertain", "finished"]


def test_without_a_curvature_a_stop_that_is_passed_at_a_probe_is_met():
    # A hill in the middle of one long step, whose ends and their derivatives tell nothing of it.
    def hill(q):
        return q[1] - 1.0 / (1.0 + (q[0] / 8.0) ** 8)

    def hill_gradient(q):
        u = q[0] / 8.0
        return np.array([u**7 / (1.0 + u**8) ** 2, 1.0])

    scene = vi.Scene(POINT, None, vi.NonlinearStop(hill, hill_gradient, 1.0))
    run = vi.simulate(scene, [-100.0, 0.5], [1.0, 0.0], (0, 200))
    assert len(run.impacts) >= 1
    assert abs(hill(run.position(run.impacts["time"][0]))) < 1e-8
    assert run.impacts["time"][0] == pytest.approx(92.0, abs=1e-6)


def between_walls(offset, curvature):
    """Make the scene of a point that flies to and fro past the middle of a disc of radius 0.05, at an offset from its centre."""
    centre, radius = np.array([0.5, 0.0]), 0.05
    walls = [vi.Stop(0, 0.0, 1.0, side="lower"), vi.Stop(0, 1.0, 1.0)]

    def gap(q):
        return np.hypot(*(q - centre)) - radius

    def gradient(q):
        return (q - centre) / np.hypot(*(q - centre))

    disc = vi.NonlinearStop(gap, gradient, 1.0, curvature=curvature)
    # A force of no size gives the flights their period. A run would meet the disc: the orbit of the walls alone is judged.
    force = vi.Harmonic([0.0, 0.0], np.pi)
    alone = vi.find_orbit(vi.Scene(POINT, force, walls), ([0.3, offset], [-1.0, 0.0]), 1, pattern=[0, 1])
    return vi.find_orbit(vi.Scene(POINT, force, [*walls, disc]), alone)


@pytest.mark.parametrize("curvature", [None, 60.0])
def test_an_orbit_whose_long_flights_pass_a_disc_is_not_admissible(curvature):
    # Along a flight of constant speed one step is enough, whose ends say nothing of the disc.
    for offset, deep in ((0.02, 0.03), (0.045, 0.005)):
        orbit = between_walls(offset, curvature)
        assert not orbit.is_admissible
        assert orbit.violation.stop == 2
        assert orbit.violation.depth == pytest.approx(deep, rel=1e-6 if curvature else 0.5)
    assert between_walls(0.0501, curvature).is_admissible


def test_an_orbit_whose_gap_contradicts_its_curvature_is_not_called_admissible():
    orbit = between_walls(0.06, 1e-3)
    assert not orbit.is_admissible
    assert np.isnan(orbit.violation.depth)
