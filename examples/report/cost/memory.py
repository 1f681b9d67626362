"""Peak memory of one run in a process of its own: `python -m report.cost.memory NAME` prints what the run added, in MiB."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from report.cost.instructions import environment

STATUS = Path("/proc/self/status")
# Below this the peak cannot be told from that of a process that does nothing [MiB].
LEAST = 1.0


def peak() -> float:
    """Largest resident memory of this process so far [MiB]."""
    line = next(line for line in STATUS.read_text().splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024.0


def added(name: str) -> float | None:
    """Peak memory that a case adds to a process that has the package loaded [MiB]; None where the system does not tell it."""
    if not STATUS.exists():
        return None
    program = [sys.executable, "-m", "report.cost.memory", name]
    done = subprocess.run(program, env=environment(), capture_output=True, text=True, check=True)
    return float(done.stdout)


def main() -> None:
    """Measure the case named on the command line."""
    from report.cost.named import find

    case = find(sys.argv[1])
    before = peak()
    case.prepare()(case.timed)
    print(peak() - before)


if __name__ == "__main__":
    main()
