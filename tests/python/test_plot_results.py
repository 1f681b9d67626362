"""Mode shapes, multipliers and existence maps."""

from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.patches import Circle
from plot_models import Map, contains, labelled, modes, stable_orbit

import vibroimpact.plot as plot
from vibroimpact.plot.existence import CATEGORIES


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
        assert sorted(text.get_text()[:21] for text in ax.texts) == ["0.5", "multipliers undefined"]

    def test_values_stand_at_their_points_and_close_ones_are_drawn_again(self):
        ax = plot.multipliers(stable_orbit({(0,): [0.4 + 0.3j, 0.4 - 0.3j, -0.7]}))
        assert sorted(text.get_text() for text in ax.texts) == ["-0.7", "0.4 ± 0.3i"]
        assert ax.child_axes == []
        ax = plot.multipliers(stable_orbit({(0,): [-0.5 + 0.01j, -0.5 - 0.01j, 0.7, 0.1]}))
        (inset,) = ax.child_axes
        (low, high), (bottom, top) = inset.get_xlim(), inset.get_ylim()
        assert low < -0.5 < high < -0.4
        assert bottom < -0.01 < 0.01 < top < 0.1
        many = np.exp(2j * np.pi * np.arange(40) / 40)
        assert list(plot.multipliers(stable_orbit({(0,): many})).texts) == []

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
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("frequency [rad/s]", "clearance[1]")

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
        # Those that occur.
        assert [text.get_text() for text in ax.figure.axes[1].get_yticklabels()] == first

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
