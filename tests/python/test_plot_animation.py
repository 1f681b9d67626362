"""Animations: the drawn pendulum has the lengths, the angles and the gaps of the model, in the frame of the ground."""

import base64
import io

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.animation import Animation
from PIL import Image

import vibroimpact as vi

LENGTHS = np.array([1.0, 0.5])
WALL, LEFT, JOINT, KNEE = range(4)  # the stops of `chain_scene`


def chain_scene():
    """Two links on a moving base between walls; a stop at the joint of the base, another between the links."""
    stops = [
        vi.Wall(1, 0.4, 0.7),
        vi.Wall(0, -0.35, 0.6, side="left"),
        vi.Stop(0, 0.3, 0.5, side="lower"),
        vi.Stop([-2.0, 2.0], 1.2, 0.5),
    ]
    return vi.Scene(vi.PendulumChain([1.0, 0.7], LENGTHS, 0.02), vi.BaseMotion(0.12, 4.0, 0.3), stops)


def chain_run(t_span=(0, 12)):
    return vi.simulate(chain_scene(), [0.1, 0.1], [0, 0], t_span)


def frames(animation):
    """Draw frame after frame."""
    for frame in animation.new_saved_frame_seq():
        animation._func(frame)
        yield frame


def lines(ax, label):
    return [drawn for drawn in ax.lines if drawn.get_label() == label]


def ends(drawn):
    return np.column_stack([drawn.get_xdata(), drawn.get_ydata()]).astype(float)


class TestPendulum:
    def test_the_drawing_has_the_geometry_of_the_model(self):
        run = chain_run()
        fig, ax = plt.subplots()
        animation = vi.plot.animate(run, ax)
        (chain,) = lines(ax, "pendulum")
        walls = [lines(ax, f"stop {k}")[0] for k in range(4)]
        assert ax.get_aspect() == 1.0
        gaps, drawn_gaps = [], []
        for frame in frames(animation):
            t = frame / 25.0
            q = run.position([t])[0]
            joints = ends(chain)
            np.testing.assert_allclose(joints[0], [0.12 * np.cos(4.0 * t + 0.3), 0.0], atol=1e-12)
            links = np.diff(joints, axis=0)
            np.testing.assert_allclose(np.hypot(*links.T), LENGTHS)
            np.testing.assert_allclose(np.arctan2(links[:, 0], -links[:, 1]), q, atol=1e-12)
            limits = [np.arctan2(*(np.diff(ends(walls[k]), axis=0)[0] * [1, -1])) for k in (JOINT, KNEE)]
            drawn_gaps.append(
                [
                    walls[WALL].get_xdata()[0] - joints[2, 0],
                    joints[1, 0] - walls[LEFT].get_xdata()[0],
                    q[0] - limits[0],
                    2.0 * (limits[1] - q[1]),
                ]
            )
            gaps.append(run.scene.gaps(q))
            np.testing.assert_allclose(ends(walls[JOINT])[0], joints[0])
            np.testing.assert_allclose(ends(walls[KNEE])[0], joints[1])
        assert len(gaps) == 301
        np.testing.assert_allclose(drawn_gaps, gaps, atol=1e-12)
        del fig

    def test_the_ground_is_an_inertial_frame(self):
        """Along the path of a lone bob only gravity accelerates it: x'' cos q + y'' sin q = -g sin q."""
        scene = vi.Scene(vi.PendulumChain([1.0], [0.8]), vi.BaseMotion(0.2, 5.0, 1.0))
        run = vi.simulate(scene, [0.4], [0.0], (0, 1), rtol=1e-11)
        ax = plt.subplots()[1]
        animation = vi.plot.animate(run, ax, fps=100, speed=0.1, max_frames=1001)
        bob = np.array([ends(lines(ax, "pendulum")[0])[-1] for _ in frames(animation)])
        step = 1e-3
        x, y = ((bob[2:] - 2.0 * bob[1:-1] + bob[:-2]) / step**2).T
        q = run.position(step * np.arange(1, len(bob) - 1))[:, 0]
        np.testing.assert_allclose(x * np.cos(q) + y * np.sin(q), -9.81 * np.sin(q), atol=1e-3)

    def test_a_double_pendulum_is_drawn_in_lengths_of_its_upper_link(self):
        scene = vi.paper_scene(kind=3, linear=False)
        ax = plt.subplots()[1]
        vi.plot.animate(vi.simulate(scene, [0, 0], [0, 0.2], (0, 4)), ax)
        links = np.diff(ends(lines(ax, "pendulum")[0]), axis=0)
        np.testing.assert_allclose(np.hypot(*links.T), [1.0, 1.0 / scene.system.length_ratio])

    def test_everything_stays_in_the_picture(self):
        ax = plt.subplots()[1]
        animation = vi.plot.animate(chain_run(), ax)
        (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
        for _ in frames(animation):
            for label in ("pendulum", "_base", "stop 0", "stop 1"):
                x, y = ends(lines(ax, label)[0]).T
                assert left < x.min() <= x.max() < right, label
                assert low < y.min() <= y.max() < high, label

    def test_a_wall_far_away_does_not_shrink_the_pendulum(self):
        scene = chain_scene().replace(stops=[vi.Wall(1, 1e6, 0.7)])
        ax = plt.subplots()[1]
        vi.plot.animate(vi.simulate(scene, [0.1, 0.1], [0, 0], (0, 2)), ax)
        assert np.ptp(ax.get_xlim()) < 5.0

    def test_the_bob_that_hits_flashes_and_fades(self):
        run = chain_run()
        hit = run.impacts[run.impacts["stop"] == WALL][0]["time"]
        before = run.impacts["time"][run.impacts["time"] < hit]
        assert not len(before) or hit - before[-1] > 0.05
        ax = plt.subplots()[1]
        animation = vi.plot.animate(run, ax)
        flash = lines(ax, "_flash")[WALL]
        alpha = []
        for _ in frames(animation):
            alpha.append(flash.get_alpha())
            np.testing.assert_array_equal(ends(flash)[0], ends(lines(ax, "pendulum")[0])[2])
        first = int(np.ceil(hit * 25.0))
        assert alpha[first - 1] == 0.0
        assert alpha[first] > 0.8
        assert alpha[first] > alpha[first + 1] > 0.0

    def test_the_trail_is_where_the_last_bob_was(self):
        run = chain_run((0, 4))
        ax = plt.subplots()[1]
        animation = vi.plot.animate(run, ax, trail=1.0)
        (trail,) = lines(ax, "_trail")
        bobs = []
        for frame in frames(animation):
            bobs.append(ends(lines(ax, "pendulum")[0])[-1])
            path = ends(trail)
            np.testing.assert_array_equal(path[-1], bobs[-1])
            np.testing.assert_array_equal(path[0], bobs[max(0, frame - 25)])
        vi.plot.animate(run, ax, trail=0)
        assert len(lines(ax, "_trail")[-1].get_xdata()) == 0

    def test_a_stop_given_by_functions_has_no_line(self):
        stop = vi.NonlinearStop(lambda q: 0.3 - q[0], lambda q: [-1.0, 0.0], 0.8)
        scene = vi.Scene(vi.PendulumChain([1.0, 1.0], LENGTHS), None, stop)
        ax = plt.subplots()[1]
        animation = vi.plot.animate(vi.simulate(scene, [0.2, 0], [0.5, 0], (0, 1)), ax)
        assert sum(1 for _ in frames(animation)) == 26
        assert not lines(ax, "stop 0")


class TestMasses:
    def test_positions_and_stops(self):
        stops = [
            vi.Stop(0, 0.5, 0.7),
            vi.Stop([0.0, -2.0], 0.8, 0.7),
            vi.Stop([-1.0, 1.0], 0.3, 0.8),
            vi.Stop([2.0, -2.0], 0.9, 1),
            vi.Stop(1, 0.7, 0.7, side="lower"),
        ]
        scene = vi.Scene(vi.LinearSystem([1, 1], [0.05, 0.05], [[2, -1], [-1, 2]]), vi.Harmonic([1, 0], 1.0), stops)
        run = vi.simulate(scene, [0, 0], [0, 0], (0, 5))
        ax = plt.subplots()[1]
        animation = vi.plot.animate(run, ax)
        assert [label.get_text() for label in ax.get_yticklabels()] == ["q[0]", "q[1]", "n·q of stop 2"]
        (masses,) = lines(ax, "masses")
        for frame in frames(animation):
            q = run.position([frame / 25.0])[0]
            np.testing.assert_allclose(masses.get_xdata(), [q[0], q[1], q[1] - q[0]], atol=1e-12)
        places = [lines(ax, f"stop {k}")[0] for k in range(5)]
        np.testing.assert_allclose([ends(place)[0, 0] for place in places], [0.5, -0.4, 0.3, -0.45, -0.7])
        np.testing.assert_allclose([ends(place)[:, 1].mean() for place in places], [0, -1, -2, -2, -1])

    def test_many_modes_show_where_they_hit(self):
        tip = np.ones(12)
        stops = [vi.Stop(tip, 0.5, 0.8), vi.Stop(tip, 0.5, 0.8, side="lower")]
        system = vi.LinearSystem(np.ones(12), 0.01 * np.ones(12), np.arange(1.0, 13.0) ** 2)
        run = vi.simulate(vi.Scene(system, vi.Harmonic(0.3 * tip, 0.95), stops), 0 * tip, 0 * tip, (0, 1))
        ax = plt.subplots()[1]
        vi.plot.animate(run, ax)
        assert [label.get_text() for label in ax.get_yticklabels()] == ["n·q of stop 0"]
        ax = plt.subplots()[1]
        vi.plot.animate(run, ax, coordinates=[3, 11])
        assert [label.get_text() for label in ax.get_yticklabels()] == ["q[3]", "q[11]", "n·q of stop 0"]
        with pytest.raises(ValueError, match=r"coordinates must be indices from 0 to 11, got -1"):
            vi.plot.animate(run, coordinates=[-1])

    def test_contact_glows_as_long_as_it_lasts(self):
        scene = vi.Scene(vi.LinearSystem([1.0], [0.1], [1.0]), vi.Harmonic([1.0], 0.3), vi.Stop(0, 0.2, 0.6))
        run = vi.simulate(scene, [0.0], [0.0], (0, 12))
        (held,) = run.segments[run.segments["kind"] == "stick"]
        ax = plt.subplots()[1]
        animation = vi.plot.animate(run, ax)
        alpha = np.array([lines(ax, "_flash")[0].get_alpha() for _ in frames(animation)])
        t = np.arange(len(alpha)) / 25.0
        np.testing.assert_array_equal(alpha[(t >= held["start"]) & (t <= held["end"])], 1.0)
        assert np.all(alpha[t > held["end"] + 0.3] == 0.0)


class TestFrames:
    @pytest.mark.parametrize(
        ("options", "count"), [({}, 51), ({"fps": 10}, 21), ({"speed": 0.5}, 101), ({"t_span": (0.5, 1.0)}, 13)]
    )
    def test_time_is_in_proportion(self, options, count):
        animation = vi.plot.animate(chain_run((0, 2)), **options)
        assert isinstance(animation, Animation)
        assert len(list(animation.new_saved_frame_seq())) == count

    def test_their_number_is_bounded(self):
        run = chain_run((0, 30))
        ax = plt.subplots()[1]
        assert len(list(frames(vi.plot.animate(run, ax, max_frames=100)))) == 100
        links = np.diff(ends(lines(ax, "pendulum")[0]), axis=0)
        np.testing.assert_allclose(np.arctan2(links[:, 0], -links[:, 1]), run.final[0])  # the last frame is the end
        with pytest.raises(ValueError, match=r"max_frames must not be below the 751 frames .*speed=1, got 500: .*t_span"):
            vi.plot.animate(run, speed=1.0)
        assert plt.get_fignums() == [1]

    def test_an_orbit_closes(self):
        guess = vi.periodic_orbits(vi.paper_scene(kind=3), pattern=[1], n_periods=2)[0]
        orbit = vi.find_orbit(vi.paper_scene(kind=3, linear=False), guess)
        ax = plt.subplots()[1]
        animation = vi.plot.animate(orbit, ax, fps=20 / orbit.period)
        drawn = [ends(lines(ax, "pendulum")[0]) for _ in frames(animation)]
        assert len(drawn) == 21
        np.testing.assert_allclose(drawn[0], drawn[-1], atol=1e-9)
        assert lines(ax, "_flash")[1].get_alpha() == 1.0

    def test_a_gif_has_the_frames_and_their_time(self, tmp_path):
        path = tmp_path / "motion.gif"
        vi.plot.animate(chain_run((0, 0.4)), fps=20).save(path, writer="pillow", dpi=40)
        with Image.open(path) as picture:
            assert picture.n_frames == 9
            assert picture.info["duration"] == 50

    def test_it_lives_with_its_figure_and_is_silent_when_dropped(self):
        vi.plot.animate(chain_run((0, 1)))
        plt.gcf().canvas.draw()

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ({"fps": 0}, "fps must be a finite number above 0, got 0"),
            ({"fps": "fast"}, "fps must be a finite number above 0, got 'fast'"),
            ({"speed": -1.0}, r"speed must be a finite number above 0, got -1\.0"),
            ({"trail": -0.1}, r"trail must be a finite number from 0, got -0\.1"),
            ({"max_frames": 1.5}, r"max_frames must be an integer from 2, got 1\.5"),
            ({"t_span": (1.0, 1.0)}, r"t_span must be a finite \(start, end\)"),
            ({"t_span": 3.0}, r"t_span must be a finite \(start, end\) with start < end, got 3\.0"),
            ({"t_span": (5.0, 6.0)}, "t_span must meet the trajectory's times, 0 to 1"),
            ({"coordinates": [0]}, r"coordinates must be None for a pendulum"),
            ({"ax": 3}, "ax must be the Axes of a figure or None"),
        ],
    )
    def test_refuses(self, options, message):
        with pytest.raises(ValueError, match=message):
            vi.plot.animate(chain_run((0, 1)), **options)
        assert plt.get_fignums() == []

    def test_refuses_what_is_no_motion_or_was_not_kept(self):
        with pytest.raises(ValueError, match="motion must be an orbit or a trajectory, got list"):
            vi.plot.animate([chain_run((0, 1))])
        for keep in ("impacts", "final"):
            run = vi.simulate(chain_scene(), [0.1, 0.1], [0, 0], (0, 1), keep=keep, t_eval=[0.0, 0.5, 1.0])
            with pytest.raises(ValueError, match=r'keep="motion"'):
                vi.plot.animate(run)
        assert plt.get_fignums() == []


class TestOnTheScreen:
    def test_the_face_of_a_mass_meets_its_stops(self):
        stops = [vi.Stop(0, 1.0, 0.8), vi.Stop(0, 0.5, 0.8, side="lower")]
        scene = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic([5.0], 2.4), stops)
        run = vi.simulate(scene, [0.0], [0.0], (0, 20))
        for impact in run.impacts[:6]:
            animation = vi.plot.animate(run, t_span=(impact["time"], 20.0), fps=20)
            (ax,) = animation._fig.axes
            animation._func(0)
            (mass,) = lines(ax, "masses")
            (wall,) = lines(ax, f"stop {impact['stop']}")
            middle = ax.transData.transform((float(mass.get_xdata()[0]), 0.0))[0]
            face = wall.get_transform().transform((float(wall.get_xdata()[0]), 0.0))[0]
            half = 0.5 * (mass.get_markersize() + mass.get_markeredgewidth() + wall.get_linewidth()) * animation._fig.dpi / 72.0
            assert face - middle == pytest.approx(half if impact["stop"] == 0 else -half, abs=0.5)

    def test_a_bob_meets_its_wall(self):
        scene = vi.Scene(vi.PendulumChain([1.0], [1.0]), None, vi.Wall(0, 0.3, 0.7))
        run = vi.simulate(scene, [0.0], [1.5], (0, 4))
        animation = vi.plot.animate(run, t_span=(run.impacts["time"][0], 4.0), fps=20)
        (ax,) = animation._fig.axes
        (bob,), (wall,) = lines(ax, "pendulum"), lines(ax, "stop 0")
        middle = ax.transData.transform((float(bob.get_xdata()[-1]), 0.0))[0]
        face = wall.get_transform().transform((float(wall.get_xdata()[0]), 0.0))[0]
        half = 0.5 * (bob.get_markersize() + bob.get_markeredgewidth() + wall.get_linewidth()) * animation._fig.dpi / 72.0
        assert face - middle == pytest.approx(half, abs=0.5)

    def test_the_canvas_fits_what_is_drawn(self):
        def size(n):
            scene = vi.Scene(vi.LinearSystem(np.eye(n), 0.1 * np.eye(n), np.eye(n)), vi.Harmonic(np.ones(n), 2.0))
            return vi.plot.animate(vi.simulate(scene, np.zeros(n), np.zeros(n), (0, 2)))._fig.get_size_inches()

        assert size(1)[1] < size(3)[1] < 4.0
        width, height = vi.plot.animate(chain_run((0, 1)))._fig.get_size_inches()
        assert height > width
        figure, ax = plt.subplots(figsize=(3.0, 2.0))
        vi.plot.animate(chain_run((0, 1)), ax)
        np.testing.assert_array_equal(figure.get_size_inches(), (3.0, 2.0))

    def test_a_notebook_shows_a_picture_that_moves(self):
        html = vi.plot.animate(chain_run((0, 1)), fps=10)._repr_html_()
        start = '<img alt="animation" src="data:image/gif;base64,'
        assert html.startswith(start)
        with Image.open(io.BytesIO(base64.b64decode(html[len(start) : -2]))) as picture:
            assert picture.n_frames == 11
