"""Instructions counted by callgrind, between marks that the counted program sets.

Callgrind writes out and resets its counts whenever a chosen function is entered. The counted program, `report.cost.marked`, calls
one that nothing else calls, so that one process measures many stretches and its start-up is in none of them. Two stretches
that differ in the number of units alone leave the cost of a unit: what is done once per call falls out.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

MARK = "getppid"
EXAMPLES = Path(__file__).parents[2]
# Functions of the C library by what they are for, whose calls are counted; the processor's variants have suffixes.
CALLS = {
    "sine, cosine": re.compile(r"^(__)?(sin|cos|sincos)(_[a-z0-9]+)?(@.*)?$"),
    "allocation": re.compile(r"^(malloc|calloc|realloc|posix_memalign|aligned_alloc)$"),
}
# Functions of the library by what they are for, whose instructions are counted. Code that the compiler has put into its
# callers is counted with those: what is found is a lower bound.
MACHINERY = {
    "search for contacts": re.compile(r"vibroimpact::contact::|integrated::contact|::take_gaps|model::contact"),
    "release of held stops": re.compile(r"integrated::release|flow::constrained"),
    "impacts": re.compile(r"vibroimpact::impact::|event_loop::(strike|hold_or_release)|::collide$"),
    "integrator": re.compile(r"flow::steps|pendulum_series|flow::taylor"),
    "load or forcing": re.compile(r"::loaded$|flow::drive|flow::split|flow::series_forcing"),
    "clock, for Ctrl-C": re.compile(r"python::interrupt|Timespec|clock_gettime"),
}
KINDS = (*CALLS, *MACHINERY)


@dataclass(frozen=True)
class Stretch:
    """Instructions between two marks; calls of the C library and instructions in the library's machinery, by kind."""

    instructions: int
    spent: Counter[str]


@dataclass(frozen=True)
class PerUnit:
    """What one more unit takes, and what a call with no unit takes."""

    instructions: float
    spent: dict[str, float]
    fixed: float


def tool() -> str | None:
    """Name and version of the counter, None where it is not installed."""
    if not shutil.which("valgrind"):
        return None
    return subprocess.run(["valgrind", "--version"], capture_output=True, text=True, check=True).stdout.strip()


def environment() -> dict[str, str]:
    """One thread of linear algebra and one order of sets: the same instructions at each call."""
    path = os.pathsep.join(filter(None, [str(EXAMPLES), os.environ.get("PYTHONPATH")]))
    steady = {"PYTHONPATH": path, "PYTHONHASHSEED": "0", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    return {**os.environ, **steady}


def kind_of(name: str, kinds: Mapping[str, re.Pattern[str]]) -> str | None:
    """What a function is for; None for those that are not looked at."""
    return next((kind for kind, pattern in kinds.items() if pattern.search(name)), None)


def read_stretch(path: Path) -> Stretch:
    """One file of callgrind: the sum of its counts, and what is looked at of its functions.

    A line of numbers is a function's own cost, but for the one after `calls=`, which is that of the function called.
    """
    spent: Counter[str] = Counter()
    total, called, own, is_own = 0, None, None, True
    with path.open(errors="replace") as file:
        for line in file:
            if line.startswith("fn="):
                own, is_own = kind_of(line[3:].strip(), MACHINERY), True
            elif line.startswith("cfn="):
                called = kind_of(line[4:].strip(), CALLS)
            elif line.startswith("calls="):
                is_own = False
                if called:
                    spent[called] += int(line[6:].split()[0])
            elif line.startswith("totals:"):
                total = int(line.split()[1])
            elif line[0] in "0123456789+-*":
                if own and is_own:
                    spent[own] += int(line.split()[1])
                is_own = True
    return Stretch(total, spent)


def stretches(arguments: Sequence[str], directory: Path) -> tuple[list[Stretch], str]:
    """Run the counted program; what lies before each mark, in order, and what it printed."""
    options = ["--tool=callgrind", f"--callgrind-out-file={directory / 'out'}", f"--dump-before={MARK}"]
    plain = ["--compress-strings=no", "--dump-line=no"]
    program = [sys.executable, "-m", "report.cost.marked", *arguments]
    done = subprocess.run(
        ["valgrind", *options, *plain, *program], env=environment(), capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(f"the counted program failed:\n{done.stderr[-2000:]}")
    files = sorted(directory.glob("out.*"), key=lambda path: int(path.suffix[1:]))
    return [read_stretch(path) for path in files], done.stdout


def per_unit(one: Stretch, few: Stretch, many: Stretch, units: Sequence[int]) -> PerUnit:
    """The slope between two stretches, and what it leaves of a stretch of about one unit."""
    first, less, more = units
    slope = (many.instructions - few.instructions) / (more - less)
    spent = {kind: (many.spent[kind] - few.spent[kind]) / (more - less) for kind in KINDS}
    return PerUnit(slope, spent, one.instructions - slope * first)


def counted(names: Sequence[str]) -> dict[str, PerUnit]:
    """What each case takes for one unit, by `report.cost.marked`; empty where callgrind is not installed."""
    if not names or not tool():
        return {}
    with tempfile.TemporaryDirectory() as directory:
        found, printed = stretches(names, Path(directory))
    units: dict[str, list[int]] = json.loads(printed)
    # Four marks for each case: after its preparation, and after each of three runs.
    if len(found) != 4 * len(names):
        raise RuntimeError(f"{len(found)} stretches for {len(names)} cases: was the mark called by something else?")
    return {name: per_unit(*found[4 * k + 1 : 4 * k + 4], units[name]) for k, name in enumerate(names)}
