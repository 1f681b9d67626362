"""Extreme contacts, by every method that applies, against closed forms: a link without gravity is a free body with series."""

import os

import numpy as np
import pytest
from mpmath import mp, mpf

import vibroimpact as vi

# A million impacts in each method where the environment asks for them.
IMPACTS = int(os.environ.get("VIBROIMPACT_IMPACTS", "20000"))
TIGHT = {"rtol": 1e-13, "atol": 1e-15}
LINEAR = pytest.mark.parametrize("method", ["exact", "rk45", "dop853", "radau"])
EVERY = pytest.mark.parametrize("method", ["exact", "taylor", "rk45", "dop853", "radau"])


def body(method, stops=(), damping=0.0, forcing=None):
    """q'' = -damping q'."""
    series = method == "taylor"
    system = vi.PendulumChain([1], [1], damping=damping, gravity=0) if series else vi.LinearSystem(1, damping, 0)
    return vi.Scene(system, forcing, stops)


def swing(method, stops, *, forcing=None):
    """q'' = -q, of the link to first order: the caller knows both closed forms."""
    return vi.Scene(vi.PendulumChain([1], [1], gravity=1) if method == "taylor" else vi.LinearSystem(1, 0, 1), forcing, stops)


def walls(clearance, restitution):
    return [vi.Stop(0, clearance, restitution), vi.Stop(0, clearance, restitution, side="lower")]


def simulate(scene, q0, v0, end, method, **options):
    run = vi.simulate(scene, q0, v0, (0, end), method=method, **(TIGHT | options))
    assert run.status == "finished", run.message
    return run


def close(value, expected, *, rtol):
    """Every entry to this part of its own size."""
    return np.allclose(value, expected, rtol=rtol, atol=0)


def quarter(amplitude):
    """A quarter of the period of a swing to an angle."""
    return mp.ellipk(mp.sin(mpf(amplitude) / 2) ** 2)


@EVERY
class TestFreeBody:
    @pytest.mark.parametrize("restitution", [1.0, 1 - 1e-12, 0.9])
    def test_between_two_stops(self, restitution, method):
        """v e^k after k impacts, from the middle: 1/(2 v) and then 1/(v e^k) apart."""
        e, v, count = mpf(restitution), 2, 40
        times = [mpf(1) / (2 * v) + sum((1 / (v * e**j) for j in range(1, k + 1)), mpf(0)) for k in range(count)]
        scene = body(method, walls(0.5, restitution))
        run = simulate(scene, 0, v, float(times[-1]) * (1 + 1e-9), method)
        assert run.impacts["stop"].tolist() == [0, 1] * (count // 2)
        assert close(run.impacts["time"], [float(t) for t in times], rtol=1e-12)
        assert close(run.impacts["speed_before"], [float(v * e**k) for k in range(count)], rtol=1e-12)

    def test_without_restitution_it_stays(self, method):
        run = simulate(body(method, walls(1, 0.0)), 0, 2, 1e3, method)
        assert run.impacts["time"].tolist() == [pytest.approx(0.5, rel=1e-14)]
        assert run.final == (pytest.approx(1, abs=1e-14), 0)

    def test_with_a_restitution_of_1e_12_it_creeps_back(self, method):
        run = simulate(body(method, walls(1, 1e-12)), 0, 2, 1e4, method)
        assert len(run.impacts) == 1
        assert run.impacts["speed_after"][0] == pytest.approx(2e-12, rel=1e-12, abs=0)
        # Its velocity has the rounding of the one it came with.
        assert 1 - run.final[0][0] == pytest.approx(2e-12 * (1e4 - 0.5), rel=0, abs=2 * 1e4 * np.spacing(2.0))

    def test_at_a_speed_of_1e_12(self, method):
        run = simulate(body(method, walls(1e-9, 0.5)), 0, 1e-12, 9e3, method, atol=1e-24)
        assert close(run.impacts["time"], [1e3, 5e3], rtol=1e-11)
        assert close(run.impacts["speed_before"], [1e-12, 0.5e-12], rtol=1e-11)
        assert run.final[0][0] == pytest.approx(0, abs=1e-20)

    def test_at_a_speed_of_1e9(self, method):
        """Every step of an integrator would hold many impacts."""
        run = simulate(body(method, walls(1, 1)), 0, 1e9, 1.01e-6, method)
        assert close(run.impacts["time"], 1e-9 * np.arange(1, 1010, 2), rtol=1e-11)
        assert run.final[0][0] == pytest.approx(0, abs=1e-8)

    def test_stops_far_closer_than_the_motion(self, method):
        run = simulate(body(method, walls(1e-9, 1)), 0, 1, 1.01e-6, method, atol=1e-22)
        assert close(run.impacts["time"], 1e-9 * np.arange(1, 1010, 2), rtol=1e-11)

    def test_a_start_in_contact(self, method):
        """Approaching: struck at once. Leaving: free. At rest: it stays."""
        for v, count, end in ((1, 1, -0.5), (-1, 0, -1), (0, 0, 0)):
            run = simulate(body(method, [vi.Stop(0, 0.7, 0.5)]), 0.7, v, 1, method)
            assert run.impacts["time"].tolist() == [0] * count
            assert run.final[0][0] == pytest.approx(0.7 + end, abs=1e-13)

    def test_a_start_inside_is_refused(self, method):
        for clearance in (0.7 - 1e-6, -0.1):
            with pytest.raises(ValueError, match="inside stop 0"):
                simulate(body(method, [vi.Stop(0, clearance, 0.5)]), 0.7, 0, 1, method)

    @pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
    def test_the_same_stop_given_twice(self, restitution, method):
        """It leaves as from one, and the impulses add up to the change of velocity."""
        run = simulate(body(method, [vi.Stop(0, 1, restitution)] * 2), 0, 2, 1, method)
        assert close(run.impacts["time"], 0.5, rtol=1e-14)
        assert run.impacts["impulse"].sum() == pytest.approx(2 * (1 + restitution), rel=1e-13)
        assert run.final[0][0] == pytest.approx(1 - restitution, abs=1e-13)

    @pytest.mark.parametrize("apart", [1e-4, 1e-8, 1e-10])
    def test_of_two_stops_close_behind_each_other_the_first_is_struck(self, apart, method):
        stops = [vi.Stop(0, 1 + apart, 0.9), vi.Stop(0, 1, 0.5)]
        run = simulate(body(method, stops), 0, 1, 1.5, method)
        assert run.impacts["stop"].tolist() == [1]
        assert run.final[0][0] == pytest.approx(0.75, abs=1e-13)

    @pytest.mark.parametrize("speed", [0.0, 1.0, -1.0])
    def test_no_room_at_all(self, speed, method):
        run = vi.simulate(body(method, walls(0, 0.5)), 0, speed, (0, 10), method=method)
        assert run.status in ("finished", "unresolved_contact")
        assert abs(run.final[0][0]) < 1e-9

    def test_a_million_impacts_do_not_drift(self, method):
        """Every unit of time one impact, at speed 1."""
        run = simulate(body(method, walls(0.5, 1)), 0, 1, IMPACTS + 0.25, method, keep="impacts")
        assert len(run.impacts) == IMPACTS
        assert close(run.impacts["time"], np.arange(IMPACTS) + 0.5, rtol=1e-11)
        assert np.abs(run.impacts["speed_before"] - 1).max() < 1e-11

    @pytest.mark.parametrize("damping", [0.3, -0.3])
    def test_with_dampers(self, damping, method):
        """v' = -c v: the distance left to go falls by c per unit of velocity, whatever the direction."""
        c, e, scene = mpf(damping), mpf(0.9), body(method, walls(0.5, 0.9), damping)
        speed, time, distance, times = mpf(2), mpf(0), mpf(0.5), []
        for _ in range(4):
            last = speed - c * distance
            time += mp.log(speed / last) / c
            times.append(float(time))
            speed, distance = e * last, 1
        run = simulate(scene, 0, 2, times[-1] * (1 + 1e-9), method)
        assert close(run.impacts["time"], times, rtol=1e-12)


@EVERY
class TestSwing:
    def test_the_middle_as_a_stop(self, method):
        """Clearance 0 and e = 1: every half period the same speed."""
        a = mpf(1.0)
        time, speed = (quarter(a), 2 * mp.sin(a / 2)) if method == "taylor" else (mp.pi / 2, a)
        run = simulate(swing(method, [vi.Stop(0, 0, 1, side="lower")]), 1.0, 0, 40, method)
        assert len(run.impacts) > 10
        assert close(run.impacts["time"], float(time) * (2 * np.arange(len(run.impacts)) + 1), rtol=1e-11)
        assert close(run.impacts["speed_before"], float(speed), rtol=1e-11)

    def test_a_start_that_grazes(self, method):
        """Every period it is back: exactly to a graze, or, in steps, to where their error of the amplitude leaves it."""
        period, pull = (4 * quarter(1.0), np.sin(1.0)) if method == "taylor" else (2 * mp.pi, 1.0)
        error = 0.0 if method == "exact" else 1e-8
        run = simulate(swing(method, [vi.Stop(0, 1.0, 0.5)]), 1.0, 0, 4.5 * float(period), method, rtol=1e-10)
        assert run.final[0][0] == pytest.approx(-1, abs=1e-8)
        # A stop that the motion would pass by d is struck at v^2 = 2 d pull; v (1 + e)/pull of the period is left out.
        fastest = np.sqrt(2 * error * pull)
        assert (run.impacts["speed_before"] <= fastest).all()
        early = 4 * 1.5 * fastest / pull
        grazes = run.grazes[run.grazes["time"] > 1]
        returns = np.concatenate([run.impacts["time"], grazes["time"]]) / float(period)
        assert returns == pytest.approx(np.round(returns), abs=early / float(period) + 1e-5)
        assert len(set(np.round(returns))) == len(returns)
        if method == "exact":
            assert len(run.impacts) == 0
            assert len(grazes) == 4

    def test_an_equilibrium_on_the_stop(self, method):
        run = simulate(swing(method, [vi.Stop(0, 0, 0.5)]), 0, 0, 1e3, method)
        assert len(run.impacts) == 0
        assert run.final == (0, 0)

    @pytest.mark.parametrize("restitution", [0.9, 0.5, 0.05, 1e-12])
    def test_a_preloaded_stop_brings_it_to_rest_for_ever(self, restitution, method):
        """Clearance -1/2. A flight that leaves at v: 2 atan(2 v), or by the energy of the link, lasts and returns at v."""
        at, e, v0 = mpf(1) / 2, mpf(restitution), mpf(0.3)

        def flight(v):
            if method != "taylor":
                return 2 * mp.atan(v / at)
            k = mp.sqrt(mp.sin(at / 2) ** 2 + (v / 2) ** 2)
            return 2 * (mp.ellipk(k**2) - mp.ellipf(mp.asin(mp.sin(at / 2) / k), k**2))

        count = 1 if restitution < 0.01 else int(np.ceil(np.log(1e-3) / np.log(restitution)))
        times, speeds, total, v = [], [], mpf(0), v0
        while v > mpf(10) ** -18:
            total += flight(v)
            times.append(float(total))
            speeds.append(float(v))
            v *= e
        run = simulate(swing(method, [vi.Stop(0, -0.5, restitution)]), -0.5, -0.3, 1e3, method)
        assert len(run.impacts) >= count
        assert close(run.impacts["time"][:count], times[:count], rtol=1e-11)
        assert close(run.impacts["speed_before"][:count], speeds[:count], rtol=1e-9)
        assert run.final == (pytest.approx(-0.5, abs=1e-13), pytest.approx(0, abs=1e-13))
        stuck = run.segments[-1]
        assert (stuck["kind"], stuck["stop"], stuck["end"]) == ("stick", 0, 1e3)
        assert stuck["start"] == pytest.approx(float(total), rel=1e-6)

    def test_fast_through_a_narrow_room(self, method):
        """Speed 1e6 between stops at 1 and -1: each crossing 2 asin(1/A), A = hypot(1, v) where v is the speed at a stop."""
        v0 = mpf(10) ** 6
        crossing = 4 / v0 * mp.ellipf(mpf(1) / 2, 4 / v0**2) if method == "taylor" else 2 * mp.asin(1 / v0)
        run = simulate(swing(method, walls(1, 1)), 0, 1e6, float(50 * crossing), method)
        assert len(run.impacts) == 50
        assert close(run.impacts["time"], float(crossing) * (np.arange(50) + 0.5), rtol=1e-11)

    def test_a_forcing_without_amplitude_is_none(self, method):
        none = vi.BaseMotion(0.0, 1.7) if method == "taylor" else vi.Harmonic(0.0, 1.7)
        runs = [simulate(swing(method, walls(0.4, 0.8), forcing=f), 0, 1, 5, method) for f in (None, none)]
        assert len(runs[0].impacts) == 4
        assert close(runs[0].impacts["time"], runs[1].impacts["time"], rtol=1e-11)


@LINEAR
class TestTwoCoordinates:
    @pytest.mark.parametrize("delta", [1e-4, -1e-9, 1e-12, -1e-12])
    def test_stops_struck_all_but_together(self, delta, method):
        """Uncoupled bodies: each keeps its own time and restitution."""
        scene = vi.Scene(vi.LinearSystem([1, 1], [0, 0], [0, 0]), None, [vi.Stop(0, 1, 0.5), vi.Stop(1, 1 + delta, 0.8)])
        run = simulate(scene, [0, 0], [1, 1], 1.5, method)
        order = run.impacts["stop"].tolist()
        assert order == ([0, 1] if delta > 0 else [1, 0])
        assert close(run.impacts["time"], np.array([1, 1 + delta])[order], rtol=1e-14)
        assert run.final[0] == pytest.approx([0.75, 1 + delta - 0.8 * (0.5 - delta)], abs=1e-13)

    def test_released_by_the_impact_of_another(self, method):
        """One body is pressed on its stop while the other, coupled by inertia, strikes: parabolas before and after."""
        mass, load = np.array([[1, 0.6], [0.6, 1]]), np.array([0.05, 0])
        stops = [vi.Stop(0, 0.0, 0.0), vi.Stop(1, 0.3, 0.9, side="lower")]
        run = simulate(vi.Scene(vi.LinearSystem(mass, [0, 0], [0, 0], load=load), None, stops), [0, 0], [0, -1], 1.3, method)
        assert run.impacts["stop"][-1] == 1
        assert run.impacts["time"][-1] == pytest.approx(0.3, rel=1e-13)
        inverse, s = np.linalg.inv(mass), 1.0
        v = np.array([0, -1]) + 1.9 * inverse[:, 1] / inverse[1, 1]
        expected = np.array([0, -0.3]) + v * s + inverse @ load * s**2 / 2
        assert run.final[0] == pytest.approx(expected, abs=1e-12)
        assert [(k["kind"], k["stop"]) for k in run.segments] == [("stick", 0), ("flight", -1)]

    def test_a_force_that_touches_zero_from_above_lets_nothing_go(self, method):
        """L = 1 + cos t."""
        scene = vi.Scene(vi.LinearSystem(1, 0, 1, load=[1]), vi.Harmonic(1, 1), vi.Stop(0, 0, 0.5))
        run = simulate(scene, 0, 0, 30, method)
        assert (run.segments["kind"].tolist(), run.final) == (["stick"], (0, 0))

    def test_a_force_that_falls_through_zero_without_slope_lets_go(self, method):
        """L = cos^3 t, of a force cos t and a spring to a body that swings as cos 3t; then the two coupled modes are free."""
        coupling = 0.5
        scene = vi.Scene(
            vi.LinearSystem([1, 1], [0, 0], [[1, coupling], [coupling, 9]]), vi.Harmonic([0.75, 0], 1), vi.Stop(0, 0, 0.0)
        )
        run = simulate(scene, [0, -0.25 / coupling], [0, 0], np.pi / 2 + 1, method)
        kinds = run.segments["kind"].tolist()
        assert kinds == ["stick", "flight"]
        assert run.segments["end"][0] == pytest.approx(np.pi / 2, abs=1e-4)
        with mp.workdps(40):
            rate = mp.zeros(6)
            rate[0, 2] = rate[1, 3] = 1
            rate[2, 0], rate[2, 1], rate[3, 0], rate[3, 1], rate[2, 4] = -1, -coupling, -coupling, -9, mpf(3) / 4
            rate[4, 5], rate[5, 4] = -1, 1
            y = -mpf(1) / (4 * coupling)
            start = mp.matrix([0, 0, 0, -3 * y * mp.sin(3 * mp.pi / 2), 0, 1])
            expected = mp.expm(rate * (mpf(run.t[-1]) - mp.pi / 2), method="taylor") * start
        assert run.final[0] == pytest.approx([float(x) for x in expected[:2]], abs=1e-10)
        assert run.final[1] == pytest.approx([float(x) for x in expected[2:4]], abs=1e-10)

    def test_a_thousand_modes_strike_a_stop(self, method):
        """sum cos(j t) / j^2 falls to -1/2: the time by 30 digits, the jump by the law; for steps a tenth of the modes."""
        n = 1000 if method == "exact" else 100
        j = np.arange(1.0, n + 1)
        stop = vi.Stop(np.ones(n), 0.5, 0.8, side="lower")
        scene = vi.Scene(vi.LinearSystem(np.ones(n), np.zeros(n), j**2), None, stop)
        run = vi.simulate(scene, 1 / j**2, np.zeros(n), (0, 4), method=method, max_impacts=1, **TIGHT)
        with mp.workdps(30):
            total = lambda t: sum((mp.cos(k * t) / k**2 for k in range(1, n + 1)), mpf(1) / 2)  # noqa: E731
            time = float(mp.findroot(total, (2.3, 2.35), tol=1e-22))
            before = np.array([float(-mp.sin(k * mpf(time)) / k) for k in range(1, n + 1)])
        assert run.impacts["time"].tolist() == [pytest.approx(time, abs=1e-11)]
        assert run.impacts["speed_before"][0] == pytest.approx(-before.sum(), abs=1e-9)
        assert run.final[1] == pytest.approx(before - 1.8 * before.mean(), abs=1e-9)


def test_links_pressed_into_dependent_stops_come_to_rest():
    """Three stops on two angles, the third through the edge of the others: they hold at the edge, stuck in each."""
    stops = [vi.Stop(i, -0.2, 0.3, side="lower") for i in (0, 1)] + [vi.Stop([1, 1], -0.4, 0.3, side="lower")]
    scene = vi.Scene(vi.PendulumChain([1, 1], [1, 1], damping=0.4, gravity=1), None, stops)
    for method in ("taylor", "rk45"):
        run = vi.simulate(scene, [0.3, 0.4], [0, 0], (0, 60), method=method)
        assert run.status == "finished", run.message
        assert run.final[0] == pytest.approx([0.2, 0.2], abs=1e-9)
        assert run.final[1] == pytest.approx([0, 0], abs=1e-9)


def test_a_held_link_is_let_go_by_the_impact_of_the_other():
    """Both at their stops, one pressed and one striking: v jumps along M^-1 n, M = [[2, cos], [cos, 1]] of equal links."""
    q, e = np.array([0.2, 0.1]), 0.9
    stops = [vi.Stop(0, 0.2, 0.0, side="upper"), vi.Stop(1, -0.1, e, side="lower")]
    scene = vi.Scene(vi.PendulumChain([1, 1], [1, 1], gravity=0), None, stops)
    inverse = np.linalg.inv([[2, np.cos(0.1)], [np.cos(0.1), 1]])
    expected = np.array([0, -1]) + (1 + e) * inverse[:, 1] / inverse[1, 1]
    assert expected[0] < 0
    for method in ("taylor", "rk45"):
        run = vi.simulate(scene, q, [0, -1], (0, 0.05), method=method)
        assert run.impacts["stop"].tolist() == [1]
        assert run.velocity(0.0) == pytest.approx(expected, abs=1e-12)
        assert run.final[0][0] < 0.2


@EVERY
def test_of_two_stops_a_rounding_apart_the_first_is_struck(method):
    run = simulate(body(method, [vi.Stop(0, 1 + 1e-12, 0.9), vi.Stop(0, 1, 0.5)]), 0, 1, 1.5, method)
    assert run.impacts["stop"].tolist() == [1]
    assert run.final[0][0] == pytest.approx(0.75, abs=1e-13)


@EVERY
def test_through_a_wide_room_at_a_speed_of_1e_12(method):
    run = simulate(body(method, walls(1, 0.5)), 0, 1e-12, 9e12, method, atol=1e-25)
    assert close(run.impacts["time"], [1e12, 5e12], rtol=1e-12)
    assert close(run.impacts["speed_before"], [1e-12, 0.5e-12], rtol=1e-12)
    assert run.stats.n_gap_evaluations < 1000


@EVERY
def test_a_damped_body_that_stops_before_the_wall_or_hits_it_at_last(method):
    """x = (1 - e^{-ct}) v/c: half-way to the stop for ever, or there at ln 2/c with half the speed."""
    scene = body(method, [vi.Stop(0, 1, 0.5)], damping=1e-3)
    # Steps of either series are held down by stability.
    run = simulate(scene, 0, 0.5e-3, 1e10 if method == "exact" else 1e6, method)
    assert len(run.impacts) == 0
    assert run.final[0][0] == pytest.approx(0.5, rel=1e-12)
    assert run.stats.n_gap_evaluations < 10_000
    run = simulate(scene, 0, 2e-3, 800, method)
    assert run.impacts["time"].tolist() == [pytest.approx(1e3 * np.log(2), rel=1e-12)]
    assert run.impacts["speed_before"].tolist() == [pytest.approx(1e-3, rel=1e-12)]


@pytest.mark.parametrize("method", ["exact", "rk45", "dop853", "radau"])
def test_a_start_at_rest_pressed_onto_a_stop_is_no_impact(method):
    """Under forcing a velocity of zero is a difference: what rounding leaves of it strikes nothing."""
    system = vi.LinearSystem([[1.0, 0.2], [0.2, 0.7]], [[0.03, -0.01], [-0.01, 0.02]], [[3.0, -1.0], [-1.0, 2.0]])
    for phase in np.linspace(0.0, 2 * np.pi, 23):
        scene = vi.Scene(system, vi.Harmonic([0.9, -0.4], 1.3, phase), vi.Stop(0, 0.1, 0.5))
        run = simulate(scene, [0.1, 3.0], [0.0, 0.0], 1e-3, method)
        assert len(run.impacts) == 0
        assert run.segments["kind"].tolist() == ["stick"]
        assert run.final[0][0] == pytest.approx(0.1, abs=1e-15)


@pytest.mark.parametrize("method", ["taylor", "rk45", "dop853", "radau"])
def test_a_link_whose_contact_force_falls_through_zero_without_slope_is_let_go(method):
    """Held at the vertical it feels s = (sin p)'' of the other, p = 2 asin(k sn t), less A sin wt: odd, from t^3 on."""
    v, w, before, after = 1.0, 3.0, 1.0, 0.5
    k, amplitude = mpf(v) / 2, -(v + v**3) / w
    angle = lambda t: 2 * mp.asin(k * mp.ellipfun("sn", t, k=k))  # noqa: E731
    start = [float(angle(-before)), float(mp.diff(angle, -before))]
    scene = vi.Scene(
        vi.PendulumChain([1, 1], [1, 1], gravity=1),
        vi.Harmonic([amplitude, 0], w, -w * before - np.pi / 2),
        vi.Stop(0, 0, 0.0, side="lower"),
    )
    run = simulate(scene, [0, start[0]], [0, start[1]], before + after, method)
    assert run.segments["kind"].tolist() == ["stick", "flight"]
    assert run.segments["end"][0] == pytest.approx(before, abs=1e-4)

    def rate(t, x):
        p, q, u, z = x
        cosine, sine = mp.cos(p - q), mp.sin(p - q)
        f, g = amplitude * mp.sin(w * t) - sine * z * z - 2 * mp.sin(p), sine * u * u - mp.sin(q)
        det = 2 - cosine**2
        return [u, z, (f - cosine * g) / det, (2 * g - cosine * f) / det]

    with mp.workdps(20):
        expected = [float(x) for x in mp.odefun(rate, 0, [0, 0, 0, mpf(v)])(after)]
    assert np.concatenate(run.final) == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("method", ["exact", "rk45", "dop853", "radau"])
@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-11, 1e-13])
@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.99])
def test_a_ball_comes_to_rest_at_its_time_whatever_the_tolerance(restitution, rtol, method):
    """From a height of one: sqrt(2) (1 + 2 e/(1 - e)); a tighter tolerance must not lose the last impacts in rounding."""
    end = np.sqrt(2.0) * (1 + 2 * restitution / (1 - restitution))
    scene = vi.Scene(vi.LinearSystem(1, 0, 0, load=-1), None, vi.Stop(0, 0, restitution, side="lower"))
    run = vi.simulate(scene, 1, 0, (0, 1.5 * end), method=method, rtol=rtol, atol=1e-3 * rtol)
    assert run.segments["kind"][-2:].tolist() == ["chatter", "stick"]
    assert run.segments["start"][-1] == pytest.approx(end, rel=1e-12)
    assert run.final == (0, 0)


@LINEAR
def test_a_contact_force_that_touches_zero_lets_nothing_go_at_any_tolerance(method):
    """L = 1 + cos t: no release, and no time that goes back."""
    scene = vi.Scene(vi.LinearSystem(1, 0, 1, load=[1]), vi.Harmonic(1, 1), vi.Stop(0, 0, 0.5))
    for rtol in (1e-4, 1e-6, 1e-9, 1e-12):
        run = vi.simulate(scene, 0, 0, (0, 200), method=method, rtol=rtol)
        assert (run.segments["kind"].tolist(), run.final) == (["stick"], (0, 0))
        assert (np.diff(run.t) >= 0).all()


@LINEAR
def test_a_contact_force_that_falls_below_zero_by_little_lets_go(method):
    """L = 1 + (1 + d) cos t, where it first is zero; behind it q = sum of an oscillation and t sin t/2."""
    for d in (1e-2, 1e-4):
        scene = vi.Scene(vi.LinearSystem(1, 0, 1, load=[1]), vi.Harmonic(1 + d, 1), vi.Stop(0, 0, 0.5))
        run = vi.simulate(scene, 0, 0, (0, 3.5), method=method)
        assert run.segments["end"][0] == pytest.approx(np.arccos(-1 / (1 + d)), abs=1e-6)
        assert run.segments["kind"][:2].tolist() == ["stick", "flight"]


@LINEAR
def test_links_that_fall_into_a_corner_come_to_rest(method):
    """One stop is held while the impacts on the other die away: what draws it back is the motion with the first held."""
    links = vi.PendulumChain([1, 1], [1, 1], damping=0.4, gravity=1).linearise()
    stops = [vi.Stop(i, -0.2, 0.3, side="lower") for i in (0, 1)]
    run = vi.simulate(vi.Scene(links, None, stops), [0.3, 0.4], [0, 0], (0, 60), method=method)
    assert run.status == "finished", run.message
    assert run.final[0] == pytest.approx([0.2, 0.2], abs=1e-11)
    assert run.final[1] == pytest.approx([0, 0], abs=1e-11)
    stuck = run.segments[run.segments["end"] == 60]
    assert sorted(stuck["stop"]) == [0, 1]
    # The impacts on the second stop while the first is held shrink by the restitution.
    late = run.impacts[(run.impacts["stop"] == 1) & (run.impacts["time"] > 1.43)]["speed_before"]
    assert late[1:6] / late[:5] == pytest.approx(0.3, rel=1e-2)


@EVERY
def test_what_is_left_of_a_speed_after_an_impact_has_its_own_digits(method):
    run = simulate(body(method, [vi.Stop(0, 1, 1e-12)]), 0, 2, 0.75, method)
    assert run.final[1][0] == pytest.approx(-2e-12, rel=1e-12, abs=0)


@pytest.mark.parametrize("ratio", [1e4, 1e6, 1e7, 1e8])
def test_a_stiff_pair_that_chatters_does_so_at_every_tolerance(ratio):
    """Equal masses, damped with their springs: impacts at 1e-6 among rates of 1e6, where time is known to rounding over speed."""
    spring = np.array([[1 + ratio, -ratio], [-ratio, ratio]])
    scene = vi.Scene(vi.LinearSystem(np.eye(2), 0.02 * spring, spring), vi.Harmonic([1.0, 0.0], 0.6), vi.Stop(1, 0.3, 0.7))
    finals = []
    for rtol in (1e-9, 1e-14):
        run = vi.simulate(scene, [0, 0], [0.3, 0.3], (0, 60), rtol=rtol, atol=1e-3 * rtol)
        assert run.status == "finished", run.message
        assert scene.gaps(run.q).min() > -1e-8
        finals.append(np.concatenate(run.final))
    assert finals[0] == pytest.approx(finals[1], abs=1e-8)


@pytest.mark.parametrize(("force", "frequency", "clearance", "load"), [(1.0, 0.6, 0.2, 0.0), (2.0, 0.5, 0.3, 0.5)])
def test_flights_lower_than_the_margin_end_where_they_end(force, frequency, clearance, load):
    """Impacts of an overdamped stiff pair, the flights between them a hundredth of the margin high and 1e-6 long."""
    spring = np.array([[1 + 1e8, -1e8], [-1e8, 1 + 1e8]])
    system = vi.LinearSystem(np.eye(2), 0.02 * spring, spring, load=[load, 0.0])
    scene = vi.Scene(system, vi.Harmonic([force, 0.0], frequency), vi.Stop(1, clearance, 0.7))
    finals = []
    for rtol in (1e-3, 1e-9, 1e-14):
        run = vi.simulate(scene, [0, 0], [0.3, 0.3], (0, 12), rtol=rtol, atol=1e-3 * rtol)
        assert run.status == "finished", run.message
        assert scene.gaps(run.q).min() > -1e-7
        finals.append(np.concatenate(run.final))
    assert finals[1] == pytest.approx(finals[2], abs=1e-8)
    assert finals[0] == pytest.approx(finals[2], abs=1e-3)


@pytest.mark.parametrize("rtol", [1e-5, 1e-6, 1e-7, 1e-8])
def test_steps_that_left_a_stop_from_inside_return_to_where_they_left(rtol):
    """A stop passed by less than its margin is struck inside it; the low flights from there never reach its zero."""
    spring = np.array([[1 + 1e4, -1e4], [-1e4, 1 + 1e4]])
    system = vi.LinearSystem(np.eye(2), 0.02 * spring, spring, load=[0.3, 0.0])
    scene = vi.Scene(system, vi.Harmonic([1.5, 0.0], 0.7), vi.Stop(1, 0.3, 0.7))
    start = [0, 0], [0.3, 0.3], (0, 40)
    run = vi.simulate(scene, *start, method="rk45", rtol=rtol, atol=0.03 * rtol)
    truth = vi.simulate(scene, *start)
    assert run.status == "finished", run.message
    assert np.concatenate(run.final) == pytest.approx(np.concatenate(truth.final), abs=10 * rtol)


class TestTwoStopsAtOnePlace:
    """What reaches one reaches the other: an orbit that hits one of them alone is none."""

    def scene(self, move=0.0, second=None):
        motion = vi.Harmonic([move], 1.5)
        stops = [vi.Stop(0, 0.2, 0.7, motion=motion), second or vi.Stop(0, 0.2, 0.4, motion=motion)]
        return vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], 1.5), stops)

    @pytest.mark.parametrize("move", [0.0, 0.05])
    @pytest.mark.parametrize("stop", [0, 1])
    def test_an_orbit_of_one(self, stop, move):
        scene = self.scene(move)
        alone = vi.periodic_orbits(scene.replace(stops=scene.stops[stop]), [0])
        both = vi.periodic_orbits(scene, [stop])
        assert len(alone) == len(both)
        assert any(orbit.is_admissible for orbit in alone)
        for orbit in both:
            assert orbit.is_admissible is False
        reasons = [orbit.violation.reason for one, orbit in zip(alone, both, strict=True) if one.is_admissible]
        assert all(f"stop {1 - stop} is reached together with those hit at t = 0" in reason for reason in reasons)

    def test_one_that_is_reached_later_changes_nothing(self):
        scene = self.scene(second=vi.Stop(0, 0.2 * (1 + 1e-9), 0.4))
        assert any(orbit.is_admissible for orbit in vi.periodic_orbits(scene, [0]))

    def test_an_integrated_orbit(self):
        scene = self.scene()
        alone = scene.replace(stops=vi.NonlinearStop(lambda q: 0.2 - q[0], lambda q: np.array([-1.0]), 0.7))
        guess = next(o for o in vi.periodic_orbits(scene.replace(stops=scene.stops[0]), [0]) if o.is_admissible)
        orbit = vi.find_orbit(alone, guess)
        assert orbit.is_admissible
        doubled = alone.replace(stops=[alone.stops[0], scene.stops[1]])
        orbit = vi.find_orbit(doubled, orbit)
        assert orbit.is_admissible is False
        assert "stop 1 is reached together" in orbit.violation.reason


def one_after_the_other(e, n=3):
    """Equal balls in a row of which the first is sent into the others: the nearest pair that closes, until none does."""
    v = np.eye(n)[0]
    while closing := [i for i in range(n - 1) if v[i] - v[i + 1] > 1e-12]:
        i = closing[-1]
        mean, half = (v[i] + v[i + 1]) / 2, (v[i] - v[i + 1]) / 2
        v[i], v[i + 1] = mean - e * half, mean + e * half
    return v


@pytest.mark.parametrize("e", [1.0, 0.5, 0.0])
@pytest.mark.parametrize("gap", [0.0, 1e-12, 1e-6])
def test_touching_balls_obey_the_law_that_the_plan_says(e, gap):
    """In contact Newton's law of all at once, with any gap between them one impact after the other."""
    stops = [vi.Stop([1, -1, 0], 1.0, e), vi.Stop([0, 1, -1], gap, e)]
    scene = vi.Scene(vi.LinearSystem(np.ones(3), np.zeros(3), np.zeros(3)), stops=stops)
    assert "Newton's law for all that are hit or touched at one instant, not for one after the other" in scene.plan()
    run = vi.simulate(scene, np.zeros(3), [1.0, 0.0, 0.0], (0.0, 3.0))
    if gap > 0.0:
        expected = one_after_the_other(e)
    else:
        # Opening speeds e and 0 of the two contacts, and the momentum.
        normals = np.array([[-1.0, 1.0, 0.0], [0.0, -1.0, 1.0], [1.0, 1.0, 1.0]])
        expected = np.linalg.solve(normals, [e, 0.0, 1.0])
    np.testing.assert_allclose(run.final[1], expected, atol=1e-9)
