"""Results in files: ``.npz`` archives of arrays with a JSON header; nothing in them is pickled, nothing is run on loading.

The header, the entry "header", says the format, the version of the library that wrote it, the type of the result, its scene and
the arguments from which it is made again. What is long is an entry of its own, to which the header refers. Numbers come back to
the bit: JSON has the shortest digits that tell a double from its neighbours.
"""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from vibroimpact import _core
from vibroimpact._core import NonlinearStop, NonlinearSystem, Orbit, Orbits, Scene, Trajectory
from vibroimpact._results import ArrayResult
from vibroimpact.attractors import Attractor, Attractors
from vibroimpact.basin_plane import Basins, Fit
from vibroimpact.basin_samples import BasinFractions
from vibroimpact.diagram import BifurcationDiagram, PoincarePoints
from vibroimpact.ensemble import Ensemble
from vibroimpact.errors import ConvergenceError
from vibroimpact.existence import ExistenceMap
from vibroimpact.exponents import LyapunovExponents

#: Counts what older libraries cannot read.
FORMAT = 1
HEADER = "header"
#: Lists of as many numbers and more are arrays of the archive.
_LONG = 8

#: What reading a file that is none of ours may raise.
_UNREADABLE = (ValueError, KeyError, EOFError, AttributeError, TypeError, RecursionError, NotImplementedError, zipfile.BadZipFile)

Result = (
    Trajectory
    | Orbit
    | Orbits
    | ExistenceMap
    | Ensemble
    | PoincarePoints
    | BifurcationDiagram
    | LyapunovExponents
    | Attractor
    | Attractors
    | Basins
    | BasinFractions
    | Fit
)

#: What makes a result again from its saved arguments.
_RESULTS: dict[str, Callable[..., Any]] = {
    "Trajectory": _core._restore_trajectory,
    "Orbit": _core._restore_orbit,
    "Orbits": _core._restore_orbits,
    "ExistenceMap": ExistenceMap,
    "Ensemble": Ensemble,
    "PoincarePoints": PoincarePoints,
    "BifurcationDiagram": BifurcationDiagram,
    "LyapunovExponents": LyapunovExponents,
    "Attractor": Attractor,
    "Attractors": Attractors,
    "Basins": Basins,
    "BasinFractions": BasinFractions,
    "Fit": Fit,
}


def save(result: Result | ArrayResult, path: str | os.PathLike[str]) -> None:
    """Write a result to a file, whole or not at all."""
    arrays: dict[str, np.ndarray[Any, Any]] = {}
    arguments, keywords = _pieces(result)
    has_scene = bool(arguments) and isinstance(arguments[0], Scene)
    header = {
        "format": FORMAT,
        "version": _core.__version__,
        "type": type(result).__name__,
        "scene": _encoded(arguments[0], arrays, "scene") if has_scene else None,
        "arguments": [_encoded(argument, arrays, "result") for argument in arguments[has_scene:]],
        "keywords": {name: _encoded(value, arrays, "result") for name, value in keywords.items()},
    }
    path = Path(path)
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as file:
            np.savez(file, **{HEADER: np.array(json.dumps(header, allow_nan=False))}, **arrays)  # type: ignore[arg-type]
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def load(path: str | os.PathLike[str]) -> Result:
    """Read a result from a file that ``save`` wrote.

    Parameters
    ----------
    path : str or path-like
        The file.

    Returns
    -------
    Trajectory, Orbit, Orbits, ExistenceMap, Ensemble, PoincarePoints, BifurcationDiagram, LyapunovExponents, Attractor or
    Attractors
        What was saved, equal to the bit.

    Raises
    ------
    ValueError
        A file that is no result of this library, that was changed or cut, or that has a newer format.
    OSError
        A file that is not there or cannot be read.

    Examples
    --------
    >>> import tempfile, pathlib
    >>> import vibroimpact as vi
    >>> run = vi.simulate(vi.paper_scene(kind=3), [0, 0], [0, 0.1], (0, 20))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run.save(pathlib.Path(folder) / "run.npz")
    ...     again = vi.load(pathlib.Path(folder) / "run.npz")
    >>> bool((again.q == run.q).all()), again.scene == run.scene
    (True, True)
    """
    header, arrays = _read(path)
    try:
        form, version = int(header["format"]), str(header["version"])
    except (KeyError, TypeError, ValueError):
        raise _refused(path, "it is no result of vibroimpact: its header has no format") from None
    if form > FORMAT:
        reason = f"its format {form} is newer than {FORMAT}, the newest that this version reads"
        raise _refused(path, f"{reason}: take vibroimpact {version} or newer")
    try:
        make = _RESULTS[header["type"]]
        scene = [] if header["scene"] is None else [_decoded(header["scene"], arrays)]
        arguments = [_decoded(argument, arrays) for argument in header["arguments"]]
        keywords = {name: _decoded(value, arrays) for name, value in header["keywords"].items()}
        result: Result = make(*scene, *arguments, **keywords)
    except (KeyError, IndexError, TypeError, AttributeError, OverflowError, RecursionError) as error:
        raise _refused(path, f"it was changed: {error!r}") from error
    except (ValueError, ConvergenceError) as error:
        raise _refused(path, f"it was changed: {error}") from error
    return result


def _read(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, np.ndarray[Any, Any]]]:
    """Return the header and the arrays of a file."""
    with Path(path).open("rb") as file:
        try:
            with np.load(file, allow_pickle=False) as archive:
                arrays = {name: archive[name] for name in archive.files}
            header = json.loads(str(arrays.pop(HEADER)))
        except _UNREADABLE as error:
            raise _refused(path, "it is no result of vibroimpact, or was cut") from error
    if not isinstance(header, dict):
        raise _refused(path, "it is no result of vibroimpact: its header is none")
    return header, arrays


def _refused(path: str | os.PathLike[str], reason: str) -> ValueError:
    return ValueError(f"path is {os.fspath(path)!r}, but {reason}")


def _pieces(thing: Any) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """Return the arguments, by place and by name, from which pickle makes an object again."""
    reduced = thing.__reduce_ex__(4)
    make, arguments = reduced[0], tuple(reduced[1])
    if make.__name__ == "__newobj_ex__":
        return tuple(arguments[1]), dict(arguments[2])
    return (arguments[1:] if make.__name__ == "__newobj__" else arguments), {}


def _is_ours(thing: Any) -> bool:
    return getattr(_core, type(thing).__name__, None) is type(thing) or type(thing).__name__ in _RESULTS


def _encoded(value: Any, arrays: dict[str, np.ndarray[Any, Any]], where: str) -> Any:
    """Return a value as JSON has it; long lists and arrays go into `arrays`, and their names stand for them."""
    if value is None or isinstance(value, (bool, str)) or type(value) is int:
        return value
    if type(value) is float:
        return value if np.isfinite(value) else {"float": repr(value)}
    if isinstance(value, np.ndarray) and value.dtype.kind in "biufcUV" and not value.dtype.hasobject:
        return {"array": _kept(value, arrays)}
    if isinstance(value, (list, tuple)):
        return _encoded_sequence(value, arrays, where)
    if isinstance(value, dict):
        return {"dict": [[_encoded(part, arrays, where) for part in item] for item in value.items()]}
    if isinstance(value, (NonlinearSystem, NonlinearStop)):
        raise _functions(where, f"a {type(value).__name__}, which is given by functions")
    if callable(value) and not _is_ours(value):
        raise _functions(where, f"{getattr(value, '__name__', value)!r}, a function")
    if not _is_ours(value):
        raise _functions(where, f"an object of type {type(value).__name__}")
    arguments, keywords = _pieces(value)
    where = f"{where}, {type(value).__name__}"
    return {
        "type": type(value).__name__,
        "arguments": [_encoded(argument, arrays, where) for argument in arguments],
        "keywords": {name: _encoded(keyword, arrays, where) for name, keyword in keywords.items()},
    }


def _functions(where: str, what: str) -> ValueError:
    remedy = "pickle the result where the function can be imported, or save its to_arrays()"
    return ValueError(f"{where} has {what}: a file cannot hold it; {remedy}")


def _kept(array: np.ndarray[Any, Any], arrays: dict[str, np.ndarray[Any, Any]]) -> str:
    """Put an array into the archive and return its name there."""
    name = f"array_{len(arrays)}"
    arrays[name] = array
    return name


def _kind(values: list[Any] | tuple[Any, ...]) -> type | None:
    """Return the one type of numbers that all values have, if it is one that an array holds."""
    kinds = {type(value) for value in values}
    (kind,) = kinds if len(kinds) == 1 else (None,)
    if kind is int and any(not -(2**63) <= value < 2**63 for value in values):
        return None
    return kind if kind in (float, int) else None


def _encoded_sequence(values: list[Any] | tuple[Any, ...], arrays: dict[str, np.ndarray[Any, Any]], where: str) -> Any:
    """Return a list or a tuple as JSON has it: long ones of numbers, or of rows of numbers, as arrays, column by column."""
    name = type(values).__name__
    if len(values) >= _LONG:
        if _kind(values):
            return {name: {"array": _kept(np.array(values), arrays)}}
        rows = {(type(row), len(row)) if isinstance(row, (list, tuple)) else None for row in values}
        if len(rows) == 1 and None not in rows:
            columns = list(zip(*values, strict=True))
            if columns and all(_kind(column) for column in columns):
                names = [_kept(np.array(column), arrays) for column in columns]
                return {name: {"rows": type(values[0]).__name__, "columns": names}}
    return {name: [_encoded(value, arrays, where) for value in values]}


def _decoded(value: Any, arrays: dict[str, np.ndarray[Any, Any]]) -> Any:
    """Return what was encoded; KeyError, TypeError or ValueError of what was not."""
    if not isinstance(value, dict):
        if isinstance(value, list):
            raise TypeError("a list stands where a value should")
        return value
    if "type" in value:
        kind = str(value["type"])
        make = _RESULTS[kind] if kind in _RESULTS else _class(kind)
        arguments = [_decoded(argument, arrays) for argument in value["arguments"]]
        return make(*arguments, **{name: _decoded(keyword, arrays) for name, keyword in value["keywords"].items()})
    ((kind, content),) = value.items()
    if kind == "float":
        return float(content)
    if kind == "array":
        return arrays[content]
    if kind == "dict":
        return {_decoded(key, arrays): _decoded(item, arrays) for key, item in content}
    return {"list": list, "tuple": tuple}[kind](_decoded_items(content, arrays))


def _decoded_items(content: Any, arrays: dict[str, np.ndarray[Any, Any]]) -> Any:
    if isinstance(content, list):
        return [_decoded(item, arrays) for item in content]
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
