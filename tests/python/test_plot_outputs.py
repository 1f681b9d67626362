"""Motions along a direction, stops across it, gaps, contact forces and spectra, as they are drawn."""

from types import SimpleNamespace

import numpy as np
import pytest
from plot_models import BouncingOrbit, BouncingTrajectory, curve, labelled

import vibroimpact as vi
import vibroimpact.plot as plot

TIP = np.array([1.0, -1.0])
BEAM = vi.Scene(
    vi.LinearSystem(np.ones(2), [0.02, 0.1], [1.0, 8.0]),
    vi.Harmonic(0.3 * TIP, 0.9),
    [vi.Stop(TIP, 0.5, 0.8), vi.Stop(2 * TIP, 1.0, 0.8, side="lower"), vi.Stop([1.0, 0.5], 9.0, 0.8)],
)
# A damper: a ball between two walls of a box that is driven.
DAMPER = vi.Scene(
    vi.LinearSystem([1.0, 0.05], [0.05, 0.0], [1.0, 0.0]),
    vi.Harmonic([0.3, 0.0], 1.0),
    [vi.Stop([-1.0, 1.0], 0.5, 0.7), vi.Stop([-1.0, 1.0], 0.5, 0.7, side="lower")],
)
HELD = vi.Scene(vi.LinearSystem(1.0, 0.0, 0.0, load=[-1.0]), vi.Harmonic(1.3, 1.0), vi.Stop(0, 0.0, 0.5, side="lower"))


def beam():
    return vi.simulate(BEAM, [0, 0], [0, 0], (0, 60))


class TestAlong:
    def test_the_tip_of_a_beam_keeps_between_its_stops(self):
        run = beam()
        ax = plot.time_history(run, along=TIP)
        t, tip = curve(ax)
        np.testing.assert_allclose(tip, run.along(TIP, t), rtol=0, atol=1e-12)
        walls = labelled(ax, "stop")
        assert [wall.get_label() for wall in walls] == ["stop 0", "stop 1"]
        np.testing.assert_allclose([wall.get_ydata()[0] for wall in walls], [0.5, -0.5], rtol=1e-15)
        assert np.max(np.abs(tip)) == pytest.approx(0.5, abs=1e-12)
        assert ax.get_ylabel() == "position n\u00b7q"

    def test_the_length_of_the_direction_scales_what_is_drawn(self):
        ax = plot.time_history(beam(), along=1e3 * TIP)
        np.testing.assert_allclose([wall.get_ydata()[0] for wall in labelled(ax, "stop")], [500.0, -500.0], rtol=1e-15)
        ax = plot.time_history(beam(), along=-TIP)
        np.testing.assert_allclose([wall.get_ydata()[0] for wall in labelled(ax, "stop")], [-0.5, 0.5], rtol=1e-15)

    def test_a_unit_vector_is_its_coordinate(self):
        for quantity in ("position", "velocity"):
            one, other = (
                curve(plot.time_history(BouncingOrbit(), along=along, quantity=quantity, periods=2)) for along in (1, [0.0, 1.0])
            )
            np.testing.assert_allclose(one, other, rtol=0, atol=1e-15)

    def test_the_velocity_along_a_direction_jumps_at_its_impacts(self):
        run = beam()
        ax = plot.phase_portrait(run, along=TIP)
        _, v = curve(ax)
        (rows,) = np.nonzero(np.isnan(v))
        hits = run.impacts[np.isin(run.impacts["time"], run.t)]
        assert len(rows) == len(hits)
        speeds = np.where(hits["stop"] == 0, hits["speed_before"], -hits["speed_before"] / 2)
        np.testing.assert_allclose(v[rows - 1], speeds, rtol=1e-9)

    def test_poincare_points_along_a_direction(self):
        run = beam()
        x, v = curve(plot.poincare_section(run, along=TIP, walls=True))
        times = BEAM.period * np.arange(len(x))
        np.testing.assert_allclose(x, run.along(TIP, times), atol=1e-12)
        np.testing.assert_allclose(v, run.along(TIP, times, 1), atol=1e-12)

    def test_lasting_contact_is_that_of_stops_that_push_along_it(self):
        run = vi.simulate(HELD, 0.3, 0.0, (0, 40))
        pair = vi.Scene(
            vi.LinearSystem(np.ones(2), np.zeros(2), [0.0, 1.0], load=[-1.0, 0.0]),
            vi.Harmonic([1.3, 0.5], 1.0),
            vi.Stop(0, 0.0, 0.5, side="lower"),
        )
        run = vi.simulate(pair, [0.3, 0.0], [0.0, 0.0], (0, 40))
        assert labelled(plot.time_history(run, along=[1.0, 1.0]), "stick")
        assert not labelled(plot.time_history(run, along=[0.0, 1.0]), "stick")

    def test_a_stop_that_moves_is_where_it_is_at_each_time(self):
        class Moving(BouncingOrbit):
            """Stop 0 is lowered by (1 - cos(pi t))/4."""

            def gap(self, stop, t):
                return super().gap(stop, t) + (0.25 * (1 - np.cos(np.pi * np.asarray(t))) if stop == 0 else 0.0)

        orbit = Moving()
        first = SimpleNamespace(normal=np.array([2.0, 0.0]), clearance=0.0, side="lower", motion="a motion")
        orbit.scene.stops = (first, *orbit.scene.stops[1:])
        (wall,) = labelled(plot.time_history(orbit, along=0), "stop 0")
        t = wall.get_xdata()
        np.testing.assert_allclose(wall.get_ydata(), -0.125 * (1 - np.cos(np.pi * t)), atol=1e-12)
        strip = [patch for patch in plot.phase_portrait(orbit, along=0).patches if patch.get_label() == "stop 0"]
        assert [patch.get_extents().width > 0 for patch in strip] == [True]


class TestGap:
    def test_of_an_orbit_over_one_period(self):
        t, h = curve(plot.gap(BouncingOrbit(), 0))
        assert (round(t[0], 6), round(t[-1], 6)) == (0.0, 2.0)
        np.testing.assert_allclose(h, 2 * (t - t**2 / 2), atol=1e-8)

    def test_of_a_dampers_ball(self):
        run = vi.simulate(DAMPER, [0, 0], [0, 0], (0, 80))
        ax = plot.gap(run, 0, t_span=(40, 80))
        plot.gap(run, 1, ax, t_span=(40, 80))
        t, h = curve(ax)
        np.testing.assert_allclose(h, run.gap(0, t), rtol=0, atol=1e-9)
        others = [line for line in ax.lines if line.get_label() == "h[1]"]
        np.testing.assert_allclose(others[0].get_ydata(), 1.0 - run.gap(0, others[0].get_xdata()), rtol=0, atol=1e-9)
        hits = [line for line in ax.lines if line.get_label().lstrip("_") == "impacts"]
        inside = run.impacts[run.impacts["time"] >= 40]
        assert [len(line.get_xdata()) for line in hits] == [np.count_nonzero(inside["stop"] == stop) for stop in (0, 1)]
        assert ax.get_ylabel() == "gap h"

    def test_it_is_smooth_between_impacts(self):
        run = vi.simulate(DAMPER, [0, 0], [0, 0], (0, 40))
        t, h = curve(plot.gap(run, 0))
        middle = 0.5 * (t[1:] + t[:-1])
        assert np.max(np.abs(run.gap(0, middle) - 0.5 * (h[1:] + h[:-1]))) < 4e-3 * np.ptp(h)

    def test_a_motion_that_was_not_kept(self):
        for draw in (plot.gap, plot.contact_force):
            with pytest.raises(ValueError, match="keep"):
                draw(BouncingTrajectory(keeps_motion=False), 0)


class TestContactForce:
    def test_it_is_broken_where_it_jumps(self):
        run = vi.simulate(HELD, 0.3, 0.0, (0, 40))
        t, force = curve(plot.contact_force(run, 0))
        seen = np.isfinite(force)
        sticks = run.segments[run.segments["kind"] == "stick"]
        inside = np.any([(t > row["start"]) & (t < row["end"]) for row in sticks], axis=0)
        np.testing.assert_allclose(force[seen & inside], 1.0 - 1.3 * np.cos(t[seen & inside]), atol=1e-9)
        assert not np.any(force[seen & ~inside])
        assert np.isnan(force).any()

    def test_that_of_an_orbit_comes_again_in_every_period(self):
        orbit = vi.find_orbit(HELD, vi.simulate(HELD, 0.3, 0.0, (0, 12 * HELD.period)))
        t, force = curve(plot.contact_force(orbit, 0, t_span=(0, 3 * orbit.period)))
        seen = np.isfinite(force)
        np.testing.assert_allclose(force[seen], orbit.contact_force(0, t[seen]), atol=1e-9)
        n_jumps = [np.count_nonzero(~seen & (t > k * orbit.period) & (t < (k + 1) * orbit.period)) for k in range(3)]
        assert n_jumps[0] == n_jumps[1] == n_jumps[2] > 0
        assert np.max(force[seen & (t > 2 * orbit.period)]) == pytest.approx(np.max(force[seen & (t < orbit.period)]), rel=1e-3)


class TestSpectrum:
    def test_a_harmonic_has_a_peak_of_its_amplitude(self):
        scene = vi.Scene(vi.LinearSystem([1.0, 1.0], np.zeros(2), [4.0, 9.0]))
        run = vi.simulate(scene, [0.3, 0.1], [0.0, 0.0], (0, 40 * np.pi))  # 40 and 60 whole periods
        w, amplitude = curve(plot.spectrum(run, along=[1.0, 2.0]))
        for frequency, height in ((2.0, 0.3), (3.0, 0.2)):
            peak = np.argmin(np.abs(w - frequency))
            assert w[peak] == pytest.approx(frequency, rel=1e-12)
            assert amplitude[peak] == pytest.approx(height, rel=1e-9)
        # Hann's window: a line is four steps wide, and nothing beyond it.
        beyond = np.min(np.abs(w[:, None] - [2.0, 3.0]), axis=1) > 2.5 * w[0]
        assert np.max(amplitude[beyond]) < 1e-9
        _, velocity = curve(plot.spectrum(run, along=0, quantity="velocity"))
        assert velocity[np.argmin(np.abs(w - 2.0))] == pytest.approx(0.6, rel=1e-9)

    def test_a_line_between_two_steps_is_lower_by_fifteen_percent(self):
        scene = vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0))
        run = vi.simulate(scene, 1.0, 0.0, (0, 40.5 * 2 * np.pi))
        _, amplitude = curve(plot.spectrum(run))
        assert np.max(amplitude) == pytest.approx(0.8488, abs=2e-4)  # of Hann's window half a step off its middle: 8/(3 pi)

    def test_impacts_make_harmonics_of_the_forcing(self):
        run = beam()
        w, amplitude = curve(plot.spectrum(run, along=TIP, t_span=(20, 60)))
        assert w[np.argmax(amplitude)] == pytest.approx(0.9, abs=0.2)
        assert w[-1] > 100 * 0.9

    def test_a_transient_may_be_left_out_and_rows_at_equal_steps_will_do(self):
        scene = vi.Scene(vi.LinearSystem(1.0, 0.2, 1.0), vi.Harmonic(1.0, 0.5))
        t = np.linspace(20 * scene.period, 60 * scene.period, 40 * 32, endpoint=False)
        rows = vi.simulate(scene, 0.0, 0.0, (0, 60 * scene.period), keep="final", t_eval=t)
        w, amplitude = curve(plot.spectrum(rows))
        assert w[np.argmax(amplitude)] == pytest.approx(0.5, rel=1e-9)
        assert np.max(amplitude) == pytest.approx(1 / abs(1 - 0.25 + 0.1j), rel=1e-6)
        uneven = vi.simulate(scene, 0.0, 0.0, (0, 60), keep="final", t_eval=[0.0, 1.0, 3.0, 4.0, 5.0])
        with pytest.raises(ValueError, match="rows at equal steps"):
            plot.spectrum(uneven)

    @pytest.mark.parametrize("samples", [3, 2.5, 2**21, "many"])
    def test_refuses_numbers_of_samples(self, samples):
        with pytest.raises(ValueError, match="samples must be an integer from 4 to 1048576, got"):
            plot.spectrum(beam(), samples=samples)

    def test_an_orbit_has_no_spectrum_of_its_own(self):
        with pytest.raises(ValueError, match="trajectory must be one trajectory, got BouncingOrbit"):
            plot.spectrum(BouncingOrbit())
