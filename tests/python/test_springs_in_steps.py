"""Stops that give way, in steps: beside exact flights and an exact twin, and beside equations written down anew."""

import numpy as np
import pytest
from contact_referee import difference, some_case
from scipy.integrate import solve_ivp

import vibroimpact as vi

STEPS = ["rk45", "dop853", "radau"]
RELEASES = ["gap", "force", "clipped"]
OSCILLATOR = vi.LinearSystem(1.0, 0.1, 1.0)
FORCE = vi.Harmonic([1.0], 0.8)

#: Of an oscillator between stops that relax, at 0.5 (k = 20, c = 0.5) and -0.9 (k = 35, c = 0.5): x, v at t = 20, 8th event.
RELAXING = (-0.811734034490746, 0.855229864438667, 12.4640447156383)


def nonlinear(n_dof=1):
    """Return the oscillator as equations of its own."""
    return vi.NonlinearSystem(
        n_dof,
        lambda t, q, v: np.cos(0.8 * t) * np.eye(n_dof)[0] - q - 0.1 * v,
        mass=np.eye(n_dof),
        potential=lambda q: 0.5 * (q @ q),
    )


def between(release, system=OSCILLATOR, force=FORCE):
    """Return an oscillator between two stops that give way."""
    upper = vi.Stop(0, 0.5, contact=vi.Spring(20, 0.5, release=release))
    lower = vi.Stop(0, 0.9, contact=vi.Spring(35, 0.5, release=release), side="lower")
    return vi.Scene(system, force, [upper, lower])


def plane(clearance, normal, law, motion=None):
    """Return a plane as any gap."""
    normal = np.asarray(normal, float)
    return vi.NonlinearStop(lambda q: clearance - normal @ q, lambda q: -normal, contact=law, curvature=0.0, motion=motion)


@pytest.mark.parametrize("method", STEPS)
def test_relaxing_stops_end_where_the_reference_says(method):
    """The reference is known to 14 digits; a run ends there to its tolerance."""
    x, v, at = RELAXING
    for scene in (between("force"), between("force", nonlinear(), None)):
        run = vi.simulate(scene, 0.0, 0.3, (0, 20), method=method, rtol=1e-11, atol=1e-13)
        assert run.final[0][0] == pytest.approx(x, abs=1e-9)
        assert run.final[1][0] == pytest.approx(v, abs=1e-9)
        ends = np.sort(np.concatenate([run.contacts["start"], run.contacts["end"]]))
        assert ends[7] == pytest.approx(at, abs=1e-9)
        assert len(ends) == 14


@pytest.mark.parametrize("method", STEPS)
@pytest.mark.parametrize("release", RELEASES)
def test_the_tables_of_steps_are_those_of_exact_flights(method, release):
    """Contacts, regimes and the energy, in the same rows."""
    scene = between(release)
    exact = vi.simulate(scene, 0.0, 0.3, (0, 20))
    run = vi.simulate(scene, 0.0, 0.3, (0, 20), method=method, rtol=1e-11, atol=1e-13)
    assert np.array_equal(run.contacts["stop"], exact.contacts["stop"])
    for name in ("start", "end", "speed_before", "speed_after", "impulse", "peak_force", "peak_approach", "loss"):
        assert run.contacts[name] == pytest.approx(exact.contacts[name], abs=1e-8, nan_ok=True)
    assert np.array_equal(run.regimes["state"], exact.regimes["state"])
    assert run.regimes["end"] == pytest.approx(exact.regimes["end"], abs=1e-9)
    assert np.abs(run.energy.balance).max() < 1e-9
    assert run.energy.contact_loss[-1] == pytest.approx(exact.energy.contact_loss[-1], abs=1e-8)


def has_preload(twin):
    """Whether some stop of a scene has a preload."""
    return any(stop.preload > 0.0 for stop in twin.stops)


@pytest.mark.parametrize("preloaded", [False, True])
def test_random_scenes_in_steps_move_as_the_twin_says(preloaded):
    """Contacts, regimes and ends of random scenes of all releases, beside rigid stops and moving ones, are those of the twin."""
    wrong, count = [], 0
    for number in range(60):
        case = some_case(7, number, lambda twin: has_preload(twin) is preloaded)
        scene = case.twin.scene()
        options = {"method": "dop853", "rtol": 1e-12, "atol": 1e-14}
        run = vi.simulate(scene, case.q0, case.v0, (0, case.end), **options)
        # Steps are known to their tolerance, which the run amplifies.
        found = difference(case.twin, case.run, run, case.end, max(case.amplification, 1.0) * 100.0)
        count += 1
        if found:
            wrong.append(f"7 {number}: {found}")
    assert not wrong, "\n".join(wrong)
    assert count == 60


@pytest.mark.parametrize("method", STEPS)
@pytest.mark.parametrize("release", RELEASES)
def test_a_stop_moves_against_a_body_that_is_held(method, release):
    """The force of a stop that moves begins and ends though the body does not move: it is that of the held motion."""
    soft = vi.Stop(0, 0.0, contact=vi.Spring(10.0, 2.0, release=release), motion=vi.Harmonic([0.1], 2.0))
    hard = vi.Stop(0, -0.05, 0.0, side="lower")
    scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0, load=[-20.0]), None, [soft, hard])
    exact = vi.simulate(scene, 0.4, 0.0, (0, 12))
    run = vi.simulate(scene, 0.4, 0.0, (0, 12), method=method, rtol=1e-10, atol=1e-12)
    assert run.status == "finished"
    assert len(run.contacts) == len(exact.contacts) >= 4
    assert np.array_equal(run.regimes["state"], exact.regimes["state"])
    assert run.regimes["start"] == pytest.approx(exact.regimes["start"], abs=1e-8)


@pytest.mark.parametrize("method", STEPS)
def test_a_place_comes_back_to_a_body_that_is_held(method):
    """A stop that relaxes meets a body that another one holds inside it."""
    soft = vi.Stop(0, 0.0, contact=vi.Spring(10.0, 2.0, release="force"))
    hard = vi.Stop(0, -0.05, 0.0, side="lower")
    scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0, load=[-20.0]), None, [soft, hard])
    exact = vi.simulate(scene, 0.4, 0.0, (0, 3))
    run = vi.simulate(scene, 0.4, 0.0, (0, 3), method=method, rtol=1e-10, atol=1e-12)
    assert list(exact.regimes["state"][-1]) == ["pressed", "held"]
    assert np.array_equal(run.regimes["state"], exact.regimes["state"])
    assert run.regimes["start"] == pytest.approx(exact.regimes["start"], abs=1e-9)
    assert run.contact_force(1, 2.0) == pytest.approx(exact.contact_force(1, 2.0), rel=1e-9)


@pytest.mark.parametrize("method", STEPS)
@pytest.mark.parametrize("release", RELEASES)
@pytest.mark.parametrize("moves", [False, True])
def test_any_surface_gives_way_alike(method, release, moves):
    """A plane that is given as any gap is the plane, at rest or in motion, beside a rigid stop."""
    law = vi.Spring(30.0, 1.5, release=release)
    motion = vi.Harmonic([0.15], 0.8, 0.4) if moves else None
    rigid = vi.Stop(1, 0.6, 0.5)
    masses = vi.LinearSystem([[1, 0.2], [0.2, 0.7]], [[0.1, -0.03], [-0.03, 0.08]], [[3, -1], [-1, 2]])
    force = vi.Harmonic([1.0, 2.0], 0.8)
    exact = vi.simulate(
        vi.Scene(masses, force, [vi.Stop([0.6, -0.8], 0.1, contact=law, motion=motion), rigid]), [0, 0], [0.3, 0.2], (0, 7)
    )
    scene = vi.Scene(masses, force, [plane(0.1, [0.6, -0.8], law, motion), rigid])
    run = vi.simulate(scene, [0, 0], [0.3, 0.2], (0, 7), method=method, rtol=1e-11, atol=1e-13)
    own, known = (each.contacts[each.contacts["stop"] == 0] for each in (run, exact))
    assert len(own) == len(known) >= 2
    for name in ("start", "end", "impulse", "peak_force"):
        assert own[name] == pytest.approx(known[name], abs=1e-7, nan_ok=True)
    assert run.final[0] == pytest.approx(exact.final[0], abs=1e-8)


def clipped_ring(t, x):
    """Return the rates of a body in a ring of radius 1 that pushes by max(0, 50 p + 3 p')."""
    q, v = x[:2], x[2:]
    radius = np.hypot(*q)
    p, rate = radius - 1.0, q @ v / radius
    force = max(0.0, 50.0 * p + 3.0 * rate) if p > 0.0 else 0.0
    return [*v, *(np.array([0.8 * np.cos(1.1 * t), 0.0]) - np.array([0.1, 0.3]) * q - force * q / radius)]


@pytest.mark.parametrize("method", ["dop853", "rk45"])
def test_a_ring_gives_way(method):
    """A body that flies in a ring, beside the equations written down anew."""
    ring = vi.NonlinearStop(
        lambda q: 1.0 - np.hypot(*q), lambda q: -q / np.hypot(*q), contact=vi.Spring(50.0, 3.0, release="clipped")
    )
    body = vi.LinearSystem(np.eye(2), np.zeros((2, 2)), np.diag([0.1, 0.3]))
    scene = vi.Scene(body, vi.Harmonic([0.8, 0.0], 1.1), [ring])
    run = vi.simulate(scene, [0.5, 0.0], [0.7, 0.4], (0, 8), method=method, rtol=1e-11, atol=1e-13)
    known = solve_ivp(clipped_ring, (0, 8), [0.5, 0.0, 0.7, 0.4], method="DOP853", rtol=1e-11, atol=1e-12, max_step=2e-3)
    assert len(run.contacts) >= 3
    assert np.concatenate(run.final) == pytest.approx(known.y[:, -1], abs=1e-6)


@pytest.mark.parametrize("release", RELEASES)
def test_a_pendulum_before_a_wall_that_gives_way(release):
    """Taylor series between contacts, steps in them; the wall as any gap with steps alone."""
    pendulum = vi.DoublePendulum(0.7, 0.6, [0.02, 0.01])
    law = vi.Spring(80.0, 1.5, release=release)
    wall = vi.Scene(pendulum, None, [vi.Wall(1, 0.1, contact=law)])
    lengths = np.array([1.0, 1.0 / 0.6])
    any_gap = vi.NonlinearStop(lambda q: 0.1 - lengths @ np.sin(q), lambda q: -lengths * np.cos(q), contact=law, curvature=2.0)
    start = ([-0.9, -0.7], [0.0, 0.0])
    run = vi.simulate(wall, *start, (0, 12), method="taylor", rtol=1e-11, atol=1e-13)
    other = vi.simulate(vi.Scene(pendulum, None, [any_gap]), *start, (0, 12), method="dop853", rtol=1e-11, atol=1e-13)
    assert len(run.contacts) == len(other.contacts) >= 2
    assert run.final[0] == pytest.approx(other.final[0], abs=1e-7)
    assert np.array_equal(run.regimes["state"], other.regimes["state"])
    assert np.abs(run.energy.balance).max() < 1e-8


@pytest.mark.parametrize("method", STEPS)
def test_a_run_goes_on_where_its_stop_relaxes(method):
    """The place of the stop is a part of the state, and its way back is in no step."""
    scene = between("force", nonlinear(), None)
    options = {"method": method, "rtol": 1e-11, "atol": 1e-13}
    whole = vi.simulate(scene, 0.0, 0.3, (0, 12), **options)
    relaxing = whole.regimes[(whole.regimes["state"] == "relaxing").any(axis=1)][0]
    cut = relaxing["start"] + 0.3 * (relaxing["end"] - relaxing["start"])
    first = vi.simulate(scene, 0.0, 0.3, (0, cut), **options)
    second = vi.simulate(scene, first.state, (cut, 12), **options)
    assert second.final[0] == pytest.approx(whole.final[0], abs=1e-9)
    deep = whole.contacts["end"][0]
    place = whole.position(deep)[0] - 0.5
    assert first.state.remembered[0] == pytest.approx(place * np.exp(-40.0 * (cut - deep)), rel=1e-8)


@pytest.mark.parametrize("damping", [1e-9, 1e-4, 1e3])
def test_places_go_back_in_any_time(damping):
    """However fast or slow a place goes back beside the body, steps know it as exact flights do."""
    stop = vi.Stop(0, 0.2, contact=vi.Spring(40.0, damping, release="force"))
    scene = vi.Scene(OSCILLATOR, FORCE, [stop])
    exact = vi.simulate(scene, 0.0, 0.3, (0, 30))
    for method in STEPS:
        run = vi.simulate(scene, 0.0, 0.3, (0, 30), method=method, rtol=1e-10, atol=1e-12)
        assert run.status == "finished"
        assert run.final[0] == pytest.approx(exact.final[0], abs=1e-6)
        assert len(run.contacts) == len(exact.contacts)


def weighed(release, weight, preload, *, force=None, motion=None, any_gap=False):
    """Return a body of mass 1 that a weight pushes onto a preloaded stop."""
    law = vi.Spring(50.0, 2.0, release=release, preload=preload)
    stop = plane(0.3, [1.0], law, motion) if any_gap else vi.Stop(0, 0.3, contact=law, motion=motion)
    return vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0, load=[weight]), force, [stop])


@pytest.mark.parametrize("method", STEPS)
@pytest.mark.parametrize("any_gap", [False, True])
class TestAPreload:
    """A stop that gives way only under more than its preload, in steps."""

    @pytest.mark.parametrize(("weight", "state"), [(1.0, "seated"), (2.0, "seated"), (3.0, "pressed"), (-1.0, "free")])
    def test_a_body_at_its_seat_is_borne_by_no_more(self, method, any_gap, weight, state):
        """At rest on the seat: the weight is borne, presses the stop in, or draws the body away."""
        run = vi.simulate(weighed("force", weight, 2.0, any_gap=any_gap), 0.3, 0.0, (0, 0.1), method=method)
        assert run.regimes["state"][0, 0] == state
        if state == "seated":
            assert run.final[0][0] == 0.3
            assert run.contact_force(0, 0.05) == pytest.approx(weight, rel=1e-13)
            assert run.contacts["impulse"] == pytest.approx([0.1 * weight], rel=1e-12)

    @pytest.mark.parametrize("moves", [False, True])
    @pytest.mark.parametrize(
        ("phase", "state", "at"),
        [(-1.6, "pressed", (1.6 - np.arccos(0.8)) / 0.8), (1.6, "free", (np.arccos(-2 / 3) - 1.6) / 0.8)],
    )
    def test_a_seat_is_left_on_either_side(self, method, any_gap, moves, phase, state, at):
        """Borne is 1 + 1.5 cos(0.8 t + phase), of a force or of the stop's own acceleration: to the preload, 2.2, or to zero."""
        size = 1.5 / 0.64 if moves else 1.5
        wave = vi.Harmonic([size], 0.8, phase)
        beside = {"motion": wave} if moves else {"force": wave}
        scene = weighed("clipped", 1.0, 2.2, any_gap=any_gap, **beside)
        q0, v0 = (0.3 + size * np.cos(phase), -0.8 * size * np.sin(phase)) if moves else (0.3, 0.0)
        run = vi.simulate(scene, q0, v0, (0, at + 0.05), method=method, rtol=1e-10, atol=1e-12)
        assert list(run.regimes["state"][:, 0]) == ["seated", state]
        assert run.regimes["end"][0] == pytest.approx(at, rel=1e-9)

    @pytest.mark.parametrize("release", RELEASES)
    def test_low_bounces_end_at_the_seat(self, method, any_gap, release):
        """Low bounces lose what the law of low ones says, then the body is borne; the energy adds up."""
        scene = weighed(release, 1.0, 2.0, any_gap=any_gap)
        run = vi.simulate(scene, 0.0, 0.0, (0, 24), method=method, rtol=1e-6, atol=1e-6)
        speed = run.contacts["speed_before"]
        lost = (speed[:-1] - speed[1:]) / speed[:-1] ** 2
        low = (speed[:-1] < 2e-2) & (speed[:-1] > 5e-3)
        assert low.sum() > 10
        assert lost[low] == pytest.approx(2 / 3 * 2.0 / (2.0 - 1.0), rel=4e-2)
        assert run.regimes["state"][-1, 0] == "seated"
        assert run.final[0][0] == pytest.approx(0.3, abs=1e-12)
        assert np.abs(run.energy.balance).max() < 1e-4
