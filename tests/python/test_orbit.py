"""Periodic orbits against the paper's cases, closed forms, independent solves and integration."""

import copy
import itertools
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import block_diag, expm

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


class TestPaper:
    def test_kind_1(self):
        """Theory 3: phase, position and speeds at the corner, multipliers in both orders of the impacts."""
        scene = vi.paper_scene(kind=1, damping=0.05, clearance=1.0)
        orbits = vi.periodic_orbits(scene, [(0, 1)], 3, free="clearance")
        assert orbits.verdict == "found"
        orbit = orbits[0]
        assert np.degrees(orbit.phase) == pytest.approx(73.0915, abs=5e-5)
        assert orbit.q0 == pytest.approx([0.806286, 0.806286], abs=5e-7)
        assert orbit.v0 == pytest.approx([-0.105278, -0.198472], abs=5e-7)
        assert [stop.clearance for stop in orbit.scene.stops] == pytest.approx(2 * [0.806286], abs=5e-7)
        assert orbit.is_admissible
        assert orbit.is_stable is True
        orders = orbit.stability.orders
        assert set(orders) == {(0, 1), (1, 0)}
        assert sorted(np.abs(m).max() for m in orders.values()) == pytest.approx([0.79333, 0.79341], abs=5e-6)
        assert np.abs(orbit.floquet_multipliers).max() == pytest.approx(0.79341, abs=5e-6)

    @pytest.mark.parametrize(("zeta", "expected"), [(0.07, [0.753, 1.775]), (0.1, [2.14, 3.42])])
    def test_kind_1_with_more_damping(self, zeta, expected):
        scene = vi.paper_scene(kind=1, damping=zeta, clearance=1.0)
        orbits = vi.periodic_orbits(scene, [(0, 1)], 3, free="clearance")
        orbit = next(o for o in orbits if np.all(o.impacts["speed_before"] > 0))
        found = sorted(np.abs(m).max() for m in orbit.stability.orders.values())
        assert found == pytest.approx(expected, rel=3e-3)
        assert orbit.is_stable is False

    def test_kind_1_closed_form(self):
        """Theory 3, corrected (30)-(35): each mode bounces as if alone."""
        orbit = orbit_of_kind(1)
        modes = vi.modes(orbit.scene.system)
        e, w, period = 0.9, 1.5, orbit.period
        eta = modes.natural_frequencies * modes.damping_ratios
        wd = np.sqrt(modes.natural_frequencies**2 - eta**2)
        dynamics = Dynamics(orbit.scene)
        forces = modes.shapes.T @ dynamics.force
        response = forces * np.exp(1j * orbit.phase) / (modes.natural_frequencies**2 - w**2 + 2j * eta * w)
        decay, cosine, sine = np.exp(-eta * period), np.cos(wd * period), np.sin(wd * period)
        g, h = eta * cosine + wd * sine, wd * cosine - eta * sine
        k, m = 1 - decay * cosine, decay * sine
        n, p = eta + e * decay * g, wd + e * decay * h
        scale = -(1 + e) * w * -response.imag / (k * p - m * n)
        found = orbit.coefficients
        assert close(found.A, -response.imag, atol=1e-13)
        assert close(found.B, response.real, atol=1e-13)
        assert close(found.a, scale * m, atol=1e-10)
        assert close(found.b, scale * k, atol=1e-10)

    def test_kind_2(self):
        """Admissible for light damping only: phases of 12 to 24 degrees at zeta = 0.01, all stable; none at 0.015."""
        scene = vi.paper_scene(kind=2, damping=0.01)
        admissible = {}
        for degrees in range(0, 360, 2):
            orbit = at_one_clearance(scene, [0], 2, np.radians(degrees))
            if orbit.is_admissible:
                admissible[degrees] = orbit
        assert list(admissible) == [12, 14, 16, 18, 20, 22, 24]
        assert all(orbit.is_stable for orbit in admissible.values())
        assert admissible[12].scene.stops[0].clearance == pytest.approx(0.354, abs=5e-4)
        assert admissible[24].scene.stops[0].clearance == pytest.approx(0.712, abs=5e-4)
        for orbit in admissible.values():  # the small gap of Fig. 6a, at the lower pendulum
            assert 0 < orbit.scene.gaps(orbit.position(np.linspace(0, orbit.period, 4000)))[:, 1].min() < 0.013
        damped = vi.paper_scene(kind=2, damping=0.015)
        for degrees in range(0, 360, 2):
            assert not at_one_clearance(damped, [0], 2, np.radians(degrees)).is_admissible

    def test_kind_3(self):
        """Admissible at zeta = 0.05 for phases of 94 to 189 degrees, clearances 0.111 to 0.178, half of them stable."""
        scene = vi.paper_scene(kind=3, damping=0.05)
        orbits = [at_one_clearance(scene, [1], 2, np.radians(degrees)) for degrees in np.arange(94.0, 190.0)]
        clearances = [orbit.scene.stops[1].clearance for orbit in orbits]
        assert all(orbit.is_admissible for orbit in orbits)
        assert min(clearances) == pytest.approx(0.111, abs=1e-3)
        assert max(clearances) == pytest.approx(0.178, abs=1e-3)
        assert 0.4 < np.mean([orbit.is_stable for orbit in orbits]) < 0.6

    @pytest.mark.parametrize("kind", [1, 2, 3])
    def test_default_scenes_have_an_admissible_orbit(self, kind):
        orbit = orbit_of_kind(kind)
        assert orbit.is_admissible
        assert orbit.violation is None
        assert orbit.pattern == vi.KINDS[kind]
        assert orbit.n_periods == N_PERIODS[kind]

    def test_kind_4_is_the_steady_response(self):
        scene = vi.paper_scene(kind=3)
        orbits = vi.periodic_orbits(scene, vi.KINDS[4])
        dynamics = Dynamics(scene)
        steady = dynamics.steady() * np.exp(1j * orbits[0].phase)
        assert close(orbits[0].q0, steady[:2].real, atol=1e-12)
        assert close(orbits[0].v0, steady[2:].real, atol=1e-12)
        assert len(orbits[0].impacts) == 0
        crossed = np.any(scene.gaps(orbits[0].position(np.linspace(0, scene.period, 200))) < 0)
        assert orbits[0].is_admissible == (not crossed)
        assert close(
            np.sort_complex(orbits[0].floquet_multipliers),
            np.sort_complex(np.exp(scene.period * np.linalg.eigvals(dynamics.a))),
            atol=1e-10,
        )

    def test_kind_1_with_unequal_clearances_has_none(self):
        """Two conditions on one phase: none, and the mismatch is told."""
        scene = vi.paper_scene(kind=1).replace(clearance=[0.8, 0.5])
        orbits = vi.periodic_orbits(scene, [(0, 1)], 3)
        assert orbits.verdict == "none"
        assert len(orbits) == 0
        assert orbits.margin is not None
        assert orbits.reason


class TestClosedForms:
    def test_ball_on_a_shaken_table(self):
        """In the frame of the table q'' = -g + a w^2 cos(w t + phase), impact at q = 0, once a period T.

        q(T) = 0 gives v+ - a w sin(phase) = g T/2, and v(T-) = v+ - g T (the forcing has no mean) gives
        v+ = e g T/(1 + e): the numbers of theory 5, its phase turned by the sign of the table's motion.
        """
        e, g, a, w = 0.8, 1.0, 0.6, 1.2
        scene = vi.Scene(vi.LinearSystem(1, 0, 0, load=-g, influence=1), vi.BaseMotion(a, w), vi.Stop(0, 0, e, side="lower"))
        period = 2 * np.pi / w
        speed = e * g * period / (1 + e)
        phase = np.arcsin((speed - g * period / 2) / (a * w))
        orbits = vi.periodic_orbits(scene, [0])
        assert len(orbits) == 2
        assert sorted(o.phase for o in orbits) == pytest.approx(sorted([phase % (2 * np.pi), (np.pi - phase) % (2 * np.pi)]))
        for orbit in orbits:
            assert orbit.v0[0] == pytest.approx(speed, rel=1e-10)
            assert orbit.q0[0] == pytest.approx(0, abs=1e-12)
            assert orbit.impacts["speed_before"][0] == pytest.approx(speed / e, rel=1e-10)
            t = np.linspace(0, period, 50, endpoint=False)
            slope = speed - a * w * np.sin(orbit.phase)
            expected = slope * t - g * t**2 / 2 + a * (np.cos(orbit.phase) - np.cos(w * t + orbit.phase))
            assert close(orbit.position(t)[:, 0], expected, atol=1e-10)

    @law
    @given(st.integers(0, 2**32 - 1), st.integers(1, 3))
    def test_the_matrix_solve(self, seed, n_periods):
        """(29): (I - R e^{AT}) z = (R - I) s(0), with the phase given, by matrices of its own."""
        scene = random_scene(seed, n_stops=1)
        dynamics = Dynamics(scene)
        n, phase = dynamics.n, float(np.random.default_rng(seed).uniform(0, 2 * np.pi))
        flow = expm(dynamics.a * n_periods * scene.period)
        recovery = block_diag(np.eye(n), dynamics.jump(0))
        system = np.eye(2 * n) - recovery @ flow
        assume(np.linalg.cond(system) < 1e6)
        rest = np.concatenate([np.linalg.solve(dynamics.stiffness, dynamics.load), np.zeros(n)])
        steady = (dynamics.steady() * np.exp(1j * phase)).real + rest
        state = np.linalg.solve(system, (recovery - np.eye(2 * n)) @ steady) + steady
        (orbit,) = vi.periodic_orbits(scene, [0], n_periods, phase=phase)
        scale = 1e-9 * (1 + np.abs(state).max())
        assert close(np.concatenate([orbit.q0, orbit.v0]), state, atol=scale)
        assert orbit.phase == pytest.approx(phase, abs=1e-12)
        contact = dynamics.normals[0] @ state[:n]
        assert orbit.scene.stops[0].clearance == pytest.approx(contact, abs=scale)
        assert orbit.period == pytest.approx(n_periods * scene.period, rel=1e-14)

    @law
    @given(st.integers(0, 2**32 - 1))
    def test_phase_and_clearance_are_inverse(self, seed):
        """The clearance that comes out for a phase has an orbit with this phase."""
        scene = random_scene(seed, n_stops=1)
        phase = float(np.random.default_rng(seed).uniform(0, 2 * np.pi))
        (orbit,) = vi.periodic_orbits(scene, [0], phase=phase)
        found = vi.periodic_orbits(orbit.scene, [0])
        assume(found.margin > 1e-3)
        assert len(found) == 2
        distance = [np.abs(np.exp(1j * o.phase) - np.exp(1j * phase)) for o in found]
        assert min(distance) < 1e-7

    def test_the_fold(self):
        """One stop: n.q = d with d = |alpha| cos(phase - phase_0): none, one or two orbits."""
        scene = vi.Scene(vi.LinearSystem(1, 0.2, 1), vi.Harmonic(1, 2.8), vi.Stop(0, 0, 0.8))
        clearances = [
            vi.periodic_orbits(scene, [0], phase=phase)[0].scene.stops[0].clearance
            for phase in np.linspace(0, 2 * np.pi, 4, endpoint=False)
        ]
        largest = np.hypot(clearances[0], clearances[1])
        assert clearances[0] == pytest.approx(-clearances[2], rel=1e-9)
        for factor, count in [(0.5, 2), (1 - 1e-9, 2), (1 + 1e-9, 0), (2, 0)]:
            orbits = vi.periodic_orbits(scene.replace(clearance=factor * largest), [0])
            assert len(orbits) == count
            assert orbits.verdict == ("found" if count else "none")
            assert orbits.margin == pytest.approx(1 - factor, abs=1e-11)

    @pytest.mark.parametrize(("kind", "dimension"), [(1, 2), (2, 1), (3, 1)])
    @pytest.mark.parametrize("phase", [0.0, np.pi])
    def test_families_without_loss(self, kind, dimension, phase):
        """Theory 5: e = 1 without damping, at phase 0 or pi a family, at any other none."""
        scene = vi.paper_scene(kind, damping=0.0).replace(restitution=1)
        orbits = vi.periodic_orbits(scene, vi.KINDS[kind], N_PERIODS[kind], phase=phase)
        assert orbits.verdict == "family"
        assert orbits.family.dimension == dimension
        assert orbits.family.basis.shape == (4, dimension)
        recovery = vi.recovery_matrix(scene, vi.KINDS[kind][0])
        monodromy = recovery @ expm(Dynamics(scene).a * N_PERIODS[kind] * scene.period)
        assert close(monodromy @ orbits.family.basis, orbits.family.basis, atol=1e-8)
        other = vi.periodic_orbits(scene, vi.KINDS[kind], N_PERIODS[kind], phase=1.0)
        assert other.verdict == "none"
        assert other.family is None

    def test_an_orbit_in_the_forcing_scale(self):
        """Linear without load: scaling the forcing by s or the clearances by 1/s is the same orbit."""
        scene = vi.paper_scene(kind=1, clearance=0.3)
        by_force = vi.periodic_orbits(scene, [(0, 1)], 3, free="forcing_scale")[0]
        by_clearance = vi.periodic_orbits(scene, [(0, 1)], 3, free="clearance")[0]
        scale = 0.3 / by_clearance.scene.stops[0].clearance
        assert by_force.phase == pytest.approx(by_clearance.phase, abs=1e-10)
        assert close(by_force.q0, scale * by_clearance.q0, atol=1e-10)
        assert by_force.scene.forcing.amplitude == pytest.approx(scale * scene.forcing.amplitude, rel=1e-9)

    def test_a_free_parameter_in_a_range(self):
        """Kind 1 closes at zeta = 0.05 for the clearance of theory 3: the damping is found again."""
        orbit = vi.periodic_orbits(vi.paper_scene(1, damping=0.05), [(0, 1)], 3, free="clearance")[0]
        scene = orbit.scene.replace(damping_scale=0.8)
        found = vi.periodic_orbits(scene, [(0, 1)], 3, free="damping_scale", between=(1.0, 1.5))
        assert any(close(o.scene.system.damping, orbit.scene.system.damping, rtol=1e-7) for o in found)


class TestMotion:
    @pytest.mark.parametrize("kind", [1, 2, 3])
    def test_integration_retraces_the_orbit(self, kind):
        orbit = orbit_of_kind(kind)
        dynamics = Dynamics(orbit.scene)
        times = np.linspace(0, orbit.period, 201)
        run = solve_ivp(
            dynamics.rate,
            (0, orbit.period),
            np.concatenate([orbit.q0, orbit.v0]),
            method="DOP853",
            t_eval=times,
            rtol=1e-12,
            atol=1e-14,
        )
        assert close(run.y[:2].T, orbit.position(times), atol=1e-9)
        assert close(run.y[2:, :-1].T, orbit.velocity(times[:-1]), atol=1e-9)
        before = orbit.velocity(orbit.period, side="before")
        assert close(run.y[2:, -1], before, atol=1e-9)
        after = before.copy()
        for stop in np.atleast_1d(vi.KINDS[kind][0]):
            after = dynamics.jump(stop) @ after
        assert close(after, orbit.v0, atol=1e-9)

    @law
    @given(st.integers(0, 2**32 - 1))
    def test_integration_retraces_random_orbits(self, seed):
        orbits = vi.periodic_orbits(random_scene(seed), [0])
        assume(len(orbits))
        orbit = orbits[0]
        dynamics = Dynamics(orbit.scene)
        n = dynamics.n
        start = np.concatenate([orbit.q0, orbit.v0])
        run = solve_ivp(dynamics.rate, (0, orbit.period), start, method="DOP853", rtol=1e-11, atol=1e-12)
        scale = 1 + np.abs(start).max()
        assert close(run.y[:n, -1], orbit.q0, atol=1e-7 * scale)
        assert close(dynamics.jump(0) @ run.y[n:, -1], orbit.v0, atol=1e-7 * scale)
        assert dynamics.gaps(orbit.q0)[0] == pytest.approx(0, abs=1e-10 * scale)

    @pytest.mark.parametrize("kind", [1, 2, 3])
    def test_simulation_retraces_the_orbit(self, kind):
        orbit = orbit_of_kind(kind)
        end = 20.5 * orbit.period
        run = vi.simulate(orbit.scene, orbit.q0, orbit.v0, (0, end))
        if kind == 1:  # two stops at one instant, decoupled under the paper's law: the corner itself is exact
            assert run.status in ("finished", "unresolved_contact")
            return
        assert run.status == "finished"
        assert len(run.impacts) == 20
        assert close(run.impacts["time"], orbit.period * np.arange(1, 21), atol=1e-7)
        times = np.linspace(0, end, 50)
        assert close(run.position(times), orbit.position(times), atol=1e-7)

    def test_it_is_periodic(self):
        orbit = orbit_of_kind(3)
        t = np.linspace(-3, 3, 31) * orbit.period + 0.1
        assert close(orbit.position(t + 5 * orbit.period), orbit.position(t), atol=1e-12)
        assert close(orbit.velocity(t + 5 * orbit.period), orbit.velocity(t), atol=1e-12)
        assert close(orbit.position(0.0), orbit.q0)
        assert close(orbit.velocity(0.0), orbit.v0)

    def test_velocity_is_the_derivative_of_position(self):
        orbit = orbit_of_kind(3)
        t = np.linspace(0.1, 0.9, 17) * orbit.period
        h = 1e-5
        slope = (orbit.position(t + h) - orbit.position(t - h)) / (2 * h)
        assert close(slope, orbit.velocity(t), atol=1e-8)

    def test_both_sides_of_the_impact(self):
        orbit = orbit_of_kind(3)
        impact = orbit.impacts[0]
        before, after = (orbit.velocity(0.0, side=side) for side in ("before", "after"))
        assert impact["time"] == 0.0
        assert impact["stop"] == 1
        assert before[1] == pytest.approx(impact["speed_before"], rel=1e-12)
        assert after[1] == pytest.approx(-impact["speed_after"], rel=1e-12)
        assert impact["speed_after"] == pytest.approx(0.9 * impact["speed_before"], rel=1e-12)
        assert impact["impulse"] == pytest.approx(1.9 * impact["speed_before"], rel=1e-12)  # b = n = unit vector
        assert after[0] == pytest.approx(before[0], rel=1e-12)
        assert impact["phase"] == pytest.approx(orbit.phase, abs=1e-12)
        assert close(orbit.velocity(1.0, side="before"), orbit.velocity(1.0), atol=0)

    def test_impulse_under_newtons_law(self):
        """M (v+ - v-) = -n p."""
        orbit = at_one_clearance(with_newtons_law(vi.paper_scene(kind=3)), [1], 2, np.radians(160))
        jump = orbit.velocity(0.0) - orbit.velocity(0.0, side="before")
        assert close(dense(orbit.scene.system.mass) @ jump, [0, -orbit.impacts["impulse"][0]], atol=1e-12)

    def test_coefficients_of_14(self):
        """q = Phi (e^{-eta t} (a cos wd t + b sin wd t) + A sin w t + B cos w t)."""
        orbit = orbit_of_kind(3)
        modes, found = vi.modes(orbit.scene.system), orbit.coefficients
        eta = modes.natural_frequencies * modes.damping_ratios
        wd = np.sqrt(modes.natural_frequencies**2 - eta**2)
        t = np.linspace(0, orbit.period, 40, endpoint=False)[:, None]
        free = np.exp(-eta * t) * (found.a * np.cos(wd * t) + found.b * np.sin(wd * t))
        forced = found.A * np.sin(1.5 * t) + found.B * np.cos(1.5 * t)
        assert close((free + forced) @ modes.shapes.T, orbit.position(t[:, 0]), atol=1e-12)

    def test_no_coefficients_where_modes_are_complex(self):
        scene = vi.Scene(
            vi.DoublePendulum(1, 3.2, (0.02, 0.05)).linearise(),
            vi.BaseMotion(0.04, 1.5),
            [vi.Stop(i, 0.1, 0.9) for i in range(2)],
        )
        assert all(orbit.coefficients is None for orbit in vi.periodic_orbits(scene, [1], 2))

    def test_shapes(self):
        orbit = orbit_of_kind(3)
        assert orbit.position(0.5).shape == (2,)
        assert orbit.position([0.5]).shape == (1, 2)
        assert orbit.position([]).shape == (0, 2)
        assert orbit.velocity(np.linspace(0, 1, 5, dtype=np.float32), side="before").shape == (5, 2)
        assert orbit.q0.shape == orbit.v0.shape == (2,)
        assert orbit.floquet_multipliers.shape == (4,)
        assert orbit.floquet_multipliers.dtype == complex
        assert orbit.monodromy.shape == (4, 4)
        assert orbit.impacts.dtype.names == ("time", "stop", "speed_before", "speed_after", "impulse", "phase")
        assert 0 <= orbit.phase < 2 * np.pi


class TestAdmissibility:
    @settings(max_examples=max(CASES, 100), deadline=5000)
    @given(st.integers(0, 2**32 - 1), st.integers(1, 2))
    def test_the_certificate_agrees_with_a_dense_scan(self, seed, n_periods):
        scene = random_scene(seed)
        for orbit in vi.periodic_orbits(scene, [0], n_periods):
            dynamics = Dynamics(orbit.scene)
            times = np.linspace(0, orbit.period, 20_001)
            q = orbit.position(times)
            gaps = dynamics.gaps(q)
            scale = 1 + np.abs(gaps).max()
            before = dynamics.normals[0] @ orbit.velocity(0.0, side="before")
            lowest = gaps.min()
            if orbit.is_admissible:
                assert lowest > -1e-6 * scale
                assert before > 0
                assert orbit.violation is None
            else:
                violation = orbit.violation
                assert lowest < 1e-6 * scale or before <= 0
                if violation.depth > 1e-4 * scale:
                    assert violation.depth == pytest.approx(-gaps[:, violation.stop].min(), abs=1e-5 * scale)
                    there = dynamics.gaps(orbit.position(violation.time))
                    assert there[violation.stop] == pytest.approx(-violation.depth, abs=1e-8 * scale)
            if before < -1e-6 * scale or lowest < -1e-4 * scale:
                assert not orbit.is_admissible

    def test_order_of_the_orbits(self):
        """Stable and admissible first, then admissible, then by depth of the violation."""
        found = 0
        for seed in range(60):
            orbits = vi.periodic_orbits(random_scene(seed), [0])
            rank = [0 if o.is_admissible and o.is_stable else 1 if o.is_admissible else 2 for o in orbits]
            assert rank == sorted(rank)
            depths = [o.violation.depth for o in orbits if not o.is_admissible]
            assert depths == sorted(depths)
            found += len(orbits)
        assert found > 40

    def test_a_violation_is_told(self):
        orbit = at_one_clearance(vi.paper_scene(kind=2, damping=0.05), [0], 2, 0.3)
        assert not orbit.is_admissible
        assert orbit.violation.reason
        assert 0 <= orbit.violation.time <= orbit.period
        assert orbit.violation.stop in (0, 1)


class TestStability:
    @pytest.mark.parametrize(
        ("scene", "phases"),
        [(vi.paper_scene(kind=3), [95, 120, 150, 185]), (with_newtons_law(vi.paper_scene(kind=3)), [150, 165, 180])],
        ids=["coordinate", "inertia"],
    )
    @pytest.mark.parametrize("place", [0.2, 0.5])
    def test_against_the_simulated_return_map(self, scene, phases, place):
        for degrees in phases:
            orbit = at_one_clearance(scene, [1], 2, np.radians(degrees))
            assert orbit.is_admissible
            t0, h = place * orbit.period, 1e-6
            start = np.concatenate([orbit.position(t0), orbit.velocity(t0)])

            def returned(x, orbit=orbit, t0=t0):
                run = vi.simulate(orbit.scene, x[:2], x[2:], (t0, t0 + orbit.period), keep="final")
                assert run.stats.n_impacts == 1
                return np.concatenate(run.final)

            assert close(returned(start), start, atol=1e-10)

            def slopes(h, start=start, returned=returned):
                return np.column_stack([(returned(start + d) - returned(start - d)) / (2 * h) for d in h * np.eye(4)])

            jacobian = (4 * slopes(h) - slopes(2 * h)) / 3  # fourth order
            found = np.linalg.eigvals(jacobian)
            size = np.abs(found).max()
            distance = np.abs(found[:, None] - orbit.floquet_multipliers[None, :])
            assert distance.min(axis=0).max() < 3e-7 * size
            assert distance.min(axis=1).max() < 3e-7 * size

    @law
    @given(st.integers(0, 2**32 - 1), st.integers(1, 2))
    def test_determinant(self, seed, n_periods):
        """det(monodromy) = prod(e_i^2) exp(-T tr(M^-1 C))."""
        for orbit in vi.periodic_orbits(random_scene(seed), [0], n_periods):
            assume(orbit.monodromy is not None)
            dynamics = Dynamics(orbit.scene)
            decay = np.exp(-orbit.period * np.trace(np.linalg.solve(dynamics.mass, dynamics.damping)))
            expected = dynamics.restitution[0] ** 2 * decay
            size = max(1.0, np.abs(orbit.monodromy).max()) ** (2 * dynamics.n)
            assert np.linalg.det(orbit.monodromy) == pytest.approx(expected, rel=1e-6, abs=1e-13 * size)
            assert np.prod(orbit.floquet_multipliers).real == pytest.approx(expected, rel=1e-6, abs=1e-13 * size)

    @pytest.mark.parametrize("kind", [1, 2, 3])
    def test_determinant_of_the_papers_orbits(self, kind):
        orbit = orbit_of_kind(kind)
        dynamics = Dynamics(orbit.scene)
        decay = np.exp(-orbit.period * np.trace(np.linalg.solve(dynamics.mass, dynamics.damping)))
        expected = 0.9 ** (2 * len(orbit.impacts)) * decay
        for multipliers in orbit.stability.orders.values():
            assert np.prod(multipliers) == pytest.approx(expected, rel=1e-9)

    def test_multipliers_are_the_eigenvalues_of_the_monodromy(self):
        orbit = orbit_of_kind(3)
        found = np.sort_complex(np.linalg.eigvals(orbit.monodromy))
        assert close(np.sort_complex(orbit.floquet_multipliers), found, atol=1e-9)
        assert np.all(np.diff(np.abs(orbit.floquet_multipliers)) <= 1e-12)

    def test_stability_is_what_the_multipliers_say(self):
        for seed in range(30):
            for orbit in vi.periodic_orbits(random_scene(seed), [0]):
                if orbit.is_stable is not None:
                    assert orbit.is_stable == (np.abs(orbit.floquet_multipliers).max() < 1)
                    assert orbit.stability.is_stable == orbit.is_stable
                assert orbit.stability.reason

    def test_coupled_stops_have_no_multipliers(self):
        """n_i . b_j nonzero: the return map is discontinuous at the corner."""
        scene = with_newtons_law(vi.paper_scene(kind=1))
        orbits = vi.periodic_orbits(scene, [(0, 1)], 3, free="clearance")
        assert len(orbits)
        for orbit in orbits:
            assert orbit.floquet_multipliers is None
            assert orbit.monodromy is None
            assert orbit.is_stable is None
            assert orbit.stability.orders == {}
            assert "discontinuous" in orbit.stability.reason


class TestObjects:
    def test_a_sequence(self):
        orbits = vi.periodic_orbits(vi.paper_scene(kind=3), [1], 2)
        assert len(orbits) == 2
        assert [o.phase for o in orbits] == [orbits[0].phase, orbits[1].phase]
        assert orbits[-1].phase == orbits[1].phase
        assert [o.phase for o in orbits[::-1]] == [orbits[1].phase, orbits[0].phase]
        assert orbits[np.int64(1)].phase == orbits[1].phase
        assert len(orbits[5:]) == 0
        assert next(reversed(orbits)).phase == orbits[1].phase
        for index in (2, -3):
            with pytest.raises(IndexError):
                orbits[index]
        with pytest.raises(TypeError):
            orbits["first"]
        with pytest.raises(TypeError):
            orbits[0] = orbits[1]
        with pytest.raises(TypeError):
            del orbits[0]

    @pytest.mark.parametrize(
        "copied", [lambda x: pickle.loads(pickle.dumps(x)), copy.copy, copy.deepcopy], ids=["pickle", "copy", "deep"]
    )
    @pytest.mark.parametrize("kind", [1, 2, 3])
    def test_copies_are_equal(self, copied, kind):
        orbits = vi.periodic_orbits(vi.paper_scene(kind), vi.KINDS[kind], N_PERIODS[kind])
        other = copied(orbits)
        assert (len(other), other.verdict, other.reason, other.margin) == (
            len(orbits),
            orbits.verdict,
            orbits.reason,
            orbits.margin,
        )
        t = np.linspace(-1, 20, 50)
        for one, two in itertools.chain(zip(orbits, other, strict=True), [(orbits[0], copied(orbits[0]))]):
            assert repr(two) == repr(one)
            assert two.scene == one.scene
            assert (two.period, two.phase, two.pattern, two.n_periods) == (
                one.period,
                one.phase,
                one.pattern,
                one.n_periods,
            )
            assert np.array_equal(two.q0, one.q0)
            assert np.array_equal(two.v0, one.v0)
            assert np.array_equal(two.position(t), one.position(t))
            assert np.array_equal(two.impacts, one.impacts)
            assert np.array_equal(two.floquet_multipliers, one.floquet_multipliers)
            assert (two.is_admissible, two.is_stable) == (one.is_admissible, one.is_stable)

    def test_a_family_is_copied_with_its_basis(self):
        scene = vi.paper_scene(3, damping=0.0).replace(restitution=1)
        orbits = vi.periodic_orbits(scene, [1], 2, phase=0.0)
        other = pickle.loads(pickle.dumps(orbits))
        assert other.verdict == "family"
        assert np.array_equal(other.family.basis, orbits.family.basis)

    @pytest.mark.parametrize("part", ["coefficients", "stability", "violation", "family"])
    def test_parts_can_be_pickled(self, part):
        orbit = orbit_of_kind(3)
        family = vi.periodic_orbits(vi.paper_scene(3, damping=0.0).replace(restitution=1), [1], 2, phase=0.0).family
        violation = at_one_clearance(vi.paper_scene(kind=2, damping=0.05), [0], 2, 0.3).violation
        value = {
            "coefficients": orbit.coefficients,
            "stability": orbit.stability,
            "violation": violation,
            "family": family,
        }[part]
        assert repr(pickle.loads(pickle.dumps(value))) == repr(value)

    def test_nothing_can_be_set(self):
        orbits = vi.periodic_orbits(vi.paper_scene(kind=3), [1], 2)
        orbit = orbits[0]
        parts = [
            (orbits, "verdict"),
            (orbit, "phase"),
            (orbit, "is_admissible"),
            (orbit.coefficients, "a"),
            (orbit.stability, "reason"),
            (orbit, "anything"),
            (orbits, "anything"),
        ]
        for value, name in parts:
            with pytest.raises(AttributeError):
                setattr(value, name, 1)
        orbit.q0[:] = 7
        assert not np.any(orbit.q0 == 7)

    @pytest.mark.parametrize("kind", [1, 2, 3])
    def test_repr_fits_a_screen(self, kind):
        orbits = vi.periodic_orbits(vi.paper_scene(kind), vi.KINDS[kind], N_PERIODS[kind])
        assert len(repr(orbits).splitlines()) <= 24
        text = repr(orbits[0])
        assert len(text.splitlines()) <= 24
        for word in ("phase", "q0", "admissible", "stable", "multipliers"):
            assert word in text

    def test_arrays(self, tmp_path):
        orbit = orbit_of_kind(3)
        np.savez(tmp_path / "orbit.npz", **orbit.to_arrays())
        with np.load(tmp_path / "orbit.npz") as arrays:
            assert np.array_equal(arrays["q0"], orbit.q0)
            assert np.array_equal(arrays["floquet_multipliers"], orbit.floquet_multipliers)
            assert np.array_equal(arrays["impacts"], orbit.impacts)

    def test_patterns_of_any_iterable(self):
        scene = vi.paper_scene(kind=3)
        phases = [
            vi.periodic_orbits(scene, pattern, 2)[0].phase
            for pattern in ([1], (1,), np.array([1]), [(1,)], [[1]], [np.int32(1)], iter([1]))
        ]
        assert len(set(phases)) == 1


class TestSpeeds:
    """What impacts list is the law of restitution itself: no rounding, no minus zero."""

    @pytest.mark.parametrize("restitution", [0.0, 0.3, 1.0])
    def test_an_orbit_leaves_at_restitution_times_the_approach(self, restitution):
        scene = vi.paper_scene(kind=3).replace(restitution=restitution, clearance=0.05)
        orbits = vi.periodic_orbits(scene, [1], 2)
        assert len(orbits) == 2
        for orbit in orbits:
            before, after = orbit.impacts["speed_before"], orbit.impacts["speed_after"]
            assert np.array_equal(after, restitution * before)
            assert not np.any(np.signbit(after) & (after == 0))
            # and the motion keeps it to rounding
            assert -orbit.v0[1] == pytest.approx(after[0], abs=1e-12)

    def test_stops_hit_together_each_keep_their_own(self):
        # coupled by inertia: reaction M^-1 n, both normals turned at once
        scene = vi.paper_scene(kind=1)
        stops = [vi.Stop(i, 0.15, e) for i, e in ((0, 0.0), (1, 0.7))]
        for orbit in vi.periodic_orbits(scene.replace(stops=stops), [(0, 1)], 3, free="clearance"):
            before, after = orbit.impacts["speed_before"], orbit.impacts["speed_after"]
            assert np.array_equal(after, [0.0, 0.7] * before)
            assert not np.signbit(after[0])
            assert np.allclose(-orbit.v0, after, rtol=0, atol=1e-12)

    @pytest.mark.parametrize("method", ["exact", "rk45"])
    @pytest.mark.parametrize("restitution", [0.0, 0.6])
    def test_a_trajectory_too(self, method, restitution):
        system = vi.LinearSystem(1.0, 0.1, 1.0)
        scene = vi.Scene(system, vi.Harmonic(1.0, 2.8), vi.Stop([0.7], -0.02, restitution))
        run = vi.simulate(scene, -1.0, 0.3, (0, 40), method=method)
        before, after = run.impacts["speed_before"], run.impacts["speed_after"]
        assert len(before) >= 2
        assert np.all(before >= 0)
        assert np.array_equal(after, restitution * before)
        assert not np.any(np.signbit(after))
        # and the motion keeps it to rounding; the last impact may end the run
        flown = run.impacts["time"] < run.segments["end"][-1]
        assert flown.sum() >= 1
        assert np.allclose(-0.7 * run.velocity(run.impacts["time"][flown])[:, 0], after[flown], rtol=0, atol=1e-12)

    def test_a_repr_shows_no_minus_zero(self):
        orbits = vi.periodic_orbits(vi.paper_scene(kind=3).replace(restitution=0.0, clearance=0.05), [1], 2)
        assert len(orbits) == 2
        assert "-0.000000" not in repr(orbits)


LONG = {
    "one_instant": "vi.periodic_orbits(slow, [0])",
    "longest_period": "vi.periodic_orbits(slow.replace(frequency=1.0001e-12), [0])",
    "longest_map": "vi.existence_map(slow, [0], ('frequency', [1.0001e-12]), ('clearance', [0.5]), workers=1)",
    "longest_map_on_threads": "vi.existence_map(slow, [0], ('frequency', np.linspace(1.1e-12, 2e-12, 600)), ('phase', [0]))",
    "is_admissible": "vi.periodic_orbits(slow, [0], phase=0.3)[0].is_admissible",
    "violation": "vi.periodic_orbits(slow, [0], phase=0.3)[0].violation",
    "multipliers": "vi.periodic_orbits(slow, [0], phase=0.3)[0].floquet_multipliers",
    "repr": "repr(vi.periodic_orbits(slow, [0], phase=0.3))",
    "two_instants": "vi.periodic_orbits(wide.replace(damping_scale=1e-3), [0, 1], 1000)",
    "free": "vi.periodic_orbits(wide, [(0, 1)], free='frequency', between=(0.1, 10.0))",
    "existence_map": "vi.existence_map(lambda x, y: slow.replace(clearance=x), [0], [0.5], [0.5], workers=1)",
}

CHILD = """
import signal
import numpy as np
import vibroimpact as vi

# 1e9 natural periods in one of the forcing: every search walks over all of them.
slow = vi.Scene(
    vi.LinearSystem([[1.0]], [[1e-12]], [[1.0]]), vi.Harmonic([1.0], 1e-9), [vi.Stop(0, 0.5, 0.8)]
)
n = 100
damping = 0.02 * np.eye(n) + 0.01 * np.diag(np.arange(n) % 3)
stiffness = 4.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
stops = [vi.Stop(i, 0.1, 0.8) for i in (0, 50)]
wide = vi.Scene(vi.LinearSystem(np.eye(n), damping, stiffness), vi.Harmonic(np.ones(n), 1.5), stops)

signal.signal(signal.SIGALRM, signal.default_int_handler)
signal.setitimer(signal.ITIMER_REAL, 0.3)
try:
    {call}
except KeyboardInterrupt:
    print("interrupted", end="")
"""


@pytest.mark.parametrize("call", LONG.values(), ids=LONG.keys())
def test_every_search_answers_an_interruption(call):
    """In a process of its own, which is ended where it is deaf: left alone, each of these calls goes on for minutes."""
    child = [sys.executable, "-c", CHILD.format(call=call)]
    answer = subprocess.run(child, capture_output=True, text=True, timeout=20, check=False)
    assert answer.stdout == "interrupted", answer.stderr
