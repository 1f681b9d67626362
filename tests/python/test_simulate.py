"""Simulated motions against closed forms and SciPy's event integration."""

import copy
import os
import pickle

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import vibroimpact as vi

CASES = int(os.environ.get("VIBROIMPACT_CASES", "50"))
law = settings(max_examples=CASES, deadline=5000)

E = 0.8
BALL = vi.Scene(vi.LinearSystem(1, 0, 0, load=-1), None, vi.Stop(0, 0, E, side="lower"))


def close(value, expected, *, rtol=0.0, atol=0.0):
    """Every entry within the tolerances named, and no others."""
    return np.allclose(value, expected, rtol=rtol, atol=atol)


def ball_impacts(height, restitution, count):
    """Times and speeds before impact of a ball dropped from rest under gravity 1."""
    speeds = np.sqrt(2 * height) * restitution ** np.arange(count)
    return speeds[0] + np.concatenate([[0.0], np.cumsum(2 * speeds[1:])]), speeds


def oscillator(restitution=0.8, clearance=0.05, **options):
    """A driven oscillator that passes the stop by far, were it not there."""
    return vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic(1, 2.8), vi.Stop(0, clearance, restitution, **options))


def pair(reaction="inertia"):
    """Two coupled masses, two stops."""
    system = vi.LinearSystem([[2, 0.5], [0.5, 1]], [[0.2, -0.1], [-0.1, 0.15]], [[5, -1], [-1, 3]], load=[0.1, -0.2])
    stops = [vi.Stop(0, 0.4, 0.9, reaction=reaction), vi.Stop([0.5, 1.0], 0.3, 0.6, side="lower", reaction=reaction)]
    return vi.Scene(system, vi.Harmonic([1.0, 0.5j], 1.7, 0.3), stops)


def dense(coefficient):
    coefficient = np.asarray(coefficient)
    return np.diag(coefficient) if coefficient.ndim == 1 else coefficient


def scipy_motion(scene, q0, v0, end):
    """Final state and impacts (time, stop, speed before) by an integrator with events and the impact law."""
    system, n = scene.system, scene.n_dof
    mass, damping, stiffness = dense(system.mass), dense(system.damping), dense(system.stiffness)
    force = scene.forcing

    def rate(t, x):
        push = system.load + (force.amplitude * np.exp(1j * (force.frequency * t + force.phase))).real
        return np.concatenate([x[n:], np.linalg.solve(mass, push - damping @ x[n:] - stiffness @ x[:n])])

    normals, reactions, events = [], [], []
    for i, stop in enumerate(scene.stops):
        normal = np.eye(n)[stop.normal] if isinstance(stop.normal, int) else stop.normal
        normal = -normal if stop.side == "lower" else normal
        reaction = {"inertia": np.linalg.solve(mass, normal), "coordinate": normal}[stop.reaction]
        normals.append(normal)
        reactions.append(reaction)

        def gap(t, x, i=i):
            return scene.stops[i].clearance - normals[i] @ x[:n]

        gap.terminal, gap.direction = True, -1
        events.append(gap)
    t, x, impacts = 0.0, np.concatenate([q0, v0]), []
    while True:
        run = solve_ivp(rate, (t, end), x, method="DOP853", rtol=1e-12, atol=1e-13, events=events, max_step=0.05)
        t, x = run.t[-1], run.y[:, -1].copy()
        if run.status == 0:
            return x, np.array(impacts)
        i = next(k for k, times in enumerate(run.t_events) if len(times))
        approach = normals[i] @ x[n:]
        impacts.append((t, i, approach))
        x[n:] -= (1 + scene.stops[i].restitution) * approach / (normals[i] @ reactions[i]) * reactions[i]


class TestAgainstClosedForms:
    def test_bouncing_ball(self):
        times, speeds = ball_impacts(1.0, E, 12)
        run = vi.simulate(BALL, 1.0, 0.0, (0, times[-1] + 1e-3))
        impacts = run.impacts
        assert close(impacts["time"], times, rtol=1e-14)
        assert close(impacts["speed_before"], speeds, rtol=1e-12)
        assert close(impacts["speed_after"], E * speeds, rtol=1e-12)
        assert close(impacts["impulse"], (1 + E) * speeds, rtol=1e-12)
        assert np.all(impacts["stop"] == 0)
        assert run.status == "finished"

    def test_bouncing_ball_between_impacts(self):
        times, speeds = ball_impacts(1.0, E, 6)
        run = vi.simulate(BALL, 1.0, 0.0, (0, times[-1]))
        t = np.linspace(times[2], times[3], 9)[1:-1]
        s = t - times[2]
        assert close(run.position(t)[:, 0], E * speeds[2] * s - s**2 / 2, atol=1e-13)
        assert close(run.velocity(t)[:, 0], E * speeds[2] - s, atol=1e-13)

    def test_many_bounces_do_not_drift(self):
        """Without loss the ball returns every 2 v, v = sqrt 2."""
        scene = BALL.replace(restitution=1)
        count = 20_000
        run = vi.simulate(scene, 1.0, 0.0, (0, 1e9), keep="impacts", max_impacts=count)
        expected = np.sqrt(2) * (1 + 2 * np.arange(count))
        assert close(run.impacts["time"], expected, rtol=1e-13, atol=0)
        assert close(run.impacts["speed_before"], np.sqrt(2), rtol=1e-11)

    @law
    @given(st.floats(0.1, 10), st.floats(0, 2), st.floats(-3, 3), st.floats(-3, 3), st.floats(0.5, 20))
    def test_free_oscillator(self, w, ratio, q0, v0, end):
        """q'' + 2 r w q' + w^2 q = 0 in all regimes by the exponential of its matrix."""
        from scipy.linalg import expm

        scene = vi.Scene(vi.LinearSystem(1, 2 * ratio * w, w**2))
        q, v = vi.simulate(scene, q0, v0, (0, end)).final
        expected = expm(np.array([[0, 1], [-(w**2), -2 * ratio * w]]) * end) @ [q0, v0]
        scale = 1e-11 * (1 + abs(q0) * max(1, w) + abs(v0)) * max(1, 1 / w) * max(1, w * end)
        assert close([q[0], v[0]], expected, atol=scale)

    def test_a_free_particle_between_walls(self):
        scene = vi.Scene(vi.LinearSystem(1, 0, 0), None, [vi.Stop(0, 1, 1), vi.Stop(0, 1, 1, side="lower")])
        run = vi.simulate(scene, 0, 2, (0, 10.25))
        assert close(run.impacts["time"], 0.5 + np.arange(10), rtol=1e-14)
        assert run.impacts["stop"].tolist() == [0, 1] * 5
        assert run.final[0][0] == pytest.approx(0.5, abs=1e-12)

    def test_a_stop_turns_the_oscillator_at_its_middle(self):
        """cos t with a stop at 0 and e = 1 hits every pi, speed 1: |cos t|."""
        scene = vi.Scene(vi.LinearSystem(1, 0, 1), None, vi.Stop(0, 0, 1, side="lower"))
        run = vi.simulate(scene, 1, 0, (0, 30), t_eval=np.linspace(0, 30, 77))
        assert close(run.impacts["time"], np.pi / 2 + np.pi * np.arange(len(run.impacts)), rtol=1e-14)
        assert close(run.q[:, 0], np.abs(np.cos(run.t)), atol=1e-12)

    def test_a_load_shifts_the_rest_position(self):
        scene = vi.Scene(vi.LinearSystem([2, 1], [0.1, 0.1], [4, 5], load=[2, -1]))
        run = vi.simulate(scene, [0.5, -0.2], [0, 0], (0, 10))
        assert close(run.final[0], [0.5, -0.2], atol=1e-14)

    def test_resonance_without_damping(self):
        """q'' + q = cos t from rest: t sin(t) / 2."""
        scene = vi.Scene(vi.LinearSystem(1, 0, 1), vi.Harmonic(1, 1))
        t = np.linspace(0, 40, 60)
        run = vi.simulate(scene, 0, 0, (0, 41), t_eval=t)
        assert close(run.q[:, 0], t * np.sin(t) / 2, atol=1e-12)

    def test_rigid_body_under_harmonic_force(self):
        """q'' = cos(w t + p) from rest."""
        w, p = 1.7, 0.4
        t = np.linspace(0, 30, 60)
        run = vi.simulate(vi.Scene(vi.LinearSystem(1, 0, 0), vi.Harmonic(1, w, p)), 0, 0, (0, 31), t_eval=t)
        expected = (np.cos(p) - np.cos(w * t + p)) / w**2 - t * np.sin(p) / w
        assert close(run.q[:, 0], expected, atol=1e-12)


class TestAgainstSciPy:
    @pytest.mark.parametrize(
        ("scene", "q0", "v0", "end"),
        [
            (oscillator(), [-0.1], [0.0], 20.0),
            (oscillator(restitution=0.5, clearance=0.2, side="lower"), [0.3], [-0.4], 20.0),
            (oscillator(restitution=1.0), [-0.5], [1.0], 20.0),
            (pair(), [0.1, 0.0], [0.5, -0.3], 15.0),
            (pair("coordinate"), [0.1, 0.0], [0.5, -0.3], 10.0),
        ],
        ids=["upper", "lower", "elastic", "pair, inertia", "pair, coordinate"],
    )
    def test_impacts_and_final_state(self, scene, q0, v0, end):
        run = vi.simulate(scene, q0, v0, (0, end))
        state, impacts = scipy_motion(scene, q0, v0, end)
        assert run.status == "finished"
        assert len(run.impacts) == len(impacts) >= 5
        assert close(run.impacts["time"], impacts[:, 0], atol=1e-8)
        assert run.impacts["stop"].tolist() == impacts[:, 1].tolist()
        assert close(run.impacts["speed_before"], impacts[:, 2], atol=1e-8)
        assert close(np.concatenate(run.final), state, atol=1e-7)

    def test_phase_of_the_impacts(self):
        run = vi.simulate(oscillator(), -0.1, 0.0, (0, 30))
        phase = run.impacts["phase"]
        assert np.all((phase >= 0) & (phase < 2 * np.pi))
        assert close(np.exp(1j * phase), np.exp(2.8j * run.impacts["time"]), atol=1e-11)


class TestLaws:
    @law
    @given(st.integers(1, 3), st.integers(0, 2**32 - 1), st.floats(0, 1))
    def test_energy_and_no_penetration(self, n, seed, restitution):
        """Newton's law without damping and forcing: each impact costs m v^2 (1 - e^2) / 2, m = 1/(n M^-1 n)."""
        random = np.random.default_rng(seed)
        a, b = random.normal(size=(2, n, n))
        mass, stiffness = a @ a.T + 0.3 * np.eye(n), b @ b.T + 0.3 * np.eye(n)
        normal = random.normal(size=n)
        scene = vi.Scene(vi.LinearSystem(mass, np.zeros(n), stiffness), None, vi.Stop(normal, 0.3, restitution))
        q0, v0 = np.zeros(n), 2 * random.normal(size=n)
        # The end of impacts that accumulate is known to the tolerance: it is asked for a hundred times finer than the law.
        run = vi.simulate(scene, q0, v0, (0, 10), max_impacts=50, rtol=1e-11, atol=1e-14)

        def energy(q, v):
            return (v @ mass @ v + q @ stiffness @ q) / 2

        effective = 1 / (normal @ np.linalg.solve(mass, normal))
        lost = effective * (1 - restitution**2) * np.sum(run.impacts["speed_before"] ** 2) / 2
        start = energy(q0, v0)
        # Impacts that accumulate are one segment, whose loss the ledger has.
        if "chatter" in run.segments["kind"]:
            lost = run.energy.impact_loss[-1]
        assert energy(*run.final) == pytest.approx(start - lost, abs=1e-9 * start)
        assert np.min(scene.gaps(run.q)) > -1e-8 * (1 + np.abs(run.q).max())
        assert close(run.impacts["speed_after"], restitution * run.impacts["speed_before"], atol=1e-12 * start)
        assert np.all(run.impacts["speed_before"] >= 0)
        assert np.all(run.impacts["impulse"] >= 0)

    @law
    @given(st.integers(0, 2**32 - 1))
    def test_flights_compose(self, seed):
        random = np.random.default_rng(seed)
        scene = pair()
        q0, v0 = random.uniform(-0.15, 0.15, size=2), random.normal(size=2)  # inside both stops
        middle = random.uniform(1, 3)
        whole = vi.simulate(scene, q0, v0, (0, 4))
        assume(whole.status == "finished" and len(whole.grazes) == 0)
        assume(np.min(whole.impacts["speed_before"], initial=1.0) > 1e-3)
        assume(np.min(np.abs(whole.impacts["time"] - middle), initial=1.0) > 1e-6)
        first = vi.simulate(scene, q0, v0, (0, middle))
        second = vi.simulate(scene, *first.final, (middle, 4))
        assert len(first.impacts) + len(second.impacts) == len(whole.impacts)
        assert close(np.concatenate(second.final), np.concatenate(whole.final), atol=1e-8)

    @pytest.mark.parametrize("lead", [1e-9, 1e-6, 1e-3, 0.01, 0.02, 0.04, 0.08, 0.16])
    @pytest.mark.parametrize("k", range(4))
    def test_an_impact_just_after_the_end_is_not_part_of_the_run(self, k, lead):
        """However near the end of the span, the state there is that of the longer motion."""
        q0, v0 = [-0.0145, -0.0105], [-0.9, 0.9]
        whole = vi.simulate(pair(), q0, v0, (0, 10))
        end = whole.impacts["time"][k] - lead
        run = vi.simulate(pair(), q0, v0, (0, end))
        assert len(run.impacts) == k
        assert close(run.final[0], whole.position(end), atol=1e-12)
        assert close(run.final[1], whole.velocity(end), atol=1e-11)

    def test_elastic_motion_can_be_reversed(self):
        scene = pair().replace(damping_scale=0, forcing=None, restitution=1)
        run = vi.simulate(scene, [0.1, 0.0], [0.5, -0.3], (0, 30))
        q, v = run.final
        assert len(run.impacts) > 5
        back = vi.simulate(scene, q, -v, (0, 30))
        assert close(back.final[0], [0.1, 0.0], atol=1e-8)
        assert close(back.final[1], [-0.5, 0.3], atol=1e-8)

    def test_the_start_of_time_does_not_matter(self):
        """Whole forcing periods later the motion is the same."""
        scene = oscillator()
        k = 1000
        shift = k * scene.period
        one = vi.simulate(scene, -0.1, 0.2, (0, 10))
        other = vi.simulate(scene, -0.1, 0.2, (shift, shift + 10))
        assert close(other.impacts["time"] - shift, one.impacts["time"], atol=1e-9)
        assert close(np.concatenate(other.final), np.concatenate(one.final), atol=1e-8)

    def test_same_bits(self):
        one, other = (vi.simulate(pair(), [0.1, 0], [0.5, 0], (0, 20)) for _ in range(2))
        assert np.array_equal(one.q, other.q)
        assert np.array_equal(one.impacts, other.impacts)


class TestTrajectory:
    def test_both_sides_of_an_impact(self):
        run = vi.simulate(BALL, 1.0, 0.0, (0, 3))
        time, speed = run.impacts["time"][0], run.impacts["speed_before"][0]
        assert run.velocity(time)[0] == pytest.approx(E * speed, rel=1e-12)
        assert run.velocity(time, side="after")[0] == pytest.approx(E * speed, rel=1e-12)
        assert run.velocity(time, side="before")[0] == pytest.approx(-speed, rel=1e-12)
        assert run.position(time)[0] == pytest.approx(0, abs=1e-14)
        rows = np.flatnonzero(run.t == time)
        assert len(rows) == 2
        assert run.v[rows[0], 0] == pytest.approx(-speed, rel=1e-12)
        assert run.v[rows[1], 0] == pytest.approx(E * speed, rel=1e-12)
        sampled = vi.simulate(BALL, 1.0, 0.0, (0, 3), t_eval=[0.0, time, 3.0])
        assert sampled.v[1, 0] == pytest.approx(E * speed, rel=1e-12)

    @pytest.mark.parametrize("method", ["exact", "rk45", "dop853", "radau"])
    def test_an_impact_that_ends_a_run_has_two_sides(self, method):
        run = vi.simulate(BALL, 1.0, 0.0, (0, 30), method=method, max_impacts=2)
        end, speed = run.impacts["time"][-1], run.impacts["speed_before"][-1]
        for kept in (run, pickle.loads(pickle.dumps(run)), copy.deepcopy(run)):
            assert kept.velocity(end) == pytest.approx([E * speed], rel=1e-9)
            assert kept.velocity(end, side="before") == pytest.approx([-speed], rel=1e-9)
            assert kept.v[-2:, 0] == pytest.approx([-speed, E * speed], rel=1e-9)
            assert np.array_equal(kept.t[-2:], [end, end])
            assert np.array_equal(kept.velocity(end), kept.final[1])
            assert kept.energy.impact_loss[-1] == pytest.approx(1 - E**4, rel=1e-8)
        for keep in ("motion", "impacts", "final"):
            options = {"keep": keep, "method": method, "max_impacts": 2}
            sampled = vi.simulate(BALL, 1.0, 0.0, (0, 30), t_eval=[end], **options)
            assert sampled.v[:, 0] == pytest.approx([E * speed], rel=1e-9)

    def test_every_impact_has_two_rows_for_drawing(self):
        run = vi.simulate(oscillator(), -0.1, 0.0, (0, 60))
        assert len(run.impacts) > 20
        for time in run.impacts["time"]:
            assert np.count_nonzero(run.t == time) == 2
        assert np.all(np.diff(run.t) >= 0)

    def test_the_sides_agree_away_from_impacts(self):
        run = vi.simulate(BALL, 1.0, 0.0, (0, 3))
        for t in (0.0, 0.7, 2.0, 3.0):
            assert close(run.velocity(t, side="before"), run.velocity(t, side="after"), atol=1e-14)

    def test_the_start_is_the_start(self):
        run = vi.simulate(BALL, 1.0, 0.25, (0, 3))
        assert run.position(0.0) == pytest.approx([1.0])
        assert run.velocity(0.0) == pytest.approx([0.25])
        assert run.velocity(0.0, side="before") == pytest.approx([0.25])

    def test_rows_for_drawing(self):
        run = vi.simulate(oscillator(), -0.1, 0.0, (0, 30))
        assert run.t.shape == (len(run.q),)
        assert run.q.shape == run.v.shape == (len(run.t), 1)
        assert len(run.t) <= 200 * len(run.segments)
        assert run.t[0] == 0.0
        assert run.t[-1] == 30.0
        inner = ~np.isin(run.t, run.impacts["time"])
        assert close(run.q[inner], run.position(run.t[inner]), atol=1e-12)
        assert close(run.v[inner], run.velocity(run.t[inner]), atol=1e-11)

    def test_shapes(self):
        run = vi.simulate(pair(), [0.1, 0], [0, 0], (0, 5))
        assert run.position(1.0).shape == (2,)
        assert run.position([1.0]).shape == (1, 2)
        assert run.position(np.linspace(0, 5, 7)).shape == (7, 2)
        assert run.position([]).shape == (0, 2)
        assert run.velocity([0.1, 0.2], side="before").shape == (2, 2)
        assert [part.shape for part in run.final] == [(2,), (2,)]

    def test_fields(self):
        run = vi.simulate(BALL, 1.0, 0.0, (0, 3))
        assert run.impacts.dtype.names == ("time", "stop", "speed_before", "speed_after", "impulse", "phase")
        assert run.grazes.dtype.names == ("time", "stop", "depth")
        assert run.segments.dtype.names == ("kind", "stop", "start", "end", "impulse")
        segments = run.segments
        assert np.all(segments["kind"] == "flight")
        assert np.all(segments["stop"] == -1)
        assert segments["start"][0] == 0.0
        assert segments["end"][-1] == 3.0
        assert np.array_equal(segments["start"][1:], segments["end"][:-1])
        assert np.array_equal(segments["start"][1:], run.impacts["time"])

    @pytest.mark.parametrize("keep", ["motion", "impacts", "final"])
    @pytest.mark.parametrize("scene", [oscillator(), oscillator().replace(forcing=None)], ids=["forced", "free"])
    @pytest.mark.parametrize("end", [10.0, 20.0, 40.0, 100.0])
    def test_every_time_of_t_eval_has_a_row(self, keep, scene, end):
        t = np.linspace(0, end, 31)
        run = vi.simulate(scene, -0.1, 0.0, (0, end), t_eval=t, keep=keep)
        assert run.status == "finished"
        assert np.array_equal(run.t, t)
        assert run.q.shape == run.v.shape == (31, 1)
        assert close(run.q[-1], run.final[0], atol=1e-12)
        assert close(run.v[-1], run.final[1], atol=1e-12)

    def test_keep(self):
        t = np.linspace(0, 9, 10)
        runs = {
            keep: vi.simulate(pair(), [0.1, 0], [0.5, 0], (0, 10), keep=keep, t_eval=t) for keep in ("motion", "impacts", "final")
        }
        motion = runs["motion"]
        assert close(motion.q, motion.position(t), atol=1e-13)
        for keep in ("impacts", "final"):
            assert np.array_equal(runs[keep].q, motion.q)
            assert np.array_equal(runs[keep].v, motion.v)
            assert np.array_equal(runs[keep].final, motion.final)
            assert runs[keep].stats.n_impacts == motion.stats.n_impacts
            with pytest.raises(ValueError, match="keep"):
                runs[keep].position(1.0)
        assert np.array_equal(runs["impacts"].impacts, motion.impacts)

    def test_t_eval_may_be_one_number_or_empty(self):
        assert vi.simulate(BALL, 1, 0, (0, 1), t_eval=0.5).q.shape == (1, 1)
        assert vi.simulate(BALL, 1, 0, (0, 1), t_eval=[]).q.shape == (0, 1)

    @pytest.mark.parametrize("count", [0, 1, 3])
    def test_max_impacts(self, count):
        times, speeds = ball_impacts(1.0, E, 5)
        run = vi.simulate(BALL, 1.0, 0.0, (0, 100), max_impacts=count)
        assert run.status == "max_impacts"
        assert len(run.impacts) == count
        if count:
            assert run.final[0][0] == pytest.approx(0, abs=1e-13)
            assert run.final[1][0] == pytest.approx(E * speeds[count - 1], rel=1e-12)
            assert run.segments["end"][-1] == pytest.approx(times[count - 1], rel=1e-14)

    def test_an_accumulation_of_impacts_ends_with_a_reason(self):
        run = vi.simulate(BALL, 1.0, 0.0, (0, 100), max_impacts=100_000)
        assert run.status in ("unresolved_contact", "finished")
        assert run.message

    def test_stats(self):
        run = vi.simulate(oscillator(), -0.1, 0.0, (0, 30))
        stats = run.stats
        assert stats.n_rhs == stats.n_steps == 0
        assert stats.n_impacts == len(run.impacts)
        assert stats.n_flights == len(run.segments)
        assert stats.n_gap_evaluations > 0
        assert vi.simulate(vi.Scene(vi.LinearSystem(1, 0, 1)), 1, 0, (0, 30)).stats.n_gap_evaluations == 0

    @pytest.mark.parametrize("method", ["auto", "AUTO", "exact", "Exact"])
    def test_method_in_any_letter_case(self, method):
        assert np.array_equal(vi.simulate(BALL, 1, 0, (0, 3), method=method).q, vi.simulate(BALL, 1, 0, (0, 3)).q)

    @pytest.mark.parametrize("span", [(0, 3), [0, 3], np.array([0, 3]), (np.float32(0), np.int64(3))])
    def test_a_span_is_any_pair(self, span):
        assert vi.simulate(BALL, 1, 0, span).final == vi.simulate(BALL, 1, 0, (0.0, 3.0)).final

    def test_a_start_in_contact(self):
        """An approaching velocity is an impact at once, a leaving one is not."""
        run = vi.simulate(BALL, 0.0, -1.0, (0, 0.5))
        assert run.impacts["time"].tolist() == [0.0]
        assert run.impacts["speed_before"][0] == 1.0
        assert run.velocity(0.0)[0] == pytest.approx(E)
        assert len(vi.simulate(BALL, 0.0, 1.0, (0, 0.5)).impacts) == 0

    def test_a_graze_is_no_impact(self):
        """cos t touches a stop at 1 with no speed at every 2 pi."""
        scene = vi.Scene(vi.LinearSystem(1, 0, 1), None, vi.Stop(0, 1, 0.5))
        run = vi.simulate(scene, 0.0, 1.0, (0, 13))
        assert len(run.impacts) == 0
        assert close(run.grazes["time"], np.pi / 2 + 2 * np.pi * np.arange(2), atol=1e-4)
        assert np.all(np.abs(run.grazes["depth"]) < 1e-8)

    def test_nothing_happens_in_no_time(self):
        run = vi.simulate(BALL, 1.0, 0.5, (2.0, 2.0))
        assert run.status == "finished"
        assert run.final[0][0] == 1.0
        assert run.final[1][0] == 0.5

    def test_nothing_can_be_set(self):
        run = vi.simulate(BALL, 1.0, 0.0, (0, 3))
        for name in ("t", "q", "impacts", "final", "status", "stats", "anything"):
            with pytest.raises(AttributeError):
                setattr(run, name, 1)
        with pytest.raises(AttributeError):
            run.stats.n_rhs = 3
        run.q[:] = 7
        assert not np.any(run.q == 7)

    def test_repr(self):
        run = vi.simulate(BALL, 1.0, 0.0, (0, 3))
        assert "finished" in repr(run)
        assert len(repr(run).splitlines()) <= 24
        assert "n_impacts=1" in repr(run.stats)

    def test_scene_and_arrays(self, tmp_path):
        run = vi.simulate(BALL, 1.0, 0.0, (0, 3))
        assert run.scene == BALL
        np.savez(tmp_path / "run.npz", **run.to_arrays())
        with np.load(tmp_path / "run.npz") as arrays:
            assert np.array_equal(arrays["q"], run.q)
            assert np.array_equal(arrays["impacts"], run.impacts)

    def test_progress(self, capsys):
        run = vi.simulate(BALL, 1.0, 0.0, (0, 3), progress=True)
        assert run.status == "finished"
        assert "100%" in capsys.readouterr().err


class TestEnd:
    @pytest.mark.parametrize("keep", ["motion", "impacts", "final"])
    @pytest.mark.parametrize("max_impacts", [None, 5])
    @pytest.mark.parametrize("method", ["exact", "taylor", "rk45", "dop853", "radau"])
    def test_a_run_goes_on_where_it_ended(self, keep, max_impacts, method):
        scene = vi.paper_scene(kind=3, clearance=0.05, linear=method != "taylor")
        options = {"method": method, "rtol": 1e-12}
        whole = vi.simulate(scene, [0.0, 0.0], [0.0, 0.1], (0.5, 120), **options)
        first = vi.simulate(scene, [0.0, 0.0], [0.0, 0.1], (0.5, 61.5), keep=keep, max_impacts=max_impacts, **options)
        assert first.t_end == (61.5 if max_impacts is None else whole.impacts["time"][4])
        rest = vi.simulate(scene, *first.final, (first.t_end, 120), **options)
        assert (first.stats.n_impacts, rest.t_end) == (5 if max_impacts else first.stats.n_impacts, 120)
        assert first.stats.n_impacts + rest.stats.n_impacts == whole.stats.n_impacts > 5
        for a, b in zip(rest.final, whole.final, strict=True):
            np.testing.assert_allclose(a, b, atol=1e-9)
        np.testing.assert_allclose(rest.impacts["phase"], whole.impacts["phase"][first.stats.n_impacts :], atol=1e-9)

    def test_it_is_saved(self):
        run = vi.simulate(vi.paper_scene(kind=3), [0.0, 0.0], [0.0, 0.1], (0, 31.5), keep="final")
        assert pickle.loads(pickle.dumps(run)).t_end == 31.5 == run.to_arrays()["t_end"][0]
