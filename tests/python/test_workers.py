"""Executors: what fails and Ctrl-C end a sweep at once, and progress is shown from all pieces."""

import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scipy.interpolate import PPoly

import vibroimpact as vi

SCENE = vi.paper_scene(3)
GRID = np.linspace(0.05, 0.3, 20)
PROMPT = 0.5  # [s] until control returns


class Slow:
    """Makes scenes slowly, counts them, and may fail at one."""

    def __init__(self, fails_at=None):
        self.count, self.fails_at, self.lock = 0, fails_at, threading.Lock()

    def __call__(self, x, y):
        with self.lock:
            self.count += 1
            if self.count == self.fails_at:
                raise ZeroDivisionError
        time.sleep(0.05)
        return SCENE.replace(clearance=y)


def test_a_piece_that_fails_ends_the_sweep():
    make = Slow(fails_at=5)
    with ThreadPoolExecutor(2) as pool:
        start = time.perf_counter()
        with pytest.raises(ZeroDivisionError):
            vi.existence_map(make, [1], GRID, GRID, 2, workers=pool)
        assert time.perf_counter() - start < PROMPT
    assert time.perf_counter() - start < 2 * PROMPT, "the pool goes on with pieces that nobody waits for"
    assert make.count < 20


def test_rows_that_fail_are_named_by_their_number_in_all():
    scenes = [SCENE] * 200
    short = PPoly([[1e-3], [-2e-3], [1e-3]], [0.0, 0.5])
    scenes[150] = SCENE.replace(stops=[vi.Stop(0, 1.0, 0.8), vi.Stop(1, 1.0, 0.8, motion=short)])
    q0 = np.zeros((200, 2))
    with ThreadPoolExecutor(2) as pool, pytest.raises(ValueError, match="row 150: t_span is"):
        vi.simulate_many(scenes, q0, 0 * q0, (0, 1), workers=pool)
    with pytest.raises(ValueError, match="row 150: t_span is"):
        vi.simulate_many(scenes, q0, 0 * q0, (0, 1))


LONG = """
import multiprocessing, os, signal, time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
import numpy as np
import vibroimpact as vi

scene = vi.paper_scene(3, clearance=0.05)
grid = np.linspace(0.05, 0.3, 100)


def make(x, y):
    time.sleep(0.01)
    return scene.replace(clearance=y)


def spring(t, q, v):
    return -q


functions = vi.Scene(vi.NonlinearSystem(1, spring, mass=1.0), None, vi.Stop(0, 0.5, 0.9))
many = np.linspace(0.0, 0.4, 200)


def interrupted(signum, frame):
    global asked
    asked = time.perf_counter()
    raise KeyboardInterrupt


if __name__ == "__main__":
    signal.signal(signal.SIGALRM, interrupted)
    pool = {pool}
    signal.setitimer(signal.ITIMER_REAL, 1.0)
    try:
        {call}
    except KeyboardInterrupt:
        print(time.perf_counter() - asked, end="", flush=True)
    for child in multiprocessing.active_children():  # left alone they hold the pipes open
        child.kill()
    os._exit(0)
"""

POOLS = {
    "threads": "ThreadPoolExecutor(2)",
    "processes": "ProcessPoolExecutor(2)",
    "map": "map",
    "own threads": "2",
}
CALLS = {
    "callable": "vi.existence_map(make, [1], grid, grid, 2, workers=pool)",
    "functions": "vi.simulate_many(functions, many, 0 * many, (0, 1000), workers=pool)",
    "trajectories": "vi.simulate_many(scene, np.zeros((200, 2)), np.zeros((200, 2)), (0, 1e6), workers=pool)",
}


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("pool", POOLS)
def test_an_interruption_is_answered(pool, call, tmp_path):
    if (pool, call) == ("own threads", "callable"):
        pytest.skip("a callable is called by the calling thread")
    script = tmp_path / "long.py"
    script.write_text(LONG.format(pool=POOLS[pool], call=CALLS[call]))
    answer = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60, check=False)
    assert answer.stdout, answer.stderr
    assert float(answer.stdout) < PROMPT


def test_waiting_pieces_are_cancelled_by_an_interruption():
    make = Slow()
    with ThreadPoolExecutor(1) as pool:
        timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
        timer.start()
        start = time.perf_counter()
        with pytest.raises(KeyboardInterrupt):
            vi.existence_map(make, [1], GRID, GRID, 2, workers=pool)
        assert time.perf_counter() - start < 0.3 + PROMPT
    assert time.perf_counter() - start < 0.3 + 2 * PROMPT
    assert make.count < 30


@pytest.mark.parametrize("workers", ["executor", "map", 2])
def test_progress_is_shown(workers, capsys):
    pytest.importorskip("tqdm")
    with ThreadPoolExecutor(2) as pool:
        run = pool if workers == "executor" else map if workers == "map" else workers
        vi.simulate_many(SCENE, np.zeros((100, 2)), np.zeros((100, 2)), (0, 5), workers=run, progress=True)
    assert "100%" in capsys.readouterr().err


@pytest.mark.parametrize("workers", [None, map])
def test_no_trajectories_are_an_ensemble_too(workers):
    ends = vi.simulate_many(SCENE, np.zeros((0, 2)), np.zeros((0, 2)), (0, 1), workers=workers)
    assert (ends.q.shape, ends.status.shape) == ((0, 2), (0,))


@pytest.mark.parametrize(
    ("scene", "methods"),
    [
        (SCENE, ["auto", "exact", "Exact", "rk45", "RK45"]),
        (vi.paper_scene(3, linear=False), ["auto", "rk45", "taylor", "Taylor"]),
    ],
)
def test_every_method_has_the_bits_of_single_runs(scene, methods):
    rng = np.random.default_rng(3)
    q0, v0 = rng.uniform(-0.1, 0.1, (2, 5, 2))
    for method in methods:
        options = {"method": method, "rtol": 1e-6, "max_impacts": 7}
        single = [vi.simulate(scene, q, v, (0, 30), keep="final", **options) for q, v in zip(q0, v0, strict=True)]
        for workers in (1, map):
            ends = vi.simulate_many(scene, q0, v0, (0, 30), workers=workers, **options)
            assert np.array_equal(ends.q, [run.final[0] for run in single])
            assert np.array_equal(ends.v, [run.final[1] for run in single])
            assert ends.status.tolist() == [run.status for run in single]


@pytest.mark.parametrize("workers", [1, map])
def test_a_method_that_the_scene_has_not_is_refused(workers):
    for scene, method in ((SCENE, "taylor"), (vi.paper_scene(3, linear=False), "exact"), (SCENE, "euler")):
        with pytest.raises(ValueError, match=r"method|linear|Taylor|scene"):
            vi.simulate_many(scene, np.zeros((2, 2)), np.zeros((2, 2)), (0, 1), method=method, workers=workers)
