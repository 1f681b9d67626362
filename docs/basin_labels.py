"""Write docs/basin_labels.md: how the label of a cell of a basin is decided, and what it does not prove.

Run by hand, ``python docs/basin_labels.py``, with the package installed and nothing else running: it times cells.
"""

from pathlib import Path
from time import perf_counter

import numpy as np

import vibroimpact as vi
from vibroimpact.analysis import attractor_labels

SCENE = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([9.0], 2.4), vi.Stop(0, 1.0, 0.8))
BOX = np.array([(-9.5, 1.0), (-8.0, 8.0)])
SAMPLES = 60_000
DISPLACEMENTS = (1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
ENOUGH = 10  # states with another label, for their number to say something
CELLS = (-0.63, 5.2)  # stop and frequency of the scene that is timed
ROUNDS = 5

TEXT = """# What the label of a basin says

`basins` gives each cell of a plane the number of the attractor to which the state in its middle leads. This page says how that
number comes about and what it is worth. Written by `docs/basin_labels.py`.

## How a label is decided

1. *The list.* `find_attractors` follows random states of the box. A motion that repeats itself is closed by `find_orbit`, so that
   its points are known to rounding; one that does not is told by its Lyapunov exponents. Then the list is closed: no cell adds to
   it, so that a label is a function of the state and of the list alone, whoever computes it and in whatever order.
2. *The phase.* Motions are looked at once in each period of the forcing, at the phase farthest from the impacts of all orbits: next
   to an impact two close motions look far apart.
3. *The cell.* It has the label of an orbit of m periods when its motion has stayed within 0.01 of the box from the orbit's points,
   each after the one before, for 3 m looks; that of a chaotic set or a torus when it has stayed within four times the usual distance
   of the set's points for 20. Never is a motion taken for one attractor that is within a fifth of the distance to another.
4. *No label.* Inside a stop there is no motion (-2). A thousand boxes away for ten looks is lost (-1). What is not decided in
   `max_periods` says so (0), and may be given to `find_attractors(seeds=...)`, the one way to make the list longer.

## What it does not prove

*A label is that of one computed motion.* Of {samples} random states of the box of the oscillator of `examples/impact_oscillator.py`
at F = 9, so many have another label when their position is moved:

| moved by | states with another label | part |
|---|---:|---:|
{moved}

The slope, {slope:.2f} +- {slope_error:.2f} over the rows with {enough} states or more, is the uncertainty exponent, and the boundary has the
dimension 2 less it. `Basins.uncertainty_exponent()` finds {exponent:.2f} +- {exponent_error:.2f} from the labels of 400 x 400 cells alone,
over distances of a cell and more: an exponent is that of its scales, and its error that of the fit. Nearer to the boundary than rounding times what the motion
multiplies it with, a label is a matter of chance, and always of the same one: the bits do not depend on the workers.

*Another method may decide otherwise.* The same states by steps in place of exact flights:

| method | rtol | states with another label |
|---|---:|---:|
{methods}

*The list may be short.* An attractor that no seed led to is missing from it. Its cells come out undecided, not wrong, if it is
periodic; a chaotic set that shares points with one of the list may be taken for that. Fractions from `basin_fractions` have the
standard error of random states, `sqrt(f (1 - f)/samples)`, and no error for what is missing from the list.

## What a cell costs

`x'' + x = cos 5.2 t` with a stop at -0.63 and e = 0.8, {timed} states right after an impact, attracted by {attractors} orbit: {per_cell:.1f} us
a cell on one core (median of {rounds}; {periods:.1f} periods and {impacts:.1f} impacts until it is decided). Published for
Attractors.jl are 0.9 to 1.7 ms a start of a smooth pendulum on all cores of another machine; the two are neither the same scene nor
the same machine, and what they say is that cells of impacting scenes need not cost more.
"""


def count_of_others(labels, others):
    """Return how many states that are in no stop, before and after, have another label."""
    outside = (labels != -2) & (others != -2)
    return int((labels != others)[outside].sum())


def labels_at(scene, states, attractors, **options):
    """Return the labels of any states, each a plane of its own row."""
    shared = (
        scene,
        attractor_labels.seen(attractors),
        BOX,
        (),
        (0.0, 2000, None, options.get("method", "auto"), options.get("rtol", 1e-9), 1e-12),
    )
    return attractor_labels.labelled(shared, (states, np.zeros(len(states))), (None, False, None))[0]


def moved(states, labels, attractors):
    """Return how many have another label at each displacement."""
    return [count_of_others(labels, labels_at(SCENE, states + np.array([off, 0.0]), attractors)) for off in DISPLACEMENTS]


def slope_of(counts):
    """Return the exponent by which parts grow with displacements, and its standard error."""
    kept = [(off, count) for off, count in zip(DISPLACEMENTS, counts, strict=True) if count >= ENOUGH]
    x, y = np.log(np.array(kept, dtype=float)).T
    (slope, _), covariance = np.polyfit(x, y, 1, cov=True)
    return slope, np.sqrt(covariance[0, 0])


def timed():
    """Return the microseconds of a cell on one core, and what its motion goes through."""
    stop, frequency = CELLS
    scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), vi.Harmonic([1.0], frequency), vi.Stop(0, -stop, 0.8, side="lower"))
    attractors = vi.find_attractors(scene, [(stop, 2.0), (-3.0, 3.0)], seeds=200)
    impact = {"stop": 0, "phase": (0.0, 2 * np.pi, 200), "speed": (0.0, 3.0, 150)}
    times = []
    for _ in range(ROUNDS):
        start = perf_counter()
        plane = vi.basins(scene, impact=impact, attractors=attractors, workers=1)
        times.append(perf_counter() - start)
    cells = plane.labels.size
    starts = np.array([[stop, 1.0]])
    run = vi.simulate(scene, *starts.T, (0.0, plane.iterations.mean() * scene.period), keep="impacts")
    return {
        "timed": cells,
        "attractors": len(attractors),
        "per_cell": 1e6 * float(np.median(times)) / cells,
        "rounds": ROUNDS,
        "periods": float(plane.iterations.mean()),
        "impacts": float(len(run.impacts)),
    }


def main():
    """Measure and write."""
    attractors = vi.find_attractors(SCENE, BOX)
    states = BOX[:, 0] + np.random.default_rng(0).random((SAMPLES, 2)) * (BOX[:, 1] - BOX[:, 0])
    labels = labels_at(SCENE, states, attractors)
    counts = moved(states, labels, attractors)
    slope, slope_error = slope_of(counts)
    plane = vi.basins(SCENE, q=(*BOX[0], 400), v=(*BOX[1], 400), attractors=attractors)
    found = plane.uncertainty_exponent()
    methods = []
    for method, rtol in (("dop853", 1e-12), ("dop853", 1e-9), ("rk45", 1e-9), ("rk45", 1e-6)):
        others = labels_at(SCENE, states, attractors, method=method, rtol=rtol)
        methods.append(f"| {method} | {rtol:g} | {count_of_others(labels, others)} |")
    text = TEXT.format(
        samples=SAMPLES,
        moved="\n".join(f"| {off:g} | {n} | {n / SAMPLES:.3%} |" for off, n in zip(DISPLACEMENTS, counts, strict=True)),
        enough=ENOUGH,
        slope=slope,
        slope_error=slope_error,
        exponent=found.value,
        exponent_error=found.error,
        methods="\n".join(methods),
        **timed(),
    )
    path = Path(__file__).with_name("basin_labels.md")
    path.write_text(text)
    print(f"written {path}")


if __name__ == "__main__":
    main()
