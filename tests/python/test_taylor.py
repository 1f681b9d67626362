"""Motions along Taylor series as Python has them: truth from elliptic functions, keeping, sides, saving, the choice by scene."""

import pickle

import mpmath
import numpy as np
import pytest

import vibroimpact as vi

START = [0.02, -0.1], [0.0, 0.3]


def pendulums():
    return vi.paper_scene(kind=3, linear=False)


def taylor(scene, span, **options):
    return vi.simulate(scene, *START, span, method="taylor", **options)


class TestTruth:
    @pytest.mark.parametrize("angle", [0.1, 1.5, 3.0])
    def test_a_link_follows_jacobis_sine(self, angle):
        """From its lowest point: ``sin(q/2) = k sn(t, k)``, ``k = sin(angle/2)``; up to 100 roundings of the start, in what the
        motion makes of them.
        """
        mpmath.mp.dps = 30
        k = mpmath.sin(mpmath.mpf(angle) / 2)

        def motion(k):
            return np.array([2 * mpmath.asin(k * mpmath.ellipfun("sn", s, k=k)) for s in t])

        scene = vi.Scene(vi.PendulumChain([2.0], [0.5], gravity=0.5))
        t = np.linspace(0, 10, 41)
        run = vi.simulate(scene, 0.0, float(2 * k), (0, 10), rtol=1e-14, atol=1e-16, t_eval=t)
        small = mpmath.mpf(10) ** -12
        condition = float(np.abs(motion(k * (1 + small)) - motion(k)).max() / small)
        truth = motion(k).astype(float)
        bound = 100 * max(condition, angle) * np.finfo(float).eps
        assert np.abs(run.q[:, 0] - truth).max() < bound
        assert np.abs(run.position(t)[:, 0] - truth).max() < bound

    def test_the_pair_moves_as_in_runge_kutta_steps(self):
        scene = pendulums()
        series = taylor(scene, (0, 60), rtol=1e-13)
        steps = vi.simulate(scene, *START, (0, 60), method="rk45", rtol=1e-13, atol=1e-15)
        assert len(series.impacts) == len(steps.impacts) > 5
        assert np.abs(series.impacts["time"] - steps.impacts["time"]).max() < 1e-11
        t = np.linspace(0, 60, 601)
        assert np.abs(series.position(t) - steps.position(t)).max() < 1e-11
        assert series.stats.n_steps < 0.05 * steps.stats.n_steps


class TestUse:
    def test_a_pendulum_gets_series_by_itself_and_the_plan_says_so(self):
        scene = pendulums()
        auto, asked = vi.simulate(scene, *START, (0, 20)), taylor(scene, (0, 20))
        assert np.array_equal(auto.impacts, asked.impacts)
        assert auto.stats.n_rhs == asked.stats.n_rhs > 0
        assert "Taylor series" in scene.plan()
        assert "Taylor" not in vi.paper_scene(kind=3).plan()

    def test_a_linear_scene_has_none(self):
        with pytest.raises(ValueError, match=r"method is .*taylor"):
            taylor(vi.paper_scene(kind=3), (0, 20))

    def test_keeping_less_changes_nothing(self):
        scene, t = pendulums(), np.linspace(0, 40, 201)
        runs = {keep: taylor(scene, (0, 40), keep=keep, t_eval=t) for keep in ("motion", "impacts", "final")}
        motion = runs["motion"]
        assert np.abs(motion.q - motion.position(t)).max() < 1e-14
        assert np.abs(motion.v - motion.velocity(t)).max() < 1e-13
        for keep in ("impacts", "final"):
            assert np.array_equal(runs[keep].q, motion.q)
            assert np.array_equal(runs[keep].final, motion.final)
        assert np.array_equal(runs["impacts"].impacts, motion.impacts)

    def test_both_sides_of_an_impact(self):
        run = taylor(pendulums(), (0, 40))
        assert len(run.impacts) > 3
        for impact in run.impacts:
            i = impact["stop"]
            before, after = (run.velocity(impact["time"], side=side)[i] for side in ("before", "after"))
            assert before == pytest.approx(impact["speed_before"], rel=1e-11)
            assert after == pytest.approx(-impact["speed_after"], rel=1e-11)
            assert np.count_nonzero(run.t == impact["time"]) == 2

    def test_it_is_saved_with_chatter_and_lasting_contact(self):
        system = vi.PendulumChain([1.0, 1.0], [1.0, 1.0], damping=0.3)
        scene = vi.Scene(system, vi.BaseMotion(0.3, 1.5), vi.Wall(1, 0.1, 0.3))
        run = vi.simulate(scene, [0, 0], [0, 0], (0, 20))
        assert {"flight", "chatter", "stick"} <= set(run.segments["kind"])
        again, t = pickle.loads(pickle.dumps(run)), np.linspace(0, 20, 301)
        assert np.array_equal(run.position(t), again.position(t))
        assert np.array_equal(run.velocity(t), again.velocity(t))
        assert np.array_equal(run.t, again.t)
        steps = vi.simulate(scene, [0, 0], [0, 0], (0, 20), method="rk45")
        assert np.abs(run.position(t) - steps.position(t)).max() < 1e-6
        assert list(run.segments["kind"]) == list(steps.segments["kind"])

    def test_many_at_once_for_any_number_of_workers(self):
        scene = pendulums()
        q0 = np.linspace([-0.1, -0.1], [0.05, 0.1], 37)
        runs = [vi.simulate_many(scene, q0, 0 * q0, (0, 30), workers=workers) for workers in (1, 2)]
        assert np.array_equal(runs[0].q, runs[1].q)
        assert np.array_equal(runs[0].v, runs[1].v)
        one = vi.simulate(scene, q0[17], [0, 0], (0, 30))
        assert np.array_equal(runs[0].q[17], one.final[0])
