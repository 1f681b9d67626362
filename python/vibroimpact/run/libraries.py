"""What belongs to a library, Python's own or an installed one, whose code is known by its record; all else is a user's."""

from __future__ import annotations

import importlib.metadata
import pickle
import sys
import sysconfig
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from vibroimpact import _core

#: Folders that installers write into, wherever they are.
_INSTALLED = ("site-packages", "dist-packages")
#: The endings of recorded files that are code.
_CODE = (".py", ".so", ".pyd", ".dylib", ".dll")


def is_library(name: str | None) -> bool:
    """Whether a module, by its full name, is one of Python's own or of an installed package."""
    return name is not None and _kind(name.partition(".")[0]) != "user"


def told(name: str) -> tuple[str, str]:
    """Return the library that a module belongs to, and what tells its code from that of other versions."""
    top = name.partition(".")[0]
    kind = _kind(top)
    if kind == "python":
        return "python", "{}.{}".format(*sys.version_info)
    return top, _core.__version__ if top == "vibroimpact" else _recorded(top)


def by_name(thing: Any) -> str | None:
    """Return the name by which a library has a thing; None for what is a user's, or is not found by its name."""
    name = getattr(thing, "__qualname__", None) or getattr(thing, "__name__", None)
    if not isinstance(name, str):
        return None
    module = getattr(thing, "__module__", None)
    if not isinstance(module, str):
        module = pickle.whichmodule(thing, name)  # type: ignore[attr-defined]
    found: Any = sys.modules.get(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    return f"{module}.{name}" if found is thing and is_library(module) else None


def _kind(top: str) -> str:
    """Return whose a module of the first level is: "python", "installed" or "user"."""
    if top in sys.builtin_module_names:
        return "python"
    file = _file(sys.modules.get(top))
    if file is None:
        return "python" if top in sys.stdlib_module_names else "user"
    return _kind_of_file(top, file)


@cache
def _kind_of_file(top: str, file: Path) -> str:
    if top == "vibroimpact" or (any(part in _INSTALLED for part in file.parts) and _owner(top) is not None):
        return "installed"
    own = {Path(sysconfig.get_path(name)).resolve() for name in ("stdlib", "platstdlib")}
    is_own = own & set(file.resolve().parents) and not any(part in _INSTALLED for part in file.parts)
    return "python" if is_own else "user"


def _file(module: ModuleType | None) -> Path | None:
    """Return the file of a module, the folder of a package without one, None for what has none, as what is frozen."""
    spec = getattr(module, "__spec__", None)
    file = getattr(module, "__file__", None) or next(iter(getattr(spec, "submodule_search_locations", None) or ()), None)
    return None if file is None else Path(file)


@cache
def _owner(top: str) -> importlib.metadata.Distribution | None:
    """Return the package that installed a module of the first level, None where none is known."""
    try:
        return importlib.metadata.distribution(top)
    except importlib.metadata.PackageNotFoundError:
        names = importlib.metadata.packages_distributions().get(top, ())
    return importlib.metadata.distribution(names[0]) if names else None


@cache
def _recorded(top: str) -> str:
    """Return what an installer recorded of a package: the digests of its files of code, else its version."""
    owner = _owner(top)
    recorded = (owner.files if owner else None) or ()
    files = sorted(f"{file} {file.hash.value}" for file in recorded if file.hash and file.name.endswith(_CODE))
    return "\n".join(files) or (owner.version if owner else "of no version")
