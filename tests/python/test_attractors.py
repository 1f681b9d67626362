"""Attractors: scenes of which they are known, the same bits whoever finds them, wrong calls."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import vibroimpact as vi

SCENE = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([9.0], 2.4), vi.Stop(0, 1.0, 0.8))
BOX = [(-3.0, 2.0), (-5.0, 5.0)]


def same(a, b):
    pairs = zip(a, b, strict=True)
    return np.array_equal(a.of_seed, b.of_seed) and all(np.array_equal(x.points, y.points) for x, y in pairs)


@pytest.fixture(scope="module")
def found():
    return vi.find_attractors(SCENE, BOX, seeds=24, workers=1)


def test_two_orbits_are_found_and_named(found):
    assert {(one.kind, one.n_periods) for one in found} == {("periodic", 1), ("periodic", 3)}
    assert len(found) == 2
    assert sum(one.fraction for one in found) == pytest.approx(1.0)
    assert [one.pattern for one in found] == [[0] * one.n_periods for one in found]
    for one in found:
        assert one.orbit.is_admissible
        assert one.orbit.is_stable
        assert one.points.shape == (one.n_periods, 2)
        assert (one.exponents < 0).all()
    inside = found.seeds[:, 0] > 1.0
    assert np.array_equal(found.of_seed == -3, inside)
    assert inside.any()
    assert f"{inside.sum()} inside" in repr(found)
    assert found[0].fraction >= found[1].fraction
    assert found[:1] == (found[0],)


def test_a_motion_from_a_seed_ends_on_the_points_of_its_attractor(found):
    for seed, place in zip(found.seeds, found.of_seed, strict=True):
        if place < 0:
            continue
        run = vi.simulate(SCENE, seed[:1], seed[1:], (0, 600 * SCENE.period), keep="final")
        state = np.concatenate(run.final)
        assert np.abs(found[place].points - state).max(axis=1).min() < 1e-6


def test_the_bits_are_the_same_with_any_workers(found):
    with ProcessPoolExecutor(2) as processes, ThreadPoolExecutor(3) as threads:
        for workers in (2, processes, threads, map):
            assert same(found, vi.find_attractors(SCENE, BOX, seeds=24, workers=workers))
    assert same(found, vi.find_attractors(SCENE, BOX, seeds=found.seeds))
    other = vi.find_attractors(SCENE, BOX, seeds=24, rng=1)
    assert not np.array_equal(other.seeds, found.seeds)


def test_no_seeds_find_nothing():
    none = vi.find_attractors(SCENE, BOX, seeds=0)
    assert len(none) == 0
    assert repr(none) == "Attractors(0 seeds: [])"


def test_what_grows_is_lost():
    growing = vi.Scene(vi.LinearSystem(1, -0.2, 1), vi.Harmonic([1.0], 2.4), ())
    found = vi.find_attractors(growing, BOX, seeds=3)
    assert (found.of_seed == -2).all()


@pytest.mark.parametrize(
    ("box", "arguments", "message"),
    [
        ([(0, 1)], {}, r"box has shape \(1, 2\), but \(2, 2\) is needed"),
        ([(0, 1), (1, 0)], {}, "the first must be the lower one"),
        ([(0, 1), (0, np.nan)], {}, "box"),
        ([(0, 1), (1, 1)], {}, "box is without width"),
        (BOX, {"seeds": -1}, "seeds is -1"),
        (BOX, {"seeds": [[0.0]]}, r"seeds has shape \(1, 1\)"),
        (BOX, {"seeds": [[0.0, np.inf]]}, r"seeds"),
        (BOX, {"longest_period": 0}, "longest_period is 0, but it must be at least 1"),
        (BOX, {"transient": -1}, "transient is -1, but it must be at least 0"),
        (BOX, {"max_periods": -1}, "max_periods is -1"),
        (BOX, {"phase": np.inf}, "phase is inf"),
        (BOX, {"workers": 0}, "workers is 0"),
    ],
)
def test_wrong_calls_are_refused(box, arguments, message):
    with pytest.raises(ValueError, match=message):
        vi.find_attractors(SCENE, box, **arguments)


def test_what_comes_to_rest_is_told_of_a_scene_that_nothing_drives():
    # x'' = x - x^3 - 0.3 x' about one of two equilibria, or pressed onto a stop before it gets there.
    def force(t, q, v):
        with np.errstate(over="ignore", invalid="ignore"):  # a step that is tried may lead far away
            return q - q**3 - 0.3 * v

    scene = vi.Scene(vi.NonlinearSystem(1, force, mass=1.0), vi.Harmonic([0.0], 1.0), vi.Stop(0, 0.5, 0.6))
    found = vi.find_attractors(scene, [(-2.0, 0.5), (-1.0, 1.0)], seeds=[(-1.2, 0.1), (0.3, 0.2), (0.2, 0.1)], transient=20)
    assert [one.kind for one in found] == ["rest", "rest"]
    places = sorted(float(one.points[0, 0]) for one in found)
    assert np.allclose(places, [-1.0, 0.5], atol=1e-8)
    assert np.allclose([one.points[:, 1] for one in found], 0.0, atol=1e-8)


def test_a_scene_without_a_period_is_refused():
    free = vi.Scene(SCENE.system, None, SCENE.stops)
    with pytest.raises(ValueError, match="without a forcing period"):
        vi.find_attractors(free, BOX, seeds=1)


PENDULUM = vi.Scene(vi.PendulumChain([1.0], [1.0], 0.3, gravity=1.0), vi.Harmonic([2.0], 1.0))
TURN = 2 * np.pi
CIRCLE = {"seeds": 16, "transient": 100, "wrap": {0: TURN}}


@pytest.fixture(scope="module")
def turning():
    return vi.find_attractors(PENDULUM, [(-np.pi, np.pi), (-3, 3)], **CIRCLE)


def test_what_turns_over_is_told_by_its_points(turning):
    rounds = [one for one in turning if one.orbit is None]
    assert len(rounds) == 2
    for one in rounds:
        assert (one.kind, one.n_periods) == ("periodic", 1)
        assert "goes round" in one.reason
        assert (np.abs(one.points[:, 0]) <= np.pi).all()
    assert turning.wrap == ((0, TURN),)
    again = vi.find_attractors(PENDULUM, [(-np.pi, np.pi), (-3, 3)], **CIRCLE, workers=map)
    assert [one.points.tobytes() for one in again] == [one.points.tobytes() for one in turning]


def test_without_a_turn_it_drifts():
    seeds = [(0.0, 2.1), (0.0, -0.4)]
    found = vi.find_attractors(PENDULUM, [(-1, 1), (-3, 3)], seeds=seeds, transient=100, max_periods=3000)
    assert not any(one.n_periods for one in found)
    assert (found.of_seed == -4).any()


def test_weak_chaos_is_one_set_with_its_basin():
    scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([8.5], 2.4), vi.Stop(0, 1.0, 0.8))
    found = vi.find_attractors(scene, [(-3, 1), (-5, 5)], seeds=24)
    assert [one.kind for one in found].count("chaotic") == 1
    assert (found.of_seed >= 0).all()
    labels = vi.basins(scene, q=(-3, 1, 6), v=(-5, 5, 6), attractors=found).labels
    assert (labels > 0).all()


def test_what_drifts_is_counted_by_itself():
    scene = vi.Scene(vi.LinearSystem(1.0, 1.0, 0.0, load=[0.3]), vi.Harmonic([1.0], 1.0))
    found = vi.find_attractors(scene, [(-1, 1), (-1, 1)], seeds=3, workers=1)
    assert len(found) == 0
    assert (found.of_seed == -4).all()
    assert "3 drifting" in repr(found)
    run = vi.simulate(scene, [0.0], [0.0], (0, 200))
    with pytest.raises(ValueError, match=r"it drifts: in each period of the forcing its position advances by \(1\.88496\)"):
        vi.find_orbit(scene, run)


def test_basins_take_the_turns_of_their_attractors(turning):
    plane = {"q": (-np.pi, np.pi, 6), "v": (-3, 3, 5), "attractors": turning}
    one = vi.basins(PENDULUM, **plane)
    assert (one.labels > 0).all()
    assert np.array_equal(vi.basins(PENDULUM, **plane, wrap={0: TURN}).labels, one.labels)
    # Without, only what stays where it is is told.
    assert (vi.basins(PENDULUM, **plane, wrap={}, max_periods=200).labels <= 0).any()
    sampled = vi.basin_fractions(PENDULUM, turning.box, samples=40, attractors=turning)
    assert sampled.fractions.sum() == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("wrap", "error", "message"),
    [
        ({1: TURN}, ValueError, "wrap is 1, but there are 1 positions"),
        ({-1: TURN}, ValueError, "wrap has the position -1"),
        ({0: 0.0}, ValueError, r"wrap\[0\] is 0, but a turn must be positive"),
        ({0: np.inf}, ValueError, r"wrap\[0\] is inf"),
        (TURN, TypeError, "wrap is 6.28.*but a dict"),
    ],
)
def test_wrong_turns_are_refused(wrap, error, message):
    for call in (vi.find_attractors, vi.basin_fractions):
        with pytest.raises(error, match=message):
            call(PENDULUM, [(-1, 1), (-1, 1)], wrap=wrap)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"seeds": 1.5}, ValueError, r"seeds has shape \(\), but \(k, 2\)"),
        ({"seeds": True}, (TypeError, ValueError), "seeds"),
        ({"seeds": None}, ValueError, "seeds has shape"),
        ({"seeds": "a"}, ValueError, "seeds is .a., but an array of numbers"),
        ({"seeds": []}, ValueError, r"seeds has shape \(0,\), but \(k, 2\)"),
        ({"seeds": [[0.0, np.inf]]}, ValueError, r"seeds\[0\] is inf"),
        ({"rng": "a"}, ValueError, "rng is 'a'"),
        ({"rng": -1}, ValueError, "rng is -1"),
        ({"wrap": {0: "a"}}, TypeError, r"wrap\[0\] is 'a'"),
    ],
)
def test_wrong_starts_name_their_argument(options, error, message):
    with pytest.raises(error, match=message):
        vi.find_attractors(PENDULUM, [(-1, 1), (-1, 1)], **options)


def test_what_is_no_scene_is_refused():
    with pytest.raises(TypeError, match="scene is None"):
        vi.find_attractors(None, [(-1, 1), (-1, 1)])
