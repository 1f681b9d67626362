"""Amplitude spectra of trajectories, by the fast Fourier transform of samples at equal steps under a Hann window.

Of samples x_k at N equal steps over a time T, their mean taken off, with the periodic window w_k = (1 - cos(2 pi k/N))/2, the
spectrum is ``2 |sum_k w_k x_k e^(-2 pi i j k/N)|/sum_k w_k`` at the angular frequencies ``2 pi j/T``. A motion ``A cos(w t)`` of
whole periods in T has a peak of height A, of any other number of them one that is lower by 15 % at the most; it is four steps of
the frequency wide. What is faster than half the rate of the samples is folded back: they are taken so densely that this is little
beside the rest.
"""

import operator
from typing import Any, Literal, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from vibroimpact.plot._axes import axes_or_new, label_axis, next_line_style, with_defaults
from vibroimpact.plot._data import FloatArray, Trajectory, is_trajectory
from vibroimpact.plot._direction import Direction, check_direction
from vibroimpact.plot._sampling import checked_span, window

PER_PERIOD = 256  # samples in a forcing period
Quantity: TypeAlias = Literal["position", "velocity", "acceleration"]
FEWEST = 1 << 14  # samples of a motion without forcing
MOST = 1 << 20
EQUAL_STEPS = 1e-6  # of a step: by how much rows at equal steps may be off


def spectrum(
    trajectory: Trajectory,
    along: ArrayLike = 0,
    ax: Axes | None = None,
    *,
    quantity: Quantity = "position",
    t_span: tuple[float, float] | None = None,
    samples: int | None = None,
    **line: Any,
) -> Axes:
    """Draw the amplitudes of the harmonics of a trajectory over their angular frequencies, on a logarithmic scale.

    Parameters
    ----------
    trajectory : Trajectory
        A trajectory that kept its motion, or has rows at equal steps (``t_eval``).
    along : int or array_like, shape (n_dof,), default 0
        What is drawn: a coordinate by its index, from 0 to n_dof - 1, or the motion along a direction n, ``n.q``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; default: a new figure.
    quantity : {"position", "velocity", "acceleration"}, default "position"
        Of what. The acceleration is that between impacts.
    t_span : (float, float), optional
        First and last time, to leave out a transient; default: all. Whole periods of the motion give the sharpest lines.
    samples : int, optional
        Samples in that time, from 4 to 2^20; default: 256 a forcing period, at most 2^20, or 2^14 without forcing. Of a
        trajectory that did not keep its motion they are its rows.
    **line
        Options of the line (`matplotlib.lines.Line2D`), such as ``color`` or ``label``.

    Returns
    -------
    matplotlib.axes.Axes
        `ax`, or the Axes of the new figure.

    Raises
    ------
    ValueError
        If an argument is outside the values above, or the trajectory has neither its motion nor rows at equal steps.

    Notes
    -----
    The mean is taken off and the samples are weighted by Hann's window, periodic. A harmonic has the height of its amplitude
    where the time has whole periods of it, and 15 % less at the worst [1]_. Velocities jump at impacts: their amplitudes fall off
    as 1/frequency, those of positions as its square.

    References
    ----------
    .. [1] F. J. Harris, "On the use of windows for harmonic analysis with the discrete Fourier transform", Proc. IEEE 66
       (1978) 51.

    Examples
    --------
    >>> import numpy as np
    >>> import vibroimpact as vi
    >>> scene = vi.Scene(vi.LinearSystem(1.0, 0.2, 1.0), vi.Harmonic(1.0, 0.5))
    >>> run = vi.simulate(scene, 0.0, 0.0, (0, 60 * scene.period))
    >>> ax = vi.plot.spectrum(run, t_span=(20 * scene.period, 60 * scene.period))
    >>> w, amplitude = ax.lines[0].get_data()
    >>> w[np.argmax(amplitude)].round(9), amplitude.max().round(6)         # 1/|1 - w^2 + 0.2 i w|
    (np.float64(0.5), np.float64(1.321637))
    """
    if not is_trajectory(trajectory):
        raise ValueError(f"trajectory must be one trajectory, got {type(trajectory).__name__}")
    direction = check_direction(along, trajectory.scene.n_dof)
    if quantity not in ("position", "velocity", "acceleration"):
        raise ValueError(f"quantity must be 'position', 'velocity' or 'acceleration', got {quantity!r}")
    t_span = checked_span(t_span)
    start, end = window(trajectory, t_span)
    if not start < end:
        raise ValueError(f"trajectory must last for some time, got {start:g} to {end:g}")
    count = _number_of_samples(samples, end - start, trajectory.scene.period)
    step, values = _samples(trajectory, direction, quantity, (start, end), count)
    frequencies, amplitudes = amplitude_spectrum(values, step)
    ax = axes_or_new(ax)
    label_axis(ax, "x", "angular frequency")
    name = getattr(direction, quantity)
    label_axis(ax, "y", f"amplitude of {quantity} {name}")
    ax.set_yscale("log")
    ax.plot(frequencies, amplitudes, **with_defaults(line, linestyle=next_line_style(ax), label=name))
    return ax


def amplitude_spectrum(values: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
    """Return angular frequencies above 0 and the amplitudes there, of samples at equal steps of time."""
    count = len(values)
    hann = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(count) / count)
    transformed = np.fft.rfft(hann * (values - np.mean(values)))
    amplitudes = 2.0 * np.abs(transformed) / np.sum(hann)
    frequencies = np.asarray(2.0 * np.pi * np.fft.rfftfreq(count, step), dtype=float)
    return frequencies[1:], amplitudes[1:]


def _number_of_samples(samples: int | None, duration: float, forcing_period: float | None) -> int:
    """Return how many samples to take, or say what is wrong with the number given."""
    if samples is None:
        wanted = FEWEST if forcing_period is None else np.ceil(PER_PERIOD * duration / forcing_period)
        return int(np.clip(wanted, 4, MOST))
    try:
        count = operator.index(samples)
    except TypeError:
        count = 0
    if not 4 <= count <= MOST:
        raise ValueError(f"samples must be an integer from 4 to {MOST}, got {samples!r}")
    return count


def _samples(
    trajectory: Trajectory, direction: Direction, quantity: str, span: tuple[float, float], count: int
) -> tuple[float, FloatArray]:
    """Return the step and the samples, that at the end left out: of a motion that was not kept its rows."""
    step = (span[1] - span[0]) / count
    times = span[0] + step * np.arange(count)
    try:
        states = getattr(trajectory, quantity)(times)
    except ValueError:
        if quantity == "acceleration":
            raise
        t = np.asarray(trajectory.t, dtype=float)
        inside = (t >= span[0]) & (t <= span[1])
        steps = np.diff(t[inside])
        if len(steps) < 3 or np.ptp(steps) > EQUAL_STEPS * np.mean(steps):
            raise ValueError(
                "trajectory must have kept its motion, or have rows at equal steps: simulate with keep='motion', or with "
                "t_eval=np.linspace(start, end, m)"
            ) from None
        rows = np.asarray(trajectory.q if quantity == "position" else trajectory.v)[inside]
        return float(np.mean(steps)), direction.of(rows)
    return step, direction.of(states)
