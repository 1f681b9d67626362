"""A call whose arguments do not fit is answered with those that a function takes."""

import difflib
import functools
import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ParamSpec, TypeVar

from vibroimpact import _core

P = ParamSpec("P")
R = TypeVar("R")


def _misfit(function: Callable[..., Any], arguments: tuple[Any, ...], named: Mapping[str, Any]) -> str | None:
    """Return what is wrong with the arguments of a call, if more is to be said of it than Python does."""
    taken = inspect.signature(function).parameters
    strangers = [given for given in named if given not in taken]
    if strangers:
        return _core._unknown(f"{function.__name__}()", strangers[0], list(taken))
    placed = [name for name, one in taken.items() if one.kind is not one.KEYWORD_ONLY]
    if len(arguments) <= len(placed):
        return None
    written = [re.search(rf"^ *{name} : .*", function.__doc__ or "", re.MULTILINE) for name in placed]
    places = "; ".join(own[0].strip() if own else name for name, own in zip(placed, written, strict=True))
    rest = ", ".join(name for name in taken if name not in placed)
    by_name = f"; by name {rest}" if rest else ""
    return f"{function.__name__}() is given {len(arguments)} arguments by place, and takes {len(placed)}: {places}{by_name}"


def no_name(module: str, given: str, names: Sequence[str]) -> AttributeError:
    """Return the error of a module without a name, with those that are near."""
    low = given.lower()
    near = [own for own in names if low in own.lower() or own.lower() in low] or difflib.get_close_matches(given, names, 3)
    meant = f"; is {' or '.join(near[:3])} meant?" if near else ""
    return AttributeError(f"module {module!r} has no attribute {given!r}{meant}", name=given)


def answered(function: Callable[P, R]) -> Callable[P, R]:
    """Return the function with an answer to calls that do not fit it."""

    @functools.wraps(function)
    def called(*arguments: P.args, **named: P.kwargs) -> R:
        try:
            return function(*arguments, **named)
        except TypeError:
            misfit = _misfit(function, arguments, named)
            if misfit is None:
                raise
        raise TypeError(misfit)

    called.__module__ = "vibroimpact"  # where pickle finds it
    return called
