"""Formulas as straight lines of operations: written once with numbers and symbols, read by every contestant in its own form.

A formula is a Python function of symbols. `traced` runs it and keeps each operation as one line, `x7 = x2 * x5`, and so the
same formula becomes a function of floats, of arrays, of heyoka's expressions, a Numba function, lines of another language or
a recurrence of Taylor coefficients.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Formula = Callable[..., Sequence[Any]]


@dataclass(frozen=True)
class Line:
    """One operation: the name it defines, the operation, and what it takes (names and numbers)."""

    name: str
    operation: str
    operands: tuple[Any, ...]

    def text(self, number: Callable[[Any], str] = repr) -> str:
        """The right-hand side, as Python and most languages write it."""
        words = [each if isinstance(each, str) else f"({number(each)})" for each in self.operands]
        return f"{self.operation}({words[0]})" if len(words) == 1 else f"{words[0]} {self.operation} {words[1]}"


class Tape:
    """The lines of a formula, in order; an operation that is there is not written again."""

    def __init__(self) -> None:
        self.lines: list[Line] = []
        self.known: dict[tuple[Any, ...], Symbol] = {}

    def put(self, operation: str, *operands: Any) -> Symbol:
        """Write one line and return the symbol that it defines."""
        names = tuple(each.name if isinstance(each, Symbol) else each for each in operands)
        key = (operation, frozenset(names)) if operation in "+*" else (operation, *names)
        if key not in self.known:
            self.known[key] = Symbol(self, f"x{len(self.lines)}")
            self.lines.append(Line(self.known[key].name, operation, names))
        return self.known[key]


@dataclass(frozen=True)
class Symbol:
    """A value not known yet; products with 0 and 1 and sums with 0 leave no line."""

    tape: Tape
    name: str

    def __add__(self, other: Any) -> Any:
        """Sum."""
        return self if is_number(other, 0) else self.tape.put("+", self, other)

    def __sub__(self, other: Any) -> Any:
        """Difference."""
        return self if is_number(other, 0) else self.tape.put("-", self, other)

    def __mul__(self, other: Any) -> Any:
        """Product."""
        if is_number(other, 0):
            return other
        return self if is_number(other, 1) else self.tape.put("*", self, other)

    def __truediv__(self, other: Any) -> Any:
        """Quotient."""
        return self if is_number(other, 1) else self.tape.put("/", self, other)

    __radd__ = __add__
    __rmul__ = __mul__

    def __rsub__(self, other: Any) -> Any:
        """Difference from a number."""
        return self.tape.put("-", other, self)

    def __rtruediv__(self, other: Any) -> Any:
        """Quotient of a number."""
        return self.tape.put("/", other, self)

    def __neg__(self) -> Any:
        """The value with the other sign."""
        return self * -1


def is_number(value: Any, number: int) -> bool:
    """Whether a value is known and is that number."""
    return not isinstance(value, Symbol) and value == number


def sin(angle: Any) -> Any:
    """Sine of a symbol or a number."""
    return angle.tape.put("sin", angle) if isinstance(angle, Symbol) else math.sin(angle)


def cos(angle: Any) -> Any:
    """Cosine of a symbol or a number."""
    return angle.tape.put("cos", angle) if isinstance(angle, Symbol) else math.cos(angle)


@dataclass(frozen=True)
class Traced:
    """A formula written out: names of its arguments, its lines, and its results (names and numbers)."""

    arguments: tuple[str, ...]
    lines: tuple[Line, ...]
    results: tuple[Any, ...]

    def source(self, name: str) -> str:
        """The formula as a Python function that returns a tuple."""
        body = [f"    {line.name} = {line.text()}" for line in self.lines]
        results = ", ".join(each if isinstance(each, str) else repr(each) for each in self.results)
        return "\n".join([f"def {name}({', '.join(self.arguments)}):", *body, f"    return ({results},)"]) + "\n"

    def function(self, functions: Mapping[str, Any] | None = None) -> Callable[..., tuple[Any, ...]]:
        """The formula as a Python function, its `sin` and `cos` those given: of floats, if none are."""
        space: dict[str, Any] = dict(functions or {"sin": math.sin, "cos": math.cos})
        exec(self.source("formula"), space)  # the text is made above of names, numbers and operations alone
        return space["formula"]


def needed(formula: Traced) -> Traced:
    """The formula without the lines that its results do not need."""
    wanted, kept = set(formula.results), []
    for line in reversed(formula.lines):
        if line.name in wanted:
            wanted.update(line.operands)
            kept.append(line)
    return Traced(formula.arguments, tuple(reversed(kept)), formula.results)


def traced(formula: Formula, arguments: Sequence[str]) -> Traced:
    """Write a formula out; it is called with one symbol for each argument."""
    tape = Tape()
    results = formula(*(Symbol(tape, name) for name in arguments))
    return Traced(tuple(arguments), tuple(tape.lines), tuple(each.name if isinstance(each, Symbol) else each for each in results))
