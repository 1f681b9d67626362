"""Every array that goes in is taken right, whatever its memory is like, or refused."""

import numpy as np
import pytest

import vibroimpact as vi

SCENE = vi.paper_scene(kind=3)
SYSTEM = SCENE.system
RUN = vi.simulate(SCENE, [0.01, 0.02], [0.1, -0.1], (0, 30))
ORBIT = vi.periodic_orbits(SCENE, [1], 2)[0]
MASS = SYSTEM.mass


def columns_of_records(array):
    """A view into records of 12 bytes: its stride is no multiple of a number's size."""
    records = np.zeros(array.shape, dtype=np.dtype([("number", array.dtype), ("rest", "i4")]))
    records["number"] = array
    return records["number"]


def misaligned(array):
    bytes_ = np.zeros(array.nbytes + 1, dtype="u1")
    view = bytes_[1:].view(array.dtype).reshape(array.shape)
    view[...] = array
    return view


def read_only(array):
    array = array.copy()
    array.flags.writeable = False
    return array


class Labelled(np.ndarray):
    """A subclass of arrays."""


class Convertible:
    """No array, but something that can be made one."""

    def __init__(self, array):
        self.array = array

    def __array__(self, dtype=None, copy=None):
        return np.array(self.array, dtype=dtype)


def spread(array):
    """Every third number of a larger array, in each dimension."""
    wide = np.full([3 * n for n in array.shape], 7.7, dtype=array.dtype)
    picked = tuple(slice(1, None, 3) for _ in array.shape)
    wide[picked] = array
    return wide[picked]


def backwards(array):
    return np.flip(np.flip(array).copy())


FORMS = {
    "records": columns_of_records,
    "misaligned": misaligned,
    "spread": spread,
    "backwards": backwards,
    "column major": np.asfortranarray,
    "big endian": lambda array: array.astype(array.dtype.newbyteorder(">")),
    "little endian": lambda array: array.astype(array.dtype.newbyteorder("<")),
    "read-only": read_only,
    "subclass": lambda array: array.view(Labelled),
    "convertible": Convertible,
    "objects": lambda array: array.astype(object),
    "lists": lambda array: array.tolist(),
    "not masked": lambda array: np.ma.array(array),
    "mask of nothing": lambda array: np.ma.array(array, mask=np.zeros(array.shape, dtype=bool)),
}

Q, V = np.array([0.01, 0.03]), np.array([0.1, -0.2])
ROWS = np.array([[0.01, 0.02], [0.03, -0.04], [0.05, 0.06]])
TIMES = np.array([0.5, 1.25, 7.0, 29.0])


def linear(**given):
    arrays = {"mass": MASS, "damping": SYSTEM.damping, "stiffness": SYSTEM.stiffness} | given
    system = vi.LinearSystem(**arrays)
    return [system.mass, system.damping, system.stiffness, system.load, system.influence]


def ends(ensemble):
    return [ensemble.q, ensemble.v]


def of_functions(result, name):
    functions = {"acceleration": lambda t, q, v: -q, "mass": lambda q: MASS}
    given = {name: lambda *_: result}
    system = vi.NonlinearSystem(2, **(functions | given))
    run = vi.simulate(vi.Scene(system, None, vi.Stop(0, 0.05, 0.5)), Q, V, (0, 3), keep="final")
    return list(run.final)


def of_gap(gradient):
    stop = vi.NonlinearStop(lambda q: 0.05 - q[0] + 0.5 * q[1], lambda q: gradient, 0.5)
    scene = vi.Scene(vi.NonlinearSystem(2, lambda t, q, v: -q, mass=MASS), None, stop)
    return list(vi.simulate(scene, Q, V, (0, 3), keep="final").final)


# argument: an array for it, and what comes out
WAYS_IN = {
    "mass": (MASS, lambda a: linear(mass=a)),
    "damping": (SYSTEM.damping, lambda a: linear(damping=a)),
    "stiffness": (SYSTEM.stiffness, lambda a: linear(stiffness=a)),
    "diagonal": (np.array([2.0, 3.0]), lambda a: linear(mass=a, damping=a, stiffness=a)),
    "load": (Q, lambda a: linear(load=a)),
    "influence": (Q, lambda a: linear(influence=a)),
    "joints": (Q, lambda a: [vi.DoublePendulum(1.0, 2.0, a).damping]),
    "masses": (np.array([1.0, 2.5]), lambda a: [vi.PendulumChain(a, [1, 1]).masses]),
    "lengths": (np.array([1.0, 2.5]), lambda a: [vi.PendulumChain([1, 1], a).lengths]),
    "chain": (Q, lambda a: [vi.PendulumChain([1, 1], [1, 1], a).damping]),
    "mass of functions": (MASS, lambda a: [vi.NonlinearSystem(2, lambda t, q, v: -q, mass=a).mass]),
    "acceleration()": (Q, lambda a: of_functions(a, "acceleration")),
    "mass()": (MASS, lambda a: of_functions(a, "mass")),
    "gradient()": (np.array([-1.0, 0.5]), of_gap),
    "amplitude": (Q, lambda a: [vi.Harmonic(a, 1.0).amplitude]),
    "complex amplitude": (Q + 1j * V, lambda a: [vi.Harmonic(a, 1.0).amplitude]),
    "normal": (Q, lambda a: [vi.Stop(a, 0.1, 0.5).normal]),
    "reaction": (Q, lambda a: [vi.Stop(0, 0.1, 0.5, reaction=a).reaction]),
    "clearance": (Q, lambda a: [[s.clearance for s in SCENE.replace(clearance=a).stops]]),
    "restitution": (Q, lambda a: [[s.restitution for s in SCENE.replace(restitution=a).stops]]),
    "gaps": (ROWS, lambda a: [SCENE.gaps(a)]),
    "q0": (Q, lambda a: vi.simulate(SCENE, a, V, (0, 5)).final),
    "v0": (V, lambda a: vi.simulate(SCENE, Q, a, (0, 5)).final),
    "t_span": (np.array([0.25, 5.0]), lambda a: vi.simulate(SCENE, Q, V, a).final),
    "t_eval": (TIMES, lambda a: [vi.simulate(SCENE, Q, V, (0, 30), t_eval=a).q]),
    "t of a trajectory": (TIMES, lambda a: [RUN.position(a), RUN.velocity(a)]),
    "t of an orbit": (TIMES, lambda a: [ORBIT.position(a), ORBIT.velocity(a)]),
    "rows of q0": (ROWS, lambda a: ends(vi.simulate_many(SCENE, a, 0 * ROWS, (0, 5)))),
    "rows of v0": (ROWS, lambda a: ends(vi.simulate_many(SCENE, 0 * ROWS, a, (0, 5)))),
    "rows elsewhere": (ROWS, lambda a: ends(vi.simulate_many(SCENE, a, 0 * ROWS, (0, 5), workers=map))),
    "matrix": (vi.recovery_matrix(SCENE, 0), lambda a: [vi.audit_recovery(a, MASS, [0]).energy_gain]),
    "mass of an audit": (MASS, lambda a: [vi.audit_recovery(vi.recovery_matrix(SCENE, 0), a, [0]).energy_gain]),
    "normals": (np.eye(2), lambda a: [vi.audit_recovery(-np.eye(4), MASS, a).restitution]),
    "x": (np.array([1.4, 1.5]), lambda a: [vi.existence_map(SCENE, [1], ("frequency", a), ("clearance", [0.15]), 2).x]),
    "x of a callable": (
        np.array([1.4, 1.5]),
        lambda a: [vi.existence_map(lambda x, y: SCENE.replace(frequency=x), [1], a, [0.15], 2).multiplier],
    ),
    "y": (np.array([0.1, 0.2]), lambda a: [vi.existence_map(SCENE, [1], ("frequency", [1.5]), ("clearance", a), 2).y]),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("way", WAYS_IN)
def test_whatever_its_memory_is_like_an_array_is_the_numbers_that_numpy_sees(way, form):
    array, answer = WAYS_IN[way]
    for given, expected in zip(answer(FORMS[form](array)), answer(array.copy()), strict=True):
        assert np.array_equal(given, expected) or given is expected is None


@pytest.mark.parametrize("way", [way for way in WAYS_IN if way != "complex amplitude"])
def test_other_numbers_are_the_nearest_doubles(way):
    array, answer = WAYS_IN[way]
    single = array.astype("f4")
    expected = answer(single.astype("f8"))
    for given in (single, single.astype(">f4"), columns_of_records(single), single.astype("g"), single.astype("c8")):
        for a, b in zip(answer(given), expected, strict=True):
            assert np.array_equal(a, b) or a is b is None


def masked_row(array):
    """A mask of one row, in a list of arrays."""
    return [np.ma.array(row, mask=np.arange(np.size(row)) == 0) for row in np.atleast_1d(array)]


def masked(array):
    return np.ma.array(array, mask=np.arange(array.size).reshape(array.shape) == array.size - 1)


REFUSED = {
    "masked": masked,
    "list of masked": masked_row,
    "imaginary parts": lambda array: array + 1e-3j,
    "texts": lambda array: array.astype(str),
    "times": lambda array: np.zeros(array.shape, dtype="m8[s]"),
    "records": lambda array: np.zeros(array.shape, dtype=[("a", "f8")]),
}


@pytest.mark.filterwarnings("ignore:.*masked element to nan")
@pytest.mark.parametrize("form", REFUSED)
@pytest.mark.parametrize("way", [way for way in WAYS_IN if way not in ("amplitude", "complex amplitude")])
def test_what_would_lose_its_meaning_as_plain_numbers_is_refused(way, form):
    array, answer = WAYS_IN[way]
    with pytest.raises(ValueError, match=r"number|finite|span|index"):
        answer(REFUSED[form](array))


def test_columns_of_its_own_structured_arrays_go_in_as_they_are():
    segments = RUN.segments
    assert segments["start"].strides[0] % 8, "the case is none"
    assert np.array_equal(RUN.position(segments["start"]), RUN.position(segments["start"].copy()))
    assert np.array_equal(SCENE.gaps(np.broadcast_to(Q, (4, 2))), SCENE.gaps(np.array([Q] * 4)))


def test_rows_that_do_not_fit_together_are_refused_wherever_they_run():
    for workers in (1, map):
        for q0, v0 in ((np.zeros((2, 3)), np.zeros((2, 3))), (np.zeros((2, 2)), np.zeros((3, 2))), (np.zeros(4), np.zeros(4))):
            with pytest.raises(ValueError, match=r"(q0|v0) has shape \(.*\), but .*\d\).* is needed"):
                vi.simulate_many(SCENE, q0, v0, (0, 1), workers=workers)
