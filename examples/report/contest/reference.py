"""References of the problems: made in many digits by `recipe.py`, checked a second way, stored beside this file."""

from __future__ import annotations

import csv
import hashlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .equations import equations
from .problems import Compliant, Ensemble, Problem

FOLDER = Path(__file__).with_name("references")


@dataclass(frozen=True)
class Reference:
    """The right answer: times of impact, final state, and the motion's own scale, one number for each entry of the state.

    Of an ensemble: no times, but the number of impacts of each trajectory of the sample; their states are rows.
    """

    times: np.ndarray
    state: np.ndarray
    scale: np.ndarray
    counts: np.ndarray
    recipe: str


def fingerprint(problem: Problem) -> str:
    """A problem in twelve letters: its formulas with ten digits of each number, its starts and its end."""
    pressed = range(len(problem.scene.stops)) if isinstance(problem, Compliant) else ()
    formulas = equations(problem.scene, pressed=pressed)
    starts = problem.starts[problem.sample].ravel() if isinstance(problem, Ensemble) else problem.start
    words = [f"{each:.10g}" for each in (*starts, problem.end)]
    for formula in (formulas.acceleration, *formulas.gaps, *formulas.impacts):
        words += [f"{line.name} {line.text(lambda number: f'{number:.10g}')}" for line in formula.lines]
        words += [each if isinstance(each, str) else f"{each:.10g}" for each in formula.results]
    return hashlib.sha256("\n".join(words).encode()).hexdigest()[:12]


def load(problem: Problem) -> Reference:
    """Read a stored reference; one that was made for other numbers is refused."""
    lines = (FOLDER / f"{problem.name}.csv").read_text().splitlines()
    recipe = " ".join(line[2:] for line in lines if line.startswith("# "))
    found: dict[str, list[str]] = {kind: [] for kind in ("problem", "impact", "state", "scale", "count")}
    for kind, value in list(csv.reader(line for line in lines if not line.startswith("# ")))[1:]:
        found[kind].append(value)
    if found.pop("problem") != [fingerprint(problem)]:
        message = f"the reference of {problem.name} was made for other numbers; make it again (recipe.py)"
        raise ValueError(message)
    times, state, scale, counts = (np.array(values, dtype=float) for values in found.values())
    state = state.reshape(len(counts), -1) if len(counts) else state
    return Reference(times, state, scale, counts.astype(int), recipe.partition(": ")[2])
