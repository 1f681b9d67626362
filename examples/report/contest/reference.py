"""References of the problems: made in many digits, checked a second way, stored beside this file with their recipe.

Run ``python examples/report/contest/reference.py [name ...]`` to make them again. The report only reads them.
"""

from __future__ import annotations

import csv
import io
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).with_name("references")
DIGITS = 25  # stored
CHECKED = 10  # of the trajectories of an ensemble each so many-th is checked the second way


@dataclass(frozen=True)
class Reference:
    """The right answer: times of impact, final state, and the motion's own scale, one number for each entry of the state.

    Of an ensemble: no times, but the number of impacts of each trajectory of the sample; their states are rows.
    """

    times: np.ndarray
    state: np.ndarray
    scale: np.ndarray
    counts: np.ndarray
    recipe: str


def load(name: str) -> Reference:
    """Read a stored reference."""
    text = (FOLDER / f"{name}.csv").read_text()
    recipe = " ".join(line[2:] for line in text.splitlines() if line.startswith("# "))
    rows = list(csv.reader(io.StringIO("\n".join(line for line in text.splitlines() if not line.startswith("# ")))))
    found: dict[str, list[float]] = {"impact": [], "state": [], "scale": [], "count": []}
    for kind, value in rows[1:]:
        found[kind].append(float(value))
    times, state, scale, counts = (np.array(found[kind]) for kind in found)
    state = state.reshape(len(counts), -1) if len(counts) else state
    return Reference(times, state, scale, counts.astype(int), recipe.partition(": ")[2])


def largest(flights, n: int) -> list[float]:
    """Largest position and velocity at the ends of the flights, one for each entry of the state."""
    states = np.array([[float(each) for each in state] for flight in flights for state in (flight.state, flight.before)])
    q, v = np.abs(states[:, :n]).max(), np.abs(states[:, n:]).max()
    return [q] * n + [v] * n


def followed(problem):
    """Flights of a problem in many digits, and the name of the way."""
    from report.contest import linear_flow, many_digits, taylor_flow

    if problem.name == "ball":
        return many_digits.motion(problem, taylor_flow.TaylorFlow(problem)), "Taylor series of the parabola"
    if hasattr(problem.scene.system, "mass"):
        return many_digits.motion(problem, linear_flow.LinearFlow(problem)), "eigenvectors of the state matrix"
    return many_digits.motion(problem, taylor_flow.TaylorFlow(problem)), "Taylor series of order 44"


def checked(problem, flights):
    """Largest difference of a second way from the flights, and its name."""
    from mpmath import mp

    from report.contest import extrapolation, linear_flow

    if problem.name == "ball":
        return by_ball(problem, flights), "the closed form t_k = sqrt(2 h/g) (1 + 2 (e + ... + e^k))"
    if hasattr(problem.scene.system, "mass"):
        return linear_flow.by_exponentials(problem, flights), "the matrix exponential of each flight"
    with mp.workdps(40):
        return extrapolation.by_extrapolation(problem, flights), "extrapolated midpoint steps of each flight"


def make(name: str) -> None:
    """Compute one reference, check it, store it."""
    from mpmath import mp

    from report.contest import many_digits, problems

    mp.dps = many_digits.DIGITS
    problem = next(each for each in problems.problems() if each.name == name)
    is_many = isinstance(problem, problems.Ensemble)
    members = [problem.member(i) for i in problem.sample] if is_many else [problem]
    motions, ways = zip(*map(followed, members), strict=True)
    found = [checked(member, flights) for member, flights in zip(members[::CHECKED], motions[::CHECKED], strict=True)]
    difference, check = max(found)
    times = [[flight.end for flight in flights if flight.stop >= 0][: problem.first] for flights in motions]
    scale = np.max([largest(flights, problem.scene.n_dof) for flights in motions], axis=0)
    which = f"ends of flights{f' of {len(found)} of {len(members)} trajectories' if is_many else ''}"
    lines = [
        f"# {problem.title}: {ways[0]}, {many_digits.DIGITS} digits;",
        f"# {which} differ by at most {mp.nstr(difference, 2)} from {check}.",
        "kind,value",
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
    from mpmath import mp

    g, e = -mp.mpf(problem.scene.system.load[0]), mp.mpf(problem.scene.stops[0].restitution)
    first = mp.sqrt(2 * mp.mpf(problem.q0[0]) / g)
    times = [flight.end for flight in flights if flight.stop >= 0]
    return max(abs(t - first * (1 + 2 * (e - e ** (k + 1)) / (1 - e))) for k, t in enumerate(times))


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[2]))
    from report.contest.problems import problems as every

    for wanted in sys.argv[1:] or [problem.name for problem in every()]:
        make(wanted)
