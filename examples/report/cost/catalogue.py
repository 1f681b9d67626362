"""The features of a scene, each as a case beside the same scene without it."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

import vibroimpact as vi
from report.cost import scenes
from report.cost.callables import available
from report.cost.case import Case, Group, Run
from report.cost.scenes import IMPACT_EVERY, LOOSE, OTHER, PERIOD, PROPORTIONAL, SMALL, START, STEP_EVERY, pair, pendulum, stops

Make = Callable[[], vi.Scene]


def times(span: float, count: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """So many times over a span."""
    return np.linspace(0.0, span, count)


def impacts(make: Make, keep: str = "final", samples: int = 0, start: Any = START) -> Run:
    """Exact flights over so many impacts, with so many times asked for per impact."""
    scene = make()
    asked = functools.cache(lambda span, count: times(span, count) if count else None)

    def run(units: int) -> int:
        span = IMPACT_EVERY * units
        t_eval = asked(span, samples * units)
        done = vi.simulate(scene, *start, (0.0, span), method="exact", rtol=LOOSE, keep=keep, t_eval=t_eval)
        return int(done.stats.n_impacts)

    return run


def pressed(law: Any, method: str) -> Run:
    """Contacts with the first stop of the pair."""
    scene = pair(stops=[vi.Stop(0, 0.1, contact=law)])

    def run(units: int) -> int:
        done = vi.simulate(scene, *START, (0.0, IMPACT_EVERY * units), method=method, rtol=LOOSE, keep="final")
        return int(done.stats.n_contacts or done.stats.n_impacts)

    return run


def steps(make: Make, keep: str = "final", samples: int = 0, method: str = "rk45") -> Run:
    """So many steps of an integrator; the number of times asked for is that per step."""
    scene = make()
    asked = functools.cache(lambda span, count: times(span, count) if count else None)

    def run(units: int) -> int:
        span = STEP_EVERY * units
        t_eval = asked(span, samples * units)
        done = vi.simulate(scene, *START, (0.0, span), method=method, rtol=LOOSE, keep=keep, t_eval=t_eval)
        return int(done.stats.n_steps)

    return run


def recorded(method: str) -> Run:
    """Impacts of exact flights, or steps, under a record: ten samples in a flight, one in a step."""
    every, unit = (IMPACT_EVERY / 10, IMPACT_EVERY) if method == "exact" else (STEP_EVERY, STEP_EVERY)
    near = stops(1) if method == "exact" else []
    scene = functools.cache(lambda span: pair(forcing=scenes.record(span, every), stops=near))

    def run(units: int) -> int:
        span = unit * units
        done = vi.simulate(scene(span), *START, (0.0, span), method=method, rtol=LOOSE, keep="final")
        return int(done.stats.n_impacts if method == "exact" else done.stats.n_steps)

    return run


def swept() -> Run:
    """Impacts under a force that is swept all along: some 23 pieces in a flight."""
    scene = pair(forcing=scenes.harmonic(), stops=stops(1))

    def run(units: int) -> int:
        span = IMPACT_EVERY * units
        ramp = vi.Ramp("frequency", 1.01 * scenes.FREQUENCY, over=span)
        done = vi.simulate(scene, *START, (0.0, span), rtol=LOOSE, keep="final", ramp=ramp)
        return int(done.stats.n_impacts)

    return run


def evaluations(make: Callable[[], vi.NonlinearSystem | vi.LinearSystem]) -> Run:
    """Runge-Kutta steps, counted by their evaluations of the right-hand side."""
    scene = vi.Scene(make())

    def run(units: int) -> int:
        span = STEP_EVERY * units / 6.0
        done = vi.simulate(scene, *START, (0.0, span), method="rk45", rtol=LOOSE, keep="final")
        return int(done.stats.n_rhs)

    return run


def gaps_in_python() -> Run:
    """Runge-Kutta steps of the pair with the first stop given as a gap and a gradient in Python."""
    gradient = np.array([-1.0, 0.0])
    stop = vi.NonlinearStop(lambda q: 0.1 - q[0], lambda q: gradient, 1.0)
    return steps(lambda: pair(stops=[stop]))


def periods(acceleration: float, restitution: float, method: str = "auto") -> Run:
    """Periods of a shaken table on which a ball is dropped."""
    scene = scenes.ball(acceleration, restitution)

    def run(units: int) -> int:
        vi.simulate(scene, [scenes.DROP], [0.0], (0.0, PERIOD * units), method=method, keep="final")
        return units

    return run


def reading(read: Callable[[vi.Trajectory, Any], object]) -> Run:
    """Instants read of a motion that has been kept: one in each flight."""
    scene = pair(stops=stops(1))
    kept = vi.simulate(scene, *START, (0.0, 500 * IMPACT_EVERY), rtol=LOOSE)

    def run(units: int) -> int:
        read(kept, times(500 * IMPACT_EVERY, units))
        return units

    return run


def ledger() -> Run:
    """The energy ledger, once for a motion with so many flights."""
    scene = pair(stops=stops(1))

    @functools.cache
    def kept(units: int) -> vi.Trajectory:
        return vi.simulate(scene, *START, (0.0, units * IMPACT_EVERY), rtol=LOOSE)

    def run(units: int) -> int:
        return len(kept(units).energy.balance)

    return run


def exact() -> Group:
    """One impact of an exact flight."""

    def case(name: str, make: Make, keep: str = "final", samples: int = 0) -> Case:
        return Case(name, lambda: impacts(make, keep, samples))

    def one(**parts: Any) -> Make:
        return lambda: pair(stops=stops(1), **parts)

    return Group(
        "exact",
        "Exact flights",
        "impact",
        (
            case("one stop", one()),
            case("forcing", one(forcing=scenes.harmonic())),
            case("forcing of three harmonics", one(forcing=scenes.harmonics())),
            Case("a record, ten samples in each flight", lambda: recorded("exact"), 5_000, 500),
            Case("a swept force", swept, 2_000, 200),
            case("the stop moves", lambda: pair(stops=[scenes.moving_stop()])),
            case("constant load", one(load=[SMALL, SMALL])),
            case("proportional damping", one(damping=PROPORTIONAL)),
            case("non-proportional damping", one(damping=OTHER)),
            case("non-proportional damping and forcing", one(damping=OTHER, forcing=scenes.harmonic())),
            case("restitution below 1", lambda: pair(stops=stops(1, 1.0 - SMALL))),
            case("a second stop", lambda: pair(stops=stops(2))),
            case("a third stop", lambda: pair(stops=stops(3))),
            case("a fourth stop", lambda: pair(stops=stops(4))),
            case("a spring out of reach for the second stop", lambda: pair(stops=[*stops(1), scenes.spring_out_of_reach()])),
            case('keep="impacts"', one(), "impacts"),
            case('keep="motion"', one(), "motion"),
            case("t_eval, one time per impact", one(), "final", 1),
            case("t_eval, ten times per impact", one(), "final", 10),
        ),
    )


def stepped() -> Group:
    """One Runge-Kutta step."""

    def case(name: str, make: Make, keep: str = "final", samples: int = 0) -> Case:
        return Case(name, lambda: steps(make, keep, samples))

    return Group(
        "rk45",
        'Runge-Kutta steps, `method="rk45"`',
        "step",
        (
            case("no stop", pair),
            case("forcing", lambda: pair(forcing=scenes.harmonic())),
            case("forcing of three harmonics", lambda: pair(forcing=scenes.harmonics())),
            Case("a record, a sample in each step", lambda: recorded("rk45"), 5_000, 500),
            case("damping", lambda: pair(damping=OTHER)),
            case("a stop that is never reached", lambda: pair(stops=[vi.Stop(1, 50.0, 1.0)])),
            case("a stop", lambda: pair(stops=stops(1))),
            case("a stop that moves", lambda: pair(stops=[scenes.moving_stop()])),
            case("a stop and a second one", lambda: pair(stops=stops(2))),
            case("a stop, a second and a third one", lambda: pair(stops=stops(3))),
            case("four stops", lambda: pair(stops=stops(4))),
            case('keep="impacts"', pair, "impacts"),
            case('keep="motion"', pair, "motion"),
            case("t_eval, one time per step", pair, "final", 1),
        ),
    )


def series() -> Group:
    """One step along a Taylor series."""

    def case(name: str, make: Make, keep: str = "final") -> Case:
        return Case(name, lambda: steps(make, keep, 0, "taylor"), 20_000)

    def walls(count: int) -> list[vi.Wall]:
        return [vi.Wall(1, 0.1, 1.0), vi.Wall(1, -5.0, 1.0, side="left"), vi.Wall(0, 5.0, 1.0)][:count]

    small = vi.BaseMotion(SMALL, scenes.FREQUENCY)
    return Group(
        "taylor",
        'Taylor series of the double pendulum, `method="taylor"`',
        "step",
        (
            case("no wall", pendulum),
            case("base motion", lambda: pendulum(forcing=small)),
            case("joint dampers", lambda: pendulum((SMALL, SMALL))),
            case("a wall that is never reached", lambda: pendulum(walls=walls(3)[2:])),
            case("a wall", lambda: pendulum(walls=walls(1))),
            case("a wall and a second one", lambda: pendulum(walls=walls(2))),
            case("three walls", lambda: pendulum(walls=walls(3))),
            case('keep="motion"', pendulum, "motion"),
        ),
    )


def callables() -> Group:
    """One evaluation of the right-hand side, by who evaluates it."""
    own = Case("the library's own `LinearSystem`", lambda: evaluations(lambda: pair().system), 60_000, 3_000)
    slow = [
        Case(name, functools.partial(evaluations, make), 6_000 if name.startswith("Python") else 60_000, 600)
        for name, make in available().items()
    ]
    return Group("callable", "The equations of motion as a user's function", "evaluation", (own, *slow))


def gaps() -> Group:
    """One Runge-Kutta step past a stop, by who knows the gap."""
    return Group(
        "gap",
        "A gap as a user's function",
        "step",
        (
            Case("a `Stop`", lambda: steps(lambda: pair(stops=stops(1)))),
            Case("a `NonlinearStop` in Python", gaps_in_python, 1_000, 200),
        ),
    )


def contact() -> Group:
    """One period of a ball on a shaken table, with and without chatter."""
    return Group(
        "chatter",
        "Chatter and lasting contact: a ball on a shaken table",
        "period",
        (
            Case("one impact a period", lambda: periods(*scenes.BOUNCING), 20_000),
            Case("impacts that accumulate, lasting contact, release", lambda: periods(*scenes.CHATTERING), 2_000, 100),
            Case('the same, `method="rk45"`', lambda: periods(*scenes.CHATTERING, "rk45"), 2_000, 100),
        ),
    )


def springs() -> Group:
    """One contact with the first stop of the pair, by its law."""

    def case(name: str, law: Any, method: str = "exact") -> Case:
        return Case(name, lambda: pressed(law, method), 5_000, 500)

    pulling = vi.Spring(100.0, scenes.DASHPOT, release="gap")
    return Group(
        "law",
        "Laws of contact",
        "contact",
        (
            case("rigid", vi.Newton(1.0)),
            case("a spring", vi.Spring(100.0)),
            case('a dashpot beside it, `release="gap"`', pulling),
            case('`release="clipped"`', vi.Spring(100.0, scenes.DASHPOT, release="clipped")),
            case('`release="force"`', vi.Spring(100.0, scenes.DASHPOT, release="force")),
            case("a preload", vi.Spring(100.0, preload=0.1)),
            case('`method="rk45"`', pulling, "rk45"),
        ),
    )


def readings() -> Group:
    """One instant read of a motion that has been kept."""
    return Group(
        "reading",
        'Reading a motion kept by `keep="motion"`',
        "instant",
        (
            Case("position(t)", lambda: reading(lambda kept, t: kept.position(t))),
            Case("velocity(t)", lambda: reading(lambda kept, t: kept.velocity(t))),
            Case("energy", ledger, 2_000, 200),
        ),
    )


@functools.cache
def groups() -> tuple[Group, ...]:
    """Every group."""
    return exact(), stepped(), series(), callables(), gaps(), contact(), springs(), readings()
