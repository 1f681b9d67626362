"""What all figures have in common: axes, labels, options, errors; the artists are asked, not the pixels."""

import ast
import importlib
import re
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.axes import Axes
from plot_models import BouncingOrbit, BouncingTrajectory, LedgerOfABall, Map, modes, stable_orbit

import vibroimpact as vi
import vibroimpact.plot as plot


def swept():
    """A run along a ramp."""
    scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([0.5], 0.8))
    return vi.simulate(scene, 0.0, 0.0, (0, 60), ramp=vi.Ramp("frequency", 1.2, over=50.0))


OSCILLATOR = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 2.4), vi.Stop(0, 1.0, 0.8))
DIAGRAM = vi.bifurcation_diagram(OSCILLATOR, ("forcing_scale", [5.0, 9.0]), direction="both", transient=9, periods=4)
EXPONENTS = vi.lyapunov_exponents(OSCILLATOR.replace(forcing_scale=5.0), 0.0, 0.0, (0, 400))
BRANCH = vi.continuation(vi.periodic_orbits(OSCILLATOR.replace(forcing_scale=9.0), [0])[0], "frequency", (2.0, 2.8))
CURVE = vi.bifurcation_curve(BRANCH.special[0], ("frequency", "clearance"), ((2.0, 2.8), (0.5, 1.5)), max_points=10)
PLANE = vi.basins(OSCILLATOR.replace(forcing_scale=9.0), q=(-3, 1.4, 5), v=(-5, 5, 4))

CALLS = {
    "time_history": lambda **k: plot.time_history(BouncingOrbit(), **k),
    "phase_portrait": lambda **k: plot.phase_portrait(BouncingOrbit(), **k),
    "poincare_section": lambda **k: plot.poincare_section(BouncingOrbit(), **k),
    "mode_shapes": lambda **k: plot.mode_shapes(modes(), **k),
    "multipliers": lambda **k: plot.multipliers(stable_orbit({(0,): [0.5, -0.2]}), **k),
    "existence_map": lambda **k: plot.existence_map(Map(), **k),
    "energy": lambda **k: plot.energy(LedgerOfABall(), **k),
    "impact_speeds": lambda **k: plot.impact_speeds(BouncingOrbit(), **k),
    "gap": lambda **k: plot.gap(BouncingOrbit(), 0, **k),
    "contact_force": lambda **k: plot.contact_force(BouncingOrbit(), 0, **k),
    "spectrum": lambda **k: plot.spectrum(BouncingTrajectory(), **k),
    "sweep": lambda **k: plot.sweep(swept(), **k),
    "bifurcation_diagram": lambda **k: plot.bifurcation_diagram(DIAGRAM, **k),
    "lyapunov": lambda **k: plot.lyapunov(EXPONENTS, **k),
    "basins": lambda **k: plot.basins(PLANE, **k),
    "branch": lambda **k: plot.branch(BRANCH, **k),
    "multiplier_paths": lambda **k: plot.multiplier_paths(BRANCH, **k),
    "bifurcation_curves": lambda **k: plot.bifurcation_curves(CURVE, **k),
}
DATA = {
    "mode_shapes": modes(),
    "multipliers": stable_orbit({(0,): [0.5]}),
    "existence_map": Map(),
    "energy": LedgerOfABall(),
    "spectrum": BouncingTrajectory(),
    "sweep": swept(),
    "bifurcation_diagram": DIAGRAM,
    "lyapunov": EXPONENTS,
    "basins": PLANE,
    "branch": BRANCH,
    "multiplier_paths": BRANCH,
    "bifurcation_curves": CURVE,
}
BEFORE_AXES = {"gap": (0,), "contact_force": (0,), "spectrum": (1,), "sweep": (0,)}  # the stop, or what is drawn along


MARKED = ("multipliers", "multiplier_paths", "existence_map", "basins")  # what is drawn of these is no line


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
    def test_axes_are_the_argument_after_the_data(self, name):
        _, ax = plt.subplots()
        assert getattr(plot, name)(DATA.get(name, BouncingOrbit()), *BEFORE_AXES.get(name, ()), ax) is ax

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
            getattr(plot, name)([BouncingOrbit()], *BEFORE_AXES.get(name, ()))
        assert plt.get_fignums() == []

    @pytest.mark.parametrize("name", ["time_history", "phase_portrait", "poincare_section", "spectrum"])
    @pytest.mark.parametrize("along", [-1, 2, 0.5, "0", None, [1.0], [0.0, 0.0], [1.0, np.nan], [[1.0, 0.0]], ["a", "b"]])
    def test_refuses_a_direction_that_is_not_there(self, name, along):
        rule = r"along must be an index from 0 to 1 or a direction of 2 finite numbers, not all 0, got "
        with pytest.raises(ValueError, match=rule + re.escape(repr(along))):
            CALLS[name](along=along)
        assert plt.get_fignums() == []

    @pytest.mark.parametrize("name", ["time_history", "phase_portrait", "poincare_section", "spectrum"])
    def test_takes_numpy_integers(self, name):
        assert "[1]" in CALLS[name](along=np.int32(1)).get_ylabel()

    @pytest.mark.parametrize("name", ["gap", "contact_force"])
    @pytest.mark.parametrize("stop", [-1, 5, 0.5, "0", None])
    def test_refuses_a_stop_that_is_not_there(self, name, stop):
        with pytest.raises(ValueError, match=rf"stop must be an index from 0 to 4, got {re.escape(repr(stop))}"):
            getattr(plot, name)(BouncingOrbit(), stop)
        assert plt.get_fignums() == []

    @pytest.mark.parametrize(
        "name", [name for name in CALLS if name not in ("multipliers", "multiplier_paths", "existence_map", "basins")]
    )
    def test_passes_options_to_the_line_under_any_alias(self, name):
        ax = CALLS[name](lw=3.5, c="red", ls=":", marker="d")
        drawn = next(line for line in ax.lines if line.get_linewidth() == 3.5)
        assert drawn.get_color() == "red"
        assert drawn.get_linestyle() == ":"
        assert drawn.get_marker() == "d"


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


class TestBranches:
    def test_a_tree_has_a_colour_for_each_branch(self):
        tree = vi.branch_tree(BRANCH[0], "frequency", (2.0, 2.8), depth=1, max_points=10)
        ax = plot.branch(tree)
        assert ax.get_ylabel() == "speed of the fastest impact"
        assert len({line.get_color() for line in ax.lines if line.get_linestyle() != "None"}) == len(tree)

    def test_curves_have_their_kind_in_the_legend(self):
        ax = plot.bifurcation_curves([CURVE])
        assert CURVE.kind.replace("_", " ") in [text.get_text() for text in ax.get_legend().get_texts()]
        x = np.concatenate([line.get_xdata() for line in ax.lines])
        np.testing.assert_array_equal(np.unique(x[np.isfinite(x)]), np.unique(CURVE.x))
