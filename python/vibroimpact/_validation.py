"""Numbers that arguments are to be."""

from __future__ import annotations

import reprlib
from typing import Any

import numpy as np

from vibroimpact import _core

#: Of a value in a message: entries of a list, characters of a text.
_short = reprlib.Repr()
_short.maxlist = _short.maxtuple = _short.maxdict = 6
_short.maxstring = _short.maxother = 160


def shown(value: object) -> str:
    """Return a value as Python writes it, long ones cut."""
    return _short.repr(value)


def few(argument: str, value: Any, names: tuple[str, ...]) -> tuple[float, ...]:
    """Return so many numbers."""
    found = _core._numbers(argument, value)
    if found.shape != (len(names),):
        message = f"{argument} is {shown(value)}, but ({', '.join(names)}) is needed"
        raise ValueError(message)
    return tuple(found.tolist())


def finite(argument: str, value: Any) -> float:
    """Return a finite number."""
    found = _core._numbers(argument, value)
    if found.shape != () or not np.isfinite(found):
        message = f"{argument} is {shown(value)}, but it must be a finite number"
        raise ValueError(message)
    return float(found)
