"""Several coordinates: stiff, light and heavy, gyroscopic, defective; the state at the end against the matrix exponential."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np
from mpmath import mpf

import vibroimpact as vi
from report.extremes.condition import Parts, truth
from report.extremes.exponential import system, system_truth
from report.extremes.finding import Finding, measured
from report.extremes.motion import ATOL, LINEAR, RTOL, SMALL, STEPPED, rule_of
from report.extremes.registry import case

Array = Sequence[Sequence[float]] | Sequence[float] | np.ndarray
Number = float | mpf
Pair = Sequence[Number]
START = ([0.7, -0.3], [0.2, 0.5])
QUIET = ([0.0, 0.0], 1.0)
PAIR = [[2.0, -1.0], [-1.0, 2.0]]
LIGHT, HEAVY, SHORT = 2.0**-20, 2.0**20, 2.0**-27  # next beyond 1e-6, 1e6 and 1e-8 among numbers that products keep exact


def full(matrix: Array) -> np.ndarray:
    """A matrix of its diagonal, or itself."""
    array = np.asarray(matrix, dtype=float)
    return np.diag(array) if array.ndim == 1 else array


def states(
    name: str,
    mass: Array,
    damping: Array,
    stiffness: Array,
    length: float,
    *,
    load: Sequence[float] = (0.0, 0.0),
    force: tuple[Sequence[float], float] = QUIET,
) -> Iterator[Finding]:
    """A linear system by exact flights and by steps."""
    m, c, k = full(mass), full(damping), full(stiffness)
    expected = system_truth(m, c, k, load, force[0], force[1], 0.0, *START, length)
    forcing = vi.Harmonic(*force) if np.any(force[0]) else None
    scene = vi.Scene(vi.LinearSystem(m, c, k, load=load), forcing)
    for method in LINEAR:
        end = vi.simulate(scene, *START, (0, length), method=method, rtol=RTOL, atol=ATOL * RTOL, keep="final").final
        yield measured(f"{name}: q, v at t = {length:g}", method, end, expected, rule_of(method))


def links(
    name: str,
    masses: tuple[float, float],
    lengths: tuple[float, float],
    length: float,
    *,
    damping: Array = (0.0, 0.0),
    gravity: float = 1.0,
) -> Iterator[Finding]:
    """Two links in minute swings by Taylor series, and their linear system by the other methods."""
    c = full(damping)
    m, k = (np.array(x, dtype=float) for x in mass_and_stiffness(masses, lengths, gravity))
    given = system_truth(m, c, k, [0, 0], *QUIET, 0.0, *START, length)
    linked = truth(links_alone, *masses, *lengths, gravity, *np.ravel(c), *np.ravel(START), length)
    pendulum = vi.Scene(vi.PendulumChain(masses, lengths, damping=c, gravity=gravity))
    linear = vi.Scene(vi.LinearSystem(m, c, k))
    for method, scene, unit, expected in (
        ("exact", linear, 1.0, given),
        *((method, linear, 1.0, given) for method in STEPPED),
        ("taylor", pendulum, SMALL, linked),
    ):
        q, v = (unit * np.array(x) for x in START)
        end = vi.simulate(scene, q, v, (0, length), method=method, rtol=RTOL, atol=ATOL * RTOL * unit, keep="final").final
        yield measured(f"{name}: q, v at t = {length:g}", method, [x / unit for x in end], expected, rule_of(method))


def mass_and_stiffness(masses: Pair, lengths: Pair, gravity: Number) -> tuple[list[list[Number]], list[list[Number]]]:
    """Matrices of two links in minute swings."""
    (m1, m2), (l1, l2) = masses, lengths
    mass = [[(m1 + m2) * l1**2, m2 * l1 * l2], [m2 * l1 * l2, m2 * l2**2]]
    return mass, [[gravity * l1 * (m1 + m2), 0 * gravity], [0 * gravity, gravity * l2 * m2]]


def links_alone(*inputs: mpf) -> Parts:
    """The state at the end from masses, lengths, gravity, dampers, start and time."""
    masses, lengths, (gravity,), damping, start = inputs[:2], inputs[2:4], inputs[4:5], inputs[5:9], inputs[9:]
    mass, stiffness = mass_and_stiffness(masses, lengths, gravity)
    quiet = [mpf(0)] * 4 + [mpf(1), mpf(0)]
    return system(2, [*chain.from_iterable(mass), *damping, *chain.from_iterable(stiffness), *quiet, *start])


@case("stiffness ratio 1e8")
def stiff() -> Iterator[Finding]:
    yield from states("undamped", [1, 1], [0, 0], [[1e8 + 1, -1], [-1, 1]], 0.1)
    yield from states("damped by 1 %, forced", [1, 1], [200, 0.1], [[1e8, -1], [-1, 1]], 5.0, force=([1, 1], 1.3))
    yield from states("overdamped", [1, 1], [2e4, 0.1], [[1e8, -1], [-1, 1]], 0.02)
    yield from links("links, one 1e8 times as long as the other", (1.0, 1.0), (1.0, SHORT), 1e-3)


@case("mass ratio 1e-6")
def light() -> Iterator[Finding]:
    yield from states("coupled by springs, forced", [1, 1e-6], [0.1, 0], PAIR, 0.5, force=([1, 0], 1.3))
    yield from links("links, a light bob below", (1.0, LIGHT), (1.0, 1.0), 3.0)


@case("mass ratio 1e6")
def heavy() -> Iterator[Finding]:
    yield from states("coupled by springs, forced", [1, 1e6], [0.1, 0], PAIR, 20.0, force=([1, 0], 1.3))
    yield from links("links, a heavy bob below", (1.0, HEAVY), (1.0, 1.0), 0.05)


@case("rigid-body mode")
def rigid() -> Iterator[Finding]:
    yield from states("two bodies and a spring", [1, 2], [0, 0], [[1, -1], [-1, 1]], 30.0, force=([1, 0], 1.3))
    yield from links("links without gravity", (1.0, 1.0), (1.0, 1.0), 30.0, gravity=0.0)


@case("a load on a rigid-body mode")
def loaded() -> Iterator[Finding]:
    yield from states("two bodies and a spring", [1, 2], [0, 0], [[1, -1], [-1, 1]], 30.0, load=[0.3, 0.1])
    yield from states("and dampers", [1, 2], [0.1, 0.2], [[1, -1], [-1, 1]], 30.0, load=[0.3, 0.1])


@case("negative stiffness (inverted pendulum)")
def saddle() -> Iterator[Finding]:
    yield from states("a saddle, loaded", [1, 1], [0, 0], [[1, 2], [2, 1]], 15.0, load=[0.1, 0])
    yield from links("links upside down", (1.0, 1.0), (1.0, 1.0), 5.0, gravity=-1.0)


@case("negative damping")
def growing() -> Iterator[Finding]:
    yield from links("links, one joint driven", (1.0, 1.0), (1.0, 1.0), 5.0, damping=[[0.1, -0.2], [-0.2, -0.3]])


@case("gyroscopic damping")
def gyroscopic() -> Iterator[Finding]:
    yield from states("forced", [1, 1], [[0, 3], [-3, 0]], [1, 2], 20.0, force=([1, 0], 1.3))
    yield from states("what stabilises negative stiffness", [1, 1], [[0, 5], [-5, 0]], [-1, -2], 20.0)
    yield from states("in a plane, loaded", [1, 1], [[0, 3], [-3, 0]], [0, 0], 20.0, load=[1, 0])
    yield from links("links", (1.0, 1.0), (1.0, 1.0), 20.0, damping=[[0, 3], [-3, 0]])


@case("repeated natural frequencies")
def repeated() -> Iterator[Finding]:
    yield from states("coupled by dampers, forced", [1, 1], [[0.3, 0.1], [0.1, 0.2]], [2, 2], 20.0, force=([1, 0], 1.4))
    yield from states("apart by 1e-12", [1, 1], [0, 0], [2, 2 + 1e-12], 20.0)
    yield from links("links without gravity, dampers", (1.0, 1.0), (1.0, 1.0), 20.0, damping=PAIR, gravity=0.0)


@case("defective state matrix")
def defective() -> Iterator[Finding]:
    yield from states("forced", [1, 1], [0, 0], [[1, 1], [0, 1]], 20.0, force=([1, 0], 1.3))
    yield from states("in resonance", [1, 1], [0, 0], [[1, 1], [0, 1]], 20.0, force=([1, 1], 1.0))
    yield from states("all but, by 1e-12", [1, 1], [0, 0], [[1, 1], [0, 1 + 1e-12]], 20.0)
    yield from states("a follower force", [1, 1], [0, 0], [[1, 1], [-1, 1]], 20.0)
