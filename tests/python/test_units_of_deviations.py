"""First deviations from a motion in other units: with lengths times L and times times S they are the same numbers."""

import numpy as np
import pytest

import vibroimpact as vi

UNITS = [(1e-6, 1.0), (1.0, 1e-6), (1e3, 1e-3), (1e-6, 1e3), (1e-9, 1e-9)]


def bent(length, time, restitution=0.6, has_jacobian=False):
    """Own equations that bend over `length`, before a stop."""

    def acceleration(t, q, v):
        return (-2.0 * q - 0.5 * length * np.tanh(q / length)) / time**2 - 0.2 * v / time

    def jacobian(t, q, v):
        return np.array([[(-2.0 - 0.5 / np.cosh(q[0] / length) ** 2) / time**2, -0.2 / time]])

    system = vi.NonlinearSystem(1, acceleration, mass=1.0, jacobian=jacobian if has_jacobian else None)
    return vi.Scene(system, vi.Harmonic([2.0 * length / time**2], 1.3 / time), vi.Stop(0, 0.3 * length, restitution))


def rates(length, time, **options):
    """Derivatives of the last state in units of it, by clearance in units of length and by restitution."""
    scene = bent(length, time, **options)
    run = vi.simulate(scene, 0.0, 0.5 * length / time, (0, 6 * time), derivatives=["clearance", "restitution"])
    size = np.array([length, length / time])
    return np.concatenate([run.derivatives["clearance"] * length / size, run.derivatives["restitution"] / size])


@pytest.mark.parametrize("has_jacobian", [False, True])
@pytest.mark.parametrize("restitution", [0.6, 0.0])
def test_derivatives_of_runs_of_own_equations(restitution, has_jacobian):
    usual = rates(1.0, 1.0, restitution=restitution, has_jacobian=has_jacobian)
    # Central differences of runs, which know nothing of deviations.
    scene = bent(1.0, 1.0, restitution)

    def final(clearance):
        there = scene.replace(clearance=clearance)
        return np.concatenate(vi.simulate(there, 0.0, 0.5, (0, 6), rtol=1e-12, atol=1e-14).final)

    h = 1e-4
    by_runs = (8 * (final(0.3 + h) - final(0.3 - h)) - final(0.3 + 2 * h) + final(0.3 - 2 * h)) / (12 * h)
    np.testing.assert_allclose(usual[:2], by_runs, atol=1e-7 * abs(by_runs).max())
    for units in UNITS[:1] + UNITS[3:4]:
        found = rates(*units, restitution=restitution, has_jacobian=has_jacobian)
        np.testing.assert_allclose(found, usual, atol=1e-7 * abs(usual).max(), err_msg=str(units))


def test_derivatives_end_where_own_equations_jump():
    """A force that jumps with the speed: what deviations become there is not in its derivatives."""
    system = vi.NonlinearSystem(1, lambda t, q, v: -q - 0.3 * np.sign(v), mass=1.0)
    scene = vi.Scene(system, None, vi.Stop(0, 3.0, 0.6))
    # From 2 it turns some pi later on the other side, where the force jumps.
    run = vi.simulate(scene, 2.0, -0.1, (0.0, 4.0), derivatives=["restitution"], t_eval=[1.0, 3.0, 3.5])
    found = run.derivatives["restitution"]
    assert (found[:2] == 0.0).all()
    assert np.isnan(found[2]).all()


def around(length, time):
    """Two masses of own equations before a circle."""
    middle, radius = np.array([-1.4, 0.2]) * length, 2.0 * length
    stiffness = np.array([[2.0, 0.3], [0.3, 3.0]]) / time**2

    def acceleration(t, q, v):
        bent = np.array([0.5 * length * np.tanh(q[0] / length) / time**2, 0.0])
        return -stiffness @ q - np.array([0.2, 0.3]) / time * v - bent

    stop = vi.NonlinearStop(
        lambda q: radius - np.hypot(*(q - middle)), lambda q: -(q - middle) / np.hypot(*(q - middle)), restitution=0.6
    )
    forcing = vi.Harmonic(np.array([2.0, 1.0]) * length / time**2, 1.3 / time)
    return vi.Scene(vi.NonlinearSystem(2, acceleration, mass=np.eye(2)), forcing, stop)


def test_multipliers_before_a_curved_stop():
    found = []
    for length, time in [(1.0, 1.0), (1e-6, 1e-5)]:
        scene = around(length, time)
        run = vi.simulate(scene, np.zeros(2), np.zeros(2), (0, 20 * scene.period))
        found.append(np.sort_complex(vi.find_orbit(scene, run).floquet_multipliers))
    np.testing.assert_allclose(found[1], found[0], atol=1e-7)


def branch(length, time):
    """A branch through impacts that accumulate, over the force."""
    system = vi.LinearSystem(1.1764011, 0.14596087 / time, 0.96887474 / time**2)
    stops = [
        vi.Stop(0, -0.23140174764128318 * length, 0.0),
        vi.Stop(0, 0.46533818555736994 * length, 0.11135343772958693, side="lower"),
    ]
    scene = vi.Scene(system, vi.Harmonic([1.28445162 * length / time**2], 1.513921135934145 / time), stops)
    run = vi.simulate(scene, [-0.24 * length], [0.0], (0, 60 * scene.period))
    return vi.continuation(vi.find_orbit(scene, run), "forcing_scale", (0.3, 2.0), max_points=300)


def test_branches_through_accumulating_impacts():
    usual = branch(1.0, 1.0)
    # Between 0.7811 and 0.7812 the contact with the lower stop vanishes, by flights between bisected impacts.
    assert [one.kind for one in usual.special] == ["chatter_border"]
    assert 0.7811 < usual.special[0].parameter < 0.7812
    for units in [*UNITS, (1e-10, 1.0), (1e6, 1e-3)]:
        other = branch(*units)
        assert len(other) == len(usual), units
        assert [one.kind for one in other.special] == ["chatter_border"], units
        assert abs(other.special[0].parameter - usual.special[0].parameter) < 1e-8, units


def test_orbits_have_no_derivatives_where_own_equations_jump():
    system = vi.NonlinearSystem(1, lambda t, q, v: -q - 0.1 * v - 0.3 * np.sign(v), mass=1.0)
    scene = vi.Scene(system, vi.Harmonic([2.0], 1.3), vi.Stop(0, 1.0, 0.6))
    run = vi.simulate(scene, 0.0, 0.1, (0, 60 * scene.period))
    found = vi.find_orbit(scene, run).derivatives(["forcing_scale"])
    assert "jumps" in found.reason
    assert np.isnan(found.q0).all()
