"""Basins: where motions end, planes of every kind, the same bits with any workers, intricate boundaries, wrong calls."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import vibroimpact as vi

SCENE = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([9.0], 2.4), vi.Stop(0, 1.0, 0.8))
BOX = [(-3.0, 1.5), (-5.0, 5.0)]
PLANE = {"q": (-3.0, 1.5, 24), "v": (-5.0, 5.0, 18)}
PAIR = vi.paper_scene(kind=3).replace(damping_scale=1.0)


@pytest.fixture(scope="module")
def found():
    return vi.find_attractors(SCENE, BOX, seeds=40)


@pytest.fixture(scope="module")
def plane(found):
    return vi.basins(SCENE, **PLANE, attractors=found)


def test_each_cell_is_where_its_motion_ends(found, plane):
    assert plane.labels.shape == plane.iterations.shape == (18, 24)
    assert plane.labels.dtype == np.int16
    assert (plane.x_name, plane.y_name) == ("q[0]", "v[0]")
    assert np.array_equal(plane.labels == -2, np.broadcast_to(plane.x > 1.0, (18, 24)))
    for j, i in [(0, 0), (5, 7), (9, 3), (17, 12)]:
        run = vi.simulate(SCENE, plane.x[i], plane.y[j], (0, 900 * SCENE.period), keep="final")
        state = np.concatenate(run.final)
        near = [np.abs(one.points - state).max(axis=1).min() < 1e-6 for one in found]
        assert near.index(True) + 1 == plane.labels[j, i]
    assert plane.fractions.sum() == pytest.approx(1.0)
    assert "fractions" in repr(plane)
    assert "inside a stop" in repr(plane)


def test_attractors_are_found_first_where_none_are_given(plane):
    own = vi.basins(SCENE, **PLANE, box=BOX)
    assert len(own.attractors) == 2
    assert np.array_equal(own.labels, plane.labels)


def test_the_bits_are_the_same_with_any_workers(found, plane):
    with ProcessPoolExecutor(2) as processes, ThreadPoolExecutor(3) as threads:
        for workers in (1, 2, processes, threads, map):
            again = vi.basins(SCENE, **PLANE, attractors=found, workers=workers)
            assert np.array_equal(again.labels, plane.labels)
            assert np.array_equal(again.iterations, plane.iterations)


def test_states_after_an_impact(found):
    after = vi.basins(SCENE, impact={"stop": 0, "phase": (0.0, 2 * np.pi, 8), "speed": (0.1, 6.0, 6)}, attractors=found)
    assert (after.x_name, after.y_name) == ("phase", "speed")
    assert (after.labels > 0).all()
    for j, i in [(0, 0), (3, 5), (5, 2)]:
        start = after.x[i] / 2.4
        run = vi.simulate(SCENE, 1.0, -after.y[j], (start, 900 * SCENE.period), keep="final")
        state = np.concatenate(run.final)
        near = [np.abs(one.points - state).max(axis=1).min() < 1e-6 for one in found]
        assert near.index(True) + 1 == after.labels[j, i]


def test_a_plane_of_more_degrees_of_freedom():
    made = vi.basins(PAIR, q={0: (-0.1, 0.1, 4), 1: 0.0}, v={0: 0.0, 1: (-0.2, 0.2, 3)}, max_periods=300)
    assert made.labels.shape == (3, 4)
    assert (made.x_name, made.y_name) == ("q[0]", "v[1]")
    # The other way round is the transposed plane.
    turned = vi.basins(PAIR, q={1: 0.0, 0: 0.05}, v={1: [-0.1, 0.1], 0: [0.0, 0.1]}, attractors=made.attractors, max_periods=300)
    assert (turned.x_name, turned.y_name) == ("v[1]", "v[0]")


def test_nothing_is_decided_in_no_time(found):
    none = vi.basins(SCENE, **PLANE, attractors=found, max_periods=0)
    assert set(np.unique(none.labels)) == {0, -2}
    assert "undecided: more max_periods, or find_attractors" in repr(none)
    empty = vi.basins(SCENE, **PLANE, attractors=(), box=BOX, max_periods=5)
    assert set(np.unique(empty.labels)) == {0, -2}
    assert empty.fractions.shape == (0,)


def test_fractions_by_samples(found):
    sampled = vi.basin_fractions(SCENE, [(-3.0, 1.0), (-5.0, 5.0)], samples=600, attractors=found)
    assert sampled.fractions.sum() == pytest.approx(1.0)
    expected = np.sqrt(sampled.fractions * (1 - sampled.fractions) / 600)
    assert np.allclose(sampled.errors, expected)
    fine = vi.basins(SCENE, q=(-3.0, 1.0, 40), v=(-5.0, 5.0, 40), attractors=found)
    assert (np.abs(sampled.fractions - fine.fractions) < 4 * sampled.errors + 0.01).all()
    along = vi.basin_fractions(SCENE, BOX, samples=60, axis=("forcing_scale", [1.0, 1.02, 1.5]))
    assert along.fractions.shape[0] == 3
    assert np.allclose(along.fractions.sum(axis=1) + along.undecided, 1.0)
    # Each keeps its column: that of three periods is first at both of the values at which it is.
    periods = [[one.n_periods for one in own] for own in along.attractors]
    assert sorted(periods[0]) == sorted(periods[1]) == [1, 3]
    assert "forcing_scale, 3 values" in repr(along)


def plane_of(labels):
    """Return basins with some labels."""
    x, y = (np.arange(float(cells)) for cells in labels.shape[::-1])
    return vi.Basins(labels, np.zeros(labels.shape, np.int32), x, y, "q[0]", "v[0]", ())


class TestBoundary:
    def test_what_is_found_of_a_straight_one(self):
        labels = np.ones((128, 128), dtype=np.int16)
        labels[:, 61:] = 2
        made = plane_of(labels)
        fit = made.boundary_dimension()
        assert isinstance(fit, vi.Fit)
        assert fit.sizes.tolist() == [2, 4, 8, 16, 32]
        assert fit.value == pytest.approx(1.0, abs=1e-12)
        assert made.uncertainty_exponent().sizes.tolist() == [1, 2, 4, 8, 16]
        whole, mixed = made.entropy(8)
        assert whole == pytest.approx(mixed / 16, abs=1e-12)

    def test_what_lies_inside_a_stop_is_no_basin(self):
        labels = np.ones((64, 64), dtype=np.int16)
        labels[:, :8], labels[:, 8:16] = -2, -3
        assert np.isnan(plane_of(labels).boundary_dimension().value)

    @pytest.mark.parametrize("cells", [0, 65, 2.5, True])
    def test_boxes_fit_into_the_plane(self, cells):
        with pytest.raises(ValueError, match="cells is"):
            plane_of(np.ones((64, 64), dtype=np.int16)).entropy(cells)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"q": (-1, 1, 4), "v": 0.0}, "1 coordinates vary, but two must"),
        ({"q": (-1, 1, 4)}, r"v\[0\] is not given"),
        ({"q": (1, -1, 4), "v": (0, 1, 4)}, r"low below high"),
        ({"q": (-1, 1, 0), "v": (0, 1, 4)}, r"at least one cell"),
        ({"q": [0.0, np.nan], "v": (0, 1, 4)}, "not finite"),
        ({"q": np.inf, "v": (0, 1, 4)}, "must be finite"),
        ({"q": {1: (0, 1, 4)}, "v": (0, 1, 4)}, "has the coordinate 1"),
        ({"impact": {"stop": 0}, "q": 1.0}, "impact is given with q or v"),
        ({"impact": {"stop": 0}}, "stop, phase and speed are needed"),
        ({"impact": {"stop": 3, "phase": (0, 1, 2), "speed": (0, 1, 2)}}, "stop is 3"),
        ({"impact": {"stop": 0, "phase": 0.0, "speed": (0, 1, 2)}}, "must both vary"),
        ({"impact": {"stop": 0, "phase": (0, 1, 2), "speed": (0, 1, 2)}}, "box is not given"),
        ({**PLANE, "hits": 0}, "hits is 0"),
        ({**PLANE, "max_periods": -1}, "max_periods is -1"),
        ({**PLANE, "workers": 0}, "workers is 0"),
    ],
)
def test_wrong_calls_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        vi.basins(SCENE, **arguments)


def test_attractors_of_another_scene_or_phase_are_refused(found):
    with pytest.raises(ValueError, match="another scene"):
        vi.basins(SCENE.replace(forcing_scale=1.1), **PLANE, attractors=found)
    with pytest.raises(ValueError, match="have their points at phase"):
        vi.basins(SCENE, **PLANE, phase=1.0, attractors=found)
    with pytest.raises(TypeError, match="an Attractor is needed"):
        vi.basins(SCENE, **PLANE, attractors=[3], box=BOX)
    with pytest.raises(ValueError, match="2 degrees of freedom"):
        vi.basins(PAIR, impact={"stop": 0, "phase": (0, 1, 2), "speed": (0, 1, 2)})
    with pytest.raises(ValueError, match="samples is 0"):
        vi.basin_fractions(SCENE, BOX, samples=0)
    with pytest.raises(ValueError, match="attractors are given with an axis"):
        vi.basin_fractions(SCENE, BOX, axis=("forcing_scale", [1.0]), attractors=found)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"impact": {"stop": 0, "phase": (0.0, 6.0, 4), "speed": (-4.0, 4.0, 4)}}, ValueError, "speed has -3"),
        ({"impact": {"stop": 0, "phase": (0.0, 6.0, 4), "speed": None}}, ValueError, "speed is nan"),
        ({"q": (-3, 1, 3.0), "v": (-5, 5, 3)}, ValueError, r"q\[0\] is \(-3, 1, 3.0\), but .* whole number of cells"),
        ({"q": (-3, 1, 10**12), "v": (-5, 5, 3)}, ValueError, r"q\[0\] has 1000000000000 cells"),
        ({"q": "a", "v": (-5, 5, 3)}, ValueError, r"q\[0\] is .a."),
        ({"q": (-3, 1, 3), "v": (-5, 5, 3), "hits": 1.5}, TypeError, "hits is 1.5"),
        ({"q": (-3, 1, 3), "v": (-5, 5, 3), "attractors": 5}, TypeError, "attractors is 5"),
        ({"q": (-3, 1, 3), "v": (-5, 5, 3), "overwrite": "x"}, TypeError, "overwrite is 'x'"),
        ({"q": (-3, 1, 3), "v": (-5, 5, 3), "store": 5}, TypeError, "store is 5"),
        ({"q": (-3, 1, 3), "v": (-5, 5, 3), "box": "ab"}, ValueError, "box is .ab."),
        ({"q": (-3, 1, 3), "v": (-5, 5, 3), "box": [(-1.7e308, 1.7e308), (-1, 1)]}, ValueError, "box is wider"),
    ],
)
def test_wrong_calls_name_their_argument(found, options, error, message):
    with pytest.raises(error, match=message):
        vi.basins(SCENE, **({"attractors": found} | options))


def test_wrong_axes_of_fractions_name_it():
    for axis in [("restitution", [np.nan]), ("foo", [1.0])]:
        with pytest.raises(ValueError, match="axis"):
            vi.basin_fractions(SCENE, BOX, samples=10, axis=axis)


def test_thirty_attractors():
    # A pendulum that is pushed a little swings about one of its lowest places, 2 pi apart.
    scene = vi.Scene(vi.PendulumChain([1.0], [1.0], 0.5, gravity=1.0), vi.Harmonic([0.1], 2.0))
    places = 2 * np.pi * np.arange(30)
    box = [(-np.pi, places[-1] + np.pi), (-0.5, 0.5)]
    found = vi.find_attractors(scene, box, seeds=np.column_stack([places + 0.1, 0 * places]), transient=50)
    assert len(found) == 30
    assert all(one.n_periods == 1 and one.fraction == pytest.approx(1 / 30) for one in found)
    plane = vi.basins(scene, q=(*box[0], 120), v=(-0.5, 0.5, 2), attractors=found)
    # Four cells a place: each leads to the attractor that is nearest.
    nearest = [int(np.argmin([abs(one.points[0, 0] - x) for one in found])) + 1 for x in plane.x]
    assert np.array_equal(plane.labels, np.broadcast_to(nearest, (2, 120)))
    assert np.allclose(plane.fractions, 1 / 30)
    # Modulo a turn there is one.
    assert len(vi.find_attractors(scene, box, seeds=found.seeds, transient=50, wrap={0: 2 * np.pi})) == 1
