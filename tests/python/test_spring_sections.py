"""Sections and diagrams of motions with stops that give way."""

import numpy as np
import pytest

import vibroimpact as vi


def soft(release="gap", *more, damping=0.5):
    """Return a forced oscillator before a stop that gives way."""
    law = vi.Spring(20.0, damping, release=release)
    return vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([1.0], 0.8), [vi.Stop(0, 0.5, contact=law), *more])


@pytest.mark.parametrize("release", ["gap", "force", "clipped"])
def test_a_section_of_impacts_has_the_beginnings_of_contacts(release):
    """Of soft and rigid stops, in order of time, with the speed of the approach and the state there."""
    scene = soft(release, vi.Stop(0, 0.8, 0.8, side="lower"))
    run = vi.simulate(scene, 0.3, 0.0, (0, 200))
    contacts = run.contacts
    points = vi.poincare_points(run)
    assert np.array_equal(points.t, contacts["start"])
    assert np.array_equal(points.stop, contacts["stop"])
    assert points.speed_before == pytest.approx(contacts["speed_before"], rel=1e-12)
    assert {0, 1} == set(points.stop)
    assert points.q[points.stop == 0] == pytest.approx(0.5, rel=1e-12)
    alone = vi.poincare_points(run, stops=[0])
    assert np.array_equal(alone.t, contacts["start"][contacts["stop"] == 0])


def test_the_section_of_an_orbit_has_its_one_contact():
    """At its beginning, with the speed of the approach."""
    scene = soft()
    orbit = vi.find_orbit(scene, vi.simulate(scene, 0.3, 0.0, (0, 60 * scene.period)))
    points = vi.poincare_points(orbit)
    assert np.array_equal(points.stop, [0] * len(orbit.pattern))
    assert points.speed_before == pytest.approx(orbit.contacts["speed_before"], rel=1e-12)


@pytest.mark.parametrize("release", ["gap", "clipped"])
def test_a_diagram_has_what_runs_one_after_the_other_have(release):
    """Points, periods and patterns along a number of the scene; the state goes on from value to value."""
    values = np.linspace(0.4, 1.2, 9)
    diagram = vi.bifurcation_diagram(soft(release), ("forcing_scale", values), transient=80, periods=20)
    q, v = [0.0], [0.0]
    for k, value in enumerate(values):
        scene = soft(release).replace(forcing_scale=value)
        start = vi.simulate(scene, q, v, (0, 80 * scene.period), keep="final")
        run = vi.simulate(scene, *start.final, (start.t_end, start.t_end + 20 * scene.period))
        q, v = run.final
        own = diagram.index == k
        points = vi.poincare_points(run, phase=0.0)
        assert np.array_equal(diagram.q[own], points.q[:20])
        assert diagram.n_impacts[k] == np.isfinite(run.contacts["speed_before"]).sum()  # one may last as the run begins
        periods, pattern = diagram.n_periods[k], diagram.pattern[k]
        if periods:
            orbit = vi.find_orbit(scene, run)
            assert orbit.n_periods == periods
            assert pattern == orbit.pattern
    assert any(diagram.n_periods > 0)
    assert [0] in diagram.pattern


def test_a_diagram_of_contacts_has_their_beginnings():
    """Its points are those of the contacts, with their speeds."""
    diagram = vi.bifurcation_diagram(soft(), ("forcing_scale", [0.8]), section="impact", transient=100, periods=30)
    assert set(diagram.stop) == {0}
    assert (diagram.speed_before > 0).all()
    assert diagram.q == pytest.approx(0.5, rel=1e-12)


@pytest.mark.parametrize("direction", ["up", "down"])
def test_a_place_of_its_own_is_not_lost_from_value_to_value(direction):
    """A diagram of a stop that relaxes slowly has at each value the orbit there; without a transient its run goes on."""
    scene = soft("force", damping=20.0)
    values = np.array([0.9, 1.0, 1.1])
    diagram = vi.bifurcation_diagram(scene, ("forcing_scale", values), transient=100, periods=3, direction=direction)
    for k, value in enumerate(diagram.parameter):
        own = scene.replace(forcing_scale=value)
        orbit = vi.find_orbit(own, vi.simulate(own, 0.0, 0.3, (0, 200 * own.period)))
        assert diagram.n_periods[k] == orbit.n_periods == 1
        at_zero = (-orbit.phase / 0.8) % orbit.period
        assert diagram.q[diagram.index == k] == pytest.approx(np.tile(orbit.position(at_zero), (3, 1)), abs=1e-9)
    # The same value again: as one run that is not interrupted.
    again = vi.bifurcation_diagram(lambda value: scene, [1.0, 2.0, 3.0], transient=0, periods=1, q0=0.4, v0=1.5)
    run = vi.simulate(scene, 0.4, 1.5, (0, 3 * scene.period))
    assert again.q[:, 0] == pytest.approx(run.position(scene.period * np.arange(3))[:, 0], abs=1e-11)
