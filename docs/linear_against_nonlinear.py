"""Write docs/linear_against_nonlinear.md: the paper's orbits by the small-angle theory beside those of eq. (3).

Run by hand, ``python docs/linear_against_nonlinear.py``, with the package installed. The amplitude of the base motion grows from
1 % to the printed value, and the clearances with it, so that the small-angle orbit keeps its shape; the nonlinear orbit
is followed from there by ``continuation``, through folds and past boundaries.
"""

from pathlib import Path

import numpy as np

import vibroimpact as vi

PARTS = (0.01, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
PERIODS = {1: 3, 2: 2, 3: 2}
SETTLING = 150  # periods of a trajectory that starts near the orbit


def linear_orbit(kind):
    """Return the first admissible orbit of the small-angle scene with the printed amplitude."""
    scene = vi.paper_scene(kind)
    free = "clearance" if kind == 1 else None
    orbits = vi.periodic_orbits(scene, vi.KINDS[kind], PERIODS[kind], free=free)
    return next(orbit for orbit in orbits if orbit.is_admissible)


def scaled(orbit, scene, part):
    """Return a scene with the orbit's clearances and its forcing amplitude, both times `part`."""
    clearances = part * np.array([stop.clearance for stop in orbit.scene.stops])
    return scene.replace(clearance=clearances, amplitude=part * orbit.scene.forcing.amplitude)


def closure(orbit):
    """Return how far a simulation over one period is from closing, relative to the motion's size, as text."""
    if not orbit.is_admissible:
        return "-"
    start = 0.5 * float(orbit.period)
    q, v = orbit.position(start), orbit.velocity(start)
    span = (start, start + orbit.period)
    run = vi.simulate(orbit.scene, q, v, span, rtol=1e-12, atol=1e-16, keep="final")
    size = max(np.abs(orbit.q0).max(), np.abs(orbit.v0).max())
    return f"{max(np.abs(run.final[0] - q).max(), np.abs(run.final[1] - v).max()) / size:.0e}"


def apart(orbit):
    """Return the least time between two impacts of an orbit, in degrees of the forcing, as text."""
    times = np.sort(orbit.impacts["time"])
    if len(times) < 2:
        return "-"
    gaps = np.diff(times, append=times[0] + orbit.period)
    return f"{360 * gaps.min() / orbit.scene.period:.4f}"


def facts(orbit, part):
    """Return what one orbit shows: phase, time between impacts, speeds by stop, largest multiplier, admissible."""
    multipliers = orbit.floquet_multipliers
    largest = "none" if multipliers is None else f"{np.abs(multipliers).max():.5f}"
    impacts = np.sort(orbit.impacts, order="stop")
    speeds = ", ".join(f"{speed / part:.5f}" for speed in impacts["speed_before"])
    admissible = "yes" if orbit.is_admissible else f"no: passes by {orbit.violation.depth / part:.1e}"
    return f"{np.degrees(orbit.phase):.4f} | {apart(orbit)} | {speeds} | {largest} | {admissible}"


def first(linear, scene):
    """Return the nonlinear orbit at the smallest amplitude.

    Where the small-angle orbit hits two stops at one instant the nonlinear one hits them one after the other: no phase and no
    speed let both be hit together at given clearances. A settled trajectory says which comes first.
    """
    small = vi.find_orbit(scaled(linear, linear.scene, PARTS[0]), linear)
    nonlinear = scaled(linear, scene, PARTS[0])
    if len(linear.impacts) == 1:
        return vi.find_orbit(nonlinear, small)
    start = 0.5 * float(small.period)
    span = (start, start + SETTLING * small.period)
    nonlinear = nonlinear.replace(phase=small.phase)
    run = vi.simulate(nonlinear, small.position(start), small.velocity(start), span, rtol=1e-11, atol=1e-15)
    return vi.find_orbit(nonlinear, run, n_periods=linear.n_periods)


def follow(kind, linear):
    """Return the branch of the nonlinear orbit over the part of the amplitude."""
    scene = vi.paper_scene(kind, linear=False)
    between = (PARTS[0], PARTS[-1])
    return vi.continuation(
        first(linear, scene), lambda part: scaled(linear, scene, part), between, start=PARTS[0], direction="up", virtual="keep"
    )


def section(kind):
    """Return the section of one kind as lines."""
    linear = linear_orbit(kind)
    lines = [
        f"## Kind {kind}",
        "",
        "| amplitude | phase [deg] | between impacts [deg] | impact speed / part | largest multiplier | admissible | closure |",
        "|---|---|---|---|---|---|---|",
    ]
    lines.append(f"| small angles | {facts(linear, 1.0)} | {closure(linear)} |")
    branch = follow(kind, linear)
    for part in PARTS:
        for orbit in branch.at(part):
            lines.append(f"| {100 * part:.4g} % | {facts(orbit, part)} | {closure(orbit)} |")
    events = [f"{own.kind.replace('_', ' ')} at {100 * own.parameter:.5f} %" for own in branch.special]
    said = ", then ".join(events) if events else "nothing happens to it"
    lines += ["", f"Along the branch: {said}. It ends: {branch.ends[1][1]}."]
    return [*lines, ""]


def main():
    """Write the page."""
    lines = [
        "# Linear against nonlinear orbits",
        "",
        "The paper's three kinds, with the defaults of `paper_scene`, in the small-angle theory and by eq. (3). Amplitude",
        "of the base motion and clearances grow together from 1 % to the printed values, so that the small-angle orbit is the",
        "same at every amplitude but for its scale; speeds and depths are divided by the part of the amplitude. The nonlinear",
        "orbit is followed by `continuation`; where its branch turns, an amplitude has several rows. The first row of each table holds for small angles. Where two stops are hit in one",
        "period their speeds stand in the order of the stops, and the time between the impacts in degrees of the forcing; two",
        "stops that the small-angle orbit hits at one instant are hit one after the other by the nonlinear one, which has one",
        "phase for two clearances. Closure is that of a simulated period, relative to the motion. Under each table stands what happens",
        "along the branch. Written by `docs/linear_against_nonlinear.py`.",
        "",
    ]
    for kind in (1, 2, 3):
        lines += section(kind)
    Path(__file__).with_suffix(".md").write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
