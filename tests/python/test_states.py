"""Runs that go on from the state in which another has ended."""

import pickle

import numpy as np
import pytest

import vibroimpact as vi

#: A weight above a table that shakes, with a stop that lets it bounce to rest and go on from there.
TABLE = vi.Scene(
    vi.LinearSystem(1.0, 0.0, 0.0),
    [vi.Harmonic([0.0], 1.3), vi.Load(0, ([-1.0, 100.0], [1.0, 1.0]))],
    vi.Stop(0, 0.0, 0.5, motion=vi.Harmonic(0.9, 1.3)),
)
MASSES = vi.LinearSystem([[1.0, 0.2], [0.2, 0.7]], [[0.1, 0.0], [0.0, 0.1]], [[2.0, -1.0], [-1.0, 1.5]])
FORCE = vi.Harmonic([1.5, 0.4], 0.8)


def soft(release, preload=0.0):
    """Return two masses before a stop that gives way and a rigid one."""
    law = vi.Spring(30.0, 1.5, release=release, preload=preload)
    stops = [vi.Stop(0, 0.2, contact=law), vi.Stop(1, 0.3, 0.4), vi.Stop(0, 0.4, contact=law, side="lower")]
    return vi.Scene(MASSES, FORCE, stops)


#: A mass that a load presses onto a rigid stop, while another bounces to rest on a stop of its own.
BESIDE = vi.Scene(
    vi.LinearSystem(np.eye(2), 0.05 * np.eye(2), [[2.0, -1.0], [-1.0, 2.0]]),
    [vi.Harmonic([0.4, 0.0], 0.5), vi.Load(0, ([-1.0, 100.0], [2.0, 2.0])), vi.Load(1, ([-1.0, 100.0], [1.0, 1.0]))],
    [vi.Stop(0, 0.2, 0.0), vi.Stop(1, 0.1, 0.6)],
)
SCENES = {
    "table": (TABLE, 0.0, -0.8),
    "held": (BESIDE, [0.0, 0.0], [0.0, 0.3]),
    "bends": (
        TABLE.replace(forcing=[TABLE.forcing[0], vi.Load(0, (np.arange(-1.0, 42), 1 + 0.5 * np.sin(np.arange(43.0) ** 2)))]),
        0.0,
        -0.8,
    ),
    **{release: (soft(release), [0.0, 0.0], [0.3, -0.5]) for release in ("gap", "force", "clipped")},
    "preload": (soft("force", 0.7), [0.0, 0.0], [0.3, -0.5]),
}


def cuts(whole):
    """Return times at which a run is in each of its states, between two and at an instant, and while impacts accumulate."""
    regimes, segments = whole.regimes, whole.segments
    rows = [row for k, row in enumerate(regimes) if k % max(1, len(regimes) // 12) == 0]
    for state in np.unique(regimes["state"]):
        met = regimes[(regimes["state"] == state).any(axis=1)]
        rows += [met[0], met[-1]]
    rows += list(segments[segments["kind"] == "chatter"][:3])
    return sorted({float(t) for row in rows for t in (row["start"], 0.5 * (row["start"] + row["end"]), row["end"])})


@pytest.mark.parametrize("name", SCENES)
class TestExactFlights:
    """Exact flights of one scene."""

    def test_they_go_on_to_the_bit(self, name):
        """Impacts, contacts, states at times and at the end are those of a run that was not interrupted."""
        scene, q0, v0 = SCENES[name]
        times = np.linspace(0.0, 40.0, 157)
        whole = vi.simulate(scene, q0, v0, (0, 40))
        known = vi.simulate(scene, q0, v0, (0, 40), t_eval=times, keep="impacts")
        assert whole.status == "finished"
        seen = set()
        for t in cuts(whole):
            first = vi.simulate(scene, q0, v0, (0, t), keep="final")
            state = pickle.loads(pickle.dumps(first.state))
            assert state == first.state
            seen.update(state.regime)
            rest = vi.simulate(scene, state, (t, 40), t_eval=times[times >= t])
            assert np.array_equal(rest.final, whole.final)
            assert np.array_equal(rest.q, known.q[times >= t])
            assert np.array_equal(rest.v, known.v[times >= t])
            assert rest.impacts.tobytes() == whole.impacts[whole.impacts["time"] > t].tobytes()
            assert rest.grazes.tobytes() == whole.grazes[whole.grazes["time"] > t].tobytes()
            assert rest.state == whole.state
            between = np.linspace(t, 40, 50)
            assert rest.position(between) == pytest.approx(whole.position(between), abs=1e-13)
            contacts, all_contacts = rest.contacts, whole.contacts
            later = contacts[contacts["start"] > t]
            same = all_contacts[all_contacts["start"] > t]
            assert np.array_equal(later["start"], same["start"])
            assert np.array_equal(later["end"], same["end"], equal_nan=True)
            assert np.abs(rest.energy.balance).max() < 1e-12
        assert seen >= {str(state) for row in whole.regimes for state in row["state"]}

    def test_they_go_on_after_a_number_of_impacts(self, name):
        """So does a run that has ended by its number of impacts, and one that has gone on from it."""
        scene, q0, v0 = SCENES[name]
        whole = vi.simulate(scene, q0, v0, (0, 40))
        state, impacts = vi.simulate(scene, q0, v0, (0, 0)).state, []
        while state.time < 40:
            run = vi.simulate(scene, state, (state.time, 40), max_impacts=7)
            impacts.append(run.impacts)
            state = run.state
        assert len(impacts) > 1
        assert np.concatenate(impacts).tobytes() == whole.impacts.tobytes()
        assert state == whole.state


def test_what_it_says():
    """Its attributes are those of the motion where the run has ended, and its arrays are they."""
    run = vi.simulate(soft("force"), [0.0, 0.0], [0.3, -0.5], (0, 40))
    relaxing = run.regimes[run.regimes["state"][:, 0] == "relaxing"][0]
    t = 0.5 * (relaxing["start"] + relaxing["end"])
    state = vi.simulate(run.scene, [0.0, 0.0], [0.3, -0.5], (0, t)).state
    assert state.time == t
    assert state.mode == 0
    assert state.z.shape == (0,)
    assert state.regime == tuple(relaxing["state"])
    assert state.q == pytest.approx(run.position(t), abs=1e-14)
    # It comes back by c r' + k r = 0 from where the force was zero.
    left = -run.gap(0, relaxing["start"])
    assert state.remembered[0] == pytest.approx(left * np.exp(-20.0 * (t - relaxing["start"])), rel=1e-9)
    assert np.isnan(state.remembered[1:]).all()
    arrays = state.to_arrays()
    assert list(arrays) == ["time", "q", "v", "z", "mode", "regime", "remembered"]
    assert arrays["regime"].tolist() == list(state.regime)
    assert "stop[0] relaxing" in repr(state)
    with pytest.raises(AttributeError):
        state.time = 0.0


def test_it_is_that_of_a_run_that_was_saved(tmp_path):
    """A run from a file, or a pickle, has the same state."""
    run = vi.simulate(soft("force"), [0.0, 0.0], [0.3, -0.5], (0, 17.3), keep="impacts")
    run.save(tmp_path / "run.npz")
    for again in (vi.load(tmp_path / "run.npz"), pickle.loads(pickle.dumps(run))):
        assert again.state == run.state


def test_other_numbers_go_on_from_where_each_element_is():
    """In a scene with another force a stop that relaxes goes on from its place; position and velocity alone do not say it."""
    scene, start = soft("force"), ([0.0, 0.0], [0.3, -0.5])
    run = vi.simulate(scene, *start, (0, 40))
    relaxing = run.regimes[run.regimes["state"][:, 0] == "relaxing"]
    t = next(t for t in relaxing["start"] + 0.01 if -run.gap(0, t) > 0)
    state = vi.simulate(scene, *start, (0, t)).state
    other = scene.replace(forcing=vi.Harmonic([1.6, 0.4], 0.8))
    rest = vi.simulate(other, state, (t, 45))
    again = vi.simulate(other, rest.state, (45, 50))
    assert np.array_equal(again.final, vi.simulate(other, state, (t, 50)).final)
    plain = vi.simulate(other, state.q, state.v, (t, 45))
    assert "stop 0 was taken to relax" in plain.message
    assert "taken" not in rest.message
    inside = -run.gap(0, t)
    assert vi.simulate(other, state.q, state.v, (t, t)).state.remembered[0] == pytest.approx(inside, rel=1e-12)
    assert vi.simulate(other, state, (t, t)).state.remembered[0] == pytest.approx(state.remembered[0], rel=1e-15)
    assert state.remembered[0] > 1.01 * inside


@pytest.mark.parametrize("method", ["dop853", "rk45", "radau"])
def test_steps_go_on_to_their_tolerance(method):
    """Steps begin anew where another run has ended."""
    scene, start = soft("gap"), ([0.0, 0.0], [0.3, -0.5])
    whole = vi.simulate(scene, *start, (0, 12), method=method, rtol=1e-10)
    exact = vi.simulate(scene, *start, (0, 12))
    pressed = exact.regimes[exact.regimes["state"][:, 0] == "pressed"][1]
    t = 0.5 * (pressed["start"] + pressed["end"])
    for first in (method, "exact"):
        state = vi.simulate(scene, *start, (0, t), method=first, rtol=1e-10).state
        assert state.regime[0] == "pressed"
        rest = vi.simulate(scene, state, (t, 12), method=method, rtol=1e-10)
        assert rest.final[0] == pytest.approx(whole.final[0], abs=1e-8)
        assert rest.state.regime == whole.state.regime


def test_what_does_not_fit_is_refused():
    """A state of other elements, of another size, of another time."""
    scene = soft("force")
    state = vi.simulate(scene, [0.0, 0.0], [0.3, -0.5], (0, 3)).state
    run = vi.simulate(scene, [0.0, 0.0], [0.3, -0.5], (0, 40))
    met = run.regimes[run.regimes["state"][:, 0] == "relaxing"][0]
    relaxing = vi.simulate(scene, [0.0, 0.0], [0.3, -0.5], (0, 0.5 * (met["start"] + met["end"]))).state
    cases = [
        (vi.Scene(MASSES, FORCE, scene.stops[:2]), state, "state .*3 elements.*2"),
        (vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), stops=[vi.Stop(0, 1.0, 0.5)] * 3), state, "state .*degrees of freedom"),
        (soft("gap"), relaxing, r'state is "relaxing" at stop 0.*Spring'),
    ]
    for other, own, message in cases:
        with pytest.raises(ValueError, match=message):
            vi.simulate(other, own, (own.time, 40))
    with pytest.raises(ValueError, match=r"t_span .*begin at the time of the state, 3"):
        vi.simulate(scene, state, (2.9, 40))
    with pytest.raises(TypeError, match="takes the place of q0 and v0"):
        vi.simulate(scene, state, [0.0, 0.0], (3, 40))
    with pytest.raises(TypeError, match=r"simulate\(\) missing 2 required positional arguments: 'v0' and 't_span'"):
        vi.simulate(scene, [0.0, 0.0])
    made, (scene_, time, q, v, left) = state.__reduce__()
    for spoilt in ((left[0], [(7, 0.1)], left[2]), ([9], [], None), (left[0], left[1], (1e-9, None, left[2][2][:-1]))):
        with pytest.raises(ValueError, match=r"saved|other numbers"):
            vi.simulate(scene_, made(scene_, time, q, v, spoilt), (time, 40))


def test_ramps_in_levels_carry_states_from_level_to_level():
    """A run under a ramp whose value stays as long as it lasts is the run without it."""
    scene, start = vi.Scene(MASSES, FORCE, vi.Stop(1, 0.3, 0.4)), ([0.0, 0.0], [0.3, -0.5])
    whole = vi.simulate(scene, *start, (0, 40))
    state = vi.simulate(scene, *start, (0, 20)).state
    rest = vi.simulate(scene, state, (20, 40), ramp=vi.Ramp("restitution", 0.3, levels=2, dwell=100))
    assert rest.final[0] == pytest.approx(whole.final[0], abs=1e-9)
    assert rest.state.regime == whole.state.regime
