"""The fixed set of calls: examples, extreme cases, contests, orbits, guesses, maps, ensembles, and scenes drawn at random."""

import contextlib
import io
import runpy
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import vibroimpact as vi

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TOLERANCES = (1e-3, 1e-6, 1e-9, 1e-12)
SCENES = 80  # at random

Cases = Iterator[tuple[str, Callable[[], object]]]


def cases() -> Cases:
    """Yield every case by name; those of the reports are named as their conditions are."""
    yield from examples()
    yield from extremes()
    yield from contests()
    yield from orbits()
    yield from maps()
    yield from random_scenes()


def examples() -> Cases:
    """Yield the examples that are no report, run as scripts."""
    reports = {"error_vs_runtime", "extreme_cases", "scene_cost"}
    for script in sorted(EXAMPLES.glob("*.py")):
        if script.stem not in reports:
            yield f"example {script.stem}", lambda script=script: example(script)


def example(script: Path) -> None:
    """Run an example; its figures and words go nowhere."""
    own = sys.argv
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        sys.argv = [str(script), "--output", folder]
        try:
            runpy.run_path(str(script), run_name="__main__")
        finally:
            sys.argv = own


def extremes() -> Cases:
    """Yield the rows of the report of extreme cases."""
    import extreme_cases  # noqa: F401  (puts all cases under their rows)
    from report.extremes.registry import findings_of
    from report.extremes.rows import ROWS

    for row in ROWS:
        yield f"extreme {row}", lambda row=row: findings_of(row, quick=False)


def contests() -> Cases:
    """Yield the problems of the contest, by each method of the library that they are open to, at four tolerances."""
    from report.contest.contestants import own
    from report.contest.measure import tolerances
    from report.contest.problems import Ensemble, problems
    from report.contest.reference import load

    for problem in problems():
        runs = many if isinstance(problem, Ensemble) else own.prepare
        methods = ("auto",) if isinstance(problem, Ensemble) else own.methods(problem)
        for method in methods:
            if method == "rk45" and problem.name.startswith("stiff_8"):
                continue  # minutes each, and steps as those of stiff_4
            for rtol in TOLERANCES:
                allowed = tolerances(rtol, load(problem))
                yield f"contest {problem.name} {method} {rtol:.0e}", runs(problem, method, allowed)


def many(problem, method, allowed) -> Callable[[], object]:
    """Return the call that moves all starts of an ensemble."""
    n, options = problem.scene.n_dof, {"rtol": allowed.relative, "atol": allowed.absolute}
    q0, v0 = problem.starts[:, :n], problem.starts[:, n:]
    return lambda: vi.simulate_many(problem.scene, q0, v0, (0.0, problem.end), method=method, **options)


def orbits() -> Cases:
    """Yield orbits of one and two instants, with phase, clearance or frequency free, and orbits found from guesses."""
    patterns = {1: [[(0, 1)], [0, 1]], 2: [[0], [0, 0]], 3: [[1], [1, 0], [1, 1]]}
    for kind, of in patterns.items():
        for linear in (True, False):
            scene = vi.paper_scene(kind, linear=linear)
            for pattern in of if linear else []:
                for n in (1, 2, 3):
                    name = f"orbits kind {kind} {pattern} in {n}"
                    yield name, lambda scene=scene, pattern=pattern, n=n: vi.periodic_orbits(scene, pattern, n)
            yield f"orbit guessed kind {kind} linear={linear}", lambda scene=scene: guessed(scene)
    for free, between in (("clearance", None), ("forcing_scale", None), ("frequency", (1.3, 1.7))):
        call = {"n_periods": 3, "free": free, "between": between}
        yield f"orbits free {free}", lambda c=call: vi.periodic_orbits(vi.paper_scene(1), [(0, 1)], **c)
    for kind in (1, 2, 3):
        yield f"modes kind {kind}", lambda kind=kind: vi.modes(vi.paper_scene(kind).system)
        yield f"recovery kind {kind}", lambda kind=kind: recovery(vi.paper_scene(kind))


def recovery(scene: vi.Scene) -> None:
    """Ask for the recovery matrix of both stops and what it keeps."""
    vi.audit_recovery(vi.recovery_matrix(scene, [0, 1]), scene.system.mass, [0, 1])


def guessed(scene: vi.Scene) -> None:
    """Follow a start for some periods, and look for the orbit that it comes to."""
    n = scene.n_dof
    run = vi.simulate(scene, np.full(n, 0.02), np.full(n, 0.1), (0.0, 40 * scene.period))
    with contextlib.suppress(vi.ConvergenceError, ValueError):
        vi.find_orbit(scene, run, 2)


def maps() -> Cases:
    """Yield existence maps of the paper's kinds, and one that a function of Python makes."""
    x, y = ("frequency", np.linspace(1.0, 3.0, 60)), ("forcing_scale", np.linspace(0.05, 2.2, 60))
    for kind, pattern in ((2, [0]), (3, [1])):
        scene = vi.paper_scene(kind)
        yield f"map kind {kind}", lambda s=scene, p=pattern: vi.existence_map(s, p, x, y, n_periods=2)
    scene = vi.paper_scene(3)
    e, w = np.linspace(0.1, 1.0, 12), np.linspace(1.0, 3.0, 12)
    made = lambda a, b: scene.replace(restitution=a, frequency=b)  # noqa: E731
    yield "map made by a function", lambda: vi.existence_map(made, [1], e, w, n_periods=2)


def random_scenes() -> Cases:
    """Yield linear scenes of one to five coordinates with dampers of all kinds and up to four stops, and chains of pendulums."""
    random = np.random.default_rng(15)
    for k in range(SCENES):
        scene, q0, v0 = drawn(random)
        for method in ("exact", "rk45"):
            yield f"random {k} {method}", lambda of=(scene, q0, v0), m=method: vi.simulate(*of, (0.0, 30.0), method=m)
        if scene.period and scene.stops:
            yield f"random {k} orbits", lambda s=scene: vi.periodic_orbits(s, [0])
    for k in range(SCENES // 4):
        start = chain(random)
        for method in ("taylor", "rk45"):
            yield f"random chain {k} {method}", lambda of=start, m=method: vi.simulate(*of, (0.0, 5.0), method=m)


def chain(random: np.random.Generator) -> tuple[vi.Scene, np.ndarray, np.ndarray]:
    """Draw a chain of one to four pendulums with a wall, a stop, both or neither, shaken or not; and a start."""
    n = int(random.integers(1, 5))
    system = vi.PendulumChain(random.uniform(0.3, 2.0, n), random.uniform(0.2, 1.0, n), float(random.choice([0.0, 0.05])))
    shaken = vi.BaseMotion(random.uniform(0.02, 0.2), random.uniform(1.0, 6.0)) if random.random() < 0.7 else None
    bob, side = int(random.integers(n)), "left" if random.random() < 0.5 else "right"
    place = random.uniform(0.02, 0.4) * (-1 if side == "left" else 1)
    stops = [vi.Wall(bob, place, 0.6, side=side), vi.Stop(int(random.integers(n)), random.uniform(0.05, 0.4), 0.8)]
    q0 = np.zeros(n)
    return vi.Scene(system, shaken, [stop for stop in stops if random.random() < 0.7]), q0, random.normal(size=n)


def drawn(random: np.random.Generator) -> tuple[vi.Scene, np.ndarray, np.ndarray]:
    """Draw a scene and a start; every other start is zero."""
    n = int(random.integers(1, 6))
    mass, stiffness, other = (root @ root.T for root in random.normal(size=(3, n, n)))
    mass += np.eye(n)
    gyroscopic = random.normal(size=(n, n))
    dampers = [0 * mass, 0.05 * stiffness, 0.1 * other, 0.05 * stiffness + 0.3 * (gyroscopic - gyroscopic.T)]
    damping = dampers[int(random.integers(4))]
    free = random.random() < 0.2
    load = random.normal(size=n) if random.random() < 0.5 else np.zeros(n)
    system = vi.LinearSystem(mass, damping, 0 * stiffness if free else stiffness, load=load)
    frequency = random.uniform(0.5, 4.0)
    forcing = vi.Harmonic(random.normal(size=n), frequency, random.uniform(0, 6)) if random.random() < 0.8 else None
    stops = []
    for _ in range(int(random.integers(0, 5))):
        normal = random.normal(size=n) if random.random() < 0.5 else int(random.integers(n))
        clearance = float(random.choice([0.0, random.uniform(0.01, 0.6)]))
        side = "lower" if random.random() < 0.5 else "upper"
        stops.append(vi.Stop(normal, clearance, float(random.choice([0.0, 0.5, 0.8, 1.0])), side=side))
    zero = random.random() < 0.5
    q0 = np.zeros(n)
    return vi.Scene(system, forcing, stops), q0, np.zeros(n) if zero else random.normal(size=n)
