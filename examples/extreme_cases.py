"""Extreme and stiff cases: every row that must hold, beside a closed form or 50-digit arithmetic, judged by one rule.

Run: python examples/extreme_cases.py [--quick] [--output DIRECTORY]
Writes extreme_cases.md and extreme_cases.csv; prints what fails. A quick run tries 10^4 impacts for 10^6.
"""

from __future__ import annotations

import time

from report.extremes import (  # noqa: F401  (importing a family of cases puts them under their rows)
    driven,
    giving_way,
    modes,
    orbits,
    pendulums,
    refusals,
    rest,
    restitution,
    several,
    speeds,
    starts,
    steady,
    systems,
)
from report.extremes.checks import checks
from report.extremes.finding import Finding
from report.extremes.lost import all_series
from report.extremes.registry import cases_of, findings_of
from report.extremes.rows import ROWS
from report.extremes.text import page_parts, records
from report.page import DEFAULT, job, put_in_readme, read_csv, write_csv, write_page

PACKAGES = ("mpmath",)


def tried(quick: bool) -> dict[str, list[Finding]]:
    """The findings of every row; a row without a case is an error."""
    without = [row for row in ROWS if not cases_of(row, quick)]
    assert not without, f"rows without a case: {without}"
    return {row: findings_of(row, quick) for row in ROWS}


def main() -> None:
    """Try all rows; write the page and its table."""
    asked = job(__doc__.partition("\n")[0])
    start = time.perf_counter()
    rows = tried(asked.quick)
    parts = page_parts(rows, all_series(), checks(), read_csv(DEFAULT / "soaks.csv"))
    write_page(asked.output / "extreme_cases.md", "Extreme and stiff cases", parts, PACKAGES)
    write_csv(asked.output / "extreme_cases.csv", records(rows))
    failed = [(row, finding) for row, findings in rows.items() for finding in findings if not finding.holds]
    for row, finding in failed:
        print(f"fails: {row} | {finding.quantity} | {finding.method} | {finding.computed} | {finding.reference}")
    count = sum(map(len, rows.values()))
    if asked.output == DEFAULT:
        put_in_readme("extremes", f"{count - len(failed)} of {count} quantities hold")
    print(f"{len(rows)} rows, {count} findings, {len(failed)} fail; {time.perf_counter() - start:.0f} s; page in {asked.output}/")


if __name__ == "__main__":
    main()
