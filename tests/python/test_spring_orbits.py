"""Periodic motions with stops that give way."""

import os
import pickle

import numpy as np
import pytest

import vibroimpact as vi

OSCILLATOR = vi.LinearSystem(1.0, 0.1, 1.0)
RELEASES = ["gap", "force", "clipped"]

#: A soak asks for more orbits, at seeds of its own.
COUNT = int(os.environ.get("VIBROIMPACT_SOAK_SPRING_ORBITS", "40"))
SEED = int(os.environ.get("VIBROIMPACT_SOAK_SPRING_ORBITS_SEED", "0"))


def soft(release="gap", *more, force=1.0, damping=0.5):
    """Return a forced oscillator before a stop that gives way."""
    law = vi.Spring(20.0, damping, release=release)
    return vi.Scene(OSCILLATOR, vi.Harmonic([force], 0.8), [vi.Stop(0, 0.5, contact=law), *more])


def settled(scene, q0=0.0, v0=0.3, *, periods=60):
    """Return the orbit that a motion settles on."""
    scene_period = 2 * np.pi / scene.forcing.frequency
    return vi.find_orbit(scene, vi.simulate(scene, q0, v0, (0, periods * scene_period)))


def test_the_orbit_of_the_reference():
    """One contact a period: its duration, phase and speed, trace and determinant of the monodromy matrix."""
    orbit = settled(soft())
    contact = orbit.contacts[0]
    assert orbit.signature == (("press", "stop[0]"), ("leave", "stop[0]"))
    assert orbit.pattern == [0]
    assert contact["end"] - contact["start"] == pytest.approx(0.717564511587882, abs=1e-12)
    assert (orbit.phase + np.pi) % (2 * np.pi) - np.pi == pytest.approx(-0.344549609996941, abs=1e-12)
    assert orbit.v0[0] == pytest.approx(1.72476106976695, abs=1e-12)
    assert orbit.q0[0] == pytest.approx(0.5, abs=1e-14)
    monodromy = orbit.monodromy
    assert np.trace(monodromy) == pytest.approx(-0.459960372668123, abs=1e-11)
    assert np.linalg.det(monodromy) == pytest.approx(0.318484834913009, abs=1e-11)
    assert orbit.is_admissible is True
    assert orbit.is_stable is True


@pytest.mark.parametrize("release", RELEASES)
class TestAnOrbit:
    """An orbit of one soft stop by each release."""

    def test_its_multipliers_are_those_of_runs_beside_it(self, release):
        """The monodromy matrix is the difference of simulations over a period, from before the contact."""
        orbit = settled(soft(release))
        start = 0.6 * orbit.period  # in free flight, the same regime at both ends
        scene = orbit.scene.replace(phase=orbit.phase + 0.8 * start)
        x = np.array([orbit.position(start)[0], orbit.velocity(start)[0]])
        step = 1e-6

        def after(x):
            q, v = vi.simulate(scene, x[:1], x[1:], (0, orbit.period)).final
            return np.array([q[0], v[0]])

        beside = [(after(x + step * e) - after(x - step * e)) / (2 * step) for e in np.eye(2)]
        own = np.sort_complex(orbit.floquet_multipliers)
        assert np.sort_complex(np.linalg.eigvals(np.transpose(beside))) == pytest.approx(own, abs=2e-8)
        assert after(x) == pytest.approx(x, abs=1e-11)

    def test_the_sum_of_exponents_is_what_the_damping_takes(self, release):
        """The determinant is exp(-c T - c_s t) with the time t for which the dashpot of the stop acts."""
        orbit = settled(soft(release))
        contact = orbit.contacts[0]
        acts = contact["end"] - contact["start"]
        wanted = np.exp(-0.1 * orbit.period - 0.5 * acts)
        assert np.prod(orbit.floquet_multipliers).real == pytest.approx(wanted, rel=1e-10)

    def test_it_is_kept_as_it_is(self, release, tmp_path):
        """Pickled and saved, and found again from itself."""
        orbit = settled(soft(release))
        orbit.save(tmp_path / "orbit.npz")
        again = [pickle.loads(pickle.dumps(orbit)), vi.load(tmp_path / "orbit.npz")]
        for own in again:
            assert own.signature == orbit.signature
            assert np.array_equal(own.floquet_multipliers, orbit.floquet_multipliers)
            assert np.array_equal(own.contacts, orbit.contacts)
            assert own.is_admissible is orbit.is_admissible
        same = vi.find_orbit(orbit.scene, orbit)
        assert same.v0 == pytest.approx(orbit.v0, abs=1e-13)
        other = vi.find_orbit(soft(release, force=1.02), orbit)
        assert other.signature == orbit.signature
        assert abs(other.v0[0] - orbit.v0[0]) > 1e-3

    def test_it_goes_on_in_a_simulation(self, release):
        """A run from its beginning retraces it; energy adds up over a period."""
        orbit = settled(soft(release))
        run = vi.simulate(orbit.scene, orbit.q0, orbit.v0, (0, 3 * orbit.period))
        assert run.final[0] == pytest.approx(orbit.q0, abs=1e-12)
        t = np.linspace(0, orbit.period, 50)
        assert run.position(t) == pytest.approx(orbit.position(t), abs=1e-12)
        energy = orbit.energy
        assert energy.contact_loss[-1] == pytest.approx(orbit.contacts["loss"].sum(), rel=1e-9)
        assert abs(energy.balance).max() < 1e-12

    def test_an_orbit_through_another_stop_is_none(self, release):
        """A stop that the motion passes makes it inadmissible, rigid or not."""
        orbit = settled(soft(release))
        deepest = orbit.contacts["peak_approach"][0]
        for more in (
            vi.Stop(0, 0.5 + 0.5 * deepest, 0.8),
            vi.Stop(0, 0.5 + 0.5 * deepest, contact=vi.Spring(5.0)),
            vi.Stop(0, -orbit.position(np.linspace(0, orbit.period, 999)).min() - 0.1, 0.8, side="lower"),
        ):
            passing = vi.find_orbit(soft(release, more), orbit)
            assert passing.is_admissible is False
            assert passing.violation.stop == 1


def test_a_pressed_motion_in_step_with_the_forcing_is_an_orbit():
    """A body that never leaves the stop: the steady response of the pressed system."""
    law = vi.Spring(20.0, 0.5, release="gap")
    scene = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0, load=[30.0]), vi.Harmonic([1.0], 0.8), [vi.Stop(0, 0.5, contact=law)])
    orbit = settled(scene, 1.8, 0.0)
    response = 1.0 / (21.0 - 0.64 + 0.8j * 0.6)
    size = orbit.max_displacement[0] - 40.0 / 21.0
    assert size == pytest.approx(abs(response), rel=1e-9)
    assert orbit.signature == ()
    assert orbit.is_admissible is True
    roots = np.roots([1.0, 0.6, 21.0])
    assert np.sort_complex(orbit.floquet_multipliers) == pytest.approx(np.sort_complex(np.exp(roots * orbit.period)), rel=1e-9)


def some_scene(seed):
    """Return a random scene of one to three coordinates with two soft stops: preloads, moving ones, rigid ones beside in some."""
    rng = np.random.default_rng(seed)
    n = 1 + seed % 3
    root = rng.normal(size=(n, n))
    stiffness = np.eye(n) * 1.5 + 0.2 * root @ root.T
    system = vi.LinearSystem(np.eye(n), 0.15 * stiffness, stiffness)
    force = vi.Harmonic(rng.normal(size=n) + 1.0, rng.uniform(0.7, 1.6))
    release = RELEASES[seed % 4 % 3]
    one = vi.Spring(rng.uniform(5, 60), rng.uniform(0, 1), release=release, preload=0.5 * (seed % 5 == 4))
    other = vi.Spring(rng.uniform(5, 60), rng.uniform(0, 1), release="gap")
    moves = vi.Harmonic(0.1, force.frequency, 0.4) if seed % 7 == 3 else None
    stops = [
        vi.Stop(0, 0.3, contact=one, reaction="coordinate" if seed % 4 == 1 else "inertia"),
        vi.Stop(n - 1, 0.4, contact=other, side="lower", motion=moves),
    ]
    if seed % 3 == 2:
        stops.append(vi.Stop(1, 0.5, 0.6))
    return vi.Scene(system, force, stops)


def beside(orbit):
    """Return the derivative of a period's map by differences of runs, from a time without memory, and what it leaves open."""
    table = orbit.regimes
    plain = table[[not (row["state"] == "relaxing").any() for row in table]]
    longest = plain[np.argmax(plain["end"] - plain["start"])]
    start = 0.5 * (longest["start"] + longest["end"])
    there = orbit.scene.replace(phase=orbit.phase + orbit.scene.forcing.frequency * start)
    x = np.concatenate([orbit.position(start), orbit.velocity(start)])
    n = len(x) // 2

    def after(x):
        return np.concatenate(vi.simulate(there, x[:n], x[n:], (0, orbit.period)).final)

    # Beside a short contact the map bends like the root of its depth.
    step = 1e-7
    columns = [(after(x + step * e) - after(x - step * e)) / (2 * step) for e in np.eye(2 * n)]
    return np.transpose(columns), np.abs(after(x) - x).max()


def test_multipliers_of_random_orbits_are_those_of_runs():
    """An orbit that a run settles on is admissible, closes, and neighbours come back by its multipliers."""
    found = 0
    for seed in range(SEED, SEED + COUNT):
        scene = some_scene(seed)
        rest = np.zeros(scene.system.n_dof)
        run = vi.simulate(scene, rest, rest, (0, 150 * 2 * np.pi / scene.forcing.frequency))
        try:
            orbit = vi.find_orbit(scene, run)
        except (ValueError, vi.ConvergenceError):
            continue  # chaos, or what has no Jacobian yet
        if orbit.is_admissible is False:
            # One that Newton's method met from chaos: the run is not near it.
            size = orbit.max_displacement.max()
            ends = [orbit.position(t) for t in np.linspace(0, orbit.period, 400)]
            assert min(np.abs(run.final[0] - q).max() for q in ends) > 1e-6 * size, f"{seed}: {orbit.violation}"
            continue
        if orbit.floquet_multipliers is None or np.abs(orbit.floquet_multipliers).max() > 30:
            continue  # differences do not tell where neighbours part so fast
        found += 1
        map_, open_ = beside(orbit)
        assert open_ < 1e-10, seed
        wanted = np.sort(np.abs(np.linalg.eigvals(map_)))
        assert np.sort(np.abs(orbit.floquet_multipliers)) == pytest.approx(wanted, abs=1e-5 * max(1.0, wanted[-1])), seed
    assert found > 0.6 * COUNT


def test_what_goes_on_from_such_an_orbit_says_what_it_does_not_take():
    """A pattern is one of impacts, and refuses these orbits by name."""
    with pytest.raises(ValueError, match=r"stops\[0\] is Spring"):
        vi.find_orbit(soft(), settled(soft()), pattern=[0])


def test_an_orbit_of_another_law_is_no_guess():
    """Impacts on a stop that gives way in the scene, contacts with one that is rigid there, and the ends of another release."""
    orbit = settled(soft())
    rigid = vi.Scene(OSCILLATOR, vi.Harmonic([1.0], 0.8), [vi.Stop(0, 0.5, 0.6)])
    hit = settled(rigid, periods=300)
    for scene, guess, law in (
        (soft(), hit, "Spring"),
        (rigid, orbit, "Newton"),
        (soft("force"), orbit, "Spring"),
    ):
        with pytest.raises(ValueError, match=f"another law.*law of contact is {law}"):
            vi.find_orbit(scene, guess)
    # Without a dashpot all releases are one.
    elastic = settled(soft(damping=0.0), periods=300)
    same = vi.find_orbit(soft("gap", damping=0.0), elastic)
    assert same.v0 == pytest.approx(elastic.v0, abs=1e-11)


def test_the_least_gap_of_a_stop_that_gives_way_is_below_zero():
    """How deep it is pressed, and what is left free of the other."""
    orbit = settled(soft("gap", vi.Stop(0, 5.0, 0.8)))
    depth = orbit.contacts["peak_approach"][0]
    assert orbit.min_gap == pytest.approx([-depth, 4.5 - depth], rel=1e-9)


class TestAStopThatIsMetBeforeItIsBack:
    """Heavy dashpots relax so slowly that their place is remembered from contact to contact."""

    @staticmethod
    def multipliers_by_differences(orbit, at):
        """Return those of simulations over a period that begin and end in a contact, which remembers nothing else."""
        q, v = orbit.position(at), orbit.velocity(at)
        x = np.concatenate([q, v])
        n = len(q)
        scene = orbit.scene.replace(phase=orbit.phase + orbit.scene.forcing.frequency * at)
        step = 1e-6

        def after(x):
            return np.concatenate(vi.simulate(scene, x[:n], x[n:], (0, orbit.period)).final)

        assert after(x) == pytest.approx(x, abs=1e-10)
        return np.linalg.eigvals(np.transpose([(after(x + step * e) - after(x - step * e)) / (2 * step) for e in np.eye(2 * n)]))

    @pytest.mark.parametrize("damping", [8.0, 20.0, 60.0])
    @pytest.mark.parametrize("preload", [0.0, 0.05])
    def test_one_stop(self, damping, preload):
        """The orbit retraces a run, and its multipliers are those of runs beside it."""
        law = vi.Spring(20.0, damping, release="force", preload=preload)
        scene = vi.Scene(OSCILLATOR, vi.Harmonic([1.0], 1.2), [vi.Stop(0, 0.3, contact=law)])
        orbit = settled(scene, periods=200)
        assert orbit.signature == (("press", "stop[0]"), ("relax", "stop[0]"))
        assert orbit.is_admissible is True
        deep = orbit.position(0.0)[0] - 0.3
        assert deep > 1e-6 or (preload > 0 and abs(deep) < 1e-12)
        inside = 0.3 * orbit.contacts["end"][0]
        beside = self.multipliers_by_differences(orbit, inside)
        assert np.sort_complex(orbit.floquet_multipliers) == pytest.approx(np.sort_complex(beside), abs=1e-7)
        again = vi.find_orbit(scene.replace(frequency=1.21), orbit)
        assert again.signature == orbit.signature
        assert again.is_admissible is True

    def test_it_is_one_of_all_orbits_with_one_contact(self):
        """The equation in the duration has the memory in it."""
        law = vi.Spring(20.0, 20.0, release="force")
        scene = vi.Scene(OSCILLATOR, vi.Harmonic([1.0], 1.2), [vi.Stop(0, 0.3, contact=law)])
        (own,) = [orbit for orbit in vi.periodic_orbits(scene, [0]) if orbit.is_admissible]
        found = settled(scene, periods=200)
        assert own.v0 == pytest.approx(found.v0, abs=1e-11)
        assert own.q0 == pytest.approx(found.q0, abs=1e-11)
        assert np.sort_complex(own.floquet_multipliers) == pytest.approx(np.sort_complex(found.floquet_multipliers), abs=1e-10)

    def test_two_stops_of_which_one_is_out_as_a_period_begins(self):
        """Its place is one dimension more of the map, and its multipliers are those with which runs settle."""
        law = vi.Spring(20.0, 30.0, release="force")
        stops = [vi.Stop(0, 0.3, contact=law), vi.Stop(0, 0.25, contact=law, side="lower")]
        scene = vi.Scene(OSCILLATOR, vi.Harmonic([1.0], 1.2), stops)
        orbit = settled(scene, periods=300)
        assert len(orbit.contacts) == 2
        assert orbit.is_admissible is True
        assert orbit.floquet_multipliers.shape == (3,)
        assert orbit.monodromy.shape == (3, 3)
        # What is left of a deviation after each period is annihilated by the characteristic polynomial (Cayley and Hamilton).
        run = vi.simulate(orbit.scene, orbit.q0 + 1e-5, orbit.v0, (0, 6 * orbit.period))
        left = [run.position(k * orbit.period + 0.4)[0] - orbit.position(0.4)[0] for k in range(6)]
        polynomial = np.poly(orbit.floquet_multipliers)
        for k in (0, 1):
            terms = polynomial * left[k : k + 4][::-1]
            assert abs(terms.sum()) < 2e-3 * np.abs(terms).max()


class TestAGivenSignature:
    """Events are waited for in their order, whatever else the motion passes by."""

    PRESS, LEAVE, RELAX = ("press", "stop[0]"), ("leave", "stop[0]"), ("relax", "stop[0]")

    @pytest.mark.parametrize(
        ("release", "signature"), [("gap", [PRESS, LEAVE]), ("force", [PRESS, RELAX]), ("clipped", [PRESS, RELAX, LEAVE])]
    )
    def test_it_leads_to_the_orbit_of_a_run(self, release, signature):
        """From a state near it."""
        known = settled(soft(release))
        found = vi.find_orbit(soft(release), (0.0, 1.8), signature=signature)
        assert found.signature == tuple(signature)
        assert found.v0 == pytest.approx(known.v0, abs=1e-11)
        again = vi.find_orbit(soft(release), known, signature=known.signature)
        assert again.v0 == pytest.approx(known.v0, abs=1e-11)

    def test_it_passes_by_what_is_not_in_it(self):
        """A rigid stop in the way: the orbit is the one without it, and not admissible."""
        known = settled(soft())
        beside = soft("gap", vi.Stop(0, 0.55, 0.8))
        found = vi.find_orbit(beside, (0.0, 1.8), signature=[self.PRESS, ("leave", 0)])
        assert found.v0 == pytest.approx(known.v0, abs=1e-11)
        assert found.is_admissible is False
        assert found.violation.stop == 1

    def test_rigid_stops_and_soft_ones_in_one_signature(self):
        """A strike beyond the place where a soft stop is pressed."""
        rigid = vi.Stop(0, 0.62, 0.6)
        known = settled(soft("gap", rigid), periods=400)
        assert ("strike", "stop[1]") in known.signature
        found = vi.find_orbit(soft("gap", rigid), known, signature=known.signature)
        assert found.v0 == pytest.approx(known.v0, abs=1e-10)

    @pytest.mark.parametrize(
        ("signature", "says"),
        [
            ([("press", "stop[1]")], "the scene has 1 stops"),
            ([("chatter", "stop[0]")], "waited for"),
            ([("press", "stop[0]"), ("press", "stop[0]")], "no such change"),
            ([("press", "stop[0]"), ("relax", "stop[0]")], "no such change"),
            ([("strike", "stop[0]")], "no such change"),
            ([], "event at least"),
            ([("press",)], "a pair of an event"),
            ([("press", "wall")], "a pair of an event"),
        ],
    )
    def test_wrong_ones_are_refused_with_the_event(self, signature, says):
        """By its place."""
        with pytest.raises(ValueError, match=rf"signature.*{says}"):
            vi.find_orbit(soft(), (0.0, 1.8), signature=signature)

    def test_it_is_one_or_the_other(self):
        """A pattern, or a signature."""
        with pytest.raises(ValueError, match="leave one out"):
            vi.find_orbit(soft(), (0.0, 1.8), pattern=[0], signature=[self.PRESS, self.LEAVE])
        with pytest.raises(ValueError, match=r"signature\[2\].*within a period"):
            vi.find_orbit(soft(), (-0.4, 0.0), signature=[self.LEAVE, self.PRESS, self.LEAVE, self.PRESS, self.LEAVE, self.PRESS])
