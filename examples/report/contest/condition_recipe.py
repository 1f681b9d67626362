"""How the conditions are made: differences of motions in many digits, that the references' own code follows.

Run, in the folder of the examples, ``python -m report.contest.condition_recipe [name ...]``; all take half an hour.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from mpmath import mp

import vibroimpact as vi

from . import many_digits, taylor_flow
from .condition import TABLE, Condition, stored
from .problems import Ensemble, Problem, problems
from .recipe import followed
from .reference import fingerprint, load

STEP = 2.0**-40  # of the scale, or of an entry: far below every depth and gap of the problems, far above the references' errors
SERIES = (160, 26, 26)  # bits, order and digits of Taylor series: changes of 2^-40 need fewer than the references


@dataclass(frozen=True)
class Answer:
    """Final state and times of impact, in many digits."""

    state: Any
    times: list[Any]

    @classmethod
    def to(cls, problem: Problem) -> Answer:
        """Follow a problem."""
        flights, _ = followed(problem)
        return cls(flights[-1].before, [flight.end for flight in flights if flight.is_hit][: problem.first])


def growth(changed: Answer, answer: Answer, scale: np.ndarray, step: float) -> tuple[np.ndarray, float]:
    """Changes of the final state and of the times of impact over a relative step."""
    own_time = scale[0] / scale[-1]
    state = [float(a - b) for a, b in zip(changed.state, answer.state, strict=True)]
    times = [float(a - b) for a, b in zip(changed.times, answer.times, strict=True)]
    return np.abs(state) / scale / step, float(np.abs(times).max(initial=0.0)) / own_time / step


def other_starts(problem: Problem, scale: np.ndarray) -> Iterator[Problem]:
    """The problem with one entry of its start changed, each in turn."""
    n = problem.scene.n_dof
    for i, size in enumerate(scale):
        start = problem.start
        start[i] += STEP * size
        yield replace(problem, q0=tuple(start[:n].tolist()), v0=tuple(start[n:].tolist()))


def other_entries(problem: Problem) -> Iterator[Problem]:
    """The problem with one entry of a matrix changed, and its mirror image with it, each in turn."""
    system = problem.scene.system
    matrices = {name: np.array(getattr(system, name)) for name in ("mass", "damping", "stiffness")}
    given = {"load": system.load, "influence": system.influence}
    for name, matrix in matrices.items():
        for index in zip(*np.nonzero(np.triu(matrix) if matrix.ndim == 2 else matrix), strict=True):
            other = matrix.copy()
            other[index] *= 1.0 + STEP
            other[index[::-1]] = other[index]
            changed = vi.LinearSystem(**(matrices | {name: other}), **given)
            yield replace(problem, scene=problem.scene.replace(system=changed))


def of_one(problem: Problem, scale: np.ndarray, with_entries: bool) -> Condition:
    """The condition of one motion."""
    answer = Answer.to(problem)
    found = [growth(Answer.to(other), answer, scale, STEP) for other in other_starts(problem, scale)]
    entries = None
    if with_entries:
        entries = float(sum(growth(Answer.to(other), answer, scale, STEP)[0] for other in other_entries(problem)).max())
    return Condition(max(float(state.max()) for state, _ in found), max(times for _, times in found), entries)


def condition(problem: Problem) -> Condition:
    """The condition of a problem, by references alone."""
    scale = load(problem).scale
    if isinstance(problem, Ensemble):
        members = [of_one(problem.member(i), scale, with_entries=False) for i in problem.sample]
        return Condition(max(each.state for each in members), max(each.times for each in members), None)
    return of_one(problem, scale, with_entries=isinstance(problem.scene.system, vi.LinearSystem))


def make(problem: Problem) -> None:
    """Compute one condition and put it into the table."""
    found = asdict(condition(problem))
    rows = stored()
    text = {name: "" if value is None else f"{value:.6g}" for name, value in found.items()}
    rows[problem.name] = {"problem": problem.name, "fingerprint": fingerprint(problem), **text}
    with TABLE.open("w", newline="") as file:
        writer = csv.DictWriter(file, ["problem", "fingerprint", "state", "times", "entries"], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows[each.name] for each in problems() if each.name in rows)
    print(problem.name, *text.values(), flush=True)


if __name__ == "__main__":
    mp.dps = many_digits.DIGITS
    taylor_flow.BITS, taylor_flow.ORDER, taylor_flow.ACCURACY = SERIES  # a third of the time
    for each in problems():
        if each.name in (sys.argv[1:] or [problem.name for problem in problems()]):
            make(each)
