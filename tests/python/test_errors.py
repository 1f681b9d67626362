"""Bad input is a ValueError that names the argument, its value and the rule; no float gets past that."""

import faulthandler
import os
import pickle

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import vibroimpact as vi

CASES = int(os.environ.get("VIBROIMPACT_CASES", "50"))
nasty = settings(max_examples=CASES, deadline=5000, suppress_health_check=[HealthCheck.too_slow])
HANG = 30.0  # [s] after which a call that answers nothing, not even a signal, ends the run

NAN, INF = float("nan"), float("inf")
ONE = vi.LinearSystem(1, 0.1, 1)
TWO = vi.LinearSystem(np.eye(2), 0.1 * np.eye(2), [[2, -1], [-1, 2]])
FORCED = vi.Scene(ONE, vi.Harmonic(1, 2.8), vi.Stop(0, 0.5, 0.8))
PAIR = vi.paper_scene(kind=3)
NONLINEAR = vi.paper_scene(kind=3, linear=False)

KEPT = vi.simulate(FORCED, 0, 0, (0, 1))
LOST = vi.simulate(FORCED, 0, 0, (0, 1), keep="final")
ORBIT = vi.periodic_orbits(PAIR, [1], 2)[0]


@pytest.fixture(autouse=True)
def _no_hang():
    faulthandler.dump_traceback_later(HANG, exit=True)
    yield
    faulthandler.cancel_dump_traceback_later()


# argument, what the message shows of the value, a word of the rule, the call
BAD = [
    # shapes
    ("damping", r"\(3, 3\)", r"\(2, 2\)", lambda: vi.LinearSystem(np.eye(2), np.eye(3), np.eye(2))),
    ("stiffness", r"\(3,\)", "2", lambda: vi.LinearSystem(np.eye(2), np.eye(2), [1, 2, 3])),
    ("mass", r"\(2, 3\)", "needed", lambda: vi.LinearSystem(np.ones((2, 3)), [0, 0], [1, 1])),
    ("mass", r"\(1, 1, 1\)", "needed", lambda: vi.LinearSystem(np.ones((1, 1, 1)), 0, 0)),
    ("mass", r"\(0,\)", "needed", lambda: vi.LinearSystem([], [], [])),
    ("load", r"\(1,\)", r"\(2,\)", lambda: vi.LinearSystem([1, 1], [0, 0], [1, 1], load=[1])),
    ("influence", r"\(3,\)", r"\(2,\)", lambda: vi.LinearSystem([1, 1], [0, 0], [1, 1], influence=[1, 2, 3])),
    ("damping", r"\(3,\)", r"\(2,\)", lambda: vi.DoublePendulum(1, 1, (1, 2, 3))),
    ("damping", r"\(3, 3\)", r"\(2, 2\)", lambda: vi.DoublePendulum(1, 1, np.eye(3))),
    ("lengths", r"\(1,\)", r"\(2,\)", lambda: vi.PendulumChain([1, 2], [1])),
    ("damping", r"\(3,\)", r"\(2,\)", lambda: vi.PendulumChain([1, 2], [1, 1], [1, 2, 3])),
    ("masses", r"\(0,\)", "needed", lambda: vi.PendulumChain([], [])),
    ("amplitude", r"\(1, 2\)", r"\(n,\)", lambda: vi.Harmonic([[1, 2]], 1)),
    ("amplitude", r"\(3,\)", r"\(2,\)", lambda: vi.Scene(TWO, vi.Harmonic([1, 2, 3], 1))),
    ("normal", r"\(3,\)", r"\(2,\)", lambda: vi.Scene(TWO, None, vi.Stop([1, 0, 0], 0, 0.5))),
    ("reaction", r"\(3,\)", r"\(2,\)", lambda: vi.Scene(TWO, None, vi.Stop(0, 0, 0.5, reaction=[1, 0, 0]))),
    ("q", r"\(3", r"\(\.\.\., 2\)", lambda: PAIR.gaps([1, 2, 3])),
    ("clearance", r"\(3,\)", r"\(2,\)", lambda: PAIR.replace(clearance=[1, 2, 3])),
    ("restitution", r"\(3,\)", r"\(2,\)", lambda: PAIR.replace(restitution=[1, 1, 1])),
    ("q0", r"\(2,\)", r"\(1,\)", lambda: vi.simulate(FORCED, [0.1, 0], 0, (0, 1))),
    ("v0", r"\(1,\)", r"\(2,\)", lambda: vi.simulate(PAIR, [0, 0], 0, (0, 1))),
    ("t_eval", r"\(1, 2\)", "needed", lambda: vi.simulate(FORCED, 0, 0, (0, 1), t_eval=[[0, 1]])),
    ("matrix", r"\(3, 3\)", r"\(4, 4\)", lambda: vi.audit_recovery(np.eye(3), np.eye(2), [0])),
    ("normals", r"\(1, 3\)", "2", lambda: vi.audit_recovery(np.eye(4), np.eye(2), [[1, 0, 0]])),
    ("t", r"\(1, 1\)", "needed", lambda: ORBIT.position([[1]])),
    # not numbers
    ("mass", "'heavy'", "numbers", lambda: vi.LinearSystem("heavy", 0, 0)),
    ("mass", "1j", "numbers", lambda: vi.LinearSystem([1 + 1j], 0, 0)),
    ("q", "'here'", "numbers", lambda: FORCED.gaps("here")),
    ("phase", "'late'", "numbers", lambda: PAIR.replace(phase="late")),
    # not finite
    ("mass", "nan", "finite", lambda: vi.LinearSystem([1, NAN], [0, 0], [1, 1])),
    ("damping", "inf", "finite", lambda: vi.LinearSystem([1, 1], [0, INF], [1, 1])),
    ("stiffness", "-inf", "finite", lambda: vi.LinearSystem(1, 0, -INF)),
    ("load", "nan", "finite", lambda: vi.LinearSystem([1, 1], [0, 0], [1, 1], load=[1, NAN])),
    ("influence", "inf", "finite", lambda: vi.LinearSystem([1, 1], [0, 0], [1, 1], influence=[1, INF])),
    ("length_ratio", "nan", "finite", lambda: vi.DoublePendulum(1, NAN)),
    ("damping", "nan", "finite", lambda: vi.DoublePendulum(1, 1, (NAN, 0))),
    ("gravity", "nan", "finite", lambda: vi.PendulumChain([1, 2], [1, 1], gravity=NAN)),
    ("amplitude", "nan", "finite", lambda: vi.Harmonic(NAN, 1)),
    ("phase", "inf", "finite", lambda: vi.Harmonic(1, 1, INF)),
    ("amplitude", "nan", "finite", lambda: vi.BaseMotion(NAN, 1)),
    ("frequency", "inf", "finite", lambda: vi.BaseMotion(1, INF)),
    ("normal", "nan", "finite", lambda: vi.Stop([1, NAN], 0, 0.5)),
    ("clearance", "nan", "finite", lambda: vi.Stop(0, NAN, 0.5)),
    ("reaction", "inf", "finite", lambda: vi.Stop(0, 0, 0.5, reaction=[1, INF])),
    ("position", "nan", "finite", lambda: vi.Wall(0, NAN, 0.5)),
    ("clearance", "nan", "finite", lambda: PAIR.replace(clearance=NAN)),
    ("damping", "nan", "finite", lambda: vi.paper_scene(3, damping=NAN)),
    ("clearance", "inf", "finite", lambda: vi.paper_scene(3, clearance=INF)),
    ("damping", "nan", "finite", lambda: vi.paper_system(1, 1, NAN)),
    ("phase", "nan", "finite", lambda: vi.periodic_orbits(PAIR, [1], phase=NAN)),
    ("matrix", "nan", "finite", lambda: vi.audit_recovery(NAN * np.eye(4), np.eye(2), [0])),
    ("q0", "nan", "finite", lambda: vi.simulate(FORCED, NAN, 0, (0, 1))),
    ("v0", "inf", "finite", lambda: vi.simulate(FORCED, 0, INF, (0, 1))),
    ("t_span", "inf", "finite", lambda: vi.simulate(FORCED, 0, 0, (0, INF))),
    ("t_span", "nan", "finite", lambda: vi.simulate(FORCED, 0, 0, (NAN, 1))),
    ("rtol", "nan", "finite", lambda: vi.simulate(FORCED, 0, 0, (0, 1), rtol=NAN)),
    ("t_eval", "nan", "span", lambda: vi.simulate(FORCED, 0, 0, (0, 1), t_eval=[NAN])),
    ("t", "nan", "finite", lambda: ORBIT.position(NAN)),
    # masses
    ("mass", "0", "positive definite", lambda: vi.LinearSystem([1, 0], [0, 0], [1, 1])),
    ("mass", "-1", "positive definite", lambda: vi.LinearSystem(-1, 0, 0)),
    ("mass", "not", "positive definite", lambda: vi.LinearSystem([[1, 2], [2, 1]], [0, 0], [1, 1])),
    ("mass", "not", "positive definite", lambda: vi.LinearSystem([[1, 1], [1, 1]], [0, 0], [1, 1])),
    ("mass", "not symmetric", "symmetric", lambda: vi.LinearSystem([[1, 0.5], [0, 1]], [0, 0], [1, 1])),
    ("mass", "not", "positive definite", lambda: vi.audit_recovery(np.eye(4), np.zeros((2, 2)), [0])),
    ("mass_ratio", "0", "greater than zero", lambda: vi.DoublePendulum(0, 1)),
    ("mass_ratio", "-1", "greater than zero", lambda: vi.paper_system(-1, 1, 0.1)),
    ("masses", "-2", "greater than zero", lambda: vi.PendulumChain([1, -2], [1, 1])),
    ("lengths", "0", "greater than zero", lambda: vi.PendulumChain([1, 2], [1, 0])),
    # restitution
    ("restitution", r"1\.1", r"\[0, 1\]", lambda: vi.Stop(0, 0, 1.1)),
    ("restitution", r"-0\.1", r"\[0, 1\]", lambda: vi.Stop(0, 0, -0.1)),
    ("restitution", "nan", r"\[0, 1\]", lambda: vi.Stop(0, 0, NAN)),
    ("restitution", "2", r"\[0, 1\]", lambda: vi.Wall(0, 0, 2)),
    ("restitution", "2", r"\[0, 1\]", lambda: PAIR.replace(restitution=2)),
    # stops and indices
    ("normal", "-1", "from 0", lambda: vi.Stop(-1, 0, 0.5)),
    ("normal", "zero", "not zero", lambda: vi.Stop([0, 0], 0, 0.5)),
    ("normal", "True", "index", lambda: vi.Stop(True, 0, 0.5)),
    ("normal", "2", "0 to 1", lambda: vi.Scene(TWO, None, vi.Stop(2, 0, 0.5))),
    ("reaction", "0", "n.b > 0", lambda: vi.Scene(TWO, None, vi.Stop([1, 0], 0, 0.5, reaction=[0, 1]))),
    ("reaction", "-1", "n.b > 0", lambda: vi.Scene(TWO, None, vi.Stop([1, 0], 0, 0.5, reaction=[-1, 0]))),
    ("bob", "-1", "from 0", lambda: vi.Wall(-1, 0, 0.5)),
    ("bob", "2", "0 to 1", lambda: vi.Scene(vi.DoublePendulum(1, 1), None, vi.Wall(2, 1, 0.5))),
    ("stops", "wall", "pendulum", lambda: vi.Scene(TWO, None, vi.Wall(0, 1, 0.5))),
    ("forcing", "base motion", "influence", lambda: vi.Scene(TWO, vi.BaseMotion(1, 1))),
    ("stops", "2", "0 to 1", lambda: vi.recovery_matrix(PAIR, 2)),
    ("stops", "-1", "from 0", lambda: vi.recovery_matrix(PAIR, -1)),
    ("stops", r"\[0, 0\]", "once", lambda: vi.recovery_matrix(PAIR, [0, 0])),
    ("normals", "5", "0 to 1", lambda: vi.audit_recovery(np.eye(4), np.eye(2), [5])),
    # patterns
    ("pattern", "2", "0 to 1", lambda: vi.periodic_orbits(PAIR, [2])),
    ("pattern", "-1", "from 0", lambda: vi.periodic_orbits(PAIR, [-1])),
    ("pattern", "empty", "stop", lambda: vi.periodic_orbits(PAIR, [()])),
    ("pattern", r"\[0, 0\]", "once", lambda: vi.periodic_orbits(PAIR, [(0, 0)])),
    ("pattern", "", "list", lambda: vi.periodic_orbits(PAIR, 1)),
    ("pattern", r"0\.5", "index", lambda: vi.periodic_orbits(PAIR, [0.5])),
    ("pattern", "'a'", "index", lambda: vi.periodic_orbits(PAIR, "a")),
    ("n_periods", "0", "at least 1", lambda: vi.periodic_orbits(PAIR, [1], 0)),
    ("n_periods", "-2", "at least 1", lambda: vi.periodic_orbits(PAIR, [1], -2)),
    # free parameters
    ("free", "clearance", "two stops", lambda: vi.periodic_orbits(PAIR, [1], free="clearance")),
    ("free", "frequency", "two stops", lambda: vi.periodic_orbits(PAIR, [1], free="frequency", between=(1, 2))),
    ("free", "colour", "one of", lambda: vi.periodic_orbits(PAIR, [(0, 1)], free="colour", between=(1, 2))),
    ("free", "clearance", "phase", lambda: vi.periodic_orbits(PAIR, [(0, 1)], free="clearance", phase=1)),
    ("between", "None", "low < high", lambda: vi.periodic_orbits(PAIR, [(0, 1)], free="frequency")),
    ("between", "2", "low < high", lambda: vi.periodic_orbits(PAIR, [(0, 1)], free="frequency", between=(2, 1))),
    ("between", "1", "free", lambda: vi.periodic_orbits(PAIR, [(0, 1)], between=(1, 2))),
    ("frequency", "0", "greater", lambda: vi.periodic_orbits(PAIR, [(0, 1)], free="frequency", between=(0, 1))),
    # frequencies
    ("frequency", "0", "greater than zero", lambda: vi.Harmonic(1, 0)),
    ("frequency", "-1", "greater than zero", lambda: vi.BaseMotion(1, -1)),
    ("frequency", "0", "greater than zero", lambda: PAIR.replace(frequency=0)),
    ("frequency", "2", "forcing", lambda: vi.Scene(ONE).replace(frequency=2)),
    ("phase", "2", "forcing", lambda: vi.Scene(ONE).replace(phase=2)),
    ("forcing_scale", "2", "forcing", lambda: vi.Scene(ONE).replace(forcing_scale=2)),
    # starts and spans
    ("q0", "gap", "inside stop 0", lambda: vi.simulate(FORCED, 0.6, 0, (0, 1))),
    ("q0", "gap", "inside stop 1", lambda: vi.simulate(PAIR, [0, 0.2], [0, 0], (0, 1))),
    ("t_span", "1", "start <= end", lambda: vi.simulate(FORCED, 0, 0, (1, 0))),
    ("rtol", "-1", "negative", lambda: vi.simulate(FORCED, 0, 0, (0, 1), rtol=-1)),
    ("atol", "-1", "negative", lambda: vi.simulate(FORCED, 0, 0, (0, 1), atol=-1)),
    ("t_eval", "2", "span", lambda: vi.simulate(FORCED, 0, 0, (0, 1), t_eval=[2])),
    ("t_eval", r"0\.1", "ascend", lambda: vi.simulate(FORCED, 0, 0, (0, 1), t_eval=[0.5, 0.1])),
    ("max_impacts", "-1", "", lambda: vi.simulate(FORCED, 0, 0, (0, 1), max_impacts=-1)),
    ("t", "2", "span", lambda: KEPT.position(2)),
    ("keep", "final", "motion", lambda: LOST.position(0.5)),
    ("keep", "final", "motion", lambda: LOST.segments),
    ("keep", "final", "motion", lambda: LOST.q),
    # names
    ("colour", "", "one of", lambda: PAIR.replace(colour=1)),
    ("side", "left", "upper", lambda: vi.Stop(0, 0, 0.5, side="left")),
    ("side", "upper", "right", lambda: vi.Wall(0, 0, 0.5, side="upper")),
    ("side", "both", "before", lambda: KEPT.velocity(0.5, side="both")),
    ("side", "both", "before", lambda: ORBIT.velocity(0.5, side="both")),
    ("reaction", "newton", "inertia", lambda: vi.Stop(0, 0, 0.5, reaction="newton")),
    ("keep", "all", "motion", lambda: vi.simulate(FORCED, 0, 0, (0, 1), keep="all")),
    ("method", "euler", "auto", lambda: vi.simulate(FORCED, 0, 0, (0, 1), method="euler")),
    ("kind", "5", "1, 2 and 3", lambda: vi.paper_scene(5)),
    ("kind", "0", "1, 2 and 3", lambda: vi.paper_scene(0)),
    # scenes that do not fit
    ("scene", "nonlinear", "linearise", lambda: vi.periodic_orbits(NONLINEAR, [0])),
    ("scene", "nonlinear", "linearise", lambda: vi.recovery_matrix(NONLINEAR, 0)),
    ("scene", "unforced", "forcing", lambda: vi.periodic_orbits(vi.Scene(ONE, None, vi.Stop(0, 1, 0.5)), [0])),
]


@pytest.mark.parametrize(("argument", "value", "rule", "call"), BAD, ids=[f"{i}-{bad[0]}" for i, bad in enumerate(BAD)])
def test_the_message_names_argument_value_and_rule(argument, value, rule, call):
    with pytest.raises(ValueError, match=rf"(?i)(?s)\b{argument}\b.*{value}.*{rule}") as caught:
        call()
    message = str(caught.value)
    assert type(caught.value) is ValueError
    assert "\n" not in message
    for word in ("Some(", "Parameter(", "BadValue", "Err("):  # how the core writes its own values
        assert word not in message


@pytest.mark.parametrize(
    "call",
    [
        lambda: vi.Scene(1),
        lambda: vi.Scene(ONE, 3),
        lambda: vi.Scene(ONE, None, [3]),
        lambda: vi.modes(vi.DoublePendulum(1, 1)),
        lambda: vi.BaseMotion(1, "fast"),
        lambda: vi.Stop(0, 1),
        lambda: vi.simulate(FORCED, 0, 0),
        lambda: vi.simulate(FORCED, 0, 0, (0, 1), "exact"),
        lambda: vi.Stop(0, 1, 1, "upper"),
    ],
)
def test_a_wrong_type_is_refused(call):
    with pytest.raises((TypeError, ValueError)):
        call()


def test_no_object_comes_from_nothing():
    for name in ("Orbit", "Orbits", "Trajectory", "Stability", "Violation", "Family", "Coefficients", "RecoveryAudit"):
        with pytest.raises(TypeError):
            getattr(vi, name)()


def test_convergence_error():
    error = vi.ConvergenceError("did not get there")
    assert isinstance(error, RuntimeError)
    assert not isinstance(error, ValueError)
    assert str(pickle.loads(pickle.dumps(error))) == "did not get there"


NASTY = [NAN, INF, -INF, 1e308, -1e308, 1e154, -1e154, 1e-154, 5e-324, -5e-324, 2.3e-308, -0.0, 0.0, 1.0, 0.5, -1.0]
any_float = st.one_of(st.sampled_from(NASTY), st.floats())
size = st.integers(1, 3)


def vector(n):
    return st.lists(any_float, min_size=n, max_size=n)


def matrix(n):
    return st.one_of(st.lists(vector(n), min_size=n, max_size=n), vector(n))


def attempt(call, *arguments, **options):
    """The value of a call, or None where it is refused in order; anything else that is raised is a failure."""
    try:
        return call(*arguments, **options)
    except (ValueError, vi.ConvergenceError):
        return None


class TestNastyFloats:
    @nasty
    @given(st.data(), size)
    def test_linear_systems(self, data, n):
        system = attempt(
            vi.LinearSystem,
            data.draw(matrix(n)),
            data.draw(matrix(n)),
            data.draw(matrix(n)),
            data.draw(vector(n)),
            None,
        )
        if system is not None:
            for name in ("mass", "damping", "stiffness", "load"):
                assert np.all(np.isfinite(getattr(system, name)))
            modes = attempt(vi.modes, system)
            assert modes is None or repr(modes)

    @nasty
    @given(any_float, any_float, any_float, any_float)
    def test_pendulums(self, a, b, c, d):
        for call in (
            lambda: vi.DoublePendulum(a, b, (c, d)),
            lambda: vi.PendulumChain([a, b], [c, d]),
            lambda: vi.PendulumChain([1, a], [1, b], [c, 0], gravity=d),
        ):
            system = attempt(call)
            if system is not None:
                linear = attempt(system.linearise)
                assert linear is None or np.all(np.isfinite(linear.stiffness))
        attempt(vi.paper_system, a, b, c)
        for kind in (1, 2, 3):
            attempt(vi.paper_scene, kind, damping=a, clearance=b, linear=bool(d))

    @nasty
    @given(any_float, any_float, any_float)
    def test_forcing_and_stops(self, a, b, c):
        for call in (
            lambda: vi.Harmonic([a], b, c),
            lambda: vi.Harmonic(complex(a, b), c),
            lambda: vi.BaseMotion(a, b, c),
            lambda: vi.Stop([a], b, c),
            lambda: vi.Stop(0, a, b, reaction=[c]),
            lambda: vi.Wall(0, a, b, side="left"),
        ):
            value = attempt(call)
            assert value is None or repr(value)

    @nasty
    @given(
        st.sampled_from(
            [
                "frequency",
                "phase",
                "amplitude",
                "clearance",
                "restitution",
                "forcing_scale",
                "damping_scale",
                "clearance[1]",
                "restitution[0]",
            ]
        ),
        any_float,
    )
    def test_replace(self, name, value):
        scene = attempt(PAIR.replace, **{name: value})
        if scene is not None:
            assert repr(scene)
            assert np.all(np.isfinite([stop.clearance for stop in scene.stops]))

    @nasty
    @given(st.data(), size, st.sampled_from(["inertia", "coordinate"]))
    def test_recovery_and_audit(self, data, n, reaction):
        system = attempt(vi.LinearSystem, data.draw(matrix(n)), np.zeros(n), np.ones(n))
        stops = [attempt(vi.Stop, data.draw(vector(n)), 1, data.draw(any_float), reaction=reaction) for _ in range(2)]
        if system is not None and None not in stops:
            scene = attempt(vi.Scene, system, None, stops)
            if scene is not None:
                attempt(vi.recovery_matrix, scene, 0)
                attempt(vi.recovery_matrix, scene, [0, 1])
        attempt(vi.audit_recovery, data.draw(matrix(2 * n)), np.eye(n), [data.draw(vector(n))])

    @nasty
    @given(
        any_float,
        any_float,
        st.sampled_from([[0], [1], [(0, 1)], []]),
        st.sampled_from([None, 0.0, NAN, 1e308, 5e-324]),
    )
    @example(1.0, 0.5, [], None)
    def test_orbits_of_the_papers_scene(self, frequency, clearance, pattern, phase):
        scene = attempt(PAIR.replace, frequency=frequency, clearance=clearance)
        if scene is not None:
            orbits = attempt(vi.periodic_orbits, scene, pattern, phase=phase)
            assert orbits is None or repr(orbits)

    @nasty
    @given(st.data(), st.integers(1, 2))
    def test_orbits(self, data, n):
        positive = st.sampled_from([1e308, 1e154, 1e-154, 5e-324, 2.3e-308, 1.0, 0.5, 1e10, 1e-10])
        real = st.sampled_from([0.0, -0.0, 1.0, -1.0, 1e308, -1e308, 1e154, 1e-154, 5e-324, 0.1, 1e8, -1e-8])
        mass = data.draw(st.lists(positive, min_size=n, max_size=n))
        other = [data.draw(st.lists(real, min_size=n, max_size=n)) for _ in range(4)]
        system = attempt(vi.LinearSystem, mass, other[0], other[1], other[2])
        forcing = attempt(vi.Harmonic, other[3], data.draw(positive))
        stop = attempt(vi.Stop, 0, data.draw(real), data.draw(st.sampled_from([0.0, 1.0, 0.5, 1e-12])))
        if None in (system, forcing, stop):
            return
        scene = attempt(vi.Scene, system, forcing, stop)
        if scene is not None:
            for phase in (None, data.draw(real)):
                orbits = attempt(vi.periodic_orbits, scene, [0], phase=phase)
                assert orbits is None or repr(orbits)

    @nasty
    @given(any_float, any_float, any_float, any_float)
    def test_free_and_between(self, low, high, phase, scale):
        attempt(vi.periodic_orbits, PAIR, [(0, 1)], 3, free="damping_scale", between=(low, high))
        attempt(vi.periodic_orbits, PAIR, [(0, 1)], 3, phase=phase)
        scene = attempt(PAIR.replace, forcing_scale=scale)
        if scene is not None:
            attempt(vi.periodic_orbits, scene, [(0, 1)], 3, free="clearance")
            attempt(vi.periodic_orbits, scene, [(0, 1)], 3, free="forcing_scale")

    @nasty
    @given(any_float, any_float, any_float, any_float)
    def test_simulate(self, q0, v0, start, end):
        run = attempt(vi.simulate, FORCED, q0, v0, (start, min(end, start + 10.0)), max_impacts=20, keep="final")
        assert run is None or repr(run)

    @nasty
    @given(any_float, any_float)
    def test_times_of_an_orbit(self, t, other):
        q = attempt(ORBIT.position, [t, other])
        assert q is None or q.shape == (2, 2)
        v = attempt(ORBIT.velocity, t, side="before")
        assert v is None or np.all(np.isfinite(v))
