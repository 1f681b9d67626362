"""One mode at every damping: the state at the end, and the roots where they nearly meet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np
from mpmath import mp, mpf

import vibroimpact as vi
from report.extremes.condition import Parts, Truth, truth
from report.extremes.finding import ROUNDING, Finding, measured, size
from report.extremes.motion import ATOL, PENDULUM, RTOL, Motion, final_states, rule_of
from report.extremes.registry import case

START = {"q": 0.7, "v": -0.4}
PUSH = {"force": 0.8, "frequency": 1.7, "phase": 0.3}
OFF = 1e-12


def both(ratio: float, length: float) -> Iterator[Finding]:
    """A mode of unit frequency, free and forced."""
    for name, force in (("free", {}), ("forced", PUSH)):
        yield from final_states(name, Motion(2 * ratio, 1.0, length=length, **START, **force))


@case("zeta = 0")
def undamped() -> Iterator[Finding]:
    yield from both(0.0, 20.0)


@case("zeta_j = 1 exactly")
def critical() -> Iterator[Finding]:
    yield from both(1.0, 3.0)


def ratio_from_roots(damping: mpf, stiffness: mpf) -> Parts:
    """The eigenvalue of larger real part: a double root is as sensitive as a square root at zero."""
    root = mp.sqrt(mp.mpc(damping**2 / 4 - stiffness)) - damping / 2
    return [[mp.re(root), mp.im(root)]]


@case("zeta_j = 1 +- 1e-12")
def nearly_critical() -> Iterator[Finding]:
    for ratio in (1 - OFF, 1 + OFF):
        side = "below" if ratio < 1 else "above"
        for finding in both(ratio, 3.0):
            yield named(finding, side)
        eigenvalues = vi.modes(vi.LinearSystem(1, 2 * ratio, 1)).eigenvalues
        found = max(eigenvalues, key=lambda root: (root.real, root.imag))
        parts = [[found.real, found.imag]]
        yield measured(f"{side}: eigenvalue", "modes", parts, truth(ratio_from_roots, 2 * ratio, 1.0), ROUNDING)


def named(finding: Finding, prefix: str) -> Finding:
    """The same under a longer name."""
    return Finding(**(vars(finding) | {"quantity": f"{prefix}, {finding.quantity}"}))


@case("zeta_j = 1e3 (overdamped)")
def overdamped() -> Iterator[Finding]:
    yield from both(1e3, 2.0)
    yield from final_states("free", Motion(2e3, 1.0, length=1e3, **START))


@case("rigid-body mode")
def rigid() -> Iterator[Finding]:
    yield from final_states("free", Motion(length=1e3, **START))
    yield from final_states("forced", Motion(length=30.0, **START, **PUSH))


@case("damped rigid body")
def damped_rigid() -> Iterator[Finding]:
    for damping in (0.3, 1e-12):
        yield from final_states(f"damping {damping:g}, forced", Motion(damping, length=30.0, **START, **PUSH))
    yield from final_states("damping 0.3, loaded", Motion(0.3, load=0.3, length=30.0, **START))


@case("a load on a rigid-body mode")
def loaded_rigid() -> Iterator[Finding]:
    yield from final_states("loaded", Motion(load=0.3, length=30.0, **START))
    yield from final_states("loaded and forced", Motion(load=0.3, length=30.0, **START, **PUSH))


@case("negative stiffness (inverted pendulum)")
def inverted() -> Iterator[Finding]:
    yield from final_states("linear, forced", Motion(0.1, -1.0, length=20.0, **START, **PUSH), small=2.0**-60)
    yield from final_states("linear, stiffness -1e6", Motion(0.0, -1e6, length=0.5, **START), small=2.0**-760)
    yield from separatrix()


def separatrix() -> Iterator[Finding]:
    """The link upside down, q'' = sin q, moves on q = 4 atan(e^s), q' = 2/cosh(s), where it starts on it."""
    q, v = float(4 * mp.atan(mp.exp(-3))), float(2 * mp.sech(-3))
    length = 5.0
    expected = truth(upside_down, q, v, length)
    for method in PENDULUM:
        scene = vi.Scene(vi.PendulumChain([1], [1], gravity=-1))
        end = vi.simulate(scene, q, v, (0, length), method=method, rtol=RTOL, atol=ATOL * RTOL, keep="final").final
        yield measured(f"large angles, next to the separatrix: q, v at t = {length:g}", method, end, expected, rule_of(method))


def upside_down(q: mpf, v: mpf, length: mpf) -> Parts:
    """Q'' = sin q by its Taylor series of 40 terms in 20 steps, each a sixth of the way to the nearest pole."""
    steps = 20
    h = length / steps
    for _ in range(steps):
        q, v = series_step(q, v, h)
    return [[q], [v]]


def series_step(q: mpf, v: mpf, h: mpf, order: int = 40) -> tuple[mpf, mpf]:
    """One step along the series of q'' = sin q, by the recurrences of sine and cosine."""
    x, s, c = [q, v], [mp.sin(q)], [mp.cos(q)]
    for k in range(order):
        x.append(s[k] / ((k + 1) * (k + 2)))
        pairs = [(j, j * x[j]) for j in range(1, k + 2)]
        s.append(sum(w * c[k + 1 - j] for j, w in pairs) / (k + 1))
        c.append(-sum(w * s[k + 1 - j] for j, w in pairs) / (k + 1))
    position = mp.polyval(x[::-1], h)
    speed = mp.polyval([k * a for k, a in enumerate(x)][:0:-1], h)
    return position, speed


@case("negative damping")
def growing() -> Iterator[Finding]:
    yield from final_states("free", Motion(-0.3, 1.0, length=30.0, **START))
    yield from final_states("forced", Motion(-0.3, 1.0, length=30.0, **START, **PUSH))


@case("10^3 modes")
def thousand() -> Iterator[Finding]:
    """w_j = j without damping: each mode is its own cosine and sine."""
    n, end, soon = 1000, 7.3, 0.7
    w = np.arange(1.0, n + 1)
    q0, v0 = 1 / w**2, np.cos(w)
    scene = vi.Scene(vi.LinearSystem(np.ones(n), np.zeros(n), w**2))
    each = [truth(swing, *inputs, end) for inputs in zip(w, q0, v0, strict=True)]
    q, v = vi.simulate(scene, q0, v0, (0, end), keep="final").final
    worst = [measured(f"mode {j + 1} by itself: q, v at t = {end:g}", "exact", [q[j], v[j]], each[j], ROUNDING) for j in range(n)]
    yield max(worst, key=lambda finding: finding.error / finding.allowed)
    together = gathered([truth(swing, *inputs, soon) for inputs in zip(w, q0, v0, strict=True)])
    # An implicit step would solve a thousand equations.
    for method in ("exact", "rk45", "dop853"):
        options = {"rtol": RTOL, "atol": ATOL * RTOL, "keep": "final"}
        found = vi.simulate(scene, q0, v0, (0, soon), method=method, **options).final
        yield measured(f"all together: q, v at t = {soon:g}", method, found, together, rule_of(method))


def gathered(truths: Sequence[Truth]) -> Truth:
    """Parts of uncoupled motions, each the part of one."""
    parts = [list(chain.from_iterable(same)) for same in zip(*(each.parts for each in truths), strict=True)]
    changes = [max(t.conditions[i] * size(t.parts[i]) for t in truths) for i in range(len(parts))]
    return Truth(parts, [float(change / size(part)) for change, part in zip(changes, parts, strict=True)])


def swing(w: mpf, q: mpf, v: mpf, t: mpf) -> Parts:
    """Free motion without damping."""
    c, s = mp.cos(w * t), mp.sin(w * t)
    return [[q * c + v / w * s], [v * c - w * q * s]]
