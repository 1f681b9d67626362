"""Print what many trajectories at once cost: basins of attraction, on one core and on two, and the memory they take.

Run by hand, ``python benches/ensemble.py [count]`` with a release build of the package installed. Every trajectory lasts 20
forcing periods of the paper's third case from its own start. Runs on one and on two workers take turns; the ratio is the
median of the ratios of neighbours.
"""

import resource
import sys
import time
from statistics import median

import numpy as np

import vibroimpact as vi

COUNT = 1_000_000
ROUNDS = 3
PERIODS = 20


def starts(count):
    """Return positions at rest over a plane of two angles, shape (count, 2)."""
    side = round(np.sqrt(count))
    first, second = np.meshgrid(np.linspace(-0.1, 0.05, side), np.linspace(-0.2, 0.05, side))
    return np.column_stack((first.ravel(), second.ravel()))


def seconds(scene, q0, workers):
    """Time of one ensemble, with its impacts."""
    start = time.perf_counter()
    run = vi.simulate_many(scene, q0, 0 * q0, (0.0, PERIODS * scene.period), workers=workers)
    return time.perf_counter() - start, run.n_impacts.sum()


def peak():
    """Largest memory of the process so far [MB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main():
    """Measure and print."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else COUNT
    for name, scene in (("linear", vi.paper_scene(kind=3)), ("large motions", vi.paper_scene(kind=3, linear=False))):
        q0 = starts(count)
        seconds(scene, q0[:1000], 2)
        before, pairs = peak(), []
        for _ in range(ROUNDS):
            (one, impacts), (two, _) = seconds(scene, q0, 1), seconds(scene, q0, 2)
            pairs.append((one, two))
        one = median(pair[0] for pair in pairs)
        gain = median(pair[0] / pair[1] for pair in pairs)
        print(
            f"{name:14} {len(q0)} trajectories of {PERIODS} periods: {one:.1f} s on one core, "
            f"{one / len(q0) * 1e6:.1f} us a trajectory, {one / max(impacts, 1) * 1e6:.2f} us an impact; "
            f"two cores {gain:.2f} times as fast; {peak() - before:.0f} MB more, of which the answers "
            f"{len(q0) * 2 * 2 * 8 / 2**20:.0f} MB"
        )


if __name__ == "__main__":
    main()
