"""Print what diagrams, exponents and basins cost, beside the runs they are made of, SciPy and, where it is installed, heyoka.

Run by hand, ``python benches/families.py [part of the whole]``, with a release build of the package installed and nothing else
running; a part such as 0.1 takes as much less. Everything on one core but where two are named; times are medians of rounds in
which the contestants take turns. SciPy's RK45 (rtol 1e-6) has too long a way for a whole diagram or plane: it goes a part of it,
and its time is multiplied.
"""

import resource
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np
from scipy.integrate import solve_ivp

import vibroimpact as vi

ROUNDS = 3
CHAOTIC = vi.Scene(vi.LinearSystem(1.0, 0.1, 1.0), vi.Harmonic([5.0], 2.4), vi.Stop(0, 1.0, 0.8))
ELASTIC = vi.Scene(vi.LinearSystem(1.0, 0.0, 1.0), vi.Harmonic([1.0], 5.2), vi.Stop(0, 0.63, 0.8, side="lower"))
PENDULUM = vi.paper_scene(kind=3, linear=False)


def seconds(action):
    """Return the time of a call, and what it gives."""
    start = time.perf_counter()
    result = action()
    return time.perf_counter() - start, result


def turns(**actions):
    """Return the median seconds of each action, which take turns, and what they gave last."""
    times, results = {name: [] for name in actions}, {}
    for _ in range(ROUNDS):
        for name, action in actions.items():
            own, results[name] = seconds(action)
            times[name].append(own)
    return {name: median(own) for name, own in times.items()}, results


def by_scipy(scene, q, v, span):
    """Follow a mass before one stop by SciPy; return its impacts."""
    stop, force = scene.stops[0], scene.forcing
    damping = float(np.ravel(scene.system.damping)[0])
    amplitude, w = float(np.real(np.ravel(force.amplitude)[0])), force.frequency
    sign = 1.0 if stop.side == "upper" else -1.0

    def rhs(t, y):
        return [y[1], amplitude * np.cos(w * t) - damping * y[1] - y[0]]

    def gap(t, y):
        return stop.clearance - sign * y[0]

    gap.terminal, gap.direction = True, -1.0
    t, y, impacts = span[0], [q, v], 0
    while t < span[1]:
        run = solve_ivp(rhs, (t, span[1]), y, events=gap, rtol=1e-6)
        t, y = run.t[-1], run.y[:, -1]
        if run.status == 1:
            y, impacts = [sign * (stop.clearance - 1e-12), -stop.restitution * y[1]], impacts + 1
    return impacts


def diagram(part):
    """Measure 800 values of 250 periods."""
    values = np.linspace(4.5, 8.5, max(int(800 * part), 8))

    def whole():
        axis = ("forcing_scale", values / 5.0)
        return vi.bifurcation_diagram(CHAOTIC, axis, workers=1)

    def loop():
        q, v = np.zeros(1), np.zeros(1)
        for value in values:
            scene = CHAOTIC.replace(forcing_scale=value / 5.0)
            run = vi.simulate(scene, q, v, (0.0, 250 * scene.period), keep="final")
            q, v = run.final

    times, _ = turns(whole=whole, loop=loop)
    slow, _ = seconds(lambda: by_scipy(CHAOTIC, 0.0, 0.0, (0.0, 250 * CHAOTIC.period)))
    print(
        f"diagram of {len(values)} values of 250 periods: {times['whole']:.3f} s; a loop over simulate {times['loop']:.3f} s; "
        f"SciPy {slow * len(values):.0f} s"
    )


def exponents(part):
    """Measure a million impacts with and without exponents."""
    end = 3.79e6 * part
    times, results = turns(
        exponents=lambda: vi.lyapunov_exponents(CHAOTIC, 0.0, 0.0, (0.0, end)),
        without=lambda: vi.simulate(CHAOTIC, 0.0, 0.0, (0.0, end), keep="final"),
    )
    ratio = times["exponents"] / times["without"]
    print(f"{results['exponents'].n_impacts} impacts with exponents: {times['exponents']:.2f} s, {ratio:.2f} of the run without")


def cells(part):
    """Measure a million cells, states right after an impact; two cores; a store."""
    side = round(1000 * np.sqrt(part))
    attractors = vi.find_attractors(ELASTIC, [(-0.63, 2.0), (-3.0, 3.0)], seeds=200)
    call = {"impact": {"stop": 0, "phase": (0.0, 2 * np.pi, side), "speed": (0.0, 3.0, side)}, "attractors": attractors}
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    with tempfile.TemporaryDirectory() as folder:
        paths = (Path(folder) / f"plane_{k}.zarr" for k in range(ROUNDS))
        times, results = turns(
            one=lambda: vi.basins(ELASTIC, **call, workers=1),
            two=lambda: vi.basins(ELASTIC, **call, workers=2),
            store=lambda: vi.basins(ELASTIC, **call, workers=1, store=next(paths)),
        )
    more = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024 - before
    plane = results["one"]
    count = plane.labels.size
    few = 20
    rng = np.random.default_rng(0)
    slow = 0.0
    for j, i in zip(rng.integers(side, size=few), rng.integers(side, size=few), strict=True):
        start, speed = plane.x[i] / 5.2, plane.y[j]
        span = (start, start + plane.iterations[j, i] * ELASTIC.period)
        slow += seconds(lambda: by_scipy(ELASTIC, -0.63, speed, span))[0]  # noqa: B023 (called at once)
    print(
        f"{count} cells, {plane.iterations.mean():.1f} periods until each is decided: {times['one']:.2f} s, "
        f"{1e6 * times['one'] / count:.1f} us a cell; two cores {times['one'] / times['two']:.2f} times as fast; a store "
        f"{100 * (times['store'] / times['one'] - 1):+.1f} %; {more:.0f} MB more; SciPy {slow / few * count:.0f} s"
    )
    print(f"  {plane}")


def pendulum(part):
    """Measure cells of the double pendulum with large motions and stops, and the same time of motion in heyoka's batches."""
    side = max(round(100 * np.sqrt(part)), 4)
    attractors = vi.find_attractors(PENDULUM, [(-0.2, 0.1), (-0.2, 0.1), (-0.3, 0.3), (-0.3, 0.3)], seeds=24)
    call = {"q": {0: (-0.1, 0.05, side), 1: (-0.2, 0.05, side)}, "v": {0: 0.0, 1: 0.0}, "attractors": attractors}
    took, plane = seconds(lambda: vi.basins(PENDULUM, **call, max_periods=500, workers=1))
    count, periods = plane.labels.size, float(plane.iterations.mean())
    line = f"{count} cells of a double pendulum, {periods:.1f} periods each: {took:.2f} s, {1e3 * took / count:.2f} ms a cell"
    try:
        from against_heyoka import batch_of_pendulums
    except ImportError:
        print(f"{line}; heyoka is not installed")
        return
    starts = np.column_stack([axis.ravel() for axis in np.meshgrid(plane.x, plane.y)])
    slow, made = seconds(lambda: batch_of_pendulums(PENDULUM, starts, periods * PENDULUM.period))
    print(f"{line}; heyoka in batches of {made}, the same time of motion, no labels: {slow:.2f} s")


def main():
    """Measure and print."""
    part = float(sys.argv[1]) if len(sys.argv) > 1 else 1.0
    for measured in (diagram, exponents, cells, pendulum):
        measured(part)


if __name__ == "__main__":
    main()
