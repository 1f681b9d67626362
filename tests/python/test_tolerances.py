"""The absolute tolerance: without a number the same run in every unit of length, with one that number; what a run says of it."""

import json
import math

import numpy as np
import pytest

import vibroimpact as vi

#: By what a change of the unit multiplies all lengths: nanometres counted in metres, metres in kilometres, in millimetres.
UNITS = [1e-9, 1e-3, 1e3]
START = [-0.1, 0.05], [1.0, -0.4]


def linear(unit=1.0):
    """Two masses between two stops, all lengths so many times as long."""
    system = vi.LinearSystem(np.diag([1.0, 1.5]), [[0.2, -0.1], [-0.1, 0.3]], [[3.0, -1.0], [-1.0, 2.0]])
    stops = [vi.Stop(0, 0.4 * unit, 0.7), vi.Stop([0.5, -1.0], 0.5 * unit, 0.8, side="lower")]
    return vi.Scene(system, vi.Harmonic(np.array([2.0, 1.0]) * unit, 1.7, 0.3), stops)


def hardening(unit=1.0):
    """The same masses on springs that harden with the square of a deflection."""

    def field(t, q, v):
        x = np.asarray(q) / unit
        return -np.array([3 * q[0] - q[1], 2 * q[1] - q[0]]) - 0.2 * np.asarray(v) - unit * x**3

    one = linear(unit)
    return vi.Scene(vi.NonlinearSystem(2, field, mass=np.diag([1.0, 1.5])), one.forcing, one.stops)


def run(make, unit, method, **options):
    q0, v0 = (np.array(x) * unit for x in START)
    return vi.simulate(make(unit), q0, v0, (0.0, 6.0), method=method, t_eval=np.linspace(0.0, 6.0, 13), **options)


@pytest.mark.parametrize(
    ("make", "method", "bound"),
    [
        (linear, "auto", 1e-10),
        (linear, "rk45", 1e-7),
        (linear, "dop853", 1e-7),
        (linear, "radau", 1e-7),
        (hardening, "auto", 1e-7),
        (hardening, "rk45", 1e-7),
    ],
)
def test_no_number_is_the_same_run_in_every_unit(make, method, bound):
    metres = run(make, 1.0, method)
    assert len(metres.impacts) >= 3
    for unit in UNITS:
        other = run(make, unit, method)
        assert len(other.impacts) == len(metres.impacts)
        # The same steps: a tolerance of a length that is none in another unit would take others.
        assert other.stats.n_steps == pytest.approx(metres.stats.n_steps, rel=0.02, abs=1)
        np.testing.assert_allclose(other.impacts["time"], metres.impacts["time"], rtol=0, atol=bound)
        np.testing.assert_allclose(other.q / unit, metres.q, rtol=0, atol=bound)
        np.testing.assert_allclose(other.v / unit, metres.v, rtol=0, atol=bound)
        assert other.stats.atol == pytest.approx(unit * metres.stats.atol, rel=1e-12)


@pytest.mark.parametrize("make", [linear, hardening])
def test_a_number_is_a_length_in_the_units_of_the_scene(make):
    given = {unit: run(make, unit, "dop853", atol=1e-6) for unit in (1.0, 1e9, 1e-3)}
    assert {own.stats.atol for own in given.values()} == {1e-6}
    # The larger a part of the motion it is, the fewer the steps.
    steps = {unit: own.stats.n_steps for unit, own in given.items()}
    assert steps[1e-3] < steps[1.0] <= steps[1e9]
    # The same length in every unit is the same run.
    metres = run(make, 1.0, "dop853", atol=1e-9)
    for unit in UNITS:
        other = run(make, unit, "dop853", atol=1e-9 * unit)
        assert other.stats.atol == 1e-9 * unit
        np.testing.assert_allclose(other.q / unit, metres.q, rtol=0, atol=1e-7)


def test_what_a_run_says_of_its_tolerance():
    system = vi.LinearSystem(1.0, 0.1, 1.0)

    def atol(clearance, start, **options):
        stops = () if clearance is None else vi.Stop(0, clearance, 0.8)
        return vi.simulate(vi.Scene(system, stops=stops), start, 0.0, (0.0, 1.0), **options).stats.atol

    assert atol(3.0, -2.0) == pytest.approx(3e-12, rel=1e-12)
    assert atol(3.0, -5.0) == pytest.approx(5e-12, rel=1e-12)
    assert atol(3.0, -5.0, atol=None) == atol(3.0, -5.0)
    # No length at all, and nothing that has a tolerance.
    assert atol(0.0, 0.0) == 1e-12
    assert atol(None, 1.0) == 0.0
    assert atol(None, 2.0, method="dop853") == pytest.approx(2e-12, rel=1e-12)
    for method in ("auto", "dop853"):
        assert atol(3.0, -2.0, method=method, atol=1e-6) == 1e-6


def test_a_saved_run_knows_its_tolerance(tmp_path):
    path = tmp_path / "run.npz"
    for options in ({}, {"atol": 3e-9}, {"method": "dop853"}):
        made = run(linear, 1e3, options.pop("method", "auto"), **options)
        made.save(path)
        assert vi.load(path).stats.atol == made.stats.atol > 0.0


def test_a_run_saved_by_0_2_0_does_not_know_its_tolerance(tmp_path):
    """It has none; all else is read, and what is not known is nan, also where it is saved again."""
    path = tmp_path / "run.npz"
    made = run(linear, 1.0, "dop853")
    made.save(path)
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    header = json.loads(str(arrays.pop("header")))
    entries = header["arguments"][0]["dict"]
    header["arguments"][0]["dict"] = [entry for entry in entries if entry[0] != "atol"]
    assert len(header["arguments"][0]["dict"]) == len(entries) - 1
    np.savez(path, header=np.array(json.dumps(header)), **arrays)
    for _ in range(2):
        old = vi.load(path)
        assert math.isnan(old.stats.atol)
        assert old.stats.n_steps == made.stats.n_steps
        assert np.array_equal(old.q, made.q)
        old.save(path)
