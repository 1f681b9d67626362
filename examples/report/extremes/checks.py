"""The references checked by a second method: how far two ways to fifty digits are apart."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import astuple

from mpmath import mp, mpf

from report.extremes.bodies import flown
from report.extremes.exponential import system
from report.extremes.extrapolated import extrapolated
from report.extremes.giving_way import elastic, given_back
from report.extremes.modes import upside_down
from report.extremes.motion import Motion
from report.extremes.oscillator import oscillator
from report.extremes.pendulums import double_pendulum, swings
from report.extremes.periodic import driven_state
from report.extremes.rest import ball
from report.extremes.restitution import between_walls
from report.extremes.starts import preloaded

START = {"q": 0.7, "v": -0.4, "force": 0.8, "frequency": 1.7, "phase": 0.3, "length": 5.0}
MOTIONS = {
    "no damping": Motion(0.0, 1.0, **START),
    "critical": Motion(2.0, 1.0, **START),
    "critical and 1e-12 more": Motion(2 + 2e-12, 1.0, load=0.3, **START),
    "overdamped, zeta = 1e3": Motion(2e3, 1.0, **START),
    "resonance": Motion(0.0, 1.0, **(START | {"frequency": 1.0})),
    "rigid body under a load": Motion(load=0.3, **START),
    "negative stiffness": Motion(0.1, -1.0, **START),
}


def oscillators() -> Iterator[tuple[str, mpf]]:
    """Closed form of an oscillator and the matrix exponential."""
    for name, m in MOTIONS.items():
        exact = [mpf(x) for x in astuple(m)]
        closed = [part[0] for part in oscillator(*exact)]
        c, k, load, force, w, phase, q, v, _, length = exact
        other = [part[0] for part in system(1, [mpf(1), c, k, load, force, w, phase, q, v, length])]
        yield f"oscillator, {name}: closed form, matrix exponential", apart(closed, other)


def apart(one: list[mpf], other: list[mpf]) -> mpf:
    """Largest difference over the largest entry."""
    return max(abs(x - y) for x, y in zip(one, other, strict=True)) / max(map(abs, one))


def orbit() -> tuple[str, mpf]:
    """The state after the impact of an orbit comes back to itself: by the closed form of the flight."""
    c, k, force, w, e, clearance = (mpf(x) for x in (0.2, 1.0, 1.0, 1.7, 0.7, 0.1))
    q, v, cosine, sine = driven_state(c, k, force, w, e, clearance)
    phase = mp.atan2(sine, cosine)
    (end,), (speed,) = oscillator(c, k, mpf(0), force, w, phase, q, v, mpf(0), 2 * mp.pi / w)
    return "orbit of one impact: matrix solve, one period of its flight", apart([q, v, clearance], [end, -e * speed, q])


def separatrix() -> tuple[str, mpf]:
    """The link upside down: its series and 4 atan(e^t)."""
    found = upside_down(4 * mp.atan(mp.exp(-3)), 2 * mp.sech(-3), mpf(5))
    expected = [4 * mp.atan(mp.exp(2)), 2 * mp.sech(2)]
    return "link upside down: series, closed form on the separatrix", apart(expected, [part[0] for part in found])


def last_bounce() -> tuple[str, mpf]:
    """A dropped ball: the sum of its flights, one by one."""
    e = mpf(0.5)
    flights, fall = mpf(0), mp.sqrt(2)
    for k in range(400):
        flights += 2 * fall * e ** (k + 1)
    return "ball to rest: closed form, sum of flights", abs(ball(mpf(1), e, mpf(1))[0][0] / (fall + flights) - 1)


def bounces() -> tuple[str, mpf]:
    """A body between stops: closed form of its impacts, and flights from stop to stop."""
    e, v, c = mpf(0.9), mpf(2), mpf(0.5)
    times, speeds = between_walls(9)(c, e, v)
    end = times[-1] + mpf(0.1)
    place = c - e * speeds[-1] * mpf(0.1)  # the ninth impact is on the upper stop
    # Mirrored copies of the body fly towards upper stops alone: one impact of each flight.
    q = -c
    (x,), _ = flown(mp.eye(1), [q + 0], [speeds[-1]], [c], [e], end - times[-2])
    return "body between stops: closed form, flown from stop to stop", abs(x / place - 1)


def pressed() -> tuple[str, mpf]:
    """A flight from a preloaded stop ends on it at the speed that it began with."""
    c, v = mpf(0.5), mpf(0.3)
    (length,), _ = preloaded(1)(-c, mpf(1), v)
    still = (mpf(0),) * 2
    (q,), (w,) = oscillator(mpf(0), mpf(1), *still, mpf(1), mpf(0), -c, -v, mpf(0), length)
    return "preloaded stop: time of a flight, closed form of the motion", apart([-c, v], [q, w])


def at_rest() -> tuple[str, mpf]:
    """The held body's neighbour of the release without slope: its cos 3 t is the motion of a mode of frequency 3."""
    y, time = mpf(-0.5), mp.pi / 2
    (q,), (v,) = oscillator(mpf(0), mpf(9), mpf(0), mpf(0), mpf(1), mpf(0), y, mpf(0), mpf(0), time)
    return "release without slope: state of the neighbour, closed form of a mode", apart([mpf(0), 3 * y], [q, v])


def on_springs() -> Iterator[tuple[str, mpf]]:
    """Contacts with a preload, and with dashpots that pull or do not, by the closed form of the motion while pressed."""
    still = (mpf(0),) * 3
    c, k, preload, u = mpf(0.5), mpf(40), mpf(0.7), mp.sqrt(0.75)
    (start,), (end,), _ = elastic(1)(c, k, preload, mpf(1))
    found = oscillator(mpf(0), 1 + k, k * c - preload, *still, c, u, mpf(0), end - start)
    yield "preloaded spring: duration of a contact, closed form of the motion", apart([c, -u], [part[0] for part in found])
    for zeta, is_pulling in ((mpf(0.2), True), (mpf(0.2), False), (mpf(1), False)):
        duration, share, _ = given_back(zeta, mp.sqrt(k), is_pulling)
        damping = 2 * zeta * mp.sqrt(k)
        left = mpf(0) if is_pulling else damping * share / k
        found = oscillator(damping, k, mpf(0), *still, mpf(0), mpf(1), mpf(0), duration)
        name = (
            f"dashpot that {'pulls' if is_pulling else 'does not pull'}, zeta = {float(zeta):g}: share, closed form of the motion"
        )
        yield name, apart([left, -share], [part[0] for part in found])


def two_links() -> tuple[str, mpf]:
    """A double pendulum by steps of two lengths."""
    inputs = [mpf(x) for x in (1e6, 1.0, 0.9, -0.7, 0.1, 0.2, 0.03)]
    one, other = ([x for part in double_pendulum(steps)(*inputs) for x in part] for steps in (14, 21))
    return "double pendulum, mass ratio 1e6: 14 steps, 21 steps of extrapolation", apart(one, other)


def swing() -> tuple[str, mpf]:
    """A link from rest, half a period later, by extrapolation and by the elliptic integral."""
    (quarter, *_), (speed, *_) = swings(1)(mpf(1), mpf(1))
    q, v = extrapolated(lambda x: [x[1], -mp.sin(x[0])], [mpf(1), mpf(0)], quarter, 10)
    return "link: elliptic integral, extrapolation", apart([mpf(0), speed], [q, -v])


def checks() -> list[tuple[str, mpf]]:
    """Every check: what is compared and how far it is apart."""
    with mp.workdps(50):
        return [
            *oscillators(),
            orbit(),
            separatrix(),
            last_bounce(),
            bounces(),
            pressed(),
            at_rest(),
            *on_springs(),
            swing(),
            two_links(),
        ]
