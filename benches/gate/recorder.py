"""What stands before the functions of the library and keeps every value of what they return."""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any

import numpy as np
from values import values

import vibroimpact as vi

FUNCTIONS = tuple(name for name in vi.__all__ if callable(getattr(vi, name)) and not isinstance(getattr(vi, name), type))


class Recorder:
    """The values of all calls of one case after the other, by case, place of the call in it, function and name."""

    def __init__(self) -> None:
        """Begin with none."""
        self.kept: dict[str, np.ndarray] = {}
        self.case = ""
        self.calls: Counter[str] = Counter()

    def keep(self, function: str, result: Any) -> None:
        """Take the values of a result, or of the error that came in its place."""
        call = f"{self.case} | {self.calls[self.case]} {function}"
        self.calls[self.case] += 1
        self.kept.update(values(result, call))

    def before(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Stand before a function."""

        @wraps(function)
        def called(*args: Any, **options: Any) -> Any:
            try:
                result = function(*args, **options)
            except Exception as error:
                self.keep(name, error)
                raise
            self.keep(name, result)
            return result

        return called

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Stand before all functions of the library for a while."""
        own = {name: getattr(vi, name) for name in FUNCTIONS}
        for name, function in own.items():
            setattr(vi, name, self.before(name, function))
        try:
            yield
        finally:
            for name, function in own.items():
                setattr(vi, name, function)
