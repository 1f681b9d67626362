"""Basins on a cluster: cells go to the workers of Dask and into a store, and what is broken off is gone on with.

`x'' + 0.02 x' + x = cos 6.2 t` with a stop at x = -0.63 and restitution 0.8: hardly damped and driven fast, it swings without an
impact, hits once in five periods of the force, or three times in fifteen, as it has begun. Each cell is the state right after an
impact, its phase along x and its speed along y.

You will see the basins twice: as far as they had come when the run was broken off, as Ctrl-C does, and whole, after the same
call again. Printed is how many cells were there then; the labels are those of a run in one process, bit by bit.

Run: python examples/basin_cluster.py [--output DIRECTORY]
Needs: pip install "vibroimpact[store]" distributed. A cluster of yours in place of the two processes here is one line,
`Client("tcp://...")`.
"""

from __future__ import annotations

import argparse
import signal
import threading
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from distributed import Client, LocalCluster

import vibroimpact as vi

AFTER_IMPACT = {"stop": 0, "phase": (0.0, 2.0 * np.pi, 240), "speed": (0.0, 3.0, 180)}
BOX = [(-0.63, 2.0), (-3.0, 3.0)]


def oscillator() -> vi.Scene:
    """Return the scene."""
    stop = vi.Stop(0, 0.63, 0.8, side="lower")
    return vi.Scene(vi.LinearSystem(1.0, 0.02, 1.0), vi.Harmonic([1.0], 6.2), stop)


def break_off_when(path: Path, chunks: int) -> threading.Thread:
    """Send this process what Ctrl-C sends, once so many chunks of labels are in a store."""
    is_there = threading.Event()

    def watch() -> None:
        while len(list(path.glob("labels/c/*/*"))) < chunks and not is_there.wait(0.01):
            pass
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    return thread


def on_a_cluster(scene: vi.Scene, call: dict[str, Any], path: Path) -> tuple[vi.Basins, vi.Basins]:
    """Return the basins as far as they had come when they were broken off, and whole."""
    cluster_of_two = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster_of_two as cluster, Client(cluster) as client:
        watching = break_off_when(path, 2)
        try:
            vi.basins(scene, **call, workers=client, store=path)
            watching.join()
        except KeyboardInterrupt:
            print("broken off")
        part = vi.load(path)
        print(part)
        whole = vi.basins(scene, **call, workers=client, store=path)
    print(whole)
    return part, whole


def main() -> None:
    """Break off, go on, compare, draw."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figures")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    scene = oscillator()
    call = {"impact": AFTER_IMPACT, "attractors": vi.find_attractors(scene, BOX, seeds=100)}
    print(call["attractors"])
    assert {1, 5} <= {one.n_periods for one in call["attractors"]}
    with TemporaryDirectory() as folder:
        part, whole = on_a_cluster(scene, call, Path(folder) / "basins.zarr")
    here = vi.basins(scene, **call)
    assert np.array_equal(whole.labels, here.labels), "the labels are those of one process"
    known = part.labels != -3
    assert known.any(), "some cells were kept"
    assert np.array_equal(part.labels[known], here.labels[known]), "and they were right"
    figure, axes = plt.subplots(2, 1, figsize=(7.0, 7.5), layout="constrained", sharex=True)
    for ax, plane, title in zip(axes, (part, whole), ("as far as it had come", "whole"), strict=True):
        vi.plot.basins(plane, ax)
        ax.set(title=title, xlabel="phase of the impact [rad]", ylabel="speed after it")
    figure.savefig(output / "basin_cluster.png", dpi=150)
    print(f"figure in {output}/")


if __name__ == "__main__":
    main()
