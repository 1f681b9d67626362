"""Periodic motions that hit stops which move: the same in the frame of the stops, and by a long simulation."""

import numpy as np
import pytest

import vibroimpact as vi

MASS = np.array([[2.0, 0.3], [0.3, 1.0]])
DAMPING = np.array([[0.3, 0.03], [0.05, 0.25]])
STIFFNESS = np.array([[9.0, -2.0], [-2.0, 5.0]])
DIRECTION = np.array([0.7, -0.4])
FORCE = np.array([[1.4, 0.5 + 0.3j], [0.2j, -0.3], [0.1, 0.05j]])
MOVES = np.array([0.12, 0.03j, 0.01 - 0.01j])
W, PHASE = 1.7, 0.4


def pair(k, stops, damping=DAMPING):
    """A scene in which all stops move as a frame does, along a direction, and the same in that frame; K harmonics."""
    system = vi.LinearSystem(MASS, damping, STIFFNESS)
    orders = 1j * W * np.arange(1, k + 1)
    carried = [(STIFFNESS + s * np.asarray(damping) + s**2 * MASS) @ DIRECTION * u for s, u in zip(orders, MOVES, strict=False)]
    moving = []
    for stop in stops:
        normal = np.asarray(stop.normal, float) if np.ndim(stop.normal) else np.eye(2)[stop.normal]
        side = 1 if stop.side == "upper" else -1
        motion = vi.Fourier(side * (normal @ DIRECTION) * MOVES[:k], W, PHASE)
        moving.append(
            vi.Stop(stop.normal, stop.clearance, stop.restitution, side=stop.side, reaction=stop.reaction, motion=motion)
        )
    return (
        vi.Scene(system, vi.Fourier(FORCE[:k], W, PHASE), moving),
        vi.Scene(system, vi.Fourier(FORCE[:k] - np.array(carried), W, PHASE), stops),
    )


STOPS = [vi.Stop(0, 0.3, 0.8), vi.Stop([0.3, 1.0], 1.2, 0.6, side="lower", reaction=[0.5, 1.0])]


def shifted(orbit, t):
    """What the frame has moved."""
    k = orbit.scene.forcing.amplitudes.shape[0]
    u = np.exp(1j * (W * t + orbit.phase) * np.arange(1, k + 1))
    return DIRECTION * (MOVES[:k] * u).sum().real


def same(one, other):
    assert one.phase == pytest.approx(other.phase, abs=1e-9)
    np.testing.assert_allclose(one.impacts["impulse"], other.impacts["impulse"], rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(one.impacts["speed_before"], other.impacts["speed_before"], rtol=1e-9, atol=1e-11)
    for t in (0.1, 1.7):
        np.testing.assert_allclose(one.position(t) - shifted(one, t), other.position(t), rtol=0, atol=1e-10)
    assert one.is_admissible == other.is_admissible
    if other.floquet_multipliers is not None and other.is_admissible:
        order = np.argsort(np.abs(other.floquet_multipliers))
        mine = one.floquet_multipliers[np.argsort(np.abs(one.floquet_multipliers))]
        np.testing.assert_allclose(np.abs(mine), np.abs(other.floquet_multipliers[order]), rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize("k", [1, 2, 3])
@pytest.mark.parametrize("n_periods", [1, 2])
def test_orbits_of_one_stop_are_those_in_its_frame(k, n_periods):
    moving, frame = pair(k, STOPS)
    for stop in (0, 1):
        found, wanted = (vi.periodic_orbits(scene, [stop], n_periods=n_periods) for scene in (moving, frame))
        assert len(found) == len(wanted)
        for one, other in zip(found, wanted, strict=True):
            same(one, other)
    assert any(orbit.is_admissible for orbit in vi.periodic_orbits(moving, [0], n_periods=1))


def test_orbits_retrace_themselves_and_close_under_steps():
    moving, _ = pair(3, STOPS[:1])
    orbits = [orbit for orbit in vi.periodic_orbits(moving, [0]) if orbit.is_admissible]
    assert orbits
    for orbit in orbits:
        t = 0.37 * orbit.period
        run = vi.simulate(
            orbit.scene, orbit.position(t), orbit.velocity(t), (t, t + orbit.period), method="dop853", rtol=1e-12, atol=1e-14
        )
        np.testing.assert_allclose(run.final, [orbit.position(t), orbit.velocity(t)], rtol=0, atol=1e-9)
        assert np.abs(orbit.energy.balance).max() < 1e-10


@pytest.mark.parametrize("k", [1, 2])
def test_the_phase_given_leaves_the_clearances(k):
    moving, frame = pair(k, STOPS[:1])
    for phase in (0.3, 2.0):
        one, other = (vi.periodic_orbits(scene, [0], phase=phase)[0] for scene in (moving, frame))
        assert one.scene.stops[0].clearance == pytest.approx(other.scene.stops[0].clearance, abs=1e-11)
        np.testing.assert_allclose(one.impacts["impulse"], other.impacts["impulse"], rtol=1e-9)


def test_stops_hit_together_with_their_clearances_scaled():
    moving, frame = pair(1, STOPS)
    found, wanted = (vi.periodic_orbits(scene, [(0, 1)], free="clearance") for scene in (moving, frame))
    assert len(found) == len(wanted) > 0
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_allclose([s.clearance for s in one.scene.stops], [s.clearance for s in other.scene.stops], rtol=1e-9)


def test_maps_are_those_in_the_frame():
    moving, frame = pair(2, STOPS[:1])
    axes = {"x": ("clearance", np.linspace(-0.2, 0.5, 8)), "y": ("restitution", [0.3, 0.6, 0.9])}
    one, other = (vi.existence_map(scene, [0], **axes) for scene in (moving, frame))
    np.testing.assert_array_equal(one.n_orbits, other.n_orbits)
    np.testing.assert_array_equal(one.is_admissible, other.is_admissible)
    np.testing.assert_array_equal(one.is_stable, other.is_stable)
    assert one.is_admissible.any()
    # Cell by cell where the frequency moves: the stop keeps its displacement.
    frequencies = [1.2, 1.7, 2.4]
    swept = vi.existence_map(moving, [0], x=("frequency", frequencies), y=("clearance", [0.1, 0.3]))
    for i, clearance in enumerate((0.1, 0.3)):
        for j, frequency in enumerate(frequencies):
            cell = moving.replace(frequency=frequency, clearance=clearance)
            assert swept.n_orbits[i, j] == len(vi.periodic_orbits(cell, [0]))


def test_a_ball_on_a_table_has_the_orbit_of_the_closed_form():
    """Once a period: the impact is where the speed of the table is (1 - e)/(1 + e) g T/2 (Holmes 1982)."""
    amplitude, w, g, e = 0.03, 25.0, 9.81, 0.8
    table = vi.Stop(0, 0.0, e, side="lower", motion=vi.Harmonic([-amplitude], w))
    scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0, load=[-g]), None, table)
    found = [orbit for orbit in vi.periodic_orbits(scene, [0]) if orbit.is_admissible]
    assert found
    period = 2 * np.pi / w
    speed = (1 - e) / (1 + e) * g * period / 2
    for orbit in found:
        assert -amplitude * w * np.sin(orbit.phase) == pytest.approx(speed, rel=1e-9)
        assert orbit.impacts["speed_before"][0] == pytest.approx(g * period / (1 + e), rel=1e-9)
        np.testing.assert_allclose(np.prod(orbit.floquet_multipliers), e**2, rtol=1e-9)


@pytest.mark.parametrize("k", [1, 3])
def test_shooting_finds_the_orbits_and_their_multipliers(k):
    moving, _ = pair(k, STOPS[:1])
    orbit = next(o for o in vi.periodic_orbits(moving, [0]) if o.is_admissible)
    near = moving.replace(restitution=0.75)
    found = vi.find_orbit(near, orbit)
    wanted = min(vi.periodic_orbits(near, [0]), key=lambda o: abs(o.phase - found.phase))
    assert found.phase == pytest.approx(wanted.phase, abs=1e-9)
    a, b = (np.sort(np.abs(o.floquet_multipliers)) for o in (found, wanted))
    np.testing.assert_allclose(a, b, rtol=1e-7, atol=1e-9)
    # The same integrated: the gap given as a function.
    stop = moving.stops[0]
    given = vi.NonlinearStop(lambda q: stop.clearance - q[0], lambda q: np.array([-1.0, 0.0]), 0.75, motion=stop.motion)
    stepped = vi.find_orbit(near.replace(stops=given), found)
    assert stepped.phase == pytest.approx(found.phase, abs=1e-8)
    np.testing.assert_allclose(np.sort(np.abs(stepped.floquet_multipliers)), a, rtol=1e-5, atol=1e-7)
    assert stepped.is_admissible


def test_multipliers_are_the_derivative_of_the_map():
    moving, _ = pair(3, STOPS[:1])
    orbit = next(o for o in vi.periodic_orbits(moving, [0]) if o.is_admissible)
    t = 0.4 * orbit.period
    x = np.concatenate([orbit.position(t), orbit.velocity(t)])

    def image(x):
        run = vi.simulate(orbit.scene, x[:2], x[2:], (t, t + orbit.period), keep="final")
        return np.concatenate(run.final)

    step = 1e-6
    jacobian = np.array([(image(x + step * e) - image(x - step * e)) / (2 * step) for e in np.eye(4)]).T
    np.testing.assert_allclose(
        np.sort(np.abs(np.linalg.eigvals(jacobian))), np.sort(np.abs(orbit.floquet_multipliers)), rtol=1e-5, atol=1e-7
    )


def test_lasting_contact_and_chatter_on_a_table_close():
    """A ball that settles on a table which throws it once in each period."""
    amplitude, w, g = 0.03, 20.0, 9.81
    table = vi.Stop(0, 0.0, 0.3, side="lower", motion=vi.Harmonic([-amplitude], w))
    scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0, load=[-g]), None, table)
    frame = vi.Scene(scene.system, vi.Harmonic([amplitude * w**2], w), vi.Stop(0, 0.0, 0.3, side="lower"))
    runs = [vi.simulate(s, [0.1], [0.0], (0, 60 * scene.period)) for s in (scene, frame)]
    one, other = (vi.find_orbit(s, run) for s, run in zip((scene, frame), runs, strict=True))
    assert one.n_periods == other.n_periods
    assert {"chatter", "stick"} <= set(one.segments["kind"])
    # The last impacts before the rest are small differences of the motion: as far as that is known, no further.
    np.testing.assert_allclose(one.impacts["impulse"], other.impacts["impulse"], rtol=1e-6, atol=1e-9)
    assert one.is_admissible == other.is_admissible


def test_two_instants_take_stops_that_rest():
    moving, _ = pair(1, STOPS)
    with pytest.raises(ValueError, match="of two instants takes stops that rest"):
        vi.periodic_orbits(moving, [0, 1])
