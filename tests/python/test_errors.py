"""Bad input is a ValueError that names the argument, its value and the rule; no float gets past that."""

import pickle

import numpy as np
import pytest

import vibroimpact as vi

NAN, INF = float("nan"), float("inf")
ONE = vi.LinearSystem(1, 0.1, 1)
TWO = vi.LinearSystem(np.eye(2), 0.1 * np.eye(2), [[2, -1], [-1, 2]])
FORCED = vi.Scene(ONE, vi.Harmonic(1, 2.8), vi.Stop(0, 0.5, 0.8))
PAIR = vi.paper_scene(kind=3)
NONLINEAR = vi.paper_scene(kind=3, linear=False)

GROWING = vi.Scene(vi.LinearSystem(1, -5, 1), vi.Harmonic(1, 0.02), vi.Stop(0, 0.5, 0.8))  # by exp(1500) in a period
STILL = PAIR.replace(amplitude=0)
X, Y = ("frequency", [1.5]), ("clearance", [0.15])


def sweep(scene, pattern):
    return vi.existence_map(scene, pattern, X, Y)


KEPT = vi.simulate(FORCED, 0, 0, (0, 1))
LOST = vi.simulate(FORCED, 0, 0, (0, 1), keep="final")
ORBIT = vi.periodic_orbits(PAIR, [1], 2)[0]


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
    ("normals", "zero", "not zero", lambda: vi.audit_recovery(np.eye(4), np.eye(2), [[0, 0]])),
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
    ("n_periods", "1000", "whole number", lambda: vi.periodic_orbits(PAIR, [1], 10**30)),
    ("pattern", "3 instants", "find_orbit", lambda: vi.periodic_orbits(PAIR, [1, 0, 1])),
    ("pattern", "3 instants", "existence_map solves", lambda: sweep(PAIR, [1, 0, 1])),
    # periods whose phase is lost, motions that doubles do not hold
    ("period", "6.28319e297", r"1e12 turns.*rate 1\.94327", lambda: vi.periodic_orbits(PAIR.replace(frequency=1e-297), [1])),
    ("period", "e297", "1e12 turns", lambda: vi.periodic_orbits(PAIR.replace(frequency=1e-297), [1, 0])),
    ("period", "e297", "1e12 turns", lambda: vi.periodic_orbits(PAIR.replace(frequency=1e-297), [])),
    ("period", "inf", "1e12 turns", lambda: vi.periodic_orbits(PAIR.replace(frequency=5e-324), [1])),
    ("period", r"4\.18879e15", "1e12 turns", lambda: vi.periodic_orbits(PAIR, [1], 10**15)),
    ("scene", "unstable", "within a period", lambda: vi.periodic_orbits(GROWING, [0])),
    ("scene", "unstable", "within a period", lambda: vi.periodic_orbits(GROWING, [0, 0])),
    # axes of maps
    ("x", "amplitude", "forcing_scale", lambda: vi.existence_map(FORCED, [0], ("amplitude", [1]), Y)),
    ("y", "amplitude", "forcing_scale", lambda: vi.existence_map(STILL, [0], X, ("amplitude", [1]))),
    ("y", "forcing_scale", "different", lambda: vi.existence_map(PAIR, [1], ("amplitude", [1]), ("forcing_scale", [1]))),
    ("scene", "nonlinear", "existence_map needs", lambda: sweep(NONLINEAR, [0])),
    ("scene", "nonlinear", "existence_map needs", lambda: vi.existence_map(lambda x, y: NONLINEAR, [0], [1], [1])),
    ("scene", "unforced", "existence_map looks", lambda: sweep(vi.Scene(ONE, None, vi.Stop(0, 1, 0.5)), [0])),
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
    ("q0", r"inside stop 0, its gap -0\.1,", r"margin, -\d[.\d]*e-\d+$", lambda: vi.simulate(FORCED, 0.6, 0, (0, 1))),
    ("q0", r"inside stop 1, its gap -0\.05", "margin", lambda: vi.simulate(PAIR, [0, 0.2], [0, 0], (0, 1))),
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
    ("clearance", "2", "no stops", lambda: vi.Scene(ONE).replace(clearance=2)),
    ("restitution", "0.5", "no stops", lambda: vi.Scene(ONE).replace(restitution=0.5)),
    ("amplitude", r"\(0,\)", "degree of freedom", lambda: vi.Harmonic([], 1)),
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


WRONG_TYPES = [
    ("n_periods", "1.5", "whole number", lambda: vi.periodic_orbits(PAIR, [1], n_periods=1.5)),
    ("n_periods", "'two'", "whole number", lambda: vi.find_orbit(PAIR, ORBIT, n_periods="two")),
    ("n_periods", "1.5", "whole number", lambda: vi.existence_map(PAIR, [1], X, Y, 1.5)),
    ("n_periods", "1.5", "whole number", lambda: vi.existence_map(lambda x, y: PAIR, [1], [1], [1], 1.5)),
    ("phase", "'x'", "number", lambda: vi.periodic_orbits(PAIR, [1], phase="x")),
    ("free", "3", "str", lambda: vi.periodic_orbits(PAIR, [(0, 1)], free=3)),
    ("between", "5", "pair of numbers", lambda: vi.periodic_orbits(PAIR, [(0, 1)], free="frequency", between=5)),
    ("clearance", "'a'", "number", lambda: vi.Stop(0, "a", 1)),
    ("restitution", "'hard'", "number", lambda: vi.Stop(0, 1, "hard")),
    ("side", "3", "str", lambda: vi.Stop(0, 1, 1, side=3)),
    ("position", "'far'", "number", lambda: vi.Wall(0, "far", 1)),
    ("frequency", "'fast'", "number", lambda: vi.BaseMotion(1, "fast")),
    ("frequency", r"\[1, 2\]", "number", lambda: vi.Harmonic(1, [1, 2])),
    ("mass_ratio", "1j", "number", lambda: vi.DoublePendulum(1j, 1)),
    ("gravity", "'g'", "number", lambda: vi.PendulumChain([1], [1], gravity="g")),
    ("kind", "1.5", "whole number", lambda: vi.paper_scene(1.5)),
    ("linear", "'no'", "True or False", lambda: vi.paper_scene(3, linear="no")),
    ("scene", "1", "Scene", lambda: vi.simulate(1, 0, 0, (0, 1))),
    ("scene", "'s'", "Scene", lambda: vi.recovery_matrix("s", 0)),
    ("scene", "3", "Scene", lambda: vi.existence_map(3, [1], X, Y)),
    ("scene", "3", "Scene", lambda: vi.simulate_many(3, 0, 0, (0, 1), workers=1)),
    ("rtol", "'a'", "number", lambda: vi.simulate(FORCED, 0, 0, (0, 1), rtol="a")),
    ("atol", "'a'", "number", lambda: vi.simulate_many(FORCED, [0], [0], (0, 1), atol="a")),
    ("method", "3", "str", lambda: vi.simulate(FORCED, 0, 0, (0, 1), method=3)),
    ("keep", "3", "str", lambda: vi.simulate(FORCED, 0, 0, (0, 1), keep=3)),
    ("max_impacts", "2.5", "whole number", lambda: vi.simulate(FORCED, 0, 0, (0, 1), max_impacts=2.5)),
    ("progress", "'yes'", "True or False", lambda: vi.simulate(FORCED, 0, 0, (0, 1), progress="yes")),
]


@pytest.mark.parametrize(
    ("argument", "value", "kind", "call"), WRONG_TYPES, ids=[f"{i}-{w[0]}" for i, w in enumerate(WRONG_TYPES)]
)
def test_a_wrong_type_is_a_type_error_whose_message_names_the_argument(argument, value, kind, call):
    with pytest.raises(TypeError, match=rf"^{argument} is {value}, but an? .*{kind}|^{argument} is {value}, but {kind}"):
        call()


@pytest.mark.parametrize("system", [vi.PendulumChain([1], [1]), vi.DoublePendulum(1, 1)])
def test_modes_name_the_remedy(system):
    with pytest.raises(TypeError, match=r"^system is .*LinearSystem is needed; take system\.linearise\(\)$"):
        vi.modes(system)
    with pytest.raises(TypeError, match=r"take scene\.linearise\(\)\.system$"):
        vi.modes(NONLINEAR)
    with pytest.raises(TypeError, match=r"LinearSystem is needed$"):
        vi.modes(3)


def test_modes_of_a_pendulum_are_those_of_its_linear_system():
    with pytest.raises(TypeError, match=r"DoublePendulum.*LinearSystem.*linearise"):
        vi.modes(vi.DoublePendulum(1, 1))
    assert vi.modes(vi.DoublePendulum(1, 1).linearise()).shapes.shape == (2, 2)


def test_no_object_comes_from_nothing():
    for name in ("Orbit", "Orbits", "Trajectory", "Stability", "Violation", "Family", "Coefficients", "RecoveryAudit"):
        with pytest.raises(TypeError):
            getattr(vi, name)()


def test_convergence_error():
    error = vi.ConvergenceError("did not get there")
    assert isinstance(error, RuntimeError)
    assert not isinstance(error, ValueError)
    assert str(pickle.loads(pickle.dumps(error))) == "did not get there"


# Messages say what was given. -----------------------------------------------------------------------------------------


def van_der_pol():
    return vi.Scene(vi.NonlinearSystem(1, lambda t, q, v: (1 - q**2) * v - q, mass=1.0))


def test_a_state_that_is_a_guess_is_called_no_trajectory():
    with pytest.raises(ValueError, match="without impacts") as refused:
        vi.find_orbit(van_der_pol(), ([2.0], [0.0], 6.6632868593))
    assert "trajectory" not in str(refused.value)


@pytest.mark.parametrize(
    ("forcing", "name"),
    [
        (vi.BaseAcceleration(([0.0, 1.0], [0.0, 1.0])), "a base acceleration"),
        (vi.BaseMotion(0.1, 1.0), "a base motion"),
    ],
)
def test_bases_are_refused_by_their_own_names(forcing, name):
    for system in (vi.NonlinearSystem(1, lambda t, q, v: -q, mass=1.0), vi.LinearSystem(1.0, 0.1, 1.0)):
        for given in (forcing, [vi.Harmonic([1.0], 1.0), forcing]):
            with pytest.raises(ValueError, match=f"forcing is {name}, but"):
                vi.Scene(system, given)


@pytest.mark.parametrize(
    ("forcing", "name"),
    [
        (vi.Harmonic([1.0], 1.0), "a harmonic force"),
        (vi.Fourier([[1.0]], 1.0), "a periodic force"),
        (vi.Load(0, ([0.0, 1.0], [1.0, 1.0])), "a load that follows a signal"),
    ],
)
def test_forces_that_need_a_mass_say_which_they_are(forcing, name):
    with pytest.raises(ValueError, match=f"{name} needs the mass matrix"):
        vi.Scene(vi.NonlinearSystem(1, lambda t, q, v: -q), forcing)


def test_an_orbit_shows_periods_of_a_forcing_that_it_has():
    free = vi.Scene(vi.LinearSystem(1.0, -0.1, 1.0), stops=vi.Stop(0, 0.5, 0.5))
    text = str(vi.find_orbit(free, vi.simulate(free, [0.1], [0.0], (0, 300)))).splitlines()[0]
    assert "forcing" not in text
    assert "phase" not in text
    forced = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
    found = vi.periodic_orbits(forced, [0], n_periods=2)
    assert found
    assert all("(2 forcing periods), phase" in str(orbit).splitlines()[0] for orbit in found)


def test_phases_of_a_whole_turn_less_rounding_are_shown_as_none():
    system = vi.NonlinearSystem(1, lambda t, q, v: -q - 0.1 * v, mass=1.0)
    scene = vi.Scene(system, vi.Harmonic([1.0], 0.8))
    # A run that ends with a whole turn, to its rounding.
    for turns in (60, 61, 67):
        run = vi.simulate(scene, [0.0], [0.0], (0, turns * 2 * np.pi / 0.8))
        text = str(vi.find_orbit(scene, run)).splitlines()[0]
        assert "(1 forcing period), phase 0.000000 rad" in text


def test_diagrams_refuse_equations_that_do_not_repeat_with_the_forcing():
    def driven(t, q, v):
        return -q - 0.2 * v + np.cos(0.8 * t)

    def moved(t, q, v):
        return -q * (1 + 0.3 * np.cos(0.8 * t)) - 0.2 * v

    for acceleration in (driven, moved):
        scene = vi.Scene(vi.NonlinearSystem(1, acceleration, mass=1.0), vi.Harmonic([0.0], 0.8))
        options = {"transient": 20, "periods": 5}
        with pytest.raises(ValueError, match=r"value 1 of the axis: .* depend on time by themselves"):
            vi.bifurcation_diagram(scene, ("frequency", [0.8, 0.9, 1.0]), **options)
        # At the frequency of its own all is well.
        assert vi.bifurcation_diagram(scene, ("forcing_scale", [1.0, 2.0]), **options).n_periods.tolist() == [1, 1]


def test_integrations_that_fail_count_their_steps():
    """Steps that come to nothing after some, not after all that there may be."""

    def away(t, q, v):
        with np.errstate(divide="ignore"):
            return np.where(t < 1.0, -q, 1.0 / np.maximum(1.2 - t, 0.0) ** 3)

    scene = vi.Scene(vi.NonlinearSystem(1, away, mass=1.0), vi.Harmonic([0.1], 0.5))
    with pytest.raises((ValueError, vi.ConvergenceError)) as failed:
        vi.find_orbit(scene, ([0.1], [0.0]))
    assert "10000000 iterations" not in str(failed.value)
