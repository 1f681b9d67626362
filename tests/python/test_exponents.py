"""Lyapunov exponents: of orbits, of chaos and of what sticks, numbers of the literature, scenes of every kind, wrong calls."""

import numpy as np
import pytest

import vibroimpact as vi

SCENE = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 2.4), vi.Stop(0, 1.0, 0.8))
REST = (0.0, 0.0)


def exponents(force, end, **options):
    return vi.lyapunov_exponents(SCENE.replace(forcing_scale=force), *REST, (0, end), **options)


def test_chaos_and_what_sticks():
    chaos = exponents(5.0, 8000, skip=800)
    assert chaos.verdict == "chaotic"
    assert abs(chaos.exponents[0] - 0.1179) < 3 * np.hypot(chaos.errors[0], 0.0005)
    assert abs(chaos.sum - chaos.expected_sum) < 1e-9
    assert chaos.history.shape == (20, 2)
    assert np.allclose(chaos.history.mean(axis=0), chaos.exponents)
    stuck = exponents(6.0, 5000)
    assert (stuck.exponents == -np.inf).all()
    assert stuck.n_landings > 0
    assert (stuck.verdict, stuck.status) == ("periodic", "finished")
    assert np.isnan(stuck.expected_sum)
    assert "-inf" in repr(stuck)
    assert "chaotic: 0.1" in repr(chaos)


def test_what_a_stop_does_not_see_has_the_exponents_of_its_damping():
    # Bounces that come to rest take both directions of the first mass, and none of the other.
    system = vi.LinearSystem(np.eye(2), np.diag([0.1, 0.3]), np.diag([1.0, 2.0]))
    for restitution in (0.0, 0.5):
        scene = vi.Scene(system, vi.Harmonic([2.0, 1.0], 0.6), vi.Stop(0, 0.2, restitution))
        found = vi.lyapunov_exponents(scene, [0.0, 0.0], [0.3, 0.1], (0, 500))
        assert found.n_landings > 10
        assert abs(found.exponents[:2].sum() + 0.3) < 1e-8
        assert (found.exponents[2:] == -np.inf).all()


def test_an_orbit_has_the_exponents_of_its_multipliers():
    scene = SCENE.replace(forcing_scale=7.75)
    orbit = vi.periodic_orbits(scene, [0])[0]
    period = orbit.period
    found = vi.lyapunov_exponents(orbit.scene, orbit.q0, orbit.v0, (0, 1030.5 * period), skip=30.5 * period)
    assert np.allclose(found.exponents, np.log(np.abs(orbit.floquet_multipliers)) / period, atol=1e-6)
    assert found.n_impacts == 1000


def test_duffings_chaos_has_the_exponents_of_the_literature():
    # x'' + 0.2 x' - x + x^3 = 0.3 cos t: 0.159, -0.359 (ChaosTools, issue 301)
    law = vi.NonlinearSystem(
        1,
        lambda t, q, v: 0.3 * np.cos(t) + q - q**3 - 0.2 * v,
        jacobian=lambda t, q, v: np.array([[1 - 3 * q[0] ** 2, -0.2]]),
    )
    found = vi.lyapunov_exponents(vi.Scene(law, None, ()), 0.1, 0.0, (0, 400), skip=50, rtol=1e-6)
    assert abs(found.sum + 0.2) < 1e-6
    assert abs(found.exponents[0] - 0.159) < 0.1


def test_scenes_without_a_period():
    tones = [vi.Harmonic([0.6], 1.1), vi.Harmonic([0.5], 1.1 * 5**0.5)]
    scene = vi.Scene(SCENE.system, tones, vi.Stop(0, 0.8, 0.7))
    found = vi.lyapunov_exponents(scene, *REST, (0, 900), skip=300)
    assert abs(found.sum - found.expected_sum) < 1e-9
    assert found.verdict in {"torus", "chaotic"}
    t = np.linspace(0, 100, 2001)
    record = vi.Load(0, (t, np.sin(1.3 * t) + np.sin(2.9 * t)))
    scene = vi.Scene(SCENE.system, record, vi.Stop(0, 0.5, 0.7))
    by = {method: vi.lyapunov_exponents(scene, *REST, (0, 100), method=method, rtol=1e-11) for method in ("exact", "dop853")}
    assert np.allclose(by["exact"].exponents, by["dop853"].exponents, atol=1e-6)
    assert abs(by["exact"].sum - by["exact"].expected_sum) < 1e-9


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"skip": 10.0}, "skip is 10, but it must be at least 0 and shorter than the span of 10"),
        ({"skip": -1.0}, "skip is -1"),
        ({"n_exponents": 0}, "n_exponents is 0, but it must be at least 1 and at most 2"),
        ({"n_exponents": 3}, "n_exponents is 3"),
        ({"n_exponents": -1}, "n_exponents is -1"),
        ({"rtol": np.nan}, "rtol is NaN"),
    ],
)
def test_wrong_arguments_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        exponents(5.0, 10.0, **arguments)


def test_wrong_starts_are_refused():
    with pytest.raises(ValueError, match="q0"):
        vi.lyapunov_exponents(SCENE, [0.0, 0.0], [0.0], (0, 10))
    with pytest.raises(ValueError, match="inside stop 0"):
        vi.lyapunov_exponents(SCENE, 2.0, 0.0, (0, 10))
    with pytest.raises(TypeError, match="scene is 3"):
        vi.lyapunov_exponents(3, 0.0, 0.0, (0, 10))


def test_a_run_that_ends_before_time_counts_has_no_exponents():
    jaws = [vi.Stop(0, 0.5, 0.8), vi.Stop(0, 0.2, 0.8, side="lower", motion=vi.Harmonic([0.9], 1.0))]
    scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([0.3], 1.0), jaws)
    found = vi.lyapunov_exponents(scene, [0.0], [0.1], (0, 400.0), skip=300)
    assert np.isnan([*found.exponents, *found.errors, found.sum, found.expected_sum]).all()
    assert (found.verdict, found.n_impacts, found.history.shape) == ("undecided", 0, (0, 2))
    assert "before the time from 300 on that counts" in found.message
    assert found.message in repr(found)


def test_a_drift_is_no_torus():
    scene = vi.Scene(vi.LinearSystem(1.0, 1.0, 0.0, load=[0.3]), vi.Harmonic([1.0], 1.0))
    found = vi.lyapunov_exponents(scene, [0.0], [0.0], (0, 2000), skip=100)
    assert found.verdict == "drift"
    assert "advances by (1.88496)" in found.message
