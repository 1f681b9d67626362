"""Stops that give way, as Python has them."""

import pickle

import numpy as np
import pytest
from contact_scenes import draw
from scipy.interpolate import CubicSpline

import vibroimpact as vi

OSCILLATOR = vi.LinearSystem(1.0, 0.1, 1.0)
FORCE = vi.Harmonic([1.0], 0.8)


def between(release, *more):
    """Return an oscillator between two stops that give way."""
    upper = vi.Stop(0, 0.5, contact=vi.Spring(20, 0.5, release=release))
    lower = vi.Stop(0, 0.9, contact=vi.Spring(35, 0.5, release=release), side="lower")
    return vi.Scene(OSCILLATOR, FORCE, [upper, lower, *more])


@pytest.mark.parametrize("release", ["gap", "force", "clipped"])
class TestARun:
    """A run with stops that give way."""

    def test_the_tables_fit_each_other(self, release):
        """Contacts are the stretches along which a stop is pressed, and the energy adds up."""
        run = vi.simulate(between(release, vi.Stop(0, 0.62, 0.6)), 0.0, 0.3, (0, 20))
        contacts, regimes = run.contacts, run.regimes
        soft = contacts[contacts["stop"] < 2]
        assert len(soft) == run.stats.n_contacts
        assert regimes["state"].shape == (len(regimes), 3)
        assert run.scene.elements == ("stop[0]", "stop[1]", "stop[2]")
        for stop in (0, 1):
            pressed = regimes[regimes["state"][:, stop] == "pressed"]
            total = (pressed["end"] - pressed["start"]).sum()
            own = soft[soft["stop"] == stop]
            last = np.nan_to_num(own["end"], nan=20.0)
            assert (last - own["start"]).sum() == pytest.approx(total, rel=1e-12)
            assert own["impulse"].sum() == pytest.approx(run.impulse(stop), rel=1e-12)
        assert (contacts["peak_force"] == np.inf).sum() == len(run.impacts)
        energy = run.energy
        assert np.abs(energy.balance).max() < 1e-13
        lost = energy.impact_loss[-1] + energy.contact_loss[-1]
        assert contacts["loss"].sum() == pytest.approx(lost, rel=1e-11)
        force = run.contact_force(0, soft["start"][0] + 0.1)
        assert 0.0 < force <= soft["peak_force"][0]

    def test_it_is_pickled_and_saved(self, release, tmp_path):
        """What is read is what was written; the file has a format of its own."""
        run = vi.simulate(between(release), 0.0, 0.3, (0, 20))
        run.save(tmp_path / "run.npz")
        for again in (pickle.loads(pickle.dumps(run)), vi.load(tmp_path / "run.npz")):
            assert np.array_equal(again.contacts, run.contacts)
            assert np.array_equal(again.regimes, run.regimes)
            assert again.stats == run.stats or again.stats.n_contacts == run.stats.n_contacts
            assert again.scene == run.scene

    def test_other_units_of_length_give_the_same_bits(self, release):
        """A scene whose lengths are a power of two times as long has the same times."""
        run = vi.simulate(between(release), 0.0, 0.3, (0, 20))
        size = 2.0**20
        stops = [vi.Stop(0, size * own.clearance, contact=own.contact, side=own.side) for own in run.scene.stops]
        long = vi.simulate(vi.Scene(OSCILLATOR, vi.Harmonic([size], 0.8), stops), 0.0, 0.3 * size, (0, 20))
        assert np.array_equal(long.contacts["start"], run.contacts["start"])
        assert np.array_equal(long.final[0], size * run.final[0])

    def test_far_from_time_zero_it_is_the_same(self, release):
        """A run a million units of time later, in the same phase."""
        run = vi.simulate(between(release), 0.0, 0.3, (0, 20))
        later = between(release).replace(phase=-0.8e6)
        far = vi.simulate(later, 0.0, 0.3, (1e6, 1e6 + 20))
        assert len(far.contacts) == len(run.contacts)
        assert far.final[0] == pytest.approx(run.final[0], abs=1e-9)


@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize("method", ["dop853", "rk45"])
def test_steps_and_exact_flights_agree_beside_rigid_stops(method, restitution):
    """Two coupled masses: a stop that gives way between them, and a rigid one for each, that hold and chatter."""
    masses = vi.LinearSystem([[1, 0.2], [0.2, 0.7]], [[0.1, -0.03], [-0.03, 0.08]], [[3, -1], [-1, 2]])
    soft = vi.Stop([0.6, -0.8], 0.1, contact=vi.Spring(200, 1, release="gap"))
    stops = [soft, vi.Stop(0, 0.3, restitution), vi.Stop(1, 0.2, restitution, side="lower")]
    scene = vi.Scene(masses, vi.Harmonic([1.0, 2.0], 1.3), stops)
    exact = vi.simulate(scene, [0, 0], [0.3, 0.2], (0, 20))
    stepped = vi.simulate(scene, [0, 0], [0.3, 0.2], (0, 20), method=method, rtol=1e-11)
    assert exact.stats.n_contacts == stepped.stats.n_contacts > 5
    assert stepped.final[0] == pytest.approx(exact.final[0], abs=1e-9)


@pytest.mark.parametrize("rigid", [False, True])
def test_a_stop_that_follows_a_signal_gives_way_there(rigid):
    """Exact flights know the rate of the signal, as steps do."""
    t = np.linspace(0, 20, 41)
    motion = CubicSpline(t, 0.1 * np.sin(0.9 * t) * np.exp(-(((t - 10) / 6) ** 2)))
    stops = [vi.Stop(0, 0.5, contact=vi.Spring(20, 0.5, release="gap"), motion=motion)]
    stops += [vi.Stop(0, 0.55, 0.7)] if rigid else []
    scene = vi.Scene(OSCILLATOR, FORCE, stops)
    exact = vi.simulate(scene, 0.0, 0.3, (0.5, 19.5))
    stepped = vi.simulate(scene, 0.0, 0.3, (0.5, 19.5), method="dop853", rtol=1e-11)
    assert len(exact.contacts) == len(stepped.contacts)
    assert stepped.final[0] == pytest.approx(exact.final[0], abs=1e-9)
    assert np.abs(exact.energy.balance).max() < 1e-12


def test_a_body_that_comes_to_rest_on_an_overdamped_stop_stays():
    """It comes back to where the gap opens in an infinite time, which takes no time to say."""
    free = vi.LinearSystem(2.0, 0.0, 0.0)
    law = vi.Spring.from_restitution(0.0, 1e9, 2.0, release="gap")
    scene = vi.Scene(free, stops=[vi.Stop(0, 0.5, contact=vi.Spring(1e9, 1.5 * law.damping, release="gap"))])
    run = vi.simulate(scene, 0.0, 0.8, (0, 1e6))
    assert run.stats.n_contacts == 1
    assert run.stats.n_gap_evaluations < 1e5
    assert run.final[0] == pytest.approx([0.5], abs=1e-12)


def test_what_does_not_take_them_yet_says_so():
    """No analysis takes a stop that gives way for a rigid one."""
    with pytest.raises(ValueError, match=r"stops\[0\] is Spring.*recovery_matrix"):
        vi.recovery_matrix(between("gap"), [0])


def test_numbers_of_other_laws_stay():
    """A restitution is one of rigid stops alone."""
    mixed = between("gap", vi.Stop(0, 0.7, 0.6))
    assert [own.restitution for own in mixed.replace(restitution=0.3).stops] == [None, None, 0.3]
    for call in (lambda: between("gap").replace(restitution=0.3), lambda: mixed.replace(restitution=[0.1, 0.2, 0.3])):
        with pytest.raises(ValueError, match="Spring"):
            call()
    assert mixed.stops[2].contact == vi.Newton(0.6)
    assert vi.Stop(0, 0.7, contact=vi.Newton(0.6)) == mixed.stops[2]


def test_a_dashpot_needs_a_release_and_says_what_each_gives_back():
    """The error has the restitution of a free body by each."""
    with pytest.raises(ValueError, match=r'0\.527 by "gap", 0\.572 by "force", 0\.572 by "clipped"'):
        vi.Spring(1.0, 0.4)
    law = vi.Spring(1.0, 0.4, release="gap")
    assert eval(repr(law), {"Spring": vi.Spring}) == law
    with pytest.raises(ValueError, match=r'release is "open"'):
        vi.Spring(1.0, 0.4, release="open")


RELEASES = ["gap", "force", "clipped"]


def weighed(release, weight, preload, *, damping=2.0, force=None, motion=None):
    """Return a body of mass 1 that a weight pushes onto a preloaded stop."""
    stop = vi.Stop(0, 0.3, contact=vi.Spring(50.0, damping, release=release, preload=preload), motion=motion)
    return vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0, load=[weight]), force, [stop])


@pytest.mark.parametrize("release", RELEASES)
class TestAPreload:
    """A stop that gives way only under more than its preload."""

    @pytest.mark.parametrize(("weight", "state"), [(1.0, "seated"), (2.0, "seated"), (3.0, "pressed"), (-1.0, "free")])
    def test_a_body_at_its_seat_is_borne_by_no_more(self, release, weight, state):
        """At rest on the seat: the weight is borne, presses the stop in, or draws the body away."""
        run = vi.simulate(weighed(release, weight, 2.0), 0.3, 0.0, (0, 0.1))
        assert run.regimes["state"][0, 0] == state
        if state == "seated":
            assert run.final[0][0] == 0.3
            assert run.final[1][0] == 0.0
            assert run.contact_force(0, 0.05) == weight
            assert run.contacts["impulse"] == pytest.approx([0.1 * weight], rel=1e-14)

    def test_bounces_lose_what_the_law_of_low_ones_says(self, release):
        """v -> v - kappa v^2, kappa = (2/3) c/(F0 - weight); then the body is borne, as a rigid stop would hold it."""
        run = vi.simulate(weighed(release, 1.0, 2.0), 0.0, 0.0, (0, 60))
        speed = run.contacts["speed_before"]
        lost = (speed[:-1] - speed[1:]) / speed[:-1] ** 2
        low = (speed[:-1] < 1e-3) & (speed[:-1] > 2e-4)
        assert low.sum() > 1000
        assert lost[low] == pytest.approx(2 / 3 * 2.0 / (2.0 - 1.0), rel=2e-3)
        assert run.regimes["state"][-1, 0] == "seated"
        assert [row["kind"] for row in run.segments[-2:]] == ["chatter", "stick"]
        assert run.final[0][0] == 0.3
        assert run.final[1][0] == 0.0
        assert np.abs(run.energy.balance).max() < 1e-13
        assert np.isfinite(run.contacts["peak_force"]).all()

    @pytest.mark.parametrize("moves", [False, True])
    @pytest.mark.parametrize(
        ("phase", "state", "at"),
        [(-1.6, "pressed", (1.6 - np.arccos(0.8)) / 0.8), (1.6, "free", (np.arccos(-2 / 3) - 1.6) / 0.8)],
    )
    def test_a_seat_is_left_on_either_side(self, release, moves, phase, state, at):
        """Borne is 1 + 1.5 cos(0.8 t + phase), of a force or of the stop's own acceleration: to the preload, 2.2, or to zero."""
        size = 1.5 / 0.64 if moves else 1.5
        wave = vi.Harmonic([size], 0.8, phase)
        scene = weighed(release, 1.0, 2.2, **({"motion": wave} if moves else {"force": wave}))
        q0, v0 = (0.3 + size * np.cos(phase), -0.8 * size * np.sin(phase)) if moves else (0.3, 0.0)
        run = vi.simulate(scene, q0, v0, (0, at + 0.05))
        assert list(run.regimes["state"][:, 0]) == ["seated", state]
        assert run.regimes["end"][0] == pytest.approx(at, rel=1e-14)
        t = np.linspace(0, at, 7)[:-1]
        assert run.contact_force(0, t) == pytest.approx(1 + 1.5 * np.cos(0.8 * t + phase), rel=1e-13)

    def test_a_free_body_is_given_back_what_the_law_says(self, release):
        """A body that nothing else pushes keeps the speed of the closed form, and is in contact as long."""
        law = vi.Spring(4.0, 0.6, release=release, preload=0.3)
        scene = vi.Scene(vi.LinearSystem(2.0, 0.0, 0.0), stops=[vi.Stop(0, 1.0, contact=law)])
        own = vi.simulate(scene, 0.0, 1.5, (0, 5)).contacts
        assert own["speed_after"] / own["speed_before"] == pytest.approx([law.equivalent_restitution(2.0, 1.5)], rel=1e-13)
        if release == "gap":
            assert own["end"] - own["start"] == pytest.approx([2.11638706827], rel=1e-11)

    def test_an_impact_on_another_stop_throws_a_body_off_its_seat(self, release):
        """What a seat bears is no impulse: coupled by inertia, a seated body has a speed after an impact of the other."""
        system = vi.LinearSystem([[1.0, 0.4], [0.4, 1.0]], np.zeros((2, 2)), np.zeros((2, 2)), load=[0.5, 0.0])
        for side, wanted in (("upper", "pressed"), ("lower", "free")):
            stops = [
                vi.Stop(0, 0.0, contact=vi.Spring(50.0, 2.0, release=release, preload=2.0)),
                vi.Stop(1, 0.5, 0.6, side=side),
            ]
            towards = 1.0 if side == "upper" else -1.0
            run = vi.simulate(vi.Scene(system, stops=stops), [0.0, 0.0], [0.0, towards], (0, 0.6))
            assert run.impacts["stop"][0] == 1
            assert [str(own) for own in run.regimes["state"][:2, 0]] == ["seated", wanted]
            assert run.regimes["end"][0] == run.impacts["time"][0]

    def test_other_units_and_other_times_change_nothing(self, release):
        """Lengths times a power of two give the same times; a start at t = 1e6 the same run."""
        made = {}
        for size in (1.0, 2.0**-30):
            law = vi.Spring(50.0, 2.0, release=release, preload=2.2 * size)
            scene = vi.Scene(
                vi.LinearSystem(1.0, 0.1, 1.0, load=[size]),
                vi.Harmonic([1.9 * size], 0.8, -1.6),
                [vi.Stop(0, 0.3 * size, contact=law), vi.Stop(0, 0.5 * size, 0.6, side="lower")],
            )
            made[size] = vi.simulate(scene, 0.3 * size, 0.0, (0, 40))
            far = scene.replace(phase=-1.6 - 0.8e6)
            later = vi.simulate(far, 0.3 * size, 0.0, (1e6, 1e6 + 40))
            assert later.final[0] == pytest.approx(made[size].final[0], abs=1e-8 * size)
            assert np.array_equal(later.regimes["state"], made[size].regimes["state"])
        one, small = made.values()
        assert np.array_equal(one.regimes["start"], small.regimes["start"])
        assert "seated" in one.regimes["state"]
        assert np.array_equal(one.final[0] * 2.0**-30, small.final[0])


def test_numbers_of_laws_are_replaced():
    """Stiffness, damping and preload of one stop or of all that have them; a law that has none says so."""
    mixed = between("gap", vi.Stop(0, 0.7, 0.6))
    assert mixed.replace(contact_stiffness=7.0).stops[1].contact == vi.Spring(7.0, 0.5, release="gap")
    one = mixed.replace(**{"contact_damping[1]": 0.0, "preload[0]": 0.2})
    assert one.stops[0].contact == vi.Spring(20.0, 0.5, release="gap", preload=0.2)
    assert one.stops[1].contact == vi.Spring(35.0, 0.0, release="gap")
    for change, message in (
        ({"contact_stiffness[2]": 1.0}, "Newton"),
        ({"contact_stiffness": -1.0}, "contact_stiffness is -1"),
        ({"contact_damping[0]": -1.0}, "contact_damping is -1"),
        ({"preload": float("nan")}, "preload is NaN"),
        ({"restitution[0]": 0.5}, "Spring"),
    ):
        with pytest.raises(ValueError, match=message):
            mixed.replace(**change)
    elastic = vi.Scene(OSCILLATOR, FORCE, [vi.Stop(0, 0.5, contact=vi.Spring(20.0))])
    with pytest.raises(ValueError, match="release"):
        elastic.replace(contact_damping=0.4)


def test_modes_of_a_regime_are_those_of_its_stiffness_and_damping():
    """The references' roots of two masses with a stop pressed; what a stop held leaves; what is refused."""
    mass, damping, stiffness = [[1.0, 0.2], [0.2, 0.7]], [[0.1, -0.03], [-0.03, 0.08]], [[3.0, -1.0], [-1.0, 2.0]]
    soft = vi.Stop([0.6, -0.8], 1.0, contact=vi.Spring(200.0, 1.0, release="gap"))
    scene = vi.Scene(vi.LinearSystem(mass, damping, stiffness), stops=[soft, vi.Stop(1, 1.0, 0.5)])
    roots = np.sort_complex(vi.modes(scene, pressed=[0]).eigenvalues)
    wanted = [-0.91445078242813 + 18.2460579685416j, -0.0294886115112644 + 1.24385402568334j]
    assert roots == pytest.approx(np.sort_complex([*wanted, *np.conj(wanted)]), abs=1e-12)
    held = vi.modes(scene, held=1)
    assert held.natural_frequencies == pytest.approx([np.sqrt(3.0)], rel=1e-14)
    assert held.shapes == pytest.approx(np.array([[1.0], [0.0]]), abs=1e-14)
    again = pickle.loads(pickle.dumps(held))
    assert np.array_equal(again.eigenvalues, held.eigenvalues)
    assert np.array_equal(vi.modes(scene).eigenvalues, vi.modes(scene.system).eigenvalues)
    for wrong, name in (({"pressed": 1}, "Newton"), ({"held": 0}, "Spring"), ({"pressed": 2}, "2 stops")):
        with pytest.raises(ValueError, match=name):
            vi.modes(scene, **wrong)
    with pytest.raises(TypeError, match="LinearSystem"):
        vi.modes(scene.system, pressed=0)


def test_ensembles_have_the_bits_of_single_runs():
    """Whatever the laws: stops that give way by each release, with preloads, beside rigid ones."""
    count = 0
    for number in range(20):
        twin, q0, v0, end = draw(np.random.default_rng([3, number]))
        parts = np.linspace(1.0, 0.2, 5)[:, None]
        scene = twin.scene()
        try:
            many = vi.simulate_many(scene, parts * q0, parts * v0, (0, end))
        except ValueError:  # a start inside a rigid stop
            continue
        for i, part in enumerate(parts):
            final = vi.simulate(scene, part * q0, part * v0, (0, end), keep="final").final
            assert np.array_equal(final, [many.q[i], many.v[i]])
            count += 1
    assert count > 50


class TestRamps:
    """Numbers that drift along a run with stops that give way."""

    PERIOD = 2 * np.pi / 0.8

    @pytest.mark.parametrize("release", ["gap", "force", "clipped"])
    @pytest.mark.parametrize(
        ("name", "to"), [("contact_stiffness[0]", 60.0), ("contact_damping", 2.0), ("clearance[0]", 0.2), ("preload[0]", 0.3)]
    )
    def test_levels_are_runs_that_go_on(self, release, name, to):
        """Level by level the run of the scene with the value, from the state before; the energy adds up."""
        scene = between(release)
        dwell = 0.37
        run = vi.simulate(scene, 0.0, 0.3, (0, 8 * dwell * self.PERIOD), ramp=vi.Ramp(name, to, levels=5, dwell=dwell))
        begin = {"contact_stiffness": 20.0, "contact_damping": 0.5, "clearance": 0.5, "preload": 0.0}[name.partition("[")[0]]
        ends = [*(dwell * self.PERIOD * np.arange(1, 5)), 8 * dwell * self.PERIOD]
        now, state = 0.0, (0.0, 0.3)
        for value, end in zip(np.linspace(begin, to, 5), ends, strict=True):
            level = scene.replace(**{name: value})
            # From the state of another scene, with each element as it was.
            piece = vi.simulate(level, *state, (now, end))
            t = np.linspace(0.9 * now + 0.1 * end, end, 7)
            assert run.position(t) == pytest.approx(piece.position(t), abs=1e-11)
            now, state = end, (piece.state,)
        assert run.final[1] == pytest.approx(piece.final[1], abs=1e-11)
        assert abs(run.energy.balance).max() < 1e-11
        total = run.energy
        columns = total.kinetic + total.potential - total.forcing_work + total.damping_loss + total.contact_loss
        assert columns == pytest.approx(columns[0], abs=1e-11)

    def test_a_gap_drifts_steadily(self):
        """Exact flights and steps agree."""
        scene = between("gap")
        drift = vi.Ramp("clearance[0]", 0.1, over=15.0)
        run = vi.simulate(scene, 0.0, 0.3, (0, 25), ramp=drift)
        steps = vi.simulate(scene, 0.0, 0.3, (0, 25), ramp=drift, method="dop853", rtol=1e-12, atol=1e-13)
        assert run.stats.n_contacts == steps.stats.n_contacts > 3
        assert run.final[0] == pytest.approx(steps.final[0], abs=1e-9)
        assert abs(run.energy.balance).max() < 1e-10

    def test_stiffness_damping_and_preload_change_in_levels_alone(self):
        """While a stop is pressed a steady change of them is no linear system of its own."""
        for name in ("contact_stiffness", "contact_damping[0]", "preload"):
            with pytest.raises(ValueError, match=r"contact_|preload.*levels="):
                vi.simulate(between("gap"), 0.0, 0.3, (0, 10), ramp=vi.Ramp(name, 1.0, over=5.0))


class TestStopsOfAnyGap:
    """The gap of one that is pressed is searched from inside, by its curvature and by places of a step."""

    FORCED = vi.Harmonic([0.15, -0.15j], 1.0)
    SHAFT = vi.LinearSystem(np.ones(2), 0.1 * np.ones(2), np.ones(2))

    @pytest.mark.parametrize("curvature", [None, 0.0])
    @pytest.mark.parametrize("method", ["rk45", "dop853", "radau"])
    def test_a_plane_by_its_gap_is_that_stop(self, method, curvature):
        law = vi.Spring(2.0, 0.1, release="gap")
        given = vi.NonlinearStop(lambda q: 1.0 - q[0], lambda q: np.array([-1.0, 0.0]), contact=law, curvature=curvature)
        options = {"method": method, "rtol": 1e-10, "atol": 1e-12}
        one, other = (
            vi.simulate(vi.Scene(self.SHAFT, self.FORCED, stop), [0.0, 0.0], [0.0, 0.0], (0, 60), **options)
            for stop in (vi.Stop(0, 1.0, contact=law), given)
        )
        assert other.status == "finished"
        assert one.stats.n_contacts == other.stats.n_contacts > 3
        assert other.contacts["start"] == pytest.approx(one.contacts["start"], abs=1e-7)
        assert other.contacts["end"] == pytest.approx(one.contacts["end"], abs=1e-7)

    @pytest.mark.parametrize("curvature", [None, 1.0])
    def test_a_point_in_an_elastic_circle_keeps_its_energy_and_its_turning(self, curvature):
        circle = vi.NonlinearStop(lambda q: 0.5 * (1 - q @ q), lambda q: -q, contact=vi.Spring(2.0), curvature=curvature)
        point = vi.LinearSystem(np.ones(2), np.zeros(2), np.ones(2))
        run = vi.simulate(vi.Scene(point, None, circle), [0.0, 0.5], [2.0, 0.2], (0, 20), rtol=1e-10, atol=1e-12)
        assert run.status == "finished"
        assert run.stats.n_contacts > 4
        assert abs(run.energy.balance).max() < 1e-8
        q, v = run.final
        assert q[0] * v[1] - q[1] * v[0] == pytest.approx(-1.0, abs=1e-8)
