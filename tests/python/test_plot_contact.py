"""Energy, impact speeds, and the marks of impacts and lasting contact, of simulated motions."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

import vibroimpact as vi


def slow_oscillator(t_eval=None, keep="motion"):
    """Pushed slowly against a stop: it hits, chatters and sticks."""
    scene = vi.Scene(vi.LinearSystem([1.0], [0.1], [1.0]), vi.Harmonic([1.0], 0.3), vi.Stop(0, 0.2, 0.6))
    return vi.simulate(scene, [0.0], [0.0], (0, 45), t_eval=t_eval, keep=keep)


def shuttle(n_impacts, restitution=1.0):
    """A free particle between stops at 1 and -1, speed 2 at the start."""
    stops = [vi.Stop(0, 1.0, restitution), vi.Stop(0, 1.0, restitution, side="lower")]
    scene = vi.Scene(vi.LinearSystem([1.0], [0.0], [0.0]), None, stops)
    return vi.simulate(scene, [0.0], [2.0], (0, n_impacts), keep="impacts")


def held_orbit():
    """A ball that chatters to rest on a shaken table and is let go where the table falls faster than it would."""
    ball = vi.LinearSystem([1.0], [0.0], [0.0], load=[-1.0])
    scene = vi.Scene(ball, vi.Harmonic([1.3], 1.0), [vi.Stop(0, 0.0, 0.5, side="lower")])
    return vi.find_orbit(scene, vi.simulate(scene, 0.3, 0.0, (0, 12 * scene.period)))


def line(ax, label):
    every = [drawn for panel in ax.figure.axes for drawn in panel.lines]
    (found,) = [drawn for drawn in every if drawn.get_label() == label]
    return np.asarray(found.get_xdata(), float), np.asarray(found.get_ydata(), float)


class TestEnergy:
    def test_what_is_stored_is_what_came_less_what_was_lost(self):
        ax = vi.plot.energy(slow_oscillator())
        names = ("kinetic + potential", "work of the forcing", "lost in dampers", "lost at impacts")
        stored, work, damped, lost = (line(ax, name)[1] for name in names)
        np.testing.assert_allclose(stored, stored[0] + work - damped - lost, atol=1e-8)
        np.testing.assert_allclose(line(ax, "kinetic")[1] + line(ax, "potential")[1], stored)
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("time t", "energy")

    def test_two_panels_share_their_time_and_are_found_again(self):
        ax = vi.plot.energy(slow_oscillator())
        _, lower = ax.figure.axes
        assert (lower.get_xlabel(), lower.get_ylabel()) == ("time t", "energy exchanged")
        assert not ax.xaxis.label.get_visible()
        assert [text.get_text() for text in lower.get_legend().get_texts()][1:] == ["lost in dampers", "lost at impacts"]
        vi.plot.energy(slow_oscillator(), ax, label="again")
        assert ax.figure.axes == [ax, lower]
        assert len(lower.lines) == 6
        ax.set_xlim(1.0, 2.0)
        assert lower.get_xlim() == (1.0, 2.0)

    @pytest.mark.parametrize("place", [None, (0.1, 0.1, 0.4, 0.8)])
    def test_given_axes_are_halved(self, place):
        figure = plt.figure()
        ax = figure.add_subplot(1, 2, 1) if place is None else figure.add_axes(place)
        whole = ax.get_position()
        vi.plot.energy(slow_oscillator(), ax)
        upper, lower = (panel.get_position() for panel in figure.axes)
        assert lower.y1 < upper.y0
        np.testing.assert_allclose([lower.x0, lower.y0, upper.y1], [whole.x0, whole.y0, whole.y1])

    def test_an_impact_is_a_step_at_its_time(self):
        run = slow_oscillator()
        t, lost = line(vi.plot.energy(run), "lost at impacts")
        assert not np.isnan(lost).any()
        steps = np.flatnonzero(np.diff(lost) > 1e-6)
        np.testing.assert_array_equal(t[steps], t[steps + 1])
        hits = run.impacts[: len(steps)]
        loss = 0.5 * (run.impacts["speed_before"] ** 2 - run.impacts["speed_after"] ** 2)
        np.testing.assert_allclose(np.diff(lost)[steps], loss[loss > 1e-6], rtol=1e-6)
        assert set(t[steps]) <= set(run.impacts["time"]), hits

    @pytest.mark.parametrize("t_eval", [np.linspace(0, 45, 46), np.linspace(0, 45, 451), "at an impact"])
    def test_at_given_times_no_line_joins_the_sides_of_an_impact(self, t_eval):
        if isinstance(t_eval, str):
            t_eval = np.sort([*np.linspace(0, 45, 46), slow_oscillator().impacts["time"][0]])
        run = slow_oscillator(t_eval=t_eval)
        ax = vi.plot.energy(run)
        for name in ("kinetic", "kinetic + potential", "lost at impacts"):
            t, _ = line(ax, name)
            for hit in run.impacts["time"]:
                drawn = np.flatnonzero((t[:-1] < hit) & (t[1:] >= hit))  # comparisons with nan are false
                assert len(drawn) == 0
        assert not np.isnan(line(ax, "work of the forcing")[1]).any()

    def test_rows_between_two_impacts_are_dots(self):
        ax = vi.plot.energy(slow_oscillator(t_eval=[0.0, 0.5, 1.0, 1.8, 5.0, 5.5]))
        (kinetic,) = [drawn for drawn in ax.lines if drawn.get_label() == "kinetic"]
        assert kinetic.get_marker() == "."
        dots = np.asarray(kinetic.get_xdata())[kinetic.get_markevery()]
        np.testing.assert_array_equal(dots, [1.0, 1.8])

    def test_label_is_put_before_the_names(self):
        ax = vi.plot.energy(slow_oscillator(), label="pushed")
        assert all(drawn.get_label().startswith("pushed, ") for drawn in ax.lines)

    def test_refuses_a_motion_that_was_not_kept_and_what_is_none(self):
        with pytest.raises(ValueError, match=r'keep.*"motion"'):
            vi.plot.energy(slow_oscillator(keep="impacts"))
        with pytest.raises(ValueError, match="data must be a trajectory"):
            vi.plot.energy(vi.modes(vi.LinearSystem(1, 0, 1)))
        assert plt.get_fignums() == []


class TestImpactSpeeds:
    def test_three_impacts_stand_on_stems(self):
        ax = vi.plot.impact_speeds(shuttle(3, restitution=0.9))
        t, speed = line(ax, "stop 0")
        np.testing.assert_allclose(speed, [2.0, 2.0 * 0.9**2])
        np.testing.assert_allclose(line(ax, "stop 1")[1], [1.8])
        stems = [drawn for drawn in ax.lines if drawn.get_label() == "_stems"]
        np.testing.assert_allclose(np.reshape(stems[0].get_xdata(), (-1, 3))[:, :2], np.column_stack([t, t]))
        np.testing.assert_allclose(np.reshape(stems[0].get_ydata(), (-1, 3))[:, :2], np.column_stack([0 * t, speed]))
        assert ax.get_ylim()[0] == 0.0

    def test_a_hundred_thousand_impacts_are_dots(self):
        ax = vi.plot.impact_speeds(shuttle(100_000))
        assert [drawn.get_label() for drawn in ax.lines] == ["stop 0", "stop 1"]
        assert sum(len(drawn.get_xdata()) for drawn in ax.lines) == 100_000
        assert all(drawn.get_markersize() == 2.0 for drawn in ax.lines)
        assert all(handle.get_markersize() >= 4.0 for handle in ax.get_legend().get_lines())

    def test_speeds_after(self):
        ax = vi.plot.impact_speeds(shuttle(3, restitution=0.9), side="after")
        np.testing.assert_allclose(line(ax, "stop 0")[1], [1.8, 1.8 * 0.9**2])
        with pytest.raises(ValueError, match="side must be 'before' or 'after', got 'both'"):
            vi.plot.impact_speeds(shuttle(3), side="both")

    def test_an_orbit_has_the_impacts_of_one_period(self):
        orbit = vi.periodic_orbits(vi.paper_scene(kind=3), [1], n_periods=2)[0]
        ax = vi.plot.impact_speeds(orbit)
        assert len(line(ax, "stop 1")[0]) == 1
        assert ax.get_xlim()[1] >= orbit.period

    def test_none_at_all(self):
        free = vi.simulate(vi.Scene(vi.LinearSystem([1.0], [0.0], [1.0])), [1.0], [0.0], (0, 5))
        assert [text.get_text() for text in vi.plot.impact_speeds(free).texts] == ["no impacts"]
        with pytest.raises(ValueError, match=r"must have kept its impacts, got none of \d+: .*keep='impacts'"):
            vi.plot.impact_speeds(slow_oscillator(keep="final"))


class TestMarksOfContact:
    @pytest.mark.parametrize("t_eval", [None, np.linspace(0.0, 45.0, 91)])
    @pytest.mark.parametrize("figure", ["time_history", "phase_portrait"])
    def test_stick_is_drawn_from_its_start_to_its_end(self, figure, t_eval):
        run = slow_oscillator(t_eval)
        ax = getattr(vi.plot, figure)(run)
        x, y = line(ax, "stick")
        held = run.segments[run.segments["kind"] == "stick"]
        parts = np.split(x, np.flatnonzero(np.isnan(x)))[:-1]
        assert len(parts) == len(held) == 3
        if figure == "phase_portrait":
            np.testing.assert_allclose(x[~np.isnan(x)], 0.2, atol=1e-9)
            np.testing.assert_allclose(y[~np.isnan(y)], 0.0, atol=1e-4)  # chatter ends with the speed of its first impact
        else:
            np.testing.assert_allclose([np.nanmin(part) for part in parts], held["start"], rtol=1e-12)
            np.testing.assert_allclose([np.nanmax(part) for part in parts], held["end"], rtol=1e-12)
            np.testing.assert_allclose(y[~np.isnan(y)], 0.2, atol=1e-9)

    @pytest.mark.parametrize("figure", ["time_history", "phase_portrait"])
    def test_those_of_an_orbit_come_again_in_every_period(self, figure):
        orbit = held_orbit()
        (first,) = orbit.segments[orbit.segments["kind"] == "stick"]
        turns = np.arange(-2, 4)
        start, end = -1.5 * orbit.period, 3.25 * orbit.period
        wanted = [(max(start, first["start"] + n * orbit.period), min(end, first["end"] + n * orbit.period)) for n in turns]
        wanted = [span for span in wanted if span[0] <= span[1]]
        x, y = line(getattr(vi.plot, figure)(orbit, t_span=(start, end)), "stick")
        parts = np.split(np.column_stack([x, y]), np.flatnonzero(np.isnan(x)))[:-1]
        assert len(parts) == len(wanted) == 6
        if figure == "time_history":
            np.testing.assert_allclose([(np.nanmin(part[:, 0]), np.nanmax(part[:, 0])) for part in parts], wanted, rtol=1e-11)
        np.testing.assert_allclose(y[~np.isnan(y)], 0.0, atol=1e-9)

    def test_it_can_be_left_out(self):
        run = slow_oscillator()
        ax = vi.plot.time_history(run, contact=False, impacts=False)
        assert {drawn.get_label() for drawn in ax.lines} == {"q[0]", "stop 0"}

    def test_a_coordinate_that_nothing_pushes_on_is_not_held(self):
        system = vi.LinearSystem([1.0, 1.0], [0.1, 0.1], [1.0, 2.0])
        run = vi.simulate(vi.Scene(system, vi.Harmonic([1.0, 0.5], 0.3), vi.Stop(0, 0.2, 0.6)), [0, 0], [0, 0], (0, 45))
        assert "stick" in run.segments["kind"]
        assert "stick" not in {drawn.get_label() for drawn in vi.plot.time_history(run, along=1).lines}

    def test_dots_at_impacts(self):
        run = slow_oscillator()
        large = run.impacts[run.impacts["speed_before"] > 1e-9]
        t, q = line(vi.plot.time_history(run), "impacts")
        np.testing.assert_allclose(q, 0.2, atol=1e-9)
        assert set(large["time"]) <= set(t)
        _, v = line(vi.plot.phase_portrait(run), "impacts")
        v = v.reshape(-1, 3)
        np.testing.assert_allclose(v[0, :2], [run.impacts["speed_before"][0], -run.impacts["speed_after"][0]], rtol=1e-9)

    def test_of_thousands_of_impacts_some_are_marked_and_the_legend_says_so(self):
        scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([5.0], 2.4), vi.Stop(0, 1.0, 0.8))
        run = vi.simulate(scene, [0.0], [0.0], (0, 9000))
        count = len(run.impacts)
        assert count > 2000
        ax = vi.plot.time_history(run)
        (marks,) = [drawn for drawn in ax.lines if drawn.get_label().startswith("impacts")]
        every = -(-count // 1000)
        assert marks.get_label() == f"impacts (one in {every})"
        assert len(marks.get_xdata()) <= 1000
        assert {"q[0]", "stop 0", marks.get_label()} == {text.get_text() for text in ax.get_legend().get_texts()}
        ax = vi.plot.phase_portrait(run)
        (marks,) = [drawn for drawn in ax.lines if drawn.get_label().startswith("impacts")]
        v = np.asarray(marks.get_ydata())
        v = v[np.isfinite(v)].reshape(-1, 2)
        np.testing.assert_allclose(v[:, 1], -0.8 * v[:, 0], rtol=1e-9)

    def test_the_time_of_impact_speeds_is_that_of_the_run(self):
        run = slow_oscillator()
        low, high = vi.plot.impact_speeds(run).get_xlim()
        assert low <= 0.0 < run.impacts["time"][0]
        assert high >= 45.0 > run.impacts["time"][-1]

    def test_styles_of_later_lines_do_not_count_the_marks(self):
        ax = vi.plot.time_history(slow_oscillator())
        vi.plot.time_history(slow_oscillator(), ax, label="again")
        (again,) = [drawn for drawn in ax.lines if drawn.get_label() == "again"]
        assert again.get_linestyle() == "--"
        assert len([drawn for drawn in ax.lines if drawn.get_label() == "stick"]) == 1

    def test_a_long_flight_is_smooth(self):
        scene = vi.Scene(vi.LinearSystem([1.0], [0.0], [1.0]))
        run = vi.simulate(scene, [1.0], [0.0], (0, 400))
        assert len(run.t) <= 200
        t, q = line(vi.plot.time_history(run), "q[0]")
        middle = 0.5 * (t[1:] + t[:-1])
        np.testing.assert_allclose(0.5 * (q[1:] + q[:-1]), np.cos(middle), atol=4e-3)  # 2 in a thousand of the range
