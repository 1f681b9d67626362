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
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

MARK = "getppid"
EXAMPLES = Path(__file__).parents[2]
# Functions of the C library by what they are for; the processor's variants of a function have suffixes.
KINDS = {
    "sine, cosine": re.compile(r"^(__)?(sin|cos|sincos)(_[a-z0-9]+)?(@.*)?$"),
    "exponential": re.compile(r"^(__)?(exp|exp2|expm1)(@.*)?$"),
    "allocation": re.compile(r"^(malloc|calloc|realloc|posix_memalign|aligned_alloc)$"),
}


@dataclass(frozen=True)
class Stretch:
    """Instructions between two marks, and calls of the C library by kind."""

    instructions: int
    calls: Counter[str]


@dataclass(frozen=True)
class PerUnit:
    """What one more unit takes, and what a call with no unit takes."""

    instructions: float
    calls: dict[str, float]
    fixed: float


def tool() -> str | None:
    """Name and version of the counter, None where it is not installed."""
    if not shutil.which("valgrind"):
        return None
    return subprocess.run(["valgrind", "--version"], capture_output=True, text=True, check=True).stdout.strip()


def environment() -> dict[str, str]:
    """One thread of linear algebra and one order of sets: the same instructions at each call."""
    steady = {"PYTHONPATH": str(EXAMPLES), "PYTHONHASHSEED": "0", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    return {**os.environ, **steady}


def kind_of(name: str) -> str | None:
    """What a function of the C library is for; None for those that are not looked at."""
    return next((kind for kind, pattern in KINDS.items() if pattern.match(name)), None)


def read_stretch(path: Path) -> Stretch:
    """One file of callgrind: the sum of its counts, and the calls of the functions that are looked at."""
    calls: Counter[str] = Counter()
    total, called = 0, None
    with path.open(errors="replace") as file:
        for line in file:
            if line.startswith("cfn="):
                called = kind_of(line[4:].strip())
            elif line.startswith("calls=") and called:
                calls[called] += int(line[6:].split()[0])
            elif line.startswith("totals:"):
                total = int(line.split()[1])
    return Stretch(total, calls)


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
    calls = {kind: (many.calls[kind] - few.calls[kind]) / (more - less) for kind in KINDS}
    return PerUnit(slope, calls, one.instructions - slope * first)


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
