"""Forces and base motions that follow signals: samples, splines, functions."""

import pickle
import re

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PPoly
from scipy.linalg import expm
from scipy.optimize import brentq

import vibroimpact as vi

MASS = np.array([[2.0, 0.3], [0.3, 1.0]])
DAMPING = np.array([[0.2, 0.03], [0.05, 0.15]])
STIFFNESS = np.array([[40.0, -9.0], [-9.0, 25.0]])
INFLUENCE = np.array([1.0, 0.6])
STOPS = [vi.Stop(0, 0.03, 0.8), vi.Stop([0.3, 1.0], 0.05, 0.6, side="lower")]
REST = np.zeros(2)
STEPS = ["rk45", "dop853", "radau"]


def system(influence=None):
    return vi.LinearSystem(MASS, DAMPING, STIFFNESS, influence=influence)


def record(m, span, seed=5):
    """Something like measured ground motion: samples of noise that was passed through a filter."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, span, m)
    noise = np.convolve(rng.standard_normal(m), np.hanning(9), "same")
    return t, 3.0 * noise * np.exp(-(((t - 0.4 * span) / (0.3 * span)) ** 2))


def cut_at_every_sample(direction, t, values, end):
    """Impacts by the matrix exponential from sample to sample: state (q, v, s, s'), four looks a piece, zeros by bisection."""
    n = 2
    inverse = np.linalg.inv(MASS)
    generator = np.zeros((6, 6))
    generator[:2, 2:4] = np.eye(2)
    generator[2:4, :2], generator[2:4, 2:4] = -inverse @ STIFFNESS, -inverse @ DAMPING
    generator[2:4, 4], generator[4, 5] = inverse @ direction, 1.0
    normals = np.array([[1.0, 0.0], [-0.3, -1.0]])
    clearances, restitutions = np.array([0.1, 0.1]), [0.5, 0.4]
    state, now, piece, impacts = np.zeros(6), 0.0, 0, []

    def put_signal(state, piece):
        inside = piece + 1 < len(t)
        state[4] = values[piece] if inside else 0.0
        state[5] = (values[piece + 1] - values[piece]) / (t[piece + 1] - t[piece]) if inside else 0.0

    looks = {}

    def look(span):
        if span not in looks:
            looks[span] = expm(generator * span)
        return looks[span]

    put_signal(state, 0)
    while now < end:
        until = t[piece + 1] if piece + 1 < len(t) else end
        until = min(until, end)
        step = min((t[1] - t[0]) / 4, until - now)
        ahead = look(step) @ state
        gaps = clearances - normals @ ahead[:n]
        if gaps.min() < -1e-12:
            times = []
            for i in range(2):
                if gaps[i] < -1e-12:
                    gap = lambda s, i=i, state=state: clearances[i] - normals[i] @ (expm(generator * s) @ state)[:n]  # noqa: E731
                    # The last time at which it is open: just after an impact the gap is zero to rounding.
                    parts = step * np.arange(64) / 64
                    low = max(s for s in parts if gap(s) > 1e-13)
                    times.append((brentq(gap, low, step, xtol=1e-15, rtol=1e-14), i))
            s, i = min(times)
            state = expm(generator * s) @ state
            now += s
            b = inverse @ normals[i]
            p = (1 + restitutions[i]) * (normals[i] @ state[2:4]) / (normals[i] @ b)
            state[2:4] -= b * p
            impacts.append((now, i, p))
            continue
        state, now = ahead, now + step
        if until - now < 1e-12 and piece + 1 < len(t):
            now, piece = until, piece + 1
            put_signal(state, piece)
    return impacts, state


def test_a_record_of_4000_samples_is_an_integration_cut_at_every_sample():
    t, a = record(4000, 40.0, seed=9)
    stops = [vi.Stop(0, 0.1, 0.5), vi.Stop([0.3, 1.0], 0.1, 0.4, side="lower")]
    scene = vi.Scene(system(INFLUENCE), vi.BaseAcceleration((t, a)), stops)
    run = vi.simulate(scene, REST, REST, (0, 50))
    impacts, state = cut_at_every_sample(-MASS @ INFLUENCE, t, a, 50.0)
    assert len(impacts) == run.impacts.size > 20
    np.testing.assert_array_equal(run.impacts["stop"], [i for _, i, _ in impacts])
    np.testing.assert_allclose(run.impacts["time"], [time for time, _, _ in impacts], rtol=0, atol=1e-9)
    np.testing.assert_allclose(run.impacts["impulse"], [p for _, _, p in impacts], rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.concatenate(run.final), state[:4], rtol=0, atol=1e-9)
    # A flight over many samples is one segment.
    assert len(run.segments) <= run.impacts.size + 1


@pytest.mark.parametrize("method", STEPS)
def test_steps_and_exact_flights_agree_under_any_signal(method):
    t, a = record(60, 12.0)
    spline = CubicSpline(t, a)
    jumps = PPoly([[3.0, -2.0, 0.0, 4.0]], [0.5, 2.0, 3.5, 5.0, 6.0])
    function = vi.Signal.from_function(lambda t: 4 * np.sin(2 * t + 0.2 * t**2), (0.0, 12.0))
    forcings = [
        vi.BaseAcceleration((t, a)),
        vi.Load([1.0, -2.0], spline),
        vi.Load(1, jumps),
        [vi.Load(0, function), vi.Harmonic([0.5, 1.0], 2.0)],
        [vi.Load(0, jumps), vi.BaseAcceleration(spline), vi.Fourier([[1.0, 0.0], [0.5j, 1.0]], 1.3, mean=[0.2, 0.1])],
    ]
    for forcing in forcings:
        scene = vi.Scene(system(INFLUENCE), forcing, STOPS)
        exact = vi.simulate(scene, REST, REST, (0, 12))
        steps = vi.simulate(scene, REST, REST, (0, 12), method=method, rtol=1e-11, atol=1e-13)
        # How many impacts of a chatter are gone through one by one is a matter of the tolerances.
        one, other = (run.impacts[run.impacts["speed_before"] > 1e-4] for run in (exact, steps))
        assert one.size == other.size > 3
        np.testing.assert_array_equal(one["stop"], other["stop"])
        np.testing.assert_allclose(one["time"], other["time"], rtol=0, atol=1e-7)
        np.testing.assert_allclose(exact.final, steps.final, rtol=0, atol=1e-7)


@pytest.mark.parametrize("damping", ["proportional", "defective", "free"])
def test_every_kind_of_modes_flies_under_signals(damping):
    jumps = PPoly([[3.0, -2.0, 0.5], [1.0, 0.0, 4.0]], [0.5, 2.0, 3.5, 6.0])
    systems = {
        "proportional": vi.LinearSystem(MASS, 0.01 * STIFFNESS, STIFFNESS),
        "defective": vi.LinearSystem([1.0, 1.0], np.zeros(2), [[4.0, 1.0], [0.0, 4.0]]),
        "free": vi.LinearSystem([1.0, 2.0], [[0.2, -0.2], [-0.2, 0.2]], [[3.0, -3.0], [-3.0, 3.0]]),
    }
    scene = vi.Scene(systems[damping], [vi.Load(0, jumps), vi.Harmonic([0.3, -0.2], 1.7)], STOPS)
    exact = vi.simulate(scene, REST, REST, (0, 15))
    steps = vi.simulate(scene, REST, REST, (0, 15), method="dop853", rtol=1e-12, atol=1e-14)
    count = min(exact.impacts.size, 12)
    assert count > 2
    np.testing.assert_array_equal(exact.impacts["stop"][:count], steps.impacts["stop"][:count])
    np.testing.assert_allclose(exact.impacts["time"][:count], steps.impacts["time"][:count], rtol=0, atol=1e-8)


@pytest.mark.parametrize("method", ["taylor", *STEPS])
def test_the_base_of_a_pendulum_accelerates(method):
    t, a = record(50, 8.0)
    spline = CubicSpline(t, 0.05 * a)
    m, mu = 0.6, 1.4
    alpha, gravity = m / (1 + m) / mu, 1 / (1 + m)

    def acceleration(time, q, v):
        push = spline(time) if 0 <= time < 8.0 else 0.0
        c, s = np.cos(q[0] - q[1]), np.sin(q[0] - q[1])
        mass = np.array([[1.0, alpha * c], [alpha * c, alpha / mu]])
        right = [
            -gravity * np.sin(q[0]) - alpha * s * v[1] ** 2 - push * np.cos(q[0]),
            alpha * s * v[0] ** 2 - alpha * gravity * np.sin(q[1]) - alpha * push * np.cos(q[1]),
        ]
        return np.linalg.solve(mass, np.array(right) - np.array([[0.07, -0.02], [-0.02, 0.02]]) @ v)

    def gap(q):
        return 0.04 - np.sin(q[0]) - np.sin(q[1]) / mu

    def gradient(q):
        return np.array([-np.cos(q[0]), -np.cos(q[1]) / mu])

    def mass(q):
        c = alpha * np.cos(q[0] - q[1])
        return np.array([[1.0, c], [c, alpha / mu]])

    pendulum = vi.DoublePendulum(m, mu, damping=(0.05, 0.02))
    scene = vi.Scene(pendulum, vi.BaseAcceleration(spline), vi.Wall(1, 0.04, 0.7))
    run = vi.simulate(scene, REST, REST, (0, 8), method=method, rtol=1e-11, atol=1e-13)
    written = vi.Scene(vi.NonlinearSystem(2, acceleration, mass=mass), None, vi.NonlinearStop(gap, gradient, 0.7))
    reference = vi.simulate(written, REST, REST, (0, 8), method="dop853", rtol=1e-11, atol=1e-13)
    assert run.impacts.size == reference.impacts.size > 3
    np.testing.assert_allclose(run.impacts["time"], reference.impacts["time"], rtol=0, atol=1e-6)


@pytest.mark.parametrize("method", ["exact", "dop853"])
def test_a_load_that_presses_holds_a_mass_on_its_stop_until_it_pulls(method):
    """Critically simple: m q'' = s(t), s a line through zero at t = 3, a stop at 0 without restitution."""
    press = vi.Load(0, ([0.0, 5.0], [3.0, -2.0]))
    scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0), press, vi.Stop(0, 0.0, 0.0))
    run = vi.simulate(scene, [0.0], [0.0], (0, 5), method=method)
    assert run.segments["kind"][0] == "stick"
    end = run.segments["end"][0]
    assert end == pytest.approx(3.0, abs=1e-9)
    # Then q = -(t - 3)^3/6.
    assert run.final[0][0] == pytest.approx(-8 / 6, abs=1e-8)
    # A force that jumps from pressing to pulling lets go at the jump.
    jump = vi.Load(0, PPoly([[1.0, -1.0]], [0.0, 2.0, 4.0]))
    run = vi.simulate(scene.replace(forcing=jump), [0.0], [0.0], (0, 4), method=method)
    assert run.segments["end"][0] == 2.0
    assert run.final[0][0] == pytest.approx(-2.0, abs=1e-9)
    # And one that jumps from pulling to pressing flies back: up to q = -1/2 with v = -1, then on its stop again.
    back = vi.Load(0, PPoly([[-1.0, 1.0]], [0.0, 1.0, 9.0]))
    run = vi.simulate(scene.replace(forcing=back), [0.0], [0.0], (0, 4), method=method)
    assert run.impacts["time"][0] == pytest.approx(2 + np.sqrt(2.0), abs=1e-9)


@pytest.mark.parametrize("method", ["exact", "dop853"])
def test_the_energy_ledger_closes(method):
    t, a = record(80, 12.0)
    scene = vi.Scene(system(INFLUENCE), [vi.BaseAcceleration((t, a)), vi.Load(0, PPoly([[3.0, -2.0]], [1.0, 4.0, 6.0]))], STOPS)
    run = vi.simulate(scene, REST, REST, (0, 15), method=method)
    energy = run.energy
    size = np.abs(energy.forcing_work).max()
    assert size > 0.01
    assert np.abs(energy.balance).max() <= 10 * 1e-9 * size


def test_runs_in_parts_and_at_given_times_are_the_run():
    t, a = record(200, 12.0)
    scene = vi.Scene(system(INFLUENCE), vi.BaseAcceleration((t, a)), STOPS)
    whole = vi.simulate(scene, REST, REST, (0, 12))
    first = vi.simulate(scene, REST, REST, (0, 5.0))
    rest = vi.simulate(scene, *first.final, (5.0, 12))
    np.testing.assert_allclose(rest.final, whole.final, rtol=0, atol=1e-9)
    times = np.sort(np.concatenate([t[::7], np.linspace(0, 12, 50)]))
    again = pickle.loads(pickle.dumps(whole))
    np.testing.assert_array_equal(again.position(times), whole.position(times))
    sampled = vi.simulate(scene, REST, REST, (0, 12), t_eval=times)
    np.testing.assert_allclose(sampled.q, whole.position(times), rtol=0, atol=1e-11)
    many = vi.simulate_many(scene, np.zeros((3, 2)), np.array([[0.0, 0.0], [0.1, 0.0], [0.0, -0.2]]), (0, 12))
    np.testing.assert_array_equal(many.q[0], whole.final[0])
    shifted = vi.simulate(scene.replace(forcing=vi.BaseAcceleration((t + 3.0, a))), REST, REST, (3.0, 15.0))
    np.testing.assert_allclose(shifted.impacts["time"] - 3.0, whole.impacts["time"], rtol=0, atol=1e-9)


def test_many_pendulums_side_by_side_are_each_by_itself():
    t, a = record(50, 8.0)
    scene = vi.Scene(vi.DoublePendulum(0.6, 1.4), vi.BaseAcceleration((t, 0.05 * a)), vi.Wall(1, 0.04, 0.7))
    starts = np.linspace(-0.02, 0.02, 11)[:, None] * np.ones(2)
    many = vi.simulate_many(scene, starts, np.zeros_like(starts), (0, 8), method="taylor")
    for i, start in enumerate(starts):
        alone = vi.simulate(scene, start, REST, (0, 8), method="taylor", keep="final")
        np.testing.assert_array_equal(many.q[i], alone.final[0])


def test_signals_are_piecewise_polynomials():
    t, a = record(30, 3.0)
    spline = CubicSpline(t, a)
    scene = vi.Scene(system(INFLUENCE), vi.BaseAcceleration(spline), STOPS)
    signal = scene.forcing.signal
    np.testing.assert_array_equal(signal.x, spline.x)
    np.testing.assert_allclose(signal.c, spline.c, rtol=1e-15)
    times = np.linspace(-0.5, 3.5, 81)
    inside = (times >= 0) & (times < 3.0)
    np.testing.assert_allclose(signal(times), np.where(inside, spline(times), 0.0), rtol=0, atol=1e-12)
    for value in (signal, scene, vi.Load([1.0, 2.0], spline), scene.replace(forcing_scale=0.3)):
        assert pickle.loads(pickle.dumps(value)) == value
    assert "29 pieces of degree 3 on [0, 3]" in repr(scene)
    assert "after 1 signal" in scene.plan()


def test_what_has_no_period_says_so():
    scene = vi.Scene(system(), vi.Load(0, ([0.0, 1.0], [1.0, 1.0])), STOPS)
    assert scene.period is None
    with pytest.raises(ValueError, match="follows a signal, which has no period"):
        vi.periodic_orbits(scene, [0])
    with pytest.raises(ValueError, match="follows signals, which have none"):
        scene.replace(frequency=2.0)
    with pytest.raises(ValueError, match="what follows a signal has none"):
        scene.replace(amplitude=2.0)


@pytest.mark.parametrize(
    ("signal", "error", "message"),
    [
        (([0.0], [1.0]), ValueError, r"t has shape \(1,\)"),
        (([0.0, 1.0], [1.0]), ValueError, r"values has shape \(1,\)"),
        (([0.0, 0.0], [1.0, 2.0]), ValueError, r"t\[1\] is 0, but it must be later than t\[0\], 0"),
        (([1.0, 0.0], [1.0, 2.0]), ValueError, r"t\[1\] is 0, but it must be later"),
        (([0.0, np.inf], [1.0, 2.0]), ValueError, r"t\[1\] is inf"),
        (([0.0, 1.0], [1.0, np.nan]), ValueError, r"values\[1\] is NaN"),
        (PPoly(np.ones((2, 3, 2)), [0, 1, 2, 3]), ValueError, r"signal.c has shape \(2, 3, 2\)"),
        (3.0, TypeError, "signal is float"),
        (np.sin, TypeError, "take Signal.from_function"),
    ],
)
def test_signals_that_are_none_are_refused(signal, error, message):
    with pytest.raises(error, match=message):
        vi.Load(0, signal)


BUMPS = {
    "half-sine": lambda x: np.sin(np.pi * x),
    "haversine": lambda x: np.sin(np.pi * x) ** 2,
    "triangle": lambda x: 1 - np.abs(2 * x - 1),
    "sawtooth of no slope at its end": lambda x: 6.75 * x * (1 - x) ** 2,
    "bump": lambda x: np.exp(4 - 1 / np.clip(x * (1 - x), 1e-3, None)),
    "wavelet": lambda x: np.sin(2 * np.pi * x) * np.sin(np.pi * x),
}


def pulse(bump, a, width):
    return lambda t: np.where((t > a) & (t < a + width), bump((t - a) / width), 0.0)


@pytest.mark.parametrize("shape", BUMPS)
@pytest.mark.parametrize("span", [(0.0, 10.0), (-3.0, 2.0), (1000.0, 1001.0)])
def test_nothing_that_lasts_a_thousandth_of_the_span_is_lost(shape, span):
    rng = np.random.default_rng(7)
    length = span[1] - span[0]
    for width in length * np.array([1e-3, 2e-3, 0.02, 0.3]):
        for _ in range(5):
            a = rng.uniform(span[0], span[1] - width)
            f = pulse(BUMPS[shape], a, width)
            signal = vi.Signal.from_function(f, span)
            t = np.concatenate([a + width * rng.uniform(size=300), rng.uniform(*span, 300)])
            # What four last places of the time make of slopes of up to ten heights over the width.
            allowed = 3e-14 + 80 * np.spacing(max(map(abs, span))) / width
            np.testing.assert_allclose(signal(t), f(t), rtol=0, atol=allowed)


@pytest.mark.parametrize("k", [8, 16, 32, 64, 128, 1024])
def test_functions_that_are_the_same_in_special_places_are_seen(k):
    """Polynomials of Chebyshev that are 1 at all places of lower ones, and waves that repeat at every regular step."""

    def chebyshev(t):
        return 2 + np.cos(k * np.arccos(np.clip(2 * t - 1, -1, 1)))

    t = np.linspace(0.05, 0.95, 999)
    np.testing.assert_allclose(vi.Signal.from_function(chebyshev, (0.0, 1.0))(t), chebyshev(t), atol=1e-12 * k)

    def wave(t):
        return np.sin(2 * np.pi * 4 * k * t) ** 2

    np.testing.assert_allclose(vi.Signal.from_function(wave, (0.0, 1.0))(t), wave(t), atol=2e-15 * 4 * k + 1e-13)


def test_named_breaks_are_where_a_function_jumps():
    def steps(t):
        return np.where(t < 1.0, 0.0, np.where(t < 2.5, np.cos(t), -1.0)) + 0.3 * (t >= 3.0)

    signal = vi.Signal.from_function(steps, (0.0, 4.0), breaks=[2.5, 1.0, 3.0, 1.0])
    t = np.linspace(0, 4, 1001)[:-1]
    np.testing.assert_allclose(signal(t), steps(t), atol=1e-14)
    assert len(signal.x) < 12
    for place in (1.0, 2.5, 3.0):
        others = [b for b in (1.0, 2.5, 3.0) if b != place]
        with pytest.raises(ValueError, match=r"the function is off by .*breaks") as refused:
            vi.Signal.from_function(steps, (0.0, 4.0), breaks=others)
        assert abs(float(re.search(r"near t = (\S+)", str(refused.value))[1]) - place) < 1e-6
    # A value that the function has at the end of the span alone is not asked for where the end is named.
    ends = vi.Signal.from_function(lambda t: np.where(t < 4.0, 1.0, 0.0), (0.0, 4.0), breaks=[4.0])
    assert len(ends.x) == 2
    np.testing.assert_allclose(ends([0.0, 2.0, 3.999]), 1.0, rtol=1e-14)


@pytest.mark.parametrize("width", [1e-4, 1e-6, 1e-8])
def test_short_pulses_are_seen_between_their_breaks(width):
    a = 3.1
    f = pulse(BUMPS["half-sine"], a, width)
    signal = vi.Signal.from_function(f, (0.0, 10.0), breaks=[a, a + width])
    t = a + width * np.linspace(0.01, 0.99, 99)
    np.testing.assert_allclose(signal(t), f(t), atol=1e-13 + 30 * np.spacing(a) / width)
    assert len(signal.x) < 20


def test_kinks_are_found_and_named_ones_cost_nothing():
    def kinked(t):
        return np.abs(np.sin(t)) + np.maximum(t - np.sqrt(2), 0.0) ** 2

    kinks = [0.0, np.pi, 2 * np.pi, np.sqrt(2)]
    found = vi.Signal.from_function(kinked, (-1.0, 7.0))
    named = vi.Signal.from_function(kinked, (-1.0, 7.0), breaks=kinks)
    t = np.random.default_rng(3).uniform(-1, 7, 2000)
    for signal in (found, named):
        np.testing.assert_allclose(signal(t), kinked(t), rtol=0, atol=31 * 2e-14)
    assert len(named.x) < 0.3 * len(found.x)


def kinked(kind, k, place):
    """A function whose terms are no steeper than `k` and no larger than 1 by much, with kinks."""
    return {
        "sine": lambda t: np.abs(np.sin(k * t)),
        "sine with a phase": lambda t: np.abs(np.sin(k * t + 0.7)),
        "clipped sawtooth": lambda t: np.maximum(np.abs((k * t) % 1.0 - 0.5), 0.1),
        "slopes that cancel": lambda t: np.where(t > place, 1.0, -0.3) * k / 2 * (t - place) + np.cos(k / 2 * t),
    }[kind]


@pytest.mark.parametrize("kind", ["sine", "sine with a phase", "clipped sawtooth", "slopes that cancel"])
@pytest.mark.parametrize("span", [(0.0, 0.01), (1.0, 3.0), (5.0, 5.01), (-300.5, -300.4), (1e4, 1e4 + 0.3)])
def test_kinks_are_found_wherever_time_begins(kind, span):
    """As well as the time is known: four last places where it was looked at, 6.8 times that between, and one of the function."""
    rng = np.random.default_rng(11)
    last_place = np.finfo(float).eps * max(map(abs, span))
    for _ in range(12):
        k = rng.uniform(2, 40) / (span[1] - span[0])
        f = kinked(kind, k, rng.uniform(*span))
        signal = vi.Signal.from_function(f, span)
        x = signal.x[:-1]
        shortest = np.concatenate([x[np.argsort(np.diff(signal.x))[:20]] + i * np.spacing(span[1]) for i in range(-9, 10)])
        middles = x + np.diff(signal.x) * rng.uniform(size=x.size)
        t = np.clip(np.concatenate([rng.uniform(*span, 200), middles, shortest]), span[0], np.nextafter(span[1], span[0]))
        largest = np.abs(f(np.linspace(*span, 500))).max()
        np.testing.assert_allclose(signal(t), f(t), rtol=0, atol=3e-14 * largest + 28 * last_place * k)


def test_a_jump_is_refused_by_its_place_wherever_time_begins():
    for start in (0.0, 5.0, 1e4):
        place = start + 0.0043
        with pytest.raises(ValueError, match=r"near t = \S+ \(the time has no places for shorter pieces\).*breaks") as refused:
            vi.Signal.from_function(lambda t, place=place: np.sign(t - place), (start, start + 0.01))
        assert abs(float(re.search(r"near t = (\S+) ", str(refused.value))[1]) - place) <= 4 * np.spacing(place)
        named = vi.Signal.from_function(lambda t, place=place: np.sign(t - place), (start, start + 0.01), breaks=[place])
        assert len(named.x) == 3


def test_the_load_of_a_shock_moves_a_base_as_the_shock_does():
    a, width = 3.1, 0.02
    f = pulse(BUMPS["half-sine"], a, width)
    for breaks in ((), (a, a + width)):
        shock = vi.Signal.from_function(lambda t: 40 * f(t), (0.0, 10.0), breaks=breaks)
        one = vi.LinearSystem(1.0, 0.2, 25.0, influence=1.0)
        run = vi.simulate(vi.Scene(one, vi.BaseAcceleration(shock)), 0.0, 0.0, (0.0, 3.3), t_eval=[3.05, 3.3])
        assert np.abs(run.q[0]).max() == 0.0
        # Enlarged by the sine and its derivative.
        w = np.pi / width
        generator = np.array([[0, 1, 0, 0], [-25, -0.2, -40, 0], [0, 0, 0, w], [0, 0, -w, 0.0]])
        x = expm(generator * width) @ [0, 0, 0, 1.0]
        x = expm(generator[:2, :2] * (3.3 - a - width)) @ x[:2]
        np.testing.assert_allclose([run.q[1, 0], run.v[1, 0]], x, atol=1e-13)


def test_functions_that_no_pieces_follow_are_refused():
    with pytest.raises(ValueError, match=r"the function is off by .* near t = .*breaks"):
        vi.Signal.from_function(np.sign, (-1.0, 2.1))
    for breaks, message in (([3.0], r"breaks\[0\] is 3, but it must lie in the span"), ([1.0, np.nan], r"breaks\[1\] is NaN")):
        with pytest.raises(ValueError, match=message):
            vi.Signal.from_function(np.sin, (0.0, 2.0), breaks=breaks)
    with pytest.raises(ValueError, match="must be finite"):
        vi.Signal.from_function(lambda t: t * np.nan, (0.0, 1.0))
    with pytest.raises(ValueError, match="span"):
        vi.Signal.from_function(np.sin, (1.0, 1.0))
    with pytest.raises(ZeroDivisionError):
        vi.Signal.from_function(lambda t: 1 / 0, (0.0, 1.0))
    with pytest.raises(TypeError, match="f is"):
        vi.Signal.from_function(3, (0.0, 1.0))
    with pytest.raises(ValueError, match="the system has coordinates 0 to 1"):
        vi.Scene(system(), vi.Load(2, ([0.0, 1.0], [1.0, 1.0])), STOPS)
    with pytest.raises(ValueError, match="no influence vector"):
        vi.Scene(system(), vi.BaseAcceleration(([0.0, 1.0], [1.0, 1.0])), STOPS)


@pytest.mark.parametrize("method", ["exact", "dop853", "rk45", "radau"])
@pytest.mark.parametrize("zero", [0.0, 1.7e-18, -1.1e-16])
def test_breakpoints_about_zero_are_passed_by_runs_that_come_from_before(method, zero):
    """A step that ends there misses it by a rounding of where it began, which is more than one of zero."""
    system = vi.LinearSystem(1.0, 0.1, 4.0)
    coarse = np.array([-3.0, -1.0, zero, 1.0, 3.0])
    for times in (coarse, np.arange(-1.0, 1.0, 0.1), np.linspace(-1.0, 1.0, 41)):
        scene = vi.Scene(system, vi.Load(0, (times, np.sin(7.0 * times))), vi.Stop(0, 0.05, 0.5))
        run = vi.simulate(scene, [0.0], [0.0], (-2.0, 2.0), method=method)
        assert run.status == "finished"
        later = vi.Scene(system, vi.Load(0, (times + 4.0, np.sin(7.0 * times))), vi.Stop(0, 0.05, 0.5))
        reference = vi.simulate(later, [0.0], [0.0], (2.0, 6.0), method="exact")
        np.testing.assert_allclose(run.final, reference.final, rtol=0, atol=1e-5)


def test_a_short_blow_costs_nothing_before_and_after_it():
    # Counted, not timed: a blow of 1e-6 s once set the longest step of the whole run.
    looks = []
    for length in (1e-2, 1e-6):
        blow = vi.Load(0, ([0.0, length / 2, length], [0.0, 1.0 / length, 0.0]))
        scene = vi.Scene(vi.LinearSystem(1.0, 0.01, 1.0), blow, vi.Stop(0, 0.2, 0.8))
        run = vi.simulate(scene, [0.0], [0.0], (0, 10))
        assert run.impacts.size == 3
        looks.append(run.stats.n_gap_evaluations)
    assert looks[1] < looks[0] + 120, looks


def test_a_periodic_spline_is_refused_and_no_number_has_no_value():
    t = np.linspace(0.0, 2 * np.pi, 9)
    periodic = CubicSpline(t, np.append(np.cos(t[:-1]), 1.0), bc_type="periodic")
    with pytest.raises(ValueError, match="signal is a periodic spline, but a signal is zero outside"):
        vi.Load(0, periodic)
    assert np.isnan(vi.Signal([0.0, 1.0], [[1.0]])(np.nan))
    with pytest.raises(ValueError, match="t is NaN"):
        vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), None, vi.Stop(0, 1.0, 0.8)).gaps([0.0], np.nan)
    with pytest.raises(TypeError, match="motion is int, but a Harmonic, a Fourier, samples"):
        vi.Stop(0, 1.0, 0.8, motion=3)
