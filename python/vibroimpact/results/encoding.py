"""Objects as JSON has them, and back: what pickle would keep, in types that a reader of any language knows; nothing is run.

Lists of numbers and arrays are put aside, and their names stand for them. Numbers come back to the bit: JSON has the shortest
digits that tell a double from its neighbours.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vibroimpact import _core
from vibroimpact._core import Hertz, NonlinearStop, NonlinearSystem, Spring

Arrays = dict[str, np.ndarray[Any, Any]]

#: The formats from which on there are objects of a type, but for those of the first.
_FORMATS: dict[type, int] = {Spring: 2, Hertz: 2}

#: Lists of as many numbers and more are arrays.
_LONG = 8


def pieces(thing: Any) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Return the arguments, by place and by name, from which pickle makes an object again."""
    reduced = thing.__reduce_ex__(4)
    make, arguments = reduced[0], tuple(reduced[1])
    if make.__name__ == "__newobj_ex__":
        return tuple(arguments[1]), dict(arguments[2])
    return (arguments[1:] if make.__name__ == "__newobj__" else arguments), {}


class Encoder:
    """Encodes values, and puts their arrays aside; `made` are the types of results, which Python knows alone."""

    def __init__(self, made: Mapping[str, Any]) -> None:
        self.arrays: Arrays = {}
        #: The least format of what has been encoded.
        self.format = 1
        self._made = made

    def encoded(self, value: Any, where: str) -> Any:
        """Return a value as JSON has it; `where` it stands is said if it cannot be."""
        if value is None or isinstance(value, (bool, str)) or type(value) is int:
            return value
        if type(value) is float:
            return value if np.isfinite(value) else {"float": repr(value)}
        if isinstance(value, np.ndarray) and value.dtype.kind in "biufcUV" and not value.dtype.hasobject:
            return {"array": self._kept(value)}
        if isinstance(value, (list, tuple)):
            return self._sequence(value, where)
        if isinstance(value, dict):
            return {"dict": [[self.encoded(part, where) for part in item] for item in value.items()]}
        if not self._is_ours(value):
            return self.other(value, where)
        return self.known(value, where)

    def known(self, value: Any, where: str) -> Any:
        """Return an object of the library as JSON has it."""
        if isinstance(value, (NonlinearSystem, NonlinearStop)):
            raise _functions(where, f"a {type(value).__name__}, which is given by functions")
        return self.by_arguments(value, where)

    def by_arguments(self, value: Any, where: str) -> Any:
        """Return an object as its type and the arguments that make it again."""
        arguments, keywords = pieces(value)
        self.format = max(self.format, _FORMATS.get(type(value), 1))
        where = f"{where}, {type(value).__name__}"
        return {
            "type": type(value).__name__,
            "arguments": [self.encoded(argument, where) for argument in arguments],
            "keywords": {name: self.encoded(keyword, where) for name, keyword in keywords.items()},
        }

    def other(self, value: Any, where: str) -> Any:
        """Refuse what is no object of the library."""
        if callable(value):
            raise _functions(where, f"{getattr(value, '__name__', value)!r}, a function")
        raise _functions(where, f"an object of type {type(value).__name__}")

    def _is_ours(self, thing: Any) -> bool:
        return getattr(_core, type(thing).__name__, None) is type(thing) or type(thing).__name__ in self._made

    def _kept(self, array: np.ndarray[Any, Any]) -> str:
        """Put an array aside and return its name there."""
        name = f"array_{len(self.arrays)}"
        self.arrays[name] = array
        return name

    def _sequence(self, values: list[Any] | tuple[Any, ...], where: str) -> Any:
        """Return a list or a tuple as JSON has it: long ones of numbers, or of rows of numbers, as arrays, column by column."""
        name = type(values).__name__
        if len(values) >= _LONG:
            if _kind(values):
                return {name: {"array": self._kept(np.array(values))}}
            rows = {(type(row), len(row)) if isinstance(row, (list, tuple)) else None for row in values}
            if len(rows) == 1 and None not in rows:
                columns = list(zip(*values, strict=True))
                if columns and all(_kind(column) for column in columns):
                    names = [self._kept(np.array(column)) for column in columns]
                    return {name: {"rows": type(values[0]).__name__, "columns": names}}
        return {name: [self.encoded(value, where) for value in values]}


def _functions(where: str, what: str) -> ValueError:
    remedy = "pickle the result where the function can be imported, or save its to_arrays()"
    return ValueError(f"{where} has {what}: a file cannot hold it; {remedy}")


def _kind(values: list[Any] | tuple[Any, ...]) -> type | None:
    """Return the one type of numbers that all values have, if it is one that an array holds."""
    kinds = {type(value) for value in values}
    (kind,) = kinds if len(kinds) == 1 else (None,)
    if kind is int and any(not -(2**63) <= value < 2**63 for value in values):
        return None
    return kind if kind in (float, int) else None


def decoded(value: Any, arrays: Arrays, made: Mapping[str, Callable[..., Any]]) -> Any:
    """Return what was encoded; KeyError, TypeError or ValueError of what was not."""
    if not isinstance(value, dict):
        if isinstance(value, list):
            raise TypeError("a list stands where a value should")
        return value
    if "type" in value:
        kind = str(value["type"])
        make = made[kind] if kind in made else _class(kind)
        arguments = [decoded(argument, arrays, made) for argument in value["arguments"]]
        return make(*arguments, **{name: decoded(keyword, arrays, made) for name, keyword in value["keywords"].items()})
    ((kind, content),) = value.items()
    if kind == "float":
        return float(content)
    if kind == "array":
        return arrays[content]
    if kind == "dict":
        return {decoded(key, arrays, made): decoded(item, arrays, made) for key, item in content}
    return {"list": list, "tuple": tuple}[kind](_decoded_items(content, arrays, made))


def _decoded_items(content: Any, arrays: Arrays, made: Mapping[str, Callable[..., Any]]) -> Any:
    if isinstance(content, list):
        return [decoded(item, arrays, made) for item in content]
    if "array" in content:
        return arrays[content["array"]].tolist()
    make = {"list": list, "tuple": tuple}[content["rows"]]
    return [make(row) for row in zip(*(arrays[name].tolist() for name in content["columns"]), strict=True)]


def _class(name: str) -> Callable[..., Any]:
    """Return what makes an object of a class of the core again: that class, or what it restores saved parts by."""
    found = getattr(_core, name)
    if not isinstance(found, type):
        raise TypeError(f"{name} is no type of a scene")
    return getattr(found, "_restore", found)
