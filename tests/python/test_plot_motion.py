"""Time histories, phase portraits and Poincare sections of motions with a closed form."""

from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from plot_models import BouncingOrbit, BouncingTrajectory, Shuttle, contains, curve, impacts_at, labelled, largest_step, stop

import vibroimpact.plot as plot


class TestTimeHistory:
    def test_position_of_an_orbit_over_one_period(self):
        ax = plot.time_history(BouncingOrbit())
        t, q = curve(ax)
        assert (t[0], t[-1]) == (0.0, 2.0)
        assert np.all(np.diff(t) >= 0.0)
        np.testing.assert_allclose(q, t - t**2 / 2, atol=1e-12)
        assert largest_step(q) < 0.01
        assert contains(ax, t, q)
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("time t", "position q[0]")

    def test_velocity_is_broken_between_the_sides_of_an_impact(self):
        ax = plot.time_history(BouncingOrbit(), quantity="velocity", periods=2)
        t, v = curve(ax)
        assert (t[0], v[0]) == (0.0, 1.0)
        (rows,) = np.nonzero(np.isnan(v))
        assert len(rows) == 2  # at t = 2, and at the end, t = 4
        for row in rows:
            assert t[row - 1] == t[row + 1]
            assert (v[row - 1], v[row + 1]) == (-1.0, 1.0)
        assert largest_step(v) < 0.1
        assert np.isnan(t[rows]).all()
        assert ax.get_ylabel() == "velocity q'[0]"

    def test_impacts_inside_the_period(self):
        ax = plot.time_history(Shuttle(), quantity="velocity", t_span=(-0.5, 2.25))
        t, v = curve(ax)
        assert (t[0], t[-1]) == (-0.5, 2.25)
        (rows,) = np.nonzero(np.isnan(v))
        np.testing.assert_array_equal(t[rows - 1], [0.0, 1.0, 2.0])
        np.testing.assert_array_equal(v[rows - 1], [2.0, -2.0, 2.0])
        np.testing.assert_array_equal(v[rows + 1], [-2.0, 2.0, -2.0])

    def test_a_coordinate_without_jumps_is_one_line(self):
        ax = plot.time_history(BouncingOrbit(), along=1, quantity="velocity", periods=3)
        assert not np.isnan(curve(ax)[1]).any()

    def test_jumps_are_thin_and_dashed(self):
        ax = plot.time_history(BouncingOrbit(), quantity="velocity", periods=2, jumps=True, impacts=False)
        main, jumps = ax.lines
        assert jumps.get_linestyle() == "--"
        assert jumps.get_linewidth() < main.get_linewidth()
        assert jumps.get_color() == main.get_color()
        np.testing.assert_array_equal(curve(ax, 1)[0], [2.0, 2.0, np.nan, 4.0, 4.0, np.nan])
        np.testing.assert_array_equal(curve(ax, 1)[1], [-1.0, 1.0, np.nan, -1.0, 1.0, np.nan])

    @pytest.mark.parametrize("periods", [0.25, 1.0, 2.5, 3])
    def test_number_of_periods(self, periods):
        t, _ = curve(plot.time_history(BouncingOrbit(), periods=periods))
        assert t[-1] == pytest.approx(2.0 * periods)

    @pytest.mark.parametrize("points", [50, 800])
    def test_number_of_points(self, points):
        t, _ = curve(plot.time_history(BouncingOrbit(), points=points))
        assert np.max(np.diff(t)) == pytest.approx(1.0 / points)

    def test_walls_where_the_gap_is_zero(self):
        ax = plot.time_history(BouncingOrbit(), along=1)
        walls = labelled(ax, "stop")
        assert [wall.get_label() for wall in walls] == ["stop 1", "stop 2"]
        np.testing.assert_allclose([wall.get_ydata() for wall in walls], [[-1.2, -1.2], [1.5, 1.5]])
        assert ax.get_ylim()[0] < -1.2
        assert ax.get_ylim()[1] > 1.5
        assert not labelled(plot.time_history(BouncingOrbit(), along=1, walls=False), "stop")
        assert not labelled(plot.time_history(BouncingOrbit(), quantity="velocity"), "stop")

    def test_walls_of_stops_on_a_coordinate_by_its_index(self):
        orbit = BouncingOrbit()
        orbit.scene.stops = tuple(
            SimpleNamespace(normal=normal, clearance=0.25, side=side)
            for normal, side in ((0, "upper"), (1, "upper"), (1, "lower"))
        )
        walls = labelled(plot.time_history(orbit, along=1), "stop")
        assert [wall.get_label() for wall in walls] == ["stop 1", "stop 2"]
        np.testing.assert_allclose([wall.get_ydata() for wall in walls], [[0.25, 0.25], [-0.25, -0.25]])

    def test_trajectory_has_its_own_rows_and_is_smooth_between_them(self):
        trajectory = BouncingTrajectory()
        t, v = curve(plot.time_history(trajectory, quantity="velocity"))
        assert set(trajectory.t) <= set(t[~np.isnan(t)])
        (rows,) = np.nonzero(np.isnan(v))
        np.testing.assert_array_equal(t[rows - 1], [2.0, 4.0, 6.0])
        assert largest_step(v) < 0.11

    @pytest.mark.parametrize("t_eval", [[0.0, 6.5], np.arange(0.0, 7.0, 0.3)])
    @pytest.mark.parametrize("coordinate", [0, 1])
    def test_few_rows_are_drawn_as_the_smooth_motion(self, t_eval, coordinate):
        trajectory = BouncingTrajectory(t_eval=t_eval)
        t, q = curve(plot.time_history(trajectory, along=coordinate))
        np.testing.assert_allclose(q, trajectory.position(t)[:, coordinate], atol=1e-12)
        middle = 0.5 * (t[1:] + t[:-1])
        off = np.abs(trajectory.position(middle)[:, coordinate] - 0.5 * (q[1:] + q[:-1]))
        assert np.max(off) < 2e-3 * np.ptp(q)

    def test_rows_two_periods_apart_hide_no_wave(self):
        trajectory = BouncingTrajectory(t_eval=[0.0, *np.arange(0.5, 41.0, 4.0)])  # two of q[1], after the first
        trajectory.impacts = impacts_at([])
        _, q = curve(plot.time_history(trajectory, along=1))
        assert np.ptp(q) == pytest.approx(2.0, abs=1e-2)
        assert largest_step(q) < 0.2

    def test_a_coordinate_at_rest_needs_no_more_rows(self):
        trajectory = BouncingTrajectory()
        trajectory.position = lambda t: np.full((len(np.atleast_1d(t)), 2), 0.1)
        trajectory.velocity = lambda t, side="after": np.zeros((len(np.atleast_1d(t)), 2))
        trajectory.q, trajectory.v = trajectory.position(trajectory.t), trajectory.velocity(trajectory.t)
        assert len(curve(plot.time_history(trajectory))[0]) <= 2 * len(trajectory.t)

    def test_rows_have_an_end(self):
        trajectory = BouncingTrajectory()
        noise = np.random.default_rng(1)
        trajectory.position = lambda t: noise.normal(size=(len(t), 2))
        trajectory.velocity = lambda t, side="after": noise.normal(size=(len(t), 2))
        assert len(curve(plot.time_history(trajectory))[0]) <= 100_000

    @pytest.mark.parametrize("t_eval", [np.arange(0.0, 7.0, 0.3), np.arange(0.0, 7.0, 0.5), [0.0, 6.5]])
    def test_missing_sides_are_added_where_the_motion_was_kept(self, t_eval):
        t, v = curve(plot.time_history(BouncingTrajectory(t_eval=t_eval), quantity="velocity"))
        (rows,) = np.nonzero(np.isnan(v))
        np.testing.assert_array_equal(t[rows - 1], [2.0, 4.0, 6.0])
        np.testing.assert_array_equal(t[rows + 1], [2.0, 4.0, 6.0])
        np.testing.assert_array_equal(v[rows - 1], [-1.0, -1.0, -1.0])
        np.testing.assert_array_equal(v[rows + 1], [1.0, 1.0, 1.0])

    @pytest.mark.parametrize("step", [0.3, 0.5])
    def test_without_the_motion_the_line_is_broken_at_impacts(self, step):
        trajectory = BouncingTrajectory(t_eval=np.arange(0.0, 7.0, step), keeps_motion=False)
        ax = plot.time_history(trajectory, quantity="velocity", jumps=True)
        t, v = curve(ax)
        assert np.count_nonzero(np.isnan(v)) == 3
        assert np.nanmax(np.diff(v)) < 0.0  # it falls all the time, but for the jumps
        assert len(curve(ax, 1)[0]) == 0
        np.testing.assert_array_equal(t[~np.isnan(t)], trajectory.t)

    def test_equal_velocities_on_two_flights_are_not_joined(self):
        trajectory = BouncingTrajectory(t_eval=[1.0, 3.0, 5.0], keeps_motion=False)  # v = 0 at each
        _, v = curve(plot.time_history(trajectory, quantity="velocity"))
        np.testing.assert_array_equal(v, [0.0, np.nan, 0.0, np.nan, 0.0])

    def test_a_row_that_misses_its_impact_by_rounding(self):
        trajectory = BouncingTrajectory(t_eval=np.arange(0.0, 7.0, 0.5))
        trajectory.impacts["time"] = np.nextafter(trajectory.impacts["time"], 0.0)
        t, v = curve(plot.time_history(trajectory, quantity="velocity"))
        np.testing.assert_array_equal(t[np.flatnonzero(np.isnan(t)) - 1], [2.0, 4.0, 6.0])
        assert largest_step(v) < 0.51

    def test_window_of_a_trajectory_has_its_ends(self):
        t, v = curve(plot.time_history(BouncingTrajectory(), quantity="velocity", t_span=(1.234, 4.0)))
        assert (t[0], t[-1]) == (1.234, 4.0)
        assert v[0] == pytest.approx(-0.234)
        assert (v[-3], v[-1]) == (-1.0, 1.0)
        t, _ = curve(plot.time_history(BouncingTrajectory(), t_span=(-1.0, 99.0)))
        assert (t[0], t[-1]) == (0.0, 7.0)

    def test_several_impacts_between_two_rows(self):
        t, q = curve(plot.time_history(BouncingTrajectory(t_eval=[0.5, 6.5])))
        (hits,) = np.nonzero(np.isin(t, [2.0, 4.0, 6.0]))
        np.testing.assert_array_equal(t[hits], [2.0, 2.0, 4.0, 4.0, 6.0, 6.0])
        np.testing.assert_array_equal(q[hits], 0.0)

    def test_curves_differ_in_line_style(self):
        ax = plot.time_history(BouncingOrbit(), along=0)
        plot.time_history(BouncingOrbit(), ax, along=1)
        plot.time_history(BouncingTrajectory(), ax)
        styles = [line.get_linestyle() for line in labelled(ax, "q[")]
        assert styles == ["-", "--", "-."]
        assert ax.get_ylabel() == "position q"

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ({"quantity": "energy"}, "quantity must be 'position' or 'velocity', got 'energy'"),
            ({"periods": 0}, "periods must be finite and above 0, got 0"),
            ({"periods": np.inf}, "periods must be finite and above 0"),
            ({"periods": 1, "t_span": (0, 1)}, "periods must be None where t_span is given"),
            ({"t_span": (1, 1)}, r"t_span must be a finite \(start, end\)"),
            ({"t_span": (0, np.nan)}, r"t_span must be a finite \(start, end\)"),
            ({"points": 1}, "points must be at least 2, got 1"),
        ],
    )
    def test_refuses_bad_options(self, options, message):
        with pytest.raises(ValueError, match=message):
            plot.time_history(BouncingOrbit(), **options)
        assert plt.get_fignums() == []

    @pytest.mark.parametrize(
        ("trajectory", "options", "message"),
        [
            (BouncingTrajectory(), {"periods": 1}, "periods must be None"),
            (BouncingTrajectory(), {"t_span": (8, 9)}, "t_span must meet the trajectory's times, 0 to 7"),
            (BouncingTrajectory(t_eval=[]), {}, "trajectory must have rows to draw"),
        ],
    )
    def test_refuses_bad_options_of_a_trajectory(self, trajectory, options, message):
        with pytest.raises(ValueError, match=message):
            plot.time_history(trajectory, **options)
        assert plt.get_fignums() == []


class TestPhasePortrait:
    def test_orbit_is_a_closed_curve_with_its_jump(self):
        ax = plot.phase_portrait(BouncingOrbit())
        q, v = curve(ax)
        np.testing.assert_allclose(q, 0.5 - v**2 / 2, atol=1e-12)
        assert largest_step(v) < 0.01
        (jump,) = labelled(ax, "_jumps")
        assert jump.get_linestyle() == "--"
        np.testing.assert_allclose(jump.get_xdata(), [0.0, 0.0, np.nan], atol=1e-15)
        np.testing.assert_array_equal(jump.get_ydata(), [-1.0, 1.0, np.nan])
        assert contains(ax, q[~np.isnan(q)], v[~np.isnan(v)])
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("position q[0]", "velocity q'[0]")
        assert not labelled(plot.phase_portrait(BouncingOrbit(), jumps=False), "_jumps")

    def test_every_impact_of_a_period_has_one_jump(self):
        (jump,) = labelled(plot.phase_portrait(Shuttle()), "_jumps")
        np.testing.assert_array_equal(jump.get_xdata(), [-1.0, -1.0, np.nan, 1.0, 1.0, np.nan])
        np.testing.assert_array_equal(jump.get_ydata(), [-2.0, 2.0, np.nan, 2.0, -2.0, np.nan])

    def test_walls_are_vertical_lines(self):
        ax = plot.phase_portrait(Shuttle())
        walls = labelled(ax, "stop")
        np.testing.assert_allclose([wall.get_xdata() for wall in walls], [[1.0, 1.0], [-1.0, -1.0]])
        assert ax.get_xlim()[0] < -1.0
        assert ax.get_xlim()[1] > 1.0
        # ticks stand on the solid side: right of the upper stop, left of the lower one
        angles = [wall.get_path_effects()[1]._angle for wall in walls]
        assert angles == [-45.0, 45.0]
        assert not labelled(plot.phase_portrait(Shuttle(), walls=False), "stop")

    def test_a_stop_of_another_coordinate_or_of_several_has_no_wall(self):
        ax = plot.phase_portrait(BouncingOrbit(), along=0)
        assert [wall.get_label() for wall in labelled(ax, "stop")] == ["stop 0"]

    def test_a_wall_is_drawn_once(self):
        ax = plot.phase_portrait(BouncingOrbit())
        plot.phase_portrait(BouncingTrajectory(), ax)
        assert len(labelled(ax, "stop")) == 1
        moved = BouncingOrbit()
        moved.scene.stops = (stop([1.0, 0.0], 0.25, "lower"),)
        plot.phase_portrait(moved, ax)
        np.testing.assert_allclose(labelled(ax, "stop")[1].get_xdata(), -0.25)

    def test_poincare_points_of_an_orbit(self):
        (points,) = labelled(plot.phase_portrait(BouncingOrbit()), "Poincaré")
        np.testing.assert_allclose(points.get_xdata(), [0.0, 0.5])
        np.testing.assert_allclose(points.get_ydata(), [1.0, 0.0])  # after the impact at 0
        assert points.get_linestyle() == "None"
        assert not labelled(plot.phase_portrait(BouncingOrbit(), section=False), "Poincaré")

    def test_poincare_points_of_a_trajectory(self):
        (points,) = labelled(plot.phase_portrait(BouncingTrajectory(), t_span=(2.5, 6.0)), "Poincaré")
        assert len(points.get_xdata()) == 4

    def test_an_unforced_motion_has_no_poincare_points(self):
        assert not labelled(plot.phase_portrait(Shuttle()), "Poincaré")

    def test_trajectory_is_never_joined_across_a_jump(self):
        for trajectory in (BouncingTrajectory(), BouncingTrajectory(t_eval=np.arange(0.0, 7.0, 0.1))):
            ax = plot.phase_portrait(trajectory)
            q, v = curve(ax)
            assert largest_step(v) < 0.11
            assert np.count_nonzero(np.isnan(q)) == 3
            assert len(labelled(ax, "_jumps")[0].get_xdata()) == 9

    def test_legend_names_each_thing_once(self):
        ax = plot.phase_portrait(BouncingOrbit())
        plot.phase_portrait(BouncingTrajectory(), ax)
        plot.phase_portrait(BouncingTrajectory(), ax, label="again")
        names = [text.get_text() for text in ax.legend().get_texts()]
        assert sorted(names) == sorted(
            ["orbit", "trajectory", "again", "impacts", "stop 0", "Poincaré points", "Poincaré points, again"]
        )
        styles = [line.get_linestyle() for line in ax.lines if line.get_label() in ("orbit", "trajectory", "again")]
        assert styles == ["-", "--", "-."]


class TestPoincareSection:
    def test_orbit_has_a_point_a_forcing_period(self):
        ax = plot.poincare_section(BouncingOrbit(), walls=True)
        q, v = curve(ax)
        np.testing.assert_allclose(q, [0.0, 0.5])
        np.testing.assert_allclose(v, [1.0, 0.0])
        assert contains(ax, q, v)
        assert len(labelled(ax, "stop")) == 1

    @pytest.mark.parametrize(("end", "count"), [(7.0, 8), (6.9, 7), (0.5, 1)])
    def test_trajectory_has_a_point_a_forcing_period(self, end, count):
        q, v = curve(plot.poincare_section(BouncingTrajectory(end=end)))
        times = np.arange(count)
        np.testing.assert_allclose(q, np.where(times % 2, 0.5, 0.0))
        np.testing.assert_allclose(v, np.where(times % 2, 0.0, 1.0))

    def test_transient_is_left_out(self):
        assert len(curve(plot.poincare_section(BouncingTrajectory(), t_span=(3.5, 99.0)))[0]) == 4

    def test_a_point_at_an_impact_is_after_it_in_spite_of_rounding(self):
        third = 2.0 / 3.0  # three forcing periods a bounce, each point a little before its impact
        trajectory = BouncingTrajectory(end=40.5, forcing_period=third * (1.0 - 1e-12))
        _, v = curve(plot.poincare_section(trajectory))
        np.testing.assert_allclose(v[::3], 1.0, atol=1e-12)

    def test_rows_serve_where_the_motion_was_not_kept(self):
        trajectory = BouncingTrajectory(t_eval=np.arange(0.0, 7.1, 0.5), keeps_motion=False)
        assert len(curve(plot.poincare_section(trajectory))[0]) == 8
        drawn = BouncingTrajectory(keeps_motion=False)  # both sides of each impact are among its rows
        _, v = curve(plot.poincare_section(drawn))
        np.testing.assert_allclose(v, [1.0, 0.0] * 4, atol=1e-12)

    def test_no_points_is_an_error_with_a_remedy(self):
        trajectory = BouncingTrajectory(t_eval=[0.3, 0.6], keeps_motion=False)
        with pytest.raises(ValueError, match=r"keep='motion'"):
            plot.poincare_section(trajectory)
        assert len(labelled(plot.phase_portrait(trajectory), "Poincaré")[0].get_xdata()) == 0

    def test_an_unforced_motion_is_refused(self):
        with pytest.raises(ValueError, match=r"motion must be forced .*scene.period = None"):
            plot.poincare_section(Shuttle())

    def test_sections_differ_in_marker(self):
        ax = plot.poincare_section(BouncingOrbit())
        plot.poincare_section(BouncingTrajectory(), ax)
        assert ax.lines[0].get_marker() != ax.lines[1].get_marker()
