"""Gear rattle: a loose wheel between the flanks of a driving one that turns unevenly.

The driving wheel oscillates by `A cos(w t)` about its steady turning; the driven one is free but for a drag, and has a backlash
of 2 b between two flanks, which move as the driving wheel does: two stops with a motion of their own. Where the drag no longer
keeps the wheels together, the driven one is thrown off its flank once in each period. That motion has a closed form (docs of
the functions below), which says for which frequencies there is one, when it is stable, and how wide it flies: where that is
more than the backlash, it meets the other flank and there is no such motion.

You will see both motions at one frequency beside the closed form, the map over frequency and backlash, every cell of which
agrees with it, and two simulations from different speeds: one settles on the stable motion, the other goes on between both
flanks. The figure has them above the map.

Run: python examples/gear_rattle.py [--output DIRECTORY]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import vibroimpact as vi

AMPLITUDE = 1e-3  # A, of the driving wheel [rad]
DRAG = 20.0  # on the driven wheel, over its inertia [rad/s^2]
RESTITUTION = 0.7
FREQUENCY = 145.0  # w, of the motions shown [rad/s]: the drag is less than A w^2, and holds nothing in contact for long
BACKLASH = 4e-3  # b, of the motions shown [rad]
SPEEDS = (0.3, 0.1)  # at the start of two simulations, in the middle of the backlash [rad/s]
FIRST = [1]  # the pattern: the flank that the drag presses against


def gears(backlash: float, frequency: float = FREQUENCY) -> vi.Scene:
    """The driven wheel between its flanks; a motion is added to the room on a stop's side."""
    driven = vi.LinearSystem([1.0], [0.0], [0.0], load=[-DRAG])
    flanks = [
        vi.Stop(0, backlash, RESTITUTION, motion=vi.Harmonic([AMPLITUDE], frequency)),
        vi.Stop(0, backlash, RESTITUTION, side="lower", motion=vi.Harmonic([-AMPLITUDE], frequency)),
    ]
    return vi.Scene(driven, None, flanks)


def launch_phases(frequency: float) -> list[float]:
    """Phases of the driving wheel at impact [rad]; none below the frequency of the fold.

    Over a period T the drag takes `g T` from the speed and nothing may be left of the way: the wheel leaves at `g T / 2`, at
    `e g T / (1 + e)` relative to the flank, whose speed `-A w sin(phase)` is the difference.
    """
    period = 2.0 * np.pi / frequency
    sine = -0.5 * DRAG * period * (1.0 - RESTITUTION) / (1.0 + RESTITUTION) / (AMPLITUDE * frequency)
    return [np.arcsin(sine) % (2.0 * np.pi), np.pi - np.arcsin(sine)] if sine >= -1.0 else []


def is_stable(frequency: float, phase: float) -> bool:
    """Whether `0 < c < 2 (1 + e^2)`, `c = (1 + e)^2 A w^2 cos(phase) / g`.

    The return map has determinant e^2 and trace `1 + e^2 - c`.
    """
    part = (1.0 + RESTITUTION) ** 2 * AMPLITUDE * frequency**2 * np.cos(phase) / DRAG
    return bool(0.0 < part < 2.0 * (1.0 + RESTITUTION**2))


def excursion(frequency: float, phase: float) -> np.ndarray:
    """How far the wheel is from its flank during the flight [rad]."""
    period = 2.0 * np.pi / frequency
    t = np.linspace(0.0, period, 4001)[1:-1]
    flank = AMPLITUDE * (np.cos(frequency * t + phase) - np.cos(phase))
    return 0.5 * DRAG * t * (period - t) - flank


def check_orbits() -> None:
    """Print both motions beside the closed form."""
    orbits = vi.periodic_orbits(gears(BACKLASH), FIRST)
    speed = DRAG * 2.0 * np.pi / FREQUENCY / (1.0 + RESTITUTION)
    print("impact speed  closed form   phase [rad]  closed form   stable")
    for orbit, phase in zip(orbits, launch_phases(FREQUENCY), strict=True):
        found = orbit.impacts["speed_before"][0]
        print(f"{found:<12.9f}  {speed:.9f}   {orbit.phase:.9f}  {phase:.9f}   {orbit.is_stable}")
        assert abs(found - speed) < 1e-10
        assert abs(orbit.phase - phase) < 1e-9
        assert orbit.is_admissible is True
        assert orbit.is_stable is is_stable(FREQUENCY, phase)


def check_map() -> vi.ExistenceMap:
    """Compute the map over frequency and backlash and compare every cell with the closed form."""
    frequencies, backlashes = np.linspace(90.0, 190.0, 101), np.linspace(1e-3, 5e-3, 81)
    found = vi.existence_map(gears(BACKLASH), FIRST, ("frequency", frequencies), ("clearance", backlashes))
    for i, frequency in enumerate(frequencies):
        phases = launch_phases(frequency)
        flights = [excursion(frequency, phase) for phase in phases]
        fits = np.array([(y.min() > -1e-12) & (y.max() < 2.0 * backlashes) for y in flights]).reshape(-1, backlashes.size)
        stable = np.array([is_stable(frequency, phase) for phase in phases], dtype=bool)
        np.testing.assert_array_equal(found.n_orbits[:, i], len(phases))
        np.testing.assert_array_equal(found.is_admissible[:, i], fits.any(axis=0))
        np.testing.assert_array_equal(found.is_stable[:, i], fits[stable].any(axis=0))
    print(f"map: {found.n_orbits.size} cells, each as in the closed form")
    return found


def check_simulations() -> list[vi.Trajectory]:
    """Simulate from both speeds: from the first the wheel settles on the closed form, from the other it meets both flanks."""
    span = (0.0, 400.0 * np.pi / FREQUENCY)
    runs = [vi.simulate(gears(BACKLASH), [0.0], [speed], span) for speed in SPEEDS]
    for run, speed in zip(runs, SPEEDS, strict=True):
        counts = np.bincount(run.impacts["stop"], minlength=2)
        print(f"from {speed} rad/s: {counts[1]} impacts on the first flank, {counts[0]} on the other")
        # The work of the flanks is in that of the forcing.
        assert np.abs(run.energy.balance).max() < 1e-9 * np.abs(run.energy.forcing_work).max()
    assert abs(runs[0].impacts["phase"][-1] - launch_phases(FREQUENCY)[0]) < 1e-9
    assert np.count_nonzero(runs[1].impacts["stop"] == 0) > 100
    return runs


def figure(runs: list[vi.Trajectory], found: vi.ExistenceMap) -> plt.Figure:
    """The last periods of both simulations between the flanks, above the map."""
    fig, (above, below) = plt.subplots(2, 1, figsize=(8, 8), layout="constrained")
    end = runs[0].t_end
    t = np.linspace(end - 12.0 * np.pi / FREQUENCY, end, 1500)
    driving = 1e3 * AMPLITUDE * np.cos(FREQUENCY * t)
    for side in (-1.0, 1.0):
        flank = driving + 1e3 * side * BACKLASH
        above.fill_between(1e3 * (t - t[0]), flank, 6.0 * side, color="0.75", label="driving wheel" if side < 0.0 else None)
    for run, speed, color in zip(runs, SPEEDS, ("#1d3a66", "#b8503f"), strict=True):
        above.plot(1e3 * (t - t[0]), 1e3 * run.along(0, t), color=color, label=f"driven wheel, from {speed} rad/s")
    above.set(xlabel="time [ms]", ylabel="angle [mrad]", ylim=(-6.0, 6.0), xlim=(0.0, 1e3 * (t[-1] - t[0])))
    above.set_title(f"Between the flanks, w = {FREQUENCY:g} rad/s, b = {1e3 * BACKLASH:g} mrad")
    above.legend(loc="upper right")
    vi.plot.existence_map(found, below)
    below.plot(FREQUENCY, BACKLASH, "o", markerfacecolor="white", markeredgecolor="black")
    below.set(xlabel="frequency [rad/s]", ylabel="backlash b [rad]", title="One impact in each period, on one flank")
    return fig


def main() -> None:
    """Compare orbits, map and simulations with the closed form; write the figure."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("figures"), help="directory of the figure")
    output: Path = parser.parse_args().output
    output.mkdir(parents=True, exist_ok=True)
    check_orbits()
    found = check_map()
    fig = figure(check_simulations(), found)
    fig.savefig(output / "gear_rattle.png", dpi=120)
    plt.close(fig)
    print(f"figure in {output}/")


if __name__ == "__main__":
    main()
