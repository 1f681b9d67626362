"""Methods of integration: the same motion by each of them, chosen ones, wrong Jacobians, stiff scenes."""

import numpy as np
import pytest

import vibroimpact as vi

STEPS = ["rk45", "dop853", "radau"]


def duffing(cubic=1.0, damping=0.2, *, jacobian=None, stop=0.6, force=0.8):
    """An oscillator with a cubic spring against a stop."""
    system = vi.NonlinearSystem(1, lambda t, q, v: -q - cubic * q**3 - damping * v, mass=[[1.0]], jacobian=jacobian)
    stops = [] if stop is None else [vi.Stop(0, stop, 0.7)]
    return vi.Scene(system, vi.Harmonic([force], 1.3), stops)


def right(t, q, v):
    return [[-1 - 3 * q[0] ** 2, -0.2]]


@pytest.mark.parametrize("method", STEPS)
def test_methods_agree(method):
    truth = vi.simulate(duffing(), 0, 1.5, (0, 30), method="dop853", rtol=1e-13, atol=1e-15)
    assert len(truth.impacts) > 5
    for name, (q0, v0) in {"scalar": (0, 1.5), "array": ([0.0], [1.5])}.items():
        run = vi.simulate(duffing(), q0, v0, (0, 30), method=method, rtol=1e-9, atol=1e-12)
        assert run.status == "finished", name
        assert len(run.impacts) == len(truth.impacts)
        np.testing.assert_allclose(run.impacts["time"], truth.impacts["time"], atol=2e-6)
        np.testing.assert_allclose(run.final[0], truth.final[0], atol=2e-6)


def test_auto_takes_what_fits_and_says_so():
    tight = vi.simulate(duffing(), 0, 1.5, (0, 10))
    assert "steps of dop853" in tight.message
    assert "radau" not in tight.message
    loose = vi.simulate(duffing(), 0, 1.5, (0, 10), rtol=1e-6)
    assert "steps of rk45" in loose.message
    stiff = vi.simulate(duffing(1e6, 2e3, stop=0.3), 0, 1.0, (0, 20), rtol=1e-6, atol=1e-9)
    assert "from t =" in stiff.message
    assert "radau" in stiff.message
    assert stiff.status == "finished"
    assert "of rk45" not in vi.simulate(duffing(), 0, 1.5, (0, 10), method="rk45").message


def test_an_implicit_method_takes_few_steps_where_the_motion_is_stiff():
    scene = duffing(1e4, 1e4, stop=0.02, force=50.0)
    explicit = vi.simulate(scene, 0, 0, (0, 5), method="rk45", rtol=1e-6, atol=1e-9)
    implicit = vi.simulate(scene, 0, 0, (0, 5), method="radau", rtol=1e-6, atol=1e-9)
    assert 10 * implicit.stats.n_steps < explicit.stats.n_steps
    np.testing.assert_allclose(implicit.final[0], explicit.final[0], rtol=1e-4, atol=1e-7)


def test_a_jacobian_that_is_given_is_used_and_refused_where_it_is_none():
    by_differences = vi.simulate(duffing(), 0, 1.5, (0, 30), method="radau")
    given = vi.simulate(duffing(jacobian=right), 0, 1.5, (0, 30), method="radau")
    assert given.stats.n_rhs < by_differences.stats.n_rhs
    np.testing.assert_allclose(given.final[0], by_differences.final[0], atol=1e-7)
    for wrong, words in [
        (lambda t, q, v: [[1.0]], "shape|jacobian"),
        (lambda t, q, v: [[np.nan, 0.0]], "finite|jacobian"),
        (lambda t, q, v: [[5.0, -0.2]], r"jacobian\[0, 0\]"),
    ]:
        with pytest.raises(ValueError, match=words):
            vi.simulate(duffing(jacobian=wrong), 0, 1.5, (0, 30), method="radau")


@pytest.mark.parametrize("method", STEPS)
def test_a_motion_that_cannot_go_on_ends(method):
    def blows_up(t, q, v):
        return q**3

    run = vi.simulate(vi.Scene(vi.NonlinearSystem(1, blows_up)), 1.0, 1.0, (0, 10), method=method)
    assert run.status == "step_underflow"
    assert 0 < run.t_end < 3


def test_the_names_of_methods_are_told():
    for name in ("rk4", "Radau5", ""):
        with pytest.raises(ValueError, match='"auto", "exact", "taylor", "rk45", "dop853", "radau"'):
            vi.simulate(duffing(), 0, 1.5, (0, 1), method=name)
    for name in ("DOP853", "Radau", "rAdAu"):
        assert vi.simulate(duffing(), 0, 1.5, (0, 1), method=name).status == "finished"


@pytest.mark.parametrize("method", STEPS)
def test_ensembles_take_every_method(method):
    scene = duffing()
    q0, v0 = np.zeros((5, 1)), np.linspace(0.5, 1.5, 5)[:, None]
    ends = vi.simulate_many(scene, q0, v0, (0, 10), method=method)
    for i in range(5):
        run = vi.simulate(scene, q0[i], v0[i], (0, 10), method=method)
        assert ends.q[i] == run.final[0]
        assert ends.v[i] == run.final[1]


def stiff_pair(mass):
    """Two masses with a cubic spring, 1e6 times as stiff as the linear one, and a damper between them."""

    def acceleration(t, q, v):
        with np.errstate(over="ignore", invalid="ignore"):
            stretch = q[1] - q[0]
            force = 2e3 * (v[1] - v[0]) + stretch + 1e6 * stretch**3
            return [10 * (force - q[0] - 0.02 * v[0]), -force]

    system = vi.NonlinearSystem(2, acceleration, mass=mass)
    return vi.Scene(system, vi.Harmonic([1.0, 0.5], 0.6), vi.Stop(1, 0.3, 0.7))


@pytest.mark.parametrize("method", STEPS)
def test_a_step_whose_stages_overflow_is_refused(method):
    run = vi.simulate(stiff_pair([[0.1, 0], [0, 1]]), [0, 0], [0.3, 0.3], (0, 0.1), method=method, rtol=1e-3, atol=1e-4)
    assert run.status == "finished"


def test_an_acceleration_that_is_no_number_from_some_time_on_is_an_error():
    system = vi.NonlinearSystem(1, lambda t, q, v: np.nan if t > 1 else -q)
    for method in STEPS:
        with pytest.raises(ValueError, match=r"acceleration\[0\] at t = 1.*is NaN"):
            vi.simulate(vi.Scene(system), 0.0, 1.0, (0, 2), method=method)


@pytest.mark.parametrize("method", STEPS)
def test_a_constant_mass_is_that_of_a_function(method):
    mass = np.array([[0.1, 0.01], [0.01, 1.0]])
    runs = [vi.simulate(stiff_pair(m), [0, 0], [0.3, 0.3], (0, 3), method=method, rtol=1e-8) for m in (mass, lambda q: mass)]
    assert len(runs[0].impacts) == len(runs[1].impacts) > 0
    assert np.allclose(runs[0].final, runs[1].final, atol=1e-8)
