"""The artists each figure is made of, for motions with a closed form; no pixels."""

import ast
import importlib
import sys
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.patches import Circle

matplotlib.use("Agg")

import vibroimpact.plot as plot
from vibroimpact.plot.existence import CATEGORIES

IMPACT = np.dtype(
    [
        ("time", float),
        ("stop", int),
        ("speed_before", float),
        ("speed_after", float),
        ("impulse", float),
        ("phase", float),
    ]
)


def impacts_at(times, stop=0):
    """Impacts with the times that matter here."""
    impacts = np.zeros(len(times), IMPACT)
    impacts["time"] = times
    impacts["stop"] = stop
    return impacts


def stop(normal, clearance, side="upper"):
    return SimpleNamespace(normal=np.asarray(normal, float), clearance=clearance, restitution=1.0, side=side)


# The second coordinate turns with the bounce of the first; stop 3 mixes both, stop 4 has no normal.
STOPS = (
    stop([2.0, 0.0], 0.0, "lower"),
    stop([0.0, -0.5], 0.6),
    stop([0.0, 0.5], 0.75),
    stop([1.0, 1.0], 9.0),
    SimpleNamespace(bob=1, position=0.3),
)


class Bounce:
    """A ball thrown up at speed 1 under gravity 1: q0 = s - s^2/2, back at s = 2; q1 = cos(pi t); forcing period 1."""

    def __init__(self, forcing_period=1.0):
        self.scene = SimpleNamespace(n_dof=2, period=forcing_period, stops=STOPS)

    def position(self, t):
        t = np.asarray(t, float)
        s = t % 2.0
        return np.column_stack([s - s * s / 2, np.cos(np.pi * t)])

    def velocity(self, t, side="after"):
        t = np.asarray(t, float)
        s = t % 2.0
        if side == "before":
            s = np.where(s == 0.0, 2.0, s)
        return np.column_stack([1.0 - s, -np.pi * np.sin(np.pi * t)])


class BouncingOrbit(Bounce):
    period = 2.0
    n_periods = 2
    impacts = impacts_at([0.0])


class BouncingTrajectory(Bounce):
    """The same from 0 to `end`, by the rows for drawing or at `t_eval`."""

    def __init__(self, end=7.0, t_eval=None, keeps_motion=True, forcing_period=1.0):
        super().__init__(forcing_period)
        self.keeps_motion = True
        hits = np.arange(2.0, end, 2.0)
        if t_eval is None:
            flights = [np.linspace(*ends, 21) for ends in pairwise([0.0, *hits, end])]
            self.t = np.concatenate(flights)
            self.v = np.vstack([np.vstack([self.velocity(t[:-1]), self.velocity(t[-1:], side="before")]) for t in flights])
        else:
            self.t = np.asarray(t_eval, float)
            self.v = self.velocity(self.t)
        self.q = self.position(self.t)
        self.impacts = impacts_at(hits)
        self.keeps_motion = keeps_motion

    def position(self, t):
        self._check()
        return super().position(t)

    def velocity(self, t, side="after"):
        self._check()
        return super().velocity(t, side)

    def _check(self):
        if not self.keeps_motion:
            raise ValueError("keep must be 'motion'")


class LedgerOfABall:
    """A ball dropped from height 1/2 under gravity 1 on a floor with restitution 0: all its energy is lost at t = 1."""

    t = np.array([0.0, 0.5, 1.0, 1.0, 2.0])
    impacts = impacts_at([1.0])
    energy = SimpleNamespace(
        kinetic=np.array([0.0, 0.125, 0.5, 0.0, 0.0]),
        potential=np.array([0.5, 0.375, 0.0, 0.0, 0.0]),
        forcing_work=np.zeros(5),
        damping_loss=np.zeros(5),
        impact_loss=np.array([0.0, 0.0, 0.0, 0.5, 0.5]),
    )


class Shuttle:
    """A free particle between walls at 1 and -1, period 2: hits stop 0 at t = 0 and stop 1 at t = 1."""

    period = 2.0
    n_periods = 1
    impacts = impacts_at([0.0, 1.0], stop=[0, 1])
    scene = SimpleNamespace(n_dof=1, period=None, stops=(stop([1.0], 1.0), stop([1.0], 1.0, "lower")))

    def position(self, t):
        s = np.asarray(t, float) % 2.0
        return np.where(s < 1.0, 1.0 - 2.0 * s, 2.0 * s - 3.0)[:, None]

    def velocity(self, t, side="after"):
        s = np.asarray(t, float) % 2.0
        falls = s < 1.0 if side == "after" else (s > 0.0) & (s <= 1.0)
        return np.where(falls, -2.0, 2.0)[:, None]


def modes(n=3):
    chain = 2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    squares, shapes = np.linalg.eigh(chain)
    return SimpleNamespace(natural_frequencies=np.sqrt(squares), shapes=shapes, damping_ratios=np.full(n, 0.05))


def stable_orbit(orders, floquet_multipliers="first", reason="all inside the unit circle"):
    if isinstance(floquet_multipliers, str):
        floquet_multipliers = np.asarray(next(iter(orders.values())))
    return SimpleNamespace(floquet_multipliers=floquet_multipliers, stability=SimpleNamespace(orders=orders, reason=reason))


@dataclass
class Map:
    """One cell of each category in the first row, the second row all without an orbit."""

    x: object = field(default_factory=lambda: np.array([1.0, 2.0, 4.0, 8.0]))
    y: object = field(default_factory=lambda: np.array([0.1, 0.3]))
    x_name: str | None = "frequency"
    y_name: str | None = "clearance[1]"
    n_orbits: object = field(default_factory=lambda: np.array([[0, 1, 2, 1], [0, 0, 0, 0]]))
    is_admissible: object = field(default_factory=lambda: np.array([[0, 0, 1, 1], [0, 0, 0, 0]], bool))
    is_stable: object = field(default_factory=lambda: np.array([[0, 1, 0, 1], [0, 0, 0, 0]], bool))
    multiplier: object = field(default_factory=lambda: np.array([[np.nan, 0.3, 1.7, 0.4], [np.nan] * 4]))


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


def curve(ax, index=0):
    """The data of one line."""
    return np.asarray(ax.lines[index].get_xdata(), float), np.asarray(ax.lines[index].get_ydata(), float)


def labelled(ax, start):
    return [line for line in ax.lines if str(line.get_label()).startswith(start)]


def largest_step(values):
    return np.nanmax(np.abs(np.diff(values)))


def contains(ax, x, y):
    (x_low, x_high), (y_low, y_high) = sorted(ax.get_xlim()), sorted(ax.get_ylim())
    return bool(np.all((x >= x_low) & (x <= x_high) & (y >= y_low) & (y <= y_high)))


CALLS = {
    "time_history": lambda **k: plot.time_history(BouncingOrbit(), **k),
    "phase_portrait": lambda **k: plot.phase_portrait(BouncingOrbit(), **k),
    "poincare_section": lambda **k: plot.poincare_section(BouncingOrbit(), **k),
    "mode_shapes": lambda **k: plot.mode_shapes(modes(), **k),
    "multipliers": lambda **k: plot.multipliers(stable_orbit({(0,): [0.5, -0.2]}), **k),
    "existence_map": lambda **k: plot.existence_map(Map(), **k),
    "energy": lambda **k: plot.energy(LedgerOfABall(), **k),
    "impact_speeds": lambda **k: plot.impact_speeds(BouncingOrbit(), **k),
}
DATA = {"mode_shapes": modes(), "multipliers": stable_orbit({(0,): [0.5]}), "existence_map": Map(), "energy": LedgerOfABall()}


class TestEveryFigure:
    def test_every_public_name_is_covered_here(self):
        assert sorted([*CALLS, "animate"]) == sorted(plot.__all__)  # the animation has tests of its own

    @pytest.mark.parametrize("name", CALLS)
    def test_draws_on_the_axes_given(self, name):
        _, (ax, other) = plt.subplots(1, 2)
        assert CALLS[name](ax=ax) is ax
        assert ax.has_data()
        assert not other.has_data()

    @pytest.mark.parametrize("name", CALLS)
    def test_makes_a_figure_where_none_is_given(self, name):
        assert plt.get_fignums() == []
        ax = CALLS[name]()
        assert isinstance(ax, Axes)
        assert plt.get_fignums() == [1]
        assert ax.get_xlabel()
        assert ax.get_ylabel()
        ax.figure.canvas.draw()

    @pytest.mark.parametrize("name", CALLS)
    def test_axes_are_the_second_argument(self, name):
        _, ax = plt.subplots()
        assert getattr(plot, name)(DATA.get(name, BouncingOrbit()), ax) is ax

    @pytest.mark.parametrize("name", CALLS)
    def test_refuses_what_is_not_axes(self, name):
        with pytest.raises(ValueError, match=r"ax must be the Axes of a figure or None, got 1"):
            CALLS[name](ax=1)
        assert plt.get_fignums() == []

    @pytest.mark.parametrize("name", CALLS)
    def test_keeps_a_label_that_is_there(self, name):
        _, ax = plt.subplots()
        ax.set_xlabel("mine")
        CALLS[name](ax=ax)
        assert ax.get_xlabel() == "mine"

    @pytest.mark.parametrize("name", CALLS)
    def test_refuses_data_of_another_kind(self, name):
        with pytest.raises(ValueError, match=r"must be .*got list"):
            getattr(plot, name)([BouncingOrbit()])
        assert plt.get_fignums() == []

    @pytest.mark.parametrize("name", ["time_history", "phase_portrait", "poincare_section"])
    @pytest.mark.parametrize("coordinate", [-1, 2, 0.5, "0", None])
    def test_refuses_a_coordinate_that_is_not_there(self, name, coordinate):
        with pytest.raises(ValueError, match=rf"coordinate must be an index from 0 to 1, got {coordinate!r}"):
            CALLS[name](coordinate=coordinate)
        assert plt.get_fignums() == []

    @pytest.mark.parametrize("name", ["time_history", "phase_portrait", "poincare_section"])
    def test_takes_numpy_integers(self, name):
        assert "[1]" in CALLS[name](coordinate=np.int32(1)).get_ylabel()

    @pytest.mark.parametrize(
        "name", ["time_history", "phase_portrait", "poincare_section", "mode_shapes", "energy", "impact_speeds"]
    )
    def test_passes_options_to_the_line_under_any_alias(self, name):
        ax = CALLS[name](lw=3.5, c="red", ls=":", marker="d")
        drawn = next(line for line in ax.lines if line.get_linewidth() == 3.5)
        assert drawn.get_color() == "red"
        assert drawn.get_linestyle() == ":"
        assert drawn.get_marker() == "d"


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
        ax = plot.time_history(BouncingOrbit(), coordinate=1, quantity="velocity", periods=3)
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
        ax = plot.time_history(BouncingOrbit(), coordinate=1)
        walls = labelled(ax, "stop")
        assert [wall.get_label() for wall in walls] == ["stop 1", "stop 2"]
        np.testing.assert_allclose([wall.get_ydata() for wall in walls], [[-1.2, -1.2], [1.5, 1.5]])
        assert ax.get_ylim()[0] < -1.2
        assert ax.get_ylim()[1] > 1.5
        assert not labelled(plot.time_history(BouncingOrbit(), coordinate=1, walls=False), "stop")
        assert not labelled(plot.time_history(BouncingOrbit(), quantity="velocity"), "stop")

    def test_walls_of_stops_on_a_coordinate_by_its_index(self):
        orbit = BouncingOrbit()
        orbit.scene.stops = tuple(
            SimpleNamespace(normal=normal, clearance=0.25, side=side)
            for normal, side in ((0, "upper"), (1, "upper"), (1, "lower"))
        )
        walls = labelled(plot.time_history(orbit, coordinate=1), "stop")
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
        t, q = curve(plot.time_history(trajectory, coordinate=coordinate))
        np.testing.assert_allclose(q, trajectory.position(t)[:, coordinate], atol=1e-12)
        middle = 0.5 * (t[1:] + t[:-1])
        off = np.abs(trajectory.position(middle)[:, coordinate] - 0.5 * (q[1:] + q[:-1]))
        assert np.max(off) < 2e-3 * np.ptp(q)

    def test_rows_two_periods_apart_hide_no_wave(self):
        trajectory = BouncingTrajectory(t_eval=[0.0, *np.arange(0.5, 41.0, 4.0)])  # two of q[1], after the first
        trajectory.impacts = impacts_at([])
        _, q = curve(plot.time_history(trajectory, coordinate=1))
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
        ax = plot.time_history(BouncingOrbit(), coordinate=0)
        plot.time_history(BouncingOrbit(), ax, coordinate=1)
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
        ax = plot.phase_portrait(BouncingOrbit(), coordinate=0)
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
        assert sorted(names) == sorted(["orbit", "trajectory", "again", "stop 0", "Poincaré points", "Poincaré points, again"])
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


class TestModeShapes:
    def test_one_line_a_mode(self):
        data = modes(4)
        ax = plot.mode_shapes(data)
        lines = labelled(ax, "mode")
        assert len(lines) == 4
        for j, line in enumerate(lines):
            np.testing.assert_array_equal(line.get_xdata(), np.arange(4))
            np.testing.assert_array_equal(line.get_ydata(), data.shapes[:, j])
        assert len({line.get_linestyle() for line in lines}) == 4
        assert len({line.get_marker() for line in lines}) == 4
        names = [text.get_text() for text in ax.get_legend().get_texts()]
        assert names[0] == f"mode 0: frequency {data.natural_frequencies[0]:.4g},\ndamping 0.05"

    def test_six_of_many_or_those_asked_for(self):
        assert len(labelled(plot.mode_shapes(modes(60)), "mode")) == 6
        lines = labelled(plot.mode_shapes(modes(60), indices=[59, np.int64(2)]), "mode")
        assert [line.get_label().split(":")[0] for line in lines] == ["mode 59", "mode 2"]

    def test_a_rigid_body_has_no_damping_ratio(self):
        data = SimpleNamespace(natural_frequencies=[0.0], shapes=[[1.0]], damping_ratios=[np.nan])
        (line,) = labelled(plot.mode_shapes(data), "mode")
        assert line.get_label() == "mode 0: frequency 0"

    def test_label_is_put_before_the_names(self):
        ax = plot.mode_shapes(modes(2), label="pinned")
        plot.mode_shapes(modes(2), ax, label="free")
        assert len(labelled(ax, "pinned, mode")) == len(labelled(ax, "free, mode")) == 2
        assert len(labelled(ax, "_zero")) == 1

    @pytest.mark.parametrize("index", [-1, 3, 0.5])
    def test_refuses_a_mode_that_is_not_there(self, index):
        with pytest.raises(ValueError, match=rf"indices must be from 0 to 2, got {index}"):
            plot.mode_shapes(modes(), indices=[0, index])
        assert plt.get_fignums() == []


class TestMultipliers:
    def test_unit_circle_in_one_scale(self):
        ax = plot.multipliers(stable_orbit({(0,): [0.5, -0.2]}))
        (circle,) = [patch for patch in ax.patches if isinstance(patch, Circle)]
        assert circle.center == (0.0, 0.0)
        assert circle.radius == 1.0
        assert ax.get_aspect() == 1.0
        assert contains(ax, np.array([-1.0, 1.0]), np.array([-1.0, 1.0]))

    def test_points_are_the_multipliers(self):
        values = np.array([0.3 + 0.4j, 0.3 - 0.4j, -2.5, 0.0])
        ax = plot.multipliers(stable_orbit({(0,): values}))
        (points,) = ax.collections
        np.testing.assert_array_equal(points.get_offsets(), np.column_stack([values.real, values.imag]))
        assert contains(ax, values.real, values.imag)
        width, height = np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())
        assert width == pytest.approx(height)
        assert points.get_label() == "multipliers:\nlargest modulus 2.5"

    def test_every_order_of_impacts_has_its_marker(self):
        ax = plot.multipliers(stable_orbit({(0, 1): [0.793, -0.1], (1, 0): [1.775, -0.1]}))
        first, second = ax.collections
        assert first.get_paths()[0].vertices.shape != second.get_paths()[0].vertices.shape
        names = [text.get_text() for text in ax.get_legend().get_texts()]
        assert names == ["stops 0 → 1:\nlargest modulus 0.793", "stops 1 → 0:\nlargest modulus 1.775"]

    def test_orders_of_several_instants(self):
        ax = plot.multipliers(stable_orbit({((0, 1), 2): [0.1], ((1, 0), 2): [0.2]}))
        assert ax.collections[0].get_label().startswith("stops (0 → 1) → 2:")

    def test_orbit_without_orders(self):
        orbit = stable_orbit({}, floquet_multipliers=np.array([0.1, 0.2]))
        assert len(plot.multipliers(orbit).collections[0].get_offsets()) == 2
        orbit.stability = None
        assert len(plot.multipliers(orbit).collections[0].get_offsets()) == 2

    def test_says_why_there_are_none(self):
        ax = plot.multipliers(stable_orbit({}, floquet_multipliers=None, reason="stop 1 is grazed at 3.2"))
        (text,) = ax.texts
        assert text.get_text().replace("\n", " ") == "multipliers undefined: stop 1 is grazed at 3.2"
        assert len(ax.collections) == 0
        assert ax.get_legend() is None

    def test_orders_without_multipliers_are_left_out(self):
        ax = plot.multipliers(stable_orbit({(0, 1): [0.5], (1, 0): None}, floquet_multipliers=None))
        assert len(ax.collections) == 1
        assert len(ax.texts) == 1

    @pytest.mark.parametrize("size", [(4.0, 4.0), (9.0, 3.0), (3.0, 6.0)])
    def test_legend_on_given_axes_stands_above_the_circle_and_the_points(self, size):
        fig, ax = plt.subplots(figsize=size)
        plot.multipliers(stable_orbit({(0, 1): [0.5 + 1.4j, 0.5 - 1.4j], (1, 0): [0.4, 0.1]}), ax)
        fig.canvas.draw()
        lowest = ax.transData.inverted().transform(ax.get_legend().get_window_extent())[0, 1]
        assert lowest > 1.4
        assert ax.get_legend().get_frame().get_alpha() == 1.0

    def test_options_go_to_the_markers(self):
        (points,) = plot.multipliers(stable_orbit({(0,): [0.5]}), color="red", s=9, lw=3.0, label="here").collections
        np.testing.assert_array_equal(points.get_facecolor()[0][:3], [1.0, 0.0, 0.0])
        assert points.get_sizes() == [9]
        assert points.get_linewidth() == [3.0]
        assert points.get_label().startswith("here, multipliers")


def lightness(colour):
    """The lightness L* of CIE 1976."""
    channels = np.asarray(to_rgb(colour))
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return 116.0 * np.cbrt(linear @ [0.2126, 0.7152, 0.0722]) - 16.0


def shown_categories(ax):
    """The category name of each cell."""
    mesh = ax.collections[0]
    colours = mesh.to_rgba(mesh.get_array())[..., :3]
    names = {tuple(np.round(to_rgb(colour), 9)): name for name, colour in CATEGORIES}
    return [[names[tuple(np.round(colour, 9))] for colour in row] for row in colours]


class TestExistenceMap:
    def test_categories(self):
        ax = plot.existence_map(Map())
        first = ["no orbit", "inadmissible", "admissible,\nunstable", "admissible,\nstable"]
        assert shown_categories(ax) == [first, ["no orbit"] * 4]
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("frequency", "clearance[1]")

    def test_colours_darken_evenly_enough_for_grey(self):
        steps = np.diff([lightness(colour) for _, colour in CATEGORIES])
        assert np.all(steps < -10.0)

    def test_cells_lie_around_the_values(self):
        ax = plot.existence_map(Map())
        corners = ax.collections[0].get_coordinates()
        np.testing.assert_allclose(corners[0, :, 0], [0.5, 1.5, 3.0, 6.0, 10.0])
        np.testing.assert_allclose(corners[:, 0, 1], [0.0, 0.2, 0.4])
        assert contains(ax, corners[..., 0], corners[..., 1])

    def test_cells_of_a_logarithmic_axis(self):
        _, ax = plt.subplots()
        ax.set_xscale("log")
        plot.existence_map(Map(), ax)
        edges = ax.collections[0].get_coordinates()[0, :, 0]
        np.testing.assert_allclose(edges, 2.0 ** np.array([-0.5, 0.5, 1.5, 2.5, 3.5]))

    @pytest.mark.parametrize("value", [2.0, 0.0, -1.0])
    def test_one_value(self, value):
        one = Map([value], [0.2], None, None, [[1]], [[True]], [[True]], [[0.5]])
        ax = plot.existence_map(one)
        assert shown_categories(ax) == [["admissible,\nstable"]]
        low, high = ax.collections[0].get_coordinates()[0, :, 0]
        assert low < value < high
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("x", "y")

    def test_values_in_any_order(self):
        whole = Map()
        turned = Map(
            x=whole.x[::-1],
            n_orbits=whole.n_orbits[:, ::-1],
            is_admissible=whole.is_admissible[:, ::-1],
            is_stable=whole.is_stable[:, ::-1],
            multiplier=whole.multiplier[:, ::-1],
        )
        assert shown_categories(plot.existence_map(turned)) == shown_categories(plot.existence_map(whole))

    def test_bar_names_the_colours(self):
        ax = plot.existence_map(Map())
        (bar,) = [other for other in ax.figure.axes if other is not ax]
        names = [text.get_text() for text in bar.get_yticklabels()]
        assert names == ["no orbit", "inadmissible", "admissible,\nunstable", "admissible,\nstable"]
        assert len(plot.existence_map(Map(), colourbar=False).figure.axes) == 1

    def test_undefined_stability_is_not_called_unstable(self):
        undecided = Map()
        undecided.multiplier = np.array([[np.nan, 0.3, np.nan, 0.4], [np.nan] * 4])
        ax = plot.existence_map(undecided)
        first = ["no orbit", "inadmissible", "admissible,\nundecided", "admissible,\nstable"]
        assert shown_categories(ax)[0] == first
        assert len(ax.figure.axes[1].get_yticklabels()) == 5

    def test_integers_and_floats_serve_as_truth_values(self):
        numbers = Map()
        numbers.is_admissible = numbers.is_admissible.astype(np.int8)
        numbers.is_stable = numbers.is_stable.astype(float)
        assert shown_categories(plot.existence_map(numbers)) == shown_categories(plot.existence_map(Map()))

    def test_refuses_arrays_of_another_shape(self):
        wrong = Map()
        wrong.is_stable = wrong.is_stable.T
        with pytest.raises(ValueError, match=r"is_stable must have the shape .* = \(2, 4\), got \(4, 2\)"):
            plot.existence_map(wrong)
        assert plt.get_fignums() == []

    def test_options_go_to_the_cells(self):
        mesh = plot.existence_map(Map(), edgecolors="white", alpha=0.5).collections[0]
        assert mesh.get_alpha() == 0.5


class TestImports:
    def test_without_matplotlib_the_remedy_is_told(self, monkeypatch):
        monkeypatch.setitem(sys.modules, "matplotlib", None)
        monkeypatch.delitem(sys.modules, "vibroimpact.plot")
        with pytest.raises(ImportError, match=r'pip install "vibroimpact\[plot\]"'):
            importlib.import_module("vibroimpact.plot")

    def test_nothing_comes_from_the_core(self):
        allowed = {"numpy", "matplotlib", *sys.stdlib_module_names}
        for path in Path(plot.__file__).parent.glob("*.py"):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
                names += [str(node.module)] if isinstance(node, ast.ImportFrom) else []
                for name in names:
                    assert name.split(".")[0] in allowed or name.startswith("vibroimpact.plot"), (path.name, name)
