"""Motions past stops that give way, in many digits: a linear flow for each set of pressed stops, from change to change.

Linear scenes, stops at rest. A contact begins and ends where its gap is zero; the state goes on through both.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from mpmath import mp

from .linear_flow import LinearFlow
from .many_digits import Flight, Functions
from .motion import one_flight
from .problems import Compliant


def motion(problem: Compliant) -> list[Flight]:
    """All flights of a problem, in order; the last one ends with the motion."""

    @cache
    def regime(pressed: tuple[int, ...]) -> tuple[LinearFlow, Functions]:
        return LinearFlow(problem, pressed), Functions.of(problem, pressed)

    t, x, end = mp.mpf(0), [mp.mpf(float(each)) for each in problem.start], mp.mpf(problem.end)
    pressed: tuple[int, ...] = ()
    flights: list[Flight] = []
    while t < end:
        flight = one_flight(*regime(pressed), t, x, end, -1, None, None)
        flights.append(replace(flight, pressed=pressed))
        t, x, pressed = flight.end, flight.before, toggled(pressed, flight.stop)
    return flights


def toggled(pressed: tuple[int, ...], stop: int) -> tuple[int, ...]:
    """The pressed stops after a change of one."""
    return tuple(sorted({*pressed} ^ {stop}))
