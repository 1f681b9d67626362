"""Sections and bifurcation diagrams: against orbits and single runs, the same bits whoever computes them, wrong calls."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest

import vibroimpact as vi

SCENE = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([1.0], 2.4), vi.Stop(0, 1.0, 0.8))
SHORT = {"transient": 20, "periods": 8}
FORCES = ("forcing_scale", [5.0, 6.5, 3.0, 9.0])


def scene_of(force):
    return SCENE.replace(forcing_scale=force)


def same(a, b):
    return a.pattern == b.pattern and all(x.tobytes() == b.to_arrays()[name].tobytes() for name, x in a.to_arrays().items())


class TestPoincarePoints:
    def test_a_motion_is_seen_once_in_a_period_and_after_its_impacts(self):
        run = vi.simulate(scene_of(9.0), 0.0, 0.0, (0.0, 20.3 * SCENE.period))
        points = vi.poincare_points(run, phase=1.0)
        assert np.allclose(np.diff(points.t), SCENE.period, rtol=1e-13)
        assert np.allclose(points.phase, 1.0)
        assert len(points.t) == 21
        assert (points.stop == -1).all()
        assert np.isnan(points.speed_before).all()
        assert np.array_equal(points.q[:, 0], run.along(0, points.t))
        hits = vi.poincare_points(run, stops=0)
        assert np.array_equal(hits.t, run.impacts["time"])
        assert np.array_equal(hits.speed_before, run.impacts["speed_before"])
        assert np.array_equal(hits.t, vi.poincare_points(run).t)
        assert np.allclose(hits.q, 1.0, atol=1e-12)
        assert np.allclose(hits.v[:, 0], -run.impacts["speed_after"], atol=1e-12)

    def test_an_orbit_has_as_many_points_as_periods(self):
        orbit = vi.periodic_orbits(vi.paper_scene(kind=3), [1], n_periods=2)[0]
        points = vi.poincare_points(orbit, phase=0.5)
        assert len(points.t) == 2
        assert np.allclose(points.phase, 0.5)
        assert len(vi.poincare_points(orbit).t) == 1

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({"phase": 0.0, "stops": 0}, "several of phase, stops and plane are given"),
            ({"plane": ([1, 0], 0.0), "stops": 0}, "several of phase, stops and plane are given"),
            ({"plane": ([1], 0.0)}, r"plane\[0\] has shape \(1,\), but \(2,\) is needed"),
            ({"plane": ([0, 0], 0.0)}, "plane is a row of zeros, but some number of it must not be zero"),
            ({"plane": ([1, 0], np.nan)}, r"plane\[1\] is NaN, but it must be finite"),
            ({"phase": np.inf}, "phase is inf, but it must be finite"),
            ({"stops": 1}, "stops is 1, but the scene has 1 stops"),
            ({"stops": -1}, "stops is -1, but indices count from 0"),
        ],
    )
    def test_wrong_sections_are_refused(self, arguments, message):
        run = vi.simulate(SCENE, 0.0, 0.0, (0.0, 9.0))
        with pytest.raises(ValueError, match=message):
            vi.poincare_points(run, **arguments)

    def test_a_plane_is_passed_upwards(self):
        free = vi.Scene(vi.LinearSystem(1, 0, 1), None, ())
        run = vi.simulate(free, 1.0, 0.0, (0.0, 100.0))
        points = vi.poincare_points(run, plane=([1, 0], 0.5))  # cos t
        assert np.allclose(points.t, (5 / 6 + np.arange(16)) * 2 * np.pi, rtol=1e-13)
        assert np.allclose(points.q, 0.5, atol=1e-13)
        assert (points.v > 0).all()
        assert (points.stop == -1).all()
        with pytest.raises(TypeError, match=r"plane is 3, but a pair \(row, value\) is needed"):
            vi.poincare_points(run, plane=3)

    def test_what_has_no_motion_or_no_period_is_refused(self):
        with pytest.raises(TypeError, match="a Trajectory or an Orbit is needed"):
            vi.poincare_points(SCENE)
        with pytest.raises(ValueError, match="keep"):
            vi.poincare_points(vi.simulate(SCENE, 0.0, 0.0, (0.0, 9.0), keep="final"), phase=0.0)
        free = vi.simulate(vi.Scene(SCENE.system, None, SCENE.stops), 0.5, 2.0, (0.0, 9.0))
        with pytest.raises(ValueError, match="needs a steady forcing with a period: the scene has none"):
            vi.poincare_points(free, phase=0.0)
        assert np.isnan(vi.poincare_points(free).phase).all()
        swept = vi.simulate(SCENE, 0.0, 0.0, (0.0, 9.0), ramp=vi.Ramp("frequency", 3.0, over=9.0))
        with pytest.raises(ValueError, match="goes along ramps"):
            vi.poincare_points(swept, phase=0.0)


class TestBifurcationDiagram:
    def test_each_value_goes_on_where_the_one_before_has_ended(self):
        diagram = vi.bifurcation_diagram(SCENE, FORCES, section="impact", **SHORT)
        assert diagram.parameter.tolist() == [3.0, 5.0, 6.5, 9.0]
        state = (np.zeros(1), np.zeros(1))
        for k, force in enumerate(diagram.parameter):
            scene, period = scene_of(force), SCENE.period
            transient = vi.simulate(scene, *state, (0.0, 20 * period))
            run = vi.simulate(scene, *transient.final, (20 * period, 28 * period))
            assert np.allclose(diagram.speed_before[diagram.index == k], run.impacts["speed_before"], rtol=1e-6)
            state = run.final

    @pytest.mark.parametrize("carry", [True, False])
    def test_whoever_computes_it_the_bits_are_the_same(self, carry):
        options = {"direction": "both", "carry": carry, **SHORT}
        alone = vi.bifurcation_diagram(SCENE, FORCES, workers=1, **options)
        assert alone.direction.tolist() == [1] * 4 + [-1] * 4
        assert same(alone, vi.bifurcation_diagram(SCENE, FORCES, workers=2, **options))
        with ThreadPoolExecutor(2) as pool:
            assert same(alone, vi.bifurcation_diagram(SCENE, FORCES, workers=pool, **options))
        with ProcessPoolExecutor(2) as pool:
            assert same(alone, vi.bifurcation_diagram(SCENE, FORCES, workers=pool, **options))
        assert same(alone, vi.bifurcation_diagram(SCENE, FORCES, workers=map, **options))
        made = vi.bifurcation_diagram(scene_of, FORCES[1], **options)
        assert made.name is None
        assert same(alone, made)

    def test_periods_and_patterns_are_named(self):
        diagram = vi.bifurcation_diagram(SCENE, ("forcing_scale", [1.0, 7.6, 9.0]), transient=3000)
        assert diagram.n_periods.tolist() == [1, 2, 1]
        assert diagram.pattern == ([], [0, 0], [0])
        assert diagram.n_impacts.tolist() == [0, 50, 50]
        assert set(diagram.status) == {"finished"}
        assert "1 of period 2" in repr(diagram)

    def test_nonlinear_scenes_and_walls_have_diagrams(self):
        scene = vi.paper_scene(kind=3, linear=False)
        diagram = vi.bifurcation_diagram(scene, ("amplitude", [0.01, 0.02]), method="taylor", transient=5, periods=4)
        assert len(diagram.index) == 8
        assert (diagram.status == "finished").all()

    def test_it_is_taken_apart_and_put_together(self):
        diagram = vi.bifurcation_diagram(SCENE, FORCES, **SHORT)
        data = pytest.importorskip("xarray") and diagram.to_xarray()
        assert data.sizes == {"value": 4, "point": 32, "dof": 1}
        assert np.array_equal(data["parameter"], diagram.parameter)
        with pytest.raises(ValueError, match="pattern has 3 entries, but 4 are needed"):
            vi.BifurcationDiagram(
                *[getattr(diagram, name) for name in ("name", "parameter", "direction", "n_periods", "n_impacts")],
                diagram.pattern[:3],
                diagram.status,
                diagram.index,
                diagram.stop,
                diagram.speed_before,
                diagram.phase,
                diagram.q,
                diagram.v,
            )

    @pytest.mark.parametrize(
        ("axis", "options", "message"),
        [
            (("forcing_scale", []), {}, "axis has shape"),
            (("forcing_scale", [1.0, np.nan]), {}, r"axis\[1\]"),
            (("frequency", [1.0, -1.0]), {}, r"axis\[1\]: frequency"),
            (("mass", [1.0]), {}, 'axis: .*"mass"'),
            (FORCES, {"direction": "left"}, 'direction is "left", but it must be "up", "down" or "both"'),
            (FORCES, {"section": "plane"}, 'section is "plane"'),
            (FORCES, {"transient": -1}, "transient is -1, but it must be at least 0"),
            (FORCES, {"periods": 0}, "periods is 0, but it must be at least 1"),
            (FORCES, {"stops": [2], "section": "impact"}, "stops is 2, but the scene has 1 stops"),
            (FORCES, {"q0": [0.0, 0.0]}, "q0"),
            (FORCES, {"workers": 0}, "workers is 0"),
        ],
    )
    def test_wrong_calls_are_refused_by_name(self, axis, options, message):
        with pytest.raises(ValueError, match=message):
            vi.bifurcation_diagram(SCENE, axis, **options)

    def test_scenes_that_have_none_are_refused(self):
        with pytest.raises(ValueError, match="without a forcing period"):
            vi.bifurcation_diagram(vi.Scene(SCENE.system, None, SCENE.stops), ("clearance", [1.0]))
        with pytest.raises(TypeError, match="but a Scene is needed"):
            vi.bifurcation_diagram(lambda force: force, [1.0])

    def test_stops_hit_together_are_one_return(self):
        stops = [vi.Stop(0, 0.5, 1.0), vi.Stop(1, 0.5, 1.0)]
        scene = vi.Scene(vi.LinearSystem([1.0, 1.0], None, [1.0, 1.0]), None, stops)
        found = vi.bifurcation_diagram(scene, ("clearance", [0.5]), section="impact", v0=[1.0, 1.0], transient=10, periods=8)
        assert found.stop.tolist() == [0, 1] * 4
        assert (found.n_periods.tolist(), found.pattern) == ([1], ([(0, 1)],))

    @pytest.mark.parametrize("section", ["phase", "impact"])
    @pytest.mark.parametrize("stops", [1, -1, [0, 3]])
    def test_stops_that_are_not_there_are_refused(self, section, stops):
        with pytest.raises(ValueError, match="stops"):
            vi.bifurcation_diagram(SCENE, FORCES, section=section, stops=stops, **SHORT)

    def test_a_phase_is_the_one_asked_for(self):
        run = vi.simulate(scene_of(9.0), 0.0, 0.0, (0.0, 30.3 * SCENE.period))
        for phase, told in [(0.0, 0.0), (-1.0, 2 * np.pi - 1.0), (7.0, 7.0 - 2 * np.pi)]:
            assert np.allclose(vi.poincare_points(run, phase=phase).phase, told, rtol=0, atol=1e-15)

    def test_without_a_period_impacts_are_counted(self):
        fed = vi.Scene(vi.LinearSystem(1, -0.1, 1), None, vi.Stop(0, 1.0, 0.5))
        axis = ("restitution", [0.2, 0.4, 0.6])
        found = vi.bifurcation_diagram(fed, axis, q0=0.1, v0=0.0, transient=60, periods=20, section="impact")
        assert found.n_periods.tolist() == [1, 1, 1]
        assert found.n_impacts.tolist() == [20, 20, 20]
        assert found.pattern == ([0], [0], [0])
        assert len(found.q) == 60
        run = vi.simulate(fed.replace(restitution=0.6), 1.0, -0.6 * found.speed_before[-1], (0, 20))
        assert np.allclose(run.impacts["speed_before"], found.speed_before[-1], rtol=1e-9)
        again = vi.bifurcation_diagram(fed, axis, q0=0.1, v0=0.0, transient=60, periods=20, section="impact", workers=map)
        assert same(again, found)
        assert vi.plot.bifurcation_diagram(found, along="speed_before")

    def test_the_error_of_a_callable_comes_out(self):
        def broken(force):
            if force > 5.0:
                raise RuntimeError("no such force")
            return scene_of(force)

        with pytest.raises(RuntimeError, match="no such force"):
            vi.bifurcation_diagram(broken, FORCES[1], **SHORT)
