"""Motions in Runge-Kutta steps as Python has them: method, counts, keeping, sides, and truth from SciPy's DOP853."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import vibroimpact as vi

START = [0.02, -0.1], [0.0, 0.3]


def close(value, expected, *, rtol=0.0, atol=0.0):
    """Every entry within the tolerances named, and no others."""
    return np.allclose(value, expected, rtol=rtol, atol=atol)


def rk45(scene, span, **options):
    return vi.simulate(scene, *START, span, method="rk45", **options)


class TestAgainstSciPy:
    def test_large_motions_of_the_double_pendulum(self):
        """Eq. (3) written out anew: m2 mu^2 and so on divided by the total mass, both angles from the vertical."""
        scene = vi.paper_scene(kind=3, linear=False)
        pendulum, base = scene.system, scene.forcing
        m, mu = pendulum.mass_ratio, pendulum.length_ratio
        alpha = m / (1 + m) / mu
        push = base.amplitude * base.frequency**2

        def rate(t, x):
            (p, q), v = x[:2], x[2:]
            u = push * np.cos(base.frequency * t + base.phase)
            mass = np.array([[1, alpha * np.cos(p - q)], [alpha * np.cos(p - q), alpha / mu]])
            force = [u * np.cos(p) - np.sin(p) / (1 + m), alpha * (u * np.cos(q) - np.sin(q) / (1 + m))]
            whirl = alpha * np.sin(p - q) * np.array([v[1] ** 2, -(v[0] ** 2)])
            return np.concatenate([v, np.linalg.solve(mass, force - whirl - pendulum.damping @ v)])

        def event(i):
            def gap(t, x):
                return scene.stops[i].clearance - x[i]

            gap.terminal, gap.direction = True, -1
            return gap

        t, x, impacts, end = 0.0, np.concatenate(START), [], 60.0
        while t < end:
            run = solve_ivp(
                rate, (t, end), x, method="DOP853", rtol=1e-12, atol=1e-14, events=[event(0), event(1)], max_step=0.05
            )
            t, x = run.t[-1], run.y[:, -1].copy()
            for i, times in enumerate(run.t_events):
                if len(times):
                    impacts.append((t, i, x[2 + i]))
                    x[2 + i] *= -scene.stops[i].restitution
        own = rk45(scene, (0, end), rtol=1e-11, atol=1e-13)
        assert len(own.impacts) == len(impacts) >= 5
        times, stops, speeds = np.transpose(impacts)
        assert np.array_equal(own.impacts["stop"], stops)
        assert close(own.impacts["time"], times, atol=1e-8)
        assert close(own.impacts["speed_before"], speeds, atol=1e-8)
        assert close(np.concatenate(own.final), x, atol=1e-8)


class TestSteps:
    @pytest.mark.parametrize("method", ["rk45", "RK45", "Rk45"])
    def test_the_method_in_any_letter_case(self, method):
        scene = vi.paper_scene(kind=3)
        run = vi.simulate(scene, *START, (0, 20), method=method)
        assert run.stats.n_steps > 0
        assert close(np.concatenate(run.final), np.concatenate(vi.simulate(scene, *START, (0, 20)).final), atol=1e-8)

    def test_a_nonlinear_scene_without_series_steps_by_itself_and_has_no_exact_flights(self):
        system = vi.NonlinearSystem(1, lambda t, q, v: -np.sin(q))
        scene = vi.Scene(system, stops=vi.Stop(0, 0.2, 0.5, reaction="coordinate"))
        runs = [vi.simulate(scene, -0.3, 0.0, (0, 20), **options) for options in ({}, {"method": "dop853"})]
        assert np.array_equal(runs[0].impacts, runs[1].impacts)
        assert runs[0].stats.n_rhs == runs[1].stats.n_rhs > 0
        for other in ("exact", "taylor"):
            with pytest.raises(ValueError, match=other):
                vi.simulate(scene, -0.3, 0.0, (0, 20), method=other)

    @pytest.mark.parametrize("linear", [True, False])
    def test_keeping_less_changes_nothing(self, linear):
        scene = vi.paper_scene(kind=3, linear=linear)
        t = np.linspace(0, 40, 201)
        runs = {keep: rk45(scene, (0, 40), keep=keep, t_eval=t) for keep in ("motion", "impacts", "final")}
        motion = runs["motion"]
        assert close(motion.q, motion.position(t), atol=1e-15)
        for keep in ("impacts", "final"):
            assert np.array_equal(runs[keep].q, motion.q)
            assert np.array_equal(runs[keep].v, motion.v)
            assert np.array_equal(runs[keep].final, motion.final)
            with pytest.raises(ValueError, match="keep"):
                runs[keep].position(1.0)
        assert np.array_equal(runs["impacts"].impacts, motion.impacts)

    def test_both_sides_of_an_impact(self):
        scene = vi.paper_scene(kind=3, linear=False)
        run = rk45(scene, (0, 40))
        for impact in run.impacts:
            i = impact["stop"]
            before, after = (run.velocity(impact["time"], side=side)[i] for side in ("before", "after"))
            assert before == pytest.approx(impact["speed_before"], rel=1e-12)
            assert after == pytest.approx(-impact["speed_after"], rel=1e-12)
            assert np.count_nonzero(run.t == impact["time"]) == 2

    def test_what_a_stiff_motion_says(self):
        run = vi.simulate(vi.Scene(vi.LinearSystem(1, 1e4, 1)), 1, 0, (0, 1), method="rk45", rtol=1e-4)
        assert "stiff" in run.message
        assert run.status == "finished"
