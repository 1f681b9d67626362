"""Two records of the same calls side by side: what is not equal to the last bit, and by how many roundings."""

import re
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

ROUNDING = 2.0**-52
MOST = 10  # roundings of their scale, times the condition of the problem, by which numbers may differ if they may at all
NUMBER = re.compile(r"[-+]?[0-9.]+(?:e[-+]?[0-9]+)?")

Record = Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Difference:
    """Two values of one name: in words where they are no numbers of one shape; else in roundings of their scale."""

    name: str
    words: str = ""
    roundings: float = 0.0

    def __str__(self) -> str:
        """Say it in a line."""
        return f"{self.name}: {self.words or f'{self.roundings:.3g} roundings'}"


def case_of(name: str) -> str:
    """Return the case that a value belongs to."""
    return name.partition(" | ")[0]


def is_same(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two arrays are equal to the last bit."""
    return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()


def difference(name: str, one: np.ndarray, other: np.ndarray) -> Difference:
    """Return how two arrays differ; texts that differ in their numbers alone by no rounding."""
    if one.dtype.kind == other.dtype.kind == "U" and one.shape == other.shape == ():
        texts = str(one), str(other)
        told = "" if NUMBER.sub("#", texts[0]) == NUMBER.sub("#", texts[1]) else f"{texts[0]!r}, then {texts[1]!r}"
        return Difference(name, told)
    if one.dtype != other.dtype or one.shape != other.shape:
        return Difference(name, f"{one.dtype} of {one.shape}, then {other.dtype} of {other.shape}")
    if one.dtype.kind not in "fc":
        return Difference(name, f"{np.sum(one != other)} of {one.size} values, {brief(one)}, then {brief(other)}")
    unknown = np.isfinite(one) != np.isfinite(other)
    if unknown.any():
        return Difference(name, f"{np.sum(unknown)} of {one.size} values are finite in one of the records alone")
    finite = np.isfinite(one)
    a, b = one[finite], other[finite]
    scale = max(np.abs(a).max(initial=0.0), np.abs(b).max(initial=0.0)) or 1.0
    return Difference(name, "", float(np.abs(a - b).max(initial=0.0) / scale / ROUNDING))


def brief(array: np.ndarray) -> str:
    """Return an array in few words."""
    words = " ".join(str(array).split())
    return words if len(words) < 60 else words[:60] + " ..."


def conditions() -> dict[str, float]:
    """Return the conditions that the reports state, by case; a case that is not there has one."""
    from report.contest.condition import stored
    from report.page import DEFAULT, read_csv

    found: dict[str, float] = defaultdict(lambda: 1.0)
    for row in read_csv(DEFAULT / "extreme_cases.csv"):
        if row["condition"]:
            case = f"extreme {row['row']}"
            found[case] = max(found[case], float(row["condition"]))
    for problem, row in stored().items():
        worst = max(float(row[kind]) for kind in ("state", "times", "entries") if row[kind])
        found[f"contest {problem}"] = max(1.0, worst)
    return found


def condition_of(name: str, known: Mapping[str, float]) -> float:
    """Return the condition of a value's case: of a contest whatever its method and tolerance."""
    case = case_of(name)
    return known[" ".join(case.split()[:2]) if case.startswith("contest") else case]


def compare(before: Record, now: Record, in_roundings: bool) -> bool:
    """Print what differs, the most first of each case; whether nothing does, or nothing by more than it may.

    What only the newer build answers is counted and is no difference.
    """
    lost = [Difference(name, "not there now") for name in before if name not in now]
    common = [name for name in before if name in now]
    differences = [difference(n, before[n], now[n]) for n in common if not is_same(before[n], now[n])]
    known = conditions()
    wrong = [d for d in differences if d.words or d.roundings > MOST * condition_of(d.name, known)]
    by_case = defaultdict(list)
    for each in lost + (wrong if in_roundings else differences):
        by_case[case_of(each.name)].append(each)
    for found in by_case.values():
        found.sort(key=lambda d: (bool(d.words), d.roundings), reverse=True)
        print(*found[:3], sep="\n")
        if len(found) > 3:
            print(f"    and {len(found) - 3} more of this case")
    numbers = sum(before[name].size for name in common)
    worst = max((d.roundings / condition_of(d.name, known) for d in differences), default=0.0)
    print(
        f"{len(common)} values, {numbers} entries: {len(differences)} values differ in a bit, {len(wrong)} by more than "
        f"{MOST} roundings times their condition (the most: {worst:.3g}), {len(lost)} are not there now, "
        f"{len(now) - len(common)} were not there before"
    )
    return not by_case
