"""Motions with one instant of impact a period, in fifty digits: the state after it and the contact, linear in the phase.

With u = (cos phase, sin phase), steady response s and recovery matrix R: (I - R e^(A T)) z = (R - I) s(0), x(0+) = z + s(0).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from mpmath import matrix, mp, mpc, mpf

from report.extremes.condition import Parts
from report.extremes.exponential import Rows, flow


def state_matrix(mass: Rows, damping: Rows, stiffness: Rows) -> matrix:
    """A of x' = A x."""
    n = len(mass)
    inverse, rate = mp.matrix(mass) ** -1, mp.zeros(2 * n)
    rate[:n, n:] = mp.eye(n)
    rate[n:, :n] = -inverse * mp.matrix(stiffness)
    rate[n:, n:] = -inverse * mp.matrix(damping)
    return rate


def recovery(restitutions: Sequence[mpf | None]) -> matrix:
    """R of stops that reset one coordinate each; None where a coordinate has none."""
    n = len(restitutions)
    result = mp.eye(2 * n)
    for i, e in enumerate(restitutions):
        result[n + i, n + i] = 1 if e is None else -e
    return result


def after_impact(rate: matrix, jump: matrix, force: Sequence[mpf], frequency: mpf, n_periods: int) -> matrix:
    """x(0+) as a 2n x 2 matrix times u; force (n,) is M^-1 F."""
    n = rate.rows // 2
    steady = mp.lu_solve(1j * frequency * mp.eye(2 * n) - rate, mp.matrix([mpc(0)] * n + [mpc(f) for f in force]))
    start = mp.matrix([[mp.re(x), mp.re(1j * x)] for x in steady])
    period = 2 * mp.pi * n_periods / frequency
    rest = mp.eye(2 * n) - jump * flow(rate, period)
    free = mp.matrix([[mpf(0)] * 2 for _ in range(2 * n)])
    for k in range(2):
        column = mp.lu_solve(rest, (jump - mp.eye(2 * n)) * start[:, k])
        for i in range(2 * n):
            free[i, k] = column[i]
    return free + start


def one_stop(n_periods: int) -> Callable[..., Parts]:
    """Phases, ascending, and speeds after the impact of both orbits of an oscillator with an upper stop."""

    def function(damping: mpf, stiffness: mpf, force: mpf, frequency: mpf, restitution: mpf, clearance: mpf) -> Parts:
        rate = state_matrix([[mpf(1)]], [[damping]], [[stiffness]])
        state = after_impact(rate, recovery([restitution]), [force], frequency, n_periods)
        middle, half = mp.atan2(state[0, 1], state[0, 0]), mp.acos(clearance / mp.hypot(state[0, 0], state[0, 1]))
        phases = sorted((middle + sign * half) % (2 * mp.pi) for sign in (1, -1))
        return [phases, [state[1, 0] * mp.cos(p) + state[1, 1] * mp.sin(p) for p in phases]]

    return function


def on_the_way(n_periods: int) -> Callable[..., Parts]:
    """Positions and velocities of the orbit of the smaller phase at its impact and after one and two waits."""

    def function(damping: mpf, stiffness: mpf, force: mpf, frequency: mpf, restitution: mpf, clearance: mpf, wait: mpf) -> Parts:
        start = driven_state(damping, stiffness, force, frequency, restitution, clearance, n_periods)
        later = flow(driven_rate(damping, stiffness, force, frequency), wait)
        states = [start, later * start, later * (later * start)]
        return [[x[0] for x in states], [x[1] for x in states]]

    return function


def driven_rate(damping: mpf, stiffness: mpf, force: mpf, frequency: mpf) -> matrix:
    """Rate matrix of (q, v, cos, sin) of a driven oscillator."""
    rate = mp.zeros(4)
    rate[0, 1], rate[1, 0], rate[1, 1], rate[1, 2] = 1, -stiffness, -damping, force
    rate[2, 3], rate[3, 2] = -frequency, frequency
    return rate


def driven_state(
    damping: mpf, stiffness: mpf, force: mpf, frequency: mpf, restitution: mpf, clearance: mpf, n_periods: int = 1
) -> matrix:
    """(q, v, cos, sin) right after the impact of the orbit of the smaller phase."""
    inputs = damping, stiffness, force, frequency, restitution, clearance
    phase = one_stop(n_periods)(*inputs)[0][0]
    u = mp.matrix([mp.cos(phase), mp.sin(phase)])
    rate = state_matrix([[mpf(1)]], [[damping]], [[stiffness]])
    state = after_impact(rate, recovery([restitution]), [force], frequency, n_periods) * u
    return mp.matrix([state[0], state[1], u[0], u[1]])


def reach(damping: mpf, stiffness: mpf, force: mpf, frequency: mpf, restitution: mpf) -> mpf:
    """|alpha|: the largest clearance at which an oscillator has an orbit of one impact a period."""
    rate = state_matrix([[mpf(1)]], [[damping]], [[stiffness]])
    state = after_impact(rate, recovery([restitution]), [force], frequency, 1)
    return mp.hypot(state[0, 0], state[0, 1])


def mismatch(entries: Sequence[mpf], n: int, n_periods: int) -> mpf:
    """1 - |L^-1 d| of stops on all coordinates hit at one instant: mass, damping, stiffness, F, w, restitutions, d."""
    cuts = np.cumsum([n * n, n * n, n * n, n, 1, n]).tolist()
    mass, damping, stiffness, force, (w,), e, d = (entries[a:b] for a, b in zip([0, *cuts], [*cuts, None], strict=True))
    rows = [[list(m[i * n : (i + 1) * n]) for i in range(n)] for m in (mass, damping, stiffness)]
    accelerations = mp.matrix(rows[0]) ** -1 * mp.matrix(force)
    state = after_impact(state_matrix(*rows), recovery(list(e)), list(accelerations), w, n_periods)
    return 1 - mp.norm(mp.lu_solve(state[:n, :], mp.matrix(d)))
