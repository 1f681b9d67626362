"""Cases under the rows they try: each is a function without arguments that yields findings."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator

from mpmath import mp

from report.extremes.finding import Finding
from report.extremes.rows import ROWS

DIGITS = 50  # of every reference

Case = Callable[[], Iterator[Finding]]
CASES: dict[str, list[Case]] = defaultdict(list)
LONG: dict[str, list[Case]] = defaultdict(list)
SHORT: dict[str, list[Case]] = defaultdict(list)


def case(row: str, cases: dict[str, list[Case]] = CASES) -> Callable[[Case], Case]:
    """Put a case under its row: of every run, or of the long or the short (quick) one alone."""
    if row not in ROWS:
        raise ValueError(f"row is {row!r}, but rows.py has none of this name")

    def put(function: Case) -> Case:
        cases[row].append(function)
        return function

    return put


def cases_of(row: str, quick: bool) -> list[Case]:
    """What tries a row."""
    return CASES[row] + (SHORT if quick else LONG)[row]


def findings_of(row: str, quick: bool) -> list[Finding]:
    """Try a row, with references of 50 digits."""
    with mp.workdps(DIGITS):
        return [finding for each in cases_of(row, quick) for finding in each()]
