"""The certificate of admissibility against minima of the gap in 50-digit arithmetic, many within 1e-9 of touching.

Orbits of random systems of one to three modes hit stop 0 once; a second stop, never hit, is placed so that the least gap to it is
known to 50 digits: by the closed form of theory section 5 in mpmath, independent of the library's arithmetic.
"""

from __future__ import annotations

import os

import mpmath as mp
import numpy as np
import pytest

import vibroimpact as vi

CASES = int(os.environ.get("VIBROIMPACT_CERTIFICATE_CASES", "1000"))
#: Least gaps asked for; a third of the orbits gets each sign and size.
SIZES = [1e-2, 1e-6, 1e-9, 1e-10, 3e-11]


class Motion:
    """A single-impact orbit of uncoupled modes in mpmath: q_j(t) on one flight, t in [0, T]."""

    def __init__(self, w, eta, force, normal, e, frequency, phase, n_periods):
        self.w = [mp.mpf(x) for x in w]
        self.eta = [mp.mpf(x) for x in eta]
        self.frequency = mp.mpf(frequency)
        self.period = 2 * mp.pi * n_periods / self.frequency
        e, normal = mp.mpf(e), [mp.mpf(x) for x in normal]
        turn = mp.expj(mp.mpf(phase))
        self.steady = [
            turn * mp.mpf(f) / (wj**2 - self.frequency**2 + 2j * etaj * self.frequency)
            for f, wj, etaj in zip(force, self.w, self.eta, strict=True)
        ]
        # Free motion after a unit impulse along the normal, repeated for ever: z+ = -(I - P)^-1 (0, n_j).
        self.unit = []
        for wj, etaj, nj in zip(self.w, self.eta, normal, strict=True):
            p = self.propagator(wj, etaj, self.period)
            m = mp.matrix([[1 - p[0], -p[1]], [-p[2], 1 - p[3]]])
            z = mp.lu_solve(m, mp.matrix([0, -nj]))
            self.unit.append((z[0], z[1]))
        # n.v+ = -e n.v-, n.v- = n.v+ + n.n p
        speed = sum(nj * mp.re(1j * self.frequency * y) for nj, y in zip(normal, self.steady, strict=True))
        unit_speed = sum(nj * u[1] for nj, u in zip(normal, self.unit, strict=True))
        self.impulse = -(1 + e) * speed / ((1 + e) * unit_speed + e * sum(nj**2 for nj in normal))

    @staticmethod
    def propagator(w, eta, t):
        """The four entries of e^{At} of one underdamped mode."""
        wd = mp.sqrt(w**2 - eta**2)
        decay = mp.exp(-eta * t)
        s, c = decay * mp.sin(wd * t) / wd, decay * mp.cos(wd * t)
        return c + eta * s, s, -(w**2) * s, c - eta * s

    def along(self, normal, t):
        """n.q, n.q' and n.q'' at t."""
        total = [mp.mpf(0)] * 3
        for nj, wj, etaj, y, u in zip(normal, self.w, self.eta, self.steady, self.unit, strict=True):
            p = self.propagator(wj, etaj, t)
            z = [self.impulse * (p[0] * u[0] + p[1] * u[1]), self.impulse * (p[2] * u[0] + p[3] * u[1])]
            z.append(-2 * etaj * z[1] - wj**2 * z[0])
            rotating = y * mp.expj(self.frequency * t)
            for k in range(3):
                total[k] += mp.mpf(nj) * (z[k] + mp.re((1j * self.frequency) ** k * rotating))
        return total

    def highest(self, normal, times, values):
        """The largest n.q over the period: the highest sampled maxima led to 50 digits, and the instant of impact."""
        best = self.along(normal, mp.mpf(0))[0]
        peaks = [i for i in range(1, len(times) - 1) if values[i - 1] <= values[i] >= values[i + 1]]
        peaks = [i for i in peaks if values[i] > values.max() - 1e-4 * np.ptp(values)]
        # A maximum may hide between the impact and the sample next to it.
        for i in [0, *peaks, len(times) - 1]:
            t = mp.mpf(float(times[i]))
            for _ in range(8):
                _, slope, curvature = self.along(normal, t)
                t -= slope / curvature
            if 0 <= t <= self.period:
                best = max(best, self.along(normal, t)[0])
        return best


def random_orbit(rng):
    """A random scene whose single-impact orbit is admissible for the stop it hits, with what mpmath needs of it."""
    while True:
        n = int(rng.integers(1, 4))
        w = np.sort(rng.uniform(0.5, 6.0, n))
        eta = w * rng.uniform(0.005, 0.3, n)
        force, hit, other = rng.normal(size=(3, n))
        e, frequency, n_periods = rng.uniform(0.3, 0.95), rng.uniform(0.8, 4.0), int(rng.integers(1, 4))
        phase = rng.uniform(0, 2 * np.pi)
        system = vi.LinearSystem(np.ones(n), 2 * eta, w**2)
        scene = vi.Scene(system, vi.Harmonic(force, frequency), vi.Stop(hit, 1.0, e))
        orbits = vi.periodic_orbits(scene, [0], n_periods, phase=phase)
        if len(orbits) == 1 and orbits[0].is_admissible:
            motion = Motion(w, eta, force, hit, e, frequency, phase, n_periods)
            return scene, orbits[0], motion, other, (n_periods, phase)


def test_the_certificate_decides_as_fifty_digits_do():
    rng = np.random.default_rng(20190711)
    with mp.workdps(50):
        for case in range(CASES):
            scene, orbit, motion, normal, (n_periods, phase) = random_orbit(rng)
            times = np.linspace(0, orbit.period, 3000)
            values = orbit.position(times) @ normal
            highest = motion.highest(normal, times, values)
            size = SIZES[case % len(SIZES)] * float(np.abs(values).max())
            clearance = float(highest + (size if case % 2 else -size))
            gap = float(mp.mpf(clearance) - highest)
            both = scene.replace(stops=[scene.stops[0], vi.Stop(normal, clearance, 0.5)])
            again = vi.periodic_orbits(both, [0], n_periods, phase=phase)[0]
            assert again.is_admissible == (gap > 0), (case, gap, again)
            if gap < 0:
                assert again.violation.stop == 1
                assert again.violation.depth == pytest.approx(-gap, abs=1e-12 * (1 + np.abs(values).max()))
