"""Numbers that arguments are to be."""

from __future__ import annotations

from typing import Any

import numpy as np

from vibroimpact import _core


def few(argument: str, value: Any, names: tuple[str, ...]) -> tuple[float, ...]:
    """Return so many numbers."""
    found = _core._numbers(argument, value)
    if found.shape != (len(names),):
        message = f"{argument} is {value!r}, but ({', '.join(names)}) is needed"
        raise ValueError(message)
    return tuple(found.tolist())


def finite(argument: str, value: Any) -> float:
    """Return a finite number."""
    found = _core._numbers(argument, value)
    if found.shape != () or not np.isfinite(found):
        message = f"{argument} is {value!r}, but it must be a finite number"
        raise ValueError(message)
    return float(found)
