"""The energy ledger from Python, and nonlinear scenes in ensembles and orbits."""

import time

import mpmath
import numpy as np
import pytest

import vibroimpact as vi


def test_the_ledger_balances_through_impacts_chatter_and_contact():
    system = vi.LinearSystem([1.0], [0.1], [1.0])
    scene = vi.Scene(system, vi.Harmonic([1.0], 0.3), vi.Stop(0, 0.2, 0.6))
    for method in ("exact", "rk45", "dop853", "radau"):
        run = vi.simulate(scene, [0.0], [0.0], (0, 100), method=method)
        assert {"flight", "chatter", "stick"} == set(run.segments["kind"])
        energy = run.energy
        assert energy.kinetic.shape == run.t.shape
        largest = max(np.abs(getattr(energy, name)).max() for name in ("kinetic", "forcing_work", "damping_loss", "impact_loss"))
        assert np.abs(energy.balance).max() < 1e-8 * largest
        np.testing.assert_allclose(energy.kinetic, 0.5 * run.v[:, 0] ** 2, atol=1e-14)


def ledger_of_a_period(orbit):
    energy = orbit.energy
    assert energy.t[0] == 0
    assert energy.t[-1] == pytest.approx(orbit.period, rel=1e-12)
    stored = energy.kinetic + energy.potential
    size = max(energy.kinetic.max(), energy.impact_loss[-1], abs(energy.forcing_work[-1]))
    assert stored[-1] == pytest.approx(stored[0], abs=1e-9 * size)
    assert energy.forcing_work[-1] == pytest.approx(energy.damping_loss[-1] + energy.impact_loss[-1], abs=1e-9 * size)
    return energy


def test_what_the_forcing_brings_in_a_period_is_lost_in_it():
    linear = vi.periodic_orbits(vi.paper_scene(kind=3), pattern=[1], n_periods=2)[0]
    energy = ledger_of_a_period(linear)
    # The loss at the impacts by the velocities on both sides of each.
    mass, times = linear.scene.system.mass, linear.impacts["time"]
    before, after = (np.array([linear.velocity(t, side) for t in times]) for side in ("before", "after"))
    lost = sum(b @ mass @ b - a @ mass @ a for b, a in zip(before, after, strict=True)) / 2
    assert energy.impact_loss[-1] == pytest.approx(lost, rel=1e-9)
    # Two periods of a trajectory along it bring twice as much.
    run = vi.simulate(linear.scene, linear.q0, linear.v0, (0, 2.5 * linear.period))
    t, work = run.energy.t, run.energy.forcing_work
    at = [work[np.searchsorted(t, k * linear.period)] for k in (1, 2)]
    assert at[1] - at[0] == pytest.approx(energy.forcing_work[-1], rel=1e-6)
    ledger_of_a_period(vi.find_orbit(vi.paper_scene(kind=3, linear=False), linear))


def test_a_period_with_chatter_and_lasting_contact_has_its_ledger():
    system = vi.LinearSystem([1.0], [0.1], [1.0])
    scene = vi.Scene(system, vi.Harmonic([1.0], 0.3), vi.Stop(0, 0.2, 0.6))
    run = vi.simulate(scene, [0.0], [0.0], (0, 200))
    orbit = vi.find_orbit(scene, run)
    assert {"flight", "chatter", "stick"} <= set(orbit.segments["kind"])
    ledger_of_a_period(orbit)


def test_the_ledger_needs_the_motion_and_forces_that_can_be_told_apart():
    scene = vi.paper_scene(kind=3)
    with pytest.raises(ValueError, match="keep"):
        _ = vi.simulate(scene, [0, 0], [0, 0.3], (0, 10), keep="impacts").energy
    for known, lack in (({}, "mass"), ({"mass": [[1.0]]}, "potential"), ({"potential": lambda q: q @ q / 2}, "mass")):
        functions = vi.Scene(vi.NonlinearSystem(1, lambda t, q, v: -q, **known))
        with pytest.raises(ValueError, match=f"NonlinearSystem without `{lack}`"):
            _ = vi.simulate(functions, [1.0], [0.0], (0, 1)).energy


def test_functions_have_the_ledger_of_the_linear_system_that_they_write_out():
    mass, damping, stiffness = np.array([[2.0, 0.5], [0.5, 1.0]]), 0.1 * np.eye(2), np.array([[5.0, -2.0], [-2.0, 3.0]])

    def acceleration(t, q, v):
        return np.linalg.solve(mass, -damping @ v - stiffness @ q)

    systems = [
        vi.NonlinearSystem(2, acceleration, mass=mass, potential=lambda q: 0.5 * q @ stiffness @ q),
        vi.LinearSystem(mass, damping, stiffness),
    ]
    times = np.linspace(0, 20, 41)
    ledgers = []
    for system in systems:
        scene = vi.Scene(system, vi.Harmonic([1.0, 0.3], 0.9), vi.Stop(0, 0.1, 0.7))
        run = vi.simulate(scene, [0, 0], [0.4, 0.4], (0, 20), method="rk45", t_eval=times)
        assert len(run.impacts) > 3
        ledgers.append(run.energy)
    for name in ("kinetic", "potential", "forcing_work", "damping_loss", "impact_loss"):
        np.testing.assert_allclose(getattr(ledgers[0], name), getattr(ledgers[1], name), rtol=1e-7, atol=1e-7)
    assert np.abs(ledgers[0].balance).max() < 1e-8


def test_large_angles_have_their_own_orbit_and_multipliers():
    linear = vi.periodic_orbits(vi.paper_scene(kind=3), pattern=[1], n_periods=2)[0]
    orbit = vi.find_orbit(vi.paper_scene(kind=3, linear=False), linear)
    assert orbit.is_admissible
    assert orbit.is_stable
    assert orbit.coefficients is None
    assert orbit.phase != linear.phase
    run = vi.simulate(orbit.scene, orbit.q0, orbit.v0, (0, 20 * orbit.period), rtol=1e-11)
    np.testing.assert_allclose(run.final[0], orbit.q0, atol=1e-7)
    np.testing.assert_allclose(orbit.position([0.0])[0], orbit.q0)


def test_an_ensemble_of_pendulums_on_two_threads_has_the_bits_of_one():
    scene = vi.paper_scene(kind=3, linear=False)
    q0, v0 = np.zeros((6, 2)), np.linspace(0, 1, 12).reshape(6, 2)
    one = vi.simulate_many(scene, q0, v0, (0, 20), workers=1)
    two = vi.simulate_many(scene, q0, v0, (0, 20), workers=2)
    np.testing.assert_array_equal(one.q, two.q)
    np.testing.assert_array_equal(one.n_impacts, two.n_impacts)


@pytest.mark.parametrize("v0", [0.0, 1.0])
def test_a_fast_part_that_has_died_out_takes_no_steps(v0):
    # q'' + (1e8 + 1e-8) q' + q = 0: roots -1e8, -1e-8.
    fast, slow = 1e8, 1e-8
    run = vi.simulate(vi.Scene(vi.LinearSystem(1.0, fast + slow, 1.0)), 1.0, v0, (0, 10))
    start = time.perf_counter()
    energy = run.energy
    assert time.perf_counter() - start < 1.0
    # q = a e^(-slow t) + b e^(-fast t)
    a = (fast + v0) / (fast - slow)
    end = a * np.exp(-slow * 10)
    lost = 0.5 * (1.0 + v0**2) - 0.5 * end**2 * (1.0 + slow**2)
    assert energy.damping_loss[-1] == pytest.approx(lost, rel=1e-7)
    assert np.abs(energy.balance).max() < 1e-12
    assert np.all(np.diff(energy.damping_loss) >= 0.0)


def test_the_ledger_of_many_impacts_is_made_in_the_time_of_the_run():
    stops = [vi.Stop(0, 1.0, 1.0), vi.Stop(0, 1.0, 1.0, side="lower")]
    run = vi.simulate(vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0), None, stops), 0.0, 2.0, (0, 100_000))
    assert len(run.impacts) == 100_000
    start = time.perf_counter()
    energy = run.energy
    assert time.perf_counter() - start < 5.0
    assert np.allclose(energy.kinetic, 2.0, rtol=1e-12)
    assert np.abs(energy.balance).max() < 1e-9


def test_the_points_of_many_impacts_are_few():
    stops = [vi.Stop(0, 1.0, 1.0), vi.Stop(0, 1.0, 1.0, side="lower")]
    run = vi.simulate(vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0), None, stops), 0.0, 2.0, (0, 100_000))
    t = run.t
    assert len(t) <= 1_000_000 + 2 * len(run.impacts)
    before, after = (np.searchsorted(t, run.impacts["time"], side=side) for side in ("left", "right"))
    assert np.all(after - before == 2), "both sides of each impact"
    assert np.array_equal(run.v[before], -run.v[before + 1])


@pytest.mark.parametrize("method", ["exact", "dop853"])
def test_a_large_phase_is_known_to_all_its_digits(method):
    # 1e10 rad: added to an angle as it is it would leave six digits of it.
    scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], 1.3, 1e10), vi.Stop(0, 0.5, 0.8))
    run = vi.simulate(scene, 0.0, 0.0, (0, 20), method=method, rtol=1e-11, atol=1e-13)
    with mpmath.workdps(40):
        small = float(mpmath.mpf(1e10) % (2 * mpmath.pi))
    near = vi.simulate(scene.replace(phase=small), 0.0, 0.0, (0, 20), method="exact")
    np.testing.assert_allclose(run.impacts["time"], near.impacts["time"], atol=1e-8)
    assert np.abs(run.energy.balance).max() < 1e-9
