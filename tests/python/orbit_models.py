"""Scenes of known orbits, random scenes, and a scene written out from the definitions."""

import os

import numpy as np
from hypothesis import settings

import vibroimpact as vi

CASES = int(os.environ.get("VIBROIMPACT_CASES", "50"))
law = settings(max_examples=CASES, deadline=5000)

N_PERIODS = {1: 3, 2: 2, 3: 2}


def close(value, expected, *, rtol=0.0, atol=0.0):
    """Every entry within the tolerances named, and no others."""
    return np.allclose(value, expected, rtol=rtol, atol=atol)


def dense(coefficient):
    coefficient = np.asarray(coefficient)
    return np.diag(coefficient) if coefficient.ndim == 1 else coefficient


def orbit_of_kind(kind):
    return vi.periodic_orbits(vi.paper_scene(kind), vi.KINDS[kind], N_PERIODS[kind])[0]


def with_newtons_law(scene):
    return scene.replace(stops=[vi.Stop(s.normal, s.clearance, s.restitution) for s in scene.stops])


def at_one_clearance(scene, pattern, n_periods, phase):
    """The orbit of one impact with the given phase, every stop at the clearance that comes out."""
    (orbit,) = vi.periodic_orbits(scene, pattern, n_periods, phase=phase)
    clearance = orbit.scene.stops[pattern[0]].clearance
    (orbit,) = vi.periodic_orbits(scene.replace(clearance=clearance), pattern, n_periods, phase=phase)
    return orbit


class Dynamics:
    """The matrices of a linear scene and its steady response, written out from the definitions."""

    def __init__(self, scene):
        system, n = scene.system, scene.n_dof
        self.n = n
        self.mass, self.damping, self.stiffness = map(dense, (system.mass, system.damping, system.stiffness))
        self.load = system.load
        self.w, self.phase = scene.forcing.frequency, scene.forcing.phase
        if isinstance(scene.forcing, vi.BaseMotion):
            self.force = self.mass @ system.influence * scene.forcing.amplitude * self.w**2
        else:
            self.force = scene.forcing.amplitude
        self.a = np.block(
            [
                [np.zeros((n, n)), np.eye(n)],
                [-np.linalg.solve(self.mass, self.stiffness), -np.linalg.solve(self.mass, self.damping)],
            ]
        )
        self.normals = np.array([self.normal(stop) for stop in scene.stops]).reshape(-1, n)
        self.reactions = np.array(
            [
                np.linalg.solve(self.mass, normal)
                if isinstance(stop.reaction, str) and stop.reaction == "inertia"
                else normal
                if isinstance(stop.reaction, str)
                else stop.reaction
                for normal, stop in zip(self.normals, scene.stops, strict=True)
            ]
        ).reshape(-1, n)
        self.restitution = np.array([stop.restitution for stop in scene.stops])
        self.clearance = np.array([stop.clearance for stop in scene.stops])

    def normal(self, stop):
        normal = np.eye(self.n)[stop.normal] if isinstance(stop.normal, int) else stop.normal
        return -normal if stop.side == "lower" else normal

    def rate(self, t, x):
        push = self.load + (self.force * np.exp(1j * (self.w * t + self.phase))).real
        n = self.n
        return np.concatenate([x[n:], np.linalg.solve(self.mass, push - self.damping @ x[n:] - self.stiffness @ x[:n])])

    def steady(self):
        """Complex amplitude X of the forced response, state (q, v), without the scene's phase."""
        q = np.linalg.solve(self.stiffness - self.w**2 * self.mass + 1j * self.w * self.damping, self.force)
        return np.concatenate([q, 1j * self.w * q])

    def jump(self, stop):
        b, normal = self.reactions[stop], self.normals[stop]
        return np.eye(self.n) - (1 + self.restitution[stop]) * np.outer(b, normal) / (normal @ b)

    def gaps(self, q):
        return self.clearance - q @ self.normals.T


def random_scene(seed, n=None, n_stops=None):
    """A damped system of one to three coordinates, forced, with one or two stops."""
    random = np.random.default_rng(seed)
    n = n or int(random.integers(1, 4))
    a, b, c = random.normal(size=(3, n, n))
    mass, stiffness = a @ a.T + 0.3 * np.eye(n), b @ b.T + 0.3 * np.eye(n)
    damping = 0.05 * stiffness if random.random() < 0.5 else 0.05 * (c @ c.T + 0.1 * np.eye(n))
    stops = [
        vi.Stop(
            random.normal(size=n),
            random.uniform(0.05, 1.0),
            random.uniform(0.2, 1.0),
            side=str(random.choice(["upper", "lower"])),
            reaction=str(random.choice(["inertia", "coordinate"])),
        )
        for _ in range(n_stops or int(random.integers(1, 3)))
    ]
    forcing = vi.Harmonic(random.normal(size=n) + 1j * random.normal(size=n), random.uniform(0.5, 3.0))
    return vi.Scene(vi.LinearSystem(mass, damping, stiffness, load=0.1 * random.normal(size=n)), forcing, stops)
