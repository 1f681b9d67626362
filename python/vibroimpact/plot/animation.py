"""Motions as moving pictures: pendulums with their links, walls and base, other systems as masses on tracks."""

import base64
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.animation import FuncAnimation
from matplotlib.axes import Axes

from vibroimpact.plot._axes import axes_or_new
from vibroimpact.plot._data import Orbit, Trajectory
from vibroimpact.plot._film import make_film
from vibroimpact.plot._links import Links, link_lengths
from vibroimpact.plot._masses import Masses
from vibroimpact.plot._sampling import not_a_motion


class _Animation(FuncAnimation):
    """An animation that lives as long as its figure, so that nobody need keep it."""

    fps: Any = 25.0  # of what it is saved as; a float, which its writers take

    def _repr_html_(self) -> str:
        """Return it as a moving picture of its own, for notebooks."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "motion.gif"
            self.save(path, writer="pillow", fps=self.fps)
            data = base64.b64encode(path.read_bytes()).decode("ascii")
        return f'<img alt="animation" src="data:image/gif;base64,{data}">'

    def __del__(self) -> None:
        """Say nothing of an animation that was not drawn: it may have been made for its frames."""


def animate(
    motion: Orbit | Trajectory,
    ax: Axes | None = None,
    *,
    t_span: tuple[float, float] | None = None,
    fps: float = 25.0,
    speed: float | None = None,
    max_frames: int = 500,
    trail: float = 1.5,
    coordinates: Sequence[int] | None = None,
    **line: Any,
) -> FuncAnimation:
    """Animate a motion, in proportion to its time.

    A pendulum is drawn as it hangs, in one scale along both axes: its base moves, and the walls and stops with it; a stop
    on angles is a line from the joint, at the angle at which its last link meets it. The path of the last bob is left behind
    for a while, and a bob that hits a stop flashes; it glows for as long as it stays in contact. Stops are drawn where the
    face of what hits them is in contact, half a mark beside the place at which its middle is then. Other systems are masses
    on tracks, one for each coordinate and one for each stop whose normal mixes them.

    Parameters
    ----------
    motion : Trajectory or Orbit
        A trajectory with ``keep="motion"``, or an orbit.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    t_span : (float, float), optional
        First and last time shown; default: the whole of a trajectory, one period of an orbit.
    fps : float, default 25
        Frames in a second of playback, above 0. A GIF counts in hundredths of a second: 20, 25 and 50 are kept exactly.
    speed : float, optional
        Units of the motion's time that pass in a second of playback, above 0; default: 1, or as many as `max_frames` need.
    max_frames : int, default 500
        The most frames there may be, from 2.
    trail : float, default 1.5
        Time for which the path of the last bob (of each mass) is seen, in seconds of playback; 0: not at all.
    coordinates : sequence of int, optional
        Coordinates of a system other than a pendulum that are drawn; default: all of at most eight, else those with a stop.
    **line
        Options of the links and bobs, or of the masses (`matplotlib.lines.Line2D`).

    Returns
    -------
    matplotlib.animation.FuncAnimation
        It lives as long as its figure; ``save("motion.gif", writer="pillow")`` writes a file. A notebook shows it as
        one, or with buttons by ``to_jshtml()``.

    Raises
    ------
    ValueError
        If `motion` is not one motion or was not kept, `speed` needs more than `max_frames` frames, or an argument is
        outside the values above.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> chain = vi.PendulumChain([1.0, 1.0], [1.0, 0.5], damping=0.05)
    >>> scene = vi.Scene(chain, vi.BaseMotion(0.1, 4.0), vi.Wall(1, 0.2, 0.7))
    >>> run = vi.simulate(scene, [0.1, -0.2], [0, 0], (0, 2))
    >>> animation = vi.plot.animate(run, fps=20)
    >>> len(list(animation.new_saved_frame_seq()))
    41
    """
    if not hasattr(motion, "scene"):
        raise not_a_motion(motion)
    film = make_film(motion, t_span, fps=fps, speed=speed, max_frames=max_frames, trail=trail)
    scene = motion.scene
    lengths = link_lengths(scene.system)
    if lengths is not None and coordinates is not None:
        raise ValueError(f"coordinates must be None for a pendulum, whose links are all drawn, got {coordinates!r}")
    is_new = ax is None
    ax = axes_or_new(ax)
    pendulum = Links(ax, scene, lengths, film, line) if lengths is not None else None
    picture = pendulum or Masses(ax, scene, film, coordinates, line)

    def show(frame: int) -> list[Any]:
        picture.show(frame)
        ax.set_title(f"t = {film.t[frame]:.{film.decimals}f}", loc="right", fontsize="medium", family="monospace")
        return []

    show(0)
    figure = ax.figure.figure  # of a part of a figure the whole
    if is_new:
        figure.set_size_inches(*picture.size)
        figure.canvas.draw()
        figure.set_layout_engine("none")  # every frame has the layout of the first
    animation = _Animation(figure, show, frames=len(film.t), interval=1000.0 / fps, blit=False)
    animation.fps = fps
    figure.canvas.mpl_connect("close_event", lambda _event: animation.pause)  # what holds the animation, with its figure
    return animation
