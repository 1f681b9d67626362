"""The motion of periodic orbits, their admissibility and stability, against integration and definitions."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from orbit_models import CASES, Dynamics, at_one_clearance, close, dense, law, orbit_of_kind, random_scene, with_newtons_law
from scipy.integrate import solve_ivp

import vibroimpact as vi


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
