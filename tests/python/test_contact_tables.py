"""Contacts of runs that do not keep their motion."""

import pickle

import numpy as np
import pytest
from test_states import FORCE, MASSES, SCENES, TABLE, soft

import vibroimpact as vi

CHAIN = vi.Scene(
    vi.PendulumChain([1.0, 0.5], [0.5, 0.3], damping=0.05),
    vi.BaseMotion(0.06, 5.0),
    [vi.Wall(1, 0.0, 0.3), vi.Wall(0, -0.02, 0.5, side="left")],
)
PENDULUM = vi.Scene(vi.DoublePendulum(0.3, 0.7, damping=[0.2, 0.2]), vi.BaseMotion(0.1, 3.0), vi.Wall(1, 0.02, 0.5))
SIDEWAYS = vi.Scene(
    MASSES,
    FORCE,
    [
        vi.Stop(0, 0.2, contact=vi.Spring(30.0, 1.5, release="force"), reaction=[1.0, 0.3]),
        vi.Stop(1, 0.3, 0.4, reaction=[0.2, 1.0]),
    ],
)
ALL = SCENES | {
    "chain": (CHAIN, [0.0, 0.0], [0.3, 0.1]),
    "pendulum": (PENDULUM, [0.0, 0.0], [0.3, 0.1]),
    "reaction": (SIDEWAYS, [0.0, 0.0], [0.3, -0.5]),
    "rigid": (vi.Scene(MASSES, FORCE, [vi.Stop(1, 0.3, 0.4), vi.Stop(0, 0.2, 0.0)]), [0.0, 0.0], [0.3, -0.5]),
}


def assert_same(found, expected):
    """Check that two tables are one to rounding."""
    for name in ("stop", "start", "end"):
        assert np.array_equal(found[name], expected[name], equal_nan=name == "end")
    for name in expected.dtype.names[1:]:
        size = np.nanmax(np.abs(np.where(np.isfinite(expected[name]), expected[name], 0.0)), initial=0.0)
        assert found[name] == pytest.approx(expected[name], rel=1e-10, abs=1e-12 * size, nan_ok=True), name


def tables(scene, q0, v0, span, **options):
    """Return the contacts of a run with its motion and of one with its impacts alone."""
    whole = vi.simulate(scene, q0, v0, span, **options)
    alone = vi.simulate(scene, q0, v0, span, keep="impacts", **options)
    assert alone.final[0].tolist() == whole.final[0].tolist()
    assert alone.impacts.tobytes() == whole.impacts.tobytes()
    return alone, whole


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("end", [7.3, 40.0])
def test_they_are_those_of_a_run_that_keeps_all(name, end):
    """Exact flights and Taylor series, by their own method."""
    alone, whole = tables(*ALL[name], (0, end))
    assert len(whole.contacts) > 0
    assert_same(alone.contacts, whole.contacts)


@pytest.mark.parametrize("method", ["dop853", "rk45"])
@pytest.mark.parametrize("name", ["gap", "table", "held", "rigid"])
def test_in_steps_too(name, method):
    """The same with steps."""
    alone, whole = tables(*ALL[name], (0, 12.7), method=method, rtol=1e-8)
    assert_same(alone.contacts, whole.contacts)


def test_beside_samples_and_a_ramp():
    """Samples do not disturb it, nor levels of a ramp."""
    scene, start = ALL["rigid"][0], ALL["rigid"][1:]
    for options in ({"t_eval": np.linspace(0, 30, 50)}, {"ramp": vi.Ramp("frequency", 1.1, levels=3, dwell=1)}):
        alone, whole = tables(scene, *start, (0, 30), **options)
        if "ramp" in options:
            assert_same(alone.contacts, whole.contacts)
        else:
            assert_same(alone.contacts, vi.simulate(scene, *start, (0, 30)).contacts)


def test_a_state_goes_on_with_them():
    """A run that goes on begins in the contact in which the other ended."""
    scene, q0, v0 = soft("force"), [0.0, 0.0], [0.3, -0.5]
    whole = vi.simulate(scene, q0, v0, (0, 40))
    pressed = whole.regimes[whole.regimes["state"][:, 0] == "pressed"][2]
    t = 0.5 * (pressed["start"] + pressed["end"])
    state = vi.simulate(scene, q0, v0, (0, t), keep="impacts").state
    alone, kept = (vi.simulate(scene, state, (t, 40), keep=keep) for keep in ("impacts", "motion"))
    assert_same(alone.contacts, kept.contacts)
    assert np.isnan(alone.contacts["speed_before"][0])


def test_they_are_saved(tmp_path):
    """A pickle and a file have them; what keeps its end alone does not."""
    run = vi.simulate(TABLE, 0.0, -0.8, (0, 40), keep="impacts")
    run.save(tmp_path / "run.npz")
    for again in (pickle.loads(pickle.dumps(run)), vi.load(tmp_path / "run.npz")):
        assert again.contacts.tobytes() == run.contacts.tobytes()
        assert pickle.loads(pickle.dumps(again)).contacts.tobytes() == run.contacts.tobytes()
    with pytest.raises(ValueError, match="keep"):
        _ = vi.simulate(TABLE, 0.0, -0.8, (0, 40), keep="final").contacts


@pytest.mark.parametrize("name", ALL)
def test_those_of_many_runs(name):
    """Each run has its own, whether they run together, side by side, or each with its scene."""
    scene, q0, v0 = ALL[name]
    factors = np.linspace(0.5, 1.0, 9)
    starts = np.outer(factors, np.atleast_1d(v0))
    q0 = np.broadcast_to(np.atleast_1d(q0), starts.shape)
    each = [vi.simulate(scene, q, v, (0, 13.7)).contacts for q, v in zip(q0, starts, strict=True)]
    for scenes in (scene, [scene] * len(factors)):
        runs = vi.simulate_many(scenes, q0, starts, (0, 13.7), keep="impacts")
        assert runs.contacts.dtype.names == ("run", *each[0].dtype.names)
        for k, own in enumerate(each):
            found = runs.contacts[runs.contacts["run"] == k]
            assert_same(found[list(own.dtype.names)], own)
    assert vi.simulate_many(scene, q0, starts, (0, 5)).contacts is None
