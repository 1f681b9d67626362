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

from vibroimpact import _core, _json, _store, basin_plane, existence
from vibroimpact._cells import Columns
from vibroimpact._core import Orbit, Orbits, Scene, Trajectory
from vibroimpact._results import ArrayResult
from vibroimpact.attractors import Attractor, Attractors
from vibroimpact.basin_plane import Basins, Fit
from vibroimpact.basin_samples import BasinFractions
from vibroimpact.branch import Branch
from vibroimpact.curve import BifurcationCurve, CurvePoint
from vibroimpact.derivative import Derivatives
from vibroimpact.diagram import BifurcationDiagram, PoincarePoints
from vibroimpact.ensemble import Ensemble
from vibroimpact.errors import ConvergenceError
from vibroimpact.existence import ExistenceMap
from vibroimpact.exponents import LyapunovExponents
from vibroimpact.special import Candidate, Special
from vibroimpact.tree import BranchTree
from vibroimpact.verdict import Beyond

#: Counts what older libraries cannot read.
FORMAT = 1
HEADER = "header"
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
    | Branch
    | Beyond
    | BifurcationCurve
    | CurvePoint
    | BranchTree
    | Candidate
    | Special
    | Derivatives
    | Fit
)


def _checked(restore: Callable[..., Any], check: Callable[[Any], None]) -> Callable[..., Any]:
    """Return what restores a motion and refuses one that its scene cannot have."""

    def restored(*arguments: Any) -> Any:
        motion = restore(*arguments)
        check(motion)
        return motion

    return restored


#: What makes a result again from its saved arguments.
RESULTS: dict[str, Callable[..., Any]] = {
    "Trajectory": _checked(_core._restore_trajectory, _core._check_trajectory),
    "Orbit": _checked(_core._restore_orbit, _core._check_orbit),
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
    "Branch": Branch,
    "Beyond": Beyond,
    "BifurcationCurve": BifurcationCurve,
    "CurvePoint": CurvePoint,
    "BranchTree": BranchTree,
    "Candidate": Candidate,
    "Special": Special,
    "Derivatives": Derivatives,
    "Fit": Fit,
}

#: What makes a result from what a store holds.
_STORED: dict[str, Callable[..., Any]] = {"Basins": basin_plane.from_store, "ExistenceMap": existence.from_store}
_COLUMNS: dict[str, Columns] = {"Basins": basin_plane.COLUMNS, "ExistenceMap": existence.COLUMNS}


def save(result: Result | ArrayResult, path: str | os.PathLike[str]) -> None:
    """Write a result to a file, whole or not at all."""
    encoder = _json.Encoder(RESULTS)
    arguments, keywords = _json.pieces(result)
    has_scene = bool(arguments) and isinstance(arguments[0], Scene)
    header = {
        "format": FORMAT,
        "version": _core.__version__,
        "type": type(result).__name__,
        "scene": encoder.encoded(arguments[0], "scene") if has_scene else None,
        "arguments": [encoder.encoded(argument, "result") for argument in arguments[has_scene:]],
        "keywords": {name: encoder.encoded(value, "result") for name, value in keywords.items()},
    }
    path = Path(path)
    part = path.with_name(path.name + ".part")
    try:
        with part.open("wb") as file:
            np.savez(file, **{HEADER: np.array(json.dumps(header, allow_nan=False))}, **encoder.arrays)  # type: ignore[arg-type]
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def load(path: str | os.PathLike[str]) -> Result:
    """Read a result from a file that ``save`` wrote.

    Parameters
    ----------
    path : str or path-like
        The file, or the folder of a store of ``basins`` or ``existence_map``, finished or not.

    Returns
    -------
    Trajectory, Orbit, Orbits, ExistenceMap, Ensemble, PoincarePoints, BifurcationDiagram, LyapunovExponents, Attractor,
    Attractors, Basins, BasinFractions, Branch, Beyond, BranchTree, BifurcationCurve, CurvePoint, Candidate, Special,
    Derivatives or Fit
        What was saved, equal to the bit.

    Raises
    ------
    ValueError
        A file or folder that is no result of this library, that was changed or cut, or that has a newer format; a motion that
        is none of its scene: it jumps, passes a stop, has not its impacts, or these are against the law of their stop, by more
        than a hundredth of the sizes of its terms. A store of basins of a scene made of functions, which the same call of
        ``basins`` opens.
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
    if Path(path).is_dir():
        return _stored(path)
    header, arrays = _read(path)
    try:
        form, version = int(header["format"]), str(header["version"])
    except (KeyError, TypeError, ValueError, OverflowError):
        raise _refused(path, "it is no result of vibroimpact: its header has no format") from None
    if form > FORMAT:
        reason = f"its format {form} is newer than {FORMAT}, the newest that this version reads"
        raise _refused(path, f"{reason}: take vibroimpact {version} or newer")
    try:
        make = RESULTS[header["type"]]
        scene = [] if header["scene"] is None else [_json.decoded(header["scene"], arrays, RESULTS)]
        arguments = [_json.decoded(argument, arrays, RESULTS) for argument in header["arguments"]]
        keywords = {name: _json.decoded(value, arrays, RESULTS) for name, value in header["keywords"].items()}
        result: Result = make(*scene, *arguments, **keywords)
    except (ValueError, ConvergenceError) as error:
        raise _refused(path, f"it was changed: {error}") from error
    except Exception as error:
        raise _refused(path, f"it was changed: {error!r}") from error
    return result


def _stored(path: str | os.PathLike[str]) -> Result:
    """Return what a store holds."""
    kind, contents, arrays = _store.contents(path, _COLUMNS)
    try:
        result: Result = _STORED[kind](contents, arrays)
    except Exception as error:
        raise _refused(path, f"it was changed: {error!r}") from error
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
            raise _refused(path, "it is no result of vibroimpact, or was changed or cut") from error
    if not isinstance(header, dict):
        raise _refused(path, "it is no result of vibroimpact: its header is none")
    return header, arrays


def _refused(path: str | os.PathLike[str], reason: str) -> ValueError:
    return ValueError(f"path is {os.fspath(path)!r}, but {reason}")
