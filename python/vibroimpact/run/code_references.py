"""What the code of a function reads outside itself: names of its module, attributes of modules, what it imports."""

from __future__ import annotations

import builtins
import dis
import importlib
import importlib.util
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from types import CodeType, FunctionType, ModuleType
from typing import Any

_MISSING = object()
#: Instructions that read a name of the module, or of what runs it.
_GLOBAL = ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS")
#: Those that read what a function encloses.
_ENCLOSED = ("LOAD_DEREF", "LOAD_CLASSDEREF", "LOAD_FROM_DICT_OR_DEREF")
_ATTRIBUTE = ("LOAD_ATTR", "LOAD_METHOD")
#: What reads names that stand in no instruction: all names of the module are read then.
_BY_NAME = ("eval", "exec", "globals", "compile", "vars")


@dataclass(frozen=True)
class Read:
    """A name that is read, the module that it is of (None: of Python's own names, or enclosed), and what it holds."""

    name: str
    module: str | None
    value: Any

    @property
    def is_missing(self) -> bool:
        """Whether there is no such name."""
        return self.value is _MISSING


def public(module: ModuleType) -> list[tuple[str, Any]]:
    """Return the names of a module with what they hold, without those that the import system sets."""
    return sorted((name, value) for name, value in vars(module).items() if not (name.startswith("__") and name.endswith("__")))


def of(function: FunctionType) -> Iterator[Read]:
    """Iterate over what the code of a function reads, that of functions within it too."""
    enclosed = {}
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        try:
            enclosed[name] = cell.cell_contents
        except ValueError:  # an empty cell
            continue
    yield from _of_code(function.__code__, function.__globals__, enclosed)


def _of_code(code: CodeType, names: dict[str, Any], enclosed: dict[str, Any]) -> Iterator[Read]:
    own = str(names.get("__name__", "?"))
    instructions = [one for one in dis.get_instructions(code) if one.opname != "EXTENDED_ARG"]
    for i, one in enumerate(instructions):
        if one.opname in _GLOBAL:
            yield from _along(_global(str(one.argval), names, own), instructions[i + 1 :])
            if one.argval in _BY_NAME and one.argval not in names:
                yield from (_global(name, names, own) for name in sorted(names) if not name.startswith("__"))
        elif one.opname in _ENCLOSED and isinstance(enclosed.get(one.argval), ModuleType):
            yield from _along(Read(str(one.argval), None, enclosed[one.argval]), instructions[i + 1 :])
        elif one.opname == "IMPORT_NAME":
            yield from _imported(str(one.argval), instructions[i - 2].argval, instructions[i - 1].argval, names)
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _of_code(inner, names, enclosed)


def _global(name: str, names: dict[str, Any], own: str) -> Read:
    """Return a name of the module, or of those that every module has."""
    if name in names:
        return Read(f"{own}.{name}", own, names[name])
    has = names.get("__builtins__", builtins)
    value = (has if isinstance(has, dict) else vars(has)).get(name, _MISSING)
    return Read(f"{own}.{name}" if value is _MISSING else name, None, value)


def _along(read: Read, rest: list[dis.Instruction]) -> Iterator[Read]:
    """Follow the attributes of modules that are read next, as ``package.module.function``."""
    for one in rest:
        if not isinstance(read.value, ModuleType) or one.opname not in _ATTRIBUTE:
            break
        name = read.value.__name__
        read = Read(f"{name}.{one.argval}", name, getattr(read.value, str(one.argval), _MISSING))
    yield read


def _imported(name: str, level: Any, wanted: Any, names: dict[str, Any]) -> Iterator[Read]:
    """Return what a function imports: names of a module, or the whole of it."""
    if level:
        name = importlib.util.resolve_name("." * int(level) + name, str(names.get("__package__") or ""))
    module = _module(name)
    for each in wanted or ():
        own = getattr(module, str(each), _MISSING)
        yield Read(f"{name}.{each}", name, _module(f"{name}.{each}") if own is _MISSING else own)
    if not wanted:
        for each in dict.fromkeys((name, name.partition(".")[0])):
            yield Read(each, None, _module(each))


def _module(name: str) -> Any:
    """Return a module, which the function would import; nothing where there is none."""
    try:
        return sys.modules.get(name) or importlib.import_module(name)
    except ImportError:
        return _MISSING
