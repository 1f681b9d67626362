"""Callables told apart by what a call of them depends on: two with the same name and other code, or other values, are two.

What is told of a function: its code, its defaults, its attributes, what it encloses, and of its module the names that its code
reads, through functions, classes and modules of the user as far as they lead. Of an object: the code of its class and what
pickle keeps of it, which the class may say by `__getstate__` or `__reduce__`. What belongs to a library is told by its name and
by what the installer recorded of the library's files.
"""

from __future__ import annotations

import hashlib
from collections import deque
from collections.abc import Callable
from functools import cached_property
from importlib.machinery import EXTENSION_SUFFIXES
from types import (
    BuiltinFunctionType,
    CellType,
    ClassMethodDescriptorType,
    CodeType,
    FunctionType,
    GetSetDescriptorType,
    MappingProxyType,
    MemberDescriptorType,
    MethodDescriptorType,
    MethodType,
    MethodWrapperType,
    ModuleType,
    WrapperDescriptorType,
)
from typing import Any

import numpy as np

from vibroimpact.run import code_references, libraries

#: Entries of a class that its results do not depend on, or that repeat others.
_BESIDE = frozenset(
    (
        *(
            "__dict__",
            "__weakref__",
            "__doc__",
            "__module__",
            "__qualname__",
            "__abstractmethods__",
            "_abc_impl",
            "__match_args__",
        ),
        *("__annotations__", "__annotate__", "__annotate_func__", "__annotations_cache__", "__parameters__", "__type_params__"),
        *("__orig_bases__", "__firstlineno__", "__static_attributes__", "__dataclass_fields__", "__dataclass_params__"),
    )
)
_OF_A_CLASS = (WrapperDescriptorType, MethodDescriptorType, ClassMethodDescriptorType, GetSetDescriptorType, MemberDescriptorType)
#: Libraries whose objects, where they wrap a function, do what that does.
_WRAPPING = frozenset(("functools", "numba", "jax", "jaxlib"))
_ATOMS = (type(None), bool, int, str, bytes, type(...), type(NotImplemented))


def parts(function: Callable[..., Any], key: str | None = None) -> dict[str, str]:
    """Return digests of all that a call depends on, by name: the same in every process, others for other code or values.

    Parameters
    ----------
    function : callable
        A function, a method, a class, an object that can be called.
    key : str, optional
        What stands for parts that cannot be looked through.

    Raises
    ------
    ValueError
        Without a key, where a part cannot be looked through: a function of an extension module of the user's own, an object of
        which pickle keeps nothing.
    """
    return _Parts(key).of(function)


def fingerprint(function: Callable[..., Any], key: str | None = None) -> str:
    """Return a name and the digest of all ``parts``."""
    return f"{named(function)} {_digest(repr(sorted(parts(function, key).items())))}"


def named(function: Any) -> str:
    """Return the full name of a function, of an object that of its class."""
    name = getattr(function, "__qualname__", None) or type(function).__qualname__
    return f"{getattr(function, '__module__', None) or type(function).__module__}.{name}"


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:32]


class _Parts:
    """The parts of a callable, each written by itself; parts that lead to others name them."""

    def __init__(self, key: str | None) -> None:
        self._key = key
        self._names: dict[tuple[Any, ...], str] = {}
        self._left: deque[tuple[str, Callable[[], str]]] = deque()
        self._alive: list[Any] = []
        self._own: dict[int, int] = {}
        self._where = ""

    def of(self, function: Callable[..., Any]) -> dict[str, str]:
        self._part(("callable",), "callable", lambda: self.text(function))
        found = {}
        while self._left:
            name, write = self._left.popleft()
            self._own, self._where = {}, name
            try:
                found[name] = _digest(write())
            except RecursionError:
                message = f"{name}: its values lie too deep in each other to be told from others"
                raise ValueError(message) from None
        return found

    def _part(self, identity: tuple[Any, ...], name: str, write: Callable[[], str]) -> str:
        """Return the name of a part, which is written later if it is new."""
        if identity not in self._names:
            names = set(self._names.values())
            again = next((f"{name}#{k}" for k in range(2, len(names) + 2) if f"{name}#{k}" not in names), name)
            self._names[identity] = again if name in names else name
            self._left.append((self._names[identity], write))
        return f"<{self._names[identity]}>"

    def text(self, thing: Any) -> str:
        """Return all that tells a value from others; what is told elsewhere by its name."""
        kind = type(thing)
        if kind in _ATOMS:
            return f"{kind.__name__}:{thing!r}"
        if kind in (float, complex):
            return f"{kind.__name__}:{complex(thing).real.hex()},{complex(thing).imag.hex()}"
        if isinstance(thing, CodeType):
            return self._code(thing)
        if isinstance(thing, (FunctionType, ModuleType, type)):
            return self._named(thing)
        if kind is tuple:
            return f"tuple({', '.join(map(self.text, thing))})"
        if kind is frozenset:
            return f"frozenset({', '.join(sorted(map(self.text, thing)))})"
        if kind is MethodType:
            return f"method({self.text(thing.__func__)}, {self.text(thing.__self__)})"
        if isinstance(thing, np.generic) and kind.__module__ == "numpy" and not thing.dtype.hasobject:
            return f"{kind.__name__}:{np.dtype(kind)}:{thing.tobytes().hex()}"
        return self._first(thing) or self._defined(thing)

    def _first(self, thing: Any) -> str | None:
        """Return where in this part a thing was before, None if it was not: what can change is told once."""
        if id(thing) in self._own:
            return f"the {self._own[id(thing)]}th"
        self._own[id(thing)] = len(self._own)
        self._alive.append(thing)
        return None

    def _defined(self, thing: Any) -> str:
        kind = type(thing)
        if kind is list:
            return f"list({', '.join(map(self.text, thing))})"
        if kind is set:
            return f"set({', '.join(sorted(map(self.text, thing)))})"
        if kind in (dict, MappingProxyType):
            return f"dict({', '.join(f'{self.text(a)}: {self.text(b)}' for a, b in thing.items())})"
        if kind is np.ndarray and not thing.dtype.hasobject:
            own = hashlib.sha256(np.ascontiguousarray(thing).tobytes()).hexdigest()
            return f"array({thing.dtype.descr}, {thing.shape}, {thing.flags.f_contiguous}, {own})"
        if kind is CellType:
            return self._cell(thing)
        if isinstance(thing, property):
            return f"property({', '.join(map(self.text, (thing.fget, thing.fset, thing.fdel)))})"
        if isinstance(thing, (classmethod, staticmethod)):
            return f"{kind.__name__}({self.text(thing.__func__)})"
        if kind is cached_property:
            return f"cached_property({self.text(thing.func)})"
        if isinstance(thing, _OF_A_CLASS):
            return f"{kind.__name__}({self.text(thing.__objclass__)}, {thing.__name__!r})"
        if kind is MethodWrapperType or (
            kind is BuiltinFunctionType and not isinstance(thing.__self__, (ModuleType, type(None)))
        ):
            return f"method({thing.__name__!r}, {self.text(thing.__self__)})"
        return self._object(thing)

    def _named(self, thing: Any) -> str:
        """Return the name of a function, a module or a class; of a user's own it is a part."""
        if isinstance(thing, ModuleType):
            if libraries.is_library(thing.__name__):
                return self._library(thing.__name__, thing.__name__)
            return self._part((id(thing),), f"module {thing.__name__}", lambda: self._module(thing))
        name = libraries.by_name(thing)
        if name is not None:
            return self._library(thing.__module__, name)
        self._alive.append(thing)
        write = self._function if isinstance(thing, FunctionType) else self._class
        return self._part((id(thing),), named(thing), lambda: write(thing))

    def _library(self, module: str, name: str) -> str:
        top, recorded = libraries.told(module)
        return f"{name} of {self._part(('library', top), f'library {top}', lambda: recorded)}"

    def _code(self, code: CodeType) -> str:
        """Return what tells code from other code: not where it stands, nor in which lines."""
        counts = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
        names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
        jumps = getattr(code, "co_exceptiontable", b"")
        return f"code({counts}, {names}, {code.co_code.hex()}, {jumps.hex()}, {', '.join(map(self.text, code.co_consts))})"

    def _cell(self, cell: CellType) -> str:
        try:
            return self.text(cell.cell_contents)
        except ValueError:
            if cell != CellType():
                raise
            return "empty"

    def _function(self, function: FunctionType) -> str:
        code = function.__code__
        enclosed = dict(zip(code.co_freevars, function.__closure__ or (), strict=True))
        values = [f"{name}: {self._cell(cell)}" for name, cell in enclosed.items() if not _holds_module(cell)]
        attributes = [f"{name}: {self.text(value)}" for name, value in sorted(vars(function).items())]
        defaults = self.text(function.__defaults__), self.text(function.__kwdefaults__)
        reads = sorted({f"{read.name}: {self._read(read)}" for read in code_references.of(function)})
        return f"function({self._code(code)}, {defaults}, {values}, {attributes}, {reads})"

    def _read(self, read: code_references.Read) -> str:
        """Return what a function reads outside itself."""
        if read.is_missing:
            return "nothing"
        value = read.value
        if isinstance(value, (FunctionType, ModuleType, type)) or read.module is None:
            return self.text(value)
        if libraries.is_library(read.module) and libraries.is_library(type(value).__module__):
            return self._library(read.module, read.name)
        self._alive.append(value)
        return self._part((read.module, read.name, id(value)), read.name, lambda: self.text(value))

    def _class(self, kind: type) -> str:
        entries = [f"{name}: {self.text(value)}" for name, value in sorted(vars(kind).items()) if name not in _BESIDE]
        return f"class({self.text(type(kind))}, {', '.join(map(self.text, kind.__bases__))}, {entries})"

    def _module(self, module: ModuleType) -> str:
        """Return all that a module of the user's own holds."""
        if str(getattr(module, "__file__", None)).endswith(tuple(EXTENSION_SUFFIXES)):
            return self._opaque(module, "it is no Python code")
        each = [
            code_references.Read(f"{module.__name__}.{name}", module.__name__, value)
            for name, value in code_references.public(module)
        ]
        return f"module({', '.join(f'{read.name}: {self._read(read)}' for read in each)})"

    def _object(self, thing: Any) -> str:
        """Return what pickle keeps of an object, and its class."""
        kind = type(thing)
        name = libraries.by_name(thing) if callable(thing) else None
        if name is not None:
            return self._library(name, name)
        if kind.__module__.partition(".")[0] in _WRAPPING and libraries.by_name(kind) is not None:
            inner = getattr(thing, "py_func", getattr(thing, "__wrapped__", None))
            if callable(inner):
                return f"{self.text(kind)}({self.text(inner)}, {self.text(getattr(thing, 'targetoptions', None))})"
        try:
            reduced = thing.__reduce_ex__(4)
        except Exception as error:  # whatever a class says that it cannot be pickled by
            return self._opaque(thing, str(error))
        if isinstance(reduced, str):
            return self._opaque(thing, "it is no Python code")
        make, arguments, state, items, entries, *setter = (*reduced, None, None, None)[: max(len(reduced), 5)]
        told = [make, tuple(arguments), state, items and list(items), entries and list(entries), setter]
        self._alive.append(told)
        return f"object({self.text(kind)}, {', '.join(map(self.text, told))})"

    def _opaque(self, thing: Any, reason: str) -> str:
        if self._key is None:
            what = f"{thing!r} cannot be told from others ({reason})"
            where = "" if self._where == "callable" else f"{self._where}: "
            message = f"{where}{what}; key=, a text of your own for it, stands for what cannot be looked through"
            raise ValueError(message)
        return f"{named(thing)}, for which a key stands"


def _holds_module(cell: CellType) -> bool:
    return cell != CellType() and isinstance(cell.cell_contents, ModuleType)
