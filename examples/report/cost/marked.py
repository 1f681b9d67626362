"""The program that is counted: `python -m report.cost.marked NAME ...` runs each case three times, with marks between.

Prints the numbers of units of the runs as JSON.
"""

from __future__ import annotations

import json
import os
import sys

from report.cost.case import Run
from report.cost.named import find


def mark() -> None:
    """Call the function at which the counts are written out and reset."""
    os.getppid()


def marked_run(run: Run, units: int) -> int:
    """A run that ends with a mark."""
    done = run(units)
    mark()
    return done


def run_thrice(run: Run, units: int) -> list[int]:
    """Run one unit, about so many, and twice as many; runs before have made whatever is made once."""
    run(1)
    run(units)
    mark()
    return [marked_run(run, count) for count in (1, units, 2 * units)]


def main() -> None:
    """Run the cases named on the command line."""
    found = {name: find(name) for name in sys.argv[1:]}
    print(json.dumps({name: run_thrice(case.prepare(), case.counted) for name, case in found.items()}))


if __name__ == "__main__":
    main()
