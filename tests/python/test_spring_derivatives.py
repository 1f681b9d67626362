"""Derivatives of runs that meet stops which give way, against differences of runs."""

import os

import numpy as np
import pytest
from contact_scenes import draw
from test_spring_exponents import states

import vibroimpact as vi

#: A soak asks for more scenes, at seeds of its own.
COUNT = int(os.environ.get("VIBROIMPACT_SOAK_SPRING_DERIVATIVES", "60"))
SEED = int(os.environ.get("VIBROIMPACT_SOAK_SPRING_DERIVATIVES_SEED", "7"))

SOFT = vi.Scene(
    vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], 0.8), vi.Stop(0, 0.5, contact=vi.Spring(20.0, 0.5, release="clipped"))
)


def numbers(twin):
    """Return the numbers of a random scene by which its run is derived, with their values."""
    found = {"damping_scale": 1.0}
    if twin.force is not None:
        found["frequency"] = twin.frequency
    for i, stop in enumerate(twin.stops):
        found[f"clearance[{i}]"] = stop.clearance
        if not stop.is_rigid:
            found[f"contact_stiffness[{i}]"] = stop.stiffness
            found |= {f"contact_damping[{i}]": stop.damping} if stop.damping > 0.0 else {}
            found |= {f"preload[{i}]": stop.preload} if stop.preload > 0.0 else {}
    return found


def difference(scene, start, times, number, own):
    """Return differences of runs by a number; none where runs beside are others, or differences not to be had."""
    name, value = number
    size = max(abs(value), 0.1)

    def at(offset):
        run = vi.simulate(scene.replace(**{name: value + offset}), *start, (0, times[-1]), t_eval=times)
        found = np.hstack([run.q, run.v])
        return found if states(run) == own else np.full_like(found, np.nan)

    def by(step):
        return (at(step) - at(-step)) / (2 * step)

    fine, coarse = by(1e-6 * size), by(3e-6 * size)
    is_sure = abs(fine - coarse).max() < 1e-5 * abs(fine).max()
    return fine + (fine - coarse) / 8 if is_sure else None


def compared(number):
    """Return how far derivatives of a random run are from differences, and what it goes through; none where it cannot be
    compared."""
    twin, q0, v0, end = draw(np.random.default_rng([SEED, number]))
    scene = twin.scene()
    if all(stop.is_rigid for stop in twin.stops):
        return None
    own = states(vi.simulate(scene, q0, v0, (0, end)))
    times = np.linspace(0.3, 1.0, 3) * end
    names = numbers(twin)
    run = vi.simulate(scene, q0, v0, (0, end), t_eval=times, derivatives=list(names))
    apart, count = 0.0, 0
    for name, value in names.items():
        found = run.derivatives[name]
        try:
            wanted = difference(scene, (q0, v0), times, (name, value), own)
        except ValueError:  # the start is inside a stop beside
            continue
        known = np.isfinite(found).all(axis=1)
        if wanted is None or not known.any():
            continue
        count += 1
        apart = max(apart, abs(found[known] - wanted[known]).max() / abs(wanted).max(initial=1e-3))
    return apart, {state for row in own for state in row} if count else set()


def test_random_runs_change_as_differences_say():
    """Of all releases, preloads and rigid stops beside, by the numbers of their laws and others."""
    seen, wrong, count = set(), [], 0
    for number in range(COUNT):
        found = compared(number)
        if found is None or not found[1]:
            continue
        count += 1
        seen |= found[1]
        if not found[0] < 1e-4:
            wrong.append((SEED, number, *found))
    assert not wrong
    assert count >= COUNT / 4
    assert seen >= {"pressed", "idle", "relaxing", "held"}


def test_a_free_body_is_given_back_as_its_formula_says():
    """A body of mass m meets a spring k at p = 0 with speed v and leaves pi sqrt(m/k) later with -v."""
    scene = vi.Scene(vi.LinearSystem(2.0, 0.0, 0.0), None, vi.Stop(0, 1.0, contact=vi.Spring(8.0)))
    names = ["clearance", "contact_stiffness"]
    run = vi.simulate(scene, 0.0, 0.5, (0, 6), t_eval=[2.5, 5.0], derivatives=names)
    # Within: q = c + (v/w) sin w (t - c/v), w = 2; behind: q = c - v (t - c/v - pi/w), dw/dk = w/(2 k).
    turn = 2.0 * (2.5 - 2.0)
    dw = 2.0 / 16.0
    by_clearance = [[1 - np.cos(turn), 2 * np.sin(turn)], [2.0, 0.0]]
    rate = 0.5 * (np.cos(turn) * 0.5 / 2.0 - np.sin(turn) / 4.0)
    by_stiffness = [[dw * rate, dw * 0.5 * -0.5 * np.sin(turn)], [dw * -0.5 * np.pi / 4.0, 0.0]]
    assert run.derivatives["clearance"] == pytest.approx(np.array(by_clearance), abs=1e-9)
    assert run.derivatives["contact_stiffness"] == pytest.approx(np.array(by_stiffness), abs=1e-9)


@pytest.mark.parametrize(
    ("scene", "start", "reason"),
    [
        (SOFT, (0.5, 0.3), "the run begins in contact"),
        (SOFT.replace(clearance=0.0), (0.0, 0.0), "the run begins in contact"),
    ],
)
def test_what_has_no_derivative_says_so(scene, start, reason):
    """One-sided derivatives are none."""
    run = vi.simulate(scene, *start, (0, 5), derivatives=["clearance"])
    assert np.isnan(run.derivatives["clearance"]).all()
    assert reason in run.message


def test_a_place_that_is_remembered_has_none_yet():
    """A relaxing stop that is met before it is back ends derivatives, with the reason."""
    scene = vi.Scene(SOFT.system, SOFT.forcing, vi.Stop(0, 0.1, contact=vi.Spring(2.0, 40.0, release="force")))
    run = vi.simulate(scene, 0.0, 0.3, (0, 40), derivatives="contact_damping")
    assert np.isnan(run.derivatives["contact_damping"]).all()
    assert "stop 0 is met before it is back at its place" in run.message


def test_scenes_that_are_integrated_are_refused():
    """They are said to be."""
    system = vi.NonlinearSystem(1, lambda t, q, v: np.cos(t) - q, mass=[[1.0]])
    scene = vi.Scene(system, None, vi.Stop(0, 0.5, contact=vi.Spring(20.0)))
    with pytest.raises(ValueError, match="derivatives= of a scene that is not linear does not take stops that give way"):
        vi.simulate(scene, 0.0, 0.3, (0, 5), derivatives="clearance")
