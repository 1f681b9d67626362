"""Periodic forces of several harmonics: exact flights, steps, lasting contact, orbits."""

import os
import pickle

import numpy as np
import pytest

import vibroimpact as vi

CASES = int(os.environ.get("VIBROIMPACT_CASES", "50"))
PAIR = vi.LinearSystem([2.0, 1.0], [[0.3, -0.1], [-0.1, 0.1]], [[5.0, -2.0], [-2.0, 2.0]])
STOPS = [vi.Stop(0, 0.15, 0.8), vi.Stop([-0.2, 1.0], 0.3, 0.7)]
AMPLITUDES = np.array([[1.0, 0.4j], [0.5 - 0.3j, 0.2], [0.0, 0.4]])
STEPS = ["rk45", "dop853", "radau"]


def scene(force, system=PAIR, stops=STOPS):
    return vi.Scene(system, force, stops)


def first_impacts(run, count):
    assert run.status == "finished"
    assert len(run.impacts) >= count
    return run.impacts[:count]


def assert_same_impacts(one, other, count, tolerance):
    a, b = first_impacts(one, count), first_impacts(other, count)
    assert list(a["stop"]) == list(b["stop"])
    for column in ("time", "speed_before", "impulse"):
        np.testing.assert_allclose(a[column], b[column], rtol=tolerance, atol=tolerance)


def closed(orbit):
    """By how much a run by steps over one period misses the beginning."""
    t = 0.37 * orbit.period
    q, v = orbit.position(t), orbit.velocity(t)
    run = vi.simulate(orbit.scene, q, v, (t, t + orbit.period), method="dop853", rtol=1e-12, atol=1e-13)
    return max(np.abs(run.final[0] - q).max(), np.abs(run.final[1] - v).max()) / (1 + np.abs(v).max())


@pytest.mark.parametrize("method", ["exact", *STEPS])
@pytest.mark.parametrize("phase", [0.0, 0.7])
def test_one_harmonic_is_the_harmonic_bit_for_bit(method, phase):
    runs = [
        vi.simulate(scene(force), [0.0, 0.0], [0.0, 0.1], (0.0, 30.0), method=method)
        for force in (vi.Harmonic(AMPLITUDES[0], 1.3, phase), vi.Fourier(AMPLITUDES[:1], 1.3, phase))
    ]
    assert len(runs[0].impacts) > 5
    assert all(np.array_equal(a, b) for a, b in zip(runs[0].final, runs[1].final, strict=True))
    assert np.array_equal(runs[0].impacts, runs[1].impacts)


def test_a_second_frequency_is_an_undamped_coordinate_that_pushes():
    w, second = 1.1, AMPLITUDES[1].real
    force = vi.Fourier([AMPLITUDES[0], second], w, 0.4)
    # y = cos(2 (w t + phase)) is a free oscillation of its own, and pushes through a column of the stiffness.
    mass, damping, stiffness = (np.zeros((3, 3)) for _ in range(3))
    mass[:2, :2], damping[:2, :2], stiffness[:2, :2] = np.diag([2.0, 1.0]), PAIR.damping, PAIR.stiffness
    mass[2, 2], stiffness[2, 2] = 1.0, (2 * w) ** 2
    stiffness[:2, 2] = -second
    wide = vi.LinearSystem(mass, damping, stiffness)
    stops = [vi.Stop([1.0, 0.0, 0.0], 0.15, 0.8), vi.Stop([-0.2, 1.0, 0.0], 0.3, 0.7)]
    by_coordinate = vi.Scene(wide, vi.Harmonic([*AMPLITUDES[0], 0.0], w, 0.4), stops)
    angle = 2 * 0.4
    start = ([0.0, 0.0, np.cos(angle)], [0.0, 0.1, -2 * w * np.sin(angle)])
    one = vi.simulate(scene(force), [0.0, 0.0], [0.0, 0.1], (0.0, 60.0))
    other = vi.simulate(by_coordinate, *start, (0.0, 60.0), method="exact")
    assert_same_impacts(one, other, 20, 1e-11)


@pytest.mark.parametrize("method", STEPS)
@pytest.mark.parametrize(
    "system",
    [
        PAIR,
        # Damping that is not proportional; a mode in step with the second harmonic; a free body beside it.
        vi.LinearSystem([2.0, 1.0], [[0.6, 0.0], [0.0, 0.0]], [[5.0, -2.0], [-2.0, 2.0]]),
        vi.LinearSystem([1.0, 1.0], [[0.0, 0.0], [0.0, 0.2]], [[2.6**2, 0.0], [0.0, 3.0]]),
        vi.LinearSystem([1.0, 1.0], [[0.2, -0.2], [-0.2, 0.2]], [[3.0, -3.0], [-3.0, 3.0]]),
        # Equal eigenvalues with one vector.
        vi.LinearSystem([1.0, 1.0], [[0.0, 0.0], [0.0, 0.0]], [[3.0, 1.0], [0.0, 3.0]]),
    ],
    ids=["pair", "complex", "resonant", "free", "defective"],
)
def test_exact_flights_are_what_steps_come_to(system, method):
    force = vi.Fourier(AMPLITUDES, 1.3, 0.2, mean=[0.4, 0.1])
    start = ([0.05, 0.0], [0.0, 0.1])
    exact = vi.simulate(scene(force, system), *start, (0.0, 20.0), method="exact")
    steps = vi.simulate(scene(force, system), *start, (0.0, 20.0), method=method, rtol=1e-11, atol=1e-13)
    count = min(len(exact.impacts), len(steps.impacts), 8)
    assert count >= 2
    assert_same_impacts(exact, steps, count, 1e-7)


def test_a_stop_is_held_and_let_go_by_the_sum_of_the_harmonics():
    stop = vi.Stop(0, 0.0, 0.0)
    system = vi.LinearSystem(1.0, 0.2, 4.0)
    force = vi.Fourier([1.5, 0.8j, -0.4], 1.0, 0.3, mean=[0.9])
    runs = [
        vi.simulate(vi.Scene(system, force, stop), -0.3, 0.0, (0.0, 30.0), method=m, rtol=1e-11, atol=1e-13)
        for m in ("exact", "dop853")
    ]
    sticks = [[s for s in run.segments if s["kind"] == "stick"] for run in runs]
    assert len(sticks[0]) == len(sticks[1]) > 2

    def pressure(t):
        angle = t + 0.3
        harmonics = ((1.5, 1), (0.8j, 2), (-0.4, 3))
        return 0.9 + sum((a * np.exp(1j * k * angle)).real for a, k in harmonics)

    for a, b in zip(*sticks, strict=True):
        np.testing.assert_allclose([a["start"], a["end"]], [b["start"], b["end"]], atol=1e-8)
        if a["end"] < 30.0:
            assert abs(pressure(a["end"])) < 1e-9


@pytest.mark.parametrize("method", ["exact", "dop853"])
def test_the_energy_ledger_closes(method):
    force = vi.Fourier(AMPLITUDES, 1.3, 0.2, mean=[0.1, -0.2])
    run = vi.simulate(scene(force), [0.0, 0.0], [0.0, 0.1], (0.0, 40.0), method=method, keep="motion", rtol=1e-10)
    energy = run.energy
    assert np.abs(energy.balance).max() < 1e-8 * np.abs(energy.forcing_work).max()


def test_forces_on_a_pendulum_are_those_written_into_its_equations():
    force = vi.Fourier([[0.3, 0.0], [0.1j, 0.2]], 1.2, 0.5, mean=[0.05, 0.0])
    chain = vi.PendulumChain([1.0, 0.6], [1.0, 0.8], damping=0.1, gravity=1.0)
    walls = [vi.Wall(1, 0.4, 0.7)]
    runs = [
        vi.simulate(vi.Scene(chain, force, walls), [0.1, -0.1], [0.0, 0.2], (0.0, 30.0), method=m, rtol=1e-11, atol=1e-13)
        for m in ("dop853", "radau")
    ]
    assert_same_impacts(*runs, 3, 1e-7)
    inertia = np.array([[1.6, 0.6 * 0.8], [0.6 * 0.8, 0.6 * 0.64]])
    moment = np.array([1.6, 0.6 * 0.8])

    def mass(q):
        return inertia * np.cos(q[:, None] - q[None, :])

    def acceleration(t, q, v):
        angle = 1.2 * t + 0.5
        amplitudes = np.array([[0.3, 0.0], [0.1j, 0.2]])
        f = np.array([0.05, 0.0]) + sum((a * np.exp(1j * k * angle)).real for k, a in enumerate(amplitudes, 1))
        f = f - moment * np.sin(q) - (inertia * np.sin(q[:, None] - q[None, :])) @ v**2
        return np.linalg.solve(mass(q), f - np.asarray(chain.damping) @ v)

    def gap(q):
        return 0.4 - np.sin(q[0]) - 0.8 * np.sin(q[1])

    def gradient(q):
        return np.array([-np.cos(q[0]), -0.8 * np.cos(q[1])])

    written = vi.NonlinearSystem(2, acceleration, mass=mass)
    stop = vi.NonlinearStop(gap, gradient, 0.7)
    other = vi.simulate(
        vi.Scene(written, None, stop), [0.1, -0.1], [0.0, 0.2], (0.0, 30.0), method="dop853", rtol=1e-11, atol=1e-13
    )
    assert_same_impacts(runs[0], other, 3, 1e-7)


def test_an_orbit_under_several_harmonics_is_found_and_its_multipliers_are_those_of_differences():
    force = vi.Fourier([4.0, 1.0 - 0.5j], 2.8)
    one = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), force, vi.Stop(0, 0.05, 0.8))
    known = vi.periodic_orbits(one, [0])[0]
    # From the orbit at another force, by shooting.
    orbit = vi.find_orbit(one, vi.periodic_orbits(one.replace(forcing_scale=1.05), [0])[0])
    np.testing.assert_allclose([*orbit.q0, *orbit.v0, orbit.phase], [*known.q0, *known.v0, known.phase], atol=1e-9)
    assert orbit.coefficients is None
    period = orbit.period
    assert orbit.is_admissible
    assert closed(orbit) < 1e-8
    # The state a little after the impact, a period later, by differences.
    t, h = 0.05 * period, 1e-6

    def mapped(q, v):
        run = vi.simulate(orbit.scene, q, v, (t, t + period))
        return np.concatenate(run.final)

    q, v = orbit.position(t), orbit.velocity(t)
    columns = [(mapped(q + h * e[:1], v + h * e[1:]) - mapped(q - h * e[:1], v - h * e[1:])) / (2 * h) for e in np.eye(2)]
    expected = np.linalg.eigvals(np.array(columns).T)
    found = orbit.floquet_multipliers
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(expected.astype(complex)), atol=1e-6)


def test_many_starts_are_those_one_by_one():
    force = vi.Fourier(AMPLITUDES, 1.3, mean=[0.1, 0.0])
    q0, v0 = np.zeros((5, 2)), np.linspace(-1.0, 1.0, 10).reshape(5, 2)
    many = vi.simulate_many(scene(force), q0, v0, (0.0, 20.0))
    for k in range(5):
        one = vi.simulate(scene(force), q0[k], v0[k], (0.0, 20.0))
        assert np.array_equal(one.final[0], many.q[k])
        assert np.array_equal(one.final[1], many.v[k])


def test_a_fourier_goes_out_and_back():
    plain = vi.Fourier([[1.0, 0.0], [0.5, 0.2]], 1.5, 0.3)
    full = vi.Fourier(AMPLITUDES, 1.5, 0.3, mean=[1.0, 2.0])
    for force in (plain, full):
        again = pickle.loads(pickle.dumps(force))
        assert again == force
        assert eval(repr(force), {"Fourier": vi.Fourier, "array": np.array}) == force
        assert scene(force).forcing == force
    assert plain.mean is None
    assert plain.amplitudes.dtype == float
    assert plain != full
    changed = scene(full).replace(frequency=2.0, phase=0.1, forcing_scale=3.0).forcing
    assert changed == vi.Fourier(3.0 * AMPLITUDES, 2.0, 0.1, mean=[3.0, 6.0])


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: vi.Fourier([], 1.0), "amplitudes"),
        (lambda: vi.Fourier([[1.0, np.nan]], 1.0), r"amplitudes\[0\]\[1\]"),
        (lambda: vi.Fourier(np.ones((2, 2, 2)), 1.0), "two axes"),
        (lambda: vi.Fourier([1.0], 0.0), "frequency"),
        (lambda: vi.Fourier([1.0], 1.0, mean=[1.0, 2.0]), "mean"),
        (lambda: vi.Fourier.fit(np.ones(4), 1.0, 2), "4 samples tell at most 1"),
        (lambda: vi.Fourier.fit(np.ones(4), 1.0, 0), "n_harmonics"),
        (lambda: vi.Fourier.fit(np.ones(4), 1.0, -1), "n_harmonics"),
        (lambda: scene(vi.Fourier([1.0], 1.0)), "forcing.amplitudes"),
        (lambda: scene(vi.Fourier(AMPLITUDES, 1.0)).replace(amplitude=2.0), "amplitude"),
        (lambda: vi.periodic_orbits(scene(vi.Fourier(AMPLITUDES, 1.0)), [0, 1]), "find_orbit"),
        (lambda: vi.periodic_orbits(scene(vi.Fourier(AMPLITUDES, 1.0)), [(0, 1)], free="clearance"), "find_orbit"),
        (lambda: vi.simulate(scene(vi.Fourier(AMPLITUDES, 1.0)), [0, 0], [0, 0], (0, 1), method="taylor"), "taylor"),
    ],
)
def test_what_cannot_be_is_refused(make, words):
    with pytest.raises(ValueError, match=words):
        make()


@pytest.mark.parametrize("seed", range(CASES))
def test_every_orbit_of_one_instant_is_found_under_several_harmonics(seed):
    random = np.random.default_rng(seed)
    n, k = random.integers(1, 4), random.integers(2, 6)
    stiffness = random.normal(size=(n, n))
    stiffness = stiffness @ stiffness.T + 0.3 * np.eye(n)
    damping = 0.05 * stiffness + 0.05 * np.eye(n)
    if seed % 3 == 0:
        damping = damping + 0.1 * np.diag(random.random(n))
    system = vi.LinearSystem(random.uniform(0.5, 2.0, n), damping, stiffness)
    amplitudes = random.normal(size=(k, n)) + 1j * random.normal(size=(k, n))
    force = vi.Fourier(amplitudes / np.arange(1, k + 1)[:, None], random.uniform(0.5, 2.0), mean=random.normal(size=n))
    normal = random.normal(size=n)
    base = vi.Scene(system, force, vi.Stop(normal, 0.0, random.uniform(0.1, 1.0)))
    # Where the contact would be at each phase says which clearances have how many orbits; it has the harmonics of the force.
    sampled = 2 * np.pi * np.arange(16) / 16
    samples = np.array([normal @ vi.periodic_orbits(base, [0], phase=phase)[0].q0 for phase in sampled])
    harmonics = np.fft.rfft(samples) / 16
    assert np.abs(harmonics[k + 1 :]).max() < 1e-10 * np.abs(harmonics).max()
    phases = 2 * np.pi * np.arange(100_000) / 100_000
    orders = np.arange(1, k + 1)
    places = harmonics[0].real + 2 * (np.exp(1j * np.outer(phases, orders)) @ harmonics[1 : k + 1]).real
    for part in (0.1, 0.5, 0.9, 1.1):
        clearance = places.min() + part * (places.max() - places.min())
        orbits = vi.periodic_orbits(base.replace(clearance=clearance), [0])
        crossings = np.flatnonzero((places > clearance) != (np.roll(places, -1) > clearance))
        assert len(orbits) == len(crossings)
        found = np.sort([orbit.phase for orbit in orbits])
        for phase, low in zip(found, phases[crossings], strict=True):
            assert 0 <= (phase - low) % (2 * np.pi) <= phases[1] * (1 + 1e-6)
        for orbit in orbits:
            assert abs(normal @ orbit.q0 - clearance) < 1e-10 * (1 + abs(clearance))
            if orbit.is_admissible:
                assert closed(orbit) < 1e-6


def test_zero_higher_harmonics_leave_the_orbits_as_they_are():
    one = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic(1.0, 2.8), vi.Stop(0, 0.1, 0.8))
    many = one.replace(forcing=vi.Fourier([1.0, 0.0, 0.0], 2.8))
    for n_periods in (1, 2):
        a, b = (vi.periodic_orbits(s, [0], n_periods=n_periods) for s in (one, many))
        assert len(a) == len(b) > 0
        for x, y in zip(a, b, strict=True):
            assert abs(x.phase - y.phase) < 1e-10
            np.testing.assert_allclose(x.q0, y.q0, atol=1e-11)
            assert (x.is_admissible, x.stability.is_stable) == (y.is_admissible, y.stability.is_stable)


def test_a_map_under_several_harmonics_is_its_cells_one_by_one():
    force = vi.Fourier([[1.0, 0.4j], [0.5 - 0.3j, 0.2]], 1.3, mean=[0.05, -0.1])
    base = vi.Scene(PAIR, force, vi.Stop(0, 0.15, 0.8))
    scales, clearances = [0.5, 1.0, 2.0], [0.02, 0.1, 0.3]
    found = vi.existence_map(base, [0], ("forcing_scale", scales), ("clearance", clearances))
    for i, clearance in enumerate(clearances):
        for j, scale in enumerate(scales):
            orbits = vi.periodic_orbits(base.replace(forcing_scale=scale, clearance=clearance), [0])
            assert found.n_orbits[i, j] == len(orbits)
            if orbits:
                assert found.is_admissible[i, j] == bool(orbits[0].is_admissible)


@pytest.mark.parametrize("mass", [2.0, lambda q: np.array([[2.0 + q[0] ** 2]])])
def test_a_force_on_a_users_equation_is_the_one_written_into_it(mass):
    amplitudes, mean = np.array([[1.2], [0.5j], [-0.3]]), 0.4

    def inertia(q):
        return mass(q)[0, 0] if callable(mass) else mass

    def free(t, q, v):
        return [-(q[0] + q[0] ** 3 + 0.2 * v[0]) / inertia(q)]

    def driven(t, q, v):
        harmonics = enumerate(amplitudes[:, 0], 1)
        force = mean + sum((a * np.exp(1j * k * (1.1 * t + 0.3))).real for k, a in harmonics)
        return [free(t, q, v)[0] + force / inertia(q)]

    matrix = mass if callable(mass) else [[mass]]
    stop = vi.Stop(0, 0.4, 0.8)
    by_forcing = vi.Scene(vi.NonlinearSystem(1, free, mass=matrix), vi.Fourier(amplitudes, 1.1, 0.3, mean=[mean]), stop)
    written = vi.Scene(vi.NonlinearSystem(1, driven, mass=matrix), None, stop)
    options = {"method": "dop853", "rtol": 1e-11, "atol": 1e-13}
    assert_same_impacts(*(vi.simulate(s, 0.0, 0.0, (0.0, 30.0), **options) for s in (by_forcing, written)), 5, 1e-8)


def test_small_motions_of_a_pendulum_under_several_harmonics_are_those_of_its_linear_scene():
    chain = vi.PendulumChain([1.0, 0.6], [1.0, 0.8], damping=0.1, gravity=9.81)
    large = vi.Scene(chain, vi.Fourier([[1e-5, 0.0], [0.0, 2e-5j]], 2.0), vi.Wall(1, 1e-6, 0.7))
    small = large.linearise()
    one, other = (vi.simulate(s, [0.0, 0.0], [0.0, 0.0], (0.0, 10.0), rtol=1e-11, atol=1e-18) for s in (large, small))
    count = min(len(one.impacts), len(other.impacts), 5)
    assert count >= 2
    np.testing.assert_allclose(one.impacts["time"][:count], other.impacts["time"][:count], atol=1e-6)


def test_an_orbit_that_sticks_is_found_and_goes_out_and_back():
    system = vi.LinearSystem(1.0, 0.2, 4.0)
    force = vi.Fourier([1.5, 0.8j, -0.4], 1.0, 0.3, mean=[0.9])
    one = vi.Scene(system, force, vi.Stop(0, 0.0, 0.0))
    long = vi.simulate(one, -0.3, 0.0, (0.0, 50 * one.period))
    orbit = vi.find_orbit(one, long, 1)
    assert any(segment["kind"] == "stick" for segment in orbit.segments)
    assert closed(orbit) < 1e-8
    for result in (orbit, long):
        again = pickle.loads(pickle.dumps(result))
        t = 0.4 * one.period
        assert np.array_equal(again.position(t), result.position(t))


def test_a_plan_names_the_harmonics():
    assert "forcing of 3 harmonics: its steady response split off" in scene(vi.Fourier(AMPLITUDES, 1.3)).plan()
    resonant = vi.LinearSystem([1.0, 1.0], [[0.0, 0.0], [0.0, 0.2]], [[2.6**2, 0.0], [0.0, 3.0]])
    assert "forcing of 3 harmonics: the response from rest" in scene(vi.Fourier(AMPLITUDES, 1.3), resonant).plan()
