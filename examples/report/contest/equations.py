"""Equations of motion, guards and impacts of a scene, from its public attributes and the textbook, not from the library's core.

Everything is a formula (`formulas.py`) of time, positions and velocities. `number` makes the constants: `float` for the
contestants, a type of more digits for the references.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import vibroimpact as vi

from .derivative import derivatives
from .formulas import Symbol, Traced, cos, sin, traced

Number = Callable[[Any], Any]
Vector = Sequence[Any]


@dataclass(frozen=True)
class Equations:
    """Formulas of a scene: accelerations of (t, q, v), the gap of each stop of (t, q), velocities after impact of (t, q, v).

    Of stops that give way some are pressed: they push, have their gap with the other sign, and there are no impacts.
    """

    n_dof: int
    acceleration: Traced
    gaps: tuple[Traced, ...]
    impacts: tuple[Traced, ...]

    def jacobian(self) -> Traced:
        """Derivatives of the accelerations by positions and velocities, of (t, q, v), row after row."""
        return derivatives(self.acceleration, self.acceleration.arguments[1:])


def solved(matrix: Sequence[Vector], right: Vector) -> list[Any]:
    """Solution of a symmetric positive definite system by `L D L^T`, numbers and symbols alike."""
    n = len(right)
    lower: list[list[Any]] = [[0] * n for _ in range(n)]
    scaled: list[list[Any]] = [[0] * n for _ in range(n)]
    pivot: list[Any] = [0] * n
    for j in range(n):
        for k in range(j):
            scaled[j][k] = total([matrix[j][k]], [scaled[j][m] * lower[k][m] for m in range(k)])
            lower[j][k] = scaled[j][k] / pivot[k]
        pivot[j] = total([matrix[j][j]], [scaled[j][m] * lower[j][m] for m in range(j)])
    y: list[Any] = []
    for i in range(n):
        y.append(total([right[i]], [lower[i][m] * y[m] for m in range(i)]))
    x: list[Any] = [0] * n
    for i in reversed(range(n)):
        x[i] = total([y[i] / pivot[i]], [lower[m][i] * x[m] for m in range(i + 1, n)])
    return x


def total(terms: Sequence[Any], less: Sequence[Any] = ()) -> Any:
    """Sum of terms less other terms, without those that are zero."""
    kept = [term for term in terms if isinstance(term, Symbol) or term != 0]
    result: Any = kept[0] if kept else 0
    for term in kept[1:]:
        result = result + term
    for term in less:
        if isinstance(term, Symbol) or term != 0:
            result = result - term
    return result


def dot(a: Vector, b: Vector) -> Any:
    """Scalar product."""
    return total([x * y for x, y in zip(a, b, strict=True)])


@dataclass(frozen=True)
class Pendulum:
    """A chain of pendulums: what its equations need, in whatever units (theory of the chain: Lagrange's equations)."""

    lengths: list[Any]
    below: list[Any]
    gravity: Any
    damping: list[list[Any]]


def pendulum(system: vi.PendulumChain | vi.DoublePendulum, number: Number) -> Pendulum:
    """The chain behind a system; `below[i]` is the mass of bob i and all below it."""
    damping = [[number(each) for each in row] for row in system.damping.tolist()]
    if isinstance(system, vi.DoublePendulum):  # dimensionless: mass m1 + m2 and length l1 are 1, g/l1 is 1/(1 + m)
        mass, length = number(system.mass_ratio), number(system.length_ratio)
        one = number(1)
        return Pendulum([one, one / length], [one, mass / (one + mass)], one / (one + mass), damping)
    masses = [number(each) for each in system.masses.tolist()]
    below = [total(masses[i:]) for i in range(len(masses))]
    return Pendulum([number(each) for each in system.lengths.tolist()], below, number(system.gravity), damping)


def pendulum_mass(chain: Pendulum, sines: Vector, cosines: Vector) -> list[list[Any]]:
    """Mass matrix `l_i l_j S_max(i,j) cos(q_i - q_j)`."""
    n = len(chain.lengths)
    weight = [[chain.lengths[i] * chain.lengths[j] * chain.below[max(i, j)] for j in range(n)] for i in range(n)]
    return [
        [weight[i][j] if i == j else (cosines[i] * cosines[j] + sines[i] * sines[j]) * weight[i][j] for j in range(n)]
        for i in range(n)
    ]


def pendulum_acceleration(chain: Pendulum, push: Any, q: Vector, v: Vector) -> list[Any]:
    """Angular accelerations of the chain; `push` is minus the acceleration of its base."""
    n = len(chain.lengths)
    sines, cosines = [sin(each) for each in q], [cos(each) for each in q]
    squares = [each * each for each in v]
    force = []
    for i in range(n):
        turning = [
            (sines[j] * cosines[i] - cosines[j] * sines[i])
            * (chain.lengths[i] * chain.lengths[j] * chain.below[max(i, j)])
            * squares[j]
            for j in range(n)
            if j != i
        ]
        weight = chain.lengths[i] * chain.below[i]
        outer = (cosines[i] * push - sines[i] * chain.gravity) * weight
        force.append(total([outer, *turning], [u * c for c, u in zip(chain.damping[i], v, strict=True)]))
    return solved(pendulum_mass(chain, sines, cosines), force)


@dataclass(frozen=True)
class Tone:
    """One harmonic of what drives a scene of constant mass: accelerations `push cos(frequency t + phase)`."""

    frequency: Any
    phase: Any
    push: list[Any]

    def wave(self, t: Any) -> Any:
        """The cosine at a time."""
        return cos(t * self.frequency + self.phase)


def harmonic(forcing: vi.Harmonic | vi.BaseMotion, number: Number) -> Callable[[Any], Any]:
    """`cos(frequency t + phase)` of a forcing, or of a stop's motion."""
    frequency, phase = number(forcing.frequency), number(forcing.phase)
    return lambda t: cos(t * frequency + phase)


def forcings(scene: vi.Scene) -> tuple[Any, ...]:
    """What drives a scene, one or several or nothing."""
    forcing = scene.forcing
    return forcing if isinstance(forcing, tuple) else () if forcing is None else (forcing,)


def frequencies(scene: vi.Scene) -> list[float]:
    """Frequencies of what drives a scene and of what moves its stops."""
    motions = [stop.motion for stop in scene.stops if stop.motion is not None]
    return [each.frequency for each in (*forcings(scene), *motions)]


def tones(scene: vi.Scene, number: Number) -> list[Tone]:
    """All harmonics that drive a scene of constant mass."""
    mass = matrix_of(scene.system.mass, number)
    return [Tone(number(each.frequency), number(each.phase), linear_push(each, scene, mass, number)) for each in forcings(scene)]


def accelerations(scene: vi.Scene, number: Number) -> Callable[[Any, Vector, Vector], list[Any]]:
    """Accelerations of (t, q, v)."""
    system, forcing = scene.system, scene.forcing
    if isinstance(system, vi.NonlinearSystem):
        return given_accelerations(scene, number)
    if not isinstance(system, vi.LinearSystem):
        chain = pendulum(system, number)
        if forcing is None:
            return lambda _, q, v: pendulum_acceleration(chain, number(0), q, v)
        wave, size = harmonic(forcing, number), number(forcing.amplitude) * number(forcing.frequency) ** 2
        return lambda t, q, v: pendulum_acceleration(chain, wave(t) * size, q, v)
    mass, damping, stiffness = (matrix_of(each, number) for each in (system.mass, system.damping, system.stiffness))
    columns = range(system.n_dof)
    by_mass = [[solved(mass, [row[j] for row in each]) for j in columns] for each in (damping, stiffness)]
    load = solved(mass, [number(each) for each in system.load.tolist()])
    driven = tones(scene, number)

    def linear(t: Any, q: Vector, v: Vector) -> list[Any]:
        waves = [tone.wave(t) for tone in driven]
        outer = [[load[i], *(wave * tone.push[i] for wave, tone in zip(waves, driven, strict=True))] for i in columns]
        inner = [[u[j] * each[j][i] for u, each in zip((v, q), by_mass, strict=True) for j in columns] for i in columns]
        return [total(outer[i], inner[i]) for i in columns]

    return linear


def given_accelerations(scene: vi.Scene, number: Number) -> Callable[[Any, Vector, Vector], list[Any]]:
    """Accelerations by a user's law and a harmonic force."""
    move = scene.system.acceleration.formula(number)
    driven = tones(scene, number)

    def given(t: Any, q: Vector, v: Vector) -> list[Any]:
        own, waves = move(t, q, v), [tone.wave(t) for tone in driven]
        outer = [[wave * each for each in tone.push] for wave, tone in zip(waves, driven, strict=True)]
        return [total(terms) for terms in zip(own, *outer, strict=True)]

    return given if driven else move


def linear_push(forcing: Any, scene: vi.Scene, mass: list[list[Any]], number: Number) -> list[Any]:
    """Accelerations by a forcing of a scene of constant mass at its crest."""
    if isinstance(forcing, vi.BaseMotion):
        size = number(forcing.amplitude) * number(forcing.frequency) ** 2
        return [number(each) * size for each in scene.system.influence.tolist()]
    return solved(mass, [number(each) for each in forcing.amplitude.tolist()])


def matrix_of(values: Any, number: Number) -> list[list[Any]]:
    """Rows of a matrix, or of the diagonal matrix of a vector."""
    rows = values.tolist()
    if isinstance(rows[0], list):
        return [[number(each) for each in row] for row in rows]
    return [[number(each if i == j else 0) for j in range(len(rows))] for i, each in enumerate(rows)]


def normal(stop: Any, scene: vi.Scene, number: Number) -> Callable[[Vector], list[Any]]:
    """Direction in which the gap of a stop shrinks, of (q)."""
    if isinstance(stop, vi.Wall):
        lengths = pendulum(scene.system, number).lengths
        sign = number(1 if stop.side == "right" else -1)
        return lambda q: [cos(each) * (lengths[i] * sign) if i <= stop.bob else number(0) for i, each in enumerate(q)]
    sign = 1 if stop.side == "upper" else -1
    fixed = [int(i == stop.normal) for i in range(scene.n_dof)] if isinstance(stop.normal, int) else stop.normal.tolist()
    return lambda _: [number(sign * each) for each in fixed]


def shift(stop: Any, number: Number) -> Callable[[Any], Any]:
    """What a stop's own motion adds to its gap, of (t): a harmonic, or nothing."""
    if stop.motion is None:
        return lambda _: 0
    wave, size = harmonic(stop.motion, number), number(outward(stop) * stop.motion.amplitude.item())
    return lambda t: wave(t) * size


def shift_rate(stop: Any, number: Number) -> Callable[[Any], Any]:
    """Speed at which a stop's own motion opens its gap, of (t)."""
    if stop.motion is None:
        return lambda _: 0
    frequency, phase = number(stop.motion.frequency), number(stop.motion.phase)
    size = number(-outward(stop) * stop.motion.amplitude.item()) * frequency
    return lambda t: sin(t * frequency + phase) * size


def outward(stop: Any) -> int:
    """Sign with which a stop's motion opens its gap: a plane's is added to its clearance, a wall's to its position."""
    return -1 if isinstance(stop, vi.Wall) and stop.side == "left" else 1


def gap(stop: Any, scene: vi.Scene, number: Number) -> Callable[[Any, Vector], Any]:
    """Signed distance to a stop, of (t, q)."""
    moved = shift(stop, number)
    if isinstance(stop, vi.Wall):
        lengths = pendulum(scene.system, number).lengths
        sign = 1 if stop.side == "right" else -1
        start = number(sign * stop.position)
        return lambda t, q: total([start, moved(t), *(sin(q[i]) * (lengths[i] * -sign) for i in range(stop.bob + 1))])
    return lambda t, q: number(stop.clearance) + moved(t) - dot(q, normal(stop, scene, number)(q))


def impact(stop: Any, scene: vi.Scene, number: Number) -> Callable[[Any, Vector, Vector], list[Any]]:
    """Velocities after the impact on one stop, of (t, q, v): `v - (1 + e) b (n . v - c') / (n . b)`, `c'` its `shift_rate`."""
    direction, share, rate = normal(stop, scene, number), number(1) + number(stop.restitution), shift_rate(stop, number)

    def after(t: Any, q: Vector, v: Vector) -> list[Any]:
        n = direction(q)
        is_direct = getattr(stop, "reaction", "inertia") == "coordinate"
        b = n if is_direct else solved(mass_at(scene, q, number), n)
        speed = total([dot(v, n)], [rate(t)]) * share / dot(n, b)
        return [total([v[i]], [speed * each]) for i, each in enumerate(b)]

    return after


def push(stop: Any, scene: vi.Scene, number: Number) -> Callable[[Any, Vector, Vector], list[Any]]:
    """Accelerations by a pressed stop, of (t, q, v): `-b (k p + c p')`, p how far it is pressed, `b` by inertia."""
    to_gap, direction, rate = gap(stop, scene, number), normal(stop, scene, number), shift_rate(stop, number)
    stiffness, damping = number(stop.contact.stiffness), number(stop.contact.damping)

    def acceleration(t: Any, q: Vector, v: Vector) -> list[Any]:
        n = direction(q)
        force = to_gap(t, q) * stiffness - total([dot(v, n)], [rate(t)]) * damping
        return [each * force for each in solved(mass_at(scene, q, number), n)]

    return acceleration


def mass_at(scene: vi.Scene, q: Vector, number: Number) -> list[list[Any]]:
    """Mass matrix at a position."""
    if isinstance(scene.system, vi.LinearSystem | vi.NonlinearSystem):
        return matrix_of(scene.system.mass, number)
    chain = pendulum(scene.system, number)
    return pendulum_mass(chain, [sin(each) for each in q], [cos(each) for each in q])


def equations(scene: vi.Scene, number: Number = float, pressed: Sequence[int] = ()) -> Equations:
    """All formulas of a scene; `pressed` are those of its stops that give way and push."""
    n = scene.n_dof
    q, v = [f"q{i}" for i in range(n)], [f"v{i}" for i in range(n)]
    gaps = [gap(stop, scene, number) for stop in scene.stops]
    sides = [number(-1 if k in pressed else 1) for k in range(len(gaps))]
    impacts = [impact(stop, scene, number) for stop in scene.stops if stop.restitution is not None]
    parts = [accelerations(scene, number), *(push(scene.stops[k], scene, number) for k in pressed)]

    def move(t: Any, *x: Any) -> list[Any]:
        return [total(terms) for terms in zip(*(part(t, x[:n], x[n:]) for part in parts), strict=True)]

    return Equations(
        n,
        traced(move, ["t", *q, *v]),
        tuple(
            traced(lambda t, *x, each=each, side=side: [each(t, x) * side], ["t", *q])
            for each, side in zip(gaps, sides, strict=True)
        ),
        tuple(traced(lambda t, *x, each=each: each(t, x[:n], x[n:]), ["t", *q, *v]) for each in impacts),
    )
