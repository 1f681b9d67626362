"""Conditions of the problems: by how much small changes of what is given change the answer.

They are made by `condition_recipe.py` from motions in many digits, and so owe nothing to any contestant; stored beside the
references.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass

from .problems import Problem
from .reference import FOLDER, fingerprint

TABLE = FOLDER / "conditions.csv"


@dataclass(frozen=True)
class Condition:
    """Factors by which relative changes grow, in the motion's own scale; of many starts the largest of the sample.

    `state`: from one entry of the start to the final state. `times`: from there to a time of impact. `entries`: from all entries
    of the mass, damping and stiffness matrices, each changed by the same part of itself in the worst direction, to the final
    state; None where there are no matrices.
    """

    state: float | None
    times: float | None
    entries: float | None


def stored() -> dict[str, dict[str, str]]:
    """Rows of the table, by problem."""
    if not TABLE.exists():
        return {}
    with TABLE.open(newline="") as file:
        return {row["problem"]: row for row in csv.DictReader(file)}


def conditions(wanted: Sequence[Problem]) -> dict[str, Condition]:
    """Stored conditions, empty where none is stored; one that was made for other numbers is refused."""
    rows, found = stored(), {}
    for problem in wanted:
        row = rows.get(problem.name)
        if row is None:
            found[problem.name] = Condition(None, None, None)
            continue
        if row["fingerprint"] != fingerprint(problem):
            message = f"the condition of {problem.name} was made for other numbers; make it again (condition_recipe.py)"
            raise ValueError(message)
        found[problem.name] = Condition(
            float(row["state"]), float(row["times"]), float(row["entries"]) if row["entries"] else None
        )
    return found
