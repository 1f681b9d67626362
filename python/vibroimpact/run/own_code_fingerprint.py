"""Functions told apart by their own code, as stores up to version 0.2.0 have them: for going on with those.

What a function reads from its module, or calls there, was not looked at, nor the code of classes, or what a wrapper of C holds.
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable
from functools import partial
from types import CodeType, FunctionType, MethodType
from typing import Any


def was_told(function: Callable[..., Any]) -> bool:
    """Whether the own code of a callable was looked at: of functions, methods and partials of them, not of other objects."""
    while isinstance(function, partial):
        function = function.func
    return isinstance(function, (FunctionType, MethodType))


def fingerprint(function: Callable[..., Any]) -> str:
    """Return a name and the digest of a function's code, defaults and enclosed values.

    Raises
    ------
    ValueError
        An object with a part that cannot be pickled.
    """
    name = f"{getattr(function, '__module__', '')}.{getattr(function, '__qualname__', type(function).__qualname__)}"
    return f"{name} {hashlib.sha256(_told(function, ()).encode()).hexdigest()}"


def _told(thing: Any, around: tuple[int, ...]) -> str:
    """Return all that tells a thing from others, as a text; what is around it is not told again."""
    if id(thing) in around:
        return f"the {around.index(id(thing))}th around"
    around = (*around, id(thing))
    if isinstance(thing, FunctionType):
        enclosed = [cell.cell_contents for cell in thing.__closure__ or ()]
        name: list[Any] = [thing.__module__, thing.__qualname__]
        parts = [*name, thing.__code__, thing.__defaults__, thing.__kwdefaults__, *enclosed]
    elif isinstance(thing, CodeType):
        parts = [thing.co_code, thing.co_names, thing.co_varnames[: thing.co_argcount], *thing.co_consts]
    elif isinstance(thing, MethodType):
        parts = [thing.__func__, thing.__self__]
    elif isinstance(thing, partial):
        parts = [thing.func, *thing.args, thing.keywords]
    elif isinstance(thing, (list, tuple)):
        parts = list(thing)
    elif isinstance(thing, dict):
        parts = [*map(list, thing.items())]
    elif isinstance(thing, (set, frozenset)):
        parts = sorted(_told(one, around) for one in thing)
    else:
        return f"{type(thing).__qualname__}:{_pickled(thing)}"
    return f"{type(thing).__name__}({', '.join(_told(part, around) for part in parts)})"


def _pickled(thing: Any) -> str:
    try:
        return pickle.dumps(thing, protocol=5).hex()
    except (TypeError, AttributeError, pickle.PicklingError) as error:
        message = f"{thing!r} cannot be told from others: {error}"
        raise ValueError(message) from None
