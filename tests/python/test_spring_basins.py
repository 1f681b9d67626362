"""Attractors and basins of scenes with stops that give way."""

import numpy as np
import pytest

import vibroimpact as vi

FREQUENCY = 0.8
PERIOD = 2 * np.pi / FREQUENCY
BOX = [(-3.0, 3.0), (-3.0, 3.0)]
SYSTEM = vi.LinearSystem(1.0, 0.02, 1.0)
FORCE = vi.Harmonic([0.7 * FREQUENCY**2], FREQUENCY)


def scene(law, *more):
    """Return a lightly damped oscillator before a stop that gives way."""
    return vi.Scene(SYSTEM, FORCE, [vi.Stop(0, 1.26, contact=law), *more])


ELASTIC = scene(vi.Spring(29.0))


def ended(own, attractors, q0, v0, start=0.0):
    """Return the labels of what motions from a state and from beside it settle on."""
    labels = set()
    for off in (0.0, 1e-12, -1e-9, 1e-8, 1e-7):
        run = vi.simulate(own, q0, v0 + off, (start, 1500 * PERIOD), keep="final")
        state = np.concatenate(run.final)
        near = [abs(one.points - state).max(axis=1).min() < 1e-2 for one in attractors]
        labels.add(near.index(True) + 1 if True in near else 0)
    return labels


@pytest.fixture(scope="module")
def found():
    return vi.find_attractors(ELASTIC, BOX, seeds=40)


def test_attractors_are_orbits_that_find_orbit_closes(found):
    """One hits nothing and is the steady response; the other is admissible and stable."""
    assert [one.kind for one in found] == ["periodic", "periodic"]
    assert sorted(one.n_periods for one in found) == [1, 5]
    free = next(one for one in found if one.n_periods == 1)
    # x = Re(F e^{i w t}/(1 - w^2 + 0.02 i w)) never comes to the stop.
    steady = 0.7 * FREQUENCY**2 / (1 - FREQUENCY**2 + 0.02j * FREQUENCY)
    assert free.points[0] == pytest.approx([steady.real, -FREQUENCY * steady.imag], abs=1e-9)
    for one in found:
        assert one.orbit.is_stable
        assert one.orbit.is_admissible
        run = vi.simulate(ELASTIC, one.points[0, :1], one.points[0, 1:], (0, one.n_periods * PERIOD))
        assert np.concatenate(run.final) == pytest.approx(one.points[0], abs=1e-8)


@pytest.mark.parametrize(
    "own",
    [
        ELASTIC,
        scene(vi.Spring(29.0, 0.4, release="gap")),
        scene(vi.Spring(29.0, 0.4, release="clipped", preload=0.2)),
        scene(vi.Spring(29.0, 0.1, release="clipped"), vi.Stop(0, 1.4, 0.8, side="lower")),
        scene(vi.Spring(29.0, release="force")),
        scene(vi.Spring(29.0, 0.4, release="force")),
        # Its place comes back in some periods alone.
        scene(vi.Spring(4.0, 6.0, release="force")),
    ],
    ids=["elastic", "gap", "clipped", "rigid beside", "force without a dashpot", "relaxing", "slowly relaxing"],
)
def test_each_cell_is_where_its_motion_ends(own):
    """A long simulation from the cell comes to the attractor that its label names; inside is inside of rigid stops alone."""
    attractors = vi.find_attractors(own, BOX, seeds=30)
    plane = vi.basins(own, q=(-3, 3, 7), v=(-3, 3, 7), attractors=attractors, hits=30)
    lower = own.stops[1].clearance if len(own.stops) > 1 else np.inf
    assert np.array_equal(plane.labels == -2, np.broadcast_to(plane.x < -lower, plane.labels.shape))
    n_sure = 0
    # Those that wander about for long are in the hand of rounding.
    for j, i in np.argwhere((plane.labels > 0) & (plane.iterations < 150)):
        ends = ended(own, attractors, plane.x[i], plane.y[j])
        if len(ends) == 1 and 0 not in ends:  # else rounding decides
            n_sure += 1
            assert ends == {plane.labels[j, i]}
    assert n_sure > 4


def test_states_at_the_beginning_of_a_contact(found):
    """With `impact` a stop that gives way is met with the speeds."""
    plane = vi.basins(
        ELASTIC, impact={"stop": 0, "phase": (0.0, 2 * np.pi, 4), "speed": (0.5, 3.0, 3)}, attractors=found, box=BOX, hits=30
    )
    for j, i in np.argwhere(plane.iterations < 150):
        start = plane.x[i] / FREQUENCY
        assert vi.simulate(ELASTIC, 1.26, plane.y[j], (start, start + 1.0)).contacts["start"][0] == start
        ends = ended(ELASTIC, found, 1.26, plane.y[j], start)
        assert len(ends) > 1 or 0 in ends or ends == {plane.labels[j, i]}


def test_chaos_of_a_soft_stop_is_one_attractor():
    """It is told by its exponents, whose sum is what the dashpots take."""
    chaotic = vi.Scene(
        vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([3.0], 2.4), vi.Stop(0, 0.5, contact=vi.Spring(20.0, 0.5, release="gap"))
    )
    one = vi.find_attractors(chaotic, [(-3, 3), (-6, 6)], seeds=6)[0]
    if one.kind == "chaotic":
        assert one.exponents[0] > 0.0
    else:
        assert one.orbit is not None


def test_an_attractor_of_stops_that_relax_is_one_from_every_seed():
    """Where a place is not back within a period a state says not all: the motion that goes on has it."""
    slow = scene(vi.Spring(4.0, 6.0, release="force"))
    for one in vi.find_attractors(slow, BOX, seeds=20):
        assert one.kind == "periodic"
        assert one.orbit.is_stable
        # From a state at which nothing is known of the place it comes back to itself, once that is forgotten.
        run = vi.simulate(slow, one.points[0, :1], one.points[0, 1:], (0, 400 * one.n_periods * PERIOD), keep="final")
        assert np.concatenate(run.final) == pytest.approx(one.points[0], abs=1e-6)


def test_equations_of_ones_own_are_refused():
    """What is not linear is not taken yet."""
    system = vi.NonlinearSystem(1, lambda t, q, v: -q, mass=[[1.0]])
    nonlinear = vi.Scene(system, FORCE, vi.Stop(0, 1.26, contact=vi.Spring(29.0)))
    with pytest.raises(ValueError, match="find_attractors of a scene that is not linear does not take stops that give way"):
        vi.find_attractors(nonlinear, BOX, seeds=2)
