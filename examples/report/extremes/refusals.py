"""Bad input: each is a ValueError whose message names the argument and the rule."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

import vibroimpact as vi
from report.extremes.finding import Finding, refused
from report.extremes.registry import case

NAN, INF = float("nan"), float("inf")
EYE, TWO = np.eye(2), [1.0, 1.0]
SCENE = vi.Scene(vi.LinearSystem(1, 0.1, 1), vi.Harmonic(1, 2.8), vi.Stop(0, 0.5, 0.8))
PAIR = vi.paper_scene(kind=3)

# row: what is given, the argument that the message must name, a word of the rule, the call
BAD: dict[str, list[tuple[str, str, str, Callable[[], object]]]] = {
    "NaN": [
        ("mass with NaN", "mass", "finite", partial(vi.LinearSystem, [1, NAN], TWO, TWO)),
        ("load with NaN", "load", "finite", partial(vi.LinearSystem, TWO, TWO, TWO, load=[1, NAN])),
        ("length ratio NaN", "length_ratio", "finite", partial(vi.DoublePendulum, 1, NAN)),
        ("amplitude NaN", "amplitude", "finite", partial(vi.Harmonic, NAN, 1)),
        ("normal with NaN", "normal", "finite", partial(vi.Stop, [1, NAN], 0, 0.5)),
        ("clearance NaN", "clearance", "finite", partial(vi.Stop, 0, NAN, 0.5)),
        ("start NaN", "q0", "finite", partial(vi.simulate, SCENE, NAN, 0, (0, 1))),
        ("span NaN", "t_span", "finite", partial(vi.simulate, SCENE, 0, 0, (NAN, 1))),
        ("tolerance NaN", "rtol", "finite", partial(vi.simulate, SCENE, 0, 0, (0, 1), rtol=NAN)),
        ("phase NaN", "phase", "finite", partial(vi.periodic_orbits, PAIR, [1], phase=NAN)),
        ("recovery matrix NaN", "matrix", "finite", partial(vi.audit_recovery, NAN * np.eye(4), EYE, [0])),
    ],
    "infinities": [
        ("damping with an infinity", "damping", "finite", partial(vi.LinearSystem, TWO, [0, INF], TWO)),
        ("stiffness minus infinity", "stiffness", "finite", partial(vi.LinearSystem, 1, 0, -INF)),
        ("influence with an infinity", "influence", "finite", partial(vi.LinearSystem, TWO, TWO, TWO, influence=[1, INF])),
        ("frequency infinite", "frequency", "finite", partial(vi.BaseMotion, 1, INF)),
        ("reaction with an infinity", "reaction", "finite", partial(vi.Stop, 0, 0, 0.5, reaction=[1, INF])),
        ("start infinitely fast", "v0", "finite", partial(vi.simulate, SCENE, 0, INF, (0, 1))),
        ("span without end", "t_span", "finite", partial(vi.simulate, SCENE, 0, 0, (0, INF))),
    ],
    "wrong shapes": [
        ("damping 3 x 3 for mass 2 x 2", "damping", "(2, 2)", partial(vi.LinearSystem, EYE, np.eye(3), EYE)),
        ("mass 2 x 3", "mass", "needed", partial(vi.LinearSystem, np.ones((2, 3)), TWO, TWO)),
        ("no mass", "mass", "needed", partial(vi.LinearSystem, [], [], [])),
        ("load of one entry for two", "load", "(2,)", partial(vi.LinearSystem, TWO, TWO, TWO, load=[1])),
        ("one length for two masses", "lengths", "(2,)", partial(vi.PendulumChain, [1, 2], [1])),
        ("start of two entries for one", "q0", "(1,)", partial(vi.simulate, SCENE, [0.1, 0], 0, (0, 1))),
        ("three clearances for two stops", "clearance", "(2,)", partial(PAIR.replace, clearance=[1, 2, 3])),
        ("three speeds for gaps of two", "q", "2)", partial(PAIR.gaps, [1, 2, 3])),
        ("recovery matrix 3 x 3", "matrix", "(4, 4)", partial(vi.audit_recovery, np.eye(3), EYE, [0])),
    ],
    "singular mass": [
        ("a mass of zero", "mass", "positive definite", partial(vi.LinearSystem, [1, 0], [0, 0], TWO)),
        ("[[1, 1], [1, 1]]", "mass", "positive definite", partial(vi.LinearSystem, [[1, 1], [1, 1]], [0, 0], TWO)),
        ("a link without mass", "masses", "greater than zero", partial(vi.PendulumChain, [1, 0], TWO)),
        ("mass ratio zero", "mass_ratio", "greater than zero", partial(vi.DoublePendulum, 0, 1)),
    ],
    "indefinite mass": [
        ("[[1, 2], [2, 1]]", "mass", "positive definite", partial(vi.LinearSystem, [[1, 2], [2, 1]], [0, 0], TWO)),
        ("a mass of -1", "mass", "positive definite", partial(vi.LinearSystem, -1, 0, 0)),
        ("a link of mass -2", "masses", "greater than zero", partial(vi.PendulumChain, [1, -2], TWO)),
        ("mass ratio -1", "mass_ratio", "greater than zero", partial(vi.paper_system, -1, 1, 0.1)),
    ],
    "zero normal": [
        ("[0, 0]", "normal", "zero", partial(vi.Stop, [0, 0], 0, 0.5)),
        ("[0, 0] to audit", "normals", "zero", partial(vi.audit_recovery, np.eye(4), EYE, [[0, 0]])),
    ],
    "n . b <= 0": [
        (
            "n . b = 0",
            "reaction",
            "n.b > 0",
            lambda: vi.Scene(vi.LinearSystem(TWO, TWO, TWO), None, vi.Stop([1, 0], 0, 0.5, reaction=[0, 1])),
        ),
        (
            "n . b = -1",
            "reaction",
            "n.b > 0",
            lambda: vi.Scene(vi.LinearSystem(TWO, TWO, TWO), None, vi.Stop([1, 0], 0, 0.5, reaction=[-1, 0])),
        ),
    ],
    "e outside [0, 1]": [
        ("1 + 1e-12", "restitution", "[0, 1]", partial(vi.Stop, 0, 0, 1 + 1e-12)),
        ("-1e-12", "restitution", "[0, 1]", partial(vi.Stop, 0, 0, -1e-12)),
        ("NaN", "restitution", "[0, 1]", partial(vi.Stop, 0, 0, NAN)),
        ("2 at a wall", "restitution", "[0, 1]", partial(vi.Wall, 0, 0, 2)),
        ("2 by replace", "restitution", "[0, 1]", partial(PAIR.replace, restitution=2)),
    ],
}


def tried(row: str) -> Iterator[Finding]:
    """Every bad input of a row."""
    for quantity, argument, rule, call in BAD[row]:
        yield refused(quantity, call, argument, rule)


for name in BAD:
    case(name)(partial(tried, name))
