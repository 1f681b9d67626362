"""What is measured along a motion: components, accelerations, gaps, contact forces."""

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
        ):
            with pytest.raises(ValueError, match="keep"):
                ask()

    def test_a_scene_without_stops(self):
        run = vi.simulate(vi.Scene(PRESSED.system), [0, 0], [0, 1], (0, 1))
        with pytest.raises(ValueError, match="stop is 0, but the scene has no stops"):
            run.gap(0)
