"""References of the problems: made in many digits, checked a second way, stored beside this file with their recipe.

Run ``python examples/report/reference.py [name ...]`` to make them again. The report only reads them.
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


@dataclass(frozen=True)
class Reference:
    """The right answer: times of impact, final state, and the motion's own scale, one number for each entry of the state."""

    times: np.ndarray
    state: np.ndarray
    scale: np.ndarray
    recipe: str


def load(name: str) -> Reference:
    """Read a stored reference."""
    text = (FOLDER / f"{name}.csv").read_text()
    recipe = " ".join(line[2:] for line in text.splitlines() if line.startswith("# "))
    rows = list(csv.reader(io.StringIO("\n".join(line for line in text.splitlines() if not line.startswith("# ")))))
    found: dict[str, list[float]] = {"impact": [], "state": [], "scale": []}
    for kind, value in rows[1:]:
        found[kind].append(float(value))
    return Reference(*(np.array(found[kind]) for kind in ("impact", "state", "scale")), recipe)


def largest(flights, n: int) -> list[float]:
    """Largest position and velocity at the ends of the flights, one for each entry of the state."""
    states = np.array([[float(each) for each in state] for flight in flights for state in (flight.state, flight.before)])
    q, v = np.abs(states[:, :n]).max(), np.abs(states[:, n:]).max()
    return [q] * n + [v] * n


def make(name: str) -> None:
    """Compute one reference, check it, store it."""
    from mpmath import mp

    from report import extrapolation, linear_flow, many_digits, problems, taylor_flow

    problem = next(each for each in problems.problems() if each.name == name)
    mp.dps = many_digits.DIGITS
    if name == "ball":
        method, check = "Taylor series of the parabola, exact", "the closed form t_k = sqrt(2 h/g) (1 + 2 (e + ... + e^k))"
        flights = many_digits.motion(problem, taylor_flow.TaylorFlow(problem))
        difference = by_ball(problem, flights)
    elif hasattr(problem.scene.system, "mass"):
        method, check = "eigenvectors of the state matrix", "the matrix exponential of each flight"
        flights = many_digits.motion(problem, linear_flow.LinearFlow(problem))
        difference = linear_flow.by_exponentials(problem, flights)
    else:
        method, check = "Taylor series of order 44", "extrapolated midpoint steps of each flight"
        flights = many_digits.motion(problem, taylor_flow.TaylorFlow(problem))
        mp.dps = 40
        difference = extrapolation.by_extrapolation(problem, flights)
        mp.dps = many_digits.DIGITS
    times = [flight.end for flight in flights if flight.stop >= 0][: problem.first]
    lines = [
        f"# {problem.title}: {method}, {many_digits.DIGITS} digits;",
        f"# ends of flights differ by at most {mp.nstr(difference, 2)} from {check}.",
        "kind,value",
        *(f"impact,{mp.nstr(each, DIGITS)}" for each in times),
        *(f"state,{mp.nstr(each, DIGITS)}" for each in flights[-1].before),
        *(f"scale,{each!r}" for each in map(float, largest(flights, problem.scene.n_dof))),
    ]
    FOLDER.mkdir(exist_ok=True)
    (FOLDER / f"{name}.csv").write_text("\n".join(lines) + "\n")
    print(name, len(times), "impacts,", mp.nstr(difference, 2), flush=True)


def by_ball(problem, flights):
    """Largest difference of the impact times of a dropped ball from the closed form."""
    from mpmath import mp

    g, e = -mp.mpf(problem.scene.system.load[0]), mp.mpf(problem.scene.stops[0].restitution)
    first = mp.sqrt(2 * mp.mpf(problem.q0[0]) / g)
    times = [flight.end for flight in flights if flight.stop >= 0]
    return max(abs(t - first * (1 + 2 * (e - e ** (k + 1)) / (1 - e))) for k, t in enumerate(times))


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))
    from report.problems import problems as every

    for wanted in sys.argv[1:] or [problem.name for problem in every()]:
        make(wanted)
