"""Exponents of motions that meet stops which give way: against differences of runs, orbits and what dashpots take."""

import itertools
import os

import numpy as np
import pytest
from contact_scenes import draw

import vibroimpact as vi

#: A soak asks for more scenes, at seeds of its own.
COUNT = int(os.environ.get("VIBROIMPACT_SOAK_SPRING_EXPONENTS", "60"))
SEED = int(os.environ.get("VIBROIMPACT_SOAK_SPRING_EXPONENTS_SEED", "5"))

OSCILLATOR = vi.LinearSystem(1.0, 0.1, 1.0)
RELEASES = ["gap", "force", "clipped"]


def states(run):
    """Return the states of all elements, one row a part of the run."""
    return [tuple(row) for row in run.regimes["state"]]


def jacobian(scene, x, end):
    """Return differences of runs by their starts; none where runs beside are others, or differences not to be had."""
    n = len(x) // 2
    own = states(vi.simulate(scene, x[:n], x[n:], (0, end)))

    def last(x):
        run = vi.simulate(scene, x[:n], x[n:], (0, end))
        return np.concatenate(run.final) if states(run) == own else np.full(2 * n, np.nan)

    def by(step):
        columns = [(last(x + step * e) - last(x - step * e)) / (2 * step) for e in np.eye(2 * n)]
        return np.transpose(columns)

    fine, coarse = by(1e-6), by(3e-6)
    is_sure = abs(fine - coarse).max() < 1e-5 * abs(fine).max()
    return fine + (fine - coarse) / 8 if is_sure else None


def growths(system, jacobian):
    """Return how the directions of modal coordinates grow, the largest first, in each order that modes may have: of their
    frequencies, or of the coordinates that they are. None where damping couples the modes, or differences do not tell."""
    modes = vi.modes(system)
    if not modes.is_proportional:
        return []
    shapes = modes.shapes
    n = len(shapes)
    orders = [shapes]
    if np.count_nonzero(shapes) == n:
        orders.append(shapes[:, np.argmax(shapes != 0.0, axis=1)])
    found = [areas(shapes, jacobian) for shapes in orders]
    is_told = all(not ((own > 1e-6 * own[0]) & (own < 1e-3 * own[0])).any() for own in found)
    return found if is_told else []


def areas(shapes, jacobian):
    """Return the lengths of the columns of a Jacobian in modal coordinates, each beside those before it, the largest first."""
    n = len(shapes)
    to_physical = np.zeros((2 * n, 2 * n))
    to_physical[:n, ::2] = to_physical[n:, 1::2] = shapes
    modal = np.linalg.solve(to_physical, jacobian @ to_physical)
    found, frame = [], np.zeros((2 * n, 0))
    for column in modal.T:
        left = column
        for _ in range(2):
            left = left - frame @ (frame.T @ left)
        found.append(np.linalg.norm(left))
        if found[-1] > 1e-6 * abs(modal).max():  # else it is gone, and its direction that of rounding
            frame = np.column_stack([frame, left / found[-1]])
    return np.sort(found)[::-1]


def compared(number):
    """Return how far exponents of a random run are from differences of runs, and which states it goes through; none where
    it cannot be compared."""
    twin, q0, v0, end = draw(np.random.default_rng([SEED, number]))
    scene = twin.scene()
    if all(stop.is_rigid for stop in twin.stops):
        return None
    try:
        run = vi.simulate(scene, q0, v0, (0, end))
        passed = states(run)
        at_ends = {*passed[0], *passed[-1]}
        if run.status != "finished" or at_ends & {"relaxing"} or {*passed[0]} & {"held", "seated"}:
            return None
        beside = jacobian(scene, np.concatenate([q0, v0]), end)
    except ValueError:  # a start beside it is inside a stop
        return None
    found = vi.lyapunov_exponents(scene, q0, v0, (0, end))
    if beside is None or found.n_clashes or found.n_grazes:
        return None
    grown = found.exponents * end
    apart = []
    if np.isfinite(grown).all() and np.linalg.cond(beside) < 1e3:
        apart.append(abs(np.linalg.slogdet(beside)[1] - grown.sum()))
    if np.isfinite(found.expected_sum):
        apart.append(1e3 * abs(found.expected_sum - found.sum) * end / (1.0 + abs(grown).sum()))
    own = np.sort(np.exp(grown))[::-1]
    off = [abs(own - wanted).max() / wanted[0] for wanted in growths(scene.system, beside)]
    apart += [min(off)] if off else []
    met_again = any(pair == ("relaxing", "pressed") for a, b in itertools.pairwise(passed) for pair in zip(a, b, strict=True))
    kinds = {state for row in passed for state in row} | ({"met again"} if met_again else set())
    return max(apart, default=0.0), kinds


def test_random_runs_grow_as_differences_say():
    """Of all releases, preloads and rigid stops beside; the sum is what dashpots and impacts take."""
    seen, wrong, count = set(), [], 0
    for number in range(COUNT):
        found = compared(number)
        if found is None:
            continue
        apart, kinds = found
        count += 1
        seen |= kinds
        if not apart < 1e-4:
            wrong.append((SEED, number, apart, kinds))
    assert not wrong
    assert count >= COUNT / 3
    assert seen >= {"pressed", "idle", "relaxing", "met again", "held"}


@pytest.mark.parametrize("release", RELEASES)
@pytest.mark.parametrize("preload", [0.0, 0.15])
def test_an_orbit_has_the_exponents_of_its_multipliers(release, preload):
    """The logarithms of its multipliers, which are real, over its period."""
    law = vi.Spring(20.0, 0.5, release=release, preload=preload)
    scene = vi.Scene(OSCILLATOR, vi.Harmonic([2.0], 0.5), vi.Stop(0, 0.5, contact=law))
    period = 2 * np.pi / 0.5
    orbit = vi.find_orbit(scene, vi.simulate(scene, 0.0, 0.3, (0, 80 * period)))
    found = vi.lyapunov_exponents(orbit.scene, orbit.q0, orbit.v0, (0, 500.5 * period), skip=100.5 * period)
    wanted = np.sort(np.log(abs(orbit.floquet_multipliers)))[::-1] / period
    assert found.exponents == pytest.approx(wanted, abs=1e-7)
    assert found.verdict == "periodic"
    assert np.isnan(found.expected_sum) == (release == "force")
    if release != "force":
        assert found.sum == pytest.approx(found.expected_sum, abs=1e-9)


def test_a_relaxing_stop_is_what_is_remembered():
    """At rest on a rigid stop nothing is left of a motion of one mass but the place of a stop that relaxes still."""
    slow = vi.Spring(2.0, 40.0, release="force")  # back by e^-1 in 20 units of time
    stops = [vi.Stop(0, 0.1, contact=slow), vi.Stop(0, 0.4, 0.0, side="lower")]
    scene = vi.Scene(vi.LinearSystem(1.0, 0.3, 1.0), vi.Harmonic([2.0], 0.6), stops)
    run = vi.simulate(scene, 0.0, 0.5, (0, 60))
    assert {("relaxing", "held"), ("pressed", "free")} <= set(states(run))
    end = run.contacts["start"][run.contacts["stop"] == 0][-2] + 0.1
    found = vi.lyapunov_exponents(scene, 0.0, 0.5, (0, end))
    assert found.n_landings > 3
    wanted = areas(np.eye(1), jacobian(scene, np.array([0.0, 0.5]), end))
    assert np.exp(found.exponents[0] * end) == pytest.approx(wanted[0], rel=1e-5)
    assert found.exponents[1] == -np.inf


@pytest.mark.parametrize("release", RELEASES)
def test_a_seat_takes_two_directions(release):
    """A body that rests at the seat of a preloaded stop leaves it, and meets it: the others grow as differences say."""
    law = vi.Spring(20.0, 1.0, release=release, preload=1.0)
    system = vi.LinearSystem(np.eye(2), 0.1 * np.eye(2), [[2.0, -1.0], [-1.0, 2.0]], load=[0.5, 0.0])
    scene = vi.Scene(system, vi.Harmonic([0.0, 1.5], 0.7), vi.Stop(0, 0.05, contact=law))
    run = vi.simulate(scene, [0.05, 0.0], [0.0, 0.0], (0, 12))
    (seated, *_), *_ = passed = states(run)
    assert seated == "seated"
    assert {("free",), ("pressed",)} <= set(passed)

    def last(x, end):
        other = vi.simulate(scene, [0.05, x[0]], [0.0, x[1]], (0, end))
        return np.concatenate(other.final)

    volumes, grown = [], []
    for end in (0.5 * run.regimes["end"][0], run.regimes["end"][-2] - 1e-3, 12.0):
        beside = np.transpose([(last(e, end) - last(-e, end)) / 2e-6 for e in 1e-6 * np.eye(2)])
        volumes.append(0.5 * np.linalg.slogdet(beside.T @ beside)[1])
        found = vi.lyapunov_exponents(scene, [0.05, 0.0], [0.0, 0.0], (0, end))
        assert (found.exponents[2:] == -np.inf).all()
        grown.append(found.exponents[:2].sum() * end)
    assert np.diff(grown) == pytest.approx(np.diff(volumes), abs=1e-6)


def test_what_takes_no_springs_says_so():
    """Scenes that are integrated are refused."""
    scene = vi.Scene(OSCILLATOR, vi.Harmonic([1.0], 0.8), vi.Stop(0, 0.5, contact=vi.Spring(20.0)))
    with pytest.raises(ValueError, match="lyapunov_exponents without exact flights does not take stops that give way"):
        vi.lyapunov_exponents(scene, 0.0, 0.3, (0, 50), method="dop853")
