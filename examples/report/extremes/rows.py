"""The rows: every extreme or stiff situation that must hold, one name each, in the order of the page."""

from __future__ import annotations

STIFF = "springs 1e4 to 1e12 times as stiff as the system"
PRELOADED = "a preload, and rest at its seat"
NEARLY_TOGETHER = "two stops hit within 1e-12 of each other"

GROUPS: dict[str, tuple[str, ...]] = {
    "Damping and stiffness": (
        "zeta = 0",
        "zeta_j = 1 exactly",
        "zeta_j = 1 +- 1e-12",
        "zeta_j = 1e3 (overdamped)",
        "stiffness ratio 1e8",
        "mass ratio 1e-6",
        "mass ratio 1e6",
        "rigid-body mode",
        "damped rigid body",
        "a load on a rigid-body mode",
        "negative stiffness (inverted pendulum)",
        "negative damping",
        "gyroscopic damping",
        "repeated natural frequencies",
        "defective state matrix",
        "10^3 modes",
    ),
    "Forcing": (
        "w = w_j exactly, undamped",
        "w off w_j by 1e-12",
        "forcing frequency 1e-6",
        "forcing frequency 1e6",
        "zero forcing amplitude",
        "zero frequency",
        "a start at t = 1e9 periods",
        "a blow of 1e-9 s",
        "a record of straight lines",
        "a force swept over 1e5 turns",
        "a stop that shakes 1e4 times while a body comes near",
    ),
    "Restitution": (
        "e = 0",
        "e = 1",
        "e = 1e-12",
        "e = 1 - 1e-12",
    ),
    "Clearances and starts": (
        "clearance 0",
        "negative clearance (preloaded stop)",
        "start in contact",
        "start in penetration",
        "start exactly grazing",
        "equilibrium exactly on a wall with no force",
    ),
    "Speeds and long runs": (
        "impact speeds 1e-12",
        "speeds so high that two impacts fall in one Runge-Kutta step",
        "stop on both sides closer than the motion",
        "10^6 impacts in one run without drift",
    ),
    "Several stops": (
        NEARLY_TOGETHER,
        "the same stop given twice",
        "a stop both sides at once with no room (jam)",
        "three stops on two coordinates (dependent normals)",
    ),
    "Chatter and lasting contact": (
        "bouncing ball to rest",
        "stuck for ever",
        "stuck in several stops",
        "released by another stop's impact",
        "released with L' = 0 too",
    ),
    "Stops that give way": (
        STIFF,
        "a spring 1e-6 of the system's",
        "critically damped while pressed",
        PRELOADED,
        "a touch of 1e-12 of the amplitude",
    ),
    "Periodic orbits": (
        "T over 1e4 free periods",
        "T under 1e-3 of a free period",
        "orbit degenerate with e = 1 undamped (family)",
        "fold |d| = |alpha| +- 1e-12",
        "orbit that grazes a second stop",
        "orbit that is a shorter one repeated",
        "kind 1 with unequal clearances (none, with the mismatch)",
    ),
    "Bad input": (
        "NaN",
        "infinities",
        "wrong shapes",
        "singular mass",
        "indefinite mass",
        "zero normal",
        "n . b <= 0",
        "e outside [0, 1]",
    ),
}

ROWS: tuple[str, ...] = tuple(row for rows in GROUPS.values() for row in rows)
