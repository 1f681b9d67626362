"""Existence maps and ensembles: the fold's closed form, cells against `periodic_orbits`, the same bits whoever computes them."""

from __future__ import annotations

import itertools
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import vibroimpact as vi


def paper_map(workers=None):
    x, y = ("frequency", np.linspace(1.3, 1.7, 30)), ("clearance", np.linspace(0.05, 0.3, 20))
    return vi.existence_map(vi.paper_scene(3), [1], x, y, 2, workers=workers)


def same(a, b):
    return all(value.tobytes() == b.to_arrays()[name].tobytes() for name, value in a.to_arrays().items())


def make_scene(mass_ratio, length_ratio):
    stops = vi.paper_scene(3).stops
    return vi.Scene(vi.paper_system(mass_ratio, length_ratio, 0.05), vi.BaseMotion(0.1 / 2.25, 1.5), stops)


def stop_at(clearance):
    return vi.Stop(1, clearance, 0.9, reaction="coordinate")


class TestExistenceMap:
    def test_ten_cells_are_those_of_periodic_orbits(self):
        found = paper_map()
        rng = np.random.default_rng(1)
        for _ in range(10):
            i, j = rng.integers(30), rng.integers(20)
            scene = vi.paper_scene(3).replace(frequency=found.x[i], clearance=found.y[j])
            orbits = vi.periodic_orbits(scene, [1], 2)
            assert found.n_orbits[j, i] == len(orbits)
            assert found.is_admissible[j, i] == any(o.is_admissible for o in orbits)
            assert found.is_stable[j, i] == any(o.is_admissible and o.is_stable for o in orbits)
            if len(orbits):
                largest = abs(orbits[0].floquet_multipliers).max()
                assert found.multiplier[j, i] == pytest.approx(largest, rel=1e-9)
            else:
                assert np.isnan(found.multiplier[j, i])

    @pytest.mark.parametrize(("pattern", "n_periods"), [([0], 2), ([0, 0], 2), ([0, 1], 1)])
    def test_every_cell_is_that_of_periodic_orbits(self, pattern, n_periods):
        stops = [vi.Stop(0, 0.5, 0.8)] + [vi.Stop(0, 0.5, 0.8, side="lower")] * (1 in pattern)
        scene = vi.Scene(vi.LinearSystem(1.0, 0.04, 1.0), vi.Harmonic(1.0, 2.8), stops)
        x, y = np.linspace(0.9, 3.1, 7), np.linspace(0.3, 2.0, 5)
        found = vi.existence_map(scene, pattern, ("frequency", x), ("forcing_scale", y), n_periods)
        for (j, scale), (i, frequency) in itertools.product(enumerate(y), enumerate(x)):
            orbits = vi.periodic_orbits(scene.replace(frequency=frequency, forcing_scale=scale), pattern, n_periods)
            admissible = [o for o in orbits if o.is_admissible]
            assert found.n_orbits[j, i] == len(orbits)
            assert found.is_admissible[j, i] == bool(admissible)
            assert found.is_stable[j, i] == any(o.is_stable for o in admissible)
            largest = abs(orbits[0].floquet_multipliers).max() if len(orbits) else np.nan
            assert found.multiplier[j, i] == pytest.approx(largest, rel=1e-9, nan_ok=True)
        # the map has cells of every kind: one that tells nothing apart would prove nothing
        assert len(np.unique(found.n_orbits)) > 1
        assert np.any(found.is_admissible & ~found.is_stable)
        assert np.any(found.is_stable)
        assert len(np.unique(found.multiplier[np.isfinite(found.multiplier)].round(6))) > 3

    def test_the_fold_line_is_the_closed_form(self):
        # One mode, e = 0: v+ = 0 at the contact, so q(0) = alpha . u with alpha from s alone: after the impact the free
        # motion z starts at -s_v(0) in velocity and z_q(0) from z_q(0) = z_q(T), v- = v+ + p.
        w0, eta, w = 1.0, 0.1, 2.8
        period = 2 * np.pi / w
        wd = np.sqrt(w0**2 - eta**2)
        s, c = np.exp(-eta * period) * np.array([np.sin(wd * period) / wd, np.cos(wd * period)])
        propagator = np.array([[c + eta * s, s], [-(w0**2) * s, c - eta * s]])
        unit = np.linalg.solve(np.eye(2) - propagator, [0, -1])
        steady = 1 / (w0**2 - w**2 + 2j * eta * w)
        velocity = 1j * w * steady
        # v+ = Re(velocity u) + unit[1] p = 0; q = Re(steady u) + unit[0] p
        alpha = steady - unit[0] / unit[1] * velocity
        system = vi.LinearSystem(1.0, 2 * eta, w0**2)
        scene = vi.Scene(system, vi.Harmonic(1.0, w), vi.Stop(0, 0.5, 0.0))
        fold = 0.5 / abs(alpha)
        scales = fold * np.array([0.5, 1 - 1e-9, 1 + 1e-9, 2.0])
        found = vi.existence_map(scene, [0], ("forcing_scale", scales), ("clearance", [0.5]))
        assert found.n_orbits.tolist() == [[0, 0, 2, 2]]

    def test_the_bits_do_not_depend_on_the_workers(self):
        one = paper_map(workers=1)
        assert same(one, paper_map(workers=2))
        assert same(one, paper_map())
        assert same(one, paper_map(workers=map))
        with ThreadPoolExecutor(2) as threads, ProcessPoolExecutor(2) as processes:
            assert same(one, paper_map(workers=threads))
            assert same(one, paper_map(workers=processes))

    def test_a_callable_makes_the_scenes(self):
        found = vi.existence_map(make_scene, [1], [1.0, 2.0], [3.0, 3.2, 3.4], 2)
        assert found.n_orbits.shape == (3, 2)
        assert found.x_name is None
        assert found.n_orbits[1, 0] == len(vi.periodic_orbits(make_scene(1.0, 3.2), [1], 2))
        with ProcessPoolExecutor(2) as pool:
            assert same(found, vi.existence_map(make_scene, [1], [1.0, 2.0], [3.0, 3.2, 3.4], 2, workers=pool))

    def test_the_amplitude_of_a_base_motion_is_a_number_to_vary(self):
        scene = vi.paper_scene(3)
        x, y = ("amplitude", [0.02, 0.05, -0.05]), ("clearance[1]", [0.1, 0.2])
        found = vi.existence_map(scene, [1], x, y, 2)
        assert found.x_name == "amplitude"
        assert found.x.tolist() == [0.02, 0.05, -0.05]
        scenes = lambda a, d: scene.replace(amplitude=a).replace(stops=[scene.stops[0], stop_at(d)])  # noqa: E731
        called = vi.existence_map(scenes, [1], x[1], y[1], 2)
        assert np.array_equal(found.n_orbits, called.n_orbits)
        assert np.array_equal(found.is_stable, called.is_stable)
        assert np.allclose(found.multiplier, called.multiplier, rtol=1e-9, equal_nan=True)

    @pytest.mark.parametrize("pattern", [[0], [0, 0]])
    @pytest.mark.parametrize(
        ("name", "values"),
        [
            ("frequency", [2.8, 1e-297, 1e-3]),  # a phase that is lost; growth by exp(1570)
            ("forcing_scale", [1.0, 1e308, 1e307]),  # equations that overflow
        ],
    )
    def test_a_motion_that_doubles_do_not_hold_is_no_orbit(self, pattern, name, values):
        scene = vi.Scene(vi.LinearSystem(1.0, -0.5, 1.0), vi.Harmonic(1e3, 2.8), vi.Stop(0, 0.5, 0.8))
        found = vi.existence_map(scene, pattern, (name, values), ("clearance", [0.5]))
        alone = vi.existence_map(scene, pattern, (name, values[:1]), ("clearance", [0.5]))
        assert found.n_orbits.tolist() == [[alone.n_orbits[0, 0], 0, 0]]
        assert not found.is_admissible[0, 1:].any()
        assert not found.is_stable[0, 1:].any()
        assert np.all(np.isnan(found.multiplier[0, 1:]))

    @pytest.mark.parametrize(
        ("x", "message"),
        [
            (("speed", [1.0]), "speed"),
            (("frequency", [0.0]), "frequency"),
            (("restitution", [1.2]), "restitution"),
            (("clearance[7]", [0.1]), "clearance"),
            (("frequency", []), "x has shape"),
            ([1.0, 2.0], "x is"),
        ],
    )
    def test_bad_axes_are_refused(self, x, message):
        with pytest.raises(ValueError, match=message):
            vi.existence_map(vi.paper_scene(3), [1], x, ("forcing_scale", [1.0]), 2)

    @pytest.mark.parametrize("workers", [0, -1, True, "all"])
    def test_bad_workers_are_refused(self, workers):
        with pytest.raises(ValueError, match="workers"):
            paper_map(workers=workers)

    def test_forty_modes_of_a_beam_between_two_stops(self):
        # A cantilever: beta_j L of the first modes, then (j + 1/2) pi; tip shape 2 (-1)^j for unit modal masses.
        roots = np.array([1.8751, 4.6941, 7.8548] + [(j + 0.5) * np.pi for j in range(3, 40)])
        w = (roots / roots[0]) ** 2
        tip = 2.0 * (-1.0) ** np.arange(40)
        stops = [vi.Stop(tip, 0.5, 0.8), vi.Stop(tip, 0.5, 0.8, side="lower")]
        scene = vi.Scene(vi.LinearSystem(np.ones(40), 2 * 0.02 * w, w**2), vi.Harmonic(0.1 * tip, 0.9), stops)
        x, y = ("frequency", np.linspace(0.7, 1.4, 4)), ("forcing_scale", [0.5, 1.0, 2.0])
        found = vi.existence_map(scene, [0], x, y)
        assert found.n_orbits.shape == (3, 4)
        assert found.n_orbits.max() == 2


class TestSimulateMany:
    def test_the_ends_have_the_bits_of_single_runs(self):
        scene = vi.paper_scene(3)
        rng = np.random.default_rng(2)
        q0, v0 = rng.uniform(-0.1, 0.1, (2, 100, 2))  # more than the pieces that an executor gets
        single = [vi.simulate(scene, q, v, (0, 200), keep="final") for q, v in zip(q0, v0, strict=True)]
        for workers in (None, 1, 2, map):
            ends = vi.simulate_many(scene, q0, v0, (0, 200), workers=workers)
            assert np.array_equal(ends.q, [run.final[0] for run in single])
            assert np.array_equal(ends.v, [run.final[1] for run in single])
            assert ends.n_impacts.tolist() == [run.stats.n_impacts for run in single]
            assert set(ends.status) == {"finished"}

    def test_one_degree_of_freedom_takes_plain_numbers(self):
        scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), None, vi.Stop(0, 0.5, 1.0))
        ends = vi.simulate_many(scene, [0.0, 0.1], [0.2, 0.3], (0, 2 * np.pi))
        assert ends.q.shape == (2, 1)
        assert ends.q[0, 0] == pytest.approx(0.0, abs=1e-14)

    def test_bad_rows_are_named(self):
        ends = vi.simulate_many(vi.paper_scene(3), [[0, 0], [9, 9]], np.zeros((2, 2)), (0, 1))
        assert ends.status.tolist() == ["finished", "inside_stop"]
        with pytest.raises(ValueError, match="v0"):
            vi.simulate_many(vi.paper_scene(3), np.zeros((3, 2)), np.zeros((2, 2)), (0, 1))
        with pytest.raises(ValueError, match="keep"):
            vi.simulate_many(vi.paper_scene(3), np.zeros((3, 2)), np.zeros((3, 2)), (0, 1), keep="motion")
