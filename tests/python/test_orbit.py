"""Periodic orbits against the paper's cases, closed forms and independent solves; the objects and their speeds."""

import copy
import itertools
import pickle

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from orbit_models import (
    N_PERIODS,
    Dynamics,
    at_one_clearance,
    close,
    law,
    orbit_of_kind,
    random_scene,
)
from scipy.linalg import block_diag, expm

import vibroimpact as vi


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
        v+ = e g T/(1 + e): the numbers of theory 5.
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

    @pytest.mark.parametrize("method", ["exact", "rk45", "dop853", "radau"])
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
