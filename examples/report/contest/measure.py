"""Measurements of one problem: first calls one after another, errors against the reference, times call by call in turn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import median, quantiles

import numpy as np

from .contestants import Outcome, Tolerances, entrant
from .contestants.ensembles import Ends
from .problems import Compliant, Ensemble, Problem
from .reference import Reference
from .trial import PREPARATION_BOUND, Contestant, Stopped

ROUNDS = 25
LEAST_ROUNDS = 3  # a median wants that many
BUDGET = 0.15  # [s] of timed calls of one point: slow points are timed in fewer rounds
SLOW = 0.4  # [s] a call that takes longer is its own time
FELL = 1e-2  # of the motion's scale: deeper in a stop than that at the end, it fell through
LOST = 0.1  # of the motion's scale: an answer further off is none
BASE = ("scipy", "RK45", 1e-6)  # times are ratios to this one


@dataclass(frozen=True)
class Point:
    """One contestant's method at one tolerance on one problem."""

    problem: str
    package: str
    method: str
    rtol: float
    verdict: str
    n_impacts: int | None = None
    state_error: float | None = None
    time_error: float | None = None
    preparation: float | None = None
    first_call: float | None = None
    seconds: float | None = None
    ratio: float | None = None
    share: float = 1.0  # of the work that a call does; times are those of the whole
    median_error: float | None = None  # of many starts; `state_error` is then the largest
    spread: float | None = None  # of the times of the rounds, between their quartiles, over their median

    @property
    def name(self) -> str:
        """Package and method."""
        return f"{self.package} {self.method}"

    @property
    def is_base(self) -> bool:
        """Whether times are ratios to this one."""
        return (self.package, self.method, self.rtol) == BASE

    @property
    def error(self) -> float:
        """The worse of the two errors, of many starts that of the state; infinite for whatever is no right answer."""
        return max(self.state_error, self.time_error or 0.0) if self.verdict == "right" else float("inf")


@dataclass(frozen=True)
class Plan:
    """What is asked of whom: tolerances, and the bound of a call [s]."""

    tolerances: Sequence[float]
    bound: float
    methods: Mapping[str, Sequence[str]]

    def of(self, package: str, problem: Problem) -> list[str]:
        """Methods of a package for a problem, all if none are named."""
        module = entrant(package, problem)
        every = module.methods(problem) if module else []
        return [each for each in every if each in self.methods.get(package, every)]


def judged(problem: Problem, reference: Reference, outcome: Outcome) -> dict[str, object]:
    """Verdict and errors of what a run found."""
    found, wanted = len(outcome.times), len(reference.times)
    is_complete = found == wanted if problem.first is None else found >= wanted
    common = min(found, wanted)
    own_time = reference.scale[0] / reference.scale[-1]
    state_error = float(np.abs((outcome.state - reference.state) / reference.scale).max())
    late = np.abs(np.asarray(outcome.times)[:common] - reference.times[:common]) / own_time
    depth = -min(problem.scene.gaps(outcome.state[: problem.scene.n_dof], problem.end)) / reference.scale[0]
    errors = {"n_impacts": found, "state_error": state_error, "time_error": float(late.max(initial=0.0))}
    if not np.all(np.isfinite(outcome.state)):
        return {"n_impacts": found, "verdict": "not finite"}
    if depth > FELL and not isinstance(problem, Compliant):
        return {**errors, "verdict": "through the stop"}
    if not is_complete:
        return {**errors, "verdict": f"{found} of {wanted} impacts"}
    if state_error > LOST:
        return {**errors, "verdict": f"off by more than {LOST:g} of the motion"}
    return {**errors, "verdict": "right"}


def judged_together(problem: Ensemble, reference: Reference, ends: Ends) -> dict[str, object]:
    """Verdict, largest and median error of many trajectories, from those that have a reference."""
    _, at, known = np.intersect1d(ends.rows, problem.sample, return_indices=True)
    errors = np.abs((ends.states[at] - reference.state[known]) / reference.scale).max(axis=1)
    wrong = int(np.count_nonzero(ends.counts[at] != reference.counts[known]))
    found = {
        "n_impacts": int(ends.counts[at].sum()),
        "share": len(ends.rows) / len(problem.starts),
        "state_error": float(errors.max()),
        "median_error": float(np.median(errors)),
    }
    return {**found, "verdict": f"wrong number of impacts in {wrong} of {len(at)} trajectories" if wrong else "right"}


def tolerances(rtol: float, reference: Reference) -> Tolerances:
    """Relative tolerance, and a tenth of it in the motion's own positions."""
    return Tolerances(rtol, 0.1 * rtol * float(reference.scale[0]))


def first_calls(problem: Problem, reference: Reference, process: Contestant, plan: Plan) -> list[Point]:
    """First calls of all methods of a package, from the loosest tolerance on."""
    points = []
    for method in plan.of(process.name, problem):
        is_over = False
        for rtol in plan.tolerances:
            point = Point(problem.name, process.name, method, rtol, "not tried: stopped before")
            if not is_over:
                point = first_call(point, problem, reference, process, plan.bound)
                is_over = point.verdict.startswith(("stopped", "killed"))
            points.append(point)
    return points


def first_call(point: Point, problem: Problem, reference: Reference, process: Contestant, bound: float) -> Point:
    """The first call of one point, or what went wrong."""
    try:
        first = process.first(problem.name, point.method, tolerances(point.rtol, reference), bound)
    except (Stopped, RuntimeError) as trouble:
        return replace(point, verdict=str(trouble))
    judge = judged_together if isinstance(problem, Ensemble) else judged
    found = judge(problem, reference, first.outcome)
    return replace(point, preparation=first.preparation, first_call=first.call, **found)


def timed(points: Sequence[Point], reference: Reference, processes: Mapping[str, Contestant], bound: float) -> list[Point]:
    """The same points with their times: each round calls every one that has not used its budget up."""
    running: dict[Point, list[float]] = {point: [] for point in points if point.first_call is not None}
    repeats: dict[Point, int] = {}
    for turn in range(ROUNDS):
        for point, times in running.items():
            if point.first_call > SLOW:
                continue
            process, arguments = processes[point.package], (point.method, tolerances(point.rtol, reference))
            if turn and (not times or (turn >= LEAST_ROUNDS and sum(times) * repeats[point] > BUDGET)):
                continue
            try:
                if not turn:
                    process.ask(PREPARATION_BOUND, "prepare", point.problem, *arguments)  # again, if a process was killed
                    repeats[point] = process.ask(2 * bound, "repeats", *arguments)
                times.append(process.ask(2 * bound, "seconds", *arguments, repeats[point]))
            except (Stopped, RuntimeError):
                continue  # lost with a process that was killed: its first call stands
    took = {point: (median(times) if times else point.first_call) / point.share for point, times in running.items()}
    base = next((t for p, t in took.items() if p.is_base), bound)
    found = {
        point: replace(point, seconds=took[point], ratio=took[point] / base, spread=spread(times))
        for point, times in running.items()
    }
    return [found.get(point, point) for point in points]


def spread(times: Sequence[float]) -> float | None:
    """How far the times of one point lie apart: between their quartiles, over their median."""
    if len(times) < LEAST_ROUNDS:
        return None
    low, middle, high = quantiles(times, n=4, method="inclusive")
    return (high - low) / middle


def base_of(points: Sequence[Point]) -> Point | None:
    """The point of one problem that times are ratios to; None where it was stopped, and they are ratios to the bound."""
    return next((p for p in points if p.is_base and p.seconds is not None), None)


def measured(problem: Problem, reference: Reference, processes: Mapping[str, Contestant], plan: Plan) -> list[Point]:
    """All points of a problem."""
    points = [point for process in processes.values() for point in first_calls(problem, reference, process, plan)]
    points = timed(points, reference, processes, plan.bound)
    for process in processes.values():
        process.ask(plan.bound, "forget")
    return points
