"""The contestants, one file each, all of one form.

A contestant's module has `DISTRIBUTION` (the package whose version the report prints), `methods(problem)` (names of its methods
for a problem) and `prepare(problem, method, tolerances)`, which compiles whatever it compiles and returns a function without
arguments that follows the motion and gives an `Outcome`. A package that is not installed is no contestant, nor is one that was
compiled for another interpreter or NumPy and so cannot be imported.
"""

from __future__ import annotations

import importlib
import importlib.util
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from ..problems import Compliant, Ensemble, Problem

#: Module here, and the module that it needs.
NEEDS = {
    "own": "vibroimpact",
    "scipy": "scipy",
    "heyoka": "heyoka",
    "pydiffsol": "pydiffsol",
    "numbalsoda": "numbalsoda",
    "diffrax": "diffrax",
    "sundae": "sksundae",
    "siconos": "siconos.kernel",
}
#: Folders of those that are driven otherwise than for one motion past rigid stops.
KINDS = {Ensemble: "ensembles", Compliant: "compliant"}
#: Of these, the ones that come from elsewhere than a package index, compiled for one interpreter and one NumPy.
FOREIGN = {"siconos"}


@dataclass(frozen=True)
class Tolerances:
    """What a method is asked for: relative, and absolute in the problem's units."""

    relative: float
    absolute: float


@dataclass(frozen=True)
class Outcome:
    """What a run found: the state at the end, and every time of impact in order."""

    state: np.ndarray
    times: np.ndarray


Run = Callable[[], Outcome]


def available(wanted: Sequence[str] = tuple(NEEDS)) -> list[str]:
    """Those of the contestants wanted that are installed."""
    return [name for name in wanted if is_found(NEEDS[name]) and (name not in FOREIGN or is_importable(NEEDS[name]))]


def is_found(module: str) -> bool:
    """Whether a module's package is there."""
    return importlib.util.find_spec(module.partition(".")[0]) is not None


def is_importable(module: str) -> bool:
    """Whether a module can be imported: tried in a process of its own, which may complain, or crash."""
    trial = subprocess.run([sys.executable, "-c", f"import {module}"], capture_output=True, check=False)
    return trial.returncode == 0


def contestant(name: str) -> ModuleType:
    """The module of a contestant."""
    return importlib.import_module(f"{__name__}.{name}")


def entrant(name: str, problem: Problem) -> ModuleType | None:
    """The module that a contestant enters for a problem, None if it has none for problems of its kind."""
    kind = KINDS.get(type(problem))
    if kind is None:
        return contestant(name)
    return contestant(f"{kind}.{name}") if importlib.util.find_spec(f"{__name__}.{kind}.{name}") else None
