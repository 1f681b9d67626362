"""Instructions of a unit and of a call, for each case of the report of scene costs."""

import csv
from math import exp, log
from pathlib import Path
from statistics import fmean

from report.cost.catalogue import groups
from report.cost.instructions import counted

HEAD = ["case", "unit", "call"]
ALLOWED = 1.02  # of a case now to the same before
OTHERS = ("callable", "gap")  # groups in which a user's function takes most

Counts = dict[str, tuple[float, float]]


def names(words: list[str]) -> list[str]:
    """Return the cases by name, those with one of the words if there are any."""
    every = [name for group in groups() if group.key not in OTHERS for name in group.names()]
    return [name for name in every if not words or any(word in name for word in words)]


def write(path: Path, words: list[str]) -> None:
    """Count all cases and write them."""
    found = counted(names(words))
    if not found:
        raise SystemExit("valgrind is not installed, or there is no such case")
    with path.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(HEAD)
        rows.writerows([name, f"{each.instructions:.1f}", f"{each.fixed:.0f}"] for name, each in found.items())


def is_count(path: Path) -> bool:
    """Whether a file is one of these."""
    with path.open("rb") as file:
        return file.readline().strip() == ",".join(HEAD).encode()


def read(path: Path) -> Counts:
    """Read a file that was written here."""
    with path.open(newline="") as file:
        return {row["case"]: (float(row["unit"]), float(row["call"])) for row in csv.DictReader(file)}


def compare(before: Counts, now: Counts) -> bool:
    """Print the ratios, the largest first; whether none is larger than it may be, nor their geometric mean above one."""
    common = [name for name in before if name in now]
    print(*(f"{name}: in one file alone" for name in sorted(before.keys() ^ now.keys())), sep="\n")
    ratios = {name: [n / b for n, b in zip(now[name], before[name], strict=True) if b > 0.0] for name in common}
    for name in sorted(common, key=lambda name: max(ratios[name]), reverse=True):
        told = ", ".join(f"{kind} {b:.0f} -> {n:.0f}" for kind, b, n in zip(HEAD[1:], before[name], now[name], strict=True))
        print(f"{max(ratios[name]):.4f}  {name}: {told}")
    mean = exp(fmean(log(each[0]) for each in ratios.values()))
    most = max(max(each) for each in ratios.values())
    print(f"geometric mean of {len(common)} units {mean:.4f}, largest ratio {most:.4f}")
    return mean <= 1.0 + 5e-4 and most <= ALLOWED
