"""Figures of families of motions: diagrams, exponents, basins; asserted on their artists."""

import matplotlib
import numpy as np
import pytest

matplotlib.use("Agg")

import matplotlib.pyplot as plt

import vibroimpact as vi

SCENE = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 2.4), vi.Stop(0, 1.0, 0.8))


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    plt.close("all")


def test_a_diagram_has_a_point_for_each_row_and_names_both_ways():
    diagram = vi.bifurcation_diagram(SCENE, ("forcing_scale", [5.0, 9.0]), direction="both", transient=9, periods=4)
    ax = vi.plot.bifurcation_diagram(diagram)
    assert [line.get_label() for line in ax.lines] == ["down", "up"]
    for line, way in zip(ax.lines, (-1, 1), strict=True):
        mine = diagram.direction[diagram.index] == way
        assert np.array_equal(line.get_xdata(), diagram.parameter[diagram.index][mine])
        assert np.array_equal(line.get_ydata(), diagram.q[mine, 0])
    assert ax.get_xlabel() == "forcing_scale [-]"
    assert ax.get_ylabel() == "position q[0]"
    up = vi.bifurcation_diagram(SCENE, ("forcing_scale", [5.0, 9.0]), section="impact", transient=9, periods=4)
    ax = vi.plot.bifurcation_diagram(up, along="speed_before")
    assert np.array_equal(ax.lines[0].get_ydata(), up.speed_before)
    assert ax.get_legend() is None
    with pytest.raises(ValueError, match='along must be an index, a direction or "speed_before"'):
        vi.plot.bifurcation_diagram(up, along="speed")


def test_exponents_are_drawn_by_batch_and_over_a_number():
    forces = [9.0, 5.0, 6.0]
    found = [vi.lyapunov_exponents(SCENE.replace(forcing_scale=f), 0.0, 0.0, (0, 2500), skip=100) for f in forces]
    ax = vi.plot.lyapunov(found[1])
    drawn = [line for line in ax.lines if str(line.get_label()).startswith("_child") or line.get_marker() in "os"]
    rows = [line.get_ydata() for line in drawn if len(line.get_xdata()) == len(found[1].history)]
    assert np.array_equal(rows[0], found[1].history[:, 0])
    ax = vi.plot.lyapunov((forces, found), name="force")
    assert ax.get_xlabel() == "force"
    points = ax.containers[0].lines[0]
    assert points.get_xdata().tolist() == [5.0, 6.0, 9.0]
    assert points.get_ydata()[0] == found[1].exponents[0]
    with pytest.raises(ValueError, match="one result for each value"):
        vi.plot.lyapunov(([1.0], found))
    one = vi.lyapunov_exponents(SCENE, 0.0, 0.0, (0, 50), n_exponents=1)
    with pytest.raises(ValueError, match="as many exponents"):
        vi.plot.lyapunov(([1.0, 2.0], [found[0], one]))


def test_basins_mark_their_attractors_and_name_them_by_pattern():
    plane = vi.basins(SCENE.replace(forcing_scale=9.0), q=(-3, 1.4, 30), v=(-5, 5, 20))
    ax = vi.plot.basins(plane)
    names = [text.get_text() for text in ax.get_legend().get_texts()]
    assert names == ["periodic 3, hits 0, 0, 0", "periodic 1, hits 0", "inside a stop"]
    marks = {line.get_label(): line for line in ax.lines}
    for k, one in enumerate(plane.attractors):
        assert np.array_equal(marks[f"_attractor {k}"].get_xdata(), one.points[:, 0])
        assert np.array_equal(marks[f"_attractor {k}"].get_ydata(), one.points[:, 1])
    mesh = ax.collections[0]
    assert mesh.get_array().shape == (20, 30)
    assert vi.plot.basins(plane, plt.figure().add_subplot(), legend=False).get_legend() is None


def test_a_branch_is_solid_where_stable_and_marks_its_special_points():
    preloaded = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 2.8), vi.Stop(0, -0.5, 0.8))
    orbit = vi.periodic_orbits(preloaded, [0])[0]
    branch = vi.continuation(orbit, "forcing_scale", (0.2, 9.0), virtual="keep", monitor={"period": lambda own: own.period})
    ax = vi.plot.branch(branch)
    drawn = {line.get_label(): line for line in ax.lines}
    # Boundaries are marked where a branch goes on beyond them.
    assert list(drawn) == ["stable", "unstable", "virtual", "fold", "graze", "period doubling"]
    assert [drawn[name].get_linestyle() for name in ("stable", "unstable", "virtual")] == ["-", "--", ":"]
    shown = np.isfinite(drawn["stable"].get_ydata())
    assert np.array_equal(shown, branch.is_stable)
    assert np.array_equal(drawn["stable"].get_ydata()[shown], branch.speeds_before[shown, 0])
    # No chord is left out.
    chords = [np.isfinite(drawn[name].get_ydata()) for name in ("stable", "unstable", "virtual")]
    assert np.logical_or.reduce([shown[1:] & shown[:-1] for shown in chords]).all()
    assert drawn["fold"].get_xdata() == [own.parameter for own in branch.special if own.kind == "fold"]
    low, high = np.nanmin(branch.speeds_before), np.nanmax(branch.speeds_before)
    assert low < drawn["fold"].get_ydata()[0] < high
    for y, label in [("phases[0]", "phase of impact 0"), ("period", "period"), (lambda own: own.period, "<lambda>")]:
        assert vi.plot.branch(branch, y=y).get_ylabel() == label
    with pytest.raises(ValueError, match=r"y must be a function or one of speeds_before\[0\], phases\[0\], period, got 'speed'"):
        vi.plot.branch(branch, y="speed")


def test_a_branch_that_hits_nothing_is_drawn_by_its_position():
    quiet = vi.periodic_orbits(SCENE, [])[0]
    branch = vi.continuation(quiet, "forcing_scale", (0.5, 9.0))
    ax = vi.plot.branch(branch)
    assert ax.get_ylabel() == "position at t = 0"
    assert [line.get_label() for line in ax.lines] == ["stable", "graze"]
