"""Stops that move by themselves: the same motion in the frame of the stop, chatter, lasting contact, energy."""

import pickle

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline, PPoly

import vibroimpact as vi

STEPS = ["dop853", "radau", "rk45"]
TIGHT = {"rtol": 1e-11, "atol": 1e-13}
MASS = np.array([[2.0, 0.3], [0.3, 1.0]])
DAMPING = np.array([[0.2, 0.03], [0.05, 0.15]])
STIFFNESS = np.array([[9.0, -2.0], [-2.0, 5.0]])
REST = np.zeros(2)


def bump(height, start, span):
    """``height`` times 16 s^2 (1 - s)^2, s from 0 to 1 over the span: at rest at both ends."""
    c = 16 * height * np.array([1.0, -2.0, 1.0, 0.0, 0.0]) / span ** np.arange(4, -1, -1)
    return PPoly(c[:, None], [start, start + span])


def same(one, other, count, tolerance, shift=lambda t: 0.0):
    """The same impacts, and the same positions but for what the stop has moved."""
    assert min(one.impacts.size, other.impacts.size) >= count
    np.testing.assert_array_equal(one.impacts["stop"][:count], other.impacts["stop"][:count])
    for name in ("time", "impulse", "speed_before", "speed_after"):
        np.testing.assert_allclose(one.impacts[name][:count], other.impacts[name][:count], rtol=0, atol=tolerance)
    t = one.impacts["time"][count - 1] * 0.999
    np.testing.assert_allclose(one.position([t])[0, 0] - shift(t), other.position([t])[0, 0], rtol=0, atol=10 * tolerance)


def table(amplitude, w, phase, gravity=9.81, restitution=0.8):
    """A ball above a table at height A cos(w t + phase), and the same in the frame of the table."""
    moving = vi.Scene(
        vi.LinearSystem(1.0, 0.0, 0.0, load=[-gravity]),
        None,
        vi.Stop(0, 0.0, restitution, side="lower", motion=vi.Harmonic([-amplitude], w, phase)),
    )
    frame = vi.Scene(
        vi.LinearSystem(1.0, 0.0, 0.0, load=[-gravity]),
        vi.Harmonic([amplitude * w**2], w, phase),
        vi.Stop(0, 0.0, restitution, side="lower"),
    )
    return moving, frame


@pytest.mark.parametrize("method", ["exact", *STEPS])
def test_a_ball_on_a_table_is_that_ball_in_the_frame_of_the_table(method):
    amplitude, w, phase = 0.03, 22.0, 0.7
    moving, frame = table(amplitude, w, phase, restitution=0.6)
    assert moving.period == frame.period == 2 * np.pi / w
    start = [0.15], [0.3]
    height, speed = amplitude * np.cos(phase), -amplitude * w * np.sin(phase)
    options = {"method": method} | ({} if method == "exact" else TIGHT)
    run = vi.simulate(moving, *start, (0, 12), **options)
    reference = vi.simulate(frame, [0.15 - height], [0.3 - speed], (0, 12), method="exact")
    same(run, reference, 20, 1e-11 if method == "exact" else 1e-7, lambda t: amplitude * np.cos(w * t + phase))
    np.testing.assert_allclose(
        run.impacts["phase"][:20], reference.impacts["phase"][:20], atol=1e-8 if method == "exact" else 1e-5
    )


@pytest.mark.parametrize("method", ["exact", *STEPS])
def test_a_gear_pair_in_the_frame_of_the_driving_wheel(method):
    """Backlash: the driven wheel between two flanks that turn with the driving one, by three harmonics."""
    amplitudes, w, c, backlash = np.array([0.02, 0.006j, 0.003]), 30.0, 0.8, 0.01
    drive = vi.Fourier(amplitudes, w, 0.3)
    k = 1j * w * np.arange(1, 4)
    driven = vi.LinearSystem(1.0, c, 0.0, load=[0.2])
    flanks = [
        vi.Stop(0, backlash, 0.7, motion=drive),
        vi.Stop(0, backlash, 0.7, side="lower", motion=vi.Fourier(-amplitudes, w, 0.3)),
    ]
    at_rest = [vi.Stop(0, backlash, 0.7), vi.Stop(0, backlash, 0.7, side="lower")]
    moving = vi.Scene(driven, None, flanks)
    frame = vi.Scene(driven, vi.Fourier(-(k**2 + c * k) * amplitudes, w, 0.3), at_rest)
    u = np.exp(1j * 0.3 * np.arange(1, 4))
    angle, speed = (amplitudes * u).sum().real, (k * amplitudes * u).sum().real
    options = {"method": method} | ({} if method == "exact" else TIGHT)
    run = vi.simulate(moving, [angle], [speed + 0.1], (0, 3), **options)
    reference = vi.simulate(frame, [0.0], [0.1], (0, 3), method="exact")
    same(run, reference, 20, 1e-11 if method == "exact" else 1e-7, lambda t: (amplitudes * np.exp(k * t) * u).sum().real)


def test_a_free_mass_in_a_shaken_box():
    amplitude, w, half = 0.02, 12.0, 0.05
    box = [
        vi.Stop(0, half, 0.9, motion=vi.Harmonic([amplitude], w)),
        vi.Stop(0, half, 0.9, side="lower", motion=vi.Harmonic([-amplitude], w)),
    ]
    free = vi.LinearSystem(1.0, 0.0, 0.0)
    run = vi.simulate(vi.Scene(free, None, box), [0.0], [0.4], (0, 8))
    fixed = [vi.Stop(0, half, 0.9), vi.Stop(0, half, 0.9, side="lower")]
    frame = vi.Scene(free, vi.Harmonic([amplitude * w**2], w), fixed)
    reference = vi.simulate(frame, [-amplitude], [0.4], (0, 8))
    same(run, reference, 20, 1e-11, lambda t: amplitude * np.cos(w * t))


def test_a_structure_in_a_frame_that_shakes_as_a_base_does():
    """All stops move as a base would: relative to it the structure sees base motion and damping and springs to the ground."""
    influence, amplitude, w = np.array([1.0, 1.0]), 0.4, 2.3
    # Springs and dampers between the masses alone, so that they do not see the base.
    damping, stiffness = 0.1 * np.array([[1.0, -1.0], [-1.0, 1.0]]), 7.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    mass = np.diag([2.0, 1.0])
    move = vi.Harmonic([amplitude], w, 0.4)
    back = vi.Harmonic([-amplitude], w, 0.4)
    moving = vi.Scene(
        vi.LinearSystem(mass, damping, stiffness),
        None,
        [vi.Stop(0, 0.2, 0.8, motion=move), vi.Stop(1, 0.15, 0.7, side="lower", motion=back)],
    )
    base = vi.Scene(
        vi.LinearSystem(mass, damping, stiffness, influence=influence),
        vi.BaseMotion(amplitude, w, 0.4),
        [vi.Stop(0, 0.2, 0.8), vi.Stop(1, 0.15, 0.7, side="lower")],
    )
    u, du = amplitude * np.cos(0.4), -amplitude * w * np.sin(0.4)
    run = vi.simulate(moving, REST + u, REST + du, (0, 40))
    reference = vi.simulate(base, REST, REST, (0, 40))
    same(run, reference, 12, 1e-10, lambda t: amplitude * np.cos(w * t + 0.4))


@pytest.mark.parametrize("method", STEPS)
def test_coupled_stops_with_motions_of_their_own(method):
    """Different frequencies and signals: exact flights beside steps."""
    t = np.linspace(0, 25, 60)
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(t, 0.05 * np.sin(1.1 * t) * np.sin(0.3 * t), bc_type="clamped")
    stops = [
        vi.Stop(0, 0.2, 0.8, motion=vi.Harmonic([0.05], 3.1)),
        vi.Stop([0.3, 1.0], 0.25, 0.6, side="lower", motion=vi.Fourier([0.03, 0.01j], 2.2, mean=[0.01])),
        vi.Stop([1.0, -1.0], 0.4, 0.7, reaction=[1.0, -0.5], motion=spline),
    ]
    scene = vi.Scene(vi.LinearSystem(MASS, DAMPING, STIFFNESS), vi.Harmonic([1.5, 0.4], 2.2), stops)
    exact = vi.simulate(scene, REST, REST, (0, 25))
    steps = vi.simulate(scene, REST, REST, (0, 25), method=method, **TIGHT)
    one, other = (run.impacts[run.impacts["speed_before"] > 1e-4] for run in (exact, steps))
    count = min(one.size, other.size, 25)
    assert count > 15
    np.testing.assert_array_equal(one["stop"][:count], other["stop"][:count])
    np.testing.assert_allclose(one["time"][:count], other["time"][:count], rtol=0, atol=1e-6)
    assert set(exact.impacts["stop"]) == {0, 1, 2}


@pytest.mark.parametrize("method", ["exact", "dop853", "radau"])
def test_a_ball_rests_on_a_table_until_that_falls_faster(method):
    amplitude, w, g = 0.02, 25.0, 9.81  # A w^2 = 12.5 > g
    moving, _ = table(amplitude, w, np.pi, g)
    # At the lowest point of the table, at rest on it: height -A.
    run = vi.simulate(moving, [-amplitude], [0.0], (0, 2), method=method)
    assert run.segments["kind"][0] == "stick"
    # z'' = A w^2 cos(w t) = -g
    released = np.arccos(-g / (amplitude * w**2)) / w
    assert run.segments["end"][0] == pytest.approx(released, abs=1e-10 if method == "exact" else 1e-6)
    times = np.linspace(0, released, 20)
    np.testing.assert_allclose(
        run.position(times)[:, 0], -amplitude * np.cos(w * times), rtol=0, atol=1e-12 if method == "exact" else 1e-7
    )
    # It flies on as a stone: the next contact by the closed form.
    z, v = -amplitude * np.cos(w * released), amplitude * w * np.sin(w * released)
    hit = run.impacts["time"][0] - released
    table_then = -amplitude * np.cos(w * (hit + released))
    assert z + v * hit - g * hit**2 / 2 == pytest.approx(table_then, abs=1e-9)


@pytest.mark.parametrize("start", [0.0, -3.7, 1e3, 1e5])
@pytest.mark.parametrize("method", ["exact", *STEPS])
def test_what_rests_on_a_table_stays_while_a_signal_acts(method, start):
    # The table moves on by the rounding of the time between the breakpoints, and between a run and the one that goes on.
    amplitude, w = 0.02, 9.0
    t = start + np.linspace(0.0, 4.0, 81)
    push = vi.Load(0, (t, np.random.default_rng(3).uniform(-1.0, 1.0, t.size)))
    table = vi.Stop(0, 0.0, 0.7, side="lower", motion=vi.Harmonic([-amplitude], w, 0.4))
    scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0, load=[-9.81]), push, table)
    angle = w * start + 0.4
    at_rest = [amplitude * np.cos(angle)], [-amplitude * w * np.sin(angle)]
    first = vi.simulate(scene, *at_rest, (start, start + 2.13), method=method)
    later = vi.simulate(scene, *first.final, (first.t_end, start + 4.0), method=method)
    for run in (first, later):
        assert run.status == "finished", run.message
        assert run.impacts.size == 0, run.message
        assert set(run.segments["kind"]) == {"stick"}


@pytest.mark.parametrize("method", ["exact", "dop853"])
def test_a_ball_comes_to_rest_on_a_table_by_chatter(method):
    amplitude, w = 0.005, 20.0  # A w^2 = 2 < g
    moving, frame = table(amplitude, w, 0.0, restitution=0.5)
    run = vi.simulate(moving, [0.1], [0.0], (0, 3), method=method)
    reference = vi.simulate(frame, [0.1 - amplitude], [0.0], (0, 3), method="exact")
    for one in (run, reference):
        assert set(one.segments["kind"]) == {"flight", "chatter", "stick"}
    start = {kind: run.segments["start"][run.segments["kind"] == kind][0] for kind in ("chatter", "stick")}
    wanted = reference.segments["start"][reference.segments["kind"] == "stick"][0]
    assert start["stick"] == pytest.approx(wanted, abs=1e-7)
    times = np.linspace(start["stick"], 3, 30)
    np.testing.assert_allclose(run.position(times)[:, 0], amplitude * np.cos(w * times), rtol=0, atol=1e-9)
    np.testing.assert_allclose(run.velocity(times)[:, 0], -amplitude * w * np.sin(w * times), rtol=0, atol=1e-7)


@pytest.mark.parametrize("method", ["exact", "dop853"])
def test_two_stops_held_at_once_carry_what_they_hold(method):
    """Pressed into a corner of two tables that move differently."""
    one, two = vi.Harmonic([0.01], 3.0, 0.2), vi.Harmonic([0.02], 2.0, -0.4)
    system = vi.LinearSystem(MASS, DAMPING, STIFFNESS, load=[30.0, 20.0])
    scene = vi.Scene(system, None, [vi.Stop(0, 0.1, 0.0, motion=one), vi.Stop([0.2, 1.0], 0.15, 0.0, motion=two)])
    assert scene.period is None
    run = vi.simulate(scene, REST, REST, (0, 12), method=method)
    times = np.linspace(6, 12, 40)
    q = run.position(times)
    c = np.array([0.1 + 0.01 * np.cos(3 * times + 0.2), 0.15 + 0.02 * np.cos(2 * times - 0.4)])
    np.testing.assert_allclose([q[:, 0], 0.2 * q[:, 0] + q[:, 1]], c, rtol=0, atol=1e-10 if method == "exact" else 1e-7)
    np.testing.assert_allclose(
        [scene.gaps(q, t) for q, t in zip(q, times, strict=True)], 0.0, atol=1e-10 if method == "exact" else 1e-7
    )


@pytest.mark.parametrize("method", ["exact", "dop853"])
def test_a_table_that_is_lifted_once_throws_the_ball(method):
    """A signal: the lift is a polynomial, and in the frame of the table a force."""
    lift = bump(0.05, 0.5, 0.2)
    down = PPoly(-lift.c, lift.x)
    scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0, load=[-9.81]), None, vi.Stop(0, 0.0, 0.6, side="lower", motion=down))
    frame = vi.Scene(scene.system, vi.Load(0, PPoly(-lift.derivative(2).c, lift.x)), vi.Stop(0, 0.0, 0.6, side="lower"))
    run = vi.simulate(scene, [0.0], [0.0], (0, 2), method=method, **(TIGHT if method != "exact" else {}))
    reference = vi.simulate(frame, [0.0], [0.0], (0, 2), method="exact")
    assert run.segments["kind"][0] == "stick"
    assert run.segments["end"][0] == pytest.approx(reference.segments["end"][0], abs=1e-9)
    count = 8
    np.testing.assert_allclose(run.impacts["time"][:count], reference.impacts["time"][:count], rtol=0, atol=1e-8)


def test_a_wall_and_a_nonlinear_stop_move():
    pendulum = vi.DoublePendulum(0.6, 1.4, damping=(0.05, 0.02))
    moving = vi.Harmonic([0.03], 1.1, 0.2)
    wall = vi.Scene(pendulum, vi.BaseMotion(0.1, 1.1), vi.Wall(1, 0.15, 0.7, motion=moving))
    left = vi.Scene(
        pendulum, vi.BaseMotion(-0.1, 1.1), vi.Wall(1, -0.15, 0.7, side="left", motion=vi.Harmonic([-0.03], 1.1, 0.2))
    )

    def gap(q):
        return 0.15 - np.sin(q[0]) - np.sin(q[1]) / 1.4

    def gradient(q):
        return np.array([-np.cos(q[0]), -np.cos(q[1]) / 1.4])

    given = [
        vi.Scene(pendulum, vi.BaseMotion(0.1, 1.1), vi.NonlinearStop(gap, gradient, 0.7, curvature=k, motion=moving))
        for k in (None, 2.0)
    ]
    run = vi.simulate(wall, REST, REST, (0, 30), **TIGHT)
    assert run.impacts.size > 3
    assert "order 8" in wall.plan()
    for other in (left, *given):
        again = vi.simulate(other, REST, REST, (0, 30), **TIGHT)
        np.testing.assert_allclose(again.impacts["time"], run.impacts["time"], rtol=0, atol=1e-7)
    small = vi.simulate(wall.linearise(), REST, REST, (0, 5))
    assert small.scene.stops[0].motion == moving
    with pytest.raises(ValueError, match="stops and walls that rest"):
        vi.simulate(wall, REST, REST, (0, 1), method="taylor")


def test_steps_see_a_table_that_moves_while_nothing_else_does():
    """A mass at rest before a stop that comes and goes: no error of its own motion would tell."""
    free = vi.LinearSystem(1.0, 0.0, 0.0)
    stop = vi.Stop(0, 0.1, 1.0, motion=vi.Harmonic([0.1001], 50.0))
    for method in ("exact", *STEPS):
        run = vi.simulate(vi.Scene(free, None, stop), [0.0], [0.0], (0, 1), method=method)
        # The first time at which 0.1 + 0.1001 cos(50 t) = 0.
        assert run.impacts["time"][0] == pytest.approx(np.arccos(-0.1 / 0.1001) / 50, abs=1e-6)


@pytest.mark.parametrize("method", ["exact", "dop853"])
def test_the_ledger_counts_the_work_of_stops(method):
    moving, _ = table(0.02, 25.0, 1.0, restitution=0.6)
    run = vi.simulate(moving, [0.05], [0.0], (0, 3), method=method, **(TIGHT if method != "exact" else {}))
    energy = run.energy
    size = np.abs(energy.forcing_work).max() + np.abs(energy.impact_loss).max()
    assert np.abs(energy.balance).max() <= 1e-8 * size
    # What impacts take is that of the relative motion alone.
    impacts = run.impacts
    lost = 0.5 * (1 - 0.6**2) * (impacts["speed_before"] ** 2).sum()
    if "chatter" not in run.segments["kind"]:
        assert energy.impact_loss[-1] == pytest.approx(lost, rel=1e-9)
    assert set(run.segments["kind"]) >= {"flight"}


def test_a_stop_that_moves_by_nothing_is_one_that_rests_bit_for_bit():
    system = vi.LinearSystem(MASS, DAMPING, STIFFNESS)
    stops = [vi.Stop(0, 0.2, 0.8), vi.Stop([0.3, 1.0], 0.25, 0.6, side="lower")]
    still = [
        vi.Stop(0, 0.2, 0.8, motion=vi.Harmonic([0.0], 2.2)),
        vi.Stop([0.3, 1.0], 0.25, 0.6, side="lower", motion=vi.Fourier([0, 0j], 2.2)),
    ]
    for forcing in (vi.Harmonic([1.5, 0.4], 2.2), None):
        for method in ("exact", "dop853"):
            one, other = (
                vi.simulate(vi.Scene(system, forcing, s), REST, [0.3, 1.0], (0, 30), method=method) for s in (stops, still)
            )
            assert one.impacts.size > 1
            np.testing.assert_array_equal(one.impacts["time"], other.impacts["time"])
            np.testing.assert_array_equal(one.final, other.final)


def test_starts_are_judged_where_the_stop_stands_then():
    moving, _ = table(0.1, 10.0, 0.0)
    scene = moving
    assert scene.gaps([0.1]) == pytest.approx(0.0)
    assert scene.gaps([0.1], np.pi / 10) == pytest.approx(0.2)
    with pytest.raises(ValueError, match="inside stop 0"):
        vi.simulate(scene, [0.05], [0.0], (0, 1))
    assert vi.simulate(scene, [0.05], [0.0], (0.15, 1)).status == "finished"
    # On the table, and approached by it: an impact at once.
    run = vi.simulate(scene, [0.1 * np.cos(5.0)], [0.0], (0.5, 1))
    assert run.impacts["time"][0] == 0.5
    assert run.impacts["speed_before"][0] == pytest.approx(-0.1 * 10 * np.sin(5.0))


def test_replacing_moves_stops_with_the_forcing():
    stop = vi.Stop(0, 0.2, 0.8, motion=vi.Harmonic([0.05], 4.0, 0.3))
    scene = vi.Scene(vi.LinearSystem(1.0, 0.2, 9.0), vi.Harmonic([1.0], 2.0, 0.1), stop)
    assert scene.period == np.pi
    assert scene.replace(frequency=3.0).stops[0].motion.frequency == 6.0
    later = scene.replace(phase=0.5)
    assert later.forcing.phase == 0.5
    assert later.stops[0].motion.phase == pytest.approx(0.3 + 0.8)
    assert scene.replace(forcing_scale=2.0).stops == scene.stops
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert "motion=Harmonic" in repr(scene)


def test_runs_keep_and_pickle_their_motion():
    moving, _ = table(0.02, 25.0, 1.0, restitution=0.6)
    run = vi.simulate(moving, [0.05], [0.0], (0, 2))
    again = pickle.loads(pickle.dumps(run))
    times = np.linspace(0, 2, 101)
    np.testing.assert_array_equal(run.position(times), again.position(times))
    sampled = vi.simulate(moving, [0.05], [0.0], (0, 2), t_eval=times)
    np.testing.assert_allclose(sampled.q, run.position(times), rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    ("motion", "error", "message"),
    [
        (([0.0, 1.0], [0.0, 1.0]), None, None),
        (([0.0, 1.0, 2.0], [0.0, 1.0, 0.0]), ValueError, "not smooth at t = 1"),
        (vi.Harmonic([0.1, 0.2], 1.0), ValueError, "one number: a stop moves along its normal"),
        (vi.Fourier([[0.1, 0.2]], 1.0), ValueError, "one number"),
        (0.3, TypeError, "motion is float"),
    ],
)
def test_what_is_no_motion_of_a_stop_is_refused(motion, error, message):
    if error is None:
        # One straight line is smooth, but does not begin or end at rest: runs must stay within it.
        scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), None, vi.Stop(0, 1.0, 0.5, motion=motion))
        assert vi.simulate(scene, [0.0], [0.1], (0, 1)).status == "finished"
        for span in ((0, 1.5), (-0.5, 0.5)):
            with pytest.raises(ValueError, match=r"the motion of stops\[0\] is known on \[0, 1\] alone"):
                vi.simulate(scene, [0.0], [0.1], span)
        return
    with pytest.raises(error, match=message):
        vi.Stop(0, 1.0, 0.5, motion=motion)


def test_where_the_motion_of_a_stop_ends_its_gap_does_not_jump():
    closing = CubicHermiteSpline([0.0, 1.0, 3.0, 6.0], [0.0, 0.0, -3e-3, -3e-3], np.zeros(4))
    stop = vi.Stop(0, 4e-3, 0.6, motion=closing)
    scene = vi.Scene(vi.LinearSystem(0.5, 1.0, 450.0), vi.Harmonic([0.8], 28.0), stop)
    run = vi.simulate(scene, 0.0, 0.0, (0.0, 6.0))
    near, end = run.gap(0, [6.0 - 1e-9, 6.0])
    assert abs(end - near) < 1e-9
    assert abs(end - (1e-3 - run.position(6.0)[0])) < 1e-15
