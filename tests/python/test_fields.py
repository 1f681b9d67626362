"""Every field of every result says its shape and its unit where a reader looks: in its docstring, which the site shows."""

import dataclasses
import re

import numpy as np
import pytest
from test_saved import OBJECTS


def fields(thing):
    """Names of what a result has."""
    kind = type(thing)
    named = [own.name for own in dataclasses.fields(kind)] if dataclasses.is_dataclass(kind) else []
    return [
        *named,
        *(name for name in dir(kind) if not name.startswith("_") and not callable(getattr(kind, name)) and name not in named),
    ]


def text_of(kind, name):
    """What is written about a field: its own docstring, or its entry among the attributes of its class."""
    own = vars(kind).get(name)
    if own is not None and type(own).__name__ in ("property", "getset_descriptor", "cached_property"):
        return own.__doc__ or ""
    entry = re.search(rf"^    (?:\w+, )*{name}(?:, \w+)* : .*\n(?:        .*\n)+", kind.__doc__ or "", re.MULTILINE)
    return entry.group(0) if entry else ""


@pytest.mark.parametrize("name", OBJECTS)
def test_fields_say_shape_and_unit(name):
    thing = OBJECTS[name]
    for field in fields(thing):
        try:
            value = getattr(thing, field)
        except ValueError:  # what this one did not keep
            continue
        text = text_of(type(thing), field)
        assert text.strip(), f"{field} is not documented"
        if isinstance(value, np.ndarray) and not value.dtype.names:
            assert "shape" in text, f"{field} has no shape: {text}"
        if isinstance(value, float | complex) or (
            isinstance(value, np.ndarray) and (value.dtype.names or value.dtype.kind in "fc")
        ):
            assert re.search(r"\[[^\]]+\]", text), f"{field} has no unit: {text}"
