"""Write one file and one pickle of each class of result, as the installed version makes them: python tests/python/kept/make.py.

The folder beside is named after the version. What is in it is never written again: `test_kept.py` reads it with every later one.
"""

import hashlib
import json
import pickle
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np

import vibroimpact as vi

#: What a motion says of itself, beside its arrays or its orbits.
OF_MOTIONS = {
    "Orbit": ("period", "phase", "n_periods", "pattern", "is_admissible", "is_stable"),
    "Orbits": ("verdict", "reason"),
    "Trajectory": ("t_end", "status", "message"),
}


def scenes():
    """Systems, forcings and stops of every class that is not given by functions."""
    linear = vi.LinearSystem([1.0, 2.0], [0.0, 0.1], [1.0, 2.0], load=[0.0, 1.0], influence=[1.0, 1.0])
    yield "Scene", vi.Scene(linear, vi.Harmonic([1.0, 2.0j], 1.5, 0.1), vi.Stop([1.0, -0.5], 0.2, 0.5, reaction=[1.0, 0.0]))
    chain = vi.PendulumChain([1.0, 2.0, 3.0], [1.0, 1.0, 1.0], 0.1)
    yield "Scene of a chain", vi.Scene(chain, vi.BaseMotion(0.1, 1.5), vi.Wall(1, 0.2, 0.5))
    yield "LinearSystem", linear
    yield "DoublePendulum", vi.DoublePendulum(1.0, 2.0, (0.1, 0.2))
    yield "PendulumChain", chain
    yield "Reduction", vi.reduce([1.0, 1.0], 0.01, np.array([[2.0, -1.0], [-1.0, 2.0]]), n_modes=1, directions=[1])
    yield "Modes", vi.modes(vi.paper_scene(kind=3).system)


def results():
    """One of each class of result."""
    scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
    orbits = vi.periodic_orbits(scene, [0])
    yield "Orbits", orbits
    yield "Orbit", orbits[0]
    yield "Trajectory", vi.simulate(scene, [0.0], [0.0], (0, 12), t_eval=[0.0, 5.0, 12.0])
    yield "Ensemble", vi.simulate_many(scene, [[0.0], [0.5]], [[0.0], [1.0]], (0, 6), keep="impacts")
    yield "ExistenceMap", vi.existence_map(scene, [0], ("frequency", [2.4, 2.5, 2.6]), ("clearance", [0.5, 1.0]))
    yield "PoincarePoints", vi.poincare_points(orbits[0])
    yield "BifurcationDiagram", vi.bifurcation_diagram(scene, ("forcing_scale", [0.9, 1.0]), transient=20, periods=4)
    yield "LyapunovExponents", vi.lyapunov_exponents(scene, [0.0], [0.0], (0, 300), skip=50)
    found = vi.find_attractors(scene, [(-3, 1), (-5, 5)], seeds=6)
    yield "Attractors", found
    yield "Attractor", found[0]
    plane = vi.basins(scene, q=(-3, 1, 8), v=(-5, 5, 8), attractors=found)
    yield "Basins", plane
    yield "Fit", plane.boundary_dimension()
    yield "BasinFractions", vi.basin_fractions(scene, [(-3, 1), (-5, 5)], samples=20, attractors=found)
    monitor = {"period": lambda orbit: orbit.period}
    branch = vi.continuation(orbits[0], "forcing_scale", (0.8, 1.0), max_points=6, monitor=monitor)
    yield "Branch", branch
    special = vi.continuation(orbits[0], "forcing_scale", (0.5, 1.0), max_points=40).special[0]
    yield "Special", special
    candidates = special.branches()
    yield "Candidate", candidates[0]
    yield "Beyond", special.beyond(periods=20)
    yield "BranchTree", vi.BranchTree((branch,), (None,))
    numbers = ("frequency", "forcing_scale"), ((2.3, 2.5), (0.4, 1.0))
    yield "BifurcationCurve", vi.bifurcation_curve(special, *numbers, max_points=4)
    yield "CurvePoint", vi.CurvePoint("fold_flip", (1.0, 2.0), (1e-12, 1e-12), 0.5, special.orbit)
    yield "Derivatives", orbits[0].derivatives(["frequency", "forcing_scale"])


def described(thing):
    """Return what tells a value from others, as JSON has it; of arrays the type, the shape and a digest of the bytes."""
    kind = type(thing).__name__
    if is_dataclass(thing):
        return {"class": kind, "fields": {own.name: described(getattr(thing, own.name)) for own in fields(thing)}}
    if isinstance(thing, (vi.Orbit, vi.Orbits, vi.Trajectory)):
        parts = {name: described(getattr(thing, name)) for name in OF_MOTIONS[kind]}
        rest = list(thing) if isinstance(thing, vi.Orbits) else thing.to_arrays()
        return {"class": kind, "fields": parts, "rest": described(rest)}
    if isinstance(thing, np.ndarray):
        if thing.dtype.names:
            return {name: described(np.ascontiguousarray(thing[name])) for name in thing.dtype.names}
        digest = hashlib.sha256(np.ascontiguousarray(thing).tobytes()).hexdigest()[:16]
        return {"dtype": thing.dtype.str, "shape": list(thing.shape), "digest": digest}
    if isinstance(thing, (list, tuple)):
        return {kind: [described(one) for one in thing]}
    if isinstance(thing, dict):
        return {"dict": {str(name): described(one) for name, one in thing.items()}}
    return thing if thing is None or isinstance(thing, (bool, str)) else repr(thing)


def main():
    folder = Path(__file__).parent / vi.__version__
    folder.mkdir()
    expected = {}
    for name, thing in (*scenes(), *results()):
        (folder / f"{name}.pickle").write_bytes(pickle.dumps(thing, protocol=4))
        if hasattr(thing, "save"):
            thing.save(folder / f"{name}.npz")
        expected[name] = described(thing)
    lines = (f"{json.dumps(name)}: {json.dumps(own, separators=(',', ':'))}" for name, own in expected.items())
    (folder / "expected.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    main()
