"""How the references are made: each motion in many digits, its flights again a second way, both stored with their difference.

Run, in the folder of the examples, ``python -m report.contest.recipe [name ...]``; all of them take twenty minutes.
"""

from __future__ import annotations

import sys

import numpy as np
from mpmath import mp

import vibroimpact as vi

from . import collocation, extrapolation, lasting, linear_flow, many_digits, switches, taylor_flow
from .equations import matrix_of
from .motion import motion
from .problems import Compliant, Ensemble, problems
from .reference import FOLDER, fingerprint

DIGITS = 25  # stored
CHECKED = 10  # of the trajectories of an ensemble each so many-th is checked the second way


def largest(flights, n: int) -> list[float]:
    """Largest position and velocity at the ends of the flights, one for each entry of the state."""
    states = np.array([[float(each) for each in state] for flight in flights for state in (flight.state, flight.before)])
    q, v = np.abs(states[:, :n]).max(), np.abs(states[:, n:]).max()
    return [q] * n + [v] * n


def is_held(system: vi.LinearSystem) -> bool:
    """Whether springs hold every mass: without them a constant force has no part in the eigenvectors of the state matrix."""
    return int(np.linalg.matrix_rank(matrix_of(system.stiffness, float))) == system.n_dof


def followed(problem):
    """Flights of a problem in many digits, and the name of the way."""
    if problem.name == "ball":
        return motion(problem, taylor_flow.TaylorFlow(problem)), "Taylor series of the parabola"
    if isinstance(problem, Compliant):
        return switches.motion(problem), "eigenvectors of the state matrix of each set of pressed stops"
    if isinstance(problem.scene.system, vi.LinearSystem) and is_held(problem.scene.system):
        return motion(problem, linear_flow.LinearFlow(problem)), "eigenvectors of the state matrix"
    return motion(problem, taylor_flow.TaylorFlow(problem)), "Taylor series of order 44"


def checked(problem, flights):
    """Largest difference of a second way from the flights, and its name."""
    if problem.name == "ball":
        return by_ball(problem, flights), "the closed form t_k = sqrt(2 h/g) (1 + 2 (e + ... + e^k))"
    if isinstance(problem.scene.system, vi.LinearSystem):
        way = "the matrix exponential of each flight"
        if any(flight.held >= 0 for flight in flights):
            way += " and each contact that lasts, limits of impacts from those taken one impact earlier"
        return lasting.by_exponentials(problem, flights), way
    with mp.workdps(40):
        if problem.is_stiff:
            return collocation.by_collocation(problem, flights), "collocation at Radau's points on each flight"
        return extrapolation.by_extrapolation(problem, flights), "extrapolated midpoint steps of each flight"


def make(name: str) -> None:
    """Compute one reference, check it, store it."""
    mp.dps = many_digits.DIGITS
    problem = next(each for each in problems() if each.name == name)
    is_many = isinstance(problem, Ensemble)
    members = [problem.member(i) for i in problem.sample] if is_many else [problem]
    motions, ways = zip(*map(followed, members), strict=True)
    found = [checked(member, flights) for member, flights in zip(members[::CHECKED], motions[::CHECKED], strict=True)]
    difference, check = max(found)
    times = [[flight.end for flight in flights if flight.is_hit][: problem.first] for flights in motions]
    scale = np.max([largest(flights, problem.scene.n_dof) for flights in motions], axis=0)
    which = f"ends of flights{f' of {len(found)} of {len(members)} trajectories' if is_many else ''}"
    lines = [
        f"# {problem.title}: {ways[0]}, {many_digits.DIGITS} digits;",
        f"# {which} differ by at most {mp.nstr(difference, 2)} from {check}.",
        "kind,value",
        f"problem,{fingerprint(problem)}",
        *(f"impact,{mp.nstr(each, DIGITS)}" for each in ([] if is_many else times[0])),
        *(f"count,{len(each)}" for each in (times if is_many else [])),
        *(f"state,{mp.nstr(each, DIGITS)}" for flights in motions for each in flights[-1].before),
        *(f"scale,{float(each)!r}" for each in scale),
    ]
    FOLDER.mkdir(exist_ok=True)
    (FOLDER / f"{name}.csv").write_text("\n".join(lines) + "\n")
    print(name, sum(map(len, times)), "impacts,", mp.nstr(difference, 2), flush=True)


def by_ball(problem, flights):
    """Largest difference of the impact times of a dropped ball from the closed form."""
    g, e = -mp.mpf(problem.scene.system.load[0]), mp.mpf(problem.scene.stops[0].restitution)
    first = mp.sqrt(2 * mp.mpf(problem.q0[0]) / g)
    times = [flight.end for flight in flights if flight.stop >= 0]
    return max(abs(t - first * (1 + 2 * (e - e ** (k + 1)) / (1 - e))) for k, t in enumerate(times))


if __name__ == "__main__":
    for wanted in sys.argv[1:] or [problem.name for problem in problems()]:
        make(wanted)
