"""Motions over time and in the phase plane, of orbits and of trajectories.

At an impact the velocity has two values: the line ends at the one before and begins again at the one after. Impacts are
dots, chatter and lasting contact lie under the line as a broad one. A stop whose normal is the direction drawn is a line with
ticks on its solid side.
"""

from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import ArrayLike

from vibroimpact.plot._axes import (
    JUMP_LABEL,
    SECTION_LABEL,
    axes_or_new,
    draw_legend,
    draw_legend_above,
    label_axis,
    label_once,
    next_line_style,
    next_section_marker,
    with_defaults,
)
from vibroimpact.plot._contact import MANY_IMPACTS, draw_contact, draw_impacts
from vibroimpact.plot._data import FloatArray, Orbit, Trajectory, is_orbit
from vibroimpact.plot._direction import Direction, check_direction
from vibroimpact.plot._sampling import POINTS, Curve, not_a_motion, poincare_states, sample
from vibroimpact.plot._walls import draw_walls

JUMP_WIDTH = 0.9  # [points]
JUMP_DASHES = (0.0, (4.0, 2.5))  # offset, (dash, space) [line widths]
MANY_POINTS = 100  # Poincare points; more are drawn without a rim to speak of
SECTION_SIZES = ((MANY_POINTS, 6.0), (1000, 3.0))  # of their marks, to so many of them [points]
LEAST_SIZE = 1.5
THIN = 0.3  # of the line of a motion with many impacts in the phase plane [points]


def time_history(
    motion: Orbit | Trajectory,
    ax: Axes | None = None,
    *,
    along: ArrayLike = 0,
    quantity: Literal["position", "velocity"] = "position",
    periods: float | None = None,
    t_span: tuple[float, float] | None = None,
    walls: bool = True,
    impacts: bool = True,
    contact: bool = True,
    jumps: bool = False,
    points: int = POINTS,
    **line: Any,
) -> Axes:
    """Draw one coordinate of a motion, or the motion along a direction, or its velocity, over time.

    Parameters
    ----------
    motion : Orbit or Trajectory
        What to draw: an orbit sampled flight by flight, a trajectory by the rows it has; where its motion was kept, both
        sides of each impact and the points that a smooth line needs are added.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    along : int or array_like, shape (n_dof,), default 0
        What is drawn: a coordinate by its index, from 0 to n_dof - 1, or the motion along a direction n, ``n.q``, such as that
        of the tip of a beam given by its modes.
    quantity : {"position", "velocity"}, default "position"
        What is drawn. The velocity line is broken at each impact.
    periods : float, optional
        Length of the drawing in periods of the orbit, from t = 0, above 0; default 1. Of orbits only.
    t_span : (float, float), optional
        First and last time drawn; default: `periods` of an orbit, the whole of a trajectory.
    walls : bool, default True
        Draw the stops whose normal `along` is, in the position; one that moves where it is at each time.
    impacts : bool, default True
        Mark the impacts that change the velocity drawn by dots, both sides where the velocity is drawn.
    contact : bool, default True
        Draw chatter and stick against a stop that acts along `along` as broad lines; of orbits, and of
        trajectories that kept their motion.
    jumps : bool, default False
        Draw the jumps of the velocity as thin dashed lines.
    points : int, default 400
        Samples of an orbit in a forcing period, at least 2. A trajectory has as many as it needs.
    **line
        Options of the line (`matplotlib.lines.Line2D`), such as ``color`` or ``label``.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure, with a legend; of more than 1000 impacts some are marked, as that says.

    Raises
    ------
    ValueError
        If an argument is outside the values above, or the trajectory has no rows.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.paper_scene(kind=3)
    >>> orbits = vi.periodic_orbits(scene, pattern=[1], n_periods=2)
    >>> ax = vi.plot.time_history(orbits[0], along=1, quantity="velocity", periods=2)
    >>> ax.get_ylabel()
    "velocity q'[1]"
    """
    direction = _check_motion(motion, along)
    if quantity not in ("position", "velocity"):
        raise ValueError(f"quantity must be 'position' or 'velocity', got {quantity!r}")
    if periods is not None:
        t_span = _span_of_periods(motion, periods, t_span)
    curve = sample(motion, direction, t_span, points)
    is_new = ax is None
    ax = axes_or_new(ax)
    label_axis(ax, "x", "time t")
    if quantity == "position":
        label_axis(ax, "y", direction.position_label)
        options = with_defaults(line, linestyle=next_line_style(ax), label=direction.position)
        drawn = ax.plot(curve.t, curve.q, **options)[0]
        if walls:
            draw_walls(ax, motion, direction, curve.t, along="y")
        if impacts:
            draw_impacts(ax, drawn, curve.t[curve.impacts], curve.q[curve.impacts])
    else:
        label_axis(ax, "y", direction.velocity_label)
        options = with_defaults(line, linestyle=next_line_style(ax), label=direction.velocity)
        drawn = ax.plot(curve.broken(curve.t), curve.broken(curve.v), **options)[0]
        if jumps:
            _draw_jumps(ax, drawn, curve, curve.t)
        if impacts:
            draw_impacts(ax, drawn, curve.jumps(curve.t), curve.jumps(curve.v))
    if contact:
        draw_contact(ax, motion, direction, curve, curve.t, curve.q if quantity == "position" else curve.v)
    if is_new:
        draw_legend_above(ax)
    return ax


def phase_portrait(
    motion: Orbit | Trajectory,
    ax: Axes | None = None,
    *,
    along: ArrayLike = 0,
    t_span: tuple[float, float] | None = None,
    walls: bool = True,
    section: bool = True,
    impacts: bool = True,
    contact: bool = True,
    jumps: bool = True,
    points: int = POINTS,
    **line: Any,
) -> Axes:
    """Draw the velocity of one coordinate, or along a direction, over the position.

    Parameters
    ----------
    motion : Orbit or Trajectory
        What to draw: one period of an orbit, or a trajectory by the rows it has; where its motion was kept, both sides of
        each impact and the points that a smooth line needs are added.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    along : int or array_like, shape (n_dof,), default 0
        What is drawn: a coordinate by its index, from 0 to n_dof - 1, or the motion along a direction n, ``n.q``, such as that
        of the tip of a beam given by its modes.
    t_span : (float, float), optional
        First and last time drawn; default: one period of an orbit, the whole of a trajectory.
    walls : bool, default True
        Draw the stops whose normal `along` is as vertical lines; one that moves as the strip in which it does.
    section : bool, default True
        Mark the Poincare points of a forced motion, at whole forcing periods, right after an impact that falls there.
        A trajectory without its motion (``keep="impacts"`` or ``"final"``) has those that are among its rows.
    impacts : bool, default True
        Mark the impacts that change the velocity drawn by dots, both sides where the velocity is drawn.
    contact : bool, default True
        Draw chatter and stick against a stop that acts along `along` as broad lines; of orbits, and of
        trajectories that kept their motion.
    jumps : bool, default True
        Draw the jump at each impact as a thin dashed line.
    points : int, default 400
        Samples of an orbit in a forcing period, at least 2. A trajectory has as many as it needs.
    **line
        Options of the line (`matplotlib.lines.Line2D`), such as ``color`` or ``label``.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure.

    Raises
    ------
    ValueError
        If an argument is outside the values above, or the trajectory has no rows.

    Examples
    --------
    >>> import vibroimpact as vi
    >>> scene = vi.paper_scene(kind=3)
    >>> orbits = vi.periodic_orbits(scene, pattern=[1], n_periods=2)
    >>> ax = vi.plot.phase_portrait(orbits[0], along=1)
    >>> ax.get_xlabel()
    'position q[1]'
    """
    direction = _check_motion(motion, along)
    curve = sample(motion, direction, t_span, points)
    is_new = ax is None
    ax = axes_or_new(ax)
    label_axis(ax, "x", direction.position_label)
    label_axis(ax, "y", direction.velocity_label)
    name = "orbit" if is_orbit(motion) else "trajectory"
    options = with_defaults(line, linestyle=next_line_style(ax), label=name)
    if len(curve.impacts) > MANY_IMPACTS:
        options = with_defaults(options, linewidth=THIN)
    drawn = ax.plot(curve.broken(curve.q), curve.broken(curve.v), **options)[0]
    if jumps:
        _draw_jumps(ax, drawn, curve, curve.q)
    if impacts:
        draw_impacts(ax, drawn, curve.jumps(curve.q), curve.jumps(curve.v))
    if contact:
        draw_contact(ax, motion, direction, curve, curve.q, curve.v)
    if walls:
        draw_walls(ax, motion, direction, curve.t, along="x")
    if section and motion.scene.period is not None:
        q, v = poincare_states(motion, direction, t_span)
        size = next((size for most, size in SECTION_SIZES if len(q) <= most), LEAST_SIZE)
        ax.plot(
            q,
            v,
            linestyle="none",
            marker=next_section_marker(ax),
            markersize=size,
            markerfacecolor="black",
            markeredgecolor="white",
            markeredgewidth=0.8 if len(q) <= MANY_POINTS else 0.0,
            label=_section_label(ax, line.get("label")),
            zorder=3.0,
        )
    if is_new:
        draw_legend(ax, beside=True)
    return ax


def _check_motion(motion: Orbit | Trajectory, along: ArrayLike) -> Direction:
    """Return what is drawn along, a direction of the motion's."""
    if not hasattr(motion, "scene"):
        raise not_a_motion(motion)
    return check_direction(along, motion.scene.n_dof)


def _span_of_periods(motion: Orbit | Trajectory, periods: float, t_span: tuple[float, float] | None) -> tuple[float, float]:
    """Return the times of the first `periods` of an orbit."""
    if t_span is not None or not is_orbit(motion):
        raise ValueError(f"periods must be None where t_span is given or the motion has no period, got {periods!r}")
    if not 0.0 < periods < float("inf"):
        raise ValueError(f"periods must be finite and above 0, got {periods!r}")
    return 0.0, float(periods * motion.period)


def _section_label(ax: Axes, label: object) -> str:
    """Name the Poincare points after the motion's own label, and each name once in a legend."""
    return label_once(ax, f"{SECTION_LABEL}, {label}" if label else SECTION_LABEL)


def _draw_jumps(ax: Axes, drawn: Line2D, curve: Curve, along: FloatArray) -> None:
    """Draw the velocity jumps of a curve, thin and dashed in its colour."""
    ax.plot(
        curve.jumps(along),
        curve.jumps(curve.v),
        color=drawn.get_color(),
        linestyle=JUMP_DASHES,
        linewidth=JUMP_WIDTH,
        label=JUMP_LABEL,
        zorder=drawn.get_zorder() - 0.1,
    )
