"""numbalsoda: compiled DOP853 and LSODA under Numba; the loop over the flights is compiled too.

`solve_ivp` (DOP853) ends at a change of sign of an event (of several in one step, the first of its list: so there is one, the
smallest gap), located to 1e-8; one Taylor step takes the state onto the stop, another off it by 1e-9 of time. LSODA has no
events: it gives states at 24 points in each period of a forcing or a stop, or in each unit of time where that is shorter, and the
point of contact is found by restarts from the one before it.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numba as nb
import numpy as np
from numbalsoda import lsoda, lsoda_sig, solve_ivp

from ..equations import equations, frequencies
from ..problems import Problem
from . import Outcome, Run, Tolerances

DISTRIBUTION = "numbalsoda"
MOST = 100_000  # impacts kept
STEPS = 10**8
OFF = 1e-9  # time of a Taylor step off the stop: on it, any change of sign by rounding is an event


def methods(_: Problem) -> list[str]:
    """Both integrators."""
    return ["dop853", "lsoda"]


def compiled_formulas(problem: Problem):
    """Right-hand side and events for the integrators; distance, state on the stop and impact for the loop."""
    formulas = equations(problem.scene)
    n = formulas.n_dof
    space = {"nb": nb, "sin": math.sin, "cos": math.cos, "signature": lsoda_sig}
    exec(formulas.acceleration.source("acceleration_of"), space)
    space["acceleration"] = nb.njit(space["acceleration_of"])
    place, state = (", ".join(["t", *(f"x[{i}]" for i in range(k))]) for k in (n, 2 * n))
    text = ["def rate(t, x, dx, data):", f"    a = acceleration({state})"]
    text += [f"    dx[{i}] = x[{n + i}]\n    dx[{n + i}] = a[{i}]" for i in range(n)]
    text += ["def distances(t, x, out, data):"]
    text += [f"    out[{k}] = gap{k}({place})[0]" for k in range(len(formulas.gaps))]
    closest = ", ".join(f"gap{k}({place})[0]" for k in range(len(formulas.gaps)))
    text += ["def smallest(t, x, out, data):", f"    out[0] = min(({closest},))"]
    text += ["def turn(k, t, x):"]
    for k, (gap, impact) in enumerate(zip(formulas.gaps, formulas.impacts, strict=True)):
        exec(gap.source(f"gap_of_{k}") + impact.source(f"impact_of_{k}"), space)
        space[f"gap{k}"], space[f"impact{k}"] = nb.njit(space[f"gap_of_{k}"]), nb.njit(space[f"impact_of_{k}"])
        text += [f"    if k == {k}:", f"        r = impact{k}({state})"]
        text += [f"        x[{n + i}] = r[{i}]" for i in range(n)]
    exec("\n".join(text) + "\n", space)
    rate, distances = nb.njit(space["rate"]), nb.njit(space["distances"])
    return n, rate, distances, nb.njit(space["turn"]), nb.cfunc(lsoda_sig)(space["rate"]), nb.cfunc(lsoda_sig)(space["smallest"])


@lru_cache(maxsize=4)
def loops(problem: Problem):
    """The compiled loops of both methods."""
    n, rate, distances, turn, rate_pointer, event_pointer = compiled_formulas(problem)
    n_stops, f, g = len(problem.scene.stops), rate_pointer.address, event_pointer.address
    fastest = max(frequencies(problem.scene), default=1.0)
    spacing = min(2.0 * np.pi / fastest, 1.0) / 24.0

    @nb.njit
    def moved(t, x, s):
        """A Taylor step, second order in the positions."""
        dx, y, none = np.empty(2 * n), x.copy(), np.zeros(1)
        rate(t, x, dx, none)
        for i in range(n):
            y[i] += s * x[n + i] + 0.5 * s * s * dx[n + i]
            y[n + i] += s * dx[n + i]
        return y

    @nb.njit
    def distance(t, x, k):
        out, none = np.empty(n_stops), np.zeros(1)
        distances(t, x, out, none)
        return out[k]

    @nb.njit
    def speed(t, x, k):
        """Rate of change of a gap, by a difference that is exact for flat stops at rest."""
        h = 1e-6
        ahead, behind = x.copy(), x.copy()
        for i in range(n):
            ahead[i] += h * x[n + i]
            behind[i] -= h * x[n + i]
        return (distance(t + h, ahead, k) - distance(t - h, behind, k)) / (2.0 * h)

    @nb.njit
    def by_dop853(start, end, rtol, atol):
        t, x, times, count = 0.0, start.copy(), np.empty(MOST), 0
        none, out = np.zeros(1), np.empty(n_stops)
        while t < end:
            flight = solve_ivp(f, np.array([t, end]), x, np.array([end]), "DOP853", 1, g, 0, 0.0, 0.0, rtol, atol)
            if not flight.event_found:
                if not flight.success:
                    raise RuntimeError("DOP853 failed")
                return flight.y[-1].copy(), times[:count]
            t, x = flight.t_event, flight.y_event.copy()
            distances(t, x, out, none)
            k = np.argmin(out)
            v = speed(t, x, k)
            if v < 0.0:
                s = -distance(t, x, k) / v
                t, x = t + s, moved(t, x, s)
                turn(k, t, x)
                times[count] = t
                count += 1
            t, x = t + OFF, moved(t, x, OFF)
        return x, times[:count]

    @nb.njit
    def by_lsoda(start, end, rtol, atol):
        t, x, times, count = 0.0, start.copy(), np.empty(MOST), 0
        none, out, old = np.zeros(1), np.empty(n_stops), np.empty(n_stops)
        while t < end:
            grid = t + spacing * np.arange(65)
            grid = grid[grid < end]
            grid = np.append(grid, min(t + 65 * spacing, end))
            states, success = lsoda(f, x, grid, none, rtol, atol, STEPS)
            if not success:
                raise RuntimeError("LSODA failed")
            hit, j = -1, 0
            distances(t, x, old, none)
            while hit < 0 and j < len(grid) - 1:
                j += 1
                distances(grid[j], states[j], out, none)
                first = 1.0
                for k in range(n_stops):
                    if out[k] < 0.0 < old[k] and old[k] / (old[k] - out[k]) < first:
                        hit, first = k, old[k] / (old[k] - out[k])
                old[:] = out
            if hit < 0:
                t, x = grid[-1], states[-1].copy()
                continue
            low, y, t0 = states[j - 1].copy(), states[j].copy(), grid[j - 1]
            s = grid[j] - t0
            for _ in range(20):  # Newton's method, each state by a restart
                change = -distance(t0 + s, y, hit) / speed(t0 + s, y, hit)
                s = min(max(s + change, 1e-14), grid[j] - t0)
                if abs(change) < 1e-9:
                    y = moved(t0 + s - change, y, change)
                    break
                y = moved(t0, low, s)
                if s > OFF:
                    again, success = lsoda(f, low, np.array([t0, t0 + s]), none, rtol, atol, STEPS)
                    y = again[1].copy()
            t, x = t0 + s, y
            turn(hit, t, x)
            times[count] = t
            count += 1
            t, x = t + OFF, moved(t, x, OFF)
        return x, times[:count]

    pointers = (rate_pointer, event_pointer)  # kept alive with the loops
    return {"dop853": by_dop853, "lsoda": by_lsoda}, pointers


def prepare(problem: Problem, method: str, tolerances: Tolerances) -> Run:
    """One call of the compiled loop; compiled here by a run to the first instant."""
    loop = loops(problem)[0][method]
    start, end, rtol, atol = problem.start, problem.end, tolerances.relative, tolerances.absolute
    loop(start, 1e-6, rtol, atol)

    def run() -> Outcome:
        return Outcome(*loop(start, end, rtol, atol))

    return run
