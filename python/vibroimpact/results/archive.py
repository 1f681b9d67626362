"""Results in files: ``.npz`` archives of arrays with a JSON header; nothing in them is pickled, nothing is run on loading.

The header, the entry "header", says the format, the version of the library that wrote it, the type of the result, its scene and
the arguments from which it is made again. What is long is an entry of its own, to which the header refers.
"""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from vibroimpact import _core
from vibroimpact._core import Orbit, Orbits, Scene, Trajectory
from vibroimpact.errors import ConvergenceError
from vibroimpact.results import encoding
from vibroimpact.results.record import RESULTS, Record

#: Counts what older libraries cannot read; a file has the least format that its contents need.
FORMAT = 2
HEADER = "header"
Result = Trajectory | Orbit | Orbits | Record


def _checked(restore: Callable[..., Trajectory | Orbit]) -> Callable[..., Trajectory | Orbit]:
    """Return what restores a motion and refuses one that its scene cannot have."""

    def restored(*arguments: Any) -> Trajectory | Orbit:
        motion = restore(*arguments)
        motion._check_kept()
        return motion

    return restored


#: What makes a motion again from its saved arguments.
_MOTIONS: dict[str, Callable[..., Any]] = {
    "Trajectory": _checked(_core._restore_trajectory),
    "Orbit": _checked(_core._restore_orbit),
    "Orbits": _core._restore_orbits,
}


def save(result: Result, path: str | os.PathLike[str]) -> None:
    """Write a result to a file, whole or not at all."""
    encoder = encoding.Encoder(_MOTIONS | RESULTS)
    arguments, keywords = encoding.pieces(result)
    has_scene = bool(arguments) and isinstance(arguments[0], Scene)
    header = {
        "version": _core.__version__,
        "type": type(result).__name__,
        "scene": encoder.encoded(arguments[0], "scene") if has_scene else None,
        "arguments": [encoder.encoded(argument, "result") for argument in arguments[has_scene:]],
        "keywords": {name: encoder.encoded(value, "result") for name, value in keywords.items()},
    }
    header["format"] = encoder.format
    path = Path(path)
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as file:
            np.savez(file, **{HEADER: np.array(json.dumps(header, allow_nan=False))}, **encoder.arrays)  # type: ignore[arg-type]
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def read(path: str | os.PathLike[str]) -> Result:
    """Return the result that a file holds."""
    header, arrays = _read(path)
    try:
        form, version = int(header["format"]), str(header["version"])
    except (KeyError, TypeError, ValueError, OverflowError):
        raise refused(path, "it is no result of vibroimpact: its header has no format") from None
    if form > FORMAT:
        reason = f"its format {form} is newer than {FORMAT}, the newest that this version reads"
        raise refused(path, f"{reason}: take vibroimpact {version} or newer")
    try:
        known = _MOTIONS | RESULTS
        make = known[header["type"]]
        scene = [] if header["scene"] is None else [encoding.decoded(header["scene"], arrays, known)]
        arguments = [encoding.decoded(argument, arrays, known) for argument in header["arguments"]]
        keywords = {name: encoding.decoded(value, arrays, known) for name, value in header["keywords"].items()}
        result: Result = make(*scene, *arguments, **keywords)
    except (ValueError, ConvergenceError) as error:
        raise refused(path, f"it was changed: {error}") from error
    except Exception as error:
        raise refused(path, f"it was changed: {error!r}") from error
    return result


def _read(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, np.ndarray[Any, Any]]]:
    """Return the header and the arrays of a file."""
    with Path(path).open("rb") as file:
        try:
            with np.load(file, allow_pickle=False) as archive:
                arrays = {name: archive[name] for name in archive.files}
            header = json.loads(str(arrays.pop(HEADER)))
        except Exception as error:  # whatever NumPy makes of bytes that are no file of its own
            if isinstance(error, OSError) and error.errno not in (None, errno.EINVAL):
                raise
            raise refused(path, "it is no result of vibroimpact, or was changed or cut") from error
    if not isinstance(header, dict):
        raise refused(path, "it is no result of vibroimpact: its header is none")
    return header, arrays


def refused(path: str | os.PathLike[str], reason: str) -> ValueError:
    """Return the error of a path that is no result."""
    return ValueError(f"path is {os.fspath(path)!r}, but {reason}")
