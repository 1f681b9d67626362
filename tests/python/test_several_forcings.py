"""Several forcings at once: one period where all frequencies are whole multiples of the lowest, none elsewhere."""

import pickle

import numpy as np
import pytest

import vibroimpact as vi

MASS = np.array([[2.0, 0.3], [0.3, 1.0]])
DAMPING = np.array([[0.2, 0.03], [0.05, 0.15]])
STIFFNESS = np.array([[9.0, -2.0], [-2.0, 5.0]])
STOPS = [vi.Stop(0, 0.12, 0.8), vi.Stop([0.3, 1.0], 0.2, 0.6, side="lower")]
REST = np.zeros(2)


def system(influence=None):
    return vi.LinearSystem(MASS, DAMPING, STIFFNESS, influence=influence)


def same(one, other, tolerance, least=6):
    assert one.impacts.size == other.impacts.size >= least
    np.testing.assert_array_equal(one.impacts["stop"], other.impacts["stop"])
    for name in ("time", "impulse", "speed_before"):
        np.testing.assert_allclose(one.impacts[name], other.impacts[name], rtol=0, atol=tolerance)
    np.testing.assert_allclose(one.final, other.final, rtol=0, atol=tolerance)


def test_harmonics_of_one_frequency_are_a_fourier_force():
    a, b = np.array([1.0, 0.5j]), np.array([0.3, -0.7])
    w, p, r = 1.3, 0.4, -0.9
    several = vi.Scene(system(), [vi.Harmonic(b, 3 * w, r), vi.Harmonic(a, w, p)], STOPS)
    # b cos(3 w t + r) = Re(b e^{i(r - 3 p)} e^{3i(w t + p)})
    fourier = vi.Scene(system(), vi.Fourier([a, 0 * a, b * np.exp(1j * (r - 3 * p))], w, p), STOPS)
    assert several.period == fourier.period == 2 * np.pi / w
    runs = [vi.simulate(scene, REST, REST, (0, 60)) for scene in (several, fourier)]
    same(*runs, 1e-11)
    # The phase of impacts is that of the fundamental frequency.
    np.testing.assert_allclose(*(run.impacts["phase"] for run in runs), atol=1e-10)
    steps = vi.simulate(several, REST, REST, (0, 60), method="dop853", rtol=1e-11, atol=1e-13)
    same(runs[0], steps, 1e-7)
    assert [orbit.phase for orbit in vi.periodic_orbits(several, [0], n_periods=2)] == pytest.approx(
        [orbit.phase for orbit in vi.periodic_orbits(fourier, [0], n_periods=2)], abs=1e-10
    )


def test_harmonics_of_a_base_are_the_forces_they_make():
    influence = np.array([1.0, -0.4])
    amplitudes, w, p = np.array([0.1, 0.02j, 0.01 - 0.01j]), 1.7, 0.3
    base = vi.Scene(system(influence), vi.BaseMotion(amplitudes, w, p), STOPS)
    k = np.arange(1, 4)[:, None]
    forces = amplitudes[:, None] * (k * w) ** 2 * (MASS @ influence)
    force = vi.Scene(system(), vi.Fourier(forces, w, p), STOPS)
    same(*(vi.simulate(scene, REST, REST, (0, 60)) for scene in (base, force)), 1e-11)
    # One harmonic of an imaginary amplitude is the same a quarter of a turn later.
    turned = vi.Scene(system(influence), vi.BaseMotion([0.1j], w, p - np.pi / 2), STOPS)
    straight = vi.Scene(system(influence), vi.BaseMotion(0.1, w, p), STOPS)
    same(*(vi.simulate(scene, REST, REST, (0, 60)) for scene in (turned, straight)), 1e-11)


@pytest.mark.parametrize("method", ["taylor", "dop853", "radau"])
def test_pendulums_take_several_harmonics_of_a_base_and_forces(method):
    pendulum = vi.DoublePendulum(0.6, 1.4, damping=(0.05, 0.02))
    forcing = [vi.BaseMotion([0.05, 0.02j], 0.8, 0.2), vi.Fourier([[0.1, 0.0], [0.0, 0.05j]], 1.6, mean=[0.02, 0.0])]
    scene = vi.Scene(pendulum, forcing, vi.Wall(1, 0.15, 0.7))
    # The reference writes the equations of motion out.
    m, mu, w = 0.6, 1.4, 0.8
    alpha, gravity = m / (1 + m) / mu, 1 / (1 + m)

    def acceleration(t, q, v):
        u = np.exp(1j * (w * t + 0.2))
        push = (0.05 * w**2 * u + 0.02j * (2 * w) ** 2 * u**2).real
        e = np.exp(1j * 1.6 * t)
        force = np.array([0.02 + 0.1 * e.real, (0.05j * e**2).real])
        s = np.sin(q[0] - q[1])
        mass = np.array([[1.0, alpha * np.cos(q[0] - q[1])], [alpha * np.cos(q[0] - q[1]), alpha / mu]])
        right = np.array(
            [-gravity * np.sin(q[0]) - alpha * s * v[1] ** 2, alpha * s * v[0] ** 2 - alpha * gravity * np.sin(q[1])]
        )
        damping = np.array([[0.07, -0.02], [-0.02, 0.02]])
        levers = np.array([np.cos(q[0]), alpha * np.cos(q[1])])
        return np.linalg.solve(mass, right - damping @ v + push * levers + force)

    def mass(q):
        c = alpha * np.cos(q[0] - q[1])
        return np.array([[1.0, c], [c, alpha / mu]])

    def gap(q):
        return 0.15 - np.sin(q[0]) - np.sin(q[1]) / mu

    def gradient(q):
        return np.array([-np.cos(q[0]), -np.cos(q[1]) / mu])

    written = vi.Scene(vi.NonlinearSystem(2, acceleration, mass=mass), None, vi.NonlinearStop(gap, gradient, 0.7))
    tight = {"rtol": 1e-11, "atol": 1e-13}
    run = vi.simulate(scene, REST, REST, (0, 25), method=method, **tight)
    reference = vi.simulate(written, REST, REST, (0, 25), method="dop853", **tight)
    same(run, reference, 2e-7, least=3)


def test_two_frequencies_without_a_period_are_a_coordinate_that_swings_undamped():
    a, b, w, other = np.array([1.0, 0.2]), np.array([0.3, 0.9]), 1.1, 1.1 * np.sqrt(2)
    scene = vi.Scene(system(), [vi.Harmonic(a, w, 0.3), vi.Harmonic(b, other, -0.5)], STOPS)
    assert scene.period is None
    run = vi.simulate(scene, REST, REST, (0, 80))
    assert np.isnan(run.impacts["phase"]).all()
    # z'' + other^2 z = 0 pushes by a column of the stiffness.
    mass = np.block([[MASS, np.zeros((2, 1))], [np.zeros((1, 2)), np.ones((1, 1))]])
    damping = np.block([[DAMPING, np.zeros((2, 1))], [np.zeros((1, 3))]])
    stiffness = np.block([[STIFFNESS, -b[:, None]], [np.zeros((1, 2)), np.full((1, 1), other**2)]])
    stops = [
        vi.Stop(0, 0.12, 0.8),
        vi.Stop([0.3, 1.0, 0.0], 0.2, 0.6, side="lower", reaction=[*np.linalg.solve(MASS, [0.3, 1.0]), 0.0]),
    ]
    pushed = vi.Scene(vi.LinearSystem(mass, damping, stiffness), vi.Harmonic([*a, 0.0], w, 0.3), stops)
    start = [0, 0, np.cos(-0.5)], [0, 0, -other * np.sin(-0.5)]
    reference = vi.simulate(pushed, *start, (0, 80))
    assert run.impacts.size == reference.impacts.size > 20
    np.testing.assert_allclose(run.impacts["time"], reference.impacts["time"], atol=1e-11)
    np.testing.assert_allclose(run.impacts["impulse"], reference.impacts["impulse"], atol=1e-11)
    for method in ("rk45", "radau"):
        same(run, vi.simulate(scene, REST, REST, (0, 80), method=method, rtol=1e-11, atol=1e-13), 1e-7)


def test_tones_keep_their_phases_late_and_from_any_start():
    forcing = [vi.Harmonic([1.0, 0.2], 1.0), vi.Harmonic([0.5, -0.1], np.sqrt(2.0))]
    scene = vi.Scene(system(), forcing, STOPS)
    late = 2.0**26
    moved = scene.replace(phase=0.0)
    assert moved == scene
    # So much later in the same phases: by the angles at that time in twice the precision.
    turns = [
        np.remainder(late, 2 * np.pi),
        float(np.remainder(np.longdouble(late) * np.longdouble(np.sqrt(2.0)), 2 * np.longdouble(np.pi))),
    ]
    early = vi.Scene(
        system(), [vi.Harmonic(f.amplitude, f.frequency, turn) for f, turn in zip(forcing, turns, strict=True)], STOPS
    )
    one = vi.simulate(scene, REST, REST, (late, late + 20))
    other = vi.simulate(early, REST, REST, (0, 20))
    assert one.impacts.size == other.impacts.size > 3
    np.testing.assert_allclose(one.impacts["time"] - late, other.impacts["time"], atol=1e-7)


def test_what_has_no_period_says_so():
    forces = [vi.Harmonic([1.0, 0.2], w) for w in (1.0, 1.5, 2.0)]
    assert vi.Scene(system(), [forces[0], forces[2]], STOPS).period == 2 * np.pi
    scene = vi.Scene(system(), forces[:2], STOPS)
    reason = r"needs a period: its forcings have no common period: the frequency 1.5 is no whole multiple of the lowest, 1"
    with pytest.raises(ValueError, match="periodic_orbits " + reason):
        vi.periodic_orbits(scene, [0])
    with pytest.raises(ValueError, match="find_orbit " + reason):
        vi.find_orbit(scene, vi.simulate(scene, REST, REST, (0, 50)))
    with pytest.raises(ValueError, match=reason):
        vi.existence_map(scene, [0], x=("frequency", [1.0, 1.1]), y=("clearance", [0.1, 0.2]))
    assert "2 frequencies without a common period" in scene.plan()


def test_replacing_scales_all_frequencies_and_shifts_all_by_one_time():
    first, second = vi.Harmonic([1.0, 0.2], 3.0, 0.4), vi.BaseMotion([0.1, 0.02], 1.5, 0.1)
    scene = vi.Scene(system([1.0, 0.0]), [first, second], STOPS)
    assert scene.forcing == (first, second)
    faster = scene.replace(frequency=2.0)
    assert [f.frequency for f in faster.forcing] == [4.0, 2.0]
    assert faster.period == np.pi
    later = scene.replace(phase=1.0)
    assert [f.phase for f in later.forcing] == pytest.approx([1.0, 0.1 + 0.6 / 2])
    start = (np.array([0.05, 0.1]), np.array([0.2, -0.1]))
    moved = vi.simulate(scene, *start, (0.6 / 3, 40 + 0.6 / 3)).impacts["time"] - 0.6 / 3
    np.testing.assert_allclose(vi.simulate(later, *start, (0, 40)).impacts["time"], moved, atol=1e-10)
    with pytest.raises(ValueError, match="amplitude is given, but the scene has several forcings"):
        scene.replace(amplitude=1.0)
    assert scene.replace(forcing_scale=2.0).forcing[1].amplitude == pytest.approx([0.2, 0.04])


def test_orbits_of_several_forcings_have_a_scene_that_retraces_them():
    forcing = [vi.Harmonic([0.4, 0.1], 3.0, 0.4), vi.Harmonic([1.0, 0.5], 1.5, 0.1)]
    scene = vi.Scene(system(), forcing, STOPS)
    orbits = vi.periodic_orbits(scene, [0], n_periods=1)
    assert orbits
    for orbit in orbits:
        first, second = orbit.scene.forcing
        assert second.phase == orbit.phase
        assert first.phase == pytest.approx(0.4 + 2 * (orbit.phase - 0.1))
        q, v = orbit.q0, orbit.v0
        if orbit.is_admissible:
            run = vi.simulate(orbit.scene, q, v, (0, orbit.period))
            np.testing.assert_allclose(run.final[0], q, atol=1e-9)


def test_maps_of_forces_and_a_base_together_are_those_of_the_scenes_one_by_one():
    forcing = [vi.BaseMotion([0.2, 0.05j], 1.5, 0.1), vi.Harmonic([0.6, 0.3], 1.5, 0.4)]
    scene = vi.Scene(system([1.0, 0.5]), forcing, STOPS)
    frequencies, clearances = [1.2, 1.5, 2.2], [0.05, 0.2]
    map_ = vi.existence_map(scene, [0], x=("frequency", frequencies), y=("clearance", clearances))
    for j, frequency in enumerate(frequencies):
        for i, clearance in enumerate(clearances):
            cell = scene.replace(frequency=frequency, clearance=clearance)
            orbits = vi.periodic_orbits(cell, [0])
            assert map_.n_orbits[i, j] == len(orbits)


def test_scenes_of_several_forcings_pickle_and_show_themselves():
    scene = vi.Scene(system([1.0, 0.0]), (vi.BaseMotion([0.1, 0.2j], 1.0), vi.Harmonic([1.0, 0.0], 2.0)), STOPS)
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert "BaseMotion(" in repr(scene)
    assert "Harmonic(" in repr(scene)
    assert vi.Scene(system(), [], STOPS).period is None


@pytest.mark.parametrize(
    ("forcing", "error", "message"),
    [
        ([1.0], TypeError, r"forcing\[0\] is float"),
        ("abc", TypeError, "forcing is str"),
        ([vi.Harmonic([1.0], 1.0)], ValueError, r"forcing.amplitude has shape \(1,\)"),
        ([vi.BaseMotion(1.0, 1.0)], ValueError, "no influence vector"),
    ],
)
def test_forcings_that_do_not_fit_are_refused(forcing, error, message):
    with pytest.raises(error, match=message):
        vi.Scene(system(), forcing, STOPS)
