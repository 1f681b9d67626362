"""Numbers of a scene that drift along a run: swept sines, levels, slowly moving stops."""

import pickle

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import PPoly

import vibroimpact as vi

MASS = np.array([[2.0, 0.3], [0.3, 1.0]])
DAMPING = np.array([[0.2, 0.03], [0.05, 0.15]])
STIFFNESS = np.array([[9.0, -2.0], [-2.0, 5.0]])
INFLUENCE = np.array([1.0, 0.6])
STOPS = [vi.Stop(0, 0.2, 0.8), vi.Stop([0.3, 1.0], 0.25, 0.6, side="lower")]
REST = np.zeros(2)
STEPS = ["rk45", "dop853", "radau"]
TIGHT = {"rtol": 1e-11, "atol": 1e-13}
MEAN = np.array([0.1, 0.0])
UP = vi.Ramp("frequency", 3.0, rate=0.05)
FORCE = vi.Harmonic([0.8 + 0.2j, -0.5j], 1.2, 0.4)


def system(influence=None):
    return vi.LinearSystem(MASS, DAMPING, STIFFNESS, influence=influence)


def integrated(force, end, stops, count):
    """The first impacts, by SciPy, under a force f(t)."""
    inverse = np.linalg.inv(MASS)
    normals = np.array([[1.0, 0.0], [-0.3, -1.0]])
    clearances, restitutions = [stop.clearance for stop in stops], [stop.restitution for stop in stops]

    def rate(t, x):
        return np.concatenate([x[2:], inverse @ (force(t) - STIFFNESS @ x[:2] - DAMPING @ x[2:])])

    def gap(i):
        def value(t, x):
            return clearances[i] - normals[i] @ x[:2]

        value.terminal, value.direction = True, -1
        return value

    t, x, impacts = 0.0, np.zeros(4), []
    while t < end and len(impacts) < count:
        run = solve_ivp(rate, (t, end), x, "DOP853", rtol=1e-12, atol=1e-14, events=[gap(0), gap(1)], max_step=0.05)
        t, x = run.t[-1], run.y[:, -1].copy()
        if run.status == 1:
            i = int(len(run.t_events[1]) > 0)
            b = inverse @ normals[i]
            p = (1 + restitutions[i]) * (normals[i] @ x[2:]) / (normals[i] @ b)
            x[2:] -= b * p
            impacts.append((t, i, p))
    return impacts


def sine(w0, rate, to, phase):
    """Angle and frequency of a linear sweep."""
    end = (to - w0) / rate

    def angle(t):
        s = np.minimum(t, end)
        return w0 * s + rate * s**2 / 2 + np.maximum(t - end, 0.0) * to + phase

    return angle, end


def same_impacts(run, expected, tolerance):
    assert len(run.impacts) >= len(expected)
    for impact, (t, stop, impulse) in zip(run.impacts, expected, strict=False):
        assert impact["stop"] == stop
        assert abs(impact["time"] - t) < tolerance
        assert abs(impact["impulse"] - impulse) < tolerance


@pytest.mark.parametrize("law", ["linear", "log"])
def test_a_chirp_without_stops_to_the_last_digits(law):
    w, eta, w0, rate, phase = 2.0, 0.05, 0.5, 0.04, 0.3
    times = [7.0, 31.0, 60.0]
    scene = vi.Scene(vi.LinearSystem(1.0, 2 * eta, w**2), vi.Harmonic([1.0], w0, phase))
    run = vi.simulate(scene, 0.0, 0.0, (0, 60), ramp=vi.Ramp("frequency", 50.0, rate=rate, law=law))

    def angle(s):
        if law == "linear":
            return mpmath.mpf(w0) * s + mpmath.mpf(rate) * s**2 / 2
        return mpmath.mpf(w0) * mpmath.expm1(mpmath.mpf(rate) * s) / mpmath.mpf(rate)

    def answered(since, t):
        turning = mpmath.sqrt(mpmath.mpf(w) ** 2 - mpmath.mpf(eta) ** 2)
        decayed = mpmath.exp(-mpmath.mpf(eta) * since) * mpmath.sin(turning * since) / turning
        return decayed * mpmath.cos(angle(t - since) + phase)

    with mpmath.workdps(30):
        exact = [float(mpmath.quad(lambda since, t=t: answered(since, t), mpmath.linspace(0, t, 61))) for t in times]
    np.testing.assert_allclose(run.position(times)[:, 0], exact, rtol=0, atol=6e-14)


def test_a_phase_after_thousands_of_turns():
    scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], 30.0, 0.3))
    run = vi.simulate(scene, 0.0, 0.0, (0, 300.0), ramp=vi.Ramp("frequency", 60.0, rate=0.1), keep="final")
    for t in (10.0, 123.456, 300.0):
        with mpmath.workdps(40):
            exact = (30 * mpmath.mpf(t) + mpmath.mpf(0.1) * mpmath.mpf(t) ** 2 / 2 + mpmath.mpf(0.3)) % (2 * mpmath.pi)
        assert abs(run.phase(t) - float(exact)) < 8e-15


@pytest.mark.parametrize("method", ["auto", "taylor", *STEPS])
def test_a_swept_force_with_two_stops(method):
    angle, _ = sine(1.2, 0.05, 3.0, 0.4)
    amplitude = FORCE.amplitude
    expected = integrated(lambda t: (amplitude * np.exp(1j * angle(t))).real, 50.0, STOPS, 20)
    options = TIGHT if method in STEPS else {}
    run = vi.simulate(vi.Scene(system(), FORCE, STOPS), REST, REST, (0, 60), method=method, ramp=UP, **options)
    same_impacts(run, expected, 1e-10 if method not in STEPS else 1e-8)
    t = run.impacts["time"]
    np.testing.assert_allclose(np.cos(run.impacts["phase"]), np.cos(angle(t)), atol=1e-12)
    np.testing.assert_allclose(run.parameter(t, "frequency"), np.minimum(1.2 + 0.05 * t, 3.0), rtol=1e-14)
    energy = run.energy
    assert np.abs(energy.balance).max() < (1e-11 if method not in STEPS else 1e-8) * energy.kinetic.max()


def test_harmonics_a_base_and_a_scale_that_grows():
    base = vi.BaseMotion([0.3, 0.1j], 1.1, 0.2)
    force = vi.Fourier([[0.2, 0.1], [0.0, 0.3j]], 2.2, 0.5, mean=MEAN)
    ramps = [vi.Ramp("frequency", 2.0, rate=0.03), vi.Ramp("forcing_scale", 2.0, over=20.0)]
    run = vi.simulate(vi.Scene(system(INFLUENCE), [base, force], STOPS), REST, REST, (0, 40), ramp=ramps)
    angle, _ = sine(1.1, 0.03, 2.0, 0.2)
    rate = 0.03

    def scale(t):
        return (1 + t / 20, 1 / 20) if t < 20 else (2.0, 0.0)

    def acting(t):
        s, s1 = scale(t)
        w, w1 = (1.1 + rate * t, rate) if t < 30 else (2.0, 0.0)
        theta = angle(t)
        bent = [
            (2j * k * w * s1 + s * (1j * k * w1 - (k * w) ** 2)) * u * np.exp(1j * k * theta) for k, u in ((1, 0.3), (2, 0.1j))
        ]
        own = 2 * (theta - 0.2) + 0.5
        harmonics = np.array([0.2, 0.1]) * np.exp(1j * own) + np.array([0.0, 0.3j]) * np.exp(2j * own)
        return -MASS @ INFLUENCE * np.sum(bent).real + s * (harmonics.real + MEAN)

    same_impacts(run, integrated(acting, 40.0, STOPS, 20), 1e-9)


@pytest.mark.parametrize("method", ["auto", "dop853"])
def test_a_pendulum_on_a_base_that_is_swept(method):
    pendulum = vi.DoublePendulum(0.6, 0.9, [0.02, 0.03])
    scene = vi.Scene(pendulum, vi.BaseMotion(0.1, 0.9, 0.0), vi.Wall(1, 0.15, 0.7))
    run = vi.simulate(
        scene, REST, REST, (0, 60), method=method, rtol=1e-11, atol=1e-13, ramp=vi.Ramp("frequency", 1.4, rate=0.01)
    )
    # The same base by its acceleration, written out.
    w = lambda t: 0.9 + 0.01 * t  # noqa: E731
    theta = lambda t: 0.9 * t + 0.005 * t**2  # noqa: E731
    base = vi.Signal.from_function(lambda t: 0.1 * (-(w(t) ** 2) * np.cos(theta(t)) - 0.01 * np.sin(theta(t))), (0, 50))
    other = vi.simulate(scene.replace(forcing=vi.BaseAcceleration(base)), REST, REST, (0, 50), rtol=1e-11, atol=1e-13)
    count = min(10, other.impacts.size)
    assert count >= 5
    np.testing.assert_allclose(run.impacts["time"][:count], other.impacts["time"][:count], atol=1e-7)


def test_levels_are_the_runs_at_each_one_after_another():
    scene = vi.Scene(system(), [FORCE, vi.Harmonic([0.2, 0.1], 2.4, 1.0)], STOPS)
    ramp = vi.Ramp("frequency", 2.0, levels=5, dwell=3.5)
    run = vi.simulate(scene, REST, REST, (0, 100), ramp=ramp)
    t, state, phase, impacts = 0.0, (REST, REST), 0.4, []
    for k, w in enumerate(np.linspace(1.2, 2.0, 5)):
        end = 100.0 if k == 4 else t + 3.5 * 2 * np.pi / w
        # The angle goes on: so does that of the second, at twice the frequency.
        here = vi.Scene(
            system(),
            [vi.Harmonic(FORCE.amplitude, w, phase - w * t), vi.Harmonic([0.2, 0.1], 2 * w, 2 * (phase - w * t) + 0.2)],
            STOPS,
        )
        level = vi.simulate(here, *state, (t, end))
        impacts.append(level.impacts)
        np.testing.assert_allclose(run.position([0.5 * (t + end)]), level.position([0.5 * (t + end)]), atol=1e-11)
        assert run.parameter(0.5 * (t + end)) == pytest.approx(w, rel=1e-15)
        state, phase, t = level.final, phase + 3.5 * 2 * np.pi, end
    impacts = np.concatenate(impacts)
    assert impacts.size == run.impacts.size > 30
    for name in ("time", "impulse"):
        np.testing.assert_allclose(run.impacts[name], impacts[name], atol=1e-9)
    assert np.abs(run.energy.balance).max() < 1e-10


def test_a_ramp_of_no_change_is_the_run_without_one():
    scene = vi.Scene(system(), FORCE, STOPS)
    plain = vi.simulate(scene, REST, REST, (0, 40))
    for ramp in (
        vi.Ramp("frequency", 1.2, over=10.0),
        vi.Ramp("frequency", 1.2, levels=4, dwell=3),
        [vi.Ramp("restitution[0]", 0.8, over=3.0), vi.Ramp("clearance[1]", 0.25, rate=1.0)],
    ):
        run = vi.simulate(scene, REST, REST, (0, 40), ramp=ramp)
        np.testing.assert_array_equal(run.impacts, plain.impacts)
        np.testing.assert_array_equal(run.q, plain.q)


@pytest.mark.parametrize("method", ["auto", *STEPS])
def test_a_clearance_that_drifts_is_a_slowly_moving_stop(method):
    options = TIGHT if method in STEPS else {}
    scene = vi.Scene(system(), FORCE, STOPS)
    ramp = vi.Ramp("clearance[0]", 0.05, over=30.0)
    run = vi.simulate(scene, REST, REST, (0, 30), method=method, ramp=ramp, **options)
    closing = vi.Stop(0, 0.2, 0.8, motion=PPoly([[-0.005], [0.0]], [0.0, 30.0]))
    other = vi.simulate(scene.replace(stops=[closing, STOPS[1]]), REST, REST, (0, 30), **options)
    assert other.impacts.size == run.impacts.size > 10
    for name in ("time", "impulse", "speed_before"):
        np.testing.assert_allclose(run.impacts[name], other.impacts[name], atol=1e-11 if method == "auto" else 1e-7)


@pytest.mark.parametrize("method", ["auto", "exact", *STEPS])
def test_the_restitution_is_that_of_the_instant(method):
    ball = vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0, load=[-9.81]), None, vi.Stop(0, 0.0, 0.9, side="lower"))
    run = vi.simulate(ball, 1.0, 0.0, (0, 3), method=method, ramp=vi.Ramp("restitution", 0.5, over=4.0))
    impacts = run.impacts
    expected = 0.9 - 0.1 * impacts["time"]
    np.testing.assert_allclose(impacts["speed_after"] / impacts["speed_before"], expected, rtol=1e-14)
    assert impacts.size > 4


@pytest.mark.parametrize("method", ["auto", "rk45"])
def test_a_damping_that_drifts(method):
    scene = vi.Scene(system(), FORCE, STOPS[:1])
    options = {"method": method, "rtol": 1e-11, "atol": 1e-13}
    run = vi.simulate(scene, [0.1, 0.1], REST, (0, 20), ramp=vi.Ramp("damping_scale", 3.0, over=20.0), **options)
    inverse = np.linalg.inv(MASS)

    def rate(t, x):
        force = (FORCE.amplitude * np.exp(1j * (1.2 * t + 0.4))).real
        return np.concatenate([x[2:], inverse @ (force - STIFFNESS @ x[:2] - (1 + t / 10) * DAMPING @ x[2:])])

    first = run.impacts["time"][0] if run.impacts.size else 20.0
    exact = solve_ivp(rate, (0, 0.999 * first), [0.1, 0.1, 0, 0], "DOP853", rtol=1e-12, atol=1e-14).y[:2, -1]
    np.testing.assert_allclose(run.position(0.999 * first), exact, atol=1e-9)
    assert np.abs(run.energy.balance).max() < 1e-8


@pytest.mark.parametrize(
    "ramp", [UP, vi.Ramp("frequency", 2.0, levels=3, dwell=4), [UP, vi.Ramp("restitution[0]", 0.4, levels=3, dwell=5)]]
)
def test_runs_pickle_and_give_everything_of_their_chapters(ramp, tmp_path):
    scene = vi.Scene(system(), FORCE, STOPS)
    run = vi.simulate(scene, REST, REST, (0, 50), ramp=ramp)
    run.save(tmp_path / "run.npz")
    for again in (pickle.loads(pickle.dumps(run)), vi.load(tmp_path / "run.npz")):
        assert again.scene == scene
        assert again.ramp == run.ramp
        np.testing.assert_array_equal(again.impacts, run.impacts)
        np.testing.assert_array_equal(again.q, run.q)
        np.testing.assert_array_equal(again.parameter([1.0, 49.0], "frequency"), run.parameter([1.0, 49.0], "frequency"))
        np.testing.assert_array_equal(again.segments, run.segments)
    # Momentum: what acted, and what the stops gave.
    t = np.linspace(0, 50, 20001)
    at_times = vi.simulate(scene, REST, REST, (0, 50), ramp=ramp, t_eval=t[::100])
    np.testing.assert_allclose(at_times.q, run.position(t[::100]), atol=1e-12)
    for part in ((0.0, 50.0), (0.0, 17.3), (17.3, 50.0)):
        whole = run.impulse(0, part)
        hits = run.impacts
        inside = (hits["stop"] == 0) & (hits["time"] > part[0]) & (hits["time"] <= part[1])
        assert whole == pytest.approx(hits["impulse"][inside].sum(), abs=1e-12)
    assert run.impulse(0) == pytest.approx(run.impulse(0, (0.0, 17.3)) + run.impulse(0, (17.3, 50.0)))
    np.testing.assert_allclose(run.gap(0, t), 0.2 - run.along(0, t), atol=1e-13)
    a = run.acceleration(t[1:-1])
    assert a.shape == (t.size - 2, 2)
    assert np.isfinite(a).all()


def test_touches_of_every_chapter_are_kept():
    # It reaches the stop without speed at t = pi, 3 pi, 5 pi: in both chapters, and no impact in either.
    scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), None, vi.Stop(0, 1.0, 0.8))
    plain = vi.simulate(scene, -1.0, 0.0, (0, 17))
    run = vi.simulate(scene, -1.0, 0.0, (0, 17), ramp=vi.Ramp("restitution", 0.5, over=5.0))
    assert plain.impacts.size == 0
    assert plain.grazes.size == 3
    np.testing.assert_allclose(run.grazes["time"], plain.grazes["time"], atol=1e-6)


def test_a_stop_that_jumps_onto_the_motion_ends_the_run():
    still = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([0.5], 1.0), vi.Stop(0, 2.0, 0.8))
    run = vi.simulate(still, 0.0, 0.0, (0, 200), ramp=vi.Ramp("clearance", -1.0, levels=2, dwell=10.1))
    assert run.status == "inside_stop"
    assert "put a stop onto the motion" in run.message
    assert run.t_end == pytest.approx(10.1 * 2 * np.pi)
    assert run.position(run.t_end).shape == (1,)


def test_most_impacts_count_along_all_levels():
    scene = vi.Scene(system(), FORCE, STOPS)
    ramp = vi.Ramp("frequency", 2.0, levels=40, dwell=1)
    run = vi.simulate(scene, REST, REST, (0, 200), ramp=ramp, max_impacts=17)
    assert run.status == "max_impacts"
    assert run.impacts.size == 17
    assert "after 17 impacts" in run.message


@pytest.mark.parametrize(
    ("ramps", "options", "message"),
    [
        (
            UP,
            {"method": "exact"},
            'ramp of "frequency" is continuous, but exact flights cannot follow it: give levels= and dwell=, or method="taylor"',
        ),
        (vi.Ramp("damping_scale", 2.0, over=1.0), {"method": "exact"}, 'ramp of "damping_scale" is continuous'),
        ([UP, vi.Ramp("frequency", 2.0, over=1.0)], {}, 'ramp is twice of "frequency"'),
        ([vi.Ramp("clearance", 1.0, over=1.0), vi.Ramp("clearance[1]", 2.0, over=1.0)], {}, "ramp is twice of"),
        (vi.Ramp("clearance", 1.0, over=1.0), {}, "the stops differ"),
        (vi.Ramp("clearance[7]", 1.0, over=1.0), {}, r"clearance\[7\] is not there"),
        (vi.Ramp("phase", 1.0, levels=3, dwell=1), {}, "a phase that jumps"),
        (vi.Ramp("forcing_scale", -1.0, over=1.0, law="log"), {}, "it must have the sign"),
    ],
)
def test_ramps_that_a_scene_does_not_take(ramps, options, message):
    with pytest.raises(ValueError, match=message):
        vi.simulate(vi.Scene(system(), FORCE, STOPS), REST, REST, (0, 10), ramp=ramps, **options)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"to": 2.0}, "how fast the ramp goes is missing"),
        ({"to": 2.0, "over": 1.0, "rate": 1.0}, "given twice"),
        ({"to": 2.0, "levels": 3}, "dwell is None"),
        ({"to": 2.0, "dwell": 3}, "levels is None"),
        ({"to": 2.0, "levels": 1, "dwell": 3}, "levels is 1"),
        ({"to": -2.0, "over": 1.0}, "frequency is -2"),
        ({"to": 2.0, "over": 0.0}, "over is 0"),
        ({"to": 2.0, "rate": np.nan}, "rate is NaN"),
        ({"to": 2.0, "over": 1.0, "law": "cubic"}, 'law is "cubic"'),
    ],
)
def test_what_is_no_ramp_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        vi.Ramp("frequency", **arguments)


def test_what_needs_a_ramp_or_a_forcing_says_so():
    with pytest.raises(ValueError, match='the parameter is "speed"'):
        vi.Ramp("speed", 1.0, over=1.0)
    free = vi.Scene(system(), None, STOPS)
    with pytest.raises(ValueError, match="it counts forcing periods"):
        vi.simulate(free, REST, REST, (0, 1), ramp=vi.Ramp("clearance[0]", 1.0, levels=3, dwell=2))
    with pytest.raises(ValueError, match="no forcing to change"):
        vi.simulate(free, REST, REST, (0, 1), ramp=UP)
    with pytest.raises(TypeError, match="ramp is 3"):
        vi.simulate(free, REST, REST, (0, 1), ramp=3)
    plain = vi.simulate(free, REST, REST, (0, 1))
    assert plain.ramp is None
    with pytest.raises(ValueError, match="the run has no ramp"):
        plain.parameter(0.5)
    run = vi.simulate(vi.Scene(system(), FORCE, STOPS), REST, REST, (0, 1), ramp=UP)
    with pytest.raises(ValueError, match="lie in the span"):
        run.parameter(2.0)
    with pytest.raises(ValueError, match='those with a ramp, "frequency"'):
        run.parameter(0.5, "phase")


def test_the_lag_at_a_fold_grows_as_the_rate_to_two_thirds():
    def scene(w):
        return vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([0.5], w), vi.Stop(0, 1.0, 0.8))

    # Orbits of one impact a period come in pairs below a frequency, and there are none above it.
    low, high = 1.55, 1.6
    while low < 0.5 * (low + high) < high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if len(vi.periodic_orbits(scene(middle), [0])) else (low, middle)
    speed_at_fold = np.mean([orbit.impacts["speed_before"][0] for orbit in vi.periodic_orbits(scene(low), [0])])
    rates, lags = 10.0 ** np.array([-7, -6.5, -6, -5.5, -5]), []
    for rate in rates:
        pair = vi.periodic_orbits(scene(low - 60 * rate ** (2 / 3)), [0])
        stable = max(pair, key=lambda orbit: orbit.impacts["speed_before"][0])
        ramp = vi.Ramp("frequency", 2.5, rate=rate)
        run = vi.simulate(stable.scene, stable.q0, stable.v0, (0, 120 * rate ** (-1 / 3)), ramp=ramp, keep="impacts")
        # It passes the fold's own speed late, on its way to a motion without impacts.
        past = run.impacts["speed_before"] - speed_at_fold
        k = np.flatnonzero(past < 0)[0]
        t = np.interp(0.0, -past[k - 1 : k + 1], run.impacts["time"][k - 1 : k + 1])
        lags.append(run.parameter(t) - low)
    power = np.polyfit(np.log(rates), np.log(lags), 1)[0]
    assert abs(power - 2 / 3) < 0.03
    steps = np.diff(np.log(lags)) / np.diff(np.log(rates))
    assert np.abs(steps - 2 / 3).max() < 0.03


class TestSweep:
    def run(self, first, last):
        scene = vi.Scene(vi.LinearSystem(1.0, 0.04, 1.0), vi.Harmonic([0.1], first), vi.Stop(0, 0.8, 0.9))
        return vi.simulate(scene, 0.0, 0.0, (0, 1300), ramp=vi.Ramp("frequency", last, over=1250.0))

    def test_up_and_down_jump_at_different_frequencies(self):
        ax = vi.plot.sweep(self.run(0.8, 1.5))
        assert vi.plot.sweep(self.run(1.5, 0.8), ax=ax) is ax
        jumps = []
        for line in ax.lines:
            w, swing = line.get_data()
            assert np.isfinite(swing).all()
            assert w.min() > 0.79
            assert w.max() < 1.51
            jumps.append(w[np.argmax(np.abs(np.diff(swing)))])
        assert jumps[0] > jumps[1] + 0.05
        assert [line.get_label() for line in ax.lines] == ["q[0], up", "q[0], down"]
        assert ax.get_xlabel() == "frequency [rad/s]"

    def test_the_swing_without_stops_is_the_amplitude(self):
        scene = vi.Scene(vi.LinearSystem(1.0, 0.2, 1.0), vi.Harmonic([1.0], 0.5))
        run = vi.simulate(scene, 0.0, 0.0, (0, 20_000), ramp=vi.Ramp("frequency", 0.9, rate=2e-5))
        w, swing = vi.plot.sweep(run).lines[0].get_data()
        exact = 1 / np.abs(1 - w**2 + 0.2j * w)
        np.testing.assert_allclose(swing[100:], exact[100:], rtol=4e-3)

    def test_over_another_number_and_what_is_refused(self):
        scene = vi.Scene(vi.LinearSystem(1.0, 0.2, 1.0), vi.Harmonic([1.0], 0.5), vi.Stop(0, 2.0, 0.9))
        ramps = [vi.Ramp("frequency", 0.9, rate=1e-3), vi.Ramp("clearance", 1.0, over=300.0)]
        run = vi.simulate(scene, 0.0, 0.0, (0, 300), ramp=ramps)
        x, _ = vi.plot.sweep(run, [2.0], parameter="clearance", color="k").lines[0].get_data()
        assert x[0] > 1.9
        assert x[-1] < 1.1
        with pytest.raises(ValueError, match="must have a ramp"):
            vi.plot.sweep(vi.simulate(scene, 0.0, 0.0, (0, 30)))
        with pytest.raises(ValueError, match="must last for a forcing period"):
            vi.plot.sweep(vi.simulate(scene, 0.0, 0.0, (0, 1.0), ramp=ramps))
        with pytest.raises(ValueError, match="must be one trajectory"):
            vi.plot.sweep(scene)


def test_the_phase_is_that_of_the_first_of_several():
    forces = [vi.Harmonic([1.0], 2.0, 0.3), vi.Harmonic([1.0], 1.0, 0.7)]
    scene = vi.Scene(vi.LinearSystem(1.0, 0.05, 1.0), forces, vi.Stop(0, 0.5, 0.8))
    nearly_at_once = vi.simulate(scene, 0.0, 0.0, (0, 20), ramp=vi.Ramp("phase", 1.3, over=1e-7))
    np.testing.assert_allclose(nearly_at_once.parameter([0.0, 1.0]), [0.3, 1.3], atol=1e-14)
    there = vi.simulate(scene.replace(phase=1.3), 0.0, 0.0, (0, 20))
    np.testing.assert_allclose(nearly_at_once.impacts["time"], there.impacts["time"], atol=1e-5)
    np.testing.assert_allclose(nearly_at_once.phase(20.0), there.phase(20.0), atol=1e-12)
    plain = vi.simulate(scene, 0.0, 0.0, (0, 20))
    none = vi.simulate(scene, 0.0, 0.0, (0, 20), ramp=vi.Ramp("phase", 0.3, over=5.0))
    np.testing.assert_array_equal(none.impacts, plain.impacts)


def test_impacts_have_their_phase_while_the_force_is_zero():
    scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), vi.Harmonic([0.0], 1.0, 0.2), vi.Stop(0, 0.3, 1.0))
    run = vi.simulate(scene, 0.0, 1.0, (0, 12), ramp=vi.Ramp("frequency", 2.0, over=8.0))
    assert run.impacts.size >= 4
    np.testing.assert_allclose(run.impacts["phase"], run.phase(run.impacts["time"]), atol=1e-14)


@pytest.mark.parametrize("parameter", ["frequency", "phase"])
@pytest.mark.parametrize("over", [1e-9, 1e-15])
def test_a_ramp_of_no_time_takes_none(parameter, over):
    scene = vi.Scene(vi.LinearSystem(1.0, 0.05, 1.0), vi.Harmonic([1.0], 1.0, 0.7), vi.Stop(0, 0.5, 0.8))
    run = vi.simulate(scene, 0.0, 0.0, (0, 20), ramp=vi.Ramp(parameter, 1.3, over=over))
    there = vi.simulate(scene.replace(**{parameter: 1.3}), 0.0, 0.0, (0, 20))
    np.testing.assert_allclose(run.impacts["time"], there.impacts["time"], atol=1e-6)


@pytest.mark.parametrize("ramp", [vi.Ramp("frequency", 2.0, over=30.0), vi.Ramp("frequency", 2.0, levels=6, dwell=1.7)])
def test_poincare_points_stand_at_whole_turns(ramp):
    scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], 1.0, 0.4), vi.Stop(0, 5.0, 0.3))
    run = vi.simulate(scene, 0.0, 0.0, (0, 60), ramp=ramp)
    q = vi.plot.poincare_section(run).lines[0].get_xdata()
    # The angle without its phase, by small steps.
    t = np.linspace(0, 60, 600_001)
    w = run.parameter(t)
    turns = np.concatenate([[0.0], np.cumsum(0.5 * (w[1:] + w[:-1]) * np.diff(t))]) / (2 * np.pi)
    times = np.interp(np.arange(int(turns[-1]) + 1), turns, t)
    np.testing.assert_allclose(q, run.along(0, times), atol=1e-4)


def test_taylor_is_a_method_of_linear_scenes_along_any_ramp():
    scene = vi.Scene(system(), FORCE, STOPS)
    for ramp in (vi.Ramp("clearance[0]", 0.3, over=5.0), vi.Ramp("frequency", 2.0, levels=3, dwell=2)):
        one, other = (vi.simulate(scene, REST, REST, (0, 20), method=method, ramp=ramp) for method in ("taylor", "auto"))
        np.testing.assert_array_equal(one.impacts, other.impacts)


@pytest.mark.parametrize("off", [5e-3, 1e-5, 1e-9, 0.0])
@pytest.mark.parametrize("turns", [0, 2, 1001])
def test_a_force_that_is_small_all_the_time_is_followed(off, turns):
    """Short restarts where the cosine passes zero: the force is known to its amplitude's rounding, however small it is itself."""
    phase, end = np.pi / 2 + np.pi * turns - off, 0.01
    one = vi.LinearSystem(1.0, 0.1, 4.0)
    stops = [vi.Stop(0, 5.0, 0.5), vi.Stop(0, 6.0, 0.5, motion=vi.Harmonic(0.3, 1.0, phase))]
    ramps = {
        "frequency": (vi.Ramp("frequency", 2.0, rate=0.01), lambda t: np.cos(phase + t + 0.005 * t**2)),
        "scale": (vi.Ramp("forcing_scale", 2.0, rate=0.01), lambda t: (1 + 0.01 * t) * np.cos(phase + t)),
    }
    for ramp, force in ramps.values():
        x = solve_ivp(
            lambda t, y, force=force: [y[1], force(t) - 4 * y[0] - 0.1 * y[1]], (0, end), [0.1, 0], "DOP853", rtol=1e-12
        )
        for method in ("auto", "dop853"):
            run = vi.simulate(
                vi.Scene(one, vi.Harmonic([1.0], 1.0, phase), stops), [0.1], [0.0], (0, end), ramp=ramp, method=method
            )
            np.testing.assert_allclose(np.concatenate(run.final), x.y[:, -1], atol=1e-12)
