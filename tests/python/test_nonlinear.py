"""Systems and stops given by functions, in Python or in C: the same laws, errors that come out as themselves."""

import ctypes
import pickle
import signal
import threading
import time
import traceback

import numpy as np
import pytest
from scipy import LowLevelCallable
from scipy.integrate import solve_ivp

import vibroimpact as vi

POINTER = ctypes.POINTER(ctypes.c_double)
PROTOTYPE = ctypes.CFUNCTYPE(None, ctypes.c_double, POINTER, POINTER, POINTER, POINTER)


def duffing(t, q, v):
    return -q - q**3


def sprung(t, q, v, parameters):
    stiffness, damping = parameters
    return -stiffness * q - damping * v


def unit_mass(q):
    return np.eye(1)


def circle(q):
    return 1.0 - q @ q


def circle_gradient(q):
    return -2.0 * q


def still(t, q, v):
    return np.zeros_like(q)


def free(n):
    """Points without any force."""
    return vi.LinearSystem(np.ones(n), np.zeros(n), np.zeros(n))


@PROTOTYPE
def sprung_in_c(t, q, v, a, parameters):
    a[0] = -parameters[0] * q[0] - parameters[1] * v[0]


@PROTOTYPE
def duffing_in_c(t, q, v, a, parameters):
    assert not parameters
    a[0] = -q[0] - q[0] ** 3


class Cfunc:
    """What a numba cfunc shows of itself."""

    def __init__(self, function):
        self.ctypes = function
        self.address = ctypes.cast(function, ctypes.c_void_p).value

    def __call__(self, *arguments):
        raise AssertionError("the Python function behind a C function is not called")


# the double pendulum of eq. (3), written down once more ----------------------------------------------------------------


def pendulum(m, mu, damping, force):
    alpha = m / (1 + m) / mu

    def mass(q):
        cos = np.cos(q[0] - q[1])
        return np.array([[1.0, alpha * cos], [alpha * cos, alpha / mu]])

    def acceleration(t, q, v):
        sin = np.sin(q[0] - q[1])
        push = force(t)
        f = [
            push * np.cos(q[0]) - np.sin(q[0]) / (1 + m) - alpha * sin * v[1] ** 2,
            alpha * (push * np.cos(q[1]) - np.sin(q[1]) / (1 + m) + sin * v[0] ** 2),
        ]
        return np.linalg.solve(mass(q), f - damping @ v)

    return acceleration, mass


def reference(acceleration, mass, gap, gradient, e, state, end):
    """DOP853 from impact to impact, restarted at every one."""
    t, x, times = 0.0, np.array(state, dtype=float), []

    def rhs(t, x):
        return np.concatenate([x[2:], acceleration(t, x[:2], x[2:])])

    def event(t, x):
        return gap(x[:2])

    event.terminal, event.direction = True, -1
    while True:
        step = solve_ivp(rhs, (t, end), x, "DOP853", events=event, rtol=1e-13, atol=1e-14, max_step=0.05)
        t, x = step.t[-1], step.y[:, -1]
        if step.status == 0:
            return x, times
        times.append(t)
        n = -gradient(x[:2])
        b = np.linalg.solve(mass(x[:2]), n)
        x = np.concatenate([x[:2], x[2:] - b * (1 + e) * (n @ x[2:]) / (n @ b)])


def test_driven_pendulums_on_a_wall_are_those_of_an_independent_integration():
    m, mu, e, position = 0.8, 1.3, 0.7, 0.25
    amplitude, frequency, phase = 0.3, 1.1, 0.5
    damping = np.array([[0.03, -0.01], [-0.01, 0.01]])
    acceleration, mass = pendulum(m, mu, damping, lambda t: amplitude * frequency**2 * np.cos(frequency * t + phase))

    def gap(q):
        return position - np.sin(q[0]) - np.sin(q[1]) / mu

    def gradient(q):
        return np.array([-np.cos(q[0]), -np.cos(q[1]) / mu])

    q0, v0, end = [-0.9, -0.4], [0.2, 0.6], 15.0
    x, times = reference(acceleration, mass, gap, gradient, e, [*q0, *v0], end)
    assert len(times) > 2
    base = vi.BaseMotion(amplitude, frequency, phase)
    wall, curved = vi.Wall(1, position, e), vi.NonlinearStop(gap, gradient, e)
    ours = vi.DoublePendulum(m, mu, damping)
    given = vi.NonlinearSystem(2, acceleration, mass=mass)
    for scene in (vi.Scene(ours, base, wall), vi.Scene(ours, base, curved), vi.Scene(given, None, curved)):
        run = vi.simulate(scene, q0, v0, (0, end), rtol=1e-11, atol=1e-13)
        assert run.status == "finished"
        np.testing.assert_allclose(run.impacts["time"], times, atol=2e-9)
        np.testing.assert_allclose(np.concatenate(run.final), x, atol=2e-8)


# functions in Python and in C -------------------------------------------------------------------------------------------


def test_python_and_c_functions_move_a_linear_oscillator_as_the_linear_system_does():
    numbers = [4.0, 0.1]
    stop = vi.Stop(0, 0.3, 0.8)
    force = vi.Harmonic(1.0, 1.7, 0.3)
    exact = vi.simulate(vi.Scene(vi.LinearSystem(1.0, 0.1, 4.0), force, stop), 0.0, 1.0, (0, 30))
    assert len(exact.impacts) > 5
    finals = []
    for function in (sprung, sprung_in_c, Cfunc(sprung_in_c), LowLevelCallable(sprung_in_c)):
        if isinstance(function, LowLevelCallable):
            # a ctypes function given to scipy carries its signature there
            assert "double" in function.signature
        system = vi.NonlinearSystem(1, function, mass=1.0, parameters=numbers)
        run = vi.simulate(vi.Scene(system, force, stop), 0.0, 1.0, (0, 30), rtol=1e-11, atol=1e-13)
        np.testing.assert_allclose(run.impacts["time"], exact.impacts["time"], atol=1e-8)
        np.testing.assert_allclose(run.final, exact.final, atol=1e-8)
        finals.append(np.concatenate(run.final))
    assert all((final == finals[0]).all() for final in finals)


def test_a_c_function_has_a_null_pointer_where_there_are_no_parameters():
    scene = vi.Scene(vi.NonlinearSystem(1, duffing_in_c, mass=1.0), stops=vi.Stop(0, 0.5, 1.0))
    python = vi.Scene(vi.NonlinearSystem(1, duffing, mass=1.0), stops=vi.Stop(0, 0.5, 1.0))
    one, other = (vi.simulate(s, 0.0, 1.0, (0, 10)) for s in (scene, python))
    np.testing.assert_allclose(one.impacts["speed_before"], np.sqrt(1 - 0.25 - 0.03125), rtol=1e-8)
    np.testing.assert_allclose(one.final, other.final, rtol=1e-12)


def test_c_functions_of_another_signature_are_refused():
    wrong = ctypes.CFUNCTYPE(None, ctypes.c_double, POINTER)(lambda t, q: None)
    returns = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double, POINTER, POINTER, POINTER, POINTER)(lambda *a: 0.0)
    for function in (wrong, returns, Cfunc(wrong), LowLevelCallable(wrong)):
        with pytest.raises(ValueError, match="const double \\*parameters"):
            vi.NonlinearSystem(1, function)
    with pytest.raises(ValueError, match="null pointer"):
        vi.NonlinearSystem(1, PROTOTYPE(0))
    with pytest.raises(TypeError, match="CFUNCTYPE"):
        vi.NonlinearSystem(1, ctypes.cast(sprung_in_c, ctypes.c_void_p).value)
    with pytest.raises(ValueError, match="parameters"):
        vi.NonlinearSystem(1, sprung_in_c, parameters={"stiffness": 1.0})


def test_functions_are_given_fresh_read_only_arrays():
    seen = []

    def watched(t, q, v):
        assert type(t) is float
        for x in (q, v):
            assert x.dtype == float
            assert x.shape == (2,)
            assert not x.flags.writeable
            with pytest.raises(ValueError, match="read-only"):
                x[0] = 1.0
        seen.append((q, q.copy()))
        return [-1.0, 2]

    run = vi.simulate(vi.Scene(vi.NonlinearSystem(2, watched)), [0, 0], [0, 1], (0, 1))
    np.testing.assert_allclose(run.final[0], [-0.5, 2.0])
    assert len(seen) == run.stats.n_rhs
    assert all((q == kept).all() for q, kept in seen)


# errors ----------------------------------------------------------------------------------------------------------------


class Own(Exception):
    pass


@pytest.mark.parametrize("where", ["acceleration", "mass", "gap", "gradient"])
def test_an_exception_of_a_function_comes_out_as_itself(where):
    calls = []
    raised = Own("in the function")

    def failing(result):
        def function(*arguments):
            calls.append(arguments)
            if len(calls) > 3:
                raise raised
            return result(arguments)

        return function

    functions = {
        "acceleration": lambda a: np.zeros(2),
        "mass": lambda a: np.eye(2),
        "gap": lambda a: circle(a[0]),
        "gradient": lambda a: circle_gradient(a[0]),
    }
    functions[where] = failing(functions[where])

    def spread(function):
        return lambda *arguments: function(arguments)

    plain = {name: f if name == where else spread(f) for name, f in functions.items()}
    system = vi.NonlinearSystem(2, plain["acceleration"], mass=plain["mass"])
    stop = vi.NonlinearStop(plain["gap"], plain["gradient"], 1.0)
    with pytest.raises(Own) as caught:
        vi.simulate(vi.Scene(system, stops=stop), [0.0, 0.1], [1.0, 0.0], (0, 50))
    assert caught.value is raised
    assert [frame.name for frame in traceback.extract_tb(raised.__traceback__)][-1] == "function"


@pytest.mark.parametrize(
    ("result", "message"),
    [
        (lambda q: np.zeros(3), r"result of acceleration at t = 0.*shape \(3,\).*\(2,\) is needed"),
        (lambda q: 0.0, r"result of acceleration at t = 0.*\(2,\) is needed"),
        (lambda q: np.zeros((2, 2)), "result of acceleration has shape"),
        (lambda q: "fast", "result of acceleration is 'fast'"),
        (lambda q: [np.nan, 0.0], r"acceleration\[0\] at t = 0 is NaN, but it must be finite"),
        (lambda q: [0.0, -np.inf], r"acceleration\[1\] at t = 0 is -inf, but it must be finite"),
    ],
)
def test_a_wrong_result_names_the_function_the_time_and_the_rule(result, message):
    scene = vi.Scene(vi.NonlinearSystem(2, lambda t, q, v: result(q)))
    with pytest.raises(ValueError, match=message):
        vi.simulate(scene, [0, 0], [0, 0], (0, 1))


def test_wrong_results_of_the_other_functions():
    point = vi.NonlinearSystem(2, still, mass=lambda q: np.eye(3))
    with pytest.raises(ValueError, match=r"result of mass at q = .*\(2, 2\) is needed"):
        vi.simulate(vi.Scene(point, vi.Harmonic([1, 0], 1.0)), [0, 0], [0, 0], (0, 1))
    with pytest.raises(ValueError, match=r"gap at q = .* is NaN, but it must be finite"):
        vi.Scene(free(2), stops=vi.NonlinearStop(lambda q: np.nan, circle_gradient, 1.0)).gaps([0, 0])
    scene = vi.Scene(free(2), stops=vi.NonlinearStop(circle, lambda q: q[:1], 1.0))
    with pytest.raises(ValueError, match=r"result of gradient at q = .*shape"):
        vi.simulate(scene, [0, 0], [1, 0], (0, 1))
    with pytest.raises(ValueError, match="mass is not symmetric"):
        vi.NonlinearSystem(2, still, mass=[[1, 0.1], [0, 1]])
    with pytest.raises(ValueError, match="mass is not positive definite"):
        vi.NonlinearSystem(2, still, mass=[[1, 2], [2, 1]])
    with pytest.raises(ValueError, match=r"mass has shape \(3, 3\)"):
        vi.NonlinearSystem(2, still, mass=np.eye(3))
    with pytest.raises(ValueError, match="n_dof is 0"):
        vi.NonlinearSystem(0, still)
    for arguments in ((2, "still"), (2, None)):
        with pytest.raises(TypeError, match="a function is needed"):
            vi.NonlinearSystem(*arguments)
    with pytest.raises(TypeError, match="jacobian is 3, but a function is needed"):
        vi.NonlinearSystem(2, still, jacobian=3)
    with pytest.raises(TypeError, match=r"gap is 1\.0, but a function is needed"):
        vi.NonlinearStop(1.0, circle_gradient, 1.0)
    with pytest.raises(ValueError, match=r"curvature is -1, but"):
        vi.NonlinearStop(circle, circle_gradient, 1.0, curvature=-1)
    with pytest.raises(ValueError, match=r"restitution is 2"):
        vi.NonlinearStop(circle, circle_gradient, 2)


def test_what_a_scene_needs_of_a_nonlinear_system_is_said_when_it_is_made():
    bare = vi.NonlinearSystem(2, still)
    for stop in (vi.Stop(0, 1.0, 1.0), vi.NonlinearStop(circle, circle_gradient, 1.0)):
        with pytest.raises(ValueError, match=r'stops\[0\].reaction is "inertia".*give it `mass`'):
            vi.Scene(bare, stops=stop)
    with pytest.raises(ValueError, match="a harmonic force needs the mass matrix"):
        vi.Scene(bare, vi.Harmonic([1, 0], 1.0))
    with pytest.raises(ValueError, match="a base motion"):
        vi.Scene(vi.NonlinearSystem(2, still, mass=np.eye(2)), vi.BaseMotion(1.0, 1.0))
    with pytest.raises(ValueError, match="a wall"):
        vi.Scene(bare, stops=vi.Wall(0, 1.0, 1.0))
    with pytest.raises(ValueError, match="reaction"):
        vi.Scene(free(2), stops=vi.NonlinearStop(circle, circle_gradient, 1.0, reaction=[1.0]))
    with pytest.raises(ValueError, match="no damping matrix to scale"):
        vi.Scene(bare).replace(damping_scale=2.0)
    with pytest.raises(ValueError, match="needs the mass matrix"):
        bare.linearise()
    # Other reactions need no mass.
    scene = vi.Scene(bare, stops=vi.Stop(0, 1.0, 0.5, reaction="coordinate"))
    run = vi.simulate(scene, [0, 0], [1, 2], (0, 3))
    np.testing.assert_allclose(run.final[1], [-0.5, 2.0])


def test_ctrl_c_ends_a_run_inside_a_slow_function():
    def slow(t, q, v):
        time.sleep(0.002)
        return -q

    scene = vi.Scene(vi.NonlinearSystem(1, slow))
    alarm = threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT))
    alarm.start()
    with pytest.raises(KeyboardInterrupt):
        vi.simulate(scene, 1.0, 0.0, (0, 1e6))
    alarm.join()


# nonlinear stops -------------------------------------------------------------------------------------------------------


def test_a_point_in_a_circle_bounces_along_chords_of_one_length():
    # Elastic: every chord has the length of the first, 2 |cos| of the angle of impact, and the angular momentum is kept.
    scene = vi.Scene(free(2), stops=vi.NonlinearStop(circle, circle_gradient, 1.0))
    q0, v0 = np.array([0.6, 0.0]), np.array([0.3, 1.1])
    run = vi.simulate(scene, q0, v0, (0, 60), rtol=1e-11, atol=1e-13)
    momentum, speed = q0[0] * v0[1] - q0[1] * v0[0], np.linalg.norm(v0)
    chord = 2 * np.sqrt(1 - (momentum / speed) ** 2)
    assert len(run.impacts) > 30
    np.testing.assert_allclose(np.diff(run.impacts["time"]), chord / speed, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(run.final[1]), speed, rtol=1e-10)
    # The normal speed is that of the gap, 2 |q| v_n.
    np.testing.assert_allclose(run.impacts["speed_before"], chord * speed, rtol=1e-9)
    assert scene.gaps(run.q).min() > -1e-9
    assert "stop 0 is not certain" in run.message
    bounded = vi.NonlinearStop(circle, circle_gradient, 1.0, curvature=2.0)
    sure = vi.simulate(vi.Scene(free(2), stops=bounded), q0, v0, (0, 60), rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(sure.impacts["time"], run.impacts["time"], atol=1e-9)
    assert "certain" not in sure.message


def test_a_plane_given_as_a_nonlinear_stop_is_a_plane_stop():
    normal, clearance = np.array([1.0, -0.5]), 0.4
    plane = vi.Stop(normal, clearance, 0.8)
    given = vi.NonlinearStop(lambda q: clearance - normal @ q, lambda q: -normal, 0.8)
    system = vi.LinearSystem([[2, 0.3], [0.3, 1]], [[0.1, 0], [0, 0.1]], [[4, -1], [-1, 2]])
    force = vi.Harmonic([3.0, 0.3], 1.3)
    one = vi.simulate(vi.Scene(system, force, plane), [0, 0], [0, 1], (0, 20), method="rk45", rtol=1e-11)
    other = vi.simulate(vi.Scene(system, force, given), [0, 0], [0, 1], (0, 20), rtol=1e-11)
    assert len(one.impacts) > 3
    np.testing.assert_allclose(other.impacts["time"], one.impacts["time"], atol=1e-9)
    np.testing.assert_allclose(other.impacts["impulse"], one.impacts["impulse"], atol=1e-9)
    assert "certain" not in one.message
    linear = vi.Scene(system, force, given).linearise()
    assert linear == vi.Scene(system, force, vi.Stop(normal, clearance, 0.8))


@pytest.mark.parametrize("depth", [1e-2, 1e-3])
def test_a_shallow_contact_between_two_steps_is_found(depth):
    # A free point crosses the edge of a disc by the given depth: a short part of a path of 200, with no step end near.
    def gap(q):
        return q[0] ** 2 + q[1] ** 2 - 1.0

    stop = vi.NonlinearStop(gap, lambda q: 2 * q, 1.0)
    run = vi.simulate(vi.Scene(free(2), stops=stop), [-100.0, 1 - depth], [1.0, 0.0], (0, 200))
    assert len(run.impacts) == 1
    assert run.impacts["time"][0] == pytest.approx(100 - np.sqrt(1 - (1 - depth) ** 2), abs=1e-6)
    over = vi.simulate(vi.Scene(free(2), stops=stop), [-100.0, 1 + depth], [1.0, 0.0], (0, 200))
    assert len(over.impacts) == 0


@pytest.mark.parametrize("width", [2.0, 0.1])
def test_a_curvature_finds_a_spike_far_narrower_than_a_step(width):
    def gap(q):
        return q[1] - np.exp(-((q[0] / width) ** 2))

    def gradient(q):
        x = q[0] / width
        return np.array([2 * x / width * np.exp(-(x**2)), 1.0])

    stop = vi.NonlinearStop(gap, gradient, 0.5, curvature=2 / width**2)
    run = vi.simulate(vi.Scene(free(2), stops=stop), [-50.0, 0.5], [1.0, 0.0], (0, 100))
    assert run.impacts["time"][0] == pytest.approx(50 - width * np.sqrt(np.log(2)), abs=1e-6)
    assert "certain" not in run.message
    over = vi.simulate(vi.Scene(free(2), stops=stop), [-50.0, 1 + 1e-3], [1.0, 0.0], (0, 100))
    assert len(over.impacts) == 0


def test_reactions_of_a_nonlinear_stop():
    mass = np.array([[2.0, 0.5], [0.5, 1.0]])
    system = vi.LinearSystem(mass, np.zeros((2, 2)), np.zeros((2, 2)))
    v0 = np.array([1.0, 0.2])
    for reaction, direction in (("inertia", None), ("coordinate", None), ([1.0, 0.0], np.array([1.0, 0.0]))):
        stop = vi.NonlinearStop(circle, circle_gradient, 0.5, reaction=reaction)
        run = vi.simulate(vi.Scene(system, stops=stop), [0, 0], v0, (0, 1.2))
        assert len(run.impacts) == 1
        n = 2 * run.position(run.impacts["time"][0])
        b = {"inertia": np.linalg.solve(mass, n), "coordinate": n}.get(str(reaction), direction)
        np.testing.assert_allclose(run.final[1], v0 - b * 1.5 * (n @ v0) / (n @ b), rtol=1e-8)


# what they are ----------------------------------------------------------------------------------------------------------


def test_linearise_finds_the_linear_part():
    m, c, k = np.array([[2, 0.5], [0.5, 1]]), np.array([[0.3, -0.1], [-0.1, 0.2]]), np.array([[5, -2], [-2, 3]])

    def acceleration(t, q, v):
        return -np.linalg.solve(m, k @ q + c @ v + 3 * q**3 + v * np.abs(v) ** 3)

    def jacobian(t, q, v):
        return -np.linalg.solve(m, np.hstack([k + 9 * np.diag(q**2), c + 4 * np.diag(np.abs(v) ** 3)]))

    for system in (
        vi.NonlinearSystem(2, acceleration, mass=m),
        vi.NonlinearSystem(2, acceleration, mass=lambda q: m, jacobian=jacobian),
    ):
        linear = system.linearise()
        np.testing.assert_allclose(linear.mass, m)
        np.testing.assert_allclose(linear.damping, c, atol=1e-10)
        np.testing.assert_allclose(linear.stiffness, k, atol=1e-10)
    scene = vi.Scene(system, vi.Harmonic([1, 0], 1.0), vi.Stop(0, 0.1, 0.9)).linearise()
    assert scene.stops == (vi.Stop(0, 0.1, 0.9),)
    assert scene.forcing == vi.Harmonic([1, 0], 1.0)
    with pytest.raises(ValueError, match="must be an equilibrium"):
        vi.NonlinearSystem(1, lambda t, q, v: 1 - q, mass=1.0).linearise()
    with pytest.raises(ValueError, match="must be an equilibrium at all times"):
        vi.NonlinearSystem(1, lambda t, q, v: np.sin(t) - q, mass=1.0).linearise()
    with pytest.raises(vi.ConvergenceError, match="jacobian"):
        vi.NonlinearSystem(1, lambda t, q, v: -q - np.sign(v), mass=1.0).linearise()
    with pytest.raises(ValueError, match=r"result of jacobian .*\(2, 4\) is needed"):
        vi.NonlinearSystem(2, still, mass=m, jacobian=lambda t, q, v: np.eye(2)).linearise()


def test_equality_repr_and_parts():
    system = vi.NonlinearSystem(1, sprung, mass=unit_mass, parameters=[4.0, 0.1])
    assert system == vi.NonlinearSystem(1, sprung, mass=unit_mass, parameters=[4.0, 0.1])
    assert system != vi.NonlinearSystem(1, sprung, mass=unit_mass, parameters=[4.0, 0.2])
    assert system != vi.NonlinearSystem(1, sprung, mass=1.0, parameters=[4.0, 0.1])
    assert system != vi.NonlinearSystem(1, lambda *a: sprung(*a), mass=unit_mass, parameters=[4.0, 0.1])
    arrays = [vi.NonlinearSystem(1, sprung, parameters=np.array([4.0, x])) for x in (0.1, 0.1, 0.3)]
    assert arrays[0] == arrays[1]
    assert arrays[0] != arrays[2]
    assert repr(system) == "NonlinearSystem(n_dof=1, acceleration=sprung, mass=unit_mass, parameters)"
    assert "in C, mass (1, 1)" in repr(vi.NonlinearSystem(1, sprung_in_c, mass=1.0))
    assert system.acceleration is sprung
    assert system.mass is unit_mass
    assert system.parameters == [4.0, 0.1]
    assert system.jacobian is None
    assert system.potential is None
    assert system.n_dof == 1
    stop = vi.NonlinearStop(circle, circle_gradient, 0.9, curvature=2.0)
    assert stop == vi.NonlinearStop(circle, circle_gradient, 0.9, curvature=2.0)
    assert stop != vi.NonlinearStop(circle, circle_gradient, 0.8, curvature=2.0)
    assert stop != vi.NonlinearStop(circle, circle_gradient, 0.9)
    assert stop != vi.NonlinearStop(lambda q: circle(q), circle_gradient, 0.9, curvature=2.0)
    assert repr(stop) == "NonlinearStop(circle, circle_gradient, restitution=0.9, curvature=2, reaction='inertia')"
    assert stop.gap is circle
    assert stop.gradient is circle_gradient
    scene = vi.Scene(free(2), stops=[vi.Stop(0, 2.0, 0.5), stop])
    assert scene.stops[1] == stop
    np.testing.assert_allclose(scene.gaps([[0.6, 0.0], [0.0, 0.0]]), [[1.4, 0.64], [2.0, 1.0]])
    with pytest.raises(ValueError, match="a nonlinear stop has a gap function"):
        scene.replace(clearance=0.1)
    assert scene.replace(restitution=0.3).stops[1].restitution == 0.3
    assert "nonlinear scene" in scene.plan()
    for purpose in (lambda: vi.periodic_orbits(scene, [0]), lambda: vi.simulate(scene, [0, 0], [0, 0], (0, 1), method="exact")):
        with pytest.raises(ValueError, match="a scene with a nonlinear stop"):
            purpose()


def test_what_pickles_and_what_cannot():
    system = vi.NonlinearSystem(1, sprung, mass=unit_mass, parameters=[4.0, 0.1])
    stop = vi.NonlinearStop(circle, circle_gradient, 0.9, curvature=2.0, reaction="coordinate")
    scene = vi.Scene(system, vi.Harmonic(1.0, 2.0), stop)
    run = vi.simulate(scene, 0.0, 1.0, (0, 3))
    for value in (system, stop, scene):
        assert pickle.loads(pickle.dumps(value)) == value
    again = pickle.loads(pickle.dumps(run))
    assert again.scene == scene
    np.testing.assert_array_equal(again.q, run.q)
    with pytest.raises(TypeError, match="C function cannot be pickled"):
        pickle.dumps(vi.Scene(vi.NonlinearSystem(1, duffing_in_c)))
    with pytest.raises((AttributeError, pickle.PicklingError)):
        pickle.dumps(vi.NonlinearSystem(1, lambda t, q, v: q))
