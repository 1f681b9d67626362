"""Every orbit with one contact in the period with a stop that gives way, by the equation in its duration."""

import os

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

import vibroimpact as vi

#: A soak asks for more scenes, at a seed of its own.
COUNT = int(os.environ.get("VIBROIMPACT_SOAK_ONE_CONTACT", "12"))
SEED = int(os.environ.get("VIBROIMPACT_SOAK_ONE_CONTACT_SEED", "0"))
RELEASES = ["gap", "force", "clipped"]


def soft(release="gap", damping=0.5, stiffness=20.0, **more):
    """Return a forced oscillator before a stop that gives way."""
    system = vi.LinearSystem(1.0, 0.1, 1.0)
    law = vi.Spring(stiffness, damping, release=release, **more)
    return vi.Scene(system, vi.Harmonic([1.0], 0.8), [vi.Stop(0, 0.5, contact=law)])


def duration(orbit):
    """Return how long the contact of an orbit lasts, admissible or not."""
    return orbit.segments["end"][0]


class Twin:
    """The same conditions written out with matrix exponentials of the enlarged system (x, 1, cos, sin)."""

    def __init__(self, mass, damping, stiffness, force, frequency, stop, n_periods=1):
        """Take a system, its force, and a stop (normal, clearance, k, c, preload, release)."""
        n = len(mass)
        normal, clearance, k, c, preload, self.release = stop
        self.period = 2 * np.pi * n_periods / frequency
        self.k, self.c = k, c
        inverse = np.linalg.inv(mass)
        self.approach = np.concatenate([normal, np.zeros(n), [-clearance, 0, 0]])
        speed = np.concatenate([np.zeros(n), normal, [0, 0, 0]])
        self.force = k * self.approach + c * speed
        self.force[2 * n] += preload
        self.free = np.zeros((2 * n + 3, 2 * n + 3))
        self.free[:n, n : 2 * n] = np.eye(n)
        self.free[n : 2 * n, :n] = -inverse @ stiffness
        self.free[n : 2 * n, n : 2 * n] = -inverse @ damping
        self.free[n : 2 * n, 2 * n + 1] = inverse @ force
        self.free[2 * n + 1, 2 * n + 2], self.free[2 * n + 2, 2 * n + 1] = -frequency, frequency
        push = np.concatenate([np.zeros(n), inverse @ normal, [0, 0, 0]])
        self.pressed = self.free - np.outer(push, self.force)
        self.n = n

    def conditions(self, tau, during=None, after=None):
        """Return the equations for (x, cos, sin) and their right-hand side."""
        m = 2 * self.n
        during = expm(self.pressed * tau) if during is None else during
        after = expm(self.free * (self.period - tau)) if after is None else after
        whole = after @ during
        begun = self.approach.copy()
        if self.release == "force" and self.c > 0:
            begun -= np.exp(-self.k / self.c * (self.period - tau)) * (self.approach @ during)
        at_gap = self.release == "gap" or self.c == 0
        ended = (self.approach if at_gap else self.force) @ during
        rows = np.vstack([(whole - np.eye(m + 3))[:m], begun, ended])
        return rows[:, [*range(m), m + 1, m + 2]], -rows[:, m]

    def roots(self, count=3000):
        """Return the durations at which the function changes its sign, but for poles."""
        taus = np.linspace(0, self.period, count + 1)
        flows = []
        for matrix in (self.pressed, self.free):
            step, powers = expm(matrix * taus[1]), [np.eye(len(matrix))]
            for _ in range(count):
                powers.append(step @ powers[-1])
            flows.append(powers)
        taus = taus[1:-1]
        values = np.array([self.misfit(tau, flows[0][k], flows[1][count - k]) for k, tau in enumerate(taus, 1)])
        found = []
        for k in np.flatnonzero(values[1:] * values[:-1] < 0):
            found.append(brentq(self.misfit, *taus[k : k + 2], xtol=1e-14))
        return np.array(found)

    def misfit(self, tau, *flows):
        """Return |u|^2 - 1 over 1 + |u|^2: a pole is no change of its sign."""
        matrix, right = self.conditions(tau, *flows)
        u = np.linalg.solve(matrix, right)[-2:]
        square = u @ u
        return (square - 1) / (square + 1)


def check(orbits, twin):
    """Compare durations; what the grid of the twin does not tell apart, two roots at a time, is a root all the same."""
    own, wanted = np.sort([duration(orbit) for orbit in orbits]), twin.roots()
    missed = [tau for tau in wanted if np.abs(own - tau).min(initial=np.inf) > 1e-7]
    assert not missed
    more = [tau for tau in own if np.abs(wanted - tau).min(initial=np.inf) > 1e-7]
    assert len(more) % 2 == 0
    assert [abs(twin.misfit(tau)) < 1e-6 for tau in more] == len(more) * [True]


def test_the_orbit_of_the_reference_is_one_of_fourteen():
    """Fourteen durations solve the conditions, and one of them is an orbit (G12)."""
    orbits = vi.periodic_orbits(soft(), [0])
    assert orbits.verdict == "found"
    assert len(orbits) == 14
    assert "every other" in orbits.reason
    assert [orbit.is_admissible for orbit in orbits] == [True] + 13 * [False]
    orbit = orbits[0]
    assert duration(orbit) == pytest.approx(0.717564511587882, abs=1e-13)
    assert (orbit.phase + np.pi) % (2 * np.pi) - np.pi == pytest.approx(-0.344549609996941, abs=1e-13)
    assert orbit.v0[0] == pytest.approx(1.72476106976695, abs=1e-13)
    assert np.trace(orbit.monodromy) == pytest.approx(-0.459960372668123, abs=1e-12)
    assert np.linalg.det(orbit.monodromy) == pytest.approx(0.318484834913009, abs=1e-12)
    assert orbit.is_stable is True


@pytest.mark.parametrize("release", RELEASES)
def test_an_orbit_is_that_of_a_search_from_a_run(release):
    """The admissible one is where a simulation settles; contacts, signature and multipliers agree."""
    scene = soft(release)
    (own,) = [orbit for orbit in vi.periodic_orbits(scene, [0]) if orbit.is_admissible]
    run = vi.simulate(scene, 0.0, 0.3, (0, 60 * own.period))
    found = vi.find_orbit(scene, run)
    assert own.signature == found.signature
    assert own.v0 == pytest.approx(found.v0, abs=1e-12)
    for name in own.contacts.dtype.names:
        assert own.contacts[name] == pytest.approx(found.contacts[name], abs=1e-11)
    assert np.sort_complex(own.floquet_multipliers) == pytest.approx(np.sort_complex(found.floquet_multipliers), abs=1e-11)


@pytest.mark.parametrize("release", RELEASES)
@pytest.mark.parametrize("damping", [0.0, 0.5, 8.0])
def test_durations_are_those_of_the_twin(release, damping):
    """No root is lost and none invented, by matrix exponentials on a fine grid."""
    scene = soft(release, damping)
    one = np.array([[1.0]])
    twin = Twin(one, 0.1 * one, one, np.array([1.0]), 0.8, (np.array([1.0]), 0.5, 20.0, damping, 0.0, release))
    check(vi.periodic_orbits(scene, [0]), twin)


@pytest.mark.parametrize("seed", range(SEED, SEED + COUNT))
def test_random_scenes_have_the_durations_of_the_twin(seed):
    """One to four coordinates, any law; the library may tell two roots apart that the grid of the twin does not."""
    rng = np.random.default_rng([seed, 59])
    n = int(rng.integers(1, 5))
    root = rng.normal(size=(n, n)) / np.sqrt(n) + np.eye(n)
    mass = root @ root.T
    root = rng.normal(size=(n, n)) / np.sqrt(n) + np.eye(n)
    stiffness = root @ root.T
    damping = 0.05 * stiffness + rng.uniform(0, 0.1) * np.diag(rng.uniform(size=n))
    force, normal = rng.normal(size=n), rng.normal(size=n)
    frequency, clearance = rng.uniform(0.5, 2.0), rng.uniform(-0.2, 0.6)
    k, c = 10 ** rng.uniform(0, 2.5), rng.choice([0.0, 10 ** rng.uniform(-2, 1)])
    release = RELEASES[rng.integers(3)]
    law = vi.Spring(k, c, release=release)
    scene = vi.Scene(
        vi.LinearSystem(mass, damping, stiffness),
        vi.Harmonic(force, frequency),
        [vi.Stop(normal, clearance, contact=law)],
    )
    n_periods = int(rng.integers(1, 3))
    twin = Twin(mass, damping, stiffness, force, frequency, (normal, clearance, k, c, 0.0, release), n_periods)
    orbits = vi.periodic_orbits(scene, [0], n_periods)
    assert "every other" in orbits.reason
    check(orbits, twin)


def test_a_given_phase_gives_the_clearance():
    """The phases and clearances of the orbits found at one clearance are found again the other way round."""
    for release in RELEASES:
        scene = soft(release)
        orbit = vi.periodic_orbits(scene, [0])[0]
        others = vi.periodic_orbits(scene.replace(clearance=7.0), [0], phase=orbit.phase)
        assert "every other" in others.reason
        clearances = np.array([other.scene.stops[0].clearance for other in others])
        same = others[int(np.abs(clearances - 0.5).argmin())]
        assert same.scene.stops[0].clearance == pytest.approx(0.5, abs=1e-11)
        assert same.v0 == pytest.approx(orbit.v0, abs=1e-11)
        assert same.phase == pytest.approx(orbit.phase, abs=1e-12)
        assert same.is_admissible is True


class TestTheSymmetricOrbit:
    """Two stops that are each other's images."""

    @staticmethod
    def scene(release="gap", stiffness=20.0, **more):
        """Return an oscillator between two equal stops."""
        law = vi.Spring(stiffness, 0.5, release=release, **more)
        stops = [vi.Stop(0, 0.5, contact=law), vi.Stop(0, 0.5, contact=law, side="lower")]
        return vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], 0.8), stops)

    @pytest.mark.parametrize("release", RELEASES)
    def test_it_is_where_a_run_settles(self, release):
        """Contacts, multipliers and motion agree; half a period later all is opposite."""
        scene = self.scene(release)
        orbits = vi.periodic_orbits(scene, [0, 1])
        assert "every other" in orbits.reason
        (own,) = [orbit for orbit in orbits if orbit.is_admissible]
        found = vi.find_orbit(scene, vi.simulate(scene, 0.0, 0.3, (0, 60 * own.period)))
        first = found.contacts["stop"][0]
        t = np.linspace(0, own.period, 40) + (0.5 * own.period if first == 1 else 0.0)
        assert own.position(t % own.period) == pytest.approx(found.position(np.linspace(0, own.period, 40)), abs=1e-10)
        assert own.position(t % own.period) == pytest.approx(-own.position((t + 0.5 * own.period) % own.period), abs=1e-12)
        assert np.sort_complex(own.floquet_multipliers) == pytest.approx(np.sort_complex(found.floquet_multipliers), abs=1e-10)

    def test_a_given_phase_gives_both_clearances(self):
        """The clearance is that of both stops."""
        own = vi.periodic_orbits(self.scene(), [0, 1])[0]
        others = vi.periodic_orbits(self.scene().replace(clearance=3.0), [0, 1], phase=own.phase)
        best = min(others, key=lambda other: abs(other.scene.stops[0].clearance - 0.5))
        assert [stop.clearance for stop in best.scene.stops] == pytest.approx([0.5, 0.5], abs=1e-11)
        assert best.v0 == pytest.approx(own.v0, abs=1e-11)

    def test_scenes_that_are_not_odd_are_refused(self):
        """Unequal stops, a load, an even number of periods."""
        law = vi.Spring(20.0, 0.5, release="gap")
        other = self.scene().replace(**{"clearance[0]": 0.6})
        loaded = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0, load=0.1), vi.Harmonic([1.0], 0.8), self.scene().stops)
        uneven = vi.Scene(self.scene().system, self.scene().forcing, [self.scene().stops[0], vi.Stop(0, 0.7, contact=law)])
        for scene, periods in ((other, 1), (loaded, 1), (uneven, 1), (self.scene(), 2)):
            with pytest.raises(ValueError, match=r"each other's images.*find_orbit"):
                vi.periodic_orbits(scene, [0, 1], periods)


def check_admissible(scene, n_periods=1):
    """Compare admissible orbits, of which there is one at least, with a search and a run that begin at them."""
    orbits = vi.periodic_orbits(scene, [0], n_periods)
    assert "every other" in orbits.reason
    admissible = [orbit for orbit in orbits if orbit.is_admissible]
    assert admissible
    for own in admissible:
        found = vi.find_orbit(scene, own)
        assert found.is_admissible is True
        assert found.v0 == pytest.approx(own.v0, abs=1e-9)
        assert duration(found) == pytest.approx(duration(own), rel=1e-6, abs=1e-11)
        multipliers = [np.sort_complex(orbit.floquet_multipliers) for orbit in (own, found)]
        assert multipliers[0] == pytest.approx(multipliers[1], abs=1e-6)
        run = vi.simulate(own.scene, own.q0, own.v0, (0, own.period))
        t = np.linspace(0, own.period, 30)
        assert run.position(t) == pytest.approx(own.position(t), abs=1e-9)
    return admissible


@pytest.mark.parametrize("release", RELEASES)
def test_a_preload_a_moving_stop_and_a_body_that_nothing_else_holds(release):
    """Each orbit is that of a run from its beginning."""
    law = vi.Spring(20.0, 0.5, release=release, preload=0.2)
    oscillator = vi.LinearSystem(1.0, 0.1, 1.0)
    check_admissible(vi.Scene(oscillator, vi.Harmonic([1.0], 0.8), [vi.Stop(0, 0.5, contact=law)]))
    law = vi.Spring(20.0, 0.5, release=release)
    moving = vi.Stop(0, 0.5, contact=law, motion=vi.Harmonic(0.1, 0.8, 0.7))
    check_admissible(vi.Scene(oscillator, vi.Harmonic([1.0], 0.8), [moving]))
    ball = vi.LinearSystem([[1.0]], [[0.0]], [[0.0]], load=[1.0])
    for amplitude, frequency, n_periods in ((4.0, 1.9, 1), (4.0, 1.9, 2), (1.0, 1.2, 1), (2.0, 2.0, 2)):
        bounced = vi.Scene(ball, vi.Harmonic([amplitude], frequency), [vi.Stop(0, 0.0, contact=law)])
        check_admissible(bounced, n_periods)


@pytest.mark.parametrize("off", [-1e-6, -1e-12, 0.0, 1e-12, 1e-6])
def test_pressed_regimes_without_modes(off):
    """Critical damping of the pressed system, and beside it."""
    critical = 2 * np.sqrt(21.0) - 0.1
    for release in RELEASES:
        check_admissible(soft(release, critical * (1 + off)).replace(frequency=1.2))


@pytest.mark.parametrize("stiffness", [1e-6, 1e-2, 1e4, 1e6, 1e8])
@pytest.mark.parametrize("clearance", [0.0, 0.2])
def test_soft_and_stiff_stops(stiffness, clearance):
    """From hardly a stop to nearly a rigid one, in the middle too, where conditions have no right-hand side."""
    law = vi.Spring.from_restitution(0.7, stiffness, 1.0, release="gap")
    scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], 2.2), [vi.Stop(0, clearance, contact=law)])
    (own,) = check_admissible(scene)
    if stiffness > 1.0:
        rigid = vi.Scene(scene.system, scene.forcing, [vi.Stop(0, clearance, 0.7)])
        (limit,) = [orbit for orbit in vi.periodic_orbits(rigid, [0]) if orbit.is_admissible]
        assert -own.contacts["speed_after"][0] / own.contacts["speed_before"][0] == pytest.approx(
            -0.7, abs=30 / np.sqrt(stiffness)
        )
        assert own.velocity(0.5 * own.period) == pytest.approx(limit.velocity(0.5 * own.period), abs=30 / np.sqrt(stiffness))


def test_stops_that_stand_by_are_guarded():
    """One that the motion passes makes an orbit inadmissible, one beyond its reach does not; rigid patterns stay as they are."""
    scene = soft()
    orbit = vi.periodic_orbits(scene, [0])[0]
    lowest = orbit.position(np.linspace(0, orbit.period, 999)).min()
    for beyond, admissible in ((0.1, True), (-0.1, False)):
        for law in (vi.Spring(5.0), vi.Newton(0.8)):
            more = vi.Stop(0, beyond - lowest, contact=law, side="lower")
            both = vi.Scene(scene.system, scene.forcing, [*scene.stops, more])
            (same,) = [own for own in vi.periodic_orbits(both, [0]) if abs(duration(own) - duration(orbit)) < 1e-9]
            assert same.is_admissible is admissible
    rigid = vi.Scene(scene.system, scene.forcing, [vi.Stop(0, 0.5, 0.8), vi.Stop(0, 3.0, contact=vi.Spring(5.0))])
    alone = vi.Scene(scene.system, scene.forcing, [vi.Stop(0, 0.5, 0.8)])
    own, wanted = vi.periodic_orbits(rigid, [0]), vi.periodic_orbits(alone, [0])
    assert [orbit.phase for orbit in own] == [orbit.phase for orbit in wanted]


def test_other_patterns_are_refused_by_name():
    """What is asked for has to be one contact, or two that are images."""
    law = vi.Spring(20.0, 0.5, release="gap")
    stops = [vi.Stop(0, 0.5, contact=law), vi.Stop(0, 0.7, contact=law), vi.Stop(0, 0.9, 0.8)]
    scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], 0.8), stops)
    for pattern in ([0, 0], [(0, 1)], [0, 2], [0, 1, 0]):
        with pytest.raises(ValueError, match=r"pattern.*find_orbit"):
            vi.periodic_orbits(scene, pattern)
    two = vi.Scene(scene.system, [vi.Harmonic([1.0], 0.8), vi.Harmonic([0.2], 1.6)], stops[:1])
    with pytest.raises(ValueError, match=r"harmonics.*find_orbit"):
        vi.periodic_orbits(two, [0])
    with pytest.raises(ValueError, match="free"):
        vi.periodic_orbits(soft(), [0], free="forcing_scale")


def test_an_existence_map_is_the_orbits_of_its_points():
    """Counts and verdicts of a few cells."""
    frequencies, clearances = np.linspace(0.6, 1.4, 4), np.array([0.2, 0.5])
    found = vi.existence_map(soft(), [0], ("frequency", frequencies), ("clearance", clearances))
    for j, clearance in enumerate(clearances):
        for i, frequency in enumerate(frequencies):
            orbits = vi.periodic_orbits(soft().replace(frequency=frequency, clearance=clearance), [0])
            assert found.n_orbits[j, i] == len(orbits)
            assert found.is_admissible[j, i] == any(orbit.is_admissible for orbit in orbits)
