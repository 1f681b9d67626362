"""Equations of one's own that bend sharply, have kinks or jump: what is said of deviations is right, or that it is not known."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vibroimpact as vi

W = 0.8
PERIOD = 2 * np.pi / W


def orbit_of(acceleration, n=1, jacobian=None, force=None, periods=20, **options):
    """The orbit that a forced system settles on from rest."""
    system = vi.NonlinearSystem(n, acceleration, mass=np.eye(n), jacobian=jacobian, **options)
    scene = vi.Scene(system, vi.Harmonic([1.0, *[0.3] * (n - 1)] if force is None else force, W))
    run = vi.simulate(scene, np.zeros(n), np.zeros(n), (0, periods * PERIOD), rtol=1e-9, atol=1e-11, keep="motion")
    return vi.find_orbit(scene, run)


def with_events(smooth, surfaces, x, time, jump):
    """The derivative of a period's map, by SciPy from surface to surface, with the saltation matrix of each.

    ``smooth(t, x, sides)`` is the rate on the sides of the surfaces, ``jump`` whether the rates differ on them.
    """
    n = len(x)
    sides = [s(x) > 0 for s, _ in surfaces]
    t, end, phi = time, time + PERIOD, np.eye(n)

    def rate(t, y):
        out = np.empty((n, n + 1))
        out[:, 0] = smooth(t, y[:n], sides)
        step = 1e-6
        for k in range(n):
            e = step * np.eye(n)[k]
            out[:, 1 + k] = (smooth(t, y[:n] + e, sides) - smooth(t, y[:n] - e, sides)) / (2 * step)
        own = y[n:].reshape(n, n)
        return np.concatenate([out[:, 0], (out[:, 1:] @ own).ravel()])

    def event(i):
        def value(t, y):
            return surfaces[i][0](y[:n])

        value.terminal, value.direction = True, -1 if sides[i] else 1
        return value

    while t < end:
        y = np.concatenate([x, phi.ravel()])
        run = solve_ivp(rate, (t, end), y, "DOP853", rtol=1e-11, atol=1e-13, events=[event(i) for i in range(len(surfaces))])
        t, x, phi = run.t[-1], run.y[:n, -1], run.y[n:, -1].reshape(n, n)
        if run.status == 1:
            i = next(i for i in range(len(surfaces)) if len(run.t_events[i]))
            before = smooth(t, x, sides)
            sides[i] = not sides[i]
            after = smooth(t, x, sides)
            normal = surfaces[i][1]
            if jump:
                phi = (np.eye(n) + np.outer(after - before, normal) / (normal @ before)) @ phi
            # Off the surface, to the side that is entered.
            x, t = x + 1e-12 * before, t + 1e-12
    return phi


def is_right_or_unknown(orbit, expected, tolerance):
    """Multipliers are those, or none are given and why is said."""
    found = orbit.floquet_multipliers
    if found is None or not np.isfinite(found).all():
        assert orbit.is_stable is None
        assert "jumps" in orbit.stability.reason or "differences" in orbit.stability.reason
        return False
    expected = np.sort_complex(np.linalg.eigvals(expected))
    np.testing.assert_allclose(np.sort_complex(found), expected, atol=tolerance)
    return True


def test_a_force_that_jumps_has_no_multipliers_or_the_right_ones():
    """A spring with a damper that only pushes: the force is there at once when it is touched, and ends at zero."""

    def pushed(d, v):
        return max(10 * d + 2 * v, 0.0) if d > 0 else 0.0

    def acceleration(t, q, v):
        return np.array([-0.1 * v[0] - q[0] - pushed(q[0] - 0.5, v[0])])

    orbit = orbit_of(acceleration, periods=40)
    # By events and differences of SciPy, and by differences of runs.
    found = orbit.floquet_multipliers
    if found is not None:
        assert abs(np.prod(found) - 0.0805241) < 1e-5
    else:
        assert "the acceleration jumps" in orbit.stability.reason
        assert orbit.is_stable is None
    exponents = vi.lyapunov_exponents(orbit.scene, orbit.q0, orbit.v0, (0, 40 * PERIOD), skip=5 * PERIOD)
    if np.isfinite(exponents.exponents).any():
        np.testing.assert_allclose(exponents.exponents, np.log(0.0805241) / (2 * PERIOD), atol=2e-3)
    else:
        assert "the acceleration jumps" in exponents.message
        assert exponents.verdict == "undecided"


@pytest.mark.parametrize("seed", range(3))
def test_piecewise_linear_oscillators_are_known_by_saltation(seed):
    """Springs and dampers that set in at a place: of a spring the force is continuous, of a damper it jumps."""
    rng = np.random.default_rng(seed)
    at, k, c = rng.uniform(-0.5, 0.8), rng.uniform(0.5, 5.0), rng.uniform(0.05, 0.3)
    for damper in (0.0, rng.uniform(0.2, 1.0)):

        def smooth(t, x, sides, at=at, k=k, c=c, damper=damper):
            more = k * (x[0] - at) + damper * x[1] if sides[0] else 0.0
            return np.array([x[1], np.cos(W * t) - x[0] - c * x[1] - more])

        def acceleration(t, q, v, smooth=smooth, at=at):
            return smooth(t, np.array([q[0], v[0]]), [q[0] > at])[1:] - np.cos(W * t)

        orbit = orbit_of(acceleration)
        start = np.concatenate([orbit.q0, orbit.v0])
        surface = [(lambda x, at=at: x[0] - at, np.array([1.0, 0.0]))]
        expected = with_events(smooth, surface, start, orbit.phase / W, jump=True)
        is_known = is_right_or_unknown(orbit, expected, 2e-6)
        # A kink is no reason to say nothing.
        assert is_known or damper > 0.0


def test_jumps_in_time_alone_are_no_reason():
    def acceleration(t, q, v):
        return np.array([-q[0] - 0.2 * v[0] - 0.5 * q[0] ** 3 + (0.3 if (W * t) % (2 * np.pi) < 2.0 else -0.3)])

    orbit = orbit_of(acceleration)
    given = orbit_of(acceleration, jacobian=lambda t, q, v: np.array([[-1.0 - 1.5 * q[0] ** 2, -0.2]]))
    assert orbit.is_stable
    np.testing.assert_allclose(orbit.floquet_multipliers, given.floquet_multipliers, atol=1e-8)


@pytest.mark.parametrize("width", [1e-1, 1e-3, 1e-5, 1e-6, 1e-8])
def test_steep_friction_has_the_multipliers_of_its_own_jacobian(width):
    def acceleration(t, q, v):
        return -q - 0.1 * v - 0.3 * np.tanh(v / width)

    def jacobian(t, q, v):
        return np.array([[-1.0, -0.1 - 0.3 / width / np.cosh(np.minimum(np.abs(v[0] / width), 300.0)) ** 2]])

    # Deviations of the velocity nearly die where it turns.
    found, given = orbit_of(acceleration), orbit_of(acceleration, jacobian=jacobian)
    if width >= 1e-4:
        assert found.floquet_multipliers is not None
    for orbit in (found, given):
        if orbit.floquet_multipliers is None:
            assert orbit.stability.reason
            return
    # The product is exp(-int trace): what the width makes of the speed at which zero is passed is all that is left of it.
    np.testing.assert_allclose(found.floquet_multipliers, given.floquet_multipliers, atol=1e-6)


@pytest.mark.parametrize("seed", [0, 2])
def test_smooth_equations_stay_defined(seed):
    """Random smooth systems, stiff ones and such in small units among them: differences are right, and nothing is doubted."""
    rng = np.random.default_rng(100 + seed)
    n = int(rng.integers(1, 4))
    unit = 10.0 ** rng.integers(-3, 2)
    stiff = 10.0 ** rng.uniform(0, 2)
    a = rng.normal(size=(n, n))
    stiffness, damping = a @ a.T + np.diag(rng.uniform(0.5, stiff, n)), np.diag(rng.uniform(0.1, 0.5, n))
    cubic, bend = rng.uniform(0.0, 2.0) / unit**2, rng.uniform(0.5, 3.0) / unit

    def acceleration(t, q, v):
        return -stiffness @ q - damping @ v - cubic * q**3 - 0.2 * unit * np.sin(bend * q) - 0.1 * np.arctan(bend * v) * unit

    def jacobian(t, q, v):
        by_q = -stiffness - np.diag(3 * cubic * q**2 + 0.2 * unit * bend * np.cos(bend * q))
        return np.hstack([by_q, -damping - np.diag(0.1 * unit * bend / (1 + (bend * v) ** 2))])

    force = unit * rng.uniform(0.5, 2.0, n)
    found, given = (orbit_of(acceleration, n, own, force, periods=12) for own in (None, jacobian))
    assert found.floquet_multipliers is not None, found.stability.reason
    np.testing.assert_allclose(np.sort(np.abs(found.floquet_multipliers)), np.sort(np.abs(given.floquet_multipliers)), atol=2e-8)


# Jacobians that are given ----------------------------------------------------------------------------------------------


def accepted(acceleration, jacobian, q, v):
    system = vi.NonlinearSystem(1, acceleration, mass=1.0, jacobian=jacobian)
    scene = vi.Scene(system, vi.Harmonic([1.0], 0.7))
    return vi.simulate(scene, [q], [v], (0, 0.1), method="radau").status == "finished"


@pytest.mark.parametrize("width", [1.0, 0.1, 0.01, 1e-3, 1e-5])
@pytest.mark.parametrize("v", [0.0, 1e-6, 0.02, 0.5, -3.0])
def test_right_jacobians_are_taken(width, v):
    """Entries far below what a difference rounds to, at places where the force is flat or steep."""
    assert accepted(
        lambda t, q, v: -q - 0.3 * np.tanh(v / width),
        lambda t, q, v: np.array([[-1.0, -0.3 / width / np.cosh(np.minimum(np.abs(v[0] / width), 300.0)) ** 2]]),
        0.0,
        v,
    )
    assert accepted(
        lambda t, q, v: -q - np.exp((q - 1) / width) if width > 1e-3 else -q,
        lambda t, q, v: np.array([[-1.0 - (np.exp((q[0] - 1) / width) / width if width > 1e-3 else 0.0), 0.0]]),
        0.0,
        v,
    )


@pytest.mark.parametrize("side", [0.0, 1.0, 0.5])
@pytest.mark.parametrize("q", [0.0, 1e-13, -1e-9, 0.2, -0.2])
def test_jacobians_to_either_side_of_a_kink_are_right(side, q):
    """A spring that is touched at q = 0, and a damper that resists one way: at the kink each one-sided derivative is right."""

    def slope(x):
        return 1.0 if x > 0 else 0.0 if x < 0 else side

    assert accepted(
        lambda t, q, v: -5.0 * np.maximum(q, 0.0) - 2.0 * np.maximum(v, 0.0),
        lambda t, q, v: np.array([[-5.0 * slope(q[0]), -2.0 * slope(v[0])]]),
        q,
        0.0,
    )


@pytest.mark.parametrize("q", [0.0, 0.3])
def test_wrong_jacobians_are_refused(q):
    for wrong in ([[1.0, 0.0]], [[-1.0, -0.1]], [[-1.01, 0.0]], [[-1.0 - 1e-2, 1e-4]]):
        with pytest.raises(ValueError, match=r"jacobian\[0, [01]\] is .* but a difference gives"):
            accepted(lambda t, q, v: -q, lambda t, q, v, wrong=wrong: np.array(wrong), q, 0.5)
