"""What a case finds: a quantity beside its reference, and the verdict by one of the rules."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpmath import mp, mpf

from report.extremes.condition import Truth

EPSILON = 2.0**-52
FACTOR = 100  # of both rules for numbers


@dataclass(frozen=True)
class Rule:
    """A unit of error of which a hundred are allowed, times the condition number."""

    name: str
    unit: float

    def allows(self, condition: float) -> float:
        """Largest error that holds at a condition number."""
        return FACTOR * max(condition, 1.0) * self.unit


ROUNDING = Rule("rounding", EPSILON)


def stepped(rtol: float) -> Rule:
    """Rule of what is integrated, or completed, to a tolerance."""
    return Rule("steps", rtol)


@dataclass(frozen=True)
class Finding:
    """One line of the page; ``error``, ``condition`` and ``allowed`` are None where the answer is no number."""

    quantity: str
    method: str
    rule: str
    computed: str
    reference: str
    holds: bool
    error: float | None = None
    condition: float | None = None
    allowed: float | None = None


def measured(quantity: str, method: str, computed: Sequence[Any], truth: Truth, rule: Rule) -> Finding:
    """Compare numbers with their truth: the part that comes closest to what it is allowed, or passes it furthest."""
    if [np.size(part) for part in computed] != [len(part) for part in truth.parts]:
        counts = " + ".join(str(np.size(part)) for part in computed), " + ".join(str(len(part)) for part in truth.parts)
        return Finding(quantity, method, rule.name, f"{counts[0]} values", f"{counts[1]} values", False)
    lines = []
    for part, expected, condition in zip(computed, truth.parts, truth.conditions, strict=True):
        differences = [abs(mpf(float(x)) - y) for x, y in zip(np.ravel(part), expected, strict=True)]
        differences = [mp.inf if mp.isnan(each) else each for each in differences]
        worst = max(range(len(differences)), key=differences.__getitem__)
        error, allowed = float(differences[worst] / size(expected)), rule.allows(condition)
        shown = f"{float(np.ravel(part)[worst]):.6g}", f"{float(expected[worst]):.6g}"
        lines.append(Finding(quantity, method, rule.name, *shown, error <= allowed, error, condition, allowed))
    return max(lines, key=lambda line: line.error / line.allowed)


def size(part: Sequence[mpf]) -> mpf:
    """What errors of a part are relative to: its largest entry; one where all of them are zero."""
    return max(abs(x) for x in part) or mpf(1)


def fact(quantity: str, method: str, computed: object, reference: object) -> Finding:
    """Compare what is no number: a count, a status, an order."""
    return Finding(quantity, method, "fact", brief(computed), brief(reference), computed == reference)


def brief(value: object, most: int = 100) -> str:
    """A value in words, cut where it is long."""
    words = " ".join(str(value).split())
    return words if len(words) <= most else words[:most] + " ..."


def refused(quantity: str, call: Callable[[], object], argument: str, rule: str) -> Finding:
    """Call with bad input: a ValueError is due whose message has the argument and the rule."""
    expected = f"ValueError with `{argument}` and `{rule}`"
    try:
        result = call()
    except ValueError as error:
        return Finding(quantity, "", "refusal", str(error), expected, argument in str(error) and rule in str(error))
    except Exception as error:
        return Finding(quantity, "", "refusal", f"{type(error).__name__}: {error}", expected, False)
    return Finding(quantity, "", "refusal", brief(f"accepted: {result}"), expected, False)


def short(number: float) -> str:
    """Two digits."""
    return f"{float(number):.1e}"
