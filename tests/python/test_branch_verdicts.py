"""Verdicts along branches of random scenes, against samples of their gaps."""

import contextlib
import os

import numpy as np
import pytest

import vibroimpact as vi

#: Scenes; more of them by an environment variable.
COUNT = int(os.environ.get("VIBROIMPACT_SOAK_BRANCHES", "20"))


def some_scene(rng):
    """One to three masses in a row before a stop or two, a number of it and its range."""
    n = int(rng.integers(1, 4))
    springs, damping = rng.uniform(0.5, 4.0, n + 1), rng.uniform(0.02, 0.3)
    stiffness = np.diag(springs[:-1] + springs[1:]) - np.diag(springs[1:-1], 1) - np.diag(springs[1:-1], -1)
    frequency, clearance = float(rng.uniform(0.4, 3.0)), float(rng.uniform(-0.5, 1.0))
    restitution = float(rng.choice([0.0, 0.0, 0.0, 0.3, 0.6, 0.8]))
    stops = [vi.Stop(0, clearance, restitution)]
    if rng.random() < 0.4:
        stops.append(vi.Stop(n - 1, float(rng.uniform(0.1, 1.0)), restitution, side="lower"))
    system = vi.LinearSystem(np.ones(n), damping * np.eye(n), stiffness)
    scene = vi.Scene(system, vi.Harmonic(rng.uniform(0.5, 4.0, n), frequency), stops)
    between = {"forcing_scale": (0.5, 1.6), "frequency": (0.7 * frequency, 1.4 * frequency)}
    name = str(rng.choice(list(between)))
    return scene, name, between[name]


def orbits_of(scene):
    """Orbits of one impact, and what the scene comes to from rest."""
    n = scene.system.n_dof
    found = list(vi.periodic_orbits(scene, [0]))[:1]
    with contextlib.suppress(ValueError, vi.ConvergenceError):
        run = vi.simulate(scene, np.full(n, -0.6), np.zeros(n), (0.0, 60.0 * scene.period))
        found.append(vi.find_orbit(scene, run))
    return found


def deepest(orbit, scene):
    """How far a stop is passed at one of six hundred times of a period."""
    times = np.linspace(0.0, orbit.period, 600)
    q = np.array([orbit.position(t) for t in times])
    last = scene.system.n_dof - 1
    ends = [(q[:, 0], scene.stops[0])] + [(-q[:, last], stop) for stop in scene.stops[1:]]
    return max(float((x - stop.clearance).max()) for x, stop in ends)


@pytest.mark.parametrize("seed", range(200, 200 + COUNT))
def test_no_orbit_that_passes_a_stop_is_admissible(seed):
    scene, name, between = some_scene(np.random.default_rng(seed))
    for orbit in orbits_of(scene):
        try:
            branch = vi.continuation(orbit, name, between, virtual="keep")
        except ValueError:
            # One of a family, or without a phase.
            continue
        for own in branch[::4]:
            if own.is_admissible:
                assert deepest(own, scene) < 1e-8
