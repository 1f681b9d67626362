"""Peak memory of runs: `python -m report.cost.memory JSON` prints what each case adds to the smallest of its series, in MiB.

The program forks for each case. The fork runs the smallest case first, which loads whatever any run loads, and gives back what
is free; what its memory then rises by at most is that of the case.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from report.cost.instructions import environment

STATUS = Path("/proc/self/status")
# Where "5" makes the present memory the largest so far.
RESET = Path("/proc/self/clear_refs")
# Below this a rise of the peak is not told from chance [MiB].
LEAST = 0.5


def peak() -> float:
    """Largest resident memory of this process so far [MiB]."""
    line = next(line for line in STATUS.read_text().splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024.0


def added(smallest: Mapping[str, str]) -> dict[str, float]:
    """What each named case adds to the peak after the case it is mapped to [MiB]; empty where the system does not tell."""
    if not STATUS.exists():
        return {}
    program = [sys.executable, "-m", "report.cost.memory", json.dumps(dict(smallest))]
    done = subprocess.run(program, env=environment(), capture_output=True, text=True, check=True)
    found: dict[str, float] = json.loads(done.stdout)
    return found


def run(name: str) -> None:
    """Run a case as often as when it is timed."""
    from report.cost.named import find

    case = find(name)
    case.prepare()(case.timed)


def forget() -> None:
    """Give back what is free, and forget the peak so far."""
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
    # Where that is forbidden the peak of the smallest case stays, and hides rises below it.
    with contextlib.suppress(OSError):
        RESET.write_text("5")


def measure(name: str, smallest: str) -> float:
    """Run two cases in a fork; what the peak rises by in the second."""
    reading, writing = os.pipe()
    if os.fork() == 0:
        run(smallest)
        forget()
        before = peak()
        run(name)
        os.write(writing, str(peak() - before).encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        text = pipe.read()
    os.wait()
    return float(text)


def main() -> None:
    """Measure the cases named on the command line."""
    pairs: dict[str, str] = json.loads(sys.argv[1])
    print(json.dumps({name: measure(name, smallest) for name, smallest in pairs.items()}))


if __name__ == "__main__":
    main()
