"""Lasting contact in many digits: the limit of impacts that accumulate, the motion while a stop holds, and its release.

Linear scenes, one stop at a time, stops that do not move. The stop holds by a force along the direction `b` of its impacts, so
the accelerations are those of the free motion less their part along `b` that would move the gap `h`: `(1 - b d^T / (d . b)) a`
with `d` the gradient of `h`. The coordinate that enters the gap most is eliminated by `h = 0`, and what is left is a linear
system like that of a flight. The check takes another way: the matrix exponential of the whole projected system.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from mpmath import mp

from .linear_flow import LinearPiece, extended, state_matrix
from .many_digits import Flight, Functions, bracketed
from .problems import Problem

AT_REST = 1e-30  # speed below which the rest of the bounces is replaced by its limit, an error of about its square
CALM = 0.02  # time after a release in which the motion leaves its stop, by less than doubles tell at first


@dataclass(frozen=True)
class Contact:
    """A linear stop, from its formulas: gap `offset + d . q`, restitution, and `share`, `b / (d . b)`."""

    offset: Any
    gradient: list[Any]
    restitution: Any
    share: list[Any]

    @classmethod
    def of(cls, functions: Functions, stop: int) -> Contact:
        """What unit positions and one impact tell."""
        n, gap, now, zero = functions.n, functions.gaps[stop], mp.mpf(0), [mp.mpf(0)] * functions.n
        offset = gap(now, *zero)[0]
        d = [gap(now, *[mp.mpf(i == j) for j in range(n)])[0] - offset for i in range(n)]
        before, speed = [-each for each in d], -dot(d, d)
        after = functions.impacts[stop](now, *zero, *before)
        restitution = -dot(d, after) / speed
        return cls(offset, d, restitution, [(u - w) / ((1 + restitution) * speed) for u, w in zip(before, after, strict=True)])

    def rates(self, functions: Functions, t: Any, x: list[Any]) -> tuple[Any, Any]:
        """First and second derivative of the gap in free motion."""
        return dot(self.gradient, x[functions.n :]), dot(self.gradient, functions.acceleration(t, *x))

    def held(self, values: list[Any]) -> list[Any]:
        """Velocities or accelerations without their part that moves the gap."""
        moving = dot(self.gradient, values)
        return [each - share * moving for each, share in zip(values, self.share, strict=True)]


def dot(a: list[Any], b: list[Any]) -> Any:
    """Scalar product."""
    return sum(u * w for u, w in zip(a, b, strict=True))


def limit(functions: Functions, contact: Contact, t: Any, x: list[Any]) -> tuple[Any, list[Any]]:
    """When and where the bounces end that follow a state just after one of them (Nordmark and Piiroinen 2009)."""
    n = functions.n
    speed, acceleration = contact.rates(functions, t, x)
    span = -2 * speed / (acceleration * (1 - contact.restitution))
    v, a = contact.held(x[n:]), contact.held(list(functions.acceleration(t, *x)))
    return t + span, [*(p + span * u for p, u in zip(x[:n], v, strict=True)), *(u + span * w for u, w in zip(v, a, strict=True))]


def projected(problem: Problem, contact: Contact) -> Any:
    """State matrix while the stop holds."""
    a, n = state_matrix(problem), problem.scene.n_dof
    for j in range(a.cols):
        for i, value in enumerate(contact.held([a[n + i, j] for i in range(n)])):
            a[n + i, j] = value
    return a


class HeldFlow:
    """Makes the motions of a linear scene on one of its stops."""

    def __init__(self, problem: Problem, contact: Contact) -> None:
        """Eliminate a coordinate and find the eigenvectors of what is left."""
        self.problem, n = problem, problem.scene.n_dof
        leading = max(range(n), key=lambda i: abs(contact.gradient[i]))
        held = projected(problem, contact)
        self.kept = [i for i in range(held.cols) if i not in (leading, n + leading)]
        whole = mp.zeros(held.cols, len(self.kept))
        for column, i in enumerate(self.kept):
            whole[i, column] = 1
            if i < 2 * n:
                row = leading if i < n else n + leading
                whole[row, column] = -contact.gradient[i % n] / contact.gradient[leading]
        whole[leading, len(self.kept) - 1] = -contact.offset / contact.gradient[leading]
        rate = held * whole
        reduced = mp.matrix([[rate[i, j] for j in range(len(self.kept))] for i in self.kept])
        self.values, vectors = mp.eig(reduced)
        self.inverse, self.vectors = mp.inverse(vectors), whole * vectors

    def __call__(self, t: Any, x: list[Any]) -> LinearPiece:
        """The motion to the end, were the stop to hold for ever."""
        z = extended(self.problem, t, x)
        weights = self.inverse * mp.matrix([z[i] for i in self.kept])
        return LinearPiece(self.problem, t, self.values, self.vectors, weights)


def release(piece: LinearPiece, functions: Functions, contact: Contact, t: Any) -> Any:
    """How long the stop holds: until the free acceleration of the gap rises through zero, or to the end."""

    def pull(s: Any) -> Any:
        return contact.rates(functions, t + s, piece.state(s))[1]

    low = mp.mpf(0)
    for s in piece.grid():
        high = min(mp.mpf(float(s)), piece.length)
        if pull(high) > 0:
            return bracketed(pull, low, high)
        low = high
    return piece.length


def check_calm(piece: Any, functions: Functions, contact: Contact) -> None:
    """Refuse a motion that comes back to its stop right after a release, where doubles do not see it."""
    for k in range(30):
        q = piece.state(mp.mpf(CALM) * mp.mpf("0.7") ** k)[: functions.n]
        if contact.offset + dot(contact.gradient, q) <= 0:
            message = f"{mp.nstr(CALM * 0.7**k, 3)} after a release the stop is touched again"
            raise ArithmeticError(message)


def by_exponentials(problem: Problem, flights: list[Flight]) -> Any:
    """Largest difference of any flight's end from the matrix exponential's, of a limit from that of one impact earlier."""
    functions, n = Functions.of(problem), problem.scene.n_dof
    return max(gaps_of_ends(problem, functions, n, flights))


def gaps_of_ends(problem: Problem, functions: Functions, n: int, flights: list[Flight]) -> Iterator[Any]:
    """The differences, flight by flight."""
    matrices = {pressed: state_matrix(problem, pressed) for pressed in {flight.pressed for flight in flights}}
    for last, flight in zip([None, *flights], flights, strict=False):
        matrix = matrices[flight.pressed]
        if flight.held >= 0:
            contact = Contact.of(functions, flight.held)
            matrix = projected(problem, contact)
            if last is not None:
                t, x = limit(functions, contact, last.start, last.state)
                yield max(abs(t - flight.start), *(abs(a - b) for a, b in zip(x, flight.state, strict=True)))
        z = mp.expm(matrix * (flight.end - flight.start)) * extended(problem, flight.start, flight.state)
        yield max(abs(z[i] - flight.before[i]) for i in range(2 * n))
