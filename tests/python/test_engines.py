"""Engines of others: Dask, MPI, joblib and process pools give the bits of the core's threads, and their failures come out."""

import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool

import numpy as np
import pytest

import vibroimpact as vi

SCENE = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([9.0], 2.4), vi.Stop(0, 1.0, 0.8))
BOX = [(-3.0, 1.5), (-5.0, 5.0)]
PLANE = {"q": (-3.0, 1.5, 24), "v": (-5.0, 5.0, 18), "max_periods": 400}
PAPER = vi.paper_scene(3)
PROMPT = 0.5  # [s] until control returns
MAP = (PAPER, [1], ("frequency", np.linspace(1.0, 2.0, 23)), ("clearance", np.linspace(0.05, 0.3, 21)), 2)


def everything(workers, **options):
    """One result of each function that takes workers."""
    found = vi.find_attractors(SCENE, BOX, seeds=12, workers=workers, **options)
    scene = vi.paper_scene(3, clearance=0.05)
    values = ("forcing_scale", [0.5, 0.8])
    states = np.linspace(0.0, 0.04, 60).reshape(30, 2)
    return [
        found,
        vi.basins(SCENE, **PLANE, attractors=found, workers=workers, **options),
        vi.basin_fractions(SCENE, BOX, samples=70, attractors=found, max_periods=400, workers=workers, **options),
        vi.existence_map(*MAP, workers=workers, **options),
        vi.simulate_many(scene, states, 0 * states, (0, 40), keep="impacts", workers=workers, **options),
        vi.bifurcation_diagram(SCENE, values, transient=30, periods=8, carry=False, workers=workers, **options),
    ]


def equal(one, other):
    names, others = one.to_arrays(), other.to_arrays()
    return all(equal_arrays(names[k], others[k]) for k in names)


def equal_arrays(one, other):
    if one.dtype.names:
        return one.dtype == other.dtype and all(equal_arrays(one[name], other[name]) for name in one.dtype.names)
    return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")


@pytest.fixture(scope="module")
def plain():
    return everything(1)


def same(found, plain):
    return [equal(one, other) for one, other in zip(found, plain, strict=True)] == [True] * len(plain)


@pytest.fixture(scope="module")
def client():
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
            yield client


def test_dask_gives_the_same_bits(client, plain, capsys):
    assert same(everything(client, progress=True), plain)
    assert "100%" in capsys.readouterr().err
    assert same(everything(client.get_executor(pure=False)), plain)


class Slow:
    """Makes scenes, each in some milliseconds."""

    def __init__(self, pause=0.004):
        self.pause = pause

    def __call__(self, x, y):
        time.sleep(self.pause)
        return PAPER.replace(frequency=x, clearance=y)


@pytest.mark.filterwarnings("ignore")
def test_dask_goes_on_where_a_worker_is_killed(client):
    axes = np.linspace(1.0, 2.0, 23), np.linspace(0.05, 0.3, 21)
    victim = next(iter(client.run(os.getpid).values()))
    killer = threading.Timer(0.5, os.kill, (victim, signal.SIGKILL))
    killer.start()
    made = vi.existence_map(Slow(), [1], *axes, 2, workers=client)
    killer.join()
    assert equal(made, vi.existence_map(Slow(0), [1], *axes, 2))


@pytest.mark.filterwarnings("ignore")
def test_an_interruption_of_dask_is_answered(client):
    axes = np.linspace(1.0, 2.0, 100), np.linspace(0.05, 0.3, 100)
    asked = []

    def interrupt():
        asked.append(time.perf_counter())
        signal.raise_signal(signal.SIGINT)

    timer = threading.Timer(1.0, interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        vi.existence_map(Slow(0.1), [1], *axes, 2, workers=client)
    assert time.perf_counter() - asked[0] < PROMPT
    # The cluster is there for the next call.
    assert equal(vi.existence_map(*MAP, workers=client), vi.existence_map(*MAP))


def test_what_is_shared_goes_to_dask_once(client):
    pytest.importorskip("distributed")
    sent = []
    submit = type(client).submit

    class Counting:
        def get_executor(self, **options):
            return client.get_executor(**options)

        def submit(self, function, *arguments, **options):
            sent.append(arguments)
            return submit(client, function, *arguments, **options)

    vi.existence_map(*MAP, workers=Counting())
    assert len(sent) == 1
    assert sent[0][0][0] == PAPER


@pytest.mark.parametrize("returned", ["list", "generator"])
def test_joblib_by_a_map(returned, plain):
    joblib = pytest.importorskip("joblib")

    def mapped(function, pieces):
        parallel = joblib.Parallel(n_jobs=2, return_as=returned)
        return parallel(joblib.delayed(function)(piece) for piece in pieces)

    assert same(everything(mapped), plain)


MPI = """
import pickle, sys
from mpi4py.futures import MPIPoolExecutor
from test_engines import everything

if __name__ == "__main__":
    with MPIPoolExecutor() as pool:
        found = everything(pool, progress=True)
    with open(sys.argv[1], "wb") as file:
        pickle.dump(found, file)
"""


def test_mpi(plain, tmp_path):
    pytest.importorskip("mpi4py")
    import pickle
    import shutil

    launcher = os.path.join(os.path.dirname(sys.executable), "mpiexec")
    launcher = launcher if os.path.exists(launcher) else shutil.which("mpiexec")
    script, results = tmp_path / "mpi.py", tmp_path / "results.pickle"
    script.write_text(MPI)
    here = os.path.dirname(os.path.abspath(__file__))
    paths = os.pathsep.join([here, *filter(None, [os.environ.get("PYTHONPATH")])])
    command = [launcher, "-n", "3", sys.executable, "-m", "mpi4py.futures", str(script), str(results)]
    answer = subprocess.run(command, env=dict(os.environ, PYTHONPATH=paths), capture_output=True, text=True, timeout=120)
    assert answer.returncode == 0, answer.stderr
    assert "100%" in answer.stderr
    with results.open("rb") as file:
        assert same(pickle.load(file), plain)


class Dies:
    """Ends its process at one scene."""

    def __call__(self, x, y):
        if y > 0.2:
            os._exit(1)
        return PAPER.replace(frequency=x, clearance=y)


def test_a_pool_whose_worker_dies_says_so_itself(tmp_path):
    pytest.importorskip("zarr")
    path = tmp_path / "map.zarr"
    axes = np.linspace(1.0, 2.0, 23), np.linspace(0.05, 0.3, 21)
    with ProcessPoolExecutor(1) as pool, pytest.raises(BrokenProcessPool):
        vi.existence_map(Dies(), [1], *axes, 2, workers=pool, store=path)
    assert vi.load(path).n_orbits.shape == (21, 23)


def test_other_wrong_workers(plain):
    for wrong in (0, -1, True, "two", 1.5):
        with pytest.raises(ValueError, match="workers is"):
            vi.existence_map(*MAP, workers=wrong)
