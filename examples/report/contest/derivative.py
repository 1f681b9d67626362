"""Derivatives of formulas, written out as formulas: what implicit methods are given as their Jacobian.

Each line of a formula has its derivatives by the arguments that are asked for, from those of what it takes (forward, by the rules
of sums, products, quotients, sines and cosines); what is zero, or not needed, leaves no line.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import Any

from .formulas import Traced, cos, needed, sin, traced

Slopes = list[Any]

VALUES: dict[str, Callable[..., Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "sin": sin,
    "cos": cos,
}
#: Derivative of a line, from its value, its operands and their derivatives.
RULES: dict[str, Callable[..., Any]] = {
    "+": lambda _, a, b, da, db: da + db,
    "-": lambda _, a, b, da, db: da - db,
    "*": lambda _, a, b, da, db: da * b + a * db,
    "/": lambda c, a, b, da, db: (da - c * db) / b,
    "sin": lambda _, a, da: da * cos(a),
    "cos": lambda _, a, da: da * sin(a) * -1,
}


def derivatives(formula: Traced, by: Sequence[str]) -> Traced:
    """Derivatives of a formula's results by some of its arguments, result after result."""
    none: Slopes = [0] * len(by)

    def entries(*arguments: Any) -> list[Any]:
        values = dict(zip(formula.arguments, arguments, strict=True))
        slopes = {name: [int(name == each) for each in by] for name in formula.arguments}
        for line in formula.lines:
            operands = [values[each] if isinstance(each, str) else each for each in line.operands]
            columns = [slopes[each] if isinstance(each, str) else none for each in line.operands]
            value = values[line.name] = VALUES[line.operation](*operands)
            rule = RULES[line.operation]
            slopes[line.name] = [rule(value, *operands, *each) for each in zip(*columns, strict=True)]
        rows = [slopes[each] if isinstance(each, str) else none for each in formula.results]
        return [entry for row in rows for entry in row]

    return needed(traced(entries, formula.arguments))
