"""Derivatives of orbits in Python: against orbits that are found beside, in optimisations, and what a user may get wrong."""

import pickle

import numpy as np
import pytest
from scipy.optimize import minimize

import vibroimpact as vi

SYSTEM = vi.LinearSystem(1.0, 0.1, 1.0)
NAMES = ("frequency", "clearance", "restitution", "forcing_scale", "damping_scale")


def scene(force=8.5, frequency=2.4, clearance=1.0, restitution=0.8):
    return vi.Scene(SYSTEM, vi.Harmonic([force], frequency), vi.Stop(0, clearance, restitution))


def orbit(**numbers):
    return vi.periodic_orbits(scene(**numbers), [0])[0]


def make(p):
    return scene(*p)


START = np.array([8.5, 2.4, 1.0, 0.8])


class TestOfAnOrbit:
    @pytest.mark.parametrize(("i", "name"), [(1, "frequency"), (2, "clearance"), (3, "restitution")])
    def test_are_those_of_orbits_beside(self, i, name):
        own = orbit()
        found = own.derivatives(name)
        assert found.parameters == (name,)
        assert found.reason == ""
        h = 1e-4 * np.eye(4)[i]
        sides = [vi.find_orbit(make(START + k * h), own) for k in (-2, -1, 1, 2)]

        def rate(values):
            a, b, c, d = (np.asarray(values(side)) for side in sides)
            return (a - d + 8 * (c - b)) / (12 * h[i])

        for values, own_rate in [
            (lambda o: o.q0, found.q0),
            (lambda o: o.v0, found.v0),
            (lambda o: [o.phase], found.phase),
            (lambda o: [o.period], found.period),
            (lambda o: o.impacts["speed_before"], found.speeds_before),
            (lambda o: o.impacts["time"], found.times),
            (lambda o: o.min_gap, found.min_gap),
            (lambda o: o.max_displacement, found.max_displacement),
        ]:
            np.testing.assert_allclose(np.ravel(own_rate), rate(values), rtol=1e-6, atol=1e-8)
        np.testing.assert_allclose(found.multipliers[:, 0], rate(lambda o: o.floquet_multipliers), rtol=1e-6)

    def test_a_callable_gives_what_names_give(self):
        own = orbit()
        by_name = own.derivatives(["forcing_scale", "frequency", "clearance", "restitution"])
        made = own.derivatives(make, start=START)
        assert made.parameters is None
        unit = np.array([8.5, 1, 1, 1])
        for name, values in by_name.to_arrays().items():
            np.testing.assert_allclose(getattr(made, name) * unit, values, rtol=1e-7, atol=1e-9, err_msg=name)

    def test_a_base_has_its_amplitude(self):
        base = vi.LinearSystem(1.0, 0.1, 1.0, influence=[1.0])
        moved = vi.Scene(base, vi.BaseMotion(1.5, 2.4), vi.Stop(0, 1.0, 0.8))
        own = vi.periodic_orbits(moved, [0])[0]
        found = own.derivatives(["forcing_scale", "amplitude"])
        np.testing.assert_allclose(found.speeds_before[:, 1] * 1.5, found.speeds_before[:, 0])
        np.testing.assert_allclose(found.multipliers[:, 1] * 1.5, found.multipliers[:, 0])

    def test_extremes_are_those_of_the_motion(self):
        stops = [vi.Stop(0, 1.0, 0.8), vi.Stop(0, 9.0, 0.8, side="lower")]
        own = vi.find_orbit(scene().replace(stops=stops), orbit())
        t = np.linspace(0, own.period, 20001)
        q = own.position(t)
        np.testing.assert_allclose(own.max_displacement, np.abs(q).max(axis=0), rtol=1e-6)
        assert own.min_gap[0] == 0.0
        np.testing.assert_allclose(own.min_gap[1], own.gap(1, t).min(), rtol=1e-6)

    def test_none_at_a_fold(self):
        branch = vi.continuation(orbit(force=1.0, frequency=2.8, clearance=-0.5), "forcing_scale", (0.2, 5.0))
        fold = next(own for own in branch.special if own.kind == "fold").orbit
        found = fold.derivatives(NAMES)
        assert all(np.isnan(values).all() for values in found.to_arrays().values())
        assert "fold" in found.reason
        assert "fold" in repr(found)

    def test_are_saved_and_pickled(self, tmp_path):
        found = orbit().derivatives(NAMES)
        found.save(tmp_path / "found.npz")
        for again in (vi.load(tmp_path / "found.npz"), pickle.loads(pickle.dumps(found))):
            assert again.parameters == NAMES
            assert again.reason == found.reason
            for name, values in found.to_arrays().items():
                np.testing.assert_array_equal(getattr(again, name), values)
        assert found.to_xarray().speeds_before.sel(number="clearance").shape == (1,)

    @pytest.mark.parametrize(
        ("arguments", "keywords", "error", "words"),
        [
            (("freq",), {}, ValueError, "parameters has 'freq'|parameters has \"freq\""),
            ((["clearance", "phase"],), {}, ValueError, "the phase shifts time alone"),
            (("clearance[3]",), {}, ValueError, "a number that the scene of the orbit has"),
            (("clearance",), {"start": [1.0]}, ValueError, "start is \\[1.0\\], but it is that of a callable"),
            ((make,), {}, ValueError, "start is None, but with a callable"),
            ((make,), {"start": [[8.5, 2.4]]}, ValueError, "start has shape"),
            ((make,), {"start": [8.5, 2.4, 1.1, 0.8]}, ValueError, "does not close in it"),
            ((lambda p: p,), {"start": [1.0]}, TypeError, "but a Scene is needed"),
            ((3,), {}, TypeError, "parameters is 3, but numbers of Scene.replace"),
            (([],), {}, ValueError, "but one name at least is needed, and each once"),
            ((["frequency", "frequency"],), {}, ValueError, "but one name at least is needed, and each once"),
        ],
    )
    def test_refuses(self, arguments, keywords, error, words):
        with pytest.raises(error, match=words):
            orbit().derivatives(*arguments, **keywords)

    def test_an_exception_of_a_callable_is_its_own(self):
        def broken(p):
            raise ZeroDivisionError("here")

        with pytest.raises(ZeroDivisionError, match="here"):
            orbit().derivatives(broken, start=[1.0])


def damper(p):
    """A ball in a box on a structure that is shaken at its frequency: the room and the restitution of the walls."""
    room, restitution = p
    mass = 0.1
    system = vi.LinearSystem([[1 + mass, mass], [mass, mass]], [[0.02, 0], [0, 0]], [[1, 0], [0, 0]])
    walls = [vi.Stop(1, room / 2, restitution), vi.Stop(1, room / 2, restitution, side="lower")]
    return vi.Scene(system, vi.Harmonic([0.1, 0], 1.0), walls)


class TestObjective:
    def test_gives_values_and_gradients(self):
        g = vi.objective(make, orbit(), "speeds_before[0]", start=START)
        p = START + np.array([0.5, 0.1, -0.2, 0.05])
        value, gradient = g(p)
        own = vi.find_orbit(make(p), g.orbit)
        assert value == pytest.approx(own.impacts["speed_before"][0], rel=1e-12)
        np.testing.assert_allclose(gradient, own.derivatives(make, start=p).speeds_before[0])
        np.testing.assert_array_equal(g.p, p)

    def test_takes_a_function(self):
        def energy(own, rates):
            u = own.impacts["speed_before"][0]
            return u**2 / 2, u * rates.speeds_before[0]

        g, plain = (vi.objective(make, orbit(), value, start=START) for value in (energy, "speeds_before[0]"))
        (value, gradient), (u, rate) = g(START), plain(START)
        assert value == pytest.approx(u**2 / 2)
        np.testing.assert_allclose(gradient, u * rate)

    def test_an_optimiser_finds_the_least_swing(self):
        start = np.array([0.6, 0.6])
        run = vi.simulate(damper(start), [0.1, 0.0], [0.0, 0.3], (0, 600 * 2 * np.pi))
        own = vi.find_orbit(damper(start), run)
        g = vi.objective(damper, own, "max_displacement[0]", start=start)
        bounds = [(0.3, 0.6), (0.5, 0.9)]
        found = minimize(g, [0.4, 0.85], jac=True, bounds=bounds, method="L-BFGS-B")
        assert found.fun < own.max_displacement[0]
        assert g.orbit.is_admissible
        np.testing.assert_allclose(found.jac[1], 0.0, atol=1e-4)  # the restitution is inside its bounds
        # Nowhere about it is less.
        for off in ([0.02, 0], [-0.02, 0], [0, 0.02], [0, -0.02]):
            p = np.clip(found.x + off, *np.transpose(bounds))
            assert vi.find_orbit(damper(p), g.orbit).max_displacement[0] >= found.fun - 1e-9

    def test_says_for_which_p_there_is_no_orbit(self):
        g = vi.objective(make, orbit(), "speeds_before[0]", start=START)
        with pytest.raises(vi.ConvergenceError, match=r"p = \[0.0, 2.4, 1.0, 0.8\], followed from \[8.5, 2.4, 1.0, 0.8\]: "):
            g([0.0, 2.4, 1.0, 0.8])
        np.testing.assert_array_equal(g.p, START)

    @pytest.mark.parametrize(
        ("value", "words"),
        [
            ("speed", "value is 'speed', but it must be an entry of q0, v0"),
            ("speeds_before", "speeds_before of this orbit is of 1 entries"),
            ("speeds_before[1]", "speeds_before of this orbit is of 1 entries"),
            ("phase[0]", "phase of this orbit is one number"),
            ("multipliers[0]", "must be an entry of"),
        ],
    )
    def test_refuses_values(self, value, words):
        with pytest.raises(ValueError, match=words):
            vi.objective(make, orbit(), value, start=START)

    def test_refuses_the_rest(self):
        own = orbit()
        with pytest.raises(TypeError, match="make is 3"):
            vi.objective(3, own, "period", start=START)
        with pytest.raises(TypeError, match="but an Orbit is needed"):
            vi.objective(make, 3, "period", start=START)
        with pytest.raises(ValueError, match="start has shape"):
            vi.objective(make, own, "period", start=1.0)
        g = vi.objective(make, own, "period", start=START)
        with pytest.raises(ValueError, match="but 4 finite numbers are needed"):
            g([1.0])
        g = vi.objective(make, own, lambda *_: (0.0, [1.0]), start=START)
        with pytest.raises(ValueError, match="the gradient of value has shape"):
            g(START)


class TestOfARun:
    def test_are_the_differences_of_runs_beside(self):
        own = scene()
        t = np.linspace(0.5, 9.5, 19)
        run = vi.simulate(own, 0.2, 1.0, (0, 10), t_eval=t, derivatives=NAMES)
        assert set(run.derivatives) == set(NAMES)
        assert len(run.impacts) > 2
        for name, value in [("frequency", 2.4), ("clearance", 1.0), ("restitution", 0.8), ("forcing_scale", 1.0)]:
            low, high = (vi.simulate(own.replace(**{name: value + h}), 0.2, 1.0, (0, 10), t_eval=t) for h in (-1e-6, 1e-6))
            rate = np.hstack([high.q - low.q, high.v - low.v]) / 2e-6
            np.testing.assert_allclose(run.derivatives[name], rate, rtol=1e-4, atol=1e-5 * np.abs(rate).max())

    def test_without_times_it_is_that_of_the_end(self):
        one = vi.simulate(scene(), 0.2, 1.0, (0, 7.3), derivatives="clearance").derivatives["clearance"]
        many = vi.simulate(scene(), 0.2, 1.0, (0, 7.3), t_eval=[1.0, 7.3], derivatives=["clearance"])
        assert one.shape == (2,)
        assert many.derivatives["clearance"].shape == (2, 2)
        # The time between makes two flights of one.
        np.testing.assert_allclose(one, many.derivatives["clearance"][1], rtol=1e-14)
        assert vi.simulate(scene(), 0.2, 1.0, (0, 7.3)).derivatives == {}

    def test_the_amplitude_of_a_base_counts_in_its_own_unit(self):
        system = vi.LinearSystem(1.0, 0.1, 1.0, influence=[1.0])
        own = vi.Scene(system, vi.BaseMotion(0.7, 1.3), vi.Stop(0, 0.5, 0.8))
        run = vi.simulate(own, 0.0, 0.0, (0, 20), derivatives=["amplitude", "forcing_scale"]).derivatives
        np.testing.assert_allclose(0.7 * run["amplitude"], run["forcing_scale"], rtol=1e-12)

    def test_where_there_is_none_the_message_says_why(self):
        own = vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), stops=vi.Stop(0, 1.0, 0.8))
        run = vi.simulate(own, 0.0, 1.0, (0, 5), t_eval=[1.0, 2.0], derivatives="damping_scale")
        assert np.isfinite(run.derivatives["damping_scale"][0]).all()
        assert np.isnan(run.derivatives["damping_scale"][1]).all()
        assert "grazes stop 0" in run.message

    def test_are_saved(self, tmp_path):
        run = vi.simulate(scene(), 0.2, 1.0, (0, 7.3), t_eval=[1.0, 7.3], derivatives=["clearance"])
        run.save(tmp_path / "run.npz")
        for other in (vi.load(tmp_path / "run.npz"), pickle.loads(pickle.dumps(run))):
            np.testing.assert_array_equal(other.derivatives["clearance"], run.derivatives["clearance"])
        assert "derivatives_clearance" in run.to_arrays()

    @pytest.mark.parametrize(
        ("options", "error", "message"),
        [
            ({"derivatives": "phase"}, ValueError, "shifts time alone"),
            (
                {"derivatives": ["freq"]},
                ValueError,
                r'derivatives has "freq" .it is called frequency here., but each must be a number of Scene.replace',
            ),
            ({"derivatives": 3}, TypeError, "derivatives is 3, but numbers of Scene.replace are needed"),
            ({"derivatives": "clearance[2]"}, ValueError, "a number that the scene"),
            ({"derivatives": "clearance", "keep": "final"}, ValueError, 'need keep="motion"'),
            ({"derivatives": "clearance", "ramp": vi.Ramp("frequency", 3.0, over=2.0)}, ValueError, "no ramp"),
        ],
    )
    def test_refuses(self, options, error, message):
        with pytest.raises(error, match=message):
            vi.simulate(scene(), 0.2, 1.0, (0, 7.3), **options)
