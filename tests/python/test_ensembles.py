"""Many runs at once: of one scene or of many, with impacts and samples, each as it is by itself."""

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import vibroimpact as vi

RNG = np.random.default_rng(8)
STOPS = [vi.Stop(0, 0.3, 0.8), vi.Stop(1, 0.25, 0.6, side="lower")]
PAIR = vi.Scene(vi.LinearSystem(np.eye(2), 0.05 * np.eye(2), [[2.0, -1.0], [-1.0, 2.0]]), vi.Harmonic([0.5, 0.1], 1.1), STOPS)
PENDULUM = vi.paper_scene(kind=3, linear=False)
Q0, V0 = RNG.uniform(-0.1, 0.1, (11, 2)), RNG.uniform(-0.3, 0.3, (11, 2))


def make(i):
    """The i-th of some scenes; importable, so that a process may call it."""
    return PAIR.replace(restitution=0.4 + 0.05 * i)


def alone(scenes, q0, v0, span, **options):
    return [vi.simulate(scene, q, v, span, **options) for scene, q, v in zip(scenes, q0, v0, strict=True)]


def check(ends, runs, t_eval=None):
    np.testing.assert_array_equal(ends.n_impacts, [run.stats.n_impacts for run in runs])
    np.testing.assert_array_equal(ends.status, [run.status for run in runs])
    for i, run in enumerate(runs):
        if t_eval is None:
            np.testing.assert_array_equal(ends.q[i], run.final[0])
            np.testing.assert_array_equal(ends.v[i], run.final[1])
        else:
            m = len(run.t)
            np.testing.assert_array_equal(ends.q[i, :m], run.q)
            np.testing.assert_array_equal(ends.v[i, :m], run.v)
            assert np.isnan(ends.q[i, m:]).all()
            assert np.isnan(ends.v[i, m:]).all()
        if ends.impacts is not None:
            own = ends.impacts[ends.impacts["run"] == i]
            for name in run.impacts.dtype.names:
                np.testing.assert_array_equal(own[name], run.impacts[name])


@pytest.mark.parametrize("scene", [PAIR, PENDULUM], ids=["linear", "pendulum"])
@pytest.mark.parametrize("method", ["auto", "rk45", "dop853", "radau"])
def test_every_method_with_impacts_and_samples(scene, method):
    t = np.linspace(0, 15, 9)
    options = {"method": method, "t_eval": t, "keep": "impacts"}
    ends = vi.simulate_many(scene, Q0, V0, (0, 15), **options)
    check(ends, alone([scene] * 11, Q0, V0, (0, 15), **options), t)
    assert ends.q.shape == (11, 9, 2)
    assert ends.impacts["run"].max() == 10


@pytest.mark.parametrize("given", ["list", "callable"])
def test_scenes_of_their_own(given):
    scenes = [make(i) for i in range(11)]
    given = scenes if given == "list" else make
    runs = alone(scenes, Q0, V0, (0, 40), keep="impacts")
    check(vi.simulate_many(given, Q0, V0, (0, 40), keep="impacts"), runs)
    check(vi.simulate_many(given, Q0, V0, (0, 40), keep="impacts", workers=map), runs)
    with ThreadPoolExecutor(2) as pool:
        check(vi.simulate_many(given, Q0, V0, (0, 40), keep="impacts", workers=pool), runs)


def test_one_row_for_all():
    scenes = [make(i) for i in range(5)]
    rows = [Q0[0]] * 5, [V0[0]] * 5
    for workers in (None, map):
        ends = vi.simulate_many(scenes, Q0[0], V0[0], (0, 30), workers=workers)
        check(ends, alone(scenes, *rows, (0, 30)))
        ends = vi.simulate_many(PAIR, Q0[:5], V0[0], (0, 30), workers=workers)
        check(ends, alone([PAIR] * 5, Q0[:5], rows[1], (0, 30)))
    one = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([0.5], 1.1), vi.Stop(0, 0.3, 0.8))
    assert vi.simulate_many(one, [0.0, 0.1, 0.2], 0.0, (0, 5)).q.shape == (3, 1)


def test_ramps_along_many():
    ramp = vi.Ramp("frequency", 1.5, rate=0.02)
    options = {"ramp": ramp, "keep": "impacts", "t_eval": [3.0, 28.0]}
    ends = vi.simulate_many(PAIR, Q0[:4], V0[:4], (0, 30), **options)
    check(ends, alone([PAIR] * 4, Q0[:4], V0[:4], (0, 30), **options), options["t_eval"])


@pytest.mark.parametrize("scene", [PAIR, PENDULUM, [PAIR] * 11], ids=["linear", "pendulum", "many"])
def test_starts_inside_a_stop_are_marked_and_the_others_run(scene):
    q0 = Q0.copy()
    wall = 0.5 if isinstance(scene, list) or scene is PAIR else 2.0
    q0[[2, 7]] = wall, wall
    ends = vi.simulate_many(scene, q0, V0, (0, 10), keep="impacts", t_eval=[1.0, 10.0])
    inside = np.isin(np.arange(11), [2, 7])
    np.testing.assert_array_equal(ends.status == "inside_stop", inside)
    assert np.isnan(ends.q[inside]).all()
    assert not np.isnan(ends.q[~inside]).any()
    assert (ends.n_impacts[inside] == 0).all()
    ends = vi.simulate_many(scene, q0, V0, (0, 10))
    np.testing.assert_array_equal(ends.q[inside], q0[inside])
    np.testing.assert_array_equal(ends.v[inside], V0[inside])


def test_runs_that_end_early_have_no_numbers_after_it():
    ends = vi.simulate_many(PAIR, Q0, V0, (0, 60), max_impacts=5, t_eval=np.linspace(0, 60, 31), keep="impacts")
    assert (ends.status == "max_impacts").all()
    assert (ends.n_impacts == 5).all()
    assert np.isnan(ends.q[:, -1]).all()
    assert not np.isnan(ends.q[:, 0]).any()
    assert ends.impacts.size == 55


def test_ensembles_come_back(tmp_path):
    ends = vi.simulate_many(PAIR, Q0, V0, (0, 20), keep="impacts", t_eval=[1.0, 20.0])
    ends.save(tmp_path / "ends.npz")
    for again in (pickle.loads(pickle.dumps(ends)), vi.load(tmp_path / "ends.npz")):
        for name, array in ends.to_arrays().items():
            np.testing.assert_array_equal(getattr(again, name), array)
    assert ends.to_xarray()["q"].dims == ("run", "time", "dof")
    assert vi.simulate_many(PAIR, Q0, V0, (0, 2)).impacts is None


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((PAIR, Q0, V0[:3]), ValueError, r"v0 has shape \(3, 2\), but \(11, 2\)"),
        (([PAIR] * 4, Q0, V0), ValueError, r"q0 has shape \(11, 2\), but \(4, 2\)"),
        (
            ([PAIR, vi.paper_scene(kind=3), vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0))], Q0[:3], V0[:3]),
            ValueError,
            r"scene\[2\] is of 1",
        ),
        ((PAIR, Q0[:, :1], V0), ValueError, "q0 has shape"),
        ((3, Q0, V0), TypeError, "scene is 3, but a Scene, a sequence"),
        (([PAIR, 3], Q0[:2], V0[:2]), TypeError, r"scene\[1\] is 3, but a Scene is needed"),
    ],
)
def test_what_does_not_fit_is_refused(arguments, error, message):
    with pytest.raises(error, match=message):
        vi.simulate_many(*arguments, (0, 1))


def test_a_whole_motion_is_not_kept():
    with pytest.raises(ValueError, match='keep is "motion", but an ensemble keeps impacts'):
        vi.simulate_many(PAIR, Q0, V0, (0, 1), keep="motion")
    with pytest.raises(ValueError, match='keep is "everything"'):
        vi.simulate_many(PAIR, Q0, V0, (0, 1), keep="everything")
    with pytest.raises(ValueError, match=r"row 3: method is \"exact\"|method"):
        vi.simulate_many([PAIR] * 3 + [PENDULUM], Q0[:4], V0[:4], (0, 1), method="exact")


def test_no_runs_are_an_ensemble_too():
    nothing = np.empty((0, 2))
    for scene in ([], PAIR, make):
        for workers in (None, map):
            ends = vi.simulate_many(scene, nothing, nothing, (0, 1), workers=workers)
            assert len(ends.status) == 0
    with pytest.raises(TypeError, match=r"scene\(0\) is None, but a Scene is needed"):
        vi.simulate_many(lambda i: None, Q0, V0, (0, 1))
    with pytest.raises(TypeError, match=r"scene\(4\) is 4, but a Scene is needed"):
        vi.simulate_many(lambda i: PAIR if i < 4 else i, Q0, V0, (0, 1))
