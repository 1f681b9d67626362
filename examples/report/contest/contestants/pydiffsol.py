"""pydiffsol: the model as text, with its stops and what is reset at them, compiled as a whole.

A reset must leave the stop, or the solver falls through it: the position is put a little in front of it, to a gap far below every
tolerance. One text of resets serves all stops: each acts if its own gap is closed, by Heaviside's function.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pydiffsol as ds

from ..equations import Equations, equations
from ..formulas import Traced
from ..opening import opening
from ..problems import Problem
from . import Outcome, Run, Tolerances

DISTRIBUTION = "pydiffsol"
CLOSED = 1e-9  # a gap below that is closed
METHODS = {"tsit45": ds.tsit45, "bdf": ds.bdf, "tr_bdf2": ds.tr_bdf2, "esdirk34": ds.esdirk34}


def methods(problem: Problem) -> list[str]:
    """An explicit pair; for stiff scenes the implicit methods too."""
    return list(METHODS) if problem.is_stiff else ["tsit45", "bdf"]


def scalars(formula: Traced, prefix: str) -> tuple[list[str], list[str]]:
    """Lines of a formula as scalars of the model, and its results."""

    def word(each: object) -> str:
        return prefix + each if isinstance(each, str) and each.startswith("x") else str(each)

    def text(operation: str, operands: list[str]) -> str:
        return f"{operation}({operands[0]})" if len(operands) == 1 else f"({operands[0]}) {operation} ({operands[1]})"

    lines = [f"{prefix}{line.name} {{ {text(line.operation, [word(o) for o in line.operands])} }}" for line in formula.lines]
    return lines, [word(each) for each in formula.results]


def model(problem: Problem) -> str:
    """The model's text."""
    formulas: Equations = equations(problem.scene)
    n = formulas.n_dof
    names = [*(f"q{i}" for i in range(n)), *(f"v{i}" for i in range(n))]
    state = ", ".join(f"{name} = {value!r}" for name, value in zip(names, problem.start.tolist(), strict=True))
    lines, rates = scalars(formulas.acceleration, "a")
    gaps, changes = [], [[name] for name in names]
    for k, (distance, impact) in enumerate(zip(formulas.gaps, formulas.impacts, strict=True)):
        leading, back = opening(problem, k)
        (to_gap, found), (to_change, moved), (to_impact, turned) = (
            scalars(formula, f"{prefix}{k}") for formula, prefix in ((distance, "g"), (back, "b"), (impact, "r"))
        )
        lines += [*to_gap, f"closed{k} {{ heaviside({CLOSED!r} - ({found[0]})) }}", *to_change, *to_impact]
        gaps += found
        changes[leading].append(f"closed{k} * ({moved[0]})")
        for i in range(n):
            changes[n + i].append(f"closed{k} * (({turned[i]}) - v{i})")
    return "\n".join(
        [
            f"u_i {{ {state} }}",
            *lines,
            f"F_i {{ {', '.join([*names[n:], *rates])} }}",
            f"stop_i {{ {', '.join(gaps)} }}",
            f"reset_i {{ {', '.join(' + '.join(each) for each in changes)} }}",
        ]
    )


@lru_cache(maxsize=4)
def compiled(problem: Problem, method: str) -> ds.Ode:
    """The compiled model; tolerances are set later."""
    return ds.Ode(model(problem), matrix_type=ds.nalgebra_dense, ode_solver=METHODS[method])


def prepare(problem: Problem, method: str, tolerances: Tolerances) -> Run:
    """One call of `solve`; two equal times in a row are an impact."""
    ode, nothing = compiled(problem, method), np.array([])

    def run() -> Outcome:
        ode.rtol, ode.atol = tolerances.relative, tolerances.absolute
        motion = ode.solve(nothing, problem.end)
        return Outcome(motion.ys[:, -1], motion.ts[1:][np.diff(motion.ts) == 0.0])

    return run
