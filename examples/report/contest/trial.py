"""Trials: each contestant in a process of its own, asked for one thing at a time, and stopped when it takes too long.

A process that hangs or dies is a result like any other. All processes are held to one core, on which only one of them works at
a time; compilation and first calls are apart from the times that are compared.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from ..timing import repeats_for, seconds
from .contestants import Outcome, Tolerances, contestant, entrant
from .problems import problems

PREPARATION_BOUND = 60.0  # [s], compilation
GRACE = 1.0  # [s] after a bound until a process that does not answer its alarm is killed
LEAST = 1e-3  # [s] of calls in a row that one time is taken from
ONE_CORE = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "JAX_PLATFORMS": "cpu",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false",
}


class Stopped(Exception):
    """A bound was passed."""


@dataclass(frozen=True)
class First:
    """The first call of a contestant: what it found, and the times of its preparation and of the call [s]."""

    preparation: float
    call: float
    outcome: Outcome


def alarm(_signal: int, _frame: object) -> None:
    """Stop what is under way."""
    raise Stopped


class Booth:
    """What runs in a contestant's process: prepared runs, by method and tolerance."""

    def __init__(self, name: str) -> None:
        """Load the contestant."""
        self.name = name
        contestant(name)
        self.problems = {problem.name: problem for problem in problems()}
        self.runs: dict[Any, Any] = {}
        self.preparation: dict[Any, float] = {}

    def forget(self) -> None:
        """Drop the runs of the last problem."""
        self.runs.clear()

    def prepare(self, name: str, method: str, tolerances: Tolerances) -> float:
        """Make a run ready, if it is not; its time."""
        start = time.perf_counter()
        if (method, tolerances) in self.runs:
            return 0.0
        problem = self.problems[name]
        self.runs[method, tolerances] = entrant(self.name, problem).prepare(problem, method, tolerances)
        return time.perf_counter() - start

    def first(self, method: str, tolerances: Tolerances) -> tuple[float, Outcome]:
        """The first call, timed."""
        start = time.perf_counter()
        outcome = self.runs[method, tolerances]()
        return time.perf_counter() - start, outcome

    def repeats(self, method: str, tolerances: Tolerances) -> int:
        """Number of calls in a row that are long enough to be timed."""
        return repeats_for(self.runs[method, tolerances], LEAST)

    def seconds(self, method: str, tolerances: Tolerances, repeats: int) -> float:
        """Time of one of several calls in a row."""
        return seconds(self.runs[method, tolerances], repeats)


def is_alarm(error: BaseException | None) -> bool:
    """Whether an alarm is behind an error."""
    return error is not None and (isinstance(error, Stopped) or is_alarm(error.__cause__))


def named(error: Exception) -> str:
    """What went wrong, in one line; a contestant's own failures are runtime errors."""
    kind = "failed" if isinstance(error, RuntimeError) else type(error).__name__
    return f"{kind}: {error}".splitlines()[0][:120]


def serve(connection: Connection, name: str, core: int | None) -> None:
    """Answer requests until the other end closes."""
    if core is not None:
        os.sched_setaffinity(0, {core})
    signal.signal(signal.SIGALRM, alarm)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # some contestants print
    booth = Booth(name)
    while True:
        try:
            bound, request, arguments = connection.recv()
        except EOFError:
            return
        try:
            signal.setitimer(signal.ITIMER_REAL, bound)
            answer = getattr(booth, request)(*arguments)
        except Stopped:
            answer = Stopped(f"stopped at {bound:g} s")
        except Exception as error:  # whatever a contestant raises is its result
            answer = RuntimeError(named(error))
            if is_alarm(error):  # compiled code came to its end before it told of the alarm
                answer = Stopped(f"stopped at {bound:g} s")
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
        connection.send(answer)


class Contestant:
    """A contestant's process, from the side of the report."""

    def __init__(self, name: str) -> None:
        """Start it."""
        self.name = name
        self.start()

    def start(self) -> None:
        """Start a process; what it had prepared before is gone."""
        os.environ.update({key: os.environ.get(key, value) for key, value in ONE_CORE.items()})
        context = multiprocessing.get_context("spawn")
        self.connection, far = context.Pipe()
        core = max(os.sched_getaffinity(0)) if hasattr(os, "sched_setaffinity") else None
        self.process = context.Process(target=serve, args=(far, self.name, core), daemon=True)
        self.process.start()
        far.close()
        self.is_fresh = True

    def ask(self, bound: float, request: str, *arguments: Any) -> Any:
        """Ask for one thing; `Stopped` past the bound, `RuntimeError` for whatever went wrong there."""
        self.connection.send((bound, request, arguments))
        patience = bound + GRACE + (30.0 if self.is_fresh else 0.0)  # a new process loads its packages first
        try:
            if not self.connection.poll(patience):
                self.end()
                self.start()
                raise Stopped(f"killed at {bound:g} s")
            answer = self.connection.recv()
        except (EOFError, ConnectionResetError):
            code = self.process.exitcode
            self.end()
            self.start()
            raise RuntimeError(f"the process died, code {code}") from None
        self.is_fresh = False
        if isinstance(answer, Exception):
            raise answer
        return answer

    def end(self) -> None:
        """Kill the process."""
        self.process.kill()
        self.process.join()
        self.connection.close()

    def first(self, problem: str, method: str, tolerances: Tolerances, bound: float) -> First:
        """Preparation and first call."""
        preparation = self.ask(PREPARATION_BOUND, "prepare", problem, method, tolerances)
        return First(preparation, *self.ask(bound, "first", method, tolerances))
