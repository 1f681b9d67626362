"""Whatever is done to a pickle, what comes out of it is an object that works, or an error: never a panic."""

import contextlib
import itertools
import pickle

import numpy as np
import pytest

import vibroimpact as vi

PAIR = vi.paper_scene(kind=3)
LARGE = vi.paper_scene(kind=3, linear=False)
PUSHED = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic(1.0, 0.3), vi.Stop(0, 0.2, 0.6))
BALL = vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0, load=[-1.0]), vi.Harmonic(1.3, 1.0), [vi.Stop(0, 0.0, 0.5, side="lower")])


def spring(t, q, v):
    return -q


def gap(q):
    return 0.2 - q[0]


def gradient(q):
    return np.array([-1.0])


DUFFING = vi.Scene(vi.NonlinearSystem(1, spring, mass=1.0), None, vi.NonlinearStop(gap, gradient, 0.5))


def objects():
    """One of every class that pickles."""
    orbits = vi.periodic_orbits(PAIR, [1], 2)
    held = vi.find_orbit(BALL, vi.simulate(BALL, 0.3, 0.0, (0, 12 * BALL.period)))
    yield "LinearSystem", PAIR.system
    yield "diagonal", vi.LinearSystem([1.0, 2.0], [0.0, 0.1], [1.0, 2.0], load=[0.0, 1.0], influence=[1.0, 1.0])
    yield "DoublePendulum", vi.DoublePendulum(1.0, 2.0, (0.1, 0.2))
    yield "PendulumChain", vi.PendulumChain([1.0, 2.0, 3.0], [1.0, 1.0, 1.0], 0.1)
    yield "NonlinearSystem", DUFFING.system
    yield "Harmonic", vi.Harmonic([1.0, 2.0j], 1.5, 0.1)
    yield "BaseMotion", vi.BaseMotion(0.1, 1.5)
    yield "Stop", vi.Stop([1.0, -0.5], 0.2, 0.5, reaction=[1.0, 0.0])
    yield "Wall", vi.Wall(1, 0.2, 0.5)
    yield "NonlinearStop", DUFFING.stops[0]
    yield "Scene", PAIR
    yield "Modes", vi.modes(PAIR.system)
    yield "RecoveryAudit", vi.audit_recovery(vi.recovery_matrix(PAIR, 0), PAIR.system.mass, [0])
    yield "Orbit", orbits[0]
    yield "Orbit that is held", held
    yield "Orbits", orbits
    yield "Coefficients", orbits[0].coefficients
    yield "Violation", orbits[1].violation or vi.Violation(1, 0.5, 0.1, "passed")
    yield "Family", vi.Family(np.eye(4)[:, :2])
    yield "Stability", orbits[0].stability
    for name, scene, start, options in [
        ("exact", PAIR, ([0, 0], [0, 0.1]), {}),
        ("held", PUSHED, (0, 0), {}),
        ("series", LARGE, ([0, 0], [0, 0.1]), {}),
        ("steps", LARGE, ([0, 0], [0, 0.1]), {"method": "rk45"}),
        ("long steps", LARGE, ([0, 0], [0, 0.1]), {"method": "dop853"}),
        ("implicit steps", LARGE, ([0, 0], [0, 0.1]), {"method": "radau"}),
        ("functions", DUFFING, (0, 1), {}),
        ("samples", LARGE, ([0, 0], [0, 0.1]), {"t_eval": [0.0, 3.0], "keep": "final"}),
        ("impacts", PAIR, ([0, 0], [0, 0.1]), {"keep": "impacts"}),
    ]:
        yield f"Trajectory, {name}", vi.simulate(scene, *start, (0, 12), **options)
    yield "Trajectory, no time", vi.simulate(PAIR, [0, 0], [0, 0.1], (0, 0))
    yield "Stats", vi.simulate(PAIR, [0, 0], [0, 0.1], (0, 3)).stats
    yield "Energy", vi.simulate(PAIR, [0, 0], [0, 0.1], (0, 3)).energy
    yield "ExistenceMap", vi.existence_map(PAIR, [1], ("frequency", [1.4, 1.5]), ("clearance", [0.1, 0.2, 0.3]), 2)
    yield "Ensemble", vi.simulate_many(PAIR, np.zeros((3, 2)), np.ones((3, 2)), (0, 3))
    graze = vi.continuation(orbits[0], "frequency", (1.0, 2.0)).special[0]
    yield "Special", graze
    yield "Beyond", graze.beyond(periods=20)
    yield "BranchTree", vi.branch_tree(orbits[0], "frequency", (1.2, 1.8), depth=1, max_points=5)
    plane = (("frequency", "clearance"), ((1.0, 3.0), (0.05, 1.0)))
    yield "BifurcationCurve", vi.bifurcation_curve(graze, *plane, max_points=5)
    yield "CurvePoint", vi.CurvePoint("fold_flip", (1.0, 2.0), (1e-12, 1e-12), 0.5, graze.orbit)
    yield "Candidate", graze.branches()[0]
    yield "Derivatives", orbits[0].derivatives(["frequency", "clearance"])
    yield "Branch", vi.continuation(orbits[0], "frequency", (1.4, 1.6), max_points=3, monitor={"period": lambda own: own.period})
    yield "PoincarePoints", vi.poincare_points(vi.simulate(PAIR, [0, 0], [1, 1], (0, 9)))
    found = vi.find_attractors(PAIR, [(-1, 0), (-1, 1), (-1, 1), (-1, 1)], seeds=2, transient=20, max_periods=20)
    yield "Attractors", found
    yield "Attractor", found[0]
    plane = vi.basins(PAIR, q={0: (-0.1, 0.1, 9), 1: 0.0}, v={0: (-0.1, 0.1, 8), 1: 0.0}, attractors=found, max_periods=10)
    yield "Basins", plane
    yield "Fit", plane.boundary_dimension()
    yield "BasinFractions", vi.basin_fractions(PAIR, found.box, samples=3, attractors=found, max_periods=5)
    yield "LyapunovExponents", vi.lyapunov_exponents(PAIR, [0, 0], [0, 0], (0, 30))
    yield "BifurcationDiagram", vi.bifurcation_diagram(PAIR, ("frequency", [0.9, 1.0]), transient=3, periods=5)


OBJECTS = dict(objects())


def pieces(thing):
    """What pickle makes an object of, with keyword arguments as the last of the positional ones."""
    reduced = thing.__reduce_ex__(4)
    make, arguments = reduced[:2]
    if make.__name__ == "__newobj_ex__":
        cls, positional, keywords = arguments
        return (lambda *given: cls(*given[:-1], **given[-1])), [*positional, dict(keywords)]
    assert len(reduced) == 2 or not any(reduced[2:]), "a state beside the arguments would go in unchecked"
    if make.__name__ == "__newobj__":
        cls, *positional = arguments
        return cls, positional
    return make, list(arguments)


def use(thing):
    """Ask for everything that an object answers without arguments, and for the motion at some times."""
    repr(thing)
    for name in dir(thing):
        if not name.startswith("_"):
            with contextlib.suppress(ValueError):  # such as the motion of a trajectory that has not kept it
                getattr(thing, name)
    if isinstance(thing, (vi.Orbit, vi.Trajectory)):
        for t in (0.0, 0.5, np.array([0.0, 1.0])):
            for ask in (thing.position, thing.velocity):
                with contextlib.suppress(ValueError):
                    ask(t)


STRANGE = [-1, 2**40, 10**30, 1e300, float("nan"), float("inf"), -0.5, None, "no such", (), [], {}, [float("nan")], object()]


def changes(value):
    """Versions of a value that are not it: truncated, doubled, turned round, of other types and sizes; deep inside too."""
    yield from STRANGE
    if isinstance(value, np.ndarray):
        yield value[:-1] if value.ndim else value
        yield np.concatenate([value, value]) if value.ndim else value
        yield value * np.nan if value.dtype.kind in "fc" else value
        yield value[..., np.newaxis]
        return
    if isinstance(value, (list, tuple)):
        kind = type(value)
        yield kind(value[:-1])
        yield kind(value[1:])
        yield kind([*value, *value])
        yield kind(reversed(value))
        # Some places are enough where there are many: the first, the last and two between.
        for k in sorted({0, len(value) // 3, len(value) // 2, len(value) - 1} & set(range(len(value)))):
            for other in changes(value[k]):
                yield kind([*value[:k], other, *value[k + 1 :]])
    if isinstance(value, dict):
        for key in value:
            yield {name: item for name, item in value.items() if name != key}
            for other in changes(value[key]):
                yield value | {key: other}


def is_sound(make, arguments):
    try:
        thing = make(*arguments)
    except (ValueError, TypeError, vi.ConvergenceError, MemoryError):
        return
    use(thing)


@pytest.mark.parametrize("name", OBJECTS)
def test_what_was_saved_comes_back(name):
    thing = OBJECTS[name]
    again = pickle.loads(pickle.dumps(thing))
    assert repr(again) == repr(thing)
    use(again)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", OBJECTS)
def test_no_change_of_what_was_saved_makes_it_panic(name):
    make, arguments = pieces(OBJECTS[name])
    for k, argument in enumerate(arguments):
        for other in changes(argument):
            is_sound(make, [*arguments[:k], other, *arguments[k + 1 :]])
    for i, j in itertools.combinations(range(len(arguments)), 2):
        swapped = list(arguments)
        swapped[i], swapped[j] = swapped[j], swapped[i]
        is_sound(make, swapped)
    is_sound(make, arguments[:-1])
    is_sound(make, [*arguments, 1])


@pytest.mark.parametrize("name", [name for name in OBJECTS if name.startswith(("Trajectory", "Orbit"))])
def test_another_scene_is_not_its_own(name):
    make, arguments = pieces(OBJECTS[name])
    for scene in (PAIR, LARGE, PUSHED, BALL, DUFFING, vi.Scene(PAIR.system), PAIR.replace(stops=PAIR.stops[:1])):
        is_sound(make, [scene, *arguments[1:]])


def changed(trajectory, **parts):
    make, (scene, saved) = trajectory.__reduce__()
    return make, (scene, saved | parts)


@pytest.mark.parametrize(
    ("part", "value"),
    [
        ("span", (0.0, float("nan"))),
        ("span", (3.0, 1.0)),
        ("span", (0.0, 5.0)),
        ("status", "happy"),
        ("stats", (1, 2, 3, 4, -1)),
        ("last", ([0.0], [0.0])),
        ("last", ([0.0, float("nan")], [0.0, 0.0])),
        ("impacts", [(1.0, 7, 1.0, 1.0, 1.0, 0.0)]),
        ("impacts", [(1.0, -1, 1.0, 1.0, 1.0, 0.0)]),
        ("impacts", [(1.0, 10**20, 1.0, 1.0, 1.0, 0.0)]),
        ("impacts", [(99.0, 0, 1.0, 1.0, 1.0, 0.0)]),
        ("impacts", [(2.0, 0, 1.0, 1.0, 1.0, 0.0), (1.0, 0, 1.0, 1.0, 1.0, 0.0)]),
        ("grazes", [(1.0, 2, 0.0)]),
        ("grazes", [(float("nan"), 0, 0.0)]),
        ("samples", ([0.0], np.zeros((2, 2)), np.zeros((1, 2)))),
        ("samples", ([0.0], np.zeros((1, 3)), np.zeros((1, 3)))),
        ("motion", [([], [], [], 0)]),
        ("motion", []),
        ("motion", [([], [], [], 10**18)]),
        ("chapters", []),
        ("chapters", [(0.0, 1e9, 0)]),
    ],
)
def test_numbers_that_no_run_leaves_are_refused_by_name(part, value):
    make, arguments = changed(OBJECTS["Trajectory, exact"], **{part: value})
    with pytest.raises(ValueError, match=r"saved|status|needed"):
        make(*arguments)
