"""Stores: results over a plane that are written while they are worked out, and gone on with by the same call again.

A store is a group of zarr. Its attributes say what it was made with, its arrays hold what was found; one of them, written last in
each chunk, says where something was.
"""

from __future__ import annotations

import base64
import hashlib
import json
import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vibroimpact import _core, _fingerprint, _json, _own_code
from vibroimpact._tiles import Tile, tile_shape

#: Counts what older libraries cannot read.
FORMAT = 1

#: Cells of a chunk: so many at least, and no more chunks than these.
_CELLS, _CHUNKS = 1 << 14, 1 << 10


def check_options(overwrite: object, key: object) -> None:
    """Refuse an `overwrite` that is neither True nor False, a `key` that is no text."""
    if not isinstance(overwrite, bool):
        message = f"overwrite is {overwrite!r}, but True or False is needed"
        raise TypeError(message)
    if not isinstance(key, (str, type(None))):
        message = f"key is {key!r}, but a text is needed, or None"
        raise TypeError(message)


class Store:
    """Arrays over the cells of a plane, shape (ny, nx), written chunk by chunk.

    `key` stands for code that cannot be looked through.

    Raises
    ------
    ValueError
        A file, a folder or a group with something else in it, a store that other arguments have made.
    ImportError
        Without zarr.
    """

    def __init__(
        self,
        store: Any,
        kind: str,
        arguments: dict[str, Any],
        axes: dict[str, NDArray[np.float64]],
        columns: dict[str, tuple[str, Any]],
        *,
        overwrite: bool,
        key: str | None = None,
    ) -> None:
        self._zarr, self._store, self._name = _zarr(), store, _shown(store)
        keyed = arguments if key is None else arguments | {"key": key}
        made = _made(kind, {name: _told(name, value, _Arguments(key)) for name, value in keyed.items()})
        group = _opened(self._zarr, store)
        if group is not None and key is None:
            self._take_over(group, made, arguments)
        is_other = group is not None and self._is_other(dict(group.attrs), made, overwrite)
        if group is None or is_other:
            group = self._created(made, is_other)
        self._group = group
        ny, nx = axes["y"].size, axes["x"].size
        self.cells = max(_CELLS, -(-nx * ny // _CHUNKS))
        wanted = {"shape": (ny, nx), "chunks": tile_shape(self.cells, nx), "dimension_names": ("y", "x")}
        for name, values in axes.items():
            self._array(name, data=values, dimension_names=(name,))
        self._arrays = {
            name: self._array(name, dtype=dtype, fill_value=fill, **wanted) for name, (dtype, fill) in columns.items()
        }

    def _created(self, made: dict[str, Any], overwrite: bool) -> Any:
        """Return the group, new, or as another process has just made it."""
        try:
            return self._tried(
                lambda: self._zarr.create_group(self._store, overwrite=overwrite, attributes={"vibroimpact": made})
            )
        except self._zarr.errors.ContainsGroupError:
            group = _opened(self._zarr, self._store)
            self._is_other(dict(group.attrs), made, False)
            return group

    def _is_other(self, attributes: dict[str, Any], made: dict[str, Any], overwrite: bool) -> bool:
        """Whether another call made a store: refused unless it may be replaced, as is a group that is no store."""
        found = attributes.get("vibroimpact")
        if not isinstance(found, dict):
            message = f"store is {self._name}, but it is a group of zarr with something else in it"
            raise ValueError(message)
        differs = _difference(found, made)
        if differs is not None and not overwrite:
            message = f"store is {self._name}, but {differs}: overwrite=True replaces it"
            raise ValueError(message)
        return differs is not None

    def _take_over(self, group: Any, made: dict[str, Any], arguments: dict[str, Any]) -> None:
        """Go on with a store that knows functions by their own code, where that is the same; it knows the rest from now on."""
        found = group.attrs.get("vibroimpact")
        if not isinstance(found, dict) or found.get("hash") == made["hash"] or not _knows_own_code(found):
            return
        encoders = {name: _OwnCode() for name in arguments}
        try:
            own = _made(made["type"], {name: _told(name, value, encoders[name]) for name, value in arguments.items()})
        except ValueError:
            return
        if any(encoder.is_blind for encoder in encoders.values()) or _difference(found, own) is not None:
            return
        self._tried(lambda: group.update_attributes({"vibroimpact": made}))
        warnings.warn(
            f"store {self._name} was made by a version that told functions by their own code alone, which is the same: it goes "
            "on, and from now on what they read and call is told too; whether that has changed since cannot be said",
            stacklevel=5,
        )

    def _array(self, name: str, **options: Any) -> Any:
        """Return an array of the group, made if it is not there."""
        if name not in self._group:
            try:
                return self._tried(lambda: self._group.create_array(name, **options))
            except self._zarr.errors.ContainsArrayError:  # another process was faster
                pass
        return self._group[name]

    def _tried(self, write: Any) -> Any:
        """Write; an error of the system names the store."""
        try:
            return write()
        except OSError as error:
            reason = error.strerror or str(error)
            raise OSError(error.errno, f"store {self._name}: {reason}; what it had before is kept") from error

    def kept(self, name: str) -> Any:
        """Return what was kept beside the arrays, None if nothing was."""
        found = self._group.attrs.get(name)
        return None if found is None else untold(found)

    def keep(self, name: str, value: Any) -> None:
        """Keep a value beside the arrays."""
        self._tried(lambda: self._group.update_attributes({name: _told(name, value)}))

    def read(self) -> dict[str, NDArray[Any]]:
        """Return the arrays as they are now."""
        return {name: np.asarray(array[:]) for name, array in self._arrays.items()}

    def lacks(self, arrays: dict[str, NDArray[Any]], chunk: Tile) -> bool:
        """Whether cells of a chunk have not been found, by the last array."""
        last = list(arrays)[-1]
        return bool((arrays[last][chunk] == self._arrays[last].fill_value).any())

    def write(self, arrays: dict[str, NDArray[Any]], chunk: Tile) -> None:
        """Write a chunk, the last array last."""

        def written() -> None:
            if _opened(self._zarr, self._store) is None:
                raise FileNotFoundError(2, "it is not there any more")
            for name, array in self._arrays.items():
                array[chunk] = arrays[name][chunk]

        self._tried(written)


def _difference(found: dict[str, Any], made: dict[str, Any]) -> str | None:
    """Return the first thing in which a store differs from what a call makes, in words."""
    for name in ("format", "version", "type"):
        if found.get(name) != made[name]:
            return f"its {name} is {found.get(name)!r}, not {made[name]!r}"
    if found.get("hash") == made["hash"]:
        return None
    own, theirs = made["arguments"], found.get("arguments", {})
    first = next((name for name in {**own, **theirs} if theirs.get(name) != own.get(name)), "hash")
    if _knows_own_code(found) and '"parts"' in json.dumps(own.get(first)):
        return f"a version made it that did not look through all code: that of {first} is another, or it did not see it"
    functions = [list(_functions(one.get(first))) for one in (own, theirs)]
    for mine, other in zip(*functions, strict=False):
        changed = sorted(name for name in {**mine, **other} if mine.get(name) != other.get(name))
        if changed:
            # What leads to others changes where these are not the same ones.
            return f"it was made with another {first}: {', '.join(changed[:4])}{' ...' if changed[4:] else ''} changed"
    return f"it was made with another {first}"


def _made(kind: str, told: dict[str, Any]) -> dict[str, Any]:
    """Return what a store keeps of the call that makes it."""
    digest = hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()
    return {"format": FORMAT, "version": _core.__version__, "type": kind, "arguments": told, "hash": digest}


def _functions(told: Any) -> Iterator[dict[str, str]]:
    """Iterate over the parts of all callables in what was told."""
    if isinstance(told, dict):
        if isinstance(told.get("parts"), dict):
            yield told["parts"]
        else:
            told = list(told.values())
    if isinstance(told, list):
        for one in told:
            yield from _functions(one)


def _knows_own_code(found: dict[str, Any]) -> bool:
    """Whether a store tells callables as up to version 0.2.0."""
    text = json.dumps(found.get("arguments"))
    return '"function"' in text and '"parts"' not in text


def contents(path: str | os.PathLike[str]) -> tuple[str, dict[str, Any], dict[str, NDArray[Any]]]:
    """Return the type of a store, its attributes and its arrays, those of its axes too.

    Raises
    ------
    ValueError
        A folder that is no store, or one of a newer format.
    """
    zarr = _zarr()
    try:
        group = zarr.open_group(path, mode="r")
    except FileNotFoundError:
        group = None
    attributes = {} if group is None else dict(group.attrs)
    made = attributes.get("vibroimpact")
    if group is None or not isinstance(made, dict) or not isinstance(made.get("format"), int):
        message = f"path is {_shown(path)}, but it is no result of vibroimpact"
        raise ValueError(message)
    if made["format"] > FORMAT:
        newer = f"its format {made['format']} is newer than {FORMAT}, the newest that this version reads"
        message = f"path is {_shown(path)}, but {newer}"
        raise ValueError(message)
    if made["type"] == "Basins" and '"function"' in json.dumps(made["arguments"]["scene"]["value"]):
        reason = "its scene is made of functions, which it does not hold: the same call of basins opens it"
        message = f"path is {_shown(path)}, but {reason}"
        raise ValueError(message)
    arrays = {name: np.asarray(array[:]) for name, array in group.arrays()}
    return str(made["type"]), attributes | {"arguments": made["arguments"]}, arrays


def _zarr() -> Any:
    try:
        import zarr
    except ImportError as error:
        raise ImportError('a store needs zarr: pip install "vibroimpact[store]"') from error
    return zarr


def _shown(store: Any) -> str:
    return repr(os.fspath(store)) if isinstance(store, (str, os.PathLike)) else repr(store)


def _opened(zarr: Any, store: Any) -> Any:
    """Return the group of a store, None where there is nothing yet."""
    if isinstance(store, (bool, int, float, bytes)):
        message = f"store is {store!r}, but a folder, or a store of zarr, is needed"
        raise TypeError(message)
    path = Path(store) if isinstance(store, (str, os.PathLike)) and "://" not in os.fspath(store) else None
    if path is not None and path.exists() and not path.is_dir():
        message = f"store is {_shown(store)}, but that is a file: a folder is needed"
        raise ValueError(message)
    try:
        return zarr.open_group(store, mode="r+")
    except FileNotFoundError:
        pass
    if path is not None and path.is_dir() and any(not entry.name.endswith(".partial") for entry in path.iterdir()):
        message = f"store is {_shown(store)}, but that folder has something else in it"
        raise ValueError(message)
    return None


class _Arguments(_json.Encoder):
    """Arguments that need not be made again: functions by what tells them apart."""

    def __init__(self, key: str | None = None) -> None:
        super().__init__({})
        self._key = key

    def encoded(self, value: Any, where: str) -> Any:
        # A list that can be called is more than its items.
        return self.other(value, where) if callable(value) and not self._is_ours(value) else super().encoded(value, where)

    def known(self, value: Any, where: str) -> Any:
        try:
            return self.by_arguments(value, where)
        except TypeError as error:
            message = f"{where}: {type(value).__name__} cannot be told from others: {error}"
            raise ValueError(message) from None

    def other(self, value: Any, where: str) -> Any:
        if isinstance(value, np.generic):
            return self.encoded(value.item(), where)
        return self.function(value, where)

    def function(self, value: Any, where: str) -> Any:
        """Return a callable, or what stands for one, as JSON has it."""
        try:
            return {"function": {"name": _fingerprint.named(value), "parts": _fingerprint.parts(value, self._key)}}
        except ValueError as error:
            message = f"{where}: {error}"
            raise ValueError(message) from None


class _OwnCode(_Arguments):
    """Arguments as they were told up to version 0.2.0, functions by their own code."""

    is_blind = False

    def function(self, value: Any, where: str) -> Any:
        self.is_blind |= not _own_code.was_told(value)
        return {"function": _own_code.fingerprint(value)}


def _told(name: str, value: Any, encoder: _Arguments | None = None) -> dict[str, Any]:
    """Return a value as JSON has it, its arrays as text."""
    encoder = encoder or _Arguments()
    told = encoder.encoded(value, name)
    arrays = {
        key: [array.dtype.str, list(array.shape), base64.b64encode(np.ascontiguousarray(array).tobytes()).decode()]
        for key, array in encoder.arrays.items()
    }
    return {"value": told, "arrays": arrays}


def untold(told: dict[str, Any]) -> Any:
    """Return what was told, KeyError where it had functions."""
    arrays = {}
    for key, (dtype, shape, text) in told["arrays"].items():
        arrays[key] = np.frombuffer(base64.b64decode(text), dtype).reshape(shape).copy()
    return _json.decoded(told["value"], arrays, {})
