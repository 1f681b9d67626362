"""What is measured along a motion: components, accelerations, gaps, contact forces."""

from itertools import pairwise

import numpy as np
import pytest

import vibroimpact as vi

METHODS = ("exact", "rk45", "dop853", "radau")
MASS = np.array([[2.0, 0.5], [0.5, 1.0]])
DAMPING = np.array([[0.3, -0.1], [-0.1, 0.2]])
STIFFNESS = np.array([[3.0, -1.0], [-1.0, 2.0]])
LOAD, FORCE, FREQUENCY, PHASE = np.array([0.3, 0.1]), np.array([0.5, -2.5]), 0.3, 0.4
NORMAL = np.array([0.6, -0.8])
# A pair that is pressed onto its stop, let go, and hits it again and again on the way there.
PRESSED = vi.Scene(
    vi.LinearSystem(MASS, DAMPING, STIFFNESS, load=LOAD),
    vi.Harmonic(FORCE, FREQUENCY, PHASE),
    [vi.Stop(NORMAL, 0.1, 0.5), vi.Stop(1, 0.4, 0.3, side="lower")],
)
BALL = vi.Scene(vi.LinearSystem(2.0, 0.0, 0.0, load=[-2.0 * 9.81]), stops=vi.Stop(0, 0.0, 0.5, side="lower"))
HELD_BALL = vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0, load=[-1.0]), vi.Harmonic(1.3, 1.0), vi.Stop(0, 0.0, 0.5, side="lower"))
WALLED = vi.Scene(vi.PendulumChain([1.0, 0.5], [0.5, 0.3], damping=0.05), stops=vi.Wall(1, -0.2, 0.4))


def pressed(method="auto", **options):
    return vi.simulate(PRESSED, [0.0, 0.0], [0.0, 0.0], (0, 60), method=method, **options)


def of_kind(run, kind, count=7):
    """Times inside the segments of a kind, away from their ends."""
    rows = run.segments[run.segments["kind"] == kind]
    parts = np.linspace(0.05, 0.95, count)
    return np.concatenate([row["start"] + (row["end"] - row["start"]) * parts for row in rows])


def held_orbit():
    return vi.find_orbit(HELD_BALL, vi.simulate(HELD_BALL, 0.3, 0.0, (0, 12 * HELD_BALL.period)))


class TestAlong:
    def test_position_and_velocity_are_those_of_the_motion_on_both_sides_of_an_impact(self):
        run = pressed()
        t = np.concatenate([np.linspace(0, 60, 91), run.impacts["time"][:20]])
        for side in ("after", "before"):
            np.testing.assert_allclose(run.along(NORMAL, t, side=side), run.position(t) @ NORMAL, rtol=0, atol=1e-15)
            np.testing.assert_allclose(run.along(NORMAL, t, 1, side), run.velocity(t, side) @ NORMAL, rtol=0, atol=1e-15)
        assert np.array_equal(run.along(1, t), run.position(t)[:, 1])
        hit = run.impacts[run.impacts["stop"] == 0][0]
        assert run.along(NORMAL, hit["time"], 1, "before") == pytest.approx(hit["speed_before"], rel=1e-12)
        assert run.along(NORMAL, hit["time"], 1) == pytest.approx(-hit["speed_after"], rel=1e-12)

    def test_without_times_it_is_that_of_the_rows(self):
        for run in (pressed(), pressed(t_eval=[0.0, 3.0, 17.5]), pressed(t_eval=[0.0, 3.0, 17.5], keep="final")):
            np.testing.assert_allclose(run.along(NORMAL), run.q @ NORMAL, rtol=0, atol=1e-15)
            np.testing.assert_allclose(run.along(NORMAL, derivative=1), run.v @ NORMAL, rtol=0, atol=1e-15)
            np.testing.assert_allclose(run.gap(0), PRESSED.gaps(run.q)[:, 0], rtol=0, atol=1e-15)
        # Points for drawing stand on both sides of an impact, each on its own.
        run = pressed()
        at = np.flatnonzero(run.t == run.impacts["time"][0])
        before, after = (run.acceleration(run.t[at[0]], side) @ NORMAL for side in ("before", "after"))
        np.testing.assert_allclose(run.along(NORMAL, derivative=2)[at], [before, after], rtol=1e-13)
        assert before != after

    def test_rows_at_given_times_have_a_side_too(self):
        free = pressed()
        hit = free.impacts["time"][0]
        run = pressed(t_eval=[0.0, hit, 60.0])
        for derivative in (1, 2):
            before, after = (run.along(NORMAL, hit, derivative, side) for side in ("before", "after"))
            assert before != after
            assert run.along(NORMAL, None, derivative, "before")[1] == before
            assert run.along(NORMAL, None, derivative)[1] == pytest.approx(float(after), rel=1e-13)

    def test_a_single_time_is_a_single_number(self):
        run, orbit = pressed(), held_orbit()
        for motion in (run, orbit):
            for value in (motion.along(0, 0.5), motion.along(0, 0.5, 2), motion.gap(0, 0.5), motion.contact_force(0, 0.5)):
                assert value.shape == ()
            assert motion.along(0, [0.5, 0.7, 0.9]).shape == (3,)
            assert motion.acceleration(0.5).shape == (motion.scene.n_dof,)
            assert motion.acceleration([0.5, 0.7]).shape == (2, motion.scene.n_dof)

    def test_an_index_is_the_unit_vector(self):
        run = pressed()
        for derivative in (0, 1, 2):
            assert np.array_equal(run.along(np.int32(1), None, derivative), run.along([0, 1], None, derivative))


class TestAcceleration:
    @pytest.mark.parametrize("method", METHODS)
    def test_it_balances_all_forces_in_flight_and_in_contact(self, method):
        run = pressed(method)
        assert {"flight", "chatter", "stick"} == set(run.segments["kind"])
        t = np.concatenate([of_kind(run, "flight"), of_kind(run, "stick")])
        q, v, a = run.position(t), run.velocity(t), run.acceleration(t)
        given = LOAD + FORCE * np.cos(FREQUENCY * t + PHASE)[:, None]
        pushed = run.contact_force(0, t)[:, None] * NORMAL - run.contact_force(1, t)[:, None] * [0, 1]
        np.testing.assert_allclose(a @ MASS + v @ DAMPING + q @ STIFFNESS, given - pushed, rtol=0, atol=1e-11)

    @pytest.mark.parametrize("scene", [PRESSED, WALLED, vi.paper_scene(kind=3, linear=False)])
    def test_it_is_the_derivative_of_the_velocity(self, scene):
        run = vi.simulate(scene, [-0.3, -0.3], [0.3, 0.0], (0, 12), rtol=1e-11)
        kinds = set(run.segments["kind"])
        t = np.concatenate([of_kind(run, kind) for kind in kinds])
        h = 1e-4
        is_inside = np.all([np.abs(t - edge) > 3 * h for edge in [*run.segments["start"], *run.segments["end"]]], axis=0)
        t = t[is_inside]
        assert len(t) > 20
        v = [run.velocity(t + k * h) for k in (-2, -1, 1, 2)]
        difference = (v[0] - 8 * v[1] + 8 * v[2] - v[3]) / (12 * h)
        np.testing.assert_allclose(run.acceleration(t), difference, rtol=0, atol=1e-7)

    def test_a_damper_makes_it_jump_at_an_impact(self):
        run = pressed()
        t = run.impacts["time"][:10]
        jump = run.acceleration(t) - run.acceleration(t, "before")
        dv = run.velocity(t) - run.velocity(t, "before")
        np.testing.assert_allclose(jump, np.linalg.solve(MASS, -DAMPING @ dv.T).T, rtol=0, atol=1e-13)

    def test_functions_have_that_of_the_linear_system_that_they_write_out(self):
        def acceleration(t, q, v):
            return np.linalg.solve(MASS, LOAD - DAMPING @ v - STIFFNESS @ q)

        functions = vi.Scene(vi.NonlinearSystem(2, acceleration, mass=MASS), PRESSED.forcing, PRESSED.stops)
        one, other = (vi.simulate(scene, [0, 0], [0, 0], (0, 30), method="dop853") for scene in (functions, PRESSED))
        t = of_kind(other, "stick")
        np.testing.assert_allclose(one.acceleration(t), other.acceleration(t), rtol=0, atol=1e-9)
        np.testing.assert_allclose(one.contact_force(0, t), other.contact_force(0, t), rtol=0, atol=1e-9)


class TestContact:
    def test_a_ball_at_rest_weighs_what_it_weighs(self):
        run = vi.simulate(BALL, 1.0, 0.0, (0, 3))
        rest = run.segments[-1]
        assert rest["kind"] == "stick"
        t = np.linspace(rest["start"], 3, 5)
        np.testing.assert_allclose(run.contact_force(0, t), 2.0 * 9.81, rtol=1e-15)
        assert not np.any(run.acceleration(t))
        assert not np.any(run.contact_force(0, np.linspace(0, run.impacts["time"][-1], 50)))

    def test_a_force_that_has_no_unit_of_its_own_is_an_acceleration(self):
        stop = vi.Stop(0, 0.0, 0.5, side="lower", reaction="coordinate")
        run = vi.simulate(BALL.replace(stops=[stop]), 1.0, 0.0, (0, 3))
        assert run.contact_force(0, 3.0) == pytest.approx(9.81, rel=1e-15)

    @pytest.mark.parametrize("method", METHODS)
    def test_forces_push_and_only_where_the_gap_is_closed(self, method):
        run = pressed(method)
        for stop in (0, 1):
            gap, force = run.gap(stop), run.contact_force(stop)
            assert gap.min() > -1e-8
            assert force.min() == 0.0
            assert np.abs(gap[force > 0]).max(initial=0.0) < 1e-8
            assert force.max() > 0.5

    def test_impacts_that_accumulate_are_no_lasting_contact(self):
        run = pressed()
        t = of_kind(run, "chatter")
        assert len(t) > 0
        assert not np.any(run.contact_force(0, t))

    def test_two_stops_carry_a_load_between_them(self):
        # A mass pressed into a corner by gravity: each wall carries the part of the load along its normal.
        load = np.array([-3.0, -5.0])
        walls = [vi.Stop(k, 0.0, 0.4, side="lower") for k in (0, 1)]
        run = vi.simulate(
            vi.Scene(vi.LinearSystem(np.ones(2), np.zeros(2), np.zeros(2), load=load), stops=walls), [0, 0], [0, 0], (0, 1)
        )
        for stop in (0, 1):
            np.testing.assert_allclose(run.contact_force(stop), -load[stop], rtol=1e-15)

    def test_a_bob_held_by_a_wall_stays_on_it(self):
        run = vi.simulate(WALLED, [-0.3, -0.3], [0.0, 0.0], (0, 30), rtol=1e-10)
        rest = run.segments[-1]
        assert rest["kind"] == "stick"
        t = np.linspace(rest["start"], rest["end"], 9)
        assert np.abs(run.gap(0, t)).max() < 1e-9
        # h'' = l.(sin(q) v^2 - cos(q) a) = 0, whatever the motion along the wall.
        q, v, a = run.position(t), run.velocity(t), run.acceleration(t)
        bend = (np.sin(q) * v**2 - np.cos(q) * a) @ [0.5, 0.3]
        assert np.abs(bend).max() < 1e-12
        # At rest the moments about the upper joint balance: the wall's force times its arm against the weights.
        end = run.position(30.0)
        weights = 9.81 * (1.5 * 0.5 * np.sin(end[0]) + 0.5 * 0.3 * np.sin(end[1]))
        arm = 0.5 * np.cos(end[0]) + 0.3 * np.cos(end[1])
        assert run.contact_force(0, 30.0) == pytest.approx(-weights / arm, rel=1e-3)


def integral(motion, values, span):
    """The integral of a function of time along a motion, by Gauss's rule of 20 points on short pieces between its events."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    segments, (first, last) = motion.segments, span
    edges = np.concatenate([segments["start"], segments["end"], motion.impacts["time"], np.linspace(first, last, 200)])
    edges = np.unique(np.clip(edges, first, last))
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)
    t = (middle[:, None] + half[:, None] * nodes).ravel()
    return np.tensordot((half[:, None] * weights).ravel(), values(t), axes=1)


def balance(motion, system, given, normals, span, sides=("after", "after")):
    """What is missing in the balance of momentum of a linear system, beside the largest of its terms."""
    change = system.mass @ (motion.velocity(span[1], sides[1]) - motion.velocity(span[0], sides[0]))
    forces = integral(
        motion, lambda t: given(t) - motion.velocity(t) @ system.damping.T - motion.position(t) @ system.stiffness.T, span
    )
    pushed = [motion.impulse(stop, span) * normal for stop, normal in enumerate(normals)]
    size = max(np.abs(change).max(), np.abs(forces).max(), np.abs(pushed).max())
    return np.abs(change - forces + np.sum(pushed, axis=0)).max() / size


def pressed_force(t):
    return LOAD + FORCE * np.cos(FREQUENCY * np.asarray(t) + PHASE)[..., None]


class TestImpulse:
    @pytest.mark.parametrize("method", METHODS)
    def test_the_momentum_balances_with_chatter_and_lasting_contact(self, method):
        rtol = 1e-9
        run = pressed(method, rtol=rtol)
        for stop in (0, 1):
            kinds = run.segments["kind"][run.segments["stop"] == stop]
            assert {"chatter", "stick"} == set(kinds)
        normals = [NORMAL, np.array([0.0, -1.0])]
        for span in [(0.0, 60.0), (7.3, 41.9), (0.0, 20.0)]:
            assert balance(run, PRESSED.system, pressed_force, normals, span) < 10 * rtol
        if method == "exact":  # to rounding
            assert balance(run, PRESSED.system, pressed_force, normals, (0.0, 60.0)) < 1e-12

    @pytest.mark.parametrize("method", ["exact", "rk45"])
    def test_the_momentum_of_any_pressed_bodies_balances(self, method):
        rng, n_spent = np.random.default_rng(5), 0
        for _ in range(80):
            n, k = rng.integers(1, 5, 2)
            mass, damping, stiffness = (m @ m.T / n for m in rng.normal(size=(3, n, n)))
            system = vi.LinearSystem(mass + np.eye(n), 0.2 * damping, stiffness * rng.integers(2), load=3 * rng.normal(size=n))
            force, frequency = rng.normal(size=n), rng.uniform(0.2, 1.5)
            outward = rng.normal(size=(k, n))
            stops = [
                vi.Stop(side * normal, rng.choice([0.0, 0.1]), rng.choice([0.0, 0.3, 0.6]), side="upper" if side > 0 else "lower")
                for normal, side in zip(outward, rng.choice([-1, 1], k), strict=True)
            ]
            scene = vi.Scene(system, vi.Harmonic(force, frequency), stops)
            run = vi.simulate(scene, np.zeros(n), np.zeros(n), (0, 10), method=method, max_impacts=300)

            def given(t, system=system, force=force, frequency=frequency):
                return system.load + force * np.cos(frequency * np.asarray(t))[..., None]

            segments = run.segments
            n_spent += np.count_nonzero((segments["kind"] == "chatter") & (segments["start"] == segments["end"]))
            # Speeds whose flights rise by no more than rounding, its square root, are none.
            assert segments["impulse"].min() > -1e-6
            assert balance(run, system, given, outward, (0.0, run.t_end)) < (1e-12 if method == "exact" else 1e-8)
        assert n_spent > 10, "several stops come to rest at one instant"

    def test_without_chatter_half_of_it_would_be_missing(self):
        # A ball that comes to rest: the impacts that are listed give less than its weight does until then.
        run = vi.simulate(BALL.replace(restitution=0.9), 1.0, 0.0, (0, 40))
        assert run.impulse(0) == pytest.approx(40 * 2.0 * 9.81, rel=1e-13)
        assert run.impacts["impulse"].sum() < 0.5 * run.impulse(0)

    @pytest.mark.parametrize("method", METHODS)
    @pytest.mark.parametrize("restitution", [0.2, 0.5, 0.9])
    def test_chatter_gives_the_sum_of_its_geometric_series(self, method, restitution):
        scene = BALL.replace(restitution=restitution)
        run = vi.simulate(scene, 1.0, 0.0, (0, 60), method=method)
        (chatter,) = run.segments[run.segments["kind"] == "chatter"]
        # The first impact left out is as fast as the one before it leaves the stop.
        speed = run.impacts["speed_after"][-1]
        rest = 2.0 * (1 + restitution) * speed / (1 - restitution)
        assert chatter["impulse"] == pytest.approx(rest, rel=1e-7)
        # All impacts together: they turn the first speed round, and carry the weight until they come to rest.
        first = np.sqrt(2 * 9.81)
        assert run.impacts["impulse"].sum() + chatter["impulse"] == pytest.approx(
            2.0 * first * (1 + restitution) / (1 - restitution), rel=1e-8
        )

    def test_it_is_the_sum_of_the_impacts_and_of_the_segments(self):
        run, orbit = pressed(), held_orbit()
        for motion, stops in ((run, (0, 1)), (orbit, (0,))):
            impacts, segments = motion.impacts, motion.segments
            assert segments.dtype.names[-1] == "impulse"
            assert not np.any(segments["impulse"][segments["kind"] == "flight"])
            for stop in stops:
                parts = [rows["impulse"][rows["stop"] == stop].sum() for rows in (impacts, segments)]
                assert motion.impulse(stop) == pytest.approx(sum(parts), rel=1e-13)
                assert min(parts) > 0

    def test_that_of_a_stick_is_its_force_over_its_time(self):
        run = pressed()
        for row in run.segments[run.segments["kind"] == "stick"]:
            span = (row["start"], row["end"])
            force = integral(run, lambda t, stop=row["stop"]: run.contact_force(stop, t), span)
            assert row["impulse"] == pytest.approx(force, rel=1e-11)
            assert run.impulse(row["stop"], span) == pytest.approx(force, rel=1e-11)

    def test_spans_add_up_and_an_impact_counts_where_it_is_behind_the_start(self):
        run = pressed()
        times = [0.0, 3.3, run.impacts["time"][0], run.impacts["time"][7], 31.4, 60.0]
        chatter = run.segments[run.segments["kind"] == "chatter"][0]
        times = np.sort([*times, chatter["start"], 0.5 * (chatter["start"] + chatter["end"]), chatter["end"]])
        for stop in (0, 1):
            parts = [run.impulse(stop, span) for span in pairwise(times)]
            assert sum(parts) == pytest.approx(run.impulse(stop), rel=1e-12)
        hit = run.impacts[0]
        t, stop = hit["time"], int(hit["stop"])
        assert run.impulse(stop, (t - 1e-6, t)) == hit["impulse"]
        assert run.impulse(stop, (t, t + 1e-6)) == 0.0
        assert run.impulse(stop, (t, t)) == 0.0

    def test_an_impact_at_the_start_of_a_run_counts(self):
        run = vi.simulate(BALL, 0.0, -1.0, (0, 0.01))
        assert len(run.impacts) == 1
        assert run.impulse(0) == run.impulse(0, (0, 0.005)) == run.impacts["impulse"][0] == pytest.approx(2.0 * 1.5, rel=1e-15)
        assert run.impulse(0, (0.001, 0.01)) == 0.0

    def test_a_run_that_ends_among_accumulating_impacts_balances(self):
        end = vi.simulate(BALL, 1.0, 0.0, (0, 3)).segments
        (chatter,) = end[end["kind"] == "chatter"]
        for part in (0.0, 0.3, 1.0):
            t = chatter["start"] + part * (chatter["end"] - chatter["start"])
            run = vi.simulate(BALL, 1.0, 0.0, (0, t))
            assert run.impulse(0) == pytest.approx(2.0 * (9.81 * t + float(run.final[1][0])), rel=1e-13)

    def test_any_reaction_changes_the_velocity_by_its_impulses(self):
        # q'' = a_free - b L with b = n, and with a b of its own: M b p is what is given.
        for reaction in ("coordinate", [1.0, -0.2]):
            stop = vi.Stop(NORMAL, 0.1, 0.5, reaction=reaction)
            scene = PRESSED.replace(stops=[stop])
            run = vi.simulate(scene, [0.0, 0.0], [0.0, 0.0], (0, 60))
            assert {"flight", "chatter", "stick"} == set(run.segments["kind"])
            b = NORMAL if reaction == "coordinate" else np.array(reaction)
            assert balance(run, PRESSED.system, pressed_force, [MASS @ b], (0.0, 60.0)) < 1e-11

    def test_what_comes_to_rest_beside_another_stop_gives_its_last_speed(self):
        # Pressed to one wall the body bounces on the other until rounding ends it.
        load = np.array([-3.0, -5.0])
        system = vi.LinearSystem(np.array([[2.0, 0.3], [0.3, 1.0]]), np.zeros((2, 2)), np.zeros((2, 2)), load=load)
        walls = [vi.Stop(k, 0.0, 0.5, side="lower") for k in (0, 1)]
        for method in ("exact", "rk45"):
            run = vi.simulate(vi.Scene(system, stops=walls), [0.0, 0.2], [0.0, 0.0], (0, 3), method=method)
            assert {"flight", "chatter", "stick"} >= set(run.segments["kind"])
            assert not np.any(np.abs(run.final[1]) > 1e-12)
            given = [run.impulse(stop) for stop in (0, 1)]
            np.testing.assert_allclose(given, -load * 3, rtol=1e-12)

    @pytest.mark.parametrize("ratio", [0.0, 1e-4, 0.01])
    def test_fast_modes_of_a_body_that_is_held_are_integrated(self, ratio):
        # Thirty modes to 3000 rad/s, shaken by the landing: what they do to the force is integrated in closed form.
        w = np.concatenate([[0.0, 1.0], np.geomspace(3.0, 3e3, 28)])
        tip = np.cos(np.arange(30) * np.pi)
        system = vi.LinearSystem(np.ones(30), 2 * ratio * w, w**2, load=3.0 * tip)
        stop = vi.Stop(tip, 0.0, 0.0)
        scene = vi.Scene(system, vi.Harmonic(tip, 0.7, 0.3), stop)
        start = -1e-4 * tip / 30
        run = vi.simulate(scene, start, np.zeros(30), (0, 4))
        held = run.segments[run.segments["kind"] == "stick"]
        assert np.sum(held["end"] - held["start"]) > 3.5
        # The momentum of the rigid mode: the load, the force and the stop.
        given = 3.0 * run.t_end + (np.sin(0.7 * run.t_end + 0.3) - np.sin(0.3)) / 0.7
        assert run.impulse(0) == pytest.approx(given - float(run.final[1][0]) / tip[0], rel=1e-9)
        middle = 0.37 * run.t_end
        parts = run.impulse(0, (0, middle)), run.impulse(0, (middle, run.t_end))
        assert sum(parts) == pytest.approx(run.impulse(0), rel=1e-9)
        given = 3.0 * middle + (np.sin(0.7 * middle + 0.3) - np.sin(0.3)) / 0.7
        assert parts[0] == pytest.approx(given - float(run.velocity(middle)[0]) / tip[0], rel=1e-9)

    def test_all_harmonics_of_a_force_are_integrated(self):
        amplitudes = np.zeros((60, 1))
        amplitudes[[0, 59], 0] = 0.5, 90.0
        mean, w = 4.0, 1.0
        scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 0.0, load=[mean]), vi.Fourier(amplitudes, w), vi.Stop(0, 0.3, 0.0))
        run = vi.simulate(scene, 0.0, 0.0, (0, 20))
        assert "stick" in run.segments["kind"]
        given = mean * 20 + 0.5 * np.sin(20.0) + 1.5 * np.sin(1200.0)
        change = float(run.final[1][0]) + 0.1 * float(run.final[0][0])
        assert run.impulse(0) == pytest.approx(given - change, rel=1e-9)
        largest = np.abs(run.energy.forcing_work).max()
        assert np.abs(run.energy.balance).max() < 1e-9 * largest

    def test_a_chain_on_a_wall_balances_its_moments(self):
        # Generalised momenta: d/dt (M(q) v) = -dV/dq + v.dM/dq v/2 - C v - n L, integrated along the motion.
        masses, lengths, damping = np.array([1.0, 0.5]), np.array([0.5, 0.3]), np.array([[0.1, -0.05], [-0.05, 0.05]])
        run = vi.simulate(WALLED, [-0.6, -0.3], [0.0, 0.0], (0, 20), rtol=1e-10)
        assert {"flight", "chatter", "stick"} == set(run.segments["kind"])
        inertia = np.outer(lengths, lengths) * np.array([[masses.sum(), masses[1]], [masses[1], masses[1]]])
        moment = lengths * [masses.sum(), masses[1]]

        def momentum(t, side):
            q, v = run.position(t), run.velocity(t, side)
            return inertia * np.cos(q[:, None] - q) @ v

        def forces(t):
            q, v = run.position(t), run.velocity(t)
            bent = inertia[0, 1] * np.sin(q[:, 0] - q[:, 1]) * v[:, 0] * v[:, 1]
            return -9.81 * moment * np.sin(q) - np.stack([bent, -bent], axis=1) - v @ damping

        # The normal turns with the motion: of each impact, of the chatters and along the sticks.
        def normal(t):
            return lengths * np.cos(run.position(t))

        pushed = np.sum([hit["impulse"] * normal(hit["time"]) for hit in run.impacts], axis=0)
        for row in run.segments[run.segments["stop"] == 0]:
            if row["kind"] == "chatter":
                pushed = pushed + row["impulse"] * normal(row["start"])
            else:
                span = (row["start"], row["end"])
                pushed = pushed + integral(run, lambda t: run.contact_force(0, t)[:, None] * normal(t), span)
        missing = momentum(20.0, "after") - momentum(0.0, "before") - integral(run, forces, (0.0, 20.0)) + pushed
        assert np.abs(missing).max() < 1e-8 * np.abs(pushed).max()


class TestOrbits:
    def test_they_have_what_a_trajectory_along_them_has(self):
        orbit = vi.periodic_orbits(vi.paper_scene(kind=3), pattern=[1], n_periods=2)[0]
        run = vi.simulate(orbit.scene, orbit.q0, orbit.v0, (0, 3.5 * orbit.period))
        t = np.linspace(0.1, 3.4 * orbit.period, 40)
        for derivative in (0, 1, 2):
            np.testing.assert_allclose(orbit.along([0.3, 1.0], t, derivative), run.along([0.3, 1.0], t, derivative), atol=1e-9)
        np.testing.assert_allclose(orbit.acceleration(t), run.acceleration(t), atol=1e-9)
        np.testing.assert_allclose(orbit.gap(1, t), run.gap(1, t), atol=1e-9)
        for side in ("before", "after"):
            np.testing.assert_allclose(
                orbit.acceleration(orbit.period, side), run.acceleration(run.impacts["time"][0], side), atol=1e-9
            )
        assert orbit.along(1, 0.0, 1, "before") == pytest.approx(orbit.impacts["speed_before"][0], rel=1e-12)

    def test_any_time_will_do_and_every_period_is_as_the_first(self):
        for orbit in (
            held_orbit(),
            vi.find_orbit(vi.paper_scene(kind=3, linear=False), vi.periodic_orbits(vi.paper_scene(kind=3), [1], 2)[0]),
        ):
            t = np.linspace(0.01, 0.99, 30) * orbit.period
            for ask in (
                lambda t, o=orbit: o.along(0, t, 2),
                lambda t, o=orbit: o.gap(0, t),
                lambda t, o=orbit: o.contact_force(0, t),
            ):
                np.testing.assert_allclose(ask(t - 3 * orbit.period), ask(t), atol=1e-9)

    def test_a_held_ball_is_pressed_by_what_does_not_move_it(self):
        orbit = held_orbit()
        stick = orbit.segments[orbit.segments["kind"] == "stick"][0]
        t = np.linspace(stick["start"], stick["end"], 11)[1:-1]
        np.testing.assert_allclose(orbit.contact_force(0, t), 1.0 - 1.3 * np.cos(t + orbit.phase), rtol=1e-9)
        assert np.abs(orbit.acceleration(t)).max() < 1e-13
        flight = orbit.segments[0]
        t = np.linspace(flight["start"], flight["end"], 11)[1:-1]
        np.testing.assert_allclose(orbit.along(0, t, 2), 1.3 * np.cos(t + orbit.phase) - 1.0, rtol=0, atol=1e-13)
        assert not np.any(orbit.contact_force(0, t))

    def test_a_period_gives_back_what_the_weight_takes(self):
        for orbit in (held_orbit(), vi.periodic_orbits(HELD_BALL.replace(forcing_scale=0.9), [0])[0]):
            assert orbit.impulse(0) == pytest.approx(orbit.period, rel=1e-10)
        # Steps: the ball as a function.
        ball = vi.NonlinearSystem(1, lambda t, q, v: np.array([-1.0]), mass=1.0)
        scene = vi.Scene(ball, HELD_BALL.forcing, HELD_BALL.stops)
        stepped = vi.find_orbit(scene, vi.simulate(scene, 0.3, 0.0, (0, 12 * scene.period), rtol=1e-10))
        assert {"flight", "chatter", "stick"} == set(stepped.segments["kind"])
        assert stepped.impulse(0) == pytest.approx(stepped.period, rel=1e-9)

    def test_spans_of_any_times_add_up_to_whole_periods(self):
        orbit = held_orbit()
        one, period = orbit.impulse(0), orbit.period
        for start in (0.0, 0.3, -7.7, 2.5 * period, float(orbit.impacts["time"][1])):
            assert orbit.impulse(0, (start, start + 3 * period)) == pytest.approx(3 * one, rel=1e-9)
            middle = start + 0.4 * period
            parts = orbit.impulse(0, (start, middle)) + orbit.impulse(0, (middle, start + period))
            assert parts == pytest.approx(one, rel=1e-9)
        # A time within rounding of an impact is the impact: the period is over there.
        assert orbit.impulse(0, (0.0, np.nextafter(3 * period, 0.0))) == pytest.approx(3 * one, rel=1e-12)
        # Along the orbit from right after its first impact: the weight and what the velocity changes by.
        for t in (0.2, 0.5 * period, 0.9 * period):
            change = orbit.velocity(t)[0] - orbit.v0[0] - 1.3 * (np.sin(t + orbit.phase) - np.sin(orbit.phase))
            assert orbit.impulse(0, (0.0, t)) == pytest.approx(t + change, abs=1e-9)


class TestEnd:
    @pytest.mark.parametrize("keep", ["motion", "impacts", "final"])
    def test_a_run_goes_on_from_its_end_in_the_same_phase(self, keep):
        whole = pressed()
        first = vi.simulate(PRESSED, [0, 0], [0, 0], (0, 100), keep=keep, max_impacts=3)
        assert first.t_end == whole.impacts["time"][2]
        second = vi.simulate(PRESSED, *first.final, (first.t_end, 60))
        assert second.t_end == 60.0
        np.testing.assert_allclose(second.final, whole.final, rtol=0, atol=1e-9)


class TestRefusals:
    @pytest.mark.parametrize("motion", [pressed(), held_orbit()], ids=["trajectory", "orbit"])
    @pytest.mark.parametrize(
        ("name", "arguments", "message"),
        [
            ("along", (2, 0.5), r"direction is 2, but the system has coordinates 0 to"),
            ("along", (-1, 0.5), r"direction is -1, but indices count from 0"),
            ("along", (True, 0.5), r"direction is True, but an index"),
            ("along", ([1.0, 2.0, 3.0], 0.5), r"direction has shape \(3,\), but \(.,\)"),
            ("along", ("tip", 0.5), r"direction is 'tip', but"),
            ("along", (0, 0.5, 3), r"derivative is 3, but it must be 0 \(position\), 1"),
            ("along", (0, 0.5, -1), r"derivative is -1, but it must be 0"),
            ("along", (0, 0.5, 1, "left"), r"side is \"left\", but it must be \"after\" or \"before\""),
            ("acceleration", (0.5, "left"), r"side is \"left\""),
            ("along", (0, float("nan")), r"t is NaN, but"),
            ("acceleration", (float("nan"),), r"t is NaN, but"),
            ("acceleration", ([[0.0]],), r"t has shape \(1, 1\)"),
            ("gap", (7, 0.5), r"stop is 7, but the scene has stops 0 to"),
            ("gap", (-1, 0.5), r"stop is -1, but indices count from 0"),
            ("gap", (0, float("inf")), r"t is inf, but"),
            ("impulse", (7,), r"stop is 7, but the scene has stops 0 to"),
            ("impulse", (0, (1.0, 0.5)), r"span is \(1.0, 0.5\), but it must be finite with start <= end"),
            ("impulse", (0, (0.0, float("nan"))), r"span is \(0.0, NaN\), but it must be finite"),
            ("impulse", (0, 1.0), r"span has shape \(1,\), but \(start, end\) is needed"),
            ("contact_force", (7, 0.5), r"stop is 7, but the scene has stops 0 to"),
            ("contact_force", (0.5, 0.5), r"stop is 0.5, but an index is needed"),
            ("contact_force", (0, float("nan")), r"t is NaN, but"),
        ],
    )
    def test_names_the_argument_the_value_and_the_rule(self, motion, name, arguments, message):
        with pytest.raises(ValueError, match=message):
            getattr(motion, name)(*arguments)

    def test_times_outside_of_a_run(self):
        run = pressed()
        for ask in (lambda t: run.along(0, t), run.acceleration, lambda t: run.gap(0, t), lambda t: run.contact_force(0, t)):
            for t in (-0.1, 60.1):
                with pytest.raises(ValueError, match=r"t is .*, but it must lie in the span \[0, 60\]"):
                    ask(t)

    def test_spans_outside_of_a_run(self):
        for span in ((-1.0, 3.0), (3.0, 61.0)):
            with pytest.raises(ValueError, match=r"span is .*, but it must lie in the span \[0, 60\]"):
                pressed().impulse(0, span)

    @pytest.mark.parametrize("keep", ["impacts", "final"])
    def test_a_motion_that_was_not_kept(self, keep):
        run = pressed(keep=keep, t_eval=[0.0, 1.0])
        for ask in (
            lambda: run.along(0, 1.0),
            lambda: run.along(0, None, 2),
            lambda: run.along(0, None, 1, "before"),
            lambda: run.acceleration(1.0),
            lambda: run.gap(0, 1.0),
            lambda: run.contact_force(0),
            lambda: run.impulse(0),
            lambda: run.segments,
        ):
            with pytest.raises(ValueError, match="keep"):
                ask()

    def test_a_scene_without_stops(self):
        run = vi.simulate(vi.Scene(PRESSED.system), [0, 0], [0, 1], (0, 1))
        with pytest.raises(ValueError, match="stop is 0, but the scene has no stops"):
            run.gap(0)
