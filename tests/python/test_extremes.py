"""Extreme and stiff motions without stops, by every method that applies, against closed forms and 50-digit arithmetic."""

import numpy as np
import pytest
from mpmath import mp, mpf

import vibroimpact as vi

TIGHT = {"rtol": 1e-13, "atol": 1e-15}


@pytest.fixture(autouse=True)
def _fifty_digits():
    with mp.workdps(50):
        yield


def matrix(coefficient):
    coefficient = np.asarray(coefficient, dtype=float)
    return mp.matrix((np.diag(np.atleast_1d(coefficient)) if coefficient.ndim < 2 else coefficient).tolist())


def enlarged(system, forcing, start):
    """Matrix and start of the autonomous system of (q, v, 1, cos, sin) whose time begins at ``start``."""
    n = system.n_dof
    inverse, rate, state = matrix(system.mass) ** -1, mp.zeros(2 * n + 3), mp.zeros(2 * n + 3, 1)
    rate[:n, n : 2 * n] = mp.eye(n)
    rate[n : 2 * n, :n] = -inverse * matrix(system.stiffness)
    rate[n : 2 * n, n : 2 * n] = -inverse * matrix(system.damping)
    rate[n : 2 * n, 2 * n] = inverse * mp.matrix(system.load.tolist())
    state[2 * n] = 1
    if forcing is not None:
        w, phase = mpf(forcing.frequency), mpf(forcing.frequency) * mpf(start) + mpf(forcing.phase)
        rate[n : 2 * n, 2 * n + 1] = inverse * mp.matrix(np.real(forcing.amplitude).tolist())
        rate[2 * n + 1, 2 * n + 2], rate[2 * n + 2, 2 * n + 1] = -w, w
        state[2 * n + 1], state[2 * n + 2] = mp.cos(phase), mp.sin(phase)
    return rate, state


def truth(scene, q0, v0, span):
    """State at the end of the span by the exponential of the enlarged matrix."""
    n, (start, end) = scene.n_dof, span
    rate, state = enlarged(scene.system, scene.forcing, start)
    for i, x in enumerate((*q0, *v0)):
        state[i] = mpf(x)
    time = mpf(end) - mpf(start)
    mp.dps += 20 + int(mp.log10(1 + mp.mnorm(rate, 1) * time))
    moved = mp.expm(rate * time, method="taylor") * state
    return np.array([float(x) for x in moved[: 2 * n]])


def linear(*matrices, force=None, load=None):
    system = vi.LinearSystem(*matrices, load=load)
    return vi.Scene(system, None if force is None else vi.Harmonic(*force))


def mode(ratio, w=1.0, **options):
    return linear(1, 2 * ratio * w, w**2, **options)


PAIR = [[2.0, -1.0], [-1.0, 2.0]]
ONE, TWO = ([0.7], [-0.4]), ([0.7, -0.3], [0.2, 0.5])
PUSH = (0.8, 1.7, 0.3)
SMALL = 1e-12

# name: scene, start, length of time, bound on the error of (exact flights, steps) relative to the largest entry of the answer
LINEAR = {
    "no damping": (mode(0, force=PUSH), ONE, 20, (1e-14, 1e-11)),
    "critical": (mode(1, force=PUSH), ONE, 3, (1e-14, 1e-11)),
    "critical and less": (mode(1 - SMALL, force=PUSH), ONE, 3, (1e-14, 1e-11)),
    "critical and more": (mode(1 + SMALL, force=PUSH), ONE, 3, (1e-14, 1e-11)),
    "critical, free": (mode(1), ONE, 3, (1e-14, 1e-11)),
    "critical and less, free": (mode(1 - SMALL), ONE, 3, (1e-14, 1e-11)),
    "critical and more, free": (mode(1 + SMALL), ONE, 3, (1e-14, 1e-11)),
    "overdamped": (mode(1e3, force=PUSH), ONE, 2, (1e-14, 1e-11)),
    "overdamped for long": (mode(1e3), ONE, 1000, (1e-13, None)),
    "stiffness 1e8": (linear([1, 1], np.diag([1.0, 0.1]), [[1e8 + 1, -1], [-1, 1]]), TWO, 0.1, (1e-11, 1e-8)),
    "stiffness 1e8, damped": (
        linear([1, 1], [2e-2 * 1e4, 0.1], [[1e8, -1], [-1, 1]], force=([1, 1], 1.3)),
        TWO,
        5,
        (2e-11, 1e-9),
    ),
    "stiffness 1e8, overdamped": (linear([1, 1], [2e4, 0.1], [[1e8, -1], [-1, 1]]), TWO, 0.02, (1e-12, 1e-9)),
    "mass 1e-6": (linear([1, 1e-6], [0.1, 0.0], PAIR, force=([1, 0], 1.3)), TWO, 0.5, (1e-11, 1e-8)),
    "mass 1e6": (linear([1, 1e6], [0.1, 0.0], PAIR, force=([1, 0], 1.3)), TWO, 20, (1e-13, 1e-10)),
    "resonance": (mode(0, force=(1, 1)), ONE, 50, (1e-13, 1e-10)),
    "resonance and less": (mode(0, force=(1, 1 - SMALL)), ONE, 50, (1e-13, 1e-10)),
    "resonance and more": (mode(0, force=(1, 1 + SMALL)), ONE, 50, (1e-13, 1e-10)),
    "resonance, damped by little": (mode(SMALL, force=(1, 1 + SMALL)), ONE, 50, (1e-13, 1e-10)),
    "resonance of coupled modes": (linear([1, 1], [0, 0], PAIR, force=([1, -2], 1)), TWO, 50, (1e-13, 1e-10)),
    "rigid body": (linear(1, 0, 0), ONE, 1e3, (1e-15, 1e-12)),
    "rigid body under load and force": (linear(1, 0, 0, load=[0.3], force=PUSH), ONE, 30, (1e-14, 1e-11)),
    "damped rigid body": (linear(1, 0.3, 0, force=PUSH), ONE, 30, (1e-14, 1e-11)),
    "damped rigid body under load": (linear(1, 0.3, 0, load=[0.3]), ONE, 30, (1e-14, 1e-11)),
    "load on a rigid-body mode": (linear([1, 2], [0, 0], [[1, -1], [-1, 1]], load=[0.3, 0.1]), TWO, 30, (1e-13, 1e-10)),
    "load on a damped rigid-body mode": (
        linear([1, 2], [0.1, 0.2], [[1, -1], [-1, 1]], load=[0.3, 0.1]),
        TWO,
        30,
        (1e-13, 1e-10),
    ),
    "rigid body damped by 1e-12": (linear(1, SMALL, 0, load=[0.3], force=PUSH), ONE, 30, (1e-14, 1e-11)),
    "period of 1e4 free periods": (mode(0.1, force=(1, 1e-4, 0.3)), ONE, 6.3e4, (1e-12, 1e-9)),
    "force of frequency 1e-6": (mode(0.1, force=(1, 1e-6, 0.3)), ONE, 30, (1e-13, 1e-10)),
    "rigid body, frequency 1e-6, soon": (linear(1, 0, 0, force=(1, 1e-6, 0.3)), ONE, 30, (1e-14, 1e-11)),
    "rigid body, frequency 1e-6": (linear(1, 0, 0, force=(1, 1e-6, 0.3)), ONE, 1e7, (1e-13, 1e-10)),
    "force of frequency 1e6": (mode(0.1, force=(1e6, 1e6, 0.3)), ONE, 0.002, (1e-12, 1e-9)),
    "rigid body, frequency 1e6": (linear(1, 0, 0, force=(1e6, 1e6, 0.3)), ONE, 0.002, (1e-12, 1e-9)),
    "force of frequency 1e6 for long": (mode(0.1, force=(1e6, 1e6, 0.3)), ONE, 30, (1e-9, None)),
    "force without amplitude": (mode(0.1, force=(0, 1.7)), ONE, 20, (1e-14, 1e-11)),
    "negative stiffness": (linear(1, 0.1, -1, force=PUSH), ONE, 20, (1e-13, 1e-10)),
    "negative stiffness of 1e6": (linear(1, 0, -1e6), ONE, 0.5, (1e-12, 1e-8)),
    "saddle": (linear([1, 1], [0, 0], [[1, 2], [2, 1]], load=[0.1, 0]), TWO, 15, (1e-13, 1e-10)),
    "negative damping": (linear(1, -0.3, 1, force=PUSH), ONE, 30, (1e-13, 1e-10)),
    "gyroscopic": (linear([1, 1], [[0, 3], [-3, 0]], [1, 2], force=([1, 0], 1.3)), TWO, 20, (1e-12, 1e-10)),
    "gyroscopically stabilised": (linear([1, 1], [[0, 5], [-5, 0]], [-1, -2]), TWO, 20, (1e-12, 1e-10)),
    "gyroscopic, free in the plane": (linear([1, 1], [[0, 3], [-3, 0]], [0, 0], load=[1, 0]), TWO, 20, (1e-12, 1e-10)),
    "equal frequencies": (linear([1, 1], [[0.3, 0.1], [0.1, 0.2]], [2, 2], force=([1, 0], 2**0.5)), TWO, 20, (1e-13, 1e-10)),
    "defective": (linear([1, 1], [0, 0], [[1, 1], [0, 1]], force=([1, 0], 1.3)), TWO, 20, (1e-12, 1e-10)),
    "defective, in resonance": (linear([1, 1], [0, 0], [[1, 1], [0, 1]], force=([1, 1], 1)), TWO, 20, (1e-12, 1e-10)),
    "defective by 1e-12": (linear([1, 1], [0, 0], [[1, 1], [0, 1 + SMALL]]), TWO, 20, (1e-12, 1e-10)),
    "follower force": (linear([1, 1], [0, 0], [[1, 1], [-1, 1]]), TWO, 20, (1e-12, 1e-10)),
}


# Without a second bound, steps would need minutes: exact flights alone.
RUNS = [(case, m) for case, row in LINEAR.items() for m, bound in zip(["exact", "rk45"], row[3], strict=True) if bound]


@pytest.mark.parametrize(("case", "method"), RUNS)
def test_a_linear_motion_is_its_matrix_exponential(case, method):
    scene, (q0, v0), length, bounds = LINEAR[case]
    bound = bounds[method == "rk45"]
    run = vi.simulate(scene, q0, v0, (0, length), method=method, keep="final", **TIGHT)
    expected = truth(scene, q0, v0, (0, length))
    assert run.status == "finished"
    for part, whole in zip(run.final, np.split(expected, 2), strict=True):
        assert np.abs(part - whole).max() <= bound * np.abs(whole).max()


@pytest.mark.parametrize("method", ["exact", "rk45", "dop853", "radau"])
@pytest.mark.parametrize("periods", [1e9, -1e9, 12345678.9])
def test_the_phase_of_a_force_is_exact_after_a_billion_periods(periods, method):
    scene = mode(0.01, force=(0.8, 1.7, 0.3))
    start = periods * scene.period
    span = (start, start + 8)
    run = vi.simulate(scene, *ONE, span, method=method, keep="final", **TIGHT)
    assert np.abs(np.concatenate(run.final) - truth(scene, *ONE, span)).max() < 1e-11


@pytest.mark.parametrize("method", ["taylor", "rk45", "dop853", "radau"])
@pytest.mark.parametrize("periods", [1e9, -1e9, 12345678.9])
def test_a_pendulum_does_not_feel_how_many_periods_are_over(periods, method):
    w, phase = 1.7, 0.3
    start = periods * 2 * np.pi / w
    finals = []
    for t0, there in ((start, phase), (0.0, float(mp.fmod(mpf(w) * mpf(start) + mpf(phase), 2 * mp.pi)))):
        scene = vi.Scene(vi.PendulumChain([1, 0.6], [1, 0.8], damping=0.1, gravity=1), vi.BaseMotion(0.3, w, there))
        finals.append(vi.simulate(scene, *TWO, (t0, t0 + 8), method=method, keep="final", **TIGHT).final)
    assert np.abs(np.subtract(*finals)).max() < 1e-11


def test_a_thousand_modes_keep_their_closed_form():
    """w_j = j, zeta_j = 0: after any time each mode is its own cosine and sine."""
    w = np.arange(1.0, 1001.0)
    q0, v0, end = 1 / w**2, np.cos(w), 7.3
    q, v = vi.simulate(vi.Scene(vi.LinearSystem(np.ones(1000), np.zeros(1000), w**2)), q0, v0, (0, end)).final
    for j in (0, 1, 17, 499, 998, 999):
        c, s = mp.cos(w[j] * mpf(end)), mp.sin(w[j] * mpf(end))
        assert q[j] == pytest.approx(float(q0[j] * c + v0[j] / mpf(w[j]) * s), abs=2e-15)
        assert v[j] == pytest.approx(float(v0[j] * c - q0[j] * mpf(w[j]) * s), abs=2e-12)


def chain(gravity=0.0, damping=0.0, masses=(1.0,), lengths=(1.0,)):
    return vi.PendulumChain(list(masses), list(lengths), damping=damping, gravity=gravity)


def extrapolated(rate, state, length, steps=12, columns=12):
    """x' = rate(t, x) over a length of time: modified midpoint steps, extrapolated to none (Gragg, Bulirsch and Stoer)."""
    x, big = [mpf(y) for y in state], mpf(length) / steps
    for step in range(steps):
        start, row = step * big, []
        for column in range(1, columns + 1):
            h = big / (2 * column)
            old, new = x, [a + h * b for a, b in zip(x, rate(start, x), strict=True)]
            for i in range(1, 2 * column):
                old, new = new, [a + 2 * h * b for a, b in zip(old, rate(start + i * h, new), strict=True)]
            slope = rate(start + big, new)
            last = [[(a + b + h * c) / 2 for a, b, c in zip(old, new, slope, strict=True)]]
            for k, before in enumerate(row, 1):
                ratio = (mpf(column) / (column - k)) ** 2 - 1
                last.append([a + (a - b) / ratio for a, b in zip(last[-1], before, strict=True)])
            row = last
        x = row[-1]
    return np.array([float(y) for y in x])


PENDULUM = pytest.mark.parametrize("method", ["taylor", "rk45", "dop853", "radau"])


@PENDULUM
class TestOneLink:
    def final(self, system, q0, v0, end, method, forcing=None):
        run = vi.simulate(vi.Scene(system, forcing), q0, v0, (0, end), method=method, keep="final", **TIGHT)
        assert run.status == "finished"
        return run.final[0][0], run.final[1][0]

    def test_without_gravity_it_is_a_rigid_body(self, method):
        assert self.final(chain(), 0.7, -0.4, 10, method) == (pytest.approx(-3.3, rel=1e-13), pytest.approx(-0.4, rel=1e-13))

    @pytest.mark.parametrize("damping", [0.3, -0.3, 1e-12])
    def test_damped_rigid_body(self, damping, method):
        q, v = self.final(chain(damping=damping), 0.7, -0.4, 10, method)
        decay = mp.expm1(-mpf(damping) * 10)
        assert v == pytest.approx(float(-mpf(0.4) * (1 + decay)), rel=1e-11)
        assert q == pytest.approx(float(mpf(0.7) + mpf(0.4) * decay / mpf(damping)), rel=1e-11)

    def test_upside_down_it_leaves_along_the_separatrix(self, method):
        """q'' = sin q: q = 4 atan(e^(t - 3)), q' = 2 / cosh(t - 3)."""
        start, end = mpf(-3), mpf(2)
        q, v = self.final(chain(gravity=-1.0), float(4 * mp.atan(mp.exp(start))), float(2 * mp.sech(start)), 5, method)
        assert q == pytest.approx(float(4 * mp.atan(mp.exp(end))), abs=1e-11)
        assert v == pytest.approx(float(2 * mp.sech(end)), abs=1e-11)

    def test_upside_down_at_rest_it_stays(self, method):
        assert self.final(chain(gravity=-1.0), 0.0, 0.0, 1e3, method) == (0, 0)

    @pytest.mark.parametrize("speed", [1e-12, 1e-150])
    def test_a_minute_swing_is_harmonic(self, speed, method):
        run = vi.simulate(vi.Scene(chain(gravity=1.0)), 0, speed, (0, 10), method=method, rtol=1e-13, atol=1e-13 * speed)
        assert run.final[0][0] == pytest.approx(speed * np.sin(10.0), rel=1e-10, abs=0)

    @pytest.mark.parametrize(("amplitude", "frequency", "end"), [(1e11, 1e-6, 5.0), (1e-6, 1e6, 3e-5), (0.0, 2.0, 5.0)])
    def test_a_base_that_moves_slowly_fast_or_not_at_all(self, amplitude, frequency, end, method):
        q, v = self.final(chain(gravity=1.0), 0.3, -0.4, end, method, vi.BaseMotion(amplitude, frequency))
        a, w = mpf(amplitude), mpf(frequency)
        expected = extrapolated(lambda t, x: [x[1], a * w**2 * mp.cos(w * t) * mp.cos(x[0]) - mp.sin(x[0])], [0.3, -0.4], end)
        assert q == pytest.approx(expected[0], abs=1e-11)
        assert v == pytest.approx(expected[1], abs=1e-11 * max(1, float(a * w)))


def double_pendulum(mass_ratio, length_ratio):
    """The rate of (q1, q2, v1, v2), theory 2 (3) without forcing and damping."""
    m, mu = mpf(mass_ratio), mpf(length_ratio)
    alpha = m / (1 + m) / mu

    def rate(_, x):
        c, s = mp.cos(x[0] - x[1]), mp.sin(x[0] - x[1])
        f1 = -alpha * x[3] ** 2 * s - mp.sin(x[0]) / (1 + m)
        f2 = mu * x[2] ** 2 * s - mu * mp.sin(x[1]) / (1 + m)
        det = 1 - alpha * mu * c**2
        return [x[2], x[3], (f1 - alpha * c * f2) / det, (f2 - mu * c * f1) / det]

    return rate


@PENDULUM
@pytest.mark.parametrize(
    ("mass_ratio", "length_ratio", "end", "bound"),
    [(1e-6, 1.0, 3.0, 1e-11), (1e6, 1.0, 0.05, 1e-7), (1.0, 1e4, 0.03, 1e-10), (1.0, 1e-4, 0.3, 1e-10)],
)
def test_links_of_very_different_masses_and_lengths(mass_ratio, length_ratio, end, bound, method):
    """Errors relative to the largest angle, speed; a heavy bob turns the upper link a thousand times as fast as it swings."""
    q0, v0 = [0.4, -0.3], [0.1, 0.2]
    scene = vi.Scene(vi.DoublePendulum(mass_ratio, length_ratio))
    run = vi.simulate(scene, q0, v0, (0, end), method=method, keep="final", **TIGHT)
    expected = np.split(extrapolated(double_pendulum(mass_ratio, length_ratio), [*q0, *v0], end), 2)
    assert run.status == "finished"
    for part, whole in zip(run.final, expected, strict=True):
        assert np.abs(part - whole).max() <= bound * np.abs(whole).max()
