"""Motions in many digits: flight after flight, impact after impact, in and out of lasting contact.

Impacts that accumulate are followed one by one down to speeds of 1e-30; the rest of them is a closed form (`lasting.py`).
"""

from __future__ import annotations

from typing import Any

from mpmath import mp

from .lasting import AT_REST, CALM, Contact, HeldFlow, check_calm, limit, release
from .many_digits import SOON, Flight, Flow, Functions, close_back, first_contact, soon_back
from .problems import Problem

RELEASED = -2  # in place of the stop that was hit last


class Stops:
    """The stops of a problem whose impacts may accumulate, and the flows on them, made when first needed."""

    def __init__(self, problem: Problem, functions: Functions) -> None:
        """None are made yet."""
        self.problem, self.functions = problem, functions
        self.contacts: dict[int, Contact] = {}
        self.flows: dict[int, HeldFlow] = {}

    def contact(self, stop: int) -> Contact:
        """A stop."""
        if stop not in self.contacts:
            self.contacts[stop] = Contact.of(self.functions, stop)
        return self.contacts[stop]

    def span(self, stop: int, t: Any, x: list[Any]) -> Flight:
        """The span in which a stop holds, from the limit of the bounces that follow a state."""
        contact = self.contact(stop)
        if stop not in self.flows:
            self.flows[stop] = HeldFlow(self.problem, contact)
        start, state = limit(self.functions, contact, t, x)
        piece = self.flows[stop](start, state)
        length = release(piece, self.functions, contact, start)
        return Flight(start, state, start + length, piece.state(length), -1, stop)


def motion(problem: Problem, flow: Flow) -> list[Flight]:
    """All flights of a problem, in order; the last one ends with the motion."""
    functions = Functions.of(problem)
    n, end, stops = functions.n, mp.mpf(problem.end), Stops(problem, functions)
    t, x, hit = mp.mpf(0), [mp.mpf(float(each)) for each in problem.start], -1
    flights: list[Flight] = []
    held = -1
    while t < end:
        contact = stops.contact(hit) if hit >= 0 and problem.first is not None else None
        if contact is not None and is_over(contact, functions, t, x):
            held = hit
            flights.append(stops.span(hit, t, x))
            t, x, hit = flights[-1].end, flights[-1].before, RELEASED
            continue
        calm = stops.contact(held) if hit == RELEASED else None
        flights.append(one_flight(flow, functions, t, x, end, hit, contact, calm))
        t, x, hit = flights[-1].end, flights[-1].before, flights[-1].stop
        if hit >= 0:
            x = [*x[:n], *functions.impacts[hit](t, *x)]
    return flights


def is_over(contact: Contact, functions: Functions, t: Any, x: list[Any]) -> bool:
    """Whether what is left of the bounces is too small to follow."""
    speed, acceleration = contact.rates(functions, t, x)
    return acceleration < 0 and speed < AT_REST


def back(piece: Any, functions: Functions, contact: Contact, stop: int, t: Any, x: list[Any]) -> Any | None:
    """Time of a return to the stop just left that doubles do not see."""
    speed, acceleration = contact.rates(functions, t, x)
    if acceleration < 0 and -2 * speed / acceleration < SOON * piece.quickest:
        return soon_back(piece, functions, stop, -2 * speed / acceleration)
    return close_back(piece, functions, stop)


def one_flight(
    flow: Flow,
    functions: Functions,
    t: Any,
    x: list[Any],
    end: Any,
    hit: int,
    contact: Contact | None,
    calm: Contact | None,
) -> Flight:
    """The flight from a state to the next contact or the end; `contact` the stop just hit, `calm` the one that let go."""
    at = t
    for piece in flow(t, x):
        if contact is not None and at == t and (s := back(piece, functions, contact, hit, t, x)) is not None:
            return Flight(t, x, at + s, piece.state(s), hit)
        if calm is not None and at == t:
            check_calm(piece, functions, calm)
        found = first_contact(piece, functions, CALM if calm is not None and at == t else 0.0)
        if found is not None and at + found[0] < end:
            return Flight(t, x, at + found[0], piece.state(found[0]), found[1])
        if at + piece.length >= end:
            return Flight(t, x, end, piece.state(end - at), -1)
        at += piece.length
    raise AssertionError(at)
