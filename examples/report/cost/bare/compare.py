"""Instructions of a unit in the whole crate and in bare builds of it, where both make the same motion to the last bit."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from report.cost.bare.change import faults
from report.cost.bare.copies import ROOT, built
from report.cost.bare.kinds import BARE, Bare

# A count may be larger by this part.
EQUAL = 0.01
UNITS = 2_000
COLLECTED = re.compile(r"Collected : (?P<count>\d+)")


@dataclass(frozen=True)
class Run:
    """A counted run: its instructions, its units, the bits of the state in which it ends."""

    instructions: int
    units: int
    state: tuple[str, ...]


@dataclass(frozen=True)
class Pair:
    """The cost of a unit of one case in the whole crate and in a bare build."""

    bare: Bare
    case: str
    whole: float
    left: float
    units: int
    is_same: bool

    def more(self) -> float:
        """What the whole crate takes beyond the bare build, as a part of that."""
        return self.whole / self.left - 1.0

    def holds(self) -> bool:
        """Whether both made the same motion and the whole crate took no more."""
        return self.is_same and self.more() <= EQUAL


@dataclass(frozen=True)
class Found:
    """The pairs counted; the changes that do not apply, and the builds that failed."""

    pairs: Sequence[Pair] = ()
    faults: Sequence[str] = ()
    failed: Sequence[str] = ()


def run(bench: Path, case: str, units: int) -> Run:
    """Count a run of a case."""
    command = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", str(bench), "--count", case, str(units), "1"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    count = COLLECTED.search(done.stderr)
    if count is None:
        raise RuntimeError(f"callgrind told no count:\n{done.stderr[-2000:]}")
    total, *state = done.stdout.split()
    return Run(int(count["count"]), int(total), tuple(state))


def per_unit(few: Run, many: Run) -> float:
    """Instructions of a unit."""
    return (many.instructions - few.instructions) / (many.units - few.units)


def pair(bare: Bare, case: str, benches: tuple[Path, Path]) -> Pair:
    """One case in both builds."""
    whole, left = [[run(bench, case, units) for units in (UNITS, 2 * UNITS)] for bench in benches]
    is_same = all((a.units, a.state) == (b.units, b.state) for a, b in zip(whole, left, strict=True))
    return Pair(bare, case, per_unit(*whole), per_unit(*left), whole[1].units, is_same)


def stale() -> list[str]:
    """The changes that do not apply to the sources any more; none where there are no sources."""
    if not (ROOT / "src").exists():
        return []
    return [f"{bare.key}: {fault}" for bare in BARE for fault in faults(bare.changes(), ROOT)]


def compared(whole: Path | None) -> Found:
    """Every bare build against the bench of the whole crate; nothing where that or callgrind is missing."""
    wrong = stale()
    if whole is None or wrong or not shutil.which("valgrind"):
        return Found(faults=wrong)
    benches = {bare.key: built(bare.key, bare.changes()) for bare in BARE}
    pairs = [pair(bare, case, (whole, bench)) for bare in BARE if (bench := benches[bare.key]) is not None for case in bare.cases]
    return Found(pairs, wrong, [key for key, bench in benches.items() if bench is None])
